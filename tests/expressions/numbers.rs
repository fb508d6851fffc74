//! Exact rationals against those of another library, doubles and themselves.
#![cfg(feature = "engine")]

use dashu_int::ops::UnsignedAbs;
use dashu_int::{IBig, UBig};
use dashu_ratio::RBig;
use librate::number::Number;
use librate_core::number::TwoDoubles;
use proptest::prelude::*;

fn n(text: &str) -> Number {
    match text.split_once('/') {
        Some((a, b)) => n(a).div(&n(b)).unwrap(),
        None => Number::parse(text).unwrap(),
    }
}

fn fraction(value: &Number) -> RBig {
    RBig::from_parts(value.numerator(), value.denominator())
}

/// Numbers of both representations, many of them at the border between the two.
fn any_number() -> impl Strategy<Value = Number> {
    let part = prop_oneof![
        (-20i128..20),
        any::<i64>().prop_map(i128::from),
        any::<i128>(),
        (-3i128..3).prop_map(|k| i128::from(i64::MAX) + k),
        (-3i128..3).prop_map(|k| i128::from(i64::MIN) + k),
    ];
    (part.clone(), part).prop_filter_map("denominator 0", |(a, b)| {
        Number::from_integer(IBig::from(a)).div(&Number::from_integer(IBig::from(b)))
    })
}

/// What the representation promises.
fn assert_canonical(value: &Number) {
    let fits = value.numerator().unsigned_abs() <= UBig::from(i64::MAX as u64)
        && value.denominator() <= UBig::from(i64::MAX as u64);
    assert_eq!(value.small_parts().is_some(), fits, "{value}");
}

proptest! {
    #[test]
    fn arithmetic_agrees_with_big_fractions(a in any_number(), b in any_number()) {
        let (p, q) = (fraction(&a), fraction(&b));
        let results = [
            (a.add(&b), &p + &q),
            (a.sub(&b), &p - &q),
            (a.mul(&b), &p * &q),
            (a.neg(), -&p),
            (a.floor(), RBig::from(p.floor())),
        ];
        for (ours, theirs) in results {
            assert_canonical(&ours);
            prop_assert_eq!(fraction(&ours), theirs);
        }
        prop_assert_eq!(a.cmp(&b), p.cmp(&q));
        if let Some(quotient) = a.div(&b) {
            assert_canonical(&quotient);
            prop_assert_eq!(quotient.mul(&b), a.clone());
            let rest = a.rem_floor(&b).unwrap();
            prop_assert!(rest.is_zero() || rest.is_negative() == b.is_negative());
            prop_assert!(rest.abs() < b.abs());
            prop_assert!(a.sub(&rest).div(&b).unwrap().is_integer());
        }
        let g = a.gcd(&b);
        if !g.is_zero() {
            let (c, d) = (a.div(&g).unwrap(), b.div(&g).unwrap());
            prop_assert!(c.is_integer() && d.is_integer() && !g.is_negative());
            prop_assert!(c.gcd(&d).is_one());
        }
    }

    #[test]
    fn doubles_round_trip(bits in any::<u64>()) {
        let value = f64::from_bits(bits);
        match Number::from_f64_exact(value) {
            None => prop_assert!(!value.is_finite()),
            Some(exact) => {
                prop_assert_eq!(exact.to_f64(), value);
                prop_assert_eq!(exact.to_double_double(), TwoDoubles { high: value, low: 0.0, error: 0.0 });
            }
        }
    }

    #[test]
    fn conversion_is_correctly_rounded(digits in "[1-9][0-9]{0,30}", exponent in -340i32..310) {
        let text = format!("{digits}e{exponent}");
        prop_assert_eq!(n(&text).to_f64(), text.parse::<f64>().unwrap());
    }

    #[test]
    fn double_doubles_hold_their_bound(a in any_number(), exponent in -400i32..300) {
        let a = a.mul(&Number::from(10).powi(exponent).unwrap());
        let TwoDoubles { high, low, error } = a.to_double_double();
        if high.is_finite() {
            prop_assert_eq!(high, a.to_f64());
            let exact = |x| Number::from_f64_exact(x).unwrap();
            let off = a.sub(&exact(high)).sub(&exact(low)).abs();
            prop_assert!(off <= exact(error));
            prop_assert!(error <= low.abs() * 1.2e-16 + f64::from_bits(1), "{high} {low} {error}");
        } else {
            prop_assert_eq!(error, f64::INFINITY);
        }
    }

    #[test]
    fn text_round_trips(a in any_number()) {
        prop_assert_eq!(n(&a.to_string()), a);
    }

    #[test]
    fn residues(a in any_number(), b in any_number()) {
        const P: u64 = 1_000_000_007;
        if let (Some(x), Some(y), Some(z)) = (a.mod_prime(P), b.mod_prime(P), a.mul(&b).mod_prime(P)) {
            prop_assert_eq!(x * y % P, z);
        }
    }

    #[test]
    fn factors_multiply_back(value in prop_oneof![1i64..5000, 1..i64::MAX], k in 1u32..4) {
        let number = Number::from(value).powi(k as i32).unwrap();
        let product = number.factors().iter().fold(Number::ONE, |product, factor| {
            product.mul(&factor.base.powi(factor.multiplicity as i32).unwrap())
        });
        prop_assert_eq!(product, number);
    }

    #[test]
    fn squares_have_roots(a in any_number()) {
        prop_assert_eq!(a.mul(&a).sqrt_exact(), Some(a.abs()));
    }
}

#[test]
fn literals() {
    for (text, value) in [
        ("2", "2"),
        ("0.5", "1/2"),
        ("-0.25", "-1/4"),
        ("6.02e23", "602000000000000000000000"),
        ("1e-3", "1/1000"),
        ("1E+2", "100"),
        ("007", "7"),
        ("1e00000000000000000000003", "1000"),
    ] {
        assert_eq!(n(text).to_string(), value);
    }
    for text in ["", "-", "1.", ".5", "1e", "1e+", "1x", "1_0", "+1", "--1", "1e30103", "1e-30103", "0x1"] {
        assert_eq!(Number::parse(text), None, "{text}");
    }
    assert!(Number::parse("1e30102").is_some());
    assert!(Number::parse("1e99999999999999999999").is_none());
}

#[test]
fn borders() {
    let max = Number::from(i64::MAX);
    let min = Number::from(i64::MIN);
    assert_eq!(min.to_i64(), Some(i64::MIN));
    assert_eq!(max.add(&Number::ONE).neg(), min);
    assert_eq!(min.add(&Number::ONE).neg(), max);
    assert_eq!(min.abs().to_i64(), None);
    assert_eq!(Number::ratio(i64::MIN, i64::MIN), Some(Number::ONE));
    assert_eq!(Number::ratio(3, -6).unwrap().to_string(), "-1/2");
    assert_eq!(Number::ratio(1, 0), None);
    assert_eq!(Number::ZERO.recip(), None);
    assert_eq!(Number::ZERO.powi(0), Some(Number::ONE));
    assert_eq!(Number::ZERO.powi(-1), None);
    assert_eq!(n("2").powi(i32::MAX), None);
    assert_eq!(n("-1").powi(i32::MIN), Some(Number::ONE));
    assert_eq!(n("-2/3").powi(-3).unwrap().to_string(), "-27/8");
    assert_eq!(n("1/7").mod_prime(7), None);
    assert_eq!(n("-1").mod_prime(7), Some(6));
    assert_eq!(std::mem::size_of::<Number>(), 16);
}

#[test]
fn out_of_range_of_doubles() {
    let TwoDoubles { high, low, error } = n("1e400").to_double_double();
    assert_eq!((high, low, error), (f64::INFINITY, 0.0, f64::INFINITY));
    assert_eq!(n("-1e400").to_double_double().high, f64::NEG_INFINITY);
    let TwoDoubles { high, low, error } = n("1e-400").to_double_double();
    assert_eq!((high, low), (0.0, 0.0));
    assert!(error > 0.0 && error < 1e-300);
}

#[test]
fn decimals() {
    for (value, digits, text) in [
        ("1/3", 4, "0.3333"),
        ("2/3", 4, "0.6667"),
        ("-12.5", 4, "-12.50"),
        ("12.5", 2, "12"),
        ("13.5", 2, "14"),
        ("9.996", 3, "10.0"),
        ("999.6", 3, "1.00e3"),
        ("0", 3, "0.00"),
        ("6.02e23", 3, "6.02e23"),
        ("1e-7", 2, "1.0e-7"),
        ("1e-6", 2, "0.0000010"),
        ("1", 1, "1"),
        ("1e-300", 1, "1e-300"),
    ] {
        assert_eq!(n(value).to_decimal(digits), text, "{value}");
    }
}

#[test]
fn factors_are_what_they_say() {
    let show = |value: &str| {
        let factors = n(value).factors();
        factors.iter().map(|f| format!("{}^{}", f.base, f.multiplicity)).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(show("1"), "");
    assert_eq!(show("360"), "2^3 3^2 5^1");
    assert_eq!(show("994009"), "997^2");
    assert_eq!(show("1018081"), "1009^2");
    assert_eq!(show("1000000016000000063"), "1000000016000000063^1");
    let huge = n("1009").powi(100).unwrap().mul(&n("2").powi(77).unwrap());
    assert_eq!(show(&huge.to_string()), "2^77 1009^100");
}
