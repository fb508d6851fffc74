//! Exact rational numbers: what every literal of a model is, until floating point is asked for.
//!
//! A [`Number`] is a reduced fraction of any size. Fractions whose numerator and denominator fit
//! 64 bits are held inline and cost no allocation; larger ones live in a
//! [`dashu_ratio::RBig`]. The representation is canonical, so that equality and hashing are
//! those of the contents.
//!
//! This module never rounds silently (conversions to floating point say how far off they are)
//! and never panics: division, powers and parsing return `None` where there is no answer or
//! where it would have more than [`MAX_BITS`] bits.

mod convert;
mod roots;
use std::cmp::Ordering;
use std::hash::{Hash, Hasher};
use std::num::NonZeroU64;

use dashu_int::ops::{BitTest, ExtendedGcd, Gcd, UnsignedAbs};
use dashu_int::{IBig, UBig};
use dashu_ratio::RBig;

pub use convert::TwoDoubles;
pub use roots::Factor;

/// Size in bits up to which numbers are written out: about 30,000 decimal digits.
pub const MAX_BITS: usize = 100_000;

/// An exact rational number of any size.
///
/// # Examples
///
/// ```
/// use librate::number::Number;
/// let tenth = Number::parse("0.1").unwrap();
/// let sum = tenth.add(&Number::ratio(1, 5).unwrap());
/// assert_eq!(sum.to_string(), "3/10");
/// ```
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Number(Repr);

/// Canonical: `Small` exactly where it fits.
#[derive(Clone, PartialEq, Eq)]
enum Repr {
    /// A reduced fraction with `|numerator|` and denominator at most `i64::MAX`.
    Small(i64, NonZeroU64),
    /// A reduced fraction that does not fit.
    Big(Box<RBig>),
}

const LIMIT: u128 = i64::MAX as u128;
const UNIT: NonZeroU64 = NonZeroU64::MIN;

/// Greatest common divisor by Euclid's algorithm; gcd(0, b) = b.
pub fn gcd64(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

impl Number {
    /// The number 0.
    pub const ZERO: Number = Number(Repr::Small(0, UNIT));
    /// The number 1.
    pub const ONE: Number = Number(Repr::Small(1, UNIT));
    /// The number -1.
    pub const MINUS_ONE: Number = Number(Repr::Small(-1, UNIT));

    /// One half.
    #[must_use]
    pub fn half() -> Number {
        Number(Repr::Small(1, UNIT.saturating_add(1)))
    }

    /// A reduced fraction of small parts; `numerator` and `denominator` are coprime already, and the second is not 0.
    fn reduced(numerator: i128, denominator: u128) -> Number {
        if numerator.unsigned_abs() <= LIMIT
            && denominator <= LIMIT
            && let Some(denominator) = NonZeroU64::new(denominator as u64)
        {
            return Number(Repr::Small(numerator as i64, denominator));
        }
        Number(Repr::Big(Box::new(RBig::from_parts(IBig::from(numerator), UBig::from(denominator)))))
    }

    /// The canonical form of a big fraction.
    fn from_big(value: RBig) -> Number {
        if value.numerator().bit_len() <= 63
            && value.denominator().bit_len() <= 63
            && let Ok(numerator) = i64::try_from(value.numerator())
            && let Ok(denominator) = u64::try_from(value.denominator())
            && let Some(denominator) = NonZeroU64::new(denominator)
        {
            return Number(Repr::Small(numerator, denominator));
        }
        Number(Repr::Big(Box::new(value)))
    }

    /// The value as a big fraction.
    fn to_big(&self) -> RBig {
        match &self.0 {
            Repr::Small(numerator, denominator) => {
                RBig::from_parts(IBig::from(*numerator), UBig::from(denominator.get()))
            }
            Repr::Big(value) => (**value).clone(),
        }
    }

    /// A whole number of any size.
    #[must_use]
    pub fn from_integer(value: IBig) -> Number {
        Number::from_big(RBig::from(value))
    }

    /// The fraction `numerator / denominator`; `None` where the denominator is 0.
    #[must_use]
    pub fn from_parts(numerator: IBig, denominator: UBig) -> Option<Number> {
        (!denominator.is_zero()).then(|| Number::from_big(RBig::from_parts(numerator, denominator)))
    }

    /// The fraction `numerator / denominator`; `None` where the denominator is 0.
    #[must_use]
    pub fn ratio(numerator: i64, denominator: i64) -> Option<Number> {
        Number::from(numerator).div(&Number::from(denominator))
    }

    /// The numerator of the reduced fraction; it carries the sign.
    #[must_use]
    pub fn numerator(&self) -> IBig {
        match &self.0 {
            Repr::Small(numerator, _) => IBig::from(*numerator),
            Repr::Big(value) => value.numerator().clone(),
        }
    }

    /// The positive denominator of the reduced fraction.
    #[must_use]
    pub fn denominator(&self) -> UBig {
        match &self.0 {
            Repr::Small(_, denominator) => UBig::from(denominator.get()),
            Repr::Big(value) => value.denominator().clone(),
        }
    }

    /// Numerator and denominator where both fit 64 bits.
    #[must_use]
    pub fn small_parts(&self) -> Option<(i64, u64)> {
        match &self.0 {
            Repr::Small(numerator, denominator) => Some((*numerator, denominator.get())),
            Repr::Big(_) => None,
        }
    }

    /// Whether the number is 0.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        matches!(self.0, Repr::Small(0, _))
    }

    /// Whether the number is 1.
    #[must_use]
    pub fn is_one(&self) -> bool {
        matches!(self.0, Repr::Small(1, UNIT))
    }

    /// Whether the number is below 0.
    #[must_use]
    pub fn is_negative(&self) -> bool {
        match &self.0 {
            Repr::Small(numerator, _) => *numerator < 0,
            Repr::Big(value) => value.numerator().sign() == dashu_int::Sign::Negative,
        }
    }

    /// Whether the number is whole.
    #[must_use]
    pub fn is_integer(&self) -> bool {
        match &self.0 {
            Repr::Small(_, denominator) => *denominator == UNIT,
            Repr::Big(value) => value.is_int(),
        }
    }

    /// Whether the number is whole and divisible by 2.
    pub(crate) fn is_even(&self) -> bool {
        self.is_integer() && !self.numerator().bit(0)
    }

    /// The value as a machine integer, where it is one.
    #[must_use]
    pub fn to_i64(&self) -> Option<i64> {
        match &self.0 {
            Repr::Small(numerator, denominator) => (*denominator == UNIT).then_some(*numerator),
            // i64::MIN is the one machine integer that is not held inline.
            Repr::Big(value) if value.is_int() => i64::try_from(value.numerator()).ok(),
            Repr::Big(_) => None,
        }
    }

    /// The length in bits of the larger of numerator and denominator.
    pub(crate) fn bits(&self) -> usize {
        match &self.0 {
            Repr::Small(numerator, denominator) => {
                (64 - (numerator.unsigned_abs() | denominator.get()).leading_zeros()) as usize
            }
            Repr::Big(value) => value.numerator().bit_len().max(value.denominator().bit_len()),
        }
    }

    /// The memory that the number takes beside itself.
    pub(crate) fn bytes(&self) -> usize {
        match &self.0 {
            Repr::Small(..) => 0,
            Repr::Big(value) => {
                let bits = value.numerator().bit_len() + value.denominator().bit_len();
                size_of::<RBig>() + bits / 8
            }
        }
    }

    /// Whether the number has outgrown [`MAX_BITS`].
    pub(crate) fn is_oversized(&self) -> bool {
        self.bits() > MAX_BITS
    }

    /// The absolute value.
    #[must_use]
    pub fn abs(&self) -> Number {
        if self.is_negative() { self.neg() } else { self.clone() }
    }

    /// The opposite.
    #[must_use]
    pub fn neg(&self) -> Number {
        match &self.0 {
            Repr::Small(numerator, denominator) => Number(Repr::Small(-numerator, *denominator)),
            Repr::Big(value) => Number::from_big(-&**value),
        }
    }

    /// The reciprocal; `None` of 0.
    #[must_use]
    pub fn recip(&self) -> Option<Number> {
        match &self.0 {
            Repr::Small(0, _) => None,
            Repr::Small(numerator, denominator) => {
                let d = i128::from(denominator.get());
                let n = u128::from(numerator.unsigned_abs());
                Some(Number::reduced(if *numerator < 0 { -d } else { d }, n))
            }
            Repr::Big(value) => {
                let (numerator, denominator) = (**value).clone().into_parts();
                let (sign, magnitude) = numerator.into_parts();
                Number::from_parts(IBig::from_parts(sign, denominator), magnitude)
            }
        }
    }

    /// The sum. Knuth, TAOCP 2, 4.5.1: one gcd where the denominators are coprime.
    #[must_use]
    pub fn add(&self, other: &Number) -> Number {
        let (Repr::Small(a, b), Repr::Small(c, d)) = (&self.0, &other.0) else {
            return Number::from_big(self.to_big() + other.to_big());
        };
        let (a, c) = (i128::from(*a), i128::from(*c));
        let (b, d) = (b.get(), d.get());
        if b == 1 && d == 1 {
            return Number::reduced(a + c, 1);
        }
        // |a|, |c|, b, d < 2^63, so that every product is below 2^126 and the sum below 2^127.
        let g = gcd64(b, d);
        if g == 1 {
            let numerator = a * i128::from(d) + c * i128::from(b);
            return Number::reduced(numerator, u128::from(b) * u128::from(d));
        }
        let t = a * i128::from(d / g) + c * i128::from(b / g);
        let h = gcd64((t.unsigned_abs() % u128::from(g)) as u64, g);
        Number::reduced(t / i128::from(h), u128::from(b / g) * u128::from(d / h))
    }

    /// The difference.
    #[must_use]
    pub fn sub(&self, other: &Number) -> Number {
        self.add(&other.neg())
    }

    /// The product.
    #[must_use]
    pub fn mul(&self, other: &Number) -> Number {
        let (Repr::Small(a, b), Repr::Small(c, d)) = (&self.0, &other.0) else {
            return Number::from_big(self.to_big() * other.to_big());
        };
        let (b, d) = (b.get(), d.get());
        if b == 1 && d == 1 {
            return Number::reduced(i128::from(*a) * i128::from(*c), 1);
        }
        if *a == 0 || *c == 0 {
            return Number::ZERO;
        }
        let g = gcd64(a.unsigned_abs(), d);
        let h = gcd64(c.unsigned_abs(), b);
        let numerator = (i128::from(*a) / i128::from(g)) * (i128::from(*c) / i128::from(h));
        Number::reduced(numerator, u128::from(b / h) * u128::from(d / g))
    }

    /// The quotient; `None` where `other` is 0.
    #[must_use]
    pub fn div(&self, other: &Number) -> Option<Number> {
        Some(self.mul(&other.recip()?))
    }

    /// An integer power (x^0 is 1, of 0 too); `None` of a negative power of 0 and where the
    /// result would have more than [`MAX_BITS`] bits.
    #[must_use]
    pub fn powi(&self, exponent: i32) -> Option<Number> {
        match exponent {
            0 => return Some(Number::ONE),
            1 => return Some(self.clone()),
            2 if !self.is_oversized() => return Some(self.mul(self)),
            _ => {}
        }
        if self.is_zero() {
            return (exponent > 0).then_some(Number::ZERO);
        }
        let base = if exponent < 0 { self.recip()? } else { self.clone() };
        if base.is_integer() && base.abs().is_one() {
            return Some(if exponent % 2 == 0 { Number::ONE } else { base });
        }
        let exponent = exponent.unsigned_abs() as usize;
        if base.bits().saturating_mul(exponent) > MAX_BITS {
            return None;
        }
        let (numerator, denominator) = base.to_big().into_parts();
        Number::from_parts(numerator.pow(exponent), denominator.pow(exponent))
    }

    /// The largest whole number not above this one.
    #[must_use]
    pub fn floor(&self) -> Number {
        Number::from_integer(self.to_big().floor())
    }

    /// `self - divisor*floor(self/divisor)`, which has the divisor's sign; `None` where the
    /// divisor is 0.
    #[must_use]
    pub fn rem_floor(&self, divisor: &Number) -> Option<Number> {
        let quotient = self.div(divisor)?.floor();
        Some(self.sub(&divisor.mul(&quotient)))
    }

    /// The largest rational number of which both are whole multiples, positive;
    /// gcd(0, b) = |b|.
    #[must_use]
    pub fn gcd(&self, other: &Number) -> Number {
        if self.is_zero() {
            return other.abs();
        }
        if other.is_zero() {
            return self.abs();
        }
        // gcd(a/b, c/d) = gcd(a, c) / lcm(b, d), both in lowest terms.
        if let (Repr::Small(a, b), Repr::Small(c, d)) = (&self.0, &other.0) {
            let numerator = gcd64(a.unsigned_abs(), c.unsigned_abs());
            let lcm = u128::from(b.get() / gcd64(b.get(), d.get())) * u128::from(d.get());
            return Number::reduced(i128::from(numerator), lcm);
        }
        let (a, c) = (self.numerator().unsigned_abs(), other.numerator().unsigned_abs());
        let (b, d) = (self.denominator(), other.denominator());
        let lcm = &b / (&b).gcd(&d) * d;
        Number::from_parts(IBig::from(a.gcd(c)), lcm).unwrap_or(Number::ONE)
    }

    /// The residue modulo a prime; `None` where the prime divides the denominator (and for
    /// `p` = 0).
    #[must_use]
    pub fn mod_prime(&self, p: u64) -> Option<u64> {
        if p == 0 {
            return None;
        }
        let (numerator, denominator) = match &self.0 {
            Repr::Small(n, d) => (i128::from(*n).rem_euclid(i128::from(p)) as u64, d.get() % p),
            Repr::Big(value) => {
                let magnitude = value.numerator().unsigned_abs() % p;
                let n = if self.is_negative() && magnitude != 0 { p - magnitude } else { magnitude };
                (n, value.denominator() % p)
            }
        };
        if denominator == 1 % p {
            return Some(numerator);
        }
        let inverse = inverse_modulo(denominator, p)?;
        Some((u128::from(numerator) * u128::from(inverse) % u128::from(p)) as u64)
    }
}

/// The inverse of `a` modulo `p`; `None` where there is none.
pub(crate) fn inverse_modulo(a: u64, p: u64) -> Option<u64> {
    let (divisor, _, inverse) = p.gcd_ext(a % p);
    (divisor == 1).then(|| i128::from(inverse).rem_euclid(i128::from(p)) as u64)
}

impl From<i64> for Number {
    fn from(value: i64) -> Number {
        Number::reduced(i128::from(value), 1)
    }
}

impl Hash for Repr {
    fn hash<H: Hasher>(&self, state: &mut H) {
        // Two words for small fractions; no others hash so, as far as a hash can tell them apart.
        match self {
            Repr::Small(numerator, denominator) => {
                state.write_i64(*numerator);
                state.write_u64(denominator.get());
            }
            Repr::Big(value) => value.hash(state),
        }
    }
}

impl Default for Number {
    fn default() -> Number {
        Number::ZERO
    }
}

impl Ord for Number {
    fn cmp(&self, other: &Number) -> Ordering {
        match (&self.0, &other.0) {
            (Repr::Small(a, b), Repr::Small(c, d)) => {
                let left = i128::from(*a) * i128::from(d.get());
                left.cmp(&(i128::from(*c) * i128::from(b.get())))
            }
            (Repr::Big(a), Repr::Big(b)) => a.cmp(b),
            _ => self.to_big().cmp(&other.to_big()),
        }
    }
}

impl PartialOrd for Number {
    fn partial_cmp(&self, other: &Number) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
