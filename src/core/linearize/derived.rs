//! From a model to its matrices as expressions: how the parts of this stage go together where nothing but a searched
//! equilibrium needs numbers.

use super::assemble::{self, Assembly, evaluate_closed};
use super::constrained::{Tied, with_multipliers};
use super::equilibrium::{Equilibrium, Search, short};
use super::multipliers;
use super::rolling::{self, SymbolicRolling};
use super::symbolic::{self, ConstantForce, SymbolicMatrices};
use super::{
    LinearizeError, SymbolicConstraints, at_equilibrium, by_hand, check_terms, check_time, in_own_numbers, steady,
    unbalanced, units, velocity,
};
use crate::expr::{ExprId, Pool, Substitution, ZeroVerdict};
use crate::model::Model;
use crate::order::Gather;
use crate::precision::Ball;

/// M, G, C, K and N of a model at its equilibrium, as expressions, and its constraints. Parameters need no values
/// unless the equilibrium has to be searched for. Assumptions are not used: [`Model::assumed`] is the model with them.
///
/// # Errors
/// As [`linearize`](super::linearize).
pub fn derive(model: Model) -> Result<SymbolicMatrices, LinearizeError> {
    derive_with_multipliers(&model).1
}

/// [`derive`](fn@derive), and under constraints the model with its multipliers, on whose expressions the matrices build.
pub(crate) fn derive_with_multipliers(model: &Model) -> (Option<Tied>, Result<SymbolicMatrices, LinearizeError>) {
    let tied = with_multipliers(model);
    let own = (!model.constraints.is_empty()).then(|| tied.clone());
    (own, derive_tied(tied))
}

/// Refuses constraints without a multiplier that do not hold at a point of expressions where the others do.
fn check_dependent(model: &Model, point: &[ExprId], dependent: &[usize]) -> Result<(), LinearizeError> {
    let mut pool = model.pool.clone();
    let coordinates = model.coordinates.iter().map(|own| own.symbol);
    let map: Substitution = coordinates.zip(point.iter().copied()).gather();
    for number in dependent {
        let constraint = &model.constraints[*number];
        let difference = pool.substitute_one(constraint.expression, &map);
        if pool.is_zero(difference) != ZeroVerdict::NonZero {
            continue;
        }
        let value: Option<Ball> = evaluate_closed(&pool, difference, ());
        let text = value.map_or_else(|| pool.display(difference), |value| short(value.mid_f64()));
        return Err(LinearizeError::ConstraintsContradict { difference: Some(text), span: constraint.span });
    }
    Ok(())
}

/// The equilibrium, in units of its own where numbers are far from usual ones.
fn search(own: &Search<'_>, dependent: &[usize]) -> Result<Equilibrium, LinearizeError> {
    let Search { model, assembly, values, visible, .. } = *own;
    let found = |own: &Search<'_>| {
        let (equilibrium, _) = unbalanced::find(own)?;
        if !model.constraints.is_empty() {
            at_equilibrium(own, &equilibrium, dependent.to_vec())?;
        }
        Ok(equilibrium)
    };
    let Some(units) = units::choose(model, assembly, values, visible) else { return found(own) };
    let mut own = model.clone();
    units.put_in(&mut own);
    let measured = assemble::assemble(&mut own);
    match found(&Search::new(&own, &measured, &measured.wide_values(&own)?, visible)) {
        Ok(mut equilibrium) => {
            equilibrium.values = units.positions(&equilibrium.values);
            Ok(equilibrium)
        }
        Err(error) => Err(in_own_numbers(error, || {
            found(&Search::new(model, assembly, &assembly.wide_values(model)?, visible)).map(|_| ())
        })),
    }
}

/// What an entry of M and one of K take, with the forms that they go through.
const ENTRY: usize = 16;

/// The equilibrium where parameters without values leave it open: coordinates stand as themselves, but for those that are given
/// and those that no force moves from 0, where the search would start.
///
/// # Errors
/// That a force acts there wherever the others are, beside what constraints, by their `expressions`, take up.
fn open_point(
    model: &mut Model,
    assembly: &Assembly,
    expressions: &[ExprId],
    missing: LinearizeError,
) -> Result<Vec<ExprId>, LinearizeError> {
    let coordinates = model.coordinates.iter().enumerate();
    let own = coordinates.map(|(i, own)| match model.equilibria.get(i) {
        Some(given) => given.symbolic,
        None => model.pool.symbol_expr(own.symbol),
    });
    let mut point: Vec<ExprId> = own.collect();
    let starts_at_zero = |i: usize| model.guesses.get(i).is_none_or(|guess| guess.symbolic.is_zero());
    let may_be_zero = |i: usize| model.equilibria.get(i).is_none() && starts_at_zero(i);
    let plain = point.clone();
    by_hand::put_in_zeros(model, assembly, &mut point, may_be_zero);
    let force = |pool: &Pool, point: &[ExprId]| ConstantForce::find(model, pool.clone(), assembly, point);
    let mut left = force(&model.pool, &point);
    if left.is_some() {
        point = plain;
        left = force(&model.pool, &point);
    }
    if left.is_none() && !expressions.is_empty() {
        let mut balanced = point.clone();
        let visible = point.len() - expressions.len();
        balanced[visible..].fill(model.pool.zero());
        let mut pool = model.pool.clone();
        if multipliers::put_in(model, assembly, &mut pool, &mut balanced, expressions).is_some() {
            left = force(&pool, &balanced);
        }
    }
    match left {
        Some(mut left) => {
            let given = model.equilibria.get(left.number).map(|given| given.span);
            let (own, force) = (model.coordinates.at(left.number), left.text());
            return Err(match given {
                Some(span) => {
                    LinearizeError::ForceOfParameters { coordinate: own.name(), force, unsigned: Vec::new(), span }
                }
                None if left.acts(model) => {
                    LinearizeError::NoEquilibrium { forces: vec![(format!("`{}`", own.name()), force)], span: own.span }
                }
                None => missing,
            });
        }
        None => by_hand::put_in_solved(model, assembly, &mut point, None),
    }
    Ok(point)
}

fn derive_tied(tied: Tied) -> Result<SymbolicMatrices, LinearizeError> {
    let expressions = tied.expressions();
    let Tied { mut model, visible, dependent, .. } = tied;
    check_time(&mut model)?;
    let order = model.coordinates.len();
    model.pool.budget().room(order.saturating_mul(order), ENTRY)?;
    velocity::check_smooth(&model)?;
    // A coordinate is cyclic by the energies, whatever constraints tie it to.
    let tied = model.potential.split_off(model.potential.len() - expressions.len());
    steady::put_rates_in(&mut model)?;
    model.potential.extend(tied);
    check_terms(&model)?;
    let mut assembly = assemble::assemble(&mut model);
    let guessed = model.guesses.any();
    let mut point = symbolic::stated(&model, false);
    let mut start = symbolic::stated(&model, true);
    let mut pool = std::mem::take(&mut model.pool);
    let determined = multipliers::put_in(&model, &assembly, &mut pool, &mut point, &expressions);
    let mut at_start = determined;
    if guessed {
        at_start = multipliers::put_in(&model, &assembly, &mut pool, &mut start, &expressions);
    } else {
        start.clone_from(&point);
    }
    model.pool = pool;
    let reactions = rolling::reactions(&mut model, &assembly);
    let settled = reactions.is_some()
        || at_start.is_some()
            && symbolic::forces_vanish(&model, &assembly, &start, &Substitution::default()) == Some(true);
    if settled {
        point = start;
        check_dependent(&model, &point[..visible], &dependent)?;
    }
    let mut at = vec![Ball::ZERO; order];
    let values = if settled { None } else { Some(assembly.values::<Ball>(&model, ())) };
    let mut open = false;
    if let Some(Err(missing)) = values {
        let undefined = assembly.undefined_in_symbols(&model, &point);
        let doubtful = || symbolic::doubtful_force(&model, &assembly, &point);
        let error = undefined.or_else(doubtful).filter(|_| !guessed);
        if error.is_some() || !model.rolling.is_empty() {
            return Err(error.unwrap_or(missing));
        }
        point = open_point(&mut model, &assembly, &expressions, missing)?;
        open = true;
    } else if let Some(Ok(values)) = values {
        let equilibrium = search(&Search::new(&model, &assembly, &values, visible), &dependent)?;
        let mut pool = std::mem::take(&mut model.pool);
        let multipliers = point.split_off(visible);
        point = symbolic::equilibrium_expressions(&model, &mut pool, &equilibrium);
        point.truncate(visible);
        if equilibrium.multipliers_given && !equilibrium.at_guess && determined.is_some() {
            point.extend(multipliers);
        } else {
            let symbols = model.coordinates.iter().skip(visible);
            point.extend(symbols.map(|own| pool.symbol_expr(own.symbol)));
        }
        model.pool = pool;
        by_hand::put_in_zeros(&model, &assembly, &mut point, |i| equilibrium.may_be_zero(i));
        by_hand::put_in_solved(&mut model, &assembly, &mut point, Some(&equilibrium.values[..visible]));
        at = equilibrium.values;
        by_hand::put_in_multipliers(&mut model, &assembly, &mut point, &expressions, &at);
    }
    assembly.forget_what_vanishes(&mut model, &point);
    let mut matrices = symbolic::matrices_at(&model, model.pool.clone(), &assembly, &point);
    matrices.open = open;
    if !settled && !open {
        let left = ConstantForce::find(&model, model.pool.clone(), &assembly, &point);
        matrices.at_values = left
            .and_then(|mut own| own.acts_nearby(&model).then(|| (model.coordinates.at(own.number).name(), own.text())));
    }
    if matrices.are_undefined()
        && let Some(error) = assembly.undefined_in_symbols(&model, &point)
    {
        return Err(error);
    }
    if !model.rolling.is_empty() {
        matrices.rolling = Some(SymbolicRolling::new(
            &model,
            &mut matrices,
            &point,
            &at,
            (visible, reactions.as_deref().unwrap_or_default()),
        )?);
    }
    if !expressions.is_empty() {
        matrices.first(visible);
        let gradients = multipliers::gradients(&model, &mut matrices.pool, &point[..visible], &expressions);
        matrices.constraints = Some(SymbolicConstraints { multipliers: point[visible..].to_vec(), gradients });
    }
    Ok(matrices)
}
