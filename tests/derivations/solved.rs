//! Equilibria that are found from a guess, in closed forms.

use crate::common::model;
use librate::derive::{Parts, derive};
use librate::expr::Tape;
use librate::precision::Ball;

/// Squares of frequencies and the equilibrium of a model, as text, and the first square as a number.
fn solved(text: &str) -> (Vec<String>, Vec<String>, f64) {
    let model = model(text);
    let mut page = derive(&model, &Parts::default().frequencies(true)).unwrap();
    let linear = page.linear.clone().unwrap();
    let squares: Vec<_> = linear.frequencies.unwrap().best().frequencies.iter().map(|own| own.omega_squared).collect();
    let symbols: Vec<_> = model.parameters.iter().map(|own| own.symbol).collect();
    let values: Vec<Ball> = model
        .parameters
        .iter()
        .map(|own| librate_core::linearize::constant(&model.pool, own.value.unwrap()).unwrap())
        .collect();
    // Symbols of coordinates that are left have no values here.
    let tape = Tape::compile(&page.pool, &squares, &symbols).ok();
    let value = tape.map_or(f64::NAN, |tape| tape.evaluate::<Ball>(&values, &mut Vec::new())[0].mid_f64());
    let pool = &mut page.pool;
    let squares = squares.iter().map(|own| pool.display(*own)).collect();
    (squares, linear.equilibrium.iter().map(|own| pool.display(*own)).collect(), value)
}

#[test]
fn equilibria_from_a_guess_are_put_into_frequencies() {
    for (text, equilibrium, square, value) in [
        ("param a = 2, b = 1  coord x  T = 1/2*x'^2  V = -a*x^2 + b*x^4  guess x = 1", None, "4*a", 8.0),
        ("param a = 2, b = 1  coord x  T = 1/2*x'^2  V = -a*x^2 + b*x^4  guess x = -1", None, "4*a", 8.0),
        (
            "param D = 3, a = 2, d = 1  coord x  T = 1/2*x'^2  V = D*(1 - exp(-a*(x - d)))^2  guess x = 1.2",
            Some("d"),
            "2*D*a^2",
            24.0,
        ),
        // Kepler: L^2 = m*k*r.
        (
            "param L = 2, k = 3, m = 1  coord r  T = 1/2*m*r'^2  V = L^2/(2*m*r^2) - k/r  guess r = 1",
            Some("L^2/(k*m)"),
            "k^4*m^2/L^6",
            81.0 / 64.0,
        ),
        // A weight on a spring that may swing: |z| where z < 0.
        (
            "param m = 1, k = 10, g = 9.81, l = 1  coord z  T = 1/2*m*z'^2
             V = 1/2*k*(sqrt(z^2) - l)^2 + m*g*z  guess z = -2",
            Some("-l - m*g/k"),
            "k/m",
            10.0,
        ),
        (
            "param R = 1, W = 5, g = 9.81  coord th  T = 1/2*R^2*(th'^2 + W^2*sin(th)^2)  V = -g*R*cos(th)
             guess th = 1",
            None,
            "W^2 - g^2/(R^2*W^2)",
            25.0 - 9.81 * 9.81 / 25.0,
        ),
    ] {
        let (squares, at, found) = solved(text);
        assert_eq!(squares, [square], "{text}");
        assert!(equilibrium.is_none_or(|own| at == [own]), "{text}: {at:?}");
        assert!((found - value).abs() < 1e-12 * value, "{text}: {found}");
    }
}

/// What is linear in a coordinate gives it by the others, whose equation may be solved then; what mixes powers and sines stays.
/// Of a family of equilibria one coordinate stays open: rotations of a molecule have the frequency 0, whatever it is.
#[test]
fn places_follow_from_each_other_in_a_family() {
    let text = "param m[1..2] = [1, 2], k = 3, d = 11/10  coord r[1..2, 1..3]
        T = sum(i in 1..2, 1/2*m[i]*dot(r[i]', r[i]'))  V = 1/2*k*(norm(r[2] - r[1]) - d)^2
        guess r[i in 1..2] = [0, 0, SIGN*i]";
    for sign in ["1", "(-1)"] {
        let (squares, places, _) = solved(&text.replace("SIGN", sign));
        assert_eq!(squares, ["0", "k/m[1] + k/m[2]"]);
        let place = if sign == "1" { "r[2,3] - d" } else { "d + r[2,3]" };
        assert_eq!(places, ["0", "0", place, "0", "0", "r[2,3]"]);
    }
}

#[test]
fn one_coordinate_may_follow_another() {
    for (text, want) in [
        (
            "param k = 2, q = 3  coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/4*k*(x^2 - q)^2 + 1/2*k*(y - x^2)^2
             guess x = 1.5  guess y = 3",
            ["sqrt(q)", "q"],
        ),
        (
            "param k = 1, q = 2  coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*k*x^2 + q*cos(x) + 1/2*k*(y - x)^2
             guess x = 1.9  guess y = 1.9",
            ["x", "y"],
        ),
    ] {
        assert_eq!(solved(text).1, want, "{text}");
    }
}
