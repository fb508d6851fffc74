//! Every equilibrium in a box, against closed forms and other programs' digits; none missed.
#![cfg(feature = "engine")]

use crate::common;

use librate::equilibria::{EquilibriaError, Equilibrium, Found, Region, find};
use librate::model::Model;
use librate::modes::Stability;
use proptest::prelude::*;

fn found(model: &Model, ranges: &str) -> Found {
    find(model, &Region::parse(ranges, model).unwrap()).unwrap()
}

fn of(text: &str, ranges: &str) -> Found {
    found(&common::model(text), ranges)
}

fn of_file(name: &str, settings: &[&str], ranges: &str) -> Found {
    let text = std::fs::read_to_string(format!("models/equilibria/{name}.lag")).unwrap();
    found(&common::model_in(&text, std::path::Path::new("."), settings), ranges)
}

/// The points of a complete search.
fn points(found: &Found) -> Vec<Vec<f64>> {
    assert!(found.complete, "{:?}", found.reasons);
    assert!(found.equilibria.iter().all(|own| own.isolated == Some(true) && own.radius() < 1e-15));
    found.equilibria.iter().map(|own| own.point.iter().map(|x| x.mid_f64()).collect()).collect()
}

#[track_caller]
fn assert_near(found: &Found, expected: &[&[f64]]) {
    let points = points(found);
    assert_eq!(points.len(), expected.len(), "{points:?}");
    for (own, expected) in points.iter().zip(expected) {
        for (x, y) in own.iter().zip(*expected) {
            assert!((x - y).abs() <= 4e-16 * y.abs().max(1.0), "{points:?}");
        }
    }
}

/// A box is closed: both ends are in it.
#[test]
fn ends_of_the_box_count() {
    use std::f64::consts::PI;
    let pendulum = "param g = 9.81 coord phi T = 1/2*phi'^2 V = -g*cos(phi)";
    assert_near(&of(pendulum, "phi=-pi..pi"), &[&[-PI], &[0.0], &[PI]]);
    assert_near(&of(pendulum, "phi=0..3"), &[&[0.0]]);
    assert_near(&of(pendulum, "phi=1/10..3.1415"), &[]);
    assert_near(&of(pendulum, "phi=-7..7"), &[&[-2.0 * PI], &[-PI], &[0.0], &[PI], &[2.0 * PI]]);
    // Where the first cut leaves next to nothing of a range about what is no double.
    assert_near(&of(pendulum, "phi=3..4"), &[&[PI]]);
    assert_near(&of("coord x T = 1/2*x'^2 V = x^3/3 - x", "x=-1..1"), &[&[-1.0], &[1.0]]);
    assert_near(&of("coord x T = 1/2*x'^2 V = x^3/3 - x", "x=-0.999999999..1"), &[&[1.0]]);
}

/// With all multipliers turned an equilibrium under constraints is the same one.
#[test]
fn constrained_equilibria_are_found_once() {
    let ellipse = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = y  constraint x^2/4 + y^2 + x*y/3 = 1";
    let half = 0.5_f64.sqrt();
    assert_near(&of(ellipse, "x=-3..3, y=-3..3"), &[&[-half, 1.5 * half], &[half, -1.5 * half]]);
    let pendulum = "coord x[1..2], y[1..2]  T = 1/2*(dot(x', x') + dot(y', y'))  V = 9.81*(y[1] + 2*y[2])
        constraint x[1]^2 + y[1]^2 = 1  constraint (x[2] - x[1])^2 + (y[2] - y[1])^2 = 1";
    assert_eq!(points(&of(pendulum, "x=-3..3, y=-3..3")).len(), 4);
}

/// Newton's method on Euler's quintics in 40 digits (mpmath), and equilateral triangles.
#[test]
fn the_five_points_of_lagrange() {
    let found = of_file("lagrange_points", &[], "x=-2..2, y=-2..2");
    let h = 0.75_f64.sqrt();
    assert_near(
        &found,
        &[
            &[-1.005_062_401_820_498_6, 0.0],
            &[0.487_85, -h],
            &[0.487_85, h],
            &[0.836_918_007_316_930_4, 0.0],
            &[1.155_679_913_094_735_4, 0.0],
        ],
    );
    let stable = found.equilibria.iter().map(|own| own.stability == Stability::Stable);
    assert_eq!(stable.collect::<Vec<_>>(), [false, true, true, false, false]);
    // Equal masses: by symmetry.
    let found = of_file("lagrange_points", &["mu = 1/2"], "x=-2..2, y=-2..2");
    assert_eq!(points(&found).len(), 5);
    // A moon of a millionth, whose poles are close together beside the box.
    let found = of_file("lagrange_points", &["mu = 1e-6"], "x=-2..2, y=-2..2");
    assert_eq!(points(&found).len(), 5);
}

/// At 0 and -2/3 of the coefficient: as near as doubles tell, and once each.
#[test]
fn equilibria_may_lie_close_together() {
    for exponent in 4..=12 {
        let found = of(&format!("coord x  T = 1/2*x'^2  V = 1e-{exponent}*x^2 + x^3"), "x=-1..1");
        let near = -2.0 / 3.0 * 10.0_f64.powi(-exponent);
        let points = points(&found);
        assert_eq!(points.len(), 2, "{points:?}");
        assert!((points[0][0] / near - 1.0).abs() < 1e-14 && points[1][0] == 0.0, "{points:?}");
    }
    // One that is no simple zero is not decided, but found.
    let flat = of("coord x, y  T = 1/2*(x'^2 + y'^2)  V = x^4 + y^2", "x=-1..1, y=-1..1");
    assert_eq!((flat.equilibria.len(), flat.complete), (1, false));
}

/// mpmath.findroot in 40 digits.
#[test]
fn the_surface_of_muller_and_brown() {
    let found = of_file("muller_brown", &[], "x=-1.5..1.2, y=-0.2..2");
    assert_near(
        &found,
        &[
            &[-0.822_001_558_732_732_1, 0.624_312_802_814_871_4],
            &[-0.558_223_634_633_024_3, 1.441_725_841_804_668_7],
            &[-0.050_010_822_998_206_06, 0.466_694_104_871_972_1],
            &[0.212_486_582_000_662_07, 0.292_988_325_107_367_8],
            &[0.623_499_404_930_876_5, 0.028_037_758_528_685_67],
        ],
    );
    let stable = found.equilibria.iter().map(|own| own.stability == Stability::Stable);
    assert_eq!(stable.collect::<Vec<_>>(), [false, true, true, false, true]);
}

#[test]
fn beads_wells_trusses_and_magnets() {
    let side = (9.81_f64 / (0.2 * 100.0)).acos();
    use std::f64::consts::PI;
    assert_near(&of_file("bead_on_hoop", &[], "th=-pi..pi"), &[&[-PI], &[-side], &[0.0], &[side], &[PI]]);
    assert_near(&of_file("bead_on_hoop", &["W = 5"], "th=-pi..pi"), &[&[-PI], &[0.0], &[PI]]);
    let root = 1.5_f64.sqrt();
    let well = "param a = 3 param b = 2 coord x T = 1/2*x'^2 V = -1/2*a*x^2 + 1/4*b*x^4";
    assert_near(&of(well, "x=-3..3"), &[&[-root], &[0.0], &[root]]);
    assert_near(&of_file("von_mises_truss", &[], "y=-2..2"), &[&[-0.5], &[0.0], &[0.5]]);
    assert_eq!(points(&of_file("von_mises_truss", &["P = 1/5"], "y=-2..2")).len(), 1);
    let d = (1.0 - 0.4_f64.sqrt()).sqrt();
    let magnets = of_file("magnets", &[], "x=-0.9..0.9");
    assert_near(&magnets, &[&[-d], &[0.0], &[d]]);
}

/// The closed forms of James (1998) for two and three ions on a line.
#[test]
fn ions_repel_each_other() {
    let a = 0.25_f64.cbrt();
    assert_near(&of_file("two_ions", &[], "x=-2..2"), &[&[-a, a], &[a, -a]]);
    // Along y the distance d is 2/(2 k) to the third, with k = 2.
    let plane = of_file("ions_in_a_plane", &["N = 2"], "r=-2..2");
    assert_near(&plane, &[&[-a, 0.0, a, 0.0], &[0.0, -0.5, 0.0, 0.5], &[0.0, 0.5, 0.0, -0.5], &[a, 0.0, -a, 0.0]]);
    let stable = plane.equilibria.iter().map(|own| own.stability == Stability::Stable);
    assert_eq!(stable.collect::<Vec<_>>(), [true, false, false, true]);
    let three = "coord x[1..3] T = sum(i in 1..3, 1/2*x[i]'^2)
        V = sum(i in 1..3, 1/2*x[i]^2) + sum(i in 1..3, j in i+1..3, 1/abs(x[j] - x[i]))";
    let three = of(three, "x=-3..3");
    let end = 1.25_f64.cbrt();
    assert_eq!(points(&three).len(), 6);
    assert!(points(&three).iter().all(|own| own.iter().any(|x| (x.abs() - end).abs() < 1e-15) && own.contains(&0.0)));
    // In a plane: lines and triangles, each in every order and from both sides.
    let plane = of_file("ions_in_a_plane", &[], "r=-2..2");
    assert!(plane.complete && points(&plane).len() == 36, "{:?}", plane.reasons);
    for own in points(&plane) {
        let swapped: Vec<f64> = [2, 3, 0, 1, 4, 5].map(|at| own[at]).to_vec();
        let mirrored: Vec<f64> = own.iter().enumerate().map(|(at, x)| if at % 2 == 1 { -x } else { *x }).collect();
        for image in [swapped, mirrored] {
            let near = |other: &Vec<f64>| other.iter().zip(&image).all(|(x, y)| (x - y).abs() < 1e-12);
            assert!(points(&plane).iter().any(near), "{image:?}");
        }
        assert!(force_on_ions(&own, 2.0) < 1e-12, "{own:?}");
    }
    let lines = points(&plane).into_iter().filter(|own| [1, 3, 5].iter().all(|at| own[*at].abs() < 1e-12));
    assert_eq!(lines.count(), 6);
}

/// The largest force on an ion, by the formula itself; the trap has the stiffness 1 along x and another along y.
fn force_on_ions(at: &[f64], along_y: f64) -> f64 {
    let force = |i: usize| {
        let others = (0..at.len() / 2).filter(|j| *j != i / 2).map(|j| {
            let [dx, dy] = [0, 1].map(|axis| at[2 * (i / 2) + axis] - at[2 * j + axis]);
            (if i.is_multiple_of(2) { dx } else { dy }) / dx.hypot(dy).powi(3)
        });
        (if i.is_multiple_of(2) { 1.0 } else { along_y }) * at[i] - others.sum::<f64>()
    };
    (0..at.len()).map(|i| force(i).abs()).fold(0.0, f64::max)
}

/// Three and four ions in a round trap, each in every order: lines (James, 1998), a triangle, a square, a triangle about one ion, and between
/// these two a kite. One of each is searched for: the ion that is farthest from the centre lies on an axis.
#[test]
fn ions_change_places_in_a_round_trap() {
    let square = (0.25 + 0.5_f64.sqrt()).cbrt();
    let about = (1.0 + 1.0 / 3.0_f64.sqrt()).cbrt();
    for (count, kinds) in [
        ("N = 3", vec![(2, (1.0 / 3.0_f64.sqrt()).cbrt()), (3, 1.25_f64.cbrt())]),
        ("N = 4", vec![(6, square), (8, about), (12, 1.436_801_991_924_17), (24, 1.180_469_336_287_6)]),
    ] {
        let found = of_file("ions_in_a_plane", &[count, "k = 1"], "r=-2..2");
        assert!(found.undecided.is_empty() && found.reasons.len() == 1, "{:?}", found.reasons);
        let point = |own: &Equilibrium| own.point.iter().map(|x| x.mid_f64()).collect();
        let points: Vec<Vec<f64>> = found.equilibria.iter().map(point).collect();
        assert!(points.iter().all(|own| force_on_ions(own, 1.0) < 1e-12));
        let largest = |own: &Vec<f64>| own.chunks(2).map(|r| r[0].hypot(r[1])).fold(0.0, f64::max);
        assert_eq!(points.len(), kinds.iter().map(|kind| kind.0).sum::<usize>());
        for (times, radius) in kinds {
            let own = points.iter().filter(|own| (largest(own) - radius).abs() < 1e-12);
            assert_eq!(own.count(), times, "{count}: {radius}; {:?}", points.iter().map(largest).collect::<Vec<_>>());
        }
    }
}

/// Singular points are no equilibria, and what is beside them is excluded.
#[test]
fn poles_are_excluded() {
    for (potential, count) in [
        ("x^2/2 - ln(x)", 1),
        ("1/x + x", 2),
        ("abs(x)", 0),
        // Beside the corner the rest of the forces is larger than that of the corner.
        ("abs(x) + (x - 1)^2", 1),
        ("1/sin(x)", 2),
        ("x^2/2 + 1/abs(x - 1)", 2),
        ("1/2*(sqrt(x^2 + 1) - 3)^2", 3),
        ("x + 1/x^2", 1),
        ("sqrt(x)*(x - 1)", 1),
    ] {
        let found = of(&format!("coord x T = 1/2*x'^2 V = {potential}"), "x=-3.1..3.1");
        assert_eq!(points(&found).len(), count, "{potential}");
    }
    for (potential, count) in
        [("1/2*(sqrt(x^2 + y^2) - 1)^2 + y/10", 2), ("-1/sqrt(x^2 + y^2) + x + y/2", 1), ("ln(x^2 + y^2) + x^2 + y", 1)]
    {
        let found = of(&format!("coord x, y T = 1/2*(x'^2 + y'^2) V = {potential}"), "x=-3..3, y=-4..4");
        assert_eq!(points(&found).len(), count, "{potential}");
    }
}

#[test]
fn constraints_have_bounded_multipliers() {
    let circle = "param l = 2 coord x, y T = 1/2*(x'^2 + y'^2) V = 9*y constraint x^2 + y^2 = l^2";
    assert_near(&of(circle, "x=-3..3, y=-3..3"), &[&[0.0, -2.0], &[0.0, 2.0]]);
    // The nearest and furthest points of an ellipse: four of them from (1/10, 0).
    let ellipse = "coord x, y T = 1/2*(x'^2 + y'^2) V = (x - 1/10)^2 + y^2 constraint x^2/4 + y^2 = 1";
    let ellipse = of(ellipse, "x=-3..3, y=-3..3");
    let (x, y) = (2.0 / 15.0, (1.0_f64 - 1.0 / 225.0).sqrt());
    assert_near(&ellipse, &[&[-2.0, 0.0], &[x, -y], &[x, y], &[2.0, 0.0]]);
}

/// What is not isolated is said, with one of them.
#[test]
fn families_are_not_counted() {
    for (text, ranges, said) in [
        ("coord x T = 1/2*x'^2", "x=-2..2", "nothing depends on `x`"),
        ("param k = 0 coord x, y T = 1/2*(x'^2 + y'^2) V = k*x^2", "x=-1..2, y=0..1", "nothing depends on `x`"),
        ("coord x, y T = 1/2*(x'^2 + y'^2) V = x^2", "x=-1..2, y=-1..1", "nothing depends on `y`"),
        ("coord x, y T = 1/2*(x'^2 + y'^2) V = x^2", "x=-1..2", "nothing depends on `y`"),
        ("coord x, y T = 1/2*(x'^2 + y'^2) V = (x - y - 1)^2", "x=-1..2, y=-1..2", "moving x, y together"),
        ("coord x, y T = 1/2*(x'^2 + y'^2) V = (x^2 + y^2 - 1)^2", "x=-2..2, y=-2..2", "not isolated"),
    ] {
        let found = of(text, ranges);
        assert!(!found.complete && !found.equilibria.is_empty(), "{text}");
        assert!(found.reasons.iter().any(|reason| reason.contains(said)), "{text}: {:?}", found.reasons);
        assert!(found.equilibria.iter().any(|own| own.isolated == Some(false)), "{text}");
        assert!(found.decided && found.undecided.is_empty(), "{text}");
    }
    // No equilibrium at all: nothing is left open.
    assert!(points(&of("coord x, y T = 1/2*(x'^2 + y'^2) V = x", "x=-1..2, y=-1..1")).is_empty());
    // The centre turns into itself.
    assert_near(&of("coord x, y T = 1/2*(x'^2 + y'^2) V = x^2 + y^2", "x=-1..2, y=-1..1"), &[&[0.0, 0.0]]);
    // Degenerate, but alone: the first derivative that is not 0 has one sign all around.
    for (well, others) in [("x^4", 0), ("cosh(x) - 1 - x^2/2", 0), ("x^3", 0), ("x^6 - x^4", 2), ("(x - 1)^4", 0)] {
        let found = of(&format!("coord x T = 1/2*x'^2 V = {well}"), "x=-2..2");
        assert!(found.complete && found.equilibria.len() == 1 + others, "{well}: {found:?}");
        assert!(found.equilibria.iter().all(|own| own.isolated == Some(true)), "{well}");
    }
    // A second one is behind a kink, nearer than pieces are small.
    let kink = of("coord x T = 1/2*x'^2 V = x^4 - 2^-140*(x + abs(x - 2^-50))", "x=-1..1");
    assert!(!kink.complete && !kink.decided && kink.undecided.len() == 1);
    // Of several coordinates, and beside a kink, nothing tells that it is.
    for text in
        ["coord x, y T = 1/2*(x'^2 + y'^2) V = x^4 + y^2", "coord x, y T = 1/2*(x'^2 + y'^2) V = abs(x)*x^3 + y^2"]
    {
        let quartic = of(text, "x=-1..2, y=-1..2");
        assert!(!quartic.complete && quartic.equilibria.len() == 1 && quartic.undecided.len() == 1);
        assert!(quartic.reasons.iter().all(|reason| !reason.contains("not isolated")), "{:?}", quartic.reasons);
        assert_eq!(quartic.equilibria[0].isolated, None);
    }
}

/// What rotations carry about is found once, on an axis and in a plane; the centre is alone.
#[test]
fn rotations_carry_families() {
    let ions = "coord r[1..2, 1..3]  T = 1/2*dot(r[1]', r[1]') + 1/2*dot(r[2]', r[2]')
        V = 1/2*dot(r[1], r[1]) + 1/2*dot(r[2], r[2]) + 1/norm(r[1] - r[2])";
    // Each ion is held by 1/(2 x)^2 = x; the place where both are one is no equilibrium, but takes an infinite force to tell.
    let x = 0.25_f64.cbrt();
    let hat = "T = 1/2*(x'^2 + y'^2 + z'^2)  V = (x^2 + y^2 + z^2 - 1)^2";
    let beside = |stiffness: &str| {
        format!(
            "coord r[1..2, 1..2]  let s[i in 1..2] = dot(r[i], r[i])  T = sum(i in 1..2, 1/2*dot(r[i]', r[i]'))
            V = sum(i in 1..2, {stiffness}*s[i] + s[i]^2/2) + 1/2*(dot(r[2] - r[1], r[2] - r[1]) - 2)^2"
        )
    };
    // 2 (s - 1) = 3/100 s²
    let at_hat = ((2.0 - (4.0_f64 - 0.24).sqrt()) / 0.06).sqrt();
    let ring = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = (x^2 + y^2 - 7.9)^2";
    for (text, ranges, radii) in [
        (format!("coord x, y, z  {hat}"), "x=-2..2, y=-2..2, z=-2..2", vec![0.0, 1.0]),
        (format!("coord r[1..3]  let x = r[1]  let y = r[2]  let z = r[3]  {hat}"), "r=-2..2", vec![0.0, 1.0]),
        (ions.to_owned(), "r=-2..2", vec![2.0_f64.sqrt() * x]),
        // With one at the centre the other has a place where all forces vanish but one on the first across its axis.
        (beside("1.3"), "r=-2..2", vec![0.0, 0.6_f64.sqrt()]),
        (beside("1.3*i"), "r=-2..2", vec![0.0, 0.713_652_709_113_36]),
        (format!("coord x, y, z  {hat} - (x^2 + y^2 + z^2)^3/100"), "x=-2..2, y=-2..2, z=-2..2", vec![0.0, at_hat]),
        // In the corners of the box alone, and not there.
        (ring.to_owned(), "x=-2..2, y=-2..2", vec![0.0, 7.9_f64.sqrt()]),
        (ring.to_owned(), "x=-1.9..1.9, y=-1.9..1.9", vec![0.0]),
    ] {
        let found = of(&text, ranges);
        let size = |own: &Equilibrium| own.point.iter().map(|x| x.mid_f64().powi(2)).sum::<f64>().sqrt();
        let mut sizes: Vec<f64> = found.equilibria.iter().map(size).collect();
        sizes.sort_by(f64::total_cmp);
        assert_eq!(sizes.len(), radii.len(), "{text}: {sizes:?}");
        assert!(sizes.iter().zip(&radii).all(|(own, radius)| (own - radius).abs() < 1e-12), "{text}: {sizes:?}");
        for own in &found.equilibria {
            assert_eq!(own.isolated, Some(size(own) < 1e-12), "{text}");
        }
        assert_eq!(
            found.reasons.iter().any(|own| own.contains("rotation")),
            radii.iter().any(|own| *own > 0.0),
            "{text}"
        );
    }
    // Forces without torque need not turn with the bodies.
    let straight = of(
        "coord x, y  T = 1/2*(x'^2 + y'^2)  V = (x^2 + y^2 - 1)^2  force x = -x*(x - 1/2)  force y = -y*(x - 1/2)",
        "x=-2..2, y=-2..2",
    );
    assert!(!straight.complete && straight.reasons.iter().all(|own| !own.contains("rotation")), "{straight:?}");
    // Rings above each other, and what lies on the axis.
    let rings = of(
        "coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)  V = (x^2 + y^2 - 1)^2 + (z^2 - 1)^2",
        "x=-2..2, y=-2..2, z=-2..2",
    );
    let sizes = rings
        .equilibria
        .iter()
        .map(|own| (own.point[0].mid_f64().hypot(own.point[1].mid_f64()), own.point[2].mid_f64()));
    let mut sizes: Vec<(i64, i64)> = sizes.map(|(r, z)| (r.round() as i64, z.round() as i64)).collect();
    sizes.sort_unstable();
    assert_eq!(sizes, [(0, -1), (0, 0), (0, 1), (1, -1), (1, 0), (1, 1)]);
    // A box that is no square, a force that knows a direction, and a motor: nothing turns.
    let bowl = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = x^2 + y^2";
    for text in [bowl.to_owned(), format!("{bowl} - x"), format!("{bowl}  force x = y  force y = 3*x")] {
        assert_eq!(points(&of(&text, "x=-1..1, y=-1..1")).len(), 1, "{text}");
    }
}

#[test]
fn boxes_that_are_none() {
    let model = common::model("coord x[1..2], y T = 1/2*(x[1]'^2 + x[2]'^2 + y'^2) V = x[1]^2 + x[2]^2 + y^2");
    let code = |ranges: &str| {
        let found = Region::parse(ranges, &model).and_then(|region| find(&model, &region));
        found.err().map(|error: EquilibriaError| error.code())
    };
    for (ranges, expected) in [
        ("x=-1..1, y=-1..1", None),
        ("x[1]=-1..1, x[2]=-sqrt(2)..pi, y=-1..1", None),
        ("", Some("E0723")),
        ("x=-1..1", Some("E0723")),
        ("x[1]=-1..1, y=-1..1", Some("E0723")),
        ("x=-1..1, y=-1..1, z=0..1", Some("E0721")),
        ("x[3]=-1..1", Some("E0721")),
        ("x=-1..1, y=1..-1", Some("E0722")),
        ("x=-1..1, y=1..1", None),
        ("x=-1..1, y=-1..inf", Some("E0722")),
        ("x=-1..1, y=-1..1/0", Some("E0720")),
        ("x=-1..1, x[1]=0..1, y=-1..1", Some("E0720")),
        ("x=-1, y=-1..1", Some("E0720")),
        ("x", Some("E0720")),
        ("x=-1..k, y=-1..1", Some("E0720")),
    ] {
        assert_eq!(code(ranges), expected, "{ranges}");
    }
}

/// A closed range of one value holds what lies at it.
#[test]
fn boxes_of_one_point() {
    let text = "coord x T = 1/2*x'^2 V = x^4/4 - x^2/2";
    assert_near(&of(text, "x=1..1"), &[&[1.0]]);
    assert!(points(&of(text, "x=1.0000001..1.0000001")).is_empty());
    assert_near(&of("coord x T = 1/2*x'^2 V = -cos(x)", "x=pi..pi"), &[&[std::f64::consts::PI]]);
    assert_near(
        &of("coord x, y T = 1/2*(x'^2 + y'^2) V = x^4/4 - x^2/2 + y^2", "x=-1..1, y=0..0"),
        &[&[-1.0, 0.0], &[0.0, 0.0], &[1.0, 0.0]],
    );
}

/// In units of the coordinates.
#[test]
fn boxes_are_in_the_units_of_the_file() {
    let text = "param g : m/s^2 = 9.81 param m : kg = 1 param l : m = 1 coord phi : deg, x : cm
        T = 1/2*m*(l^2*phi'^2 + x'^2) V = -m*g*l*cos(phi) + 1/2*m*g/l*(x - 0.05*l)^2";
    let found = of(text, "phi=-90..180, x=4..6");
    assert_near(&found, &[&[0.0, 0.05], &[std::f64::consts::PI, 0.05]]);
    assert!(points(&of(text, "phi=-90..180, x=0..1")).is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    /// F = ∏ (x - r): every planted root is found, none else, however they lie.
    #[test]
    fn planted_roots_are_found(roots in proptest::collection::btree_set(-40_i32..40, 1..6)) {
        let factors: Vec<String> = roots.iter().map(|r| format!("(x - ({r})/10)")).collect();
        let text = format!("coord x T = 1/2*x'^2 V = 0*x force x = {}", factors.join("*"));
        let found = of(&text, "x=-4..4");
        let expected: Vec<f64> = roots.iter().map(|r| f64::from(*r) / 10.0).collect();
        let own: Vec<f64> = points(&found).iter().map(|own| own[0]).collect();
        prop_assert_eq!(own.len(), expected.len());
        for (x, y) in own.iter().zip(&expected) {
            prop_assert!((x - y).abs() < 1e-14);
        }
    }

    /// Random quartic surfaces: wherever Newton's method in doubles ends inside the box, that is one of those found.
    #[test]
    fn nothing_that_newton_finds_is_missing(c in proptest::collection::vec(-3_i32..=3, 8), seed in 0_u32..1000) {
        let terms = ["x", "y", "x^2", "x*y", "y^2", "x^3", "x^2*y", "x*y^2"];
        let sum: Vec<String> = terms.iter().zip(&c).map(|(term, c)| format!("({c})*{term}")).collect();
        let text = format!("coord x, y T = 1/2*(x'^2 + y'^2) V = x^4 + y^4 + {}", sum.join(" + "));
        let found = of(&text, "x=-2..2, y=-2..2");
        let c: Vec<f64> = c.iter().map(|c| f64::from(*c)).collect();
        let mut state = u64::from(seed) + 1;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 * 4.0 - 2.0
        };
        for _ in 0..60 {
            let (mut x, mut y) = (random(), random());
            let mut step = f64::INFINITY;
            for _ in 0..60 {
                let fx = 4.0 * x.powi(3) + c[0] + 2.0 * c[2] * x + c[3] * y + 3.0 * c[5] * x * x + 2.0 * c[6] * x * y + c[7] * y * y;
                let fy = 4.0 * y.powi(3) + c[1] + c[3] * x + 2.0 * c[4] * y + c[6] * x * x + 2.0 * c[7] * x * y;
                let xx = 12.0 * x * x + 2.0 * c[2] + 6.0 * c[5] * x + 2.0 * c[6] * y;
                let xy = c[3] + 2.0 * c[6] * x + 2.0 * c[7] * y;
                let yy = 12.0 * y * y + 2.0 * c[4] + 2.0 * c[7] * x;
                let det = xx * yy - xy * xy;
                let (dx, dy) = ((yy * fx - xy * fy) / det, (xx * fy - xy * fx) / det);
                (x, y) = (x - dx, y - dy);
                step = dx.hypot(dy);
            }
            if step < 1e-12 && x.abs() < 2.0 && y.abs() < 2.0 {
                let near = |point: &[f64]| (point[0] - x).abs() < 1e-6 && (point[1] - y).abs() < 1e-6;
                let known = found.equilibria.iter().any(|own| near(&[own.point[0].mid_f64(), own.point[1].mid_f64()]));
                let open = found.undecided.iter().any(|own| {
                    (own.point[0] - x).abs() <= own.radius + 1e-6 && (own.point[1] - y).abs() <= own.radius + 1e-6
                });
                prop_assert!(known || open, "{} {} {}", text, x, y);
            }
        }
    }
}

/// A family that lies beside the box but for a corner of it is not called absent; one that is too large, or too far away, is.
#[test]
fn families_that_may_reach_the_box() {
    let pair = "coord r[1..2, 1..3]  T = sum(a in 1..2, 1/2*dot(r[a]', r[a]'))";
    let well = "coord r[1..3]  T = 1/2*dot(r', r')";
    let plane = "coord x[1..4]  T = 1/2*dot(x', x')
        V = 1/2*(-2*x[1] - 3*x[2] - 3*x[3] - 3*x[4] - 4.3)^2 + 1/2*(-3*x[1] + 2*x[2] - 2*x[3] + x[4] + 1.7)^2";
    for (text, ranges, is_open) in [
        // 0.967 (1, 1, 1) and its opposite are inside, and 0.99 (1, 1, 1).
        (format!("{pair}  V = 1/2*(norm(r[2] - r[1]) - 3.35)^2"), "r=-1..1", true),
        (format!("{pair}  V = 1/2*(norm(r[2] - r[1]) - 3.47)^2"), "r=-1..1", false),
        (format!("{well}  V = (dot(r, r) - 2.95)^2"), "r=-1..1", true),
        (format!("{well}  V = (dot(r, r) - 3.01)^2"), "r=-1..1", false),
        (plane.to_owned(), "x=-1..1", true),
        ("coord x, y  T = 1/2*(x'^2 + y'^2)  V = (x - y - 3)^2".to_owned(), "x=-1..1, y=-1..1", false),
    ] {
        let found = of(&text, ranges);
        let others = found.equilibria.iter().filter(|own| own.isolated != Some(true)).count();
        assert_eq!(!found.complete, is_open, "{text}: {found:?}");
        assert!(is_open || others == 0, "{text}: {found:?}");
    }
}
