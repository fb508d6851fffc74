//! Steps whose results hold the solution.
//!
//! What is left out needs few digits: the box that the solution stays in and Lagrange's remainders are double-double for any
//! precision of the step.

use super::bounds::{finite, near_unit, norm, onwards};
use super::expansion::{Slopes, expanded, expanded_slopes};
use super::plain::weights;
use super::{Equations, horner};
use librate_core::expr::{Prepared, Series};
use librate_core::precision::{Ball, Enclosure, Matrix, up};

/// Remainders above so many roundings of the solution make a step shorter.
const REMAINDER: f64 = 16.0;
/// A step this much shorter than what was asked for is given up.
const SHORTEST: f64 = 1e-9;
/// Attempts at one step.
const ATTEMPTS: usize = 60;
/// Attempts at a box that holds the solution.
const BOXES: usize = 8;

/// One step from t to t + length.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Step<S> {
    /// How long the step is.
    pub length: S,
    /// Whether it is as long as was asked for.
    pub whole: bool,
    /// Where the midpoint of the state goes; empty where no state is followed.
    pub image: Vec<S>,
    /// dx(t + length)/dx(t), row by row, for every initial point in the state.
    pub slopes: Vec<S>,
}

/// Steps with bounds, over enclosures of one precision.
#[derive(Clone, Debug)]
pub struct Enclosing<S: Enclosure> {
    dimension: usize,
    moving: bool,
    precision: S::Precision,
    order: usize,
    whole: Series<S>,
    rates: Series<S>,
    values: Prepared<Ball>,
    coarse: Series<Ball>,
    scratch: Vec<Ball>,
    /// The length that is tried next.
    next: f64,
}

impl<S: Enclosure> Enclosing<S> {
    /// For steps of Taylor's method of the given order; equations with open parameters have none.
    #[must_use]
    pub fn new(equations: &Equations, order: usize, precision: S::Precision) -> Self {
        let values = equations.tape.prepare::<Ball>(());
        Self {
            dimension: equations.dimension,
            moving: equations.moving,
            precision,
            order: order.max(2),
            whole: equations.tape.prepare::<S>(precision).series(),
            rates: equations.rates.prepare::<S>(precision).series(),
            coarse: values.series(),
            values,
            scratch: Vec::new(),
            next: f64::INFINITY,
        }
    }

    /// The unit matrix, row by row.
    #[must_use]
    pub fn unit(&self) -> Vec<S> {
        Matrix::unit(self.dimension, self.precision).into_entries()
    }

    /// A step from t, of the length asked for or a shorter one. `state` holds the initial points; it is empty where only
    /// T is followed. `None` where no step was found: beside a singularity, or for a set of initial points that is too
    /// large.
    pub fn step(&mut self, t: &S, state: &[S], longest: &S) -> Option<Step<S>> {
        let asked = longest.abs_upper();
        if !asked.is_finite() {
            return None;
        }
        let start: Vec<Ball> = std::iter::once(t).chain(state).map(S::to_ball).collect();
        let here = finite(&self.values, &start, &mut self.scratch)?;
        let jacobian = here.get(self.followed()..)?;
        let sizes: Vec<f64> = jacobian.iter().map(|x| x.mid_f64().abs()).collect();
        let weights = weights(self.dimension, &sizes);
        let norm = norm(jacobian, &weights);
        let mut length = self.next.min(asked);
        if !self.next.is_finite() && norm > 0.0 {
            length = asked.min(1.0 / norm);
        }
        let floor = asked * SHORTEST;
        for _ in 0..ATTEMPTS {
            if length.is_nan() || length < floor {
                return None;
            }
            // A remainder a little shorter than a step would be a step of its own.
            let whole = length >= 0.999 * asked;
            let step = if whole { longest.clone() } else { S::exact(length, self.precision) };
            let Some((excess, rest)) = self.remainder(&start, step.abs_upper(), &here, &weights) else {
                length *= 0.5;
                continue;
            };
            let factor = 0.9 * excess.powf(-1.0 / self.order as f64);
            if excess <= 1.0 {
                self.next = length * factor.clamp(0.5, 2.0);
                return self.sum(t, state, step, whole, &rest);
            }
            length *= factor.clamp(0.1, 0.9);
        }
        None
    }

    /// How many components of a state are followed.
    fn followed(&self) -> usize {
        if self.moving { self.dimension } else { 0 }
    }

    /// How the last coefficients over a box that holds the solution, the p-th, compare with what is allowed in their share of the
    /// step, and all of them. `start` begins with the time.
    fn remainder(
        &mut self,
        start: &[Ball],
        length: f64,
        here: &[Ball],
        weights: &[f64],
    ) -> Option<(f64, Slopes<Ball>)> {
        let (time, state) = start.split_first()?;
        let time = onwards(*time, length);
        let (tube, jacobian) = self.tube(&time, state, length, here, weights)?;
        let first = near_unit(&jacobian, weights, length)?;
        let rest = expanded_slopes(&mut self.coarse, &time, &tube, &first, 1.0, self.order, ());
        let power = length.powi(self.order as i32);
        let rounding = REMAINDER * S::rounding(self.precision);
        let last: Vec<Ball> = last_of(&rest.slopes)?;
        let mut excess = norm(&last, weights) * power / rounding;
        if self.moving {
            let relative =
                |values: &[Ball]| values.iter().zip(weights).fold(0.0_f64, |most, (x, w)| most.max(x.abs_upper() / w));
            let size = relative(&last_of(&rest.states)?) * power;
            let scale = relative(state) + length * relative(&here[..self.dimension]);
            if scale > 0.0 {
                excess = excess.max(size / (rounding * scale));
            }
        }
        excess.is_finite().then_some((excess.max(1e-30), rest))
    }

    /// A box that no solution from the state leaves before the end of the step, and J over it.
    ///
    /// If |f_i| <= b_i on [t, t + h] x Π(x_i + [-r_i, r_i]) and h b_i <= r_i, then a solution that starts in x stays in
    /// that box until t + h (Picard and Lindelöf; f has bounded derivatives there).
    fn tube(
        &mut self,
        time: &Ball,
        state: &[Ball],
        length: f64,
        here: &[Ball],
        weights: &[f64],
    ) -> Option<(Vec<Ball>, Vec<Ball>)> {
        let n = self.followed();
        let fastest = here[..n].iter().zip(weights).fold(0.0_f64, |most, (f, w)| most.max(f.abs_upper() / w));
        let mut reach: Vec<f64> =
            here[..n].iter().zip(weights).map(|(f, w)| length * (1.5 * f.abs_upper()).max(0.5 * fastest * w)).collect();
        for _ in 0..BOXES {
            let tube: Vec<Ball> = state.iter().zip(&reach).map(|(x, r)| x.with_added_radius(*r)).collect();
            let values = finite(&self.values, &[&[*time], tube.as_slice()].concat(), &mut self.scratch)?;
            let mut held = true;
            for (f, r) in values[..n].iter().zip(&mut reach) {
                let needed = up(length * f.abs_upper());
                if needed > *r {
                    held = false;
                    *r = 1.2 * needed;
                }
            }
            if held {
                return Some((tube, values[n..].to_vec()));
            }
        }
        None
    }

    /// The polynomial of degree p - 1 and the remainder. Beside the point nothing depends on the set but T.
    fn sum(&mut self, t: &S, state: &[S], step: S, whole: bool, rest: &Slopes<Ball>) -> Option<Step<S>> {
        let (degree, precision) = (self.order - 1, self.precision);
        let with_rest = |rows: &mut Vec<Vec<S>>, rest: &[Vec<Ball>]| -> Option<Vec<S>> {
            for (row, last) in rows.iter_mut().zip(last_of(rest)?) {
                row.push(S::from_ball(&last, precision));
            }
            Some(rows.iter().map(|row| horner(row, &step)).collect())
        };
        let unit = self.unit();
        let mut slopes = expanded_slopes(&mut self.whole, t, state, &unit, 1.0, degree, precision).slopes;
        let slopes = with_rest(&mut slopes, &rest.slopes)?;
        let image = if self.moving {
            let centers: Vec<S> = state.iter().map(S::center).collect();
            let mut path = expanded(&mut self.rates, t, &centers, 1.0, degree, precision);
            with_rest(&mut path, &rest.states)?
        } else {
            Vec::new()
        };
        slopes.iter().chain(&image).all(S::is_finite).then_some(Step { length: step, whole, image, slopes })
    }
}

/// The last coefficient of each row.
fn last_of(rows: &[Vec<Ball>]) -> Option<Vec<Ball>> {
    rows.iter().map(|row| row.last().copied()).collect()
}
