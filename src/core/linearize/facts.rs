//! What is known of every expression with respect to coordinates and velocities.
//!
//! Children stand before their parents in the pool, so that one pass over what is new since the
//! last question answers it for all; nothing is examined twice. It makes no expressions.

use crate::expr::{ExprId, Node, Pool, Symbol};
use crate::model::Local;
use crate::number::Number;
use crate::precision::Scalar;

/// What variables derivatives are taken by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Variable {
    /// A generalized coordinate.
    Coordinate,
    /// A generalized velocity.
    Velocity,
}

/// Facts about one expression.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fact {
    /// A coordinate occurs in it.
    coordinate: bool,
    /// A velocity occurs in it.
    velocity: bool,
    /// It is seen to become 0 with all velocities, at least as fast as this power of them; 0 where it is not.
    pub(super) order: f64,
    /// A symbol, a number or a function of a symbol.
    atom: bool,
    /// A product of atoms: parts of it that could be shared with others cost nothing.
    pub(super) simple: bool,
}

/// Facts about the expressions of one pool.
#[derive(Debug, Default)]
pub(crate) struct Facts {
    /// By the number of the symbol.
    variables: Vec<Option<Variable>>,
    known: Vec<Fact>,
}

impl Facts {
    /// With these for the coordinates and velocities.
    pub(crate) fn about<'a>(locals: impl IntoIterator<Item = &'a Local>) -> Self {
        let mut own = Self::default();
        let kinds = |local: &Local| [(local.coordinate, Variable::Coordinate), (local.velocity, Variable::Velocity)];
        for (symbol, variable) in locals.into_iter().flat_map(kinds) {
            if own.variables.len() <= symbol.index() {
                own.variables.resize(symbol.index() + 1, None);
            }
            own.variables[symbol.index()] = Some(variable);
        }
        own
    }

    /// Whether a symbol is a variable of this kind.
    pub(crate) fn is(&self, symbol: Symbol, variable: Variable) -> bool {
        self.variables.get(symbol.index()) == Some(&Some(variable))
    }

    /// Whether a variable of this kind occurs in an expression.
    pub(crate) fn varies(&mut self, pool: &Pool, id: ExprId, variable: Variable) -> bool {
        let fact = self.of(pool, id);
        match variable {
            Variable::Coordinate => fact.coordinate,
            Variable::Velocity => fact.velocity,
        }
    }

    /// Whether an expression is seen to become 0 when all velocities do.
    pub(crate) fn rests(&mut self, pool: &Pool, id: ExprId) -> bool {
        self.of(pool, id).order > 0.0
    }

    /// What is known of an expression.
    pub(super) fn of(&mut self, pool: &Pool, id: ExprId) -> Fact {
        if self.known.len() <= id.index() {
            for id in pool.ids_from(self.known.len()) {
                let fact = self.fact(pool.node(id), pool);
                self.known.push(fact);
            }
        }
        self.known.get(id.index()).copied().unwrap_or_default()
    }

    fn fact(&self, node: &Node, pool: &Pool) -> Fact {
        let known = |id: &ExprId| self.known.get(id.index()).copied().unwrap_or_default();
        let mut fact = Fact::default();
        node.for_each_child(|child| {
            let child = known(&child);
            fact.coordinate |= child.coordinate;
            fact.velocity |= child.velocity;
        });
        match node {
            Node::Number(value) => {
                fact.order = if value.is_zero() { f64::INFINITY } else { 0.0 };
                fact.atom = true;
            }
            Node::Pi => fact.atom = true,
            Node::Symbol(symbol) => {
                fact.coordinate = self.is(*symbol, Variable::Coordinate);
                fact.velocity = self.is(*symbol, Variable::Velocity);
                fact.order = if fact.velocity { 1.0 } else { 0.0 };
                fact.atom = true;
            }
            Node::Sum { constant, terms } => {
                let orders = terms.iter().map(|(term, _)| known(term).order);
                fact.order = if constant.is_zero() { orders.fold(f64::INFINITY, f64::min) } else { 0.0 };
            }
            Node::Product(factors) => {
                let vanishes = |base: &ExprId, exponent: &Number| known(base).order > 0.0 && !exponent.is_negative();
                // A factor that may have no value at rest leaves it open.
                if factors.iter().all(|(base, power)| !known(base).velocity || vanishes(base, power)) {
                    let vanishing = factors.iter().filter(|(base, power)| vanishes(base, power));
                    fact.order = vanishing.map(|(base, power)| known(base).order * power.to_f64()).sum();
                }
                fact.simple = factors.iter().all(|(base, _)| known(base).atom);
            }
            Node::Function(function, x) => {
                fact.order = if 0.0_f64.apply(*function) == 0.0 { known(x).order } else { 0.0 };
                fact.atom = matches!(pool.node(*x), Node::Symbol(_));
            }
            Node::Power { .. } | Node::Atan2 { .. } | Node::Undefined => {}
        }
        fact.simple |= fact.atom;
        fact
    }
}
