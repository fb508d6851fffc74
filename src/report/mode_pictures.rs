//! Mode shapes and sweeps as pictures.

use super::picture::{Axis, Curve, Panel, Picture, Stroke, titled};
use super::{Written, with_unit};
use librate_core::linearize::Linearized;
use librate_core::modes::Kind;
use librate_core::oscillation::{NormalMode, NormalModes};
use librate_core::precision::Ball;
use librate_studies::sweep::Sweep;
use librate_studies::tracking::{Branch, Shape, Tracked};

/// More shapes than this are no picture.
const MOST_PANELS: usize = 60;
/// Stems of more coordinates would touch each other.
const MOST_STEMS: usize = 48;
/// Frequencies of more branches can't be told apart.
const MOST_NAMED: usize = 16;

/// `omega = 3.132 rad/s, even`
pub(super) fn caption(mode: &NormalMode, number: usize, has_units: bool) -> String {
    let [rate, exponent] = if has_units { [" rad/s", " 1/s"] } else { ["", ""] };
    let short = |value| Written::new(value, 5).text();
    let mut text = match mode.kind {
        Kind::Zero => format!("{number}: zero mode"),
        Kind::Oscillation => format!("{number}: ω = {}{rate}", short(&mode.omega)),
        Kind::Damped | Kind::Undecided => {
            format!("{number}: ω = {}{rate}, growth {}{exponent}", short(&mode.omega), short(&mode.growth))
        }
        Kind::Overdamped => format!("{number}: overdamped, {}{exponent}", short(&mode.growth)),
        Kind::Unstable => format!("{number}: unstable, growth {}{exponent}", short(&mode.growth)),
    };
    if let Some(class) = &mode.symmetry {
        text.push_str(&format!(", {class}"));
    }
    text
}

/// The shapes of the modes as an SVG picture, a panel each: how far each coordinate goes, and for shapes whose coordinates
/// do not move in phase how far a quarter of a period later.
#[must_use]
pub fn modes_svg(linearized: &Linearized, modes: &NormalModes) -> String {
    let model = linearized.model();
    let names: Vec<String> = model.coordinates.names().collect();
    let shown = modes.modes.len().min(MOST_PANELS);
    let panels = modes.modes.iter().zip(1..).take(shown).map(|(mode, number)| {
        let largest = mode.vector.iter().chain(&mode.imaginary).fold(0.0_f64, |most, part| most.max(part.abs()));
        let size = if largest > 0.0 { largest } else { 1.0 };
        let curve = |name: &str, colour, stroke, values: &[f64], aside: f64| {
            let points = values.iter().zip(1..).map(|(part, at)| [f64::from(at) + aside, part / size]);
            Curve { name: name.to_owned(), colour, stroke, points: points.collect() }
        };
        let is_complex = !mode.imaginary.is_empty();
        let aside = if is_complex { 0.12 } else { 0.0 };
        let first = if is_complex { "at the start" } else { "" };
        let mut curves = Vec::new();
        if names.len() <= MOST_STEMS {
            curves.push(curve("", 0, Stroke::Stems, &mode.vector, -aside));
            curves.push(curve(first, 0, Stroke::Dots, &mode.vector, -aside));
        } else {
            curves.push(curve(first, 0, Stroke::Solid, &mode.vector, 0.0));
        }
        if is_complex {
            // Re((u + iv) e^(iωt)) is -v after a quarter of a period; where there is none, both parts are free motions.
            let (told, sign) = match mode.kind {
                Kind::Zero | Kind::Overdamped => ("the imaginary part", 1.0),
                _ if mode.growth.is_zero() => ("a quarter of a period later", -1.0),
                _ => ("a quarter of a period later, but for the growth", -1.0),
            };
            let later: Vec<f64> = mode.imaginary.iter().map(|part| sign * part).collect();
            let stroke = if names.len() <= MOST_STEMS { Stroke::Stems } else { Stroke::Dashed };
            curves.push(curve("", 1, stroke, &later, aside));
            curves.push(curve(told, 1, Stroke::Rings, &later, aside));
        }
        let across = Axis::names("", names.clone());
        Panel::new(across, Axis::blank(-1.15, 1.15), curves).titled(caption(mode, number, model.has_units))
    });
    let left_out = match modes.modes.len() {
        all if all > shown => format!(" The first {shown} of {all} modes."),
        _ => String::new(),
    };
    let panels: Vec<Panel> = panels.collect();
    let title = titled("Normal modes", model.name.as_deref());
    let description = format!("The shape of each mode, with 1 for the largest component.{left_out}");
    let (columns, size) = if names.len() > 12 { (2, [400.0, 110.0]) } else { (3, [240.0, 110.0]) };
    Picture { columns, ..Picture::column(title, description, size, panels) }.svg()
}

/// The frequency of each mode as an SVG picture, growth in a panel below where there is some: over the wave number where all modes have
/// one (the dispersion of a ring), else mode by mode.
#[must_use]
pub fn spectrum_svg(linearized: &Linearized, modes: &NormalModes) -> String {
    let model = linearized.model();
    let wave = |mode: &NormalMode| mode.symmetry.as_deref()?.strip_prefix("wave number ")?.parse().ok();
    let waves: Option<Vec<f64>> = modes.modes.iter().map(wave).collect();
    let (what, label) = if waves.is_some() { ("Dispersion", "wave number") } else { ("Spectrum", "mode") };
    let places = waves.unwrap_or_else(|| (1..=modes.modes.len()).map(|number| number as f64).collect());
    let panel = |label: &str, up: &str, colour, value: &dyn Fn(&NormalMode) -> f64| {
        let points: Vec<[f64; 2]> = places.iter().zip(&modes.modes).map(|(at, mode)| [*at, value(mode)]).collect();
        let axis = |label: &str, at: usize| Axis::over(label, points.iter().map(|point| point[at]).chain([0.0]), 0.04);
        let (across, up) = (axis(label, 0).whole(), axis(up, 1));
        let curve = |stroke| Curve { name: String::new(), colour, stroke, points: points.clone() };
        let own = [Stroke::Stems, Stroke::Dots].map(curve);
        // Stems of many modes, or of many of one wave number, would only hide each other.
        let shown = own.into_iter().skip(usize::from(what == "Dispersion" || points.len() > MOST_STEMS));
        Panel::new(across, up, shown.collect())
    };
    let [rate, exponent] = axis_labels(model.has_units);
    let grows = modes.modes.iter().any(|mode| mode.growth.mid_f64() != 0.0);
    let omega = panel(label, rate, 0, &|mode| mode.omega.mid_f64());
    let growth = grows.then(|| panel(label, exponent, 1, &|mode| mode.growth.mid_f64()));
    let description = format!("The frequency of each of {} modes by its {label}.", modes.modes.len());
    with_growth(titled(what, model.name.as_deref()), description, omega, growth)
}

/// Frequencies, with growth in a panel below where there is some.
fn with_growth(title: String, description: String, omega: Panel, growth: Option<Panel>) -> String {
    let size = if growth.is_some() { [600.0, 260.0] } else { [600.0, 380.0] };
    Picture::column(title, description, size, [omega].into_iter().chain(growth).collect()).svg()
}

/// What frequencies and growth are called.
pub(super) fn axis_labels(has_units: bool) -> [&'static str; 2] {
    if has_units { ["ω (rad/s)", "growth (1/s)"] } else { ["ω", "growth"] }
}

/// How a sweep is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SweepView {
    /// Lines ω = k Ω for a parameter Ω that is a rate of rotation: a Campbell diagram.
    pub orders: Vec<f64>,
    /// The exponents in the plane of growth and frequency instead, from rings at the first value on.
    pub locus: bool,
}

impl SweepView {
    /// With a line for each of some orders, or as a root locus.
    #[must_use]
    pub fn new(orders: Vec<f64>, locus: bool) -> Self {
        Self { orders, locus }
    }
}

/// Frequencies over a parameter as an SVG picture, each mode followed by its shape; growth dashed, in a panel below where there is some.
#[must_use]
pub fn sweep_svg(sweep: &Sweep, places: &[Tracked], branches: &[Branch], view: &SweepView) -> String {
    let name = sweep.range().name();
    let model = (0..sweep.range().len()).find_map(|place| sweep.model(place).ok());
    let [rate, exponent] = axis_labels(model.as_ref().is_some_and(|model| model.has_units));
    let pick = |(place, at): &(usize, usize), point: &dyn Fn(f64, &Shape) -> [f64; 2]| {
        let place = places.get(*place)?;
        Some(point(place.value, place.shapes().get(*at)?))
    };
    let curves = |stroke, point: &dyn Fn(f64, &Shape) -> [f64; 2]| -> Vec<Curve> {
        let one = |(number, branch): (usize, &Branch)| {
            let class = branch.class.as_ref().map_or_else(String::new, |class| format!(", {class}"));
            let name = if branches.len() <= MOST_NAMED { format!("mode {}{class}", number + 1) } else { String::new() };
            let points = branch.at.iter().filter_map(|at| pick(at, point)).collect();
            Curve { name, colour: number, stroke, points }
        };
        branches.iter().enumerate().map(one).collect()
    };
    let axis = |label: &str, curves: &[Curve], at: usize| {
        Axis::over(label, curves.iter().flat_map(|own| &own.points).map(|point| point[at]), 0.04)
    };
    let model_name = model.as_ref().and_then(|model| model.name.as_deref());
    if view.locus {
        let mut curves = curves(Stroke::Solid, &|_, mode| [mode.growth.mid_f64(), mode.omega.mid_f64()]);
        let starts = curves.iter().filter_map(|own| {
            let points = own.points.first().map(|point| vec![*point])?;
            Some(Curve { name: String::new(), colour: own.colour, stroke: Stroke::Rings, points })
        });
        let starts: Vec<Curve> = starts.collect();
        curves.extend(starts);
        let description = format!("Growth and frequency of each mode over {name}, from rings at its first value on.");
        let panel = Panel::new(axis(exponent, &curves, 0), axis(rate, &curves, 1), curves);
        return Picture::single(titled("Root locus", model_name), description, panel).svg();
    }
    let label = with_unit(name, sweep.unit().as_deref());
    let values = || places.iter().map(|place| place.value);
    let across = || Axis::over(&label, values(), 0.0);
    let mut omega = curves(Stroke::Solid, &|value, mode| [value, mode.omega.mid_f64()]);
    let growth = curves(Stroke::Dashed, &|value, mode| [value, mode.growth.mid_f64()]);
    let grows = growth.iter().flat_map(|own| &own.points).any(|point| point[1] != 0.0);
    let up = axis(rate, &omega, 1);
    let unit = unit(sweep);
    for (order, colour) in view.orders.iter().zip(branches.len()..) {
        let points = values().map(|value| [value, order * unit * value]).collect();
        omega.push(Curve { name: format!("order {order}"), colour, stroke: Stroke::Thin, points });
    }
    let points = crossings(sweep, places, branches);
    let crossed = !points.is_empty();
    if crossed {
        let colour = branches.len() + view.orders.len();
        omega.push(Curve { name: "crossing".to_owned(), colour, stroke: Stroke::Rings, points });
    }
    let growth = grows.then(|| Panel::new(across(), axis(exponent, &growth, 1), growth));
    let what = if view.orders.is_empty() { "Frequencies" } else { "Campbell diagram" };
    let rings = if crossed {
        " Rings are where modes of different symmetry, or of coordinates without a coupling, cross: bounds on both sides prove their \
         order."
    } else {
        ""
    };
    let description = format!("The frequencies over {name}; each mode is followed by its shape.{rings}");
    with_growth(titled(what, model_name), description, Panel::new(across(), up, omega), growth)
}

/// Where frequencies of different symmetry classes change places, as their bounds at two values within a part of a pixel prove. Others that
/// come near to each other may avoid it; at a pole, where a frequency ends, they do not cross.
fn crossings(sweep: &Sweep, places: &[Tracked], branches: &[Branch]) -> Vec<[f64; 2]> {
    let closest = match places {
        [first, .., last] => (last.value - first.value).abs() / 1000.0,
        [] | [_] => return Vec::new(),
    };
    let mut found = Vec::new();
    for (number, own) in branches.iter().enumerate() {
        let others = branches[number + 1..].iter().filter(|other| other.class.is_some() && other.class != own.class);
        for other in others.filter(|_| own.class.is_some()) {
            let beside = own.at.iter().filter_map(|(place, at)| {
                let there = other.at.binary_search_by_key(place, |own| own.0).ok()?;
                let (place, pair) = (places.get(*place)?, [*at, other.at[there].1]);
                // Where there is more symmetry than elsewhere nothing is told.
                let class = |at: usize| place.shapes().get(at).map(|own| &own.class);
                let is_class = |(at, branch): (usize, &Branch)| class(at) == Some(&branch.class);
                if !pair.into_iter().zip([own, other]).all(is_class) {
                    return None;
                }
                Some((pair.map(|at| rank(place.shapes(), at)), Apart::new(place, pair)?))
            });
            // At a value where they are equal nothing is decided.
            let beside: Vec<_> = beside.filter(|(_, own)| !own.by.contains_zero()).collect();
            for window in beside.windows(2) {
                let [(ranks, mut before), (_, mut after)] = [window[0], window[1]];
                while before.crosses(&after)
                    && (after.value - before.value).abs() > closest
                    && let Some(middle) = Apart::between(sweep, &before, &after, ranks, [own, other])
                {
                    if before.crosses(&middle) { after = middle } else { before = middle }
                }
                if before.crosses(&after) && (after.value - before.value).abs() <= closest {
                    let share = before.by.mid_f64() / (before.by.mid_f64() - after.by.mid_f64());
                    let at = |[from, to]: [f64; 2]| from + share * (to - from);
                    found.push([at([before.value, after.value]), at([before.omega, after.omega])]);
                }
            }
        }
    }
    found
}

/// How often the class of a mode occurs before it: modes of a class keep their order.
fn rank(modes: &[Shape], at: usize) -> usize {
    modes[..at].iter().filter(|own| own.class == modes[at].class).count()
}

/// Two frequencies at a value of the parameter.
#[derive(Clone, Copy)]
struct Apart {
    value: f64,
    /// The first of them.
    omega: f64,
    /// By how much it is larger than the other.
    by: Ball,
}

impl Apart {
    fn new(place: &Tracked, [one, two]: [usize; 2]) -> Option<Self> {
        let (one, two) = (place.shapes().get(one)?, place.shapes().get(two)?);
        let both = [one, two].iter().all(|own| own.omega.is_positive());
        both.then(|| Self { value: place.value, omega: one.omega.mid_f64(), by: one.omega - two.omega })
    }

    /// In the middle of an interval, where the modes have these ranks in the classes of their branches.
    fn between(sweep: &Sweep, from: &Self, to: &Self, ranks: [usize; 2], branches: [&Branch; 2]) -> Option<Self> {
        let place = Tracked::of(sweep.at(0.5 * (from.value + to.value))?);
        let mode = |which: usize| {
            let of_class = |own: &(usize, &Shape)| own.1.class == branches[which].class;
            place.shapes().iter().enumerate().filter(of_class).nth(ranks[which]).map(|own| own.0)
        };
        Self::new(&place, [mode(0)?, mode(1)?])
    }

    fn crosses(&self, other: &Self) -> bool {
        self.by.is_negative() != other.by.is_negative()
    }
}

/// What the unit of the parameter is worth in SI.
fn unit(sweep: &Sweep) -> f64 {
    let Some((from, to)) = sweep.ends_si() else { return 1.0 };
    let ends = [(0, from), (sweep.range().len() - 1, to)].map(|(place, si)| (sweep.value(place), si));
    ends.iter().find(|(value, _)| *value != 0.0).map_or(1.0, |(value, si)| si.mid_f64() / value)
}
