//! Frequencies near a bifurcation are said to be ill-conditioned; stiff beside soft is not.
#![cfg(feature = "engine")]

use crate::common;

use common::{load, model};
use librate::diagnostic::Diagnostic;
use librate::linearize::{LinearizeError, linearize};
use librate::model::{Model, Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate::syntax::parse;
use librate_core::linearize::Inertia;

fn ill_conditioned(model: Model) -> Option<Diagnostic> {
    // Some models are there for their mistake.
    let linearized = linearize(model).ok()?;
    let modes = normal_modes(&linearized, &Options::default()).unwrap();
    let mut all = modes.warnings(&linearized).into_iter();
    all.find(|warning| warning.code == Some("W0104"))
}

fn of_text(text: &str) -> Option<Diagnostic> {
    let file = parse(text).unwrap();
    ill_conditioned(elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap())
}

/// Read from `relative changes of 2e-10 in these terms may change it by 1 %`.
fn change(warning: Option<Diagnostic>) -> String {
    let label = warning.unwrap().primary.unwrap().text;
    let (change, _) = label.strip_prefix("relative changes of ").unwrap().split_once(" in ").unwrap();
    change.to_owned()
}

/// omega^2 = W^2 - (g/(W*R))^2 with W^2*R/g = (1 + e)^2, e = 1e-8: about 4*e*W^2, the difference of W^2 and g/R.
#[test]
fn the_terms_of_the_hoop_nearly_cancel() {
    let hoop = "param g = 10  param R = 0.1  param W = 10.0000001  coord th
        T = 1/2*R^2*(th'^2 + W^2*sin(th)^2)  V = -g*R*cos(th)";
    for place in ["equilibrium th = acos(g/(W^2*R))", "guess th = acos(g/(W^2*R))"] {
        assert_eq!(change(of_text(&format!("{hoop}  {place}"))), "4e-10", "{place}");
    }
    // At the bottom, just above and below the critical speed, omega^2 = g/R - W^2 is 2*e*W^2.
    assert_eq!(change(of_text(&format!("{hoop}  guess th = 1e-4"))), "2e-10");
    let slow = hoop.replace("10.0000001", "9.9999999");
    assert_eq!(change(of_text(&slow)), "2e-10");
    // A guess that is exact, also where it is no function of the parameters.
    assert_eq!(change(of_text(&format!("{slow}  guess th = 0"))), "2e-10");
    let flat = "param k = 1  param c = 2  coord x  T = 1/2*x'^2
        V = 1/2*k*(x - 2)^2 - 1/2*(1 - 1e-8)*(x - c)^2  guess x = 2";
    assert_eq!(change(of_text(flat)), "1e-10");
    // Parameters that change together.
    let defined = hoop.replace("10.0000001", "(1 - 1e-8)*sqrt(g/R)");
    assert_eq!(change(of_text(&defined)), "2e-10");
    // Well above it nothing cancels.
    let fast = hoop.replace("10.0000001", "20");
    assert!(of_text(&format!("{fast}  guess th = 1")).is_none());
}

/// Of the hard models those near a bifurcation, and those whose terms cancel; of the others none: no
/// springs or masses far apart, weak bonds, bodies far from the origin.
#[test]
fn stiff_beside_soft_is_no_cancellation() {
    let mut found: Vec<String> = Vec::new();
    for folder in ["models", "models/hard"] {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_string_lossy().to_string();
            let slow = ["chain_2000", "ubiquitin"].contains(&name.as_str());
            let model = path.extension().is_some_and(|end| end == "lag") && !slow;
            if model && ill_conditioned(load(&path)).is_some() {
                found.push(name);
            }
        }
    }
    found.sort();
    assert_eq!(
        found,
        [
            "bead_just_above",
            "bead_just_above_searched",
            "bead_just_below",
            "cancelling_energies",
            "cancelling_energies_extreme",
            "cancelling_energies_severe",
            "column_just_buckled",
            "column_just_falls",
            "column_just_stands",
        ]
    );
}

/// What is not told from 0 is not called 0.
#[test]
fn a_mass_matrix_is_called_singular_only_where_it_is() {
    let proved = |kinetic: &str, potential: &str| {
        let text = format!("coord x, y  T = {kinetic}  V = {potential}");
        let file = parse(&text).unwrap();
        let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
        let error = normal_modes(&linearize(model).unwrap(), &Options::default()).unwrap_err();
        let words = error.to_string();
        let LinearizeError::SingularMass { inertia, .. } = error else {
            panic!("{error}");
        };
        let proved = inertia != Inertia::Undecided;
        assert_eq!(words.contains("is singular"), proved, "{words}");
        assert_eq!(words.contains("not shown"), !proved, "{words}");
        proved
    };
    assert!(proved("1/2*x'^2", "x^2"));
    assert!(proved("1/2*(sqrt(2)*x' + y')^2", "(sqrt(2)*x + y)^2"));
    assert!(!proved("1/2*(ln(2)*x' + y')^2", "x^2 + y^2"));
}

#[test]
fn shapes_of_a_wide_cluster_are_orthonormal() {
    // 35 equal oscillators, hardly coupled: one cluster in the digits that are asked for.
    let model = model(
        "param N = 35  param m = 6.17  param k = 7.48  param c = 9e-14
         coord x[1..N]
         T = sum(a in 1..N, 1/2*m*x[a]'^2)
         V = sum(a in 1..N, 1/2*k*x[a]^2) + sum(a in 1..N-1, 1/2*c*(x[a+1] - x[a])^2)",
    );
    let linearized = linearize(model).unwrap();
    let modes = normal_modes(&linearized, &Options::default()).unwrap().modes;
    for (a, left) in modes.iter().enumerate() {
        for (b, right) in modes.iter().enumerate() {
            let parts = left.vector.iter().zip(&right.vector);
            let product: f64 = 6.17 * parts.map(|(x, y)| x * y).sum::<f64>();
            let want = f64::from(u8::from(a == b));
            assert!((product - want).abs() < 1e-13, "{a} {b}: {product:e}");
        }
    }
}
