//! K X and M X with bounds, for all columns of X at once, at the price of products of doubles.
//!
//! Everything here lies transposed: row j belongs to column x_j, so that loops over columns of X are
//! vector instructions. A sparse matrix is multiplied in double-double entry by entry. A dense one
//! is cut into slices of so few bits that products of slices are exact in doubles, whoever sums
//! them in whatever order (Ozaki, Ogita, Oishi, Rump, "Error-free transformations of matrix
//! multiplication by using fast routines of matrix multiplication and its applications", Numer.
//! Algorithms 59 (2012)); faer multiplies the slices.

use faer::Accum;

use super::dense::{Columns, Matrix, Plain, add_to, gamma, multiply, multiply_onto};
use super::pencil::Enclosed;
use super::product::{product_bound, product_sparse, row_products};
use crate::precision::{Ball, U2, exponent_of, power_of_two, two_sum, up};

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
            .map(|(value, ((error, own), length))| {
                Ball::new(value, up(length * (error + unit * own)))
            })
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
        Self {
            matrix,
            columns: Some(columns),
            weights,
            norm: 0.0,
            size: 0.0,
        }
    }

    /// (A X)ᵀ from Xᵀ; `lengths` are bounds of the lengths of the columns of X, `slices` says how many
    /// slices of a dense matrix are taken.
    pub(super) fn image(&self, xt: &Matrix, lengths: &[f64], slices: usize) -> Image {
        match &self.columns {
            Some(columns) => Image {
                value: product_sparse(xt, columns),
                error: self.sparse_error(columns, xt),
            },
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
            let image = Image {
                value: product_sparse(xt, columns),
                error: self.sparse_error(columns, xt),
            };
            let products = image.products_with(xt, &moved.lengths);
            return (image, products);
        }
        let mut products = before.products_with(&moved.ahead, &moved.ahead_lengths);
        let old_lengths = lengths_of_rows(&before.value);
        let Image {
            mut value,
            mut error,
        } = before;
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
        squares
            .iter()
            .map(|square| square.sqrt() * (1.0 + 1e-6) + 1e-150)
            .collect()
    }
}

/// A matrix cut into slices, the coarsest first, each of which is row by row or column by column a power of two
/// times integers of at most `bits` bits, and what the last one leaves over, in doubles.
struct Sliced {
    parts: Vec<Plain>,
    /// Exponents e with |entries of this row (column)| <= 2^e.
    scales: Vec<i32>,
    /// What the last slices leave over, rounded to doubles, each after one slice more; `None` where that is nothing.
    rests: Vec<Option<Plain>>,
}

/// XᵀA for Xᵀ (m by n) and a symmetric A, and a bound of each row's error in length.
///
/// With slices of β bits, A_p B_q sums n products of integers of at most 2^β times a power of two: exact in
/// doubles if n 2^2β <= 2^53. All slices but the first hold at most 2^(β-1), being what rounding left, so that products
/// with the same p + q, whose powers of two are the same, may be summed exactly as long as the sum of their
/// n 2^2β, halved for each p, q > 1, is at most 2^53. The products with p + q <= P + 1 of P slices are taken so. What is
/// left, with R_q for what the first q slices of A leave over and S for what those of X do,
///
/// ```text
///   XᵀA - Σ_{p+q<=P+1} X_pᵀA_q = Σ_p X_pᵀR_(P+1-p) + SᵀA
/// ```
///
/// is so small that its P + 1 products are taken in doubles, all in one sum of sums of [`BLOCK`] terms, in which no term
/// is rounded more often than `roundings`: by rows they are off by γ of so many terms times
/// Σ_p ‖x_p‖ ‖R_(P+1-p)‖ + ‖s‖ ‖A‖ (Cauchy, Schwarz; Frobenius norms), and by 2 u of that as R, S and A are
/// rounded to doubles. Entries of R_q are at most 2^(f - qβ - 1), f being the scale of their column, and those of x_p (s) at
/// most 2^(e - (p-1)β - 1) (2^(e - Pβ - 1)). The sums in double-double cost 2 u² of their terms each, and no term is larger than
/// n 2^(e + f) (1 + 2^(1-β)).
///
/// Where the entries of A have so few bits that it is a single slice, those of X may have more, and there are fewer of them.
fn sliced_product(xt: &Matrix, a: &Matrix, lengths: &[f64], slices: usize) -> (Matrix, Vec<f64>) {
    let (m, n) = (xt.rows, a.columns);
    let both = 53 - (n as f64).log2().ceil() as i32;
    let (bits, a_bits, slices) = match few_bits(a, both / 2) {
        Some(few) => (both - few, few, (slices - 1).max(1)),
        None => (both / 2, both / 2, slices),
    };
    let left = slice(xt, (slices, 1), bits, Cut::Rows);
    let right = slice(a, (slices, slices), a_bits, Cut::Columns);
    let mut value = Matrix::zeros(m, n);
    let mut part = Plain::zeros(m, n);
    let largest = n as f64 * power_of_two(bits + a_bits);
    let mut first = true;
    for order in 2..=slices + 1 {
        let mut held = 0.0;
        // From both ends, so that large ones come first.
        let pairs = (1..order).map(|k| if k % 2 == 1 { k / 2 + 1 } else { order - k / 2 });
        for (p, q) in pairs.map(|p| (p, order - p)) {
            let (Some(a), Some(b)) = (left.parts.get(p - 1), right.parts.get(q - 1)) else {
                continue;
            };
            let half = |slice| if slice == 1 { 1.0 } else { 0.5 };
            let size = largest * half(p) * half(q);
            if held > 0.0 && held + size <= power_of_two(53) {
                multiply_onto(&mut part, Accum::Add, a.view(), b.view());
                held += size;
                continue;
            }
            if held > 0.0 {
                put_onto(&mut value, &mut part, &mut first);
            }
            multiply_onto(&mut part, Accum::Replace, a.view(), b.view());
            held = size;
        }
        if held > 0.0 {
            put_onto(&mut value, &mut part, &mut first);
        }
    }
    let rest = left.rests.last().and_then(Option::as_ref);
    let last = rest.map(|rest| (rest.view(), a.hi()));
    let pairs = left.parts.iter().zip(right.rests.iter().rev());
    let pairs = pairs.filter_map(|(x, rest)| Some((x.view(), rest.as_ref()?.view())));
    let pairs: Vec<_> = pairs.chain(last).collect();
    let mut accumulate = Accum::Replace;
    for start in (0..n).step_by(BLOCK) {
        let block = start..(start + BLOCK).min(n);
        for (x, a) in &pairs {
            let (x, a) = (x.columns(block.clone()), a.rows(block.clone()));
            multiply_onto(&mut part, accumulate, x, a);
            accumulate = Accum::Add;
        }
    }
    if !pairs.is_empty() {
        put_onto(&mut value, &mut part, &mut first);
    }
    // The lengths of a row of ones and of the scales of the columns.
    let squares: f64 = right
        .scales
        .iter()
        .map(|&f| power_of_two(f) * power_of_two(f))
        .sum();
    let across = squares.sqrt() * (1.0 + 1e-6);
    let ones = (n as f64).sqrt() * (1.0 + 1e-6);
    // Of what q slices leave over, beside 2^scale.
    let left_over = |q: usize| power_of_two(-(q as i32) * bits - 1);
    let left_over_of_a = |q: usize| power_of_two(-(q as i32) * a_bits - 1);
    let rest_of_x = rest.is_some();
    let exact = (slices * (slices + 1) / 2 + 1) as f64;
    let sums = 3.0 * exact * U2 * n as f64;
    let roundings = BLOCK + (slices + 1) * n.div_ceil(BLOCK);
    let unit = gamma(roundings.min((slices + 1) * n)) + 2.0 * f64::EPSILON;
    let error = left
        .scales
        .iter()
        .zip(lengths)
        .map(|(&e, length)| {
            let entry = power_of_two(e);
            let mut rest = 0.0;
            for p in 1..=slices {
                if right.rests[slices - p].is_some() {
                    // The first slice of x is no longer than x and what it leaves over.
                    let own = match p {
                        1 => length + ones * entry * left_over(1),
                        _ => ones * entry * left_over(p - 1),
                    };
                    rest += own * (ones * across * left_over_of_a(slices + 1 - p));
                }
            }
            if rest_of_x {
                rest += ones * entry * left_over(slices) * (ones * across);
            }
            up((unit * rest + sums * entry * across) * (1.0 + 1e-6) + 1e-290)
        })
        .collect();
    (value, error)
}

/// With how many bits a column is a multiple of a power of two that is not beyond its own scale, if with `most`.
fn few_bits(a: &Matrix, most: i32) -> Option<i32> {
    let mut bits = 1;
    for column in 0..a.columns {
        let entries = a.column_hi(column);
        let largest = entries.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let scale = scale_of(largest);
        for (x, low) in entries.iter().zip(a.column_lo(column)) {
            if *x == 0.0 {
                continue;
            }
            let zeros = (x.to_bits() | 1 << 52).trailing_zeros() as i32;
            bits = bits.max(scale - (exponent_of(*x) - 52 + zeros));
            if bits > most || *low != 0.0 {
                return None;
            }
        }
    }
    Some(bits)
}

/// An exponent e with |x| <= 2^e for all x of a row or column, from the largest of their high parts. Entries below 2^-400 are
/// treated as if there were nothing left.
fn scale_of(largest: f64) -> i32 {
    (exponent_of(largest) + 1).clamp(-400, 900)
}

/// Terms of products in doubles that are summed apart: the bound grows with the number of roundings, and with fewer terms the
/// products take longer.
const BLOCK: usize = 128;

/// Adds a sum of products to the total; the first of them is the total.
fn put_onto(total: &mut Matrix, part: &mut Plain, first: &mut bool) {
    if *first {
        std::mem::swap(&mut total.hi, &mut part.data);
        *first = false;
    } else {
        add_to(total, part);
    }
}

/// Takes from double-doubles what is a multiple of the anchors' unit.
///
/// Rounds to that unit; exact, as is what is left (Rump, Ogita, Oishi, "Accurate floating-point summation
/// I", SIAM J. Sci. Comput. 31 (2008)).
fn cut(to: &mut [f64], (hi, lo): (&mut [f64], &mut [f64]), anchors: &[f64]) {
    for (((to, hi), lo), anchor) in to.iter_mut().zip(hi).zip(lo).zip(anchors) {
        let top = (*hi + anchor) - anchor;
        *to = top;
        (*hi, *lo) = two_sum(*hi - top, *lo);
    }
}

/// Whether rows or columns have a scale of their own.
#[derive(Clone, Copy, PartialEq)]
enum Cut {
    Rows,
    Columns,
}

/// Cuts a matrix into slices and keeps so many rests.
fn slice(a: &Matrix, (slices, kept): (usize, usize), bits: i32, by: Cut) -> Sliced {
    let (rows, columns) = (a.rows, a.columns);
    let mut largest = vec![0.0_f64; if by == Cut::Rows { rows } else { columns }];
    for column in 0..columns {
        let entries = a.column_hi(column).iter();
        match by {
            Cut::Rows => {
                for (largest, x) in largest.iter_mut().zip(entries) {
                    *largest = largest.max(x.abs());
                }
            }
            Cut::Columns => largest[column] = entries.fold(0.0, |most, x| most.max(x.abs())),
        }
    }
    let scales: Vec<i32> = largest.iter().map(|&x| scale_of(x)).collect();
    let mut parts: Vec<Plain> = (0..slices).map(|_| Plain::zeros(rows, columns)).collect();
    let mut rests: Vec<Plain> = (0..kept).map(|_| Plain::zeros(rows, columns)).collect();
    // 1.5 · 2^52 times the unit of a slice, for each row or column.
    let anchors: Vec<Vec<f64>> = (1..=slices as i32)
        .map(|number| {
            let anchor = |scale: &i32| 1.5 * power_of_two((52 + scale - number * bits).max(-1000));
            scales.iter().map(anchor).collect()
        })
        .collect();
    let (mut hi, mut lo) = (vec![0.0; rows], vec![0.0; rows]);
    let mut same = vec![0.0; rows];
    for column in 0..columns {
        hi.copy_from_slice(a.column_hi(column));
        lo.copy_from_slice(a.column_lo(column));
        for (number, (part, anchors)) in parts.iter_mut().zip(&anchors).enumerate() {
            let anchors = match by {
                Cut::Rows => anchors.as_slice(),
                Cut::Columns => {
                    same.fill(anchors[column]);
                    same.as_slice()
                }
            };
            cut(part.column_mut(column), (&mut hi, &mut lo), anchors);
            if let Some(rest) = rests.get_mut((number + kept).wrapping_sub(slices)) {
                rest.column_mut(column).copy_from_slice(&hi);
            }
        }
    }
    let zero = |part: &Plain| part.data.iter().all(|x| *x == 0.0);
    while parts.pop_if(|part| zero(part)).is_some() {}
    let some = |rest: Plain| (!zero(&rest)).then_some(rest);
    Sliced {
        parts,
        scales,
        rests: rests.into_iter().map(some).collect(),
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
    squares
        .iter()
        .map(|square| square.sqrt() * (1.0 + 1e-6) + 1e-150)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::DoubleDouble;
    use dashu_ratio::RBig;

    fn sample(rows: usize, columns: usize, grading: f64, seed: u64) -> Matrix {
        let mut state = seed;
        let mut next = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
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
        for (m, n, slices, grading) in [
            (5, 37, 1, 0.0),
            (3, 30, 2, 0.0),
            (5, 40, 3, 0.0),
            (4, 33, 3, 20.0),
            (4, 35, 1, -1.0),
            (4, 35, 3, -1.0),
        ] {
            let (xt, mut a) = (sample(m, n, grading, 3), sample(n, n, grading, 5));
            if grading < 0.0 {
                a.hi.iter_mut().for_each(|x| *x = (*x * 300.0).round());
                a.lo.fill(0.0);
            }
            let (value, error) = sliced_product(&xt, &a, &lengths_of_rows(&xt), slices);
            for (row, bound) in error.iter().enumerate() {
                let mut squares = RBig::ZERO;
                for column in 0..n {
                    let sum = (0..n).fold(RBig::ZERO, |sum, k| {
                        sum + exact(xt.get(row, k)) * exact(a.get(k, column))
                    });
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
                let (sum, magnitude) = terms.fold((RBig::ZERO, RBig::ZERO), |(sum, all), term| {
                    (sum + &term, all + size(term))
                });
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
            let (image, products) =
                operator.image_after(before, &Moved::new(next.clone(), &change));
            assert_eq!(products.len(), m);
            for (row, product) in products.iter().enumerate() {
                let (mut squares, mut form) = (RBig::ZERO, RBig::ZERO);
                for column in 0..n {
                    let sum = (0..n).fold(RBig::ZERO, |sum, k| {
                        sum + exact(next.get(row, k)) * exact(matrix.mid.get(k, column))
                    });
                    squares += square(&(exact(image.value.get(row, column)) - &sum));
                    form += sum * exact(next.get(row, column));
                }
                let bound = RBig::try_from(image.error[row]).unwrap();
                assert!(squares <= square(&bound), "{shift}");
                let (mid, radius) = (exact(product.mid), product.radius);
                let off = mid - form;
                assert!(
                    square(&off) <= square(&RBig::try_from(radius).unwrap()),
                    "{shift}"
                );
                // The products of A with a large step are off by what counts in a square only.
                assert!(shift < 1e-12 || radius < 1e-5 * image.error[row]);
            }
        }
    }
}
