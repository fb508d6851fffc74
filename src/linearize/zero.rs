//! Zero modes are proved: motions along which the potential does not change to second order.
//!
//! [`Symmetry`] gives those that hold everywhere. What the exact
//! matrix K of rational numbers shows beyond that is added, and what counting unstressed elements
//! shows ([`mechanism`]). Smallness of a number proves nothing
//! and is never asked for.

use super::assemble::{Assembly, Values};
use super::symmetry::{Symmetry, symmetries};
use super::{exact, mechanism};
use crate::model::Model;
use crate::precision::{Ball, Big, Scalar};

/// A motion that is proved to cost no energy to second order.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ZeroMode<N = Ball> {
    /// A vector of the kernel of K, one component a coordinate.
    pub vector: Vec<N>,
    /// What it is, in words: "translation", "rotation", …
    pub meaning: String,
}

/// Enclosures that zero modes are worked out in.
pub(crate) trait Enclosure: Scalar {
    /// A double near the number.
    fn middle(&self) -> f64;
    /// About the size of the number, 0 if the number may be 0.
    fn certain_size(&self) -> f64;
}

impl Enclosure for Ball {
    fn middle(&self) -> f64 {
        self.mid_f64()
    }

    fn certain_size(&self) -> f64 {
        self.abs_lower()
    }
}

impl Enclosure for Big {
    fn middle(&self) -> f64 {
        self.mid_f64()
    }

    fn certain_size(&self) -> f64 {
        if self.contains_zero() {
            0.0
        } else {
            self.abs_upper().to_f64()
        }
    }
}

/// The proved zero modes at an equilibrium: linearly independent. `known` is the equilibrium as the
/// model gives it or the search found it, `at` the same in the numbers of `values`.
pub(crate) fn zero_modes<S: Enclosure>(
    model: &Model,
    assembly: &Assembly,
    known: &[Ball],
    at: &[S],
    values: &Values<S>,
) -> Vec<ZeroMode<S>> {
    let precision = values.precision();
    let found = symmetries(model, assembly, &vec![true; at.len()])
        .iter()
        .map(|symmetry| ZeroMode {
            vector: symmetry.vector(at, precision),
            meaning: symmetry.meaning().to_owned(),
        })
        .collect();
    let mut kept = independent(found, Vec::new());
    if let Some(exact) = exact::kernel(model, assembly, known) {
        let rest = exact
            .into_iter()
            .map(|vector| ZeroMode {
                vector: vector
                    .iter()
                    .map(|number| S::from_number(number, precision))
                    .collect(),
                meaning: "no restoring force".to_owned(),
            })
            .collect();
        kept = independent(rest, kept);
    }
    if let Some(mechanism) = mechanism::kernel(assembly, at, values) {
        let rest = mechanism
            .into_iter()
            .map(|vector| ZeroMode {
                vector,
                meaning: "no restoring force".to_owned(),
            })
            .collect();
        kept = independent(rest, kept);
    }
    kept
}

/// Adds those modes that do not depend on the ones kept so far. Dropping one that is nearly
/// dependent loses a proof, never makes a wrong one.
fn independent<S: Enclosure>(
    modes: Vec<ZeroMode<S>>,
    mut kept: Vec<ZeroMode<S>>,
) -> Vec<ZeroMode<S>> {
    let mut sieve = Sieve::default();
    for mode in &kept {
        sieve.accepts(&mode.vector);
    }
    for mode in modes {
        if mode.vector.iter().all(Scalar::is_finite) && sieve.accepts(&mode.vector) {
            kept.push(mode);
        }
    }
    kept
}

/// Those of the symmetries that are independent at a point.
pub(crate) fn independent_symmetries(symmetries: Vec<Symmetry>, at: &[Ball]) -> Vec<Symmetry> {
    let mut sieve = Sieve::default();
    symmetries
        .into_iter()
        .filter(|symmetry| sieve.accepts(&symmetry.vector(at, ())))
        .collect()
}

/// Vectors that depend on earlier ones are held back (Gram-Schmidt).
#[derive(Default)]
struct Sieve {
    basis: Vec<Vec<f64>>,
}

impl Sieve {
    fn accepts<S: Enclosure>(&mut self, vector: &[S]) -> bool {
        let vector: Vec<f64> = vector.iter().map(S::middle).collect();
        let norm = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm == 0.0 || !norm.is_finite() {
            return false;
        }
        let mut rest: Vec<f64> = vector.iter().map(|x| x / norm).collect();
        for _ in 0..2 {
            for other in &self.basis {
                let overlap: f64 = other.iter().zip(&rest).map(|(a, b)| a * b).sum();
                for (x, y) in rest.iter_mut().zip(other) {
                    *x -= overlap * y;
                }
            }
        }
        let left = rest.iter().map(|x| x * x).sum::<f64>().sqrt();
        if left < 1e-7 {
            return false;
        }
        self.basis.push(rest.iter().map(|x| x / left).collect());
        true
    }
}
