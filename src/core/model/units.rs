//! Units: the factors that lead to SI, and the dimensions; the table of their names is the language's.
//!
//! What the dimensions say about the energies is the business of [`super::dimension`].

use super::error::unit_elsewhere;
use super::{Dimension, ModelError};
use crate::diagnostic::{Meant, nearest};
use crate::expr::{ExprId, Pool};
use crate::number::Number;
use crate::span::Span;
use crate::syntax::units::{UNITS, elsewhere, look_up, of_other_case, power, product};
use crate::syntax::{File, UnitKind, UnitRef};

/// The names of the units, without prefixes.
pub fn unit_names() -> impl Iterator<Item = &'static str> {
    UNITS.iter().map(|known| known.name)
}

/// The same, and those with the usual prefixes: `kg`, `cm`, `kN`.
pub fn units_with_prefixes() -> impl Iterator<Item = String> {
    let prefixed = |prefix: &'static str| {
        let units = UNITS.iter().filter(|known| known.prefixes);
        units.map(move |known| format!("{prefix}{}", known.name))
    };
    let usual = ["k", "M", "G", "m", "u", "n"].into_iter().flat_map(prefixed);
    unit_names().map(str::to_owned).chain(usual).chain(["cm".to_owned()])
}

/// What is measured in a unit, which may have a prefix.
///
/// ```
/// let force = librate::model::unit_dimension("kN").map(|own| own.to_string());
/// assert_eq!(force.as_deref(), Some("a force"));
/// ```
#[must_use]
pub fn unit_dimension(name: &str) -> Option<Dimension> {
    exponents(name).map(Dimension::new)
}

fn named_factor(pool: &mut Pool, name: &str) -> Option<ExprId> {
    let (known, exponent) = look_up(name)?;
    let number = Number::parse(known.factor)?.mul(&Number::from(10).powi(exponent)?);
    let Some(over) = known.pi_over else { return Some(pool.number(number)) };
    let share = number.div(&Number::from(over))?;
    Some(pool.scale(pool.pi(), &share))
}

/// The exponents of kg, m, s, A, K, mol and cd in a unit.
pub(super) fn exponents(name: &str) -> Option<[i8; 7]> {
    look_up(name).map(|(known, _)| known.exponents)
}

fn unknown(name: &str, span: Span) -> ModelError {
    let known = UNITS.iter().map(|known| known.name);
    // Prefixes are told apart by their case, `n` may be short for anything, and `Cm` for `C*m`.
    let same = of_other_case(name)
        .map(|own| Meant { text: own.to_owned(), is_certain: name.len() > 1 && product(name).is_none() });
    let written = || {
        power(name)
            .map(Meant::certain)
            .or_else(|| product(name).map(|text| Meant { is_certain: !text.ends_with("*s"), text }))
    };
    let named = elsewhere(name).map(|own| Meant::guess(own.to_owned()));
    let near = || nearest(name, known).map(|own| Meant::guess(own.to_owned()));
    let nearest = match unit_elsewhere(name) {
        Some(_) => None,
        None => named.or(same).or_else(written).or_else(near),
    };
    ModelError::UnknownUnit { name: name.to_owned(), span, nearest }
}

/// The names in a unit, with their places and exponents.
pub(super) fn powers(file: &File, unit: UnitRef) -> Vec<(&str, Span, Number)> {
    // With room for most: dimensions are inferred beside other work, and whoever makes a list larger waits for the others.
    let mut todo = Vec::with_capacity(8);
    todo.push((unit, Number::ONE));
    let mut names = Vec::new();
    while let Some((at, exponent)) = todo.pop() {
        match file.unit(at).kind {
            UnitKind::One => {}
            UnitKind::Name(name) => names.push((name, file.unit(at).span, exponent)),
            UnitKind::Product(factors) => {
                let signed = |under: bool| if under { exponent.neg() } else { exponent.clone() };
                todo.extend(factors.iter().rev().map(|(under, factor)| (*factor, signed(*under))));
            }
            UnitKind::Power { base, numerator, denominator } => {
                let own = Number::ratio(i64::from(numerator), i64::from(denominator));
                todo.extend(own.map(|own| (base, exponent.mul(&own))));
            }
        }
    }
    names
}

/// The exponents of kg, m, s, A, K, mol and cd in a whole unit; `None` where a name in it is not known.
pub(super) fn dimension(file: &File, unit: UnitRef) -> Option<[Number; 7]> {
    let mut sum = [0; 7].map(Number::from);
    for (name, _, exponent) in powers(file, unit) {
        for (sum, own) in sum.iter_mut().zip(exponents(name)?) {
            *sum = sum.add(&exponent.mul(&Number::from(i64::from(own))));
        }
    }
    Some(sum)
}

/// The factor by which a number in a unit becomes a number in SI: an expression without symbols.
pub(super) fn factor(pool: &mut Pool, file: &File, unit: UnitRef, errors: &mut Vec<ModelError>) -> ExprId {
    let mut product = pool.one();
    for (name, span, exponent) in powers(file, unit) {
        match named_factor(pool, name) {
            Some(factor) => {
                let factor = pool.powr(factor, &exponent);
                product = pool.mul(product, factor);
            }
            None => errors.push(unknown(name, span)),
        }
    }
    product
}
