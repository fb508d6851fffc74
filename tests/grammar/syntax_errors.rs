//! What is said about mistakes: one file a family of mistakes, its report next to it.

use librate::diagnostic::{Diagnostic, Severity};
use librate::span::Span;
use librate::syntax::parse;
use std::fmt::Write;

/// The report without drawing: a line a place, the line of the source above the first.
fn report(source: &str) -> String {
    let mut out = String::new();
    for error in parse(source).expect_err("the file has mistakes") {
        let diagnostic = Diagnostic::from(&error);
        assert_eq!(diagnostic.severity, Severity::Error);
        if let Some(label) = &diagnostic.primary {
            let (line, column) = label.span.line_column(source);
            let text: String = source.lines().nth(line - 1).unwrap_or("").chars().take(80).collect();
            writeln!(out, "{line} | {text}").unwrap();
            writeln!(out, "{line}:{column}{}: {}", shown(source, label.span), diagnostic.message).unwrap();
            writeln!(out, "  label: {}", label.text).unwrap();
        } else {
            writeln!(out, "{}", diagnostic.message).unwrap();
        }
        for label in &diagnostic.secondary {
            let (line, column) = label.span.line_column(source);
            writeln!(out, "  {line}:{column}{}: {}", shown(source, label.span), label.text).unwrap();
        }
        if let Some(help) = &diagnostic.help {
            writeln!(out, "  help: {help}").unwrap();
        }
        out.push('\n');
    }
    out
}

fn shown(source: &str, span: Span) -> String {
    let text: String = source[span.range()].escape_debug().take(40).collect();
    format!(" «{text}»")
}

#[test]
fn mistakes_are_explained() {
    insta::with_settings!({ snapshot_path => "../syntax_errors", prepend_module_to_snapshot => false }, {
        insta::glob!("../syntax_errors", "*.lag", |path| {
            let source = std::fs::read_to_string(path).unwrap();
            insta::assert_snapshot!(report(&source));
        });
    });
}

#[test]
fn overlong_words_are_shortened() {
    let text = format!("`{}` is not declared", "ü".repeat(100_000));
    let short = Diagnostic::global(text).message;
    assert!(short.chars().count() < 120, "{short}");
    assert!(short.starts_with("`üü") && short.ends_with("ü` is not declared"));
    let long = "a sentence of many short words ".repeat(10);
    assert_eq!(Diagnostic::global(long.clone()).message, long);
}
