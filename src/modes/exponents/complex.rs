//! Complex numbers in double-double and of any precision, as far as they are needed here.

use faer::c64;

use crate::precision::{Big, DoubleDouble};

/// A complex number in double-double.
///
/// Sums are off by at most 4 u² of the result in each part, so of its modulus. A part of a product is a sum
/// of two products off by 6 u² each: at most (6 + 4 (1 + 6 u²)) u² (|ac| + |bd|) <= 11 u² |z||w|, so that the
/// modulus is off by at most 16 u² |z||w|.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Complex {
    pub(super) re: DoubleDouble,
    pub(super) im: DoubleDouble,
}

impl Complex {
    pub(super) const ZERO: Self = Self { re: DoubleDouble::ZERO, im: DoubleDouble::ZERO };

    pub(super) fn from_c64(value: c64) -> Self {
        Self { re: DoubleDouble::exact(value.re), im: DoubleDouble::exact(value.im) }
    }

    /// The nearest pair of doubles: off by at most u of each part.
    pub(super) fn to_c64(self) -> c64 {
        c64::new(self.re.hi, self.im.hi)
    }

    /// What [`Complex::to_c64`] loses, from above.
    pub(super) fn low(self) -> f64 {
        self.re.lo.abs() + self.im.lo.abs()
    }

    pub(super) fn conj(self) -> Self {
        Self { re: self.re, im: -self.im }
    }

    pub(super) fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }

    pub(super) fn sub(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }

    pub(super) fn mul(self, other: Self) -> Self {
        Self { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }

    pub(super) fn is_finite(self) -> bool {
        self.re.is_finite() && self.im.is_finite()
    }

    /// The modulus, about.
    pub(super) fn size(self) -> f64 {
        self.re.hi.hypot(self.im.hi)
    }
}

/// A complex number of any precision, each part with its bound.
#[derive(Clone, Debug)]
pub(super) struct Wide {
    pub(super) re: Big,
    pub(super) im: Big,
}

impl Wide {
    pub(super) fn zero(bits: usize) -> Self {
        Self { re: Big::zero(bits), im: Big::zero(bits) }
    }

    /// Whether it is exactly 0.
    pub(super) fn is_zero(&self) -> bool {
        self.re.is_zero() && self.im.is_zero()
    }

    pub(super) fn from_complex(value: Complex, bits: usize) -> Self {
        Self { re: Big::from_double_double(value.re, bits), im: Big::from_double_double(value.im, bits) }
    }

    pub(super) fn from_c64(value: c64, bits: usize) -> Self {
        Self { re: Big::from_f64(value.re, bits), im: Big::from_f64(value.im, bits) }
    }

    pub(super) fn add(&self, other: &Self) -> Self {
        Self { re: &self.re + &other.re, im: &self.im + &other.im }
    }

    pub(super) fn sub(&self, other: &Self) -> Self {
        Self { re: &self.re - &other.re, im: &self.im - &other.im }
    }

    pub(super) fn mul(&self, other: &Self) -> Self {
        Self {
            re: &(&self.re * &other.re) - &(&self.im * &other.im),
            im: &(&self.re * &other.im) + &(&self.im * &other.re),
        }
    }

    pub(super) fn times(&self, other: &Big) -> Self {
        Self { re: &self.re * other, im: &self.im * other }
    }

    /// The quotient; not finite where the divisor may be 0.
    pub(super) fn div(&self, other: &Self) -> Self {
        let square = &(&other.re * &other.re) + &(&other.im * &other.im);
        let product = self.mul(&other.conj());
        Self { re: &product.re / &square, im: &product.im / &square }
    }

    pub(super) fn conj(&self) -> Self {
        Self { re: self.re.clone(), im: -&self.im }
    }

    /// Rounded to so many bits, and taken to be exactly that.
    pub(super) fn center(&self, bits: usize) -> Self {
        Self { re: self.re.center().with_bits(bits).center(), im: self.im.center().with_bits(bits).center() }
    }

    pub(super) fn with_bits(self, bits: usize) -> Self {
        Self { re: self.re.with_bits(bits), im: self.im.with_bits(bits) }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.re.is_finite() && self.im.is_finite()
    }

    /// The midpoint in doubles, off by at most 2^-51 of its modulus (each part is within a unit of its last
    /// place), and 2^-1070.
    pub(super) fn to_c64(&self) -> c64 {
        c64::new(self.re.mid_f64(), self.im.mid_f64())
    }

    /// The midpoint in double-double.
    pub(super) fn to_complex(&self) -> Complex {
        Complex { re: self.re.center().to_ball().mid, im: self.im.center().to_ball().mid }
    }

    /// An upper bound of the distance from the midpoint.
    pub(super) fn radius(&self) -> f64 {
        (self.re.radius() + self.im.radius()).to_f64()
    }

    /// An upper bound of the modulus.
    pub(super) fn abs_upper(&self) -> f64 {
        (self.re.abs_upper() + self.im.abs_upper()).to_f64()
    }
}
