//! Equilibria in symbols, where the force on a coordinate can be solved by hand.
//!
//! That is where it depends on no other coordinate and falls into factors which are linear in the
//! coordinate or in one sine or cosine of it: for the bead on a spinning hoop sin(th) = 0 or
//! cos(th) = g/(R*W^2). No search is made, and of the numbers only the signs of parameters are examined.

use super::check::{Checker, Signs};
use super::lagrangian::{Lagrangian, Variables};
use super::simplify::Algebra;
use crate::expr::{ExprId, Node, Pool, Substitution};
use crate::number::Number;
use crate::order::Gather;
use crate::precision::Function;
use crate::syntax::Comparison;

/// What makes the force on a coordinate vanish.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Root {
    /// The number of the coordinate.
    pub coordinate: usize,
    /// What has to have the value: the coordinate, or a sine or cosine of it.
    pub left: ExprId,
    /// The value.
    pub value: ExprId,
    /// Where it exists, if not everywhere: a sine or cosine is not above 1 in size.
    pub condition: Option<Condition>,
}

/// An inequality between parameters, as `W^2 > g/R`.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Condition {
    /// The left side, nowhere negative.
    pub left: ExprId,
    /// What stands between.
    pub relation: Comparison,
    /// The right side, nowhere negative.
    pub right: ExprId,
    /// What is taken to be positive, or where the second is true negative, as it is at the values.
    pub signs: Vec<(ExprId, bool)>,
}

/// The roots of the forces that can be solved, coordinate by coordinate.
pub(super) fn roots(
    pool: &mut Algebra<'_>,
    variables: &Variables,
    lagrangian: &Lagrangian,
    checker: &Checker<'_>,
) -> Vec<Root> {
    let at_rest = variables.at_rest(pool);
    let mut result = Vec::new();
    if !lagrangian.other.is_empty() {
        return result;
    }
    let mut forces = lagrangian.forces.clone();
    for (i, drag) in &lagrangian.drags {
        let drag = pool.substitute_one(*drag, &at_rest);
        let sum = forces.get(i).map_or(drag, |force| pool.add(*force, drag));
        forces.insert(*i, sum);
    }
    for (i, force) in &forces {
        let symbols = pool.symbols(*force);
        let alone = symbols.iter().all(|symbol| {
            variables.time != Some(*symbol) && variables.symbols.coordinate(*symbol).is_none_or(|other| other == *i)
        });
        // With b_i(t) there is a force db_i/dt besides.
        if alone && !lagrangian.linear.contains_key(i) {
            let mut roots = roots_of(pool, variables, *i, *force).unwrap_or_default();
            if roots.iter().any(|root| angle(pool, root.left).is_some()) {
                add_conditions(pool, checker, &mut roots);
            }
            result.extend(roots);
        }
    }
    result
}

/// The roots of all factors; `None` where one can't be solved.
fn roots_of(pool: &mut Algebra<'_>, variables: &Variables, coordinate: usize, force: ExprId) -> Option<Vec<Root>> {
    let (_, core) = pool.split_content(force);
    let factors = pool.factors(core);
    let mut roots = Vec::new();
    for (base, exponent) in factors {
        if !moves(pool, variables, coordinate, base) {
            continue;
        }
        if exponent.is_negative() || !exponent.is_integer() {
            // Where it has a value is not told here.
            return None;
        }
        roots.push(root(pool, variables, coordinate, base)?);
    }
    Some(roots)
}

fn moves(pool: &Pool, variables: &Variables, coordinate: usize, e: ExprId) -> bool {
    pool.depends_on(e, &|symbol| variables.symbols.coordinate(symbol) == Some(coordinate))
}

/// The root of a factor that is A + B*u, with u the coordinate or a sine or cosine.
fn root(pool: &mut Algebra<'_>, variables: &Variables, coordinate: usize, factor: ExprId) -> Option<Root> {
    let symbol = *variables.coordinates.get(coordinate)?;
    let slope = pool.diff(factor, symbol);
    if !moves(pool, variables, coordinate, slope) {
        let zero = Substitution::from([(symbol, pool.zero())]);
        let rest = pool.substitute_one(factor, &zero);
        let left = pool.symbol_expr(symbol);
        // As x - d*x/abs(x) has not, though its slope is 1.
        let is_defined = !pool.is_undefined(rest);
        return is_defined.then(|| quotient(pool, coordinate, left, rest, slope));
    }
    if !pool.is_sum(factor) && pool.as_function(factor).is_none() {
        return None;
    }
    let mut left: Option<ExprId> = None;
    let mut slope: Vec<(ExprId, Number)> = Vec::new();
    let mut rest = Vec::new();
    for (term, coefficient) in pool.terms(factor) {
        if !moves(pool, variables, coordinate, term) {
            rest.push((term, coefficient));
            continue;
        }
        let parts = pool.factors(term);
        let (own, others): (Vec<_>, Vec<_>) =
            parts.into_iter().partition(|(base, _)| moves(pool, variables, coordinate, *base));
        let [(base, exponent)] = own.as_slice() else { return None };
        if !exponent.is_one() || left.is_some_and(|left| left != *base) {
            return None;
        }
        left = Some(*base);
        slope.push((pool.product_of_powers(&others), coefficient));
    }
    let left = left?;
    // The angle is a multiple of the coordinate, so that every value of it is reached.
    let angle = angle(pool, left)?;
    let rate = pool.diff(angle, symbol);
    if moves(pool, variables, coordinate, rate) {
        return None;
    }
    let slope = pool.linear(&slope);
    let rest = pool.linear(&rest);
    Some(quotient(pool, coordinate, left, rest, slope))
}

/// The root -rest/slope.
fn quotient(pool: &mut Algebra<'_>, coordinate: usize, left: ExprId, rest: ExprId, slope: ExprId) -> Root {
    let quotient = pool.div(rest, slope);
    let value = pool.neg(quotient);
    Root { coordinate, left, value: pool.simplify(value), condition: None }
}

/// The angle of a sine or cosine.
pub(super) fn angle(pool: &Pool, e: ExprId) -> Option<ExprId> {
    if let Node::Function(Function::Sin | Function::Cos, angle) = *pool.node(e) { Some(angle) } else { None }
}

/// Gives the roots that don't exist everywhere their conditions.
///
/// Where sin(x) = 0 is a root beside cos(x) = v, or the other way round, v = 1 and v = -1 are no further points; so |v| < 1 is
/// asked for, else |v| <= 1.
fn add_conditions(pool: &mut Pool, checker: &Checker<'_>, roots: &mut [Root]) {
    let lone: Vec<ExprId> = roots.iter().filter(|root| root.value.is_zero()).map(|root| root.left).collect();
    for root in roots {
        let Some(own) = angle(pool, root.left) else { continue };
        if pool.as_number(root.value).is_some_and(|v| v.abs() <= Number::ONE) {
            continue;
        }
        let strict = lone.iter().any(|left| *left != root.left && angle(pool, *left) == Some(own));
        root.condition = Some(condition(pool, checker, root.value, strict));
    }
}

/// |value| < 1 or |value| <= 1 as one writes it: with the factor alone on its side that stands there to the highest power,
/// else without a fraction.
fn condition(pool: &mut Pool, checker: &Checker<'_>, value: ExprId, strict: bool) -> Condition {
    let mut signs = Signs::new();
    let (content, core) = pool.split_content(value);
    let mut factors: Vec<(ExprId, Number)> = Vec::new();
    for (base, exponent) in pool.factors(core) {
        let size =
            if exponent.is_integer() && exponent.is_even() { base } else { size(pool, checker, base, &mut signs) };
        factors.push((size, exponent));
    }
    let highest = factors.iter().map(|(_, e)| e.abs()).max().filter(|e| *e > Number::ONE);
    let alone = (0..factors.len()).filter(|at| Some(factors[*at].1.abs()) == highest).only();
    let number = pool.number(content.abs());
    let (left, right, is_above) = if let Some(at) = alone {
        let (base, exponent) = factors.remove(at);
        let is_above = exponent.is_negative();
        let left = pool.powr(base, &exponent.abs());
        factors.push((number, Number::ONE));
        let rest = pool.product_of_powers(&factors);
        let right = if is_above { rest } else { pool.powi(rest, -1) };
        (left, right, is_above)
    } else {
        let (below, mut above): (Vec<_>, Vec<_>) = factors.into_iter().partition(|(_, e)| e.is_negative());
        above.push((number, Number::ONE));
        let below: Vec<(ExprId, Number)> = below.into_iter().map(|(base, e)| (base, e.neg())).collect();
        let left = pool.product_of_powers(&above);
        (left, pool.product_of_powers(&below), false)
    };
    let relation = match (is_above, strict) {
        (true, true) => Comparison::Greater,
        (true, false) => Comparison::GreaterEqual,
        (false, true) => Comparison::Less,
        (false, false) => Comparison::LessEqual,
    };
    Condition { left, relation, right, signs: signs.into_iter().collect() }
}

/// The absolute value of a factor; without bars where the values of the parameters tell its sign.
fn size(pool: &mut Pool, checker: &Checker<'_>, e: ExprId, signs: &mut Signs) -> ExprId {
    if pool.is_nonnegative(e) {
        return e;
    }
    match sign_by_parameters(pool, checker, e) {
        Some((negative, known)) => {
            signs.extend(known);
            if negative { pool.neg(e) } else { e }
        }
        None => pool.abs(e),
    }
}

/// The sign of a symbol or of a sum of products of symbols, if it follows from theirs at the values; true for negative. And theirs.
pub(super) fn sign_by_parameters(pool: &mut Pool, checker: &Checker<'_>, e: ExprId) -> Option<(bool, Signs)> {
    let symbols = pool.symbols(e).into_iter();
    let known = symbols.map(|symbol| Some((pool.symbol_expr(symbol), checker.sign(symbol)?)));
    let known: Signs = known.collect::<Option<_>>()?;
    Some((single_sign(pool, e, &known)?, known))
}

/// The same, if it follows from these.
fn single_sign(pool: &Pool, e: ExprId, known: &Signs) -> Option<bool> {
    let of_symbol = |e: ExprId| known.iter().find(|(own, _)| *own == e).map(|(_, negative)| *negative);
    let of_term = |term: ExprId| -> Option<bool> {
        let mut negative = false;
        for (base, exponent) in pool.factors(term) {
            if !exponent.is_integer() {
                return None;
            }
            if !exponent.is_even() && !pool.is_nonnegative(base) {
                negative ^= of_symbol(base)?;
            }
        }
        Some(negative)
    };
    if !pool.is_sum(e) {
        return of_symbol(e);
    }
    let is_negative = |(term, coefficient): (ExprId, Number)| Some(of_term(term)? != coefficient.is_negative());
    let signs = pool.terms(e).into_iter().map(is_negative).collect::<Option<Vec<bool>>>()?;
    let first = *signs.first()?;
    signs.iter().all(|sign| *sign == first).then_some(first)
}
