//! Integrals within expressions: which of the rates in their exponentials are 0.

use std::collections::BTreeMap;

use super::ModelError;
use super::assume::Assumption;
use super::names::World;
use crate::expr::{Exponentials, ExprId, Pool, Substitution, Symbol, evaluate_closed};
use crate::number::Number;
use crate::order::Gather;
use crate::precision::Big;
use crate::span::Span;
use crate::syntax::Comparison;

/// Enough to tell numbers from 0 that a person writes.
const BITS: usize = 256;

/// The function whose derivatives by these symbols are the second of each pair, and that is 0 where they are the first: along a path
/// from there, one symbol after the other. `None` where an integral is not known.
pub(crate) fn along_path(pool: &mut Pool, path: &[(Symbol, [ExprId; 2])]) -> Option<ExprId> {
    let mut parts = Vec::with_capacity(path.len());
    for (at, (symbol, [start, slope])) in path.iter().enumerate() {
        let later: Substitution = path[at + 1..].iter().map(|(symbol, [start, _])| (*symbol, *start)).gather();
        let slope = pool.substitute_one(*slope, &later);
        let function = Exponentials::of(pool, slope, *symbol).ok()?;
        let rates = function.rates().into_iter().map(|rate| (rate, pool.as_number(rate).map(Number::is_zero)));
        let known: BTreeMap<ExprId, Option<bool>> = rates.gather();
        let end = pool.symbol_expr(*symbol);
        let vanishes = |rate| known.get(&rate).copied().unwrap_or(Some(true));
        parts.push(function.integral(pool, [*start, end], vanishes).ok()?);
    }
    Some(pool.sum(&parts))
}

impl World {
    /// The integral of an expression over a variable between bounds, exact.
    pub(super) fn integral_of(
        &mut self,
        e: ExprId,
        variable: Symbol,
        bounds: [ExprId; 2],
        span: Span,
    ) -> Result<ExprId, ModelError> {
        let function = Exponentials::of(&mut self.pool, e, variable).map_err(|part| {
            let variable = self.pool.symbol_name(variable).into_owned();
            ModelError::NoIntegral { part: self.pool.display(part), variable, span }
        })?;
        let known: BTreeMap<ExprId, Option<bool>> =
            function.rates().into_iter().map(|rate| (rate, self.vanishes(rate))).collect();
        let integral =
            function.integral(&mut self.pool, bounds, |rate| known.get(&rate).copied().unwrap_or(Some(true)));
        self.pool.budget().check()?;
        integral.map_err(|rate| {
            let (_, core) = self.split(rate);
            let rate = if self.pool.is_constant(core) { rate } else { core };
            let moves = self.pool.symbols_of(&[rate]).into_iter().any(|symbol| !self.is_parameter(symbol));
            ModelError::OpenIntegral { rate: self.pool.display(rate), moves, span }
        })
    }

    fn is_parameter(&self, symbol: Symbol) -> bool {
        self.kinds.parameter(symbol).is_some()
    }

    /// Whether an expression is 0: by its form, or by values and assumptions of the parameters.
    fn vanishes(&mut self, e: ExprId) -> Option<bool> {
        if self.pool.vanishes(e) {
            return Some(true);
        }
        let (mut factors, core) = self.split(e);
        factors.push(core);
        factors.into_iter().all(|factor| self.is_nonzero(factor)).then_some(false)
    }

    fn is_nonzero(&mut self, e: ExprId) -> bool {
        if let Some(closed) = self.closed(e) {
            return evaluate_closed::<Big>(&self.pool, closed, BITS).is_some_and(|value| !value.contains_zero());
        }
        if let Some(symbol) = self.pool.as_symbol(e) {
            // As below a fraction bar.
            return self.is_parameter(symbol);
        }
        (0..self.assumptions.len()).any(|at| {
            let Assumption { left, relation, right, .. } = self.assumptions[at];
            let difference = self.pool.sub(left, right);
            matches!(relation, Comparison::Greater | Comparison::Less | Comparison::NotEqual)
                && self.split(difference).1 == e
        })
    }

    /// The factors that all terms of an expression share, and what is left: p - q of pi*p/L - pi*q/L.
    fn split(&mut self, e: ExprId) -> (Vec<ExprId>, ExprId) {
        let terms = self.pool.terms(e);
        let mut shared = terms.first().map_or(Vec::new(), |(first, _)| self.pool.factors(*first));
        for (term, _) in &terms {
            let own = self.pool.factors(*term);
            shared.retain(|factor| own.contains(factor));
        }
        let inverse: Vec<(ExprId, Number)> = shared.iter().map(|(base, power)| (*base, power.neg())).collect();
        let divisor = self.pool.product_of_powers(&inverse);
        let rest: Vec<(ExprId, Number)> =
            terms.into_iter().map(|(term, number)| (self.pool.mul(term, divisor), number)).collect();
        let rest = self.pool.linear(&rest);
        (shared.into_iter().map(|(base, _)| base).collect(), self.pool.split_content(rest).1)
    }
}
