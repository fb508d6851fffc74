//! Rigorous enclosures at any precision: a binary midpoint of so many bits and an error bound with
//! an exponent of its own.
//!
//! A [`Big`] stands for some real number x with |x - mid| <= radius, as a [`Ball`] does, and every
//! operation returns one that contains the result for all numbers in its operands. The midpoint
//! significand 2^exponent is rounded to nearest to `bits` bits, which is off by at most half a unit
//! of the last place, and by nothing where no bits are lost: exact data stay exact as long as they
//! fit.

mod arithmetic;
mod functions;
mod sum;

pub(crate) use sum::Sum;

use std::ops::Add;

use dashu_int::ops::{BitTest, PowerOfTwo};
use dashu_int::{IBig, Sign, UBig, Word};

use super::ball::Ball;
use super::double::DoubleDouble;
use super::magnitude::Magnitude;
use crate::number::Number;

/// Numbers from 2 to this on count as not finite; those below its inverse as 0 up to that.
const LARGEST: i64 = 1 << 40;
/// More bits than this are not worked with.
pub(crate) const MOST_BITS: usize = 1 << 24;

/// A real number known to lie within a radius of a binary number of `bits` bits.
///
/// Operations on two numbers work with the larger of their precisions.
///
/// # Examples
///
/// ```
/// use librate::number::Number;
/// use librate::precision::Big;
/// let third = Big::from_number(&Number::ratio(1, 3).unwrap(), 200);
/// assert!(!third.is_exact() && (&(&third * &Big::from_f64(3.0, 200)) - &Big::one(200)).contains_zero());
/// assert_eq!(third.decimal(50).text, format!("0.{}", "3".repeat(50)));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct Big {
    significand: IBig,
    exponent: i64,
    bits: usize,
    radius: Magnitude,
}

/// Leading bits of a magnitude.
struct Leading {
    /// So many as are asked for, fewer if it has fewer.
    bits: u64,
    /// How many follow.
    shift: usize,
    /// Whether any of those is not 0.
    more: bool,
}

fn leading(value: &IBig, count: usize) -> Leading {
    let (_, words) = value.as_sign_words();
    let shift = value.bit_len().saturating_sub(count);
    let size = Word::BITS as usize;
    let (first, offset) = (shift / size, shift % size);
    let (low, high) = words.split_at(first.min(words.len()));
    let bits = high.iter().rev().fold(0u128, |bits, word| bits << size | u128::from(*word));
    let below = bits & ((1u128 << offset) - 1) != 0 || low.iter().any(|word| *word != 0);
    Leading { bits: (bits >> offset) as u64, shift, more: below }
}

impl Big {
    /// No number at all: what comes of leaving the domain or the range. As its radius is infinite, so is that of what is computed from it.
    pub fn not_finite(bits: usize) -> Self {
        Self { significand: IBig::ZERO, exponent: 0, bits, radius: Magnitude::INFINITE }
    }

    /// Zero, exactly.
    pub fn zero(bits: usize) -> Self {
        Self::from_parts(IBig::ZERO, 0, bits)
    }

    /// One, exactly.
    pub fn one(bits: usize) -> Self {
        Self::from_parts(IBig::ONE, 0, bits)
    }

    /// significand 2^exponent, rounded to `bits` bits (at least 2).
    pub fn from_parts(significand: IBig, exponent: i64, bits: usize) -> Self {
        Self::rounded(significand, exponent, bits, Magnitude::ZERO)
    }

    /// The midpoint rounded to nearest (ties away from zero) to `bits` bits, with a radius larger by
    /// half a unit of the last place if bits that are not 0 are dropped.
    fn rounded(significand: IBig, exponent: i64, bits: usize, radius: Magnitude) -> Self {
        let bits = bits.clamp(2, MOST_BITS);
        let length = significand.bit_len();
        if length == 0 {
            return Self { significand, exponent: 0, bits, radius };
        }
        let top = exponent.saturating_add(length as i64);
        if top > LARGEST || !radius.is_finite() {
            return Self::not_finite(bits);
        }
        if top < -LARGEST {
            // Below 2^top in size.
            let radius = radius.add(Magnitude::power_of_two(top));
            return Self { significand: IBig::ZERO, exponent: 0, bits, radius };
        }
        if length <= bits {
            return Self { significand, exponent, bits, radius };
        }
        let drop = length - bits;
        let (sign, magnitude) = significand.into_parts();
        let exact = magnitude.trailing_zeros().is_none_or(|zeros| zeros >= drop);
        let away = magnitude.bit(drop - 1);
        let mut kept = magnitude >> drop;
        if away {
            kept += UBig::ONE;
        }
        let exponent = exponent + drop as i64;
        Self {
            significand: IBig::from_parts(sign, kept),
            exponent,
            bits,
            radius: if exact { radius } else { radius.add(Magnitude::power_of_two(exponent - 1)) },
        }
    }

    /// A number that contains an exact one.
    pub fn from_number(number: &Number, bits: usize) -> Self {
        let bits = bits.clamp(2, MOST_BITS);
        let denominator = number.denominator();
        if denominator.is_power_of_two() {
            let shift = denominator.trailing_zeros().unwrap_or(0);
            return Self::from_parts(number.numerator(), -(shift as i64), bits);
        }
        arithmetic::quotient(number.numerator(), &denominator, 0, bits, Magnitude::ZERO)
    }

    /// A double (rounded if `bits` is below 53); infinities and NaN are not finite.
    pub fn from_f64(value: f64, bits: usize) -> Self {
        if !value.is_finite() {
            return Self::not_finite(bits);
        }
        let (significand, exponent) = super::decimal::parts(value);
        Self::from_parts(significand, i64::from(exponent), bits)
    }

    /// A double-double.
    pub(crate) fn from_double_double(value: DoubleDouble, bits: usize) -> Self {
        &Self::from_f64(value.hi, bits) + &Self::from_f64(value.lo, bits)
    }

    /// A ball, with its radius.
    pub fn from_ball(value: &Ball, bits: usize) -> Self {
        Self::from_double_double(value.mid, bits).with_added_radius(Magnitude::from_f64(value.radius))
    }

    /// A [`Ball`] that contains the number; not finite beyond the range of balls.
    ///
    /// The leading 53 bits of the midpoint and 53 of what follows them make a double-double that is
    /// off by less than one unit of its last bit; what is too small for a double goes to the radius.
    #[must_use]
    pub fn to_ball(&self) -> Ball {
        if !self.is_finite() || self.top() > 980 {
            return Ball::NOT_FINITE;
        }
        if self.top() < -900 {
            return Ball::ZERO.with_added_radius(self.abs_upper().to_f64());
        }
        let Leading { bits: high, shift, more } = leading(&self.significand, 53);
        let place = self.exponent + shift as i64;
        let negative = self.is_mid_negative();
        let double = |bits: u64, place: i64| {
            let size = super::double::scale(bits as f64, place as i32);
            if negative { -size } else { size }
        };
        let mut rest = Magnitude::ZERO;
        let mut low = 0.0;
        if more {
            let (_, magnitude) = self.significand.clone().into_parts();
            let tail = IBig::from(magnitude.split_bits(shift).0);
            let next = leading(&tail, 53);
            let last = self.exponent + next.shift as i64;
            if last > -1020 {
                low = double(next.bits, last);
            } else {
                rest = Magnitude::power_of_two(self.exponent + tail.bit_len() as i64);
            }
            if next.more {
                rest = rest.add(Magnitude::power_of_two(last));
            }
        }
        // The sum of the two is not rounded but written with the nearest double first.
        let mid = DoubleDouble::new(double(high, place), low);
        Ball::new(mid, self.radius.add(rest).to_f64())
    }

    /// The same beyond the range of balls: see [`Ball::scale_far`].
    pub(crate) fn to_far_ball(&self) -> Ball {
        let size = self.abs_upper();
        if size.is_zero() || !size.is_finite() {
            return self.to_ball();
        }
        let (_, by) = size.parts();
        self.scale(-by).to_ball().scale_far(by)
    }

    /// The midpoint as a fraction of powers of 2: `(significand, exponent)`.
    #[must_use]
    pub fn mid(&self) -> (&IBig, i64) {
        (&self.significand, self.exponent)
    }

    /// The midpoint alone, exactly; not finite if the number isn't.
    pub fn center(&self) -> Self {
        if !self.is_finite() {
            return self.clone();
        }
        Self { radius: Magnitude::ZERO, ..self.clone() }
    }

    /// The double nearest to the midpoint, among those below the range of normal ones up to one unit of the last place; infinite
    /// or 0 beyond the range of doubles, NaN where the number is not finite.
    #[must_use]
    pub fn mid_f64(&self) -> f64 {
        if !self.is_finite() {
            return f64::NAN;
        }
        // Two bits more than a double has, the last one for all that follow: the conversion rounds to the nearest one.
        let Leading { bits, shift, more } = leading(&self.significand, 55);
        let place = (self.exponent + shift as i64).clamp(-4000, 4000) as i32;
        let size = super::double::scale((bits | u64::from(more)) as f64, place);
        if self.is_mid_negative() { -size } else { size }
    }

    /// The largest distance from the midpoint; 0 for an exact number.
    pub fn radius(&self) -> Magnitude {
        self.radius
    }

    /// The precision that results are rounded to.
    #[must_use]
    pub fn bits(&self) -> usize {
        self.bits
    }

    /// The exponent e with |mid| < 2^e, 2^(e-1) <= |mid|; very small for 0.
    fn top(&self) -> i64 {
        match self.significand.bit_len() {
            0 => -4 * LARGEST,
            length => self.exponent + length as i64,
        }
    }

    fn is_mid_negative(&self) -> bool {
        self.significand.sign() == Sign::Negative
    }

    fn is_mid_zero(&self) -> bool {
        self.significand.is_zero()
    }

    /// Whether the number is one at all.
    #[inline]
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.radius.is_finite()
    }

    /// Whether the number is known exactly.
    #[inline]
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.radius.is_zero()
    }

    /// Whether the number is zero, exactly.
    #[inline]
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.is_exact() && self.is_mid_zero()
    }

    /// Whether the number is certainly positive. Decided by the leading 53 bits of the midpoint.
    #[must_use]
    pub fn is_positive(&self) -> bool {
        !self.is_mid_negative() && self.mid_lower() > self.radius
    }

    /// Whether the number is certainly negative.
    #[must_use]
    pub fn is_negative(&self) -> bool {
        self.is_mid_negative() && self.mid_lower() > self.radius
    }

    /// Whether the number may be zero; true as well if it is not finite.
    #[must_use]
    pub fn contains_zero(&self) -> bool {
        !(self.is_positive() || self.is_negative())
    }

    /// An upper bound of |mid|.
    pub(crate) fn mid_upper(&self) -> Magnitude {
        let Leading { bits, shift, more } = leading(&self.significand, 53);
        Magnitude::from_parts(bits + u64::from(more), self.exponent + shift as i64)
    }

    /// A lower bound of |mid|.
    pub(crate) fn mid_lower(&self) -> Magnitude {
        let Leading { bits, shift, .. } = leading(&self.significand, 53);
        Magnitude::from_parts(bits, self.exponent + shift as i64)
    }

    /// An upper bound of the absolute value; infinite if the number is not finite.
    pub fn abs_upper(&self) -> Magnitude {
        self.mid_upper().add(self.radius)
    }

    /// A lower bound of the absolute value; 0 if the number may be 0.
    pub fn abs_lower(&self) -> Magnitude {
        self.mid_lower().sub_down(self.radius)
    }

    /// The same number with a radius larger by `error`.
    pub fn with_added_radius(mut self, error: Magnitude) -> Self {
        self.radius = self.radius.add(error);
        if self.radius.is_finite() { self } else { Self::not_finite(self.bits) }
    }

    /// The same number at another precision, rounded if that is lower.
    pub fn with_bits(self, bits: usize) -> Self {
        Self::rounded(self.significand, self.exponent, bits, self.radius)
    }

    /// Absolute value. Where the number may be 0, it is [0, m] for the larger end m.
    pub fn abs(&self) -> Self {
        if !self.contains_zero() || self.is_exact() {
            if self.is_mid_negative() { -self } else { self.clone() }
        } else {
            Self::from_zero_to(self.abs_upper(), self.bits)
        }
    }

    /// The numbers from 0 to `end`.
    pub(crate) fn from_zero_to(end: Magnitude, bits: usize) -> Self {
        let half = end.scale(-1);
        let mid = Self::from_magnitude(half, bits);
        mid.with_added_radius(half)
    }

    /// A magnitude as a number, exactly if there are 53 bits for it.
    pub(crate) fn from_magnitude(value: Magnitude, bits: usize) -> Self {
        let (mantissa, exponent) = value.parts();
        Self::from_f64(mantissa, bits).scale(exponent)
    }

    /// A number whose bounds hold both.
    ///
    /// With c any point, |x - c| <= |a - c| + ra for x in the one and |b - c| + rb in the other; c is
    /// the middle between the midpoints.
    pub fn hull(&self, other: &Self) -> Self {
        let center = (&self.center() + &other.center()).scale(-1).center();
        let reach = |end: &Self| (&end.center() - &center).abs_upper().add(end.radius);
        let radius = reach(self).max(reach(other));
        center.with_added_radius(radius)
    }

    /// The number times 2^exponent.
    pub fn scale(&self, exponent: i64) -> Self {
        Self::rounded(
            self.significand.clone(),
            self.exponent.saturating_add(exponent),
            self.bits,
            self.radius.scale(exponent),
        )
    }
}
