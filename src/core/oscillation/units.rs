//! Modes that were found in units of their own, in SI.

use std::borrow::Cow;

use super::{NormalMode, NormalModes};
use crate::linearize::{Linearized, Units};
use crate::modes::Precise;
use crate::precision::{Ball, Big, Magnitude};

/// Exponents of 2 of the numbers that a ball holds with all its digits.
const OF_BALLS: std::ops::Range<i64> = -850..980;

/// Bits of a number that a ball held in other units.
const BITS: usize = 128;

fn is_lost(before: &Ball, after: &Ball) -> bool {
    let (_, exponent) = Magnitude::from_f64(after.abs_upper()).parts();
    let held = after.is_finite() && OF_BALLS.contains(&exponent);
    !(held || before.is_zero())
}

/// Puts a mode's numbers in SI. Where balls do not hold them there, [`NormalMode::precise`] does.
pub(super) fn in_si(units: &Units, mode: &mut NormalMode) {
    let rate = units.rate();
    let [omega, growth] = [&mode.omega, &mode.growth].map(|x| x.scale_far(rate));
    let square = mode.omega_squared.map(|square| square.scale_far(2 * rate));
    let pairs = [(&mode.omega, &omega), (&mode.growth, &growth)];
    let squares = mode.omega_squared.as_ref().zip(square.as_ref());
    let lost = pairs.into_iter().chain(squares).any(|(before, after)| is_lost(before, after));
    if lost && mode.precise.is_none() {
        let big = |x: &Ball| Big::from_ball(x, BITS);
        let (omega, growth) = (big(&mode.omega), big(&mode.growth));
        let square = mode.omega_squared.as_ref().map_or_else(|| &(&omega * &omega) - &(&growth * &growth), big);
        mode.precise = Some(Box::new(Precise { omega_squared: square, omega, growth }));
    }
    if let Some(precise) = mode.precise.as_deref_mut() {
        precise.omega_squared = precise.omega_squared.scale(2 * rate);
        precise.omega = precise.omega.scale(rate);
        precise.growth = precise.growth.scale(rate);
    }
    (mode.omega, mode.growth, mode.omega_squared) = match mode.precise.as_deref() {
        Some(precise) => (
            precise.omega.to_far_ball(),
            precise.growth.to_far_ball(),
            square.map(|_| precise.omega_squared.to_far_ball()),
        ),
        None => (omega, growth, square),
    };
    let count = mode.vector.len();
    mode.component_error_bounds = units.component_errors(mode.vector_error_bound, count);
}

/// Modes in the units that the matrices of the model are in: the way back.
pub fn in_units<'a>(linearized: &Linearized, modes: &'a NormalModes) -> Cow<'a, NormalModes> {
    let Some(units) = linearized.units() else { return Cow::Borrowed(modes) };
    let mut modes = modes.clone();
    let rate = -units.rate();
    for mode in &mut modes.modes {
        let back = |x: &Ball, precise: Option<&Big>, power: i64| match precise {
            Some(precise) => precise.scale(power).to_far_ball(),
            None => x.scale_far(power),
        };
        let precise = mode.precise.take();
        let precise = precise.as_deref();
        let square = precise.map(|own| &own.omega_squared);
        mode.omega = back(&mode.omega, precise.map(|own| &own.omega), rate);
        mode.growth = back(&mode.growth, precise.map(|own| &own.growth), rate);
        mode.omega_squared = mode.omega_squared.map(|x| back(&x, square, 2 * rate));
        let count = mode.vector.len();
        units.shape(&mut mode.vector, true);
        units.shape(&mut mode.imaginary, true);
        mode.vector_error_bound = units.shape_error(mode.vector_error_bound, count, true);
    }
    Cow::Owned(modes)
}
