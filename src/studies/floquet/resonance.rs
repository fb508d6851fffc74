//! Which resonance with the drive a growing motion belongs to. Nothing here has bounds: it is a name.

use nalgebra::{Complex, DMatrix};

use super::multipliers::{Multiplier, Place};
use crate::flow::{Equations, Plain};
use librate_core::order::Order;
use librate_core::precision::Ball;

/// Times at which the equations are averaged.
const SAMPLES: u32 = 96;
/// Squares of frequencies below this, beside what is averaged, are not told from 0.
const LEFT: f64 = 1e-12;

/// A parametric resonance: the sum or difference of two frequencies is about a multiple of that of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Resonance {
    /// The two frequencies, by their place in the list; the same twice for the resonance of one.
    pub of: (usize, usize),
    /// Whether they are added.
    pub sum: bool,
    /// The multiple: with one frequency w, the drive has 2 w/order.
    pub order: u32,
}

/// The frequencies of the equations averaged over a period, rising; none where no restoring force is left of some motion. With them how fast
/// motions of these equations grow, friction and all: without a resonance.
pub(super) fn frequencies(equations: &Equations, period: f64, state: &[Ball]) -> (Vec<f64>, f64) {
    let n = equations.dimension() / 2;
    let mut plain = Plain::new(equations);
    let mut state: Vec<f64> =
        if equations.is_moving() { state.iter().map(Ball::mid_f64).collect() } else { Vec::new() };
    let mut average = DMatrix::<f64>::zeros(2 * n, 2 * n);
    let mut size = 0.0_f64;
    for sample in 0..SAMPLES {
        let [begin, end] = [sample, sample + 1].map(|k| period * f64::from(k) / f64::from(SAMPLES));
        let mut first = true;
        let there = plain.travel(begin, end, &state, |_, _, jacobian| {
            if first {
                let share = DMatrix::from_row_slice(2 * n, 2 * n, &jacobian[..4 * n * n]) / f64::from(SAMPLES);
                size += share.view((n, 0), (n, n)).iter().map(|entry| entry.abs()).sum::<f64>();
                average += share;
            }
            first = false;
        });
        let Some((next, _)) = there else { return (Vec::new(), 0.0) };
        state = next;
    }
    let growth = average.complex_eigenvalues().iter().fold(0.0, |most: f64, own| most.max(own.re));
    let stiffness = -average.view((n, 0), (n, n));
    let squares = stiffness.complex_eigenvalues();
    // What the average leaves of terms that cancel is rounding.
    let is_rounding = |square: &Complex<f64>| square.norm() <= LEFT * size;
    let oscillates = |square: &Complex<f64>| square.re > 0.0 && square.im.abs() <= 1e-6 * square.re;
    let squares = squares.iter().filter(|square| !is_rounding(square));
    if !squares.clone().all(oscillates) {
        return (Vec::new(), growth);
    }
    let mut frequencies: Vec<f64> = squares.map(|square| square.re.sqrt()).collect();
    frequencies.order_by(f64::total_cmp);
    (frequencies, growth)
}

/// The resonance that is nearest among those of the kind of the largest multiplier: a real one belongs to a single
/// frequency, w P about a multiple of pi, even for a positive and odd for a negative one; any other to two. Of a drive that
/// repeats more often than the period that is given, the multiplier is a power of its own, which keeps the sign where the
/// number of cycles is odd. None where most of what it grows by is there without a resonance.
pub(super) fn resonance(
    multipliers: &[Multiplier],
    (frequencies, growth): &(Vec<f64>, f64),
    period: f64,
    cycles: u32,
) -> Option<Resonance> {
    let largest = multipliers.iter().find(|own| own.place == Place::Outside)?;
    if 2.0 * growth * period > largest.re.mid_f64().hypot(largest.im.mid_f64()).ln() {
        return None;
    }
    let drive = std::f64::consts::TAU * f64::from(cycles) / period;
    let mut best: Option<(f64, Resonance)> = None;
    let mut offer = |of: (usize, usize), sum: bool, order: f64, total: f64| {
        let order = order.max(1.0);
        let off = (total / drive - order).abs();
        if order < 1e6 && best.is_none_or(|(least, _)| off < least) {
            let order = order as u32;
            best = Some((off, Resonance { of, sum, order }));
        }
    };
    let real = largest.im.is_zero();
    for (i, first) in frequencies.iter().enumerate() {
        if real {
            let total = 2.0 * first;
            let order = total / drive;
            let order = if cycles.is_multiple_of(2) {
                order.round()
            } else if largest.re.is_positive() {
                (2.0 * (0.5 * order).round()).max(2.0)
            } else {
                2.0 * (0.5 * (order - 1.0)).round() + 1.0
            };
            offer((i, i), true, order, total);
            continue;
        }
        for (j, second) in frequencies.iter().enumerate().skip(i + 1) {
            for (sum, total) in [(true, first + second), (false, second - first)] {
                offer((i, j), sum, (total / drive).round(), total);
            }
        }
    }
    best.map(|(_, resonance)| resonance)
}
