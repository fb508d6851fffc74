//! Stiffness given as a sum of squares besides its entries: what entries have lost is found.
//!
//! The witness is the count of eigenvalues below a number by exact elimination in fractions.
#![cfg(feature = "engine")]

use crate::modes_support;

use dashu_ratio::RBig;
use librate::modes::{Kind, Options, Stability};
use librate::precision::Ball;
use librate_core::modes::{Source, Spectrum, solve, solve_from};
use librate_core::precision::Factors;
use modes_support::{Exact, ball, chain, check_enclosures, diagonal, integers, power_of_ten, problem};
use proptest::prelude::*;

struct Known(Factors);

impl Source for Known {
    fn factors(&self) -> Option<Factors> {
        Some(self.0.clone())
    }
}

/// One spring: places and coefficients of its elongation, and its stiffness.
type Spring = (Vec<(usize, i64)>, RBig);

fn stiffness(n: usize, springs: &[Spring]) -> Exact {
    let mut k = vec![vec![RBig::ZERO; n]; n];
    for (elongation, strength) in springs {
        for (i, a) in elongation {
            for (j, b) in elongation {
                k[*i][*j] += strength * RBig::from(a * b);
            }
        }
    }
    k
}

fn factors(springs: &[Spring]) -> Factors {
    let mut factors = Factors::default();
    for (elongation, strength) in springs {
        let root = ball(strength).abs().sqrt();
        let entries = elongation.iter().map(|(place, a)| (*place, Ball::from(*a as f64) * root)).collect();
        factors.rows.push((*strength > RBig::ZERO, entries));
    }
    factors
}

fn check(mass: &Exact, springs: &[Spring]) -> Spectrum {
    let k = stiffness(mass.len(), springs);
    let source = Known(factors(springs));
    let spectrum = solve_from(&problem(mass, &k), &source, &Options::default()).unwrap();
    check_enclosures(mass, &k, &spectrum);
    spectrum
}

/// Whether every frequency is known to eleven digits.
fn is_covered(spectrum: &Spectrum) -> bool {
    spectrum.modes.iter().all(|mode| {
        let x = mode.omega_squared;
        mode.kind != Kind::Undecided && x.radius <= 1e-11 * x.mid.hi.abs()
    })
}

/// Fixed at one end, springs 1 and 10^exponent by turns.
fn alternating(n: usize, exponent: i32) -> Vec<Spring> {
    (0..n)
        .map(|i| {
            let strength = power_of_ten(if i % 2 == 0 { 0 } else { exponent });
            let mut elongation = vec![(i, 1)];
            if i > 0 {
                elongation.push((i - 1, -1));
            }
            (elongation, strength)
        })
        .collect()
}

#[test]
fn springs_that_entries_have_lost() {
    for exponent in [20, 30, 40] {
        let springs = alternating(8, exponent);
        let mass = diagonal(&integers(&[1; 8]));
        let k = stiffness(8, &springs);
        if exponent > 20 {
            // In 31 digits nothing is left of the 1 beside 1e40.
            let lost = solve(&problem(&mass, &k), &Options::default()).unwrap();
            assert_eq!(lost.stability, Stability::Undecided);
        }
        let spectrum = check(&mass, &springs);
        assert!(is_covered(&spectrum), "{exponent}: {spectrum:?}");
        assert_eq!(spectrum.stability, Stability::Stable);
    }
}

#[test]
fn a_spring_that_pushes_beside_stiff_ones() {
    let mut springs = alternating(6, 32);
    springs[2].1 = -RBig::from(3) / RBig::from(2);
    let spectrum = check(&diagonal(&integers(&[1, 2, 3, 1, 2, 3])), &springs);
    assert!(is_covered(&spectrum));
    assert_eq!(spectrum.stability, Stability::Unstable);
}

#[test]
fn factors_that_do_not_fit_are_refused() {
    let (mass, k) = chain(&integers(&[1, 1]), &integers(&[1, 1, 1]));
    let mut exact = problem(&mass, &k);
    // Digits that no double-double has, so that the factors are asked for.
    exact.stiffness[0] = exact.stiffness[0].with_added_radius(1e-5);
    for bad in [
        Factors { rows: vec![(true, vec![(2, Ball::ONE)])], rest: Vec::new() },
        Factors { rows: Vec::new(), rest: vec![Ball::ONE; 3] },
        Factors { rows: vec![(true, vec![(0, Ball::NOT_FINITE)])], rest: Vec::new() },
    ] {
        assert!(solve_from(&exact, &Known(bad), &Options::default()).is_err());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    /// Networks of springs between any two masses or a mass and the wall, over forty decades.
    #[test]
    fn graded_networks(
        masses in prop::collection::vec(-6..6i32, 2..6),
        extra in prop::collection::vec((0..6usize, 0..6usize, -20..20i32, any::<bool>()), 0..6),
        wall in prop::collection::vec(-20..20i32, 6),
    ) {
        let n = masses.len();
        let mass = diagonal(&masses.iter().map(|&e| power_of_ten(e)).collect::<Vec<_>>());
        let mut springs: Vec<Spring> =
            (0..n).map(|i| (vec![(i, 1)], power_of_ten(wall[i]))).collect();
        for (i, j, exponent, negative) in extra {
            let (i, j) = (i % n, j % n);
            if i != j {
                let strength = power_of_ten(exponent);
                let strength = if negative && exponent < -10 { -strength } else { strength };
                springs.push((vec![(i, 1), (j, -1)], strength));
            }
        }
        let spectrum = check(&mass, &springs);
        // Where nothing pushes, every frequency is determined to nearly all digits.
        if springs.iter().all(|(_, k)| *k > RBig::ZERO) {
            prop_assert!(is_covered(&spectrum), "{spectrum:?}");
        }
    }
}
