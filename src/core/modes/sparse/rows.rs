//! Sparse matrices by whole rows, and what is computed with eight vectors at once.

use crate::precision::{Ball, Complex, DoubleDouble, LANES, Lane, Pair, SparseMatrix, kernel};

/// u, the rounding of a double.
pub(super) const U: f64 = 0.5 * f64::EPSILON;
/// Sums of products are taken in pieces of so many rows, which are then added in double-double.
const PIECE: usize = 1024;

/// A matrix by rows: centres of the entries as two doubles.
pub(super) struct Rows {
    pub(super) starts: Vec<usize>,
    pub(super) columns: Vec<u32>,
    pub(super) high: Vec<f64>,
    /// Empty where all entries are doubles.
    pub(super) low: Vec<f64>,
    /// Radii of the entries; empty where all are exact.
    radii: Vec<f64>,
    /// The most entries of a row.
    pub(super) widest: usize,
    /// A symmetric matrix without the entries right of the diagonal.
    half: bool,
}

impl Rows {
    /// A symmetric matrix of which the lower triangle is stored.
    pub(super) fn new(matrix: &SparseMatrix) -> Self {
        Self::of(matrix, true)
    }

    /// A symmetric matrix without any rows yet, which [`Self::push`] and [`Self::end_row`] give it; for its norms and decompositions alone.
    pub(super) fn half() -> Self {
        let (columns, high, low, radii) = Default::default();
        Self { starts: vec![0], columns, high, low, radii, widest: 0, half: true }
    }

    /// The next entry of the last row, which is not right of the diagonal; without the lower part of its centre, as entries are
    /// decomposed.
    pub(super) fn push(&mut self, column: usize, value: &Ball) {
        if !value.is_zero() {
            self.columns.push(column as u32);
            self.high.push(value.mid.hi);
            self.radii.push(value.radius);
        }
    }

    /// Ends a row.
    pub(super) fn end_row(&mut self) {
        let before = self.starts.last().copied().unwrap_or(0);
        self.widest = self.widest.max(self.columns.len() - before);
        self.starts.push(self.columns.len());
    }

    /// A matrix of which all entries are stored.
    pub(super) fn general(matrix: &SparseMatrix) -> Self {
        Self::of(matrix, false)
    }

    fn of(matrix: &SparseMatrix, mirrored: bool) -> Self {
        let n = matrix.dimension();
        let mut starts = vec![0_usize; n + 1];
        let (mut doubles, mut exact) = (true, true);
        for (i, j, value) in matrix.entries() {
            starts[i + 1] += 1;
            if mirrored && i != j {
                starts[j + 1] += 1;
            }
            doubles &= value.mid.lo == 0.0;
            exact &= value.radius == 0.0;
        }
        for i in 0..n {
            starts[i + 1] += starts[i];
        }
        let total = starts[n];
        let (mut columns, mut high) = (vec![0_u32; total], vec![0.0; total]);
        let mut low = vec![0.0; if doubles { 0 } else { total }];
        let mut radii = vec![0.0; if exact { 0 } else { total }];
        let mut next = starts.clone();
        // Column by column, so that every row has its entries in rising order: those left of the diagonal come first.
        for (i, j, value) in matrix.entries() {
            let mut put = |row: usize, column: usize| {
                let at = next[row];
                next[row] += 1;
                columns[at] = column as u32;
                high[at] = value.mid.hi;
                if let Some(low) = low.get_mut(at) {
                    *low = value.mid.lo;
                }
                if let Some(radius) = radii.get_mut(at) {
                    *radius = value.radius;
                }
            };
            put(i, j);
            if mirrored && i != j {
                put(j, i);
            }
        }
        let widest = (0..n).map(|i| starts[i + 1] - starts[i]).max().unwrap_or(0);
        Self { starts, columns, high, low, radii, widest, half: false }
    }

    pub(super) fn dimension(&self) -> usize {
        self.starts.len() - 1
    }

    pub(super) fn row(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i]..self.starts[i + 1]
    }

    /// The entry in a row and column, 0 where none is stored.
    pub(super) fn entry(&self, i: usize, j: usize) -> DoubleDouble {
        let row = self.row(i);
        let own = self.columns[row.clone()].binary_search(&(j as u32));
        own.map_or(DoubleDouble::ZERO, |at| self.value(row.start + at))
    }

    #[inline(always)]
    pub(super) fn value(&self, at: usize) -> DoubleDouble {
        DoubleDouble { hi: self.high[at], lo: self.low.get(at).copied().unwrap_or(0.0) }
    }

    /// The entries of a row: column and enclosure.
    pub(super) fn entries(&self, i: usize) -> impl Iterator<Item = (usize, Ball)> {
        self.row(i).map(|at| (self.columns[at] as usize, Ball::new(self.value(at), self.radius(at))))
    }

    pub(super) fn radius(&self, at: usize) -> f64 {
        self.radii.get(at).copied().unwrap_or(0.0)
    }

    /// A bound of |D^(-1/2) A D^(-1/2)| in length, for A the magnitudes of all entries, and for A their radii.
    pub(super) fn norms(&self, roots: &[f64]) -> (f64, f64) {
        let n = self.dimension();
        // Sums of magnitudes and of radii, and of how many entries.
        let mut sums = vec![(0.0, 0.0, 0_usize); n];
        for i in 0..n {
            for at in self.row(i) {
                let j = self.columns[at] as usize;
                let weight = roots[i] * roots[j];
                let mut add = |row: usize| {
                    let (sum, errors, count) = &mut sums[row];
                    *sum += self.high[at].abs() * weight;
                    *errors += self.radius(at) * weight;
                    *count += 1;
                };
                add(i);
                if self.half && i != j {
                    add(j);
                }
            }
        }
        let (mut most, mut radius) = (0.0_f64, 0.0_f64);
        for (sum, errors, count) in sums {
            let slack = 1.0 + (count + 16) as f64 * 2.0 * U;
            most = most.max(sum * slack);
            radius = radius.max(errors * slack);
        }
        (most, radius)
    }

    /// A x, enclosed.
    pub(super) fn times_balls(&self, x: &[Ball]) -> Vec<Ball> {
        let row = |i: usize| {
            let parts = self.entries(i).filter(|(j, _)| !x[*j].is_zero());
            parts.fold(Ball::ZERO, |sum, (j, entry)| sum + entry * x[j])
        };
        (0..self.dimension()).map(row).collect()
    }

    /// A component of A x, enclosed.
    pub(super) fn component(&self, x: &[Complex<Ball>], i: usize) -> Complex<Ball> {
        self.entries(i).fold(Complex::zero(()), |sum: Complex<Ball>, (j, entry)| sum.add(&x[j].times(&entry)))
    }

    /// y = A x in doubles.
    pub(super) fn times(&self, x: &[f64], y: &mut [f64]) {
        for (i, y) in y.iter_mut().enumerate() {
            let mut sum = 0.0;
            for at in self.row(i) {
                sum += self.high[at] * x[self.columns[at] as usize];
            }
            *y = sum;
        }
    }
}

/// Eight vectors side by side, one lane a vector, one element a coordinate.
pub(super) type Panel = Vec<Lane>;

kernel!(
/// K x - θ M x of eight vectors, summed in double-double and rounded to doubles.
///
/// With m entries in the widest row of K and of M: the products of higher parts are taken apart exactly, as are the additions of
/// their roundings; what is added to the lower parts is at most u (m + 2) times the sum P of magnitudes and is rounded at most
/// 2 m + 8 times, so that a component is off by ((m + 3)² + 16) u² P (|K| and |θ| |M| together), and by u of itself.
pub(super) residuals, residual_loops, (stiffness: &Rows, mass: &Rows, x: &[Lane], theta: Lane, out: &mut [Lane]));

/// A row of A times eight vectors, in double-double.
#[inline(always)]
fn row_times<const FUSED: bool>(rows: &Rows, i: usize, x: &[Lane]) -> Pair {
    let mut sum = Pair::ZERO;
    for at in rows.row(i) {
        sum.add_products::<FUSED>(x[rows.columns[at] as usize], &Pair::splat(rows.value(at)));
    }
    sum
}

#[inline(always)]
fn residual_loops<const FUSED: bool>(stiffness: &Rows, mass: &Rows, x: &[Lane], theta: Lane, out: &mut [Lane]) {
    for (i, out) in out.iter_mut().enumerate() {
        let mut sum = row_times::<FUSED>(stiffness, i, x);
        let inertia = row_times::<FUSED>(mass, i, x).settled();
        sum.add_products::<FUSED>(-theta, &inertia);
        *out = sum.high + sum.low;
    }
}

kernel!(
/// ‖K z - σ M z - r‖ of eight vectors, squared, with weights; see [`residuals`] and [`squares`].
pub(super) leftovers, leftover_loops, (matrices: [&Rows; 2], z: &[Lane], shift: f64, r: &[Lane], roots: &[f64]) -> Lane);

#[inline(always)]
fn leftover_loops<const FUSED: bool>(
    [stiffness, mass]: [&Rows; 2],
    z: &[Lane],
    shift: f64,
    r: &[Lane],
    roots: &[f64],
) -> Lane {
    let theta = Lane::splat(-shift);
    let (mut total, mut sum) = (Lane::ZERO, Lane::ZERO);
    for (i, r) in r.iter().enumerate() {
        let mut own = row_times::<FUSED>(stiffness, i, z);
        if shift != 0.0 {
            own.add_products::<FUSED>(theta, &row_times::<FUSED>(mass, i, z).settled());
        }
        let left = ((own.high - *r) + own.low) * Lane::splat(roots[i]);
        sum += left * left;
        if i % PIECE == PIECE - 1 {
            total += sum;
            sum = Lane::ZERO;
        }
    }
    rounded_up(total + sum, r.len())
}

/// Products of eight vectors with eight others, each with its own: Σ x_i y_i. Off by at most [`products_error`] times the lengths.
pub(super) fn products(x: &[Lane], y: &[Lane]) -> Lane {
    let mut total = Lane::ZERO;
    for (x, y) in x.chunks(PIECE).zip(y.chunks(PIECE)) {
        let own = x.iter().zip(y).fold(Lane::ZERO, |sum, (x, y)| sum + *x * *y);
        total += own;
    }
    total
}

/// See [`products`].
pub(super) fn products_error(n: usize) -> f64 {
    2.0 * (PIECE + n / PIECE + 8) as f64 * U
}

/// A sum of squares in pieces that is not below the exact one.
#[inline(always)]
fn rounded_up(sum: Lane, n: usize) -> Lane {
    let roundings = (PIECE + n / PIECE + 16) as f64;
    sum * Lane::splat(1.0 + 2.0 * roundings * U)
}

/// Products of the first vectors of a panel with the eight of another: `[a][b]`.
pub(super) type Products = [[DoubleDouble; LANES]; LANES];

kernel!(
/// x_a · A y_b of the first `count` vectors x in double-double: sums of n products, added in pieces. What they are off by is at
/// most u² ((m + 3)² + (PIECE + 3)² + n / PIECE + 32) times the sum of all magnitudes.
pub(super) forms, form_loops, (x: &[Lane], count: usize, matrix: &Rows, y: &[Lane]) -> Products);

/// See [`forms`], in units of u² of the sum of magnitudes.
pub(super) fn form_error(n: usize, widest: usize) -> f64 {
    let square = |x: usize| (x as f64 + 3.0) * (x as f64 + 3.0);
    square(widest) + square(PIECE) + (n / PIECE) as f64 + 32.0
}

#[inline(always)]
fn form_loops<const FUSED: bool>(x: &[Lane], count: usize, matrix: &Rows, y: &[Lane]) -> Products {
    let mut total = [[DoubleDouble::ZERO; LANES]; LANES];
    for (piece, x) in x.chunks(PIECE).enumerate() {
        let mut sums = [Pair::ZERO; LANES];
        for (i, x) in (piece * PIECE..).zip(x) {
            let own = row_times::<FUSED>(matrix, i, y).settled();
            for (sum, x) in sums.iter_mut().zip(x.0).take(count) {
                sum.add_products::<FUSED>(Lane::splat(x), &own);
            }
        }
        add(&mut total, sums.map(|sum| (sum.high, sum.low)));
    }
    total
}

#[inline(always)]
fn add(total: &mut Products, sums: [(Lane, Lane); LANES]) {
    for (total, (high, low)) in total.iter_mut().zip(&sums) {
        for (b, total) in total.iter_mut().enumerate() {
            *total = *total + DoubleDouble::new(high.0[b], low.0[b]);
        }
    }
}

kernel!(
/// x_a · y_b of the first `count` vectors x, in doubles but for the addition of pieces. What they are off by is at most
/// 2 u (PIECE + 8) times the sum of all magnitudes.
pub(super) plain_forms, plain_loops, (x: &[Lane], count: usize, y: &[Lane]) -> Products);

/// See [`plain_forms`]; the rest is for the additions of as many pieces as there may be.
pub(super) const PLAIN_ERROR: f64 = 2.0 * (PIECE + 9) as f64 * U;

#[inline(always)]
fn plain_loops<const FUSED: bool>(x: &[Lane], count: usize, y: &[Lane]) -> Products {
    let mut total = [[DoubleDouble::ZERO; LANES]; LANES];
    for (x, y) in x.chunks(PIECE).zip(y.chunks(PIECE)) {
        let mut sums = [Lane::ZERO; LANES];
        for (x, y) in x.iter().zip(y) {
            for (sum, x) in sums.iter_mut().zip(x.0).take(count) {
                *sum += Lane::splat(x) * *y;
            }
        }
        add(&mut total, sums.map(|sum| (sum, Lane::ZERO)));
    }
    total
}

/// Lengths of eight vectors, squared, with weights: Σ (w_i x_i)², each not below the exact value.
pub(super) fn squares(x: &[Lane], weights: &[f64]) -> Lane {
    let mut total = Lane::ZERO;
    for (x, weights) in x.chunks(PIECE).zip(weights.chunks(PIECE)) {
        let mut sum = Lane::ZERO;
        for (x, weight) in x.iter().zip(weights) {
            let own = *x * Lane::splat(*weight);
            sum += own * own;
        }
        total += sum;
    }
    rounded_up(total, x.len())
}
