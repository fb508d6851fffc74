//! Walking over what an expression is made of.

use std::collections::HashMap;
use std::hash::BuildHasherDefault;

use super::intern::NodeHasher;
use super::{ExprId, Node, Pool, Symbol};

/// A map from expressions, for memos; never iterated over.
pub(super) type ExprMap<T> = HashMap<ExprId, T, BuildHasherDefault<NodeHasher>>;

/// The expressions that some roots are made of, roots included, in ascending order, with the
/// place of each.
pub(super) struct Reachable {
    pub(super) ids: Vec<ExprId>,
    pub(super) places: ExprMap<usize>,
}

impl Reachable {
    /// The place of an expression among the ids; those of its children come before it.
    pub(super) fn place(&self, id: ExprId) -> usize {
        self.places.get(&id).copied().unwrap_or(0)
    }
}

impl Node {
    /// Calls `visit` with every child, in the order in which the node holds them.
    pub fn for_each_child(&self, mut visit: impl FnMut(ExprId)) {
        match self {
            Node::Number(_) | Node::Pi | Node::Symbol(_) | Node::Undefined => {}
            Node::Sum { terms, .. } => terms.iter().for_each(|(term, _)| visit(*term)),
            Node::Product(factors) => factors.iter().for_each(|(base, _)| visit(*base)),
            Node::Power { base, exponent } => {
                visit(*base);
                visit(*exponent);
            }
            Node::Function(_, x) => visit(*x),
            Node::Atan2 { y, x } => {
                visit(*y);
                visit(*x);
            }
        }
    }
}

impl Pool {
    /// All expressions the roots are made of, roots included, in ascending order: children
    /// before parents.
    #[must_use]
    pub fn reachable(&self, roots: &[ExprId]) -> Vec<ExprId> {
        let mut seen: ExprMap<()> = ExprMap::default();
        let mut ids: Vec<ExprId> = Vec::new();
        for root in roots {
            if seen.insert(*root, ()).is_none() {
                ids.push(*root);
            }
        }
        let mut next = 0;
        while let Some(id) = ids.get(next).copied() {
            next += 1;
            self.node(id).for_each_child(|child| {
                if seen.insert(child, ()).is_none() {
                    ids.push(child);
                }
            });
        }
        ids.sort_unstable();
        ids
    }

    /// The reachable expressions with their places.
    pub(super) fn reachable_places(&self, roots: &[ExprId]) -> Reachable {
        let ids = self.reachable(roots);
        let places = ids
            .iter()
            .enumerate()
            .map(|(place, id)| (*id, place))
            .collect();
        Reachable { ids, places }
    }

    /// The symbols that occur in an expression, in order of creation.
    #[must_use]
    pub fn symbols(&self, root: ExprId) -> Vec<Symbol> {
        self.symbols_of(&[root])
    }

    /// The symbols that occur in any of the expressions, in order of creation.
    #[must_use]
    pub fn symbols_of(&self, roots: &[ExprId]) -> Vec<Symbol> {
        let mut symbols: Vec<Symbol> = self
            .reachable(roots)
            .into_iter()
            .filter_map(|id| self.as_symbol(id))
            .collect();
        symbols.sort_unstable();
        symbols
    }

    /// Whether a symbol of a kind occurs in an expression.
    pub fn depends_on(&self, root: ExprId, is_wanted: &dyn Fn(Symbol) -> bool) -> bool {
        if self.is_constant(root) {
            return false;
        }
        self.reachable(&[root])
            .into_iter()
            .filter_map(|id| self.as_symbol(id))
            .any(is_wanted)
    }

    /// For every expression of an ascending list that holds its own children, whether a wanted
    /// symbol occurs in it.
    pub(super) fn dependent(
        &self,
        reachable: &Reachable,
        is_wanted: impl Fn(Symbol) -> bool,
    ) -> Vec<bool> {
        let mut dependent = vec![false; reachable.ids.len()];
        for (place, id) in reachable.ids.iter().enumerate() {
            let mut depends = match self.node(*id) {
                Node::Symbol(symbol) => is_wanted(*symbol),
                Node::Number(_)
                | Node::Pi
                | Node::Sum { .. }
                | Node::Product(_)
                | Node::Power { .. }
                | Node::Function(..)
                | Node::Atan2 { .. }
                | Node::Undefined => false,
            };
            self.node(*id)
                .for_each_child(|child| depends |= dependent[reachable.place(child)]);
            dependent[place] = depends;
        }
        dependent
    }
}
