//! The function whose arguments are being written. What is not complete can rarely be read, so that this is decided by the
//! letters before the place.

use librate::syntax::{STATEMENT_WORDS, signature};
use serde_json::{Value, json};

use super::complete::{is_letter, without_word};
use super::document::Document;

pub(super) fn help(document: &Document, at: usize) -> Value {
    let before = document.text.get(..at).unwrap_or_default();
    let Some((word, written)) = call(before) else { return Value::Null };
    let Some((call, meaning)) = signature(word) else { return Value::Null };
    let arguments = call.split_once('(').map_or("", |(_, rest)| rest.trim_end_matches(')'));
    let parameters: Vec<&str> = arguments.split(", ").collect();
    let labels: Vec<Value> = parameters.iter().map(|own| json!({"label": own})).collect();
    // Sums have as many indices as one likes.
    let active = written.min(parameters.len() - 1);
    json!({
        "signatures": [{"label": call, "documentation": meaning, "parameters": labels}],
        "activeSignature": 0,
        "activeParameter": active,
    })
}

/// The function of the innermost call that is open at the end of a text, and how many of its arguments are written.
fn call(before: &str) -> Option<(&str, usize)> {
    let (mut depth, mut commas) = (0_usize, 0);
    for (number, line) in before.rsplit('\n').enumerate() {
        let code = line.find('#').map_or(line, |start| &line[..start]);
        if number == 0 && code.len() < line.len() {
            return None;
        }
        for (place, letter) in code.char_indices().rev() {
            match letter {
                ')' | ']' => depth += 1,
                '(' | '[' if depth > 0 => depth -= 1,
                '(' => {
                    let called = code[..place].trim_end();
                    let word = &called[without_word(called).len()..];
                    if signature(word).is_some() {
                        return Some((word, commas));
                    }
                    commas = 0;
                }
                '[' => commas = 0,
                ',' if depth == 0 => commas += 1,
                _ => {}
            }
        }
        // What stands above belongs to another statement.
        let word = code.trim_start();
        let word = &word[..word.find(|c| !is_letter(c)).unwrap_or(word.len())];
        if STATEMENT_WORDS.contains(&word) {
            return None;
        }
    }
    None
}
