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
