//! Equations under conditions on velocities, with their multipliers.
#![cfg(feature = "engine")]

use crate::common::{load, model};
use crate::derive_support::BruteForce;

use std::path::Path;

use librate::derive::{Conserved, Parts, derive};
use librate::expect::are_equal;

#[test]
fn equations_have_the_forces_of_the_conditions() {
    for name in ["disc", "skate_on_spring", "ball_in_paraboloid"] {
        let model = load(Path::new(&format!("models/rolling/{name}.lag")));
        let derivation = derive(&model, &Parts::all()).unwrap();
        let mut pool = derivation.pool.clone();
        let brute = BruteForce::new(&model, &mut pool);
        let constraints = derivation.constraints.as_ref().unwrap();
        assert_eq!(constraints.expressions.len(), model.rolling.len());
        for (i, equation) in derivation.equations.as_ref().unwrap().iter().enumerate() {
            let own = brute.expression(&mut pool, equation, &[]);
            let mut want = brute.equation(&mut pool, i);
            let velocity = model.coordinates.at(i).velocity;
            for (name, condition) in constraints.names.iter().zip(&constraints.expressions) {
                let multiplier = pool.symbol(name);
                let multiplier = pool.symbol_expr(multiplier);
                let slope = pool.diff(*condition, velocity);
                let force = pool.mul(multiplier, slope);
                want = pool.sub(want, force);
            }
            assert!(are_equal(&mut pool, own, want), "{name}: equation {i}");
        }
        // Forces of conditions do no work, and keep no momentum that they act on.
        let energy = derivation.energy.as_ref().unwrap();
        assert!(energy.conserved.contains(&Conserved::Energy { is_total: true }), "{name}");
        assert!(!energy.conserved.contains(&Conserved::Momentum(0)), "{name}");
        assert!(energy.hamiltonian.is_none() && derivation.linear.is_err(), "{name}");
    }
}

#[test]
fn a_belt_does_work() {
    let belt = model("coord x, y  T = 1/2*(x'^2 + y'^2)  V = x^2 + y^2  constraint x' = x*y' + 1");
    let derivation = derive(&belt, &Parts::all()).unwrap();
    assert_eq!(derivation.constraints.unwrap().names, ["mu"]);
    assert!(derivation.energy.unwrap().conserved.is_empty());
}
