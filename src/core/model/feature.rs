//! What a model may say beside energies of free coordinates at rest. Not every stage covers it.

use super::Model;
use crate::span::Span;

/// What a model may say beside T and V.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// The time occurs.
    Time,
    /// A `dissipation` function.
    Dissipation,
    /// A generalised `force`.
    Force,
    /// A `constraint`.
    Constraint,
    /// A `constraint` on velocities.
    Rolling,
    /// `equilibrium NAME' = …`
    SteadyMotion,
}

impl Feature {
    /// What it is called where it occurs.
    pub fn label(self) -> &'static str {
        match self {
            Self::Time => "contains the time",
            Self::Dissipation => "friction",
            Self::Force => "a force that no energy gives",
            Self::Constraint => "a constraint",
            Self::Rolling => "a condition on velocities",
            Self::SteadyMotion => "given here",
        }
    }
}

impl Model {
    /// What the model says beside T and V, and where it does so first.
    pub fn features(&self) -> impl Iterator<Item = (Feature, Span)> {
        let rate = self.rates.iter().flatten().map(|given| given.span).next();
        let constraint = self.constraints.first().map(|own| own.span);
        let all = [
            (Feature::Time, self.time_dependent),
            (Feature::Dissipation, self.dissipation),
            (Feature::Force, self.force),
            (Feature::Constraint, constraint),
            (Feature::Rolling, self.rolling.first().map(|own| own.span)),
            (Feature::SteadyMotion, rate),
        ];
        all.into_iter().filter_map(|(feature, span)| Some((feature, span?)))
    }
}
