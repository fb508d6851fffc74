//! Whether a symmetric matrix is positive definite, proved.

use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par};

use super::super::dense::{Matrix, Plain};
use super::super::product::{Part, TERM, bound_product, measured_product};
use super::scale::Enclosure;
use super::start::cholesky;
use crate::precision::{DoubleDouble, up};

/// Whether the symmetric part of the matrix is shown to be positive definite: with P near the inverse of its Cholesky
/// factor in doubles, P A Pᵀ is diagonally dominant with a positive diagonal, and A is definite where
/// P A Pᵀ is and P is not singular, which follows.
///
/// The rows of P A Pᵀ are dominant in the sense Σ_j |b_ij + b_ji| / 2 < b_ii, which is what the symmetric part
/// needs (Gershgorin).
pub(super) fn is_positive_definite(matrix: &Enclosure) -> bool {
    let n = matrix.mid.rows;
    let doubles = matrix.doubles();
    let symmetric = Mat::from_fn(n, n, |i, j| 0.5 * (doubles[(i, j)] + doubles[(j, i)]));
    let Some(l) = cholesky(&symmetric) else {
        return false;
    };
    let mut p = Mat::<f64>::identity(n, n);
    solve_lower_triangular_in_place(l.as_ref(), p.as_mut(), Par::Seq);
    let (mut rows, mut columns) = (Matrix::zeros(n, n), Matrix::zeros(n, n));
    for j in 0..n {
        for i in 0..n {
            rows.set(i, j, DoubleDouble::exact(p[(i, j)]));
            columns.set(j, i, DoubleDouble::exact(p[(i, j)]));
        }
    }
    let (image, mut error) = matrix.times(&columns);
    let (form, noise) = measured_product(&rows, &image, Part::All);
    for j in 0..n {
        for (e, y) in error.column_mut(j).iter_mut().zip(image.column_hi(j)) {
            *e = up(*e + TERM * y.abs());
        }
    }
    let radius: Plain = bound_product(&rows.magnitudes(), &error, Part::All);
    (0..n).all(|i| {
        let mut rest = 0.0;
        for j in 0..n {
            let bound = radius.get(i, j) + noise.get(i, j) + radius.get(j, i) + noise.get(j, i);
            let sum = (form.get(i, j) + form.get(j, i)).hi.abs() * (1.0 + 1e-15);
            rest += 0.5 * bound;
            if i != j {
                rest += 0.5 * sum;
            }
        }
        // Sums of nonnegative doubles.
        rest * (1.0 + 8.0 * (n as f64 + 2.0) * f64::EPSILON) < form.get(i, i).hi * (1.0 - 1e-15)
    })
}
