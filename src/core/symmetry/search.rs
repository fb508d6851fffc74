//! Generators of the automorphism group of a coloured graph: refinement of hashed rows, and a search
//! with a limited effort.
//!
//! A base is a list of vertices of which each is told apart in turn, with refinement in between, until
//! all vertices differ. From its end to its beginning, one automorphism is searched for each vertex
//! that the next base vertex may be taken to and isn't yet, with all base vertices before held where
//! they are. So the orbits multiply to the order of the group, and no two searches find the same
//! (Sims, 1970; B. D. McKay, Congressus Numerantium 30 (1981) 45).

use crate::expr::mix;
use crate::groups::Groups;
use crate::order::Order;

/// A graph with labelled edges; equal labels are equal numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct Graph {
    /// What tells vertices apart from the start.
    pub(super) colours: Vec<u64>,
    /// Neighbours in ascending order, with the labels of the edges; both directions are there, with one label.
    pub(super) rows: Vec<Vec<(usize, u64)>>,
    /// Whether vertices 2i and 2i + 1 are each other's opposites, which no permutation takes apart.
    pub(super) opposites: bool,
}

/// A group of permutations, each given by the images of 0, 1, … or with signs.
pub(super) struct Group<P = Vec<usize>> {
    /// None of them is in the group that those before it generate.
    pub(super) generators: Vec<P>,
    /// How many elements the group has.
    pub(super) order: f64,
}

/// Colours after the base vertices of a level have been told apart.
struct Level {
    colours: Vec<u64>,
    sorted: Vec<u64>,
    /// The next base vertex; none where all vertices differ.
    base: Option<usize>,
}

fn sorted(colours: &[u64]) -> Vec<u64> {
    let mut sorted = colours.to_vec();
    sorted.sort_unstable();
    sorted
}

fn distinct(sorted: &[u64]) -> usize {
    sorted.chunk_by(|a, b| a == b).count()
}

impl Graph {
    fn edges(&self) -> usize {
        self.rows.iter().map(Vec::len).sum::<usize>() + self.rows.len()
    }

    /// Colours vertices anew by what they see until that tells no more of them apart. A hash that
    /// comes out equal by chance tells too few apart, which costs time and nothing else. `effort` is how many looks at an edge are
    /// left.
    fn refine(&self, mixed: &[Vec<(usize, u64)>], colours: &mut Vec<u64>, effort: &mut usize) -> Option<Vec<u64>> {
        let mut count = distinct(&sorted(colours));
        let mut rounds = 1;
        loop {
            *effort = effort.checked_sub(rounds * self.edges())?;
            for _ in 0..rounds {
                let next = mixed.iter().zip(colours.iter()).map(|(row, own)| {
                    row.iter().fold(mix(*own), |sum, (j, label)| {
                        let seen = colours.get(*j).copied().unwrap_or(0);
                        sum.wrapping_add(mix(seen ^ label))
                    })
                });
                *colours = next.collect();
            }
            let new = sorted(colours);
            let new_count = distinct(&new);
            if new_count <= count || new_count == colours.len() {
                return Some(new);
            }
            count = new_count;
            // Looking whether it is over costs more than a round.
            rounds = (2 * rounds).min(64);
        }
    }

    /// The rows with labels in which every bit counts.
    fn mixed(&self) -> Vec<Vec<(usize, u64)>> {
        let row = |row: &Vec<(usize, u64)>| row.iter().map(|(j, label)| (*j, mix(*label))).collect();
        self.rows.iter().map(row).collect()
    }

    /// Whether refinement tells all vertices apart.
    pub(super) fn all_differ(&self, mut effort: usize) -> Option<bool> {
        let mut colours = self.colours.clone();
        let sorted = self.refine(&self.mixed(), &mut colours, &mut effort)?;
        Some(distinct(&sorted) == colours.len())
    }

    /// The largest number of vertices of which any two can be exchanged while all others stay.
    ///
    /// Two such see the same beside each other, so that with themselves among their neighbours, by the label
    /// of the edge between them if there is one, they see the same throughout; being exchanged by chance of
    /// equal hashes is checked, so that the number may be too small and never too large.
    pub(super) fn most_alike(&self) -> usize {
        let mut keys: Vec<(u64, usize)> = Vec::new();
        let mut labels: Vec<u64> = Vec::new();
        for (i, row) in self.rows.iter().enumerate() {
            let seen = |j: usize, label: u64| mix(j as u64 ^ mix(label));
            let sum = row.iter().fold(mix(self.colours[i]), |sum, (j, label)| sum.wrapping_add(seen(*j, *label)));
            labels.clear();
            labels.extend(row.iter().map(|(_, label)| *label));
            labels.sort_unstable();
            labels.dedup();
            keys.push((sum, i));
            let with_itself = |label: &u64| sum.wrapping_add(seen(i, *label)) ^ mix(*label);
            keys.extend(labels.iter().map(|label| (with_itself(label), i)));
        }
        keys.put_in_order();
        let alike = keys.chunk_by(|a, b| a.0 == b.0).map(|group| {
            let first = group[0].1;
            let exchanged = group[1..].iter().filter(|(_, i)| self.exchange(first, *i).is_some());
            1 + exchanged.count()
        });
        alike.max().unwrap_or(0)
    }

    /// The permutation that exchanges two vertices, and their opposites, if it keeps colours and edges.
    fn exchange(&self, a: usize, b: usize) -> Option<Vec<usize>> {
        let opposite = |i: usize| if self.opposites { i ^ 1 } else { i };
        if opposite(a) == b && a != b {
            return None;
        }
        let moved = [(a, b), (opposite(a), opposite(b))];
        let image = |i: usize| {
            let to = moved.iter().find_map(|(x, y)| match i {
                i if i == *x => Some(*y),
                i if i == *y => Some(*x),
                _ => None,
            });
            to.unwrap_or(i)
        };
        // Edges have one label for both directions: where the rows of those that move are kept, so are
        // all others.
        self.keeps(image, moved.iter().map(|(from, _)| *from)).then(|| (0..self.rows.len()).map(image).collect())
    }

    fn level(&self, mixed: &[Vec<(usize, u64)>], mut colours: Vec<u64>, effort: &mut usize) -> Option<Level> {
        let sorted = self.refine(mixed, &mut colours, effort)?;
        let base = smallest_cell(&colours, &sorted);
        Some(Level { colours, sorted, base })
    }

    /// Whether a permutation keeps the colours and edges of some vertices.
    fn keeps(&self, image: impl Fn(usize) -> usize, mut vertices: impl Iterator<Item = usize>) -> bool {
        let mut row_image: Vec<(usize, u64)> = Vec::new();
        vertices.all(|i| {
            row_image.clear();
            row_image.extend(self.rows[i].iter().map(|(j, label)| (image(*j), *label)));
            row_image.put_in_order();
            self.colours[i] == self.colours[image(i)] && self.rows[image(i)] == row_image
        })
    }

    /// The automorphism group; `None` where the effort does not suffice.
    pub(super) fn automorphisms(&self, mut effort: usize) -> Option<Group> {
        let mut found: Group = Group { generators: Vec::new(), order: 1.0 };
        let mixed = self.mixed();
        let mut levels = vec![self.level(&mixed, self.colours.clone(), &mut effort)?];
        while let Some(base) = levels.last().and_then(|level| level.base) {
            let colours = levels.last().map_or_else(Vec::new, |level| level.colours.clone());
            levels.push(self.level(&mixed, singled_out(colours, base), &mut effort)?);
        }
        for depth in (0..levels.len()).rev() {
            let Some(base) = levels[depth].base else { continue };
            let colour = levels[depth].colours[base];
            let mut orbits = Groups::new(self.rows.len());
            let join = |orbits: &mut Groups, generator: &[usize]| {
                generator.iter().enumerate().for_each(|(i, j)| orbits.join(i, *j));
            };
            found.generators.iter().for_each(|generator| join(&mut orbits, generator));
            let mut refused: Vec<usize> = Vec::new();
            for to in 0..self.rows.len() {
                let known = orbits.least(to);
                if levels[depth].colours[to] != colour || known == orbits.least(base) || refused.contains(&known) {
                    continue;
                }
                // Base vertices are the first of their kind, so that the search would find no other.
                let generator = match self.exchange(base, to) {
                    Some(generator) => Some(generator),
                    None => self.search(&mixed, &levels, depth, to, &mut effort)?,
                };
                match generator {
                    Some(generator) => {
                        join(&mut orbits, &generator);
                        refused = refused.iter().map(|at| orbits.least(*at)).collect();
                        found.generators.push(generator);
                    }
                    None => refused.push(known),
                }
            }
            let own = orbits.least(base);
            let size = (0..self.rows.len()).filter(|i| orbits.least(*i) == own).count();
            found.order *= size as f64;
        }
        Some(found)
    }

    /// An automorphism that holds the base vertices before `depth` and takes the next one to `to`.
    fn search(
        &self,
        mixed: &[Vec<(usize, u64)>],
        levels: &[Level],
        depth: usize,
        to: usize,
        effort: &mut usize,
    ) -> Option<Option<Vec<usize>>> {
        let start = levels[depth].colours.clone();
        // What is to be tried: a coloured target, its depth, and the vertex to single out.
        let mut open = vec![(start, depth, to)];
        while let Some((colours, depth, to)) = open.pop() {
            let mut colours = singled_out(colours, to);
            let target = self.refine(mixed, &mut colours, effort)?;
            let Some(source) = levels.get(depth + 1).filter(|source| target == source.sorted) else { continue };
            match source.base {
                Some(base) => {
                    let colour = source.colours[base];
                    let choices: Vec<usize> = (0..colours.len()).rev().filter(|j| colours[*j] == colour).collect();
                    *effort = effort.checked_sub(choices.len() * colours.len())?;
                    open.extend(choices.into_iter().map(|j| (colours.clone(), depth + 1, j)));
                }
                None => {
                    let mut places: Vec<(u64, usize)> = colours.iter().copied().zip(0..colours.len()).collect();
                    places.put_in_order();
                    let place = |colour| Some(places[places.binary_search_by_key(colour, |(c, _)| *c).ok()?].1);
                    let image: Vec<usize> = source.colours.iter().filter_map(place).collect();
                    *effort = effort.checked_sub(self.edges())?;
                    if image.len() == colours.len() && self.keeps(|i| image[i], 0..image.len()) {
                        return Some(Some(image));
                    }
                }
            }
        }
        Some(None)
    }
}

fn singled_out(mut colours: Vec<u64>, vertex: usize) -> Vec<u64> {
    if let Some(colour) = colours.get_mut(vertex) {
        *colour = mix(!*colour);
    }
    colours
}

/// The first vertex of the smallest set of several vertices that look the same.
fn smallest_cell(colours: &[u64], sorted: &[u64]) -> Option<usize> {
    let smallest = sorted.chunk_by(|a, b| a == b).filter(|cell| cell.len() > 1).min_by_key(|cell| cell.len())?;
    colours.iter().position(|colour| Some(colour) == smallest.first())
}
