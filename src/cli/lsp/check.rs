//! What needs the model: mistakes, values, dimensions, modes. Worked out beside the server, for the newest text alone.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use librate::budget::Budget;
use librate::diagnostic::{Diagnostic, Severity};
use librate::expr::{ExprId, Pool};
use librate::model::{self, Dimension, Model, Settings, TableTexts};
use librate::modes::Options;
use librate::oscillation::NormalModes;
use librate::precision::{Ball, decimal};
use librate::syntax::StatementKind;
use librate::{Error, linearize};
use lsp_server::{Message, Notification, Request, RequestId};
use serde_json::{Value, json};

use super::document::Document;
use super::rest::{AtRest, at_rest};
use crate::cli::args::ModelArgs;
use crate::cli::guard::Guard;
use crate::cli::input::{self, Source};
use crate::cli::messages::Lines;
use crate::cli::{Failure, Size, checked, solved};

/// Modes are computed once nothing was typed for so long, of models up to so many coordinates.
const PAUSE: Duration = Duration::from_millis(200);
const MOST_COORDINATES: usize = 200;
/// A text with mistakes is read for values, and the line above it goes, once nothing was typed for so long.
const LONG_PAUSE: Duration = Duration::from_secs(2);
/// What an editor asks for anew.
const LENS: &str = "workspace/codeLens/refresh";
const HINTS: &str = "workspace/inlayHint/refresh";
/// So many frequencies are shown, with so many digits.
const SHOWN: usize = 6;
const DIGITS: usize = 6;

/// What is known of each text.
pub(super) type Known = Arc<Mutex<HashMap<String, State>>>;

#[derive(Default)]
pub(super) struct State {
    /// The number of the newest check.
    pub(super) latest: u64,
    pub(super) facts: Arc<Facts>,
}

/// What is known of the statements as they were last in order; the mistakes are those of now.
#[derive(Clone, Default)]
pub(super) struct Facts {
    pub(super) diagnostics: Vec<Diagnostic>,
    /// The values of parameters and constant expressions in SI: by name, the members with their digits.
    pub(super) values: BTreeMap<String, Vec<(String, String)>>,
    pub(super) dimensions: BTreeMap<String, Dimension>,
    /// The columns of the tables.
    pub(super) columns: BTreeMap<String, Vec<String>>,
    /// The frequencies in a line.
    pub(super) modes: Option<String>,
    /// The coordinates at the equilibrium, by the names of their families.
    pub(super) at_rest: BTreeMap<String, Vec<AtRest>>,
}

/// A poisoned lock holds nothing that is half done.
pub(super) fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A text to be checked.
pub(super) struct Job {
    pub(super) document: Document,
    pub(super) budget: Budget,
    pub(super) number: u64,
}

/// Sends the editor a message, as long as there is one.
type Editor = Box<dyn Fn(Message) + Send>;

pub(super) struct Checker {
    editor: Editor,
    /// What the editor is able to ask for anew.
    renewed: Vec<&'static str>,
    pub(super) known: Known,
}

impl Checker {
    pub(super) fn new(editor: Editor, workspace: &Value) -> Self {
        let known = |field: &str| workspace[field]["refreshSupport"] == json!(true);
        let all = [("codeLens", LENS), ("inlayHint", HINTS)];
        let renewed = all.into_iter().filter(|(field, _)| known(field)).map(|(_, method)| method).collect();
        Self { editor, renewed, known: Known::default() }
    }

    /// Works until nobody sends anything more.
    pub(super) fn run(&self, jobs: &Receiver<Job>) {
        let mut waiting = VecDeque::new();
        loop {
            waiting.extend(jobs.try_iter());
            let Some(job) = waiting.pop_front().or_else(|| jobs.recv().ok()) else { return };
            let model = self.check(&job);
            let pause = match &model {
                Some(_) => PAUSE,
                None if !self.is_latest(&job) => continue,
                None if waiting.is_empty() => LONG_PAUSE,
                None => Duration::ZERO,
            };
            match jobs.recv_timeout(pause) {
                Ok(newer) => waiting.push_back(newer),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            let is_right = model.is_some();
            let is_solved = |own: &Model| own.coordinates.len() <= MOST_COORDINATES && own.time_dependent.is_none();
            match model.filter(is_solved) {
                _ if !self.is_latest(&job) => {}
                Some(model) => self.solve(&job, &model),
                None if is_right => self.show_modes(&job, None),
                None => {
                    self.learn(&job, None, &tables(&job.document).0);
                    self.show_modes(&job, None);
                }
            }
        }
    }

    /// Has a line above the model, which stays there until the next one is known.
    fn show_modes(&self, job: &Job, line: Option<String>) {
        let mut is_new = false;
        self.put(job, |facts| {
            is_new = facts.modes != line;
            facts.modes = line;
        });
        if is_new {
            self.renew(job, LENS);
        }
    }

    fn is_latest(&self, job: &Job) -> bool {
        lock(&self.known).get(&job.document.uri).is_some_and(|state| state.latest == job.number)
    }

    /// Works out the modes, and then what takes longer.
    fn solve(&self, job: &Job, model: &Model) {
        let mut options = Options::default().digits(DIGITS);
        (options.vectors, options.threads) = (false, 1);
        let found = solved(model.clone(), &options);
        let line = found.as_ref().map_or_else(ToString::to_string, |(_, modes)| modes_line(model, modes));
        self.show_modes(job, Some(line));
        if let Ok((linearized, _)) = found {
            let at_rest = at_rest(model, &linearized);
            self.put(job, |facts| facts.at_rest = at_rest);
        }
    }

    /// Changes what is known, unless the text is another one by now.
    fn put(&self, job: &Job, change: impl FnOnce(&mut Facts)) {
        let mut known = lock(&self.known);
        if let Some(state) = known.get_mut(&job.document.uri).filter(|state| state.latest == job.number) {
            change(Arc::make_mut(&mut state.facts));
        }
    }

    /// Has it shown, unless the text is another one by now.
    fn renew(&self, job: &Job, method: &'static str) {
        if self.is_latest(job) && self.renewed.contains(&method) {
            let id = RequestId::from(format!("{method} {}", job.number));
            (self.editor)(Message::Request(Request::new(id, method.to_owned(), Value::Null)));
        }
    }

    /// Reports what is wrong with a text; gives the model if nothing is.
    fn check(&self, job: &Job) -> Option<Model> {
        if !self.is_latest(job) {
            return None;
        }
        let document = &job.document;
        let (tables, unread) = tables(document);
        let (diagnostics, model) = match (document.is_readable, unread) {
            (false, _) => (model::mistakes(&document.file, &document.errors, &document.text, &Settings::new()), None),
            (true, Some(unread)) => (vec![unread], None),
            (true, None) => match checked_model(document, &tables, &job.budget) {
                Ok((model, warnings)) => (warnings, Some(model)),
                Err(error) => (error.diagnostics(), None),
            },
        };
        if !self.is_latest(job) {
            return None;
        }
        let lines = document.lines();
        let shown = diagnostics.iter().map(|own| shown(document, &lines, own)).collect();
        let told = published(&document.uri, document.version, shown);
        let columns = columns(document, &tables);
        self.put(job, |facts| {
            facts.diagnostics = diagnostics;
            facts.at_rest = BTreeMap::new();
            // A table that can't be read for the moment has the columns that it had.
            facts.columns.extend(columns);
        });
        // Only now, as an editor asks for corrections as soon as it has the mistakes; and before anything else, as they are
        // waited for.
        (self.editor)(Message::Notification(told));
        // While something is written, what was known of the statements has to do.
        let is_new = lock(&self.known).get(&document.uri).is_none_or(|state| state.facts.values.is_empty());
        if model.is_some() || is_new {
            self.learn(job, model.as_ref(), &tables);
        }
        model
    }

    /// Works out the values and dimensions of what can be read.
    fn learn(&self, job: &Job, model: Option<&Model>, tables: &TableTexts) {
        let document = &job.document;
        let has_lets = document.file.statements.iter().any(|own| matches!(own.kind, StatementKind::Let(_)));
        let values = match model {
            Some(model) if !has_lets => {
                let parameters = model.parameters.iter();
                values(&model.pool, parameters.filter_map(|own| Some((own.name.clone(), own.value?))))
            }
            _ => {
                let settings = Settings::new().within(job.budget.clone());
                let (pool, all) = model::constants(&document.file, tables, &settings);
                values(&pool, all)
            }
        };
        let dimensions = model::dimensions(&document.file);
        self.put(job, |facts| {
            // What can't be read for the moment is as it was.
            if model.is_some() {
                (facts.values, facts.dimensions) = (BTreeMap::new(), BTreeMap::new());
            }
            facts.values.extend(values);
            facts.dimensions.extend(dimensions);
        });
        self.renew(job, HINTS);
    }
}

/// What the command line would be asked.
fn arguments(document: &Document) -> ModelArgs {
    let (settings, allow_paths) = (Vec::new(), Vec::new());
    ModelArgs { file: document.path(), settings, allow_paths, verbose: false, guard: Guard::default(), drawn: false }
}

/// The tables of a model, or why none can be read.
fn tables(document: &Document) -> (TableTexts, Option<Diagnostic>) {
    let mut source = Source::of(&document.path(), String::new());
    match input::read_tables(&arguments(document), &document.file, &mut source) {
        Ok(tables) => (tables, None),
        Err(Failure::Other { message, .. }) => (TableTexts::new(), Some(Diagnostic::global(message))),
        Err(_) => (TableTexts::new(), None),
    }
}

fn checked_model(document: &Document, tables: &TableTexts, budget: &Budget) -> Result<(Model, Vec<Diagnostic>), Error> {
    let settings = Settings::new().within(budget.clone());
    checked(&arguments(document), &document.file, tables, &settings, Size::Any)
}

/// The names in the first line of each table.
fn columns(document: &Document, tables: &TableTexts) -> BTreeMap<String, Vec<String>> {
    let named = document.file.statements.iter().filter_map(|own| {
        let StatementKind::Table { name, path, .. } = &own.kind else { return None };
        let is_matrix = path.to_ascii_lowercase().ends_with(".mtx");
        let is_header = |line: &&str| !line.trim().is_empty() && !line.starts_with('#');
        let columns = if is_matrix { "i,j,v" } else { tables.text(path)?.lines().find(is_header)? };
        let columns = columns.trim_start_matches('\u{feff}').split(',');
        Some((name.text.to_string(), columns.map(|own| own.trim().trim_matches('"').to_owned()).collect()))
    });
    named.collect()
}

/// The digits of a value, without zeros at the end: it is often a short decimal.
pub(super) fn digits(value: &Ball) -> String {
    let text = decimal(value, DIGITS).text;
    let (digits, power) = text.split_at(text.find('e').unwrap_or(text.len()));
    match digits.contains('.') {
        true => format!("{}{power}", digits.trim_end_matches('0').trim_end_matches('.')),
        false => text,
    }
}

fn values(pool: &Pool, all: impl IntoIterator<Item = (String, ExprId)>) -> BTreeMap<String, Vec<(String, String)>> {
    let mut values: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    for (name, value) in all {
        if let Some(value) = linearize::constant(pool, value) {
            let family = name.split('[').next().unwrap_or_default();
            values.entry(family.to_owned()).or_default().push((name.clone(), digits(&value)));
        }
    }
    values
}

/// The frequencies, and whether motions stay small.
fn modes_line(model: &Model, modes: &NormalModes) -> String {
    let shown = modes.modes.iter().take(SHOWN).map(|mode| decimal(&mode.omega, DIGITS).text);
    let mut all: Vec<String> = shown.collect();
    all.extend((modes.modes.len() > SHOWN).then(|| "…".to_owned()));
    let unit = if model.has_units { " rad/s" } else { "" };
    format!("omega = {}{unit}, {}", all.join(", "), modes.stability.as_str())
}

/// A message as an editor has it.
fn shown(document: &Document, lines: &Lines<'_>, own: &Diagnostic) -> Value {
    let primary = own.primary.as_ref();
    let label = primary.filter(|label| !label.text.is_empty()).map(|label| format!(": {}", label.text));
    let help = own.help.as_ref().map(|help| format!("\n{help}"));
    let message = format!("{}{}{}", own.message, label.unwrap_or_default(), help.unwrap_or_default());
    let related = own
        .secondary
        .iter()
        .map(|label| json!({"location": document.location(lines, label.span), "message": label.text}));
    let severity = if own.severity == Severity::Warning { 2 } else { 1 };
    let mut shown = json!({
        "range": lines.range(primary.map(|label| label.span).unwrap_or_default()),
        "severity": severity,
        "source": "librate",
        "message": message,
        "relatedInformation": related.collect::<Vec<Value>>(),
    });
    if let Some(code) = own.code {
        shown["code"] = json!(code);
    }
    // What is never used is shown paler.
    if matches!(own.code, Some("W0001" | "W0002" | "W0003" | "W0004")) {
        shown["tags"] = json!([1]);
    }
    shown
}

pub(super) fn published(uri: &str, version: Option<i64>, diagnostics: Vec<Value>) -> Notification {
    let mut told = json!({"uri": uri, "diagnostics": diagnostics});
    if let Some(version) = version {
        told["version"] = json!(version);
    }
    Notification::new("textDocument/publishDiagnostics".to_owned(), told)
}
