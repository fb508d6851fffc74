//! Every file of models/ against its reference of 40 digits, which is computed by other means
//! (tests/reference).
#![cfg(feature = "engine")]

use crate::common;

use std::path::Path;

use common::{load, model, model_files};
use librate::linearize::linearize;
use librate::modes::{Kind, Options, Stability};
use librate::number::Number;
use librate::oscillation::{NormalModes, normal_modes};
use librate::precision::{Ball, Big, Scalar};
use librate_core::precision::Magnitude;
use serde_json::Value;

fn reference(path: &Path) -> Value {
    let name = path.file_stem().unwrap().to_string_lossy().to_string();
    let text = std::fs::read_to_string(format!("tests/reference/{name}.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// A decimal string of any length as an enclosure.
fn ball(value: &Value) -> Ball {
    let text = value.as_str().unwrap();
    let (negative, digits) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let number = Number::parse(digits).unwrap();
    Ball::from_number(&if negative { number.neg() } else { number }, ())
}

/// The reference is right to 40 digits, the bound must hold for it.
fn assert_holds(what: &str, own: &Ball, want: &Ball, name: &str) -> f64 {
    let off = own.sub(want);
    let distance = off.mid_f64().abs();
    let slack = want.mid_f64().abs() * 1e-31;
    assert!(distance <= own.radius + slack, "{name}: {what} is off by {distance:e}, its bound is {:e}", own.radius);
    let size = want.mid_f64().abs();
    if size == 0.0 { 0.0 } else { distance / size }
}

fn check(name: &str, normal: &NormalModes, equilibrium: &[Ball], want: &Value) {
    for (own, want) in equilibrium.iter().zip(want["equilibrium"].as_array().unwrap()) {
        assert_holds("the equilibrium", own, &ball(want), name);
    }
    let stability = normal.stability.as_str();
    assert_eq!(stability, want["stability"].as_str().unwrap(), "{name}");
    let modes = want["modes"].as_array().unwrap();
    assert_eq!(normal.modes.len(), modes.len(), "{name}");
    for (i, (own, want)) in normal.modes.iter().zip(modes).enumerate() {
        let kind = own.kind.as_str();
        assert_eq!(kind, want["kind"].as_str().unwrap(), "{name} mode {i}");
        for (what, own, want) in [("omega", &own.omega, &want["omega"]), ("growth", &own.growth, &want["growth"])] {
            let relative = assert_holds(what, own, &ball(want), name);
            assert!(relative <= 1e-13, "{name}: {what} of mode {i} is off by {relative:e}");
        }
    }
    if let Some(classes) = want.get("symmetry") {
        let own: Vec<Value> = normal.modes.iter().map(|mode| mode.symmetry.clone().into()).collect();
        assert_eq!(&Value::Array(own), classes, "{name}");
    }
}

#[test]
fn models_agree_with_references() {
    for path in model_files() {
        let want = reference(&path);
        let name = path.file_stem().unwrap().to_string_lossy().to_string();
        let linearized = linearize(load(&path));
        if let Some(error) = want.get("error") {
            let found = linearized.err().unwrap_or_else(|| panic!("{name} has no error"));
            assert!(found.to_string().contains(error.as_str().unwrap()), "{name}: {found}");
            continue;
        }
        let linearized = linearized.unwrap_or_else(|error| panic!("{name}: {error}"));
        let normal = normal_modes(&linearized, &Options::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        check(&name, &normal, &linearized.equilibrium().values, &want);
    }
}

#[test]
fn ubiquitin_agrees_with_the_published_eigenvalues() {
    let path = Path::new("models/ubiquitin.lag");
    let want = reference(path);
    let linearized = linearize(load(path)).unwrap();
    let options = Options::default().lowest(36);
    let normal = normal_modes(&linearized, &options).unwrap();
    let published = want["published_eigenvalues"].as_array().unwrap();
    assert_eq!(published.len(), 36);
    for (mode, published) in normal.modes.iter().zip(published) {
        let text = published.as_str().map_or_else(|| published.to_string(), str::to_owned);
        let published: f64 = text.parse().unwrap();
        let own = mode.omega_squared.unwrap().mid_f64();
        // Five digits are given, and the noise of single precision is in them.
        let digit = 10.0_f64.powf(own.abs().max(1e-9).log10().floor() - 4.0);
        assert!((own - published).abs() <= 0.5 * digit + 1e-6, "{own} {published}");
    }
}

#[test]
fn damped_modes_have_their_damping_ratio() {
    for (friction, ratio) in [("1/5", 0.1), ("2e-12", 1e-12), ("1.999999", 0.999_999_5)] {
        let text = format!("param c = {friction} coord x T = 1/2*x'^2 V = 1/2*x^2 dissipation = 1/2*c*x'^2");
        let linearized = linearize(model(&text)).unwrap();
        let options = Options::default();
        let modes = normal_modes(&linearized, &options).unwrap();
        let (found, precise) = modes.modes[0].damping_ratio().unwrap();
        let found = precise.map_or(found, |own| own.to_ball());
        assert!((found.mid_f64() - ratio).abs() <= 1e-15 * ratio, "{found:?}");
        let json = librate::report::modes_json(&linearized, &modes, &options);
        let number = |name: &str| {
            let (_, rest) = json.split_once(&format!("\"{name}\": ")).unwrap();
            rest[..rest.find([',', '}']).unwrap()].parse::<f64>().unwrap()
        };
        assert!((number("damping_ratio") / ratio - 1.0).abs() < 1e-9, "{json}");
        assert!((number("quality_factor") * 2.0 * ratio - 1.0).abs() < 1e-9, "{json}");
    }
    // A mirror of friction and rotation, too, has classes; one that friction does not share has none.
    let classes = |dampers: &str, rest: &str| {
        let text = format!(
            "coord x[1..3]  lagrangian = 1/2*dot(x', x') - 1/2*((x[1] - x[2])^2 + (x[2] - x[3])^2 + dot(x, x)){rest}
             dissipation = {dampers}"
        );
        let modes = normal_modes(&linearize(model(&text)).unwrap(), &Options::default()).unwrap();
        modes.modes.iter().map(|mode| mode.symmetry.clone().unwrap_or_default()).collect::<Vec<_>>()
    };
    assert_eq!(classes("0.1*x[2]'^2", ""), ["even", "odd", "even"]);
    assert_eq!(classes("0.1*x[2]'^2", " + 3/10*x[2]'*(x[1] + x[3])"), ["even", "odd", "even"]);
    assert_eq!(classes("0.1*x[1]'^2", ""), ["", "", ""]);
    // So have generalised forces, by what they do at all places.
    assert_eq!(classes("0  force x[i in 1..3] = -x[i]'*x[2]^2 - x[i]^3/2 - x[i]/3", ""), ["even", "odd", "even"]);
    assert_eq!(classes("0  force x[1] = -x[3]'  force x[3] = -x[1]'", ""), ["odd", "even", "even"]);
    assert_eq!(classes("0  force x[i in 1..3] = -i*x[i]^3", ""), ["", "", ""]);
    assert_eq!(classes("0  force x[1] = -x[1]^2", ""), ["", "", ""]);
    let text = "coord x T = 1/2*x'^2 V = 1/2*x^2";
    let linearized = linearize(model(text)).unwrap();
    let modes = normal_modes(&linearized, &Options::default()).unwrap();
    assert!(modes.modes[0].damping_ratio().is_none());
}

/// Pendulums in x and y: constraints are exchanged with the bodies that they hold.
#[test]
fn classes_under_constraints() {
    let classes = |energy: &str, hung: &str, rest: &str| {
        let text = format!(
            "param a[1..3] = [-1, 0, 1]  coord x[1..3], y[1..3]  T = 1/2*(dot(x', x') + dot(y', y'))
             V = y[1] + y[2] + y[3] + {energy}  constraint [i in 1..3] {hung}  {rest}
             guess x[i in 1..3] = a[i]  guess y[i in 1..3] = -1"
        );
        let modes = normal_modes(&linearize(model(&text)).unwrap(), &Options::default()).unwrap();
        modes.modes.iter().map(|mode| mode.symmetry.clone().unwrap_or_default()).collect::<Vec<_>>()
    };
    let springs = "1/2*((x[2] - x[1] - 1)^2 + (x[3] - x[2] - 1)^2)";
    let circles = "(x[i] - a[i])^2 + y[i]^2 = 1";
    assert_eq!(classes(springs, circles, ""), ["even", "odd", "even"]);
    assert_eq!(classes(springs, circles, "dissipation = 1/10*x[2]'^2"), ["even", "odd", "even"]);
    // Along the true distance only the mirror x -> -x is a symmetry, under which equal motions are odd.
    let lengths = "1/2*sum(i in 1..2, (sqrt((x[i+1] - x[i])^2 + (y[i+1] - y[i])^2) - 1)^2)";
    assert_eq!(classes(lengths, circles, ""), ["odd", "even", "odd"]);
    // Beyond the second order, and in the constraints alone, nothing is exchanged.
    assert_eq!(classes(&format!("{springs} + (x[1] + 1)^3"), circles, ""), ["", "", ""]);
    let bent = "(x[i] - a[i])^2 + y[i]^2 + i*(y[i] + 1)^3 = 1";
    assert_eq!(classes(springs, bent, ""), ["", "", ""]);
}

/// Where a mirror holds a coordinate at 0 it is 0 exactly, also beside others that are searched for: it is not coupled to them.
#[test]
fn coordinates_that_no_force_moves_from_zero_are_zero() {
    let text = "param b = 200  coord r, th  T = 1/2*(r'^2 + r^2*th'^2)  dissipation = 0.1*r'^2
        V = 20*(r - 1/2)^2 + 1/4*b*(r - 1/2)^4 - 9.81*r*cos(th)  guess r = 0.6  guess th = 0.1";
    let linearized = linearize(model(text)).unwrap();
    let [r, th] = linearized.equilibrium().values[..] else { panic!("two coordinates") };
    assert!(th.is_exact() && th.is_zero() && linearized.equilibrium().proved);
    let modes = normal_modes(&linearized, &Options::default()).unwrap();
    assert_eq!(modes.stability, Stability::Stable);
    let [swing, bounce] = &modes.modes[..] else { panic!("two modes") };
    // omega² = g/r.
    assert_eq!((swing.kind, bounce.kind), (Kind::Oscillation, Kind::Damped));
    let off = swing.omega.mid_f64() - (9.81 / r.mid_f64()).sqrt();
    assert!(off.abs() < 1e-15 && swing.vector[0] == 0.0, "{off}");
}

/// A molecule in a row that bends freely: its atoms are on their axis exactly, and their places on it are proved.
#[test]
fn molecules_in_a_row_are_proved_from_a_guess() {
    let text = "param m[1..3] = [16, 12, 16]  coord r[1..3, 1..3]  T = sum(a in 1..3, 1/2*m[a]*dot(r[a]', r[a]'))
        V = sum(a in 1..2, 10*(norm(r[a+1] - r[a]) - 1.16)^2)  guess r[a in 1..3] = [0, 0, a - 2]";
    let linearized = linearize(model(text)).unwrap();
    assert!(linearized.equilibrium().proved);
    let modes = normal_modes(&linearized, &Options::default()).unwrap();
    assert_eq!(modes.point_group.as_deref(), Some("D∞h"));
    let classes: Vec<_> = modes.modes[7..].iter().map(|mode| mode.symmetry.as_deref()).collect();
    assert_eq!(classes, [Some("Σg+"), Some("Σu+")]);
}

/// Forces that no energy gives have as many digits as others, also where there are no velocities.
#[test]
fn circulatory_forces_have_all_digits() {
    // omega² = 2 and 3: K + N = [[2, 1], [0, 3]].
    let text = "coord x, y  T = 1/2*(x'^2 + y'^2)  force x = -2*x - y  force y = -3*y";
    let linearized = linearize(model(text)).unwrap();
    let modes = normal_modes(&linearized, &Options::default().digits(50)).unwrap().modes;
    for (mode, square) in modes.iter().zip([2, 3]) {
        let omega = &mode.precise.as_ref().unwrap().omega;
        let off = &(omega * omega) - &Big::from_number(&Number::from(square), omega.bits());
        assert!(off.contains_zero() && off.abs_upper() < Magnitude::from_f64(1e-49), "{off:?}");
    }
}
