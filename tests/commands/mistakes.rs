//! What people write who know other languages and the blackboard, with what is said of it and the text after all fixes
//! that can be made without asking; a fix never leaves a mistake in its place.

use std::fmt::Write;

use librate::diagnostic::{Diagnostic, Replacement, replaced};
use librate::model::{Settings, TableTexts, elaborate};
use librate::span::Span;
use librate::syntax::parse;

/// A model needs no more rounds: a mistake that hides another is found in the next one.
const ROUNDS: usize = 5;

fn mistakes(source: &str) -> Vec<Diagnostic> {
    let file = match parse(source) {
        Ok(file) => file,
        Err(errors) => return errors.iter().map(Diagnostic::from).collect(),
    };
    let errors = elaborate(&file, &TableTexts::new(), &Settings::new()).err().unwrap_or_default();
    errors.iter().map(Diagnostic::from).collect()
}

/// Applies a fix alone: nothing of the new text may be wrong, and all that was wrong elsewhere is so still, or solved.
fn check_alone(source: &str, change: &Replacement, before: &[Diagnostic]) {
    let text = replaced(source, [change]);
    let end = change.span.start + u32::try_from(change.text.len()).unwrap();
    let inside = Span::new(change.span.start, end);
    let others: Vec<String> = before.iter().map(|own| own.message.clone()).collect();
    for mistake in mistakes(&text) {
        let Some(label) = &mistake.primary else { continue };
        let within = label.span.start >= inside.start && label.span.end <= inside.end && inside.start < inside.end;
        let known = others.contains(&mistake.message);
        assert!(!within || known, "{:?} leaves `{}` in\n{text}", change, mistake.message);
    }
}

fn report(source: &str) -> String {
    let mut out = String::new();
    let mut text = source.to_owned();
    for round in 0..ROUNDS {
        let found = mistakes(&text);
        for own in &found {
            let place = own.primary.as_ref().map_or(Span::default(), |label| label.span);
            let (line, column) = place.line_column(&text);
            writeln!(out, "{line}:{column} «{}» {}: {}", &text[place.range()], own.code.unwrap(), own.message).unwrap();
            writeln!(out, "  help: {}", own.help.as_deref().unwrap_or("none")).unwrap();
            if let Some(change) = &own.replacement {
                writeln!(out, "  fix: «{}» -> «{}»", &text[change.span.range()], change.text).unwrap();
                check_alone(&text, change, &found);
            }
        }
        let changes: Vec<&Replacement> = found.iter().filter_map(|own| own.replacement.as_ref()).collect();
        if changes.is_empty() || round + 1 == ROUNDS {
            break;
        }
        text = replaced(&text, changes);
        writeln!(out, "---\n{text}---").unwrap();
    }
    out
}

#[test]
fn mistakes_of_other_languages_are_understood() {
    insta::with_settings!({ snapshot_path => "../mistakes", prepend_module_to_snapshot => false }, {
        insta::glob!("../mistakes", "*.lag", |path| {
            let source = std::fs::read_to_string(path).unwrap();
            insta::assert_snapshot!(report(&source));
        });
    });
}
