//! Equalities between parameters under which a model is symmetric.
//!
//! Parameters of one family, or of one name but for its number, are of a kind: `m[1]` and `m[3]`,
//! `k12` and `k23`. Where all of a kind that have equal values (or where there are no values, all of a
//! kind) are one, the symmetry of M and K is searched for; then the equalities that it takes are read off
//! the entries that it takes to each other, and no others.

use std::collections::{BTreeMap, BTreeSet};

use super::pair::Pair;
use super::simplify::Algebra;
use crate::expr::{ExprId, Pool, Substitution, Symbol};
use crate::model::Model;
use crate::order::Gather;
use crate::symmetry::Symmetry;

/// Parameters that are taken to be equal, by the number of the one that stands for each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Ties {
    /// The number of the parameter that stands for it.
    leader: Vec<usize>,
    /// Which ones have the opposite value of the first of their kind.
    opposite: Vec<bool>,
}

/// The name without its number or index.
fn kind(name: &str) -> &str {
    let end = name.find(|c: char| c == '[' || c == '_' || c.is_numeric());
    name.get(..end.unwrap_or(name.len())).unwrap_or(name)
}

impl Ties {
    fn none(count: usize) -> Self {
        Self { leader: (0..count).collect(), opposite: vec![false; count] }
    }

    /// All parameters of a kind are equal: of equal values, or whatever their values.
    pub(super) fn of_a_kind(model: &Model, pool: &mut Pool, used: &[Symbol], by_value: bool) -> Self {
        let mut ties = Self::none(model.parameters.len());
        let mut first: BTreeMap<(&str, Option<ExprId>), usize> = BTreeMap::new();
        let zero = pool.zero();
        for (i, parameter) in model.parameters.iter().enumerate() {
            // What is defined from others does not occur.
            if pool.as_symbol(parameter.symbolic) != Some(parameter.symbol)
                || used.binary_search(&parameter.symbol).is_err()
            {
                continue;
            }
            let value = match (by_value, parameter.value) {
                (true, None) => continue,
                (true, value) => value,
                (false, _) => None,
            };
            let own = kind(&parameter.name);
            // Opposite values are equal but for the sign.
            if let Some(value) = value.filter(|value| *value != zero)
                && let Some(leader) = first.get(&(own, Some(pool.neg(value))))
            {
                ties.leader[i] = *leader;
                ties.opposite[i] = true;
                continue;
            }
            ties.leader[i] = *first.entry((own, value)).or_insert(i);
        }
        ties
    }

    /// Whether no two parameters are tied.
    pub(super) fn is_empty(&self) -> bool {
        self.leader.iter().enumerate().all(|(i, leader)| i == *leader)
    }

    /// What each tied parameter is replaced by.
    pub(super) fn substitution(&self, model: &Model, pool: &mut Pool) -> Substitution {
        let mut map = Substitution::new();
        for (i, leader) in self.leader.iter().enumerate().filter(|(i, l)| i != *l) {
            let value = pool.symbol_expr(model.parameters[*leader].symbol);
            let opposite = self.opposite[i] != self.opposite[*leader];
            map.insert(model.parameters[i].symbol, if opposite { pool.neg(value) } else { value });
        }
        map
    }

    /// M and K with these parameters equal, each entry in its shortest form.
    pub(super) fn applied(&self, model: &Model, pool: &mut Algebra<'_>, pair: &Pair) -> Pair {
        let map = self.substitution(model, pool);
        pair.changed(pool, |pool, values| pool.substitute(values, &map))
    }

    /// The parameters that are equal, set by set.
    pub(super) fn sets(&self, model: &Model) -> Vec<Vec<String>> {
        let mut sets: BTreeMap<usize, Vec<String>> = BTreeMap::new();
        for (i, leader) in self.leader.iter().enumerate() {
            let opposite = self.opposite[i] != self.opposite[*leader];
            let minus = if opposite { "-" } else { "" };
            sets.entry(*leader).or_default().push(format!("{minus}{}", model.parameters[i].name));
        }
        sets.into_values().filter(|set| set.len() > 1).collect()
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.leader[a], self.leader[b]);
        let (low, high) = (a.min(b), a.max(b));
        self.leader.iter_mut().filter(|leader| **leader == high).for_each(|leader| *leader = low);
    }

    /// The ties among these that a symmetry of M and K needs.
    pub(super) fn needed(&self, model: &Model, pool: &mut Algebra<'_>, pair: &Pair, symmetry: &Symmetry) -> Self {
        let mut needed = Self::none(self.leader.len());
        needed.opposite.clone_from(&self.opposite);
        let mut pairs: BTreeSet<(ExprId, ExprId)> = BTreeSet::new();
        for g in &symmetry.generators {
            for i in 0..pair.len() {
                for j in pair.columns(i) {
                    let ((to_i, a), (to_j, b)) = (g.of(i), g.of(j));
                    let (m, k) = pair.at(pool, i, j);
                    let (m2, k2) = pair.at(pool, to_i, to_j);
                    for (own, image) in [(m, m2), (k, k2)] {
                        let image = if a == b { image } else { pool.neg(image) };
                        pairs.extend((own != image).then_some((own, image)));
                    }
                }
            }
        }
        pairs.into_iter().for_each(|both| self.tie(model, pool, both, &mut needed));
        needed
    }

    /// Adds the ties that make two expressions equal.
    fn tie(&self, model: &Model, pool: &mut Algebra<'_>, (a, b): (ExprId, ExprId), needed: &mut Self) {
        let equal = |pool: &mut Algebra<'_>, ties: &Self| {
            let map = ties.substitution(model, pool);
            let images = pool.substitute(&[a, b], &map);
            pool.simplify(images[0]) == pool.simplify(images[1])
        };
        if equal(pool, needed) {
            return;
        }
        // What stands in one of them alone has its counterpart among what stands in the other alone.
        let numbers = |pool: &Pool, e: ExprId| -> Vec<usize> {
            let symbols = pool.symbols(e);
            let all = model.parameters.iter().enumerate();
            all.filter(|(_, p)| symbols.binary_search(&p.symbol).is_ok()).map(|(i, _)| i).collect()
        };
        let (left, right) = (numbers(pool, a), numbers(pool, b));
        let alone = |own: &[usize], other: &[usize]| -> Vec<usize> {
            own.iter().copied().filter(|i| !other.contains(i)).collect()
        };
        let mut tried = needed.clone();
        let mut partners = alone(&right, &left);
        for i in alone(&left, &right) {
            let partner = partners.iter().position(|j| self.leader[*j] == self.leader[i]);
            if let Some(at) = partner {
                tried.join(i, partners.remove(at));
            }
        }
        if equal(pool, &tried) {
            *needed = tried;
            return;
        }
        // Single ties among all that occur, then all of them.
        let all: BTreeSet<usize> = left.iter().chain(&right).copied().gather();
        let mut everything = needed.clone();
        for (at, i) in all.iter().enumerate() {
            for j in all.iter().skip(at + 1) {
                if self.leader[*i] != self.leader[*j] {
                    continue;
                }
                let mut single = needed.clone();
                single.join(*i, *j);
                if equal(pool, &single) {
                    *needed = single;
                    return;
                }
                everything.join(*i, *j);
            }
        }
        *needed = everything;
    }
}
