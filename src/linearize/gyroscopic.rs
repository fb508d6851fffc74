//! Terms linear in the velocities: whether they matter.
//!
//! A term a(q)·q' of the Lagrangian gives the gyroscopic matrix G_ij = ∂a_i/∂q_j - ∂a_j/∂q_i. It
//! vanishes where the term is a total time derivative, and then nothing has to be supported.

use std::collections::BTreeMap;

use super::assemble::VelocityLinear;
use super::equilibrium::Equilibrium;
use super::error::{Feature, LinearizeError};
use super::symbolic::equilibrium_expressions;
use crate::expr::{ExprId, Substitution, ZeroVerdict};
use crate::model::Model;

/// Refuses a model whose gyroscopic matrix is not zero at the equilibrium.
pub(crate) fn check(
    model: &mut Model,
    linear: &[VelocityLinear],
    equilibrium: &Equilibrium,
) -> Result<(), LinearizeError> {
    if linear.is_empty() {
        return Ok(());
    }
    let mut pool = std::mem::take(&mut model.pool);
    let point = equilibrium_expressions(model, &mut pool, Some(equilibrium));
    model.pool = pool;
    check_symbolic(model, linear, &point)
}

/// The same at a point of expressions.
pub(crate) fn check_symbolic(
    model: &mut Model,
    linear: &[VelocityLinear],
    point: &[ExprId],
) -> Result<(), LinearizeError> {
    let mut entries: BTreeMap<(u32, u32), Vec<ExprId>> = BTreeMap::new();
    let Some(span) = linear.first().map(|term| term.family.span) else {
        return Ok(());
    };
    let pool = &mut model.pool;
    for term in linear {
        for at in 0..term.family.count {
            let coordinates = term.family.coordinates_of(at);
            let mut map = Substitution::default();
            for (local, number) in term.family.locals.iter().zip(coordinates) {
                map.insert(local.coordinate, point[*number as usize]);
            }
            for (symbol, constant) in term.family.values.iter().zip(term.family.constants_of(at)) {
                map.insert(*symbol, *constant);
            }
            for (i, coefficient) in &term.coefficients {
                for (j, local) in term.family.locals.iter().enumerate() {
                    let slope = pool.diff(*coefficient, local.coordinate);
                    let slope = pool.substitute(&[slope], &map)[0];
                    let (row, column) = (coordinates[*i], coordinates[j]);
                    let (key, value) = if row < column {
                        ((row, column), slope)
                    } else {
                        ((column, row), pool.neg(slope))
                    };
                    if row != column {
                        entries.entry(key).or_default().push(value);
                    }
                }
            }
        }
    }
    for parts in entries.values() {
        let entry = pool.sum(parts);
        match pool.is_zero(entry) {
            ZeroVerdict::Zero => {}
            ZeroVerdict::NonZero | ZeroVerdict::Unknown => {
                return Err(LinearizeError::Unsupported {
                    feature: Feature::Gyroscopic,
                    span,
                });
            }
        }
    }
    Ok(())
}
