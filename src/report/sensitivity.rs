//! How frequencies change with parameters, as text and as JSON.

use std::fmt::Write;

use super::json::{modes_with, null, number, record};
use super::modes::heading;
use super::plain::wrapped;
use super::table::{Column, draw};
use super::{Exponent, Style, Tone, UNDECIDED, Written, listed, nearest, nearest_bound};
use librate_core::linearize::Linearized;
use librate_core::modes::Options;
use librate_core::oscillation::NormalModes;
use librate_core::precision::{Ball, one_digit_up_text};
use librate_studies::sensitivity::Sensitivities;

/// Beside the frequencies at most so many parameters have columns of their own.
const MOST_COLUMNS: usize = 6;

/// The modes as [`super::modes_json`] has them, each with `derivatives`: d omega / d parameter by the name of the parameter,
/// `null` where there is none, and `derivative_error_bounds` of them; and `growth_derivatives` with their
/// bounds where some growth is not 0, or ceases to be.
#[must_use]
pub fn sensitivity_json(
    linearized: &Linearized,
    modes: &NormalModes,
    sensitivities: &Sensitivities,
    options: &Options,
) -> String {
    let model = linearized.model();
    let grows = grows(modes, sensitivities);
    let object = |derivatives: &[Option<Ball>], part: fn(&Ball) -> f64| {
        let fields = sensitivities.parameters.iter().zip(derivatives);
        record(fields.map(|(parameter, derivative)| {
            let value = derivative.as_ref().map(part);
            (&model.parameters[*parameter].name, value.map_or_else(null, number))
        }))
    };
    let both = |more: &mut String, names: [&str; 2], derivatives: &[Option<Ball>]| {
        for (name, part) in names.into_iter().zip([nearest, nearest_bound]) {
            let _ = write!(more, ", \"{name}\": {}", object(derivatives, part));
        }
    };
    modes_with(linearized, modes, options, &|at| {
        let mut more = String::new();
        let names = ["derivatives", "derivative_error_bounds"];
        both(&mut more, names, &sensitivities.omega[at]);
        if grows {
            let names = ["growth_derivatives", "growth_derivative_error_bounds"];
            both(&mut more, names, &sensitivities.growth[at]);
        }
        more
    })
}

/// The frequencies and their derivatives as a table to read, and the growths likewise where some is not 0, or ceases to be.
#[must_use]
pub fn sensitivity_text(
    linearized: &Linearized,
    modes: &NormalModes,
    sensitivities: &Sensitivities,
    options: &Options,
    style: &Style,
) -> String {
    let model = linearized.model();
    let mut out = style.paint(Tone::Heading, &heading(linearized)) + "\n\n";
    let rows: Vec<Exponent> = modes.modes.iter().map(|mode| Exponent::new(mode, options.digits)).collect();
    let uncertain = modes.modes.iter().any(|mode| mode.uncertainty.is_some());
    let names: Vec<&str> =
        sensitivities.parameters.iter().map(|parameter| model.parameters[*parameter].name.as_str()).collect();
    let column =
        |heading: &str, of: &dyn Fn(&Exponent) -> String| Column::numbers(heading, rows.iter().map(of).collect());
    let sigma = |of: &dyn Fn(&Exponent) -> String| uncertain.then(|| column("sigma", of));
    let omega = [Some(column("omega", &|row| row.omega.text())), sigma(&|row| row.omega_sigma.clone())];
    out.push_str(&table("omega", omega, &names, &sensitivities.omega, options.digits, style));
    if grows(modes, sensitivities) {
        let growth = [Some(column("growth", &|row| row.growth.text())), sigma(&|row| row.growth_sigma.clone())];
        out.push('\n');
        out.push_str(&table("growth", growth, &names, &sensitivities.growth, options.digits, style));
    }
    out
}

/// Whether some growth is not 0, or ceases to be.
fn grows(modes: &NormalModes, sensitivities: &Sensitivities) -> bool {
    let begins = |own: &Ball| !own.contains_zero();
    modes.modes.iter().any(|mode| !mode.growth.is_zero()) || sensitivities.growth.iter().flatten().flatten().any(begins)
}

/// What each mode has, and its derivatives by all parameters.
fn table(
    what: &str,
    own: [Option<Column>; 2],
    names: &[&str],
    derivatives: &[Vec<Option<Ball>>],
    digits: usize,
    style: &Style,
) -> String {
    let written = |value: Option<Ball>| match value {
        None => "none".to_owned(),
        Some(value) if value.is_zero() => "0".to_owned(),
        Some(value) if value.contains_zero() => UNDECIDED.to_owned(),
        Some(value) => Written::new(&value, digits).text(),
    };
    let count = derivatives.len();
    let mut columns = vec![Column::counting("mode", count)];
    columns.extend(own.into_iter().flatten());
    let used: usize = columns.iter().map(Column::width).sum();
    let by_parameter: Vec<Column> = names
        .iter()
        .enumerate()
        .map(|(at, name)| {
            let cells = derivatives.iter().map(|row| written(row[at]));
            Column::numbers(&format!("d/d {name}"), cells.collect())
        })
        .collect();
    let width: usize = by_parameter.iter().map(Column::width).sum();
    let fits = names.len() <= MOST_COLUMNS && used + width <= style.width + super::table::GAP;
    columns.extend(by_parameter.into_iter().filter(|_| fits));
    let mut out = draw(&columns, count, |_| None, style);
    if !fits {
        out.push_str(&format!("\nd {what} / d parameter\n"));
    }
    for (at, row) in derivatives.iter().enumerate().filter(|_| !fits) {
        let items: Vec<String> =
            names.iter().zip(row).map(|(name, value)| format!("{name} {}", written(*value))).collect();
        out.push_str(&listed(&format!("mode {}", at + 1), &items, style.width));
    }
    out.push_str(&remark(names, derivatives, style.width));
    let is_short = |own: &Ball| !own.contains_zero() && !Written::new(own, digits).complete;
    if derivatives.iter().flatten().flatten().any(is_short) {
        let words = format!("fewer than {digits} digits of some derivatives: only those that are certain are printed");
        out.push_str(&format!("\n{}\n", wrapped(&words, style.width).join("\n")));
    }
    out
}

/// How near to 0 what is written as [`UNDECIDED`] is, by parameter; nothing where it is not written.
fn remark(names: &[&str], derivatives: &[Vec<Option<Ball>>], width: usize) -> String {
    let items: Vec<String> = names
        .iter()
        .enumerate()
        .filter_map(|(at, name)| {
            let column = derivatives.iter().filter_map(|row| row[at]);
            let undecided = column.filter(|own| own.contains_zero() && !own.is_zero());
            let most = undecided.map(|own| own.abs_upper()).fold(0.0, f64::max);
            (most > 0.0).then(|| format!("{name} {}", one_digit_up_text(most)))
        })
        .collect();
    if items.is_empty() {
        return String::new();
    }
    let what = format!("{UNDECIDED} is 0 or near, at most");
    format!("\n{}", listed(&what, &items, width))
}
