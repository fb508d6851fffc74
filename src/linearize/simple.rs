//! Equilibria that are known without a proof about a box: points of simple numbers at which forces are exactly 0.

use super::assemble::Assembly;
use super::equilibrium::Search;
use super::symbolic::{equilibrium_expressions, forces_vanish};
use crate::model::Model;
use crate::precision::Ball;

/// A search that creeps to where nothing holds a motion to second order ends this near, beside the size of the
/// coordinate or 1.
const NEAR: f64 = 1e-6;

/// Whole multiples of this are simple numbers.
const GRID: f64 = 0.0625;

/// Whether the forces vanish where the model says, or at 0, for any values of the parameters.
pub(super) fn vanishes_identically(model: &Model, assembly: &Assembly) -> bool {
    if assembly.acts_at_rest() {
        return false;
    }
    let mut pool = model.pool.clone();
    let point = equilibrium_expressions(model, &mut pool, None);
    forces_vanish(model, assembly, &point) == Some(true)
}

impl Search<'_> {
    /// Whether the point is an equilibrium as it stands: exact numbers, and forces that are exactly 0.
    pub(super) fn vanishes_exactly(&self, at: &[Ball]) -> bool {
        let force = self.gradient(at);
        self.free
            .iter()
            .all(|i| at[*i].is_exact() && force[*i].is_zero())
    }

    /// A point of simple numbers beside an estimate, where it is an equilibrium.
    pub(super) fn simple_place(&self, at: &[Ball]) -> Option<Vec<Ball>> {
        let mut place = at.to_vec();
        for i in &self.free {
            let own = at[*i].mid_f64();
            let simple = (own / GRID).round() * GRID;
            let off = (simple - own).abs();
            if off.is_nan() || off > NEAR * own.abs().max(1.0) {
                return None;
            }
            // No negative zero.
            place[*i] = Ball::exact(simple + 0.0);
        }
        let given = self.verify_given(&place, None).is_ok();
        (given && self.vanishes_exactly(&place)).then_some(place)
    }
}
