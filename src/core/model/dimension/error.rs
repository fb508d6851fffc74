//! Contradictions among dimensions.

use super::{Dimension, names};
use crate::diagnostic::{Diagnostic, at};
use crate::mistakes;
use crate::span::Span;

/// A name without a unit, and what the file says elsewhere that it must be.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Inferred {
    /// The name.
    pub name: String,
    /// What it was found to be.
    pub dimension: Dimension,
    /// What told.
    pub span: Span,
}

mistakes! {
/// A contradiction between the dimensions of quantities.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
Error DimensionError {
    /// Terms of a sum that are different kinds of quantity.
    #[error("the dimensions of a sum differ: {found} can't be added to {other}")]
    "E0201" UnlikeTerms(span) {
        /// The odd term.
        found: Dimension,
        /// What the other terms are.
        other: Dimension,
        /// One of them.
        other_span: Span,
        /// A name in it whose dimension was inferred.
        inferred: Option<Inferred>,
    } => with_inferred(
            at(*span, with_unit(found))
                .with_secondary(*other_span, with_unit(other)),
            inferred.as_ref(),
        )
        .with_help(names::remedy(found, other)),

    /// A term of an energy that is none.
    #[error("the dimensions of `{what}` don't fit: it is {wanted}, but this is {found}")]
    "E0202" WrongEnergy(span) {
        /// `V`, `dissipation`, …
        what: &'static str,
        /// What the term is.
        found: Dimension,
        /// What it has to be.
        wanted: Dimension,
        /// The statement's first word.
        statement: Span,
        /// A name in it whose dimension was inferred.
        inferred: Option<Inferred>,
    } => with_inferred(
            at(*span, with_unit(found)).with_secondary(
                *statement,
                if wanted.unit() == wanted.to_string() {
                    with_unit(wanted)
                } else {
                    format!("`{what}` is {}", with_unit(wanted))
                },
            ),
            inferred.as_ref(),
        )
        .with_help(names::remedy(found, wanted)),

    /// A function of pure numbers with something else in it, or an exponent that is no number.
    #[error("{what} must be without a dimension, but is {found}")]
    "E0203" NotANumber(span) {
        /// The argument of which function, or the exponent.
        what: String,
        /// What it is.
        found: Dimension,
        /// A name in it whose dimension was inferred.
        inferred: Option<Inferred>,
    } => with_inferred(
            at(*span, with_unit(found)),
            inferred.as_ref(),
        )
        .with_help(names::remedy(found, &Dimension::default())),

    /// Arguments of a function that must be alike and are not.
    #[error("the dimensions of {what} differ: {found} beside {other}")]
    "E0204" UnlikeArguments(span) {
        /// The function, or the two sides of a constraint.
        what: String,
        /// What one is.
        found: Dimension,
        /// What the other is.
        other: Dimension,
        /// Where it stands.
        other_span: Span,
        /// A name in it whose dimension was inferred.
        inferred: Option<Inferred>,
    } => with_inferred(
            at(*span, with_unit(found))
                .with_secondary(*other_span, with_unit(other)),
            inferred.as_ref(),
        )
        .with_help(names::remedy(found, other)),

    /// A right side that is not what its name is declared to be.
    #[error("the dimensions don't fit: `{name}` is {declared}, but its {side} is {found}")]
    "E0205" WrongSide(span) {
        /// The name.
        name: String,
        /// What it is.
        declared: Dimension,
        /// Where that is said.
        declared_span: Span,
        /// `right side`, `guess`, …
        side: &'static str,
        /// What the right side is.
        found: Dimension,
        /// A name in it whose dimension was inferred.
        inferred: Option<Inferred>,
    } => with_inferred(
            at(*span, with_unit(found)).with_secondary(
                *declared_span,
                format!("`{name}` is {}", with_unit(declared)),
            ),
            inferred.as_ref(),
        )
        .with_help(names::remedy(found, declared)),
}
}

/// `a force (N)`, without repeating the unit where there is no word.
fn with_unit(dimension: &Dimension) -> String {
    let words = dimension.to_string();
    if dimension.is_number() || words.ends_with(&dimension.unit()) {
        return words;
    }
    format!("{words} ({})", dimension.unit())
}

impl From<&Box<DimensionError>> for Diagnostic {
    fn from(error: &Box<DimensionError>) -> Self {
        Self::from(&**error)
    }
}

fn with_inferred(diagnostic: Diagnostic, inferred: Option<&Inferred>) -> Diagnostic {
    match inferred {
        Some(inferred) => diagnostic.with_secondary(
            inferred.span,
            format!("this makes `{}` {}", inferred.name, with_unit(&inferred.dimension)),
        ),
        None => diagnostic,
    }
}
