//! A mirror: a permutation of the coordinates that leaves M and K unchanged.
//!
//! Entries count as equal where their enclosures meet, at thirty digits while a permutation is looked
//! for, and at [`BITS`] bits before it is believed: parameters may differ in the 34th digit. The coordinates are first told apart by repeated refinement of their rows'
//! contents; what is left is searched with a limited effort. Only a group with a single element
//! beside the identity is a mirror; larger groups are not named here. Nothing is ever labelled
//! that was not checked entry by entry.

use std::collections::HashMap;

use crate::linearize::Linearized;
use crate::precision::{Ball, Big};

/// Larger models are not searched.
const MOST_COORDINATES: usize = 600;
/// Steps of the search before it gives up.
const MOST_STEPS: usize = 200_000;

/// A permutation has to leave the numbers unchanged to so many bits ...
const BITS: usize = 320;
/// ... in models of up to so many coordinates; for larger ones it would take longer than the modes.
const MOST_CHECKED: usize = 200;

/// The only permutation beside the identity that leaves M and K unchanged.
pub(super) struct Mirror {
    image: Vec<usize>,
}

impl Mirror {
    /// Whether the mirror leaves the matrices unchanged in numbers of many bits too.
    pub(super) fn holds(&self, linearized: &Linearized) -> bool {
        let n = self.image.len();
        if n > MOST_CHECKED {
            return true;
        }
        let Some(precise) = linearized.precisely(BITS) else {
            return false;
        };
        let unchanged = |matrix: &[Big]| {
            let meets = |i: usize, j: usize| {
                let (own, other) = (
                    &matrix[i + n * j],
                    &matrix[self.image[i] + n * self.image[j]],
                );
                // Most entries are the same bits.
                own == other || (own - other).contains_zero()
            };
            (0..n).all(|j| (0..=j).all(|i| meets(i, j)))
        };
        unchanged(&precise.mass) && unchanged(&precise.stiffness)
    }

    /// `even` where the mirror leaves the vector unchanged, `odd` where it reverses it.
    pub(super) fn class(&self, vector: &[f64], error: f64) -> Option<&'static str> {
        if vector.len() != self.image.len() {
            return None;
        }
        let largest = vector.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let allowed = (2.0 * error).max(1e-9 * largest);
        if error.is_nan() || allowed > 1e-3 * largest {
            return None;
        }
        let mirrored = self.image.iter().map(|j| vector[*j]);
        let (mut even, mut odd) = (true, true);
        for (own, other) in vector.iter().zip(mirrored) {
            even &= (own - other).abs() <= allowed;
            odd &= (own + other).abs() <= allowed;
        }
        match (even, odd) {
            (true, false) => Some("even"),
            (false, true) => Some("odd"),
            (true, true) | (false, false) => None,
        }
    }
}

/// The mirror of a problem, if it has exactly one.
pub(super) fn mirror(n: usize, mass: &[Ball], stiffness: &[Ball]) -> Option<Mirror> {
    if !(2..=MOST_COORDINATES).contains(&n) {
        return None;
    }
    let classes = entry_classes(mass, stiffness)?;
    let colours = refine(n, &classes);
    let found = automorphisms(n, &classes, &colours)?;
    let [image] = <[Vec<usize>; 1]>::try_from(found).ok()?;
    // Coordinates that no force holds can be exchanged in any model; that is no mirror of it.
    let held = |i: usize| (0..n).any(|j| !stiffness[i + n * j].contains_zero());
    if !(0..n).any(|i| image[i] != i && held(i)) {
        return None;
    }
    // A single element beside the identity is its own inverse.
    Some(Mirror { image })
}

/// One number for each pair of entries (M_ij, K_ij), the same where both are equal.
fn entry_classes(mass: &[Ball], stiffness: &[Ball]) -> Option<Vec<u64>> {
    let of_mass = value_classes(mass)?;
    let of_stiffness = value_classes(stiffness)?;
    let pairs = of_mass.into_iter().zip(of_stiffness);
    Some(
        pairs
            .map(|(m, k)| u64::from(m) << 32 | u64::from(k))
            .collect(),
    )
}

/// Numbers values so that those whose balls meet have the same number.
fn value_classes(values: &[Ball]) -> Option<Vec<u32>> {
    if !values.iter().all(Ball::is_finite) {
        return None;
    }
    // Most entries are exact zeros; the first stands for all of them.
    let zero = values.iter().position(Ball::is_zero);
    let mut order: Vec<usize> = (0..values.len())
        .filter(|i| Some(*i) == zero || !values[*i].is_zero())
        .collect();
    order.sort_by(|a, b| {
        values[*a]
            .mid
            .partial_cmp(&values[*b].mid)
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let mut classes = vec![0; values.len()];
    let mut class = 0;
    for pair in order.windows(2) {
        let (before, after) = (&values[pair[0]], &values[pair[1]]);
        // Rounding differs with the order of summation: a little more than the radii is allowed.
        let gap = (after.mid - before.mid).hi;
        let reach = before.radius + after.radius + 1e-29 * after.mid.hi.abs();
        if gap > reach {
            class += 1;
        }
        classes[pair[1]] = class;
    }
    if let Some(zero) = zero {
        let class = classes[zero];
        for (own, value) in classes.iter_mut().zip(values) {
            if value.is_zero() {
                *own = class;
            }
        }
    }
    Some(classes)
}

/// The class that most entries beside the diagonal have.
fn commonest(n: usize, classes: &[u64]) -> Option<u64> {
    let mut beside: Vec<u64> = (0..n * n)
        .filter(|at| at % n != at / n)
        .map(|at| classes[at])
        .collect();
    beside.sort_unstable();
    let most = beside.chunk_by(|a, b| a == b).max_by_key(|same| same.len());
    most.and_then(|same| same.first()).copied()
}

/// Colours coordinates until those of one colour see the same colours in their rows.
///
/// Entries of the commonest class are left out of the rows: the colours of all coordinates
/// together are the same seen from each, so that what is seen through the other classes and the
/// own colour tells those.
fn refine(n: usize, classes: &[u64]) -> Vec<u32> {
    let common = commonest(n, classes);
    let rows: Vec<Vec<(u64, usize)>> = (0..n)
        .map(|i| {
            (0..n)
                .filter(|j| *j != i && Some(classes[i + n * j]) != common)
                .map(|j| (classes[i + n * j], j))
                .collect()
        })
        .collect();
    let mut colours: Vec<u32> = vec![0; n];
    let mut count = 1;
    loop {
        let mut numbers: HashMap<(u32, Vec<(u64, u32)>), u32> = HashMap::new();
        let mut next = Vec::with_capacity(n);
        for i in 0..n {
            let mut row: Vec<(u64, u32)> = rows[i]
                .iter()
                .map(|(class, j)| (*class, colours[*j]))
                .collect();
            row.sort_unstable();
            row.push((classes[i + n * i], colours[i]));
            let fresh = u32::try_from(numbers.len()).unwrap_or(u32::MAX);
            next.push(*numbers.entry((colours[i], row)).or_insert(fresh));
        }
        let new_count = numbers.len();
        colours = next;
        if new_count == count {
            return colours;
        }
        count = new_count;
    }
}

/// The permutations beside the identity, at most two; `None` where the search was given up.
fn automorphisms(n: usize, classes: &[u64], colours: &[u32]) -> Option<Vec<Vec<usize>>> {
    // Coordinates of rare colours first: they leave little choice.
    let mut sizes: HashMap<u32, usize> = HashMap::new();
    for colour in colours {
        *sizes.entry(*colour).or_insert(0) += 1;
    }
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by_key(|i| (sizes[&colours[*i]], *i));
    let mut image = vec![usize::MAX; n];
    let mut used = vec![false; n];
    let mut found = Vec::new();
    // For each depth: the next candidate to try.
    let mut next = vec![0];
    let mut steps = 0;
    while let Some(depth) = next.len().checked_sub(1) {
        if depth == n {
            let identity = image.iter().enumerate().all(|(i, j)| i == *j);
            if !identity {
                found.push(image.clone());
                if found.len() == 2 {
                    return Some(found);
                }
            }
            next.pop();
            continue;
        }
        let i = order[depth];
        if image[i] != usize::MAX {
            used[image[i]] = false;
            image[i] = usize::MAX;
        }
        let candidate = (next[depth]..n).find(|j| {
            steps += 1;
            !used[*j]
                && colours[*j] == colours[i]
                && classes[i + n * i] == classes[*j + n * *j]
                && order[..depth]
                    .iter()
                    .all(|k| classes[i + n * k] == classes[*j + n * image[*k]])
        });
        if steps > MOST_STEPS {
            return None;
        }
        match candidate {
            Some(j) => {
                image[i] = j;
                used[j] = true;
                next[depth] = j + 1;
                next.push(0);
            }
            None => {
                next.pop();
            }
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use crate::linearize::linearize;
    use crate::model::{Settings, TableTexts, elaborate};
    use crate::modes::Options;
    use crate::oscillation::normal_modes;
    use crate::syntax::parse;

    fn classes(length: &str) -> Vec<Option<String>> {
        let text = format!(
            "param g = 9.81  param l[1..2] = [1, {length}]  coord phi[1..2]
             T = sum(i in 1..2, 1/2*l[i]^2*phi[i]'^2)
             V = sum(i in 1..2, g*l[i]*(1 - cos(phi[i]))) + (phi[1] - phi[2])^2"
        );
        let file = parse(&text).unwrap();
        let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
        let normal = normal_modes(&linearize(model).unwrap(), &Options::default()).unwrap();
        normal.modes.into_iter().map(|mode| mode.symmetry).collect()
    }

    #[test]
    fn nearly_equal_is_no_mirror() {
        let both = [Some("even".to_owned()), Some("odd".to_owned())];
        assert_eq!(classes("1"), both);
        assert_eq!(classes("1 + 1e-33"), [None, None]);
        assert_eq!(classes("1 + 1e-80"), [None, None]);
    }
}
