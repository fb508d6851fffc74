//! The numeric stage: whole solutions, and what decides where one decomposition takes over.
//!
//! `cargo bench --bench modes --no-default-features --features engine`

use divan::Bencher;
use librate::modes::Options;
use librate::precision::{Ball, Big};
use librate_core::modes::{PreciseProblem, Problem, Source, solve, solve_from};

fn main() {
    divan::main();
}

fn problem(n: usize, mass: impl Fn(usize, usize) -> f64, k: impl Fn(usize, usize) -> f64) -> Problem {
    let flat = |f: &dyn Fn(usize, usize) -> f64| (0..n * n).map(|at| Ball::exact(f(at % n, at / n))).collect();
    Problem { dimension: n, mass: flat(&mass), stiffness: flat(&k), zero_vectors: Vec::new() }
}

/// A chain between walls.
fn chain(n: usize) -> Problem {
    problem(
        n,
        |i, j| f64::from(u8::from(i == j)),
        |i, j| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        },
    )
}

/// A pendulum of n links.
fn pendulum(n: usize) -> Problem {
    let weight = |i: usize| (n - i) as f64;
    problem(n, |i, j| weight(i.max(j)), |i, j| if i == j { 9.81 * weight(i) } else { 0.0 })
}

/// A ring: every frequency but one or two is double.
fn ring(n: usize) -> Problem {
    problem(
        n,
        |i, j| f64::from(u8::from(i == j)),
        |i, j| match (i + n - j) % n {
            0 => 2.5,
            1 => -1.0,
            d if d == n - 1 => -1.0,
            _ => 0.0,
        },
    )
}

#[divan::bench(max_time = 3, args = [1, 2, 3, 6, 10, 20, 24, 40, 60, 100, 228, 1000])]
fn chains(bencher: Bencher<'_, '_>, n: usize) {
    let problem = chain(n);
    bencher.bench(|| solve(&problem, &Options::default()));
}

#[divan::bench(max_time = 3, args = [3, 10, 24, 50, 100, 228, 1000])]
fn pendulums(bencher: Bencher<'_, '_>, n: usize) {
    let problem = pendulum(n);
    bencher.bench(|| solve(&problem, &Options::default()));
}

#[divan::bench(max_time = 3, args = [3, 10, 24, 50, 100, 228, 1000])]
fn rings(bencher: Bencher<'_, '_>, n: usize) {
    let problem = ring(n);
    bencher.bench(|| solve(&problem, &Options::default()));
}

/// Matrices of doubles, which are exact at any precision.
struct Doubles(Problem);

impl Source for Doubles {
    fn precisely(&self, bits: usize) -> Option<PreciseProblem> {
        let exact = |a: &[Ball]| -> Vec<Big> { a.iter().map(|x| Big::from_ball(x, bits)).collect() };
        Some(PreciseProblem {
            dimension: self.0.dimension,
            mass: exact(&self.0.mass),
            stiffness: exact(&self.0.stiffness),
            zero_vectors: Vec::new(),
        })
    }
}

/// Dense M and K, all frequencies. python-flint 0.9 takes 14 and 156 ms for K alone at n = 20 and 50.
#[divan::bench(max_time = 3, args = [3, 20, 50, 100])]
fn hundred_digits(bencher: Bencher<'_, '_>, n: usize) {
    let entry = |i: usize, j: usize| ((1 + i * j) as f64).sin() / 3.0;
    let dense = |i: usize, j: usize| entry(i, j) + if i == j { n as f64 } else { 0.0 };
    let source = Doubles(problem(n, |i, j| dense(i + 1, j + 1), dense));
    let options = Options::default().digits(100);
    bencher.bench(|| solve_from(&source.0, &source, &options));
}

#[divan::bench(max_time = 3, args = [3, 50, 228])]
fn frequencies_only(bencher: Bencher<'_, '_>, n: usize) {
    let problem = pendulum(n);
    let options = Options::default().without_vectors();
    bencher.bench(|| solve(&problem, &options));
}

/// What the two decompositions cost by themselves: where one overtakes the other.
mod decomposition {
    use divan::Bencher;
    use faer::{Mat, Side};
    use nalgebra::{DMatrix, SymmetricEigen};

    const SIZES: [usize; 7] = [10, 20, 30, 40, 50, 60, 80];

    fn entry(i: usize, j: usize) -> f64 {
        ((i + 1) as f64 * (j + 1) as f64).sin()
    }

    #[divan::bench(args = SIZES)]
    fn nalgebra(bencher: Bencher<'_, '_>, n: usize) {
        let a = DMatrix::from_fn(n, n, entry);
        bencher.bench(|| SymmetricEigen::try_new(a.clone(), f64::EPSILON, 100 * n));
    }

    #[divan::bench(args = SIZES)]
    fn faer(bencher: Bencher<'_, '_>, n: usize) {
        let a = Mat::from_fn(n, n, entry);
        bencher.bench(|| a.self_adjoint_eigen(Side::Lower));
    }
}
