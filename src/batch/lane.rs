//! Eight numbers side by side: one of each parameter set of a block.
//!
//! Every operation is a loop over the eight that the compiler turns into vector instructions. None
//! is fused and none is reordered, so that a set's numbers don't depend on the machine's vectors
//! (beyond its sine and its like), nor on the sets beside it.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// How many parameter sets are worked on at once.
pub(super) const LANES: usize = 8;

/// One number of each set of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub(super) struct Lane(pub(super) [f64; LANES]);

impl Lane {
    pub(super) const ZERO: Self = Self([0.0; LANES]);
    pub(super) const ONE: Self = Self([1.0; LANES]);

    #[inline(always)]
    pub(super) fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    pub(super) fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut result = self;
        for value in &mut result.0 {
            *value = f(*value);
        }
        result
    }

    #[inline(always)]
    pub(super) fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut result = self;
        for (value, other) in result.0.iter_mut().zip(other.0) {
            *value = f(*value, other);
        }
        result
    }

    #[inline(always)]
    pub(super) fn abs(self) -> Self {
        self.map(f64::abs)
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    /// The larger number; `other` where either is none.
    #[inline(always)]
    pub(super) fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    /// Per set `self` where `choice` is not 0, else `other`.
    #[inline(always)]
    pub(super) fn choose(self, choice: Self, other: Self) -> Self {
        let mut result = other;
        for i in 0..LANES {
            result.0[i] = if choice.0[i] != 0.0 {
                self.0[i]
            } else {
                other.0[i]
            };
        }
        result
    }

    /// 1 where the number is above the other one, else 0.
    #[inline(always)]
    pub(super) fn above(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { 1.0 } else { 0.0 })
    }

    /// Whether any number is not 0.
    #[inline(always)]
    pub(super) fn any(self) -> bool {
        self.0
            .iter()
            .fold(false, |any, value| any | (*value != 0.0))
    }
}

impl Add for Lane {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Lane {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Lane {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Div for Lane {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

impl Neg for Lane {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl AddAssign for Lane {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Lane {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
