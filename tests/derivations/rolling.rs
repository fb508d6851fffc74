//! Equations under conditions on velocities, with their multipliers.
#![cfg(feature = "engine")]

use crate::common::{load, model};
use crate::derive_support::BruteForce;

use std::path::Path;

use librate::derive::{Conserved, Motion, Parts, derive};
use librate::expect::are_equal;
use librate::model::Constant;
use librate::motion::{Start, System, Times};
use librate::number::Number;
use librate::precision::Ball;
use librate_core::expr::{ExprId, Substitution};
use librate_core::linearize::{evaluate_closed, known_values};

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
        assert!(energy.conserved.contains(&Conserved::Energy { is_total: Some(true) }), "{name}");
        assert!(!energy.conserved.contains(&Conserved::Momentum(0)), "{name}");
        assert!(energy.hamiltonian.is_none() && derivation.linear.is_ok(), "{name}");
    }
}

/// On a motion that is integrated they stay what they were.
#[test]
fn reduced_equations_that_are_derivatives_are_integrated() {
    let upright = "coord x, y, th, ph  param m = 2, R = 3/10, A = 1/4, C = 1/2
        T = 1/2*m*(x'^2 + y'^2) + 1/2*C*ph'^2 + 1/2*A*th'^2  V = 0
        constraint x' = R*ph'*cos(th)  constraint y' = R*ph'*sin(th)";
    let rubs = format!("{upright}  param c = 1  force th = -c*th'");
    let turntable = std::fs::read_to_string("models/rolling/turntable.lag").unwrap();
    for (text, from, wanted) in [
        (upright, "th'=1, ph'=2, x'=3/5", vec!["(C + m*R^2)*ph'"]),
        (&rubs, "th'=1, ph'=2, x'=3/5", vec!["A*th' + th*c", "(C + m*R^2)*ph'"]),
        (&turntable, "x=1/10, b'=1", vec!["7/5*m*r^2*a' - m*r*W*x", "7/5*m*r^2*b' - m*r*W*y"]),
    ] {
        let model = model(text);
        let derivation = derive(&model, &Parts::default().energy(true)).unwrap();
        let system = System::new(&model).unwrap();
        let start = Start::parse(from, &model, None, &system).unwrap();
        let times = Times::new(&Constant::parse("3").unwrap(), 7).unwrap();
        let motion = system.motion(&start, &times).unwrap();
        let mut pool = derivation.pool.clone();
        let brute = BruteForce::new(&model, &mut pool);
        let mut found = Vec::new();
        for quantity in &derivation.energy.as_ref().unwrap().conserved {
            let Conserved::Integral { value, .. } = quantity else { continue };
            found.push(derivation.text(value));
            let value = brute.expression(&mut pool, value, &[]);
            let values = motion.rows.iter().map(|row| {
                let mut known = known_values(&model);
                let state = model.coordinates.iter().map(|own| own.symbol);
                let state = state.chain(model.coordinates.iter().map(|own| own.velocity));
                for (symbol, x) in state.zip(row) {
                    known.insert(symbol, pool.number(Number::from_f64_exact(x.mid_f64()).unwrap()));
                }
                let value = pool.substitute_one(value, &known);
                evaluate_closed::<Ball>(&pool, value, ()).unwrap().mid_f64()
            });
            let values: Vec<f64> = values.collect();
            assert!(values[0].abs() > 1e-3 && values.iter().all(|own| (own - values[0]).abs() < 1e-14), "{values:?}");
        }
        assert_eq!(found, wanted, "{text}");
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

/// The matrices are those of the equations in independent velocities, differentiated at the equilibrium or steady motion.
#[test]
fn matrices_are_those_of_the_reduced_equations() {
    for name in ["disc", "skate_on_spring", "sleigh"] {
        let model = load(Path::new(&format!("models/rolling/{name}.lag")));
        let derivation = derive(&model, &Parts::all()).unwrap();
        let whole = derivation.linear.as_ref().unwrap();
        let reduced = whole.tangent.as_ref().unwrap().reduced.as_ref().unwrap();
        let own = derivation.independent.as_ref().unwrap();
        assert_eq!(own.free, reduced.free, "{name}");
        let linear = reduced.derivation.linear.as_ref().unwrap();
        let mut pool = reduced.derivation.pool.clone();
        let mut point = Substitution::default();
        for (coordinate, at) in model.coordinates.iter().zip(&whole.equilibrium) {
            point.insert(coordinate.symbol, *at);
            let rate = derivation.rates.iter().find(|(own, _)| *own == coordinate.name());
            point.insert(coordinate.velocity, rate.map_or_else(|| pool.zero(), |(_, rate)| *rate));
        }
        for (i, equation) in own.equations.iter().enumerate() {
            let load = equation.expression(&mut pool, |pool, motion| match motion {
                Motion::Velocity(j) => pool.symbol_expr(model.coordinates.at(j).velocity),
                _ => pool.zero(),
            });
            for (j, at) in own.free.iter().enumerate() {
                let coordinate = model.coordinates.at(*at);
                let mass = equation.coefficient(&mut pool, Motion::Acceleration(*at));
                let (by_velocity, by_place) =
                    (pool.diff(load, coordinate.velocity), pool.diff(load, coordinate.symbol));
                let entry = |rows: &Option<Vec<Vec<ExprId>>>| rows.as_ref().map(|rows| rows[i][j]);
                let velocity: Vec<ExprId> =
                    [&linear.gyroscopic, &linear.damping].into_iter().filter_map(entry).collect();
                let place: Vec<ExprId> =
                    std::iter::once(linear.stiffness[i][j]).chain(entry(&linear.circulatory)).collect();
                for (want, own) in [(mass, vec![linear.mass[i][j]]), (by_velocity, velocity), (by_place, place)] {
                    let want = pool.substitute_one(want, &point);
                    let own = pool.sum(&own);
                    assert!(are_equal(&mut pool, own, want), "{name}: {i} {j}");
                }
            }
        }
    }
    // Without values, too.
    let text = std::fs::read_to_string("models/rolling/skate_on_spring.lag").unwrap();
    let open = text.lines().map(|line| match line.starts_with("param") {
        true => line.split('=').next().unwrap(),
        false => line,
    });
    let open = derive(&model(&open.collect::<Vec<_>>().join("\n")), &Parts::all()).unwrap();
    let page = open.reduced();
    let linear = page.linear.as_ref().unwrap();
    let text = |e: ExprId| page.pool.display(e);
    assert_eq!((text(linear.mass[1][1]), text(linear.stiffness[1][1])), ("J + m*a^2".to_owned(), "k".to_owned()));
}

#[test]
fn a_belt_does_work() {
    let belt = model("coord x, y  T = 1/2*(x'^2 + y'^2)  V = x^2 + y^2  constraint x' = x*y' + 1");
    let derivation = derive(&belt, &Parts::all()).unwrap();
    assert_eq!(derivation.constraints.unwrap().names, ["mu"]);
    assert!(derivation.energy.unwrap().conserved.is_empty());
}
