//! Decimal digits of numbers with bounds.
#![cfg(feature = "engine")]

use librate::precision::{Ball, Big, Rounding, decimal};
use librate_core::precision::{DoubleDouble, decimal_to_place, one_digit_up, one_digit_up_text, quick_decimal};
use proptest::prelude::*;

fn ball(hi: f64, lo: f64, radius: f64) -> Ball {
    Ball::new(DoubleDouble::new(hi, lo), radius)
}

fn text(hi: f64, radius: f64, digits: usize) -> String {
    decimal(&ball(hi, 0.0, radius), digits).text
}

#[test]
fn digits_and_layout() {
    assert_eq!(text(3.132_091_952_673_165, 1e-15, 10), "3.132091953");
    assert_eq!(text(1.5, 0.0, 10), "1.500000000");
    assert_eq!(text(-0.00012, 1e-20, 3), "-0.000120");
    assert_eq!(text(1.234_567_89e-12, 1e-28, 10), "1.234567890e-12");
    assert_eq!(text(123_456.0, 0.0, 10), "123456.0000");
    assert_eq!(text(123_456.0, 0.0, 6), "123456");
    assert_eq!(text(123_456.0, 0.0, 3), "1.23e5");
    assert_eq!(text(9.9999, 1e-9, 2), "10");
    assert_eq!(text(9.9999, 1e-9, 4), "10.00");
    assert_eq!(text(0.000_001, 1e-30, 2), "1.0e-6");
    assert_eq!(text(2.5e20, 0.0, 10), "2.500000000e20");
    assert_eq!(text(0.0, 0.0, 10), "0");
    assert_eq!(decimal(&Ball::PI, 31).text, "3.141592653589793238462643383280");
}

#[test]
fn only_decided_digits_are_printed() {
    let d = decimal(&ball(std::f64::consts::PI, 0.0, 1e-6), 10);
    assert_eq!((d.text.as_str(), d.digits, d.rounding), ("3.14159", 6, Rounding::Fewer));
    assert_eq!(d.error_bound, 4e-6);
    let d = decimal(&ball(1e-20, 0.0, 3e-20), 10);
    assert_eq!((d.text.as_str(), d.rounding, d.error_bound), ("0", Rounding::Undecided, 5e-20));
    // Of a number that is not 0, either: -7e-23 would be a digit that nobody has decided.
    for (mid, radius, bound) in [(0.5, 0.3, 0.8), (-7e-23, 6.9e-23, 2e-22)] {
        let d = decimal(&ball(mid, 0.0, radius), 10);
        let own = (d.text.as_str(), d.rounding, d.error_bound);
        assert_eq!(own, ("0", Rounding::Undecided, bound));
    }
    assert_eq!(decimal(&Ball::NOT_FINITE, 10).error_bound, f64::INFINITY);
}

/// The digits that doubles tell, if they do.
fn is_quick(value: &Ball, digits: usize) -> bool {
    let quick = quick_decimal(value, digits);
    let own = decimal(value, digits);
    assert!(
        quick.is_none() || own.rounding == Rounding::Correct && quick.as_ref() == Some(&own.text),
        "{own:?} {quick:?}"
    );
    quick.is_some()
}

#[test]
fn quick_digits_are_the_same() {
    for value in [0.0, 1.5, -0.00012, 1.234_567_89e-12, 123_456.0, 9.9999, 0.000_001, 2.5e20, 1e-280, 1e280] {
        for digits in [1, 2, 3, 5, 10, 17, 40] {
            assert!(is_quick(&Ball::from(value), digits), "{value} {digits}");
        }
    }
    is_quick(&Ball::from(5e-324), 3);
    is_quick(&Ball::from(1e300), 3);
    // Ties, exactly.
    for quarters in 1..1000 {
        for digits in 1..6 {
            assert!(is_quick(&Ball::from(f64::from(quarters) / 4.0), digits));
        }
    }
    assert!(is_quick(&ball(3.132_091_952_673_165, 1e-17, 1e-14), 10));
    for undecided in [ball(1.5, 0.0, 1e-30), ball(0.0, 0.0, 1e-30), ball(1.0, 0.0, 0.1), Ball::NOT_FINITE] {
        assert!(!is_quick(&undecided, 1));
    }
}

#[test]
fn numbers_end_at_a_place() {
    let to = |x: f64, place| decimal_to_place(&Ball::from(x), place, 10).text;
    assert_eq!(to(2.004_996, -3), "2.005");
    assert_eq!(to(9.996, -2), "10.00");
    assert_eq!(to(9.6, 0), "10");
    assert_eq!(to(-0.000_996, -5), "-0.00100");
    assert_eq!(to(1234.5, 2), "1.2e3");
    // At least one digit, at most as many as asked for.
    assert_eq!(to(0.034, 0), "0.03");
    assert_eq!(to(0.096, 1), "0.1");
    assert_eq!(to(1.0 / 3.0, -20), "0.3333333333");
    assert_eq!(to(0.999_999_999_99, -20), "1.000000000");
    assert_eq!(Big::pi(200).decimal_to_place(-4, 50).text, "3.1416");
}

#[test]
fn ties_are_owned_up_to() {
    let exact = decimal(&ball(0.125, 0.0, 0.0), 2);
    assert_eq!((exact.text.as_str(), exact.rounding), ("0.12", Rounding::Correct));
    let near = decimal(&ball(0.125, 0.0, 1e-20), 2);
    assert_eq!((near.text.as_str(), near.rounding), ("0.12", Rounding::Tie));
    let near = decimal(&ball(0.375, 1e-25, 1e-20), 2);
    assert_eq!((near.text.as_str(), near.rounding), ("0.38", Rounding::Tie));
    let near = decimal(&ball(9.5, 0.0, 1e-20), 1);
    assert_eq!((near.text.as_str(), near.error_bound), ("1e1", 0.6));
}

#[test]
fn bounds_round_up_to_one_digit() {
    assert_eq!(one_digit_up_text(4.4e-16), "5e-16");
    assert_eq!(one_digit_up_text(9.1e-3), "1e-2");
    assert_eq!(one_digit_up_text(3e-10), "3e-10");
    assert_eq!(one_digit_up_text(0.0), "0");
    assert_eq!(one_digit_up_text(f64::INFINITY), "inf");
    assert_eq!(one_digit_up_text(f64::NAN), "inf");
    assert_eq!(one_digit_up(one_digit_up(1.0)), 1.0);
    assert!(one_digit_up(5e-324) > 0.0);
}

proptest! {
    #[test]
    fn quick_digits_are_the_same_at_random(
        mantissa in -1_000_000_000_i64..1_000_000_000,
        scale in -20..20_i32,
        lo in -1e-17..1e-17_f64,
        radius in -30..-8_i32,
        digits in 1_usize..20,
    ) {
        let x = mantissa as f64 * 10_f64.powi(scale);
        is_quick(&ball(x, lo * x, x.abs() * 10_f64.powi(radius)), digits);
    }

    /// The standard library prints doubles correctly rounded: an outside witness.
    #[test]
    fn agrees_with_the_standard_library(m in -1.0..1.0f64, e in -300..290i32, digits in 1..30usize) {
        let x = m * 10f64.powi(e);
        prop_assume!(x != 0.0);
        let got = decimal(&Ball::exact(x), digits).text;
        let want = format!("{:.*e}", digits - 1, x);
        let value = |s: &str| s.parse::<f64>().unwrap();
        prop_assert_eq!(value(&got), value(&want));
        let count = |s: &str| {
            let mantissa = s.split('e').next().unwrap().trim_start_matches(['-', '0', '.']);
            mantissa.chars().filter(char::is_ascii_digit).count()
        };
        prop_assert_eq!(count(&got), digits);
    }

    #[test]
    fn printed_number_is_within_its_bound(m in 0.1..1.0f64, r in 0.0..1.0f64, k in 0..20i32, digits in 1..14usize) {
        let x = ball(m, 0.0, r * 10f64.powi(-k));
        let d = decimal(&x, digits);
        let printed = d.text.parse::<f64>().unwrap();
        prop_assert!((printed - x.lower()).abs() <= d.error_bound * (1.0 + 1e-12) + 1e-15);
        prop_assert!((printed - x.upper()).abs() <= d.error_bound * (1.0 + 1e-12) + 1e-15);
    }
}
