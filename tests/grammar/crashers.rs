//! What fuzzing has found stays found.
#![cfg(all(feature = "engine", feature = "format"))]

#[path = "../../fuzz/checks.rs"]
mod checks;

use librate::syntax::{FUNCTIONS, STATEMENT_WORDS};

/// Runs a check on all texts that are kept because they go ways of their own, and on all files that
/// once broke it.
fn replay(target: &str, check: fn(&str)) {
    let kept = std::fs::read_to_string(format!("fuzz/corpus/{target}.txt")).unwrap();
    let texts: Vec<&str> = kept.split("\u{1e}\n").collect();
    assert!(texts.len() > 300);
    for text in texts {
        let held = std::panic::catch_unwind(|| check(text));
        assert!(held.is_ok(), "{text:?}");
    }
    let folder = format!("fuzz/crashers/{target}");
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let kept = std::panic::catch_unwind(|| check(&text));
        assert!(kept.is_ok(), "{}", path.display());
    }
}

#[test]
fn parsing_holds() {
    replay("parse", checks::parse);
}

#[test]
fn layout_holds() {
    replay("format", checks::format);
}

#[test]
fn the_trip_holds() {
    replay("trip", checks::trip);
}

#[test]
fn the_dictionary_has_every_word() {
    let dictionary = std::fs::read_to_string("fuzz/librate.dict").unwrap();
    for word in STATEMENT_WORDS.iter().chain(&FUNCTIONS) {
        let line = format!("\"{word}\"");
        assert!(dictionary.lines().any(|own| own == line), "{line}");
    }
}
