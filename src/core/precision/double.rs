//! Double-double arithmetic: a number as the unevaluated sum of two doubles, about 31 digits.
//!
//! Error bounds are those of Joldes, Muller, Popescu, "Tight and rigorous error bounds for basic
//! building blocks of double-word arithmetic", ACM TOMS 44 (2017), with u = 2^-53; they hold as
//! long as nothing overflows or underflows. The error-free transformations are Knuth's and
//! Dekker's; the arrangement follows Hida, Li, Bailey, "Library for double-double and quad-double
//! arithmetic" (2007).

use std::ops::{Add, Div, Mul, Neg, Sub};

/// The exact sum a + b = s + e with s the rounded sum (Knuth, TAOCP 2, 4.2.2, theorem B); of doubles, or of lanes of them.
#[inline(always)]
pub fn two_sum<T: Copy + Add<Output = T> + Sub<Output = T>>(a: T, b: T) -> (T, T) {
    let s = a + b;
    let t = s - a;
    (s, (a - (s - t)) + (b - t))
}

/// The exact sum a + b = s + e where |a| >= |b| or a = 0 (Dekker, Numer. Math. 18 (1971)).
#[inline(always)]
pub fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    (s, b - (s - a))
}

/// The exact product a b = p + e with p the rounded product.
///
/// Exact for |a|, |b| < 2^990 and |a b| > 2^-960 (or a b = 0); below that e is off by at most
/// 2^-1070. Both ways of computing e give the same number, so results do not depend on the
/// machine. `f64::mul_add` without hardware support is a slow library call, hence the second way.
#[inline(always)]
pub fn two_prod(a: f64, b: f64) -> (f64, f64) {
    let p = a * b;
    #[cfg(any(target_feature = "fma", target_arch = "aarch64"))]
    {
        (p, a.mul_add(b, -p))
    }
    #[cfg(not(any(target_feature = "fma", target_arch = "aarch64")))]
    {
        (p, product_error(a, b, p))
    }
}

/// a b - p by splitting both factors in halves of 26 bits (Dekker 1971, Veltkamp).
#[inline(always)]
pub fn product_error(a: f64, b: f64, p: f64) -> f64 {
    let (ah, al) = split(a);
    let (bh, bl) = split(b);
    ((ah * bh - p) + ah * bl + al * bh) + al * bl
}

#[inline(always)]
fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a; // 2^27 + 1
    let high = c - (c - a);
    (high, a - high)
}

/// x 2^exponent, exact unless the result leaves the range of doubles.
#[inline]
pub(crate) fn scale(x: f64, exponent: i32) -> f64 {
    let mut x = x;
    let mut left = exponent;
    while left.unsigned_abs() > 1000 {
        let step = left.clamp(-1000, 1000);
        x *= power_of_two(step);
        left -= step;
        if x == 0.0 || !x.is_finite() {
            return x;
        }
    }
    x * power_of_two(left)
}

/// 2^exponent for -1074 <= exponent <= 1023.
#[inline(always)]
pub const fn power_of_two(exponent: i32) -> f64 {
    if exponent < -1022 {
        f64::from_bits(1 << (exponent + 1074))
    } else {
        f64::from_bits(((1023 + exponent) as u64) << 52)
    }
}

/// The exponent e with 2^e <= |x| < 2^(e+1); -1023 for zero and subnormal numbers.
#[inline(always)]
pub fn exponent_of(x: f64) -> i32 {
    ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023
}

/// The number `hi + lo`, where `hi` is that sum rounded to a double.
///
/// Comparison by `hi`, then `lo`, is comparison of the values.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default)]
pub struct DoubleDouble {
    /// The nearest double.
    pub hi: f64,
    /// What the nearest double leaves over.
    pub lo: f64,
}

impl DoubleDouble {
    /// Zero.
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0 };
    /// One.
    pub const ONE: Self = Self { hi: 1.0, lo: 0.0 };

    /// The sum of two doubles, exactly.
    #[inline]
    pub fn new(a: f64, b: f64) -> Self {
        let (hi, lo) = two_sum(a, b);
        Self { hi, lo }
    }

    /// A double, exactly.
    #[inline]
    pub const fn exact(value: f64) -> Self {
        Self { hi: value, lo: 0.0 }
    }

    /// Whether both parts are finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.hi.is_finite() && self.lo.is_finite()
    }

    /// Absolute value.
    #[inline]
    pub fn abs(self) -> Self {
        if self.hi < 0.0 || (self.hi == 0.0 && self.lo < 0.0) { -self } else { self }
    }

    /// x 2^exponent, exact unless the result leaves the range of doubles.
    #[inline]
    pub fn scale(self, exponent: i32) -> Self {
        Self { hi: scale(self.hi, exponent), lo: scale(self.lo, exponent) }
    }

    /// Square root, relative error at most 25/8 u^2 (Lefevre, Louvet, Muller, Picot, Rideau,
    /// "Accurate calculation of Euclidean norms using double-word arithmetic", ACM TOMS 49 (2023)).
    /// Not a number below zero.
    pub fn sqrt(self) -> Self {
        if self.hi == 0.0 {
            return Self::ZERO;
        }
        if self.hi < power_of_two(-480) || self.hi > power_of_two(480) {
            // Squares stay in range after an even shift.
            let shift = exponent_of(self.hi).max(-1000) & !1;
            let scaled = self.scale(-shift);
            if scaled.hi >= power_of_two(-480) && scaled.hi <= power_of_two(480) {
                return scaled.sqrt_in_range().scale(shift / 2);
            }
        }
        self.sqrt_in_range()
    }

    fn sqrt_in_range(self) -> Self {
        let s = self.hi.sqrt();
        let (p, e) = two_prod(s, s);
        let rest = ((self.hi - p) - e) + self.lo;
        let (hi, lo) = fast_two_sum(s, rest / (2.0 * s));
        Self { hi, lo }
    }
}

impl Neg for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    /// Relative error at most 3 u^2 / (1 - 4 u) (AccurateDWPlusDW, theorem 3.1).
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (sh, sl) = two_sum(self.hi, other.hi);
        let (th, tl) = two_sum(self.lo, other.lo);
        let (vh, vl) = fast_two_sum(sh, sl + th);
        let (hi, lo) = fast_two_sum(vh, tl + vl);
        Self { hi, lo }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + (-other)
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    /// Relative error at most 5 u^2 (DWTimesDW1; the constant is Muller and Rideau's,
    /// "Formalization of double-word arithmetic", ACM TOMS 48 (2022)).
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (p, e) = two_prod(self.hi, other.hi);
        let cross = self.hi * other.lo + self.lo * other.hi;
        let (hi, lo) = fast_two_sum(p, e + cross);
        Self { hi, lo }
    }
}

impl Div for DoubleDouble {
    type Output = Self;

    /// Relative error at most 15 u^2 + 56 u^3 (DWDivDW2, theorem 7.2).
    #[inline]
    fn div(self, other: Self) -> Self {
        let range = power_of_two(-480)..=power_of_two(480);
        if range.contains(&self.hi.abs()) && range.contains(&other.hi.abs()) {
            return divide_in_range(self, other);
        }
        if self.hi == 0.0 || !self.hi.is_finite() || !other.hi.is_finite() || other.hi == 0.0 {
            return Self::exact(self.hi / other.hi);
        }
        // Out of the way of under- and overflow; scaling by powers of two is exact. Subnormal
        // numbers need a second step, for the exponent does not tell their size.
        let up = |x: Self| {
            if exponent_of(x.hi) == -1023 { (x.scale(200), 200) } else { (x, 0) }
        };
        let (x, ux) = up(self);
        let (y, uy) = up(other);
        let (ex, ey) = (exponent_of(x.hi), exponent_of(y.hi));
        divide_in_range(x.scale(-ex), y.scale(-ey)).scale(ex - ux - (ey - uy))
    }
}

#[inline(always)]
fn divide_in_range(x: DoubleDouble, y: DoubleDouble) -> DoubleDouble {
    let t = x.hi / y.hi;
    // r = y t by DWTimesFP1 (theorem 4.1).
    let (ch, cl) = two_prod(y.hi, t);
    let (th, tl) = fast_two_sum(ch, y.lo * t);
    let (rh, rl) = fast_two_sum(th, tl + cl);
    let rest = (x.hi - rh) + (x.lo - rl);
    let (hi, lo) = fast_two_sum(t, rest / y.hi);
    DoubleDouble { hi, lo }
}
