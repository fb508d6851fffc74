//! Frequencies over a range of a parameter.
#![cfg(feature = "cli")]

use crate::cli_support;

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use cli_support::*;
use librate::Source;
use librate::linearize::constant;
use librate::model::{Range, Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::report::SweepRow;
use librate::sweep::Sweep;
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
    // What is assumed of the parameter holds at the ends, and not between.
    let file = folder("assumed").join("model.lag");
    fs::write(&file, "param c = 2 assume (c - 1)^2 > 1/2 coord x T = 1/2*x'^2 V = 1/2*c*x^2").unwrap();
    let assumed = run(&["sweep", file.to_str().unwrap(), "--over", "c=0..2:21"]);
    let lines: Vec<&str> = assumed.out.lines().collect();
    assert_eq!((lines[1], lines[11], lines[21]), ("0.0,0", "1.0,", "2.0,1.414213562"));
    assert!(assumed.err.contains("at c = 0.3: this assumption does not hold"), "{}", assumed.err);
}

#[test]
fn what_is_no_range_is_refused() {
    for (text, word) in [
        ("k", "NAME=a..b:count"),
        ("k=1..2", "NAME=a..b:count"),
        ("k=1:2", "NAME=a..b:count"),
        ("k=1..2:0", "1 to 1000000"),
        ("k=1..2:1e9", "1 to 1000000"),
        ("k=1..2:1.5", "whole number"),
        ("k=1..2:3000000", "1 to 1000000"),
        ("k=1..x:3", "without names such as `x`"),
        ("k=1/0..2:3", "divisor 0"),
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
    assert_eq!(Range::parse("k=1..2:1e2").unwrap().len(), 100);
    // Parts beyond the range of doubles.
    let range = Range::parse("k=1..2*exp(800)/(exp(800) + 1):2").unwrap();
    assert_eq!(range.value(1), Some(2.0));
    // Up to the largest double.
    let far =
        with_input(&["sweep", "-", "--over", "k=1e300..1.5e308:2"], "param k = 1  coord x  T = x'^2/2  V = k*x^2/2");
    assert_eq!(far.out, "k,omega1\n1e300,1.000000000e150\n1.5e308,1.224744871e154\n", "{}", far.err);
    assert!(Range::parse("k=1..2e308:2").unwrap_err().to_string().contains("too large a one"));
    let range = Range::parse("W=sqrt(2)..pi:3").unwrap();
    assert_eq!(range.value(0), Some(2.0_f64.sqrt()));
    assert_eq!(range.value(2), Some(std::f64::consts::PI));
    assert_eq!(range.value(3), None);
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sweep").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// What doubles with bounds decide is what certified modes have, for a parameter of each model.
#[test]
fn quick_lines_are_certified_ones() {
    let (mut quick, mut models) = (0, 0);
    for path in fs::read_dir("models").unwrap() {
        let path = path.unwrap().path();
        if path.extension().is_none_or(|end| end != "lag") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let file = librate::syntax::parse(&text).unwrap();
        let Ok(model) = elaborate(&file, &TableTexts::new(), &Settings::new()) else { continue };
        for name in ["k", "m", "g", "l[1]", "k12", "W"] {
            let Some(parameter) = model.parameters.iter().find(|own| own.name == name && own.value.is_some()) else {
                continue;
            };
            let value = constant(&model.pool, parameter.value.unwrap()).unwrap().mid_f64();
            // Numbers that are no doubles, past both sides of where some models lose their stability.
            let range = Range::parse(&format!("{name}={value}/3..{value}*16/3:31")).unwrap();
            let options = Options::default();
            let source = Source { file: file.clone(), tables: TableTexts::new(), settings: Settings::new() };
            let sweep = Sweep::new(source, range, options);
            let Some(_) = sweep.derived().filter(|model| model.coordinates.len() <= 8) else { continue };
            models += 1;
            let places = [0, 1, 4, 13, 30];
            for (place, enclosed) in places.iter().zip(sweep.worker().enclosed(&places)) {
                assert_eq!(Some(sweep.value(*place)), sweep.range().value(*place));
                let Some(row) = enclosed.and_then(|modes| SweepRow::enclosed(sweep.value(*place), &modes, 10)) else {
                    continue;
                };
                let certified = sweep.place(*place);
                let certified = SweepRow::new(certified.value, &certified.result.unwrap().1, 10);
                assert_eq!(row, certified, "{} {name} {place}", path.display());
                quick += 1;
            }
        }
    }
    assert!(models > 20 && quick > 4 * models, "{quick} of {models}");
}

#[test]
fn any_number_of_threads_writes_the_same_bytes() {
    for over in ["g=1..20:40", "N=2..17:16"] {
        let model = if over.starts_with('g') { PENDULUMS } else { "models/chain_walls.lag" };
        for more in [&[][..], &["--json"]] {
            let of = |threads| {
                let over = ["sweep", model, "--over", over, "--threads", threads];
                let run = run(&[&over, more].concat());
                assert_eq!(run.status, 0, "{}", run.err);
                (run.out, run.err)
            };
            let one = of("1");
            assert_eq!(one, of("3"));
            assert_eq!(one, of("64"));
        }
    }
}

#[test]
fn parts_make_the_whole() {
    let whole = printed(&["sweep", PENDULUMS, "--over", "k12=0..8:17"]);
    for count in [1, 2, 5, 17, 20] {
        let parts = (1..=count).map(|part| {
            let part = format!("{part}/{count}");
            printed(&["sweep", PENDULUMS, "--over", "k12=0..8:17", "--part", &part])
        });
        assert_eq!(parts.collect::<String>(), whole, "{count}");
    }
    for wrong in ["0/3", "4/3", "1", "1/0", "a/b", "1/2/3", "-1/2", "1/9999999"] {
        let run = run(&["sweep", PENDULUMS, "--over", "k12=0..8:17", "--part", wrong]);
        assert_eq!((run.status, run.out.as_str()), (2, ""), "{wrong}");
    }
    let json = run(&["sweep", PENDULUMS, "--over", "k12=0..8:17", "--json", "--part", "1/2"]);
    assert_eq!(json.status, 2);
}

#[test]
fn columns_of_long_tables_come_from_a_few_values() {
    // Unstable between 3.2 and 3.4, which none of nine values is.
    let text = "param W = 1  coord x  T = x'^2/2  V = ((W - 33/10)^2 - 1/100)*x^2/2";
    let over = ["sweep", "-", "--over", "W=0..10:101", "--digits", "3"];
    let whole = with_input(&over, text);
    assert!(whole.out.starts_with("W,omega1,growth1\n") && whole.err.is_empty(), "{}", whole.err);
    assert!(whole.out.contains("\n3.3,0,0.100\n"), "{}", whole.out);
    let part = with_input(&[&over[..], &["--part", "1/1"]].concat(), text);
    assert!(part.out.starts_with("W,omega1\n") && part.out.contains("\n3.3,\n3.4,0\n"), "{}", part.out);
    assert_eq!(part.status, 0);
    let told = "at W = 3.3: there are modes or growth that the table has no columns for";
    assert!(part.err.contains(told) && part.err.matches("at W").count() == 1, "{}", part.err);
    let all = with_input(&[&over[..], &["--part", "1/1", "--growth"]].concat(), text);
    assert_eq!((all.out, all.err), (whole.out, whole.err));
    let no_modes = with_input(&["sweep", "-", "--over", "W=1..10:5000"], "param W = 1  coord x  T = x'^2  V = W*x");
    assert_eq!((no_modes.status, no_modes.out.as_str()), (1, ""));
}

#[test]
fn a_table_that_was_cut_is_continued() {
    let folder = folder("resumed");
    let file = folder.join("out.csv");
    let path = file.to_str().unwrap();
    let over = ["sweep", PENDULUMS, "--over", "m[2]=1..4:12"];
    let whole = printed(&over);
    let resume = [&over[..], &["--resume", path]].concat();
    let header = whole.find('\n').unwrap() + 1;
    let second = header + whole[header..].find('\n').unwrap() + 1;
    for cut in
        [0, 1, 7, header - 1, header, header + 2, second - 1, second, second + 1, 200, whole.len() - 1, whole.len()]
    {
        fs::write(&file, &whole[..cut]).unwrap();
        assert_eq!(printed(&resume), "");
        assert_eq!(fs::read_to_string(&file).unwrap(), whole, "{cut}");
    }
    fs::remove_file(&file).unwrap();
    printed(&resume);
    assert_eq!(fs::read_to_string(&file).unwrap(), whole);
    // A part without a header, and one that is empty.
    for (part, shown) in [("2/3", 4), ("1/100", 1)] {
        let own = printed(&[&over[..], &["--part", part]].concat());
        assert_eq!(own.lines().count(), shown);
        fs::write(&file, &own[..own.len() / 2]).unwrap();
        printed(&[&resume[..], &["--part", part]].concat());
        assert_eq!(fs::read_to_string(&file).unwrap(), own, "{part}");
    }
}

#[test]
fn what_is_another_table_is_not_continued() {
    let folder = folder("refused");
    let file = folder.join("out.csv");
    let path = file.to_str().unwrap();
    let over = ["sweep", PENDULUMS, "--over", "k12=0..8:17"];
    let whole = printed(&over);
    let refused = |text: &str, more: &[&str], reason: &str| {
        fs::write(&file, text).unwrap();
        let run = run(&[&over[..], &["--resume", path], more].concat());
        assert_eq!((run.status, run.out.as_str()), (1, ""), "{reason}");
        assert!(run.err.contains("can't go on with") && run.err.contains(reason), "{}", run.err);
        assert_eq!(fs::read_to_string(&file).unwrap(), text);
    };
    refused(&whole.replacen("k12", "k23", 1), &[], "line 1 is not the header of a sweep over k12");
    refused("k12,omega1,omega3\n", &[], "line 1 is not the header");
    refused(&whole[whole.find('\n').unwrap() + 1..], &[], "line 1 is not the header");
    refused(&whole, &["--part", "2/2"], "line 1 does not begin with 4.0, the value of k12 there");
    refused(&whole, &["--part", "1/2"], "line 10 is beyond the last value");
    refused(&format!("{whole}8.0,1,2,3\n"), &[], "line 19 is beyond the last value");
    refused(&whole.replacen("\n0.5,", "\n0.5,1,", 1), &[], "line 3 has 5 cells");
    refused(&whole.replacen("\n0.5,", "\n0.25,", 1), &[], "line 3 does not begin with 0.5");
    for other in [&["--set", "g=10"][..], &["--digits", "9"]] {
        refused(&whole, other, "what it has for k12 = 8 is not what this model and these options give");
    }
}

#[test]
fn lines_are_written_as_they_are_made() {
    // All of them would take minutes.
    let mut child = command(&["sweep", "models/double_pendulum.lag", "--over", "g=1..2:1000000"]).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert_eq!(lines.next().unwrap().unwrap(), "g,omega1,omega2");
    assert!(lines.take(100).all(|line| line.unwrap().split(',').count() == 3));
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn the_budget_is_that_of_a_value() {
    let over = ["sweep", "models/chain_walls.lag", "--set", "N=41", "--over", "k=1..2:60", "--threads", "1"];
    let start = std::time::Instant::now();
    let long = run(&[&over[..], &["--budget", "1s"]].concat());
    assert_eq!((long.status, long.err.as_str()), (0, ""), "{:?}", start.elapsed());
    assert_eq!(long.out.lines().count(), 61);
}
