//! Exponents of gyroscopic and damped systems against closed forms.
#![cfg(feature = "engine")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

use librate::modes::exponents::{ExponentKind, Exponents, QuadraticProblem, Structure, exponents};
use librate::modes::{Options, Stability};
use librate::precision::Ball;

fn balls(rows: &[&[f64]]) -> Vec<Ball> {
    let n = rows.len();
    (0..n * n)
        .map(|at| Ball::exact(rows[at % n][at / n]))
        .collect()
}

fn problem(structure: Structure, m: &[&[f64]], d: &[&[f64]], s: &[&[f64]]) -> QuadraticProblem {
    QuadraticProblem {
        dimension: m.len(),
        mass: balls(m),
        velocity: balls(d),
        stiffness: balls(s),
        structure,
        zero_vectors: Vec::new(),
    }
}

fn solved(problem: &QuadraticProblem) -> Exponents {
    exponents(problem, &(), &Options::default()).unwrap()
}

fn kinds(found: &Exponents) -> Vec<ExponentKind> {
    found.entries.iter().map(|entry| entry.kind).collect()
}

#[track_caller]
fn close(found: &Ball, expected: Ball) {
    assert!(
        (*found - expected).contains_zero(),
        "{found:?} {expected:?}"
    );
    assert!(found.radius <= 1e-14 * found.mid_f64().abs(), "{found:?}");
}

const I2: &[&[f64]] = &[&[1.0, 0.0], &[0.0, 1.0]];

#[test]
fn foucault() {
    // q'' - 2 Ω J q' + ω² q = 0 has the frequencies √(ω² + Ω²) ± Ω.
    let (w2, o) = (2.0, 0.25);
    let found = solved(&problem(
        Structure::Gyroscopic,
        I2,
        &[&[0.0, -2.0 * o], &[2.0 * o, 0.0]],
        &[&[w2, 0.0], &[0.0, w2]],
    ));
    assert_eq!(kinds(&found), [ExponentKind::Oscillation; 2]);
    assert_eq!(found.stability, Stability::Stable);
    let root = Ball::exact(w2 + o * o).sqrt();
    close(&found.entries[0].omega, root - Ball::exact(o));
    close(&found.entries[1].omega, root + Ball::exact(o));
    assert!(found.entries.iter().all(|entry| entry.growth.is_zero()));
}

#[test]
fn damped_pair() {
    // q'' + 2 c q' + k q = 0
    let found = solved(&problem(Structure::Damped, &[&[1.0]], &[&[0.5]], &[&[2.0]]));
    assert_eq!(kinds(&found), [ExponentKind::Damped]);
    close(&found.entries[0].growth, Ball::exact(-0.25));
    close(&found.entries[0].omega, Ball::exact(2.0 - 0.0625).sqrt());
    let over = solved(&problem(Structure::Damped, &[&[1.0]], &[&[5.0]], &[&[2.0]]));
    assert_eq!(kinds(&over), [ExponentKind::Overdamped; 2]);
    let root = Ball::exact(17.0).sqrt();
    close(&over.entries[0].growth, (root - Ball::exact(5.0)).scale(-1));
    close(
        &over.entries[1].growth,
        (-root - Ball::exact(5.0)).scale(-1),
    );
}

#[test]
fn free_particle_in_a_magnetic_field() {
    let mut free = problem(
        Structure::Gyroscopic,
        I2,
        &[&[0.0, -3.0], &[3.0, 0.0]],
        &[&[0.0, 0.0], &[0.0, 0.0]],
    );
    free.zero_vectors = vec![vec![Ball::ONE, Ball::ZERO], vec![Ball::ZERO, Ball::ONE]];
    let found = solved(&free);
    assert_eq!(
        kinds(&found),
        [ExponentKind::Zero, ExponentKind::Oscillation]
    );
    assert_eq!(found.stability, Stability::Neutral);
    close(&found.entries[1].omega, Ball::exact(3.0));
}

#[test]
fn free_translation() {
    // Two equal masses and a spring, seen from a frame in which nothing turns: one zero, one oscillation.
    let mut free = problem(
        Structure::Gyroscopic,
        I2,
        &[&[0.0, 0.0], &[0.0, 0.0]],
        &[&[1.0, -1.0], &[-1.0, 1.0]],
    );
    free.zero_vectors = vec![vec![Ball::ONE, Ball::ONE]];
    let found = solved(&free);
    assert_eq!(
        kinds(&found),
        [ExponentKind::Zero, ExponentKind::Oscillation]
    );
    close(&found.entries[1].omega, Ball::exact(2.0).sqrt());
    // The same with a damper between them.
    let mut damped = problem(
        Structure::Damped,
        I2,
        &[&[0.5, -0.5], &[-0.5, 0.5]],
        &[&[1.0, -1.0], &[-1.0, 1.0]],
    );
    damped.zero_vectors = vec![vec![Ball::ONE, Ball::ONE]];
    let found = solved(&damped);
    assert_eq!(kinds(&found), [ExponentKind::Zero, ExponentKind::Damped]);
    close(&found.entries[1].growth, Ball::exact(-0.5));
    close(&found.entries[1].omega, Ball::exact(2.0 - 0.25).sqrt());
}

#[test]
fn gyroscopically_stabilised_and_not() {
    // q'' + g J q' - k q = 0: λ² = -(g² - 2k ± g √(g² - 4k)) / 2.
    let hill = |g: f64| {
        solved(&problem(
            Structure::Gyroscopic,
            I2,
            &[&[0.0, -g], &[g, 0.0]],
            &[&[-1.0, 0.0], &[0.0, -1.0]],
        ))
    };
    let stable = hill(3.0);
    assert_eq!(kinds(&stable), [ExponentKind::Oscillation; 2]);
    let (g, root) = (Ball::exact(3.0), Ball::exact(5.0).sqrt());
    close(&stable.entries[0].omega, (g - root).scale(-1));
    close(&stable.entries[1].omega, (g + root).scale(-1));
    assert_eq!(stable.stability, Stability::Stable);
    // Slower: a quadruple ±√3/2 ± i/2.
    let unstable = hill(1.0);
    assert_eq!(
        kinds(&unstable),
        [ExponentKind::Unstable, ExponentKind::Damped]
    );
    assert_eq!(unstable.stability, Stability::Unstable);
    close(
        &unstable.entries[0].growth,
        Ball::exact(3.0).sqrt().scale(-1),
    );
    close(&unstable.entries[0].omega, Ball::exact(0.5));
    close(
        &unstable.entries[1].growth,
        -Ball::exact(3.0).sqrt().scale(-1),
    );
}
