//! Motions that stretch no element: the kernel of the matrix of all ∇s.
//!
//! Take coordinates S on which no generalised force acts at rest, and the elements E that depend on any of them, fewer than S has
//! coordinates. The forces on S vanish: Σ_E phi_e' ∇s_e = 0 in S. If these ∇s_e, cut to S, are linearly independent, every
//! phi_e' of E is 0 exactly, however the numbers round; so K x = Σ phi_e'' ∇s_e (∇s_e·x) for x in S, and it
//! vanishes for the x that all ∇s_e annihilate, |S| - |E| of them at least. Balls enclose a basis: a
//! pivot whose ball excludes 0 proves the independence of its row. Nothing is concluded where a
//! pivot's ball contains 0.
//!
//! The largest such S is found by counting alone: what a largest matching of coordinates with
//! elements leaves over, and what can be reached from there (Dulmage, Mendelsohn, "Coverings of
//! bipartite graphs", Canad. J. Math. 10 (1958)). It is all of a chain without walls, or one mass that
//! hangs loose on a rigid body.

use std::collections::VecDeque;

use super::assemble::{Assembly, Values};
use super::constrained::{eliminate, largest_among};
use crate::number::Number;
use crate::order::Gather;
use crate::precision::{Eliminated, Enclosure};

/// Elimination of dense rows is for systems of moderate size.
const MOST: usize = 400;

/// Vectors that all ∇s annihilate.
pub(crate) struct Kernel<S> {
    /// The coordinates with pivots.
    pub(crate) pivots: Vec<usize>,
    /// One vector for each coordinate without: 1 there, and 0 at the others without.
    pub(crate) vectors: Vec<(usize, Vec<S>)>,
}

/// The kernel of all ∇s of elements that are shown to be unstressed; `None` where counting finds nothing
/// or the elements can't be shown to be independent. `wanted`: the coordinates to have pivots,
/// which make the vectors the same in whatever numbers.
pub(crate) fn kernel<S: Enclosure>(
    assembly: &Assembly,
    at: &[S],
    values: &Values<S>,
    wanted: Option<&[usize]>,
) -> Option<Kernel<S>> {
    let n = at.len();
    let number = |value: i64| S::from_number(&Number::from(value), values.precision());
    let (zero, one) = (number(0), number(1));
    let slopes = assembly.slopes(at, values);
    let (loose, touching) = loose(n, &slopes);
    let unforced = assembly.without_force_at_rest(n);
    if loose.is_empty() || loose.len() > MOST || !loose.iter().all(|i| unforced[*i]) {
        return None;
    }
    let mut place = vec![usize::MAX; n];
    for (at, coordinate) in loose.iter().enumerate() {
        place[*coordinate] = at;
    }
    let row = |element: &usize| {
        let mut row = vec![zero.clone(); loose.len()];
        for (coordinate, entry) in &slopes[*element] {
            if let Some(to) = row.get_mut(place[*coordinate]) {
                *to = entry.clone();
            }
        }
        row
    };
    let among = wanted.map(|wanted| wanted.iter().map(|coordinate| place[*coordinate]).collect::<Vec<_>>());
    let rank = largest_among(among.as_deref());
    let Eliminated { pivots, rows } = eliminate(touching.iter().map(row).collect(), rank, values.precision())?;
    let free = (0..loose.len()).filter(|column| !pivots.contains(column));
    let vector = |column: usize| {
        let mut vector = vec![zero.clone(); n];
        vector[loose[column]] = one.clone();
        for (row, pivot) in pivots.iter().enumerate() {
            vector[loose[*pivot]] = rows[row][column].neg();
        }
        (loose[column], vector)
    };
    Some(Kernel { vectors: free.map(vector).collect(), pivots: pivots.iter().map(|pivot| loose[*pivot]).collect() })
}

/// The coordinates that a largest matching with elements leaves over or that can be reached from
/// those, and the elements that depend on these, fewer by as many as were left over.
fn loose<S>(n: usize, slopes: &[Vec<(usize, S)>]) -> (Vec<usize>, Vec<usize>) {
    let elements = slopes.iter().enumerate().flat_map(|(element, row)| row.iter().map(move |(i, _)| (*i, element)));
    let elements = elements.by_place(n);
    const NONE: usize = usize::MAX;
    // The coordinate that each element is matched with.
    let mut matched = vec![NONE; slopes.len()];
    let mut left: Vec<usize> = Vec::new();
    // The search that last came by, and the coordinate it came from.
    let mut seen = vec![NONE; slopes.len()];
    let mut from = vec![NONE; slopes.len()];
    let mut own = vec![NONE; n];
    for start in 0..n {
        // Breadth first along alternating paths to an element without a partner.
        let mut queue = VecDeque::from([start]);
        let mut end = NONE;
        while let Some(coordinate) = queue.pop_front() {
            for &element in &elements[coordinate] {
                if seen[element] == start || end != NONE {
                    continue;
                }
                seen[element] = start;
                from[element] = coordinate;
                match matched[element] {
                    NONE => end = element,
                    partner => queue.push_back(partner),
                }
            }
            if end != NONE {
                break;
            }
        }
        if end == NONE {
            left.push(start);
        }
        while end != NONE {
            let coordinate = from[end];
            let before = own[coordinate];
            matched[end] = coordinate;
            own[coordinate] = end;
            end = before;
        }
    }
    let mut inside = vec![false; n];
    let mut touched = vec![false; slopes.len()];
    let mut queue: VecDeque<usize> = left.iter().copied().collect();
    left.iter().for_each(|&coordinate| inside[coordinate] = true);
    while let Some(coordinate) = queue.pop_front() {
        for &element in &elements[coordinate] {
            let partner = matched[element];
            touched[element] = true;
            // An element without a partner would have lengthened the matching.
            if partner != NONE && !inside[partner] {
                inside[partner] = true;
                queue.push_back(partner);
            }
        }
    }
    let all = |marks: &[bool]| -> Vec<usize> {
        let marked = marks.iter().enumerate().filter(|(_, mark)| **mark);
        marked.map(|(at, _)| at).collect()
    };
    (all(&inside), all(&touched))
}
