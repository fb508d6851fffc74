//! The layout of model files: examples with their canonical text beside them, and the laws on
//! every file of the project.
#![cfg(feature = "format")]

use crate::format_laws;

use std::fmt::Write;
use std::time::{Duration, Instant};

use format_laws::laws;
use librate::syntax::{format, parse};

/// Line ends and marks that can't be seen are shown.
#[test]
fn files_have_one_layout() {
    insta::with_settings!({ snapshot_path => "../format", prepend_module_to_snapshot => false }, {
        insta::glob!("../format", "*.lag", |path| {
            let source = std::fs::read_to_string(path).unwrap();
            let shown = laws(&source).replace('\r', "␍").replace('\u{feff}', "<mark>");
            insta::assert_snapshot!(shown);
        });
    });
}

#[test]
fn every_file_keeps_the_laws() {
    let mut count = 0;
    for folder in ["models", "tests/language", "tests/syntax", "tests/errors"] {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let is_model = path.extension().is_some_and(|end| end == "lag");
            if let Ok(source) = std::fs::read_to_string(&path)
                && is_model
                && parse(&source).is_ok()
            {
                laws(&source);
                count += 1;
            }
        }
    }
    assert!(count > 200, "{count}");
}

#[test]
fn models_and_guide_are_canonical() {
    let mut changed = String::new();
    for entry in std::fs::read_dir("models").unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|end| end == "lag") {
            let source = std::fs::read_to_string(&path).unwrap();
            if format(&source).unwrap() != source {
                writeln!(changed, "{}", path.display()).unwrap();
            }
        }
    }
    let guide = std::fs::read_to_string("docs/language.md").unwrap();
    for rest in guide.split("```lag\n").skip(1) {
        let block = rest.split("```").next().unwrap();
        if laws(block) != block {
            writeln!(changed, "{block}").unwrap();
        }
    }
    assert_eq!(changed, "", "`librate fmt` puts these in order");
}

/// In a debug build too, with room for a busy machine.
#[test]
fn length_costs_no_more_than_length() {
    let terms = "1/2*k*x^2 + ".repeat(100_000);
    let statements = "param a = [1,2] # note\nlet b[i in 1..3] = (a[i] +\n1)*2\n".repeat(20_000);
    let line = "let b = a*(c + d); ".repeat(20_000);
    let nested = format!("V = {}x{}", "sin((1 + ".repeat(120), "))".repeat(120));
    let comments = "V = a*( # one\n b # two\n + c)\n# three\n".repeat(20_000);
    for source in [format!("V = {terms}x"), statements, line, nested, comments] {
        let start = Instant::now();
        let once = format(&source).unwrap();
        assert!(start.elapsed() < Duration::from_secs(60));
        assert_eq!(format(&once).unwrap(), once);
    }
}
