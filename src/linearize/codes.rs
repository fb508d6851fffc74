//! The codes of models without small oscillations: E0301 and following.

use super::LinearizeError;

impl LinearizeError {
    /// The code of this kind of mistake, `E0012`: it never changes, and
    /// [`explain`](crate::explain::explain) tells more about it.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::MissingValue { .. } => "E0301",
            Self::NotAnEquilibrium { .. } => "E0302",
            Self::NoEquilibrium { .. } => "E0303",
            Self::EquilibriumNotFound { .. } => "E0304",
            Self::NotFinite { .. } => "E0305",
            Self::SingularMass { .. } => "E0306",
            Self::IndefiniteMass { .. } => "E0307",
            Self::Unsupported { .. } => "E0308",
            Self::TimeDependent { .. } => "E0309",
            Self::NoModes { .. } => "E0310",
            Self::TooLarge { .. } => "E0311",
            Self::Budget(exceeded) => exceeded.code(),
            Self::NotCyclic { .. } => "E0312",
            Self::ConstraintsContradict { .. } => "E0313",
            Self::ConstraintBroken { .. } => "E0314",
            Self::ConstraintsSingular { .. } => "E0315",
            Self::FrictionNotSmooth { .. } => "E0316",
            Self::RateNotKept { .. } => "E0317",
            Self::SingularCoordinates { .. } => "E0318",
            Self::ConstraintFlat { .. } => "E0320",
            Self::ForceOfParameters { .. } => "E0321",
        }
    }
}
