//! The codes of contradictions among dimensions: E0201 and following.

use super::DimensionError;

impl DimensionError {
    /// The code of this kind of mistake, `E0012`: it never changes, and
    /// [`explain`](crate::explain::explain) tells more about it.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::UnlikeTerms { .. } => "E0201",
            Self::WrongEnergy { .. } => "E0202",
            Self::NotANumber { .. } => "E0203",
            Self::UnlikeArguments { .. } => "E0204",
            Self::WrongSide { .. } => "E0205",
        }
    }
}
