//! Exact values of numbers with bounds, as fractions; functions by name.
#![cfg(feature = "engine")]

use dashu_int::{IBig, UBig};
use dashu_ratio::RBig;
use librate::precision::Scalar;
use librate_core::expr::function_from_name;
use librate_core::precision::DoubleDouble;
use librate_core::precision::Magnitude;

pub(crate) fn double(x: f64) -> RBig {
    RBig::try_from(x).unwrap()
}

pub(crate) fn double_double(x: DoubleDouble) -> RBig {
    double(x.hi) + double(x.lo)
}

pub(crate) fn magnitude(x: Magnitude) -> RBig {
    let (mantissa, exponent) = x.parts();
    double(mantissa) * power_of_two(exponent)
}

pub(crate) fn power_of_two(exponent: i64) -> RBig {
    let size = RBig::from(UBig::ONE << exponent.unsigned_abs() as usize);
    if exponent < 0 { RBig::ONE / size } else { size }
}

pub(crate) fn absolute(x: RBig) -> RBig {
    if x < RBig::ZERO { -x } else { x }
}

/// A decimal number with exponent.
pub(crate) fn decimal(text: &str) -> RBig {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits: IBig = format!("{whole}{fraction}").parse().unwrap();
    let power = exponent.parse::<i32>().unwrap() - fraction.len() as i32;
    let size = RBig::from(UBig::from(10u8).pow(power.unsigned_abs() as usize));
    if power < 0 { RBig::from(digits) / size } else { RBig::from(digits) * size }
}

/// A function of one or two numbers by its name.
pub(crate) fn apply<S: Scalar>(name: &str, x: &S, y: &S) -> S {
    match name {
        "atan2" => x.atan2(y),
        "pow" => x.pow(y),
        "sqrt" => x.sqrt(),
        other => x.apply(function_from_name(other).unwrap()),
    }
}
