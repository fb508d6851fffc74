//! Roots of exact numbers: perfect powers and the factors that come out of a root.

use dashu_int::UBig;
use dashu_int::ops::{BitTest, SquareRoot, UnsignedAbs};

use super::Number;

/// Primes below which factors are found by trial division.
const TRIAL_LIMIT: u64 = 1000;
/// Size in bits beyond which perfect powers are searched for only among small roots.
const POWER_CHECK_BITS: usize = 1 << 14;

/// A factor of a positive whole number and how often it divides it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Factor {
    /// A prime, or what trial division left over (whole, above 1, no perfect power).
    pub base: Number,
    /// The multiplicity, positive.
    pub multiplicity: u32,
}

impl Number {
    /// The exact square root, where it is rational.
    #[must_use]
    pub fn sqrt_exact(&self) -> Option<Number> {
        self.root_exact(2)
    }

    /// The exact root of this order of a number that is not negative, where it is rational.
    pub(crate) fn root_exact(&self, order: u32) -> Option<Number> {
        if self.is_negative() || order == 0 {
            return None;
        }
        let order = usize::try_from(order).ok()?;
        let root = |n: &UBig| {
            let r = if order == 2 { n.sqrt() } else { n.nth_root(order) };
            (r.pow(order) == *n).then_some(r)
        };
        let numerator = root(&self.numerator().unsigned_abs())?;
        Number::from_parts(numerator.into(), root(&self.denominator())?)
    }

    /// The factors of a positive whole number in ascending order: primes below 1000, then what
    /// is left, written as a power where it is one. Empty for 1 and for what is not a positive
    /// whole number.
    #[must_use]
    pub fn factors(&self) -> Vec<Factor> {
        let mut factors = Vec::new();
        if !self.is_integer() || self.is_negative() || self.is_zero() {
            return factors;
        }
        let mut push = |base: UBig, multiplicity| {
            factors.push(Factor { base: Number::from_integer(base.into()), multiplicity });
        };
        let mut rest = self.numerator().unsigned_abs();
        for p in trial_divisors() {
            if rest < UBig::from(p * p) {
                // A prime, or 1.
                break;
            }
            let divisor = UBig::from(p);
            if let Some(multiplicity) = rest.remove(&divisor)
                && multiplicity > 0
            {
                push(divisor, u32::try_from(multiplicity).unwrap_or(u32::MAX));
            }
        }
        if !rest.is_one() {
            let (base, multiplicity) = as_power(rest);
            push(base, multiplicity);
        }
        factors
    }
}

/// 2, 3, 5 and the numbers coprime to 30 up to the limit; composites among them divide nothing.
fn trial_divisors() -> impl Iterator<Item = u64> {
    const WHEEL: [u64; 8] = [1, 7, 11, 13, 17, 19, 23, 29];
    let wheel = (0..TRIAL_LIMIT.div_ceil(30)).flat_map(|k| WHEEL.map(|w| 30 * k + w));
    [2, 3, 5].into_iter().chain(wheel.skip(1)).take_while(|p| *p < TRIAL_LIMIT)
}

/// What trial division left as a power: it is a prime, or has no prime factor below 1000, so that a k-th power has k at most
/// bits / log2(1000).
fn as_power(mut rest: UBig) -> (UBig, u32) {
    const PRIMES: [usize; 18] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61];
    let mut multiplicity = 1;
    for k in PRIMES {
        if rest.bit_len() > POWER_CHECK_BITS && k > 3 {
            break;
        }
        while rest.bit_len() > 9 * k {
            let root = rest.nth_root(k);
            if root.pow(k) != rest {
                break;
            }
            rest = root;
            multiplicity *= k as u32;
        }
    }
    (rest, multiplicity)
}
