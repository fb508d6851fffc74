//! The operations on numbers of any precision, each with the inequality that its radius stands on.

use std::ops::{Add, Div, Mul, Neg, Sub};

use dashu_int::ops::{BitTest, DivRem, SquareRootRem, UnsignedAbs};
use dashu_int::{IBig, Sign, UBig};

use super::super::magnitude::Magnitude;
use super::super::scalar::power;
use super::Big;
use super::sum::{Sum, WORD, words};

/// Bits that a quotient or root has beyond those asked for before it is rounded.
const EXTRA: usize = 8;

impl Big {
    /// Square root. A number that may be 0 gives [0, sqrt(upper)]; one below 0 is not finite.
    ///
    /// |sqrt(m + h) - sqrt(m)| = |h| / (sqrt(m + h) + sqrt(m)) for |h| <= r, largest at h = -r.
    pub fn sqrt(&self) -> Self {
        if !self.is_finite() || self.is_negative() {
            return Self::not_finite(self.bits);
        }
        if self.is_zero() {
            return self.clone();
        }
        if !self.is_positive() {
            return Self::from_zero_to(self.abs_upper().sqrt(), self.bits);
        }
        // floor(sqrt(s 4^k)) / 2^k with an even exponent left: off by less than one unit.
        let wanted = 2 * (self.bits + EXTRA);
        let mut shift = wanted.saturating_sub(self.significand.bit_len());
        if (self.exponent - shift as i64).rem_euclid(2) == 1 {
            shift += 1;
        }
        let square = self.significand.clone().unsigned_abs() << shift;
        let (root, rest) = square.sqrt_rem();
        let exponent = (self.exponent - shift as i64).div_euclid(2);
        let mut radius = if rest.is_zero() { Magnitude::ZERO } else { Magnitude::power_of_two(exponent) };
        if !self.is_exact() {
            let (at, least) = (self.mid_lower(), self.abs_lower());
            let sum = at.sqrt_down().add_down(least.sqrt_down());
            radius = radius.add(self.radius.div(sum));
        }
        Self::rounded(IBig::from(root), exponent, self.bits, radius)
    }

    /// Integer power by repeated squaring, negative exponents included.
    pub fn powi(&self, exponent: i32) -> Self {
        let power = power(self, exponent.unsigned_abs(), |x, y| x * y).unwrap_or_else(|| Self::one(self.bits));
        if exponent < 0 { &Self::one(self.bits) / &power } else { power }
    }
}

/// numerator / denominator 2^exponent with `bits` bits; `radius` is added.
///
/// The quotient of the integers is rounded towards 0: off by less than one unit, and by nothing
/// where the division leaves no rest.
pub(super) fn quotient(numerator: IBig, denominator: &UBig, exponent: i64, bits: usize, radius: Magnitude) -> Big {
    let wanted = (bits + EXTRA + denominator.bit_len()).saturating_sub(numerator.bit_len());
    let (sign, magnitude) = numerator.into_parts();
    let (digits, rest) = (magnitude << wanted).div_rem(denominator);
    let exponent = exponent.saturating_sub(wanted as i64);
    let radius = if rest.is_zero() { radius } else { radius.add(Magnitude::power_of_two(exponent)) };
    Big::rounded(IBig::from_parts(sign, digits), exponent, bits, radius)
}

/// Bits of a sum of products beyond those that are kept.
const GUARD: i64 = 32;

/// Σ left_j right_(n-1-j), rounded once. `None` for n = 0.
///
/// Products are whole numbers times powers of two, which are added up exactly; those that are less than a unit 2^e in all are left
/// out and enter the radius, where e lies `GUARD` bits below the last place of the largest product. The errors of the factors enter as
/// in a product: |a| rb + |b| ra + ra rb for each.
pub(super) fn convolution(left: &[Big], right: &[Big]) -> Option<Big> {
    let pairs = || left.iter().zip(right.iter().rev());
    let bits = pairs().map(|(x, y)| x.bits.max(y.bits)).max()?;
    let mut radius = Magnitude::ZERO;
    let mut top = i64::MIN;
    let mut longest = 0;
    for (x, y) in pairs() {
        let (ra, rb) = (x.radius, y.radius);
        if !rb.is_zero() {
            radius = radius.add(x.mid_upper().add(ra).mul(rb));
        }
        if !ra.is_zero() {
            radius = radius.add(y.mid_upper().mul(ra));
        }
        if !x.is_mid_zero() && !y.is_mid_zero() {
            top = top.max(x.top() + y.top());
            longest = longest.max(words(&x.significand) + words(&y.significand));
        }
    }
    let unit = top.saturating_sub(bits as i64 + GUARD);
    // No product that reaches the unit has a bit below this.
    let least = unit.saturating_sub((longest * WORD) as i64);
    let mut sum = Sum::default();
    sum.clear(longest + (bits + GUARD as usize).div_ceil(WORD) + 1);
    for (x, y) in pairs() {
        if x.is_mid_zero() || y.is_mid_zero() {
            continue;
        }
        if x.top() + y.top() < unit {
            radius = radius.add(Magnitude::power_of_two(unit));
        } else {
            sum.add_product(&x.significand, &y.significand, (x.exponent + y.exponent - least) as usize);
        }
    }
    Some(Big::rounded(sum.value(), least, bits, radius))
}

impl Neg for &Big {
    type Output = Big;

    fn neg(self) -> Big {
        Big { significand: -&self.significand, ..self.clone() }
    }
}

impl Add for &Big {
    type Output = Big;

    /// |(x + y) - (a + b)| <= ra + rb. A summand that is smaller than the last place by far is left
    /// out and its size added to the radius.
    fn add(self, other: &Big) -> Big {
        let bits = self.bits.max(other.bits);
        let radius = self.radius.add(other.radius);
        let (large, small) = if self.top() >= other.top() { (self, other) } else { (other, self) };
        if large.top() - small.top() > bits as i64 + 64 && large.exponent > small.top() {
            let radius = radius.add(small.mid_upper());
            return Big::rounded(large.significand.clone(), large.exponent, bits, radius);
        }
        let exponent = self.exponent.min(other.exponent);
        let aligned = |x: &Big| -> Option<usize> {
            let shift = usize::try_from(x.exponent - exponent).ok()?;
            (shift > 0).then_some(shift)
        };
        let sum = match (aligned(self), aligned(other)) {
            (None, None) => &self.significand + &other.significand,
            (Some(shift), _) => (&self.significand << shift) + &other.significand,
            (None, Some(shift)) => &self.significand + (&other.significand << shift),
        };
        Big::rounded(sum, exponent, bits, radius)
    }
}

impl Sub for &Big {
    type Output = Big;

    fn sub(self, other: &Big) -> Big {
        self + &(-other)
    }
}

impl Mul for &Big {
    type Output = Big;

    /// x y - a b = a (y - b) + b (x - a) + (x - a)(y - b), so the error is at most
    /// |a| rb + |b| ra + ra rb.
    fn mul(self, other: &Big) -> Big {
        let bits = self.bits.max(other.bits);
        let (ra, rb) = (self.radius, other.radius);
        let mut radius = Magnitude::ZERO;
        if !rb.is_zero() {
            radius = self.mid_upper().add(ra).mul(rb);
        }
        if !ra.is_zero() {
            radius = radius.add(other.mid_upper().mul(ra));
        }
        Big::rounded(&self.significand * &other.significand, self.exponent + other.exponent, bits, radius)
    }
}

impl Div for &Big {
    type Output = Big;

    /// With q = a / b: x / y - q = ((x - a) - q (y - b)) / y, so the error is at most
    /// (ra + |q| rb) / (|b| - rb). Not finite if the divisor may be 0.
    fn div(self, other: &Big) -> Big {
        let bits = self.bits.max(other.bits);
        let least = other.abs_lower();
        if least.is_zero() {
            return Big::not_finite(bits);
        }
        let mut radius = self.radius;
        if !other.is_exact() {
            let q = self.mid_upper().div(other.mid_lower());
            radius = radius.add(q.mul(other.radius));
        }
        if !radius.is_zero() {
            radius = radius.div(least);
        }
        let (sign, divisor) = other.significand.clone().into_parts();
        let numerator = match sign {
            Sign::Positive => self.significand.clone(),
            Sign::Negative => -&self.significand,
        };
        quotient(numerator, &divisor, self.exponent - other.exponent, bits, radius)
    }
}
