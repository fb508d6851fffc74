//! Taylor coefficients of solutions and of T, enclosed, which both kinds of steps sum.

use super::bounds::time_coefficient;
use super::count;
use librate_core::expr::Series;
use librate_core::precision::Enclosure;

/// Coefficients of the solutions through a point or a box, in units of time, a row each.
pub(super) fn expanded<S: Enclosure>(
    series: &mut Series<S>,
    time: &S,
    state: &[S],
    unit: f64,
    order: usize,
    precision: S::Precision,
) -> Vec<Vec<S>> {
    series.clear();
    let mut rows: Vec<Vec<S>> = state.iter().map(|x| row(x, order)).collect();
    let mut inputs = Vec::with_capacity(state.len() + 1);
    let whole = S::exact(unit, precision);
    for k in 0..order {
        inputs.clear();
        inputs.push(time_coefficient(time, unit, k, precision));
        inputs.extend(rows.iter().map(|row| row[k].clone()));
        let count = S::exact(count(k + 1), precision);
        for (row, f) in rows.iter_mut().zip(series.next(&inputs)) {
            row.push(f.mul(&whole).div(&count));
        }
    }
    rows
}

/// Coefficients of the entries of T along all solutions through a box, in units of time, a row each, from its values at first, for
/// a series of f, where the state is followed, and J.
pub(super) fn expanded_slopes<S: Enclosure>(
    series: &mut Series<S>,
    time: &S,
    state: &[S],
    first: &[S],
    unit: f64,
    order: usize,
    precision: S::Precision,
) -> Slopes<S> {
    series.clear();
    let entries = first.len();
    let n = entries.isqrt();
    let mut states: Vec<Vec<S>> = state.iter().map(|x| row(x, order)).collect();
    let mut slopes: Vec<Vec<S>> = first.iter().map(|x| row(x, order)).collect();
    let mut jacobian: Vec<Vec<S>> = vec![Vec::with_capacity(order); entries];
    // The place behind the last coefficient that is not 0.
    let mut live = vec![0; entries];
    let whole = S::exact(unit, precision);
    let mut inputs = Vec::with_capacity(state.len() + 1);
    for k in 0..order {
        inputs.clear();
        inputs.push(time_coefficient(time, unit, k, precision));
        inputs.extend(states.iter().map(|row| row[k].clone()));
        let outputs = series.next(&inputs);
        let share = whole.div(&S::exact(count(k + 1), precision));
        for (row, f) in states.iter_mut().zip(outputs) {
            row.push(f.mul(&share));
        }
        for ((row, live), value) in jacobian.iter_mut().zip(&mut live).zip(&outputs[state.len()..]) {
            row.push(value.clone());
            if !value.is_exact_zero() {
                *live = k + 1;
            }
        }
        for i in 0..n {
            for j in 0..n {
                let parts = (0..n).filter_map(|l| {
                    let orders = live[n * i + l].min(k + 1);
                    let left = &jacobian[n * i + l][..orders];
                    S::convolution(left, &slopes[n * l + j][k + 1 - orders..=k])
                });
                let sum = parts.reduce(|sum, part| sum.add(&part));
                let next = sum.map_or_else(|| S::exact(0.0, precision), |sum| sum.mul(&share));
                slopes[n * i + j].push(next);
            }
        }
    }
    Slopes { states, slopes }
}

/// Coefficients by component, and by entry of T.
pub(super) struct Slopes<S> {
    pub(super) states: Vec<Vec<S>>,
    pub(super) slopes: Vec<Vec<S>>,
}

fn row<S: Clone>(first: &S, order: usize) -> Vec<S> {
    let mut row = Vec::with_capacity(order + 2);
    row.push(first.clone());
    row
}
