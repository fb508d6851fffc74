//! The number types expressions are evaluated over: doubles and balls.

use super::ball::Ball;
use super::double::DoubleDouble;
use super::scalar::{Function, Scalar};
use crate::number::Number;

impl Scalar for f64 {
    type Precision = ();

    fn from_number(number: &Number, (): ()) -> Self {
        number.to_double_double().0
    }

    fn pi((): ()) -> Self {
        std::f64::consts::PI
    }

    fn add(&self, other: &Self) -> Self {
        self + other
    }

    fn sub(&self, other: &Self) -> Self {
        self - other
    }

    fn mul(&self, other: &Self) -> Self {
        self * other
    }

    fn div(&self, other: &Self) -> Self {
        self / other
    }

    fn neg(&self) -> Self {
        -self
    }

    fn powi(&self, exponent: i32) -> Self {
        f64::powi(*self, exponent)
    }

    fn sqrt(&self) -> Self {
        f64::sqrt(*self)
    }

    fn pow(&self, exponent: &Self) -> Self {
        f64::powf(*self, *exponent)
    }

    fn apply(&self, function: Function) -> Self {
        match function {
            Function::Sin => self.sin(),
            Function::Cos => self.cos(),
            Function::Tan => self.tan(),
            Function::Asin => self.asin(),
            Function::Acos => self.acos(),
            Function::Atan => self.atan(),
            Function::Sinh => self.sinh(),
            Function::Cosh => self.cosh(),
            Function::Tanh => self.tanh(),
            Function::Exp => self.exp(),
            Function::Ln => self.ln(),
            Function::Abs => self.abs(),
        }
    }

    fn atan2(&self, x: &Self) -> Self {
        if *self == 0.0 && *x == 0.0 {
            return f64::NAN;
        }
        // Adding 0 turns -0 into 0, whose angle is pi and not -pi.
        f64::atan2(*self + 0.0, *x)
    }

    fn signum(&self) -> Self {
        if *self == 0.0 {
            f64::NAN
        } else {
            f64::signum(*self)
        }
    }

    fn is_finite(&self) -> bool {
        f64::is_finite(*self)
    }

    fn is_exact_zero(&self) -> bool {
        *self == 0.0
    }
}

impl Scalar for Ball {
    type Precision = ();

    fn from_number(number: &Number, (): ()) -> Self {
        let (hi, lo, error) = number.to_double_double();
        if hi.is_finite() {
            Ball::new(DoubleDouble::new(hi, lo), error)
        } else {
            Ball::NOT_FINITE
        }
    }

    fn pi((): ()) -> Self {
        Ball::PI
    }

    fn add(&self, other: &Self) -> Self {
        *self + *other
    }

    fn sub(&self, other: &Self) -> Self {
        *self - *other
    }

    fn mul(&self, other: &Self) -> Self {
        *self * *other
    }

    fn div(&self, other: &Self) -> Self {
        *self / *other
    }

    fn neg(&self) -> Self {
        -*self
    }

    fn powi(&self, exponent: i32) -> Self {
        Ball::powi(self, exponent)
    }

    fn sqrt(&self) -> Self {
        Ball::sqrt(self)
    }

    fn pow(&self, exponent: &Self) -> Self {
        Ball::pow(self, exponent)
    }

    fn apply(&self, function: Function) -> Self {
        match function {
            Function::Sin => self.sin(),
            Function::Cos => self.cos(),
            Function::Tan => self.tan(),
            Function::Asin => self.asin(),
            Function::Acos => self.acos(),
            Function::Atan => self.atan(),
            Function::Sinh => self.sinh(),
            Function::Cosh => self.cosh(),
            Function::Tanh => self.tanh(),
            Function::Exp => self.exp(),
            Function::Ln => self.ln(),
            Function::Abs => self.abs(),
        }
    }

    fn atan2(&self, x: &Self) -> Self {
        Ball::atan2(self, x)
    }

    fn signum(&self) -> Self {
        if self.is_positive() {
            Ball::ONE
        } else if self.is_negative() {
            -Ball::ONE
        } else {
            Ball::NOT_FINITE
        }
    }

    fn is_finite(&self) -> bool {
        Ball::is_finite(self)
    }

    fn is_exact_zero(&self) -> bool {
        self.is_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_of_the_axes_are_in_the_half_open_range() {
        let pi = std::f64::consts::PI;
        assert_eq!(Scalar::atan2(&-0.0, &-1.0), pi);
        assert_eq!(Scalar::atan2(&Ball::ZERO, &Ball::exact(-1.0)).mid_f64(), pi);
        assert!(!Scalar::is_finite(&Scalar::atan2(&0.0, &0.0)));
        assert!(!Scalar::is_finite(&Scalar::atan2(&Ball::ZERO, &Ball::ZERO)));
    }

    #[test]
    fn exact_numbers_stay_exact() {
        assert_eq!(Ball::from_number(&Number::from(7), ()), Ball::exact(7.0));
        assert_eq!(f64::from_number(&Number::from(-7), ()), -7.0);
    }
}
