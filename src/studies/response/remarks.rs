//! What is to be said of a response beside its numbers.

use super::{Response, Value};
use librate_core::diagnostic::Diagnostic;

/// Which values a remark is about.
type IsMeant = fn(&Value) -> bool;

impl Response {
    /// Warnings: where values are no numbers, and that an equilibrium is not proved.
    #[must_use]
    pub fn remarks(&self) -> Vec<Diagnostic> {
        const MOST: usize = 3;
        let mut all = Vec::new();
        let wanted: [(IsMeant, &str, &str); 2] = [
            (
                |value| matches!(value, Value::Infinite),
                "the response is infinite: an undamped resonance",
                "there is no steady motion at this frequency: the force feeds the mode without end",
            ),
            (
                |value| matches!(value, Value::Undecided),
                "the response is not decided",
                "bounds do not tell it from a resonance or from 0: its cells are empty",
            ),
        ];
        for (is_meant, what, help) in wanted {
            let hit = |at: &usize| self.outputs.iter().any(|output| is_meant(&output.values[*at]));
            let places: Vec<usize> = (0..self.places.len()).filter(hit).collect();
            if places.is_empty() {
                continue;
            }
            let named: Vec<String> = places.iter().take(MOST).map(|at| self.places[*at].to_string()).collect();
            let more = if places.len() > MOST { format!(" and {} more", places.len() - MOST) } else { String::new() };
            let message = format!("at {} = {}{more} {what}", self.name, named.join(", "));
            all.push(Diagnostic::remark(message).with_help(help));
        }
        if !self.proved {
            let remark = Diagnostic::remark("the existence of the equilibrium is not proved");
            all.push(
                remark.with_help("its place is an estimate, and the digits of the response do not cover its error"),
            );
        }
        all
    }
}
