//! Whether a model depends on the time. What merely contains `t` does not: a body that is turned about the vertical.

use super::coordinates::Symbols;
use super::elaborate::Elaborator;
use super::integral::along_path;
use super::names::World;
use super::terms::{Local, TermFamily};
use super::{Constraint, Model};
use crate::expr::{ExprId, Node, Pool, Substitution, Symbol};
use crate::number::Number;
use crate::precision::Function;
use crate::span::Span;

impl Elaborator<'_> {
    /// Puts t = 0 where the time drops out identically: of a term, or of all the terms of an energy that have one instance.
    pub(super) fn drop_time(&mut self, energies: [&mut Vec<TermFamily>; 3], forces: &mut [TermFamily]) {
        let Some(time) = self.world.time else { return };
        for force in forces {
            drop_from(&mut self.world, time, &mut [force]);
        }
        for energy in energies {
            let (mut single, several): (Vec<_>, Vec<_>) =
                energy.iter_mut().partition(|own| is_single(&self.world.kinds, own));
            if !drop_from(&mut self.world, time, &mut single) && single.len() > 1 {
                single.into_iter().for_each(|own| _ = drop_from(&mut self.world, time, &mut [own]));
            }
            several.into_iter().for_each(|own| _ = drop_from(&mut self.world, time, &mut [own]));
        }
    }

    /// Where the time is in an energy, a force or a constraint.
    pub(super) fn time_dependence(&self, energies: &[&Vec<TermFamily>], constraints: &[Constraint]) -> Option<Span> {
        let time = self.world.time?;
        let terms = energies.iter().flat_map(|families| families.iter());
        let terms = terms.map(|family| (family.body, family.span));
        let conditions = constraints.iter().map(|constraint| (constraint.expression, constraint.span));
        terms.chain(conditions).find_map(|(e, span)| {
            let symbols = self.world.pool.symbols_of(&[e]);
            symbols.contains(&time).then_some(span)
        })
    }
}

/// Whether a term is in the symbols of the coordinates themselves, so that it may be added to others of this kind.
fn is_single(kinds: &Symbols, family: &TermFamily) -> bool {
    let shared = |local: &Local| kinds.coordinate(local.coordinate).is_some();
    family.count == 1 && family.values.is_empty() && family.locals.iter().all(shared)
}

/// Puts t = 0 into terms whose sum is the same at all times; whether that is so.
fn drop_from(world: &mut World, time: Symbol, terms: &mut [&mut TermFamily]) -> bool {
    let pool = &mut world.pool;
    let bodies: Vec<ExprId> = terms.iter().map(|own| own.body).collect();
    if !bodies.iter().any(|body| pool.depends_on(*body, &|symbol| symbol == time)) {
        return true;
    }
    // Not by a derivative, which vanishes for square waves, too.
    let at_start = pool.substitute(&bodies, &Substitution::from([(time, pool.zero())]));
    let (now, then) = (pool.sum(&bodies), pool.sum(&at_start));
    let drops = pool.agree(now, then);
    if drops {
        terms.iter_mut().zip(at_start).for_each(|(own, body)| own.body = body);
    }
    drops
}

impl Model {
    /// Puts t = 0 in, where the equations of motion are the same at all times though the energies are not: those of a pendulum in
    /// an accelerating car. A term f(q, q', t) - f(q, q', 0) = Σ b_i q_i' + c with ∂b_i/∂q_j = ∂b_j/∂q_i adds ∂b_i/∂t - ∂c/∂q_i to
    /// the equation of q_i; where that does not depend on the time it becomes a potential, or a force where none is found. False, and
    /// nothing is changed, where the time matters.
    pub(crate) fn drop_time(&mut self) -> bool {
        if self.time_dependent.is_none() {
            return true;
        }
        let Some(time) = self.symbols.time() else { return false };
        let mut pool = self.pool.clone();
        let others = self.forces.iter().map(|own| own.body).chain(self.constraints.iter().map(|own| own.expression));
        let mut others = others.chain(self.rolling.iter().map(|own| own.expression));
        if others.any(|e| pool.depends_on(e, &|symbol| symbol == time)) {
            return false;
        }
        let (mut kinetic, mut potential, mut forces) =
            (self.kinetic.clone(), self.potential.clone(), self.forces.clone());
        let start = Substitution::from([(time, pool.zero())]);
        // L, term by term, but those in the symbols of the coordinates themselves together.
        let mut together: Option<TermFamily> = None;
        let mut terms = Vec::new();
        for (sign, family) in kinetic.iter_mut().map(|own| (1, own)).chain(potential.iter_mut().map(|own| (-1, own))) {
            if !pool.depends_on(family.body, &|symbol| symbol == time) {
                continue;
            }
            let body = pool.scale(family.body, &Number::from(sign));
            if is_single(&self.symbols, family) {
                let sum = together
                    .get_or_insert_with(|| TermFamily::single(family.span, pool.zero(), Vec::new(), Vec::new()));
                sum.body = pool.add(sum.body, body);
                for (local, number) in family.locals.iter().zip(&family.coordinates) {
                    if !sum.coordinates.contains(number) {
                        sum.locals.push(*local);
                        sum.coordinates.push(*number);
                    }
                }
            } else {
                terms.push(TermFamily { body, ..family.clone() });
            }
            family.body = pool.substitute_one(family.body, &start);
        }
        for family in terms.into_iter().chain(together) {
            let Some(slopes) = slopes_of_time(&mut pool, &family, time) else { return false };
            if let Some(body) = potential_of(&mut pool, &family, &slopes) {
                potential.push(TermFamily { body, ..family });
                continue;
            }
            for (place, slope) in slopes {
                forces.push(TermFamily { body: pool.neg(slope), acts_on: Some(place), ..family.clone() });
                self.force.get_or_insert(family.span);
            }
        }
        (self.kinetic, self.potential, self.forces, self.pool) = (kinetic, potential, forces, pool);
        self.time_dependent = None;
        true
    }
}

/// A function of the coordinates of a term whose derivatives are these, by their places; `None` where none is found.
fn potential_of(pool: &mut Pool, family: &TermFamily, slopes: &[(usize, ExprId)]) -> Option<ExprId> {
    let path = slopes.iter().map(|(place, slope)| (family.locals[*place].coordinate, [pool.zero(), *slope]));
    let path: Vec<(Symbol, [ExprId; 2])> = path.collect();
    let sum = along_path(pool, &path)?;
    let is_right = slopes.iter().all(|(place, slope)| {
        let own = pool.diff(sum, family.locals[*place].coordinate);
        pool.agree(own, *slope)
    });
    is_right.then_some(sum)
}

/// What a term of L adds to the equations beyond what it adds with t = 0, by the places of its coordinates. `None` where this depends on the
/// time or on velocities, or is not smooth.
fn slopes_of_time(pool: &mut Pool, family: &TermFamily, time: Symbol) -> Option<Vec<(usize, ExprId)>> {
    let depends = |pool: &Pool, e: ExprId| pool.depends_on(e, &|symbol| symbol == time);
    // Derivatives of square waves vanish, though these do not stay the same.
    let jumps = [Function::Abs, Function::Asin, Function::Acos, Function::Atan, Function::Tan];
    let may_jump = |id: ExprId| match pool.node(id) {
        Node::Function(function, x) => jumps.contains(function) && depends(pool, *x),
        Node::Atan2 { .. } => depends(pool, id),
        Node::Product(factors) => factors.iter().any(|(base, exponent)| {
            let is_power = exponent.is_integer() && !exponent.is_negative();
            !is_power && !pool.is_nonnegative(*base) && depends(pool, *base)
        }),
        Node::Number(_) | Node::Pi | Node::Symbol(_) | Node::Sum { .. } | Node::Power { .. } | Node::Undefined => false,
    };
    if pool.reachable(&[family.body]).into_iter().any(may_jump) {
        return None;
    }
    let start = Substitution::from([(time, pool.zero())]);
    let at_start = pool.substitute_one(family.body, &start);
    let change = pool.sub(family.body, at_start);
    let at_rest = family.at_rest(pool);
    let rest = pool.substitute_one(change, &at_rest);
    let by_velocities: Vec<ExprId> = family.locals.iter().map(|own| pool.diff(change, own.velocity)).collect();
    let mut slopes = Vec::new();
    for (place, own) in family.locals.iter().enumerate() {
        let by_velocity = by_velocities[place];
        for (other, by_other) in family.locals.iter().zip(&by_velocities) {
            let bend = pool.diff(by_velocity, other.velocity);
            let (one, two) = (pool.diff(by_velocity, other.coordinate), pool.diff(*by_other, own.coordinate));
            if !pool.vanishes(bend) || !pool.agree(one, two) {
                return None;
            }
        }
        let (gain, pull) = (pool.diff(by_velocity, time), pool.diff(rest, own.coordinate));
        let slope = pool.sub(gain, pull);
        let first = pool.substitute_one(slope, &start);
        let first = pool.substitute_one(first, &at_rest);
        if !pool.agree(slope, first) {
            return None;
        }
        if !pool.vanishes(first) {
            slopes.push((place, first));
        }
    }
    Some(slopes)
}
