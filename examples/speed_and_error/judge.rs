//! Eigenvalues held against true ones, in exact arithmetic.

use dashu_int::IBig;
use librate::number::Number;

/// m 2^exponent.
pub(crate) fn binary(significand: IBig, exponent: i64) -> Number {
    let power = Number::from(2).powi(i32::try_from(exponent).unwrap_or(0)).unwrap_or_else(|| Number::from(1));
    Number::from_integer(significand).mul(&power)
}

/// A decimal string as the number that it is.
pub(crate) fn parse(text: &str) -> Option<Number> {
    match text.strip_prefix('-') {
        Some(rest) => Number::parse(rest).map(|x| x.neg()),
        None => Number::parse(text),
    }
}

/// How eigenvalues compare with the true ones.
#[derive(Clone, Debug, Default)]
pub(crate) struct Judged {
    /// The largest relative error of a frequency, or rate of growth, that is not zero. One that comes with
    /// the wrong sign of ω² is off by more than 1.
    pub(crate) error: f64,
    /// The relative error of each.
    pub(crate) errors: Vec<f64>,
    /// How many ω² have the wrong sign, zeros left aside.
    pub(crate) wrong_signs: usize,
    /// The largest frequency that is truly zero, in units of the lowest one that is not; either sign.
    pub(crate) zero: Option<f64>,
}

/// Relative error of sign(λ) √|λ| for λ = (1 + δ) λ': |√(1 + δ) - 1|, free of cancellation.
fn of_frequency(delta: f64) -> f64 {
    if delta >= -1.0 { delta.abs() / (1.0 + (1.0 + delta).sqrt()) } else { 1.0 + (-1.0 - delta).sqrt() }
}

/// Rising eigenvalues, all or the lowest ones, against all the true ones; what is below the digits of these
/// is no error.
pub(crate) fn judge(values: &[Number], truth: &[Number], digits: usize) -> Judged {
    let resolution = 10f64.powi(-(digits.min(300) as i32));
    let least = truth.iter().filter(|x| !x.is_zero()).map(Number::abs);
    let least = least.reduce(|a, b| if a.sub(&b).is_negative() { a } else { b });
    let mut judged = Judged::default();
    for (value, truth) in values.iter().zip(truth) {
        if truth.is_zero() {
            let size = least.as_ref().and_then(|least| value.abs().div(least));
            let size = size.map_or(0.0, |x| x.to_f64().sqrt());
            judged.zero = Some(judged.zero.unwrap_or(0.0).max(size));
        } else {
            let delta = value.sub(truth).div(truth).map_or(0.0, |x| x.to_f64());
            let error = Some(of_frequency(delta)).filter(|error| *error > resolution);
            let error = error.unwrap_or(0.0);
            judged.wrong_signs += usize::from(delta <= -1.0);
            judged.error = judged.error.max(error);
            judged.errors.push(error);
        }
    }
    judged
}

/// A ball: midpoint and radius, exactly.
pub(crate) struct Enclosure {
    pub(crate) mid: Number,
    pub(crate) radius: Number,
}

impl Enclosure {
    /// Whether the ball holds a number that is known up to a part of `1e-digits`.
    pub(crate) fn holds(&self, truth: &Number, digits: usize) -> bool {
        let unit = Number::from(10).powi(-(digits as i32));
        let slack = truth.abs().mul(&unit.unwrap_or_else(|| Number::from(0))).add(&self.radius);
        !slack.sub(&self.mid.sub(truth).abs()).is_negative()
    }

    /// The bound of the relative error of the frequency: 1 - √(1 - r) for a relative radius r; `None`
    /// where the sign is open or the ball is exactly zero.
    pub(crate) fn bound(&self) -> Option<f64> {
        let relative = self.radius.div(&self.mid.abs())?.to_f64();
        (relative < 1.0).then(|| relative / (1.0 + (1.0 - relative).sqrt()))
    }
}
