//! Walking over what an expression is made of.

use std::hash::BuildHasherDefault;

use hashbrown::HashMap;

use super::intern::NodeHasher;
use super::{ExprId, Node, Pool, Symbol};
use crate::number::Number;
use crate::order::Order;

type Places = HashMap<ExprId, usize, BuildHasherDefault<NodeHasher>>;

/// The expressions that some roots are made of, roots included, in ascending order, with the
/// place of each.
pub(super) struct Reachable {
    pub(super) ids: Vec<ExprId>,
    index: Index,
}

/// Where an expression stands among the reachable ones.
enum Index {
    /// A bit for every expression of the pool up to the largest root, and for each word of bits
    /// how many are set before it.
    Dense { bits: Vec<u64>, before: Vec<usize> },
    /// For small expressions in large pools.
    Sparse(Places),
}

/// Pools up to this size are always marked in bits.
const SMALL_POOL: usize = 1 << 12;

impl Reachable {
    /// The place of one of the expressions among the ids; those of its children come before it.
    pub(super) fn place(&self, id: ExprId) -> usize {
        match &self.index {
            Index::Dense { bits, before } => {
                let (word, bit) = (id.index() / 64, id.index() % 64);
                let lower = bits.get(word).map_or(0, |bits| bits & ((1 << bit) - 1));
                before.get(word).copied().unwrap_or(0) + lower.count_ones() as usize
            }
            Index::Sparse(places) => places.get(&id).copied().unwrap_or(0),
        }
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

    /// Calls `visit` with every number that the node itself holds: constants, factors of terms, exponents of products.
    pub(crate) fn for_each_number(&self, mut visit: impl FnMut(&Number)) {
        match self {
            Node::Number(number) => visit(number),
            Node::Sum { constant, terms } => {
                visit(constant);
                terms.iter().for_each(|(_, factor)| visit(factor));
            }
            Node::Product(factors) => factors.iter().for_each(|(_, exponent)| visit(exponent)),
            Node::Pi
            | Node::Symbol(_)
            | Node::Power { .. }
            | Node::Function(..)
            | Node::Atan2 { .. }
            | Node::Undefined => {}
        }
    }
}

impl Pool {
    /// All expressions the roots are made of, roots included, in ascending order: children
    /// before parents.
    #[must_use]
    pub fn reachable(&self, roots: &[ExprId]) -> Vec<ExprId> {
        self.reachable_places(roots).ids
    }

    /// Whether some expression of the pool is of this kind.
    pub(crate) fn contains(&self, is: impl Fn(&Node) -> bool) -> bool {
        self.nodes.iter().any(is)
    }

    /// The reachable expressions with their places.
    pub(super) fn reachable_places(&self, roots: &[ExprId]) -> Reachable {
        let size = roots.iter().map(|root| root.index() + 1).max().unwrap_or(0);
        let few = if size <= SMALL_POOL { None } else { self.reachable_if_few(roots, size / 64) };
        few.unwrap_or_else(|| self.reachable_by_bits(roots, size))
    }

    /// The reachable expressions, unless there are more than `limit`.
    fn reachable_if_few(&self, roots: &[ExprId], limit: usize) -> Option<Reachable> {
        let mut places = Places::default();
        let mut ids: Vec<ExprId> = Vec::new();
        let mut visit = |id: ExprId, ids: &mut Vec<ExprId>| {
            if places.insert(id, 0).is_none() {
                ids.push(id);
            }
        };
        roots.iter().for_each(|root| visit(*root, &mut ids));
        let mut next = 0;
        while let Some(id) = ids.get(next).copied() {
            if ids.len() > limit {
                return None;
            }
            next += 1;
            self.node(id).for_each_child(|child| visit(child, &mut ids));
        }
        ids.sort_unstable();
        for (place, id) in ids.iter().enumerate() {
            places.insert(*id, place);
        }
        Some(Reachable { ids, index: Index::Sparse(places) })
    }

    /// The reachable expressions by marking children downwards from the largest root.
    fn reachable_by_bits(&self, roots: &[ExprId], size: usize) -> Reachable {
        let mut bits = vec![0u64; size.div_ceil(64)];
        let mark = |bits: &mut [u64], id: ExprId| {
            if let Some(word) = bits.get_mut(id.index() / 64) {
                *word |= 1 << (id.index() % 64);
            }
        };
        roots.iter().for_each(|root| mark(&mut bits, *root));
        let mut ids: Vec<ExprId> = Vec::new();
        for word in (0..bits.len()).rev() {
            // Children may lie in the same word, but only below.
            let mut pending = u64::MAX;
            while bits[word] & pending != 0 {
                let bit = 63 - (bits[word] & pending).leading_zeros();
                pending = (1 << bit) - 1;
                let id = ExprId((word * 64) as u32 + bit);
                ids.push(id);
                self.node(id).for_each_child(|child| mark(&mut bits, child));
            }
        }
        ids.reverse();
        let mut count = 0;
        let before = bits.iter().map(|word| {
            let before = count;
            count += word.count_ones() as usize;
            before
        });
        let before = before.collect();
        Reachable { ids, index: Index::Dense { bits, before } }
    }

    /// The symbols that occur in an expression, in order of creation.
    #[must_use]
    pub fn symbols(&self, root: ExprId) -> Vec<Symbol> {
        self.symbols_of(&[root])
    }

    /// The symbols that occur in any of the expressions, in order of creation.
    #[must_use]
    pub fn symbols_of(&self, roots: &[ExprId]) -> Vec<Symbol> {
        if roots.iter().all(|root| self.is_constant(*root)) {
            return Vec::new();
        }
        let mut symbols: Vec<Symbol> = self.reachable(roots).into_iter().filter_map(|id| self.as_symbol(id)).collect();
        symbols.put_in_order();
        symbols
    }

    /// Whether a symbol of a kind occurs in an expression.
    pub fn depends_on(&self, root: ExprId, is_wanted: &dyn Fn(Symbol) -> bool) -> bool {
        if self.is_constant(root) {
            return false;
        }
        self.reachable(&[root]).into_iter().filter_map(|id| self.as_symbol(id)).any(is_wanted)
    }

    /// For every expression of an ascending list that holds its own children, whether a wanted
    /// symbol occurs in it.
    pub(super) fn dependent(&self, reachable: &Reachable, is_wanted: impl Fn(Symbol) -> bool) -> Vec<bool> {
        let mut dependent = vec![false; reachable.ids.len()];
        for (place, id) in reachable.ids.iter().enumerate() {
            let mut depends = self.as_symbol(*id).is_some_and(&is_wanted);
            self.node(*id).for_each_child(|child| depends |= dependent[reachable.place(child)]);
            dependent[place] = depends;
        }
        dependent
    }
}
