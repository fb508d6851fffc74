//! K X and M X with bounds, for all columns of X at once, at the price of products of doubles.
//!
//! Everything here lies transposed: row j belongs to column x_j, so that loops over columns of X are
//! vector instructions. A sparse matrix is multiplied in double-double entry by entry, a dense one in `slices`.

use super::dense::{Columns, Matrix, Plain, add_to, gamma, multiply};
use super::pencil::Enclosed;
use super::product::{product_bound, product_sparse, row_products};
use super::slices::sliced_product;
use crate::precision::{Ball, U2, up};

/// A matrix with fewer nonzero entries than this part of all counts as sparse.
const SPARSE: f64 = 0.1;

/// A symmetric matrix in the form in which it is multiplied.
pub(super) struct Operator<'a> {
    matrix: &'a Enclosed,
    columns: Option<Columns>,
    /// Of a dense matrix upper bounds of the Frobenius norms of all weights and of the matrix itself.
    norm: f64,
    size: f64,
}

/// (A X)ᵀ for a symmetric matrix A.
pub(super) struct Image {
    /// Row j is near (A x_j)ᵀ ...
    pub(super) value: Matrix,
    /// ... off by at most this in Euclidean length.
    pub(super) error: Vec<f64>,
}

/// Columns X' = X + D, rounded to double-doubles, in rows.
pub(super) struct Moved<'a> {
    pub(super) xt: Matrix,
    /// Bounds of the lengths of the columns of X', X' + D and D.
    pub(super) lengths: Vec<f64>,
    ahead_lengths: Vec<f64>,
    shifts: Vec<f64>,
    /// X' + D.
    ahead: Matrix,
    change: &'a Plain,
}

impl<'a> Moved<'a> {
    pub(super) fn new(xt: Matrix, change: &'a Plain) -> Self {
        let mut ahead = xt.clone();
        add_to(&mut ahead, change);
        let columns = (0..change.columns).map(|i| change.column(i));
        Self {
            lengths: lengths_of_rows(&xt),
            ahead_lengths: lengths_of_rows(&ahead),
            shifts: row_lengths(change.rows, columns),
            xt,
            ahead,
            change,
        }
    }
}

impl Image {
    /// xᵀ (A x) for every column, given as rows with bounds of their lengths.
    pub(super) fn products_with(&self, xt: &Matrix, lengths: &[f64]) -> Vec<Ball> {
        let unit = product_bound(xt.columns);
        let own_lengths = lengths_of_rows(&self.value);
        let products = row_products(xt, &self.value).into_iter();
        let bounds = self.error.iter().zip(&own_lengths).zip(lengths);
        products
            .zip(bounds)
            .map(|(value, ((error, own), length))| Ball::new(value, up(length * (error + unit * own))))
            .collect()
    }
}

impl<'a> Operator<'a> {
    pub(super) fn new(matrix: &'a Enclosed) -> Self {
        let n = matrix.mid.rows;
        let most = (SPARSE * (n * n) as f64) as usize + 2 * n;
        let mut places = Vec::new();
        let mut starts = vec![0];
        for column in 0..n {
            places.extend(matrix.nonzero(column));
            starts.push(places.len());
            if places.len() > most {
                break;
            }
        }
        if places.len() > most {
            // Sums of up to n² squares in doubles, whose roundings the factor covers, and low parts.
            let norm = |own: &Plain| -> f64 {
                let squares = |column: &[f64]| column.iter().map(|x| x * x).sum::<f64>();
                (own.data.chunks(own.stride).map(squares).sum::<f64>() * (1.0 + 1e-6) + 1e-300).sqrt()
            };
            return Self { matrix, columns: None, norm: norm(&matrix.weights()), size: norm(&matrix.mid.hi) };
        }
        let most = starts.windows(2).map(|range| range[1] - range[0]).max();
        let unit = product_bound(most.unwrap_or(0));
        let mut columns = Columns::default();
        for (column, range) in starts.windows(2).enumerate() {
            for &row in &places[range[0]..range[1]] {
                let entry = matrix.mid.get(row, column);
                columns.hi.push(entry.hi);
                columns.lo.push(entry.lo);
                columns.weights.push(up(matrix.weight(row, column) + unit * entry.hi.abs()));
            }
        }
        (columns.starts, columns.places) = (starts, places);
        Self { matrix, columns: Some(columns), norm: 0.0, size: 0.0 }
    }

    /// (A X)ᵀ from Xᵀ; `lengths` are bounds of the lengths of the columns of X, `slices` says how many
    /// slices of a dense matrix are taken.
    pub(super) fn image(&self, xt: &Matrix, lengths: &[f64], slices: usize) -> Image {
        if let Some(columns) = &self.columns {
            return Self::sparse_image(columns, xt);
        }
        let (value, mut error) = sliced_product(xt, &self.matrix.mid, lengths, slices);
        // |Σ_k r_ik x_k| over i in length, for entries r of A's error: at most the Frobenius norm times the length of x.
        for (error, length) in error.iter_mut().zip(lengths) {
            *error = up(*error + self.norm * length);
        }
        Image { value, error }
    }

    /// (A X')ᵀ from (A X)ᵀ for columns X' that were moved by D, with the products x'ᵀA x'.
    ///
    /// For a dense A only A D is computed, in doubles: what that is off by is as small beside A X' as D is
    /// beside X'. With ‖A‖ the Frobenius norm: the product costs γ ‖A‖ ‖d‖, the low parts of A are
    /// below u ‖A‖, the radii of A apply to d as well, the sum costs 2 u² of the image, which is no longer than
    /// ‖A‖ ‖x'‖ and its own error, and the rounding of x' another 2 u² ‖A‖ ‖x'‖ (DWPlusFP).
    ///
    /// The products don't suffer from that: (x + d)ᵀA (x + d) = (x + 2d)ᵀA x + dᵀA d, in which A x is the old
    /// image, and the last part is small by the square of D. x' and x' + d are rounded, 2 u² each time, of
    /// which x' counts twice, and so is the sum, 3 u²: together less than 16 u² of
    /// (‖x'‖ + ‖d‖) (‖A x‖ + ‖A d‖).
    ///
    /// A sparse A is multiplied anew, which costs less.
    pub(super) fn image_after(&self, before: Image, moved: &Moved<'_>) -> (Image, Vec<Ball>) {
        let (xt, change) = (&moved.xt, moved.change);
        if let Some(columns) = &self.columns {
            let image = Self::sparse_image(columns, xt);
            let products = image.products_with(xt, &moved.lengths);
            return (image, products);
        }
        let mut products = before.products_with(&moved.ahead, &moved.ahead_lengths);
        let old_lengths = lengths_of_rows(&before.value);
        let Image { mut value, mut error } = before;
        let part = multiply(change.view(), self.matrix.mid.hi.view());
        let mut squares = vec![0.0; change.rows];
        for column in 0..change.columns {
            let pairs = change.column(column).iter().zip(part.column(column));
            for (square, (d, image)) in squares.iter_mut().zip(pairs) {
                *square += d * image;
            }
        }
        add_to(&mut value, &part);
        let unit = gamma(change.columns) + 2.0 * f64::EPSILON;
        for (j, error) in error.iter_mut().enumerate() {
            let (length, shift) = (moved.lengths[j], moved.shifts[j]);
            let image = old_lengths[j] + *error + (self.size + self.norm) * shift;
            let rounding = 16.0 * U2 * (length + shift) * image;
            // The product A d, the low parts of A, and the sum of d times it: each below γ or 2 u of ‖A‖ ‖d‖².
            let square = (3.0 * unit * self.size + self.norm) * shift * shift;
            products[j] = (products[j] + Ball::exact(squares[j]))
                .with_added_radius(up((rounding + square) * (1.0 + 1e-9) + 1e-290));
            let product = self.size * (unit * shift + 5.0 * U2 * (length + shift)) + 1e-290;
            *error = up(*error * (1.0 + 1e-9) + product * (1.0 + 1e-9) + self.norm * shift);
        }
        (Image { value, error }, products)
    }

    /// The weights hold the radii of A and the rounding of products, per unit of |x|.
    fn sparse_image(columns: &Columns, xt: &Matrix) -> Image {
        let m = xt.rows;
        let mut squares = vec![0.0; m];
        let mut sum = vec![0.0; m];
        for column in 0..columns.starts.len() - 1 {
            sum.fill(0.0);
            columns.add_weighted(column, xt, &mut sum);
            for (square, sum) in squares.iter_mut().zip(&sum) {
                *square += sum * sum;
            }
        }
        // Sums of less than 2^20 terms in doubles, and the low parts of x: covered by 1e-6. Nothing
        // counts below 1e-150, as its square is lost.
        let error = squares.iter().map(|square| square.sqrt() * (1.0 + 1e-6) + 1e-150).collect();
        Image { value: product_sparse(xt, columns), error }
    }
}

/// Upper bounds of the lengths of the rows.
pub(super) fn lengths_of_rows(a: &Matrix) -> Vec<f64> {
    row_lengths(a.rows, (0..a.columns).map(|i| a.hi.column(i)))
}

/// Upper bounds of the lengths of the rows of a matrix with these columns, low parts included.
///
/// Sums of less than 2^20 squares in doubles, covered by 1e-6; nothing counts below 1e-150, as its
/// square is lost.
pub(super) fn row_lengths<'a>(rows: usize, columns: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
    let mut squares = vec![0.0; rows];
    for column in columns {
        for (square, x) in squares.iter_mut().zip(column) {
            *square += x * x;
        }
    }
    squares.iter().map(|square| square.sqrt() * (1.0 + 1e-6) + 1e-150).collect()
}
