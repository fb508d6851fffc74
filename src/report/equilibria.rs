//! The equilibria in a box, or over a parameter, as text and as JSON.

use std::fmt::Write;

use super::json::{Object, array, bound, error_bound, lines, middles, null, number, record, string, strings};
use super::modes::stability_tone;
use super::table::{Column, draw};
use super::{Style, Tone, Written, bound_text, counted, headline, shown_unit, with_unit};
use librate_core::linearize::short;
use librate_core::model::{Coordinate, Model};
use librate_core::modes::Stability;
use librate_core::precision::Ball;
use librate_studies::equilibria::{Bifurcation, Branch, Diagram, Equilibrium, Found, Region};

/// Digits of coordinates and frequencies.
const DIGITS: usize = 10;

/// How many there are, in words.
pub(super) fn equilibria_count(equilibria: usize) -> String {
    match equilibria {
        0 => "no equilibrium".to_owned(),
        1 => "1 equilibrium".to_owned(),
        count => format!("{count} equilibria"),
    }
}

/// The equilibria as a table to read; why these may not be all is for the caller to tell ([`Found::reasons`]).
#[must_use]
pub fn equilibria_text(model: &Model, found: &Found, style: &Style) -> String {
    let all = &found.equilibria;
    let mut out = style.paint(Tone::Heading, &headline(model.name.as_deref(), model.coordinates.len()));
    let families = all.iter().filter(|own| own.isolated == Some(false)).count();
    let count = match families {
        1 if found.decided && all.len() == 1 => "1 family of equilibria in the box".to_owned(),
        2.. if found.decided && families == all.len() => format!("{families} families of equilibria in the box"),
        1.. if found.decided => format!("{} in the box, one of each family", equilibria_count(all.len())),
        _ => format!("{} in the box", equilibria_count(all.len())),
    };
    let is_all = found.complete || found.decided && families > 0;
    let whether = completeness(is_all, all.is_empty(), style);
    let _ = writeln!(out, "\n\n{count}, {whether}");
    if all.is_empty() {
        return out;
    }
    out.push('\n');
    let places = point_columns(model, || all.iter().map(|own| own.point.as_slice()));
    let painted = |at: usize| Some((stability_tone(all[at].stability), all[at].stability.as_str()));
    let numbers = vec![Column::counting("", all.len())];
    push_table(&mut out, [numbers, places, modes_columns(model, all)], all.len(), painted, style);
    out
}

/// That these are all there are, or not.
fn completeness(complete: bool, empty: bool, style: &Style) -> String {
    let (tone, whether) = match (complete, empty) {
        (true, true) => (Tone::Good, "proved"),
        (true, false) => (Tone::Good, "all there are"),
        (false, _) => (Tone::Careful, "not proved to be all"),
    };
    style.paint(tone, whether)
}

/// A column for each coordinate.
fn point_columns<'a, I: Iterator<Item = &'a [Ball]>>(model: &Model, points: impl Fn() -> I) -> Vec<Column> {
    let column = |(at, coordinate): (usize, Coordinate<'_>)| {
        let unit = shown_unit(coordinate).filter(|_| model.has_units);
        let cells = points().map(|point| Written::new(&point[at], DIGITS).text());
        Column::numbers(&with_unit(&coordinate.name(), unit), cells.collect())
    };
    model.coordinates.iter().enumerate().map(column).collect()
}

/// A table with columns for the coordinates among others; where they don't fit, tables of their own follow, with as many side by
/// side as there is space for.
fn push_table<'a>(
    out: &mut String,
    [mut columns, places, last]: [Vec<Column>; 3],
    rows: usize,
    painted: impl Fn(usize) -> Option<(Tone, &'a str)>,
    style: &Style,
) {
    let width: usize = columns.iter().chain(&places).chain(&last).map(Column::width).sum();
    let (beside, below) = if width <= style.width { (places, Vec::new()) } else { (Vec::new(), places) };
    columns.extend(beside.into_iter().chain(last));
    out.push_str(&draw(&columns, rows, painted, style));
    let mut below = below.into_iter().peekable();
    while below.peek().is_some() {
        let mut columns = vec![Column::counting("", rows)];
        let mut width = columns[0].width();
        while let Some(next) = below.next_if(|next| columns.len() == 1 || width + next.width() <= style.width) {
            width += next.width();
            columns.push(next);
        }
        out.push('\n');
        out.push_str(&draw(&columns, rows, |_| None, style));
    }
}

/// How far numbers are off at most, as they are printed.
fn printed_bound<'a>(numbers: impl IntoIterator<Item = &'a Ball>) -> String {
    bound_text(numbers.into_iter().map(|own| Written::new(own, DIGITS).bound).fold(0.0, f64::max))
}

/// Bound, stability, and the lowest frequency or the fastest growth.
fn modes_columns(model: &Model, all: &[Equilibrium]) -> Vec<Column> {
    let written = |ball: &Ball| Written::new(ball, DIGITS).text();
    let first = |all: &[Ball]| all.iter().find(|own| own.is_positive()).map_or_else(String::new, written);
    let lowest = |all: &[Ball]| {
        let positive = all.iter().filter(|own| own.is_positive());
        positive.min_by(|a, b| a.mid_f64().total_cmp(&b.mid_f64())).map_or_else(String::new, written)
    };
    let [frequency, rate] =
        if model.has_units { ["lowest omega (rad/s)", "growth (1/s)"] } else { ["lowest omega", "growth"] };
    let mut columns = vec![
        Column::words("bound", all.iter().map(|own| printed_bound(&own.point)).collect()),
        Column::words("stability", all.iter().map(|own| own.stability.as_str().to_owned()).collect()),
        Column::numbers(frequency, all.iter().map(|own| lowest(&own.omega)).collect()),
    ];
    let growth: Vec<String> = all.iter().map(|own| first(&own.growth)).collect();
    columns.extend(growth.iter().any(|own| !own.is_empty()).then(|| Column::numbers(rate, growth)));
    columns
}

/// The equilibria as a JSON object: `model`, `coordinates`, `box` (per coordinate both ends in SI, `null` for one that is left out),
/// `complete`, `equilibria` with `point` in SI, `radius` (the largest error of a coordinate as it stands here), `isolated`,
/// `stability`, `omega` and `growth` (one a mode, in the order of `modes`), `undecided` places and `messages`, why it is not complete.
#[must_use]
pub fn equilibria_json(model: &Model, found: &Found) -> String {
    let mut object = head(model, &found.region);
    object.field("complete", found.complete);
    object.field("equilibria", lines(found.equilibria.iter().map(equilibrium_object)));
    let undecided = found.undecided.iter().map(|own| {
        let point = array(own.point.iter().map(|x| number(*x)));
        record([("point", point), ("radius", bound(own.radius))])
    });
    object.field("undecided", array(undecided));
    object.field("messages", strings(&found.reasons));
    object.end() + "\n"
}

fn head(model: &Model, region: &Region) -> Object {
    let ends = |side: &Option<[Ball; 2]>| side.as_ref().map_or_else(null, middles);
    let mut object = Object::of_model(model);
    object.field("box", record(model.coordinates.names().zip(region.sides.iter().map(ends))));
    object
}

fn equilibrium_object(own: &Equilibrium) -> String {
    record([
        ("point", middles(&own.point)),
        ("radius", bound(own.radius())),
        ("isolated", own.isolated.map_or_else(null, |own| own.to_string())),
        ("stability", string(own.stability.as_str())),
        ("omega", middles(&own.omega)),
        ("growth", middles(&own.growth)),
    ])
}

/// The branches of equilibria over a parameter as tables to read; why these may not be all is for the caller to tell
/// ([`Diagram::reasons`]).
#[must_use]
pub fn diagram_text(model: &Model, diagram: &Diagram, style: &Style) -> String {
    let Diagram { branches, bifurcations, values, name, .. } = diagram;
    let mut out = style.paint(Tone::Heading, &headline(model.name.as_deref(), model.coordinates.len()));
    let (count, places) = (values.len(), counted(values.len(), "value"));
    let _ = writeln!(
        out,
        "\n\n{} of equilibria in the box over {places} of {name}, {}",
        match branches.len() {
            1 => "1 branch".to_owned(),
            many => format!("{many} branches"),
        },
        completeness(diagram.complete, branches.is_empty(), style)
    );
    let parameter = with_unit(name, diagram.unit.as_deref());
    if !branches.is_empty() && count > 0 {
        out.push('\n');
        let end = |at: &dyn Fn(&Branch) -> Option<usize>| -> Vec<String> {
            branches.iter().map(|own| at(own).map_or_else(String::new, |place| short(values[place]))).collect()
        };
        let columns = vec![
            Column::counting("", branches.len()),
            Column::numbers(&format!("from {parameter}"), end(&|own| Some(own.at.first()?.0))),
            Column::numbers("to", end(&|own| Some(own.at.last()?.0))),
            Column::words("stability", branches.iter().map(|own| stabilities(own, diagram)).collect()),
        ];
        let lasts = || branches.iter().filter_map(|own| Some(own.at.last()?.1.point.as_slice()));
        let all = [columns, point_columns(model, lasts), Vec::new()];
        push_table(&mut out, all, branches.len(), |_| None, style);
        out.push_str("coordinates are those at the last value of a branch\n");
    }
    if !bifurcations.is_empty() {
        let rows = bifurcations.len();
        let of = |text: fn(&Bifurcation) -> String| bifurcations.iter().map(text).collect();
        let columns = vec![
            Column::counting("", rows),
            Column::words("bifurcation", of(|own| own.kind.as_str().to_owned())),
            Column::numbers(&parameter, of(|own| Written::new(&own.value, DIGITS).text())),
            Column::words("bound", of(|own| printed_bound(own.point.iter().chain([&own.value])))),
        ];
        let places = point_columns(model, || bifurcations.iter().map(|own| own.point.as_slice()));
        out.push('\n');
        push_table(&mut out, [columns, places, Vec::new()], rows, |_| None, style);
    }
    out
}

/// `stable, unstable from 8`, or behind a bifurcation `stable, neutral at 8, unstable behind it`: what begins there begins with it.
fn stabilities(branch: &Branch, diagram: &Diagram) -> String {
    let mut parts: Vec<String> = Vec::new();
    let mut last = None;
    let mut turning = None;
    for (place, own) in &branch.at {
        let value = diagram.values[*place];
        if own.stability == Stability::Neutral && bifurcates(diagram, value) {
            turning = Some(value);
            continue;
        }
        if last != Some(own.stability) {
            let word = own.stability.as_str();
            parts.push(match (last, turning) {
                (None, _) => word.to_owned(),
                (Some(_), None) => format!("{word} from {}", short(value)),
                (Some(_), Some(turning)) => format!("neutral at {}, {word} behind it", short(turning)),
            });
            last = Some(own.stability);
        }
        turning = None;
    }
    if parts.is_empty() { Stability::Neutral.as_str().to_owned() } else { parts.join(", ") }
}

/// Whether a value of the parameter is one of a bifurcation: stability there says nothing of what is beside.
pub(super) fn bifurcates(diagram: &Diagram, value: f64) -> bool {
    diagram.bifurcations.iter().any(|own| (own.value - Ball::exact(value)).contains_zero())
}

/// The branches of equilibria over a parameter as a JSON object: `model`, `coordinates`, `box`, `parameter`, its values under its
/// name, `complete`, `branches` with `values`, `points`, `radius`, `stability`, `omega` and `growth`, one a value; and
/// `bifurcations` with `kind`, the parameter's value under its name, its bound, `point` and `radius`.
#[must_use]
pub fn diagram_json(model: &Model, diagram: &Diagram) -> String {
    let mut object = head(model, &diagram.region);
    let name = string(&diagram.name);
    let all = array(diagram.values.iter().map(|value| number(*value)));
    object.field("parameter", format!("{name},\n {name}: {all}"));
    object.field("complete", diagram.complete);
    let branches = diagram.branches.iter().map(|branch| {
        let own = || branch.at.iter().map(|(_, own)| own);
        let mut object = Object::new(",\n   ");
        object.field("values", array(branch.at.iter().map(|(place, _)| number(diagram.values[*place]))));
        object.field("points", array(own().map(|own| middles(&own.point))));
        object.field("radius", array(own().map(|own| bound(own.radius()))));
        object.field("stability", strings(own().map(|own| own.stability.as_str())));
        object.field("omega", array(own().map(|own| middles(&own.omega))));
        object.field("growth", array(own().map(|own| middles(&own.growth))));
        object.end()
    });
    object.field("branches", lines(branches));
    let bifurcations = diagram.bifurcations.iter().map(|own| {
        record([
            ("kind", string(own.kind.as_str())),
            (&diagram.name, number(own.value.mid_f64())),
            ("error_bound", error_bound(&own.value)),
            ("point", middles(&own.point)),
            ("radius", bound(own.radius())),
        ])
    });
    object.field("bifurcations", lines(bifurcations));
    object.field("messages", strings(&diagram.reasons));
    object.end() + "\n"
}
