//! Balls against exact rationals.
#![cfg(feature = "engine")]

use crate::exact;

use dashu_ratio::RBig;
use librate::number::Number;
use librate::precision::{Ball, Scalar};
use librate_core::precision::DoubleDouble;
use proptest::prelude::*;

fn contains(ball: &Ball, value: &RBig) -> bool {
    let low = exact::double_double(ball.mid) - exact::double(ball.radius);
    let high = exact::double_double(ball.mid) + exact::double(ball.radius);
    low <= *value && *value <= high && exact::double(ball.lower()) <= low && high <= exact::double(ball.upper())
}

/// A ball and a number in it.
fn inhabited() -> impl Strategy<Value = (Ball, RBig)> {
    let radii = prop_oneof![Just(0.0), Just(1e-32), Just(1e-20), Just(1e-3), Just(3.0)];
    let scales = prop_oneof![Just(-300), Just(-40), Just(0), Just(0), Just(37), Just(200)];
    let small = prop_oneof![Just(0.0), Just(1.0)];
    (-8.0..8.0f64, -1.0..1.0f64, small, radii, -1.0..=1.0f64, scales).prop_map(|(a, b, l, r, t, e)| {
        let mid = DoubleDouble::new(a, a * b * l * f64::EPSILON / 2.0).scale(e);
        let ball = Ball::new(mid, r * 2f64.powi(e));
        let number = exact::double_double(mid) + exact::double(ball.radius) * exact::double(t);
        (ball, number)
    })
}

proptest! {
    #[test]
    fn operations_enclose((x, a) in inhabited(), (y, b) in inhabited()) {
        prop_assert!(contains(&(x + y), &(&a + &b)));
        prop_assert!(contains(&(x - y), &(&a - &b)));
        prop_assert!(contains(&(x * y), &(&a * &b)));
        prop_assert!(contains(&x.hull(&y), &a) && contains(&x.hull(&y), &b));
        let quotient = x / y;
        if quotient.is_finite() {
            prop_assert!(contains(&quotient, &(&a / &b)));
        } else {
            prop_assert!(y.contains_zero() || y.mid.hi.abs() < 1e-290 || x.mid.hi.abs() > 1e50);
        }
        let square = x.powi(2);
        prop_assert!(contains(&square, &(&a * &a)));
        let size = exact::absolute(a);
        prop_assert!(contains(&x.abs(), &size));
        let root = x.abs().sqrt();
        let (low, high) = (exact::double(root.lower().max(0.0)), exact::double(root.upper()));
        prop_assert!(&low * &low <= size && size <= &high * &high);
    }
}

#[test]
fn exact_data_stay_exact() {
    let x = Ball::exact(3.0);
    assert!((x * x + Ball::exact(0.5)).is_exact());
    assert_eq!((Ball::exact(6.0) / x), Ball::exact(2.0));
    assert_eq!(Ball::exact(9.0).sqrt(), x);
    assert_eq!(x.powi(-1).powi(-1).mid_f64(), 3.0);
    assert_eq!(Ball::exact(2.0).powi(-3), Ball::exact(0.125));
}

#[test]
fn leaving_the_domain_is_not_finite() {
    assert!(!(Ball::ONE / Ball::exact(0.0)).is_finite());
    assert!(!(Ball::ONE / Ball::new(DoubleDouble::ONE, 1.0)).is_finite());
    assert!(!Ball::exact(-1.0).sqrt().is_finite());
    assert!(!Ball::exact(1e200).powi(2).is_finite());
    let near_zero = Ball::new(DoubleDouble::exact(-1e-20), 1e-19).sqrt();
    assert!(near_zero.lower() <= 0.0 && near_zero.upper() >= 3e-10);
    assert!(!(Ball::NOT_FINITE + Ball::ONE).is_finite());
    assert!(!(Ball::NOT_FINITE * Ball::ZERO).is_finite());
    assert!(Ball::NOT_FINITE.contains_zero() && !Ball::NOT_FINITE.is_positive());
}

#[test]
fn angles_of_the_axes_are_in_the_half_open_range() {
    let pi = std::f64::consts::PI;
    assert_eq!(Scalar::atan2(&-0.0, &-1.0), pi);
    assert_eq!(Scalar::atan2(&Ball::ZERO, &Ball::exact(-1.0)).mid_f64(), pi);
    assert!(!Scalar::is_finite(&Scalar::atan2(&0.0, &0.0)));
    assert!(!Scalar::is_finite(&Scalar::atan2(&Ball::ZERO, &Ball::ZERO)));
}

#[test]
fn exact_numbers_stay_exact() {
    assert_eq!(Ball::from_number(&Number::from(7), ()), Ball::exact(7.0));
    assert_eq!(f64::from_number(&Number::from(-7), ()), -7.0);
}
