//! First approximations of exponents, vectors and left vectors, in doubles.
//!
//! Cholesky M = L Lᵀ, then a matrix of first order A = [[0, F₁], [-F₂, -L⁻¹DL⁻ᵀ]] with F₂F₁ = L⁻¹SL⁻ᵀ: where the
//! symmetric part of S is positive definite F₂ is its Cholesky factor, which keeps slow exponents beside fast ones
//! (the rounding errors of A are those of its frequencies, not of their squares) and makes A skew, thus
//! normal, where nothing is damped. Else F₁ is a multiple of the unit matrix. Vectors of the exponent 0 and the
//! chains that start from them are split off before.
//!
//! Nothing here is trusted: what comes out is certified afterwards, however it came about.

use faer::linalg::solvers::DenseSolveCore;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par, Scale, c64};
use nalgebra::DMatrix;
use nalgebra::linalg::balancing::balance_parlett_reinsch;

use super::super::start::{NOISE, cholesky};
use super::columns::{Column, Columns};
use super::complex::{Complex, part};
use super::couplings::Link;
use super::scale::Scaled;
use crate::precision::Ball;

/// The length that links of chains of the exponent 0 are given: discs around 0 are at least as large. Residuals of
/// the columns at both ends are smaller by far, whatever the length.
const LINK: f64 = 1.0 / (1u64 << 30) as f64;

/// L⁻¹ A L⁻ᵀ
fn reduced(l: &Mat<f64>, mut a: Mat<f64>) -> Mat<f64> {
    solve_lower_triangular_in_place(l.as_ref(), a.as_mut(), Par::Seq);
    solve_lower_triangular_in_place(l.as_ref(), a.as_mut().transpose_mut(), Par::Seq);
    a
}

/// The zero vectors in reduced coordinates with chain vectors: x and, for each chain, its combination of zero
/// vectors.
struct Kernel {
    /// n by z.
    basis: Mat<f64>,
    /// n by c, and z by c.
    chain: Mat<f64>,
    heads: Mat<f64>,
}

/// Chains of length two that start in the kernel: Z a with ZᵀDZ a = 0 and S z₁ = -D Z a.
fn kernel(scaled: &Scaled, l: &Mat<f64>, d: &Mat<f64>, s: &Mat<f64>) -> Option<Kernel> {
    let (n, z) = (scaled.n, scaled.zero.len());
    let mut basis = Mat::from_fn(n, z, |i, j| scaled.zero[j][i].mid_f64());
    // Lᵀ x
    basis = l.transpose() * &basis;
    // The kernel from the left; S may not be symmetric.
    let svd = s.svd().ok()?;
    let left = if scaled.structure == super::Structure::Gyroscopic {
        basis.clone()
    } else {
        Mat::from_fn(n, z, |i, j| svd.U()[(i, n - z + j)])
    };
    let image = d * &basis;
    let small = left.transpose() * &image;
    let size = d.norm_max() * left.norm_max() * basis.norm_max() * n as f64;
    let inner = small.svd().ok()?;
    let rank = (0..z).filter(|&k| inner.S()[k].abs() > 1e-10 * size).count();
    let chains = z - rank;
    let heads = Mat::from_fn(z, chains, |i, j| inner.V()[(i, rank + j)]);
    // -S⁺ D Z a
    let target = &image * &heads;
    let largest_s = if n > 0 { svd.S()[0].abs() } else { 0.0 };
    let mut chain = svd.U().transpose() * &target;
    for i in 0..n {
        let value = svd.S()[i];
        let by = if i < n - z && value.abs() > 1e-13 * largest_s { -1.0 / value } else { 0.0 };
        for j in 0..chains {
            chain[(i, j)] *= by;
        }
    }
    let chain = svd.V() * &chain;
    Some(Kernel { basis, chain, heads })
}

/// Makes rows and columns of like size by powers of two.
fn balanced(a: &mut Mat<f64>) -> Vec<f64> {
    let n = a.nrows();
    let mut matrix = DMatrix::from_fn(n, n, |i, j| a[(i, j)]);
    let scale = balance_parlett_reinsch(&mut matrix);
    *a = Mat::from_fn(n, n, |i, j| matrix[(i, j)]);
    scale.as_slice().to_vec()
}

/// First approximations; `None` where doubles do not do.
pub(super) fn start(scaled: &Scaled, l: &Mat<f64>) -> Option<Columns> {
    let n = scaled.n;
    let z = scaled.zero.len();
    let d = reduced(l, scaled.velocity.mid.doubles());
    let s = reduced(l, scaled.stiffness.mid.doubles());
    let symmetric = Mat::from_fn(n, n, |i, j| 0.5 * (s[(i, j)] + s[(j, i)]));
    let factor = if z == 0 { cholesky(&symmetric, NOISE * n as f64) } else { None };
    let largest = s.norm_max();
    let gamma = if largest > 0.0 { largest.sqrt() } else { 1.0 };
    let definite = factor.is_some();
    let (f1, f2) = match factor {
        Some(f2) => {
            let mut f1 = s.clone();
            solve_lower_triangular_in_place(f2.as_ref(), f1.as_mut(), Par::Seq);
            (f1, f2)
        }
        None => (Mat::from_fn(n, n, |i, j| if i == j { gamma } else { 0.0 }), &s * Scale(1.0 / gamma)),
    };
    let mut a = Mat::<f64>::zeros(2 * n, 2 * n);
    a.submatrix_mut(0, n, n, n).copy_from(&f1);
    a.submatrix_mut(n, 0, n, n).copy_from(-&f2);
    a.submatrix_mut(n, n, n, n).copy_from(-&d);
    if !a.is_all_finite() {
        return None;
    }
    // Columns of the exponent 0: (γ x, 0) and (γ z₁, Z a).
    let kernel = if z > 0 { Some(kernel(scaled, l, &d, &s)?) } else { None };
    let chains = kernel.as_ref().map_or(0, |kernel| kernel.chain.ncols());
    let split = z + chains;
    let mut fixed = Mat::<f64>::zeros(2 * n, split);
    if let Some(kernel) = &kernel {
        fixed.submatrix_mut(0, 0, n, z).copy_from(&kernel.basis * Scale(gamma));
        fixed.submatrix_mut(0, z, n, chains).copy_from(&kernel.chain * Scale(gamma));
        fixed.submatrix_mut(n, z, n, chains).copy_from(&kernel.basis * &kernel.heads);
    }
    let gamma = if definite { None } else { Some(gamma) };
    for attempt in 0..2 {
        if attempt > 0 {
            disturb(&mut a);
        }
        // Vectors that agree to the last digit may end the decomposition itself.
        let Some((mu, vectors)) = rest(&a, &fixed, !definite) else { continue };
        // All columns of first order, and their inverse.
        let entry = |i, j| if j < split { c64::new(fixed[(i, j)], 0.0) } else { vectors[(i, j - split)] };
        let v = Mat::from_fn(2 * n, 2 * n, entry);
        let w = v.partial_piv_lu().inverse();
        let clear = (split..2 * n).all(|j| {
            // Columns have length 1, so that a row is as long as its exponent is ill-conditioned.
            let square: f64 = (0..2 * n).map(|i| w[(j, i)].re * w[(j, i)].re + w[(j, i)].im * w[(j, i)].im).sum();
            (0.5..MOST_CONDITION * MOST_CONDITION).contains(&square)
        });
        if clear || attempt > 0 {
            return assemble(scaled, l, &mu, &v, &w, kernel.as_ref(), gamma);
        }
    }
    None
}

/// Vectors more parallel than this have no use for what follows.
const MOST_CONDITION: f64 = 1e7;

/// Moves exponents that doubles do not tell apart away from each other: entries by some 1e-9 of their rows and
/// columns, in no pattern but always the same.
fn disturb(a: &mut Mat<f64>) {
    let m = a.nrows();
    let mut rows = vec![0.0_f64; m];
    let mut columns = vec![0.0_f64; m];
    for j in 0..m {
        for i in 0..m {
            rows[i] = rows[i].max(a[(i, j)].abs());
            columns[j] = columns[j].max(a[(i, j)].abs());
        }
    }
    let mut state = 1_u64;
    for j in 0..m {
        for i in 0..m {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let share = (state >> 40) as f64 / f64::from(1 << 23) - 1.0;
            a[(i, j)] += share * 1e-9 * (rows[i] * columns[j]).sqrt();
        }
    }
}

/// Exponents and vectors of first order of what is left of A beside the given columns, an invariant
/// subspace of the exponent 0; pairs follow each other, the one above the real axis first.
fn rest(a: &Mat<f64>, fixed: &Mat<f64>, balance: bool) -> Option<(Vec<c64>, Mat<c64>)> {
    let (m, split) = (a.nrows(), fixed.ncols());
    let left = m - split;
    let (q, mut inner) = if split > 0 {
        let q = fixed.qr().compute_Q();
        let inner = q.transpose() * a * &q;
        (Some(q), inner)
    } else {
        (None, a.clone())
    };
    let mut block = inner.submatrix(split, split, left, left).to_owned();
    let scale = if balance { balanced(&mut block) } else { vec![1.0; left] };
    if left == 0 {
        return Some((Vec::new(), Mat::zeros(m, 0)));
    }
    let eigen = block.eigen().ok()?;
    let values: Vec<c64> = (0..left).map(|k| eigen.S()[k]).collect();
    if values.iter().any(|x| !(x.re.is_finite() && x.im.is_finite())) {
        return None;
    }
    // Pairs: each value above the axis, then its conjugate.
    let mut mu = Vec::with_capacity(left);
    let mut vectors = Mat::<c64>::zeros(m, left);
    let above = values.iter().filter(|x| x.im > 0.0).count();
    if above != values.iter().filter(|x| x.im < 0.0).count() {
        return None;
    }
    if split > 0 {
        // Within the split-off space nothing is left of A but its nilpotent part.
        inner.submatrix_mut(split, 0, left, split).fill(0.0);
    }
    for (k, &value) in values.iter().enumerate() {
        if value.im < 0.0 {
            continue;
        }
        let inside: Vec<c64> = (0..left).map(|i| part(eigen.U()[(i, k)] * scale[i], value.im == 0.0)).collect();
        // (T₀ - λ) b = -A₁₂ a with T₀² = 0: b = (A₁₂ a + T₀ A₁₂ a / λ) / λ.
        let mut b: Vec<c64> = (0..split).map(|i| (0..left).map(|j| inside[j] * inner[(i, split + j)]).sum()).collect();
        if split > 0 {
            let by = c64::new(1.0, 0.0) / value;
            let turned: Vec<c64> = (0..split).map(|i| (0..split).map(|j| b[j] * inner[(i, j)]).sum()).collect();
            for (b, t) in b.iter_mut().zip(turned) {
                *b = (*b + t * by) * by;
            }
        }
        let whole: Vec<c64> = match &q {
            Some(q) => {
                let terms = |i: usize| b.iter().chain(&inside).enumerate().map(move |(j, b)| *b * q[(i, j)]);
                (0..m).map(|i| terms(i).sum()).collect()
            }
            None => inside,
        };
        let square: f64 = whole.iter().map(|x| x.re * x.re + x.im * x.im).sum();
        if !(square.is_finite() && square > 0.0) {
            return None;
        }
        let by = 1.0 / square.sqrt();
        for (i, x) in whole.iter().enumerate() {
            vectors[(i, mu.len())] = *x * by;
        }
        mu.push(value);
        if value.im > 0.0 {
            for (i, x) in whole.iter().enumerate() {
                vectors[(i, mu.len())] = c64::new(x.re, -x.im) * by;
            }
            mu.push(c64::new(value.re, -value.im));
        }
    }
    Some((mu, vectors))
}

/// Vectors of second order, in the coordinates of the scaled problem.
fn assemble(
    scaled: &Scaled,
    l: &Mat<f64>,
    rest: &[c64],
    v: &Mat<c64>,
    w: &Mat<c64>,
    kernel: Option<&Kernel>,
    gamma: Option<f64>,
) -> Option<Columns> {
    let n = scaled.n;
    let z = scaled.zero.len();
    let split = 2 * n - rest.len();
    let zero = c64::new(0.0, 0.0);
    let mut mu = vec![zero; split];
    mu.extend_from_slice(rest);
    // Real and imaginary parts beside each other, L⁻ᵀ from the left.
    let mut xs = Mat::<f64>::zeros(n, 4 * n);
    let mut ys = Mat::<f64>::zeros(n, 4 * n);
    for j in 0..2 * n {
        let size = mu[j].re.hypot(mu[j].im);
        for i in 0..n {
            let x = match gamma {
                Some(gamma) if j < split || size <= gamma => v[(i, j)] / gamma,
                _ if size > 0.0 => v[(n + i, j)] / mu[j],
                _ => return None,
            };
            (xs[(i, 2 * j)], xs[(i, 2 * j + 1)]) = (x.re, x.im);
            let y = w[(j, n + i)];
            (ys[(i, 2 * j)], ys[(i, 2 * j + 1)]) = (y.re, y.im);
        }
    }
    solve_upper_triangular_in_place(l.transpose(), xs.as_mut(), Par::Seq);
    solve_upper_triangular_in_place(l.transpose(), ys.as_mut(), Par::Seq);
    let column = |from: &Mat<f64>, j: usize, by: f64, real: bool| -> Vec<Complex> {
        let number = |i: usize| c64::new(from[(i, 2 * j)] * by, from[(i, 2 * j + 1)] * by);
        (0..n).map(|i| Complex::from_c64(part(number(i), real), ())).collect()
    };
    let mut all: Vec<Column<Ball>> = Vec::with_capacity(2 * n);
    let mut conjugate_of = vec![None; 2 * n];
    for j in 0..2 * n {
        if mu[j].im < 0.0 {
            all.push(all[j - 1].conjugate());
            conjugate_of[j] = Some(j - 1);
            continue;
        }
        let (x, y) = if j < z {
            let given = scaled.zero[j].iter();
            (given.map(|value| Complex::new(*value, Ball::ZERO)).collect(), column(&ys, j, 1.0, true))
        } else if j < split {
            (column(&xs, j, LINK, true), column(&ys, j, 1.0 / LINK, true))
        } else {
            // |x|² about 1 / |μ|: then exponents of all sizes are judged alike.
            let parts = (0..2).flat_map(|part| (0..n).map(move |i| (part, i)));
            let square: f64 = parts.map(|(part, i)| xs[(i, 2 * j + part)] * xs[(i, 2 * j + part)]).sum();
            let size = mu[j].re.hypot(mu[j].im).max(1e-30);
            let by = 1.0 / (square * size).sqrt();
            if !(by.is_finite() && by > 0.0) {
                return None;
            }
            let real = mu[j].im == 0.0;
            (column(&xs, j, by, real), column(&ys, j, 1.0 / by, real))
        };
        all.push(Column { mu: Complex::from_c64(mu[j], ()), x, y });
    }
    let places = (0..split - z).flat_map(|to| (0..z).map(move |from| (from, to)));
    let link = |(from, to)| Some(Link { from, to: z + to, value: kernel?.heads[(from, to)] * LINK });
    let links = places.filter_map(link).filter(|link| link.value != 0.0).collect();
    let columns = Columns { all, conjugate_of, zeros: z, chains: split - z, links, ..Columns::default() };
    columns.all.iter().all(Column::is_finite).then_some(columns)
}
