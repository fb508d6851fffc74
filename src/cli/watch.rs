//! `librate watch`: a command again each time its model is saved.

use std::collections::HashSet;
use std::convert::Infallible;
use std::ffi::OsString;
use std::io::{self, IsTerminal};
use std::path::PathBuf;
use std::process::{Child, Command as Process, ExitCode};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::Duration;

use clap::{Args, CommandFactory};
use librate::syntax::{self, StatementKind};
use notify_debouncer_full::notify::RecursiveMode;
use notify_debouncer_full::{DebounceEventResult, new_debouncer};

use super::args::{Cli, Command, MessageFormat};
use super::input::folder;
use super::{Failure, ended, fault, output};

/// Events within this time are one save.
const SETTLE: Duration = Duration::from_millis(50);
/// How often a running command is asked whether it has ended.
const TICK: Duration = Duration::from_millis(20);

/// What can be typed.
#[derive(Debug, Args)]
pub(crate) struct Watch {
    /// The command with its arguments, or the model file alone
    #[arg(value_name = "COMMAND", required = true, trailing_var_arg = true, allow_hyphen_values = true)]
    words: Vec<OsString>,
}

/// What is run, and the model that it is about.
struct Task {
    words: Vec<OsString>,
    file: PathBuf,
}

impl Task {
    fn new(watch: &Watch) -> Result<Self, Failure> {
        let mut words = watch.words.clone();
        let known = |word: &OsString| Cli::command().get_subcommands().any(|own| word == own.get_name());
        if words.first().is_some_and(|word| !known(word)) {
            words.insert(0, "modes".into());
        }
        let typed = std::iter::once(OsString::from("librate")).chain(words.iter().cloned());
        let mut cli = super::args::parsed(typed).map_err(Failure::Usage)?;
        let file = match &mut cli.command {
            // It would write what it watches.
            Command::Fmt(_) => None,
            command => command.model().map(|model| model.file.clone()),
        };
        let none = || fault("only commands that read one model can be run again and again".to_owned());
        let file = file.ok_or_else(none)?;
        if file.as_os_str() == "-" {
            return Err(fault("standard input is never saved: give a file".to_owned()));
        }
        if matches!(&cli.command, Command::Show(show) if show.output.is_some()) {
            words.push("--live".into());
        }
        Ok(Self { words, file })
    }

    /// The model and its tables, as far as they are known.
    fn files(&self) -> HashSet<PathBuf> {
        let folder = folder(&self.file);
        let text = std::fs::read_to_string(&self.file).unwrap_or_default();
        let mut files = HashSet::from([self.file.clone()]);
        for statement in syntax::parse(&text).map(|file| file.statements).unwrap_or_default() {
            if let StatementKind::Table { path, .. } = statement.kind {
                files.insert(folder.join(path));
            }
        }
        files
    }

    fn start(&self) -> Result<Child, Failure> {
        let own = std::env::current_exe();
        let started = own.and_then(|own| Process::new(own).args(&self.words).spawn());
        started.map_err(|error| fault(format!("can't run the command: {error}")))
    }

    /// Runs the command again and again.
    fn repeat(&self) -> Result<Infallible, Failure> {
        let cannot = |error: &dyn std::fmt::Display| fault(format!("can't watch `{}`: {error}", self.file.display()));
        let (sender, events) = mpsc::channel::<DebounceEventResult>();
        let mut debouncer = new_debouncer(SETTLE, None, sender).map_err(|error| cannot(&error))?;
        let mut folders = HashSet::new();
        loop {
            // Editors put a new file in place of the old one: folders stay.
            let files = self.files();
            for own in files.iter().map(|file| folder(file)) {
                if folders.insert(own.to_owned()) {
                    let watched = debouncer.watch(own, RecursiveMode::NonRecursive);
                    if own == folder(&self.file) {
                        watched.map_err(|error| cannot(&error))?;
                    }
                }
            }
            let own: Vec<PathBuf> =
                files.iter().filter_map(|file| file.canonicalize().ok()).chain(files.clone()).collect();
            if io::stdout().is_terminal() {
                output::clear_screen();
            }
            let mut child = self.start()?;
            let saved = wait(&events, &mut child, &own);
            // An answer to what is no longer written.
            let _ = child.kill();
            let _ = child.wait();
            if !saved {
                return Err(fault("can't watch any longer".to_owned()));
            }
        }
    }
}

/// Runs until it is interrupted or can't go on.
pub(super) fn run(watch: &Watch, format: MessageFormat) -> ExitCode {
    let Err(failure) = Task::new(watch).and_then(|task| task.repeat());
    ended(Err(failure), format)
}

/// Waits until one of the files is saved; false where nothing is heard any more.
fn wait(events: &Receiver<DebounceEventResult>, child: &mut Child, files: &[PathBuf]) -> bool {
    let mut running = true;
    loop {
        let heard =
            if running { events.recv_timeout(TICK) } else { events.recv().map_err(|_| RecvTimeoutError::Disconnected) };
        match heard {
            Ok(Ok(all)) => {
                let is_own = |path: &PathBuf| files.iter().any(|own| own == path || path.ends_with(own));
                let changed = all.iter().filter(|event| !event.kind.is_access());
                if changed.flat_map(|event| &event.paths).any(is_own) {
                    return true;
                }
            }
            // Events that were lost may have been of these files.
            Ok(Err(_)) => return true,
            Err(RecvTimeoutError::Timeout) => running = matches!(child.try_wait(), Ok(None)),
            Err(RecvTimeoutError::Disconnected) => return false,
        }
    }
}
