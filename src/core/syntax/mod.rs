//! From the text of a model file to its tree.
//!
//! [`parse`] cuts the text into statements, reads each by the grammar in `grammar/librate.pest`,
//! and puts their trees into one [`File`]; what is wrong in one statement doesn't hide what is
//! wrong in the next. [`print_file`] writes a tree back, and with the feature `format` the function
//! of that name puts a text in canonical layout, comments kept. This stage never asks what a name
//! means: whether it is declared, is a function, or has the right indices is the model's affair.
//! Only this module knows pest.
//!
//! No input overflows the stack: text that nests deeper than 256 levels is refused by the scan
//! in front of the grammar, on every machine alike.

mod arena;
pub mod ast;
mod build;
mod error;
mod explain;
#[cfg(feature = "format")]
mod format;
mod grammar;
mod lexer;
mod lookalike;
mod names;
mod print;
mod reuse;
mod split;
pub(crate) mod units;
mod walk;
mod words;

use hashbrown::HashSet;

pub use arena::{Expressions, Units};
pub use ast::{
    Binding, Comment, Comparison, Drawn, Expr, ExprKind, ExprRef, File, IndexEntry, IndexKind, Indices, Member, Name,
    Statement, StatementKind, Unit, UnitKind, UnitRef,
};
pub use error::SyntaxError;
#[cfg(feature = "format")]
pub use format::format;
#[cfg(feature = "engine")]
pub(crate) use lookalike::latin;
pub use names::{NameKind, NamePlace, names};
#[cfg(feature = "engine")]
pub(crate) use print::print_indices;
pub use print::{print_expr, print_file, print_statement, print_unit};
#[cfg(feature = "format")]
pub(crate) use words::GREEK;
pub use words::{FUNCTIONS, STATEMENT_WORDS, reserved_meaning, signature};
#[cfg(feature = "engine")]
pub(crate) use words::{function_meant, is_derivative};

use crate::order::Order;
use crate::span::Span;
use build::Builder;
use reuse::Old;

/// The longest text read, in bytes.
pub const MOST_BYTES: usize = 32 << 20;

/// Parses the text of a model file.
///
/// A byte order mark at the start is skipped; places count from the beginning of `source`, mark
/// included.
///
/// # Errors
/// All mistakes of the text in the order of their places, one or more; at most a thousand,
/// since nobody reads more. Text longer than [`MOST_BYTES`] is refused as a whole.
///
/// ```
/// let file = librate::syntax::parse("coord x  T = 1/2*x'^2  V = 1/2*x^2")?;
/// assert_eq!(file.statements.len(), 3);
///
/// let errors = librate::syntax::parse("V = 2 x\ncoord t").unwrap_err();
/// assert_eq!(errors[0].to_string(), "the multiplication sign is missing");
/// assert_eq!(errors[1].to_string(), "`t` can't be used as a name");
/// # Ok::<(), Vec<librate::syntax::SyntaxError>>(())
/// ```
pub fn parse(source: &str) -> Result<File, Vec<SyntaxError>> {
    let (file, errors) = parse_readable(source);
    if errors.is_empty() { Ok(file) } else { Err(errors) }
}

/// Parses as much of a text as can be read, for an editor in which it is being written: the tree of all statements
/// without a mistake, and the mistakes of the others as [`parse`] reports them.
///
/// ```
/// let (file, errors) = librate::syntax::parse_readable("param k = 2\nV = 2 x");
/// assert_eq!((file.statements.len(), errors.len()), (1, 1));
/// ```
#[must_use]
pub fn parse_readable(source: &str) -> (File, Vec<SyntaxError>) {
    read(source, None)
}

/// The same of a text that was changed in one place, in less time: what is as in the text `old`, which was read as `file`, is copied.
///
/// ```
/// use librate::syntax::{parse_changed, parse_readable};
/// let (old, new) = ("param k = 2\nV = k", "param k = 21\nV = k");
/// assert_eq!(parse_changed(&parse_readable(old).0, old, new), parse_readable(new));
/// ```
#[must_use]
pub fn parse_changed(file: &File, old: &str, source: &str) -> (File, Vec<SyntaxError>) {
    read(source, Some(&Old::new(file, old, source)))
}

fn read(source: &str, old: Option<&Old<'_>>) -> (File, Vec<SyntaxError>) {
    if source.len() > MOST_BYTES {
        let error = SyntaxError::FileTooLarge { bytes: source.len(), most: MOST_BYTES };
        return (File::default(), vec![error]);
    }
    let mark = '\u{feff}';
    let start = if source.starts_with(mark) { mark.len_utf8() as u32 } else { 0 };
    let pieces = split::split(source, start);
    let mut errors = pieces.errors;
    let mut builder = Builder::new(pieces.comments, pieces.statements.len());
    for piece in pieces.statements {
        if piece.broken {
            continue;
        }
        if errors.len() >= split::MOST_ERRORS {
            break;
        }
        if old.is_some_and(|old| builder.reuse(old, source, piece.span)) {
            continue;
        }
        if let Err(error) = builder.statement(source, piece.span) {
            let place = error.span();
            let lost = matches!(error, SyntaxError::UnknownStatement { .. } | SyntaxError::MissingStatementWord { .. });
            errors.push(error);
            if lost {
                let rest = Span::new(place.start, piece.span.end);
                errors.extend(explain::more_unknown_statements(source, rest));
            }
        }
    }
    errors.truncate(split::MOST_ERRORS);
    errors.order_by_key(SyntaxError::span);
    (builder.finish(), without_follow_ons(source, errors))
}

/// Drops what is said about the uses of a reserved word that the file tries to declare.
fn without_follow_ons(source: &str, mut errors: Vec<SyntaxError>) -> Vec<SyntaxError> {
    let name = |error: &SyntaxError| {
        if let SyntaxError::ReservedName { name, .. } = error { Some(name.clone()) } else { None }
    };
    let declared: HashSet<String> = errors.iter().filter_map(name).collect();
    if !declared.is_empty() {
        errors.retain(|error| {
            let used = source.get(error.span().range());
            matches!(error, SyntaxError::ReservedName { .. }) || used.is_none_or(|word| !declared.contains(word))
        });
    }
    errors
}
