//! Frequencies of hard problems against references of 40 digits computed by other means.

#![cfg(feature = "engine")]

use crate::modes_support;

use dashu_ratio::RBig;
use librate::modes::{Kind, Options, PrecisionLevel, Stability};
use librate::precision::{Ball, Rounding, decimal};
use librate_core::modes::{ModesError, Problem, solve};
use modes_support::*;

fn reference(name: &str) -> Vec<RBig> {
    let path = format!("{}/tests/reference/hard/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    json["omega"].as_array().unwrap().iter().map(|x| parse(x.as_str().unwrap())).collect()
}

/// Every frequency within its bound of the reference, the bound below 1e-13 relative, and ten
/// correctly rounded digits.
fn check(name: &str, problem: &Problem) {
    let spectrum = solve(problem, &Options::default()).unwrap();
    let omegas = reference(name);
    assert_eq!(spectrum.modes.len(), omegas.len());
    let mut worst: (f64, f64) = (0.0, 0.0);
    for (mode, omega) in spectrum.modes.iter().zip(&omegas) {
        if *omega == RBig::ZERO {
            assert_eq!(mode.kind, Kind::Zero);
            assert!(mode.omega.is_zero());
            continue;
        }
        assert_eq!(mode.kind, Kind::Oscillation);
        let error = abs(double(mode.omega.mid.hi) + double(mode.omega.mid.lo) - omega);
        // The references have 40 digits.
        let slack = omega * parse("1e-39");
        assert!(error <= double(mode.omega.radius) + slack, "{name}: {:?}", mode.omega);
        let relative = (error / omega).to_f64().value();
        worst = (worst.0.max(relative), worst.1.max(mode.omega.radius / mode.omega.mid.hi));
        let printed = decimal(&mode.omega, 10);
        assert_eq!(printed.rounding, Rounding::Correct);
        let off = abs(parse(&printed.text) - omega) / omega;
        assert!(off < parse("5e-10"), "{name}: {}", printed.text);
    }
    assert!(worst.0 < 1e-13 && worst.1 < 1e-13, "{name}: {worst:?}");
}

fn ones(n: usize) -> Vec<RBig> {
    vec![RBig::ONE; n]
}

#[test]
fn stiff_springs_beside_soft_ones() {
    let e = |k: &[i32]| -> Vec<RBig> { k.iter().map(|&k| if k < 0 { RBig::ZERO } else { power_of_ten(k) }).collect() };
    let (m, k) = chain(&ones(3), &e(&[0, 8, 16, -1]));
    check("H1_stiff3", &problem(&m, &k));
    let (m, k) = chain(&ones(3), &e(&[16, 8, 0, -1]));
    check("H1_stiff3_rev", &problem(&m, &k));
    let mut springs: Vec<i32> = (0..20).map(|i| if i % 2 == 0 { 0 } else { 14 }).collect();
    springs.push(-1);
    let (m, k) = chain(&ones(20), &e(&springs));
    check("H1_stiff20", &problem(&m, &k));
}

#[test]
fn masses_over_twenty_four_decades() {
    let decades = [-12, -10, -8, -6, -3, -1, 1, 3, 6, 8, 10, 12];
    let masses: Vec<RBig> = decades.iter().map(|&e| power_of_ten(e)).collect();
    let (m, k) = chain(&masses, &ones(13));
    check("H2_graded12", &problem(&m, &k));
    let masses: Vec<RBig> = (0..12).map(|i| power_of_ten(-12 + 2 * ((5 * i) % 13))).collect();
    let (m, k) = chain(&masses, &ones(13));
    check("H2_shuffled12", &problem(&m, &k));
}

#[test]
fn free_chain_with_its_translation() {
    let mut springs = ones(51);
    springs[0] = RBig::ZERO;
    springs[50] = RBig::ZERO;
    let (m, k) = chain(&ones(50), &springs);
    let mut problem = problem(&m, &k);
    problem.zero_vectors = vec![vec![Ball::ONE; 50]];
    check("H3_free50", &problem);
    let spectrum = solve(&problem, &Options::default()).unwrap();
    assert_eq!(spectrum.stability, Stability::Neutral);
    check_vectors(&problem, &spectrum, 1e-13);
    let equal = 1.0 / 50f64.sqrt();
    assert!(spectrum.modes[0].vector.iter().all(|x| (x - equal).abs() < 1e-15));
    // Without the proof the lowest one stays undecided, with a small bound.
    problem.zero_vectors.clear();
    let spectrum = solve(&problem, &Options::default()).unwrap();
    assert_eq!(spectrum.stability, Stability::Undecided);
    assert_eq!(spectrum.modes[0].kind, Kind::Undecided);
    assert!(spectrum.modes[0].omega_squared.abs_upper() < 1e-28);
}

#[test]
fn nearly_degenerate_pair_is_separated() {
    let g = ratio(981, 100);
    let k = power_of_ten(-13);
    let stiffness = vec![vec![&g + &k, -k.clone()], vec![-k.clone(), &g + &k]];
    let problem = problem(&diagonal(&ones(2)), &stiffness);
    check("H4_degenerate", &problem);
    let modes = solve(&problem, &Options::default()).unwrap().modes;
    assert_ne!(modes[0].cluster, modes[1].cluster);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    for (mode, sign) in modes.iter().zip([1.0, -1.0]) {
        assert!((mode.vector[0] - half).abs() <= mode.vector_error_bound);
        assert!((mode.vector[1] - sign * half).abs() <= mode.vector_error_bound);
        assert!(mode.vector_error_bound < 1e-14, "{}", mode.vector_error_bound);
    }
}

#[test]
fn hilbert_mass_matrix() {
    let (_, k) = chain(&ones(12), &ones(13));
    let m: Exact = (0..12).map(|i| (0..12).map(|j| ratio(1, i + j + 1)).collect()).collect();
    check("H6_hilbert12", &problem(&m, &k));
}

#[test]
fn pendulums_and_hanging_chains() {
    for (name, n) in [("H7_pendulum20", 20_i64), ("pendulum50", 50)] {
        let g = ratio(981, 100);
        let m: Exact = (0..n).map(|i| (0..n).map(|j| RBig::from(n - i.max(j))).collect()).collect();
        let k = diagonal(&(0..n).map(|i| &g * RBig::from(n - i)).collect::<Vec<_>>());
        check(name, &problem(&m, &k));
        // The same in the transverse displacements of a hanging chain: tensions rise to the top.
        let mut tensions: Vec<RBig> = (0..n).map(|i| &g * RBig::from(n - i)).collect();
        tensions.push(RBig::ZERO);
        let (m, k) = chain(&ones(n as usize), &tensions);
        check(name, &problem(&m, &k));
    }
}

/// Where vectors in doubles do not do, each is corrected by the others: bounds of shapes hold, and are of use.
#[test]
fn corrected_shapes_keep_their_bounds() {
    let options = Options::default().digits(12);
    // A free chain: x_j = √(2/n) cos(kπ(j - 1/2)/n).
    let n = 150;
    let mut springs = ones(n + 1);
    (springs[0], springs[n]) = (RBig::ZERO, RBig::ZERO);
    let (m, k) = chain(&ones(n), &springs);
    let mut free = problem(&m, &k);
    free.zero_vectors = vec![vec![Ball::ONE; n]];
    let spectrum = solve(&free, &options).unwrap();
    assert_eq!(spectrum.level, PrecisionLevel::Refined);
    let length = (Ball::exact(2.0) / Ball::exact(n as f64)).sqrt();
    for (number, mode) in spectrum.modes.iter().enumerate().skip(1) {
        let exact = |j: usize| {
            let angle = Ball::exact(number as f64 * (j as f64 + 0.5)) / Ball::exact(n as f64);
            length * (Ball::PI * angle).cos()
        };
        let bound = mode.vector_error_bound;
        assert!(bound < 1e-15, "{number} {bound}");
        // Either end is as large: the sign is that of the first.
        let sign = Ball::exact(exact(0).mid.hi.signum() * mode.vector[0].signum());
        for (j, x) in mode.vector.iter().enumerate() {
            let off = (Ball::exact(*x) - sign * exact(j)).abs_upper();
            assert!(off <= bound * (1.0 + 1e-9) + 1e-30, "{number} {j} {off} {bound}");
        }
    }
    // A pendulum, against the same by other means: twice as many digits are refined with images of their own.
    let n = 100;
    let m: Exact = (0..n).map(|i| (0..n).map(|j| RBig::from(n - i.max(j))).collect()).collect();
    let k = diagonal(&(0..n).map(|i| RBig::from(n - i)).collect::<Vec<_>>());
    let pendulum = problem(&m, &k);
    let found = solve(&pendulum, &options).unwrap();
    assert_eq!(found.level, PrecisionLevel::Refined);
    let better = solve(&pendulum, &Options::default().digits(22)).unwrap();
    for (mode, other) in found.modes.iter().zip(&better.modes) {
        let bound = mode.vector_error_bound;
        assert!(bound < 1e-14, "{bound}");
        for (x, y) in mode.vector.iter().zip(&other.vector) {
            assert!((x - y).abs() <= bound + other.vector_error_bound);
        }
        assert!((mode.omega - other.omega).contains_zero());
    }
}

#[test]
fn twenty_five_digits() {
    let (m, k) = chain(&ones(10), &ones(11));
    let spectrum = solve(&problem(&m, &k), &with_digits(25)).unwrap();
    for (j, mode) in spectrum.modes.iter().enumerate() {
        let printed = decimal(&mode.omega, 25);
        assert_eq!((printed.digits, printed.rounding), (25, Rounding::Correct), "{j}");
        // ω = 2 sin(j π / 22)
        let angle = Ball::PI * Ball::exact((j + 1) as f64) / Ball::exact(22.0);
        let closed = angle.sin().scale(1);
        assert!(!(closed - mode.omega).is_positive() && !(closed - mode.omega).is_negative());
    }
}

/// Both with closed forms; the ring's frequencies are double.
#[test]
fn long_chain_and_ring() {
    let n = 120;
    let (m, k) = chain(&ones(n), &ones(n + 1));
    let spectrum = solve(&problem(&m, &k), &Options::default()).unwrap();
    for (j, mode) in spectrum.modes.iter().enumerate() {
        let angle = Ball::PI * Ball::exact((j + 1) as f64) / Ball::exact(2.0 * (n + 1) as f64);
        assert!((angle.sin().scale(1) - mode.omega).contains_zero());
        assert!(mode.omega.radius < 1e-13 * mode.omega.mid.hi);
    }
    let n = 60;
    let (m, mut k) = chain(&ones(n), &ones(n + 1));
    k[0][n - 1] = RBig::from(-1);
    k[n - 1][0] = RBig::from(-1);
    let mut ring = problem(&m, &k);
    ring.zero_vectors = vec![vec![Ball::ONE; n]];
    let spectrum = solve(&ring, &Options::default()).unwrap();
    check_vectors(&ring, &spectrum, 1e-13);
    for (j, mode) in spectrum.modes.iter().enumerate().skip(1) {
        let angle = Ball::PI * Ball::exact(j.div_ceil(2) as f64) / Ball::exact(n as f64);
        assert!((angle.sin().scale(1) - mode.omega).contains_zero());
        assert!(mode.omega.radius < 1e-13 * mode.omega.mid.hi);
        assert!(mode.vector_error_bound < 1e-14, "{}", mode.vector_error_bound);
        assert_eq!(mode.cluster as usize, j.div_ceil(2));
    }
}

#[test]
fn unstable_first_then_zero_then_rising() {
    // Upside down, at rest, and two that oscillate.
    let k = diagonal(&[RBig::from(4), RBig::from(-1), RBig::ZERO, RBig::from(1), RBig::from(-9)]);
    let mut problem = problem(&diagonal(&ones(5)), &k);
    let mut zero = vec![Ball::ZERO; 5];
    zero[2] = Ball::ONE;
    problem.zero_vectors = vec![zero];
    let spectrum = solve(&problem, &Options::default()).unwrap();
    let kinds: Vec<Kind> = spectrum.modes.iter().map(|m| m.kind).collect();
    use Kind::{Oscillation, Unstable, Zero};
    assert_eq!(kinds, [Unstable, Unstable, Zero, Oscillation, Oscillation]);
    for (mode, exact) in spectrum.modes.iter().zip([-9.0, -1.0, 0.0, 1.0, 4.0]) {
        assert!((mode.omega_squared - Ball::exact(exact)).contains_zero());
        assert!(mode.omega_squared.radius <= 1e-28);
    }
    assert_eq!(decimal(&spectrum.modes[0].growth, 10).text, "3.000000000");
    assert!(spectrum.modes[0].omega.is_zero() && spectrum.modes[4].growth.is_zero());
    assert_eq!(spectrum.modes[0].vector, [0.0, 0.0, 0.0, 0.0, 1.0]);
    assert_eq!(spectrum.stability, Stability::Unstable);
    let two = Options::default().lowest(2);
    assert_eq!(solve(&problem, &two).unwrap().modes.len(), 2);
    let none = Options::default().without_vectors();
    assert!(solve(&problem, &none).unwrap().modes[0].vector.is_empty());
}

#[test]
fn degenerate_cluster_has_an_echelon_basis() {
    // Three equal masses in a ring: a zero mode and a pair.
    let k: Exact = (0..3).map(|i| (0..3).map(|j| RBig::from(if i == j { 2 } else { -1 })).collect()).collect();
    let mut problem = problem(&diagonal(&ones(3)), &k);
    problem.zero_vectors = vec![vec![Ball::ONE; 3]];
    let modes = solve(&problem, &Options::default()).unwrap().modes;
    assert_eq!(modes[1].cluster, modes[2].cluster);
    let close = |x: &[f64], y: [f64; 3]| x.iter().zip(y).all(|(a, b)| (a - b).abs() < 1e-15);
    // (1, 0, -1) and, orthogonal to it, the rest of (0, 1, -1).
    let (a, b) = (0.5f64.sqrt(), (1.0f64 / 6.0).sqrt());
    assert!(close(&modes[1].vector, [a, 0.0, -a]), "{:?}", modes[1].vector);
    assert!(close(&modes[2].vector, [-b, 2.0 * b, -b]), "{:?}", modes[2].vector);
    assert!(modes[1].vector_error_bound < 1e-15);
}

#[test]
fn bad_mass_matrices_are_refused_with_a_direction() {
    let unit = diagonal(&ones(2));
    let singular = vec![integers(&[1, 1]), integers(&[1, 1])];
    assert_eq!(
        solve(&problem(&singular, &unit), &Options::default()).unwrap_err(),
        ModesError::NotPositiveDefinite { direction: vec![1.0, -1.0], singular: true }
    );
    let indefinite = vec![integers(&[1, 2]), integers(&[2, 1])];
    assert_eq!(
        solve(&problem(&indefinite, &unit), &Options::default()).unwrap_err(),
        ModesError::NotPositiveDefinite { direction: vec![1.0, -0.5], singular: false }
    );
    let missing = diagonal(&integers(&[1, 0]));
    assert_eq!(
        solve(&problem(&missing, &unit), &Options::default()).unwrap_err(),
        ModesError::NotPositiveDefinite { direction: vec![0.0, 1.0], singular: true }
    );
}

#[test]
fn requests_that_make_no_sense_are_errors() {
    let mut p = problem(&diagonal(&ones(2)), &diagonal(&ones(2)));
    p.zero_vectors = vec![vec![Ball::ONE; 2]];
    assert_eq!(solve(&p, &Options::default()).unwrap_err(), ModesError::ZeroVector { index: 0 });
    p.zero_vectors.clear();
    p.stiffness[1] = Ball::NOT_FINITE;
    assert!(matches!(solve(&p, &Options::default()).unwrap_err(), ModesError::NotFinite { row: 1, column: 0, .. }));
    p.stiffness.pop();
    assert!(matches!(solve(&p, &Options::default()).unwrap_err(), ModesError::Shape { .. }));
    let empty = Problem { dimension: 0, mass: vec![], stiffness: vec![], zero_vectors: vec![] };
    assert!(solve(&empty, &Options::default()).unwrap().modes.is_empty());
}

/// Near neighbours that the start in doubles mixes by a thousandth: the first refinement must not
/// lose sight of their splittings. K = PᵀΛP, M = PᵀP with Λ = 1 + {0, 1, 3, 7, 12} · 10^-e and one
/// eigenvalue far away.
#[test]
fn splittings_at_the_edge_of_doubles() {
    let p: Exact = [
        [3, -1, 2, 0, 1, -2],
        [1, 4, -1, 2, 0, 1],
        [-2, 1, 5, 1, -1, 0],
        [0, 2, 1, 3, 2, -1],
        [1, 0, -1, 2, 4, 1],
        [2, -1, 0, 1, -3, 5],
    ]
    .iter()
    .map(|row| integers(row))
    .collect();
    for exponent in 8..=20 {
        let mut values: Vec<_> =
            [0, 1, 3, 7, 12].iter().map(|&i| ratio(1, 1) + ratio(i, 1) * power_of_ten(-exponent)).collect();
        values.push(ratio(50, 1));
        let congruent = |d: &[dashu_ratio::RBig]| -> Exact {
            (0..6)
                .map(|i| (0..6).map(|j| (0..6).fold(ratio(0, 1), |s, k| s + &p[k][i] * &p[k][j] * &d[k])).collect())
                .collect()
        };
        let mass = congruent(&integers(&[1; 6]));
        let stiffness = congruent(&values);
        let problem = problem(&mass, &stiffness);
        let spectrum = solve(&problem, &with_digits(24)).unwrap();
        check_enclosures(&mass, &stiffness, &spectrum);
        for (mode, value) in spectrum.modes.iter().zip(&values) {
            let b = mode.omega_squared;
            assert!(b.radius < 1e-24, "10^-{exponent}: {b:?}");
            let error = abs(double(b.mid.hi) + double(b.mid.lo) - value);
            assert!(error <= double(b.radius));
        }
        let clusters = spectrum.modes.last().unwrap().cluster;
        assert_eq!(clusters, 5, "10^-{exponent}: all five are told apart");
    }
}
