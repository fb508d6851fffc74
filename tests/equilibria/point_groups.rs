//! Point groups of molecules and the classes of their modes, against the reductions that books give, and models that only
//! seem to have them.
#![cfg(feature = "engine")]

use std::collections::BTreeMap;

use librate::linearize::linearize;
use librate::model::{Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::{NormalModes, normal_modes};
use librate::syntax::parse;

fn modes(text: &str) -> NormalModes {
    let file = parse(text).unwrap_or_else(|_| panic!("{text}"));
    let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap_or_else(|_| panic!("{text}"));
    normal_modes(&linearize(model).unwrap(), &Options::default()).unwrap()
}

/// The classes of x, y and z and of the turns about them in the tables of characters (Wilson, Decius and Cross, Molecular
/// Vibrations, appendix X), of bodies in space.
fn of_drifts(group: &str) -> &'static str {
    match group {
        "C2" => "2 A + 4 B",
        "C3" => "2 A + 2 E",
        "Cs" => "3 A' + 3 A''",
        "C2v" => "A1 + A2 + 2 B1 + 2 B2",
        "C3v" => "A1 + A2 + 2 E",
        "C∞v" => "2 Π + Σ+",
        "C2h" => "Ag + Au + 2 Bg + 2 Bu",
        "D3" => "2 A2 + 2 E",
        "D2d" => "A2 + B2 + 2 E",
        "D3d" => "A2g + A2u + Eg + Eu",
        "D4d" => "A2 + B2 + E1 + E3",
        "D2h" => "B1g + B1u + B2g + B2u + B3g + B3u",
        "D3h" => "A2' + A2'' + E' + E''",
        "D4h" => "A2g + A2u + Eg + Eu",
        "D6h" => "A2g + A2u + E1g + E1u",
        "D∞h" => "Πg + Πu + Σu+",
        "T" => "2 T",
        "Td" => "T1 + T2",
        "Ih" => "T1g + T1u",
        other => panic!("{other} is not in the table"),
    }
}

/// The group and how many vibrations there are of each class: `C3v: 2 A1 + 2 E`; `?` are those without. Those of a free body's
/// drifts are held against the table.
fn reduced(text: &str) -> String {
    let found = modes(text);
    let drifts = found.modes.iter().filter(|mode| mode.omega.mid_f64() == 0.0).count();
    if let Some(group) = found.point_group.as_deref().filter(|_| drifts >= 5) {
        assert_eq!(counted(&found, text, |omega| omega == 0.0), of_drifts(group), "{group}: {text}");
    }
    let vibrations = counted(&found, text, |omega| omega > 0.0);
    format!("{}: {vibrations}", found.point_group.as_deref().unwrap_or("-"))
}

/// How many modes there are of each class among those with some frequencies.
fn counted(found: &NormalModes, text: &str, is_meant: impl Fn(f64) -> bool) -> String {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for mode in found.modes.iter().filter(|mode| is_meant(mode.omega.mid_f64())) {
        *counts.entry(mode.symmetry.clone().unwrap_or_else(|| "?".to_owned())).or_default() += 1;
    }
    let terms = counts.into_iter().map(|(name, vectors)| {
        let together = match name.chars().next() {
            Some('E' | 'Π') => 2,
            Some('T') => 3,
            Some('G') => 4,
            Some('H') => 5,
            _ => 1,
        };
        assert_eq!(vectors % together, 0, "{name} of {:?}: {text}", found.point_group);
        if vectors == together { name } else { format!("{} {name}", vectors / together) }
    });
    terms.collect::<Vec<String>>().join(" + ")
}

fn of_model(name: &str) -> String {
    reduced(&std::fs::read_to_string(format!("models/{name}.lag")).unwrap())
}

/// Springs between all bodies, at rest, those of one length alike; `more` is added to the energy.
fn springs(masses: &[&str], places: &[[&str; 3]], more: &str) -> String {
    let n = masses.len();
    let rows: Vec<String> = places.iter().map(|own| format!("[{}]", own.join(", "))).collect();
    format!(
        "param m[1..{n}] = [{}]  param c[1..{n}, 1..3] = [{}]
         coord r[1..{n}, 1..3]
         T = sum(a in 1..{n}, 1/2*m[a]*dot(r[a]', r[a]'))
         V = sum(a in 1..{n}, b in a+1..{n}, 1/2/(1 + dot(c[a] - c[b], c[a] - c[b]))*(norm(r[a] - r[b]) - norm(c[a] - c[b]))^2) {more}
         equilibrium r[a in 1..{n}] = c[a]",
        masses.join(", "),
        rows.join(", ")
    )
}

/// The squared volume of four bodies, which keeps them in a plane.
fn volume(bodies: [usize; 4]) -> String {
    let [a, b, c, d] = bodies;
    format!("+ 1/50*dot(cross(r[{b}] - r[{a}], r[{c}] - r[{a}]), r[{d}] - r[{a}])^2")
}

#[test]
fn the_models_are_reduced_as_in_books() {
    for (name, expected) in [
        ("water", "C2v: 2 A1 + B2"),
        ("ammonia", "C3v: 2 A1 + 2 E"),
        ("methane", "Td: A1 + E + 2 T2"),
        ("tetrahedron", "Td: A1 + E + T2"),
        ("co2", "D∞h: Πu + Σg+ + Σu+"),
        ("ethylene", "D2h: 3 Ag + Au + 2 B1u + B2g + 2 B2u + 2 B3g + B3u"),
        ("benzene", "D6h: 2 A1g + A2g + A2u + 2 B1u + 2 B2g + 2 B2u + E1g + 3 E1u + 4 E2g + 2 E2u"),
    ] {
        assert_eq!(of_model(name), expected, "{name}");
    }
}

/// A tetrahedron about a body of its own.
fn methane(masses: [&str; 5], more: &str) -> String {
    let corners = [["0", "0", "0"], ["1", "1", "1"], ["1", "-1", "-1"], ["-1", "1", "-1"], ["-1", "-1", "1"]];
    springs(&masses, &corners, more)
}

/// Two triangles about an axis through two bodies, the second turned.
fn ethane(degrees: u32) -> String {
    let turned = |k: u32, start: u32, z: &'static str| -> [String; 3] {
        let angle = format!("{}*pi/180", start + 120 * k);
        [format!("cos({angle})"), format!("sin({angle})"), z.to_owned()]
    };
    let lower = (0..3).map(|k| turned(k, 0, "-7/5"));
    let hydrogens: Vec<[String; 3]> = lower.chain((0..3).map(|k| turned(k, degrees, "7/5"))).collect();
    let mut places = vec![["0", "0", "-1"], ["0", "0", "1"]];
    places.extend(hydrogens.iter().map(|own| [own[0].as_str(), own[1].as_str(), own[2].as_str()]));
    springs(&["12", "12", "1", "1", "1", "1", "1", "1"], &places, "")
}

/// A body of one kind at each corner of a ring, in two heights in turn.
fn crown(n: u32, height: &str) -> String {
    let places: Vec<[String; 3]> = (0..n)
        .map(|k| {
            let sign = if k % 2 == 0 { "" } else { "-" };
            [format!("cos(2*pi*{k}/{n})"), format!("sin(2*pi*{k}/{n})"), format!("{sign}{height}")]
        })
        .collect();
    let places: Vec<[&str; 3]> = places.iter().map(|own| [0, 1, 2].map(|k| own[k].as_str())).collect();
    springs(&vec!["1"; n as usize], &places, "")
}

#[test]
fn other_groups_of_molecules() {
    // Wilson, Decius and Cross, Molecular Vibrations; Herzberg, Infrared and Raman Spectra, table 36.
    let allene = springs(
        &["12", "12", "12", "1", "1", "1", "1"],
        &[
            ["0", "0", "0"],
            ["0", "0", "1"],
            ["0", "0", "-1"],
            ["0.8", "0", "1.5"],
            ["-0.8", "0", "1.5"],
            ["0", "0.8", "-1.5"],
            ["0", "-0.8", "-1.5"],
        ],
        "",
    );
    assert_eq!(reduced(&allene), "D2d: 3 A1 + B1 + 3 B2 + 4 E");
    assert_eq!(reduced(&ethane(60)), "D3d: 3 A1g + A1u + 2 A2u + 3 Eg + 3 Eu");
    assert_eq!(reduced(&ethane(0)), "D3h: 3 A1' + A1'' + 2 A2'' + 3 E' + 3 E''");
    // Two triangles, one over the other but turned.
    let prism = "param l[1..3] = [sqrt(3 - 24/13), sqrt(3 + 12/13 + 5/13*sqrt(3)), sqrt(3 + 12/13 - 5/13*sqrt(3))]
        coord r[1..6, 1..3]
        let c[i in 1..3] = [cos(2*pi*i/3), sin(2*pi*i/3), 0]
        T = sum(a in 1..6, 1/2*dot(r[a]', r[a]'))
        V = sum(a in 1..3, 1/2*(norm(r[a] - r[mod(a, 3) + 1]) - sqrt(3))^2
            + 1/2*(norm(r[a + 3] - r[mod(a, 3) + 4]) - sqrt(3))^2)
          + sum(a in 1..3, k in 1..3, 1/k*(norm(r[a] - r[mod(a + k - 2, 3) + 4]) - l[k])^2)
        equilibrium r[a in 1..3] = c[a]
        equilibrium r[a in 4..6] = [12/13*c[a - 3][1] - 5/13*c[a - 3][2], 5/13*c[a - 3][1] + 12/13*c[a - 3][2], 1]";
    assert_eq!(reduced(prism), "D3: 3 A1 + A2 + 4 E");
    // Lengths of bonds that are equal are roots in roots, written in two ways.
    assert_eq!(reduced(&ethane(20)), "D3: 4 A1 + 2 A2 + 6 E");
    assert_eq!(reduced(&crown(8, "1/2")), "D4d: 2 A1 + B1 + B2 + 2 E1 + 3 E2 + 2 E3");
    // Xenon tetrafluoride, the corners on C2'; diimide; hydrogen peroxide.
    let square = [["0", "0", "0"], ["1", "0", "0"], ["0", "1", "0"], ["-1", "0", "0"], ["0", "-1", "0"]];
    let flat = [volume([1, 2, 3, 4]), volume([1, 3, 4, 5]), volume([1, 4, 5, 2]), volume([1, 5, 2, 3])].concat()
        + &volume([2, 3, 4, 5]);
    let tetrafluoride = springs(&["131", "19", "19", "19", "19"], &square, &flat);
    assert_eq!(reduced(&tetrafluoride), "D4h: A1g + A2u + B1g + B2g + B2u + 2 Eu");
    let diimide = [["0", "1/2", "0"], ["0", "-1/2", "0"], ["0.9", "0.8", "0"], ["-0.9", "-0.8", "0"]];
    let diimide = springs(&["14", "14", "1", "1"], &diimide, &volume([1, 2, 3, 4]));
    assert_eq!(reduced(&diimide), "C2h: 3 Ag + Au + 2 Bu");
    let peroxide = [["0", "0.7", "0"], ["0", "-0.7", "0"], ["0.8", "0.9", "0.5"], ["-0.8", "-0.9", "0.5"]];
    let peroxide = springs(&["16", "16", "1", "1"], &peroxide, "");
    assert_eq!(reduced(&peroxide), "C2: 4 A + 2 B");
    // Boron's twelve at the corners of an icosahedron.
    let golden = "(1 + sqrt(5))/2";
    let minus = format!("-{golden}");
    let mut corners = Vec::new();
    for a in ["1", "-1"] {
        for b in [golden, minus.as_str()] {
            corners.extend([["0", a, b], [a, b, "0"], [b, "0", a]]);
        }
    }
    assert_eq!(reduced(&springs(&["11"; 12], &corners, "")), "Ih: Ag + Gg + Gu + 2 Hg + Hu + T1u + T2u");
}

#[test]
fn isotopes_and_what_is_nearly_equal() {
    let h = ["12", "1", "1", "1", "1"];
    assert_eq!(reduced(&methane(h, "")), "Td: A1 + E + 2 T2");
    // Wilson, Decius and Cross, ch. 6: CH3D and CH2D2.
    assert_eq!(reduced(&methane(["12", "2", "1", "1", "1"], "")), "C3v: 3 A1 + 3 E");
    assert_eq!(reduced(&methane(["12", "2", "2", "1", "1"], "")), "C2v: 4 A1 + A2 + 2 B1 + 2 B2");
    assert_eq!(reduced(&methane(["12", "1", "2", "3", "3"], "")), "Cs: 6 A' + 3 A''");
    assert_eq!(reduced(&methane(["12", "1", "2", "3", "4"], "")), "-: 9 ?");
    // What is nearly of one frequency has shapes that mix both classes.
    for (heavier, expected) in [("1 + 1e-9", "C3v: 3 A1 + 3 E"), ("1 + 1e-40", "C3v: 6 ? + A1 + E")] {
        assert_eq!(reduced(&methane(["12", heavier, "1", "1", "1"], "")), expected);
    }
    for (farther, expected) in [("1 + 1e-9", "Cs: 4 A' + 2 A''"), ("1 + 1e-40", "Cs: 4 A' + 2 A''")] {
        let places = [["0", "0", "0.4"], [farther, "0", "0"], ["-1/2", "sqrt(3)/2", "0"], ["-1/2", "-sqrt(3)/2", "0"]];
        assert_eq!(reduced(&springs(&["14", "1", "1", "1"], &places, "")), expected);
    }
    // Out of the plane by so little.
    for height in ["1e-9", "1e-40"] {
        let places = [["0", "0", height], ["1", "0", "0"], ["-1/2", "sqrt(3)/2", "0"], ["-1/2", "-sqrt(3)/2", "0"]];
        assert_eq!(modes(&springs(&["14", "1", "1", "1"], &places, "")).point_group, None, "{height}");
    }
}

#[test]
fn forces_that_tell_left_from_right() {
    // Odd under every exchange of two corners, even under the turns; of third order, so that M and K are those of Td.
    let square = |a: usize, b: usize| format!("dot(r[{a}] - r[{b}], r[{a}] - r[{b}])");
    let [a, b, c] =
        [[2, 3, 4, 5], [2, 4, 3, 5], [2, 5, 3, 4]].map(|[i, j, k, l]| format!("({} + {})", square(i, j), square(k, l)));
    let chiral = format!("+ 1/100*({a} - {b})*({b} - {c})*({c} - {a})");
    assert_eq!(reduced(&methane(["12", "1", "1", "1", "1"], &chiral)), "T: A + E + 2 T");
    // One corner's bond is stiffer only beyond the second order.
    let cubic = "+ (norm(r[2] - r[1]) - sqrt(3))^3";
    assert_eq!(reduced(&methane(["12", "1", "1", "1", "1"], cubic)), "C3v: 6 ? + A1 + E");
    let both = format!("{chiral} {cubic}");
    assert_eq!(reduced(&methane(["12", "1", "1", "1", "1"], &both)), "C3: 6 ? + A + E");
}

#[test]
fn turned_and_shifted_the_names_are_the_same() {
    // A turn in fractions, with a shift.
    let turned = |text: &str| {
        let (axes, place) = ("[[1/3, -2/3, 2/3], [2/3, -1/3, -2/3], [2/3, 2/3, 1/3]]", "= c[a]");
        assert!(text.contains(place));
        let moved = text.replace(place, "= [5 + dot(R[1], c[a]), 7 + dot(R[2], c[a]), dot(R[3], c[a]) - 9]");
        format!("param R[1..3, 1..3] = {axes}\n{moved}")
    };
    let places = [["0", "0", "0.4"], ["1", "0", "0"], ["-1/2", "sqrt(3)/2", "0"], ["-1/2", "-sqrt(3)/2", "0"]];
    assert_eq!(reduced(&turned(&springs(&["14", "1", "1", "1"], &places, ""))), "C3v: 2 A1 + 2 E");
    let straight = [["0", "0", "-1"], ["0", "0", "0"], ["0", "0", "1"]];
    let bend = "+ 1/9*dot(cross(r[1] - r[2], r[3] - r[2]), cross(r[1] - r[2], r[3] - r[2]))";
    assert_eq!(reduced(&turned(&springs(&["16", "12", "16"], &straight, bend))), "D∞h: Πu + Σg+ + Σu+");
    assert_eq!(reduced(&turned(&springs(&["16", "12", "14"], &straight, bend))), "C∞v: Π + 2 Σ+");
    let flat = [["1", "0", "0"], ["-1", "0", "0"], ["0", "2", "0"], ["0", "-2", "0"]];
    let flat = springs(&["12", "12", "1", "1"], &flat, &volume([1, 2, 3, 4]));
    assert_eq!(reduced(&turned(&flat)), reduced(&flat));
}

#[test]
fn what_is_held_from_outside() {
    let places = [["0", "0", "0.4"], ["1", "0", "0"], ["-1/2", "sqrt(3)/2", "0"], ["-1/2", "-sqrt(3)/2", "0"]];
    let masses = ["14", "1", "1", "1"];
    // About the axis all turns as before; about an axis across one mirror does, and about another point than the origin nothing
    // is known to.
    let about_z = "+ 1/10*sum(a in 1..4, (r[a][3] - c[a][3])^2)";
    assert_eq!(reduced(&springs(&masses, &places, about_z)), "C3v: 3 A1 + 3 E");
    let across = "+ 1/10*sum(a in 1..4, (r[a][2] - c[a][2])^2)";
    assert_eq!(modes(&springs(&masses, &places, across)).point_group.as_deref(), Some("Cs"));
    let both = "+ 1/10*sum(a in 1..4, (r[a][2] - c[a][2])^2 + 2*(r[a][1] - c[a][1])^2)";
    assert_eq!(modes(&springs(&masses, &places, both)).point_group, None);
    let far = "+ 1/10*(norm(r[1] - [5, 7, 11]) - norm(c[1] - [5, 7, 11]))^2";
    assert_eq!(modes(&springs(&masses, &places, far)).point_group, None);
    // Ions in a trap, which are searched for: in space at the corners of a tetrahedron, in the plane of a triangle.
    // Their centre moves with the trap's own frequency, breathing is the root of 3 times as fast.
    let ions = |n: u32, width: u32, start: &str| {
        format!(
            "param c[1..{n}, 1..{width}] = {start}
             coord r[1..{n}, 1..{width}]
             T = sum(a in 1..{n}, 1/2*dot(r[a]', r[a]'))
             V = sum(a in 1..{n}, 1/2*dot(r[a], r[a])) + sum(a in 1..{n}, b in a+1..{n}, 1/norm(r[a] - r[b]))
             guess r[a in 1..{n}] = c[a]"
        )
    };
    let corners = "[[0.5, 0.6, 0.55], [0.6, -0.5, -0.6], [-0.5, 0.55, -0.6], [-0.6, -0.5, 0.5]]";
    assert_eq!(reduced(&ions(4, 3, corners)), "Td: A1 + E + 2 T2");
    assert_eq!(reduced(&ions(3, 2, "[[0.8, 0.1], [-0.4, 0.7], [-0.5, -0.6]]")), "C3v: A1 + 2 E");
    // In a trap that is not round the triangle has a mirror at most.
    let oval =
        ions(3, 2, "[[0.8, 0.1], [-0.4, 0.7], [-0.5, -0.6]]").replace("dot(r[a], r[a])", "(r[a][1]^2 + 1.1*r[a][2]^2)");
    assert_eq!(modes(&oval).point_group, None);
}

#[test]
fn rings_in_a_plane() {
    let ring = |n: u32| {
        format!(
            "coord r[1..{n}, 1..2]  T = sum(a in 1..{n}, 1/2*dot(r[a]', r[a]'))
             V = sum(a in 1..{n}, b in a+1..{n}, 1/2*(norm(r[a] - r[b]) - 2*sin(pi*(b - a)/{n}))^2/(1 + sin(pi*(b - a)/{n})))
             equilibrium r[a in 1..{n}] = [cos(2*pi*a/{n}), sin(2*pi*a/{n})]"
        )
    };
    assert_eq!(reduced(&ring(3)), "C3v: A1 + E");
    assert_eq!(reduced(&ring(5)), "C5v: A1 + E1 + 2 E2");
    assert_eq!(reduced(&ring(6)), "C6v: A1 + B1 + B2 + E1 + 2 E2");
}

#[test]
fn frequencies_that_agree_by_accident() {
    // With kb = k/3 A1 and E of methane have one frequency, and vectors of both mix: none is called by a false name.
    let methane = std::fs::read_to_string("models/methane.lag").unwrap().replace("k2 : N/m = 46", "k2 : N/m = 500/3");
    let found = modes(&methane);
    assert_eq!(found.point_group.as_deref(), Some("Td"));
    for mode in found.modes.iter().filter(|mode| mode.omega.mid_f64() > 0.0) {
        let square = mode.omega_squared.unwrap().mid_f64() * 1.008 * 1.66053906892e-27 / 500.0;
        let mixed = (square - 1.0).abs() < 1e-9;
        match mode.symmetry.as_deref() {
            Some("T2") => assert!(!mixed),
            Some("A1" | "E") | None => assert!(mixed),
            Some(other) => panic!("{other}"),
        }
    }
}
