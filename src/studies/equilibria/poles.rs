//! Poles of the potential: why there is no equilibrium beside one.
//!
//! Beside a pole forces are unbounded, of any direction: intervals exclude nothing. But along a field w that leads away from it they
//! have one sign. Let s be what the potential depends on there: U(q, s) with s = |u|² or |u| for a linear u. With w = ∇s, or s∇s,
//! w·∇s is m s for a number m, and so w·F = m s ∂U/∂s + w·(∂U/∂q + what else acts): for U = -k/√s the first part is m k/(2 √s), which
//! exceeds the second near s = 0. Where several poles are near at once, as of three bodies in a cell, w is the sum of their
//! fields, if w·∇s = m s still holds for each. Products with s are worked out in symbols, so nothing is divided by 0.

use std::collections::HashMap;

use librate_core::expr::{ExprId, Node, Pool, Prepared, Substitution, Symbol, Tape};
use librate_core::number::Number;
use librate_core::order::Gather;
use librate_core::precision::{Function, Interval, Scalar};

/// More poles are not examined together.
const MOST_POLES: usize = 200;
/// A pole is near where what vanishes there takes values from so small a part of others on.
const NEAR: f64 = 0.5;
/// Forms of sums of fields that are tried.
const MOST_FORMS: usize = 2000;

/// One pole: where an expression vanishes.
struct Pole {
    /// The expression.
    base: ExprId,
    /// Stands for it.
    symbol: Symbol,
    /// The field that leads away from it; `None` where there is none of these kinds.
    field: Option<Vec<ExprId>>,
    /// |∇s|, as a root of s where it is one.
    slope: ExprId,
}

/// The poles of a potential.
pub(super) struct Poles {
    pool: Pool,
    poles: Vec<Pole>,
    /// The potential with symbols for what vanishes at poles.
    potential: ExprId,
    others: Vec<ExprId>,
    unknowns: Vec<Symbol>,
    inputs: Vec<Symbol>,
    bases: Option<Prepared<Interval>>,
    forms: HashMap<Vec<usize>, Form>,
}

/// What is worked out beside some poles.
struct Form {
    /// w·F.
    along: Option<Prepared<Interval>>,
    /// Beside a single one |∇s| ∂U/∂s, then all other forces, by coordinate.
    alone: Option<Prepared<Interval>>,
}

/// What a potential has no value at 0 of, and depends on unknowns.
pub(super) fn bases(pool: &Pool, potential: ExprId, unknowns: &[Symbol]) -> Vec<ExprId> {
    let mut found = Vec::new();
    for id in pool.reachable(&[potential]) {
        match pool.node(id) {
            Node::Product(factors) => {
                // With a fraction for an exponent some derivative has a pole.
                let poles = factors.iter().filter(|(_, exponent)| exponent.is_negative() || !exponent.is_integer());
                found.extend(poles.map(|(base, _)| *base));
            }
            Node::Function(Function::Ln, x) => found.push(*x),
            Node::Function(Function::Abs, _) => found.push(id),
            Node::Power { base, .. } => found.push(*base),
            Node::Number(_)
            | Node::Pi
            | Node::Symbol(_)
            | Node::Undefined
            | Node::Sum { .. }
            | Node::Function(..)
            | Node::Atan2 { .. } => {}
        }
    }
    let mut found = found.into_iter().distinct();
    found.retain(|base| pool.depends_on(*base, &|symbol| unknowns.contains(&symbol)));
    found
}

impl Poles {
    pub(super) fn new(
        pool: &mut Pool,
        potential: ExprId,
        others: &[ExprId],
        unknowns: &[Symbol],
        inputs: &[Symbol],
    ) -> Self {
        let found = bases(pool, potential, unknowns);
        let found = if found.len() <= MOST_POLES { found } else { Vec::new() };
        let compiled = if found.is_empty() { None } else { Tape::compile(pool, &found, inputs).ok() };
        let mut poles = Vec::new();
        for base in found {
            let symbol = pool.fresh_symbol("distance");
            let own = pool.symbol_expr(symbol);
            if pool.is_nonnegative(base) {
                pool.assume_nonnegative(&[own]);
            }
            let (field, slope) = field(pool, base, own, unknowns);
            poles.push(Pole { base, symbol, field, slope });
        }
        let parts = poles.iter().map(|pole| (pole.base, pool.symbol_expr(pole.symbol))).collect();
        let potential = pool.replaced(&[potential], &parts)[0];
        Self {
            pool: pool.clone(),
            poles,
            potential,
            others: others.to_vec(),
            unknowns: unknowns.to_vec(),
            inputs: inputs.to_vec(),
            bases: compiled.map(|tape| tape.prepare(())),
            forms: HashMap::new(),
        }
    }

    /// Whether poles may lie within, and there is no equilibrium beside them.
    pub(super) fn exclude(&mut self, at: &[Interval], scratch: &mut Vec<Interval>) -> bool {
        let Some(bases) = &self.bases else { return false };
        let values = bases.evaluate(at, scratch);
        // What is as far away as the piece is large bounds derivatives no better.
        let is_near = |own: &Interval| own.contains(0.0) || own.lo > 0.0 && own.lo < NEAR * own.hi;
        let near: Vec<usize> = (0..values.len()).filter(|k| is_near(&values[*k])).collect();
        if near.is_empty() {
            return false;
        }
        if !self.forms.contains_key(&near) {
            if self.forms.len() >= MOST_FORMS {
                return false;
            }
            let form = Form { along: self.along(&near), alone: self.alone(&near) };
            self.forms.insert(near.clone(), form);
        }
        let Some(form) = self.forms.get(&near) else { return false };
        if let Some(along) = &form.along {
            let along = along.evaluate(at, scratch);
            if along.iter().any(|own| own.is_empty() || !own.contains(0.0)) {
                return true;
            }
        }
        let Some(alone) = &form.alone else { return false };
        let alone = alone.evaluate(at, scratch);
        if alone.iter().any(Interval::is_empty) {
            return true;
        }
        // Where both cancel they are as large: beside a corner, as of |u|, all others may be larger than its force.
        let size = alone[0].abs();
        let square = alone[1..].iter().fold(Interval::point(0.0), |sum, own| sum.add(&own.powi(2)));
        size.meet(&square.sqrt()).is_empty()
    }

    /// The slopes of the potential without those by way of the poles that are near.
    fn rest(&mut self, near: &[usize]) -> Vec<ExprId> {
        let pool = &mut self.pool;
        let slopes = pool.gradient(self.potential, &self.unknowns);
        let mut rest: Vec<ExprId> = slopes.iter().zip(&self.others).map(|(x, y)| pool.add(*x, *y)).collect();
        for (k, pole) in self.poles.iter().enumerate() {
            if near.contains(&k) {
                continue;
            }
            let rate = pool.diff(self.potential, pole.symbol);
            for (slope, own) in rest.iter_mut().zip(pool.gradient(pole.base, &self.unknowns)) {
                let own = pool.mul(rate, own);
                *slope = pool.add(*slope, own);
            }
        }
        rest
    }

    fn compiled(&mut self, parts: &[ExprId]) -> Option<Prepared<Interval>> {
        let back: Substitution = self.poles.iter().map(|pole| (pole.symbol, pole.base)).gather();
        let parts = self.pool.substitute(parts, &back);
        Some(Tape::compile(&self.pool, &parts, &self.inputs).ok()?.prepare(()))
    }

    /// |∇s| ∂U/∂s and the other forces.
    fn alone(&mut self, near: &[usize]) -> Option<Prepared<Interval>> {
        let [k] = near else { return None };
        let mut parts = self.rest(near);
        let pole = &self.poles[*k];
        let rate = self.pool.diff(self.potential, pole.symbol);
        // The size alone: an odd power of what changes its sign is large on both sides.
        let own = self.pool.symbol_expr(pole.symbol);
        let size = self.pool.abs(own);
        parts.insert(0, leading(&mut self.pool, rate, pole.slope, own, size));
        self.compiled(&parts)
    }

    /// w·F for the poles that are near.
    fn along(&mut self, near: &[usize]) -> Option<Prepared<Interval>> {
        let mut field: Vec<ExprId> = vec![self.pool.zero(); self.unknowns.len()];
        for k in near {
            let own = self.poles[*k].field.clone()?;
            field = field.iter().zip(own).map(|(x, y)| self.pool.add(*x, y)).collect();
        }
        let rest = self.rest(near);
        let pool = &mut self.pool;
        let mut parts: Vec<ExprId> = field.iter().zip(rest).map(|(w, force)| pool.mul(*w, force)).collect();
        for k in near {
            let pole = &self.poles[*k];
            let rate = pool.diff(self.potential, pole.symbol);
            let towards = pool.gradient(pole.base, &self.unknowns);
            let advance = pool.dot(&field, &towards);
            let ratio = pool.div(advance, pole.base);
            let number = constant(pool, ratio, &self.unknowns)?;
            let own = pool.symbol_expr(pole.symbol);
            let scaled = pool.mul(number, own);
            parts.push(leading(pool, rate, scaled, own, own));
        }
        let total = self.pool.sum(&parts);
        self.compiled(&[total])
    }
}

/// rate·scaled as the lowest power of a symbol in it, taken of `size` in its place, times a factor.
fn leading(pool: &mut Pool, rate: ExprId, scaled: ExprId, symbol: ExprId, size: ExprId) -> ExprId {
    let mut terms: Vec<ExprId> = Vec::new();
    for (term, weight) in pool.terms(rate) {
        let term = pool.mul(term, scaled);
        terms.push(pool.scale(term, &weight));
    }
    let power = |term: &ExprId| {
        let power = pool.factors(*term).into_iter().find(|(base, _)| *base == symbol);
        power.map_or(Number::ZERO, |(_, exponent)| exponent)
    };
    let Some(lowest) = terms.iter().map(power).min().filter(Number::is_negative) else { return pool.sum(&terms) };
    let back = pool.powr(symbol, &lowest.neg());
    let rest: Vec<ExprId> = terms.iter().map(|term| pool.mul(*term, back)).collect();
    let rest = pool.sum(&rest);
    let front = pool.powr(size, &lowest);
    pool.mul(front, rest)
}

/// The number that an expression comes to wherever it is taken.
fn constant(pool: &mut Pool, e: ExprId, unknowns: &[Symbol]) -> Option<ExprId> {
    if !pool.depends_on(e, &|symbol| unknowns.contains(&symbol)) {
        return Some(e);
    }
    for unknown in unknowns {
        let slope = pool.diff(e, *unknown);
        if !pool.vanishes(slope) {
            return None;
        }
    }
    let somewhere = |at: usize| Number::ratio(37 + 12 * at as i64 + (at * at) as i64, 29);
    let map: Option<Vec<(Symbol, Number)>> =
        unknowns.iter().enumerate().map(|(at, symbol)| Some((*symbol, somewhere(at)?))).collect();
    let map: Substitution = map?.into_iter().map(|(symbol, x)| (symbol, pool.number(x))).gather();
    let value = pool.substitute_one(e, &map);
    (!pool.is_undefined(value)).then_some(value)
}

/// The field that leads away from where a base vanishes: its gradient, or that times the base; and the size of the gradient.
fn field(pool: &mut Pool, base: ExprId, own: ExprId, unknowns: &[Symbol]) -> (Option<Vec<ExprId>>, ExprId) {
    let gradient = pool.gradient(base, unknowns);
    let squares: Vec<ExprId> = gradient.iter().map(|own| pool.square(*own)).collect();
    let square = pool.sum(&squares);
    let ratio = pool.div(square, base);
    if let Some(number) = constant(pool, ratio, unknowns) {
        let square = pool.mul(number, own);
        return (Some(gradient), pool.sqrt(square));
    }
    match constant(pool, square, unknowns) {
        Some(number) => {
            let field = gradient.iter().map(|own| pool.mul(*own, base)).collect();
            (Some(field), pool.sqrt(number))
        }
        None => (None, pool.sqrt(square)),
    }
}
