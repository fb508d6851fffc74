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

/// A number in the text where a quantity with a dimension belongs.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Unnamed {
    /// As it is written.
    pub number: String,
    /// Its declaration as a parameter.
    pub declaration: String,
}

impl Unnamed {
    fn help(&self) -> String {
        format!("give {} a name with a unit: `{}`", self.number, self.declaration)
    }
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
        /// The declaration of one of them that is a number without a name.
        unnamed: Option<Box<Unnamed>>,
        /// A name in it whose dimension was inferred.
        inferred: Option<Inferred>,
    } => unlike(*span, [found, other], Some((*other_span, with_unit(other))), inferred.as_ref())
        .or_help(unnamed.as_deref().map(Unnamed::help)),

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
    } => {
        let is_unit = wanted.unit() == wanted.to_string();
        let label = if is_unit { with_unit(wanted) } else { format!("`{what}` is {}", with_unit(wanted)) };
        unlike(*span, [found, wanted], Some((*statement, label)), inferred.as_ref())
    },

    /// A function of pure numbers with something else in it, or an exponent that is no number.
    #[error("{what} must be dimensionless, but is {found}")]
    "E0203" NotANumber(span) {
        /// The argument of which function, or the exponent.
        what: String,
        /// What it is.
        found: Dimension,
        /// A name in it whose dimension was inferred.
        inferred: Option<Inferred>,
    } => unlike(*span, [found, &Dimension::default()], None, inferred.as_ref()),

    /// Arguments of a function that must be alike and are not.
    #[error("the dimensions of {what} differ: {found} and {other}")]
    "E0204" UnlikeArguments(span) {
        /// The function, or the two sides of a constraint.
        what: String,
        /// What one is.
        found: Dimension,
        /// What the other is.
        other: Dimension,
        /// Where it stands.
        other_span: Span,
        /// The declaration of one of them that is a number without a name.
        unnamed: Option<Box<Unnamed>>,
        /// A name in it whose dimension was inferred.
        inferred: Option<Inferred>,
    } => unlike(*span, [found, other], Some((*other_span, with_unit(other))), inferred.as_ref())
        .or_help(unnamed.as_deref().map(Unnamed::help)),

    /// A right side that is not what its name is declared to be.
    #[error("the dimensions don't fit: `{name}` is {}, but its {side} is {found}", role(.name, .declared))]
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
    } => {
        let unit = if is_moment(name, declared) { "a moment (N*m)".to_owned() } else { with_unit(declared) };
        let label = format!("`{name}` is {unit}");
        unlike(*span, [found, declared], Some((*declared_span, label)), inferred.as_ref())
    },
}
}

/// Whether a name stands for what turns an angle.
fn is_moment(name: &str, dimension: &Dimension) -> bool {
    name.starts_with("force ") && names::symbol(dimension) == Some("J")
}

/// What a name is.
fn role(name: &str, dimension: &Dimension) -> String {
    if is_moment(name, dimension) { "a moment".to_owned() } else { dimension.to_string() }
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

/// What is shown of something that is not what it has to be: beside it what tells what it has to be, and the name whose dimension was
/// inferred.
fn unlike(
    span: Span,
    [found, wanted]: [&Dimension; 2],
    beside: Option<(Span, String)>,
    inferred: Option<&Inferred>,
) -> Diagnostic {
    let this = |own: &Inferred| (own.span, format!("this makes `{}` {}", own.name, with_unit(&own.dimension)));
    let labels = beside.into_iter().chain(inferred.map(this));
    let shown = labels.fold(at(span, with_unit(found)), |shown, (span, label)| shown.with_secondary(span, label));
    shown.with_help(names::remedy(found, wanted))
}
