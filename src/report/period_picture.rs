//! The curve of a period, as SVG.

use super::picture::{Axis, Curve, Panel, Picture, Stroke, titled};
use super::{shown_unit, with_unit};
use librate_core::model::{Model, Range};
use librate_core::precision::Ball;
use librate_studies::period::{Motion, Place, hills};

/// The period over the amplitude or the energy, as an SVG picture; broken where there is no periodic motion, at a separatrix, and where librations
/// end and rotations begin.
#[must_use]
pub fn period_svg(model: &Model, range: &Range, places: &[Place]) -> String {
    let mut curves: Vec<Curve> = Vec::new();
    let mut before = None;
    for place in places {
        let Ok(found) = &place.result else {
            before = None;
            continue;
        };
        let (hills, across) = match &found.motion {
            // In SI, like the axis.
            Motion::Libration { turning } => {
                let amplitude = (turning[1] - found.equilibrium).mid_f64();
                (Some(hills(model, turning.each_ref().map(Ball::mid_f64))), amplitude)
            }
            Motion::Rotation { .. } => (None, place.value),
        };
        if before != Some(hills) {
            let (name, colour) = if hills.is_none() { ("rotation", 1) } else { ("libration", 0) };
            curves.push(Curve { name: name.to_owned(), colour, stroke: Stroke::Solid, points: Vec::new() });
        }
        before = Some(hills);
        if let Some(curve) = curves.last_mut() {
            let across = if range.name() == "amplitude" { across } else { place.value };
            curve.points.push([across, found.period.mid_f64()]);
        }
    }
    if curves.iter().all(|curve| curve.colour == 0) {
        curves.iter_mut().for_each(|curve| curve.name.clear());
    }
    let values = |at: usize| curves.iter().flat_map(|curve| &curve.points).map(move |point| point[at]);
    let up = Axis::over(if model.has_units { "period (s)" } else { "period" }, values(1), 0.05);
    let unit = match range.name() {
        "amplitude" => model.coordinates.iter().next().and_then(shown_unit),
        _ => Some("J").filter(|_| model.has_units),
    };
    let across = Axis::over(with_unit(range.name(), unit), values(0), 0.0);
    let description = format!(
        "The period over the {}; the curve ends where no motion is periodic, and at a separatrix.",
        range.name()
    );
    Picture::single(titled("Period", model.name.as_deref()), description, Panel::new(across, up, curves)).svg()
}
