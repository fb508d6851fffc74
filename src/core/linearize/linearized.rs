//! What a model about its equilibrium tells of itself.

use super::constrained::Tangent;
use super::equilibrium::{Equilibrium, Origin};
use super::massless::Massless;
use super::rolling::Rolling;
use super::{
    Feature, Flow, LinearizeError, Linearized, Structure, SymbolicMatrices, Units, ZeroMode, constant, exact, rational,
    symbolic, velocity, zero,
};
use crate::model::{Given, Model};
use crate::precision::{Ball, Integers, has_pivots};

impl Linearized {
    /// The model.
    #[must_use]
    pub fn model(&self) -> &Model {
        self.shown.as_ref().map_or(&self.model, |shown| &shown.0)
    }

    /// What matrices, forces and motions are measured in where numbers in SI would leave the range of doubles; `None` where it is SI.
    /// The equilibrium is in SI always.
    #[must_use]
    pub fn units(&self) -> Option<&Units> {
        self.units.as_ref()
    }

    /// The model in [`Linearized::units`], with rates and multipliers put in.
    pub fn measured_model(&self) -> &Model {
        &self.model
    }

    /// The equilibrium in [`Linearized::units`], multipliers behind the coordinates.
    pub fn measured_equilibrium(&self) -> &[Ball] {
        &self.equilibrium.values
    }

    /// The multipliers of constraints by their names, at the equilibrium.
    pub(crate) fn multipliers(&self) -> impl Iterator<Item = (String, Ball)> {
        let visible = self.model().coordinates.len();
        let names = self.model.coordinates.names();
        let values = self.equilibrium.values.iter().enumerate();
        let length = |at| self.units.as_ref().map_or(0, |units| units.length(at));
        names.zip(values.map(move |(at, value)| value.scale_far(length(at)))).skip(visible)
    }

    /// The equilibrium.
    #[must_use]
    pub fn equilibrium(&self) -> &Equilibrium {
        self.shown.as_ref().map_or(&self.equilibrium, |shown| &shown.1)
    }

    /// The number of coordinates.
    #[must_use]
    pub fn coordinates(&self) -> usize {
        self.model().coordinates.len()
    }

    /// What conditions on velocities leave of the model, where there are such.
    pub(super) fn rolling(&self) -> Option<&Rolling> {
        self.rolled_numbers().map(|(rolling, _)| rolling)
    }

    pub(super) fn rolled_numbers(&self) -> Option<&(Rolling, velocity::Numbers<Ball>)> {
        self.constrained.as_ref().and_then(|own| own.rolling.as_ref())
    }

    /// For each condition on velocities that can't be integrated, the coordinate that moves along the family of equilibria
    /// which it leaves: a zero exponent each beside those of the matrices.
    #[must_use]
    pub fn rolled(&self) -> &[usize] {
        self.rolling().map_or(&[], |own| &own.symbolic.moved)
    }

    /// How the velocities of coordinates that follow others under conditions come of places; see [`Rolling::drift`].
    pub(crate) fn drift(&self) -> Option<Vec<Vec<Ball>>> {
        self.rolling().filter(|own| own.drifts())?.drift(&self.model, &self.equilibrium.values)
    }

    /// Whether such coordinates move away as t² or faster; `None` where that is not decided.
    pub(crate) fn follows_away(&self) -> Option<bool> {
        let rolling = self.rolling().filter(|own| own.drifts());
        rolling.map_or(Some(false), |own| rational::follows_away(self, &own.symbolic))
    }

    /// The coordinates that others follow under conditions, and these.
    pub(crate) fn following(&self) -> Option<&Tangent<Ball>> {
        self.constrained.as_ref().map(|own| &own.tangent)
    }

    /// The direction of each of these families, in all coordinates.
    pub(crate) fn families(&self) -> &[Vec<Ball>] {
        self.constrained.as_ref().map_or(&[], |own| &own.families)
    }

    /// Whether conditions on velocities leave exponents in pairs ±s, though the matrices are not those of a model without
    /// friction.
    pub(crate) fn runs_backward(&self) -> bool {
        self.rolling().is_some_and(Rolling::runs_backward)
    }

    /// The number of degrees of freedom, which the matrices have as many rows as: that of the
    /// coordinates, less the number of independent constraints and of massless directions.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.tangents().last().map_or(self.model.coordinates.len(), |tangent| tangent.free.len())
    }

    /// The motions that constraints allow, and of these the ones that massless coordinates follow.
    pub(super) fn tangents(&self) -> impl DoubleEndedIterator<Item = &Tangent<Ball>> {
        let constrained = self.constrained.as_ref().map(|own| &own.tangent);
        constrained.into_iter().chain(self.massless().map(|own| &own.tangent))
    }

    pub(super) fn massless(&self) -> Option<&Massless> {
        self.massless.as_ref()?.as_ref().as_ref().ok()
    }

    /// The number of directions without inertia that follow the others: there are as many modes fewer.
    #[must_use]
    pub fn massless_directions(&self) -> usize {
        self.massless().map_or(0, |own| own.following.len()) + self.flow().map_or(0, Flow::following)
    }

    /// The number of modes, those of equations of first order counted as pairs: that of the coordinates, less the constraints, the
    /// directions that follow the others, and one of each two that gyroscopic forces alone hold.
    #[must_use]
    pub fn mode_count(&self) -> usize {
        let undamped = self.structure == Structure::Gyroscopic;
        let less = |flow: &Flow| flow.following() + if undamped { flow.pairs() } else { 0 };
        self.dimension() - self.flow().map_or(0, less)
    }

    /// Whether some equations with friction are of first order, so that how many entries there are is seen from the exponents alone.
    #[must_use]
    pub fn is_first_order(&self) -> bool {
        self.structure == Structure::Damped && (self.flow.is_some() || self.massless.is_some())
    }

    /// Refuses coordinates without inertia, for what has to have accelerations.
    ///
    /// # Errors
    /// [`LinearizeError::Unsupported`] with the first of them.
    pub fn check_inertia(&self) -> Result<(), LinearizeError> {
        let following = self.massless().and_then(|own| own.following.first());
        let following = following.map(|at| self.constrained.as_ref().map_or(*at, |own| own.tangent.free[*at]));
        let flow = || self.flow().filter(|_| self.rolling().is_none());
        let flowing = || flow()?.places.first().and_then(|at| self.free_coordinates().get(*at).copied());
        following.or_else(flowing).map_or(Ok(()), |at| {
            let span = self.model().coordinates.at(at).span;
            Err(LinearizeError::Unsupported { feature: Feature::Massless, span })
        })
    }

    /// The coordinates without inertia that friction or gyroscopic forces hold.
    pub(crate) fn flow(&self) -> Option<&Flow> {
        self.flow.as_deref()
    }

    /// Why there are no modes, where directions without inertia do not follow the others.
    pub(crate) fn massless_error(&self) -> Option<&LinearizeError> {
        self.massless.as_ref()?.as_ref().as_ref().err()
    }

    /// Whether coordinates follow others, under constraints or without inertia. The matrices are then those of the
    /// coordinates that the others follow; [`Linearized::embed`] makes motions of all of them.
    #[must_use]
    pub fn is_reduced(&self) -> bool {
        self.is_constrained() || self.massless().is_some()
    }

    /// Whether constraints tie coordinates to each other.
    #[must_use]
    pub fn is_constrained(&self) -> bool {
        let own = self.constrained.as_ref();
        own.is_some_and(|own| !own.bound.is_empty() || own.rolling.is_some())
    }

    /// The coordinates that the others follow, by number: all of them where none does.
    #[must_use]
    pub fn free_coordinates(&self) -> Vec<usize> {
        let all = (0..self.coordinates()).collect();
        self.tangents().fold(all, |left, tangent| tangent.free.iter().filter_map(|at| left.get(*at).copied()).collect())
    }

    /// The number of independent constraints.
    #[must_use]
    pub fn constraints(&self) -> usize {
        let own = self.constrained.as_ref();
        let of = |rolling: &Rolling| rolling.symbolic.bound.len() + rolling.symbolic.first.len();
        own.map_or(0, |own| own.rolling.as_ref().map_or(own.bound.len(), |(rolling, _)| of(rolling)))
    }

    /// The constraints that follow from the others, by their number in the model: nothing would change
    /// without them.
    #[must_use]
    pub fn dependent_constraints(&self) -> &[usize] {
        self.constrained.as_ref().map_or(&[], |own| &own.dependent)
    }

    /// What kind of equations of motion the model has near the equilibrium.
    #[must_use]
    pub fn structure(&self) -> Structure {
        self.structure
    }

    /// The same where some coordinates, for which the file gives nothing, are 0.
    pub(crate) fn with_zeros(mut self, coordinates: &[usize]) -> Self {
        for i in coordinates {
            self.equilibrium.origins[*i] = Origin::Zero;
        }
        self
    }

    /// The rates of a steady motion in SI, one a coordinate, 0 for those that rest.
    #[must_use]
    pub fn rates(&self) -> Vec<Ball> {
        let model = self.model();
        let rate = |given: Option<Given>| constant(&model.pool, given?.value?);
        model.rates.iter().map(|given| rate(given).unwrap_or(Ball::ZERO)).collect()
    }

    /// Whether friction at rest has no share in any coordinate that a motion moves, exactly.
    pub(crate) fn is_free_of_friction_at_rest(&self, motion: &[Ball]) -> bool {
        let n = motion.len();
        self.circulatory()
            .is_none_or(|matrix| (0..n).all(|j| motion[j].is_zero() || (0..n).all(|i| matrix[i + n * j].is_zero())))
    }

    /// M, G + C and K + N exactly, dense, in units of roots in which they are rational or combinations of a few square roots;
    /// `None` where there are no such units for an entry, or there are too many.
    #[must_use]
    pub fn integers(&self) -> Option<Integers> {
        self.integers_with(self.flow())
    }

    /// The same with a regular leading matrix where friction holds what has no inertia.
    pub(crate) fn integers_with(&self, flow: Option<&Flow>) -> Option<Integers> {
        let plain = !self.is_reduced() && flow.is_none();
        let direct = plain.then(|| exact::integers(self)).flatten();
        match direct {
            Some(found) if found.roots.is_empty() => Some(found),
            found => rational::integers(self, flow).or(found),
        }
    }

    /// A motion of all coordinates, from a motion of those that the others follow whose components are
    /// off by up to `error`; and what its components are off by. The same where none follows others.
    #[must_use]
    pub fn embed(&self, motion: &[f64], error: f64) -> (Vec<f64>, f64) {
        let own = (motion.to_vec(), error);
        self.tangents().rev().fold(own, |(motion, error), tangent| tangent.embed(&motion, error))
    }

    /// The vectors a whose squares a aᵀ the stiffness matrix is the sum of, as entries with their places; `None` where there are none, and
    /// where coordinates follow others.
    #[must_use]
    pub fn squares(&self) -> Option<Vec<Vec<(usize, Ball)>>> {
        if self.is_reduced() { None } else { self.assembly.squares(&self.equilibrium.values, &self.values) }
    }

    /// M and K as expressions.
    #[must_use]
    pub fn symbolic(&self) -> SymbolicMatrices {
        symbolic::matrices(&self.model, &self.assembly, &self.equilibrium)
    }

    /// Motions that are proved to cost no energy: independent vectors of the kernel of K.
    #[must_use]
    pub fn zero_modes(&self) -> Vec<ZeroMode> {
        self.zero_modes_with(true)
    }

    /// Under conditions on velocities: directions of the coordinates that the others follow which no force of a displacement acts
    /// on, whatever the values of the parameters are.
    #[must_use]
    pub fn unheld(&self) -> Option<Vec<Vec<Ball>>> {
        self.rolling().map(Rolling::unheld)
    }

    /// Which of some zero modes no force acts on that goes with velocities, whatever the parameters are.
    pub(crate) fn unmoved(&self, modes: &[ZeroMode]) -> Vec<bool> {
        let pool = &mut self.model.pool.clone();
        modes.iter().map(|mode| self.rolling().is_none() && mode.is_unmoved(&self.assembly, pool)).collect()
    }

    /// Those that symmetries and loose parts explain, or all.
    pub(crate) fn zero_modes_with(&self, others: bool) -> Vec<ZeroMode> {
        if let Some(rolling) = self.rolling() {
            return match rational::unheld(self) {
                Some(vectors) => vectors.into_iter().map(ZeroMode::of_exact).collect(),
                None => rolling.unheld().into_iter().map(ZeroMode::of_no_force).collect(),
            };
        }
        let modes = zero::zero_modes(self, others);
        if !self.is_reduced() {
            return modes;
        }
        let restricted =
            |vector: &[Ball]| self.tangents().fold(vector.to_vec(), |vector, tangent| tangent.restrict(&vector));
        modes.into_iter().map(|mode| mode.mapped(restricted)).collect()
    }

    /// A point beside the equilibrium.
    pub(super) fn nearby(&self) -> Vec<Ball> {
        let shift = |(i, value): (usize, &Ball)| {
            let step = 1e-2 * (1.0 + 0.1 * (i % 7) as f64);
            *value + Ball::from(step * value.mid_f64().abs().max(1.0))
        };
        self.equilibrium.values.iter().enumerate().map(shift).collect()
    }

    /// Whether every motion is proved to have inertia beside the equilibrium: then it is the coordinates that are
    /// singular there.
    pub(crate) fn has_inertia_nearby(&self) -> bool {
        let at = self.nearby();
        // Multipliers, which have no inertia, stand behind the coordinates.
        let (n, all) = (self.coordinates(), self.model.coordinates.len());
        let mass = self.assembly.mass(&at, &self.values);
        let rows = (0..n).map(|i| (0..n).map(|j| mass[i + all * j]).collect()).collect();
        has_pivots(rows, Ball::is_positive, ())
    }

    /// The first term whose numbers at the equilibrium are not finite, as an error.
    #[must_use]
    pub fn not_finite(&self) -> Option<LinearizeError> {
        let what = "a second derivative of the energies";
        self.assembly.not_finite(&self.model, &self.equilibrium.values, &self.values, what)
    }
}
