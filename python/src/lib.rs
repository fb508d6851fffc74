//! librate for Python: models, their commands and what these answer, as text, JSON and bytes. What a user of Python sees of it
//! is made in `librate/*.py`; no thread holds the interpreter while it computes.

mod answers;
mod commands;
mod job;
mod studies;

use librate::{explain, inertia, report, syntax};
use pyo3::prelude::*;

use answers::{Answer, Shown, digits};
use job::{Failure, Page};

/// The native half of the package.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::answers::{Derivation, Modes};
    #[pymodule_export]
    use super::commands::{
        all_equilibria, amplitudes, archive, check, derivation, modes, plot_modes, sensitivities, show, source_code,
        tensors,
    };
    #[pymodule_export]
    use super::job::Model;
    #[pymodule_export]
    use super::studies::{multipliers, periods, solve_sets, steady_response, sweep, trajectory};
    #[pymodule_export]
    use super::{body, codes, format, page, version};
}

/// A model in canonical layout.
#[pyfunction]
fn format(py: Python<'_>, text: String) -> PyResult<String> {
    let done = py.detach(|| syntax::format(&text).map_err(Failure::from));
    done.map_err(|told| told.raise(py, &Page { name: "model".to_owned(), text }))
}

/// The version of the package.
#[pyfunction]
fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}

/// All codes of errors and warnings.
#[pyfunction]
fn codes() -> Vec<&'static str> {
    explain::codes().collect()
}

/// The page on a code.
#[pyfunction]
fn page(code: &str) -> Option<&'static str> {
    explain::explain(code)
}

/// Mass, centre of mass and tensor of points (a CSV text) or of a mesh (the bytes of an STL file).
#[pyfunction]
fn body(
    py: Python<'_>,
    points: Option<String>,
    mesh: Option<Vec<u8>>,
    amount: Option<(bool, String)>,
    digits_wanted: i64,
) -> PyResult<Answer> {
    let text = points.clone().unwrap_or_default();
    let done = py.detach(|| -> Result<Answer, Failure> {
        let digits = digits(digits_wanted, answers::MOST_DIGITS)?;
        let amount = match amount {
            Some((true, mass)) => inertia::Amount::mass(&mass)?,
            Some((false, density)) => inertia::Amount::density(&density)?,
            None => inertia::Amount::default(),
        };
        let body = match (points, mesh) {
            (Some(points), _) => inertia::of_points(&points, digits)?,
            (None, mesh) => inertia::Mesh::read_stl(&mesh.unwrap_or_default())?.body(&amount, digits)?,
        };
        let text = report::body_text("body", &body, digits, &report::Style::default());
        Ok(Answer { json: report::body_json(&body, digits), text, warnings: Shown::default() })
    });
    done.map_err(|told| told.raise(py, &Page { name: "points".to_owned(), text }))
}
