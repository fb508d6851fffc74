//! From the syntax tree to a checked model.
//!
//! Names are looked up, shapes and ranges checked, tables read, settings applied, and the energies
//! taken apart into families of terms ([`TermFamily`]). Everything stays exact and symbolic: no
//! energy is differentiated and no coordinate gets a number here.

mod assume;
mod beside;
mod compile;
mod compile_index;
mod constant;
mod coordinates;
mod dimension;
mod elaborate;
mod error;
mod feature;
mod functions;
mod given;
mod index;
mod instance;
mod integral;
mod lets;
mod matrix_market;
mod meant;
mod members;
mod mistakes;
mod names;
mod parameters;
mod points;
mod program;
mod range;
mod rates;
mod read;
mod run;
mod settings;
mod sieve;
mod survey;
mod table;
mod tensors;
mod terms;
mod time;
mod units;
mod values;
mod warning;

pub use assume::Assumption;
pub use beside::{mistakes, parse};
pub use constant::Constant;
pub use coordinates::{Coordinate, Coordinates, Symbols};
pub use dimension::{Dimension, DimensionError, Inferred, Unnamed, dimensions};
pub use elaborate::{constants, coordinate_count, elaborate};
pub use error::{MissingCoordinate, ModelError};
pub use feature::Feature;
pub use given::{Given, Givens};
pub(crate) use integral::along_path;
pub use names::{Parameter, SymbolKind};
pub use points::{Drawing, Point};
pub use range::{Range, entries};
pub(crate) use run::BYTES_A_TERM;
pub use settings::Settings;
pub use table::{Cell, Table, TableTexts};
pub use tensors::Tensor;
pub(crate) use terms::slopes_by;
pub use terms::{Local, TermFamily};
pub use units::{unit_dimension, unit_names, units_with_prefixes};
pub(crate) use values::transposed;
pub use warning::Warning;

use crate::expr::{ExprId, Pool};
use crate::order::Gather;
use crate::span::Span;

/// A constraint: what it sets to zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Constraint {
    /// The left side less the right one, in the symbols of coordinates and parameters, and linear in velocities among
    /// [`Model::rolling`].
    pub expression: ExprId,
    /// Where it stands.
    pub span: Span,
}

/// Coordinates declared under one name.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct CoordinateFamily {
    /// The name.
    pub name: String,
    /// How many values each index takes; empty for a single coordinate.
    pub extents: Vec<usize>,
    /// The number of its first coordinate; the others follow, the last index fastest.
    pub first: usize,
}

impl CoordinateFamily {
    /// The number of coordinates.
    #[must_use]
    pub fn len(&self) -> usize {
        self.extents.iter().product()
    }

    /// The numbers of its coordinates.
    #[must_use]
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.len()
    }

    /// Whether an index runs over nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A checked model.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Model {
    /// From the `model` statement.
    pub name: Option<String>,
    /// Where all expressions of the model live.
    pub pool: Pool,
    /// The generalised coordinates in the order of declaration, the last index fastest.
    pub coordinates: Coordinates,
    /// The names that the coordinates are declared under.
    pub families: Vec<CoordinateFamily>,
    /// The parameters in the order of declaration.
    pub parameters: Vec<Parameter>,
    /// The names of expressions, of families without indices, in the order of declaration.
    pub named: Vec<String>,
    /// What the symbols of the pool stand for.
    pub symbols: Symbols,
    /// The kinetic energy, or the whole `lagrangian`.
    pub kinetic: Vec<TermFamily>,
    /// The potential energy; empty beside a `lagrangian`.
    pub potential: Vec<TermFamily>,
    /// Whether `kinetic` holds a `lagrangian`.
    pub lagrangian: bool,
    /// Per coordinate: where the search for an equilibrium or a periodic motion starts.
    pub guesses: Givens,
    /// Per coordinate: its velocity at t = 0 where the search for a periodic motion starts.
    pub guessed_velocities: Givens,
    /// Per coordinate: the equilibrium as given.
    pub equilibria: Givens,
    /// Per coordinate: the rate of a steady motion.
    pub rates: Givens,
    /// The dissipation function, if there is one.
    pub dissipation: Option<Span>,
    /// The first `force`, if there is one.
    pub force: Option<Span>,
    /// Forces that no energy gives: generalised forces, and the terms of the dissipation function.
    pub forces: Vec<TermFamily>,
    /// The holonomic constraints.
    pub constraints: Vec<Constraint>,
    /// What may be used to simplify symbols, see [`Model::assumed`].
    pub assumptions: Vec<Assumption>,
    /// The constraints on velocities, integrable or not.
    pub rolling: Vec<Constraint>,
    /// Those of them that were left out, as they follow from others.
    pub redundant: Vec<Constraint>,
    /// The coordinates that are left out where this is a larger model in independent velocities: they follow by its conditions.
    pub follow: Vec<String>,
    /// The `period` statement: the period and its place.
    pub period: Option<Given>,
    /// Where the energies depend on the time explicitly.
    pub time_dependent: Option<Span>,
    /// The named expressions that are matrices of 3 x 3; members of families only with [`Settings::only_tensors`].
    pub tensors: Vec<Tensor>,
    /// Matrices of numbers and parameters that are written where a tensor of inertia is meant, without a name.
    pub unnamed_tensors: Vec<Tensor>,
    /// What `draw` statements say; `None` without any.
    pub drawing: Option<Drawing>,
    /// The points that may be drawn, with [`Settings::with_points`] alone, and without a drawing.
    pub points: Vec<Point>,
    /// Whether the file uses units, so that results are in SI.
    pub has_units: bool,
}

impl Model {
    /// What is left of an expression where nothing moves; of a condition on velocities what drives it.
    pub fn at_rest(&self, pool: &mut Pool, e: ExprId) -> ExprId {
        let rest = self.coordinates.iter().map(|own| (own.velocity, pool.zero())).gather();
        pool.substitute_one(e, &rest)
    }

    /// What is made of the model and its expressions, to which others may be added.
    pub(crate) fn with_pool<T>(&mut self, make: impl FnOnce(&Self, &mut Pool) -> T) -> T {
        let mut pool = std::mem::take(&mut self.pool);
        let made = make(self, &mut pool);
        self.pool = pool;
        made
    }
}
