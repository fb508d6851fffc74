//! Taylor coefficients of compiled expressions against closed forms and against derivatives of the expressions.
#![cfg(feature = "engine")]

use librate::expr::{ExprId, Function, Pool, Symbol, Tape};
use librate::number::Number;
use librate::precision::{Ball, Big, Scalar};
use librate_core::precision::{DoubleDouble, LANES, Lane};
use proptest::prelude::*;

/// The first coefficients of an expression along a curve with the given coefficients.
fn series<S: Scalar>(
    pool: &Pool,
    root: ExprId,
    x: Symbol,
    curve: &[S],
    orders: usize,
    precision: S::Precision,
) -> Vec<S> {
    let tape = Tape::compile(pool, &[root], &[x]).unwrap();
    let mut series = tape.prepare::<S>(precision).series();
    let zero = S::from_number(&Number::ZERO, precision);
    (0..orders).map(|k| series.next(&[curve.get(k).unwrap_or(&zero).clone()])[0].clone()).collect()
}

fn doubles(pool: &Pool, root: ExprId, x: Symbol, curve: &[f64], orders: usize) -> Vec<f64> {
    series(pool, root, x, curve, orders, ())
}

fn assert_near(got: &[f64], expected: &[f64]) {
    assert_eq!(got.len(), expected.len());
    for (got, expected) in got.iter().zip(expected) {
        assert!((got - expected).abs() <= 1e-14 * expected.abs().max(1.0), "{got} {expected}");
    }
}

fn factorial(k: usize) -> f64 {
    (1..=k).map(|j| j as f64).product()
}

#[test]
fn known_expansions() {
    let mut pool = Pool::default();
    let x = pool.symbol("x");
    let e = pool.symbol_expr(x);
    let line = [0.0, 1.0];
    let inverse = |k: usize| 1.0 / factorial(k);
    let sign = |k: usize| if (k / 2).is_multiple_of(2) { 1.0 } else { -1.0 };
    type Closed<'a> = (Function, Box<dyn Fn(usize) -> f64 + 'a>);
    let odd = |k: usize| if k % 2 == 1 { 1.0 } else { 0.0 };
    let even = |k: usize| if k.is_multiple_of(2) { 1.0 } else { 0.0 };
    let known: [Closed; 6] = [
        (Function::Exp, Box::new(inverse)),
        (Function::Sin, Box::new(move |k| odd(k) * sign(k) * inverse(k))),
        (Function::Cos, Box::new(move |k| even(k) * sign(k) * inverse(k))),
        (Function::Sinh, Box::new(move |k| odd(k) * inverse(k))),
        (Function::Cosh, Box::new(move |k| even(k) * inverse(k))),
        (Function::Atan, Box::new(move |k| if k % 2 == 1 { sign(k) / k as f64 } else { 0.0 })),
    ];
    for (function, coefficient) in known {
        let root = pool.apply(function, e);
        let expected: Vec<f64> = (0..12).map(coefficient).collect();
        assert_near(&doubles(&pool, root, x, &line, 12), &expected);
    }
    // Bernoulli numbers.
    let tangent = [0.0, 1.0, 0.0, 1.0 / 3.0, 0.0, 2.0 / 15.0, 0.0, 17.0 / 315.0, 0.0, 62.0 / 2835.0];
    let root = pool.apply(Function::Tan, e);
    assert_near(&doubles(&pool, root, x, &line, 10), &tangent);
    let root = pool.apply(Function::Tanh, e);
    let alternating: Vec<f64> = tangent.iter().enumerate().map(|(k, c)| c * sign(k)).collect();
    assert_near(&doubles(&pool, root, x, &line, 10), &alternating);
    // ln(1 + x), 1/(1 + x), sqrt(1 + x), (1 + x)^(-3/2), (1 + x)^(1/3).
    let one = pool.one();
    let shifted = pool.add(one, e);
    let root = pool.apply(Function::Ln, shifted);
    let logarithm: Vec<f64> = (0..12).map(|k| if k == 0 { 0.0 } else { (1.0 - 2.0 * even(k)) / k as f64 }).collect();
    assert_near(&doubles(&pool, root, x, &line, 12), &logarithm);
    for (n, d) in [(-1, 1), (1, 2), (-3, 2), (1, 3), (-7, 5), (40, 1)] {
        let root = pool.powr(shifted, &Number::ratio(n, d).unwrap());
        let exponent = n as f64 / d as f64;
        let mut binomial = vec![1.0];
        for k in 1..12 {
            binomial.push(binomial[k - 1] * (exponent - k as f64 + 1.0) / k as f64);
        }
        assert_near(&doubles(&pool, root, x, &line, 12), &binomial);
    }
}

#[test]
fn whole_powers_of_what_begins_with_zero_are_polynomials() {
    let mut pool = Pool::default();
    let x = pool.symbol("x");
    let e = pool.symbol_expr(x);
    for n in [1_usize, 2, 3, 7, 12] {
        let root = pool.powr(e, &Number::from(n as i64));
        let got = series(&pool, root, x, &[Ball::ZERO, Ball::exact(2.0)], 14, ());
        for (k, c) in got.iter().enumerate() {
            let expected = if k == n { f64::powi(2.0, n as i32) } else { 0.0 };
            assert_eq!(*c, Ball::exact(expected), "{n} {k}");
        }
    }
}

#[test]
fn what_has_no_expansion_is_not_finite() {
    let mut pool = Pool::default();
    let x = pool.symbol("x");
    let e = pool.symbol_expr(x);
    let root = pool.powr(e, &Number::half());
    let magnitude = pool.abs(e);
    let third = pool.powr(e, &Number::ratio(1, 3).unwrap());
    for root in [root, magnitude, third] {
        assert!(!doubles(&pool, root, x, &[0.0, 1.0], 2)[1].is_finite());
        let balls = series(&pool, root, x, &[Ball::ZERO, Ball::ONE], 2, ());
        assert!(!balls[1].is_finite());
        // A constant is its own expansion, 0 too.
        assert_eq!(doubles(&pool, root, x, &[0.0], 4), [0.0; 4]);
    }
    let inverse = pool.powr(e, &Number::from(-1));
    assert!(!doubles(&pool, inverse, x, &[0.0, 1.0], 1)[0].is_finite());
    // An input that is left out.
    let tape = Tape::compile(&pool, &[e], &[x]).unwrap();
    assert!(!tape.prepare::<f64>(()).series().next(&[])[0].is_finite());
}

/// Every operation: x is the curve, which stays in (0.2, 0.8).
fn operations(pool: &mut Pool, e: ExprId) -> Vec<ExprId> {
    let mut all: Vec<ExprId> = [
        Function::Sin,
        Function::Cos,
        Function::Tan,
        Function::Asin,
        Function::Acos,
        Function::Atan,
        Function::Sinh,
        Function::Cosh,
        Function::Tanh,
        Function::Exp,
        Function::Ln,
    ]
    .into_iter()
    .map(|function| pool.apply(function, e))
    .collect();
    for (n, d) in [(2, 1), (-1, 1), (-3, 1), (9, 1), (1, 2), (-5, 2), (1, 3), (-7, 4)] {
        all.push(pool.powr(e, &Number::ratio(n, d).unwrap()));
    }
    let (one, half) = (pool.one(), pool.number(Number::half()));
    let (sine, cosine, exponential) = (all[0], all[1], all[9]);
    let below = pool.sub(e, one);
    all.push(pool.abs(below));
    all.push(pool.power(e, sine));
    all.push(pool.power(half, e));
    all.push(pool.atan2(sine, below));
    all.push(pool.atan2(below, e));
    let product = pool.mul(sine, exponential);
    let sum = pool.add(cosine, product);
    all.push(pool.div(product, sum));
    all.push(pool.apply(Function::Sin, sum));
    let pi = pool.pi();
    let turned = pool.mul(pi, sum);
    all.push(pool.sub(turned, half));
    all
}

#[test]
fn a_second_curve_begins_anew() {
    let mut pool = Pool::default();
    let x = pool.symbol("x");
    let e = pool.symbol_expr(x);
    let roots = operations(&mut pool, e);
    let sine = pool.sin(e);
    let two = pool.number(Number::from(2));
    // What depends on no input is worked out once, a number or none.
    let fixed = pool.sqrt(two);
    let undefined = pool.undefined();
    let product = pool.mul(fixed, sine);
    let roots = [roots.as_slice(), &[fixed, product, undefined]].concat();
    let tape = Tape::compile(&pool, &roots, &[x]).unwrap();
    let prepared = tape.prepare::<f64>(());
    let mut series = prepared.series();
    for curve in [[0.3, 1.0, -0.2], [0.5, 0.25, 0.0], [0.7, 0.0, 0.0]] {
        series.clear();
        let mut fresh = prepared.series();
        for k in 0..20 {
            let input = [curve.get(k).copied().unwrap_or(0.0)];
            let own = series.next(&input).to_vec();
            for (own, fresh) in own.iter().zip(fresh.next(&input)) {
                assert!(own == fresh || own.is_nan() && fresh.is_nan());
            }
        }
        for output in 0..roots.len() {
            assert_eq!(series.live(output), fresh.live(output));
        }
        assert_eq!(series.live(roots.len() - 3), 1);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// k! times the k-th coefficient along c_0 + c_1 t + c_2 t² is the k-th derivative by t.
    #[test]
    fn coefficients_are_derivatives(c in (0.2..0.8f64, -1.0..1.0f64, -1.0..1.0f64)) {
        let mut pool = Pool::default();
        let (x, t) = (pool.symbol("x"), pool.symbol("t"));
        let e = pool.symbol_expr(x);
        let time = pool.symbol_expr(t);
        let curve = [c.0, c.1, c.2];
        let mut path = pool.zero();
        for (k, c) in curve.iter().enumerate() {
            let c = pool.number(Number::from_f64_exact(*c).unwrap());
            let power = pool.powr(time, &Number::from(k as i64));
            let term = pool.mul(c, power);
            path = pool.add(path, term);
        }
        for root in operations(&mut pool, e) {
            let balls = series(&pool, root, x, &curve.map(Ball::exact), 6, ());
            let plain = doubles(&pool, root, x, &curve, 6);
            let doubled = series(&pool, root, x, &curve.map(DoubleDouble::exact), 6, ());
            // Another curve in each lane.
            let side_by_side = [0, 1, 2].map(|k| Lane(std::array::from_fn(|lane| curve[k] * (1.0 - lane as f64 / 64.0))));
            let side_by_side = series(&pool, root, x, &side_by_side, 6, ());
            for lane in 0..LANES {
                let own = curve.map(|c| c * (1.0 - lane as f64 / 64.0));
                let own = doubles(&pool, root, x, &own, 6);
                for (k, (own, all)) in own.iter().zip(&side_by_side).enumerate() {
                    let size = own.abs().max(1.0);
                    prop_assert!((own - all.0[lane]).abs() <= 1e-9 * size, "{} {}", pool.display(root), k);
                }
            }
            let wide: Vec<Big> = curve.iter().map(|c| Big::from_f64(*c, 200)).collect();
            let wide = series(&pool, root, x, &wide, 6, 200);
            let mut derivative = pool.substitute_one(root, &[(x, path)].into_iter().collect());
            let mut count = Ball::ONE;
            for k in 0..6 {
                if k > 0 {
                    derivative = pool.diff(derivative, t);
                    count = count * Ball::exact(k as f64);
                }
                let exact = Tape::compile(&pool, &[derivative], &[t]).unwrap();
                let exact = exact.evaluate(&[Ball::ZERO], &mut Vec::new())[0] / count;
                let text = pool.display(root).to_string();
                prop_assert!(exact.is_finite() && balls[k].is_finite(), "{} {}", text, k);
                prop_assert!((exact - balls[k]).contains_zero(), "{} {}: {:?} {:?}", text, k, exact, balls[k]);
                let size = exact.abs_upper().max(1.0);
                prop_assert!((exact - balls[k]).abs_upper() <= 1e-24 * size, "{} {}", text, k);
                prop_assert!((exact.mid_f64() - plain[k]).abs() <= 1e-9 * size, "{} {}", text, k);
                prop_assert!((exact - Ball::from(doubled[k])).abs_upper() <= 1e-24 * size, "{} {}", text, k);
                let difference = (&wide[k] - &Big::from_ball(&exact, 200)).to_ball();
                prop_assert!(difference.contains_zero() && difference.abs_upper() <= 1e-24 * size);
            }
        }
    }
}
