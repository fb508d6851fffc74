//! The peers in Python: numpy, scipy with LAPACK and ARPACK, mpmath, python-flint.

use std::path::Path;

use librate::number::Number;
use serde_json::{Value, json};

use super::case::Case;
use super::judge;
pub(crate) use super::process::Peers;

impl Peers {
    pub(crate) fn set(&mut self, case: &Case) -> Result<(), String> {
        let [mass_text, stiffness_text] = case.texts.clone().unwrap_or_default();
        self.ask(&json!({"case": {
            "n": case.n,
            "singular": case.zeros() > 0,
            "mass": case.mass,
            "stiffness": case.stiffness,
            "mass_text": mass_text,
            "stiffness_text": stiffness_text,
        }}))
    }

    /// M and K in a file for NumPy, of which so many of the lowest modes are wanted.
    pub(crate) fn set_large(&mut self, file: &Path, count: usize, singular: bool) -> Result<(), String> {
        self.ask(&json!({"large": {"file": file, "count": count, "singular": singular}}))
    }

    /// CPU seconds and rising eigenvalues.
    ///
    /// # Errors
    /// What the peer says where it gives up.
    pub(crate) fn run(&mut self, peer: &str, patience: f64) -> Result<(f64, Vec<Number>), String> {
        self.ask(&json!({"run": peer, "patience": patience}))?;
        let answer = self.answer()?;
        let seconds = answer["seconds"].as_f64();
        let values = answer["values"].as_array();
        let (Some(seconds), Some(values)) = (seconds, values) else {
            return Err("no values".to_owned());
        };
        let parse = |value: &Value| value.as_str().and_then(judge::parse);
        let values: Option<Vec<Number>> = values.iter().map(parse).collect();
        Ok((seconds, values.ok_or("not a number")?))
    }
}
