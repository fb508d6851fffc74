//! What a model may say beside energies of free coordinates at rest. Not every stage covers it.

use super::Model;
use crate::span::Span;
use crate::worded;

worded! {
/// What a model may say beside T and V.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
Feature {
    /// The time occurs.
    Time "contains the time",
    /// A `dissipation` function.
    Dissipation "friction",
    /// A generalised `force`.
    Force "a generalised force",
    /// A `constraint`.
    Constraint "a constraint",
    /// A `constraint` on velocities.
    Rolling "a condition on velocities",
    /// `equilibrium NAME' = …`
    SteadyMotion "given here",
}
/// What it is called where it occurs.
label
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
