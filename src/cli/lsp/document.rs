//! A text that is open in an editor.

use std::path::PathBuf;
use std::sync::Arc;

use librate::span::Span;
use librate::syntax::{self, File, NameKind, NamePlace, SyntaxError};
use serde_json::{Value, json};

use crate::cli::messages::Lines;

/// A text as it is at the moment, and as much of it as can be read.
#[derive(Clone)]
pub(super) struct Document {
    pub(super) uri: String,
    pub(super) version: Option<i64>,
    pub(super) text: Arc<str>,
    pub(super) file: Arc<File>,
    /// Whether the whole text has a tree.
    pub(super) is_readable: bool,
    pub(super) errors: Arc<[SyntaxError]>,
    /// The last text without mistakes of syntax, and its tree.
    last: Option<(Arc<str>, Arc<File>)>,
}

impl Document {
    /// Reads a text, with what was there before.
    pub(super) fn read(uri: &str, version: Option<i64>, text: &str, before: Option<&Self>) -> Self {
        let mut last = before.and_then(|own| own.last.clone());
        let (file, errors) = match &last {
            Some((old, file)) => syntax::parse_changed(file, old, text),
            None => syntax::parse_readable(text),
        };
        let (text, file, is_readable): (Arc<str>, _, _) = (text.into(), Arc::new(file), errors.is_empty());
        if is_readable {
            last = Some((text.clone(), file.clone()));
        }
        Self { uri: uri.to_owned(), version, text, file, is_readable, errors: errors.into(), last }
    }

    pub(super) fn lines(&self) -> Lines<'_> {
        Lines::new(&self.text)
    }

    /// The file, where the text has one; a text without one is treated like standard input.
    pub(super) fn path(&self) -> PathBuf {
        let path = self.uri.strip_prefix("file://").map(decoded);
        // On Windows `file:///c:/models/chain.lag`.
        let path = path.map(|path| match path.as_bytes() {
            [b'/', letter, b':', ..] if letter.is_ascii_alphabetic() => path[1..].to_owned(),
            _ => path,
        });
        PathBuf::from(path.as_deref().unwrap_or("-"))
    }

    pub(super) fn source(&self, span: Span) -> &str {
        self.text.get(span.range()).unwrap_or_default()
    }

    /// The name at an offset, or just before it.
    pub(super) fn name_at(&self, at: usize) -> Option<NamePlace<'_>> {
        let names = syntax::names(&self.file);
        names.into_iter().find(|name| (name.span.start as usize..=name.span.end as usize).contains(&at))
    }

    /// All places of what a name names.
    pub(super) fn same(&self, name: &NamePlace<'_>) -> Vec<NamePlace<'_>> {
        let mut names = syntax::names(&self.file);
        names.retain(|other| other.text == name.text && other.kind == name.kind);
        names
    }

    pub(super) fn location(&self, lines: &Lines<'_>, span: Span) -> Value {
        json!({"uri": self.uri, "range": lines.range(span)})
    }

    /// The address of a table beside the model.
    pub(super) fn beside(&self, path: &str) -> String {
        let folder = self.uri.rfind('/').map_or("", |end| &self.uri[..=end]);
        let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/._-~".contains(&byte);
        let encoded =
            path.bytes().map(|byte| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") });
        format!("{folder}{}", encoded.collect::<String>())
    }

    /// The path of a table.
    pub(super) fn table(&self, name: &str) -> Option<&str> {
        self.file.statements.iter().find_map(|own| match &own.kind {
            syntax::StatementKind::Table { name: own, path, .. } if *own.text == *name => Some(path.as_str()),
            _ => None,
        })
    }
}

/// Whether a name can be given another one.
pub(super) fn is_renamable(name: &NamePlace<'_>) -> bool {
    matches!(name.kind, NameKind::Quantity | NameKind::Index(_) | NameKind::Model)
}

/// `%20` and the like as what they stand for.
fn decoded(text: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let [first, after @ ..] = rest {
        let digit = |at: usize| after.get(at).and_then(|byte| char::from(*byte).to_digit(16));
        if let (b'%', Some(high), Some(low)) = (first, digit(0), digit(1)) {
            bytes.push((16 * high + low) as u8);
            rest = &after[2..];
        } else {
            bytes.push(*first);
            rest = after;
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
