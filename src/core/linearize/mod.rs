//! From a checked model to its linearization: the equilibrium, and M, G, C and K there.
//!
//! The kinetic energy is read off at velocity zero as a quadratic form, the effective potential
//! V - T0 is differentiated twice; nothing else of the equations of motion is ever built. Both stay
//! families of elements ([`Element`]) with their factors; [`Linearized::mass`] and
//! [`Linearized::stiffness`] add them up in double-double with rigorous bounds, from the exact
//! expressions. Eigenvalues are not this stage's business.

mod absent;
mod assemble;
mod by_hand;
mod condition;
mod constrained;
mod dependence;
mod derived;
mod descent;
mod elements;
mod elimination;
mod entries;
mod equilibrium;
mod error;
mod exact;
mod existence;
mod factors;
mod facts;
mod finish;
mod flow;
mod inputs;
mod integers;
mod integrable;
mod invariance;
mod massless;
mod matrices;
mod mechanism;
mod multipliers;
mod naming;
mod nested;
mod newton;
mod parameters;
mod parametric;
mod precise;
mod radicals;
mod rational;
mod rest;
mod rolling;
mod rows;
mod simple;
mod slopes;
mod steady;
mod surface;
mod symbolic;
mod symmetry;
mod tied;
mod unbalanced;
mod undefined;
mod units;
mod velocity;
mod verify;
mod zero;

pub use assemble::{evaluate_closed, signed_terms};
pub(crate) use condition::Shape;
pub use constrained::Tied;
pub use derived::{derive, derive_with_multipliers};
pub use elements::Element;
pub(crate) use elements::{Splitter, elements};
pub use entries::Entries;
use equilibrium::Search;
pub use equilibrium::{Equilibrium, Origin, short};
pub use error::{Feature, Inertia, LinearizeError};
pub(crate) use facts::Variable;
pub(crate) use flow::Flow;
pub use integrable::integrated;
pub(crate) use invariance::{Bodies, Invariance};
pub(crate) use massless::may_be_singular;
pub(crate) use multipliers::{Eliminated, eliminate};
pub use multipliers::{SymbolicConstraints, clear_column as clear_symbolic_column};
pub(crate) use naming::constant as translation_name;
pub use parameters::known_values;
pub use parametric::{Parametric, parametric};
pub use precise::Precise;
pub use rest::{AtRest, at_rest};
pub use rolling::SymbolicRolling;
pub use slopes::{Slopes, WithMultipliers};
pub(crate) use symbolic::instances;
pub use symbolic::{SymbolicMatrices, forces_of, instance, written_out};
pub(crate) use symmetry::{Rotation, candidate_rotations, rotation_name};
pub use zero::{NO_FORCE, ZeroMode};

use assemble::{Assembly, Values};
use constrained::Tangent;
use derived::leaving_out_dependent;
use massless::Massless;
use rolling::Rolling;
use unbalanced::Unbalanced;
pub use units::{Units, power_of_two};

use std::cell::Cell;

use crate::model::{Given, Model};
use crate::precision::{Ball, Big, Factors, Integers, SparseMatrix, clear_column};

/// The largest dense problem: its matrices and vectors take about 2 GB.
pub const MOST_COORDINATES: usize = 4000;

/// For what is added to an entry of a sparse matrix, with its place in an order.
const BYTES_A_SHARE: u64 = 36;
/// What makes many of them, and what does not.
const FULL: &str = "the square of a sum over many coordinates has an entry for every two of them, one of differences of neighbours few";

/// The number that an expression without symbols comes to; `None` where it has symbols.
#[must_use]
pub fn constant(pool: &crate::expr::Pool, value: crate::expr::ExprId) -> Option<Ball> {
    assemble::evaluate_closed::<Ball>(pool, value, ())
}

/// Refuses more coordinates than dense matrices can have, for callers that know their number before
/// there is a model: see [`coordinate_count`](crate::model::coordinate_count).
///
/// # Errors
/// [`LinearizeError::TooLarge`] beyond [`MOST_COORDINATES`].
pub fn check_size(coordinates: usize) -> Result<(), LinearizeError> {
    if coordinates <= MOST_COORDINATES {
        return Ok(());
    }
    Err(LinearizeError::TooLarge { coordinates, most: MOST_COORDINATES })
}

/// Refuses more terms than there is memory for, before they are worked out.
fn check_terms(model: &Model) -> Result<(), LinearizeError> {
    let terms = signed_terms(model).map(|(_, family)| family.count).sum();
    Ok(model.pool.budget().room(terms, crate::model::BYTES_A_TERM)?)
}

/// A model about its equilibrium.
#[derive(Clone, Debug)]
pub struct Linearized {
    /// What all is worked out with: rates of steady motions put in, multipliers among the coordinates.
    model: Model,
    /// The model and its equilibrium as they were asked for, where these differ.
    shown: Option<Box<(Model, Equilibrium)>>,
    assembly: Assembly,
    values: Values<Ball>,
    equilibrium: Equilibrium,
    /// Where the equilibrium comes from beside friction that acts at rest.
    unbalanced: Option<Box<Unbalanced>>,
    /// The directions that constraints allow.
    constrained: Option<Box<Constrained>>,
    /// The motions that directions without inertia follow, or why these do not; `None` where there are none.
    massless: Option<Box<Result<Massless, LinearizeError>>>,
    /// What has no inertia of what is left, where friction holds it.
    flow: Option<Box<Flow>>,
    /// What all but `shown` is measured in, where that is not SI.
    units: Option<Units>,
    /// The parameters that stood in exponents.
    exponents: parameters::Exponents,
    structure: Structure,
}

/// Constraints at the equilibrium.
#[derive(Clone, Debug)]
struct Constrained {
    tangent: Tangent<Ball>,
    /// The coordinates that follow the others.
    bound: Vec<usize>,
    /// The multipliers are those of a given point, not searched for.
    given: bool,
    /// The constraints that follow from others, by number.
    dependent: Vec<usize>,
    /// What conditions on velocities leave of the model, and its numbers.
    rolling: Option<(Rolling, velocity::Numbers<Ball>)>,
    /// For each of these that can't be integrated the direction of its family of equilibria.
    families: Vec<Vec<Ball>>,
}

impl Constrained {
    /// Adds conditions on velocities to constraints.
    fn put_in(&mut self, rolling: Rolling, model: &Model, equilibrium: &Equilibrium) -> Result<(), LinearizeError> {
        let span = model.rolling.first().map(|own| own.span).unwrap_or_default();
        let Some((numbers, tangent)) = rolling.numbers::<Ball>(model, &equilibrium.values, ()) else {
            return Err(LinearizeError::RollingNotCovered { reason: "their matrices have no numbers there", span });
        };
        self.tangent = tangent;
        self.rolling = Some((rolling, numbers));
        Ok(())
    }
}

/// What kind of linear system of equations a model leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Structure {
    /// M q'' + K q = 0.
    Conservative,
    /// M q'' + G q' + K q = 0 with skew G and symmetric K.
    Gyroscopic,
    /// M q'' + (K + N) q = 0: friction acts at rest alone, and exponents are in pairs ±s.
    Circulatory,
    /// M q'' + (G + C) q' + (K + N) q = 0: with dissipation.
    Damped,
}

/// Finds the equilibrium of a model and linearizes it there.
///
/// # Errors
/// Where the model needs something that is not supported, a parameter has no value, there are more than [`MOST_COORDINATES`]
/// and constraints, friction that acts at rest or a search for the equilibrium need dense matrices, there is no equilibrium, the energies are not defined there, a steady motion is none, or constraints
/// contradict each other or depend on each other just there.
pub fn linearize(model: Model) -> Result<Linearized, LinearizeError> {
    let budget = model.pool.budget().clone();
    budget.at("the equilibrium and the matrices there", None);
    let model = if model.rolling.is_empty() { model } else { integrated(&model).into_owned() };
    let linearized = if model.constraints.is_empty() {
        linearize_without(model, &[])
    } else {
        leaving_out_dependent(&model, |left_out| linearize_without(model.clone(), left_out))
    };
    budget.check()?;
    if let Ok(own) = &linearized {
        budget.tell(|| own.in_words());
    }
    linearized
}

/// Linearizes a model without some of its constraints, which follow from the others.
fn linearize_without(model: Model, left_out: &[usize]) -> Result<Linearized, LinearizeError> {
    let far = Cell::new(None);
    let found = linearize_in(model, left_out, true, &far);
    let Err(error) = found else { return found };
    let Some(model) = far.take() else { return Err(error) };
    Err(in_own_numbers(error, || linearize_in(model, left_out, false, &far).map(|_| ())))
}

/// An error that was found in other units: in the numbers of the file, where these tell the same, and wherever it has numbers
/// to tell, which would be false ones.
fn in_own_numbers(error: LinearizeError, again: impl FnOnce() -> Result<(), LinearizeError>) -> LinearizeError {
    let kind = std::mem::discriminant(&error);
    let told = again().err();
    let measured = matches!(
        error,
        LinearizeError::NoEquilibrium { .. }
            | LinearizeError::NotAnEquilibrium { .. }
            | LinearizeError::EquilibriumNotFound { .. }
            | LinearizeError::ConstraintFlat { .. }
            | LinearizeError::ConstraintsContradict { .. }
            | LinearizeError::ConstraintBroken { .. }
            | LinearizeError::NotFinite { .. }
    );
    told.filter(|own| measured || std::mem::discriminant(own) == kind).unwrap_or(error)
}

/// The same in units of its own where the numbers of the model are far from usual ones, or with `units` false in those of the file; `far` gets
/// the model as it was where they are.
fn linearize_in(
    mut model: Model,
    left_out: &[usize],
    units: bool,
    far: &Cell<Option<Model>>,
) -> Result<Linearized, LinearizeError> {
    check_time(&mut model)?;
    let visible = model.coordinates.len();
    let turning = model.rates.any();
    let bound = !model.constraints.is_empty();
    let rolls = !model.rolling.is_empty();
    if turning || bound || rolls {
        check_size(visible)?;
    }
    let mut asked = (turning || bound).then(|| model.clone());
    velocity::check_smooth(&model)?;
    if turning {
        steady::put_rates_in(&mut model)?;
    }
    let mut dependent = Vec::new();
    if bound {
        let multiplied = constrained::with_multipliers(&model, left_out);
        model = multiplied.model;
        dependent = multiplied.dependent;
        check_size(model.coordinates.len())?;
    }
    let exponents = parameters::put_exponents_in(&mut model)?;
    check_terms(&model)?;
    let mut assembly = assemble::assemble(&mut model);
    if assembly.acts_at_rest() {
        check_size(visible)?;
    }
    if visible > MOST_COORDINATES {
        // Before they are worked out: shares of entries, what they are sorted by, and their sums.
        let shares = assembly.shares();
        let bytes = shares.saturating_mul(BYTES_A_SHARE);
        model.pool.budget().room_for(format!("{shares} shares of the entries of M and K"), bytes, FULL)?;
    }
    let mut values = assembly.values::<Ball>(&model, ())?;
    let chosen = if rolls { None } else { units::choose(&model, &assembly, &values, visible) };
    if let Some(own) = &chosen {
        far.set(Some(asked.as_ref().unwrap_or(&model).clone()));
        if units {
            asked.get_or_insert_with(|| model.clone());
            own.put_in(&mut model);
            assembly = assemble::assemble(&mut model);
        }
        values = assembly.wide_values(&model)?;
    }
    let reactions = rolling::reactions(&mut model, &assembly);
    let (equilibrium, unbalanced) = match &reactions {
        Some(_) => (equilibrium::stated(&model)?, None),
        None => unbalanced::find(&Search::new(&model, &assembly, &values, visible))?,
    };
    if !assembly.velocity.is_empty() && visible <= MOST_COORDINATES {
        let point = model.with_pool(|model, pool| symbolic::equilibrium_expressions(model, pool, Some(&equilibrium)));
        assembly.forget_what_vanishes(&mut model, &point);
    }
    let reactions = (visible, reactions.as_deref().unwrap_or_default());
    let rolling = rolls.then(|| rolling::Rolling::new(&mut model, &assembly, &equilibrium, reactions)).transpose()?;
    let mut constrained = None;
    if rolls || bound {
        let mut found = at_equilibrium(&Search::new(&model, &assembly, &values, visible), &equilibrium, dependent)?;
        if let Some(rolling) = rolling {
            found.put_in(rolling, &model, &equilibrium)?;
        }
        constrained = Some(Box::new(found));
    }
    let units = chosen.filter(|_| units);
    let shown = asked.map(|model| {
        let mut own = equilibrium.first(visible);
        if let Some(units) = &units {
            own.values = units.positions(&own.values);
        }
        Box::new((model, own))
    });
    let mut linearized = Linearized {
        model,
        shown,
        assembly,
        values,
        equilibrium,
        unbalanced: unbalanced.map(Box::new),
        constrained,
        massless: None,
        flow: None,
        units,
        exponents,
        structure: Structure::Conservative,
    };
    linearized.put_families_in()?;
    if !rolls {
        linearized.massless = massless::find(&linearized).map(Box::new);
    }
    linearized.structure = linearized.find_structure();
    if matches!(linearized.structure, Structure::Damped | Structure::Gyroscopic) {
        linearized.flow = flow::find(&mut linearized).map(Box::new);
    }
    Ok(linearized)
}

/// Whether a matrix of which all entries are stored equals its transpose, exactly.
fn is_symmetric(matrix: &SparseMatrix) -> bool {
    let is_same = |a: &Ball, b: &Ball| a.radius == 0.0 && b.radius == 0.0 && (*a - *b).is_zero();
    matrix.entries().filter(|(i, j, _)| i != j).all(|(i, j, own)| {
        let (rows, values) = matrix.column(i);
        rows.binary_search(&(j as u32)).is_ok_and(|at| is_same(own, &values[at]))
    })
}

/// The directions that constraints allow at an equilibrium; that those left out hold as well.
fn at_equilibrium(
    search: &Search<'_>,
    equilibrium: &Equilibrium,
    dependent: Vec<usize>,
) -> Result<Constrained, LinearizeError> {
    let Search { model, assembly, values, visible, .. } = *search;
    let at = &equilibrium.values;
    if let Some((number, by)) = contradiction(model, &at[..visible], &dependent) {
        return Err(LinearizeError::ConstraintsContradict {
            difference: Some(equilibrium::short(by)),
            span: model.constraints[number].span,
        });
    }
    let order = model.coordinates.len();
    let second = assembly.stiffness(at, values);
    let rows = constrained::gradients(&second, visible, order);
    let given = equilibrium.multipliers_given && !rows.is_empty();
    let constrained =
        |(tangent, bound)| Constrained { tangent, bound, given, dependent, rolling: None, families: Vec::new() };
    if rows.is_empty() {
        return Ok(constrained((Tangent::all(visible), Vec::new())));
    }
    let singular = || LinearizeError::ConstraintsSingular {
        point: undefined::point_text(model, &at[..visible]),
        span: model.constraints.first().map(|own| own.span).unwrap_or_default(),
    };
    // What has inertia is left, so that what has none is a coordinate still.
    let moved = massless::moved(assembly, at, values, order).0;
    let in_balls =
        constrained::choose_light(&rows, &moved, ()).and_then(|bound| Some((Tangent::new(&rows, &bound, ())?, bound)));
    let found = in_balls.or_else(|| tangent_in_bits(search, equilibrium));
    Ok(constrained(found.ok_or_else(singular)?))
}

/// The directions that constraints allow where balls do not tell their gradients apart.
fn tangent_in_bits(search: &Search<'_>, equilibrium: &Equilibrium) -> Option<(Tangent<Ball>, Vec<usize>)> {
    let Search { model, assembly, visible, .. } = *search;
    let bits = dependence::bits(model)?;
    let values = assembly.values::<Big>(model, bits).ok()?;
    let at = precise::equilibrium(model, assembly, equilibrium, &values)?;
    let second = assembly.stiffness(&at, &values);
    let rows = constrained::gradients(&second, visible, model.coordinates.len());
    let bound = constrained::choose_bound(&rows, None, bits)?;
    Some((Tangent::new(&rows, &bound, bits)?.to_balls(), bound))
}

/// A constraint without a multiplier that does not hold where the others do, and what its sides differ by.
fn contradiction(model: &Model, at: &[Ball], dependent: &[usize]) -> Option<(usize, f64)> {
    for number in dependent {
        let Some(difference) = constrained::difference(model, *number, at) else {
            continue;
        };
        if !difference.contains_zero() {
            return Some((*number, difference.mid_f64()));
        }
    }
    if dependent.is_empty() {
        return None;
    }
    let kept: Vec<usize> = (0..model.constraints.len()).filter(|number| !dependent.contains(number)).collect();
    let start = dependence::exactly(model, at)?;
    dependence::follow(model, &kept, dependent, &start)?
}

/// That a parameter has no value.
pub fn missing_value(model: &Model, parameter: usize) -> LinearizeError {
    let parameter = model.parameters.get(parameter);
    let (name, span) = parameter.map_or_else(Default::default, |own| (own.name.clone(), own.span));
    LinearizeError::MissingValue { name, span }
}

/// Refuses a model whose equations depend on the time, and leaves no time in another one.
pub(super) fn check_time(model: &mut Model) -> Result<(), LinearizeError> {
    let span = model.time_dependent.unwrap_or_default();
    if model.drop_time() { Ok(()) } else { Err(LinearizeError::TimeDependent { span }) }
}

/// Refuses what is beyond M and K of free coordinates at rest.
fn check_plain(model: &Model) -> Result<(), LinearizeError> {
    if let Some(span) = model.time_dependent {
        return Err(LinearizeError::TimeDependent { span });
    }
    let rate = model.rates.given().map(|given| given.span).next();
    let constraint = model.constraints.first().map(|own| own.span);
    let features = [
        (Feature::Dissipation, model.dissipation),
        (Feature::Force, model.force),
        (Feature::Constraint, constraint),
        (Feature::SteadyMotion, rate),
        (Feature::Rolling, model.rolling.first().map(|own| own.span)),
    ];
    match features.into_iter().find_map(|(feature, span)| Some((feature, span?))) {
        Some((feature, span)) => Err(LinearizeError::Unsupported { feature, span }),
        None => Ok(()),
    }
}

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
    fn rolling(&self) -> Option<&Rolling> {
        self.rolled_numbers().map(|(rolling, _)| rolling)
    }

    fn rolled_numbers(&self) -> Option<&(Rolling, velocity::Numbers<Ball>)> {
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

    /// The coordinates that others follow under conditions, and these.
    pub(crate) fn following(&self) -> Option<&Tangent<Ball>> {
        self.constrained.as_ref().map(|own| &own.tangent)
    }

    /// Works out the directions of the families of equilibria that conditions on velocities leave.
    fn put_families_in(&mut self) -> Result<(), LinearizeError> {
        let Some((rolling, numbers)) = self.rolled_numbers() else { return Ok(()) };
        let Some(tangent) = self.following() else { return Ok(()) };
        let at = &self.equilibrium.values;
        let following = rolling.following(&self.model, at, numbers).or_else(|| {
            let exact = rational::following(self)?.into_iter();
            Some(exact.map(|own| own.iter().map(|x| x.in_numbers(())).collect()).collect())
        });
        let families = following.and_then(|own| rolling.families(&self.model, at, &own, tangent));
        let span = self.model.rolling.first().map(|own| own.span).unwrap_or_default();
        let reason = "the family of equilibria that they leave is not determined";
        let families = families.ok_or(LinearizeError::RollingNotCovered { reason, span })?;
        if let Some(own) = &mut self.constrained {
            own.families = families;
        }
        Ok(())
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
    fn tangents(&self) -> impl DoubleEndedIterator<Item = &Tangent<Ball>> {
        let constrained = self.constrained.as_ref().map(|own| &own.tangent);
        constrained.into_iter().chain(self.massless().map(|own| &own.tangent))
    }

    fn massless(&self) -> Option<&Massless> {
        self.massless.as_ref()?.as_ref().as_ref().ok()
    }

    /// The number of directions without inertia that follow the others: there are as many modes fewer.
    #[must_use]
    pub fn massless_directions(&self) -> usize {
        self.massless().map_or(0, Massless::count) + self.flow().map_or(0, Flow::following)
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
        let following = self.massless().and_then(|own| own.following.first()).map(|at| match &self.constrained {
            Some(own) => own.tangent.free[*at],
            None => *at,
        });
        let flow = || self.flow().filter(|_| self.rolling().is_none());
        let flowing = || flow()?.places.first().and_then(|at| self.free_coordinates().get(*at).copied());
        match following.or_else(flowing) {
            Some(at) => {
                let span = self.model().coordinates.at(at).span;
                Err(LinearizeError::Unsupported { feature: Feature::Massless, span })
            }
            None => Ok(()),
        }
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
        let of = |rolling: &Rolling| rolling.bound().len() + rolling.first_order().len();
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

    fn find_structure(&self) -> Structure {
        let acts = |matrix: &SparseMatrix| matrix.stored() > 0;
        if self.assembly.velocity.is_empty() && self.rolling().is_none() {
            return Structure::Conservative;
        } else if acts(&self.sparse_of_velocities(velocity::Matrix::Damping)) {
            return Structure::Damped;
        }
        let circulatory = self.sparse_of_velocities(velocity::Matrix::Circulatory);
        // Where velocities follow places, shapes are complex.
        let turns = self.rolling().is_some_and(Rolling::drifts);
        match (acts(&self.sparse_of_velocities(velocity::Matrix::Gyroscopic)) || turns, acts(&circulatory)) {
            (false, false) => Structure::Conservative,
            (true, false) => Structure::Gyroscopic,
            (false, true) => Structure::Circulatory,
            // Forces that have a potential are no others. Else the two together leave no pairs ±s.
            (true, true) if is_symmetric(&circulatory) => Structure::Gyroscopic,
            (true, true) => Structure::Damped,
        }
    }

    /// Terms and equilibrium in words.
    fn in_words(&self) -> String {
        let families = &self.assembly.families;
        let count: usize = families.iter().map(|family| family.terms.count).sum();
        let equilibrium = &self.equilibrium;
        let how = match (equilibrium.steps, equilibrium.proved) {
            (0, true) => "not searched for".to_owned(),
            (steps, true) => format!("found in {steps} steps and proved"),
            (steps, false) => format!("found in {steps} steps, not proved"),
        };
        format!("energies: {count} terms of {} forms; equilibrium: {how}", families.len())
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

    /// The stiffness matrix as a sum of squares, as far as it is one; `None` where coordinates follow others.
    #[must_use]
    pub fn factors(&self) -> Option<Factors> {
        if self.is_reduced() {
            return None;
        }
        let at = &self.equilibrium.values;
        Some(self.assembly.factors(at, &self.values))
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
    fn nearby(&self) -> Vec<Ball> {
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
        let mut rows: Vec<Vec<Ball>> = (0..n).map(|i| (0..n).map(|j| mass[i + all * j]).collect()).collect();
        (0..n).all(|k| {
            let is_positive = rows[k][k].is_positive();
            if is_positive {
                clear_column(&mut rows, k, k, ());
            }
            is_positive
        })
    }

    /// The first term whose numbers at the equilibrium are not finite, as an error.
    #[must_use]
    pub fn not_finite(&self) -> Option<LinearizeError> {
        self.assembly.not_finite(
            &self.model,
            &self.equilibrium.values,
            &self.values,
            "a second derivative of the energies",
        )
    }
}
