//! Small texts that ask for work without end are refused, with what grows and where.
#![cfg(feature = "cli")]

use crate::cli_support;

use cli_support::*;
use librate::budget::{Budget, Limit};
use librate::derive::{Parts, derive};
use librate::diagnostic::Diagnostic;
use librate::linearize::linearize;
use librate::model::{Constant, Model, Settings, TableTexts, elaborate};
use librate::{Error, syntax};

/// Enough for every model that is meant, and little to fill.
const BYTES: u64 = 20_000_000;

fn model(text: &str) -> Result<Model, Error> {
    model_within(text, BYTES)
}

fn model_within(text: &str, bytes: u64) -> Result<Model, Error> {
    let file = syntax::parse(text)?;
    let settings = Settings::new().within(Budget::new(bytes));
    Ok(elaborate(&file, &TableTexts::new(), &settings)?)
}

fn only(error: &Error) -> Diagnostic {
    let mut all = error.diagnostics();
    assert_eq!(all.len(), 1, "{all:?}");
    all.remove(0)
}

/// The code, the message and what the place says.
fn refused(text: &str, error: &Error) -> (&'static str, String, String) {
    let told = only(error);
    let place = told.primary.map_or("", |label| &text[label.span.range()]);
    (told.code.unwrap(), told.message, place.to_owned())
}

fn with_energies(declared: &str, potential: &str) -> String {
    format!("coord x\n{declared}\nT = 1/2*x'^2\nV = {potential}\n")
}

#[test]
fn what_grows_is_named_with_its_place() {
    let cases = [
        // Flat sums of sums: quadratic memory.
        (with_energies("let u[0] = x\nlet u[k in 1..5000] = u[k-1] + sin(u[k-1])", "u[5000]"), "V"),
        (with_energies("param p[1..20000000] = 1", "p[1]*x^2"), "`p`"),
        (with_energies("coord y[1..20000000]", "x^2"), "`y`"),
        (with_energies("coord z[1..2000, 1..2000]", "x^2"), "`z`"),
        (with_energies("param H = sum(i in 1..20000000, 1/i)", "H*x^2"), "`H`"),
        (with_energies("", "sum(i in 1..20000000, sin(i*x))"), "V"),
        (with_energies("let w[k in 1..20000000] = k*x", "dot(w, w)"), "V"),
    ];
    for (text, what) in cases {
        let (code, message, place) = refused(&text, &model(&text).unwrap_err());
        assert_eq!(code, "E0901", "{text}");
        assert_eq!(message, format!("the budget of 20 MB is used up by {what}"));
        assert!(place.contains(what.trim_matches('`')) || what == "V", "{place}");
        assert!(!place.is_empty());
    }
}

#[test]
fn numbers_end_at_a_hundred_thousand_bits() {
    let cases = [
        (
            with_energies(
                "param r = 37/10\nparam u[0] = 1/3\nparam u[k in 1..30] = r*u[k-1]*(1 - u[k-1])",
                "u[30]*x^2",
            ),
            "r*u[k-1]*(1 - u[k-1])",
        ),
        (with_energies("param f[0] = 1\nparam f[k in 1..20000] = k*f[k-1]", "f[20000]*x^2"), "k*f[k-1]"),
        (with_energies("let f[0] = 1\nlet f[k in 1..20000] = k*f[k-1]", "f[20000]*x^2"), "k*f[k-1]"),
        (with_energies("param k = 2^(2^40)", "k*x^2"), "2^(2^40)"),
        (with_energies("", "x^2*10^(10^9)"), "10^(10^9)"),
        (with_energies("param k = 1e999999999", "k*x^2"), "1e999999999"),
        (with_energies("param k = 1e-40000", "k*x^2"), "1e-40000"),
        (with_energies("param a = 7^30000  param b = a*a", "b*x^2"), "a*a"),
    ];
    for (text, where_) in cases {
        // Room for the numbers that do fit.
        let error = model_within(&text, 10 * BYTES).unwrap_err();
        let (code, _, place) = refused(&text, &error);
        assert_eq!((code, place.as_str()), ("E0134", where_), "{text}");
    }
    // What fits is as exact as ever.
    assert!(model(&with_energies("param k = 1e30000", "k*x^2")).is_ok());
    assert!(Constant::parse("2^(2^40)").is_err());
    assert!(Constant::parse("sum(i in 1..20000000, 1/i)").is_err());
}

#[test]
fn every_stage_asks_the_same_budget() {
    let many = "coord x[1..5000]\nT = sum(i in 1..5000, 1/2*x[i]'^2)\nV = sum(i in 1..5000, x[i]^2)";
    let error = derive(&model(many).unwrap(), &Parts::all()).unwrap_err();
    assert_eq!(only(&error.into()).code, Some("E0901"));
    // Stopped from outside, a stage has nothing but that to say.
    let text = with_energies("", "x^2/2 + x^4/4");
    let stopped = model(&text).unwrap();
    stopped.pool.budget().stop(Limit::Time(10));
    let error = linearize(stopped).unwrap_err();
    assert_eq!(error.to_string(), "the budget of 10 s is used up by V");
}

#[test]
fn memory_that_is_given_back_may_be_used_again() {
    let budget = Budget::new(BYTES);
    let text = with_energies("param a[1..10000] = 1", "a[1]*x^2");
    let file = syntax::parse(&text).unwrap();
    for _ in 0..20 {
        let settings = Settings::new().within(budget.clone());
        assert!(elaborate(&file, &TableTexts::new(), &settings).is_ok());
    }
}

#[test]
fn the_command_line_has_a_clock() {
    let turns = "coord a, b, c\nlet R = rot_x(a)*rot_y(b)*rot_z(c)\nlet S = R*R\nlet w = angular_velocity(S*S)\n\
                 T = 1/2*dot(w, w)\nV = a^2 + b^2 + c^2\n";
    let clock = ["derive", "-", "--budget", "1s", "--message-format", "json"];
    let run = with_input(&[&clock[..], &["--only", "equations"]].concat(), turns);
    assert_eq!(run.status, 1, "{}", run.err);
    let told: serde_json::Value = serde_json::from_str(&run.err).unwrap();
    assert_eq!(told["code"], "E0901");
    assert_eq!(told["help"], "`--budget` raises it: `--budget 10s`");
    assert!(run.out.is_empty());
    // What was worked out before is written, and what is left out is said.
    let run = with_input(&clock, turns);
    assert_eq!(run.status, 0, "{}", run.err);
    let told: serde_json::Value = serde_json::from_str(&run.err).unwrap();
    assert_eq!((told["severity"].as_str(), told["code"].as_str()), (Some("warning"), None));
    assert!(run.out.contains("mass matrix M") && run.out.contains(": what would follow is left"), "{}", run.out);
    let run = with_input(&[&clock[..], &["--only", "mass"]].concat(), turns);
    assert_eq!((run.status, run.err.as_str()), (0, ""));
}

#[test]
fn budgets_are_read() {
    for limits in ["60s", "10min", "1h", "4GB", "500MB", "60s,4GB", "4GB, 60s", "none"] {
        let run = with_input(&["modes", "-", "--budget", limits], SPRING);
        assert_eq!((run.status, run.err.as_str()), (0, ""), "{limits}");
    }
    for limits in ["", "60", "s", "0s", "1s,2s", "1TB", "-1s", "1s;1GB"] {
        let run = with_input(&["modes", "-", "--budget", limits], SPRING);
        assert_eq!(run.status, 2, "{limits}");
    }
}

#[test]
fn long_formulas_are_refused_before_they_are_written() {
    let mut text = "coord x\nlet a1 = x\n".to_owned();
    for k in 1..60 {
        text += &format!("let a{} = a{k}*a{k} + a{k}\n", k + 1);
    }
    text += "T = 1/2*x'^2\nV = a60\n";
    let run = with_input(&["derive", "-", "--budget", "2s,200MB"], &text);
    assert_eq!(run.status, 1, "{}", run.err);
    assert!(run.err.contains("E0901") && run.err.len() < 2000, "{}", run.err);
}
