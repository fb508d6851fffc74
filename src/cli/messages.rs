//! Diagnostics for programs: one JSON object a line.

use librate::diagnostic::{Diagnostic, Label, Severity};
use librate::span::Span;
use serde_json::{Value, json};

use super::input::Source;
use super::output::visible_json;

/// Where the lines of a text begin, so that every place is found without reading it again.
struct Lines<'a> {
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        let mut starts = vec![0];
        starts.extend(text.match_indices('\n').map(|(at, _)| at + 1));
        Self { text, starts }
    }

    /// Line and column, from 1; columns count characters.
    fn place(&self, at: u32) -> (usize, usize) {
        let mut at = (at as usize).min(self.text.len());
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        let line = self.starts.partition_point(|start| *start <= at);
        let start = self.starts[line - 1];
        let before = self.text[start..at].trim_start_matches('\u{feff}');
        (line, before.chars().count() + 1)
    }

    fn label(&self, label: &Label) -> Value {
        let Span { start, end } = label.span;
        let (line, column) = self.place(start);
        let (end_line, end_column) = self.place(end);
        json!({
            "label": label.text,
            "start": start,
            "end": end,
            "line": line,
            "column": column,
            "end_line": end_line,
            "end_column": end_column,
        })
    }
}

fn object(
    severity: &str,
    code: Option<&str>,
    message: &str,
    help: Option<&str>,
    file: Option<&str>,
    places: (Value, Vec<Value>),
) -> String {
    let (primary, secondary) = places;
    let value = json!({
        "severity": severity,
        "code": code,
        "message": message,
        "file": file,
        "primary": primary,
        "secondary": secondary,
        "help": help,
    });
    format!("{}\n", visible_json(&value.to_string()))
}

/// All diagnostics, one JSON object a line, in the order given.
pub(crate) fn diagnostics(source: &Source, all: &[Diagnostic]) -> String {
    let lines = Lines::new(&source.text);
    all.iter()
        .map(|one| {
            let primary = one.primary.as_ref().map_or(Value::Null, |label| lines.label(label));
            let secondary = one.secondary.iter().map(|label| lines.label(label)).collect();
            object(
                one.severity.as_str(),
                one.code,
                &one.message,
                one.help.as_deref(),
                Some(&source.name),
                (primary, secondary),
            )
        })
        .collect()
}

/// A message that is not about a place in a model.
pub(crate) fn message(text: &str, help: Option<&str>) -> String {
    object(Severity::Error.as_str(), None, text, help, None, (Value::Null, Vec::new()))
}

/// A line that tells how something is computed.
pub(crate) fn note(text: &str) -> String {
    object("note", None, text, None, None, (Value::Null, Vec::new()))
}
