//! `librate fmt`: rewrites model files in canonical layout, or shows what would change.

use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use librate::Error;
use librate::syntax;
use similar::TextDiff;

use super::args::{Fmt, MessageFormat};
use super::input::{self, Source};
use super::{FAULT, Failure, complain, write_out};

/// The least difference is looked for so long; only huge files with changes everywhere need more,
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
    let source = input::read_model(file).map_err(fault)?;
    let formatted = match syntax::format(&source.text) {
        Ok(formatted) => formatted,
        Err(errors) => return Err(Failure::Model(source, Error::from(errors).diagnostics())),
    };
    let same = formatted == source.text;
    if check {
        if !same {
            write_out(&difference(&source, &formatted))?;
        }
        return Ok(same);
    }
    if input::is_standard_input(file) {
        write_out(&formatted)?;
    } else if !same {
        replace(file, &formatted).map_err(|error| {
            let reason = match error.kind() {
                ErrorKind::PermissionDenied => "writing it is not permitted".to_owned(),
                _ => input::in_words(&error),
            };
            fault(format!(
                "can't write the model file `{}`: {reason}",
                source.name
            ))
        })?;
    }
    Ok(true)
}

fn fault(message: String) -> Failure {
    Failure::Other {
        message,
        help: None,
        status: FAULT,
    }
}

/// A unified diff from the file to its canonical layout.
fn difference(source: &Source, formatted: &str) -> String {
    let diff = TextDiff::configure()
        .timeout(PATIENCE)
        .diff_lines(source.text.as_str(), formatted);
    let mut unified = diff.unified_diff();
    unified
        .context_radius(CONTEXT)
        .header(&source.name, &format!("{} (formatted)", source.name));
    unified.to_string()
}

/// Writes the text to a new file beside the old one, which it then replaces: whatever happens in
/// between, one of the two is whole. A link stays a link, and permissions stay as they are.
fn replace(file: &Path, text: &str) -> io::Result<()> {
    let target = fs::canonicalize(file)?;
    let permissions = fs::metadata(&target)?.permissions();
    if permissions.readonly() {
        return Err(ErrorKind::PermissionDenied.into());
    }
    let (path, mut beside) = create_beside(&target)?;
    let written = beside
        .write_all(text.as_bytes())
        .and_then(|()| beside.set_permissions(permissions))
        .and_then(|()| beside.sync_all())
        .and_then(|()| fs::rename(&path, &target));
    if written.is_err() {
        // The first error is the one to report.
        let _ = fs::remove_file(&path);
    }
    written
}

/// A new file in the folder of another, under a name that nothing has.
fn create_beside(target: &Path) -> io::Result<(PathBuf, fs::File)> {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let mut attempt = 0_u32;
    loop {
        let path = target.with_file_name(format!(".{name}.{}.{attempt}", std::process::id()));
        match fs::File::create_new(&path) {
            Ok(file) => return Ok((path, file)),
            Err(error) if error.kind() == ErrorKind::AlreadyExists && attempt < 100 => attempt += 1,
            Err(error) => return Err(error),
        }
    }
}
