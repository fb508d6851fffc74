//! What is known of each coordinate at the equilibrium: where it is, and its entries of K and M.

use std::collections::BTreeMap;

use librate::derive::{self, Derivation, Parts};
use librate::linearize::Linearized;
use librate::model::{Dimension, Model};
use librate::precision::Ball;

use super::check::digits;

/// Longer expressions are left out.
const LONGEST: usize = 60;
/// Symbols are worked out for up to so many coordinates.
const MOST_SYMBOLS: usize = 40;
const ENERGY: [i8; 7] = [1, 2, -2, 0, 0, 0, 0];
/// An energy over the square of a rate.
const INERTIA: [i8; 7] = [1, 2, 0, 0, 0, 0, 0];

/// A coordinate at the equilibrium.
#[derive(Clone)]
pub(super) struct AtRest {
    member: String,
    position: String,
    /// The entries of K and M, where others follow it those among the motions that are left; `None` where it follows.
    entries: Option<[Entry; 2]>,
}

/// An entry of a matrix.
#[derive(Clone)]
struct Entry {
    symbol: Option<String>,
    digits: String,
}

impl Entry {
    fn new(symbol: String, value: &Ball) -> Self {
        let digits = digits(value);
        let is_shown = !symbol.is_empty() && symbol.chars().count() <= LONGEST && symbol != digits;
        Self { symbol: is_shown.then_some(symbol), digits }
    }
}

impl AtRest {
    /// In a line, with units where that of the coordinate is known.
    pub(super) fn line(&self, dimension: Option<&Dimension>) -> String {
        let unit = |of: Dimension| match of.is_number() {
            true => String::new(),
            false => format!(" {}", of.unit()),
        };
        let own = dimension.cloned().map(unit).unwrap_or_default();
        let place = format!("at the equilibrium `{} = {}{own}`", self.member, self.position);
        let Some([stiffness, inertia]) = &self.entries else {
            return format!("{place}, near which it follows other coordinates");
        };
        let entry = |entry: &Entry, energy: [i8; 7]| {
            let unit = dimension.map(|x| unit(x.missing(&x.missing(&Dimension::new(energy))))).unwrap_or_default();
            let symbol = entry.symbol.as_ref().map(|text| format!("{text} = ")).unwrap_or_default();
            format!("`{symbol}{}{unit}`", entry.digits)
        };
        format!("{place}: stiffness K = {}, inertia M = {}", entry(stiffness, ENERGY), entry(inertia, INERTIA))
    }
}

/// All coordinates, by the names of their families.
pub(super) fn at_rest(model: &Model, linearized: &Linearized) -> BTreeMap<String, Vec<AtRest>> {
    let free = linearized.free_coordinates();
    let symbols = if free.len() <= MOST_SYMBOLS { symbols(model, &free) } else { None };
    let (mass, stiffness) = (linearized.mass(), linearized.stiffness());
    let entries = |i: usize| {
        let k = free.iter().position(|own| *own == i)?;
        let (stiffness, mass) = (stiffness.get(k * (free.len() + 1))?, mass.get(k * (free.len() + 1))?);
        let symbols = symbols.as_ref().and_then(|all| all.get(k).cloned()).unwrap_or_default();
        Some([Entry::new(symbols.0, stiffness), Entry::new(symbols.1, mass)])
    };
    let mut all: BTreeMap<String, Vec<AtRest>> = BTreeMap::new();
    for (i, (member, position)) in
        linearized.model().coordinates.names().zip(&linearized.equilibrium().values).enumerate()
    {
        let family = member.split('[').next().unwrap_or_default().to_owned();
        let own = AtRest { member, position: digits(position), entries: entries(i) };
        all.entry(family).or_default().push(own);
    }
    all
}

/// K and M of these coordinates in symbols, if they are those that are left there, too.
fn symbols(model: &Model, free: &[usize]) -> Option<Vec<(String, String)>> {
    let derivation = derive::derive(model, &Parts::default()).ok()?;
    let linear = derivation.linear.as_ref().ok()?;
    let diagonal = |own: &Derivation| {
        let linear = own.linear.as_ref().ok()?;
        let rows = linear.stiffness.iter().zip(&linear.mass).enumerate();
        rows.map(|(i, (k, m))| Some((own.pool.display(*k.get(i)?), own.pool.display(*m.get(i)?))))
            .collect::<Option<Vec<_>>>()
    };
    match &linear.tangent {
        None => diagonal(&derivation).filter(|all| all.len() == free.len()),
        Some(tangent) => {
            let reduced = tangent.reduced.as_ref().filter(|own| own.free == free)?;
            diagonal(&reduced.derivation)
        }
    }
}
