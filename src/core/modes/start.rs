//! First approximations of the eigenvectors, in doubles.
//!
//! Cholesky M = L Lᵀ, standard problem A = L⁻¹ K L⁻ᵀ, reflections that take the zero vectors out,
//! an eigenvalue decomposition in doubles, back to X = L⁻ᵀ U. Where M is too ill-conditioned for
//! doubles, the same with Cholesky factor and reduction in numbers of higher precision.
//!
//! Nothing here is trusted: what comes out is certified afterwards, however it came about.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::householder::{
    apply_block_householder_sequence_on_the_left_in_place_scratch as turn_scratch,
    apply_block_householder_sequence_on_the_left_in_place_with_conj as turn,
    apply_block_householder_sequence_transpose_on_the_left_in_place_with_conj as turn_back,
};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Conj, Mat, MatMut, MatRef, Par, Side};

use super::dense::Matrix;
use crate::precision::Enclosure;

/// Relative size below which a pivot in doubles cannot be told from rounding error, per unit of dimension.
pub(super) const NOISE: f64 = 4.0 * f64::EPSILON;

/// The lower Cholesky factor in doubles; `None` if a pivot is not above so much of the diagonal entry.
pub(super) fn cholesky(a: &Mat<f64>, noise: f64) -> Option<Mat<f64>> {
    let l = a.llt(Side::Lower).ok()?.L().to_owned();
    let clear = |k: usize| {
        let pivot = l[(k, k)] * l[(k, k)];
        pivot > noise * a[(k, k)].abs() && pivot.is_finite()
    };
    (0..a.nrows()).all(clear).then_some(l)
}

/// The Cholesky factor of M in doubles; of a diagonal matrix the reciprocals of its entries.
pub(super) enum Factor {
    Diagonal(Vec<f64>),
    Full(Mat<f64>),
}

impl Factor {
    /// `None` where doubles will not do.
    pub(super) fn new(mass: &Matrix) -> Option<Self> {
        let n = mass.rows;
        if (0..n).all(|c| mass.hi.column(c)[c + 1..].iter().all(|x| *x == 0.0)) {
            let pivots = (0..n).map(|k| mass.get(k, k).hi);
            let inverse = |pivot: f64| (pivot > 0.0 && pivot.is_finite()).then(|| 1.0 / pivot.sqrt());
            return pivots.map(inverse).collect::<Option<_>>().map(Self::Diagonal);
        }
        cholesky(&mass.doubles(), NOISE * n as f64).map(Self::Full)
    }

    /// B <- L⁻¹ B, or L⁻ᵀ B.
    fn solve(&self, b: MatMut<'_, f64>, transposed: bool) {
        match self {
            Self::Full(l) if transposed => solve_upper_triangular_in_place(l.transpose(), b, Par::Seq),
            Self::Full(l) => solve_lower_triangular_in_place(l.as_ref(), b, Par::Seq),
            Self::Diagonal(inverse) => {
                for column in b.col_iter_mut() {
                    column.iter_mut().zip(inverse).for_each(|(x, inverse)| *x *= inverse);
                }
            }
        }
    }

    /// Lᵀ B
    fn transposed_times(&self, b: &Mat<f64>) -> Mat<f64> {
        match self {
            Self::Full(l) => l.transpose() * b,
            Self::Diagonal(inverse) => Mat::from_fn(b.nrows(), b.ncols(), |i, j| b[(i, j)] / inverse[i]),
        }
    }

    /// Approximate eigenvectors in doubles: the columns of X, n by n - z for z zero vectors (the columns of `zero`),
    /// M-orthonormal and M-orthogonal to the zero vectors up to rounding; `None` where the decomposition does not converge.
    pub(super) fn eigenvectors(&self, stiffness: &Matrix, zero: &Matrix) -> Option<Matrix> {
        let mut a = stiffness.doubles();
        self.solve(a.as_mut(), false);
        self.solve(a.as_mut().transpose_mut(), false);
        let mut u = deflated_eigenvectors(a, &self.transposed_times(&zero.doubles()))?;
        self.solve(u.as_mut(), true);
        Some(Matrix::from_doubles(u.as_ref()))
    }
}

/// Why there is no first approximation at a higher precision.
pub(super) enum Failure<S> {
    /// M has no Cholesky factor in this arithmetic; along this direction its form is not positive
    /// beyond rounding.
    NotPositiveDefinite(Vec<S>),
    /// The decomposition did not converge.
    NoConvergence,
}

/// Entries of a matrix by row and column.
pub(super) type Entries<'a, S> = &'a dyn Fn(usize, usize) -> S;

/// The columns of [`Factor::eigenvectors`] with Cholesky factor and reduction in midpoints of enclosures. A pivot has to
/// be above `noise` of the diagonal entry.
pub(super) fn careful_eigenvectors<S: Enclosure>(
    mass: Entries<'_, S>,
    stiffness: Entries<'_, S>,
    zero: &Mat<f64>,
    noise: f64,
    precision: S::Precision,
) -> Result<Vec<Vec<S>>, Failure<S>> {
    let n = zero.nrows();
    let l = factor(n, mass, noise, precision).map_err(Failure::NotPositiveDefinite)?;
    // A = L⁻¹ (L⁻¹ K)ᵀ
    let reduced = |entries: Entries<'_, S>| -> Vec<Vec<S>> {
        let column = |j: usize| {
            let mut column: Vec<S> = (0..n).map(|i| entries(i, j)).collect();
            forward(&l, &mut column);
            column
        };
        (0..n).map(column).collect()
    };
    let half = reduced(stiffness);
    let whole = reduced(&|i, j| half[i][j].clone());
    let a = Mat::from_fn(n, n, |i, j| whole[j][i].mid_f64());
    let lower = Mat::from_fn(n, n, |i, j| if i >= j { l[j][i].mid_f64() } else { 0.0 });
    let u = deflated_eigenvectors(a, &(lower.transpose() * zero)).ok_or(Failure::NoConvergence)?;
    let column = |j: usize| {
        let mut column: Vec<S> = (0..n).map(|i| S::exact(u[(i, j)], precision)).collect();
        backward(&l, &mut column, n);
        column
    };
    Ok((0..u.ncols()).map(column).collect())
}

/// The lower Cholesky factor, column by column, or the vector v = (-M_k⁻¹ m, 1, 0, ...) for which vᵀMv is the k-th pivot.
pub(super) fn factor<S: Enclosure>(
    n: usize,
    mass: Entries<'_, S>,
    noise: f64,
    precision: S::Precision,
) -> Result<Vec<Vec<S>>, Vec<S>> {
    let mut l: Vec<Vec<S>> = (0..n).map(|j| (0..n).map(|i| mass(i, j)).collect()).collect();
    for k in 0..n {
        let pivot = l[k][k].mid_f64();
        if pivot <= noise * mass(k, k).mid_f64().abs() || !pivot.is_finite() {
            let mut v = vec![S::exact(0.0, precision); n];
            v[k] = S::exact(1.0, precision);
            backward(&l, &mut v, k);
            return Err(v);
        }
        let (done, rest) = l.split_at_mut(k + 1);
        let column = &mut done[k];
        let root = column[k].sqrt().center();
        for value in &mut column[k + 1..] {
            *value = value.div(&root).center();
        }
        column[k] = root;
        for (j, target) in (k + 1..).zip(rest) {
            subtract(&mut target[j..], &column[j..], &column[j]);
        }
    }
    Ok(l)
}

/// x <- x - factor y, in midpoints.
fn subtract<S: Enclosure>(x: &mut [S], y: &[S], factor: &S) {
    if factor.is_zero() {
        return;
    }
    for (x, y) in x.iter_mut().zip(y).filter(|(_, y)| !y.is_zero()) {
        *x = x.sub(&factor.mul(y)).center();
    }
}

/// x <- L⁻¹ x
pub(super) fn forward<S: Enclosure>(l: &[Vec<S>], x: &mut [S]) {
    for (k, column) in l.iter().enumerate() {
        let value = x[k].div(&column[k]).center();
        subtract(&mut x[k + 1..], &column[k + 1..], &value);
        x[k] = value;
    }
}

/// x <- L⁻ᵀ x in the first components; the others stay as they are.
fn backward<S: Enclosure>(l: &[Vec<S>], x: &mut [S], first: usize) {
    for (k, column) in l[..first].iter().enumerate().rev() {
        let others = x[k + 1..].iter().zip(&column[k + 1..]).filter(|(t, _)| !t.is_zero());
        let value = others.fold(x[k].clone(), |value, (t, c)| value.sub(&t.mul(c)).center());
        x[k] = value.div(&column[k]).center();
    }
}

/// Orthonormal eigenvectors of a symmetric matrix that are orthogonal to the columns of z.
fn deflated_eigenvectors(mut a: Mat<f64>, z: &Mat<f64>) -> Option<Mat<f64>> {
    let (n, split) = (z.nrows(), z.ncols());
    if split == 0 {
        return symmetric_eigenvectors(a.as_ref());
    }
    // Q takes the first axes to the columns of z.
    let qr = z.qr();
    let (basis, coefficients) = (qr.Q_basis(), qr.Q_coeff());
    let mut memory = MemBuffer::new(turn_scratch::<f64>(n, coefficients.nrows(), n));
    let stack = MemStack::new(&mut memory);
    turn_back(basis, coefficients, Conj::No, a.as_mut(), Par::Seq, stack);
    turn_back(basis, coefficients, Conj::No, a.as_mut().transpose_mut(), Par::Seq, stack);
    let left = n - split;
    let inner = symmetric_eigenvectors(a.submatrix(split, split, left, left))?;
    let mut u = Mat::zeros(n, left);
    u.submatrix_mut(split, 0, left, left).copy_from(&inner);
    turn(basis, coefficients, Conj::No, u.as_mut(), Par::Seq, stack);
    Some(u)
}

/// Orthonormal eigenvectors of a symmetric matrix, of which the lower triangle is read.
pub(super) fn symmetric_eigenvectors(a: MatRef<'_, f64>) -> Option<Mat<f64>> {
    // Nothing is left where all modes are zero modes.
    if a.nrows() == 0 {
        return Some(Mat::zeros(0, 0));
    }
    if !a.is_all_finite() {
        return None;
    }
    Some(a.self_adjoint_eigen(Side::Lower).ok()?.U().to_owned())
}
