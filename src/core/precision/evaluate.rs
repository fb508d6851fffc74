//! The number types expressions are evaluated over: doubles, one or eight, double-doubles and balls.

use super::ball::Ball;
use super::big::Big;
use super::double::DoubleDouble;
use super::lane::Lane;
use super::scalar::{self, Function, Scalar, functions, operators, own_methods};
use super::sums;
use crate::number::{Number, TwoDoubles};

impl Scalar for f64 {
    type Precision = ();

    #[inline]
    fn from_number(number: &Number, (): ()) -> Self {
        number.to_double_double().high
    }

    #[inline]
    fn pi((): ()) -> Self {
        std::f64::consts::PI
    }

    operators!(*);

    fn powi(&self, exponent: i32) -> Self {
        f64::powi(*self, exponent)
    }

    #[inline]
    fn sqrt(&self) -> Self {
        f64::sqrt(*self)
    }

    fn pow(&self, exponent: &Self) -> Self {
        f64::powf(*self, *exponent)
    }

    functions!();

    fn atan2(&self, x: &Self) -> Self {
        if *self == 0.0 && *x == 0.0 {
            return f64::NAN;
        }
        // Adding 0 turns -0 into 0, whose angle is pi and not -pi.
        f64::atan2(*self + 0.0, *x)
    }

    #[inline]
    fn signum(&self) -> Self {
        if *self == 0.0 { f64::NAN } else { f64::signum(*self) }
    }

    /// Four sums side by side: one would wait for each of its additions.
    #[inline]
    fn convolution(left: &[Self], right: &[Self]) -> Option<Self> {
        let (blocks, left) = left.as_chunks::<4>();
        let (right, mirrored) = right.as_rchunks::<4>();
        let mut sums = [0.0; 4];
        for (x, y) in blocks.iter().zip(mirrored.iter().rev()) {
            for i in 0..4 {
                sums[i] += x[i] * y[3 - i];
            }
        }
        let sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
        let sum = left.iter().zip(right.iter().rev()).fold(sum, |sum, (x, y)| sum + x * y);
        (!(blocks.is_empty() && left.is_empty())).then_some(sum)
    }

    #[inline]
    fn is_finite(&self) -> bool {
        f64::is_finite(*self)
    }

    #[inline]
    fn is_exact_zero(&self) -> bool {
        *self == 0.0
    }
}

/// Nothing is known of errors here: a value is the middle of the enclosure that [`Ball`] computes.
impl Scalar for DoubleDouble {
    type Precision = ();

    #[inline]
    fn from_number(number: &Number, (): ()) -> Self {
        Ball::from_number(number, ()).mid
    }

    #[inline]
    fn pi((): ()) -> Self {
        Ball::PI.mid
    }

    operators!(*);

    fn powi(&self, exponent: i32) -> Self {
        Ball::from(*self).powi(exponent).mid
    }

    #[inline]
    fn sqrt(&self) -> Self {
        DoubleDouble::sqrt(*self)
    }

    fn pow(&self, exponent: &Self) -> Self {
        Ball::from(*self).pow(&Ball::from(*exponent)).mid
    }

    fn apply(&self, function: Function) -> Self {
        Ball::from(*self).apply(function).mid
    }

    fn atan2(&self, x: &Self) -> Self {
        Ball::from(*self).atan2(&Ball::from(*x)).mid
    }

    #[inline]
    fn convolution(left: &[Self], right: &[Self]) -> Option<Self> {
        sums::convolution(left, right)
    }

    #[inline]
    fn is_finite(&self) -> bool {
        DoubleDouble::is_finite(*self)
    }

    #[inline]
    fn is_exact_zero(&self) -> bool {
        self.hi == 0.0 && self.lo == 0.0
    }
}

impl Scalar for Lane {
    type Precision = ();

    #[inline]
    fn from_number(number: &Number, (): ()) -> Self {
        Self::splat(f64::from_number(number, ()))
    }

    #[inline]
    fn pi((): ()) -> Self {
        Self::splat(std::f64::consts::PI)
    }

    operators!(*);

    fn powi(&self, exponent: i32) -> Self {
        self.map(|x| x.powi(exponent))
    }

    #[inline]
    fn sqrt(&self) -> Self {
        Lane::sqrt(*self)
    }

    fn pow(&self, exponent: &Self) -> Self {
        self.zip(*exponent, f64::powf)
    }

    fn apply(&self, function: Function) -> Self {
        self.map(|x| x.apply(function))
    }

    fn atan2(&self, x: &Self) -> Self {
        self.zip(*x, |y, x| Scalar::atan2(&y, &x))
    }

    #[inline]
    fn signum(&self) -> Self {
        self.map(|x| Scalar::signum(&x))
    }

    #[inline]
    fn convolution(left: &[Self], right: &[Self]) -> Option<Self> {
        (!left.is_empty()).then(|| sums::convolution_of_lanes(left, right))
    }

    /// Whether all eight are.
    #[inline]
    fn is_finite(&self) -> bool {
        self.0.iter().fold(true, |all, x| all & x.is_finite())
    }

    /// Whether all eight are.
    #[inline]
    fn is_exact_zero(&self) -> bool {
        !self.any()
    }
}

impl Scalar for Ball {
    type Precision = ();

    #[inline]
    fn from_number(number: &Number, (): ()) -> Self {
        let TwoDoubles { high, low, error } = number.to_double_double();
        if high.is_finite() { Ball::new(DoubleDouble::new(high, low), error) } else { Ball::NOT_FINITE }
    }

    #[inline]
    fn is_same(&self, other: &Self) -> bool {
        let bits = |own: &Self| [own.mid.hi, own.mid.lo, own.radius].map(f64::to_bits);
        bits(self) == bits(other)
    }

    #[inline]
    fn pi((): ()) -> Self {
        Ball::PI
    }

    operators!(*);

    functions!();

    own_methods! { Ball:
        powi(exponent: i32) -> Self;
        sqrt() -> Self;
        pow(exponent: &Self) -> Self;
        atan2(x: &Self) -> Self;
        is_finite() -> bool;
    }

    #[inline]
    fn signum(&self) -> Self {
        if self.is_positive() {
            Ball::ONE
        } else if self.is_negative() {
            -Ball::ONE
        } else {
            Ball::NOT_FINITE
        }
    }

    fn convolution(left: &[Self], right: &[Self]) -> Option<Self> {
        if left.len() >= sums::SHORT_FOR_BALLS
            && let Some(sum) = sums::convolution_of_balls(left, right)
        {
            return Some(sum);
        }
        scalar::one_by_one(left, right)
    }

    fn to_wide(&self, bits: usize) -> Option<Big> {
        Some(Big::from_ball(self, bits))
    }

    fn from_wide(wide: &Big) -> Option<Self> {
        Some(wide.to_far_ball())
    }

    #[inline]
    fn is_exact_zero(&self) -> bool {
        self.is_zero()
    }
}
