//! The same steps in plain doubles.

use super::Equations;
use crate::expr::Series;

/// The order of the steps: about the best for 16 digits.
const ORDER: usize = 24;
/// What a step may leave out, beside the size of the state.
const TOLERANCE: f64 = 1e-17;
/// More steps than this are not made.
const MOST_STEPS: usize = 1_000_000;

/// Steps in plain doubles: results are good to about rounding, and nothing is bounded.
#[derive(Clone, Debug)]
pub struct Plain {
    dimension: usize,
    moving: bool,
    series: Series<f64>,
    state: Vec<Vec<f64>>,
    jacobian: Vec<Vec<f64>>,
    slopes: Vec<Vec<f64>>,
}

impl Plain {
    /// For any number of trips.
    #[must_use]
    pub fn new(equations: &Equations) -> Self {
        let n = equations.dimension;
        let states = if equations.moving { n } else { 0 };
        Self {
            dimension: n,
            moving: equations.moving,
            series: equations.tape.prepare::<f64>(()).series(),
            state: vec![vec![0.0; states]; ORDER],
            jacobian: vec![vec![0.0; n * n]; ORDER],
            slopes: vec![vec![0.0; n * n]; ORDER],
        }
    }

    /// The state at `end` and its derivative by the state at `begin`, row by row, from that at `begin`; `None` where the
    /// solution does not reach `end`. `visit` sees the time, the state and J at the beginning of each step.
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
            visit(t, &state, &self.jacobian[0]);
            let longest = self.length()?;
            let last = t + longest >= end - 1e-3 * longest;
            let h = if last { end - t } else { longest };
            let sum = |orders: &[Vec<f64>], at: usize| {
                let terms = orders.iter().rev();
                terms.fold(0.0, |value, order| value * h + order[at])
            };
            let step: Vec<f64> = (0..n * n).map(|at| sum(&self.slopes, at)).collect();
            for (at, x) in state.iter_mut().enumerate() {
                *x = sum(&self.state, at);
            }
            total = (0..n * n)
                .map(|at| {
                    let (i, j) = (at / n, at % n);
                    (0..n).map(|k| step[n * i + k] * total[n * k + j]).sum()
                })
                .collect();
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
        let states = if self.moving { n } else { 0 };
        self.series.clear();
        self.state[0].copy_from_slice(&state[..states]);
        for (at, x) in self.slopes[0].iter_mut().enumerate() {
            *x = f64::from(u8::from(at / n == at % n));
        }
        let mut inputs = vec![0.0; states + 1];
        for k in 0..ORDER {
            inputs[0] = match k {
                0 => t,
                1 => 1.0,
                _ => 0.0,
            };
            inputs[1..].copy_from_slice(&self.state[k]);
            let outputs = self.series.next(&inputs);
            self.jacobian[k].copy_from_slice(&outputs[states..]);
            if k + 1 == ORDER {
                break;
            }
            #[allow(clippy::cast_precision_loss)] // orders are small
            let share = 1.0 / (k + 1) as f64;
            for (next, f) in self.state[k + 1].iter_mut().zip(outputs) {
                *next = f * share;
            }
            for i in 0..n {
                for j in 0..n {
                    let mut sum = 0.0;
                    for order in 0..=k {
                        let row = &self.jacobian[order][n * i..n * (i + 1)];
                        for (l, entry) in row.iter().enumerate() {
                            sum += entry * self.slopes[k - order][n * l + j];
                        }
                    }
                    self.slopes[k + 1][n * i + j] = sum * share;
                }
            }
        }
    }

    /// A length at which the last two terms are about what is allowed; `None` where there is none.
    fn length(&self) -> Option<f64> {
        let n = self.dimension;
        let sizes: Vec<f64> = self.jacobian[0].iter().map(|x| x.abs()).collect();
        let weights = Self::weights(n, &sizes);
        let slope = |order: usize| {
            let entries = self.slopes[order].iter().enumerate();
            entries.fold(0.0_f64, |most, (at, x)| {
                most.max(x.abs() * weights[at % n] / weights[at / n])
            })
        };
        let place = |order: usize| {
            let parts = self.state[order].iter().zip(&weights);
            parts.fold(0.0_f64, |most, (x, w)| most.max(x.abs() / w))
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
