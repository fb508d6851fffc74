//! Equilibria by hand: coordinates that no force moves from 0, those that linear equations determine, and those whose equation has a
//! root that can be written down. Of what is left to a search the coordinates stand as themselves.

use hashbrown::HashMap;

use super::assemble::Assembly;
use super::multipliers;
use super::parameters::Formulas;
use super::roots::roots;
use super::symbolic::forces;
use crate::expr::{ExprId, Node, Pool, Substitution, Symbol, ZeroVerdict};
use crate::model::{Coordinate, Model};
use crate::precision::{Ball, Big, Function};

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
/// Nor are those of so many for multipliers.
const LONGEST_MULTIPLIER: usize = 40;
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
    let mut solved: Vec<(usize, Symbol, ExprId)> = Vec::new();
    let depends = |pool: &Pool, e: ExprId| pool.depends_on(e, &|symbol| open.iter().any(|(_, own)| *own == symbol));
    while let Some((place, value)) = (0..equations.len()).find_map(|place| {
        let (i, symbol, force) = equations[place];
        let others = |other| other != symbol && open.iter().any(|(_, own)| *own == other);
        let value = linear(&mut pool, symbol, force, &depends)
            .or_else(|| (!pool.depends_on(force, &others)).then(|| root(model, &mut pool, i, force, at?))?)?;
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
        // A multiplier was not found beside the coordinates.
        let at = at.filter(|at| i < at.len());
        if at.map_or(!open, |at| agrees(model, &model.pool, value, at, i)) {
            point[i] = value;
        }
    }
}

/// Puts in what the forces say of multipliers, behind the coordinates, that stand as themselves, where that is short and holds at the point
/// that was found.
pub(super) fn put_in_multipliers(
    model: &mut Model,
    assembly: &Assembly,
    point: &mut Vec<ExprId>,
    expressions: &[ExprId],
    at: &[Ball],
) {
    let behind = point.len() - expressions.len()..point.len();
    let mut pool = std::mem::take(&mut model.pool);
    let mut balanced = point.clone();
    balanced[behind.clone()].fill(pool.zero());
    let found = multipliers::put_in(model, assembly, &mut pool, &mut balanced, expressions);
    model.pool = pool;
    let holds = |i: usize| {
        let is_short = model.pool.reachable(&[balanced[i]]).len() <= LONGEST_MULTIPLIER;
        is_short && agrees(model, &model.pool, balanced[i], at, i)
    };
    if found.is_some() && behind.into_iter().all(holds) {
        *point = balanced;
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

/// Whether an expression is what was found for a coordinate, where all were found.
fn agrees(model: &Model, pool: &Pool, value: ExprId, at: &[Ball], i: usize) -> bool {
    let off = number_there(model, pool, value, at).map(|number| number.to_far_ball() - at[i]);
    off.is_some_and(|off| off.is_finite() && off.contains_zero())
}

/// The shortest root of a force that is where a search found it.
fn root(model: &Model, pool: &mut Pool, i: usize, force: ExprId, at: &[Ball]) -> Option<ExprId> {
    let (symbol, here) = (model.coordinates.at(i).symbol, at.get(i)?);
    // Its size is known where its sign is.
    let place = pool.symbol_expr(symbol);
    let size = pool.apply(Function::Abs, place);
    let signed = if here.is_negative() { pool.neg(place) } else { place };
    let force = *pool.replaced(&[force], &HashMap::from([(size, signed)])).first()?;
    let mut all = roots(pool, symbol, force);
    all.retain(|own| agrees(model, pool, *own, at, i));
    let shortest = all.into_iter().min_by_key(|own| pool.reachable(&[*own]).len())?;
    (pool.reachable(&[shortest]).len() <= LONGEST).then_some(shortest)
}
