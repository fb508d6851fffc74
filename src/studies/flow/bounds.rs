//! Bounds that steps of enclosures share.

use librate_core::expr::Prepared;
use librate_core::precision::{Ball, DoubleDouble, Enclosure, Matrix, up};

/// x + [0, length] for an upper bound of the length.
pub(super) fn onwards(x: Ball, length: f64) -> Ball {
    let half = (0.5 * length).next_up();
    (x + Ball::exact(half)).with_added_radius(half)
}

/// The Taylor coefficient of order k of the time itself, in units of time.
pub(super) fn time_coefficient<S: Enclosure>(time: &S, unit: f64, k: usize, precision: S::Precision) -> S {
    match k {
        0 => time.clone(),
        1 => S::exact(unit, precision),
        _ => S::exact(0.0, precision),
    }
}

/// What a tape gives, if all of it is finite.
pub(super) fn finite(tape: &Prepared<Ball>, inputs: &[Ball], scratch: &mut Vec<Ball>) -> Option<Vec<Ball>> {
    let values = tape.evaluate(inputs, scratch);
    values.iter().all(Ball::is_finite).then_some(values)
}

/// T, row by row, at all times up to an upper bound of a length, from the values of J until then; `None` where it has no bound.
///
/// |T(s) - 1| <= e^(a s) - 1 in the operator norm that belongs to max |x_i|/w_i, for a >= |J| there (Gronwall).
pub(super) fn near_unit(jacobian: &[Ball], weights: &[f64], length: f64) -> Option<Vec<Ball>> {
    let n = weights.len();
    let bound = growth(up(norm(jacobian, weights) * length));
    if !bound.is_finite() {
        return None;
    }
    let mut entries = Matrix::<Ball>::unit(n, ()).into_entries();
    for (at, (entry, reached)) in entries.iter_mut().zip(reached(n, jacobian)).enumerate() {
        if reached {
            *entry = entry.with_added_radius(up(bound * weights[at / n] / weights[at % n]));
        }
    }
    Some(entries)
}

/// An upper bound of e^x - 1 for x >= 0.
fn growth(x: f64) -> f64 {
    if !(0.0..700.0).contains(&x) {
        return f64::INFINITY;
    }
    let exponential = Ball::from(DoubleDouble::exact(x)).exp();
    up((exponential - Ball::ONE).upper().max(0.0))
}

/// max_i Σ_j |a_ij| w_j/w_i of a square matrix, row by row, from above.
pub(super) fn norm(matrix: &[Ball], weights: &[f64]) -> f64 {
    let n = weights.len();
    let row = |i: usize| {
        let parts = matrix[n * i..n * (i + 1)].iter().zip(weights);
        // Weights are powers of two; each partial sum is rounded up.
        parts.fold(0.0_f64, |sum, (x, w)| if x.is_zero() { sum } else { up(sum + x.abs_upper() * (w / weights[i])) })
    };
    (0..n).map(row).fold(0.0, f64::max)
}

/// Where T may differ from 1: where a path of entries of J that are not 0 leads from i to j.
///
/// Let R be all that is reached from i. Rows of J in R have entries in R alone, so that the j-th column of T obeys
/// equations of its own there: for j outside of R it begins with 0 and stays 0, in R and, since dT_ij/dt is made of it, in
/// row i too, where T_ij stays what it is at first.
fn reached(n: usize, jacobian: &[Ball]) -> Vec<bool> {
    let mut reached: Vec<bool> = jacobian.iter().map(|entry| !entry.is_zero()).collect();
    for k in 0..n {
        for i in 0..n {
            if reached[n * i + k] {
                for j in 0..n {
                    reached[n * i + j] |= reached[n * k + j];
                }
            }
        }
    }
    reached
}
