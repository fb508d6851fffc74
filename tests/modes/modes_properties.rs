//! Random problems with known exact answers: M = PᵀP and K = PᵀΛP for an integer matrix P have the
//! eigenvalues Λ and the M-orthonormal eigenvectors P⁻¹e_k, all rational.

#![cfg(feature = "engine")]

use crate::modes_support;

use std::ops::Range;

use dashu_ratio::RBig;
use librate::modes::{Kind, Options, Stability};
use librate::precision::Ball;
use librate_core::modes::{ModesError, Problem, solve};
use librate_core::precision::DoubleDouble;
use modes_support::*;
use proptest::prelude::*;

/// Gauss-Jordan in exact numbers; `None` if singular.
fn inverse(p: &Exact) -> Option<Exact> {
    let n = p.len();
    let mut a = p.clone();
    let mut b = diagonal(&vec![RBig::ONE; n]);
    for k in 0..n {
        let at = (k..n).find(|&i| a[i][k] != RBig::ZERO)?;
        a.swap(k, at);
        b.swap(k, at);
        let pivot = a[k][k].clone();
        for x in a[k].iter_mut().chain(b[k].iter_mut()) {
            *x = &*x / &pivot;
        }
        for i in 0..n {
            if i == k || a[i][k] == RBig::ZERO {
                continue;
            }
            let factor = a[i][k].clone();
            for j in 0..n {
                let (x, y) = (&factor * &a[k][j], &factor * &b[k][j]);
                a[i][j] = &a[i][j] - &x;
                b[i][j] = &b[i][j] - &y;
            }
        }
    }
    Some(b)
}

/// Pᵀ diag(d) P
fn congruent(p: &Exact, d: &[RBig]) -> Exact {
    let n = p.len();
    (0..n).map(|i| (0..n).map(|j| (0..n).fold(RBig::ZERO, |s, k| s + &p[k][i] * &p[k][j] * &d[k])).collect()).collect()
}

#[derive(Debug)]
struct Case {
    p: Exact,
    values: Vec<RBig>,
}

/// Eigenvalues of all sorts: apart, equal, nearly equal, of either sign, zero, over many decades.
fn eigenvalue() -> impl Strategy<Value = RBig> {
    prop_oneof![
        4 => (-9..20i64).prop_map(RBig::from),
        2 => (1..4i64, 1..25i32).prop_map(|(a, e)| RBig::from(a) + power_of_ten(-e)),
        1 => (1..4i64, -12..12i32).prop_map(|(a, e)| RBig::from(a) * power_of_ten(e)),
        1 => Just(RBig::from(2)),
    ]
}

/// With an integer matrix P that has entries near its diagonal only.
fn case(dimensions: Range<usize>, band: usize) -> impl Strategy<Value = Case> {
    dimensions.prop_flat_map(move |n| {
        let entries = proptest::collection::vec(-5..6i64, n * n);
        let scales = proptest::collection::vec(prop_oneof![4 => Just(0), 1 => -6..7i32], n);
        let values = proptest::collection::vec(eigenvalue(), n);
        (entries, scales, values).prop_map(move |(entries, scales, values)| {
            let p = (0..n)
                .map(|i| {
                    (0..n)
                        .map(|j| {
                            let near = i64::from(i.abs_diff(j) < band);
                            RBig::from(near * entries[i * n + j]) * power_of_ten(scales[j])
                        })
                        .collect()
                })
                .collect();
            Case { p, values }
        })
    })
}

fn float(x: &RBig) -> f64 {
    x.to_f64().value()
}

/// `PROPTEST_CASES` asks for more than a quick run draws.
fn cases() -> u32 {
    let asked = std::env::var("PROPTEST_CASES").ok();
    asked.and_then(|text| text.parse().ok()).unwrap_or(400)
}

/// Eigenvalues, kinds, clusters and vectors against the exact ones.
fn check(case: &Case, prove_zeros: bool) -> Result<(), TestCaseError> {
    let n = case.p.len();
    let Some(inverse) = inverse(&case.p) else {
        return Ok(());
    };
    let mass = congruent(&case.p, &vec![RBig::ONE; n]);
    let stiffness = congruent(&case.p, &case.values);
    let mut problem = problem(&mass, &stiffness);
    let column = |k: usize| -> Vec<RBig> { (0..n).map(|i| inverse[i][k].clone()).collect() };
    let zeros: Vec<usize> = (0..n).filter(|&k| case.values[k] == RBig::ZERO).collect();
    if prove_zeros {
        problem.zero_vectors = zeros.iter().map(|&k| column(k).iter().map(ball).collect()).collect();
    }
    let spectrum = match solve(&problem, &Options::default()) {
        Ok(spectrum) => spectrum,
        // Honest where double-double does not show M to be positive definite.
        Err(ModesError::NotPositiveDefinite { singular: true, .. }) => return Ok(()),
        Err(other) => return Err(TestCaseError::fail(format!("{other}"))),
    };
    prop_assert_eq!(spectrum.modes.len(), n);
    if n < 20 {
        check_enclosures(&mass, &stiffness, &spectrum);
    }

    // Known eigenvalues, one to one.
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| case.values[i].cmp(&case.values[j]));
    let mut modes: Vec<_> = spectrum.modes.iter().collect();
    modes.sort_by(|a, b| a.omega_squared.mid.partial_cmp(&b.omega_squared.mid).unwrap());
    for (mode, &k) in modes.iter().zip(&order) {
        let b = mode.omega_squared;
        let error = abs(double(b.mid.hi) + double(b.mid.lo) - &case.values[k]);
        prop_assert!(error <= double(b.radius), "{b:?} for {}", case.values[k]);
        match mode.kind {
            Kind::Oscillation => prop_assert!(case.values[k] > RBig::ZERO),
            Kind::Unstable => prop_assert!(case.values[k] < RBig::ZERO),
            Kind::Zero => prop_assert!(case.values[k] == RBig::ZERO && prove_zeros),
            Kind::Undecided => prop_assert!(!(prove_zeros && case.values[k] == RBig::ZERO)),
            other => prop_assert!(false, "{other:?}"),
        }
    }
    // The order in which they are printed.
    let rank = |kind: Kind| match kind {
        Kind::Unstable => 0,
        Kind::Zero => 1,
        Kind::Undecided => 2,
        _ => 3,
    };
    prop_assert!(spectrum.modes.windows(2).all(|w| rank(w[0].kind) <= rank(w[1].kind)));
    if spectrum.stability == Stability::Stable {
        prop_assert!(case.values.iter().all(|x| *x > RBig::ZERO));
    }
    // Equal eigenvalues are never told apart.
    for (a, i) in modes.iter().zip(&order) {
        for (b, j) in modes.iter().zip(&order) {
            if case.values[*i] == case.values[*j] {
                prop_assert_eq!(a.cluster, b.cluster);
            }
        }
    }
    // Vectors: the part outside the exact eigenspace of the cluster, in M-length.
    let size: f64 = mass.iter().flatten().map(|x| float(x).abs()).sum::<f64>().sqrt();
    for mode in &modes {
        let v: Vec<RBig> = mode.vector.iter().map(|&x| double(x)).collect();
        let image: Vec<RBig> = (0..n).map(|i| (0..n).fold(RBig::ZERO, |s, j| s + &mass[i][j] * &v[j])).collect();
        let mut rest = v.clone();
        for (other, &k) in modes.iter().zip(&order) {
            if other.cluster == mode.cluster {
                let x = column(k);
                let c = x.iter().zip(&image).fold(RBig::ZERO, |s, (a, b)| s + a * b);
                for (r, x) in rest.iter_mut().zip(&x) {
                    *r = &*r - &(&c * x);
                }
            }
        }
        let square =
            (0..n).fold(RBig::ZERO, |s, i| s + (0..n).fold(RBig::ZERO, |t, j| t + &mass[i][j] * &rest[i] * &rest[j]));
        let length = float(&square).sqrt();
        prop_assert!(
            length <= mode.vector_error_bound * size * (1.0 + 1e-9),
            "{length:e} > {:e}",
            mode.vector_error_bound * size
        );
    }
    // A single mode: component by component, up to its sign.
    for (mode, &k) in modes.iter().zip(&order) {
        if modes.iter().filter(|m| m.cluster == mode.cluster).count() == 1 {
            let x = column(k);
            let sign = if mode.vector.iter().zip(&x).map(|(a, b)| a * float(b)).sum::<f64>() < 0.0 { -1 } else { 1 };
            for (a, b) in mode.vector.iter().zip(&x) {
                let error = abs(double(*a) - b * RBig::from(sign));
                prop_assert!(error <= double(mode.vector_error_bound.min(1e300)));
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(), max_shrink_iters: 300, failure_persistence: None, ..Default::default() })]

    #[test]
    fn eigenvalues_and_vectors_are_where_they_are_said_to_be(case in case(1..7, 7), prove_zeros: bool) {
        check(&case, prove_zeros)?;
    }

    #[test]
    fn any_input_is_answered(
        n in 0..5usize,
        mass in proptest::collection::vec(prop_oneof![-3.0..3.0f64, Just(0.0), Just(1e300), Just(1e-300), Just(f64::NAN), Just(f64::INFINITY)], 25),
        stiffness in proptest::collection::vec(prop_oneof![-3.0..3.0f64, Just(0.0), Just(-1e300), Just(1e-310)], 25),
        radius in prop_oneof![Just(0.0), Just(1e-20), Just(0.5), Just(f64::INFINITY)],
        zeros in 0..3usize,
    ) {
        let flat = |a: &[f64]| -> Vec<Ball> {
            a.iter().take(n * n).map(|&x| Ball { mid: DoubleDouble::exact(x), radius }).collect()
        };
        let zero_vectors = vec![vec![Ball::ONE; n]; zeros];
        let problem = Problem { dimension: n, mass: flat(&mass), stiffness: flat(&stiffness), zero_vectors };
        for vectors in [true, false] {
            let mut options = Options::default().lowest(2).digits(12);
            options.vectors = vectors;
            if let Ok(spectrum) = solve(&problem, &options) {
                prop_assert!(spectrum.modes.len() <= 2);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, max_shrink_iters: 20, failure_persistence: None, ..Default::default() })]

    /// From 20 coordinates on most is done in products of doubles, dense or sparse.
    #[test]
    fn large_problems_keep_their_bounds(dense in case(20..24, 24), sparse in case(20..24, 2), prove_zeros: bool) {
        check(&dense, prove_zeros)?;
        check(&sparse, prove_zeros)?;
    }
}
