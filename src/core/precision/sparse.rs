//! Matrices of which most entries are 0.

use super::{Ball, Complex, Enclosure, Scalar};

/// The entries that are not exactly 0, column by column: those of the lower triangle where the matrix is symmetric, unless told otherwise.
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct SparseMatrix<S = Ball> {
    /// Where each column begins in `rows` and `values`; one more than there are columns.
    starts: Vec<usize>,
    rows: Vec<u32>,
    values: Vec<S>,
}

impl<S: Scalar> SparseMatrix<S> {
    /// From all entries column by column, of which the lower triangle is read.
    pub(crate) fn from_dense(dimension: usize, entries: &[S]) -> Self {
        let places = (0..dimension).flat_map(|j| (j..dimension).map(move |i| (i, j)));
        let shares = places.map(|(i, j)| (i as u32, j as u32, entries[j * dimension + i].clone()));
        Self::from_shares(dimension, &shares.filter(|(_, _, value)| !value.is_exact_zero()).collect::<Vec<_>>())
    }

    /// The sum of shares: row, column, value; of a symmetric matrix with no row above the column. Several for one entry are added in their order.
    pub fn from_shares(dimension: usize, shares: &[(u32, u32, S)]) -> Self {
        // By column, in the order of the shares.
        let mut ends = vec![0_usize; dimension + 1];
        for (_, column, _) in shares {
            ends[*column as usize + 1] += 1;
        }
        for j in 0..dimension {
            ends[j + 1] += ends[j];
        }
        let mut order = vec![0_u32; shares.len()];
        let mut next = ends.clone();
        for (number, (_, column, _)) in (0_u32..).zip(shares) {
            order[next[*column as usize]] = number;
            next[*column as usize] += 1;
        }
        let (rows, values) = (Vec::with_capacity(shares.len()), Vec::with_capacity(shares.len()));
        let mut matrix = Self { starts: Vec::with_capacity(dimension + 1), rows, values };
        matrix.starts.push(0);
        for j in 0..dimension {
            let own = &mut order[ends[j]..ends[j + 1]];
            own.sort_by_key(|number| shares[*number as usize].0);
            for group in own.chunk_by(|a, b| shares[*a as usize].0 == shares[*b as usize].0) {
                let mut parts = group.iter().map(|number| &shares[*number as usize]);
                let Some((row, _, first)) = parts.next() else { continue };
                let sum = parts.fold(first.clone(), |sum, (_, _, part)| sum.add(part));
                if !sum.is_exact_zero() {
                    matrix.rows.push(*row);
                    matrix.values.push(sum);
                }
            }
            matrix.starts.push(matrix.rows.len());
        }
        matrix
    }

    /// The sum of two matrices that store the same parts.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        let both = self.entries().chain(other.entries());
        let both: Vec<(u32, u32, S)> = both.map(|(i, j, value)| (i as u32, j as u32, value.clone())).collect();
        Self::from_shares(self.dimension(), &both)
    }

    /// All entries of a symmetric matrix of which the lower triangle is stored.
    pub fn mirrored(&self) -> Self {
        let all = self.entries().flat_map(|(i, j, value)| {
            let own = (i as u32, j as u32, value.clone());
            let other = (i != j).then(|| (j as u32, i as u32, value.clone()));
            std::iter::once(own).chain(other)
        });
        Self::from_shares(self.dimension(), &all.collect::<Vec<_>>())
    }
}

impl<S: Enclosure> SparseMatrix<S> {
    /// The image of a vector under a matrix of which all entries are stored, or under the transposed one.
    pub(crate) fn times(&self, x: &[Complex<S>], transposed: bool, precision: S::Precision) -> Vec<Complex<S>> {
        let mut image = vec![Complex::zero(precision); self.dimension()];
        for (i, j, entry) in self.entries() {
            let (to, from) = if transposed { (j, i) } else { (i, j) };
            image[to] = image[to].add(&x[from].times(entry));
        }
        image
    }
}

impl<S> SparseMatrix<S> {
    /// The number of rows.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The number of entries.
    pub(crate) fn stored(&self) -> usize {
        self.rows.len()
    }

    /// The rows of a column, ascending, and the entries there.
    pub(crate) fn column(&self, j: usize) -> (&[u32], &[S]) {
        let range = self.starts[j]..self.starts[j + 1];
        (&self.rows[range.clone()], &self.values[range])
    }

    /// All entries: row, column, value, column by column.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, &S)> {
        (0..self.dimension()).flat_map(|j| {
            let (rows, values) = self.column(j);
            rows.iter().zip(values).map(move |(i, value)| (*i as usize, j, value))
        })
    }

    /// How far the entries are from the diagonal at most.
    pub(crate) fn bandwidth(&self) -> usize {
        self.entries().map(|(i, j, _)| i - j).max().unwrap_or(0)
    }
}
