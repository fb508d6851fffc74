//! Equilibria that are known without a proof about a box: points of simple numbers at which forces are exactly 0.

use super::equilibrium::{Equilibrium, Search};
use super::parameters::known_values;
use super::symbolic::{forces_vanish, stated};
use super::{exact, multipliers};
use crate::expr::ExprId;
use crate::model::Model;
use crate::precision::Ball;

/// A search that creeps to where nothing holds a motion to second order ends this near, beside the size of the
/// coordinate or 1.
const NEAR: f64 = 1e-6;

/// Whole multiples of this are simple numbers.
const GRID: f64 = 0.0625;

impl Search<'_> {
    /// Whether no force acts where a search is to start: the forces are 0 without any rounding, in exact numbers, or
    /// as expressions.
    pub(super) fn is_equilibrium(&self, start: &Equilibrium, force: &[Ball]) -> bool {
        let mut own = self.free.iter().map(|i| &force[*i]);
        if !own.clone().all(|force| force.is_finite() && force.contains_zero()) {
            return false;
        }
        // A force that is zero within its bounds may still be one.
        own.all(Ball::is_zero)
            || exact::forces_vanish(self.model, self.assembly, start, &self.free)
            || self.vanishes_identically(start.at_guess)
    }

    /// Whether all forces vanish where the model says, or where it guesses, or at 0, for the values of the parameters.
    fn vanishes_identically(&self, guessed: bool) -> bool {
        let vanish = |model| forces_vanish(model, self.assembly, &stated(model, guessed), &known_values(model));
        !self.assembly.acts_at_rest() && vanish(self.model) == Some(true)
    }

    /// The same where the model guesses, with multipliers of constraints that balance the forces.
    pub(super) fn vanishes_with_multipliers(&self) -> bool {
        let model = self.model;
        let expressions: Vec<ExprId> = model.constraints.iter().map(|own| own.expression).collect();
        // Constraints that follow from others have no multiplier.
        if self.visible + expressions.len() != model.coordinates.len() {
            return false;
        }
        let mut pool = model.pool.clone();
        let mut point = stated(model, true);
        let balanced = multipliers::put_in(model, self.assembly, &mut pool, &mut point, &expressions);
        let valued = Model { pool, ..model.clone() };
        balanced.is_some() && forces_vanish(&valued, self.assembly, &point, &known_values(&valued)) == Some(true)
    }

    /// Whether the point is an equilibrium as it stands: exact numbers, and forces that are exactly 0.
    pub(super) fn vanishes_exactly(&self, at: &[Ball]) -> bool {
        let force = self.gradient(at);
        self.free.iter().all(|i| at[*i].is_exact() && force[*i].is_zero())
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
        let given = self.verify_given(&place, self.gradient(&place), None).is_ok();
        (given && self.vanishes_exactly(&place)).then_some(place)
    }
}
