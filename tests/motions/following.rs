//! What is known of where a solution starts is followed along with it.
#![cfg(feature = "engine")]

use librate::expr::{ExprId, Pool};
use librate::precision::Ball;
use librate_core::precision::DoubleDouble;
use librate_studies::flow::{Equations, Following};

/// The state at a time of a solution of x' = f(x), from a box.
fn followed(rates: fn(&mut Pool, &[ExprId]) -> Vec<ExprId>, start: &[(f64, f64)], until: f64) -> Vec<Ball> {
    let mut pool = Pool::new();
    let time = pool.symbol("t");
    let symbols: Vec<_> = (0..start.len()).map(|i| pool.symbol(&format!("x{i}"))).collect();
    let state: Vec<ExprId> = symbols.iter().map(|x| pool.symbol_expr(*x)).collect();
    let rates = rates(&mut pool, &state);
    let equations = Equations::compile(&mut pool, time, &symbols, &[], &rates).unwrap();
    let ball = |(x, r): &(f64, f64)| Ball::new(DoubleDouble::exact(*x), *r);
    let start: Vec<Ball> = start.iter().map(ball).collect();
    let mut following = Following::new(&equations, 20, (), &start, until);
    while following.time() < until {
        following.reach(until - following.time()).unwrap();
        following.advance().unwrap();
    }
    following.state()
}

/// x0' = -x1, x1' = x0
fn turning(pool: &mut Pool, x: &[ExprId]) -> Vec<ExprId> {
    vec![pool.neg(x[1]), x[0]]
}

/// Almost three turns: the box turns along and is hardly wider than its image.
#[test]
fn rotations_cost_nothing() {
    let angle = 1000.0_f64.to_radians();
    let end = followed(turning, &[(0.0, 1e-3), (0.0, 1e-9)], angle);
    let (s, c) = angle.sin_cos();
    assert!(end[0].radius >= 1e-3 * c.abs() && end[0].radius < 1.001e-3 * c.abs());
    assert!(end[1].radius >= 1e-3 * s.abs() && end[1].radius < 1.001e-3 * s.abs());
    // The short edge has grown by rounding only: four turns and a half bring it back to its axis.
    let end = followed(turning, &[(0.0, 1e-3), (0.0, 1e-9)], 9.0 * std::f64::consts::PI);
    assert!(end[1].radius < 2e-9, "{end:?}");
}

#[test]
fn corners_stay_inside() {
    // A pendulum, whose boxes are sheared and stretched.
    let rates = |pool: &mut Pool, x: &[ExprId]| {
        let sine = pool.sin(x[0]);
        vec![x[1], pool.neg(sine)]
    };
    let (mid, radius) = ([1.0, 0.3], [0.05, 0.02]);
    for until in [0.5, 2.0, 5.0] {
        let end = followed(rates, &[(mid[0], radius[0]), (mid[1], radius[1])], until);
        for (a, b) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let corner = [(mid[0] + a * radius[0], 0.0), (mid[1] + b * radius[1], 0.0)];
            for (own, corner) in end.iter().zip(followed(rates, &corner, until)) {
                let off = (*own - corner).mid_f64().abs();
                assert!(off <= own.radius * (1.0 + 1e-14), "{until}: {own:?} {corner:?}");
            }
        }
    }
}

#[test]
fn what_is_exact_stays_exact() {
    let rates = |pool: &mut Pool, x: &[ExprId]| {
        let turned = turning(pool, &x[1..]);
        vec![pool.zero(), turned[0], turned[1]]
    };
    let end = followed(rates, &[(3.0, 0.0), (1.0, 0.0), (0.0, 0.0)], 2.0);
    assert_eq!(end[0], Ball::exact(3.0));
    assert!(end[1].radius > 0.0 && end[2].radius > 0.0);
    assert!(end[1].radius < 1e-28 && end[2].radius < 1e-28, "{end:?}");
}
