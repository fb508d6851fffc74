//! Answers while a model is being written: `watch` and `repl`.
#![cfg(all(feature = "cli", unix))]

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use crate::cli_support::*;

const MODEL: &str = "param k = 1\ncoord x\nT = 1/2*x'^2\nV = 1/2*k*x^2\n";

/// An empty folder of a test's own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("typing").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// A command that goes on, with its lines as they come; it ends with this.
struct Going {
    child: Child,
    lines: Receiver<String>,
}

fn lines(from: impl Read + Send + 'static, to: std::sync::mpsc::Sender<String>) {
    thread::spawn(move || {
        for line in BufReader::new(from).lines() {
            let Ok(line) = line else { return };
            if to.send(line).is_err() {
                return;
            }
        }
    });
}

impl Going {
    fn new(folder: &Path, arguments: &[&str]) -> Self {
        let mut command = command(arguments);
        command.current_dir(folder).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let (sender, received) = channel();
        lines(child.stdout.take().unwrap(), sender.clone());
        lines(child.stderr.take().unwrap(), sender);
        Self { child, lines: received }
    }

    /// Waits for a line with this in it.
    #[track_caller]
    fn expect(&self, part: &str) {
        let mut told = Vec::new();
        loop {
            match self.lines.recv_timeout(Duration::from_secs(60)) {
                Ok(line) if line.contains(part) => return,
                Ok(line) => told.push(line),
                Err(_) => panic!("no `{part}` in {told:#?}"),
            }
        }
    }
}

impl Drop for Going {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_saved_model_is_answered_again() {
    let folder = folder("saved");
    let file = folder.join("model.lag");
    fs::write(&file, MODEL).unwrap();
    let going = Going::new(&folder, &["watch", "model.lag", "--digits", "5"]);
    going.expect("1.0000");
    fs::write(&file, MODEL.replace("k = 1", "k = 4")).unwrap();
    going.expect("2.0000");
    fs::write(&file, MODEL.replace("k*x^2", "j*x^2")).unwrap();
    going.expect("`j` is not declared");
    // As editors do it: another file in place of this one.
    let other = folder.join("model.lag~");
    fs::write(&other, MODEL.replace("k = 1", "k = 9")).unwrap();
    fs::rename(&other, &file).unwrap();
    going.expect("3.0000");
}

#[test]
fn a_saved_table_is_answered_again() {
    let folder = folder("table");
    fs::write(folder.join("k.csv"), "k\n16\n").unwrap();
    let model = "table springs = \"k.csv\"\ncoord x\nT = 1/2*x'^2\nV = sum(s in springs, 1/2*s.k*x^2)\n";
    fs::write(folder.join("model.lag"), model).unwrap();
    let going = Going::new(&folder, &["watch", "derive", "model.lag", "--json"]);
    going.expect("x'' + 16*x = 0");
    fs::write(folder.join("k.csv"), "k\n25\n").unwrap();
    going.expect("x'' + 25*x = 0");
}

#[test]
fn a_page_knows_of_a_newer_one() {
    let folder = folder("page");
    fs::write(folder.join("model.lag"), MODEL).unwrap();
    let version = || fs::read_to_string(folder.join("page.html.js")).unwrap_or_default();
    let page = || fs::read_to_string(folder.join("page.html")).unwrap_or_default();
    let own = |text: &str| text.split('"').nth(1).unwrap_or("none").to_owned();
    let wait = |done: &dyn Fn() -> bool| {
        assert!((0..600).any(|_| done() || {
            thread::sleep(Duration::from_millis(100));
            false
        }));
    };
    let _going = Going::new(&folder, &["watch", "show", "model.lag", "-o", "page.html"]);
    wait(&|| page().contains(&format!("'{}'", own(&version()))));
    let first = version();
    fs::write(folder.join("model.lag"), MODEL.replace("k = 1", "k = 4")).unwrap();
    wait(&|| version() != first && page().contains(&format!("'{}'", own(&version()))));
    // What is wrong is beside the page, which stays as it was, until it is mended.
    let (good, last) = (fs::read_to_string(folder.join("model.lag")).unwrap(), page());
    fs::write(folder.join("model.lag"), good.replace("param k", "param q")).unwrap();
    wait(&|| version().starts_with("window.librateFault = \"error") && version().contains("`k` is not declared"));
    assert_eq!(page(), last);
    fs::write(folder.join("model.lag"), good).unwrap();
    wait(&|| version().ends_with("window.librateFault = null;\n"));
}

#[test]
fn what_can_not_be_watched() {
    let told = |arguments: &[&str]| {
        let run = run(arguments);
        (run.status, run.err)
    };
    let (status, text) = told(&["watch", "fmt", "models/three_pendulums.lag"]);
    assert!(status == 1 && text.contains("only commands that read one model"), "{text}");
    let (status, text) = told(&["watch", "-"]);
    assert!(status == 1 && text.contains("standard input is never saved"), "{text}");
    let (status, text) = told(&["watch", "modes", "models/three_pendulums.lag", "--digit"]);
    assert!(status == 2 && text.contains("--digit"), "{text}");
    let (status, text) = told(&["watch", "nowhere/model.lag"]);
    assert!(status == 1 && text.contains("can't watch `nowhere/model.lag`"), "{text}");
}

/// What a conversation prints.
fn answers(folder: &Path, arguments: &[&str], typed: &str) -> Run {
    let mut command = command(&[&["repl"], arguments].concat());
    command.current_dir(folder);
    finish(command, typed.as_bytes())
}

#[test]
fn frequencies_move_with_what_is_typed() {
    let folder = folder("typed");
    let typed = "coord x\nT = 1/2*x'^2\nparam k = 4\nV = 1/2*k*x^2\nk = 9  # (N/m\nundo\n\
                 V = 1/2*k*(\n  x^2 + x^2)\nparam c = 2\nV = 1/2*k*c^2*x^2\ntext\nsave model.lag\nquit\nV = nonsense\n";
    let run = answers(&folder, &[], typed);
    assert_eq!((run.status, run.err.as_str()), (0, ""));
    let omegas: Vec<&str> = run.out.lines().filter(|line| line.contains("omega")).map(str::trim).collect();
    assert_eq!(
        omegas,
        [
            "1  oscillation  omega 2.000000000",
            "1  oscillation  omega 3.000000000   was 2.000000000",
            "1  oscillation  omega 2.000000000   was 3.000000000",
            "1  oscillation  omega 2.828427125   was 2.000000000",
            "1  oscillation  omega 2.828427125",
            "1  oscillation  omega 4.000000000   was 2.828427125",
        ]
    );
    // What others need stands above them.
    let model = "param k = 4\nparam c = 2\ncoord x\nT = 1/2*x'^2\nV = 1/2*k*c^2*x^2\n";
    assert!(run.out.ends_with(model), "{}", run.out);
    assert_eq!(fs::read_to_string(folder.join("model.lag")).unwrap(), model);
    let again = answers(&folder, &["model.lag"], "k = 1\n");
    assert!(again.out.ends_with("omega 2.000000000   was 4.000000000\n"), "{}", again.out);
}

/// Members of a family that are declared one by one stay, and so does what a statement declares beside a name.
#[test]
fn statements_replace_what_they_declare_and_nothing_else() {
    let typed = "param a = 1, k = 1\ncoord x[1..2]\nlet u[0] = a\nlet u[i in 1..2] = u[i-1]*x[i]\n\
                 T = 1/2*dot(x', x')\nV = 1/2*k*dot(x, x) + u[2]\nforce x[1] = -1/2*x[1]'\nforce x[2] = -x[2]'\n\
                 force x[ 2 ] = -1/5*x[2]'\nlet u[j in 1..2] = u[j-1]*x[j]^2\nparam k = 5\nk = 4\ntext\n";
    let run = answers(&folder("replaced"), &[], typed);
    let model = "param a = 1, k = 4\ncoord x[1..2]\nlet u[0] = a\nlet u[j in 1..2] = u[j-1]*x[j]^2\nT = 1/2*dot(x', x')\n\
                 V = 1/2*k*dot(x, x) + u[2]\nforce x[1] = -1/2*x[1]'\nforce x[ 2 ] = -1/5*x[2]'\n";
    assert!(run.out.ends_with(model), "{}", run.out);
    assert!(run.err.contains("`a` is declared in the same statement"), "{}", run.err);
    let run = answers(&folder("replaced"), &[], "param a = 1\nparam k = 1\nparam k = 2, a = 3\ntext\n");
    assert_eq!(run.out, "param k = 2, a = 3\n");
    // All of a family takes the place of a member, and of what had its name.
    let typed =
        "param k = 3\nparam k[1..2] = 5\ncoord x[1..2]\nguess x[1] = 1/10\nguess x[1..2] = 1/5\nguess x[2] = 1\ntext\n";
    let run = answers(&folder("replaced"), &[], typed);
    assert_eq!(run.out, "param k[1..2] = 5\ncoord x[1..2]\nguess x[1..2] = 1/5\n");
    assert!(run.err.contains("x[2]` is declared with others of its family"), "{}", run.err);
    let run = answers(&folder("replaced"), &[], "param a[1] = 1, a[2] = 2\nparam a[1] = 5\ntext\n");
    assert_eq!(run.out, "param a[1] = 1, a[2] = 2\n");
}

/// The model after the last line, and what is said.
fn typed(text: &str) -> (String, String) {
    let run = answers(&folder("values"), &[], &format!("{text}\ntext\n"));
    (run.out, run.err)
}

#[test]
fn names_members_and_shared_names_take_other_values() {
    for (text, model) in [
        ("param m[1..2] = [3, 4]\nm[2] = 7", "param m[1..2] = [3, 7]\n"),
        ("param m[0..2] : kg = 5\nm[1] = 7/2", "param m[0..2] : kg = [5, 7/2, 5]\n"),
        ("param m[1..2] = 2\nm = [3,4]", "param m[1..2] = [3,4]\n"),
        ("param m[1..2] = [3, 4]\nm = 5", "param m[1..2] = 5\n"),
        ("param m[1] = 1, m[2] = 2\nm[ 2 ] = 3", "param m[1] = 1, m[2] = 3\n"),
        ("param A[1,2] = 1\nA[1][2] = 3", "param A[1,2] = 3\n"),
        ("param a, b = 3\na = 2", "param b = 3, a = 2\n"),
        ("param a, b, c : kg = 3 ± 0.1, d = 4\nb = 2", "param a, c : kg = 3 ± 0.1, d = 4, b : kg = 2 ± 0.1\n"),
        ("param a, b : kg\na = 2", "param b : kg, a : kg = 2\n"),
        ("param k : N/m\nk = 2", "param k : N/m = 2\n"),
        ("let y = 2\ny = 3", "let y = 3\n"),
        ("param k = (4) ± 0.1\nk = 9   # stiffer", "param k = 9 ± 0.1\n"),
        ("param k = 4 ± 0.1, j = 1\nk = 9 +/- 0.2  # stiffer", "param k = 9 +/- 0.2, j = 1\n"),
    ] {
        assert_eq!(typed(text), (model.to_owned(), String::new()), "{text}");
    }
}

/// What is said of a value that no statement has, and nothing changes.
#[test]
fn values_without_a_place_are_explained() {
    for (before, line, part) in [
        ("coord x\n", "x = 3", "write `equilibrium x = …`"),
        ("param m[i in 1..3] = i\n", "m[2] = 7", "`m = VALUE` gives one to all of `m`"),
        ("param m[1..2] = 2\n", "m = [3, 4, 5]", "`m` has 2 members, but 3 values are given"),
        ("param m[1..2] = 2\n", "m[3] = 4", "`m[3]` has no value of its own"),
        ("param a[1..2], b[1..2] = 2\n", "a[2] = 4", "`a[2]` has no value of its own"),
        ("let y = 2\n", "y = 3 ± 1", "E0041"),
        ("param m[1] = 1\nparam m[2] = 2\n", "m = [3, 4]", "error"),
        ("coord x, y\n", "coord x : m", "`y` is declared in the same statement: declare all of it again\n"),
    ] {
        let (model, told) = typed(&format!("{before}{line}"));
        assert!(model == before && told.contains(part), "{line}: {told}\n{model}");
    }
}

#[test]
fn a_period_is_a_statement_or_a_command() {
    let model = "param W = 2\ncoord x\nT = 1/2*x'^2\nV = 1/2*x^2\n";
    let (out, told) = typed(&format!("{model}period 2*pi/W\nundo\nperiod --amplitude 1"));
    assert!(out.ends_with(model) && out.contains("6.28318"), "{out}{told}");
    assert!(typed("param W = 2\nperiod 2*pi/W").0.ends_with("period 2*pi/W\n"));
}

#[test]
fn other_commands_have_the_model_typed_so_far() {
    let folder = folder("commands");
    fs::write(folder.join("model.lag"), MODEL).unwrap();
    let run = answers(
        &folder,
        &["model.lag"],
        "derive --only mass\nmodes --digits 4 --no-vectors\nplot motion --start 'x=1' --until 1 --samples 3 -o m.svg\nexplain E0101\n",
    );
    assert_eq!(run.status, 0, "{}", run.err);
    assert!(
        run.out.contains("mass matrix M") && run.out.contains("1.000 ") && run.out.contains("E0101"),
        "{}",
        run.out
    );
    assert!(fs::read_to_string(folder.join("m.svg")).unwrap().starts_with("<svg"));
}

/// Mistakes are told, and change nothing that was there.
#[test]
fn mistakes_do_not_end_the_conversation() {
    let folder = folder("mistakes");
    fs::write(folder.join("model.lag"), MODEL).unwrap();
    fs::write(folder.join("other.lag"), MODEL).unwrap();
    let typed = "nonsense here\nj = 3\nundo\nV = 1/2*(\n)\nV = 1/2*z*x^2\nundo\nk = 1 +\nk = 2/0\nundo\nk\nx\nmode\nfoo\n\
                 set k = 2\nsave other.lag\nsave model.lag\n\nsave\ntext\n\u{1}\n";
    let run = answers(&folder, &["model.lag"], typed);
    assert_eq!(run.status, 0);
    for part in [
        "there is no statement `nonsense`",
        "a statement word is missing before `j`",
        "nothing has been changed",
        "`z` is not declared",
        "save it where",
        "divisor 0 is not defined",
        "`k = VALUE` gives the parameter another value",
        "`x` is declared",
        "did you mean `modes`?",
        "there is no command `foo`: `help`",
        "write `k = 2`",
        "`other.lag` is there already",
    ] {
        assert!(run.err.contains(part), "{part}: {}", run.err);
    }
    assert!(run.out.ends_with(MODEL), "{}", run.out);
    assert_eq!(answers(&folder, &["nowhere.lag"], "").status, 1);
}
