//! How numbers, shapes and lists of modes are written, for modes that are made up.
#![cfg(feature = "cli")]

use crate::common;

use librate::linearize::{Linearized, linearize};
use librate::modes::{Kind, Options};
use librate::number::Number;
use librate::oscillation::{NormalModes, normal_modes};
use librate::precision::{Ball, Big};
use librate::report::{Style, modes_json, modes_text};

fn oscillators(names: &[&str], options: &Options) -> (Linearized, NormalModes) {
    let squares = |dot: &str| {
        let terms: Vec<String> = names.iter().map(|x| format!("{x}{dot}^2")).collect();
        terms.join(" + ")
    };
    let model =
        common::model(&format!("coord {}  T = 1/2*({})  V = 1/18*({})", names.join(", "), squares("'"), squares("")));
    let linearized = linearize(model).unwrap();
    let modes = normal_modes(&linearized, options).unwrap();
    (linearized, modes)
}

/// The row of the first mode of one coordinate: its frequency and the bound of its error.
fn row(omega: Ball, digits: usize) -> (String, String) {
    let options = Options::default().digits(digits);
    let (linearized, mut modes) = oscillators(&["x"], &options);
    modes.modes[0].omega = omega;
    modes.modes[0].precise = None;
    first(&modes_text(&linearized, &modes, &options, &Style::default()))
}

fn first(text: &str) -> (String, String) {
    let row = text.lines().find(|line| line.starts_with("   1 ")).unwrap();
    let words: Vec<&str> = row.split_whitespace().collect();
    (words[1].to_owned(), words[2].to_owned())
}

#[test]
fn correct_rounding_is_half_a_unit_off_at_most() {
    for (value, digits, bound) in [
        (3.132_091_952_673_165, 10, "5e-10"),
        (2.0, 10, "5e-10"),
        (123_456.0, 6, "5e-1"),
        (123_456.0, 3, "5e2"),
        (1.5e-12, 3, "5e-15"),
        (0.0, 10, "0"),
    ] {
        assert_eq!(row(Ball::from(value), digits).1, bound, "{value}");
    }
    let fewer = row(Ball::from(0.3).with_added_radius(1e-7), 10);
    assert_eq!((fewer.0.as_str(), fewer.1.as_str()), ("0.300000", "5e-7"));
    assert_eq!(row(Ball::NOT_FINITE, 10).0, "?");
    // 1/3, with more digits than balls have, and with more than doubles have exponents.
    for (digits, bound) in [(100, "5e-101"), (330, "5e-324")] {
        let options = Options::default().digits(digits);
        let (linearized, mut modes) = oscillators(&["x"], &options);
        let third = Big::from_number(&Number::ratio(1, 3).unwrap(), 1300);
        modes.modes[0].precise.as_mut().unwrap().omega = third;
        let text = modes_text(&linearized, &modes, &options, &Style::default());
        let (third, own) = first(&text);
        assert_eq!((third, own.as_str()), (format!("0.{}", "3".repeat(digits)), bound));
    }
}

#[test]
fn numbers_are_json() {
    let options = Options::default();
    let (linearized, mut modes) = oscillators(&["x"], &options);
    modes.modes[0].vector = vec![9.81, -0.0, 5e-16, 1e300, f64::NAN, f64::INFINITY];
    modes.modes[0].symmetry = Some("a\"b".to_owned());
    let json = modes_json(&linearized, &modes, &options);
    assert!(json.contains("[9.81, 0.0, 5e-16, 1e300, null, null]"), "{json}");
    assert!(json.contains("\"a\\\"b\""), "{json}");
}

#[test]
fn modes_are_counted_from_one() {
    let names: Vec<String> = (1..41).map(|i| format!("x{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let options = Options::default();
    let (linearized, modes) = oscillators(&names, &options);
    let odd: Vec<usize> = (0..20).map(|i| 2 * i).collect();
    for (zero, want) in [
        (&[2][..], "mode 3 "),
        (&[0, 1], "modes 1 and 2 "),
        (&[0, 1, 2, 3, 4, 5, 6], "modes 1 to 7 "),
        (&[0, 1, 4], "modes 1, 2 and 5 "),
        (&odd, "modes 1, 3, 5, 7, 9 and 15 more "),
    ] {
        let mut modes = modes.clone();
        for at in zero {
            modes.modes[*at].kind = Kind::Zero;
        }
        modes.zero_motions = vec!["translation".to_owned(); 2];
        let text = modes_text(&linearized, &modes, &options, &Style::default());
        assert!(text.lines().any(|line| line.starts_with(want)), "{want}: {text}");
    }
}

#[test]
fn shapes_name_their_largest_components() {
    let options = Options::default();
    // Too many for a column each.
    let names = ["a", "b", "c", "d", "e", "f", "g"].map(|name| name.repeat(24));
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let (linearized, mut modes) = oscillators(&names, &options);
    modes.modes[0].vector = vec![0.1, -0.7, 0.699_999_999_999_999_9, 1e-17, 0.0, 0.0, 0.0];
    modes.modes[0].vector_error_bound = 1e-15;
    let shapes: Vec<String> = (70..170)
        .map(|width| {
            let text = modes_text(&linearized, &modes, &options, &Style::default().width(width));
            let row = text.lines().find(|line| line.starts_with("   1 ")).unwrap();
            let shape = row.split_once("oscillation").unwrap().1;
            let below = || text.lines().rfind(|line| line.starts_with("   1 ")).unwrap().trim_start_matches("   1");
            let shape = if shape.trim().is_empty() { below() } else { shape };
            // Behind the heights of all components.
            let (heights, largest) = shape.trim().split_once("  ").unwrap();
            assert_eq!(heights, "▅▁█▄▄▄▄");
            largest.to_owned()
        })
        .collect();
    let [a, b, c] = [0, 1, 2].map(|at: usize| names[at]);
    let all = format!("{b} -0.70, {c} 0.70, {a} 0.10");
    let two = format!("{b} -0.70, {c} 0.70, …");
    let one = format!("{b} -0.70, …");
    for want in [all, two, one] {
        assert!(shapes.contains(&want), "{want}: {shapes:#?}");
    }
}

#[test]
fn lists_flow_into_lines() {
    let options = Options::default();
    let (linearized, mut modes) = oscillators(&["x"], &options);
    modes.modes[0].kind = Kind::Zero;
    modes.zero_motions = ["turn a", "turn b", "turn c"].map(str::to_owned).to_vec();
    let text = |width| modes_text(&linearized, &modes, &options, &Style::default().width(width));
    let title = "mode 1 represents:\n";
    assert!(text(18).contains(&format!("{title}  turn a, turn b,\n  turn c\n")), "{}", text(18));
    assert!(text(1).contains(&format!("{title}  turn a,\n  turn b,\n  turn c\n")));
}
