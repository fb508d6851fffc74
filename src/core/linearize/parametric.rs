//! The matrices and the forces as expressions in chosen parameters, for many sets of their values.
//!
//! What [`super::derive`] writes out, with every other parameter at its exact value, and with the
//! equilibrium left open where it has to be searched for at each set.

use super::assemble;
use super::equilibrium::{Equilibrium, Origin};
use super::error::{Feature, LinearizeError};
use super::parameters::{parameters_of, put_exponents_in};
use super::steady::put_rates_in;
use super::symbolic::SymbolicMatrices;
use super::velocity::check_smooth;
use super::{check_plain, missing_value, symbolic};
use crate::expr::{ExprId, Pool, Substitution, Symbol};
use crate::model::{Given, Model};
use crate::precision::Ball;

/// A model as a function of some of its parameters.
pub struct Parametric {
    /// Where the expressions live.
    pub pool: Pool,
    /// The symbols of the parameters that vary, in the order asked for.
    pub parameters: Vec<Symbol>,
    /// Per coordinate: its symbol where it is searched for.
    pub searched: Vec<Option<Symbol>>,
    /// Per coordinate: the equilibrium, itself where it is searched for.
    pub equilibrium: Vec<ExprId>,
    /// Per coordinate: where a search starts.
    pub start: Vec<ExprId>,
    /// Whether the model says where a search starts; otherwise it starts only where forces act at
    /// the point 0.
    pub guessed: bool,
    /// The equilibrium at the parameters' own values, where it was searched for and found.
    pub nominal: Option<Vec<f64>>,
    /// The mass matrix, row by row.
    pub mass: Vec<Vec<ExprId>>,
    /// K + N, the stiffness matrix and what forces that no energy gives add to it, row by row; symmetric where the
    /// model is conservative.
    pub stiffness: Vec<Vec<ExprId>>,
    /// G + C, what multiplies velocities, row by row; `None` where the model is conservative: G, C and N are proved to
    /// vanish whatever the parameters, and no force acts that no energy gives.
    pub velocity: Option<Vec<Vec<ExprId>>>,
    /// The gradient of the effective potential, less the forces that no energy gives; empty where it is proved to
    /// vanish whatever the parameters.
    pub gradient: Vec<ExprId>,
}

/// Derives a model as a function of the parameters with these numbers.
///
/// # Errors
/// As [`super::derive`], and where another parameter that matters has no value.
pub fn parametric(mut model: Model, varying: &[usize]) -> Result<Parametric, LinearizeError> {
    check_plain(&model)?;
    let whole = model.clone();
    // An exponent that varies stays a symbol; any other gets its value before differentiation.
    for number in varying {
        model.parameters[*number].value = None;
    }
    check_smooth(&model)?;
    put_rates_in(&mut model)?;
    put_exponents_in(&mut model)?;
    let assembly = assemble::assemble(&mut model);
    let count = model.coordinates.len();
    let is_open = model.equilibria.iter().any(|given| given.is_none());
    let guessed = is_open && model.guesses.any();

    let forces_at = |model: &mut Model, point: &[ExprId]| {
        model.with_pool(|model, pool| {
            let mut all = vec![pool.zero(); count];
            for (number, parts) in symbolic::at_rest(model, pool, &assembly, point) {
                all[number as usize] = pool.sum(&parts);
            }
            all
        })
    };
    let point = symbolic::stated(&model, false);
    let gradient = if guessed {
        None
    } else {
        let gradient = forces_at(&mut model, &point);
        let gradient = fixed(&mut model, varying, &gradient)?;
        let vanishes = |force: &ExprId| model.pool.vanishes(*force);
        gradient.iter().all(vanishes).then(Vec::new)
    };
    let closed = gradient.is_some();
    let origin = |given: Option<Given>| match (given, closed) {
        (Some(_), _) => Origin::Given,
        (None, true) => Origin::Zero,
        (None, false) => Origin::Found,
    };
    let origins: Vec<Origin> = model.equilibria.iter().map(origin).collect();
    let both = origins.iter().zip(model.coordinates.iter());
    let searched = both.map(|(origin, own)| (*origin == Origin::Found).then_some(own.symbol)).collect();
    let place = Equilibrium::exactly(vec![Ball::ZERO; count], origins);
    let mut matrices = symbolic::matrices(&model, &assembly, &place);
    model.pool = std::mem::take(&mut matrices.pool);
    let still = matrices.mass.iter().position(|row| row.iter().all(|entry| entry.is_zero()));
    if let Some(coordinate) = still {
        let span = model.coordinates.at(coordinate).span;
        return Err(LinearizeError::Unsupported { feature: Feature::Massless, span });
    }
    let velocity = velocities(&mut model, &mut matrices, assembly.acts_at_rest());
    let gradient = gradient.unwrap_or_else(|| forces_at(&mut model, &matrices.equilibrium));
    // Only a place to start from: without one the search starts at the guess.
    let found = if closed || !is_open { None } else { super::linearize(whole).ok() };
    let nominal = found.map(|own| own.equilibrium().values.iter().map(Ball::mid_f64).collect());
    let zero = model.pool.zero();
    let start: Vec<ExprId> = model.guesses.iter().map(|guess| guess.map_or(zero, |guess| guess.symbolic)).collect();

    let mut all = matrices.equilibrium;
    all.extend(&start);
    all.extend(&gradient);
    let rows = matrices.mass.iter().chain(&matrices.stiffness).chain(velocity.iter().flatten());
    all.extend(rows.flatten());
    let all = fixed(&mut model, varying, &all)?;
    let (equilibrium, rest) = all.split_at(count);
    let (start, rest) = rest.split_at(count);
    let (gradient, rest) = rest.split_at(gradient.len());
    let (mass, rest) = rest.split_at(count * count);
    let (stiffness, own_velocity) = rest.split_at(count * count);
    let rows = |entries: &[ExprId]| -> Vec<Vec<ExprId>> { entries.chunks(count.max(1)).map(<[_]>::to_vec).collect() };
    Ok(Parametric {
        parameters: varying.iter().map(|number| model.parameters[*number].symbol).collect(),
        searched,
        equilibrium: equilibrium.to_vec(),
        start: start.to_vec(),
        guessed,
        nominal,
        mass: rows(mass),
        stiffness: rows(stiffness),
        velocity: velocity.map(|_| rows(own_velocity)),
        gradient: gradient.to_vec(),
        pool: model.pool,
    })
}

/// G + C, and N is added to K; `None` where there is nothing of these, and no force of theirs at rest.
fn velocities(model: &mut Model, matrices: &mut SymbolicMatrices, acts_at_rest: bool) -> Option<Vec<Vec<ExprId>>> {
    let SymbolicMatrices { gyroscopic, damping, circulatory, stiffness, mass, .. } = matrices;
    if !acts_at_rest && gyroscopic.is_none() && damping.is_none() && circulatory.is_none() {
        return None;
    }
    let pool = &mut model.pool;
    let mut velocity = vec![vec![pool.zero(); mass.len()]; mass.len()];
    let mut add = |into: &mut [Vec<ExprId>], rows: &Option<Vec<Vec<ExprId>>>| {
        for (entry, own) in into.iter_mut().flatten().zip(rows.iter().flatten().flatten()) {
            *entry = pool.add(*entry, *own);
        }
    };
    add(&mut velocity, gyroscopic);
    add(&mut velocity, damping);
    add(stiffness, circulatory);
    Some(velocity)
}

/// Expressions with every parameter at its value but those that vary.
fn fixed(model: &mut Model, varying: &[usize], roots: &[ExprId]) -> Result<Vec<ExprId>, LinearizeError> {
    let mut values = Substitution::default();
    for number in parameters_of(model, roots) {
        if varying.contains(&number) {
            continue;
        }
        let parameter = &model.parameters[number];
        let value = parameter.value.ok_or_else(|| missing_value(model, number))?;
        values.insert(parameter.symbol, value);
    }
    Ok(model.pool.substitute(roots, &values))
}
