//! Coordinates without inertia that friction holds: equations of first order among those of second.
//!
//! Where M has rows of zeros and the block D₂₂ of D = G + C there is regular, their rows of s²M + sD + S are multiplied by s + σ, each with a
//! σ of its own. That adds the exponents -σ to those of the model, which are known, and nothing else; the leading matrix
//! is then [[M₁₁, 0], [D₂₁, D₂₂]], regular, and by steps on the rows of D₂₂ alone it becomes [[M₁₁, 0], [0, diagonal]]. So exponents,
//! bounds and digits are those of any other model, vectors stay as they are, and what friction does not reach keeps its form.

use super::Linearized;
use super::massless;
use crate::number::Number;
use crate::precision::{Ball, Enclosure, Scalar, clear_column};

/// The coordinates that only friction holds.
#[derive(Clone, Debug)]
pub(crate) struct Flow {
    /// Their numbers among the coordinates that are left.
    rows: Vec<usize>,
    /// About the fastest rate of the model, a power of two.
    rate: f64,
    /// What stands for a mass of each.
    masses: Vec<f64>,
    /// σ of each.
    shifts: Vec<f64>,
}

/// M, G + C and K + N, dense, column by column.
pub(super) type Three<S> = [Vec<S>; 3];

/// The coordinates without inertia of a damped model, where friction determines how they move.
pub(super) fn find(own: &Linearized) -> Option<Flow> {
    let rows = massless::resting(own);
    if rows.is_empty() {
        return None;
    }
    let (velocity, stiffness) = own.velocity_and_stiffness();
    let mass = own.mass();
    let n = own.dimension();
    let size = |matrix: &[Ball], i: usize| -> f64 { (0..n).map(|j| matrix[i + n * j].mid_f64().abs()).sum() };
    let mut fastest = 0.0_f64;
    for i in 0..n {
        let (own, d, s) = (mass[i + n * i].mid_f64(), size(&velocity, i), size(&stiffness, i));
        if rows.contains(&i) {
            fastest = fastest.max(s / velocity[i + n * i].mid_f64().abs());
        } else {
            fastest = fastest.max(d / own).max((s / own).sqrt());
        }
    }
    let power = |x: f64| x.log2().ceil().exp2();
    let rate = if fastest.is_finite() && fastest > 0.0 { power(fastest) } else { 1.0 };
    let masses = rows.iter().map(|i| power(size(&velocity, *i) / rate)).collect();
    let flow = Flow { shifts: Vec::new(), rows, rate, masses }.attempt(0);
    flow.regular(&[mass, velocity, stiffness], Enclosure::certain_size, ()).is_some().then_some(flow)
}

impl Flow {
    /// The same with other σ, simple fractions of the fastest rate that exponents are seldom equal to.
    pub(crate) fn attempt(&self, number: usize) -> Self {
        let shift = |at: usize| self.rate * (89 + 19 * at + 31 * number) as f64 / 64.0;
        Self { shifts: (0..self.rows.len()).map(shift).collect(), ..self.clone() }
    }

    /// The number of the first of the coordinates.
    pub(crate) fn first(&self) -> Option<usize> {
        self.rows.first().copied()
    }

    /// What was added: the exponents -σ.
    pub(crate) fn shifts(&self) -> &[f64] {
        &self.shifts
    }

    /// The polynomial with a regular leading matrix; `None` where that is not shown. `size` is positive for what may be divided by.
    pub(crate) fn regular<S: Scalar>(
        &self,
        [mass, velocity, stiffness]: &Three<S>,
        size: impl Fn(&S) -> f64,
        precision: S::Precision,
    ) -> Option<Three<S>> {
        let n = mass.len().isqrt();
        let others: Vec<usize> = (0..n).filter(|i| !self.rows.contains(i)).collect();
        // Y with Y M₁₁ = D₂₁.
        let mut factors: Vec<Vec<S>> = Vec::new();
        if self.rows.iter().any(|j| others.iter().any(|i| !velocity[j + n * i].is_exact_zero())) {
            let row = |i: &usize| {
                let own = others.iter().map(|k| mass[i + n * k].clone());
                own.chain(self.rows.iter().map(|j| velocity[j + n * i].clone())).collect()
            };
            factors = others.iter().map(row).collect();
            solve(&mut factors, &size, precision)?;
        }
        let number = |x: f64| Some(S::from_number(&Number::from_f64_exact(x)?, precision));
        let mut rows: Vec<Vec<S>> = Vec::with_capacity(self.rows.len());
        for (at, j) in self.rows.iter().enumerate() {
            let shift = number(self.shifts[at])?;
            let mut row: Vec<S> = self.rows.iter().map(|k| velocity[j + n * k].clone()).collect();
            let without = |mut sum: S, matrix: &[S], column: usize| {
                for (i, factor) in others.iter().zip(&factors) {
                    let (factor, entry) = (&factor[others.len() + at], &matrix[i + n * column]);
                    if !factor.is_exact_zero() && !entry.is_exact_zero() {
                        sum = sum.sub(&factor.mul(entry));
                    }
                }
                sum
            };
            for column in 0..n {
                let both = stiffness[j + n * column].add(&shift.mul(&velocity[j + n * column]));
                row.push(without(both, velocity, column));
            }
            for column in 0..n {
                row.push(without(shift.mul(&stiffness[j + n * column]), stiffness, column));
            }
            rows.push(row);
        }
        solve(&mut rows, &size, precision)?;
        let mut all = [mass.clone(), velocity.clone(), stiffness.clone()];
        for (at, j) in self.rows.iter().enumerate() {
            let own = number(self.masses[at])?;
            all[0][j + n * j] = own.clone();
            for column in 0..n {
                for (matrix, first) in [(1, self.rows.len()), (2, self.rows.len() + n)] {
                    all[matrix][j + n * column] = rows[at][first + column].mul(&own);
                }
            }
        }
        Some(all)
    }
}

/// Gauss-Jordan elimination of as many columns as there are rows.
fn solve<S: Scalar>(rows: &mut [Vec<S>], size: impl Fn(&S) -> f64, precision: S::Precision) -> Option<()> {
    for at in 0..rows.len() {
        let largest = |a: &usize, b: &usize| size(&rows[*a][at]).total_cmp(&size(&rows[*b][at]));
        let pivot = (at..rows.len()).max_by(largest).filter(|row| size(&rows[*row][at]) > 0.0)?;
        rows.swap(at, pivot);
        clear_column(rows, at, at, precision);
    }
    Some(())
}
