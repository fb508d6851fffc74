//! The equations of motion of a model, compiled: M(q, t) q'' + h(q, q', t) = 0, with forces along the gradients of
//! constraints.
//!
//! With p_i = dL/dq_i' they are M_ij = dp_i/dq_j' and h_i = sum of dp_i/dq_j q_j' + dp_i/dt - dL/dq_i + dF/dq_i' (Landau and
//! Lifshitz, Mechanics, §5). A constraint c = 0 that holds at all times has c'' = J q'' + gamma = 0 with J = dc/dq; together
//! with M q'' + h = Jᵀ mu that determines q'' (E. Hairer, G. Wanner, Solving Ordinary Differential Equations 2, section 7.1).

use super::error::MotionError;
use crate::derive::Simplifier;
use crate::expr::{ExprId, Pool, Substitution, Symbol, Tape};
use crate::linearize::{
    derive_with_multipliers, known_values, missing_value, signed_terms, written_out,
};
use crate::model::{Model, SymbolKind};
use crate::number::Number;

/// Terms beyond this are not written out.
const MOST_TERMS: usize = 200_000;
/// Equations of more parts than this are left as they are.
const MOST_SHORTENED: usize = 400;

/// The equations as tapes over the time, the coordinates and the velocities.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    pub(super) coordinates: usize,
    pub(super) constraints: usize,
    /// Where the first outputs belong: the entries of M on and above its diagonal that are not 0.
    pub(super) mass: Vec<(usize, usize)>,
    /// Behind M and h, the entries of J that are not 0: constraint and coordinate. Then gamma follows.
    pub(super) gradients: Vec<(usize, usize)>,
    /// Whether M and J are the same everywhere.
    pub(super) constant: bool,
    /// M, h, J, gamma.
    pub(super) tape: Tape,
    /// c, and c' in the velocities.
    pub(super) surface: Tape,
    /// The energy function, where it is conserved.
    pub(super) energy: Option<Tape>,
}

impl Equations {
    /// Writes the equations out, with the values of the parameters.
    ///
    /// # Errors
    /// Parameters without a value, and models with too many terms.
    pub(super) fn new(model: &Model) -> Result<Self, MotionError> {
        let families = model.kinetic.iter().chain(&model.potential);
        let families = families.chain(&model.friction);
        let terms: usize = families.map(|family| family.count).sum();
        if terms > MOST_TERMS {
            return Err(MotionError::TooLarge {
                terms,
                most: MOST_TERMS,
            });
        }
        let mut pool = model.pool.clone();
        let known = known_values(model);
        let lagrangian = written_out(model, &mut pool, signed_terms(model), &known);
        let friction = model.friction.iter().map(|family| (false, family));
        let friction = written_out(model, &mut pool, friction, &known);
        let coordinates: Vec<Symbol> = model.coordinates.iter().map(|c| c.symbol).collect();
        let velocities: Vec<Symbol> = model.coordinates.iter().map(|c| c.velocity).collect();
        let n = coordinates.len();
        let kind = |symbol: Symbol| model.symbols.get(&symbol).copied();
        let is_coordinate = |symbol| matches!(kind(symbol), Some(SymbolKind::Coordinate(_)));
        let is_velocity = |symbol| matches!(kind(symbol), Some(SymbolKind::Velocity(_)));
        let number = |symbol| match kind(symbol) {
            Some(
                SymbolKind::Coordinate(at) | SymbolKind::Velocity(at) | SymbolKind::Parameter(at),
            ) => at,
            _ => usize::MAX,
        };
        let time = model.time();
        let time = time.unwrap_or_else(|| pool.fresh_symbol("t"));
        let speed: Vec<ExprId> = velocities.iter().map(|v| pool.symbol_expr(*v)).collect();

        let forces = pool.gradient(lagrangian, &coordinates);
        let momenta = pool.gradient(lagrangian, &velocities);
        let drags = pool.gradient(friction, &velocities);
        let mut mass = Vec::new();
        let mut inertia = Vec::new();
        let mut loads = Vec::new();
        for i in 0..n {
            for (symbol, value) in pool.slopes(momenta[i], is_velocity) {
                let j = number(symbol);
                if i <= j && !is_zero(&pool, value) {
                    mass.push((i, j));
                    inertia.push(value);
                }
            }
            let mut parts = vec![drags[i], pool.diff(momenta[i], time)];
            for (symbol, slope) in pool.slopes(momenta[i], is_coordinate) {
                parts.push(pool.mul(slope, speed[number(symbol)]));
            }
            parts.push(pool.neg(forces[i]));
            loads.push(pool.sum(&parts));
        }

        let constraints = constraints(model, &mut pool, &known);
        let mut gradients = Vec::new();
        let mut slopes = Vec::new();
        let mut bends = Vec::new();
        let mut surface = constraints.clone();
        for (a, constraint) in constraints.iter().enumerate() {
            let mut rate = vec![pool.diff(*constraint, time)];
            for (symbol, slope) in pool.slopes(*constraint, is_coordinate) {
                gradients.push((a, number(symbol)));
                slopes.push(slope);
                rate.push(pool.mul(slope, speed[number(symbol)]));
            }
            let rate = pool.sum(&rate);
            surface.push(rate);
            let mut bend = vec![pool.diff(rate, time)];
            for (symbol, slope) in pool.slopes(rate, is_coordinate) {
                bend.push(pool.mul(slope, speed[number(symbol)]));
            }
            bends.push(pool.sum(&bend));
        }

        let constant = [&inertia, &slopes].iter().all(|values| {
            let mut values = values.iter();
            values.all(|e| {
                !pool.depends_on(*e, &|symbol| {
                    symbol == time || kind(symbol).is_some_and(moves)
                })
            })
        });
        let mut inputs = vec![time];
        inputs.extend(coordinates.iter().chain(&velocities));
        let mut outputs: Vec<ExprId> = [inertia, loads, slopes, bends].concat();
        shorten(&mut pool, &mut outputs);
        let compile = |pool: &Pool, roots: &[ExprId]| {
            Tape::compile(pool, roots, &inputs).map_err(|missing| {
                // All that is no input is a parameter.
                MotionError::Linearize(missing_value(model, number(missing.symbol)))
            })
        };
        let conserved = model.friction.is_empty() && model.time_dependent.is_none();
        let energy = conserved.then(|| {
            let products = momenta.iter().zip(&speed);
            let mut parts: Vec<ExprId> = products.map(|(p, v)| pool.mul(*p, *v)).collect();
            parts.push(pool.neg(lagrangian));
            pool.sum(&parts)
        });
        Ok(Self {
            coordinates: n,
            constraints: constraints.len(),
            mass,
            gradients,
            constant,
            tape: compile(&pool, &outputs)?,
            surface: compile(&pool, &surface)?,
            energy: energy.map(|e| compile(&pool, &[e])).transpose()?,
        })
    }
}

/// Brings small equations to their shortest form: what is left of cos a cos b + sin a sin b is computed in every order
/// of every step. Many coordinates have short equations as they stand, or none that could be found in time.
fn shorten(pool: &mut Pool, equations: &mut Vec<ExprId>) {
    let before = pool.reachable(equations).len();
    if before > MOST_SHORTENED {
        return;
    }
    let mut short = Simplifier::default();
    let shorter: Vec<ExprId> = equations.iter().map(|e| short.simplify(pool, *e)).collect();
    if pool.reachable(&shorter).len() < before {
        *equations = shorter;
    }
}

fn moves(kind: SymbolKind) -> bool {
    matches!(kind, SymbolKind::Coordinate(_) | SymbolKind::Velocity(_))
}

fn is_zero(pool: &Pool, e: ExprId) -> bool {
    pool.as_number(e).is_some_and(Number::is_zero)
}

/// The independent constraints, with the values of the parameters.
fn constraints(model: &Model, pool: &mut Pool, known: &Substitution) -> Vec<ExprId> {
    if model.constraints.is_empty() {
        return Vec::new();
    }
    let (tied, _) = derive_with_multipliers(model);
    let kept = tied.map_or_else(Vec::new, |tied| tied.expressions());
    pool.substitute(&kept, known)
}
