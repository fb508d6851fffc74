//! Motions that mislead the length of a step: series with gaps, forces that are nothing where a step begins, corners. References
//! are closed forms; where they have digits, these come from quadratures and elliptic functions with 40 digits.
#![cfg(feature = "engine")]

use librate::model::{Constant, Settings, TableTexts, elaborate};
use librate::motion::{Start, System, Times};
use librate::precision::Ball;
use librate::syntax;

/// The coordinates at the last of `samples` times.
fn end(text: &str, start: &str, until: &str, samples: usize) -> Vec<Ball> {
    let file = syntax::parse(text).unwrap();
    let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
    let system = System::new(&model).unwrap();
    let start = Start::parse(start, &model, None, &system).unwrap();
    let times = Times::new(&Constant::parse(until).unwrap(), samples).unwrap();
    let found = system.motion(&start, &times).unwrap();
    found.rows.last().unwrap().clone()
}

fn assert_ends(text: &str, start: &str, until: &str, want: f64) {
    for samples in [2, 7] {
        let found = end(text, start, until, samples)[0];
        let off = (found.mid_f64() - want).abs();
        assert!(off <= found.radius + 1e-14 * want.abs().max(1.0), "{text} {start} {until}: {found:?}, {want}");
        assert!(found.radius < 1e-12, "{text} {start} {until}: {found:?}");
    }
}

#[test]
fn series_with_gaps() {
    // From 90° the series has the powers 2, 6, 10, …: sin(x/2) = sin(pi/4) cd(t).
    let pendulum = "coord x  T = 1/2*x'^2  V = 1 - cos(x)";
    assert_ends(pendulum, "x = pi/2", "2", -0.205_639_486_773_336_94);
    assert_ends(pendulum, "x = pi/2", "3", -1.320_582_384_989_074_5);
    assert_ends(pendulum, "x = pi/2", "10", -0.946_862_453_255_903_5);
    // With a speed where no force acts: t, t^9, t^17, … and t, t^21, ….
    let flat = |n: u32| format!("coord x  T = 1/2*x'^2  V = x^{n}");
    assert_ends(&flat(8), "x' = 1", "3", -0.837_375_181_689_475_1);
    assert_ends(&flat(8), "x' = 1", "10", 0.667_185_359_797_238_2);
    assert_ends(&flat(20), "x' = 1", "3", -0.925_863_698_674_628_2);
    assert_ends(&flat(20), "x' = 1", "10", 0.313_036_229_048_016);
    // For a loose tolerance, too, where both last terms vanish.
    for tolerance in [1e-4, 1e-8, 1e-12] {
        for (n, want) in [(8, 0.667_185_359_797_238_2), (20, 0.313_036_229_048_016)] {
            let model = flat(n);
            let file = syntax::parse(&model).unwrap();
            let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
            let system = System::new(&model).unwrap();
            let start = Start::parse("x' = 1", &model, None, &system).unwrap();
            let times = Times::new(&Constant::parse("10").unwrap(), 2).unwrap();
            let found = system.quick(&start, &times, tolerance).unwrap();
            let off = (found.rows[1][0].mid_f64() - want).abs();
            assert!(off < 1e3 * tolerance, "x^{n} to {tolerance}: {off:e}");
        }
    }
}

#[test]
fn forces_that_begin_later() {
    // A hill that is not felt where the motion begins, and turns it back.
    let hill = "coord x  T = 1/2*x'^2  V = exp(-x^2)";
    assert_ends(hill, "x = -20, x' = 1", "40", -20.278_152_886_804_4);
    // A kick at t = 50: the integrals of e^(-u²) and sin(u) e^(-u²), which is Dawson's for half of it.
    let kick = "coord x  T = 1/2*x'^2  V = -x*exp(-(t - 50)^2)";
    assert_ends(kick, "x = 0", "100", 50.0 * std::f64::consts::PI.sqrt());
    let oscillator = "coord x  T = 1/2*x'^2  V = 1/2*x^2 - x*exp(-(t - 50)^2)";
    assert_ends(oscillator, "x = 0", "50", 0.424_436_383_502_022_3);
    let after = std::f64::consts::PI.sqrt() * (-0.25_f64).exp() * 50.0_f64.sin();
    assert_ends(oscillator, "x = 0", "100", after);
    // Two masses that meet: with d = y - x, d = (ln 100 + 2 ln cosh 8(t - t0))/8.
    let pair = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 100*exp(-8*(y - x))";
    // cosh² 8 t0 = e^240/100, and cosh is half an exponential there.
    let t0 = (120.0 - 10.0_f64.ln() + 2.0_f64.ln()) / 8.0;
    let distance = (100.0_f64.ln() + 2.0 * (8.0 * (40.0 - t0) - 2.0_f64.ln())) / 8.0;
    let start = "x = 0, x' = 1, y = 30, y' = -1";
    assert_ends(pair, start, "40", 15.0 - 0.5 * distance);
}

#[test]
fn corners() {
    // V = |x| from x = 1: parabolas of sqrt(2) each.
    let valley = "coord x  T = 1/2*x'^2  V = abs(x)";
    let root = 2.0_f64.sqrt();
    let parabola = |t: f64| {
        let quarters = (t / root).floor();
        let s = t - quarters * root;
        match quarters as i64 % 4 {
            0 => 1.0 - 0.5 * s * s,
            1 => -root * s + 0.5 * s * s,
            2 => -1.0 + 0.5 * s * s,
            _ => root * s - 0.5 * s * s,
        }
    };
    for until in ["2", "5", "20"] {
        assert_ends(valley, "x = 1", until, parabola(until.parse().unwrap()));
    }
    // A second spring on one side: half turns with omega = 1 and sqrt(11).
    let stopper = "coord x  T = 1/2*x'^2  V = 1/2*x^2 + 5*((x + abs(x))/2)^2";
    let fast = 11.0_f64.sqrt();
    let half = std::f64::consts::PI;
    let turns = |t: f64| {
        // From x = -1 at rest to 0 in a quarter, and round.
        let s = (t - 0.5 * half).rem_euclid(half / fast + half);
        if s < half / fast { (fast * s).sin() / fast } else { -(s - half / fast).sin() }
    };
    for until in ["2", "6", "20"] {
        assert_ends(stopper, "x = -1", until, turns(until.parse().unwrap()));
    }
    // A force that changes its sign in time.
    let ramp = "coord x  T = 1/2*x'^2  V = x*abs(t - 2)";
    // x' = 2 - ∫ |t - 2|: x(2) = 1 + 4 - 8/3, then x' = (t - 2)²/-2.
    assert_ends(ramp, "x = 1, x' = 2", "3", 7.0 / 3.0 - 1.0 / 6.0);
}
