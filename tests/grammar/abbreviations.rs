//! Names on the page for what it would repeat: with their values put back everything is as it was, and they
//! are given only where they shorten the page.
#![cfg(feature = "cli")]

use crate::common;

use common::{load, model, model_files};
use librate::derive::{Derivation, MotionSum, Parts, derive};
use librate::expect::are_equal;
use librate::expr::{ExprId, Pool};
use librate::report::{Style, derive_json, derive_text};
use librate_core::derive::Definition;
use librate_core::expr::Substitution;

/// All expressions of a page in a fixed order.
fn expressions(derivation: &Derivation) -> Vec<ExprId> {
    let mut all = Vec::new();
    let mut sums: Vec<&MotionSum> = derivation.equations.iter().flatten().collect();
    if let Some(energy) = &derivation.energy {
        sums.extend(&energy.momenta);
        sums.push(&energy.function);
        sums.extend(&energy.hamiltonian);
    }
    if let Ok(linear) = &derivation.linear {
        if let Some(part) = &linear.second_order {
            sums.extend(&part.equations);
            sums.extend([&part.kinetic, &part.potential]);
        }
        let rows = linear.mass.iter().chain(&linear.stiffness);
        all.extend(rows.flatten().copied());
    }
    all.extend(sums.iter().flat_map(|sum| sum.terms.iter().map(|term| term.coefficient)));
    all
}

/// With the values of names put in, the last one first: it may contain the earlier ones.
fn written_out(pool: &mut Pool, definitions: &[Definition], mut e: ExprId) -> ExprId {
    for definition in definitions.iter().rev() {
        let map = Substitution::from([(definition.symbol, definition.value)]);
        e = pool.substitute_one(e, &map);
    }
    e
}

#[test]
fn names_stand_for_what_they_replace() {
    let mut found = Vec::new();
    for path in model_files() {
        let model = load(&path);
        if model.coordinates.len() > 12 || !model.constraints.is_empty() {
            continue;
        }
        let derivation = derive(&model, &Parts::all()).unwrap();
        let Some((short, definitions)) = derivation.abbreviated() else {
            continue;
        };
        let mut pool = short.pool.clone();
        let (before, after) = (expressions(&derivation), expressions(&short));
        assert_eq!(before.len(), after.len());
        for (before, after) in before.into_iter().zip(after) {
            let after = written_out(&mut pool, &definitions, after);
            assert!(are_equal(&mut pool, before, after), "{path:?}");
        }
        for (at, definition) in definitions.iter().enumerate() {
            let name = &definition.name;
            assert!(!derivation.symbols.contains_key(name), "{path:?}: {name}");
            // Nothing that comes later is needed.
            let symbols = pool.symbols(definition.value);
            let later = definitions[at..].iter().find(|d| symbols.contains(&d.symbol));
            assert!(later.is_none(), "{path:?}: {name}");
        }
        // JSON is written out.
        let json = derive_json(&derivation);
        assert!(!json.contains("norm("), "{path:?}");
        found.push(path.file_stem().unwrap().to_string_lossy().into_owned());
    }
    for name in ["co2", "water"] {
        assert!(found.iter().any(|own| own == name), "{found:?}");
    }
    for name in ["three_pendulums", "double_pendulum", "governor"] {
        assert!(!found.iter().any(|own| own == name), "{found:?}");
    }
}

#[test]
fn a_molecule_has_its_distances_at_the_top() {
    let text = "param m[1..3] = 1  param k = 1  param l = 1
        coord r[1..3, 1..3]
        T = sum(a in 1..3, 1/2*m[a]*dot(r[a]', r[a]'))
        V = 1/2*k*((norm(r[2] - r[1]) - l)^2 + (norm(r[3] - r[2]) - l)^2 + (norm(r[3] - r[1]) - l)^2)
        equilibrium r[1] = [0, 0, 0]
        equilibrium r[2] = [l, 0, 0]
        equilibrium r[3] = [l/2, sqrt(3)/2*l, 0]";
    let derivation = derive(&model(text), &Parts::all()).unwrap();
    let page = derive_text(&derivation, &Style::default().ascii(true));
    let top: Vec<&str> =
        page.lines().skip_while(|line| *line != "abbreviations").take_while(|line| !line.is_empty()).collect();
    assert_eq!(
        top,
        ["abbreviations", "  d12 = norm(r[2] - r[1])", "  d13 = norm(r[3] - r[1])", "  d23 = norm(r[3] - r[2])",]
    );
    let first = page.lines().find(|line| line.contains("r[1,1]''")).unwrap();
    assert!(first.contains("d12") && !first.contains("sqrt"), "{first}");
}
