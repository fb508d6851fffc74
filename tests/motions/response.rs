//! Steady responses against references of 40 digits that were computed by other means (tests/reference/response.py), closed forms of
//! textbooks, and plain elimination with 60 digits for random models.
#![cfg(feature = "engine")]

use faer::c64;
use librate::Source;
use librate::model::{Range, Settings, TableTexts, elaborate};
use librate::number::Number;
use librate::precision::{Ball, Big, Scalar};
use librate::response::{Request, Response, ResponseError, Study, Value};
use librate::syntax;
use librate_core::modes::{SparseQuadratic, SparseResponse};
use librate_core::precision::{Complex, Rounding, SparseMatrix, decimal, push_decimal};
use proptest::prelude::*;

/// What a model responds to a force on a coordinate, or to its own drive.
fn study(text: &str, settings: &[String], input: Option<&str>, over: &str) -> Result<Study, ResponseError> {
    let file = syntax::parse(text).unwrap();
    let mut all = Settings::new();
    settings.iter().for_each(|setting| all.add(setting).unwrap());
    let tables = TableTexts::new();
    let model = elaborate(&file, &tables, &all).unwrap();
    let range = Range::parse(over).unwrap();
    let request = Request { input: input.map(str::to_owned), outputs: Vec::new(), range, digits: 10 };
    Study::new(model, Source { file, tables, settings: all }, request)
}

fn response(text: &str, input: Option<&str>, over: &str) -> Response {
    let study = study(text, &[], input, over).unwrap();
    study.response((0..study.len()).map(|place| study.values(place).unwrap()))
}

fn known(value: &Value) -> (Ball, Option<Ball>) {
    match value {
        Value::Known { amplitude, phase } => (*amplitude, *phase),
        other => panic!("{other:?}"),
    }
}

fn number(text: &str) -> Number {
    match text.strip_prefix('-') {
        Some(rest) => Number::parse(rest).unwrap().neg(),
        None => Number::parse(text).unwrap(),
    }
}

/// That a number of 40 digits is in a ball that decides ten.
fn check(what: &str, found: &Ball, text: &str) {
    let own = Ball::from_number(&number(text), ());
    let off = *found - own;
    let rounding = 1e-30 * own.mid_f64().abs();
    assert!(off.mid_f64().abs() <= found.radius + rounding, "{what}: {found:?} is not {text}");
    assert!(found.radius <= 1e-12 * own.mid_f64().abs(), "{what}: {found:?}");
}

#[test]
fn models_respond_as_their_references_say() {
    let text = std::fs::read_to_string("tests/reference/response.json").unwrap();
    let all: serde_json::Value = serde_json::from_str(&text).unwrap();
    let mut checked = 0;
    for entry in all.as_array().unwrap() {
        let name = entry["model"].as_str().unwrap();
        let text = std::fs::read_to_string(format!("models/response/{name}.lag")).unwrap();
        let settings = entry["settings"].as_array().unwrap().iter();
        let settings: Vec<String> = settings.map(|own| own.as_str().unwrap().to_owned()).collect();
        let study = study(&text, &settings, entry["input"].as_str(), entry["over"].as_str().unwrap()).unwrap();
        let found = study.response((0..study.len()).map(|place| study.values(place).unwrap()));
        for (at, end) in entry["ends"].as_array().unwrap().iter().enumerate() {
            let end = end.as_object().unwrap();
            assert_eq!(found.outputs.len(), end.len(), "{name}");
            for output in &found.outputs {
                let what = format!("{name} {} {}", entry["over"], output.coordinate);
                let (amplitude, phase) = known(&output.values[at]);
                let own = &end[&output.coordinate];
                let [own, angle] = [0, 1].map(|part| own[part].as_str().unwrap());
                if number(own).is_zero() {
                    assert!(amplitude.is_zero() && phase.is_none(), "{what}");
                } else {
                    check(&what, &amplitude, own);
                    check(&what, &phase.unwrap(), angle);
                }
                checked += 1;
            }
        }
    }
    assert!(checked > 60);
}

/// At the fixed points of an absorber the amplitude does not depend on the damping (Den Hartog, Mechanical Vibrations, §3.3).
#[test]
fn absorbers_have_two_fixed_points() {
    let text = std::fs::read_to_string("models/response/damped_absorber.lag").unwrap();
    // g² of both: (1 ± sqrt(mu/(2 + mu)))/(1 + mu), with mu = 1/20.
    let over = "omega=sqrt(100*(1 - sqrt(1/41))*20/21)..sqrt(100*(1 + sqrt(1/41))*20/21):2";
    let amplitude = |damping: &str| -> Vec<Ball> {
        let study = study(&text, &[format!("c={damping}")], Some("x1"), over).unwrap();
        (0..2).map(|place| known(&study.values(place).unwrap()[0]).0).collect()
    };
    let exact = Ball::exact(41.0).sqrt() / Ball::exact(2000.0);
    for damping in ["1/10", "2", "17"] {
        for found in amplitude(damping) {
            assert!((found - exact).contains_zero() && found.radius < 1e-16, "{found:?}");
        }
    }
}

#[test]
fn transmissibility_is_one_at_one_frequency_for_any_damping() {
    let text = std::fs::read_to_string("models/response/shaken_base.lag").unwrap();
    for damping in ["c=1", "c=30"] {
        let study = study(&text, &[damping.to_owned()], None, "W=sqrt(800)..sqrt(800):1").unwrap();
        let (amplitude, phase) = known(&study.values(0).unwrap()[0]);
        check(damping, &amplitude, "0.01");
        assert!(phase.unwrap().is_negative());
    }
}

#[test]
fn a_damped_oscillator_lags_by_a_quarter_at_resonance() {
    let text = "coord x  T = 1/2*x'^2  V = 2*x^2  dissipation = 1/20*x'^2";
    let found = response(text, Some("x"), "omega=0..4:3");
    let (amplitude, phase) = known(&found.outputs[0].values[1]);
    check("amplitude", &amplitude, "5");
    check("phase", &phase.unwrap(), "-1.570796326794896619231321691639751442099");
    let (amplitude, phase) = known(&found.outputs[0].values[0]);
    assert!(amplitude.mid_f64() == 0.25 && phase.unwrap().is_zero());
}

#[test]
fn undamped_resonances_are_infinite_where_they_are_excited() {
    let text = std::fs::read_to_string("models/response/two_masses_driven.lag").unwrap();
    // omega² = 4 and 12: the second one is no rational number.
    for over in ["omega=2..2:1", "omega=sqrt(12)..sqrt(12):1"] {
        let found = response(&text, Some("x[1]"), over);
        assert!(found.outputs.iter().all(|output| output.values == [Value::Infinite]), "{over}: {found:?}");
    }
    let found = response(&text, Some("x[1]"), "omega=0..4:1001");
    let infinite: Vec<usize> = (0..1001).filter(|at| found.outputs[0].values[*at] == Value::Infinite).collect();
    assert_eq!(infinite, [500]);
    assert!(found.outputs.iter().all(|output| !output.values.contains(&Value::Undecided)));
    // Next to a resonance a response is large.
    let near = response(&text, Some("x[1]"), "omega=2 - 1e-25..3:2");
    let (amplitude, _) = known(&near.outputs[0].values[0]);
    check("near", &amplitude, "1250000000000000000000000.09375");
}

/// A force on three equal masses in the middle does not excite the mode in which the middle one rests.
#[test]
fn modes_that_a_force_is_orthogonal_to_are_no_resonances() {
    let text = "coord x[1..3]  T = sum(i in 1..3, 1/2*x[i]'^2)
        V = 1/2*(x[1]^2 + (x[2] - x[1])^2 + (x[3] - x[2])^2 + x[3]^2)";
    let found = response(text, Some("x[2]"), "omega=sqrt(2)..sqrt(2):1");
    // (K - 2M) x = e_2: x = (-1, 0, -1) with x_1 + x_3 = -1: by symmetry -1/2 each.
    let values: Vec<Value> = found.outputs.iter().map(|output| output.values[0]).collect();
    let (first, phase) = known(&values[0]);
    check("first", &first, "0.5");
    check("phase", &phase.unwrap(), "3.141592653589793238462643383279502884197");
    assert!(known(&values[1]).0.is_zero() && values[0] == values[2]);
    // A force on the first one does, and the middle one does not take part: its limit is finite.
    let found = response(text, Some("x[1]"), "omega=sqrt(2)..sqrt(2):1");
    assert_eq!(found.outputs[0].values, [Value::Infinite]);
    check("middle", &known(&found.outputs[1].values[0]).0, "0.5");
}

/// Two wheels and a skate, of which two conditions can be integrated: 3 p'' = f for each wheel, and x is where both have been.
#[test]
fn conditions_of_both_kinds() {
    let text = "coord x, y, psi, pl, pr  T = 1/2*(x'^2 + y'^2 + psi'^2 + pl'^2 + pr'^2)
        constraint -x'*sin(psi) + y'*cos(psi) = 0  constraint x'*cos(psi) + y'*sin(psi) = pl' + pr'
        constraint psi' = pr' - pl'";
    let found = response(text, Some("x"), "omega=1/2..1:2");
    let amplitude = |coordinate: usize| known(&found.outputs[coordinate].values[0]).0;
    check("x", &amplitude(0), "2.666666666666666666666666666666666666666667");
    check("pl", &amplitude(3), "1.333333333333333333333333333333333333333333");
    assert!(amplitude(1).is_zero());
}

#[test]
fn rigid_motions_have_no_static_response() {
    let text = "coord x, y  T = 1/2*x'^2 + 3/2*y'^2  V = 2*(x - y)^2";
    let found = response(text, Some("x"), "omega=0..1:2");
    assert!(found.outputs.iter().all(|output| output.values[0] == Value::Infinite));
    let (amplitude, _) = known(&found.outputs[0].values[1]);
    // x = (k - m2)/((k - 1)(k - m2) - k²) with k = 4, m2 = 3.
    check("x", &amplitude, "0.07692307692307692307692307692307692307692");
    // A spring between neighbours: forces that cancel leave the centre where it is.
    let relative = "coord u, s  T = 1/2*(s' + u')^2 + 1/2*(s' - u')^2  V = 8*u^2";
    let found = response(relative, Some("u"), "omega=0..1:2");
    check("u", &known(&found.outputs[0].values[0]).0, "0.0625");
    assert!(known(&found.outputs[1].values[0]).0.is_zero());
}

/// A force on a joint without mass moves it, though the joint follows the masses otherwise.
#[test]
fn massless_coordinates_respond_to_forces_on_them() {
    let text = "coord x, y  T = 1/2*x'^2  V = 1/2*(2*(x - y)^2 + 3*y^2)";
    let found = response(text, Some("y"), "omega=2..3:2");
    // (2 - w²) x - 2 y = 0, -2 x + 5 y = 1.
    check("x", &known(&found.outputs[0].values[0]).0, "0.1428571428571428571428571428571428571429");
    check("y", &known(&found.outputs[1].values[0]).0, "0.1428571428571428571428571428571428571429");
    // With a damper in place of the spring to the wall, y is of first order.
    let text = "coord x, y  T = 1/2*x'^2  V = (x - y)^2  dissipation = 3/2*y'^2";
    let found = response(text, Some("y"), "omega=1..2:2");
    // x (2 - 1) = 2 y, 2 y - 2 x + 3 i y = 1: y = 1/(-2 + 3 i).
    check("y", &known(&found.outputs[1].values[0]).0, "0.2773500981126145610091708667284996881732");
}

/// Rotation without friction: what is pushed moves in phase with the force or against it, whatever its stiffness.
#[test]
fn a_point_in_a_turning_frame_moves_in_phase() {
    let text = "coord x, y
        lagrangian = 1/2*(x'^2 + y'^2) + x*y' - 1/2*(2*x^2 + 3*y^2) - sqrt(2)/10*x*y";
    let found = response(text, Some("x"), "omega=0.5..2:4");
    for (value, omega) in found.outputs[0].values.iter().zip([0.5_f64, 1.0, 1.5, 2.0]) {
        // (2 - w²) x + (√2/10 - i w) y = 1, (√2/10 + i w) x + (3 - w²) y = 0.
        let square = omega * omega;
        let want = (3.0 - square) / ((2.0 - square) * (3.0 - square) - 0.02 - square);
        let (amplitude, phase) = known(value);
        assert!((amplitude.mid_f64() - want.abs()).abs() < 1e-12 * want.abs(), "{omega}: {amplitude:?}, {want}");
        let against = if want < 0.0 { std::f64::consts::PI } else { 0.0 };
        assert!((phase.unwrap().mid_f64() - against).abs() < 1e-15, "{omega}: {phase:?}");
    }
}

#[test]
fn drives_are_found_wherever_they_are_written() {
    let support = "param W = 1  param a = 1/10  coord phi
        let x = a*cos(W*t) + sin(phi)  T = 1/2*(x'^2 + cos(phi)'^2)  V = -10*cos(phi)";
    let force = "param W = 1  param a = 1/10  coord phi
        T = 1/2*phi'^2  V = 5*phi^2  force phi = a*W^2*cos(W*t)";
    let relative = "param W = 1  param a = 1/10  coord phi
        lagrangian = 1/2*phi'^2 - 5*phi^2 + a*W^2*cos(W*t)*phi";
    for text in [support, force, relative] {
        let found = response(text, None, "W=0..2:3");
        assert_eq!(found.name, "W");
        let values: Vec<Ball> = found.outputs[0].values.iter().map(|value| known(value).0).collect();
        assert!(values[0].is_zero());
        check("at 1", &values[1], "0.01111111111111111111111111111111111111111");
        check("at 2", &values[2], "0.06666666666666666666666666666666666666667");
    }
    // A phase, a frequency in turns, and an equilibrium that the weight moves.
    let text = "param f = 1  coord x  T = 1/2*x'^2  V = 2*x^2 + 9*x  force x = sin(2*pi*f*t + pi/6)";
    let found = response(text, None, "f=1..2:2");
    let (amplitude, phase) = known(&found.outputs[0].values[0]);
    // 1/(4 pi² - 4), and -sin lags by pi/2 behind -cos: pi - pi/2 + pi/6 = 2 pi/3.
    check("amplitude", &amplitude, "0.02818614998987950066597818778482005466021");
    check("phase", &phase.unwrap(), "2.094395102393195492308428922186335256131");
}

/// A drive of twice the angle that is written: cos² = 1/2 + cos(2 W t)/2, sin cos = sin(2 W t)/2.
#[test]
fn products_of_sines_are_the_second_harmonic() {
    for force in ["cos(W*t)^2", "sin(W*t)*cos(W*t)"] {
        let found =
            response(&format!("param W = 1  coord x  T = 1/2*x'^2  V = x^2  force x = {force}"), None, "W=1..2:2");
        check("at 1", &known(&found.outputs[0].values[0]).0, "0.25");
        check("at 2", &known(&found.outputs[0].values[1]).0, "0.03571428571428571428571428571428571428571");
    }
}

/// |cos| is cos or -cos in between, and no multiple of either.
#[test]
fn rectified_drives_are_not_harmonic() {
    for drive in [
        "force x = abs(cos(W*t))",
        "force x = (cos(W*t) + abs(cos(W*t)))/2",
        "force x = sqrt(cos(W*t)^2)",
        "force x = (cos(W*t)^4)^(1/4)",
        "force x = abs(cos(W*t))*cos(W*t)",
        "force x = sin(acos(cos(W*t)))",
        "force x = cos(W*t^2)",
    ] {
        let text = format!("param W = 1  coord x  T = 1/2*x'^2  V = x^2  {drive}");
        let found = study(&text, &[], None, "W=1..2:2");
        assert!(matches!(found, Err(ResponseError::NotHarmonic { .. })), "{drive}");
    }
}

/// A shaft's disc in a frame that turns with the drive: the matrices change with the parameter.
#[test]
fn matrices_may_depend_on_the_frequency_of_the_drive() {
    let text = "param W = 1  coord x  T = 1/2*x'^2 + 1/2*W^2*x^2  V = 5*x^2  force x = W*cos(W*t)";
    let found = response(text, None, "W=1..2:2");
    // W/(10 - 2 W²).
    check("at 1", &known(&found.outputs[0].values[0]).0, "0.125");
    check("at 2", &known(&found.outputs[0].values[1]).0, "1");
}

#[test]
fn what_is_no_response_is_refused() {
    let plain = "coord x, y  T = 1/2*x'^2 + 1/2*y'^2  V = x^2 + y^2";
    let driven = "param W = 1  param k = 4  coord x  T = 1/2*x'^2  V = 1/2*k*x^2 - x*cos(W*t)";
    let cases = [
        (plain, Some("z"), "omega=0..1:2", "E1101"),
        (plain, None, "W=0..1:2", "E1102"),
        (driven, Some("x"), "omega=0..1:2", "E1103"),
        (driven, None, "k=0..1:2", "E1104"),
        ("param W = 1  coord x  T = 1/2*x'^2  V = x^2 - x*cos(W*t)^3", None, "W=0..1:2", "E1105"),
        ("param W = 1  coord x  T = 1/2*x'^2  V = x^2 - x*t*cos(W*t)", None, "W=0..1:2", "E1105"),
        ("param W = 1  coord x  T = 1/2*x'^2  V = x^2 - x*cos(W*t) - x*cos(3*t)", None, "W=0..1:2", "E1105"),
        ("param W = 1  coord x  T = 1/2*x'^2  V = x^2*(2 - cos(W*t))", None, "W=0..1:2", "E1106"),
        (plain, Some("x"), "omega=-1..1:2", "E1108"),
    ];
    for (text, input, over, code) in cases {
        assert_eq!(study(text, &[], input, over).err().map(|error| error.code()), Some(code), "{text}");
    }
}

/// sin(N θ)/((k + iωc) sin((N + 1) θ)) with 2 (k + iωc)(1 - cos θ) = ω²m.
#[test]
fn long_chains_respond_as_their_closed_form_says() {
    let text = std::fs::read_to_string("models/response/driven_chain.lag").unwrap();
    let n = 5000;
    let study = study(&text, &[format!("N={n}")], Some("x[1]"), "omega=1/2..19:6").unwrap();
    for place in 0..6 {
        let omega = study.place(place);
        let spring = c64::new(100.0, 0.5 * omega);
        let angle = (c64::new(1.0, 0.0) - c64::new(0.5 * omega * omega, 0.0) / spring).acos();
        // By powers of the smaller of e^(±iθ).
        let z = (angle * c64::new(0.0, 1.0)).exp();
        let z = if z.norm() > 1.0 { z.inv() } else { z };
        let one = c64::new(1.0, 0.0);
        let exact = z * (one - z.powu(2 * n)) / (one - z.powu(2 * n + 2)) / spring;
        let (amplitude, phase) = known(&study.values(place).unwrap()[0]);
        assert!((amplitude.mid_f64() / exact.norm() - 1.0).abs() < 1e-10, "{omega}");
        assert!((phase.unwrap().mid_f64() - exact.arg()).abs() < 1e-9, "{omega}");
    }
}

/// What the mass in row 7 and column 5 of a square membrane does when that in row 3 and column 4 is pushed: a sum over all modes.
fn membrane(n: usize, omega: f64, friction: f64) -> c64 {
    let angle = |k: usize| std::f64::consts::PI * k as f64 / (n + 1) as f64;
    let mut sum = c64::new(0.0, 0.0);
    for (k, l) in (1..=n).flat_map(|k| (1..=n).map(move |l| (angle(k), angle(l)))) {
        let shape = |[i, j]: [f64; 2]| 2.0 / (n + 1) as f64 * (k * i).sin() * (l * j).sin();
        let square = 4.0 - 2.0 * k.cos() - 2.0 * l.cos();
        sum += shape([3.0, 4.0]) * shape([7.0, 5.0]) / c64::new(square - omega * omega, friction * omega);
    }
    sum
}

/// A square membrane in oil by the sum over its modes, which are products of sines.
#[test]
fn membranes_respond_as_their_modes_say() {
    let n = 20_usize;
    let text = format!(
        "coord z[1..{n}, 1..{n}]  T = sum(i in 1..{n}, j in 1..{n}, 1/2*z[i,j]'^2)
        let u[0, j in 1..{n}] = 0  let u[{n} + 1, j in 1..{n}] = 0  let u[i in 1..{n}, j in 1..{n}] = z[i,j]
        let v[i in 1..{n}, 0] = 0  let v[i in 1..{n}, {n} + 1] = 0  let v[i in 1..{n}, j in 1..{n}] = z[i,j]
        V = sum(i in 0..{n}, j in 1..{n}, 1/2*(u[i+1,j] - u[i,j])^2) + sum(i in 1..{n}, j in 0..{n}, 1/2*(v[i,j+1] - v[i,j])^2)
        dissipation = sum(i in 1..{n}, j in 1..{n}, 1/40*z[i,j]'^2)"
    );
    let study = study(&text, &[], Some("z[3,4]"), "omega=1/3..5/2:4").unwrap();
    for place in 0..4 {
        let omega = study.place(place);
        let exact = membrane(n, omega, 0.05);
        let (amplitude, phase) = known(&study.values(place).unwrap()[n * 6 + 4]);
        assert!((amplitude.mid_f64() / exact.norm() - 1.0).abs() < 1e-11, "{omega}: {amplitude:?} {exact}");
        assert!((phase.unwrap().mid_f64() - exact.arg()).abs() < 1e-11, "{omega}");
    }
}

/// The same without friction, where nothing but counts of eigenvalues tells how near a resonance is; and all the digits there are.
#[test]
fn membranes_without_friction_respond_in_phase() {
    let n = 24_usize;
    let text = format!(
        "coord z[1..{n}, 1..{n}]  T = sum(i in 1..{n}, j in 1..{n}, 1/2*z[i,j]'^2)
        V = sum(i in 1..{n}, j in 1..{n}, 2*z[i,j]^2) - sum(i in 1..{n}-1, j in 1..{n}, z[i+1,j]*z[i,j])
          - sum(i in 1..{n}, j in 1..{n}-1, z[i,j+1]*z[i,j])"
    );
    let study = study(&text, &[], Some("z[3,4]"), "omega=1/3..5/2:4").unwrap();
    for place in 0..4 {
        let omega = study.place(place);
        let exact = membrane(n, omega, 0.0).re;
        let (amplitude, phase) = known(&study.values(place).unwrap()[n * 6 + 4]);
        assert!((amplitude.mid_f64() / exact.abs() - 1.0).abs() < 1e-10, "{omega}: {amplitude:?} {exact}");
        let expected = if exact > 0.0 { Ball::ZERO } else { Ball::PI };
        assert!((phase.unwrap() - expected).contains_zero());
    }
}

/// Gauss elimination with row exchanges, in numbers of many bits.
fn plainly(mut rows: Vec<Vec<Complex<Big>>>) -> Vec<Complex<Big>> {
    let n = rows.len();
    for k in 0..n {
        let size = |row: &Vec<Complex<Big>>| row[k].square_of_modulus().mid_f64();
        let pivot = (k..n).max_by(|a, b| size(&rows[*a]).total_cmp(&size(&rows[*b]))).unwrap();
        rows.swap(k, pivot);
        let own = rows[k].clone();
        for row in (0..n).filter(|row| *row != k) {
            let factor = rows[row][k].div(&own[k]);
            for (entry, own) in rows[row].iter_mut().zip(&own) {
                *entry = entry.sub(&factor.mul(own));
            }
        }
    }
    (0..n).map(|k| rows[k][n].div(&rows[k][k])).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn random_damped_models_respond_as_plain_elimination_says(
        order in 1_usize..6,
        entries in prop::collection::vec(-9_i64..10, 75),
        omega in 1_i64..60,
        input in 0_usize..6,
    ) {
        let input = input % order;
        // Bᵀ B + 1 is positive definite.
        let product = |part: usize, i: usize, j: usize| -> i64 {
            let entry = |k: usize, i: usize| entries[25 * part + 5 * k + i];
            (0..order).map(|k| entry(k, i) * entry(k, j)).sum::<i64>() + i64::from(i == j)
        };
        let sum = |part: usize, prime: &str| -> String {
            let pairs = (0..order).flat_map(|i| (0..order).map(move |j| (i, j)));
            let terms = pairs.map(|(i, j)| {
                format!("({})*x[{}]{prime}*x[{}]{prime}", product(part, i, j), i + 1, j + 1)
            });
            terms.collect::<Vec<_>>().join(" + ")
        };
        let text = format!(
            "coord x[1..{order}]  T = 1/2*({})  V = 5*({})  dissipation = 1/20*({})",
            sum(0, "'"), sum(1, ""), sum(2, "'"),
        );
        let study = study(&text, &[], Some(&format!("x[{}]", input + 1)), &format!("omega={omega}/7..100:2")).unwrap();
        let found = [study.values(0).unwrap(), study.in_doubles(0..1).remove(0).unwrap()];
        let bits = 256;
        let big = |top: i64, bottom: i64| Big::from_number(&Number::ratio(top, bottom).unwrap(), bits);
        let w = big(omega, 7);
        let rows = (0..order).map(|i| {
            let own = (0..order).map(|j| {
                let [mass, stiffness, damping] = [0, 1, 2].map(|part| product(part, i, j));
                let re = big(10 * stiffness, 1).sub(&w.mul(&w).mul(&big(mass, 1)));
                Complex::new(re, w.mul(&big(damping, 10)))
            });
            let right = Complex::new(big(i64::from(i == input), 1), big(0, 1));
            own.chain([right]).collect()
        });
        let exact = plainly(rows.collect());
        for (value, exact) in found.iter().flat_map(|values| values.iter().zip(&exact)) {
            let (amplitude, phase) = known(value);
            let modulus = exact.square_of_modulus().sqrt().to_ball();
            prop_assert!((amplitude - modulus).contains_zero(), "{text}: {amplitude:?} {modulus:?}");
            let angle = exact.im.atan2(&exact.re).to_ball();
            prop_assert!((phase.unwrap() - angle).contains_zero(), "{text}: {phase:?} {angle:?}");
        }
    }

    /// Sparse decompositions with one bound for all, for any D and S.
    #[test]
    fn random_sparse_systems_respond_as_plain_elimination_says(
        order in 2_usize..14,
        entries in prop::collection::vec((0_usize..14, 0_usize..14, -9_i64..10, 0_u8..4), 1..60),
        top in 0_i64..60,
        input in 0_usize..14,
    ) {
        let input = input % order;
        let mut whole = [0, 1].map(|_| vec![vec![0_i64; order]; order]);
        // Springs, dampers and gyroscopic couplings between two, and what is none of these.
        for (i, j, value, kind) in entries {
            let (i, j) = (i % order, j % order);
            let [damping, stiffness] = &mut whole;
            let matrix = if kind % 2 == 0 { damping } else { stiffness };
            match kind {
                0 => { matrix[i][j] += value; matrix[j][i] -= value; }
                3 => matrix[i][j] += value,
                _ => {
                    matrix[i][i] += value.abs(); matrix[j][j] += value.abs();
                    matrix[i][j] -= value.abs(); matrix[j][i] -= value.abs();
                }
            }
        }
        let mass = |i: usize, j: usize| if i == j { 3 + i as i64 } else { i64::from(i.abs_diff(j) == 1) };
        let sparse = |entry: &dyn Fn(usize, usize) -> i64, lower: bool| {
            let all = (0..order).flat_map(|i| (0..order).map(move |j| (i, j))).filter(|(i, j)| !lower || i >= j);
            let shares = all.map(|(i, j)| (i as u32, j as u32, Ball::exact(entry(i, j) as f64)));
            SparseMatrix::from_shares(order, &shares.filter(|own| !own.2.is_zero()).collect::<Vec<_>>())
        };
        let problem = SparseQuadratic {
            mass: sparse(&mass, true),
            velocity: sparse(&|i, j| whole[0][i][j], false),
            stiffness: sparse(&|i, j| whole[1][i][j] + i64::from(i == j), false),
            undamped: false,
            symmetric: false,
            passive: false,
        };
        let bits = 256;
        let big = |top: i64, bottom: i64| Big::from_number(&Number::ratio(top, bottom).unwrap(), bits);
        let w = big(top, 7);
        let rows = (0..order).map(|i| {
            let own = (0..order).map(|j| {
                let re = big(whole[1][i][j] + i64::from(i == j), 1).sub(&w.mul(&w).mul(&big(mass(i, j), 1)));
                Complex::new(re, w.mul(&big(whole[0][i][j], 1)))
            });
            own.chain([Complex::new(big(i64::from(i == input), 1), big(0, 1))]).collect()
        });
        let exact = plainly(rows.collect());
        let omega = Ball::from_number(&Number::ratio(top, 7).unwrap(), ());
        let found = SparseResponse::new(&problem).unwrap().at(&omega, &[(input, Complex::real(1.0, ()))]);
        let most = exact.iter().map(|own| own.square_of_modulus().mid_f64()).fold(0.0, f64::max).sqrt();
        // Without an answer only where A is nearly singular.
        prop_assert!(found.is_some() || most.is_nan() || most > 1e8, "{most}");
        for (own, exact) in found.iter().flatten().zip(&exact) {
            for (own, exact) in [(own.re, &exact.re), (own.im, &exact.im)] {
                prop_assert!((own - exact.to_ball()).contains_zero(), "{own:?} {exact:?}");
                prop_assert!(own.radius < 1e-18 * most.max(1.0), "{own:?} {most}");
            }
        }
    }

    /// In doubles, against the same in double-double: chains with springs and dampers to the walls and to the two next neighbours.
    #[test]
    fn random_banded_models_respond_alike_in_doubles(
        order in 3_usize..30,
        springs in prop::collection::vec(1_i64..100, 60),
        dampers in prop::collection::vec(0_i64..5, 60),
        top in 1_i64..50,
    ) {
        let sum = |factors: &[i64], prime: &str| -> String {
            let near = (1..order).map(|i| format!("{}*(x[{}]{prime} - x[{i}]{prime})^2", factors[i], i + 1));
            let far = (1..order - 1).map(|i| format!("{}*(x[{}]{prime} - x[{i}]{prime})^2", factors[30 + i], i + 2));
            let wall = std::iter::once(format!("{}*x[1]{prime}^2", factors[0]));
            near.chain(far).chain(wall).collect::<Vec<_>>().join(" + ")
        };
        let text = format!(
            "coord x[1..{order}]  T = 1/2*sum(i in 1..{order}, x[i]'^2)  V = {}  dissipation = 1/50*({})",
            sum(&springs, ""), sum(&dampers, "'"),
        );
        let study = study(&text, &[], Some("x[2]"), &format!("omega=1/3..{top}:21")).unwrap();
        let quick = study.in_doubles(0..21);
        prop_assert!(quick.iter().flatten().count() >= 15, "{text}");
        for (place, own) in quick.iter().enumerate() {
            for (own, value) in own.iter().flatten().zip(study.values(place).unwrap()) {
                let [(a, phase), (b, angle)] = [known(own), known(&value)];
                prop_assert!((a - b).contains_zero() && a.radius < 1e-13 * a.mid_f64(), "{text}: {a:?} {b:?}");
                prop_assert!((phase.unwrap() - angle.unwrap()).contains_zero(), "{text}: {phase:?} {angle:?}");
            }
        }
    }

    #[test]
    fn quick_digits_are_those_of_all(x in any::<f64>(), shift in -60_i32..60, digits in 1_usize..16, error in 0.0..1e-12) {
        // Of all sizes, and those that are near to printed numbers.
        for mid in [x, (x.to_bits() as f64 / 1e4).round() * 10_f64.powi(shift), (x % 1e3).round() + 0.5, 10_f64.powi(shift)] {
            let ball = Ball::exact(mid).with_added_radius(error * mid.abs());
            let mut text = Vec::new();
            if ball.is_finite() && push_decimal(&mut text, &ball, digits) {
                let all = decimal(&ball, digits);
                prop_assert_eq!(String::from_utf8(text).unwrap(), all.text);
                prop_assert_eq!(all.rounding, Rounding::Correct);
            }
        }
    }
}
