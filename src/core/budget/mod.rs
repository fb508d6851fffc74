//! One budget for work and memory, shared by all stages of a model.
//!
//! A [`Budget`] is handed to a model with its `model::Settings` and goes with its pool of expressions
//! through every stage. What grows counts its bytes here; loops ask whether the budget [is spent](Budget::is_spent) and
//! end. A stage whose budget is spent returns [`Exceeded`], never half a result.
//!
//! Memory is counted, so that the same model is refused everywhere. Time is not measured here: whoever has a clock calls
//! [`Budget::stop`] from another thread, as the command line does.
//!
//! ```
//! use librate::budget::{Budget, Limit};
//! use librate::model::{self, Settings, TableTexts};
//! use librate::syntax;
//!
//! let file = syntax::parse("coord x[1..1000000]  T = sum(i in 1..1000000, 1/2*x[i]'^2)")?;
//! let settings = Settings::new().within(Budget::new(1_000_000));
//! let errors = model::elaborate(&file, &TableTexts::new(), &settings).unwrap_err();
//! assert_eq!(errors[0].to_string(), "the budget of 1 MB is used up by `x`");
//! # Ok::<(), Vec<syntax::SyntaxError>>(())
//! ```

mod codes;

use std::fmt;
use std::panic::{RefUnwindSafe, UnwindSafe};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use crate::diagnostic::Diagnostic;
use crate::span::Span;

/// The memory of a budget that is not given one, in bytes.
pub(crate) const BYTES: u64 = 1_000_000_000;

/// Time for a model of up to [`SHORT`] bytes; one ten times as long has ten times as much.
const SECONDS: u64 = 10;
const SHORT: u64 = 8192;
/// Memory for each byte of input beyond that.
const BYTES_A_BYTE: u64 = 2000;
/// A build without optimization takes so many times as long.
const SLOW_BUILD: u64 = if cfg!(slow_build) { 6 } else { 1 };

/// How much less text than memory there may be.
const MEMORY_FOR_TEXT: u64 = 64;

/// Shorter texts are not counted.
const SHORT_TEXT: usize = 1 << 16;

/// Bytes are counted in portions of this size.
const PORTION: u64 = 1 << 16;

/// What a budget limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// Time, in seconds.
    Time(u64),
    /// Memory, in bytes.
    Memory(u64),
    /// The length of formulas written out, in bytes.
    Text(u64),
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bytes = match self {
            Self::Time(seconds) if seconds % 60 == 0 => return write!(f, "{} min", seconds / 60),
            Self::Time(seconds) => return write!(f, "{seconds} s"),
            Self::Memory(bytes) | Self::Text(bytes) => *bytes,
        };
        match bytes {
            0..1_000_000 => write!(f, "{} kB", bytes.div_ceil(1000))?,
            1_000_000..1_000_000_000 => write!(f, "{} MB", bytes / 1_000_000)?,
            _ => write!(f, "{} GB", bytes as f64 / 1e9)?,
        }
        match self {
            Self::Text(_) => write!(f, " for formulas written out"),
            Self::Time(_) | Self::Memory(_) => Ok(()),
        }
    }
}

/// What a user permits: `60s`, `4GB`, `60s,4GB`, `none`. What is not said depends on the length of the input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limits {
    seconds: Option<u64>,
    bytes: Option<u64>,
}

impl Limits {
    /// Reads a time, a memory, or both with a comma.
    ///
    /// # Errors
    /// How limits are written, in words.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong = || "a time, a memory or both are needed: `60s`, `10min`, `4GB`, `60s,4GB`, `none`".to_owned();
        if text.trim() == "none" {
            return Ok(Self { seconds: Some(u64::MAX), bytes: Some(u64::MAX) });
        }
        let mut limits = Self::default();
        for part in text.split(',') {
            let part = part.trim();
            let unit = part.find(|c: char| !c.is_ascii_digit() && c != '.').ok_or_else(wrong)?;
            let (count, unit) = part.split_at(unit);
            let count: f64 = count.parse().map_err(|_| wrong())?;
            let (slot, scale) = match unit.trim() {
                "s" => (&mut limits.seconds, 1.0),
                "min" => (&mut limits.seconds, 60.0),
                "h" => (&mut limits.seconds, 3600.0),
                "MB" => (&mut limits.bytes, 1e6),
                "GB" => (&mut limits.bytes, 1e9),
                _ => return Err(wrong()),
            };
            if count <= 0.0 || slot.is_some() {
                return Err(wrong());
            }
            // Whole seconds and bytes; what no machine has is as good as no limit.
            *slot = Some((count * scale).ceil() as u64);
        }
        Ok(limits)
    }

    /// Seconds for so many bytes of a model and its tables.
    #[must_use]
    pub fn seconds(&self, input: u64) -> u64 {
        self.seconds.unwrap_or(SLOW_BUILD * SECONDS * input.max(SHORT) / SHORT)
    }

    /// Memory for so many bytes of a model and its tables.
    #[must_use]
    pub fn bytes(&self, input: u64) -> u64 {
        let beyond = input.saturating_sub(SHORT);
        self.bytes.unwrap_or_else(|| BYTES.saturating_add(beyond.saturating_mul(BYTES_A_BYTE)))
    }
}

/// A budget is used up: by what, and which limit it had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the budget of {limit} is {}{what}", how_words(.need))]
#[non_exhaustive]
pub struct Exceeded {
    /// What grew, or was at work.
    pub what: String,
    /// Where it stands.
    pub span: Option<Span>,
    /// What it was too much for.
    pub limit: Limit,
    /// What it would have taken, where that was worked out before.
    pub need: Option<Need>,
}

/// Memory that was asked for and not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Need {
    /// So many bytes.
    pub bytes: u64,
    /// So many would do, with what is held already.
    pub total: u64,
    /// What takes less.
    pub instead: &'static str,
}

fn how_words(need: &Option<Need>) -> String {
    need.map_or("used up by ".to_owned(), |need| {
        // Two digits, rounded up.
        let unit = 10_u64.pow(need.bytes.max(1).ilog10().saturating_sub(1));
        format!("less than the {} for ", Limit::Memory(need.bytes.div_ceil(unit).saturating_mul(unit)))
    })
}

impl From<&Exceeded> for Diagnostic {
    fn from(error: &Exceeded) -> Self {
        let message = error.to_string();
        let diagnostic = match error.span {
            Some(span) => Self::error(message, span, "this takes more"),
            None => Self::global(message),
        };
        let raised = match error.limit {
            Limit::Time(seconds) => format!("{}s", seconds.max(1).saturating_mul(10)),
            Limit::Memory(bytes) | Limit::Text(bytes) => {
                Limit::Memory(bytes.saturating_mul(4)).to_string().replace(' ', "")
            }
        };
        let help = match error.need {
            Some(need) => {
                let enough = need.total.div_ceil(1_000_000_000);
                format!("{}; `--budget` raises it: `--budget {enough}GB`", need.instead)
            }
            None => format!("`--budget` raises it: `--budget {raised}`"),
        };
        diagnostic.with_code(error.code()).with_help(help)
    }
}

/// What is being worked on, for messages.
#[derive(Clone, Debug, Default)]
struct Task {
    what: String,
    span: Option<Span>,
}

/// Hears which ways are taken.
struct Listener(Box<dyn Fn(&str) + Send + Sync + UnwindSafe + RefUnwindSafe>);

impl fmt::Debug for Listener {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Listener")
    }
}

#[derive(Debug, Default)]
struct Shared {
    bytes: u64,
    held: AtomicU64,
    written: AtomicU64,
    spent: AtomicBool,
    /// Whether somebody watches the time, and little of it is left.
    watched: AtomicBool,
    nearly: AtomicBool,
    /// What is at work, and by what the budget was used up.
    state: Mutex<(Task, Option<Exceeded>)>,
    listener: OnceLock<Listener>,
}

/// A limit on work and memory; clones share it.
#[derive(Clone, Debug)]
pub struct Budget(Arc<Shared>);

impl Default for Budget {
    fn default() -> Self {
        Self::new(BYTES)
    }
}

impl Budget {
    /// A budget of so many bytes, without a limit of time.
    #[must_use]
    pub fn new(bytes: u64) -> Self {
        let task = Task { what: "the model".to_owned(), span: None };
        Self(Arc::new(Shared { bytes, state: Mutex::new((task, None)), ..Shared::default() }))
    }

    /// From now on a listener hears which solver is chosen and why, a line at a time; there is one listener, the first.
    pub fn listen(&self, listener: impl Fn(&str) + Send + Sync + UnwindSafe + RefUnwindSafe + 'static) {
        let _ = self.0.listener.set(Listener(Box::new(listener)));
    }

    /// Tells the listener, if there is one.
    pub(crate) fn tell(&self, words: impl FnOnce() -> String) {
        if let Some(Listener(listener)) = self.0.listener.get() {
            listener(&words());
        }
    }

    /// What is being worked on, in words.
    #[must_use]
    pub fn task(&self) -> String {
        self.state().0.what.clone()
    }

    fn state(&self) -> MutexGuard<'_, (Task, Option<Exceeded>)> {
        // What another thread left there is whole: two assignments.
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether work has to end: its result will not be used.
    #[must_use]
    pub fn is_spent(&self) -> bool {
        self.0.spent.load(Ordering::Relaxed)
    }

    /// Somebody watches the time from now on: searches without an end of their own may go on until little is left of it.
    pub fn watch(&self) {
        self.0.watched.store(true, Ordering::Relaxed);
    }

    /// Whether the time is watched.
    #[must_use]
    pub fn is_watched(&self) -> bool {
        self.0.watched.load(Ordering::Relaxed)
    }

    /// Little time is left.
    pub fn hurry(&self) {
        self.0.nearly.store(true, Ordering::Relaxed);
    }

    /// Whether a search has to be content with what it has found.
    #[must_use]
    pub fn is_nearly_spent(&self) -> bool {
        self.0.nearly.load(Ordering::Relaxed)
    }

    /// Nothing, or by what the budget was used up.
    ///
    /// # Errors
    /// [`Exceeded`] where the budget is spent.
    pub fn check(&self) -> Result<(), Exceeded> {
        if self.is_spent() { self.state().1.clone().map_or(Ok(()), Err) } else { Ok(()) }
    }

    /// Names what is being worked on, and where it stands.
    pub fn at(&self, what: impl Into<String>, span: Option<Span>) {
        let what = what.into();
        self.state().0 = Task { what, span };
    }

    /// Ends all work under this budget, from any thread; says what was at work.
    pub fn stop(&self, limit: Limit) -> Exceeded {
        let Task { what, span } = self.state().0.clone();
        self.stop_by(Exceeded { what, span, limit, need: None })
    }

    fn stop_by(&self, new: Exceeded) -> Exceeded {
        let exceeded = self.state().1.get_or_insert(new).clone();
        self.0.spent.store(true, Ordering::Relaxed);
        exceeded
    }

    /// Asks for memory before it is taken.
    ///
    /// # Errors
    /// [`Exceeded`] where so many items of a size are more than the budget holds.
    pub(crate) fn room(&self, count: usize, bytes_each: usize) -> Result<(), Exceeded> {
        let held = self.0.held.load(Ordering::Relaxed);
        let more = (count as u64).saturating_mul(bytes_each as u64);
        if held.saturating_add(more) > self.0.bytes {
            return Err(self.stop(Limit::Memory(self.0.bytes)));
        }
        self.check()
    }

    /// Asks for all the memory of something before any of it is taken; `instead` says what takes less.
    ///
    /// # Errors
    /// [`Exceeded`] with the figure where it is more than is left.
    pub(crate) fn room_for(&self, what: impl Into<String>, bytes: u64, instead: &'static str) -> Result<(), Exceeded> {
        let total = self.0.held.load(Ordering::Relaxed).saturating_add(bytes);
        if total > self.0.bytes {
            let need = Some(Need { bytes, total: total.saturating_add(total / 4), instead });
            let (what, limit) = (what.into(), Limit::Memory(self.0.bytes));
            return Err(self.stop_by(Exceeded { what, span: None, limit, need }));
        }
        self.check()
    }

    /// How long a formula may become when written out, in bytes.
    pub(crate) fn longest_text(&self) -> usize {
        usize::try_from(self.0.bytes / MEMORY_FOR_TEXT).unwrap_or(usize::MAX)
    }

    /// Counts a formula that was written out.
    pub(crate) fn count_text(&self, length: usize) {
        if length < SHORT_TEXT {
            return;
        }
        let before = self.0.written.fetch_add(length as u64, Ordering::Relaxed);
        let most = self.0.bytes / MEMORY_FOR_TEXT;
        if before.saturating_add(length as u64) > most {
            self.stop(Limit::Text(most));
        }
    }
}

/// Memory counted against a budget as long as this is held; a clone counts as much again.
#[derive(Debug)]
pub(crate) struct Held {
    budget: Budget,
    bytes: u64,
    /// How many of them the budget was told of.
    counted: u64,
}

impl Held {
    pub(crate) fn new(budget: Budget) -> Self {
        Self { budget, bytes: 0, counted: 0 }
    }

    pub(crate) fn budget(&self) -> &Budget {
        &self.budget
    }

    pub(crate) fn grow(&mut self, bytes: usize) {
        self.bytes += bytes as u64;
        if self.bytes > self.counted + PORTION {
            let more = self.bytes - self.counted;
            self.counted = self.bytes;
            let shared = &self.budget.0;
            if shared.held.fetch_add(more, Ordering::Relaxed) + more > shared.bytes {
                self.budget.stop(Limit::Memory(shared.bytes));
            }
        }
    }
}

impl Default for Held {
    fn default() -> Self {
        Self::new(Budget::default())
    }
}

impl Clone for Held {
    fn clone(&self) -> Self {
        let mut own = Self::new(self.budget.clone());
        own.grow(usize::try_from(self.bytes).unwrap_or(usize::MAX));
        own
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        let held = &self.budget.0.held;
        held.fetch_sub(self.counted, Ordering::Relaxed);
    }
}
