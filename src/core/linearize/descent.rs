//! Down the potential, where the search along the forces has no way on.
//!
//! Trust-region steps with |K| in place of K, which lead off saddles and, where the potential rises
//! on all sides, always end at a minimum. A straight step along a curved valley leaves its floor, and V
//! rises by the stiffness of its walls: before a step is judged, up to three more steps may bring it
//! back to the floor (the watchdog technique; Chamberlain and others, Math. Prog. Study 16 (1982) 1).

use nalgebra::DMatrix;

use super::assemble::{Assembly, Values, evaluate_closed};
use super::equilibrium::Search;
use super::inputs::Inputs;
use super::newton::Downhill;
use crate::expr::Tape;
use crate::model::Model;
use crate::precision::{Ball, Big, Scalar};

/// More steps than this find nothing either.
const MOST_STEPS: usize = 1000;

/// How much the potential may rise on a step, beside what it is to fall.
const HIGH_WALL: f64 = 100.0;

/// Steps that may follow one before it is judged.
const MOST_RETURNS: usize = 3;

/// About so many multiplications may go into principal axes, ten or so m^3 each time.
const MOST_WORK: f64 = 2e11;

/// V - T0, but for what is the same everywhere.
pub(super) struct Energy<'a> {
    assembly: &'a Assembly,
    /// With those parameters too that no force depends on.
    values: Values<Ball>,
    /// Per family.
    terms: Vec<(Tape, Inputs)>,
}

impl<'a> Energy<'a> {
    pub(super) fn new(model: &Model, assembly: &'a Assembly, values: &Values<Ball>) -> Option<Self> {
        let mut values = values.clone();
        let mut terms = Vec::with_capacity(assembly.families.len());
        for family in &assembly.families {
            let inputs = family.inputs.of_others(model, &[family.effective]);
            for number in &inputs.parameters {
                let value = evaluate_closed(&model.pool, model.parameters[*number].value?, ())?;
                values.parameters[*number] = Some(value);
            }
            terms.push((inputs.tape(model, &model.pool, &family.terms, &[family.effective])?, inputs));
        }
        Some(Self { assembly, values, terms })
    }

    pub(super) fn at(&self, point: &[Ball]) -> Ball {
        let mut total = Ball::ZERO;
        let families = self.assembly.families.iter().zip(&self.terms);
        for (family, (tape, inputs)) in families.filter(|(family, _)| !family.potential.is_empty()) {
            inputs.run(&family.terms, tape, point, &self.values, |_, numbers, _| total = total.add(&numbers[0]));
        }
        total
    }
}

impl Search<'_> {
    /// Leads down to a minimum, near enough for Newton steps to take over; whether it got there.
    pub(super) fn descend(&self, at: &mut Vec<Ball>, metric: &DMatrix<f64>, energy: &Energy<'_>) -> bool {
        let size = self.free.len() as f64;
        // A number between 50 and 10000: the cast can't go wrong.
        let mut budget = (MOST_WORK / (10.0 * size.powi(3))).clamp(50.0, 10_000.0) as usize;
        let mut radius = f64::INFINITY;
        let mut height = energy.at(at);
        let Some(mut spectrum) = self.spectrum(at, metric) else { return false };
        for _ in 0..MOST_STEPS {
            let force = self.weighted(&self.gradient(at), metric);
            if !force.finite || !height.is_finite() || at.iter().any(|x| x.mid_f64().abs() > 1e150) {
                return false;
            }
            let Downhill { step, whole, falls } = spectrum.downhill(&force, radius);
            let length = step.norm();
            let scale = self.weighted_size(at, metric);
            if spectrum.is_bowl() && whole && (length <= 1e-7 * scale || falls <= height.radius) {
                return true;
            }
            if budget == 0 || length <= 1e-30 * scale || falls.is_nan() {
                return false;
            }
            let mut place = self.moved(at, metric, &step);
            let mut better = None;
            // A high wall on the way, as at a pole, is not passed.
            let middle = energy.at(&self.moved(at, metric, &(&step * 0.5)));
            let rise = middle.sub(&height).mid_f64();
            if rise.is_nan() || rise > HIGH_WALL * falls {
                radius = 0.25 * length;
                continue;
            }
            for back in 0..=MOST_RETURNS {
                let there = energy.at(&place);
                if !there.is_finite() || budget == 0 {
                    break;
                }
                let lower = height.sub(&there).mid_f64() >= 1e-4 * falls;
                if !lower && back == MOST_RETURNS {
                    break;
                }
                let Some(changed) = self.spectrum(&place, metric) else { break };
                budget -= 1;
                if lower {
                    better = Some((place, there, changed));
                    break;
                }
                let force = self.weighted(&self.gradient(&place), metric);
                if !force.finite {
                    break;
                }
                let step = changed.downhill(&force, length).step;
                place = self.moved(&place, metric, &step);
            }
            match better {
                Some((place, there, changed)) => {
                    *at = place;
                    height = there;
                    spectrum = changed;
                    if !whole {
                        radius *= 3.0;
                    } else if radius.is_finite() {
                        radius = radius.max(3.0 * length);
                    }
                }
                None => radius = 0.25 * length,
            }
        }
        false
    }

    /// A metric in which the stiffness at a point has entries of about 1 at most, whatever the masses:
    /// each coordinate in a unit of its own (Ruiz, RAL-TR-2001-034).
    pub(super) fn stiffness_metric(&self, at: &[Ball]) -> DMatrix<f64> {
        let (n, m) = (self.model.coordinates.len(), self.free.len());
        let stiffness = self.assembly.stiffness(at, self.values);
        let size = |i: usize, j: usize| stiffness[self.free[i] + n * self.free[j]].mid_f64().abs();
        let mut units = vec![1.0_f64; m];
        for _ in 0..6 {
            let row = |i: usize| (0..m).map(|j| size(i, j) / (units[i] * units[j])).fold(0.0, f64::max);
            let largest: Vec<f64> = (0..m).map(row).collect();
            for (unit, largest) in units.iter_mut().zip(largest) {
                if largest > 0.0 && largest.is_finite() {
                    *unit *= largest.sqrt();
                }
            }
        }
        DMatrix::from_diagonal(&nalgebra::DVector::from_vec(units))
    }

    /// Whether the stiffness is nothing but rounding, and with more bits the equilibrium is elsewhere: the force was lost in rounding.
    fn is_hidden(&self, at: &[Ball], start: &[Ball]) -> bool {
        let n = at.len();
        let largest = |matrix: &[Ball], size: fn(&Ball) -> f64| {
            let entries = self.free.iter().flat_map(|i| self.free.iter().map(move |j| i + n * j));
            entries.map(|place| size(&matrix[place])).fold(0.0, f64::max)
        };
        let size: fn(&Ball) -> f64 = |x| x.mid_f64().abs();
        let stiffness = self.assembly.stiffness(at, self.values);
        if largest(&stiffness, |x| x.radius) <= largest(&stiffness, size) {
            return false;
        }
        let centre: Vec<Ball> = at.iter().map(|x| Ball::new(x.mid, 0.0)).collect();
        let Some((point, values)) = self.closer(&centre, None) else { return false };
        let force = self.assembly.gradient(&point, &values);
        let force = self.free.iter().map(|i| size(&force[*i].to_ball())).fold(0.0, f64::max);
        let stiffness: Vec<Ball> = self.assembly.stiffness(&point, &values).iter().map(Big::to_ball).collect();
        let scale = at.iter().zip(start).map(|(a, b)| size(a) + size(b)).fold(0.0, f64::max);
        force > 1e-10 * scale * largest(&stiffness, size)
    }

    /// Whether a point without a proof may pass for one at rest: what is left to go is next to
    /// nothing beside the way from the start, in units in which no coordinate hides behind another.
    pub(super) fn rests(&self, at: &[Ball], start: &[Ball]) -> bool {
        let gradient = self.gradient(at);
        if self.free.iter().all(|i| gradient[*i].contains_zero()) {
            return !self.is_hidden(at, start);
        }
        let metric = self.stiffness_metric(at);
        let force = self.weighted(&gradient, &metric);
        let way: Vec<Ball> = at.iter().zip(start).map(|(a, b)| a.sub(b)).collect();
        let scale = self.weighted_size(at, &metric) + self.weighted_size(&way, &metric);
        self.spectrum(at, &metric).is_some_and(|spectrum| {
            let left = spectrum.newton(&force).norm();
            !spectrum.pushes_neutral(&force) && left <= 1e-10 * scale
        })
    }
}
