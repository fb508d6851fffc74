//! Equilibria beside friction that acts at rest, which no potential gives.
//!
//! A medium that moves drags: the forces F(q) = -∇(V - T0) - ∂F/∂q' at rest are no gradient, and their derivative
//! is not symmetric. They vanish where mu·F(q) is stationary in q and in further coordinates mu alike, at mu = 0, where
//! the second derivatives are regular exactly if those of the forces are. So the same search and the same proof do, with
//! twice as many coordinates.

use super::assemble::{self, Assembly, signed_terms};
use super::equilibrium::{self, Equilibrium, Search};
use super::error::LinearizeError;
use super::precise;
use crate::expr::{ExprId, Pool};
use crate::model::{Given, Local, Model, TermFamily};
use crate::number::Number;
use crate::precision::{Ball, Big};

/// Forces as a potential in twice as many coordinates, and the equilibrium there.
#[derive(Clone, Debug)]
pub(crate) struct Unbalanced {
    model: Model,
    assembly: Assembly,
    pub(super) equilibrium: Equilibrium,
}

/// The equilibrium of a model, however its forces come about.
pub(super) fn find(search: &Search<'_>) -> Result<(Equilibrium, Option<Unbalanced>), LinearizeError> {
    let Search { model, assembly, values, visible, .. } = *search;
    let count = model.coordinates.len();
    let zero = vec![Ball::ZERO; count];
    let guessed = model.guesses.any();
    let searched = guessed || model.equilibria.iter().take(visible).any(|given| given.is_none());
    let stated = guessed || model.equilibria.any();
    let rests = || !stated && assembly.gradient(&zero, values).iter().all(Ball::is_zero);
    if !(searched && assembly.acts_at_rest()) || rests() {
        return Ok((equilibrium::find(search)?, None));
    }
    if visible < count
        && let Some(found) = search.without_search()?
    {
        return Ok((found, None));
    }
    let mut doubled = doubled(model, assembly);
    let own = assemble::assemble(&mut doubled);
    let known = own.values::<Ball>(&doubled, ())?;
    let mut found = equilibrium::find(&Search::new(&doubled, &own, &known, 2 * count));
    // Where that search ends, from an equilibrium of the energies alone, which has a way down.
    if visible == count && matches!(found, Err(LinearizeError::EquilibriumNotFound { .. })) {
        let mut conservative = assembly.clone();
        conservative.velocity.clear();
        if let Ok(near) = equilibrium::find(&Search::new(model, &conservative, values, visible)) {
            for (i, place) in near.values.iter().enumerate() {
                let value = Number::from_f64_exact(place.mid_f64()).unwrap_or_default();
                let symbolic = doubled.pool.number(value);
                let span = model.coordinates.at(i).span;
                doubled.guesses.set(i, Some(Given { symbolic, value: Some(symbolic), span }));
            }
            found = equilibrium::find(&Search::new(&doubled, &own, &known, 2 * count)).or(found);
        }
    }
    let found = found?;
    let equilibrium = found.first(count);
    // Forces on what is given are not among those that were brought to zero.
    let force = assembly.gradient(&equilibrium.values, values);
    let is_pushed = |i: &usize| model.equilibria.get(*i).is_some() && !force[*i].contains_zero();
    if let Some(i) = (0..count).find(is_pushed) {
        return Err(search.acts(i, equilibrium::short(-force[i].mid_f64())));
    }
    let unbalanced = Unbalanced { model: doubled, assembly: own, equilibrium: found };
    Ok((equilibrium, Some(unbalanced)))
}

impl Unbalanced {
    /// The equilibrium with so many bits: the first `count` coordinates.
    pub(super) fn precisely(&self, bits: usize, count: usize) -> Option<Vec<Big>> {
        let values = self.assembly.values::<Big>(&self.model, bits).ok()?;
        let mut found = precise::equilibrium(&self.model, &self.assembly, &self.equilibrium, &values)?;
        found.truncate(count);
        Some(found)
    }
}

/// The model whose potential is mu·(∇(V - T0) + ∂F/∂q' at rest).
fn doubled(model: &Model, assembly: &Assembly) -> Model {
    let mut own = model.clone();
    let count = own.coordinates.len();
    let zero = own.pool.zero();
    for i in 0..count {
        let coordinate = own.coordinates.at(i);
        let (name, span) = (coordinate.name(), coordinate.span);
        own.add_coordinate(&format!("the multiplier of the force on {name}"), name, span);
        // A force on what is held need not vanish here.
        let held = own.equilibria.get(i).map(|given| Given { symbolic: zero, value: Some(zero), ..given });
        own.equilibria.set(count + i, held);
    }
    let pool = &mut own.pool;
    let mut potential = Vec::new();
    for (negative, family) in signed_terms(model) {
        let rests = family.at_rest(pool);
        let share = pool.substitute_one(family.body, &rests);
        let energy = if negative { share } else { pool.neg(share) };
        let slopes = family.locals.iter().map(|local| pool.diff(energy, local.coordinate));
        let forces: Vec<(usize, ExprId)> = slopes.enumerate().collect();
        potential.extend(multiplied(pool, family, &forces, count));
    }
    for family in &assembly.velocity {
        potential.extend(multiplied(pool, &family.terms, &family.derivatives.rest, count));
    }
    own.kinetic = Vec::new();
    own.potential = potential;
    own.forces = Vec::new();
    own
}

/// The sum of mu·force of a family, as a family with one more slot for each force.
fn multiplied(pool: &mut Pool, family: &TermFamily, forces: &[(usize, ExprId)], count: usize) -> Option<TermFamily> {
    let mut parts = Vec::new();
    let mut slots: Vec<(usize, Local)> = Vec::new();
    for (place, force) in forces {
        if force.is_zero() {
            continue;
        }
        let name = format!("mu {place} of a slot");
        let symbol = pool.symbol(&name);
        let velocity = pool.symbol(&format!("{name}'"));
        parts.push(pool.times(*force, symbol));
        slots.push((*place, Local::new(symbol, velocity)));
    }
    if slots.is_empty() {
        return None;
    }
    let mut own = family.clone();
    own.body = pool.sum(&parts);
    let width = family.locals.len();
    own.coordinates.clear();
    for at in 0..family.count {
        let numbers = &family.coordinates[at * width..(at + 1) * width];
        own.coordinates.extend(numbers);
        let mirrored = slots.iter().map(|(place, ..)| numbers[*place] + u32::try_from(count).unwrap_or(u32::MAX));
        own.coordinates.extend(mirrored);
    }
    own.locals.extend(slots.iter().map(|(_, local)| *local));
    Some(own)
}
