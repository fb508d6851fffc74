//! What a model looks like: its points at given coordinates, with the rods and springs between them.
//!
//! A rod is where a distance can't change, which is proved; a spring is where a term of the potential depends on the coordinates of two
//! points and no others, or on the distance of one from the origin. Nothing is said about models whose points are not known, or are all in one place at the equilibrium. Where a model says itself
//! what is to be drawn, that is the figure.

use std::collections::HashSet;

use crate::program::Program;
use librate_core::expr::{ExprId, Node, Pool, Substitution, Symbol};
use librate_core::linearize::{Linearized, constant, known_values};
use librate_core::model::{Model, Parameter};
use librate_core::number::Number;
use librate_core::order::Gather;
use librate_core::precision::Scalar;

/// Rods are searched for between so many points, ...
const MOST_RIGID: usize = 40;
/// ... and springs in so many terms.
const MOST_TERMS: usize = 20_000;
/// Of each point at most so many lines are drawn on average.
const MOST_LINES: usize = 4;

/// What a line between points stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// A distance that does not change.
    Rod,
    /// A force between two points.
    Spring,
}

/// A line between points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Line {
    /// The point where it begins, by number.
    pub from: usize,
    /// The point where it ends; `None` is the origin.
    pub to: Option<usize>,
    /// What it stands for.
    pub link: Link,
}

/// The points of a model.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Figure {
    /// Their names.
    pub names: Vec<String>,
    /// 2 in a plane, 3 in space.
    pub dimension: usize,
    /// Their positions, one after another, `dimension` components each, of the coordinates in SI, then of the parameters that are open.
    pub positions: Program,
    /// How many of them, from the first on, are dots; others are ends of lines alone.
    pub dots: usize,
    /// Lines between points.
    pub lines: Vec<Line>,
    /// Coordinates that move none of its points.
    pub still: Vec<String>,
    /// How much of what the model draws has no place at the equilibrium, and is left out.
    pub left_out: usize,
}

/// The figure of a model that was checked by [`librate_core::model::Settings::with_points`]; parameters have their values but for those
/// named in `open`, and the time is 0.
#[must_use]
pub fn figure(linearized: &Linearized, open: &[&str]) -> Option<Figure> {
    let model = linearized.model();
    let mut pool = model.pool.clone();
    let opened: Vec<&Parameter> =
        open.iter().filter_map(|name| model.parameters.iter().find(|own| own.name == *name)).collect();
    // What is defined from others follows them.
    let defined: Substitution = model.parameters.iter().map(|own| (own.symbol, own.symbolic)).gather();
    let mut values = known_values(model);
    values.retain(|symbol, _| opened.iter().all(|own| own.symbol != *symbol));
    let zero = pool.zero();
    values.extend(model.symbols.time().map(|time| (time, zero)));
    let found = model.points.iter().map(|point| &point.position);
    let said = model.drawing.iter().flat_map(|own| own.points.iter().chain(own.lines.iter().flat_map(|line| &line.0)));
    let all: Vec<&Vec<ExprId>> = found.chain(said).collect();
    let dimension = all.iter().map(|position| position.len()).max()?;
    let mut positions: Vec<ExprId> = Vec::new();
    for position in all {
        let own = if open.is_empty() { position.clone() } else { pool.substitute(position, &defined) };
        let own = pool.substitute(&own, &values);
        positions.extend(own.into_iter().chain(std::iter::repeat(zero)).take(dimension));
    }
    let mut names: Vec<String> = model.points.iter().map(|point| point.name.clone()).collect();
    if model.drawing.is_none() {
        names.extend(add_pivots(&mut pool, model, &mut positions, dimension));
    }
    let inputs: Vec<Symbol> =
        model.coordinates.iter().map(|own| own.symbol).chain(opened.iter().map(|own| own.symbol)).collect();
    let equilibrium = linearized.equilibrium().values.iter().take(model.coordinates.len());
    let mut at: Vec<f64> = equilibrium.map(|value| value.mid_f64()).collect();
    at.extend(opened.iter().filter_map(|own| Some(constant(&model.pool, own.value?)?.mid_f64())));
    if let Some(drawing) = &model.drawing {
        // What has no place there is left out.
        let has_place = |own: &[ExprId]| evaluated(&pool, own, &inputs, &at).is_some();
        let (dots, ends) = positions.split_at(dimension * drawing.points.len());
        let mut kept: Vec<ExprId> = dots.chunks(dimension).filter(|own| has_place(own)).flatten().copied().collect();
        let dots = kept.len() / dimension;
        let mut lines = Vec::new();
        for (pair, (_, is_spring)) in ends.chunks(2 * dimension).zip(&drawing.lines) {
            if has_place(pair) {
                let from = kept.len() / dimension;
                let link = if *is_spring { Link::Spring } else { Link::Rod };
                lines.push(Line { from, to: Some(from + 1), link });
                kept.extend(pair);
            }
        }
        let left_out = drawing.points.len() + drawing.lines.len() - dots - lines.len();
        if kept.is_empty() {
            return None;
        }
        let positions = Program::compile(&pool, &kept, &inputs).ok()?;
        let still = still(&pool, model, &kept);
        return Some(Figure { names, dimension, positions, dots, lines, still, left_out });
    }
    let program = Program::compile(&pool, &positions, &inputs).ok()?;
    let there = evaluated(&pool, &positions, &inputs, &at)?;
    let count = names.len();
    // Displacements from one place are no figure.
    let is_one_place = there.chunks(dimension).all(|own| Some(own) == there.get(..dimension));
    if count > 1 && is_one_place {
        return None;
    }
    let mut lines = rods(&mut pool, model, &positions, dimension);
    lines.extend(held(&mut pool, model, &positions, dimension));
    let known: HashSet<(usize, Option<usize>)> = lines.iter().map(|own| (own.from, own.to)).collect();
    let springs = springs(&mut pool, model, &positions, dimension);
    let springs: Vec<_> = springs.into_iter().filter(|pair| !known.contains(pair)).collect();
    if springs.len() <= MOST_LINES * count {
        lines.extend(springs.into_iter().map(|(from, to)| Line { from, to, link: Link::Spring }));
    }
    let still = still(&pool, model, &positions);
    Some(Figure { dots: count, names, dimension, positions: program, lines, still, left_out: 0 })
}

fn still(pool: &Pool, model: &Model, positions: &[ExprId]) -> Vec<String> {
    let moved: HashSet<usize> = moving(pool, model, positions).into_iter().collect();
    let all = model.coordinates.iter().enumerate().filter(|(number, _)| !moved.contains(number));
    all.map(|(_, own)| own.name()).collect()
}

fn evaluated(pool: &Pool, roots: &[ExprId], inputs: &[Symbol], at: &[f64]) -> Option<Vec<f64>> {
    let tape = librate_core::expr::Tape::compile(pool, roots, inputs).ok()?;
    let found: Vec<f64> = tape.evaluate(at, &mut Vec::new());
    found.iter().all(|value| value.is_finite()).then_some(found)
}

/// The coordinates that a point moves with.
fn moving(pool: &Pool, model: &Model, position: &[ExprId]) -> Vec<usize> {
    pool.symbols_of(position).into_iter().filter_map(|symbol| model.symbols.coordinate(symbol)).collect()
}

/// Whether the distance of a point from another, or from the origin, depends on no coordinate.
fn is_rigid(pool: &mut Pool, model: &Model, point: &[ExprId], other: Option<&[ExprId]>) -> bool {
    let mut squares = Vec::new();
    for (axis, part) in point.iter().enumerate() {
        let part = other.map_or(*part, |other| pool.sub(*part, other[axis]));
        squares.push(pool.mul(part, part));
    }
    let square = pool.sum(&squares);
    moving(pool, model, &[square]).into_iter().all(|number| {
        let slope = pool.diff(square, model.coordinates.at(number).symbol);
        pool.vanishes(slope)
    })
}

/// Adds what points turn about that slides along an axis by a coordinate, as the cart of a pendulum; their names.
fn add_pivots(pool: &mut Pool, model: &Model, positions: &mut Vec<ExprId>, dimension: usize) -> Vec<String> {
    let mut names = Vec::new();
    let points: Vec<Vec<ExprId>> = positions.chunks(dimension).take(MOST_RIGID).map(<[ExprId]>::to_vec).collect();
    for point in points {
        for number in moving(pool, model, &point) {
            let coordinate = model.coordinates.at(number);
            let slopes: Vec<ExprId> = point.iter().map(|part| pool.diff(*part, coordinate.symbol)).collect();
            let along: Vec<usize> = (0..dimension).filter(|axis| slopes[*axis] != pool.zero()).collect();
            let [axis] = along[..] else { continue };
            if slopes[axis] != pool.one() {
                continue;
            }
            let mut pivot = vec![pool.zero(); dimension];
            pivot[axis] = pool.symbol_expr(coordinate.symbol);
            let is_known = positions.chunks(dimension).any(|own| *own == pivot);
            if !is_known && point != pivot && is_rigid(pool, model, &point, Some(&pivot)) {
                positions.extend(pivot);
                names.push(coordinate.name());
            }
        }
    }
    names
}

/// Distances between points, or from the origin, that do not depend on any coordinate.
fn rods(pool: &mut Pool, model: &Model, positions: &[ExprId], dimension: usize) -> Vec<Line> {
    let points: Vec<&[ExprId]> = positions.chunks(dimension).collect();
    if points.len() > MOST_RIGID {
        return Vec::new();
    }
    let mut found = Vec::new();
    // What is a coordinate itself goes where it likes.
    let is_free = |pool: &Pool, point: &[ExprId]| point.iter().any(|part| pool.as_symbol(*part).is_some());
    for (at, point) in points.iter().enumerate() {
        if !is_free(pool, point) && is_rigid(pool, model, point, None) {
            found.push(Line { from: at, to: None, link: Link::Rod });
        }
        for (other, end) in points.iter().enumerate().skip(at + 1) {
            if !(is_free(pool, point) && is_free(pool, end)) && is_rigid(pool, model, end, Some(point)) {
                found.push(Line { from: at, to: Some(other), link: Link::Rod });
            }
        }
    }
    found
}

/// Distances that constraints hold.
fn held(pool: &mut Pool, model: &Model, positions: &[ExprId], dimension: usize) -> Vec<Line> {
    let points: Vec<&[ExprId]> = positions.chunks(dimension).collect();
    let moves: Vec<Vec<usize>> = points.iter().map(|own| moving(pool, model, own)).collect();
    let mut found = Vec::new();
    for constraint in model.constraints.iter().take(MOST_TERMS) {
        let all = moving(pool, model, &[constraint.expression]);
        let is_inside = |point: &usize| moves[*point].iter().all(|number| all.contains(number));
        match (0..points.len()).filter(is_inside).collect::<Vec<_>>()[..] {
            [a, b] => found.push(Line { from: a, to: Some(b), link: Link::Rod }),
            // Nothing but the distance from the origin: the gradient points there.
            [only] => {
                let parts = points[only];
                let slope = |part: &ExprId| match pool.vanishes(*part) {
                    true => Some(*part),
                    false => pool.as_symbol(*part).map(|own| pool.diff(constraint.expression, own)),
                };
                let Some(slopes) = parts.iter().map(slope).collect::<Option<Vec<ExprId>>>() else { continue };
                let mut along = |i: usize, j: usize| {
                    let [a, b] = [pool.mul(slopes[i], parts[j]), pool.mul(slopes[j], parts[i])];
                    pool.agree(a, b)
                };
                if (1..dimension).all(|axis| along(0, axis) && along(axis - 1, axis)) {
                    found.push(Line { from: only, to: None, link: Link::Rod });
                }
            }
            _ => {}
        }
    }
    found
}

/// What is written as a sum, or a constant times a sum, is term by term.
fn add_summands(pool: &Pool, term: ExprId, is_local: &impl Fn(&Symbol) -> bool, found: &mut Vec<ExprId>) {
    match pool.node(term) {
        Node::Sum { terms, .. } => terms.iter().for_each(|(term, _)| add_summands(pool, *term, is_local, found)),
        Node::Product(factors) => {
            let moves = |factor: &&(ExprId, Number)| pool.symbols_of(&[factor.0]).iter().any(is_local);
            match factors.iter().filter(moves).collect::<Vec<_>>()[..] {
                [(sum, power)] if power.is_one() => add_summands(pool, *sum, is_local, found),
                _ => found.push(term),
            }
        }
        _ => found.push(term),
    }
}

/// Pairs of points that a term of the potential depends on, and points on whose distance from the origin one does.
fn springs(pool: &mut Pool, model: &Model, positions: &[ExprId], dimension: usize) -> Vec<(usize, Option<usize>)> {
    let moves: Vec<Vec<usize>> = positions.chunks(dimension).map(|own| moving(pool, model, own)).collect();
    let points = moves.iter().enumerate().flat_map(|(point, own)| own.iter().map(move |number| (*number, point)));
    let of_coordinate = points.by_place(model.coordinates.len());
    let mut found = Vec::new();
    let mut seen = HashSet::new();
    let energy = if model.lagrangian { &model.kinetic } else { &model.potential };
    for family in energy.iter().filter(|family| family.count <= MOST_TERMS) {
        let mut terms = Vec::new();
        let is_local = |symbol: &Symbol| family.locals.iter().any(|local| local.coordinate == *symbol);
        let at_rest = family.at_rest(pool);
        for body in pool.substitute(&[family.body], &at_rest) {
            add_summands(pool, body, &is_local, &mut terms);
        }
        let places = terms.iter().map(|term| {
            let inside = pool.symbols_of(&[*term]);
            let locals = family.locals.iter().enumerate().filter(|(_, local)| inside.contains(&local.coordinate));
            (*term, locals.map(|(place, _)| place).collect::<Vec<usize>>())
        });
        let places: Vec<(ExprId, Vec<usize>)> = places.collect();
        for (instance, (term, places)) in
            (0..family.count).flat_map(|instance| places.iter().map(move |own| (instance, own)))
        {
            let coordinates = family.coordinates_of(instance);
            let all: HashSet<usize> =
                places.iter().filter_map(|place| Some(*coordinates.get(*place)? as usize)).collect();
            let near = all.iter().filter_map(|number| of_coordinate.get(*number)).flatten().copied().distinct();
            let is_inside = |point: &&usize| moves[**point].iter().all(|number| all.contains(number));
            if let [a, b] = near.iter().filter(is_inside).collect::<Vec<_>>()[..] {
                found.push((*a, Some(*b)));
                continue;
            }
            if family.count > MOST_RIGID || moves.len() > MOST_RIGID {
                continue;
            }
            let of_local = family.locals.iter().zip(coordinates).map(|(local, number)| {
                (local.coordinate, pool.symbol_expr(model.coordinates.at(*number as usize).symbol))
            });
            let of_local: Substitution = of_local.gather();
            let own = pool.substitute(&[*term], &of_local);
            let moves_with = |point: &usize| all.iter().all(|number| moves[*point].contains(number));
            for point in near.into_iter().filter(moves_with) {
                let position = &positions[point * dimension..][..dimension];
                if own.iter().all(|own| is_central(pool, model, *own, position)) {
                    found.push((point, None));
                }
            }
        }
    }
    found.into_iter().filter(|own| seen.insert(*own)).collect()
}

/// Whether a term depends on the distance of a point from the origin and nothing else, but not as a constant force does.
fn is_central(pool: &mut Pool, model: &Model, term: ExprId, point: &[ExprId]) -> bool {
    let squares: Vec<ExprId> = point.iter().map(|part| pool.mul(*part, *part)).collect();
    let square = pool.sum(&squares);
    let symbols: Vec<Symbol> =
        moving(pool, model, point).into_iter().map(|number| model.coordinates.at(number).symbol).collect();
    let slopes: Vec<[ExprId; 2]> = symbols.iter().map(|own| [pool.diff(term, *own), pool.diff(square, *own)]).collect();
    let mut is_parallel = |[a, b]: [ExprId; 2], [c, d]: [ExprId; 2]| {
        let products = [pool.mul(a, d), pool.mul(b, c)];
        pool.agree(products[0], products[1])
    };
    let is_radial =
        slopes.iter().enumerate().all(|(at, own)| slopes[..at].iter().all(|other| is_parallel(*own, *other)));
    let bends: Vec<ExprId> = symbols.iter().zip(&slopes).map(|(symbol, [own, _])| pool.diff(*own, *symbol)).collect();
    let is_bent = bends.into_iter().any(|own| !pool.vanishes(own));
    is_radial && is_bent && slopes.iter().any(|[_, own]| !pool.vanishes(*own))
}
