//! What is not as expected, to be read by the one who expected it.

use std::fmt::{self, Display, Formatter};

/// How a derivation differs from what was expected. Places in matrices count from 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Mismatch {
    /// An expected text is no expression of the model language, or none that can be compared.
    #[error("{part}\n  can't be read: {text}\n  {message}")]
    Unreadable {
        /// The part, with its place.
        part: String,
        /// The text.
        text: String,
        /// What is wrong with it.
        message: String,
    },
    /// The derivation has no such part.
    #[error("{part}\n  is not there: {reason}")]
    NotThere {
        /// The part.
        part: &'static str,
        /// Why.
        reason: String,
    },
    /// The two are not equal.
    #[error("{part}\n  expected: {expected}\n  found:    {found}")]
    Differs {
        /// The part, with its place.
        part: String,
        /// What was expected, as it was written.
        expected: String,
        /// What the derivation has, in the model language.
        found: String,
    },
}

/// All differences between a derivation and what was expected of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mismatches(pub Vec<Mismatch>);

impl Display for Mismatches {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("the derivation is not what was expected\n")?;
        for mismatch in &self.0 {
            write!(f, "\n{mismatch}\n")?;
        }
        Ok(())
    }
}

impl std::error::Error for Mismatches {}
