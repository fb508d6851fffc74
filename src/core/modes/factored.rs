//! The stiffness as a sum of squares, K = Σ ± a aᵀ + rest.
//!
//! A sum of entries loses what is soft beside what is stiff. The energies (a·x)² keep it: the error of
//! Σ (a·x_i)(a·x_j) is small beside the energies themselves, not beside the stiffest spring. And where
//! all squares are positive, the modes are the singular vectors of the matrix of the a, which
//! one-sided Jacobi rotations find with small relative errors however they are graded (Demmel,
//! Veselic, "Jacobi's method is more accurate than QR", SIAM J. Matrix Anal. 13 (1992); with a
//! pivoted QR decomposition before it Drmac, Veselic, "New fast and accurate Jacobi SVD algorithm",
//! ibid. 29 (2008)).

use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par};

use super::dense::{Columns, Matrix, Plain};
use super::pencil::{Enclosed, Scaled};
use super::product::{Part, TERM, bound_product, measured_product, product_bound, product_sparse};
use super::start::cholesky;
use super::{ModesError, Which};
use crate::order::{Order, places};
use crate::precision::{Ball, Factors, up};

/// Factors in scaled coordinates.
pub(super) struct Factored {
    /// The vectors a, one a column.
    columns: Columns,
    /// Of each a: whether its square is subtracted.
    negative: Vec<bool>,
    rest: Option<Enclosed>,
}

impl Factored {
    /// # Errors
    /// [`ModesError::Shape`] and [`ModesError::NotFinite`] where the factors are not those of an n by n
    /// matrix.
    pub(super) fn new(scaled: &Scaled, factors: &Factors) -> Result<Self, ModesError> {
        let n = scaled.n;
        let half = scaled.power / 2;
        let mut columns = Columns::default();
        for (number, (_, entries)) in factors.rows.iter().enumerate() {
            let unit = product_bound(entries.len());
            for (place, entry) in entries {
                if *place >= n {
                    return Err(ModesError::Shape { matrix: Which::Stiffness, expected: n, found: *place + 1 });
                }
                let entry = entry.scale(scaled.shift[*place] - half);
                if !entry.is_finite() {
                    return Err(ModesError::NotFinite { matrix: Which::Stiffness, row: *place, column: number });
                }
                columns.push(*place, entry.mid, up(entry.radius + unit * entry.mid.hi.abs()));
            }
            columns.end();
        }
        let rest = if factors.rest.is_empty() {
            None
        } else if factors.rest.len() == n * n {
            Some(Enclosed::symmetric(n, &factors.rest, &scaled.shift, scaled.power))
        } else {
            return Err(ModesError::Shape { matrix: Which::Stiffness, expected: n * n, found: factors.rest.len() });
        };
        Ok(Self { columns, negative: factors.rows.iter().map(|(positive, _)| !positive).collect(), rest })
    }

    /// XᵀKX.
    ///
    /// With E = XᵀA off by at most D, |fl(EEᵀ) - EEᵀ| <= c |E||E|ᵀ + noise for c and noise of
    /// [`measured_product`], and |EEᵀ - (E ± D)(E ± D)ᵀ| <= |E|Dᵀ + D(|E| + D)ᵀ; signs change nothing of that.
    pub(super) fn form(&self, x: &Matrix) -> Enclosed {
        let xt = x.transposed();
        let elongation = product_sparse(&xt, &self.columns);
        let count = elongation.columns;
        let mut off = Plain::zeros(xt.rows, count);
        for (element, range) in self.columns.starts.windows(2).enumerate() {
            let off = off.column_mut(element);
            self.columns.add_weighted(element, &xt, off);
            // Sums of at most n terms, and the low parts of x.
            let factor = 1.0 + 4.0 * (range[1] - range[0] + 4) as f64 * f64::EPSILON;
            off.iter_mut().for_each(|off| *off *= factor);
        }
        let sizes = elongation.magnitudes();
        let near = Plain::from_fn(xt.rows, count, |row, at| up(TERM * sizes.get(row, at) + off.get(row, at)));
        let far = Plain::from_fn(xt.rows, count, |row, at| up(sizes.get(row, at) + off.get(row, at)));
        let mut radius = bound_product(&near, &far.transposed());
        let other = bound_product(&sizes, &off.transposed());
        let mut signed = elongation.clone();
        for (element, negative) in self.negative.iter().enumerate() {
            if *negative {
                let (hi, lo) = signed.column_mut(element);
                hi.iter_mut().chain(lo).for_each(|x| *x = -*x);
            }
        }
        let (mut mid, noise) = measured_product(&signed, &elongation.transposed(), Part::Lower);
        let rest = self.rest.as_ref().map(|rest| rest.congruent(x, &xt));
        for column in 0..radius.columns {
            for row in 0..radius.rows {
                let mut total = radius.get(row, column) + other.get(row, column) + noise.get(row, column);
                if let Some(rest) = &rest {
                    let sum = Ball::new(mid.get(row, column), 0.0) + rest.ball(row, column);
                    mid.set(row, column, sum.mid);
                    total += sum.radius;
                }
                radius.set(row, column, up(total));
            }
        }
        Enclosed::general(mid, radius)
    }

    /// Approximate eigenvectors where K is a sum of positive squares and nothing else; `None` otherwise.
    pub(super) fn singular_vectors(&self, scaled: &Scaled, count: usize) -> Option<Matrix> {
        let stressed = self.rest.as_ref().is_some_and(|rest| !rest.is_negligible());
        if stressed || self.negative.contains(&true) || count == 0 {
            return None;
        }
        let n = scaled.n;
        let elements = self.negative.len();
        let lower = cholesky(&scaled.mass.mid.doubles(), 0.0)?;
        // Rows by falling size, which keeps what is soft apart from what is stiff (Cox, Higham,
        // "Stability of Householder QR factorization for weighted least squares problems", 1998).
        let range = |e: usize| self.columns.starts[e]..self.columns.starts[e + 1];
        let size = |e: &usize| {
            let entries = self.columns.hi[range(*e)].iter();
            entries.fold(0.0_f64, |most, x| most.max(x.abs()))
        };
        let order = places(elements, &mut |a, b| size(b).total_cmp(&size(a)));
        let mut weighted = Mat::<f64>::zeros(n, elements);
        for (to, &e) in order.iter().enumerate() {
            for at in range(e) {
                weighted[(self.columns.places[at], to)] += self.columns.hi[at];
            }
        }
        solve_lower_triangular_in_place(lower.as_ref(), weighted.as_mut(), Par::Seq);
        let qr = weighted.transpose().to_owned().col_piv_qr();
        let r = qr.thin_R();
        let (forward, _) = qr.P().arrays();
        let rank = r.nrows();
        if rank < count {
            return None;
        }
        // The columns of Rᵀ; rotated until they are orthogonal they are the right singular vectors.
        let mut columns: Vec<Vec<f64>> =
            (0..rank).map(|k| (0..n).map(|i| if i >= k { r[(k, i)] } else { 0.0 }).collect()).collect();
        rotate(&mut columns);
        let mut lengths: Vec<(usize, f64)> = columns.iter().map(|c| length(c)).enumerate().collect();
        lengths.order_by(|a, b| b.1.total_cmp(&a.1));
        let mut vectors = Mat::<f64>::zeros(n, count);
        for (to, &(from, length)) in lengths[..count].iter().enumerate() {
            if length.is_nan() || length <= 0.0 {
                return None;
            }
            for (i, value) in columns[from].iter().enumerate() {
                vectors[(forward[i], to)] = value / length;
            }
        }
        solve_upper_triangular_in_place(lower.transpose(), vectors.as_mut(), Par::Seq);
        Some(Matrix::from_doubles(vectors.as_ref()))
    }
}

fn length(x: &[f64]) -> f64 {
    // Entries may be as small as the square root of the smallest double: scaled first.
    let largest = x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    let sum: f64 = x.iter().map(|x| (x / largest) * (x / largest)).sum();
    largest * sum.sqrt()
}

/// One-sided Jacobi rotations until all columns are orthogonal to rounding.
fn rotate(columns: &mut [Vec<f64>]) {
    let count = columns.len();
    for _ in 0..30 {
        let mut rotated = false;
        for q in 1..count {
            let (before, after) = columns.split_at_mut(q);
            let second = &mut after[0];
            for first in before {
                let (a, b) = (length(first), length(second));
                if a == 0.0 || b == 0.0 {
                    continue;
                }
                let cosine: f64 = first.iter().zip(&*second).map(|(x, y)| (x / a) * (y / b)).sum();
                if cosine.abs() <= 4e-16 * (count as f64).sqrt() || cosine.is_nan() {
                    continue;
                }
                rotated = true;
                // tan of the angle from cot 2θ = (b² - a²) / (2 a b cos).
                let zeta = (b / a - a / b) / (2.0 * cosine);
                let t = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
                let c = 1.0 / t.hypot(1.0);
                let s = c * t;
                for (x, y) in first.iter_mut().zip(second.iter_mut()) {
                    (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
                }
            }
        }
        if !rotated {
            break;
        }
    }
}
