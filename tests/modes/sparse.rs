//! Some modes of large sparse problems: against closed forms, and against the dense path for random ones.

#![cfg(feature = "engine")]

use std::path::Path;

use librate::budget::Budget;
use librate::linearize::linearize;
use librate::model::{Settings, TableTexts, elaborate};
use librate::modes::{Kind, Options, Stability};
use librate::oscillation::{NormalModes, normal_modes};
use librate::precision::Ball;
use librate::report::{Style, modes_text};
use librate::syntax::parse;
use librate_core::modes::{Method, Problem, SparseProblem, Wanted, solve, solve_sparse};
use librate_core::precision::SparseMatrix;
use proptest::prelude::*;
use proptest::strategy::ValueTree;

use crate::common::{model, model_in};

const CHAIN: &str = "
coord x[1..N]
let u[0] = 0
let u[i in 1..N] = x[i]
let u[N+1] = 0
T = sum(i in 1..N, 1/2*x[i]'^2)
V = sum(i in 0..N, 1/2*(u[i+1] - u[i])^2)
";

const FREE_CHAIN: &str = "
coord x[1..N]
T = sum(i in 1..N, 1/2*x[i]'^2)
V = sum(i in 1..N-1, 1/2*(x[i+1] - x[i])^2)
";

/// A membrane of N by N masses in a frame.
const MEMBRANE: &str = "
coord z[1..N, 1..N]
T = sum(i in 1..N, j in 1..N, 1/2*z[i,j]'^2)
V = sum(i in 1..N-1, j in 1..N, 1/2*(z[i+1,j] - z[i,j])^2) + sum(i in 1..N, j in 1..N-1, 1/2*(z[i,j+1] - z[i,j])^2)
  + sum(j in 1..N, 1/2*z[1,j]^2 + 1/2*z[N,j]^2) + sum(i in 1..N, 1/2*z[i,1]^2 + 1/2*z[i,N]^2)
";

fn modes(text: &str, n: usize, options: &Options) -> NormalModes {
    let linearized = linearize(model(&format!("param N = {n}\n{text}"))).unwrap();
    normal_modes(&linearized, options).unwrap()
}

/// 2 sin(πj / 2(n + 1)), rounded.
fn of_chain(j: usize, n: usize) -> f64 {
    2.0 * (std::f64::consts::PI * j as f64 / (2.0 * (n as f64 + 1.0))).sin()
}

/// That an enclosure holds a number that is known to a few roundings, and is narrow.
fn holds(omega: &Ball, exact: f64, radius: f64) {
    let (mid, off) = (omega.mid_f64(), omega.radius + 4.0 * f64::EPSILON * exact);
    assert!((mid - exact).abs() <= off, "{mid} is not {exact}");
    assert!(omega.radius <= radius * exact, "{exact} to {}", omega.radius);
}

#[test]
fn long_chains_have_their_closed_frequencies() {
    for (n, lowest) in [(301, 4), (5000, 10), (20000, 5)] {
        let found = modes(CHAIN, n, &Options::default().lowest(lowest));
        assert_eq!(found.method, Some(Method::Tridiagonal));
        assert_eq!(found.stability, Stability::Stable);
        assert_eq!(found.modes.len(), lowest);
        for (j, mode) in found.modes.iter().enumerate() {
            holds(&mode.omega, of_chain(j + 1, n), 1e-15);
            // x_i = √(2 / (n + 1)) sin(πij / (n + 1)), the largest component positive.
            let sine = |i: usize| (std::f64::consts::PI * (i * (j + 1)) as f64 / (n as f64 + 1.0)).sin();
            let sign = mode.vector[n / 7].signum() * sine(n / 7 + 1).signum();
            for i in (0..n).step_by(37) {
                let exact = sign * (2.0 / (n as f64 + 1.0)).sqrt() * sine(i + 1);
                let off = (mode.vector[i] - exact).abs();
                assert!(off <= mode.vector_error_bound + 1e-15, "{off} > {}", mode.vector_error_bound);
            }
            assert!(mode.vector_error_bound < 1e-9 * (2.0 / n as f64).sqrt());
        }
    }
}

#[test]
fn a_free_chain_drifts() {
    let n = 3000;
    let found = modes(FREE_CHAIN, n, &Options::default().lowest(5));
    assert_eq!(found.stability, Stability::Neutral);
    assert_eq!(found.zero_motions, ["translation of x"]);
    assert_eq!(found.modes[0].kind, Kind::Zero);
    assert!(found.modes[0].omega.is_zero());
    for (j, mode) in found.modes.iter().enumerate().skip(1) {
        holds(&mode.omega, 2.0 * (std::f64::consts::PI * j as f64 / (2.0 * n as f64)).sin(), 1e-15);
    }
}

/// The inverse of K is the matrix of a chain with one free end.
#[test]
fn few_modes_where_each_is_tied_to_all() {
    let text = "coord x[1..N]
        T = sum(i in 1..N, 1/2*x[i]'^2)
        V = sum(i in 1..N, 1/2*i*x[i]^2 + sum(j in i+1..N, i*x[i]*x[j]))";
    let n = 320;
    let found = modes(text, n, &Options::default().lowest(7));
    assert_eq!(found.method, Some(Method::Lanczos));
    for (at, mode) in found.modes.iter().enumerate() {
        let angle = std::f64::consts::PI * (2 * (n - at) - 1) as f64 / (4 * n + 2) as f64;
        holds(&mode.omega, 0.5 / angle.sin(), 1e-12);
    }
}

#[test]
fn all_modes_of_chains_have_their_closed_frequencies() {
    for n in [301, 900] {
        let found = modes(CHAIN, n, &Options::default());
        assert_eq!((found.method, found.modes.len()), (Some(Method::Tridiagonal), n));
        assert_eq!(found.stability, Stability::Stable);
        for (j, mode) in found.modes.iter().enumerate() {
            holds(&mode.omega, of_chain(j + 1, n), 1e-20);
            assert!(mode.vector_error_bound < 1e-16);
            let sine = |i: usize| (std::f64::consts::PI * (i * (j + 1)) as f64 / (n as f64 + 1.0)).sin();
            let sign = mode.vector[n / 7].signum() * sine(n / 7 + 1).signum();
            for i in (0..n).step_by(7) {
                let exact = sign * (2.0 / (n as f64 + 1.0)).sqrt() * sine(i + 1);
                assert!((mode.vector[i] - exact).abs() < 1e-12, "{j} {i}");
            }
        }
        let free = modes(FREE_CHAIN, n, &Options::default().lowest(n / 2));
        assert_eq!((free.method, free.modes.len()), (Some(Method::Tridiagonal), n / 2));
        assert_eq!((free.stability, free.modes[0].kind), (Stability::Neutral, Kind::Zero));
        assert_eq!(free.zero_motions, ["translation of x"]);
        assert!(free.modes[0].vector.iter().all(|x| (x - 1.0 / (n as f64).sqrt()).abs() < 1e-15));
        for (j, mode) in free.modes.iter().enumerate().skip(1) {
            holds(&mode.omega, 2.0 * (std::f64::consts::PI * j as f64 / (2.0 * n as f64)).sin(), 1e-20);
        }
    }
}

/// Masses and springs from a row of numbers without order; the coordinates are numbered by `place`.
fn uneven_chain(n: usize, place: impl Fn(usize) -> usize) -> String {
    let number = |i: usize| (i * i * 31 + 7 * i) % 17 + 9;
    let sum = |terms: Vec<String>| terms.join(" + ");
    let inertia = (0..n).map(|i| format!("{}/7*x[{}]'^2", number(i), place(i))).collect();
    let bond = |i: usize| format!("1/{}*(x[{}] - x[{}])^2", number(n + i), place(i), place(i + 1));
    // An upright pendulum at one end: one mode grows.
    let bonds = (0..n - 1).map(bond).collect();
    format!("coord x[1..N]\nT = {}\nV = {} - x[{}]^2", sum(inertia), sum(bonds), place(0))
}

#[test]
fn all_modes_of_an_uneven_chain_are_those_of_dense_matrices() {
    let n = 302;
    let shuffled = |i: usize| (i * 7) % n + 1;
    let own = modes(&uneven_chain(n, |i| i + 1), n, &Options::default());
    let dense = modes(&uneven_chain(n, shuffled), n, &Options::default());
    assert_eq!((own.method, dense.method), (Some(Method::Tridiagonal), None));
    assert_eq!((own.stability, dense.stability), (Stability::Unstable, Stability::Unstable));
    for (a, b) in own.modes.iter().zip(&dense.modes) {
        assert_eq!((a.kind, a.cluster), (b.kind, b.cluster));
        let (x, y) = if a.kind == Kind::Unstable { (&a.growth, &b.growth) } else { (&a.omega, &b.omega) };
        assert!((*x - *y).contains_zero() && x.radius <= 1e-13 * x.mid_f64(), "{x:?} {y:?}");
        let top = (0..n).max_by(|i, j| a.vector[*i].abs().total_cmp(&a.vector[*j].abs())).unwrap();
        let sign = a.vector[top].signum() * b.vector[shuffled(top) - 1].signum();
        let bound = a.vector_error_bound + b.vector_error_bound;
        for (i, x) in a.vector.iter().enumerate() {
            assert!((x - sign * b.vector[shuffled(i) - 1]).abs() <= bound);
        }
    }
}

/// All frequencies of a membrane, ascending.
fn of_membrane(n: usize) -> Vec<f64> {
    let square = |j: usize| of_chain(j, n).powi(2);
    let mut all: Vec<f64> = (1..=n).flat_map(|i| (1..=n).map(move |j| (square(i) + square(j)).sqrt())).collect();
    all.sort_by(f64::total_cmp);
    all
}

#[test]
fn a_membrane_has_all_its_equal_frequencies() {
    let n = 40;
    let found = modes(MEMBRANE, n, &Options::default().lowest(30).without_vectors());
    assert_eq!(found.method, Some(Method::Lanczos));
    assert_eq!(found.modes.len(), 30);
    let exact = of_membrane(n);
    for (mode, exact) in found.modes.iter().zip(&exact) {
        holds(&mode.omega, *exact, 1e-14);
    }
    let clusters: std::collections::BTreeSet<u32> = found.modes.iter().map(|mode| mode.cluster).collect();
    let mut distinct = exact[..30].to_vec();
    distinct.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    assert_eq!(clusters.len(), distinct.len());
}

#[test]
fn a_free_crystal_has_its_triple_frequencies() {
    // In three dimensions an elimination is so much work that the order is looked for by nested dissection.
    let n = 24;
    let crystal = "
coord z[1..N, 1..N, 1..N]
T = sum(i in 1..N, j in 1..N, l in 1..N, 1/2*z[i,j,l]'^2)
V = sum(i in 1..N-1, j in 1..N, l in 1..N, 1/2*(z[i+1,j,l] - z[i,j,l])^2)
  + sum(i in 1..N, j in 1..N-1, l in 1..N, 1/2*(z[i,j+1,l] - z[i,j,l])^2)
  + sum(i in 1..N, j in 1..N, l in 1..N-1, 1/2*(z[i,j,l+1] - z[i,j,l])^2)
";
    let found = modes(crystal, n, &Options::default().lowest(8).without_vectors());
    assert_eq!(found.stability, Stability::Neutral);
    assert!(found.modes[0].omega.is_zero());
    let square = |j: usize| (2.0 * (std::f64::consts::PI * j as f64 / (2 * n) as f64).sin()).powi(2);
    for (k, mode) in found.modes.iter().enumerate().skip(1) {
        let squares = if k <= 3 {
            square(1)
        } else if k <= 6 {
            2.0 * square(1)
        } else {
            3.0 * square(1)
        };
        holds(&mode.omega, squares.sqrt(), 1e-14);
    }
}

#[test]
fn modes_near_a_frequency_are_the_nearest() {
    let (n, omega, count) = (30, 1.7, 8);
    let found = modes(MEMBRANE, n, &Options::default().near(omega, count).without_vectors());
    assert!(found.method.is_some());
    let mut exact = of_membrane(n);
    exact.sort_by(|a, b| (a - omega).abs().total_cmp(&(b - omega).abs()));
    let mut nearest = exact[..count].to_vec();
    nearest.sort_by(f64::total_cmp);
    for (mode, exact) in found.modes.iter().zip(&nearest) {
        holds(&mode.omega, *exact, 1e-13);
    }
    // The same of a small model, whose matrices are dense.
    let small = modes(CHAIN, 12, &Options::default().near(1.0, 3));
    assert!(small.method.is_none());
    let exact: Vec<f64> = (3..=5).map(|j| of_chain(j, 12)).collect();
    for (mode, exact) in small.modes.iter().zip(&exact) {
        holds(&mode.omega, *exact, 1e-11);
    }
    // Far from usual numbers modes are computed in other units, and asked for in rad/s.
    let far = "param k = 1e-200\ncoord x, y, z\nT = 1/2*(x'^2 + y'^2 + z'^2)\nV = k*(1/2*x^2 + 2*y^2 + 9/2*z^2)";
    let found = normal_modes(&linearize(model(far)).unwrap(), &Options::default().near(2e-100, 1)).unwrap();
    assert_eq!(found.modes.len(), 1);
    holds(&found.modes[0].omega, 2e-100, 1e-9);
    // A window that reaches 0 has the lowest.
    let low = modes(CHAIN, 500, &Options::default().near(0.001, 3));
    for (j, mode) in low.modes.iter().enumerate() {
        holds(&mode.omega, of_chain(j + 1, 500), 1e-13);
    }
}

#[test]
fn vectors_of_others_get_bounds() {
    let n = 20;
    let exact = of_membrane(n);
    let lowest = modes(MEMBRANE, n, &Options::default().lowest(6));
    let given = |from: usize, to: usize| {
        let mut options = Options::default();
        // Some digits alone, in other lengths.
        let rough = lowest.modes[from..to].iter().flat_map(|mode| mode.vector.iter().map(|x| (x * 3e9).round() / 1e9));
        options.given = Some(rough.collect());
        options
    };
    for (from, to) in [(0, 6), (0, 1), (1, 3), (3, 6)] {
        let found = modes(MEMBRANE, n, &given(from, to));
        assert_eq!((found.method, found.modes.len()), (Some(Method::Given), to - from));
        for (mode, exact) in found.modes.iter().zip(&exact[from..]) {
            holds(&mode.omega, *exact, 1e-13);
        }
    }
    // The second and third are one frequency: one of them alone is no whole part of the spectrum.
    let linearized = linearize(model(&format!("param N = {n}\n{MEMBRANE}"))).unwrap();
    let options = given(3, 6);
    let found = normal_modes(&linearized, &options).unwrap();
    let text = modes_text(&linearized, &found, &options, &Style::default());
    assert!(text.contains("3 of 400 modes, from given vectors, none between them missing"), "{text}");
    assert!(normal_modes(&linearized, &given(0, 2)).is_err());
    assert!(normal_modes(&linearized, &given(2, 4)).is_err());
}

#[test]
fn models_of_the_folder_for_large_ones_are_solved() {
    for (file, size) in [("chain", "N = 700"), ("membrane", "N = 20"), ("net", "N = 14")] {
        let text = std::fs::read_to_string(format!("models/large/{file}.lag")).unwrap();
        let linearized = linearize(model_in(&text, Path::new("models/large"), &[size])).unwrap();
        let found = normal_modes(&linearized, &Options::default().lowest(3)).unwrap();
        assert_eq!(found.stability, Stability::Stable);
        assert!(found.method.is_some());
    }
}

/// Points in a cube as a table, one a unit of volume.
fn points(count: usize) -> String {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (count as f64).cbrt() * (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let rows = (0..count).map(|_| format!("{:.4},{:.4},{:.4}\n", next(), next(), next()));
    std::iter::once("x,y,z\n".to_owned()).chain(rows).collect()
}

#[test]
fn a_free_network_has_the_modes_of_the_dense_one() {
    let text = std::fs::read_to_string("models/large/network.lag").unwrap();
    let tables = TableTexts::new().with("points.csv".to_owned(), points(300));
    let model = elaborate(&parse(&text).unwrap(), &tables, &Settings::new()).unwrap();
    let linearized = linearize(model).unwrap();
    let few = normal_modes(&linearized, &Options::default().lowest(12).without_vectors()).unwrap();
    let all = normal_modes(&linearized, &Options::default().without_vectors()).unwrap();
    assert!(few.method.is_some() && all.method.is_none());
    let zeros = |modes: &NormalModes| modes.modes.iter().filter(|mode| mode.kind == Kind::Zero).count();
    assert!(zeros(&few) >= 6 && zeros(&few) == zeros(&all).min(12));
    assert_eq!((few.stability, &few.zero_motions), (Stability::Neutral, &all.zero_motions));
    for (mode, same) in few.modes.iter().zip(&all.modes) {
        assert!((mode.omega - same.omega).contains_zero());
        assert!(mode.omega.radius <= 1e-12 * mode.omega.mid_f64());
    }
}

/// Sparse matrices and the same ones dense.
#[derive(Debug)]
struct Case {
    n: usize,
    mass: Vec<(u32, u32, Ball)>,
    stiffness: Vec<(u32, u32, Ball)>,
}

impl Case {
    fn dense(&self, shares: &[(u32, u32, Ball)]) -> Vec<Ball> {
        let mut all = vec![Ball::ZERO; self.n * self.n];
        for (i, j, value) in shares {
            for at in [*i as usize + self.n * *j as usize, *j as usize + self.n * *i as usize] {
                all[at] = all[at] + *value;
                if i == j {
                    break;
                }
            }
        }
        all
    }

    /// What both ways find of some modes; none where the sparse one gives up.
    fn compare(&self, wanted: Wanted) -> bool {
        let sparse = |shares: &[_]| SparseMatrix::from_shares(self.n, shares);
        let problem = SparseProblem { mass: sparse(&self.mass), stiffness: sparse(&self.stiffness) };
        let Some((found, _)) =
            solve_sparse(&problem, wanted, &mut Vec::new, &Options::default(), &Budget::default()).unwrap()
        else {
            return false;
        };
        let dense = Problem {
            dimension: self.n,
            mass: self.dense(&self.mass),
            stiffness: self.dense(&self.stiffness),
            zero_vectors: Vec::new(),
        };
        let all = solve(&dense, &Options::default()).unwrap();
        let first = match wanted {
            Wanted::Lowest(_) | Wanted::Given(_) => 0,
            Wanted::Near(..) => {
                let lowest = found.modes[0].omega_squared;
                let place = all.modes.iter().position(|mode| !(mode.omega_squared - lowest).contains_zero());
                let mut at = all.modes.iter().position(|mode| (mode.omega_squared - lowest).contains_zero()).unwrap();
                // The last of equal ones that leaves room for those found.
                while at + found.modes.len() < all.modes.len()
                    && (all.modes[at + 1].omega_squared - lowest).contains_zero()
                    && found.modes.get(1).is_some_and(|next| !(next.omega_squared - lowest).contains_zero())
                {
                    at += 1;
                }
                assert!(place.is_some() || self.n == found.modes.len());
                at
            }
        };
        for (mode, exact) in found.modes.iter().zip(&all.modes[first..]) {
            let (a, b) = (mode.omega_squared, exact.omega_squared);
            assert!((a - b).contains_zero(), "{a:?} is not {b:?}");
            let scale = all.modes.last().unwrap().omega_squared.abs_upper();
            assert!(a.radius <= 1e-13 * scale, "{a:?}");
        }
        true
    }
}

/// Springs between some pairs, springs to the ground, some of them negative, equal ones among them.
fn case() -> impl Strategy<Value = Case> {
    (10..40_usize, 1..4_usize, any::<bool>()).prop_flat_map(|(n, reach, coupled)| {
        let spring = prop_oneof![4 => 1..6i32, 1 => Just(1)].prop_map(f64::from);
        let pairs = proptest::collection::vec((0..n, 1..=reach, spring), n..3 * n);
        let ground = proptest::collection::vec(prop_oneof![6 => 1..4i32, 1 => -2..1i32], n);
        let masses = proptest::collection::vec(1..5i32, n);
        (pairs, ground, masses).prop_map(move |(pairs, ground, masses)| {
            let place = |i: usize| i as u32;
            let mut stiffness = Vec::new();
            for (i, step, k) in pairs {
                let j = (i + step) % n;
                for at in [i, j] {
                    stiffness.push((place(at), place(at), Ball::exact(k)));
                }
                stiffness.push((place(i.max(j)), place(i.min(j)), Ball::exact(-k)));
            }
            let diagonal = |values: Vec<i32>, scale: f64| -> Vec<(u32, u32, Ball)> {
                (0..).zip(values).map(|(i, value)| (i, i, Ball::exact(scale * f64::from(value)))).collect()
            };
            stiffness.extend(diagonal(ground, 0.25));
            let mut mass = diagonal(masses, 1.0);
            if coupled {
                mass.extend((1..place(n)).map(|i| (i, i - 1, Ball::exact(0.25))));
            }
            Case { n, mass, stiffness }
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    #[test]
    fn random_sparse_problems_agree_with_dense_ones(case in case(), count in 1..6_usize) {
        case.compare(Wanted::Lowest(count));
    }

    #[test]
    fn modes_near_a_frequency_agree_with_dense_ones(case in case(), count in 1..5_usize, omega in 0.5..3.0) {
        case.compare(Wanted::Near(omega, count));
    }
}

#[test]
fn random_sparse_problems_are_solved() {
    // That few are given up: the property above says nothing of those.
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let mut solved = 0;
    for _ in 0..40 {
        let case = case().new_tree(&mut runner).unwrap().current();
        solved += usize::from(case.compare(Wanted::Lowest(3)));
    }
    assert!(solved >= 38, "{solved} of 40");
}

/// What the modes near a frequency say of all others, too.
#[test]
fn stability_is_that_of_all_modes() {
    let near = Options::default().near(1.0, 2).without_vectors();
    for (text, stability) in [
        (format!("{FREE_CHAIN} - 1/2*x[1]^2"), Stability::Unstable),
        (FREE_CHAIN.to_owned(), Stability::Neutral),
        (CHAIN.to_owned(), Stability::Stable),
    ] {
        let found = modes(text.trim_end().replace("\n - ", " - ").as_str(), 400, &near);
        assert_eq!((found.stability, found.modes.len()), (stability, 2), "{text}");
    }
}

/// The waves of a ring come in pairs: those of the sparse path are those of the dense one.
#[test]
fn equal_frequencies_have_the_same_echelon_basis() {
    let ring = "coord x[1..N]  T = sum(i in 1..N, 1/2*x[i]'^2)  V = sum(i in 1..N, 1/2*(x[mod(i, N) + 1] - x[i])^2)";
    let few = modes(ring, 301, &Options::default().lowest(5));
    let all = modes(ring, 301, &Options::default());
    assert!(few.method.is_some() && all.method.is_none());
    for (own, other) in few.modes.iter().zip(&all.modes) {
        let most = own.vector.iter().zip(&other.vector).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(most < 1e-12, "{most}");
    }
}

/// More digits than double-double has for so many coordinates, without all other modes.
#[test]
fn digits_beyond_double_double_are_those_of_few_modes() {
    let found = modes(CHAIN, 600, &Options::default().lowest(2).digits(28).without_vectors());
    let precise = found.modes[0].precise.as_ref().unwrap();
    // 2 sin(pi/1202)
    assert!((found.modes[0].omega.mid_f64() - 2.0 * (std::f64::consts::PI / 1202.0).sin()).abs() < 1e-16);
    assert!(precise.omega.radius().to_f64() < 1e-30 * precise.omega.mid_f64());
}

/// A pendulum whose weight is a generalised force, beside a free mass and a long chain: V turns freely about z, but the weight holds it. The
/// frequency is sqrt(g/l), l the length to which the weight stretches the rod.
#[test]
fn weights_that_are_forces_hold() {
    let text = |next: usize| {
        format!(
            "coord q[1..N], x, y, z
             T = sum(i in 1..N, 1/2*q[i]'^2) + 1/2*(x'^2 + y'^2 + z'^2)
             V = sum(i in 1..N, 50*(1 + i/100)*q[i]^2) + sum(i in 1..N-{next}, 1/20*(q[i+{next}] - q[i])^2)
               + 50*(sqrt(x^2 + y^2) - 1)^2
             force y = -9.81
             equilibrium y = -1.0981"
        )
    };
    for (n, next) in [(10, 2), (320, 2), (320, 1)] {
        let found = modes(&text(next), n, &Options::default().lowest(3));
        assert_eq!(found.modes[0].kind, Kind::Zero);
        assert_eq!(found.zero_motions, ["z is free"]);
        holds(&found.modes[1].omega, (9.81_f64 / 1.0981).sqrt(), 1e-13);
        assert!(found.modes[2].omega.lower() > 9.9);
        let near = modes(&text(next), n, &Options::default().near(2.9, 1));
        holds(&near.modes[0].omega, (9.81_f64 / 1.0981).sqrt(), 1e-13);
    }
}

/// No element is stressed where V alone counts; the force is what keeps x, or drives it away.
#[test]
fn forces_stress_what_is_no_element() {
    for (force, kind) in [("1e-36", Kind::Oscillation), ("-1e-36", Kind::Unstable)] {
        let text = format!(
            "param F = {force}
             coord x, y
             T = 1/2*(x'^2 + y'^2)
             V = 1/2*(y - 1/3 + x^2/2)^2
             force y = F
             equilibrium y = 1/3 + F"
        );
        let found = modes(&text, 1, &Options::default());
        assert!(found.modes.iter().any(|own| own.kind == kind), "{force}: {:?}", found.modes);
        assert!(found.modes.iter().all(|own| own.kind != Kind::Zero));
    }
}

/// A force on a cart says nothing of a mass on one spring at its natural length beside it.
#[test]
fn forces_elsewhere_leave_mechanisms() {
    let text = "param k = 2  param s = 0.3
        coord x, y, w
        T = 1/2*(x'^2 + y'^2 + w'^2)
        V = 1/2*k*(sqrt((x - 1)^2 + (y - 2)^2) - sqrt(5))^2 + 1/2*k*w^2
        force w = s*cos(w)
        equilibrium x = 0
        equilibrium y = 0";
    let found = modes(text, 1, &Options::default());
    assert_eq!((found.stability, found.modes[0].kind), (Stability::Neutral, Kind::Zero));
}
