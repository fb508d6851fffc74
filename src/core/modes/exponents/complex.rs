//! Complex numbers in double-double and of any precision, with bounds of their parts.

use faer::c64;

use crate::precision::{self, Ball, Big, Enclosure};

/// A complex number in double-double.
pub(super) type Complex = precision::Complex<Ball>;

/// A complex number of any precision.
pub(super) type Wide = precision::Complex<Big>;

/// Both parts rounded, and the imaginary one left out where the number is known to be real.
pub(super) fn rounded<S: Enclosure>(
    z: &precision::Complex<S>,
    real: bool,
    precision: S::Precision,
) -> precision::Complex<S> {
    let im = if real { S::exact(0.0, precision) } else { z.im.rounded(precision) };
    precision::Complex::new(z.re.rounded(precision), im)
}

/// A pair of doubles, without the imaginary one where the number is known to be real.
pub(super) fn part(z: c64, real: bool) -> c64 {
    if real { c64::new(z.re, 0.0) } else { z }
}

/// The largest modulus of a component.
pub(super) fn largest(vector: &[c64]) -> f64 {
    vector.iter().map(|x| x.norm()).fold(0.0, f64::max)
}

impl Complex {
    /// The modulus, about.
    pub(super) fn modulus(&self) -> f64 {
        self.re.mid.hi.hypot(self.im.mid.hi)
    }
}

impl Wide {
    pub(super) fn from_complex(value: &Complex, bits: usize) -> Self {
        Self::new(Big::from_ball(&value.re, bits), Big::from_ball(&value.im, bits))
    }

    /// The midpoint in double-double.
    pub(super) fn to_complex(&self) -> Complex {
        let part = |x: &Big| x.center().to_ball().center();
        Complex::new(part(&self.re), part(&self.im))
    }
}
