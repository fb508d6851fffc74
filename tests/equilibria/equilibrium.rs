//! Which equilibrium is found.
#![cfg(feature = "engine")]

use librate::linearize::{LinearizeError, Linearized, linearize};
use librate::model::{Settings, TableTexts, elaborate};
use librate::oscillation::normal_modes;
use librate::syntax::parse;

fn at(text: &str) -> Result<Linearized, LinearizeError> {
    let file = parse(text).unwrap();
    let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
    linearize(model)
}

fn found(text: &str) -> Vec<f64> {
    let linearized = at(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let values = &linearized.equilibrium().values;
    values.iter().map(|value| value.mid_f64()).collect()
}

#[test]
fn the_equilibrium_near_the_guess_is_found() {
    // A pendulum is at rest at every multiple of pi; which one is near changes at pi/2.
    for guess in ["0.1", "0.7", "1.2", "1.4", "1.5", "-1.5"] {
        let text = format!("coord x  T = 1/2*x'^2  V = -cos(x)  guess x = {guess}");
        let x = found(&text)[0];
        assert!(x.abs() < 1e-30, "{guess}: {x}");
    }
    for guess in ["1.65", "1.8", "2.5", "3", "4", "4.6"] {
        let text = format!("coord x  T = 1/2*x'^2  V = -cos(x)  guess x = {guess}");
        let x = found(&text)[0];
        assert!((x - std::f64::consts::PI).abs() < 1e-15, "{guess}: {x}");
    }
    // The first step of Newton's method lands beyond the pole, on the other equilibrium, or far beyond it.
    for guess in ["1.99", "2", "2.01", "100", "1e5"] {
        assert!((found(&format!("coord x  T = 1/2*x'^2  V = 1/x + x  guess x = {guess}"))[0] - 1.0).abs() < 1e-15);
    }
    // There it looks the same: a way across the pole is taken for none.
    for guess in ["1.109", "1.10999", "1.11"] {
        assert!((found(&format!("coord x  T = x'^2  V = 1/x^12 - 2/x^6  guess x = {guess}"))[0] - 1.0).abs() < 1e-15);
    }
    // Two wells and the hill between them.
    let well = |guess: &str| found(&format!("coord x  T = x'^2  V = (x^2 - 1)^2  guess x = {guess}"))[0];
    assert_eq!(well("0.7"), 1.0);
    assert_eq!(well("5"), 1.0);
    assert_eq!(well("-0.6"), -1.0);
    assert_eq!(well("0.3"), 0.0);
    // From where one step leads exactly to the other well.
    assert_eq!(found("coord x  T = x'^2  V = x^4/4 - x^2/2  guess x = 1/2")[0], 0.0);
}

#[test]
fn wells_far_apart_in_scale_are_found() {
    let deep = "coord x  T = x'^2  V = -1e6*exp(-1e8*(x - 1e-3)^2) - exp(-x^2)  guess x = 0.0010001";
    assert!((found(deep)[0] - 1e-3).abs() < 1e-9);
    let shallow = "coord x  T = x'^2  V = -1e6*exp(-1e8*(x - 5)^2) - exp(-x^2)  guess x = 0.3";
    assert!(found(shallow)[0].abs() < 1e-30);
}

#[test]
fn a_start_without_stiffness_is_left() {
    // At 0 the second derivative vanishes, but not the force.
    let x = found("coord x  T = x'^2  V = x^4/4 - x")[0];
    assert!((x - 1.0).abs() < 1e-15, "{x}");
}

/// The stiffness jumps where a contact begins: at 0, where the search starts, and below a guess.
#[test]
fn a_ball_comes_to_rest_on_a_contact() {
    let ball = "param m = 0.5, g = 9.81, k = 2000  coord z  T = 1/2*m*z'^2  V = m*g*z + 1/2*k*((abs(z) - z)/2)^2";
    for guess in ["", "guess z = 1", "guess z = 1e-3", "guess z = -2"] {
        let z = found(&format!("{ball}  {guess}"))[0];
        assert!((z + 0.5 * 9.81 / 2000.0).abs() < 1e-17, "{guess}: {z}");
    }
}

/// Forces without a potential vanish at a point near the guess. The last is a zero of two polynomials (mpmath).
#[test]
fn forces_vanish_near_the_guess() {
    let near = |text: &str, wanted: &[f64]| {
        let found = found(text);
        let off = found.iter().zip(wanted).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(found.len() == wanted.len() && off < 1e-14, "{text}: {found:?}");
    };
    near("coord x  T = 1/2*x'^2  force x = 3 - x^3  guess x = 1.44", &[3.0_f64.cbrt()]);
    near("coord x  T = 1/2*x'^2  force x = 1e-9*(3 - x^3)  guess x = 1.44", &[3.0_f64.cbrt()]);
    near(
        "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*(x^2 + y^2) + (x - 1)^2 + 3/2*(x*y - 1)^2  force x = -0.2*y
            guess x = 0.86  guess y = 0.8",
        &[0.861_515_106_068_522, 0.801_005_834_644_672_4],
    );
    // Only from where the energy is least Newton's method gets there.
    near(
        "coord q1, q2, q3  T = q1'^2 + q2'^2 + q3'^2  force q1 = 3*q1/5
         V = 3*q1^2/2 + 3*q2^2/2 + 2*q3^2 + (-q1/2 + 3*q2 - q3^2)^2 + (4*q1^2 + 2*q1 + 2*q2 - q3/2 - 3)^2/10
             + cos(q1/2 - 3*q2 + q3^2)",
        &[0.472_805_290_346_756_8, 0.091_418_936_037_873_81, -0.024_584_990_189_903_85],
    );
    // From a start without stiffness there is no way.
    let error = at("coord x  T = 1/2*x'^2  force x = 3 - x^3").unwrap_err();
    assert!(matches!(error, LinearizeError::EquilibriumNotFound { .. }), "{error:?}");
    // Forces that are lost in rounding say nothing.
    let error = at("param k = 4  coord x  T = 1/2*x'^2  V = 1/2*k*integral(s in 0..1, (1 + s*x)^200)  guess x = -2");
    assert!(matches!(error.unwrap_err(), LinearizeError::EquilibriumNotFound { .. }));
    // Nowhere at rest: what is told is the place of each coordinate, once.
    let error = at("coord x, y  T = 1/2*(x'^2 + y'^2)  V = y^2  force x = 2 + sin(x)*cos(y)").unwrap_err();
    let told = librate::diagnostic::Diagnostic::from(&error);
    let help = told.help.unwrap_or_default();
    assert!(help.matches("x = ").count() <= 1 && help.matches("y = ").count() <= 1, "{help}");
}

#[test]
fn neutral_directions_are_no_obstacle() {
    let text = "
        coord x[1..3]
        T = sum(i in 1..3, x[i]'^2)
        V = (x[2] - x[1] - 2)^2 + (x[3] - x[2] - 3)^4 + (x[3] - x[2] - 3)^2
        guess x[2] = 1
    ";
    let x = found(text);
    assert!((x[1] - x[0] - 2.0).abs() < 1e-15);
    assert!((x[2] - x[1] - 3.0).abs() < 1e-15);
}

#[test]
fn without_an_equilibrium_the_force_is_named() {
    let text = "param F = 3  coord x, y  T = x'^2 + y'^2  V = -F*x + y^2";
    let error = at(text).unwrap_err();
    assert_eq!(error.to_string(), "there is no equilibrium: the force on `x` is F = 3 everywhere");
    // Two bodies that hold each other but fall together.
    let text = "coord a, b  T = a'^2 + b'^2  V = (a - b)^2 - sin(1)*a - b";
    let error = at(text).unwrap_err();
    assert!(matches!(error, LinearizeError::NoEquilibrium { .. }), "{error}");
    // A force that falls off, but never vanishes.
    let error = at("coord x  T = x'^2  V = exp(-x)").unwrap_err();
    assert!(matches!(error, LinearizeError::EquilibriumNotFound { .. }), "{error}");
}

#[test]
fn a_claimed_equilibrium_is_verified() {
    let error = at("coord x  T = x'^2  V = (x - 1)^2  equilibrium x = 1.0000000001").unwrap_err();
    assert!(matches!(error, LinearizeError::NotAnEquilibrium { .. }), "{error}");
    // The other coordinate is searched for, then the given one is verified.
    let error = at("coord x, y  T = x'^2 + y'^2  V = (x - y)^2 + (y - 1)^2 + 2*x  equilibrium x = 0").unwrap_err();
    assert!(matches!(error, LinearizeError::NotAnEquilibrium { .. }), "{error}");
    let fine = found("coord x, y  T = x'^2 + y'^2  V = (x - y)^2 + (y - 1)^2  equilibrium x = 1");
    assert_eq!(fine, [1.0, 1.0]);
}

#[test]
fn where_newton_has_no_way_on_a_minimum_is_found() {
    for k in ["1e6", "1e8", "1e10", "1e12"] {
        let text = format!(
            "param k = {k}  coord x, y  T = 1/2*(x'^2 + y'^2)
            V = 1/2*k*(norm([x, y]) - 1)^2 + 9.81*y - 3*x  guess x = 0.1  guess y = -1"
        );
        let weight = 3.0_f64.hypot(9.81);
        let length = 1.0 + weight / k.parse::<f64>().unwrap();
        let point = found(&text);
        assert!((point[0] - 3.0 / weight * length).abs() < 1e-14, "{k}");
        assert!((point[1] + 9.81 / weight * length).abs() < 1e-14, "{k}");
    }
}

#[test]
fn a_force_that_differs_from_place_to_place_is_not_called_the_same() {
    // Hardly any stiffness where the search starts: yet the springs hold.
    let text = "coord x, y  T = 1/2*(x'^2 + y'^2)
        V = 1/2*1e-8*x^2 + 15*x^4 + 1e6*(y - x)^2 - 60*x - 60*y";
    let point = found(text);
    let x: f64 = point[0];
    assert!((60.0 * x.powi(3) + 1e-8 * x - 120.0).abs() < 1e-9, "{x}");
}

#[test]
fn a_force_within_its_bound_is_not_called_none() {
    let energies = "param c = ln(6) - ln(2) - ln(3)  coord x  T = 1/2*x'^2
        V = 1e25*c*x + 1/2*x^2 - 1e-8*x";
    let linearized = at(energies).unwrap();
    let x = linearized.equilibrium().values[0];
    assert!(x.lower() <= 1e-8 && x.upper() >= 1e-8);
    let error = at(&format!("{energies}  equilibrium x = 0")).unwrap_err();
    assert!(matches!(error, LinearizeError::NotAnEquilibrium { .. }), "{error}");
}

/// Coordinates, V or `lagrangian`, and what is to blame; T is that of unit masses where none is given.
const UNDEFINED: &[(&str, &str)] = &[
    ("coord x, y  V = -1/sqrt(x^2 + y^2)", "sqrt(x^2 + y^2)"),
    ("param k  coord x, y  V = -k/norm([x, y])", "sqrt(x^2 + y^2)"),
    ("param k  coord x, y  V = k*(norm([x, y]) - 1)^2", "sqrt(x^2 + y^2)"),
    ("param k  coord x, y  V = -k/(x^4 + y^4)", "x^4 + y^4"),
    ("coord x, y  V = ln(x^2 + y^2)", "ln(x^2 + y^2)"),
    ("coord x, y  V = (x^2 + y^2)^(3/4)", "(x^2 + y^2)^(1/4)"),
    ("coord x  V = abs(x) + x^2", "abs(x)"),
    ("coord x  V = sqrt(x) + x^2", "sqrt(x)"),
    ("coord x  V = sin(x)/x", "x"),
    ("coord x  V = x^2 + asin(x + 2)", "asin(2 + x)"),
    ("coord x  V = x^2*ln(x^2)", "ln(x^2)"),
    ("coord x, y  V = x^2 + y^2 + atan2(y, x)^2", "atan2"),
    // The derivative of a logarithm is defined where the logarithm is not.
    ("coord x  V = x^2/2 + ln(x - 3)", "ln(x - 3)"),
    ("coord x  V = x + ln(x - 1)  equilibrium x = 0", "ln(x - 1)"),
    ("param k  param a  coord x  V = -k/(x - a)^2  equilibrium x = a", "(x - a)^2"),
    ("coord x  T = x'^2/x  V = x^2", "x"),
    ("param c  coord x  V = x^2  dissipation = c*x'^2/x", "x"),
    ("coord x, y  lagrangian = x'^2 + y'^2 + (x*y' - y*x')/(x^2 + y^2) - x^2 - y^2", "x^2 + y^2"),
    ("coord x, y  V = x^2 + y^2  constraint y = abs(x)", "abs(x)"),
    ("coord x, y  V = y  constraint norm([x, y]) = 0", "sqrt(x^2 + y^2)"),
];

/// Where an energy or a force has no value, there is no equilibrium: neither in numbers nor in symbols, whether parameters
/// have values or not.
#[test]
fn where_a_force_is_undefined_there_is_no_equilibrium() {
    for (text, blamed) in UNDEFINED {
        let mut text = (*text).to_owned();
        if !text.contains("T =") && !text.contains("lagrangian") {
            text += if text.contains(", y") { "  T = x'^2 + y'^2" } else { "  T = x'^2" };
        }
        let valued = ["k", "a", "c"]
            .iter()
            .fold(text.clone(), |text, name| text.replace(&format!("param {name} "), &format!("param {name} = 2 ")));
        let derived = |text: &str| {
            let file = parse(text).unwrap();
            let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
            librate_core::linearize::derive(model).map(|_| ())
        };
        let numeric = at(&valued)
            .and_then(|linearized| normal_modes(&linearized, &librate::modes::Options::default()).map(|_| ()));
        for result in [derived(&text), derived(&valued), numeric] {
            let Err(LinearizeError::NotFinite { cause: Some(cause), .. }) = result else {
                panic!("{text}: {result:?}");
            };
            assert!(cause.contains(&format!("`{blamed}")), "{text}: {cause}");
        }
    }
}

/// |x|^3 is smooth enough, and so is what is 0/0 only in the way it is written.
#[test]
fn what_is_smooth_enough_has_an_equilibrium() {
    for text in [
        "coord x  T = x'^2/2  V = x^2 + abs(x)^3",
        "coord x  T = x'^2/2  V = x^2 + (x^2)^(5/4)",
        "coord x  T = x'^2/2  V = x^2 - ln(cosh(x)) + x^2/2",
        "coord x  T = x'^2/2  V = x^2 + x^2*abs(x)",
        "coord x  T = x'^2/2  V = x^2 + x*abs(x)^2*x^2/abs(x)",
        "coord x  T = x'^2/2  V = x^2 + abs(x)^5/x",
        "coord x  T = x'^2/2  V = x^2 + abs(sin(2*x))^3 + x^3*abs(x)",
        "coord x  T = x'^2/2 + x^2*abs(x)*x'^2  V = x^2",
        "coord x  T = x'^2/2  V = x^2  dissipation = abs(x')^3/3",
        "coord x  T = x'^2/2  V = x^2  dissipation = abs(x')*x'^2 + (x'^2)^(5/4) + abs(x)*abs(x')^3",
    ] {
        let linearized = at(text).unwrap();
        assert!(linearized.equilibrium().values[0].is_zero(), "{text}");
        let stiffness = linearized.stiffness()[0];
        assert_eq!(stiffness.mid_f64(), 2.0, "{text}");
    }
}

const SPHERE: &str = "coord r, th, ph
    T = 1/2*(r'^2 + r^2*th'^2 + r^2*sin(th)^2*ph'^2)
    equilibrium th = pi/2";

/// Beside another coordinate the corner is a line; and a force or a friction that has a corner is none to second order.
#[test]
fn corners_are_as_sharp_as_their_power() {
    let wells = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*x^2 + 2*y^2";
    for more in ["abs(y - x)^3", "(x - y)^2*abs(y - x)", "abs(x*y)^3"] {
        let linearized = at(&format!("{wells} + {more}")).unwrap();
        let modes = normal_modes(&linearized, &librate::modes::Options::default()).unwrap();
        let omegas: Vec<f64> = modes.modes.iter().map(|mode| mode.omega.mid_f64()).collect();
        assert_eq!(omegas, [1.0, 2.0], "{more}");
    }
    for (text, what) in [
        ("V = x^2 + x*abs(x)", "a second derivative of the energies"),
        ("V = x^2 + abs(x)^3/x", "a second derivative of the energies"),
        ("V = x^2 + x^2/abs(x)", "the force"),
    ] {
        let found = at(&format!("coord x  T = 1/2*x'^2  {text}"))
            .and_then(|linearized| normal_modes(&linearized, &librate::modes::Options::default()));
        match found {
            Err(LinearizeError::NotFinite { what: found, .. }) => assert_eq!(found, what, "{text}"),
            other => panic!("{text}: {other:?}"),
        }
    }
    for friction in ["abs(x')", "x'*abs(x')", "abs(x')^(3/2)", "abs(x')*abs(x)"] {
        let text = format!("coord x  T = 1/2*x'^2  V = x^2  dissipation = {friction}");
        let found = at(&text);
        assert!(matches!(found, Err(LinearizeError::FrictionNotSmooth { .. })), "{text}");
    }
}

/// Where sin(pi/2) and the like make the matrices rational they are exact, and repeated exponents are decided.
#[test]
fn matrices_are_exact_beside_angles_of_pi() {
    for (text, omegas) in [
        // Kepler's circle: r and ph at omega 1, th at omega 1, by nothing but the force law.
        (format!("{SPHERE}  V = -1/r  equilibrium r = 1  equilibrium ph' = 1"), [0.0, 1.0, 1.0]),
        (format!("{SPHERE}  V = -1/r  guess r = 0.9  equilibrium ph' = 1"), [0.0, 1.0, 1.0]),
        (format!("{SPHERE}  V = -8/r  guess r = 2.3  equilibrium ph' = 1"), [0.0, 1.0, 1.0]),
        // An oscillator that is the same in all directions, on a circle: r at twice its frequency.
        (format!("{SPHERE}  V = 9/2*r^2  equilibrium r = 2  equilibrium ph' = 3"), [0.0, 3.0, 6.0]),
    ] {
        let linearized = at(&text).unwrap();
        assert!(linearized.integers().is_some(), "{text}");
        let modes = normal_modes(&linearized, &librate::modes::Options::default()).unwrap();
        for (mode, omega) in modes.modes.iter().zip(omegas) {
            assert!((mode.omega.mid_f64() - omega).abs() < 1e-12, "{text}: {:?}", mode.omega);
            assert!(mode.growth.is_zero(), "{text}: {:?}", mode.growth);
        }
        assert_eq!(modes.modes.len(), 3, "{text}");
    }
    // A bowl z = r^2 at its rate, in cylindrical and in spherical coordinates: taken where it is guessed, exactly. All radii
    // turn with this rate, so that r is free beside ph.
    for bowl in [
        "coord r, ph, z  T = 1/2*(r'^2 + r^2*ph'^2 + z'^2)  V = g*z
         constraint z = r^2  guess r = 1  guess z = 1",
        "coord r, th, ph  T = 1/2*(r'^2 + r^2*th'^2 + r^2*sin(th)^2*ph'^2)  V = g*r*cos(th)
         constraint r*cos(th) = r^2*sin(th)^2  guess r = sqrt(2)  guess th = pi/4",
    ] {
        let text = format!("param g = 10  {bowl}  equilibrium ph' = sqrt(2*g)");
        let linearized = at(&text).unwrap();
        let equilibrium = linearized.equilibrium();
        assert!(equilibrium.proved && equilibrium.steps == 0, "{text}");
        let modes = normal_modes(&linearized, &librate::modes::Options::default()).unwrap();
        assert_eq!(modes.modes[0].kind, librate::modes::Kind::Zero);
        assert!((modes.modes[1].omega.mid_f64() - 4.0).abs() < 1e-14);
        assert_eq!(modes.zero_motions, ["ph is free", "no restoring force to second order"]);
    }
    // A bowl z = r^4/4 turns at ph' = 3 where r is 1.
    let bowl = "coord r, ph, z  T = 1/2*(r'^2 + r^2*ph'^2 + z'^2)  V = 9*z
        constraint z = r^4/4  equilibrium r = 1  equilibrium z = 1/4  equilibrium ph' = 3";
    let linearized = at(bowl).unwrap();
    let modes = normal_modes(&linearized, &librate::modes::Options::default()).unwrap();
    assert!((modes.modes[1].omega_squared.unwrap().mid_f64() - 27.0).abs() < 1e-12);
}

/// Of many springs none is asked for its force where symbols show that there is none; a place that is off by less than bounds of
/// doubles tell is still found out.
#[test]
fn many_springs_are_unstressed_by_their_lengths() {
    let mut table = "x,y,off\n".to_owned();
    for i in 0..60 {
        table += &format!(
            "{}.{},{}.{},{}\n",
            i * 7 % 11,
            i * i % 97,
            i * 5 % 13,
            i * 3 % 89,
            if i == 9 { "1e-40" } else { "0" }
        );
    }
    let tables = TableTexts::new().with("p.csv".to_owned(), table);
    let at = |place: &str, length: &str| {
        let text = format!(
            "table p = \"p.csv\"  coord r[1..rows(p), 1..2]  let s[a in p] = [a.x, a.y]
            T = sum(a in p, 1/2*dot(r[a]', r[a]'))
            V = sum(a in p, b in p where a < b, 1/2*(norm(r[b] - r[a]) - {length})^2)
            equilibrium r[a in p] = [{place}, a.y]"
        );
        let file = parse(&text).unwrap();
        linearize(elaborate(&file, &tables, &Settings::new()).unwrap())
    };
    let whole = at("a.x", "norm(s[b] - s[a])").unwrap();
    let zero = normal_modes(&whole, &Default::default()).unwrap().modes.into_iter().filter(|mode| mode.omega.is_zero());
    assert_eq!(zero.count(), 3);
    for (place, length) in [("a.x + a.off", "norm(s[b] - s[a])"), ("a.x", "(norm(s[b] - s[a]) + a.off)")] {
        let error = at(place, length).unwrap_err();
        assert!(matches!(error, LinearizeError::NotAnEquilibrium { .. }), "{error}");
    }
}
