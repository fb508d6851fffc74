//! Arithmetic modulo the prime of the identity tests.
#![cfg(feature = "engine")]

use librate::expr::Pool;
use librate::number::Number;
use librate_core::expr::{PRIME, add_mod, fraction_mod, inverse_mod, mul_mod, neg_mod, pow_mod, sqrt_mod, sub_mod};
use librate_core::linearize::nullspace_mod;
use proptest::prelude::*;

fn residue() -> impl Strategy<Value = u64> {
    prop_oneof![0..PRIME, 0..3u64, (1..4u64).prop_map(|k| PRIME - k)]
}

proptest! {
    #[test]
    fn field_operations(a in residue(), b in residue()) {
        let wide = |x: u128| (x % u128::from(PRIME)) as u64;
        prop_assert_eq!(mul_mod(a, b), wide(u128::from(a) * u128::from(b)));
        prop_assert_eq!(add_mod(a, b), wide(u128::from(a) + u128::from(b)));
        prop_assert_eq!(add_mod(sub_mod(a, b), b), a);
        prop_assert_eq!(add_mod(a, neg_mod(a)), 0);
        match inverse_mod(a) {
            Some(inverse) => prop_assert_eq!(mul_mod(a, inverse), 1),
            None => prop_assert_eq!(a, 0),
        }
        prop_assert_eq!(sqrt_mod(mul_mod(a, a)), Some(a.min(neg_mod(a))));
        let is_square = a == 0 || pow_mod(a, (PRIME - 1) / 2) == 1;
        prop_assert_eq!(sqrt_mod(a).is_some(), is_square);
    }

    #[test]
    fn fractions_are_found_again(n in -900_000_000i64..900_000_000, d in 1i64..900_000_000) {
        let fraction = Number::ratio(n, d).unwrap();
        prop_assert_eq!(fraction_mod(fraction.mod_prime(PRIME).unwrap()), Some(fraction));
    }

    #[test]
    fn null_vectors_are_annihilated(
        rows in prop::collection::vec(prop::collection::vec(0..4u64, 0..6), 0..6)
    ) {
        let basis = nullspace_mod(&rows, 6);
        prop_assert_eq!(basis.len() + nullspace_mod(&basis, 6).len(), 6);
        for vector in basis {
            for row in &rows {
                let sum = row.iter().zip(&vector).fold(0, |s, (a, b)| add_mod(s, mul_mod(*a, *b)));
                prop_assert_eq!(sum, 0);
            }
        }
    }
}

#[test]
fn null_space_of_a_difference() {
    let rows = [vec![1, PRIME - 1, 0], vec![0, 1, PRIME - 1]];
    assert_eq!(nullspace_mod(&rows, 3), [[1, 1, 1]]);
    assert_eq!(nullspace_mod(&[], 2), [[1, 0], [0, 1]]);
}

#[test]
fn values_at_a_point() {
    let mut pool = Pool::default();
    let (x, y) = (pool.variable("x"), pool.variable("y"));
    let product = pool.mul(x, y);
    let quotient = pool.div(x, y);
    let at = |value: u64| move |_| value;
    assert_eq!(pool.evaluate_mod(&[product, quotient], at(5), 1), Some(vec![25, 1]));
    assert_eq!(pool.evaluate_mod(&[product, quotient], at(0), 1), None);
    assert_eq!(pool.evaluate_mod(&[product], at(0), 1), Some(vec![0]));
    let point = pool.modular_point(&[product], at(3), 1).unwrap();
    assert!(point.certainty.is_exact());
    let root = pool.sqrt(x);
    assert!(!pool.modular_point(&[root], at(4), 1).unwrap().certainty.is_exact());
}

#[test]
fn pools_go_to_other_threads() {
    fn check<T: Send + Sync + Clone + Default + std::fmt::Debug>() {}
    check::<Pool>();
}

/// 1009, 1013 and 1021 are primes beyond those that are tried as factors: a root of a product of two is the product of the roots of the two.
#[test]
fn roots_of_composite_numbers() {
    use librate::expr::ZeroVerdict;
    let mut pool = Pool::default();
    let mut root = |number: i64| {
        let number = pool.integer(number);
        pool.sqrt(number)
    };
    let (a, b, c) = (root(1009), root(1013), root(1021));
    let (ab, ac, aab) = (root(1009 * 1013), root(1009 * 1021), root(1009 * 1009 * 1013));
    let (over, under) = (pool.div(ab, ac), pool.div(b, c));
    let product = pool.mul(a, b);
    let multiple = pool.scale(b, &Number::from(1009));
    for (one, other) in [(over, under), (ab, product), (aab, multiple)] {
        let (difference, sum) = (pool.sub(one, other), pool.add(one, other));
        assert_eq!(pool.is_zero(difference), ZeroVerdict::Zero, "{}", pool.display(difference));
        assert_ne!(pool.is_zero(sum), ZeroVerdict::Zero, "{}", pool.display(sum));
    }
    let sum = pool.add(ab, b);
    assert_ne!(pool.is_zero(sum), ZeroVerdict::Zero);
    // What is 0 modulo the prime alone.
    let prime = pool.number(Number::parse(&PRIME.to_string()).unwrap());
    let x = pool.variable("x");
    let multiple = pool.mul(prime, x);
    assert_ne!(pool.is_zero(multiple), ZeroVerdict::Zero);
}
