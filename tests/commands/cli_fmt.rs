//! `librate fmt` from outside.
#![cfg(feature = "cli")]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const MESSY: &str = "coord x\n\n\n\nT=1/2*x'^2 # kinetic\nV = (2*x^2)\n";
const NEAT: &str = "coord x\n\nT = 1/2*x'^2  # kinetic\nV = 2*x^2\n";

struct Run {
    status: i32,
    out: String,
    err: String,
}

fn fmt(arguments: &[&str], input: &[u8], folder: &Path) -> Run {
    let mut child = Command::new(env!("CARGO_BIN_EXE_librate"))
        .arg("fmt")
        .args(arguments)
        .current_dir(folder)
        .env_remove("CLICOLOR_FORCE")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let _ = child.stdin.take().unwrap().write_all(input);
    let output = child.wait_with_output().unwrap();
    Run {
        status: output.status.code().expect("not killed by a signal"),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

/// An empty folder of a test's own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli_fmt").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn silent(run: &Run) -> bool {
    (run.status, run.out.as_str(), run.err.as_str()) == (0, "", "")
}

#[test]
fn files_are_rewritten_where_they_stand() {
    let folder = folder("rewritten");
    std::fs::write(folder.join("a.lag"), MESSY).unwrap();
    std::fs::write(folder.join("b.lag"), MESSY.replace('\n', "\r\n")).unwrap();
    std::fs::write(folder.join("c.lag"), NEAT).unwrap();
    let long_ago = std::time::UNIX_EPOCH;
    let neat = std::fs::File::options().append(true).open(folder.join("c.lag")).unwrap();
    neat.set_modified(long_ago).unwrap();
    assert!(silent(&fmt(&["a.lag", "b.lag", "c.lag"], b"", &folder)));
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert_eq!(read("a.lag"), NEAT);
    assert_eq!(read("b.lag"), NEAT.replace('\n', "\r\n"));
    // What is in order isn't touched, and nothing is left lying about.
    assert_eq!(neat.metadata().unwrap().modified().unwrap(), long_ago);
    assert_eq!(names(&folder), ["a.lag", "b.lag", "c.lag"]);
    assert!(silent(&fmt(&["--check", "a.lag", "b.lag", "c.lag"], b"", &folder)));
}

#[test]
fn standard_input_goes_to_standard_output() {
    let here = Path::new(".");
    let run = fmt(&["-"], MESSY.as_bytes(), here);
    assert_eq!((run.status, run.out.as_str(), run.err.as_str()), (0, NEAT, ""));
    let run = fmt(&["-"], NEAT.as_bytes(), here);
    assert_eq!((run.status, run.out.as_str()), (0, NEAT));
    let run = fmt(&["-", "--check"], NEAT.as_bytes(), here);
    assert!(silent(&run));
}

#[test]
fn check_shows_the_difference_and_writes_nothing() {
    let folder = folder("check");
    std::fs::write(folder.join("messy.lag"), MESSY).unwrap();
    std::fs::write(folder.join("neat.lag"), NEAT).unwrap();
    let run = fmt(&["--check", "neat.lag", "messy.lag"], b"", &folder);
    assert_eq!((run.status, run.err.as_str()), (1, ""));
    insta::assert_snapshot!(run.out);
    assert_eq!(std::fs::read_to_string(folder.join("messy.lag")).unwrap(), MESSY);
    let run = fmt(&["--check", "-"], MESSY.as_bytes(), &folder);
    assert_eq!(run.status, 1);
    assert!(run.out.starts_with("--- <stdin>\n+++ <stdin> (formatted)\n"), "{}", run.out);
}

#[test]
fn mistakes_leave_a_file_alone_and_the_others_are_done() {
    let folder = folder("mistakes");
    let broken = "coord x\nV = 2 x\n";
    std::fs::write(folder.join("broken.lag"), broken).unwrap();
    std::fs::write(folder.join("messy.lag"), MESSY).unwrap();
    let run = fmt(&["broken.lag", "no_such.lag", "messy.lag"], b"", &folder);
    assert_eq!((run.status, run.out.as_str()), (1, ""));
    assert!(run.err.contains("the multiplication sign is missing"), "{}", run.err);
    assert!(run.err.contains("broken.lag:2:5"), "{}", run.err);
    assert!(run.err.contains("there is no such file"), "{}", run.err);
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert_eq!((read("broken.lag").as_str(), read("messy.lag").as_str()), (broken, NEAT));
    assert_eq!(names(&folder), ["broken.lag", "messy.lag"]);
    let run = fmt(&["-"], broken.as_bytes(), &folder);
    assert_eq!((run.status, run.out.as_str()), (1, ""));
}

#[test]
fn wrong_usage() {
    let here = Path::new(".");
    for arguments in [&[][..], &["--check"], &["--set", "a=1", "-"], &["--json", "-"]] {
        let run = fmt(arguments, b"", here);
        assert_eq!((run.status, run.out.as_str()), (2, ""), "{arguments:?}");
        assert!(!run.err.is_empty());
    }
}

#[test]
fn models_are_canonical() {
    let here = Path::new(".");
    let mut files = vec!["--check".to_owned()];
    files.extend(
        names(Path::new("models"))
            .into_iter()
            .filter(|name| name.ends_with(".lag"))
            .map(|name| format!("models/{name}")),
    );
    assert!(files.len() > 50);
    let files: Vec<&str> = files.iter().map(String::as_str).collect();
    let run = fmt(&files, b"", here);
    assert_eq!((run.status, run.out.as_str(), run.err.as_str()), (0, "", ""));
}

#[cfg(unix)]
#[test]
fn permissions_and_links_stay() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = folder("permissions");
    let file = folder.join("real.lag");
    std::fs::write(&file, MESSY).unwrap();
    std::fs::set_permissions(&file, PermissionsExt::from_mode(0o754)).unwrap();
    symlink("real.lag", folder.join("link.lag")).unwrap();
    assert!(silent(&fmt(&["link.lag"], b"", &folder)));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), NEAT);
    assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o754);
    assert!(folder.join("link.lag").symlink_metadata().unwrap().is_symlink());
    assert_eq!(names(&folder), ["link.lag", "real.lag"]);
    // A file that mustn't be written isn't.
    std::fs::write(&file, MESSY).unwrap();
    std::fs::set_permissions(&file, PermissionsExt::from_mode(0o444)).unwrap();
    let run = fmt(&["real.lag"], b"", &folder);
    assert_eq!(run.status, 1);
    assert!(run.err.contains("writing it is not permitted"), "{}", run.err);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), MESSY);
}
