//! Numbers from text and to text, from and to floating point.

use std::fmt;

use dashu_int::{IBig, Sign, UBig};
use dashu_ratio::RBig;

use super::{Number, Repr};

/// Largest decimal exponent of a literal, either way, and most digits it may have: as many as the longest number has,
/// and some zeros.
const MAX_DECIMAL_EXPONENT: u64 = 40_000;
const MAX_DIGITS: usize = 40_000;
/// Whole numbers up to here are exact in a double.
const EXACT: u64 = 1 << 53;

/// A number as a sum of two doubles, which is off by `error` at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoDoubles {
    /// The nearest double.
    pub high: f64,
    /// The double nearest to the remainder.
    pub low: f64,
    /// An upper bound of what is left.
    pub error: f64,
}

impl Number {
    /// The exact value of a decimal literal: `2`, `0.5`, `6.02e23`, with an optional minus sign.
    ///
    /// `None` for anything else, and for numbers of more than [`MAX_BITS`](super::MAX_BITS) bits.
    #[must_use]
    pub fn parse(text: &str) -> Option<Number> {
        let (negative, text) = text.strip_prefix('-').map_or((false, text), |rest| (true, rest));
        let (mantissa, exponent) = match text.split_once(['e', 'E']) {
            Some((mantissa, exponent)) => (mantissa, exponent.parse::<i64>().ok()?),
            None => (text, 0),
        };
        if exponent.unsigned_abs() > MAX_DECIMAL_EXPONENT {
            return None;
        }
        let (whole, fraction) = match mantissa.split_once('.') {
            Some((_, "")) => return None,
            Some(parts) => parts,
            None => (mantissa, ""),
        };
        let are_digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
        if whole.is_empty() || !are_digits(whole) || !are_digits(fraction) || whole.len() + fraction.len() > MAX_DIGITS
        {
            return None;
        }
        if let Some(number) = short_decimal(whole, fraction, exponent) {
            return Some(if negative { number.neg() } else { number });
        }
        let digits = format!("{whole}{fraction}");
        let magnitude = UBig::from_str_radix(&digits, 10).ok()?;
        let sign = if negative { Sign::Negative } else { Sign::Positive };
        let numerator = IBig::from_parts(sign, magnitude);
        let shift = exponent - fraction.len() as i64;
        let power = UBig::from(10u8).pow(shift.unsigned_abs() as usize);
        let number =
            if shift >= 0 { Number::from_integer(numerator * power) } else { Number::from_parts(numerator, power)? };
        (!number.is_oversized()).then_some(number)
    }

    /// The nearest double, ties to even; infinite beyond the range of doubles.
    #[must_use]
    pub fn to_f64(&self) -> f64 {
        match &self.0 {
            Repr::Small(n, d) if d.get() == 1 => *n as f64,
            // One correctly rounded division of two exact doubles.
            Repr::Small(n, d) if n.unsigned_abs() <= EXACT && d.get() <= EXACT => *n as f64 / d.get() as f64,
            Repr::Small(..) => self.to_big().to_f64().value(),
            Repr::Big(value) => value.to_f64().value(),
        }
    }

    /// The number as a sum of two doubles.
    ///
    /// Beyond the range of doubles `high` is infinite, `low` 0 and `error` infinite.
    #[must_use]
    pub fn to_double_double(&self) -> TwoDoubles {
        let high = self.to_f64();
        if !high.is_finite() {
            return TwoDoubles { high, low: 0.0, error: f64::INFINITY };
        }
        if let Repr::Small(n, d) = &self.0
            && n.unsigned_abs() <= EXACT
            && d.get() <= EXACT
        {
            // The remainder of a rounded division is a double (here far from underflow), so that
            // the fused operation gives it exactly; its quotient by d is off by half an ulp.
            let (n, d) = (*n as f64, d.get() as f64);
            let low = (-high).mul_add(d, n) / d;
            let error = if low == 0.0 { 0.0 } else { (low.abs() * f64::EPSILON / 2.0).next_up() };
            return TwoDoubles { high, low, error };
        }
        let Some(remainder) = Number::from_f64_exact(high).map(|h| self.sub(&h)) else {
            return TwoDoubles { high, low: 0.0, error: f64::INFINITY };
        };
        let low = remainder.to_f64();
        let error = match Number::from_f64_exact(low) {
            Some(l) => remainder.sub(&l),
            None => remainder,
        };
        if error.is_zero() {
            return TwoDoubles { high, low, error: 0.0 };
        }
        // Nearest, then one step up: an upper bound, of what underflows too.
        TwoDoubles { high, low, error: error.abs().to_f64().next_up() }
    }

    /// The exact value of a double; `None` of infinities and NaN.
    #[must_use]
    pub fn from_f64_exact(value: f64) -> Option<Number> {
        if value.abs() <= EXACT as f64 && value.fract() == 0.0 {
            return Some(Number::from(value as i64));
        }
        RBig::try_from(value).ok().map(Number::from_big)
    }
}

/// A number of few digits; `None` for any other.
fn short_decimal(whole: &str, fraction: &str, exponent: i64) -> Option<Number> {
    const MOST: usize = 18;
    if whole.len() + fraction.len() > MOST {
        return None;
    }
    let digits = whole.bytes().chain(fraction.bytes()).fold(0, |sum, digit| 10 * sum + i64::from(digit - b'0'));
    let shift = exponent - fraction.len() as i64;
    let power = 10_i64.checked_pow(u32::try_from(shift.abs()).ok()?)?;
    if shift < 0 { Number::ratio(digits, power) } else { digits.checked_mul(power).map(Number::from) }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Repr::Small(n, d) if d.get() == 1 => write!(f, "{n}"),
            Repr::Small(n, d) => write!(f, "{n}/{d}"),
            Repr::Big(value) if value.is_int() => write!(f, "{}", value.numerator()),
            Repr::Big(value) => write!(f, "{}/{}", value.numerator(), value.denominator()),
        }
    }
}

impl fmt::Debug for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}
