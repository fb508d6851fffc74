//! Some exponents of large sparse models with friction and rotation: against closed forms, and against the dense path for random ones.

#![cfg(feature = "engine")]

use faer::c64;
use librate::budget::Budget;
use librate::linearize::linearize;
use librate::modes::{Kind, Options, Stability};
use librate::oscillation::{NormalModes, normal_modes};
use librate::precision::Ball;
use librate_core::modes::exponents::{QuadraticProblem, Structure, exponents};
use librate_core::modes::{Method, SparseQuadratic, Wanted, solve_sparse_quadratic};
use librate_core::oscillation::sparse_quadratic;
use librate_core::precision::SparseMatrix;
use proptest::prelude::*;

use crate::common::model;

fn modes(text: &str, options: &Options) -> NormalModes {
    modes_by(Method::Arnoldi, text, options)
}

fn modes_by(method: Method, text: &str, options: &Options) -> NormalModes {
    let found = normal_modes(&linearize(model(text)).unwrap(), options).unwrap();
    assert_eq!(found.method, Some(method), "{text}");
    found
}

/// That an enclosure is narrow and holds a number that is known to some roundings.
fn holds(own: &Ball, exact: f64, scale: f64) {
    assert!((own.mid_f64() - exact).abs() <= own.radius + 1e-14 * scale, "{own:?} is not {exact}");
    assert!(own.radius <= 1e-13 * exact.abs().max(1e-3 * scale), "{exact} to {:e}", own.radius);
}

/// 2 sin(πj / 2(n + 1))
fn of_chain(j: usize, n: usize) -> f64 {
    2.0 * (std::f64::consts::PI * j as f64 / (2.0 * (n as f64 + 1.0))).sin()
}

/// A string of beads seen from a frame that turns about its axis: the frequencies at rest, more and less by the rate.
#[test]
fn a_string_in_a_turning_frame() {
    let (n, rate) = (400, 0.003);
    let text = format!(
        "param N = {n}  param W = {rate}
         coord x[1..N], y[1..N]
         lagrangian = sum(i in 1..N, 1/2*((x[i]' - W*y[i])^2 + (y[i]' + W*x[i])^2))
           - sum(i in 1..N-1, 1/2*((x[i+1] - x[i])^2 + (y[i+1] - y[i])^2)) - 1/2*(x[1]^2 + x[N]^2 + y[1]^2 + y[N]^2)"
    );
    let mut exact: Vec<f64> = (1..=n).flat_map(|j| [of_chain(j, n) - rate, of_chain(j, n) + rate]).collect();
    exact.sort_by(f64::total_cmp);
    let lowest = modes(&text, &Options::default().lowest(5));
    assert_eq!((lowest.stability, lowest.secular), (Stability::Stable, Some(false)));
    for (mode, exact) in lowest.modes.iter().zip(&exact) {
        assert_eq!(mode.kind, Kind::Oscillation);
        holds(&mode.omega, *exact, *exact);
        // y is a quarter of a turn before or behind x, and both are as long: the largest component is at x.
        let largest = (0..n).map(|i| mode.vector[i]).fold(0.0, f64::max);
        let middle = (0..n).find(|i| mode.vector[*i] == largest).unwrap();
        assert!((mode.imaginary[n + middle].abs() - largest).abs() <= 1e-12);
        assert!(mode.vector_error_bound < 1e-12, "{:e}", mode.vector_error_bound);
    }
    let next_to_0 = modes(&text, &Options::default().near(0.0, 2).without_vectors());
    next_to_0.modes.iter().zip(&exact).for_each(|(mode, exact)| holds(&mode.omega, *exact, *exact));
    exact.sort_by(|a, b| (a - 0.5).abs().total_cmp(&(b - 0.5).abs()));
    let near = modes(&text, &Options::default().near(0.5, 4).without_vectors());
    let mut nearest = exact[..4].to_vec();
    nearest.sort_by(f64::total_cmp);
    near.modes.iter().zip(&nearest).for_each(|(mode, exact)| holds(&mode.omega, *exact, *exact));
}

/// Friction like the masses: growth -c/2, and frequencies lower than without.
#[test]
fn a_chain_in_oil() {
    let (n, c) = (500, 0.002);
    let text = format!(
        "param N = {n}  param c = {c}
         coord x[1..N]
         T = sum(i in 1..N, 1/2*x[i]'^2)
         V = sum(i in 1..N-1, 1/2*(x[i+1] - x[i])^2) + 1/2*x[1]^2 + 1/2*x[N]^2
         dissipation = sum(i in 1..N, 1/2*c*x[i]'^2)"
    );
    // The same as forces on each coordinate.
    let forces = text.replace("dissipation = sum(i in 1..N, 1/2*c*x[i]'^2)", "force x[i in 1..N] = -c*x[i]'");
    for text in [text, forces] {
        let found = modes_by(Method::Tridiagonal, &text, &Options::default().lowest(6));
        assert_eq!(found.stability, Stability::Stable);
        for (j, mode) in found.modes.iter().enumerate() {
            assert_eq!(mode.kind, Kind::Damped);
            let omega = (of_chain(j + 1, n).powi(2) - 0.25 * c * c).sqrt();
            holds(&mode.omega, omega, omega);
            holds(&mode.growth, -0.5 * c, omega);
            // √(2/(n + 1)) sin(πij/(n + 1)), turned so that the largest component is positive; xᴴMx = 1.
            let size = (2.0 / (n as f64 + 1.0)).sqrt();
            for i in [0, 7, 100, 499] {
                let exact = size * (std::f64::consts::PI * ((i + 1) * (j + 1)) as f64 / (n as f64 + 1.0)).sin();
                let own = mode.vector[i].hypot(mode.imaginary.get(i).copied().unwrap_or(0.0));
                assert!((own - exact.abs()).abs() <= mode.vector_error_bound + 1e-12, "{own} {exact}");
            }
        }
    }
}

/// C = a M + b K: zeros of s² + (a + b λ) s + λ with λ those of a chain, of points or of rods between them; slow and fast ones where
/// friction is large.
#[test]
fn friction_like_masses_and_springs() {
    let n = 400;
    let text = |a: f64, b: f64, of_rods: bool| {
        let mass = if of_rods { (2.0 / 3.0, 1.0 / 6.0) } else { (1.0, 0.0) };
        format!(
            "param N = {n}  param a = {a}  param b = {b}  param m = {}  param h = {}
             coord x[1..N]
             T = sum(i in 1..N, 1/2*m*x[i]'^2) + sum(i in 1..N-1, h*x[i]'*x[i+1]')
             V = sum(i in 1..N-1, 1/2*(x[i+1] - x[i])^2) + 1/2*x[1]^2 + 1/2*x[N]^2
             dissipation = 1/2*a*(sum(i in 1..N, m*x[i]'^2) + 2*sum(i in 1..N-1, h*x[i]'*x[i+1]'))
               + 1/2*b*(sum(i in 1..N-1, (x[i+1]' - x[i]')^2) + x[1]'^2 + x[N]'^2)",
            mass.0, mass.1
        )
    };
    let exponents = |a: f64, b: f64, of_rods: bool| -> Vec<[f64; 2]> {
        let each = (1..=n).flat_map(|j| {
            let stiffness = of_chain(j, n).powi(2);
            let lambda = stiffness / if of_rods { 1.0 - stiffness / 6.0 } else { 1.0 };
            let rate = 0.5 * (a + b * lambda);
            let square = lambda - rate * rate;
            if square > 0.0 {
                return vec![[square.sqrt(), -rate]];
            }
            let fast = -rate - (-square).sqrt();
            vec![[0.0, lambda / fast], [0.0, fast]]
        });
        let mut all: Vec<[f64; 2]> = each.collect();
        all.sort_by(|x, y| x[0].total_cmp(&y[0]).then(y[1].total_cmp(&x[1])));
        all
    };
    for (a, b, of_rods) in [
        (0.1, 0.0, false),
        (0.002, 0.0, true),
        (0.04, 0.0, false),
        (0.5, 0.03, false),
        (0.0, 0.05, false),
        (0.01, 0.02, true),
        (0.02, 0.1, false),
        (0.3, 0.001, true),
    ] {
        let (text, all) = (text(a, b, of_rods), exponents(a, b, of_rods));
        let budget = |near: f64| {
            let mut nearest = all.clone();
            nearest.sort_by(|x, y| (x[0] - near).abs().total_cmp(&(y[0] - near).abs()));
            nearest.truncate(5);
            nearest.sort_by(|x, y| x[0].total_cmp(&y[0]));
            (Options::default().near(near, 5), nearest)
        };
        let lowest = (Options::default().lowest(9), all[..9].to_vec());
        let mut cases = vec![lowest, budget(0.5), budget(1.3)];
        // Those that do not oscillate are as near, all of them.
        let slow = all.iter().filter(|own| own[0] == 0.0).count();
        cases.extend((slow < 3).then(|| budget(0.05)));
        for (options, exact) in cases {
            let method = if of_rods { Method::Lanczos } else { Method::Tridiagonal };
            let found = modes_by(method, &text, &options);
            // That some friction is left at the lowest frequency is not seen from others.
            let is_seen = a > 0.0 || options.near.is_none();
            let stability = if is_seen { Stability::Stable } else { Stability::Undecided };
            assert_eq!((found.stability, found.modes.len()), (stability, exact.len()), "{a} {b}");
            for (mode, [omega, growth]) in found.modes.iter().zip(&exact) {
                holds(&mode.omega, *omega, omega.hypot(*growth));
                holds(&mode.growth, *growth, omega.hypot(*growth));
                assert_eq!(mode.kind == Kind::Overdamped, *omega == 0.0);
                assert!(mode.imaginary.is_empty() && mode.vector_error_bound < 1e-8, "{:e}", mode.vector_error_bound);
            }
        }
    }
}

/// The same of free bodies: a ring, whose modes come in pairs, and a chain. They stop where friction acts on them, or drift.
#[test]
fn free_bodies_with_friction() {
    let n = 400;
    for (a, b, is_ring) in [
        (0.1, 0.0, false),
        (0.004, 0.01, false),
        (2.0, 0.0, true),
        (0.05, 0.01, true),
        (0.0, 0.05, true),
        (0.0, 0.1, false),
    ] {
        let (closing, rate) = if is_ring { ("+ (x[N] - x[1])^2", "+ (x[N]' - x[1]')^2") } else { ("", "") };
        let of_masses = if a > 0.0 { format!("1/2*{a}*sum(i in 1..N, x[i]'^2) +") } else { String::new() };
        let text = format!(
            "param N = {n}  param b = {b}
             coord x[1..N]
             T = sum(i in 1..N, 1/2*x[i]'^2)
             V = 1/2*(sum(i in 1..N-1, (x[i+1] - x[i])^2) {closing})
             dissipation = {of_masses} 1/2*b*(sum(i in 1..N-1, (x[i+1]' - x[i]')^2) {rate})"
        );
        let turn = std::f64::consts::PI / f64::from(n);
        let lambda = |j: i32| {
            2.0 * (f64::from(if is_ring { (j + 1) / 2 } else { j }) * turn * if is_ring { 1.0 } else { 0.5 }).sin()
        };
        let each = (1..40).map(|j| lambda(j).powi(2)).flat_map(|lambda| {
            let rate = 0.5 * (a + b * lambda);
            let root = (lambda - rate * rate).abs().sqrt();
            let is_slow = lambda < rate * rate;
            if is_slow { vec![[0.0, -lambda / (rate + root)], [0.0, -rate - root]] } else { vec![[root, -rate]] }
        });
        let mut all: Vec<[f64; 2]> = each.chain((a > 0.0).then_some([0.0, -a])).collect();
        all.sort_by(|x, y| x[0].total_cmp(&y[0]).then(y[1].total_cmp(&x[1])));
        let method = if is_ring { Method::Lanczos } else { Method::Tridiagonal };
        assert_eq!(modes_by(method, &text, &Options::default().lowest(1)).modes.len(), 1);
        let found = modes_by(method, &text, &Options::default().lowest(7));
        assert_eq!((found.stability, found.secular, found.modes.len()), (Stability::Neutral, Some(false), 7), "{text}");
        assert_eq!(found.zero_motions, ["translation of x"]);
        let zeros = found.modes.iter().take_while(|mode| mode.kind == Kind::Zero).count();
        assert_eq!(zeros, 1);
        for (mode, [omega, growth]) in found.modes[1..].iter().zip(&all) {
            holds(&mode.omega, *omega, omega.hypot(*growth));
            holds(&mode.growth, *growth, omega.hypot(*growth));
            assert!(mode.vector_error_bound < 1e-6, "{:e}", mode.vector_error_bound);
        }
    }
}

/// Friction that drives the fast modes: those that grow come first, and none of the slow ones is given for them.
#[test]
fn friction_that_drives_is_not_overlooked() {
    let text = "param n = 301  param a = 0.1  param b = -0.04  coord x[1..n]
        T = sum(i in 1..n, 1/2*x[i]'^2)
        V = sum(i in 1..n-1, 1/2*(x[i+1] - x[i])^2) + 1/2*x[1]^2 + 1/2*x[n]^2
        dissipation = a*sum(i in 1..n, 1/2*x[i]'^2) + b*(sum(i in 1..n-1, 1/2*(x[i+1]' - x[i]')^2) + 1/2*x[1]'^2 + 1/2*x[n]'^2)";
    let found =
        normal_modes(&linearize(model(text)).unwrap(), &Options::default().lowest(1).without_vectors()).unwrap();
    let square = of_chain(301, 301).powi(2);
    assert_eq!((found.stability, found.modes[0].kind), (Stability::Unstable, Kind::Unstable));
    assert!((found.modes[0].growth.mid_f64() + 0.5 * (0.1 - 0.04 * square)).abs() < 1e-12);
}

/// The friction of each mass.
type Friction<'a> = &'a dyn Fn(usize) -> f64;

/// Friction that differs from mass to mass: the exponents nearest to a frequency decay as fast as the mean, far from the axis beside the distance
/// to the next ones. And a single damper: what is far from the axis is excluded by many discs. Against eigenvalues in doubles.
#[test]
fn friction_of_many_kinds() {
    let n = 320;
    let of_all = |i: usize| 0.1 * (1.0 + 0.3 * (i % 3) as f64);
    let of_one = |i: usize, c: f64| if i == 100 { c } else { 0.0 };
    let cases: [(&str, Friction<'_>, f64); 3] = [
        ("sum(i in 1..N, 0.05*(1 + 0.3*mod(i, 3))*x[i]'^2)", &of_all, 1e-10),
        ("1/2*x[100]'^2", &|i| of_one(i, 1.0), 1e-10),
        ("5000*x[100]'^2", &|i| of_one(i, 10_000.0), 1e-7),
    ];
    for (dissipation, friction, tolerance) in cases {
        let text = format!(
            "param N = {n}  coord x[1..N]
             T = sum(i in 1..N, 1/2*x[i]'^2)
             V = sum(i in 1..N-1, 1/2*(x[i+1] - x[i])^2) + 1/2*x[1]^2
             dissipation = {dissipation}"
        );
        let first_order = nalgebra::DMatrix::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
            (true, _) => f64::from(u8::from(j == i + n)),
            (false, false) if i == j => -friction(i - n + 1),
            (false, true) if i - n == j => {
                if j == n - 1 {
                    -1.0
                } else {
                    -2.0
                }
            }
            (false, true) if (i - n).abs_diff(j) == 1 => 1.0,
            _ => 0.0,
        });
        let all = first_order.complex_eigenvalues();
        for near in [0.1, 1.1, 1.9].into_iter().skip(if tolerance < 1e-9 { 0 } else { 2 }) {
            let found = modes(&text, &Options::default().near(near, 3));
            let mut exact: Vec<[f64; 2]> = all.iter().filter(|s| s.im >= 0.0).map(|s| [s.im, s.re]).collect();
            exact.sort_by(|x, y| (x[0] - near).abs().total_cmp(&(y[0] - near).abs()));
            exact.truncate(3);
            exact.sort_by(|x, y| x[0].total_cmp(&y[0]));
            assert_eq!(found.modes.len(), 3);
            for (mode, [omega, growth]) in found.modes.iter().zip(&exact) {
                let off = (mode.omega.mid_f64() - omega).abs().max((mode.growth.mid_f64() - growth).abs());
                assert!(off < tolerance, "{dissipation} {near}: {off:e}");
                assert!(mode.omega.radius < 1e-12 && mode.vector_error_bound < 1e-8, "{:?}", mode.omega);
            }
        }
    }
}

/// A membrane in oil: equal exponents, each as often as it is one.
#[test]
fn a_membrane_in_oil() {
    let (n, c) = (20, 0.01);
    let text = format!(
        "param N = {n}  param c = {c}
         coord z[1..N, 1..N]
         T = sum(i in 1..N, j in 1..N, 1/2*z[i,j]'^2)
         V = sum(i in 1..N-1, j in 1..N, 1/2*(z[i+1,j] - z[i,j])^2 + 1/2*(z[j,i+1] - z[j,i])^2)
           + sum(i in 1..N, 1/2*(z[1,i]^2 + z[N,i]^2 + z[i,1]^2 + z[i,N]^2))
         dissipation = sum(i in 1..N, j in 1..N, 1/2*c*z[i,j]'^2)"
    );
    let pairs = (1..=n).flat_map(|j| (1..=n).map(move |l| (j, l)));
    let square = |(j, l): (usize, usize)| of_chain(j, n).powi(2) + of_chain(l, n).powi(2) - 0.25 * c * c;
    let mut exact: Vec<f64> = pairs.map(|pair| square(pair).sqrt()).collect();
    exact.sort_by(f64::total_cmp);
    let found = modes_by(Method::Lanczos, &text, &Options::default().lowest(14).without_vectors());
    // By Arnoldi steps, which do not know that friction is like the masses.
    let problem = sparse_quadratic(&linearize(model(&text)).unwrap()).unwrap();
    let options = Options::default().without_vectors();
    let other = solve_sparse_quadratic(&problem, Wanted::Lowest(14), &options, &Budget::default()).unwrap();
    for ((mode, other), exact) in found.modes.iter().zip(&other.entries).zip(&exact) {
        for (omega, growth) in [(&mode.omega, &mode.growth), (&other.omega, &other.growth)] {
            holds(omega, *exact, *exact);
            holds(growth, -0.5 * c, *exact);
        }
    }
    assert_eq!(found.modes[1].cluster, found.modes[2].cluster);
    assert_eq!((found.stability, found.secular), (Stability::Stable, Some(false)));
}

/// How far s is from an exponent of the chain with a damper at its free end: a step of Newton's method for (s² + cs + 1) sin nθ = sin (n - 1)θ with
/// s = 2i sin(θ/2), since sin iθ solves s² x = x₊ - 2x + x₋.
fn distance(s: c64, n: usize, c: f64) -> f64 {
    let (unit, n) = (c64::new(0.0, 1.0), n as f64);
    let theta = (s / (unit * 2.0)).asin() * 2.0;
    let factor = s * s + s * c + 1.0;
    let rate = unit * (theta * 0.5).cos();
    let value = factor * (theta * n).sin() - (theta * (n - 1.0)).sin();
    let slope = (s * 2.0 + c) * rate * (theta * n).sin() + factor * n * (theta * n).cos()
        - (theta * (n - 1.0)).cos() * (n - 1.0);
    (value / slope * rate).norm()
}

#[test]
fn a_damper_at_the_end_of_a_chain() {
    let n = 600;
    let text = |c: f64| {
        format!(
            "param N = {n}  param c = {c}
         coord x[1..N]
         T = sum(i in 1..N, 1/2*x[i]'^2)
         V = sum(i in 1..N-1, 1/2*(x[i+1] - x[i])^2) + 1/2*x[1]^2
         dissipation = 1/2*c*x[N]'^2"
        )
    };
    let near = Options::default().near(0.5, 5).without_vectors();
    let lowest = Options::default().lowest(8).without_vectors();
    // The strong one adds a fast motion that does not oscillate, beside the strip that is searched.
    for (c, options, count) in [(0.3, lowest, 8), (0.3, near.clone(), 5), (8.0, near, 5)] {
        let found = modes(&text(c), &options);
        assert_eq!((found.modes.len(), found.stability), (count, Stability::Stable));
        for mode in &found.modes {
            let (growth, omega) = (mode.growth.mid_f64(), mode.omega.mid_f64());
            let off = distance(c64::new(growth, omega), n, c);
            assert!(off <= 1e-13 * omega, "{omega} is off by {off:e}");
            assert!(mode.omega.radius <= 1e-13 * omega && mode.growth.radius <= 1e-13 * growth.abs());
        }
        // About π/n apart, as waves that are reflected in part are: none is missing.
        for pair in found.modes.windows(2) {
            let apart = pair[1].omega.mid_f64() - pair[0].omega.mid_f64();
            assert!((0.9..1.1).contains(&(apart * n as f64 / std::f64::consts::PI)));
        }
    }
    let precise = modes(&text(0.3), &Options::default().lowest(2).digits(20).without_vectors());
    assert!(precise.modes.iter().all(|mode| mode.omega.radius <= 1e-21 * mode.omega.mid_f64()));
}

/// Where energy comes in the unstable motions would have to be among all: only those next to a frequency are found.
#[test]
fn what_cannot_be_proved_is_left_to_others() {
    let text = "param N = 320
         coord x[1..N]
         T = sum(i in 1..N, 1/2*x[i]'^2)
         V = sum(i in 1..N-1, 1/2*(x[i+1] - x[i])^2) + 1/2*x[1]^2 + 1/2*x[N]^2
         force x[1] = 1/50*x[1]'";
    let near = modes(text, &Options::default().near(0.3, 2).without_vectors());
    assert!(near.modes.iter().all(|mode| mode.kind == Kind::Unstable));
    assert_eq!(near.stability, Stability::Unstable);
    // All fall away: at 0 there is nothing to search about, elsewhere nothing to be found.
    let (mut few, _) = drawn(&[[0.0; 8]; 5], true, 0.0);
    let shares: Vec<(u32, u32, Ball)> = (0..5).map(|i| (i, i, Ball::exact(-1.0))).collect();
    few.stiffness = SparseMatrix::from_shares(5, &shares);
    for omega in [0.0, 1.0] {
        let near = Wanted::Near(omega, 1);
        assert!(solve_sparse_quadratic(&few, near, &Options::default(), &Budget::default()).is_none());
    }
}

/// Entries next to the diagonal: numbers between -1 and 1 for M, G, C and K.
type Band = [f64; 8];

fn drawn(numbers: &[Band], damped: bool, circulatory: f64) -> (SparseQuadratic, QuadraticProblem) {
    let n = numbers.len();
    let (mut mass, mut velocity, mut stiffness) = (Vec::new(), Vec::new(), Vec::new());
    for (i, own) in numbers.iter().enumerate() {
        let at = i as u32;
        let next = (i + 1 < n).then_some(at + 1);
        mass.push((at, at, 1.0 + 0.4 * own[0]));
        stiffness.push((at, at, 2.2 + own[1]));
        velocity.push((at, at, if damped { 0.1 * (1.0 + own[2]) } else { 0.0 }));
        if let Some(next) = next {
            mass.push((next, at, 0.2 * own[3]));
            for (i, j, sign) in [(next, at, 1.0), (at, next, -1.0)] {
                velocity.push((i, j, sign * 0.3 * own[4] + if damped { 0.05 * own[5] } else { 0.0 }));
                stiffness.push((i, j, 0.6 * own[6] + sign * circulatory * own[7]));
            }
        }
    }
    let balls = |all: &[(u32, u32, f64)]| -> Vec<(u32, u32, Ball)> {
        all.iter().map(|(i, j, value)| (*i, *j, Ball::exact(*value))).collect()
    };
    let sparse = |all: &[(u32, u32, f64)]| SparseMatrix::from_shares(n, &balls(all));
    let dense = |all: &[(u32, u32, f64)], mirrored: bool| {
        let mut matrix = vec![Ball::ZERO; n * n];
        for (i, j, value) in balls(all) {
            matrix[i as usize + n * j as usize] = value;
            if mirrored {
                matrix[j as usize + n * i as usize] = value;
            }
        }
        matrix
    };
    let symmetric = circulatory == 0.0;
    let structure = match (damped, symmetric) {
        (false, true) => Structure::Gyroscopic,
        (true, true) => Structure::Dissipative,
        _ => Structure::Damped,
    };
    let whole = QuadraticProblem {
        dimension: n,
        mass: dense(&mass, true),
        velocity: dense(&velocity, false),
        stiffness: dense(&stiffness, false),
        structure,
        zero_vectors: Vec::new(),
        unmoved: Vec::new(),
    };
    let few = SparseQuadratic {
        mass: sparse(&mass),
        velocity: sparse(&velocity),
        stiffness: sparse(&stiffness),
        undamped: structure == Structure::Gyroscopic,
        symmetric,
        // Rows of C are 0.1 (1 + u) beside at most 0.1 in all: not always.
        passive: false,
    };
    (few, whole)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]
    #[test]
    fn exponents_are_those_of_the_dense_path(
        numbers in prop::collection::vec(prop::array::uniform8(-1.0_f64..1.0), 4..14),
        damped: bool,
        circulatory in prop::sample::select(vec![0.0, 0.2]),
        omega in 0.2_f64..2.5,
        count in 1_usize..4,
    ) {
        let (few, whole) = drawn(&numbers, damped, circulatory);
        let all = exponents(&whole, &(), &Options::default()).unwrap();
        let distance = |omega_of: &Ball| (omega_of.mid_f64() - omega).abs();
        let mut order: Vec<usize> = (0..all.entries.len()).collect();
        order.sort_by(|a, b| distance(&all.entries[*a].omega).total_cmp(&distance(&all.entries[*b].omega)));
        let near = Wanted::Near(omega, count);
        if let Some(found) = solve_sparse_quadratic(&few, near, &Options::default(), &Budget::default()) {
            prop_assert_eq!(found.entries.len(), count);
            for entry in &found.entries {
                let same = order[..count].iter().any(|at| {
                    let other = &all.entries[*at];
                    (other.omega - entry.omega).contains_zero() && (other.growth - entry.growth).contains_zero()
                        && (entry.kind == other.kind || entry.kind == Kind::Undecided)
                });
                prop_assert!(same, "{entry:?} is none of {:?}", all.entries);
            }
        }
        if !damped && circulatory == 0.0 && all.stability == Stability::Stable
            && let Some(found) = solve_sparse_quadratic(&few, Wanted::Lowest(count), &Options::default(), &Budget::default())
        {
            prop_assert_eq!(found.stability, Stability::Stable);
            for (entry, other) in found.entries.iter().zip(&all.entries) {
                prop_assert!((other.omega - entry.omega).contains_zero() && entry.growth.is_zero());
            }
        }
    }
}

/// Beside a damped chain an overdamped mass on its own: of its exponents -c/2 ± sqrt(c²/4 - k), both without frequency, the slower one is the
/// first.
#[test]
fn the_slower_of_two_that_do_not_oscillate_comes_first() {
    for c in [0.2018, 0.2020, 0.2028, 0.2032_f64] {
        let text = format!(
            "param N = 320  param c = {c}
             coord x[1..N]
             T = sum(i in 1..N, 1/2*x[i]'^2)
             V = sum(i in 2..N, 1/2*(1 + i/1000)*x[i]^2) + 1/2*0.01*x[1]^2 + sum(i in 2..N-1, 0.0005*(x[i+1] - x[i])^2)
             dissipation = 1/2*c*x[1]'^2"
        );
        let found = modes(&text, &Options::default().lowest(1));
        let exact = -c / 2.0 + (c * c / 4.0 - 0.01).sqrt();
        assert!((found.modes[0].growth.mid_f64() - exact).abs() < 1e-12, "{c}: {:?} is not {exact}", found.modes[0]);
    }
}

/// A free chain in a turning frame, z'' + 2iW z' + k z = 0: an exponent 0 for k = 0, whose sign is noise, is there once, and nothing is left
/// out for it.
#[test]
fn what_may_be_zero_is_counted_once() {
    let (n, rate) = (160, 0.1_f64);
    let text = format!(
        "param N = {n}  param W = {rate}
         coord x[1..N], y[1..N]
         lagrangian = sum(i in 1..N, 1/2*(x[i]'^2 + y[i]'^2) + W*(x[i]*y[i]' - y[i]*x[i]'))
           - sum(i in 1..N-1, 50*(x[i+1] - x[i])^2 + 50*(y[i+1] - y[i])^2)"
    );
    // Free ends are as far as fixed ones of a chain with one bead less.
    let stiffness = |j: usize| 100.0 * of_chain(j, n - 1).powi(2);
    let both = |j: usize| [-1.0, 1.0].map(|side| (rate * rate + stiffness(j)).sqrt() + side * rate);
    let mut exact: Vec<f64> = (0..n).flat_map(both).collect();
    exact.sort_by(f64::total_cmp);
    for (near, count) in [(0.02, 3), (0.02, 4), (0.1, 4), (0.15, 4)] {
        let linearized = linearize(model(&text)).unwrap();
        let found = normal_modes(&linearized, &Options::default().near(near, count).without_vectors()).unwrap();
        let mut nearest = exact.clone();
        nearest.sort_by(|a, b| (a - near).abs().total_cmp(&(b - near).abs()));
        nearest.truncate(count);
        nearest.sort_by(f64::total_cmp);
        for (mode, exact) in found.modes.iter().zip(&nearest) {
            assert!((mode.omega.mid_f64() - exact).abs() < 1e-12, "{near}: {:?} is not {exact}", mode.omega);
        }
    }
}

/// Frequencies that are equal to their bounds are put in order by friction; what may be equal to one neighbour and to the other is no order of
/// all three, which a sort may not be asked for.
#[test]
fn nearly_equal_frequencies_are_put_in_order() {
    let n = 80;
    let (mut potential, mut dissipation) = (String::from("0"), String::from("0"));
    let mut seed: u64 = 3;
    for i in 1..=n {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let (c, j) = ((seed >> 33) % 900 + 10, (seed >> 50) % 90);
        potential += &format!(" + 1/2*(100 + ({c}/100)^2/4 + {j}*1e-26)*x[{i}]^2");
        dissipation += &format!(" + 1/2*{c}/100*x[{i}]'^2");
    }
    let text =
        format!("coord x[1..{n}]  T = sum(i in 1..{n}, 1/2*x[i]'^2)  V = {potential}  dissipation = {dissipation}");
    let found = normal_modes(&linearize(model(&text)).unwrap(), &Options::default().without_vectors()).unwrap();
    assert_eq!(found.modes.len(), n);
    assert!(found.modes.iter().all(|own| (own.omega.mid_f64() - 10.0).abs() < 1e-13));
}
