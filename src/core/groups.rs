//! What belongs together, from pairs that do.

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
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); self.0.len()];
        for i in 0..self.0.len() {
            members[self.least(i)].push(i);
        }
        members.retain(|own| !own.is_empty());
        members
    }
}

/// The groups of numbers below a count of which some pairs are linked.
pub fn connected(count: usize, linked: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut left: Vec<usize> = (0..count).collect();
    let mut parts = Vec::new();
    while !left.is_empty() {
        let mut part = vec![left.remove(0)];
        let mut at = 0;
        while let Some(i) = part.get(at).copied() {
            part.extend(left.extract_if(.., |j| linked(i, *j)));
            at += 1;
        }
        part.sort_unstable();
        parts.push(part);
    }
    parts
}
