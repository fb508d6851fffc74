//! Normal coordinates of all models: with the amplitudes that are printed M becomes 1 and K the squares of the
//! reference frequencies, and the page says the same with its abbreviations.
#![cfg(feature = "cli")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

mod common;

use std::path::Path;

use common::{load, model, model_files, model_in};
use librate::derive::{Motion, NormalCoordinates, Parts, derive};
use librate::expr::{Pool, Substitution, Symbol, Tape};
use librate::linearize::linearize;
use librate::model::Model;
use librate::precision::{Ball, Scalar};
use librate::report::{Style, derive_json, derive_text};
use serde_json::Value;

/// The values of expressions in the model language, with the parameters of a model.
fn values(path: &Path, expressions: &[String]) -> Vec<Ball> {
    let mut text = std::fs::read_to_string(path).unwrap();
    for (i, expression) in expressions.iter().enumerate() {
        text.push_str(&format!("\nparam amplitude_{i} = {expression}"));
    }
    let model = model_in(&text, path.parent().unwrap(), &[]);
    let value = |i: usize| {
        let name = format!("amplitude_{i}");
        let parameter = model.parameters.iter().find(|p| p.name == name).unwrap();
        let tape = Tape::compile(&model.pool, &[parameter.value.unwrap()], &[]).unwrap();
        tape.evaluate::<Ball>(&[], &mut Vec::new())[0]
    };
    (0..expressions.len()).map(value).collect()
}

/// omega^2 of the modes of a reference, ascending.
fn references(path: &Path) -> Vec<f64> {
    let name = path.file_stem().unwrap().to_string_lossy();
    let text = std::fs::read_to_string(format!("tests/reference/{name}.json")).unwrap();
    let reference: Value = serde_json::from_str(&text).unwrap();
    let number = |value: &Value| -> f64 { value.as_str().unwrap().parse().unwrap() };
    let modes = reference["modes"].as_array().unwrap().iter();
    let mut all: Vec<f64> = modes
        .map(|mode| number(&mode["omega"]).powi(2) - number(&mode["growth"]).powi(2))
        .collect();
    all.sort_by(f64::total_cmp);
    all
}

#[test]
fn amplitudes_make_both_matrices_diagonal() {
    let mut checked = Vec::new();
    for path in model_files() {
        let model = load(&path);
        if model.coordinates.len() > 12 {
            continue;
        }
        let Ok(derivation) = derive(&model, &Parts::default().frequencies(true)) else {
            continue;
        };
        let json: Value = serde_json::from_str(&derive_json(&derivation)).unwrap();
        let Some(modes) = json.get("normal_coordinates") else {
            continue;
        };
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let n = model.coordinates.len();
        let texts: Vec<String> = modes
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|mode| mode["amplitudes"].as_array().unwrap())
            .map(|text| text.as_str().unwrap().to_owned())
            .collect();
        assert_eq!(texts.len(), n * n, "{name}");
        let columns = values(&path, &texts);
        let linearized = linearize(model).unwrap();
        let squares = references(&path);
        let scale = squares.iter().map(|s| s.abs()).fold(0.0, f64::max);
        let form = |matrix: &[Ball], r: usize, s: usize| {
            let mut sum = Ball::ZERO;
            for i in 0..n {
                for j in 0..n {
                    let product = columns[n * r + i].mul(&columns[n * s + j]);
                    sum = sum.add(&product.mul(&matrix[i + n * j]));
                }
            }
            sum
        };
        let (mass, stiffness) = (linearized.mass(), linearized.stiffness());
        assert_eq!(squares.len(), n, "{name}");
        for (r, square) in squares.iter().enumerate() {
            for s in 0..n {
                let unit = if r == s { 1.0 } else { 0.0 };
                let own = form(&mass, r, s);
                assert!(
                    (own.mid_f64() - unit).abs() < 1e-12,
                    "{name} {r} {s}: {own:?}"
                );
                let want = if r == s { *square } else { 0.0 };
                let own = form(&stiffness, r, s);
                let off = (own.mid_f64() - want).abs();
                assert!(off < 1e-12 * scale, "{name} {r} {s}: {own:?}, not {want}");
            }
        }
        checked.push(name);
    }
    for name in [
        "three_pendulums",
        "double_pendulum",
        "co2",
        "dumbbell",
        "two_pendulums_on_a_cart",
        "two_masses_walls",
        "pendulum_on_spring_cart",
        "lc_coupled",
        "spring_pendulum",
        "egg_box_saddle",
    ] {
        assert!(checked.iter().any(|own| own == name), "{name}: {checked:?}");
    }
}

/// The value of every symbol by its name: parameters, and what the page defines.
fn page_amplitudes(model: &Model, normal: &NormalCoordinates, pool: &Pool) -> Vec<Vec<f64>> {
    let mut pool = pool.clone();
    let mut known: Vec<(Symbol, f64)> = Vec::new();
    for parameter in &model.parameters {
        let tape = Tape::compile(&model.pool, &[parameter.value.unwrap()], &[]).unwrap();
        let value = tape.evaluate::<f64>(&[], &mut Vec::new())[0];
        known.push((parameter.symbol, value));
    }
    let evaluate = |pool: &Pool, known: &[(Symbol, f64)], e| {
        let symbols = pool.symbols(e);
        let point: Vec<f64> = symbols
            .iter()
            .map(|symbol| known.iter().find(|(own, _)| own == symbol).unwrap().1)
            .collect();
        let tape = Tape::compile(pool, &[e], &symbols).unwrap();
        tape.evaluate::<f64>(&point, &mut Vec::new())[0]
    };
    for abbreviation in &normal.abbreviations {
        match &abbreviation.modes {
            None => {
                let value = evaluate(&pool, &known, abbreviation.value);
                for name in &abbreviation.names {
                    known.push((pool.symbol(name), value));
                }
            }
            Some((letter, modes)) => {
                let any = pool.symbol(&format!("{}[{letter}]", normal.omega));
                for r in modes {
                    let root = pool.sqrt(normal.modes[*r].omega_squared);
                    let map = Substitution::from([(any, root)]);
                    let e = pool.substitute_one(abbreviation.value, &map);
                    let value = evaluate(&pool, &known, e);
                    let name = abbreviation.names[0].replace(letter.as_str(), &(r + 1).to_string());
                    known.push((pool.symbol(&name), value));
                }
            }
        }
    }
    (0..normal.modes.len())
        .map(|r| {
            normal
                .coordinates
                .iter()
                .map(|sum| {
                    let e = sum.expression(&mut pool, |pool, motion| {
                        if motion == Motion::Normal(r) {
                            pool.one()
                        } else {
                            pool.zero()
                        }
                    });
                    evaluate(&pool, &known, e)
                })
                .collect()
        })
        .collect()
}

#[test]
fn the_page_says_the_same_with_its_abbreviations() {
    let mut checked = 0;
    for path in model_files() {
        let model = load(&path);
        if model.coordinates.len() > 12 {
            continue;
        }
        let Ok(derivation) = derive(&model, &Parts::default().frequencies(true)) else {
            continue;
        };
        let Some(found) = derivation
            .linear
            .as_ref()
            .ok()
            .and_then(|l| l.frequencies.as_ref())
        else {
            continue;
        };
        for case in [Some(&found.general), found.tied.as_ref()]
            .into_iter()
            .flatten()
        {
            let Some(normal) = &case.normal else {
                continue;
            };
            for (r, own) in page_amplitudes(&model, normal, &derivation.pool)
                .iter()
                .enumerate()
            {
                let pool = &derivation.pool;
                let want: Vec<f64> = normal.modes[r]
                    .amplitudes
                    .iter()
                    .map(|e| {
                        let symbols = pool.symbols(*e);
                        let tape = Tape::compile(pool, &[*e], &symbols).unwrap();
                        let point: Vec<f64> = symbols
                            .iter()
                            .map(|symbol| {
                                let mut all = model.parameters.iter();
                                let own = all.find(|p| p.symbol == *symbol).unwrap();
                                let value = own.value.unwrap();
                                let tape = Tape::compile(&model.pool, &[value], &[]).unwrap();
                                tape.evaluate::<f64>(&[], &mut Vec::new())[0]
                            })
                            .collect();
                        tape.evaluate::<f64>(&point, &mut Vec::new())[0]
                    })
                    .collect();
                let size = want.iter().map(|x| x.abs()).fold(0.0, f64::max);
                // The sign of a mode is free.
                let off = |sign: f64| {
                    let pairs = own.iter().zip(&want);
                    pairs.map(|(a, b)| (a - sign * b).abs()).fold(0.0, f64::max)
                };
                let off = off(1.0).min(off(-1.0));
                assert!(off < 1e-11 * size, "{path:?} {r}: {own:?} {want:?}");
                checked += 1;
            }
        }
    }
    assert!(checked > 40, "{checked}");
}

#[test]
fn what_is_not_known_in_closed_form_has_none() {
    let text = |path: &str| {
        let derivation = derive(&load(Path::new(path)), &Parts::all()).unwrap();
        derive_text(&derivation, &Style::default())
    };
    assert!(!text("models/triple_pendulum.lag").contains("normal coordinates"));
    assert!(text("models/dumbbell.lag").contains("normal coordinates"));
}

/// Names of the page that the model has itself are avoided.
#[test]
fn names_of_the_model_are_left_alone() {
    let text = "param Q = 1  param A = 2  param a = 3  param L = 2  param omega = 5  param r = 7  coord x, y
        T = 1/2*Q*x'^2 + 1/2*A*y'^2
        V = 1/2*a*x^2 + 1/2*L*(x - y)^2 + 1/2*omega*y^2 + r*y^4";
    let derivation = derive(&model(text), &Parts::all()).unwrap();
    let linear = derivation.linear.as_ref().unwrap();
    let normal = linear
        .frequencies
        .as_ref()
        .unwrap()
        .best()
        .normal
        .as_ref()
        .unwrap();
    assert_eq!(normal.lagrangian_name, "lagrangian");
    assert_eq!(normal.omega, "Omega");
    assert_eq!(
        derivation.displaced_text(&normal.coordinates[0]),
        "B[1]*eta[1] + B[2]*eta[2]"
    );
    assert_eq!(
        derivation.displaced_text(&normal.coordinates[1]),
        "b[1]*B[1]*eta[1] + b[2]*B[2]*eta[2]"
    );
    assert_eq!(normal.abbreviations[0].names, ["b[s]"]);
    assert_eq!(
        derivation.displaced_text(&normal.lagrangian),
        "1/2*(eta[1]'^2 + eta[2]'^2 - Omega[1]^2*eta[1]^2 - Omega[2]^2*eta[2]^2)"
    );
}
