//! Coordinates without inertia, beside closed forms.
#![cfg(feature = "engine")]

use crate::common::model;

use librate::linearize::{LinearizeError, Linearized, linearize};
use librate::modes::{Kind, Options, Stability};
use librate::number::Number;
use librate::oscillation::{NormalModes, normal_modes};
use librate::precision::{Ball, Scalar};

fn solved(text: &str) -> (Linearized, NormalModes) {
    let linearized = linearize(model(text)).unwrap_or_else(|error| panic!("{text}: {error}"));
    let normal = normal_modes(&linearized, &Options::default()).unwrap_or_else(|error| panic!("{text}: {error}"));
    (linearized, normal)
}

fn number(text: &str) -> Ball {
    let (over, under) = text.split_once('/').unwrap_or((text, "1"));
    let part = |text: &str| Ball::from_number(&Number::parse(text).unwrap(), ());
    part(over) / part(under)
}

/// omega² of all modes, as fractions.
#[track_caller]
fn check(text: &str, massless: usize, squares: &[&str]) -> NormalModes {
    let (linearized, normal) = solved(text);
    assert_eq!(linearized.massless_directions(), massless, "{text}");
    assert_eq!(normal.modes.len(), squares.len(), "{text}");
    for (mode, square) in normal.modes.iter().zip(squares) {
        let own = mode.omega_squared.unwrap();
        assert!((own - number(square)).contains_zero(), "{text}: {own:?}, not {square}");
        assert!(own.radius <= 1e-14 * own.mid_f64().abs(), "{text}: {own:?}");
        assert_eq!(mode.vector.len(), linearized.coordinates(), "{text}");
    }
    normal
}

fn refused(text: &str) -> LinearizeError {
    normal_modes(&linearize(model(text)).unwrap(), &Options::default()).unwrap_err()
}

#[test]
fn nodes_follow_what_holds_them() {
    let series = "param k1 = 2  param k2 = 3  coord x, y, z  V = 1/2*k1*(x - y)^2 + 1/2*k2*(y - z)^2\n";
    // k = 1/(1/2 + 1/3) between two masses that are free: a zero mode beside it.
    let normal = check(&format!("{series} T = 1/2*x'^2 + 1/2*z'^2"), 1, &["0", "12/5"]);
    assert_eq!(normal.zero_motions, ["translation"]);
    // The same between x = 2 z and z.
    check(&format!("{series} T = 1/2*x'^2 + 1/2*z'^2  constraint x = 2*z"), 1, &["6/25"]);
    // A mass of 0 is none.
    check(&format!("{series} param m = 0  T = 1/2*x'^2 + 1/2*z'^2 + 1/2*m*y'^2"), 1, &["0", "12/5"]);
}

#[test]
fn directions_follow_that_are_no_coordinates() {
    check("coord x, y, z  T = 1/2*(x' + y')^2  V = 1/2*(x^2 + 2*y^2 + z^2)", 2, &["2/3"]);
    check("coord x, y  T = 1/2*(sqrt(2)*x' + y')^2  V = x^2 + y^2", 1, &["2/3"]);
}

#[test]
fn symmetries_are_those_of_all_coordinates() {
    let frame = "coord x[1..2], a[1..2]  T = sum(i in 1..2, 1/2*x[i]'^2)
        V = sum(i in 1..2, (x[i] - a[i])^2 + 1/2*a[i]^2) + 1/2*(a[1] - a[2])^2";
    let normal = check(frame, 2, &["2/3", "6/5"]);
    let classes: Vec<Option<&str>> = normal.modes.iter().map(|mode| mode.symmetry.as_deref()).collect();
    assert_eq!(classes, [Some("even"), Some("odd")]);
}

#[test]
fn equilibria_are_searched_for_with_nodes() {
    // The node rests where 2 y + y³ = g; its springs have 2 + 3 y² = 14 there, and with 7 behind it 14/3.
    let text = "param g = 12  coord x, y  T = 1/2*x'^2  V = y^2 + 1/4*y^4 + 7/2*(x - y)^2 - g*x  guess y = 1";
    let (linearized, normal) = solved(text);
    assert!(linearized.equilibrium().proved);
    let own = normal.modes[0].omega_squared.unwrap();
    assert!((own - number("14/3")).contains_zero() && own.radius < 1e-12, "{own:?}");
}

#[test]
fn friction_elsewhere_leaves_nodes_alone() {
    let (_, normal) =
        solved("param c = 1/10  coord x, y  T = 1/2*x'^2  V = 10*y^2 + 15*(x - y)^2  dissipation = 1/2*c*x'^2");
    let mode = &normal.modes[0];
    assert!((mode.growth + number("1/20")).contains_zero());
    assert!((mode.omega * mode.omega + mode.growth * mode.growth - number("12")).contains_zero());
}

#[test]
fn what_nothing_holds_is_an_error() {
    for text in [
        "coord x, y  T = 1/2*x'^2  V = x^2",
        "coord x, y, z  T = 1/2*x'^2  V = x^2 + (y - z)^2",
        "coord x, y  T = 1/2*(x' + y')^2  V = (x + y)^2",
    ] {
        let error = refused(text);
        assert!(matches!(error, LinearizeError::SingularMass { .. }), "{text}: {error}");
        assert!(error.to_string().contains("nothing holds it"), "{text}: {error}");
    }
    // Multipliers, alone and among springs.
    for text in [
        "coord x, z, y  T = 1/2*(x'^2 + z'^2)  V = x^2 + y*(x - z)",
        "coord x, y, z  T = 1/2*x'^2  V = x^2 + (y - z)^2/2 + x*(y + z)",
    ] {
        let error = refused(text);
        assert!(matches!(error, LinearizeError::NotCondensed { .. }), "{text}: {error}");
    }
}

/// s = -3 and the pair of s² + s + 8 = 0, in the order of the modes.
#[track_caller]
fn check_zener(text: &str, dimension: usize, digits: usize) {
    let linearized = linearize(model(text)).unwrap();
    assert_eq!(linearized.dimension(), dimension, "{text}");
    let normal = normal_modes(&linearized, &Options::default().digits(digits)).unwrap();
    let kinds: Vec<Kind> = normal.modes.iter().map(|mode| mode.kind).collect();
    assert_eq!(kinds, [Kind::Overdamped, Kind::Damped], "{text}");
    assert_eq!(normal.stability, Stability::Stable, "{text}");
    let [real, pair] = &normal.modes[..] else { panic!("{text}") };
    assert!((real.growth + number("3")).contains_zero() && real.growth.radius < 1e-12, "{text}: {:?}", real.growth);
    assert!((pair.growth + number("1/2")).contains_zero() && pair.growth.radius < 1e-12, "{text}: {:?}", pair.growth);
    assert!((pair.omega * pair.omega - number("31/4")).contains_zero(), "{text}: {:?}", pair.omega);
}

#[test]
fn friction_adds_real_exponents() {
    let own = "param c = 5/4  coord x, y";
    for digits in [10, 40] {
        check_zener(&format!("{own}  T = 1/2*x'^2  V = 3*x^2 + 5/2*(x - y)^2  dissipation = 1/2*c*y'^2"), 2, digits);
        // The damper between the mass and the node, and the spring behind it.
        check_zener(&format!("{own}  T = 1/2*x'^2  V = 3*x^2 + 5/2*y^2  dissipation = 1/2*c*(x' - y')^2"), 2, digits);
        // Half of the spring on either side of the damper: the sum of both nodes follows at once.
        let both = "T = 1/2*x'^2  V = 3*x^2 + 5*(x - y)^2 + 5*z^2  dissipation = 1/2*c*(y' - z')^2";
        check_zener(&format!("{own}, z  {both}"), 2, digits);
        // Directions that are no coordinates: the mass moves by x + y; and with the node z behind the damper, y + z follows.
        let direction = "T = 1/2*(x' + y')^2  V = 3*(x + y)^2 + 5/2*x^2  dissipation = 1/2*c*y'^2";
        check_zener(&format!("{own}  {direction}"), 2, digits);
        let both = "T = 1/2*(x' + y')^2  V = 3*(x + y)^2 + 5*x^2 + 5*z^2  dissipation = 1/2*c*(y' - z')^2";
        check_zener(&format!("{own}, z  {both}"), 3, digits);
        // Irrational numbers: nothing is decided by whole ones.
        let turned =
            "param a = sqrt(2) + ln(3)  T = 1/2*x'^2  V = 3*x^2 + 5/2*(x - a*y)^2  dissipation = 1/2*c*a^2*y'^2";
        check_zener(&format!("{own}  {turned}"), 2, digits);
    }
    let (_, normal) = solved("coord y  T = 0  V = 3/2*y^2  dissipation = y'^2");
    assert!((normal.modes[0].growth + number("3/2")).contains_zero());
    assert_eq!(normal.modes.len(), 1);
}

#[test]
fn what_friction_does_not_reach_keeps_its_growth_of_0() {
    let (_, normal) = solved(
        "coord x, y[1..2], z  T = 1/2*x'^2 + 1/2*z'^2  V = 1/2*x^2 + (x - y[1])^2 + 3/2*(x - y[2])^2 + 7/2*z^2
         dissipation = 3/20*y[1]'^2 + 3/10*y[2]'^2",
    );
    let kinds: Vec<Kind> = normal.modes.iter().map(|mode| mode.kind).collect();
    assert_eq!(kinds, [Kind::Overdamped, Kind::Overdamped, Kind::Damped, Kind::Oscillation]);
    let last = &normal.modes[3];
    assert!(last.growth.is_zero() && (last.omega * last.omega - number("7")).contains_zero());
    let lowest = linearize(model("coord x, y  T = 1/2*x'^2  V = x^2 + (x - y)^2  dissipation = y'^2")).unwrap();
    let lowest = normal_modes(&lowest, &Options::default().lowest(1)).unwrap();
    assert_eq!(lowest.modes.len(), 1);
}

#[test]
fn free_bodies_joined_by_springs_and_dampers_in_series() {
    // K is 0 but for (x - y)²: the translation and what the damper leaves open.
    let (_, normal) = solved("coord x, y, z  T = 1/2*x'^2 + z'^2  V = 5/2*(x - y)^2  dissipation = 3/20*(y' - z')^2");
    let kinds: Vec<Kind> = normal.modes.iter().map(|mode| mode.kind).collect();
    assert_eq!(kinds, [Kind::Zero, Kind::Zero, Kind::Overdamped, Kind::Overdamped]);
    assert_eq!(normal.stability, Stability::Neutral);
    // c s² + k s + k c (1/m1 + 1/m2) = 0 with c = 3/10 and k = 5.
    for mode in &normal.modes[2..] {
        let s = mode.growth;
        assert!((number("3/10") * s * s + number("5") * s + number("9/4")).contains_zero(), "{s:?}");
    }
}

#[test]
fn two_directions_that_rotation_holds_make_one_mode() {
    // A guiding centre: omega² = k p/B², for numbers that whole ones decide and others.
    let drift = "coord x, y  lagrangian = B/2*(x*y' - y*x') - k/2*x^2 - p/2*y^2";
    check(&format!("param B = 2  param k = 1  param p = 3  {drift}"), 0, &["3/4"]);
    check(&format!("param B = sqrt(2)  param k = 1  param p = 3  {drift}"), 0, &["3/2"]);
    // A coordinate and its momentum; beside it a node that follows, and a mass.
    check("coord q, p  lagrangian = p*q' - p^2/4 - 3/2*q^2", 0, &["3/2"]);
    check("coord q, p, w  lagrangian = p*q' - p^2/4 - 3/2*q^2 - (w - q)^2", 1, &["3/2"]);
    check("coord q, p, x  lagrangian = p*q' - p^2/4 - 3/2*q^2 + 1/2*x'^2 - 3*x^2", 0, &["3/2", "6"]);
    // On a saddle it runs away with -omega²; free it rests anywhere, in two directions that are one mode.
    let (_, normal) = solved(&format!("param B = sqrt(2)  param k = 1  param p = -3  {drift}"));
    let [mode] = &normal.modes[..] else { panic!("{normal:?}") };
    assert_eq!((mode.kind, normal.stability), (Kind::Unstable, Stability::Unstable));
    assert!((mode.growth * mode.growth - number("3/2")).contains_zero());
    let (_, normal) = solved("coord x, y, z  lagrangian = x*y' + 1/2*z'^2 - 1/2*z^2");
    let kinds: Vec<Kind> = normal.modes.iter().map(|mode| mode.kind).collect();
    assert_eq!((kinds, normal.stability), (vec![Kind::Zero, Kind::Oscillation], Stability::Neutral));
    // Of three one is left over, which a force at the others' velocities would have to move.
    assert!(matches!(refused("coord x, y, z  lagrangian = x*y' - x^2 - y^2"), LinearizeError::SingularMass { .. }));
}

#[test]
fn nodes_that_springs_hold_may_be_coupled_to_velocities() {
    // x = y', so that the mass of y is 2.
    check("coord x, y  lagrangian = 1/2*y'^2 - 1/2*x^2 - 1/2*y^2 + x*y'", 1, &["1/2"]);
    check("param b = sqrt(3)  coord x, y  lagrangian = 1/2*y'^2 - 1/2*x^2 - 1/2*y^2 + b*x*y'", 1, &["1/4"]);
    // The roots of 161/18 u² - 8599/588 u + 288/49 with u = omega², by sums and products.
    let two = "param k = 3  param b = 1/2  param c = 1/7  coord x, y, z, w
        lagrangian = 1/2*y'^2 + z'^2 - 1/2*k*x^2 - 1/2*y^2 + b*x*y' + z*x' - w^2/2 - z^2 + c*w*z + c*y*z + 2/3*z'*w";
    let (linearized, normal) = solved(two);
    assert_eq!(linearized.massless_directions(), 2);
    let [p, q] = [0, 1].map(|at: usize| normal.modes[at].omega_squared.unwrap());
    assert!((p + q - number("8599/588") / number("161/18")).contains_zero());
    assert!((p * q - number("288/49") / number("161/18")).contains_zero());
    // Friction elsewhere, and a force at a velocity: the exponents of (s² + s/7 + 1) times what is left of the other two.
    let (_, normal) = solved(
        "param c = 1/7  coord x, y, z  T = 1/2*y'^2 + 1/2*z'^2  V = x^2/2 + y^2/2 + z^2/2
         force x = 3*y'  force y = -x'  force z = -c*z'",
    );
    let [first, second] = &normal.modes[..] else { panic!("{normal:?}") };
    // y'' + 3 y'' + y = 0.
    assert!((first.omega * first.omega - number("1/4")).contains_zero() && first.growth.contains_zero());
    assert!((second.growth + number("1/14")).contains_zero());
}

#[test]
fn a_guiding_centre_beside_friction_is_one_mode_more() {
    let (_, normal) = solved(
        "param B = 2  coord x, y, z  lagrangian = B*x*y' - x^2/2 - 3/2*y^2 + 1/2*z'^2 - z^2  dissipation = 1/4*z'^2",
    );
    let [first, second] = &normal.modes[..] else { panic!("{normal:?}") };
    assert!((first.omega * first.omega - number("3/4")).contains_zero() && first.growth.contains_zero());
    assert!((second.growth + number("1/4")).contains_zero() && second.kind == Kind::Damped);
}

#[test]
fn directions_that_springs_hold_may_be_coupled_to_velocities() {
    check("coord x, y  T = 1/2*(x' + y')^2 + x*y'  V = x^2 + y^2", 1, &["4/5"]);
    // Directions with components that no double has: 1/(9 + 4 + 1) and 1/(1 + a^2 + 1).
    check("coord x, y  T = 1/2*(3*x' + 2*y')^2 + x*y'  V = 1/2*x^2 + 1/2*y^2", 1, &["1/14"]);
    check("param a = 3/10  coord x, y  T = 1/2*(x' + a*y')^2 + x*y'  V = 1/2*x^2 + 1/2*y^2", 1, &["100/209"]);
    let (_, normal) = solved("coord x, y  T = 4*x'*y' + 2*x'^2 + 2*y'^2 + x*y'  V = 2*x^2 + 4*x*y + 13/2*y^2");
    let [mode] = &normal.modes[..] else { panic!("{normal:?}") };
    // det(s²M + sG + K) = (4 s² + 4)(4 s² + 13) - (4 s² + 4)² + s² = 37 s² + 36.
    assert!((mode.omega_squared.unwrap() - number("36/37")).contains_zero(), "{:?}", mode.omega_squared);
}

#[test]
fn nodes_under_constraints_follow_in_any_order() {
    // 2 and 3 in series: 6/5.
    for order in ["x, a, b", "a, x, b", "a, b, x"] {
        let series = format!("coord {order}  T = 1/2*x'^2  V = a^2 + 3/2*b^2  constraint x = a + b");
        check(&series, 1, &["6/5"]);
        check(&series.replace("x = a + b", "x' = a' + b'"), 1, &["6/5"]);
    }
    check("coord x, a, b, c  T = 1/2*x'^2  V = (a^2 + b^2 + c^2)/2  constraint x = a + b + c", 2, &["1/3"]);
}

/// Of a relaxation whose coordinate moves 1e14 times as far as the mass it drags along: y/x = m s²/k + 2.
#[test]
fn what_hardly_moves_a_mass_is_normalised_by_it() {
    for (friction, rate) in [("1e-5", 1e9), ("2e-5", 5e8), ("1e-4", 1e8)] {
        let (_, normal) = solved(&format!(
            "coord x, y  T = 1/2*x'^2  V = 1/2*1e4*x^2 + 1/2*1e4*(x - y)^2  dissipation = 1/2*{friction}*y'^2"
        ));
        let own = normal.modes.iter().find(|own| own.growth.mid_f64() < -0.9 * rate).unwrap();
        let ratio = 1e-4 * own.growth.mid_f64().powi(2) + 2.0;
        let [x, y] = own.vector[..] else { panic!("{own:?}") };
        assert!((x - 1.0).abs() <= own.vector_error_bound && (y - ratio).abs() <= own.vector_error_bound, "{own:?}");
        assert!(own.vector_error_bound <= 1e-14 * ratio, "{own:?}");
    }
}

/// With friction alone at what has no inertia an exponent is added to make the pencil regular: here the first one that is tried, -89/64,
/// is one of the model, too.
#[test]
fn an_exponent_that_is_added_may_be_there() {
    let (_, normal) = solved(
        "param ky = pi/6  param q = exp(1)/20  param s = 89/64  param kx = q^2/(ky - s) - s^2 + 0.9*s
         coord x, y  T = 1/2*x'^2  V = 1/2*kx*x^2 + q*x*y + 1/2*ky*y^2  dissipation = 1/2*0.9*x'^2 + 1/2*y'^2",
    );
    let growths: Vec<f64> = normal.modes.iter().map(|mode| mode.growth.mid_f64()).collect();
    assert_eq!(growths, [0.511_213_986_220_822_3, -0.544_187_761_819_121_1, -1.390_625]);
}
