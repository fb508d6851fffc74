//! The equilibria in a box, as text and as JSON.

use std::fmt::Write;

use super::json::{array, lines, null, number, string};
use super::table::{Column, draw};
use super::{Style, Tone, Written, headline, shown_unit};
use librate_core::model::Model;
use librate_core::modes::Stability;
use librate_core::precision::{Ball, one_digit_up, one_digit_up_text};
use librate_studies::equilibria::{Equilibrium, Found};

/// Digits of coordinates and frequencies.
const DIGITS: usize = 10;

/// The equilibria as a table to read; why these may not be all is for the caller to tell ([`Found::reasons`]).
#[must_use]
pub fn equilibria_text(model: &Model, found: &Found, style: &Style) -> String {
    let all = &found.equilibria;
    let mut out = style.paint(Tone::Heading, &headline(model.name.as_deref(), model.coordinates.len()));
    let count = match all.len() {
        0 => "no equilibrium".to_owned(),
        1 => "1 equilibrium".to_owned(),
        count => format!("{count} equilibria"),
    };
    let (tone, whether) = match (found.complete, all.is_empty()) {
        (true, true) => (Tone::Good, "proved"),
        (true, false) => (Tone::Good, "all there are"),
        (false, _) => (Tone::Careful, "not proved to be all"),
    };
    let _ = writeln!(out, "\n\n{count} in the box, {}", style.paint(tone, whether));
    if all.is_empty() {
        return out;
    }
    out.push('\n');
    let rows = all.len();
    let numbers = Column::right("", (1..=rows).map(|at| at.to_string()).collect());
    let mut places: Vec<Column> = Vec::new();
    for (at, coordinate) in model.coordinates.iter().enumerate() {
        let unit = shown_unit(coordinate).filter(|_| model.has_units);
        let heading = unit.map_or_else(|| coordinate.name(), |unit| format!("{} ({unit})", coordinate.name()));
        let cells = all.iter().map(|own| Written::new(&own.point[at], DIGITS).text());
        places.push(Column::numbers(&heading, cells.collect()));
    }
    let last = modes_columns(model, all);
    let width: usize = [&numbers].into_iter().chain(&places).chain(&last).map(Column::width).sum();
    let painted = |at: usize| {
        let tone = match all[at].stability {
            Stability::Stable => Tone::Good,
            Stability::Unstable => Tone::Bad,
            Stability::Neutral | Stability::Undecided => Tone::Careful,
        };
        Some((tone, all[at].stability.as_str()))
    };
    if width <= style.width {
        let columns: Vec<Column> = [numbers].into_iter().chain(places).chain(last).collect();
        out.push_str(&draw(&columns, rows, painted, style));
        return out;
    }
    let columns: Vec<Column> = [numbers].into_iter().chain(last).collect();
    out.push_str(&draw(&columns, rows, painted, style));
    // Coordinates in tables of their own, as many side by side as there is space for.
    let mut places = places.into_iter().peekable();
    while places.peek().is_some() {
        let mut columns = vec![Column::right("", (1..=rows).map(|at| at.to_string()).collect())];
        let mut width = columns[0].width();
        while let Some(next) = places.next_if(|next| columns.len() == 1 || width + next.width() <= style.width) {
            width += next.width();
            columns.push(next);
        }
        out.push('\n');
        out.push_str(&draw(&columns, rows, |_| None, style));
    }
    out
}

/// Bound, stability, and the lowest frequency or the fastest growth.
fn modes_columns(model: &Model, all: &[Equilibrium]) -> Vec<Column> {
    let radius = |own: &Equilibrium| match own.radius() {
        0.0 => "0".to_owned(),
        radius => one_digit_up_text(radius),
    };
    let written = |ball: &Ball| Written::new(ball, DIGITS).text();
    let lowest = |own: &Equilibrium| {
        let oscillating = own.omega.iter().find(|omega| omega.is_positive());
        oscillating.map_or_else(String::new, written)
    };
    let fastest = |own: &Equilibrium| {
        let growing = own.growth.iter().find(|growth| growth.is_positive());
        growing.map_or_else(String::new, written)
    };
    let [frequency, rate] =
        if model.has_units { ["lowest omega (rad/s)", "growth (1/s)"] } else { ["lowest omega", "growth"] };
    let mut columns = vec![
        Column::words("bound", all.iter().map(radius).collect()),
        Column::words("stability", all.iter().map(|own| own.stability.as_str().to_owned()).collect()),
        Column::numbers(frequency, all.iter().map(lowest).collect()),
    ];
    let growth: Vec<String> = all.iter().map(fastest).collect();
    if growth.iter().any(|own| !own.is_empty()) {
        columns.push(Column::numbers(rate, growth));
    }
    columns
}

/// The equilibria as a JSON object: `model`, `coordinates`, `box` (per coordinate both ends in SI, `null` for one that is left out),
/// `complete`, `equilibria` with `point` in SI, `radius` (the largest error of a coordinate as it stands here), `isolated`,
/// `stability`, `omega` and `growth` (one a mode, in the order of `modes`), `undecided` places and `messages`, why it is not complete.
#[must_use]
pub fn equilibria_json(model: &Model, found: &Found) -> String {
    let mut out = String::from("{");
    write_head(&mut out, model, found);
    let equilibria = found.equilibria.iter().map(equilibrium_object);
    let _ = write!(out, ",\n \"complete\": {},\n \"equilibria\": {}", found.complete, lines(equilibria));
    let undecided = found.undecided.iter().map(|own| {
        let point = array(own.point.iter().map(|x| number(*x)));
        format!("{{\"point\": {point}, \"radius\": {}}}", number(one_digit_up(own.radius)))
    });
    let _ = write!(out, ",\n \"undecided\": {}", array(undecided));
    let _ = write!(out, ",\n \"messages\": {}", array(found.reasons.iter().map(|reason| string(reason))));
    out.push_str("}\n");
    out
}

fn write_head(out: &mut String, model: &Model, found: &Found) {
    let names: Vec<String> = model.coordinates.names().map(|name| string(&name)).collect();
    let sides = names.iter().zip(&found.region.sides).map(|(name, side)| match side {
        Some([from, to]) => format!("{name}: [{}, {}]", number(from.mid_f64()), number(to.mid_f64())),
        None => format!("{name}: null"),
    });
    let sides: Vec<String> = sides.collect();
    let _ = write!(
        out,
        "\"model\": {},\n \"coordinates\": {},\n \"box\": {{{}}}",
        model.name.as_deref().map_or_else(null, string),
        array(names.into_iter()),
        sides.join(", ")
    );
}

fn equilibrium_object(own: &Equilibrium) -> String {
    let values = |all: &[Ball]| array(all.iter().map(|x| number(x.mid_f64())));
    format!(
        "{{\"point\": {}, \"radius\": {}, \"isolated\": {}, \"stability\": \"{}\", \"omega\": {}, \"growth\": {}}}",
        values(&own.point),
        number(one_digit_up(own.radius())),
        own.isolated,
        own.stability.as_str(),
        values(&own.omega),
        values(&own.growth),
    )
}
