//! L written out as T2 + T1 - U with T2 = 1/2 sum A_ij(q, t) q_i' q_j' and T1 = sum b_i(q, t) q_i'.
//!
//! Every body is differentiated once by its velocities; its instances fill the slots. Terms that are
//! no such polynomial in the velocities (a relativistic mass) are kept as they are.

use std::collections::BTreeMap;

use super::simplify::Algebra;
use crate::expr::{ExprId, Pool, Substitution, Symbol};
use crate::linearize::{Splitter, Variable, elements, forces_of, instance, instances, signed_terms};
use crate::model::{Model, Symbols, TermFamily};
use crate::number::Number;
use crate::order::Gather;

/// The Lagrangian of a model, sorted by powers of the velocities.
#[derive(Clone, Debug, Default)]
pub(super) struct Lagrangian {
    /// A_ij, on and above the diagonal, those that are not 0.
    pub(super) inertia: BTreeMap<(usize, usize), ExprId>,
    /// b_i, those that are not 0.
    pub(super) linear: BTreeMap<usize, ExprId>,
    /// The derivatives of U = V - T0 by the coordinates, those that are not 0.
    pub(super) forces: BTreeMap<usize, ExprId>,
    /// The terms of U.
    pub(super) potential: Vec<ExprId>,
    /// Terms of L that are no quadratic polynomial in the velocities.
    pub(super) other: Vec<ExprId>,
    /// What friction, generalised forces and conditions add to the left sides of the equations, by coordinate, term by term.
    pub(super) drags: Vec<(usize, ExprId)>,
    /// Whether T0 is not 0 identically: U is more than V.
    pub(super) has_rest_energy: bool,
}

/// What the symbols of a model are.
pub(super) struct Variables {
    /// The coordinates, in order.
    pub(super) coordinates: Vec<Symbol>,
    /// Their velocities.
    pub(super) velocities: Vec<Symbol>,
    pub(super) symbols: Symbols,
    /// The time, where the model speaks of it.
    pub(super) time: Option<Symbol>,
}

impl Variables {
    pub(super) fn new(model: &Model) -> Self {
        let (coordinates, velocities) = model.coordinates.iter().map(|own| (own.symbol, own.velocity)).unzip();
        Self { coordinates, velocities, symbols: model.symbols.clone(), time: model.time() }
    }

    /// Whether a velocity occurs in an expression.
    pub(super) fn moves(&self, pool: &Pool, e: ExprId) -> bool {
        pool.depends_on(e, &|symbol| self.symbols.velocity(symbol).is_some())
    }

    /// The partial derivative by the time.
    pub(super) fn by_time(&self, pool: &mut Pool, e: ExprId) -> ExprId {
        if let Some(time) = self.time { pool.diff(e, time) } else { pool.zero() }
    }

    /// Puts all velocities to 0.
    pub(super) fn at_rest(&self, pool: &Pool) -> Substitution {
        self.velocities.iter().map(|v| (*v, pool.zero())).gather()
    }
}

/// A body by powers of its local velocities.
struct Body {
    /// By local numbers, the first not above the second.
    inertia: BTreeMap<(usize, usize), ExprId>,
    linear: BTreeMap<usize, ExprId>,
    /// Its share of U.
    potential: ExprId,
    /// The derivatives of that share by the local coordinates.
    forces: Vec<(usize, ExprId)>,
}

/// Sorts the terms of a model's Lagrangian by powers of the velocities.
pub(super) fn lagrangian(model: &Model, pool: &mut Algebra<'_>) -> Lagrangian {
    let mut splitter = Splitter::about(signed_terms(model).flat_map(|(_, family)| &family.locals));
    let mut inertia: BTreeMap<(usize, usize), Vec<ExprId>> = BTreeMap::new();
    let mut linear: BTreeMap<usize, Vec<ExprId>> = BTreeMap::new();
    let mut forces: BTreeMap<usize, Vec<ExprId>> = BTreeMap::new();
    let mut result = Lagrangian::default();
    for (negative, family) in signed_terms(model) {
        let share = if negative { pool.neg(family.body) } else { family.body };
        let Some(body) = body(pool, &mut splitter, family, share) else {
            result.other.extend(instances(model, pool, family, share, None));
            continue;
        };
        result.has_rest_energy |= !negative && !model.lagrangian && !body.potential.is_zero();
        let mut roots = vec![body.potential];
        roots.extend(body.inertia.values());
        roots.extend(body.linear.values());
        roots.extend(body.forces.iter().map(|(_, force)| *force));
        for at in 0..family.count {
            let map = instance(model, pool, family, at, None);
            let mut here = pool.substitute(&roots, &map).into_iter();
            let coordinates = family.coordinates_of(at);
            let number = |local: usize| coordinates.get(local).map_or(0, |i| *i as usize);
            if let Some(potential) = here.next()
                && !potential.is_zero()
            {
                result.potential.push(potential);
            }
            for ((a, b), value) in body.inertia.keys().zip(&mut here) {
                let (i, j) = (number(*a), number(*b));
                // Two slots that hold the same coordinate meet on the diagonal from both sides.
                let value = if a != b && i == j { pool.scale(value, &Number::from(2)) } else { value };
                inertia.entry((i.min(j), i.max(j))).or_default().push(value);
            }
            for (a, value) in body.linear.keys().zip(&mut here) {
                linear.entry(number(*a)).or_default().push(value);
            }
            for ((a, _), value) in body.forces.iter().zip(&mut here) {
                forces.entry(number(*a)).or_default().push(value);
            }
        }
    }
    result.inertia = added(pool, inertia);
    result.linear = added(pool, linear);
    result.forces = added(pool, forces);
    result
}

/// The sums in their shortest form, without those that are 0.
fn added<Key: Ord>(pool: &mut Algebra<'_>, parts: BTreeMap<Key, Vec<ExprId>>) -> BTreeMap<Key, ExprId> {
    let mut sums = BTreeMap::new();
    for (key, parts) in parts {
        let sum = pool.short(|pool| pool.sum(&parts));
        if !sum.is_zero() {
            sums.insert(key, sum);
        }
    }
    sums
}

/// Sorts one body; `None` where it is no quadratic polynomial in the velocities.
fn body(pool: &mut Algebra<'_>, splitter: &mut Splitter, family: &TermFamily, share: ExprId) -> Option<Body> {
    let velocities: Vec<Symbol> = family.locals.iter().map(|local| local.velocity).collect();
    let at_rest = family.at_rest(pool);
    let moving = splitter.facts.varies(pool, share, Variable::Velocity);
    let mut inertia: BTreeMap<(usize, usize), Vec<ExprId>> = BTreeMap::new();
    let mut linear: BTreeMap<usize, Vec<ExprId>> = BTreeMap::new();
    if moving {
        for element in elements(pool, splitter, share, &velocities, Variable::Velocity) {
            let mut moves = |e: ExprId| splitter.facts.varies(pool, e, Variable::Velocity);
            let stretched = !element.slope.is_empty() && moves(element.second)
                || (element.slope.iter().any(|(_, slope)| moves(*slope)) && !element.second.is_zero());
            let bent = !element.curvature.is_empty()
                && (moves(element.first) || element.curvature.iter().any(|(_, _, entry)| moves(*entry)));
            if stretched || bent {
                return None;
            }
            if !element.second.is_zero() {
                for (k, (a, left)) in element.slope.iter().enumerate() {
                    for (b, right) in element.slope.iter().skip(k) {
                        let value = pool.product(&[element.second, *left, *right]);
                        inertia.entry((*a, *b)).or_default().push(value);
                    }
                }
            }
            for (a, b, entry) in &element.curvature {
                inertia.entry((*a, *b)).or_default().push(pool.mul(element.first, *entry));
            }
            let mut entries = vec![element.first];
            entries.extend(element.slope.iter().map(|(_, slope)| *slope));
            let entries = pool.substitute(&entries, &at_rest);
            if let Some((first, slopes)) = entries.split_first() {
                for ((a, _), slope) in element.slope.iter().zip(slopes) {
                    linear.entry(*a).or_default().push(pool.mul(*first, *slope));
                }
            }
        }
    }
    let rest = splitter.at_rest(pool, share, &at_rest);
    if pool.is_undefined(rest) {
        return None;
    }
    let potential = pool.neg(rest);
    let facts = &splitter.facts;
    let slopes = pool.slopes(potential, |symbol| facts.is(symbol, Variable::Coordinate));
    let local = |symbol: Symbol| family.locals.iter().position(|local| local.coordinate == symbol);
    let forces: Vec<(usize, ExprId)> =
        slopes.into_iter().filter_map(|(symbol, slope)| Some((local(symbol)?, slope))).collect();
    Some(Body { inertia: added(pool, inertia), linear: added(pool, linear), potential, forces })
}

/// What Rayleigh's function and generalised forces add to the left sides of the equations, by coordinate, term by term.
pub(super) fn drags(model: &Model, pool: &mut Pool, variables: &Variables) -> Vec<(usize, ExprId)> {
    let mut drags = Vec::new();
    for family in &model.forces {
        if family.acts_on.is_some() {
            let forces = forces_of(model, pool, family);
            drags.extend(forces.into_iter().map(|(i, force)| (i, pool.neg(force))));
        } else {
            for term in instances(model, pool, family, family.body, None) {
                drags.extend(variables.symbols.velocity_slopes(pool, term));
            }
        }
    }
    drags
}
