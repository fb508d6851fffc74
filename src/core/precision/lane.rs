//! Eight doubles side by side: one of each parameter set of a block, or of each place of a chart.
//!
//! Every operation is a loop over the eight that the compiler turns into vector instructions. None
//! is fused and none is reordered, so that a number doesn't depend on the machine's vectors
//! (beyond its sine and its like), nor on those beside it.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use super::double::{DoubleDouble, product_error, two_sum};

/// How many numbers are worked on at once.
pub const LANES: usize = 8;

/// Eight doubles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lane(pub [f64; LANES]);

impl Lane {
    /// 0, eight times.
    pub const ZERO: Self = Self([0.0; LANES]);
    /// 1, eight times.
    pub const ONE: Self = Self([1.0; LANES]);

    /// A number, eight times.
    #[inline(always)]
    #[must_use]
    pub fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// A function of each.
    #[inline(always)]
    #[must_use]
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut result = self;
        for value in &mut result.0 {
            *value = f(*value);
        }
        result
    }

    /// A function of each and its neighbour in the other.
    #[inline(always)]
    #[must_use]
    pub fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut result = self;
        for i in 0..LANES {
            result.0[i] = f(self.0[i], other.0[i]);
        }
        result
    }

    /// Absolute values.
    #[inline(always)]
    #[must_use]
    pub fn abs(self) -> Self {
        self.map(f64::abs)
    }

    /// Square roots.
    #[inline(always)]
    #[must_use]
    pub fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    /// The larger number; `other` where either is none.
    #[inline(always)]
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    /// Of each `self` where `choice` is not 0, else `other`.
    #[inline(always)]
    #[must_use]
    pub fn choose(self, choice: Self, other: Self) -> Self {
        let mut result = other;
        for i in 0..LANES {
            result.0[i] = if choice.0[i] != 0.0 { self.0[i] } else { other.0[i] };
        }
        result
    }

    /// 1 where the number is above the other one, else 0.
    #[inline(always)]
    #[must_use]
    pub fn above(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { 1.0 } else { 0.0 })
    }

    /// Whether any number is not 0.
    #[inline(always)]
    #[must_use]
    pub fn any(self) -> bool {
        self.0.iter().fold(false, |any, value| any | (*value != 0.0))
    }
}

macro_rules! one_by_one {
    ($($operator:ident $name:ident)*) => {
        $(impl $operator for Lane {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                self.zip(other, f64::$name)
            }
        })*
    };
}

one_by_one!(Add add Sub sub Mul mul Div div);

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

/// Eight double-doubles.
#[derive(Clone, Copy)]
pub(crate) struct Pair {
    pub(crate) high: Lane,
    pub(crate) low: Lane,
}

impl Pair {
    pub(crate) const ZERO: Self = Self { high: Lane::ZERO, low: Lane::ZERO };

    /// A number, eight times.
    #[inline(always)]
    pub(crate) fn splat(value: DoubleDouble) -> Self {
        Self { high: Lane::splat(value.hi), low: Lane::splat(value.lo) }
    }

    /// self + x y.
    #[inline(always)]
    pub(crate) fn add_products<const FUSED: bool>(&mut self, x: Lane, y: &Self) {
        let (product, error) = lane_product::<FUSED>(x, y.high);
        let (sum, rest) = two_sum(self.high, product);
        self.high = sum;
        self.low += rest + (error + x * y.low);
    }

    /// Its parts as they should be: the lower one less than a rounding of the higher one.
    #[inline(always)]
    pub(crate) fn settled(&self) -> Self {
        let (high, low) = two_sum(self.high, self.low);
        Self { high, low }
    }

    /// The number k - θ m.
    #[inline(always)]
    pub(crate) fn shifted<const FUSED: bool>(k: DoubleDouble, theta: &Self, m: DoubleDouble) -> Self {
        let t = -theta.high;
        let (p, error) = lane_product::<FUSED>(t, Lane::splat(m.hi));
        let (high, rest) = two_sum(Lane::splat(k.hi), p);
        let low = rest + (error + (t * Lane::splat(m.lo) - theta.low * Lane::splat(m.hi)) + Lane::splat(k.lo));
        Self::nearly_settled(high, low)
    }

    /// The sum of two parts of which the second is small.
    #[inline(always)]
    pub(crate) fn nearly_settled(high: Lane, low: Lane) -> Self {
        let sum = high + low;
        Self { high: sum, low: low - (sum - high) }
    }
}

/// See [`two_prod`](super::two_prod).
#[inline(always)]
pub(crate) fn lane_product<const FUSED: bool>(a: Lane, b: Lane) -> (Lane, Lane) {
    let p = a * b;
    let mut error = p;
    for l in 0..LANES {
        error.0[l] = if FUSED { a.0[l].mul_add(b.0[l], -p.0[l]) } else { product_error(a.0[l], b.0[l], p.0[l]) };
    }
    (p, error)
}

/// Wraps loops over numbers in a function that runs them compiled for fused multiply-add and four lanes where the machine
/// has these: without them they cost five times as much. Loops take products apart, so that they give the same bits with
/// fused multiplications and without; they are always inlined, so that they have the instructions of their caller.
macro_rules! kernel {
    ($(#[$doc:meta])* $visibility:vis $name:ident, $loops:ident, ($($argument:ident: $type:ty),*) $(-> $result:ty)?) => {
        $(#[$doc])*
        $visibility fn $name($($argument: $type),*) $(-> $result)? {
            #[cfg(target_arch = "x86_64")]
            if std::arch::is_x86_feature_detected!("avx2")
                && std::arch::is_x86_feature_detected!("fma")
            {
                #[target_feature(enable = "avx2,fma")]
                fn fused($($argument: $type),*) $(-> $result)? {
                    $loops::<true>($($argument),*)
                }
                #[allow(unsafe_code)]
                // SAFETY: the features that the function is compiled for were detected just above.
                return unsafe { fused($($argument),*) };
            }
            $loops::<{ cfg!(any(target_feature = "fma", target_arch = "aarch64")) }>($($argument),*)
        }
    };
}

pub(crate) use kernel;
