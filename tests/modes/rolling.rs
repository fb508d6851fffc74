//! Conditions on velocities: models/rolling against references of 40 digits, numbers that others published, and what is refused.
#![cfg(feature = "engine")]

use crate::common;

use std::path::Path;

use common::{load, model};
use librate::diagnostic::Diagnostic;
use librate::linearize::{Linearized, linearize};
use librate::modes::{Kind, Options, Stability};
use librate::number::Number;
use librate::oscillation::{NormalModes, normal_modes};
use librate::precision::{Ball, Scalar};
use serde_json::Value;

fn ball(text: &str) -> Ball {
    let (negative, digits) = text.strip_prefix('-').map_or((false, text), |rest| (true, rest));
    let number = Number::parse(digits).unwrap();
    Ball::from_number(&if negative { number.neg() } else { number }, ())
}

fn modes(linearized: &Linearized) -> NormalModes {
    normal_modes(linearized, &Options::default()).unwrap()
}

fn of_text(text: &str) -> NormalModes {
    modes(&linearize(model(text)).unwrap())
}

fn error(text: &str) -> String {
    let error = linearize(model(text)).err().unwrap();
    let diagnostic = Diagnostic::from(&error);
    format!("{}: {}", diagnostic.code.unwrap_or_default(), diagnostic.message)
}

#[test]
fn models_agree_with_references() {
    for name in ["ball_in_paraboloid", "bicycle", "disc", "skate_on_spring"] {
        let text = std::fs::read_to_string(format!("tests/reference/rolling/{name}.json")).unwrap();
        let want: Value = serde_json::from_str(&text).unwrap();
        let linearized = linearize(load(Path::new(&format!("models/rolling/{name}.lag")))).unwrap();
        let found = modes(&linearized);
        assert_eq!(found.stability.as_str(), want["stability"].as_str().unwrap(), "{name}");
        let wanted = want["modes"].as_array().unwrap();
        assert_eq!(found.modes.len(), wanted.len(), "{name}");
        for (i, (own, want)) in found.modes.iter().zip(wanted).enumerate() {
            assert_eq!(own.kind.as_str(), want["kind"].as_str().unwrap(), "{name} mode {i}");
            for (own, want) in [(&own.omega, &want["omega"]), (&own.growth, &want["growth"])] {
                let want = ball(want.as_str().unwrap());
                let off = own.sub(&want).mid_f64().abs();
                let size = want.mid_f64().abs();
                assert!(off <= own.radius + 1e-31 * size, "{name} mode {i}: off by {off:e}, bound {:e}", own.radius);
                assert!(off <= 1e-12 * size.max(1.0) && own.radius <= 1e-12 * size.max(1.0), "{name} mode {i}");
            }
        }
    }
}

fn at_speed(text: &str, speed: &str) -> String {
    let own =
        |line: &str| if line.starts_with("param v ") { format!("param v : m/s = {speed}") } else { line.to_owned() };
    text.lines().map(own).collect::<Vec<_>>().join("\n")
}

/// Exponents of M s² + v C1 s + g K0 + v² K2 with the matrices that Meijaard, Papadopoulos, Ruina and Schwab (2007) print for
/// their benchmark, in the 14 digits that these determine: real parts, and imaginary parts behind a comma.
const TABLE: [(&str, &[&str]); 5] = [
    ("0", &["5.5309437176539", "3.1316432479066"]),
    ("1", &["3.5269617099007,0.8077402751993", "-3.1342312506658", "-7.1100801463744"]),
    ("3", &["1.7067560566397,2.3158244738432", "-2.6336613725367", "-10.351014672459"]),
    ("5", &["-0.3228664290041", "-14.078389692798", "-0.7753418821958,4.4648677137882"]),
    ("10", &["0.1610533865317", "-24.624596350174", "-3.7201684043729,10.906811394763"]),
];

#[test]
fn the_bicycle_has_the_exponents_of_its_benchmark() {
    let text = std::fs::read_to_string("models/rolling/bicycle.lag").unwrap();
    for (speed, wanted) in TABLE {
        let found = of_text(&at_speed(&text, speed));
        let mut own = found.modes.iter().filter(|mode| mode.kind != Kind::Zero);
        for want in wanted {
            let (growth, omega) = want.split_once(',').unwrap_or((want, "0"));
            let mode = own.next().unwrap();
            for (own, want) in [(&mode.growth, growth), (&mode.omega, omega)] {
                let want: f64 = want.parse().unwrap();
                assert!((own.mid_f64() - want).abs() <= 2e-13 * want.abs().max(1.0), "v = {speed}: {own:?} {want}");
                assert!(own.radius <= 1e-12 * want.abs().max(1.0), "v = {speed}: {own:?}");
            }
        }
        assert!(own.next().is_none(), "v = {speed}");
        assert_eq!(found.modes.iter().filter(|mode| mode.kind == Kind::Zero).count(), 5);
    }
}

#[test]
fn the_disc_stands_above_its_critical_speed() {
    let text = std::fs::read_to_string("models/rolling/disc.lag").unwrap();
    // v^2 = g*r/3 = 1.635.
    for (speed, stability) in [("1.278", Stability::Unstable), ("1.279", Stability::Neutral)] {
        let found = of_text(&at_speed(&text, speed));
        assert_eq!(found.stability, stability, "{speed}");
        // Motions run backward are motions: a pair ±s is one entry.
        assert_eq!(found.modes.len(), 5, "{speed}");
    }
}

const WHEEL: &str = "param m = 1  param r = 0.2  param k = 5
    coord x, theta
    T = 1/2*m*x'^2 + 1/4*m*r^2*theta'^2
    V = 1/2*k*(x - 0.1)^2";

#[test]
fn what_can_be_integrated_is_a_constraint() {
    let omega = |modes: NormalModes| modes.modes.iter().map(|mode| mode.omega).collect::<Vec<_>>();
    let rolling = omega(of_text(&format!("{WHEEL}  constraint x' = r*theta'  guess x = 0.1")));
    let integrated = omega(of_text(&format!("{WHEEL}  constraint x - 0.1 = r*theta")));
    assert_eq!(rolling.len(), 1);
    assert_eq!(rolling[0].mid_f64(), integrated[0].mid_f64());
    // On an incline the force of the constraint holds it against the spring on its rim.
    let incline = "param m = 1  param r = 0.2  param k = 50  param g = 9.81
        coord x, theta
        T = 1/2*m*x'^2 + 1/4*m*r^2*theta'^2
        V = -m*g*x/2 + 1/2*k*(x + r*theta)^2";
    let rolling = of_text(&format!("{incline}  constraint x' = r*theta'"));
    // 3/2*m*x'' + 4*k*x = m*g/2
    let want = (200.0_f64 / 1.5).sqrt();
    assert!((rolling.modes[0].omega.mid_f64() - want).abs() < 1e-12);
    // Coefficients that depend on the coordinates, but close: r' = r*theta' is ln r = theta.
    let spiral = "coord s, theta  T = 1/2*(s'^2 + theta'^2)  V = 1/2*(s - 1)^2 + 1/2*theta^2  guess s = 1";
    let found = of_text(&format!("{spiral}  constraint s' = s*theta'"));
    assert_eq!(found.modes.len(), 1);
    assert_eq!(found.modes[0].kind, Kind::Oscillation);
    let want = of_text(&format!("{spiral}  constraint ln(s) = theta"));
    assert_eq!(found.modes[0].omega.mid_f64(), want.modes[0].omega.mid_f64());
}

#[test]
fn each_condition_that_stays_leaves_a_family_of_equilibria() {
    // A trailer behind a skate: two conditions, three brackets deep.
    let trailer = "coord x, y, a, b
        T = 1/2*(x'^2 + y'^2) + 1/2*(a'^2 + b'^2)
        V = 1/2*a^2
        constraint cos(a)*y' = sin(a)*x'
        constraint b' = x'*cos(a)*sin(a - b) + y'*sin(a)*sin(a - b)";
    let found = of_text(trailer);
    assert_eq!(found.modes.len(), 4);
    assert!(found.zero_motions.iter().any(|motion| motion == "equilibria with any y"), "{:?}", found.zero_motions);
}

#[test]
fn what_is_not_covered_is_refused() {
    let upright = std::fs::read_to_string("models/rolling/disc.lag").unwrap();
    let slips = error(&upright.replace("equilibrium phi' = v/r", "equilibrium phi' = 2*v/r"));
    assert!(slips.starts_with("E0322"), "{slips}");
    let belt = "coord x, th  T = 1/2*(x'^2 + th'^2)  V = 1/2*x^2 + 1/2*th^2  constraint x' = cos(x)*th' + x";
    assert!(error(belt).starts_with("E0323"), "{}", error(belt));
    let twice = format!("{}\nconstraint x'*sin(psi) = y'*cos(psi)", upright);
    assert!(error(&twice).starts_with("E0323"), "{}", error(&twice));
}
