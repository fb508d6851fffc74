//! Closed forms of all models, read back in the model language, against references of 40 digits that are
//! computed by other means (tests/reference); and as they are written, in one snapshot.
#![cfg(feature = "cli")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

mod common;

use std::path::Path;

use common::{model_files, model_in};
use librate::derive::{Case, Parts, derive};
use librate::expr::Tape;
use librate::model::Model;
use librate::number::Number;
use librate::precision::{Ball, Scalar};
use librate::report::{Style, derive_json, derive_text};
use serde_json::Value;

fn frequencies(model: &Model) -> Value {
    let derivation = derive(model, &Parts::default().frequencies(true)).unwrap();
    serde_json::from_str(&derive_json(&derivation)).unwrap()
}

/// The values of expressions in the model language, with the parameters of a model.
fn values(text: &str, folder: &Path, settings: &[&str], expressions: &[String]) -> Vec<Ball> {
    let mut all = text.to_owned();
    for (i, expression) in expressions.iter().enumerate() {
        all.push_str(&format!("\nparam closed_form_{i} = {expression}"));
    }
    let model = model_in(&all, folder, settings);
    let value = |i: usize| {
        let name = format!("closed_form_{i}");
        let parameter = model.parameters.iter().find(|p| p.name == name).unwrap();
        let tape = Tape::compile(&model.pool, &[parameter.value.unwrap()], &[]).unwrap();
        tape.evaluate::<Ball>(&[], &mut Vec::new())[0]
    };
    (0..expressions.len()).map(value).collect()
}

fn ball(text: &str) -> Ball {
    let (negative, digits) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let number = Number::parse(digits).unwrap();
    Ball::from_number(&if negative { number.neg() } else { number }, ())
}

/// omega^2 of the modes of a reference, ascending.
fn references(name: &str) -> Vec<Ball> {
    let text = std::fs::read_to_string(format!("tests/reference/{name}.json")).unwrap();
    let reference: Value = serde_json::from_str(&text).unwrap();
    let modes = reference["modes"].as_array().unwrap();
    let squared = modes.iter().map(|mode| {
        let (omega, growth) = (
            ball(mode["omega"].as_str().unwrap()),
            ball(mode["growth"].as_str().unwrap()),
        );
        omega.mul(&omega).sub(&growth.mul(&growth))
    });
    let mut all: Vec<Ball> = squared.collect();
    all.sort_by(|a, b| a.mid_f64().total_cmp(&b.mid_f64()));
    all
}

/// Each closed form with its multiplicity among the references; all of them where it says so.
fn check(name: &str, json: &Value, values: &[Ball]) {
    let want = references(name);
    let scale = want.iter().map(|w| w.mid_f64().abs()).fold(0.0, f64::max);
    let mut left = want.clone();
    for (entry, value) in json["frequencies"].as_array().unwrap().iter().zip(values) {
        for _ in 0..entry["multiplicity"].as_u64().unwrap() {
            let near = |w: &Ball| (w.mid_f64() - value.mid_f64()).abs() <= 1e-14 * scale;
            let at = left.iter().position(near);
            let at =
                at.unwrap_or_else(|| panic!("{name}: {entry} is {value:?}, not among {want:?}"));
            left.remove(at);
        }
    }
    let complete = json["frequencies_complete"].as_bool().unwrap();
    assert_eq!(complete, left.is_empty(), "{name}");
}

#[test]
fn closed_forms_agree_with_references() {
    let mut complete = Vec::new();
    let mut lines = Vec::new();
    for path in model_files() {
        let name = path.file_stem().unwrap().to_string_lossy().to_string();
        let text = std::fs::read_to_string(&path).unwrap();
        let folder = path.parent().unwrap();
        let model = model_in(&text, folder, &[]);
        if derive(&model, &Parts::default()).is_err() {
            continue;
        }
        let json = frequencies(&model);
        let Some(entries) = json.get("frequencies") else {
            continue;
        };
        // Where the equilibrium was searched for, coordinates stand for themselves.
        let searched = |(name, at): (&Value, &Value)| name == at;
        let pairs = json["coordinates"].as_array().unwrap().iter();
        if pairs
            .zip(json["equilibrium"].as_array().unwrap())
            .any(searched)
        {
            continue;
        }
        let expressions: Vec<String> = entries
            .as_array()
            .unwrap()
            .iter()
            .map(|entry| entry["omega_squared"].as_str().unwrap().to_owned())
            .collect();
        check(&name, &json, &values(&text, folder, &[], &expressions));
        if json["frequencies_complete"] == true {
            complete.push(name.clone());
        }
        let derivation = derive(&model, &Parts::default().frequencies(true)).unwrap();
        let text = derive_text(&derivation, &Style::default());
        let heading = |line: &&str| line.starts_with("symmetry") || line.contains("frequencies");
        let part = text.lines().skip_while(|line| !heading(line));
        lines.push(format!("{name}\n{}\n", part.collect::<Vec<_>>().join("\n")));
    }
    for name in [
        "three_pendulums",
        "coupled_oscillators_equal",
        "ring",
        "chain_walls",
        "chain_free",
        "chain_fixed_free",
        "beam_simply_supported",
        "diatomic_ring",
        "double_pendulum",
        "co2",
        "square_lattice",
        "tetrahedron",
        "two_pendulums_on_a_cart",
        "torsion_discs",
    ] {
        assert!(complete.iter().any(|own| own == name), "{name}");
    }
    insta::assert_snapshot!("closed_forms_of_all_models", lines.join("\n"));
}

fn forms(case: &Case, text: impl Fn(librate::expr::ExprId) -> String) -> Vec<(String, usize)> {
    let forms = case.frequencies.iter();
    forms
        .map(|f| (text(f.omega_squared), f.multiplicity))
        .collect()
}

#[test]
fn the_odd_class_of_three_pendulums_is_the_one_of_the_text() {
    let text = std::fs::read_to_string("models/three_pendulums.lag").unwrap();
    let derivation = derive(
        &model_in(&text, Path::new("models"), &[]),
        &Parts::default().frequencies(true),
    )
    .unwrap();
    let found = derivation.linear.unwrap().frequencies.unwrap();
    assert!(found.general.frequencies.is_empty());
    let tied = found.tied.unwrap();
    let symmetry = tied.symmetry.unwrap();
    assert_eq!(
        symmetry.ties,
        [
            vec!["m[1]", "m[3]"],
            vec!["l[1]", "l[3]"],
            vec!["k12", "k23"]
        ]
    );
    let odd = tied
        .frequencies
        .iter()
        .find(|f| f.symmetry.as_deref() == Some("odd"))
        .unwrap();
    assert_eq!(
        derivation.pool.display(odd.omega_squared),
        "g/l[1] + L^2*k12/(m[1]*l[1]^2)"
    );
    let block = tied
        .blocks
        .iter()
        .find(|block| block.class == "odd")
        .unwrap();
    assert_eq!(block.basis, [vec![(0, 1), (2, -1)]]);
}

#[test]
fn parameters_without_values_are_drawn() {
    let text = "param k  param m  coord x, y
        T = 1/2*m*(x'^2 + y'^2)  V = 1/2*k*(x^2 + y^2 + (x - y)^2)";
    let derivation = derive(
        &model_in(text, Path::new("."), &[]),
        &Parts::default().frequencies(true),
    )
    .unwrap();
    let found = derivation.linear.unwrap().frequencies.unwrap();
    let pool = &derivation.pool;
    let forms = forms(&found.general, |e| pool.display(e));
    assert_eq!(forms, [("k/m".to_owned(), 1), ("3*k/m".to_owned(), 1)]);
}

#[test]
fn equalities_that_would_make_a_symmetry_are_told() {
    let text = std::fs::read_to_string("models/three_pendulums_unequal.lag").unwrap();
    let derivation = derive(
        &model_in(&text, Path::new("models"), &[]),
        &Parts::default().frequencies(true),
    )
    .unwrap();
    let found = derivation.linear.unwrap().frequencies.unwrap();
    assert!(found.general.symmetry.is_none() && found.tied.is_none());
    let would_be = found.would_be.unwrap();
    assert_eq!(
        would_be.ties,
        [
            vec!["m[1]", "m[3]"],
            vec!["l[1]", "l[3]"],
            vec!["k12", "k23"]
        ]
    );
}

#[test]
fn limits_and_series_of_closed_forms() {
    let text = std::fs::read_to_string("models/two_masses_walls.lag").unwrap();
    let model = model_in(&text, Path::new("models"), &["k1=1", "k2=1/1000", "m1=2"]);
    let mut derivation = derive(&model, &Parts::default().frequencies(true)).unwrap();
    let exact = derivation.clone();
    derivation.expand("k2", 2);
    let value = |derivation: &librate::derive::Derivation| -> Vec<f64> {
        let json: Value = serde_json::from_str(&derive_json(derivation)).unwrap();
        let entries = json["frequencies"].as_array().unwrap();
        let expressions: Vec<String> = entries
            .iter()
            .map(|entry| entry["omega_squared"].as_str().unwrap().to_owned())
            .collect();
        let settings = ["k1=1", "k2=1/1000", "m1=2"];
        let values = values(&text, Path::new("models"), &settings, &expressions);
        values.iter().map(Ball::mid_f64).collect()
    };
    // The next term is of the third power of 1/1000.
    for (series, exact) in value(&derivation).iter().zip(value(&exact)) {
        let off = (series - exact).abs();
        assert!(off < 5e-9 && off > 0.0, "{series} {exact}");
    }
    let mut limit = exact.clone();
    limit.limit("k2", &Number::ZERO);
    let values = value(&limit);
    // k1/m1 = 1/2 and k3/m2 = 5/3.
    assert!((values[0] - 0.5).abs() < 1e-15 && (values[1] - 5.0 / 3.0).abs() < 1e-15);
}

#[test]
fn a_cubic_is_solved_on_request() {
    // Zeros of the Laguerre polynomial L_3 (SymPy: laguerre_poly(3).nroots()), times g/l.
    let want = [0.415774556783479, 2.29428036027904, 6.28994508293748];
    let text = std::fs::read_to_string("models/triple_pendulum.lag").unwrap();
    let model = model_in(
        &text,
        Path::new("models"),
        &["g=1", "l[1]=1", "l[2]=1", "l[3]=1"],
    );
    let plain = frequencies(&model);
    assert!(plain.get("frequencies").is_none());
    let parts = Parts::default().frequencies(true).cubic(true);
    let json = derive_json(&derive(&model, &parts).unwrap());
    let json: Value = serde_json::from_str(&json).unwrap();
    let expressions: Vec<String> = json["frequencies"]
        .as_array()
        .unwrap()
        .iter()
        .map(|entry| entry["omega_squared"].as_str().unwrap().to_owned())
        .collect();
    let settings = ["g=1", "l[1]=1", "l[2]=1", "l[3]=1"];
    let values = values(&text, Path::new("models"), &settings, &expressions);
    for (own, want) in values.iter().zip(want) {
        assert!((own.mid_f64() - want).abs() < 1e-13, "{own:?} {want}");
    }
    assert_eq!(values.len(), 3);
}
