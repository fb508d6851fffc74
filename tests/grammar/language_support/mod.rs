//! Reading expectations from headers, and the way from a file to its modes.

#![allow(dead_code)] // each test file uses its part

use std::path::Path;

use librate::diagnostic::Diagnostic;
use librate::linearize::{Linearized, linearize};
use librate::model::{Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::{NormalModes, normal_modes};
use librate::precision::Ball;
use librate::syntax::{StatementKind, parse};

/// What a header says.
#[derive(Default)]
pub(crate) struct Case {
    pub(crate) omega: Vec<String>,
    pub(crate) growth: Vec<String>,
    pub(crate) kinds: Vec<String>,
    pub(crate) symmetry: Vec<String>,
    pub(crate) equilibrium: Vec<String>,
    pub(crate) stability: Option<String>,
    pub(crate) settings: Vec<String>,
    pub(crate) same: Option<String>,
    pub(crate) error: Option<String>,
    pub(crate) at: Option<String>,
}

impl Case {
    pub(crate) fn read(path: &Path) -> Self {
        let text = String::from_utf8(std::fs::read(path).unwrap()).unwrap();
        let mut case = Self::default();
        for line in text.trim_start_matches('\u{feff}').lines() {
            let Some((word, value)) = line.trim().strip_prefix("# ").and_then(|line| line.split_once(": ")) else {
                continue;
            };
            let list = || value.split_whitespace().map(str::to_owned).collect();
            let text = value.trim().to_owned();
            match word {
                "omega" => case.omega = list(),
                "growth" => case.growth = list(),
                "kinds" => case.kinds = list(),
                "symmetry" => case.symmetry = list(),
                "equilibrium" => case.equilibrium = list(),
                "stability" => case.stability = Some(text),
                "set" => case.settings.push(text),
                "same" => case.same = Some(text),
                "error" => case.error = Some(text),
                "at" => case.at = Some(text),
                _ => {}
            }
        }
        case
    }
}

/// A model that came through.
pub(crate) struct Done {
    pub(crate) linearized: Linearized,
    pub(crate) normal: NormalModes,
}

/// Messages, each with `line:column` where it has a place.
pub(crate) struct Fault {
    pub(crate) messages: Vec<(String, Option<String>)>,
}

fn fault(source: &str, diagnostics: impl Iterator<Item = Diagnostic>) -> Fault {
    let messages = diagnostics.map(|diagnostic| {
        let place = diagnostic.primary.map(|label| {
            let (line, column) = label.span.line_column(source);
            format!("{line}:{column}")
        });
        (diagnostic.message, place)
    });
    Fault { messages: messages.collect() }
}

pub(crate) fn run(path: &Path, settings: &[String]) -> Result<Done, Fault> {
    let source = String::from_utf8(std::fs::read(path).unwrap()).unwrap();
    run_source(&source, path.parent(), settings, None)
}

pub(crate) fn run_with_table(source: &str, table: Option<&str>) -> Result<Done, Fault> {
    run_source(source, None, &[], table)
}

fn run_source(source: &str, folder: Option<&Path>, settings: &[String], table: Option<&str>) -> Result<Done, Fault> {
    let file = parse(source).map_err(|errors| fault(source, errors.iter().map(Diagnostic::from)))?;
    let mut tables = TableTexts::new();
    if let Some(table) = table {
        tables = tables.with("t.csv", table);
    }
    for statement in &file.statements {
        if let (StatementKind::Table { path, .. }, Some(folder)) = (&statement.kind, folder)
            && let Ok(csv) = std::fs::read_to_string(folder.join(path))
        {
            tables = tables.with(path.clone(), csv);
        }
    }
    let mut set = Settings::new();
    for setting in settings {
        set.add(setting).map_err(|error| fault(source, [Diagnostic::from(&error)].into_iter()))?;
    }
    let model = elaborate(&file, &tables, &set).map_err(|errors| fault(source, errors.iter().map(Diagnostic::from)))?;
    let linearized = linearize(model).map_err(|error| fault(source, [Diagnostic::from(&error)].into_iter()))?;
    let normal = normal_modes(&linearized, &Options::default())
        .map_err(|error| fault(source, [Diagnostic::from(&error)].into_iter()))?;
    Ok(Done { linearized, normal })
}

/// The conventions for vectors: xᵀMy is 1 or 0, and the first component within 1e-6 of the largest
/// is positive. Complex ones have xᴴMx = 1 and are not orthogonal to each other.
pub(crate) fn check_vectors(done: &Done) -> Vec<String> {
    let n = done.linearized.coordinates();
    if done.linearized.dimension() < n {
        // M is that of the directions that are left.
        let short = done.normal.modes.iter().position(|one| one.vector.len() != n);
        return short.map(|at| format!("vector {} is too short", at + 1)).into_iter().collect();
    }
    // Of all coordinates, those of equations of first order too.
    let mass =
        if done.linearized.is_constrained() { done.linearized.with_multipliers().mass } else { done.linearized.mass() };
    let mass: Vec<f64> = mass.iter().map(Ball::mid_f64).collect();
    let modes = &done.normal.modes;
    let mut faults = Vec::new();
    for (i, one) in modes.iter().enumerate() {
        if one.vector.len() != n {
            return vec![format!("vector {} has {} components", i + 1, one.vector.len())];
        }
        let times = |x: &[f64]| -> Vec<f64> {
            let row = |row| (0..n).map(|at| mass[row + n * at] * x[at]).sum();
            (0..n).map(row).collect()
        };
        let applied = times(&one.vector);
        if !one.imaginary.is_empty() {
            let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
            let other = times(&one.imaginary);
            let square = dot(&applied, &one.vector) + dot(&other, &one.imaginary);
            let size = |at: &usize| one.vector[*at].hypot(one.imaginary[*at]);
            let largest = (0..n).map(|at| size(&at)).fold(0.0, f64::max);
            // What has no inertia has a largest component of 1.
            let has_inertia = square > 1e-12 || (largest - 1.0).abs() > 1e-9;
            if has_inertia && (square - 1.0).abs() > 1e-9 + 1e3 * one.vector_error_bound {
                faults.push(format!("xᴴMx of {} is {square}", i + 1));
            }
            let lead = (0..n).find(|at| size(at) >= largest * (1.0 - 1e-6)).unwrap();
            if one.vector[lead] <= 0.0 || one.imaginary[lead] != 0.0 {
                faults.push(format!("vector {} has the wrong phase", i + 1));
            }
            continue;
        }
        for (j, other) in modes.iter().enumerate().take(i + 1) {
            if !other.imaginary.is_empty() {
                continue;
            }
            let product: f64 = applied.iter().zip(&other.vector).map(|(a, b)| a * b).sum();
            let want = if i == j { 1.0 } else { 0.0 };
            // Masses that differ by many decades leave more rounding in this sum than in x.
            let size: f64 = (0..n * n).map(|at| (mass[at] * one.vector[at % n] * other.vector[at / n]).abs()).sum();
            let reach = one.vector_error_bound.max(other.vector_error_bound);
            if (product - want).abs() > 1e-9 * size.max(1.0) + 1e3 * reach {
                faults.push(format!("xᵀMy of {} and {} is {product}", i + 1, j + 1));
            }
        }
        let largest = one.vector.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let lead = one.vector.iter().find(|x| x.abs() >= largest * (1.0 - 1e-6));
        if lead.is_some_and(|lead| *lead <= 0.0) {
            faults.push(format!("vector {} has the wrong sign", i + 1));
        }
    }
    faults
}
