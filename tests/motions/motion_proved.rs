//! Proved motions: every bound holds against references of 40 digits and against runs with many more bits, for random models too.
#![cfg(feature = "cli")]

use crate::cli_support;
use crate::common;
use crate::motion_support;

use common::{load, model, model_files};
use librate::linearize::linearize;
use librate::model::Model;
use librate::modes::Options;
use librate::motion::{Enclosed, MotionError, Start, System, Trajectory};
use librate::oscillation::normal_modes;
use librate::precision::Scalar;
use librate::report::{motion_csv, motion_json};
use motion_support::{check, motion, proved, share, times};
use proptest::prelude::*;

/// That two enclosures of the same motion have points in common.
fn agree(what: &str, one: &Trajectory, other: &Trajectory) {
    assert_eq!(one.rows.len(), other.rows.len());
    for (row, same) in one.rows.iter().zip(&other.rows) {
        for (a, b) in row.iter().zip(same) {
            let apart = a.sub(b).mid_f64().abs();
            let rounding = 1e-30 * a.mid_f64().abs();
            assert!(apart <= a.radius + b.radius + rounding, "{what}: {a:?} {b:?}");
        }
    }
}

fn double_pendulum() -> Model {
    model(
        "param g = 9.81  param l[1..2] = 1  param m[1..2] = 1
         coord th[1..2]
         let r1 = [l[1]*sin(th[1]), -l[1]*cos(th[1])]
         let r2 = r1 + [l[2]*sin(th[2]), -l[2]*cos(th[2])]
         T = 1/2*m[1]*dot(r1', r1') + 1/2*m[2]*dot(r2', r2')
         V = m[1]*g*r1[2] + m[2]*g*r2[2]",
    )
}

#[test]
fn closed_forms_lie_within_the_bounds() {
    let pendulum = model(
        "param g = 9.81  param l = 1/2  coord phi
         T = 1/2*l^2*phi'^2  V = -g*l*cos(phi)",
    );
    let kepler = model("coord x, y  T = 1/2*(x'^2 + y'^2)  V = -1/sqrt(x^2 + y^2)");
    let damped = model("param k = 4  param c = 0.2  coord x  T = 1/2*x'^2  V = 1/2*k*x^2  dissipation = 1/2*c*x'^2");
    let driven = model(
        "param k = 4  param f = 0.5  param w = 1.9  coord x
         T = 1/2*x'^2  V = 1/2*k*x^2 - f*cos(w*t)*x  period 2*pi/w",
    );
    let fall = model("param g = 9.81  param m = 2  coord z  T = 1/2*m*z'^2  V = m*g*z");
    let switched = model("coord x  T = 1/2*x'^2  V = 1/2*x^2 - x*tanh(50*sin(t))  period 2*pi");
    for (name, model, from, until, rows) in [
        ("pendulum", &pendulum, "phi=3", "5", 5),
        ("kepler", &kepler, "x=1/5, y'=sqrt(19/2)", "20", 6),
        ("damped", &damped, "x=1", "60", 5),
        ("driven", &driven, "x=0", "100", 5),
        ("free_fall", &fall, "z=10", "2", 3),
        ("switched", &switched, "x=0", "30", 4),
    ] {
        let found = proved(model, from, until, rows, 10).unwrap();
        check(name, model, &found, 10);
        check(name, model, &found, 15);
        // More digits take more bits.
        if name == "pendulum" {
            let more = proved(model, from, until, rows, 30).unwrap();
            assert!(more.proved > found.proved && found.proved == Some(106));
            check(name, model, &more, 30);
        }
    }
}

#[test]
fn a_double_pendulum_for_a_hundred_seconds() {
    let model = double_pendulum();
    let found = proved(&model, "th[1]=3/10, th[2]=3/10", "100", 5, 20).unwrap();
    assert_eq!(found.proved, Some(106));
    check("double_pendulum", &model, &found, 20);
    let most = found.rows.iter().flatten().map(|x| x.radius);
    assert!(most.fold(0.0, f64::max) < 1e-20);
}

#[test]
fn a_chaotic_motion_takes_more_bits() {
    let model = double_pendulum();
    let found = proved(&model, "th[1]=2, th[2]=5/2", "10", 2, 25).unwrap();
    assert!(found.proved > Some(106), "{:?}", found.proved);
    check("chaotic", &model, &found, 25);
}

#[test]
fn the_upright_pendulum_stays_upright() {
    let upright = model("coord phi  T = 1/2*phi'^2  V = -cos(phi)");
    let found = proved(&upright, "phi=pi", "100", 3, 10).unwrap();
    let csv = motion_csv(&upright, &found, None, 10);
    for line in csv.lines().skip(1) {
        assert_eq!(line.split(',').nth(1), Some("3.141592654"), "{csv}");
    }
    assert!(found.proved > Some(106));
}

#[test]
fn constraints_are_enclosed() {
    let rod = model(
        "param g = 9.81  param l = 1/2
         coord x, y
         T = 1/2*(x'^2 + y'^2)
         V = g*y
         constraint x^2 + y^2 = l^2
         equilibrium x = 0
         equilibrium y = -l",
    );
    let found = proved(&rod, "x=sin(1)/2, y=-cos(1)/2", "7", 8, 10).unwrap();
    let angle = model(
        "param g = 9.81  param l = 1/2  coord phi
         T = 1/2*l^2*phi'^2  V = -g*l*cos(phi)",
    );
    let same = proved(&angle, "phi=1", "7", 8, 10).unwrap();
    for (row, angle) in found.rows.iter().zip(&same.rows) {
        let half = librate::precision::Ball::exact(0.5);
        let x = angle[0].sin().mul(&half);
        let off = row[0].sub(&x).mid_f64().abs();
        assert!(off <= row[0].radius + x.radius && off < 1e-20);
    }
    // What is left out follows from the constraint.
    let followed = proved(&rod, "x=3/10", "1", 2, 10).unwrap();
    let full = proved(&rod, "x=3/10, y=-2/5", "1", 2, 10).unwrap();
    agree("y follows", &followed, &full);
}

#[test]
fn what_can_not_be_proved_is_told() {
    let plate = model("coord x  T = 1/2*x'^2  V = abs(x)  guess x = 1");
    let planet = model("coord x, y  T = 1/2*(x'^2 + y'^2)  V = -1/sqrt(x^2 + y^2)");
    let angle = model("coord x, y  T = 1/2*(x'^2 + y'^2)  V = atan2(y, x)^2  guess x = 1");
    let saw = model("coord x  T = 1/2*x'^2  V = 0  force x = atan2(sin(t), cos(t))");
    for (model, from, until, last) in [
        // sqrt 2; a quarter of a period of a fall from 1; the jump of an angle, after a tenth.
        (&plate, "x=1", "3", std::f64::consts::SQRT_2),
        (&planet, "x=1", "3", 1.110_720_8),
        (&angle, "x=-1, y=1, y'=-10", "1", 0.105),
        (&saw, "x=0", "8", std::f64::consts::PI),
    ] {
        let error = proved(model, from, until, 4, 10).unwrap_err();
        let MotionError::NotProved { reached, .. } = &error else {
            panic!("{error}");
        };
        let reached: f64 = reached.parse().unwrap();
        assert!(reached <= last + 1e-6 && reached > 0.5 * last, "{error}");
    }
    let chain = model("coord x[1..30]  T = sum(i in 1..30, x[i]'^2)  V = sum(i in 1..30, x[i]^2)");
    let error = Enclosed::new(&chain).unwrap_err();
    assert!(matches!(error, MotionError::TooLargeToProve { .. }), "{error}");
}

/// A start in decimal fractions is moved onto the constraints within its digits, and enclosed there.
#[test]
fn a_rounded_start_is_moved_onto_the_constraints() {
    let rod = model(
        "coord x, y  T = 1/2*(x'^2 + y'^2)  V = y
         constraint x^2 + y^2 = 1  guess y = -1",
    );
    let system = librate::motion::System::new(&rod).unwrap();
    let parse = |text: &str| librate::motion::Start::parse(text, &rod, None, &system);
    // In full, and with what is left out.
    for text in [
        "x=0.8660254037844386, y=-0.5",
        "x=0.8660254037844386, y=-1/2",
        "x=0.866, y=-0.5",
        "x=0.866, y=-0.5, x'=0.5, y'=0.866",
    ] {
        let start = parse(text).unwrap();
        let [x, y] = [start.positions[0].mid_f64(), start.positions[1].mid_f64()];
        assert!((x * x + y * y - 1.0).abs() < 1e-15, "{text}: {x}, {y}");
        assert!(!start.moved.is_empty(), "{text}");
        for moved in &start.moved {
            assert!(moved.by.abs() < 0.5e-3, "{text}: {moved:?}");
        }
        let one = proved(&rod, text, "1", 3, 10).unwrap();
        let plain = librate::motion::System::new(&rod).unwrap();
        let plain = plain.motion(&start, &times("1", 3)).unwrap();
        agree(text, &one, &plain);
    }
    // A velocity that a condition does not name takes no roundings of the others.
    let skate =
        model("coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)  V = 1/2*(2*x^2 + 3*y^2 + 5*z^2)  constraint z' = y*x'");
    let own = librate::motion::System::new(&skate).unwrap();
    let start = librate::motion::Start::parse("y=1/10, x'=1", &skate, None, &own).unwrap();
    assert_eq!(start.velocities[1].mid_f64(), 0.0);
    // 1/2 is exact: x alone is moved.
    let moved = parse("x=0.8660254037844386, y=-1/2").unwrap().moved;
    assert_eq!(moved.len(), 1);
    // sqrt(3)/2 = 0.86602540378443864676...: by 0.4676e-16 within 0.5e-16.
    assert!((moved[0].by - 4.676_372_317_075_294e-17).abs() < 1e-30, "{moved:?}");
    // Beyond the digits, and where nothing is rounded.
    for text in ["x=0.8661, y=-0.5", "x=1, y=1/10", "x=0.866, y=-0.5, x'=0.51, y'=0.866"] {
        assert!(matches!(parse(text), Err(MotionError::OffConstraints { .. })), "{text}");
    }
    // What is left out follows, and is proved too.
    assert!(parse("x=0.6").unwrap().moved.is_empty());
    proved(&rod, "x=0.6", "1", 3, 10).unwrap();
}

/// A coordinate that no other one moves is known exactly.
#[test]
fn what_rests_is_exact() {
    let two = model("coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*x^2*(1 + y^2) + 1/4*y^4");
    let found = proved(&two, "x=1", "10", 4, 10).unwrap();
    for row in &found.rows {
        assert!(row[1].is_zero() && row[3].is_zero() && row[0].radius < 1e-25);
    }
}

#[test]
fn modes_start_within_their_bounds() {
    let mut followed = 0;
    for path in model_files() {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let model = load(&path);
        if model.coordinates.len() > 3 || model.time_dependent.is_some() {
            continue;
        }
        let Ok(linearized) = linearize(model.clone()) else {
            continue;
        };
        // Without inertia there are no accelerations.
        if linearized.check_inertia().is_err() {
            continue;
        }
        let Ok(enclosed) = Enclosed::new(&model) else {
            continue;
        };
        let modes = normal_modes(&linearized, &Options::default()).unwrap();
        let system = System::new(&model).unwrap();
        let amplitude = share(&linearized, 1e-2);
        for (at, mode) in modes.modes.iter().enumerate() {
            let omega = mode.omega.mid_f64();
            if omega == 0.0 {
                continue;
            }
            let from = Start::mode(at + 1, &amplitude, linearized.model(), (&linearized, &modes), &system).unwrap();
            let times = times(&format!("{:.17e}", 3.0 / omega), 4);
            let found = match enclosed.motion(&from, &times, 10) {
                Ok(found) => found,
                // Constraints that Newton's method led to, and modes of one frequency.
                Err(MotionError::OpenStart {}) => continue,
                Err(error) => panic!("{name}: {error}"),
            };
            agree(&name, &found, &system.motion(&from, &times).unwrap());
            followed += 1;
        }
    }
    assert!(followed > 40, "{followed}");
}

#[test]
fn the_command_line_says_that_it_is_proved() {
    let file = "models/double_pendulum.lag";
    let start = "th[1]=3/10, th[2]=3/10";
    let run = cli_support::run(&[
        "motion",
        file,
        "--start",
        start,
        "--until",
        "10",
        "--samples",
        "3",
        "--proved",
        "--digits",
        "20",
    ]);
    assert_eq!(run.status, 0);
    assert!(run.err.ends_with(" steps with 106 bits; every digit is proved\n"), "{}", run.err);
    let want = "t,th[1],th[2],th[1]',th[2]'
0.0,0.30000000000000000000,0.30000000000000000000,0,0
5.0,0.17273394295466760623,0.33553136340998066131,0.53322223483723456066,0.28564781622746662888
10.0,0.077091680843071750481,0.092761302782235200711,0.33610123782742276864,1.1854540257149328423
";
    assert_eq!(run.out, want);
}

#[test]
fn json_has_the_bounds() {
    let model = model("coord x  T = 1/2*x'^2  V = 1/2*x^2");
    let found = proved(&model, "x=1", "3", 4, 12).unwrap();
    let value: serde_json::Value = serde_json::from_str(&motion_json(&model, &found, 12)).unwrap();
    assert_eq!(value["proved"], true);
    for (column, want) in [(0, f64::cos as fn(f64) -> f64), (1, |t: f64| -t.sin())] {
        let column = &value["columns"][column];
        for row in 0..4 {
            let t = value["times"][row].as_f64().unwrap();
            let own = column["values"][row].as_f64().unwrap();
            let bound = column["error_bounds"][row].as_f64().unwrap();
            assert!((own - want(t)).abs() <= bound + 3e-16 && bound < 1e-15);
        }
    }
    assert_eq!(value["columns"][0]["digits"][3], "-0.989992496600");
    let estimated = motion(&model, "x=1", "3", 4);
    let value: serde_json::Value = serde_json::from_str(&motion_json(&model, &estimated, 12)).unwrap();
    assert_eq!(value["proved"], false);
    assert!(value["columns"][1]["error_estimates"].is_array());
}

/// Two coordinates with masses that depend on the place, coupled anharmonically, with friction, rotation and a drive, some of it.
fn random_model() -> impl Strategy<Value = String> {
    let small = || -4..=4_i32;
    ((small(), small(), small(), small()), (0..3_i32, small(), small(), 0..3_i32)).prop_map(
        |((a, b, c, d), (friction, turn, drive, kind))| {
            let barrier = match kind {
                0 => "cos(q)",
                1 => "exp(-p^2)",
                _ => "1/(2 + sin(p + q))",
            };
            format!(
                "coord p, q
                 lagrangian = 1/2*(2 + sin(q)*{a}/5)*p'^2 + 1/2*(1 + p^2/4)*q'^2 + {b}/10*p'*q'*cos(p)
                   + {turn}/4*(p*q' - q*p') - p^2 - 2*q^2 - {c}/8*p^2*q - {d}/8*(p - q)^4 - {barrier}
                   + {drive}/5*p*cos(2*t)
                 dissipation = {friction}/10*(p'^2 + (p' - q')^2)
                 period pi"
            )
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, ..ProptestConfig::default() })]

    /// Runs in double-double and in many more bits, and the run that is estimated, all hold the same motion.
    #[test]
    fn random_motions_are_enclosed(text in random_model(), start in prop::array::uniform4(-8..=8_i32)) {
        let model = model(&text);
        let [p, q, u, v] = start;
        let from = format!("p={p}/10, q={q}/10, p'={u}/10, q'={v}/10");
        // An unbounded potential may send it off to infinity.
        let Ok(found) = proved(&model, &from, "1", 4, 8) else { return Ok(()) };
        prop_assert_eq!(found.proved, Some(106));
        if let Ok(more) = proved(&model, &from, "1", 4, 30) {
            prop_assert!(more.proved > found.proved);
            agree(&text, &found, &more);
            agree(&text, &motion(&model, &from, "1", 4), &more);
        }
    }
}
