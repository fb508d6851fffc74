//! The chapter on testing derivations (docs/snapshot-testing.md): its code, and that the chapter shows this code.
#![cfg(feature = "engine")]

use librate::derive::{Derivation, Parts, derive};
use librate::expr::ExprId;
use librate::{assert_derives, model, syntax};

fn derivation() -> Derivation {
    let text = std::fs::read_to_string("models/pendulum_on_spring_cart.lag").unwrap();
    let file = syntax::parse(&text).unwrap();
    let model = model::elaborate(&file, &Default::default(), &Default::default()).unwrap();
    derive(&model, &Parts::all()).unwrap()
}

#[test]
fn the_equations_are_those_of_the_lecture() {
    assert_derives!(
        &derivation(),
        equations = [
            "(m1 + m2)*x'' + m2*l*(phi''*cos(phi) - phi'^2*sin(phi)) + k*x = 0",
            "l*phi'' + x''*cos(phi) + g*sin(phi) = 0",
        ],
        mass = "[[m1 + m2, m2*l], [m2*l, m2*l^2]]",
        stiffness = "[[k, 0], [0, m2*g*l]]",
        momenta = ["(m1 + m2)*x' + m2*l*cos(phi)*phi'", "m2*l*(l*phi' + cos(phi)*x')"],
        characteristic = ["k*g", "0", "(m1 + m2)*g + k*l", "0", "m1*l"],
    );
}

#[test]
fn equations_as_they_were() {
    insta::assert_snapshot!(derivation().equation_texts().join("\n"), @r"
    (m1 + m2)*x'' + l*m2*phi''*cos(phi) - l*m2*phi'^2*sin(phi) + k*x = 0
    l*m2*x''*cos(phi) + l^2*m2*phi'' + g*l*m2*sin(phi) = 0
    ");
}

#[test]
fn matrices_as_they_were() {
    let derivation = derivation();
    let linear = derivation.linear.as_ref().unwrap();
    let written = |rows: &[Vec<ExprId>]| {
        let rows = rows.iter().map(|row| {
            let entries = row.iter().map(|entry| derivation.pool.display(*entry));
            entries.collect::<Vec<_>>().join(", ")
        });
        rows.collect::<Vec<_>>().join("\n")
    };
    insta::assert_snapshot!(written(&linear.mass), @r"
    m1 + m2, l*m2
    l*m2, l^2*m2
    ");
    insta::assert_snapshot!(written(&linear.stiffness), @r"
    k, 0
    0, g*l*m2
    ");
}

#[test]
fn energies_as_they_were() {
    let derivation = derivation();
    let energy = derivation.energy.as_ref().unwrap();
    insta::assert_snapshot!(derivation.text(&energy.momenta[1]), @"l*m2*x'*cos(phi) + l^2*m2*phi'");
    insta::assert_snapshot!(derivation.text(&energy.function), @"1/2*(m1 + m2)*x'^2 + 1/2*l^2*m2*phi'^2 + l*m2*x'*phi'*cos(phi) + 1/2*k*x^2 - g*l*m2*cos(phi)");
}

#[test]
fn the_squares_of_the_frequencies_solve_the_quadratic() {
    let derivation = derivation();
    let middle = "k*l + g*(m1 + m2)";
    let root = format!("sqrt(({middle})^2 - 4*k*g*m1*l)");
    assert_derives!(
        &derivation,
        frequencies = [format!("({middle} - {root})/(2*m1*l)"), format!("({middle} + {root})/(2*m1*l)"),],
    );
}

/// Every block of the chapter is a part of this file, the model that of its file, and the message what is printed.
#[test]
fn the_chapter_shows_this_code() {
    let chapter = std::fs::read_to_string("docs/snapshot-testing.md").unwrap();
    let own = std::fs::read_to_string("tests/derivations/derivation_of_a_cart.rs").unwrap();
    let blocks = |language: &str| -> Vec<String> {
        let fence = format!("```{language}\n");
        let parts = chapter.split(&fence).skip(1);
        parts.map(|rest| rest.split("```").next().unwrap().to_owned()).collect()
    };
    let code = blocks("rust");
    assert!(code.len() >= 4);
    for block in code {
        assert!(own.contains(&block), "not in this file:\n{block}");
    }
    let file = std::fs::read_to_string("models/pendulum_on_spring_cart.lag").unwrap();
    let [lag] = blocks("lag").try_into().unwrap();
    assert!(file.ends_with(&lag), "{lag}");
    let wrong = librate::expect::Expected::new().stiffness("[[k + m2*g/l, 0], [0, m2*g*l]]");
    let [text] = blocks("text").try_into().unwrap();
    assert_eq!(wrong.compare(&derivation()).unwrap_err().to_string(), text);
}
