//! The grammar for tree-sitter, held against the parser.

use crate::syntax_random::{alphabet, changed};
use crate::syntax_trees::{Planter, bounds};

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use fancy_regex::Regex;
use librate_core::syntax::*;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use tree_sitter::{Language, Parser, Query, QueryCursor, StreamingIterator, Tree};

const FOLDER: &str = "editors/tree-sitter-librate";

fn language() -> Language {
    tree_sitter_librate::LANGUAGE.into()
}

fn tree(text: &str) -> Tree {
    let mut parser = Parser::new();
    parser.set_language(&language()).unwrap();
    parser.parse(text, None).unwrap()
}

fn models(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            models(&path, found);
        } else if path.extension().is_some_and(|end| end == "lag") {
            found.push(path);
        }
    }
}

/// Every model file of the project, right or wrong.
fn files() -> Vec<PathBuf> {
    let mut found = Vec::new();
    ["models", "tests", "docs", "examples"].iter().for_each(|folder| models(Path::new(folder), &mut found));
    found.sort();
    found
}

#[test]
fn both_grammars_are_one_language() {
    let mut texts: Vec<String> = files().iter().map(|path| std::fs::read_to_string(path).unwrap()).collect();
    assert!(texts.len() > 700);
    let mut runner = TestRunner::deterministic();
    for _ in 0..400 {
        let mut planter = Planter::default();
        planter.statements(&bounds().new_tree(&mut runner).unwrap().current());
        texts.push(print_file(&planter.file));
        texts.push(changed().new_tree(&mut runner).unwrap().current());
        let words = proptest::collection::vec(alphabet(), 1..6).new_tree(&mut runner).unwrap().current();
        texts.push(format!("coord x let a = {}", words.join(" ")));
    }
    let mut wrong = 0;
    let mut right = 0;
    for text in &texts {
        match (parse(text), tree(text).root_node().has_error()) {
            (Ok(_), is_wrong) => {
                assert!(!is_wrong, "tree-sitter does not read\n{text}");
                right += 1;
            }
            (Err(_), true) => wrong += 1,
            // What no grammar says: functions and `t` are reserved, conditions stand in filters, a blank before a parenthesis
            // only behind functions, letters are those that they look like, and nothing nests too deep.
            (Err(errors), false) => {
                let is_beyond = |own: &SyntaxError| {
                    matches!(
                        own,
                        SyntaxError::ReservedName { .. }
                            | SyntaxError::ConditionOutsideFilter { .. }
                            | SyntaxError::MissingMultiplication { .. }
                            | SyntaxError::NestingTooDeep { .. }
                            | SyntaxError::UnusualLetter { .. }
                    )
                };
                assert!(errors.iter().all(is_beyond), "tree-sitter reads\n{text}\n{errors:#?}");
            }
        }
    }
    // Neither is a matter of a few.
    assert!(right > 1000 && wrong > 700, "{right} {wrong}");
}

#[test]
fn names_have_the_colours_of_what_they_are() {
    let query = std::fs::read_to_string(format!("{FOLDER}/queries/highlights.scm")).unwrap();
    let query = Query::new(&language(), &query).unwrap();
    for path in ["models/water.lag", "models/chain_walls.lag", "models/benzene.lag", "tests/syntax/triatomic.lag"] {
        let text = std::fs::read_to_string(path).unwrap();
        let tree = tree(&text);
        // By place: of several patterns the last decides.
        let mut found: BTreeMap<usize, (usize, &str)> = BTreeMap::new();
        let mut cursor = QueryCursor::new();
        let mut matches = cursor.matches(&query, tree.root_node(), text.as_bytes());
        while let Some(own) = matches.next() {
            for capture in own.captures {
                let entry = found.entry(capture.node.start_byte()).or_default();
                *entry = (*entry).max((own.pattern_index, query.capture_names()[capture.index as usize]));
            }
        }
        let colour = |at: u32| found.get(&(at as usize)).map_or("", |own| own.1);
        let file = parse(&text).unwrap();
        for statement in &file.statements {
            assert_eq!(colour(statement.span.start), "keyword", "{path}: {:?}", statement.span);
        }
        for name in names(&file) {
            let may_be: &[&str] = match name.kind {
                NameKind::Quantity => &["variable", "constant", "module"],
                NameKind::Index(_) => &["variable", "variable.parameter"],
                NameKind::Column(_) => &["property"],
                NameKind::Function => &["function.builtin"],
                NameKind::Unit => &["type"],
                NameKind::Model => &["module"],
            };
            let own = colour(name.span.start);
            assert!(may_be.contains(&own), "{path}: `{}` is {own}", name.text);
        }
        for comment in &file.comments {
            assert_eq!(colour(comment.span.start), "comment", "{path}");
        }
    }
}

/// The parser is made of this grammar: it has its rules, and where there is the program that makes it, all of them as they are.
#[test]
fn the_parser_is_made_from_the_grammar() {
    let read = |file: &str| std::fs::read_to_string(format!("{FOLDER}/{file}")).unwrap();
    let (grammar, made) = (read("grammar.js"), read("src/grammar.json"));
    let rule = Regex::new(r"(?m)^    (\w+): (?:\$|\(\)) =>").unwrap();
    let rules = rule.captures_iter(grammar.split_once("rules: {").unwrap().1);
    let rules: BTreeSet<String> = rules.map(|own| own.unwrap()[1].to_owned()).collect();
    let json: serde_json::Value = serde_json::from_str(&made).unwrap();
    assert_eq!(json["rules"].as_object().unwrap().keys().cloned().collect::<BTreeSet<_>>(), rules);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tree-sitter");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::copy(format!("{FOLDER}/tree-sitter.json"), folder.join("tree-sitter.json")).unwrap();
    let mut program = Command::new("tree-sitter");
    program.args(["generate", "-o"]).arg(&folder).arg(format!("{FOLDER}/grammar.js"));
    if program.output().is_ok_and(|own| own.status.success()) {
        assert_eq!(std::fs::read_to_string(folder.join("grammar.json")).unwrap(), made);
    }
}

#[test]
fn the_words_are_those_of_the_language() {
    let query = std::fs::read_to_string(format!("{FOLDER}/queries/highlights.scm")).unwrap();
    let grammar = std::fs::read_to_string(format!("{FOLDER}/grammar.js")).unwrap();
    let listed = |text: &str, sign: &str| {
        let quoted = Regex::new(&format!("{sign}([A-Za-z0-9_]+){sign}")).unwrap();
        quoted.captures_iter(text).map(|own| own.unwrap()[1].to_owned()).collect::<BTreeSet<String>>()
    };
    let between = |text: &str, start: &str, end: &str| {
        let rest = text.split_once(start).unwrap().1;
        rest.split_once(end).unwrap().0.to_owned()
    };
    let statements: BTreeSet<String> = STATEMENT_WORDS.into_iter().map(str::to_owned).collect();
    assert_eq!(listed(&between(&grammar, "STATEMENTS = [", "]"), "'"), statements);
    assert_eq!(listed(&between(&query, "\n[\n", "] @keyword"), "\""), statements);
    let functions = FUNCTIONS.into_iter().chain(["rows"]).map(str::to_owned).collect();
    assert_eq!(listed(&between(&query, "(#any-of? @function.builtin", "))"), "\""), functions);
    let about: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(format!("{FOLDER}/tree-sitter.json")).unwrap()).unwrap();
    assert_eq!(about["metadata"]["version"], env!("CARGO_PKG_VERSION"));
    let made = language().metadata().unwrap();
    assert_eq!(
        format!("{}.{}.{}", made.major_version, made.minor_version, made.patch_version),
        env!("CARGO_PKG_VERSION")
    );
}
