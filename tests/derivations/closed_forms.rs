//! Closed forms of all models, read back in the model language, against references of 40 digits that are
//! computed by other means (tests/reference); and as they are written, in one snapshot.
#![cfg(feature = "cli")]

use crate::common;

use std::path::Path;

use common::{model_files, model_in};
use librate::derive::{Parts, derive};
use librate::expr::Tape;
use librate::model::Model;
use librate::number::Number;
use librate::precision::{Ball, Scalar};
use librate::report::{Style, derive_json, derive_text};
use librate_core::derive::{Case, Frequency};
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
        let (omega, growth) = (ball(mode["omega"].as_str().unwrap()), ball(mode["growth"].as_str().unwrap()));
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
            let at = at.unwrap_or_else(|| panic!("{name}: {entry} is {value:?}, not among {want:?}"));
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
        if pairs.zip(json["equilibrium"].as_array().unwrap()).any(searched) {
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
    forms.map(|f| (text(f.omega_squared), f.multiplicity)).collect()
}

#[test]
fn the_odd_class_of_three_pendulums_is_the_one_of_the_text() {
    let text = std::fs::read_to_string("models/three_pendulums.lag").unwrap();
    let derivation = derive(&model_in(&text, Path::new("models"), &[]), &Parts::default().frequencies(true)).unwrap();
    let found = derivation.linear.unwrap().frequencies.unwrap();
    assert!(found.general.frequencies.is_empty());
    let tied = found.tied.unwrap();
    let symmetry = tied.symmetry.unwrap();
    assert_eq!(symmetry.ties, [vec!["m[1]", "m[3]"], vec!["l[1]", "l[3]"], vec!["k12", "k23"]]);
    let odd = tied.frequencies.iter().find(|f| f.symmetry.as_deref() == Some("odd")).unwrap();
    assert_eq!(derivation.pool.display(odd.omega_squared), "g/l[1] + L^2*k12/(m[1]*l[1]^2)");
    let block = tied.blocks.iter().find(|block| block.class == "odd").unwrap();
    assert_eq!(block.basis, [vec![(0, 1), (2, -1)]]);
}

/// Three atoms around a centre and three more outside, as cyclopropane's in their plane: the two rings turn against each other with
/// 3/2 kM (a + d)²/(m L²) + 3/2 kM a²/(M L²), L being the distance that kM keeps; two frequencies belong to A1, three to E.
#[test]
fn rings_of_bodies_have_closed_forms_by_their_point_group() {
    let text = "param m = 2, M = 1, a = 1, d = 1/2, k = 3, kH = 5, kM = 1/2
        coord c[1..3, 1..2], h[1..3, 1..2]
        equilibrium c[i in 1..3] = a*[cos(2*pi*i/3), sin(2*pi*i/3)]
        equilibrium h[i in 1..3] = (a + d)*[cos(2*pi*i/3), sin(2*pi*i/3)]
        let n[i in 1..3] = c[mod(i, 3) + 1]
        let l[i in 1..3] = c[mod(i + 1, 3) + 1]
        T = sum(i in 1..3, 1/2*m*dot(c[i]', c[i]') + 1/2*M*dot(h[i]', h[i]'))
        V = 1/2*sum(i in 1..3, k*(norm(n[i] - c[i]) - sqrt(3)*a)^2 + kH*(norm(h[i] - c[i]) - d)^2
            + kM*(norm(h[i] - n[i]) - sqrt((a + d)^2 + a^2 + a*(a + d)))^2
            + kM*(norm(h[i] - l[i]) - sqrt((a + d)^2 + a^2 + a*(a + d)))^2)";
    let model = model_in(text, Path::new("."), &[]);
    let json = frequencies(&model);
    let all = json["frequencies"].as_array().unwrap();
    let count = |class: &str| all.iter().filter(|own| own["symmetry"] == class).count();
    assert_eq!([count("A1"), count("A2")], [2, 1], "{json:#}");
    let turning = all.iter().find(|own| own["symmetry"] == "A2").unwrap()["omega_squared"].as_str().unwrap();
    let distance = "(3*a*(a + d) + d^2)";
    let want = format!("3/2*kM*((a + d)^2/m + a^2/M)/{distance}");
    let both = values(text, Path::new("."), &["a=7/5", "M=1/3"], &[turning.to_owned(), want]);
    assert!(both[0].sub(&both[1]).contains_zero(), "{turning}");
}

/// A parameter that is 0 is open like others: what agrees there alone is neither one form nor one frequency more.
#[test]
fn values_of_zero_join_no_frequencies() {
    let two = "param k = 1, q = 0, m = 1, M = 2  coord x, y, z, w
        T = 1/2*m*x'^2 + 1/2*M*y'^2 + 1/2*m*z'^2 + 1/2*M*w'^2
        V = 1/2*k*(x - y)^2 + 1/2*k*(z - w)^2 + 1/2*q*z^2";
    let chain = "param k = 1, q = 0, m = 1  coord x[1..7], y
        T = 1/2*m*sum(i in 1..7, (1 + i)*x[i]'^2) + 1/2*m*y'^2
        V = 1/2*k*sum(i in 1..6, i*i*(x[i+1] - x[i])^2) + 1/2*q*(x[1]^2 + 3*x[5]^2) + q*y^2";
    for text in [two, chain] {
        let all = |settings: &[&str]| -> Vec<String> {
            let json = frequencies(&model_in(text, Path::new("."), settings));
            let mut all: Vec<String> = json["frequencies"].as_array().unwrap().iter().map(Value::to_string).collect();
            all.sort();
            all
        };
        assert_eq!(all(&[]), all(&["q=1/1000"]));
    }
}

/// A planar molecule of four with central forces, as BF3.
#[test]
fn fractions_are_not_piled_up_about_roots() {
    let text = "param M = 11, m = 19, a = 13/10, k = 8, q = 1
        coord b[1..2], f[1..3, 1..2]
        equilibrium b = [0, 0]
        equilibrium f[i in 1..3] = a*[cos(2*pi*i/3), sin(2*pi*i/3)]
        T = 1/2*M*dot(b', b') + sum(i in 1..3, 1/2*m*dot(f[i]', f[i]'))
        V = sum(i in 1..3, 1/2*k*(norm(f[i] - b) - a)^2)
            + sum(i in 1..3, j in i+1..3, 1/2*q*(norm(f[i] - f[j]) - sqrt(3)*a)^2)";
    let json = frequencies(&model_in(text, Path::new("."), &[]));
    let all = json["frequencies"].as_array().unwrap();
    let pair: Vec<&str> =
        all.iter().filter(|own| own["symmetry"] == "E").map(|own| own["omega_squared"].as_str().unwrap()).collect();
    let sum = "3*m*k + 3*M*q + 2*M*k";
    let root = "sqrt(9*(M*q - m*k)^2 + 4*M*k^2*(M + 3*m))";
    assert_eq!(pair, ["-", "+"].map(|sign| format!("1/4*({sum} {sign} {root})/(M*m)")));
    // In-plane vibrations of a triangle about its centre: λ₊ + λ₋ and λ₊ λ₋.
    let [low, high] = [pair[0], pair[1]];
    let wanted = ["k*(3/(2*M) + 1/m) + 3*q/(2*m)", "3*k*q*(M + 3*m)/(4*M*m^2)"];
    let checks = [format!("{low} + {high} - ({})", wanted[0]), format!("({low})*({high}) - {}", wanted[1])];
    for off in values(text, Path::new("."), &["k=17/3"], &checks) {
        assert!(off.contains_zero(), "{off:?}");
    }
}

#[test]
fn parameters_without_values_are_drawn() {
    let text = "param k  param m  coord x, y
        T = 1/2*m*(x'^2 + y'^2)  V = 1/2*k*(x^2 + y^2 + (x - y)^2)";
    let derivation = derive(&model_in(text, Path::new("."), &[]), &Parts::default().frequencies(true)).unwrap();
    let found = derivation.linear.unwrap().frequencies.unwrap();
    let pool = &derivation.pool;
    let forms = forms(&found.general, |e| pool.display(e));
    assert_eq!(forms, [("k/m".to_owned(), 1), ("3*k/m".to_owned(), 1)]);
}

#[test]
fn equalities_that_would_make_a_symmetry_are_told() {
    let text = std::fs::read_to_string("models/three_pendulums_unequal.lag").unwrap();
    let derivation = derive(&model_in(&text, Path::new("models"), &[]), &Parts::default().frequencies(true)).unwrap();
    let found = derivation.linear.unwrap().frequencies.unwrap();
    assert!(found.general.symmetry.is_none() && found.tied.is_none());
    let would_be = found.would_be.unwrap();
    assert_eq!(would_be.ties, [vec!["m[1]", "m[3]"], vec!["l[1]", "l[3]"], vec!["k12", "k23"]]);
}

/// Masses and springs that happen to be equal make a mirror for these values alone.
#[test]
fn general_forms_have_no_class_of_equal_values() {
    let text = "param m1 = 1, m2 = 1, k1 = 2, k2 = 2, k = 3  coord x, y
        T = 1/2*m1*x'^2 + 1/2*m2*y'^2  V = 1/2*k1*x^2 + 1/2*k2*y^2 + 1/2*k*(x - y)^2";
    let derivation = derive(&model_in(text, Path::new("."), &[]), &Parts::default().frequencies(true)).unwrap();
    let found = derivation.linear.as_ref().unwrap().frequencies.as_ref().unwrap();
    let classes = |case: &Case| case.frequencies.iter().map(|own| own.symmetry.clone()).collect::<Vec<_>>();
    assert_eq!(classes(&found.general), [None, None]);
    let of_values = |own: &Frequency| own.symmetry_at_values.as_deref() == Some("even");
    assert!(of_values(&found.general.frequencies[0]) && found.general.frequencies[1].symmetry_at_values.is_some());
    let page = derive_text(&derivation, &Style::default());
    assert!(page.contains("(even at these values)") && page.contains("(even)"), "{page}");
    assert_eq!(classes(found.tied.as_ref().unwrap()), [Some("even".to_owned()), Some("odd".to_owned())]);
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
        let expressions: Vec<String> =
            entries.iter().map(|entry| entry["omega_squared"].as_str().unwrap().to_owned()).collect();
        let settings = ["k1=1", "k2=1/1000", "m1=2"];
        let values = values(&text, Path::new("models"), &settings, &expressions);
        // Which sign of a root that can be drawn comes first is open.
        let mut values: Vec<f64> = values.iter().map(Ball::mid_f64).collect();
        values.sort_by(f64::total_cmp);
        values
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
fn corrections_belong_to_their_zeroth_order() {
    // Whichever of the two circuits is the faster one: L1 C1 = 1, L2 C2 = 2 and the other way round.
    let text = "param L1, L2, C1, C2, M  coord q1, q2
        T = 1/2*L1*q1'^2 + 1/2*L2*q2'^2 + M*q1'*q2'  V = q1^2/(2*C1) + q2^2/(2*C2)";
    for settings in [["L1=1", "L2=2"], ["L1=2", "L2=1"]] {
        let all = [&settings[..], &["C1=1", "C2=1", "M=1/1000"]].concat();
        let model = model_in(text, Path::new("."), &all);
        let mut derivation = derive(&model, &Parts::default().frequencies(true)).unwrap();
        derivation.expand("M", 2);
        let found = derivation.linear.as_ref().unwrap().frequencies.as_ref().unwrap();
        let forms: Vec<String> =
            found.general.frequencies.iter().map(|form| derivation.pool.display(form.omega_squared)).collect();
        assert!(!forms.iter().any(|form| form.contains("sqrt") || form.contains("abs")), "{forms:?}");
        let series = values(text, Path::new("."), &all, &forms);
        let mut series: Vec<f64> = series.iter().map(Ball::mid_f64).collect();
        series.sort_by(f64::total_cmp);
        // Zeros of (1 - L1 z)(1 - L2 z) - M² z².
        let (a, root) = (2.0 - 1e-6, (9.0 - 4.0 * (2.0 - 1e-6_f64)).sqrt());
        for (own, true_value) in series.iter().zip([(3.0 - root) / (2.0 * a), (3.0 + root) / (2.0 * a)]) {
            assert!((own - true_value).abs() < 1e-11, "{own} {true_value}");
        }
    }
}

/// Frequencies that become equal are one, twice, in limits and series alike.
#[test]
fn frequencies_that_become_equal_are_joined() {
    let text = "param k, K, m  coord x, y  T = 1/2*m*(x'^2 + y'^2)  V = 1/2*k*(x^2 + y^2) + 1/2*K*(x - y)^2";
    let exact = derive(&model_in(text, Path::new("."), &[]), &Parts::default().frequencies(true)).unwrap();
    let (mut limit, mut series) = (exact.clone(), exact);
    limit.limit("K", &Number::ZERO);
    series.expand("K", 0);
    for derivation in [limit, series] {
        let found = derivation.linear.as_ref().unwrap().frequencies.as_ref().unwrap();
        let forms = found.general.frequencies.iter();
        let forms: Vec<_> = forms.map(|own| (derivation.pool.display(own.omega_squared), own.multiplicity)).collect();
        assert_eq!(forms, [("k/m".to_owned(), 2)]);
    }
}

/// Of two frequencies one grows without end as m vanishes; the other has its series.
#[test]
fn a_frequency_that_stays_finite_has_its_series() {
    let text = "param m, M, k, p  coord x, y  T = 1/2*m*x'^2 + 1/2*M*y'^2  V = 1/2*k*(x - y)^2 + 1/2*p*x^2";
    let settings = ["m=1/1000", "M=2", "k=3", "p=5"];
    let mut derivation =
        derive(&model_in(text, Path::new("."), &settings), &Parts::default().frequencies(true)).unwrap();
    derivation.expand("m", 2);
    let found = derivation.linear.as_ref().unwrap().frequencies.as_ref().unwrap();
    let forms = found.general.frequencies.iter().map(|form| derivation.pool.display(form.omega_squared));
    let forms: Vec<String> = forms.collect();
    let series: Vec<f64> = values(text, Path::new("."), &settings, &forms).iter().map(Ball::mid_f64).collect();
    // (8 - m z)(3 - 2 z) = 9
    let (m, b) = (1e-3, 16.0 + 3e-3);
    let exact = 30.0 / (b + (b * b - 4.0 * 2.0 * m * 15.0_f64).sqrt());
    assert!(series.len() == 1 && (series[0] - exact).abs() < 1e-11, "{forms:?} {series:?} {exact}");
}

/// Where the square of a frequency is negative, so is its series: one root stands in front, beside whose inverse it would take a sign.
#[test]
fn series_of_unstable_frequencies_keep_their_signs() {
    let text = "param a, b, c, g, h  assume a > 0, b > 0, c > 0, g > 0, h > 0  coord x, y
        T = 2/3*a*x'^2 + c*(x*y' - y*x') + 1/2*c^2*(x^2 + y^2)
        V = 1/4*b*x^2 + 1/2*g*h*y^2 + 2/3*g*(y - x)^2  equilibrium x = 0  equilibrium y = 0";
    // Unstable and stable.
    for settings in
        [["a=6/5", "c=7/10", "g=1/2", "h=2/5", "b=1/1000"], ["a=3/10", "c=1/10", "g=3/2", "h=2", "b=1/1000"]]
    {
        let exact = derive(&model_in(text, Path::new("."), &settings), &Parts::default().frequencies(true)).unwrap();
        let mut series = exact.clone();
        series.expand("b", 2);
        let [exact, series] = [exact, series].map(|own| {
            let json: Value = serde_json::from_str(&derive_json(&own)).unwrap();
            let form = json["frequencies"][0]["omega_squared"].as_str().unwrap().to_owned();
            let exponent = json["exponents"][0]["exponent"].as_str().unwrap();
            assert!(!exponent.contains('i') || exponent.matches("sqrt((").count() == 1, "{exponent}");
            values(text, Path::new("."), &settings, &[form])[0].mid_f64()
        });
        assert!(((series - exact) / exact).abs() < 1e-8, "{series} {exact}");
    }
}

/// A root that stands there with one sign alone is a magnitude.
#[test]
fn roots_without_their_opposite_keep_their_sign() {
    let text = "param k, d, h  coord y  T = 1/2*y'^2  V = 1/2*k*(sqrt(y^2 + d^2 + h^2) - 1)^2";
    let mut derivation = derive(&model_in(text, Path::new("."), &[]), &Parts::default().frequencies(true)).unwrap();
    derivation.limit("h", &Number::ZERO);
    let found = derivation.linear.as_ref().unwrap().frequencies.as_ref().unwrap();
    let form = derivation.pool.display(found.general.frequencies[0].omega_squared);
    assert!(form.contains("abs(d)"), "{form}");
}

/// k + e - e²/(k (1 - M)) and k/M + e/M + e²/(k (1 - M)), and √(k/m) (1 - c²/(8 m k)): no fraction within another.
#[test]
fn series_are_sums_over_one_bar_each() {
    let text = "param M = 2  param k = 3  param e = 1/10  coord x, y
        T = 1/2*x'^2 + 1/2*M*y'^2  V = 1/2*k*(x^2 + y^2) + 1/2*e*(x - y)^2";
    let mut derivation = derive(&model_in(text, Path::new("."), &[]), &Parts::all()).unwrap();
    derivation.expand("e", 2);
    let forms = derivation.linear.as_ref().unwrap().frequencies.as_ref().unwrap().general.frequencies.clone();
    let forms: Vec<String> = forms.iter().map(|form| derivation.pool.display(form.omega_squared)).collect();
    assert_eq!(forms, ["k + e - e^2/(k*(1 - M))", "e/M + k/M + e^2/(k*(1 - M))"]);
    let text = "param m = 1  param c = 1/10  param k = 1  coord x
        T = 1/2*m*x'^2  V = 1/2*k*x^2  dissipation = 1/2*c*x'^2";
    let mut derivation = derive(&model_in(text, Path::new("."), &[]), &Parts::all()).unwrap();
    derivation.expand("c", 3);
    let own = derivation.linear.as_ref().unwrap().exponents.as_ref().unwrap();
    assert_eq!(derivation.pool.display(own.exponents[0].imaginary), "sqrt(k/m)*(1 - 1/8*c^2/(m*k))");
}

#[test]
fn limits_and_series_of_exponents() {
    let text = "param m = 1  param c = 1/10  param k = 1  coord x
        T = 1/2*m*x'^2  V = 1/2*k*x^2  dissipation = 1/2*c*x'^2";
    let mut derivation = derive(&model_in(text, Path::new("."), &[]), &Parts::all()).unwrap();
    derivation.limit("c", &Number::ZERO);
    let own = derivation.linear.as_ref().unwrap().exponents.as_ref().unwrap();
    assert!(own.complete && own.exponents.len() == 2 && own.stability.is_none());
    assert!(own.exponents.iter().all(|own| derivation.pool.display(own.real) == "0"));
    assert_eq!(derivation.pool.display(own.exponents[0].imaginary), "sqrt(k/m)");
}

#[test]
fn a_cubic_is_solved_on_request() {
    // Zeros of the Laguerre polynomial L_3 (SymPy: laguerre_poly(3).nroots()), times g/l.
    let want = [0.415774556783479, 2.29428036027904, 6.28994508293748];
    let text = std::fs::read_to_string("models/triple_pendulum.lag").unwrap();
    let model = model_in(&text, Path::new("models"), &["g=1", "l[1]=1", "l[2]=1", "l[3]=1"]);
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

/// Four masses in a row between walls, nothing equal.
const FOUR_MASSES: &str = "param m[1..4] = [2, 3, 5, 1]
    param k[1..5] = [7, 2, 1, 3, 4]
    coord x[1..4]
    T = 1/2*sum(i in 1..4, m[i]*x[i]'^2)
    V = 1/2*k[1]*x[1]^2 + 1/2*sum(i in 1..3, k[i+1]*(x[i+1] - x[i])^2) + 1/2*k[5]*x[4]^2";

/// Equal oscillators in a row, coupled unequally: the squares lie symmetrically about k/m, so that the quartic is a quadratic
/// in (omega^2 - k/m)^2.
const FOUR_COUPLED: &str = "param m = 2  param k = 5  param a = 1  param b = 2  param c = 3/2
    coord x[1..4]
    T = 1/2*m*sum(i in 1..4, x[i]'^2)
    V = 1/2*k*sum(i in 1..4, x[i]^2) + a*x[1]*x[2] + b*x[2]*x[3] + c*x[3]*x[4]";

#[test]
fn a_quartic_is_solved_on_request() {
    // mpmath, 40 digits: eigsy of M^(-1/2) K M^(-1/2).
    for (text, want) in [
        (
            FOUR_MASSES,
            [
                "0.381891308687522349578187896580536658186",
                "0.9580062150537797244747609105170636531806",
                "4.681778507608290389890750174145974949385",
                "7.278323968650407536056301018756424739248",
            ],
        ),
        (
            FOUR_COUPLED,
            [
                "1.184221267118686345461296558675513713792",
                "2.214997673523101482916649022669032970078",
                "2.785002326476898517083350977330967029922",
                "3.815778732881313654538703441324486286208",
            ],
        ),
    ] {
        let model = model_in(text, Path::new("."), &[]);
        for parts in [Parts::default(), Parts::default().cubic(true)] {
            let derivation = derive(&model, &parts.frequencies(true)).unwrap();
            let page = derive_text(&derivation, &Style::default());
            assert!(page.contains("zeros of quartics: --quartic"), "{page}");
            let json: Value = serde_json::from_str(&derive_json(&derivation)).unwrap();
            assert!(json.get("frequencies").is_none());
        }
        let parts = Parts::default().frequencies(true).quartic(true);
        let derivation = derive(&model, &parts).unwrap();
        assert!(!derive_text(&derivation, &Style::default()).contains("--quartic"));
        let json: Value = serde_json::from_str(&derive_json(&derivation)).unwrap();
        let expressions: Vec<String> = json["frequencies"]
            .as_array()
            .unwrap()
            .iter()
            .map(|entry| entry["omega_squared"].as_str().unwrap().to_owned())
            .collect();
        assert_eq!(expressions.len(), 4);
        let own = values(text, Path::new("."), &[], &expressions);
        for (own, want) in own.iter().zip(want) {
            let off = own.sub(&ball(want));
            assert!(off.contains_zero() && off.radius < 1e-11, "{own:?} {want}");
        }
    }
}

#[test]
fn what_a_page_abbreviates_is_what_programs_read() {
    let mut checked = 0;
    let texts = [FOUR_MASSES.to_owned(), FOUR_COUPLED.to_owned()];
    let models = texts.map(|text| model_in(&text, Path::new("."), &[]));
    let files = model_files().into_iter().filter_map(|path| {
        let text = std::fs::read_to_string(&path).unwrap();
        let model = model_in(&text, path.parent().unwrap(), &[]);
        (model.coordinates.len() <= 20).then_some(model)
    });
    for model in files.chain(models) {
        let parts = Parts::default().frequencies(true).quartic(true);
        let Ok(derivation) = derive(&model, &parts) else {
            continue;
        };
        // Equilibria that are searched for have symbols of their own.
        let Some(found) = derivation.linear.as_ref().ok().and_then(|linear| linear.frequencies.as_ref()) else {
            continue;
        };
        for case in [Some(&found.general), found.tied.as_ref()].into_iter().flatten() {
            for solved in &case.solved {
                let mut known: Vec<(String, f64)> = Vec::new();
                for parameter in &model.parameters {
                    let Some(value) = parameter.value else {
                        continue;
                    };
                    let tape = Tape::compile(&model.pool, &[value], &[]).unwrap();
                    let value = tape.evaluate::<f64>(&[], &mut Vec::new())[0];
                    known.push((parameter.name.clone(), value));
                }
                let linearized = librate::linearize::linearize(model.clone()).unwrap();
                let at = linearized.equilibrium().values.iter();
                for (coordinate, value) in model.coordinates.iter().zip(at) {
                    known.push((coordinate.name(), value.mid_f64()));
                }
                let evaluate = |known: &[(String, f64)], e| {
                    let pool = &derivation.pool;
                    let symbols = pool.symbols(e);
                    let inputs: Vec<f64> = symbols
                        .iter()
                        .map(|symbol| {
                            let name = pool.symbol_name(*symbol);
                            known.iter().find(|(own, _)| *own == name).unwrap().1
                        })
                        .collect();
                    let tape = Tape::compile(pool, &[e], &symbols).unwrap();
                    tape.evaluate::<f64>(&inputs, &mut Vec::new())[0]
                };
                for abbreviation in &solved.abbreviations {
                    let value = evaluate(&known, abbreviation.value);
                    known.push((abbreviation.names[0].clone(), value));
                }
                let mut own: Vec<f64> = Vec::new();
                for formula in &solved.formulas {
                    let numbers = formula.numbers.clone();
                    let (letter, numbers) = numbers.unwrap_or(("1".to_owned(), vec![0]));
                    for number in numbers {
                        let mut known = known.clone();
                        known.push((letter.clone(), number as f64));
                        let terms = formula.terms.iter().map(|e| evaluate(&known, *e));
                        let sum: f64 = terms.sum();
                        let whole = evaluate(&known, formula.omega_squared);
                        assert!((sum - whole).abs() < 1e-12 * whole.abs().max(1.0));
                        own.push(sum);
                    }
                }
                let written = solved.frequencies.iter();
                let mut written: Vec<f64> = written.map(|e| evaluate(&known, *e)).collect();
                own.sort_by(f64::total_cmp);
                written.sort_by(f64::total_cmp);
                assert_eq!(own.len(), written.len());
                let size = written.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
                for (own, written) in own.iter().zip(&written) {
                    assert!((own - written).abs() < 1e-12 * size, "{own} {written}");
                    checked += 1;
                }
            }
        }
    }
    assert!(checked >= 20, "{checked}");
}

#[test]
fn closed_forms_of_numbers_far_from_usual_ones() {
    let chain = |m: &str, k: &str| {
        let text = format!(
            "param m = {m}  param k = {k}  coord x, y
            T = m/2*(x'^2 + y'^2)  V = k/2*(x^2 + (x - y)^2)"
        );
        frequencies(&model_in(&text, Path::new("."), &[]))
    };
    let near = chain("2", "3");
    assert!(near["frequencies"].as_array().is_some_and(|all| all.len() == 2));
    assert!(!near["normal_coordinates"].is_null());
    for (m, k) in [("1e300", "1e250"), ("1e-300", "exp(-800)"), ("1e-300", "1e290")] {
        let far = chain(m, k);
        for part in ["frequencies", "normal_coordinates"] {
            assert_eq!(far[part], near[part], "{m} {k} {part}");
        }
    }
    // An equilibrium that is searched for, under a constraint with small numbers.
    let text = "coord x, z  T = x'^2/2 + z'^2/2  V = x^2/2 + z^2/2  constraint 1e-300*z = 1e-300/2";
    let found = frequencies(&model_in(text, Path::new("."), &[]));
    assert!(found["not_linearized"].is_null(), "{found}");
}
