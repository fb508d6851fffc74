//! Every block of the language guide is a model that runs.
#![cfg(feature = "engine")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

use librate::linearize::linearize;
use librate::model::{Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::{NormalMode, normal_modes};

#[test]
fn blocks_of_the_guide_run() {
    let guide = std::fs::read_to_string("docs/language.md").unwrap();
    let blocks: Vec<&str> = guide
        .split("```lag\n")
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap())
        .collect();
    assert!(blocks.len() >= 5);
    for block in blocks {
        let file = librate::syntax::parse(block).unwrap_or_else(|e| panic!("{block}\n{e:?}"));
        let model = elaborate(&file, &TableTexts::new(), &Settings::new())
            .unwrap_or_else(|e| panic!("{block}\n{e:?}"));
        let linearized = linearize(model).unwrap_or_else(|e| panic!("{block}\n{e}"));
        let normal = normal_modes(&linearized, &Options::default()).unwrap();
        assert_eq!(normal.modes.len(), linearized.dimension());
        // What turns steadily is free to.
        let turns = linearized.model().rates.iter().any(Option::is_some);
        let moves = |mode: &NormalMode| {
            mode.omega.mid_f64() > 0.0 || turns && mode.kind == librate::modes::Kind::Zero
        };
        assert!(normal.modes.iter().all(moves), "{block}");
    }
}
