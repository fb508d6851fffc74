//! Motions against closed forms and references of 40 digits (tests/reference/motion.py): every printed digit is right, and
//! estimates of errors are not too small.
#![cfg(feature = "cli")]

use crate::common;
use crate::motion_support;

use std::path::Path;

use common::{load, model, model_files};
use librate::linearize::linearize;
use librate::model::Constant;
use librate::modes::Options;
use librate::motion::{Enclosed, MotionError, Start, System, Times, superposition};
use librate::oscillation::normal_modes;
use librate::precision::{Ball, Big, Scalar};
use librate::report::{motion_csv, motion_svg};
use motion_support::{check, motion, reference, share, signed, start, times};

#[test]
fn a_pendulum_follows_elliptic_functions() {
    let model = model(
        "param g = 9.81  param l = 1/2
         coord phi
         T = 1/2*l^2*phi'^2
         V = -g*l*cos(phi)",
    );
    let found = motion(&model, "phi=3", "5", 5);
    check("pendulum", &model, &found, 10);
    check("pendulum", &model, &found, 25);
    assert!(found.energy_drift.unwrap() < 1e-28);
}

/// The velocity of a coordinate that stays where it is, at an equilibrium that is searched for.
#[test]
fn what_rests_is_zero() {
    let model = model("coord x, y  T = 1/2*x'^2 + 1/2*y'^2  V = 1/2*x^2 - cos(y) + y/100");
    let csv = motion_csv(&model, &motion(&model, "x=1", "10", 5), None, 10);
    for (row, t) in csv.lines().skip(1).zip([0.0, 2.5, 5.0, 7.5, 10.0_f64]) {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let want = [t, t.cos(), -(0.01_f64.asin()), -t.sin(), 0.0];
        assert!(cells.iter().zip(want).all(|(cell, want)| (cell - want).abs() < 1e-9), "{row}");
        assert_eq!(cells[4], 0.0);
    }
}

/// Rows at turning points alone do not tell how large velocities are.
#[test]
fn rows_a_period_apart_keep_their_digits() {
    let model = model("coord x  T = 1/2*x'^2  V = 1/2*x^2");
    let found = motion(&model, "x=1", "200*pi", 3);
    let lines = motion_csv(&model, &found, None, 10);
    let lines: Vec<&str> = lines.lines().skip(1).map(|line| line.split_once(',').unwrap().1).collect();
    assert_eq!(lines, ["1.000000000,0", "1.000000000,0", "1.000000000,0"]);
}

#[test]
fn the_same_pendulum_in_x_and_y() {
    let text = "param g = 9.81  param l = 1/2
         coord x, y
         T = 1/2*(x'^2 + y'^2)
         V = g*y
         constraint x^2 + y^2 = l^2
         equilibrium x = 0
         equilibrium y = -l";
    let model = model(text);
    let found = motion(&model, "x=sin(1)/2, y=-cos(1)/2", "7", 8);
    let angle = self::model(
        "param g = 9.81  param l = 1/2  coord phi
         T = 1/2*l^2*phi'^2  V = -g*l*cos(phi)",
    );
    let same = motion(&angle, "phi=1", "7", 8);
    for (row, angle) in found.rows.iter().zip(&same.rows) {
        let (x, y) = (row[0].mid_f64(), row[1].mid_f64());
        let phi = angle[0].mid_f64();
        assert!((x - 0.5 * phi.sin()).abs() < 1e-15 && (y + 0.5 * phi.cos()).abs() < 1e-15);
        let speed = 0.5 * angle[1].mid_f64();
        assert!((row[2].mid_f64() - speed * phi.cos()).abs() < 1e-14);
        let gap = row[0].mul(&row[0]).add(&row[1].mul(&row[1])).mid_f64() - 0.25;
        assert!(gap.abs() < 1e-15);
    }
    // What is left out of a start follows from the constraint.
    let rest = start(&model, "x=3/10");
    assert!((rest.positions[1].mid_f64() + 0.4).abs() < 1e-16);
}

#[test]
fn a_planet_from_its_pericentre() {
    let model = model(
        "coord x, y
         T = 1/2*(x'^2 + y'^2)
         V = -1/sqrt(x^2 + y^2)",
    );
    // a = 2, e = 9/10
    let found = motion(&model, "x=1/5, y'=sqrt(19/2)", "20", 6);
    check("kepler", &model, &found, 10);
    assert!(found.energy_drift.unwrap() < 1e-27);
}

#[test]
fn friction_and_driving() {
    let damped = model("param k = 4  param c = 0.2  coord x  T = 1/2*x'^2  V = 1/2*k*x^2  dissipation = 1/2*c*x'^2");
    let found = motion(&damped, "x=1", "60", 5);
    check("damped", &damped, &found, 10);
    assert!(found.energy_drift.is_none());
    let driven = model(
        "param k = 4  param f = 0.5  param w = 1.9  coord x  T = 1/2*x'^2  V = 1/2*k*x^2 - f*cos(w*t)*x  period 2*pi/w",
    );
    let found = motion(&driven, "x=0", "100", 5);
    check("driven", &driven, &found, 10);
}

#[test]
fn a_motion_needs_no_equilibrium() {
    let model = model("param g = 9.81  param m = 2  coord z  T = 1/2*m*z'^2  V = m*g*z");
    let found = motion(&model, "z=10", "2", 3);
    check("free_fall", &model, &found, 10);
}

#[test]
fn a_double_pendulum_for_a_hundred_seconds() {
    let model = model(
        "param g = 9.81  param l[1..2] = 1  param m[1..2] = 1
         coord th[1..2]
         let r1 = [l[1]*sin(th[1]), -l[1]*cos(th[1])]
         let r2 = r1 + [l[2]*sin(th[2]), -l[2]*cos(th[2])]
         T = 1/2*m[1]*dot(r1', r1') + 1/2*m[2]*dot(r2', r2')
         V = m[1]*g*r1[2] + m[2]*g*r2[2]",
    );
    let found = motion(&model, "th[1]=3/10, th[2]=3/10", "100", 5);
    check("double_pendulum", &model, &found, 10);
    check("double_pendulum", &model, &found, 20);
    // In doubles, to a tolerance.
    let system = System::new(&model).unwrap();
    let from = start(&model, "th[1]=3/10, th[2]=3/10");
    let want = reference("double_pendulum");
    let mut before = f64::INFINITY;
    for tolerance in [1e-6, 1e-9, 1e-12, 1e-15] {
        let quick = system.quick(&from, &times("100", 5), tolerance).unwrap();
        let off = quick.rows[4]
            .iter()
            .zip(&want[4])
            .map(|(own, want)| (own.mid_f64() - signed(want).mid_f64()).abs())
            .fold(0.0, f64::max);
        assert!(off < before.min(1e3 * tolerance), "{tolerance:e}: {off:e}");
        before = off;
    }
}

#[test]
fn digits_of_a_chaotic_motion_run_out() {
    let model = model(
        "coord p, q
         T = 1/2*(2*p'^2 + q'^2 + 2*cos(p - q)*p'*q')
         V = -9.81*(2*cos(p) + cos(q))",
    );
    let short = motion(&model, "p=3, q=3", "40", 5);
    let long = motion(&model, "p=3, q=3", "120", 13);
    // Rows that both have agree within what they claim, though the runs have other sizes.
    for (row, same) in short.rows.iter().zip(&long.rows) {
        for (a, b) in row.iter().zip(same) {
            let off = a.sub(b).mid_f64().abs();
            assert!(off <= a.radius + b.radius, "{a:?} {b:?}");
        }
    }
    let csv = motion_csv(&model, &long, None, 10);
    let last = csv.lines().last().unwrap();
    let cells: Vec<&str> = last.split(',').collect();
    assert!(cells[1].len() < 8, "{last}");
}

/// Where two components are equally large the first is displaced by the amplitude, as it is positive in the shape.
#[test]
fn modes_start_with_the_sign_of_their_shapes() {
    for (text, mode, signs) in [
        ("coord x, y  T = 1/2*x'^2 + 1/2*y'^2  V = x^2 + y^2 + x*y", 1, [1.0, -1.0]),
        ("coord x, y  lagrangian = 1/2*x'^2 + 1/2*y'^2 - x^2 - y^2 + x*y'", 1, [1.0, 0.0]),
    ] {
        let model = model(text);
        let linearized = linearize(model.clone()).unwrap();
        let modes = normal_modes(&linearized, &Options::default()).unwrap();
        let system = System::new(&model).unwrap();
        let start =
            Start::mode(mode, &share(&linearized, 1.0), linearized.model(), (&linearized, &modes), &system).unwrap();
        let own: Vec<f64> =
            start.positions.iter().map(|x| x.mid_f64().signum() * f64::from(x.mid_f64() != 0.0)).collect();
        assert_eq!(own, signs, "{text}");
    }
}

/// The largest component of a mode is displaced by the amplitude under constraints, too, which the others follow.
#[test]
fn modes_under_constraints_start_at_their_amplitude() {
    let model =
        model("param g = 9.81  coord x, y  T = 1/2*(x'^2 + y'^2)  V = g*y  constraint x^2 + y^2 = 4  guess y = -1");
    let linearized = linearize(model.clone()).unwrap();
    let modes = normal_modes(&linearized, &Options::default()).unwrap();
    let system = System::new(&model).unwrap();
    let start = |by: f64| {
        let amplitude = share(&linearized, by);
        Start::mode(1, &amplitude, linearized.model(), (&linearized, &modes), &system)
    };
    let own = start(1.0).unwrap();
    assert_eq!(own.positions[0].mid_f64(), 1.0);
    assert!((own.positions[1].mid_f64() + 3.0_f64.sqrt()).abs() <= 1e-15);
    assert!(matches!(start(3.0), Err(MotionError::OffConstraints { .. })));
}

#[test]
fn modes_start_small_motions() {
    let mut followed = 0;
    for path in model_files() {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let model = load(&path);
        if model.coordinates.len() > 6 || model.time_dependent.is_some() {
            continue;
        }
        // Some have no equilibrium.
        let Ok(linearized) = linearize(model.clone()) else {
            continue;
        };
        // Without inertia there are no accelerations.
        if linearized.check_inertia().is_err() {
            continue;
        }
        let modes = normal_modes(&linearized, &Options::default()).unwrap();
        let system = System::new(&model).unwrap();
        let amplitude = share(&linearized, 1e-7);
        for (at, mode) in modes.modes.iter().enumerate() {
            let (omega, growth) = (mode.omega.mid_f64(), mode.growth.mid_f64());
            if omega == 0.0 || growth > 0.0 {
                continue;
            }
            followed += 1;
            let from = Start::mode(at + 1, &amplitude, linearized.model(), (&linearized, &modes), &system).unwrap();
            let period = format!("{:.17e}", std::f64::consts::TAU / omega);
            let found = system.motion(&from, &times(&period, 5)).unwrap();
            // After a period it is where it was, but for its decay.
            let decay = (growth * std::f64::consts::TAU / omega).exp();
            let rest = &linearized.equilibrium().values;
            let n = rest.len();
            let size = |i: usize| from.positions[i].sub(&rest[i]).mid_f64();
            let most = (0..n).map(|i| size(i).abs()).fold(0.0, f64::max);
            let rates = linearized.rates();
            for i in 0..n {
                let turned = rates[i].mid_f64() * std::f64::consts::TAU / omega;
                let end = found.rows[4][i].sub(&rest[i]).mid_f64() - turned;
                let off = (end - decay * size(i)).abs();
                assert!(off < 1e-4 * most, "{name}, mode {}: {off:e} of {most:e}", at + 1);
            }
            let linear = superposition(&linearized, &from, &times(&period, 5)).unwrap().collect::<Vec<_>>();
            for (row, linear) in found.rows.iter().zip(&linear) {
                for i in 0..n {
                    let off = (row[i].mid_f64() - linear[i]).abs();
                    // The superposition is one of doubles.
                    let rounding = 4.0 * f64::EPSILON * rest[i].mid_f64().abs();
                    assert!(off < 1e-4 * most + rounding, "{name}, mode {}: {off:e} of {most:e}", at + 1);
                }
            }
        }
    }
    assert!(followed > 80, "{followed}");
}

#[test]
fn numbers_are_in_the_coordinates_units() {
    let model = model(
        "param g : m/s^2 = 9.81  param l : m = 1/2  param m : kg = 1
         coord phi : deg
         T = 1/2*m*l^2*phi'^2
         V = -m*g*l*cos(phi)",
    );
    let from = start(&model, "phi = 90, phi' = 180");
    assert!((from.positions[0].mid_f64() - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert!((from.velocities[0].mid_f64() - std::f64::consts::PI).abs() < 1e-15);
}

/// A knife edge on an incline slides up and down on a cycloid, and never leaves its height for long: A. M. Bloch, Nonholonomic
/// Mechanics and Control, section 1.6.
#[test]
fn a_knife_edge_does_not_slide_down() {
    let edge = model(
        "param g = 9.81  param m = 2  param J = 0.3
         coord x, y, phi
         T = 1/2*m*(x'^2 + y'^2) + 1/2*J*phi'^2
         V = -m*g*x/2
         constraint x'*sin(phi) = y'*cos(phi)",
    );
    let found = motion(&edge, "phi'=3", "4", 9);
    let reach = 9.81 / 2.0 / (2.0 * 9.0);
    for (at, row) in found.rows.iter().enumerate() {
        let turned = 3.0 * 0.5 * at as f64;
        let want = [reach * turned.sin().powi(2), reach * (turned - (2.0 * turned).sin() / 2.0), turned];
        for (own, want) in row.iter().zip(want) {
            assert!((own.mid_f64() - want).abs() < 1e-13, "{at}: {own:?} {want}");
        }
    }
    assert!(found.energy_drift.unwrap() < 1e-20);
    assert_eq!(found.constraint_drift, Some(0.0));
    // What follows from others is left out.
    let ring = |more: &str| {
        let text =
            "coord a, b, c  T = a'^2 + b'^2 + c'^2  V = a^2 + b^2 + 3*c^2  constraint a' = -b'  constraint b' = -c'";
        motion(&model(&format!("{text}{more}")), "a=1, b=-1, c=1", "3", 2).rows
    };
    assert_eq!(ring("  constraint a' = c'"), ring(""));
    let edges = |more: &str| {
        let text = "coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)  V = x^2 + y^2  constraint z' = y*x'";
        motion(&model(&format!("{text}{more}")), "x=1, y=2, y'=1", "3", 2).rows
    };
    assert_eq!(edges("  constraint 2*z' = 2*y*x'"), edges(""));
    let line = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = x^2  constraint x = 3*y + 1";
    let found = motion(&model(&format!("{line}  constraint x' = 3*y'")), "x=2", "3", 2).rows;
    assert_eq!(found, motion(&model(line), "x=2", "3", 2).rows);
    // Single steps in doubles of few digits leave the circle.
    let circle = model("coord x, y  T = 1/2*(x'^2 + y'^2)  V = y  constraint x^2 + y^2 = 1  guess y = -1");
    let system = System::new(&circle).unwrap();
    let from = start(&circle, "x=3/5, y=-4/5");
    assert_eq!(system.motion(&from, &times("5", 9)).unwrap().constraint_drift, Some(0.0));
    let quick = system.quick(&from, &times("5", 9), 1e-6).unwrap();
    let off = |row: &Vec<Ball>| (row[0].mid_f64().powi(2) + row[1].mid_f64().powi(2) - 1.0).abs();
    let most = quick.rows.iter().map(off).fold(0.0, f64::max);
    // Its terms, with the derivatives by x and y, are 2 at most.
    let drift = quick.constraint_drift.unwrap();
    assert!(drift >= most / 2.0 * 0.99 && drift < 1e-3, "{drift:e} {most:e}");
    // A belt that moves does work.
    let belt = model("coord x, y  T = 1/2*(x'^2 + y'^2)  V = x^2 + y^2  constraint x' = x*y' + 1");
    assert!(motion(&belt, "x=1", "1", 2).energy_drift.is_none());
    // Neither is a kink in the way of one, nor the time in its condition.
    let driven = model(
        "coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2*(1 + x^2)) + x'*y*z  V = x^2 + y^2 + z^4 + abs(z)*x
         constraint 2*x' = z*y' + cos(3*t)*z' + t",
    );
    let found = motion(&driven, "x=0.3, z=0.5, y'=1, z'=1", "8", 2);
    assert!((found.rows[1][0].mid_f64() - 15.832885806350956).abs() < 1e-13);
    // A start that slides sideways is no motion of it.
    let system = System::new(&edge).unwrap();
    let slides = Start::parse("y'=1, phi=0", &edge, None, &system);
    assert!(matches!(slides, Err(MotionError::OffConstraints { .. })), "{slides:?}");
}

/// In independent velocities, which are the same everywhere: conditions hold by construction.
#[test]
fn a_disc_rolls() {
    let disc = load(Path::new("models/rolling/disc.lag"));
    let found = motion(&disc, "theta=0.1, phi'=4, x'=2", "10", 3);
    for (own, want) in found.rows.iter().flatten().zip(reference("disc").iter().flatten()) {
        let off = Big::from_ball(own, 200).sub(&signed(want)).mid_f64().abs();
        assert!(off < 1e-20 && own.radius < 1e-22, "{own:?} is off by {off:e}");
    }
    assert_eq!(found.energy_drift, Some(0.0));
    let system = System::new(&disc).unwrap();
    let from = start(&disc, "theta=0.1, phi'=4, x'=2");
    let quick = system.quick(&from, &times("100", 11), 1e-12).unwrap();
    assert!(quick.steps < 1200 && quick.energy_drift.unwrap() < 1e-11, "{quick:?}");
    for row in &quick.rows {
        let value = |at: usize| row[at].mid_f64();
        let (speed, heading) = (0.5 * value(9), value(2));
        assert!((value(5) - speed * heading.cos()).abs() < 1e-15 && (value(6) - speed * heading.sin()).abs() < 1e-15);
    }
}

/// What the conditions leave of a steady motion is where a motion starts: a bicycle rides on, a disc leans in its circle.
#[test]
fn steady_rolling_goes_on() {
    for (name, still) in [("bicycle", "phi"), ("disc_in_circle", "theta")] {
        let model = load(Path::new(&format!("models/rolling/{name}.lag")));
        let system = System::new(&model).unwrap();
        let linearized = Start::linearized(&model, false).unwrap();
        let from = Start::parse("x=0", &model, linearized.as_ref(), &system).unwrap();
        let names: Vec<String> = model.coordinates.names().collect();
        let still = names.iter().position(|own| own == still).unwrap();
        let found = system.motion(&from, &times("1", 2)).unwrap();
        let [first, last] = [0, 1].map(|row| found.rows[row][still].mid_f64());
        assert!((last - first).abs() < 1e-12, "{name}: {first} {last}");
        // A yaw and a pitch that are rounding have constraints whose terms are rounding, too.
        assert_eq!(found.constraint_drift, Some(0.0), "{name}");
        // It moves on all the same.
        assert!(from.velocities.iter().any(|own| own.mid_f64().abs() > 1.0), "{name}");
        assert!(from.velocities.iter().all(|own| own.mid_f64() == 0.0 || own.mid_f64().abs() > 1e-20), "{name}");
    }
}

/// Turned against its sense it rattles and turns back, else it goes on (A. Garcia and M. Hubbard, Proceedings of the Royal Society A 418
/// (1988) 165).
#[test]
fn a_rattleback_turns_back() {
    let text = std::fs::read_to_string("models/rolling/rattleback.lag").unwrap();
    let body = model(&text.replace("equilibrium psi' = W", ""));
    let system = System::new(&body).unwrap();
    let turning = |start: &str| {
        let from = Start::parse(start, &body, None, &system).unwrap();
        let found = system.quick(&from, &times("6", 2), 1e-10).unwrap();
        assert!(found.energy_drift.unwrap() < 1e-8);
        found.rows[1][7].mid_f64()
    };
    assert!(turning("psi'=-5, p=0.001, q=0.0005") > 3.0);
    assert!(turning("psi'=5, p=0.001, q=0.0005") > 4.99);
}

#[test]
fn singularities_are_told() {
    let model = model("coord x, y  T = 1/2*(x'^2 + y'^2)  V = -1/sqrt(x^2 + y^2)");
    let system = System::new(&model).unwrap();
    let from = start(&model, "x=1");
    let error = system.motion(&from, &times("3", 4)).unwrap_err();
    assert!(matches!(error, MotionError::Singular { .. }), "{error}");
    // Where the mass matrix is singular from the start.
    let model = self::model("coord r, phi  T = 1/2*(r'^2 + r^2*phi'^2)  V = 1/2*r^2  guess r = 0");
    let system = System::new(&model).unwrap();
    let from = start(&model, "r=0, phi'=1");
    let error = system.motion(&from, &times("3", 4)).unwrap_err();
    assert!(matches!(error, MotionError::Singular { .. }), "{error}");
}

#[test]
fn units_of_time_do_not_matter() {
    // The same oscillator with a period of 1e-14 s and of 1e14 s.
    for (k, scale) in [("4e28", 1e14), ("4", 1.0), ("4e-28", 1e-14)] {
        let text = format!("param k = {k}  coord x  T = 1/2*x'^2  V = 1/2*k*x^2*(1 + x^2)");
        let model = model(&text);
        let until = format!("{:e}", 3.0 / scale);
        let found = motion(&model, "x=1/2", &until, 4);
        let plain = self::model("coord x  T = 1/2*x'^2  V = 2*x^2*(1 + x^2)");
        let same = motion(&plain, "x=1/2", "3", 4);
        for (row, same) in found.rows.iter().zip(&same.rows) {
            assert!((row[0].mid_f64() - same[0].mid_f64()).abs() < 1e-14, "{k}");
            assert!((row[1].mid_f64() / scale - same[1].mid_f64()).abs() < 1e-14, "{k}");
            assert!(row[0].radius < 1e-20);
        }
    }
}

#[test]
fn wrong_starts_are_told() {
    let model = model(
        "param l = 1/2  coord x, y  T = 1/2*(x'^2 + y'^2)  V = y
         constraint x^2 + y^2 = l^2
         equilibrium x = 0
         equilibrium y = -l",
    );
    let system = System::new(&model).unwrap();
    let linearized = linearize(model.clone()).unwrap();
    let start = |text: &str| Start::parse(text, &model, Some(&linearized), &system).unwrap_err();
    for (text, code) in [
        ("x", "E0601"),
        ("x=", "E0601"),
        ("x=1, x=2", "E0601"),
        ("x''=1", "E0601"),
        ("x=y", "E0601"),
        ("z=1", "E0602"),
        ("x=1", "E0606"),
        ("x=0.3, y=0.3", "E0606"),
        ("y'=1", "E0606"),
    ] {
        let error = start(text);
        assert_eq!(error.code(), code, "{text}: {error}");
    }
    let modes = normal_modes(&linearized, &Options::default()).unwrap();
    let amplitude = Constant::parse("1").unwrap();
    let error = Start::mode(2, &amplitude, linearized.model(), (&linearized, &modes), &system).unwrap_err();
    assert!(matches!(error, MotionError::NoSuchMode { mode: 2, count: 1 }));
    assert!(Times::new(&Constant::parse("0").unwrap(), 3).is_err());
    assert!(Times::new(&Constant::parse("1").unwrap(), 0).is_err());
}

#[test]
fn a_table_and_a_picture() {
    let model = load("models/three_pendulums.lag".as_ref());
    let linearized = linearize(model.clone()).unwrap();
    let modes = normal_modes(&linearized, &Options::default()).unwrap();
    let system = System::new(&model).unwrap();
    let amplitude = Constant::parse("1/2").unwrap();
    let from = Start::mode(2, &amplitude, linearized.model(), (&linearized, &modes), &system).unwrap();
    let times = times("10", 11);
    let found = system.motion(&from, &times).unwrap();
    let linear = superposition(&linearized, &from, &times).unwrap().collect::<Vec<_>>();
    let csv = motion_csv(&model, &found, None, 10);
    let mut lines = csv.lines();
    let header = "t,phi[1],phi[2],phi[3],phi[1]',phi[2]',phi[3]'";
    assert_eq!(lines.next(), Some(header));
    assert_eq!(lines.next(), Some("0.0,0.5000000000,0,-0.5000000000,0,0,0"));
    assert_eq!(csv.lines().count(), 12);
    // An odd motion stays odd.
    for row in csv.lines().skip(1) {
        assert_eq!(row.split(',').nth(2), Some("0"), "{row}");
    }
    let both = motion_csv(&model, &found, Some(&linear), 10);
    assert!(both.lines().next().unwrap().ends_with(",linear phi[3]'"));
    let svg = motion_svg(&model, &found, Some(&linear));
    assert!(svg.contains("φ₃, linear") && svg.matches("<path class=\"c").count() >= 6);
}

#[test]
fn linear_motions_are_told_in_si() {
    // Masses and springs of 3e-300 and 12e-300, and of 3 and 12; lengths far apart.
    let rows = |mass: &str, stiffness: &str, length: &str| -> Vec<Vec<f64>> {
        let text = format!(
            "param m = {mass}  param k = {stiffness}  param l = {length}  coord x, y
             T = m/2*(x'^2 + l^2*y'^2)  V = k/2*(x^2 + (x - l*y)^2)"
        );
        let model = model(&text);
        let linearized = linearize(model.clone()).unwrap();
        let system = System::new(&model).unwrap();
        let start = Start::parse("x=1/10", &model, Some(&linearized), &system).unwrap();
        let times = Times::new(&Constant::parse("3").unwrap(), 4).unwrap();
        let rows = superposition(&linearized, &start, &times).unwrap();
        let scale: f64 = length.parse().unwrap();
        rows.map(|row| vec![row[0], row[1] * scale, row[2], row[3] * scale]).collect()
    };
    let usual = rows("3", "12", "1");
    for (mass, stiffness, length) in [("3e-300", "12e-300", "1"), ("3e200", "12e200", "1e-200")] {
        for (own, usual) in rows(mass, stiffness, length).iter().zip(&usual) {
            let off = own.iter().zip(usual).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-14, "{own:?} {usual:?}");
        }
    }
}

/// A pendulum in x and y.
const PENDULUM: &str = "param m = 2  coord x, y  T = 1/2*m*(x'^2 + y'^2)  V = 9.81*m*y  constraint x^2 + y^2 = 1
    guess y = -1";

#[test]
fn starts_of_other_programs_are_moved_onto_the_constraints() {
    let model = model(PENDULUM);
    let system = System::new(&model).unwrap();
    // sin and cos of 0.6 as a run leaves them that drifts by 1e-6.
    let start =
        Start::parse("x=0.56464303805, y=-0.82533643987, x'=0.8253356149, y'=0.564642473", &model, None, &system);
    let start = start.unwrap();
    let [x, y] = [0, 1].map(|at| start.positions[at].mid_f64());
    assert!((x * x + y * y - 1.0).abs() < 1e-15);
    assert!((x.atan2(-y) - 0.6).abs() < 1e-9, "the same masses: moved along the radius");
    let [u, v] = [0, 1].map(|at| start.velocities[at].mid_f64());
    assert!((x * u + y * v).abs() < 1e-15);
    assert!(
        start.moved.iter().all(|own| own.by.abs() < 1e-5) && start.moved.iter().any(|own| !own.rounded),
        "{:?}",
        start.moved
    );
    // So far off no program is.
    let far = Start::parse("x=0.56464303805, y=-0.83533643987", &model, None, &system);
    assert!(matches!(far, Err(MotionError::OffConstraints { .. })), "{far:?}");
}

#[test]
fn starts_and_times_from_tables() {
    let free = model("param k = 4  coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*k*x^2 + 1/2*y^2");
    let system = System::new(&free).unwrap();
    let starts = Start::table("y,x'\n1,0.5\n-2,0\n", &free, None, &system).unwrap();
    assert_eq!(starts.len(), 2);
    let times = Times::table("name,t\na,1.5\nb,0\nc,0.25\nd,1.5\n").unwrap();
    assert_eq!(times.len(), 4);
    for (start, (y, u)) in starts.iter().zip([(1.0, 0.5), (-2.0, 0.0)]) {
        let start = start.as_ref().unwrap();
        let followed = system.motion(start, &times).unwrap();
        let quick = system.quick(start, &times, 1e-14).unwrap();
        let proved = Enclosed::new(&free).unwrap().motion(start, &times, 12).unwrap();
        for found in [&followed, &quick, &proved] {
            let seen: Vec<f64> = found.times.iter().map(Ball::mid_f64).collect();
            assert_eq!(seen, [1.5, 0.0, 0.25, 1.5]);
            for (t, row) in seen.iter().zip(&found.rows) {
                let want = [u / 2.0 * (2.0 * t).sin(), y * t.cos(), u * (2.0 * t).cos(), -y * t.sin()];
                for (value, want) in row.iter().zip(want) {
                    assert!((value.mid_f64() - want).abs() < 1e-12, "{t}: {row:?}");
                }
            }
        }
    }
    let only_zero = Times::table("t\n0\n").unwrap();
    assert_eq!(system.motion(starts[0].as_ref().unwrap(), &only_zero).unwrap().rows.len(), 1);
    let bad = |text: &str| Times::table(text).unwrap_err().to_string();
    assert!(bad("time\n1\n").contains("there is no column `t`, but time"));
    assert!(bad("t\n").contains("no row"));
    assert!(bad("t\n1\nsoon\n").contains("(line 3): `soon` in the column `t` is not a number"));
    assert!(bad("t\n-1\n").contains("begins at t = 0"));
    let bad = |text: &str| Start::table(text, &free, None, &system).unwrap_err().to_string();
    assert!(bad("z\n1\n").contains("`z` is not a coordinate"));
    assert!(bad("x\nleft\n").contains("`left` in the column `x` is not a number"));
    // One that is wrong is no obstacle to the others.
    let model = model(PENDULUM);
    let system = System::new(&model).unwrap();
    let starts = Start::table("x,y\n0.6,-0.8\n0.6,-0.9\n0.60001,-0.8\n", &model, None, &system).unwrap();
    assert!(starts[0].is_ok() && matches!(starts[1], Err(MotionError::OffConstraints { .. })));
    assert_eq!(starts[2].as_ref().unwrap().moved.len(), 2);
}

/// A stop that is touched for a moment, between two places of a step that are looked at. With V = x²/2 + F max(x - s, 0): from x = cos(t) to where
/// it is s, there as about -F, and back. With V = |x| - 2x the fall towards 0 is a parabola that ends in two others.
#[test]
fn what_is_grazed_is_not_missed() {
    let grazed = model(
        "param s = 0.99999  param F = 100
         coord x  T = 1/2*x'^2  V = 1/2*x^2 + F/2*(abs(x - s) + x - s)",
    );
    let found = motion(&grazed, "x=0, x'=1", "5", 2);
    let csv = motion_csv(&grazed, &found, None, 10);
    // 40 digits by mpmath, from the closed form.
    let last: Vec<&str> = csv.lines().last().unwrap().split(',').collect();
    for (cell, exact) in last[1..].iter().zip([-0.956_374_672_9, 0.292_142_918_8]) {
        let value: f64 = cell.parse().unwrap();
        assert!((value - exact).abs() < 1e-9, "{csv}");
    }
    let falling = model("coord x  T = 1/2*x'^2  V = -2*x + abs(x)");
    let csv = motion_csv(&falling, &motion(&falling, "x=0.49999, x'=-1", "3", 4), None, 10);
    let last: Vec<f64> = csv.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    assert!((last[1] - 2.011_933_473_658).abs() < 1e-9 && (last[2] - 2.005_962_847_940).abs() < 1e-9, "{csv}");
}

/// Stops that are met one soon after the other, in whatever order they are written.
#[test]
fn stops_are_passed_in_the_order_of_time() {
    for (force, y, rate) in [
        ("abs(x - 1.01)/(x - 1.01) + abs(x - 1)/(x - 1)", -2.0199, -0.02),
        ("abs(x - 1)/(x - 1) + abs(x - 1.01)/(x - 1.01)", -2.0199, -0.02),
        // x = t.
        ("abs(x - 1.01) + abs(x - 1)", 2.010_099_666_666_667, 2.0001),
    ] {
        let model = model(&format!("coord x, y  T = 1/2*x'^2 + 1/2*y'^2  V = 0*x  force y = {force}"));
        let csv = motion_csv(&model, &motion(&model, "x=0, x'=1, y=0", "2", 2), None, 10);
        let last: Vec<f64> = csv.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
        let (own, own_rate) = (last[2], last[4]);
        assert!((own - y).abs() < 2e-9 && (own_rate - rate).abs() < 2e-9, "{force}: {csv}");
    }
}
