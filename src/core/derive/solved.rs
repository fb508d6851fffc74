//! Equilibria that were found numerically, as expressions in the parameters: where the force on a coordinate, with what is known
//! of the others put in, vanishes at a root that is written down by powers, functions and their inverses, or a quadratic equation.
//! Which of several roots is the equilibrium is told by its enclosure.

use std::collections::HashMap;

use super::Linear;
use super::check::Checker;
use super::lagrangian::{self, Variables};
use super::simplify::Algebra;
use crate::expr::{ExprId, Symbol};
use crate::linearize::known_values;
use crate::model::{Given, Model};
use crate::number::Number;
use crate::order::Order;
use crate::precision::Function;

/// Roots of more symbols are left as they were found.
const MOST_SYMBOLS: u64 = 40;
/// Of models with more coordinates none are looked for.
const MOST_COORDINATES: usize = 12;

/// The model with such equilibria given, where there are some; from what was derived without.
pub(super) fn with_solved(model: &Model, found: &Linear) -> Option<Model> {
    let plain = model.constraints.is_empty() && model.rolling.is_empty() && !model.rates.any();
    if !plain || found.open || model.coordinates.len() > MOST_COORDINATES {
        return None;
    }
    let variables = Variables::new(model);
    let searched =
        |pool: &Algebra<'_>, i: usize| pool.as_symbol(found.equilibrium[i]) == Some(variables.coordinates[i]);
    let mut own = model.clone();
    let mut whole = model.pool.clone();
    let pool = &mut Algebra::new(&mut whole);
    let mut open: Vec<usize> = (0..model.coordinates.len()).filter(|i| searched(pool, *i)).collect();
    if open.is_empty() {
        return None;
    }
    let lagrangian = lagrangian::lagrangian(model, pool);
    if !lagrangian.other.is_empty() || !lagrangian.linear.is_empty() {
        return None;
    }
    let checker = Checker::new(model);
    let drags = lagrangian::drags(model, pool, &variables);
    let mut known = variables.at_rest(pool);
    for (i, at) in found.equilibrium.iter().enumerate().filter(|(i, _)| !open.contains(i)) {
        known.insert(variables.coordinates[i], *at);
    }
    let (all, values) = (open.len(), known_values(model));
    loop {
        let before = open.len();
        open.retain(|i| {
            let (symbol, coordinate) = (variables.coordinates[*i], model.coordinates.at(*i));
            let zero = pool.zero();
            let mut force = lagrangian.forces.get(i).copied().unwrap_or(zero);
            for (_, drag) in drags.iter().filter(|(at, _)| at == i) {
                force = pool.add(force, *drag);
            }
            let force = pool.substitute_one(force, &known);
            let others = |other: Symbol| other != symbol && variables.symbols.coordinate(other).is_some();
            if pool.depends_on(force, &others) {
                return true;
            }
            let Some(root) = root(pool, &checker, symbol, force) else { return true };
            known.insert(symbol, root);
            let value = Some(pool.substitute_one(root, &values));
            own.equilibria.set(*i, Some(Given { symbolic: root, value, span: coordinate.span }));
            false
        });
        if open.is_empty() || open.len() == before {
            break;
        }
    }
    own.pool = whole;
    (open.len() < all).then_some(own)
}

/// The root of a force that is the equilibrium of a coordinate.
fn root(pool: &mut Algebra<'_>, checker: &Checker<'_>, symbol: Symbol, force: ExprId) -> Option<ExprId> {
    let (place, zero) = (pool.symbol_expr(symbol), pool.zero());
    let here = *checker.evaluate(pool, &[place])?.first()?;
    // Its size is known where its sign is.
    let size = pool.apply(Function::Abs, place);
    let signed = if here.is_negative() { pool.neg(place) } else { place };
    let force = *pool.replaced(&[force], &HashMap::from([(size, signed)])).first()?;
    let (_, core) = pool.split_content(force);
    let mut all = Vec::new();
    for (base, exponent) in pool.factors(core) {
        if !exponent.is_negative() && pool.depends_on(base, &|own| own == symbol) {
            Solving { symbol, found: &mut all }.solve(pool, base, zero);
        }
    }
    let mut all: Vec<ExprId> = all.into_iter().map(|own| pool.simplify(own)).collect();
    all.retain(|own| {
        let value = checker.evaluate(pool, &[*own]);
        value.is_some_and(|value| value.iter().all(|one| one.is_finite() && (*one - here).contains_zero()))
    });
    let shortest = all.into_iter().min_by_key(|own| pool.weight_of(&[*own]))?;
    (pool.weight_of(&[shortest]) <= MOST_SYMBOLS).then_some(shortest)
}

struct Solving<'a> {
    symbol: Symbol,
    found: &'a mut Vec<ExprId>,
}

impl Solving<'_> {
    /// Where an expression has a value.
    fn solve(&mut self, pool: &mut Algebra<'_>, e: ExprId, value: ExprId) {
        let own = self.symbol;
        let moves = |pool: &Algebra<'_>, e: ExprId| pool.depends_on(e, &|symbol| symbol == own);
        if pool.as_symbol(e) == Some(own) {
            self.found.push(value);
            return;
        }
        if let Some((function, x)) = pool.as_function(e) {
            for value in inverses(pool, function, value) {
                self.solve(pool, x, value);
            }
            return;
        }
        if !pool.is_sum(e) {
            let (moving, others): (Vec<_>, Vec<_>) =
                pool.factors(e).into_iter().partition(|(base, _)| moves(pool, *base));
            if let [(base, exponent)] = moving.as_slice() {
                let others = pool.product_of_powers(&others);
                let value = pool.div(value, others);
                self.power(pool, *base, exponent, value);
            }
            return;
        }
        let (moving, rest): (Vec<_>, Vec<_>) = pool.terms(e).into_iter().partition(|(term, _)| moves(pool, *term));
        let rest = pool.linear(&rest);
        let value = pool.sub(value, rest);
        if let [(term, coefficient)] = moving.as_slice() {
            if let Some(inverse) = coefficient.recip() {
                let value = pool.scale(value, &inverse);
                self.solve(pool, *term, value);
            }
            return;
        }
        let whole = pool.linear(&moving);
        let slope = pool.diff(whole, own);
        if !moves(pool, slope) {
            self.found.push(pool.div(value, slope));
            return;
        }
        self.powers(pool, &moving, value);
    }

    /// Where a power of a base has a value.
    fn power(&mut self, pool: &mut Algebra<'_>, base: ExprId, exponent: &Number, value: ExprId) {
        let Some(inverse) = exponent.recip() else { return };
        let root = pool.powr(value, &inverse);
        self.solve(pool, base, root);
        if exponent.is_even() && !value.is_zero() {
            let opposite = pool.neg(root);
            self.solve(pool, base, opposite);
        }
    }

    /// Where a sum of powers of a base, with what does not move before them, has a value: of two powers u^a and u^b, or of three with
    /// the middle one halfway.
    fn powers(&mut self, pool: &mut Algebra<'_>, terms: &[(ExprId, Number)], value: ExprId) {
        let own = self.symbol;
        let mut shares: Vec<(Number, Vec<(ExprId, Number)>)> = Vec::new();
        if !value.is_zero() {
            shares.push((Number::ZERO, vec![(value, Number::MINUS_ONE)]));
        }
        let mut common = None;
        for (term, coefficient) in terms {
            let (moving, others): (Vec<_>, Vec<_>) =
                pool.factors(*term).into_iter().partition(|(base, _)| pool.depends_on(*base, &|symbol| symbol == own));
            let [(base, exponent)] = moving.as_slice() else { return };
            if common.is_some_and(|common| common != *base) {
                return;
            }
            common = Some(*base);
            let share = (pool.product_of_powers(&others), coefficient.clone());
            match shares.iter_mut().find(|(power, _)| power == exponent) {
                Some((_, shares)) => shares.push(share),
                None => shares.push((exponent.clone(), vec![share])),
            }
        }
        shares.order_by(|(a, _), (b, _)| a.cmp(b));
        let coefficients: Vec<ExprId> = shares.iter().map(|(_, own)| pool.linear(own)).collect();
        let steps: Vec<Number> = shares.windows(2).map(|pair| pair[1].0.sub(&pair[0].0)).collect();
        let Some(base) = common else { return };
        match (coefficients.as_slice(), steps.as_slice()) {
            ([c, a], [step]) => {
                let quotient = pool.div(*c, *a);
                let value = pool.neg(quotient);
                self.power(pool, base, step, value);
            }
            ([c, b, a], [step, other]) if step == other => {
                let (square, product) = (pool.square(*b), pool.mul(*a, *c));
                let discriminant = pool.linear(&[(square, Number::ONE), (product, Number::from(-4))]);
                let size = pool.sqrt(discriminant);
                for sign in [Number::ONE, Number::MINUS_ONE] {
                    let above = pool.linear(&[(size, sign), (*b, Number::MINUS_ONE)]);
                    let quotient = pool.div(above, *a);
                    let value = pool.scale(quotient, &Number::half());
                    self.power(pool, base, step, value);
                }
            }
            _ => {}
        }
    }
}

/// What a function has a value at.
fn inverses(pool: &mut Algebra<'_>, function: Function, value: ExprId) -> Vec<ExprId> {
    let (inverse, opposite) = match function {
        Function::Sin => (Function::Asin, false),
        Function::Cos => (Function::Acos, true),
        Function::Tan => (Function::Atan, false),
        Function::Asin => (Function::Sin, false),
        Function::Acos => (Function::Cos, false),
        Function::Atan => (Function::Tan, false),
        Function::Exp => (Function::Ln, false),
        Function::Ln => (Function::Exp, false),
        Function::Abs => return vec![value, pool.neg(value)],
        Function::Sinh | Function::Cosh | Function::Tanh => return Vec::new(),
    };
    let own = pool.apply(inverse, value);
    let mut all = vec![own];
    if opposite {
        all.push(pool.neg(own));
    }
    if function == Function::Sin {
        let pi = pool.pi();
        all.push(pool.sub(pi, own));
    }
    all
}
