//! Pictures and pages: what `plot` and `show` write, and what they find to draw.
#![cfg(feature = "cli")]

use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::cli_support::*;
use crate::common::model_files;
use librate::Source;
use librate::figure::{Figure, figure};
use librate::linearize::linearize;
use librate::model::{Range, Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::sweep::Sweep;
use librate::syntax::parse;
use librate::tracking::{Tracked, branches};
use librate_studies::figure::Link;
use librate_studies::tracking::Branch;
use roxmltree::Document;
use serde_json::Value;

/// An SVG picture that is what all of them are.
fn picture(arguments: &[&str]) -> String {
    let run = run(&[&["plot"], arguments].concat());
    assert_eq!(run.status, 0, "{arguments:?}: {}", run.err);
    let page = Document::parse(&run.out).unwrap();
    let svg = page.root_element();
    let numbers: Vec<f64> = svg.attribute("viewBox").unwrap().split(' ').map(|word| word.parse().unwrap()).collect();
    let named =
        |name: &str| svg.children().find(|node| node.has_tag_name(("http://www.w3.org/2000/svg", name))).unwrap();
    assert!(!named("title").text().unwrap().is_empty() && !named("desc").text().unwrap().is_empty());
    assert!(named("style").text().unwrap().contains("prefers-color-scheme:dark"));
    let labelled: Vec<&str> = svg.attribute("aria-labelledby").unwrap().split(' ').collect();
    assert_eq!(labelled, [named("title").attribute("id").unwrap(), named("desc").attribute("id").unwrap()]);
    for text in page.descendants().filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "text"))) {
        let at = |name: &str| text.attribute(name).unwrap().parse::<f64>().unwrap();
        assert!(
            (0.0..=numbers[2]).contains(&at("x")) && (0.0..=numbers[3]).contains(&at("y")),
            "{arguments:?}: {text:?}"
        );
    }
    assert!(!run.out.contains("NaN") && !run.out.contains("inf"), "{arguments:?}");
    run.out
}

fn texts(svg: &str) -> Vec<String> {
    let page = Document::parse(svg).unwrap();
    let all = page.descendants().filter(|node| node.tag_name().name() == "text");
    all.filter_map(|node| Some(node.text()?.to_owned())).collect()
}

#[test]
fn each_kind_is_drawn() {
    let modes = picture(&["modes", "models/three_pendulums.lag"]);
    let told = texts(&modes);
    assert!(told.contains(&"1: ω = 3.1321 rad/s, even".to_owned()), "{told:?}");
    assert!(told.contains(&"φ₃".to_owned()));
    let complex = texts(&picture(&["modes", "models/foucault_pendulum.lag"]));
    assert!(complex.contains(&"a quarter of a period later".to_owned()));
    let damped = texts(&picture(&["modes", "models/damped_pair.lag"]));
    assert!(damped.contains(&"a quarter of a period later, but for the growth".to_owned()), "{damped:?}");
    let free = texts(&picture(&["modes", "models/cyclotron.lag"]));
    assert!(free.contains(&"the imaginary part".to_owned()), "{free:?}");
    let spectrum = texts(&picture(&["spectrum", "models/three_pendulums.lag"]));
    assert!(spectrum.iter().any(|own| own.starts_with("Spectrum")) && spectrum.contains(&"mode".to_owned()));
    let dispersion = texts(&picture(&["spectrum", "models/ring.lag"]));
    assert!(dispersion.contains(&"wave number".to_owned()), "{dispersion:?}");
    let sweep = texts(&picture(&["sweep", "models/three_pendulums.lag", "--over", "k12=0..8:9"]));
    assert!(sweep.contains(&"k₁₂ (N/m)".to_owned()) && sweep.contains(&"ω (rad/s)".to_owned()), "{sweep:?}");
    let grows = texts(&picture(&["sweep", "models/bead_on_hoop_bottom.lag", "--over", "W=0..10:21"]));
    assert!(grows.contains(&"growth".to_owned()) || grows.contains(&"growth (1/s)".to_owned()), "{grows:?}");
    let motion =
        ["motion", "models/three_pendulums.lag", "--mode", "2", "--amplitude", "0.5", "--until", "5", "--linear"];
    assert!(texts(&picture(&motion)).contains(&"φ₁, linear".to_owned()));
    let bead = "models/equilibria/bead_on_hoop.lag";
    let well = texts(&picture(&["equilibria", bead, "--box", "th=-2..2"]));
    assert!(["potential", "stable", "unstable"].iter().all(|own| well.contains(&(*own).to_owned())), "{well:?}");
    let portrait = texts(&picture(&["equilibria", "models/simple_pendulum.lag", "--box", "phi=-4..4"]));
    for own in ["to and fro", "leaves the box", "separatrix", "φ̇ (rad/s)"] {
        assert!(portrait.contains(&own.to_owned()), "{portrait:?}");
    }
    let over = ["sweep", "models/whirling_shaft_above.lag", "--over", "W=0..60:13"];
    let campbell = texts(&picture(&[&over[..], &["--orders", "1,2.5"]].concat()));
    assert!(campbell.iter().any(|own| own.starts_with("Campbell diagram")), "{campbell:?}");
    assert!(campbell.contains(&"order 2.5".to_owned()), "{campbell:?}");
    let locus = texts(&picture(&[&over[..], &["--root-locus"]].concat()));
    assert!(
        locus.iter().any(|own| own.starts_with("growth")) && !locus.iter().any(|own| own.starts_with('W')),
        "{locus:?}"
    );
    let branches = picture(&["equilibria", bead, "--box", "th=-2..2", "--over", "W=0..20:11"]);
    assert!(texts(&branches).contains(&"pitchfork".to_owned()) && branches.contains("line dashed"), "{branches}");
    let plane = picture(&["equilibria", "models/equilibria/muller_brown.lag", "--box", "x=-1.5..1.2, y=-0.5..2"]);
    assert!(texts(&plane).contains(&"high potential".to_owned()) && plane.len() < 200_000);
    let chart = picture(&["floquet", "models/mathieu.lag", "--map", "a=0..4:9", "q=0..4:9"]);
    assert!(texts(&chart).contains(&"stable".to_owned()) && chart.contains("fill-opacity"));
    let driven = ["response", "models/response/damped_absorber.lag", "--input", "x1", "--over", "omega=0..20:101"];
    let with_peaks = picture(&[&driven[..], &["--peaks"]].concat());
    let rings = |text: &str| text.matches(" ring\"").count();
    assert_eq!([rings(&with_peaks), rings(&picture(&driven))], [6, 0]);
    let response = texts(&picture(&driven));
    assert!(response.contains(&"ω (rad/s)".to_owned()) && response.contains(&"phase (rad)".to_owned()), "{response:?}");
    // The same bytes again.
    assert_eq!(chart, picture(&["floquet", "models/mathieu.lag", "--map", "a=0..4:9", "q=0..4:9", "--threads", "1"]));
    let swing = texts(&picture(&["floquet", "models/child_on_swing.lag", "--map", "eps=0.1..0.5:3", "l0=1..3:3"]));
    assert!(swing.contains(&"l₀ (m)".to_owned()) && swing.iter().any(|own| own.ends_with(" 1/s")), "{swing:?}");
}

/// Of the odd mode, omega² = 1 + 2k, and the higher even one, 5/2 + sqrt(9/4 + 9/50), however few values are drawn.
#[test]
fn rings_are_where_modes_cross() {
    let text = "param k = 1  coord x[1..2], y  T = 1/2*x[1]'^2 + 1/2*x[2]'^2 + 1/2*y'^2
        V = 1/2*(x[1]^2 + x[2]^2) + 1/2*k*(x[1] - x[2])^2 + 2*y^2 + 3/10*y*(x[1] + x[2])";
    let crossing = (1.5 + (9.0_f64 / 4.0 + 9.0 / 50.0).sqrt()) / 2.0;
    for count in [2, 3, 7] {
        let svg = with_input(&["plot", "sweep", "-", "--over", &format!("k=0..4:{count}")], text).out;
        let (_, rings) = svg.split_once(" ring\" cx=\"").unwrap();
        let place: f64 = rings.split('"').next().unwrap().parse().unwrap();
        // The range is 600 wide.
        assert!((place / 600.0 * 4.0 - crossing).abs() < 1e-3, "{count}: {place}");
    }
    // Without a symmetry: what nothing couples, at omega² = k, crosses the others; what a little couples does not.
    let swept = |more: &str| {
        let text = format!(
            "param k = 2  coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)
             V = 1/2*k*x^2 + x^3 + 3/2*y^2 + y^3 + 1/2*(z - y)^2 + z^3{more}"
        );
        with_input(&["plot", "sweep", "-", "--over", "k=0.2..6.2:7"], &text).out
    };
    let (apart, coupled) = (swept(""), swept(" + x*y/10"));
    assert!(texts(&apart).contains(&"mode 2, y, z".to_owned()) && !coupled.contains(" ring\""), "{apart}");
    let rings = apart.split(" ring\" cx=\"").skip(1);
    let places: Vec<f64> = rings.map(|own| own.split('"').next().unwrap().parse().unwrap()).collect();
    // The last one is that of the legend.
    assert_eq!(places.len(), 3);
    // Of y and z, (5 ∓ √13)/2.
    for (place, crossing) in places.iter().zip([(5.0 - 13_f64.sqrt()) / 2.0, (5.0 + 13_f64.sqrt()) / 2.0]) {
        assert!((0.2 + place / 100.0 - crossing).abs() < 2e-3, "{place}");
    }
}

#[test]
fn all_models_have_a_picture_of_their_modes() {
    for path in model_files() {
        let name = path.to_str().unwrap();
        let modes = run(&["modes", name, "--lowest", "4"]);
        if modes.status == 0 {
            let svg = picture(&["modes", name, "--lowest", "4"]);
            assert!(texts(&svg).iter().any(|text| text.starts_with("1: ")), "{name}");
        }
    }
}

/// No curve goes through a separatrix, at which the period has no end, and amplitudes are in SI, whatever unit the coordinate has.
#[test]
fn periods_end_at_a_separatrix() {
    let curves = |svg: &str| svg.matches("class=\"c0 line\"").count();
    let paths = |over: &str| curves(&picture(&["period", "models/double_well.lag", "--over", over]));
    assert_eq!([paths("energy=-0.9..-0.1:9"), paths("energy=-0.9..5:30"), paths("energy=1..5:9")], [1, 2, 1]);
    let model = "param J : kg*m^2 = 1  param D : N*m = 1  coord th : deg  T = 1/2*J*th'^2  V = D*(1 - cos(th))";
    let told = texts(&with_input(&["plot", "period", "-", "--over", "amplitude=10..170:5"], model).out);
    assert!(told.contains(&"amplitude (rad)".to_owned()) && !told.contains(&"100".to_owned()), "{told:?}");
}

#[test]
fn what_is_no_picture_is_told() {
    for (arguments, told) in [
        (&["period", "models/simple_pendulum.lag", "--amplitude", "1"][..], "a single period is no curve"),
        (&["floquet", "models/mathieu.lag"], "no chart"),
        (&["sweep", "models/three_pendulums.lag", "--over", "k12=0..8:20000"], "too many for a picture"),
        (&["modes", "models/three_pendulums.lag", "--json", "-o", "x.svg"], "cannot be used with"),
    ] {
        let run = run(&[&["plot"], arguments].concat());
        assert_eq!(run.status, 2, "{arguments:?}");
        assert!(run.err.contains(told), "{}", run.err);
    }
}

fn swept(text: &str, over: &str) -> Vec<Branch> {
    let range = Range::parse(over).unwrap();
    let file = parse(text).unwrap();
    let source = Source { file, tables: TableTexts::new(), settings: Settings::new() };
    let sweep = Sweep::new(source, range, Options::default());
    let all: Vec<usize> = (0..sweep.range().len()).collect();
    let mut places = sweep.worker().tracked(&all);
    for (at, place) in all.into_iter().zip(&places) {
        let full = Tracked::of(sweep.place(at));
        assert_eq!((place.value, place.shapes().len()), (full.value, full.shapes().len()));
        for (own, full) in place.shapes().iter().zip(full.shapes()) {
            assert!((own.omega - full.omega).contains_zero() && (own.growth - full.growth).contains_zero());
            // Of those at single values between nothing is asked.
            assert!(own.class.is_none() || own.class == full.class);
        }
    }
    branches(&sweep, &mut places)
}

/// The number that a branch has among the modes at its first and at its last place.
fn ends(branches: &[Branch]) -> Vec<[usize; 2]> {
    branches.iter().map(|branch| [branch.at.first().unwrap().1, branch.at.last().unwrap().1]).collect()
}

#[test]
fn modes_cross_where_nothing_couples_them_and_avoid_it_where_something_does() {
    let pair =
        |coupling: &str| format!("param k = 1  coord x, y  T = x'^2/2 + y'^2/2  V = k*x^2/2 + y^2 + {coupling}*x*y");
    // 1 to 4 for the one, 2 for the other; a place on the crossing itself, and none.
    for count in [7, 6, 19] {
        let crossing = swept(&pair("0"), &format!("k=1..4:{count}"));
        assert_eq!(ends(&crossing), [[0, 1], [1, 0]], "{count}");
        assert!(crossing.iter().all(|branch| branch.at.len() >= count));
        for coupling in ["0.001", "1e-6", "3e-9"] {
            let avoided = swept(&pair(coupling), &format!("k=1..4:{count}"));
            assert_eq!(ends(&avoided), [[0, 0], [1, 1]], "{count}, {coupling}");
        }
    }
    // Of the motion of the support alone nothing is left of 1e-20 beside 1 in doubles.
    let support = std::fs::read_to_string("models/hard/nearly_massless_support.lag").unwrap();
    for count in [5, 21] {
        let found = swept(&support, &format!("m=0.8..1.2:{count}"));
        assert_eq!(ends(&found), [[0, 0], [1, 1]]);
        assert!(found.iter().all(|branch| branch.at.len() < 5 * count));
    }
    // Even and odd modes of a mirror cross, whatever couples them.
    let mirror = "param c = 1  coord a, b, d  T = (a'^2 + b'^2 + d'^2)/2
        V = (a^2 + d^2)/2 + b^2 + (a - b)^2/20 + (d - b)^2/20 + c*(a - d)^2/4";
    let found = swept(mirror, "c=0..4:9");
    let odd: Vec<_> = found.iter().filter(|branch| branch.class.as_deref() == Some("odd")).collect();
    assert_eq!(odd.len(), 1);
    assert_eq!([odd[0].at[0].1, odd[0].at.last().unwrap().1], [1, 2]);
}

/// Growth and decay of one shape are not taken for each other where two small exponents become real beside them.
#[test]
fn exponents_of_opposite_signs_are_told_apart() {
    let flutter = "param m = 5, S = 2/5, I = 1/10, kh = 500, ka = 40, U = 5, r = 6, e = 2/25
        coord h, al  T = 1/2*m*h'^2 + S*h'*al' + 1/2*I*al'^2  V = 1/2*kh*h^2 + 1/2*ka*al^2  dissipation = 1/2*h'^2
        force h = -r*U^2*al  force al = r*U^2*e*al";
    let svg = with_input(&["plot", "sweep", "-", "--over", "U=8.9..9.4:11"], flutter).out;
    let steepest = pieces(&svg).iter().flatten().map(|[a, .., d]| (d[1] - a[1]).abs()).fold(0.0, f64::max);
    assert!(steepest < 120.0 && svg.len() < 60_000, "{steepest}, {}", svg.len());
}

/// Even frequencies with ω² = 3/2 ± sqrt(33/100), the odd one with 4a: it crosses both, which rings tell; what only comes near has none.
#[test]
fn crossings_that_are_proved_have_rings() {
    let model = "param a = 1  coord x, y, z  T = 1/2*(x'^2 + y'^2 + z'^2)
        V = 1/2*(x + y)^2 + a*(x - y)^2 + 1/2*z^2 + 1/5*z*(x + y)";
    let rings = |model: &str| -> Vec<f64> {
        let svg = with_input(&["plot", "sweep", "-", "--over", "a=0..3:31"], model).out;
        let page = Document::parse(&svg).unwrap();
        let rings = page.descendants().filter(|node| node.attribute("class").is_some_and(|own| own.ends_with(" ring")));
        rings.map(|node| node.attribute("cx").unwrap().parse().unwrap()).collect()
    };
    let found = rings(model);
    // The last one stands in the legend.
    assert_eq!(found.len(), 3);
    let (left, right) = (0.0, 608.0);
    for (x, a) in found.iter().zip([1.5 - 0.33_f64.sqrt(), 1.5 + 0.33_f64.sqrt()]) {
        assert!((x - left - a / 4.0 / 3.0 * (right - left)).abs() < 2.0, "{x}");
    }
    assert_eq!(rings(&model.replace("1/5*z*(x + y)", "1/5*z*(x + 2*y)")), [0.0; 0]);
    // At a pole a frequency ends; the even one is 2 where 1/(2.03 - a) is 4.
    let pole = "param a = 1  coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/4*(x + y)^2/(2.03 - a) + (x - y)^2";
    assert_eq!(rings(pole).len(), 2);
}

/// The cubic pieces of each curve of a picture: four points each.
fn pieces(svg: &str) -> Vec<Vec<[[f64; 2]; 4]>> {
    let page = Document::parse(svg).unwrap();
    let paths = page.descendants().filter_map(|node| node.attribute("d").filter(|path| path.contains('C')));
    let numbers = |text: &str| -> Vec<f64> { text.split_whitespace().map(|own| own.parse().unwrap()).collect() };
    let curve = |path: &str| {
        let mut parts = path.trim_start_matches('M').split('C').map(numbers);
        let start = parts.next().unwrap();
        let mut last = [start[0], start[1]];
        let piece = |own: Vec<f64>| {
            let from = std::mem::replace(&mut last, [own[4], own[5]]);
            [from, [own[0], own[1]], [own[2], own[3]], last]
        };
        parts.map(piece).collect()
    };
    paths.map(curve).collect()
}

/// ω² = (3 ± sqrt((2a - 1)² + 4c²))/2: corners of any sharpness between two values.
#[test]
fn curves_are_right_between_values() {
    let (from, to) = (0.013, 1.01);
    for coupling in [1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3] {
        let model = format!(
            "param a = 0, c = {coupling}  coord x, y  T = 1/2*(x'^2 + y'^2)
             V = 1/2*((1 + a)*x^2 + (2 - a)*y^2) + c*x*y"
        );
        let over = format!("a={from}..{to}:11");
        let curves = pieces(&with_input(&["plot", "sweep", "-", "--over", &over], &model).out);
        let omega = |a: f64, sign: f64| {
            let root = (2.0 * a - 1.0).hypot(2.0 * coupling);
            ((3.0 + sign * root) / 2.0).sqrt()
        };
        let [low, high] = [0, 1].map(|at: usize| curves[at][0][0][1]);
        let up = |a: f64, sign: f64| {
            low + (omega(a, sign) - omega(from, -1.0)) * (high - low) / (omega(from, 1.0) - omega(from, -1.0))
        };
        for (curve, sign) in curves.iter().zip([-1.0, 1.0]) {
            let (left, right) = (curve[0][0][0], curve[curve.len() - 1][3][0]);
            for piece in curve {
                for share in (0..=20).map(|at| f64::from(at) / 20.0) {
                    let rest = 1.0 - share;
                    let weights = [rest.powi(3), 3.0 * rest * rest * share, 3.0 * rest * share * share, share.powi(3)];
                    let [x, y] =
                        [0, 1].map(|at: usize| weights.iter().zip(piece).map(|(w, own)| w * own[at]).sum::<f64>());
                    let a = from + (x - left) * (to - from) / (right - left);
                    assert!((y - up(a, sign)).abs() < 0.5, "{coupling}: {} at {a}", y - up(a, sign));
                }
            }
        }
    }
}

/// At ka = 1 the three are alike, so that their classes have other names there than elsewhere.
#[test]
fn modes_are_followed_through_values_of_more_symmetry() {
    let three = "param ka = 1  coord p[1..3]  T = sum(i in 1..3, 1/2*p[i]'^2)
        V = sum(i in 1..3, p[i]^2) + 1/2*ka*(p[1] - p[2])^2 + 1/2*((p[2] - p[3])^2 + (p[3] - p[1])^2)";
    for count in [3, 5, 9, 21] {
        let found = swept(three, &format!("ka=0..2:{count}"));
        assert_eq!(ends(&found), [[0, 0], [1, 2], [2, 1]], "{count}");
        let classes: Vec<_> = found.iter().map(|branch| branch.class.as_deref()).collect();
        assert_eq!(classes, [Some("even"), Some("odd"), Some("even")], "{count}");
    }
    let triangle = "param k = 5, M = 1  coord r[1..3, 1..2]
        T = 1/2*dot(r[1]', r[1]') + 1/2*dot(r[2]', r[2]') + 1/2*M*dot(r[3]', r[3]')
        V = sum(i in 1..3, j in i+1..3, 1/2*k*(norm(r[i] - r[j]) - 1)^2)
        equilibrium r[i in 1..3] = [cos(2*pi*i/3), sin(2*pi*i/3)]/sqrt(3)";
    let found = swept(triangle, "M=1..3:5");
    assert_eq!(ends(&found).len(), 6);
    assert!(found.iter().all(|branch| branch.at.len() >= 5));
    let page = with_input(&["show", "-", "--over", "M=1..3:5"], triangle).out;
    let nodes = data(&page)["grid"]["nodes"].clone();
    for mode in nodes.as_array().unwrap().iter().flat_map(|node| node["modes"].as_array().unwrap()) {
        assert!(mode.is_object(), "{nodes:#}");
    }
}

/// Frequencies 2 ± W in a frame that turns: the lower one turns back at W = 2.
#[test]
fn a_whirl_is_followed_through_zero() {
    let whirl = "param W = 0  coord x, y
        lagrangian = 1/2*(x' - W*y)^2 + 1/2*(y' + W*x)^2 - 2*(x^2 + y^2)";
    for count in [3, 5, 12, 33] {
        let found = swept(whirl, &format!("W=1..5:{count}"));
        assert_eq!(ends(&found), [[0, 0], [1, 1]], "{count}");
    }
}

/// Of x'' + c x' + x: ω = sqrt(1 - c²/4), which ends steeply at c = 2, where a second real exponent begins.
#[test]
fn curves_are_right_beyond_critical_damping() {
    let damped = "param c = 0  coord x  T = 1/2*x'^2  V = 1/2*x^2  dissipation = 1/2*c*x'^2";
    for count in [3, 5, 9, 17] {
        let over = format!("c=0..5:{count}");
        assert_eq!(swept(damped, &over).len(), 2);
        let curves = pieces(&with_input(&["plot", "sweep", "-", "--over", &over], damped).out);
        let (left, right) = (curves[0][0][0], curves[0][curves[0].len() - 1][3]);
        let c = |x: f64| 5.0 * (x - left[0]) / (right[0] - left[0]);
        assert!((c(curves[1][0][0][0]) - 2.0).abs() < 0.01, "{count}");
        for [x, y] in curves[0].iter().map(|piece| piece[3]) {
            let omega = (1.0 - c(x) * c(x) / 4.0).max(0.0).sqrt();
            let drawn = (right[1] - y) / (right[1] - left[1]);
            // Half a pixel, across or up.
            let is_near = |c: f64| ((1.0 - c * c / 4.0).max(0.0).sqrt() - drawn) * (omega - drawn) <= 0.0;
            assert!((omega - drawn).abs() < 0.003 || is_near(c(x - 0.5)) || is_near(c(x + 0.5)), "{count}: {x} {y}");
        }
    }
}

/// A curve that is steep at its beginning: ω² = 1 + 2/c, in units of 1/(L C).
#[test]
fn curves_are_right_from_their_first_value_on() {
    let model = "param c = 1  coord a, b  T = 1/2*(a'^2 + b'^2)  V = 1/2*(a^2 + b^2) + 1/2*(a + b)^2/c";
    let curves = pieces(&with_input(&["plot", "sweep", "-", "--over", "c=0.01..0.1:21"], model).out);
    let omega = |c: f64| (1.0 + 2.0 / c).sqrt();
    let curve = curves.iter().max_by_key(|own| own.len()).unwrap();
    let ([left, high], [right, low]) = (curve[0][0], curve[curve.len() - 1][3]);
    for piece in curve {
        // Half way along a cubic piece.
        let middle = [0, 1].map(|at: usize| (piece[0][at] + 3.0 * (piece[1][at] + piece[2][at]) + piece[3][at]) / 8.0);
        let c = 0.01 + 0.09 * (middle[0] - left) / (right - left);
        let up = high + (omega(c) - omega(0.01)) * (low - high) / (omega(0.1) - omega(0.01));
        assert!((middle[1] - up).abs() < 0.5, "{} at {c}", middle[1] - up);
    }
}

/// Of x'' + 0.02 x' + x: a peak of 1/0.02 that no value of the range meets, on an axis that holds it.
#[test]
fn responses_go_through_their_peaks() {
    let model = "coord x  T = 1/2*x'^2  V = 1/2*x^2  dissipation = 1/100*x'^2";
    let plot = ["plot", "response", "-", "--input", "x", "--over", "omega=0.1..3:24"];
    for peaks in [&[][..], &["--peaks"]] {
        let svg = with_input(&[&plot[..], peaks].concat(), model).out;
        let page = Document::parse(&svg).unwrap();
        let labels: Vec<&str> = page.descendants().filter_map(|node| node.text()).collect();
        assert!(labels.contains(&"10¹") && labels.contains(&"10⁰"), "{labels:?}");
        let highest = pieces(&svg)[0].iter().map(|piece| piece[3][1]).fold(f64::INFINITY, f64::min);
        // The axis goes from 1/8 to 50, with a twentieth beside.
        let (from, to) = ((1.0_f64 / 8.0).log10(), 50.0_f64.log10());
        assert!((highest - 230.0 * 0.05 / 1.1).abs() < 2.0, "{highest}, {from}, {to}");
        let rings = page.descendants().filter(|node| node.attribute("class") == Some("c0 ring"));
        for ring in rings {
            assert!((ring.attribute("cy").unwrap().parse::<f64>().unwrap() - highest).abs() < 0.02);
        }
    }
}

/// A resonance without damping leaves the picture, and its flanks do not take all of it.
#[test]
fn responses_without_damping_leave_the_picture() {
    let model = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*(x^2 + y^2 + (x - y)^2)";
    let svg = with_input(&["plot", "response", "-", "--input", "x", "--over", "omega=0..3:101"], model).out;
    assert!(svg.contains("curves leave it near resonances") && svg.len() < 80_000, "{}", svg.len());
}

/// Labels of axes stand beside the longest number.
#[test]
fn labels_and_numbers_stand_apart() {
    let circuit = "param L : H = 1e-3, C : F = 1e-6  coord q : C  T = 1/2*L*q'^2  V = q^2/(2*C)";
    let svg = with_input(&["plot", "sweep", "-", "--over", "C=1e-6..1.0001e-6:5"], circuit).out;
    let page = Document::parse(&svg).unwrap();
    let at = |node: &roxmltree::Node<'_, '_>| node.attribute("x").unwrap().parse::<f64>().unwrap();
    let all = || page.descendants().filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "text")));
    let label = all().find(|node| node.attribute("transform").is_some()).unwrap();
    let numbers = all().filter(|node| node.attribute("text-anchor") == Some("end"));
    for number in numbers {
        let width = 6.5 * number.text().unwrap().chars().count() as f64;
        assert!(at(&number) - width > at(&label) + 4.0, "{:?}", number.text());
    }
}

fn drawn(text: &str) -> Option<Figure> {
    let file = parse(text).unwrap();
    let model = elaborate(&file, &TableTexts::new(), &Settings::new().with_points()).unwrap();
    figure(&linearize(model).unwrap(), &[])
}

/// Where lines begin and end, and what they stand for.
fn lines(figure: &Figure) -> Vec<(usize, Option<usize>, Link)> {
    figure.lines.iter().map(|own| (own.from, own.to, own.link)).collect()
}

#[test]
fn points_rods_and_springs_are_found() {
    let text = std::fs::read_to_string("models/double_pendulum.lag").unwrap();
    let double = drawn(&text).unwrap();
    assert_eq!((double.names.as_slice(), double.dimension), (&["r1".to_owned(), "r2".to_owned()][..], 2));
    assert_eq!(lines(&double), [(0, None, Link::Rod), (0, Some(1), Link::Rod)]);
    let bonds = "param k = 2  coord r[1..3, 1..3]  T = sum(a in 1..3, dot(r[a]', r[a]')/2)
        V = 1/2*k*((norm(r[2] - r[1]) - 1)^2 + (norm(r[3] - r[2]) - 1)^2)  guess r[a in 1..3] = [0, 0, a]";
    let molecule = drawn(bonds).unwrap();
    assert_eq!((molecule.names[1].as_str(), molecule.dimension), ("r[2]", 3));
    assert_eq!(lines(&molecule), [(0, Some(1), Link::Spring), (1, Some(2), Link::Spring)]);
    let held = "coord x, y  T = (x'^2 + y'^2)/2  V = 10*y  constraint x^2 + y^2 = 4  guess y = -2";
    let pendulum = drawn(held).unwrap();
    assert_eq!((pendulum.names[0].as_str(), lines(&pendulum)), ("(x, y)", vec![(0, None, Link::Rod)]));
    let bead = "coord x, y  T = (x'^2 + y'^2)/2  V = 10*y  constraint y = x^2  guess y = 0";
    assert_eq!(drawn(bead).unwrap().lines, []);
    let cart = std::fs::read_to_string("models/two_pendulums_on_a_cart.lag").unwrap();
    let (cart, _) = cart.split_once("\ndraw ").unwrap();
    let cart = drawn(cart).unwrap();
    assert_eq!(cart.names, ["p1", "p2", "X"]);
    assert_eq!(lines(&cart), [(0, Some(2), Link::Rod), (1, Some(2), Link::Rod)]);
    // Of a lagrangian as of V; a distance from the origin, but no weight.
    let written = bonds.replace("  V = 1/2*k*(", " - 1/2*k*(").replace("  T = ", "  lagrangian = ");
    assert_eq!(drawn(&written).unwrap().lines, molecule.lines);
    let elastic = "coord r, th  let p = [r*sin(th), -r*cos(th)]  T = 1/2*dot(p', p')
        V = 20*(norm(p) - 1)^2 + 10*p[2]  guess r = 1.2";
    assert_eq!(lines(&drawn(elastic).unwrap()), [(0, None, Link::Spring)]);
    assert_eq!(drawn(&elastic.replace("20*(norm(p) - 1)^2", "20*p[1]^2 + p[2]^4")).unwrap().lines, []);
    // A cart that is no point.
    let cart = "coord s, th  let b = [sin(th), -cos(th)]  T = 1/2*s'^2 + 1/2*dot(b', b')
        V = 10*s^2 + 10*b[2] + 1/2*s*sin(th)";
    assert_eq!(drawn(cart).unwrap().still, ["s"]);
    let shown = with_input(&["show", "-"], cart);
    assert!(shown.err.contains("no drawn point moves with s"), "{}", shown.err);
    assert!(shown.out.contains("No drawn point moves with s"));
    // Displacements, angles and differences are no places.
    for none in [
        "coord u[1..3, 1..3]  T = sum(i in 1..3, j in 1..3, u[i,j]'^2)  V = sum(i in 1..3, j in 1..3, u[i,j]^2)",
        "coord x[1..4], y[1..4]  T = sum(i in 1..4, x[i]'^2 + y[i]'^2)  V = sum(i in 1..4, x[i]^2 + y[i]^2)",
        "coord a, b  let d = [a - b, a]  T = a'^2 + b'^2  V = dot(d, d)",
    ] {
        assert!(drawn(none).is_none(), "{none}");
    }
}

/// What a model says of itself takes the place of what is found in it.
#[test]
fn drawings_are_what_models_say() {
    let pendulum = "param l = 2  coord phi, y  T = 1/2*(l^2*phi'^2 + y'^2)  V = phi^2 + y^2
        let r = l*[sin(phi), -cos(phi)]
        draw point r, [3, y]
        draw line [0, 0], r
        draw spring [i in 1..2] [i, 0], [i + 1, y], [4, 4]";
    let figure = drawn(pendulum).unwrap();
    assert_eq!((figure.dimension, figure.dots), (2, 2));
    let lines: Vec<_> = figure.lines.iter().map(|own| own.link).collect();
    assert_eq!(lines, [Link::Rod, Link::Spring, Link::Spring, Link::Spring, Link::Spring]);
    let page = with_input(&["show", "-"], pendulum).out;
    let figure = &data(&page)["figure"];
    assert_eq!((&figure["dots"], &figure["lines"][0]), (&Value::from(2), &serde_json::json!([2, 3, "rod"])));
    if let Some((dom, log)) = in_browser(&page, "mode=1&t=0") {
        assert!(!log.contains("Uncaught"), "{log}");
        let frame = frame(&dom);
        let number = |value: &Value| value.as_f64().unwrap();
        let [phi, y] = [0, 1].map(|at| number(&frame["coordinates"][at]));
        let expected = [[2.0 * phi.sin(), -2.0 * phi.cos()], [3.0, y], [0.0, 0.0]];
        for (point, expected) in frame["points"].as_array().unwrap().iter().zip(expected) {
            let [x, y] = [0, 1].map(|axis| number(&point[axis]));
            assert!((x - expected[0]).hypot(y - expected[1]) < 1e-12, "{frame}");
        }
    }
    for (wrong, code, words) in [
        ("draw point phi", "E0112", "this is a number"),
        ("draw point [phi', 0]", "E0112", "this has a velocity in it"),
        ("draw point [1, 2, 3, phi]", "E0112", "a vector of 4"),
        ("draw line r", "E0112", "a line has two ends"),
        ("draw point [q, 0]", "E0101", "`q` is not declared"),
        ("coord z[2..4, 1..2] draw point z[j]", "E0101", "`draw point [j in 2..4] z[…]`"),
        ("draw rod r, r", "E0058", "expected `point`, `line` or `spring`"),
        ("draw line", "E0019", "`draw line r, s`"),
        ("param draw = 1", "E0005", "begins a statement"),
    ] {
        let checked = with_input(&["check", "-"], &format!("{pendulum}\n{wrong}"));
        assert!(checked.status == 1 && checked.err.contains(code) && checked.err.contains(words), "{}", checked.err);
    }
}

fn page(model: &str) -> String {
    let run = run(&["show", model]);
    assert_eq!(run.status, 0, "{model}: {}", run.err);
    run.out
}

fn data(page: &str) -> Value {
    let start = page.find("id=\"data\">").unwrap() + "id=\"data\">".len();
    serde_json::from_str(&page[start..start + page[start..].find("</script>").unwrap()]).unwrap()
}

#[test]
fn pages_have_everything_and_nothing_from_elsewhere() {
    for path in model_files() {
        let name = path.to_str().unwrap();
        let modes = run(&["modes", name, "--json"]);
        if modes.status != 0 || name.contains("ubiquitin") {
            continue;
        }
        let modes: Value = serde_json::from_str(&modes.out).unwrap();
        let all = modes["modes"].as_array().unwrap();
        if all.len() > 200 {
            continue;
        }
        let page = page(name);
        assert!(page.len() < 300_000 || all.len() > 60, "{name}: {}", page.len());
        // Names of XML are no addresses.
        let addresses = page.matches("http").count();
        assert_eq!(addresses, page.matches("=\"http://www.w3.org/").count(), "{name}");
        let data = data(&page);
        assert_eq!(data["names"], modes["coordinates"], "{name}");
        for (drawn, mode) in data["modes"].as_array().unwrap().iter().zip(all) {
            assert_eq!(drawn["kind"], mode["kind"]);
            assert!(page.contains(&format!("<td>{}</td>", mode["omega_digits"].as_str().unwrap_or("?"))), "{name}");
            assert_eq!(drawn["shape"].as_array().unwrap().len(), modes["coordinates"].as_array().unwrap().len());
        }
    }
}

#[test]
fn pages_say_what_modes_says() {
    let page = page("models/co2.lag");
    for told in
        ["bound</th>", "f (Hz)</th>", "<p>modes 1 to 5 together are: translation of r along x,", "symmetry</th>"]
    {
        assert!(page.contains(told), "{told}: {page}");
    }
    assert!(self::page("models/lc_ladder.lag").contains("The model has no points to draw"));
}

#[test]
fn texts_of_models_are_no_markup() {
    let text = "# </script><script>alert(1)</script> & </pre>\nmodel m\ncoord x\nT = x'^2\nV = x^2\n";
    let run = with_input(&["show", "-"], text);
    assert_eq!(run.status, 0, "{}", run.err);
    assert!(run.out.contains("# &lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt; &amp; &lt;/pre&gt;"));
    assert_eq!(run.out.matches("<script").count(), 2);
}

#[test]
fn pages_of_thousands_of_modes_are_refused() {
    let run = run(&["show", "models/chain_walls.lag", "--set", "N=300"]);
    assert_eq!(run.status, 2);
    assert!(run.err.contains("--lowest"), "{}", run.err);
    assert_eq!(self::run(&["show", "models/chain_walls.lag", "--set", "N=300", "--lowest", "5"]).status, 0);
}

#[test]
fn sliders_move_modes_that_are_followed_from_node_to_node() {
    let numbers =
        |value: &Value| -> Vec<f64> { value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect() };
    let pendulum = "models/double_pendulum.lag";
    let run_page = run(&["show", pendulum, "--over", "m[2]=0.5..4:3", "--over", "l[2]=0.5..2:4"]);
    assert_eq!(run_page.status, 0, "{}", run_page.err);
    assert_eq!(run_page.out.matches("data-axis type=\"range\"").count(), 2);
    let grid = &data(&run_page.out)["grid"];
    for (node, mass, length) in [(0, "0.5", "0.5"), (6, "2.25", "3/2"), (11, "4", "2")] {
        let [mass, length] = [format!("m[2]={mass}"), format!("l[2]={length}")];
        let there = run(&["modes", pendulum, "--json", "--set", &mass, "--set", &length]);
        let there: Value = serde_json::from_str(&there.out).unwrap();
        for (drawn, mode) in
            grid["nodes"][node]["modes"].as_array().unwrap().iter().zip(there["modes"].as_array().unwrap())
        {
            let [drawn_omega, omega] = [drawn, mode].map(|own| own["omega"].as_f64().unwrap());
            assert!((drawn_omega / omega - 1.0).abs() < 1e-4, "{node}");
            let [a, b] = [numbers(&drawn["shape"]), numbers(&mode["vector"])];
            assert!((a[0] * b[1] - a[1] * b[0]).abs() < 1e-3 * a[0].hypot(a[1]) * b[0].hypot(b[1]), "{node}");
        }
    }
    // Frequencies that cross: each keeps its shape, and its sign. At k = 3 any basis is as good.
    let crossing = "param k = 2\ncoord x, y\nT = 1/2*x'^2 + 1/2*y'^2\nV = 1/2*k*x^2 + 3/2*y^2\n";
    let run_page = with_input(&["show", "-", "--over", "k=1..5:5"], crossing);
    let grid = data(&run_page.out)["grid"].clone();
    assert_eq!(grid["axes"][0]["own"], 0.25);
    for (node, k) in grid["nodes"].as_array().unwrap().iter().zip(1..) {
        let modes = &node["modes"];
        assert!((modes[0]["omega"].as_f64().unwrap() - f64::from(k).sqrt()).abs() < 1e-4);
        assert!((modes[1]["omega"].as_f64().unwrap() - 3_f64.sqrt()).abs() < 1e-4);
        assert_eq!([numbers(&modes[0]["shape"]), numbers(&modes[1]["shape"])], [[1.0, 0.0], [0.0, 1.0]]);
    }
    // No modes where the model has none: said in the data, not a failure.
    let lonely = "param k = 1\ncoord x\nT = 1/2*x'^2\nV = 1/2*x^2 + sqrt(k)*x^4\n";
    let run_page = with_input(&["show", "-", "--over", "k=-1..1:3"], lonely);
    assert_eq!(run_page.status, 0, "{}", run_page.err);
    assert!(data(&run_page.out)["grid"]["nodes"][0].is_null() && data(&run_page.out)["grid"]["nodes"][2].is_object());
    for (ranges, wanted) in [
        (&["k=1..2:3", "k=2..3:3"][..], "`k` can't have two sliders"),
        (&["q=1..2:3"], "`q` can't be moved"),
        (&["k=1..2:1"], "two at least"),
        (&["k=1..2:100000"], "a page has room for"),
        (&["k=1..2"], "NAME=a..b:count"),
        (&["k=1..2:2", "m=1..2:2", "l=1..2:2"], "two sliders"),
    ] {
        let arguments: Vec<&str> =
            ["show", "-"].into_iter().chain(ranges.iter().flat_map(|own| ["--over", own])).collect();
        let refused = with_input(&arguments, crossing);
        assert!(refused.status == 2 && refused.err.contains(wanted), "{ranges:?}: {}", refused.err);
    }
}

/// What a browser makes of a page; nothing where there is no browser.
fn in_browser(page: &str, address: &str) -> Option<(String, String)> {
    let browser = ["chromium", "chromium-browser", "google-chrome"]
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success()))?;
    // Tests run side by side.
    static OPENED: AtomicUsize = AtomicUsize::new(0);
    let own = OPENED.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("librate-show-{}-{own}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("page.html");
    std::fs::write(&file, page).unwrap();
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
            "--disable-background-networking",
            "--enable-logging=stderr",
            "--virtual-time-budget=1000",
            "--dump-dom",
        ])
        .arg(format!("--user-data-dir={}", folder.display()))
        .arg(format!("file://{}#{address}", file.display()))
        .output()
        .unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    Some((String::from_utf8(output.stdout).unwrap(), String::from_utf8_lossy(&output.stderr).into_owned()))
}

/// What a page that stands still has drawn.
fn frame(dom: &str) -> Value {
    let start = dom.find("data-drawn=\"").expect("drawn") + "data-drawn=\"".len();
    let text = dom[start..start + dom[start..].find('"').unwrap()].replace("&quot;", "\"");
    serde_json::from_str(&text).unwrap()
}

#[test]
fn browsers_draw_what_sliders_say() {
    let page = run(&["show", "models/double_pendulum.lag", "--over", "l[2]=0.5..2:4"]).out;
    let Some((dom, log)) = in_browser(&page, "mode=2&t=0&l[2]=1.75") else {
        eprintln!("no browser here: pages are not looked at");
        return;
    };
    assert!(!log.contains("Uncaught") && !log.contains("SyntaxError"), "{log}");
    let drawn = frame(&dom);
    let [first, second] = [0, 1].map(|point| [0, 1].map(|axis| drawn["points"][point][axis].as_f64().unwrap()));
    // The rod is as long as the slider says, and the shape half way between two nodes.
    assert!(((second[0] - first[0]).hypot(second[1] - first[1]) - 1.75).abs() < 1e-9);
    let nodes = &data(&page)["grid"]["nodes"];
    let part =
        |at: usize| -> f64 { [2, 3].iter().map(|node| nodes[node]["modes"][1]["shape"][at].as_f64().unwrap()).sum() };
    let angles = [0, 1].map(|at| drawn["coordinates"][at].as_f64().unwrap());
    assert!((angles[0] * part(1) - angles[1] * part(0)).abs() < 1e-9);
    assert!(dom.contains("≈ "), "the table says that numbers are interpolated");
    // No numbers where there is no equilibrium, and s² between kinds of modes.
    let hoop = "param g = 9.81, R = 1/5, W = 10  coord th  T = 1/2*R^2*(th'^2 + W^2*sin(th)^2)  V = -g*R*cos(th)
        equilibrium th = acos(g/(W^2*R))";
    let hoop = with_input(&["show", "-", "--over", "W=2..20:4"], hoop).out;
    for at in ["2", "5"] {
        let (dom, _) = in_browser(&hoop, &format!("mode=1&t=0&W={at}")).unwrap();
        assert!(dom.contains("No equilibrium or no modes are known here.") && !dom.contains("<td>8.714"), "{at}");
    }
    let pair = "param k = 1  coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*k*x^2 + y^2";
    let pair = with_input(&["show", "-", "--over", "k=-1..3:3"], pair).out;
    for (k, told) in [("-0.36", "unstable, ω ≈ 0.00, growth ≈ 0.600"), ("0.36", "ω ≈ 0.600")] {
        let (dom, _) = in_browser(&pair, &format!("mode=1&t=0&k={k}")).unwrap();
        assert!(dom.contains(told), "{k}: {told}");
    }
}

#[test]
fn browsers_draw_what_was_computed() {
    let page = page("models/double_pendulum.lag");
    for (mode, time, share) in [(1, "0", 1.0), (2, "0.25", 0.0), (2, "0.5", -1.0)] {
        let Some((dom, log)) = in_browser(&page, &format!("mode={mode}&t={time}")) else {
            eprintln!("no browser here: pages are not looked at");
            return;
        };
        assert!(!log.contains("Uncaught") && !log.contains("SyntaxError"), "{log}");
        let drawn = frame(&dom);
        let data = data(&page);
        let shape: Vec<f64> =
            data["modes"][mode - 1]["shape"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        let angles: Vec<f64> = drawn["coordinates"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        // Along the shape, as far as the phase says.
        let far = angles[0] / shape[0];
        assert!((angles[1] - far * shape[1]).abs() < 1e-12, "{angles:?}");
        assert!(
            far.signum() * share >= 0.0 && (share != 0.0 || far.abs() < 1e-12) && (share == 0.0 || far.abs() > 0.01)
        );
        let points = drawn["points"].as_array().unwrap();
        let at = |i: usize, k: usize| points[i][k].as_f64().unwrap();
        let first = [angles[0].sin(), -angles[0].cos()];
        let second = [first[0] + angles[1].sin(), first[1] - angles[1].cos()];
        for k in 0..2 {
            assert!((at(0, k) - first[k]).abs() < 1e-12 && (at(1, k) - second[k]).abs() < 1e-12, "{drawn}");
        }
    }
}

#[test]
fn a_page_is_written_into_a_file_but_not_over_its_model() {
    let folder = std::env::temp_dir().join(format!("librate-page-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let model = folder.join("m.lag");
    std::fs::write(&model, SPRING).unwrap();
    let at = |path: &Path| path.to_str().unwrap().to_owned();
    let refused = run(&["show", &at(&model), "-o", &at(&model)]);
    assert!(refused.status == 1 && refused.err.contains("this command reads that file"), "{}", refused.err);
    let file = folder.join("page.html");
    assert_eq!(printed(&["show", &at(&model), "-o", &at(&file)]), "");
    assert!(std::fs::read_to_string(&file).unwrap().starts_with("<!DOCTYPE html>"));
    std::fs::remove_dir_all(&folder).unwrap();
}
