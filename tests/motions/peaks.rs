//! Maxima and minima of steady responses: closed forms of textbooks, and of random models nothing that samples of the response show is missed.
#![cfg(feature = "engine")]

use librate::Source;
use librate::model::{Range, Settings, TableTexts, elaborate};
use librate::precision::Ball;
use librate::response::{PeakKind, Peaks, Request, Study};
use librate::syntax;
use librate_studies::response::Peak;
use proptest::prelude::*;

fn study(text: &str, input: Option<&str>, over: &str) -> Study {
    let file = syntax::parse(text).unwrap();
    let (tables, settings) = (TableTexts::new(), Settings::new());
    let model = elaborate(&file, &tables, &settings).unwrap();
    let range = Range::parse_ends(over).unwrap();
    let request = Request { input: input.map(str::to_owned), outputs: Vec::new(), range, digits: 10 };
    Study::new(model, Source { file, tables, settings }, request).unwrap()
}

fn peaks(text: &str, input: Option<&str>, over: &str) -> Vec<Peaks> {
    let study = study(text, input, over);
    (0..study.outputs()).map(|output| study.peaks(output).unwrap()).collect()
}

fn of(kind: PeakKind, all: &Peaks) -> Vec<Ball> {
    all.found.iter().filter(|own| own.kind == kind).map(|own| own.place).collect()
}

/// That a narrow ball holds a number that is known to some 16 digits.
fn is(found: &Ball, exact: f64) {
    let off = (found.mid_f64() - exact).abs();
    assert!(off <= 4e-16 * exact.abs() && found.radius <= 1e-15 * exact.abs(), "{found:?} is not {exact}");
}

/// Of m x'' + c x' + k x = cos(omega t): omega² = w²(1 - 2z²), the amplitude 1/(2 k z sqrt(1 - z²)), half of its square at w²(1 - 2z² ± 2z sqrt(1 - z²));
/// French, Vibrations and Waves, chapter 4.
#[test]
fn a_damped_oscillator_has_one_maximum() {
    let text = "coord x  T = 1/2*x'^2  V = 1/2*100*x^2  dissipation = 1/2*2*x'^2";
    for over in ["omega=0..30", "omega=30..0"] {
        let [found] = &peaks(text, Some("x"), over)[..] else { panic!() };
        let [
            Peak {
                kind: PeakKind::Maximum, place, amplitude: Some(amplitude), half_power: [Some(from), Some(to)], ..
            },
        ] = &found.found[..]
        else {
            panic!("{found:?}")
        };
        let z: f64 = 0.1;
        let root = 2.0 * z * (1.0 - z * z).sqrt();
        is(place, 10.0 * (1.0 - 2.0 * z * z).sqrt());
        is(amplitude, 0.01 / root);
        is(from, 10.0 * (1.0 - 2.0 * z * z - root).sqrt());
        is(to, 10.0 * (1.0 - 2.0 * z * z + root).sqrt());
        assert!(found.undecided.is_empty());
    }
}

/// Without an interior maximum from critical damping/√2 on.
#[test]
fn a_heavily_damped_oscillator_has_none() {
    let text = "coord x  T = 1/2*x'^2  V = 1/2*100*x^2  dissipation = 1/2*15*x'^2";
    let [found] = &peaks(text, Some("x"), "omega=0..30")[..] else { panic!() };
    assert!(found.found.is_empty() && found.undecided.is_empty(), "{found:?}");
}

/// Of a shaken base: (omega/w)² = (sqrt(1 + 8 z²) - 1)/(4 z²), Rao, Mechanical Vibrations, §3.6.
#[test]
fn transmissibility_has_its_maximum_below_the_normal_frequency() {
    let text = std::fs::read_to_string("models/response/shaken_base.lag").unwrap();
    let [found] = &peaks(&text, None, "W=1..60")[..] else { panic!() };
    let [maximum] = of(PeakKind::Maximum, found)[..] else { panic!("{found:?}") };
    let z: f64 = 0.1;
    is(&maximum, 20.0 * (2.0 / ((1.0 + 8.0 * z * z).sqrt() + 1.0)).sqrt());
}

/// A chain between walls that is driven at its end resonates at 2 sin(k pi/(2(n + 1))); its first mass rests at the frequencies of the chain without it.
#[test]
fn chains_have_resonances_and_antiresonances_in_turn() {
    let text = "coord x[1..12]  T = sum(i in 1..12, 1/2*x[i]'^2)
        V = 1/2*(x[1]^2 + sum(i in 1..11, (x[i+1] - x[i])^2) + x[12]^2)";
    let found = peaks(text, Some("x[1]"), "omega=0..3");
    let sine = |k: usize, n: usize| 2.0 * (std::f64::consts::PI * k as f64 / (2.0 * n as f64)).sin();
    for own in &found {
        let resonances = of(PeakKind::Resonance, own);
        assert_eq!(resonances.len(), 12);
        resonances.iter().enumerate().for_each(|(k, place)| is(place, sine(k + 1, 13)));
        assert!(own.undecided.is_empty());
    }
    let resting = of(PeakKind::Antiresonance, &found[0]);
    assert_eq!(resting.len(), 11);
    resting.iter().enumerate().for_each(|(k, place)| is(place, sine(k + 1, 12)));
    assert!(of(PeakKind::Antiresonance, &found[11]).is_empty());
}

/// Absorbers without friction hold the mass that they are on, and what only it moves, at their own frequencies, whatever friction acts on the others
/// (J. P. Den Hartog, Mechanical Vibrations, §3.2).
#[test]
fn absorbers_hold_damped_masses() {
    let text = |m: &str| {
        format!(
            "param m = {m}  coord x, y  T = 3/2*x'^2 + 1/2*m*y'^2  V = 5/2*x^2 + 1/2*1.3*(y - x)^2
            dissipation = 0.2*x'^2"
        )
    };
    for (m, place) in [("0.7", (1.3_f64 / 0.7).sqrt()), ("1.3", 1.0)] {
        let [x, y] = &peaks(&text(m), Some("x"), "omega=0..5")[..] else { panic!() };
        assert!(x.undecided.is_empty() && y.undecided.is_empty() && of(PeakKind::Antiresonance, y).is_empty());
        let [resting] = of(PeakKind::Antiresonance, x)[..] else { panic!("{x:?}") };
        is(&resting, place);
        assert!(x.found.iter().any(|own| own.kind == PeakKind::Antiresonance && own.amplitude == Some(Ball::ZERO)));
    }
    let driven = format!("param W = 1  {}  force x = cos(W*t) + 3*sin(W*t)  period 2*pi/W", text("0.7"));
    is(&of(PeakKind::Antiresonance, &peaks(&driven, None, "W=1/10..5")[0])[0], (1.3_f64 / 0.7).sqrt());
    // Two on the first of two damped masses: their frequencies are 2 and 3.
    let text = "coord x[1..2], a, b  T = 1/2*(x[1]'^2 + x[2]'^2 + a'^2 + b'^2)
        V = x[1]^2 + 2*(x[2] - x[1])^2 + 2*(a - x[1])^2 + 9/2*(b - x[1])^2
        dissipation = 0.1*x[1]'^2 + 0.2*x[2]'^2 + 0.3*(x[2] - x[1])'^2";
    for input in ["x[1]", "x[2]"] {
        for (output, found) in peaks(text, Some(input), "omega=0..6").iter().enumerate() {
            let resting = of(PeakKind::Antiresonance, found);
            // An absorber is held by the other one alone; the second mass, where it is driven, by none.
            let wanted: &[f64] = match (input, output) {
                ("x[2]", 1) => &[],
                (_, 0 | 1) => &[2.0, 3.0],
                ("x[1]", 2) => &[3.0],
                ("x[1]", _) => &[2.0],
                _ => continue,
            };
            assert!(found.undecided.is_empty());
            assert_eq!(resting.len(), wanted.len(), "{input} {found:?}");
            resting.iter().zip(wanted).for_each(|(place, wanted)| is(place, *wanted));
        }
    }
}

/// Coriolis forces without friction: both circular frequencies are poles of x and y, between them x rests and y does not.
#[test]
fn gyroscopic_resonances_are_found() {
    let text = "coord x, y  lagrangian = 1/2*((x' - y)^2 + (y' + x)^2) - 1/2*9*(x^2 + y^2)";
    let found = peaks(text, Some("x"), "omega=1/2..10");
    for own in &found {
        let [slow, fast] = &of(PeakKind::Resonance, own)[..] else { panic!("{own:?}") };
        is(slow, 2.0);
        is(fast, 4.0);
    }
    let [resting] = &of(PeakKind::Antiresonance, &found[0])[..] else { panic!() };
    is(resting, 8_f64.sqrt());
    assert!(of(PeakKind::Minimum, &found[0]).is_empty());
    // y = 2 omega/((omega² - 4)(omega² - 16)): 3 omega⁴ - 20 omega² - 64 = 0 for its smallest amplitude.
    let [smallest] = &of(PeakKind::Minimum, &found[1])[..] else { panic!() };
    is(smallest, ((20.0 + 1168_f64.sqrt()) / 6.0).sqrt());
}

/// A mode that the force does not excite makes the system singular; what is left open is near it and nowhere else.
#[test]
fn modes_that_rest_are_reported() {
    let text = std::fs::read_to_string("models/three_pendulums.lag").unwrap();
    let silent = 3.189_043_744_5;
    for own in peaks(&text, Some("phi[2]"), "omega=0..6") {
        assert_eq!(of(PeakKind::Resonance, &own).len(), 2);
        let [[from, to]] = own.undecided[..] else { panic!("{own:?}") };
        assert!((from - silent).abs() < 1e-8 && (to - silent).abs() < 1e-8, "{own:?}");
    }
}

/// What a mode without the output leaves open does not hide the others: chains between walls, seen at a node.
#[test]
fn nodes_hide_no_other_resonance() {
    for n in [3, 5] {
        let text = format!(
            "param N = {n}  coord x[1..N]  T = sum(i in 1..N, 1/2*x[i]'^2)
            V = sum(i in 1..N-1, 1/2*(x[i+1] - x[i])^2) + 1/2*x[1]^2 + 1/2*x[N]^2"
        );
        let all = peaks(&text, Some("x[1]"), "omega=0..3");
        let own = &all[n / 2];
        let frequency = |k: usize| 2.0 * (std::f64::consts::PI * k as f64 / (2 * n + 2) as f64).sin();
        let found = of(PeakKind::Resonance, own);
        assert_eq!(found.len(), n.div_ceil(2), "{own:?}");
        found.iter().zip((1..=n).step_by(2)).for_each(|(found, k)| is(found, frequency(k)));
        let near =
            |piece: &[f64; 2]| (0..=n).any(|k| (piece[0] - frequency(k)).abs() < 1e-2 && piece[1] - piece[0] < 1e-2);
        assert!(own.undecided.iter().all(near), "{own:?}");
    }
}

/// Far above all frequencies the last coordinate of a chain moves by 1e-70: nothing is left undecided there, and each maximum has its half power beside it.
#[test]
fn far_ends_of_a_range_are_decided() {
    let text = "coord x[1..10]  T = sum(i in 1..10, 1/2*x[i]'^2)
        V = 10*x[1]^2 + sum(i in 1..9, 10*(x[i+1] - x[i])^2)
        dissipation = 1/2*1.7e-3*(x[1]'^2 + sum(i in 1..9, (x[i+1]' - x[i]')^2))";
    for over in ["omega=0..12", "omega=0..1e4"] {
        let own = study(text, Some("x[1]"), over).peaks(9).unwrap();
        assert!(own.undecided.is_empty(), "{own:?}");
        let maxima: Vec<&Peak> = own.found.iter().filter(|one| one.kind == PeakKind::Maximum).collect();
        assert_eq!(maxima.len(), 10);
        for (k, one) in (0..).zip(maxima) {
            let frequency = 2.0 * 20.0_f64.sqrt() * (std::f64::consts::PI * f64::from(2 * k + 1) / 42.0).sin();
            assert!((one.place.mid_f64() - frequency).abs() < 1e-3, "{one:?} {frequency}");
            let [from, to] = one.half_power.map(|own| own.unwrap().mid_f64());
            assert!(from < one.place.mid_f64() && one.place.mid_f64() < to && to - from < 0.02, "{one:?}");
        }
    }
}

/// At the end of the range the matrix is singular, for a mode that the force does not excite: the half power lies between.
#[test]
fn half_power_beside_a_singular_end() {
    let text = "coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)  V = 1/2*(x^2 + (x - y)^2 + (x - z)^2)
        dissipation = 1/20*x'^2";
    // With u = y + z: ((3 - ω² + iω/10)(1 - ω²) - 2) x = (1 - ω²) F.
    let square = |omega: f64| {
        let rest = 1.0 - omega * omega;
        rest * rest / (((2.0 + rest) * rest - 2.0).powi(2) + (omega / 10.0 * rest).powi(2))
    };
    for over in ["omega=1..2", "omega=0..1"] {
        let own = study(text, Some("x"), over).peaks(0).unwrap();
        let one = own.found.iter().find(|one| one.kind == PeakKind::Maximum).unwrap();
        for half in one.half_power.map(|own| own.unwrap().mid_f64()) {
            let off = 2.0 * square(half) / square(one.place.mid_f64()) - 1.0;
            assert!(off.abs() < 1e-9, "{over} {half} {off}");
        }
    }
}

/// What does not hang together with the driven coordinate rests, and its frequencies are none of the response.
#[test]
fn other_systems_in_the_same_model_are_left_alone() {
    let text = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*(4*x^2 + 9*y^2)";
    let [own, other] = &peaks(text, Some("x"), "omega=0..5")[..] else { panic!() };
    let [resonance] = &of(PeakKind::Resonance, own)[..] else { panic!("{own:?}") };
    is(resonance, 2.0);
    assert!(own.undecided.is_empty() && other.found.is_empty() && other.undecided.is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn no_maximum_of_a_random_model_is_missed(
        order in 1_usize..5,
        entries in prop::collection::vec(-9_i64..10, 48),
        damping in 1_i64..200,
    ) {
        // Bᵀ B + 1 is positive definite.
        let sum = |part: usize, prime: &str| -> String {
            let entry = |k: usize, i: usize| entries[16 * part + 4 * k + i];
            let product = |i, j| (0..order).map(|k| entry(k, i) * entry(k, j)).sum::<i64>() + i64::from(i == j);
            let pairs = (0..order).flat_map(|i| (0..order).map(move |j| (i, j)));
            let term = |(i, j)| format!("({})*x[{}]{prime}*x[{}]{prime}", product(i, j), i + 1, j + 1);
            pairs.map(term).collect::<Vec<_>>().join(" + ")
        };
        let text = format!(
            "coord x[1..{order}]  T = 1/2*({})  V = 5*({})  dissipation = 1/{damping}*({})",
            sum(0, "'"), sum(1, ""), sum(2, "'"),
        );
        let places = 301;
        let sampled = study(&text, Some("x[1]"), &format!("omega=1/10..30:{places}"));
        let values: Vec<_> = (0..places).map(|place| sampled.values(place).unwrap()).collect();
        prop_assert_eq!(sampled.outputs(), order);
        for (output, own) in (0..order).map(|output| (output, sampled.peaks(output).unwrap())) {
            prop_assert!(own.undecided.is_empty(), "{text}: {own:?}");
            let tops: Vec<f64> = of(PeakKind::Maximum, &own).iter().map(Ball::mid_f64).collect();
            let height = |place: usize| values[place][output].amplitude();
            for place in 1..places - 1 {
                if height(place) > height(place - 1) && height(place) > height(place + 1) {
                    let near = sampled.place(place - 1)..sampled.place(place + 1);
                    prop_assert!(tops.iter().any(|top| near.contains(top)), "{text}: {near:?} {tops:?}");
                }
            }
            for peak in &own.found {
                let place = peak.place.mid_f64();
                let beside = study(&text, Some("x[1]"), &format!("omega={}..{}:2", place * (1.0 - 1e-6), place * (1.0 + 1e-6)));
                for side in 0..2 {
                    let other = beside.values(side).unwrap()[output].amplitude();
                    let own = peak.amplitude.unwrap().mid_f64();
                    let is_top = peak.kind == PeakKind::Maximum;
                    prop_assert!(if is_top { other <= own } else { other >= own }, "{text}: {peak:?} {other}");
                }
            }
        }
    }
}

/// The slope may vanish at an end of the range: what lies close to it is found all the same.
#[test]
fn a_resonance_beside_an_end() {
    let text = "coord x  T = 1/2*x'^2  V = 1/2*x^2";
    for over in ["omega=0..1.00000000001", "omega=0..1e11"] {
        let [found] = &peaks(text, Some("x"), over)[..] else { panic!() };
        let [place] = &of(PeakKind::Resonance, found)[..] else { panic!("{over}: {found:?}") };
        is(place, 1.0);
        assert!(found.undecided.is_empty(), "{over}: {:?}", found.undecided);
    }
}

/// At a third of each piece behind an end.
#[test]
fn a_resonance_at_the_same_place_of_all_pieces() {
    for (w, exact) in
        [("4/3*2^(-36)", 4.0 / 3.0 * 0.5_f64.powi(36)), ("1 - 4/3*2^(-36)", 1.0 - 4.0 / 3.0 * 0.5_f64.powi(36))]
    {
        let text = format!("param w = {w}  coord x  T = 1/2*x'^2  V = 1/2*w^2*x^2");
        let [found] = &peaks(&text, Some("x"), "omega=0..1")[..] else { panic!() };
        let [place] = &of(PeakKind::Resonance, found)[..] else { panic!("{w}: {found:?}") };
        is(place, exact);
    }
}

/// The resonances under a drive do not depend on its phase.
#[test]
fn drives_of_any_phase_find_the_same() {
    for function in ["cos", "sin"] {
        let text = format!(
            "param W = 1  coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*x^2 + 3/2*(x - y)^2  force x = {function}(W*t)"
        );
        let all = peaks(&text, None, "W=0.1..5");
        let places = of(PeakKind::Resonance, &all[0]);
        let [first, second] = &places[..] else { panic!("{function}: {:?}", all[0]) };
        // ω⁴ - 7 ω² + 3 = 0
        is(first, ((7.0 - 37.0_f64.sqrt()) / 2.0).sqrt());
        is(second, ((7.0 + 37.0_f64.sqrt()) / 2.0).sqrt());
    }
}
