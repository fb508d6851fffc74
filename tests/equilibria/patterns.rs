//! The symmetry of patterns of equal entries, and what is nearly one.
#![cfg(feature = "engine")]

use crate::common;

use librate::linearize::linearize;
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate_core::symmetry::{Pattern, Symmetry};

/// Every coordinate beside every other, by labels that are given; 0 is none.
fn complete(colours: &[u64], label: impl Fn(usize, usize) -> i64) -> Pattern {
    let mut pattern = Pattern::new(colours.len());
    for (i, colour) in colours.iter().enumerate() {
        pattern.set_diagonal(i, *colour, true);
        for j in (0..colours.len()).filter(|j| *j != i && label(i, *j) != 0) {
            pattern.push(i, j, label(i, j), true);
        }
    }
    pattern
}

/// The order of the group with signs.
fn order(pattern: &Pattern) -> f64 {
    Symmetry::find_signed(pattern).unwrap().order
}

#[test]
fn alike_coordinates_are_exchanged() {
    let one = |_: usize, _: usize| 1;
    assert_eq!(order(&complete(&[1; 6], one)), 720.0);
    assert_eq!(order(&complete(&[1, 1, 2, 2, 2, 2, 1], one)), 144.0);
    // The edges of a ring have a label of their own: its turns exchange no two alone.
    let ring = |n: usize| move |i: usize, j: usize| i64::from([1, n - 1].contains(&i.abs_diff(j)));
    let labelled = move |n: usize| move |i: usize, j: usize| 1 + ring(n)(i, j);
    assert_eq!(order(&complete(&[1; 6], labelled(6))), 12.0);
    // The hub of a star is like none of its ends, which have no edges between them.
    let star = |i: usize, j: usize| i64::from(i == 0 || j == 0);
    let star = complete(&[1; 5], star);
    assert_eq!(order(&star), 24.0);
    let found = Symmetry::find_signed(&star).unwrap();
    assert!(found.generators.iter().all(|g| g.of(0).0 == 0));
    // So many that are alike have too large a group; in a ring they are not, however many.
    assert!(Symmetry::may_have_classes(&complete(&[1; 6], one)));
    assert!(!Symmetry::may_have_classes(&complete(&[1; 80], one)));
    assert!(Symmetry::may_have_classes(&complete(&[1; 80], labelled(80))));
}

#[test]
fn nearly_equal_is_no_mirror() {
    let classes = |length: &str| -> Vec<Option<String>> {
        let model = common::model(&format!(
            "param g = 9.81  param l[1..2] = [1, {length}]  coord phi[1..2]
             T = sum(i in 1..2, 1/2*l[i]^2*phi[i]'^2)
             V = sum(i in 1..2, g*l[i]*(1 - cos(phi[i]))) + (phi[1] - phi[2])^2"
        ));
        let normal = normal_modes(&linearize(model).unwrap(), &Options::default()).unwrap();
        normal.modes.into_iter().map(|mode| mode.symmetry).collect()
    };
    let both = [Some("even".to_owned()), Some("odd".to_owned())];
    assert_eq!(classes("1"), both);
    assert_eq!(classes("1 + 1e-33"), [None, None]);
    assert_eq!(classes("1 + 1e-80"), [None, None]);
}
