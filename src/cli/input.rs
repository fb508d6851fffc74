//! Reading what the library is handed: the model file and its tables.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use librate::model::TableTexts;
use librate::syntax::{self, StatementKind};

/// Larger tables are not read.
const MOST_TABLE_BYTES: u64 = 256 << 20;

/// The text of a model file, and what to call it in messages.
pub(crate) struct Source {
    pub(crate) name: String,
    pub(crate) text: String,
}

/// Reads the model file, or standard input for `-`.
pub(crate) fn read_model(file: &Path) -> Result<Source, String> {
    // One byte more than the parser reads, so that it can say that this is too much.
    let most = syntax::MOST_BYTES as u64 + 1;
    if is_standard_input(file) {
        let text = read_text(io::stdin().lock(), most);
        return match text {
            Ok(text) => Ok(Source {
                name: "<stdin>".to_owned(),
                text,
            }),
            Err(reason) => Err(format!(
                "can't read the model from standard input: {reason}"
            )),
        };
    }
    let name = file.display().to_string();
    match open(file).and_then(|opened| read_text(opened, most)) {
        Ok(text) => Ok(Source { name, text }),
        Err(reason) => Err(format!("can't read the model file `{name}`: {reason}")),
    }
}

/// Reads the tables that a model names, relative to its file.
pub(crate) fn read_tables(file: &Path, model: &syntax::File) -> TableTexts {
    let folder = if is_standard_input(file) {
        None
    } else {
        file.parent()
    };
    let mut texts = TableTexts::new();
    let mut seen: Vec<&str> = Vec::new();
    for statement in &model.statements {
        let StatementKind::Table { path, .. } = &statement.kind else {
            continue;
        };
        if seen.contains(&path.as_str()) {
            continue;
        }
        seen.push(path);
        let place = folder.map_or_else(|| Path::new(path).to_owned(), |folder| folder.join(path));
        texts = match read_table(&place) {
            Ok(text) => texts.with(path.clone(), text),
            Err(reason) => texts.with_failure(path.clone(), reason),
        };
    }
    texts
}

/// The largest file of points or triangles that is read.
const MOST_BYTES: u64 = 2 << 30;

/// Reads a file of any kind, or standard input for `-`.
pub(crate) fn read_bytes(file: &Path) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let name = file.display();
    let read = if is_standard_input(file) {
        let read = io::stdin()
            .lock()
            .take(MOST_BYTES + 1)
            .read_to_end(&mut bytes);
        read.map_err(|error| in_words(&error))
    } else {
        open(file).and_then(|opened| {
            let read = opened.take(MOST_BYTES + 1).read_to_end(&mut bytes);
            read.map_err(|error| in_words(&error))
        })
    };
    match read {
        Ok(_) if bytes.len() as u64 > MOST_BYTES => Err(format!(
            "the file `{name}` is larger than {} GB",
            MOST_BYTES >> 30
        )),
        Ok(_) => Ok(bytes),
        Err(reason) if is_standard_input(file) => {
            Err(format!("can't read standard input: {reason}"))
        }
        Err(reason) => Err(format!("can't read the file `{name}`: {reason}")),
    }
}

fn read_table(place: &Path) -> Result<String, String> {
    let text = read_text(open(place)?, MOST_TABLE_BYTES + 1)?;
    if text.len() as u64 > MOST_TABLE_BYTES {
        return Err(format!("it is larger than {} MB", MOST_TABLE_BYTES >> 20));
    }
    Ok(text)
}

pub(crate) fn is_standard_input(file: &Path) -> bool {
    file.as_os_str() == "-"
}

fn open(file: &Path) -> Result<File, String> {
    let opened = File::open(file).map_err(|error| in_words(&error))?;
    match opened.metadata() {
        Ok(metadata) if metadata.is_dir() => Err("it is a directory".to_owned()),
        Ok(_) | Err(_) => Ok(opened),
    }
}

/// At most `most` bytes of UTF-8; a character cut in two at the end is dropped.
fn read_text(source: impl Read, most: u64) -> Result<String, String> {
    let mut bytes = Vec::new();
    source
        .take(most)
        .read_to_end(&mut bytes)
        .map_err(|error| in_words(&error))?;
    utf8(bytes, most)
}

/// The bytes as text; of `most` bytes a character cut in two at the end is dropped.
pub(crate) fn utf8(bytes: Vec<u8>, most: u64) -> Result<String, String> {
    let length = bytes.len() as u64;
    String::from_utf8(bytes).or_else(|error| {
        let fault = error.utf8_error();
        let mut bytes = error.into_bytes();
        let good = fault.valid_up_to();
        if length == most && fault.error_len().is_none() {
            bytes.truncate(good);
            return String::from_utf8(bytes).map_err(|_| "it is not UTF-8 text".to_owned());
        }
        let line = bytes[..good].iter().filter(|byte| **byte == b'\n').count() + 1;
        Err(format!(
            "it is not UTF-8 text (byte {good} in line {line}, {:#04x})",
            bytes.get(good).copied().unwrap_or(0)
        ))
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
