//! The words of mechanics for dimensions, and what is said to be missing.
#![cfg(feature = "engine")]

use librate::diagnostic::Diagnostic;
use librate::model::{Settings, TableTexts, elaborate};
use librate::syntax::parse;

/// What is said about something of a unit that should be of another.
fn said(found: &str, wanted: &str) -> (String, String) {
    let text =
        format!("param m : kg = 1  coord x : m  T = 1/2*m*x'^2  V = 0  param p : {found} = 1  let q : {wanted} = p");
    let file = parse(&text).unwrap();
    let errors = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap_err();
    let diagnostic = Diagnostic::from(&errors[0]);
    (diagnostic.message, diagnostic.help.unwrap())
}

#[test]
fn missing_factors_are_named() {
    for (found, wanted, help) in [
        ("N", "J", "multiply by a length"),
        ("J", "N", "divide by a length"),
        ("m^2/s^2", "J", "multiply by a mass"),
        ("kg*m^2", "J", "divide by the square of a time; is the prime of a velocity missing?"),
        ("kg^2*m^5*s", "J", "a factor in 1/kg/m^3/s^3 is missing"),
    ] {
        assert_eq!(said(found, wanted).1, help, "{found} {wanted}");
    }
}

#[test]
fn units_are_exact() {
    for (unit, value) in [
        ("deg", "pi/180"),
        ("rev", "2*pi"),
        ("rpm", "pi/30"),
        ("min", "60"),
        ("h", "3600"),
        ("d", "86400"),
        ("u", "166053906892/10^38"),
        ("meV", "1602176634/10^31"),
        ("cal", "4.184"),
        ("kcal", "4184"),
        ("angstrom", "1/10^10"),
        ("bar", "100000"),
        ("mbar", "100"),
        ("atm", "101325"),
        ("in", "0.0254"),
        ("ft", "0.3048"),
        ("lb", "0.45359237"),
        ("lbf", "0.45359237*9.80665"),
        ("lbf*s^2/in", "0.45359237*9.80665/0.0254"),
        ("kN*mm/(us)^2", "10^12"),
    ] {
        let text =
            format!("param p : {unit} = 1  param q = {value}  coord x : m  param m : kg = 1  T = 1/2*m*x'^2  V = 0");
        let model = elaborate(&parse(&text).unwrap(), &TableTexts::new(), &Settings::new()).unwrap();
        assert_eq!(model.parameters[0].value, model.parameters[1].value, "{unit}");
    }
}

#[test]
fn rates_beside_other_units_are_suspicious() {
    let warned = |coordinate: &str, other: &str, rate: &str| {
        let text = format!(
            "param W : {other} = 1  param m : kg = 1  param r : m = 1  coord x : m, {coordinate}  \
             T = 1/2*m*(x'^2 + r^2*phi'^2)  V = m*W^2*x^2  equilibrium phi'{rate}"
        );
        let file = parse(&text).unwrap();
        let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
        let mut warnings = model.warnings(&file).into_iter();
        warnings.find(|one| one.code == Some("W0010")).map(|one| one.message)
    };
    for (coordinate, other, rate, message) in [
        ("phi : deg", "rad/s", " = 2", "the number for `phi'` is read in deg/s, but `W` is in rad/s"),
        ("phi : rad", "rpm", " = 2*pi", "the number for `phi'` is read in rad/s, but `W` is in rpm"),
        ("phi", "deg/s", " = -2", "the number for `phi'` is read in 1/s, but `W` is in deg/s"),
    ] {
        assert_eq!(warned(coordinate, other, rate).as_deref(), Some(message));
    }
    for (coordinate, other, rate) in [
        ("phi : rad", "rad/s", " = 2"),
        ("phi : rad", "Hz", " = 2"),
        ("phi : deg", "rpm", " : deg/s = 2"),
        ("phi : deg", "rpm", " = W"),
        ("phi : deg", "rpm", " = 0"),
        ("phi : deg", "deg/s", " = 2"),
    ] {
        assert_eq!(warned(coordinate, other, rate), None, "{coordinate}, {other}{rate}");
    }
}

/// None has two words, else one of them would not be said.
#[test]
fn dimensions_have_their_words() {
    for (unit, word) in [
        ("m", "a length"),
        ("kg", "a mass"),
        ("s", "a time"),
        ("s^2", "the square of a time"),
        ("A", "a current"),
        ("A*s", "a charge"),
        ("K", "a temperature"),
        ("mol", "an amount of substance"),
        ("cd", "a luminous intensity"),
        ("1", "a pure number"),
        ("m^2", "an area"),
        ("m^3", "a volume"),
        ("1/s", "a rate"),
        ("1/s^2", "an angular acceleration"),
        ("m/s", "a velocity"),
        ("m/s^2", "an acceleration"),
        ("m^2/s^2", "the square of a velocity"),
        ("N", "a force"),
        ("J", "an energy"),
        ("W", "a power"),
        ("kg*m/s", "a momentum"),
        ("J*s", "an angular momentum"),
        ("N/m", "a spring constant"),
        ("kg/s", "a friction coefficient"),
        ("kg*m^2", "a moment of inertia"),
        ("kg/m", "a mass per length"),
        ("kg/m^2", "a mass per area"),
        ("kg/m^3", "a density"),
        ("Pa", "a pressure"),
        ("V", "a voltage"),
        ("V/m", "an electric field"),
        ("ohm", "a resistance"),
        ("S", "a conductance"),
        ("F", "a capacitance"),
        ("H", "an inductance"),
        ("Wb", "a magnetic flux"),
        ("T", "a magnetic field"),
    ] {
        let message = said(unit, "kg^3").0;
        assert!(message.ends_with(&format!("its right side is {word}")), "{unit}: {message}");
    }
}

/// A setting is in the unit of its parameter, however the file gives that its value; so is an uncertainty that names nothing.
#[test]
fn settings_are_in_the_units_of_the_file() {
    let value = |text: &str, setting: &str| {
        let mut settings = Settings::new();
        if !setting.is_empty() {
            settings.add(setting).unwrap();
        }
        let model = elaborate(&parse(text).unwrap(), &TableTexts::new(), &settings).unwrap();
        let shown = |e| model.pool.display(e);
        let own = model.parameters.iter().filter(|own| own.name.starts_with('L'));
        let texts =
            own.map(|own| format!("{} ± {}", shown(own.value.unwrap()), own.uncertainty.map_or("?".to_owned(), shown)));
        texts.collect::<Vec<_>>().join(", ")
    };
    let rest = "param m : kg = 1  coord x : m  T = 1/2*m*x'^2  V = 0";
    assert_eq!(value(&format!("param q : m = 1/100  param L : cm = q*3  {rest}"), "L=4"), "1/25 ± ?");
    assert_eq!(
        value(&format!("param q : m = 1/100  param L[1..2] : cm = q*3  {rest}"), "L[2]=4"),
        "0.03 ± ?, 1/25 ± ?"
    );
    assert_eq!(value(&format!("param q : m = 1/100  param L : cm = 2 ± q  {rest}"), ""), "0.02 ± 0.01");
    assert_eq!(value(&format!("param q : m = 1/100  param L : cm = q ± 1  {rest}"), ""), "0.01 ± 0.01");
    let family = format!("param L[i in 1..2] : cm = i ± i/10  {rest}");
    assert_eq!(value(&family, ""), "0.01 ± 0.001, 0.02 ± 0.002");
}

/// Energies may stand before what they use, and pieces of a family have one dimension.
#[test]
fn dimensions_do_not_depend_on_the_order() {
    let codes = |text: &str| {
        let errors = elaborate(&parse(text).unwrap(), &TableTexts::new(), &Settings::new()).unwrap_err();
        errors.iter().map(|error| Diagnostic::from(error).code.unwrap()).collect::<Vec<_>>().join(" ")
    };
    let rest = "coord x : m  param m : kg = 1  T = 1/2*m*x'^2";
    assert_eq!(codes(&format!("{rest}  V = 1/2*k*x^2 + k*x  param k : N/m = 4")), "E0202");
    assert_eq!(codes(&format!("equilibrium x : s = 0  {rest}  V = 0")), "E0205");
    assert_eq!(codes(&format!("{rest}  V = 0  param q[1] : m = 1  param q[2] : s = 1")), "E0205");
}
