//! Lists the statements and names of a model file: what an editor or another tool can do with the
//! parser alone.
//!
//! ```text
//! cargo run --no-default-features --example embed_parser models/three_pendulums.lag
//! ```
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use std::process::ExitCode;

use librate::diagnostic::Diagnostic;
use librate::syntax::{self, Statement, StatementKind, print_statement};

fn main() -> ExitCode {
    let Some(path) = std::env::args().nth(1) else {
        println!("usage: embed_parser FILE");
        return ExitCode::from(2);
    };
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) => {
            println!("{path}: {error}");
            return ExitCode::FAILURE;
        }
    };
    match syntax::parse(&text) {
        Ok(file) => {
            for statement in &file.statements {
                let (line, _) = statement.span.line_column(&text);
                let (word, names) = gives(statement);
                println!("{line:4}  {word:12} {}", names.join(", "));
                println!("      | {}", print_statement(&file, statement).trim_end());
            }
            ExitCode::SUCCESS
        }
        Err(errors) => {
            for error in &errors {
                let diagnostic = Diagnostic::from(error);
                let place = diagnostic.primary.map(|label| label.span.line_column(&text));
                let (line, column) = place.unwrap_or((1, 1));
                println!("{path}:{line}:{column}: {}", diagnostic.message);
            }
            ExitCode::FAILURE
        }
    }
}

/// The word of a statement and the names that it gives something to.
fn gives(statement: &Statement) -> (&'static str, Vec<&str>) {
    match &statement.kind {
        StatementKind::Model { name } => ("model", vec![&name.text]),
        StatementKind::Param(bindings) => ("param", bindings.iter().map(|one| one.name.text.as_str()).collect()),
        StatementKind::Coord { declarations } => {
            let names = declarations.iter().map(|one| one.name.text.as_str());
            ("coord", names.collect())
        }
        StatementKind::Let(binding) => ("let", vec![&binding.name.text]),
        StatementKind::Kinetic(_) => ("T", Vec::new()),
        StatementKind::Potential(_) => ("V", Vec::new()),
        StatementKind::Lagrangian(_) => ("lagrangian", Vec::new()),
        StatementKind::Dissipation(_) => ("dissipation", Vec::new()),
        StatementKind::Force(binding) => ("force", vec![&binding.name.text]),
        StatementKind::Assume(_) => ("assume", Vec::new()),
        StatementKind::Constraint { .. } => ("constraint", Vec::new()),
        StatementKind::Guess { binding, .. } => ("guess", vec![&binding.name.text]),
        StatementKind::Equilibrium { binding, .. } => ("equilibrium", vec![&binding.name.text]),
        StatementKind::Period(_) => ("period", Vec::new()),
        StatementKind::Draw { drawn, .. } => ("draw", vec![drawn.as_str()]),
        StatementKind::Table { name, .. } => ("table", vec![&name.text]),
    }
}
