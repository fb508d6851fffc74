//! Equations under conditions on velocities, with their multipliers.
#![cfg(feature = "engine")]

use crate::common::{load, model};
use crate::derive_support::BruteForce;

use std::path::Path;

use librate::derive::{Conserved, Parts, derive};
use librate::expect::are_equal;
use librate_core::expr::Substitution;

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

/// Each is the sum of Lagrange's equations along an allowed velocity, in which forces of conditions cancel.
#[test]
fn equations_in_independent_velocities_have_no_multipliers() {
    for (name, free) in
        [("disc", vec![2, 3, 4]), ("skate_on_spring", vec![0, 2]), ("ball_in_paraboloid", vec![2, 3, 4])]
    {
        let model = load(Path::new(&format!("models/rolling/{name}.lag")));
        let derivation = derive(&model, &Parts::all()).unwrap();
        let mut pool = derivation.pool.clone();
        let brute = BruteForce::new(&model, &mut pool);
        let own = derivation.independent.as_ref().unwrap();
        assert_eq!(own.free, free, "{name}");
        let mut speeds = Substitution::default();
        for (i, speed) in &own.follows {
            let speed = brute.expression(&mut pool, speed, &[]);
            speeds.insert(model.coordinates.at(*i).velocity, speed);
        }
        for condition in &model.rolling {
            let left = pool.substitute_one(condition.expression, &speeds);
            let zero = pool.zero();
            assert!(are_equal(&mut pool, left, zero), "{name}");
        }
        let mut moved = Substitution::default();
        for (i, speed) in &own.follows {
            let speed = brute.expression(&mut pool, speed, &[]);
            let rate = brute.rate(&mut pool, speed);
            moved.insert(brute.acceleration(&pool, *i), rate);
        }
        for (at, equation) in own.free.iter().zip(&own.equations) {
            let mut want = brute.equation(&mut pool, *at);
            for (i, speed) in &own.follows {
                let speed = brute.expression(&mut pool, speed, &[]);
                let slope = pool.diff(speed, model.coordinates.at(*at).velocity);
                let other = brute.equation(&mut pool, *i);
                let part = pool.mul(slope, other);
                want = pool.add(want, part);
            }
            let want = pool.substitute_one(want, &moved);
            let want = pool.substitute_one(want, &speeds);
            let found = brute.expression(&mut pool, equation, &[]);
            assert!(are_equal(&mut pool, found, want), "{name}: equation {at}");
        }
    }
}

#[test]
fn a_belt_does_work() {
    let belt = model("coord x, y  T = 1/2*(x'^2 + y'^2)  V = x^2 + y^2  constraint x' = x*y' + 1");
    let derivation = derive(&belt, &Parts::all()).unwrap();
    assert_eq!(derivation.constraints.unwrap().names, ["mu"]);
    assert!(derivation.energy.unwrap().conserved.is_empty());
}
