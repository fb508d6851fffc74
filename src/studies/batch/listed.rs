//! The exponents of one set in their order, conjugates beside each other.

use faer::c64;

use super::complex::ComplexLane;
use super::exponents::Exponents;
use librate_core::order::Order;
use librate_core::precision::Lane;

/// An imaginary part that is this small a part of an exponent is rounding.
const NEGLIGIBLE: f64 = 8.0 * f64::EPSILON;
/// The first component within this fraction of the largest one is made real.
const ALIKE: f64 = 1e-6;

/// An exponent of one set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Listed {
    pub(super) value: c64,
    /// A bound of its absolute error.
    pub(super) bound: f64,
    /// Which of the vectors is its own, or, where its imaginary part is negative, has it for its conjugate.
    vector: usize,
}

/// Lists the exponents of a set. Those of a real matrix are real or in pairs; what rounding leaves of that is
/// repaired, at the expense of the bound.
pub(super) fn list(values: &[ComplexLane], radii: Option<&[Lane]>, unit: f64, lane: usize, all: &mut Vec<Listed>) {
    let value = |k: usize| {
        let own = values[k].get(lane);
        c64::new(own.re * unit, own.im * unit)
    };
    let bound = |k: usize| match radii.map(|radii| radii[k].0[lane]) {
        // Underflow, in the unit and in the exponent.
        Some(radius) if radius.is_finite() => radius * unit + f64::MIN_POSITIVE,
        _ => f64::INFINITY,
    };
    // The distance or somewhat more.
    let apart = |a: c64, b: c64| (a.re - b.re).abs() + (a.im - b.im).abs();
    let more = 1.0 + 8.0 * f64::EPSILON;
    let is_real = |k: &usize| {
        let own = value(*k);
        let others = (0..values.len()).filter(|j| j != k);
        own.im.abs() <= NEGLIGIBLE * own.re.abs()
            || others.map(|j| apart(own.conj(), value(j))).fold(f64::INFINITY, f64::min) > 2.0 * own.im.abs()
    };
    let mut real: Vec<usize> = (0..values.len()).filter(is_real).collect();
    let others = (0..values.len()).filter(|k| !real.contains(k));
    let (mut upper, mut lower): (Vec<usize>, Vec<usize>) = others.partition(|k| value(*k).im > 0.0);
    upper.order_by(|i, j| value(*j).im.total_cmp(&value(*i).im));
    all.clear();
    for k in upper {
        let own = value(k);
        let nearest = (0..lower.len()).min_by(|i, j| {
            let [a, b] = [i, j].map(|at| apart(own.conj(), value(lower[*at])));
            a.total_cmp(&b)
        });
        let Some(nearest) = nearest else {
            real.push(k);
            continue;
        };
        let other = lower.remove(nearest);
        let bound = bound(k).max((bound(other) + apart(own.conj(), value(other))) * more);
        all.extend([own, own.conj()].map(|value| Listed { value, bound, vector: k }));
    }
    real.extend(lower);
    all.extend(real.into_iter().map(|k| {
        let own = value(k);
        Listed { value: c64::new(own.re + 0.0, 0.0), bound: (bound(k) + own.im.abs()) * more, vector: k }
    }));
    all.order_by(|a, b| {
        let by_frequency = a.value.im.abs().total_cmp(&b.value.im.abs());
        let by_rate = by_frequency.then(a.value.re.total_cmp(&b.value.re));
        by_rate.then(a.vector.cmp(&b.vector)).then(b.value.im.total_cmp(&a.value.im))
    });
}

impl Listed {
    /// Writes the shape, with xᴴMx = 1 and its leading component real and positive.
    pub(super) fn shape(&self, solved: &Exponents, lane: usize, into: &mut [c64]) {
        let vector = solved.shapes[self.vector][lane];
        let half = if solved.is_fast(vector).0[lane] == 0.0 { 0 } else { into.len() };
        let from = &solved.right[vector * solved.values.len() + half..];
        for (to, from) in into.iter_mut().zip(from) {
            *to = from.get(lane);
        }
        let size = |x: &c64| x.re.hypot(x.im);
        let largest = into.iter().map(size).fold(0.0, f64::max);
        let Some(first) = into.iter().position(|x| size(x) >= largest * (1.0 - ALIKE)) else { return };
        let turn = into[first].conj() / (size(&into[first]) * solved.lengths[vector].0[lane]);
        for x in into.iter_mut() {
            *x *= turn;
        }
        into[first].im = 0.0;
        if self.value.im < 0.0 {
            into.iter_mut().for_each(|x| *x = x.conj());
        }
    }
}
