//! Ordinary differential equations x' = f(t, x), a step at a time: enclosed, and in plain doubles.
//!
//! Right sides are tapes; a step sums the Taylor series of the solution ([`librate_core::expr::Series`]), of any order, and
//! that of its derivative by the initial point (the variational equations T' = J T, J = df/dx). [`Enclosing`] bounds what is
//! left out: a box that the solution does not leave during the step, by the theorem of Picard and Lindelöf, a bound
//! of T there by Gronwall's inequality, and Lagrange's remainder from the series over that box (R. E. Moore, Interval
//! Analysis (1966), chapter 11; N. S. Nedialkov, K. R. Jackson, G. F. Corliss, Appl. Math. Comput. 105 (1999) 21).
//! [`Following`] does the same for one solution over a long time, about a centre of any precision. [`Plain`] does the
//! same sums in doubles, with an error that is estimated only, for one set of parameters or for several at once.
//!
//! It never sees a model, and never says that a bound holds where a box was not shown to hold the solution: such a
//! step fails.

mod bounds;
mod enclosing;
mod expansion;
mod explicit;
mod following;
mod plain;
mod set;

pub use enclosing::{Enclosing, Step};
pub(crate) use explicit::solved;
pub use following::Following;
pub use plain::{Doubles, Plain};

use librate_core::expr::{ExprId, Pool, Symbol, Tape, UnboundSymbol};
use librate_core::precision::Scalar;

/// x' = f(t, x) with the derivatives of f, compiled.
#[derive(Clone, Debug)]
pub struct Equations {
    dimension: usize,
    /// How many parameters stay open, for [`Plain::set_parameters`].
    parameters: usize,
    /// Whether the state itself is followed; otherwise only T, with a J that depends on t alone.
    moving: bool,
    /// How many entries of J are not identically 0.
    couplings: usize,
    /// f where the state is followed, then J row by row.
    tape: Tape,
    /// f alone.
    rates: Tape,
}

impl Equations {
    /// From f as expressions in the time, the state and parameters, one for each component of the state.
    ///
    /// # Errors
    /// [`UnboundSymbol`] where f contains another symbol.
    pub fn compile(
        pool: &mut Pool,
        time: Symbol,
        state: &[Symbol],
        parameters: &[Symbol],
        rates: &[ExprId],
    ) -> Result<Self, UnboundSymbol> {
        let mut outputs = rates.to_vec();
        for rate in rates {
            outputs.extend(state.iter().map(|symbol| pool.diff(*rate, *symbol)));
        }
        let inputs: Vec<Symbol> = [&[time], state, parameters].concat();
        Ok(Self {
            dimension: state.len(),
            parameters: parameters.len(),
            moving: true,
            couplings: couplings(pool, &outputs[rates.len()..]),
            tape: Tape::compile(pool, &outputs, &inputs)?,
            rates: Tape::compile(pool, rates, &inputs)?,
        })
    }

    /// T' = J(t) T alone, for a J given row by row: linear equations, or those about a state that rests.
    ///
    /// # Errors
    /// [`UnboundSymbol`] where J contains another symbol than the time.
    pub fn linear(
        pool: &Pool,
        time: Symbol,
        dimension: usize,
        parameters: &[Symbol],
        slopes: &[ExprId],
    ) -> Result<Self, UnboundSymbol> {
        let inputs: Vec<Symbol> = [&[time], parameters].concat();
        Ok(Self {
            dimension,
            parameters: parameters.len(),
            moving: false,
            couplings: couplings(pool, slopes),
            tape: Tape::compile(pool, slopes, &inputs)?,
            rates: Tape::compile(pool, &[], &inputs)?,
        })
    }

    /// The number of components of the state.
    pub(crate) fn dimension(&self) -> usize {
        self.dimension
    }

    /// How many entries of J are not identically 0: with the dimension, what the products of a step are counted by.
    pub(crate) fn couplings(&self) -> usize {
        self.couplings
    }

    /// Whether the state itself is followed.
    pub(crate) fn is_moving(&self) -> bool {
        self.moving
    }
}

fn couplings(pool: &Pool, slopes: &[ExprId]) -> usize {
    slopes.iter().filter(|slope| **slope != pool.zero()).count()
}

/// The power of two nearest to a positive number, on a logarithmic scale, far within the range of doubles; 1 for what has none.
pub(crate) fn nearest_power_of_two(value: f64) -> f64 {
    let power = value.log2().round();
    if power.is_finite() { power.clamp(-900.0, 900.0).exp2() } else { 1.0 }
}

/// A number of terms or steps, which is far below 2^53, as a double.
pub(crate) fn count(number: usize) -> f64 {
    number as f64
}

/// A polynomial at a place.
pub(crate) fn horner<S: Scalar>(row: &[S], place: &S) -> S {
    let sum = row.iter().rev().cloned().reduce(|value, lower| value.mul(place).add(&lower));
    sum.unwrap_or_else(|| place.sub(place))
}
