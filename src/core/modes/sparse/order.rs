//! In which order the rows of a sparse symmetric matrix are eliminated: by minimum degree, or by nested dissection where that is less work.

use faer::Side;
use faer::perm::PermRef;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use feral_metis::{CscPattern, metis_order};
use hashbrown::HashMap;

use crate::order::Gather;

/// Multiplications of an elimination that are worth looking for a better order.
const MUCH: f64 = 2e9;

/// What is known of a factor L before its numbers.
pub(super) struct Elimination {
    /// The pattern of L Lᵀ.
    pub(super) symbolic: SymbolicCholesky<usize>,
    /// The most entries in a row of L.
    pub(super) widest: usize,
    /// About how many multiplications it takes.
    work: f64,
}

/// An elimination for a pattern given by its upper triangle, column by column, in an order of all rows where one is given. `None`
/// where there is no memory for it.
pub(super) fn elimination(starts: &[usize], rows: &[usize], order: Option<&[usize]>) -> Option<Elimination> {
    let in_order = |order: &[usize]| {
        let mut places = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, row)| places[*row] = place);
        let order = PermRef::new_checked(order, &places, order.len());
        factored(starts, rows, SymmetricOrdering::Custom(order))
    };
    let own = match order {
        Some(order) => in_order(order)?,
        None => factored(starts, rows, SymmetricOrdering::Amd)?,
    };
    if order.is_none()
        && own.work > MUCH
        && let Some(order) = dissection(starts, rows)
        && let Some(better) = in_order(&order).filter(|other| other.work < own.work)
    {
        return Some(better);
    }
    Some(own)
}

fn factored(starts: &[usize], rows: &[usize], ordering: SymmetricOrdering<'_, usize>) -> Option<Elimination> {
    let n = starts.len() - 1;
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, starts, None, rows);
    let symbolic =
        factorize_symbolic_cholesky(pattern, Side::Upper, ordering, CholeskySymbolicParams::default()).ok()?;
    let (widest, work) = counts(&symbolic, n);
    Some(Elimination { symbolic, widest, work })
}

/// The most entries in a row of L, and about the multiplications that an elimination takes: the squares of the entries in its columns.
fn counts(symbolic: &SymbolicCholesky<usize>, n: usize) -> (usize, f64) {
    let mut counts = vec![1_usize; n];
    let mut work = 0.0;
    match symbolic.raw() {
        SymbolicCholeskyRaw::Simplicial(own) => {
            own.row_idx().iter().for_each(|i| counts[*i] += 1);
            work += own.col_ptr().windows(2).map(|pair| ((pair[1] - pair[0]) as f64).powi(2)).sum::<f64>();
        }
        SymbolicCholeskyRaw::Supernodal(own) => {
            for s in 0..own.n_supernodes() {
                let (first, end) = (own.supernode_begin()[s], own.supernode_end()[s]);
                let below = own.supernode(s).pattern();
                (first..end).for_each(|i| counts[i] += i - first);
                below.iter().for_each(|i| counts[*i] += end - first);
                work += (first..end).map(|i| ((end - i + below.len()) as f64).powi(2)).sum::<f64>();
            }
        }
    }
    (counts.into_iter().max().unwrap_or(0), work)
}

/// An order by nested dissection (G. Karypis, V. Kumar, "A fast and high quality multilevel scheme for partitioning irregular graphs", SIAM J.
/// Sci. Comput. 20 (1998) 359) of the graph in which rows with entries in the same columns, as the axes of a point, are one node.
fn dissection(starts: &[usize], rows: &[usize]) -> Option<Vec<usize>> {
    let n = starts.len() - 1;
    // Both triangles, every row in rising order.
    let entries = (0..n).flat_map(|j| rows[starts[j]..starts[j + 1]].iter().map(move |i| (*i, j)));
    let both = entries.flat_map(|(i, j)| [(j, i)].into_iter().chain((i != j).then_some((i, j))));
    let columns = both.by_place(n);
    let mut numbers: HashMap<&[usize], usize> = HashMap::new();
    let mut nodes: Vec<Vec<usize>> = Vec::new();
    let mut node_of = Vec::with_capacity(n);
    for (i, column) in columns.iter().enumerate() {
        let node = *numbers.entry(column).or_insert(nodes.len());
        if node == nodes.len() {
            nodes.push(Vec::new());
        }
        nodes[node].push(i);
        node_of.push(i32::try_from(node).ok()?);
    }
    let (mut ends, mut neighbours) = (vec![0_i32], Vec::new());
    for (node, members) in nodes.iter().enumerate() {
        let others = columns[*members.first()?].iter().map(|j| node_of[*j]);
        neighbours.extend(others.filter(|other| *other as usize != node).distinct());
        ends.push(i32::try_from(neighbours.len()).ok()?);
    }
    let order = metis_order(&CscPattern::new(nodes.len(), &ends, &neighbours)?).ok()?;
    Some(order.into_iter().flat_map(|node| nodes[node as usize].iter().copied()).collect())
}
