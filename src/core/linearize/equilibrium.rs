//! The equilibrium: given and verified, zero where the forces vanish there, or searched for.
//!
//! The search is a Newton iteration on the generalised forces, so that saddles and maxima count as
//! well as minima; it works in mass-weighted coordinates, in which forces on coordinates of
//! different units can be compared, and is damped so that the force falls at every step the way the
//! linear model foresees, which keeps it near its start. Where that way ends, the units are those of
//! the stiffness, and then the potential is gone down (`descent`). The forces themselves are evaluated in
//! double-double with bounds: a component whose enclosure holds zero is at rounding level and does not
//! move the point, which is how neutral directions (free bodies) stay where they are. Then a proof is
//! tried that an equilibrium is there ([`Setting`]), which also says how close: that is the radius of
//! the coordinates, which enters the stiffness matrix. Without a proof the radius is an estimate from
//! the last forces.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::assemble::{Assembly, Values, evaluate_closed};
use super::descent::Energy;
use super::error::LinearizeError;
use super::exact;
use super::existence::{Axes, Products, Proof, Setting};
use super::newton::{Force, Spectrum};
use super::parameters::parameters_of;
use super::symbolic::force_text;
use super::symmetry::symmetries;
use super::undefined::{given_not_finite, point_text};
use super::zero::independent_symmetries;
use crate::expr::{ExprId, Pool};
use crate::model::Model;
use crate::precision::{Ball, Big, DoubleDouble, Scalar};

/// Where a coordinate of the equilibrium comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The model gives it.
    Given,
    /// It is zero, and no force acts there.
    Zero,
    /// It was searched for.
    Found,
}

/// The point that is linearized about.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Equilibrium {
    /// The coordinates in SI, each with the radius that it is known to.
    pub values: Vec<Ball>,
    /// Per coordinate: where the value comes from.
    pub origins: Vec<Origin>,
    /// Newton steps of the search; 0 where nothing was searched for.
    pub steps: usize,
    /// Whether it is proved that an equilibrium lies within the radii of the coordinates that were
    /// searched for. True where nothing was searched for. Where it is false (the stiffness is
    /// singular or nearly so, for no symmetry that was found), the radii are an estimate, twice the
    /// last possible Newton step, and so is all that depends on them.
    ///
    /// Coordinates that are given are given: the forces on them are zero to within the rounding of
    /// numbers of 320 bits, or of doubled doubles beside coordinates that are not proved.
    pub proved: bool,
    /// What was shown, unless the forces vanish exactly or nothing was.
    pub(crate) proof: Option<Arc<Proof>>,
    /// The multipliers of constraints follow from the coordinates, which were not searched for.
    pub(crate) multipliers_given: bool,
    /// The coordinates that were to be searched for are those that the search was to start from, exactly.
    pub(crate) at_guess: bool,
}

/// The equilibrium that a model states in full.
///
/// # Errors
/// [`LinearizeError::MissingValue`] where one has none.
pub(super) fn stated(model: &Model) -> Result<Equilibrium, LinearizeError> {
    let (values, _) = given_point(model)?;
    let origins = vec![Origin::Given; values.len()];
    Ok(Equilibrium::exactly(values, origins))
}

impl Equilibrium {
    /// A point where all forces are known to vanish.
    pub(super) fn exactly(values: Vec<Ball>, origins: Vec<Origin>) -> Self {
        Self { values, origins, steps: 0, proved: true, proof: None, multipliers_given: false, at_guess: false }
    }

    /// What a coordinate is exactly, without parameters, where the model says it.
    #[must_use]
    pub fn expression(&self, model: &Model, coordinate: usize) -> Option<ExprId> {
        let stated = match self.origins[coordinate] {
            Origin::Given => &model.equilibria,
            Origin::Found if self.at_guess => &model.guesses,
            Origin::Found | Origin::Zero => return None,
        };
        stated.get(coordinate)?.value
    }

    /// The point in numbers of another type: what the model says exactly, and for the rest what `other` makes of it.
    pub(super) fn in_numbers<S: Scalar>(
        &self,
        model: &Model,
        precision: S::Precision,
        other: impl Fn(&Ball) -> Option<S>,
    ) -> Option<Vec<S>> {
        in_numbers(&model.pool, &self.values, precision, |i| self.expression(model, i), other)
    }

    /// Whether a coordinate was searched for and found beside 0.
    pub(super) fn may_be_zero(&self, i: usize) -> bool {
        self.origins[i] == Origin::Found && self.values[i].contains_zero()
    }

    /// The bits that the proof took.
    pub(super) fn bits(&self) -> usize {
        self.proof.as_ref().map_or(0, |own| own.bits)
    }

    /// What belongs to the first coordinates: those before multipliers.
    pub(super) fn first(&self, count: usize) -> Self {
        let mut own = self.clone();
        own.values.truncate(count);
        own.origins.truncate(count);
        own
    }
}

/// A point in numbers of another type: what is `stated` exactly, by the numbers of coordinates, and for the rest what `other` makes
/// of it.
pub(super) fn in_numbers<S: Scalar>(
    pool: &Pool,
    at: &[Ball],
    precision: S::Precision,
    stated: impl Fn(usize) -> Option<ExprId>,
    other: impl Fn(&Ball) -> Option<S>,
) -> Option<Vec<S>> {
    let number = |(i, value): (usize, &Ball)| {
        stated(i).map_or_else(|| other(value), |exact| evaluate_closed(pool, exact, precision))
    };
    at.iter().enumerate().map(number).collect()
}

/// More Newton steps than this find nothing either.
const MOST_STEPS: usize = 300;

/// A step is short that is no more than this part of the way and of the coordinates, and long from this on.
const SHORT_STEP: f64 = 1e-6;
const LONG_STEP: f64 = 0.25;

/// Halvings of a step that goes too far.
const HALVINGS: usize = 50;

/// Double-double has about so many bits; what lies further apart goes to a radius.
const BITS_OF_BALLS: usize = 128;

/// Beside the size of the coordinates: above the rounding of double-double, below that of doubles.
const ROOM_OF_BALLS: f64 = 1.0 / (1_u128 << 75) as f64;

/// Enough to tell a force of 1e-90 from none.
pub(super) const BITS_TO_VERIFY: usize = 320;

/// What the search works with.
pub(super) struct Search<'a> {
    pub(super) model: &'a Model,
    pub(super) assembly: &'a Assembly,
    pub(super) values: &'a Values<Ball>,
    /// The coordinates that are searched for.
    pub(super) free: Vec<usize>,
    /// The coordinates proper, before multipliers of constraints.
    pub(super) visible: usize,
}

/// What a search came to: steps and a proof, or nothing, and the spectrum where it ended.
enum Outcome {
    Rests(usize, Option<Proof>),
    Stuck(Option<Spectrum>),
}

/// What a coordinate has moved by less than this, beside the largest one, may be rounding.
const NOISE: f64 = 1e-13;
/// Of so many coordinates a proof is tried twice.
const MOST_AGAIN: usize = 30;
/// So many coordinates are put back one by one, where that can't be done with all of them.
const MOST_ALONE: usize = 32;

/// A number that is given, in balls.
pub(super) fn closed(model: &Model, given: Option<crate::model::Given>) -> Result<Option<Ball>, LinearizeError> {
    let Some(given) = given else { return Ok(None) };
    let Some(value) = given.value else {
        let is_missing = |number: &usize| model.parameters[*number].value.is_none();
        let number = parameters_of(model, &[given.symbolic]).into_iter().find(is_missing);
        return Err(super::missing_value(model, number.unwrap_or(0)));
    };
    match super::assemble::evaluate_closed::<Ball>(&model.pool, value, ()) {
        Some(number) if !number.is_finite() => Err(given_not_finite(model, &given)),
        number => Ok(number),
    }
}

/// The point with what is given, and where each coordinate has its place from.
fn given_point(model: &Model) -> Result<(Vec<Ball>, Vec<Origin>), LinearizeError> {
    let count = model.coordinates.len();
    let (mut point, mut origins) = (vec![Ball::ZERO; count], vec![Origin::Zero; count]);
    for i in 0..count {
        if let Some(value) = closed(model, model.equilibria.get(i))? {
            point[i] = value;
            origins[i] = Origin::Given;
        }
    }
    Ok((point, origins))
}

impl<'a> Search<'a> {
    /// Behind the `visible` coordinates there are multipliers of constraints.
    pub(super) fn new(model: &'a Model, assembly: &'a Assembly, values: &'a Values<Ball>, visible: usize) -> Self {
        Self { model, assembly, values, free: Vec::new(), visible }
    }

    /// The equilibrium under constraints where no search is needed: where it is given, or all forces vanish at the start.
    pub(super) fn without_search(&self) -> Result<Option<Equilibrium>, LinearizeError> {
        let (mut point, origins) = given_point(self.model)?;
        self.at_start(&mut point, &origins)
    }
}

/// Finds or verifies the equilibrium.
pub(super) fn find(whole: &Search<'_>) -> Result<Equilibrium, LinearizeError> {
    let Search { model, visible, .. } = *whole;
    let count = model.coordinates.len();
    let (mut point, mut origins) = given_point(model)?;
    let free = (0..count).filter(|i| origins[*i] == Origin::Zero).collect();
    let guessed = model.guesses.any();
    let mut search = Search { free, ..*whole };
    if visible < count {
        return search.constrained(point, origins);
    }
    for i in &search.free {
        if let Some(value) = closed(model, model.guesses.get(*i))? {
            point[*i] = value;
        }
        if guessed {
            origins[*i] = Origin::Found;
        }
    }
    let mut start = Equilibrium { at_guess: guessed, ..Equilibrium::exactly(point, origins) };
    let force = search.gradient(&start.values);
    if search.is_equilibrium(&start, &force) {
        if !guessed {
            search.free.clear();
        }
        search.verify_given(&start.values, force, None)?;
        return Ok(start);
    }
    super::check_size(count)?;
    let mut point = std::mem::take(&mut start.values);
    for i in &search.free {
        start.origins[*i] = Origin::Found;
        point[*i] = Ball::exact(point[*i].mid_f64());
    }
    let (steps, proof) = search.search_with_zeros(&mut point)?;
    search.verify_given(&point, search.gradient(&point), proof.as_ref())?;
    let mut proved = proof.is_some() || search.vanishes_exactly(&point);
    if !proved && let Some(simple) = search.simple_place(&point) {
        (point, proved) = (simple, true);
    }
    Ok(Equilibrium { values: point, steps, proved, proof: proof.map(Arc::new), at_guess: false, ..start })
}

impl Search<'_> {
    pub(super) fn gradient(&self, at: &[Ball]) -> Vec<Ball> {
        self.assembly.gradient(at, self.values)
    }

    fn not_finite(&self, at: &[Ball], what: &str) -> LinearizeError {
        let told = self.assembly.not_finite(self.model, at, self.values, what);
        told.unwrap_or_else(|| LinearizeError::NotFinite {
            what: what.to_owned(),
            point: point_text(self.model, at),
            cause: None,
            span: self.model.kinetic.first().map(|family| family.span).unwrap_or_default(),
        })
    }

    /// Checks that the force vanishes where the equilibrium is given. What double-double leaves open is
    /// asked again with more bits.
    pub(super) fn verify_given(
        &self,
        at: &[Ball],
        mut force: Vec<Ball>,
        proof: Option<&Proof>,
    ) -> Result<(), LinearizeError> {
        if !force.iter().all(Ball::is_finite) {
            return Err(self.not_finite(at, "the force"));
        }
        let mut held: Vec<usize> = (0..at.len()).collect();
        held.retain(|i| self.free.binary_search(i).is_err());
        let open = !self.assembly.unstressed && held.iter().any(|i| !force[*i].is_zero() && force[*i].contains_zero());
        if open && let Some((point, values)) = self.closer(at, proof) {
            force = self.assembly.gradient(&point, &values).iter().map(Big::to_ball).collect();
        }
        let acting = held.into_iter().find(|i| !force[*i].contains_zero());
        acting.map_or(Ok(()), |i| Err(self.acts(i, force_text(self.model, i, -force[i].mid_f64()))))
    }

    /// The error that a force acts on a coordinate.
    pub(super) fn acts(&self, coordinate: usize, force: String) -> LinearizeError {
        let own = self.model.coordinates.at(coordinate);
        let span = self.model.equilibria.get(coordinate).map_or(own.span, |given| given.span);
        LinearizeError::NotAnEquilibrium { coordinate: own.name(), force, span }
    }

    /// A point in numbers of so many bits: what is given exactly, and for the rest what `other` makes of it.
    pub(super) fn in_bits(&self, at: &[Ball], bits: usize, other: impl Fn(&Ball) -> Option<Big>) -> Option<Vec<Big>> {
        in_numbers(&self.model.pool, at, bits, |i| self.model.equilibria.get(i)?.value, other)
    }

    /// A point and the values with [`BITS_TO_VERIFY`] bits, if the place is known as well.
    pub(super) fn closer(&self, at: &[Ball], proof: Option<&Proof>) -> Option<(Vec<Big>, Values<Big>)> {
        let bits = BITS_TO_VERIFY.max(proof.map_or(0, |own| own.bits));
        let values = self.assembly.values::<Big>(self.model, bits).ok()?;
        let known = |value: &Ball| value.is_exact() || proof.is_some();
        let mut point = self.in_bits(at, bits, |value| known(value).then(|| Big::from_ball(value, bits)))?;
        if let Some(proof) = proof {
            point = proof.refine(point, bits, |at: &[Big]| self.assembly.gradient(at, &values))?;
        }
        Some((point, values))
    }

    /// [`Search::search`], but for coordinates that are 0 there exactly, since no force moves them from 0 wherever the others are: these
    /// are searched for no more.
    pub(super) fn search_with_zeros(&mut self, at: &mut Vec<Ball>) -> Result<(usize, Option<Proof>), LinearizeError> {
        let (steps, proof) = self.search(at)?;
        let may_be_zero = |i: &usize| *i < self.visible && at[*i].contains_zero();
        let mut zeros: Vec<usize> = self.free.iter().copied().filter(may_be_zero).collect();
        let mut trial = at.clone();
        // Without any rounding, so wherever the others are in their bounds.
        let mut tried = 0;
        while zeros.len() != tried {
            tried = zeros.len();
            trial.clone_from(at);
            zeros.iter().for_each(|i| trial[*i] = Ball::ZERO);
            let force = self.gradient(&trial);
            zeros.retain(|i| force[*i].is_zero());
        }
        // Without a proof for all it is tried once more for the others, which takes as long.
        if zeros.is_empty() || proof.is_none() && at.len() > MOST_AGAIN {
            return Ok((steps, proof));
        }
        let mut held = Search { free: self.free.clone(), ..*self };
        held.free.retain(|i| zeros.binary_search(i).is_err());
        held.free.iter().for_each(|i| trial[*i] = Ball::exact(at[*i].mid_f64()));
        let rests = |trial: &[Ball]| {
            let force = self.gradient(trial);
            zeros.iter().all(|i| force[*i].is_zero())
        };
        let metric = held.metric(&trial);
        let again = if held.free.is_empty() { Ok(Outcome::Rests(0, None)) } else { held.run(&mut trial, &metric) };
        // It is the same point, where that was proved.
        let meets = |(own, other): (&Ball, &Ball)| (*own - *other).contains_zero();
        if let Ok(Outcome::Rests(_, own)) = again
            && (own.is_some() || held.vanishes_exactly(&trial))
            && (proof.is_none() || trial.iter().zip(at.iter()).all(meets))
            && rests(&trial)
        {
            self.free = held.free;
            *at = trial;
            return Ok((steps, own));
        }
        Ok((steps, proof))
    }

    /// Searches from `at`; gives the number of steps, and a proof if there is one.
    ///
    /// First along the path of Newton steps, with forces compared by the masses, then by the
    /// stiffness; where both paths end, down the potential from the same start.
    pub(super) fn search(&self, at: &mut Vec<Ball>) -> Result<(usize, Option<Proof>), LinearizeError> {
        let start = at.clone();
        let masses = self.metric(&start);
        let spectrum = match self.run(at, &masses)? {
            Outcome::Rests(steps, proof) if proof.is_some() || self.rests(at, &start) => {
                return Ok((steps, proof));
            }
            Outcome::Rests(..) => None,
            Outcome::Stuck(spectrum) => spectrum,
        };
        let spectrum = spectrum.or_else(|| self.spectrum(at, &masses));
        if let Some(error) = self.nowhere(at, &masses, spectrum.as_ref()) {
            return Err(error);
        }
        let metrics = [masses, self.stiffness_metric(&start)];
        let mut trial = start.clone();
        if let Ok(Outcome::Rests(steps, proof)) = self.run(&mut trial, &metrics[1])
            && (proof.is_some() || self.rests(&trial, &start))
        {
            *at = trial;
            return Ok((steps, proof));
        }
        if let Some(energy) = Energy::new(self.model, self.assembly, self.values) {
            for metric in &metrics {
                let mut low = start.clone();
                // With multipliers the potential has no bottom.
                let tied = self.visible < at.len();
                let is_low = if tied { self.slide(&mut low, &energy) } else { self.descend(&mut low, metric, &energy) };
                if !is_low {
                    continue;
                }
                for metric in [metric, &self.stiffness_metric(&low)] {
                    let mut trial = low.clone();
                    // What only fades away with the distance is as flat as a minimum: a proof is asked for.
                    if let Ok(Outcome::Rests(steps, proof)) = self.run(&mut trial, metric)
                        && (proof.is_some() || self.vanishes_exactly(&trial))
                    {
                        *at = trial;
                        return Ok((steps, proof));
                    }
                    // Newton's way in doubles may end far above what many bits can tell.
                    trial.clone_from(&low);
                    if let Some(proof) = self.settle(&mut trial, metric) {
                        *at = trial;
                        return Ok((1, Some(proof)));
                    }
                }
            }
        }
        Err(self.flat_constraint(at, &start).unwrap_or_else(|| self.not_found(at)))
    }

    /// Newton's way from `at`.
    fn run(&self, at: &mut [Ball], metric: &DMatrix<f64>) -> Result<Outcome, LinearizeError> {
        let mut force = self.weighted(&self.gradient(at), metric);
        if !force.finite {
            return Err(self.not_finite(at, "the force"));
        }
        let mut damping = 1.0_f64;
        let mut next = None;
        let mut last = None;
        let (mut way, mut length) = (0.0, f64::INFINITY);
        for step in 0..MOST_STEPS {
            if force.rounding {
                return Ok(Outcome::Rests(step, self.settle(at, metric)));
            }
            let Some(spectrum) = next.take().or_else(|| self.spectrum(at, metric)) else {
                // The stiffness jumps where a contact begins: on to where less force acts.
                let Some(trial) = self.along_force(at, metric, &force) else {
                    return Err(self.not_finite(at, "the stiffness"));
                };
                force = self.weighted(&self.gradient(&trial), metric);
                at.clone_from_slice(&trial);
                continue;
            };
            let newton = spectrum.newton(&force);
            let mut accepted = false;
            damping = (4.0 * damping).min(1.0);
            for attempt in 0..40 {
                let direction = &newton * damping;
                let trial = self.moved(at, metric, &direction);
                let there = self.weighted(&self.gradient(&trial), metric);
                let falls = there.norm < force.norm * (1.0 - 1e-4 * damping);
                let better = there.finite && (falls || there.rounding);
                if better && spectrum.foresaw(&force, &there, damping, direction.norm()) {
                    let changed = self.spectrum(&trial, metric);
                    let alike = changed.as_ref().is_some_and(|changed| changed.resembles(&spectrum, &direction));
                    // A long step may have passed a pole, or another point where no force acts.
                    let size = direction.norm() / (way + self.weighted_size(at, metric));
                    let passes = || {
                        let middle = self.moved(at, metric, &(&direction * 0.5));
                        let there = self.weighted(&self.gradient(&middle), metric);
                        !there.finite || there.norm > 2.0 * force.norm
                    };
                    let near = alike && !(size > LONG_STEP && passes()) || there.rounding && size <= SHORT_STEP;
                    if near {
                        at.clone_from_slice(&trial);
                        force = there;
                        next = changed;
                        length = direction.norm();
                        way += length;
                        accepted = true;
                        break;
                    }
                }
                // Near rounding level the force can't fall any more: a last tiny step is taken.
                let scale = way + self.weighted_size(at, metric);
                let tiny = direction.norm() <= 1e-14 * scale && there.finite && !spectrum.pushes_neutral(&force);
                if tiny && there.norm <= force.norm * 2.0 && attempt == 0 {
                    at.clone_from_slice(&trial);
                    return Ok(Outcome::Rests(step + 1, self.settle(at, metric)));
                }
                damping *= 0.5;
            }
            if !accepted {
                last = Some(spectrum);
                if let Some(trial) = self.along_force(at, metric, &force) {
                    force = self.weighted(&self.gradient(&trial), metric);
                    at.clone_from_slice(&trial);
                    damping = 1.0;
                    continue;
                }
                break;
            }
            if at.iter().any(|x| x.mid_f64().abs() > 1e150) {
                break;
            }
            // Where the stiffness vanishes too, every step is a fixed part of the one before.
            if step + 1 == MOST_STEPS && length <= 1e-20 * way {
                return Ok(Outcome::Rests(MOST_STEPS, self.settle(at, metric)));
            }
        }
        Ok(Outcome::Stuck(last))
    }

    /// The square root of the mass matrix of the free coordinates, with 1 for what has none, as a Cholesky factor; the
    /// unit matrix where it has no such factor.
    fn metric(&self, at: &[Ball]) -> DMatrix<f64> {
        let n = self.model.coordinates.len();
        let m = self.free.len();
        let mass = self.assembly.mass(at, self.values);
        let own = DMatrix::from_fn(m, m, |i, j| {
            let entry = &mass[self.free[i] + n * self.free[j]];
            // A multiplier has no mass, nor has a massless coordinate.
            if i == j && entry.is_zero() { 1.0 } else { entry.mid_f64() }
        });
        match nalgebra::Cholesky::new(own) {
            Some(factor) if factor.l().iter().all(|x| x.is_finite()) => factor.l(),
            Some(_) | None => DMatrix::identity(m, m),
        }
    }

    /// L⁻¹F: the force in mass-weighted coordinates, and whether it is nothing but rounding.
    pub(super) fn weighted(&self, gradient: &[Ball], metric: &DMatrix<f64>) -> Force {
        let own: Vec<&Ball> = self.free.iter().map(|i| &gradient[*i]).collect();
        let raw = DVector::from_iterator(own.len(), own.iter().map(|g| g.mid_f64()));
        let noise = DVector::from_iterator(own.len(), own.iter().map(|g| g.radius));
        let finite = own.iter().all(|g| g.is_finite());
        let rounding = own.iter().all(|g| g.is_finite() && g.contains_zero());
        let vector = metric.solve_lower_triangular(&raw).unwrap_or(raw);
        // |L⁻¹| of the radii is at most the inverse of the comparison matrix of them.
        let m = own.len();
        let comparison = DMatrix::from_fn(m, m, |i, j| {
            let entry = metric[(i, j)].abs();
            if i == j { entry } else { -entry }
        });
        let noise = comparison.solve_lower_triangular(&noise).unwrap_or(noise);
        Force { norm: vector.norm(), noise, vector, finite, rounding }
    }

    /// How far the free coordinates are from 0, in mass-weighted coordinates.
    pub(super) fn weighted_size(&self, at: &[Ball], metric: &DMatrix<f64>) -> f64 {
        let own = self.free.iter().map(|i| at[*i].mid_f64());
        metric.tr_mul(&DVector::from_iterator(self.free.len(), own)).norm()
    }

    pub(super) fn spectrum(&self, at: &[Ball], metric: &DMatrix<f64>) -> Option<Spectrum> {
        let n = self.model.coordinates.len();
        let m = self.free.len();
        let stiffness = self.assembly.stiffness(at, self.values);
        let own = DMatrix::from_fn(m, m, |i, j| stiffness[self.free[i] + n * self.free[j]].mid_f64());
        if !own.iter().all(|x| x.is_finite()) {
            return None;
        }
        let half = metric.solve_lower_triangular(&own)?;
        let both = metric.solve_lower_triangular(&half.transpose())?;
        let mut symmetric = (&both + both.transpose()) * 0.5;
        // Of numbers whose squares underflow nalgebra makes vectors that are none.
        let least = 1e-100 * symmetric.amax();
        symmetric.apply(|x| *x = if x.abs() <= least { 0.0 } else { *x });
        Some(Spectrum { eigen: SymmetricEigen::new(symmetric) })
    }

    /// The point moved by a step in mass-weighted coordinates.
    pub(super) fn moved(&self, at: &[Ball], metric: &DMatrix<f64>, step: &DVector<f64>) -> Vec<Ball> {
        let step = metric.transpose().solve_upper_triangular(step).unwrap_or_else(|| step.clone());
        let mut moved = at.to_vec();
        for (k, i) in self.free.iter().enumerate() {
            // The new point is an exact number: what it is off by is asked of the force.
            let sum = at[*i].mid + DoubleDouble::exact(step[k]);
            moved[*i] = Ball::new(sum, 0.0);
        }
        moved
    }

    /// Where Newton has no way on: steps along the force, both ways, from short to long; then to where it turns round downhill, as in
    /// a contact.
    fn along_force(&self, at: &[Ball], metric: &DMatrix<f64>, force: &Force) -> Option<Vec<Ball>> {
        let unit = &force.vector / force.norm;
        let moved = |length: f64| {
            let trial = self.moved(at, metric, &(&unit * length));
            let there = self.weighted(&self.gradient(&trial), metric);
            (there.finite && there.norm < 0.9 * force.norm, there.vector.dot(&unit), trial)
        };
        let lengths = || (-12..=12).map(|power| 2.0_f64.powi(2 * power - 4));
        let both = lengths().flat_map(|length| [-length, length]);
        both.map(moved).find_map(|(is_less, _, trial)| is_less.then_some(trial)).or_else(|| {
            let mut far = lengths().find(|length| moved(-length).1 < 0.0)?;
            let mut near = 0.25 * far;
            (0..HALVINGS).find_map(|_| {
                let middle = 0.5 * (near + far);
                let (is_less, along, trial) = moved(-middle);
                *if along < 0.0 { &mut far } else { &mut near } = middle;
                is_less.then_some(trial)
            })
        })
    }

    /// Newton steps with double-double forces down to rounding level, then a proof of what is left;
    /// without one, the estimate: twice the last possible step, the noise of the force included.
    fn settle(&self, at: &mut [Ball], metric: &DMatrix<f64>) -> Option<Proof> {
        let spectrum = self.spectrum(at, metric)?;
        // Of a family of equilibria one with simple numbers: what is exact there stays so.
        if spectrum.is_nearly_singular()
            && let Some(place) = exact::beside(self.model, self.assembly, at, &self.free)
        {
            at.clone_from_slice(&place);
        }
        let mut best = f64::INFINITY;
        for _ in 0..8 {
            let gradient = self.gradient(at);
            let force = self.weighted(&gradient, metric);
            if !force.finite || force.norm >= best || force.norm == 0.0 {
                break;
            }
            best = force.norm;
            let trial = self.moved(at, metric, &spectrum.newton(&force));
            let there = self.weighted(&self.gradient(&trial), metric);
            if there.finite && there.norm <= force.norm {
                at.clone_from_slice(&trial);
            } else {
                break;
            }
        }
        self.drop_noise(at, metric);
        if let Some((proof, place)) = self.proof(at, metric, &spectrum) {
            for (i, place) in self.free.iter().zip(place) {
                at[*i] = place;
            }
            return Some(proof);
        }
        let force = self.weighted(&self.gradient(at), metric);
        let left = spectrum.reach(&force);
        let back = metric.transpose().try_inverse().unwrap_or_else(|| DMatrix::identity(left.len(), left.len()));
        let vectors = back * &spectrum.eigen.eigenvectors;
        for (k, i) in self.free.iter().enumerate() {
            let radius: f64 = (0..left.len()).map(|mode| vectors[(k, mode)].abs() * left[mode]).sum();
            at[*i] = at[*i].with_added_radius(2.0 * radius);
        }
        None
    }

    /// Gives coordinates that differ by rounding alone from where the search started their places there, where no force tells them
    /// apart: what nothing holds stays where it is.
    fn drop_noise(&self, at: &mut [Ball], metric: &DMatrix<f64>) {
        let largest = at.iter().map(|x| x.mid_f64().abs()).fold(0.0, f64::max);
        let start = |i: usize| closed(self.model, self.model.guesses.get(i)).ok().flatten().unwrap_or(Ball::ZERO);
        let places = self.free.iter().filter(|i| **i < self.visible).map(|i| (*i, start(*i)));
        let is_noise = |(i, place): &(usize, Ball)| {
            let way = (at[*i] - *place).mid_f64().abs();
            way > 0.0 && way <= NOISE * largest
        };
        let moved: Vec<(usize, Ball)> = places.filter(is_noise).collect();
        let alone = moved.iter().map(std::slice::from_ref).take(MOST_ALONE);
        let all = std::iter::once(moved.as_slice()).chain(alone);
        let mut force = self.weighted(&self.gradient(at), metric);
        for part in all.filter(|part| !part.is_empty()) {
            let mut trial = at.to_vec();
            part.iter().for_each(|(i, place)| trial[*i] = *place);
            let there = self.weighted(&self.gradient(&trial), metric);
            if there.finite && (there.rounding || there.norm <= force.norm) {
                at.clone_from_slice(&trial);
                force = there;
            }
            if part.len() == moved.len() && at[moved[0].0] == moved[0].1 {
                break;
            }
        }
    }

    /// Tries to prove an equilibrium beside `at`, and says where its free coordinates are. Symmetries are
    /// searched for only where the stiffness may be singular, and more bits than doubles have are taken
    /// only where these do not do.
    fn proof(&self, at: &[Ball], metric: &DMatrix<f64>, spectrum: &Spectrum) -> Option<(Proof, Vec<Ball>)> {
        let eigen = &spectrum.eigen;
        let axes = metric.transpose().solve_upper_triangular(&eigen.eigenvectors)?;
        let symmetries = if spectrum.is_nearly_singular() {
            // Along a symmetry no force acts whatever the place, nor may a generalised one.
            let unforced = self.assembly.without_force_at_rest(at.len());
            let mut allowed = vec![false; at.len()];
            for i in &self.free {
                allowed[*i] = unforced[*i];
            }
            let all = symmetries(self.model, self.assembly, at, &allowed, true);
            independent_symmetries(all, at)
        } else {
            Vec::new()
        };
        let setting = Setting {
            assembly: self.assembly,
            values: self.values,
            free: &self.free,
            products: Products::Doubles,
            bits: BITS_OF_BALLS,
            room: ROOM_OF_BALLS,
        };
        let scaled = Axes::new(&axes, eigen.eigenvalues.as_slice(), symmetries.len());
        let proved = scaled.and_then(|scaled| setting.prove(at, scaled, &symmetries));
        if let Some((proof, radii)) = proved {
            if let Some(place) = self.closer_place(at, &proof, &radii) {
                return Some((proof, place));
            }
            let free = self.free.iter().zip(radii);
            let place = free.map(|(i, radius)| at[*i].with_added_radius(radius));
            return Some((proof, place.collect()));
        }
        self.finish(at, &axes, &symmetries)
    }
}

/// A number in a message.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-3..1e6).contains(&size) {
        let text = format!("{value:.6}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text.is_empty() || text == "-0" { "0".to_owned() } else { text.to_owned() }
    } else {
        format!("{value:.5e}")
    }
}
