//! Numbers with bounds: double-double arithmetic, rigorous enclosures and their decimal digits.
//!
//! The stage offers one number type after the other, from fast to careful: [`DoubleDouble`] (about
//! 31 digits), [`Ball`] (a double-double with an absolute error bound that every operation
//! carries along), [`Big`] (the same with any number of bits) and [`decimal`], which prints the
//! digits that a ball decides and no others.
//! Expressions are evaluated over any of them through [`Scalar`].
//!
//! It never sees an expression or a matrix, never guesses that something small is zero, and
//! never returns a bound that does not hold: a result outside the domain or the range of its type
//! is not finite, and that spreads.

mod ball;
mod banded;
mod big;
mod complex;
mod decimal;
mod double;
mod dual;
mod elementary;
mod enclosure;
mod evaluate;
mod interval;
mod lane;
mod magnitude;
mod matrix;
mod root;
mod scalar;
mod sparse;
mod sums;
mod system;

pub use ball::{Ball, U2, up};
pub use banded::{Banded, Polar};
pub use big::Big;
pub(crate) use big::Sum;
pub use complex::{Complex, hypot};
pub use decimal::{
    Decimal, Rounding, decimal, decimal_to_place, one_digit_up, one_digit_up_text, push_decimal, quick_decimal,
};
pub use double::{DoubleDouble, exponent_of, fast_two_sum, power_of_two, product_error, two_prod, two_sum};
pub use dual::Dual;
pub use enclosure::Enclosure;
pub use interval::Interval;
pub use lane::{LANES, Lane};
pub(crate) use lane::{Pair, kernel, lane_product};
pub use magnitude::Magnitude;
pub(crate) use matrix::{Eliminated, eliminate};
pub use matrix::{Entry, Matrix, clear_column, has_pivots, quadratic_form, reduce, subtract, sum_of_products};
pub(crate) use root::nth_root;
pub use root::{Integers, Root};
pub use scalar::{Function, Scalar, power};
pub use sparse::SparseMatrix;
pub use system::System;
