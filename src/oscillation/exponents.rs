//! Modes of models with gyroscopic forces or friction.

use super::NormalModes;
use crate::linearize::{Feature, LinearizeError, Linearized};
use crate::modes::Options;

pub(super) fn normal_modes(
    linearized: &Linearized,
    _options: &Options,
) -> Result<NormalModes, LinearizeError> {
    Err(LinearizeError::Unsupported {
        feature: Feature::Gyroscopic,
        span: linearized.model().coordinates.first().map(|own| own.span).unwrap_or_default(),
    })
}
