//! Vectors that someone else computed, made ready for a proof.

use faer::linalg::solvers::SelfAdjointEigen;
use faer::{Mat, Side};

use super::lanczos::dot;
use super::shifted::Pencil;

/// Vectors that span the same space, with xᵀMx = 1 and diagonal XᵀKX as doubles see it, and these quotients ascending;
/// `None` where the vectors are not independent. n entries a vector, one after the other.
pub(super) fn ritz(pencil: &Pencil, vectors: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
    let n = pencil.dimension();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut image = vec![0.0; n];
    for vector in vectors.chunks_exact(n) {
        let mut own = vector.to_vec();
        for _ in 0..2 {
            for other in &basis {
                pencil.mass.times(&own, &mut image);
                let part = dot(other, &image);
                own.iter_mut().zip(other).for_each(|(x, y)| *x -= part * y);
            }
            pencil.mass.times(&own, &mut image);
            let length = dot(&own, &image).sqrt();
            if !(length.is_finite() && length > 0.0) {
                return None;
            }
            own.iter_mut().for_each(|x| *x /= length);
        }
        basis.push(own);
    }
    let times_stiffness = |own: &Vec<f64>| {
        pencil.stiffness.times(own, &mut image);
        image.clone()
    };
    let images: Vec<Vec<f64>> = basis.iter().map(times_stiffness).collect();
    let k = basis.len();
    let form = Mat::from_fn(k, k, |i, j| 0.5 * (dot(&basis[i], &images[j]) + dot(&basis[j], &images[i])));
    let eigen: SelfAdjointEigen<f64> = form.self_adjoint_eigen(Side::Lower).ok()?;
    let mut turned = vec![0.0; n * k];
    for (j, column) in turned.chunks_exact_mut(n).enumerate() {
        for (i, own) in basis.iter().enumerate() {
            let part = eigen.U()[(i, j)];
            column.iter_mut().zip(own).for_each(|(x, y)| *x += part * y);
        }
    }
    Some((turned, (0..k).map(|j| eigen.S()[j]).collect()))
}
