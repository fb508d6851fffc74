//! Linear systems of a step of the Taylor method.

use super::step::{Real, Trouble};
use librate_core::precision::Matrix;

/// A matrix that equations are solved with again and again.
pub(super) enum Factored<S> {
    Diagonal(Vec<S>),
    /// L and U in one, and which row each one was.
    Full {
        entries: Matrix<S>,
        rows: Vec<usize>,
    },
}

impl<S: Real> Factored<S> {
    /// Elimination with partial pivoting, rows scaled by their largest entries.
    pub(super) fn new(mut entries: Matrix<S>) -> Result<Self, Trouble> {
        let size = |x: &S| x.middle().abs();
        let mut scales: Vec<f64> = entries.rows().map(|row| row.iter().map(size).fold(0.0, f64::max)).collect();
        let order = scales.len();
        let mut rows: Vec<usize> = (0..order).collect();
        for k in 0..order {
            let pivot = (k..order).max_by(|a, b| {
                let of = |row: usize| size(&entries[(row, k)]) / scales[row];
                of(*a).total_cmp(&of(*b))
            });
            let pivot = pivot.unwrap_or(k);
            let value = size(&entries[(pivot, k)]);
            if !(value > 0.0 && value.is_finite()) {
                return Err(Trouble::Singular);
            }
            if pivot != k {
                for column in 0..order {
                    let (own, other) = ((k, column), (pivot, column));
                    (entries[own], entries[other]) = (entries[other], entries[own]);
                }
                rows.swap(pivot, k);
                scales.swap(pivot, k);
            }
            for row in k + 1..order {
                if entries[(row, k)].is_exact_zero() {
                    continue;
                }
                let factor = entries[(row, k)].div(&entries[(k, k)]);
                for column in k + 1..order {
                    let above = &entries[(k, column)];
                    if !above.is_exact_zero() {
                        entries[(row, column)] = entries[(row, column)].sub(&factor.mul(above));
                    }
                }
                entries[(row, k)] = factor;
            }
        }
        Ok(Self::Full { entries, rows })
    }

    /// `x` is memory to work in.
    pub(super) fn solve(&self, right: &mut [S], x: &mut Vec<S>) {
        match self {
            Self::Diagonal(entries) => {
                for (x, entry) in right.iter_mut().zip(entries) {
                    *x = x.div(entry);
                }
            }
            Self::Full { entries, rows } => {
                let order = rows.len();
                x.clear();
                x.extend(rows.iter().map(|row| right[*row]));
                let subtract = |x: &mut [S], i: usize, from: std::ops::Range<usize>| {
                    for j in from {
                        let entry = &entries[(i, j)];
                        if !entry.is_exact_zero() {
                            x[i] = x[i].sub(&entry.mul(&x[j]));
                        }
                    }
                };
                for i in 0..order {
                    subtract(x, i, 0..i);
                }
                for i in (0..order).rev() {
                    subtract(x, i, i + 1..order);
                    x[i] = x[i].div(&entries[(i, i)]);
                }
                right[..order].copy_from_slice(x);
            }
        }
    }
}
