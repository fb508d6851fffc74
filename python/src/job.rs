//! A model as Python holds it, and the thread in which its commands run: the interpreter goes on meanwhile, and an interrupt
//! or the end of the budget stops the work.

use std::collections::BTreeMap;
use std::panic;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

use librate::batch::StudyError;
use librate::budget::{Budget, Exceeded, Limit, Limits};
use librate::diagnostic::Diagnostic;
use librate::inertia::{self, InertiaError};
use librate::linearize::LinearizeError;
use librate::model::{self, ModelError, Range, Settings, TableTexts};
use librate::syntax::{self, StatementKind, SyntaxError};
use librate::{Error, linearize, sensitivity};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::answers::Shown;

/// How often an interrupt and the clock are asked for.
const TICK: Duration = Duration::from_millis(20);
/// As the main thread of a program has.
const STACK: usize = 8 << 20;

/// What went wrong.
#[derive(Debug)]
pub(crate) struct Failure(pub(crate) Vec<Diagnostic>);

macro_rules! failures {
    ($diagnostics:expr => $($error:ty),*) => {$(
        impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self($diagnostics(error))
            }
        }
    )*};
}

failures!(
    |error| Error::from(error).diagnostics() => Vec<SyntaxError>,
    Vec<ModelError>,
    ModelError,
    LinearizeError,
    librate::motion::MotionError,
    librate::period::PeriodError,
    librate::amplitude::AmplitudeError,
    librate::equilibria::EquilibriaError,
    librate::floquet::FloquetError,
    librate::response::ResponseError
);
failures!(|error: Error| error.diagnostics() => Error);
failures!(|error| vec![Diagnostic::from(&error)] => Exceeded, InertiaError, StudyError);
failures!(|errors: Vec<_>| errors.iter().map(Diagnostic::from).collect() => Vec<InertiaError>);

impl Failure {
    /// A request that can't be met, and how to write one that can.
    pub(crate) fn request(message: impl Into<String>, help: &str) -> Self {
        Self(vec![Diagnostic::global(message).with_help(help)])
    }

    /// As `librate.Error`.
    pub(crate) fn raise(&self, py: Python<'_>, page: &Page) -> PyErr {
        let shown = py.detach(|| Shown::new(page, &self.0));
        let made = || py.import("librate._errors")?.getattr("_error")?.call1((shown,));
        made().map_or_else(|error| error, PyErr::from_value)
    }
}

/// A text with its name, for messages.
#[derive(Debug)]
pub(crate) struct Page {
    pub(crate) name: String,
    pub(crate) text: String,
}

/// All that a model is made from.
#[derive(Debug)]
pub(crate) struct Source {
    pub(crate) page: Page,
    pub(crate) file: syntax::File,
    pub(crate) tables: TableTexts,
    settings: Settings,
    limits: Limits,
}

/// A command at work on a model.
pub(crate) struct Job {
    pub(crate) source: Arc<Source>,
    /// Values from outside, with the budget of this command.
    pub(crate) settings: Settings,
    pub(crate) warnings: Vec<Diagnostic>,
    budget: Budget,
    /// Set where the time begins anew.
    clock: Arc<AtomicBool>,
}

/// How many coordinates a command can do with.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Size {
    Any,
    /// As many as dense matrices can have.
    Dense,
}

impl Job {
    /// The model; what is suspicious in it is kept.
    pub(crate) fn model(&mut self, size: Size) -> Result<model::Model, Failure> {
        let Source { file, tables, .. } = self.source.as_ref();
        if size == Size::Dense {
            linearize::check_size(model::coordinate_count(file, tables, &self.settings))?;
        }
        let model = model::elaborate(file, tables, &self.settings)?;
        self.warnings.extend(model.warnings(file));
        self.warnings.extend(inertia::warnings(&model));
        Ok(model)
    }

    /// As [`Job::model`], for what takes parameters at their values and says so where these are uncertain.
    pub(crate) fn values(&mut self, size: Size) -> Result<model::Model, Failure> {
        let model = self.model(size)?;
        self.warnings.extend(sensitivity::ignored(&model));
        Ok(model)
    }

    /// For studies that make the model anew at each value of a parameter.
    pub(crate) fn made_from(&self) -> librate::Source {
        let Source { file, tables, .. } = self.source.as_ref();
        librate::Source { file: file.clone(), tables: tables.clone(), settings: self.settings.clone() }
    }
}

/// A model file that was parsed, with its tables and settings.
#[pyclass(frozen, module = "librate._native")]
pub(crate) struct Model {
    pub(crate) source: Arc<Source>,
}

#[pymethods]
impl Model {
    /// `tables` has texts by the names of files or of tables, `failures` why files could not be read.
    #[new]
    fn new(
        py: Python<'_>,
        page: (String, String),
        tables: BTreeMap<String, String>,
        failures: BTreeMap<String, String>,
        settings: Vec<String>,
        budget: Option<String>,
    ) -> PyResult<Self> {
        let (name, text) = page;
        let page = Page { name, text };
        let made = py.detach(|| -> Result<_, Failure> {
            let mut set = Settings::new();
            for text in &settings {
                set.add(text)?;
            }
            let limits = budget.as_deref().map_or(Ok(Limits::default()), Limits::parse);
            let limits = limits.map_err(|wrong| Failure::request("the budget can't be read", &wrong))?;
            let file = model::parse(&page.text, &set).map_err(Failure)?;
            Ok((file, set, limits))
        });
        let (file, settings, limits) = made.map_err(|told| told.raise(py, &page))?;
        let mut texts = TableTexts::new();
        for statement in &file.statements {
            let StatementKind::Table { name, path, .. } = &statement.kind else { continue };
            let text = tables.get(path.as_str()).or_else(|| tables.get(name.text.as_str()));
            texts = match (text, failures.get(path.as_str())) {
                (Some(text), _) => texts.with(path.as_str(), text.as_str()),
                (None, Some(reason)) => texts.with_failure(path.as_str(), reason.as_str()),
                (None, None) => texts,
            };
        }
        Ok(Self { source: Arc::new(Source { page, file, tables: texts, settings, limits }) })
    }

    /// The files that the model names.
    fn paths(&self) -> Vec<&str> {
        let statements = self.source.file.statements.iter();
        let paths = statements.filter_map(|statement| match &statement.kind {
            StatementKind::Table { path, .. } => Some(path.as_str()),
            _ => None,
        });
        paths.collect()
    }
}

impl Model {
    /// Runs a command in a thread of its own: what it found, and warnings.
    pub(crate) fn run<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Job) -> Result<T, Failure> + Send + 'static,
    ) -> PyResult<(T, Shown)> {
        let source = Arc::clone(&self.source);
        let input = (source.page.text.len() + source.tables.bytes()) as u64;
        let (seconds, bytes) = (source.limits.seconds(input), source.limits.bytes(input));
        let budget = Budget::new(bytes);
        let settings = source.settings.clone().within(budget.clone());
        let clock = Arc::new(AtomicBool::new(false));
        let (own, again) = (budget.clone(), Arc::clone(&clock));
        let mut job = Job { source, settings, warnings: Vec::new(), budget: own, clock: again };
        let (done, mut wait) = mpsc::channel();
        let work = move || {
            let result = work(&mut job);
            // Nobody waits for what was interrupted.
            let _ = done.send((result, job.warnings));
        };
        thread::Builder::new().name("librate".to_owned()).stack_size(STACK).spawn(work)?;
        let mut start = Instant::now();
        let stopped = OnceLock::new();
        let (result, warnings) = loop {
            let received;
            (wait, received) = py.detach(move || {
                let received = wait.recv_timeout(TICK);
                (wait, received)
            });
            match received {
                Ok(done) => break done,
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(PyRuntimeError::new_err("the computation ended without an answer"));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
            if let Err(interrupt) = py.check_signals() {
                budget.stop(Limit::Time(seconds));
                return Err(interrupt);
            }
            if clock.swap(false, Ordering::Relaxed) {
                start = Instant::now();
            }
            // What asks its budget ends at nine tenths; for everything else nobody waits any longer than to the end.
            let used = start.elapsed().as_secs_f64() / seconds as f64;
            if used > 0.9 {
                let exceeded = stopped.get_or_init(|| budget.stop(Limit::Time(seconds)));
                if used > 1.0 {
                    return Err(Failure(vec![Diagnostic::from(exceeded)]).raise(py, &self.source.page));
                }
            }
        };
        let page = &self.source.page;
        if let Err(exceeded) = budget.check() {
            // Whatever else it ended with may only follow from that.
            return Err(Failure::from(exceeded).raise(py, page));
        }
        let value = result.map_err(|told| told.raise(py, page))?;
        Ok((value, py.detach(|| Shown::new(page, &warnings))))
    }
}

/// A range from outside.
pub(crate) fn range(text: &str, help: &str) -> Result<Range, Failure> {
    Range::parse(text).map_err(|error| Failure::request(error.to_string(), help))
}

/// As many threads as there are cores.
pub(crate) fn cores() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// Results in order, each made by one of the threads, and each with all of the time for itself.
pub(crate) fn in_parallel<T: Send, W: FnMut(usize) -> T>(
    job: &Job,
    threads: Option<usize>,
    count: usize,
    worker: impl Fn() -> W + Sync,
) -> Result<Vec<T>, Failure> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut work = worker();
        let mut own = Vec::new();
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            if at >= count || job.budget.is_spent() {
                return own;
            }
            own.push((at, work(at)));
            job.clock.store(true, Ordering::Relaxed);
        }
    };
    let mut all: Vec<(usize, T)> = Vec::with_capacity(count);
    thread::scope(|scope| {
        let threads = threads.unwrap_or_else(cores).min(count);
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        for thread in running {
            all.extend(thread.join().unwrap_or_else(|reason| panic::resume_unwind(reason)));
        }
    });
    job.budget.check()?;
    all.sort_unstable_by_key(|(at, _)| *at);
    Ok(all.into_iter().map(|(_, result)| result).collect())
}
