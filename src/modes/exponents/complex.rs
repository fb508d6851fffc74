//! Complex numbers in double-double and of any precision.

use faer::c64;

use crate::precision::{self, Big, DoubleDouble};

/// A complex number in double-double.
///
/// Sums are off by at most 4 u² of the result in each part, so of its modulus. A part of a product is a sum
/// of two products off by 6 u² each: at most (6 + 4 (1 + 6 u²)) u² (|ac| + |bd|) <= 11 u² |z||w|, so that the
/// modulus is off by at most 16 u² |z||w|.
pub(super) type Complex = precision::Complex<DoubleDouble>;

impl Complex {
    pub(super) const ZERO: Self = Self { re: DoubleDouble::ZERO, im: DoubleDouble::ZERO };

    pub(super) fn from_c64(value: c64) -> Self {
        Self::new(value.re.into(), value.im.into())
    }

    /// The nearest pair of doubles: off by at most u of each part.
    pub(super) fn to_c64(&self) -> c64 {
        c64::new(self.re.hi, self.im.hi)
    }

    /// What [`Complex::to_c64`] loses, from above.
    pub(super) fn low(&self) -> f64 {
        self.re.lo.abs() + self.im.lo.abs()
    }

    /// The modulus, about.
    pub(super) fn modulus(&self) -> f64 {
        self.re.hi.hypot(self.im.hi)
    }
}

/// A complex number of any precision, each part with its bound.
pub(super) type Wide = precision::Complex<Big>;

impl Wide {
    pub(super) fn from_complex(value: &Complex, bits: usize) -> Self {
        Self::new(Big::from_double_double(value.re, bits), Big::from_double_double(value.im, bits))
    }

    /// The midpoint in double-double.
    pub(super) fn to_complex(&self) -> Complex {
        let part = |x: &Big| x.center().to_ball().mid;
        Complex::new(part(&self.re), part(&self.im))
    }

    /// Rounded to so many bits, and taken to be exactly that.
    pub(super) fn rounded(&self, bits: usize) -> Self {
        let part = |x: &Big| x.center().with_bits(bits).center();
        Self::new(part(&self.re), part(&self.im))
    }
}
