//! One direction: modules stand in `lib.rs` in reading order, and a stage imports only from what
//! stands above it.

use std::path::{Path, PathBuf};

/// The modules in which stages and studies stand, in reading order, each by its folder or file without its end; the report
/// is one.
fn modules() -> Vec<String> {
    let mut modules = Vec::new();
    for own in ["core", "studies"] {
        let lib = std::fs::read_to_string(format!("src/{own}/lib.rs")).unwrap();
        let lines = lib.lines().filter_map(|line| line.strip_prefix("pub mod ").or_else(|| line.strip_prefix("mod ")));
        modules.extend(lines.map(|line| format!("{own}/{}", line.trim_end_matches(';'))));
    }
    modules.push("report".to_owned());
    modules
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

/// Within a crate; that no crate uses a later one is cargo's to see.
#[test]
fn stages_import_only_from_above() {
    let order = modules();
    assert!(order.len() > 20);
    for (place, module) in order.iter().enumerate() {
        for path in sources(module) {
            let code = std::fs::read_to_string(&path).unwrap();
            for other in &order[place + 1..] {
                let Some((own, name)) = other.split_once('/').filter(|(own, _)| module.starts_with(own)) else {
                    continue;
                };
                let reaches = ["::", ";", ","].iter().any(|end| code.contains(&format!("crate::{name}{end}")))
                    || code.contains(&format!("crate::{{{name}"));
                assert!(!reaches, "{}: `{module}` reaches forward to `{own}/{name}`", path.display());
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
            assert!(!uses || module == "core/syntax", "{}", path.display());
        }
    }
}

#[test]
fn modes_know_no_names_and_expressions() {
    for path in sources("core/modes") {
        let text = std::fs::read_to_string(&path).unwrap();
        for other in ["expr", "model", "linearize", "syntax", "number"] {
            let code = text.as_str();
            assert!(!code.contains(&format!("crate::{other}")), "{} uses {other}", path.display());
        }
    }
}

#[test]
fn no_stage_of_the_trip_knows_of_batches() {
    // A sweep has small models solved in batches, and modes followed by the shapes of these.
    let own = ["studies/batch", "studies/sweep", "studies/tracking"];
    let others = modules().into_iter().filter(|module| !own.contains(&module.as_str()));
    for module in others {
        for path in sources(&module) {
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(!text.contains("::batch"), "{}", path.display());
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

/// What `cargo deny` checks, for whoever does not have it: crates of the registry alone, each once, with a license that
/// leaves one which deny.toml allows, in words like `(MIT OR Apache-2.0) AND Unicode-3.0`.
#[test]
fn dependencies_stand_once_and_are_free() {
    let listed = std::process::Command::new(env!("CARGO"))
        .args(["tree", "--locked", "--offline", "--package", "librate", "--all-features"])
        .args(["--edges", "normal,build", "--prefix", "none"])
        .args(["--no-dedupe", "--format", "{p}|{l}"])
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&listed.stderr);
    assert!(listed.status.success(), "{errors}");
    let listed = String::from_utf8(listed.stdout).unwrap();
    let mut crates: Vec<&str> = listed.lines().filter(|line| !line.contains("(/")).collect();
    crates.sort_unstable();
    crates.dedup();
    assert!(crates.len() > 50);
    let (skipped, licenses) = (allowed("skip"), allowed("allow"));
    let mut before = ("", "");
    for line in crates {
        let (package, license) = line.split_once('|').unwrap();
        let mut words = package.split(' ');
        let (name, version) = (words.next().unwrap(), words.next().unwrap());
        assert!(words.all(|word| word == "(proc-macro)"), "{package}");
        let old = format!("{}.", before.1.trim_start_matches('v'));
        let fits = |skip: &String| {
            let (own, start) = skip.split_once('@').unwrap();
            own == name && old.starts_with(&format!("{start}."))
        };
        let once = before.0 != name || skipped.iter().any(fits);
        assert!(once, "{name} {} and {version}", before.1);
        before = (name, version);
        let fine = license.split(" AND ").all(|part| {
            let choices = part.trim_matches(['(', ')']).split(" OR ");
            let mut choices = choices.flat_map(|own| own.split('/'));
            choices.any(|one| licenses.iter().any(|own| own == one))
        });
        assert!(fine, "{line}");
    }
}

/// It is built with all that there is, too, as the other examples are.
#[test]
fn the_example_of_an_embedder_needs_the_parser_alone() {
    let code = std::fs::read_to_string("examples/embed_parser.rs").unwrap();
    let mut used = code.split("use librate::").skip(1).map(|rest| rest.split(':').next().unwrap());
    let parser = ["span", "diagnostic", "explain", "syntax"];
    assert!(code.contains("use librate::syntax::") && used.all(|module| parser.contains(&module)));
}
