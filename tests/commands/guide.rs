//! Every block of the language guide is a model that runs, and what the README shows is what comes.
#![cfg(feature = "cli")]

use std::collections::BTreeSet;

use crate::cli_support;

use cli_support::*;
use librate::linearize::linearize;
use librate::model::{Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::{NormalMode, normal_modes};
use librate::syntax::STATEMENT_WORDS;

#[test]
fn blocks_of_the_guide_run() {
    let guide = std::fs::read_to_string("docs/language.md").unwrap();
    let blocks: Vec<&str> = guide.split("```lag\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert!(blocks.len() >= 5);
    for block in blocks {
        let file = librate::syntax::parse(block).unwrap_or_else(|e| panic!("{block}\n{e:?}"));
        let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap_or_else(|e| panic!("{block}\n{e:?}"));
        let linearized = linearize(model).unwrap_or_else(|e| panic!("{block}\n{e}"));
        let normal = normal_modes(&linearized, &Options::default()).unwrap();
        assert_eq!(normal.modes.len(), linearized.dimension() + linearized.rolled().len());
        // What turns steadily is free to, and so is the place of what rolls or slides.
        let turns = linearized.model().rates.any() || !linearized.rolled().is_empty();
        let moves = |mode: &NormalMode| mode.omega.mid_f64() > 0.0 || turns && mode.kind == librate::modes::Kind::Zero;
        assert!(normal.modes.iter().all(moves), "{block}");
    }
}

/// All statements of the program are in the guide.
#[test]
fn the_guide_has_all_statements_of_the_language() {
    let guide = std::fs::read_to_string("docs/language.md").unwrap();
    let chapter = guide.split_once("\n## Statements\n").unwrap().1.split("\n## ").next().unwrap();
    let words: BTreeSet<&str> = chapter.split(|c: char| !c.is_alphanumeric()).collect();
    STATEMENT_WORDS.iter().for_each(|own| assert!(words.contains(own), "{own}"));
}

/// The models of docs/matrices.md with the tables above them, and their exponents: growth and frequency.
#[test]
fn models_given_as_matrices() {
    let page = std::fs::read_to_string("docs/matrices.md").unwrap();
    let mut tables = TableTexts::new();
    let mut found = Vec::new();
    for block in page.split("```").skip(1).step_by(2) {
        let (head, text) = block.split_once('\n').unwrap();
        match head.split_once(' ') {
            Some(("mtx", name)) => {
                tables = tables.with(name, text);
            }
            Some(("lag", _)) => {
                let model = elaborate(&librate::syntax::parse(text).unwrap(), &tables, &Settings::new()).unwrap();
                let normal = normal_modes(&linearize(model).unwrap(), &Options::default()).unwrap();
                let exponents = normal.modes.iter().map(|mode| [mode.growth.mid_f64(), mode.omega.mid_f64()]);
                found.push(exponents.collect::<Vec<_>>());
            }
            _ => assert_eq!(head, "text"),
        }
    }
    let [chain, bicycle] = found.as_slice() else { panic!() };
    assert_eq!(chain.len(), 3);
    assert!(chain.iter().any(|mode| mode[0] == 0.0 && (mode[1] - 2.0_f64.sqrt()).abs() < 1e-14), "{chain:?}");
    let table = [[-0.775341882195845, 4.46486771378829], [-0.322866429004087, 0.0], [-14.07838969279822, 0.0]];
    assert_eq!(bicycle.len(), 3);
    for own in table {
        let near = |mode: &&[f64; 2]| (mode[0] - own[0]).hypot(mode[1] - own[1]) < 1e-12;
        assert_eq!(bicycle.iter().filter(near).count(), 1, "{own:?}: {bicycle:?}");
    }
}

/// What stands between fences of plain text behind a phrase.
fn shown<'a>(text: &'a str, phrase: &str) -> &'a str {
    let (_, rest) = text.split_once(phrase).unwrap_or_else(|| panic!("{phrase}"));
    let (_, rest) = rest.split_once("```text\n").unwrap();
    rest.split_once("```").unwrap().0
}

#[test]
fn the_readme_shows_what_is_printed() {
    let readme = std::fs::read_to_string("README.md").unwrap();
    let (version, _) = env!("CARGO_PKG_VERSION").rsplit_once('.').unwrap();
    assert!(readme.contains(&format!("librate = {{ version = \"{version}\", ")));
    let file = "models/three_pendulums.lag";
    let modes = printed(&["modes", file]);
    assert_eq!(shown(&readme, &format!("modes {file}")).trim_end(), modes.trim_end());
    // The model itself, less the comments that its file has besides.
    let model = std::fs::read_to_string(file).unwrap();
    let bare = |text: &str| -> String {
        let lines = text.lines().filter(|line| !line.starts_with('#'));
        lines.collect::<Vec<_>>().join("\n").trim().to_owned()
    };
    assert_eq!(bare(shown(&readme, "that they come from.")), bare(&model));
}
