//! The hard numerical cases of models/hard against their references of 40 digits
//! (tests/reference/hard.py): every printed digit is the correctly rounded one, with the ten digits
//! that are printed unless told otherwise and with fifteen; every printed bound covers the true
//! error; zero modes are exact and as many as there are.
//!
//! The lists say what is not reached today. A model that does better than its list says fails the
//! test, so that the list is kept.
#![cfg(all(feature = "engine", feature = "format"))]

use crate::common;

use std::path::{Path, PathBuf};

use common::load;
use librate::linearize::linearize;
use librate::modes::Options;
use librate::number::Number;
use librate::oscillation::normal_modes;
use librate::precision::{Ball, Scalar};
use librate::report::modes_json;
use librate::syntax::format;
use serde_json::Value;

/// Too slow for every run: dense matrices of this size take minutes. Run with `--ignored`.
const SLOW: &[&str] = &["chain_2000"];

/// Not solved, or not rightly, and why.
const FAILS: &[(&str, &str)] = &[];

/// Right, but fewer digits than asked for, or undecided, from this number of digits on.
const FEWER: &[(&str, usize)] = &[];

fn files() -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir("models/hard")
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "lag"))
        .collect();
    files.sort();
    files
}

fn name(path: &Path) -> String {
    path.file_stem().unwrap().to_string_lossy().to_string()
}

fn reference(path: &Path) -> Value {
    let text = format!("tests/reference/hard/{}.json", name(path));
    serde_json::from_str(&std::fs::read_to_string(text).unwrap()).unwrap()
}

/// A decimal string as the number that it is.
fn exact(text: &str) -> Number {
    match text.strip_prefix('-') {
        Some(rest) => Number::parse(rest).unwrap().neg(),
        None => Number::parse(text).unwrap(),
    }
}

/// A field of a mode, which is one line of the JSON, as it is written there: reading it as a double
/// would round it.
fn field<'a>(mode: &'a str, key: &str) -> &'a str {
    let (_, rest) = mode.split_once(&format!("\"{key}\": ")).unwrap();
    rest.split([',', '}']).next().unwrap().trim_matches('"')
}

fn at_most(a: &Number, b: &Number) -> bool {
    !b.sub(a).is_negative()
}

/// Significant digits of a printed number, and one unit of its last place.
fn last_place(text: &str) -> (usize, Number) {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let place = exponent.parse::<i32>().unwrap() - i32::try_from(decimals).unwrap();
    let unit = Number::from(10).powi(place).unwrap();
    (digits.trim_start_matches('0').len(), unit)
}

/// What one model gave: whether all digits were there, or what is wrong.
fn outcome(path: &Path, digits: usize) -> Result<bool, String> {
    let want = reference(path);
    let linearized = linearize(load(path)).map_err(|error| error.to_string())?;
    let options = Options::default().digits(digits);
    let normal = normal_modes(&linearized, &options).map_err(|error| error.to_string())?;
    for (own, want) in linearized.equilibrium().values.iter().zip(want["equilibrium"].as_array().unwrap()) {
        let want = Ball::from_number(&exact(want.as_str().unwrap()), ());
        let off = own.sub(&want).mid_f64().abs();
        if off > own.radius + 1e-31 * want.mid_f64().abs() {
            return Err(format!("the equilibrium is off by {off:e}, its bound is {:e}", own.radius));
        }
    }
    let json = modes_json(&linearized, &normal, &options);
    let found: Vec<&str> = json.lines().filter(|line| line.contains("\"omega_digits\"")).collect();
    let modes = want["modes"].as_array().unwrap();
    if found.len() != modes.len() {
        return Err(format!("{} modes", found.len()));
    }
    let mut complete = true;
    for (at, (own, want)) in found.iter().zip(modes).enumerate() {
        let kind = field(own, "kind");
        let decided = kind != "undecided";
        complete &= decided;
        if decided && kind != want["kind"].as_str().unwrap() {
            return Err(format!("mode {at} is said to be {kind}"));
        }
        for key in ["omega", "growth"] {
            let true_value = exact(want[key].as_str().unwrap());
            // The reference itself ends after 40 digits.
            let slack = true_value.abs().mul(&exact("1e-39"));
            let printed = field(own, &format!("{key}_digits"));
            let off = |value: &Number| value.sub(&true_value).abs().sub(&slack);
            let bound = exact(field(own, "digits_error_bound"));
            if !at_most(&off(&exact(printed)), &bound) {
                return Err(format!("{key} of mode {at}, {printed}, is out of bounds"));
            }
            // The double is the one nearest to what stands there.
            let plain: f64 = field(own, key).parse().unwrap();
            let plain = Number::from_f64_exact(plain).unwrap();
            if !at_most(&off(&plain), &exact(field(own, "error_bound"))) {
                return Err(format!("{key} of mode {at} as a double is out of bounds"));
            }
            if true_value.is_zero() {
                if printed != "0" {
                    return Err(format!("{key} of mode {at} is {printed} instead of 0"));
                }
                continue;
            }
            let (count, unit) = last_place(printed);
            if count > 0 && !at_most(&off(&exact(printed)).mul(&Number::from(2)), &unit) {
                return Err(format!("{key} of mode {at}, {printed}, is not rounded correctly"));
            }
            complete &= count == digits;
        }
    }
    let stability = normal.stability.as_str();
    if stability != want["stability"].as_str().unwrap() && (complete || stability != "undecided") {
        return Err(format!("said to be {stability}"));
    }
    Ok(complete)
}

fn check(path: &Path) {
    let name = name(path);
    let fails = FAILS.iter().find(|(other, _)| *other == name);
    let fewer = FEWER.iter().find(|(other, _)| *other == name);
    for digits in [10, 15] {
        match outcome(path, digits) {
            Err(_) if fails.is_some() => return,
            Err(message) => panic!("{name}, {digits} digits: {message}"),
            Ok(complete) => {
                let expected = fewer.is_none_or(|(_, from)| digits < *from);
                assert!(complete || !expected, "{name} lacks some of {digits} digits");
                assert!(!complete || expected, "{name} has all {digits} digits: take it off the list");
            }
        }
    }
    assert!(fails.is_none(), "{name} is right: take it off the list");
}

#[test]
fn every_digit_is_right() {
    let files = files();
    assert!(files.len() > 40);
    for path in files {
        if !SLOW.contains(&name(&path).as_str()) {
            check(&path);
        }
    }
}

#[test]
#[ignore = "takes minutes"]
fn every_digit_of_slow_models_is_right() {
    for name in SLOW {
        check(Path::new(&format!("models/hard/{name}.lag")));
    }
}

#[test]
fn hard_models_are_canonical_and_introduced() {
    for path in files() {
        let source = std::fs::read_to_string(&path).unwrap();
        assert_eq!(format(&source).unwrap(), source, "{}", path.display());
        let comment = source.lines().take_while(|line| line.starts_with('#'));
        assert!(comment.count() >= 3, "{}", path.display());
    }
}
