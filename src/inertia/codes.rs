//! The codes of what gives no tensor of inertia: E0401 and following.

use super::InertiaError;

impl InertiaError {
    /// The code of this kind of mistake, `E0012`: it never changes, and
    /// [`explain`](crate::explain::explain) tells more about it.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::NoTensor { .. } => "E0401",
            Self::MissingValue { .. } => "E0402",
            Self::NotANumberEntry { .. } => "E0403",
            Self::BadTable { .. } => "E0404",
            Self::MissingColumn { .. } => "E0405",
            Self::ColumnTwice { .. } => "E0406",
            Self::NotANumber { .. } => "E0407",
            Self::NegativeMass { .. } => "E0408",
            Self::NoMass { .. } => "E0409",
            Self::NotAMesh { .. } => "E0410",
            Self::WrongLength { .. } => "E0411",
            Self::CutOff { .. } => "E0412",
            Self::BadTriangle { .. } => "E0413",
            Self::NotFinite { .. } => "E0414",
            Self::OpenMesh { .. } => "E0415",
            Self::TurnedTriangle { .. } => "E0416",
            Self::NotAManifold { .. } => "E0417",
            Self::InsideOut { .. } => "E0418",
            Self::NoVolume {} => "E0419",
            Self::OutOfRange {} => "E0420",
            Self::BadAmount { .. } => "E0421",
            Self::NoMoments { .. } => "E0422",
        }
    }
}
