//! Whether a model depends on the time. What merely contains `t` does not: a body that is turned about the vertical.

use super::Constraint;
use super::elaborate::Elaborator;
use super::names::{SymbolKind, World};
use super::terms::TermFamily;
use crate::expr::{ExprId, Substitution, Symbol, ZeroVerdict};
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
                energy.iter_mut().partition(|own| is_single(&self.world, own));
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
fn is_single(world: &World, family: &TermFamily) -> bool {
    let shared = |local: &super::Local| matches!(world.kinds.get(local.coordinate), Some(SymbolKind::Coordinate(_)));
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
    let then = pool.neg(then);
    let change = pool.add(now, then);
    let drops = pool.is_zero(change) == ZeroVerdict::Zero;
    if drops {
        terms.iter_mut().zip(at_start).for_each(|(own, body)| own.body = body);
    }
    drops
}
