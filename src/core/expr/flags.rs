//! Cheap facts about an expression, recorded when it is made.

use super::{ExprId, Function, Node, Pool};
use crate::number::Number;

/// What is known of an expression without looking into it again.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Flags {
    /// Not negative wherever it has a value.
    pub(super) nonnegative: bool,
    /// Without symbols.
    pub(super) constant: bool,
    /// A sum whose coefficients are whole and coprime.
    pub(super) primitive: bool,
}

impl Pool {
    /// The facts about a node whose children are in the pool.
    pub(super) fn flags_of(&self, node: &Node) -> Flags {
        let constant = |id: ExprId| self.flags(id).constant;
        match node {
            Node::Number(value) => Flags { nonnegative: !value.is_negative(), constant: true, primitive: false },
            Node::Pi => Flags { nonnegative: true, constant: true, primitive: false },
            Node::Undefined => Flags { nonnegative: false, constant: true, primitive: false },
            Node::Symbol(_) => Flags::default(),
            Node::Sum { constant: number, terms } => Flags {
                nonnegative: !number.is_negative()
                    && terms.iter().all(|(t, c)| !c.is_negative() && self.is_nonnegative(*t)),
                constant: terms.iter().all(|(t, _)| constant(*t)),
                primitive: content(number, terms).is_one(),
            },
            Node::Product(factors) => Flags {
                nonnegative: factors.iter().all(|(b, e)| self.is_nonnegative_power(*b, e)),
                constant: factors.iter().all(|(b, _)| constant(*b)),
                primitive: false,
            },
            Node::Power { base, exponent } => {
                Flags { nonnegative: true, constant: constant(*base) && constant(*exponent), primitive: false }
            }
            Node::Function(function, x) => Flags {
                nonnegative: match function {
                    Function::Exp | Function::Cosh | Function::Abs | Function::Acos => true,
                    Function::Sinh | Function::Tanh | Function::Atan | Function::Asin => self.is_nonnegative(*x),
                    Function::Sin | Function::Cos | Function::Tan | Function::Ln => false,
                },
                constant: constant(*x),
                primitive: false,
            },
            Node::Atan2 { y, x } => {
                Flags { nonnegative: self.is_nonnegative(*y), constant: constant(*y) && constant(*x), primitive: false }
            }
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
    let mut gcd = constant.abs();
    for (_, coefficient) in terms {
        if !(gcd.is_one() && coefficient.is_integer()) {
            gcd = gcd.gcd(coefficient);
        }
    }
    gcd
}
