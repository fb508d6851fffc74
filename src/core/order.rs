//! Sorting and gathering that is compiled once: the sorts of the standard library are compiled anew for each kind of item
//! and each way to compare, at three thousand lines of the compiler's code a time.
//! Lists in the innermost loops of large models are sorted by those.

use std::cmp::Ordering;

/// So many items are sorted by exchanging neighbours.
const FEW: usize = 12;

/// Stable sorting of lists, by places that are sorted first.
pub trait Order<T> {
    /// Sorts by a comparison.
    fn order_by(&mut self, compare: impl FnMut(&T, &T) -> Ordering);

    /// Sorts by a key, made anew for each comparison.
    fn order_by_key<K: Ord>(&mut self, mut key: impl FnMut(&T) -> K) {
        self.order_by(|a, b| key(a).cmp(&key(b)));
    }

    /// Sorts as the items compare.
    fn put_in_order(&mut self)
    where
        T: Ord,
    {
        self.order_by(T::cmp);
    }
}

impl<T> Order<T> for [T] {
    fn order_by(&mut self, mut compare: impl FnMut(&T, &T) -> Ordering) {
        if self.len() <= FEW {
            for end in 1..self.len() {
                let mut at = end;
                while at > 0 && compare(&self[at], &self[at - 1]).is_lt() {
                    self.swap(at, at - 1);
                    at -= 1;
                }
            }
            return;
        }
        let mut places = places(self.len(), &mut |i, j| compare(&self[*i], &self[*j]));
        for start in 0..places.len() {
            // One cycle of the permutation; places that are filled are their own.
            let mut at = start;
            loop {
                let from = std::mem::replace(&mut places[at], at);
                if from == start {
                    break;
                }
                self.swap(at, from);
                at = from;
            }
        }
    }
}

/// Which of so many items stands at each place once they are sorted.
pub fn places(count: usize, compare: &mut dyn FnMut(&usize, &usize) -> Ordering) -> Vec<usize> {
    let mut places: Vec<usize> = (0..count).collect();
    places.sort_by(compare);
    places
}

/// Maps and sets from items that need no sorting before.
pub trait Gather: Iterator + Sized {
    /// Takes one item after the other; the last of equal keys is kept.
    fn gather<C: Default + Extend<Self::Item>>(self) -> C {
        let mut all = C::default();
        all.extend(self);
        all
    }

    /// Each item once, in order.
    fn distinct(self) -> Vec<Self::Item>
    where
        Self::Item: Ord,
    {
        let mut all: Vec<Self::Item> = self.collect();
        all.put_in_order();
        all.dedup();
        all
    }

    /// What belongs to each key, keys in the order in which they come.
    fn grouped<K: PartialEq, T>(self) -> Vec<(K, Vec<T>)>
    where
        Self: Iterator<Item = (K, T)>,
    {
        let mut groups: Vec<(K, Vec<T>)> = Vec::new();
        for (key, item) in self {
            groups.under(key).push(item);
        }
        groups
    }

    /// What belongs to each of so many places, in the order in which it comes.
    fn by_place<T>(self, count: usize) -> Vec<Vec<T>>
    where
        Self: Iterator<Item = (usize, T)>,
    {
        let mut all: Vec<Vec<T>> = (0..count).map(|_| Vec::new()).collect();
        self.for_each(|(place, item)| all[place].push(item));
        all
    }

    /// The item, if there is exactly one.
    fn only(mut self) -> Option<Self::Item> {
        self.next().filter(|_| self.next().is_none())
    }
}

impl<I: Iterator> Gather for I {}

/// Lists of pairs of keys and values, each key once, in the order in which they came.
pub trait Keyed<K, V> {
    /// The value of a key; a default one at the end where there is none.
    fn under(&mut self, key: K) -> &mut V;
}

impl<K: PartialEq, V: Default> Keyed<K, V> for Vec<(K, V)> {
    fn under(&mut self, key: K) -> &mut V {
        let at = self.iter().position(|(own, _)| *own == key).unwrap_or(self.len());
        if at == self.len() {
            self.push((key, V::default()));
        }
        &mut self[at].1
    }
}
