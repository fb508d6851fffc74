//! Stability charts where steps in doubles could go wrong: drives with jumps, corners and pulses, against closed forms and
//! against certified multipliers.
#![cfg(feature = "engine")]

use std::f64::consts::PI;

use librate::Source;
use librate::chart::{Chart, Place};
use librate::floquet::floquet;
use librate::model::{Range, Settings, TableTexts, elaborate};
use librate::syntax;

/// All places, row by row, with the values of both parameters.
fn places(text: &str, ranges: [&str; 2]) -> Vec<([f64; 2], Place)> {
    let file = syntax::parse(text).unwrap();
    let ranges = ranges.map(|range| Range::parse(range).unwrap());
    let chart = Chart::new(&Source { file, tables: TableTexts::new(), settings: Settings::new() }, ranges).unwrap();
    let mut worker = chart.worker();
    let values = [chart.values(0), chart.values(1)];
    let mut found = Vec::new();
    for (row, first) in values[0].iter().enumerate() {
        let places = worker.row(row);
        found.extend(values[1].iter().zip(places).map(|(second, place)| ([*first, *second], place)));
    }
    found
}

/// sin(sqrt(k) s)/sqrt(k) and cos(sqrt(k) s) for k of any sign.
fn half(k: f64, s: f64) -> (f64, f64) {
    let w = k.abs().sqrt();
    if k > 0.0 {
        ((w * s).sin() / w, (w * s).cos())
    } else if k < 0.0 {
        ((w * s).sinh() / w, (w * s).cosh())
    } else {
        (s, 1.0)
    }
}

/// Without force a body drifts away; a free oscillation has the multipliers -1, too, and stays.
#[test]
fn a_drift_is_not_called_stable() {
    let text = "param d = 1  param e = 0  coord x  T = 1/2*x'^2  V = 1/2*(d + e*cos(2*t))*x^2  period pi";
    for ([d, _], place) in places(text, ["d=0..4:5", "e=0..1e-300:2"]) {
        assert_eq!(place.stable, (d > 0.0).then_some(true), "{d}");
    }
    // A parameter is found whatever the spaces in its name.
    let family = text.replace("param d =", "param d[i in 1..2, j in 1..2] =").replace("(d +", "(d[1,2] +");
    for name in ["d[1,2]", "d[1, 2]"] {
        assert_eq!(places(&family, [&format!("{name}=0..4:5"), "e=0..1e-300:2"]).len(), 10);
    }
}

/// Two halves of a period with constant stiffness: half the trace of the monodromy matrix is
/// cos cos - (k1 + k2)/2 (sin/w1)(sin/w2) (E. Meissner, Schweizerische Bauzeitung 72 (1918) 95).
#[test]
fn square_waves_have_their_closed_form() {
    let text = "param a = 1  param q = 0.5  coord y  T = 1/2*y'^2 \
                V = 1/2*(a - q*cos(t)/abs(cos(t)))*y^2  period 2*pi";
    let mut unstable = 0;
    for ([a, q], place) in places(text, ["a=-0.3..2.2:14", "q=0.05..1.4:11"]) {
        let (k1, k2) = (a - q, a + q);
        let ((s1, c1), (s2, c2)) = (half(k1, PI), half(k2, PI));
        let trace = c1 * c2 - 0.5 * (k1 + k2) * s1 * s2;
        // Not on a border.
        assert!((trace.abs() - 1.0).abs() > 1e-6, "{a} {q}");
        assert_eq!(place.stable, Some(trace.abs() < 1.0), "{a} {q}: {trace}");
        let growth = if trace.abs() > 1.0 {
            unstable += 1;
            (trace.abs() + (trace * trace - 1.0).sqrt()).ln() / (2.0 * PI)
        } else {
            0.0
        };
        let off = (place.growth_rate - growth).abs();
        assert!(off < 1e-11, "{a} {q}: {} {growth}", place.growth_rate);
    }
    assert!(unstable > 20);
}

/// What charts say of smooth drives agrees with certified multipliers.
#[test]
fn pulses_are_not_missed() {
    for (drive, period, ranges) in [
        // Nothing is to be seen of the pulse at the beginning: its first forty derivatives vanish.
        ("a + q*sin(t/2)^40", "2*pi", ["a=0..0.2:3", "q=0..8:5"]),
        // A hundredth of the period wide.
        ("a + q*exp(-2000*(1 - cos(t)))", "2*pi", ["a=-0.2..1:2", "q=3..3:1"]),
        ("a + q*exp(-2000*(1 - cos(t - 2)))", "2*pi", ["a=-0.2..1:2", "q=3..3:1"]),
        ("a + q*tanh(20*sin(t))", "2*pi", ["a=0.2..1:2", "q=0.1..0.7:2"]),
    ] {
        let text = format!("param a = 1  param q = 1  coord y  T = 1/2*y'^2  V = 1/2*({drive})*y^2  period {period}");
        for ([a, q], place) in places(&text, ranges) {
            let settings = [format!("a={a}"), format!("q={q}")];
            let mut own = Settings::new();
            for setting in &settings {
                own.add(setting).unwrap();
            }
            let file = syntax::parse(&text).unwrap();
            let model = elaborate(&file, &TableTexts::new(), &own).unwrap();
            let certified = floquet(&model, &Default::default()).unwrap_or_else(|error| panic!("{text}: {error}"));
            if let Some(stable) = certified.stable {
                assert_eq!(place.stable, Some(stable), "{text} {settings:?}");
            }
            let rate = certified.growth_rate.unwrap().mid_f64();
            let off = (place.growth_rate - rate).abs();
            assert!(off < 1e-9, "{text} {settings:?}: {} {rate}", place.growth_rate);
        }
    }
}

/// Two bodies that only a pumped spring joins drift with their centre of mass, with friction between them, too: neither stable nor not.
#[test]
fn what_drifts_is_not_called_stable() {
    for friction in ["", "  dissipation = 0.1*(x' - y')^2"] {
        let text = "param q = 0  param b = 0  coord x, y  T = 1/2*x'^2 + 1/2*y'^2 \
                    V = 1/2*(1 - 2*q*cos(2*t))*(x - y)^2 + b*y^2  period pi";
        for ([_, b], place) in places(&format!("{text}{friction}"), ["q=0..0.3:4", "b=0..1:2"]) {
            assert_eq!(place.stable, (b > 0.0).then_some(true), "{friction}: {b}");
        }
    }
}

/// A corner in a force that moves the place: y'' + y = |sin t| has a periodic motion, and its multipliers are those of y'' + y' c + y = 0.
#[test]
fn corners_in_a_force_do_not_matter_to_linear_motions() {
    let text = "param c = 1/4  param f = 1  coord y  T = 1/2*y'^2  V = 1/2*y^2 - f*y*abs(sin(t)) \
                dissipation = 1/2*c*y'^2  period pi";
    for ([c, _], place) in places(text, ["c=0.1..1:4", "f=0.5..2:3"]) {
        assert_eq!(place.stable, Some(true));
        let off = (place.growth_rate + 0.5 * c).abs();
        assert!(off < 1e-11, "{c}: {}", place.growth_rate);
    }
}

/// A damper of no strength leaves the multipliers on the circle, also where they meet at -1.
#[test]
fn dampers_without_strength_change_nothing() {
    let text = "param h = 0  param R = 0  coord q  T = 1/2*q'^2  V = 1/2*q^2*(1 + h*cos(2*t)) \
                dissipation = 1/2*R*q'^2  period pi";
    for ([h, r], place) in places(text, ["h=0..0.2:2", "R=0..0.1:2"]) {
        if h == 0.0 {
            assert_eq!(place.stable, Some(true), "{r}");
            assert!((place.growth_rate + 0.5 * r).abs() < 1e-13, "{r}: {}", place.growth_rate);
            assert!(r > 0.0 || place.growth_rate == 0.0, "{}", place.growth_rate);
        }
    }
}
