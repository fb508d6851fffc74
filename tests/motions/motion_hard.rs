//! Motions whose digits are easily wrong: kinks, tops of barriers, forces that begin with a high power of the time, and shapes that are known
//! to 16 digits only.
#![cfg(feature = "cli")]

use crate::cli_support::with_input;
use crate::common;
use crate::motion_support;

use common::model;
use librate::linearize::linearize;
use librate::model::Constant;
use librate::modes::Options;
use librate::motion::{MotionError, Start, System};
use librate::oscillation::normal_modes;
use librate::precision::Scalar;
use librate::report::motion_csv;
use motion_support::{check, motion, proved, reference, signed, start, times};

/// Every cell of the table that is not empty, as text and number, by row.
fn cells(csv: &str) -> Vec<Vec<(String, f64)>> {
    let mut table = csv::Reader::from_reader(csv.as_bytes());
    let rows = table.records().map(|row| {
        let row = row.unwrap();
        let cells = row.iter().skip(1);
        cells.map(|cell| (cell.to_owned(), cell.parse().unwrap_or(f64::NAN))).collect()
    });
    rows.collect()
}

/// Half a unit of the last place.
fn half_unit(text: &str) -> f64 {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |parts| parts.1.len());
    let exponent: i32 = exponent.parse().unwrap();
    0.5 * 10.0_f64.powi(exponent - i32::try_from(decimals).unwrap())
}

/// Holds every printed digit against the reference, however small numbers are, and tells how many cells are empty. What is printed as 0
/// is below 1e-25 of the largest number of its row.
fn digits_hold(name: &str, csv: &str) -> usize {
    let mut empty = 0;
    let rows = cells(csv);
    let want = reference(name);
    assert_eq!(rows.len(), want.len(), "{name}");
    for (row, want) in rows.iter().zip(&want) {
        let size = |want: &String| want.parse::<f64>().unwrap().abs();
        let largest = want.iter().map(size).fold(0.0, f64::max);
        for ((text, _), want) in row.iter().zip(want) {
            if text.is_empty() {
                empty += 1;
                continue;
            }
            if want == "0.0" || text == "0" {
                assert!(text == "0" && size(want) <= 1e-25 * largest, "{name}: {want} as {text}");
                continue;
            }
            let mantissa = text.split_once('e').map_or(text.as_str(), |parts| parts.0);
            let kept = mantissa.trim_start_matches(['-', '0', '.']).replace('.', "");
            let digits = i32::try_from(kept.len()).unwrap();
            let want = signed(want);
            // Half a unit of the last of so many digits is at most this, beside the number.
            let off = signed(text).sub(&want).div(&want).mid_f64().abs();
            assert!(off <= 0.5001 * 10.0_f64.powi(1 - digits), "{name}: {text} is off by {off:e}");
        }
    }
    empty
}

#[test]
fn numbers_may_be_as_small_as_doubles_are() {
    let slope = model("coord x  T = 1/2*x'^2  V = exp(-x)");
    let found = motion(&slope, "x=700", "10", 3);
    assert_eq!(digits_hold("slope", &motion_csv(&slope, &found, None, 10)), 0);
    let found = motion(&slope, "x=760", "10", 3);
    assert_eq!(digits_hold("far_slope", &motion_csv(&slope, &found, None, 10)), 0);
    assert_eq!(found.energy_drift, None);
    let spring = model("coord x  T = 1/2*x'^2  V = 1/2*x^2");
    for from in ["x=1e-310", "x=1/10^310"] {
        let found = motion(&spring, from, "1", 3);
        digits_hold("tiny", &motion_csv(&spring, &found, None, 10));
        let found = proved(&spring, from, "1", 3, 10).unwrap();
        digits_hold("tiny", &motion_csv(&spring, &found, None, 10));
    }
    // A start that no double is near: it is not 0.
    let found = motion(&spring, "x=1e-400", "1", 3);
    assert!(!motion_csv(&spring, &found, None, 10).contains(",0,0"));
    // Inertias and forces of a few digits leave a few.
    let light = model("coord x  T = 1/2*1e-310*x'^2  V = 1/2*1e-310*x^2");
    let found = motion(&light, "x=1", "1", 3);
    assert!(found.rows[2][0].radius > 1e-12);
}

#[test]
fn what_decays_is_followed_on() {
    let friction = model("coord x  T = 1/2*x'^2  V = 1/2*x^2  dissipation = x'^2");
    let found = motion(&friction, "x=1", "1000", 3);
    digits_hold("critical", &motion_csv(&friction, &found, None, 10));
    let found = proved(&friction, "x=1", "1000", 3, 10).unwrap();
    digits_hold("critical", &motion_csv(&friction, &found, None, 10));
}

#[test]
fn a_kick_to_come_is_no_singularity() {
    let kick = model("coord x  T = 1/2*x'^2  V = x^2/2 - x*exp(-(t-3)^2*1e4)  period 1");
    for (name, from) in [("kicked", "x=0"), ("kicked_from_one", "x=1")] {
        let found = motion(&kick, from, "6", 3);
        check(name, &kick, &found, 20);
        assert_eq!(digits_hold(name, &motion_csv(&kick, &found, None, 20)), 0);
    }
    let found = proved(&kick, "x=0", "6", 3, 10).unwrap();
    assert_eq!(digits_hold("kicked", &motion_csv(&kick, &found, None, 10)), 0);
}

#[test]
fn a_chain_begins_with_ever_higher_powers_of_the_time() {
    let chain = model(
        "coord x[1..12]
         let u[0] = 0
         let u[i in 1..12] = x[i]
         let u[13] = 0
         T = sum(i in 1..12, 1/2*x[i]'^2)
         V = sum(i in 0..12, 1/4*(u[i+1] - u[i])^4)",
    );
    let found = motion(&chain, "x[1]=1", "1", 3);
    let csv = motion_csv(&chain, &found, None, 10);
    assert!(digits_hold("quartic_chain", &csv) <= 26, "{csv}");
    // What the others never move rests.
    let two = model("coord x, y  T = 1/2*(x'^2 + y'^2)  V = x^2/2 + y^4/4*cos(x)");
    let csv = motion_csv(&two, &motion(&two, "x=1", "4", 3), None, 10);
    assert!(cells(&csv).iter().all(|row| row[1].0 == "0" && row[3].0 == "0"), "{csv}");
}

/// The powers of the time that the members begin with count up beyond the order of a step.
#[test]
fn a_pull_runs_along_a_chain() {
    let chain = |n: usize| {
        model(&format!(
            "coord x[1..{n}]
             T = sum(i in 1..{n}, 1/2*x[i]'^2)
             V = sum(i in 2..{n}, 50*(x[i] - x[i-1])^2) + 50*x[1]^2 + 50*x[{n}]^2"
        ))
    };
    let chain_of_20 = chain(20);
    let found = motion(&chain_of_20, "x[1]=1", "1/5", 5);
    assert!(found.steps < 100, "{} steps", found.steps);
    let csv = motion_csv(&chain_of_20, &found, None, 10);
    assert_eq!(digits_hold("pulled_chain", &csv), 0, "{csv}");
    // A force that grows with the time adds terms behind the first ones, which are small as well.
    let driven = model(
        "coord x[1..17]
         T = sum(i in 1..17, 1/2*x[i]'^2)
         V = sum(i in 2..17, 1/2*1e-6*(x[i] - x[i-1])^2) - x[1]*t^2",
    );
    let csv = motion_csv(&driven, &motion(&driven, "x[1]=1e-6", "1", 2), None, 10);
    // By the series in fractions: 1e-6*k^15*t^30/30! + 2*k^15*t^34/34! and so on.
    let last = &cells(&csv)[1];
    assert_eq!([&*last[15].0, &*last[16].0], ["1.054430242e-128", "9.176831057e-138"]);
    // Most of these have not been reached by what moves with any order.
    let found = motion(&chain(100), "x[1]=1", "1/5", 2);
    assert!(found.steps < 1000, "{} steps", found.steps);
}

/// Whether the motion is said to end in a singularity, or only that it can't be followed.
#[test]
fn singularities_are_enclosed() {
    let of = |text: &str, from: &str| {
        let own = model(&format!("coord x  T = 1/2*x'^2  {text}  guess x = 1"));
        let system = System::new(&own).unwrap();
        system.motion(&start(&own, from), &times("3", 3)).unwrap_err()
    };
    for (text, from) in [
        ("V = -1/x", "x=1"),
        ("V = ln(x)", "x=1"),
        ("V = -1/x^5", "x=1"),
        ("V = 2*x - sqrt(x - 1/2)", "x=1/4"),
        ("V = 1/x", "x=0"),
    ] {
        let error = of(text, from);
        assert!(matches!(error, MotionError::Singular { .. }), "{text}: {error}");
    }
    for (text, from) in [("V = -x^4", "x=1"), ("V = -exp(3*x)", "x=1"), ("V = exp(1000*x)", "x=1")] {
        let error = of(text, from);
        assert!(matches!(error, MotionError::Stuck { .. }), "{text}: {error}");
    }
    let thin = model("coord x  T = 1/2*x^2*x'^2  V = x  guess x = 1");
    let system = System::new(&thin).unwrap();
    let error = system.motion(&start(&thin, "x=1"), &times("3", 3)).unwrap_err();
    assert!(error.to_string().contains("inverse"), "{error}");
}

#[test]
fn steps_end_at_kinks() {
    let plate = model("coord x  T = 1/2*x'^2  V = abs(x)  guess x = 1");
    check("bounce", &plate, &motion(&plate, "x=1", "20", 5), 10);
    check("bounce", &plate, &motion(&plate, "x=1", "20", 5), 22);
    let edge = model("coord x  T = 1/2*x'^2  V = 1/2*x^2 + abs(x - 1/3)  guess x = 0");
    check("edge", &edge, &motion(&edge, "x=2", "20", 5), 20);
    // From rest, where the force of friction has its kink.
    let drag = model("coord x  T = 1/2*x'^2  V = 1/2*x^2  dissipation = 1/3*abs(x')^3");
    check("drag", &drag, &motion(&drag, "x=1", "10", 5), 20);
}

/// The same in u = x + x³/3, where the inertia is that of 1.
#[test]
fn kinks_are_passed_where_the_inertia_changes() {
    let bent = model("coord x  T = 1/2*(x'*(1 + x^2))^2  V = 1/2*(x + x^3/3)^2 + abs(x)*(1 + x^2/3)");
    let found = motion(&bent, "x=1", "12", 13);
    let plain = model("coord u  T = 1/2*u'^2  V = 1/2*u^2 + abs(u)");
    for (row, same) in found.rows.iter().zip(&motion(&plain, "u=4/3", "12", 13).rows) {
        let x = row[0].mid_f64();
        let off = x + x.powi(3) / 3.0 - same[0].mid_f64();
        assert!(off.abs() < 1e-14, "{off:e}");
    }
    // One in another, as of a clearance: a mass of 2 is drawn back by 1, and beyond 1/2 driven on; x = 0 at t = 2 √6 - 2.
    let clear = model("coord x  T = x'^2  V = abs(abs(x) - 1/2)");
    let x = motion(&clear, "x=2", "4", 3).rows.iter().map(|row| row[0].mid_f64()).collect::<Vec<_>>();
    assert!((x[1] - 1.0).abs() < 1e-15 && (x[2] - 38.0 + 16.0 * 6.0_f64.sqrt()).abs() < 1e-13, "{x:?}");
    // From the kink itself.
    assert_eq!(motion(&bent, "x=0, x'=1", "2", 3).rows.len(), 3);
}

#[test]
fn kinks_of_several_coordinates_meet() {
    // Twice the same ball, and a third one on its own: kinks at the same time and at others.
    let three = model(
        "coord x[1..3]
         T = 1/2*(x[1]'^2 + x[2]'^2 + x[3]'^2)
         V = abs(x[1]) + abs(x[2]) + 2*abs(x[3])
         guess x[1] = 1",
    );
    let found = motion(&three, "x[1]=1, x[2]=1, x[3]=-2", "20", 5);
    let one = model("coord x  T = 1/2*x'^2  V = abs(x)  guess x = 1");
    let same = motion(&one, "x=1", "20", 5);
    for (row, same) in found.rows.iter().zip(&same.rows) {
        for (at, own) in [(0, 0), (1, 0), (3, 1), (4, 1)] {
            let off = row[at].sub(&same[own]).mid_f64().abs();
            assert!(off <= 1e-25, "{off:e}");
        }
        // Twice as far with twice the force takes the same time.
        let off = row[2].mid_f64() + 2.0 * row[0].mid_f64();
        assert!(off.abs() < 1e-14, "{off:e}");
    }
}

#[test]
fn a_block_that_sticks_is_told() {
    let block = model("coord x  T = 1/2*x'^2  V = 1/2*x^2  dissipation = 1/2*abs(x')");
    let system = System::new(&block).unwrap();
    // Dry friction of 1/2 holds it where the spring draws with less.
    let from = start(&block, "x=1/4");
    let error = system.motion(&from, &times("10", 3)).unwrap_err();
    let MotionError::Singular { reason, .. } = &error else {
        panic!("{error}");
    };
    assert!(reason.contains("kink"), "{error}");
    // From 9/4 it turns at -5/4 and at 1/4, where it stays, after 2 pi.
    let from = start(&block, "x=9/4");
    let found = system.motion(&from, &times("6", 13)).unwrap();
    for (row, time) in found.rows.iter().zip(&found.times) {
        let t = time.mid_f64();
        let want = if t < std::f64::consts::PI { 0.5 + 1.75 * t.cos() } else { -0.5 + 0.75 * t.cos() };
        assert!((row[0].mid_f64() - want).abs() < 1e-14, "{t}");
    }
    let error = system.motion(&from, &times("7", 3)).unwrap_err();
    assert!(matches!(error, MotionError::Singular { .. }), "{error}");
}

/// At rest on a ridge a ball falls to either side, or not; with a force along it, or a way down that both sides share, there is one motion.
#[test]
fn ridges_have_no_single_motion() {
    let ridge = model("coord x, y  T = 1/2*(x'^2 + y'^2)  V = y - abs(x)");
    let system = System::new(&ridge).unwrap();
    let error = system.motion(&start(&ridge, "x=0, y=1"), &times("1", 2)).unwrap_err();
    assert!(matches!(&error, MotionError::Singular { reason, .. } if reason.contains("several motions")), "{error}");
    let found = system.motion(&start(&ridge, "x=0, x'=-1"), &times("2", 2)).unwrap();
    assert_eq!(found.rows[1][0].mid_f64(), -4.0);
    for (way, want) in [("y - x^2*abs(x)", -2.0), ("y - abs(x) + 2*x", -6.0)] {
        let model = model(&format!("coord x, y  T = 1/2*(x'^2 + y'^2)  V = {way}"));
        let found = System::new(&model).unwrap().motion(&start(&model, "x=0"), &times("2", 2));
        let rows = found.unwrap().rows;
        assert_eq!(rows[1][usize::from(want == -2.0)].mid_f64(), want, "{way}");
    }
}

/// Where a momentum or the energy would jump at a kink, velocities would have to: a gear that changes its side, a step of the potential,
/// an inertia that is another one beyond.
#[test]
fn impacts_end_a_motion() {
    for (text, start) in [
        ("coord x, y  T = 1/2*x'^2 + 1/2*(y' + abs(x)')^2  V = 1/2*y^2", "x = -1, x' = 1"),
        ("coord x  T = 1/2*x'^2  V = 1/2*x^2 + abs(x)/x", "x = -1, x' = 3"),
        ("coord x  T = 1/2*(2 + abs(x)/x)*x'^2  V = 1/2*x^2", "x = -1, x' = 3"),
    ] {
        let run = with_input(&["motion", "-", "--start", start, "--until", "2"], text);
        assert!(run.err.contains("error[E0607]") && run.err.contains("would jump"), "{text}: {}", run.err);
    }
    // Without a jump there.
    let still = "coord x  T = 1/2*x'^2  V = x*abs(t - 2)";
    let run = with_input(&["motion", "-", "--start", "x = 1, x' = 2", "--until", "4", "--samples", "2"], still);
    assert!(run.out.ends_with("4.0,1.000000000,-2.000000000\n"), "{} {}", run.out, run.err);
}

#[test]
fn what_begins_at_zero_is_followed() {
    // Steps used to be as long as the table: nothing had a size yet.
    let switched = model("coord x  T = 1/2*x'^2  V = 1/2*x^2 - x*tanh(50*sin(t))  period 2*pi");
    let found = motion(&switched, "x=0", "30", 4);
    check("switched", &switched, &found, 10);
    check("switched", &switched, &found, 20);
    // x'' = t⁸: x = t¹⁰/90; and x'' = 1/(1 - t⁸), whose last terms vanish: the sum of t^(8k+2)/((8k+1)(8k+2)).
    let late = model("coord x  T = 1/2*x'^2  V = -x*t^8  period 1");
    let found = motion(&late, "x=0", "3", 4);
    assert!((found.rows[3][0].mid_f64() - 59049.0 / 90.0).abs() < 1e-10);
    let powers = model("coord x  T = 1/2*x'^2  V = -x/(1 - t^8)  period 1");
    let found = motion(&powers, "x=0", "3/4", 2);
    let sum: f64 = (0..40).map(|k| 0.75_f64.powi(8 * k + 2) / f64::from((8 * k + 1) * (8 * k + 2))).sum();
    assert!((found.rows[1][0].mid_f64() - sum).abs() < 1e-15);
}

/// A pendulum that stands upright stands there for ever; its start in 31 digits falls after some seventy units of time, and is upright
/// again for a while after that.
#[test]
fn nothing_is_claimed_of_a_fall_that_rounding_began() {
    let upright = model("coord phi  T = 1/2*phi'^2  V = -cos(phi)");
    for samples in [3, 5, 21] {
        let found = motion(&upright, "phi=pi", "200", samples);
        for row in cells(&motion_csv(&upright, &found, None, 10)) {
            for ((text, value), want) in row.iter().zip([std::f64::consts::PI, 0.0]) {
                if !text.is_empty() {
                    assert!((value - want).abs() <= half_unit(text), "{text}");
                }
            }
        }
        let last = found.rows.last().unwrap();
        assert!(last[0].radius > 0.1);
    }
}

#[test]
fn cells_without_digits_are_empty() {
    let double = model(
        "coord p, q
         T = 1/2*(2*p'^2 + q'^2 + 2*cos(p - q)*p'*q')
         V = -9.81*(2*cos(p) + cos(q))",
    );
    let found = motion(&double, "p=2, q=5/2", "100", 6);
    let csv = motion_csv(&double, &found, None, 10);
    let last = cells(&csv).pop().unwrap();
    assert!(last.iter().all(|(text, _)| text.is_empty()), "{csv}");
}

#[test]
fn shapes_have_no_more_digits_than_are_known() {
    let springs = model(
        "coord x[1..2]
         T = 1/2*x[1]'^2 + 1/2*x[2]'^2
         V = 1/2*x[1]^2 + x[2]^2 + 1/2*(x[1] - x[2])^2",
    );
    let linearized = linearize(springs.clone()).unwrap();
    let modes = normal_modes(&linearized, &Options::default()).unwrap();
    let system = System::new(&springs).unwrap();
    let amplitude = Constant::parse("1").unwrap();
    let from = Start::mode(1, &amplitude, linearized.model(), (&linearized, &modes), &system).unwrap();
    let found = system.motion(&from, &times("2", 3)).unwrap();
    // The other component is (sqrt 5 - 1)/2, and both go as cos(omega t), omega² = (5 - sqrt 5)/2.
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    let omega = ((5.0 - 5.0_f64.sqrt()) / 2.0).sqrt();
    let csv = motion_csv(&springs, &found, None, 25);
    for (row, time) in cells(&csv).iter().zip(&found.times) {
        let (text, value) = &row[1];
        let want = golden * (omega * time.mid_f64()).cos();
        let unit = half_unit(text);
        assert!((value - want).abs() <= 1.001 * unit + 1e-15 && unit > 1e-17, "{csv}");
    }
    // What is displaced by the amplitude is, to the last digit.
    assert!(csv.lines().nth(1).unwrap().contains(",1.000000000000000000000000,"), "{csv}");
}

/// What rests at an equilibrium that was searched for moves by rounding alone, which says nothing of the others.
#[test]
fn what_rests_leaves_the_digits_of_others() {
    let text = "coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)  V = 1/2*x^2 - cos(y) + y/100 + (z - x)^2 + 0*z";
    let apart = with_input(
        &["motion", "-", "--start", "x=1, z=1", "--until", "1", "--samples", "3"],
        &text.replace(" + (z - x)^2", ""),
    );
    assert_eq!(apart.status, 0, "{}", apart.err);
    let rows: Vec<Vec<&str>> = apart.out.lines().skip(1).map(|line| line.split(',').collect()).collect();
    // cos t, asin(-1/100) and 0 or nothing, -sin t.
    assert_eq!([rows[1][1], rows[2][1]], ["0.8775825619", "0.5403023059"]);
    assert!(rows.iter().all(|row| row[2] == "-0.01000016667"), "{rows:?}");
    assert_eq!([rows[1][4], rows[2][4]], ["-0.4794255386", "-0.8414709848"]);
    // 0 exactly, though the place was searched for.
    let still = with_input(&["motion", "-", "--start", "y=1", "--until", "1", "--samples", "2"], text);
    let rows: Vec<Vec<&str>> = still.out.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert!(rows.iter().all(|row| row[1] == "0" && row[3] == "0" && row[4] == "0"), "{rows:?}");
}
