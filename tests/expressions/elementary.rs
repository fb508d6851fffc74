//! Elementary functions of balls against values computed elsewhere.
#![cfg(feature = "engine")]

use crate::exact;

use librate::precision::Ball;
use librate_core::precision::DoubleDouble;

/// Values with 60 digits computed outside (mpmath), arguments as exact doubles.
#[test]
fn functions_enclose_reference_values() {
    for line in include_str!("../reference/elementary.txt").lines() {
        let fields: Vec<&str> = line.split(' ').collect();
        let number = |k: usize| fields[k].parse::<f64>().unwrap();
        let x = Ball::from(DoubleDouble { hi: number(1), lo: number(2) });
        let y = Ball::from(DoubleDouble { hi: number(3), lo: number(4) });
        let value = exact::decimal(fields[5]);
        let distance = |got: &Ball| exact::absolute(exact::double_double(got.mid) - &value);
        let got = exact::apply(fields[0], &x, &y);
        assert!(distance(&got) <= exact::double(got.radius), "{line}: {got:?}");
        let relative = got.radius / got.mid.hi.abs();
        let limit = if fields[0] == "pow" { 2e-28 } else { 2.5e-30 };
        assert!(relative < limit || got.radius < 1e-60, "{line}: {relative:e}");
        // A wide argument: its value at a point inside must be enclosed too.
        for r in [1e-20, 1e-6, 0.3] {
            let off = DoubleDouble::exact(r * 0.75 * x.mid.hi);
            let wide = Ball::new(x.mid + off, r * x.mid.hi.abs());
            let got = exact::apply(fields[0], &wide, &y);
            if got.is_finite() {
                assert!(distance(&got) <= exact::double(got.radius), "wide {r:e} {line}: {got:?}");
            }
        }
    }
}

#[test]
fn domains_end_without_panic() {
    assert!(!Ball::exact(0.0).ln().is_finite());
    assert!(!Ball::exact(-1.0).ln().is_finite());
    assert!(!Ball::exact(1.5).asin().is_finite());
    assert!(!Ball::exact(-1.5).acos().is_finite());
    assert!(!Ball::exact(1e4).exp().is_finite());
    assert!(Ball::exact(-1e4).exp().abs_upper() < 1e-280);
    assert_eq!(Ball::exact(1e300).sin().radius, 1.0);
    assert!(!Ball::NOT_FINITE.sin().is_finite() && !Ball::NOT_FINITE.atan().is_finite());
    assert!(!Ball::NOT_FINITE.tanh().is_finite() && !Ball::NOT_FINITE.pow(&Ball::ONE).is_finite());
    let one = Ball::new(DoubleDouble::ONE, 1e-30);
    assert!(one.acos().is_finite() && one.asin().is_finite() && one.acos().contains_zero());
    assert_eq!(Ball::ZERO.cos(), Ball::ONE);
    assert_eq!(Ball::ZERO.sin(), Ball::ZERO);
    assert_eq!(Ball::ZERO.asin(), Ball::ZERO);
    assert_eq!(Ball::ZERO.pow(&Ball::exact(2.5)), Ball::ZERO);
}
