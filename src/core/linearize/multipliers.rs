//! Constraints in symbols: multipliers at an equilibrium that is known in symbols, and the directions that are left.
//!
//! Nothing here gets a number. Pivots are what is not 0 identically; parameters at which one vanishes all the same are
//! the business of those who put values in.

use super::assemble::{Assembly, evaluate_closed};
use super::parameters::known_values;
use super::symbolic::at_rest;
use crate::expr::{ExprId, Pool, Symbol, ZeroVerdict};
use crate::model::Model;
use crate::precision::Ball;

/// Constraints and their multipliers.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SymbolicConstraints {
    /// The multipliers at the equilibrium, for which grad V = sum of multipliers times grad c; one that was found
    /// numerically stands as itself.
    pub multipliers: Vec<ExprId>,
    /// The gradients at the equilibrium, one row a constraint.
    pub gradients: Vec<Vec<ExprId>>,
}

/// Multipliers that balance the forces at a point, put in behind its coordinates; `None` where the forces don't
/// determine them. That they balance the other forces too remains to be seen.
pub(super) fn put_in(
    model: &Model,
    assembly: &Assembly,
    pool: &mut Pool,
    point: &mut [ExprId],
    expressions: &[ExprId],
) -> Option<()> {
    // A model without constraints pays nothing for them.
    if expressions.is_empty() {
        return Some(());
    }
    let visible = point.len() - expressions.len();
    // With multipliers 0: the derivatives of U, and friction.
    let mut forces = at_rest(model, pool, assembly, point);
    let gradients = gradients(model, pool, &point[..visible], expressions);
    let mut rows = Vec::with_capacity(visible);
    for (i, number) in (0..visible).zip(0..) {
        let mut row: Vec<ExprId> = gradients.iter().map(|gradient| gradient[i]).collect();
        row.push(pool.sum(&forces.remove(&number).unwrap_or_default()));
        rows.push(row);
    }
    let is_pivot = |pool: &Pool, e: ExprId| differs_from_zero(model, pool, e);
    let Eliminated { pivots, rows } = eliminate(pool, rows, expressions.len(), &is_pivot)?;
    for (column, row) in pivots {
        point[visible + column] = *rows.get(row)?.last()?;
    }
    Some(())
}

/// Whether an expression is shown to be different from 0: identically, or where that can't be decided, at the values of the
/// parameters.
fn differs_from_zero(model: &Model, pool: &Pool, e: ExprId) -> bool {
    match pool.is_zero(e) {
        ZeroVerdict::Zero => false,
        ZeroVerdict::NonZero => true,
        ZeroVerdict::Unknown => {
            let mut pool = pool.clone();
            let value = pool.substitute_one(e, &known_values(model));
            let value = evaluate_closed::<Ball>(&pool, value, ());
            value.is_some_and(|value| value.is_finite() && !value.contains_zero())
        }
    }
}

/// The gradients of some expressions at a point, one row each.
pub(super) fn gradients(model: &Model, pool: &mut Pool, point: &[ExprId], expressions: &[ExprId]) -> Vec<Vec<ExprId>> {
    let coordinates: Vec<Symbol> = model.coordinates.iter().take(point.len()).map(|own| own.symbol).collect();
    let map = coordinates.iter().copied().zip(point.iter().copied()).collect();
    let mut row = |expression: &ExprId| {
        let slopes = pool.gradient(*expression, &coordinates);
        pool.substitute(&slopes, &map)
    };
    expressions.iter().map(&mut row).collect()
}

/// Rows after elimination.
pub(crate) struct Eliminated {
    /// Where the pivots stand: column and row.
    pub(crate) pivots: Vec<(usize, usize)>,
    pub(crate) rows: Vec<Vec<ExprId>>,
}

/// Gauss-Jordan elimination of the first `wanted` columns, with 1 for each pivot and nothing above and below it. Short
/// pivots first, numbers before all; `is_pivot` says what is different from 0. `None` where the columns are not shown to be independent.
pub(crate) fn eliminate(
    pool: &mut Pool,
    mut rows: Vec<Vec<ExprId>>,
    wanted: usize,
    is_pivot: &dyn Fn(&Pool, ExprId) -> bool,
) -> Option<Eliminated> {
    let mut pivots: Vec<(usize, usize)> = Vec::with_capacity(wanted);
    while pivots.len() < wanted {
        let mut best: Option<(usize, usize, usize)> = None;
        for (row, entries) in rows.iter().enumerate() {
            if pivots.iter().any(|(_, used)| *used == row) {
                continue;
            }
            for (column, entry) in entries.iter().enumerate().take(wanted) {
                if pivots.iter().any(|(used, _)| *used == column) {
                    continue;
                }
                let size = match pool.as_number(*entry) {
                    Some(number) if number.is_zero() => continue,
                    Some(_) => 0,
                    None => pool.reachable(&[*entry]).len(),
                };
                let shorter = best.is_none_or(|(.., other)| size < other);
                if shorter && is_pivot(pool, *entry) {
                    best = Some((column, row, size));
                }
            }
        }
        let (column, row, _) = best?;
        clear_column(pool, &mut rows, row, column);
        pivots.push((column, row));
    }
    Some(Eliminated { pivots, rows })
}

/// A step of Gauss-Jordan elimination in symbols.
pub fn clear_column(pool: &mut Pool, rows: &mut [Vec<ExprId>], row: usize, column: usize) {
    let pivot = rows[row][column];
    let scaled: Vec<ExprId> = rows[row].iter().map(|e| pool.div(*e, pivot)).collect();
    for (at, other) in rows.iter_mut().enumerate() {
        let factor = other[column];
        if at == row || factor.is_zero() {
            continue;
        }
        for (entry, above) in other.iter_mut().zip(&scaled) {
            let part = pool.mul(factor, *above);
            let difference = pool.sub(*entry, part);
            // What cancels is seen to, so that it is no pivot.
            *entry = match pool.is_zero(difference) {
                ZeroVerdict::Zero => pool.zero(),
                ZeroVerdict::NonZero | ZeroVerdict::Unknown => difference,
            };
        }
    }
    rows[row] = scaled;
}
