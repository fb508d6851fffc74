//! The codes of mistakes in what a model says: E0101 and following.

use super::ModelError;

impl ModelError {
    /// The code of this kind of mistake, `E0012`: it never changes, and
    /// [`explain`](crate::explain::explain) tells more about it.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::UndeclaredName { .. } => "E0101",
            Self::UnknownFunction { .. } => "E0102",
            Self::GivenTwice { .. } => "E0103",
            Self::SecondStatement { .. } => "E0104",
            Self::LagrangianBesideEnergies { .. } => "E0105",
            Self::MissingKinetic { .. } => "E0106",
            Self::NoCoordinates { .. } => "E0107",
            Self::RecursiveLet { .. } => "E0108",
            Self::IndexOutOfRange { .. } => "E0109",
            Self::NotAnInteger { .. } => "E0110",
            Self::TooManyIndices { .. } => "E0111",
            Self::Shape { .. } => "E0112",
            Self::ArgumentCount { .. } => "E0113",
            Self::ListLength { .. } => "E0114",
            Self::Acceleration { .. } => "E0115",
            Self::NotConstant { .. } => "E0116",
            Self::MissingValue { .. } => "E0117",
            Self::UnknownSetting { .. } => "E0118",
            Self::BadSetting { .. } => "E0119",
            Self::MissingTable { .. } => "E0120",
            Self::BadTable { .. } => "E0121",
            Self::UnknownColumn { .. } => "E0122",
            Self::TooLarge { .. } => "E0123",
            Self::UndecidedComparison { .. } => "E0124",
            Self::IndexReusesName { .. } => "E0125",
            Self::ConditionOrValue { .. } => "E0126",
            Self::NotForIndices { .. } => "E0127",
            Self::Undefined { .. } => "E0128",
            Self::UnknownUnit { .. } => "E0129",
            Self::TableAsValue { .. } => "E0130",
            Self::NotACoordinate { .. } => "E0131",
            Self::BadIndices { .. } => "E0132",
            Self::ConstraintOnVelocities { .. } => "E0133",
            Self::NumberTooLong { .. } => "E0134",
            Self::Budget(exceeded) => exceeded.code(),
            // Never told to anybody.
            Self::FollowOn {} => "E0100",
            Self::Dimension(error) => error.code(),
        }
    }
}
