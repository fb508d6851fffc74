//! `examples/speed_and_error` on a few small problems without its peers, and the document that it wrote last:
//! bounds hold and cover the digits that were asked for, nothing is missing, every picture is there.
#![cfg(feature = "cli")]

#[path = "../../examples/speed_and_error/case.rs"]
mod case;
#[path = "../../examples/speed_and_error/cells.rs"]
mod cells;
#[path = "../../examples/speed_and_error/document.rs"]
mod document;
#[path = "../../examples/speed_and_error/growth.rs"]
mod growth;
#[path = "../../examples/speed_and_error/judge.rs"]
mod judge;
#[path = "../../examples/speed_and_error/large.rs"]
mod large;
#[path = "../../examples/speed_and_error/paths.rs"]
mod paths;
#[path = "../../examples/speed_and_error/peers.rs"]
mod peers;
#[path = "../../examples/speed_and_error/plots.rs"]
mod plots;
#[path = "../../examples/speed_and_error/run.rs"]
mod run;
#[path = "../../examples/speed_and_error/truth.rs"]
mod truth;

use std::path::Path;

use crate::{clock, frame, machine, points, process, real, reference};

use case::FAMILIES;
use judge::judge;
use large::LARGE;
use librate::number::Number;
use run::{DEFAULT, FAER, PATHS, Plan, librate_paths};

const HARD: [&str; 2] = ["springs_0_16_8", "weak_bond"];

#[test]
fn bounds_hold_and_cover_the_digits() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let plan =
        Plan { hard: &HARD, largest: 3, largest_sparse: 1000, patience: 0.0, longest: 10.0, longest_sparse: 10.0 };
    let mut peers = Err("left out".to_owned());
    let report = plan.run(root, &mut peers, |_| {}).unwrap();
    assert_eq!(report.measured.len(), HARD.len() + FAMILIES.len());
    assert_eq!(report.violations(), Vec::<String>::new());
    for measured in &report.measured {
        for (label, digits) in librate_paths() {
            let outcome = measured.of(label).unwrap();
            let certified = outcome.certified.as_ref().unwrap();
            let unit = 10f64.powi(-(digits as i32));
            assert!(certified.holds && certified.covered, "{label} on {}", measured.name);
            assert!(certified.bound <= unit, "{label} on {}", measured.name);
            assert!(outcome.judged.error <= certified.bound, "{label} on {}", measured.name);
            assert_eq!(outcome.judged.wrong_signs, 0);
            assert!(outcome.judged.zero.is_none_or(|zero| zero == 0.0));
        }
        // Jacobi rotations are right on all of these, and a wrong path is seen to be wrong.
        let jacobi = measured.of("Jacobi on the factor").unwrap();
        assert!(jacobi.judged.error < 1e-14, "{}", measured.name);
        let textbook = measured.of(FAER).unwrap().judged.error;
        let hard = measured.family.is_none();
        assert_eq!(textbook > 1e-9, hard, "{}: {textbook:e}", measured.name);
    }

    // The large models at their smallest.
    let ask = |arguments| Ok(large::one(root, arguments).map_err(|error| error.to_string()));
    let sparse = large::run(&plan, &mut peers, &ask, |_| {}).unwrap();
    assert_eq!((sparse.report.measured.len(), sparse.growth.len()), (LARGE.len(), LARGE.len()));
    assert_eq!(sparse.report.violations(), Vec::<String>::new());
    for measured in &sparse.report.measured {
        let outcome = measured.of(DEFAULT).unwrap();
        let certified = outcome.certified.as_ref().unwrap();
        assert!(certified.covered && outcome.judged.error <= certified.bound, "{}", measured.name);
        assert_eq!(measured.zeros, if measured.family == Some("network") { 6 } else { 0 });
    }

    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("speed_and_error");
    let _ = std::fs::remove_dir_all(&out);
    document::write(Some(&report), Some(&sparse), &plan, &out).unwrap();
    complete(&out);
    // Either part can be written anew without the other.
    let file = out.join("speed-and-error.md");
    let whole = std::fs::read_to_string(&file).unwrap();
    for (dense, sparse) in [(Some(&report), None), (None, Some(&sparse)), (None, None)] {
        document::write(dense, sparse, &plan, &out).unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), whole);
    }
    let text = std::fs::read_to_string(out.join("speed-and-error.md")).unwrap();
    assert!(text.contains("Without the peers in Python (left out)"));
}

#[test]
fn the_document_is_complete() {
    complete(Path::new("docs"));
    let text = std::fs::read_to_string("docs/speed-and-error.md").unwrap();
    // The one in the repository has all the peers, and no bound in it is broken.
    assert!(!text.contains("Not installed") && !text.contains("Without the peers"));
    let broken = "bounds that do not hold |\n";
    let (_, table) = text.split_once(broken).unwrap();
    let rows: Vec<&str> = table.lines().skip(1).take_while(|line| !line.is_empty()).collect();
    assert_eq!(rows.len(), librate_paths().count());
    assert!(rows.iter().all(|row| row.ends_with("| 0 | 0 |")), "{rows:?}");
    let readme = std::fs::read_to_string("README.md").unwrap();
    assert!(readme.contains("](docs/speed-and-error/hard.svg)"));
}

/// Names every path and every family, and links to pictures that are there.
fn complete(folder: &Path) {
    let text = std::fs::read_to_string(folder.join("speed-and-error.md")).unwrap();
    for path in &PATHS {
        assert!(text.contains(&format!("**{}**", path.label)), "{}", path.label);
    }
    for title in FAMILIES.iter().map(|family| family.title).chain(LARGE.iter().map(|family| family.title)) {
        assert!(text.contains(title), "{title}");
    }
    let links: Vec<&str> = text
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split_once(')'))
        .map(|(link, _)| link)
        .filter(|link| link.ends_with(".svg"))
        .collect();
    assert_eq!(links.len(), 3);
    for link in links {
        let picture = std::fs::read_to_string(folder.join(link)).unwrap();
        assert!(picture.starts_with("<svg") && picture.trim_end().ends_with("</svg>"));
        assert!(picture.contains("librate"), "{link}");
    }
}

#[test]
fn errors_are_those_of_frequencies() {
    let numbers = |values: &[i64]| values.iter().map(|&x| Number::from(x)).collect::<Vec<_>>();
    // 0 instead of 1, 16 instead of 4, 9 as it should be: frequencies off by 1, 1 and 0.
    let judged = judge(&numbers(&[0, 9, 16]), &numbers(&[1, 9, 4]), 50);
    assert_eq!(judged.errors, [1.0, 0.0, 1.0]);
    assert_eq!((judged.error, judged.wrong_signs, judged.zero), (1.0, 1, None));
    // -4 instead of 1 is a growth of 2 instead of a frequency of 1.
    let judged = judge(&numbers(&[-4, 9]), &numbers(&[1, 9]), 50);
    assert_eq!((judged.error, judged.wrong_signs), (3.0, 1));
    // A zero that comes as -4 beside 16, and one that is one.
    let judged = judge(&numbers(&[-4, 16]), &numbers(&[0, 16]), 50);
    assert_eq!((judged.error, judged.wrong_signs, judged.zero), (0.0, 0, Some(0.5)));
    let judged = judge(&numbers(&[0, 16]), &numbers(&[0, 16]), 50);
    assert_eq!(judged.zero, Some(0.0));
}
