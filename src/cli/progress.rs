//! A sign of life for work that takes longer than half a second, on a terminal only.

use std::io::{self, IsTerminal};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::ProgressBar;

use super::guard::Guard;

/// Work shorter than this shows nothing.
const PATIENCE: Duration = Duration::from_millis(500);
/// How often the line is drawn.
const TICK: Duration = Duration::from_millis(100);

/// Shows that work goes on until it is dropped.
pub(super) struct Progress {
    waiter: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    /// Begins to wait, and shows the stage that a command is at, unless it tells of its stages itself; in a pipe nothing is ever
    /// shown.
    pub(super) fn start(what: &'static str, guard: &Guard) -> Self {
        if guard.tells || !io::stderr().is_terminal() {
            return Self { waiter: None };
        }
        let guard = guard.clone();
        let (done, wait) = mpsc::channel::<()>();
        let spawned = std::thread::Builder::new().spawn(move || {
            if wait.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                let bar = ProgressBar::new_spinner().with_message(what);
                bar.enable_steady_tick(TICK);
                // Ends when the sender is dropped.
                while wait.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                    if let Some(stage) = guard.stage() {
                        bar.set_message(format!("{what}: {stage}"));
                    }
                }
                bar.finish_and_clear();
            }
        });
        // Without a thread there is no spinner, and nothing is lost.
        Self { waiter: spawned.ok().map(|thread| (done, thread)) }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((done, thread)) = self.waiter.take() {
            drop(done);
            let _ = thread.join();
        }
    }
}

/// Shows how much of countable work is done, on a terminal only, until it is dropped.
pub(super) struct Counter {
    bar: Option<ProgressBar>,
}

impl Counter {
    /// Begins to count; what takes less than the patience of a reader shows nothing.
    pub(super) fn start(what: &'static str, count: usize) -> Self {
        if !io::stderr().is_terminal() {
            return Self { bar: None };
        }
        let bar = ProgressBar::hidden().with_message(what).with_elapsed(Duration::ZERO);
        bar.set_length(u64::try_from(count).unwrap_or(u64::MAX));
        Self { bar: Some(bar) }
    }

    /// One more is done.
    pub(super) fn step(&self) {
        let Some(bar) = &self.bar else { return };
        bar.inc(1);
        if bar.is_hidden() && bar.elapsed() > PATIENCE {
            bar.set_draw_target(indicatif::ProgressDrawTarget::stderr());
        }
    }
}

impl Drop for Counter {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
