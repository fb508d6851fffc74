//! First approximations of the eigenvectors, in doubles.
//!
//! Cholesky M = L Lᵀ, standard problem A = L⁻¹ K L⁻ᵀ, reflections that take the zero vectors out,
//! an eigenvalue decomposition in doubles, back to X = L⁻ᵀ U. Where M is too ill-conditioned for
//! doubles, the same with Cholesky factor and reduction in double-double.
//!
//! Nothing here is trusted: what comes out is certified afterwards, however it came about.

use std::ops::{Add, Div, Mul, Neg, Sub};

use faer::diag::DiagMut;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{MatMut, MatRef, Par};
use nalgebra::{DMatrix, SymmetricEigen};

use super::dense::Matrix;
use crate::precision::DoubleDouble;

/// From this dimension on faer decomposes faster than nalgebra: equal at 10, 1.4 times at 20, 3 times
/// at 80 (benches/modes.rs, `decomposition`).
const LARGE: usize = 14;

/// From this dimension on a dense M is factored by faer.
const DENSE: usize = 24;

/// What Cholesky factor and substitutions need.
trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Relative size below which a pivot cannot be told from rounding error, per unit of dimension.
    const NOISE: f64;
    fn of(value: DoubleDouble) -> Self;
    fn double(self) -> f64;
    fn wide(self) -> DoubleDouble;
    fn root(self) -> Self;
}

impl Real for f64 {
    const NOISE: f64 = 4.0 * f64::EPSILON;

    fn of(value: DoubleDouble) -> Self {
        value.hi
    }

    fn double(self) -> f64 {
        self
    }

    fn wide(self) -> DoubleDouble {
        DoubleDouble::exact(self)
    }

    fn root(self) -> Self {
        self.sqrt()
    }
}

impl Real for DoubleDouble {
    const NOISE: f64 = 64.0 * f64::EPSILON * f64::EPSILON;

    fn of(value: DoubleDouble) -> Self {
        value
    }

    fn double(self) -> f64 {
        self.hi
    }

    fn wide(self) -> DoubleDouble {
        self
    }

    fn root(self) -> Self {
        self.sqrt()
    }
}

/// Why there is no first approximation.
pub(super) enum Failure {
    /// M has no Cholesky factor in this arithmetic; along this direction its form is not positive
    /// beyond rounding.
    NotPositiveDefinite(Vec<DoubleDouble>),
    /// The decomposition did not converge.
    NoConvergence,
}

/// Approximate eigenvectors in doubles: the columns of X, n by n - z for z zero vectors (the
/// columns of `zero`), M-orthonormal and M-orthogonal to the zero vectors up to rounding.
pub(super) fn in_doubles(mass: &Matrix, stiffness: &Matrix, zero: &Matrix) -> Result<Matrix, Failure> {
    if mass.rows >= DENSE {
        let factor = diagonal_factor(mass).or_else(|| blocked_factor(mass));
        if let Some(factor) = factor {
            return by_blocks(&factor, stiffness, zero);
        }
    }
    approximate::<f64>(mass, stiffness, zero)
}

/// The same with Cholesky factor and reduction in double-double.
pub(super) fn in_double_doubles(mass: &Matrix, stiffness: &Matrix, zero: &Matrix) -> Result<Matrix, Failure> {
    approximate::<DoubleDouble>(mass, stiffness, zero)
}

fn approximate<R: Real>(mass: &Matrix, stiffness: &Matrix, zero: &Matrix) -> Result<Matrix, Failure> {
    let n = mass.rows;
    let factor = Factor::<R>::new(mass).map_err(Failure::NotPositiveDefinite)?;
    // A = L⁻¹ (L⁻¹ K)ᵀ
    let mut a: Vec<R> = Vec::with_capacity(n * n);
    for column in 0..n {
        a.extend((0..n).map(|row| R::of(stiffness.get(row, column))));
    }
    a.chunks_exact_mut(n).for_each(|column| factor.forward(column));
    transpose(&mut a, n);
    a.chunks_exact_mut(n).for_each(|column| factor.forward(column));
    let mut a: Vec<f64> = a.into_iter().map(R::double).collect();
    let u = deflated_eigenvectors(&factor, &mut a, zero).ok_or(Failure::NoConvergence)?;
    let mut x = Matrix::zeros(n, n - zero.columns);
    let mut y: Vec<R> = Vec::with_capacity(n);
    for (column, u) in u.chunks_exact(n).enumerate() {
        y.clear();
        y.extend(u.iter().map(|&value| R::of(DoubleDouble::exact(value))));
        factor.backward(&mut y);
        for (row, value) in y.iter().enumerate() {
            x.set(row, column, value.wide());
        }
    }
    Ok(x)
}

/// The factor of a diagonal matrix; `None` where it is not, or where doubles will not do.
fn diagonal_factor(mass: &Matrix) -> Option<Factor<f64>> {
    let n = mass.rows;
    let below = |c: usize| mass.column_hi(c)[c + 1..].iter().all(|x| *x == 0.0);
    let positive = |c: usize| {
        let pivot = mass.get(c, c).hi;
        pivot > 0.0 && pivot.is_finite()
    };
    if !(0..n).all(|c| positive(c) && below(c)) {
        return None;
    }
    let mut entries = vec![0.0; n * n];
    for c in 0..n {
        entries[c * n + c] = mass.get(c, c).hi.sqrt();
    }
    Some(Factor { n, diagonal_only: true, entries })
}

/// The factor of a matrix that is not diagonal, by faer; `None` where doubles will not
/// do: then the other way finds out why.
fn blocked_factor(mass: &Matrix) -> Option<Factor<f64>> {
    let n = mass.rows;
    let mut entries: Vec<f64> = Vec::with_capacity(n * n);
    for column in 0..n {
        entries.extend_from_slice(mass.column_hi(column));
    }
    let scratch = cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
    let mut memory = MemBuffer::try_new(scratch).ok()?;
    cholesky_in_place(
        MatMut::from_column_major_slice_mut(&mut entries, n, n),
        Default::default(),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .ok()?;
    let noise = f64::NOISE * n as f64;
    let clear = (0..n).all(|k| {
        let pivot = entries[k * n + k] * entries[k * n + k];
        pivot > noise * mass.get(k, k).hi && pivot.is_finite()
    });
    clear.then_some(Factor { n, diagonal_only: false, entries })
}

/// [`approximate`] in doubles, whole blocks of columns at a time.
fn by_blocks(factor: &Factor<f64>, stiffness: &Matrix, zero: &Matrix) -> Result<Matrix, Failure> {
    let (n, m) = (factor.n, factor.n - zero.columns);
    let l = MatRef::from_column_major_slice(&factor.entries, n, n);
    let mut a: Vec<f64> = Vec::with_capacity(n * n);
    for column in 0..n {
        a.extend_from_slice(stiffness.column_hi(column));
    }
    let inverse: Vec<f64> = (0..n).map(|k| 1.0 / factor.entries[k * n + k]).collect();
    if factor.diagonal_only {
        for (column, own) in a.chunks_exact_mut(n).zip(&inverse) {
            for (x, other) in column.iter_mut().zip(&inverse) {
                *x *= own * other;
            }
        }
    } else {
        let mut block = MatMut::from_column_major_slice_mut(&mut a, n, n);
        solve_lower_triangular_in_place(l, block.as_mut(), Par::Seq);
        solve_lower_triangular_in_place(l, block.transpose_mut(), Par::Seq);
    }
    let mut u = deflated_eigenvectors(factor, &mut a, zero).ok_or(Failure::NoConvergence)?;
    if factor.diagonal_only {
        for column in u.chunks_exact_mut(n) {
            for (x, inverse) in column.iter_mut().zip(&inverse) {
                *x *= inverse;
            }
        }
    } else if m > 0 {
        let block = MatMut::from_column_major_slice_mut(&mut u, n, m);
        solve_upper_triangular_in_place(l.transpose(), block, Par::Seq);
    }
    let mut x = Matrix::zeros(n, m);
    for (column, u) in u.chunks_exact(n).enumerate() {
        x.column_mut(column).0.copy_from_slice(u);
    }
    Ok(x)
}

/// Eigenvectors of A = L⁻¹ K L⁻ᵀ orthogonal to Lᵀ Z, column by column; A is overwritten.
fn deflated_eigenvectors<R: Real>(factor: &Factor<R>, a: &mut [f64], zero: &Matrix) -> Option<Vec<f64>> {
    let (n, z) = (factor.n, zero.columns);
    if z == 0 {
        return symmetric_eigenvectors(n, a);
    }
    let mut reflectors: Vec<Vec<f64>> = Vec::with_capacity(z);
    for p in 0..z {
        // Lᵀ z, as earlier reflections leave it, is turned into the p-th axis.
        let mut v: Vec<f64> = (0..n).map(|row| factor.transposed_row(row, |k| zero.get(k, p).hi)).collect();
        for (q, earlier) in reflectors.iter().enumerate() {
            reflect(&mut v[q..], earlier);
        }
        let axis = householder(&v[p..]);
        reflect_both_sides(a, n, p, &axis);
        reflectors.push(axis);
    }
    let m = n - z;
    let mut block = Vec::with_capacity(m * m);
    for column in z..n {
        block.extend_from_slice(&a[column * n + z..(column + 1) * n]);
    }
    let vectors = symmetric_eigenvectors(m, &mut block)?;
    let mut u = vec![0.0; n * m];
    if m > 0 {
        for (u, vector) in u.chunks_exact_mut(n).zip(vectors.chunks_exact(m)) {
            u[z..].copy_from_slice(vector);
            for (p, axis) in reflectors.iter().enumerate().rev() {
                reflect(&mut u[p..], axis);
            }
        }
    }
    Some(u)
}

/// The Cholesky factor, column by column, lower triangle.
struct Factor<R> {
    n: usize,
    diagonal_only: bool,
    entries: Vec<R>,
}

impl<R: Real> Factor<R> {
    fn new(mass: &Matrix) -> Result<Self, Vec<DoubleDouble>> {
        let n = mass.rows;
        let mut entries: Vec<R> = Vec::with_capacity(n * n);
        for column in 0..n {
            entries.extend((0..n).map(|row| R::of(mass.get(row, column))));
        }
        let diagonal_only = (0..n).all(|c| (c + 1..n).all(|r| entries[c * n + r].double() == 0.0));
        for k in 0..n {
            let pivot = entries[k * n + k];
            if pivot.double() <= R::NOISE * n as f64 * mass.get(k, k).hi.abs() || !pivot.double().is_finite() {
                return Err(null_direction(&entries, n, k));
            }
            let root = pivot.root();
            entries[k * n + k] = root;
            if diagonal_only {
                continue;
            }
            let (done, rest) = entries.split_at_mut((k + 1) * n);
            let column = &mut done[k * n..];
            for value in &mut column[k + 1..] {
                *value = *value / root;
            }
            for (j, target) in rest.chunks_exact_mut(n).enumerate() {
                let j = k + 1 + j;
                let factor = column[j];
                if factor.double() == 0.0 {
                    continue;
                }
                for (t, &c) in target[j..].iter_mut().zip(&column[j..]) {
                    *t = *t - factor * c;
                }
            }
        }
        Ok(Self { n, diagonal_only, entries })
    }

    /// x <- L⁻¹ x
    fn forward(&self, x: &mut [R]) {
        let n = self.n;
        for k in 0..n {
            let column = &self.entries[k * n..(k + 1) * n];
            let value = x[k] / column[k];
            x[k] = value;
            if self.diagonal_only || value.double() == 0.0 {
                continue;
            }
            for (t, &c) in x[k + 1..].iter_mut().zip(&column[k + 1..]) {
                *t = *t - value * c;
            }
        }
    }

    /// x <- L⁻ᵀ x
    fn backward(&self, x: &mut [R]) {
        let n = self.n;
        for k in (0..n).rev() {
            let column = &self.entries[k * n..(k + 1) * n];
            let mut value = x[k];
            if !self.diagonal_only {
                for (&t, &c) in x[k + 1..].iter().zip(&column[k + 1..]) {
                    value = value - t * c;
                }
            }
            x[k] = value / column[k];
        }
    }

    /// One component of Lᵀ z.
    fn transposed_row(&self, row: usize, z: impl Fn(usize) -> f64) -> f64 {
        if self.diagonal_only {
            return self.entries[row * self.n + row].double() * z(row);
        }
        let column = &self.entries[row * self.n..(row + 1) * self.n];
        (row..self.n).map(|k| column[k].double() * z(k)).sum()
    }
}

/// The vector v = (-M_k⁻¹ m, 1, 0, ...) for which vᵀMv is the k-th pivot, from the first k columns
/// of the factor.
fn null_direction<R: Real>(entries: &[R], n: usize, k: usize) -> Vec<DoubleDouble> {
    let mut v = vec![DoubleDouble::ZERO; n];
    v[k] = DoubleDouble::ONE;
    for row in (0..k).rev() {
        let column = &entries[row * n..(row + 1) * n];
        // L_kᵀ w = the k-th row of L, with w = -v.
        let mut sum = -column[k].wide();
        for j in row + 1..k {
            sum = sum - column[j].wide() * v[j];
        }
        v[row] = sum / column[row].wide();
    }
    v
}

fn transpose<T>(a: &mut [T], n: usize) {
    for column in 0..n {
        for row in 0..column {
            a.swap(column * n + row, row * n + column);
        }
    }
}

/// The unit vector w for which 1 - 2 w wᵀ takes v to the first axis.
fn householder(v: &[f64]) -> Vec<f64> {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut w = v.to_vec();
    if let Some(first) = w.first_mut() {
        *first += if *first < 0.0 { -norm } else { norm };
    }
    let norm = w.iter().map(|x| x * x).sum::<f64>().sqrt();
    if norm > 0.0 {
        w.iter_mut().for_each(|x| *x /= norm);
    }
    w
}

fn reflect(x: &mut [f64], w: &[f64]) {
    let dot: f64 = x.iter().zip(w).map(|(a, b)| a * b).sum();
    for (x, w) in x.iter_mut().zip(w) {
        *x -= 2.0 * dot * w;
    }
}

/// A <- (1 - 2 w wᵀ) A (1 - 2 w wᵀ) in the rows and columns from p on.
fn reflect_both_sides(a: &mut [f64], n: usize, p: usize, w: &[f64]) {
    let mut q = vec![0.0; w.len()];
    for (column, &factor) in a[p * n..].chunks_exact(n).zip(w) {
        for (q, x) in q.iter_mut().zip(&column[p..]) {
            *q += 2.0 * factor * x;
        }
    }
    let half: f64 = q.iter().zip(w).map(|(a, b)| a * b).sum();
    for (q, w) in q.iter_mut().zip(w) {
        *q -= half * w;
    }
    for (j, column) in a[p * n..].chunks_exact_mut(n).enumerate() {
        for ((x, q_i), w_i) in column[p..].iter_mut().zip(&q).zip(w) {
            *x -= w_i * q[j] + q_i * w[j];
        }
    }
}

/// Orthonormal eigenvectors of a symmetric matrix, column by column; the matrix is overwritten.
pub(super) fn symmetric_eigenvectors(n: usize, a: &mut [f64]) -> Option<Vec<f64>> {
    // Nothing is left where all modes are zero modes; nalgebra panics on an empty matrix.
    if n == 0 {
        return Some(Vec::new());
    }
    for column in 0..n {
        for row in 0..column {
            let mean = 0.5 * (a[column * n + row] + a[row * n + column]);
            a[column * n + row] = mean;
            a[row * n + column] = mean;
        }
    }
    if a.iter().any(|x| !x.is_finite()) {
        return None;
    }
    if n < LARGE {
        let matrix = DMatrix::from_column_slice(n, n, a);
        let eigen = SymmetricEigen::try_new(matrix, f64::EPSILON, 100 * (n + 1))?;
        return Some(eigen.eigenvectors.as_slice().to_vec());
    }
    let mut values = vec![0.0; n];
    let mut vectors = vec![0.0; n * n];
    let yes = ComputeEigenvectors::Yes;
    let scratch = self_adjoint_evd_scratch::<f64>(n, yes, Par::Seq, Default::default());
    let mut memory = MemBuffer::try_new(scratch).ok()?;
    self_adjoint_evd(
        MatRef::from_column_major_slice(a, n, n),
        DiagMut::from_slice_mut(&mut values),
        Some(MatMut::from_column_major_slice_mut(&mut vectors, n, n)),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .ok()?;
    Some(vectors)
}
