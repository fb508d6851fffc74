//! Work on all cores, its results in order.

use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use super::Failure;
use super::progress::Counter;

/// So many results for each thread may wait for one before them.
const AHEAD: usize = 16;

struct Queue<T> {
    /// The first that nobody works on.
    next: usize,
    /// Those that are to be handed on, the first of which is `wanted`.
    done: BTreeMap<usize, T>,
    wanted: usize,
    stop: bool,
}

struct Shared<T> {
    queue: Mutex<Queue<T>>,
    changed: Condvar,
}

impl<T> Shared<T> {
    fn queue(&self) -> MutexGuard<'_, Queue<T>> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, queue: MutexGuard<'a, Queue<T>>) -> MutexGuard<'a, Queue<T>> {
        self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner)
    }

    fn stop(&self) {
        self.queue().stop = true;
        self.changed.notify_all();
    }

    /// The number of what is to be done next, once it is not too far ahead.
    fn take(&self, count: usize, ahead: usize) -> Option<usize> {
        let mut queue = self.queue();
        while !queue.stop && queue.next < count && queue.next >= queue.wanted + ahead {
            queue = self.wait(queue);
        }
        let at = queue.next;
        queue.next += 1;
        (!queue.stop && at < count).then_some(at)
    }

    /// The next result in order; none where a thread has ended without one.
    fn result(&self) -> Option<T> {
        let mut queue = self.queue();
        let wanted = queue.wanted;
        loop {
            if let Some(result) = queue.done.remove(&wanted) {
                queue.wanted += 1;
                self.changed.notify_all();
                return Some(result);
            }
            if queue.stop {
                return None;
            }
            queue = self.wait(queue);
        }
    }
}

/// Nobody waits for a thread that has died.
struct Alive<'a, T>(&'a Shared<T>);

impl<T> Drop for Alive<'_, T> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.stop();
        }
    }
}

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
    mut each: impl FnMut(T) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let threads = threads.unwrap_or_else(cores).min(count);
    let counter = Counter::start(what, count);
    let queue = Queue { next: 0, done: BTreeMap::new(), wanted: 0, stop: false };
    let shared = Shared { queue: Mutex::new(queue), changed: Condvar::new() };
    let work = || {
        let _alive = Alive(&shared);
        let mut work = worker();
        while let Some(at) = shared.take(count, AHEAD * threads) {
            let result = work(at);
            counter.step();
            shared.queue().done.insert(at, result);
            shared.changed.notify_all();
        }
    };
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(work);
        }
        let mut handed_on = Ok(());
        for _ in 0..count {
            let Some(result) = shared.result() else { break };
            handed_on = each(result);
            if handed_on.is_err() {
                shared.stop();
                break;
            }
        }
        handed_on
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
