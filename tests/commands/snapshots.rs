//! What `modes` and `derive`, or `floquet`, print for every model, beside the model's reference in
//! tests/reference: a change of any printed character shows as a diff. Whether the numbers are
//! right is checked in tests/modes/models.rs; that the printed digits are those numbers, here.
#![cfg(feature = "cli")]

use crate::common;

use std::path::Path;

use common::load;
use librate::derive::{Parts, derive};
use librate::diagnostic::Diagnostic;
use librate::floquet::{self, floquet};
use librate::linearize::linearize;
use librate::modes::Options;
use librate::oscillation::normal_modes;
use librate::report::{Style, derive_text, floquet_text, modes_json, modes_text};

/// Shapes and matrices of more coordinates than this are not worth a snapshot.
const MOST_WRITTEN_OUT: usize = 12;

fn printed(path: &Path) -> String {
    let model = load(path);
    let style = Style::default();
    if model.time_dependent.is_some() {
        let found = floquet(&model, &floquet::Options::default()).unwrap();
        return floquet_text(&model, &found, 10, &style);
    }
    let linearized = match linearize(model.clone()) {
        Ok(linearized) => linearized,
        Err(error) => {
            let diagnostic = Diagnostic::from(&error);
            return format!("{}\nhelp: {}\n", diagnostic.message, diagnostic.help.unwrap());
        }
    };
    let count = linearized.dimension();
    let mut options = Options::default();
    options.lowest = (count > 20).then_some(20);
    let modes = normal_modes(&linearized, &options).unwrap();
    let mut out = modes_text(&linearized, &modes, &options, &style);
    let wide = out.lines().find(|line| line.chars().count() > style.width);
    assert!(wide.is_none(), "{}: {wide:?}", path.display());
    check_digits(path, &modes_json(&linearized, &modes, &options));
    if count <= MOST_WRITTEN_OUT {
        let derivation = derive(&model, &Parts::all()).unwrap();
        out.push_str("\n---\n");
        out.push_str(&derive_text(&derivation, &style));
    }
    out
}

/// The printed digits are the first ones of the 40-digit reference, correctly rounded.
fn check_digits(path: &Path, json: &str) {
    let name = path.file_stem().unwrap().to_string_lossy();
    let reference = std::fs::read_to_string(format!("tests/reference/{name}.json")).unwrap();
    let reference: serde_json::Value = serde_json::from_str(&reference).unwrap();
    let own: serde_json::Value = serde_json::from_str(json).unwrap();
    let want = reference["modes"].as_array().unwrap();
    for (own, want) in own["modes"].as_array().unwrap().iter().zip(want) {
        for key in ["omega", "growth"] {
            let want = want[key].as_str().unwrap();
            let digits = own[format!("{key}_digits")].as_str().unwrap();
            if want == "0" {
                assert_eq!(digits, "0", "{name}");
                continue;
            }
            let significant = |text: &str| {
                text.chars().take_while(|c| *c != 'e').filter(char::is_ascii_digit).skip_while(|c| *c == '0').count()
            };
            assert_eq!(significant(digits), 10, "{name}: {digits}");
            // At ten digits a double can tell whether the rounding is right, but for ties.
            let (own, want): (f64, f64) = (digits.parse().unwrap(), want.parse().unwrap());
            let unit = 10.0_f64.powf(want.abs().log10().floor() - 9.0);
            assert!((own - want).abs() <= 0.5000001 * unit, "{name}: {digits} is not {want}");
        }
    }
}

#[test]
fn models_print_as_before() {
    insta::glob!("../../models", "*.lag", |path| {
        insta::with_settings!({ snapshot_path => "../../models/snapshots", prepend_module_to_snapshot => false, omit_expression => true }, {
            insta::assert_snapshot!(printed(path));
        });
    });
}
