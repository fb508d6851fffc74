//! Dense matrices in double-double and in doubles.
//!
//! Stored column by column, high and low parts apart, columns padded with zeros to a multiple of
//! four rows, so that the compiler can turn the inner loops into vector instructions.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

use crate::precision::{DoubleDouble, fast_two_sum, two_sum};

/// A matrix of double-doubles.
#[derive(Clone, Debug)]
pub(super) struct Matrix {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) stride: usize,
    pub(super) hi: Vec<f64>,
    pub(super) lo: Vec<f64>,
}

/// A matrix of doubles: magnitudes and bounds.
#[derive(Clone, Debug)]
pub(super) struct Plain {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) stride: usize,
    pub(super) data: Vec<f64>,
}

fn padded(rows: usize) -> usize {
    rows.next_multiple_of(4)
}

impl Matrix {
    pub(super) fn zeros(rows: usize, columns: usize) -> Self {
        let stride = padded(rows);
        let length = stride * columns;
        Self { rows, columns, stride, hi: vec![0.0; length], lo: vec![0.0; length] }
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
        let at = column * self.stride + row;
        DoubleDouble { hi: self.hi[at], lo: self.lo[at] }
    }

    pub(super) fn set(&mut self, row: usize, column: usize, value: DoubleDouble) {
        let at = column * self.stride + row;
        self.hi[at] = value.hi;
        self.lo[at] = value.lo;
    }

    /// The high parts of a column.
    pub(super) fn column_hi(&self, column: usize) -> &[f64] {
        &self.hi[column * self.stride..column * self.stride + self.rows]
    }

    /// The high parts.
    pub(super) fn doubles(&self) -> Mat<f64> {
        self.hi().to_owned()
    }

    pub(super) fn from_doubles(doubles: MatRef<'_, f64>) -> Self {
        Self::from_fn(doubles.nrows(), doubles.ncols(), |i, j| DoubleDouble::exact(doubles[(i, j)]))
    }

    /// The high parts, to be multiplied.
    pub(super) fn hi(&self) -> MatRef<'_, f64> {
        view(&self.hi, self.rows, self.columns, self.stride)
    }

    /// The low parts of a column.
    pub(super) fn column_lo(&self, column: usize) -> &[f64] {
        &self.lo[column * self.stride..column * self.stride + self.rows]
    }

    /// High and low parts of a column, to be written.
    pub(super) fn column_mut(&mut self, column: usize) -> (&mut [f64], &mut [f64]) {
        let range = column * self.stride..column * self.stride + self.rows;
        (&mut self.hi[range.clone()], &mut self.lo[range])
    }

    pub(super) fn transposed(&self) -> Self {
        let mut result = Self::zeros(self.columns, self.rows);
        let shape = (self.rows, self.columns);
        let to = result.stride;
        transpose(&self.hi, shape, self.stride, &mut result.hi, to);
        transpose(&self.lo, shape, self.stride, &mut result.lo, to);
        result
    }

    /// Upper bounds of the magnitudes: |hi + lo| <= |hi| (1 + 2^-53).
    pub(super) fn magnitudes(&self) -> Plain {
        let data = self.hi.iter().map(|x| x.abs() * (1.0 + f64::EPSILON)).collect();
        Plain { rows: self.rows, columns: self.columns, stride: self.stride, data }
    }

    /// Adds another matrix of the same shape.
    pub(super) fn add_assign(&mut self, other: &Self) {
        *self = Self::from_fn(self.rows, self.columns, |i, j| self.get(i, j) + other.get(i, j));
    }

    /// The given columns, in the given order.
    pub(super) fn gather(&self, columns: &[usize]) -> Self {
        let mut result = Self::zeros(self.rows, columns.len());
        for (to, &from) in columns.iter().enumerate() {
            let (to, from) = (to * self.stride, from * self.stride);
            result.hi[to..to + self.stride].copy_from_slice(&self.hi[from..from + self.stride]);
            result.lo[to..to + self.stride].copy_from_slice(&self.lo[from..from + self.stride]);
        }
        result
    }

    /// The given rows, in the given order.
    pub(super) fn gather_rows(&self, rows: &[usize]) -> Self {
        Self::from_fn(rows.len(), self.columns, |to, column| self.get(rows[to], column))
    }

    /// Writes the columns of `other` over the given columns.
    pub(super) fn scatter(&mut self, columns: &[usize], other: &Self) {
        for (from, &to) in columns.iter().enumerate() {
            let (to, from) = (to * self.stride, from * self.stride);
            self.hi[to..to + self.stride].copy_from_slice(&other.hi[from..from + self.stride]);
            self.lo[to..to + self.stride].copy_from_slice(&other.lo[from..from + self.stride]);
        }
    }
}

impl Plain {
    pub(super) fn zeros(rows: usize, columns: usize) -> Self {
        let stride = padded(rows);
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

    pub(super) fn transposed(&self) -> Self {
        let mut result = Self::zeros(self.columns, self.rows);
        let shape = (self.rows, self.columns);
        let to = result.stride;
        transpose(&self.data, shape, self.stride, &mut result.data, to);
        result
    }

    /// Copies the lower triangle into the upper one.
    pub(super) fn mirror(&mut self) {
        mirror(&mut self.data, self.columns, self.stride);
    }

    /// To be multiplied.
    pub(super) fn view(&self) -> MatRef<'_, f64> {
        view(&self.data, self.rows, self.columns, self.stride)
    }

    /// As a matrix of double-doubles.
    pub(super) fn widened(&self) -> Matrix {
        let lo = vec![0.0; self.data.len()];
        let (rows, columns, stride) = (self.rows, self.columns, self.stride);
        Matrix { rows, columns, stride, hi: self.data.clone(), lo }
    }
}

/// Numbers that are stored column by column, as faer multiplies them.
fn view(data: &[f64], rows: usize, columns: usize, stride: usize) -> MatRef<'_, f64> {
    if rows == 0 || columns == 0 {
        return MatRef::from_column_major_slice(&[], rows, columns);
    }
    MatRef::from_column_major_slice_with_stride(data, rows, columns, stride)
}

/// The side of squares that fit the cache.
const SIDE: usize = 16;

/// Copies the numbers of a matrix, stored column by column, into its transpose.
fn transpose(from: &[f64], (rows, columns): (usize, usize), stride: usize, to: &mut [f64], to_stride: usize) {
    for c0 in (0..columns).step_by(SIDE) {
        for r0 in (0..rows).step_by(SIDE) {
            for column in c0..(c0 + SIDE).min(columns) {
                for row in r0..(r0 + SIDE).min(rows) {
                    to[row * to_stride + column] = from[column * stride + row];
                }
            }
        }
    }
}

/// Copies the lower triangle of n by n numbers, stored column by column, into the upper one.
pub(super) fn mirror(data: &mut [f64], n: usize, stride: usize) {
    for c0 in (0..n).step_by(SIDE) {
        for r0 in (c0..n).step_by(SIDE) {
            for column in c0..(c0 + SIDE).min(n) {
                for row in r0.max(column + 1)..(r0 + SIDE).min(n) {
                    data[row * stride + column] = data[column * stride + row];
                }
            }
        }
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

/// The columns of a sparse matrix, as double-doubles.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    /// Where each column starts in the lists, and the end.
    pub(super) starts: Vec<usize>,
    /// The rows of its entries.
    pub(super) places: Vec<usize>,
    pub(super) hi: Vec<f64>,
    pub(super) lo: Vec<f64>,
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
