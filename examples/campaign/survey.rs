//! Many models on all cores, and what came of them by kind.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use crate::check::{Asked, Outcome, WRONGS, Wrong, check};
use crate::draw::Draw;
use crate::kinds::{KINDS, Model, draw};

/// Which models.
#[derive(Clone)]
pub(crate) struct Plan {
    pub(crate) seed: u64,
    /// Numbers of the models, from the first up to the last, not included.
    pub(crate) models: std::ops::Range<usize>,
    pub(crate) kind: Option<usize>,
    pub(crate) digits: Option<usize>,
    pub(crate) threads: usize,
}

/// A model with something wrong.
pub(crate) struct Failure {
    pub(crate) kind: usize,
    pub(crate) index: usize,
    pub(crate) violations: Vec<(Wrong, String)>,
}

/// What came of all models of a kind.
#[derive(Default)]
pub(crate) struct Tally {
    pub(crate) models: usize,
    pub(crate) coordinates: Vec<usize>,
    pub(crate) numbers: usize,
    pub(crate) wrong: [usize; WRONGS.len()],
    /// Digits of numbers with fewer than asked for, and the models they are from.
    pub(crate) fewer: Vec<(usize, usize)>,
    pub(crate) undecided: usize,
    pub(crate) zeros: usize,
    pub(crate) ties: usize,
    pub(crate) loose_shapes: usize,
    pub(crate) ratios: Vec<f64>,
    pub(crate) cpu: Vec<Duration>,
}

/// What came of a plan.
pub(crate) struct Survey {
    pub(crate) tallies: Vec<Tally>,
    pub(crate) failures: Vec<Failure>,
}

impl Plan {
    pub(crate) fn kind_of(&self, index: usize) -> usize {
        self.kind.unwrap_or(index % KINDS.len())
    }

    /// A model, and what is asked about it: mostly ten digits of everything.
    pub(crate) fn model(&self, index: usize) -> (Model, Asked) {
        let (model, mut rest) = draw(self.seed, self.kind_of(index), index);
        let asked = asked(&mut rest, self.digits);
        (model, asked)
    }

    /// The same whatever the number of threads, times excepted.
    pub(crate) fn run(&self, progress: impl Fn(usize) + Sync) -> Survey {
        let next = AtomicUsize::new(self.models.start);
        let done = AtomicUsize::new(0);
        let results: Mutex<Vec<(usize, Outcome)>> = Mutex::new(Vec::new());
        std::thread::scope(|scope| {
            for _ in 0..self.threads {
                scope.spawn(|| {
                    loop {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        if index >= self.models.end {
                            break;
                        }
                        let _here = Here::new(self.kind_of(index), index);
                        let (model, asked) = self.model(index);
                        let outcome = check(&model, &asked);
                        if let Ok(mut results) = results.lock() {
                            results.push((index, outcome));
                        }
                        progress(done.fetch_add(1, Ordering::Relaxed) + 1);
                    }
                });
            }
        });
        let mut results = results.into_inner().unwrap_or_default();
        results.sort_by_key(|(index, _)| *index);
        let mut survey = Survey { tallies: KINDS.iter().map(|_| Tally::default()).collect(), failures: Vec::new() };
        for (index, outcome) in results {
            survey.add(self.kind_of(index), index, outcome);
        }
        survey
    }
}

fn asked(draw: &mut Draw, digits: Option<usize>) -> Asked {
    let drawn = if draw.once_in(4) { draw.size(1, 26) } else { 10 };
    let lowest = draw.once_in(10).then(|| draw.size(1, 4));
    Asked { digits: digits.unwrap_or(drawn), vectors: !draw.once_in(10), lowest }
}

/// Says which model it was if the thread panics.
struct Here {
    kind: usize,
    index: usize,
}

impl Here {
    fn new(kind: usize, index: usize) -> Self {
        CURRENT.set(Some((kind, index)));
        Self { kind, index }
    }
}

impl Drop for Here {
    fn drop(&mut self) {
        debug_assert_eq!(CURRENT.get(), Some((self.kind, self.index)));
        CURRENT.set(None);
    }
}

thread_local! {
    static CURRENT: std::cell::Cell<Option<(usize, usize)>> = const { std::cell::Cell::new(None) };
}

/// The model that this thread is at.
pub(crate) fn current() -> Option<(usize, usize)> {
    CURRENT.get()
}

impl Survey {
    fn add(&mut self, kind: usize, index: usize, outcome: Outcome) {
        let tally = &mut self.tallies[kind];
        tally.models += 1;
        tally.coordinates.push(outcome.coordinates);
        tally.numbers += outcome.numbers;
        tally.fewer.extend(outcome.fewer.iter().map(|digits| (*digits, index)));
        tally.undecided += outcome.undecided;
        tally.zeros += outcome.zeros;
        tally.ties += outcome.ties;
        tally.loose_shapes += outcome.loose_shapes;
        tally.ratios.extend(outcome.ratios);
        tally.cpu.push(outcome.cpu);
        for (count, wrong) in tally.wrong.iter_mut().zip(WRONGS) {
            *count += outcome.violations.iter().filter(|v| v.0 == wrong).count();
        }
        if !outcome.violations.is_empty() {
            self.failures.push(Failure { kind, index, violations: outcome.violations });
        }
    }
}
