//! `assume`: what it simplifies, what follows from it, and what contradicts the values.
#![cfg(feature = "engine")]

use librate::assert_derives;
use librate::derive::{Derivation, Parts, derive};
use librate::diagnostic::Diagnostic;
use librate::linearize::LinearizeError;
use librate::model::{Model, Settings, TableTexts, elaborate};
use librate::report::{Style, derive_json, derive_latex, derive_text};
use librate::syntax::parse;

fn model(text: &str) -> Result<Model, Vec<Diagnostic>> {
    let file = parse(text).unwrap();
    elaborate(&file, &TableTexts::new(), &Settings::new())
        .map_err(|errors| errors.iter().map(Diagnostic::from).collect())
}

fn derived(text: &str) -> Derivation {
    derive(&model(text).unwrap(), &Parts::all()).unwrap()
}

/// K of a coordinate that has this stiffness, with these assumptions.
fn stiffness(assumed: &str, stiffness: &str) -> String {
    let text = format!("param a, b, c, m[1..3] {assumed} coord x  T = 1/2*x'^2  V = 1/2*({stiffness})*x^2");
    let derivation = derived(&text);
    derivation.pool.display(derivation.linear.as_ref().unwrap().stiffness[0][0])
}

#[test]
fn roots_and_absolute_values() {
    for (assumed, written, short) in [
        ("", "sqrt(a^2)", "abs(a)"),
        ("assume a > 0", "sqrt(a^2)", "a"),
        ("assume a < 0", "sqrt(a^2)", "-a"),
        ("assume a >= 0", "abs(a)^3", "a^3"),
        ("assume 0 < a", "sqrt(4*a^2*b^2)", "2*a*abs(b)"),
        ("assume a > b", "abs(a - b)", "a - b"),
        ("assume a > b", "abs(b - a)", "a - b"),
        ("assume a < b", "sqrt((2*a - 2*b)^2)", "2*b - 2*a"),
        ("assume a != b", "abs(a - b)", "abs(b - a)"),
        // What follows from several.
        ("assume a > b, b > 0", "abs(a)", "a"),
        ("assume a > b, b > c, c > 0", "abs(a)", "a"),
        ("assume a > 0, b > 0", "abs(a + b)", "a + b"),
        ("assume a*b > 0, b > 0", "abs(a)", "a"),
        ("assume a > 1", "abs(a)", "a"),
        ("assume a > -1", "abs(a)", "abs(a)"),
        ("assume m > 0", "abs(m[2])", "m[2]"),
        ("assume m[1] > m[2]", "abs(m[2] - m[1])", "m[1] - m[2]"),
    ] {
        assert_eq!(stiffness(assumed, written), short, "{assumed}: {written}");
    }
}

#[test]
fn members_of_families_in_sums() {
    let text = "param k[1..2]  assume k > 0  coord x[1..2]
        T = sum(i in 1..2, 1/2*x[i]'^2)  V = sum(i in 1..2, 1/2*sqrt(k[i]^2)*x[i]^2)";
    assert_derives!(&derived(text), stiffness = "[[k[1], 0], [0, k[2]]]");
}

#[test]
fn an_equilibrium_with_a_root() {
    let text = |assumed: &str| {
        format!(
            "param m, k, l, h  {assumed}  coord x  T = 1/2*m*x'^2
             V = 1/2*k*(sqrt(x^2 + h^2) - l)^2  equilibrium x = sqrt(l^2 - h^2)"
        )
    };
    let derivation = derived(&text("assume l > h, h > 0"));
    assert_derives!(&derivation, stiffness = "[[k*(1 - h^2/l^2)]]", frequencies = ["k/m*(1 - h^2/l^2)"]);
    let page = derive_text(&derivation, &Style::default());
    assert!(page.contains("\nassumed: l > h, h > 0\n"), "{page}");
    assert!(derive_latex(&derivation, false).contains("Assumed: $l > h$, $h > 0$."));
    assert!(derive_json(&derivation).contains(r#""assumptions": ["l > h", "h > 0"]"#));
    let derivation = derived(&text(""));
    let Err(error @ LinearizeError::ForceOfParameters { .. }) = &derivation.linear else { panic!() };
    let help = Diagnostic::from(error).help.unwrap();
    assert!(help.contains("write `assume l > 0`"), "{help}");
}

#[test]
fn values_have_to_agree() {
    let told = |text: &str| match model(&format!("{text}  coord x  T = 1/2*x'^2  V = a*x^2")) {
        Ok(_) => String::new(),
        Err(errors) => format!("{}: {}", errors[0].code.unwrap(), errors[0].primary.as_ref().unwrap().text),
    };
    for (text, label) in [
        ("param a = 1, b = 2  assume a > b", "E0135: 1 > 2 is false"),
        ("param a = 1, b = 1  assume a != b", "E0135: 1 != 1 is false"),
        ("param a = 2, b = 2  assume a > b", "E0135: 2 > 2 is false"),
        ("param a = sqrt(2)  assume a^2 < 2", "E0135: 2 < 2 is false"),
        ("param a = 1, m[1..3] = [1, 0, 2]  assume m > 0", "E0135: 0 > 0 is false"),
        ("param a = 1, m[1..3] = 1  assume m > [0, 0]", "E0112: the sides of an assumption must have the same shape"),
        ("param a = 1, b = 1  assume a >= b, a <= b, a > -pi, a < 2*b", ""),
        ("param a = 1, b  assume a > b", ""),
    ] {
        let said = told(text);
        assert_eq!(said.split(": ").next(), label.split(": ").next(), "{text}: {said}");
        if label.starts_with("E0135") {
            assert_eq!(said, label, "{text}");
        }
    }
    let text = "param a = 1  coord x  assume x > 0  T = 1/2*x'^2  V = a*x^2";
    assert_eq!(model(text).unwrap_err()[0].code, Some("E0116"));
    let text = "param a : m = 2, b : kg = 1  coord x : m  assume a > b  T = 1/2*b*x'^2  V = 0";
    assert!(model(text).unwrap_err()[0].code.unwrap().starts_with("E02"));
}

/// What angles between bounds say of their sines, without being told so.
#[test]
fn signs_of_angles() {
    let conditions = |assumed: &str, stiffness: &str| {
        let text = format!("param al, k assume k > 0 {assumed} coord x  T = 1/2*x'^2  V = 1/2*k*({stiffness})*x^2");
        let derivation = derived(&text);
        let stability = derivation.linear.unwrap().exponents.unwrap().stability.unwrap();
        stability.iter().filter(|own| own.open.is_some()).count()
    };
    for (assumed, stiffness, open) in [
        ("assume al > 0, al < pi/2", "sin(al)", 0),
        ("assume al > 0, al < pi/2", "cos(al)*tan(al)", 0),
        ("assume al > 0, al < pi/2", "cos(al)", 0),
        ("assume 0 < al, al < 3", "sin(al)", 0),
        ("assume al > -1, al < 1", "cos(al)", 0),
        ("assume al > 0, al < 1", "sin(2*al)", 0),
        ("assume al > 0, al < 2", "sin(2*al)", 1),
        ("assume al > 0, al < 2", "cos(al)", 1),
        ("assume al > 0", "sin(al)", 1),
        ("", "cos(al)", 1),
    ] {
        assert_eq!(conditions(assumed, stiffness), open, "{assumed} {stiffness}");
    }
    let text = "param al, k assume k > 0, al > 0, al < pi/2 coord x  T = 1/2*x'^2  V = 1/2*k*sin(al)*x^2";
    let page = derive_text(&derived(text), &Style::default());
    assert!(page.contains("assumed: k > 0, α > 0, α < ½ π\n"), "{page}");
}

/// A force that nothing balances is told without values, too, as the signs of its factors are known; a page with values says which it needs.
#[test]
fn forces_without_values() {
    let text = "param m, g assume m > 0, g > 0 coord x, y  T = 1/2*m*(x'^2 + y'^2)  V = m*g*y  constraint x = y";
    let error = derived(text).linear.err().unwrap();
    let LinearizeError::NoEquilibrium { forces, .. } = &error else { panic!("{error}") };
    assert_eq!(forces.len(), 1, "{error}");
    assert!(forces[0].1.contains("m*g"), "{error}");
    let text = "param k = 2, P = 1, e0 = 0  coord th  T = 1/2*th'^2  V = 1/2*k*(th - e0)^2 + P*cos(th)";
    let page = derive_text(&derived(text), &Style::default());
    assert!(page.contains("it is one at these values; the force on θ there is\n  k e₀\n"), "{page}");
}

/// Squares are hedged where they may vanish, and nowhere else.
#[test]
fn special_values() {
    for (text, hedged) in [
        ("param k, m assume k > 0, m > 0 coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2", false),
        (
            "param k, m, c assume k > 0, m > 0, c > 0 coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2  dissipation = 1/2*c*x'^2",
            false,
        ),
        ("param a, m assume m > 0 coord x  T = 1/2*m*x'^2  V = 1/2*a^2*x^2", true),
        ("param a, b assume a > 0, b > 0 coord x  T = 1/2*x'^2  V = 1/2*(a - b)^2*x^2", true),
        ("param a, b assume a > 0, b > a coord x  T = 1/2*x'^2  V = 1/2*(a - b)^2*x^2", false),
        ("param a assume a > 0 coord x  T = 1/2*x'^2  V = -1/2*a*x^2", false),
    ] {
        let derivation = derived(text);
        let own = derivation.linear.unwrap().exponents.unwrap();
        assert_eq!(own.settled, !hedged, "{text}");
    }
}

/// What a page adds has no name of an expression that the model has.
#[test]
fn names_of_expressions_are_taken() {
    let text = "param m, k assume m > 0, k > 0 coord x let omega = sqrt(k/m) let L = x let Q = x let s = x
        T = 1/2*m*x'^2  V = 1/2*m*omega^2*x^2 + k*x^4  dissipation = 1/2*k*x'^2";
    let page = derive_text(&derived(text), &Style::default());
    for line in page.lines().filter(|line| line.contains(" = ")) {
        let name = line.trim_start().split(' ').next().unwrap();
        assert!(!["L", "Q", "s"].contains(&name) || line.contains("= x"), "{page}");
    }
}
