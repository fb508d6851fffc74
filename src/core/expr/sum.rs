//! Sums: flattening, collecting equal terms, numeric factors.

use super::flags::content;
use super::{ExprId, Node, ONE, Pool, UNDEFINED, ZERO};
use crate::number::Number;
use crate::order::Order;

/// Whether the coefficient that decides about a sum's sign is negative: the constant, or where
/// that is 0 the last term's. (So differences read as they are written, the later name first:
/// `x - x0`, and `1 - cos(x)`.)
pub(super) fn leads_negative(constant: &Number, terms: &[(ExprId, Number)]) -> bool {
    if constant.is_zero() {
        terms.last().is_some_and(|(_, coefficient)| coefficient.is_negative())
    } else {
        constant.is_negative()
    }
}

impl Pool {
    /// The sum of the expressions.
    pub fn sum(&mut self, terms: &[ExprId]) -> ExprId {
        match terms {
            [] => ZERO,
            [single] => *single,
            _ => self.linear_iter(terms.iter().map(|term| (*term, Number::ONE))),
        }
    }

    /// The sum of `coefficient*expression`.
    pub fn linear(&mut self, terms: &[(ExprId, Number)]) -> ExprId {
        match terms {
            [] => ZERO,
            [(single, coefficient)] => self.scale(*single, coefficient),
            _ => self.linear_iter(terms.iter().cloned()),
        }
    }

    /// The sum of two expressions.
    pub fn add(&mut self, a: ExprId, b: ExprId) -> ExprId {
        if a == ZERO {
            return b;
        }
        if b == ZERO {
            return a;
        }
        self.linear_iter([(a, Number::ONE), (b, Number::ONE)].into_iter())
    }

    /// The difference of two expressions.
    pub fn sub(&mut self, a: ExprId, b: ExprId) -> ExprId {
        if b == ZERO { a } else { self.linear_iter([(a, Number::ONE), (b, Number::MINUS_ONE)].into_iter()) }
    }

    /// The opposite of an expression.
    pub fn neg(&mut self, a: ExprId) -> ExprId {
        self.scale(a, &Number::MINUS_ONE)
    }

    /// A number times an expression.
    pub fn scale(&mut self, e: ExprId, factor: &Number) -> ExprId {
        if e == UNDEFINED || self.is_spent() {
            return UNDEFINED;
        }
        if factor.is_oversized() {
            return self.too_long();
        }
        if factor.is_one() {
            return e;
        }
        if factor.is_zero() { ZERO } else { self.linear_iter(std::iter::once((e, factor.clone()))) }
    }

    fn linear_iter(&mut self, parts: impl Iterator<Item = (ExprId, Number)>) -> ExprId {
        let mut constant = Number::ZERO;
        let mut terms: Vec<(ExprId, Number)> = Vec::with_capacity(parts.size_hint().0);
        for (e, factor) in parts {
            // Numbers of many digits take their time.
            if constant.is_oversized() || self.is_spent() {
                self.outgrown |= constant.is_oversized();
                return UNDEFINED;
            }
            match self.node(e) {
                Node::Number(value) => constant = constant.add(&value.mul(&factor)),
                Node::Sum { constant: inner, terms: others } => {
                    constant = constant.add(&inner.mul(&factor));
                    terms.extend(others.iter().map(|(t, c)| (*t, c.mul(&factor))));
                }
                Node::Undefined => return UNDEFINED,
                Node::Pi
                | Node::Symbol(_)
                | Node::Product(_)
                | Node::Power { .. }
                | Node::Function(..)
                | Node::Atan2 { .. } => terms.push((e, factor)),
            }
        }
        collect_equal(&mut terms);
        let oversized = constant.is_oversized() || terms.iter().any(|(_, c)| c.is_oversized());
        match terms.as_slice() {
            _ if oversized => self.too_long(),
            [] => self.number(constant),
            [(single, coefficient)] if constant.is_zero() && coefficient.is_one() => *single,
            _ => self.intern(Node::Sum { constant, terms: terms.into() }),
        }
    }

    /// Σ a_i b_i.
    pub fn dot(&mut self, a: &[ExprId], b: &[ExprId]) -> ExprId {
        let terms: Vec<ExprId> = a.iter().zip(b).map(|(a, b)| self.mul(*a, *b)).collect();
        self.sum(&terms)
    }

    /// What an expression is a product of: bases with their exponents, itself alone where it is none.
    #[must_use]
    pub fn factors(&self, e: ExprId) -> Vec<(ExprId, Number)> {
        if let Node::Product(factors) = self.node(e) { factors.to_vec() } else { vec![(e, Number::ONE)] }
    }

    /// What an expression is a sum of: terms with their coefficients, the constant as a multiple of 1; itself alone where it is none.
    pub fn terms(&self, e: ExprId) -> Vec<(ExprId, Number)> {
        if let Node::Sum { constant, terms } = self.node(e) {
            let constant = (!constant.is_zero()).then(|| (ONE, constant.clone()));
            terms.iter().cloned().chain(constant).collect()
        } else {
            vec![(e, Number::ONE)]
        }
    }

    /// An expression as `coefficient*core` with the core's coefficients whole and coprime and its
    /// leading one positive. Numbers are their own coefficient, with the core 1.
    pub(crate) fn split_content(&mut self, e: ExprId) -> (Number, ExprId) {
        if let Some(value) = self.as_number(e) { (value.clone(), ONE) } else { self.split_coefficient(e, true) }
    }

    /// The same of what is no number; the coefficient is positive where the core may have either sign.
    pub(super) fn split_coefficient(&mut self, e: ExprId, has_sign: bool) -> (Number, ExprId) {
        let Node::Sum { constant, terms } = self.node(e) else { return (Number::ONE, e) };
        let negative = has_sign && leads_negative(constant, terms);
        if self.flags(e).primitive && !negative {
            return (Number::ONE, e);
        }
        let content = content(constant, terms);
        let factor = if negative { content.neg() } else { content };
        match factor.recip() {
            Some(inverse) => {
                let core = self.scale(e, &inverse);
                (factor, core)
            }
            None => (Number::ONE, e),
        }
    }

    /// Whether the leading coefficient is negative (false of what has none).
    pub(super) fn leads_negative(&self, e: ExprId) -> bool {
        if let Node::Sum { constant, terms } = self.node(e) {
            return leads_negative(constant, terms);
        }
        self.as_number(e).is_some_and(Number::is_negative)
    }
}

/// Sorts by what is multiplied (or raised), adds up the coefficients (or exponents) of equals and drops those that are 0.
pub(crate) fn collect_equal<T: Ord>(items: &mut Vec<(T, Number)>) {
    if !items.is_sorted_by(|a, b| a.0 < b.0) {
        items.order_by(|a, b| a.0.cmp(&b.0));
        items.dedup_by(|later, kept| {
            let same = later.0 == kept.0;
            if same {
                kept.1 = kept.1.add(&later.1);
            }
            same
        });
    }
    items.retain(|(_, value)| !value.is_zero());
}
