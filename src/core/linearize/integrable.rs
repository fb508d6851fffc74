//! Conditions on velocities that are relations of the coordinates.
//!
//! Those whose coefficients are gradients as they stand, or less a constant multiple of another one's, are integrated. How many of the others no function of the coordinates gives is
//! told by the Lie brackets of the fields of allowed velocities (Frobenius). *Nothing is multiplied by a factor to be a gradient.*

use std::borrow::Cow;

use nalgebra::DVector;

use super::assemble::evaluate_closed;
use super::constrained::depend;
use super::elimination::Elimination;
use super::parameters::known_values;
use super::rows::{Rows, eliminate};
use super::symbolic::stated;
use crate::expr::{ExprId, Pool, Seeds, Substitution, Symbol};
use crate::model::{Constraint, Model, SymbolKind, along_path};
use crate::order::{Gather, Order};

/// The model without those conditions that follow from constraints and other conditions everywhere. Of several that say the same those
/// are kept that are farthest from saying so where the search starts: of three components of rolling not that across the surface there.
#[must_use]
pub fn without_dependent(model: &Model) -> Cow<'_, Model> {
    if model.rolling.is_empty() {
        return Cow::Borrowed(model);
    }
    let mut pool = model.pool.clone();
    let (known, held, n) = (known_values(model), model.constraints.len(), model.coordinates.len());
    // Slopes by velocities, and behind these what is without velocities.
    let mut rows: Vec<Vec<(usize, ExprId)>> = Vec::new();
    for (at, own) in model.constraints.iter().chain(&model.rolling).enumerate() {
        let own = pool.substitute_one(own.expression, &known);
        let mut row = if at < held {
            model.symbols.slopes(&mut pool, own)
        } else {
            model.symbols.velocity_slopes(&mut pool, own)
        };
        let rest = match model.time().filter(|_| at < held) {
            Some(time) => pool.diff(own, time),
            None if at < held => pool.zero(),
            None => model.at_rest(&mut pool, own),
        };
        row.push((n, rest));
        rows.push(row);
    }
    if !depend(&pool, &rows)[held..].contains(&true) {
        return Cow::Borrowed(model);
    }
    let order = from_others(model, &mut pool, &rows);
    let sorted: Vec<Vec<(usize, ExprId)>> = order.iter().map(|at| rows[*at].clone()).collect();
    let depends = depend(&pool, &sorted);
    let follows: Vec<usize> =
        order.into_iter().zip(depends).filter(|(_, depends)| *depends).map(|(at, _)| at).collect();
    let mut model = model.clone();
    for at in (0..model.rolling.len()).rev().filter(|at| follows.contains(&(held + at))) {
        model.redundant.push(model.rolling.remove(at));
    }
    Cow::Owned(model)
}

/// Rows, constraints first, by how far each is from depending on those before it where the search starts, in doubles.
fn from_others(model: &Model, pool: &mut Pool, rows: &[Vec<(usize, ExprId)>]) -> Vec<usize> {
    let (n, held) = (model.coordinates.len(), model.constraints.len());
    let place = model.coordinates.iter().map(|own| own.symbol).zip(stated(model, true));
    let place: Substitution = place.chain(model.time().map(|time| (time, pool.zero()))).gather();
    let known = known_values(model);
    let mut number = |e: ExprId| {
        let here = pool.substitute_one(e, &place);
        let here = pool.substitute_one(here, &known);
        evaluate_closed::<f64>(pool, here, ()).filter(|x| x.is_finite()).unwrap_or(0.0)
    };
    let mut left: Vec<(usize, DVector<f64>)> = Vec::new();
    for (at, row) in rows.iter().enumerate() {
        let mut dense = DVector::zeros(n);
        row.iter().filter(|(i, _)| *i < n).for_each(|(i, e)| dense[*i] = number(*e));
        left.push((at, dense));
    }
    let mut order = Vec::with_capacity(rows.len());
    // What differs by rounding stays in order.
    let rank = |(at, row): &(usize, DVector<f64>)| (*at < held, (row.norm().ln() * 1e6).round());
    while let Some(next) = (0..left.len()).reduce(|a, b| if rank(&left[b]) > rank(&left[a]) { b } else { a }) {
        let (at, own) = left.remove(next);
        order.push(at);
        if let Some(own) = own.try_normalize(0.0) {
            left.iter_mut().for_each(|(_, other)| other.axpy(-own.dot(other), &own, 1.0));
        }
    }
    order
}

/// Conditions whose coefficients are the gradient of a function, and those that are with a multiple of another one, integrated:
/// relations of the coordinates that hold where the search starts. The others are left as they are, and those whose integral is not known;
/// those that follow from others are left out.
#[must_use]
pub fn integrated(model: &Model) -> Cow<'_, Model> {
    if model.rolling.is_empty() {
        return Cow::Borrowed(model);
    }
    let mut model = without_dependent(model).into_owned();
    let driven: Vec<bool> = model.with_pool(|model, pool| {
        model.rolling.iter().map(|own| !model.at_rest(pool, own.expression).is_zero()).collect()
    });
    let (driven, mut open): (Vec<_>, Vec<_>) =
        std::mem::take(&mut model.rolling).into_iter().zip(driven).partition(|(_, driven)| *driven);
    let mut at = 0;
    while at < open.len() {
        let (own, _) = &open[at];
        let others = open.iter().map(|(other, _)| other.expression).filter(|other| *other != own.expression);
        let mut all = combinations(&mut model, own.expression, others);
        let found = all.iter_mut().find_map(|rows| integral(&mut model, rows));
        if let Some(expression) = found {
            model.constraints.push(Constraint { expression, span: own.span });
            open.remove(at);
            at = 0;
        } else {
            at += 1;
        }
    }
    model.rolling = open.into_iter().chain(driven).map(|(own, _)| own).collect();
    model.rolling.order_by_key(|own| own.span);
    Cow::Owned(model)
}

/// The coefficients of a condition, and those that are left where another one, times what no coordinate is in, takes the velocity of
/// one away.
fn combinations(model: &mut Model, own: ExprId, others: impl Iterator<Item = ExprId>) -> Vec<Vec<(usize, ExprId)>> {
    let Model { pool, symbols, .. } = model;
    let moves = |symbol| symbols.parameter(symbol).is_none();
    let rows = symbols.velocity_slopes(pool, own);
    let mut all = vec![rows.clone()];
    for other in others {
        let mut tried: Vec<ExprId> = Vec::new();
        for (i, slope) in symbols.velocity_slopes(pool, other) {
            let Some((_, mine)) = rows.iter().find(|(at, _)| *at == i) else { continue };
            let ratio = pool.div(*mine, slope);
            if tried.contains(&ratio) || pool.depends_on(ratio, &moves) {
                continue;
            }
            tried.push(ratio);
            let share = pool.mul(ratio, other);
            let rest = pool.sub(own, share);
            let rest = symbols.velocity_slopes(pool, rest);
            all.push(rest.into_iter().filter(|(_, slope)| !pool.vanishes(*slope)).collect());
        }
    }
    all
}

/// The function with these derivatives that is 0 where the search starts: along a path from there, one coordinate after the other.
fn integral(model: &mut Model, rows: &[(usize, ExprId)]) -> Option<ExprId> {
    let timed = |symbol| matches!(model.symbols.get(symbol), Some(SymbolKind::Velocity(_) | SymbolKind::Time));
    if rows.iter().any(|(_, e)| model.pool.depends_on(*e, &timed)) {
        return None;
    }
    let slopes: Vec<ExprId> = rows.iter().map(|(_, slope)| *slope).collect();
    for symbol in model.pool.symbols_of(&slopes) {
        let Some(number) = model.symbols.coordinate(symbol) else { continue };
        let other = rows.iter().find(|(i, _)| *i == number).map_or(model.pool.zero(), |(_, slope)| *slope);
        for (i, slope) in rows {
            let forth = model.pool.diff(*slope, symbol);
            let back = model.pool.diff(other, model.coordinates.at(*i).symbol);
            if !model.pool.agree(forth, back) {
                return None;
            }
        }
    }
    let start = stated(model, true);
    let path = rows.iter().map(|(i, slope)| (model.coordinates.at(*i).symbol, [start[*i], *slope]));
    let path: Vec<(Symbol, [ExprId; 2])> = path.collect();
    along_path(&mut model.pool, &path)
}

/// How many of the conditions, constraints included, no function of the coordinates gives: the rank of the Lie brackets of the
/// allowed velocities beyond these, at random points.
pub(super) fn not_integrable(model: &Model, pool: &mut Pool, bound: &[usize], visible: usize) -> Option<usize> {
    let coordinates: Vec<Symbol> = model.coordinates.iter().take(visible).map(|own| own.symbol).collect();
    let velocities: Vec<Symbol> = model.coordinates.iter().take(visible).map(|own| own.velocity).collect();
    let mut rows: Rows = model.constraints.iter().map(|own| pool.gradient(own.expression, &coordinates)).collect();
    rows.truncate(bound.len() - model.rolling.len());
    rows.extend(model.rolling.iter().map(|own| pool.gradient(own.expression, &velocities)));
    let free: Vec<usize> = (0..visible).filter(|i| !bound.contains(i)).collect();
    let constraints = rows.len() - model.rolling.len();
    for (at, row) in rows.iter_mut().enumerate() {
        let rest = at.checked_sub(constraints).map(|at| model.at_rest(pool, model.rolling[at].expression));
        row.push(rest.unwrap_or(pool.zero()));
    }
    let rows = eliminate(pool, rows, bound)?;
    let speeds = |pool: &mut Pool, i: usize| -> Vec<ExprId> { rows.iter().map(|row| pool.neg(row[i])).collect() };
    let mut fields: Vec<Field> = free.iter().map(|i| Field { free: Some(*i), speeds: speeds(pool, *i) }).collect();
    let rest = speeds(pool, visible);
    if rest.iter().any(|e| !pool.vanishes(*e)) {
        fields.push(Field { free: None, speeds: rest });
    }
    let bound: Vec<Symbol> = bound.iter().map(|i| coordinates[*i]).collect();
    let bracket = |pool: &mut Pool, x: &Field, y: &Field| -> Field {
        let [forth, back] = [(x, y), (y, x)].map(|(own, other)| {
            let bound = bound.iter().copied().zip(own.speeds.iter().copied()).filter(|(_, speed)| !speed.is_zero());
            let seeds: Seeds = own.free.map(|i| (coordinates[i], pool.one())).into_iter().chain(bound).collect();
            pool.derivation(&other.speeds, &seeds)
        });
        let speeds = forth.into_iter().zip(back).map(|(forth, back)| pool.sub(forth, back));
        Field { free: None, speeds: speeds.collect() }
    };
    // Of fields that are independent of each other and of those allowed.
    let mut brackets: Vec<Field> = Vec::new();
    for (at, x) in fields.iter().enumerate() {
        brackets.extend(fields[at + 1..].iter().map(|y| bracket(pool, x, y)));
    }
    let mut rank = 0;
    loop {
        let is_new = independent(pool, &brackets)?;
        let before = rank;
        let mut is_new = is_new.into_iter();
        brackets.retain(|_| is_new.next().unwrap_or_default());
        rank = brackets.len();
        if rank == bound.len() || rank == before {
            return Some(rank);
        }
        for at in before..rank {
            let next: Vec<Field> = fields.iter().map(|own| bracket(pool, own, &brackets[at])).collect();
            brackets.extend(next);
        }
    }
}

/// Which fields are independent of those before them; `None` where it depends on signs of roots.
fn independent(pool: &Pool, fields: &[Field]) -> Option<Vec<bool>> {
    let all: Vec<ExprId> = fields.iter().flat_map(|field| field.speeds.iter().copied()).collect();
    let width = fields.first().map_or(1, |field| field.speeds.len().max(1));
    let mut found = pool.points_at_random(&all, 3).map(|values| {
        let mut samples = Elimination::default();
        let add = |own: &[u64]| samples.add((0..).zip(own.iter().copied()).filter(|(_, value)| *value != 0).collect());
        values.chunks(width).map(add).collect::<Option<Vec<bool>>>()
    });
    let first = found.next()??;
    found.all(|other| other.as_ref() == Some(&first)).then_some(first)
}

/// A field of allowed velocities, or a Lie bracket of such.
struct Field {
    /// The free coordinate whose velocity is 1, if any; those of all others are 0.
    free: Option<usize>,
    /// The velocities of the bound coordinates.
    speeds: Vec<ExprId>,
}
