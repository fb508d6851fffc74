//! Tensors of inertia that no body has.

use super::principal::Impossible;
use super::{NamedTensor, of_model};
use librate_core::diagnostic::{Diagnostic, at};
use librate_core::mistakes;
use librate_core::model::{Model, Tensor};
use librate_core::order::Order;
use librate_core::precision::decimal;
use librate_core::span::Span;

mistakes! {
/// Something suspicious about a tensor of a model.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
Warning Warning {
    /// Moments that break the triangle inequality, or a negative one.
    #[error("no body can have {}: {why}", described(.name))]
    "W0201" ImpossibleTensor(span) {
        /// The tensor; empty if it has no name.
        name: String,
        /// Where it is used as one, if anywhere.
        rotational: Option<Span>,
        /// Which rule its moments break.
        why: String,
    } => at(*span, "this tensor").and_at(*rotational, "used as one here").with_help(
        "moments about three perpendicular axes are sums of m*(y^2 + z^2), m*(x^2 + z^2) and m*(x^2 + y^2): none is larger than the sum of the two others",
    ),
}
}

fn described(name: &str) -> String {
    if name.is_empty() { "this tensor of inertia".to_owned() } else { format!("the tensor of inertia `{name}`") }
}

impl Warning {
    /// What is to be said of a tensor whose moments are known.
    pub(super) fn of(tensor: &NamedTensor) -> Option<Self> {
        let [a, b, c] = tensor.principal.moments.as_slice() else { return None };
        // A matrix that the file says to be something else may have any eigenvalues.
        if tensor.unit.as_deref().is_some_and(|unit| unit != super::UNIT) {
            return None;
        }
        let [a, b, c] = [a, b, c].map(|moment| decimal(&moment.value, 6).text);
        let why = match tensor.principal.impossible? {
            Impossible::Negative => format!("its smallest principal moment is {a}"),
            Impossible::Triangle => {
                format!("its largest principal moment, {c}, is larger than the sum of the others, {a} and {b}")
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

/// Tensors that no body has, among those that a model uses as one: as omega . I . omega with an angular velocity omega, in
/// `about` or in `steiner`. Any other matrix may be something else. Tensors that have no moments, for want of a value or
/// another reason, are left alone.
///
/// Costs nothing for a model without any.
#[must_use]
pub fn warnings(model: &Model) -> Vec<Diagnostic> {
    let used = |tensor: &&Tensor| tensor.rotational.is_some();
    let named = model.tensors.iter().filter(used);
    // What is written in full stands behind what it may contain.
    let mut unnamed: Vec<&Tensor> = model.unnamed_tensors.iter().collect();
    unnamed.order_by_key(|tensor| tensor.span.end - tensor.span.start);
    let tensors: Vec<&Tensor> = named.chain(unnamed).collect();
    if tensors.is_empty() {
        return Vec::new();
    }
    let mut rotating = model.clone();
    let mut found: Vec<Warning> = Vec::new();
    for tensor in tensors {
        // `steiner(I, m, d)` is no better than its I, of which it has been told.
        let told = |Warning::ImpossibleTensor { rotational, .. }: &Warning| {
            let inner = |used: Span| tensor.span.start <= used.start && used.end <= tensor.span.end;
            tensor.name.is_empty() && rotational.is_some_and(inner)
        };
        if found.iter().any(told) {
            continue;
        }
        // One by one: what can't be told of one says nothing of the others. Few digits do: what counts are signs.
        rotating.tensors = vec![tensor.clone()];
        found.extend(of_model(&rotating, 4).unwrap_or_default().iter().filter_map(Warning::of));
    }
    found.order_by_key(|Warning::ImpossibleTensor { span, .. }| span.start);
    found.iter().map(Diagnostic::from).collect()
}
