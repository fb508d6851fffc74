//! Exponents and conditions of stability in symbols: of all models, against references of 40 digits at their own parameters, and
//! against certified exponents at others drawn at random.
#![cfg(feature = "cli")]

use crate::common;

use std::path::{Path, PathBuf};

use common::model_in;
use librate::assert_derives;
use librate::derive::{Derivation, Parts, derive};
use librate::expect::Expected;
use librate::expr::{ExprId, Symbol, Tape};
use librate::model::Model;
use librate::modes::Options;
use librate::precision::Ball;
use librate_core::derive::Linear;

/// Sets of parameters drawn for each model; `SETS=1000` draws more.
const SETS: usize = 8;

fn page(model: &Model) -> Derivation {
    derive(model, &Parts::default().frequencies(true)).unwrap()
}

/// The values of expressions at those of the parameters; `None` where something else occurs in them.
fn values(page: &Derivation, model: &Model, expressions: &[ExprId]) -> Option<Vec<f64>> {
    let symbols: Vec<Symbol> = page.pool.symbols_of(expressions);
    let value = |symbol: &Symbol| {
        let parameter = model.parameters.iter().find(|own| own.symbol == *symbol)?;
        let tape = Tape::compile(&model.pool, &[parameter.value?], &[]).ok()?;
        Some(tape.evaluate::<Ball>(&[], &mut Vec::new())[0])
    };
    let inputs: Vec<Ball> = symbols.iter().map(value).collect::<Option<_>>()?;
    let tape = Tape::compile(&page.pool, expressions, &symbols).ok()?;
    let found = tape.evaluate(&inputs, &mut Vec::new());
    Some(found.iter().map(Ball::mid_f64).collect())
}

/// Growth and omega of the modes, where there are any.
fn modes(model: Model) -> Option<Vec<(Ball, Ball)>> {
    let linearized = librate::linearize::linearize(model).ok()?;
    let modes = librate::oscillation::normal_modes(&linearized, &Options::default().without_vectors()).ok()?;
    Some(modes.modes.iter().map(|mode| (mode.growth, mode.omega)).collect())
}

/// Files with a model, those of problems among them.
fn files() -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = ["models", "tests/problems"]
        .into_iter()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "lag"))
        .collect();
    files.sort();
    let only = std::env::var("ONLY").unwrap_or_default();
    files.retain(|path| path.to_string_lossy().contains(&only));
    files
}

fn linear(page: &Derivation) -> Option<&Linear> {
    page.reduced().linear.as_ref().ok()
}

#[test]
fn closed_exponents_are_those_of_the_modes() {
    let (mut complete, mut forms) = (0, 0);
    for path in files() {
        let text = std::fs::read_to_string(&path).unwrap();
        let model = model_in(&text, path.parent().unwrap(), &[]);
        let page = page(&model);
        let page = page.reduced();
        let Some(own) = page.linear.as_ref().ok().and_then(|linear| linear.exponents.as_ref()) else {
            continue;
        };
        let parts: Vec<ExprId> = own.exponents.iter().flat_map(|own| [own.real, own.imaginary]).collect();
        let Some(parts) = values(page, &model, &parts) else { continue };
        let Some(modes) = modes(model) else { continue };
        let scale = parts.iter().fold(0.0_f64, |scale, own| scale.max(own.abs()));
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-13 * scale;
        let of_mode = |growth: f64, omega: f64, (real, imaginary): (f64, f64)| {
            // One of a pair ±s stands for both where nothing is damped.
            near(real.abs(), growth.abs()) && near(imaginary.abs(), omega)
        };
        for pair in parts.chunks_exact(2) {
            let found = modes.iter().any(|(g, w)| of_mode(g.mid_f64(), w.mid_f64(), (pair[0], pair[1])));
            assert!(found, "{}: {pair:?} is not among {modes:?}", path.display());
            forms += 1;
        }
        if own.complete {
            for (growth, omega) in &modes {
                let mut all = parts.chunks_exact(2);
                let found = all.any(|pair| of_mode(growth.mid_f64(), omega.mid_f64(), (pair[0], pair[1])));
                assert!(found, "{}: {growth:?} + {omega:?} i has no closed form", path.display());
            }
            complete += 1;
        }
        if let Some(characteristic) = &own.characteristic
            && own.complete
        {
            let count: usize = own.exponents.iter().map(|own| own.multiplicity).sum();
            assert_eq!(count, characteristic.len() - 1, "{}", path.display());
        }
    }
    assert!(std::env::var("ONLY").is_ok() || complete > 90 && forms > 300, "{complete} models, {forms} exponents");
}

/// Common divisors of long polynomials are found with numbers that stay short: this did not end before.
#[test]
fn all_five_matrices_of_two_coordinates_are_derived_at_once() {
    let text = "param m param M param k param c param a param b coord x, y
        T = m*x'^2 + 1/2*M*y'^2 V = 1/2*k*x^2 + k*y^2
        dissipation = 1/2*c*x'^2 + 1/2*c*(x' - y')^2
        force x = -a*y + 2*b*y' force y = 2*a*x - 2*b*x'";
    let page = page(&common::model(text));
    let own = linear(&page).unwrap().exponents.as_ref().unwrap();
    let characteristic: Vec<String> = own.characteristic.iter().flatten().map(|own| page.pool.display(*own)).collect();
    assert_eq!(characteristic[..2], ["2*k^2 + 2*a^2", "5*k*c - 6*a*b - c*a"]);
    assert!(!own.complete && own.stability.as_ref().is_some_and(|own| own.len() == 3));
}

/// Conditions that are long when multiplied out are given in the coefficients.
#[test]
fn long_conditions_are_not_multiplied_out() {
    for (name, count) in [("three_masses_and_a_motor", 6), ("two_masses_on_a_turntable", 7)] {
        let text = std::fs::read_to_string(format!("tests/problems/{name}.lag")).unwrap();
        let page = page(&common::model(&text));
        let own = linear(&page).unwrap().exponents.as_ref().unwrap();
        assert_eq!(own.stability.as_ref().map(Vec::len), Some(count), "{name}");
    }
}

/// At an equilibrium that stays in symbols, coefficients are sums of hundreds of products: the discriminant of a cubic would not end.
#[test]
fn long_coefficients_are_not_multiplied() {
    let text = "param a = 0.7  param b = 1/2  param c = 3/2  coord x, y, th
        T = 1/2*(c + b*(1 + exp(x/2))^2)*x'^2 + 1/2*y'^2 + 1/2*th'^2
        V = 1/2*a*x^2 + 1/2*b*y^2 + 1/2*c*th^2 + b*(atan(th)*ln(2 + x^2) - 1)^2  force x = 0.1*y'";
    let page = page(&common::model(text));
    let own = linear(&page).unwrap().exponents.as_ref().unwrap();
    assert_eq!(own.characteristic.as_ref().map(Vec::len), Some(7));
}

#[test]
fn what_nothing_holds_has_exponents_without_values() {
    let page = page(&common::model("param m coord x, y T = 1/2*m*x'^2 + m*y'^2"));
    let own = linear(&page).unwrap().exponents.as_ref().unwrap();
    assert!(own.complete);
    let all: Vec<usize> = own.exponents.iter().map(|own| own.multiplicity).collect();
    assert_eq!(all, [4]);
}

#[test]
fn a_derivation_is_what_a_book_says() {
    let of = |name: &str| {
        let text = std::fs::read_to_string(format!("models/{name}.lag")).unwrap();
        page(&model_in(&text, Path::new("models"), &[]))
    };
    assert_derives!(
        &of("foucault_pendulum"),
        gyroscopic = "[[0, -2*m*W*sin(latitude)], [2*m*W*sin(latitude), 0]]",
        characteristic = ["g^2/l^2", "0", "2*g/l + 4*W^2*sin(latitude)^2", "0", "1"],
    );
    let damped = of("overdamped_oscillator");
    assert_derives!(&damped, damping = "[[c]]", characteristic = ["D", "c", "J"], stability = ["c", "D"]);
    let wrong = Expected::new().characteristic(["D", "2*c", "J"]).stability(["D"]).gyroscopic("[[0]]");
    let mismatches = wrong.compare(&damped).unwrap_err();
    assert_eq!(mismatches.0.len(), 3, "{mismatches}");
    // A top that sleeps, and a spring on a table that turns.
    let top = of("sleeping_top_fast");
    let conditions = linear(&top).unwrap().exponents.as_ref().unwrap().stability.as_ref().unwrap();
    assert_eq!(conditions.len(), 1);
    assert_derives!(&top, stability = ["C^2*S^2 - 4*A*m*g*l"]);
    // As it stands in books: one fraction bar, no fraction in a sum.
    let text = std::fs::read_to_string("models/ziegler_column.lag").unwrap();
    let column = page(&model_in(&text, Path::new("models"), &["P=0"]));
    let own = linear(&column).unwrap().exponents.as_ref().unwrap();
    let first = column.reduced().pool.display(own.exponents[0].imaginary);
    assert_eq!(first, "1/2*sqrt((7*k - 2*l*P - sqrt((2*l*P - 7*k)^2 - 8*k^2))/m)/l");
}

#[test]
fn the_imaginary_unit_is_no_name_of_the_model() {
    let text = "param i = 2  param m = 1  coord x  T = 1/2*m*x'^2  V = 1/2*i*x^2";
    let text = librate::report::derive_json(&page(&model_in(text, Path::new("."), &[])));
    assert!(text.contains("\"j*sqrt(i/m)\""), "{text}");
}

/// Numbers at random, the same in each run.
struct Draws(u64);

impl Draws {
    /// Between 1/4 and 4.
    fn factor(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let unit = (self.0 >> 40) as f64 / (1_u64 << 24) as f64;
        4_f64.powf(2.0 * unit - 1.0)
    }
}

/// A model with other parameters, where these keep the signs that the derivation uses; and whether some motion grows.
fn redrawn(text: &str, folder: &Path, model: &Model, page: &Derivation, draws: &mut Draws) -> Option<(Model, bool)> {
    let free = model.parameters.iter().filter(|own| page.pool.as_symbol(own.symbolic) == Some(own.symbol));
    let settings: Vec<String> = free
        .filter_map(|own| {
            let tape = Tape::compile(&model.pool, &[own.value?], &[]).ok()?;
            let value = tape.evaluate::<Ball>(&[], &mut Vec::new())[0].mid_f64();
            Some(format!("{}={}", own.name, value * draws.factor()))
        })
        .collect();
    let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
    let other = std::panic::catch_unwind(|| model_in(text, folder, &settings)).ok()?;
    let linear = linear(page)?;
    let (signs, negative): (Vec<ExprId>, Vec<bool>) = linear.signs.iter().copied().unzip();
    let values = values(page, &other, &signs)?;
    if values.iter().zip(negative).any(|(value, negative)| (*value < 0.0) != negative) {
        return None;
    }
    let modes = modes(other.clone())?;
    let undecided = modes.iter().any(|(growth, _)| growth.contains_zero() && !growth.is_zero());
    (!undecided).then(|| (other, modes.iter().any(|(growth, _)| growth.is_positive())))
}

#[test]
fn conditions_of_stability_are_necessary_and_sufficient() {
    let sets = std::env::var("SETS").map_or(SETS, |sets| sets.parse().unwrap());
    let (mut models, mut stable, mut unstable) = (0, 0, 0);
    for path in files() {
        let (text, folder) = (std::fs::read_to_string(&path).unwrap(), path.parent().unwrap());
        let model = model_in(&text, folder, &[]);
        let page = page(&model);
        let Some(linear) = linear(&page) else { continue };
        let Some(own) = linear.exponents.as_ref().and_then(|own| own.stability.as_ref()) else { continue };
        let conditions: Vec<ExprId> = own.iter().map(|own| own.positive).collect();
        let mut draws = Draws(1);
        let mut tried = false;
        for _ in 0..sets {
            let Some((other, grows)) = redrawn(&text, folder, &model, &page, &mut draws) else { continue };
            let Some(values) = values(page.reduced(), &other, &conditions) else { break };
            tried = true;
            let holds = values.iter().all(|value| *value > 0.0);
            assert_eq!(holds, !grows, "{}: {values:?} at {:?}", path.display(), other.parameters);
            stable += usize::from(holds);
            unstable += usize::from(!holds);
        }
        models += usize::from(tried);
    }
    println!("{models} models, {stable} stable sets of parameters, {unstable} unstable ones");
    assert!(std::env::var("ONLY").is_ok() || models > 80 && unstable > 60);
}
