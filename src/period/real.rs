//! What the quadrature asks of a number beside arithmetic: signs and bounds, in double-double or with any
//! number of bits.

use crate::linearize::Enclosure;
use crate::precision::{Ball, Big, Magnitude};

/// An enclosure with bounds that do not leave their range.
pub(super) trait Real: Enclosure {
    /// Whether the number is certainly positive.
    fn is_positive(&self) -> bool;
    /// Whether the number is certainly negative.
    fn is_negative(&self) -> bool;
    /// An upper bound of the absolute value.
    fn largest(&self) -> Magnitude;
    /// A lower bound of the absolute value; 0 where the number may be 0.
    fn least(&self) -> Magnitude;
    /// The radius.
    fn doubt(&self) -> Magnitude;
    /// The same with a radius larger by `error`.
    fn with_error(&self, error: Magnitude) -> Self;
    /// An enclosure of all that lies between the two.
    fn joined(&self, other: &Self) -> Self;
    /// A ball that contains the number.
    fn ball(&self) -> Ball;
    /// An enclosure of what a bigger number encloses.
    fn from_big(value: &Big, precision: Self::Precision) -> Self;
}

impl Real for Ball {
    fn is_positive(&self) -> bool {
        Ball::is_positive(self)
    }

    fn is_negative(&self) -> bool {
        Ball::is_negative(self)
    }

    fn largest(&self) -> Magnitude {
        Magnitude::from_f64(self.abs_upper())
    }

    fn least(&self) -> Magnitude {
        Magnitude::from_f64(self.abs_lower())
    }

    fn doubt(&self) -> Magnitude {
        Magnitude::from_f64(self.radius)
    }

    fn with_error(&self, error: Magnitude) -> Self {
        self.with_added_radius(error.to_f64())
    }

    fn joined(&self, other: &Self) -> Self {
        self.hull(other)
    }

    fn ball(&self) -> Ball {
        *self
    }

    fn from_big(value: &Big, (): ()) -> Self {
        value.to_ball()
    }
}

impl Real for Big {
    fn is_positive(&self) -> bool {
        Big::is_positive(self)
    }

    fn is_negative(&self) -> bool {
        Big::is_negative(self)
    }

    fn largest(&self) -> Magnitude {
        self.abs_upper()
    }

    fn least(&self) -> Magnitude {
        self.abs_lower()
    }

    fn doubt(&self) -> Magnitude {
        self.radius()
    }

    fn with_error(&self, error: Magnitude) -> Self {
        self.clone().with_added_radius(error)
    }

    fn joined(&self, other: &Self) -> Self {
        self.hull(other)
    }

    fn ball(&self) -> Ball {
        self.to_ball()
    }

    fn from_big(value: &Big, bits: usize) -> Self {
        value.clone().with_bits(bits)
    }
}
