//! The highlighting grammar of editors, held against the parser: what the parser takes for a
//! number, a function, a unit has to be coloured as one.

use crate::textmate;

use std::collections::BTreeSet;
use std::path::PathBuf;

use fancy_regex::Regex;
use librate::span::Span;
use librate_core::syntax::*;
use serde_json::Value;
use textmate::{Grammar, Scoped};

const FOLDER: &str = "editors/vscode";

fn json(name: &str) -> Value {
    let text = std::fs::read_to_string(format!("{FOLDER}/{name}")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn grammar() -> Grammar {
    Grammar::new(&json("librate.tmLanguage.json"))
}

struct Colours<'s> {
    source: &'s str,
    scopes: Vec<Scoped>,
}

impl<'s> Colours<'s> {
    fn new(grammar: &Grammar, source: &'s str) -> Self {
        let mut scopes = grammar.scopes(source);
        scopes.sort_by_key(|scoped| (scoped.start, scoped.end));
        Self { source, scopes }
    }

    /// The scopes that cover a place.
    fn at(&self, span: Span) -> Vec<&str> {
        let range = span.range();
        let last = self.scopes.partition_point(|scoped| scoped.start <= range.start);
        // No scope is longer than a line.
        let first = self.source[..range.start].rfind('\n').unwrap_or(0);
        let first = self.scopes.partition_point(|scoped| scoped.start < first);
        self.scopes[first..last]
            .iter()
            .filter(|scoped| scoped.end >= range.end)
            .map(|scoped| scoped.scope.as_str())
            .collect()
    }

    fn is(&self, span: Span, scope: &str) {
        let scopes = self.at(span);
        let (line, column) = span.line_column(self.source);
        assert!(
            scopes.iter().any(|one| one.starts_with(scope)),
            "{line}:{column} `{}` is {scopes:?}, not {scope}\n{}",
            &self.source[span.range()],
            self.source
        );
    }
}

fn word(at: u32, text: &str) -> Span {
    Span::new(at, at + text.len() as u32)
}

fn check(grammar: &Grammar, source: &str) {
    let file = parse(source).unwrap();
    let colours = Colours::new(grammar, source);
    let name = |name: &Name| colours.is(name.span, "entity.name.variable");
    let unit = |unit: &Option<UnitRef>| {
        if let Some(unit) = unit {
            let Span { start, .. } = file.unit(*unit).span;
            let text = source[file.unit(*unit).span.range()].trim_end();
            colours.is(word(start, text), "support.type.unit");
        }
    };
    for comment in &file.comments {
        let text = source[comment.span.range()].trim_end_matches('\r');
        let span = word(comment.span.start, text);
        colours.is(span, "comment.line");
        let inside = span.range();
        for scoped in &colours.scopes {
            let meets = scoped.start < inside.end && scoped.end > inside.start;
            let kind = scoped.scope.split('.').next().unwrap();
            let punctuation = scoped.scope.starts_with("punctuation.definition.comment");
            assert!(!meets || kind == "comment" || punctuation, "{} in a comment", scoped.scope);
        }
    }
    for statement in &file.statements {
        let start = statement.span.start;
        let first = STATEMENT_WORDS
            .into_iter()
            .filter(|word| source[start as usize..].starts_with(word))
            .max_by_key(|word| word.len())
            .unwrap();
        colours.is(word(start, first), "keyword.other.statement");
        match &statement.kind {
            StatementKind::Model { name: text } => name(text),
            StatementKind::Param(bindings) => {
                for binding in bindings {
                    name(&binding.name);
                    unit(&binding.unit);
                    indices(&file, &colours, binding.indices.as_deref());
                }
            }
            StatementKind::Let(binding)
            | StatementKind::Force(binding)
            | StatementKind::Guess { binding, .. }
            | StatementKind::Equilibrium { binding, .. } => {
                name(&binding.name);
                unit(&binding.unit);
                indices(&file, &colours, binding.indices.as_deref());
            }
            StatementKind::Coord { declarations } => {
                for declaration in declarations {
                    name(&declaration.name);
                    unit(&declaration.unit);
                    indices(&file, &colours, declaration.indices.as_deref());
                }
            }
            StatementKind::Constraint { indices: list, .. } | StatementKind::Draw { indices: list, .. } => {
                indices(&file, &colours, list.as_deref());
            }
            StatementKind::Table { name: text, path_span, .. } => {
                name(text);
                colours.is(*path_span, "string.quoted.double");
            }
            StatementKind::Kinetic(_)
            | StatementKind::Potential(_)
            | StatementKind::Lagrangian(_)
            | StatementKind::Dissipation(_)
            | StatementKind::Assume(_)
            | StatementKind::Period(_) => {}
        }
    }
    for expr in file.expressions.iter() {
        match &expr.kind {
            ExprKind::Number(_) => colours.is(expr.span, "constant.numeric"),
            ExprKind::Name(text) if *text == "t" => colours.is(expr.span, "variable.language"),
            ExprKind::Name(text) if *text == "pi" => colours.is(expr.span, "constant.language"),
            ExprKind::Name(text) if FUNCTIONS.contains(text) => {}
            ExprKind::Name(_) => colours.is(expr.span, "variable.other"),
            ExprKind::Field { field, .. } => colours.is(field.span, "variable.other.member"),
            ExprKind::Call { function, .. } => {
                let known = FUNCTIONS.contains(&function.text.as_str()) || function.text == "rows";
                let scope = if known { "support.function" } else { "variable.other" };
                colours.is(function.span, scope);
            }
            ExprKind::SumOver { indices: list, .. } | ExprKind::IntegralOver { indices: list, .. } => {
                let name = if matches!(expr.kind, ExprKind::SumOver { .. }) { "sum" } else { "integral" };
                colours.is(word(expr.span.start, name), "support.function");
                indices(&file, &colours, Some(list));
            }
            ExprKind::Prime(_) => {
                let end = expr.span.end;
                colours.is(Span::new(end - 1, end), "keyword.operator.derivative");
            }
            ExprKind::Negate(_) => {
                colours.is(word(expr.span.start, "-"), "keyword.operator.arithmetic");
            }
            ExprKind::Not(_) => colours.is(word(expr.span.start, "not"), "keyword.operator.word"),
            ExprKind::Index { .. }
            | ExprKind::Power { .. }
            | ExprKind::Product(_)
            | ExprKind::Sum(_)
            | ExprKind::Vector(_)
            | ExprKind::Compare { .. }
            | ExprKind::And(_)
            | ExprKind::Or(_) => {}
        }
    }
    // What the parser accepts is nowhere marked as wrong.
    for scoped in &colours.scopes {
        assert!(!scoped.scope.starts_with("invalid"), "{}", &source[scoped.start..scoped.end]);
    }
}

fn indices(file: &File, colours: &Colours<'_>, indices: Option<&Indices>) {
    for entry in indices.into_iter().flat_map(|indices| &indices.entries) {
        match &entry.kind {
            IndexKind::Member(_) => {}
            IndexKind::Range { variable, from, to } => {
                if let Some(variable) = variable {
                    colours.is(variable.span, "variable.parameter");
                }
                let (from, to) = (file.expr(*from).span.end, file.expr(*to).span.start);
                let gap = &colours.source[Span::new(from, to).range()];
                let dots = from + gap.find("..").unwrap() as u32;
                colours.is(word(dots, ".."), "keyword.operator.range");
            }
            IndexKind::Rows { variable, .. } => colours.is(variable.span, "variable.parameter"),
        }
    }
}

fn models(folders: &[&str]) -> Vec<PathBuf> {
    folders
        .iter()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "lag"))
        .collect()
}

#[test]
fn files_are_coloured_as_they_are_parsed() {
    let grammar = grammar();
    let mut count = 0;
    for path in models(&["models", "tests/language", "tests/syntax"]) {
        if let Ok(source) = std::fs::read_to_string(&path)
            && parse(&source).is_ok()
        {
            check(&grammar, &source);
            count += 1;
        }
    }
    assert!(count > 200, "{count}");
}

#[test]
fn corners_of_the_language() {
    let grammar = grammar();
    for source in [
        "param T1 : T = 300  param Vm : V*m^(1/2)/(kg*s)^-2 = 1e-3 ± 2E+5",
        "coord x : V, φ[1..2] : m T = x'^2 V = 1..2*x # T = 1".replace("1..2*x", "2*x").as_str(),
        "coord\n  a,\n  b # c, coord\n, Te : T\nlagrangian = a'*b' - Te",
        "let pin = sinus + t1 + int + 2*not_a + xsin",
        "let a = sum(b in bonds where not b.in == 1 and b.T < 3.5, b.sin*rows(bonds))",
        "table long = \"a # no comment\"  # a comment with \"quotes\"",
        "let ω0 = -[1, 2][1]''  equilibrium x' = 6.02e23",
        "let x[i in 1..n-1, 3] = y[i..1]".replace("[i..1]", "[i]").as_str(),
    ] {
        check(&grammar, source);
    }
}

#[test]
fn half_numbers_and_open_texts_are_marked() {
    let grammar = grammar();
    for (source, wrong) in [("let a = 1.", "1."), ("let a = .5", ".5"), ("table a = \"b", "\"b")] {
        let at = source.find(wrong).unwrap() as u32;
        Colours::new(&grammar, source).is(word(at, wrong), "invalid.illegal");
    }
}

/// The words that stand as alternatives in a pattern.
fn words(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => map.iter().for_each(|(key, inner)| match (key.as_str(), inner) {
            ("match" | "begin", Value::String(regex)) => {
                let list = Regex::new(r"\(([A-Za-z0-9_]+(?:\|[A-Za-z0-9_]+)*)\)").unwrap();
                for hit in list.captures_iter(regex) {
                    let hit = hit.unwrap();
                    let alternatives = hit.get(1).unwrap().as_str().split('|');
                    found.extend(alternatives.map(str::to_owned));
                }
            }
            _ => words(inner, found),
        }),
        Value::Array(list) => list.iter().for_each(|inner| words(inner, found)),
        _ => {}
    }
}

#[test]
fn the_words_are_those_of_the_language() {
    let json = json("librate.tmLanguage.json");
    let owned = |words: &[&str]| words.iter().map(|w| (*w).to_owned()).collect::<BTreeSet<_>>();
    let mut statements = BTreeSet::new();
    words(&json["repository"]["statements"], &mut statements);
    words(&json["repository"]["coordinates"], &mut statements);
    words(&json["repository"]["parameters"], &mut statements);
    assert_eq!(statements, owned(&STATEMENT_WORDS));
    let end = json["repository"]["coordinates"]["end"].as_str().unwrap();
    assert!(end.contains(&format!("(?:{})", STATEMENT_WORDS.join("|"))), "{end}");
    let mut functions = BTreeSet::new();
    words(&json["repository"]["functions"], &mut functions);
    let mut wanted = owned(&FUNCTIONS);
    wanted.extend(owned(&["sum", "integral", "rows"]));
    assert_eq!(functions, wanted);
}

#[test]
fn an_editor_finds_the_parts() {
    let package = json("package.json");
    let language = &package["contributes"]["languages"][0];
    let grammar = &package["contributes"]["grammars"][0];
    let named = |value: &Value| json(value.as_str().unwrap().trim_start_matches("./"));
    assert_eq!(language["extensions"][0], ".lag");
    assert_eq!(named(&grammar["path"])["scopeName"], grammar["scopeName"]);
    let configuration = named(&language["configuration"]);
    assert_eq!(configuration["comments"]["lineComment"], "#");
    assert_eq!(configuration["brackets"].as_array().unwrap().len(), 2);
    // What is declared is what the extension has.
    assert_eq!(package["version"], env!("CARGO_PKG_VERSION"));
    let script = std::fs::read_to_string(format!("{FOLDER}/{}", package["main"].as_str().unwrap())).unwrap();
    let command = package["contributes"]["commands"][0]["command"].as_str().unwrap();
    assert!(script.contains(&format!("registerCommand('{command}'")));
    let settings = package["contributes"]["configuration"]["properties"].as_object().unwrap();
    assert!(settings.keys().all(|own| script.contains(&format!("'{own}'"))));
}
