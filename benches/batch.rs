//! A thousand sets of parameters: where eight sets rotated together stop being faster than every
//! set decomposed by itself (above 40 coordinates), what bounds, friction and a search cost.
//!
//! `cargo bench --bench batch --no-default-features --features engine`

#[allow(dead_code, reason = "examples use more of it")]
#[path = "../examples/speed_and_error/problems.rs"]
mod problems;

use divan::Bencher;
use librate::batch::{Options, Solutions, Study};
use librate::model::{Settings, TableTexts, elaborate};
use librate::syntax::parse;
use librate_studies::batch::Bounds;
use problems::{DAMPING, LINKS};

fn main() {
    divan::main();
}

const SETS: usize = 1000;

const CHAIN: &str = "
    param m = 1  param k = 1  param w = 1
    coord x[1..N]
    T = sum(i in 1..N, 1/2*m*x[i]'^2)
    V = sum(i in 1..N-1, 1/2*k*(x[i+1] - x[i])^2) + 1/2*w*x[1]^2 + 1/2*k*x[N]^2
";

/// Equal charges in a trap: the equilibrium has to be searched for.
const IONS: &str = "
    param w = 1  param c = 1
    coord x[1..N]
    T = sum(i in 1..N, 1/2*x[i]'^2)
    V = sum(i in 1..N, 1/2*w*x[i]^2) + sum(i in 1..N, j in i+1..N, c/(x[j] - x[i]))
    guess x[i in 1..N] = i - (N + 1)/2
";

fn bench(bencher: Bencher<'_, '_>, text: &str, n: usize, names: &[&str], bounds: Bounds) {
    let mut options = Options::default();
    options.bounds = bounds;
    let study = parse(&format!("param N = {n}{text}"))
        .ok()
        .and_then(|file| elaborate(&file, &TableTexts::new(), &Settings::new()).ok())
        .and_then(|model| Study::with_options(model, names, options).ok());
    let Some(study) = study else { return };
    let sets: Vec<f64> = (0..SETS * study.width()).map(|at| 0.5 + (at * 7919 % 1000) as f64 / 1000.0).collect();
    let mut solutions = Solutions::new();
    bencher.bench_local(|| study.solve_into(&sets, &mut solutions));
}

#[divan::bench(args = [1, 3, 10, 20, 30, 40, 41, 50, 60], sample_count = 10)]
fn chains(bencher: Bencher<'_, '_>, n: usize) {
    bench(bencher, CHAIN, n, &["m", "k", "w"], Bounds::Rigorous);
}

#[divan::bench(args = [3, 10, 20, 40, 41], sample_count = 10)]
fn pendulums(bencher: Bencher<'_, '_>, n: usize) {
    bench(bencher, LINKS, n, &["m", "l", "g"], Bounds::Rigorous);
}

#[divan::bench(args = [3, 10, 20, 40, 41], sample_count = 10)]
fn pendulums_without_bounds(bencher: Bencher<'_, '_>, n: usize) {
    bench(bencher, LINKS, n, &["m", "l", "g"], Bounds::None);
}

#[divan::bench(args = [3, 5, 10], sample_count = 10)]
fn searched(bencher: Bencher<'_, '_>, n: usize) {
    bench(bencher, IONS, n, &["w", "c"], Bounds::Rigorous);
}

#[divan::bench(args = [3, 10, 20], sample_count = 10)]
fn damped(bencher: Bencher<'_, '_>, n: usize) {
    bench(bencher, &format!("{LINKS}{DAMPING}"), n, &["m", "l", "g", "c"], Bounds::Rigorous);
}
