//! Normal coordinates of all models: with the amplitudes that are printed M becomes 1 and K the squares of the
//! reference frequencies, and the page says the same with its abbreviations.
#![cfg(feature = "cli")]

use crate::common;

use std::path::Path;

use common::{load, model, model_files, model_in};
use librate::derive::{Motion, Parts, derive};
use librate::expr::{ExprId, Pool, Symbol, Tape};
use librate::linearize::linearize;
use librate::model::Model;
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate::precision::{Ball, Scalar};
use librate::report::{Style, derive_json, derive_latex, derive_text};
use librate_core::derive::{Case, NormalCoordinates, WaveNumber};
use librate_core::expr::Substitution;
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
    let mut all: Vec<f64> =
        modes.map(|mode| number(&mode["omega"]).powi(2) - number(&mode["growth"]).powi(2)).collect();
    all.sort_by(f64::total_cmp);
    all
}

#[test]
fn amplitudes_make_both_matrices_diagonal() {
    let mut checked = Vec::new();
    let quartic = Parts::default().frequencies(true).quartic(true);
    let both = [Parts::default().frequencies(true), quartic];
    let all = model_files().into_iter();
    for (path, parts) in all.flat_map(|path| both.map(|parts| (path.clone(), parts))) {
        let model = load(&path);
        if model.coordinates.len() > 12 {
            continue;
        }
        // Under constraints they are those of fewer coordinates, which the checks of derivations hold against the modes.
        if !model.constraints.is_empty() {
            continue;
        }
        let Ok(derivation) = derive(&model, &parts) else {
            continue;
        };
        let json: Value = serde_json::from_str(&derive_json(&derivation)).unwrap();
        let Some(modes) = json.get("normal_coordinates") else {
            continue;
        };
        // Nor where massless coordinates follow the others.
        if json.get("free_coordinates").is_some() {
            continue;
        }
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let n = model.coordinates.len();
        let texts: Vec<String> = modes
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|mode| {
                let square = mode["omega_squared"].as_str().unwrap();
                let amplitudes = mode["amplitudes"].as_array().unwrap().iter();
                amplitudes.map(move |text| {
                    let text = text.as_str().unwrap();
                    match mode.get("omega") {
                        Some(omega) => text.replace(omega.as_str().unwrap(), &format!("sqrt({square})")),
                        None => text.to_owned(),
                    }
                })
            })
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
                assert!((own.mid_f64() - unit).abs() < 1e-12, "{name} {r} {s}: {own:?}");
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
        "triple_pendulum",
        "three_pendulums_unequal",
        "torsion_discs",
        "two_masses_free",
    ] {
        assert!(checked.iter().any(|own| own == name), "{name}: {checked:?}");
    }
}

/// The value of a parameter.
fn parameter(model: &Model, symbol: Symbol) -> f64 {
    let mut all = model.parameters.iter();
    let own = all.find(|p| p.symbol == symbol).unwrap();
    let tape = Tape::compile(&model.pool, &[own.value.unwrap()], &[]).unwrap();
    tape.evaluate::<f64>(&[], &mut Vec::new())[0]
}

/// An expression at the values of the parameters.
fn page_value(model: &Model, pool: &Pool, e: ExprId) -> f64 {
    let symbols = pool.symbols(e);
    let point: Vec<f64> = symbols.iter().map(|own| parameter(model, *own)).collect();
    let tape = Tape::compile(pool, &[e], &symbols).unwrap();
    tape.evaluate::<f64>(&point, &mut Vec::new())[0]
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
        let point: Vec<f64> =
            symbols.iter().map(|symbol| known.iter().find(|(own, _)| own == symbol).unwrap().1).collect();
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
                    let mut map = Substitution::from([(any, root)]);
                    // Ratios that are given mode by mode.
                    for other in &normal.abbreviations {
                        let name = &other.names[0];
                        if other.modes.as_ref().is_some_and(|(_, modes)| modes.contains(r)) {
                            let own = name.replace(&format!("[{letter}]"), &format!("[{}]", r + 1));
                            let own = pool.variable(&own);
                            let any = pool.symbol(name);
                            map.insert(any, own);
                        }
                    }
                    let e = pool.substitute_one(abbreviation.value, &map);
                    let value = evaluate(&pool, &known, e);
                    let name = &abbreviation.names[0];
                    let name = &name.replace(&format!("[{letter}]"), &format!("[{}]", r + 1));
                    known.push((pool.symbol(name), value));
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
                    let e =
                        sum.expression(
                            &mut pool,
                            |pool, motion| {
                                if motion == Motion::Normal(r) { pool.one() } else { pool.zero() }
                            },
                        );
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
        let parts = Parts::default().frequencies(true).quartic(true);
        let Ok(derivation) = derive(&model, &parts) else {
            continue;
        };
        let Some(found) = derivation.linear.as_ref().ok().and_then(|l| l.frequencies.as_ref()) else {
            continue;
        };
        for case in [Some(&found.general), found.tied.as_ref()].into_iter().flatten() {
            let Some(normal) = &case.normal else {
                continue;
            };
            for (r, own) in page_amplitudes(&model, normal, &derivation.pool).iter().enumerate() {
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
                                // The frequency of the mode.
                                if normal.modes[r].omega.is_some_and(|omega| pool.as_symbol(omega) == Some(*symbol)) {
                                    return page_value(&model, pool, normal.modes[r].omega_squared).sqrt();
                                }
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
    let normal = linear.frequencies.as_ref().unwrap().best().normal.as_ref().unwrap();
    assert_eq!(derivation.names.energies[0], "lagrangian");
    assert_eq!(normal.omega, "Omega");
    assert_eq!(derivation.displaced_text(&normal.coordinates[0]), "B[1]*eta[1] + B[2]*eta[2]");
    assert_eq!(derivation.displaced_text(&normal.coordinates[1]), "b[1]*B[1]*eta[1] + b[2]*B[2]*eta[2]");
    assert_eq!(normal.abbreviations[0].names, ["b[s]"]);
    assert_eq!(
        derivation.displaced_text(&normal.lagrangian),
        "1/2*(eta[1]'^2 + eta[2]'^2 - Omega[1]^2*eta[1]^2 - Omega[2]^2*eta[2]^2)"
    );
}

/// The sums of sines of chains, rings and nets make M the unit matrix and K diagonal, with the squares of the reference.
#[test]
fn waves_make_both_matrices_diagonal() {
    let mut checked = Vec::new();
    for path in model_files() {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let model = load(&path);
        if !(3..=100).contains(&model.coordinates.len()) {
            continue;
        }
        let Ok(derivation) = derive(&model, &Parts::default().frequencies(true)) else {
            continue;
        };
        let linear = derivation.linear.as_ref().ok();
        let Some(found) = linear.and_then(|linear| linear.frequencies.as_ref()) else {
            continue;
        };
        let case = found.best();
        if case.waves.is_empty() {
            continue;
        }
        let n = model.coordinates.len();
        let columns = wave_columns(&model, case, &derivation.pool);
        assert_eq!(columns.len(), n, "{name}");
        let linearized = linearize(model).unwrap();
        let product = |matrix: &[Ball], x: &[f64]| -> Vec<f64> {
            let entry = |i: usize, j: usize| matrix[i + n * j].mid_f64();
            let row = |i: usize| (0..n).map(|j| entry(i, j) * x[j]).sum();
            (0..n).map(row).collect()
        };
        let dot = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
        let (mass, stiffness) = (linearized.mass(), linearized.stiffness());
        let squares = references(&path);
        let scale = squares.iter().map(|s| s.abs()).fold(0.0, f64::max);
        let mut own = Vec::new();
        for (r, x) in columns.iter().enumerate() {
            let (m, k) = (product(&mass, x), product(&stiffness, x));
            for (s, y) in columns.iter().enumerate() {
                let unit = if r == s { 1.0 } else { 0.0 };
                assert!((dot(y, &m) - unit).abs() < 1e-11, "{name} {r} {s}");
                if r == s {
                    own.push(dot(y, &k));
                } else {
                    assert!(dot(y, &k).abs() < 1e-11 * scale, "{name} {r} {s}");
                }
            }
        }
        own.sort_by(f64::total_cmp);
        for (own, want) in own.iter().zip(&squares) {
            assert!((own - want).abs() < 1e-11 * scale, "{name} {own} {want}");
        }
        checked.push(name);
    }
    for name in [
        "chain_walls",
        "chain_free",
        "chain_fixed_free",
        "ring",
        "square_lattice",
        "lc_ladder",
        "beaded_string",
        "beam_simply_supported",
    ] {
        assert!(checked.iter().any(|own| own == name), "{name}: {checked:?}");
    }
}

/// What each coordinate is moved by, mode by mode.
fn wave_columns(model: &Model, case: &Case, pool: &Pool) -> Vec<Vec<f64>> {
    let mut pool = pool.clone();
    let mut columns = Vec::new();
    for waves in &case.waves {
        for sum in &waves.sums {
            let amplitude = pool.mul(sum.factor, sum.shape);
            let mut modes: Vec<Vec<(String, i64)>> = vec![Vec::new()];
            for WaveNumber { name: letter, first, last, .. } in &sum.numbers {
                let mut longer = Vec::new();
                for mode in &modes {
                    for j in *first..=*last {
                        let mut mode = mode.clone();
                        mode.push((letter.clone(), j));
                        longer.push(mode);
                    }
                }
                modes = longer;
            }
            let symbols = pool.symbols(amplitude);
            let tape = Tape::compile(&pool, &[amplitude], &symbols).unwrap();
            for mode in modes {
                let mut column = vec![0.0; model.coordinates.len()];
                for (at, i) in waves.order.iter().enumerate() {
                    let mut own = mode.clone();
                    let mut rest = at as i64;
                    for (letter, size) in waves.places.iter().rev() {
                        own.push((letter.clone(), rest % size + 1));
                        rest /= size;
                    }
                    let inputs: Vec<f64> = symbols
                        .iter()
                        .map(|symbol| {
                            let name = pool.symbol_name(*symbol);
                            match own.iter().find(|(letter, _)| *letter == name) {
                                Some((_, value)) => *value as f64,
                                None => parameter(model, *symbol),
                            }
                        })
                        .collect();
                    column[*i] = tape.evaluate::<f64>(&inputs, &mut Vec::new())[0];
                }
                columns.push(column);
            }
        }
    }
    columns
}

/// Chains with all kinds of ends, against the certified modes.
#[test]
fn chains_with_all_kinds_of_ends() {
    // What stands at the first and the last mass: a spring of the chain to a wall, nothing, a spring of twice the stiffness (a wall
    // half a distance off).
    for (left, right) in [(1, 1), (0, 0), (2, 2), (1, 0), (0, 1), (2, 1), (1, 2), (0, 2), (2, 0)] {
        let text = format!(
            "param m = 3  param k = 2  coord y[1..7]
            T = 1/2*m*sum(i in 1..7, y[i]'^2)
            V = 1/2*k*sum(i in 1..6, (y[i+1] - y[i])^2) + 1/2*{left}*k*y[1]^2 + 1/2*{right}*k*y[7]^2"
        );
        let model = model(&text);
        let derivation = derive(&model, &Parts::default().frequencies(true)).unwrap();
        let linear = derivation.linear.as_ref().unwrap();
        let case = linear.frequencies.as_ref().unwrap().best();
        assert_eq!(case.waves.len(), 1, "{left} {right}");
        let columns = wave_columns(&model, case, &derivation.pool);
        let linearized = linearize(model).unwrap();
        let modes = normal_modes(&linearized, &Options::default()).unwrap();
        let stiffness = linearized.stiffness();
        let mut own = Vec::new();
        for (r, x) in columns.iter().enumerate() {
            let size: f64 = x.iter().map(|x| 3.0 * x * x).sum();
            assert!((size - 1.0).abs() < 1e-13, "{left} {right} {r}: {size}");
            let force = |i: usize| -> f64 { (0..7).map(|j| stiffness[i + 7 * j].mid_f64() * x[j]).sum() };
            let square: f64 = (0..7).map(|i| x[i] * force(i)).sum();
            for (i, x) in x.iter().enumerate() {
                assert!((force(i) - 3.0 * square * x).abs() < 1e-13, "{left} {right} {r}");
            }
            own.push(square);
        }
        own.sort_by(f64::total_cmp);
        for (own, mode) in own.iter().zip(&modes.modes) {
            let want = mode.omega_squared.unwrap().mid_f64();
            assert!((own - want).abs() < 1e-13, "{left} {right}: {own} {want}");
        }
    }
}

#[test]
fn sums_of_sines_as_they_stand_on_the_page() {
    let page = |text: &str| {
        let derivation = derive(&model(text), &Parts::default().frequencies(true)).unwrap();
        let text = derive_text(&derivation, &Style::default().ascii(true));
        let latex = derive_latex(&derivation, false);
        let at = text.find("\nnormal coordinates").unwrap();
        let chapter = text[at..].lines().skip(2).take_while(|line| !line.is_empty());
        let lines = chapter.map(|line| line.trim().to_owned());
        (lines.collect::<Vec<_>>(), latex)
    };
    // A family that begins elsewhere, and coordinates that are none.
    let (lines, latex) = page(
        "param m  param k  coord x[3..6]
        T = 1/2*m*sum(i in 3..6, x[i]'^2)
        V = 1/2*k*sum(i in 3..5, (x[i+1] - x[i])^2) + 1/2*k*(x[3]^2 + x[6]^2)",
    );
    assert_eq!(
        lines,
        [
            "x[n + 2] = sqrt(2/(5*m))*sum(j in 1..4, sin(pi*j*n/5)*Q[j]), n = 1..4",
            "L = 1/2*sum(j in 1..4, Q[j]'^2 - omega[j]^2*Q[j]^2)",
        ]
    );
    assert!(latex.contains(r"\sum_{j = 1}^{4}"), "{latex}");
    let (lines, _) = page(
        "param m  param k  param n = 2  param L = 1  coord a, b, c
        T = 1/2*n*L*m*(a'^2 + b'^2 + c'^2)
        V = 1/2*k*((a - b)^2 + (b - c)^2 + (c - a)^2)",
    );
    assert_eq!(lines[1], "q = [a, b, c]");
    assert!(lines[0].starts_with("q[l] = "), "{lines:?}");
    assert!(lines[2].starts_with("lagrangian = "), "{lines:?}");
}
