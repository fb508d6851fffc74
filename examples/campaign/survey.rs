//! Many models on all cores.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::check::{Asked, Outcome, check};
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

/// What came of a model.
pub(crate) struct Done {
    pub(crate) index: usize,
    pub(crate) outcome: Outcome,
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
    pub(crate) fn run(&self, progress: impl Fn(usize) + Sync) -> Vec<Done> {
        let next = AtomicUsize::new(self.models.start);
        let done = AtomicUsize::new(0);
        let results: Mutex<Vec<Done>> = Mutex::new(Vec::new());
        std::thread::scope(|scope| {
            for _ in 0..self.threads {
                scope.spawn(|| {
                    loop {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        if index >= self.models.end {
                            break;
                        }
                        CURRENT.set(Some((self.kind_of(index), index)));
                        let (model, asked) = self.model(index);
                        let outcome = check(&model, &asked);
                        if let Ok(mut results) = results.lock() {
                            results.push(Done { index, outcome });
                        }
                        progress(done.fetch_add(1, Ordering::Relaxed) + 1);
                    }
                });
            }
        });
        let mut results = results.into_inner().unwrap_or_default();
        results.sort_by_key(|done| done.index);
        results
    }
}

fn asked(draw: &mut Draw, digits: Option<usize>) -> Asked {
    let drawn = if draw.once_in(4) { draw.size(1, 26) } else { 10 };
    let lowest = draw.once_in(10).then(|| draw.size(1, 4));
    Asked { digits: digits.unwrap_or(drawn), vectors: !draw.once_in(10), lowest }
}

thread_local! {
    static CURRENT: std::cell::Cell<Option<(usize, usize)>> = const { std::cell::Cell::new(None) };
}

/// The model that this thread is at.
pub(crate) fn current() -> Option<(usize, usize)> {
    CURRENT.get()
}
