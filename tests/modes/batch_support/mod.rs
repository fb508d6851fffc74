//! What the tests of parameter studies share.

#![allow(dead_code, reason = "each test file uses its share")]

use librate::model::{Model, Settings, TableTexts, elaborate};
use librate::syntax::parse;
use librate_studies::batch::Solution;

pub(crate) fn model(text: &str) -> Model {
    let file = parse(text).unwrap_or_else(|errors| panic!("{errors:?}"));
    elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// Knuth's MMIX generator, between 0 and 1.
pub(crate) fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 53) as f64
}

/// M-orthonormality, the equation itself, and the sign.
pub(crate) fn check_vectors(name: &str, n: usize, own: &Solution<'_>) {
    let product =
        |a: &[f64], x: &[f64]| -> Vec<f64> { (0..n).map(|i| (0..n).map(|j| a[i + n * j] * x[j]).sum()).collect() };
    let dot = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
    let largest = own.omega_squared.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let vectors: Vec<&[f64]> = own.vectors.chunks(n).collect();
    assert_eq!(vectors.len(), n);
    for (i, x) in vectors.iter().enumerate() {
        let (mx, kx) = (product(own.mass, x), product(own.stiffness, x));
        for (j, y) in vectors.iter().enumerate() {
            let unit = f64::from(u8::from(i == j));
            assert!((dot(y, &mx) - unit).abs() < 1e-10, "{name}: vectors {i} and {j}");
            let energy = dot(y, &kx) - unit * own.omega_squared[i];
            assert!(energy.abs() <= 1e-10 * largest, "{name}: vectors {i} and {j}");
        }
        let size = x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let first = x.iter().find(|x| x.abs() >= size * (1.0 - 1e-6)).unwrap();
        assert!(*first > 0.0, "{name}: sign of vector {i}");
    }
}
