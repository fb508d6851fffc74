//! Dense matrices in double-double and in doubles.
//!
//! Stored column by column, high and low parts apart, columns padded with zeros to a multiple of
//! four rows, so that the compiler can turn the inner loops into vector instructions.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

use crate::precision::{DoubleDouble, fast_two_sum, two_sum};

/// A matrix of double-doubles: their high parts, and their low parts.
#[derive(Clone, Debug)]
pub(super) struct Matrix {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) hi: Plain,
    pub(super) lo: Plain,
}

/// A matrix of doubles: magnitudes and bounds.
#[derive(Clone, Debug)]
pub(super) struct Plain {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) stride: usize,
    pub(super) data: Vec<f64>,
}

impl Matrix {
    fn of(hi: Plain, lo: Plain) -> Self {
        Self { rows: hi.rows, columns: hi.columns, hi, lo }
    }

    pub(super) fn zeros(rows: usize, columns: usize) -> Self {
        Self::of(Plain::zeros(rows, columns), Plain::zeros(rows, columns))
    }

    /// From the entry of each row and column.
    pub(super) fn from_fn(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> DoubleDouble) -> Self {
        let mut result = Self::zeros(rows, columns);
        for column in 0..columns {
            for row in 0..rows {
                result.set(row, column, entry(row, column));
            }
        }
        result
    }

    pub(super) fn get(&self, row: usize, column: usize) -> DoubleDouble {
        DoubleDouble { hi: self.hi.get(row, column), lo: self.lo.get(row, column) }
    }

    pub(super) fn set(&mut self, row: usize, column: usize, value: DoubleDouble) {
        self.hi.set(row, column, value.hi);
        self.lo.set(row, column, value.lo);
    }

    /// The high parts.
    pub(super) fn doubles(&self) -> Mat<f64> {
        self.hi.view().to_owned()
    }

    pub(super) fn from_doubles(doubles: MatRef<'_, f64>) -> Self {
        Self::from_fn(doubles.nrows(), doubles.ncols(), |i, j| DoubleDouble::exact(doubles[(i, j)]))
    }

    /// High and low parts of a column, to be written.
    pub(super) fn column_mut(&mut self, column: usize) -> (&mut [f64], &mut [f64]) {
        (self.hi.column_mut(column), self.lo.column_mut(column))
    }

    pub(super) fn transposed(&self) -> Self {
        Self::of(self.hi.transposed(), self.lo.transposed())
    }

    /// Copies the lower triangle into the upper one.
    pub(super) fn mirror(&mut self) {
        self.hi.mirror();
        self.lo.mirror();
    }

    /// Upper bounds of the magnitudes: |hi + lo| <= |hi| (1 + 2^-53).
    pub(super) fn magnitudes(&self) -> Plain {
        let mut sizes = self.hi.clone();
        sizes.data.iter_mut().for_each(|x| *x = x.abs() * (1.0 + f64::EPSILON));
        sizes
    }

    /// Adds another matrix of the same shape.
    pub(super) fn add_assign(&mut self, other: &Self) {
        *self = Self::from_fn(self.rows, self.columns, |i, j| self.get(i, j) + other.get(i, j));
    }

    /// The given columns, in the given order.
    pub(super) fn gather(&self, columns: &[usize]) -> Self {
        Self::from_fn(self.rows, columns.len(), |row, to| self.get(row, columns[to]))
    }

    /// The given rows, in the given order.
    pub(super) fn gather_rows(&self, rows: &[usize]) -> Self {
        Self::from_fn(rows.len(), self.columns, |to, column| self.get(rows[to], column))
    }

    /// Writes the columns of `other` over the given columns.
    pub(super) fn scatter(&mut self, columns: &[usize], other: &Self) {
        for (from, &to) in columns.iter().enumerate() {
            self.hi.column_mut(to).copy_from_slice(other.hi.column(from));
            self.lo.column_mut(to).copy_from_slice(other.lo.column(from));
        }
    }
}

impl Plain {
    pub(super) fn zeros(rows: usize, columns: usize) -> Self {
        let stride = rows.next_multiple_of(4);
        Self { rows, columns, stride, data: vec![0.0; stride * columns] }
    }

    /// From the entry of each row and column.
    pub(super) fn from_fn(rows: usize, columns: usize, mut entry: impl FnMut(usize, usize) -> f64) -> Self {
        let mut result = Self::zeros(rows, columns);
        for column in 0..columns {
            for (row, to) in result.column_mut(column).iter_mut().enumerate() {
                *to = entry(row, column);
            }
        }
        result
    }

    pub(super) fn get(&self, row: usize, column: usize) -> f64 {
        self.data[column * self.stride + row]
    }

    pub(super) fn set(&mut self, row: usize, column: usize, value: f64) {
        self.data[column * self.stride + row] = value;
    }

    /// Sets an entry and the one across the diagonal.
    pub(super) fn set_both(&mut self, row: usize, column: usize, value: f64) {
        self.set(row, column, value);
        self.set(column, row, value);
    }

    pub(super) fn column(&self, column: usize) -> &[f64] {
        &self.data[column * self.stride..column * self.stride + self.rows]
    }

    /// A column with the zeros that it is padded with.
    pub(super) fn padded_column(&self, column: usize) -> &[f64] {
        &self.data[column * self.stride..(column + 1) * self.stride]
    }

    pub(super) fn column_mut(&mut self, column: usize) -> &mut [f64] {
        &mut self.data[column * self.stride..column * self.stride + self.rows]
    }

    /// The entries of a row.
    pub(super) fn row(&self, row: usize) -> impl Iterator<Item = &f64> {
        self.data.iter().skip(row).step_by(self.stride.max(1))
    }

    pub(super) fn transposed(&self) -> Self {
        Self::from_fn(self.columns, self.rows, |row, column| self.get(column, row))
    }

    /// Copies the lower triangle into the upper one.
    pub(super) fn mirror(&mut self) {
        for column in 0..self.columns {
            for row in column + 1..self.rows {
                self.set(column, row, self.get(row, column));
            }
        }
    }

    /// To be multiplied, by faer.
    pub(super) fn view(&self) -> MatRef<'_, f64> {
        if self.rows == 0 || self.columns == 0 {
            return MatRef::from_column_major_slice(&[], self.rows, self.columns);
        }
        MatRef::from_column_major_slice_with_stride(&self.data, self.rows, self.columns, self.stride)
    }

    /// As a matrix of double-doubles.
    pub(super) fn widened(&self) -> Matrix {
        Matrix::of(self.clone(), Self::zeros(self.rows, self.columns))
    }
}

/// Rounding of a product of doubles with `inner` terms, whatever the order of summation, fused or not:
/// |computed - exact| <= γ Σ |a| |b|, but for underflow (Higham, Accuracy and Stability of Numerical
/// Algorithms, 3.1).
pub(super) fn gamma(inner: usize) -> f64 {
    let nu = (inner as f64 + 2.0) * 0.5 * f64::EPSILON;
    nu / (1.0 - nu)
}

/// a b in doubles, by faer; see [`gamma`].
pub(super) fn multiply(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Plain {
    let mut c = Plain::zeros(a.nrows(), b.ncols());
    multiply_onto(&mut c, Accum::Replace, a, b);
    c
}

/// a b in doubles, put in the place of what `c` holds, or added to it.
pub(super) fn multiply_onto(c: &mut Plain, accumulate: Accum, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    let (rows, columns, stride) = (c.rows, c.columns, c.stride);
    if rows == 0 || columns == 0 {
        return;
    }
    let to = MatMut::from_column_major_slice_with_stride_mut(&mut c.data, rows, columns, stride);
    matmul(to, accumulate, a, b, 1.0, Par::Seq);
}

/// The columns of a sparse matrix, as double-doubles with errors.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    /// Where each column starts in the lists, and the end.
    pub(super) starts: Vec<usize>,
    /// The rows of its entries.
    pub(super) places: Vec<usize>,
    pub(super) hi: Vec<f64>,
    pub(super) lo: Vec<f64>,
    /// What a product with an entry is off by, per unit of the other factor; as in [`Enclosed`](super::pencil::Enclosed).
    pub(super) weights: Vec<f64>,
}

impl Default for Columns {
    /// None.
    fn default() -> Self {
        Self { starts: vec![0], places: Vec::new(), hi: Vec::new(), lo: Vec::new(), weights: Vec::new() }
    }
}

impl Columns {
    /// One entry more in the last column.
    pub(super) fn push(&mut self, row: usize, entry: DoubleDouble, weight: f64) {
        self.places.push(row);
        self.hi.push(entry.hi);
        self.lo.push(entry.lo);
        self.weights.push(weight);
    }

    /// Ends the last column.
    pub(super) fn end(&mut self) {
        self.starts.push(self.places.len());
    }

    /// Adds the weights of a column times the sizes of what its entries are multiplied by, for all rows of Xᵀ.
    pub(super) fn add_weighted(&self, column: usize, xt: &Matrix, sums: &mut [f64]) {
        for at in self.starts[column]..self.starts[column + 1] {
            let weight = self.weights[at];
            for (sum, x) in sums.iter_mut().zip(xt.hi.column(self.places[at])) {
                *sum += weight * x.abs();
            }
        }
    }
}

/// Adds a matrix of doubles, which costs 2 u² of the sum (DWPlusFP).
pub(super) fn add_to(sum: &mut Matrix, part: &Plain) {
    for column in 0..sum.columns {
        let (hi, lo) = sum.column_mut(column);
        for ((hi, lo), x) in hi.iter_mut().zip(lo).zip(part.column(column)) {
            let (s, e) = two_sum(*hi, *x);
            (*hi, *lo) = fast_two_sum(s, e + *lo);
        }
    }
}
