//! Equations that are linear in what is wanted, solved in symbols.

use librate_core::expr::{ExprId, Pool};

/// X with A X = B, by elimination without exchanges of rows: for an A whose leading minors are not 0, as those of a positive
/// matrix. `None` where an expression of the result is undefined.
pub(crate) fn solved(
    pool: &mut Pool,
    mut matrix: Vec<Vec<ExprId>>,
    mut right: Vec<Vec<ExprId>>,
) -> Option<Vec<Vec<ExprId>>> {
    let n = matrix.len();
    let zero = pool.zero();
    let subtract = |pool: &mut Pool, from: ExprId, factor: ExprId, other: ExprId| {
        if other == zero {
            return from;
        }
        let product = pool.mul(factor, other);
        pool.sub(from, product)
    };
    for k in 0..n {
        for i in k + 1..n {
            if matrix[i][k] == zero {
                continue;
            }
            let factor = pool.div(matrix[i][k], matrix[k][k]);
            for rows in [&mut matrix, &mut right] {
                let (upper, lower) = rows.split_at_mut(i);
                for (entry, other) in lower[0].iter_mut().zip(&upper[k]) {
                    *entry = subtract(pool, *entry, factor, *other);
                }
            }
        }
    }
    for k in (0..n).rev() {
        for j in 0..right[k].len() {
            let mut value = right[k][j];
            for l in k + 1..n {
                if matrix[k][l] != zero {
                    value = subtract(pool, value, matrix[k][l], right[l][j]);
                }
            }
            right[k][j] = pool.div(value, matrix[k][k]);
            if pool.is_undefined(right[k][j]) {
                return None;
            }
        }
    }
    Some(right)
}
