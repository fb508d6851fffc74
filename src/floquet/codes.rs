//! The codes of driven models: E0401 and following.

use super::FloquetError;

impl FloquetError {
    /// The code of this kind of mistake: it never changes, and [`explain`](crate::explain::explain) tells more
    /// about it.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::NoTime { .. } => "E0401",
            Self::NoPeriod { .. } => "E0402",
            Self::NotAPeriod { .. } => "E0403",
            Self::PeriodNotPositive { .. } => "E0404",
            Self::EquilibriumMoves { .. } => "E0405",
            Self::NoPeriodicMotion { .. } => "E0406",
            Self::Singular { .. } => "E0407",
            Self::NotDefined { .. } => "E0408",
            Self::Unsupported { .. } => "E0409",
            Self::TooLarge { .. } => "E0410",
            Self::Linearize(error) => error.code(),
        }
    }
}
