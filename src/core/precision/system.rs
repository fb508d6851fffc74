//! Linear systems whose entries are enclosures, solved with a bound.

use nalgebra::{DMatrix, DVector};

use super::double::exponent_of;
use super::{Ball, Complex, DoubleDouble, up};

/// More corrections than it takes from doubles to double-double.
const MOST_CORRECTIONS: usize = 6;

/// A square matrix B of enclosures and an approximate inverse R of it, which prove that every matrix within is
/// regular: ‖1 - RB‖ < 1.
///
/// With x̃ about the solution of Bx = b and r = b - Bx̃ the error is x - x̃ = (RB)⁻¹Rr, so that no component of it is larger than
/// ‖Rr‖/(1 - ‖1 - RB‖) in the maximum norm (S. M. Rump, Verification methods: rigorous results using floating-point
/// arithmetic, Acta Numerica 19 (2010) 287, section 10). Rows and columns are brought to like size by powers of two.
pub struct System {
    order: usize,
    /// Row by row, scaled.
    entries: Vec<Ball>,
    row_shift: Vec<i32>,
    column_shift: Vec<i32>,
    inverse: DMatrix<f64>,
    /// An upper bound of ‖1 - RB‖.
    contraction: f64,
}

impl System {
    /// From the entries, row by row; `None` where the matrix is not shown to be regular.
    pub fn new(order: usize, mut entries: Vec<Ball>) -> Option<Self> {
        if entries.len() != order * order || !entries.iter().all(Ball::is_finite) {
            return None;
        }
        let size = |largest: f64| (largest > 0.0).then(|| -exponent_of(largest));
        let mut row_shift = Vec::with_capacity(order);
        for row in entries.chunks_exact_mut(order.max(1)) {
            let shift = size(row.iter().fold(0.0, |most: f64, x| most.max(x.mid_f64().abs())))?;
            row.iter_mut().for_each(|x| *x = x.scale(shift));
            row_shift.push(shift);
        }
        let mut column_shift = Vec::with_capacity(order);
        for j in 0..order {
            let column = (0..order).map(|i| entries[order * i + j].mid_f64().abs());
            let shift = size(column.fold(0.0, f64::max))?;
            entries.iter_mut().skip(j).step_by(order).for_each(|entry| *entry = entry.scale(shift));
            column_shift.push(shift);
        }
        let inverse = DMatrix::from_fn(order, order, |i, j| entries[order * i + j].mid_f64()).try_inverse()?;
        let contraction = contraction(&inverse, &entries)?;
        Some(Self { order, entries, row_shift, column_shift, inverse, contraction })
    }

    /// Likewise from the complex entry of each row and column: unknowns are real parts, then imaginary ones, and so are right sides.
    pub fn of_complex(order: usize, entry: impl Fn(usize, usize) -> Complex<Ball>) -> Option<Self> {
        let n = 2 * order;
        let entries = (0..n * n).map(|at| {
            let (i, j) = (at / n, at % n);
            let own = entry(i % order, j % order);
            match (i < order, j < order) {
                (true, true) | (false, false) => own.re,
                (true, false) => -own.im,
                (false, true) => own.im,
            }
        });
        Self::new(n, entries.collect())
    }

    /// The system with the transposed matrix.
    pub fn transposed(&self) -> Option<Self> {
        let n = self.order;
        let entries: Vec<Ball> = (0..n * n).map(|at| self.entries[n * (at % n) + at / n]).collect();
        let inverse = self.inverse.transpose();
        let contraction = contraction(&inverse, &entries)?;
        Some(Self {
            order: n,
            entries,
            row_shift: self.column_shift.clone(),
            column_shift: self.row_shift.clone(),
            inverse,
            contraction,
        })
    }

    /// The solution for a right side, for every matrix and right side within their enclosures.
    pub fn solve(&self, right: &[Ball]) -> Option<Vec<Ball>> {
        let n = self.order;
        let right: Vec<Ball> = right.iter().zip(&self.row_shift).map(|(x, shift)| x.scale(*shift)).collect();
        let mut middle = vec![DoubleDouble::ZERO; n];
        let mut best: Option<(f64, Vec<DoubleDouble>)> = None;
        for _ in 0..MOST_CORRECTIONS {
            let residual = self.residual(&right, &middle);
            let error = self.error(&residual)?;
            // As long as it helps clearly.
            if best.as_ref().is_some_and(|(least, _)| error > 0.25 * least) {
                if let Some((least, known)) = &mut best
                    && error < *least
                {
                    (*least, *known) = (error, middle);
                }
                break;
            }
            let off = DVector::from_fn(n, |i, _| residual[i].mid_f64());
            let step = &self.inverse * off;
            let next = middle.iter().zip(step.iter()).map(|(x, step)| *x + DoubleDouble::exact(*step));
            let next: Vec<DoubleDouble> = next.collect();
            best = Some((error, std::mem::replace(&mut middle, next)));
        }
        let (error, middle) = best?;
        let ball = |(x, shift): (DoubleDouble, &i32)| Ball::new(x, 0.0).with_added_radius(error).scale(*shift);
        let solution: Vec<Ball> = middle.into_iter().zip(&self.column_shift).map(ball).collect();
        solution.iter().all(Ball::is_finite).then_some(solution)
    }

    /// b - Bx.
    fn residual(&self, right: &[Ball], x: &[DoubleDouble]) -> Vec<Ball> {
        let rows = self.entries.chunks_exact(self.order.max(1));
        let left = |(row, right): (&[Ball], &Ball)| {
            let terms = row.iter().zip(x).filter(|(entry, x)| !entry.is_zero() && x.hi != 0.0);
            terms.fold(*right, |sum, (entry, x)| sum - *entry * Ball::from(*x))
        };
        rows.zip(right).map(left).collect()
    }

    /// ‖Rr‖/(1 - ‖1 - RB‖), rounded up.
    fn error(&self, residual: &[Ball]) -> Option<f64> {
        let n = self.order;
        let sizes: Vec<f64> = residual.iter().map(Ball::abs_upper).collect();
        let sum = |i: usize| (0..n).map(|k| self.inverse[(i, k)].abs() * sizes[k]).sum::<f64>();
        let most = (0..n).map(sum).fold(0.0, f64::max);
        let error = up(up(most * slack(n)) / (1.0 - self.contraction));
        error.is_finite().then_some(error)
    }
}

/// A factor that covers the rounding of sums of `n` numbers that are not negative, and of their products.
fn slack(n: usize) -> f64 {
    1.0 + (2.0 * n as f64 + 16.0) * f64::EPSILON
}

/// An upper bound of ‖1 - RB‖ in the norm of row sums, where it is less than 1.
///
/// With B̂ the doubles at the middle, |1 - RB| <= |1 - fl(RB̂)| + γ_n |R||B̂| + |R||B - B̂|, row by row (N. J. Higham, Accuracy
/// and Stability of Numerical Algorithms, 2nd ed. (2002), (3.13)), whatever the order of the sums; n 2^-1074 for
/// each entry at most is lost to underflow. γ_n = nu/(1 - nu) <= 2nu = n 2^-52.
fn contraction(inverse: &DMatrix<f64>, entries: &[Ball]) -> Option<f64> {
    let n = inverse.nrows();
    let gamma = n as f64 * f64::EPSILON;
    let weight = |row: &[Ball]| row.iter().map(|x| gamma * x.mid_f64().abs() + x.mid_f64_error()).sum();
    let weight: Vec<f64> = entries.chunks_exact(n.max(1)).map(weight).collect();
    let product = inverse * DMatrix::from_fn(n, n, |i, j| entries[n * i + j].mid_f64());
    let mut most: f64 = 0.0;
    for i in 0..n {
        let mut sum = 0.0;
        for j in 0..n {
            let unit = if i == j { 1.0 } else { 0.0 };
            sum += (unit - product[(i, j)]).abs();
            sum += inverse[(i, j)].abs() * weight[j];
        }
        most = most.max(sum);
    }
    // Each difference from 1 is rounded, too; 1e-300 stands for underflow.
    let most = up(most * slack(2 * n)) + 1e-300;
    (most < 0.5).then_some(most)
}
