//! What proofs of this stage ask of a number: enclosures, of whatever precision.

use crate::precision::{Ball, Big, Magnitude, Scalar};

/// Enclosures that zero modes and equilibria are proved in.
pub(crate) trait Enclosure: Scalar {
    /// A double near the number.
    fn middle(&self) -> f64;
    /// An upper bound of the distance between [`Enclosure::middle`] and the number.
    fn middle_error(&self) -> f64;
    /// About the size of the number, 0 if the number may be 0.
    fn certain_size(&self) -> f64;
    /// An upper bound of the size of the number.
    fn largest_size(&self) -> f64;
    /// The same with a radius larger by `error`, which is not negative.
    fn widened(&self, error: f64) -> Self;
    /// The middle of the enclosure, exactly.
    fn centre(&self) -> Self;
    /// A double, exactly.
    fn from_double(value: f64, precision: Self::Precision) -> Self;
    /// The same enclosure, or a little more, in numbers of so many bits.
    fn to_big(&self, bits: usize) -> Big;
}

impl Enclosure for Ball {
    fn middle(&self) -> f64 {
        self.mid_f64()
    }

    fn middle_error(&self) -> f64 {
        self.mid_f64_error()
    }

    fn certain_size(&self) -> f64 {
        self.abs_lower()
    }

    fn largest_size(&self) -> f64 {
        self.abs_upper()
    }

    fn widened(&self, error: f64) -> Self {
        self.with_added_radius(error)
    }

    fn centre(&self) -> Self {
        Self::new(self.mid, 0.0)
    }

    fn from_double(value: f64, (): ()) -> Self {
        Self::exact(value)
    }

    fn to_big(&self, bits: usize) -> Big {
        Big::from_ball(self, bits)
    }
}

impl Enclosure for Big {
    fn middle(&self) -> f64 {
        self.mid_f64()
    }

    fn middle_error(&self) -> f64 {
        // A double has 53 bits, and no number here has fewer: the difference is rounded outward.
        let rest = self - &Self::from_f64(self.mid_f64(), self.bits());
        rest.abs_upper().to_f64()
    }

    fn certain_size(&self) -> f64 {
        if self.contains_zero() {
            0.0
        } else {
            self.abs_upper().to_f64()
        }
    }

    fn largest_size(&self) -> f64 {
        self.abs_upper().to_f64()
    }

    fn widened(&self, error: f64) -> Self {
        self.clone().with_added_radius(Magnitude::from_f64(error))
    }

    fn centre(&self) -> Self {
        self.center()
    }

    fn from_double(value: f64, bits: usize) -> Self {
        Self::from_f64(value, bits)
    }

    fn to_big(&self, bits: usize) -> Big {
        self.clone().with_bits(bits)
    }
}
