//! K X and M X with bounds, for all columns of X at once, at the price of products of doubles.
//!
//! Everything here lies transposed: row j belongs to column x_j, so that loops over columns of X are
//! vector instructions. A sparse matrix is multiplied in double-double entry by entry, a dense one in `slices`.

use super::dense::{Columns, Matrix};
use super::pencil::Enclosed;
use super::product::{product_bound, product_sparse, row_products};
use super::slices::sliced_product;
use crate::precision::{Ball, up};

/// A matrix with fewer nonzero entries than this part of all counts as sparse.
const SPARSE: f64 = 0.1;

/// A symmetric matrix in the form in which it is multiplied.
pub(super) struct Operator<'a> {
    matrix: &'a Enclosed,
    columns: Option<Columns>,
    /// Of a dense matrix an upper bound of the Frobenius norm of all weights.
    norm: f64,
}

/// (A X)ᵀ for a symmetric matrix A.
pub(super) struct Image {
    /// Row j is near (A x_j)ᵀ ...
    pub(super) value: Matrix,
    /// ... off by at most this in Euclidean length.
    pub(super) error: Vec<f64>,
}

impl Image {
    /// xᵀ (A x) for every column, given as rows with bounds of their lengths.
    pub(super) fn products_with(&self, xt: &Matrix, lengths: &[f64]) -> Vec<Ball> {
        let unit = product_bound(xt.columns);
        let own_lengths = lengths_of_rows(&self.value);
        let bounds = self.error.iter().zip(&own_lengths).zip(lengths);
        let radii = bounds.map(|((error, own), length)| up(length * (error + unit * own)));
        row_products(xt, &self.value).into_iter().zip(radii).map(|(value, radius)| Ball::new(value, radius)).collect()
    }
}

impl<'a> Operator<'a> {
    pub(super) fn new(matrix: &'a Enclosed) -> Self {
        let n = matrix.mid.rows;
        let most = (SPARSE * (n * n) as f64) as usize + 2 * n;
        let counts: Vec<usize> = (0..n).map(|column| matrix.nonzero(column).count()).collect();
        if counts.iter().sum::<usize>() > most {
            // Sums of up to n² squares in doubles, whose roundings the factor covers, and low parts.
            let squares = matrix.weights().data.iter().map(|x| x * x).sum::<f64>();
            return Self { matrix, columns: None, norm: (squares * (1.0 + 1e-6) + 1e-300).sqrt() };
        }
        let unit = product_bound(counts.into_iter().max().unwrap_or(0));
        let mut columns = Columns::default();
        for column in 0..n {
            for row in matrix.nonzero(column) {
                let entry = matrix.mid.get(row, column);
                columns.push(row, entry, up(matrix.weight(row, column) + unit * entry.hi.abs()));
            }
            columns.end();
        }
        Self { matrix, columns: Some(columns), norm: 0.0 }
    }

    /// (A X)ᵀ from Xᵀ; `lengths` are bounds of the lengths of the columns of X, `slices` says how many
    /// slices of a dense matrix are taken.
    pub(super) fn image(&self, xt: &Matrix, lengths: &[f64], slices: usize) -> Image {
        if let Some(columns) = &self.columns {
            // The weights hold the radii of A and the rounding of products, per unit of |x|.
            let weighted = (0..columns.starts.len() - 1).map(|column| {
                let mut sum = vec![0.0; xt.rows];
                columns.add_weighted(column, xt, &mut sum);
                sum
            });
            return Image { value: product_sparse(xt, columns), error: row_lengths(xt.rows, weighted) };
        }
        let (value, mut error) = sliced_product(xt, &self.matrix.mid, lengths, slices);
        // |Σ_k r_ik x_k| over i in length, for entries r of A's error: at most the Frobenius norm times the length of x.
        for (error, length) in error.iter_mut().zip(lengths) {
            *error = up(*error + self.norm * length);
        }
        Image { value, error }
    }
}

/// Upper bounds of the lengths of the rows.
pub(super) fn lengths_of_rows(a: &Matrix) -> Vec<f64> {
    row_lengths(a.rows, (0..a.columns).map(|i| a.hi.column(i)))
}

/// Upper bounds of the lengths of the rows of a matrix with these columns, low parts included.
///
/// Sums of less than 2^20 squares in doubles, covered by 1e-6, as are sums of so many terms that are squared; nothing counts below
/// 1e-150, as its square is lost.
pub(super) fn row_lengths(rows: usize, columns: impl Iterator<Item = impl AsRef<[f64]>>) -> Vec<f64> {
    let mut squares = vec![0.0; rows];
    for column in columns {
        for (square, x) in squares.iter_mut().zip(column.as_ref()) {
            *square += x * x;
        }
    }
    squares.iter().map(|square| square.sqrt() * (1.0 + 1e-6) + 1e-150).collect()
}
