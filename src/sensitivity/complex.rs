//! Complex numbers whose parts are enclosures, as far as they are needed here.

use nalgebra::Complex;

use crate::precision::{Ball, up};

/// Real and imaginary part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Enclosed {
    pub(super) re: Ball,
    pub(super) im: Ball,
}

impl Enclosed {
    pub(super) const ZERO: Self = Self { re: Ball::ZERO, im: Ball::ZERO };

    pub(super) fn exact(value: Complex<f64>) -> Self {
        Self { re: Ball::from(value.re), im: Ball::from(value.im) }
    }

    pub(super) fn middle(&self) -> Complex<f64> {
        Complex::new(self.re.mid_f64(), self.im.mid_f64())
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

    pub(super) fn times(self, factor: Ball) -> Self {
        Self { re: self.re * factor, im: self.im * factor }
    }

    /// The quotient; not finite where the divisor may be 0.
    pub(super) fn div(self, other: Self) -> Self {
        let square = other.re * other.re + other.im * other.im;
        let product = self.mul(other.conj());
        Self { re: product.re / square, im: product.im / square }
    }

    pub(super) fn scale(self, exponent: i32) -> Self {
        Self { re: self.re.scale(exponent), im: self.im.scale(exponent) }
    }

    pub(super) fn contains_zero(&self) -> bool {
        self.re.contains_zero() && self.im.contains_zero()
    }

    pub(super) fn is_zero(&self) -> bool {
        self.re.is_zero() && self.im.is_zero()
    }

    pub(super) fn is_finite(&self) -> bool {
        self.re.is_finite() && self.im.is_finite()
    }

    /// An upper bound of the modulus.
    pub(super) fn size(&self) -> f64 {
        up(self.re.abs_upper().hypot(self.im.abs_upper()))
    }

    pub(super) fn hull(&self, other: &Self) -> Self {
        Self { re: self.re.hull(&other.re), im: self.im.hull(&other.im) }
    }

    pub(super) fn with_added_radius(&self, radius: f64) -> Self {
        Self { re: self.re.with_added_radius(radius), im: self.im.with_added_radius(radius) }
    }
}

/// Rows and columns of small matrices: `a[i][j]`.
pub(super) type Rows<T> = Vec<Vec<T>>;
