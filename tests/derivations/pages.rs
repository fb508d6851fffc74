//! Pages of all models in all forms: text that holds its width, and HTML that is XML with the elements of MathML Core. That Typst
//! compiles is held by the tests of the Python package, which has a compiler at hand.
#![cfg(feature = "cli")]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests stop at the first surprise")]

use crate::common;

use std::path::Path;

use common::{load, model_files};
use librate::derive::{Derivation, Parts, derive};
use librate::model::{Settings, TableTexts, elaborate};
use librate::report::{Style, derive_html, derive_text, derive_typst};
use roxmltree::Document;
use unicode_width::UnicodeWidthStr;

/// Pages of larger models say nothing new.
const MOST: usize = 24;

fn derivations() -> impl Iterator<Item = (String, Derivation)> {
    model_files().into_iter().filter_map(|path| {
        let model = load(&path);
        let small = model.coordinates.len() <= MOST;
        let mut derivation = small.then(|| derive(&model, &Parts::all().numbers(true)).ok()).flatten()?;
        let file = librate::syntax::parse(&std::fs::read_to_string(&path).unwrap()).unwrap();
        derivation.put_given(&file, &Settings::new(), &model);
        Some((path.display().to_string(), derivation))
    })
}

/// The elements of <https://www.w3.org/TR/mathml-core/> that hold formulas, and those of HTML around them.
const ELEMENTS: [&str; 26] = [
    "math",
    "mfrac",
    "mi",
    "mn",
    "mo",
    "mover",
    "mroot",
    "mrow",
    "msqrt",
    "msub",
    "msubsup",
    "msup",
    "mtable",
    "mtd",
    "mspace",
    "mtext",
    "mtr",
    "munder",
    "munderover",
    "article",
    "style",
    "h2",
    "h3",
    "p",
    "div",
    "span",
];

/// How many elements are in each; none where that is any number.
fn children(name: &str) -> Option<usize> {
    match name {
        "mfrac" | "mover" | "msub" | "msup" | "munder" => Some(2),
        "msubsup" | "munderover" => Some(3),
        "mi" | "mn" | "mo" | "mtext" => Some(0),
        _ => None,
    }
}

#[test]
fn every_page_holds_its_width_and_is_markup() {
    for (name, derivation) in derivations() {
        for width in [80, 100] {
            let text = derive_text(&derivation, &Style::default().width(width));
            let wide = text.lines().filter(|line| line.width() > width);
            assert_eq!(wide.collect::<Vec<_>>(), Vec::<&str>::new(), "{name}");
        }
        let html = derive_html(&derivation);
        let document = Document::parse(&html).unwrap_or_else(|error| panic!("{name}: {error}"));
        for node in document.descendants().filter(|node| node.is_element()) {
            let tag = node.tag_name().name();
            assert!(ELEMENTS.contains(&tag), "{name}: {tag}");
            let count = node.children().filter(|child| child.is_element()).count();
            assert!(children(tag).is_none_or(|wanted| wanted == count), "{name}: {count} in {tag}");
        }
        assert!(!html.contains('`') && html.contains("<math"), "{name}");
    }
}

#[test]
fn html_and_typst_have_what_the_page_has() {
    for name in ["simple_pendulum", "spring_pendulum", "three_pendulums"] {
        let model = load(&Path::new("models").join(format!("{name}.lag")));
        let derivation = derive(&model, &Parts::all().numbers(true)).unwrap();
        insta::assert_snapshot!(format!("html__{name}"), derive_html(&derivation));
        insta::assert_snapshot!(format!("typst__{name}"), derive_typst(&derivation));
    }
}

/// The page begins with what the file says and ends with numbers.
/// What a page calls by a letter has another one where the model has this letter.
#[test]
fn letters_of_a_page_are_none_of_the_model() {
    let page = |model: &str, lines: &[&str]| {
        let file = librate::syntax::parse(model).unwrap();
        let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
        let mut derivation = derive(&model, &Parts::all().numbers(true)).unwrap();
        derivation.put_given(&file, &Settings::new(), &model);
        let text = derive_text(&derivation, &Style::default());
        for line in lines {
            assert!(text.lines().any(|own| own.trim().starts_with(line)), "{line}:\n{text}");
        }
    };
    page(
        "param g = 9.81, R = 1/5, omega = 3  coord th  T = 1/2*R^2*(th'^2 + omega^2*sin(th)^2)  V = -g*R*cos(th)",
        &["Ω² = ─ - ω²", "Ω at these values: 6.328506933"],
    );
    page(
        "param m = 1, g = 1, h = 1, W = 1, H = 1  coord x  T = 1/2*m*(x'^2 + W^2*x^2)  V = H*m*g*x^2/h",
        &["E: the time does not occur in L; E is not T + V", "momenta"],
    );
    page(
        "param L = 1, M = 1/2, F = 1/10  coord a, b  lagrangian = 1/2*L*(a'^2 + b'^2) + M*a'*b' - 1/2*(a^2 + b^2)
         dissipation = 1/2*F*a'^2",
        &["ℒ = ½ L (", "ℱ = ½ F ", "p_a = L "],
    );
    page(
        "param s = 1, lambda = 2, sigma = 1/10  coord x  T = 1/2*s*x'^2  V = 1/2*lambda*x^2  dissipation = 1/2*sigma*x'^2",
        &["s s₀² + σ s₀ + λ = 0"],
    );
    page(
        "param B = 1, k = 2  coord x, y  lagrangian = 1/2*(x'^2 + y'^2) + B*x*y' - 1/2*k*(x^2 + y^2)",
        &["T₂ and V to second order", "T₂ = ½ ("],
    );
}

#[test]
fn what_is_given_stands_first() {
    let text = "param N = 2  param g : m/s^2 = 9.81  param l[1..2] : cm = [50, 1e2]  param m[i in 1..N] : kg = 2
        param W = sqrt(g/l[1])  param A[1..2, 1..2] = [[1, 2], [3, 4]]
        coord x[1..N] : m, phi : rad
        let s[k in 1..N] = x[k]^2
        T = sum(i in 1..N, 1/2*m[i]*x[i]'^2) + 1/2*m[1]*l[2]^2*phi'^2
        V = 1/2*W^2*m[1]*sum(i in 1..N, s[i]) + m[1]*g*l[2]*(1 - cos(phi))
        param c : N*m*s/rad = 1/10
        dissipation = 1/2*c*phi'^2";
    let file = librate::syntax::parse(text).unwrap();
    let mut settings = Settings::new();
    settings.add("m[2]=3").unwrap();
    let model = librate::model::elaborate(&file, &librate::model::TableTexts::new(), &settings).unwrap();
    let mut derivation = derive(&model, &Parts::all().numbers(true)).unwrap();
    derivation.put_given(&file, &settings, &model);
    insta::assert_snapshot!("given_text", derive_text(&derivation, &Style::default()));
    derivation.only = Some(vec!["model".to_owned()]);
    insta::assert_snapshot!("given_ascii", derive_text(&derivation, &Style::default().ascii(true)));
    insta::assert_snapshot!("given_typst", derive_typst(&derivation));
}

/// All the lines that one with indices stands for.
fn spelled_out(line: &str) -> Vec<String> {
    let (text, ranges) = line.split_once(", for ").unwrap_or((line, ""));
    let mut all = vec![text.to_owned()];
    for range in ranges.split(", ").filter(|range| !range.is_empty()) {
        let (index, range) = range.split_once(" in ").unwrap();
        let (first, last) = range.split_once("..").unwrap();
        let values = first.parse::<i64>().unwrap()..=last.parse().unwrap();
        let with = |text: &str, value: i64| {
            let part = |part: &str| {
                let own = part.trim_end_matches([',', ']']);
                let more = own.trim_start().strip_prefix(index).filter(|_| own.len() < part.len());
                let more = more.and_then(|more| if more.is_empty() { Some(0) } else { more.parse::<i64>().ok() });
                more.map_or_else(
                    || part.to_owned(),
                    |more| {
                        let space = &own[..own.len() - own.trim_start().len()];
                        format!("{space}{}{}", value + more, &part[own.len()..])
                    },
                )
            };
            text.split_inclusive(['[', ',', ']']).map(part).collect::<String>()
        };
        all = all.iter().flat_map(|text| values.clone().map(|value| with(text, value)).collect::<Vec<_>>()).collect();
    }
    all
}

/// Equations that differ by their indices are one line, and nothing is lost by that: chains, rings, lattices, bodies.
#[test]
fn lines_with_indices_stand_for_all() {
    let mut gathered = 0;
    let lattice = "param n = 6  param i = 2  coord x[1..5, 1..n], y[1..3]
        T = 1/2*sum(a in 1..5, b in 1..n, x[a,b]'^2) + 1/2*sum(a in 1..3, y[a]'^2)
        V = sum(a in 1..4, b in 1..n, i/2*(x[a+1,b] - x[a,b])^2) + sum(a in 1..5, b in 1..n-1, i*(x[a,b+1] - x[a,b])^4)
          + 1/2*dot([x[1,1], x[2,2]], [x[3,3], x[4,4]]) + 1/2*sum(a in 1..3, y[a]^2)";
    let own = common::model(lattice);
    let models = model_files().into_iter().map(|path| (path.display().to_string(), load(&path)));
    let models = models.filter(|(_, model)| model.coordinates.len() <= MOST);
    for (name, model) in models.chain([("lattice".to_owned(), own.clone())]) {
        let Ok(mut derivation) = derive(&model, &Parts::default().equations(true)) else { continue };
        if derivation.equations.is_none() || derivation.abbreviated().is_some() {
            continue;
        }
        derivation.only = Some(vec!["equations".to_owned()]);
        let page = derive_text(&derivation, &Style::default().ascii(true));
        let lines = page.lines().skip_while(|line| !line.starts_with("Lagrange")).skip(1);
        let lines: Vec<&str> = lines.take_while(|line| line.starts_with("  ")).map(str::trim).collect();
        let mut all: Vec<String> = lines.iter().flat_map(|line| spelled_out(line)).collect();
        gathered += usize::from(lines.len() < all.len());
        let mut expected = derivation.equation_texts();
        all.sort();
        expected.sort();
        assert_eq!(all, expected, "{name}");
    }
    assert!(gathered > 5, "{gathered}");
    let mut own = derive(&own, &Parts::default()).unwrap();
    own.only = Some(vec!["mass".to_owned(), "stiffness".to_owned()]);
    insta::assert_snapshot!("matrices_with_indices", derive_text(&own, &Style::default()));
}
