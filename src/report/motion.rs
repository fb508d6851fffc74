//! Motions, as CSV and as a picture.

use std::io::{self, Write};

use super::json::{Object, array, error_bound, middles, null, number, record, string};
use super::picture::{Axis, Curve, Panel, Picture, Stroke, titled};
use super::{counted, csv_text, shown_unit, units, with_unit};
use librate_core::model::Model;
use librate_core::precision::{Ball, decimal, one_digit_up_text};
use librate_studies::motion::{Start, Trajectory};

/// More curves than this tell nobody anything.
const MOST_CURVES: usize = 10;

/// A table with one line a row: `t`, the coordinates, their velocities (`x'`), and with a superposition of modes the same once more,
/// `linear x` and `linear x'`.
///
/// Numbers are in SI, with so many correctly rounded digits as far as bounds or error estimates allow; an empty cell has lost all
/// of them. Values of quick runs are doubles as they are, and so is the superposition.
#[must_use]
pub fn motion_csv(model: &Model, trajectory: &Trajectory, superposition: Option<&[Vec<f64>]>, digits: usize) -> String {
    let linear = superposition.iter().flat_map(|_| columns(model)).map(|name| format!("linear {name}"));
    let header = ["t".to_owned()].into_iter().chain(columns(model)).chain(linear);
    let rows = cells(trajectory, digits).enumerate().map(|(at, own)| {
        let linear = superposition.and_then(|rows| rows.get(at));
        own.chain(linear.into_iter().flatten().map(|value| number(*value)))
    });
    csv_text(header, rows)
}

/// The cells of each row: the time, then what the digits tell of the values.
fn cells(trajectory: &Trajectory, digits: usize) -> impl Iterator<Item = impl Iterator<Item = String>> {
    let estimated = trajectory.estimated;
    trajectory.times.iter().zip(&trajectory.rows).map(move |(time, row)| {
        let rest = rest(row);
        let own = row.iter().map(move |value| match estimated {
            true => decided(value, digits, rest),
            false => number(value.mid_f64()),
        });
        std::iter::once(number(time.mid_f64())).chain(own)
    })
}

/// The tables of motions from several starts below each other, as [`motion_csv`] has them, with the number of the start in a column
/// in front.
#[derive(Debug)]
pub struct MotionsCsv<W: Write> {
    table: csv::Writer<W>,
    digits: usize,
}

impl<W: Write> MotionsCsv<W> {
    /// Begins with the header.
    ///
    /// # Errors
    /// Those of the writer, here and below.
    pub fn new(out: W, model: &Model, digits: usize) -> io::Result<Self> {
        let mut table = csv::Writer::from_writer(out);
        let header = ["start".to_owned(), "t".to_owned()].into_iter().chain(columns(model));
        table.write_record(header).map_err(plain)?;
        Ok(Self { table, digits })
    }

    /// Writes the motion from the start of this number.
    pub fn motion(&mut self, start: usize, motion: &Trajectory) -> io::Result<()> {
        let mut rows = cells(motion, self.digits);
        rows.try_for_each(|own| self.table.write_record([start.to_string()].into_iter().chain(own))).map_err(plain)
    }

    /// Writes what is left.
    pub fn finish(mut self) -> io::Result<()> {
        self.table.flush()
    }
}

/// What the writer below said.
pub(super) fn plain(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

/// The names of the columns: coordinates, then velocities.
fn columns(model: &Model) -> impl Iterator<Item = String> {
    let names = || model.coordinates.names();
    names().chain(names().map(|name| format!("{name}'")))
}

/// A motion as a JSON object, a column for each coordinate and each velocity: doubles, the digits of [`motion_csv`], and what the doubles
/// are off by, as `error_bounds` where that is proved and as `error_estimates` where it is not. A quick run has neither.
/// The schema is `motion.schema.json`.
#[must_use]
pub fn motion_json(model: &Model, trajectory: &Trajectory, digits: usize) -> String {
    let proved = trajectory.proved.is_some();
    let mut object = Object::of_model(model);
    object.field("proved", proved);
    object.field("steps", trajectory.steps);
    object.field("energy_drift", trajectory.energy_drift.map_or_else(null, number));
    object.field("constraint_drift", trajectory.constraint_drift.map_or_else(null, number));
    object.field("times", middles(&trajectory.times));
    let rests: Vec<f64> = trajectory.rows.iter().map(|row| rest(row)).collect();
    let columns = columns(model).enumerate().map(|(at, name)| {
        let values = || trajectory.rows.iter().filter_map(|row| row.get(at));
        let mut fields = vec![("name", string(&name)), ("values", middles(values()))];
        if trajectory.estimated {
            let texts = values().zip(&rests).map(|(value, rest)| decided(value, digits, *rest));
            let texts = texts.map(|text| if text.is_empty() { null() } else { string(&text) });
            fields.push(("digits", array(texts)));
            let errors = values().map(error_bound);
            fields.push((if proved { "error_bounds" } else { "error_estimates" }, array(errors)));
        }
        record(fields)
    });
    object.lines("columns", columns);
    object.end() + "\n"
}

/// What may be 0 and is less than this part of the largest number of its row rests.
const REST: f64 = 1e-25;

/// Below which magnitude what may be 0 counts as 0.
fn rest(row: &[Ball]) -> f64 {
    REST * row.iter().map(Ball::abs_upper).fold(0.0, f64::max)
}

/// The digits that are certain, 0 for what rests; nothing where none is certain.
fn decided(value: &Ball, digits: usize, rest: f64) -> String {
    let own = decimal(value, digits);
    match own.digits > 0 {
        true => own.text,
        false if value.contains_zero() && value.abs_upper() <= rest => "0".to_owned(),
        false => String::new(),
    }
}

/// So many values that were moved are told.
const MOST_MOVED: usize = 6;

/// What was moved onto the constraints, and by how much in SI, in a line; `None` where nothing was.
#[must_use]
pub fn start_remark(model: &Model, start: &Start) -> Option<String> {
    let mut moved: Vec<String> = Vec::new();
    for own in start.moved.iter().take(MOST_MOVED) {
        let name = &model.coordinates.get(own.coordinate)?.name();
        let prime = if own.velocity { "'" } else { "" };
        moved.push(format!("{name}{prime} by {:.1e}", own.by));
    }
    moved.extend((start.moved.len() > MOST_MOVED).then(|| "…".to_owned()));
    let all = moved.join(", ");
    let within = if start.moved.iter().all(|own| own.rounded) { ", within the digits given" } else { "" };
    (!moved.is_empty()).then(|| format!("the start was moved onto the constraints{within}: {all}"))
}

/// How a motion was computed, in a line for people: the number of steps, and what energy and constraints do.
#[must_use]
pub fn motion_remark(trajectory: &Trajectory) -> String {
    let mut text = counted(trajectory.steps, "step");
    if let Some(bits) = trajectory.proved {
        text.push_str(&format!(" with {bits} bits; every digit is proved"));
    }
    let drifts = [
        (trajectory.energy_drift, "the energy is constant", "the energy drifts", "the largest kinetic energy"),
        (trajectory.constraint_drift, "the constraints are kept", "the constraints drift", "their largest terms"),
    ];
    for (drift, is_kept, drifts, of) in drifts {
        match drift {
            Some(0.0) => text.push_str(&format!("; {is_kept} up to rounding")),
            Some(drift) => text.push_str(&format!("; {drifts} by at most {} of {of}", one_digit_up_text(drift))),
            None => {}
        }
    }
    text
}

/// The coordinates over the time, as an SVG picture: thin for the superposition of modes. Of many coordinates the first ten.
#[must_use]
pub fn motion_svg(model: &Model, trajectory: &Trajectory, superposition: Option<&[Vec<f64>]>) -> String {
    let shown = model.coordinates.len().min(MOST_CURVES);
    let times: Vec<f64> = trajectory.times.iter().map(|t| t.mid_f64()).collect();
    let curve = |at: usize, stroke: Stroke, values: &mut dyn Iterator<Item = f64>| {
        let name = model.coordinates.at(at).name();
        let name = if stroke == Stroke::Thin { format!("{name}, linear") } else { name };
        Curve { name, colour: at, stroke, points: times.iter().zip(values).map(|(t, value)| [*t, value]).collect() }
    };
    let full = |at: usize| curve(at, Stroke::Solid, &mut trajectory.rows.iter().map(|row| row[at].mid_f64()));
    let linear = |at: usize| Some(curve(at, Stroke::Thin, &mut superposition?.iter().map(|row| row[at])));
    let all: Vec<Curve> = (0..shown).map(full).collect();
    // Not for a superposition that has gone far off.
    let up = Axis::over(common_label(model, shown), all.iter().flat_map(|own| &own.points).map(|point| point[1]), 0.08);
    let across = Axis::over(if model.has_units { "t (s)" } else { "t" }, times.iter().copied(), 0.0);
    let curves = (0..shown).filter_map(linear).chain(all).collect();
    let description = match model.coordinates.len() {
        all if all > shown => format!("The first {shown} of {all} coordinates over the time."),
        _ => "The coordinates over the time.".to_owned(),
    };
    let picture = Picture::single(titled("Motion", model.name.as_deref()), description, Panel::new(across, up, curves));
    picture.without(model.coordinates.len() - shown).svg()
}

/// `x (m)` for one coordinate, `coordinates (m)` where they have one unit.
fn common_label(model: &Model, shown: usize) -> String {
    let what = match model.coordinates.first() {
        Some(only) if shown == 1 => only.name(),
        _ => "coordinates".to_owned(),
    };
    with_unit(&what, units(model.coordinates.iter().take(shown).map(shown_unit)).as_deref())
}
