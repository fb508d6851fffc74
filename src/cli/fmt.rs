//! `librate fmt`: rewrites model files in canonical layout, or shows what would change.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use librate::{Error, syntax};
use similar::TextDiff;

use super::args::{Fmt, MessageFormat};
use super::input::{self, Source};
use super::output::{self, visible, write_data, write_out};
use super::{FAULT, Failure, complain, fault};

/// The least difference is searched for so long; only huge files with changes everywhere need more,
/// and are shown as replaced in larger pieces then.
const PATIENCE: Duration = Duration::from_secs(2);
/// Lines around a change.
const CONTEXT: usize = 3;

/// Handles every file, whatever became of those before it; the worst status counts.
pub(super) fn run(args: &Fmt, format: MessageFormat) -> ExitCode {
    let mut status = 0;
    for file in &args.files {
        match one(file, args.check) {
            Ok(true) => {}
            Ok(false) => status = status.max(FAULT),
            // Nobody sees what would change; that something would is in the status.
            Err(Failure::BrokenPipe) => return ExitCode::from(if args.check { FAULT } else { 0 }),
            Err(failure) => status = status.max(complain(failure, format)),
        }
    }
    ExitCode::from(status)
}

/// Formats a file; says whether all is well with it: not so if it was to be checked and differs.
fn one(file: &Path, check: bool) -> Result<bool, Failure> {
    let source = input::read_model(file)?;
    let formatted = syntax::format(&source.text);
    let formatted = formatted.map_err(|all| Failure::Model(source.clone(), Error::from(all).diagnostics()))?;
    let same = formatted == source.text;
    if check {
        if !same {
            write_out(&visible(&difference(&source, &formatted, "formatted"), false))?;
        }
        return Ok(same);
    }
    if input::is_stream(file) {
        write_data(&formatted)?;
    } else if !same {
        rewrite(file, &source, &formatted)?;
    }
    Ok(true)
}

/// Writes a model file anew, which is taken to hold what was read.
pub(super) fn rewrite(file: &Path, source: &Source, new: &str) -> Result<(), Failure> {
    output::replace(file, &|mut out| out.write_all(new.as_bytes()), Some(&source.text)).map_err(|error| {
        let reason = output::in_words(&error);
        fault(format!("can't write the model file `{}`: {reason}", source.name))
    })
}

/// A unified diff from a file to what becomes of it.
pub(super) fn difference(source: &Source, new: &str, what: &str) -> String {
    let diff = TextDiff::configure().timeout(PATIENCE).diff_lines(source.text.as_str(), new);
    let mut unified = diff.unified_diff();
    unified.context_radius(CONTEXT).header(&source.name, &format!("{} ({what})", source.name));
    unified.to_string()
}
