//! The same steps in plain doubles.

use super::Equations;
use crate::expr::Series;

/// The order of the steps: about the best for 16 digits.
const ORDER: usize = 24;
/// What a step may leave out, beside the size of the state.
const TOLERANCE: f64 = 1e-17;
/// More steps than this are not made.
const MOST_STEPS: usize = 1_000_000;

/// The coefficients of one component.
type Row = [f64; ORDER];

/// Steps in plain doubles: results are good to about rounding, and nothing is bounded.
#[derive(Clone, Debug)]
pub struct Plain {
    dimension: usize,
    moving: bool,
    series: Series<f64>,
    parameters: Vec<f64>,
    inputs: Vec<f64>,
    state: Vec<Row>,
    jacobian: Vec<Row>,
    /// The place behind the last coefficient of an entry of J that is not 0.
    live: Vec<usize>,
    slopes: Vec<Row>,
    /// Work space of a step.
    step: Vec<f64>,
    next: Vec<f64>,
    sizes: Vec<f64>,
}

impl Plain {
    /// For any number of trips; open parameters are 0 until they are set.
    #[must_use]
    pub fn new(equations: &Equations) -> Self {
        let n = equations.dimension;
        let states = if equations.moving { n } else { 0 };
        Self {
            dimension: n,
            moving: equations.moving,
            series: equations.tape.prepare::<f64>(()).series(),
            parameters: vec![0.0; equations.parameters],
            inputs: Vec::new(),
            state: vec![[0.0; ORDER]; states],
            jacobian: vec![[0.0; ORDER]; n * n],
            live: vec![0; n * n],
            slopes: vec![[0.0; ORDER]; n * n],
            step: vec![0.0; n * n],
            next: vec![0.0; n * n],
            sizes: vec![0.0; n * n],
        }
    }

    /// Values for the open parameters, in their order.
    pub fn set_parameters(&mut self, values: &[f64]) {
        for (own, value) in self.parameters.iter_mut().zip(values) {
            *own = *value;
        }
    }

    /// The state at `end` and its derivative by the state at `begin`, row by row, from that at `begin`; `None` where the
    /// solution does not reach `end`. `visit` sees the time, the state and J, row by row, at the beginning of each step.
    pub fn travel(
        &mut self,
        begin: f64,
        end: f64,
        state: &[f64],
        mut visit: impl FnMut(f64, &[f64], &[f64]),
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let n = self.dimension;
        let mut state = state.to_vec();
        let mut total: Vec<f64> = (0..n * n)
            .map(|at| f64::from(u8::from(at / n == at % n)))
            .collect();
        let mut t = begin;
        for _ in 0..MOST_STEPS {
            self.expand(t, &state);
            for (size, entry) in self.sizes.iter_mut().zip(&self.jacobian) {
                *size = entry[0];
            }
            visit(t, &state, &self.sizes);
            let longest = self.length()?;
            let last = t + longest >= end - 1e-3 * longest;
            let h = if last { end - t } else { longest };
            let sum = |row: &Row| row.iter().rev().fold(0.0, |value, term| value * h + term);
            for (value, row) in self.step.iter_mut().zip(&self.slopes) {
                *value = sum(row);
            }
            for (value, row) in state.iter_mut().zip(&self.state) {
                *value = sum(row);
            }
            for i in 0..n {
                for j in 0..n {
                    let products = (0..n).map(|k| self.step[n * i + k] * total[n * k + j]);
                    self.next[n * i + j] = products.sum();
                }
            }
            total.copy_from_slice(&self.next);
            if state.iter().chain(&total).any(|x| !x.is_finite()) {
                return None;
            }
            if last {
                return Some((state, total));
            }
            t += h;
        }
        None
    }

    fn expand(&mut self, t: f64, state: &[f64]) {
        let n = self.dimension;
        let states = self.state.len();
        self.series.clear();
        for (row, x) in self.state.iter_mut().zip(state) {
            row[0] = *x;
        }
        for (at, row) in self.slopes.iter_mut().enumerate() {
            row[0] = f64::from(u8::from(at / n == at % n));
        }
        self.live.fill(0);
        for k in 0..ORDER {
            self.inputs.clear();
            self.inputs.push(match k {
                0 => t,
                1 => 1.0,
                _ => 0.0,
            });
            self.inputs.extend(self.state.iter().map(|row| row[k]));
            let at_start = f64::from(u8::from(k == 0));
            self.inputs
                .extend(self.parameters.iter().map(|p| p * at_start));
            let outputs = self.series.next(&self.inputs);
            for ((row, live), value) in self
                .jacobian
                .iter_mut()
                .zip(&mut self.live)
                .zip(&outputs[states..])
            {
                row[k] = *value;
                if *value != 0.0 {
                    *live = k + 1;
                }
            }
            if k + 1 == ORDER {
                break;
            }
            #[allow(clippy::cast_precision_loss)] // orders are small
            let share = 1.0 / (k + 1) as f64;
            for (row, f) in self.state.iter_mut().zip(outputs) {
                row[k + 1] = f * share;
            }
            for i in 0..n {
                for j in 0..n {
                    let mut sum = 0.0;
                    for l in 0..n {
                        let orders = self.live[n * i + l].min(k + 1);
                        let left = &self.jacobian[n * i + l][..orders];
                        let right = &self.slopes[n * l + j][k + 1 - orders..=k];
                        let products = left.iter().zip(right.iter().rev());
                        sum += products.map(|(a, b)| a * b).sum::<f64>();
                    }
                    self.slopes[n * i + j][k + 1] = sum * share;
                }
            }
        }
    }

    /// A length at which the last two terms are about what is allowed; `None` where there is none.
    fn length(&mut self) -> Option<f64> {
        let n = self.dimension;
        for size in &mut self.sizes {
            *size = size.abs();
        }
        let weights = Self::weights(n, &self.sizes);
        let slope = |order: usize| {
            let entries = self.slopes.iter().enumerate();
            entries.fold(0.0_f64, |most, (at, row)| {
                most.max(row[order].abs() * weights[at % n] / weights[at / n])
            })
        };
        let place = |order: usize| {
            let parts = self.state.iter().zip(&weights);
            parts.fold(0.0_f64, |most, (row, w)| most.max(row[order].abs() / w))
        };
        let mut length = f64::INFINITY;
        for order in [ORDER - 2, ORDER - 1] {
            #[allow(clippy::cast_precision_loss)] // orders are small
            let root = 1.0 / order as f64;
            length = length.min((TOLERANCE / slope(order)).powf(root));
            let size = place(0) + place(1);
            if self.moving && size > 0.0 {
                length = length.min((TOLERANCE * size / place(order)).powf(root));
            }
        }
        (length > 0.0).then_some(length)
    }

    /// Scales of the components, powers of two, for which |J| has rows and columns of like size.
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
}
