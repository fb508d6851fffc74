//! Mistakes and warnings on standard error: drawn for people, as JSON for programs.
#![cfg(feature = "cli")]

use crate::cli_support;

use cli_support::*;
use serde_json::Value;

const SUSPICIOUS: &str = "\
param _spare = 1
param k = 2  param g = 9.81
param N = 3.0
let twice = 2*k
coord x[1..N], y, free
T = sum(i in 1..N, 1/2*x[i]'^2) + 1/2*y'^2 + 1/2*free'^2
V = 1/2*k*y^2 + sum(i in 1..N, x[i]^2)
";

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn warnings_are_drawn_and_the_result_printed() {
    for command in ["check", "modes", "derive"] {
        let run = with_input(&[command, "-"], SUSPICIOUS);
        assert_eq!(run.status, 0, "{command}: {}", run.err);
        assert!(!run.out.is_empty());
        if command == "check" {
            insta::assert_snapshot!(run.err);
        }
        for name in ["`g`", "`twice`", "`free`", "`3.0`"] {
            assert!(run.err.contains(name), "{command} says nothing of {name}");
        }
        assert!(!run.err.contains("_spare"));
        assert!(!run.err.contains("error"));
    }
}

#[test]
fn an_equilibrium_that_runs_away_is_remarked_unless_it_was_given() {
    let falling = "coord x, y  T = 1/2*x'^2 + 1/2*y'^2  V = -x^2 ";
    let code = |model: String| {
        let run = with_input(&["modes", "-", "--message-format", "json"], &model);
        assert_eq!(run.status, 0);
        let codes = lines(&run.err);
        codes.iter().map(|line| line["code"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(code(format!("{falling} - y^2")), ["W0101"]);
    assert_eq!(code(format!("{falling} + y^2")), ["W0102"]);
    let given = "equilibrium x = 0  equilibrium y = 0";
    assert!(code(format!("{falling} + y^2 {given}")).is_empty());
    // With friction, magnetic terms and forces as without, where the potential falls.
    assert_eq!(code(format!("{falling} - y^2  dissipation = 0.1*x'^2")), ["W0101"]);
    assert_eq!(code(format!("{falling} + y^2  force y = -0.1*y'")), ["W0102"]);
    assert_eq!(code("coord x, y  lagrangian = x'^2 + y'^2 + 0.1*x*y' + x^2 - y^2".to_owned()), ["W0102"]);
    assert!(code("coord x, y  lagrangian = x'^2 + y'^2 + 9*x*y' + x^2 + y^2".to_owned()).is_empty());
    assert!(code("coord x, y  T = x'^2 + y'^2  V = x^2 + y^2  force x = 9*y  force y = -9*x".to_owned()).is_empty());
}

#[test]
fn the_coordinate_that_moves_away_is_named_without_vectors_too() {
    let saddle = "coord x, y  T = 1/2*x'^2 + 1/2*y'^2  V = x^2 - y^2";
    let damped = format!("{saddle}  dissipation = 0.1*x'^2");
    let tied = "coord z, x, y  T = 1/2*(x'^2 + y'^2 + z'^2)  V = x^2 - y^2  constraint z = x";
    for (model, line) in [(saddle, "modes -"), (&damped, "modes -"), (tied, "modes -"), (saddle, "modes - --lowest 1")]
    {
        let run = with_input(&format!("{line} --no-vectors").split(' ').collect::<Vec<_>>(), model);
        assert!(run.err.contains("[W0102]") && run.err.contains("`y` moves away from it"), "{model}: {}", run.err);
    }
    let maximum = with_input(&["modes", "-", "--lowest", "1"], "coord x, y  T = x'^2 + y'^2  V = -x^2 - y^2");
    assert!(maximum.err.contains("[W0101]"), "{}", maximum.err);
}

#[test]
fn names_are_no_values_on_the_command_line() {
    for (line, name) in [
        ("period - --amplitude x", "x"),
        ("period - --amplitude k", "k"),
        ("motion - --start x=x --until 1 --samples 2", "x"),
        ("motion - --start x=k --until 1 --samples 2", "k"),
        ("motion - --start x=1 --until x --samples 2", "x"),
        ("equilibria - --box x=-x..x", "x"),
        ("modes - --set k=2*k", "k"),
        ("modes - --set k=t", "t"),
        ("sweep - --over k=0..k:2", "k"),
    ] {
        let run = with_input(&line.split(' ').collect::<Vec<_>>(), "param k = 4  coord x  T = 1/2*x'^2  V = k*x^2");
        let said = format!("values are numbers, without names such as `{name}`");
        assert!(run.status != 0 && run.err.contains(&said), "{line}: {}", run.err);
    }
}

#[test]
fn classes_and_reasons_are_those_of_the_model() {
    let run = |line: &str, model: &str| with_input(&line.split(' ').collect::<Vec<_>>(), model);
    let pair = "param c = 0.1  coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*(x^2 + y^2 + (x - y)^2) ";
    let friction = format!("{pair} dissipation = 1/2*c*(x'^2 + y'^2)");
    let turning = "coord x, y  lagrangian = 1/2*(x'^2 + y'^2) + x*y' - y*x' - x^2 - 2*y^2";
    for model in [friction.as_str(), turning] {
        let classes = |line: &str| {
            let json: serde_json::Value = serde_json::from_str(&run(line, model).out).unwrap();
            let modes = json["modes"].as_array().unwrap().clone();
            modes.iter().map(|mode| mode["symmetry"].clone()).collect::<Vec<_>>()
        };
        assert_eq!(classes("modes - --json --no-vectors"), classes("modes - --json"), "{model}");
    }
    let free = "param c = 1  coord x  T = 1/2*x'^2  V = 0  dissipation = 1/2*c*x'^2";
    let response = run("response - --input x --over omega=0..1:2", free);
    assert!(
        response.err.contains("nothing holds the model") && !response.err.contains("resonance"),
        "{}",
        response.err
    );
    let other = run("response - --input x --output zz --over omega=0..1:2", free);
    assert!(other.err.contains("--output 'x'`"), "{}", other.err);
    let page = run("derive -", "param i = 2, k = 3  coord x  T = 1/2*x'^2  V = 1/2*k*x^2  dissipation = 1/2*i*x'^2");
    assert!(page.out.contains("-1.000000000 ± 1.414213562 j"), "{}", page.out);
    assert_eq!(page.out.matches("imaginary unit").count(), 1);
}

#[test]
fn negative_numbers_are_values_of_options() {
    for (line, said) in [
        ("modes - --lowest -1", "a whole number, 1 or more, is needed"),
        ("modes - --near -1 --count 1", "a frequency in rad/s, 0 or more, is needed"),
        ("modes - --budget -1s", "a time, a memory or both are needed"),
        ("motion - --start x=1 --until 1 --samples -1", "a whole number, 1 or more, is needed"),
        ("inertia - --mass -1", "the mass must be a positive number"),
        ("derive - --expand k -1", "`-1` is not a power"),
        ("plot sweep - --over k=1..2:3 --orders -1", "a frequency in rad/s, 0 or more, is needed"),
    ] {
        let run = with_input(&line.split(' ').collect::<Vec<_>>(), "param k = 1  coord x  T = 1/2*x'^2  V = k*x^2");
        assert!(run.status != 0 && run.err.contains(said) && !run.err.contains("tip"), "{line}: {}", run.err);
    }
}

#[test]
fn all_mistakes_are_told_beside_those_of_syntax() {
    let codes = |model: &str| {
        let run = with_input(&["check", "-", "--message-format", "json"], model);
        lines(&run.err).iter().map(|line| line["code"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let twice = "param a = 1  param a = 2  coord x  T = 1/2*x'^2  V = 1/2 x^2 + sin(x, x) + acs(x)";
    assert_eq!(codes(twice), ["E0103", "E0007"]);
    let apart = "param a = 1/2 b  param a = 2  coord x  T = 1/2*x'^2  V = 1/2*x^2 + sin(x, x) + acs(x)";
    assert_eq!(codes(apart), ["E0007", "E0113", "E0102"]);
    // What follows from the broken one is not.
    assert_eq!(codes("param k = 1/2 b  coord x  T = 1/2*x'^2  V = 1/2*k*x^2"), ["E0007"]);
    assert_eq!(codes("let u[0] = 2 3  let u[i in 1..2] = u[i-1]  coord x  T = 1/2*x'^2  V = u[0]*x^2"), ["E0008"]);
    assert_eq!(codes("coord x  T = 1/2 x'^2  V = 1/2*x^2"), ["E0007"]);
    let family = "pram n = 4  coord x[1..n]  let y[0] = 0  let y[k in 1..n] = y[k-1] + x[k]
        T = sum(k in 1..n, 1/2*y[k]'^2)  V = sum(k in 1..n, y[k]^2)";
    assert_eq!(codes(family), ["E0002"]);
}

#[test]
fn what_can_not_be_set_and_where_filters_stand_is_told() {
    let model = "param k = 2  coord x  let s = 3*x  T = 1/2*x'^2  V = 1/2*k*s^2";
    let help = |model: &str, more: &[&str]| with_input(&[&["modes", "-"], more].concat(), model).err;
    assert!(help(model, &["--set", "x=1"]).contains("it is a coordinate: write `guess x = …`"));
    assert!(help(model, &["--set", "s=1"]).contains("`s` follows from others"));
    assert!(help(model, &["--set", "kk=1"]).contains("did you mean `k`?"));
    let filter = "coord x[1..3]  T = 1/2*dot(x', x')  V = sum(i in 1..3 where i != 2, j in 1..3, x[i]*x[j])";
    assert!(help(filter, &[]).contains("then the filter"));
}

#[test]
fn a_period_without_time_is_told() {
    let warned = |rest: &str| {
        let model = format!("param W = 2  coord x  T = 1/2*x'^2  {rest}");
        let run = with_input(&["check", "-", "--message-format", "json"], &model);
        assert_eq!(run.status, 0, "{}", run.err);
        lines(&run.err).iter().any(|line| line["code"] == "W0008")
    };
    assert!(warned("V = 1/2*W*x^2  period 2*pi/W"));
    assert!(warned("V = 1/2*W*x^2  dissipation = x'^2  period 2*pi/W"));
    assert!(!warned("V = 1/2*x^2*cos(W*t)  period 2*pi/W"));
    assert!(!warned("let f = cos(W*t)  V = 1/2*x^2*f  period 2*pi/W"));
    assert!(!warned("V = x^2  dissipation = (1 + cos(W*t)/2)*x'^2  period 2*pi/W"));
    assert!(!warned("V = 1/2*W*x^2"));
}

#[test]
fn a_guessed_velocity_has_the_unit_of_one() {
    let model = "coord x : cm  param m : kg = 1  param k : N/m = 2  T = 1/2*m*x'^2  V = 1/2*k*x^2*cos(t/1)
        guess x' : m = 1";
    let run = with_input(&["check", "-", "--message-format", "json"], model);
    let wrong = lines(&run.err).into_iter().find(|line| line["code"] == "E0205").expect("a length is no velocity");
    let message = wrong["message"].as_str().unwrap_or_default();
    assert!(message.contains("`x'` is a velocity"), "{message}");
}

/// A statement that can't be read may declare what others use.
#[test]
fn what_cannot_be_read_may_declare_names() {
    let model = "param k = 2 m\ncoord x\nT = 1/2*x'^2\nV = 1/2*k*x^2 + q\n";
    let run = with_input(&["--message-format", "json", "check", "-"], model);
    let all = lines(&run.err);
    let messages: Vec<&str> = all.iter().filter_map(|line| line["message"].as_str()).collect();
    assert_eq!(messages.len(), 2, "{}", run.err);
    assert_eq!(messages[1], "`q` is not declared");
}

#[test]
fn messages_for_programs() {
    let model = "coord x\nT = 1/2*m*x'^2\nV = 1/2*x^2 + 2 x\n# ü\nlet ä = öde*2\n";
    for format in ["--message-format=json", "--message-format=text"] {
        let run = with_input(&["modes", "-", format], model);
        assert_eq!((run.status, run.out.as_str()), (1, ""));
    }
    let run = with_input(&["--message-format", "json", "modes", "-"], model);
    let all = lines(&run.err);
    // Names that nothing declares are told beside what can't be read.
    let codes: Vec<&str> = all.iter().filter_map(|line| line["code"].as_str()).collect();
    assert_eq!(codes, ["E0101", "E0007", "E0101"], "{}", run.err);
    let one = &all[1];
    assert_eq!(one["severity"], "error");
    assert_eq!(one["code"], "E0007");
    assert_eq!(one["file"], "<stdin>");
    assert_eq!(one["message"], "the multiplication sign is missing");
    let (start, end) =
        (one["primary"]["start"].as_u64().unwrap() as usize, one["primary"]["end"].as_u64().unwrap() as usize);
    assert_eq!(&model[start..end], "2 x");
    assert_eq!(one["primary"]["line"], 3);
    assert_eq!(one["primary"]["column"], 15);
    assert_eq!(one["primary"]["end_column"], 18);

    let run = with_input(&["check", "-", "--message-format", "json"], &model.replace("2 x", "2*x"));
    let all = lines(&run.err);
    assert_eq!(all.len(), 2, "{}", run.err);
    assert_eq!(all[0]["primary"]["line"], 2);
    // Columns count characters.
    assert_eq!((&all[1]["code"], &all[1]["primary"]["line"]), (&"E0101".into(), &5.into()));
    assert_eq!(all[1]["primary"]["column"], 9);

    let run = run_json_failure(&["modes", "no_such_file.lag"]);
    assert_eq!(run["file"], Value::Null);
    assert_eq!(run["primary"], Value::Null);
}

fn run_json_failure(arguments: &[&str]) -> Value {
    let mut all = arguments.to_vec();
    all.extend(["--message-format", "json"]);
    let run = run(&all);
    assert_eq!(run.status, 1);
    serde_json::from_str(&run.err).unwrap()
}

#[test]
fn second_places_are_told() {
    let model = "param a : m = 1  coord x : m  T = 1/2*a*x'^2\nparam a : m = 2";
    let run = with_input(&["check", "-", "--message-format", "json"], model);
    let all = lines(&run.err);
    let twice = all.iter().find(|line| line["code"] == "E0103").unwrap();
    assert_eq!(twice["secondary"][0]["line"], 1);
    assert_eq!(twice["secondary"][0]["label"], "first given here");
}

#[test]
fn endless_names_do_not_flood_the_terminal() {
    let name = "x".repeat(1_000_000);
    for model in [
        name.clone(),
        format!("coord y  T = 1/2*y'^2 + {name}"),
        format!("coord y  T = 1/2*y'^2  V = {name}(y)"),
        format!("coord {name}  coord {name}"),
    ] {
        for format in ["text", "json"] {
            let run = with_input(&["check", "-", "--message-format", format], &model);
            assert_eq!(run.status, 1);
            assert!(run.err.len() < 3000, "{} bytes", run.err.len());
        }
    }
}

#[test]
fn starts_are_given_by_members_with_commas() {
    for (start, said) in [
        ("x[1]=1;x[2]'=2", "several values are separated by commas"),
        ("x[1]=1 x[2]=2", "several values are separated by commas"),
        ("x=1", "did you mean `x[1]`?"),
        ("x'=1", "did you mean `x[1]'`?"),
    ] {
        let motion = ["motion", "-", "--until", "1", "--samples", "2", "--start", start];
        let run = with_input(&motion, "coord x[1..2]  T = 1/2*dot(x', x')  V = dot(x, x)");
        assert!(run.status == 1 && run.err.contains(said), "{start}: {}", run.err);
    }
}

/// What needs accelerations refuses coordinates without inertia, whether springs or friction hold them.
#[test]
fn what_needs_accelerations_refuses_coordinates_without_inertia() {
    let springs = "coord x, y  T = 1/2*x'^2  V = y^2 + (x - y)^2";
    let friction = "coord x, y  T = 1/2*x'^2  V = x^2 + (x - y)^2  dissipation = 1/2*y'^2";
    let motion = ["motion", "-", "--until", "1", "--samples", "2", "--start", "x=0.1"];
    let code = ["export", "-", "--code", "c"];
    for (arguments, text) in [
        (&motion[..], springs),
        (&motion[..], friction),
        (&code[..], springs),
        (&code[..], friction),
        (&["amplitude", "-"][..], springs),
    ] {
        let run = with_input(arguments, text);
        assert_eq!(run.status, 1, "{arguments:?} {text}");
        assert!(run.err.contains("E0308") && run.err.contains("no inertia"), "{arguments:?} {text}: {}", run.err);
    }
}
