//! The codes of driven models: E0701 and following.

use super::FloquetError;

impl FloquetError {
    /// The code of this kind of mistake: it never changes, and [`explain`](crate::explain::explain) tells more
    /// about it.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::NoTime { .. } => "E0701",
            Self::NoPeriod { .. } => "E0702",
            Self::NotAPeriod { .. } => "E0703",
            Self::PeriodNotPositive { .. } => "E0704",
            Self::EquilibriumMoves { .. } => "E0705",
            Self::NoPeriodicMotion { .. } => "E0706",
            Self::Singular { .. } => "E0707",
            Self::NotDefined { .. } => "E0708",
            Self::Unsupported { .. } => "E0709",
            Self::TooLarge { .. } => "E0710",
            Self::TooLong { .. } => "E0711",
            Self::Linearize(error) => error.code(),
        }
    }
}
