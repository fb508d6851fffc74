//! `assume` statements: relations between parameters, for what a derivation simplifies.

use std::borrow::Cow;
use std::cmp::Ordering;
use std::collections::BTreeSet;

use super::compile::Scope;
use super::elaborate::Elaborator;
use super::index::is_so;
use super::names::World;
use super::{Given, Model, ModelError};
use crate::expr::{ExprId, Function, Node, Pool, evaluate_closed};
use crate::number::Number;
use crate::precision::Big;
use crate::span::Span;
use crate::syntax::{Comparison, ExprKind, ExprRef};

/// Enough to tell two numbers apart that a person writes.
const BITS: usize = 256;

/// A relation between parameters that holds whatever their values are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Assumption {
    /// Left of the sign.
    pub left: ExprId,
    /// The sign.
    pub relation: Comparison,
    /// Right of the sign.
    pub right: ExprId,
    /// Where it stands.
    pub span: Span,
    /// Whether others say it: that the sine of an angle between 0 and pi is positive.
    pub follows: bool,
}

impl Elaborator<'_> {
    /// The relations that a comparison stands for: between vectors one a component, with a number on one side of each.
    pub(super) fn assumption(&mut self, at: ExprRef) -> Option<Vec<Assumption>> {
        let span = self.file.expr(at).span;
        let ExprKind::Compare { operator: relation, left, right } = self.file.expr(at).kind else { return None };
        let programs = self.compiled(&[left, right], &Scope::default())?;
        let sides = programs.iter().map(|program| Some(self.value_of(program, &[])?.scalars()));
        let sides = sides.collect::<Option<Vec<_>>>()?;
        let count = sides.iter().map(Vec::len).max()?;
        if sides.iter().any(|side| side.len() != count && side.len() != 1) {
            let what = "the sides of an assumption must have the same shape".to_owned();
            return self.refuse(ModelError::Shape { what, span, help: None });
        }
        let mut found = Vec::new();
        for at in 0..count {
            let [left, right] = [0, 1].map(|side| sides[side][at % sides[side].len()]);
            if let Some(on) = [left, right].into_iter().find_map(|side| self.world.varying_symbol(side)) {
                return self.refuse(ModelError::NotConstant { what: "an assumption".to_owned(), on, span });
            }
            if let Some(values) = self.contradicted(left, relation, right) {
                return self.refuse(ModelError::AssumptionBroken { values, span });
            }
            found.push(Assumption { left, relation, right, span, follows: false });
        }
        Some(found)
    }

    /// What the values of the parameters make of a relation that does not hold for them.
    fn contradicted(&mut self, left: ExprId, relation: Comparison, right: ExprId) -> Option<String> {
        let difference = self.world.pool.sub(left, right);
        let difference = self.world.closed(difference)?;
        let pool = &self.world.pool;
        let value = evaluate_closed::<Big>(pool, difference, BITS)?;
        let order = if value.is_positive() {
            Ordering::Greater
        } else if value.is_negative() {
            Ordering::Less
        } else if pool.vanishes(difference) {
            Ordering::Equal
        } else {
            return None;
        };
        if is_so(order, relation) {
            return None;
        }
        let [left, right] = [left, right].map(|side| {
            let closed = self.world.closed(side)?;
            evaluate_closed::<f64>(&self.world.pool, closed, ())
        });
        Some(format!("{} {} {}", left?, relation.sign(), right?))
    }
}

/// Relations beyond so many are not put together.
const MOST_CHAINED: usize = 32;

impl World {
    /// That a relation leaves no value to a difference together with those before it: `a > 0` and `a < 0`.
    pub(super) fn assumed_before(&mut self, own: &Assumption) -> Option<ModelError> {
        let difference = self.pool.sub(own.left, own.right);
        let opposite = self.pool.neg(difference);
        let mut possible = vec![Ordering::Less, Ordering::Equal, Ordering::Greater];
        possible.retain(|order| is_so(*order, own.relation));
        for earlier in &self.assumptions {
            let other = self.pool.sub(earlier.left, earlier.right);
            if other == difference {
                possible.retain(|order| is_so(*order, earlier.relation));
            } else if other == opposite {
                possible.retain(|order| is_so(order.reverse(), earlier.relation));
            }
            if possible.is_empty() {
                return Some(ModelError::AssumptionsContradict { first: earlier.span, span: own.span });
            }
        }
        None
    }
}

impl Model {
    /// The model with its expressions in the form that they have where the assumptions hold: `sqrt(d^2)` is d where
    /// d > 0, |l - d| is l - d where l > d. Of a parameter that stands between bars it is assumed, too, that it is positive if its
    /// value is.
    #[must_use]
    pub fn assumed(&self) -> Cow<'_, Model> {
        let is_bars = |node: &Node| matches!(node, Node::Function(Function::Abs, _));
        if self.assumptions.is_empty() && !self.pool.contains(is_bars) {
            return Cow::Borrowed(self);
        }
        let mut own = self.clone();
        let mut pool = std::mem::take(&mut own.pool);
        let roots: Vec<ExprId> = own.expressions().into_iter().map(|e| *e).collect();
        let positive = self.positive_between_bars(&pool, &roots);
        own.assumptions.extend(positive);
        let of_angles = own.signs_of_angles(&mut pool, &roots);
        own.assumptions.extend(of_angles);
        let differences = own.assumptions.iter().filter_map(|own| match own.relation {
            Comparison::Greater | Comparison::GreaterEqual => Some(pool.sub(own.left, own.right)),
            Comparison::Less | Comparison::LessEqual => Some(pool.sub(own.right, own.left)),
            Comparison::Equal | Comparison::NotEqual => None,
        });
        let mut nonnegative: Vec<ExprId> = differences.collect();
        chain(&mut pool, &mut nonnegative);
        pool.assume_nonnegative(&nonnegative);
        for (e, new) in own.expressions().into_iter().zip(pool.built_anew(&roots)) {
            *e = new;
        }
        own.pool = pool;
        Cow::Owned(own)
    }

    /// All expressions that a derivation begins with.
    fn expressions(&mut self) -> Vec<&mut ExprId> {
        let terms = self.kinetic.iter_mut().chain(&mut self.potential).chain(&mut self.forces);
        let mut all: Vec<&mut ExprId> = terms.map(|family| &mut family.body).collect();
        all.extend(self.parameters.iter_mut().map(|parameter| &mut parameter.symbolic));
        let conditions = self.constraints.iter_mut().chain(&mut self.rolling);
        all.extend(conditions.map(|condition| &mut condition.expression));
        let given = [&mut self.guesses, &mut self.guessed_velocities, &mut self.equilibria, &mut self.rates];
        let given = given.into_iter().flat_map(|own| own.given_mut().map(|(_, given)| given)).chain(&mut self.period);
        all.extend(given.map(|Given { symbolic, .. }| symbolic));
        all
    }

    /// That parameters are positive of which an absolute value is taken and whose values are.
    fn positive_between_bars(&self, pool: &Pool, roots: &[ExprId]) -> Vec<Assumption> {
        let mut found: Vec<Assumption> = Vec::new();
        for e in pool.reachable(roots) {
            let Node::Function(Function::Abs, inner) = *pool.node(e) else { continue };
            for (base, _) in pool.factors(inner) {
                let parameter = self.parameters.iter().find(|own| pool.as_symbol(base) == Some(own.symbol));
                let value = parameter.and_then(|own| evaluate_closed::<Big>(pool, own.value?, BITS));
                let known =
                    self.assumptions.iter().chain(&found).any(|own| own.left == base && own.right == pool.zero());
                if !known && value.is_some_and(|value| value.is_positive()) {
                    let (relation, right) = (Comparison::Greater, pool.zero());
                    found.push(Assumption { left: base, relation, right, span: Span::default(), follows: false });
                }
            }
        }
        found
    }

    /// That sines, cosines and tangents are positive of angles, and of multiples of them in the expressions, that are assumed to lie
    /// between such bounds.
    fn signs_of_angles(&self, pool: &mut Pool, roots: &[ExprId]) -> Vec<Assumption> {
        let mut angles = BTreeSet::new();
        for e in pool.reachable(roots) {
            let Node::Function(Function::Sin | Function::Cos | Function::Tan, angle) = *pool.node(e) else { continue };
            angles.insert(angle);
            angles.extend(pool.terms(angle).iter().map(|(term, _)| *term));
        }
        let mut found = Vec::new();
        for angle in angles {
            let Some(ends) = self.bounds(pool, angle) else { continue };
            let quarters =
                |from: i64, to: i64| [from, to].map(|quarters| Number::ratio(quarters, 2).unwrap_or_default());
            for (function, [from, to]) in
                [(Function::Sin, quarters(0, 2)), (Function::Cos, quarters(-1, 1)), (Function::Tan, quarters(0, 1))]
            {
                let pi = pool.pi();
                let (from, to) = (pool.scale(pi, &from), pool.scale(pi, &to));
                let [low, high] = [pool.sub(ends[0], from), pool.sub(to, ends[1])];
                if [low, high].into_iter().all(|own| is_nonnegative(pool, own)) {
                    let (left, right) = (pool.apply(function, angle), pool.zero());
                    let relation = Comparison::Greater;
                    found.push(Assumption { left, relation, right, span: Span::default(), follows: true });
                }
            }
        }
        found
    }

    /// Numbers between which the assumptions say that an expression of one parameter lies; both are left out.
    fn bounds(&self, pool: &mut Pool, e: ExprId) -> Option<[ExprId; 2]> {
        let symbol =
            self.parameters.iter().map(|own| own.symbol).find(|own| pool.depends_on(e, &|symbol| symbol == *own))?;
        let slope = pool.diff(e, symbol);
        let is_falling = pool.as_number(slope)?.is_negative();
        let own = pool.symbol_expr(symbol);
        let bound = |is_upper: bool| {
            self.assumptions.iter().find_map(|assumed| match assumed.relation {
                Comparison::Greater if !is_upper && assumed.left == own => Some(assumed.right),
                Comparison::Greater if is_upper && assumed.right == own => Some(assumed.left),
                Comparison::Less if is_upper && assumed.left == own => Some(assumed.right),
                Comparison::Less if !is_upper && assumed.right == own => Some(assumed.left),
                _ => None,
            })
        };
        let [low, high] = [bound(is_falling)?, bound(!is_falling)?].map(|bound| {
            let put_in = [(symbol, bound)].into_iter().collect();
            pool.substitute_one(e, &put_in)
        });
        Some([low, high])
    }
}

/// Whether a number is proved not to be negative.
fn is_nonnegative(pool: &Pool, number: ExprId) -> bool {
    pool.vanishes(number) || evaluate_closed::<Big>(pool, number, BITS).is_some_and(|value| value.is_positive())
}

/// With b - a and c - b, c - a is not negative: sums of two in which something cancels.
fn chain(pool: &mut Pool, nonnegative: &mut Vec<ExprId>) {
    let mut last = 0;
    while last < nonnegative.len().min(MOST_CHAINED) {
        for first in 0..last {
            let (a, b) = (nonnegative[first], nonnegative[last]);
            let sum = pool.add(a, b);
            let [parts, ours, theirs] = [sum, a, b].map(|e| pool.terms(e).len());
            if parts < ours + theirs && parts <= 2 && !nonnegative.contains(&sum) {
                nonnegative.push(sum);
            }
        }
        last += 1;
    }
}
