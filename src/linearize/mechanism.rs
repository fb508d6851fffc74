//! Motions that stretch no element: the kernel of the matrix of all ∇s.
//!
//! Where the forces vanish, sum of phi_e' ∇s_e = 0; if the ∇s_e are linearly independent, every
//! phi_e' is 0 exactly, however the numbers round, and K = sum of phi_e'' ∇s_e∇s_eᵀ. With fewer
//! elements than coordinates its kernel is proved by counting, and balls enclose a basis of it: a
//! pivot whose ball excludes 0 proves the independence of its row. Nothing is concluded where a
//! pivot's ball contains 0.

use super::assemble::{Assembly, Values};
use super::zero::Enclosure;
use crate::number::Number;

/// Elimination of dense rows is for systems of moderate size.
const MOST: usize = 400;

/// Vectors that all ∇s annihilate, one a column without a pivot; `None` where the elements are too
/// many or can't be shown to be independent.
pub(crate) fn kernel<S: Enclosure>(
    assembly: &Assembly,
    at: &[S],
    values: &Values<S>,
) -> Option<Vec<Vec<S>>> {
    let n = at.len();
    if n > MOST {
        return None;
    }
    let number = |value: i64| S::from_number(&Number::from(value), values.precision());
    let (zero, one) = (number(0), number(1));
    let mut rows = assembly.slopes(at, values, n)?;
    let mut pivots: Vec<usize> = Vec::with_capacity(rows.len());
    // Gauss-Jordan elimination, the largest entry of all that are left as pivot.
    for done in 0..rows.len() {
        let mut best: Option<(usize, usize, f64)> = None;
        for (row, own) in rows.iter().enumerate().skip(done) {
            for (column, entry) in own.iter().enumerate() {
                let size = entry.certain_size();
                if size > best.map_or(0.0, |(_, _, size)| size) && !pivots.contains(&column) {
                    best = Some((row, column, size));
                }
            }
        }
        let (row, column, _) = best?;
        rows.swap(done, row);
        let pivot = rows[done][column].clone();
        for entry in &mut rows[done] {
            *entry = entry.div(&pivot);
        }
        let above = rows[done].clone();
        for (row, own) in rows.iter_mut().enumerate() {
            let factor = own[column].clone();
            if row == done || factor.is_exact_zero() {
                continue;
            }
            for (entry, above) in own.iter_mut().zip(&above) {
                *entry = entry.sub(&factor.mul(above));
            }
            own[column] = zero.clone();
        }
        pivots.push(column);
    }
    let free = (0..n).filter(|column| !pivots.contains(column));
    Some(
        free.map(|column| {
            let mut vector = vec![zero.clone(); n];
            vector[column] = one.clone();
            for (row, pivot) in pivots.iter().enumerate() {
                vector[*pivot] = rows[row][column].neg();
            }
            vector
        })
        .collect(),
    )
}
