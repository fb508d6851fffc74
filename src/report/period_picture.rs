//! The curve of a period, as SVG.

use plotters::prelude::*;

use super::picture::{self, Drawing};
use librate_core::model::Range;
use librate_studies::period::{Motion, Place};

const LINE: RGBColor = RGBColor(31, 119, 180);
const SIZE: (u32, u32) = (640, 400);

/// The period over the amplitude or the energy, as an SVG picture; broken where there is no periodic motion and where
/// librations end and rotations begin.
#[must_use]
pub fn period_svg(range: &Range, places: &[Place], has_units: bool) -> String {
    let mut pieces: Vec<Vec<(f64, f64)>> = vec![Vec::new()];
    let mut before = None;
    for place in places {
        let kind = place.result.as_ref().ok().map(|found| matches!(found.motion, Motion::Rotation { .. }));
        if kind != before {
            pieces.push(Vec::new());
            before = kind;
        }
        if let (Ok(found), Some(piece)) = (&place.result, pieces.last_mut()) {
            piece.push((place.value, found.period.mid_f64()));
        }
    }
    picture::svg(SIZE, |area| draw(area, range, &pieces, has_units))
}

fn draw(
    area: &Drawing<'_>,
    range: &Range,
    pieces: &[Vec<(f64, f64)>],
    has_units: bool,
) -> Result<(), Box<dyn std::error::Error>> {
    let points = || pieces.iter().flatten();
    let ends = |value: fn(&(f64, f64)) -> f64| {
        let values = points().map(value);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        // A single place, or none, has an axis as well.
        if high > low {
            (low, high)
        } else if low.is_finite() {
            let room = low.abs().max(1e-300) * 0.5;
            (low - room, high + room)
        } else {
            (0.0, 1.0)
        }
    };
    let (left, right) = ends(|point| point.0);
    let (low, high) = ends(|point| point.1);
    let room = 0.05 * (high - low);
    let period = if has_units { "period in s" } else { "period" };
    let mut chart = picture::axes(area, left..right, (low - room)..(high + room), (range.name(), Some(period)))?;
    for piece in pieces {
        if let [only] = piece.as_slice() {
            chart.draw_series(std::iter::once(Circle::new(*only, 2, LINE.filled())))?;
        } else {
            chart.draw_series(LineSeries::new(piece.iter().copied(), LINE.stroke_width(2)))?;
        }
    }
    Ok(())
}
