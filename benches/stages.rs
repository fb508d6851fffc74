//! Every stage of the way from text to normal modes, on models of growing size, each beside its floor:
//! what the same result costs at the very least, without places, symbols or bounds.
//!
//! `cargo bench --bench stages --no-default-features --features engine`

use std::fmt::{self, Display, Formatter};

use divan::Bencher;
use librate::linearize::{Linearized, linearize};
use librate::model::{Model, Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate::precision::Ball;
use librate::syntax::{File, parse};

fn main() {
    divan::main();
}

/// A file of `models/` and the N it is taken with.
#[derive(Clone, Copy)]
struct Case(&'static str, usize);

impl Display for Case {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.0, self.1)
    }
}

const ALL: [Case; 7] = [
    Case("three_pendulums", 3),
    Case("n_pendulum", 10),
    Case("n_pendulum", 50),
    Case("n_pendulum", 200),
    Case("fput_chain", 100),
    Case("ubiquitin", 76),
    Case("fput_chain", 1000),
];

/// The modes of a thousand coordinates take too long to be repeated.
const SMALLER: &[Case] = ALL.split_at(6).0;

struct Source {
    text: &'static str,
    tables: TableTexts,
    settings: Settings,
}

/// A model that can't be read is a mistake of the benchmark.
fn stop() -> ! {
    std::process::exit(1)
}

fn source(Case(name, n): Case) -> Source {
    let mut settings = Settings::new();
    let mut tables = TableTexts::new();
    let text = match name {
        "three_pendulums" => include_str!("../models/three_pendulums.lag"),
        "n_pendulum" => include_str!("../models/n_pendulum.lag"),
        "fput_chain" => include_str!("../models/fput_chain.lag"),
        _ => include_str!("../models/ubiquitin.lag"),
    };
    if matches!(name, "n_pendulum" | "fput_chain") && settings.add(&format!("N={n}")).is_err() {
        stop();
    }
    if name == "ubiquitin" {
        let points = include_str!("../models/data/ubiquitin_atoms.csv");
        tables = tables.with("data/ubiquitin_atoms.csv".to_owned(), points.to_owned());
    }
    Source { text, tables, settings }
}

fn parsed(source: &Source) -> File {
    parse(source.text).unwrap_or_else(|_| stop())
}

fn elaborated(source: &Source, file: &File) -> Model {
    elaborate(file, &source.tables, &source.settings).unwrap_or_else(|_| stop())
}

fn linear(model: Model) -> Linearized {
    linearize(model).unwrap_or_else(|_| stop())
}

#[divan::bench(args = ALL)]
fn a_parse(bencher: Bencher<'_, '_>, case: Case) {
    let source = source(case);
    bencher.bench(|| parsed(&source));
}

/// The floor of parsing: looking at every byte.
#[divan::bench(args = ALL)]
fn a_parse_floor(bencher: Bencher<'_, '_>, case: Case) {
    let source = source(case);
    let kind = |byte: u8| u32::from(byte.is_ascii_alphanumeric());
    bencher.bench(|| divan::black_box(source.text).bytes().map(kind).sum::<u32>());
}

/// The floor of elaboration: the tree walked once.
#[divan::bench(args = ALL)]
fn b_elaborate_floor(bencher: Bencher<'_, '_>, case: Case) {
    let file = parsed(&source(case));
    bencher.bench(|| file.expressions.iter().map(|e| e.span.start).max());
}

#[divan::bench(args = ALL)]
fn b_elaborate(bencher: Bencher<'_, '_>, case: Case) {
    let source = source(case);
    let file = parsed(&source);
    bencher.bench(|| elaborated(&source, &file));
}

#[divan::bench(args = ALL)]
fn c_linearize(bencher: Bencher<'_, '_>, case: Case) {
    let source = source(case);
    let model = elaborated(&source, &parsed(&source));
    bencher.with_inputs(|| model.clone()).bench_values(linear);
}

#[divan::bench(args = ALL)]
fn d_evaluate(bencher: Bencher<'_, '_>, case: Case) {
    let source = source(case);
    let linear = linear(elaborated(&source, &parsed(&source)));
    bencher.bench(|| (linear.mass(), linear.stiffness()));
}

/// The floor of evaluation: two matrices of enclosures filled with zeros.
#[divan::bench(args = ALL)]
fn d_evaluate_floor(bencher: Bencher<'_, '_>, case: Case) {
    let source = source(case);
    let n = linear(elaborated(&source, &parsed(&source))).dimension();
    bencher.bench(|| (vec![Ball::ZERO; n * n], vec![Ball::ZERO; n * n]));
}

/// The floor of the modes: the bare decomposition in doubles, without bounds.
#[divan::bench(args = SMALLER)]
fn e_modes_floor(bencher: Bencher<'_, '_>, case: Case) {
    let source = source(case);
    let linear = linear(elaborated(&source, &parsed(&source)));
    let n = linear.dimension();
    let matrix = |entries: &[Ball]| nalgebra::DMatrix::from_iterator(n, n, entries.iter().map(Ball::mid_f64));
    let (mass, stiffness) = (matrix(&linear.mass()), matrix(&linear.stiffness()));
    bencher.bench(|| {
        let factor = mass.clone().cholesky()?;
        let left = factor.l().solve_lower_triangular(&stiffness)?;
        let both = factor.l().solve_lower_triangular(&left.transpose())?;
        Some(both.symmetric_eigen().eigenvalues.sum())
    });
}

#[divan::bench(args = SMALLER)]
fn e_modes(bencher: Bencher<'_, '_>, case: Case) {
    let source = source(case);
    let linear = linear(elaborated(&source, &parsed(&source)));
    bencher.bench(|| normal_modes(&linear, &Options::default()));
}

#[divan::bench(args = SMALLER)]
fn f_whole_trip(bencher: Bencher<'_, '_>, case: Case) {
    let source = source(case);
    bencher.bench(|| {
        let linear = linear(elaborated(&source, &parsed(&source)));
        normal_modes(&linear, &Options::default())
    });
}

#[cfg(feature = "format")]
#[divan::bench(args = ALL)]
fn g_format(bencher: Bencher<'_, '_>, case: Case) {
    let source = source(case);
    bencher.bench(|| librate::syntax::format(source.text));
}

/// The floor of layout: the tree parsed and printed.
#[cfg(feature = "format")]
#[divan::bench(args = ALL)]
fn g_format_floor(bencher: Bencher<'_, '_>, case: Case) {
    let source = source(case);
    bencher.bench(|| librate_core::syntax::print_file(&parsed(&source)));
}
