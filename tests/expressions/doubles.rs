//! Double-double arithmetic against exact rationals.
#![cfg(feature = "engine")]

use crate::exact;

use dashu_ratio::RBig;
use exact::absolute;
use librate_core::precision::{DoubleDouble, two_prod};
use proptest::prelude::*;

fn within(got: DoubleDouble, exact: &RBig, ulps: f64) -> bool {
    let error = exact::double_double(got) - exact;
    let bound = exact::double(ulps * 2f64.powi(-106)) * exact;
    absolute(error) <= absolute(bound) && got.hi == got.hi + got.lo
}

fn anything() -> impl Strategy<Value = DoubleDouble> {
    (-1.0..1.0f64, -1.0..1.0f64, -90..90i32)
        .prop_map(|(a, b, e)| DoubleDouble::new(a, b * a * f64::EPSILON / 2.0).scale(e))
}

proptest! {
    #[test]
    fn products_split_exactly(a in -1e100..1e100f64, b in -1e100..1e100f64) {
        let (p, e) = two_prod(a, b);
        prop_assert_eq!(e, a.mul_add(b, -p));
    }

    #[test]
    fn four_operations_keep_their_bounds(x in anything(), y in anything()) {
        let (a, b) = (exact::double_double(x), exact::double_double(y));
        prop_assert!(within(x + y, &(&a + &b), 3.01));
        prop_assert!(within(x - y, &(&a - &b), 3.01));
        prop_assert!(within(x * y, &(&a * &b), 5.01));
        if y.hi != 0.0 {
            prop_assert!(within(x / y, &(&a / &b), 15.01));
        }
        let root = x.abs().sqrt();
        let square = exact::double_double(root) * exact::double_double(root);
        let size = absolute(a);
        prop_assert!(square >= &size * exact::double(1.0 - 7.0 * 2f64.powi(-53)));
        let error = absolute(square - &size);
        prop_assert!(error <= size * exact::double(6.3 * 2f64.powi(-106)));
    }
}

#[test]
fn extremes_divide_and_root_cleanly() {
    let tiny = DoubleDouble::exact(1e-310);
    assert_eq!((tiny / tiny).hi, 1.0);
    assert_eq!((DoubleDouble::exact(4e-300) / DoubleDouble::exact(2e-300)).hi, 2.0);
    assert_eq!(DoubleDouble::exact(2f64.powi(-1000)).sqrt().hi, 2f64.powi(-500));
    assert_eq!(DoubleDouble::exact(2f64.powi(980)).sqrt().hi, 2f64.powi(490));
    assert!(!(DoubleDouble::ONE / DoubleDouble::ZERO).is_finite());
    assert!(DoubleDouble::exact(-1.0).sqrt().hi.is_nan());
}
