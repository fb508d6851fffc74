//! A short run of `examples/campaign`: random models of every kind, as texts, against a reference that

//! shares nothing with the library.

use crate::kinds;
use crate::survey::Plan;

#[test]
fn every_claim_about_random_models_holds() {
    let plan = Plan {
        seed: 1,
        models: 0..320,
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
