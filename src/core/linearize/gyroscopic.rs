//! Terms linear in the velocities: whether they matter.
//!
//! A term a(q)·q' of the Lagrangian gives the gyroscopic matrix G_ij = ∂a_i/∂q_j - ∂a_j/∂q_i. It
//! vanishes where the term is a total time derivative, and then the model is one without.

use std::collections::BTreeMap;

use super::assemble::VelocityLinear;
use super::symbolic::instance;
use crate::expr::{ExprId, ZeroVerdict};
use crate::model::Model;

/// Whether the gyroscopic matrix is proved to be zero at a point of expressions.
pub(crate) fn vanishes(model: &mut Model, linear: &[VelocityLinear], point: &[ExprId]) -> bool {
    let mut entries: BTreeMap<(u32, u32), Vec<ExprId>> = BTreeMap::new();
    let mut pool = std::mem::take(&mut model.pool);
    for term in linear {
        for at in 0..term.family.count {
            let coordinates = term.family.coordinates_of(at);
            let map = instance(model, &mut pool, &term.family, at, Some(point));
            for (i, coefficient) in &term.coefficients {
                for (j, local) in term.family.locals.iter().enumerate() {
                    let slope = pool.diff(*coefficient, local.coordinate);
                    let slope = pool.substitute(&[slope], &map)[0];
                    let (row, column) = (coordinates[*i], coordinates[j]);
                    let (key, value) =
                        if row < column { ((row, column), slope) } else { ((column, row), pool.neg(slope)) };
                    if row != column {
                        entries.entry(key).or_default().push(value);
                    }
                }
            }
        }
    }
    let vanish = entries.values().all(|parts| {
        let entry = pool.sum(parts);
        pool.is_zero(entry) == ZeroVerdict::Zero
    });
    model.pool = pool;
    vanish
}
