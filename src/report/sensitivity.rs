//! How frequencies change with parameters, as text and as JSON.

use std::fmt::Write;

use super::json::{modes_with, null, number, string};
use super::table::{Column, draw};
use super::{Style, Tone, Written, headline, listed};
use crate::linearize::Linearized;
use crate::modes::Options;
use crate::oscillation::NormalModes;
use crate::precision::Ball;
use crate::sensitivity::Sensitivities;

/// Digits of a derivative in a table.
const DIGITS: usize = 6;

/// Beside the frequencies at most so many parameters have columns of their own.
const MOST_COLUMNS: usize = 6;

/// The modes as [`super::modes_json`] has them, each with `derivatives`: d omega / d parameter by the name of the parameter,
/// `null` where there is none; and `growth_derivatives` where some growth is not 0. `omega_sigma` where parameters have
/// uncertainties.
#[must_use]
pub fn sensitivity_json(
    linearized: &Linearized,
    modes: &NormalModes,
    sensitivities: &Sensitivities,
    options: &Options,
) -> String {
    let model = linearized.model();
    let sigmas = sensitivities.omega_sigma(linearized);
    let grows = modes.modes.iter().any(|mode| !mode.growth.is_zero());
    let object = |derivatives: &[Option<Ball>]| {
        let fields: Vec<String> = sensitivities
            .parameters
            .iter()
            .zip(derivatives)
            .map(|(parameter, derivative)| {
                let name = string(&model.parameters[*parameter].name);
                // What can't be told from 0 is none.
                let value = derivative.map(|own| {
                    if own.contains_zero() {
                        0.0
                    } else {
                        own.mid_f64()
                    }
                });
                format!("{name}: {}", value.map_or_else(null, number))
            })
            .collect();
        format!("{{{}}}", fields.join(", "))
    };
    modes_with(linearized, modes, options, &|at| {
        let mut more = format!(", \"derivatives\": {}", object(&sensitivities.omega[at]));
        if grows {
            let _ = write!(
                more,
                ", \"growth_derivatives\": {}",
                object(&sensitivities.growth[at])
            );
        }
        if let Some(sigmas) = &sigmas {
            more.push_str(&sigma_field(sigmas[at]));
        }
        more
    })
}

/// `omega_sigma` of a mode.
fn sigma_field(sigma: Option<f64>) -> String {
    format!(", \"omega_sigma\": {}", sigma.map_or_else(null, number))
}

/// The modes as [`super::modes_json`] has them, with the uncertainty of each omega that those of the parameters give.
#[must_use]
pub fn modes_json_with_sigma(
    linearized: &Linearized,
    modes: &NormalModes,
    sigmas: &[Option<f64>],
    options: &Options,
) -> String {
    modes_with(linearized, modes, options, &|at| {
        sigma_field(sigmas.get(at).copied().flatten())
    })
}

/// The frequencies and their derivatives as a table to read.
#[must_use]
pub fn sensitivity_text(
    linearized: &Linearized,
    modes: &NormalModes,
    sensitivities: &Sensitivities,
    options: &Options,
    style: &Style,
) -> String {
    let model = linearized.model();
    let count = linearized.dimension();
    let mut out = style.paint(Tone::Heading, &headline(model.name.as_deref(), count));
    out.push_str("\n\n");
    let written = |value: Option<Ball>| match value {
        None => "none".to_owned(),
        Some(value) if value.contains_zero() => "0".to_owned(),
        Some(value) => Written::new(&value, DIGITS).text(),
    };
    let omega = modes.modes.iter().map(|mode| {
        let precise = mode.precise.as_deref().map(|precise| &precise.omega);
        Written::finest(&mode.omega, precise, options.digits).text()
    });
    let numbers = (1..=modes.modes.len()).map(|at| at.to_string()).collect();
    let mut columns = vec![
        Column::right("mode", numbers),
        Column::numbers("omega", omega.collect()),
    ];
    if let Some(sigmas) = sensitivities.omega_sigma(linearized) {
        let cells = sigmas
            .into_iter()
            .map(|sigma| written(sigma.map(Ball::from)));
        columns.push(Column::numbers("sigma", cells.collect()));
    }
    let names: Vec<&str> = sensitivities
        .parameters
        .iter()
        .map(|parameter| model.parameters[*parameter].name.as_str())
        .collect();
    let used: usize = columns.iter().map(Column::width).sum();
    let own: Vec<Column> = names
        .iter()
        .enumerate()
        .map(|(at, name)| {
            let cells = sensitivities.omega.iter().map(|row| written(row[at]));
            Column::numbers(&format!("d/d {name}"), cells.collect())
        })
        .collect();
    let width: usize = own.iter().map(Column::width).sum();
    if names.len() <= MOST_COLUMNS && used + width <= style.width + super::table::GAP {
        columns.extend(own);
        out.push_str(&draw(&columns, modes.modes.len(), |_| None, style));
        return out;
    }
    out.push_str(&draw(&columns, modes.modes.len(), |_| None, style));
    out.push_str("\nd omega / d parameter\n");
    for (at, row) in sensitivities.omega.iter().enumerate() {
        let items: Vec<String> = names
            .iter()
            .zip(row)
            .map(|(name, value)| format!("{name} {}", written(*value)))
            .collect();
        out.push_str(&listed(&format!("mode {}", at + 1), &items, style.width));
    }
    out
}
