//! The codes of motions without a period: E0501 and following.

use super::PeriodError;

impl PeriodError {
    /// The code of this kind of mistake, `E0012`: it never changes, and
    /// [`explain`](crate::explain::explain) tells more about it.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Budget(exceeded) => exceeded.code(),
            Self::NotOneCoordinate { .. } => "E0501",
            Self::Unsupported { .. } => "E0502",
            Self::NotQuadratic { .. } => "E0503",
            Self::BadRequest { .. } => "E0504",
            Self::BeyondBarrier { .. } => "E0505",
            Self::AtBarrier { .. } => "E0506",
            Self::BelowEquilibrium { .. } => "E0507",
            Self::Maximum { .. } => "E0508",
            Self::NotPeriodic { .. } => "E0509",
            Self::NotSmooth { .. } => "E0510",
            Self::NegativeMass { .. } => "E0511",
            Self::Undecided { .. } => "E0512",
            Self::NoInertia { .. } => "E0513",
            Self::TooLong { .. } => "E0514",
        }
    }
}
