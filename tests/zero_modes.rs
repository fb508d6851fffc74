//! Zero modes are shown with what they are, part by part where a model falls into several.
#![cfg(feature = "engine")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

use librate::linearize::linearize;
use librate::model::{Settings, TableTexts, elaborate};
use librate::syntax::parse;

fn motions(text: &str) -> Vec<String> {
    let file = parse(text).unwrap();
    let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
    let linearized = linearize(model).unwrap();
    let modes = linearized.zero_modes();
    modes.into_iter().map(|mode| mode.meaning).collect()
}

/// Springs between all points of a range, at rest as given.
fn body(from: usize, to: usize) -> String {
    format!(
        "sum(a in {from}..{to}, b in a+1..{to}, 1/2*(norm(r[a] - r[b]) - norm(rest[a] - rest[b]))^2)"
    )
}

#[test]
fn a_free_molecule_moves_and_turns_six_ways() {
    let found = motions(&format!(
        "coord r[1..4, 1..3]  let rest = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
         T = sum(a in 1..4, 1/2*dot(r[a]', r[a]'))  V = {}
         equilibrium r[a in 1..4] = rest[a]",
        body(1, 4)
    ));
    let along = ["x", "y", "z"].map(|axis| format!("translation of r along {axis}"));
    let about = ["z", "y", "x"].map(|axis| format!("rotation about {axis}"));
    assert_eq!(found, [along, about].concat());
}

#[test]
fn two_bodies_are_told_apart() {
    let found = motions(&format!(
        "coord r[1..7, 1..2]
         let rest = [[0, 0], [1, 0], [0, 1], [5, 5], [6, 5], [5, 6], [6, 7]]
         T = sum(a in 1..7, 1/2*dot(r[a]', r[a]'))  V = {} + {}
         equilibrium r[a in 1..7] = rest[a]",
        body(1, 3),
        body(4, 7)
    ));
    assert_eq!(
        found,
        [
            "translation of r[1..3] along x",
            "translation of r[1..3] along y",
            "translation of r[4..7] along x",
            "translation of r[4..7] along y",
            "rotation of r[1..3]",
            "rotation of r[4..7]",
        ]
    );
}

#[test]
fn a_linear_molecule_turns_about_two_axes_only() {
    let found = motions(
        "coord r[1..3, 1..3]  T = sum(a in 1..3, 1/2*dot(r[a]', r[a]'))
         V = 1/2*(norm(r[1] - r[2]) - 1)^2 + 1/2*(norm(r[3] - r[2]) - 1)^2
           + 1/2*dot(r[1] - 2*r[2] + r[3], r[1] - 2*r[2] + r[3])
         equilibrium r[a in 1..3] = [0, 0, a - 2]",
    );
    assert_eq!(found.len(), 5);
    assert_eq!(found[3..], ["rotation about y", "rotation about x"]);
}

#[test]
fn what_slides_or_turns_alone_is_named() {
    let found = motions(
        "coord x[1..5], phi, u, v
         T = sum(i in 1..5, 1/2*x[i]'^2) + phi'^2 + u'^2 + v'^2
         V = 1/2*(x[2] - x[1])^2 + 1/2*(x[3] - x[2])^2 + 1/2*(x[5] - x[4])^2
           + 1/4*(u^2 + v^2 - 1)^2
         equilibrium u = 1",
    );
    assert_eq!(
        found,
        [
            "translation of x[1..3]",
            "translation of x[4..5]",
            "phi is free",
            "rotation of u, v",
        ]
    );
    let discs = motions(
        "param I : kg*m^2 = 1  param k : N*m = 1  coord a : rad, b : rad, x : m
         param m : kg = 1  T = I*a'^2 + I*b'^2 + m*x'^2  V = k*(1 - cos(a - b))",
    );
    assert_eq!(discs, ["common rotation of a, b", "x is free"]);
    let gears = motions("coord x, y, z  T = x'^2 + y'^2 + z'^2  V = (x - 2*y)^2 + z^2");
    assert_eq!(gears, ["x : y = 2 : 1"]);
}

/// Counting bonds finds three motions here; the one between the first four points that is too many
/// hides the dangling point.
#[test]
fn a_bond_too_many_elsewhere_hides_no_motion() {
    let found = motions(&format!(
        "coord r[1..5, 1..2]  let rest = [[0, 0], [3, 1], [1, 2], [4, 5], [7, 1]]
         T = sum(a in 1..5, 1/2*dot(r[a]', r[a]'))
         V = {} + 1/2*(norm(r[5] - r[4]) - norm(rest[5] - rest[4]))^2
         equilibrium r[a in 1..5] = rest[a]",
        body(1, 4)
    ));
    assert_eq!(found.len(), 4);
    assert_eq!(found[3], "no restoring force");
}
