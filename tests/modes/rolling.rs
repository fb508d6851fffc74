//! Conditions on velocities: models/rolling against references of 40 digits, numbers that others published, and what is refused.
#![cfg(feature = "engine")]

use crate::common;

use std::path::Path;

use common::{load, model};
use faer::c64;
use librate::derive::{Parts, derive, in_independent_coordinates, linearized};
use librate::diagnostic::Diagnostic;
use librate::linearize::{Linearized, linearize};
use librate::modes::{Kind, Options, Stability};
use librate::number::Number;
use librate::oscillation::{NormalMode, NormalModes, normal_modes};
use librate::precision::{Ball, Scalar};
use librate::sensitivity::sensitivities;
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
    for name in ["ball_in_paraboloid", "bicycle", "disc", "hoop", "knife_edge", "skate_on_spring"] {
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

/// Conditions that are derivatives of relations of the coordinates, which hold where the search starts.
#[test]
fn gradients_are_integrated() {
    let plane = "param g = 9.81  param l = 2  coord x, y  T = 1/2*(x'^2 + y'^2)  V = g*y";
    let below = "equilibrium x = 0  equilibrium y = -l";
    let space = "param g = 9.81  coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)  V = g*z";
    for (text, condition, relation) in [
        (format!("{plane}  {below}"), "x*x' + y*y' = 0", "x^2 + y^2 = l^2"),
        (format!("{plane}  {below}"), "3*x*x' = -3*y*y'", "x^2 + y^2 = l^2"),
        (format!("{plane}  guess x = 1/10  guess y = -l"), "x*x' + y*y' = 0", "x^2 + y^2 = l^2 + 1/100"),
        (plane.to_owned(), "y' = sin(x)*x'", "y = 1 - cos(x)"),
        (plane.to_owned(), "(1 + y)*x*x' + 1/2*x^2*y' - y' = 0", "1/2*(1 + y)*x^2 = y"),
        (space.to_owned(), "z' = x*x' + 2*y*y'", "z = 1/2*x^2 + y^2"),
        (space.to_owned(), "z' = (x + y)*(x' + y') + y'*cos(y)*sin(y)", "2*z = (x + y)^2 + sin(y)^2"),
    ] {
        let [own, other] = [condition, relation].map(|tie| of_text(&format!("{text}  constraint {tie}")));
        assert_eq!((own.stability, own.modes.len()), (other.stability, other.modes.len()), "{condition}");
        for (own, other) in own.modes.iter().zip(&other.modes) {
            assert!((own.omega - other.omega).contains_zero() && own.omega.radius < 1e-12, "{condition}: {own:?}");
            assert_eq!(own.vector.len(), other.vector.len());
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

fn found(name: &str, changes: &[(&str, &str)]) -> NormalModes {
    let mut text = std::fs::read_to_string(format!("models/rolling/{name}.lag")).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    modes(&linearized(model(&text)).unwrap())
}

/// The frequency in the closed form of models/rolling/disc_in_circle.lag, from Euler's equations with the velocity of rotation about
/// the diameter, the axis and the line of steepest descent.
fn in_circle(turning: f64, lean: f64) -> f64 {
    let (m, r, g) = (2.0, 0.5, 9.81);
    let (a, c) = (m * r * r / 4.0, m * r * r / 2.0);
    let b = c + m * r * r;
    let (up, across) = (turning * lean.sin(), turning * lean.cos());
    let spin = (a * up - m * g * r * lean.tan() / turning) / b;
    let k = up - c * spin / a;
    let square = a * turning * turning + k * (2.0 * a * up - b * spin) + m * r * r * across * across;
    (square - m * g * r * lean.cos()) / (a + m * r * r)
}

#[test]
fn a_disc_leans_in_a_circle() {
    for (turning, lean) in [("2", "-asin(3/5)"), ("1", "-asin(7/25)"), ("-3", "asin(3/5)")] {
        let changes = [("rad/s = 2", format!("rad/s = {turning}")), ("rad = -asin(3/5)", format!("rad = {lean}"))];
        let changes = changes.each_ref().map(|(from, to)| (*from, to.as_str()));
        let found = found("disc_in_circle", &changes);
        let sine: f64 = if lean.contains("25") { -0.28 } else { 0.6 * if lean.starts_with('-') { -1.0 } else { 1.0 } };
        let want = in_circle(turning.parse().unwrap(), sine.asin());
        let swings: Vec<f64> =
            found.modes.iter().filter(|own| own.kind == Kind::Oscillation).map(|own| own.omega.mid_f64()).collect();
        assert_eq!(swings.len(), 1, "{turning} {lean}: {:?}", found.modes);
        assert!((swings[0] * swings[0] - want).abs() < 1e-11 * want, "{turning} {lean}: {swings:?} {want}");
    }
    // With another turning rate nothing holds it.
    let text = std::fs::read_to_string("models/rolling/disc_in_circle.lag").unwrap();
    assert!(linearized(model(&text.replace("psi' = W", "psi' = 2*W"))).is_err());
}

/// Turning rate, and growth and frequency of both modes, from tests/reference/rattleback.py.
const RATTLES: [(&str, [[f64; 2]; 2]); 3] = [
    ("5", [[0.06799761326302043, 20.82592718430309], [-1.697707516564121, 101.127609130966]]),
    ("-5", [[-0.06799761326302043, 20.82592718430309], [1.697707516564121, 101.127609130966]]),
    ("0.5", [[0.007153936049948025, 20.22359394201563], [-0.1701249263800581, 98.59206827758509]]),
];

#[test]
fn a_rattleback_tells_the_ways_of_turning_apart() {
    for (turning, wants) in RATTLES {
        let mut found = found("rattleback", &[("rad/s  = 5", &format!("rad/s = {turning}"))]).modes;
        found.retain(|mode| mode.kind != Kind::Zero);
        found.sort_by(|a, b| a.omega.mid_f64().total_cmp(&b.omega.mid_f64()));
        assert_eq!(found.len(), 2, "{turning}");
        for (own, [growth, omega]) in found.iter().zip(wants) {
            let off = (own.growth.mid_f64() - growth).abs().max((own.omega.mid_f64() - omega).abs());
            assert!(off < 1e-12, "{turning}: {own:?}");
        }
    }
}

#[test]
fn a_sleigh_slides_on_with_its_centre_ahead() {
    for (ahead, stability) in [("0.2", Stability::Neutral), ("-0.2", Stability::Unstable)] {
        let change = format!("param a : m      = {ahead}");
        let found = found("sleigh", &[("param a : m      = 0.2", &change)]);
        let ahead: f64 = ahead.parse().unwrap();
        let want = -1.5 * ahead * 3.0 / (0.3 + 1.5 * ahead * ahead);
        let moving: Vec<f64> =
            found.modes.iter().filter(|own| own.kind != Kind::Zero).map(|own| own.growth.mid_f64()).collect();
        assert_eq!(moving.len(), 1, "{:?}", found.modes);
        assert!((moving[0] - want).abs() < 1e-12, "{moving:?} {want}");
        assert_eq!(found.stability, stability);
    }
}

/// A sleigh held across a slope by its blade, with a spring that turns it back: forces of constraint at rest.
#[test]
fn a_blade_holds_a_sleigh_on_a_slope() {
    let held = "param m = 1.5  param J = 0.3  param k = 2  param g = 9.81
        coord x, y, th
        T = 1/2*m*(x'^2 + y'^2) + 1/2*J*th'^2
        V = 1/2*k*th^2 + m*g*y/10
        constraint cos(th)*y' = sin(th)*x'";
    assert!(linearize(model(held)).is_err());
    let found = modes(&linearized(model(held)).unwrap());
    // m*x'' = -m*g/10*th, J*th'' = -k*th: the other exponents are 0, twice.
    let swings: Vec<f64> =
        found.modes.iter().filter(|own| own.kind == Kind::Oscillation).map(|own| own.omega.mid_f64()).collect();
    assert_eq!(swings.len(), 1, "{:?}", found.modes);
    assert!((swings[0] - (2.0_f64 / 0.3).sqrt()).abs() < 1e-12, "{swings:?}");
}

/// The hoop, whose mass is in its rim, stands above v^2 = g*r/4.
#[test]
fn a_hoop_stands_above_its_critical_speed() {
    // 0.981
    for (speed, stability) in [("0.990", Stability::Unstable), ("0.991", Stability::Neutral)] {
        let found = found("hoop", &[("m/s   = 1.5", &format!("m/s   = {speed}"))]);
        assert_eq!(found.stability, stability, "{speed}");
    }
}

#[test]
fn sensitivities_are_those_in_independent_velocities() {
    let of = |name: &str| {
        let own = in_independent_coordinates(&load(Path::new(&format!("models/rolling/{name}.lag")))).unwrap();
        let linearized = linearize(own).unwrap();
        let modes = modes(&linearized);
        let found = sensitivities(&linearized, &modes);
        let last = found.omega.last().unwrap();
        last.iter().map(|own| own.unwrap().mid_f64()).collect::<Vec<f64>>()
    };
    // By W and the lean, against differences of the closed form.
    let step = 1e-5;
    let lean = -(0.6_f64).asin();
    let omega = |turning: f64, lean: f64| in_circle(turning, lean).sqrt();
    let by_turning = (omega(2.0 + step, lean) - omega(2.0 - step, lean)) / (2.0 * step);
    let by_lean = (omega(2.0, lean + step) - omega(2.0, lean - step)) / (2.0 * step);
    let own = of("disc_in_circle");
    assert!((own[3] - by_turning).abs() < 1e-7 && (own[4] - by_lean).abs() < 1e-7, "{own:?}");
    // k/(J + m*a^2), by m, J, a and k.
    let (m, j, a, k) = (1.5, 0.3, 0.2, 2.0_f64);
    let inertia: f64 = j + m * a * a;
    let omega = (k / inertia).sqrt();
    let per_inertia = -omega / (2.0 * inertia);
    let wants = [per_inertia * a * a, per_inertia, per_inertia * 2.0 * m * a, omega / (2.0 * k)];
    for (own, want) in of("skate_on_spring").iter().zip(wants) {
        assert!((own - want).abs() < 1e-12, "{own} {want}");
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
    // One of them is a relation of the coordinates, in no form that is seen.
    let both = "coord x, y, z, th  T = 1/2*(x'^2 + y'^2 + z'^2 + th'^2)  V = 1/2*th^2 + z^2
        constraint x' = (2 + cos(x))*th'  constraint y' = th*z'";
    assert!(error(both).starts_with("E0323"), "{}", error(both));
    // z = 2*exp(-x) through the guess, and not where the potential is least.
    let leaf =
        "coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)  V = 1/2*(x^2 + y^2) + 1/2*(z - 1)^2  constraint z' = -z*x'";
    for guess in ["guess z = 2", "guess z = 1  guess y = 1/2"] {
        let error = error(&format!("{leaf}  {guess}"));
        assert!(error.starts_with("E0323") && error.contains("`guess`"), "{error}");
    }
    for told in ["", "guess z = 1", "equilibrium z = 1  guess x = 0"] {
        assert_eq!(of_text(&format!("{leaf}  {told}")).modes.len(), 2, "{told}");
    }
    let here = derive(&model(&format!("{leaf}  guess z = 1")), &Parts::all()).unwrap();
    assert!(here.linear.is_ok());
    // A spin that a condition depends on: not that the energies do.
    let blade =
        "coord x, y, th  T = 1/2*(x'^2 + y'^2 + th'^2)  constraint sin(th)*x' = cos(th)*y'  equilibrium th' = 2";
    assert!(error(blade).starts_with("E0323"), "{}", error(blade));
}

/// Conditions that follow from constraints or from others, wherever it is, change nothing, and are told.
#[test]
fn conditions_that_follow_from_others_change_nothing() {
    let plane = "param g = 9.81  coord x, y  T = 1/2*(x'^2 + y'^2)";
    let ring = "coord a, b, c  T = a'^2 + b'^2 + c'^2  V = a^2 + b^2 + 3*c^2  constraint a' = -b'";
    let disc = std::fs::read_to_string("models/rolling/disc.lag").unwrap();
    let leaning = "param m = 2, r = 0.5, g = 9.81, v = 2  coord x, y, z, psi, th, phi
        let E = rot_z(psi)*rot_x(th)  let R = E*rot_y(phi)
        let w = R*angular_velocity(R)  let d = E*[0, 0, -r]  let u = angular_velocity(R)
        let s = [x, y, z]' + cross(w, d)
        T = 1/2*m*(x'^2 + y'^2 + z'^2) + 1/8*m*r^2*(u[1]^2 + 2*u[2]^2 + u[3]^2)  V = m*g*z
        constraint z = r*cos(th)  equilibrium x' = v  equilibrium phi' = v/r  equilibrium z = r";
    // A ball in a bowl with its axis along z, or x: of its conditions that across the bowl says nothing at the bottom.
    let bowl = |up: &str, two: &str, slip: &str| {
        format!(
            "param m = 0.4, r = 0.1, g = 9.81, R = 1.5  coord q[1..2], a[1..3]  let h = (q[1]^2 + q[2]^2)/(2*R)
            let p = {up}  let n = {two}
            let Q = rot_x(a[1])*rot_y(a[2])*rot_z(a[3])  let w = Q*angular_velocity(Q)  let s = p' - cross(w, r*n)
            T = 1/2*m*dot(p', p') + 1/5*m*r^2*dot(w, w)  V = m*g*h  guess q[1] = 1e-3
            {slip}"
        )
    };
    let steep = "1/sqrt(1 + 2*h/R)";
    let upright =
        bowl("[q[1], q[2], h]", &format!("[-q[1]/R, -q[2]/R, 1]*{steep}"), "constraint s[1] = 0  constraint s[2] = 0");
    let aside =
        bowl("[h, q[1], q[2]]", &format!("[1, -q[1]/R, -q[2]/R]*{steep}"), "constraint s[2] = 0  constraint s[3] = 0");
    let whole = |text: &str| text.split("constraint s[").next().unwrap().to_owned() + "constraint s = [0, 0, 0]";
    for (own, fewer) in [
        (
            format!("{plane}  V = x^2  constraint x = 3*y + 1  constraint x' = 3*y'"),
            format!("{plane}  V = x^2  constraint x = 3*y + 1"),
        ),
        (
            format!("{plane}  V = g*y  constraint x^2 + y^2 = 4  constraint x*x' + y*y' = 0  guess y = -2.1"),
            format!("{plane}  V = g*y  constraint x^2 + y^2 = 4  guess y = -2.1"),
        ),
        (format!("{ring}  constraint b' = -c'  constraint a' = c'"), format!("{ring}  constraint b' = -c'")),
        (format!("{disc}\nconstraint x'*sin(psi) = y'*cos(psi)"), disc.clone()),
        (
            format!("{leaning}  constraint s = [0, 0, 0]"),
            format!("{leaning}  constraint s[1] = 0  constraint s[2] = 0"),
        ),
        (whole(&upright), upright.clone()),
        (whole(&aside), aside.clone()),
    ] {
        let [linear, other] = [&own, &fewer].map(|text| linearize(model(text)).unwrap());
        let [found, want] = [&linear, &other].map(modes);
        assert_eq!((found.modes.len(), found.stability), (want.modes.len(), want.stability), "{own}");
        for (one, two) in found.modes.iter().zip(&want.modes) {
            assert!((one.omega - two.omega).contains_zero() && (one.growth - two.growth).contains_zero(), "{own}");
        }
        let codes: Vec<_> = found.warnings(&linear).iter().filter_map(|own| own.code).collect();
        assert_eq!(codes.iter().filter(|own| **own == "W0105").count(), 1, "{own}: {codes:?}");
    }
    let swings = of_text(&whole(&aside)).modes.iter().map(|mode| mode.omega.mid_f64()).fold(0.0, f64::max);
    assert!((swings - (5.0_f64 / 7.0 * 9.81 / 1.5).sqrt()).abs() < 1e-12, "{swings}");
}

/// Where no place is free of forces that is told, and no condition on velocities is blamed that is a relation of coordinates.
/// The equations of a disc that rolls upright or leans, as Neimark and Fufaev have them: what cos² + sin² is goes away at once.
#[test]
fn equations_of_a_rolling_disc_are_short() {
    let text = "param m, r, g, I, J  coord X, Y, ph, th, ps
        T = 1/2*m*(X'^2 + Y'^2 + r^2*sin(th)^2*th'^2) + 1/2*I*(th'^2 + ph'^2*cos(th)^2) + 1/2*J*(ps' - ph'*sin(th))^2
        V = m*g*r*cos(th)
        constraint X'*cos(ph) + Y'*sin(ph) + r*sin(th)*ph' = r*ps'
        constraint -X'*sin(ph) + Y'*cos(ph) = r*cos(th)*th'";
    let page = derive(&model(text), &Parts::all()).unwrap();
    let reduced = page.independent.as_ref().unwrap();
    let found: Vec<String> = reduced.equations.iter().map(|own| page.text(own)).collect();
    let want = [
        "(I*cos(th)^2 + (J + m*r^2)*sin(th)^2)*ph'' - (J + m*r^2)*ps''*sin(th) \
         + 2*(J + m*r^2 - I)*ph'*th'*sin(th)*cos(th) - J*th'*ps'*cos(th)",
        "(I + m*r^2)*th'' + (I - J - m*r^2)*ph'^2*sin(th)*cos(th) + (J + m*r^2)*ph'*ps'*cos(th) - m*r*g*sin(th)",
        "-(J + m*r^2)*ph''*sin(th) + (J + m*r^2)*ps'' - (J + 2*m*r^2)*ph'*th'*cos(th)",
    ];
    assert_eq!(found, want);
}

/// A load that conditions bear leaves all coordinates at 0, as one that is given there: x'' + 2 x - 5 theta = 0, theta'' + 3 theta = 0.
#[test]
fn conditions_bear_a_load_at_zero() {
    for condition in ["y' = th*x'", "sin(th)*x' = cos(th)*y'"] {
        let text =
            format!("coord x, y, th  T = 1/2*(x'^2 + y'^2 + th'^2)  V = x^2 - 5*y + 3/2*th^2  constraint {condition}");
        let linearized = linearized(model(&text)).unwrap();
        let own = modes(&linearized).modes;
        let kinds: Vec<Kind> = own.iter().map(|mode| mode.kind).collect();
        assert_eq!(kinds, [Kind::Zero, Kind::Oscillation, Kind::Oscillation], "{condition}");
        let squares: Vec<f64> = own.iter().map(|mode| mode.omega.mid_f64().powi(2)).collect();
        assert!(squares[0] == 0.0 && (squares[1] - 2.0).abs() < 1e-14 && (squares[2] - 3.0).abs() < 1e-14);
        assert!((own[2].vector[0] + 5.0 * own[2].vector[2]).abs() < 1e-14 && own[2].vector.len() == 3);
        let page = derive(&model(&text), &Parts::default().frequencies(true)).unwrap();
        assert!(page.linear.is_ok());
    }
}

#[test]
fn there_may_be_no_equilibrium() {
    let roller = "param g = 9.81  coord x, th  T = 1/2*(x'^2 + th'^2)  V = -g*x/2  constraint x' = 3*th'";
    let error = linearized(model(roller)).unwrap_err();
    assert_eq!(Diagnostic::from(&error).code, Some("E0303"));
}

/// A pendulum on a wheel that rolls: the same in a frame that moves along.
#[test]
fn steady_rolling_is_rest_in_another_frame() {
    let model = |tie: &str| {
        of_text(&format!(
            "param M = 2, J = 0.5, m = 1, l = 0.4, R = 0.5, g = 9.81, W = 3  coord x, th, phi
             T = 1/2*M*x'^2 + 1/2*J*th'^2 + 1/2*m*((x' + l*phi'*cos(phi))^2 + (l*phi'*sin(phi))^2)
             V = -m*g*l*cos(phi)  {tie}  equilibrium x' = R*W  equilibrium th' = W"
        ))
    };
    for tie in ["constraint x' = R*th'", "constraint x = R*th"] {
        let found = model(tie);
        let [zero, mode] = &found.modes[..] else { panic!("{found:?}") };
        assert_eq!((zero.kind, mode.kind), (Kind::Zero, Kind::Oscillation));
        // g/l (Me + m)/Me with Me = M + J/R² = 4.
        assert!((mode.omega * mode.omega - ball("24.525") * ball("5") / ball("4")).contains_zero());
    }
    // At other rates the wheel slips.
    let slips = linearize(common::model(
        "coord x, th  T = 1/2*x'^2 + 1/2*th'^2  V = 0  constraint x = 2*th  equilibrium x' = 3  equilibrium th' = 1",
    ));
    assert_eq!(Diagnostic::from(&slips.unwrap_err()).code, Some("E0312"));
}

/// What conditions leave open may be held by springs: the others follow along the family of equilibria.
#[test]
fn families_of_equilibria_may_take_others_along() {
    let skate = |v: &str| {
        of_text(&format!("coord x, y, th  T = 1/2*(x'^2 + y'^2 + th'^2)  V = {v}  constraint cos(th)*y' = sin(th)*x'"))
    };
    // y rests anywhere, and x with it.
    let found = skate("1/2*th^2 + 1/2*(x - y)^2");
    let [zero, others @ ..] = &found.modes[..] else { panic!() };
    assert_eq!((zero.kind, others.len(), found.stability), (Kind::Zero, 2, Stability::Stable));
    let half = 0.5_f64.sqrt();
    for (x, want) in zero.vector.iter().zip([half, half, 0.0]) {
        assert!((x - want).abs() < 1e-15, "{:?}", zero.vector);
    }
    assert!(others.iter().all(|mode| (mode.omega - Ball::ONE).contains_zero()));
    // 2 x - y = 0 and th = y/3 along the family.
    let found = skate("x^2 - x*y + 3/2*th^2 - th*y");
    let [zero, ..] = &found.modes[..] else { panic!() };
    let [x, y, th] = zero.vector[..] else { panic!() };
    assert!((2.0 * x - y).abs() < 1e-15 && (3.0 * th - y).abs() < 1e-15 && y > 0.0, "{:?}", zero.vector);
    assert!((x * x + y * y + th * th - 1.0).abs() < 1e-15);
    let squares: Vec<f64> = found.modes[1..].iter().map(|mode| mode.omega.mid_f64().powi(2)).collect();
    assert!((squares[0] - 2.0).abs() < 1e-14 && (squares[1] - 3.0).abs() < 1e-14, "{squares:?}");
}

/// x, y, … of so many coordinates with drawn numbers in halves.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        // D. Knuth, The Art of Computer Programming, volume 2, section 3.3.4.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % 9) as f64 / 2.0 - 2.0
    }
}

/// Conditions A q' + B q = 0 with constant A and B: what is printed are exponents of the whole pencil with
/// multipliers, with its vectors.
#[test]
fn conditions_that_depend_on_places_have_the_exponents_of_the_whole_pencil() {
    let names = ["w", "x", "y", "z"];
    let (n, c) = (4, 2);
    let (mut answered, mut first_order) = (0, 0);
    for seed in 1..=80 {
        let mut draw = Draw(seed);
        let masses: Vec<f64> = (0..n).map(|_| draw.next().abs() + 0.5).collect();
        let springs: Vec<f64> = (0..n).map(|_| draw.next()).collect();
        let coupling = draw.next();
        // Each third drawing acts through one place alone.
        let sparse = seed % 3 == 0;
        let mut rows = Vec::new();
        for _ in 0..c {
            let slopes: Vec<f64> = (0..n).map(|_| draw.next()).collect();
            let places: Vec<f64> = (0..n).map(|i| if sparse && i != 1 { 0.0 } else { draw.next() }).collect();
            rows.push((slopes, places));
        }
        let sum = |of: &dyn Fn(usize) -> String| (0..n).map(of).collect::<Vec<_>>().join(" + ");
        let mut text = format!("coord {}\n", names.join(", "));
        text += &format!("T = {}\n", sum(&|i| format!("({})*{}'^2/2", masses[i], names[i])));
        text += &format!("V = {} + ({coupling})*w*z\n", sum(&|i| format!("({})*{}^2/2", springs[i], names[i])));
        for (slopes, places) in &rows {
            let term = |i: usize| format!("({})*{name}' + ({})*{name}", slopes[i], places[i], name = names[i]);
            text += &format!("constraint {} = 0\n", sum(&term));
        }
        let Ok(own) = linearize(model(&text)) else { continue };
        let found = modes(&own);
        answered += 1;
        first_order += usize::from(own.dimension() > n - c);
        for mode in &found.modes {
            let s = c64::new(mode.growth.mid_f64(), mode.omega.mid_f64());
            if s.norm() == 0.0 {
                continue;
            }
            let part = |i: usize| mode.imaginary.get(i).copied().unwrap_or(0.0);
            let x: Vec<c64> = (0..n).map(|i| c64::new(mode.vector[i], part(i))).collect();
            let inertia: f64 = (0..n).map(|i| masses[i] * x[i].norm_sqr()).sum();
            assert!((inertia - 1.0).abs() < 1e-9, "{text}: {inertia}");
            // (s A + B) x = 0, and (s² M + K) x is Aᵀ times multipliers: orthogonal to what A allows.
            for (slopes, places) in &rows {
                let off: c64 = (0..n).map(|i| (s * slopes[i] + places[i]) * x[i]).sum();
                assert!(off.norm() < 1e-8 * (1.0 + s.norm()), "{text}: {s} {off}");
            }
            let mut force: Vec<c64> = (0..n).map(|i| (s * s * masses[i] + springs[i]) * x[i]).collect();
            force[0] += x[3] * coupling;
            force[3] += x[0] * coupling;
            let dot = |a: usize, b: usize| (0..n).map(|i| rows[a].0[i] * rows[b].0[i]).sum::<f64>();
            let determinant = dot(0, 0) * dot(1, 1) - dot(0, 1) * dot(0, 1);
            let image = |a: usize| (0..n).map(|i| force[i] * rows[a].0[i]).sum::<c64>();
            let multiplier = [
                (image(0) * dot(1, 1) - image(1) * dot(0, 1)) / determinant,
                (image(1) * dot(0, 0) - image(0) * dot(0, 1)) / determinant,
            ];
            for (i, own) in force.iter().enumerate() {
                let held: c64 = (0..c).map(|a| multiplier[a] * rows[a].0[i]).sum();
                assert!((own - held).norm() < 1e-7 * (1.0 + s.norm_sqr()), "{text}: {s} {:?}", own - held);
            }
        }
    }
    assert!(answered > 60 && first_order > 40, "{answered} {first_order}");
}

/// A ball on a turntable, a towed caster, a car and its trailer: closed forms, and shapes that move the coordinates that follow.
#[test]
fn first_order_conditions_have_their_closed_forms() {
    for turning in ["3", "-5/2"] {
        let found = found("turntable", &[("rad/s = 3", &format!("rad/s = {turning}"))]);
        let swings: Vec<&NormalMode> = found.modes.iter().filter(|own| own.kind == Kind::Oscillation).collect();
        let rate = if turning == "3" { 3.0 } else { -2.5 };
        assert_eq!((swings.len(), found.modes.len(), found.stability), (1, 5, Stability::Neutral));
        let omega = swings[0].omega.mid_f64();
        assert!((omega - (2.0_f64 / 7.0 * rate).abs()).abs() < 1e-15, "{omega}");
        // r*b' = x' + W*y.
        let part = |i: usize| c64::new(swings[0].vector[i], swings[0].imaginary[i]);
        let off = c64::new(0.0, 0.1 * omega) * part(3) - c64::new(0.0, omega) * part(0) - rate * part(1);
        assert!(off.norm() < 1e-12, "{off}");
    }
    let (m, inertia, a, c, k, v) = (2.0, 0.3, 0.25, 0.4, 50.0, 3.0);
    let caster = found("caster", &[]);
    assert_eq!(caster.stability, Stability::Unstable);
    for mode in caster.modes.iter().filter(|own| own.kind != Kind::Zero) {
        let s = c64::new(mode.growth.mid_f64(), mode.omega.mid_f64());
        let own = ((s * (inertia + m * (c - a) * (c - a)) + m * v * (c - a)) * s + k * c * c) * s + k * c * v;
        assert!(own.norm() < 1e-11, "{s}: {own}");
    }
    let stable = found("caster", &[("kg*m^2 = 0.3", "kg*m^2 = 0.07")]);
    assert_eq!(stable.stability, Stability::Neutral);
    // Pushed, it turns round.
    let trailer = "param v = -2  param L = 1  coord x, psi  T = 500*x'^2
        constraint L*psi' = -x'*sin(psi)  equilibrium x' = v";
    let own = of_text(trailer);
    assert_eq!((own.stability, own.modes[0].growth.mid_f64()), (Stability::Unstable, 2.0));
    // What moves by itself is not left out.
    let own = of_text("param a = 0.3  coord th, x  T = th'^2 + x'^2  V = 2*x^2  constraint th' = a*sin(th)");
    assert_eq!((own.stability, own.modes.len()), (Stability::Unstable, 2));
}

/// What follows a coordinate of frequency 0 moves as t² where that drifts.
#[test]
fn what_follows_a_drifting_coordinate_moves_away() {
    let blade = "coord x, y, th  T = 1/2*(x'^2 + y'^2 + th'^2)  constraint y'*cos(th) = x'*sin(th)";
    for (text, secular) in [
        // th'' = 0 and y' = 2*th.
        (format!("{blade}  equilibrium x' = 2"), true),
        // At rest y stays where it is.
        (blade.to_owned(), false),
        (format!("{blade}  equilibrium x' = 2  V = 1/2*th^2"), false),
        // th' = -c*th' ends: y' = 2*th stays.
        (format!("{blade}  equilibrium x' = 2  dissipation = 1/2*th'^2"), false),
    ] {
        assert_eq!(of_text(&text).secular, Some(secular), "{text}");
    }
    assert_eq!(found("disc", &[]).secular, Some(true));
    assert_eq!(found("turntable", &[]).secular, Some(false));
}

/// Conditions that no velocities obey are told as such, whether of constraints or of each other.
#[test]
fn conditions_contradict_each_other() {
    for text in [
        "coord x, y  T = 1/2*(x'^2 + y'^2)  V = x^2  constraint x = y  constraint x' = y' + 1",
        "coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)  V = x^2  constraint x' = y*z' + 1  constraint x' = y*z' + 2",
    ] {
        assert_eq!(Diagnostic::from(&linearize(common::model(text)).unwrap_err()).code, Some("E0313"), "{text}");
    }
    // Rates may obey it.
    let broken =
        linearize(common::model("coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)  V = z^2  constraint x' = cos(y)*z' + 1"));
    assert_eq!(Diagnostic::from(&broken.unwrap_err()).code, Some("E0322"));
}

/// A weight is a constant force: what falls steadily is at rest but for its place.
#[test]
fn a_ball_falls_at_its_terminal_velocity() {
    let ball = "param m = 0.5, c = 2, g = 9.81  coord z  T = 1/2*m*z'^2  V = m*g*z  force z = -c*z'";
    let found = of_text(&format!("{ball}  equilibrium z' = -m*g/c"));
    let growths: Vec<f64> = found.modes.iter().map(|mode| mode.growth.mid_f64()).collect();
    assert_eq!(growths, [0.0, -4.0]);
    // At another speed it is not held.
    let faster = linearize(common::model(&format!("{ball}  equilibrium z' = -2*m*g/c"))).unwrap_err();
    assert_eq!(Diagnostic::from(&faster).code, Some("E0317"));
}

/// With x' = 2: p'' = -p, y' = 2 p, s' = 2 p - 2 s.
#[test]
fn a_trailer_follows_at_a_constant_speed() {
    let found = of_text(
        "coord x, y, p, s  T = 1/2*(x'^2 + y'^2 + p'^2 + s'^2)  V = 1/2*p^2
        constraint y'*cos(p) = x'*sin(p)  constraint y' = s' + x'*s  equilibrium x' = 2",
    );
    let told: Vec<(Kind, f64, f64)> =
        found.modes.iter().map(|own| (own.kind, own.omega.mid_f64(), own.growth.mid_f64())).collect();
    assert!(told.contains(&(Kind::Oscillation, 1.0, 0.0)), "{told:?}");
    let falling = told.iter().find(|own| own.0 == Kind::Overdamped).unwrap();
    assert!((falling.2 + 2.0).abs() < 1e-15, "{told:?}");
    assert!(told.iter().all(|own| own.0 == Kind::Zero || own.1 == 1.0 || own == falling), "{told:?}");
}
