//! Mistakes that stand beside mistakes of syntax, so that all of a file are reported at once.

use hashbrown::HashSet;

use super::elaborate::elaborate;
use super::error::ModelError;
use super::settings::Settings;
use super::table::TableTexts;
use crate::budget::Budget;
use crate::diagnostic::Diagnostic;
use crate::order::Order;
use crate::span::Span;
use crate::syntax::{self, File, SyntaxError};

/// The statements of a file with mistakes are elaborated in so many bytes.
const BYTES: u64 = 16 << 20;

/// Parses a model file as [`syntax::parse`] does. Where it has mistakes of syntax, those of its other statements that are
/// mistakes whatever the broken ones say are reported with them, in the order of the file.
///
/// ```
/// use librate::model;
/// let all = model::parse("param k = 1\nparam k = 2\nV = 1/2 k", &Default::default()).unwrap_err();
/// let codes: Vec<_> = all.iter().filter_map(|own| own.code).collect();
/// assert_eq!(codes, ["E0103", "E0007"]);
/// ```
///
/// # Errors
/// All mistakes of syntax, and such others.
pub fn parse(text: &str, settings: &Settings) -> Result<File, Vec<Diagnostic>> {
    let (file, errors) = syntax::parse_readable(text);
    if errors.is_empty() { Ok(file) } else { Err(mistakes(&file, &errors, text, settings)) }
}

/// All mistakes of a text with the mistakes of syntax that [`syntax::parse_readable`] found, in the order of the file.
#[must_use]
pub fn mistakes(file: &File, errors: &[SyntaxError], text: &str, settings: &Settings) -> Vec<Diagnostic> {
    let settings = settings.clone().within(Budget::new(BYTES));
    let others = elaborate(file, &TableTexts::new(), &settings).err().unwrap_or_default();
    let unread = unread(file, text);
    // An index whose range can't be read is none that is declared.
    let is_index = |name: &str, span: &Span| {
        let statement =
            file.statements.iter().map(|own| own.span.range()).find(|own| own.contains(&span.range().start));
        let text = statement.and_then(|own| text.get(own)).unwrap_or_default();
        text.contains(&format!("{name} in "))
    };
    let is_mistake = |error: &&ModelError| match error {
        ModelError::UndeclaredName { name, span, .. } if is_index(name, span) => false,
        error => stands_alone(error, &unread),
    };
    let others = others.iter().filter(is_mistake).map(Diagnostic::from);
    let mut all: Vec<Diagnostic> = errors.iter().map(Diagnostic::from).chain(others).collect();
    all.order_by_key(|own| own.primary.as_ref().map(|label| label.span));
    all
}

/// The words of what can't be read.
fn unread<'a>(file: &File, text: &'a str) -> HashSet<&'a str> {
    let ends = file.statements.iter().map(|statement| statement.span.range().end);
    let starts = file.statements.iter().map(|statement| statement.span.range().start);
    let gaps = std::iter::once(0).chain(ends).zip(starts.chain([text.len()]));
    let gaps = gaps.filter_map(|(from, to)| text.get(from..to));
    gaps.flat_map(|gap| gap.split(|c: char| !(c.is_alphanumeric() || c == '_'))).collect()
}

/// Whether something is a mistake whatever the statements say that can't be read.
fn stands_alone(error: &ModelError, unread: &HashSet<&str>) -> bool {
    match error {
        // One of them may declare it.
        ModelError::UndeclaredName { name, .. } | ModelError::NotACoordinate { name, .. } => !unread.contains(&**name),
        ModelError::UnknownFunction { .. }
        | ModelError::BracketedFunction { .. }
        | ModelError::TimeArgument { .. }
        | ModelError::ForeignDerivative { .. }
        | ModelError::GivenTwice { .. }
        | ModelError::SecondStatement { .. }
        | ModelError::LagrangianBesideEnergies { .. }
        | ModelError::ArgumentCount { .. }
        | ModelError::TooManyIndices { .. }
        | ModelError::Shape { .. }
        | ModelError::Acceleration { .. }
        | ModelError::NumberTooLong { .. }
        | ModelError::IndexReusesName { .. }
        | ModelError::ConditionOrValue { .. }
        | ModelError::NotForIndices { .. }
        | ModelError::UnknownUnit { .. }
        | ModelError::TableAsValue { .. }
        | ModelError::BadIndices { .. } => true,
        // Of the file as a whole, or of values that a statement may still change.
        _ => false,
    }
}
