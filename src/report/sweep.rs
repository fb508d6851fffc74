//! Modes over a range of a parameter, as CSV and JSON.

use super::json::{number, string};
use super::{Written, modes_json};
use librate_core::model::Range;
use librate_core::modes::Options;
use librate_core::oscillation::NormalMode;
use librate_studies::sweep::Place;

/// A table with one line a place: the parameter, `omega1`, `omega2`, …, and `growth1`, … where the growth
/// of some mode at some place is not 0.
///
/// Numbers have `options.digits` correctly rounded digits, or those that are certain. Cells are empty where a place has
/// fewer modes than others, or none.
#[must_use]
pub fn sweep_csv(range: &Range, places: &[Place], options: &Options) -> String {
    let modes = |place: &'_ Place| -> Vec<NormalMode> {
        match &place.result {
            Ok((_, modes)) => modes.modes.clone(),
            Err(_) => Vec::new(),
        }
    };
    let rows: Vec<Vec<NormalMode>> = places.iter().map(modes).collect();
    let most = rows.iter().map(Vec::len).max().unwrap_or(0);
    let grows = rows.iter().flatten().any(|mode| !mode.growth.is_zero());
    let mut header = vec![range.name().to_owned()];
    header.extend((1..=most).map(|at| format!("omega{at}")));
    if grows {
        header.extend((1..=most).map(|at| format!("growth{at}")));
    }
    // Writing to memory does not fail.
    let mut table = csv::Writer::from_writer(Vec::new());
    let _ = table.write_record(&header);
    for (place, row) in places.iter().zip(&rows) {
        let mut cells = vec![number(place.value)];
        let omega = row.iter().map(|mode| {
            let precise = mode.precise.as_deref().map(|precise| &precise.omega);
            cell(Written::finest(&mode.omega, precise, options.digits))
        });
        cells.extend(padded(omega, most));
        if grows {
            let growth = row.iter().map(|mode| {
                let precise = mode.precise.as_deref().map(|precise| &precise.growth);
                cell(Written::finest(&mode.growth, precise, options.digits))
            });
            cells.extend(padded(growth, most));
        }
        let _ = table.write_record(&cells);
    }
    let bytes = table.into_inner().unwrap_or_default();
    String::from_utf8(bytes).unwrap_or_default()
}

fn cell(written: Written) -> String {
    written.digits.unwrap_or_default()
}

fn padded(cells: impl Iterator<Item = String>, width: usize) -> impl Iterator<Item = String> {
    cells.chain(std::iter::repeat_with(String::new)).take(width)
}

/// An array with one object a place: the parameter under its name, then all that
/// [`modes_json`] has; `error` in its place where there are no modes.
#[must_use]
pub fn sweep_json(range: &Range, places: &[Place], options: &Options) -> String {
    let objects: Vec<String> = places
        .iter()
        .map(|place| {
            let value = format!("{{{}: {}", string(range.name()), number(place.value));
            match &place.result {
                Ok((linearized, modes)) => {
                    let own = modes_json(linearized, modes, options);
                    let own = own.trim_start_matches('{').trim_end();
                    format!("{value}, {own}")
                }
                Err(error) => format!("{value}, \"error\": {}}}", string(&error.to_string())),
            }
        })
        .collect();
    format!("[{}]\n", objects.join(",\n"))
}
