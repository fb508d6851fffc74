//! Matrices of expressions, row by row. Sums that are proved to vanish are 0.

use super::multipliers::clear_column;
use crate::expr::{ExprId, Pool};
use crate::model::transposed;
use crate::number::Number;

/// Rows of expressions.
pub(super) type Rows = Vec<Vec<ExprId>>;

/// A sum of products of rows and columns, 0 where it is proved to be.
pub(super) fn product(pool: &mut Pool, left: &Rows, right: &Rows) -> Rows {
    let width = right.first().map_or(0, Vec::len);
    let mut entry = |row: &Vec<ExprId>, column: usize| {
        let parts = row.iter().zip(right).filter(|(a, own)| !a.is_zero() && !own[column].is_zero());
        let parts: Vec<ExprId> = parts.map(|(a, own)| pool.mul(*a, own[column])).collect();
        let sum = pool.sum(&parts);
        if pool.vanishes(sum) { pool.zero() } else { sum }
    };
    left.iter().map(|row| (0..width).map(|column| entry(row, column)).collect()).collect()
}

pub(super) fn scaled(pool: &mut Pool, rows: &Rows, factor: Number) -> Rows {
    let factor = pool.number(factor);
    rows.iter().map(|row| row.iter().map(|e| pool.mul(factor, *e)).collect()).collect()
}

pub(super) fn added(pool: &mut Pool, left: &Rows, right: &Rows) -> Rows {
    let mut both = |(a, b): (&ExprId, &ExprId)| {
        let sum = pool.add(*a, *b);
        if pool.vanishes(sum) { pool.zero() } else { sum }
    };
    left.iter().zip(right).map(|(a, b)| a.iter().zip(b).map(&mut both).collect()).collect()
}

/// A matrix with columns of 0 but for some.
pub(super) fn masked(pool: &Pool, rows: &Rows, kept: &[bool]) -> Rows {
    let entry = |(e, kept): (&ExprId, &bool)| if *kept { *e } else { pool.zero() };
    rows.iter().map(|row| row.iter().zip(kept).map(entry).collect()).collect()
}

/// left - a b
pub(super) fn minus(pool: &mut Pool, left: &Rows, a: &Rows, b: &Rows) -> Rows {
    let own = product(pool, a, b);
    let own = scaled(pool, &own, Number::MINUS_ONE);
    added(pool, left, &own)
}

/// The first so many entries of rows.
pub(super) fn beginning(rows: &[Vec<ExprId>], width: usize) -> Rows {
    rows.iter().map(|row| row[..width].to_vec()).collect()
}

/// The sum of two matrices by the first so many coordinates.
pub(super) fn total(pool: &mut Pool, visible: usize, parts: [Option<&Rows>; 2]) -> Rows {
    let nothing = || vec![vec![pool.zero(); visible]; visible];
    let [first, second] = parts.map(|rows| rows.map_or_else(&nothing, |rows| beginning(&rows[..visible], visible)));
    added(pool, &first, &second)
}

pub(super) fn vanish(rows: &Rows) -> bool {
    rows.iter().flatten().all(|e| e.is_zero())
}

/// Gauss-Jordan elimination in symbols with pivots in given columns, in that order; the rows come in the order of the pivots.
pub(super) fn eliminate(pool: &mut Pool, mut rows: Rows, columns: &[usize]) -> Option<Rows> {
    for (at, column) in columns.iter().enumerate() {
        let found = (at..rows.len()).find(|row| !pool.vanishes(rows[*row][*column]))?;
        rows.swap(at, found);
        clear_column(pool, &mut rows, at, *column);
    }
    Some(rows)
}

/// M, G, C, K and N: what of D and S is symmetric and what is not.
pub(super) fn parts(pool: &mut Pool, mass: Rows, velocity: &Rows, stiffness: &Rows) -> [Option<Rows>; 5] {
    let mut split = |rows: &Rows| {
        let mirrored = transposed(rows);
        let opposite = scaled(pool, &mirrored, Number::MINUS_ONE);
        [&mirrored, &opposite].map(|other| {
            let sum = added(pool, rows, other);
            scaled(pool, &sum, Number::half())
        })
    };
    let [damping, gyroscopic] = split(velocity);
    let [stiffness, circulatory] = split(stiffness);
    let there = |rows: Rows| (!vanish(&rows)).then_some(rows);
    [Some(mass), there(gyroscopic), there(damping), Some(stiffness), there(circulatory)]
}
