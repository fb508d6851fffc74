//! Equilibria under constraints: multipliers beside coordinates.
//!
//! Where the coordinates are given, or the origin will do, the multipliers follow from as many forces as there are
//! constraints, and the other forces must then vanish. Otherwise coordinates and multipliers are searched for
//! together, from multipliers that leave the least force at the start.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::assemble::{Assembly, Values};
use super::constrained::{choose_bound, gradients, solve};
use super::dependence;
use super::descent::Energy;
use super::equilibrium::{BITS_TO_VERIFY, Equilibrium, Origin, Search, closed, short};
use super::error::LinearizeError;
use super::symbolic::force_text;
use super::undefined::point_text;
use crate::precision::{Ball, Big, Enclosure};

/// Steps onto the constraints, and halvings of a step along them.
const MOST_ROUNDS: usize = 50;

/// Steps down along the constraints, and the coordinates for which they are taken.
const MOST_SLIDES: usize = 300;
const MOST_SLIDING: usize = 200;

/// Puts the multipliers into a point whose coordinates are known: from the forces on the coordinates `bound`.
/// `None` where these do not determine them.
pub(super) fn put_multipliers_in<S: Enclosure>(
    assembly: &Assembly,
    values: &Values<S>,
    at: &mut [S],
    visible: usize,
    bound: &[usize],
) -> Option<()> {
    let precision = values.precision();
    let order = at.len();
    at[visible..].fill(S::exact(0.0, precision));
    let force = assembly.gradient(at, values);
    let rows = gradients(&assembly.stiffness(at, values), visible, order);
    // With rows R = -∂c/∂q the force is that without multipliers and their sum with R.
    let equation = |i: &usize| rows.iter().map(|row| row[*i].clone()).chain([force[*i].neg()]).collect();
    let found = solve(bound.iter().map(equation).collect(), precision)?;
    for (multiplier, found) in at[visible..].iter_mut().zip(found) {
        *multiplier = found;
    }
    Some(())
}

impl Search<'_> {
    /// An equilibrium under constraints. `point` has the coordinates that are given.
    pub(super) fn constrained(
        &mut self,
        mut point: Vec<Ball>,
        mut origins: Vec<Origin>,
    ) -> Result<Equilibrium, LinearizeError> {
        let visible = self.visible;
        if let Some(found) = self.at_start(&mut point, &origins)? {
            return Ok(found);
        }
        // What is given starts the search, and must be what it ends at.
        let given = point.clone();
        self.free = (0..point.len()).collect();
        for (i, guess) in self.model.guesses.iter().enumerate().take(visible) {
            if origins[i] != Origin::Given
                && let Some(value) = closed(self.model, guess)?
            {
                point[i] = Ball::exact(value.mid_f64());
            }
        }
        for coordinate in &mut point[..visible] {
            *coordinate = Ball::exact(coordinate.mid_f64());
        }
        self.guess_multipliers(&mut point);
        let start = self.gradient(&point);
        let (steps, proof) = self.search_with_zeros(&mut point)?;
        for i in 0..visible {
            if origins[i] == Origin::Given && !(point[i] - given[i]).contains_zero() {
                return Err(self.acts(i, short(-start[i].mid_f64())));
            }
        }
        origins.fill(Origin::Found);
        let proved = proof.is_some() || self.vanishes_exactly(&point);
        Ok(Equilibrium { steps, proved, proof: proof.map(Arc::new), ..Equilibrium::exactly(point, origins) })
    }

    /// The equilibrium where no search is needed: where all of it is given, or all forces vanish at 0 or at the guess.
    pub(super) fn at_start(
        &self,
        point: &mut [Ball],
        origins: &[Origin],
    ) -> Result<Option<Equilibrium>, LinearizeError> {
        let all_given = origins[..self.visible].iter().all(|origin| *origin == Origin::Given);
        let guessed = self.model.guesses.any();
        let given = point.to_vec();
        if all_given || !guessed {
            match self.settled(point) {
                None => {
                    let here = Equilibrium::exactly(point.to_vec(), origins.to_vec());
                    return Ok(Some(Equilibrium { multipliers_given: true, ..here }));
                }
                Some(error) if all_given => return Err(error),
                Some(_) => {}
            }
        }
        if guessed { self.at_guess(&given, origins) } else { Ok(None) }
    }

    /// The equilibrium where the model guesses it, if no force acts there as expressions tell.
    fn at_guess(&self, given: &[Ball], origins: &[Origin]) -> Result<Option<Equilibrium>, LinearizeError> {
        let visible = self.visible;
        let (mut values, mut origins) = (given.to_vec(), origins.to_vec());
        for i in 0..visible {
            if origins[i] != Origin::Given {
                origins[i] = Origin::Found;
                values[i] = closed(self.model, self.model.guesses.get(i))?.unwrap_or(Ball::ZERO);
            }
        }
        let force = self.gradient(&values);
        let broken = |force: &Ball| !force.is_finite() || !force.contains_zero();
        if force[visible..].iter().any(broken)
            || !self.vanishes_with_multipliers()
            || self.settled(&mut values).is_some()
        {
            return Ok(None);
        }
        let here = Equilibrium::exactly(values, origins);
        Ok(Some(Equilibrium { multipliers_given: true, at_guess: true, ..here }))
    }

    /// Multipliers from the coordinates as they are given, or 0; what speaks against an equilibrium there.
    fn settled(&self, point: &mut [Ball]) -> Option<LinearizeError> {
        let visible = self.visible;
        let rows = gradients(&self.assembly.stiffness(point, self.values), visible, point.len());
        let singular = LinearizeError::ConstraintsSingular {
            point: point_text(self.model, &point[..visible]),
            span: self.model.coordinates.at(visible).span,
        };
        let bits = dependence::bits(self.model).unwrap_or(BITS_TO_VERIFY);
        let in_bits = || {
            let values = self.assembly.values::<Big>(self.model, bits).ok()?;
            Some((self.in_bits(point, bits, |value| Some(Big::from_ball(value, bits)))?, values))
        };
        let bound = choose_bound(&rows, None, ()).or_else(|| {
            let (at, values) = in_bits()?;
            let rows = gradients(&self.assembly.stiffness(&at, &values), visible, at.len());
            choose_bound(&rows, None, bits)
        });
        let Some(bound) = bound else { return Some(singular) };
        let found = in_bits().and_then(|(mut at, values)| {
            put_multipliers_in(self.assembly, &values, &mut at, visible, &bound)?;
            let force = self.assembly.gradient(&at, &values);
            Some((at, force))
        });
        let Some((at, force)) = found else { return Some(singular) };
        if put_multipliers_in(self.assembly, self.values, point, visible, &bound).is_none() {
            for (multiplier, own) in point.iter_mut().zip(&at).skip(visible) {
                *multiplier = own.to_ball();
            }
        }
        let rough: Vec<Ball> = force.iter().map(Big::to_ball).collect();
        for (i, force) in force.iter().enumerate() {
            if force.contains_zero() {
                continue;
            }
            let own = -rough[i].mid_f64();
            return Some(if i >= visible {
                let given = self.model.equilibria.given().next().map(|given| given.span);
                let span = self.model.coordinates.at(i).span;
                LinearizeError::ConstraintBroken { difference: short(own), span, given }
            } else if bound.contains(&i) {
                self.acts(i, force_text(self.model, i, own))
            } else {
                self.acts(i, short(own))
            });
        }
        None
    }

    /// Moves coordinates the least way onto the constraints; whether it got there.
    fn move_onto_constraints(&self, at: &mut [Ball]) -> bool {
        let (visible, order) = (self.visible, at.len());
        for _ in 0..MOST_ROUNDS {
            let off = self.gradient(at).split_off(visible);
            let sizes = at[..visible].iter().map(|x| x.mid_f64().abs());
            let scale = sizes.fold(0.0, f64::max);
            let slopes = self.slopes(&self.assembly.stiffness(at, self.values), order);
            let Some(step) = least_squares(slopes, &off) else { return false };
            for (x, step) in at.iter_mut().zip(step.iter()) {
                *x = Ball::exact(x.mid_f64() + step);
            }
            if step.norm() <= 1e-13 * scale || step.norm() == 0.0 {
                return true;
            }
        }
        false
    }

    /// Down the potential along the surface that constraints leave, by Newton steps with |K| in place of K there, near enough to a minimum
    /// for the search to take over; whether it got there.
    pub(super) fn slide(&self, at: &mut [Ball], energy: &Energy<'_>) -> bool {
        let (visible, order) = (self.visible, at.len());
        let height = |at: &[Ball]| {
            let mut free = at.to_vec();
            free[visible..].fill(Ball::ZERO);
            energy.at(&free)
        };
        if visible > MOST_SLIDING || !self.move_onto_constraints(at) {
            return false;
        }
        for _ in 0..MOST_SLIDES {
            // What force the constraints leave is that along the surface.
            self.guess_multipliers(at);
            let stiffness = self.assembly.stiffness(at, self.values);
            let slopes = self.slopes(&stiffness, order);
            let force = DVector::from_iterator(visible, self.gradient(at).iter().take(visible).map(Ball::mid_f64));
            let Ok(inverse) = slopes.clone().pseudo_inverse(1e-12) else { return false };
            let along = DMatrix::identity(visible, visible) - inverse * slopes;
            let second = DMatrix::from_fn(visible, visible, |i, j| stiffness[i + order * j].mid_f64());
            if !second.iter().chain(along.iter()).chain(force.iter()).all(|x| x.is_finite()) {
                return false;
            }
            let eigen = nalgebra::SymmetricEigen::new(&along * second * &along);
            let size = DVector::from_iterator(visible, at.iter().take(visible).map(Ball::mid_f64)).norm();
            let size = if size > 0.0 { size } else { 1.0 };
            // No step is longer than the place is far from 0.
            let least = (force.norm() / size).max(1e-9 * eigen.eigenvalues.amax());
            let mut step = DVector::zeros(visible);
            for (value, v) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
                step -= v * (v.dot(&force) / value.abs().max(least));
            }
            if step.norm().is_nan() || step.norm() <= 1e-9 * size {
                return true;
            }
            let (here, mut part) = (height(at), 1.0);
            let lower = (0..MOST_ROUNDS).find_map(|_| {
                let mut there = at.to_vec();
                for (x, step) in there.iter_mut().zip(step.iter()) {
                    *x = Ball::exact(x.mid_f64() + part * step);
                }
                let falls = 1e-4 * part * step.dot(&force).abs();
                part *= 0.5;
                (self.move_onto_constraints(&mut there) && (here - height(&there)).mid_f64() >= falls).then_some(there)
            });
            let Some(lower) = lower else { return true };
            at.copy_from_slice(&lower);
        }
        false
    }

    /// Multipliers that leave the least force.
    fn guess_multipliers(&self, point: &mut [Ball]) {
        let (visible, order) = (self.visible, point.len());
        point[visible..].fill(Ball::ZERO);
        let force = self.gradient(point);
        let slopes = self.slopes(&self.assembly.stiffness(point, self.values), order);
        let Some(found) = least_squares(slopes.transpose(), &force[..visible]) else { return };
        for (multiplier, found) in point[visible..].iter_mut().zip(found.iter()) {
            *multiplier = Ball::exact(*found);
        }
    }

    /// The gradients of the constraints, one row each, about.
    fn slopes(&self, stiffness: &[Ball], order: usize) -> DMatrix<f64> {
        let rows = gradients(stiffness, self.visible, order);
        DMatrix::from_fn(rows.len(), self.visible, |a, i| rows[a][i].mid_f64())
    }
}

/// The shortest x for which Ax is as near -y as it can be.
fn least_squares(a: DMatrix<f64>, y: &[Ball]) -> Option<DVector<f64>> {
    let right = DVector::from_fn(y.len(), |i, _| -y[i].mid_f64());
    let finite = a.iter().chain(right.iter()).all(|x| x.is_finite());
    finite.then(|| a.svd(true, true).solve(&right, 1e-12).ok())?
}
