//! Steps whose results hold the solution.

use super::Equations;
use super::bounds::{growth, norm, onwards, reached, time_coefficient};
use super::plain::weights;
use librate_core::expr::{Prepared, Series};
use librate_core::number::Number;
use librate_core::precision::{Enclosure, Matrix, up};

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

/// Taylor coefficients of a solution and of its derivative, by order.
#[derive(Clone, Debug)]
struct Expansion<S> {
    state: Vec<Vec<S>>,
    jacobian: Vec<Vec<S>>,
    slopes: Vec<Vec<S>>,
}

impl<S> Expansion<S> {
    fn empty() -> Self {
        Self { state: Vec::new(), jacobian: Vec::new(), slopes: Vec::new() }
    }
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
    values: Prepared<S>,
    scratch: Vec<S>,
    point: Expansion<S>,
    tube: Expansion<S>,
    /// The length that is tried next.
    next: f64,
}

impl<S: Enclosure> Enclosing<S> {
    /// For steps of Taylor's method of the given order; equations with open parameters have none.
    #[must_use]
    pub fn new(equations: &Equations, order: usize, precision: S::Precision) -> Self {
        let values = equations.tape.prepare::<S>(precision);
        Self {
            dimension: equations.dimension,
            moving: equations.moving,
            precision,
            order: order.max(2),
            whole: values.series(),
            rates: equations.rates.prepare::<S>(precision).series(),
            values,
            scratch: Vec::new(),
            point: Expansion::empty(),
            tube: Expansion::empty(),
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
        let start: Vec<S> = std::iter::once(t).chain(state).cloned().collect();
        let here = self.values.evaluate(&start, &mut self.scratch);
        let jacobian = here.get(if self.moving { self.dimension } else { 0 }..)?;
        if here.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let weights = self.weights(jacobian);
        let norm = norm(jacobian, &weights);
        // Beside the point nothing depends on the set but T.
        let unit = self.unit();
        let mut point = std::mem::replace(&mut self.point, Expansion::empty());
        self.expand(&mut point, t, state, &unit, self.order);
        let found = self.shorten(t, state, longest, &here, &weights, norm, &point);
        self.point = point;
        found
    }

    #[allow(clippy::too_many_arguments)] // one step with all that is known where it begins
    fn shorten(
        &mut self,
        t: &S,
        state: &[S],
        longest: &S,
        here: &[S],
        weights: &[f64],
        norm: f64,
        point: &Expansion<S>,
    ) -> Option<Step<S>> {
        let asked = longest.abs_upper();
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
            let Some(excess) = self.remainder(t, state, &step, here, weights, point) else {
                length *= 0.5;
                continue;
            };
            let factor = 0.9 * excess.powf(-1.0 / self.order as f64);
            if excess <= 1.0 {
                self.next = length * factor.clamp(0.5, 2.0);
                return self.sum(t, state, step, whole, point);
            }
            length *= factor.clamp(0.1, 0.9);
        }
        None
    }

    /// The p-th coefficients over a box that holds the solution, in `self.tube`, and how their share of the step
    /// compares with what is allowed.
    fn remainder(
        &mut self,
        t: &S,
        state: &[S],
        step: &S,
        here: &[S],
        weights: &[f64],
        point: &Expansion<S>,
    ) -> Option<f64> {
        let n = self.dimension;
        let length = step.abs_upper();
        let time = onwards(t, length, self.precision);
        let (tube, jacobian) = self.tube(&time, state, length, here, weights)?;
        // |T(s) - 1| <= e^(a s) - 1 in the operator norm that belongs to max |x_i|/w_i, for a >= |J| there (Gronwall).
        let bound = growth(up(norm(&jacobian, weights) * length));
        if !bound.is_finite() {
            return None;
        }
        let reached = reached(self.dimension, &jacobian);
        let mut slopes = self.unit();
        for (at, entry) in slopes.iter_mut().enumerate() {
            if reached[at] {
                *entry = entry.with_added_radius(up(bound * weights[at / n] / weights[at % n]));
            }
        }
        let mut expansion = std::mem::replace(&mut self.tube, Expansion::empty());
        self.expand(&mut expansion, &time, &tube, &slopes, self.order + 1);
        let power = length.powi(self.order as i32);
        let rounding = REMAINDER * S::rounding(self.precision);
        let mut excess = 0.0_f64;
        let size = norm(expansion.slopes.get(self.order)?, weights) * power;
        excess = excess.max(size / rounding);
        if self.moving {
            let relative =
                |values: &[S]| values.iter().zip(weights).fold(0.0_f64, |most, (x, w)| most.max(x.abs_upper() / w));
            let size = relative(expansion.state.get(self.order)?) * power;
            let scale = relative(point.state.first()?) + length * relative(point.state.get(1)?);
            if scale > 0.0 {
                excess = excess.max(size / (rounding * scale));
            }
        }
        self.tube = expansion;
        excess.is_finite().then_some(excess.max(1e-30))
    }

    /// A box that no solution from the state leaves before the end of the step, and J over it.
    ///
    /// If |f_i| <= b_i on [t, t + h] x Π(x_i + [-r_i, r_i]) and h b_i <= r_i, then a solution that starts in x stays in
    /// that box until t + h (Picard and Lindelöf; f has bounded derivatives there).
    fn tube(&mut self, time: &S, state: &[S], length: f64, here: &[S], weights: &[f64]) -> Option<(Vec<S>, Vec<S>)> {
        let n = if self.moving { self.dimension } else { 0 };
        let fastest = here[..n].iter().zip(weights).fold(0.0_f64, |most, (f, w)| most.max(f.abs_upper() / w));
        let mut reach: Vec<f64> =
            here[..n].iter().zip(weights).map(|(f, w)| length * (1.5 * f.abs_upper()).max(0.5 * fastest * w)).collect();
        for _ in 0..BOXES {
            let tube: Vec<S> = state.iter().zip(&reach).map(|(x, r)| x.with_added_radius(*r)).collect();
            let inputs: Vec<S> = std::iter::once(time).chain(&tube).cloned().collect();
            let values = self.values.evaluate(&inputs, &mut self.scratch);
            if values.iter().any(|x| !x.is_finite()) {
                return None;
            }
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

    /// Coefficients of x and T below `orders`, from x_0 and T_0.
    fn expand(&mut self, into: &mut Expansion<S>, t: &S, state: &[S], unit: &[S], orders: usize) {
        let n = self.dimension;
        let states = if self.moving { n } else { 0 };
        self.whole.clear();
        into.state.resize(orders.max(into.state.len()), Vec::new());
        into.jacobian.resize(orders.max(into.jacobian.len()), Vec::new());
        into.slopes.resize(orders.max(into.slopes.len()), Vec::new());
        into.state[0] = state.to_vec();
        into.slopes[0] = unit.to_vec();
        let zero = S::from_number(&Number::ZERO, self.precision);
        let mut inputs: Vec<S> = Vec::with_capacity(n + 1);
        for k in 0..orders - 1 {
            inputs.clear();
            inputs.push(time_coefficient(t, 1.0, k, self.precision));
            inputs.extend(into.state[k].iter().cloned());
            let outputs = self.whole.next(&inputs);
            let count = S::exact((k + 1) as f64, self.precision);
            into.state[k + 1].clear();
            into.state[k + 1].extend(outputs[..states].iter().map(|f| f.div(&count)));
            into.jacobian[k].clear();
            into.jacobian[k].extend_from_slice(&outputs[states..]);
            let mut next = std::mem::take(&mut into.slopes[k + 1]);
            next.clear();
            for i in 0..n {
                for j in 0..n {
                    let mut sum: Option<S> = None;
                    for order in 0..=k {
                        let row = &into.jacobian[order][n * i..n * (i + 1)];
                        for (l, entry) in row.iter().enumerate() {
                            let other = &into.slopes[k - order][n * l + j];
                            if entry.is_exact_zero() || other.is_exact_zero() {
                                continue;
                            }
                            let product = entry.mul(other);
                            sum = Some(match sum {
                                None => product,
                                Some(sum) => sum.add(&product),
                            });
                        }
                    }
                    next.push(sum.map_or_else(|| zero.clone(), |sum| sum.div(&count)));
                }
            }
            into.slopes[k + 1] = next;
        }
    }

    /// The polynomial of degree p - 1 and the remainder.
    fn sum(&mut self, t: &S, state: &[S], step: S, whole: bool, point: &Expansion<S>) -> Option<Step<S>> {
        let p = self.order;
        let horner = |orders: &[Vec<S>], last: &[S]| -> Vec<S> {
            let mut value = last.to_vec();
            for lower in orders[..p].iter().rev() {
                for (value, lower) in value.iter_mut().zip(lower) {
                    *value = value.mul(&step).add(lower);
                }
            }
            value
        };
        let slopes = horner(&point.slopes, self.tube.slopes.get(p)?);
        let image = if self.moving {
            let centers: Vec<S> = state.iter().map(S::center).collect();
            horner(&self.path(t, &centers), self.tube.state.get(p)?)
        } else {
            Vec::new()
        };
        slopes.iter().chain(&image).all(S::is_finite).then_some(Step { length: step, whole, image, slopes })
    }

    /// The coefficients of the solution through a point, up to order p - 1.
    fn path(&mut self, t: &S, centers: &[S]) -> Vec<Vec<S>> {
        self.rates.clear();
        let mut orders = vec![centers.to_vec()];
        for k in 0..self.order - 1 {
            let mut inputs = vec![time_coefficient(t, 1.0, k, self.precision)];
            inputs.extend(orders[k].iter().cloned());
            let count = S::exact((k + 1) as f64, self.precision);
            let next = self.rates.next(&inputs);
            orders.push(next.iter().map(|f| f.div(&count)).collect());
        }
        orders
    }

    /// Scales of the components, powers of two, in which the entries of J are of like size on both sides of the
    /// diagonal (E. E. Osborne, J. ACM 7 (1960) 338).
    fn weights(&self, jacobian: &[S]) -> Vec<f64> {
        let sizes: Vec<f64> = jacobian.iter().map(|x| x.mid_f64().abs()).collect();
        weights(self.dimension, &sizes)
    }
}
