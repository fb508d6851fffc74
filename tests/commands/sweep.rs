//! Frequencies over a range of a parameter.
#![cfg(feature = "cli")]

use crate::cli_support;

use cli_support::*;
use librate::model::Range;
use serde_json::Value;

#[test]
fn each_place_is_what_a_setting_gives() {
    let csv = run(&["sweep", "models/three_pendulums.lag", "--over", "k12=0..8:5"]);
    assert_eq!(csv.status, 0, "{}", csv.err);
    let lines: Vec<Vec<&str>> = csv.out.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(lines[0], ["k12", "omega1", "omega2", "omega3"]);
    assert_eq!(lines.len(), 6);
    for line in &lines[1..] {
        let set = format!("k12={}", line[0]);
        let modes = run(&["modes", "models/three_pendulums.lag", "--json", "--set", &set]);
        let modes: Value = serde_json::from_str(&modes.out).unwrap();
        for (cell, mode) in line[1..].iter().zip(modes["modes"].as_array().unwrap()) {
            assert_eq!(*cell, mode["omega_digits"].as_str().unwrap());
        }
    }
}

#[test]
fn growth_has_columns_where_there_is_some() {
    // omega² = W² sin² - …: the bottom of the hoop is unstable beyond W² = g/R = 49.05.
    let csv = run(&["sweep", "models/bead_on_hoop_bottom.lag", "--over", "W=0..10:2", "--digits", "5"]);
    assert_eq!(csv.status, 0, "{}", csv.err);
    assert_eq!(csv.out, "W,omega1,growth1\n0.0,7.0036,0\n10.0,0,7.1379\n");
}

#[test]
fn json_has_the_modes_at_each_value() {
    let over = ["sweep", "models/three_pendulums.lag", "--over", "m[2]=1..4:4", "--json"];
    let found: Value = serde_json::from_str(&run(&over).out).unwrap();
    let places = found.as_array().unwrap();
    assert_eq!(places.len(), 4);
    for (at, place) in places.iter().enumerate() {
        assert_eq!(place["m[2]"], (at + 1) as f64);
        assert_eq!(place["modes"].as_array().unwrap().len(), 3);
        assert_eq!(place["model"], "three_pendulums");
    }
}

#[test]
fn places_without_modes_are_empty_and_told() {
    let csv = run(&["sweep", "models/chain_walls.lag", "--over", "N=1..3:5", "--lowest", "1"]);
    assert_eq!(csv.status, 0);
    let cells: Vec<&str> = csv.out.lines().map(|line| line.split_once(',').unwrap().1).collect();
    assert_eq!(cells[2], "");
    assert!(cells[1].starts_with("1.414") && cells[3].starts_with("1.000"), "{cells:?}");
    assert!(csv.err.contains("at N = 1.5: 3/2 is not a whole number"), "{}", csv.err);
    let none = run(&["sweep", "models/chain_walls.lag", "--over", "N=1/3..1/2:2"]);
    assert_eq!((none.status, none.out.as_str()), (1, ""));
}

#[test]
fn what_is_no_range_is_refused() {
    for (text, word) in [
        ("k", "NAME=a..b:count"),
        ("k=1..2", "NAME=a..b:count"),
        ("k=1:2", "NAME=a..b:count"),
        ("k=1..2:0", "1 to 1000000"),
        ("k=1..2:1e9", "whole number"),
        ("k=1..2:3000000", "1 to 1000000"),
        ("k=1..x:3", "`x` is not a constant"),
        ("k=1/0..2:3", "not a constant"),
        ("k=1) + (2..3:4", ""),
        ("=1..2:3", ""),
    ] {
        let error = Range::parse(text).unwrap_err().to_string();
        assert!(error.contains(word), "{text}: {error}");
        let refused = run(&["sweep", "models/chain_walls.lag", "--over", text]);
        assert_eq!((refused.status, refused.out.as_str()), (2, ""), "{text}");
    }
    let unknown = run(&["sweep", "models/chain_walls.lag", "--over", "zeta=1..2:3"]);
    assert_eq!((unknown.status, unknown.out.as_str()), (1, ""));
    // Parts beyond the range of doubles.
    let range = Range::parse("k=1..2*exp(800)/(exp(800) + 1):2").unwrap();
    assert_eq!(range.value(1), Some(2.0));
    let range = Range::parse("W=sqrt(2)..pi:3").unwrap();
    assert_eq!(range.value(0), Some(2.0_f64.sqrt()));
    assert_eq!(range.value(2), Some(std::f64::consts::PI));
    assert_eq!(range.value(3), None);
}
