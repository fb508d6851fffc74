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
    /// Weights of the entries of `columns`.
    weights: Vec<f64>,
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
        // The weight of what is not exactly zero is not either.
        let nonzero = |column: usize| {
            let weights = matrix.weight.column(column).iter();
            let entries = weights.enumerate().filter(|(_, w)| **w != 0.0);
            entries.map(|(row, _)| row)
        };
        let most = (SPARSE * (n * n) as f64) as usize + 2 * n;
        let mut places = Vec::new();
        let mut starts = vec![0];
        for column in 0..n {
            places.extend(nonzero(column));
            starts.push(places.len());
            if places.len() > most {
                break;
            }
        }
        if places.len() > most {
            // Sums of up to n² squares in doubles, whose roundings the factor covers, and low parts.
            let norm = |a: &dyn Fn(usize) -> &'a [f64]| -> f64 {
                let squares = |column| a(column).iter().map(|x| x * x).sum::<f64>();
                ((0..n).map(squares).sum::<f64>() * (1.0 + 1e-6) + 1e-300).sqrt()
            };
            return Self {
                matrix,
                columns: None,
                weights: Vec::new(),
                norm: norm(&|column| matrix.weight.column(column)),
                size: norm(&|column| matrix.mid.column_hi(column)),
            };
        }
        let most = starts.windows(2).map(|range| range[1] - range[0]).max();
        let unit = product_bound(most.unwrap_or(0));
        let mut columns = Columns::default();
        let mut weights = Vec::with_capacity(places.len());
        for (column, range) in starts.windows(2).enumerate() {
            for &row in &places[range[0]..range[1]] {
                let entry = matrix.mid.get(row, column);
                columns.hi.push(entry.hi);
                columns.lo.push(entry.lo);
                weights.push(up(matrix.weight.get(row, column) + unit * entry.hi.abs()));
            }
        }
        (columns.starts, columns.places) = (starts, places);
        Self { matrix, columns: Some(columns), weights, norm: 0.0, size: 0.0 }
    }

    /// (A X)ᵀ from Xᵀ; `lengths` are bounds of the lengths of the columns of X, `slices` says how many
    /// slices of a dense matrix are taken.
    pub(super) fn image(&self, xt: &Matrix, lengths: &[f64], slices: usize) -> Image {
        match &self.columns {
            Some(columns) => Image { value: product_sparse(xt, columns), error: self.sparse_error(columns, xt) },
            None => {
                let (value, mut error) = sliced_product(xt, &self.matrix.mid, lengths, slices);
                // |Σ_k r_ik x_k| over i in length, for entries r of A's error: at most the Frobenius
                // norm times the length of x.
                for (error, length) in error.iter_mut().zip(lengths) {
                    *error = up(*error + self.norm * length);
                }
                Image { value, error }
            }
        }
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
            let image = Image { value: product_sparse(xt, columns), error: self.sparse_error(columns, xt) };
            let products = image.products_with(xt, &moved.lengths);
            return (image, products);
        }
        let mut products = before.products_with(&moved.ahead, &moved.ahead_lengths);
        let old_lengths = lengths_of_rows(&before.value);
        let Image { mut value, mut error } = before;
        let part = multiply(change.view(), self.matrix.mid.hi());
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
    fn sparse_error(&self, columns: &Columns, xt: &Matrix) -> Vec<f64> {
        let m = xt.rows;
        let mut squares = vec![0.0; m];
        let mut sum = vec![0.0; m];
        for range in columns.starts.windows(2) {
            sum.fill(0.0);
            for at in range[0]..range[1] {
                let weight = self.weights[at];
                for (sum, x) in sum.iter_mut().zip(xt.column_hi(columns.places[at])) {
                    *sum += weight * x.abs();
                }
            }
            for (square, sum) in squares.iter_mut().zip(&sum) {
                *square += sum * sum;
            }
        }
        // Sums of less than 2^20 terms in doubles, and the low parts of x: covered by 1e-6. Nothing
        // counts below 1e-150, as its square is lost.
        squares.iter().map(|square| square.sqrt() * (1.0 + 1e-6) + 1e-150).collect()
    }
}

/// Upper bounds of the lengths of the rows.
pub(super) fn lengths_of_rows(a: &Matrix) -> Vec<f64> {
    row_lengths(a.rows, (0..a.columns).map(|i| a.column_hi(i)))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::DoubleDouble;
    use dashu_ratio::RBig;

    fn sample(rows: usize, columns: usize, grading: f64, seed: u64) -> Matrix {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut matrix = Matrix::zeros(rows, columns);
        for column in 0..columns {
            for row in 0..rows {
                let scale = 10f64.powf(grading * next());
                let value = DoubleDouble::new(next() * scale, next() * scale * 1e-17);
                matrix.set(row, column, value);
            }
        }
        matrix
    }

    fn exact(x: DoubleDouble) -> RBig {
        RBig::try_from(x.hi).unwrap() + RBig::try_from(x.lo).unwrap()
    }

    fn square(x: &RBig) -> RBig {
        x * x
    }

    #[test]
    fn sliced_products_keep_their_bound_and_are_not_far_from_it() {
        for (m, n, slices, grading) in
            [(5, 37, 1, 0.0), (3, 30, 2, 0.0), (5, 40, 3, 0.0), (4, 33, 3, 20.0), (4, 35, 1, -1.0), (4, 35, 3, -1.0)]
        {
            let (xt, mut a) = (sample(m, n, grading, 3), sample(n, n, grading, 5));
            if grading < 0.0 {
                a.hi.iter_mut().for_each(|x| *x = (*x * 300.0).round());
                a.lo.fill(0.0);
            }
            let (value, error) = sliced_product(&xt, &a, &lengths_of_rows(&xt), slices);
            for (row, bound) in error.iter().enumerate() {
                let mut squares = RBig::ZERO;
                for column in 0..n {
                    let sum = (0..n).fold(RBig::ZERO, |sum, k| sum + exact(xt.get(row, k)) * exact(a.get(k, column)));
                    squares += square(&(exact(value.get(row, column)) - sum));
                }
                let bound = RBig::try_from(*bound).unwrap();
                assert!(squares <= square(&bound), "{m} {n} {slices}");
                // The bound is of use: not a million times too large where nothing is graded.
                let close = square(&(bound * RBig::try_from(1e-6).unwrap()));
                assert!(grading != 0.0 || squares >= close, "{m} {n} {slices}");
            }
        }
    }

    #[test]
    fn sparse_products_and_row_products_keep_their_bounds() {
        let (m, n) = (9, 26);
        let xt = sample(m, n, 8.0, 17);
        let band = |row: usize, column: usize| row.abs_diff(column) <= 1;
        let mut a = sample(n, n, 8.0, 19);
        let mut columns = Columns::default();
        columns.starts.push(0);
        for column in 0..n {
            for row in 0..n {
                if band(row, column) {
                    let entry = a.get(row, column);
                    columns.places.push(row);
                    columns.hi.push(entry.hi);
                    columns.lo.push(entry.lo);
                } else {
                    a.set(row, column, DoubleDouble::ZERO);
                }
            }
            columns.starts.push(columns.places.len());
        }
        let image = product_sparse(&xt, &columns);
        let sums = row_products(&xt, &image);
        let size = |x: RBig| if x < RBig::ZERO { -x } else { x };
        let unit = RBig::try_from(super::super::product::product_bound(n)).unwrap();
        for (row, found) in sums.iter().enumerate() {
            let (mut total, mut sizes) = (RBig::ZERO, RBig::ZERO);
            for column in 0..n {
                let terms = (0..n).map(|k| exact(xt.get(row, k)) * exact(a.get(k, column)));
                let (sum, magnitude) =
                    terms.fold((RBig::ZERO, RBig::ZERO), |(sum, all), term| (sum + &term, all + size(term)));
                let value = exact(image.get(row, column));
                assert!(size(&value - &sum) <= &unit * magnitude);
                let term = exact(xt.get(row, column)) * value;
                total += &term;
                sizes += size(term);
            }
            assert!(size(exact(*found) - total) <= &unit * sizes);
        }
    }

    #[test]
    fn images_of_moved_columns_keep_their_bounds() {
        let (m, n) = (4, 37);
        let entries = sample(n, n, 3.0, 23);
        let balls: Vec<Ball> = (0..n * n)
            .map(|at| entries.get(at % n, at / n))
            .map(|entry| Ball::new(entry, 1e-30 * entry.hi.abs()))
            .collect();
        let matrix = Enclosed::new(n, &balls, &vec![0; n], 0);
        let operator = Operator::new(&matrix);
        for shift in [1e-14, 1e-9] {
            let xt = sample(m, n, 0.0, 29);
            let before = operator.image(&xt, &lengths_of_rows(&xt), 3);
            let mut change = Plain::zeros(m, n);
            let steps = sample(m, n, 2.0, 31);
            for (to, x) in change.data.iter_mut().zip(&steps.hi) {
                *to = shift * x;
            }
            let mut next = xt.clone();
            add_to(&mut next, &change);
            let (image, products) = operator.image_after(before, &Moved::new(next.clone(), &change));
            assert_eq!(products.len(), m);
            for (row, product) in products.iter().enumerate() {
                let (mut squares, mut form) = (RBig::ZERO, RBig::ZERO);
                for column in 0..n {
                    let sum = (0..n)
                        .fold(RBig::ZERO, |sum, k| sum + exact(next.get(row, k)) * exact(matrix.mid.get(k, column)));
                    squares += square(&(exact(image.value.get(row, column)) - &sum));
                    form += sum * exact(next.get(row, column));
                }
                let bound = RBig::try_from(image.error[row]).unwrap();
                assert!(squares <= square(&bound), "{shift}");
                let (mid, radius) = (exact(product.mid), product.radius);
                let off = mid - form;
                assert!(square(&off) <= square(&RBig::try_from(radius).unwrap()), "{shift}");
                // The products of A with a large step are off by what counts in a square only.
                assert!(shift < 1e-12 || radius < 1e-5 * image.error[row]);
            }
        }
    }
}
