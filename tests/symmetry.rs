//! Random models with a symmetry that was put in: it is found, M and K fall apart exactly, and the modes
//! are what their labels say.
#![cfg(feature = "engine")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

use librate::derive::{Parts, derive};
use librate::linearize::linearize;
use librate::model::{Model, Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate::symmetry::{GroupKind, Pattern, SignedPermutation, Symmetry};
use librate::syntax::parse;
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
                pattern.push(
                    i,
                    j,
                    label(mass[i][j], stiffness[i][j]),
                    stiffness[i][j] != 0,
                );
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
    let text = format!(
        "coord x[1..{n}]\nT = {}\nV = {}",
        form(mass, "'"),
        form(stiffness, "")
    );
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
        2 => (
            vec![
                plain([1, 0, 3, 2, 5, 4, 7, 6]),
                plain([2, 3, 0, 1, 6, 7, 4, 5]),
            ],
            4.0,
        ),
        // A ring of four cells with two coordinates each.
        3 => (
            vec![
                plain([1, 2, 3, 0, 5, 6, 7, 4]),
                plain([0, 3, 2, 1, 4, 7, 6, 5]),
            ],
            8.0,
        ),
        // All permutations of three cells.
        _ => (
            vec![
                plain([1, 0, 2, 4, 3, 5, 6, 7]),
                plain([1, 2, 0, 4, 5, 3, 6, 7]),
            ],
            6.0,
        ),
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
fn planted(
    which: usize,
    entries: &[i64],
    order: &[usize],
    signs: &[bool],
) -> (Matrix, Matrix, Vec<Element>, f64) {
    let by: Element = order
        .iter()
        .zip(signs)
        .map(|(i, s)| (*i, if *s { -1 } else { 1 }))
        .collect();
    let (generators, count) = generators(which);
    let generators: Vec<Element> = generators.iter().map(|g| conjugated(g, &by)).collect();
    let elements = group(&generators);
    let mass = averaged(&filled(&entries[..36], 40), &elements);
    let stiffness = averaged(&filled(&entries[36..], 60), &elements);
    (mass, stiffness, generators, count)
}

fn as_public(g: &Element) -> impl Fn(&[f64]) -> Vec<f64> {
    let g = g.clone();
    move |x: &[f64]| {
        let mut out = vec![0.0; x.len()];
        for (i, value) in x.iter().enumerate() {
            out[g[i].0] = g[i].1 as f64 * value;
        }
        out
    }
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
                // The sign of a mirror with signs is a matter of choice: ask the one that was found.
                let image = found.generators[0].apply(x);
                let sign = if label == Some("even") { 1.0 } else { -1.0 };
                for (own, other) in x.iter().zip(&image) {
                    prop_assert!((own - sign * other).abs() < 1e-12);
                }
            }
            if let GroupKind::Ring { length, .. } = found.kind
                && which == 3
            {
                // The planted turn plus its inverse is 2 cos(2 pi j/N) on the wave number j.
                let turn = as_public(&planted[0]);
                let (once, mut back) = (turn(x), turn(x));
                for _ in 0..length - 2 {
                    back = turn(&back);
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
    fn almost_equal_numbers_are_not_equal(power in 25_u32..60) {
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
        assert_eq!(
            matches!(found.kind, GroupKind::Ring { length: 1000, .. }),
            ring
        );
    }
}
