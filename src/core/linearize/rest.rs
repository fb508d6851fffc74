//! What acts on a model that rests, in symbols: for whoever searches for all of its equilibria.

use super::error::{Feature, LinearizeError};
use super::parameters::{known_values, put_exponents_in};
use super::symbolic::{drags_at_rest, written_out};
use super::{assemble::signed_terms, check_time, missing_value, steady};
use crate::expr::{ExprId, Pool, Substitution, Symbol};
use crate::model::Model;
use crate::order::Gather;

/// Potential, forces and constraints of a model at rest, with the parameters at their values.
#[derive(Clone, Debug)]
pub struct AtRest {
    /// Where the expressions live.
    pub pool: Pool,
    /// The symbols of the coordinates.
    pub coordinates: Vec<Symbol>,
    /// The symbols of the parameters that vary, in the order asked for.
    pub parameters: Vec<Symbol>,
    /// V - T0.
    pub potential: ExprId,
    /// Per coordinate: what friction and generalised forces add to the derivative of the potential.
    pub others: Vec<ExprId>,
    /// What has to vanish under holonomic constraints.
    pub constraints: Vec<ExprId>,
    /// Per coordinate: whether it turns at a constant rate, and nothing depends on it.
    pub turning: Vec<bool>,
}

/// Writes a model at rest out, with the parameters of these numbers left open.
///
/// # Errors
/// Explicit time, conditions on velocities, a rate of what is not cyclic, and a parameter that matters without a value.
pub fn at_rest(mut model: Model, varying: &[usize]) -> Result<AtRest, LinearizeError> {
    check_time(&mut model)?;
    if let Some(own) = model.rolling.first() {
        return Err(LinearizeError::Unsupported { feature: Feature::Rolling, span: own.span });
    }
    steady::put_rates_in(&mut model)?;
    for number in varying {
        model.parameters[*number].value = None;
    }
    put_exponents_in(&mut model)?;
    let mut pool = std::mem::take(&mut model.pool);
    let none = Substitution::default();
    let terms = signed_terms(&model).map(|(negative, family)| (!negative, family));
    let potential = written_out(&model, &mut pool, terms, None, &none);
    let others = drags_at_rest(&model, &mut pool).into_iter().by_place(model.coordinates.len());
    let mut all = vec![potential];
    all.extend(others.iter().map(|parts| pool.sum(parts)));
    all.extend(model.constraints.iter().map(|own| own.expression));
    let zero = pool.zero();
    let mut values: Substitution = model.coordinates.iter().map(|own| (own.velocity, zero)).gather();
    let derived = model.parameters.iter().filter(|own| pool.as_symbol(own.symbolic) != Some(own.symbol));
    let derived: Substitution = derived.map(|own| (own.symbol, own.symbolic)).gather();
    let all = pool.substitute(&all, &derived);
    values.extend(known_values(&model));
    let all = pool.substitute(&all, &values);
    for symbol in pool.symbols_of(&all) {
        if let Some(number) = model.symbols.parameter(symbol)
            && !varying.contains(&number)
        {
            return Err(missing_value(&model, number));
        }
    }
    let (forces, constraints) = all[1..].split_at(model.coordinates.len());
    Ok(AtRest {
        coordinates: model.coordinates.iter().map(|own| own.symbol).collect(),
        parameters: varying.iter().map(|number| model.parameters[*number].symbol).collect(),
        potential: all[0],
        others: forces.to_vec(),
        constraints: constraints.to_vec(),
        turning: model.rates.iter().map(|rate| rate.is_some()).collect(),
        pool,
    })
}
