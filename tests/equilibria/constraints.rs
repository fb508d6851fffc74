//! Constraints of vectors, component by component.
#![cfg(feature = "engine")]

use crate::common;

use common::model;
use librate::linearize::{LinearizeError, linearize};
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate_core::linearize::derive;

fn omegas(text: &str) -> Vec<[f64; 2]> {
    let linearized = linearize(model(text)).unwrap();
    let modes = normal_modes(&linearized, &Options::default().digits(15)).unwrap();
    let of = |mode: &librate::oscillation::NormalMode| [mode.omega.mid_f64(), mode.omega.mid_f64_error()];
    modes.modes.iter().map(of).collect()
}

/// A double pendulum whose rods are vectors of fixed direction, and the one in angles.
#[test]
fn rods_as_vectors_are_the_pendulum_in_angles() {
    let parameters = "param g = 9.81  param l[1..2] = [1, 0.7]  param m[1..2] = [2, 3]  coord th[1..2]";
    let tied = omegas(&format!(
        "{parameters}  coord r[1..2, 1..2]
         T = sum(i in 1..2, 1/2*m[i]*dot(r[i]', r[i]'))
         V = sum(i in 1..2, m[i]*g*r[i, 2])
         constraint r[1] = l[1]*[sin(th[1]), -cos(th[1])]
         constraint r[2] - r[1] = l[2]*[sin(th[2]), -cos(th[2])]
         guess r[i in 1..2] = [0, -i]"
    ));
    let angles = omegas(&format!(
        "{parameters}
         let a = l[1]*[sin(th[1]), -cos(th[1])]
         let b = a + l[2]*[sin(th[2]), -cos(th[2])]
         T = 1/2*m[1]*dot(a', a') + 1/2*m[2]*dot(b', b')
         V = m[1]*g*a[2] + m[2]*g*b[2]"
    ));
    assert_eq!((tied.len(), angles.len()), (2, 2));
    for (tied, angles) in tied.iter().zip(&angles) {
        assert!((tied[0] - angles[0]).abs() <= tied[1] + angles[1], "{tied:?} {angles:?}");
    }
}

/// The way down is gone in many steps, each with multipliers of its own.
#[test]
fn minima_along_constraints_are_those_without_them() {
    let energies = "T = x'^2 + y'^2 + u'^2  V = 7/5*x^2 + 3/5*(y - x)^2 + 11/4*u^2 + 13/2*u";
    let tied = omegas(&format!("coord x, u, y  {energies}  constraint u = x^2 + 4/5*y"));
    let put_in = omegas(&format!("coord x, y  let u = x^2 + 4/5*y  {energies}"));
    assert_eq!((tied.len(), put_in.len()), (2, 2));
    for (tied, put_in) in tied.iter().zip(&put_in) {
        assert!((tied[0] - put_in[0]).abs() <= tied[1] + put_in[1], "{tied:?} {put_in:?}");
    }
}

/// A family of vector constraints, with a component that says 0 = 0.
#[test]
fn families_of_vectors_are_tied_member_by_member() {
    let text = "param N = 3  coord r[1..N, 1..3], x[1..N]
        T = sum(i in 1..N, 1/2*dot(r[i]', r[i]'))
        V = sum(i in 1..N, 1/2*i*dot(r[i], r[i])) + 0*x[1]
        constraint [i in 1..N] [r[i, 1], r[i, 2], 0] = [x[i], 2*x[i], 0]";
    let linearized = linearize(model(text)).unwrap();
    assert_eq!(linearized.model().constraints.len(), 6);
    let difference = text.replace("[r[i, 1], r[i, 2], 0] = [x[i], 2*x[i], 0]", "r[i] - [x[i], 2*x[i], r[i, 3]] = 0");
    assert_eq!(omegas(&difference), omegas(text));
    // omega² = i, along (1, 2, 0)/√5 and along z.
    let found = omegas(text);
    let want = [1.0, 1.0, 2.0, 2.0, 3.0, 3.0_f64];
    assert_eq!(found.len(), want.len());
    for (found, want) in found.iter().zip(want) {
        assert!((found[0] - want.sqrt()).abs() <= found[1] + 1e-15, "{found:?}");
    }
}

#[test]
fn sides_of_different_shapes_are_a_mistake() {
    for sides in ["r = [x, x, 0]", "r = x", "r = [[x, x]]"] {
        let text = format!("coord r[1..2], x  T = dot(r', r') + x'^2  V = dot(r, r)  constraint {sides}");
        let file = librate::syntax::parse(&text).unwrap();
        let errors = librate::model::elaborate(&file, &Default::default(), &Default::default());
        let errors = errors.unwrap_err();
        assert_eq!(errors[0].code(), "E0112", "{errors:?}");
        assert!(errors[0].to_string().contains("sides of a constraint"), "{errors:?}");
    }
}

/// Constraints that differ by less than doubled doubles tell are as many as there are, and those that don't differ at
/// all are one, whatever they are multiplied by.
#[test]
fn nearly_equal_constraints_are_told_apart() {
    let square = "coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)  V = x^2 + y^2 + 2*z^2";
    let left = |constraints: &str| {
        let linearized = linearize(model(&format!("{square}  {constraints}"))).unwrap();
        let dependent = linearized.dependent_constraints().to_vec();
        (linearized.dimension(), dependent)
    };
    for (constraints, dimension, dependent) in [
        ("constraint x = y  constraint x*(1 + 1e-32) = y", 1, vec![]),
        ("constraint x = y  constraint x*(1 + 1e-200) = y", 1, vec![]),
        ("constraint x = y  constraint x = y + 1e-40*z", 1, vec![]),
        ("constraint x = y  constraint y = z  constraint x = z + 1e-50*y", 0, vec![]),
        ("constraint x = y  constraint y = z  constraint x = z", 1, vec![2]),
        ("constraint x = y  constraint 1e-200*x = 1e-200*y", 2, vec![1]),
        ("constraint x = y  constraint sqrt(2)*x = sqrt(2)*y", 2, vec![1]),
        ("constraint x = y  constraint pi*x = (pi + 1e-40)*y", 1, vec![]),
        ("constraint x = y  constraint sin(x) = sin(y)*(1 + 1e-36)", 1, vec![]),
    ] {
        assert_eq!(left(constraints), (dimension, dependent), "{constraints}");
    }
    // What follows only where the others hold is refused.
    let there = "constraint x = y  constraint sin(x) = sin(y)  equilibrium x = 0  equilibrium y = 0  equilibrium z = 0";
    let error = linearize(model(&format!("{square}  {there}"))).err();
    assert!(matches!(error, Some(LinearizeError::ConstraintsSingular { .. })), "{error:?}");
}

/// Constraints that can't all hold are refused, in numbers and in symbols, however little they differ by.
#[test]
fn contradictions_are_exact() {
    let plane = "param k = 3  coord x, y  T = 1/2*(x'^2 + y'^2)  V = x^2 + y^2";
    for constraints in [
        "constraint x = y  constraint x = y + 1e-30",
        "constraint x = y  constraint x = y + 1e-90",
        "constraint x = y  constraint 7*x = 7*y + 1e-300",
        "constraint x = y  constraint k*x = k*y + k*1e-60",
        "constraint x = 1  constraint y = 1  constraint x + y = 2 + 1e-45",
        "constraint x^2 + y^2 = 1  constraint sqrt(x^2 + y^2) = 1 + 1e-50  guess y = -1",
    ] {
        let text = format!("{plane}  {constraints}");
        for error in [linearize(model(&text)).err(), derive(model(&text)).err()] {
            let Some(LinearizeError::ConstraintsContradict { .. }) = error else {
                panic!("{constraints}: {error:?}");
            };
        }
    }
}

/// Forces beside constraints: an equilibrium at 0 or at the guess is found as it is, and what is symmetric is no friction.
#[test]
fn forces_under_constraints_rest_where_they_vanish() {
    let found = |text: &str| {
        let linearized = linearize(model(text)).unwrap();
        assert!(linearized.equilibrium().values.iter().all(librate::precision::Ball::is_zero), "{text}");
        normal_modes(&linearized, &Options::default()).unwrap()
    };
    let kinds = |text: &str| found(text).modes.iter().map(|mode| mode.kind).collect::<Vec<_>>();
    use librate::modes::Kind::{Oscillation, Unstable, Zero};
    assert_eq!(kinds("coord x, y  T = 1/2*(x'^2 + y'^2)  force y = -9.81  constraint y = 0"), [Zero]);
    let bowl = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = y  constraint y = x^2  force x = -3*x - 2*x'*y";
    let bowl = found(bowl);
    assert!((bowl.modes[0].omega.mid_f64().powi(2) - 5.0).abs() < 1e-14 && bowl.modes[0].kind == Oscillation);
    let curved = "coord x, y, z, w
        T = w^2*x'^2/3 + w'^2/2 + w'*x*x'/3 + x'^2/2 + 9*y'^2/2 + z'^2/2
        V = w^2 - 2*w*x + 2*w*y + 3*w*z - x^2 + x*y + x*z + 2*x + 2*z^2 + z
        force x = -3*w'*x/2 - 2*x/5  force z = 5*w*x' + z/2
        constraint w^2 + 2*x + z + 2 = w^2 + 2  guess x = 0";
    assert_eq!(kinds(curved), [Unstable, Oscillation, Oscillation]);
    // s⁴ + s² - 1: one entry for ±s, as with the same force in V.
    let turning = "coord x, y  T = 1/2*(x'^2 + y'^2) + x*y'  V = -1/2*x^2  force y = -y";
    assert_eq!(kinds(turning), [Unstable, Oscillation]);
}
