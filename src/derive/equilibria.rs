//! Equilibria in symbols, where the force on a coordinate can be solved by hand.
//!
//! That is where it depends on no other coordinate and falls into factors which are linear in the
//! coordinate or in one sine or cosine of it: for the bead on a spinning hoop sin(th) = 0 or
//! cos(th) = g/(R*W^2). Nothing is searched for and no number is looked at.

use super::lagrangian::{Lagrangian, Variables};
use super::simplify::Simplifier;
use crate::expr::{ExprId, Node, Pool, Substitution};
use crate::number::Number;
use crate::precision::Function;

/// What makes the force on a coordinate vanish.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Root {
    /// The number of the coordinate.
    pub coordinate: usize,
    /// What has to have the value: the coordinate, or a sine or cosine of it.
    pub left: ExprId,
    /// The value.
    pub value: ExprId,
    /// Whether that exists only where the value is not above 1 in size.
    pub bounded: bool,
}

/// The roots of the forces that can be solved, coordinate by coordinate.
pub(super) fn roots(
    pool: &mut Pool,
    short: &mut Simplifier,
    variables: &Variables,
    lagrangian: &Lagrangian,
) -> Vec<Root> {
    let mut result = Vec::new();
    if !lagrangian.other.is_empty() {
        return result;
    }
    for (i, force) in &lagrangian.forces {
        let symbols = pool.symbols(*force);
        let alone = symbols.iter().all(|symbol| {
            variables.time != Some(*symbol)
                && variables
                    .coordinate(*symbol)
                    .is_none_or(|other| other == *i)
        });
        // With b_i(t) there is a force db_i/dt besides.
        if alone && !lagrangian.linear.contains_key(i) {
            result.extend(roots_of(pool, short, variables, *i, *force).unwrap_or_default());
        }
    }
    result
}

/// The roots of all factors; `None` where one can't be solved.
fn roots_of(
    pool: &mut Pool,
    short: &mut Simplifier,
    variables: &Variables,
    coordinate: usize,
    force: ExprId,
) -> Option<Vec<Root>> {
    let (_, core) = pool.split_content(force);
    let factors = pool.factors(core);
    let mut roots = Vec::new();
    for (base, exponent) in factors {
        if !moves(pool, variables, coordinate, base) {
            continue;
        }
        if exponent.is_negative() {
            // It doesn't vanish where it has a value; but where that is, is not told here.
            return None;
        }
        roots.push(root(pool, short, variables, coordinate, base)?);
    }
    Some(roots)
}

fn moves(pool: &Pool, variables: &Variables, coordinate: usize, e: ExprId) -> bool {
    pool.depends_on(e, &|symbol| {
        variables.coordinate(symbol) == Some(coordinate)
    })
}

/// The root of a factor that is A + B*u, with u the coordinate or a sine or cosine.
fn root(
    pool: &mut Pool,
    short: &mut Simplifier,
    variables: &Variables,
    coordinate: usize,
    factor: ExprId,
) -> Option<Root> {
    let symbol = *variables.coordinates.get(coordinate)?;
    let slope = pool.diff(factor, symbol);
    if !moves(pool, variables, coordinate, slope) {
        let zero = Substitution::from([(symbol, pool.zero())]);
        let rest = pool.substitute_one(factor, &zero);
        let left = pool.symbol_expr(symbol);
        return Some(quotient(pool, short, coordinate, left, rest, slope));
    }
    let one = Number::ONE;
    let (constant, terms) = match pool.node(factor) {
        Node::Sum { constant, terms } => (constant.clone(), terms.to_vec()),
        Node::Function(..) => (Number::ZERO, vec![(factor, one.clone())]),
        Node::Number(_)
        | Node::Pi
        | Node::Symbol(_)
        | Node::Product(_)
        | Node::Power { .. }
        | Node::Atan2 { .. }
        | Node::Undefined => return None,
    };
    let mut left: Option<ExprId> = None;
    let mut slope: Vec<(ExprId, Number)> = Vec::new();
    let mut rest = vec![(pool.number(constant), one)];
    for (term, coefficient) in terms {
        if !moves(pool, variables, coordinate, term) {
            rest.push((term, coefficient));
            continue;
        }
        let parts = pool.factors(term);
        let (own, others): (Vec<_>, Vec<_>) = parts
            .into_iter()
            .partition(|(base, _)| moves(pool, variables, coordinate, *base));
        let [(base, exponent)] = own.as_slice() else {
            return None;
        };
        if !exponent.is_one() || left.is_some_and(|left| left != *base) {
            return None;
        }
        left = Some(*base);
        slope.push((pool.product_of_powers(&others), coefficient));
    }
    let left = left?;
    // The angle is a multiple of the coordinate, so that every value of it is reached.
    let Node::Function(Function::Sin | Function::Cos, angle) = *pool.node(left) else {
        return None;
    };
    let rate = pool.diff(angle, symbol);
    if moves(pool, variables, coordinate, rate) {
        return None;
    }
    let slope = pool.linear(&slope);
    let rest = pool.linear(&rest);
    let mut root = quotient(pool, short, coordinate, left, rest, slope);
    let value = pool.as_number(root.value);
    root.bounded = value.is_none_or(|value| value.abs() > Number::ONE);
    Some(root)
}

/// The root -rest/slope.
fn quotient(
    pool: &mut Pool,
    short: &mut Simplifier,
    coordinate: usize,
    left: ExprId,
    rest: ExprId,
    slope: ExprId,
) -> Root {
    let quotient = pool.div(rest, slope);
    let value = pool.neg(quotient);
    Root {
        coordinate,
        left,
        value: short.simplify(pool, value),
        bounded: false,
    }
}
