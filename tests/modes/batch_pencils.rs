//! Parameter studies of random matrices, degenerate, graded and of either sign.
#![cfg(feature = "engine")]

use crate::batch_support;

use batch_support::{check_vectors, model, random};
use librate::batch::{Outcome, Study};
use librate::precision::Ball;
use librate_core::modes::{self, Problem};
use proptest::prelude::*;

/// A model whose matrices are its parameters.
fn any_pencil(n: usize) -> Study {
    let text = format!(
        "param a[1..{n}, 1..{n}] = 1  param b[1..{n}, 1..{n}] = 1
         coord x[1..{n}]
         T = sum(i in 1..{n}, j in 1..{n}, 1/2*a[i,j]*x[i]'*x[j]')
         V = sum(i in 1..{n}, j in 1..{n}, 1/2*b[i,j]*x[i]*x[j])"
    );
    Study::new(model(&text), &["a", "b"]).unwrap()
}

/// M = P Pᵀ + 1 and K = B diag(d) Bᵀ of random P and B, rounded.
fn pencil(n: usize, grades: &[f64], state: &mut u64) -> (Vec<f64>, Vec<f64>) {
    let mut square = |_| -> Vec<f64> { (0..n * n).map(|_| random(state) - 0.5).collect() };
    let (p, b) = (square(0), square(1));
    let mut mass = vec![0.0; n * n];
    let mut stiffness = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let mut m = f64::from(u8::from(i == j));
            let mut k = 0.0;
            for l in 0..n {
                m += p[i + n * l] * p[j + n * l];
                k += b[i + n * l] * grades[l] * b[j + n * l];
            }
            (mass[i + n * j], mass[j + n * i]) = (m, m);
            (stiffness[i + n * j], stiffness[j + n * i]) = (k, k);
        }
    }
    (mass, stiffness)
}

fn check_pencils(n: usize, pencils: &[(Vec<f64>, Vec<f64>)]) -> Result<(), TestCaseError> {
    let study = any_pencil(n);
    let sets: Vec<f64> = pencils.iter().flat_map(|(mass, stiffness)| mass.iter().chain(stiffness).copied()).collect();
    let solutions = study.solve(&sets).unwrap();
    for ((mass, stiffness), own) in pencils.iter().zip(solutions.iter()) {
        prop_assert_eq!(own.mass, &mass[..]);
        prop_assert_eq!(own.stiffness, &stiffness[..]);
        let exact = |matrix: &[f64]| matrix.iter().copied().map(Ball::exact).collect();
        let problem =
            Problem { dimension: n, mass: exact(mass), stiffness: exact(stiffness), zero_vectors: Vec::new() };
        let want = modes::solve(&problem, &Default::default()).unwrap();
        prop_assert_eq!(own.outcome, Outcome::Solved);
        let mut exact: Vec<Ball> = want.modes.iter().map(|mode| mode.omega_squared).collect();
        exact.sort_by(|a, b| a.mid_f64().total_cmp(&b.mid_f64()));
        let largest = exact.iter().fold(0.0_f64, |most, x| most.max(x.mid_f64().abs()));
        for ((value, bound), exact) in own.omega_squared.iter().zip(own.omega_squared_bounds).zip(&exact) {
            let off = (*exact - Ball::exact(*value)).mid_f64().abs();
            prop_assert!(off <= bound + exact.radius, "{off:e} {bound:e}");
            prop_assert!(*bound <= 1e-11 * largest + 1e-200, "{bound:e} of {largest:e}");
        }
        check_vectors("a random pencil", n, &own);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn random_pencils(n in 1_usize..13, seed: u64, kind in 0_u8..4, count in 1_usize..12) {
        let mut state = seed;
        let pencils: Vec<_> = (0..count)
            .map(|_| {
                let grades: Vec<f64> = (0..n)
                    .map(|l| match kind {
                        0 => 1.0 + random(&mut state),
                        // Graded over many decades.
                        1 => 10.0_f64.powf(-12.0 * random(&mut state)),
                        // Rank one: all others are zero, and degenerate.
                        2 => f64::from(u8::from(l == 0)),
                        // Of either sign.
                        _ => random(&mut state) - 0.5,
                    })
                    .collect();
                pencil(n, &grades, &mut state)
            })
            .collect();
        check_pencils(n, &pencils)?;
    }
}

#[test]
fn repeated_and_scaled_eigenvalues() {
    for n in [1, 2, 3, 8, 17] {
        let unit =
            |size: f64| -> Vec<f64> { (0..n * n).map(|at| if at % (n + 1) == 0 { size } else { 0.0 }).collect() };
        let pencils = [
            (unit(1.0), unit(2.0)),
            (unit(1e-27), unit(500.0)),
            (unit(1e30), unit(1e-30)),
            (unit(1e-9), unit(0.0)),
            (unit(3.0), unit(-1.0)),
        ];
        check_pencils(n, &pencils).unwrap();
    }
}

#[test]
fn beyond_the_rotations_every_set_is_decomposed() {
    let n = 45;
    let mut state = 11;
    let pencils: Vec<_> = (0..3)
        .map(|_| {
            let grades: Vec<f64> = (0..n).map(|_| 0.5 + random(&mut state)).collect();
            pencil(n, &grades, &mut state)
        })
        .collect();
    check_pencils(n, &pencils).unwrap();
}
