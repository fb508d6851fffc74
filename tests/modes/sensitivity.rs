//! Derivatives of frequencies against differences of certified frequencies with forty digits.
#![cfg(feature = "engine")]

use crate::common;

use std::path::Path;

use common::model_in;
use librate::linearize::{Linearized, Structure, linearize};
use librate::modes::{Kind, Options};
use librate::oscillation::{NormalModes, normal_modes};
use librate::precision::{Ball, Big};
use librate::report::{Style, modes_text};
use librate::sensitivity::{Sensitivities, put_uncertainties, sensitivities};

fn solve(text: &str, settings: &[&str], digits: usize) -> (Linearized, NormalModes) {
    let linearized = linearize(model_in(text, Path::new("models"), settings)).unwrap();
    let options = Options::default().digits(digits);
    let modes = normal_modes(&linearized, &options).unwrap();
    (linearized, modes)
}

fn sensitivity(text: &str) -> (Linearized, NormalModes, Sensitivities) {
    let (linearized, modes) = solve(text, &[], 15);
    let found = sensitivities(&linearized, &modes);
    (linearized, modes, found)
}

/// omega and growth of each mode with many bits.
fn precisely(modes: &NormalModes) -> Vec<[Big; 2]> {
    let numbers = modes.modes.iter().map(|mode| match &mode.precise {
        Some(precise) => [precise.omega.clone(), precise.growth.clone()],
        None => [&mode.omega, &mode.growth].map(|ball| Big::from_ball(ball, 256)),
    });
    numbers.collect()
}

/// Every derivative of a model against (f(p + h) - f(p - h))/2h with h = 1e-9 p, which is off by 1e-18 or so of the scale
/// omega/p, and by 1e-31 for digits. Of equal modes one side rises as the other falls. How many were compared.
fn compare(name: &str, text: &str) -> usize {
    let (linearized, modes, found) = sensitivity(text);
    let model = linearized.model();
    let mut compared = 0;
    // Modes that are equal: ranges, as they stand in a row.
    let cluster = |mode: usize| modes.modes[mode].cluster;
    let range = |mode: usize| {
        let own = |other: &usize| cluster(*other) == cluster(mode);
        let count = modes.modes.len();
        (0..count).find(own).unwrap()..(0..count).rfind(own).unwrap() + 1
    };
    for (at, parameter) in found.parameters.iter().enumerate() {
        let parameter = &model.parameters[*parameter];
        let value = parameter.value.unwrap();
        let value = librate_core::linearize::constant(&model.pool, value).unwrap();
        let whole = model.pool.display(parameter.value.unwrap());
        let shifted = |sign: &str| {
            let setting = format!("{} = ({whole})*(1 {sign} 1e-9)", parameter.name);
            precisely(&solve(text, &[&setting], 40).1)
        };
        let (up, down) = (shifted("+"), shifted("-"));
        let step = value * Ball::exact(2.0) / Ball::exact(1e9);
        for (mode, up) in up.iter().enumerate() {
            let range = range(mode);
            let down = &down[range.start + range.end - 1 - mode];
            let own = &modes.modes[mode];
            let scale = own.omega.mid_f64().hypot(own.growth.mid_f64()) / value.mid_f64().abs();
            // Beside their shapes, in any order, where M and K are all there is.
            let mut order: Vec<usize> = range.clone().collect();
            if linearized.structure() == Structure::Conservative {
                let size = |mode: &usize| found.omega[*mode][at].map_or(f64::NAN, |own| own.mid_f64());
                let size = |mode: &usize| size(mode) - found.growth[*mode][at].map_or(0.0, |own| own.mid_f64());
                order.sort_by(|a, b| size(a).total_cmp(&size(b)));
            }
            let mode = order[mode - range.start];
            for (part, own) in [found.omega[mode][at], found.growth[mode][at]].iter().enumerate() {
                let want = (&up[part] - &down[part]).to_ball() / step;
                // A zero under conditions on velocities may be one for other reasons elsewhere.
                if own.is_none() && linearized.unheld().is_some() && modes.modes[mode].kind == Kind::Zero {
                    continue;
                }
                let own = own.unwrap_or_else(|| panic!("{name}: {} of mode {mode}", parameter.name));
                let off = (own - want).mid_f64().abs();
                let size = want.mid_f64().abs() + scale;
                assert!(
                    off <= own.radius + 1e-15 * size && own.radius <= 1e-12 * size,
                    "{name}: {} of mode {mode}: {own:?}, not {want:?}",
                    parameter.name
                );
                compared += 1;
            }
        }
    }
    compared
}

#[test]
fn derivatives_are_those_of_certified_frequencies() {
    let mut compared = 0;
    for (name, text) in [
        ("three pendulums", include_str!("../../models/three_pendulums_unequal.lag")),
        ("double pendulum", include_str!("../../models/double_pendulum.lag")),
        ("bead", include_str!("../../models/bead_on_hoop_fast.lag")),
        ("cart", include_str!("../../models/pendulum_on_spring_cart.lag")),
        ("inverted", include_str!("../../models/inverted_pendulum.lag")),
        ("damped", include_str!("../../models/damped_pair.lag")),
        ("belt", include_str!("../../models/belt_oscillator.lag")),
        ("shaft", include_str!("../../models/whirling_shaft_above.lag")),
        ("spring", include_str!("../../models/rotating_spring.lag")),
        ("linkage", include_str!("../../models/four_bar_linkage.lag")),
        ("beads", include_str!("../../models/beads_on_rods.lag")),
    ] {
        compared += compare(name, text);
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn derivatives_under_conditions_on_velocities_are_those_of_certified_frequencies() {
    let mut compared = 0;
    for (name, text) in [
        ("disc", include_str!("../../models/rolling/disc.lag")),
        ("turntable", include_str!("../../models/rolling/turntable.lag")),
        ("caster", include_str!("../../models/rolling/caster.lag")),
        ("sleigh", include_str!("../../models/rolling/sleigh.lag")),
        ("skate", include_str!("../../models/rolling/skate_on_spring.lag")),
        ("paraboloid", include_str!("../../models/rolling/ball_in_paraboloid.lag")),
    ] {
        compared += compare(name, text);
    }
    assert!(compared > 100, "{compared}");
    // What the front wheel of a bicycle carries changes with g, and nothing else does.
    let bicycle = include_str!("../../models/rolling/bicycle.lag");
    let (.., found) = sensitivity(bicycle);
    let at = |g: &str| solve(&bicycle.replace("m/s^2 = 9.81", &format!("m/s^2 = {g}")), &[], 15).1;
    let [down, up] = ["9.809", "9.811"].map(at);
    for (mode, (down, up)) in
        down.modes.iter().zip(&up.modes).enumerate().filter(|(_, (own, _))| own.kind != Kind::Zero)
    {
        let want = (up.omega - down.omega).mid_f64() / 2e-3;
        assert!((found.omega[mode][1].unwrap().mid_f64() - want).abs() < 1e-6 * (1.0 + want.abs()), "{want}");
    }
    // A place that forces move with the parameter is not followed under conditions on velocities.
    let text = "param k = 2, f = 1  coord x, y, th  T = 1/2*(x'^2 + y'^2 + th'^2)
        V = 1/2*k*th^2 - f*th + 1/2*y^2  constraint y'*cos(th) = x'*sin(th)  guess th = 0.5  guess y = 0";
    let (linearized, modes, found) = sensitivity(text);
    assert!(linearized.unheld().is_some() && modes.modes.len() > 1);
    let moving = (0..modes.modes.len()).filter(|at| modes.modes[*at].kind != Kind::Zero);
    assert!(moving.clone().count() > 0 && moving.flat_map(|at| &found.omega[at]).any(Option::is_none));
}

/// Every member is a parameter of its own and breaks the symmetry.
/// Exponents get their values before anything is differentiated by coordinates.
#[test]
fn parameters_in_exponents_have_derivatives() {
    for (text, count) in [
        ("param n = 1.5  coord x  T = 1/2*x'^2  V = (1 + x)^n - n*x", 1),
        ("param n = 2, p = 3  coord x  T = 1/2*n^p*x'^2  V = 1/2*3^n*x^2*2^(1/p)", 2),
        ("param a = 1.2, n = 3  coord x  T = 1/2*x'^2  V = (x - a^n)^2*n^x  equilibrium x = a^n", 2),
        (
            "param m = 1, k = 2, n = 1.5, a = 1.3  coord r, ph  T = 1/2*m*(r'^2 + r^2*ph'^2)  V = k*r^n
            equilibrium r = a  equilibrium ph' = sqrt(n*k*a^(n - 2)/m)",
            4,
        ),
    ] {
        assert!(compare(text, text) >= count, "{text}");
    }
    // At x = 0 the second derivative of x^n is 2 for n = 2 alone.
    let (.., found) = sensitivity("param n = 2  coord x  T = 1/2*x'^2  V = x^n");
    assert!(found.omega[0][0].is_none());
}

/// Zero modes for these values of the parameters, by forces that no potential has.
#[test]
fn forces_that_cancel_have_no_derivative() {
    for text in [
        "param k = 1, P = 1  coord x  T = 1/2*x'^2  V = 1/2*k*x^2  force x = P*x",
        "param k = 1, P = 1  coord x  T = 1/2*x'^2  V = 0  force x = P*x - k*x",
    ] {
        let (.., found) = sensitivity(text);
        assert!(found.omega[0].iter().all(Option::is_none), "{text}");
    }
}

#[test]
fn clusters_split_as_certified_frequencies_do() {
    let mut compared = 0;
    for (name, text) in [
        (
            "ring",
            "param n = 6  param k[1..6] = 2  param m[1..6] = 3  coord x[1..n]
             T = sum(i in 1..n, 1/2*m[i]*x[i]'^2)
             V = sum(i in 1..n, 1/2*k[i]*(x[mod(i, n) + 1] - x[i])^2) + sum(i in 1..n, 1/2*x[i]^2)",
        ),
        (
            "triple",
            "param k[1..3] = 5  param a = 1/7  param b = 1  coord x[1..3]
             T = 1/2*dot(x', x')
             V = sum(i in 1..3, 1/2*k[i]*x[i]^2) + 1/2*(a - 1/7)*x[1]*x[2] + (b - 1)*x[2]*x[3]",
        ),
        (
            "damped ring",
            "param n = 4  param k[1..4] = 2  param c[1..4] = 1/5  coord x[1..n]
             T = sum(i in 1..n, 1/2*x[i]'^2)
             V = sum(i in 1..n, 1/2*k[i]*(x[mod(i, n) + 1] - x[i])^2 + 1/2*x[i]^2)
             dissipation = sum(i in 1..n, 1/2*c[i]*x[i]'^2)",
        ),
        (
            "two charges in two equal traps",
            "param k[1..2] = 3  param B[1..2] = 1/2  param s = 1  coord x[1..2], y[1..2]
             lagrangian = sum(i in 1..2, 1/2*(x[i]'^2 + y[i]'^2)
               + 1/2*B[i]*(x[i]*y[i]' - y[i]*x[i]') - 1/2*k[i]*(x[i]^2 + y[i]^2)) - (s - 1)*x[1]*x[2]",
        ),
        (
            "bob on springs",
            "param g = 9.81  param l = 2  param kx = 3  param ky = 3  param b = 1  coord x, y, z
             T = 1/2*(x'^2 + y'^2 + z'^2)
             V = g*z + 1/2*kx*x^2 + 1/2*ky*y^2 + (b - 1)*x*y
             constraint x^2 + y^2 + z^2 = l^2  guess z = -2",
        ),
    ] {
        compared += compare(name, text);
    }
    assert!(compared > 150, "{compared}");
}

/// A bead in a square trough, k = p², and a free charge in a field that is off: frequencies go as |p| and as |B|.
#[test]
fn what_has_a_corner_has_no_derivative() {
    for text in [
        "param p = 0  coord x  T = 1/2*x'^2  V = 1/2*p^2*x^2",
        "param B = 0  coord x, y  lagrangian = 1/2*(x'^2 + y'^2) + 1/2*B*(x*y' - y*x')",
    ] {
        let (_, modes, found) = sensitivity(text);
        for mode in 0..modes.modes.len() {
            assert!(found.omega[mode][0].is_none(), "{text}: {:?}", found.omega);
        }
    }
}

/// -ω/2m and ω/2k with ω = √(2/3), to as many digits as a ball has.
#[test]
fn derivatives_have_more_digits_than_vectors() {
    let (_, modes, found) = sensitivity("param k = 2  param m = 3  coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2");
    let omega = modes.modes[0].omega;
    for (own, want) in found.omega[0].iter().zip([omega / Ball::exact(4.0), -omega / Ball::exact(6.0)]) {
        let own = own.unwrap();
        assert!((own - want).contains_zero() && own.radius < 1e-29, "{own:?} {want:?}");
    }
}

/// Forces that vanish at the values as they are begin to act: growth falls by c/2m, a field splits what is equal.
#[test]
fn friction_and_rotation_that_begin_count() {
    let text = "param c = 0  param B = 0  param s = 0  coord x, y, z
        lagrangian = 1/2*(x'^2 + y'^2) + 3/2*z'^2 + 1/2*B*(x*y' - y*x') - 2*(x^2 + y^2) - 27/2*z^2
        dissipation = 1/2*c*z'^2 + s*(x'*y - y'*x)";
    let (_, modes, found) = sensitivity(text);
    let omegas: Vec<f64> = modes.modes.iter().map(|mode| mode.omega.mid_f64()).collect();
    assert_eq!(omegas, [2.0, 2.0, 3.0]);
    let near = |own: Option<Ball>, want: f64| {
        let own = own.unwrap();
        assert!((own.mid_f64() - want).abs() < 1e-15 && own.radius < 1e-13, "{own:?} {want}");
    };
    // By c: exponent 3i - c/6. By B: 2i ± iB/2. By s, x'' + 4x + s y = 0 and y'' + 4y - s x = 0: exponent² = -4 ± i s.
    for (mode, omega, growth) in [
        (0, [0.0, -0.5, 0.0], [0.0, 0.0, 0.25]),
        (1, [0.0, 0.5, 0.0], [0.0, 0.0, 0.25]),
        (2, [0.0, 0.0, 0.0], [-1.0 / 6.0, 0.0, 0.0]),
    ] {
        for at in 0..3 {
            near(found.omega[mode][at], omega[at]);
            let own = found.growth[mode][at].map(|own| if mode < 2 && at == 2 { own.abs() } else { own });
            near(own, growth[at]);
        }
    }
}

/// x = g/k is given as a number: the equilibrium moves all the same. omega² = k + 3 x²/10, k x + x³/10 = g.
#[test]
fn a_given_equilibrium_moves_as_the_forces_say() {
    let energies = "param k = 1  param g = 11/10  coord x
        T = 1/2*x'^2  V = 1/2*k*x^2 + x^4/40 - g*x";
    let (_, modes, searched) = sensitivity(&format!("{energies}  guess x = 1"));
    let (_, _, given) = sensitivity(&format!("{energies}  equilibrium x = 1"));
    // dx/dg = 1/omega² and d(omega²)/dg = 6 x/10 dx/dg, with omega² = 1.3.
    let want = 0.6 / 1.3 / (2.0 * 1.3_f64.sqrt());
    assert!((modes.modes[0].omega.mid_f64() - 1.3_f64.sqrt()).abs() < 1e-15);
    for found in [searched, given] {
        let own = found.omega[0][1].unwrap();
        assert!((own.mid_f64() - want).abs() < 1e-15, "{own:?}");
    }
}

/// Zero modes that are there whatever the numbers are keep omega = 0: of a body that turns, too.
#[test]
fn zero_modes_of_bodies_that_turn_stay() {
    for text in [
        include_str!("../../models/sleeping_top_fast.lag"),
        include_str!("../../models/gyroscope_in_gimbals.lag"),
        include_str!("../../models/tennis_racket.lag"),
        include_str!("../../models/cyclotron.lag"),
    ] {
        let (_, modes, found) = sensitivity(text);
        let mut zeros = 0;
        for (mode, row) in modes.modes.iter().zip(&found.omega) {
            if mode.kind == librate::modes::Kind::Zero {
                zeros += 1;
                assert!(row.iter().all(|own| own.unwrap().is_zero()), "{row:?}");
            } else {
                assert!(row.iter().all(Option::is_some), "{row:?}");
            }
        }
        assert!(zeros > 0);
    }
}

/// Critical damping: the exponent goes as a root.
#[test]
fn defective_exponents_have_no_derivative() {
    let text = include_str!("../../models/critically_damped_oscillator.lag");
    let (_, _, found) = sensitivity(text);
    assert!(found.omega.iter().flatten().all(Option::is_none), "{found:?}");
}

#[test]
fn equal_frequencies_split_as_their_forms_say() {
    // d omega / d k is 0 for the one and 1/(2 omega) for the other, whatever the basis was.
    let text = "param k = 4  coord x, y
        T = 1/2*(x'^2 + y'^2)
        V = 1/2*4*(x - y)^2/2 + 1/2*k*(x + y)^2/2";
    let (_, modes, found) = sensitivity(text);
    assert_eq!(modes.modes[0].omega.mid_f64(), 2.0);
    let derivatives: Vec<f64> = found.omega.iter().map(|row| row[0].unwrap().mid_f64()).collect();
    assert!(derivatives[0].abs() < 1e-15 && (derivatives[1] - 0.25).abs() < 1e-15, "{derivatives:?}");
}

#[test]
fn a_frequency_that_goes_as_a_root_has_no_derivative() {
    let text = "param k = 0  coord x  T = 1/2*x'^2  V = 1/2*k*x^2";
    let (_, _, found) = sensitivity(text);
    assert_eq!(found.omega[0][0].map(|own| own.mid_f64()), None);
}

#[test]
fn free_bodies_stay_free() {
    let text = "param k = 3  param d = 1  coord r[1..2, 1..2]
        T = sum(i in 1..2, 1/2*dot(r[i]', r[i]'))
        V = 1/2*k*(norm(r[2] - r[1]) - d)^2
        guess r[i in 1..2] = [(i - 1)*3/2, 0]";
    let (_, modes, found) = sensitivity(text);
    assert_eq!(modes.modes.len(), 4);
    for row in &found.omega[..3] {
        assert!(row.iter().all(|own| own.unwrap().contains_zero()), "{row:?}");
    }
    // omega = sqrt(2 k)
    let want = 6.0_f64.sqrt() / 6.0;
    assert!((found.omega[3][0].unwrap().mid_f64() - want).abs() < 1e-14);
    assert!(found.omega[3][1].unwrap().contains_zero());
}

#[test]
fn uncertainties_add_up_by_squares() {
    let one_by_one = "param k = 4 +/- 0.1  param m = 1 +/- 0.02  param c = 3
        coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2 + c*x^4";
    let listed = "param p[1..2] = [4, 1] +/- [0.1, 0.02]  coord x  T = 1/2*p[2]*x'^2  V = 1/2*p[1]*x^2";
    for text in [one_by_one, listed] {
        let (linearized, _, found) = sensitivity(text);
        let sigma = found.uncertainties(&linearized).unwrap()[0].omega.unwrap();
        // omega (σ_k/k)/2 and omega (σ_m/m)/2
        let want = (2.0 * 0.1 / 4.0 / 2.0_f64).hypot(2.0 * 0.02 / 2.0);
        assert!((sigma.mid_f64() - want).abs() < 1e-15 && sigma.radius < 1e-15, "{sigma:?}");
    }
    let without = sensitivity("param k = 4  coord x  T = 1/2*x'^2  V = 1/2*k*x^2");
    assert!(without.2.uncertainties(&without.0).is_none());
}

/// Where each of several uncertainties splits equal modes along vectors of its own, their shares can't be added up.
#[test]
fn uncertainties_of_equal_modes() {
    let two = |k: &str| format!("{k}  coord x[1..2]  T = 1/2*dot(x', x')  V = 1/2*sum(i in 1..2, k[i]*x[i]^2)");
    let sigmas = |text: &str| {
        let (linearized, _, found) = sensitivity(text);
        let own = found.uncertainties(&linearized).unwrap().into_iter();
        own.map(|own| own.omega.map(|omega| omega.mid_f64())).collect::<Vec<_>>()
    };
    let mixed = "param c = 0 +/- 0.1  param k[1..2] = 4 +/- 0.1  coord x[1..2]
        T = 1/2*dot(x', x')  V = 1/2*sum(i in 1..2, k[i]*x[i]^2) + c*x[1]*x[2]";
    assert_eq!(sigmas(mixed), [None, None]);
    // Each spring holds one of them.
    let apart = sigmas(&two("param k[1..2] = 4 +/- 0.1"));
    assert!(apart.iter().all(|own| (own.unwrap() - 0.025).abs() < 1e-15), "{apart:?}");
    // The first shape is that of x, whose spring alone is uncertain.
    let first = sigmas("param k = 4 +/- 0.1  coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*k*x^2 + 2*y^2");
    assert!((first[0].unwrap() - 0.025).abs() < 1e-15 && first[1].unwrap().abs() < 1e-15, "{first:?}");
    assert!(sigmas(&two("param k[1..2] = [4, 5]  param c = 1 +/- 0.1")).iter().all(Option::is_some));
    // One that splits them, and one that moves both alike.
    let one = "param k = 4 +/- 0.1  param m = 1 +/- 0.02  param a = 0 +/- 0.3
        coord x, y  T = 1/2*m*(x'^2 + y'^2)  V = 1/2*k*(x^2 + y^2) + 1/2*a*(x^2 - y^2)";
    let common = (2.0 * 0.1 / 4.0 / 2.0_f64).hypot(2.0 * 0.02 / 2.0);
    for sigma in sigmas(one) {
        assert!((sigma.unwrap() - common.hypot(0.3 / 4.0)).abs() < 1e-14, "{sigma:?}");
    }
}

/// The lines of the table of modes, and what stands below it.
fn printed(text: &str) -> String {
    let (linearized, mut modes) = solve(text, &[], 10);
    put_uncertainties(&linearized, &mut modes, &Options::default()).unwrap();
    modes_text(&linearized, &modes, &Options::default(), &Style::default())
}

#[test]
fn uncertain_numbers_end_where_their_uncertainty_does() {
    let one = |k: &str| printed(&format!("param k = {k}  coord x  T = 1/2*x'^2  V = 1/2*k*x^2"));
    // omega = sqrt(k), sigma = sigma_k/(2 omega)
    for (k, row) in [
        ("4 ± 0.1", "1  2.000  0.025   5e-4  oscillation"),
        // 9.996…: carried to the second decimal place.
        ("99.92 ± 1", "1  9.996  0.050   5e-4  oscillation"),
        ("99.95 ± 0.8", "1  9.997  0.040   5e-4  oscillation"),
        ("99.99 ± 8", "1  10.00  0.40   5e-3  oscillation"),
        ("2 ± 1e-15", "1  1.414213562  3.5e-16  5e-10  oscillation"),
        // Larger than the number itself: one digit is left, and a word of warning.
        ("1e-4 ± 1", "1  0.01   50     5e-3  oscillation"),
        // A growth has one as well.
        ("-4 ± 0.1", "1  0      0      2.000   0.025   5e-4  unstable"),
        // sqrt(k) has no derivative at 0.
        ("0 ± 0.1", "1  0      none       0  zero"),
        ("4", "1  2.000000000  5e-10  oscillation"),
    ] {
        let text = one(k);
        let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
        let row = words(row);
        assert!(text.lines().any(|line| words(line).starts_with(&row)), "{k}: {row}\n{text}");
        assert_eq!(text.contains("sigma"), k != "4", "{text}");
        assert_eq!(text.contains("only a rough estimate"), k.starts_with("1e-4"), "{text}");
        assert_eq!(text.contains("no derivative"), k.starts_with("0 "), "{text}");
    }
    // Friction: both parts, lambda = -c/2 + i sqrt(1 - c²/4).
    let text = printed("param c = 0.3 ± 0.05  coord x  T = 1/2*x'^2  V = 1/2*x^2  dissipation = 1/2*c*x'^2");
    assert!(text.contains("0.9887  0.0038  -0.150  0.025"), "{text}");
}

#[test]
fn what_sets_ranges_or_is_defined_from_others_has_no_entry() {
    let text = "param n = 3  param k = 2  param w = 3*k  coord x[1..n]
        T = sum(i in 1..n, 1/2*x[i]'^2)  V = sum(i in 1..n, 1/2*w*i*x[i]^2)";
    let (linearized, _, found) = sensitivity(text);
    let names: Vec<&str> =
        found.parameters.iter().map(|parameter| linearized.model().parameters[*parameter].name.as_str()).collect();
    assert_eq!(names, ["k"]);
    // omega = sqrt(3 k i): what k does by way of w counts.
    let own: Ball = found.omega[0][0].unwrap();
    assert!((own.mid_f64() - 6.0_f64.sqrt() / 4.0).abs() < 1e-15);
}

/// With V = 1/2 x·Hx - f x1 + (x1³ + x2³ + …)/6 the diagonal of dK/df is dx/df = H⁻¹e1 at x = 0: for Hilbert's matrix H
/// whole numbers, which the roundings of its entries enter with the condition 1e10.
#[test]
fn motions_of_equilibria_are_solutions_of_linear_systems() {
    let text = "param n = 8  param f = 0  coord x[1..n]  T = sum(i in 1..n, 1/2*x[i]'^2)
        V = sum(i in 1..n, j in 1..n, 1/2*x[i]*x[j]/(i + j - 1)) - f*x[1] + sum(i in 1..n, x[i]^3/6)";
    let slopes = solve(text, &[], 15).0.slopes(1).unwrap();
    let want = [64.0, -2016.0, 20160.0, -92400.0, 221760.0, -288288.0, 192192.0, -51480.0];
    for (i, want) in want.into_iter().enumerate() {
        let own = slopes.stiffness[9 * i];
        let off = own - Ball::exact(want);
        assert!(off.contains_zero() && off.radius < 1e-15, "{own:?}");
    }
    // Nothing holds x1 - x2, which the force would move.
    let text = "param f = 0  coord x[1..2]  T = sum(i in 1..2, 1/2*x[i]'^2)  V = 1/2*(x[1] + x[2])^2 - f*x[1]";
    assert!(solve(text, &[], 15).0.slopes(0).is_none());
}
