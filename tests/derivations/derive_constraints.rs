//! Derivations under constraints: equations with multipliers, and M and K of the motions that are left, against what is
//! derived by hand and against the modes, which come by another path.
#![cfg(feature = "cli")]

use crate::common;

use common::{load, model, model_files};
use librate::assert_derives;
use librate::derive::{Derivation, Parts, derive};
use librate::expr::{ExprId, Pool, Tape};
use librate::linearize::{LinearizeError, linearize};
use librate::model::Model;
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate::precision::Ball;
use librate::report::{Style, derive_latex, derive_text};
use librate_core::derive::{Linear, Tangent};
use librate_core::expr::Substitution;
use nalgebra::DMatrix;

fn tangent(derivation: &Derivation) -> (&Linear, &Tangent) {
    let linear = derivation.linear.as_ref().unwrap();
    (linear, linear.tangent.as_ref().unwrap())
}

/// The values of expressions in the parameters.
fn values(model: &Model, pool: &mut Pool, roots: &[ExprId]) -> Vec<Ball> {
    let known: Substitution =
        model.parameters.iter().map(|parameter| (parameter.symbol, parameter.value.unwrap())).collect();
    let closed = pool.substitute(roots, &known);
    closed.into_iter().map(|root| librate_core::linearize::constant(pool, root).unwrap()).collect()
}

#[test]
fn a_pendulum_in_x_and_y() {
    let model = load("models/pendulum_in_x_and_y.lag".as_ref());
    let derivation = derive(&model, &Parts::all()).unwrap();
    assert_derives!(
        &derivation,
        equations = ["m*x'' = 2*lambda*x", "m*y'' + m*g = 2*lambda*y"],
        equilibrium = ["0", "-l"],
        mass = "[[m, 0], [0, m]]",
        stiffness = "[[m*g/l, 0], [0, m*g/l]]",
        momenta = ["m*x'", "m*y'"],
        energy_function = "1/2*m*(x'^2 + y'^2) + m*g*y",
        frequencies = ["g/l"],
    );
    let constraints = derivation.constraints.as_ref().unwrap();
    let show = |e: ExprId| derivation.pool.display(e);
    assert_eq!(constraints.names, ["lambda"]);
    assert_eq!(show(constraints.expressions[0]), "x^2 + y^2 - l^2");
    let (_, tangent) = tangent(&derivation);
    assert_eq!(show(tangent.multipliers[0]), "-1/2*g*m/l");
    assert_eq!(tangent.gradients[0].iter().map(|e| show(*e)).collect::<Vec<_>>(), ["0", "-2*l"]);
    let energy = derivation.energy.as_ref().unwrap();
    assert!(energy.hamiltonian.is_none());
}

#[test]
fn the_name_lambda_may_be_taken() {
    let text = "param lambda  param k  coord x, y
        T = 1/2*(x'^2 + y'^2)
        V = 1/2*k*x^2
        constraint x = lambda*y";
    let derivation = derive(&model(text), &Parts::all()).unwrap();
    assert_derives!(
        &derivation,
        equations = ["x'' + k*x = Lambda", "y'' + lambda*Lambda = 0"],
        frequencies = ["k*lambda^2/(1 + lambda^2)"],
    );
}

#[test]
fn symmetric_beads_on_a_ring_of_wire() {
    // Two beads on a circle in a plane, tied by a spring and each to the bottom by the field.
    let text = "param g = 2  param m = 3  param R = 5  param k = 7
        coord x[1..2], y[1..2]
        T = sum(i in 1..2, 1/2*m*(x[i]'^2 + y[i]'^2))
        V = sum(i in 1..2, m*g*y[i]) + 1/2*k*(x[2] - x[1])^2
        constraint [i in 1..2] x[i]^2 + y[i]^2 = R^2
        equilibrium x[i in 1..2] = 0
        equilibrium y[i in 1..2] = -R";
    let derivation = derive(&model(text), &Parts::all()).unwrap();
    assert_derives!(&derivation, frequencies = ["g/R", "g/R + 2*k/m"]);
    let (_, tangent) = tangent(&derivation);
    let reduced = tangent.reduced.as_ref().unwrap();
    assert_eq!(reduced.free, [0, 1]);
    let linear = reduced.derivation.linear.as_ref().unwrap();
    let frequencies = linear.frequencies.as_ref().unwrap();
    // Symmetries that keep constraints are not looked for in symbols, and those of M and K alone give no names: the modes do.
    let best = frequencies.best();
    assert!(best.symmetry.is_none() && best.blocks.is_empty());
    let classes: Vec<_> = best.frequencies.iter().map(|f| f.symmetry_at_values.as_deref()).collect();
    assert_eq!(classes, [Some("even"), Some("odd")]);
}

#[test]
fn steady_motions_under_constraints() {
    // A pendulum on the axle of a disc that rolls: cyclic are the coordinates that the energies do not depend on.
    let text = "param m, M, R, l, g, v  coord x, phi, th
        T = 1/2*M*x'^2 + 1/4*M*R^2*phi'^2 + 1/2*m*((x' + l*th'*cos(th))^2 + (l*th'*sin(th))^2)
        V = -m*g*l*cos(th)  constraint x = R*phi  equilibrium x' = v  equilibrium phi' = v/R";
    let derivation = derive(&model(text), &Parts::all()).unwrap();
    assert_derives!(
        &derivation,
        mass = "[[m + M, 0, l*m], [0, 1/2*M*R^2, 0], [l*m, 0, l^2*m]]",
        stiffness = "[[0, 0, 0], [0, 0, 0], [0, 0, g*l*m]]",
        frequencies = ["0", "g/l + 2*g*m/(3*M*l)"]
    );
}

#[test]
fn a_constraint_that_follows_from_others_has_no_multiplier() {
    let text = "param k = 1  param l = 1  coord x, y
        T = 1/2*(x'^2 + y'^2)
        V = 1/2*k*x^2
        constraint x = l*y
        constraint 2*x - 2*l*y = 0";
    let derivation = derive(&model(text), &Parts::all()).unwrap();
    let constraints = derivation.constraints.as_ref().unwrap();
    assert_eq!(constraints.names, ["lambda[1]"]);
    assert_eq!(constraints.dependent, 1);
    assert_derives!(&derivation, frequencies = ["k*l^2/(1 + l^2)"]);
}

#[test]
fn a_point_off_the_constraint_is_an_error() {
    let text = "param l = 1  coord x, y
        T = 1/2*(x'^2 + y'^2)
        V = y
        constraint x^2 + y^2 = l^2
        equilibrium x = 0
        equilibrium y = -2*l";
    let error = derive(&model(text), &Parts::all()).unwrap_err();
    assert!(matches!(error, LinearizeError::ConstraintBroken { .. }), "{error:?}");
}

#[test]
fn what_is_found_numerically_stands_for_itself() {
    let text = "param g = 9.81  param l = 0.5  param k = 4
        coord x, y
        T = 1/2*(x'^2 + y'^2)
        V = g*y + 1/2*k*(x - 1)^2
        constraint x^2 + y^2 = l^2
        guess y = -l";
    let derivation = derive(&model(text), &Parts::all()).unwrap();
    let (linear, tangent) = tangent(&derivation);
    let show = |e: ExprId| derivation.pool.display(e);
    assert_eq!(linear.equilibrium.iter().map(|e| show(*e)).collect::<Vec<_>>(), ["x", "y"]);
    // The multiplier is what the forces at that point say: 2 lambda x = k (x - 1).
    assert_eq!(show(tangent.multipliers[0]), "1/2*k*(1 - 1/x)");
    assert_eq!(show(linear.stiffness[0][0]), "k/x");
    // Along the circle, in terms of x: delta_y = -x/y delta_x, M_r = 1 + x^2/y^2 and, with the curvature of the circle,
    // K_r = k - 2 lambda (1 + x^2/y^2), where 2 lambda y = g.
    let reduced = tangent.reduced.as_ref().unwrap();
    assert_eq!(reduced.free, [0]);
    let page = &*reduced.derivation;
    let frequencies = page.linear.as_ref().unwrap().frequencies.as_ref().unwrap();
    let closed = frequencies.best().frequencies[0].omega_squared;
    let linearized = linearize(model(text)).unwrap();
    let [x, y] = *linearized.equilibrium().values.as_slice() else {
        panic!();
    };
    let number = |value: Ball| value.mid_f64();
    let (x, y, g) = (number(x), number(y), 9.81);
    let inertia = 1.0 + x * x / (y * y);
    let want = 4.0 / inertia - g / y;
    let modes = normal_modes(&linearized, &Options::default()).unwrap();
    let omega_squared = number(modes.modes[0].omega_squared.unwrap());
    assert!((omega_squared - want).abs() < 1e-12 * want);
    let point = [("x", x), ("y", y), ("g", g), ("k", 4.0)];
    let symbols = page.pool.symbols(closed);
    let inputs: Vec<f64> = symbols
        .iter()
        .map(|symbol| {
            let name = page.pool.symbol_name(*symbol);
            point.iter().find(|(own, _)| *own == name).unwrap().1
        })
        .collect();
    let tape = Tape::compile(&page.pool, &[closed], &symbols).unwrap();
    let own = tape.evaluate::<f64>(&inputs, &mut Vec::new())[0];
    assert!((own - want).abs() < 1e-12 * want, "{own} {want}");
    // What stands for its value is told.
    let text = derive_text(&derivation, &Style::default().ascii(true));
    assert!(text.contains("it is kept as symbols below: x, y\n"), "{text}");
    let latex = derive_latex(&derivation, false);
    assert!(latex.contains("below: $x$, $y$.\n"), "{latex}");
}

#[test]
fn every_model_with_constraints_has_a_page_that_agrees_with_its_modes() {
    let mut seen = 0;
    for path in model_files() {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let model = load(&path);
        if model.constraints.is_empty() {
            continue;
        }
        seen += 1;
        let mut derivation = derive(&model, &Parts::all()).unwrap();
        // At rest at the equilibrium the equations hold.
        let mut pool = derivation.pool.clone();
        let zero = pool.zero();
        let names = derivation.constraints.as_ref().unwrap().names.clone();
        let (linear, tangent) = tangent(&derivation);
        let mut rest = Substitution::default();
        for (coordinate, at) in model.coordinates.iter().zip(&linear.equilibrium) {
            rest.insert(coordinate.symbol, *at);
        }
        for (name, value) in names.iter().zip(&tangent.multipliers) {
            rest.insert(pool.symbol(name), *value);
        }
        for equation in derivation.equations.as_ref().unwrap() {
            let left = equation.expression(&mut pool, |_, _| zero);
            let left = pool.substitute_one(left, &rest);
            let left = values(&model, &mut pool, &[left])[0];
            assert!(left.contains_zero() && left.radius < 1e-24, "{name}: {left:?}");
        }
        // The matrices of what is left have the frequencies of the other path.
        let reduced = tangent.reduced.as_ref().unwrap();
        let page = reduced.derivation.linear.as_ref().unwrap();
        let n = page.mass.len();
        let mut pool = reduced.derivation.pool.clone();
        let mut matrix = |rows: &[Vec<ExprId>]| {
            let entries: Vec<ExprId> = rows.iter().flatten().copied().collect();
            let entries = values(&model, &mut pool, &entries);
            DMatrix::from_row_iterator(n, n, entries.iter().map(Ball::mid_f64))
        };
        let (mass, stiffness) = (matrix(&page.mass), matrix(&page.stiffness));
        let root = mass.cholesky().unwrap().l().try_inverse().unwrap();
        let mut squares: Vec<f64> =
            (&root * stiffness * root.transpose()).symmetric_eigenvalues().iter().copied().collect();
        squares.sort_by(f64::total_cmp);
        let linearized = linearize(model.clone()).unwrap();
        let modes = normal_modes(&linearized, &Options::default()).unwrap();
        let mut certified: Vec<f64> = modes.modes.iter().map(|mode| mode.omega_squared.unwrap().mid_f64()).collect();
        certified.sort_by(f64::total_cmp);
        assert_eq!(squares.len(), certified.len(), "{name}");
        let largest = certified.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (own, want) in squares.iter().zip(&certified) {
            assert!((own - want).abs() < 1e-13 * largest, "{name}: {own} {want}");
        }
        derivation.limit("g", &librate::number::Number::ZERO);
    }
    assert!(seen >= 7, "{seen}");
}
