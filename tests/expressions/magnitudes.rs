//! Magnitudes are rounded outward.
#![cfg(feature = "engine")]

use crate::exact;

use dashu_ratio::RBig;
use exact::magnitude;
use librate_core::precision::Magnitude;
use proptest::prelude::*;

fn some() -> impl Strategy<Value = Magnitude> {
    prop_oneof![
        (1.0..2.0f64, -200..200i64).prop_map(|(m, e)| Magnitude::from_f64(m).scale(e)),
        (1.0..2.0f64, -2..2i64).prop_map(|(m, e)| Magnitude::from_f64(m).scale(e)),
        Just(Magnitude::ZERO),
        (-70..70i64).prop_map(Magnitude::power_of_two),
        (-2..2i64).prop_map(|e| Magnitude::from_f64(2.0f64.next_down()).scale(e)),
    ]
}

proptest! {
    #[test]
    fn rounded_the_right_way(x in some(), y in some()) {
        let (a, b) = (magnitude(x), magnitude(y));
        let close = RBig::ONE + exact::double(2e-15);
        let above = |m: Magnitude, value: &RBig| {
            let m = magnitude(m);
            m >= *value && m <= value * &close
        };
        prop_assert!(above(x + y, &(&a + &b)));
        prop_assert!(above(x * y, &(&a * &b)));
        if !y.is_zero() {
            prop_assert!(above(x / y, &(&a / &b)));
        }
        let rest = magnitude(x.sub_down(y));
        let true_rest = if a > b { &a - &b } else { RBig::ZERO };
        prop_assert!(rest <= true_rest && true_rest <= rest + &a * exact::double(1e-15));
        let (high, low) = (magnitude(x.sqrt()), magnitude(x.sqrt_down()));
        prop_assert!(&low * &low <= a && a <= &high * &high && high <= low * &close);
        let low = magnitude(x.add_down(y));
        prop_assert!(low <= &a + &b && &a + &b <= low * &close);
        for m in [x + y, x.add_down(y), x * y, x.sqrt(), x.sub_down(y), x / y] {
            let (mantissa, exponent) = m.parts();
            prop_assert!((1.0..2.0).contains(&mantissa) || exponent == 0);
        }
        prop_assert_eq!(x < y, a < b);
    }
}

#[test]
fn the_ends_of_the_range_are_rounded_up() {
    let tiny = Magnitude::from_f64(1e-300).powi(4);
    assert!(!tiny.is_zero() && tiny.to_f64() == f64::from_bits(1));
    assert!(tiny.powi(u32::MAX).powi(u32::MAX) >= Magnitude::power_of_two(i64::MIN));
    assert!(!tiny.powi(u32::MAX).powi(u32::MAX).is_zero());
    assert!(!Magnitude::from_f64(9.0).powi(u32::MAX).powi(u32::MAX).is_finite());
    assert_eq!(Magnitude::from_f64(5e-324).to_f64(), 5e-324f64.next_up());
    assert_eq!(Magnitude::from_f64(-0.75).to_f64(), 0.75);
    assert!(!Magnitude::from_f64(f64::NAN).is_finite());
}
