//! The equilibria in a box, and their branches over a parameter, as SVG.

use super::equilibria::{bifurcates, equilibria_count};
use super::picture::{Axis, Cell, Curve, Panel, Picture, Sample, Stroke, titled};
use super::{shown_unit, with_unit};
use librate_core::model::Model;
use librate_core::modes::Stability;
use librate_core::order::{Gather, Order};
use librate_core::precision::Ball;
use librate_studies::equilibria::{Branch, Diagram, Equilibrium, Found, Landscape};
use librate_studies::period::{Course, portrait};

/// So many coordinates are drawn over a parameter, one panel each.
const MOST_PANELS: usize = 6;
/// Equilibria have to be seen on what is dark.
const DARKEST: f64 = 0.5;
/// Stability is told by more than colour.
const KINDS: [(Stability, &str, usize, Stroke); 4] = [
    (Stability::Stable, "stable", 0, Stroke::Dots),
    (Stability::Unstable, "unstable", 1, Stroke::Rings),
    (Stability::Neutral, "neutral", 2, Stroke::Rings),
    (Stability::Undecided, "undecided", 7, Stroke::Rings),
];

/// Kinds of motion by colour and stroke.
const COURSES: [(Course, &str, usize, Stroke); 3] = [
    (Course::Bound, "to and fro", 0, Stroke::Thin),
    (Course::Leaving, "leaves the box", 2, Stroke::Thin),
    (Course::Separatrix, "separatrix", 1, Stroke::Solid),
];

/// The equilibria of one coordinate on the curve of the potential, with the phase portrait below where energy is conserved; of more in the plane of the first two that have a range, darker where the
/// potential is higher if these are all.
#[must_use]
pub fn equilibria_svg(model: &Model, found: &Found, landscape: &Landscape) -> String {
    let title = titled("Equilibria", model.name.as_deref());
    let [first, second] = {
        let mut all = landscape.coordinates();
        [all.next(), all.next()]
    };
    let Some(first) = first else { return Picture::single(title, String::new(), nothing()).svg() };
    let dots = |height: &dyn Fn(&[f64]) -> f64| -> Vec<Curve> {
        let kinds = KINDS.into_iter().map(|(kind, name, colour, stroke)| {
            let own = found.equilibria.iter().filter(|own| own.stability == kind);
            let place = |own: &Equilibrium| {
                let point: Vec<f64> = own.point.iter().map(Ball::mid_f64).collect();
                [point[first], height(&point)]
            };
            Curve { name: name.to_owned(), colour, stroke, points: own.map(place).collect() }
        });
        kinds.filter(|curve| !curve.points.is_empty()).collect()
    };
    let axis = |at: usize| {
        let own = model.coordinates.get(at);
        let label = own.map_or_else(String::new, |own| with_unit(&own.name(), shown_unit(own)));
        let side = found.region.sides.get(at).and_then(Option::as_ref);
        Axis::over(label, side.into_iter().flatten().map(Ball::mid_f64), 0.0)
    };
    let Some(second) = second else {
        let curve = landscape.curve();
        let mut curves = dots(&|point| landscape.height(point));
        let marked = curves.iter().flat_map(|own| &own.points).map(|point| point[1]);
        // Poles leave the picture.
        let mut heights: Vec<f64> = curve.iter().map(|own| own[1]).filter(|own| own.is_finite()).collect();
        heights.order_by(f64::total_cmp);
        let shares = [1, 19].map(|share| heights.get(heights.len() * share / 20).copied().unwrap_or(0.0));
        let name = if model.has_units { "potential (J)" } else { "potential" };
        let up = Axis::over(name, marked.chain(shares), 0.15);
        curves.insert(0, Curve { name: "potential".to_owned(), colour: 7, stroke: Stroke::Solid, points: curve });
        let orbits = portrait(model, found);
        let count = equilibria_count(found.equilibria.len());
        let mut picture = Picture::single(
            title,
            format!("{count} on the curve of the potential."),
            Panel::new(axis(first), up, curves),
        );
        if let Some(own) = model.coordinates.get(first).filter(|_| !orbits.is_empty()) {
            picture.description = format!("{count} on the curve of the potential, above curves of constant energy.");
            picture.size = [600.0, 240.0];
            let unit = shown_unit(own).map(|unit| format!("{unit}/s"));
            let label = with_unit(&format!("{}'", own.name()), unit.as_deref());
            let all = orbits.iter().flat_map(|own| &own.points).map(|point| point[1]);
            let mut curves: Vec<Curve> = Vec::new();
            for (course, name, colour, stroke) in COURSES {
                let own = orbits.iter().filter(|own| own.course == course);
                let points = own.map(|own| own.points.clone());
                curves.extend(points.map(|points| Curve { name: name.to_owned(), colour, stroke, points }));
            }
            curves.extend(dots(&|_| 0.0));
            picture.panels.push(Panel::new(axis(first), Axis::over(label, all, 0.05), curves));
        }
        return picture.svg();
    };
    let mut panel = Panel::new(axis(first), axis(second), dots(&|point| point[second]));
    let (heights, half) = landscape.plane();
    panel.cells = cells(&heights, half);
    let description = format!("{} in the plane of two coordinates.", equilibria_count(found.equilibria.len()));
    let mut picture = Picture::single(title, description, panel);
    if !heights.is_empty() {
        picture.legend.push((Sample::Cell(Some(DARKEST)), "high potential".to_owned()));
    }
    picture.svg()
}

fn nothing() -> Panel {
    Panel::new(Axis::blank(0.0, 1.0), Axis::blank(0.0, 1.0), Vec::new())
}

/// Shades by the order of heights, so that poles do not take all of them; steps are lines of equal height.
fn cells(heights: &[([f64; 2], f64)], half: [f64; 2]) -> Vec<Cell> {
    const SHADES: f64 = 12.0;
    let mut sorted: Vec<f64> = heights.iter().map(|(_, own)| *own).filter(|own| own.is_finite()).collect();
    sorted.order_by(f64::total_cmp);
    let share = |value: f64| sorted.partition_point(|own| *own < value) as f64 / sorted.len().max(1) as f64;
    let mut all: Vec<Cell> = Vec::new();
    for (at, value) in heights {
        let [low, high] = [[at[0] - half[0], at[1] - half[1]], [at[0] + half[0], at[1] + half[1]]];
        let shade = value.is_finite().then(|| DARKEST * (SHADES * share(*value)).floor() / SHADES);
        match all.last_mut() {
            // Neighbours of one shade are one rectangle.
            Some(last) if last.shade == shade && last.corners[0][1] == low[1] => last.corners[1][0] = high[0],
            _ => all.push(Cell { corners: [low, high], shade }),
        }
    }
    all
}

/// The branches of equilibria over a parameter as an SVG picture, a panel for each of the first six coordinates; solid where stable.
#[must_use]
pub fn diagram_svg(model: &Model, diagram: &Diagram) -> String {
    let panels = model.coordinates.iter().take(MOST_PANELS).enumerate().map(|(at, coordinate)| {
        let mut curves: Vec<Curve> = diagram.branches.iter().flat_map(|own| pieces(own, diagram, at)).collect();
        let points = diagram.bifurcations.iter().map(|own| [own.value.mid_f64(), own.point[at].mid_f64()]);
        let kinds = diagram.bifurcations.iter().map(|own| own.kind.as_str()).distinct();
        for (colour, kind) in kinds.into_iter().enumerate() {
            let own = diagram.bifurcations.iter().zip(points.clone()).filter(|(own, _)| own.kind.as_str() == kind);
            let points = own.map(|(_, point)| point).collect();
            curves.push(Curve { name: kind.to_owned(), colour: colour + 2, stroke: Stroke::Dots, points });
        }
        let values = |part: usize| curves.iter().flat_map(|own| &own.points).map(move |point| point[part]);
        let across = Axis::over(with_unit(&diagram.name, diagram.unit.as_deref()), diagram.values.iter().copied(), 0.0);
        let up = Axis::over(with_unit(&coordinate.name(), shown_unit(coordinate)), values(1), 0.05);
        Panel::new(across, up, curves)
    });
    let panels: Vec<Panel> = panels.collect();
    let size = if panels.len() > 1 { [600.0, 230.0] } else { [600.0, 360.0] };
    let description = format!(
        "{} branches of equilibria over {}, with {} bifurcations; dashed where unstable.",
        diagram.branches.len(),
        diagram.name,
        diagram.bifurcations.len()
    );
    Picture::column(titled("Equilibria", model.name.as_deref()), description, size, panels).svg()
}

/// A branch in pieces of one stability; what lies between two values has that of the nearer one which is on the same side of
/// bifurcations.
fn pieces(branch: &Branch, diagram: &Diagram, coordinate: usize) -> Vec<Curve> {
    let mut pieces: Vec<Curve> = Vec::new();
    let known: Vec<(f64, Stability)> =
        branch.at.iter().map(|(place, own)| (diagram.values[*place], own.stability)).collect();
    let beside = |(value, own): &&(f64, Stability)| *own != Stability::Neutral || !bifurcates(diagram, *value);
    let turning: Vec<f64> = diagram.bifurcations.iter().map(|own| own.value.mid_f64()).collect();
    let parted = |a: f64, b: f64| turning.iter().any(|own| (own - a) * (own - b) < 0.0);
    let mut before: Option<Stability> = None;
    for (value, point) in &branch.way {
        let same_side = known.iter().filter(beside).filter(|(own, _)| !parted(*own, *value));
        let nearest = same_side.min_by(|(a, _), (b, _)| (a - value).abs().total_cmp(&(b - value).abs()));
        let stability = nearest.map_or(before.unwrap_or(Stability::Undecided), |(_, own)| *own);
        let point = [*value, point[coordinate]];
        if before != Some(stability) {
            let last = pieces.last().and_then(|own: &Curve| own.points.last().copied());
            let (name, colour, stroke) = match stability {
                Stability::Stable => ("stable", 0, Stroke::Solid),
                Stability::Unstable => ("unstable", 1, Stroke::Dashed),
                Stability::Neutral => ("neutral", 6, Stroke::Thin),
                Stability::Undecided => ("undecided", 7, Stroke::Thin),
            };
            pieces.push(Curve { name: name.to_owned(), colour, stroke, points: last.into_iter().collect() });
            before = Some(stability);
        }
        if let Some(piece) = pieces.last_mut() {
            piece.points.push(point);
        }
    }
    pieces
}
