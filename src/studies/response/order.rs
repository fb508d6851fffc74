//! An order of the rows of a sparse matrix that keeps its entries near the diagonal (E. Cuthill and J. McKee, Reducing the bandwidth of
//! sparse symmetric matrices, Proc. 24th ACM National Conference (1969) 157).

use librate_core::order::{Gather, Order};

/// The place of each row: by breadth-first search from a row far out, neighbours with few neighbours first; as they stand where that is
/// no better.
pub(super) fn narrow(order: usize, entries: &[(usize, usize)]) -> Vec<usize> {
    let neighbours = neighbours(order, entries);
    let width = |places: &[usize]| entries.iter().map(|(i, j)| places[*i].abs_diff(places[*j])).max().unwrap_or(0);
    let natural: Vec<usize> = (0..order).collect();
    let mut places = vec![usize::MAX; order];
    let mut next = 0;
    for start in 0..order {
        if places[start] != usize::MAX {
            continue;
        }
        // The row that is found last from any is far out.
        let far = levels(&neighbours, start).last().copied().unwrap_or(start);
        for row in levels(&neighbours, far) {
            places[row] = next;
            next += 1;
        }
    }
    if width(&places) < width(&natural) { places } else { natural }
}

/// All rows that hang together with one, in the order of a breadth-first search from it.
pub(super) fn levels(neighbours: &[Vec<usize>], start: usize) -> Vec<usize> {
    let mut order = vec![start];
    let mut seen = std::collections::HashSet::from([start]);
    let mut at = 0;
    while let Some(row) = order.get(at) {
        let mut new: Vec<usize> = neighbours[*row].iter().copied().filter(|other| seen.insert(*other)).collect();
        new.order_by_key(|other| neighbours[*other].len());
        order.extend(new);
        at += 1;
    }
    order
}

/// The rows that each has entries with.
pub(super) fn neighbours(order: usize, entries: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let pairs = entries.iter().filter(|(row, column)| row != column);
    let all = pairs.flat_map(|(row, column)| [(*row, *column), (*column, *row)]).by_place(order);
    all.into_iter().map(|own| own.into_iter().distinct()).collect()
}
