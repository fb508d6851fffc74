//! Motions that no friction reaches beside damped ones, and repeated exponents: what they are is decided.
#![cfg(feature = "engine")]

use crate::common;

use common::model;
use librate::linearize::{Linearized, linearize};
use librate::modes::{Kind, Limit, Options, Stability};
use librate::number::Number;
use librate::oscillation::{NormalMode, NormalModes, normal_modes};
use librate::precision::{Big, Rounding};

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
    let want = [(root - b, 0.0), (2.0_f64.powf(0.25), 0.0), (root + b, 0.0), ((3.0 - damped * damped).sqrt(), -damped)];
    let mut want = want.to_vec();
    want.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert_eq!(found.modes.len(), 4);
    for (mode, (omega, growth)) in found.modes.iter().zip(want) {
        assert!((mode.omega.mid_f64() - omega).abs() < 1e-15, "{mode:?}");
        assert!((mode.growth.mid_f64() - growth).abs() < 1e-15, "{mode:?}");
        assert_eq!(mode.growth.is_zero(), growth == 0.0, "{mode:?}");
        let kind = if growth == 0.0 { Kind::Oscillation } else { Kind::Damped };
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
    let cut: Vec<f64> = lowest.modes.iter().map(|mode| mode.omega.mid_f64()).collect();
    assert_eq!(cut, omegas[..2]);
    assert!(all.modes.iter().enumerate().all(|(at, mode)| mode.cluster as usize == at));
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
            let double: Vec<_> = found.modes.iter().filter(|mode| mode.omega.is_zero()).collect();
            assert_eq!((found.modes.len(), double.len()), (3, 2));
            for mode in double {
                assert_eq!(mode.kind, Kind::Overdamped);
                assert!((mode.growth.mid_f64() + want).abs() < 1e-15, "{mode:?}");
                let limit = Limit::Defective { order: 2 };
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
        assert!(found.modes.iter().any(|mode| mode.kind == kind), "{found:?}");
        assert!(found.modes.iter().all(|mode| mode.limit.is_none()), "{found:?}");
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
    let free: Vec<u32> = found.modes.iter().filter(|mode| mode.growth.is_zero()).map(|mode| mode.cluster).collect();
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
    assert_eq!(found.zero_motions.len(), 1);
    assert_eq!(found.modes[1].kind, Kind::Damped);
}

/// What grows without friction is left to the whole: it has both exponents, as a damped model lists them.
#[test]
fn what_grows_has_both_exponents_as_before() {
    let text = "coord x, y
        T = 1/2*(x'^2 + y'^2)  V = -sqrt(2)/2*x^2 + y^2  dissipation = pi/10*y'^2";
    let (_, found) = solve(text, &Options::default());
    assert_eq!(found.stability, Stability::Unstable);
    let growths: Vec<f64> = found.modes.iter().map(|mode| mode.growth.mid_f64()).collect();
    let s = 2.0_f64.powf(0.25);
    assert!((growths[0] - s).abs() < 1e-14, "{growths:?}");
    assert!(growths.iter().any(|growth| (growth + s).abs() < 1e-14), "{growths:?}");
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
        let (linearized, modes) = solve(&format!("{energies}  dissipation = {friction}"), &Options::default());
        let codes: Vec<&str> = modes.warnings(&linearized).iter().filter_map(|warning| warning.code).collect();
        assert_eq!(codes.contains(&"W0106"), told, "{friction}: {codes:?}");
    }
}

/// What is known of a repeated exponent: growth, omega, and the sizes of its Jordan blocks, one for each entry.
type Repeated = (f64, f64, &'static [usize]);

/// The entries at an exponent have the blocks that are expected, with one shape each; shapes solve λ²Mx + λDx + Sx = 0 and
/// are orthonormal.
fn holds(text: &str, stability: Stability, secular: bool, repeated: &[Repeated]) {
    let (linearized, found) = solve(text, &Options::default());
    assert_eq!((found.stability, found.secular), (stability, Some(secular)), "{text}");
    let n = linearized.dimension();
    let mass = linearized.mass();
    let (velocity, stiffness) = linearized.velocity_and_stiffness();
    for (growth, omega, orders) in repeated {
        let own: Vec<_> = found
            .modes
            .iter()
            .filter(|mode| (mode.growth.mid_f64() - growth).hypot(mode.omega.mid_f64() - omega) < 1e-9)
            .collect();
        let sizes: Vec<usize> = own
            .iter()
            .map(|mode| match mode.limit {
                Some(Limit::Defective { order }) => order,
                None => 1,
                other => panic!("{text}: {other:?}"),
            })
            .collect();
        assert_eq!(sizes, *orders, "{text}: {growth} {omega}");
        // Real and imaginary parts, and their products.
        let part = |x: &[f64], i: usize| x.get(i).copied().unwrap_or(0.0);
        let shape = |at: usize, i: usize| (part(&own[at].vector, i), part(&own[at].imaginary, i));
        let times = |x: (f64, f64), y: (f64, f64)| (x.0 * y.0 - x.1 * y.1, x.0 * y.1 + x.1 * y.0);
        let lambda = (*growth, *omega);
        for at in 0..own.len() {
            assert!(own[at].vector_error_bound < 1e-12, "{text}: {:?}", own[at]);
            for i in 0..n {
                let mut sum = (0.0, 0.0);
                for j in 0..n {
                    let k = i + n * j;
                    let l = times(times(lambda, lambda), (mass[k].mid_f64(), 0.0));
                    let d = times(lambda, (velocity[k].mid_f64(), 0.0));
                    let term = times((l.0 + d.0 + stiffness[k].mid_f64(), l.1 + d.1), shape(at, j));
                    sum = (sum.0 + term.0, sum.1 + term.1);
                }
                assert!(sum.0.hypot(sum.1) < 1e-11, "{text}: {sum:?} {:?}", own[at]);
            }
            for other in 0..at {
                let mut product = (0.0, 0.0);
                for i in 0..n {
                    for j in 0..n {
                        let (x, y) = (shape(other, i), shape(at, j));
                        let term = times((x.0, -x.1), y);
                        let m = mass[i + n * j].mid_f64();
                        product = (product.0 + m * term.0, product.1 + m * term.1);
                    }
                }
                let size = product.0.hypot(product.1);
                let same = own[at].vector == own[other].vector;
                assert!((size - if same { 1.0 } else { 0.0 }).abs() < 1e-12, "{text}: {size}");
            }
        }
        // One shape a block; a block of even size at 0 without friction has half as many entries.
        let mut shapes: Vec<&Vec<f64>> = own.iter().map(|mode| &mode.vector).collect();
        shapes.dedup();
        let mut blocks = 0;
        let mut at = 0;
        while at < sizes.len() {
            let entries = match own[at].kind {
                Kind::Zero if sizes[at] > 2 => sizes.iter().filter(|size| **size == sizes[at]).count(),
                Kind::Zero => 1,
                _ => sizes[at],
            };
            blocks += 1;
            at += entries;
        }
        assert_eq!(shapes.len(), blocks, "{text}: {growth} {omega}");
    }
}

/// Every mode once for its multiplicity, Jordan blocks by their sizes, shapes that span what they claim.
#[test]
fn jordan_blocks_have_their_sizes() {
    let two = "coord x, y  T = 1/2*(x'^2 + y'^2)";
    let cases: &[(String, Stability, bool, &[Repeated])] = &[
        // Two oscillators damped critically: twice a block of 2.
        (
            format!("{two}  V = 1/2*(x^2 + y^2)  dissipation = x'^2 + y'^2"),
            Stability::Stable,
            false,
            &[(-1.0, 0.0, &[2, 2, 2, 2])],
        ),
        // The same in other coordinates.
        (
            "coord x, y  T = 1/2*((x' + 2*y')^2 + (3*x' + 5*y')^2)
             V = 1/2*((x + 2*y)^2 + (3*x + 5*y)^2)
             dissipation = (x' + 2*y')^2 + (3*x' + 5*y')^2"
                .to_owned(),
            Stability::Stable,
            false,
            &[(-1.0, 0.0, &[2, 2, 2, 2])],
        ),
        // One critical, one with -1 and -3; and free ones with -1.
        (
            format!("{two}  V = 1/2*x^2 + 3/2*y^2  dissipation = x'^2 + 2*y'^2"),
            Stability::Stable,
            false,
            &[(-1.0, 0.0, &[2, 2, 1]), (-3.0, 0.0, &[1])],
        ),
        (
            "coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)  V = 1/2*x^2
             dissipation = x'^2 + 1/2*(y'^2 + z'^2)"
                .to_owned(),
            Stability::Neutral,
            false,
            &[(-1.0, 0.0, &[2, 2, 1, 1]), (0.0, 0.0, &[1, 1])],
        ),
        // A degenerate real exponent with enough shapes.
        (
            format!("{two}  V = 1/2*(x - y)^2  dissipation = 1/2*((x' - y')^2 + x'^2 + y'^2)"),
            Stability::Neutral,
            false,
            &[(-1.0, 0.0, &[1, 1]), (-2.0, 0.0, &[1]), (0.0, 0.0, &[1])],
        ),
        // λ³(λ + 1), and λ⁴ without friction: motions grow as t² and t³.
        (
            "coord x, y  T = 1/2*(x'^2 + y'^2) + 2*x*y'  V = -2*x^2  dissipation = 1/2*x'^2".to_owned(),
            Stability::Neutral,
            true,
            &[(0.0, 0.0, &[3]), (-1.0, 0.0, &[1])],
        ),
        (
            "coord x, y  T = 1/2*(x'^2 + y'^2) + 2*x*y'  V = -2*x^2".to_owned(),
            Stability::Neutral,
            true,
            &[(0.0, 0.0, &[4, 4])],
        ),
        // A charge in a magnetic field: a drift along it, a guiding centre, a gyration.
        (
            "coord x, y, z
             lagrangian = 1/2*(x'^2 + y'^2 + z'^2) + 1/2*(x*y' - y*x')"
                .to_owned(),
            Stability::Neutral,
            false,
            &[(0.0, 0.0, &[1, 1]), (0.0, 1.0, &[1])],
        ),
        // Where a top falls asleep, alone and beside two oscillators of its frequency, of which one is a second such top.
        (
            "coord x, y  lagrangian = 1/2*(x'^2 + y'^2 + x^2 + y^2) + x*y' - y*x'".to_owned(),
            Stability::Neutral,
            true,
            &[(0.0, 1.0, &[2, 2])],
        ),
        (
            "coord x, y, z, w  lagrangian = 1/2*(x'^2 + y'^2 + x^2 + y^2) + x*y' - y*x'
             + 1/2*(z'^2 + w'^2 - z^2 - w^2)"
                .to_owned(),
            Stability::Neutral,
            true,
            &[(0.0, 1.0, &[2, 2, 1, 1])],
        ),
        (
            "coord x, y, z, w  lagrangian = 1/2*(x'^2 + y'^2 + x^2 + y^2) + x*y' - y*x'
             + 1/2*(z'^2 + w'^2 + z^2 + w^2) + w*z' - z*w'"
                .to_owned(),
            Stability::Neutral,
            true,
            &[(0.0, 1.0, &[2, 2, 2, 2])],
        ),
        // A ring of four with friction: equal complex exponents, and their shapes are real.
        (
            "coord x[1..4]  T = 1/2*sum(i in 1..4, x[i]'^2)
             V = 1/2*sum(i in 1..3, (x[i+1] - x[i])^2) + 1/2*(x[1] - x[4])^2 + 1/2*sum(i in 1..4, x[i]^2)
             dissipation = 1/10*sum(i in 1..4, x[i]'^2)"
                .to_owned(),
            Stability::Stable,
            false,
            &[(-0.1, 2.99_f64.sqrt(), &[1, 1])],
        ),
        // Irrational numbers: friction alone leaves both matrices symmetric, and equal real exponents have their shapes.
        (format!("{two}  V = sqrt(2)/2*(x^2 + y^2)  dissipation = 2*(x'^2 + y'^2)"), Stability::Stable, false, &[]),
    ];
    for (text, stability, secular, repeated) in cases {
        holds(text, *stability, *secular, repeated);
    }
}

/// Equal real exponents of irrational matrices: kinds are decided, shapes are the coordinates.
#[test]
fn equal_real_exponents_of_irrational_numbers_are_real() {
    let text = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = sqrt(2)/2*(x^2 + y^2)
        dissipation = 2*(x'^2 + y'^2)";
    let (_, found) = solve(text, &Options::default());
    assert!(found.modes.iter().all(|mode| mode.kind == Kind::Overdamped));
    let shapes: Vec<Vec<f64>> = found.modes.iter().map(|mode| mode.vector.clone()).collect();
    let (x, y) = (vec![1.0, 0.0], vec![0.0, 1.0]);
    assert_eq!(shapes, [x.clone(), y.clone(), x, y]);
}

/// All directions that are free are named, more than there are entries.
#[test]
fn the_kernel_is_named_as_a_whole() {
    let text = "coord x, y, z
        lagrangian = 1/2*(x'^2 + y'^2 + z'^2) + 1/2*(x*y' - y*x')";
    let (_, found) = solve(text, &Options::default());
    assert_eq!(found.zero_motions, ["x is free", "y is free", "z is free"]);
    let zero = &found.modes[..2];
    assert_eq!(zero[0].vector, [0.0, 0.0, 1.0]);
    let half = 0.5_f64.sqrt();
    assert!((zero[1].vector[0] - half).abs() < 1e-15 && (zero[1].imaginary[1] - half).abs() < 1e-15);
}

/// Without friction and rotation, forces that go round leave pairs ±s: n entries, the growing one of a real pair, both of
/// ±a ± ib, half of the zeros.
#[test]
fn circulatory_forces_alone_leave_pairs() {
    use Kind::{Damped, Oscillation, Unstable, Zero};
    type Entry = (Kind, f64, f64);
    let root = |x: f64| x.sqrt();
    // s² = -3/2 ± i √(4ν² - 1)/2 for ν = 2.
    let (a, b) = (-1.5, root(15.0) / 2.0);
    let modulus = root(a * a + b * b);
    let flutter = (root((modulus + a) / 2.0), root((modulus - a) / 2.0));
    let e = 1.0_f64.exp();
    let split = root(9.0 - 1.0 / 16.0);
    let cases: &[(&str, Stability, &[Entry])] = &[
        (
            "V = -x^2/2 - 2*y^2  dissipation = (x'*y - y'*x)/8",
            Stability::Unstable,
            &[(Unstable, root((5.0 + split) / 2.0), 0.0), (Unstable, root((5.0 - split) / 2.0), 0.0), (Zero, 0.0, 0.0)],
        ),
        (
            "V = x^2/2 + y^2 + z^2/2  dissipation = 2*(x'*y - y'*x)",
            Stability::Unstable,
            &[(Unstable, flutter.0, flutter.1), (Oscillation, 0.0, 1.0), (Damped, -flutter.0, flutter.1)],
        ),
        (
            "V = sqrt(2)/2*z^2  dissipation = exp(1)*(x'*y - y'*x)",
            Stability::Unstable,
            &[
                (Unstable, root(e / 2.0), root(e / 2.0)),
                (Damped, -root(e / 2.0), root(e / 2.0)),
                (Oscillation, 0.0, 2.0_f64.powf(0.25)),
            ],
        ),
        (
            "V = pi*(x^2 - z^2)  dissipation = exp(1)*(y'*x - 2*y'*z)",
            Stability::Unstable,
            &[
                (Unstable, root(2.0 * std::f64::consts::PI), 0.0),
                (Zero, 0.0, 0.0),
                (Oscillation, 0.0, root(2.0 * std::f64::consts::PI)),
            ],
        ),
        // N symmetric: springs, only written otherwise.
        (
            "V = x^2 + z^2  dissipation = x'*y + y'*x",
            Stability::Unstable,
            &[
                (Unstable, root(root(2.0) - 1.0), 0.0),
                (Oscillation, 0.0, root(2.0)),
                (Oscillation, 0.0, root(1.0 + root(2.0))),
            ],
        ),
    ];
    for (text, stability, entries) in cases {
        let text = format!("coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)  {text}");
        let (_, found) = solve(&text, &Options::default());
        assert_eq!(found.stability, *stability, "{text}");
        assert_eq!(found.modes.len(), entries.len(), "{text}");
        for (mode, (kind, growth, omega)) in found.modes.iter().zip(*entries) {
            assert_eq!(mode.kind, *kind, "{text}: {mode:?}");
            assert!((mode.growth.mid_f64() - growth).abs() < 1e-14, "{text}");
            assert!((mode.omega.mid_f64() - omega).abs() < 1e-14, "{text}");
            assert_eq!(mode.growth.is_zero(), *growth == 0.0, "{text}");
            assert_eq!(mode.omega.is_zero(), *omega == 0.0, "{text}");
        }
    }
    // A block of 4 at 0 that no arithmetic decides is said to be open.
    let (_, open) =
        solve("param c = exp(1)  coord x, z  T = 1/2*(x'^2 + z'^2)  dissipation = c/20*x*z'", &Options::default());
    assert_eq!(open.stability, Stability::Undecided);
    assert!(open.modes.iter().all(|mode| mode.kind == Kind::Undecided));
    let repeated: &[(&str, Stability, bool, &[Repeated])] = &[
        ("V = 1/2*(x^2 + y^2)  dissipation = 1/2*x'*y", Stability::Neutral, true, &[(0.0, 1.0, &[2, 2])]),
        ("V = -1/2*(x^2 + y^2)  dissipation = 1/2*x'*y", Stability::Unstable, false, &[(1.0, 0.0, &[2, 2])]),
        ("dissipation = x'*y", Stability::Neutral, true, &[(0.0, 0.0, &[4, 4])]),
    ];
    for (text, stability, secular, repeated) in repeated {
        let text = format!("coord x, y  T = 1/2*(x'^2 + y'^2)  {text}");
        holds(&text, *stability, *secular, repeated);
    }
}

/// A zero mode of friction at rest that no symmetry explains has no other one's name.
#[test]
fn zero_modes_of_circulatory_forces_are_named() {
    let (_, found) = solve(
        "coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)
         V = 1/2*x^2 - x*y  dissipation = x'*y - y'*x",
        &Options::default(),
    );
    assert_eq!(found.zero_motions, ["z is free", "no restoring force to second order"]);
}

/// Square roots in the entries that units take away: boundaries of gyroscopic stability, blocks at 0; and a searched equilibrium
/// that is a fraction.
#[test]
fn blocks_of_irrational_models_are_decided() {
    let cases: &[(&str, Stability, bool, &[Repeated])] = &[
        (
            "param b = sqrt(2)  coord x, y
             lagrangian = 1/2*(x'^2 + y'^2) + b*(x*y' - y*x') + b^2/2*(x^2 + y^2)",
            Stability::Neutral,
            true,
            &[(0.0, 2.0_f64.sqrt(), &[2, 2])],
        ),
        (
            "coord x, y  T = 1/2*(x'^2 + y'^2) + 2*sqrt(1/3)*x*y'  V = -2/3*x^2",
            Stability::Neutral,
            true,
            &[(0.0, 0.0, &[4, 4])],
        ),
        (
            "param s = sqrt(1/3)  coord x, y, z
             lagrangian = 1/2*(x'^2 + y'^2 + z'^2) + s*(x*y' - y*x' + y*z' - z*y' + z*x' - x*z')",
            Stability::Neutral,
            false,
            &[(0.0, 0.0, &[1, 1]), (0.0, 2.0, &[1])],
        ),
        // Lengths in units of their own.
        (
            "param b = sqrt(2)  coord x, y
             T = 1/2*(x'^2 + 3*y'^2) + b*sqrt(3)*(x*y' - y*x')  V = -1/2*b^2*(x^2 + 3*y^2)",
            Stability::Neutral,
            true,
            &[(0.0, 2.0_f64.sqrt(), &[2, 2])],
        ),
        (
            "coord x  T = 1/2*x'^2  V = 1/4*(x^2 - 16/9)^2  dissipation = 2*sqrt(8/9)*x'^2  guess x = 1",
            Stability::Stable,
            false,
            &[(-1.885_618_083_164_126_7, 0.0, &[2, 2])],
        ),
    ];
    for (text, stability, secular, repeated) in cases {
        holds(text, *stability, *secular, repeated);
    }
}

/// Critical damping at equilibria that are solutions of quadratic equations or angles with such cosines, of one coordinate and of several.
#[test]
fn critical_damping_at_algebraic_equilibria_is_decided() {
    let cases: &[(&str, &[Repeated])] = &[
        ("coord x  T = 1/2*x'^2  V = (x^2 - 2)^2/4  dissipation = 2*x'^2  guess x = 3/2", &[(-2.0, 0.0, &[2, 2])]),
        // The golden section, where V'' is the root of 5.
        (
            "coord x  T = 1/2*x'^2  V = x^3/3 - x^2/2 - x  dissipation = 5^(1/4)*x'^2  guess x = 3/2",
            &[(-1.495_348_781_221_220_5, 0.0, &[2, 2])],
        ),
        (
            "coord x  T = 1/2*x'^2  V = x/2 - sin(x)  dissipation = sqrt(sqrt(3)/2)*x'^2  guess x = 1",
            &[(-0.930_604_859_102_099_6, 0.0, &[2, 2])],
        ),
        (
            "coord x, y  T = 1/2*(x'^2 + y'^2)
             V = (x^2 - 2)^2/4 + (y^2 - 3)^2/4
             dissipation = 2*x'^2 + sqrt(6)*y'^2  guess x = 1  guess y = 2",
            &[(-2.0, 0.0, &[2, 2]), (-2.449_489_742_783_178, 0.0, &[2, 2])],
        ),
    ];
    for (text, repeated) in cases {
        holds(text, Stability::Stable, false, repeated);
    }
}

/// Entries that are combinations of one square root or of two, which no units take away.
#[test]
fn repeated_exponents_of_irrational_combinations_are_decided() {
    let cases: &[(&str, Stability, bool, &[Repeated])] = &[
        (
            "let u = x + sqrt(2)*y  let v = sqrt(3)*x + y
             T = 1/2*(u'^2 + v'^2)  V = 1/2*(u^2 + v^2)  dissipation = u'^2 + v'^2",
            Stability::Stable,
            false,
            &[(-1.0, 0.0, &[2, 2, 2, 2])],
        ),
        (
            "let u = x + sqrt(2)*y  let v = y - sqrt(2)*x
             T = 1/2*(u'^2 + v'^2)  V = 1/2*(u^2 + v^2)  dissipation = 1/3*u'*v",
            Stability::Neutral,
            true,
            &[(0.0, 1.0, &[2, 2])],
        ),
        // A root that only the conjugate has, too: 1 + sqrt(2) beside 3.
        (
            "let u = x + (1 + sqrt(2))*y  let v = y
             T = 1/2*(u'^2 + v'^2)  V = 1/2*(1 + sqrt(2))*(u^2 + v^2)",
            Stability::Stable,
            false,
            &[],
        ),
        (
            "let u = x + (1 + sqrt(2))*y  let v = (2 - sqrt(3))*y
             T = 1/2*(u'^2 + v'^2)  V = 3/2*u^2  dissipation = u'^2*sqrt(3) + 1/2*v'^2",
            Stability::Neutral,
            false,
            &[(-1.732_050_807_568_877_2, 0.0, &[2, 2]), (0.0, 0.0, &[1]), (-1.0, 0.0, &[1])],
        ),
    ];
    for (text, stability, secular, repeated) in cases {
        holds(&format!("coord x, y  {text}"), *stability, *secular, repeated);
    }
}

/// Lagrange's triangle of equal masses with the side, the rate or the distance from the centre of 1, given or searched for: 27 times the
/// product of the masses over the square of their sum is over 1, (1 ± sqrt(-2))/2 of Routh, and the centre of mass goes round with the
/// rate, once in a chain of 2.
#[test]
fn the_triangle_of_lagrange_is_decided() {
    let law = "T = sum(i in 1..3, 1/2*((x[i]' - W*y[i])^2 + (y[i]' + W*x[i])^2))
               V = -sum(i in 1..3, j in i+1..3, 1/sqrt((x[i] - x[j])^2 + (y[i] - y[j])^2))";
    let places = "x[1] = a/sqrt(3)  S x[2] = -a/(2*sqrt(3))  S x[3] = -a/(2*sqrt(3))
                  S y[1] = 0  S y[2] = a/2  S y[3] = -a/2";
    let given = format!("equilibrium {}", places.replace('S', "equilibrium"));
    let guessed = "guess x[1] = 0.577  guess x[2] = -0.2886  guess x[3] = -0.2886
                   guess y[2] = 1/2  guess y[3] = -1/2";
    for (rate, side, place) in [
        (1.0, "W = 1  param a = 3^(1/3)", given.as_str()),
        (3.0_f64.sqrt(), "W = sqrt(3)  param a = 1", given.as_str()),
        (3.0_f64.powf(-0.25), "W = (1/3)^(1/4)  param a = sqrt(3)", given.as_str()),
        (3.0_f64.sqrt(), "W = sqrt(3)", guessed),
    ] {
        let text = format!("param {side}  coord x[1..3], y[1..3]  {law}  {place}");
        let (_, found) = solve(&text, &Options::default());
        assert_eq!((found.stability, found.secular), (Stability::Unstable, Some(true)), "{text}");
        let rounded = |x: f64| (x * 1e10).round() / 1e10;
        let entries = found.modes.iter().map(|mode| {
            let [growth, omega] = [mode.growth, mode.omega].map(|x| x.mid_f64() / rate);
            let order = match mode.limit {
                Some(Limit::Defective { order }) => order,
                None => 1,
                other => panic!("{text}: {other:?}"),
            };
            (mode.kind, rounded(growth), rounded(omega), order)
        });
        let entries: Vec<_> = entries.collect();
        let growth = rounded(std::f64::consts::FRAC_1_SQRT_2);
        assert_eq!(
            entries,
            [
                (Kind::Unstable, growth, 1.0, 1),
                (Kind::Zero, 0.0, 0.0, 1),
                (Kind::Oscillation, 0.0, 1.0, 2),
                (Kind::Oscillation, 0.0, 1.0, 2),
                (Kind::Oscillation, 0.0, 1.0, 1),
                (Kind::Damped, -growth, 1.0, 1),
            ],
            "{text}"
        );
    }
}

/// A steady rotation beside friction: the angle drifts with its own rate, a block of 2 at 0 whatever the numbers are.
#[test]
fn steady_rotation_beside_friction_is_neutral() {
    for (rate, stiffness) in [("1", "3"), ("sqrt(2)", "6"), ("1/3", "pi")] {
        let text = format!(
            "param W = {rate}  param k = {stiffness}  coord th, r
             T = 1/2*((1 + r)^2*th'^2 + r'^2)  V = 1/2*k*r^2  dissipation = 1/10*r'^2
             equilibrium th' = W"
        );
        let (_, found) = solve(&text, &Options::default());
        assert_eq!((found.stability, found.secular), (Stability::Neutral, Some(false)), "{text}");
        let kinds: Vec<Kind> = found.modes.iter().map(|mode| mode.kind).collect();
        assert_eq!(kinds, [Kind::Zero, Kind::Damped], "{text}");
        assert_eq!(found.zero_motions, ["th is free"]);
    }
}

/// Rates of decay that are far apart: c/m and k/c of one coordinate, whatever the numbers are; and of two that are coupled.
#[test]
fn rates_far_apart_are_found() {
    let relative = |found: f64, want: f64| (found / want - 1.0).abs();
    for (mass, damping, stiffness) in
        [("1", "1", "1e-17"), ("1e-30", "1", "sqrt(2)*1e-20"), ("7", "1e30", "1e-30"), ("pi*1e-25", "3e20", "1e-30")]
    {
        let text = format!(
            "param m = {mass}  param c = {damping}  param k = {stiffness}
             coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2  dissipation = 1/2*c*x'^2"
        );
        let (linearized, found) = solve(&text, &Options::default());
        let value = |matrix: &[librate::precision::Ball]| matrix[0].mid_f64();
        let m = value(&linearized.mass());
        let c = value(&linearized.damping().unwrap());
        let k = value(&linearized.stiffness());
        assert_eq!(found.stability, Stability::Stable, "{text}");
        let growths: Vec<f64> = found.modes.iter().map(|mode| mode.growth.mid_f64()).collect();
        assert_eq!(growths.len(), 2, "{text}");
        assert!(relative(growths[0], -k / c) < 1e-14, "{text}: {growths:?}");
        assert!(relative(growths[1], -c / m) < 1e-14, "{text}: {growths:?}");
        assert!(found.modes.iter().all(|mode| mode.kind == Kind::Overdamped));
    }
    // Fifty orders of magnitude between the slowest and the fastest.
    let text = "coord x, y  T = 1/2*(x'^2 + 1e-10*y'^2)  V = 1/2*(1e-20*x^2 + 1e-12*(x - y)^2)
        dissipation = 1/2*(x'^2 + 1e10*y'^2)";
    let (_, found) = solve(text, &Options::default());
    assert!(found.modes.iter().all(|mode| mode.kind == Kind::Overdamped));
    assert_eq!(found.modes.len(), 4);
}

/// An entry of the matrices: its value, row and column (from 1), and the power of the rate in its unit.
type Entry = (f64, usize, usize, i64);

/// A model in coordinates of 10^-lengths of their units, energies of 10^energy and rates of 10^rate.
fn in_units(energies: [&[Entry]; 4], lengths: [i64; 2], energy: i64, rate: i64) -> String {
    let term = |(value, i, j, order): &Entry, first: &str, second: &str| {
        let power = lengths[i - 1] + lengths[j - 1] + energy + order * rate;
        format!(" + ({value})*1e{power}*x[{i}]{first}*x[{j}]{second}")
    };
    let sum = |entries: &[Entry], first: &str, second: &str| -> String {
        entries.iter().map(|own| term(own, first, second)).collect()
    };
    let [mass, stiffness, rotation, friction] = energies;
    format!(
        "coord x[1..2]\nlagrangian = 0{}{} - (0{})\ndissipation = 0{}\n",
        sum(mass, "'", "'"),
        sum(rotation, "", "'"),
        sum(stiffness, "", ""),
        sum(friction, "'", "'"),
    )
}

fn exponent(mode: &NormalMode) -> [Big; 2] {
    match mode.precise.as_deref() {
        Some(precise) => [precise.omega.clone(), precise.growth.clone()],
        None => [&mode.omega, &mode.growth].map(|x| Big::from_ball(x, 200)),
    }
}

fn ten(power: i64) -> Big {
    Big::from_number(&Number::parse(&format!("1e{power}")).unwrap(), 200)
}

#[test]
fn units_far_from_usual_ones_change_nothing() {
    let masses: &[Entry] = &[(1.0, 1, 1, 0), (1.0, 1, 2, 0), (1.5, 2, 2, 0)];
    let bound: &[Entry] = &[(2.5, 1, 1, 2), (-2.0, 1, 2, 2), (2.0, 2, 2, 2)];
    let saddle: &[Entry] = &[(2.5, 1, 1, 2), (-8.0, 1, 2, 2), (2.0, 2, 2, 2)];
    let top: &[Entry] = &[(-0.5, 1, 1, 2), (-0.25, 2, 2, 2)];
    let free: &[Entry] = &[(0.5, 1, 1, 2), (-1.0, 1, 2, 2), (0.5, 2, 2, 2)];
    let turning: &[Entry] = &[(3.0, 1, 2, 1), (-3.0, 2, 1, 1)];
    let friction: &[Entry] = &[(0.5, 1, 1, 1), (0.25, 2, 2, 1)];
    let heavy: &[Entry] = &[(50.0, 1, 1, 1), (0.25, 2, 2, 1)];
    let models: [[&[Entry]; 4]; 8] = [
        [masses, bound, &[], &[]],
        [masses, saddle, &[], &[]],
        [masses, free, &[], &[]],
        [masses, bound, &[], friction],
        [masses, bound, turning, friction],
        [masses, top, turning, &[]],
        [masses, bound, &[], heavy],
        [masses, free, &[], friction],
    ];
    let units = [
        ([140, -140], 0, 0),
        ([0, 0], 290, 0),
        ([0, 0], -295, 0),
        ([0, 0], 0, 145),
        ([0, 0], 0, -145),
        ([70, -60], -70, 35),
        ([-15, 15], 3, 20),
    ];
    for (number, model) in models.into_iter().enumerate() {
        let (_, plain) = solve(&in_units(model, [0, 0], 0, 0), &Options::default());
        for (lengths, energy, rate) in units {
            let text = in_units(model, lengths, energy, rate);
            let (_, found) = solve(&text, &Options::default());
            let at = format!("model {number}, {lengths:?} {energy} {rate}");
            assert_eq!(found.stability, plain.stability, "{at}");
            assert_eq!(found.secular, plain.secular, "{at}");
            assert_eq!(found.modes.len(), plain.modes.len(), "{at}");
            for (mode, want) in found.modes.iter().zip(&plain.modes) {
                assert_eq!((mode.kind, mode.limit), (want.kind, want.limit), "{at}");
                for (x, want) in exponent(mode).iter().zip(exponent(want)) {
                    let x = x * &ten(-rate);
                    let off = (&x - &want).abs_upper().to_f64();
                    assert!(off <= 1e-13 * want.mid_f64().abs(), "{at}: {x:?} {want:?}");
                }
                // Shapes are those of the plain model, in units of energy and rate too; their sign is that of the largest component.
                let size =
                    |mode: &NormalMode, i: usize| mode.vector[i].hypot(mode.imaginary.get(i).copied().unwrap_or(0.0));
                for i in 0..2 {
                    let unit = &ten(lengths[i]) * &ten(energy).sqrt();
                    let number = |x: f64| &Big::from_f64(x, 200) * &unit;
                    let off = number(size(mode, i)).mid_f64() - size(want, i);
                    let bound = number(mode.error_bound_of(i)).mid_f64();
                    assert!(off.abs() <= 2.0 * bound + 1e-14, "{at}: {off:e} {bound:e}");
                    let tells = lengths == [0, 0] || !mode.component_error_bounds.is_empty();
                    assert!(!tells || bound < 1e-12, "{at}: {bound:e}");
                }
            }
        }
    }
}

#[test]
fn exponents_far_apart_are_decided() {
    // Of one coordinate by itself: m, c, k.
    for (c, slow, fast) in [("1e70", -70, 70), ("1e140", -140, 140), ("1e150", -150, 150)] {
        let text = format!("coord x  T = x'^2/2  V = x^2/2  dissipation = {c}*x'^2/2");
        let (_, found) = solve(&text, &Options::default());
        assert_eq!(found.stability, Stability::Stable);
        for (mode, power) in found.modes.iter().zip([slow, fast]) {
            assert_eq!(mode.kind, Kind::Overdamped, "{c}");
            let off = (&exponent(mode)[1] + &ten(power)).abs_upper().to_f64();
            assert!(off <= 1e-10 * ten(power).mid_f64(), "{c}: {mode:?}");
        }
    }
}

#[test]
fn small_ways_are_found() {
    for (k, l) in [(-300, -120), (-100, -120), (0, -120), (200, -140)] {
        let text = format!(
            "param k = 1e{k}  param l = 1e{l}  coord x  T = x'^2/2
            V = k*(x - l)^2/2 + k*(x - l)^4/l^2"
        );
        let (linearized, found) = solve(&text, &Options::default());
        let place = linearized.equilibrium();
        let want = ten(l).mid_f64();
        assert!(place.proved && (place.values[0].mid_f64() - want).abs() <= 1e-12 * want);
        let omega = &exponent(&found.modes[0])[0];
        let off = (omega - &ten(k / 2)).abs_upper().to_f64();
        assert!(off <= 1e-12 * ten(k / 2).mid_f64(), "{text}: {omega:?}");
    }
}

#[test]
fn exponential_parameters_have_frequencies() {
    for power in [-1400_i32, -800, 700, 800, 1300] {
        let text = format!("param k = exp({power})  coord x  T = x'^2/2  V = k*x^2/2");
        let (_, found) = solve(&text, &Options::default());
        assert_eq!((found.stability, found.modes[0].kind), (Stability::Stable, Kind::Oscillation));
        let want = f64::from(power / 2).exp();
        let off = (found.modes[0].omega.mid_f64() - want).abs();
        assert!(off <= 1e-13 * want, "{power}: {:?}", found.modes[0]);
    }
}

#[test]
fn one_vector_for_two_exponents_is_no_pair_of_shapes() {
    // Triangular: friction takes one of two equal couplings away.
    let (_, found) = solve(
        "coord x, y  T = 1e14/2*x'^2 + 1e2/2*y'^2  V = 1e16/2*x^2 - 1e10/2*x*y + 1e4/2*y^2
        dissipation = 1e15/2*x'^2 - 1e10/2*x'*y + 1e10/2*y'*x + 1e3/2*y'^2",
        &Options::default(),
    );
    let blocks = found.modes.iter().map(|mode| mode.limit);
    let blocks: Vec<Option<Limit>> = blocks.collect();
    assert_eq!(blocks, [Some(Limit::Defective { order: 2 }); 2]);
    assert!(found.modes.iter().all(|mode| mode.vector[1] == 0.0));
}

/// What is printed of omega and growth of the first mode.
fn printed(text: &str, digits: usize) -> [(String, Rounding); 2] {
    let (_, found) = solve(text, &Options::default().digits(digits));
    exponent(&found.modes[0]).map(|x| {
        let decimal = x.decimal(digits);
        (decimal.text, decimal.rounding)
    })
}

#[test]
fn roundings_next_to_a_tie_are_decided() {
    let omega = |w: &str, unit: &str, digits| {
        let text = format!("coord x  T = x'^2/2  V = {unit}^2*({w})^2*x^2/2");
        printed(&text, digits)[0].clone()
    };
    for (w, digits, want) in [
        ("2.5 + 1e-40", 1, "3"),
        ("2.5 - 1e-40", 1, "2"),
        ("3.5 - 1e-100", 1, "3"),
        ("2.5 + 1e-250", 1, "3"),
        ("1.23455 + 1e-45", 5, "1.2346"),
        ("1.23455 - 1e-45", 5, "1.2345"),
        ("1.2345678915 - 1e-60", 10, "1.234567891"),
    ] {
        assert_eq!(omega(w, "1", digits), (want.to_owned(), Rounding::Correct), "{w}");
        let far = (format!("{want}e120"), Rounding::Correct);
        assert_eq!(omega(w, "1e120", digits), far, "{w} far");
    }
    // A tie, and what is nearer than the highest precision tells: within one unit of the last place, and told as such.
    for w in ["2.5", "2.5 + 1e-300"] {
        assert_eq!(omega(w, "1", 1), ("2".to_owned(), Rounding::Tie), "{w}");
    }
    for k in ["100", "100*pi"] {
        for (c, want) in [("2.5 + 1e-40", "-3"), ("2.5 - 1e-40", "-2")] {
            let text = format!("coord x  T = x'^2/2  V = {k}*x^2/2  dissipation = ({c})*x'^2");
            assert_eq!(printed(&text, 1)[1], (want.to_owned(), Rounding::Correct));
        }
    }
    let rotor = "coord x, y  V = 0
        lagrangian = (x'^2 + y'^2)/2 + (a - 1/a)/2*(x*y' - y*x') - (x^2 + y^2)/2";
    let rotor = rotor.replace("V = 0", "param a = 2.5 + 1e-40");
    let (_, found) = solve(&rotor, &Options::default().digits(1));
    let last = exponent(&found.modes[1])[0].decimal(1);
    assert_eq!((last.text.as_str(), last.rounding), ("3", Rounding::Correct));
}
