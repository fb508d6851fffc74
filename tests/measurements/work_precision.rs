//! `examples/work_precision` without its peers, and the document that it wrote last: errors are of the size of the tolerance,
//! nothing is missing, the picture is there.
#![cfg(feature = "engine")]

#[path = "../../examples/work_precision/document.rs"]
mod document;
#[path = "../../examples/work_precision/picture.rs"]
mod picture;
#[path = "../../examples/work_precision/run.rs"]
mod run;

use std::path::Path;

use crate::{clock, frame, machine, process};

use run::{FULL, METHODS, QUICK};

#[test]
fn errors_follow_tolerances() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let report = run::run(root, Err("left out".to_owned()), 0.0, 60.0).unwrap();
    assert_eq!(report.lines.len(), METHODS.len());
    let quick = report.line(QUICK).unwrap();
    assert_eq!(quick.trips.len(), 14);
    for trip in &quick.trips {
        let tolerance = 10f64.powi(-trip.tolerance.unwrap());
        assert!(trip.error <= 100.0 * tolerance + 1e-13, "{trip:?}");
    }
    let full = report.line(FULL).unwrap();
    assert!(full.trips[0].error < 1e-28, "{:?}", full.trips);
    // The others tell why they are left out.
    for line in &report.lines {
        let own = line.name == QUICK || line.name == FULL;
        assert_eq!(line.remark.is_none(), own, "{}", line.name);
    }
    let out = std::env::temp_dir().join(format!("work-precision-{}", std::process::id()));
    document::write(&report, &out).unwrap();
    let text = std::fs::read_to_string(out.join("work-precision.md")).unwrap();
    std::fs::remove_dir_all(&out).unwrap();
    assert!(text.contains("Left out in this run: SciPy DOP853 (left out)."));
    assert!(text.contains("| librate, to a tolerance | 1e-12 |"));
}

#[test]
fn the_document_in_the_tree_is_whole() {
    let text = std::fs::read_to_string("docs/work-precision.md").unwrap();
    for method in &METHODS {
        assert!(text.contains(&format!("| {} |", method.name)), "{}", method.name);
    }
    assert!(!text.contains("Left out in this run"));
    for link in text.split("](").skip(1) {
        let file = link.split(')').next().unwrap();
        assert!(Path::new("docs").join(file).exists(), "{file}");
    }
}
