//! What `derive` prints beside the same as a book has it (tests/reference/book_forms.txt): equal, and not longer by
//! more than a tenth; and formulas as a physicist would leave them.
#![cfg(feature = "engine")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests stop at the first surprise"
)]

use std::collections::BTreeMap;

use crate::common;

use common::{load, model};
use librate::derive::{Derivation, Parts, derive};
use librate::expect::Expected;
use librate::expr::{ExprId, ZeroVerdict};
use librate::number::Number;
use librate::report::{Style, derive_json, derive_text};
use librate_core::derive::greater_and_less;
use serde_json::Value;

/// A printed form may have a tenth more tokens than the book's.
const MOST: f64 = 1.1;

/// Names with their indices, numbers, and signs one by one, without ` = 0`: a book may have terms on both sides.
fn tokens(text: &str) -> usize {
    let mut count = 0;
    let mut rest = text.trim_end_matches(" = 0").trim_start();
    while let Some(first) = rest.chars().next() {
        let word = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        let mut end = first.len_utf8();
        if word(first) {
            end = rest.find(|c: char| !word(c)).unwrap_or(rest.len());
            if first.is_alphabetic() && rest[end..].starts_with('[') {
                end += rest[end..].find(']').unwrap() + 1;
            }
        }
        count += 1;
        rest = rest[end..].trim_start();
    }
    count
}

#[test]
fn tokens_are_counted_as_a_reader_counts_them() {
    assert_eq!(tokens("m[1]*l[1]^2"), 5);
    assert_eq!(tokens("-1/2*(r[1,2] - 0.5)"), 10);
    assert_eq!(tokens("[[a, 0], [0, b1]]"), 13);
}

/// Adds what a book has to what is expected.
type Expect = fn(Expected, &[&str]) -> Expected;

/// What a line begins with, the field of the JSON with the same, and where it is expected.
const LINES: [(&str, &str, Expect); 10] = [
    ("M = ", "mass", |own, all| own.mass(all[0])),
    ("K = ", "stiffness", |own, all| own.stiffness(all[0])),
    ("G = ", "gyroscopic", |own, all| own.gyroscopic(all[0])),
    ("C = ", "damping", |own, all| own.damping(all[0])),
    ("E: ", "equations", |own, all| own.equations(all)),
    ("small: ", "linearized_equations", |own, all| own.linearized(all)),
    ("q0 = ", "equilibrium", |own, all| own.equilibrium(all)),
    ("h = ", "energy_function", |own, all| own.energy_function(all[0])),
    ("H = ", "hamiltonian", |own, all| own.hamiltonian(all[0])),
    ("omega^2 = ", "frequencies", |own, all| own.frequencies(all)),
];

/// The forms in one field of the JSON, each as text; those of the frequencies by length, since they have no order.
fn printed(json: &Value, field: &str) -> Vec<String> {
    let text = |value: &Value| value.to_string().replace('"', "");
    let mut all: Vec<String> = match (&json[field], field) {
        (Value::Array(all), "frequencies") => all.iter().map(|own| text(&own["omega_squared"])).collect(),
        (Value::Array(all), "equations" | "linearized_equations" | "equilibrium") => all.iter().map(text).collect(),
        (own, _) => vec![text(own)],
    };
    if field == "frequencies" {
        all.sort_by_key(|text| tokens(text));
    }
    all
}

#[test]
fn pages_are_the_books_and_as_short() {
    let file = std::fs::read_to_string("tests/reference/book_forms.txt").unwrap();
    let mut wrong = Vec::new();
    let (mut ours, mut books, mut pages, mut checked) = (0, 0, 0, BTreeMap::new());
    for entry in file.split("\n\n").skip(1) {
        let mut lines = entry.lines().filter(|line| !line.starts_with('#'));
        let name = lines.next().unwrap();
        let (forms, text): (Vec<&str>, Vec<&str>) =
            lines.partition(|line| LINES.iter().any(|(start, ..)| line.starts_with(start)));
        let model = if text.is_empty() { load(format!("models/{name}.lag").as_ref()) } else { model(&text.join("\n")) };
        let only_matrices = forms.iter().all(|line| line.starts_with("M = ") || line.starts_with("K = "));
        let derivation = derive(&model, &if only_matrices { Parts::default() } else { Parts::all() }).unwrap();
        let json: Value = serde_json::from_str(&derive_json(&derivation)).unwrap();
        pages += 1;
        for (start, field, expect) in LINES {
            let mut book: Vec<&str> = forms.iter().filter_map(|line| line.strip_prefix(start)).collect();
            if book.is_empty() {
                continue;
            }
            if let Err(mismatches) = expect(Expected::new(), &book).compare(&derivation) {
                wrong.push(format!("{name}: {mismatches}"));
                continue;
            }
            if field == "frequencies" {
                book.dedup();
                book.sort_by_key(|text| tokens(text));
            }
            for (own, book) in printed(&json, field).iter().zip(&book) {
                let counts = [tokens(own), tokens(book)];
                ours += counts[0];
                books += counts[1];
                *checked.entry(field).or_insert(0) += 1;
                if counts[0] as f64 > MOST * counts[1] as f64 {
                    wrong.push(format!("{name}, {field}: {counts:?}\n  {own}\n  {book}"));
                }
            }
        }
    }
    println!("{ours} tokens on {pages} pages, in the books {books}: {checked:?}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let closed = ["equilibrium", "energy_function", "hamiltonian", "frequencies"];
    let [closed, equations] = [&closed[..], &["equations", "linearized_equations"]]
        .map(|fields| fields.iter().filter_map(|field| checked.get(field)).sum::<usize>());
    assert!(pages >= 150 && equations >= 100 && closed >= 60, "{pages} pages, {checked:?}");
}

/// The page of a model without values, in the model language.
fn lines(text: &str) -> Vec<String> {
    let mut style = Style::default();
    style.ascii = true;
    let derivation = derive(&model(text), &Parts::all()).unwrap();
    derive_text(&derivation, &style).lines().map(|line| line.trim().to_owned()).collect()
}

#[track_caller]
fn has(page: &[String], expected: &[&str]) {
    for line in expected {
        assert!(page.iter().any(|own| own == line), "{line}\n\n{}", page.join("\n"));
    }
}

#[test]
fn a_relativistic_mass_is_the_third_power_of_gamma() {
    let page = lines(
        "param m, c, k coord x assume m > 0, c > 0, k > 0
         lagrangian = -m*c^2*sqrt(1 - x'^2/c^2) - 1/2*k*x^2",
    );
    has(&page, &["gamma = 1/sqrt(1 - x'^2/c^2)", "m*gamma^3*x'' + k*x = 0", "h = 1/2*k*x^2 + m*c^2*gamma"]);
    // In a plane.
    let page = lines(
        "param m, c, q, B coord x, y let v = [x', y'] assume m > 0, c > 0
         lagrangian = -m*c^2*sqrt(1 - dot(v, v)/c^2) + q*B*(x*y' - y*x')/2",
    );
    has(&page, &["h = m*c^2*gamma"]);
    // Where the letter is taken, all is as it is written.
    let page = lines(
        "param gamma, c, k coord x assume gamma > 0, c > 0, k > 0
         lagrangian = -gamma*c^2*sqrt(1 - x'^2/c^2) - 1/2*k*x^2",
    );
    has(&page, &["gamma/(1 - x'^2/c^2)^(3/2)*x'' + k*x = 0"]);
}

/// Squares are completed and products found where that is shorter, and the sides differ by what has to be positive.
#[test]
fn conditions_have_their_shortest_form() {
    let all = [
        ("1 - 27*x + 27*x^2", "1 > 27*x*(1 - x)"),
        ("16*x^4 - 8*x^2*(y + z) + (y - z)^2", "(4*x^2 - y - z)^2 > 4*y*z"),
        ("x*y^2 + 2*x*y*z + x*z^2 - u*v^2", "x*(y + z)^2 > u*v^2"),
        ("x*y - u*v^2*x - u*v^2*y + u^2*v^4", "(u*v^2 - x)*(u*v^2 - y) > 0"),
        ("x - y", "x > y"),
    ];
    for (text, expected) in all {
        let text = format!("param x, y, z, u, v coord q T = 1/2*q'^2 V = 1/2*({text})*q^2");
        let derivation = derive(&model(&text), &Parts::default()).unwrap();
        let positive = derivation.linear.as_ref().unwrap().stiffness[0][0];
        let mut pool = derivation.pool;
        let [greater, less] = greater_and_less(&mut pool, positive).unwrap();
        assert_eq!(format!("{} > {}", pool.display(greater), pool.display(less)), expected);
        let difference = pool.sub(greater, less);
        let rest = pool.sub(difference, positive);
        assert_eq!(pool.is_zero(rest), ZeroVerdict::Zero, "{text}");
    }
}

/// That a is not 0 follows from the first one.
#[test]
fn what_may_not_vanish_is_told_without_what_other_conditions_say() {
    let page = lines(
        "param M, a, n coord x, y, z assume M > 0
         T = 1/2*(x'^2 + M*y'^2 + z'^2) V = 1/2*(x^2 + a*y^2 + a*z^2) force z = n*y",
    );
    has(&page, &["a > 0", "M != 1"]);
}

#[test]
fn powers_of_one_base_are_put_together() {
    let page = lines(
        "param m, k, n, r0 coord r, phi assume r0 > 0, m > 0, k > 0, n > 0
         T = 1/2*m*(r'^2 + r^2*phi'^2) V = k*r^n/n
         equilibrium r = r0 equilibrium phi' = sqrt(k*r0^(n - 2)/m)",
    );
    has(&page, &["m*r'' - m*r*phi'^2 + k*r^(n - 1) = 0", "k*r0^(n - 2)*(n - 2)  0"]);
}

#[test]
fn hamiltonians_have_squares_of_sums_of_momenta() {
    let top = lines(
        "param A, C, m, g, l coord theta, phi, psi
         T = 1/2*A*(theta'^2 + sin(theta)^2*phi'^2) + 1/2*C*(psi' + cos(theta)*phi')^2
         V = m*g*l*cos(theta)
         equilibrium theta = pi/3",
    );
    let energy =
        "H = (p_phi - p_psi*cos(theta))^2/(2*A*sin(theta)^2) + p_theta^2/(2*A) + p_psi^2/(2*C) + m*g*l*cos(theta)";
    has(&top, &[energy]);
    let charge = lines(
        "param m, q, B, k coord x, y
         lagrangian = 1/2*m*(x'^2 + y'^2) + 1/2*q*B*(x*y' - y*x') - 1/2*k*(x^2 + y^2)",
    );
    has(&charge, &["H = (p_x + 1/2*q*B*y)^2/(2*m) + (p_y - 1/2*q*B*x)^2/(2*m) + 1/2*k*(x^2 + y^2)"]);
}

#[test]
fn sums_are_collected_and_angles_doubled() {
    let page = lines(
        "param m1, m2, k, al coord x
         T = 1/2*m1*x'^2 + 1/2*m2*x'^2
         V = 1/2*k*(sin(al)^2 + 2*sin(al/2)^4 + 2*cos(al/2)^4)*x^2",
    );
    has(&page, &["h = 1/2*(m1 + m2)*x'^2 + k*x^2", "omega^2 = 2*k/(m1 + m2)"]);
}

#[test]
fn a_double_pendulum_has_one_bar_and_its_limit_no_root() {
    let text = "param g, l1, l2, m1, m2 coord a, b assume g > 0, l1 > 0, l2 > 0, m1 > 0, m2 > 0
         T = 1/2*m1*l1^2*a'^2 + 1/2*m2*(l1^2*a'^2 + l2^2*b'^2 + 2*l1*l2*a'*b'*cos(a - b))
         V = -(m1 + m2)*g*l1*cos(a) - m2*g*l2*cos(b)";
    let root = "sqrt((m1 + m2)^2*(l1 + l2)^2 - 4*l1*l2*m1*(m1 + m2))";
    let forms = ["-", "+"].map(|sign| format!("omega^2 = 1/2*g*((m1 + m2)*(l1 + l2) {sign} {root})/(l1*l2*m1)"));
    has(&lines(text), &forms.each_ref().map(String::as_str));
    let mut derivation = derive(&model(text), &Parts::default().frequencies(true)).unwrap();
    derivation.limit("m2", &Number::ZERO);
    let linear = derivation.linear.as_ref().unwrap();
    let case = linear.frequencies.as_ref().unwrap().best();
    let mut all: Vec<String> = case.frequencies.iter().map(|own| derivation.pool.display(own.omega_squared)).collect();
    all.sort();
    assert_eq!(all, ["g/l1", "g/l2"]);
}

/// In `--limit m2=0` equal masses would both go to 0: where all is known without that it is not said.
#[test]
fn a_limit_separates_what_was_equal() {
    let text = std::fs::read_to_string("models/double_pendulum.lag").unwrap();
    let mut derivation = derive(&model(&text), &Parts::default().frequencies(true)).unwrap();
    let frequencies = |derivation: &Derivation| derivation.linear.as_ref().unwrap().frequencies.clone().unwrap();
    assert!(frequencies(&derivation).tied.is_some());
    derivation.limit("m[2]", &Number::ZERO);
    assert!(frequencies(&derivation).tied.is_none());
    // Without the upper mass it is one pendulum of both lengths: the other frequency grows without end.
    let mut derivation = derive(&model(&text), &Parts::default().frequencies(true)).unwrap();
    derivation.limit("m[1]", &Number::ZERO);
    let left = frequencies(&derivation).general.frequencies;
    let left: Vec<String> = left.iter().map(|own| derivation.pool.display(own.omega_squared)).collect();
    assert_eq!(left, ["g/(l[1] + l[2])"]);
}

/// Water has its polynomial, and its classes are those of C2v.
#[test]
fn water_has_its_characteristic_polynomial_and_its_classes() {
    let text = std::fs::read_to_string("models/water.lag").unwrap();
    let derivation = derive(&model(&text), &Parts::default().frequencies(true)).unwrap();
    let linear = derivation.linear.as_ref().unwrap();
    let found = linear.exponents.as_ref().unwrap().characteristic.as_ref().unwrap();
    assert_eq!(found.len(), 19);
    let zero = |own: &ExprId| derivation.pool.as_number(*own).is_some_and(Number::is_zero);
    assert!(found[..12].iter().all(zero) && !zero(&found[12]));
    let frequencies = linear.frequencies.as_ref().unwrap();
    assert_eq!(frequencies.point_group.as_deref(), Some("C2v"));
    let classes: Vec<&str> = frequencies.best().frequencies.iter().filter_map(|own| own.symmetry.as_deref()).collect();
    assert_eq!(classes, ["A1", "A1", "B2"]);
}

#[test]
fn what_a_positive_mass_implies_is_no_condition() {
    let page = lines(
        "param m1, m2, k coord x, y
         T = 1/2*m1*x'^2 + 1/2*m2*x'^2 + 1/2*m2*y'^2 V = 1/2*k*(x^2 + (y - x)^2)",
    );
    has(&page, &["k > 0"]);
}

#[test]
fn chains_have_their_characteristic_polynomial() {
    for n in [10, 24] {
        a_chain_has_its_characteristic_polynomial(n);
    }
}

fn a_chain_has_its_characteristic_polynomial(n: u64) {
    let derivation = derive(
        &model(&format!(
            "param m, k coord x[1..{n}]
             T = sum(i in 1..{n}, 1/2*m*x[i]'^2)
             V = sum(i in 2..{n}, 1/2*k*(x[i] - x[i-1])^2) + 1/2*k*x[1]^2 + 1/2*k*x[{n}]^2"
        )),
        &Parts::default().frequencies(true),
    )
    .unwrap();
    let linear = derivation.linear.as_ref().unwrap();
    let found = linear.exponents.as_ref().unwrap().characteristic.as_ref().unwrap();
    let found: Vec<String> = found.iter().map(|own| derivation.pool.display(*own)).collect();
    // Chebyshev's polynomial of the second kind: the sum of binomial(n + 1 + j, n - j) (m s^2)^j k^(n - j).
    let choose = |n: u64, k: u64| (0..k).fold(1, |product, at| product * (n - at) / (at + 1));
    let power = |name: &str, power: u64| match power {
        0 => String::new(),
        1 => name.to_owned(),
        _ => format!("{name}^{power}"),
    };
    for (at, own) in (0..).zip(&found) {
        let (j, odd) = (at / 2, at % 2);
        let number = match choose(n + 1 + j, n - j) {
            1 => String::new(),
            own => own.to_string(),
        };
        let factors = [number, power("m", j), power("k", n - j)];
        let factors: Vec<&str> = factors.iter().map(String::as_str).filter(|own| !own.is_empty()).collect();
        assert_eq!(*own, if odd == 1 { "0".to_owned() } else { factors.join("*") });
    }
    assert_eq!(found.len() as u64, 2 * n + 1);
}

/// Whoever asks for the polynomial of a conservative model gets it, and whether it is stable.
#[test]
fn chapters_that_are_asked_for_are_there() {
    let only = ["characteristic", "exponents", "stability"].map(str::to_owned);
    let model = model("param m, k coord x T = 1/2*m*x'^2 V = 1/2*k*x^2");
    let mut derivation = derive(&model, &Parts::of(&only)).unwrap();
    derivation.only = Some(only.to_vec());
    let page = derive_text(&derivation, &Style::default());
    for part in ["m s² + k = 0", ", and its conjugate", "k > 0"] {
        assert!(page.contains(part), "{part}\n\n{page}");
    }
}
