//! Complex numbers over any real ones.

use faer::c64;

use super::{Enclosure, Function, Magnitude, Scalar};

/// A complex number; over enclosures, with bounds of its parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Complex<S> {
    /// The real part.
    pub re: S,
    /// The imaginary part.
    pub im: S,
}

impl<S: Scalar> Complex<S> {
    /// Of its parts.
    #[inline]
    pub fn new(re: S, im: S) -> Self {
        Self { re, im }
    }

    /// The sum.
    #[inline]
    pub fn add(&self, other: &Self) -> Self {
        Self::new(self.re.add(&other.re), self.im.add(&other.im))
    }

    /// The difference.
    #[inline]
    pub fn sub(&self, other: &Self) -> Self {
        Self::new(self.re.sub(&other.re), self.im.sub(&other.im))
    }

    /// The product.
    #[inline]
    pub fn mul(&self, other: &Self) -> Self {
        Self::new(
            self.re.mul(&other.re).sub(&self.im.mul(&other.im)),
            self.re.mul(&other.im).add(&self.im.mul(&other.re)),
        )
    }

    /// Times a real number.
    pub fn times(&self, factor: &S) -> Self {
        Self::new(self.re.mul(factor), self.im.mul(factor))
    }

    /// The quotient; not finite where an enclosure of the divisor contains 0.
    pub fn div(&self, other: &Self) -> Self {
        let square = other.square_of_modulus();
        let product = self.mul(&other.conjugate());
        Self::new(product.re.div(&square), product.im.div(&square))
    }

    /// z̄.
    pub fn conjugate(&self) -> Self {
        Self::new(self.re.clone(), self.im.neg())
    }

    /// |z|².
    pub fn square_of_modulus(&self) -> S {
        self.re.mul(&self.re).add(&self.im.mul(&self.im))
    }

    /// z̄/|z|².
    pub fn inverse(&self) -> Self {
        let square = self.square_of_modulus();
        Self::new(self.re.div(&square), self.im.neg().div(&square))
    }

    /// Whether it is exactly 0.
    pub fn is_zero(&self) -> bool {
        self.re.is_exact_zero() && self.im.is_exact_zero()
    }

    /// Whether both parts are.
    pub fn is_finite(&self) -> bool {
        self.re.is_finite() && self.im.is_finite()
    }
}

impl<S: Enclosure> Complex<S> {
    /// 0.
    pub fn zero(precision: S::Precision) -> Self {
        Self::real(0.0, precision)
    }

    /// A real number, exactly.
    pub fn real(value: f64, precision: S::Precision) -> Self {
        Self::from_c64(c64::new(value, 0.0), precision)
    }

    /// A pair of doubles, exactly.
    pub fn from_c64(value: c64, precision: S::Precision) -> Self {
        Self::new(S::exact(value.re, precision), S::exact(value.im, precision))
    }

    /// The midpoint in doubles, off by at most 2^-51 of its modulus (each part is within a unit of its last
    /// place), and 2^-1070.
    pub fn to_c64(&self) -> c64 {
        c64::new(self.re.mid_f64(), self.im.mid_f64())
    }

    /// Times 2^exponent.
    pub fn scale(&self, exponent: i64) -> Self {
        Self::new(self.re.times_power_of_two(exponent), self.im.times_power_of_two(exponent))
    }

    /// An upper bound of the modulus.
    pub fn upper_bound(&self) -> Magnitude {
        hypot(self.re.abs_upper_magnitude(), self.im.abs_upper_magnitude())
    }

    /// An upper bound of the distance from the midpoint.
    pub fn radius(&self) -> Magnitude {
        hypot(self.re.radius_magnitude(), self.im.radius_magnitude())
    }

    /// With radii of the parts larger by so much.
    pub fn with_added_radius(&self, radius: Magnitude) -> Self {
        Self::new(self.re.with_added_magnitude(radius), self.im.with_added_magnitude(radius))
    }

    /// The midpoint, exactly.
    pub fn center(&self) -> Self {
        Self::new(self.re.center(), self.im.center())
    }

    /// Whether it may be 0.
    pub fn contains_zero(&self) -> bool {
        let possible = |x: &S| !(x.is_positive() || x.is_negative());
        possible(&self.re) && possible(&self.im)
    }

    /// An enclosure of all that lies between the two.
    pub fn hull(&self, other: &Self) -> Self {
        Self::new(self.re.hull(&other.re), self.im.hull(&other.im))
    }

    /// About a square root: of the midpoint, with midpoints.
    ///
    /// With r the modulus, its parts are sqrt((r ± re)/2); the larger one is taken so, the other from their product im/2.
    pub fn root(&self, precision: S::Precision) -> Self {
        let modulus = self.square_of_modulus().center().sqrt().center();
        if !modulus.is_positive() {
            return Self::zero(precision);
        }
        let half = S::exact(0.5, precision);
        let large = self.re.apply(Function::Abs).add(&modulus).mul(&half);
        let large = large.center().sqrt().center();
        let small = self.im.mul(&half).div(&large).center();
        if self.re.neg().is_positive() {
            // The imaginary part is the larger one.
            if small.neg().is_positive() { Self::new(small.neg(), large.neg()) } else { Self::new(small, large) }
        } else {
            Self::new(large, small)
        }
    }
}

/// An upper bound of sqrt(x² + y²).
pub fn hypot(x: Magnitude, y: Magnitude) -> Magnitude {
    (x * x + y * y).sqrt()
}
