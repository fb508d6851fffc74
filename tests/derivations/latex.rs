//! The derivation in LaTeX: every formula of every textbook model is parsed by a LaTeX parser that is
//! not ours, and where a TeX engine is installed the pages are typeset.
#![cfg(feature = "cli")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "tests stop at the first surprise"
)]

use crate::common;

use std::path::Path;
use std::process::{Command, Stdio};

use common::{load, model_files};
use librate::derive::{Derivation, Parts, derive};
use librate::model::Settings;
use librate::report::derive_latex;
use librate::syntax::{StatementKind, parse};
use librate::typeset::Notation;
use pulldown_latex::{Parser, Storage};

/// Pages of larger models say nothing new.
const MOST: usize = 24;

fn derivation(path: &Path) -> Option<Derivation> {
    let model = load(path);
    if model.coordinates.len() > MOST || !model.constraints.is_empty() {
        return None;
    }
    let mut derivation = derive(&model, &Parts::all().numbers(true)).unwrap();
    let file = parse(&std::fs::read_to_string(path).unwrap()).unwrap();
    derivation.put_given(&file, &Settings::new(), &model);
    Some(derivation)
}

/// The formulas of a page: displayed ones and those in the text.
fn formulas(page: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut rest = page;
    while let Some((_, after)) = rest.split_once("\\begin{equation}\n") {
        let (formula, after) = after.split_once("\n\\end{equation}").expect("a display that ends");
        found.push(formula);
        rest = after;
    }
    for line in page.lines().filter(|line| line.contains('$')) {
        found.extend(line.split('$').skip(1).step_by(2));
    }
    found
}

fn check(formula: &str, origin: &str) {
    let storage = Storage::new();
    for event in Parser::new(formula, &storage) {
        if let Err(error) = event {
            panic!("{origin}: {error}\n{formula}");
        }
    }
}

#[test]
fn a_parser_reads_every_formula() {
    let mut count = 0;
    for path in model_files() {
        let Some(derivation) = derivation(&path) else {
            continue;
        };
        let page = derive_latex(&derivation, false);
        assert!(!page.contains("texttt"), "{path:?}: {page}");
        for formula in formulas(&page) {
            check(formula, &path.display().to_string());
            count += 1;
        }
    }
    assert!(count > 300, "{count} formulas");
}

/// The energies as they stand in the files, sums over members and all.
#[test]
fn a_parser_reads_the_energies_as_written() {
    let mut count = 0;
    for path in model_files() {
        let file = parse(&std::fs::read_to_string(&path).unwrap()).unwrap();
        for statement in &file.statements {
            let (StatementKind::Kinetic(at) | StatementKind::Potential(at)) = statement.kind else {
                continue;
            };
            let formula = Notation::default().formula(&file, at);
            check(&formula.latex_display(), &path.display().to_string());
            count += 1;
        }
    }
    assert!(count > 80, "{count} energies");
}

#[test]
fn pages_read_like_the_book() {
    for name in ["three_pendulums", "double_pendulum", "simple_pendulum", "spring_pendulum"] {
        let path = Path::new("models").join(format!("{name}.lag"));
        let page = derive_latex(&derivation(&path).unwrap(), true);
        insta::assert_snapshot!(format!("latex__{name}"), page);
    }
}

/// The first TeX engine that is installed.
fn engine() -> Option<&'static str> {
    ["pdflatex", "lualatex", "xelatex", "tectonic"].into_iter().find(|engine| {
        let mut command = Command::new(engine);
        command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
        command.status().is_ok_and(|status| status.success())
    })
}

#[test]
fn an_engine_typesets_every_page_where_one_is_installed() {
    let Some(engine) = engine() else {
        eprintln!("no TeX engine is installed, nothing is typeset");
        return;
    };
    let folder = std::env::temp_dir().join(format!("librate-latex-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for path in model_files() {
        let Some(derivation) = derivation(&path) else {
            continue;
        };
        let file = folder.join("page.tex");
        std::fs::write(&file, derive_latex(&derivation, true)).unwrap();
        let mut command = Command::new(engine);
        if engine != "tectonic" {
            command.args(["-interaction=nonstopmode", "-halt-on-error"]);
        }
        let output = command.arg(&file).current_dir(&folder).output().unwrap();
        let log = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{path:?}: {log}");
        let overfull = log.split("Overfull \\hbox (").skip(1).filter_map(|rest| rest.split_once("pt"));
        let widest = overfull.filter_map(|(points, _)| points.parse().ok()).fold(0.0, f64::max);
        assert!(widest < 5.0, "{path:?}: {widest} pt too wide");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
