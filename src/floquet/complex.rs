//! Complex numbers with bounds, of any precision.

use crate::precision::Enclosure;
use crate::precision::{Function, Magnitude};

/// A complex number with bounds.
#[derive(Clone, Debug)]
pub(super) struct Complex<S> {
    pub(super) re: S,
    pub(super) im: S,
}

impl<S: Enclosure> Complex<S> {
    pub(super) fn new(re: S, im: S) -> Self {
        Self { re, im }
    }

    pub(super) fn exact(re: f64, im: f64, precision: S::Precision) -> Self {
        Self::new(S::exact(re, precision), S::exact(im, precision))
    }

    pub(super) fn add(&self, other: &Self) -> Self {
        Self::new(self.re.add(&other.re), self.im.add(&other.im))
    }

    pub(super) fn sub(&self, other: &Self) -> Self {
        Self::new(self.re.sub(&other.re), self.im.sub(&other.im))
    }

    pub(super) fn mul(&self, other: &Self) -> Self {
        Self::new(
            self.re.mul(&other.re).sub(&self.im.mul(&other.im)),
            self.re.mul(&other.im).add(&self.im.mul(&other.re)),
        )
    }

    /// Times a real number.
    pub(super) fn times(&self, factor: &S) -> Self {
        Self::new(self.re.mul(factor), self.im.mul(factor))
    }

    pub(super) fn conj(&self) -> Self {
        Self::new(self.re.clone(), self.im.neg())
    }

    pub(super) fn square_of_modulus(&self) -> S {
        self.re.mul(&self.re).add(&self.im.mul(&self.im))
    }

    /// z̄/|z|².
    pub(super) fn inverse(&self) -> Self {
        let square = self.square_of_modulus();
        Self::new(self.re.div(&square), self.im.neg().div(&square))
    }

    /// Times 2^exponent.
    pub(super) fn doubled(&self, exponent: i64) -> Self {
        Self::new(self.re.doubled(exponent), self.im.doubled(exponent))
    }

    /// An upper bound of the modulus.
    pub(super) fn size(&self) -> Magnitude {
        hypot(self.re.size(), self.im.size())
    }

    /// An upper bound of the distance from the midpoint.
    pub(super) fn spread(&self) -> Magnitude {
        hypot(self.re.spread(), self.im.spread())
    }

    /// The midpoint, exactly.
    pub(super) fn center(&self) -> Self {
        Self::new(self.re.center(), self.im.center())
    }

    pub(super) fn is_finite(&self) -> bool {
        self.re.is_finite() && self.im.is_finite()
    }

    /// About a square root: of the midpoint, with midpoints.
    ///
    /// With r the modulus, its parts are sqrt((r ± re)/2); the larger one is taken so, the other from their product im/2.
    pub(super) fn root(&self, precision: S::Precision) -> Self {
        let zero = S::exact(0.0, precision);
        let modulus = self.square_of_modulus().center().sqrt().center();
        if !modulus.is_positive() {
            return Self::new(zero.clone(), zero);
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
pub(super) fn hypot(x: Magnitude, y: Magnitude) -> Magnitude {
    (x * x + y * y).sqrt()
}
