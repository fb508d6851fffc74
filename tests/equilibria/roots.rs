//! Matrices whose entries are combinations of square roots, exactly.
#![cfg(feature = "engine")]

use crate::common;

use librate::linearize::{Linearized, linearize};
use librate::number::Number;
use librate::precision::Big;
use librate_core::precision::Integers;

const BITS: usize = 200;

/// One oscillator, its K as given.
fn oscillator(stiffness: &str) -> Linearized {
    linearize(common::model(&format!(
        "param a = 2  param b = 3  param c = 5  coord x  T = 1/2*x'^2  V = 1/2*({stiffness})*x^2"
    )))
    .unwrap()
}

/// K/M of its whole entries, with a root for each of `roots`.
fn quotient(found: &Integers) -> Big {
    let whole = |part: usize| {
        let entries = found.matrices[part].iter().enumerate();
        entries.fold(Big::zero(BITS), |sum, (subset, entry)| {
            let own = found.roots.iter().enumerate();
            let own = own.filter(|(k, _)| subset >> k & 1 == 1);
            let product =
                own.fold(Big::one(BITS), |product, (_, root)| &product * &Big::from_parts(root.clone(), 0, BITS));
            &sum + &(&Big::from_parts(entry.clone(), 0, BITS) * &product.sqrt())
        })
    };
    &(&whole(2) / &whole(0)) * &found.rate.value(BITS).powi(2)
}

#[test]
fn sums_of_roots_are_a_field() {
    for (stiffness, value, roots) in [
        ("1/(1 + sqrt(a) + sqrt(b))", 1.0 / (1.0 + 2f64.sqrt() + 3f64.sqrt()), 2),
        ("(1 + sqrt(a) + sqrt(b))/(1 + sqrt(b) + sqrt(2))", 1.0, 0),
        ("(1 + sqrt(a) + sqrt(b))^-3*(1 + sqrt(2) + sqrt(b))^3", 1.0, 0),
        // 5 + 2√6
        ("(sqrt(a) + sqrt(b))^2", 5.0 + 24f64.sqrt(), 1),
        ("(sqrt(a) + sqrt(b))^2 - sqrt(24)", 5.0, 0),
        // The golden ratio.
        ("((1 + sqrt(c))/2)^2 - (1 + sqrt(5))/2", 1.0, 0),
        ("(1 + sqrt(c))/2 - sqrt(a)", (1.0 + 5f64.sqrt()) / 2.0 - 2f64.sqrt(), 2),
        // Roots have the least order.
        ("1 + (4*a)^(1/6)/sqrt(2)", 2.0, 0),
        ("((4*b)^(1/4))^4", 12.0, 0),
        ("(3*b)^(1/4)*sqrt(3) + c", 8.0, 0),
        ("a^(1/3)*4^(1/3)", 2.0, 0),
        ("sqrt(sqrt(b))^-4*9", 3.0, 0),
        ("abs(sqrt(a) - sqrt(b))", 3f64.sqrt() - 2f64.sqrt(), 1),
        ("abs(sqrt(a) - sqrt(b)) + sqrt(2) - sqrt(3) + 1", 1.0, 0),
        // √2, √6, √12 and √50 are combinations of two.
        ("sqrt(a) + sqrt(2*b) + sqrt(4*b) + sqrt(10*c)", 2f64.sqrt() + 6f64.sqrt() + 12f64.sqrt() + 50f64.sqrt(), 2),
    ] {
        let linearized = oscillator(stiffness);
        let found = linearized.integers().unwrap();
        assert_eq!(found.roots.len(), roots, "{stiffness}: {found:?}");
        let own = quotient(&found);
        let entry = Big::from_ball(&linearized.stiffness()[0], BITS);
        assert!((&own - &entry).contains_zero(), "{stiffness}: {found:?}");
        assert!((own.mid_f64() - value).abs() < 1e-14, "{stiffness}: {found:?}");
    }
    let third = Number::ratio(1, 3).unwrap();
    let whole = oscillator("1/b").integers().unwrap();
    assert!((&quotient(&whole) - &Big::from_number(&third, BITS)).contains_zero());
    // Cube roots are no combinations of square roots.
    for stiffness in ["1 + a^(1/3)", "sqrt(a) + a^(1/3)"] {
        assert!(oscillator(stiffness).integers().is_none(), "{stiffness}");
    }
}
