//! Files and terminals: what is read, what is written, what is shown.
#![cfg(all(feature = "cli", unix))]

use crate::cli_support;

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use cli_support::*;

const MESSY: &str = "coord x\nT=1/2*x'^2\nV = (2*x^2)\n";
const NEAT: &str = "coord x\nT = 1/2*x'^2\nV = 2*x^2\n";

/// An empty folder of a test's own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli_files").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn within(folder: &Path, arguments: &[&str]) -> Run {
    let mut command = command(arguments);
    command.current_dir(folder);
    finish(command, b"")
}

fn shell(folder: &Path, line: &str) -> Run {
    let mut shell = Command::new("sh");
    shell
        .args(["-c", line])
        .env("L", env!("CARGO_BIN_EXE_librate"))
        .current_dir(folder)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped());
    finish(shell, b"")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn is_fault(run: &Run, reason: &str) {
    assert_eq!((run.status, run.out.as_str()), (1, ""), "{}", run.err);
    assert!(run.err.contains(reason), "{}", run.err);
}

/// A model of exactly so many bytes, the last of which belong to a statement.
fn model_of(bytes: usize, comment: &str) -> String {
    let (head, tail) = ("coord x  T = 1/2*x'^2  V = 2*x^2 #", "\nparam last = 1\n");
    let mut text = head.to_owned();
    while text.len() + comment.len() + tail.len() <= bytes {
        text.push_str(comment);
    }
    text.extend(std::iter::repeat_n('a', bytes - text.len() - tail.len()));
    text + tail
}

#[test]
fn nothing_is_ever_cut() {
    const MOST: usize = 32 << 20;
    let folder = folder("long");
    let file = folder.join("long.lag");
    fs::write(&file, model_of(MOST, "a")).unwrap();
    assert_eq!(within(&folder, &["check", "long.lag"]).status, 0);
    // Characters of two and of four bytes at the border, and the border between two statements.
    for (over, comment) in [(1, "é"), (3, "𝜑"), (20, "a")] {
        let text = model_of(MOST + over, comment);
        fs::write(&file, &text).unwrap();
        for command in ["check", "fmt", "inertia"] {
            is_fault(&within(&folder, &[command, "long.lag"]), "the file is too large");
        }
        is_fault(&shell(&folder, "\"$L\" fmt - < long.lag"), "too large");
        assert_eq!(fs::read_to_string(&file).unwrap(), text);
    }
    fs::remove_file(&file).unwrap();
    // Tables and meshes: sparse files, of which nothing is read beyond the limit.
    let model = "table q = \"q.csv\"  coord x[1..rows(q)]  T = dot(x', x')";
    fs::write(folder.join("m.lag"), model).unwrap();
    let table = fs::File::create(folder.join("q.csv")).unwrap();
    table.set_len((256 << 20) + 1).unwrap();
    is_fault(&within(&folder, &["check", "m.lag"]), "it is larger than 256 MB");
    fs::remove_file(folder.join("q.csv")).unwrap();
}

#[test]
fn pipes_and_devices_keep_nobody_waiting() {
    let folder = folder("devices");
    assert!(Command::new("mkfifo").arg(folder.join("pipe.lag")).status().unwrap().success());
    symlink("/dev/zero", folder.join("zero.lag")).unwrap();
    symlink("/dev/zero", folder.join("zero.csv")).unwrap();
    for file in ["pipe.lag", "zero.lag", "zero.csv", "/dev/zero"] {
        for command in ["check", "modes", "inertia", "fmt"] {
            is_fault(&within(&folder, &[command, file]), "a pipe or a device, not a file");
        }
    }
    fs::write(folder.join("m.lag"), "table q = \"pipe.lag\"  coord x  T = x'^2").unwrap();
    let run = within(&folder, &["check", "m.lag"]);
    is_fault(&run, "a pipe or a device, not a file");
    assert!(!run.err.contains("standard input"), "{}", run.err);
    fs::write(folder.join("q.csv"), b"a,b\n1,\xff\n").unwrap();
    fs::write(folder.join("m.lag"), "table q = \"q.csv\"  coord x  T = x'^2").unwrap();
    is_fault(&within(&folder, &["check", "m.lag"]), "save it as UTF-8 text");
    is_fault(&shell(&folder, "\"$L\" modes - < /dev/zero"), "the file is too large");
    // What a shell hands over is read to its end.
    fs::write(folder.join("neat.lag"), NEAT).unwrap();
    let run = shell(&folder, "cat neat.lag | \"$L\" modes /dev/fd/0");
    assert!(run.out.contains("2.000000000"), "{}", run.err);
    let run = shell(&folder, "\"$L\" fmt /dev/stdin < neat.lag");
    assert_eq!((run.status, run.out.as_str()), (0, NEAT), "{}", run.err);
}

#[test]
fn tables_lie_in_or_below_the_folder_of_the_model() {
    let folder = folder("tables");
    let inside = folder.join("inside");
    fs::create_dir_all(inside.join("below")).unwrap();
    fs::create_dir(folder.join("other")).unwrap();
    let secret = "hidden,words\n1,2\n";
    for place in ["outside.csv", "inside/own.csv", "inside/below/own.csv", "other/q.csv"] {
        fs::write(folder.join(place), secret).unwrap();
    }
    symlink("../outside.csv", inside.join("link.csv")).unwrap();
    symlink("below/own.csv", inside.join("fine.csv")).unwrap();
    symlink("../other", inside.join("folder")).unwrap();
    let absolute = inside.join("own.csv").display().to_string();
    let outside = folder.join("outside.csv").display().to_string();
    let model = |path: &str| {
        let text = format!("table q = \"{path}\"  coord x  T = x'^2  V = q[1].secret*x^2");
        fs::write(inside.join("m.lag"), text).unwrap();
    };
    for path in ["own.csv", "below/own.csv", "below/../own.csv", "fine.csv", "../inside/own.csv", &absolute] {
        model(path);
        is_fault(&within(&folder, &["check", "inside/m.lag"]), "its columns are hidden, words");
        is_fault(&within(&inside, &["check", "m.lag"]), "its columns are hidden, words");
        is_fault(&shell(&inside, "\"$L\" check - < m.lag"), "its columns are hidden, words");
    }
    for path in
        ["../outside.csv", "../nothing.csv", "link.csv", "folder/q.csv", "/etc/passwd", "/etc/nothing", &outside]
    {
        model(path);
        for run in [
            within(&folder, &["check", "inside/m.lag"]),
            within(&inside, &["inertia", "m.lag"]),
            shell(&inside, "\"$L\" check - < m.lag"),
            within(&inside, &["check", "m.lag", "--allow-path", "below"]),
        ] {
            is_fault(&run, "there is no such file in or below the folder of the model");
            assert!(!run.err.contains("hidden"), "{}", run.err);
        }
    }
    for path in ["../outside.csv", "link.csv", "folder/q.csv", &outside] {
        model(path);
        for arguments in [&["--allow-path", ".."][..], &["--allow-path", "../other", "--allow-path=.."]] {
            let run = within(&inside, &[&["check", "m.lag"], arguments].concat());
            is_fault(&run, "its columns are hidden, words");
        }
    }
    is_fault(&within(&inside, &["check", "m.lag", "--allow-path", "none"]), "can't use the folder `none`");
    // A model that is a link has its tables where it leads to.
    model("own.csv");
    symlink("inside/m.lag", folder.join("m.lag")).unwrap();
    symlink("inside/own.csv", folder.join("own.csv")).unwrap();
    is_fault(&within(&folder, &["check", "m.lag"]), "its columns are hidden, words");
    // Of what is read, no more is quoted than it takes to see what it is.
    let header: Vec<String> = (0..40).map(|i| format!("{i}{}", "secret ".repeat(30))).collect();
    fs::write(inside.join("own.csv"), header.join(",")).unwrap();
    let run = within(&inside, &["check", "m.lag"]);
    assert_eq!(run.status, 1);
    assert!(run.err.len() < 1000 && !run.err.contains("8secret"), "{}", run.err);
}

#[test]
fn results_are_not_written_over_what_was_read() {
    let folder = folder("own");
    let text = "table q = \"q.csv\"  coord x  T = 1/2*x'^2  V = q[1].k*x^2";
    fs::write(folder.join("own.lag"), text).unwrap();
    fs::write(folder.join("q.csv"), "k\n2\n").unwrap();
    fs::hard_link(folder.join("own.lag"), folder.join("hard.lag")).unwrap();
    symlink("own.lag", folder.join("soft.lag")).unwrap();
    symlink("q.csv", folder.join("soft.csv")).unwrap();
    let before = names(&folder);
    let motion = ["--start", "x=1", "--until", "1", "--samples", "2", "-o"];
    for model in ["own.lag", "hard.lag", "soft.lag"] {
        for picture in ["own.lag", "./own.lag", "hard.lag", "soft.lag", "q.csv", "soft.csv"] {
            let run = within(&folder, &[&["plot", "motion", model], &motion[..], &[picture]].concat());
            is_fault(&run, "this command reads that file");
        }
    }
    let line = format!("\"$L\" plot motion - {} own.lag < own.lag", motion.join(" "));
    is_fault(&shell(&folder, &line), "this command reads that file");
    let line = format!("\"$L\" plot motion own.lag {} out > out", motion.join(" "));
    is_fault(&shell(&folder, &line), "has written it already");
    fs::remove_file(folder.join("out")).unwrap();
    let period = ["plot", "period", "own.lag", "--over", "energy=1..2:2", "-o"];
    is_fault(&within(&folder, &[&period[..], &["hard.lag"]].concat()), "this command reads that file");
    fs::copy("models/mathieu.lag", folder.join("z.lag")).unwrap();
    let chart = ["floquet", "z.lag", "--map", "a=0..1:2", "q=0..1:2"];
    is_fault(&within(&folder, &[&chart[..], &["--borders", "z.lag"]].concat()), "this command reads that file");
    let drawn = [&["plot"], &chart[..], &["--borders", "b", "-o", "./b"]].concat();
    is_fault(&within(&folder, &drawn), "has written it already");
    fs::remove_file(folder.join("b")).unwrap();
    fs::remove_file(folder.join("z.lag")).unwrap();
    assert_eq!(fs::read_to_string(folder.join("own.lag")).unwrap(), text);
    assert_eq!(names(&folder), before);
}

#[test]
fn pictures_are_whole_and_keep_permissions_and_links() {
    let folder = folder("pictures");
    fs::write(folder.join("m.lag"), NEAT).unwrap();
    let draw = |picture: &str| {
        let arguments = ["plot", "motion", "m.lag", "--start", "x=1", "--until", "1", "-o", picture];
        within(&folder, &arguments)
    };
    assert_eq!(draw("new.svg").status, 0);
    let new = fs::read_to_string(folder.join("new.svg")).unwrap();
    assert!(new.trim_end().ends_with("</svg>"));
    // As the shell makes files.
    assert_eq!(shell(&folder, "> made").status, 0);
    let mode = |name: &str| folder.join(name).metadata().unwrap().mode();
    assert_eq!(mode("new.svg"), mode("made"));
    let old = "x".repeat(3 * new.len());
    fs::write(folder.join("old.svg"), &old).unwrap();
    fs::set_permissions(folder.join("old.svg"), PermissionsExt::from_mode(0o640)).unwrap();
    symlink("old.svg", folder.join("soft.svg")).unwrap();
    symlink("later.svg", folder.join("dangling.svg")).unwrap();
    for picture in ["soft.svg", "dangling.svg", "/dev/null"] {
        assert_eq!(draw(picture).status, 0, "{picture}");
    }
    assert_eq!(fs::read_to_string(folder.join("old.svg")).unwrap(), new);
    assert_eq!(fs::read_to_string(folder.join("later.svg")).unwrap(), new);
    assert_eq!(mode("old.svg") & 0o7777, 0o640);
    fs::write(folder.join("made"), &old).unwrap();
    fs::hard_link(folder.join("made"), folder.join("hard.svg")).unwrap();
    assert_eq!(draw("hard.svg").status, 0);
    assert_eq!(fs::read_to_string(folder.join("made")).unwrap(), new);
    is_fault(&draw("none/x.svg"), "there is no such folder");
    is_fault(&draw("."), "it is a directory");
    fs::set_permissions(folder.join("old.svg"), PermissionsExt::from_mode(0o444)).unwrap();
    is_fault(&draw("old.svg"), "writing it is not permitted");
    let all = ["dangling.svg", "hard.svg", "later.svg", "m.lag", "made", "new.svg", "old.svg", "soft.svg"];
    assert_eq!(names(&folder), all);
}

#[test]
fn formatting_keeps_hard_links_long_names_and_what_others_write() {
    let folder = folder("fmt");
    let long = format!("{}.lag", "n".repeat(251));
    fs::write(folder.join(&long), MESSY).unwrap();
    fs::hard_link(folder.join(&long), folder.join("hard.lag")).unwrap();
    for name in ["hard.lag", &long] {
        fs::write(folder.join(name), MESSY).unwrap();
        assert_eq!(within(&folder, &["fmt", name]).status, 0);
        assert_eq!(fs::read_to_string(folder.join(&long)).unwrap(), NEAT);
        assert_eq!(folder.join("hard.lag").metadata().unwrap().nlink(), 2);
    }
    fs::remove_file(folder.join("hard.lag")).unwrap();
    fs::write(folder.join(&long), MESSY).unwrap();
    assert_eq!(within(&folder, &["fmt", &long]).status, 0);
    assert_eq!(fs::read_to_string(folder.join(&long)).unwrap(), NEAT);
    fs::remove_file(folder.join(&long)).unwrap();
    // While a large file is formatted, somebody saves another one.
    let file = folder.join("large.lag");
    fs::write(&file, format!("{MESSY}{}", "param a=(1)\n".repeat(200_000))).unwrap();
    let mut child = command(&["fmt", "large.lag"]).current_dir(&folder).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(100));
    let still = child.try_wait().unwrap().is_none();
    if still {
        fs::write(&file, "# new\n").unwrap();
    }
    let output = child.wait_with_output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    if still {
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains("it has been changed since"), "{message}");
        assert_eq!(fs::read_to_string(&file).unwrap(), "# new\n");
    }
    assert_eq!(names(&folder), ["large.lag"]);
}

/// No control characters but the ends of lines, no colours where none are asked for, no marks of direction.
fn is_clean(text: &str) -> bool {
    !text.chars().any(|c| {
        c.is_control() && c != '\n'
            || matches!(c, '\u{61c}' | '\u{200e}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    })
}

#[test]
fn nothing_hidden_reaches_a_terminal() {
    let folder = folder("hidden");
    let evil = "a\u{1b}[31m\u{9b}8m\u{202e}\u{2066}\r\u{7f}\u{61c}\u{b}b";
    let name = format!("{}.lag", evil.replace('\u{b}', ""));
    let neat = format!("# {evil}\ncoord x\nT = 1/2*x'^2\nV = 2*x^2\n");
    let models = [
        neat.clone(),
        neat.replace("T =", "T="),
        format!("coord x # {evil}\nT = 1/2*x'^2 + zz # {evil}\nV = 2*x^2 # {evil}"),
        format!("table q = \"{evil}.csv\"  coord x  T = x'^2"),
        "coord x\u{85}  T = x'^2 \u{202e} + \u{1b}[2Jy".to_owned(),
        format!("{} + zz + {}", neat, "é*x + ".repeat(5000)),
        "coord x  coord x  param k = zz".to_owned(),
    ];
    for model in &models {
        fs::write(folder.join(&name), model).unwrap();
        for arguments in
            [&["check", &name][..], &["fmt", "--check", &name], &["modes", &name], &["check", &name, &name]]
        {
            let run = within(&folder, arguments);
            assert!(is_clean(&run.out) && is_clean(&run.err), "{}{}", run.out, run.err);
            let run = within(&folder, &[arguments, &["--message-format", "json"]].concat());
            assert!(is_clean(&run.out) && is_clean(&run.err), "{}{}", run.out, run.err);
            // With colours there are ours and no others.
            let mut colored = command(arguments);
            colored.current_dir(&folder).env("CLICOLOR_FORCE", "1").env_remove("NO_COLOR");
            let run = finish(colored, b"");
            let bare = (run.out + &run.err).replace("\u{1b}[", "");
            assert!(is_clean(&bare) && !bare.contains("a31m"), "{bare}");
        }
    }
    // The name is whole in JSON, and so is the text that is formatted.
    fs::write(folder.join(&name), "coord x x").unwrap();
    let run = within(&folder, &["check", &name, "--message-format", "json"]);
    let line: serde_json::Value = serde_json::from_str(&run.err).unwrap();
    assert_eq!(line["file"], name);
    let run = finish(command(&["fmt", "-"]), neat.as_bytes());
    assert_eq!(run.out, neat);
    let run = within(&folder, &["modes", "no\u{1b}[2J\u{9b}.lag"]);
    assert!(run.status == 1 && is_clean(&run.err), "{}", run.err);
}

#[test]
fn a_result_that_can_not_be_written_is_no_success() {
    let here = Path::new(".");
    for line in [
        "modes models/three_pendulums.lag >&-",
        "modes models/three_pendulums.lag --json > /dev/full",
        "derive models/three_pendulums.lag > /dev/full",
        "explain E0001 >&-",
        "--help >&-",
        "check --help > /dev/full",
        "--version > /dev/full",
        "fmt - < models/three_pendulums.lag >&-",
    ] {
        is_fault(&shell(here, &format!("\"$L\" {line}")), "can't write the result");
    }
    let quiet = "modes models/three_pendulums.lag 2>&1 1<> /dev/null";
    for line in [quiet, "modes models/three_pendulums.lag | true", "fmt models/three_pendulums.lag >&-"] {
        let run = shell(here, &format!("\"$L\" {line}"));
        assert_eq!((run.status, run.err.as_str()), (0, ""), "{line}");
    }
}

/// Tables that are too large are refused before they are computed.
#[test]
fn tables_larger_than_memory_are_refused() {
    let text = "coord x  T = 1/2*x'^2  V = 1/2*x^2";
    let way = ["motion", "-", "--start", "x=1", "--until", "1e6", "--samples"];
    for (samples, numbers, more) in [
        ("1666667", "5000001", &[][..]),
        ("1e7", "30000000", &["--json"]),
        ("1e15", "3000000000000000", &["--proved"]),
        ("1e15", "3000000000000000", &["--tolerance", "1e-9", "--linear"]),
    ] {
        let begun = Instant::now();
        let run = with_input(&[&way[..], &[samples], more].concat(), text);
        assert_eq!((run.status, run.out.as_str()), (1, ""), "{samples}: {}", run.err);
        let told = format!("error[E0609]: a table of {numbers} numbers is too large: at most 5000000");
        assert!(run.err.contains(&told) && run.err.contains("request fewer rows"), "{samples}: {}", run.err);
        assert!(begun.elapsed().as_secs() < 5, "{samples}: {:?}", begun.elapsed());
    }
}

#[test]
fn motions_from_tables() {
    let folder = folder("starts");
    fs::write(
        folder.join("p.lag"),
        "coord x, y\nT = 1/2*(x'^2 + y'^2)\nV = y\nconstraint x^2 + y^2 = 1\nguess y = -1\n",
    )
    .unwrap();
    fs::write(folder.join("starts.csv"), "x,y\n0.6,-0.8\n0.6,-0.9\n0.60001,-0.8\n").unwrap();
    fs::write(folder.join("at.csv"), "t\n0.5\n0\n").unwrap();
    let all = ["motion", "p.lag", "--start-table", "starts.csv", "--at", "at.csv"];
    let run = within(&folder, &all);
    let (out, told) = (run.out, run.err);
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!((lines[0], lines.len(), run.status), ("start,t,x,y,x',y'", 5, 0), "{told}");
    assert!(lines[2] == "1,0.0,0.6000000000,-0.8000000000,0,0" && lines[3].starts_with("3,0.5,"), "{out}");
    assert!(told.contains("error[E0606]: start 2: ") && told.contains("start 3: the start was moved"), "{told}");
    let single = within(&folder, &["motion", "p.lag", "--start", "x=0.6, y=-0.8", "--at", "at.csv"]);
    let single = single.out;
    let own: Vec<String> = single.lines().skip(1).map(|line| format!("1,{line}")).collect();
    assert_eq!(lines[1..3], own);
    let again = within(&folder, &[&all[..], &["--threads", "1"]].concat());
    assert_eq!(again.out, out);
    // Nothing is written over a table, and nothing wrong passes for one.
    fs::write(folder.join("bad.csv"), "x,z\n0.6,1\n").unwrap();
    let bad = within(&folder, &["motion", "p.lag", "--start-table", "bad.csv", "--until", "1"]);
    assert!(bad.err.contains("`z` is not a coordinate") && bad.status == 1);
    let bad = within(&folder, &["motion", "p.lag", "--start", "x=0", "--at", "bad.csv"]);
    assert!(bad.err.contains("there is no column `t`, but x, z") && bad.status == 1);
}

/// In a terminal of its own, which `script` of util-linux opens.
#[cfg(target_os = "linux")]
#[test]
fn long_pages_are_read_in_a_pager() {
    let shown = |pager: &str, model: &str| {
        let program = env!("CARGO_BIN_EXE_librate");
        let mut script = Command::new("script");
        // On a busy machine there may be progress on standard error.
        let command = format!("stty rows 24 cols 80; {program} derive models/{model}.lag 2>/dev/null");
        script.args(["--quiet", "--command", &command, "/dev/null"]).env("PAGER", pager).env("NO_COLOR", "1");
        let output = script.output().unwrap();
        String::from_utf8(output.stdout).unwrap().replace("\r\n", "\n")
    };
    assert_eq!(shown("tail -n 1", "three_pendulums").lines().count(), 1);
    let whole = shown("", "three_pendulums");
    assert!(whole.starts_with("three_pendulums: 3 coordinates") && whole.lines().count() > 24);
    assert_eq!(shown("no-such-pager", "three_pendulums"), whole);
    // What fits is not handed on.
    let check = Command::new("script")
        .args([
            "--quiet",
            "--command",
            &format!("{} check models/three_pendulums.lag", env!("CARGO_BIN_EXE_librate")),
            "/dev/null",
        ])
        .env("PAGER", "false")
        .output()
        .unwrap();
    assert!(String::from_utf8(check.stdout).unwrap().contains("three_pendulums"));
}
