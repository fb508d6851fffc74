//! Numbers with a derivative: forward-mode algorithmic differentiation.

use super::{Function, Scalar, power};
use crate::number::Number;

/// A number and its derivative by one variable. Every operation applies the chain rule (Griewank and Walther,
/// Evaluating Derivatives (2008), chapter 3); over enclosures the derivative is enclosed as well.
#[derive(Clone, Debug, PartialEq)]
pub struct Dual<S> {
    /// The number.
    pub value: S,
    /// Its derivative.
    pub slope: S,
}

impl<S: Scalar> Dual<S> {
    /// What does not depend on the variable.
    #[must_use]
    pub fn constant(value: S, precision: S::Precision) -> Self {
        let slope = S::from_number(&Number::ZERO, precision);
        Self { value, slope }
    }

    /// f(x) from f and f' at x.
    fn chain(&self, value: S, slope: &S) -> Self {
        Self { value, slope: if self.slope.is_exact_zero() { self.slope.clone() } else { slope.mul(&self.slope) } }
    }

    /// 1 in the precision of a number that is not 0 there.
    fn one(like: &S) -> S {
        like.powi(0)
    }
}

impl<S: Scalar> Scalar for Dual<S> {
    type Precision = S::Precision;

    fn from_number(number: &Number, precision: S::Precision) -> Self {
        Self::constant(S::from_number(number, precision), precision)
    }

    fn pi(precision: S::Precision) -> Self {
        Self::constant(S::pi(precision), precision)
    }

    fn add(&self, other: &Self) -> Self {
        Self { value: self.value.add(&other.value), slope: self.slope.add(&other.slope) }
    }

    fn sub(&self, other: &Self) -> Self {
        Self { value: self.value.sub(&other.value), slope: self.slope.sub(&other.slope) }
    }

    fn mul(&self, other: &Self) -> Self {
        let left = self.slope.mul(&other.value);
        Self { value: self.value.mul(&other.value), slope: left.add(&self.value.mul(&other.slope)) }
    }

    fn div(&self, other: &Self) -> Self {
        // (a/b)' = (a' - (a/b) b')/b
        let value = self.value.div(&other.value);
        let rest = self.slope.sub(&value.mul(&other.slope));
        Self { slope: rest.div(&other.value), value }
    }

    fn neg(&self) -> Self {
        Self { value: self.value.neg(), slope: self.slope.neg() }
    }

    fn powi(&self, exponent: i32) -> Self {
        let value = self.value.powi(exponent);
        if exponent == 0 {
            let slope = value.sub(&value);
            return Self { value, slope };
        }
        let factor = count(&self.value, exponent);
        let slope = factor.mul(&self.value.powi(exponent - 1));
        self.chain(value, &slope)
    }

    fn sqrt(&self) -> Self {
        let value = self.value.sqrt();
        let slope = Self::one(&value).div(&value.add(&value));
        self.chain(value, &slope)
    }

    fn pow(&self, exponent: &Self) -> Self {
        // (a^b)' = a^b (b' ln a + b a'/a)
        let value = self.value.pow(&exponent.value);
        let mut slope = exponent.value.mul(&self.slope).div(&self.value);
        if !exponent.slope.is_exact_zero() {
            let logarithm = self.value.apply(Function::Ln);
            slope = slope.add(&exponent.slope.mul(&logarithm));
        }
        Self { slope: value.mul(&slope), value }
    }

    fn apply(&self, function: Function) -> Self {
        let x = &self.value;
        let value = x.apply(function);
        let one = || Self::one(x);
        let square = || x.mul(x);
        let slope = match function {
            Function::Sin => x.apply(Function::Cos),
            Function::Cos => x.apply(Function::Sin).neg(),
            Function::Tan => one().add(&value.mul(&value)),
            Function::Asin => one().div(&one().sub(&square()).sqrt()),
            Function::Acos => one().div(&one().sub(&square()).sqrt()).neg(),
            Function::Atan => one().div(&one().add(&square())),
            Function::Sinh => x.apply(Function::Cosh),
            Function::Cosh => x.apply(Function::Sinh),
            Function::Tanh => one().sub(&value.mul(&value)),
            Function::Exp => value.clone(),
            Function::Ln => one().div(x),
            // The sign, which 0 has none of.
            Function::Abs => value.div(x),
        };
        self.chain(value, &slope)
    }

    fn atan2(&self, x: &Self) -> Self {
        // d atan2(y, x) = (x dy - y dx)/(x² + y²)
        let square = x.value.mul(&x.value).add(&self.value.mul(&self.value));
        let rise = x.value.mul(&self.slope).sub(&self.value.mul(&x.slope));
        Self { value: self.value.atan2(&x.value), slope: rise.div(&square) }
    }

    fn is_finite(&self) -> bool {
        self.value.is_finite() && self.slope.is_finite()
    }

    fn is_exact_zero(&self) -> bool {
        self.value.is_exact_zero() && self.slope.is_exact_zero()
    }
}

/// A whole number in the precision of another: by doubling.
fn count<S: Scalar>(like: &S, number: i32) -> S {
    let one = like.powi(0);
    let total = power(&one, number.unsigned_abs(), S::add).unwrap_or_else(|| one.sub(&one));
    if number < 0 { total.neg() } else { total }
}
