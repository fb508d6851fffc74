//! Steady responses, as CSV and JSON.

use std::fmt::Write;

use super::Written;
use super::json::{array, null, number, string};
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
        optional(&response.model),
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
