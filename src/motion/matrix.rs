//! Linear systems of a step of the Taylor method.

use super::step::{Real, Trouble};

/// A matrix that equations are solved with again and again.
pub(super) enum Matrix<S> {
    Diagonal(Vec<S>),
    /// L and U in one, row by row, and which row each one was.
    Full {
        order: usize,
        entries: Vec<S>,
        rows: Vec<usize>,
    },
}

impl<S: Real> Matrix<S> {
    /// Elimination with partial pivoting, rows scaled by their largest entries.
    pub(super) fn factored(mut entries: Vec<S>, order: usize) -> Result<Self, Trouble> {
        let size = |x: &S| x.middle().abs();
        let mut rows: Vec<usize> = (0..order).collect();
        let mut scales: Vec<f64> =
            entries.chunks(order.max(1)).map(|row| row.iter().map(size).fold(0.0, f64::max)).collect();
        for k in 0..order {
            let pivot = (k..order).max_by(|a, b| {
                let of = |row: usize| size(&entries[order * row + k]) / scales[row];
                of(*a).total_cmp(&of(*b))
            });
            let pivot = pivot.unwrap_or(k);
            let value = size(&entries[order * pivot + k]);
            if !(value > 0.0 && value.is_finite()) {
                return Err(Trouble::Singular);
            }
            if pivot != k {
                for column in 0..order {
                    entries.swap(order * pivot + column, order * k + column);
                }
                rows.swap(pivot, k);
                scales.swap(pivot, k);
            }
            for row in k + 1..order {
                if entries[order * row + k].is_exact_zero() {
                    continue;
                }
                let factor = entries[order * row + k].div(&entries[order * k + k]);
                for column in k + 1..order {
                    let above = &entries[order * k + column];
                    if !above.is_exact_zero() {
                        let part = factor.mul(above);
                        entries[order * row + column] = entries[order * row + column].sub(&part);
                    }
                }
                entries[order * row + k] = factor;
            }
        }
        Ok(Self::Full { order, entries, rows })
    }

    /// `x` is memory to work in.
    pub(super) fn solve(&self, right: &mut [S], x: &mut Vec<S>) {
        match self {
            Self::Diagonal(entries) => {
                for (x, entry) in right.iter_mut().zip(entries) {
                    *x = x.div(entry);
                }
            }
            Self::Full { order, entries, rows } => {
                x.clear();
                x.extend(rows.iter().map(|row| right[*row]));
                for i in 0..*order {
                    for j in 0..i {
                        let entry = &entries[order * i + j];
                        if !entry.is_exact_zero() {
                            x[i] = x[i].sub(&entry.mul(&x[j]));
                        }
                    }
                }
                for i in (0..*order).rev() {
                    for j in i + 1..*order {
                        let entry = &entries[order * i + j];
                        if !entry.is_exact_zero() {
                            x[i] = x[i].sub(&entry.mul(&x[j]));
                        }
                    }
                    x[i] = x[i].div(&entries[order * i + i]);
                }
                right[..*order].copy_from_slice(x);
            }
        }
    }
}
