//! From arguments to an exit status: reads files, calls the library, writes.

mod args;
mod draw;
mod fmt;
mod input;
mod progress;

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

use anstream::{AutoStream, ColorChoice};
use clap::Parser;
use librate::diagnostic::Diagnostic;
use librate::model::{self, Model, Settings};
use librate::report::{self, Style};
use librate::{Error, linearize, modes, oscillation, syntax};

use args::{Cli, Command, ModelArgs};
use input::Source;
use progress::Progress;

/// The model or the request is at fault.
const FAULT: u8 = 1;
/// Wrong usage.
const USAGE: u8 = 2;
/// Columns where the output is no terminal: fixed, so that it is the same everywhere.
const PLAIN_WIDTH: usize = 100;
/// Messages in a pipe are wrapped by whoever reads them.
const PLAIN_MESSAGE_WIDTH: usize = 140;

/// Why a command ended without a result.
enum Failure {
    /// Mistakes in the model, to be drawn into its text.
    Model(Source, Vec<Diagnostic>),
    /// Anything else, with the exit status.
    Other {
        message: String,
        help: Option<String>,
        status: u8,
    },
    /// Nobody reads the output any more.
    BrokenPipe,
}

/// Runs the command that was typed.
pub(crate) fn run() -> ExitCode {
    let cli = Cli::parse();
    let result = match &cli.command {
        Command::Modes(modes) => modes_text(modes),
        Command::Check(check) => check_text(check),
        Command::Derive(derive) => derive_text(derive),
        // Has several files, each with a result of its own.
        Command::Fmt(fmt) => return fmt::run(fmt),
    };
    match result.and_then(|text| write_out(&text)) {
        Ok(()) | Err(Failure::BrokenPipe) => ExitCode::SUCCESS,
        Err(failure) => ExitCode::from(complain(failure)),
    }
}

fn modes_text(args: &args::Modes) -> Result<String, Failure> {
    let (source, model) = load(&args.model)?;
    let options = modes::Options {
        vectors: !args.no_vectors,
        lowest: args.lowest,
        digits: args.digits,
    };
    let progress = Progress::start("computing the modes");
    let computed = linearize::linearize(model).and_then(|linearized| {
        let modes = oscillation::normal_modes(&linearized, &options)?;
        Ok((linearized, modes))
    });
    drop(progress);
    match computed {
        Ok((linearized, modes)) if args.json => {
            Ok(report::modes_json(&linearized, &modes, &options))
        }
        Ok((linearized, modes)) => Ok(report::modes_text(&linearized, &modes, &options, &style())),
        Err(error) => Err(Failure::Model(source, Error::from(error).diagnostics())),
    }
}

fn check_text(args: &args::Check) -> Result<String, Failure> {
    let (source, model) = load(&args.model)?;
    let name = model.name.as_ref().unwrap_or(&source.name);
    let count = model.coordinates.len();
    let plural = if count == 1 { "" } else { "s" };
    let energies = if model.lagrangian {
        "the lagrangian is in order"
    } else if model.potential.is_empty() {
        "T is in order, V is 0"
    } else {
        "T and V are in order"
    };
    Ok(format!("{name}: {count} coordinate{plural}, {energies}\n"))
}

fn derive_text(args: &args::Derive) -> Result<String, Failure> {
    let (source, model) = load(&args.model)?;
    let name = model.name.clone();
    let progress = Progress::start("deriving M and K");
    let derived = linearize::derive(model);
    drop(progress);
    match derived {
        Ok(matrices) if args.json => Ok(report::derive_json(name.as_deref(), &matrices)),
        Ok(matrices) => Ok(report::derive_text(name.as_deref(), &matrices, &style())),
        Err(error) => Err(Failure::Model(source, Error::from(error).diagnostics())),
    }
}

/// The checked model, and its text for messages.
fn load(args: &ModelArgs) -> Result<(Source, Model), Failure> {
    let mut settings = Settings::new();
    for text in &args.settings {
        settings.add(text).map_err(|error| {
            let diagnostic = Diagnostic::from(&error);
            Failure::Other {
                message: diagnostic.message,
                help: diagnostic.help,
                status: USAGE,
            }
        })?;
    }
    let source = input::read_model(&args.file).map_err(|message| Failure::Other {
        message,
        help: None,
        status: FAULT,
    })?;
    let checked = syntax::parse(&source.text)
        .map_err(Error::from)
        .and_then(|file| {
            let tables = input::read_tables(&args.file, &file);
            Ok(model::elaborate(&file, &tables, &settings)?)
        });
    match checked {
        Ok(model) => Ok((source, model)),
        Err(error) => Err(Failure::Model(source, error.diagnostics())),
    }
}

fn style() -> Style {
    Style {
        color: AutoStream::choice(&io::stdout()) != ColorChoice::Never,
        width: terminal_width(&io::stdout()).unwrap_or(PLAIN_WIDTH),
    }
}

fn terminal_width(stream: &impl IsTerminal) -> Option<usize> {
    if !stream.is_terminal() {
        return None;
    }
    let (terminal_size::Width(width), _) = terminal_size::terminal_size()?;
    Some(usize::from(width).max(40))
}

fn write_out(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    written.map_err(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => Failure::BrokenPipe,
        _ => Failure::Other {
            message: format!("can't write the result: {error}"),
            help: None,
            status: FAULT,
        },
    })
}

/// Writes what went wrong to standard error; gives the exit status.
fn complain(failure: Failure) -> u8 {
    let stream = io::stderr();
    let color = AutoStream::choice(&stream) != ColorChoice::Never;
    let (text, status) = match failure {
        Failure::Model(source, all) => {
            let width = terminal_width(&stream).unwrap_or(PLAIN_MESSAGE_WIDTH);
            (draw::diagnostics(&source, &all, color, width), FAULT)
        }
        Failure::Other {
            message,
            help,
            status,
        } => (draw::message(&message, help.as_deref(), color), status),
        Failure::BrokenPipe => return 0,
    };
    // Where not even this can be written, the exit status has to do.
    let _ = stream.lock().write_all(text.as_bytes());
    status
}
