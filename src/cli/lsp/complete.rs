//! What may be written at a place. The statement that is being written can rarely be read, so that this is decided by the
//! letters before the place.

use std::collections::HashSet;

use librate::model;
use librate::syntax::{self, Drawn, NameKind, STATEMENT_WORDS, signature};
use serde_json::{Value, json};

use super::check::Facts;
use super::document::Document;

/// The kinds of the protocol.
const FUNCTION: u8 = 3;
const FIELD: u8 = 5;
const VARIABLE: u8 = 6;
const UNIT: u8 = 11;
const KEYWORD: u8 = 14;
const CONSTANT: u8 = 21;

pub(super) fn completion(document: &Document, facts: &Facts, at: usize) -> Value {
    let before = document.text.get(..at).unwrap_or_default();
    let line = before.rsplit('\n').next().unwrap_or_default();
    // Nothing is to be written for somebody in a comment or a path.
    if line.contains('#') || line.matches('"').count() % 2 == 1 {
        return json!([]);
    }
    let (before, line) = (without_word(before), without_word(line));
    if let Some(row) = before.strip_suffix('.').filter(|row| !row.ends_with('.')) {
        return columns(row, facts);
    }
    if is_unit(line) {
        let units = model::units_with_prefixes().map(|name| {
            let detail = model::unit_dimension(&name).map(|own| own.to_string());
            json!({"label": name, "kind": UNIT, "detail": detail})
        });
        return units.collect();
    }
    if line.trim() == "draw" {
        return Drawn::ALL.map(|own| json!({"label": own.as_str(), "kind": KEYWORD})).into_iter().collect();
    }
    let mut all = Vec::new();
    if line.trim().is_empty() || line.trim_end().ends_with(';') {
        all.extend(STATEMENT_WORDS.map(|word| json!({"label": word, "kind": KEYWORD})));
    }
    let mut seen = HashSet::new();
    for name in syntax::names(&document.file) {
        if name.kind == NameKind::Quantity && name.is_declaration && seen.insert(name.text) {
            let value = facts.values.get(name.text).and_then(|own| own.first()).map(|(_, digits)| digits);
            let dimension = facts.dimensions.get(name.text).map(ToString::to_string);
            let detail: Vec<String> = value.cloned().into_iter().chain(dimension).collect();
            all.push(json!({"label": name.text, "kind": VARIABLE, "detail": detail.join(", ")}));
        }
    }
    for name in syntax::FUNCTIONS.into_iter().chain(["sum", "integral", "rows"]) {
        let (call, meaning) = signature(name).unwrap_or_default();
        all.push(json!({"label": name, "kind": FUNCTION, "detail": call, "documentation": meaning}));
    }
    all.push(json!({"label": "pi", "kind": CONSTANT, "detail": "3.14159…"}));
    all.push(json!({"label": "t", "kind": CONSTANT, "detail": "the time"}));
    Value::Array(all)
}

pub(in crate::cli) fn is_letter(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

pub(in crate::cli) fn without_word(text: &str) -> &str {
    text.trim_end_matches(is_letter)
}

/// Whether a unit is being written: behind a colon, with nothing but a unit since.
pub(in crate::cli) fn is_unit(line: &str) -> bool {
    let Some((_, unit)) = line.rsplit_once(':') else { return false };
    unit.chars().all(|c| is_letter(c) || " */^()-".contains(c))
}

/// The columns of the table whose row stands before the point: `b`, an index of rows, or `bonds[3]`.
fn columns(row: &str, facts: &Facts) -> Value {
    let word = |text: &str| text[without_word(text).len()..].to_owned();
    let table = match row.strip_suffix(']').and_then(|inside| inside.rfind('[')) {
        Some(open) => word(&row[..open]),
        None => {
            let index = format!("{} in ", word(row));
            let found = row.match_indices(&index).filter(|(at, _)| !row[..*at].ends_with(is_letter)).last();
            found.map_or("", |(at, _)| &row[at + index.len()..]).chars().take_while(|c| is_letter(*c)).collect()
        }
    };
    let columns = facts.columns.get(&table).into_iter().flatten();
    columns.map(|name| json!({"label": name, "kind": FIELD, "detail": format!("column of {table}")})).collect()
}
