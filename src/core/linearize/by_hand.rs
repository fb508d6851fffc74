//! Equilibria by hand: coordinates that no force moves from 0, those that linear equations determine, and those whose equation has a
//! root that can be written down. Of what is left to a search the coordinates stand as themselves.

use std::collections::HashMap;

use super::assemble::{Assembly, evaluate_closed};
use super::parameters::{Formulas, known_values};
use super::roots::roots;
use super::symbolic::forces;
use crate::expr::{ExprId, Node, Pool, Substitution, Symbol, ZeroVerdict};
use crate::model::{Coordinate, Model};
use crate::precision::{Ball, Big, Function, Scalar};

/// So many coordinates are tried for zeros.
const MOST_ZEROS: usize = 60;

/// Puts 0 in for those coordinates of an equilibrium that may be 0, where the forces on them vanish identically once they are:
/// a plane that the motion can stay in, say.
pub(super) fn put_in_zeros(model: &Model, assembly: &Assembly, point: &mut [ExprId], may_be: impl Fn(usize) -> bool) {
    let mut zeros: Vec<usize> = (0..model.coordinates.len()).filter(|i| may_be(*i)).collect();
    while (1..=MOST_ZEROS).contains(&zeros.len()) {
        let mut trial = point.to_vec();
        for i in &zeros {
            trial[*i] = model.pool.zero();
        }
        let Some((pool, forces)) = forces(model, model.pool.clone(), assembly, &trial) else { return };
        let tried = zeros.len();
        zeros.retain(|i| forces.get(&(*i as u32)).is_none_or(|force| pool.vanishes(*force)));
        if zeros.len() == tried {
            point.copy_from_slice(&trial);
            return;
        }
    }
}

/// So many coordinates are solved for.
const MOST_SOLVED: usize = 8;
/// Values of more symbols are no shorter than the name of the coordinate.
const LONGEST: usize = 24;
/// Bits of the numbers that values are compared in.
const BITS: usize = 192;

/// Puts in what the forces say of coordinates that stand as themselves, one after the other: where the force on one is linear in it
/// and depends on no other. `at` has what a search found, to compare with, and to tell roots apart where it is not linear; without it
/// nothing is left to compare.
pub(super) fn put_in_solved(model: &mut Model, assembly: &Assembly, point: &mut [ExprId], at: Option<&[Ball]>) {
    let coordinates = || model.coordinates.iter().enumerate();
    let itself =
        |(i, own): (usize, Coordinate)| (model.pool.as_symbol(point[i]) == Some(own.symbol)).then_some((i, own.symbol));
    let open: Vec<(usize, Symbol)> = coordinates().filter_map(itself).collect();
    if !(1..=MOST_SOLVED).contains(&open.len()) {
        return;
    }
    let Some((mut pool, forces)) = forces(model, model.pool.clone(), assembly, point) else { return };
    let equation = |(i, symbol): &(usize, Symbol)| Some((*i, *symbol, *forces.get(&(*i as u32))?));
    let mut equations: Vec<(usize, Symbol, ExprId)> = open.iter().filter_map(equation).collect();
    if let Some(at) = at {
        let all: Vec<ExprId> = equations.iter().map(|(_, _, force)| *force).collect();
        let signed = signed_there(model, &mut pool, &all, at);
        for ((_, _, force), own) in equations.iter_mut().zip(pool.replaced(&all, &signed)) {
            *force = own;
        }
    }
    let values = known_values(model);
    let mut solved: Vec<(usize, Symbol, ExprId)> = Vec::new();
    let depends = |pool: &Pool, e: ExprId| pool.depends_on(e, &|symbol| open.iter().any(|(_, own)| *own == symbol));
    while let Some((place, value)) = (0..equations.len()).find_map(|place| {
        let (i, symbol, force) = equations[place];
        let others = |other| other != symbol && open.iter().any(|(_, own)| *own == other);
        let value = linear(&mut pool, symbol, force, &depends).or_else(|| {
            let here = at?.get(i)?;
            (!pool.depends_on(force, &others)).then(|| root(&mut pool, symbol, force, here, &values))?
        })?;
        Some((place, value))
    }) {
        let (i, symbol, _) = equations.swap_remove(place);
        let known = Substitution::from([(symbol, value)]);
        equations.iter_mut().chain(&mut solved).for_each(|(_, _, e)| *e = pool.substitute_one(*e, &known));
        solved.push((i, symbol, value));
    }
    // Of a family of equilibria the others follow those that stay open: nothing is left to be solved for these.
    let is_family = at.is_some() && equations.iter().all(|(_, _, force)| pool.vanishes(*force));
    model.pool = pool;
    for (i, _, value) in solved {
        let open = depends(&model.pool, value);
        if open && !is_family || model.pool.reachable(&[value]).len() > LONGEST {
            continue;
        }
        let agrees = |found: &Ball| match open {
            true => number_there(model, &model.pool, value, at.unwrap_or_default())
                .is_some_and(|own| own.sub(&Big::from_ball(found, BITS)).contains_zero()),
            false => agrees(&mut model.pool, value, found, &values),
        };
        // A multiplier was not found beside the coordinates.
        if at.and_then(|at| at.get(i)).map_or(!open, agrees) {
            point[i] = value;
        }
    }
}

/// What an expression in coordinates is where these were found.
fn number_there(model: &Model, pool: &Pool, e: ExprId, at: &[Ball]) -> Option<Big> {
    let at: Vec<Big> = at.iter().map(|x| Big::from_ball(x, BITS)).collect();
    Formulas::new(model, pool, &[e])?.at(model, &at, BITS)?.into_iter().next().filter(Big::is_finite)
}

/// For absolute values what stands in the bars, with the sign that it has there.
fn signed_there(model: &Model, pool: &mut Pool, all: &[ExprId], at: &[Ball]) -> HashMap<ExprId, ExprId> {
    let mut signed = HashMap::new();
    for id in pool.reachable(all) {
        let Node::Function(Function::Abs, inner) = *pool.node(id) else { continue };
        match number_there(model, pool, inner, at) {
            Some(number) if number.is_positive() => signed.insert(id, inner),
            Some(number) if number.is_negative() => signed.insert(id, pool.neg(inner)),
            Some(_) | None => None,
        };
    }
    signed
}

/// The root of a force that is linear in a coordinate.
fn linear(pool: &mut Pool, symbol: Symbol, force: ExprId, depends: &impl Fn(&Pool, ExprId) -> bool) -> Option<ExprId> {
    let slope = pool.diff(force, symbol);
    if depends(pool, slope) || pool.is_zero(slope) != ZeroVerdict::NonZero {
        return None;
    }
    let zero = pool.zero();
    let rest = pool.substitute_one(force, &Substitution::from([(symbol, zero)]));
    // Not so for what jumps where it is 0.
    let (itself, rest) = (pool.symbol_expr(symbol), pool.neg(rest));
    let (linear, value) = (pool.mul(slope, itself), pool.div(rest, slope));
    let difference = pool.sub(force, linear);
    let difference = pool.add(difference, rest);
    pool.vanishes(difference).then_some(value)
}

/// Whether an expression is a number that was found, at the values of the parameters.
fn agrees(pool: &mut Pool, value: ExprId, found: &Ball, values: &Substitution) -> bool {
    let number = pool.substitute_one(value, values);
    let number: Option<Big> = evaluate_closed(pool, number, BITS);
    let off = number.map(|number| number.to_far_ball() - *found);
    off.is_some_and(|off| off.is_finite() && off.contains_zero())
}

/// The shortest root of a force that is where a search found it.
fn root(pool: &mut Pool, symbol: Symbol, force: ExprId, here: &Ball, values: &Substitution) -> Option<ExprId> {
    // Its size is known where its sign is.
    let place = pool.symbol_expr(symbol);
    let size = pool.apply(Function::Abs, place);
    let signed = if here.is_negative() { pool.neg(place) } else { place };
    let force = *pool.replaced(&[force], &HashMap::from([(size, signed)])).first()?;
    let mut all = roots(pool, symbol, force);
    all.retain(|own| agrees(pool, *own, here, values));
    let shortest = all.into_iter().min_by_key(|own| pool.reachable(&[*own]).len())?;
    (pool.reachable(&[shortest]).len() <= LONGEST).then_some(shortest)
}
