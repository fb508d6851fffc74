//! Steady motions: cyclic coordinates that turn at constant rates.
//!
//! A rate S of a coordinate psi is put in where its velocity stands, psi' = S + what oscillates, and all
//! that follows is as for rest: what S leaves without velocities joins the potential (with a minus, as T0 does),
//! what is linear in them is gyroscopic. That is allowed only where nothing depends on psi itself,
//! which is checked.

use super::assemble::signed_terms;
use super::error::LinearizeError;
use super::parameters::known_values;
use super::symbolic::{drags_at_rest, instance};
use crate::expr::{ExprId, Pool, Substitution, Symbol, ZeroVerdict};
use crate::model::{Constraint, Local, Model, TermFamily};
use crate::span::Span;

/// Why a steady motion under conditions on velocities is not covered.
const TURNS: &str = "they depend on a coordinate that turns at a constant rate";

/// Puts the rates of steady motions into all energies.
///
/// # Errors
/// [`LinearizeError::NotCyclic`] for a coordinate that an energy depends on, [`LinearizeError::RollingNotCovered`] where a condition on
/// velocities does.
pub(crate) fn put_rates_in(model: &mut Model) -> Result<(), LinearizeError> {
    if !model.rates.any() {
        return Ok(());
    }
    take_loads_out(model);
    let changing = changing(model);
    for coordinate in 0..model.coordinates.len() {
        if let Some(rate) = model.rates.get(coordinate) {
            check_cyclic(model, &changing, coordinate, rate.span)?;
        }
    }
    let rates: Vec<Option<ExprId>> = model.rates.iter().map(|rate| rate.map(|rate| rate.symbolic)).collect();
    let families = model.kinetic.iter_mut().chain(&mut model.potential);
    for family in families.chain(&mut model.forces) {
        put_in(&mut model.pool, family, &rates);
    }
    let drags = model.with_pool(drags_at_rest);
    for coordinate in 0..model.coordinates.len() {
        // What a constraint holds may be balanced by its force, which the search for the equilibrium tells.
        let own = model.coordinates.at(coordinate).symbol;
        let is_tied = |tie: &Constraint| model.pool.depends_on(tie.expression, &|symbol| symbol == own);
        if let Some(rate) = model.rates.get(coordinate)
            && !model.constraints.iter().any(is_tied)
        {
            check_kept(model, &drags, coordinate, rate.span)?;
        }
    }
    Ok(())
}

/// Makes forces of terms of V that are linear in a coordinate with a rate: a weight that falls steadily is held by friction, wherever it is.
fn take_loads_out(model: &mut Model) {
    let Model { pool, potential, rates, forces, force, .. } = model;
    for family in potential.iter_mut().filter(|family| family.count == 1) {
        for (slot, local) in family.locals.clone().into_iter().enumerate() {
            let slope = pool.diff(family.body, local.coordinate);
            let is_local = |symbol| family.locals.iter().any(|own| own.coordinate == symbol || own.velocity == symbol);
            let turning = rates.get(family.coordinates[slot] as usize).is_some();
            if !turning || slope.is_zero() || pool.depends_on(slope, &is_local) {
                continue;
            }
            let load = pool.times(slope, local.coordinate);
            family.body = pool.sub(family.body, load);
            forces.push(TermFamily { body: pool.neg(slope), acts_on: Some(slot), ..family.clone() });
            force.get_or_insert(family.span);
        }
    }
}

/// Whether friction and other forces leave a rate alone. A force that depends on where the other coordinates are is left to the
/// search for an equilibrium.
fn check_kept(
    model: &mut Model,
    drags: &[(usize, ExprId)],
    coordinate: usize,
    rate: Span,
) -> Result<(), LinearizeError> {
    let values = known_values(model);
    let Model { pool, symbols, coordinates, .. } = model;
    let own = drags.iter().filter(|(at, _)| *at == coordinate);
    let parts: Vec<ExprId> = own.map(|(_, drag)| pool.neg(*drag)).collect();
    let force = pool.sum(&parts);
    let moves = |symbol| symbols.coordinate(symbol).is_some();
    // What is no identity may hold for the values.
    let at_values = pool.substitute_one(force, &values);
    if pool.depends_on(force, &moves) || pool.is_zero(at_values) != ZeroVerdict::NonZero {
        return Ok(());
    }
    let name = coordinates.at(coordinate).name();
    Err(LinearizeError::RateNotKept { coordinate: name, force: pool.display(force), span: rate })
}

/// v becomes v + w in the body, where the instances fill w with a rate or 0.
fn put_in(pool: &mut Pool, family: &mut TermFamily, rates: &[Option<ExprId>]) {
    let width = family.locals.len();
    let symbols = pool.symbols_of(&[family.body]);
    let rate_of = |number: &u32| rates.get(*number as usize).copied().flatten();
    let mut map = Substitution::default();
    let mut slots: Vec<(usize, Symbol)> = Vec::new();
    for (slot, Local { velocity, .. }) in family.locals.iter().enumerate() {
        let mut numbers = family.coordinates.iter().skip(slot).step_by(width);
        if symbols.contains(velocity) && numbers.any(|number| rate_of(number).is_some()) {
            let own = pool.symbol(&format!("rate {}", velocity.index()));
            let (moving, steady) = (pool.symbol_expr(*velocity), pool.symbol_expr(own));
            map.insert(*velocity, pool.add(moving, steady));
            slots.push((slot, own));
        }
    }
    if !slots.is_empty() {
        let zero = pool.zero();
        family.body = pool.substitute_one(family.body, &map);
        family.add_values(&slots, |number| rate_of(&number).unwrap_or(zero));
    }
}

/// The constraints that the steady motion changes: what turns may be tied to what turns with it, as in x = R th.
fn changing(model: &mut Model) -> Vec<Constraint> {
    let Model { pool, coordinates, rates, constraints, rolling, .. } = model;
    let turning = coordinates.iter().zip(rates.iter());
    let turning: Vec<(Symbol, ExprId)> = turning.filter_map(|(own, rate)| Some((own.symbol, rate?.symbolic))).collect();
    let changes = |constraint: &&Constraint| {
        let change = turning.iter().map(|(own, rate)| {
            let slope = pool.diff(constraint.expression, *own);
            pool.mul(slope, *rate)
        });
        let change: Vec<ExprId> = change.collect();
        let change = pool.sum(&change);
        !pool.vanishes(change)
    };
    constraints.iter().chain(rolling.iter()).filter(changes).copied().collect()
}

/// Whether neither L, nor the dissipation, nor a constraint depends on a coordinate.
fn check_cyclic(
    model: &mut Model,
    changing: &[Constraint],
    coordinate: usize,
    rate: Span,
) -> Result<(), LinearizeError> {
    let mut pool = std::mem::take(&mut model.pool);
    let symbol = model.coordinates.at(coordinate).symbol;
    let energies = signed_terms(model).map(|(negative, family)| (0, negative, family));
    let forces = model.forces.iter().map(|family| (1, false, family));
    let mut parts: [Vec<ExprId>; 2] = [Vec::new(), Vec::new()];
    let mut place = None;
    for (which, negative, family) in energies.chain(forces) {
        for at in 0..family.count {
            let slots = family.locals.iter().zip(family.coordinates_of(at));
            for (local, _) in slots.filter(|(_, number)| **number as usize == coordinate) {
                let slope = pool.diff(family.body, local.coordinate);
                if slope.is_zero() {
                    continue;
                }
                let map = instance(model, &mut pool, family, at, None);
                let slope = pool.substitute_one(slope, &map);
                let slope = if negative { pool.neg(slope) } else { slope };
                parts[which].push(slope);
                place = place.or(Some(family.span));
            }
        }
    }
    let mut cyclic = parts.iter().all(|parts| {
        let slope = pool.sum(parts);
        pool.vanishes(slope)
    });
    let mut tied = None;
    for constraint in changing {
        let slope = pool.diff(constraint.expression, symbol);
        if !pool.vanishes(slope) {
            if model.rolling.contains(constraint) {
                model.pool = pool;
                return Err(LinearizeError::RollingNotCovered { reason: TURNS, span: constraint.span });
            }
            cyclic = false;
            place = Some(constraint.span);
            tied = tied.or_else(|| rate_beside(model, &mut pool, constraint, coordinate));
        }
    }
    model.pool = pool;
    if cyclic {
        return Ok(());
    }
    Err(LinearizeError::NotCyclic {
        coordinate: model.coordinates.at(coordinate).name(),
        span: rate,
        energy: place.unwrap_or(rate),
        tied,
    })
}

/// The rate of another coordinate at which a constraint holds on: `p2' = R1*W/R2`. One without a rate goes first.
fn rate_beside(model: &Model, pool: &mut Pool, constraint: &Constraint, coordinate: usize) -> Option<String> {
    let rates = || model.rates.iter().map(|rate| rate.map(|rate| rate.symbolic)).enumerate();
    let mut slopes = Vec::new();
    for (at, rate) in rates() {
        let slope = pool.diff(constraint.expression, model.coordinates.at(at).symbol);
        if !pool.vanishes(slope) {
            slopes.push((at, slope, rate));
        }
    }
    let other = *slopes.iter().filter(|(at, ..)| *at != coordinate).min_by_key(|(.., rate)| rate.is_some())?;
    let beside = slopes.iter().filter(|(at, ..)| *at != other.0);
    let changes: Vec<ExprId> = beside.filter_map(|(_, slope, rate)| Some(pool.mul(*slope, (*rate)?))).collect();
    let change = pool.sum(&changes);
    let rate = pool.div(change, other.1);
    let rate = pool.neg(rate);
    let moves = |symbol| model.symbols.coordinate(symbol).is_some();
    let name = model.coordinates.at(other.0).name();
    (!pool.depends_on(rate, &moves)).then(|| format!("{name}' = {}", pool.display(rate)))
}
