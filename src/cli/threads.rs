//! Work on all cores, its results in order.

use std::sync::mpsc::{self, Receiver, SyncSender};
use std::sync::{Mutex, PoisonError};
use std::thread;

use super::Failure;
use super::progress::Counter;

/// So many results for each thread may wait for one before them.
const AHEAD: usize = 16;

/// As many threads as there are cores.
pub(super) fn cores() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// Results by number, each made by one of the threads and handed on in order, until that fails. Each thread makes its worker itself.
pub(super) fn in_order<T: Send, W: FnMut(usize) -> T>(
    threads: Option<usize>,
    count: usize,
    what: &'static str,
    worker: impl Fn() -> W + Sync,
    each: impl FnMut(T) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let threads = threads.unwrap_or_else(cores).min(count);
    let counter = Counter::start(what, count);
    let open = Mutex::new(0..count);
    // Where each result is to be found, in order; who is too far ahead waits until there is room for one more.
    let (places, results) = mpsc::sync_channel(AHEAD * threads);
    let work = |places: SyncSender<Receiver<T>>| {
        let mut work = worker();
        loop {
            let (done, place) = mpsc::sync_channel(1);
            // Whoever takes a number keeps the lock until its place is queued, so that places are in order.
            let mut open = open.lock().unwrap_or_else(PoisonError::into_inner);
            let Some(at) = open.next().filter(|_| places.send(place).is_ok()) else { return };
            drop(open);
            let result = work(at);
            counter.step();
            // Nobody waits for it where handing on has failed.
            let _ = done.send(result);
        }
    };
    thread::scope(|scope| {
        for _ in 0..threads {
            let (work, places) = (&work, places.clone());
            scope.spawn(move || work(places));
        }
        // The threads have senders of their own, so that nobody waits for one that has died.
        drop(places);
        results.into_iter().map_while(|place| place.recv().ok()).try_for_each(each)
    })
}

/// The same with all results at the end; `step` is called behind each.
pub(super) fn all<T: Send, W: FnMut(usize) -> T>(
    threads: Option<usize>,
    count: usize,
    what: &'static str,
    worker: impl Fn() -> W + Sync,
    mut step: impl FnMut() -> Result<(), Failure>,
) -> Result<Vec<T>, Failure> {
    let mut all = Vec::with_capacity(count);
    in_order(threads, count, what, worker, |result| {
        all.push(result);
        step()
    })?;
    Ok(all)
}
