//! Exponents of gyroscopic and damped systems against closed forms.
#![cfg(feature = "engine")]

use dashu_int::IBig;
use librate::linearize::{LinearizeError, linearize};
use librate::modes::{Kind, Limit, Options, Stability};
use librate::oscillation::{NormalModes, normal_modes};
use librate::precision::Ball;
use librate_core::modes::ModesError;
use librate_core::modes::exponents::{Exponents, QuadraticProblem, QuadraticSource, Structure, exponents};
use librate_core::precision::Integers;

fn balls(rows: &[&[f64]]) -> Vec<Ball> {
    let n = rows.len();
    (0..n * n).map(|at| Ball::exact(rows[at % n][at / n])).collect()
}

fn problem(structure: Structure, m: &[&[f64]], d: &[&[f64]], s: &[&[f64]]) -> QuadraticProblem {
    QuadraticProblem {
        dimension: m.len(),
        mass: balls(m),
        velocity: balls(d),
        stiffness: balls(s),
        structure,
        zero_vectors: Vec::new(),
        unmoved: Vec::new(),
    }
}

fn solved(problem: &QuadraticProblem) -> Exponents {
    exponents(problem, &(), &Options::default()).unwrap()
}

fn kinds(found: &Exponents) -> Vec<Kind> {
    found.entries.iter().map(|entry| entry.kind).collect()
}

#[track_caller]
fn close(found: &Ball, expected: Ball) {
    assert!((*found - expected).contains_zero(), "{found:?} {expected:?}");
    assert!(found.radius <= 1e-14 * found.mid_f64().abs(), "{found:?}");
}

const I2: &[&[f64]] = &[&[1.0, 0.0], &[0.0, 1.0]];

fn of_model(text: &str) -> Result<NormalModes, LinearizeError> {
    let file = librate::syntax::parse(text).unwrap();
    let model = librate::model::elaborate(&file, &Default::default(), &Default::default()).unwrap();
    normal_modes(&linearize(model)?, &Options::default())
}

/// In r = x + 4 z the first is s² + s + 10 = 0, and z is free; doubles do not tell this M from a singular one.
#[test]
fn inertias_over_sixteen_decades() {
    let modes = |sign: &str| {
        of_model(&format!(
            "coord x, z  T = 1/2*1e8*(x' + 4*z')^2 {sign} 1/2*1e-8*z'^2  V = 1/2*1e9*(x + 4*z)^2
             dissipation = 1/2*1e8*(x' + 4*z')^2"
        ))
    };
    let found = modes("+").unwrap().modes;
    assert_eq!((found[0].kind, found[1].kind, found[1].growth.mid_f64()), (Kind::Zero, Kind::Damped, -0.5));
    close(&found[1].omega, Ball::exact(9.75).sqrt());
    assert!(modes("-").is_err());
}

/// Frequencies that are equal in doubles, and in pairs of them, are in order: ω² = k - c²/4.
#[test]
fn frequencies_closer_than_doubles_are_in_order() {
    for (gap, friction, digits) in
        [("3e-18", ["1e-18", "5e-18"], 30), ("3e-18", ["0.1", "0.1"], 30), ("3e-38", ["0.1", "0.1"], 50)]
    {
        let file = librate::syntax::parse(&format!(
            "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*x^2 + 1/2*(1 - {gap})*y^2
             dissipation = 1/2*{}*x'^2 + 1/2*{}*y'^2",
            friction[0], friction[1]
        ));
        let model = librate::model::elaborate(&file.unwrap(), &Default::default(), &Default::default()).unwrap();
        let found = normal_modes(&linearize(model).unwrap(), &Options::default().digits(digits)).unwrap().modes;
        let moves: Vec<bool> = found.iter().map(|mode| mode.vector[1].abs() > 0.5).collect();
        assert_eq!(moves, [true, false], "{gap} {friction:?}");
    }
}

/// A motor turns a disc against friction, at the rate at which both balance: for these values, not for all.
#[test]
fn a_rate_is_kept_at_the_values() {
    let modes = |rate: &str| {
        of_model(&format!(
            "param J = 0.5, c = 3, tau = 6  coord phi  T = 1/2*J*phi'^2  force phi = tau - c*phi'  equilibrium phi' = {rate}"
        ))
    };
    let found = modes("2").unwrap().modes;
    assert_eq!((found[0].kind, found[1].kind, found[1].growth.mid_f64()), (Kind::Zero, Kind::Overdamped, -6.0));
    assert!(matches!(modes("3"), Err(LinearizeError::RateNotKept { .. })));
}

#[test]
fn foucault() {
    // q'' - 2 Ω J q' + ω² q = 0 has the frequencies √(ω² + Ω²) ± Ω.
    let (w2, o) = (2.0, 0.25);
    let found =
        solved(&problem(Structure::Gyroscopic, I2, &[&[0.0, -2.0 * o], &[2.0 * o, 0.0]], &[&[w2, 0.0], &[0.0, w2]]));
    assert_eq!(kinds(&found), [Kind::Oscillation; 2]);
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
    assert_eq!(kinds(&found), [Kind::Damped]);
    close(&found.entries[0].growth, Ball::exact(-0.25));
    close(&found.entries[0].omega, Ball::exact(2.0 - 0.0625).sqrt());
    let over = solved(&problem(Structure::Damped, &[&[1.0]], &[&[5.0]], &[&[2.0]]));
    assert_eq!(kinds(&over), [Kind::Overdamped; 2]);
    let root = Ball::exact(17.0).sqrt();
    close(&over.entries[0].growth, (root - Ball::exact(5.0)).scale(-1));
    close(&over.entries[1].growth, (-root - Ball::exact(5.0)).scale(-1));
}

#[test]
fn free_particle_in_a_magnetic_field() {
    let mut free = problem(Structure::Gyroscopic, I2, &[&[0.0, -3.0], &[3.0, 0.0]], &[&[0.0, 0.0], &[0.0, 0.0]]);
    free.zero_vectors = vec![vec![Ball::ONE, Ball::ZERO], vec![Ball::ZERO, Ball::ONE]];
    let found = solved(&free);
    assert_eq!(kinds(&found), [Kind::Zero, Kind::Oscillation]);
    assert_eq!(found.stability, Stability::Neutral);
    close(&found.entries[1].omega, Ball::exact(3.0));
}

#[test]
fn free_translation() {
    // Two equal masses and a spring, seen from a frame in which nothing turns: one zero, one oscillation.
    let mut free = problem(Structure::Gyroscopic, I2, &[&[0.0, 0.0], &[0.0, 0.0]], &[&[1.0, -1.0], &[-1.0, 1.0]]);
    free.zero_vectors = vec![vec![Ball::ONE, Ball::ONE]];
    let found = solved(&free);
    assert_eq!(kinds(&found), [Kind::Zero, Kind::Oscillation]);
    close(&found.entries[1].omega, Ball::exact(2.0).sqrt());
    // The same with a damper between them.
    let mut damped = problem(Structure::Damped, I2, &[&[0.5, -0.5], &[-0.5, 0.5]], &[&[1.0, -1.0], &[-1.0, 1.0]]);
    damped.zero_vectors = vec![vec![Ball::ONE, Ball::ONE]];
    let found = solved(&damped);
    assert_eq!(kinds(&found), [Kind::Zero, Kind::Damped]);
    close(&found.entries[1].growth, Ball::exact(-0.5));
    close(&found.entries[1].omega, Ball::exact(2.0 - 0.25).sqrt());
}

#[test]
fn gyroscopically_stabilised_and_not() {
    // q'' + g J q' - k q = 0: λ² = -(g² - 2k ± g √(g² - 4k)) / 2.
    let hill =
        |g: f64| solved(&problem(Structure::Gyroscopic, I2, &[&[0.0, -g], &[g, 0.0]], &[&[-1.0, 0.0], &[0.0, -1.0]]));
    let stable = hill(3.0);
    assert_eq!(kinds(&stable), [Kind::Oscillation; 2]);
    let (g, root) = (Ball::exact(3.0), Ball::exact(5.0).sqrt());
    close(&stable.entries[0].omega, (g - root).scale(-1));
    close(&stable.entries[1].omega, (g + root).scale(-1));
    assert_eq!(stable.stability, Stability::Stable);
    // Slower: a quadruple ±√3/2 ± i/2.
    let unstable = hill(1.0);
    assert_eq!(kinds(&unstable), [Kind::Unstable, Kind::Damped]);
    assert_eq!(unstable.stability, Stability::Unstable);
    close(&unstable.entries[0].growth, Ball::exact(3.0).sqrt().scale(-1));
    close(&unstable.entries[0].omega, Ball::exact(0.5));
    close(&unstable.entries[1].growth, -Ball::exact(3.0).sqrt().scale(-1));
}

/// The matrices as whole numbers over a denominator.
struct Whole {
    denominator: i64,
    problem: QuadraticProblem,
}

impl QuadraticSource for Whole {
    fn integers(&self) -> Option<Integers> {
        let whole = |entries: &[Ball]| {
            entries.iter().map(|x| IBig::from((x.mid_f64() * self.denominator as f64) as i64)).collect()
        };
        Some(Integers {
            matrices: [whole(&self.problem.mass), whole(&self.problem.velocity), whole(&self.problem.stiffness)],
            ..Integers::default()
        })
    }
}

fn solved_exactly(problem: QuadraticProblem, denominator: i64, digits: usize) -> Exponents {
    let source = Whole { denominator, problem };
    let options = Options::default().digits(digits);
    exponents(&source.problem, &source, &options).unwrap()
}

#[test]
fn critical_damping() {
    // (λ + 3/2)² = 0: one exponent twice, one vector.
    let critical = || problem(Structure::Damped, &[&[1.0]], &[&[3.0]], &[&[2.25]]);
    let found = solved_exactly(critical(), 4, 50);
    assert_eq!(kinds(&found), [Kind::Overdamped; 2]);
    for entry in &found.entries {
        assert_eq!(entry.limit, Some(Limit::Defective { order: 2 }));
        assert!((entry.growth - Ball::exact(-1.5)).contains_zero());
        let precise = entry.precise.as_ref().unwrap();
        assert_eq!(precise.growth.decimal(50).text, format!("-1.5{}", "0".repeat(48)));
        assert!(entry.omega.is_zero());
    }
    assert_eq!(found.stability, Stability::Stable);
    // Without the exact matrices it stays open what the two are, but not that the motion decays.
    let open = solved(&critical());
    assert!(open.entries.iter().all(|entry| entry.kind == Kind::Undecided));
    assert!(open.entries.iter().all(|entry| entry.limit == Some(Limit::Unresolved { count: 2 })));
    assert!(open.entries.iter().all(|entry| entry.growth.is_negative()));
    assert!(open.entries.iter().all(|entry| (entry.growth - Ball::exact(-1.5)).contains_zero()));
    assert_eq!(open.stability, Stability::Stable);
}

#[test]
fn nearly_critical_damping() {
    // λ² + 2 λ + 1 - 2^-80 = 0: -1 ± 2^-40, from entries of 80 bits.
    let mut near = problem(Structure::Damped, &[&[1.0]], &[&[2.0]], &[&[1.0]]);
    near.stiffness[0] = Ball::ONE - Ball::exact(2f64.powi(-80));
    let found = solved(&near);
    assert_eq!(kinds(&found), [Kind::Overdamped; 2]);
    let step = Ball::exact(2f64.powi(-40));
    assert!((found.entries[0].growth - (step - Ball::ONE)).contains_zero());
    assert!((found.entries[1].growth - (-step - Ball::ONE)).contains_zero());
    assert!(found.entries.iter().all(|entry| entry.growth.radius < 1e-13));
    // And on the other side -1 ± i 2^-40.
    near.stiffness[0] = Ball::ONE + Ball::exact(2f64.powi(-80));
    let found = solved(&near);
    assert_eq!(kinds(&found), [Kind::Damped]);
    close(&found.entries[0].omega, step);
}

#[test]
fn many_digits() {
    let found =
        exponents(&problem(Structure::Damped, &[&[1.0]], &[&[1.0]], &[&[1.0]]), &(), &Options::default().digits(100))
            .unwrap();
    // √3/2
    let expected =
        "0.8660254037844386467637231707529361834714026269051903140279034897259665084544000185405730933786242878";
    let precise = found.entries[0].precise.as_ref().unwrap();
    assert_eq!(precise.omega.decimal(100).text, expected);
    assert_eq!(precise.growth.decimal(100).text, format!("-0.5{}", "0".repeat(99)));
    assert_eq!(found.entries[0].limit, None);
}

#[test]
fn where_a_top_falls_asleep() {
    // q'' + g J q' - q = 0 at g = 2: (λ² + 1)² = 0, imaginary and defective.
    let top = problem(Structure::Gyroscopic, I2, &[&[0.0, -2.0], &[2.0, 0.0]], &[&[-1.0, 0.0], &[0.0, -1.0]]);
    let open = solved(&top);
    assert_eq!(open.stability, Stability::Undecided);
    let found = solved_exactly(top, 1, 30);
    assert_eq!(kinds(&found), [Kind::Oscillation; 2]);
    assert_eq!(found.stability, Stability::Neutral);
    for entry in &found.entries {
        assert!(entry.growth.is_zero());
        assert!((entry.omega - Ball::ONE).contains_zero() && entry.omega.radius < 1e-28);
        assert_eq!(entry.limit, Some(Limit::Defective { order: 2 }));
    }
}

#[test]
fn equal_frequencies_with_enough_vectors() {
    // Two equal oscillators that nothing couples: growth 0 by the energy, no exact matrices needed.
    let two = problem(Structure::Gyroscopic, I2, &[&[0.0, 0.0], &[0.0, 0.0]], &[&[3.0, 0.0], &[0.0, 3.0]]);
    let found = solved(&two);
    assert_eq!(kinds(&found), [Kind::Oscillation; 2]);
    assert_eq!(found.stability, Stability::Stable);
    assert!(found.entries.iter().all(|entry| entry.growth.is_zero() && entry.limit.is_none()));
    found.entries.iter().for_each(|entry| close(&entry.omega, Ball::exact(3.0).sqrt()));
    // The same with dampers.
    let damped = problem(Structure::Damped, I2, &[&[1.0, 0.0], &[0.0, 1.0]], &[&[3.0, 0.0], &[0.0, 3.0]]);
    let found = solved_exactly(damped, 1, 10);
    assert_eq!(kinds(&found), [Kind::Damped; 2]);
    assert!(found.entries.iter().all(|entry| entry.limit.is_none()));
    found.entries.iter().for_each(|entry| close(&entry.omega, Ball::exact(11.0).sqrt().scale(-1)));
}

#[test]
fn undamped_beside_damped() {
    // One oscillator of two is damped: the other one's growth is 0, which only exact matrices tell.
    let pair = || {
        problem(
            Structure::Damped,
            &[&[2.0, 1.0], &[1.0, 1.0]],
            &[&[1.0, 1.0], &[1.0, 1.0]],
            &[&[7.0, 5.0], &[5.0, 5.0]],
        )
    };
    // In u = q1, v = q1 + q2: u'' + 2u = 0 and v'' + v' + 5v = 0.
    let found = solved_exactly(pair(), 1, 12);
    assert_eq!(kinds(&found), [Kind::Oscillation, Kind::Damped]);
    assert!(found.entries[0].growth.is_zero());
    close(&found.entries[0].omega, Ball::exact(2.0).sqrt());
    close(&found.entries[1].growth, Ball::exact(-0.5));
    close(&found.entries[1].omega, Ball::exact(4.75).sqrt());
    assert_eq!(found.stability, Stability::Stable);
    let open = solved(&pair());
    assert_eq!(open.stability, Stability::Undecided);
}

#[test]
fn penning_trap() {
    // x'' - c y' - x w²/2 = 0 and so on, z'' + w² z = 0: magnetron, axial and modified cyclotron frequency.
    let (c, w2) = (10.0, 8.0);
    let found = solved(&problem(
        Structure::Gyroscopic,
        &[&[1.0, 0.0, 0.0], &[0.0, 1.0, 0.0], &[0.0, 0.0, 1.0]],
        &[&[0.0, -c, 0.0], &[c, 0.0, 0.0], &[0.0, 0.0, 0.0]],
        &[&[-w2 / 2.0, 0.0, 0.0], &[0.0, -w2 / 2.0, 0.0], &[0.0, 0.0, w2]],
    ));
    assert_eq!(kinds(&found), [Kind::Oscillation; 3]);
    assert_eq!(found.stability, Stability::Stable);
    let root = Ball::exact(c * c - 2.0 * w2).sqrt();
    close(&found.entries[0].omega, (Ball::exact(c) - root).scale(-1));
    close(&found.entries[1].omega, Ball::exact(w2).sqrt());
    close(&found.entries[2].omega, (Ball::exact(c) + root).scale(-1));
}

#[test]
fn triangular_points() {
    // x'' - 2y' = 3/4 x + k y, y'' + 2x' = k x + 9/4 y with k² = 27/16 (1 - 2μ)²:
    // λ⁴ + λ² + 27/4 μ (1 - μ) = 0, here for given k² instead of μ.
    let point = |k: f64| {
        solved(&problem(Structure::Gyroscopic, I2, &[&[0.0, -2.0], &[2.0, 0.0]], &[&[-0.75, -k], &[-k, -2.25]]))
    };
    // λ⁴ + λ² + c = 0 with c = 27/16 - k².
    let c = |k: f64| Ball::exact(27.0) / Ball::exact(16.0) - Ball::exact(k) * Ball::exact(k);
    let stable = point(1.2890625);
    assert_eq!(kinds(&stable), [Kind::Oscillation; 2]);
    assert_eq!(stable.stability, Stability::Stable);
    let root = (Ball::ONE - c(1.2890625).scale(2)).sqrt();
    close(&stable.entries[0].omega, (Ball::ONE - root).scale(-1).sqrt());
    close(&stable.entries[1].omega, (Ball::ONE + root).scale(-1).sqrt());
    // Beyond Routh's ratio.
    let unstable = point(1.125);
    assert_eq!(kinds(&unstable), [Kind::Unstable, Kind::Damped]);
    let modulus = c(1.125).sqrt();
    let growth = ((modulus - Ball::ONE.scale(-1)).scale(-1)).sqrt();
    close(&unstable.entries[0].growth, growth);
    close(&unstable.entries[0].omega, ((modulus + Ball::ONE.scale(-1)).scale(-1)).sqrt());
}

#[test]
fn small_growth_beside_a_large_frequency() {
    // λ² + 2^-29 λ + 1 = 0
    let found = solved(&problem(Structure::Damped, &[&[1.0]], &[&[2f64.powi(-29)]], &[&[1.0]]));
    close(&found.entries[0].growth, Ball::exact(-2f64.powi(-30)));
}

#[test]
fn refused() {
    let flat = problem(Structure::Damped, &[&[0.0]], &[&[1.0]], &[&[1.0]]);
    let error = exponents(&flat, &(), &Options::default()).unwrap_err();
    assert_eq!(error, ModesError::MassNotDecided);
    let mut short = problem(Structure::Damped, &[&[1.0]], &[&[1.0]], &[&[1.0]]);
    short.velocity.clear();
    assert!(matches!(exponents(&short, &(), &Options::default()), Err(ModesError::Shape { found: 0, .. })));
    let mut beyond = problem(Structure::Damped, &[&[1.0]], &[&[1.0]], &[&[1.0]]);
    beyond.stiffness[0] = Ball::NOT_FINITE;
    assert!(matches!(exponents(&beyond, &(), &Options::default()), Err(ModesError::NotFinite { .. })));
    // Not in the kernel; not independent; of the wrong length.
    let with = |vectors: Vec<Vec<Ball>>| {
        let mut free = problem(Structure::Damped, I2, I2, &[&[1.0, -1.0], &[-1.0, 1.0]]);
        free.zero_vectors = vectors;
        exponents(&free, &(), &Options::default()).unwrap_err()
    };
    let one = vec![Ball::ONE, Ball::ONE];
    assert_eq!(with(vec![vec![Ball::ONE, Ball::ZERO]]), ModesError::ZeroVector { index: 0 });
    assert_eq!(with(vec![one.clone(), one]), ModesError::ZeroVector { index: 1 });
    assert_eq!(with(vec![vec![Ball::ONE]]), ModesError::ZeroVector { index: 0 });
}

#[test]
fn equal_exponents_of_definite_signature() {
    // Two equal tops, fast enough to stand: S is negative, the equal frequencies are of one signature.
    let g = 3.0;
    let turn: &[&[f64]] = &[&[0.0, -g, 0.0, 0.0], &[g, 0.0, 0.0, 0.0], &[0.0, 0.0, 0.0, -g], &[0.0, 0.0, g, 0.0]];
    let one: &[&[f64]] = &[&[1.0, 0.0, 0.0, 0.0], &[0.0, 1.0, 0.0, 0.0], &[0.0, 0.0, 1.0, 0.0], &[0.0, 0.0, 0.0, 1.0]];
    let mut tops = problem(Structure::Gyroscopic, one, turn, one);
    tops.stiffness.iter_mut().for_each(|x| *x = -*x);
    let found = solved(&tops);
    assert_eq!(kinds(&found), [Kind::Oscillation; 4]);
    assert_eq!(found.stability, Stability::Stable);
    let root = Ball::exact(5.0).sqrt();
    close(&found.entries[0].omega, (Ball::exact(g) - root).scale(-1));
    close(&found.entries[3].omega, (Ball::exact(g) + root).scale(-1));
    // Two equal overdamped oscillators: real exponents in pairs, by the symmetry of D and S.
    let over = problem(Structure::Damped, I2, &[&[5.0, 0.0], &[0.0, 5.0]], &[&[2.0, 0.0], &[0.0, 2.0]]);
    let found = solved(&over);
    assert_eq!(kinds(&found), [Kind::Overdamped; 4]);
    assert!(found.entries.iter().all(|entry| entry.limit.is_none()));
}

#[test]
fn uncertain_matrices() {
    // Foucault with ω² and Ω in intervals: bounds hold at their ends.
    let (w2, o, r) = (2.0, 0.25, 1e-9);
    let mut wide = problem(Structure::Gyroscopic, I2, &[&[0.0, -2.0 * o], &[2.0 * o, 0.0]], &[&[w2, 0.0], &[0.0, w2]]);
    for entry in wide.velocity.iter_mut().chain(&mut wide.stiffness) {
        if !entry.is_zero() {
            *entry = entry.with_added_radius(r);
        }
    }
    let found = solved(&wide);
    assert_eq!(kinds(&found), [Kind::Oscillation; 2]);
    // Just inside: w2 + r is rounded itself, and the discs are hardly larger than they have to be.
    let r = 0.999 * r;
    for (w2, o) in [(w2 + r, o + 0.5 * r), (w2 - r, o - 0.5 * r), (w2 + r, o - 0.5 * r)] {
        let root = (Ball::exact(w2) + Ball::exact(o) * Ball::exact(o)).sqrt();
        for (entry, omega) in found.entries.iter().zip([root - Ball::exact(o), root + Ball::exact(o)]) {
            assert!((entry.omega - omega).contains_zero(), "{:?} {omega:?}", entry.omega);
            // Not by much too wide either, and said to be open: the matrices do not determine ten digits.
            assert!(entry.omega.radius < 20.0 * r);
            assert_eq!(entry.limit, Some(Limit::Open));
        }
    }
}

#[test]
fn a_kernel_that_is_not_told() {
    // Exponents 0, 0 and ±i√2, S singular and nobody says so: open, and nothing is made up.
    let found = solved(&problem(
        Structure::Gyroscopic,
        &[&[2.0, 0.0], &[0.0, 1.0]],
        &[&[0.0, 0.0], &[0.0, 0.0]],
        &[&[0.0, 0.0], &[0.0, 2.0]],
    ));
    assert_eq!(found.stability, Stability::Undecided);
    for entry in &found.entries {
        assert!(!entry.growth.is_positive() && !entry.growth.is_negative());
    }
}
