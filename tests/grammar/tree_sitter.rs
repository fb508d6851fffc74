//! The grammar for tree-sitter, held against the parser. Where a program that makes
//! parsers of it is missing, this is left out.

use crate::syntax_random::{alphabet, changed};
use crate::syntax_trees::{Planter, bounds};

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use fancy_regex::Regex;
use librate_core::syntax::*;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

const FOLDER: &str = "editors/tree-sitter-librate";

fn tree_sitter(arguments: &[&str]) -> Output {
    Command::new("tree-sitter").args(arguments).output().unwrap()
}

/// The parser as a library, in a folder of its own; `None` where it can't be made.
fn library(name: &str) -> Option<(PathBuf, String)> {
    // `.ci/run` says which one is missing.
    let is_there = |program: &&str| Command::new(program).arg("--version").output().is_ok();
    if !["tree-sitter", "node", "cc"].iter().all(is_there) {
        return None;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::copy(format!("{FOLDER}/tree-sitter.json"), folder.join("tree-sitter.json")).unwrap();
    let path = |file: &str| folder.join(file).to_str().unwrap().to_owned();
    let made = tree_sitter(&["generate", "-o", &path("src"), &format!("{FOLDER}/grammar.js")]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let made = tree_sitter(&["build", "-o", &path("librate.so"), &path("")]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let library = path("librate.so");
    Some((folder, library))
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

/// The paths that tree-sitter finds something wrong with.
fn wrong(folder: &Path, library: &str, paths: &[PathBuf]) -> HashSet<PathBuf> {
    let list = folder.join("paths");
    std::fs::write(&list, paths.iter().map(|path| format!("{}\n", path.display())).collect::<String>()).unwrap();
    let arguments =
        ["parse", "-l", library, "--lang-name", "librate", "-q", "--json-summary", "--paths", list.to_str().unwrap()];
    let output = tree_sitter(&arguments);
    let text = String::from_utf8(output.stdout).unwrap();
    // In front of the summary is a line for each of them.
    let summary: serde_json::Value = serde_json::from_str(&text[text.find("{\n").unwrap()..]).unwrap();
    let all = summary["parse_summaries"].as_array().unwrap();
    assert_eq!(all.len(), paths.len());
    let failed = all.iter().filter(|own| own["successful"] == serde_json::json!(false));
    failed.map(|own| PathBuf::from(own["file"].as_str().unwrap())).collect()
}

#[test]
fn both_grammars_are_one_language() {
    let Some((folder, library)) = library("tree-sitter-language") else { return };
    let mut paths = files();
    assert!(paths.len() > 700);
    let mut runner = TestRunner::deterministic();
    let mut write = |number: usize, text: String| {
        let path = folder.join(format!("{number}.lag"));
        std::fs::write(&path, text).unwrap();
        paths.push(path);
    };
    for number in 0..400 {
        let mut planter = Planter::default();
        planter.statements(&bounds().new_tree(&mut runner).unwrap().current());
        write(number, print_file(&planter.file));
        write(10_000 + number, changed().new_tree(&mut runner).unwrap().current());
        let words = proptest::collection::vec(alphabet(), 1..6).new_tree(&mut runner).unwrap().current();
        write(20_000 + number, format!("coord x let a = {}", words.join(" ")));
    }
    let wrong = wrong(&folder, &library, &paths);
    let mut right = 0;
    for path in &paths {
        let text = std::fs::read_to_string(path).unwrap();
        match (parse(&text), wrong.contains(path)) {
            (Ok(_), is_wrong) => {
                assert!(!is_wrong, "tree-sitter does not read {}:\n{text}", path.display());
                right += 1;
            }
            (Err(_), true) => {}
            // What no grammar says: functions and `t` are reserved, conditions stand in filters, a blank before a parenthesis
            // only behind functions, and nothing nests too deep.
            (Err(errors), false) => {
                let is_beyond = |own: &SyntaxError| {
                    matches!(
                        own,
                        SyntaxError::ReservedName { .. }
                            | SyntaxError::ConditionOutsideFilter { .. }
                            | SyntaxError::MissingMultiplication { .. }
                            | SyntaxError::NestingTooDeep { .. }
                    )
                };
                assert!(errors.iter().all(is_beyond), "tree-sitter reads {}:\n{text}\n{errors:#?}", path.display());
            }
        }
    }
    // Neither is a matter of a few.
    assert!(right > 1000 && wrong.len() > 700, "{right} {}", wrong.len());
}

/// What the names of a file are coloured as, by line and byte: of several patterns the last decides.
fn colours(output: &str) -> BTreeMap<(usize, usize), (usize, String)> {
    let place = Regex::new(r"capture: \d+ - ([a-z.]+), start: \((\d+), (\d+)\)").unwrap();
    let mut pattern = 0;
    let mut found: BTreeMap<_, (usize, String)> = BTreeMap::new();
    for line in output.lines() {
        if let Some(number) = line.trim().strip_prefix("pattern: ") {
            pattern = number.parse().unwrap();
        } else if let Some(own) = place.captures(line).unwrap() {
            let number = |at: usize| own[at].parse().unwrap();
            let entry = found.entry((number(2), number(3))).or_default();
            if pattern >= entry.0 {
                *entry = (pattern, own[1].to_owned());
            }
        }
    }
    found
}

#[test]
fn names_have_the_colours_of_what_they_are() {
    let Some((_, library)) = library("tree-sitter-colours") else { return };
    let query = format!("{FOLDER}/queries/highlights.scm");
    for path in ["models/water.lag", "models/chain_walls.lag", "models/benzene.lag", "tests/syntax/triatomic.lag"] {
        let text = std::fs::read_to_string(path).unwrap();
        let output = tree_sitter(&["query", "-l", &library, "--lang-name", "librate", &query, path]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let found = colours(&String::from_utf8(output.stdout).unwrap());
        let colour = |at: u32| {
            let (line, start) = (text[..at as usize].matches('\n').count(), text[..at as usize].rfind('\n'));
            let column = at as usize - start.map_or(0, |end| end + 1);
            found.get(&(line, column)).map_or("", |(_, own)| own.as_str())
        };
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

/// Needs no program.
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
}
