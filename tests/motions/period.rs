//! Periods against references found by other means (tests/reference/periods.py), and what has none.
#![cfg(feature = "cli")]

use crate::cli_support;

use cli_support::*;
use librate::linearize::linearize;
use librate::model::{Constant, elaborate};
use librate::number::Number;
use librate::period::{Motion, Options, Oscillator, Period, Request};
use librate::precision::{Ball, Big, Scalar};
use librate::report::{Style, period_text};
use librate::syntax;
use proptest::prelude::*;
use serde_json::Value;

fn oscillator(text: &str) -> Oscillator {
    let file = syntax::parse(text).unwrap_or_else(|errors| panic!("{text}: {errors:?}"));
    let model = elaborate(&file, &Default::default(), &Default::default()).unwrap();
    Oscillator::of_model(&model).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn period(text: &str, request: &Request, digits: usize) -> Period {
    let options = Options::default().digits(digits);
    oscillator(text).period(request, &options).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn amplitude(text: &str) -> Request {
    Request::Amplitude(Constant::parse(text).unwrap())
}

fn energy(text: &str) -> Request {
    Request::Energy(Constant::parse(text).unwrap())
}

fn references() -> Vec<Value> {
    let text = std::fs::read_to_string("tests/reference/periods.json").unwrap();
    serde_json::from_str(&text).unwrap()
}

/// The text of a case's model.
fn text(case: &Value) -> String {
    match case.get("file") {
        Some(file) => std::fs::read_to_string(file.as_str().unwrap()).unwrap(),
        None => case["model"].as_str().unwrap().to_owned(),
    }
}

fn asked(case: &Value) -> Request {
    match case.get("amplitude") {
        Some(value) => amplitude(value.as_str().unwrap()),
        None => energy(case["energy"].as_str().unwrap()),
    }
}

#[test]
fn periods_agree_with_references() {
    for case in references() {
        let found = period(&text(&case), &asked(&case), 10);
        let want = Number::parse(case["period"].as_str().unwrap()).unwrap();
        let want = Big::from_number(&want, 200);
        let own = found.precise.clone().unwrap_or_else(|| Big::from_ball(&found.period, 200));
        let off = &own - &want;
        // The reference has 40 digits.
        let slack = 1e-39 * want.mid_f64();
        let bound = own.radius().to_f64();
        assert!(off.mid_f64().abs() <= bound + slack, "{case}: off by {:e}, bound {bound:e}", off.mid_f64());
        assert!(bound <= 1e-17 * want.mid_f64(), "{case}: {bound:e}");
        // What is printed as a double is within its bound, and that is what rounding to doubles takes.
        let double = Ball::from(found.period.mid_f64());
        let off = Big::from_ball(&double, 200).sub(&want).mid_f64().abs();
        assert!(off <= found.period.mid_f64_error(), "{case}");
        assert!(found.period.mid_f64_error() <= 2e-16 * want.mid_f64(), "{case}");
    }
}

#[test]
fn forty_digits_are_those_of_the_references() {
    for case in references().iter().step_by(3) {
        let found = period(&text(case), &asked(case), 36);
        let want = Number::parse(case["period"].as_str().unwrap()).unwrap();
        let want = Big::from_number(&want, 300).decimal(36);
        let own = found.precise.unwrap().decimal(36);
        assert_eq!(own.text, want.text, "{case}");
    }
}

/// What is printed for the models of `models/period` and the motions that have references, which the digits are held
/// against above.
#[test]
fn periods_print_as_before() {
    insta::glob!("../../models/period", "*.lag", |path| {
        let model = std::fs::read_to_string(path).unwrap();
        let own = oscillator(&model);
        let name = path.file_name().unwrap().to_str().unwrap();
        let mut out = String::new();
        for case in references() {
            let file = case.get("file").and_then(Value::as_str).unwrap_or_default();
            if !file.ends_with(&format!("/{name}")) {
                continue;
            }
            let options = Options::default();
            let found = own.period(&asked(&case), &options).unwrap();
            let request = case.get("amplitude").map_or("energy", |_| "amplitude");
            out.push_str(&format!("--{request} {}\n", case[request].as_str().unwrap()));
            out.push_str(&period_text(&own, &found, &options, &Style::default()));
            out.push('\n');
        }
        assert!(!out.is_empty(), "{name} has no reference");
        insta::with_settings!({ snapshot_path => "../../models/period/snapshots", prepend_module_to_snapshot => false, omit_expression => true }, {
            insta::assert_snapshot!(out);
        });
    });
}

/// About a corner there are no small oscillations, and a top is no equilibrium.
#[test]
fn corners_are_told() {
    let wedge = period("coord x  T = 1/2*x'^2  V = abs(x - 1)", &amplitude("1"), 10);
    assert!(wedge.corner && wedge.proved && wedge.small.is_none() && wedge.bend.is_none());
    assert_eq!(wedge.equilibrium.mid_f64(), 1.0);
    let pressed = period("coord x  T = 1/2*x'^2  V = x^2 + abs(x)", &amplitude("1"), 10);
    assert!(pressed.corner && pressed.small.is_none());
    // Flat on one side: half of a harmonic motion about -1, and the time from -5/2 to -2 and back of one about 0.
    for (text, time) in [
        ("V = 1/2*x^2 + abs(x + 1)", std::f64::consts::PI + 2.0 * 0.8_f64.acos()),
        ("param k = 0.3  V = k*(1/2*x^2 + abs(x + 1))", (std::f64::consts::PI + 2.0 * 0.8_f64.acos()) / 0.3_f64.sqrt()),
    ] {
        let flat = period(&format!("coord x  T = 1/2*x'^2  {text}"), &amplitude("1.5"), 10);
        assert!(flat.corner && (flat.period.mid_f64() - time).abs() < 1e-14 * time, "{:?}", flat.period);
    }
    for text in [
        "coord x  T = 1/2*x'^2  V = x^4 - abs(x)",
        "coord x  T = 1/2*x'^2  V = abs(x) - x",
        "coord x  T = 1/2*x'^2  V = abs(x) - x - x^3",
        "coord x  T = 1/2*x'^2  V = abs(x)  equilibrium x = 1/7",
        "coord x  T = 1/2*x'^2  V = abs(x) + 2*x",
        "param k  coord x  T = 1/2*x'^2  V = k*abs(x)",
        "coord x, y  T = 1/2*x'^2 + 1/2*y'^2  V = abs(x) + y^2",
        "coord x  T = 1/2*x'^2  V = abs(x)  dissipation = x'^2",
    ] {
        let file = syntax::parse(text).unwrap();
        let model = elaborate(&file, &Default::default(), &Default::default()).unwrap();
        assert!(Oscillator::of_model(&model).is_err(), "{text}");
    }
}

/// A force that is constant on each side of a corner is not called constant.
#[test]
fn a_force_that_jumps_is_not_the_same_everywhere() {
    for text in ["coord x  T = 1/2*x'^2  V = abs(x - 1)", "coord x, y  T = x'^2 + y'^2  V = abs(x + y - 1)"] {
        let file = syntax::parse(text).unwrap();
        let model = elaborate(&file, &Default::default(), &Default::default()).unwrap();
        let error = linearize(model).unwrap_err();
        assert!(!matches!(error, librate::linearize::LinearizeError::NoEquilibrium { .. }), "{error}");
    }
}

#[test]
fn turning_points_and_small_oscillations_are_told() {
    let morse = "coord x  T = 1/2*x'^2  V = (1 - exp(-x))^2";
    let found = period(morse, &energy("1/4"), 10);
    let Motion::Libration { turning } = found.motion else { panic!("a libration") };
    // (1 - e^-x)² = 1/4
    assert!((turning[0].mid_f64() + 1.5_f64.ln()).abs() < 1e-15);
    assert!((turning[1].mid_f64() - 2.0_f64.ln()).abs() < 1e-15);
    // omega = sqrt(2 (1 - E)), and E = A² to the leading order.
    let bend = found.bend.unwrap();
    assert!((bend.mid_f64() + 0.5).abs() < 1e-25 && bend.radius < 1e-25);
    let small = found.small.unwrap();
    assert!((small.mid_f64() - std::f64::consts::TAU / 2.0_f64.sqrt()).abs() < 1e-14);
    let quartic = period("coord x  T = 1/2*x'^2  V = x^4", &amplitude("1"), 10);
    assert!(quartic.small.is_none() && quartic.bend.is_none());
}

/// omega = omega_0 (1 + bend A²), against the periods themselves.
#[test]
fn small_amplitudes_change_the_frequency_as_told() {
    for text in [
        "coord q  T = 1/2*q'^2  V = 1 - cos(q)",
        "coord q  T = 1/2*(1 + q + q^2/3)*q'^2  V = q^2/2 + q^3/5 - q^4/7",
        "coord q  T = 1/2*exp(q)*q'^2  V = cosh(q) + q^3",
        "param k = 3  coord q  T = q'^2/(2 + sin(q))  V = k*(q - 1)^2*(1 + q^2)  guess q = 1",
    ] {
        let own = oscillator(text);
        let at = |amplitude: &Request| own.period(amplitude, &Options::default().digits(20)).unwrap();
        let (large, small) = (at(&amplitude("1/500")), at(&amplitude("1/1000")));
        let bend = small.bend.unwrap().mid_f64();
        // (omega/omega_0 - 1)/A² = bend + c A + …, c taken out.
        let change = |found: &Period, amplitude: f64| {
            let ratio = found.small.unwrap().div(&found.period);
            ratio.sub(&Ball::ONE).mid_f64() / amplitude.powi(2)
        };
        let extrapolated = 2.0 * change(&small, 1e-3) - change(&large, 2e-3);
        assert!((extrapolated - bend).abs() < 1e-4 * (1.0 + bend.abs()), "{text}: {bend} {extrapolated}");
    }
}

/// In another coordinate the same motion has the same period.
#[test]
fn coordinates_do_not_matter() {
    // x = sinh(q)
    let plain = "coord x  T = 1/2*x'^2  V = x^2/2 + x^4/3 - x^3/4";
    let bent = "coord q  let x = sinh(q)  T = 1/2*x'^2  V = x^2/2 + x^4/3 - x^3/4";
    for energy_text in ["1/10", "1", "50"] {
        let [plain, bent] = [plain, bent].map(|text| period(text, &energy(energy_text), 20).period);
        assert!(plain.radius < 1e-23 && bent.radius < 1e-23);
        assert!(plain.sub(&bent).contains_zero(), "{energy_text}");
    }
}

/// A term linear in the velocity and a constant in V change nothing; T0 belongs to the potential.
#[test]
fn what_does_not_count() {
    let plain = period("coord x  T = 1/2*x'^2  V = x^2/2 + x^4", &amplitude("1"), 15);
    let others = [
        "coord x  T = 1/2*(x' + x^2)^2 - x^4/2  V = x^2/2 + x^4 + 7",
        "coord x  lagrangian = 1/2*x'^2 - x^2/2 - x^4",
        "coord x  T = 1/2*x'^2 - x^4  V = x^2/2",
    ];
    for text in others {
        let other = period(text, &amplitude("1"), 15);
        let off = other.period.sub(&plain.period);
        assert!(off.contains_zero(), "{text}: {off:?}");
    }
}

#[test]
fn units_of_the_coordinate_count() {
    let text = |unit: &str| {
        format!(
            "param m : kg = 1  param g : m/s^2 = 9.81  param l : cm = 50  coord phi : {unit}  T = 1/2*m*l^2*phi'^2  V = m*g*l*(1 - cos(phi))"
        )
    };
    let degrees = period(&text("deg"), &amplitude("90"), 15);
    let radians = period(&text("rad"), &amplitude("pi/2"), 15);
    assert!(degrees.period.sub(&radians.period).contains_zero());
}

/// The area of an orbit in phase space grows with the energy as the period: dJ/dE = T. A check that uses nothing of
/// E - U at turning points but their places.
fn action(coefficients: &[f64], excess: f64, turning: &[Ball; 2]) -> f64 {
    // J = 2 ∫ sqrt(2 (E - U)) dx with x = middle + half sin s; trapezoidal sums converge geometrically.
    let (a, b) = (turning[0].mid_f64(), turning[1].mid_f64());
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let count = 400;
    let potential = |x: f64| coefficients.iter().rev().fold(0.0, |sum, c| (sum + c) * x);
    let total: f64 = (0..count)
        .map(|at| {
            let s = std::f64::consts::TAU * (f64::from(at) + 0.5) / f64::from(count);
            let x = middle + half * s.sin();
            let rest = (excess - potential(x)).max(0.0);
            (2.0 * rest).sqrt() * half * s.cos().abs()
        })
        .sum();
    total * std::f64::consts::TAU / f64::from(count)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Wells that are polynomials, by Gauss and Chebyshev's rule on (E - U)/((x - a)(b - x)), which is a polynomial
    /// too; in doubles.
    #[test]
    fn polynomial_wells(c2 in 1..20i32, c3 in -6..6i32, c4 in 0..9i32, c5 in -2..2i32, c6 in 1..5i32, a in 1..30i32) {
        let text = format!("coord x  T = 1/2*x'^2  V = {c2}/10*x^2 + {c3}/10*x^3 + {c4}/10*x^4 + {c5}/10*x^5 + {c6}/10*x^6");
        let own = oscillator(&text);
        // Where a barrier is in the way there is an error, and nothing to compare.
        let Ok(found) = own.period(&amplitude(&format!("{a}/10")), &Options::default().digits(15)) else {
            return Ok(());
        };
        let Motion::Libration { turning } = &found.motion else { panic!("a libration") };
        let coefficients: Vec<f64> = [0, c2, c3, c4, c5, c6].iter().map(|c| f64::from(*c) / 10.0).collect();
        let (low, high) = (turning[0].mid_f64(), turning[1].mid_f64());
        // Synthetic division of E - U by (x - high) and (x - low).
        let mut polynomial: Vec<f64> = std::iter::once(found.energy.mid_f64())
            .chain(coefficients.iter().map(|c| -c))
            .collect();
        for root in [high, low] {
            let mut carry = 0.0;
            for c in polynomial.iter_mut().rev() {
                let next = *c + carry * root;
                *c = carry;
                carry = next;
            }
        }
        let ratio = |x: f64| -polynomial.iter().rev().fold(0.0, |sum, c| sum * x + c);
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        // Twice as many points until nothing changes.
        let rule = |count: i32| -> f64 {
            let sum: f64 = (0..count)
                .map(|k| {
                    let angle = std::f64::consts::PI * (f64::from(k) + 0.5) / f64::from(count);
                    (2.0 / ratio(middle + half * angle.cos())).sqrt()
                })
                .sum();
            sum * std::f64::consts::PI / f64::from(count)
        };
        let (coarse, fine) = (rule(2000), rule(4000));
        if (coarse - fine).abs() < 1e-12 * fine {
            let own = found.period.mid_f64();
            prop_assert!((own - fine).abs() < 1e-11 * fine, "{text}, {a}/10: {own} {fine}");
        }
        // dJ/dE = T by central differences is good to some 1e-5 only, but shares nothing with the integrand above.
        let energy_now = found.energy.mid_f64();
        let near = |factor: &str| {
            let request = energy(&format!("{energy_now:e}*{factor}").replace("e-", "*10^-").replace("e", "*10^"));
            own.period(&request, &Options::default()).ok()
        };
        if let (Some(below), Some(above)) = (near("(1 - 1/1000)"), near("(1 + 1/1000)")) {
            let area = |found: &Period| match &found.motion {
                Motion::Libration { turning } => action(&coefficients, found.energy.mid_f64(), turning),
                _ => f64::NAN,
            };
            let slope = (area(&above) - area(&below)) / (2e-3 * energy_now);
            let both = below.period.mid_f64() - above.period.mid_f64();
            if both.abs() < 0.01 * fine {
                prop_assert!((slope / fine - 1.0).abs() < 2e-3, "{text}, {a}/10: {slope} {fine}");
            }
        }
    }
}

fn told(model: &str, more: &[&str]) -> String {
    let mut arguments = vec!["period", "-"];
    arguments.extend(more);
    let run = with_input(&arguments, model);
    assert_eq!((run.status, run.out.as_str()), (1, ""), "{model} {more:?}");
    run.err
}

/// What is beyond the range or the digits of doubled doubles is asked for again with more bits, whatever digits are wanted.
#[test]
fn periods_beyond_doubles() {
    let tau = 2.0 * std::f64::consts::PI;
    for (model, request, want) in [
        ("coord x  T = 1e200*x'^2  V = 1e-200*x^2", amplitude("1/10"), tau * 1e200),
        // 2 pi/sqrt(2 (1 - E)) with 1 - E = 2 e^-300: the turning point is where nothing holds any more.
        ("coord x  T = 1/2*x'^2  V = (1 - exp(-x))^2", amplitude("300"), 4.378_467_779_859_209e65),
        // Up to a minimum of U where stiffness vanishes: gamma(1/4)²/sqrt(pi).
        ("coord x  T = 1/2*x'^2  V = x^4/4  guess x = 1", amplitude("1"), 7.416_298_709_205_487),
    ] {
        let found = period(model, &request, 10);
        let off = (found.period.mid_f64() - want).abs();
        assert!(off <= 4e-16 * want, "{model}: {:?}", found.period);
    }
    // A narrow bump, far below the smallest double at the bottom of the well: the same as with 40 digits.
    let bump = "coord x  T = 1/2*x'^2  V = x^2/2 + 10*exp(-((x - 1/2)/0.02)^2)";
    for asked in [energy("1/2"), energy("1/10")] {
        let few = period(bump, &asked, 10).period;
        let many = period(bump, &asked, 40).period;
        assert!(few.sub(&many).contains_zero(), "{few:?} {many:?}");
    }
}

#[test]
fn an_equilibrium_without_stiffness_is_found_where_it_is_simple() {
    let well = "coord x  T = 1/2*x'^2  V = x^4/4  guess x = 1";
    let found = period(well, &amplitude("1"), 10);
    assert!(found.proved && found.equilibrium.is_zero());
    assert!(found.small.is_none() && found.bend.is_none());
    // Where it is not, nothing is said of small oscillations about it.
    let irrational = "coord x  T = 1/2*x'^2  V = (x^2 - 2)^4  guess x = 1";
    let found = period(irrational, &amplitude("1/10"), 10);
    assert!(!found.proved && found.small.is_none() && found.bend.is_none());
}

#[test]
fn motions_without_a_period_are_told() {
    let pendulum = "coord q  T = 1/2*q'^2  V = 1 - cos(q)";
    let cubic = "coord x  T = 1/2*x'^2  V = x^2/2 + x^3/3";
    let double = "coord x  T = 1/2*x'^2  V = x^4/4 - x^2/2";
    let right = format!("{double}  guess x = 1");
    let middle = format!("{double}  equilibrium x = 0");
    let cases: [(&str, [&str; 2], &str); 32] = [
        (pendulum, ["--amplitude", "4"], "E0505"),
        (pendulum, ["--amplitude", "pi"], "E0506"),
        (pendulum, ["--amplitude", "0"], "E0504"),
        (pendulum, ["--amplitude", "-1"], "E0504"),
        (pendulum, ["--energy", "2"], "E0506"),
        (pendulum, ["--energy", "0"], "E0507"),
        (pendulum, ["--energy", "-3"], "E0507"),
        (cubic, ["--amplitude", "1/2"], "E0506"),
        (cubic, ["--amplitude", "0.6"], "E0509"),
        (cubic, ["--energy", "1/6"], "E0506"),
        (cubic, ["--energy", "1"], "E0509"),
        (&right, ["--energy", "0"], "E0506"),
        (&right, ["--energy", "-1/4"], "E0507"),
        (&right, ["--amplitude", "sqrt(2) - 1"], "E0506"),
        (&middle, ["--amplitude", "1"], "E0508"),
        (&middle, ["--energy", "-1/10"], "E0507"),
        ("coord x  T = x'^2  V = (1 - exp(-x))^2", ["--energy", "1"], "E0509"),
        ("coord x  T = x'^2  V = ln(1 + x^2)*(1 - x)  guess x = 0", ["--energy", "9"], "E0509"),
        // As high as the equilibrium, and lower, behind barriers.
        (pendulum, ["--amplitude", "2*pi"], "E0505"),
        (pendulum, ["--amplitude", "4*pi + 1"], "E0505"),
        (pendulum, ["--energy", "1e300"], "E0504"),
        (pendulum, ["--amplitude", "1e-145"], "E0504"),
        // A pole.
        ("coord x  T = x'^2  V = 3*tan(2*x)^2", ["--amplitude", "1"], "E0505"),
        // The cusp of a cycloid: no barrier, for nothing is left of the inertia.
        ("coord u  T = 2*cos(u/2)^2*u'^2  V = 2*sin(u/2)^2", ["--amplitude", "pi"], "E0510"),
        ("coord x  T = x'^2  V = (x^2 - 2)^2*(x^2 + 1)  guess x = 1", ["--amplitude", "1/10"], "E0508"),
        ("coord x  T = x'^2", ["--amplitude", "1"], "E0509"),
        ("coord x  T = 0*x'^2  V = x^2", ["--amplitude", "1"], "E0513"),
        ("coord x  T = x'^2  V = x^2 + abs(x^2 - 1/8)", ["--amplitude", "1/2"], "E0510"),
        ("coord x  T = x'^4  V = x^2", ["--amplitude", "1"], "E0503"),
        ("coord x, y  T = x'^2 + y'^2  V = x^2 + y^2", ["--amplitude", "1"], "E0501"),
        ("coord x  T = x'^2  V = x^2*(2 + cos(t))", ["--amplitude", "1"], "E0502"),
        ("coord x  T = (1 - x^2)*x'^2  V = x^2", ["--amplitude", "2"], "E0511"),
    ];
    for (model, request, code) in cases {
        let err = told(model, &request);
        assert!(err.contains(&format!("[{code}]")), "{model} {request:?}: {err}");
    }
    let beyond = told(pendulum, &["--amplitude", "4"]);
    assert!(beyond.contains("barrier at q = 3.141593") && beyond.contains("the barrier is 2 above"), "{beyond}");
}

#[test]
fn one_motion_is_asked_for() {
    let model = "coord x  T = x'^2  V = x^2";
    for wrong in [
        &["--amplitude", "1", "--energy", "1"][..],
        &[],
        &["--amplitude", "y"],
        &["--amplitude", "1) + (1"],
        &["--energy", ""],
        &["--over", "k=0..1:3"],
    ] {
        let mut arguments = vec!["period", "-"];
        arguments.extend(wrong);
        assert_eq!(with_input(&arguments, model).status, 2, "{wrong:?}");
    }
}

#[test]
fn curves_are_what_single_requests_give() {
    let run = run(&["period", "models/simple_pendulum.lag", "--over", "amplitude=1..4:4"]);
    assert_eq!(run.status, 0);
    assert!(run.err.contains("at amplitude = 4"), "{}", run.err);
    let lines: Vec<&str> = run.out.lines().collect();
    assert_eq!(lines[0], "amplitude,period,error_bound");
    assert_eq!(lines[4], "4.0,,");
    for line in &lines[1..4] {
        let cells: Vec<&str> = line.split(',').collect();
        let one = printed(&["period", "models/simple_pendulum.lag", "--amplitude", cells[0], "--json"]);
        let one: Value = serde_json::from_str(&one).unwrap();
        assert_eq!(one["period_digits"], cells[1]);
        assert_eq!(one["digits_error_bound"], cells[2].parse::<f64>().unwrap());
    }
}

#[test]
fn curves_are_drawn() {
    let folder = std::env::temp_dir().join(format!("librate-period-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("curve.svg");
    let run = run(&[
        "plot",
        "period",
        "models/simple_pendulum.lag",
        "--over",
        "energy=5..60:12",
        "-o",
        file.to_str().unwrap(),
    ]);
    assert_eq!(run.status, 0, "{}", run.err);
    let svg = std::fs::read_to_string(&file).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    // Below the barrier and above it: two lines.
    assert!(svg.contains("<path class=\"c0 line\"") && svg.contains("<path class=\"c1 line\""), "{svg}");
    assert!(svg.contains(">libration<") && svg.contains(">rotation<"));
    assert!(svg.contains("period (s)"));
}

#[test]
fn numbers_far_from_usual_ones_change_nothing() {
    let plain = period("coord x  T = x'^2/2  V = x^2/2 + x^4/4", &amplitude("1"), 20);
    let slow = "coord x  T = x'^2/2  V = exp(-800)*(x^2/2 + x^4/4)";
    let found = period(slow, &amplitude("1"), 20);
    let want = plain.period * Ball::exact(400.0).apply(librate_core::precision::Function::Exp);
    assert!((found.period - want).contains_zero());
    // E = 3/4 exp(-800), which is no double.
    let energy = found.energy_precise.unwrap().decimal(8).text;
    assert_eq!(energy, "2.7509059e-348");
    let Motion::Libration { turning } = found.motion else { panic!("it turns") };
    assert!((turning[1] - Ball::ONE).contains_zero());
    let pendulum =
        |m: &str, g: &str, l: &str| format!("coord phi  T = {m}*{l}^2*phi'^2/2  V = {m}*{g}*{l}*(1 - cos(phi))");
    let near = period(&pendulum("1", "1", "1"), &amplitude("2"), 15).period;
    let far = period(&pendulum("1e-300", "1e200", "1e-80"), &amplitude("2"), 15).period;
    let far = far * Ball::from_number(&Number::parse("1e140").unwrap(), ());
    assert!((far - near).contains_zero() && (far - near).radius < 1e-14);
}

/// What is told beside the period of a motion with kinks, and what is not.
#[test]
fn kinks_beside_the_period() {
    // The change of the frequency is linear in the amplitude.
    let stiffer = period("coord x  T = 1/2*x'^2  V = 1/2*x^2 + abs(x)^3", &amplitude("1/1000"), 10);
    assert!(stiffer.bend.is_none());
    assert!((stiffer.small.unwrap().mid_f64() - std::f64::consts::TAU).abs() < 1e-15);
    // A spring that is stiffer on one side has half of a period on each: whole, with any amplitude; as a square of the part pressed, too.
    let halves = std::f64::consts::PI * (1.0 + 1.0 / 3.0_f64.sqrt());
    for potential in ["x^2 + x*abs(x)/2", "1/2*x^2 + 1/4*(x + abs(x))^2"] {
        let found = period(&format!("coord x  T = 1/2*x'^2  V = {potential}"), &amplitude("1"), 10);
        for own in [found.period, found.small.unwrap()] {
            assert!((own.mid_f64() - halves).abs() < 1e-14, "{potential}: {own:?}");
        }
    }
    // A kink beside the equilibrium, and one that is nowhere reached, change nothing of it.
    let shelf = period("coord x  T = 1/2*x'^2  V = 1/2*x^2 + abs(x - 5)  ", &amplitude("1"), 10);
    assert!(shelf.bend.is_some_and(|bend| bend.contains_zero()));
    assert!((shelf.period.mid_f64() - std::f64::consts::TAU).abs() < 1e-15);
    // Many digits, and an equilibrium at a kink that is no binary fraction.
    let far = period(
        "coord x  T = 1/2*x'^2  V = 1/2*(x - 1/10)^2 + abs(x - 1/10)^3  equilibrium x = 1/10",
        &amplitude("1/10"),
        40,
    );
    let near = period("coord x  T = 1/2*x'^2  V = 1/2*x^2 + abs(x)^3", &amplitude("1/10"), 40);
    let (far, near) = (far.precise.unwrap(), near.precise.unwrap());
    assert!((&far - &near).mid_f64().abs() < 1e-39 && near.radius().to_f64() < 1e-39);
    // Which piece a turning point lies in: right before and right behind a corner.
    for (own, want) in [("1 - 1e-12", std::f64::consts::TAU), ("1 + 1e-12", std::f64::consts::TAU)] {
        let stop = "coord x  T = 1/2*x'^2  V = 1/2*x^2 + 50*(abs(x - 1) + x - 1)^2";
        let found = period(stop, &amplitude(own), 10).period.mid_f64();
        assert!((found - want).abs() < 1e-5, "{own}: {found}");
    }
}

/// Integrals of dq/q' by mpmath with 40 digits, in the angle of x = A sin(angle).
#[test]
fn kinetic_energies_with_more_powers_of_the_velocity() {
    let relativistic = "param c = 2  coord x  T = -c^2*sqrt(1 - x'^2/c^2)";
    for (text, request, want) in [
        // A term that is linear in the velocity moves nothing.
        (format!("{relativistic} + 3/10*x*x'  V = 3/4*x^2"), amplitude("3"), "7.78900043025851513117872907803741"),
        // In a constant force the momentum is F t: 4 p/F with E = sqrt(c^4 + p^2 c^2).
        (format!("{relativistic}  V = 3*abs(x)"), amplitude("2"), "6.11010092660778667545072959163734"),
        (
            "coord x  T = 1/2*x'^2 + 1/4*x'^4  V = 1/2*x^2 + 1/4*x^4".to_owned(),
            amplitude("1"),
            "6.12568016051420088938851210415988",
        ),
        // Up for 2 v/g, in the floor for (pi + 2 atan(g/(omega v)))/omega.
        (
            "param g = 9.81, m = 0.5, k = 300  coord x  guess x = -0.01
             T = 1/2*m*x'^2  V = m*g*x + k/8*(abs(x) - x)^2"
                .to_owned(),
            energy("4.905"),
            "1.03866465754803286432376587246789",
        ),
    ] {
        for digits in [10, 30] {
            let found = period(&text, &request, digits);
            let want = Number::parse(want).unwrap();
            let precise = found.precise.clone().unwrap_or_else(|| Big::from_ball(&found.period, 160));
            let off = precise.sub(&Big::from_number(&want, 160));
            let bound = 10.0_f64.powi(1 - digits as i32).max(1e-31);
            assert!(off.mid_f64().abs() < bound && precise.to_ball().radius < bound, "{text}: {found:?}");
        }
    }
    // Slow motions are those of Newton, fast ones have the speed of light.
    let slow = period(&format!("{relativistic}  V = 1/2*x^2"), &amplitude("1e-6"), 10);
    assert!((slow.period.mid_f64() / (2.0 * std::f64::consts::PI) - 1.0 - 3.0 / 16.0 * 1e-12 / 4.0).abs() < 1e-15);
    assert!(slow.bend.is_none() && slow.small.is_some());
    let fast = period(&format!("{relativistic}  V = 1/2*x^2"), &amplitude("1e6"), 10);
    assert!((fast.period.mid_f64() / 2e6 - 1.0).abs() < 1e-5);
    // No function of the energy that is known, and rests that vary.
    for kinetic in ["1/2*x'^2 + 1/6*x'^6", "cosh(x')", "-(1 + x^2)*sqrt(1 - x'^2)", "1/2*x'^2 + x'^3"] {
        let file = syntax::parse(&format!("coord x  T = {kinetic}  V = 1/2*x^2")).unwrap();
        let model = elaborate(&file, &Default::default(), &Default::default()).unwrap();
        assert_eq!(Oscillator::of_model(&model).unwrap_err().code(), "E0503", "{kinetic}");
    }
}

/// All orbits of a box keep their energy.
fn portrait(text: &str, ranges: &str) -> Vec<librate_studies::period::Orbit> {
    let file = syntax::parse(text).unwrap();
    let model = elaborate(&file, &Default::default(), &Default::default()).unwrap();
    let region = librate::equilibria::Region::parse(ranges, &model).unwrap();
    let found = librate::equilibria::find(&model, &region).unwrap();
    librate_studies::period::portrait(&model, &found)
}

/// Of an energy that a saddle has, what goes to and fro elsewhere divides nothing: three wells, two saddles.
#[test]
fn separatrices_reach_a_saddle() {
    use librate_studies::period::Course;

    let text = "coord x  T = 1/2*x'^2  V = x^6/6 + 1/10*x^5 - 17/8*x^4 - 1/2*x^3 + 11/2*x^2 - x";
    let orbits = portrait(text, "x=-4..4");
    let separating: Vec<_> = orbits.iter().filter(|own| own.course == Course::Separatrix).collect();
    // The zeros of V' by numpy.
    let saddles = [-1.374_603_718, 1.123_326_911];
    assert!(!separating.is_empty());
    for own in separating {
        let places = || own.points.iter().map(|point| point[0]);
        let (from, to) = (places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max));
        assert!(saddles.iter().any(|saddle| (from - 0.01..=to + 0.01).contains(saddle)), "{from} to {to}");
    }
}

#[test]
fn phase_portraits_are_curves_of_constant_energy() {
    use librate_studies::period::Course;
    let orbits = portrait("param g = 2  coord q  T = 1/2*q'^2  V = g*(1 - cos(q))", "q=-4..10");
    let mut counts = [0; 3];
    for orbit in &orbits {
        counts[orbit.course as usize] += 1;
        let separates = (orbit.energy - 4.0).abs() < 1e-12;
        assert_eq!(orbit.course == Course::Separatrix, separates, "{}", orbit.energy);
        assert_eq!(orbit.course == Course::Bound, orbit.energy < 3.9, "{}", orbit.energy);
        for [q, v] in &orbit.points {
            assert!((0.5 * v * v + 2.0 * (1.0 - q.cos()) - orbit.energy).abs() < 1e-7 * 4.0, "{q} {v}");
        }
        // Through a saddle, at rest.
        let is_saddle = |q: f64| [-1.0, 1.0, 3.0].iter().any(|own| (q - own * std::f64::consts::PI).abs() < 1e-7);
        let rests = orbit.points.iter().any(|[q, v]| *v == 0.0 && is_saddle(*q));
        assert_eq!(rests, separates, "{}", orbit.energy);
        if orbit.course == Course::Bound {
            // Closed, up to turning points found by halving.
            let ends = [orbit.points[0], orbit.points[orbit.points.len() - 1]];
            assert!((ends[0][0] - ends[1][0]).abs() < 1e-12 && ends.iter().all(|[_, v]| v.abs() < 1e-4), "{ends:?}");
        }
    }
    // Four energies in each of two wells, four above and one between in either direction.
    assert_eq!(counts, [8, 8, 6]);
    // A shallow well beside a deep one has an orbit as well.
    let orbits = portrait("coord x  T = 1/2*x'^2  V = x^4/4 - x^2/2 + 3/8*x", "x=-2..2");
    let inside = |own: &librate_studies::period::Orbit| own.points.iter().all(|[x, _]| *x > 0.45);
    assert!(orbits.iter().any(|own| own.course == Course::Bound && inside(own)));
    // A mass that depends on the place; and a wall where V has no value.
    let orbits = portrait("coord r  T = 1/2*(1 + r^2)*r'^2  V = 1/r + r", "r=0..4");
    assert!(orbits.iter().any(|own| own.course == Course::Bound));
    for [r, v] in orbits.iter().flat_map(|own| own.points.iter().map(|point| (own.energy, point))).map(|(e, [r, v])| {
        assert!((0.5 * (1.0 + r * r) * v * v + 1.0 / r + r - e).abs() < 1e-6 * e, "{r} {v}");
        [*r, *v]
    }) {
        assert!(r > 0.0 && v.is_finite());
    }
    // Energy is lost: there is none.
    assert!(portrait("coord q  T = 1/2*q'^2  V = q^2/2  dissipation = q'^2", "q=-1..1").is_empty());
}

/// An angle jumps by 2 pi where its point crosses the negative axis, and so does an energy or an inertia that has it.
#[test]
fn jumps_of_angles_are_told() {
    for (text, from) in [
        ("coord x  T = 1/2*x'^2  V = 1/2*x^2 + 1/10*atan2(x - 1, -1)", "2"),
        ("coord x  T = 1/2*(1 + 1/10*atan2(sin(x), cos(x)))*x'^2  V = 1/2*x^2", "4"),
    ] {
        let error = oscillator(text).period(&amplitude(from), &Options::default()).unwrap_err();
        assert!(matches!(error, librate::period::PeriodError::NotSmooth { .. }), "{text}: {error}");
    }
}
