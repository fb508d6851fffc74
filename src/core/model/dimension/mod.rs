//! Dimensions: what kind of quantity every name is, and where that can't be.
//!
//! In a file with units every name has a dimension, given or unknown. Each sum, each function and
//! each energy is an equation among dimensions; equations are linear in the exponents and are
//! solved as they come ([`solve`]). What contradicts the equations before it is a mistake, told
//! with both places and the factor that is missing. Numbers are not examined here, except in
//! exponents; a file without units is not checked at all.

mod error;
mod evaluate;
mod infer;
mod names;
mod operations;
mod solve;

pub use error::{DimensionError, Inferred, Unnamed};
pub use infer::dimensions;
pub(super) use infer::{Dimensions, infer};

use crate::number::Number;

/// The seven SI base units, in the order in which exponents are kept.
const BASE: [&str; 7] = ["kg", "m", "s", "A", "K", "mol", "cd"];

/// A product of powers of SI base units: what kind of quantity something is.
///
/// Angles are pure numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Dimension {
    exponents: [Number; 7],
}

impl Dimension {
    /// From whole exponents of kg, m, s, A, K, mol and cd.
    ///
    /// ```
    /// use librate::model::Dimension;
    /// let force = Dimension::new([1, 1, -2, 0, 0, 0, 0]);
    /// assert_eq!(force.unit(), "N");
    /// assert_eq!(force.to_string(), "a force");
    /// ```
    #[must_use]
    pub fn new(exponents: [i8; 7]) -> Self {
        Self { exponents: exponents.map(|e| Number::from(i64::from(e))) }
    }

    /// Whether this is a pure number.
    #[must_use]
    pub fn is_number(&self) -> bool {
        self.exponents.iter().all(Number::is_zero)
    }

    /// What is to be multiplied by `self` to get `wanted`.
    ///
    /// ```
    /// use librate::model::Dimension;
    /// let (length, force) = (Dimension::new([0, 1, 0, 0, 0, 0, 0]), Dimension::new([1, 1, -2, 0, 0, 0, 0]));
    /// assert_eq!(length.missing(&force).unit(), "N/m");
    /// ```
    #[must_use]
    pub fn missing(&self, wanted: &Self) -> Self {
        Self { exponents: std::array::from_fn(|at| wanted.exponents[at].sub(&self.exponents[at])) }
    }

    fn inverse(&self) -> Self {
        self.missing(&Self::default())
    }

    /// The SI unit in the language's syntax: `N`, `kg*m^2`, `m^(1/2)`, `1`.
    #[must_use]
    pub fn unit(&self) -> String {
        if let Some(symbol) = names::symbol(self) {
            return symbol.to_owned();
        }
        let power = |base: &str, e: &Number| match e.small_parts() {
            Some((1, 1)) => base.to_owned(),
            Some((n, 1)) => format!("{base}^{n}"),
            Some((n, d)) => format!("{base}^({n}/{d})"),
            None => format!("{base}^?"),
        };
        let mut over = Vec::new();
        let mut under = String::new();
        for (base, e) in BASE.iter().zip(&self.exponents) {
            if e.is_negative() {
                under.push('/');
                under.push_str(&power(base, &e.neg()));
            } else if !e.is_zero() {
                over.push(power(base, e));
            }
        }
        let over = if over.is_empty() { "1".to_owned() } else { over.join("*") };
        format!("{over}{under}")
    }
}

/// In words: `a force`, or `a quantity in kg*m^3` where there is no word.
impl std::fmt::Display for Dimension {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(word) = names::word(self) { f.write_str(word) } else { write!(f, "a quantity in {}", self.unit()) }
    }
}
