//! The code of each kind of mistake.

use super::MotionError;

impl MotionError {
    /// The code of this kind of mistake; it never changes its meaning.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::BadStart { .. } => "E0601",
            Self::NotACoordinate { .. } => "E0602",
            Self::NoSuchMode { .. } => "E0603",
            Self::BadAmplitude { .. } => "E0604",
            Self::BadTimes { .. } => "E0605",
            Self::OffConstraints { .. } => "E0606",
            Self::Singular { .. } => "E0607",
            Self::TooLarge { .. } => "E0608",
            Self::TooManyNumbers { .. } => "E0609",
            Self::TooLong { .. } => "E0610",
            Self::NotProved { .. } => "E0611",
            Self::OpenStart => "E0612",
            Self::TooLargeToProve { .. } => "E0613",
            Self::Stuck { .. } => "E0614",
            Self::Linearize(error) => error.code(),
        }
    }
}
