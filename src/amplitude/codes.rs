//! The codes of models whose frequencies have no leading change with the amplitude: E0801 and following.

use super::AmplitudeError;

impl AmplitudeError {
    /// The code of this kind of mistake, `E0012`: it never changes, and
    /// [`explain`](crate::explain::explain) tells more about it.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Unsupported { .. } => "E0801",
            Self::Gyroscopic { .. } => "E0802",
            Self::NotQuadratic { .. } => "E0803",
            Self::Unstable { .. } => "E0804",
            Self::NotSmooth => "E0805",
            Self::TooLarge { .. } => "E0806",
            Self::Linearize(error) => error.code(),
        }
    }
}
