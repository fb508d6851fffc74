//! Reading what the library is handed: the model file, its tables, points and meshes.
//!
//! Everything is judged by the bytes that were read; what is larger than its limit is refused and never cut.

use std::borrow::Cow;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use librate::diagnostic::Diagnostic;
use librate::model::TableTexts;
use librate::syntax::{self, StatementKind, SyntaxError};

use super::args::ModelArgs;
use super::output::visible;
use super::{Failure, fault};

/// Larger tables are not read.
const MOST_TABLE_BYTES: usize = 256 << 20;
/// The largest mesh that is read: ten million triangles.
const MOST_MESH_BYTES: usize = 512 << 20;

/// The text of a model file, and what to call it in messages.
#[derive(Clone)]
pub(crate) struct Source {
    pub(crate) name: String,
    pub(crate) text: String,
    /// What results are not written over: files that were read, and those written so far.
    pub(crate) taken: Vec<PathBuf>,
}

impl Source {
    /// A file as it was read, with `text` for messages.
    pub(crate) fn of(file: &Path, text: String) -> Self {
        if is_stream(file) {
            let opened = if file.as_os_str() == "-" { Path::new("/dev/stdin") } else { file };
            return Self { name: "<stdin>".to_owned(), text, taken: vec![opened.to_owned()] };
        }
        Self { name: file.display().to_string(), text, taken: vec![file.to_owned()] }
    }

    /// The name for a terminal, beside colours of our own.
    pub(crate) fn shown(&self) -> Cow<'_, str> {
        visible(&self.name, false)
    }
}

/// Reads the model file, or standard input for `-`.
pub(crate) fn read_model(file: &Path) -> Result<Source, Failure> {
    let bytes = read(file, syntax::MOST_BYTES).map_err(|reason| cannot_read("model", file, &reason))?;
    model_text(file, bytes)
}

/// The bytes of a model as text.
pub(crate) fn model_text(file: &Path, bytes: Vec<u8>) -> Result<Source, Failure> {
    let (read, most) = (bytes.len(), syntax::MOST_BYTES);
    if read > most {
        let error = Diagnostic::from(&SyntaxError::FileTooLarge { bytes: read, most });
        return Err(Failure::Model(Source::of(file, String::new()), vec![error]));
    }
    let text = utf8(bytes).map_err(|reason| cannot_read("model", file, &reason))?;
    Ok(Source::of(file, text))
}

/// Reads a table of points as text.
pub(crate) fn points_text(file: &Path, bytes: Vec<u8>) -> Result<Source, Failure> {
    let text = within(bytes, MOST_TABLE_BYTES).and_then(utf8);
    let text = text.map_err(|reason| cannot_read("table", file, &reason))?;
    Ok(Source::of(file, text))
}

/// Reads a table of numbers, or standard input for `-`.
pub(crate) fn read_table(file: &Path) -> Result<Source, Failure> {
    points_text(file, read_bytes(file)?)
}

/// Reads a file of any kind, or standard input for `-`.
pub(crate) fn read_bytes(file: &Path) -> Result<Vec<u8>, Failure> {
    let bytes = read(file, MOST_MESH_BYTES).and_then(|bytes| within(bytes, MOST_MESH_BYTES));
    bytes.map_err(|reason| cannot_read("", file, &reason))
}

/// Why a named pipe is not read.
const NOT_A_FILE: &str = "it is a pipe or a device, not a file";

fn cannot_read(what: &str, file: &Path, reason: &str) -> Failure {
    let space = if what.is_empty() { "" } else { " " };
    let hint = if reason == NOT_A_FILE { "; `-` reads standard input" } else { "" };
    fault(if is_stream(file) {
        format!("can't read the {what}{space}from standard input: {reason}")
    } else {
        format!("can't read the {what}{space}file `{}`: {reason}{hint}", file.display())
    })
}

/// Reads the tables that a model names, relative to its file; they are in `source` then.
pub(crate) fn read_tables(args: &ModelArgs, model: &syntax::File, source: &mut Source) -> Result<TableTexts, Failure> {
    let allowed = Allowed::new(args)?;
    let mut texts = TableTexts::new();
    let mut seen: Vec<&str> = Vec::new();
    for statement in &model.statements {
        let StatementKind::Table { path, .. } = &statement.kind else { continue };
        if seen.contains(&path.as_str()) {
            continue;
        }
        seen.push(path);
        let text = allowed.place(path).and_then(|place| {
            let text = utf8(within(read_file(&place, MOST_TABLE_BYTES)?, MOST_TABLE_BYTES)?)?;
            source.taken.push(place);
            Ok(text)
        });
        texts = match text {
            Ok(text) => texts.with(path.clone(), text),
            Err(reason) => texts.with_failure(path.clone(), reason),
        };
    }
    Ok(texts)
}

/// Where tables may lie: in or below the folder of the model file, or of one given with `--allow-path`.
struct Allowed {
    /// What paths are relative to.
    folder: PathBuf,
    /// Without symbolic links.
    roots: Vec<PathBuf>,
}

impl Allowed {
    fn new(args: &ModelArgs) -> Result<Self, Failure> {
        let folder = if is_stream(&args.file) { Path::new(".") } else { folder(&args.file) };
        let mut roots: Vec<PathBuf> = folder.canonicalize().into_iter().collect();
        // Of a model that is a symbolic link, the folder that it leads to as well.
        if !is_stream(&args.file)
            && let Ok(file) = args.file.canonicalize()
        {
            roots.extend(file.parent().map(Path::to_owned));
        }
        for root in &args.allow_paths {
            roots.push(root.canonicalize().map_err(|error| {
                let reason = in_words(&error);
                fault(format!("can't use the folder `{}`: {reason}", root.display()))
            })?);
        }
        Ok(Self { folder: folder.to_owned(), roots })
    }

    /// The file that a model calls `path`. Of what lies elsewhere nothing is said, not even whether it is there.
    fn place(&self, path: &str) -> Result<PathBuf, String> {
        let leads_out =
            !Path::new(path).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        match self.folder.join(path).canonicalize() {
            Ok(place) if self.roots.iter().any(|root| place.starts_with(root)) => Ok(place),
            Err(error) if !leads_out => Err(in_words(&error)),
            Ok(_) | Err(_) => {
                Err("there is no such file in or below the folder of the model; `--allow-path DIR` adds another folder"
                    .to_owned())
            }
        }
    }
}

/// The folder of a file.
pub(crate) fn folder(file: &Path) -> &Path {
    file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."))
}

/// Standard input, or what a shell has opened, as for `<(…)`: read to its end like a pipe.
pub(crate) fn is_stream(file: &Path) -> bool {
    let file = file.as_os_str().to_str().unwrap_or_default();
    matches!(file, "-" | "/dev/stdin") || file.starts_with("/dev/fd/")
}

/// At most one byte more than `most`, so that one can tell that this is too much.
fn read(file: &Path, most: usize) -> Result<Vec<u8>, String> {
    if file.as_os_str() == "-" {
        return all(io::stdin().lock(), most);
    }
    if is_stream(file) {
        return all(open(file)?, most);
    }
    read_file(file, most)
}

/// The same of a file on a disk. Devices and named pipes would keep one waiting, or have no end.
fn read_file(file: &Path, most: usize) -> Result<Vec<u8>, String> {
    let kind = fs::metadata(file).map_err(|error| in_words(&error))?.file_type();
    if kind.is_dir() {
        return Err("it is a directory".to_owned());
    }
    if !kind.is_file() {
        return Err(NOT_A_FILE.to_owned());
    }
    all(open(file)?, most)
}

fn open(file: &Path) -> Result<File, String> {
    File::open(file).map_err(|error| in_words(&error))
}

fn all(source: impl Read, most: usize) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    source.take(most as u64 + 1).read_to_end(&mut bytes).map_err(|error| in_words(&error))?;
    Ok(bytes)
}

/// Refuses what is more than `most` bytes.
fn within(bytes: Vec<u8>, most: usize) -> Result<Vec<u8>, String> {
    if bytes.len() > most { Err(format!("it is larger than {} MB", most >> 20)) } else { Ok(bytes) }
}

fn utf8(bytes: Vec<u8>) -> Result<String, String> {
    String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let bytes = error.into_bytes();
        let line = bytes[..good].iter().filter(|byte| **byte == b'\n').count() + 1;
        let byte = bytes.get(good).copied().unwrap_or(0);
        format!("it is not UTF-8 text (byte {good} in line {line}, {byte:#04x})")
    })
}

pub(crate) fn in_words(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "reading it is not permitted".to_owned(),
        io::ErrorKind::IsADirectory => "it is a directory".to_owned(),
        _ => error.to_string(),
    }
}
