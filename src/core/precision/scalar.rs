//! What a number type has to offer so that compiled expressions can be evaluated over it.

use super::Big;
use crate::number::Number;

crate::worded! {
/// The elementary functions of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
Function {
    /// Sine.
    Sin "sin",
    /// Cosine.
    Cos "cos",
    /// Tangent.
    Tan "tan",
    /// Arc sine.
    Asin "asin",
    /// Arc cosine.
    Acos "acos",
    /// Arc tangent.
    Atan "atan",
    /// Hyperbolic sine.
    Sinh "sinh",
    /// Hyperbolic cosine.
    Cosh "cosh",
    /// Hyperbolic tangent.
    Tanh "tanh",
    /// Exponential function.
    Exp "exp",
    /// Natural logarithm.
    Ln "ln",
    /// Absolute value.
    Abs "abs",
}
/// Its name in the model language.
name
/// All of them.
ALL
}

/// A number type that expressions are evaluated over: `f64`, double-double balls, balls of any
/// precision, and whatever comes later.
///
/// Nothing panics: outside its domain an operation returns a value for which
/// [`Scalar::is_finite`] is false, and that value spreads.
pub trait Scalar: Clone {
    /// What has to be said to make a number from nothing: nothing for types of one precision, the
    /// bits for those of any.
    type Precision: Copy;
    /// The nearest value (for enclosures: a value that contains it) of an exact number.
    fn from_number(number: &Number, precision: Self::Precision) -> Self;
    /// The number pi.
    fn pi(precision: Self::Precision) -> Self;
    /// Sum.
    fn add(&self, other: &Self) -> Self;
    /// Difference.
    fn sub(&self, other: &Self) -> Self {
        self.add(&other.neg())
    }
    /// Product.
    fn mul(&self, other: &Self) -> Self;
    /// Quotient.
    fn div(&self, other: &Self) -> Self;
    /// Opposite.
    fn neg(&self) -> Self;
    /// Integer power, negative ones included.
    fn powi(&self, exponent: i32) -> Self;
    /// Square root.
    fn sqrt(&self) -> Self;
    /// General power of a positive base.
    fn pow(&self, exponent: &Self) -> Self;
    /// An elementary function.
    fn apply(&self, function: Function) -> Self;
    /// The angle of the point (x, y), in (-pi, pi]: `y.atan2(x)`.
    fn atan2(&self, x: &Self) -> Self;
    /// 1 or -1 where the sign is decided, else not a number.
    fn signum(&self) -> Self {
        self.apply(Function::Abs).div(self)
    }
    /// left_0 right_(n-1) + left_1 right_(n-2) + … + left_(n-1) right_0 for n numbers each, in an order that suits the
    /// type; `None` for n = 0.
    #[inline]
    fn convolution(left: &[Self], right: &[Self]) -> Option<Self> {
        one_by_one(left, right)
    }
    /// Whether the value is a number at all.
    fn is_finite(&self) -> bool;
    /// Whether two values are the same bit by bit, for types that are quickly compared; false says nothing.
    fn is_same(&self, _other: &Self) -> bool {
        false
    }
    /// The same in numbers whose exponents have no end, for an enclosure that has one of its own range.
    fn to_wide(&self, _bits: usize) -> Option<Big> {
        None
    }
    /// What [`Scalar::to_wide`] came to, enclosed.
    fn from_wide(_wide: &Big) -> Option<Self> {
        None
    }
    /// Whether the value is zero and known to be exactly that; `false` is always allowed and only
    /// costs time.
    fn is_exact_zero(&self) -> bool {
        false
    }
}

/// The operators of numbers, or with `*` of those that are copied.
macro_rules! operators {
    ($($star:tt)?) => {
        #[inline]
        fn add(&self, other: &Self) -> Self {
            $($star)? self + $($star)? other
        }

        #[inline]
        fn sub(&self, other: &Self) -> Self {
            $($star)? self - $($star)? other
        }

        #[inline]
        fn mul(&self, other: &Self) -> Self {
            $($star)? self * $($star)? other
        }

        #[inline]
        fn div(&self, other: &Self) -> Self {
            $($star)? self / $($star)? other
        }

        #[inline]
        fn neg(&self) -> Self {
            -$($star)? self
        }
    };
}

/// The elementary functions, each by the method of its name.
macro_rules! functions {
    () => {
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
    };
}

/// Methods that the type has itself, by the same names.
macro_rules! own_methods {
    ($of:ident: $($name:ident($($argument:ident: $type:ty)?) -> $result:ty;)*) => {
        $(#[inline]
        fn $name(&self, $($argument: $type)?) -> $result {
            $of::$name(self, $($argument)?)
        })*
    };
}

pub(super) use {functions, operators, own_methods};

/// A power by repeated squaring; `None` for the exponent 0.
pub fn power<T: Clone>(base: &T, exponent: u32, mut product: impl FnMut(&T, &T) -> T) -> Option<T> {
    let (mut left, mut square) = (exponent, base.clone());
    let mut power: Option<T> = None;
    while left > 0 {
        if left & 1 == 1 {
            power = Some(power.map_or_else(|| square.clone(), |power| product(&power, &square)));
        }
        left >>= 1;
        if left > 0 {
            square = product(&square, &square);
        }
    }
    power
}

/// [`Scalar::convolution`], one product after the other.
pub(super) fn one_by_one<S: Scalar>(left: &[S], right: &[S]) -> Option<S> {
    let products = left.iter().zip(right.iter().rev()).map(|(x, y)| x.mul(y));
    products.reduce(|sum, product| sum.add(&product))
}
