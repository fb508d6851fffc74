//! Why there is no study, or no answer to one.

use crate::source::quoted;
use librate_core::diagnostic::Diagnostic;
use librate_core::linearize::LinearizeError;

/// A study that can't be made, or a request that does not fit it. What is wrong with a single set
/// of parameters is its [`Outcome`](super::Outcome) instead.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// No parameter was named, so that all sets would be the same.
    #[error("a study needs a parameter that varies")]
    NothingVaries {},
    /// A name that is no parameter of the model.
    #[error("the model has no parameter `{name}`")]
    UnknownParameter {
        /// The name.
        name: String,
        /// The parameter that may have been meant.
        nearest: Option<String>,
    },
    /// A parameter named twice, by itself or with its family.
    #[error("the parameter `{name}` is named twice")]
    NamedTwice {
        /// The parameter.
        name: String,
    },
    /// A parameter that decides how many coordinates or terms there are.
    #[error("`{name}` sets the range of a family and can't vary: the matrices would change size")]
    SetsRange {
        /// The parameter.
        name: String,
    },
    /// A parameter that the model defines from others, which it follows.
    #[error("`{name}` is defined by other parameters and varies with them: {}", quoted(.on))]
    Dependent {
        /// The parameter.
        name: String,
        /// The parameters that it is defined from.
        on: Vec<String>,
    },
    /// The model can't be linearized.
    #[error(transparent)]
    Linearize {
        /// Why.
        #[from]
        error: LinearizeError,
    },
    /// Values that are not whole sets.
    #[error("{found} values are not a whole number of sets of {width}")]
    Length {
        /// How many values were given.
        found: usize,
        /// How many a set has.
        width: usize,
    },
}

impl From<&StudyError> for Diagnostic {
    fn from(error: &StudyError) -> Self {
        let message = Self::global(error.to_string());
        match error {
            StudyError::Linearize { error } => Self::from(error),
            StudyError::UnknownParameter { nearest: Some(nearest), .. } => {
                message.with_help(format!("did you mean `{nearest}`?"))
            }
            StudyError::Dependent { name, .. } => message.with_help(format!(
                "vary those instead, or set `{name}` to a number when the model is elaborated: then \
                 it is a parameter of its own"
            )),
            StudyError::SetsRange { .. } => message.with_help("make a separate study for each of its values"),
            StudyError::NothingVaries {}
            | StudyError::UnknownParameter { .. }
            | StudyError::NamedTwice { .. }
            | StudyError::Length { .. } => message,
        }
    }
}
