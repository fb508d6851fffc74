//! One direction: modules stand in `lib.rs` in reading order, and a stage imports only from what
//! stands above it.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

use std::path::{Path, PathBuf};

fn modules() -> Vec<String> {
    let lib = std::fs::read_to_string("src/lib.rs").unwrap();
    lib.lines()
        .filter_map(|line| line.strip_prefix("pub mod "))
        .map(|line| line.trim_end_matches(';').to_owned())
        .collect()
}

fn sources(of: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut todo = vec![PathBuf::from("src").join(of)];
    let single = Path::new("src").join(format!("{of}.rs"));
    if single.exists() {
        files.push(single);
    }
    while let Some(folder) = todo.pop() {
        let Ok(entries) = std::fs::read_dir(&folder) else {
            continue;
        };
        for entry in entries {
            let path = entry.unwrap().path();
            if path.is_dir() {
                todo.push(path);
            } else if path.extension().is_some_and(|end| end == "rs") {
                files.push(path);
            }
        }
    }
    assert!(!files.is_empty(), "no sources for {of}");
    files
}

#[test]
fn stages_import_only_from_above() {
    let order = modules();
    assert!(order.len() > 8);
    for (place, module) in order.iter().enumerate() {
        for path in sources(module) {
            let text = std::fs::read_to_string(&path).unwrap();
            let code = text.split("#[cfg(test)]").next().unwrap();
            for (later, other) in order.iter().enumerate() {
                let reaches = code.contains(&format!("crate::{other}::"))
                    || code.contains(&format!("crate::{other};"))
                    || code.contains(&format!("crate::{{{other}"));
                assert!(
                    !reaches || later <= place,
                    "{}: `{module}` reaches forward to `{other}`",
                    path.display()
                );
            }
        }
    }
}

#[test]
fn only_the_parser_sees_pest() {
    for module in modules() {
        for path in sources(&module) {
            let text = std::fs::read_to_string(&path).unwrap();
            let uses = text.contains("use pest") || text.contains("pest::");
            assert!(!uses || module == "syntax", "{}", path.display());
        }
    }
}

#[test]
fn modes_know_no_names_and_expressions() {
    for path in sources("modes") {
        let text = std::fs::read_to_string(&path).unwrap();
        for other in ["expr", "model", "linearize", "syntax", "number"] {
            let code = text.split("#[cfg(test)]").next().unwrap();
            assert!(
                !code.contains(&format!("crate::{other}")),
                "{} uses {other}",
                path.display()
            );
        }
    }
}

#[test]
fn no_stage_of_the_trip_knows_of_batches() {
    for module in modules().iter().filter(|module| *module != "batch") {
        for path in sources(module) {
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(!text.contains("crate::batch"), "{}", path.display());
        }
    }
}

/// The words in quotation marks of a list in deny.toml.
fn allowed(list: &str) -> Vec<String> {
    let text = std::fs::read_to_string("deny.toml").unwrap();
    let (_, rest) = text.split_once(&format!("\n{list} = [")).unwrap();
    let (words, _) = rest.split_once(']').unwrap();
    let words = words.split('"').skip(1).step_by(2);
    words.map(str::to_owned).collect()
}

/// What `cargo deny` checks, for whoever does not have it.
#[test]
fn dependencies_stand_once_and_are_free() {
    let lock = std::fs::read_to_string("Cargo.lock").unwrap();
    let field = |package: &str, name: &str| {
        let line = package.lines().find_map(|line| {
            let value = line.strip_prefix(name)?.strip_prefix(" = \"")?;
            value.strip_suffix('"')
        });
        line.map(str::to_owned)
    };
    let packages: Vec<(String, String)> = lock
        .split("[[package]]\n")
        .skip(1)
        .map(|package| {
            let source = field(package, "source");
            let registry = "registry+https://github.com/rust-lang/crates.io-index";
            assert!(source.is_none_or(|source| source == registry), "{package}");
            (
                field(package, "name").unwrap(),
                field(package, "version").unwrap(),
            )
        })
        .collect();
    let skipped = allowed("skip");
    for pair in packages.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let (name, version) = &pair[0];
        let fits = |skip: &String| {
            let (own, start) = skip.split_once('@').unwrap();
            own == name && format!("{version}.").starts_with(&format!("{start}."))
        };
        assert!(
            skipped.iter().any(fits),
            "{name} {version} and {}",
            pair[1].1
        );
    }
}

/// Each license in words like `(MIT OR Apache-2.0) AND Unicode-3.0` leaves one that deny.toml allows.
#[test]
fn licenses_are_those_allowed() {
    let allowed = allowed("allow");
    let listed = std::process::Command::new(env!("CARGO"))
        .args([
            "tree",
            "--locked",
            "--offline",
            "--all-features",
            "--edges",
            "normal,build",
            "--prefix",
            "none",
            "--format",
            "{l}",
        ])
        .output()
        .unwrap();
    assert!(
        listed.status.success(),
        "{}",
        String::from_utf8_lossy(&listed.stderr)
    );
    let listed = String::from_utf8(listed.stdout).unwrap();
    assert!(listed.lines().count() > 50);
    for license in listed.lines().map(|line| line.trim_end_matches(" (*)")) {
        let fine = license.split(" AND ").all(|part| {
            let mut choices = part
                .trim_matches(['(', ')'])
                .split(" OR ")
                .flat_map(|own| own.split('/'));
            choices.any(|one| allowed.iter().any(|own| own == one))
        });
        assert!(fine, "{license}");
    }
}
