//! A set of points about a centre: a box on axes that turn with the solutions.
//!
//! The set is all W Q s with |s_i| <= r_i for powers of two W and a nearly orthogonal Q. Its image under a linear map is
//! held by such a set again, with a Q that follows the longest edges: so what is known of some direction is not spread over
//! all of them, and a rotation costs nothing (R. J. Lohner, Einschließung der Lösung gewöhnlicher Anfangs- und
//! Randwertaufgaben, Karlsruhe (1988), and in Computational Ordinary Differential Equations (1992), 425; why it works:
//! N. S. Nedialkov, K. R. Jackson, in Perspectives on Enclosure Methods (2001), 219).

use librate_core::order::Order;
use librate_core::precision::{Ball, Matrix, up};

/// Directions this near to those there are already, beside their lengths, add nothing.
const SAME: f64 = 1e-6;

/// A box on axes of its own.
#[derive(Clone, Debug)]
pub(super) struct Set {
    /// The scales W of the components, powers of two.
    weights: Vec<f64>,
    /// Q.
    axes: Matrix<f64>,
    /// r, along the columns of Q.
    radii: Vec<f64>,
}

impl Set {
    /// A box along the coordinates.
    pub(super) fn new(radii: Vec<f64>) -> Self {
        let n = radii.len();
        Self { weights: vec![1.0; n], axes: Matrix::unit(n, ()), radii }
    }

    /// The scales of the components, powers of two.
    pub(super) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The largest size of each component.
    pub(super) fn spread(&self) -> Vec<f64> {
        let sum = |row: &[f64]| row.iter().zip(&self.radii).fold(0.0, |sum, (q, r)| plus(sum, q.abs() * r));
        self.axes.rows().zip(&self.weights).map(|(row, weight)| weight * sum(row)).collect()
    }

    /// V⁻¹ A W Q for a matrix A, given row by row, and scales V.
    fn turned(&self, matrix: &[Ball], scales: &[f64]) -> Matrix<Ball> {
        let n = self.radii.len();
        let mut turned = Matrix::from_fn(n, n, |_, _| Ball::ZERO);
        for i in 0..n {
            for k in 0..n {
                let entry = matrix[n * i + k];
                if entry.is_zero() {
                    continue;
                }
                let entry = entry * Ball::exact(self.weights[k] / scales[i]);
                for j in 0..n {
                    let axis = self.axes[(k, j)];
                    if axis != 0.0 && self.radii[j] > 0.0 {
                        turned[(i, j)] = turned[(i, j)] + entry * Ball::exact(axis);
                    }
                }
            }
        }
        turned
    }

    /// The largest size of each component of the image under a matrix, given row by row.
    pub(super) fn image(&self, matrix: &[Ball]) -> Vec<f64> {
        let turned = self.turned(matrix, &vec![1.0; self.radii.len()]);
        let row = |row: &[Ball]| row.iter().zip(&self.radii).fold(0.0, |sum, (a, r)| plus(sum, a.abs_upper() * r));
        turned.rows().map(row).collect()
    }

    /// A set that holds the image under a matrix, given row by row, with errors added to each component, on scales of its
    /// own. `None` where axes could not be made orthogonal, as for numbers beyond their range.
    ///
    /// With G = V⁻¹ A W Q the new set is to hold v = G s + V⁻¹ d for |s| <= r, |d| <= errors. For s' with Q' s' = v and
    /// E = 1 - Q'ᵀQ' it is Q'ᵀv = (1 - E) s', thus s' = Q'ᵀv + E s', and with |E| <= epsilon < 1 in the operator norm of
    /// the largest component, |s'| <= |Q'ᵀv|/(1 - epsilon) there. So |s'_i| <= y_i + Σ_j |E_ij| max y/(1 - epsilon) for
    /// y >= |Q'ᵀG| r + |Q'ᵀ| V⁻¹ errors. (E of norm below 1 shows that Q' has an inverse.)
    pub(super) fn moved(&self, matrix: &[Ball], errors: &[f64], scales: Vec<f64>) -> Option<Self> {
        let n = self.radii.len();
        let turned = self.turned(matrix, &scales);
        let axes = self.new_axes(&turned, errors);
        let mut sizes = vec![0.0; n];
        let mut gaps = vec![0.0; n];
        for i in 0..n {
            let axis = |k: usize| axes[(k, i)];
            let mut size = 0.0;
            for (j, radius) in self.radii.iter().enumerate().filter(|(_, r)| **r > 0.0) {
                let along = (0..n).filter(|k| axis(*k) != 0.0);
                let entry = along.fold(Ball::ZERO, |entry, k| entry + Ball::exact(axis(k)) * turned[(k, j)]);
                size = plus(size, entry.abs_upper() * radius);
            }
            for (k, error) in errors.iter().enumerate().filter(|(k, error)| axis(*k) != 0.0 && **error > 0.0) {
                size = plus(size, axis(k).abs() * up(error / scales[k]));
            }
            sizes[i] = size;
            for j in 0..n {
                let entry =
                    (0..n).filter(|k| axis(*k) != 0.0).fold(Ball::exact(f64::from(u8::from(i == j))), |entry, k| {
                        entry - Ball::exact(axis(k)) * Ball::exact(axes[(k, j)])
                    });
                gaps[i] = plus(gaps[i], entry.abs_upper());
            }
        }
        let gap = gaps.iter().fold(0.0_f64, |most, gap| most.max(*gap));
        let largest = sizes.iter().fold(0.0_f64, |most, size| most.max(*size));
        if !(gap < 0.5 && largest.is_finite()) {
            return None;
        }
        let shared = up(largest / (1.0 - gap));
        let radii = sizes.iter().zip(&gaps).map(|(size, gap)| plus(*size, gap * shared)).collect();
        Some(Self { weights: scales, axes, radii })
    }

    /// Orthogonal columns along the longest edges of an image first. Components that neither the image nor an error moves
    /// keep their axis to themselves.
    fn new_axes(&self, turned: &Matrix<Ball>, errors: &[f64]) -> Matrix<f64> {
        let n = self.radii.len();
        let edges = |i: usize| (0..n).any(|j| self.radii[j] > 0.0 && !turned[(i, j)].is_zero());
        let live: Vec<usize> = (0..n).filter(|i| errors[*i] > 0.0 || edges(*i)).collect();
        let edge = |j: usize| -> Vec<f64> {
            live.iter().map(|i| turned[(*i, j)].mid_f64()).map(|x| x * self.radii[j]).collect()
        };
        let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let normal = |v: Vec<f64>| -> Option<Vec<f64>> {
            // Squares of what is as small as errors of many bits vanish.
            let largest = v.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let v: Vec<f64> = v.iter().map(|x| x / largest).collect();
            let size = length(&v);
            (size.is_finite() && size > 0.0).then(|| v.iter().map(|x| x / size).collect())
        };
        let mut edges: Vec<(f64, Vec<f64>)> = (0..n)
            .filter(|j| self.radii[*j] > 0.0)
            .filter_map(|j| {
                let edge = edge(j);
                let largest = edge.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                Some((largest, normal(edge)?))
            })
            .collect();
        edges.order_by(|a, b| b.0.total_cmp(&a.0));
        let units = Matrix::<f64>::unit(live.len(), ());
        let mut basis: Vec<Vec<f64>> = Vec::with_capacity(live.len());
        for mut v in edges.into_iter().map(|edge| edge.1).chain(units.rows().map(<[f64]>::to_vec)) {
            if basis.len() == live.len() {
                break;
            }
            // Twice is enough (B. N. Parlett, The Symmetric Eigenvalue Problem (1980), section 6-9).
            for _ in 0..2 {
                for own in &basis {
                    let share: f64 = own.iter().zip(&v).map(|(a, b)| a * b).sum();
                    for (x, a) in v.iter_mut().zip(own) {
                        *x -= share * a;
                    }
                }
            }
            if length(&v) > SAME
                && let Some(v) = normal(v)
            {
                basis.push(v);
            }
        }
        let mut axes = Matrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j && !live.contains(&i))));
        for (column, axis) in live.iter().zip(&basis) {
            for (row, x) in live.iter().zip(axis) {
                axes[(*row, *column)] = *x;
            }
        }
        axes
    }
}

/// A sum of what is not negative, rounded up; 0 stays 0.
fn plus(sum: f64, part: f64) -> f64 {
    if part == 0.0 { sum } else { up(sum + part) }
}
