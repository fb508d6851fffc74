//! Sums of products of mirrored rows, of all numbers that have their own.
#![cfg(feature = "engine")]

use crate::exact;

use dashu_ratio::RBig;
use librate::precision::{Ball, Scalar};
use librate_core::precision::{DoubleDouble, LANES, Lane, two_prod, two_sum};
use proptest::prelude::*;

/// One product after the other.
fn one_by_one(left: &[Ball], right: &[Ball]) -> Option<Ball> {
    let products = left.iter().zip(right.iter().rev());
    products.map(|(x, y)| *x * *y).reduce(|sum, x| sum + x)
}

/// Four sums of every fourth product each, without vector instructions: to give the same bits as with them.
fn side_by_side(left: &[DoubleDouble], right: &[DoubleDouble]) -> DoubleDouble {
    let mut sums = [(0.0, 0.0); 4];
    for (j, (x, y)) in left.iter().zip(right.iter().rev()).enumerate() {
        let (high, low) = &mut sums[j % 4];
        let (product, error) = two_prod(x.hi, y.hi);
        let (sum, lost) = two_sum(*high, product);
        *high = sum;
        *low += lost + (error + (x.hi * y.lo + x.lo * y.hi));
    }
    let [a, b, c, d] = sums.map(|(high, low)| DoubleDouble::new(high, low));
    (a + b) + (c + d)
}

#[test]
fn exact_sums_stay_exact_and_what_is_out_of_range_is_left() {
    let whole: Vec<Ball> = (0..9).map(|k| Ball::exact(f64::from(k))).collect();
    assert_eq!(Ball::convolution(&whole, &whole), Some(Ball::exact(84.0)));
    assert_eq!(Ball::convolution(&[Ball::ZERO; 5], &whole[..5]), Some(Ball::ZERO));
    // What is 0 exactly stays so beside anything, and radii that get lost in a product do not.
    let doubtful = vec![Ball::new(DoubleDouble::ONE, 1e-20); 6];
    assert_eq!(Ball::convolution(&[Ball::ZERO; 6], &doubtful), Some(Ball::ZERO));
    let small = vec![Ball::new(DoubleDouble::exact(1e-140), 1e-200); 6];
    let smaller = vec![Ball::exact(1e-140); 6];
    assert!(Ball::convolution(&small, &smaller).unwrap().radius > 0.0);
    for odd in [Ball::exact(1e-200), Ball::exact(1e200), Ball::NOT_FINITE] {
        let mut row = whole.clone();
        row[3] = odd;
        let found = Ball::convolution(&row, &whole).unwrap();
        assert_eq!(found.is_finite(), odd.is_finite());
        if odd.is_finite() {
            assert_eq!(found, one_by_one(&row, &whole).unwrap());
        }
    }
}

fn rows() -> impl Strategy<Value = Vec<(DoubleDouble, DoubleDouble)>> {
    let number = (-1.0..1.0f64, -1.0..1.0f64, -20..20i32)
        .prop_map(|(a, b, e)| DoubleDouble::new(a, b * a * f64::EPSILON / 2.0).scale(e));
    let other = (-1.0..1.0f64, -1.0..1.0f64).prop_map(|(a, b)| DoubleDouble::new(a, b * a * f64::EPSILON / 2.0));
    prop::collection::vec((number, other), 0..40)
}

proptest! {
    #[test]
    fn convolutions_of_balls_enclose(
        rows in rows(),
        radii in prop::collection::vec((0..4usize, 0..4usize, -1.0..=1.0f64, -1.0..=1.0f64), 40),
    ) {
        let sizes = [0.0, 1e-30, 1e-12, 0.5];
        let mut exact = RBig::ZERO;
        let (mut left, mut right) = (Vec::new(), Vec::new());
        for ((x, y), (r, s, t, v)) in rows.iter().zip(&radii) {
            let (x, y) = (Ball::new(*x, sizes[*r]), Ball::new(*y, sizes[*s]));
            let inside = |ball: &Ball, share: f64| {
                exact::double_double(ball.mid) + exact::double(ball.radius) * exact::double(share)
            };
            exact += inside(&x, *t) * inside(&y, *v);
            left.push(x);
            right.push(y);
        }
        right.reverse();
        let found = Ball::convolution(&left, &right);
        prop_assert_eq!(found.is_none(), left.is_empty());
        let Some(found) = found else { return Ok(()) };
        let off = exact::absolute(exact::double_double(found.mid) - exact);
        prop_assert!(off <= exact::double(found.radius));
        // Hardly wider than one product after the other.
        let simple = one_by_one(&left, &right).unwrap();
        let products = left.iter().zip(right.iter().rev());
        let sum: f64 = products.map(|(x, y)| (x.mid.hi * y.mid.hi).abs()).sum();
        prop_assert!(found.radius <= simple.radius * (1.0 + 1e-9) + 10.0 * f64::EPSILON * f64::EPSILON * sum + 1e-300);
        if left.len() >= 4 {
            let mids = |row: &[Ball]| row.iter().map(|x| x.mid).collect::<Vec<DoubleDouble>>();
            prop_assert_eq!(found.mid, side_by_side(&mids(&left), &mids(&right)));
        }
    }

    #[test]
    fn convolutions_are_sums_of_mirrored_products(rows in rows()) {
        let (left, right): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
        let products = || left.iter().zip(right.iter().rev());
        let mut exact = RBig::ZERO;
        let mut sum = RBig::ZERO;
        for (x, y) in products() {
            let product = exact::double_double(*x) * exact::double_double(*y);
            exact += &product;
            sum += exact::absolute(product);
        }
        let found = DoubleDouble::convolution(&left, &right);
        prop_assert_eq!(found.is_none(), left.is_empty());
        if let Some(found) = found {
            // 40 terms, each of which costs some units of u² of the sum of magnitudes.
            let u2 = exact::double(f64::EPSILON * f64::EPSILON / 4.0);
            prop_assert!(exact::absolute(exact::double_double(found) - &exact) <= u2 * RBig::from(100) * &sum);
            if left.len() >= 4 {
                prop_assert_eq!(found, side_by_side(&left, &right));
            }
        }
        // In doubles, one row or eight.
        let doubles = |row: &[DoubleDouble]| row.iter().map(|x| x.hi).collect::<Vec<f64>>();
        let (left, right) = (doubles(&left), doubles(&right));
        let plain = f64::convolution(&left, &right);
        prop_assert_eq!(plain.is_none(), left.is_empty());
        let lanes = |row: &[f64]| row.iter().map(|x| Lane::splat(*x)).collect::<Vec<Lane>>();
        let lanes = Lane::convolution(&lanes(&left), &lanes(&right));
        if let (Some(plain), Some(lanes)) = (plain, lanes) {
            let simple = left.iter().zip(right.iter().rev()).fold(0.0, |sum, (x, y)| sum + x * y);
            prop_assert_eq!(lanes.0, [simple; LANES]);
            let products = left.iter().zip(right.iter().rev());
            let sum: f64 = products.map(|(x, y)| (x * y).abs()).sum();
            prop_assert!((plain - simple).abs() <= 80.0 * f64::EPSILON * sum);
        }
    }
}
