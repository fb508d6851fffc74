//! The command line from outside: what is typed, what comes back.
#![cfg(feature = "cli")]

use crate::cli_support;

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use cli_support::*;
use serde_json::Value;

const PENDULUM: &str = "models/simple_pendulum.lag";

fn scratch(name: &str, content: &[u8]) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, content).unwrap();
    path
}

#[test]
fn three_pendulums_as_text() {
    insta::assert_snapshot!(printed(&["modes", PENDULUMS]));
}

#[test]
fn shapes_stand_below_on_a_narrow_terminal() {
    use librate::{linearize, model, modes, oscillation, report, syntax};
    let text = std::fs::read_to_string(PENDULUMS).unwrap();
    let file = syntax::parse(&text).unwrap();
    let model = model::elaborate(&file, &Default::default(), &Default::default()).unwrap();
    let linearized = linearize::linearize(model).unwrap();
    let options = modes::Options::default();
    let normal = oscillation::normal_modes(&linearized, &options).unwrap();
    let written = |width| {
        let style = report::Style::default().width(width);
        report::modes_text(&linearized, &normal, &options, &style)
    };
    insta::assert_snapshot!(written(72));
    assert_eq!(written(80), printed(&["modes", PENDULUMS]));
    assert!(written(100).contains("symmetry  phi[1]"));
    // However narrow, no digit of a frequency is lost.
    assert!(written(1).contains("3.132091953"));
}

#[test]
fn unstable_and_zero_modes_as_text() {
    let saddle = printed(&["modes", "models/egg_box_saddle.lag"]);
    let cart = run(&["modes", "models/two_pendulums_on_a_cart.lag"]);
    assert!(cart.err.contains("no restoring force acts on `X`"));
    insta::assert_snapshot!(format!("{saddle}\n{}", cart.out));
}

#[test]
fn matrices_as_text() {
    let small = printed(&["derive", PENDULUMS]);
    let wide = printed(&["derive", "models/n_pendulum.lag", "--set", "N=4"]);
    insta::assert_snapshot!(format!("{small}\n{wide}"));
}

#[test]
fn a_large_model_stays_readable() {
    let text = printed(&["modes", "models/ubiquitin.lag"]);
    assert!(text.lines().all(|line| line.chars().count() <= 110), "{text}");
    assert!(text.lines().count() > 228);
    assert!(text.contains("together are"));
    // With friction a shape has a second row, but not where all move nearly in phase.
    let chain = "coord x[1..8]  T = sum(i in 1..8, 1/2*x[i]'^2)
        V = 1/2*x[1]^2 + 1/2*x[8]^2 + sum(i in 1..7, 1/2*(x[i+1] - x[i])^2)  dissipation = 1/2*0.01*x[1]'^2";
    let little = with_input(&["modes", "-"], chain).out;
    assert!(little.contains(" ▅▇████▇▅ ") && !little.contains("a quarter later"), "{little}");
    assert!(with_input(&["modes", "-"], &chain.replace("0.01", "1")).out.contains("shape, and a quarter later"));
}

#[test]
fn families_of_equilibria_are_counted() {
    let hat = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = (x^2 + y^2 - 1)^2";
    for (text, told) in [
        (hat.to_owned(), "2 equilibria in the box, one of each family, all there are"),
        (hat.replace("V = (", "V = 1/4*(x + y)^2 + 0*("), "1 family of equilibria in the box, all there are"),
        (hat.replace("V = (x^2 + y^2 - 1)^2", "V = x^2*y^2"), "not proved to be all"),
    ] {
        let out = with_input(&["equilibria", "-", "--box", "x=-2..2, y=-2..2"], &text).out;
        assert!(out.contains(told), "{out}");
    }
}

#[test]
fn options_stand_before_and_behind_the_file() {
    let before = printed(&["modes", "--no-vectors", "--set", "k12=8", PENDULUMS]);
    let behind = printed(&["modes", PENDULUMS, "--set=k12=8", "--no-vectors"]);
    assert_eq!(before, behind);
    assert_ne!(before, printed(&["modes", PENDULUMS, "--no-vectors"]));
    assert!(!before.contains("phi[1]"), "{before}");
}

#[test]
fn verbose_tells_the_solver_on_standard_error() {
    let arguments = ["modes", "models/large/chain.lag", "--set", "N=400", "--lowest", "3"];
    let silent = printed(&arguments);
    let with = |more: &[&str]| run(&[&arguments, more].concat());
    let told = with(&["--verbose"]);
    assert_eq!((told.status, &told.out), (0, &silent));
    let lines: Vec<&str> = told.err.lines().collect();
    assert!(lines[1].starts_with("structure: 400 coordinates; M diagonal, 400 entries; K tridiagonal"), "{lines:?}");
    assert!(lines[2].starts_with("solver: Sturm counts"), "{lines:?}");
    let json = with(&["--verbose", "--message-format", "json"]);
    assert_eq!(json.err.lines().count(), lines.len());
    for (line, text) in json.err.lines().zip(&lines) {
        let value: serde_json::Value = serde_json::from_str(line).unwrap();
        assert_eq!((&value["severity"], &value["message"]), (&"note".into(), &(*text).into()));
    }
    // So do other commands with modes, and pictures of them.
    let others: [&[&str]; 5] = [
        &["sweep", "models/three_pendulums.lag", "--over", "k12=1..4:3"],
        &["sensitivity", "models/three_pendulums.lag"],
        &["response", "models/three_pendulums.lag", "--input", "phi[1]", "--over", "omega=1..2:3"],
        &["plot", "modes", "models/three_pendulums.lag"],
        &["show", "models/three_pendulums.lag"],
    ];
    for other in others {
        let told = run(&[other, &["--verbose"]].concat());
        assert!(
            told.status == 0 && told.err.starts_with("energies: ") && told.err.lines().count() < 4,
            "{other:?}: {}",
            told.err
        );
        assert_eq!(told.out, printed(other));
    }
    assert_eq!(with(&["--threads", "3"]).out, silent);
    assert_eq!(with(&["--threads", "0"]).status, 2);
}

#[test]
fn the_lowest_modes_only() {
    let text = printed(&["modes", PENDULUMS, "--lowest", "2"]);
    assert!(text.contains("3.132091953") && text.contains("3.189043744"));
    assert!(text.contains("the 2 lowest of 3 modes") && !text.contains("3.244996148"));
    let all = printed(&["modes", PENDULUMS, "--lowest", "99"]);
    assert_eq!(all, printed(&["modes", PENDULUMS]));
}

#[test]
fn digits_are_those_asked_for_or_those_certain() {
    let text = printed(&["modes", PENDULUMS, "--digits", "20"]);
    assert!(text.contains("3.1320919526731650539 "), "{text}");
    let text = printed(&["modes", PENDULUMS, "--digits", "3"]);
    assert!(text.contains("3.13 ") && text.contains("5e-3"), "{text}");
    // sqrt(g / l) to 100 digits, with a bound below all of them; nothing is missing.
    let text = printed(&["modes", PENDULUMS, "--digits", "100"]);
    let root = "3.132091952673165053927326206764414303486954951315939925901619174701411174388440475623619187333729414";
    assert!(text.contains(root) && text.contains("5e-100"), "{text}");
    assert!(!text.contains("fewer"), "{text}");
    let text = printed(&["modes", PENDULUMS, "--digits", "100", "--json"]);
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["modes"][0]["omega_digits"], root);
    assert_eq!(json["modes"][0]["digits_error_bound"], 5e-100);
}

#[test]
fn standard_input() {
    let run = with_input(&["modes", "-"], SPRING);
    assert_eq!((run.status, run.err.as_str()), (0, ""));
    assert!(run.out.starts_with("1 coordinate\n") && run.out.contains("2.000000000"));
    // Tables are looked for where the command is run.
    let model = "table masses = \"models/data/t.csv\"\ncoord x  T = 1/2*masses[1].m*x'^2";
    let run = with_input(&["check", "-"], model);
    assert_eq!(run.status, 1);
    assert!(run.err.contains("<stdin>:1:16") && run.err.contains("there is no such file"));
}

#[test]
fn tables_stand_beside_the_model() {
    scratch("masses.csv", b"\xef\xbb\xbfm\r\n2\r\n");
    let text = b"table masses = \"masses.csv\"  coord x  T = 1/2*masses[1].m*x'^2  V = x^2";
    let model = scratch("beside.lag", text);
    let text = printed(&["modes", model.to_str().unwrap()]);
    assert!(text.contains("1.000000000"), "{text}");
}

#[test]
fn check_says_one_line() {
    let text = printed(&["check", PENDULUMS]);
    assert_eq!(text, "three_pendulums: 3 coordinates, T and V are in order\n");
    let run = with_input(&["check", "-"], "coord x  lagrangian = x'^2 - x^2");
    assert_eq!(run.out, "<stdin>: 1 coordinate, the lagrangian is in order\n");
    let run = with_input(&["check", "-"], "coord x  T = x'^2");
    assert_eq!(run.out, "<stdin>: 1 coordinate, T is in order, V is 0\n");
}

#[test]
fn exit_statuses() {
    for (arguments, status) in [
        (&["--help"][..], 0),
        (&["--version"], 0),
        (&["modes", "--help"], 0),
        (&[], 2),
        (&["modes"], 2),
        (&["modes", PENDULUMS, PENDULUMS], 2),
        (&["fmt"], 2),
        (&["floquet", PENDULUMS], 1),
        (&["floquet", "models/mathieu.lag"], 0),
        (&["floquet", "models/mathieu.lag", "--digits", "31"], 2),
        (&["floquet", "models/mathieu.lag", "--map", "a=0..1:3"], 2),
        (&["floquet", "models/mathieu.lag", "--map", "a=0..1:3", "q=0"], 2),
        (&["floquet", "models/mathieu.lag", "--map", "a=0..1:3", "a=0..1:3"], 2),
        (&["floquet", "models/mathieu.lag", "--map", "a=0..1:3", "b=0..1:3"], 1),
        (&["floquet", PENDULUMS, "--map", "g=1..2:3", "L=1..2:3"], 1),
        (&["help"], 2),
        (&["modes", PENDULUMS, "--latex"], 2),
        (&["modes", PENDULUMS, "--lowest", "0"], 2),
        (&["modes", PENDULUMS, "--lowest", "-1"], 2),
        (&["modes", PENDULUMS, "--digits", "0"], 2),
        (&["modes", PENDULUMS, "--digits", "ten"], 2),
        (&["modes", PENDULUMS, "--digits", "251"], 2),
        (&["modes", PENDULUMS, "--set", "k12"], 2),
        (&["modes", PENDULUMS, "--set", "k12="], 2),
        (&["modes", PENDULUMS, "--set", "unknown=1"], 1),
        (&["modes", PENDULUMS, "--set", "L:cm=30"], 2),
        (&["sweep", PENDULUMS, "--over", "L:cm=20..30:3"], 2),
        (&["period", PENDULUM, "--amplitude", "1 ± 0.1"], 2),
        (&["modes", "models/no_such_file.lag"], 1),
        (&["modes", "models"], 1),
        (&["modes", "models/heavy_roller_on_incline.lag"], 1),
        (&["modes", "-"], 1),
    ] {
        let run = run(arguments);
        assert_eq!(run.status, status, "{arguments:?}: {}", run.err);
        if status == 0 {
            assert_eq!(run.err, "", "{arguments:?}");
        } else {
            assert_eq!(run.out, "", "{arguments:?}");
            assert!(run.err.starts_with("error") || arguments.is_empty(), "{arguments:?}");
        }
    }
}

#[test]
fn members_are_set_as_expressions_name_them() {
    let text = "param a[1..2, 1..2] = [[1, 2], [3, 4]]  coord x  T = 1/2*x'^2  V = 1/2*a[2,1]*x^2";
    for setting in ["a[2,1]=9", "a[2][1]=9", "a [2][1] = 9"] {
        let run = with_input(&["modes", "-", "--json", "--set", setting], text);
        assert!(run.out.contains("\"omega\": 3.0"), "{setting}: {}{}", run.out, run.err);
    }
}

/// All digits that are asked for, or a word why not.
#[test]
fn digits_of_derivatives_are_told() {
    let text = "param k = 2  param m = 3  coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2";
    for (digits, is_short) in [("10", false), ("25", false), ("40", true)] {
        let own = with_input(&["sensitivity", "-", "--digits", digits], text).out;
        assert_eq!(own.contains("digits of some derivatives: only those that are certain"), is_short, "{own}");
        assert!(
            own.contains("-0.1360827634879543387887380"[..].get(..digits.parse::<usize>().unwrap().min(24)).unwrap()),
            "{own}"
        );
    }
}

#[test]
fn settings_have_no_unit_and_may_have_an_uncertainty() {
    for bad in ["L:cm=30", "L=30 cm"] {
        let run = run(&["modes", PENDULUMS, "--set", bad]);
        assert_eq!(run.status, 2);
        assert!(run.err.contains("comes without a unit"), "{}", run.err);
    }
    let run = run(&["modes", PENDULUMS, "--set", "m[1..2]=7"]);
    assert!(run.err.contains("one member is set at a time"), "{}", run.err);
    assert_eq!(run.err.matches("can't read the setting").count(), 1, "{}", run.err);
    // omega = sqrt(g/l): d omega = omega dl/(2 l)
    let sigma = |settings: &[&str]| {
        let own = [&["sensitivity", PENDULUM, "--json"], settings].concat();
        let json: serde_json::Value = serde_json::from_str(&printed(&own)).unwrap();
        json["modes"][0]["omega_sigma"].as_f64()
    };
    let omega = 9.81_f64.sqrt();
    let off = sigma(&["--set", "l=1±0.1"]).unwrap() - omega * 0.05;
    assert!(off.abs() < 1e-15, "{off}");
    assert_eq!(sigma(&["--set", "l=1"]), None);
    // The modes of a sweep have it too; that of a value put in for the parameter itself stays.
    let text = "param k = 4 ± 1/10  param g = 1  coord x, y  T = 1/2*(x'^2 + y'^2)
        V = 1/2*k*x^2 + 1/2*g*y^2";
    for (over, sigmas) in
        [("g=1..9:2", [[0.0, 0.025], [0.025, 0.0]]), ("k=9..16:2", [[0.0, 0.1 / 6.0], [0.0, 0.1 / 8.0]])]
    {
        for flag in ["--json", "--no-vectors"] {
            let run =
                with_input(&["sweep", "-", "--over", over, "--json", flag][..5 + usize::from(flag != "--json")], text);
            assert!(!run.err.contains("is ignored"), "{}", run.err);
            let json: serde_json::Value = serde_json::from_str(&run.out).unwrap();
            for (place, sigmas) in sigmas.iter().enumerate() {
                for (mode, sigma) in sigmas.iter().enumerate() {
                    let own = json[place]["modes"][mode]["omega_sigma"].as_f64().unwrap();
                    assert!((own - sigma).abs() < 1e-15, "{over} {place} {mode}: {own}");
                }
            }
        }
        let run = with_input(&["sweep", "-", "--over", over], text);
        assert!(run.err.contains("the uncertainty of `k` is ignored"), "{}", run.err);
    }
    // What is left out is said, where it is.
    let run = cli_support::run(&["period", PENDULUM, "--amplitude", "1", "--set", "l=1 ± 0.1"]);
    assert!(run.err.contains("the uncertainty of `l` is ignored here"), "{}", run.err);
}

#[test]
fn contradictory_constraints_are_no_derivation() {
    let bodies = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = x^2 + y^2";
    for constraints in [
        "constraint x + y = 1  constraint x + y = 2",
        "param a = 3  constraint x = a  constraint 2*x = 7 - y + y",
        "guess x = 1  constraint x^2 + y^2 = 1  constraint x^2 + y^2 = 1 + 1e-30",
    ] {
        for command in ["modes", "derive"] {
            let run = with_input(&[command, "-"], &format!("{bodies}  {constraints}"));
            assert_eq!(run.status, 1, "{command} {constraints}: {}", run.out);
            assert!(run.err.contains("E0313"), "{command} {constraints}: {}", run.err);
            assert!(run.out.is_empty(), "{}", run.out);
        }
    }
    // What follows from the others is no contradiction.
    let run = with_input(&["derive", "-"], &format!("{bodies}  constraint x + y = 1  constraint 2*x + 2*y = 2"));
    assert_eq!(run.status, 0, "{}", run.err);
}

#[test]
fn many_groups_of_equal_modes_are_told_in_one_sentence() {
    let told = |model: &str| -> Vec<String> {
        let text = printed(&["modes", model]);
        let text = text.replace("\n    ", " ");
        let lines = text.lines().filter(|line| line.contains("equal within their bounds"));
        lines.map(str::to_owned).collect()
    };
    let many = told("models/square_lattice.lag");
    assert_eq!(many.len(), 1, "{many:?}");
    assert!(many[0].starts_with("modes 1 and 2; 3 and 4;") && many[0].contains("31 more groups"), "{many:?}");
    let [few] = &told("models/tetrahedron.lag")[..] else {
        panic!("no line, or several");
    };
    assert!(few.starts_with("modes 7 and 8; 9 to 11 are equal"), "{few}");
}

#[test]
fn help_teaches() {
    let text = printed(&["--help"]);
    // The model in it works.
    let model: String = text
        .lines()
        .skip_while(|line| *line != "    model three_pendulums")
        .take_while(|line| line.is_empty() || line.starts_with("    "))
        .map(|line| format!("{line}\n"))
        .collect();
    let run = with_input(&["modes", "-"], &model);
    assert_eq!(run.status, 0, "{model}\n{}", run.err);
    assert!(run.out.contains("3.189043744"), "{}", run.out);
    for command in [
        "modes",
        "check",
        "derive",
        "fmt",
        "sweep",
        "sensitivity",
        "amplitude",
        "floquet",
        "period",
        "motion",
        "inertia",
        "export",
    ] {
        assert!(text.contains(command));
    }
    for command in ["modes", "check", "derive", "sweep", "sensitivity", "amplitude", "floquet", "inertia", "export"] {
        assert!(printed(&[command, "--help"]).contains("--set <NAME=VALUE>"));
    }
}

#[test]
fn limits_of_what_is_no_parameter_name_those_there_are() {
    for flag in [["--limit", "k=0"].as_slice(), &["--expand", "k", "2"]] {
        let run = run(&[&["derive", "models/three_pendulums.lag"], flag].concat());
        assert_eq!(run.status, 1);
        assert_eq!(run.out, "");
        assert_eq!(
            run.err,
            "error: there is no parameter `k`\nhelp: the model has the parameters `g`, `L`, `m[1]`, `m[2]`, `m[3]`, \
             `l[1]`, `l[2]`, `l[3]`, ...\n"
        );
    }
}

#[test]
fn limits_have_exponents_and_series_are_asked_for_once() {
    let derive = ["derive", "models/double_pendulum.lag", "--json", "--limit", "m[2]=0"];
    let derived: Value = serde_json::from_str(&printed(&derive)).unwrap();
    let exponents = derived["exponents"].as_array().unwrap().iter().map(|own| own["exponent"].as_str().unwrap());
    let both = ["i*sqrt(g/l[1])", "-i*sqrt(g/l[1])", "i*sqrt(g/l[2])", "-i*sqrt(g/l[2])"];
    assert_eq!(exponents.collect::<Vec<_>>(), both);
    let twice = run(&["derive", "models/double_pendulum.lag", "--expand", "g", "1", "--expand", "g", "2"]);
    assert_eq!(twice.status, 2);
    assert!(twice.err.contains("cannot be used multiple times"), "{}", twice.err);
}

#[test]
fn a_chart_as_table_and_picture() {
    let [svg, borders] = ["chart.svg", "borders.csv"].map(|name| scratch(name, b""));
    let chart = ["floquet", "models/mathieu.lag", "--map", "a=-1..5:7", "q=0..2:3", "--threads", "3"];
    assert_eq!(printed(&[&["plot"], &chart[..], &["-o", svg.to_str().unwrap()]].concat()), "");
    let run = run(&[&chart[..], &["--borders", borders.to_str().unwrap()]].concat());
    assert_eq!((run.status, run.err.as_str()), (0, ""));
    let lines: Vec<&str> = run.out.lines().collect();
    assert_eq!(lines[0], "a,q,stable,growth_rate");
    assert_eq!(lines.len(), 1 + 7 * 3);
    // exp(t) without a drive at a = -1; a = 1, q = 1 is in the first tongue, a = 2, q = 1 beside it.
    let rate = lines[1].strip_prefix("-1.0,0.0,false,").unwrap();
    assert!((rate.parse::<f64>().unwrap() - 1.0).abs() < 1e-13, "{rate}");
    assert!(lines[8].starts_with("1.0,1.0,false,4.534535"), "{}", lines[8]);
    assert_eq!(lines[11], "2.0,1.0,true,0e0");
    let picture = std::fs::read_to_string(svg).unwrap();
    assert!(picture.starts_with("<svg") && picture.ends_with("</svg>\n"));
    assert!(picture.matches("<rect").count() > 3);
    let borders = std::fs::read_to_string(borders).unwrap();
    // a_1(1), from below; a_0(1) and b_1(1) are both between 0 and -1.
    let a1 = borders.lines().find(|line| line.ends_with(",1.0")).unwrap();
    let a1: f64 = a1.split_once(',').unwrap().0.parse().unwrap();
    assert!((a1 - 1.859_108_072_514_364).abs() < 1e-12, "{a1}");
    // Values are the doubles of a sweep.
    let table = printed(&["floquet", "models/mathieu.lag", "--map", "a=1..3:4", "q=0..0:1"]);
    let values: Vec<&str> = table.lines().skip(1).filter_map(|line| line.split(',').next()).collect();
    assert_eq!(values, ["1.0", "1.6666666666666667", "2.3333333333333335", "3.0"]);
}

#[test]
fn files_that_are_no_text() {
    let path = scratch("latin.lag", b"coord x\nparam gr\xf6\xdfe = 1\n");
    let run = run(&["check", path.to_str().unwrap()]);
    assert_eq!(run.status, 1);
    assert!(run.err.contains("not UTF-8 text (byte 16 in line 2, 0xf6)"), "{}", run.err);
    let run = finish(command(&["check", "-"]), b"\xff\xfe");
    assert_eq!(run.status, 1);
    assert!(run.err.contains("not UTF-8"), "{}", run.err);
}

#[test]
fn columns_count_characters() {
    // A byte order mark, Windows line ends, a tab, and letters two columns wide.
    let text = "\u{feff}coord x\r\nT = 1/2*x'^2\r\n\tV = 変数*x^2 + φ*q*x^2\r\n";
    let run = with_input(&["check", "-"], text);
    assert_eq!(run.status, 1);
    insta::assert_snapshot!(run.err);
}

#[test]
fn long_lines_are_cut_around_the_mistake() {
    let terms = " + é*x".repeat(5000);
    let text = format!("coord x  param é = 1  T = x'^2  V = x^2{terms} + zz*x{terms}");
    let run = with_input(&["check", "-"], &text);
    assert_eq!(run.status, 1);
    assert!(run.err.contains("<stdin>:1:30043"), "{}", run.err);
    assert!(run.err.len() < 1000 && run.err.contains("^^ unknown name"));
}

#[test]
fn colour_only_where_it_is_wanted() {
    let plain = run(&["modes", "models/inverted_pendulum.lag"]);
    assert!(!plain.out.contains('\u{1b}'));
    let mut forced = command(&["modes", "models/inverted_pendulum.lag"]);
    forced.env("CLICOLOR_FORCE", "1").env_remove("NO_COLOR");
    let forced = finish(forced, b"").out;
    assert!(forced.contains("\u{1b}[31m"));
    let mut mistake = command(&["modes", "-"]);
    mistake.env("CLICOLOR_FORCE", "1").env("NO_COLOR", "1");
    assert!(!finish(mistake, b"coord x").err.contains('\u{1b}'));
    // Colours change nothing else.
    let bare: String = forced
        .split('\u{1b}')
        .enumerate()
        .map(|(at, part)| if at == 0 { part } else { part.split_once('m').unwrap().1 })
        .collect();
    assert_eq!(bare, plain.out);
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let mut child = command(&["modes", "models/ubiquitin.lag", "--json"]).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

#[test]
fn modes_as_json() {
    let text = printed(&["modes", PENDULUMS, "--json"]);
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        keys(&json),
        [
            "model",
            "librate",
            "coordinates",
            "equilibrium",
            "equilibrium_error_bound",
            "stability",
            "secular",
            "modes",
            "units"
        ]
    );
    assert_eq!(json["model"], "three_pendulums");
    assert_eq!(json["coordinates"], serde_json::json!(["phi[1]", "phi[2]", "phi[3]"]));
    assert_eq!(json["equilibrium"], serde_json::json!([0.0, 0.0, 0.0]));
    assert_eq!(json["stability"], "stable");
    let modes = json["modes"].as_array().unwrap();
    assert_eq!(modes.len(), 3);
    for (mode, symmetry) in modes.iter().zip(["even", "odd", "even"]) {
        assert_eq!(
            keys(mode),
            [
                "omega",
                "omega_digits",
                "omega_squared",
                "growth",
                "growth_digits",
                "error_bound",
                "digits_error_bound",
                "kind",
                "symmetry",
                "vector",
                "vector_error_bound"
            ]
        );
        assert_eq!((&mode["kind"], &mode["symmetry"]), (&"oscillation".into(), &symmetry.into()));
        assert_eq!((&mode["growth"], &mode["growth_digits"]), (&0.0.into(), &"0".into()));
        assert!(mode["vector_error_bound"].as_f64().unwrap() < 1e-13);
    }
    assert_eq!(modes[0]["omega"].as_f64().unwrap(), 9.81_f64.sqrt());
    assert_eq!(modes[0]["omega_digits"], "3.132091953");
    assert_eq!(modes[0]["omega_squared"], 9.81);
    assert_eq!(modes[0]["digits_error_bound"], 5e-10);
    // The distance of the nearest double from the true number.
    let bound = modes[0]["error_bound"].as_f64().unwrap();
    assert!((1e-17..=4.4e-16).contains(&bound), "{bound}");
    let components = modes[0]["vector"].as_array().unwrap();
    assert!(components.iter().all(|part| (part.as_f64().unwrap() - 0.5).abs() < 1e-13));
}

#[test]
fn json_of_other_kinds_of_modes() {
    let json: Value = serde_json::from_str(&printed(&["modes", "models/egg_box_saddle.lag", "--json"])).unwrap();
    assert_eq!(json["stability"], "unstable");
    let (unstable, stable) = (&json["modes"][0], &json["modes"][1]);
    assert_eq!((&unstable["kind"], &unstable["omega"]), (&"unstable".into(), &0.0.into()));
    assert_eq!(unstable["omega_digits"], "0");
    assert!(unstable["growth"].as_f64().unwrap() > 0.0);
    assert!(unstable["omega_squared"].as_f64().unwrap() < 0.0);
    assert_eq!(stable["growth_digits"], "0");

    let json: Value = serde_json::from_str(&printed(&["modes", "models/water.lag", "--json", "--no-vectors"])).unwrap();
    assert_eq!(json["stability"], "neutral");
    assert_eq!(json["zero_motions"].as_array().unwrap().len(), 6);
    let zero = &json["modes"][0];
    assert_eq!((&zero["kind"], &zero["error_bound"]), (&"zero".into(), &0.0.into()));
    assert_eq!(zero["digits_error_bound"], 0.0);
    assert!(zero.get("vector").is_none() && zero.get("vector_error_bound").is_none());

    let run = with_input(&["modes", "-", "--json", "--digits", "4"], SPRING);
    let json: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(json["model"], Value::Null);
    assert_eq!(json["modes"][0]["omega_digits"], "2.000");
    assert!(json["modes"][0].get("symmetry").is_none());
}

#[test]
fn matrices_as_json() {
    let json: Value = serde_json::from_str(&printed(&["derive", PENDULUMS, "--json"])).unwrap();
    assert_eq!(
        keys(&json),
        [
            "model",
            "librate",
            "coordinates",
            "equilibrium",
            "mass",
            "stiffness",
            "equations",
            "linearized_equations",
            "kinetic_second_order",
            "potential_second_order",
            "momenta",
            "energy_function",
            "hamiltonian",
            "conserved",
            "symmetry",
            "blocks",
            "frequencies",
            "frequencies_complete",
            "frequencies_equal",
            "normal_coordinates",
            "characteristic",
            "exponents",
            "exponents_complete",
            "exponents_equal",
            "stability",
            "force_vanishes"
        ]
    );
    assert_eq!(json["equations"][2], "m[3]*l[3]^2*phi[3]'' + L^2*k23*(phi[3] - phi[2]) + g*m[3]*l[3]*sin(phi[3]) = 0");
    assert_eq!(json["equilibrium"], serde_json::json!(["0", "0", "0"]));
    assert_eq!(json["mass"][0][1], "0");
    assert_eq!(json["stiffness"][0][1], json["stiffness"][1][0]);
    // Entries are expressions of the language.
    for matrix in ["mass", "stiffness"] {
        for entry in json[matrix].as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap()) {
            let text = format!("let entry = {}", entry.as_str().unwrap());
            assert!(librate::syntax::parse(&text).is_ok(), "{text}");
        }
    }
}

#[test]
fn completions_know_the_commands() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = printed(&["completions", shell]);
        assert!(script.contains("sensitivity") && script.contains("digits"), "{shell}");
    }
}

#[test]
fn chapters_of_a_derivation() {
    let json: Value =
        serde_json::from_str(&printed(&["derive", PENDULUMS, "--json", "--only", "mass,exponents"])).unwrap();
    assert_eq!(
        keys(&json),
        ["model", "librate", "coordinates", "mass", "exponents", "exponents_complete", "exponents_equal"]
    );
    for options in [&["--ascii"][..], &["--latex"]] {
        for chapter in librate::derive::CHAPTERS {
            let page = printed(&[&["derive", "models/sleeping_top_fast.lag", "--only", chapter], options].concat());
            let has = |words: &str| page.to_lowercase().contains(words);
            let all =
                [("equations", "lagrange's equations"), ("mass", "mass matrix"), ("gyroscopic", "gyroscopic matrix")];
            let others =
                [("momenta", "momenta"), ("characteristic", "characteristic eq"), ("stability", "stable while")];
            for (own, words) in all.into_iter().chain(others) {
                assert_eq!(has(words), own == chapter, "{chapter}: {page}");
            }
        }
    }
}

#[test]
fn units_and_lengths_of_modes() {
    let page = printed(&["modes", "models/water.lag", "--unit", "cm-1", "--normalize", "max"]);
    assert!(page.contains("f (cm-1)") && page.contains("1 for their largest component"), "{page}");
    let json = |options: &[&str]| -> Value {
        serde_json::from_str(&printed(&[&["modes", "models/water.lag", "--json"], options].concat())).unwrap()
    };
    let (plain, largest) = (json(&[]), json(&["--normalize", "max"]));
    assert_eq!(largest["normalization"], "max");
    for (own, scaled) in plain["modes"].as_array().unwrap().iter().zip(largest["modes"].as_array().unwrap()) {
        let parts = |mode: &Value| -> Vec<f64> {
            mode["vector"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
        };
        let (own, bound) = (parts(own), scaled["vector_error_bound"].as_f64().unwrap());
        let top = own.iter().fold(0.0_f64, |top, x| top.max(x.abs()));
        let first = own.iter().find(|x| x.abs() >= top * (1.0 - 1e-6)).unwrap();
        assert!(bound < 1e-9);
        for (x, y) in own.iter().zip(parts(scaled)) {
            assert!((x / first - y).abs() <= bound, "{x} {y} {bound}");
        }
    }
    // 1/(2 pi c) in 1/cm, of the highest frequency.
    let omega = plain["modes"].as_array().unwrap().last().unwrap()["omega"].as_f64().unwrap();
    let number = omega / (2.0 * std::f64::consts::PI * 29_979_245_800.0);
    assert!(page.contains(&format!("{:.2}", (number * 100.0).floor() / 100.0)), "{number} is not in {page}");
}

/// Every mistake is explained at its place: one file a kind, the report next to it. The first line
/// of a file may say what is typed: `# librate: modes --set x=1`.
#[test]
fn mistakes_are_explained() {
    insta::with_settings!({ snapshot_path => "../errors", prepend_module_to_snapshot => false }, {
        insta::glob!("../errors", "*.lag", |path| {
            let source = std::fs::read_to_string(path).unwrap();
            let typed = source
                .lines()
                .find_map(|line| line.strip_prefix("# librate: "))
                .unwrap_or("modes");
            let mut arguments: Vec<&str> = typed.split(' ').collect();
            arguments.push(path.file_name().unwrap().to_str().unwrap());
            let mut command = command(&arguments);
            command.current_dir(path.parent().unwrap());
            let run = finish(command, b"");
            assert_eq!((run.status, run.out.as_str()), (1, ""), "{}: {}", path.display(), run.err);
            insta::assert_snapshot!(run.err);
        });
    });
}

/// Turning points and the energy have as many digits as the period.
#[test]
fn a_period_has_all_digits_that_are_asked_for() {
    let model = b"param g = 9.81  coord a  T = 1/2*a'^2  V = g*(1 - cos(a))";
    let path = scratch("digits_of_a_period.lag", model);
    let found = printed(&["period", path.to_str().unwrap(), "--energy", "2", "--digits", "20"]);
    assert!(found.contains("a = -0.64992960011276302100 and 0.64992960011276302100\n"), "{found}");
    assert!(found.contains(" 2.0000000000000000000\n"), "{found}");
}

#[test]
fn lists_set_families() {
    let model = "param m[1..2] = 1  param k = 1\ncoord x[1..2]\nT = sum(i in 1..2, m[i]*x[i]'^2)/2\nV = k*(x[1]^2 + x[2]^2)/2\n";
    let path = scratch("lists.lag", model.as_bytes());
    let modes = |settings: &[&str]| {
        let mut arguments = vec!["modes", path.to_str().unwrap(), "--no-vectors"];
        settings.iter().for_each(|own| arguments.extend(["--set", own]));
        run(&arguments)
    };
    let listed = modes(&["m=[4, 16]"]);
    assert!(listed.out.contains("0.2500000000") && listed.out.contains("0.5000000000"), "{}", listed.out);
    assert_eq!(listed.out, modes(&["m[1]=4", "m[2]=16"]).out);
    // What is set of a member goes before, wherever it stands.
    assert_eq!(listed.out, modes(&["m[2]=16", "m=[4, 1]"]).out);
    for (setting, reason) in [
        ("m=[1, 2, 3]", "`m` has 2 members, but a vector of 3 is given"),
        ("k=[1, 2]", "`k` is one number"),
        ("m[1]=[1, 2]", "one member is one number"),
        ("k=1 +/- [1, 2]", "an uncertainty is one number"),
    ] {
        let refused = modes(&[setting]);
        assert_eq!(refused.status, 1, "{setting}");
        assert!(refused.err.contains(reason), "{}", refused.err);
    }
}

#[test]
fn what_can_only_have_been_meant_is_corrected() {
    // Two names at once; what stands in a comment stays.
    let wrong = "param mass = 2  param stiff = 3\ncoord x\nT = 1/2*mas*x'^2\nV = 1/2*stif*x^2  # stif\n";
    let path = scratch("wrong.lag", wrong.as_bytes());
    let file = path.to_str().unwrap();
    let told = run(&["check", file, "--message-format", "json"]);
    let told: Vec<Value> = told.err.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(told[0]["replacement"]["text"], "mass");
    assert_eq!((&told[0]["replacement"]["line"], &told[0]["replacement"]["column"]), (&3.into(), &9.into()));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), wrong);
    let corrected = run(&["check", file, "--fix"]);
    assert_eq!((corrected.status, corrected.err.as_str()), (0, ""));
    assert!(corrected.out.contains("+T = 1/2*mass*x'^2"), "{}", corrected.out);
    assert!(corrected.out.ends_with("1 coordinate, T and V are in order\n"), "{}", corrected.out);
    let right = wrong.replace("mas*", "mass*").replace("stif*", "stiff*");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), right);
    // Nothing is left to do, and what has no correction stays.
    assert!(!run(&["check", file, "--fix"]).out.contains('+'));
    let hopeless = right + "let q = zzzz\n";
    std::fs::write(&path, &hopeless).unwrap();
    let refused = run(&["check", file, "--fix"]);
    assert_eq!((refused.status, refused.out.as_str()), (1, ""));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), hopeless);
    assert_eq!(run(&["check", "-", "--fix"]).status, 2);
}

#[test]
fn manual_pages_are_those_of_the_help() {
    let whole = printed(&["man"]);
    assert!(whole.contains(".TH librate 1") && whole.contains("librate\\-modes"), "{whole}");
    let modes = printed(&["man", "modes"]);
    assert!(modes.contains("librate\\-modes") && modes.contains("\\-\\-digits"), "{modes}");
    let refused = run(&["man", "nodes"]);
    assert_eq!((refused.status, refused.out.as_str()), (2, ""));
}

/// The names in a list of commands.
fn commands(help: &str) -> Vec<String> {
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    listed.filter_map(|line| Some(line.split_whitespace().next()?.to_owned())).collect()
}

#[test]
fn help_is_as_wide_as_the_terminal() {
    let help = |words: &[&str], width: &str| {
        let mut command = command(words);
        command.arg("--help").env("COLUMNS", width);
        let run = finish(command, b"");
        assert_eq!(run.status, 0, "{words:?}");
        run.out
    };
    let mut all = vec![vec![]];
    all.extend(commands(&printed(&["--help"])).into_iter().map(|name| vec![name]));
    all.extend(commands(&printed(&["plot", "--help"])).into_iter().map(|kind| vec!["plot".to_owned(), kind]));
    assert!(all.len() > 30);
    for own in all {
        let words: Vec<&str> = own.iter().map(String::as_str).collect();
        for line in help(&words, "80").lines() {
            assert!(line.chars().count() <= 80, "{words:?}: {line}");
        }
        // Where there is more room it is used, up to 100 columns; no line is broken where it stands in the source.
        let wide = help(&words, "200");
        let (text, _) = wide.split_once("Usage:").unwrap();
        let lines: Vec<&str> = text.lines().collect();
        for (line, next) in lines.iter().zip(&lines[1..]) {
            let word = next.split_whitespace().next().map_or(usize::MAX, |word| word.chars().count());
            let has_room = line.chars().count().saturating_add(word) < 99;
            let ends = line.is_empty() || line.ends_with(':') || next.starts_with(' ') || line.starts_with(' ');
            assert!(line.chars().count() <= 100 && (ends || !has_room || next.is_empty()), "{words:?}: {line}");
        }
    }
}

#[test]
#[cfg(unix)]
fn examples_of_the_help_run() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("examples");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    std::os::unix::fs::symlink(std::fs::canonicalize("models").unwrap(), folder.join("models")).unwrap();
    let help = printed(&["--help"]);
    let names = commands(&help);
    assert!(names.len() > 20, "{names:?}");
    let program = Path::new(env!("CARGO_BIN_EXE_librate")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    let shell = |line: &str| {
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", line]).current_dir(&folder).env("PATH", &path).stdin(Stdio::null());
        shell
    };
    let run = |line: &str| {
        let ran = shell(line).output().unwrap();
        assert!(ran.status.success(), "{line}\n{}", String::from_utf8_lossy(&ran.stderr));
    };
    // The first page has its own model.
    let (_, model) = help.split_once("three_pendulums.lag:\n").unwrap();
    let (model, lines) = model.split_once("Commands:").unwrap();
    std::fs::write(folder.join("three_pendulums.lag"), model).unwrap();
    std::fs::copy("models/simple_pendulum.lag", folder.join("pendulum.lag")).unwrap();
    let lines = lines.lines().filter_map(|line| line.strip_prefix("    librate "));
    lines.for_each(|line| run(&format!("librate {}", line.split("   ").next().unwrap())));
    let mut examples = 0;
    for name in &names {
        let own = printed(&[name, "--help"]);
        for line in own.lines().skip_while(|line| *line != "Examples:").filter(|line| line.contains("librate ")) {
            let line = line.trim().split(" > ").next().unwrap().trim_end_matches(" | man -l -");
            examples += 1;
            if name != "watch" {
                run(line);
                continue;
            }
            // Goes on until it is told to end, once it has answered.
            let page = folder.join("page.html");
            let _ = std::fs::remove_file(&page);
            let mut watch = shell(&format!("exec {line}")).stdout(Stdio::piped()).spawn().unwrap();
            let mut out = watch.stdout.take().unwrap();
            if line.contains("page.html") {
                while !page.exists() {
                    std::thread::sleep(Duration::from_millis(20));
                }
            } else {
                out.read_exact(&mut [0; 20]).unwrap();
            }
            watch.kill().unwrap();
            watch.wait().unwrap();
        }
    }
    assert!(examples > 30, "{examples}");
}

/// Bounds are rounded up, the lowest is the lowest, and what is known is no 0.
#[test]
fn texts_say_what_is_known() {
    let damped = "coord x, y  T = 1/2*(x'^2 + y'^2)  V = 1/2*9*x^2 + 1/2*y^2  force x = (1 - x^2)*x'/10";
    let found = with_input(&["equilibria", "-", "--box", "x=-1..1, y=-1..1"], damped);
    assert!(found.out.lines().last().unwrap().contains("unstable   1.000000000 "), "{}", found.out);
    let pendulum = "coord x  T = 1/2*x'^2  V = -cos(x)";
    for tolerance in ["1e-5", "1e-6", "1e-7"] {
        let motion = ["motion", "-", "--start", "x=2", "--until", "30", "--samples", "200", "--tolerance", tolerance];
        let told = with_input(&motion, pendulum).err;
        let told = told.split("at most ").nth(1).unwrap().split(' ').next().unwrap().parse::<f64>().unwrap();
        let json: Value =
            serde_json::from_str(&with_input(&[motion.as_slice(), &["--json"]].concat(), pendulum).out).unwrap();
        assert!(told >= json["energy_drift"].as_f64().unwrap(), "{tolerance}: {told}");
    }
    let tensor = with_input(&["inertia", "-"], "param e = 1e-14  let I = [[1, e, 0], [e, 2, 0], [0, 0, 3]]");
    assert!(tensor.out.contains("-1.00000e-14"), "{}", tensor.out);
}
