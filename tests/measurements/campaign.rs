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
    let done = plan.run(|_| {});
    let failures = done.iter().filter(|done| !done.outcome.violations.is_empty());
    let wrong: Vec<String> = failures
        .map(|failure| {
            let kind = kinds::KINDS[plan.kind_of(failure.index)].0;
            let violations = &failure.outcome.violations;
            format!("--seed {} --kind {kind} --model {}: {violations:?}", plan.seed, failure.index)
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for kind in 0..kinds::KINDS.len() {
        let own = done.iter().filter(|done| plan.kind_of(done.index) == kind);
        assert!(own.map(|done| done.outcome.numbers).sum::<usize>() > 100);
    }
}
