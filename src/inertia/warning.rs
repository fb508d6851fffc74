//! Tensors of inertia that no body has.

use super::principal::Impossible;
use super::{NamedTensor, of_model};
use crate::diagnostic::Diagnostic;
use crate::model::Model;
use crate::precision::decimal;
use crate::span::Span;

/// Something suspicious about a tensor of a model.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// Moments that break the triangle inequality, or a negative one.
    #[error("no body has the tensor of inertia `{name}`: {why}")]
    ImpossibleTensor {
        /// The tensor.
        name: String,
        /// Where it stands.
        span: Span,
        /// Where it is used as omega . I . omega, if anywhere.
        rotational: Option<Span>,
        /// Which rule its moments break.
        why: String,
    },
}

impl Warning {
    /// The code of this kind, `W0201`.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::ImpossibleTensor { .. } => "W0201",
        }
    }

    /// What is to be said of a tensor whose moments are known.
    pub(super) fn of(tensor: &NamedTensor) -> Option<Self> {
        let [a, b, c] = tensor.principal.moments.as_slice() else {
            return None;
        };
        // A matrix that the file says to be something else may have any eigenvalues.
        if tensor
            .unit
            .as_deref()
            .is_some_and(|unit| unit != super::UNIT)
        {
            return None;
        }
        let [a, b, c] = [a, b, c].map(|moment| decimal(&moment.value, 6).text);
        let why = match tensor.principal.impossible? {
            Impossible::Negative => format!("its smallest principal moment is {a}"),
            Impossible::Triangle => {
                format!(
                    "its largest principal moment, {c}, is more than the sum of the others, {a} and {b}"
                )
            }
        };
        Some(Self::ImpossibleTensor {
            name: tensor.name.clone(),
            span: tensor.span,
            rotational: tensor.rotational,
            why,
        })
    }
}

impl From<&Warning> for Diagnostic {
    fn from(warning: &Warning) -> Self {
        let Warning::ImpossibleTensor {
            span, rotational, ..
        } = warning;
        let told =
            Self::warning(warning.to_string(), *span, "this tensor").with_code(warning.code());
        let told = match rotational {
            Some(rotational) => told.with_secondary(*rotational, "used as one here"),
            None => told,
        };
        told.with_help(
            "moments about three perpendicular axes are sums of m*(y^2 + z^2), m*(x^2 + z^2) and m*(x^2 + y^2): none is more than the two others together",
        )
    }
}

/// Tensors that no body has, among those that a model uses as omega . I . omega with an angular velocity omega: any other
/// matrix may be something else. Tensors that have no moments, for want of a value or another reason, are left alone.
///
/// Costs nothing for a model without such an energy.
#[must_use]
pub fn warnings(model: &Model) -> Vec<Warning> {
    if model
        .tensors
        .iter()
        .all(|tensor| tensor.rotational.is_none())
    {
        return Vec::new();
    }
    let mut rotating = model.clone();
    rotating
        .tensors
        .retain(|tensor| tensor.rotational.is_some());
    // Few digits do: what counts are signs.
    let found = of_model(&rotating, 4).unwrap_or_default();
    found.iter().filter_map(Warning::of).collect()
}
