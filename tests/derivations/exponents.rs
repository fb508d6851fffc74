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
use librate::linearize::LinearizeError;
use librate::model::Model;
use librate::modes::Options;
use librate::precision::Ball;
use librate::report::{Style, derive_text};
use librate_core::derive::Linear;

/// Sets of parameters drawn for each model; `SETS=1000` draws more.
const SETS: usize = 8;

fn page(model: &Model) -> Derivation {
    derive(model, &Parts::default().frequencies(true)).unwrap()
}

/// The values of expressions at those of the parameters; `None` where something else occurs in them.
fn values(page: &Derivation, model: &Model, expressions: &[ExprId]) -> Option<Vec<f64>> {
    let pool = &mut page.pool.clone();
    // Roots of what is 0 at the values are exact.
    let numbers =
        model.parameters.iter().filter_map(|own| Some((own.symbol, model.pool.as_number(own.value?)?.clone())));
    let numbers = numbers.map(|(symbol, value)| (symbol, pool.number(value))).collect();
    let expressions = &pool.substitute(expressions, &numbers);
    let symbols: Vec<Symbol> = pool.symbols_of(expressions);
    let value = |symbol: &Symbol| {
        let parameter = model.parameters.iter().find(|own| own.symbol == *symbol)?;
        let tape = Tape::compile(&model.pool, &[parameter.value?], &[]).ok()?;
        Some(tape.evaluate::<Ball>(&[], &mut Vec::new())[0])
    };
    let inputs: Vec<Ball> = symbols.iter().map(value).collect::<Option<_>>()?;
    let tape = Tape::compile(pool, expressions, &symbols).ok()?;
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

fn page_of_problem(name: &str) -> Derivation {
    let text = std::fs::read_to_string(format!("tests/problems/{name}.lag")).unwrap();
    page(&common::model(&text))
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
        let rolls = !model.rolling.is_empty();
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
            // A page leaves the zeros of conditions on velocities aside.
            let moving = modes.iter().filter(|(growth, omega)| !(rolls && growth.is_zero() && omega.is_zero()));
            for (growth, omega) in moving {
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
        let page = page_of_problem(name);
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

/// Polynomials with factors of second degree alone, in s² or in s.
#[test]
fn factors_of_second_degree_are_found() {
    for (name, count) in [("two_pairs_of_frequencies", 8), ("two_damped_oscillators_in_one", 4)] {
        let page = page_of_problem(name);
        let own = linear(&page).unwrap().exponents.as_ref().unwrap();
        assert!(own.complete && own.exponents.len() == count, "{name}");
    }
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

/// A charge on a hill in a magnetic field: s⁴ + (B² - w²) s² + w⁴/4, imaginary where B² > 2 w².
#[test]
fn conditions_of_stability_make_frequencies_of_complex_exponents() {
    let text = "param B, w  coord x, y
        lagrangian = 1/2*(x'^2 + y'^2) + B/2*(x*y' - y*x') + 1/4*w^2*(x^2 + y^2)";
    let text = librate::report::derive_json(&page(&model_in(text, Path::new("."), &[])));
    let found: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&found["stability"][0], &found["frequencies_complete"]), (&"B^2 - 2*w^2".into(), &true.into()));
    let squares: Vec<&str> =
        found["frequencies"].as_array().unwrap().iter().map(|own| own["omega_squared"].as_str().unwrap()).collect();
    assert_eq!(squares, ["1/4*(B + sqrt(B^2 - 2*w^2))^2", "1/4*(sqrt(B^2 - 2*w^2) - B)^2"]);
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
    // From a guess another equilibrium may be found than the one on the page.
    let there = librate::linearize::linearize(other.clone()).ok()?;
    let found = there.equilibrium().values.iter().map(|own| own.mid_f64());
    let given = self::values(page, &other, &linear.equilibrium);
    // Or the one there is none any more.
    let same = |(a, b): (&f64, f64)| (a - b).abs() <= 1e-9 * (1.0 + b.abs());
    if given.is_some_and(|given| !given.iter().zip(found).all(same)) {
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

/// Squares of frequencies, exponents and conditions of stability of a model, the first two with their multiplicities.
fn told(text: &str) -> [Vec<String>; 3] {
    let page = page(&common::model(text));
    let linear = linear(&page).unwrap();
    let own = linear.exponents.as_ref().unwrap();
    let pool = &mut page.pool.clone();
    let frequencies = linear.frequencies.iter().flat_map(|own| &own.best().frequencies);
    let frequencies = frequencies.map(|own| format!("{}: {}", own.multiplicity, pool.display(own.omega_squared)));
    let frequencies = frequencies.collect();
    let exponents = own
        .exponents
        .iter()
        .map(|own| format!("{}: {} + i*({})", own.multiplicity, pool.display(own.real), pool.display(own.imaginary)));
    let exponents = exponents.collect();
    let conditions = own.stability.iter().flatten().map(|own| pool.display(own.positive));
    [frequencies, exponents, conditions.collect()]
}

/// Side lengths with √3: coefficients that are 0 are none.
#[test]
fn triangles_of_springs_are_stable() {
    let springs = "param k = 2  param m = 1.5  param d = 1
        coord r[1..3, 1..2]
        T = 1/2*m*sum(i in 1..3, dot(r[i]', r[i]'))
        V = 1/2*k*sum(i in 1..3, j in i+1..3, (norm(r[i] - r[j]) - d)^2)
        equilibrium r[1] = [0, 0]  equilibrium r[2] = [d, 0]  equilibrium r[3] = [d/2, sqrt(3)/2*d]";
    let about_centre = "param k = 2  param m = 1.5  param d = 1
        coord r[1..3, 1..2]
        T = 1/2*m*sum(i in 1..3, dot(r[i]', r[i]'))
        V = 1/2*k*sum(i in 1..3, j in i+1..3, (norm(r[i] - r[j]) - d*sqrt(3))^2)
        equilibrium r[i in 1..3] = [d*cos(2*pi*i/3), d*sin(2*pi*i/3)]";
    let in_space = springs.replace("1..2]", "1..3]").replace("d, 0]", "d, 0, 0]").replace("[0, 0]", "[0, 0, 0]");
    let in_space = in_space.replace("sqrt(3)/2*d]", "sqrt(3)/2*d, 0]");
    for text in [springs, about_centre, &in_space] {
        assert_eq!(told(text)[2], ["k"], "{text}");
    }
    let two_kinds = springs.replace("param k = 2", "param k = 2  param q = 3  param M = 2");
    let two_kinds = two_kinds
        .replace("sum(i in 1..3, dot(r[i]', r[i]'))", "sum(i in 1..2, dot(r[i]', r[i]')) + 1/2*M*dot(r[3]', r[3]')");
    let two_kinds = two_kinds.replace(
        "1/2*k*sum(i in 1..3, j in i+1..3, (norm(r[i] - r[j]) - d)^2)",
        "1/2*k*(norm(r[1] - r[2]) - d)^2 + 1/2*q*sum(i in 1..2, (norm(r[i] - r[3]) - d)^2)",
    );
    assert_eq!(told(&two_kinds)[2], ["q", "k"]);
}

/// Frequencies are counted in blocks of three and more, too; what is linear there is no cubic.
#[test]
fn frequencies_are_counted_in_all_blocks() {
    let on_springs = |links: &str, first: usize, last: usize| {
        let all = format!("sum(i in {first}..{last}");
        format!(
            "param k = 2  param a = 1.5  coord x[{first}..{last}]
            T = 1/2*{all}, x[i]'^2)  V = 1/2*k*{all}, x[i]^2) + 1/2*a*{links}"
        )
    };
    let star = |leaves: usize| on_springs(&format!("sum(i in 1..{leaves}, (x[i] - x[0])^2)"), 0, leaves);
    assert_eq!(told(&star(3))[0], ["1: k", "2: k + a", "1: k + 4*a"]);
    assert_eq!(told(&star(4))[0], ["1: k", "3: k + a", "1: k + 5*a"]);
    assert_eq!(told(&star(5))[0], ["1: k", "4: k + a", "1: k + 6*a"]);
    let bipartite = on_springs("sum(i in 1..2, j in 3..5, (x[i] - x[j])^2)", 1, 5);
    assert_eq!(told(&bipartite)[0], ["1: k", "2: k + 2*a", "1: k + 3*a", "1: k + 5*a"]);
    let petersen =
        "sum(i in 0..4, (x[mod(i + 1, 5)] - x[i])^2 + (x[i] - x[i + 5])^2 + (x[5 + mod(i + 2, 5)] - x[5 + i])^2)";
    assert_eq!(told(&on_springs(petersen, 0, 9))[0], ["1: k", "5: k + 2*a", "4: k + 5*a"]);
    let tetrahedron = "param k = 2  param m = 1.5  param d = 1
        coord r[1..4, 1..3]
        T = 1/2*m*sum(i in 1..4, dot(r[i]', r[i]'))
        V = 1/2*k*sum(i in 1..4, j in i+1..4, (norm(r[i] - r[j]) - d)^2)
        equilibrium r[1] = [0, 0, 0]  equilibrium r[2] = [d, 0, 0]  equilibrium r[3] = [d/2, sqrt(3)/2*d, 0]
        equilibrium r[4] = [d/2, sqrt(3)/6*d, sqrt(2/3)*d]";
    assert_eq!(told(tetrahedron)[0], ["6: 0", "2: k/m", "3: 2*k/m", "1: 4*k/m"]);
}

/// Where one part drives another, equal exponents are a Jordan block.
#[test]
fn exponents_of_parts_that_drive_others_have_to_differ() {
    let driven = "param k = 1  param p = 2  param a = 3  coord x, y
        T = 1/2*(x'^2 + y'^2)  V = 1/2*k*x^2 + 1/2*p*y^2  force y = a*x";
    assert_eq!(told(driven)[2], ["p", "k", "(p - k)^2"]);
    // y'' = 0, and then x'' = d y or, with friction, x'' = d y from y'' = -c y': powers of t beyond the first.
    for friction in ["0", "c*y'"] {
        let page = page(&common::model(&format!(
            "param k = 1  param d = 1  param c = 1  coord x, y, z
            T = 1/2*(x'^2 + y'^2 + z'^2)  V = 1/2*k*z^2  force x = d*y  force y = -{friction}"
        )));
        assert!(linear(&page).unwrap().exponents.as_ref().unwrap().stability.is_none(), "{friction}");
    }
}

/// The factors of characteristic polynomials, and how often they occur.
#[test]
fn factors_of_characteristic_polynomials_are_found() {
    let ring = |n: usize| {
        format!(
            "param m = 2  param k = 3  param c = 0.4  coord x[1..{n}]
            T = 1/2*m*sum(i in 1..{n}, x[i]'^2)  V = 1/2*k*sum(i in 1..{n}, (x[mod(i, {n}) + 1] - x[i])^2)
            dissipation = 1/2*c*sum(i in 1..{n}, x[i]'^2)"
        )
    };
    let [_, three, conditions] = told(&ring(3));
    let pair = |sign: &str, inside: &str| format!("-1/2*c/m + i*({sign}1/2*sqrt({inside} - c^2)/m)");
    let both = |times: usize, inside: &str| ["", "-"].map(|sign| format!("{times}: {}", pair(sign, inside)));
    assert_eq!(three[..2], ["1: 0 + i*(0)", "1: -c/m + i*(0)"]);
    assert_eq!(three[2..], both(2, "12*m*k"));
    assert_eq!(conditions, ["c", "k"]);
    assert_eq!(told(&ring(4))[1][2..], [both(1, "16*m*k"), both(2, "8*m*k")].concat());
    // What is left of five is of the fourth degree, and not even.
    assert_eq!(told(&ring(5))[1], ["1: 0 + i*(0)", "1: -c/m + i*(0)"]);
    assert_eq!(told(&ring(6))[1].len(), 8);
    let chain = "param m = 2  param k = 3  param a = 0.7  param c = 0.4  coord x, y, z
        T = 1/2*m*(x'^2 + y'^2 + z'^2)
        V = 1/2*k*(x^2 + y^2 + z^2) + 1/2*a*(y - x)^2 + 1/2*a*(z - y)^2
        dissipation = 1/2*c*(x'^2 + y'^2 + z'^2)";
    let expected = [both(1, "4*m*k"), both(1, "12*m*a + 4*m*k"), both(1, "4*m*(k + a)")];
    assert_eq!(told(chain)[1], expected.concat());
    let turned = "param B = 0.4  param k = 3  coord x, y, z
        lagrangian = 1/2*(x'^2 + y'^2 + z'^2) - 1/2*k*(x^2 + y^2 + z^2) + B*(x*y' + y*z' + z*x')";
    let [_, own, conditions] = told(turned);
    assert_eq!(
        own[..3],
        ["1: 0 + i*(sqrt(k))", "1: 0 + i*(-sqrt(k))", "1: 0 + i*(1/2*(sqrt(4*k + 3*B^2) - sqrt(3)*B))"]
    );
    assert_eq!((own.len(), conditions), (6, vec!["k".to_owned()]));
    let ring = "param k, g  coord y[1..4]
        lagrangian = sum(i in 1..4, 1/2*y[i]'^2 - 1/2*k*(y[mod(i, 4) + 1] - y[i])^2 + g*y[i]'*y[mod(i, 4) + 1])";
    let [_, own, _] = told(ring);
    assert_eq!(own[..2], ["2: 0 + i*(0)", "1: 0 + i*(2*sqrt(k))"]);
    assert_eq!(own.len(), 7);
    // Two that are alike split into their sum and difference.
    let alike = "param m = 1, k = 2, B = 0.5, a = 0.3  coord x, y, u, v
        lagrangian = 1/2*m*(x'^2 + y'^2 + u'^2 + v'^2) - 1/2*k*(x^2 + y^2 + u^2 + v^2) - 1/2*a*((x - u)^2 + (y - v)^2)
            + 1/2*B*(x*y' - y*x' + u*v' - v*u')";
    assert_eq!(told(alike)[1].len(), 8);
}

/// Where exponents are equal at the values of the parameters their forms are as good as anywhere else.
#[test]
fn exponents_may_be_equal_at_the_values() {
    let damped = |c: &str, k: &str| {
        let m = "param m = 0.1  coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2";
        format!("param c = {c}  param k = {k}  {m}  dissipation = 1/2*c*x'^2")
    };
    let (critical, near) = (told(&damped("0.4", "0.4")), told(&damped("0.39", "0.4")));
    assert_eq!(critical[1].len(), 2);
    assert_eq!(critical, near);
    let free = "param m = 1  param k = 0  coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2";
    assert_eq!(told(free)[1], ["1: 0 + i*(sqrt(k/m))", "1: 0 + i*(-sqrt(k/m))"]);
    let turning = |k: &str| {
        let text = "param W = 2  coord x, y  T = 1/2*((x' - W*y)^2 + (y' + W*x)^2)  V = 1/2*k*(x^2 + y^2)";
        format!("param k = {k}  {text}")
    };
    let resting = told(&turning("4"));
    assert_eq!(resting[1].len(), 4);
    assert_eq!(resting, told(&turning("4.1")));
}

/// A coordinate that a computed equilibrium leaves 0 is 0 on the page.
#[test]
fn computed_equilibria_keep_what_is_zero() {
    let elastic = "param m = 1, k = 40, L = 1, g = 9.81  coord r, th
        T = 1/2*m*(r'^2 + r^2*th'^2)  V = 1/2*k*(r - L)^2 - m*g*r*cos(th)  guess r = 1";
    assert_eq!(told(elastic)[0], ["1: k*g/(m*g + k*L)", "1: k/m"]);
}

/// Without values nothing is searched for: the coordinates stay as they are where linear equations do not determine them.
#[test]
fn equilibria_may_be_left_open() {
    let elastic = "param m, k, L, g  coord r, th
        T = 1/2*m*(r'^2 + r^2*th'^2)  V = 1/2*k*(r - L)^2 - m*g*r*cos(th)  guess r = 1";
    assert_eq!(told(elastic)[0], ["1: k*g/(m*g + k*L)", "1: k/m"]);
    let hanging = "param m, k, g  coord x, y  T = 1/2*m*(x'^2 + y'^2)  V = 1/2*k*x^2 + 1/2*k*(y - x)^2 - m*g*(x + y)";
    let resting = "param m, k  coord x, y  T = 1/2*m*(x'^2 + y'^2)  V = 1/2*k*x^2 + 1/2*k*(y - x)^2";
    assert_eq!(told(hanging), told(resting));
    let text = derive_text(&page(&common::model(hanging)), &Style::default());
    assert!(text.contains("x = ─────") && text.contains("3 m g"), "{text}");
    let well = "param m, a, b  coord x  T = 1/2*m*x'^2  V = a/x^2 + b*x^2  guess x = 1";
    assert_eq!(told(well)[0], ["1: 6*a/(m*x^4) + 2*b/m"]);
    let text = derive_text(&page(&common::model(well)), &Style::default());
    assert!(text.contains("equilibrium left open, as parameters have no values"), "{text}");
}

/// A guess at which the forces vanish whatever the parameters are is the equilibrium: a bead on a hoop that turns fast (Taylor, Classical
/// Mechanics, section 7.6).
#[test]
fn guesses_may_be_equilibria_in_symbols() {
    let hoop = |values: &str| {
        told(&format!(
            "{values}  coord th  T = 1/2*m*R^2*(th'^2 + W^2*sin(th)^2)  V = -m*g*R*cos(th)
            guess th = acos(g/(R*W^2))"
        ))
    };
    for values in ["param m, R, g, W", "param m = 1, R = 0.2, g = 9.81, W = 10"] {
        assert_eq!(hoop(values)[0], ["1: W^2 - g^2/(R^2*W^2)"]);
    }
}

/// Nothing is left open where a force acts whatever the coordinates are, and no coordinate is 0 where others or constraints forbid it.
#[test]
fn open_equilibria_are_some() {
    let of = |text: &str| page(&common::model(text));
    let given = of("param m, k, a, b  coord x, y  T = 1/2*m*(x'^2 + y'^2)
        V = 1/2*k*(x - b)^2 + 1/2*k*(y - a)^2  equilibrium x = a");
    let refused = given.linear.as_ref().err().map(LinearizeError::code);
    assert_eq!(refused, Some("E0321"));
    let falls = of("param m, g  coord x, y  T = 1/2*m*(x'^2 + y'^2)  V = m*g*y");
    assert_eq!(falls.linear.as_ref().err().map(LinearizeError::code), Some("E0301"));
    for open in [
        "param m, k, a  coord x, y  T = 1/2*m*(x'^2 + y'^2)  V = k*y*(x^2 - a^2)",
        "param m, k, h, l  coord x, y  T = 1/2*m*(x'^2 + y'^2)  V = 1/2*k*x^2 + 1/2*h*y^2  constraint x^2 + y^2 = l^2",
    ] {
        let page = of(open);
        let whole = page.linear.as_ref().unwrap();
        assert!(
            whole.open && whole.equilibrium.iter().take(2).all(|own| page.pool.as_symbol(*own).is_some()),
            "{open}"
        );
    }
    // A power may be negative.
    let [_, _, conditions] = told("param m, k, a, n  coord x  T = 1/2*m*x'^2  V = 1/2*k*a^n*x^2");
    assert_eq!(conditions, ["k*a^n"]);
}

/// The inertia of a frame that accelerates is a potential.
#[test]
fn pendulums_in_an_accelerating_car_are_conservative() {
    let page = page(&common::model(
        "param g = 9.81, l = 0.8, a = 3  coord th[1..2]  let r[i in 1..2] = [l*sin(th[i]) + a*t^2/2, -l*cos(th[i])]
         T = sum(i in 1..2, 1/2*dot(r[i]', r[i]'))  V = sum(i in 1..2, g*r[i][2])  guess th = -0.3",
    ));
    let whole = page.linear.as_ref().unwrap();
    assert!(whole.is_conservative());
    assert_eq!(page.pool.display(whole.stiffness[1][1]), "g*l*cos(th[2]) - l*a*sin(th[2])");
}

/// The fourth Lagrange point in space: s⁴ + s² + 27/4 mu (1 - mu) and s² + 1, with lengths that are 1 (Szebehely, Theory of Orbits,
/// section 5.4).
#[test]
fn long_polynomials_are_written_as_they_stand() {
    let text = "param mu = 0.01  coord x, y, z
        let r1 = sqrt((x + mu)^2 + y^2 + z^2)  let r2 = sqrt((x - 1 + mu)^2 + y^2 + z^2)
        lagrangian = 1/2*((x' - y)^2 + (y' + x)^2 + z'^2) + (1 - mu)/r1 + mu/r2
        guess x = 0.5  guess y = 0.866";
    let page = page(&common::model(text));
    let own = linear(&page).unwrap().exponents.as_ref().unwrap();
    let polynomial = own.characteristic.as_ref().unwrap();
    let conditions: Vec<ExprId> = own.stability.iter().flatten().map(|own| own.positive).collect();
    let all: Vec<ExprId> = polynomial.iter().chain(&conditions).copied().collect();
    let symbols: Vec<Symbol> = page.pool.symbols_of(&all);
    let tape = Tape::compile(&page.pool, &all, &symbols).unwrap();
    for mu in [0.01, 0.03, 0.04, 0.2] {
        let inputs = symbols.iter().map(|symbol| match &*page.pool.symbol_name(*symbol) {
            "mu" => mu,
            "x" => 0.5 - mu,
            "y" => 0.75_f64.sqrt(),
            other => panic!("{other} is 0 at the equilibrium"),
        });
        let values = tape.evaluate(&inputs.collect::<Vec<f64>>(), &mut Vec::new());
        let (found, conditions) = values.split_at(polynomial.len());
        let c = 27.0 / 4.0 * mu * (1.0 - mu);
        for (found_one, want) in found.iter().zip([c, 0.0, 1.0 + c, 0.0, 2.0, 0.0, 1.0]) {
            assert!((found_one / found[6] - want).abs() < 1e-12, "{mu}: {found:?}");
        }
        assert_eq!(conditions.iter().all(|own| *own > 0.0), 4.0 * c < 1.0, "{mu}: {conditions:?}");
    }
}

#[test]
fn conditions_that_always_hold_are_left_out() {
    let open = |text: &str| {
        let page = page(&common::model(text));
        let own = linear(&page).unwrap().exponents.as_ref().unwrap().stability.as_ref().unwrap();
        own.iter().filter_map(|own| Some(page.reduced().pool.display(own.open?))).collect::<Vec<_>>()
    };
    // (kx - ky)² and what is positive beside it.
    let trap = "param m = 1, kx = 2, ky = 3, B = 0.7  coord x, y
        lagrangian = 1/2*m*(x'^2 + y'^2) - 1/2*kx*x^2 - 1/2*ky*y^2 + B*x*y'";
    assert!(open(trap).is_empty());
    // k > 0 follows from k d² > m n².
    let turned = "param k, d, m, n  coord x, y  assume m > 0
        lagrangian = 1/2*m*(x'^2 + y'^2) - 1/2*(k*d^2 - m*n^2)*x^2 - 1/2*k*y^2";
    assert_eq!(open(turned), ["k*d^2 - m*n^2"]);
    // 9π - 16, √2 - 1, the power r^n, a definite form in numbers of any sign, and squares beside |cos| <= 1.
    let plain =
        |k: &str| format!("param r = 2, n = 3, a = -1, b = 2, w = 1/2  coord x  T = 1/2*x'^2  V = 1/2*({k})*x^2");
    for k in [
        "9*pi - 16",
        "(sqrt(2) - 1)*r^n",
        "r^(1 + n)",
        "a^2 - a*b + b^2",
        "3 - 4*a + 2*a^2",
        "a^2 - 2*a*b*cos(w) + b^2",
        "2 + cos(a)",
    ] {
        assert!(open(&plain(k)).is_empty(), "{k}");
    }
    for (k, left) in
        [("2*r^n - n*r^n", "2 - n"), ("a^2 - 3*a*b + b^2", "a^2 - 3*a*b + b^2"), ("1 - 2*cos(a)", "1 - 2*cos(a)")]
    {
        assert_eq!(open(&plain(k)), [left]);
    }
    // The same pair of exponents twice, with vectors enough.
    let charges = "param m = 1, B = 1, k = 2, K = 1  coord x1, y1, x2, y2
        lagrangian = 1/2*m*(x1'^2 + y1'^2 + x2'^2 + y2'^2) + 1/2*B*(x1*y1' - y1*x1' - x2*y2' + y2*x2')
            - 1/2*k*(x1^2 + y1^2 + x2^2 + y2^2) - 1/2*K*((x1 - x2)^2 + (y1 - y2)^2)";
    assert!(open(charges).is_empty());
    let inverted = page(&common::model("param a, b  coord x  T = 1/2*x'^2  V = -1/2*(a + b)*x^2"));
    let text = derive_text(&inverted, &Style::default());
    assert!(text.contains("a + b < 0"), "{text}");
}
