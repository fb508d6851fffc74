//! What proofs ask of a number: enclosures in double-double or with any number of bits.

use super::scalar::own_methods;
use super::{Ball, Big, Magnitude, Scalar};

/// A number known to lie within a radius of a midpoint.
pub trait Enclosure: Scalar {
    /// A double, exactly.
    fn exact(value: f64, precision: Self::Precision) -> Self;
    /// The midpoint, exactly.
    fn center(&self) -> Self;
    /// The midpoint, rounded to the precision and taken to be exactly that.
    fn rounded(&self, precision: Self::Precision) -> Self;
    /// A double near the midpoint.
    fn mid_f64(&self) -> f64;
    /// An upper bound of the distance between [`Enclosure::mid_f64`] and the number.
    fn mid_f64_error(&self) -> f64;
    /// An upper bound of the distance from the midpoint; infinite where the number is none.
    fn radius(&self) -> f64 {
        self.radius_magnitude().to_f64()
    }
    /// An upper bound of the absolute value; infinite where the number is none.
    fn abs_upper(&self) -> f64 {
        self.abs_upper_magnitude().to_f64()
    }
    /// About the absolute value, 0 where the number may be 0.
    fn certain_size(&self) -> f64;
    /// With a radius larger by so much, which is not negative.
    fn with_added_radius(&self, by: f64) -> Self {
        self.with_added_magnitude(Magnitude::from_f64(by))
    }
    /// An upper bound of the absolute value, with an exponent of its own.
    fn abs_upper_magnitude(&self) -> Magnitude;
    /// A lower bound of the absolute value, with an exponent of its own; 0 where the number may be 0.
    fn abs_lower_magnitude(&self) -> Magnitude;
    /// An upper bound of the distance from the midpoint, with an exponent of its own.
    fn radius_magnitude(&self) -> Magnitude;
    /// With a radius larger by so much.
    fn with_added_magnitude(&self, by: Magnitude) -> Self;
    /// A number not below a size.
    fn from_magnitude(size: Magnitude, precision: Self::Precision) -> Self;
    /// Times 2^exponent.
    fn times_power_of_two(&self, exponent: i64) -> Self;
    /// Whether the number is certainly positive.
    fn is_positive(&self) -> bool;
    /// Whether the number is certainly negative.
    fn is_negative(&self) -> bool;
    /// Whether the number is zero, exactly.
    fn is_zero(&self) -> bool {
        self.is_exact_zero()
    }
    /// An enclosure of all that lies between the two.
    fn hull(&self, other: &Self) -> Self;
    /// As a ball in double-double.
    fn to_ball(&self) -> Ball;
    /// With the bits given.
    fn to_big(&self, bits: usize) -> Big;
    /// Not rounded: a ball with the bits given, a bigger number with those that it has.
    fn unrounded(&self, bits: usize) -> Big {
        self.clone().precise().unwrap_or_else(|| self.to_big(bits))
    }
    /// The number itself where it has more bits or a wider range than a ball.
    fn precise(self) -> Option<Big>;
    /// What a bigger number encloses.
    fn from_big(value: &Big, precision: Self::Precision) -> Self;
    /// What a ball holds.
    fn from_ball(value: &Ball, precision: Self::Precision) -> Self;
    /// About the relative error of one operation.
    fn rounding(precision: Self::Precision) -> f64;
}

impl Enclosure for Ball {
    fn exact(value: f64, (): ()) -> Self {
        Ball::exact(value)
    }

    fn center(&self) -> Self {
        if self.is_finite() { Ball::new(self.mid, 0.0) } else { *self }
    }

    fn rounded(&self, (): ()) -> Self {
        Enclosure::center(self)
    }

    own_methods! { Ball:
        mid_f64() -> f64;
        mid_f64_error() -> f64;
        abs_upper() -> f64;
        with_added_radius(by: f64) -> Self;
        is_positive() -> bool;
        is_negative() -> bool;
        hull(other: &Self) -> Self;
    }

    fn certain_size(&self) -> f64 {
        self.abs_lower()
    }

    fn radius(&self) -> f64 {
        if self.is_finite() { self.radius } else { f64::INFINITY }
    }

    fn abs_upper_magnitude(&self) -> Magnitude {
        Magnitude::from_f64(Enclosure::abs_upper(self))
    }

    fn abs_lower_magnitude(&self) -> Magnitude {
        Magnitude::from_f64(self.abs_lower())
    }

    fn radius_magnitude(&self) -> Magnitude {
        Magnitude::from_f64(Enclosure::radius(self))
    }

    fn with_added_magnitude(&self, by: Magnitude) -> Self {
        self.with_added_radius(by.to_f64())
    }

    fn from_magnitude(size: Magnitude, (): ()) -> Self {
        Ball::exact(size.to_f64())
    }

    fn times_power_of_two(&self, exponent: i64) -> Self {
        self.scale(exponent.clamp(-4000, 4000) as i32)
    }

    fn to_ball(&self) -> Ball {
        *self
    }

    fn to_big(&self, bits: usize) -> Big {
        Big::from_ball(self, bits)
    }

    fn precise(self) -> Option<Big> {
        None
    }

    fn from_big(value: &Big, (): ()) -> Self {
        value.to_ball()
    }

    fn from_ball(value: &Ball, (): ()) -> Self {
        *value
    }

    fn rounding((): ()) -> f64 {
        super::U2
    }
}

impl Enclosure for Big {
    fn exact(value: f64, bits: usize) -> Self {
        Big::from_f64(value, bits)
    }

    fn rounded(&self, bits: usize) -> Self {
        Big::center(&Big::center(self).with_bits(bits))
    }

    own_methods! { Big:
        center() -> Self;
        mid_f64() -> f64;
        is_positive() -> bool;
        is_negative() -> bool;
        hull(other: &Self) -> Self;
        to_ball() -> Ball;
    }

    fn mid_f64_error(&self) -> f64 {
        // A double has 53 bits, and no number here has fewer: the difference is rounded outward.
        let rest = self - &Self::from_f64(self.mid_f64(), self.bits());
        Big::abs_upper(&rest).to_f64()
    }

    fn certain_size(&self) -> f64 {
        if self.contains_zero() { 0.0 } else { Big::abs_upper(self).to_f64() }
    }

    fn abs_upper_magnitude(&self) -> Magnitude {
        Big::abs_upper(self)
    }

    fn abs_lower_magnitude(&self) -> Magnitude {
        self.abs_lower()
    }

    fn radius_magnitude(&self) -> Magnitude {
        Big::radius(self)
    }

    fn with_added_magnitude(&self, by: Magnitude) -> Self {
        self.clone().with_added_radius(by)
    }

    fn from_magnitude(size: Magnitude, bits: usize) -> Self {
        // All 53 bits of a size fit.
        Big::from_magnitude(size, bits.max(64))
    }

    fn times_power_of_two(&self, exponent: i64) -> Self {
        self.scale(exponent)
    }

    fn to_big(&self, bits: usize) -> Big {
        self.clone().with_bits(bits)
    }

    fn precise(self) -> Option<Big> {
        Some(self)
    }

    fn from_big(value: &Big, bits: usize) -> Self {
        value.to_big(bits)
    }

    fn from_ball(value: &Ball, bits: usize) -> Self {
        Big::from_ball(value, bits)
    }

    fn rounding(bits: usize) -> f64 {
        f64::powi(2.0, -i32::try_from(bits.min(1000)).unwrap_or(1000))
    }
}
