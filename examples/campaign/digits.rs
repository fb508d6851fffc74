//! Decimal digits the slow way: exact fractions, and nothing of the library's.

use dashu_int::IBig;
use dashu_int::ops::BitTest as _;
use dashu_ratio::RBig;

use crate::draw::power_of_ten;
use crate::real::*;

/// Forty digits, for messages.
pub(crate) fn digits(x: &Real) -> String {
    let negative = is_negative(x);
    let (rounded, place) = round(&ratio(&abs(x)), 40);
    let digits = (rounded / power_of_ten(place)).to_string();
    let sign = if negative { "-" } else { "" };
    let (first, rest) = digits.split_at(1);
    format!("{sign}{first}.{rest}e{}", place + 39)
}

pub(crate) fn absolute(x: RBig) -> RBig {
    if x < RBig::ZERO { -x } else { x }
}

/// A printed number and how many significant digits it shows.
pub(crate) fn read(text: &str) -> Option<(RBig, usize)> {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let all = format!("{whole}{fraction}");
    let shown = all.trim_start_matches('0').len();
    let exponent: i64 = exponent.parse().ok()?;
    let digits: IBig = all.parse().ok()?;
    let value = RBig::from(digits) * power_of_ten(exponent - fraction.len() as i64);
    Some((value, shown))
}

/// A positive number to so many significant digits, to nearest and ties to even, and the power of ten of
/// the last place before a carry.
pub(crate) fn round(x: &RBig, count: usize) -> (RBig, i64) {
    if *x == RBig::ZERO {
        return (RBig::ZERO, 0);
    }
    let guess = x.to_f64().value().log10().floor();
    let mut exponent = if guess.is_finite() { guess as i64 } else { 0 };
    while power_of_ten(exponent) > *x {
        exponent -= 1;
    }
    while power_of_ten(exponent + 1) <= *x {
        exponent += 1;
    }
    let place = exponent - count as i64 + 1;
    let unit = power_of_ten(place);
    let scaled = x / &unit;
    let (two, floor) = (RBig::from(2), scaled.floor());
    let rest = scaled - RBig::from(floor.clone());
    let half = RBig::ONE / &two;
    let odd = floor.bit(0);
    let up = rest > half || rest == half && odd;
    let rounded = RBig::from(floor) + if up { RBig::ONE } else { RBig::ZERO };
    (rounded * unit, place)
}
