//! Diagnostics for programs: one JSON object a line.

use librate::diagnostic::{Diagnostic, Label, Replacement, Severity};
use librate::span::Span;
use serde_json::{Value, json};

use super::input::Source;
use super::output::visible_json;

/// Where the lines of a text begin, so that every place is found without reading it again.
pub(super) struct Lines<'a> {
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> Lines<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        Self { text, starts }
    }

    /// The line, from 1, and what stands on it before a place.
    fn before(&self, at: u32) -> (usize, &'a str) {
        let mut at = (at as usize).min(self.text.len());
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        let line = self.starts.partition_point(|start| *start <= at);
        (line, &self.text[self.starts[line - 1]..at])
    }

    /// Line and column, from 1; columns count characters.
    fn place(&self, at: u32) -> (usize, usize) {
        let (line, before) = self.before(at);
        (line, before.trim_start_matches('\u{feff}').chars().count() + 1)
    }

    /// A place as editors count: lines from 0, columns in units of UTF-16.
    pub(super) fn position(&self, at: u32) -> Value {
        let (line, before) = self.before(at);
        json!({"line": line - 1, "character": before.encode_utf16().count()})
    }

    /// Start and end as editors count.
    pub(super) fn range(&self, span: Span) -> Value {
        json!({"start": self.position(span.start), "end": self.position(span.end)})
    }

    /// The offset of a place as editors count; what is behind the end of a line is its end.
    pub(super) fn offset(&self, position: &Value) -> usize {
        let count = |field: &str| usize::try_from(position[field].as_u64().unwrap_or(0)).unwrap_or(usize::MAX);
        let Some(start) = self.starts.get(count("line")) else { return self.text.len() };
        let line = self.text[*start..].lines().next().unwrap_or_default();
        let mut left = count("character");
        for (at, letter) in line.char_indices() {
            match left.checked_sub(letter.len_utf16()) {
                Some(rest) if left > 0 => left = rest,
                _ => return start + at,
            }
        }
        start + line.len()
    }

    /// A place in the text, with what is to be said or written there.
    fn at(&self, span: Span, key: &str, text: &str) -> Value {
        let Span { start, end } = span;
        let (line, column) = self.place(start);
        let (end_line, end_column) = self.place(end);
        json!({
            key: text,
            "start": start,
            "end": end,
            "line": line,
            "column": column,
            "end_line": end_line,
            "end_column": end_column,
        })
    }
}

/// A message that is about no place.
fn object(severity: &str, code: Option<&str>, message: &str, help: Option<&str>) -> Value {
    json!({
        "severity": severity,
        "code": code,
        "message": message,
        "file": null,
        "primary": null,
        "secondary": [],
        "help": help,
        "replacement": null,
    })
}

fn line(object: &Value) -> String {
    format!("{}\n", visible_json(&object.to_string()))
}

/// All diagnostics, one JSON object a line, in the order given.
pub(crate) fn diagnostics(source: &Source, all: &[Diagnostic]) -> String {
    let lines = Lines::new(&source.text);
    all.iter()
        .map(|one| {
            let label = |own: &Label| lines.at(own.span, "label", &own.text);
            let changed = |own: &Replacement| lines.at(own.span, "text", &own.text);
            let mut told = object(one.severity.as_str(), one.code, &one.message, one.help.as_deref());
            told["file"] = json!(source.name);
            told["primary"] = one.primary.as_ref().map_or(Value::Null, label);
            told["secondary"] = one.secondary.iter().map(label).collect();
            told["replacement"] = one.replacement.as_ref().map_or(Value::Null, changed);
            line(&told)
        })
        .collect()
}

/// A message that is not about a place in a model.
pub(crate) fn message(text: &str, help: Option<&str>) -> String {
    line(&object(Severity::Error.as_str(), None, text, help))
}

/// A line that tells how something is computed.
pub(crate) fn note(text: &str) -> String {
    line(&object("note", None, text, None))
}
