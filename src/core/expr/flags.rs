//! Cheap facts about an expression, recorded when it is made.

use super::{ExprId, Function, Node, Pool};
use crate::number::Number;
use crate::order::Gather;

/// What is known of an expression without looking into it again.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Flags {
    /// Not negative wherever it has a value.
    pub(super) nonnegative: bool,
    /// Not positive, by assumption.
    pub(super) nonpositive: bool,
    /// Without symbols.
    pub(super) constant: bool,
    /// A sum whose coefficients are whole and coprime.
    pub(super) primitive: bool,
}

impl Pool {
    /// Takes these expressions for not negative from now on, whatever their symbols are, and what follows from that: with
    /// l - d and d, l as well. Expressions that are there keep their form until they are built anew.
    pub fn assume_nonnegative(&mut self, assumed: &[ExprId]) {
        let mut round = assumed.to_vec();
        while !round.is_empty() {
            for e in round {
                let (factor, core) = self.split_content(e);
                let opposite = self.neg(core);
                let (above, below) = if factor.is_negative() { (opposite, core) } else { (core, opposite) };
                for (e, positive) in [(above, true), (e, true), (below, false)] {
                    if let Some(flags) = self.flags.get_mut(e.index()).filter(|flags| !flags.constant) {
                        flags.nonnegative |= positive;
                        flags.nonpositive |= !positive;
                    }
                }
            }
            for place in 0..self.nodes.len() {
                self.flags[place].nonnegative |= self.flags_of(&self.nodes[place]).nonnegative;
            }
            let following = assumed.iter().filter_map(|e| self.nonnegative_part(*e));
            round = following.filter(|e| !self.is_nonnegative(*e)).collect();
        }
    }

    /// The factor that is not negative where an expression is, which is the only one of its terms that can be positive.
    fn nonnegative_part(&self, e: ExprId) -> Option<ExprId> {
        let terms = self.terms(e);
        let is_below = |(term, factor): &&(ExprId, Number)| factor.is_negative() && self.is_nonnegative(*term);
        let open = terms.iter().filter(|own| !is_below(own));
        let (term, factor) = open.only()?;
        let factors = self.factors(*term);
        let open = factors.iter().filter(|(base, exponent)| !self.is_nonnegative_power(*base, exponent));
        let (base, _) = open.only()?;
        (!factor.is_negative()).then_some(*base)
    }

    /// The facts about a node whose children are in the pool.
    pub(super) fn flags_of(&self, node: &Node) -> Flags {
        let constant = |id: ExprId| self.flags(id).constant;
        match node {
            Node::Number(value) => Flags { nonnegative: !value.is_negative(), constant: true, ..Flags::default() },
            Node::Pi => Flags { nonnegative: true, constant: true, ..Flags::default() },
            Node::Undefined => Flags { nonnegative: false, constant: true, ..Flags::default() },
            Node::Symbol(_) => Flags::default(),
            Node::Sum { constant: number, terms } => Flags {
                nonnegative: !number.is_negative()
                    && terms.iter().all(|(t, c)| !c.is_negative() && self.is_nonnegative(*t)),
                constant: terms.iter().all(|(t, _)| constant(*t)),
                primitive: content(number, terms).is_one(),
                nonpositive: false,
            },
            Node::Product(factors) => Flags {
                nonnegative: factors.iter().all(|(b, e)| self.is_nonnegative_power(*b, e)),
                constant: factors.iter().all(|(b, _)| constant(*b)),
                ..Flags::default()
            },
            Node::Power { base, exponent } => {
                // As (-2)^n is not, with an n that gets the value 3.
                let constant = constant(*base) && constant(*exponent);
                Flags { nonnegative: self.is_nonnegative(*base), constant, ..Flags::default() }
            }
            Node::Function(function, x) => Flags {
                nonnegative: match function {
                    Function::Exp | Function::Cosh | Function::Abs | Function::Acos => true,
                    Function::Sinh | Function::Tanh | Function::Atan | Function::Asin => self.is_nonnegative(*x),
                    Function::Sin | Function::Cos | Function::Tan | Function::Ln => false,
                },
                constant: constant(*x),
                ..Flags::default()
            },
            Node::Atan2 { y, x } => Flags {
                nonnegative: self.is_nonnegative(*y),
                constant: constant(*y) && constant(*x),
                ..Flags::default()
            },
        }
    }

    /// Whether `base^exponent` is not negative wherever it has a value. (Powers that are not
    /// whole have values only of bases that are not negative.)
    pub(super) fn is_nonnegative_power(&self, base: ExprId, exponent: &Number) -> bool {
        exponent.is_even() || !exponent.is_integer() || self.is_nonnegative(base)
    }
}

/// The positive rational number by which the coefficients of a sum become coprime whole numbers.
pub(super) fn content(constant: &Number, terms: &[(ExprId, Number)]) -> Number {
    terms.iter().fold(
        constant.abs(),
        |gcd, (_, coefficient)| {
            if gcd.is_one() && coefficient.is_integer() { gcd } else { gcd.gcd(coefficient) }
        },
    )
}
