//! Motions that no friction reaches, beside damped ones, in models whose numbers are irrational: what they are is decided.
#![cfg(feature = "engine")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

mod common;

use common::model;
use librate::linearize::{Linearized, linearize};
use librate::modes::exponents::Limit;
use librate::modes::{Kind, Options, Stability};
use librate::oscillation::{NormalModes, normal_modes, warnings};

fn solve(text: &str, options: &Options) -> (Linearized, NormalModes) {
    let linearized = linearize(model(text)).unwrap();
    let modes = normal_modes(&linearized, options).unwrap();
    (linearized, modes)
}

/// An undamped oscillator, a damped one, and two charges of which one drags: omega² = sqrt(2), x²+πx/5+3 = 0, and
/// omega = sqrt(1 + B²) ± B for B = sqrt(3)/4 without friction.
const SEPARATE: &str = "param B = sqrt(3)/4  coord a, b, x, y
    T = 1/2*(a'^2 + b'^2 + x'^2 + y'^2) + B*(x*y' - y*x')
    V = sqrt(2)/2*a^2 + 3/2*b^2 + 1/2*(x^2 + y^2)
    dissipation = pi/10*b'^2";

#[test]
fn growth_is_exactly_zero_where_no_friction_acts() {
    let (_, found) = solve(SEPARATE, &Options::default().digits(20));
    assert_eq!(found.stability, Stability::Stable);
    let b = 3.0_f64.sqrt() / 4.0;
    let root = (1.0 + b * b).sqrt();
    let damped = std::f64::consts::PI / 10.0;
    let want = [
        (root - b, 0.0),
        (2.0_f64.powf(0.25), 0.0),
        (root + b, 0.0),
        ((3.0 - damped * damped).sqrt(), -damped),
    ];
    let mut want = want.to_vec();
    want.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert_eq!(found.modes.len(), 4);
    for (mode, (omega, growth)) in found.modes.iter().zip(want) {
        assert!((mode.omega.mid_f64() - omega).abs() < 1e-15, "{mode:?}");
        assert!((mode.growth.mid_f64() - growth).abs() < 1e-15, "{mode:?}");
        assert_eq!(mode.growth.is_zero(), growth == 0.0, "{mode:?}");
        let kind = if growth == 0.0 {
            Kind::Oscillation
        } else {
            Kind::Damped
        };
        assert_eq!(mode.kind, kind);
        assert_eq!((mode.vector.len(), mode.limit), (4, None));
    }
}

#[test]
fn parts_are_ordered_and_cut_as_one() {
    let (_, all) = solve(SEPARATE, &Options::default());
    let omegas: Vec<f64> = all.modes.iter().map(|mode| mode.omega.mid_f64()).collect();
    assert!(omegas.is_sorted(), "{omegas:?}");
    let (_, lowest) = solve(SEPARATE, &Options::default().lowest(2));
    let cut: Vec<f64> = lowest
        .modes
        .iter()
        .map(|mode| mode.omega.mid_f64())
        .collect();
    assert_eq!(cut, omegas[..2]);
    assert!(
        all.modes
            .iter()
            .enumerate()
            .all(|(at, mode)| mode.cluster as usize == at)
    );
}

/// c² = 4 m k in numbers that are irrational, beside anything else: -c/2m twice with one vector. One unit off in the
/// 30th place it is not, and that is decided as well.
#[test]
fn irrational_critical_damping_is_recognised() {
    let energies = "param k = 2  param m = 3/7  coord x, y  T = 1/2*m*x'^2 + 1/2*y'^2
        V = 1/2*k*x^2 + pi/2*y^2";
    for other in ["0", "1/9*y'^2"] {
        let text = format!("{energies}  dissipation = sqrt(k*m)*x'^2 + {other}");
        for digits in [10, 60] {
            let (_, found) = solve(&text, &Options::default().digits(digits));
            assert_eq!(found.stability, Stability::Stable);
            let want = (2.0_f64 * 7.0 / 3.0).sqrt();
            let double: Vec<_> = found
                .modes
                .iter()
                .filter(|mode| mode.omega.is_zero())
                .collect();
            assert_eq!((found.modes.len(), double.len()), (3, 2));
            for mode in double {
                assert_eq!(mode.kind, Kind::Overdamped);
                assert!((mode.growth.mid_f64() + want).abs() < 1e-15, "{mode:?}");
                let limit = Limit::Defective {
                    multiplicity: 2,
                    vectors: 1,
                };
                assert_eq!(mode.limit, Some(limit));
                assert_eq!(mode.precise.is_some(), digits == 60);
                assert!((mode.vector[0] - (7.0_f64 / 3.0).sqrt()).abs() < 1e-15);
                assert_eq!(mode.vector[1], 0.0);
            }
        }
    }
    for (sign, kind) in [("+", Kind::Overdamped), ("-", Kind::Damped)] {
        let text = format!("{energies}  dissipation = sqrt(k*m)*(1 {sign} 1e-30)*x'^2");
        let (_, found) = solve(&text, &Options::default());
        assert!(
            found.modes.iter().any(|mode| mode.kind == kind),
            "{found:?}"
        );
        assert!(
            found.modes.iter().all(|mode| mode.limit.is_none()),
            "{found:?}"
        );
    }
}

/// Equal exponents of separate parts are one cluster: omega = 2^(1/4) twice, and each with its own vector.
#[test]
fn equal_exponents_of_parts_are_one_cluster() {
    let text = "coord a, b, c, d
        T = 1/2*(a'^2 + b'^2 + c'^2 + d'^2)
        V = sqrt(2)/2*(a^2 + b^2) + sqrt(2)/2*c^2 + sqrt(5)/2*d^2 + 1/7*c*d
        dissipation = pi/10*d'^2";
    let (_, found) = solve(text, &Options::default());
    let free: Vec<u32> = found
        .modes
        .iter()
        .filter(|mode| mode.growth.is_zero())
        .map(|mode| mode.cluster)
        .collect();
    assert_eq!(free.len(), 2);
    assert_eq!(free[0], free[1]);
}

/// A free body beside a damped one: the zero keeps its name, and the whole is neutral.
#[test]
fn zero_modes_of_parts_keep_their_names() {
    let text = "coord x, y
        T = 1/2*pi*(x'^2 + y'^2)  V = sqrt(2)*y^2  dissipation = sqrt(3)*y'^2/9";
    let (_, found) = solve(text, &Options::default());
    assert_eq!(found.stability, Stability::Neutral);
    assert_eq!(found.modes[0].kind, Kind::Zero);
    assert!(found.modes[0].meaning.is_some());
    assert_eq!(found.modes[1].kind, Kind::Damped);
}

/// What grows without friction is left to the whole: it has both exponents, as a damped model lists them.
#[test]
fn what_grows_has_both_exponents_as_before() {
    let text = "coord x, y
        T = 1/2*(x'^2 + y'^2)  V = -sqrt(2)/2*x^2 + y^2  dissipation = pi/10*y'^2";
    let (_, found) = solve(text, &Options::default());
    assert_eq!(found.stability, Stability::Unstable);
    let growths: Vec<f64> = found
        .modes
        .iter()
        .map(|mode| mode.growth.mid_f64())
        .collect();
    let s = 2.0_f64.powf(0.25);
    assert!((growths[0] - s).abs() < 1e-14, "{growths:?}");
    assert!(
        growths.iter().any(|growth| (growth + s).abs() < 1e-14),
        "{growths:?}"
    );
}

/// Oil that turns does work round loops, more than it takes out where it turns fast; a belt in a straight line does
/// none.
#[test]
fn friction_that_drives_loops_is_told() {
    let energies = "param u = 3  coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*(x^2 + y^2)";
    for (friction, told) in [
        ("1/10*((x' + u*y)^2 + (y' - u*x)^2)", true),
        ("1/10*((x' - u)^2 + (y' - u)^2)", false),
        ("1/10*((x' + u/6*y)^2 + (y' - u/6*x)^2)", false),
        ("1/10*(x'*y - y'*x)", true),
        ("-1/10*u*x'^2", true),
    ] {
        let (linearized, modes) = solve(
            &format!("{energies}  dissipation = {friction}"),
            &Options::default(),
        );
        let codes: Vec<&str> = warnings(&linearized, &modes)
            .iter()
            .map(|warning| warning.code())
            .collect();
        assert_eq!(codes.contains(&"W0106"), told, "{friction}: {codes:?}");
    }
}
