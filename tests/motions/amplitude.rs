//! Changes of frequencies with the amplitude against references found by other means (tests/reference/amplitudes.py),
//! against exact periods, and resonances that leave none.
#![cfg(feature = "cli")]

use crate::cli_support;

use cli_support::*;
use librate::amplitude::{self, AmplitudeError, Amplitudes, Obstacle, amplitude};
use librate::linearize::{Linearized, linearize};
use librate::model::{Constant, elaborate};
use librate::modes::Options;
use librate::motion::{Start, System, Times};
use librate::number::Number;
use librate::oscillation::{NormalModes, normal_modes};
use librate::period::{self, Oscillator, Request};
use librate::precision::{Ball, Scalar};
use librate::report::{Style, amplitude_text};
use librate::syntax;
use librate_studies::amplitude::ModeAmplitude;
use serde_json::Value;

fn whole(text: &str) -> (Linearized, NormalModes, Amplitudes) {
    let file = syntax::parse(text).unwrap_or_else(|errors| panic!("{text}: {errors:?}"));
    let model = elaborate(&file, &Default::default(), &Default::default()).unwrap();
    let linearized = linearize(model).unwrap_or_else(|error| panic!("{text}: {error}"));
    let modes = normal_modes(&linearized, &Options::default().digits(14)).unwrap();
    let found = amplitude(&linearized, &modes).unwrap_or_else(|error| panic!("{text}: {error}"));
    (linearized, modes, found)
}

fn changes(text: &str) -> Vec<ModeAmplitude> {
    whole(text).2.modes
}

fn ball(text: &str) -> Ball {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1, digits),
        None => (1, text),
    };
    let number = Number::parse(digits).unwrap().mul(&Number::from(sign));
    Ball::from_number(&number, ())
}

/// The bound holds for what is known to 40 digits, and is worth something.
fn assert_is(what: &str, own: &ModeAmplitude, want: &Ball) {
    let change = own.change.unwrap_or_else(|| panic!("{what}: {own:?}"));
    let off = change.sub(want).mid_f64().abs();
    assert!(off <= change.radius + 1e-31 * want.mid_f64().abs(), "{what}: {change:?} is off by {off:e}");
    assert!(change.radius <= 1e-12 * want.mid_f64().abs().max(0.1), "{what}: {change:?}");
}

#[test]
fn changes_agree_with_periodic_motions() {
    let text = std::fs::read_to_string("tests/reference/amplitudes.json").unwrap();
    let cases: Vec<Value> = serde_json::from_str(&text).unwrap();
    assert!(cases.len() >= 8);
    for case in cases {
        let file = case["file"].as_str().unwrap();
        let own = changes(&std::fs::read_to_string(file).unwrap());
        let want = case["changes"].as_array().unwrap();
        assert_eq!(own.len(), want.len(), "{file}");
        for (at, (own, want)) in own.iter().zip(want).enumerate() {
            let what = format!("{file}, mode {}", at + 1);
            match want.as_str() {
                Some(want) => assert_is(&what, own, &ball(want)),
                None => assert!(own.change.is_none() && own.obstacle.is_some(), "{what}"),
            }
        }
    }
}

/// One coordinate: what the exact quadrature of the period has for the same number, by another way.
#[test]
fn one_coordinate_changes_as_its_period_does() {
    for text in [
        "coord x  T = 1/2*x'^2  V = (1 - exp(-x))^2",
        // Neither acts.
        "param c = 0  coord x  T = 1/2*x'^2  V = 1 - cos(x)  dissipation = c*x'^2  force x = -2*c*x'",
        "coord x  T = 1/2*x'^2  V = 1/2*x^2 + x^3/3 + x^4/7",
        "coord x  T = 1/2*(1 + x + x^2/3)*x'^2  V = cosh(x) + x^3",
        "coord x  T = 1/2*(1 + x/2)^2*x'^2  V = 1/2*(x + x^2/4)^2",
        "param w = 2  coord th  T = 1/2*th'^2 + 1/2*w^2*sin(th)^2  V = -9*cos(th)",
        "coord th  T = 1/2*(2 + sin(th))*th'^2  V = sin(th)^2 + th^2  guess th = 1/3",
        "coord x  lagrangian = 1/2*x'^2 + x^2*x' - x^2 - x^4",
    ] {
        let (linearized, _, found) = whole(text);
        let oscillator = Oscillator::new(&linearized).unwrap();
        let request = Request::Amplitude(Constant::parse("1/1000").unwrap());
        let period = oscillator.period(&request, &period::Options::default());
        let bend = period.unwrap().bend.unwrap();
        let own = found.modes[0].change.unwrap();
        assert!(own.sub(&bend).contains_zero(), "{text}: {own:?}, {bend:?}");
        assert!(own.radius < 1e-12, "{text}: {own:?}");
    }
}

/// By symmetry a straight motion of two coordinates is that of one, whatever the coordinates are called.
#[test]
fn equal_frequencies_that_are_not_coupled_keep_their_change() {
    let file = "models/amplitude/henon_heiles.lag";
    let both = changes(&std::fs::read_to_string(file).unwrap());
    let want = ball("5").div(&ball("-12"));
    for (at, own) in both.iter().enumerate() {
        assert_is("Hénon and Heiles", own, &want);
        assert_eq!(own.equal, [1 - at]);
    }
    // The same in coordinates that make M no multiple of 1: shapes of one frequency are orthonormal in M alone. Straight motions in
    // all directions have the same change in the normal coordinate.
    let skew = "coord u, v  let x = u + v/2  let y = v
        T = 1/2*(x'^2 + y'^2)  V = 1/2*(x^2 + y^2) + x^2*y - 1/3*y^3";
    let (_, modes, found) = whole(skew);
    for (mode, own) in modes.modes.iter().zip(&found.modes) {
        let largest = mode.vector[own.coordinate];
        let change = own.change.unwrap().mid_f64() * largest * largest;
        assert!((change + 5.0 / 12.0).abs() < 1e-12, "{change}");
    }
    // Two equal quartic springs along x and y: diagonals and axes are modes, and nothing between them is.
    let quartic = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*x^2 + 1/2*y^2 + 1/4*(x^4 + y^4)";
    for own in changes(quartic) {
        assert_is("two springs", &own, &ball("0.375"));
        assert_eq!(own.equal.len(), 1);
    }
    let tilted = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*x^2 + 1/2*y^2 + 1/4*(3/5*x + 4/5*y)^4";
    for (at, own) in changes(tilted).iter().enumerate() {
        assert_eq!(own.obstacle, Some(Obstacle::OneToOne { with: 1 - at }));
        assert!(own.change.is_none());
    }
    // Tuned to the same frequency, and kept apart by the sign of x.
    let tuned = "coord x, y  T = 1/2*x'^2 + y'^2  V = 1/2*x^2 + y^2 + x^2*y^2 + 1/4*x^4 + y^4";
    let own = changes(tuned);
    assert!(own.iter().all(|own| own.change.is_some() && own.equal.len() == 1));
}

#[test]
fn resonances_are_recognised() {
    let pair = |rest: &str| {
        let text = format!("param s = 4  coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*x^2 + {rest}");
        changes(&text)
    };
    let two = pair("2*y^2 + x^2*y/10");
    assert_eq!(two[0].obstacle, Some(Obstacle::OneToTwo { with: 1 }));
    // x = 0 is a motion of its own, and the spring of y is linear.
    assert_is("the fast one", &two[1], &Ball::ZERO);
    assert_eq!((two[1].drives, two[0].drives), (Some(0), None));
    // Twice the frequency, but not driven at it.
    let apart = pair("2*y^2 + x^2*y^2/10 + x^4/4");
    assert_is("not driven", &apart[0], &ball("0.375"));
    assert_eq!((apart[0].obstacle, apart[0].equal.len()), (None, 0));
    let three = pair("9/2*y^2 + x^3*y/10");
    assert_eq!(three[0].obstacle, Some(Obstacle::OneToThree { with: 1 }));
    // y moves with the mean of x², and nothing brings it back.
    let drift = pair("x^2*y/10 + y^4");
    let slow = drift.iter().position(|own| own.change.is_none()).unwrap();
    assert_eq!(drift[slow].obstacle, Some(Obstacle::NoOscillation));
    assert_eq!(drift[1 - slow].obstacle, Some(Obstacle::Drift { with: slow }));
    // Near: told by the range.
    let reach = |stiffness: &str| {
        let own = pair(&format!("1/2*{stiffness}*y^2 + x^2*y/10"));
        own[0].reach.unwrap()
    };
    let (far, near) = (reach("3"), reach("3.999"));
    // (0.1/2)/(4 - k) of the mode's own square reaches a tenth of it.
    assert!((near / 0.002 - 1.0).abs() < 1e-9, "{near}");
    assert!(far > 100.0 * near);
    // A wave in the third harmonic, as near.
    let third = pair("1/2*8.999*y^2 + x^3*y");
    let want = (0.1_f64 * 0.001 / 0.25).sqrt();
    assert!((third[0].reach.unwrap() / want - 1.0).abs() < 1e-6);
}

/// A free body: what is turned and displaced as a whole changes nothing.
#[test]
fn free_motions_are_no_obstacle() {
    let text = "coord x[1..2]  T = 1/2*(x[1]'^2 + x[2]'^2)  V = 1/2*(x[2] - x[1])^2 + 1/4*(x[2] - x[1])^4";
    let own = changes(text);
    assert_eq!(own[0].obstacle, Some(Obstacle::NoOscillation));
    // Reduced mass 1/2 and s = 2 x: omega² = 2, s'' = -2 s - 2 s³, change 3/8 of s², 3/2 of x².
    assert_is("dumbbell", &own[1], &ball("1.5"));
    // A body that may turn in the plane, too, breathes as if it could not.
    let plane = "coord r[1..2,1..2]
        let d = [r[2,1] - r[1,1], r[2,2] - r[1,2]]
        let s = sqrt(dot(d, d))
        T = sum(i in 1..2, j in 1..2, 1/2*r[i,j]'^2)
        V = 1/2*(s - 1)^2 + 1/4*(s - 1)^4
        equilibrium r[1,1] = 0  equilibrium r[1,2] = 0  equilibrium r[2,1] = 1  equilibrium r[2,2] = 0";
    let own = changes(plane);
    assert_eq!(own.iter().filter(|own| own.change.is_some()).count(), 1);
    assert_is("in the plane", own.last().unwrap(), &ball("1.5"));
}

/// An integrated motion comes back after the period that is said, up to the next power of the amplitude.
#[test]
fn motions_have_the_frequency() {
    let chain = "coord x[1..3]
        let u[0] = 0  let u[i in 1..3] = x[i]  let u[4] = 0
        T = sum(i in 1..3, 1/2*x[i]'^2)
        V = sum(i in 0..3, 1/2*(u[i+1] - u[i])^2 + 1/4*(u[i+1] - u[i])^4)";
    let (linearized, modes, found) = whole(chain);
    // The middle mode (1, 0, -1) of the symmetric chain is straight at all amplitudes: x'' = -2 x - 2 x³.
    assert_is("the middle mode", &found.modes[1], &ball("0.375"));
    let system = System::new(linearized.model()).unwrap();
    let size = 0.01;
    let amplitude = Constant::parse("1/100").unwrap();
    let start = Start::mode(2, &amplitude, linearized.model(), (&linearized, &modes), &system).unwrap();
    let omega = 2.0_f64.sqrt();
    let phase_after = |change: f64| {
        let period = std::f64::consts::TAU / (omega * (1.0 + change * size * size));
        let end = Constant::parse(&format!("{period:.17e}")).unwrap();
        let motion = system.motion(&start, &Times::new(&end, 2).unwrap()).unwrap();
        let row = motion.rows.last().unwrap();
        (row[3].mid_f64() / (omega * size)).abs()
    };
    let change = found.modes[1].change.unwrap().mid_f64();
    assert!(phase_after(change) < 2.0 * size.powi(4));
    assert!(phase_after(0.0) > 100.0 * phase_after(change));
}

#[test]
fn large_chains_are_covered() {
    let text = std::fs::read_to_string("models/fput_chain.lag").unwrap();
    let own = changes(&text);
    assert_eq!(own.len(), 32);
    let text = text.replace("N = 32", "N = 5");
    let (linearized, modes, few) = whole(&text);
    assert!(few.modes.iter().all(|own| own.change.unwrap().is_positive()));
    // Mode j of the β-chain shifts by itself alone: V4 summed over the bonds, with bond displacements of the shape.
    let n = 5.0_f64;
    for (at, (own, mode)) in few.modes.iter().zip(&modes.modes).enumerate() {
        let mut bonds = vec![0.0];
        bonds.extend(&mode.vector);
        bonds.push(0.0);
        let quartic: f64 = bonds.windows(2).map(|b| (b[1] - b[0]).powi(4)).sum();
        let omega = 2.0 * (std::f64::consts::FRAC_PI_2 * (at as f64 + 1.0) / (n + 1.0)).sin();
        // V = beta/4 quartic a⁴: omega(1 + 3/8 beta quartic a²/omega²), A = a times the largest component.
        let largest = mode.vector[own.coordinate];
        let want = 3.0 / 8.0 * 0.3 * quartic / (omega * omega * largest * largest);
        let change = own.change.unwrap().mid_f64();
        assert!((change / want - 1.0).abs() < 1e-12, "{change} {want}");
    }
    assert_eq!(linearized.dimension(), 5);
}

#[test]
fn changes_print_as_before() {
    insta::glob!("../../models/amplitude", "*.lag", |path| {
        let text = std::fs::read_to_string(path).unwrap();
        let (linearized, modes, found) = whole(&text);
        let out = amplitude_text(&linearized, &modes, &found, 10, &Style::default());
        insta::with_settings!({ snapshot_path => "../../models/amplitude/snapshots", prepend_module_to_snapshot => false, omit_expression => true }, {
            insta::assert_snapshot!(out);
        });
    });
}

#[test]
fn the_command_prints_the_same() {
    let file = "models/elastic_pendulum.lag";
    let text = printed(&["amplitude", file]);
    assert!(text.contains("1:2 with mode 2"), "{text}");
    let json: Value = serde_json::from_str(&printed(&["amplitude", file, "--json"])).unwrap();
    let modes = json["modes"].as_array().unwrap();
    assert!(modes[0]["frequency_change"].is_null());
    assert_eq!(modes[0]["obstacle"]["kind"], "1:2");
    assert_eq!(modes[0]["obstacle"]["mode"], 2);
    assert_eq!(modes[1]["frequency_change"], 0.0);
    assert_eq!(modes[1]["drives"], 1);
    let driven = run(&["amplitude", "models/mathieu.lag"]);
    assert_eq!(driven.status, 1);
    assert!(driven.err.contains("E0801"), "{}", driven.err);
}

#[test]
fn too_many_terms_are_told_before_anything_is_computed() {
    // Half a million pairs: their modes alone would take seconds.
    let text = "param N = 708  coord x[1..N]  T = sum(i in 1..N, x[i]'^2)  \
                V = sum(i in 1..N, sum(j in 1..N, (x[i] - x[j])^4 + x[i]^2))";
    let file = syntax::parse(text).unwrap();
    let model = elaborate(&file, &Default::default(), &Default::default()).unwrap();
    let error = amplitude::check(&model).unwrap_err();
    let AmplitudeError::TooLarge { terms, most } = &error else { panic!("{error}") };
    assert!(*terms >= 708 * 708 && *most < *terms);
    assert_eq!(error.code(), "E0806");
    assert!(error.to_string().contains(&terms.to_string()), "{error}");
}

#[test]
fn numbers_far_from_usual_ones_change_nothing() {
    // 3/8 for V = x²/2 + x⁴/4, -1/16 for a pendulum, each times any energy.
    for (text, want) in [
        ("coord x  T = x'^2/2  V = exp(-800)*(x^2/2 + x^4/4)", 0.375),
        ("coord x  T = 1e-300*x'^2/2  V = 1e-290*(x^2/2 - x^4/4)", -0.375),
        (
            "param m = 1e-300  param g = 1e250  param l = 1e100  coord phi
          T = m*l^2*phi'^2/2  V = m*g*l*(1 - cos(phi))",
            -0.0625,
        ),
    ] {
        let own = &changes(text)[0];
        assert_is(text, own, &Ball::exact(want));
        assert!(own.reach.is_some_and(|reach| (0.1..2.0).contains(&reach)), "{text}");
    }
}
