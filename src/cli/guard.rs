//! The clock and the scale of a budget: a thread that stops the work when its time or memory is used up.
//!
//! Work that asks its budget ends within milliseconds, with the error of its stage. What does not (a product of large
//! matrices) is ended here, with the same message.

use std::collections::HashSet;
use std::fs;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

use librate::budget::{Budget, Limit, Limits};
use librate::diagnostic::Diagnostic;

use super::args::MessageFormat;
use super::input::Source;
use super::{Answer, FAULT, Failure, complain, output};

/// A search that has found something ends at this part of the time, so that the rest is enough to tell it.
const NEARLY: f64 = 0.75;
/// How often is looked.
const INTERVAL: Duration = Duration::from_millis(10);

/// Begins when a model is read and ends when its result is written.
#[derive(Clone, Debug, Default)]
pub(crate) struct Guard {
    limits: Limits,
    format: MessageFormat,
    done: Arc<AtomicBool>,
    /// The time begins anew.
    again: Arc<AtomicBool>,
    budget: Arc<OnceLock<Budget>>,
    /// Which solver is chosen, and why, is written to standard error.
    pub(super) tells: bool,
}

impl Guard {
    pub(crate) fn new(limits: Limits, format: MessageFormat, tells: bool) -> Self {
        Self { limits, format, done: Arc::default(), again: Arc::default(), budget: Arc::default(), tells }
    }

    /// What is being worked on, in words.
    pub(super) fn stage(&self) -> Option<String> {
        self.budget.get().map(Budget::task)
    }

    /// From now on nothing is ended any more: the answer, where all of it could be worked out within the budget.
    pub(crate) fn finish(&self, answer: Result<Answer, Failure>) -> Result<Answer, Failure> {
        if self.done.swap(true, Ordering::Relaxed) {
            return answer;
        }
        let Some(Err(exceeded)) = self.budget.get().map(Budget::check) else { return answer };
        // Whatever else it ended with may only follow from that.
        let source = match answer {
            Ok(answer) => answer.remarks.map(|(source, _)| source),
            Err(Failure::Model(source, _)) => Some(source),
            Err(other) => return Err(other),
        };
        let told = Diagnostic::from(&exceeded);
        Err(match source {
            Some(source) => Failure::Model(source, vec![told]),
            None => Failure::Other { message: told.message, help: told.help, status: FAULT },
        })
    }

    /// An answer will do as it is: the budget ended only what it says is left out.
    pub(crate) fn accept(&self) {
        self.done.store(true, Ordering::Relaxed);
    }

    /// Of work in many parts, that one is done: the next has all of the time for itself. Not so once the budget is spent.
    pub(crate) fn go_on(&self, source: &Source) -> Result<(), Failure> {
        self.again.store(true, Ordering::Relaxed);
        match self.budget.get() {
            Some(budget) if budget.is_spent() => Err(Failure::Model(source.clone(), Vec::new())),
            Some(_) | None => Ok(()),
        }
    }

    /// The budget for a model and so many bytes of tables, whose time begins now.
    pub(crate) fn begin(&self, source: &Source, tables: usize) -> Budget {
        // One command reads one model, if again where it corrects it.
        if let Some(begun) = self.budget.get() {
            return begun.clone();
        }
        let input = (source.text.len() + tables) as u64;
        let (seconds, bytes) = (self.limits.seconds(input), self.limits.bytes(input));
        let budget = Budget::new(bytes);
        budget.watch();
        let watch = Watch {
            budget: budget.clone(),
            guard: self.clone(),
            source: source.clone(),
            seconds,
            bytes,
            start: Instant::now(),
            worked: 0.0,
        };
        if self.tells {
            let format = self.format;
            // Work in many parts tells the same of each.
            let told = Mutex::new(HashSet::new());
            budget.listen(move |line| {
                if told.lock().is_ok_and(|mut told| told.insert(line.to_owned())) {
                    output::write_messages(&format.note(line));
                }
            });
        }
        let _ = self.budget.set(budget.clone());
        // Without a thread what is counted stays within the budget all the same.
        let _ = thread::Builder::new().spawn(move || watch.run());
        budget
    }
}

/// What the thread watches over.
struct Watch {
    budget: Budget,
    guard: Guard,
    source: Source,
    seconds: u64,
    bytes: u64,
    start: Instant,
    /// Processor time by then, in seconds.
    worked: f64,
}

impl Watch {
    fn run(mut self) {
        loop {
            thread::sleep(INTERVAL);
            if self.guard.done.load(Ordering::Relaxed) {
                return;
            }
            if self.guard.again.swap(false, Ordering::Relaxed) {
                self.start = Instant::now();
                self.worked = processor_time().unwrap_or(0.0);
            }
            // What asks its budget is stopped at nine tenths, everything else at the end.
            let used = [
                (self.time() / self.seconds as f64, Limit::Time(self.seconds)),
                (memory() / self.bytes as f64, Limit::Memory(self.bytes)),
            ];
            if used[0].0 > NEARLY {
                self.budget.hurry();
            }
            for (used, limit) in used {
                if used > 0.9 {
                    let exceeded = self.budget.stop(limit);
                    if used > 1.0 && !self.guard.done.load(Ordering::Relaxed) {
                        let told = vec![Diagnostic::from(&exceeded)];
                        let status = complain(Failure::Model(self.source, told), self.guard.format);
                        std::process::exit(i32::from(status));
                    }
                }
            }
        }
    }

    /// In seconds: processor time where it is known, and never more than has passed, so that neither a busy machine nor
    /// many threads nor a slow reader shorten a budget.
    fn time(&self) -> f64 {
        let passed = self.start.elapsed().as_secs_f64();
        processor_time().map_or(passed, |worked| (worked - self.worked).min(passed))
    }
}

/// The processor time of this process in seconds, where the system tells it.
fn processor_time() -> Option<f64> {
    /// Of Linux, everywhere.
    const TICKS_A_SECOND: f64 = 100.0;
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    // Behind the name, which may contain anything: the state, ten more, user time, system time.
    let (_, fields) = stat.rsplit_once(')')?;
    let mut ticks = fields.split_whitespace().skip(11).take(2);
    let user: f64 = ticks.next()?.parse().ok()?;
    let system: f64 = ticks.next()?.parse().ok()?;
    Some((user + system) / TICKS_A_SECOND)
}

/// The memory of this process in bytes, 0 where the system does not tell it.
fn memory() -> f64 {
    let read = || -> Option<f64> {
        let status = fs::read_to_string("/proc/self/status").ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
        let kilobytes: f64 = line.split_whitespace().next()?.parse().ok()?;
        Some(1024.0 * kilobytes)
    };
    read().unwrap_or(0.0)
}
