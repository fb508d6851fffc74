//! Matrices of numbers, real or complex.

use std::ops::{Index, IndexMut};

use super::{Complex, Scalar};
use crate::number::Number;

/// What matrices are made of.
pub trait Entry: Clone {
    /// See [`Scalar::Precision`].
    type Precision: Copy;
    /// A whole number.
    fn whole(value: i64, precision: Self::Precision) -> Self;
    /// The sum.
    fn add(&self, other: &Self) -> Self;
    /// The difference.
    fn sub(&self, other: &Self) -> Self;
    /// The product.
    fn mul(&self, other: &Self) -> Self;
    /// The quotient.
    fn div(&self, other: &Self) -> Self;
    /// Whether it is exactly 0.
    fn is_zero(&self) -> bool;
}

macro_rules! operations {
    ($of:ident: $($name:ident)*) => {
        $(fn $name(&self, other: &Self) -> Self {
            $of::$name(self, other)
        })*
    };
}

impl<S: Scalar> Entry for S {
    type Precision = S::Precision;

    operations!(Scalar: add sub mul div);

    fn whole(value: i64, precision: S::Precision) -> Self {
        S::from_number(&Number::from(value), precision)
    }

    fn is_zero(&self) -> bool {
        self.is_exact_zero()
    }
}

impl<S: Scalar> Entry for Complex<S> {
    type Precision = S::Precision;

    operations!(Complex: add sub mul div);

    fn whole(value: i64, precision: S::Precision) -> Self {
        Self::new(S::whole(value, precision), S::whole(0, precision))
    }

    fn is_zero(&self) -> bool {
        Complex::is_zero(self)
    }
}

/// A matrix, row by row.
#[derive(Clone, Debug)]
pub struct Matrix<T> {
    columns: usize,
    entries: Vec<T>,
}

impl<T> Index<(usize, usize)> for Matrix<T> {
    type Output = T;

    fn index(&self, (row, column): (usize, usize)) -> &T {
        &self.entries[self.columns * row + column]
    }
}

impl<T> IndexMut<(usize, usize)> for Matrix<T> {
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut T {
        &mut self.entries[self.columns * row + column]
    }
}

impl<T> Matrix<T> {
    /// From the entries, row by row.
    pub fn new(columns: usize, entries: Vec<T>) -> Self {
        Self { columns, entries }
    }

    /// From the entry of each row and column, both from 0.
    pub fn from_fn(rows: usize, columns: usize, mut entry: impl FnMut(usize, usize) -> T) -> Self {
        let entries = (0..rows * columns).map(|at| entry(at / columns, at % columns));
        Self::new(columns, entries.collect())
    }

    /// All entries, row by row.
    pub fn into_entries(self) -> Vec<T> {
        self.entries
    }

    /// All entries, row by row.
    pub fn entries(&self) -> &[T] {
        &self.entries
    }

    /// The rows, of one entry at least.
    pub fn rows(&self) -> std::slice::ChunksExact<'_, T> {
        self.entries.chunks_exact(self.columns.max(1))
    }

    /// The matrix of the images of the entries.
    pub fn map<U>(&self, image: impl FnMut(&T) -> U) -> Matrix<U> {
        Matrix::new(self.columns, self.entries.iter().map(image).collect())
    }
}

impl<T: Entry> Matrix<T> {
    /// The unit matrix.
    pub fn unit(order: usize, precision: T::Precision) -> Self {
        Self::from_fn(order, order, |i, j| T::whole(i64::from(i == j), precision))
    }

    /// The transposed matrix.
    pub fn transposed(&self) -> Self {
        let rows = self.rows().len();
        Self::from_fn(self.columns, rows, |i, j| self[(j, i)].clone())
    }

    /// The image of a vector.
    pub fn image(&self, vector: &[T], precision: T::Precision) -> Vec<T> {
        let sum = |row| sum_of_products(row, vector, precision);
        self.rows().map(sum).collect()
    }

    /// The sum.
    pub fn add(&self, other: &Self) -> Self {
        let pairs = self.entries.iter().zip(&other.entries);
        Self::new(self.columns, pairs.map(|(x, y)| x.add(y)).collect())
    }

    /// The product.
    pub fn mul(&self, other: &Self, precision: T::Precision) -> Self {
        let columns = other.transposed();
        let sums = |row| columns.rows().map(move |column| sum_of_products(row, column, precision));
        Self::new(other.columns, self.rows().flat_map(sums).collect())
    }
}

/// Σ x_i y_i, without terms that are exactly 0.
pub fn sum_of_products<T: Entry>(x: &[T], y: &[T], precision: T::Precision) -> T {
    let products = x.iter().zip(y);
    let products = products.filter(|(x, y)| !(x.is_zero() || y.is_zero()));
    products.fold(T::whole(0, precision), |sum, (x, y)| sum.add(&x.mul(y)))
}

/// xᵀAx for columns of so many entries, one after the other; there may be more of them than x has components.
pub fn quadratic_form<T: Entry>(matrix: &[T], order: usize, x: &[T], precision: T::Precision) -> T {
    let image: Vec<T> = matrix.chunks(order).map(|column| sum_of_products(column, x, precision)).collect();
    sum_of_products(&image, x, precision)
}

/// A step of Gauss-Jordan elimination: a row is divided by its entry in a column, and so much of it taken off the others
/// that they are 0 there.
pub fn clear_column<T: Entry>(rows: &mut [Vec<T>], row: usize, column: usize, precision: T::Precision) {
    let pivot = rows[row][column].clone();
    for entry in &mut rows[row] {
        *entry = entry.div(&pivot);
    }
    let own = rows[row].clone();
    for (at, other) in rows.iter_mut().enumerate() {
        let factor = other[column].clone();
        if at == row || factor.is_zero() {
            continue;
        }
        subtract(other, &own, &factor);
        other[column] = T::whole(0, precision);
    }
}

/// Whether all pivots of an elimination without exchanges are as they should be.
pub fn has_pivots<T: Entry>(mut rows: Vec<Vec<T>>, is_pivot: impl Fn(&T) -> bool, precision: T::Precision) -> bool {
    for k in 0..rows.len() {
        if !is_pivot(&rows[k][k]) {
            return false;
        }
        clear_column(&mut rows, k, k, precision);
    }
    true
}

/// The reduced echelon form of rows one after the other, each by its largest entry in the first so many columns: where these stand.
pub fn reduce<T: Entry>(rows: &mut [Vec<T>], width: usize, size: fn(&T) -> f64, precision: T::Precision) -> Vec<usize> {
    let mut pivots = Vec::new();
    for k in 0..rows.len() {
        let size = |column: &usize| size(&rows[k][*column]);
        let open = (0..width).filter(|column| !pivots.contains(column));
        let Some(pivot) = open.max_by(|a, b| size(a).total_cmp(&size(b))) else { break };
        clear_column(rows, k, pivot, precision);
        pivots.push(pivot);
    }
    pivots
}

/// x - factor·y, without products with 0.
pub fn subtract<T: Entry>(x: &mut [T], y: &[T], factor: &T) {
    if factor.is_zero() {
        return;
    }
    for (x, y) in x.iter_mut().zip(y) {
        if !y.is_zero() {
            *x = x.sub(&factor.mul(y));
        }
    }
}

/// Rows after elimination.
pub(crate) struct Eliminated<T> {
    /// The columns of the pivots, in the order in which they were taken.
    pub(crate) pivots: Vec<usize>,
    /// The rows in that order: 1 in the column of the own pivot, 0 in those of the others. Rows without pivots are left out.
    pub(crate) rows: Vec<Vec<T>>,
}

/// Gauss-Jordan elimination. The next pivot is always the entry of the highest rank, the first of several; `ranks` gives those of
/// the entries of a row, of which the ones without a rank are no pivots.
pub(crate) fn eliminate<T: Entry, R: PartialOrd>(
    mut rows: Vec<Vec<T>>,
    ranks: impl Fn(&[T]) -> Vec<Option<R>>,
    precision: T::Precision,
) -> Eliminated<T> {
    let (mut pivots, mut order) = (Vec::new(), Vec::new());
    loop {
        let mut best: Option<(R, usize, usize)> = None;
        for row in (0..rows.len()).filter(|row| !order.contains(row)) {
            for (column, rank) in ranks(&rows[row]).into_iter().enumerate() {
                if let Some(rank) = rank
                    && best.as_ref().is_none_or(|(other, ..)| rank > *other)
                {
                    best = Some((rank, row, column));
                }
            }
        }
        let Some((_, row, column)) = best else { break };
        clear_column(&mut rows, row, column, precision);
        order.push(row);
        pivots.push(column);
    }
    Eliminated { pivots, rows: order.into_iter().map(|row| std::mem::take(&mut rows[row])).collect() }
}
