//! `derive --limit` and `--expand`: what they print, at the values of the parameters, against closed forms.
#![cfg(feature = "cli")]

use crate::{cli_support, common};

use std::path::Path;

use cli_support::*;
use common::model_in;
use fancy_regex::Regex;
use librate::linearize::constant;
use serde_json::Value;

const PENDULUM: &str = "param g : m/s^2 = 9.81  param l : cm = 30  param m : kg = 1  param k : N/m = 3
    param w : 1/s = sqrt(g/l)  coord th : rad  T = 1/2*m*l^2*th'^2  V = -m*g*l*cos(th) + 1/2*k*l^2*th^2";
const IN_SI: &str = "param g = 9.81  param l = 67  param m = 1  param k = 3  param W = 7.292115e-5  coord q  T = q'^2";

/// Imaginary exponents that are printed, without i, at the values of the parameters but those that are set.
fn printed_values(text: &str, set: &[&str], words: &[&str]) -> Vec<f64> {
    let run = with_input(&[&["derive", "-", "--json"], words].concat(), text);
    assert_eq!(run.status, 0, "{}", run.err);
    let derived: Value = serde_json::from_str(&run.out).unwrap();
    let forms = derived["exponents"].as_array().unwrap().iter().map(|own| own["exponent"].as_str().unwrap());
    let unit = Regex::new(r"\bi\*|\*i\b").unwrap();
    let forms = forms.map(|own| unit.replace_all(own, "").into_owned()).enumerate();
    let forms: Vec<String> = forms.map(|(at, own)| format!("\nparam form{at} = {own}")).collect();
    let plain = if text.contains(" : ") { IN_SI } else { text };
    let model = model_in(&format!("{plain}{}", forms.concat()), Path::new("."), set);
    let own = model.parameters.iter().filter(|own| own.name.starts_with("form"));
    own.map(|own| constant(&model.pool, own.value.unwrap()).unwrap().mid_f64()).collect()
}

fn assert_near(found: &[f64], wanted: &[f64], off: f64) {
    let near = found.len() == wanted.len() && found.iter().zip(wanted).all(|(own, want)| (own - want).abs() < off);
    assert!(near, "{found:?} {wanted:?}");
}

#[test]
fn limits_are_in_the_unit_of_the_parameter() {
    for (value, meters) in [("l=50", 0.5), ("l=10*sqrt(2)", 0.1 * f64::sqrt(2.0))] {
        let omega = (9.81 / meters + 3.0_f64).sqrt();
        assert_near(&printed_values(PENDULUM, &[], &["--limit", value]), &[omega, -omega], 1e-12);
    }
    let text = std::fs::read_to_string("models/foucault_pendulum.lag").unwrap();
    // W, and what is left of it where 2 latitude = pi/3.
    let turn = 7.292115e-5_f64;
    for (value, down) in [("latitude=90", turn), ("latitude=540/pi*pi/6", turn), ("latitude=30", turn / 2.0)] {
        let omega = (9.81 / 67.0 + down * down).sqrt();
        let mut found = printed_values(&text, &[], &["--limit", value]);
        found.sort_by(f64::total_cmp);
        assert_near(&found, &[-omega - down, down - omega, omega - down, omega + down], 1e-12);
    }
    let page = with_input(&["derive", "-", "--only", "frequencies", "--limit", "l=50"], PENDULUM);
    assert!(page.out.contains("for l -> ½"), "{}", page.out);
}

#[test]
fn limits_of_what_is_written_out_are_refused() {
    let chain = "param N = 3  param k = 1  coord x[i in 1..N]
        T = 1/2*sum(i in 1..N, x[i]'^2)  V = 1/2*k*sum(i in 1..N, x[i]^2)";
    for (text, words) in
        [(PENDULUM, ["--limit", "w=0"].as_slice()), (PENDULUM, &["--expand", "w", "2"]), (chain, &["--limit", "N=0"])]
    {
        let run = with_input(&[&["derive", "-"], words].concat(), text);
        assert_eq!((run.status, run.out.as_str()), (2, ""));
        assert!(run.err.contains("is not in the formulas"), "{}", run.err);
    }
    // What cancels is allowed.
    let plain = "param g = 9.81  param l = 3/10  param m = 1  coord th  T = 1/2*m*l^2*th'^2  V = -m*g*l*cos(th)";
    let omega = f64::sqrt(9.81 / 0.3);
    assert_near(&printed_values(plain, &[], &["--limit", "m=0"]), &[omega, -omega], 1e-12);
}

#[test]
fn limits_leave_the_first_of_a_pair_positive_near_zero() {
    let turntable = "param m = 1  param k1 = 4  param k2 = 3  param W = 1  coord x, y
        lagrangian = 1/2*m*((x' - W*y)^2 + (y' + W*x)^2) - 1/2*(k1*x^2 + k2*y^2)";
    let trap = "param m = 1  param b = 10  param a = 3  coord x, y, z
        lagrangian = 1/2*m*(x'^2 + y'^2 + z'^2) + 1/2*b*(x*y' - y*x') - 1/4*m*a^2*(2*z^2 - x^2 - y^2)";
    // omega^4 - (k1 + k2 + 2 W²) omega² + (k1 - W²)(k2 - W²) = 0, and omega² -+ b omega + a²/2 = 0 beside omega = a.
    let near = 0.01_f64;
    let sum = 7.0 + 2.0 * near * near;
    let root = (sum * sum - 4.0 * (4.0 - near * near) * (3.0 - near * near)).sqrt();
    let turning = [((sum - root) / 2.0).sqrt(), ((sum + root) / 2.0).sqrt()];
    let root = (100.0 - 2.0 * near * near).sqrt();
    let trapped = [(10.0 - root) / 2.0, near, (10.0 + root) / 2.0];
    let both = [(turntable, "W", turning.as_slice()), (trap, "a", &trapped)];
    for (text, name, wanted) in both {
        let mut found = printed_values(text, &[&format!("{name}={near}")], &["--expand", name, "2"]);
        assert!(found.chunks(2).all(|pair| pair[0] > 0.0 && pair[0] == -pair[1]), "{found:?}");
        found.retain(|own| *own > 0.0);
        found.sort_by(f64::total_cmp);
        assert_near(&found, wanted, 1e-6);
    }
}

#[test]
fn limits_and_series_divide_by_nothing_that_is_zero() {
    let tops = "param A = 2  param B = 0.5  param H = 6  param a = 3  param b = 2  coord th, ph
        lagrangian = 1/2*(A*th'^2 + B*ph'^2) + H*th'*ph + 1/2*(a*th^2 + b*ph^2)";
    // A B omega^4 - (H² - A b - B a) omega² + a b = 0.
    for (limit, square) in [("a=0", 36.0 - 4.0), ("b=0", 36.0 - 1.5_f64)] {
        let mut found = printed_values(tops, &[], &["--limit", limit]);
        found.sort_by(f64::total_cmp);
        found.dedup();
        assert_near(&found, &[-square.sqrt(), 0.0, square.sqrt()], 1e-12);
    }
    let equal = "param a = 2  param b = 2  param k = 1/100  coord x, y
        T = 1/2*(x'^2 + y'^2)  V = 1/2*a*x^2 + 1/2*b*y^2 + k*x*y";
    for omega in printed_values(equal, &[], &["--expand", "k", "2"]) {
        assert!([2.01, 1.99].iter().any(|own| (omega * omega - own).abs() < 1e-5), "{omega}");
    }
}
