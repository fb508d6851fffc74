//! Steady responses, as CSV and JSON.

use std::fmt::Write;

use super::json::{array, model_and_version, null, number, string};
use super::picture::{Axis, Curve, Panel, Picture, Stroke, titled};
use super::{Written, common, with_unit};
use librate_core::precision::{Ball, one_digit_up, quick_decimal};
use librate_studies::response::{Response, Value};

/// A number for a cell: all digits, or those that are certain.
fn cell(value: &Ball, digits: usize) -> String {
    quick_decimal(value, digits).or_else(|| Written::new(value, digits).digits).unwrap_or_default()
}

/// A line a frequency: the frequency, then amplitude and phase of each output. `inf` is a resonance, and empty what is not decided.
#[must_use]
pub fn response_csv(response: &Response, digits: usize) -> String {
    let mut table = csv::Writer::from_writer(Vec::new());
    let names = response.outputs.iter().map(|own| &own.coordinate);
    let names = names.flat_map(|name| [format!("{name} amplitude"), format!("{name} phase")]);
    // Nothing that is written to memory fails.
    let _ = table.write_record(std::iter::once(response.name.clone()).chain(names));
    for (at, place) in response.places.iter().enumerate() {
        let cells = response.outputs.iter().flat_map(|output| match &output.values[at] {
            Value::Known { amplitude, phase } => {
                [cell(amplitude, digits), phase.map_or_else(String::new, |phase| cell(&phase, digits))]
            }
            Value::Infinite => ["inf".to_owned(), String::new()],
            _ => [String::new(), String::new()],
        });
        let _ = table.write_record(std::iter::once(number(*place)).chain(cells));
    }
    String::from_utf8(table.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// The response as a JSON object: `model`, `input`, the frequencies under the name of their column, and `outputs`, each with
/// `coordinate`, `amplitude`, `phase` and their bounds, one a frequency. An amplitude is `"inf"` at a resonance, and what is not decided is
/// `null`, as is the phase of an amplitude that is 0 or infinite.
#[must_use]
pub fn response_json(response: &Response) -> String {
    let optional = |text: &Option<String>| text.as_deref().map_or_else(null, string);
    let mut out = String::new();
    let _ = write!(
        out,
        "{{\"model\": {},\n \"input\": {},\n \"parameter\": {},\n {}: {},\n \"outputs\": [",
        model_and_version(response.model.as_deref()),
        optional(&response.input),
        string(&response.name),
        string(&response.name),
        array(response.places.iter().map(|place| number(*place))),
    );
    let bound = |value: &Ball| number(one_digit_up(value.mid_f64_error()));
    for (at, output) in response.outputs.iter().enumerate() {
        let values = || output.values.iter();
        let known = |value: &Value| match value {
            Value::Known { amplitude, phase } => (Some(*amplitude), *phase),
            _ => (None, None),
        };
        let amplitudes = values().map(|value| match value {
            Value::Infinite => string("inf"),
            value => known(value).0.map_or_else(null, |own| number(own.mid_f64())),
        });
        let phases = values().map(|value| known(value).1.map_or_else(null, |own| number(own.mid_f64())));
        let amplitude_bounds = values().map(|value| known(value).0.as_ref().map_or_else(null, bound));
        let phase_bounds = values().map(|value| known(value).1.as_ref().map_or_else(null, bound));
        let _ = write!(
            out,
            "{}{{\"coordinate\": {},\n   \"unit\": {},\n   \"amplitude\": {},\n   \"amplitude_error_bound\": {},\n   \"phase\": {},\n   \"phase_error_bound\": {}}}",
            if at == 0 { "\n  " } else { ",\n  " },
            string(&output.coordinate),
            optional(&output.unit),
            array(amplitudes),
            array(amplitude_bounds),
            array(phases),
            array(phase_bounds),
        );
    }
    out.push(']');
    if !response.proved {
        out.push_str(",\n \"equilibrium_proved\": false");
    }
    out.push_str("}\n");
    out
}

/// An amplitude of more than so many times the median one leaves the picture, as all do near a resonance without damping.
const TALLEST: f64 = 25.0;
/// More curves than this tell nobody anything.
const MOST_CURVES: usize = 10;

/// Amplitude and phase over the frequency as an SVG picture, one below the other; of many outputs the first ten.
#[must_use]
pub fn response_svg(response: &Response) -> String {
    let shown = response.outputs.iter().take(MOST_CURVES);
    let curves = |pick: fn(&Value) -> f64, jump: f64| -> Vec<Curve> {
        let one = |(colour, output): (usize, &librate_studies::response::Output)| {
            let mut points: Vec<[f64; 2]> = Vec::new();
            for (place, value) in response.places.iter().zip(&output.values) {
                let size = pick(value);
                let point = [*place, if size.is_finite() { size } else { f64::NAN }];
                // From -pi to pi is no way.
                if points.last().is_some_and(|last| (last[1] - point[1]).abs() > jump) {
                    points.push([f64::NAN; 2]);
                }
                points.push(point);
            }
            Curve { name: output.coordinate.clone(), colour, stroke: Stroke::Solid, points }
        };
        shown.clone().enumerate().map(one).collect()
    };
    let [amplitudes, phases] = [curves(Value::amplitude, f64::INFINITY), curves(Value::phase, std::f64::consts::PI)];
    let points = || amplitudes.iter().flat_map(|own| &own.points).map(|point| point[1]);
    let mut sizes: Vec<f64> = points().filter(|size| *size > 0.0).collect();
    sizes.sort_by(f64::total_cmp);
    let most = sizes.get(sizes.len() / 2).map_or(f64::INFINITY, |median| TALLEST * median);
    let label = with_unit("amplitude", common(shown.clone().map(|own| own.unit.as_deref())));
    let unit = response.unit.as_deref().or((response.input.is_some()).then_some("rad/s"));
    let name = with_unit(&response.name, unit);
    let across = || Axis::over(&name, response.places.iter().copied(), 0.0);
    let up = Axis::over(label, points().filter(|size| *size <= most).chain([0.0]), 0.05);
    let turn = Axis::over("phase (rad)", [-std::f64::consts::PI, std::f64::consts::PI].into_iter(), 0.05);
    let source =
        response.input.as_ref().map_or_else(|| "its own drive".to_owned(), |name| format!("a force on {name}"));
    Picture {
        title: titled("Response", response.model.as_deref()),
        description: format!(
            "Amplitude and phase of the steady response to {source}; curves break at resonances without damping."
        ),
        columns: 1,
        size: [600.0, 230.0],
        panels: vec![Panel::new(across(), up, amplitudes), Panel::new(across(), turn, phases)],
        legend: Vec::new(),
    }
    .svg()
}
