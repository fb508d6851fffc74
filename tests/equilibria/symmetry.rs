//! Random models with a symmetry that was put in: it is found, M and K fall apart exactly, and the modes
//! are what their labels say.
#![cfg(feature = "engine")]

use librate::derive::{Parts, derive};
use librate::linearize::linearize;
use librate::model::{Model, Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate::syntax::parse;
use librate_core::symmetry::{GroupKind, Pattern, SignedPermutation, Symmetry};
use proptest::prelude::*;

type Matrix = Vec<Vec<i64>>;

/// A signed permutation as images with signs.
type Element = Vec<(usize, i64)>;

fn after(g: &Element, h: &Element) -> Element {
    h.iter().map(|(j, s)| (g[*j].0, g[*j].1 * s)).collect()
}

/// All elements of a group.
fn group(generators: &[Element]) -> Vec<Element> {
    let n = generators[0].len();
    let mut all = vec![(0..n).map(|i| (i, 1)).collect::<Element>()];
    let mut next = 0;
    while next < all.len() {
        for g in generators {
            let product = after(g, &all[next]);
            if !all.contains(&product) {
                all.push(product);
            }
        }
        next += 1;
    }
    all
}

/// The sum of g A gᵀ over the group.
fn averaged(a: &Matrix, elements: &[Element]) -> Matrix {
    let n = a.len();
    let mut sum = vec![vec![0; n]; n];
    for g in elements {
        for i in 0..n {
            for j in 0..n {
                let ((p, s), (q, t)) = (g[i], g[j]);
                sum[p][q] += s * t * a[i][j];
            }
        }
    }
    sum
}

fn conjugated(g: &Element, by: &Element) -> Element {
    let mut inverse = vec![(0, 1); by.len()];
    for (i, (j, s)) in by.iter().enumerate() {
        inverse[*j] = (i, *s);
    }
    after(by, &after(g, &inverse))
}

fn pattern(mass: &Matrix, stiffness: &Matrix) -> Pattern {
    let n = mass.len();
    let mut pattern = Pattern::new(n);
    // Small whole numbers: a pair is a label by itself.
    let label = |m: i64, k: i64| m * 1_000_003 + k;
    for i in 0..n {
        let own = label(mass[i][i], stiffness[i][i]);
        pattern.set_diagonal(i, own.unsigned_abs(), stiffness[i][i] != 0);
        for j in (0..n).filter(|j| *j != i) {
            if (mass[i][j], stiffness[i][j]) != (0, 0) {
                pattern.push(i, j, label(mass[i][j], stiffness[i][j]), stiffness[i][j] != 0);
            }
        }
    }
    pattern
}

fn model(mass: &Matrix, stiffness: &Matrix) -> Model {
    let n = mass.len();
    let form = |a: &Matrix, dot: &str| {
        let mut terms = Vec::new();
        for (i, row) in a.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                if *value != 0 {
                    terms.push(format!("({value})/2*x[{}]{dot}*x[{}]{dot}", i + 1, j + 1));
                }
            }
        }
        terms.join(" + ")
    };
    let text = format!("coord x[1..{n}]\nT = {}\nV = {}", form(mass, "'"), form(stiffness, ""));
    elaborate(&parse(&text).unwrap(), &TableTexts::new(), &Settings::new()).unwrap()
}

/// Groups by name, on eight coordinates.
fn generators(which: usize) -> (Vec<Element>, f64) {
    let plain = |images: [usize; 8]| images.into_iter().map(|i| (i, 1)).collect::<Element>();
    match which {
        // A mirror with two coordinates on it.
        0 => (vec![plain([1, 0, 3, 2, 5, 4, 6, 7])], 2.0),
        // A mirror that turns the last coordinate around, and one more.
        1 => {
            let mut g = plain([1, 0, 3, 2, 5, 4, 6, 7]);
            g[7].1 = -1;
            g[4].1 = -1;
            g[5].1 = -1;
            (vec![g], 2.0)
        }
        // Two mirrors that commute.
        2 => (vec![plain([1, 0, 3, 2, 5, 4, 7, 6]), plain([2, 3, 0, 1, 6, 7, 4, 5])], 4.0),
        // A ring of four cells with two coordinates each.
        3 => (vec![plain([1, 2, 3, 0, 5, 6, 7, 4]), plain([0, 3, 2, 1, 4, 7, 6, 5])], 8.0),
        // All permutations of three cells.
        _ => (vec![plain([1, 0, 2, 4, 3, 5, 6, 7]), plain([1, 2, 0, 4, 5, 3, 6, 7])], 6.0),
    }
}

/// A random symmetric matrix with a heavy diagonal, so that it is positive definite.
fn filled(entries: &[i64], heavy: i64) -> Matrix {
    let n = 8;
    let mut a = vec![vec![0; n]; n];
    let mut entries = entries.iter();
    let places = (0..n).flat_map(|i| (0..=i).map(move |j| (i, j)));
    for (i, j) in places {
        let value = *entries.next().unwrap();
        a[i][j] = value;
        a[j][i] = value;
    }
    for (i, row) in a.iter_mut().enumerate() {
        row[i] += heavy + i64::try_from(i).unwrap();
    }
    a
}

/// M and K with a planted group, the group's elements, and its order.
fn planted(which: usize, entries: &[i64], order: &[usize], signs: &[bool]) -> (Matrix, Matrix, Vec<Element>, f64) {
    let by: Element = order.iter().zip(signs).map(|(i, s)| (*i, if *s { -1 } else { 1 })).collect();
    let (generators, count) = generators(which);
    let generators: Vec<Element> = generators.iter().map(|g| conjugated(g, &by)).collect();
    let elements = group(&generators);
    let mass = averaged(&filled(&entries[..36], 40), &elements);
    let stiffness = averaged(&filled(&entries[36..], 60), &elements);
    (mass, stiffness, generators, count)
}

/// A vector of displacements moved by an element of the group.
fn turned(by: &SignedPermutation, x: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; x.len()];
    for (i, value) in x.iter().enumerate() {
        let (to, negative) = by.of(i);
        out[to] = if negative { -value } else { *value };
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn planted_groups_are_found_and_split_exactly(
        which in 0_usize..5,
        entries in prop::collection::vec(-3_i64..=3, 72),
        order in Just((0..8).collect::<Vec<usize>>()).prop_shuffle(),
        signs in prop::collection::vec(any::<bool>(), 8),
    ) {
        let (mass, stiffness, planted, count) = planted(which, &entries, &order, &signs);
        let pattern = pattern(&mass, &stiffness);
        let found = Symmetry::find(&pattern).unwrap();
        // A mirror without signs comes before larger groups with signs.
        let is_plain = |g: &SignedPermutation| (0..8).all(|i| !g.of(i).1);
        let mirror_first = found.order == 2.0 && found.generators.iter().all(is_plain);
        prop_assert!(found.order >= count || mirror_first, "{} < {count}", found.order);
        for g in &found.generators {
            prop_assert!(pattern.is_kept_by(g));
        }
        // Every planted element moves coordinates as some element of the group found does.
        let all = SignedPermutation::group(&found.generators, 10_000);
        for g in &planted {
            let same = |h: &SignedPermutation| (0..8).all(|i| h.of(i).0 == g[i].0);
            prop_assert!(mirror_first || all.iter().any(same));
        }

        let model = model(&mass, &stiffness);
        let derivation = derive(&model, &Parts::default().frequencies(true)).unwrap();
        let linear = derivation.linear.unwrap();
        let case = linear.frequencies.unwrap().general;
        if let GroupKind::Mirrors(_) = found.kind {
            let vectors: Vec<(&str, &Vec<(usize, i64)>)> = case
                .blocks
                .iter()
                .flat_map(|block| block.basis.iter().map(|v| (block.class.as_str(), v)))
                .collect();
            prop_assert_eq!(vectors.len(), 8);
            for a in [&mass, &stiffness] {
                for (class, left) in &vectors {
                    for (other, right) in &vectors {
                        let entry: i64 = left
                            .iter()
                            .flat_map(|(i, x)| right.iter().map(move |(j, y)| x * y * a[*i][*j]))
                            .sum();
                        prop_assert!(class == other || entry == 0);
                    }
                }
            }
        }

        // Labels against the projections of the modes.
        let modes = normal_modes(&linearize(model).unwrap(), &Options::default()).unwrap().modes;
        for mode in &modes {
            let label = mode.symmetry.as_deref();
            prop_assert!(label.is_some(), "{:?}", found.kind);
            if mirror_first && label.is_some_and(|label| !["even", "odd"].contains(&label)) {
                // Told apart by the larger group with signs.
                continue;
            }
            let x = &mode.vector;
            if found.order == 2.0 {
                // Of g and -g, which a quadratic V both has, the one with fewer signs is the mirror.
                let mirror = found.kept(&mut |g| pattern.is_kept_by(g)).unwrap();
                let image = turned(&mirror.generators[0], x);
                let sign = if label == Some("even") { 1.0 } else { -1.0 };
                for (own, other) in x.iter().zip(&image) {
                    prop_assert!((own - sign * other).abs() < 1e-12);
                }
            }
            if let GroupKind::Ring { turn, length } = found.kept(&mut |g| pattern.is_kept_by(g)).unwrap().kind {
                // The turn plus its inverse is 2 cos(2 pi j/N) on the wave number j.
                let (once, mut back) = (turned(&turn, x), turned(&turn, x));
                for _ in 0..length - 2 {
                    back = turned(&turn, &back);
                }
                let j: f64 = label.unwrap().strip_prefix("wave number ").unwrap().parse().unwrap();
                let factor = 2.0 * (std::f64::consts::TAU * j / length as f64).cos();
                for i in 0..8 {
                    prop_assert!((once[i] + back[i] - factor * x[i]).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn almost_equal_numbers_are_not_equal(power in 25_u32..90) {
        let text = format!(
            "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*x^2 + 1/2*(1 + 1e-{power})*y^2 + 1/2*(x - y)^2"
        );
        let model = elaborate(&parse(&text).unwrap(), &TableTexts::new(), &Settings::new()).unwrap();
        let modes = normal_modes(&linearize(model).unwrap(), &Options::default()).unwrap().modes;
        prop_assert!(modes.iter().all(|mode| mode.symmetry.is_none()));
    }
}

#[test]
fn a_thousand_in_a_ring_and_in_a_row() {
    // Rings have as many turns and mirrors each as they have cells, rows one mirror.
    for (ring, order) in [(true, 2000.0), (false, 2.0)] {
        let n = 1000;
        let mut pattern = Pattern::new(n);
        for i in 0..n {
            pattern.set_diagonal(i, 1, true);
            let mut row = Vec::new();
            if ring || i > 0 {
                row.push((i + n - 1) % n);
            }
            if ring || i + 1 < n {
                row.push((i + 1) % n);
            }
            row.sort_unstable();
            for j in row {
                pattern.push(i, j, -2, true);
            }
        }
        let found = Symmetry::find(&pattern).unwrap();
        assert_eq!(found.order, order);
        assert_eq!(matches!(found.kind, GroupKind::Ring { length: 1000, .. }), ring);
    }
}

/// The frequencies with their classes, `-` where there is none.
fn classes(text: &str) -> Vec<String> {
    let file = parse(text).unwrap_or_else(|_| panic!("{text}"));
    let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
    let modes = normal_modes(&linearize(model).unwrap(), &Options::default()).unwrap();
    let held = modes.modes.into_iter().filter(|mode| mode.omega.mid_f64() > 0.0);
    held.map(|mode| mode.symmetry.unwrap_or_else(|| "-".to_owned())).collect()
}

/// The blocks of a derivation and how it writes its exchanges.
fn derived(text: &str) -> (Vec<String>, usize) {
    let model = elaborate(&parse(text).unwrap(), &TableTexts::new(), &Settings::new()).unwrap();
    let derivation = derive(&model, &Parts::default().frequencies(true)).unwrap();
    let frequencies = derivation.linear.unwrap().frequencies.unwrap();
    let case = frequencies.best();
    let blocks = case.blocks.iter().map(|block| block.class.clone());
    let exchanges = case.symmetry.as_ref().map_or(0, |found| found.generators.len());
    (blocks.collect(), exchanges)
}

/// Water in coordinates of one's own choice, with the places of H, O and H in them.
fn water(declared: &str, places: [&str; 3], equilibria: &str) -> String {
    let [h1, o, h2] = places;
    format!(
        "param mH = 1  param mO = 15.87  param k = 1  param kb = 0.09  param c = 0.61
         {declared}
         let h1 = {h1}  let o = {o}  let h2 = {h2}  let a = h1 - o  let b = h2 - o
         T = 1/2*mH*(dot(h1', h1') + dot(h2', h2')) + 1/2*mO*dot(o', o')
         V = 1/2*k*(norm(a) - 1)^2 + 1/2*k*(norm(b) - 1)^2
           + 1/2*kb*(acos(dot(a, b)/(norm(a)*norm(b))) - 2*acos(c))^2
         {equilibria}"
    )
}

#[test]
fn bending_and_symmetric_stretching_of_water_are_even() {
    let s = "sqrt(1 - c^2)";
    let vectors = ["r[1]", "r[2]", "r[3]"];
    let alone = ["[x1, y1]", "[x2, y2]", "[x3, y3]"];
    // In space the molecule is of C2v.
    let space = [("even", "A1"), ("odd", "B2")];
    for text in [
        // In a plane, about y; about x and away from the origin; in space, across all axes but one; one by one.
        water(
            "coord r[1..3, 1..2]",
            vectors,
            &format!("equilibrium r[1] = [-{s}, c]  equilibrium r[2] = [0, 0]  equilibrium r[3] = [{s}, c]"),
        ),
        water(
            "coord r[1..3, 1..2]",
            vectors,
            &format!(
                "equilibrium r[1] = [7 - c, 2 + {s}]  equilibrium r[2] = [7, 2]  equilibrium r[3] = [7 - c, 2 - {s}]"
            ),
        ),
        water(
            "coord r[1..3, 1..3]",
            vectors,
            &format!("equilibrium r[1] = [0, {s}, c]  equilibrium r[2] = [0, 0, 0]  equilibrium r[3] = [0, -{s}, c]"),
        ),
        water(
            "coord x1, y1, x2, y2, x3, y3",
            alone,
            &format!("equilibrium x1 = -{s}  equilibrium y1 = c  equilibrium x3 = {s}  equilibrium y3 = c"),
        ),
    ] {
        let told = |own: &str| {
            space.iter().find(|(_, name)| *name == own).map_or(own.to_owned(), |(own, _)| (*own).to_owned())
        };
        let found = classes(&text);
        assert_eq!(found.contains(&"A1".to_owned()), text.contains("1..3, 1..3]"), "{text}");
        let found: Vec<String> = found.iter().map(|own| told(own)).collect();
        assert_eq!(found, ["even", "even", "odd"], "{text}");
    }
}

#[test]
fn straight_molecules_have_sigma_and_pi() {
    let molecule = |masses: &str, springs: &str, places: &str| {
        format!(
            "param m[1..3] = {masses}  param k[1..2] = {springs}  coord r[1..3, 1..3]
             let a = r[1] - r[2]  let b = r[3] - r[2]  let bend = a/norm(a) + b/norm(b)
             T = sum(i in 1..3, 1/2*m[i]*dot(r[i]', r[i]'))
             V = 1/2*k[1]*(norm(a) - 1)^2 + 1/2*k[2]*(norm(b) - 1)^2 + 1/50*dot(bend, bend)
             equilibrium r[i in 1..3] = {places}"
        )
    };
    let along = |axis: &str| match axis {
        "x" => "[i - 2, 0, 0]",
        "z" => "[5, 3, i]",
        _ => "[0, 4 - i, 0]",
    };
    for axis in ["x", "y", "z"] {
        let same = molecule("[16, 12, 16]", "[1, 1]", along(axis));
        assert_eq!(classes(&same), ["Πu", "Πu", "Σg+", "Σu+"]);
        let different = molecule("[16, 12, 32]", "[1, 2]", along(axis));
        assert_eq!(classes(&different), ["Π", "Π", "Σ+", "Σ+"]);
    }
}

#[test]
fn classes_of_point_groups() {
    let springs = |bodies: &str, width: usize, energy: &str, places: &str| {
        format!(
            "coord r[1..{bodies}, 1..{width}]
             T = sum(a in 1..{bodies}, 1/2*dot(r[a]', r[a]'))
             V = {energy}
             equilibrium r[a in 1..{bodies}] = {places}"
        )
    };
    let all = |n: &str, length: &str| format!("sum(a in 1..{n}, b in a+1..{n}, 1/2*(norm(r[a] - r[b]) - {length})^2)");
    // The tetrahedron: omega^2 = 1 (E), 2 (T2), 4 (A1); Landau and Lifshitz, Quantum Mechanics, §100.
    let corners = "param c[1..4, 1..3] = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]\n";
    let tetrahedron = springs("4", 3, &all("4", "2*sqrt(2)"), "c[a]");
    assert_eq!(classes(&format!("{corners}{tetrahedron}")), ["E", "E", "T2", "T2", "T2", "A1"]);
    // A square with diagonals in its plane: the group of the square acts as C4v does. Breathing is A1; the sides stretched
    // in turn, x against y, is B1 or B2 as the corners lie.
    let square = "param c[1..4, 1..2] = [[1, 1], [-1, 1], [-1, -1], [1, -1]]\n";
    let sides = "1/2*(norm(r[1] - r[2]) - 2)^2 + 1/2*(norm(r[2] - r[3]) - 2)^2
      + 1/2*(norm(r[3] - r[4]) - 2)^2 + 1/2*(norm(r[4] - r[1]) - 2)^2
      + 1/4*(norm(r[1] - r[3]) - 2*sqrt(2))^2 + 1/4*(norm(r[2] - r[4]) - 2*sqrt(2))^2";
    let found = classes(&format!("{square}{}", springs("4", 2, sides, "c[a]")));
    assert_eq!(found.iter().filter(|own| *own == "A1").count(), 1);
    assert_eq!(found.last().unwrap(), "A1");
    assert_eq!(found.len(), 5);
    // An equilateral triangle: breathing is A1 of C3v.
    let triangle = "param c[1..3, 1..2] = [[-1, 0], [1, 0], [0, sqrt(3)]]\n";
    let found = classes(&format!("{triangle}{}", springs("3", 2, &all("3", "2"), "c[a]")));
    assert_eq!(found, ["E", "E", "A1"]);
    // Formaldehyde, C2v about y: out of the plane is B1, in the plane and across B2.
    let formaldehyde = "param m[1..4] = [1, 1, 12, 16]
        param c[1..4, 1..3] = [[-0.9, 0.5, 0], [0.9, 0.5, 0], [0, 0, 0], [0, -1.2, 0]]
        coord r[1..4, 1..3]
        T = sum(a in 1..4, 1/2*m[a]*dot(r[a]', r[a]'))
        V = sum(a in 1..4, b in a+1..4, 1/2*(norm(r[a] - r[b]) - norm(c[a] - c[b]))^2)
          + (r[3][3] - (r[1][3] + r[2][3] + r[4][3])/3)^2/100
        equilibrium r[a in 1..4] = c[a]";
    let mut found = classes(formaldehyde);
    found.sort();
    assert_eq!(found, ["A1", "A1", "A1", "B1", "B2", "B2"]);
}

#[test]
fn totally_symmetric_modes_of_larger_molecules() {
    // Sulphur hexafluoride, Oh: A1g + Eg + 2 T1u + T2g + T2u (Herzberg, Infrared and Raman Spectra, p. 122).
    let octahedron = "param c[1..7, 1..3] = [[0,0,0], [1,0,0], [-1,0,0], [0,1,0], [0,-1,0], [0,0,1], [0,0,-1]]
        param m[1..7] = [32, 19, 19, 19, 19, 19, 19]
        coord r[1..7, 1..3]
        T = sum(a in 1..7, 1/2*m[a]*dot(r[a]', r[a]'))
        V = sum(b in 2..7, (norm(r[1] - r[b]) - 1)^2)
          + sum(a in 2..7, b in a+1..7 where mod(a, 2) == 1 or b > a+1, 1/7*(norm(r[a] - r[b]) - sqrt(2))^2)
        equilibrium r[a in 1..7] = c[a]";
    let mut found = classes(octahedron);
    found.sort();
    let three = |name: &str| vec![name.to_owned(); 3];
    let mut expected = vec!["A1g".to_owned(), "Eg".to_owned(), "Eg".to_owned()];
    expected.extend(["T1u", "T1u", "T2g", "T2u"].iter().flat_map(|name| three(name)));
    assert_eq!(found, expected);
    // Ammonia, C3v.
    let ammonia = "param c[1..4, 1..3] = [[0, 0, 0.4], [1, 0, 0], [-1/2, sqrt(3)/2, 0], [-1/2, -sqrt(3)/2, 0]]
        param m[1..4] = [14, 1, 1, 1]
        coord r[1..4, 1..3]
        T = sum(a in 1..4, 1/2*m[a]*dot(r[a]', r[a]'))
        V = sum(a in 1..4, b in a+1..4, 1/2*(norm(r[a] - r[b]) - norm(c[a] - c[b]))^2)
        equilibrium r[a in 1..4] = c[a]";
    let found = classes(ammonia);
    assert_eq!([&found[0], &found[5]], ["A1", "A1"]);
    // A ring of six as benzene's, in space and held across: breathing is A1g of D6h.
    let ring = "coord r[1..6, 1..3]
        T = sum(a in 1..6, 1/2*dot(r[a]', r[a]'))
        V = sum(a in 1..6, 1/2*(norm(r[a] - r[mod(a, 6) + 1]) - 1)^2
          + 1/5*(norm(r[a] - r[mod(a + 1, 6) + 1]) - sqrt(3))^2
          + 1/10*(r[a][3] - (r[mod(a, 6) + 1][3] + r[mod(a + 4, 6) + 1][3])/2)^2)
        equilibrium r[a in 1..6] = [cos(pi*a/3), sin(pi*a/3), 0]";
    assert_eq!(classes(ring).iter().filter(|own| *own == "A1g").count(), 1);
    // Three masses with Morse's potential in a row: stretching both at once is even.
    let row = "coord x[1..3]  T = sum(i in 1..3, x[i]'^2/2)
        V = sum(i in 1..2, (1 - exp(1 - x[i+1] + x[i]))^2)
        equilibrium x[i in 1..3] = i";
    assert_eq!(classes(row), ["even", "odd"]);
}

#[test]
fn a_symmetry_is_one_of_the_energies() {
    let two = |energy: &str| format!("coord x[1..2]  T = 1/2*x[1]'^2 + 1/2*x[2]'^2  V = {energy}");
    let quadratic = "1/2*x[1]^2 + 1/2*x[2]^2 + 1/2*(x[2] - x[1])^2";
    // Where both stand the permutation without signs is the mirror; a cubic spring between walls turns around.
    for (more, expected) in [
        ("", ["even", "odd"]),
        ("+ (x[2] - x[1])^4", ["even", "odd"]),
        ("+ (x[2] - x[1])^3", ["odd", "even"]),
        ("+ x[1]^3 + (x[2] - x[1])^3 - x[2]^3", ["odd", "even"]),
        ("+ x[1]^3 + x[2]^3", ["even", "odd"]),
        ("+ x[1]^3", ["-", "-"]),
        ("+ x[1]^3 + x[2]^3 + (x[2] - x[1])^3", ["-", "-"]),
        ("+ x[1]^4", ["-", "-"]),
        ("+ x[1]^3 + (1 + 1e-40)*x[2]^3", ["-", "-"]),
    ] {
        let text = two(&format!("{quadratic} {more}"));
        assert_eq!(classes(&text), expected, "{more}");
        let (blocks, exchanges) = derived(&text);
        let named = expected[0] != "-";
        assert_eq!(exchanges, usize::from(named), "{more}");
        assert!(blocks.is_empty() || named, "{more}: {blocks:?}");
    }
    // T counts, too; and an equilibrium that the permutation moves is none of its own.
    let inertia = "coord x, y  T = 1/2*(1 + x)*x'^2 + 1/2*(1 - y)*y'^2  V = x^2 + y^2 + x*y";
    assert_eq!(classes(inertia), ["even", "odd"]);
    let inertia = "coord x, y  T = 1/2*(1 + x)*x'^2 + 1/2*(1 + 2*y)*y'^2  V = x^2 + y^2 + x*y";
    assert_eq!(classes(inertia), ["-", "-"]);
    // Friction that acts only beyond the second order counts as well.
    let friction = "coord x, y  T = 1/2*x'^2 + 1/2*y'^2  V = x^2 + y^2 + x*y  dissipation = x'^4";
    assert_eq!(classes(friction), ["-", "-"]);
    let bobs = "coord a, b  T = 1/2*a'^2 + 1/2*b'^2
        V = -cos(a) - cos(b) + 1/20/sqrt((sin(b) - sin(a))^2 + (cos(b) - cos(a))^2)
        guess a = -0.3  guess b = 0.3";
    assert_eq!(classes(bobs), ["odd", "even"]);
    let double = "coord a, b  T = a'^2 + 1/2*b'^2 + a'*b'*cos(a - b)  V = -2*cos(a) - cos(b)";
    assert_eq!(classes(double), ["-", "-"]);
    // Between walls, places and not displacements, searched for: breathing is even.
    let walls = "coord x[1..3]  T = sum(i in 1..3, 1/2*x[i]'^2)
        V = 1/x[1] + 1/(x[2] - x[1]) + 1/(x[3] - x[2]) + 1/(4 - x[3])
        guess x[i in 1..3] = i + 1/10";
    assert_eq!(classes(walls), ["odd", "even", "odd"]);
}

#[test]
fn rings_keep_their_wave_numbers_where_the_energies_turn() {
    let ring = |cubic: &str| {
        format!(
            "coord x[1..5]  T = sum(i in 1..5, 1/2*x[i]'^2)
             V = sum(i in 1..5, 1/2*x[i]^2 + 1/2*(x[mod(i, 5) + 1] - x[i])^2 + {cubic}*(x[mod(i, 5) + 1] - x[i])^3)"
        )
    };
    let waves = [0, 1, 1, 2, 2].map(|j| format!("wave number {j}"));
    assert_eq!(classes(&ring("0")), waves);
    assert_eq!(classes(&ring("1/7")), waves);
    assert!(classes(&ring("i/7")).iter().all(|own| own == "-"));
}

#[test]
fn mirrors_have_one_order_in_modes_and_derive() {
    // Four masses of a rectangle, two mirrors: the modes' names are those of the blocks.
    let text = "coord u[1..2, 1..2]  T = sum(i in 1..2, j in 1..2, 1/2*u[i,j]'^2)
        V = sum(i in 1..2, j in 1..2, 1/2*u[i,j]^2)
          + sum(i in 1..2, 1/2*(u[i,2] - u[i,1])^2) + sum(j in 1..2, (u[2,j] - u[1,j])^2)";
    // omega^2 = 1, 1 + 2 (columns against each other), 1 + 4 (rows), 1 + 6.
    let found = classes(text);
    assert_eq!(found, ["even, even", "odd, even", "even, odd", "odd, odd"]);
    let model = elaborate(&parse(text).unwrap(), &TableTexts::new(), &Settings::new()).unwrap();
    let derivation = derive(&model, &Parts::default().frequencies(true)).unwrap();
    let case = derivation.linear.unwrap().frequencies.unwrap().general;
    for block in &case.blocks {
        let own = derivation.pool.as_number(block.stiffness[0][0]).unwrap();
        let mass = derivation.pool.as_number(block.mass[0][0]).unwrap();
        let square = own.div(mass).unwrap().to_i64().unwrap();
        let at = [1, 3, 5, 7].iter().position(|own| *own == square).unwrap();
        assert_eq!(block.class, found[at]);
    }
}
