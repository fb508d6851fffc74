//! The language, sentence by sentence, and problems of textbooks: every file of tests/language and tests/problems against
//! what its header says.
//!
//! The header is comments of the form `# word: value`. Lines with `#:` are the closed form, in
//! Python with mpmath; tests/language/expect.py computes the expected digits from them and writes
//! them below, so that no expectation comes from this project's own code.
//!
//! | word | meaning |
//! | --- | --- |
//! | `omega`, `growth` | one number a mode, in the order printed |
//! | `kinds`, `stability` | what the modes are |
//! | `equilibrium` | one number a coordinate |
//! | `symmetry` | one class a mode |
//! | `set` | a value from outside, as `--set` takes it |
//! | `same` | another file with the same results |
//! | `error`, `at` | part of the message of some error, and its line:column |
#![cfg(feature = "engine")]

use crate::language_support;

use std::path::{Path, PathBuf};

use language_support::{Case, Fault, run};
use librate::number::Number;
use librate::precision::{Ball, Scalar};

fn files() -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = ["tests/language", "tests/problems"]
        .into_iter()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "lag"))
        .collect();
    files.sort();
    files
}

/// A decimal number of any length as an enclosure.
fn ball(text: &str) -> Ball {
    let (negative, digits) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let number = Number::parse(digits).unwrap_or_else(|| panic!("{text} is no number"));
    Ball::from_number(&if negative { number.neg() } else { number }, ())
}

/// The relative error, and whether the bound holds beside the digits of the expectation.
fn compare(what: &str, own: &Ball, want: &str, faults: &mut Vec<String>) {
    let want = ball(want);
    let distance = own.sub(&want).mid_f64().abs();
    let size = want.mid_f64().abs();
    if size == 0.0 && what != "equilibrium" && !own.is_zero() {
        faults.push(format!("{what} should be exactly 0, is {:e} ± {:e}", own.mid_f64(), own.radius));
    }
    if distance > own.radius + 1e-18 * size {
        faults.push(format!(
            "{what} {:e} ± {:e} does not hold {:e} (off by {distance:e})",
            own.mid_f64(),
            own.radius,
            want.mid_f64()
        ));
    }
    if size > 0.0 && distance > 1e-13 * size {
        faults.push(format!("{what} {:e} is off by {:e} from {:e}", own.mid_f64(), distance / size, want.mid_f64()));
    }
}

/// Compares one file with its header; gives what is wrong with it.
fn faults(path: &Path) -> Vec<String> {
    let mut case = Case::read(path);
    let mut faults = Vec::new();
    let result = run(path, &case.settings);
    if let Some(message) = &case.error {
        match result {
            Ok(_) => faults.push("there is no error".to_owned()),
            Err(Fault { messages }) => {
                let found = messages.iter().any(|(text, place)| {
                    text.contains(message) && case.at.as_ref().is_none_or(|at| Some(at) == place.as_ref())
                });
                if !found {
                    faults.push(format!("other errors: {messages:?}"));
                }
            }
        }
        return faults;
    }
    let done = match result {
        Ok(done) => done,
        Err(Fault { messages }) => return vec![format!("refused: {messages:?}")],
    };
    if let Some(other) = &case.same {
        let settings = case.settings.clone();
        case = Case::read(&path.with_file_name(other));
        case.settings = settings;
    }
    let modes = &done.normal.modes;
    if case.omega.is_empty() {
        faults.push("nothing is expected".to_owned());
    }
    if modes.len() != case.omega.len() {
        return vec![format!("{} modes instead of {}", modes.len(), case.omega.len())];
    }
    for (i, mode) in modes.iter().enumerate() {
        compare(&format!("omega {}", i + 1), &mode.omega, &case.omega[i], &mut faults);
        let growth = case.growth.get(i).map_or("0", String::as_str);
        compare(&format!("growth {}", i + 1), &mode.growth, growth, &mut faults);
        let kind = mode.kind.as_str();
        if case.kinds.get(i).is_some_and(|want| want != kind) {
            faults.push(format!("mode {} is {kind}", i + 1));
        }
        if let Some(want) = case.symmetry.get(i) {
            let own = mode.symmetry.as_deref().unwrap_or("-");
            if want != own {
                faults.push(format!("symmetry of mode {} is {own}", i + 1));
            }
        }
    }
    let stability = done.normal.stability.as_str();
    if case.stability.as_ref().is_some_and(|want| want != stability) {
        faults.push(format!("the stability is {stability}"));
    }
    let equilibrium = &done.linearized.equilibrium().values;
    if !case.equilibrium.is_empty() && equilibrium.len() != case.equilibrium.len() {
        faults.push(format!("{} coordinates", equilibrium.len()));
    }
    for (own, want) in equilibrium.iter().zip(&case.equilibrium) {
        compare("equilibrium", own, want, &mut faults);
    }
    faults.extend(language_support::check_vectors(&done));
    faults
}

#[test]
fn files_keep_what_their_headers_promise() {
    let only = std::env::var("ONLY").ok();
    let mut failed = 0;
    let mut count = 0;
    for path in files() {
        let name = path.file_name().unwrap().to_string_lossy().to_string();
        if only.as_ref().is_some_and(|only| !name.contains(only.as_str())) {
            continue;
        }
        count += 1;
        // What is known to be missing says so, until it is there.
        let source = std::fs::read_to_string(&path).unwrap();
        let pending = source.contains("\n# pending: ");
        let begin = std::time::Instant::now();
        let mut found = std::panic::catch_unwind(|| faults(&path)).unwrap_or_else(|_| vec!["a panic".to_owned()]);
        if begin.elapsed().as_secs() >= 10 {
            found.push(format!("it takes {:?}", begin.elapsed()));
        }
        if pending {
            found = match found.is_empty() {
                true => vec!["this works now: take out `pending`".to_owned()],
                false => Vec::new(),
            };
        }
        if !found.is_empty() {
            failed += 1;
            println!("{name}:");
            found.iter().take(6).for_each(|fault| println!("    {fault}"));
        }
    }
    assert!(only.is_some() || count >= 180, "{count} files");
    assert!(failed == 0, "{failed} of {count} files fail");
}
