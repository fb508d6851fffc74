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
