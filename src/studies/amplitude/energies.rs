//! L = T2 - U of a model, compiled to gradients: what is linear in the velocities is proved to move nothing.

use super::error::AmplitudeError;
use crate::mechanics::{Mechanics, beside_energies, is_gradient};
use crate::source;
use librate_core::expr::{ExprId, Pool, Substitution, Symbol, Tape};
use librate_core::linearize::{instance, known_values, signed_terms};
use librate_core::model::Model;
use librate_core::number::Number;
use librate_core::order::Gather;
use librate_core::span::Span;

/// Terms beyond this are not written out.
const MOST_TERMS: usize = 200_000;

/// Refuses what is not covered, before anything is computed.
///
/// # Errors
/// Explicit time, friction, constraints and steady motions, and more terms than are written out.
pub fn check(model: &Model) -> Result<(), AmplitudeError> {
    if let Some((feature, span)) = beside_energies(model) {
        return Err(AmplitudeError::Unsupported { feature, span });
    }
    let terms = Mechanics::terms(model);
    if terms > MOST_TERMS { Err(AmplitudeError::TooLarge { terms, most: MOST_TERMS }) } else { Ok(()) }
}

/// Gradients of U = V - T0 and of T2, with the values of the parameters.
pub(super) struct Energies {
    /// ∂U/∂q as functions of q.
    pub(super) potential: Tape,
    /// ∂T2/∂q, then ∂T2/∂q', as functions of q and q'; `None` where the masses are the same everywhere.
    pub(super) kinetic: Option<Tape>,
}

impl Energies {
    pub(super) fn new(model: &Model) -> Result<Self, AmplitudeError> {
        let mut pool = model.pool.clone();
        let mut parts = Parts::of(model, &mut pool)?;
        let small = pool.with_small_exponentials(&[parts.kinetic, parts.potential]);
        if let [kinetic, potential] = small.as_slice() {
            (parts.kinetic, parts.potential) = (*kinetic, *potential);
        }
        if let Some(span) = parts.linear_span
            && acts(model, &mut pool, parts.linear)
        {
            return Err(AmplitudeError::Gyroscopic { span });
        }
        let coordinates: Vec<Symbol> = model.coordinates.iter().map(|c| c.symbol).collect();
        let velocities: Vec<Symbol> = model.coordinates.iter().map(|c| c.velocity).collect();
        let compile = |pool: &Pool, roots: &[ExprId], inputs: &[Symbol]| {
            Tape::compile(pool, roots, inputs)
                .map_err(|unbound| AmplitudeError::Linearize(source::missing(model, &unbound)))
        };
        let forces = pool.gradient(parts.potential, &coordinates);
        let potential = compile(&pool, &forces, &coordinates)?;
        let moves = |symbol| model.symbols.coordinate(symbol).is_some();
        let kinetic = if pool.depends_on(parts.kinetic, &moves) {
            let mut roots = pool.gradient(parts.kinetic, &coordinates);
            roots.extend(pool.gradient(parts.kinetic, &velocities));
            Some(compile(&pool, &roots, &[coordinates, velocities].concat())?)
        } else {
            None
        };
        Ok(Self { potential, kinetic })
    }
}

/// L = T2 + T1 - U by powers of the velocities.
struct Parts {
    kinetic: ExprId,
    linear: ExprId,
    /// The first term that is not 0 in T1.
    linear_span: Option<Span>,
    potential: ExprId,
}

impl Parts {
    /// The parts of each body are those of its power series in a factor of all velocities, which has to end with the
    /// square.
    fn of(model: &Model, pool: &mut Pool) -> Result<Self, AmplitudeError> {
        let known = known_values(model);
        let factor = pool.fresh_symbol("factor");
        let scale = pool.symbol_expr(factor);
        let zero = pool.zero();
        let at_rest = Substitution::from([(factor, zero)]);
        let mut sums: [Vec<ExprId>; 3] = Default::default();
        let mut linear_span = None;
        for (negative, family) in signed_terms(model) {
            let velocities: Vec<Symbol> = family.locals.iter().map(|local| local.velocity).collect();
            let is_velocity = |symbol| velocities.contains(&symbol);
            let bodies = if pool.depends_on(family.body, &is_velocity) {
                let scaled: Substitution = velocities.iter().map(|own| (*own, pool.times(scale, *own))).gather();
                let whole = pool.substitute_one(family.body, &scaled);
                let once = pool.diff(whole, factor);
                let twice = pool.diff(once, factor);
                let third = pool.diff(twice, factor);
                if !pool.vanishes(third) {
                    let span = family.span;
                    return Err(AmplitudeError::NotQuadratic { span });
                }
                let twice = pool.scale(twice, &Number::ratio(1, 2).unwrap_or_default());
                let mut parts = pool.substitute(&[whole, once, twice], &at_rest);
                if let Some(once) = parts.get_mut(1) {
                    if pool.vanishes(*once) {
                        *once = zero;
                    } else {
                        linear_span.get_or_insert(family.span);
                    }
                }
                parts
            } else {
                vec![family.body, zero, zero]
            };
            for at in 0..family.count {
                let map = instance(model, pool, family, at, None);
                let terms = pool.substitute(&bodies, &map);
                for (sum, term) in sums.iter_mut().zip(terms).filter(|(_, term)| *term != zero) {
                    sum.push(if negative { pool.neg(term) } else { term });
                }
            }
        }
        let [rest, once, twice] = sums.map(|terms| {
            let sum = pool.sum(&terms);
            pool.substitute_one(sum, &known)
        });
        Ok(Self { kinetic: twice, linear: once, linear_span, potential: pool.neg(rest) })
    }
}

/// Whether b(q)·q' has a curl somewhere, or may have one: where it has none it is the derivative of a function of q by the time
/// and moves nothing.
fn acts(model: &Model, pool: &mut Pool, linear: ExprId) -> bool {
    let mut rows = vec![Vec::new(); model.coordinates.len()];
    for (row, factor) in model.symbols.velocity_slopes(pool, linear) {
        rows[row] = model.symbols.slopes(pool, factor);
    }
    !is_gradient(pool, &rows)
}
