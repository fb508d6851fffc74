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
mod facts;
mod finish;
mod flow;
mod inputs;
mod integers;
mod integrable;
mod invariance;
mod linearized;
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
mod roots;
mod rows;
mod simple;
mod slopes;
mod squares;
mod steady;
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
pub(crate) use constrained::Tied;
pub use constrained::independent_constraints;
pub use derived::derive;
pub(crate) use derived::derive_with_multipliers;
pub use elements::Element;
pub(crate) use elements::{Splitter, elements};
pub(crate) use elimination::grows_from_zero;
pub use elimination::nullspace_mod;
pub use entries::Entries;
use equilibrium::Search;
pub use equilibrium::{Equilibrium, Origin, short};
pub use error::{Feature, Inertia, LinearizeError};
pub(crate) use facts::Variable;
pub(crate) use flow::Flow;
pub use integrable::{integrated, without_dependent};
pub(crate) use invariance::{Bodies, Invariance};
pub(crate) use massless::may_be_singular;
pub(crate) use multipliers::{Eliminated, eliminate};
pub use multipliers::{SymbolicConstraints, clear_column as clear_symbolic_column};
pub(crate) use naming::constant as translation_name;
pub use parameters::{all_terms, bodies, exponents_in, known_values};
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
use massless::Massless;
use rolling::Rolling;
use unbalanced::Unbalanced;
pub use units::{Units, power_of_two};

use std::cell::Cell;

use crate::model::Model;
use crate::precision::{Ball, Big, SparseMatrix};

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
    Err(LinearizeError::TooLarge { coordinates, most: MOST_COORDINATES, in_code: false })
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
    let linearized = in_units(model);
    budget.check()?;
    if let Ok(own) = &linearized {
        budget.tell(|| own.in_words());
    }
    linearized
}

/// Linearizes a model, in units of its own where its numbers are far from usual ones; what is wrong is told in those of the file.
fn in_units(model: Model) -> Result<Linearized, LinearizeError> {
    let far = Cell::new(None);
    let found = linearize_in(model, true, &far);
    let Err(error) = found else { return found };
    let Some(model) = far.take() else { return Err(error) };
    Err(in_own_numbers(error, || linearize_in(model, false, &far).map(|_| ())))
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
fn linearize_in(mut model: Model, units: bool, far: &Cell<Option<Model>>) -> Result<Linearized, LinearizeError> {
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
        let multiplied = constrained::with_multipliers(&model);
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
        let point = model.with_pool(|model, pool| symbolic::equilibrium_expressions(model, pool, &equilibrium));
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
    let constrained = |(tangent, bound)| Constrained { tangent, bound, dependent, rolling: None, families: Vec::new() };
    if rows.is_empty() {
        return Ok(constrained((Tangent::solved(visible, &[], Vec::new()), Vec::new())));
    }
    let singular = || LinearizeError::ConstraintsSingular {
        point: undefined::point_text(model, &at[..visible]),
        span: model.constraints.first().map(|own| own.span).unwrap_or_default(),
    };
    // What has inertia is left, so that what has none is a coordinate still.
    let moved = massless::moved(assembly, at, values, order).0;
    let in_balls =
        constrained::choose_light(&rows, &moved).and_then(|bound| Some((Tangent::new(&rows, &bound, ())?, bound)));
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
    let broken = |number: &usize| {
        let difference = constrained::difference(model, *number, at).filter(|own| !own.contains_zero())?;
        Some((*number, difference.mid_f64()))
    };
    if let Some(found) = dependent.iter().find_map(broken) {
        return Some(found);
    }
    if dependent.is_empty() {
        return None;
    }
    let kept: Vec<usize> = (0..model.constraints.len()).filter(|number| !dependent.contains(number)).collect();
    dependence::follow(model, &kept, dependent, at)?
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

/// Refuses what is beyond free coordinates.
fn check_plain(model: &Model) -> Result<(), LinearizeError> {
    if let Some(span) = model.time_dependent {
        return Err(LinearizeError::TimeDependent { span });
    }
    let both = [(Feature::Constraint, model.constraints.first()), (Feature::Rolling, model.rolling.first())];
    let mut found = both.into_iter().filter_map(|(feature, own)| Some((feature, own?.span)));
    found.next().map_or(Ok(()), |(feature, span)| Err(LinearizeError::Unsupported { feature, span }))
}

impl Linearized {
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
}
