//! Intervals between doubles, for filters of whole boxes of values ([`super::sieve`]), of which there are many.
//!
//! The nearest double to a sum, product, quotient or root of doubles has no double between it and the true value: the
//! next double beyond it is a bound.

use std::cmp::Ordering;

use crate::precision::{Ball, power};

/// The numbers from one double to another, these included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Interval {
    pub(super) const ZERO: Self = Self::at(0.0);
    pub(super) const ONE: Self = Self::at(1.0);

    pub(super) const fn at(value: f64) -> Self {
        Self { low: value, high: value }
    }

    pub(super) fn from_ball(ball: &Ball) -> Self {
        Self { low: ball.lower(), high: ball.upper() }
    }

    /// Next to rounded bounds; of what is known not to be negative the lower one neither.
    fn around(low: f64, high: f64, is_nonnegative: bool) -> Self {
        let low = low.next_down();
        Self { low: if is_nonnegative { low.max(0.0) } else { low }, high: high.next_up() }
    }

    pub(super) fn is_finite(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    pub(super) fn neg(self) -> Self {
        Self { low: -self.high, high: -self.low }
    }

    pub(super) fn add(self, other: Self) -> Self {
        Self::around(self.low + other.low, self.high + other.high, self.low >= 0.0 && other.low >= 0.0)
    }

    pub(super) fn mul(self, other: Self) -> Self {
        let [a, b, c, d] = [self.low * other.low, self.low * other.high, self.high * other.low, self.high * other.high];
        Self::around(a.min(b).min(c.min(d)), a.max(b).max(c.max(d)), self.low >= 0.0 && other.low >= 0.0)
    }

    /// `None` where the divisor may be 0.
    pub(super) fn inverse(self) -> Option<Self> {
        (self.low > 0.0 || self.high < 0.0).then(|| Self::around(1.0 / self.high, 1.0 / self.low, self.low > 0.0))
    }

    pub(super) fn abs(self) -> Self {
        if self.low >= 0.0 {
            self
        } else if self.high <= 0.0 {
            self.neg()
        } else {
            Self { low: 0.0, high: self.high.max(-self.low) }
        }
    }

    pub(super) fn square(self) -> Self {
        let size = self.abs();
        size.mul(size)
    }

    pub(super) fn powi(self, exponent: i32) -> Option<Self> {
        let product = |x: &Self, y: &Self| if x == y { x.square() } else { x.mul(*y) };
        let power = power(&self, exponent.unsigned_abs(), product).unwrap_or(Self::ONE);
        if exponent < 0 { power.inverse() } else { Some(power) }
    }

    /// `None` where it may be negative.
    pub(super) fn sqrt(self) -> Option<Self> {
        (self.low >= 0.0).then(|| Self::around(self.low.sqrt(), self.high.sqrt(), true))
    }

    /// `None` where it is open.
    pub(super) fn order(self, other: Self) -> Option<Ordering> {
        if self.high < other.low {
            Some(Ordering::Less)
        } else if self.low > other.high {
            Some(Ordering::Greater)
        } else {
            let equal = self.low == self.high && self == other;
            equal.then_some(Ordering::Equal)
        }
    }
}
