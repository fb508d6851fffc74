//! Floquet multipliers against references of 50 digits that were computed by other means (tests/reference/driven.py), and
//! the steps behind them against solutions in closed form and against themselves with more digits.
#![cfg(feature = "engine")]

use crate::common;

use common::{load, model_files};
use librate::Source;
use librate::chart::Chart;
use librate::expr::{Pool, Symbol};
use librate::floquet::{Floquet, FloquetError, Options, Place, floquet};
use librate::model::{Model, Range, Settings, TableTexts, elaborate};
use librate::number::Number;
use librate::precision::{Ball, Big, Scalar};
use librate::syntax;
use librate_core::precision::Enclosure;
use librate_studies::floquet::exponent;
use librate_studies::flow::{Enclosing, Equations, Plain};
use proptest::prelude::*;
use serde_json::Value;

fn number(text: &str) -> Number {
    match text.strip_prefix('-') {
        Some(rest) => Number::parse(rest).unwrap().neg(),
        None => Number::parse(text).unwrap(),
    }
}

fn ball(value: &Value) -> Ball {
    Ball::from_number(&number(value.as_str().unwrap()), ())
}

fn model(text: &str, settings: &[String]) -> Model {
    let file = syntax::parse(text).unwrap();
    let mut all = Settings::new();
    for setting in settings {
        all.add(setting).unwrap();
    }
    elaborate(&file, &TableTexts::new(), &all).unwrap()
}

fn multipliers_of(text: &str) -> Floquet {
    floquet(&model(text, &[]), &Options::default()).unwrap()
}

fn assert_holds(what: &str, own: &Ball, want: &Ball) {
    let off = *own - *want;
    assert!(off.contains_zero(), "{what}: {own:?} is not {want:?}");
    assert!(off.abs_upper() <= 1e-12, "{what}: bound {:e}", own.radius);
}

fn assert_multipliers(name: &str, found: &Floquet, wanted: &Value) {
    let wanted = wanted.as_array().unwrap();
    assert_eq!(found.multipliers.len(), wanted.len(), "{name}");
    let mut free: Vec<(Ball, Ball)> = wanted.iter().map(|z| (ball(&z[0]), ball(&z[1]))).collect();
    for own in &found.multipliers {
        let near = |z: &(Ball, Ball)| (z.0 - own.re).abs_upper().hypot((z.1 - own.im).abs_upper());
        let best = (0..free.len()).min_by(|a, b| near(&free[*a]).total_cmp(&near(&free[*b])));
        let (re, im) = free.remove(best.unwrap());
        assert_holds(name, &own.re, &re);
        assert_holds(name, &own.im, &im);
        assert_holds(name, &own.modulus, &(re.powi(2) + im.powi(2)).sqrt());
    }
}

/// A drive that is a force has the potential -F(t) x, and so has one that depends on the place alike.
#[test]
fn forces_with_a_potential_leave_no_place_undecided() {
    let of = |potential: &str, forces: &str| {
        multipliers_of(&format!(
            "coord x, y  T = 1/2*(x'^2 + y'^2)
             V = 1/2*(x^2 + 2*y^2) + 1/4*x^4 {potential}  {forces}  period pi"
        ))
    };
    let energy = of("- 3/10*x*cos(2*t) - 1/5*x*y*(2 + sin(2*t))", "");
    let force = of("", "force x = 3/10*cos(2*t) + 1/5*y*(2 + sin(2*t))  force y = 1/5*x*(2 + sin(2*t))");
    assert_eq!((energy.stable, force.stable), (Some(true), Some(true)));
    for (one, other) in energy.multipliers.iter().zip(&force.multipliers) {
        assert!((one.re - other.re).contains_zero() && (one.im - other.im).contains_zero());
        assert_eq!((one.place, other.place), (Place::On, Place::On));
    }
    // Round a loop this one does work.
    let turning = of("", "force x = 1/5*y*cos(2*t)  force y = -1/5*x*cos(2*t)");
    assert!(turning.multipliers.iter().all(|own| own.place != Place::On));
}

/// Friction that is of second order about rest, or acts on what is not coupled, leaves the other multipliers on the circle.
#[test]
fn friction_that_linear_equations_lack_leaves_no_place_undecided() {
    let free = "coord x, y  T = 1/2*(1 + cos(2*t)/5)*x'^2 + 1/2*y'^2 + sin(2*t)/4*x*y'
        V = 3/2*x^2 + 2/3*y^2 + x*y/10  period pi";
    let wanted = multipliers_of(free);
    assert_eq!(wanted.stable, Some(true));
    for drag in ["force y = y'*sin(x)/6", "force x = x*x'^2  dissipation = 1/2*y^2*y'^2"] {
        let found = multipliers_of(&format!("{free}  {drag}"));
        assert_eq!((found.stable, &found.multipliers), (Some(true), &wanted.multipliers), "{drag}");
    }
    for drag in ["dissipation = 1/2*y'^2/100", "force x = y/100  force y = -x/100", "force x = x'*cos(x)/100"] {
        let found = multipliers_of(&format!("{free}  {drag}"));
        assert!(found.multipliers.iter().all(|own| own.place != Place::On), "{drag}");
    }
    let apart = "coord x, y  T = 1/2*x'^2 + 1/2*y'^2  V = 1/2*(3 + cos(2*t))*x^2 + 2/3*y^2 + x^2*y  dissipation = x'^2/10  period pi";
    let found = multipliers_of(apart);
    let places = |wanted: Place| found.multipliers.iter().filter(|own| own.place == wanted).count();
    assert_eq!((found.stable, places(Place::On), places(Place::Inside)), (Some(true), 2, 2));
}

#[test]
fn models_agree_with_references() {
    let mut checked = 0;
    for path in model_files() {
        let name = path.file_stem().unwrap().to_string_lossy().to_string();
        let text = std::fs::read_to_string(format!("tests/reference/{name}.json")).unwrap();
        let want: Value = serde_json::from_str(&text).unwrap();
        let model = load(&path);
        if want.get("multipliers").is_none() {
            assert!(model.time_dependent.is_none(), "{name} has no reference");
            assert!(matches!(floquet(&model, &Options::default()), Err(FloquetError::NoTime { .. })), "{name}");
            continue;
        }
        checked += 1;
        let found = floquet(&model, &Options::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_holds(&name, &found.period, &ball(&want["period"]));
        for (own, want) in found.place.iter().zip(want["place"].as_array().unwrap()) {
            assert_holds(&name, own, &ball(want));
        }
        assert_multipliers(&name, &found, &want["multipliers"]);
        assert_eq!(found.stable, want["stable"].as_bool(), "{name}");
        assert_holds(&name, &found.growth_rate.unwrap(), &ball(&want["growth_rate"]));
    }
    assert!(checked >= 6);
}

const HILL: &str = "param a = 1  param q = 1  coord y  T = 1/2*y'^2  V = 1/2*(a - 2*q*cos(2*t))*y^2  period pi";

/// The solution that begins with (1, 0) is even, that with (0, 1) odd: a_r are the zeros of y1'(pi), b_r those of y2(pi).
fn sign_changes(q: &str, order: &str, value: &Number) -> bool {
    let size = value.abs().to_f64().max(1.0);
    let shift = Number::from_f64_exact(1e-12 * size).unwrap();
    let entry = |a: &Number| {
        let settings = [format!("a = {}", decimal(a)), format!("q = {q}")];
        let found = floquet(&model(HILL, &settings), &Options::default()).unwrap();
        found.monodromy[if order.starts_with('a') { 2 } else { 1 }]
    };
    let (low, high) = (entry(&value.sub(&shift)), entry(&value.add(&shift)));
    low.is_positive() && high.is_negative() || low.is_negative() && high.is_positive()
}

/// A fraction in the language.
fn decimal(value: &Number) -> String {
    format!("{}/{}", value.numerator(), value.denominator())
}

#[test]
fn borders_of_mathieus_equation() {
    let text = std::fs::read_to_string("tests/reference/driven/mathieu_borders.json").unwrap();
    let data: Value = serde_json::from_str(&text).unwrap();
    let mut checked = 0;
    for (place, row) in data["borders"].as_array().unwrap().iter().enumerate() {
        let row = row.as_object().unwrap();
        let q = row["q"].as_str().unwrap();
        // Each of the orders in one of three rows.
        let orders = row.iter().filter(|(key, _)| *key != "q");
        for (order, value) in orders.skip(place % 3).step_by(3) {
            let value = number(value.as_str().unwrap());
            assert!(sign_changes(q, order, &value), "{order}({q})");
            checked += 1;
        }
    }
    assert_eq!(checked, 8 * 7);
}

/// Tables that others made, with 16 digits.
#[test]
fn borders_of_published_tables() {
    let mut checked = 0;
    for kind in ["a", "b"] {
        let text = std::fs::read_to_string(format!("tests/reference/driven/mathieu_{kind}.csv")).unwrap();
        let mut lines = text.lines();
        let heading: Vec<&str> = lines.next().unwrap().split(',').collect();
        for line in lines.step_by(40) {
            let cells: Vec<&str> = line.split(',').collect();
            for (order, cell) in heading.iter().zip(&cells).skip(1) {
                assert!(sign_changes(cells[0], order, &number(cell)), "{order}({})", cells[0]);
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 3 * 11 + 3 * 10);
}

fn chart(text: &str, ranges: [&str; 2]) -> Chart {
    let file = syntax::parse(text).unwrap();
    let ranges = ranges.map(|range| Range::parse(range).unwrap());
    Chart::new(&Source { file, tables: TableTexts::new(), settings: Settings::new() }, ranges).unwrap()
}

#[test]
fn charts_have_the_borders_of_mathieus_equation() {
    let text = std::fs::read_to_string("tests/reference/driven/mathieu_borders.json").unwrap();
    let data: Value = serde_json::from_str(&text).unwrap();
    for row in data["borders"].as_array().unwrap() {
        let row = row.as_object().unwrap();
        let q = row["q"].as_str().unwrap();
        let chart = chart(HILL, ["a=-20..50:2001", &format!("q={q}..{q}:1")]);
        let mut worker = chart.worker();
        let rows: Vec<_> = (0..chart.len()[0]).map(|at| worker.row(at)).collect();
        let mut found = Vec::new();
        for at in 0..rows.len() {
            let pair = [at, at + 1].map(|at| rows.get(at).map(Vec::as_slice));
            found.extend(worker.borders(at, pair).iter().map(|border| border.at[0]));
        }
        let orders = row.iter().filter(|(key, _)| *key != "q");
        let mut known: Vec<f64> = orders.map(|(_, value)| value.as_str().unwrap().parse().unwrap()).collect();
        known.sort_by(f64::total_cmp);
        // A tongue between two lines of the grid is not seen; what is seen is where it is. In a shallow one the trace comes
        // to its border slowly, in proportion to the width, and what is rounded moves the border by as much more.
        for border in &found {
            let near = (0..known.len())
                .min_by(|a, b| (known[*a] - border).abs().total_cmp(&(known[*b] - border).abs()))
                .unwrap();
            let partner = |at: usize| known.get(at).map_or(f64::INFINITY, |a| (a - known[near]).abs());
            let width = partner(near + 1).min(partner(near.wrapping_sub(1)));
            let allowed = 1e-12 * border.abs().max(10.0) * (0.1 / width).max(1.0);
            let off = (known[near] - border).abs();
            assert!(off <= allowed, "{q}: {border} by {off:e}, width {width}");
        }
        // Beside another border as near as lines of the grid are to each other one may be missed.
        let known: Vec<f64> = known.into_iter().filter(|a| (-20.0..50.0).contains(a)).collect();
        let spacing = 70.0 / 2000.0;
        let alone = |at: usize| {
            let near = |other: usize| known.get(other).is_some_and(|a| (a - known[at]).abs() < spacing);
            !near(at + 1) && !near(at.wrapping_sub(1))
        };
        let clear: Vec<f64> = (0..known.len()).filter(|at| alone(*at)).map(|at| known[at]).collect();
        assert!(!clear.is_empty());
        for a in clear {
            assert!(found.iter().any(|border| (border - a).abs() < 1e-9), "{q}: {a}");
        }
    }
}

#[test]
fn charts_agree_with_certified_multipliers() {
    let damped = "param W = 2  param k = 1  param m = 2  param f = W^2/4  coord x, y
        T = 1/2*(m*x'^2 + y'^2)  V = 1/2*(f + k*cos(W*t))*(x - y)^2 + x^2 + y^2
        dissipation = 1/50*x'^2  period 2*pi/W";
    let forced = "param F = 1  param W = 2  coord x
        T = 1/2*x'^2  V = 1/2*3*x^2 + 1/4*x^4 - F*x*cos(W*t)  dissipation = 1/5*x'^2  period 2*pi/W";
    let jumped = "param F = 3/10  param W = 3/2  coord x  guess x' = 3/2
        T = 1/2*x'^2  V = 1/2*x^2 + 1/4*x^4 - F*x*sin(W*t)  dissipation = 1/200*x'^2  period 2*pi/W";
    let cases = [
        (jumped, ["F=1/5..2/5:3", "W=7/5..8/5:3"]),
        (HILL, ["a=-1..7:5", "q=-3..4:4"]),
        (damped, ["W=1..4:3", "k=0..3/2:3"]),
        (forced, ["F=0..1:2", "W=1/2..3:3"]),
    ];
    let mut seen = [0, 0];
    for (text, ranges) in cases {
        let chart = chart(text, ranges);
        let mut worker = chart.worker();
        let [first, second] = [chart.values(0), chart.values(1)];
        for (i, a) in first.iter().enumerate() {
            let row = worker.row(i);
            for (b, place) in second.iter().zip(row) {
                let exact = |x: &f64| decimal(&Number::from_f64_exact(*x).unwrap());
                let names = chart.names();
                let settings = [format!("{} = {}", names[0], exact(a)), format!("{} = {}", names[1], exact(b))];
                let found = floquet(&model(text, &settings), &Options::default()).unwrap();
                if let Some(stable) = found.stable {
                    seen[usize::from(stable)] += 1;
                    assert_eq!(place.stable, Some(stable), "{settings:?}");
                    let rate = found.growth_rate.unwrap().mid_f64();
                    assert!((place.growth_rate - rate).abs() < 1e-9, "{settings:?} {rate}");
                }
            }
        }
    }
    assert!(seen[0] > 5 && seen[1] > 15, "{seen:?}");
}

#[test]
fn places_do_not_depend_on_those_beside_them() {
    // A row of eight beside its places one by one, with periods and motions that differ from place to place.
    let forced = "param F = 1  param W = 2  coord x
        T = 1/2*x'^2  V = 1/2*3*x^2 + 1/4*x^4 - F*x*cos(W*t)  dissipation = 1/5*x'^2  period 2*pi/W";
    let meissner = "param W = 2  param k = 1  coord x  T = 1/2*x'^2  V = 1/2*(1 + k*cos(W*t))*x^2
        period 2*pi/W";
    for (text, first, [from, to]) in [(forced, "F", [0.5, 4.0]), (meissner, "k", [0.4, 4.0])] {
        let row = chart(text, [&format!("{first}=1..1:1"), &format!("W={from}..{to}:13")]);
        let together = row.worker().row(0);
        for (at, place) in row.values(1).iter().zip(together) {
            let alone = chart(text, [&format!("{first}=1..1:1"), &format!("W={at}..{at}:1")]);
            let alone = alone.worker().row(0)[0];
            assert_eq!(place.stable, alone.stable, "W = {at}");
            let off = (place.growth_rate - alone.growth_rate).abs();
            assert!(off < 1e-11 || place.growth_rate.is_nan(), "W = {at}: {off:e}");
        }
    }
    // One place without a motion beside others that have one.
    let escaping = chart(
        "param F = 1  param W = 2  coord x  T = 1/2*x'^2  V = exp(-x) + F*x - x*cos(W*t)/10  period 2*pi/W",
        ["W=2..2:1", "F=-1..2:7"],
    );
    let row = escaping.worker().row(0);
    let found: Vec<bool> = row.iter().map(|place| place.stable.is_some()).collect();
    assert_eq!(found, [false, false, false, true, true, true, true], "{row:?}");
    // Where Newton's steps have to be shortened the motions are still found, in short time.
    let forced = chart(
        "param F = 1  param W = 2  coord x  T = 1/2*x'^2  V = 1/2*x^2 + 1/4*x^4 - F*x*cos(W*t)  period 2*pi/W",
        ["W=1.2..1.2:1", "F=0.5..0.5:1"],
    );
    assert_eq!(forced.worker().row(0)[0].stable, Some(true));
}

#[test]
fn what_lies_on_the_border_is_undecided() {
    // Without a drive: 2 sqrt(a) = W exactly, where both multipliers are -1.
    let both =
        multipliers_of("coord y  T = 1/2*y'^2 + 0*sin(2*t)*y'  V = 1/2*y^2 + 1/2*0*cos(2*t)*y^2 + sin(2*t)  period pi");
    assert_eq!(both.stable, None);
    assert_eq!(both.growth_rate, None);
    // A free coordinate beside a driven one: 1 twice, with one vector.
    let free = multipliers_of("coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*(2 + cos(7*t)/2)*y^2  period 2*pi/7");
    assert_eq!(free.stable, None);
    assert!(free.growth_rate.unwrap().is_zero());
    let single = free.multipliers.iter().filter(|own| own.place == Place::On && own.single);
    assert_eq!(single.count(), 2);
    assert!(free.multipliers.iter().all(|own| own.place == Place::On));
}

/// cos t over half of its period is -1 times itself: the exponents are i, which of its two signs is open.
#[test]
fn exponents_on_the_cut_have_their_frequency() {
    let found = multipliers_of("coord x  T = 1/2*x'^2  V = 1/2*x^2 + 0*sin(2*t)*x^2 + sin(2*t)  period pi");
    for own in &found.multipliers {
        let (growth, omega) = exponent(own, &found.period);
        assert!(growth.mid_f64().abs() < 1e-12 && (omega.mid_f64() - 1.0).abs() < 1e-12, "{growth:?} {omega:?}");
    }
}

#[test]
fn damping_and_gyroscopic_terms() {
    // The product of all multipliers is exp(-∫ tr M⁻¹C dt).
    let damped = multipliers_of(
        "coord x, y  T = 1/2*(x'^2 + 2*y'^2) + 1/2*(x*y' - y*x')
         V = 1/2*((3 + cos(2*t))*x^2 + 4*y^2)  dissipation = 1/10*x'^2 + 1/5*y'^2  period pi",
    );
    let product = damped.multipliers.iter().fold(Ball::ONE, |all, own| all * own.modulus);
    let want = (Ball::exact(-0.4) * Ball::PI).exp();
    assert!((product - want).abs_upper() < 1e-12, "{product:?} {want:?}");
    assert_eq!(damped.stable, Some(true));
    assert!(damped.growth_rate.unwrap().is_negative());
    // A mass that changes: x = y/sqrt(m).
    let heavy = multipliers_of("let m = 2 + sin(t)  coord x  T = 1/2*m*x'^2  V = 1/2*3*x^2  period 2*pi");
    assert!(heavy.multipliers.iter().all(|own| own.place == Place::On || own.modulus.is_positive()));
    assert!(heavy.stable.is_some());
}

#[test]
fn forced_motion_is_found_and_proved() {
    // Linear: x = cos(t)/(k - 1) in steady state.
    let forced = multipliers_of("coord x  T = 1/2*x'^2  V = 1/2*3*x^2 - x*cos(t)  period 2*pi");
    assert!(!forced.rests);
    assert_holds("x", &forced.place[0], &Ball::exact(0.5));
    assert_holds("x'", &forced.velocities[0], &Ball::ZERO);
    assert_eq!(forced.stable, Some(true));
    // Duffing's oscillator, damped: the multipliers have the product exp(-2 c P).
    let duffing = multipliers_of(
        "coord x  T = 1/2*x'^2  V = 1/2*x^2 + 1/4*x^4 - 3/10*x*cos(6/5*t)  dissipation = 1/10*x'^2  period 2*pi/(6/5)",
    );
    let product = duffing.multipliers.iter().fold(Ball::ONE, |all, own| all * own.modulus);
    let want = (-Ball::exact(0.2) * duffing.period).exp();
    assert!((product - want).abs_upper() < 1e-12);
}

/// Motions of one period beside each other, each from its guess of coordinate and velocity.
#[test]
fn coexisting_motions_are_found_from_their_guesses() {
    let text = std::fs::read_to_string("tests/reference/driven/coexisting.json").unwrap();
    let want: Value = serde_json::from_str(&text).unwrap();
    for motion in want["motions"].as_array().unwrap() {
        let name = motion["model"].as_str().unwrap();
        let found = multipliers_of(name);
        assert!(!found.rests, "{name}");
        assert_holds(name, &found.place[0], &ball(&motion["start"][0]));
        assert_holds(name, &found.velocities[0], &ball(&motion["start"][1]));
        assert_multipliers(name, &found, &motion["multipliers"]);
    }
    // Without a velocity, or beside an equilibrium, what rests is asked for.
    let parametric = "coord x  T = 1/2*x'^2  V = 1/2*(1 + 2/5*cos(2*t))*x^2 + 1/4*x^4  period 2*pi ";
    for rest in ["guess x' = 0", "equilibrium x = 0  guess x' = 1", "guess x = 0"] {
        assert!(multipliers_of(&format!("{parametric} {rest}")).rests, "{rest}");
    }
    // What is found from far away is said to be far.
    let far = multipliers_of(&format!("{parametric} guess x' = 2"));
    let away: Vec<_> = far.away.iter().map(|own| (own.coordinate, own.velocity, own.guess)).collect();
    assert_eq!(away, [(0, true, 2.0)]);
    // Two oscillators, one coupled weakly to the other, each on its own branch: the velocities are those of the references.
    let two = multipliers_of(
        "coord x[1..2] : cm  param m : kg = 1  param k : N/m = 1  param a : N/m^3 = 1  param F : N = 0.3  param W : rad/s = 1.5
         T = sum(i in 1..2, m/2*x[i]'^2)
         V = sum(i in 1..2, k/2*x[i]^2 + a/4*x[i]^4 - F*x[i]*sin(W*t))
         period 2*pi/W  guess x[i in 1..1]' = -37  guess x[2]' : m/s = 2",
    );
    assert_holds("x[1]'", &two.velocities[0], &ball(&want["motions"][4]["start"][1]));
    assert_holds("x[2]'", &two.velocities[1], &ball(&want["motions"][6]["start"][1]));
}

fn single(rate: impl Fn(&mut Pool, Symbol, Symbol) -> librate::expr::ExprId) -> Equations {
    let mut pool = Pool::default();
    let (t, x) = (pool.symbol("t"), pool.symbol("x"));
    let rate = rate(&mut pool, t, x);
    Equations::compile(&mut pool, t, &[x], &[], &[rate]).unwrap()
}

/// x' = x (1 - x) has x(t) = 1/(1 + (1/x_0 - 1) e^-t), with dx/dx_0 = e^-t (x/x_0)².
#[test]
fn logistic_growth_is_enclosed() {
    let equations = single(|pool, _, x| {
        let e = pool.symbol_expr(x);
        let one = pool.one();
        let rest = pool.sub(one, e);
        pool.mul(e, rest)
    });
    let mut walk = Enclosing::<Ball>::new(&equations, 30, ());
    let start = Ball::exact(0.125);
    let (mut time, mut x, mut slope) = (Ball::ZERO, start, Ball::ONE);
    let end = Ball::exact(6.5);
    let mut steps = 0;
    loop {
        let step = walk.step(&time, &[x], &(end - time)).unwrap();
        x = step.image[0] + step.slopes[0] * (x - x.center());
        slope = step.slopes[0] * slope;
        steps += 1;
        if step.whole {
            break;
        }
        time = time + step.length;
    }
    let decay = (-end).exp();
    let want = Ball::ONE / (Ball::ONE + (Ball::ONE / start - Ball::ONE) * decay);
    let turned = decay * (want / start).powi(2);
    assert!((x - want).contains_zero() && x.radius < 1e-27, "{x:?} {want:?}");
    assert!((slope - turned).contains_zero() && slope.radius < 1e-26, "{slope:?} {turned:?}");
    assert!((2..60).contains(&steps), "{steps}");
    let (there, slopes) = Plain::new(&equations).travel(0.0, 6.5, &[0.125], |_, _, _| {}).unwrap();
    assert!((there[0] - want.mid_f64()).abs() < 1e-14);
    assert!((slopes[0] - turned.mid_f64()).abs() < 1e-14);
}

/// x' = x² from 1 is 1/(1 - t): there is no way beyond t = 1.
#[test]
fn a_singularity_ends_the_way() {
    let equations = single(|pool, _, x| {
        let e = pool.symbol_expr(x);
        pool.square(e)
    });
    let mut walk = Enclosing::<Ball>::new(&equations, 20, ());
    let (mut time, mut x) = (Ball::ZERO, Ball::ONE);
    let mut reached = 0;
    while let Some(step) = walk.step(&time, &[x], &(Ball::exact(2.0) - time)) {
        assert!(!step.whole);
        x = step.image[0] + step.slopes[0] * (x - x.center());
        time = time + step.length;
        assert!((x - Ball::ONE / (Ball::ONE - time)).contains_zero());
        reached += 1;
        assert!(reached < 2000);
    }
    assert!(time.mid_f64() > 0.9 && time.mid_f64() < 1.0);
    assert!(Plain::new(&equations).travel(0.0, 2.0, &[1.0], |_, _, _| {}).is_none());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, ..ProptestConfig::default() })]

    /// Results in double-double and with 300 bits hold the same numbers.
    #[test]
    fn precisions_agree(a in -3.0..40.0f64, q in -8.0..8.0f64, b in -0.5..0.5f64) {
        let mut pool = Pool::default();
        let t = pool.symbol("t");
        let e = pool.symbol_expr(t);
        let twice = pool.scale(e, &Number::from(2));
        let cosine = pool.cos(twice);
        let [a, q, b] = [a, q, b].map(|x| Number::from_f64_exact(x).unwrap());
        let wave = pool.scale(cosine, &q);
        let a = pool.number(a.neg());
        let stiffness = pool.add(a, wave);
        let drag = pool.scale(cosine, &b);
        let (zero, one) = (pool.zero(), pool.one());
        let equations = Equations::linear(&pool, t, 2, &[], &[zero, one, stiffness, drag]).unwrap();
        fn total<S: Enclosure>(equations: &Equations, end: S, order: usize, precision: S::Precision) -> Vec<Ball> {
            let mut walk = Enclosing::<S>::new(equations, order, precision);
            let mut total = walk.unit();
            let mut time = S::exact(0.0, precision);
            loop {
                let step = walk.step(&time, &[], &end.sub(&time)).unwrap();
                let s = &step.slopes;
                let entry = |i: usize, j: usize| s[2 * i].mul(&total[j]).add(&s[2 * i + 1].mul(&total[2 + j]));
                total = vec![entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1)];
                if step.whole {
                    return total.iter().map(S::to_ball).collect();
                }
                time = time.add(&step.length);
            }
        }
        let quick = total::<Ball>(&equations, Ball::PI, 34, ());
        let careful = total::<Big>(&equations, Big::pi(300), 90, 300);
        let size = careful.iter().fold(1.0_f64, |most, x| most.max(x.abs_upper()));
        for (quick, careful) in quick.iter().zip(&careful) {
            prop_assert!((*quick - *careful).contains_zero());
            prop_assert!(quick.radius <= 1e-25 * size, "{:e} {:e}", quick.radius, size);
        }
    }
}

/// The same models with constraints and in angles: a pendulum whose support moves up and down with friction, and a double one.
#[test]
fn constraints_leave_the_multipliers_of_free_coordinates() {
    let drive = "param g = 9.81  param l = 0.5  param a = 0.1  param W = 10  param m = 2  period 2*pi/W";
    let one = "let x1 = l*sin(u)  let y1 = -l*cos(u)";
    let energies = |friction: &str| {
        format!("T = 1/2*m*(x1'^2 + (y1 + a*cos(W*t))'^2)  V = m*g*y1  dissipation = 1/2*{friction}*(x1'^2 + y1'^2)")
    };
    let double = "T = 1/2*m*(x1'^2 + (y1 + a*cos(W*t))'^2) + 1/2*(x2'^2 + (y2 + a*cos(W*t))'^2)  V = m*g*y1 + g*y2";
    for (free, tied, energies) in [
        (format!("coord u  {one}"), "coord x1, y1  constraint x1^2 + y1^2 = l^2", energies("0")),
        (format!("coord u  {one}"), "coord y1, x1  constraint sqrt(x1^2 + y1^2) = l", energies("0.3")),
        (
            format!("coord u, v  {one}  let x2 = x1 + l*sin(v)  let y2 = y1 - l*cos(v)"),
            "coord x1, y1, x2, y2  constraint x1^2 + y1^2 = l^2  constraint (x2 - x1)^2 + (y2 - y1)^2 = l^2
             equilibrium x2 = 0  equilibrium y2 = -2*l",
            double.to_owned(),
        ),
    ] {
        let free = multipliers_of(&format!("{drive}  {free}  {energies}"));
        let tied_text = format!("{drive}  {tied}  {energies}  equilibrium x1 = 0  equilibrium y1 = -l");
        let tied = multipliers_of(&tied_text);
        if tied.place.len() == 2 {
            // The same constraint by the velocities that it allows.
            let rolling = tied_text.replace("constraint x1^2 + y1^2 = l^2", "constraint x1*x1' + y1*y1' = 0");
            let rolling = multipliers_of(&rolling);
            assert_eq!(format!("{:?}", rolling.multipliers), format!("{:?}", tied.multipliers), "{energies}");
        }
        assert_eq!(tied.place.len(), tied.velocities.len());
        assert_eq!((tied.stable, tied.multipliers.len()), (free.stable, free.multipliers.len()), "{energies}");
        for (own, other) in tied.multipliers.iter().zip(&free.multipliers) {
            assert!((own.re - other.re).contains_zero() && (own.im - other.im).contains_zero(), "{own:?} {other:?}");
            assert!(own.place == other.place && own.error() < 1e-12);
        }
    }
    // An equilibrium that is none, and what does not determine the directions that are left.
    for (text, what) in [
        (
            "coord x, y  T = x'^2 + (y + cos(t))'^2  V = y + sin(t)*x  constraint x^2 + y^2 = 1  equilibrium y = -1",
            "does not hold at all times",
        ),
        (
            "coord x, y  T = x'^2 + y'^2  V = y^2*cos(t)  constraint x + y = 0  constraint 2*x + 2*y = 0",
            "depend on each other",
        ),
        ("coord x, y  T = x'^2 + y'^2  V = x^2*cos(t)  constraint x = y  constraint x = 0", "leave no motion"),
        ("coord x, y  T = x'^2 + y'^2  V = y^2*cos(t)  constraint x' = x*y'", "constraints on velocities"),
    ] {
        let error = floquet(&model(&format!("{text}  period 2*pi"), &[]), &Options::default()).unwrap_err();
        assert!(error.code() == "E0709" && error.to_string().contains(what), "{text}: {error}");
    }
}

/// On a line that turns at the rate 2 a unit mass on a unit spring obeys u'' = (4 - 1) u; after half a turn u points the other way.
#[test]
fn constraints_that_change_with_time_about_rest() {
    let text = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*(x^2 + y^2)  constraint y*cos(2*t) = x*sin(2*t)  period pi";
    let found = multipliers_of(text);
    let sizes = [3.0_f64.sqrt(), -3.0_f64.sqrt()].map(|rate| (rate * std::f64::consts::PI).exp());
    assert_eq!((found.stable, found.multipliers.len()), (Some(false), 2));
    for (own, size) in found.multipliers.iter().zip(sizes) {
        assert!((own.re.mid_f64().abs() - size).abs() < 1e-9 * size && own.im.is_zero(), "{own:?}");
    }
}

/// Periodic motions with constraints and in angles: supports that move, one of them within the constraint.
#[test]
fn constrained_motions_have_the_multipliers_of_free_ones() {
    let drive = "param g = 9.81  param l = 0.5  param a = 0.03  param W = 7  period 2*pi/W";
    let angle = "coord u  let x = l*sin(u)  let y = -l*cos(u)";
    let circle = "coord x, y  constraint x^2 + y^2 = l^2  guess y = -0.49  guess x = 0.01";
    let sideways = |friction: &str| {
        format!("T = 1/2*((x + a*cos(W*t))'^2 + y'^2)  V = g*y  dissipation = 1/2*{friction}*(x'^2 + y'^2)")
    };
    let lab = "T = 1/2*(x'^2 + y'^2)  V = g*y";
    let cases = [
        (format!("{angle}  {}", sideways("0")), format!("{circle}  {}", sideways("0"))),
        (format!("{angle}  {}", sideways("0.4")), format!("{circle}  {}", sideways("0.4"))),
        (
            format!("coord u  let x = a*cos(W*t) + l*sin(u)  let y = -l*cos(u)  {lab}"),
            format!("coord x, y  constraint (x - a*cos(W*t))^2 + y^2 = l^2  guess x = a  guess y = -l  {lab}"),
        ),
        (
            format!("{angle}  coord v  T = 1/2*((x + a*cos(W*t))'^2 + y'^2) + 1/2*v'^2 + v*x'  V = g*y + 30*v^2"),
            format!("{circle}  coord v  T = 1/2*((x + a*cos(W*t))'^2 + y'^2) + 1/2*v'^2 + v*x'  V = g*y + 30*v^2"),
        ),
    ];
    for (free, tied) in cases {
        let [free, tied] = [free, tied].map(|text| multipliers_of(&format!("{drive}  {text}")));
        assert!(!tied.rests && tied.place.len() > free.place.len());
        assert!((tied.place[0].powi(2) + tied.place[1].powi(2) - Ball::exact(0.25)).abs_upper() < 0.02);
        assert_eq!((tied.stable, tied.multipliers.len()), (free.stable, free.multipliers.len()));
        for (own, other) in tied.multipliers.iter().zip(&free.multipliers) {
            assert!((own.re - other.re).contains_zero() && (own.im - other.im).contains_zero(), "{own:?} {other:?}");
            assert!(own.place == other.place && own.error() < 1e-10);
        }
    }
}
