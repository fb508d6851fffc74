//! Doubles that know how far off they may be (to first order), and their dual numbers.

use librate::expr::Function;
use librate::number::Number;
use librate::precision::Scalar;

/// A double with an estimate of its error.
#[derive(Clone, Copy, Debug)]
pub struct Approx {
    pub value: f64,
    pub error: f64,
}

impl Approx {
    pub fn exact(value: f64) -> Approx {
        Approx { value, error: 0.0 }
    }

    fn with(value: f64, error: f64) -> Approx {
        Approx { value, error: error + value.abs() * 1e-15 }
    }

    /// Where it is not certain that there is a value.
    const UNCERTAIN: Approx = Approx { value: f64::NAN, error: f64::INFINITY };

    fn is_uncertain(&self) -> bool {
        self.error == f64::INFINITY || self.value.is_infinite()
    }

    /// Whether both are the same value, or the expected one (`self`) is not certain to exist.
    pub fn agrees(&self, found: &Approx) -> bool {
        let allowed = 8.0 * (self.error + found.error) + 1e-290;
        if !self.value.is_finite() || !self.error.is_finite() || self.error > 1e-6 * (1.0 + self.value.abs()) {
            return true;
        }
        // Infinite: somewhere on the way it was not certain that there is a value.
        if found.is_uncertain() || found.error > 1e-6 * (1.0 + found.value.abs()) {
            return true;
        }
        (self.value - found.value).abs() <= allowed
    }

    fn function(&self, function: Function, slope: f64) -> Approx {
        Approx::with(super::apply(function, self.value), self.error * slope.abs())
    }
}

impl Scalar for Approx {
    type Precision = ();

    fn from_number(number: &Number, (): ()) -> Self {
        Approx::with(number.to_f64(), 0.0)
    }
    fn pi((): ()) -> Self {
        Approx::with(std::f64::consts::PI, 0.0)
    }
    fn add(&self, other: &Self) -> Self {
        if self.is_uncertain() || other.is_uncertain() {
            return Approx::UNCERTAIN;
        }
        Approx::with(self.value + other.value, self.error + other.error)
    }
    fn sub(&self, other: &Self) -> Self {
        if self.is_uncertain() || other.is_uncertain() {
            return Approx::UNCERTAIN;
        }
        Approx::with(self.value - other.value, self.error + other.error)
    }
    fn mul(&self, other: &Self) -> Self {
        if self.is_uncertain() || other.is_uncertain() {
            return Approx::UNCERTAIN;
        }
        let error = self.error * other.value.abs() + other.error * self.value.abs();
        Approx::with(self.value * other.value, error)
    }
    fn div(&self, other: &Self) -> Self {
        if self.is_uncertain() || other.is_uncertain() {
            return Approx::UNCERTAIN;
        }
        // A divisor that may be 0 leaves nothing.
        if other.error >= other.value.abs() {
            return Approx::UNCERTAIN;
        }
        let value = self.value / other.value;
        let smallest = other.value.abs() - other.error;
        Approx::with(value, (self.error + other.error * value.abs()) / smallest)
    }
    fn neg(&self) -> Self {
        Approx { value: -self.value, error: self.error }
    }
    fn powi(&self, exponent: i32) -> Self {
        let mut power = Approx::exact(1.0);
        for _ in 0..exponent.abs() {
            power = power.mul(self);
        }
        if exponent < 0 { Approx::exact(1.0).div(&power) } else { power }
    }
    fn sqrt(&self) -> Self {
        if self.is_uncertain() {
            return Approx::UNCERTAIN;
        }
        if self.error > 0.0 && self.value.abs() <= self.error {
            return Approx::UNCERTAIN;
        }
        let value = self.value.sqrt();
        Approx::with(value, if self.error == 0.0 { 0.0 } else { self.error / value })
    }
    fn pow(&self, exponent: &Self) -> Self {
        if self.is_uncertain() || exponent.is_uncertain() {
            return Approx::UNCERTAIN;
        }
        // Through logarithm and exponential, whose errors are known; 0 has no power here.
        if self.value <= self.error {
            return Approx::UNCERTAIN;
        }
        self.apply(Function::Ln).mul(exponent).apply(Function::Exp)
    }
    fn apply(&self, function: Function) -> Self {
        if self.is_uncertain() {
            return Approx::UNCERTAIN;
        }
        let x = self.value;
        match function {
            Function::Sin | Function::Cos => self.function(function, 1.0),
            Function::Tan => {
                let (s, c) = (self.apply(Function::Sin), self.apply(Function::Cos));
                s.div(&c)
            }
            Function::Asin | Function::Acos => {
                if x.abs() + self.error > 1.0 && self.error > 0.0 {
                    return Approx { value: f64::NAN, error: f64::INFINITY };
                }
                let slope = 1.0 / (1.0 - x * x).sqrt();
                self.function(function, if self.error == 0.0 { 0.0 } else { slope })
            }
            Function::Atan => self.function(function, 1.0),
            Function::Sinh | Function::Cosh => self.function(function, x.cosh()),
            Function::Tanh => self.function(function, 1.0),
            Function::Exp => self.function(function, x.exp()),
            Function::Ln => self.function(function, 1.0 / (x.abs() - self.error).max(0.0)),
            Function::Abs => self.function(function, 1.0),
        }
    }
    fn atan2(&self, x: &Self) -> Self {
        if self.is_uncertain() || x.is_uncertain() {
            return Approx::UNCERTAIN;
        }
        let r2 = self.value * self.value + x.value * x.value;
        if x.value < self.error + x.error && self.value.abs() <= self.error {
            // On the branch cut.
            return Approx::UNCERTAIN;
        }
        let error = (self.error * x.value.abs() + x.error * self.value.abs()) / r2;
        Approx::with(self.value.atan2(x.value), error)
    }
    fn is_finite(&self) -> bool {
        self.value.is_finite()
    }
}

/// A value with its derivative.
#[derive(Clone, Copy, Debug)]
pub struct Dual {
    pub value: Approx,
    pub slope: Approx,
}

impl Dual {
    fn chain(&self, value: Approx, slope: Approx) -> Dual {
        Dual { value, slope: self.slope.mul(&slope) }
    }
}

impl Scalar for Dual {
    type Precision = ();

    fn from_number(number: &Number, (): ()) -> Self {
        Dual { value: Approx::from_number(number, ()), slope: Approx::exact(0.0) }
    }
    fn pi((): ()) -> Self {
        Dual { value: Approx::pi(()), slope: Approx::exact(0.0) }
    }
    fn add(&self, other: &Self) -> Self {
        Dual { value: self.value.add(&other.value), slope: self.slope.add(&other.slope) }
    }
    fn sub(&self, other: &Self) -> Self {
        Dual { value: self.value.sub(&other.value), slope: self.slope.sub(&other.slope) }
    }
    fn mul(&self, other: &Self) -> Self {
        let slope = self.slope.mul(&other.value).add(&self.value.mul(&other.slope));
        Dual { value: self.value.mul(&other.value), slope }
    }
    fn div(&self, other: &Self) -> Self {
        let value = self.value.div(&other.value);
        let slope = self.slope.sub(&value.mul(&other.slope)).div(&other.value);
        Dual { value, slope }
    }
    fn neg(&self) -> Self {
        Dual { value: self.value.neg(), slope: self.slope.neg() }
    }
    fn powi(&self, exponent: i32) -> Self {
        let slope = self.value.powi(exponent - 1).mul(&Approx::exact(f64::from(exponent)));
        self.chain(self.value.powi(exponent), slope)
    }
    fn sqrt(&self) -> Self {
        let value = self.value.sqrt();
        self.chain(value, Approx::exact(0.5).div(&value))
    }
    fn pow(&self, exponent: &Self) -> Self {
        let value = self.value.pow(&exponent.value);
        let by_base = self.slope.mul(&exponent.value).div(&self.value);
        let by_exponent = exponent.slope.mul(&self.value.apply(Function::Ln));
        Dual { value, slope: by_base.add(&by_exponent).mul(&value) }
    }
    fn apply(&self, function: Function) -> Self {
        let one = Approx::exact(1.0);
        let x = self.value;
        let value = x.apply(function);
        let slope = match function {
            Function::Sin => x.apply(Function::Cos),
            Function::Cos => x.apply(Function::Sin).neg(),
            Function::Tan => one.div(&x.apply(Function::Cos).powi(2)),
            Function::Asin => one.div(&one.sub(&x.mul(&x)).sqrt()),
            Function::Acos => one.div(&one.sub(&x.mul(&x)).sqrt()).neg(),
            Function::Atan => one.div(&one.add(&x.mul(&x))),
            Function::Sinh => x.apply(Function::Cosh),
            Function::Cosh => x.apply(Function::Sinh),
            Function::Tanh => one.div(&x.apply(Function::Cosh).powi(2)),
            Function::Exp => value,
            Function::Ln => one.div(&x),
            Function::Abs => x.div(&x.apply(Function::Abs)),
        };
        self.chain(value, slope)
    }
    fn atan2(&self, x: &Self) -> Self {
        let value = self.value.atan2(&x.value);
        let r2 = self.value.mul(&self.value).add(&x.value.mul(&x.value));
        let slope = self.slope.mul(&x.value).sub(&x.slope.mul(&self.value)).div(&r2);
        Dual { value, slope }
    }
    fn is_finite(&self) -> bool {
        self.value.is_finite() && self.slope.is_finite()
    }
}
