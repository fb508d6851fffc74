//! Driven models at their limits: periods that are proved, tried or none, borders of stability with several coordinates,
//! multipliers beyond the range of doubles, ways that are too long or end.
#![cfg(feature = "cli")]

use std::f64::consts::PI;

use librate::Source;
use librate::chart::Chart;
use librate::floquet::{Floquet, FloquetError, Options, Place, floquet};
use librate::model::{Model, Range, Settings, TableTexts, elaborate};
use librate::precision::{Ball, Big};
use librate::report::{Style, floquet_text};
use librate::{Error, syntax};
use serde_json::Value;

fn model(text: &str) -> Model {
    let file = syntax::parse(text).unwrap();
    elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap()
}

fn found(text: &str) -> Result<Floquet, FloquetError> {
    floquet(&model(text), &Options::default())
}

/// An oscillator with this drive.
fn driven(drive: &str, period: &str) -> String {
    format!("param g = 9.81  param l = 2  coord x  T = 1/2*x'^2  V = 1/2*(40 + {drive})*x^2  period {period}")
}

#[test]
fn periods_are_proved_from_the_form() {
    for (drive, period, cycles) in [
        ("cos(3/2*sqrt(g/l)*t)", "2*pi/(3/2*sqrt(g/l))", 1),
        ("cos((1 + sqrt(2))*t)", "2*pi/(1 + sqrt(2))", 1),
        ("cos((1 + sqrt(2))*t)", "2*pi*(sqrt(2) - 1)", 1),
        ("exp(sin(2*t))", "pi", 1),
        ("tanh(50*sin(t))", "2*pi", 1),
        ("sin(3*(t + 1/3))", "2*pi/3", 1),
        ("sin(t + sin(t)/2)", "2*pi", 1),
        ("sin(t)^2", "pi", 1),
        ("sin(t)*cos(t)", "pi", 1),
        ("abs(2 + sin(t)*cos(t))", "pi", 1),
        ("cosh(sin(t))", "pi", 1),
        ("atan2(sin(t), 2 + cos(t))", "2*pi", 1),
        ("exp(-tan(sin(t)/2)^2)", "pi", 1),
        ("cos(2*t) + cos(3*t)", "2*pi", 1),
        ("cos(x - t)", "2*pi", 1),
        ("cos(2*t)", "3*pi", 3),
        ("cos(4*t) + cos(6*t)", "4*pi", 4),
        ("sin(t)^2", "6*pi", 6),
    ] {
        let found = found(&driven(drive, period)).unwrap_or_else(|error| panic!("{drive}: {error}"));
        assert!(found.period_proved, "{drive}, {period}");
        assert_eq!(found.cycles, cycles, "{drive}, {period}");
    }
}

#[test]
fn periods_that_are_none_are_disproved() {
    for (drive, period) in [
        ("cos(t)", "3"),
        ("cos(t)", "pi"),
        ("cos(t)", "6.283185307179586"),
        ("cos(t) + cos(sqrt(2)*t)", "2*pi"),
        ("exp(-t)", "1"),
        ("sin(t)^3", "pi"),
        ("tan(t)", "pi/2"),
        ("cos(x*t)", "2*pi"),
        ("t*cos(t)", "2*pi"),
    ] {
        let found = found(&driven(drive, period));
        assert!(matches!(found, Err(FloquetError::NotAPeriod { .. })), "{drive}, {period}: {found:?}");
    }
}

#[test]
fn a_period_that_is_only_tried_is_said_to_be() {
    // acos(1/3) = atan(2 sqrt(2)).
    let text = driven("cos(t)", "4*(asin(1/3) + atan(2*sqrt(2)))");
    let found = found(&text).unwrap();
    assert!(!found.period_proved);
    let style = Style::default();
    let written = |found: &Floquet| floquet_text(&model(&text), found, 10, &style);
    assert!(written(&found).contains("tested at 24 states, not proved"));
    let proved = self::found(&driven("cos(t)", "2*pi")).unwrap();
    assert!(!written(&proved).contains("tested"));
}

#[test]
fn charts_check_the_period() {
    let chart = |period: &str| {
        let text = format!("param a = 1  param q = 1  {}", driven("a - q*cos(a*t)", period));
        let file = syntax::parse(&text).unwrap();
        let ranges = ["a=1..3:3", "q=0..1:2"].map(|range| Range::parse(range).unwrap());
        Chart::new(&Source { file, tables: TableTexts::new(), settings: Settings::new() }, ranges)
    };
    assert!(chart("2*pi/a").is_ok());
    let wrong = chart("2*pi/(a + 1)").unwrap_err();
    assert!(matches!(wrong, Error::Floquet(FloquetError::NotAPeriod { .. })), "{wrong:?}");
}

#[test]
fn resonances_are_those_of_one_cycle() {
    let mathieu = |period: &str| {
        let text = format!("coord y  T = 1/2*y'^2  V = 1/2*(1 - 2/5*cos(2*t))*y^2  period {period}");
        found(&text).unwrap().resonance.unwrap()
    };
    let once = mathieu("pi");
    assert_eq!((once.of, once.order), ((0, 0), 1));
    for period in ["2*pi", "3*pi", "4*pi"] {
        assert_eq!(mathieu(period), once, "{period}");
    }
    // A motor makes x grow, whatever the drive does, which is far from every resonance.
    let motor = found(
        "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 2*x^2 + 2*y^2
         force x = x'/10 + y*cos(7*t)/1000  force y = -y'/10 - x*cos(7*t)/1000  period 2*pi/7",
    );
    let motor = motor.unwrap();
    assert_eq!((motor.stable, motor.resonance, motor.frequencies.len()), (Some(false), None, 2));
}

/// A Mathieu oscillator u and another one v that is stable, in coordinates in which both are coupled.
fn turned(a: &str, q: &str) -> String {
    format!(
        "coord x, y  let u = (3*x + 4*y)/5  let v = (4*x - 3*y)/5  T = 1/2*(x'^2 + y'^2)
         V = 1/2*({a} - 2*({q})*cos(2*t))*u^2 + 1/2*(23/10 + cos(2*t)/7)*v^2  period pi"
    )
}

/// Multipliers of u come together at 1 or -1 at the border: 1e-30 beside it their distance is some 1e-15, and a change of the
/// matrix by 1e-30 decides.
#[test]
fn borders_of_several_coordinates_are_decided() {
    let text = std::fs::read_to_string("tests/reference/driven/mathieu_borders.json").unwrap();
    let data: Value = serde_json::from_str(&text).unwrap();
    let mut checked = 0;
    for row in data["borders"].as_array().unwrap() {
        let q = row["q"].as_str().unwrap();
        let orders: &[&str] = match q {
            "0.5" => &["b1", "a3"],
            "10" => &["a0"],
            _ => continue,
        };
        for order in orders {
            let border = row[*order].as_str().unwrap();
            for (shift, above) in [("1e-30", true), ("-1e-30", false)] {
                let found = found(&turned(&format!("({border} + ({shift}))"), q)).unwrap();
                let stable = order.starts_with('a') == above;
                assert_eq!(found.stable, Some(stable), "{order}({q}) {shift}");
                let outside = found.multipliers.iter().any(|own| own.place == Place::Outside);
                assert_eq!(outside, !stable);
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 6);
}

/// u and v are almost equal, but for the sign of their energy: multipliers that nearly collide on the circle, and could leave it
/// if they did.
#[test]
fn near_collisions_on_the_circle_are_told_apart() {
    for apart in ["1e-8", "1e-12", "1e-20", "1e-40"] {
        let text = format!(
            "coord x, y  let u = (5*x + 4*y)/3  let v = (4*x + 5*y)/3  T = 1/2*(u'^2 - v'^2)
             V = 1/2*(3 - cos(2*t))*u^2 - 1/2*(3 + {apart} - cos(2*t))*v^2  period pi"
        );
        let found = found(&text).unwrap();
        assert_eq!(found.stable, Some(true), "{apart}");
        let mut all = found.multipliers.iter();
        assert!(all.all(|own| own.single && own.place == Place::On), "{apart}");
    }
}

/// What symmetry makes repeat: a ring of equal oscillators, and an isotropic one in a rotating frame, about a periodic motion.
#[test]
fn multipliers_that_repeat_on_the_circle_are_decided_by_their_form() {
    let ring = "coord x[1..3]  T = sum(i in 1..3, 1/2*x[i]'^2)  period 2*pi/3
        V = sum(i in 1..3, 1/2*(1 + cos(3*t)/5)*(x[i] - x[mod(i, 3) + 1])^2 + 1/2*x[i]^2)";
    let rotating = "param W = 3/10  coord x, y
        let X = x*cos(W*t) - y*sin(W*t)  let Y = x*sin(W*t) + y*cos(W*t)
        T = 1/2*(X'^2 + Y'^2)  V = x^2 + y^2 + x*cos(W*t)  period 2*pi/W";
    for (text, rests) in [(ring, true), (rotating, false)] {
        let found = found(text).unwrap();
        assert_eq!((found.stable, found.rests), (Some(true), rests), "{text}");
        let all = &found.multipliers;
        assert!(all.iter().all(|own| own.place == Place::On && own.semisimple));
        let repeated = all.iter().filter(|own| !own.single).count();
        assert_eq!(repeated, 4, "{text}");
    }
}

/// Two that are equal but for the sign of their energy, mixed by a drive that changes neither: a small change could make
/// them grow, and nothing is said.
#[test]
fn multipliers_of_mixed_signature_are_undecided() {
    let text = "coord x, y  period 2*pi
        let X = x*cosh(sin(t)) + y*sinh(sin(t))  let Y = x*sinh(sin(t)) + y*cosh(sin(t))
        T = 1/2*(X'^2 - Y'^2)  V = X^2 - Y^2";
    let found = found(text).unwrap();
    assert_eq!((found.stable, found.growth_rate), (None, None));
    assert!(found.multipliers.iter().all(|own| own.place == Place::Undecided));
}

#[test]
fn multipliers_of_very_different_size_have_all_their_digits() {
    let text = "coord x, y  T = 1/2*(x'^2 + y'^2)
        V = 1/2*(1 + 3*cos(t))*x^2 + 1/2*(2 - 4*cos(t))*y^2 + x*y/10  period 20*pi";
    let found = found(text).unwrap();
    assert_eq!(found.stable, Some(false));
    let sizes: Vec<f64> = found.multipliers.iter().map(|own| own.modulus.mid_f64()).collect();
    assert!(sizes[0] > 1e14 && sizes[3] < 1e-14, "{sizes:?}");
    for own in &found.multipliers {
        assert!(own.modulus.radius < 1e-10 * own.modulus.mid_f64(), "{own:?}");
    }
    // In pairs z, 1/z: ten cycles are the tenth power of one.
    for (own, other) in [(0, 3), (1, 2)] {
        let product = found.multipliers[own].modulus * found.multipliers[other].modulus;
        assert!((product - Ball::ONE).contains_zero());
    }
    let single = self::found(&text.replace("20*pi", "2*pi")).unwrap();
    let power = single.multipliers[0].modulus.powi(10);
    assert!((power - found.multipliers[0].modulus).contains_zero());
}

/// x'' = k(t) x with k > 0 over a thousand cycles: e^6200.
#[test]
fn growth_beyond_the_range_of_doubles_has_a_rate() {
    let text = |period: &str| format!("coord x  T = 1/2*x'^2  V = -1/2*(1 + cos(t)/2)*x^2  period {period}");
    let long = found(&text("2000*pi")).unwrap();
    let once = found(&text("2*pi")).unwrap();
    assert_eq!(long.stable, Some(false));
    let (rate, want) = (long.growth_rate.unwrap(), once.growth_rate.unwrap());
    assert!((rate - want).contains_zero() && rate.radius < 1e-15, "{rate:?} {want:?}");
    assert!(!long.multipliers[0].modulus.is_finite());
    assert!(long.multipliers[0].log_modulus().mid_f64() > 6000.0);
    let written = floquet_text(&model(&text("2000*pi")), &long, 10, &Style::default());
    assert!(written.contains("e2693") && !written.contains('?'), "{written}");
}

/// Two oscillators over many cycles, where enclosures that are multiplied one by one would grow like powers of a number
/// above 1.
#[test]
fn long_periods_do_not_lose_digits() {
    let text = "coord x, y  T = 1/2*(x'^2 + y'^2)
        V = 1/2*(1 + cos(t/200)/2)*y^2 + 3*x^2 + x*y/2  period 400*pi";
    let found = found(text).unwrap();
    assert_eq!(found.stable, Some(true));
    assert!(found.monodromy.iter().all(|entry| entry.radius < 1e-20), "{:?}", found.monodromy);
    let forced = "coord x  T = 1/2*x'^2  V = 1/2*x^2 + x^4/4 - x*cos(2*pi*t/100)  period 100";
    let found = self::found(forced).unwrap();
    assert!(!found.rests);
    assert_eq!(found.stable, Some(true));
}

/// A saddle that is pushed: the motion about which it trembles magnifies what is rounded by e^(4 pi).
#[test]
fn unstable_periodic_motions_have_all_their_digits() {
    let text = "coord x, y  T = 1/2*(x'^2 + y'^2)
        V = -2*x^2 + x^4/4 + 1/2*y^2 + x*y/5 - (x + y)*cos(2*t)/100  period pi";
    let file = model(text);
    let found = floquet(&file, &Options::default().digits(40)).unwrap();
    assert!(!found.rests);
    assert_eq!(found.stable, Some(false));
    assert!((found.growth_rate.unwrap().mid_f64() - 2.0).abs() < 0.1);
    let precise = |at: usize| found.multipliers[at].precise.clone().unwrap();
    let [first, last] = [precise(0), precise(3)];
    let product = &first[0] * &last[0];
    assert!((&product - &Big::one(300)).contains_zero());
    assert!(product.radius().to_f64() < 1e-38, "{product:?}");
    // What double-double says holds the same.
    let coarse = floquet(&file, &Options::default()).unwrap();
    assert!(coarse.multipliers.iter().all(|own| own.precise.is_none()));
    for (coarse, fine) in coarse.multipliers.iter().zip(&found.multipliers) {
        assert!((coarse.re - fine.re).contains_zero() && (coarse.im - fine.im).contains_zero());
    }
    for (coarse, fine) in coarse.place.iter().zip(&found.place) {
        assert!((*coarse - *fine).contains_zero() && fine.radius < 1e-29, "{fine:?}");
    }
}

#[test]
fn ways_that_are_too_long_or_end_are_told() {
    let slow = found("coord x  T = 1/2*x'^2  V = 1/2*(1 + cos(t/1000000)/2)*x^2  period 2000000*pi");
    assert!(matches!(slow, Err(FloquetError::TooLong { .. })), "{slow:?}");
    let forced = found("coord x  T = 1/2*x'^2  V = 1/2*x^2 + x^4/4 - x*cos(t/1000000)  period 2000000*pi");
    assert!(matches!(forced, Err(FloquetError::TooLong { .. })), "{forced:?}");
    let singular = found("coord x  T = 1/2*x'^2  V = 1/2*x^2/cos(t)  period 2*pi");
    assert!(matches!(singular, Err(FloquetError::Singular { .. })), "{singular:?}");
    // As fast as that, and everything stands still.
    let fast = found("coord x  T = 1/2*x'^2  V = 1/2*(1 + cos(1000000*t)/2)*x^2  period 2*pi/1000000").unwrap();
    assert_eq!(fast.stable, Some(true));
    let angle = fast.multipliers[0].im.mid_f64();
    assert!((angle - 2e-6 * PI).abs() < 1e-12, "{angle}");
}

/// Balanced upright, driven: x = pi + y with y'' = sin y - cos(t)/10, y(0) from y'(0) = y(pi/2) = 0, at 30 digits by other means.
#[test]
fn the_motion_by_the_guess_is_found() {
    let text = "coord x  T = 1/2*x'^2  V = -cos(x) + x*cos(t)/10  period 2*pi";
    let upright = found(&format!("{text}  guess x = pi")).unwrap();
    assert!((upright.place[0].mid_f64() - 3.191600990049603).abs() < 1e-14);
    assert!(upright.velocities[0].mid_f64().abs() < 1e-14);
    assert!((upright.multipliers[0].re.mid_f64() / 534.440_882_573_032_7 - 1.0).abs() < 1e-12);
    assert_eq!((upright.stable, upright.away.len()), (Some(false), 0));
    let hanging = found(&format!("{text}  guess x = 1/10")).unwrap();
    assert!(hanging.place[0].mid_f64().abs() < 1.0 && hanging.away.is_empty());
    // Steeper and for longer: e^(3 * 2 pi), and two coupled ones, one of them upright.
    let steep = found("coord x  T = 1/2*x'^2  V = -9*cos(x) + x*cos(t)/10  period 2*pi  guess x = pi");
    assert!((steep.unwrap().place[0].mid_f64() - std::f64::consts::PI).abs() < 0.1);
    let two = found(
        "coord x, y  T = 1/2*(x'^2 + y'^2)  V = -cos(x) - 3*cos(y) + (x - y)^2/100 + x*cos(t)/10
         period 2*pi  guess x = pi  guess y = 0",
    );
    let two = two.unwrap();
    assert!((two.place[0].mid_f64() - 3.2).abs() < 0.2 && two.place[1].mid_f64().abs() < 0.2);
    // There is none near this guess, and that is said.
    let far = found("coord x  T = 1/2*x'^2  V = 3*x^2 + x*cos(t)/10  period 2*pi  guess x = 20");
    let far = far.unwrap();
    assert_eq!((far.away[0].coordinate, far.away[0].guess), (0, 20.0));
    assert!(far.away[0].range.1 < 0.1);
}

/// A trap whose forces average to 0, in SI: what rounding leaves of the average is no frequency.
#[test]
fn rounding_is_no_frequency() {
    for size in ["1", "1e13"] {
        let text = format!(
            "param W = sqrt({size})
             coord x, y  T = 1/2*(x'^2 + y'^2)
             V = 2*{size}*cos(W*t)*(x^2 - y^2)/2  period 2*pi/W"
        );
        let trap = found(&text).unwrap();
        assert_eq!(trap.stable, Some(false));
        assert!(trap.frequencies.is_empty(), "{:?}", trap.frequencies);
        assert_eq!(trap.resonance, None);
    }
}

/// A chain of equal members that pump the next one: exponents a/2 ± iω each as often as it has members, which bounds do not decide beside a
/// smaller one that they do. The rate is that of the chain, or is not told.
#[test]
fn what_is_undecided_may_grow_faster() {
    let text = |n: usize, a: &str| {
        format!(
            "param n = {n}  param a = {a}
             coord x[1..n], z
             T = 1/2*sum(i in 1..n, x[i]'^2) + 1/2*z'^2
             V = sum(i in 1..n, x[i]^2) + z^2
             force x[i in 1..n] = a*x[i]' + sum(j in 1..n where j == i - 1, (1 + cos(t))*x[j])
             force z = a/10*z'
             period 2*pi"
        )
    };
    for (n, a) in [(2, "1e-4"), (6, "1e-4"), (6, "1e-6"), (8, "1e-4")] {
        let found = librate::floquet::floquet(&model(&text(n, a)), &librate::floquet::Options::default()).unwrap();
        let exact = 0.5 * a.parse::<f64>().unwrap();
        if let Some(rate) = found.growth_rate {
            assert!((rate.mid_f64() - exact).abs() <= rate.radius + 1e-15 * exact, "{n}, {a}: {rate:?} is not {exact}");
        }
        assert_eq!(found.growth_rate.is_some(), n == 2, "{n}, {a}");
    }
}
