//! Equilibria over a parameter, against closed forms: which branches there are, and where they end or meet.
#![cfg(feature = "engine")]

use librate::Source;
use librate::equilibria::{Diagram, EquilibriaError, Kind, Region, follow};
use librate::model::{Range, Settings, TableTexts, elaborate};
use librate::modes::Stability;
use librate::precision::Ball;
use librate::syntax::parse;
use librate_studies::equilibria::Branch;
use proptest::prelude::*;

fn diagram(text: &str, ranges: &str, over: &str) -> Result<Diagram, EquilibriaError> {
    let file = parse(text).unwrap();
    let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
    let source = Source { file, tables: TableTexts::new(), settings: Settings::new() };
    follow(&source, &Region::parse(ranges, &model)?, &Range::parse(over).unwrap())
}

/// One that has to be complete.
#[track_caller]
fn complete(text: &str, ranges: &str, over: &str) -> Diagram {
    let found = diagram(text, ranges, over).unwrap();
    assert!(found.complete, "{:?}", found.reasons);
    found
}

fn of_file(name: &str, ranges: &str, over: &str) -> Diagram {
    complete(&std::fs::read_to_string(format!("models/equilibria/{name}.lag")).unwrap(), ranges, over)
}

#[track_caller]
fn assert_encloses(ball: &Ball, expected: f64) {
    let off = (ball.mid_f64() - expected).abs();
    assert!(off <= 4e-16 * expected.abs().max(0.1) + ball.mid_f64_error(), "{ball:?}, not {expected}");
    assert!(ball.radius <= 1e-14 * expected.abs().max(1.0), "{ball:?}");
}

/// Kind, parameter and coordinates of each bifurcation.
#[track_caller]
fn assert_bifurcations(found: &Diagram, expected: &[(Kind, f64, &[f64])]) {
    assert_eq!(found.bifurcations.len(), expected.len(), "{:?}", found.bifurcations);
    for (own, (kind, value, point)) in found.bifurcations.iter().zip(expected) {
        assert_eq!(own.kind, *kind);
        assert_encloses(&own.value, *value);
        own.point.iter().zip(*point).for_each(|(x, y)| assert_encloses(x, *y));
    }
}

/// First and last value of each branch.
fn ends(found: &Diagram) -> Vec<[f64; 2]> {
    let ends =
        found.branches.iter().map(|own| [&own.at[0], own.at.last().unwrap()].map(|(place, _)| found.values[*place]));
    ends.collect()
}

/// What a branch has at a value.
fn at(branch: &Branch, number: usize) -> (f64, Stability) {
    let own = branch.at.iter().find(|(place, _)| *place == number).map(|(_, own)| own).unwrap();
    (own.point[0].mid_f64(), own.stability)
}

/// cos(th) = g/(R W^2) beyond W = sqrt(g/R).
#[test]
fn a_bead_on_a_hoop_leaves_the_bottom_at_a_pitchfork() {
    let found = of_file("bead_on_hoop", "th=-3..3", "W=0..20:41");
    let critical = (9.81_f64 / 0.2).sqrt();
    assert_bifurcations(&found, &[(Kind::Pitchfork, critical, &[0.0])]);
    assert_eq!(ends(&found), [[0.0, 20.0], [7.5, 20.0], [7.5, 20.0]]);
    for (number, w) in found.values.iter().enumerate() {
        let (bottom, stability) = at(&found.branches[0], number);
        assert_eq!((bottom, stability == Stability::Stable), (0.0, *w < critical));
        if *w > critical {
            let expected = (9.81 / (0.2 * w * w)).acos();
            let (left, right) = (at(&found.branches[1], number), at(&found.branches[2], number));
            assert!((right.0 - expected).abs() < 1e-15 && left.0 == -right.0);
            assert_eq!((left.1, right.1), (Stability::Stable, Stability::Stable));
        }
    }
    // About the top, 180 degrees away from where sines are odd: it is an equilibrium at all rates.
    let top = of_file("bead_on_hoop", "th=3..4", "W=0..20:5");
    assert_eq!((ends(&top), top.bifurcations.len()), (vec![[0.0, 20.0]], 0));
}

/// About pi, not 0: V = c cos(th) + cos(2 th) bifurcates at th = pi where c = 4.
#[test]
fn a_pitchfork_half_a_turn_away() {
    let text = "param c = 1 coord th T = 1/2*th'^2 V = c*cos(th) + cos(2*th)";
    let found = complete(text, "th=2..4", "c=1..6:11");
    assert_bifurcations(&found, &[(Kind::Pitchfork, 4.0, &[std::f64::consts::PI])]);
}

/// Folds where s^3 = l b^2, s being the length of a bar.
#[test]
fn a_truss_snaps_through_at_folds() {
    let found = of_file("von_mises_truss", "y=-2..2", "P=-0.5..0.5:21");
    let l = 1.25_f64.sqrt();
    let s = l.cbrt();
    let y = (s * s - 1.0).sqrt();
    let p = 2.0 * y * (l / s - 1.0);
    assert_bifurcations(&found, &[(Kind::Fold, -p, &[-y]), (Kind::Fold, p, &[y])]);
    let drawn = &found.branches[0].way;
    assert!(drawn.windows(2).all(|pair| pair[0].0 <= pair[1].0), "{drawn:?}");
    assert!((drawn.last().unwrap().0 - p).abs() < 1e-15 && (drawn.last().unwrap().1[0] - y).abs() < 1e-15);
}

/// Two wells that are coupled: x = -y at x^2 = 1 - c, which x != -y leaves where c = 2/3.
#[test]
fn mirror_images_in_two_coordinates() {
    let text = "param c = 1 coord x, y T = 1/2*x'^2 + 1/2*y'^2 V = (x^2 - 1)^2 + (y^2 - 1)^2 + c*(x - y)^2";
    let found = complete(text, "x=-2..2, y=-2..2", "c=0.05..1.5:30");
    let x = 3.0_f64.recip().sqrt();
    let mut told: Vec<_> = found.bifurcations.iter().map(|own| own.kind).collect();
    told.dedup();
    assert_eq!(told, [Kind::Pitchfork]);
    let points: Vec<(f64, f64)> =
        found.bifurcations.iter().map(|own| (own.value.mid_f64(), own.point[0].mid_f64().abs())).collect();
    for (own, expected) in points.iter().zip([(2.0 / 3.0, x), (2.0 / 3.0, x), (1.0, 0.0)]) {
        assert!((own.0 - expected.0).abs() < 1e-15 && (own.1 - expected.1).abs() < 1e-15, "{points:?}");
    }
    assert_eq!((points.len(), found.branches.len()), (3, 9));
}

/// A branch passes through a bifurcation at one of the values, upward and downward.
#[test]
fn bifurcations_at_a_value() {
    let text = "param a = 1 coord x T = 1/2*x'^2 V = x^4/4 - a*x^2/2";
    for (over, first) in [("a=-1..1:21", [-1.0, 1.0]), ("a=1..-1:21", [1.0, -1.0])] {
        let found = complete(text, "x=-2..2", over);
        assert_bifurcations(&found, &[(Kind::Pitchfork, 0.0, &[0.0])]);
        let middle = found.branches.iter().find(|own| own.at.len() == 21).unwrap();
        assert_eq!(found.values[middle.at[0].0], first[0]);
        assert_eq!(at(middle, 10), (0.0, Stability::Neutral));
        assert_eq!(found.branches.len(), 3);
    }
}

/// Where the range ends in a bifurcation, the equilibrium there belongs to one branch.
#[test]
fn bifurcations_at_an_end() {
    let quartic = "param a = 0 coord x T = 1/2*x'^2 V = x^4/4 - a*x^2/2";
    let cubic = "param a = 0 coord x T = 1/2*x'^2 V = x^3/3 - a*x";
    for (text, over, place, expected) in [
        (quartic, "a=-1..0:5", 4, &[[-1.0, 0.0]][..]),
        (quartic, "a=0..-1:5", 0, &[[0.0, -1.0]]),
        (quartic, "a=0..1:5", 0, &[[0.0, 1.0], [0.25, 1.0], [0.25, 1.0]]),
        (cubic, "a=0..1:5", 0, &[[0.0, 1.0], [0.25, 1.0]]),
        (cubic, "a=-1..1:5", 2, &[[0.0, 1.0], [0.5, 1.0]]),
        (cubic, "a=1..0:5", 4, &[[1.0, 0.0], [1.0, 0.25]]),
    ] {
        let found = complete(text, "x=-2..2", over);
        let mut all = ends(&found);
        assert_eq!(found.bifurcations.len(), 1);
        let there = found.branches.iter().filter(|own| own.at.iter().any(|(at, _)| *at == place));
        let there: Vec<(f64, Stability)> = there.map(|own| at(own, place)).collect();
        assert_eq!((there.len(), there[0].0), (1, 0.0), "{text} {over}");
        let mut expected = expected.to_vec();
        for own in [&mut all, &mut expected] {
            own.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        }
        assert_eq!(all, expected, "{text} {over}");
    }
}

/// x (p - x) with a second coordinate that moves along: no mirror, but x = 0 remains.
#[test]
fn two_branches_cross() {
    let text = "param p = 1 coord x, y T = 1/2*x'^2 + 1/2*y'^2 V = x^3/3 - p*x^2/2 + 1/2*(y - p)^2*(1 + x^2)";
    let found = complete(text, "x=-2..2, y=-3..3", "p=-1..1:8");
    assert_bifurcations(&found, &[(Kind::Transcritical, 0.0, &[0.0, 0.0])]);
    assert_eq!(ends(&found), [[-1.0, 1.0], [-1.0, 1.0]]);
}

/// Weak in one direction, and poles beside it.
#[test]
fn the_triangle_of_lagrange_over_the_mass() {
    let found = of_file("lagrange_points", "x=-2..2, y=-2..2", "mu=0.01..0.05:5");
    assert_eq!((ends(&found), found.bifurcations.len()), (vec![[0.01, 0.05]; 5], 0));
    // Routh: unstable from mu = (1 - sqrt(69)/9)/2 on.
    let told: Vec<bool> = (0..5).map(|number| at(&found.branches[1], number).1 == Stability::Stable).collect();
    assert_eq!(told, [true, true, true, false, false]);
}

/// What can't be proved is said.
#[test]
fn degenerate_bifurcations_are_left_open() {
    let found = diagram("param h = 0 coord x T = 1/2*x'^2 V = x^4/4 - h*x", "x=-2..2", "h=-1..1:21").unwrap();
    assert!(!found.complete && found.bifurcations.is_empty());
    assert!(found.reasons.iter().any(|reason| reason.starts_with("at 0: ")), "{:?}", found.reasons);
    // All places are equilibria at k = 0, or the branch parts as x⁴: no pitchforks; and one that y bends.
    for (text, is_one) in [
        ("coord x T = 1/2*x'^2 V = k*x^2", false),
        ("coord x, y T = 1/2*x'^2 + 1/2*y'^2 V = k*x^2 + y^2 + x^2*y + x^4/4", false),
        ("coord x T = 1/2*x'^2 V = k*x^2*(1 + x)", false),
        ("coord x, y T = 1/2*x'^2 + 1/2*y'^2 V = k*x^2 + y^2 + x^2*y", true),
    ] {
        let ranges = if text.contains("y^2") { "x=-2..2, y=-2..2" } else { "x=-0.5..0.5" };
        let found = diagram(&format!("param k = 1 {text}"), ranges, "k=-1..1:4").unwrap();
        assert_eq!((found.bifurcations.len() == 1, found.complete), (is_one, is_one), "{text}: {:?}", found.reasons);
    }
    let error =
        diagram("param N = 2 coord x[1..3] T = 1/2*dot(x', x') V = sum(i in 1..N, x[i]^2)", "x=-1..1", "N=1..3:3");
    assert_eq!(error.unwrap_err().code(), "E0726");
    let error = diagram("param k = 1 coord x T = 1/2*x'^2 V = 1/2*k*x^2", "x=-1..1", "k=1..2:10001");
    assert_eq!(error.unwrap_err().code(), "E0727");
}

/// Branches that end in a kink beside a fold of others, and undecided ones that a bifurcation elsewhere in them does not account for.
#[test]
fn what_a_bifurcation_does_not_explain_is_left_open() {
    let text = "param a=-0.1 param p=-0.21 param q=-0.0027 param s=1 param c=0.545 coord x T=1/2*x'^2
        let C=s*p^2-c*(a-q) V=a*(s*x^3/3-s*p*x^2+C*x)+abs(x)*(s*x^3/4-2*s*p*x^2/3+C*x/2)";
    assert!(!diagram(text, "x=-4..5", "a=-0.35..0.35:8").unwrap().complete);
    let text = "param p=0.0078 param a=0.1 coord x T=1/2*x'^2
        V=x^8/8-(2*p^2+a)*x^6/6+(p^4+a^2+2*a*p^2)*x^4/4-a*(p^4+a^2)*x^2/2";
    assert!(!diagram(text, "x=-4..4", "a=-0.2..0.2:5").unwrap().complete);
    // Folds at the ends of the range, and two between whose values lies a branch.
    let pendulum = complete("param p=0 coord x T=1/2*x'^2 V=-cos(x)-p*x", "x=-3..3", "p=-1..1:5");
    assert_eq!((pendulum.branches.len(), pendulum.bifurcations.len()), (3, 2));
    complete("param p=0 coord x T=1/2*x'^2 V=x^4/4-1e-4*x^2/2+p*x", "x=-2..2", "p=-1..1:20");
}

/// The parameter's own unit.
#[test]
fn values_are_in_the_unit_of_the_parameter() {
    let text = "param h : mm = 500 param b : m = 1 param k : N/m = 1 param m : kg = 1 param P : mN = 0 coord y : m \
                T = 1/2*m*y'^2 V = k*(sqrt(b^2 + y^2) - sqrt(b^2 + h^2))^2 + P*y";
    let found = complete(text, "y=-2..2", "P=-60..60:13");
    assert_eq!(found.unit.as_deref(), Some("mN"));
    assert!((found.bifurcations[1].value.mid_f64() - 42.914_325_731_224_69).abs() < 1e-13, "{:?}", found.bifurcations);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Of a polynomial that is tilted, V(x) - h x, there are folds where V'' changes its sign, at h = V'.
    #[test]
    fn folds_of_random_polynomials(
        coefficients in prop::collection::vec(-20_i32..=20, 4),
        count in 5_usize..40,
    ) {
        let terms = coefficients.iter().enumerate().map(|(at, own)| format!("{own}/10*x^{}", at + 2));
        let text = format!("param h = 0 coord x T = 1/2*x'^2 V = x^6 - h*x + {}", terms.collect::<Vec<_>>().join(" + "));
        let slope = |x: f64, times: usize| {
            let all = coefficients.iter().map(|own| f64::from(*own) / 10.0).chain([1.0]).enumerate();
            all.map(|(at, own)| {
                let n = (at + 2) as f64;
                if times == 1 { own * n * x.powi(at as i32 + 1) } else { own * n * (n - 1.0) * x.powi(at as i32) }
            }).sum::<f64>()
        };
        let grid: Vec<f64> = (0..=40_000).map(|at| f64::from(at) * 1e-4 - 2.0 + 1.234e-6).collect();
        let mut expected = Vec::new();
        for pair in grid.windows(2) {
            if slope(pair[0], 2) * slope(pair[1], 2) < 0.0 {
                let [mut a, mut b] = [pair[0], pair[1]];
                for _ in 0..60 {
                    let middle = 0.5 * (a + b);
                    if slope(a, 2) * slope(middle, 2) <= 0.0 { b = middle } else { a = middle }
                }
                if slope(a, 1).abs() < 5.0 && a.abs() < 2.0 { expected.push(slope(a, 1)) }
            }
        }
        let found = diagram(&text, "x=-2..2", &format!("h=-5..5:{count}")).unwrap();
        // Those that begin and end between two values are not seen.
        let values = &found.values;
        let gap = |h: f64| values.windows(2).position(|pair| pair[0] <= h && h <= pair[1]);
        for own in &found.bifurcations {
            prop_assert_eq!(own.kind, Kind::Fold);
            let near = expected.iter().map(|h| (h - own.value.mid_f64()).abs()).fold(f64::INFINITY, f64::min);
            prop_assert!(near < 1e-6, "{} at {:?}, expected {:?}", text, own, expected);
        }
        for h in &expected {
            let alone = expected.iter().filter(|other| gap(**other) == gap(*h)).count() == 1;
            let seen = found.bifurcations.iter().any(|own| (own.value.mid_f64() - h).abs() < 1e-6);
            prop_assert!(seen || !alone, "{}: {} of {:?}, {:?} {:?}", text, h, expected, found.bifurcations, found.reasons);
        }
    }
}
