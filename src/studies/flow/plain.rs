//! The same steps in plain doubles, for one set of parameters or for eight at once.
//!
//! The length of a step is what its last terms allow. They may all vanish, as next to a pulse that has not come yet, and know
//! nothing of a corner ahead: the series of the right side is held against its values on the way, and where it is off the
//! step is made shorter. So corners and jumps are come close to in steps that halve, and passed.

use super::{Equations, horner};
use librate_core::expr::{Prepared, Series};
use librate_core::precision::{LANES, Lane, Matrix, Scalar};

/// The order of the steps: about the best for 16 digits.
const ORDER: usize = 24;
/// What a step may leave out, beside the size of the state.
const TOLERANCE: f64 = 1e-17;
/// More steps than this are not made.
const MOST_STEPS: usize = 1_000_000;
/// The terms that the length of a step is taken from: gaps in a series are mostly shorter.
const LAST: std::ops::Range<usize> = ORDER / 2..ORDER;
/// Times in a motion at which the right side is evaluated, at least; what is shorter than their distance may be missed.
const SAMPLES: f64 = 64.0;
/// How far a series may be off its function, beside the size of J.
const OFF: f64 = 1e-11;
/// A step this short, beside the whole time, passes whatever is there.
const SHORTEST: f64 = 1e-14;

/// The coefficients of one component.
type Row<N> = [N; ORDER];

/// One double, or several side by side that share the lengths of their steps.
pub trait Doubles: Scalar<Precision = ()> + Copy {
    /// How many there are.
    const COUNT: usize;
    /// Each from its place.
    fn each(of: impl FnMut(usize) -> f64) -> Self;
    /// The one at a place below [`Doubles::COUNT`].
    fn one(&self, place: usize) -> f64;
    /// The largest absolute value.
    fn size(&self) -> f64;
}

impl Doubles for f64 {
    const COUNT: usize = 1;

    fn each(mut of: impl FnMut(usize) -> f64) -> Self {
        of(0)
    }

    fn one(&self, _: usize) -> f64 {
        *self
    }

    fn size(&self) -> f64 {
        self.abs()
    }
}

impl Doubles for Lane {
    const COUNT: usize = LANES;

    fn each(of: impl FnMut(usize) -> f64) -> Self {
        Self(std::array::from_fn(of))
    }

    fn one(&self, place: usize) -> f64 {
        self.0.get(place).copied().unwrap_or(f64::NAN)
    }

    fn size(&self) -> f64 {
        self.abs().0.into_iter().fold(0.0, f64::max)
    }
}

/// Steps in plain doubles: results are good to about rounding, and nothing is bounded.
#[derive(Clone, Debug)]
pub struct Plain<N: Doubles = f64> {
    dimension: usize,
    moving: bool,
    most_steps: usize,
    series: Series<N>,
    values: Prepared<N>,
    scratch: Vec<N>,
    parameters: Vec<N>,
    inputs: Vec<N>,
    state: Vec<Row<N>>,
    jacobian: Vec<Row<N>>,
    /// The place behind the last coefficient of an entry of J that is not 0.
    live: Vec<usize>,
    slopes: Vec<Row<N>>,
    /// Work space of a step.
    step: Vec<N>,
    next: Vec<N>,
    sizes: Vec<f64>,
    weights: Vec<f64>,
    /// The right side at one place.
    right: Vec<N>,
}

impl<N: Doubles> Plain<N> {
    /// For any number of integrations; open parameters are 0 until they are set.
    #[must_use]
    pub fn new(equations: &Equations) -> Self {
        let n = equations.dimension;
        let states = if equations.moving { n } else { 0 };
        let zero = N::each(|_| 0.0);
        let values = equations.tape.prepare::<N>(());
        Self {
            dimension: n,
            moving: equations.moving,
            most_steps: MOST_STEPS,
            series: values.series(),
            values,
            scratch: Vec::new(),
            parameters: vec![zero; equations.parameters],
            inputs: Vec::new(),
            state: vec![[zero; ORDER]; states],
            jacobian: vec![[zero; ORDER]; n * n],
            live: vec![0; n * n],
            slopes: vec![[zero; ORDER]; n * n],
            step: vec![zero; n * n],
            next: vec![zero; n * n],
            sizes: vec![0.0; n * n],
            weights: vec![1.0; n],
            right: vec![zero; states + n * n],
        }
    }

    /// Values for the open parameters, in their order.
    pub(crate) fn set_parameters(&mut self, values: &[N]) {
        for (own, value) in self.parameters.iter_mut().zip(values) {
            *own = *value;
        }
    }

    /// An integration of more steps ends without a result.
    pub(crate) fn set_most_steps(&mut self, most: usize) {
        self.most_steps = most.min(MOST_STEPS);
    }

    /// The state at `end` and its derivative by the state at `begin`, row by row, from that at `begin`; `None` where the
    /// solution does not reach `end`, of several where one does not. `visit` sees the time, the state and J, row by row, at
    /// the beginning of each step.
    pub fn travel(
        &mut self,
        begin: N,
        end: N,
        state: &[N],
        mut visit: impl FnMut(N, &[N], &[N]),
    ) -> Option<(Vec<N>, Vec<N>)> {
        let n = self.dimension;
        let mut state = state.to_vec();
        let mut total = Matrix::unit(n, ()).into_entries();
        // Several go each at its own pace, in step with the one that has the longest way.
        let way = end.sub(&begin);
        let whole = way.size();
        let pace = if whole > 0.0 { way.div(&N::each(|_| whole)) } else { N::each(|_| 1.0) };
        let mut gone = 0.0;
        for _ in 0..self.most_steps {
            let t = begin.add(&pace.mul(&N::each(|_| gone)));
            self.expand(t, &state);
            if !self.is_finite() {
                // At a corner there is no series, but beside it.
                self.nudge(t, pace.mul(&N::each(|_| SHORTEST * whole)), &state);
            }
            for (first, entry) in self.next.iter_mut().zip(&self.jacobian) {
                *first = entry[0];
            }
            visit(t, &state, &self.next);
            let longest = self.length(&pace)?.min(whole - gone);
            let longest = self.fitting(longest, whole, t, &pace)?;
            let last = gone + longest >= whole - 1e-3 * longest;
            let length = if last { whole - gone } else { longest };
            let h = pace.mul(&N::each(|_| length));
            for (value, row) in self.step.iter_mut().zip(&self.slopes) {
                *value = horner(row, &h);
            }
            for (value, row) in state.iter_mut().zip(&self.state) {
                *value = horner(row, &h);
            }
            for i in 0..n {
                for j in 0..n {
                    let products = (0..n).map(|k| self.step[n * i + k].mul(&total[n * k + j]));
                    self.next[n * i + j] = products.reduce(|sum, x| sum.add(&x))?;
                }
            }
            total.copy_from_slice(&self.next);
            if state.iter().chain(&total).any(|x| !x.is_finite()) {
                return None;
            }
            if last {
                return Some((state, total));
            }
            gone += length;
        }
        None
    }

    fn is_finite(&self) -> bool {
        let mut last = self.state.iter().map(|row| &row[ORDER - 1]);
        let mut slopes = self.jacobian.iter().map(|row| &row[ORDER - 1]);
        last.all(Scalar::is_finite) && slopes.all(Scalar::is_finite)
    }

    /// The series about the place where the solution is a moment later, for that at t.
    fn nudge(&mut self, t: N, moment: N, state: &[N]) {
        let states = self.state.len();
        self.inputs.clear();
        self.inputs.push(t);
        self.inputs.extend_from_slice(state);
        self.inputs.extend(&self.parameters);
        self.values.evaluate_into(&self.inputs, &mut self.scratch, &mut self.right);
        let rates = self.right[..states].iter().zip(state);
        let moved: Vec<N> = rates.map(|(rate, x)| x.add(&rate.mul(&moment))).collect();
        self.expand(t.add(&moment), &moved);
    }

    fn expand(&mut self, t: N, state: &[N]) {
        let n = self.dimension;
        let states = self.state.len();
        let (zero, one) = (N::each(|_| 0.0), N::each(|_| 1.0));
        self.series.clear();
        for (row, x) in self.state.iter_mut().zip(state) {
            row[0] = *x;
        }
        for (row, value) in self.slopes.iter_mut().zip(Matrix::unit(n, ()).into_entries()) {
            row[0] = value;
        }
        self.live.fill(0);
        for k in 0..ORDER {
            self.inputs.clear();
            self.inputs.push(match k {
                0 => t,
                1 => one,
                _ => zero,
            });
            self.inputs.extend(self.state.iter().map(|row| row[k]));
            self.inputs.extend(self.parameters.iter().map(|p| if k == 0 { *p } else { zero }));
            let outputs = self.series.next(&self.inputs);
            for ((row, live), value) in self.jacobian.iter_mut().zip(&mut self.live).zip(&outputs[states..]) {
                row[k] = *value;
                if !value.is_exact_zero() {
                    *live = k + 1;
                }
            }
            if k + 1 == ORDER {
                break;
            }
            let share = N::each(|_| 1.0 / (k + 1) as f64);
            for (row, f) in self.state.iter_mut().zip(outputs) {
                row[k + 1] = f.mul(&share);
            }
            for i in 0..n {
                for j in 0..n {
                    let mut sum = zero;
                    for l in 0..n {
                        let orders = self.live[n * i + l].min(k + 1);
                        let left = &self.jacobian[n * i + l][..orders];
                        let right = &self.slopes[n * l + j][k + 1 - orders..=k];
                        if let Some(part) = N::convolution(left, right) {
                            sum = sum.add(&part);
                        }
                    }
                    self.slopes[n * i + j][k + 1] = sum.mul(&share);
                }
            }
        }
    }

    /// A length at which the last terms are about what is allowed, for the one whose pace is 1; `None` where there is none. A
    /// term before the last may be as much larger.
    fn length(&mut self, pace: &N) -> Option<f64> {
        let n = self.dimension;
        for (size, entry) in self.sizes.iter_mut().zip(&self.jacobian) {
            *size = entry[0].size();
        }
        self.weights = weights(n, &self.sizes);
        let weights = &self.weights;
        // The largest (|term|/size)^(1/order) is one over the length at which terms would not fall.
        let mut rate = 0.0_f64;
        for order in LAST.rev() {
            let pace = pace.powi(order as i32);
            let root = 1.0 / order as f64;
            let mut term = self.slopes.iter().enumerate().fold(0.0_f64, |most, (at, row)| {
                let size = row[order].mul(&pace).size();
                most.max(size * weights[at % n] / weights[at / n])
            });
            if self.moving {
                for place in 0..N::COUNT {
                    let of = |order: usize| {
                        let parts = self.state.iter().zip(weights);
                        parts.fold(0.0_f64, |most, (row, w)| most.max(row[order].one(place).abs() / w))
                    };
                    let size = of(0) + of(1);
                    if size > 0.0 {
                        term = term.max(of(order) * pace.one(place) / size);
                    }
                }
            }
            // Mostly another term is what counts.
            if term > rate.powi(order as i32) {
                rate = term.powf(root);
            }
        }
        let length = TOLERANCE.powf(1.0 / (ORDER - 1) as f64) / rate;
        (length > 0.0).then_some(length)
    }

    /// The length, halved until series and right side agree on the way; `whole` is the whole time.
    fn fitting(&mut self, longest: f64, whole: f64, t: N, pace: &N) -> Option<f64> {
        let mut length = longest;
        while !self.fits(length, whole, t, pace) {
            length *= 0.5;
            if length.is_nan() || length <= SHORTEST * whole {
                // A jump: it is where it is to this distance.
                return (longest > 0.0).then_some(longest.min(2.0 * SHORTEST * whole));
            }
        }
        Some(length)
    }

    /// Whether the series of the right side has its values at places of a step.
    fn fits(&mut self, length: f64, whole: f64, t: N, pace: &N) -> bool {
        let n = self.dimension;
        let states = self.state.len();
        let samples = (SAMPLES * length / whole).ceil().max(2.0);
        let mut sample = 1.0;
        while sample <= samples {
            let after = pace.mul(&N::each(|_| length * (sample / samples)));
            sample += 1.0;
            self.inputs.clear();
            self.inputs.push(t.add(&after));
            let state = self.state.iter().map(|row| horner(row, &after));
            self.inputs.extend(state);
            let reach = self.inputs[1..].iter().zip(&self.weights);
            let reach = reach.fold(0.0_f64, |most, (x, w)| most.max(x.size() / w));
            self.inputs.extend(&self.parameters);
            self.values.evaluate_into(&self.inputs, &mut self.scratch, &mut self.right);
            let (mut size, mut off) = (0.0_f64, 0.0_f64);
            let mut finite = true;
            let slopes = self.right[states..].iter().zip(&self.jacobian);
            for (at, (value, row)) in slopes.enumerate() {
                let scale = self.weights[at % n] / self.weights[at / n];
                let series = horner(&row[..self.live[at]], &after);
                finite &= value.is_finite();
                size = size.max(value.size() * scale);
                off = off.max(value.sub(&series).size() * scale);
            }
            let (mut force, mut off_force) = (0.0_f64, 0.0_f64);
            let rates = self.right[..states].iter().zip(&self.state);
            for ((value, row), w) in rates.zip(&self.weights) {
                // Of x' = Σ (k + 1) x_(k+1) t^k.
                let mut series = N::each(|_| 0.0);
                for k in (1..ORDER).rev() {
                    let term = row[k].mul(&N::each(|_| k as f64));
                    series = series.mul(&after).add(&term);
                }
                finite &= value.is_finite();
                force = force.max(value.size() / w);
                off_force = off_force.max(value.sub(&series).size() / w);
            }
            // The terms of a force may cancel: it is known to a part of J x.
            let forces = off_force <= OFF * (force + size * reach);
            if !(finite && forces && off <= OFF * size) {
                return false;
            }
        }
        true
    }
}

/// Scales of the components, powers of two, for which |J| has rows and columns of like size (E. E. Osborne, J. ACM 7 (1960) 338).
pub(super) fn weights(n: usize, sizes: &[f64]) -> Vec<f64> {
    let mut weights = vec![1.0_f64; n];
    for _ in 0..12 {
        let mut changed = false;
        for i in 0..n {
            let (mut row, mut column) = (0.0, 0.0);
            for j in (0..n).filter(|j| *j != i) {
                row += sizes[n * i + j] * weights[j] / weights[i];
                column += sizes[n * j + i] * weights[i] / weights[j];
            }
            if !(row > 0.0 && column > 0.0 && row < 1e200 && column < 1e200) {
                continue;
            }
            // Half the logarithm of their ratio, as a power of two.
            let by = (0.5 * (row / column).log2()).round();
            if by != 0.0 && (weights[i].log2() + by).abs() < 300.0 {
                weights[i] *= by.exp2();
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    weights
}
