//! What belongs together, from pairs that do.

use crate::order::Gather;

/// Groups of numbers below n that grow pair by pair; each is known by its least member.
#[derive(Clone, Debug)]
pub struct Groups(Vec<usize>);

impl Groups {
    /// Each number by itself.
    pub fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    /// The least member of a number's group.
    pub fn least(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    /// Makes one group of those of two numbers.
    pub fn join(&mut self, i: usize, j: usize) {
        let (a, b) = (self.least(i), self.least(j));
        self.0[a.max(b)] = a.min(b);
    }

    /// All groups by their least members, each in rising order.
    pub(crate) fn all(&mut self) -> Vec<Vec<usize>> {
        let count = self.0.len();
        let mut members = (0..count).map(|i| (self.least(i), i)).by_place(count);
        members.retain(|own| !own.is_empty());
        members
    }
}

/// The groups of numbers below a count of which some pairs are linked, in either order.
pub fn connected(count: usize, linked: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut groups = Groups::new(count);
    for j in 0..count {
        (0..j).filter(|i| linked(*i, j)).for_each(|i| groups.join(i, j));
    }
    groups.all()
}
