//! What is printed as JSON is what the published schemas say, for every model and every mistake.
#![cfg(feature = "cli")]

use crate::cli_support;

use boon::{Compiler, SchemaIndex, Schemas};
use cli_support::*;
use serde_json::Value;

struct Schema {
    all: Schemas,
    index: SchemaIndex,
}

impl Schema {
    fn read(name: &str) -> Self {
        let mut all = Schemas::new();
        let mut compiler = Compiler::new();
        let index = compiler.compile(&format!("schema/{name}.schema.json"), &mut all).unwrap();
        Self { all, index }
    }

    fn check(&self, what: &str, value: &Value) {
        if let Err(error) = self.all.validate(value, self.index) {
            panic!("{what}: {error}");
        }
    }

    fn refuses(&self, value: &Value) -> bool {
        self.all.validate(value, self.index).is_err()
    }
}

fn files(folder: &str) -> Vec<String> {
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path().display().to_string())
        .filter(|path| path.ends_with(".lag"))
        .collect();
    files.sort();
    assert!(files.len() > 5);
    files
}

#[test]
fn modes_and_derivations_of_all_models() {
    let modes = Schema::read("modes");
    let derive = Schema::read("derive");
    let floquet = Schema::read("floquet");
    let (mut checked, mut driven) = (0, 0);
    for file in files("models") {
        let multipliers = run(&["floquet", &file, "--json"]);
        if multipliers.status == 0 {
            driven += 1;
            let value: Value = serde_json::from_str(&multipliers.out).unwrap();
            floquet.check(&file, &value);
            let count = value["coordinates"].as_array().unwrap().len();
            for key in ["multipliers", "moduli", "circle", "exponents"] {
                assert_eq!(value[key].as_array().unwrap().len(), 2 * count, "{file}");
            }
            let mut bad = value;
            bad["stable"] = "yes".into();
            assert!(floquet.refuses(&bad));
        }
        let run_modes = run(&["modes", &file, "--json", "--lowest", "20"]);
        if run_modes.status != 0 {
            continue;
        }
        checked += 1;
        let value: Value = serde_json::from_str(&run_modes.out).unwrap();
        modes.check(&file, &value);
        let count = value["coordinates"].as_array().unwrap().len();
        assert_eq!(value["equilibrium"].as_array().unwrap().len(), count);
        for mode in value["modes"].as_array().unwrap() {
            assert_eq!(mode["vector"].as_array().unwrap().len(), count, "{file}");
        }
        let tied = std::fs::read_to_string(&file).unwrap().contains("\nconstraint ");
        if count <= 12 && !tied {
            let only = run(&["derive", &file, "--json", "--only", "mass"]);
            let run = run(&["derive", &file, "--json"]);
            assert_eq!(run.status, 0, "{file}: {}", run.err);
            let value: Value = serde_json::from_str(&run.out).unwrap();
            derive.check(&file, &value);
            derive.check(&file, &serde_json::from_str(&only.out).unwrap());
            assert_eq!(value["mass"].as_array().unwrap().len(), count);
        }
    }
    assert!(checked > 40);
    assert!(driven > 5);
}

#[test]
fn messages_about_all_mistakes() {
    let schema = Schema::read("diagnostic");
    let mut checked = 0;
    for file in files("tests/errors").into_iter().chain(files("tests/syntax_errors")) {
        let run = run(&["modes", &file, "--message-format", "json"]);
        for line in run.err.lines() {
            let value: Value = serde_json::from_str(line).unwrap();
            schema.check(&file, &value);
            assert_eq!(value["file"], file);
            checked += 1;
        }
    }
    let notes = run(&["modes", "models/three_pendulums.lag", "--verbose", "--message-format", "json"]);
    for line in notes.err.lines() {
        schema.check("notes", &serde_json::from_str(line).unwrap());
        checked += 1;
    }
    assert!(checked > 100);
}

#[test]
fn periods() {
    let schema = Schema::read("period");
    let pendulum = "models/period/pendulum.lag";
    for request in [
        &["--amplitude", "2"][..],
        &["--energy", "20"],
        &["--over", "amplitude=1..4:4"],
        &["--over", "energy=10..30:4"],
    ] {
        let mut arguments = vec!["period", pendulum, "--json"];
        arguments.extend(request);
        let run = run(&arguments);
        assert_eq!(run.status, 0, "{request:?}: {}", run.err);
        schema.check(pendulum, &serde_json::from_str(&run.out).unwrap());
    }
    let quartic = printed(&["period", "models/period/quartic.lag", "--amplitude", "1", "--json"]);
    let mut value: Value = serde_json::from_str(&quartic).unwrap();
    assert!(value["small_amplitude_period"].is_null());
    schema.check("quartic", &value);
    value["turning_points"] = Value::Null;
    assert!(schema.refuses(&value));
}

#[test]
fn responses() {
    let schema = Schema::read("response");
    for request in [
        &["two_masses_driven.lag", "--input", "x[1]", "--over", "omega=0..4:5"][..],
        &["two_masses_driven.lag", "--input", "x[1]", "--output", "x[2]", "--over", "omega=0..4:3"],
        &["unbalance.lag", "--over", "n=0..4:5"],
    ] {
        let file = format!("models/response/{}", request[0]);
        let mut arguments = vec!["response", &file, "--json"];
        arguments.extend(&request[1..]);
        let run = run(&arguments);
        assert_eq!(run.status, 0, "{request:?}: {}", run.err);
        let mut value: Value = serde_json::from_str(&run.out).unwrap();
        schema.check(&file, &value);
        value["outputs"][0]["amplitude"][0] = "large".into();
        assert!(schema.refuses(&value), "{file}");
        let run = crate::cli_support::run(&[&arguments[..], &["--peaks"]].concat());
        let mut value: Value = serde_json::from_str(&run.out).unwrap();
        schema.check(&file, &value);
        assert!(value["outputs"][0]["peaks"].as_array().is_some_and(|all| !all.is_empty()), "{file}");
        value["outputs"][0]["peaks"][0]["kind"] = "large".into();
        assert!(schema.refuses(&value), "{file}");
    }
}

/// What `response --peaks` prints and says of two masses, of a maximum between its half-power points, and of ranges without a count.
#[test]
fn peaks_as_csv() {
    let found = run(&[
        "response",
        "models/response/two_masses_driven.lag",
        "--input",
        "x[1]",
        "--over",
        "omega=0..5",
        "--peaks",
    ]);
    let expected = "output,kind,omega,amplitude,half power from,half power to
x[1],resonance,2.000000000,inf,,
x[1],antiresonance,2.828427125,0,,
x[1],resonance,3.464101615,inf,,
x[2],resonance,2.000000000,inf,,
x[2],minimum,2.828427125,0.2500000000,,
x[2],resonance,3.464101615,inf,,
";
    assert_eq!((found.status, found.out.as_str(), found.err.as_str()), (0, expected, ""));
    let silent = [
        "response",
        "models/three_pendulums.lag",
        "--input",
        "phi[2]",
        "--output",
        "phi[1]",
        "--over",
        "omega=0..6",
        "--peaks",
    ];
    let found = run(&silent);
    assert!(found.err.contains("peaks of phi[1] are not decided at omega near 3.189044"), "{}", found.err);
    // The mode of y at √1.04, which is not excited, cuts off the flank of the peak; farther away it does not.
    for (square, cut) in [("1.04", ", nor all half-power points of the maximum at 0.9974969"), ("3", "")] {
        let text = format!(
            "coord u, y  T = 1/2*u'^2 + 1/2*(y' + u')^2  V = 1/2*u^2 + 1/2*{square}*(y + u)^2  dissipation = 1/20*u'^2"
        );
        let found =
            with_input(&["response", "-", "--input", "u", "--output", "u", "--over", "omega=0..2", "--peaks"], &text);
        let warning = found.err.lines().next().unwrap_or_default();
        assert!(warning.contains("not decided at omega near") && warning.ends_with(cut), "{}", found.err);
        assert_eq!(warning.contains("half-power"), !cut.is_empty(), "{warning}");
    }
}

#[test]
fn equilibria_in_a_box_and_over_a_parameter() {
    let schema = Schema::read("equilibria");
    let file = "models/equilibria/bead_on_hoop.lag";
    for (more, part) in [(&[][..], "equilibria"), (&["--over", "W=0..20:5"], "branches")] {
        let run = run(&[&["equilibria", file, "--box", "th=-2..2", "--json"], more].concat());
        assert_eq!(run.status, 0, "{more:?}: {}", run.err);
        let mut value: Value = serde_json::from_str(&run.out).unwrap();
        schema.check(file, &value);
        assert_eq!(value[part].as_array().unwrap().len(), 3);
        let word = if more.is_empty() { &mut value[part][0] } else { &mut value["bifurcations"][0]["kind"] };
        *word = "large".into();
        assert!(schema.refuses(&value), "{more:?}");
    }
    // A value at which a pitchfork is.
    let well = "param a = 1  coord x  T = 1/2*x'^2  V = x^4/4 - a*x^2/2";
    let found = with_input(&["equilibria", "-", "--box", "x=-3..3", "--over", "a=-1..1:5"], well).out;
    assert!(found.contains("stable, neutral at 0, unstable behind it"), "{found}");
}

/// What the language promises of the columns, of resonances and of wrong words.
#[test]
fn responses_as_csv() {
    let file = "models/response/two_masses_driven.lag";
    let run_with = |more: &[&str]| run(&[&["response", file][..], more].concat());
    let found = run_with(&["--input", "x[1]", "--output", "x[2]", "--output", "x[1]", "--over", "omega=1..3:3"]);
    let expected = "omega,x[2] amplitude,x[2] phase,x[1] amplitude,x[1] phase
1.0,0.1212121212,0,0.2121212121,0
2.0,inf,,inf,
3.0,0.2666666667,3.141592654,0.06666666667,0
";
    assert_eq!((found.status, found.out.as_str()), (0, expected));
    assert!(found.err.contains("at omega = 2 the response is infinite"), "{}", found.err);
    assert_eq!(run_with(&["--input", "x[1]", "--output", "x[2], x[1]", "--over", "omega=1..3:3"]).out, expected);
    assert_eq!(run_with(&["--input", "x[1]", "--output", "", "--over", "omega=1..3:3"]).status, 1);
    let (no_name, no_range) = (["--input", "x[3]", "--over", "omega=1..3:3"], ["--input", "x[1]", "--over", "omega=1"]);
    assert_eq!((run_with(&no_name).status, run_with(&no_range).status), (1, 2));
    assert!(run_with(&no_name).err.contains("did you mean"));
    assert_eq!(run_with(&["--input", "x[1]", "--over", "W=1..3:3"]).status, 2);
    assert_eq!(run_with(&["--input", "x[1]"]).status, 2);
}

#[test]
fn amplitudes() {
    let schema = Schema::read("amplitude");
    for file in files("models/amplitude").into_iter().chain([
        "models/elastic_pendulum.lag".to_owned(),
        "models/co2.lag".to_owned(),
        "models/double_well.lag".to_owned(),
    ]) {
        let run = run(&["amplitude", &file, "--json"]);
        assert_eq!(run.status, 0, "{file}: {}", run.err);
        let mut value: Value = serde_json::from_str(&run.out).unwrap();
        schema.check(&file, &value);
        let modes = value["modes"].as_array_mut().unwrap();
        let mode = modes[0].as_object_mut().unwrap();
        mode.remove("obstacle");
        mode.insert("frequency_change".to_owned(), Value::Null);
        assert!(schema.refuses(&value), "{file}");
    }
}

#[test]
fn motions_with_and_without_a_proof() {
    let schema = Schema::read("motion");
    for how in [&["--proved"][..], &[], &["--tolerance", "1e-9"]] {
        let mut arguments = vec!["motion", "models/spring_pendulum.lag", "--mode", "1"];
        arguments.extend(["--amplitude", "1/100", "--until", "1", "--samples", "3", "--json"]);
        arguments.extend(how);
        let run = run(&arguments);
        assert_eq!(run.status, 0, "{}", run.err);
        let mut value: Value = serde_json::from_str(&run.out).unwrap();
        schema.check("a motion", &value);
        assert_eq!(value["proved"], how == ["--proved"]);
        let columns = value["columns"].as_array().unwrap();
        assert_eq!(columns.len(), 2 * value["coordinates"].as_array().unwrap().len());
        if how == ["--proved"] {
            value["columns"][0].as_object_mut().unwrap().remove("error_bounds");
            assert!(schema.refuses(&value));
        }
    }
}

/// The schemas can fail.
#[test]
fn what_is_not_promised_is_refused() {
    let text = printed(&["modes", PENDULUMS, "--json"]);
    let good: Value = serde_json::from_str(&text).unwrap();
    let schema = Schema::read("modes");
    assert!(!schema.refuses(&good));
    let mut bad = good.clone();
    bad["stability"] = "perhaps".into();
    assert!(schema.refuses(&bad));
    let mut bad = good.clone();
    bad["modes"][0]["error_bound"] = (-1.0).into();
    assert!(schema.refuses(&bad));
    let mut bad = good;
    bad["modes"][0]["omega_digits"] = "3,13".into();
    assert!(schema.refuses(&bad));
}
