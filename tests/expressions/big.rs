//! Numbers of any precision against exact rationals, balls, outside references and themselves.
#![cfg(feature = "engine")]

use crate::exact;

use dashu_int::IBig;
use dashu_ratio::RBig;
use exact::{absolute, magnitude};
use librate::number::Number;
use librate::precision::{Ball, Big, Rounding, Scalar};
use librate_core::precision::DoubleDouble;
use librate_core::precision::Magnitude;
use proptest::prelude::*;

fn mid(x: &Big) -> RBig {
    let (significand, exponent) = x.mid();
    RBig::from(significand.clone()) * exact::power_of_two(exponent)
}

fn contains(x: &Big, exact: &RBig) -> bool {
    x.is_finite() && absolute(mid(x) - exact) <= magnitude(x.radius())
}

/// Whether all of `inner` is inside `outer`; so it is where nothing is known.
fn covers(outer: &Big, inner: &Big) -> bool {
    if !outer.is_finite() {
        return true;
    }
    let distance = absolute(mid(outer) - mid(inner));
    distance + magnitude(inner.radius()) <= magnitude(outer.radius())
}

/// A number of some precision and an exact one in it.
fn inhabited() -> impl Strategy<Value = (Big, RBig)> {
    let radii = prop_oneof![
        Just(Magnitude::ZERO),
        Just(Magnitude::ZERO),
        Just(Magnitude::from_f64(1e-40)),
        Just(Magnitude::from_f64(1e-12)),
        Just(Magnitude::from_f64(0.3)),
    ];
    let scales = prop_oneof![Just(0i64), Just(0), Just(-900), Just(77), Just(3000)];
    let lengths = prop_oneof![Just(53usize), Just(64), Just(100), Just(200), Just(350)];
    (any::<i128>(), any::<i64>(), radii, -1.0..=1.0f64, scales, lengths, 0..120u32).prop_map(
        |(a, b, r, t, e, bits, shorter)| {
            let significand = IBig::from(a >> shorter) * IBig::from(b);
            let x = Big::from_parts(significand, e - 190 + i64::from(shorter), bits).center();
            let x = x.with_added_radius(r.scale(e));
            let exact = mid(&x) + magnitude(x.radius()) * RBig::try_from(t).unwrap();
            (x, exact)
        },
    )
}

proptest! {
    #[test]
    fn operations_enclose((x, a) in inhabited(), (y, b) in inhabited()) {
        prop_assert!(contains(&(&x + &y), &(&a + &b)));
        prop_assert!(contains(&(&x - &y), &(&a - &b)));
        prop_assert!(contains(&(&x * &y), &(&a * &b)));
        prop_assert!(contains(&x.hull(&y), &a) && contains(&x.hull(&y), &b));
        prop_assert!(contains(&x.clone().with_bits(60), &a));
        let quotient = &x / &y;
        if quotient.is_finite() {
            prop_assert!(contains(&quotient, &(&a / &b)));
        } else {
            prop_assert!(y.contains_zero());
        }
        prop_assert!(contains(&x.powi(3), &(&a * &a * &a)));
        let size = absolute(a.clone());
        prop_assert!(contains(&x.abs(), &size));
        let root = x.abs().sqrt();
        let (low, high) = (mid(&root) - magnitude(root.radius()), mid(&root) + magnitude(root.radius()));
        prop_assert!(&high * &high >= size && (low < RBig::ZERO || &low * &low <= size));
        prop_assert!(!x.is_positive() || a > RBig::ZERO);
        prop_assert!(!x.is_negative() || a < RBig::ZERO);
        prop_assert!(x.is_positive() || x.is_negative() || x.contains_zero());
        prop_assert!(magnitude(x.abs_lower()) <= size && size <= magnitude(x.abs_upper()));
        let ball = x.to_ball();
        if ball.is_finite() {
            prop_assert!(contains(&Big::from_ball(&ball, 400), &a));
            let slack = ball.radius - x.radius().to_f64();
            prop_assert!(slack <= 1e-31 * ball.mid.hi.abs() + 1e-13 * ball.radius + 1e-267);
        } else {
            prop_assert!(x.abs_upper() > Magnitude::power_of_two(900));
        }
    }

    /// What both types make of the same doubles has to overlap.
    #[test]
    fn agrees_with_balls(a in -3.0..3.0f64, b in 0.1..3.0f64, r in prop_oneof![Just(0.0), Just(1e-20), Just(1e-3)]) {
        let (x, y) = (Ball::new(DoubleDouble::exact(a), r), Ball::exact(b));
        let (p, q) = (Big::from_ball(&x, 160), Big::from_ball(&y, 160));
        let unit = Ball::exact(a / 3.1).with_added_radius(r);
        let pairs = [
            (x + y, &p + &q), (x * y, &p * &q), (x / y, &p / &q), (x.sin(), p.sin()),
            (x.cos(), p.cos()), (x.tan(), p.tan()), (x.atan(), p.atan()), (x.exp(), p.exp()),
            (y.ln(), q.ln()), (x.sinh(), p.sinh()), (x.cosh(), p.cosh()), (x.tanh(), p.tanh()),
            (x.atan2(&y), p.atan2(&q)), (y.atan2(&x), q.atan2(&p)), (y.pow(&x), q.pow(&p)),
            (unit.asin(), Big::from_ball(&unit, 160).asin()),
            (unit.acos(), Big::from_ball(&unit, 160).acos()), (y.sqrt(), q.sqrt()),
        ];
        for (number, (ball, big)) in pairs.iter().enumerate() {
            prop_assert_eq!(ball.is_finite(), big.is_finite(), "{} {:?} {:?}", number, ball, big);
            if ball.is_finite() {
                let gap = &Big::from_ball(ball, 200) - big;
                prop_assert!(gap.contains_zero(), "{} {:?} {:?}", number, ball, big);
                if r == 0.0 {
                    prop_assert!(big.radius().to_f64() <= 1e-45 * (1.0 + big.mid_f64().abs()));
                }
            }
        }
    }
}

/// At every precision the functions hold the references (60 digits, mpmath) and each other; wide
/// arguments hold the values inside.
#[test]
fn functions_enclose_references_and_higher_precision() {
    let mut decided = 0;
    for line in include_str!("../reference/elementary.txt").lines() {
        let fields: Vec<&str> = line.split(' ').collect();
        let number = |k: usize| fields[k].parse::<f64>().unwrap();
        let argument = |high: usize, low: usize, bits: usize| {
            &Big::from_f64(number(high), bits) + &Big::from_f64(number(low), bits)
        };
        let at = |bits: usize| exact::apply(fields[0], &argument(1, 2, bits), &argument(3, 4, bits));
        let reference = exact::decimal(fields[5]);
        let close = absolute(reference.clone()) * exact::decimal("1e-59");
        let best = at(400);
        assert!(best.is_finite(), "{line}");
        assert!(absolute(mid(&best) - &reference) <= close + magnitude(best.radius()), "{line}");
        for bits in [60, 120, 250] {
            let some = at(bits);
            assert!(covers(&some, &best), "{line} at {bits}: {some:?}");
            decided += usize::from(some.is_finite());
        }
        // Arguments of 120 bits or less are exact at 400.
        let relative = magnitude(best.radius());
        assert!(relative <= absolute(mid(&best)) * exact::power_of_two(-395), "{line}: {best:?}");
        for r in [1e-30, 1e-9, 0.2] {
            let x = argument(1, 2, 120);
            let off = Big::from_f64(r * 0.75 * number(1), 120);
            let wide = (&x + &off).with_added_radius(Magnitude::from_f64(r * number(1)));
            let got = exact::apply(fields[0], &wide, &argument(3, 4, 120));
            assert!(covers(&got, &best), "wide {r:e} {line}: {got:?}");
            decided += usize::from(got.is_finite());
        }
    }
    assert!(decided > 2600, "{decided} of 2778");
}

#[test]
fn extremes_are_enclosed_or_refused_without_panic() {
    let big = |digits: i64| Big::one(100).scale(digits);
    for x in [
        big(400_000),
        big(1 << 39),
        big(-400_000),
        big(-(1 << 39)),
        big(20_000),
        -&big(1 << 39),
        big(-200),
        big(33),
        -&big(33),
        Big::not_finite(100),
        Big::zero(100),
        Big::zero(100).with_added_radius(Magnitude::power_of_two(1 << 41)),
        Big::one(100).with_added_radius(Magnitude::power_of_two(-(1 << 41))),
        Big::one(100).with_added_radius(Magnitude::power_of_two(-90)),
        Big::from_f64(-0.75, 2),
        Big::from_f64(1e300, 1),
        Big::from_f64(3.0, 0),
    ] {
        for y in [big(3), big(1 << 39), big(-(1 << 39)), Big::zero(100), -&big(0)] {
            for name in [
                "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "ln", "pow",
                "sqrt",
            ] {
                let got = exact::apply(name, &x, &y);
                assert!(got.is_finite() || x.bits() <= 100, "{name}");
            }
            let _ = (&x + &y, &x * &y, &x / &y, x.powi(i32::MAX), x.powi(-7), x.to_ball());
            let _ = (x.hull(&y), x.mid_f64(), x.decimal(20), x.abs(), x.scale(i64::MAX));
        }
    }
    assert_eq!(big(400_000).sin().radius(), Magnitude::ONE);
    assert!(!big(400_000).tan().is_finite() && !big(31).exp().is_finite());
    assert!(covers(&big(400_000).atan(), &big(400_000).with_bits(200).atan()));
    assert!(big(20_000).ln().is_finite() && big(1 << 39).ln().is_finite());
    assert!((-&big(31)).exp().abs_upper() <= Magnitude::power_of_two(1 - (1 << 30)));
    for r in [0.3, 7.5] {
        let wide = Big::zero(80).with_added_radius(Magnitude::from_f64(r)).exp();
        assert!(wide.is_finite() && wide.abs_upper().to_f64() >= r.exp());
    }
    assert!(!Big::from_f64(f64::NAN, 53).is_finite() && !Big::not_finite(53).sin().is_finite());
    assert!(!Big::not_finite(53).center().is_finite() && Big::not_finite(53).contains_zero());
    let one = Big::one(90).with_added_radius(Magnitude::from_f64(1e-25));
    assert!(one.acos().contains_zero() && one.asin().is_finite());
    assert!(!Big::from_f64(1.5, 90).asin().is_finite() && !Big::from_f64(-1.5, 90).acos().is_finite());
    assert!(!(&Big::one(90) / &Big::zero(90)).is_finite());
}

#[test]
fn exact_data_stay_exact() {
    let three = Big::from_number(&Number::from(3), 100);
    let eighth = Big::from_number(&Number::ratio(-5, 8).unwrap(), 100);
    assert!((&(&three * &three) + &eighth).is_exact());
    assert!((&(&three * &three).sqrt() - &three).is_zero());
    assert!((&(&Big::from_f64(6.0, 100) / &three) - &Big::from_f64(2.0, 100)).is_zero());
    assert!((&three.powi(-1).powi(-1) - &three).contains_zero());
    assert!(Big::zero(80).sin().is_zero() && Big::one(80).ln().is_zero());
    assert!(Big::zero(80).exp().is_exact() && Big::one(80).acos().contains_zero());
    // Radii far below doubles: 2^-2000 is not 0.
    let thin = Big::one(4000).with_added_radius(Magnitude::power_of_two(-2000));
    assert!(!thin.is_exact() && (&thin - &Big::one(4000)).contains_zero());
    assert!((&thin - &Big::from_parts(IBig::from(3), -1999, 4000)).is_positive());
    assert_eq!(thin.to_ball().radius, f64::from_bits(1));
}

#[test]
fn digits_are_printed_as_many_as_wanted() {
    let text = |x: &Big, digits| x.decimal(digits).text;
    let pi = Big::pi(3400);
    assert!(text(&pi, 1001).ends_with("6111959092164201989"));
    assert_eq!(text(&pi, 31), "3.141592653589793238462643383280");
    let short = Big::pi(64).decimal(40);
    assert_eq!((short.rounding, short.text.as_str()), (Rounding::Fewer, "3.14159265358979324"));
    assert_eq!(text(&Big::from_f64(-0.125, 60), 5), "-0.12500");
    assert_eq!(text(&Big::from_f64(1e22, 80), 3), "1.00e22");
    let tie = Big::from_f64(0.125, 80).with_added_radius(Magnitude::from_f64(1e-30));
    assert_eq!(tie.decimal(2).rounding, Rounding::Tie);
    let tiny = Big::one(80).scale(-4000);
    let d = tiny.decimal(3);
    assert_eq!((d.text.as_str(), d.error_bound), ("7.59e-1205", f64::from_bits(1)));
    let nothing = Big::zero(80).with_added_radius(Magnitude::power_of_two(-5000)).decimal(3);
    assert_eq!((nothing.text.as_str(), nothing.rounding), ("0", Rounding::Undecided));
    assert!(nothing.error_bound > 0.0);
    assert_eq!(Big::not_finite(80).decimal(3).text, "nan");
    assert_eq!(Big::one(80).scale(1 << 30).decimal(3).rounding, Rounding::Undecided);
    assert_eq!(text(&Big::one(80).scale(-(1 << 30)), 3), "0");
}

#[test]
fn convolutions_enclose_sums_of_products() {
    let number = |k: i64| Number::ratio(7 * k - 40, 3 + k * k).unwrap();
    for (bits, many) in [(60, 1), (90, 5), (200, 40)] {
        let row = |shift: i64| -> Vec<Big> {
            let numbers = (0..many).map(|k| Big::from_number(&number(k + shift), bits));
            // Some of very different size.
            numbers.enumerate().map(|(k, x)| if k % 7 == 3 { x.scale(-150) } else { x }).collect()
        };
        let (left, right) = (row(0), row(5));
        let found = Big::convolution(&left, &right).unwrap();
        let exact = |shift: i64, k: i64| {
            let x = Big::from_number(&number(k + shift), 2000);
            if k % 7 == 3 { x.scale(-150) } else { x }
        };
        let sum = (0..many).fold(Big::zero(2000), |sum, k| &sum + &(&exact(0, k) * &exact(5, many - 1 - k)));
        assert!((&found - &sum).contains_zero());
        // A few roundings of the largest products, and no more.
        let sizes = left.iter().zip(right.iter().rev());
        let size = sizes.fold(Magnitude::ZERO, |sum, (x, y)| sum + x.abs_upper() * y.abs_upper());
        assert!(found.radius() < size.scale(2 - bits as i64));
    }
    let whole: Vec<Big> = (0..6).map(|k| Big::from_number(&Number::from(k), 80)).collect();
    let sum = Big::convolution(&whole, &whole).unwrap();
    assert!((&sum - &Big::from_f64(20.0, 80)).is_zero());
    assert!(Big::convolution(&[], &[]).is_none());
    assert!(!Big::convolution(&[Big::not_finite(80)], &whole[..1]).unwrap().is_finite());
}
