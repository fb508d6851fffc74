//! Zero modes are shown with what they are, part by part where a model falls into several.
#![cfg(feature = "engine")]

use std::collections::BTreeMap;

use librate::linearize::{Linearized, linearize};
use librate::model::{Settings, TableTexts, elaborate};
use librate::modes::{Kind, Options, Stability};
use librate::number::Number;
use librate::oscillation::normal_modes;
use librate::precision::Big;
use librate::syntax::parse;
use librate_core::precision::Magnitude;

fn motions(text: &str) -> Vec<String> {
    let file = parse(text).unwrap();
    let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
    let linearized = linearize(model).unwrap();
    let modes = linearized.zero_modes();
    modes.into_iter().map(|mode| mode.meaning).collect()
}

/// Springs between all points of a range, at rest as given.
fn body(from: usize, to: usize) -> String {
    format!("sum(a in {from}..{to}, b in a+1..{to}, 1/2*(norm(r[a] - r[b]) - norm(rest[a] - rest[b]))^2)")
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
    assert_eq!(found, ["translation of x[1..3]", "translation of x[4..5]", "phi is free", "rotation of u, v",]);
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
    assert_eq!(found[3], "no restoring force to second order");
}

fn linearized(text: &str, rows: &str) -> Linearized {
    let file = parse(text).unwrap();
    let tables = TableTexts::new().with("k.csv", format!("i,j,v\n{rows}"));
    linearize(elaborate(&file, &tables, &Settings::new()).unwrap()).unwrap()
}

/// A model whose stiffness is a table of entries, with `more` in T.
fn of_entries(n: usize, entries: &Entries, more: &str) -> Linearized {
    let text = format!(
        "table k = \"k.csv\"  coord x[1..{n}]  T = sum(i in 1..{n}, 1/2*x[i]'^2) {more}
         V = sum(e in k, 1/2*e.v*x[e.i]*x[e.j])"
    );
    linearized(&text, &rows(entries))
}

type Entries = BTreeMap<(usize, usize), Number>;

/// Decimals of so many digits are all of those that are used here.
fn rows(entries: &Entries) -> String {
    let rows = entries.iter();
    rows.map(|((i, j), value)| format!("{i},{j},{}\n", value.to_decimal(60))).collect()
}

fn add(entries: &mut Entries, i: usize, j: usize, value: &Number) {
    let entry = entries.entry((i, j)).or_insert(Number::ZERO);
    *entry = entry.add(value);
}

/// What springs between neighbours add; `unit` is what a coordinate is measured in.
fn chain(sites: std::ops::Range<usize>, spring: &str, unit: impl Fn(usize) -> Number) -> Entries {
    let spring = Number::parse(spring).unwrap();
    let mut entries = Entries::new();
    for i in sites.start..sites.end - 1 {
        for (a, b) in [(i, i), (i, i + 1), (i + 1, i), (i + 1, i + 1)] {
            let value = spring.mul(&unit(a)).mul(&unit(b));
            add(&mut entries, a, b, &if a == b { value } else { value.neg() });
        }
    }
    entries
}

fn one(_: usize) -> Number {
    Number::from(1)
}

#[test]
fn a_free_chain_given_by_its_entries_is_free_at_any_size() {
    for n in [2, 60, 61, 1000, 4000] {
        let zeros = of_entries(n, &chain(1..n + 1, "0.7", one), "").zero_modes();
        assert_eq!(zeros.len(), 1, "{n}");
        assert!(zeros[0].vector.iter().all(|x| *x == zeros[0].vector[0]));
    }
}

/// omega_j = 2 sqrt(k) sin(pi j/2n), with and without a gyroscopic term, which turns no frequency of the rest into 0.
#[test]
fn modes_of_a_table_are_those_of_its_chain() {
    let n = 61;
    let entries = chain(1..n + 1, "1", one);
    let found = normal_modes(&of_entries(n, &entries, ""), &Options::default()).unwrap();
    assert_eq!(found.stability, Stability::Neutral);
    for (j, mode) in found.modes.iter().enumerate() {
        let expected = 2.0 * (std::f64::consts::PI * j as f64 / (2 * n) as f64).sin();
        assert!((mode.omega.mid_f64() - expected).abs() < 1e-9);
        assert_eq!(mode.kind == Kind::Zero, j == 0);
    }
    let turned = of_entries(n, &entries, "+ 1/2*(x[1]*x[2]' - x[2]*x[1]')");
    let found = normal_modes(&turned, &Options::default()).unwrap();
    assert_eq!(found.stability, Stability::Neutral);
    let zeros = found.modes.iter().filter(|mode| mode.kind == Kind::Zero);
    assert_eq!(zeros.count(), 1);
}

#[test]
fn several_bodies_in_a_table_are_each_free() {
    let mut entries = chain(1..41, "1", one);
    entries.extend(chain(41..101, "2", one));
    entries.extend(chain(101..104, "1e-30", one));
    assert_eq!(of_entries(103, &entries, "").zero_modes().len(), 3);
    // The least spring to a wall holds one of them.
    add(&mut entries, 50, 50, &Number::parse("1e-40").unwrap());
    assert_eq!(of_entries(103, &entries, "").zero_modes().len(), 2);
}

/// A kernel of fractions of many digits: in coordinates x/u the free chain moves as 1/u.
#[test]
fn the_motion_may_be_fractions_of_many_digits() {
    let unit = |i: usize| Number::ratio(1_000_000_007 + 7919 * (i * i) as i64, 1_000_000).unwrap();
    let n = 80;
    let zeros = of_entries(n, &chain(1..n + 1, "0.123456789", unit), "").zero_modes();
    assert_eq!(zeros.len(), 1);
    let vector = &zeros[0].vector;
    for i in 1..n {
        let ratio = vector[i].mid_f64() / vector[0].mid_f64();
        let expected = unit(1).to_f64() / unit(i + 1).to_f64();
        assert!((ratio / expected - 1.0).abs() < 1e-12, "{i}");
    }
}

/// A frame of bars between points of a 3 by 3 by 3 grid, its axes and the diagonals of its faces, as entries: rigid,
/// and free to move and turn six ways. Without the diagonals each of the 27 points has as many bars as a grid gives it.
#[test]
fn a_frame_in_space_is_free_six_ways() {
    let point = |a: usize| [a / 9, a / 3 % 3, a % 3].map(|x| x as i64);
    for (longest, zeros) in [(2, 6), (1, 81 - 54)] {
        let mut entries = Entries::new();
        for (a, b) in (0..27).flat_map(|a| (0..a).map(move |b| (a, b))) {
            let bar = [0, 1, 2].map(|axis| point(a)[axis] - point(b)[axis]);
            let square: i64 = bar.iter().map(|x| x * x).sum();
            if square > longest || bar.iter().any(|x| x.abs() > 1) {
                continue;
            }
            for (i, j) in (0..9).map(|at| (at / 3, at % 3)) {
                let value = Number::ratio(bar[i] * bar[j], square).unwrap();
                for (p, q, sign) in [(a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)] {
                    let value = value.mul(&Number::from(sign));
                    add(&mut entries, 3 * p + i + 1, 3 * q + j + 1, &value);
                }
            }
        }
        assert_eq!(of_entries(81, &entries, "").zero_modes().len(), zeros);
    }
}

/// K_ij/sqrt(m_i m_j), as weighted by masses: roots in every entry, and the motion sqrt(m).
#[test]
fn entries_may_be_roots_of_masses() {
    let n = 70;
    let found = linearized(
        &format!(
            "table k = \"k.csv\"  coord x[1..{n}]  param m[i in 1..{n}] = 2 + i/7 + 3*mod(i, 2)
             T = sum(i in 1..{n}, 1/2*x[i]'^2)
             V = sum(e in k, 1/2*e.v/sqrt(m[e.i]*m[e.j])*x[e.i]*x[e.j])"
        ),
        &rows(&chain(1..n + 1, "1", one)),
    );
    let zeros = found.zero_modes();
    assert_eq!(zeros.len(), 1);
    let mass = |i: usize| 2.0 + i as f64 / 7.0 + 3.0 * (i % 2) as f64;
    for i in 1..n {
        let ratio = zeros[0].vector[i].mid_f64() / zeros[0].vector[0].mid_f64();
        assert!((ratio - (mass(i + 1) / mass(1)).sqrt()).abs() < 1e-12);
    }
}

/// Springs of true length between neighbours of a lattice that is at rest as it is guessed, or drawn: with n by m
/// points 2 n m - n (m - 1) - m (n - 1) motions cost nothing on a square one; diagonals of unstretched triangles leave
/// three.
#[test]
fn a_lattice_at_rest_stays_where_it_is() {
    let square = |body: &str| {
        format!(
            "param n = 5  param m = 7  param a = 0.1  param d = 0.1
             {body}
             V = sum(i in 1..n-1, j in 1..m, 1/2*(norm(r[i+1,j] - r[i,j]) - d)^2)
               + sum(i in 1..n, j in 1..m-1, 1/2*(norm(r[i,j+1] - r[i,j]) - d)^2)"
        )
    };
    let guessed = square(
        "coord r[1..n, 1..m, 1..2]  guess r[i in 1..n, j in 1..m] = [i*a, j*a]
         T = sum(i in 1..n, j in 1..m, 1/2*dot(r[i,j]', r[i,j]'))",
    );
    let moved = |place: &str| {
        format!(
            "coord u[1..n, 1..m, 1..2]  T = sum(i in 1..n, j in 1..m, 1/2*dot(u[i,j]', u[i,j]'))
             let r[i in 1..n, j in 1..m] = {place} + u[i,j]"
        )
    };
    let drawn = square(&moved("[i*a, j*a]"));
    // Sides of triangles, sqrt(3)/2 high.
    let triangles = square(&moved("[i*a + j*a/2, j*a*sqrt(3)/2]"))
        + " + sum(i in 1..n-1, j in 1..m-1, 1/2*(norm(r[i+1,j] - r[i,j+1]) - d)^2)";
    let free = 2 * 35 - 5 * 6 - 7 * 4;
    for (text, zeros) in [(guessed, free), (drawn, free), (triangles, 3)] {
        let found = linearized(&text, "");
        assert!(found.equilibrium().proved && found.equilibrium().steps == 0);
        assert_eq!(found.zero_modes().len(), zeros, "{text}");
    }
}

/// A guess that is exactly right, though no double, stays so with all digits.
#[test]
fn a_guess_that_is_right_is_taken_exactly() {
    let found = linearized(
        "coord x, y  T = x'^2 + y'^2  V = (x^2 - 2)^2 + (3*y - 1)^4
         guess x = sqrt(2)  guess y = 1/3",
        "",
    );
    assert!(found.equilibrium().proved && found.equilibrium().steps == 0);
    let precise = found.precisely(512).unwrap();
    assert!(precise.equilibrium.iter().all(|x| x.to_ball().radius < 1e-30));
    // V'' = 8 x² = 16 for x.
    let stiffness = &precise.stiffness[0];
    assert!((stiffness - &Big::from_f64(16.0, 512)).abs_upper() < Magnitude::ONE.scale(-480));
    let zeros = found.zero_modes();
    assert_eq!(zeros.len(), 1);
    assert!(zeros[0].vector[0].is_zero());
}

/// Two masses on a rod in orbit about a centre, the angles of both in every term: nothing depends on that of the orbit.
/// However x and y enter, in a product or term by term.
#[test]
fn the_angle_of_an_orbit_stays_free() {
    let places = "param GM = 1  param l = 0.01  coord r, f, a
         let p = [r*cos(f) + l/2*cos(f + a), r*sin(f) + l/2*sin(f + a)]
         let q = [r*cos(f) - l/2*cos(f + a), r*sin(f) - l/2*sin(f + a)]
         equilibrium f' = 1  guess r = 1";
    let together = "T = 1/2*dot(p', p') + 1/2*dot(q', q')  V = -GM/norm(p) - GM/norm(q)";
    let apart = "T = 1/2*p[1]'^2 + 1/2*p[2]'^2 + 1/2*q[1]'^2 + 1/2*q[2]'^2
         V = -GM/sqrt(p[1]^2 + p[2]^2) - GM/sqrt(q[1]^2 + q[2]^2)";
    for energies in [together, apart] {
        let found = linearized(&format!("{places} {energies}"), "");
        assert!(found.equilibrium().proved, "{energies}");
        let modes = normal_modes(&found, &Options::default()).unwrap();
        assert_eq!(modes.stability, Stability::Neutral);
        assert_eq!(modes.modes[0].kind, Kind::Zero);
        assert_eq!(modes.zero_motions, ["f is free"]);
        // A rod that librates in its orbit: omega² = 3 to within (l/r)².
        assert!((modes.modes[2].omega.mid_f64() - 3.0_f64.sqrt()).abs() < 1e-3);
    }
}

/// Terms that change, while their sum doesn't.
#[test]
fn what_only_the_sum_of_terms_leaves_is_found() {
    let hat = "coord x, y  T = x'^2 + y'^2  V = x^4/4 + x^2*y^2/2 + y^4/4 - x^2/2 - y^2/2
         guess x = 0.3  guess y = 0.7";
    let found = linearized(hat, "");
    assert!(found.equilibrium().proved);
    assert_eq!(found.zero_modes().len(), 1);
    // Two parts that turn together alone: each pulls at the other's angle.
    let screw = "coord x[1..2], y[1..2]  T = x[1]'^2 + x[2]'^2 + y[1]'^2 + y[2]'^2
         V = (x[1]^2 + y[1]^2 - 1)^2 + (x[2]^2 + y[2]^2 - 1)^2
           + atan2(y[1], x[1]) - atan2(y[2], x[2])
         guess x[i in 1..2] = 1";
    let file = parse(screw).unwrap();
    let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
    let proved = linearize(model).is_ok_and(|found| found.equilibrium().proved);
    assert!(!proved, "a torque acts on each everywhere");
}

/// What is held by too few elements is found by counting, here by those that the end of a search leaves with a little stress.
/// Three atoms in a plane about a fourth, in coordinates along the bonds and across them: it moves and turns freely, and so does what has
/// twelve atoms, with sines and cosines of 30°, 45°, …
#[test]
fn angles_of_a_family_are_exact() {
    for n in [2, 3, 4, 6, 8, 12, 24] {
        let model = format!(
            "coord r[1..{n}], s[1..{n}], x, y
             let p[i in 1..{n}] = [(1 + r[i])*cos(2*pi*i/{n}) - s[i]*sin(2*pi*i/{n}),
                                   (1 + r[i])*sin(2*pi*i/{n}) + s[i]*cos(2*pi*i/{n})]
             T = sum(i in 1..{n}, dot(p[i]', p[i]')) + x'^2 + y'^2
             V = sum(i in 1..{n}, (norm(p[i] - [x, y]) - 1)^2)"
        );
        // Nothing holds the atoms across.
        assert_eq!(motions(&model).len(), n + 2, "{n}");
    }
}

#[test]
fn what_is_held_by_too_little_is_loose() {
    let count = |n: usize, elements: &[&str]| {
        let sum: Vec<String> = elements.iter().map(|s| format!("(exp({s}) - ({s}))")).collect();
        let text = format!("coord x[1..{n}]  T = sum(i in 1..{n}, 1/2*x[i]'^2)  V = {}", sum.join(" + "));
        motions(&text).len()
    };
    // A chain without walls, with one.
    assert_eq!(count(3, &["x[1] - x[2]", "x[2] - 2*x[3]"]), 1);
    assert_eq!(count(3, &["x[1] - x[2]", "x[2] - 2*x[3]", "x[3]"]), 0);
    // 4 and 5 hang on 3 by one element, while the rest has more than it needs.
    let held = ["x[1]", "x[1] - x[2]", "x[2]", "x[2] - x[3]", "x[3]"];
    assert_eq!(count(5, &[&held[..], &["sin(x[3] - 2*x[4] - x[5])"]].concat()), 1);
    assert_eq!(count(5, &held), 2);
}

/// What vanishes with the velocities is left out of the potential, what does not joins it.
#[test]
fn kinetic_terms_at_rest_join_the_potential() {
    let stiffness = |kinetic: &str| {
        let text = format!("param l = 2  coord q  T = {kinetic}  V = 2*q^2");
        let file = parse(&text).unwrap();
        let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
        linearize(model).map(|l| (l.mass()[0].mid_f64(), l.stiffness()[0].mid_f64()))
    };
    assert_eq!(stiffness("1/2*(l*cos(q)*q' + q')^2").unwrap(), (9.0, 4.0));
    assert_eq!(stiffness("1/2*(l*cos(q)*q' + q')^2 + cos(q)").unwrap(), (9.0, 5.0));
    // cos q/(l cos q + 1) is 0/0 at rest, not 0, and nothing is said of it.
    let (mass, _) = stiffness("1/2*q'^2 + cos(q)*q'/(l*cos(q)*q' + q')").unwrap();
    assert!(mass.is_nan());
}
