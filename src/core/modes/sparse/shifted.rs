//! K - σ M as L D Lᵀ: its inertia with a proof, and solutions of linear systems without one.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLdltRef;
use faer::sparse::linalg::cholesky::{LdltRef, SymbolicCholesky, SymbolicCholeskyRaw};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use std::sync::{Arc, Mutex};

use super::lanczos::{Seed, dot};
use super::order::{Elimination, elimination};
use super::rows::{Rows, U};
use crate::precision::{LANES, Lane, SparseMatrix, up};

/// Steps of an inverse iteration that tells 1 from 1000.
const ITERATIONS: usize = 5;

/// K x = λ M x with sparse matrices, and what bounds are made of.
pub(super) struct Pencil {
    pub(super) stiffness: Rows,
    pub(super) mass: Rows,
    /// With d so that M - diag(d) is not negative: √d rounded up, 1/√d rounded up, and the least d.
    pub(super) weights: Vec<f64>,
    pub(super) roots: Vec<f64>,
    pub(super) least_weight: f64,
    /// Bounds in length of |D^(-1/2) A D^(-1/2)| for the magnitudes of A and for their radii, D = diag(d).
    pub(super) stiffness_norms: (f64, f64),
    pub(super) mass_norms: (f64, f64),
    /// How K - σ M is decomposed, in the order of [`elimination`]; `None` where K and M are tridiagonal: in that of the coordinates.
    general: Option<Arc<General>>,
}

/// What decompositions of matrices with one pattern share.
struct General {
    symbolic: SymbolicCholesky<usize>,
    /// The upper triangle of K - σ M, column by column.
    starts: Vec<usize>,
    rows: Vec<usize>,
    /// The most entries in a row of L.
    widest: usize,
}

/// An order in which the rows of matrices with one pattern are eliminated, with what was known of the last of them.
pub(super) struct GivenOrder<'a> {
    pub(super) rows: &'a [usize],
    pub(super) last: &'a Pattern,
}

/// What was known of a decomposition, for those of other matrices with the same pattern.
#[derive(Default)]
pub(super) struct Pattern(Mutex<Option<Arc<General>>>);

/// L D Lᵀ.
pub(super) struct Factor<'a> {
    pub(super) pencil: &'a Pencil,
    pub(super) shift: f64,
    values: Values<'a>,
    /// The number of negative pivots.
    pub(super) negative: usize,
    /// The least pivot beside the largest stiffness.
    pub(super) weakest: f64,
    /// L D Lᵀ differs from K - σ M by at most this times M, in both directions.
    pub(super) error: f64,
}

enum Values<'a> {
    /// Pivots, and the entries of L below them.
    Tridiagonal(Vec<f64>, Vec<f64>),
    General(&'a General, Vec<f64>),
}

impl Pencil {
    /// `None` where M is not shown to be positive definite by its diagonal, or there is no memory for L.
    pub(super) fn new(stiffness: &SparseMatrix, mass: &SparseMatrix) -> Option<Self> {
        let mass = Rows::new(mass);
        let weights = weights(&mass)?;
        Self::of(Rows::new(stiffness), mass, weights, None)
    }

    /// The same for a positive definite M and d with M - diag(d) not negative, as is known otherwise; in a given order of the rows.
    pub(super) fn of(
        stiffness: Rows,
        mass: Rows,
        mut weights: Vec<f64>,
        order: Option<&GivenOrder<'_>>,
    ) -> Option<Self> {
        let n = mass.dimension();
        let least_weight = weights.iter().copied().fold(f64::INFINITY, f64::min);
        let roots: Vec<f64> = weights.iter().map(|d| (1.0 / d).sqrt() * (1.0 + 4.0 * U)).collect();
        weights.iter_mut().for_each(|d| *d = d.sqrt() * (1.0 + 2.0 * U));
        let is_narrow =
            |rows: &Rows| (0..n).all(|i| rows.row(i).all(|at| (rows.columns[at] as usize).abs_diff(i) <= 1));
        let general = if order.is_none() && is_narrow(&stiffness) && is_narrow(&mass) {
            None
        } else {
            Some(General::new(&stiffness, &mass, order)?)
        };
        let (stiffness_norms, mass_norms) = (stiffness.norms(&roots), mass.norms(&roots));
        Some(Self { stiffness, mass, weights, roots, least_weight, stiffness_norms, mass_norms, general })
    }

    pub(super) fn dimension(&self) -> usize {
        self.weights.len()
    }

    pub(super) fn is_tridiagonal(&self) -> bool {
        self.general.is_none()
    }

    /// How many entries L and D have.
    pub(super) fn fill(&self) -> usize {
        self.general.as_ref().map_or(2 * self.dimension(), |general| general.symbolic.len_val())
    }

    /// The entries of K - σ M on the diagonal and below it, where these are tridiagonal.
    pub(super) fn bands(&self, i: usize, shift: f64) -> (f64, f64) {
        let at = |j: usize| self.stiffness.entry(i, j).hi - shift * self.mass.entry(i, j).hi;
        (at(i), if i > 0 { at(i - 1) } else { 0.0 })
    }

    /// L D Lᵀ; `None` where a pivot is 0 or none.
    pub(super) fn factor(&self, shift: f64) -> Option<Factor<'_>> {
        let factor = match &self.general {
            None => self.tridiagonal(shift)?,
            Some(general) => general.factor(self, shift)?,
        };
        factor.error.is_finite().then_some(factor)
    }

    /// [`Factor::error`] from a bound of D^(-1/2) |L| |D| |Lᵀ| D^(-1/2) in length, with the most entries in a row of L.
    fn error(&self, shift: f64, size: f64, widest: usize) -> f64 {
        // |A - L D Lᵀ| <= γ |L| |D| |Lᵀ| for sums of products in any order (N. Higham, Accuracy and Stability of Numerical
        // Algorithms, theorem 10.3 and section 11.1), with two roundings more for the scaling by D; A is off from K - σ M
        // by 4 u of |K| + |σ M| and by the radii.
        let steps = (widest + 16) as f64 * U;
        let (own, other) = (self.stiffness_norms, self.mass_norms);
        let entries = 4.0 * U * (own.0 + shift.abs() * other.0) + own.1 + shift.abs() * other.1;
        up(steps / (1.0 - steps) * size + entries)
    }

    fn tridiagonal(&self, shift: f64) -> Option<Factor<'_>> {
        let n = self.dimension();
        let (mut pivots, mut below) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let (mut pivot, mut negative, mut weakest) = (1.0, 0, f64::INFINITY);
        let (mut size, mut before, mut left) = (0.0_f64, 0.0, 0.0);
        for i in 0..n {
            let (diagonal, side) = self.bands(i, shift);
            let ratio: f64 = if i > 0 { side / pivot } else { 0.0 };
            // The row above is complete now: left is |l d| t of its own left neighbour.
            let root = self.roots[i];
            if i > 0 {
                let t = f64::abs(pivot) * (self.roots[i - 1] + ratio.abs() * root);
                size = size.max(self.roots[i - 1] * (t + left));
                before = ratio.abs() * t;
            }
            left = before;
            pivot = diagonal - ratio * side;
            if pivot == 0.0 || !pivot.is_finite() {
                return None;
            }
            negative += usize::from(pivot < 0.0);
            weakest = weakest.min(f64::abs(pivot) * root * root);
            pivots.push(pivot);
            below.push(ratio);
        }
        let last = self.roots.last().copied().unwrap_or(0.0);
        size = size.max(last * (f64::abs(pivot) * last + left));
        let values = Values::Tridiagonal(pivots, below);
        let error = self.error(shift, size * (1.0 + 32.0 * U), 2);
        Some(Factor { pencil: self, shift, values, negative, weakest: weakest / self.stiffness_norms.0, error })
    }
}

/// d with M - diag(d) not negative: what is left of the diagonal beside the other entries of its row (Gershgorin).
pub(super) fn weights(mass: &Rows) -> Option<Vec<f64>> {
    let n = mass.dimension();
    let root = |i: usize| Some(mass.entry(i, i).hi.sqrt()).filter(|root| *root > 0.0);
    let roots: Vec<f64> = (0..n).map(root).collect::<Option<_>>()?;
    let row = |i: usize| {
        let mut rest = 0.0;
        let mut own = 0.0;
        for at in mass.row(i) {
            let j = mass.columns[at] as usize;
            let (size, radius) = (mass.high[at].abs(), mass.radius(at));
            if i == j {
                own = size * (1.0 - 4.0 * U) - radius;
            } else {
                // Rows in units in which the diagonal is 1.
                rest += (size * (1.0 + 4.0 * U) + radius) * (roots[i] / roots[j]);
            }
        }
        let own = (own - rest * (1.0 + (mass.widest + 8) as f64 * 2.0 * U)) * (1.0 - 4.0 * U);
        (own > 0.0).then_some(own)
    };
    (0..n).map(row).collect()
}

impl General {
    fn new(stiffness: &Rows, mass: &Rows, order: Option<&GivenOrder<'_>>) -> Option<Arc<Self>> {
        let n = mass.dimension();
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for j in 0..n {
            merge(stiffness, mass, j, |i, _, _| rows.push(i));
            starts.push(rows.len());
        }
        let mut last = order.and_then(|own| own.last.0.lock().ok());
        if let Some(known) = last.as_ref().and_then(|last| last.as_ref())
            && known.starts == starts
            && known.rows == rows
        {
            return Some(Arc::clone(known));
        }
        let Elimination { symbolic, widest, .. } = elimination(&starts, &rows, order.map(|own| own.rows))?;
        let made = Arc::new(Self { symbolic, starts, rows, widest });
        if let Some(last) = &mut last {
            **last = Some(Arc::clone(&made));
        }
        Some(made)
    }

    fn factor<'a>(&'a self, pencil: &'a Pencil, shift: f64) -> Option<Factor<'a>> {
        let n = pencil.dimension();
        let mut entries = Vec::with_capacity(self.rows.len());
        for j in 0..n {
            merge(&pencil.stiffness, &pencil.mass, j, |_, own, mass| entries.push(own - shift * mass));
        }
        let matrix = SparseColMatRef::new(
            SymbolicSparseColMatRef::new_checked(n, n, &self.starts, None, &self.rows),
            entries.as_slice(),
        );
        let mut values = vec![0.0; self.symbolic.len_val()];
        let scratch = self.symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::try_new(scratch).ok()?;
        self.symbolic
            .factorize_numeric_ldlt(
                &mut values,
                matrix,
                Side::Upper,
                LdltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .ok()?;
        let order: Vec<usize> = self.symbolic.perm().map_or_else(|| (0..n).collect(), |own| own.arrays().0.to_vec());
        let roots: Vec<f64> = order.iter().map(|i| pencil.roots[*i]).collect();
        let (mut negative, mut weakest) = (0, f64::INFINITY);
        let mut sums = roots.clone();
        let mut fine = true;
        // |Lᵀ| roots, times |D|.
        self.each_column(&values, |j, pivot, rows, entries| {
            fine &= pivot != 0.0 && pivot.is_finite();
            negative += usize::from(pivot < 0.0);
            weakest = weakest.min(pivot.abs() * roots[j] * roots[j]);
            let column = rows.iter().zip(entries).map(|(i, entry)| entry.abs() * roots[*i]);
            sums[j] = pivot.abs() * (roots[j] + column.sum::<f64>());
        });
        let mut products = sums.clone();
        self.each_column(&values, |j, _, rows, entries| {
            rows.iter().zip(entries).for_each(|(i, entry)| products[*i] += entry.abs() * sums[j]);
        });
        let size = products.iter().zip(&roots).map(|(sum, root)| sum * root).fold(0.0, f64::max);
        let slack = 1.0 + (2 * self.widest + n / 1000 + 64) as f64 * 4.0 * U;
        let values = Values::General(self, values);
        let error = pencil.error(shift, size * slack, self.widest);
        let weakest = weakest / pencil.stiffness_norms.0;
        fine.then_some(Factor { pencil, shift, values, negative, weakest, error })
    }

    /// The columns of L from left to right: their number, the pivot, rows and entries below it.
    fn each_column(&self, values: &[f64], mut visit: impl FnMut(usize, f64, &[usize], &[f64])) {
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(own) => {
                for j in 0..own.ncols() {
                    let (start, end) = (own.col_ptr()[j], own.col_ptr()[j + 1]);
                    visit(j, values[start], &own.row_idx()[start + 1..end], &values[start + 1..end]);
                }
            }
            SymbolicCholeskyRaw::Supernodal(own) => {
                let factor = SupernodalLdltRef::new(own, values);
                let mut rows = Vec::new();
                for s in 0..own.n_supernodes() {
                    let node = factor.supernode(s);
                    let (entries, first) = (node.val(), node.start());
                    rows.clear();
                    rows.extend(first..first + entries.ncols());
                    rows.extend(node.pattern());
                    for j in 0..entries.ncols() {
                        let column = entries.col(j).try_as_col_major().map_or(&[][..], |own| own.as_slice());
                        visit(first + j, column[j], &rows[j + 1..], &column[j + 1..]);
                    }
                }
            }
        }
    }
}

/// The entries of K and M in the upper triangle of a column, by rising row.
fn merge(stiffness: &Rows, mass: &Rows, j: usize, mut visit: impl FnMut(usize, f64, f64)) {
    let (mut a, mut b) = (stiffness.row(j).peekable(), mass.row(j).peekable());
    loop {
        let row = |rows: &Rows, at: Option<&usize>| at.map_or(usize::MAX, |at| rows.columns[*at] as usize);
        let (left, right) = (row(stiffness, a.peek()), row(mass, b.peek()));
        let i = left.min(right);
        if i > j {
            return;
        }
        let own = if left == i { a.next().map_or(0.0, |at| stiffness.high[at]) } else { 0.0 };
        let other = if right == i { b.next().map_or(0.0, |at| mass.high[at]) } else { 0.0 };
        visit(i, own, other);
    }
}

impl Factor<'_> {
    /// About the eigenvalue that is nearest to the shift, and not below it, by inverse iteration; no bound.
    pub(super) fn least(&self) -> f64 {
        let n = self.pencil.dimension();
        let mut seed = Seed::default();
        let mut x: Vec<f64> = (0..n).map(|_| seed.next()).collect();
        let mut inertia = vec![0.0; n];
        let mut least = f64::INFINITY;
        for _ in 0..ITERATIONS {
            self.pencil.mass.times(&x, &mut inertia);
            let before = dot(&x, &inertia);
            self.solve(&mut inertia);
            x.copy_from_slice(&inertia);
            self.pencil.mass.times(&x, &mut inertia);
            least = (before / dot(&x, &inertia)).sqrt();
        }
        least
    }

    /// Solves for some vectors, column by column.
    pub(super) fn solve(&self, vectors: &mut [f64]) {
        let n = self.pencil.dimension();
        match &self.values {
            Values::General(general, values) => {
                let count = vectors.len() / n.max(1);
                let scratch = general.symbolic.solve_in_place_scratch::<f64>(count, Par::Seq);
                let Ok(mut memory) = MemBuffer::try_new(scratch) else {
                    // Without memory there is no solution.
                    vectors.fill(f64::NAN);
                    return;
                };
                LdltRef::new(&general.symbolic, values).solve_in_place_with_conj(
                    Conj::No,
                    MatMut::from_column_major_slice_mut(vectors, n, count),
                    Par::Seq,
                    MemStack::new(&mut memory),
                );
            }
            Values::Tridiagonal(pivots, below) => {
                for x in vectors.chunks_exact_mut(n.max(1)) {
                    for i in 1..n {
                        x[i] -= below[i] * x[i - 1];
                    }
                    for i in (0..n).rev() {
                        let right = if i + 1 < n { below[i + 1] * x[i + 1] } else { 0.0 };
                        x[i] = x[i] / pivots[i] - right;
                    }
                }
            }
        }
    }

    /// Solves for eight vectors.
    pub(super) fn solve_panel(&self, panel: &mut [Lane]) {
        let n = panel.len();
        if let Values::Tridiagonal(pivots, below) = &self.values {
            for i in 1..n {
                let before = panel[i - 1];
                panel[i] -= Lane::splat(below[i]) * before;
            }
            let mut right = Lane::ZERO;
            for i in (0..n).rev() {
                panel[i] = panel[i] * Lane::splat(1.0 / pivots[i]) - right;
                right = Lane::splat(below[i]) * panel[i];
            }
            return;
        }
        let mut columns = vec![0.0; n * LANES];
        for (i, lane) in panel.iter().enumerate() {
            lane.0.iter().enumerate().for_each(|(l, value)| columns[i + n * l] = *value);
        }
        self.solve(&mut columns);
        for (i, lane) in panel.iter_mut().enumerate() {
            lane.0.iter_mut().enumerate().for_each(|(l, value)| *value = columns[i + n * l]);
        }
    }
}
