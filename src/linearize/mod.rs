//! From a checked model to its linearization: the equilibrium, and M and K there.
//!
//! The kinetic energy is read off at velocity zero as a quadratic form, the effective potential
//! V - T0 is differentiated twice; nothing else of the equations of motion is ever built. Both stay
//! families of elements ([`Element`]) with their factors; [`Linearized::mass`] and
//! [`Linearized::stiffness`] add them up in double-double with rigorous bounds, from the exact
//! expressions. Eigenvalues are not this stage's business.

mod absent;
mod assemble;
mod codes;
mod condition;
mod descent;
mod elements;
mod enclosure;
mod entries;
mod equilibrium;
mod error;
mod exact;
mod existence;
mod factors;
mod facts;
mod finish;
mod gyroscopic;
mod mechanism;
mod naming;
mod newton;
mod parametric;
mod precise;
mod symbolic;
mod symmetry;
mod undefined;
mod verify;
mod zero;

pub use assemble::ElementFamily;
pub(crate) use assemble::signed_terms;
pub(crate) use condition::Shape;
pub use elements::Element;
pub(crate) use elements::{Splitter, elements};
pub use entries::Entries;
pub use equilibrium::{Equilibrium, Origin};
pub use error::{Feature, LinearizeError};
pub use factors::Factors;
pub(crate) use facts::Variable;
pub(crate) use parametric::{Parametric, parametric};
pub use precise::Precise;
pub use symbolic::SymbolicMatrices;
pub(crate) use symbolic::instance;
pub(crate) use symmetry::{Rotation, candidate_rotations, rotation_name, translation_name};
pub use zero::ZeroMode;

use assemble::{Assembly, Values};

use crate::model::Model;
use crate::precision::Ball;

/// The largest dense problem: its matrices and vectors take about 2 GB.
pub const MOST_COORDINATES: usize = 4000;

/// Refuses more coordinates than [`linearize`] takes, for callers that know their number before
/// there is a model: see [`coordinate_count`](crate::model::coordinate_count).
///
/// # Errors
/// [`LinearizeError::TooLarge`] beyond [`MOST_COORDINATES`].
pub fn check_size(coordinates: usize) -> Result<(), LinearizeError> {
    if coordinates <= MOST_COORDINATES {
        return Ok(());
    }
    Err(LinearizeError::TooLarge {
        coordinates,
        most: MOST_COORDINATES,
    })
}

/// A model about its equilibrium.
#[derive(Clone, Debug)]
pub struct Linearized {
    model: Model,
    assembly: Assembly,
    values: Values<Ball>,
    equilibrium: Equilibrium,
}

/// Finds the equilibrium of a model and linearizes it there.
///
/// # Errors
/// Where the model needs something that is not supported, a parameter has no value, there is no
/// equilibrium, or the energies are not defined there.
pub fn linearize(mut model: Model) -> Result<Linearized, LinearizeError> {
    check_supported(&model)?;
    check_size(model.coordinates.len())?;
    assemble::put_exponents_in(&mut model);
    let (assembly, linear) = assemble::assemble(&mut model);
    let values = assembly
        .values::<Ball>(&model, ())
        .map_err(|missing| missing_value(&model, missing.0))?;
    let equilibrium = equilibrium::find(&model, &assembly, &values)?;
    gyroscopic::check(&mut model, &linear, &equilibrium)?;
    Ok(Linearized {
        model,
        assembly,
        values,
        equilibrium,
    })
}

/// M and K of a model at its equilibrium, as expressions. Parameters need no values unless the
/// equilibrium has to be searched for.
///
/// # Errors
/// As [`linearize`].
pub fn derive(mut model: Model) -> Result<SymbolicMatrices, LinearizeError> {
    check_supported(&model)?;
    let (assembly, linear) = assemble::assemble(&mut model);
    let guessed = model.guesses.iter().any(Option::is_some);
    let mut pool = model.pool.clone();
    let point = symbolic::equilibrium_expressions(&model, &mut pool, None);
    model.pool = pool;
    if !guessed && symbolic::forces_vanish(&model, &assembly, &point) == Some(true) {
        gyroscopic::check_symbolic(&mut model, &linear, &point)?;
        return Ok(symbolic::matrices(&model, &assembly, None));
    }
    let values = assembly
        .values::<Ball>(&model, ())
        .map_err(|missing| missing_value(&model, missing.0))?;
    let equilibrium = equilibrium::find(&model, &assembly, &values)?;
    gyroscopic::check(&mut model, &linear, &equilibrium)?;
    Ok(symbolic::matrices(&model, &assembly, Some(&equilibrium)))
}

fn missing_value(model: &Model, parameter: usize) -> LinearizeError {
    let parameter = &model.parameters[parameter];
    LinearizeError::MissingValue {
        name: parameter.name.clone(),
        span: parameter.span,
    }
}

fn check_supported(model: &Model) -> Result<(), LinearizeError> {
    if let Some(span) = model.time_dependent {
        return Err(LinearizeError::TimeDependent { span });
    }
    let rate = model.rates.iter().flatten().map(|given| given.span).next();
    let features = [
        (Feature::Dissipation, model.dissipation),
        (Feature::Constraint, model.constraints.first().copied()),
        (Feature::SteadyMotion, rate),
    ];
    for (feature, span) in features {
        if let Some(span) = span {
            return Err(LinearizeError::Unsupported { feature, span });
        }
    }
    Ok(())
}

impl Linearized {
    /// The model.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The equilibrium.
    #[must_use]
    pub fn equilibrium(&self) -> &Equilibrium {
        &self.equilibrium
    }

    /// The number of coordinates.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.model.coordinates.len()
    }

    /// The families of elements.
    #[must_use]
    pub fn elements(&self) -> &[ElementFamily] {
        &self.assembly.families
    }

    /// The mass matrix, dense, column by column, in SI.
    #[must_use]
    pub fn mass(&self) -> Vec<Ball> {
        self.assembly.mass(&self.equilibrium.values, &self.values)
    }

    /// The stiffness matrix, dense, column by column, in SI.
    #[must_use]
    pub fn stiffness(&self) -> Vec<Ball> {
        self.assembly
            .stiffness(&self.equilibrium.values, &self.values)
    }

    /// The stiffness matrix as a sum of squares, as far as it is one.
    #[must_use]
    pub fn factors(&self) -> Factors {
        self.assembly
            .factors(&self.equilibrium.values, &self.values)
    }

    /// M and K as expressions.
    #[must_use]
    pub fn symbolic(&self) -> SymbolicMatrices {
        symbolic::matrices(&self.model, &self.assembly, Some(&self.equilibrium))
    }

    /// Motions that are proved to cost no energy: independent vectors of the kernel of K.
    #[must_use]
    pub fn zero_modes(&self) -> Vec<ZeroMode> {
        zero::zero_modes(
            &self.model,
            &self.assembly,
            &self.equilibrium.values,
            &self.values,
        )
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
