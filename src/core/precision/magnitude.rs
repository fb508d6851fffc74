//! Sizes with an exponent of their own: bounds of errors far below and above the range of doubles.

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul};

use super::double::{power_of_two, scale};
use super::scalar::power;

/// Exponents beyond this are as good as infinite ...
const LARGEST: i64 = 1 << 42;
/// ... and sizes below 2 to this are rounded up to it.
const SMALLEST: i64 = -(1 << 42);

/// A nonnegative number `mantissa` 2^`exponent`, or infinity: the radius of a [`Big`](super::Big).
///
/// Every operation is rounded up, so that what is computed from upper bounds is one; those that end
/// in `_down` are rounded down and take lower bounds where the result rises with the operand.
/// 53 bits, exponents up to 2^42 either way: nothing overflows or vanishes on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct Magnitude {
    /// In [1, 2); 0 for zero, infinite for infinity, both with exponent 0.
    mantissa: f64,
    exponent: i64,
}

impl Magnitude {
    /// Zero.
    pub const ZERO: Self = Self { mantissa: 0.0, exponent: 0 };
    /// One.
    pub const ONE: Self = Self { mantissa: 1.0, exponent: 0 };
    /// Infinity: nothing is known.
    pub const INFINITE: Self = Self { mantissa: f64::INFINITY, exponent: 0 };

    /// A number of at least 1 and at most 4 times 2^exponent. Halving is exact.
    fn normal(mantissa: f64, exponent: i64) -> Self {
        let (mantissa, exponent) = if mantissa >= 4.0 {
            (0.25 * mantissa, exponent + 2)
        } else if mantissa >= 2.0 {
            (0.5 * mantissa, exponent + 1)
        } else {
            (mantissa, exponent)
        };
        if exponent > LARGEST {
            Self::INFINITE
        } else if exponent < SMALLEST {
            Self::power_of_two(SMALLEST)
        } else {
            Self { mantissa, exponent }
        }
    }

    /// 2^exponent; rounded up below 2^(-2^42), infinite above 2^(2^42).
    pub const fn power_of_two(exponent: i64) -> Self {
        if exponent > LARGEST {
            return Self::INFINITE;
        }
        Self { mantissa: 1.0, exponent: if exponent < SMALLEST { SMALLEST } else { exponent } }
    }

    /// The absolute value of a double, exactly; infinite for NaN.
    pub fn from_f64(value: f64) -> Self {
        let value = value.abs();
        if value == 0.0 {
            return Self::ZERO;
        }
        if !value.is_finite() {
            return Self::INFINITE;
        }
        // Subnormal numbers are scaled first.
        let (value, shift) = if value < f64::MIN_POSITIVE { (value * power_of_two(60), -60) } else { (value, 0) };
        let exponent = super::double::exponent_of(value);
        Self { mantissa: scale(value, -exponent), exponent: i64::from(exponent) + shift }
    }

    /// The whole number `leading` times 2^exponent, for `leading` below 2^53: exact.
    pub(crate) fn from_parts(leading: u64, exponent: i64) -> Self {
        let whole = Self::from_f64(leading as f64);
        if leading == 0 { whole } else { Self::normal(whole.mantissa, whole.exponent.saturating_add(exponent)) }
    }

    /// The smallest double not below; infinite beyond the range of doubles.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        if self.mantissa == 0.0 || self.mantissa == f64::INFINITY {
            return self.mantissa;
        }
        match self.exponent {
            1024.. => f64::INFINITY,
            -1022..=1023 => self.mantissa * power_of_two(self.exponent as i32),
            // Subnormal: rounded to nearest, then a step up.
            -1080..=-1023 => scale(self.mantissa, self.exponent as i32).next_up(),
            _ => f64::from_bits(1),
        }
    }

    /// The double nearest to log2 of the number: minus infinity for zero. Not a bound.
    #[must_use]
    pub fn log2(self) -> f64 {
        self.mantissa.log2() + self.exponent as f64
    }

    /// The mantissa in [1, 2), 0 or infinity, and the exponent of 2.
    #[must_use]
    pub fn parts(self) -> (f64, i64) {
        (self.mantissa, self.exponent)
    }

    /// Whether it is 0.
    #[inline]
    #[must_use]
    pub fn is_zero(self) -> bool {
        self.mantissa == 0.0
    }

    /// Whether it is not infinite.
    #[inline]
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.mantissa < f64::INFINITY
    }

    /// Times 2^exponent; exact but at the ends of the range, where it is rounded up.
    pub fn scale(self, exponent: i64) -> Self {
        if self.is_zero() || !self.is_finite() {
            return self;
        }
        Self::normal(self.mantissa, self.exponent.saturating_add(exponent))
    }

    /// The sum, rounded down: by a step, but not below the larger summand.
    pub fn add_down(self, other: Self) -> Self {
        let (large, small) = if self < other { (other, self) } else { (self, other) };
        if small.is_zero() || !large.is_finite() || large.exponent - small.exponent > 60 {
            return large;
        }
        let gap = (large.exponent - small.exponent) as i32;
        let sum = (large.mantissa + small.mantissa * power_of_two(-gap)).next_down();
        Self::normal(sum.max(large.mantissa), large.exponent)
    }

    /// A lower bound of self - other (0 where it isn't positive) from a lower bound `self` and an
    /// upper bound `other`.
    pub fn sub_down(self, other: Self) -> Self {
        if other.is_zero() || self.is_zero() {
            return self;
        }
        if !other.is_finite() || self <= other {
            return Self::ZERO;
        }
        if !self.is_finite() {
            return self;
        }
        // self > other, so the gap is not negative; the smaller one is rounded up.
        let gap = self.exponent - other.exponent;
        let small = if gap > 60 { power_of_two(-59) } else { other.mantissa * power_of_two(-(gap as i32)) };
        let rest = (self.mantissa - small).next_down();
        if rest <= 0.0 {
            return Self::ZERO;
        }
        let exact = Self::from_f64(rest);
        let exponent = exact.exponent + self.exponent;
        if exponent < SMALLEST { Self::ZERO } else { Self { exponent, ..exact } }
    }

    /// The square root, rounded up.
    pub fn sqrt(self) -> Self {
        self.root(f64::next_up)
    }

    /// The square root, rounded down.
    pub fn sqrt_down(self) -> Self {
        // The root of a mantissa in [1, 4) is 1 or at least 1 + 2^-53 in doubles, so that a step down
        // leaves [1, 2) only from 1 itself, which is exact.
        self.root(|root| if root > 1.0 { root.next_down() } else { root })
    }

    fn root(self, rounded: impl Fn(f64) -> f64) -> Self {
        if self.is_zero() || !self.is_finite() {
            return self;
        }
        let half = self.exponent.div_euclid(2);
        let rest = if self.exponent.rem_euclid(2) == 1 { 2.0 } else { 1.0 };
        Self::normal(rounded((self.mantissa * rest).sqrt()), half)
    }

    /// A power with a whole exponent, rounded up.
    pub fn powi(self, exponent: u32) -> Self {
        power(&self, exponent, |x, y| *x * *y).unwrap_or(Self::ONE)
    }

    /// An upper bound of exp(self) - 1, and of exp(self) where it is 1 greater: e^r - 1 <= r e^r, and
    /// e^r <= 1 + 2r up to r = 1/2, e^r <= 3^ceil(r) beyond. Infinite from 2^20 on.
    pub(crate) fn exp(self) -> Self {
        if self <= Self::power_of_two(-1) {
            return Self::ONE.add(self.scale(1));
        }
        if self >= Self::power_of_two(20) {
            return Self::INFINITE;
        }
        Self::from_f64(3.0).powi(self.to_f64().ceil() as u32)
    }

    /// The smaller one.
    pub fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    /// The larger one.
    pub fn max(self, other: Self) -> Self {
        if self < other { other } else { self }
    }
}

impl Add for Magnitude {
    type Output = Self;

    /// The sum, rounded up: adding two doubles is off by at most half a unit of the last place of the
    /// result, which one step up covers.
    fn add(self, other: Self) -> Self {
        if self.is_zero() || !other.is_finite() {
            return other;
        }
        if other.is_zero() || !self.is_finite() {
            return self;
        }
        let (large, small) = if self.exponent >= other.exponent { (self, other) } else { (other, self) };
        let gap = large.exponent - small.exponent;
        if gap > 60 {
            // What is added is below 2^-59, half a step at most.
            return Self::normal(large.mantissa.next_up(), large.exponent);
        }
        let sum = large.mantissa + small.mantissa * power_of_two(-(gap as i32));
        Self::normal(sum.next_up(), large.exponent)
    }
}

impl Mul for Magnitude {
    type Output = Self;

    /// The product, rounded up; 0 times infinity is infinite.
    fn mul(self, other: Self) -> Self {
        if !(self.is_finite() && other.is_finite()) {
            return Self::INFINITE;
        }
        if self.is_zero() || other.is_zero() {
            return Self::ZERO;
        }
        Self::normal((self.mantissa * other.mantissa).next_up(), self.exponent + other.exponent)
    }
}

impl Div for Magnitude {
    type Output = Self;

    /// The quotient of an upper bound by a lower one, rounded up; infinite where the divisor is 0.
    fn div(self, lower: Self) -> Self {
        if lower.is_zero() || !self.is_finite() {
            return Self::INFINITE;
        }
        if self.is_zero() || !lower.is_finite() {
            return Self::ZERO;
        }
        // The quotient lies in (1/2, 2).
        Self::normal(2.0 * (self.mantissa / lower.mantissa).next_up(), self.exponent - lower.exponent - 1)
    }
}

impl PartialOrd for Magnitude {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        let special = |x: &Self| x.is_zero() || !x.is_finite();
        if special(self) || special(other) || self.exponent == other.exponent {
            return self.mantissa.partial_cmp(&other.mantissa);
        }
        Some(self.exponent.cmp(&other.exponent))
    }
}
