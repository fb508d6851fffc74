//! Parameter studies of models with exponents: friction, gyroscopic and other forces.
#![cfg(feature = "engine")]

use crate::batch::assert_independent;
use crate::batch_support::{bounds_hold, check_exponents, model, random};
use crate::common::load;

use std::path::Path;

use librate::batch::{Options, Outcome, Study};
use librate::precision::Ball;
use proptest::prelude::*;

/// Any M, B and K.
fn any_pencil(n: usize) -> Study {
    let text = format!(
        "param m[1..{n}, 1..{n}] = 1  param b[1..{n}, 1..{n}] = 1  param k[1..{n}, 1..{n}] = 1
         coord x[1..{n}]
         T = sum(i in 1..{n}, j in 1..{n}, 1/2*m[i,j]*x[i]'*x[j]')
         V = 0
         force x[i in 1..{n}] = -sum(j in 1..{n}, b[i,j]*x[j]' + k[i,j]*x[j])"
    );
    Study::new(model(&text), &["m", "b", "k"]).unwrap()
}

/// M = P Pᵀ + 1, and B and K of one kind or other.
fn pencil(n: usize, kind: u8, state: &mut u64) -> Vec<f64> {
    let mut square = || -> Vec<f64> { (0..n * n).map(|_| random(state) - 0.5).collect() };
    let (p, mut b, mut k) = (square(), square(), square());
    let symmetric =
        |a: &[f64], sign: f64| -> Vec<f64> { (0..n * n).map(|at| a[at] + sign * a[at % n * n + at / n]).collect() };
    match kind {
        // Gyroscopic.
        0 => (b, k) = (symmetric(&b, -1.0), symmetric(&k, 1.0)),
        // Symmetric, overdamped.
        1 => (b, k) = (symmetric(&b, 1.0).iter().map(|x| x * 1e5).collect(), symmetric(&k, 1.0)),
        // No stiffness of the first coordinate.
        2 => (0..n).for_each(|j| (k[j], k[j * n]) = (0.0, 0.0)),
        // Slow and fast.
        3 => (0..n * n).for_each(|at| k[at] *= 1e8_f64.powi((at / n + at % n) as i32)),
        // Circulatory.
        4 => b.fill(0.0),
        // Oscillators that are the same.
        5 => (0..n * n).for_each(|at| {
            let unit = f64::from(u8::from(at / n == at % n));
            (b[at], k[at]) = (0.25 * unit, unit);
        }),
        _ => {}
    }
    let mut set: Vec<f64> = (0..n * n)
        .map(|at| {
            let (i, j) = (at / n, at % n);
            let unit = f64::from(u8::from(i == j));
            if kind == 5 { unit } else { unit + (0..n).map(|l| p[i * n + l] * p[j * n + l]).sum::<f64>() }
        })
        .collect();
    set.extend(b);
    set.extend(k);
    set
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// Each exponent is within its bound of a certified one, and no two of the same.
    #[test]
    fn bounds_hold_of_random_matrices(n in 1_usize..5, seed in any::<u64>()) {
        let (study, mut state) = (any_pencil(n), seed);
        let sets: Vec<f64> = (0..7).flat_map(|kind| pencil(n, kind, &mut state)).collect();
        let solutions = study.solve(&sets).unwrap();
        for (kind, (set, own)) in sets.chunks(study.width()).zip(solutions.iter()).enumerate() {
            prop_assert_eq!(own.outcome, Outcome::Solved);
            prop_assert_eq!([own.mass, own.velocity, own.stiffness].concat(), set);
            let [worst, _] = check_exponents("a pencil", n, &own, &study.certified(set).unwrap());
            // Where vectors are a basis that is not skew, bounds are small.
            prop_assert!(![0, 1, 5].contains(&kind) || worst < 1e-9, "kind {kind}: {worst:e}");
        }
    }
}

/// m s² + c s + k = 0, on both sides of critical damping.
#[test]
fn damped_oscillators() {
    let text =
        "param m = 1  param c = 1  param k = 1  coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2  dissipation = 1/2*c*x'^2";
    let study = Study::new(model(text), &["m", "c", "k"]).unwrap();
    assert!(!study.is_conservative());
    let mut state = 5;
    let mut sets: Vec<f64> = (0..300).map(|at| 10.0_f64.powf((random(&mut state) - 0.5) * f64::from(at % 9))).collect();
    sets.extend([1.0, 1e6, 1.0, /* critical */ 1.0, 2.0, 1.0, 0.3, 0.0, 7.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0]);
    let solutions = study.solve(&sets).unwrap();
    for (set, own) in sets.chunks(3).zip(solutions.iter()) {
        assert_eq!(own.outcome, Outcome::Solved);
        let [m, c, k] = [0, 1, 2].map(|at: usize| Ball::exact(set[at]));
        let two = Ball::exact(2.0) * m;
        let square = c * c - Ball::exact(4.0) * m * k;
        let root = square.abs().sqrt() / two;
        let exact = if square.is_negative() {
            [[-c / two, root], [-c / two, -root]]
        } else {
            // The slower one by the product of both: no digits cancel.
            let fast = -c / two - root;
            let slow = if fast.is_zero() { Ball::ZERO } else { k / (m * fast) };
            [[fast, Ball::ZERO], [slow, Ball::ZERO]]
        };
        assert!(bounds_hold(&own, &exact), "{set:?}: {own:?} {exact:?}");
        let is_double = square.is_zero();
        for (value, bound) in own.exponents.iter().zip(own.exponent_bounds) {
            let size = value.re.hypot(value.im);
            assert!(
                is_double || *bound <= 1e-13 * size.max(1e-3 * (square.abs().mid_f64() / k.mid_f64())),
                "{set:?} {bound:e} of {value}"
            );
        }
    }
}

/// ω = √(g/l + W²) ± W, and no growth.
#[test]
fn foucault_pendulums() {
    let text = "param g = 9.81  param l = 67  param W = 1e-4  coord x, y
        lagrangian = 1/2*(x'^2 + y'^2) + W*(x*y' - y*x') - g/(2*l)*(x^2 + y^2)";
    let study = Study::new(model(text), &["g", "l", "W"]).unwrap();
    let mut state = 8;
    let sets: Vec<f64> =
        (0..50).flat_map(|_| [9.0 + random(&mut state), 60.0 * random(&mut state), random(&mut state)]).collect();
    let solutions = study.solve(&sets).unwrap();
    for (set, own) in sets.chunks(3).zip(solutions.iter()) {
        let [g, l, w] = [0, 1, 2].map(|at: usize| Ball::exact(set[at]));
        let root = (g / l + w * w).sqrt();
        let exact = [root - w, w - root, root + w, -root - w].map(|omega| [Ball::ZERO, omega]);
        assert!(bounds_hold(&own, &exact), "{set:?}: {own:?}");
        assert!(own.exponent_bounds.iter().all(|bound| *bound < 1e-13), "{own:?}");
    }
}

/// 2 a² + (7 k - 2 P l) a + k² = 0 with a = m l² s².
#[test]
fn ziegler_columns() {
    let study = Study::new(load(Path::new("models/ziegler_column.lag")), &["m", "l", "k", "P"]).unwrap();
    let mut state = 9;
    let sets: Vec<f64> = (0..60).flat_map(|_| [1.0, 1.0, 1.0, 8.0].map(|most| most * random(&mut state))).collect();
    let solutions = study.solve(&sets).unwrap();
    let mut flutters = 0;
    for (set, own) in sets.chunks(4).zip(solutions.iter()) {
        let [m, l, k, p] = [0, 1, 2, 3].map(|at: usize| Ball::exact(set[at]));
        let (two, inertia) = (Ball::exact(2.0), m * l * l);
        let half = (Ball::exact(7.0) * k - two * p * l) / Ball::exact(4.0);
        let square = half * half - k * k / two;
        let roots: Vec<[Ball; 2]> = if square.is_negative() {
            flutters += 1;
            // |a| = k/√2 and Re a = -half.
            let [re, im] = [-half, half].map(|part| ((k / two.sqrt() + part) / (two * inertia)).sqrt());
            vec![[re, im], [re, -im], [-re, im], [-re, -im]]
        } else {
            let fast = if half.is_positive() { -half - square.sqrt() } else { -half + square.sqrt() };
            let of = |a: Ball| {
                let s = (a.abs() / inertia).sqrt();
                if a.is_negative() { [[Ball::ZERO, s], [Ball::ZERO, -s]] } else { [[s, Ball::ZERO], [-s, Ball::ZERO]] }
            };
            [of(fast), of(k * k / two / fast)].concat()
        };
        assert!(own.outcome.is_solved() && bounds_hold(&own, &roots), "{set:?}: {own:?} {roots:?}");
    }
    assert!((10..50).contains(&flutters), "{flutters}");
}

const ARM: &str = "
    param g = 9.81  param l[1..2] = 1  param p[1..2] = 60  param d[1..2] = 5  param a = 0.4  param h = 10
    coord th[1..2]
    let r1 = [l[1]*sin(th[1]), -l[1]*cos(th[1])]
    let r2 = r1 + [l[2]*sin(th[2]), -l[2]*cos(th[2])]
    T = 1/2*dot(r1', r1') + 1/2*dot(r2', r2')
    V = g*r1[2] + g*r2[2]
    force th[1] = p[1]*(a - th[1]) - d[1]*th[1]' + h*th[2]
    force th[2] = p[2]*(2*a - th[2]) - d[2]*th[2]'
    guess th[1] = 0.3  guess th[2] = 0.5
";

/// A controlled arm that finds its own place: it is proved, and is where forces vanish.
#[test]
fn controlled_arms() {
    let names = ["g", "l", "p", "d", "a", "h"];
    let nominal = [9.81, 1.0, 1.0, 60.0, 60.0, 5.0, 5.0, 0.4, 10.0];
    let study = Study::new(model(ARM), &names).unwrap();
    assert!(!study.is_at_rest());
    let mut state = 10;
    let mut sets: Vec<f64> = (0..24).flat_map(|_| nominal.map(|x| x * (0.7 + 0.6 * random(&mut state)))).collect();
    sets[2 * 9 + 4] = f64::NAN;
    sets[3 * 9 + 1] = 0.0;
    assert_independent(&study, &sets);
    let solutions = study.solve(&sets).unwrap();
    for (at, (set, own)) in sets.chunks(9).zip(solutions.iter()).enumerate() {
        if at == 2 || at == 3 {
            assert!(!own.outcome.is_solved(), "{:?}", own.outcome);
            continue;
        }
        assert_eq!(own.outcome, Outcome::Solved, "{set:?}");
        let (&[g, l1, l2, p1, p2, _, _, a, h], &[x, y]) = (&set, &own.equilibrium) else { panic!() };
        let forces = [p1 * (a - x) + h * y - 2.0 * g * l1 * x.sin(), p2 * (2.0 * a - y) - g * l2 * y.sin()];
        assert!(forces.iter().all(|force| force.abs() < 1e-12), "{forces:?}");
        let [worst, _] = check_exponents("an arm", 2, &own, &study.certified(set).unwrap());
        assert!(worst < 1e-12, "{worst:e}");
    }
}

/// Nothing holds the carriage, and it may be anywhere: the place is an estimate, as for models without friction.
#[test]
fn a_carriage_that_nothing_holds() {
    let text = "param c = 1  param f = 0.3  coord x, q  T = 1/2*x'^2 + 1/2*(x' + q')^2  V = 1/4*q^4 + 1/2*q^2
        dissipation = 1/2*c*x'^2  force q = f + 0.1*q'  guess q = 1";
    let study = Study::new(model(text), &["c", "f"]).unwrap();
    let solutions = study.solve(&[1.0, 0.3, 2.0, 0.1]).unwrap();
    for own in solutions.iter() {
        assert_eq!(own.outcome, Outcome::Estimated);
        assert_eq!(own.exponents[0].im, 0.0);
    }
}

/// A rotor whose rate varies, about a steady motion: s = ±i (W ± √k).
#[test]
fn steady_motions() {
    let text = "param W = 3  param k = 4  param J = 2  coord x, y, psi
        T = 1/2*((x' - psi'*y)^2 + (y' + psi'*x)^2) + 1/2*J*psi'^2  V = 1/2*k*(x^2 + y^2)  equilibrium psi' = W";
    let study = Study::new(model(text), &["W", "k", "J"]).unwrap();
    let sets = [3.0, 4.0, 2.0, 0.5, 9.0, 1.0];
    let solutions = study.solve(&sets).unwrap();
    for (set, own) in sets.chunks(3).zip(solutions.iter()) {
        let (fast, slow) = ((set[0] + set[1].sqrt()), (set[0] - set[1].sqrt()).abs());
        let exact = [0.0, 0.0, slow, -slow, fast, -fast].map(|omega| [Ball::ZERO, Ball::exact(omega)]);
        assert!(own.outcome.is_solved() && bounds_hold(&own, &exact), "{own:?}");
    }
}

#[test]
fn sets_that_fail_and_those_beside_them() {
    let study = any_pencil(3);
    let mut state = 11;
    let mut sets: Vec<f64> = (0..19).flat_map(|at| pencil(3, at % 7, &mut state)).collect();
    sets[4 * 27 + 12] = f64::NAN;
    sets[6 * 27 + 20] = f64::INFINITY;
    // M with a row of zeros, one that is not positive, one that is singular.
    (0..3).for_each(|at| (sets[8 * 27 + at], sets[8 * 27 + 3 * at]) = (0.0, 0.0));
    sets[9 * 27 + 4] = -1.0;
    sets[10 * 27..10 * 27 + 9].fill(1.0);
    assert_independent(&study, &sets);
    let solutions = study.solve(&sets).unwrap();
    for (at, own) in solutions.iter().enumerate() {
        let expected = match at {
            4 | 6 => Outcome::NotFinite,
            8..11 => Outcome::MassNotPositive,
            _ => Outcome::Solved,
        };
        assert_eq!(own.outcome, expected, "set {at}");
        let is_number = own.exponents.iter().all(|own| own.re.is_finite() && own.im.is_finite());
        assert_eq!(is_number, expected == Outcome::Solved, "{own:?}");
    }
}

/// Exponents alone are the same to rounding, without a bound and with one.
#[test]
fn without_bounds_and_without_vectors() {
    let mut state = 12;
    let sets: Vec<f64> = (0..40).flat_map(|_| pencil(4, 0, &mut state)).collect();
    let of = |options: Options| {
        let study = Study::with_options(any_pencil(4).model().clone(), &["m", "b", "k"], options).unwrap();
        study.solve(&sets).unwrap()
    };
    let (full, few) = (of(Options::default()), of(Options::default().without_vectors().without_matrices()));
    assert_eq!(full.exponents(), few.exponents());
    assert!(few.shapes().is_empty() && few.velocity().is_empty() && full.shapes().len() == 40 * 8 * 4);
    let plain = of(Options::default().without_vectors().without_bounds());
    assert!(plain.exponent_bounds().iter().all(|bound| *bound == f64::INFINITY));
    for (a, b) in plain.exponents().iter().zip(full.exponents()) {
        assert!((a.im - b.im).abs() < 1e-9, "{a} {b}");
    }
}

/// Forces and friction that come to nothing leave a conservative model, solved as such; others never do.
#[test]
fn which_models_are_conservative() {
    let of = |rest: &str| {
        let text =
            format!("param k = 1  param c = 1  coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*k*(x^2 + y^2)  {rest}");
        Study::new(model(&text), &["k", "c"]).unwrap().is_conservative()
    };
    assert!(of("") && of("dissipation = c*x'^4"));
    let others = ["dissipation = c*x'^2", "force x = -c*x", "force x = c", "force x = c*y'", "force x = c*y"];
    assert!(!others.into_iter().any(of));
}
