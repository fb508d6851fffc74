//! More digits than double-double has, and problems that it can't solve, against exact counts of
//! eigenvalues at the ends of every printed number.

#![cfg(feature = "engine")]

use crate::modes_support;

use dashu_ratio::RBig;
use librate::modes::{Kind, Options, Stability};
use librate::precision::{Big, Rounding};
use librate_core::modes::{ModesError, PreciseProblem, Source, Spectrum, solve, solve_from};
use librate_core::precision::Magnitude;
use modes_support::precise::*;
use modes_support::*;
use proptest::prelude::*;

fn ones(n: usize) -> Vec<RBig> {
    vec![RBig::ONE; n]
}

fn hilbert(n: i64) -> Exact {
    (0..n).map(|i| (0..n).map(|j| ratio(1, i + j + 1)).collect()).collect()
}

fn check(mass: &Exact, stiffness: &Exact, digits: usize) {
    let (spectrum, _) = solved_precisely(mass, stiffness, &[], &with_digits(digits));
    assert_eq!(spectrum.modes.len(), mass.len());
    check_printed(mass, stiffness, &spectrum, digits);
}

#[test]
fn a_hundred_digits_of_a_chain() {
    let (m, k) = chain(&ones(20), &ones(21));
    check(&m, &k, 100);
    // 2 sin(pi / 6) = 1 for the seventh of twenty: pi k / (2 (n + 1)) with n + 1 = 21.
    let (spectrum, asked) = solved_precisely(&m, &k, &[], &with_digits(100));
    assert_eq!(printed(&spectrum.modes[6], 100).0, format!("1.{}", "0".repeat(99)));
    assert_eq!(asked.len(), 1);
    let (spectrum, asked) = solved_precisely(&m, &k, &[], &with_digits(20));
    assert!(asked.is_empty() && spectrum.modes.iter().all(|m| m.precise.is_none()));
    check(&m, &k, 250);
}

#[test]
fn only_columns_that_need_it() {
    let (m, k) = chain(&ones(12), &ones(13));
    let options = with_digits(60).lowest(2);
    let (spectrum, _) = solved_precisely(&m, &k, &[], &options);
    assert_eq!(spectrum.modes.len(), 2);
    check_printed(&m, &k, &spectrum, 60);
    let options = with_digits(200).lowest(3);
    let (spectrum, _) = solved_precisely(&m, &k, &[], &options);
    check_printed(&m, &k, &spectrum, 200);
    // A few of many, taken on from what doubles give.
    let springs = [vec![RBig::ZERO], ones(59), vec![RBig::ZERO]].concat();
    let (m, k) = chain(&ones(60), &springs);
    let (spectrum, asked) = solved_precisely(&m, &k, &[ones(60)], &with_digits(100).lowest(5));
    assert!(spectrum.modes.len() == 5 && asked.len() == 1, "{asked:?}");
    check_printed(&m, &k, &spectrum, 100);
    check_vectors_of(&spectrum, 1e-14);
    let (m, k) = ring(40);
    let (spectrum, _) = solved_precisely(&m, &k, &[ones(40)], &with_digits(100).lowest(5));
    check_printed(&m, &k, &spectrum, 100);
    check_vectors_of(&spectrum, 1e-12);
}

/// All bounds below a limit, and the shapes as long as they should be in unit masses.
fn check_vectors_of(spectrum: &Spectrum, limit: f64) {
    for mode in &spectrum.modes {
        let square: f64 = mode.vector.iter().map(|x| x * x).sum();
        assert!(mode.vector_error_bound < limit, "{}", mode.vector_error_bound);
        assert!((square - 1.0).abs() < 1e-12);
    }
}

#[test]
fn ill_conditioned_mass_matrices() {
    check(&hilbert(12), &diagonal(&ones(12)), 100);
    check(&hilbert(20), &diagonal(&ones(20)), 10);
    check(&hilbert(16), &diagonal(&ones(16)), 100);
}

#[test]
fn ill_conditioned_with_a_zero_mode() {
    // Relative coordinates of a free chain in a bad basis: K z = 0 for z = (1, ..., 1).
    let (_, k) = chain(&ones(18), &[vec![RBig::ZERO], ones(17), vec![RBig::ZERO]].concat());
    let m = hilbert(18);
    let (spectrum, _) = solved_precisely(&m, &k, &[ones(18)], &with_digits(40));
    assert_eq!(spectrum.stability, Stability::Neutral);
    check_printed(&m, &k, &spectrum, 40);
}

#[test]
fn beyond_the_range_of_double_double() {
    let springs: Vec<RBig> = (0..7).map(|i| power_of_ten(60 * (i % 2))).collect();
    let (m, k) = chain(&ones(6), &springs);
    check(&m, &k, 10);
    check(&m, &k, 60);
}

#[test]
fn stiff_springs_beside_soft_ones() {
    let springs: Vec<RBig> = (0..11).map(|i| power_of_ten(30 * (i % 2))).collect();
    let (m, k) = chain(&ones(10), &springs);
    check(&m, &k, 10);
    check(&m, &k, 100);
}

fn pair(coupling: i32) -> (Exact, Exact) {
    let (g, k) = (ratio(981, 100), power_of_ten(coupling));
    let stiffness = vec![vec![&g + &k, -k.clone()], vec![-k.clone(), &g + &k]];
    (diagonal(&ones(2)), stiffness)
}

#[test]
fn nearly_equal_pairs() {
    for coupling in [-40, -60, -99] {
        let (m, k) = pair(coupling);
        check(&m, &k, 100);
        let (spectrum, _) = solved_precisely(&m, &k, &[], &with_digits(100));
        assert_ne!(spectrum.modes[0].cluster, spectrum.modes[1].cluster, "{coupling} {:?}", spectrum.modes);
        assert!(spectrum.modes.iter().all(|mode| mode.vector_error_bound < 1e-14));
    }
    // For the shapes, more is tried than the digits need: x and y alone are none of them.
    for coupling in [-28, -40, -99] {
        let (m, k) = pair(coupling);
        let (spectrum, _) = solved_precisely(&m, &k, &[], &Options::default());
        for mode in &spectrum.modes {
            assert!(mode.vector_error_bound < 1e-14, "{coupling} {mode:?}");
            let half = |x: &f64| (x.abs() - 0.5_f64.sqrt()).abs() < 1e-14;
            assert!(mode.vector.iter().all(half), "{coupling} {mode:?}");
        }
    }
    // Below the digits that are asked for they may stay together.
    let (m, k) = pair(-130);
    check(&m, &k, 100);
}

fn ring(n: usize) -> (Exact, Exact) {
    let mut k = diagonal(&vec![RBig::from(2); n]);
    for i in 1..=n {
        let (i, j) = (i - 1, i % n);
        k[i][j] = -RBig::ONE;
        k[j][i] = -RBig::ONE;
    }
    (diagonal(&ones(n)), k)
}

#[test]
fn equal_frequencies_and_a_zero_mode() {
    let (m, k) = ring(12);
    let (spectrum, asked) = solved_precisely(&m, &k, &[ones(12)], &with_digits(100));
    assert_eq!(spectrum.stability, Stability::Neutral);
    assert_eq!(spectrum.modes[0].kind, Kind::Zero);
    assert!(spectrum.modes[0].precise.is_none());
    assert_eq!(spectrum.modes[1].cluster, spectrum.modes[2].cluster);
    assert!(asked.len() <= 2, "{asked:?}");
    check_printed(&m, &k, &spectrum, 100);
    assert!(spectrum.modes.iter().all(|mode| mode.vector_error_bound < 1e-14));
    let (m, k) = chain(&ones(15), &[vec![RBig::ZERO], ones(14), vec![RBig::ZERO]].concat());
    let (spectrum, _) = solved_precisely(&m, &k, &[ones(15)], &with_digits(120));
    check_printed(&m, &k, &spectrum, 120);
    // All equal, and exactly so.
    let m = hilbert(5);
    check(&m, &m, 80);
}

#[test]
fn a_zero_that_is_not_proved_stays_open() {
    let (m, k) = chain(&ones(6), &[vec![RBig::ZERO], ones(5), vec![RBig::ZERO]].concat());
    let (spectrum, asked) = solved_precisely(&m, &k, &[], &Options::default());
    assert_eq!(spectrum.modes[0].kind, Kind::Undecided);
    assert!(spectrum.modes[0].omega_squared.abs_upper() < 1e-150);
    // Each time by about half more at least: the last one costs more than all before it.
    assert!(asked.len() <= 4, "{asked:?}");
    assert!(asked.windows(2).all(|pair| 5 * pair[1] >= 7 * pair[0]), "{asked:?}");
    // A sign that takes many bits.
    let (m, mut k) = chain(&ones(3), &[vec![RBig::ZERO], ones(2), vec![RBig::ZERO]].concat());
    k[1][1] = &k[1][1] - power_of_ten(-70);
    let (spectrum, _) = solved_precisely(&m, &k, &[], &Options::default());
    assert_eq!(spectrum.stability, Stability::Unstable);
    check_printed(&m, &k, &spectrum, 10);
}

/// Matrices that are no better known than to 20 digits, whatever is asked.
struct Vague(Exact, Exact);

impl Source for Vague {
    fn precisely(&self, bits: usize) -> Option<PreciseProblem> {
        let radius = Magnitude::from_f64(1e-20);
        let vague = |a: &Exact| -> Vec<Big> {
            let entries = a.iter().flatten();
            entries.map(|x| big(x, bits).with_added_radius(radius)).collect()
        };
        Some(PreciseProblem {
            dimension: self.0.len(),
            mass: vague(&self.0),
            stiffness: vague(&self.1),
            zero_vectors: Vec::new(),
        })
    }
}

#[test]
fn what_is_known_better_stays() {
    let (m, k) = chain(&ones(5), &ones(6));
    let problem = problem(&m, &k);
    let options = with_digits(50);
    let alone = solve(&problem, &options).unwrap();
    let helped = solve_from(&problem, &Vague(m, k), &options).unwrap();
    for (a, b) in alone.modes.iter().zip(&helped.modes) {
        assert!(b.precise.is_none() && b.omega.radius <= a.omega.radius);
        assert!(b.omega.radius < 1e-28);
    }
}

#[test]
fn what_more_precision_does_not_change() {
    // A singular mass matrix stays an error, and an indefinite one.
    let k = diagonal(&ones(2));
    for off in [RBig::ONE, RBig::from(2)] {
        let m = vec![vec![RBig::ONE, off.clone()], vec![off, RBig::ONE]];
        let problem = problem(&m, &k);
        let got = solve(&problem, &Options::default()).unwrap_err();
        assert!(matches!(got, ModesError::NotPositiveDefinite { .. }));
    }
    // 5 / 2 is a tie at one digit.
    let m = diagonal(&[RBig::ONE]);
    let k = diagonal(&[ratio(25, 4)]);
    let (spectrum, _) = solved_precisely(&m, &k, &[], &with_digits(1));
    assert_eq!(printed(&spectrum.modes[0], 1), ("2".to_owned(), Rounding::Tie));
}

/// `PROPTEST_CASES` asks for more than a quick run draws.
fn cases() -> u32 {
    let asked = std::env::var("PROPTEST_CASES").ok();
    asked.and_then(|text| text.parse().ok()).unwrap_or(60)
}

/// AᵀA + small multiples of the unit matrix, symmetric K: sometimes nearly degenerate or graded.
fn pencil() -> impl Strategy<Value = (Exact, Exact)> {
    (2..6usize).prop_flat_map(|n| {
        let entries = proptest::collection::vec(-4..5i64, n * n);
        let stiff = proptest::collection::vec(-3..4i64, n * n);
        let scales = proptest::collection::vec(prop_oneof![3 => Just(0), 1 => -8..9i32], n);
        let shift = prop_oneof![Just(0), Just(20), Just(35)];
        (entries, stiff, scales, shift).prop_map(move |(a, b, s, shift)| {
            let small = power_of_ten(-shift);
            let mut m = diagonal(&vec![small; n]);
            let mut k = diagonal(&vec![RBig::from(3); n]);
            for i in 0..n {
                for j in 0..n {
                    for l in 0..n {
                        let product = RBig::from(a[l * n + i] * a[l * n + j]);
                        m[i][j] = &m[i][j] + &product;
                    }
                    let both = RBig::from(b[i * n + j] + b[j * n + i]) * ratio(1, 3);
                    k[i][j] = &k[i][j] + both;
                }
            }
            let scaled = |x: &Exact| -> Exact {
                (0..n).map(|i| (0..n).map(|j| &x[i][j] * power_of_ten(s[i] + s[j])).collect()).collect()
            };
            (scaled(&m), scaled(&k))
        })
    })
}

/// Masses, and springs between any two of them or a mass and the wall, over forty decades: entries of K lose what is soft.
fn network() -> impl Strategy<Value = (Exact, Exact)> {
    let spring = (0..6usize, 0..6usize, -20..20i32, any::<bool>());
    let walls = proptest::collection::vec((-6..6i32, -20..20i32), 2..6);
    (walls, proptest::collection::vec(spring, 0..6)).prop_map(|(walls, springs)| {
        let n = walls.len();
        let powers =
            |of: &dyn Fn(&(i32, i32)) -> i32| walls.iter().map(|own| power_of_ten(of(own))).collect::<Vec<_>>();
        let (m, mut k) = (diagonal(&powers(&|own| own.0)), diagonal(&powers(&|own| own.1)));
        for (i, j, exponent, pushes) in springs {
            let (i, j) = (i % n, j % n);
            if i != j {
                let strength = power_of_ten(exponent);
                let strength = if pushes && exponent < -10 { -strength } else { strength };
                for (row, column) in [(i, i), (j, j)] {
                    k[row][column] += &strength;
                }
                for (row, column) in [(i, j), (j, i)] {
                    k[row][column] -= &strength;
                }
            }
        }
        (m, k)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(), max_shrink_iters: 100, failure_persistence: None, ..Default::default() })]

    #[test]
    fn random_pencils((m, k) in pencil(), digits in 1..121usize) {
        let (spectrum, _) = solved_precisely(&m, &k, &[], &with_digits(digits));
        if spectrum.modes.iter().all(|mode| mode.kind != Kind::Undecided) {
            check_printed(&m, &k, &spectrum, digits);
        } else {
            // Only what is singular.
            prop_assert_eq!(count_below(&m, &k, &RBig::ZERO).1 > 0, true);
        }
    }

    #[test]
    fn graded_networks((m, k) in network(), digits in 10..16usize) {
        let (spectrum, _) = solved_precisely(&m, &k, &[], &with_digits(digits));
        if count_below(&m, &k, &RBig::ZERO).1 == 0 {
            check_printed(&m, &k, &spectrum, digits);
        }
    }
}
