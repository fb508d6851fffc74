//! Motions, as CSV and as a picture.

use plotters::prelude::*;

use super::json::{array, null, number, string};
use super::picture::{self, Drawing, FAINT, FONT, INK, PAPER};
use crate::model::Model;
use crate::motion::{Start, Trajectory};
use crate::precision::{Ball, decimal, one_digit_up};

/// More curves than this tell nobody anything.
const MOST_CURVES: usize = 10;

/// A table with one line a row: `t`, the coordinates, their velocities (`x'`), and with a superposition of modes the same once more,
/// `linear x` and `linear x'`.
///
/// Numbers are in SI, with so many correctly rounded digits as far as bounds or error estimates allow; an empty cell has lost all
/// of them. Values of quick runs are doubles as they are, and so is the superposition.
#[must_use]
pub fn motion_csv(
    model: &Model,
    trajectory: &Trajectory,
    superposition: Option<&[Vec<f64>]>,
    digits: usize,
) -> String {
    let names: Vec<&str> = model
        .coordinates
        .iter()
        .map(|own| own.name.as_str())
        .collect();
    let both = |prefix: &str| -> Vec<String> {
        let positions = names.iter().map(|name| format!("{prefix}{name}"));
        let velocities = names.iter().map(|name| format!("{prefix}{name}'"));
        positions.chain(velocities).collect()
    };
    let mut header = vec!["t".to_owned()];
    header.extend(both(""));
    if superposition.is_some() {
        header.extend(both("linear "));
    }
    // Writing to memory does not fail.
    let mut table = csv::Writer::from_writer(Vec::new());
    let _ = table.write_record(&header);
    for (at, (time, row)) in trajectory.times.iter().zip(&trajectory.rows).enumerate() {
        let mut cells = vec![number(time.mid_f64())];
        cells.extend(row.iter().map(|value| {
            if trajectory.estimated {
                decided(value, digits)
            } else {
                number(value.mid_f64())
            }
        }));
        let linear = superposition.and_then(|rows| rows.get(at));
        cells.extend(linear.into_iter().flatten().map(|value| number(*value)));
        let _ = table.write_record(&cells);
    }
    let bytes = table.into_inner().unwrap_or_default();
    String::from_utf8(bytes).unwrap_or_default()
}

/// A motion as a JSON object, a column for each coordinate and each velocity: doubles, the digits of [`motion_csv`], and what the doubles
/// are off by, as `error_bounds` where that is proved and as `error_estimates` where it is not. A quick run has neither.
/// The schema is `motion.schema.json`.
#[must_use]
pub fn motion_json(model: &Model, trajectory: &Trajectory, digits: usize) -> String {
    let names = || model.coordinates.iter().map(|own| own.name.clone());
    let columns = names().chain(names().map(|name| format!("{name}'")));
    let columns = columns.enumerate().map(|(at, name)| {
        let values = || trajectory.rows.iter().map(move |row| &row[at]);
        let middles = array(values().map(|value| number(value.mid_f64())));
        let mut text = format!("\n  {{\"name\": {}, \"values\": {middles}", string(&name));
        if trajectory.estimated {
            let digits = values().map(|value| match decided(value, digits) {
                text if text.is_empty() => null(),
                text => string(&text),
            });
            let errors = values().map(|value| number(one_digit_up(value.mid_f64_error())));
            let what = if trajectory.proved.is_some() {
                "error_bounds"
            } else {
                "error_estimates"
            };
            text.push_str(&format!(
                ", \"digits\": {}, \"{what}\": {}",
                array(digits),
                array(errors)
            ));
        }
        text.push('}');
        text
    });
    let columns: Vec<String> = columns.collect();
    format!(
        "{{\"model\": {},\n \"coordinates\": {},\n \"proved\": {},\n \"steps\": {},\n \"energy_drift\": {},\n \"times\": {},\n \"columns\": [{}]}}\n",
        model.name.as_deref().map_or_else(null, string),
        array(names().map(|name| string(&name))),
        trajectory.proved.is_some(),
        trajectory.steps,
        trajectory.energy_drift.map_or_else(null, number),
        array(trajectory.times.iter().map(|time| number(time.mid_f64()))),
        columns.join(",")
    )
}

/// The digits that are certain; nothing where none is.
fn decided(value: &Ball, digits: usize) -> String {
    let own = decimal(value, digits);
    if own.digits > 0 {
        own.text
    } else {
        String::new()
    }
}

/// So many values that were moved are told.
const MOST_MOVED: usize = 6;

/// What was moved onto the constraints, and by how much in SI, in a line; `None` where nothing was.
#[must_use]
pub fn start_remark(model: &Model, start: &Start) -> Option<String> {
    let mut moved: Vec<String> = Vec::new();
    for own in start.moved.iter().take(MOST_MOVED) {
        let name = &model.coordinates.get(own.coordinate)?.name;
        let prime = if own.velocity { "'" } else { "" };
        moved.push(format!("{name}{prime} by {:.1e}", own.by));
    }
    if start.moved.len() > MOST_MOVED {
        moved.push("…".to_owned());
    }
    let all = moved.join(", ");
    (!moved.is_empty()).then(|| {
        format!("the start was moved onto the constraints, within the digits given: {all}")
    })
}

/// How a motion was computed, in a line for people: the number of steps, and what the energy does.
#[must_use]
pub fn motion_remark(trajectory: &Trajectory) -> String {
    let steps = trajectory.steps;
    let plural = if steps == 1 { "" } else { "s" };
    let mut text = format!("{steps} step{plural}");
    if let Some(bits) = trajectory.proved {
        text.push_str(&format!(
            " in numbers of {bits} bits; every digit is proved"
        ));
    }
    match trajectory.energy_drift {
        Some(0.0) => text.push_str("; the energy stays what it is but for rounding"),
        Some(drift) => text.push_str(&format!(
            "; the energy strays by at most {drift:.0e} of the largest kinetic energy"
        )),
        None => {}
    }
    text
}

const SIZE: (u32, u32) = (760, 420);
/// Colours that people with any kind of sight tell apart (Okabe and Ito, 2008), and two more.
const COLOURS: [RGBColor; MOST_CURVES] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(120, 94, 60),
    RGBColor(90, 90, 90),
    RGBColor(148, 103, 189),
    RGBColor(23, 60, 90),
];

/// The coordinates over the time, as an SVG picture: solid, and thin for the superposition of modes. Of many coordinates the first
/// ten.
#[must_use]
pub fn motion_svg(
    model: &Model,
    trajectory: &Trajectory,
    superposition: Option<&[Vec<f64>]>,
) -> String {
    picture::svg(SIZE, |area| draw(area, model, trajectory, superposition))
}

fn draw(
    area: &Drawing<'_>,
    model: &Model,
    trajectory: &Trajectory,
    superposition: Option<&[Vec<f64>]>,
) -> Result<(), Box<dyn std::error::Error>> {
    let shown = model.coordinates.len().min(MOST_CURVES);
    let times: Vec<f64> = trajectory.times.iter().map(|t| t.mid_f64()).collect();
    let curve = |at: usize| -> Vec<(f64, f64)> {
        let values = trajectory.rows.iter().map(|row| row[at].mid_f64());
        times.iter().copied().zip(values).collect()
    };
    let linear = |at: usize| -> Vec<(f64, f64)> {
        let rows = superposition.unwrap_or_default();
        times
            .iter()
            .copied()
            .zip(rows.iter().map(|row| row[at]))
            .collect()
    };
    let solid: Vec<_> = (0..shown).map(curve).collect();
    let thin: Vec<_> = (0..shown).map(linear).collect();
    let all = solid.iter().flatten().map(|point| point.1);
    let (mut low, mut high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    if !low.is_finite() || !high.is_finite() {
        (low, high) = (-1.0, 1.0);
    }
    // Room for what differs a little, not for a superposition that has gone far off.
    let room = (0.08 * (high - low)).max(1e-12 * low.abs().max(high.abs()).max(1e-300));
    let end = times.last().copied().unwrap_or(0.0).max(1e-300);
    let time = if model.has_units { "t in s" } else { "t" };
    let mut chart = picture::axes(area, 0.0..end, (low - room)..(high + room), (time, None))?;
    for at in 0..shown {
        let colour = COLOURS[at];
        let inside = thin[at]
            .iter()
            .copied()
            .filter(|point| (low - room..high + room).contains(&point.1));
        chart.draw_series(LineSeries::new(inside, colour.mix(0.45).stroke_width(1)))?;
        chart
            .draw_series(LineSeries::new(
                solid[at].iter().copied(),
                colour.stroke_width(2),
            ))?
            .label(model.coordinates[at].name.clone())
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .background_style(PAPER.mix(0.8))
        .border_style(FAINT)
        .label_font((FONT, 13).into_font().color(&INK))
        .draw()?;
    Ok(())
}
