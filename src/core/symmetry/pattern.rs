//! Which entries of M and K are equal, and the graphs whose automorphisms are their symmetries.

use hashbrown::HashMap;

use super::SignedPermutation;
use super::search::{Graph, Group};
use crate::groups::Groups;
use crate::order::Order;

/// Elements looked through for one that differs from another only by signs.
const MOST_KNOWN: usize = 200;

/// What a pair of matrices looks like: equal numbers stand for equal pairs of entries (M_ij, K_ij).
#[derive(Clone, Debug, Default)]
pub struct Pattern {
    /// Beside the diagonal, by row, in ascending order of columns: what is not 0.
    rows: Vec<Vec<(usize, i64)>>,
    diagonal: Vec<u64>,
    /// Whether some force acts along the coordinate or between it and others.
    held: Vec<bool>,
}

impl Pattern {
    /// A pattern without entries.
    #[must_use]
    pub fn new(coordinates: usize) -> Self {
        Self { rows: vec![Vec::new(); coordinates], diagonal: vec![0; coordinates], held: vec![false; coordinates] }
    }

    /// How many coordinates there are.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Says what stands on the diagonal; `held` where the stiffness is not 0.
    pub fn set_diagonal(&mut self, coordinate: usize, label: u64, held: bool) {
        if let (Some(own), Some(is_held)) = (self.diagonal.get_mut(coordinate), self.held.get_mut(coordinate)) {
            *own = label;
            *is_held |= held;
        }
    }

    /// Says what stands at (i, j), in rows and columns in ascending order: not 0, with opposite numbers
    /// for opposite entries; `held` where the stiffness is not 0.
    pub fn push(&mut self, i: usize, j: usize, label: i64, held: bool) {
        if i == j || j >= self.len() {
            return;
        }
        if let (Some(row), Some(is_held)) = (self.rows.get_mut(i), self.held.get_mut(i)) {
            row.push((j, label));
            *is_held |= held;
        }
    }

    /// Says that a constraint holds two coordinates together, whatever their signs.
    pub(crate) fn tie(&mut self, i: usize, j: usize) {
        let Some(row) = self.rows.get_mut(i) else { return };
        if let Err(at) = row.binary_search_by_key(&j, |(j, _)| *j)
            && i != j
        {
            row.insert(at, (j, 0));
        }
        self.held[i] = true;
    }

    /// The coordinates of each part that hangs together by entries of M and K.
    pub(crate) fn parts(&self) -> Vec<Vec<usize>> {
        let mut together = Groups::new(self.len());
        for (i, row) in self.rows.iter().enumerate() {
            row.iter().filter(|(_, label)| *label != 0).for_each(|(j, _)| together.join(i, *j));
        }
        together.all()
    }

    /// The number of its part, for each coordinate.
    pub(super) fn components(&self) -> Vec<usize> {
        let mut component = vec![0; self.len()];
        for (number, group) in self.parts().into_iter().enumerate() {
            group.into_iter().for_each(|i| component[i] = number);
        }
        component
    }

    /// The coordinates in parts where some force acts.
    pub(crate) fn active(&self) -> Vec<bool> {
        let component = self.components();
        let mut held = vec![false; self.len()];
        component.iter().zip(&self.held).for_each(|(own, is_held)| held[*own] |= is_held);
        component.iter().map(|own| held[*own]).collect()
    }

    /// Whether a signed permutation leaves the pattern unchanged.
    #[must_use]
    pub fn is_kept_by(&self, g: &SignedPermutation) -> bool {
        let mut moved: Vec<(usize, i64)> = Vec::new();
        g.len() == self.len()
            && self.rows.iter().enumerate().all(|(i, row)| {
                let (to, sign) = g.of(i);
                moved.clear();
                moved.extend(row.iter().map(|(j, label)| {
                    let (column, other) = g.of(*j);
                    (column, if sign == other { *label } else { -*label })
                }));
                moved.put_in_order();
                self.diagonal.get(to) == self.diagonal.get(i) && self.rows.get(to) == Some(&moved)
            })
    }

    /// What differs from the start: entries of the diagonal; each coordinate outside of the symmetry
    /// from all others.
    fn colours(&self, active: &[bool]) -> Vec<u64> {
        let diagonal = self.diagonal.iter().zip(active).enumerate();
        diagonal.map(|(i, (label, active))| if *active { 2 * label } else { 2 * i as u64 + 1 }).collect()
    }

    /// Whether no two coordinates can be exchanged, whatever the signs; `None` where the effort does
    /// not suffice.
    pub(super) fn all_differ(&self, active: &[bool]) -> Option<bool> {
        let mut colours = self.colours(active);
        colours.sort_unstable();
        if colours.windows(2).all(|pair| pair[0] != pair[1]) {
            return Some(true);
        }
        self.graph(active, i64::unsigned_abs).all_differ(super::EFFORT)
    }

    /// The graph for permutations without signs.
    fn unsigned(&self, active: &[bool]) -> Graph {
        self.graph(active, |label| label as u64)
    }

    fn graph(&self, active: &[bool], of: impl Fn(i64) -> u64) -> Graph {
        let row = |row: &Vec<(usize, i64)>| row.iter().map(|(j, label)| (*j, of(*label))).collect();
        Graph { colours: self.colours(active), rows: self.rows.iter().map(row).collect(), opposites: false }
    }

    /// The largest number of coordinates of which any two can be exchanged while all others stay.
    pub(super) fn most_alike(&self, active: &[bool]) -> usize {
        self.unsigned(active).most_alike()
    }

    /// The permutations without signs.
    pub(super) fn permutations(&self, active: &[bool], effort: usize) -> Option<Group<SignedPermutation>> {
        let found = self.unsigned(active).automorphisms(effort)?;
        let generators = found.generators.into_iter();
        Some(Group { generators: generators.map(SignedPermutation::unsigned).collect(), order: found.order })
    }

    /// The permutations with signs, without those that only change signs.
    ///
    /// Coordinate i becomes two vertices, 2i for itself and 2i + 1 for its opposite, joined by an edge
    /// of a label of its own; an entry joins equal ends by its label and opposite ones by the opposite.
    pub(super) fn signed_permutations(&self, active: &[bool], effort: usize) -> Option<Group<SignedPermutation>> {
        let mut graph = Graph { opposites: true, ..Graph::default() };
        for (i, colour) in self.colours(active).into_iter().enumerate() {
            for opposite in [0, 1] {
                let mut row: Vec<(usize, u64)> = vec![(2 * i + 1 - opposite, 0)];
                for (j, label) in &self.rows[i] {
                    row.push((2 * j + opposite, *label as u64));
                    row.push((2 * j + 1 - opposite, label.wrapping_neg() as u64));
                }
                row.put_in_order();
                graph.colours.push(colour);
                graph.rows.push(row);
            }
        }
        let found = graph.automorphisms(effort)?;
        let component = self.components();
        let order = self.parts().iter().fold(found.order, |order, _| order / 2.0);
        let mut generators: Vec<SignedPermutation> = Vec::new();
        for image in found.generators {
            let mut g = SignedPermutation {
                image: image.iter().step_by(2).map(|to| to / 2).collect(),
                negative: image.iter().step_by(2).map(|to| to % 2 == 1).collect(),
            };
            prefer_positive(&mut g, &component);
            // Signs aside it may be known.
            let known = SignedPermutation::group(&generators, MOST_KNOWN);
            let is_new = known.iter().all(|other| other.image != g.image);
            if !g.moves_nothing() && is_new {
                generators.push(g);
            }
        }
        Some(Group { generators, order })
    }
}

/// Turns the signs of each part that hangs together so that most are positive, or where as many are
/// negative the first one is.
fn prefer_positive(g: &mut SignedPermutation, component: &[usize]) {
    let mut balance: HashMap<usize, (i64, bool)> = HashMap::new();
    for (own, negative) in component.iter().zip(&g.negative) {
        let (balance, _) = balance.entry(*own).or_insert((0, *negative));
        *balance += if *negative { -1 } else { 1 };
    }
    for (own, negative) in component.iter().zip(&mut g.negative) {
        if let Some((balance, first)) = balance.get(own) {
            *negative ^= *balance < 0 || (*balance == 0 && *first);
        }
    }
}
