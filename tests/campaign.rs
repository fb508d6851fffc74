//! A short run of `examples/campaign`: random models of every kind, as texts, against a reference that
//! shares nothing with the library.
#![cfg(feature = "cli")]
#![allow(dead_code, reason = "the example reports more than a test asks for")]

#[path = "../examples/campaign/check.rs"]
mod check;
#[path = "../examples/campaign/digits.rs"]
mod digits;
#[path = "../examples/campaign/draw.rs"]
mod draw;
#[path = "../examples/campaign/exponents.rs"]
mod exponents;
#[path = "../examples/campaign/kinds/mod.rs"]
mod kinds;
#[path = "../examples/campaign/pencil.rs"]
mod pencil;
#[path = "../examples/campaign/real.rs"]
mod real;
#[path = "../examples/campaign/reference.rs"]
mod reference;
#[path = "../examples/campaign/survey.rs"]
mod survey;

use survey::Plan;

#[test]
fn every_claim_about_random_models_holds() {
    let plan = Plan {
        seed: 1,
        models: 0..400,
        kind: None,
        digits: None,
        threads: std::thread::available_parallelism().map_or(1, usize::from),
    };
    let survey = plan.run(|_| {});
    let wrong: Vec<String> = survey
        .failures
        .iter()
        .map(|failure| {
            format!(
                "--seed {} --kind {} --model {}: {:?}",
                plan.seed,
                kinds::KINDS[failure.kind].0,
                failure.index,
                failure.violations
            )
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(survey.tallies.iter().all(|tally| tally.numbers > 100));
}
