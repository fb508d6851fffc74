//! A sign of life for work that takes longer than half a second, on a terminal only.

use std::io::{self, IsTerminal};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::ProgressBar;

/// Work shorter than this shows nothing.
const PATIENCE: Duration = Duration::from_millis(500);

/// Shows that work goes on until it is dropped.
pub(super) struct Progress {
    waiter: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    /// Begins to wait; in a pipe nothing is ever shown.
    pub(super) fn start(what: &'static str) -> Self {
        if !io::stderr().is_terminal() {
            return Self { waiter: None };
        }
        let (done, wait) = mpsc::channel::<()>();
        let spawned = std::thread::Builder::new().spawn(move || {
            if wait.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                let bar = ProgressBar::new_spinner().with_message(what);
                bar.enable_steady_tick(Duration::from_millis(100));
                // Ends when the sender is dropped.
                let _ = wait.recv();
                bar.finish_and_clear();
            }
        });
        // Without a thread there is no spinner, and nothing is lost.
        Self {
            waiter: spawned.ok().map(|thread| (done, thread)),
        }
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
