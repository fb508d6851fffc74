//! What a type of enclosures has to offer beyond arithmetic.

use crate::precision::{Ball, Big, DoubleDouble, Magnitude, Scalar, up};

/// A number known to lie within a radius of a midpoint.
pub trait Enclosure: Scalar {
    /// A double, exactly.
    fn exact(value: f64, precision: Self::Precision) -> Self;
    /// The midpoint, exactly.
    fn center(&self) -> Self;
    /// The midpoint as a double, about.
    fn middle(&self) -> f64;
    /// An upper bound of the distance from the midpoint; infinite where the number is none.
    fn radius(&self) -> f64;
    /// An upper bound of the absolute value; infinite where the number is none.
    fn abs_upper(&self) -> f64;
    /// With a radius larger by so much.
    fn widened(&self, by: f64) -> Self;
    /// An upper bound of the absolute value, with an exponent of its own.
    fn size(&self) -> Magnitude;
    /// An upper bound of the distance from the midpoint, with an exponent of its own.
    fn spread(&self) -> Magnitude;
    /// With a radius larger by so much.
    fn with_spread(&self, by: Magnitude) -> Self;
    /// A number not below a size.
    fn from_size(size: Magnitude, precision: Self::Precision) -> Self;
    /// Times 2^exponent.
    fn doubled(&self, exponent: i64) -> Self;
    /// Whether the number is certainly positive.
    fn is_above_zero(&self) -> bool;
    /// Whether the number is zero, exactly.
    fn is_zero(&self) -> bool;
    /// As a ball in double-double.
    fn to_ball(&self) -> Ball;
    /// With the bits given, or those that it has.
    fn to_big(&self, bits: usize) -> Big;
    /// The number itself where it has more bits or a wider range than a ball.
    fn precise(self) -> Option<Big>;
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
        if self.is_finite() {
            Ball::new(self.mid, 0.0)
        } else {
            *self
        }
    }

    fn middle(&self) -> f64 {
        self.mid_f64()
    }

    fn radius(&self) -> f64 {
        if self.is_finite() {
            self.radius
        } else {
            f64::INFINITY
        }
    }

    fn abs_upper(&self) -> f64 {
        Ball::abs_upper(self)
    }

    fn widened(&self, by: f64) -> Self {
        self.with_added_radius(by)
    }

    fn size(&self) -> Magnitude {
        Magnitude::from_f64(Enclosure::abs_upper(self))
    }

    fn spread(&self) -> Magnitude {
        Magnitude::from_f64(Enclosure::radius(self))
    }

    fn with_spread(&self, by: Magnitude) -> Self {
        self.with_added_radius(by.to_f64())
    }

    fn from_size(size: Magnitude, (): ()) -> Self {
        Ball::exact(size.to_f64())
    }

    fn doubled(&self, exponent: i64) -> Self {
        // In steps that leave neither the range of doubles nor that of their exponents.
        let mut value = *self;
        let mut left = exponent.clamp(-4000, 4000);
        while left != 0 {
            let step = left.clamp(-500, 500);
            value = value.scale(step as i32);
            left -= step;
        }
        value
    }

    fn is_above_zero(&self) -> bool {
        self.is_positive()
    }

    fn is_zero(&self) -> bool {
        Ball::is_zero(self)
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

    fn from_ball(value: &Ball, (): ()) -> Self {
        *value
    }

    fn rounding((): ()) -> f64 {
        crate::precision::U2
    }
}

impl Enclosure for Big {
    fn exact(value: f64, bits: usize) -> Self {
        Big::from_f64(value, bits)
    }

    fn center(&self) -> Self {
        if self.is_finite() {
            Big::center(self)
        } else {
            self.clone()
        }
    }

    fn middle(&self) -> f64 {
        self.mid_f64()
    }

    fn radius(&self) -> f64 {
        Big::radius(self).to_f64()
    }

    fn abs_upper(&self) -> f64 {
        Big::abs_upper(self).to_f64()
    }

    fn widened(&self, by: f64) -> Self {
        if by >= 0.0 && by.is_finite() {
            self.clone().with_added_radius(Magnitude::from_f64(by))
        } else {
            Big::not_finite(self.bits())
        }
    }

    fn size(&self) -> Magnitude {
        Big::abs_upper(self)
    }

    fn spread(&self) -> Magnitude {
        Big::radius(self)
    }

    fn with_spread(&self, by: Magnitude) -> Self {
        self.clone().with_added_radius(by)
    }

    fn from_size(size: Magnitude, bits: usize) -> Self {
        // All 53 bits of a size fit.
        Big::from_magnitude(size, bits.max(64))
    }

    fn doubled(&self, exponent: i64) -> Self {
        self.scale(exponent)
    }

    fn is_above_zero(&self) -> bool {
        self.is_positive()
    }

    fn is_zero(&self) -> bool {
        Big::is_zero(self)
    }

    fn to_ball(&self) -> Ball {
        Big::to_ball(self)
    }

    fn to_big(&self, _: usize) -> Big {
        self.clone()
    }

    fn precise(self) -> Option<Big> {
        Some(self)
    }

    fn from_ball(value: &Ball, bits: usize) -> Self {
        if value.is_finite() {
            Big::from_ball(value, bits)
        } else {
            Big::not_finite(bits)
        }
    }

    fn rounding(bits: usize) -> f64 {
        f64::powi(2.0, -i32::try_from(bits.min(1000)).unwrap_or(1000))
    }
}

/// x + [0, length] for an upper bound of the length.
pub(super) fn onwards<S: Enclosure>(x: &S, length: f64, precision: S::Precision) -> S {
    let half = (0.5 * length).next_up();
    x.add(&S::exact(half, precision)).widened(half)
}

/// An upper bound of e^x - 1 for x >= 0.
pub(super) fn growth(x: f64) -> f64 {
    if !(0.0..700.0).contains(&x) {
        return f64::INFINITY;
    }
    let exponential = Ball::from(DoubleDouble::exact(x)).exp();
    up((exponential - Ball::ONE).upper().max(0.0))
}

/// max_i Σ_j |a_ij| w_j/w_i of a square matrix, row by row, from above.
pub(super) fn norm<S: Enclosure>(matrix: &[S], weights: &[f64]) -> f64 {
    let n = weights.len();
    let row = |i: usize| {
        let parts = matrix[n * i..n * (i + 1)].iter().zip(weights);
        // Weights are powers of two; each partial sum is rounded up.
        parts.fold(0.0_f64, |sum, (x, w)| {
            if x.is_zero() {
                sum
            } else {
                up(sum + x.abs_upper() * (w / weights[i]))
            }
        })
    };
    (0..n).map(row).fold(0.0, f64::max)
}

/// Where T may differ from 1: where a path of entries of J that are not 0 leads from i to j.
///
/// Let R be all that is reached from i. Rows of J in R have entries in R alone, so that the j-th column of T obeys
/// equations of its own there: for j outside of R it begins with 0 and stays 0, in R and, since dT_ij/dt is made of it, in
/// row i too, where T_ij stays what it is at first.
pub(super) fn reached<S: Enclosure>(n: usize, jacobian: &[S]) -> Vec<bool> {
    let mut reached: Vec<bool> = jacobian.iter().map(|entry| !entry.is_zero()).collect();
    for k in 0..n {
        for i in 0..n {
            if reached[n * i + k] {
                for j in 0..n {
                    reached[n * i + j] |= reached[n * k + j];
                }
            }
        }
    }
    reached
}
