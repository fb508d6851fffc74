//! Where an expression of one symbol has a value: by powers, functions and their inverses, and quadratic equations. Nothing is
//! searched for; which of several roots is meant is for the caller to say.

use crate::expr::{ExprId, Pool, Symbol};
use crate::number::Number;
use crate::order::{Keyed, Order};
use crate::precision::Function;

/// Roots of an expression in a symbol, those that can be written down; not all of those that repeat.
pub(super) fn roots(pool: &mut Pool, symbol: Symbol, e: ExprId) -> Vec<ExprId> {
    let (_, core) = pool.split_content(e);
    let zero = pool.zero();
    let mut found = Vec::new();
    for (base, exponent) in factors(pool, core) {
        if !exponent.is_negative() && pool.depends_on(base, &|own| own == symbol) {
            Solving { symbol, found: &mut found }.solve(pool, base, zero);
        }
    }
    found
}

/// The factors of a product; those that all terms of a sum have in common, and what is left of it.
fn factors(pool: &mut Pool, e: ExprId) -> Vec<(ExprId, Number)> {
    if !pool.is_sum(e) {
        return pool.factors(e);
    }
    let terms = pool.terms(e);
    let all: Vec<Vec<(ExprId, Number)>> = terms.iter().map(|(term, _)| pool.factors(*term)).collect();
    let [first, others @ ..] = all.as_slice() else { return Vec::new() };
    let in_all = |own: &&(ExprId, Number)| others.iter().all(|other| other.contains(own));
    let mut common: Vec<(ExprId, Number)> = first.iter().filter(in_all).cloned().collect();
    let shared = pool.product_of_powers(&common);
    let rest: Vec<(ExprId, Number)> =
        terms.into_iter().map(|(term, factor)| (pool.div(term, shared), factor)).collect();
    common.push((pool.linear(&rest), Number::ONE));
    common
}

struct Solving<'a> {
    symbol: Symbol,
    found: &'a mut Vec<ExprId>,
}

impl Solving<'_> {
    /// Where an expression has a value.
    fn solve(&mut self, pool: &mut Pool, e: ExprId, value: ExprId) {
        let own = self.symbol;
        let moves = |pool: &Pool, e: ExprId| pool.depends_on(e, &|symbol| symbol == own);
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
    fn power(&mut self, pool: &mut Pool, base: ExprId, exponent: &Number, value: ExprId) {
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
    fn powers(&mut self, pool: &mut Pool, terms: &[(ExprId, Number)], value: ExprId) {
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
            shares.under(exponent.clone()).push(share);
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
fn inverses(pool: &mut Pool, function: Function, value: ExprId) -> Vec<ExprId> {
    let inverse = match function {
        Function::Sin => Function::Asin,
        Function::Cos => Function::Acos,
        Function::Tan => Function::Atan,
        Function::Asin => Function::Sin,
        Function::Acos => Function::Cos,
        Function::Atan => Function::Tan,
        Function::Exp => Function::Ln,
        Function::Ln => Function::Exp,
        Function::Abs => return vec![value, pool.neg(value)],
        Function::Sinh | Function::Cosh | Function::Tanh => return Vec::new(),
    };
    let own = pool.apply(inverse, value);
    match function {
        Function::Sin => {
            let pi = pool.pi();
            vec![own, pool.sub(pi, own)]
        }
        Function::Cos => vec![own, pool.neg(own)],
        _ => vec![own],
    }
}
