//! Every stage of the way from text to normal modes, on models of growing size.
//!
//! `cargo bench --bench stages --no-default-features --features engine`

use divan::Bencher;
use librate::linearize::{Linearized, linearize};
use librate::model::{Model, Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate::syntax::{File, parse};

fn main() {
    divan::main();
}

/// The models: a file of `models/` and the N it is taken with.
const MODELS: [(&str, usize); 7] = [
    ("three_pendulums", 3),
    ("n_pendulum", 10),
    ("n_pendulum", 50),
    ("n_pendulum", 200),
    ("fput_chain", 100),
    ("fput_chain", 1000),
    ("ubiquitin", 76),
];

/// All of them; the modes of a thousand coordinates take too long to be repeated.
const ALL: [usize; 7] = [0, 1, 2, 3, 4, 5, 6];
const SMALLER: [usize; 6] = [0, 1, 2, 3, 4, 6];

struct Source {
    text: &'static str,
    tables: TableTexts,
    settings: Settings,
}

/// A mistake here is a mistake of the benchmark: it says so and stops.
fn stop(what: &str) -> ! {
    let name: &dyn std::fmt::Display = &what;
    std::process::exit(i32::from(!name.to_string().is_empty()))
}

fn source(at: usize) -> Source {
    let (name, n) = MODELS[at];
    let mut settings = Settings::new();
    let mut tables = TableTexts::new();
    let text = match name {
        "three_pendulums" => include_str!("../models/three_pendulums.lag"),
        "n_pendulum" => include_str!("../models/n_pendulum.lag"),
        "fput_chain" => include_str!("../models/fput_chain.lag"),
        _ => include_str!("../models/ubiquitin.lag"),
    };
    if matches!(name, "n_pendulum" | "fput_chain") && settings.add(&format!("N={n}")).is_err() {
        stop("N");
    }
    if name == "ubiquitin" {
        let points = include_str!("../models/data/ubiquitin_atoms.csv");
        tables = tables.with("data/ubiquitin_atoms.csv".to_owned(), points.to_owned());
    }
    Source {
        text,
        tables,
        settings,
    }
}

fn parsed(source: &Source) -> File {
    parse(source.text).unwrap_or_else(|_| stop("parse"))
}

fn elaborated(source: &Source, file: &File) -> Model {
    elaborate(file, &source.tables, &source.settings).unwrap_or_else(|_| stop("elaborate"))
}

fn linear(model: Model) -> Linearized {
    linearize(model).unwrap_or_else(|_| stop("linearize"))
}

#[divan::bench(args = ALL)]
fn a_parse(bencher: Bencher<'_, '_>, at: usize) {
    let source = source(at);
    bencher.bench(|| parsed(&source));
}

#[divan::bench(args = ALL)]
fn b_elaborate(bencher: Bencher<'_, '_>, at: usize) {
    let source = source(at);
    let file = parsed(&source);
    bencher.bench(|| elaborated(&source, &file));
}

#[divan::bench(args = ALL)]
fn c_linearize(bencher: Bencher<'_, '_>, at: usize) {
    let source = source(at);
    let model = elaborated(&source, &parsed(&source));
    bencher.with_inputs(|| model.clone()).bench_values(linear);
}

#[divan::bench(args = ALL)]
fn d_evaluate(bencher: Bencher<'_, '_>, at: usize) {
    let source = source(at);
    let linear = linear(elaborated(&source, &parsed(&source)));
    bencher.bench(|| (linear.mass(), linear.stiffness()));
}

#[divan::bench(args = SMALLER)]
fn e_modes(bencher: Bencher<'_, '_>, at: usize) {
    let source = source(at);
    let linear = linear(elaborated(&source, &parsed(&source)));
    bencher.bench(|| normal_modes(&linear, &Options::default()));
}

#[divan::bench(args = SMALLER)]
fn f_whole_trip(bencher: Bencher<'_, '_>, at: usize) {
    let source = source(at);
    bencher.bench(|| {
        let linear = linear(elaborated(&source, &parsed(&source)));
        normal_modes(&linear, &Options::default())
    });
}
