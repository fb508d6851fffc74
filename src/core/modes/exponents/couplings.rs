//! How the columns of a nearly diagonal quadratic pencil are coupled: magnitudes and bounds in doubles.
//!
//! With L(λ) = λ²M + λD + S, the first-order pencil A - λB = [[0, 1], [-S, -D]] - λ diag(1, M), and matrices
//! V = [X; XT], W = [TYᵀM + YᵀD, Yᵀ] for a matrix T of the order 2n,
//!
//! ```text
//!   WBV = (TYᵀ)(MX) + Yᵀ(DX + MXT) = Q,    W(AV - BVT) = -YᵀR,    R = MXT² + DXT + SX,
//! ```
//!
//! as multiplying out shows. So W(A - σB)V = H(σ) = Q (T - σ) - YᵀR; likewise from the left
//! H(σ) = (T - σ) Q - EᵀX with Eᵀ = T²YᵀM + TYᵀD + YᵀS. T is diagonal, its entries μ, but for the links of Jordan
//! chains of the exponent 0. For i ≠ j and without links
//!
//! ```text
//!   H_ij(σ) = -y_iᵀR_j + (μ_j - σ) Q_ij = -E_iᵀx_j + (μ_i - σ) Q_ij,
//! ```
//!
//! where R_j = L(μ_j) x_j and E_i = L(μ_i)ᵀ y_i are residuals. W never has to be known: M and D in it are the
//! exact matrices. Only residuals have to be computed with care; products with them are bounded in
//! doubles.

use faer::{Mat, c64};

use super::super::dense::{Plain, gamma, multiply};
use super::super::product::bound_product;
use crate::precision::up;

/// A complex number in doubles and a bound of its error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Approximate {
    pub(super) value: c64,
    pub(super) error: f64,
}

impl Approximate {
    pub(super) fn conjugate(self) -> Self {
        Self { value: self.value.conj(), error: self.error }
    }
}

/// What a column contributes.
#[derive(Clone, Debug)]
pub(super) struct Residuals {
    pub(super) x: Vec<Approximate>,
    pub(super) y: Vec<Approximate>,
    /// The residual R_j and the one from the left, E_j.
    pub(super) residual: Vec<Approximate>,
    pub(super) left: Vec<Approximate>,
    /// M x_j, and D x_j + M (XT)_j.
    pub(super) image: Vec<Approximate>,
    pub(super) rest: Vec<Approximate>,
    /// (TYᵀ)_j.
    pub(super) turned: Vec<Approximate>,
    /// A bound of |y_jᵀR_j|.
    pub(super) defect: f64,
}

impl Residuals {
    pub(super) fn conjugate(&self) -> Self {
        let conjugate = |x: &[Approximate]| x.iter().map(|x| x.conjugate()).collect();
        Self {
            x: conjugate(&self.x),
            y: conjugate(&self.y),
            residual: conjugate(&self.residual),
            left: conjugate(&self.left),
            image: conjugate(&self.image),
            rest: conjugate(&self.rest),
            turned: conjugate(&self.turned),
            defect: self.defect,
        }
    }
}

/// Entry (k, j) of T beside its diagonal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) value: f64,
}

/// Bounds of the pencil's entries, 2n by 2n, and the entries themselves as nearly as doubles have them.
pub(super) struct Couplings {
    pub(super) size: usize,
    /// Upper bounds of |H_ij(μ_j)| off the diagonal, 0 on it.
    pub(super) right: Plain,
    /// Upper bounds of |H_ij(μ_i)| off the diagonal, transposed: entry (j, i).
    pub(super) left_t: Plain,
    /// Upper bounds of |Q_ij| off the diagonal, 0 on it; and the transpose.
    pub(super) q: Plain,
    pub(super) q_t: Plain,
    /// Upper bounds of |H_jj(μ_j)|.
    pub(super) defect: Vec<f64>,
    /// Bounds of |Q_jj| from below.
    pub(super) least: Vec<f64>,
    /// |μ_i - μ_j|, within a factor 1 ± 1e-12.
    pub(super) distance: Plain,
    /// y_iᵀR_j, E_iᵀx_j and Q_ij, without bounds.
    pub(super) residuals: Mat<c64>,
    pub(super) lefts: Mat<c64>,
    pub(super) unit: Mat<c64>,
}

/// Columns of complex numbers, real and imaginary parts beside each other, and their moduli and errors.
struct Bundle {
    parts: Plain,
    /// Bounds of the moduli, errors included.
    moduli: Plain,
    errors: Plain,
}

impl Bundle {
    fn new<'a>(n: usize, measured: &'a [Residuals], part: impl Fn(&'a Residuals) -> &'a [Approximate]) -> Self {
        let m = measured.len();
        let mut parts = Plain::zeros(n, 2 * m);
        let (mut moduli, mut errors) = (Plain::zeros(n, m), Plain::zeros(n, m));
        for (j, own) in measured.iter().enumerate() {
            for (i, x) in part(own).iter().enumerate() {
                parts.set(i, 2 * j, x.value.re);
                parts.set(i, 2 * j + 1, x.value.im);
                // hypot is off by less than a unit of the last place.
                moduli.set(i, j, up(x.value.norm() + x.error));
                errors.set(i, j, x.error);
            }
        }
        Self { parts, moduli, errors }
    }
}

/// a_iᵀb_j for all i and j, and a bound of the error of each.
///
/// Real and imaginary parts are four real products of n terms, each off by at most γ_n Σ|a'||b'| (see
/// [`gamma`]), and (|a'| + |a''|)(|b'| + |b''|) <= 2 |a||b|: with the two sums the modulus is off by at most
/// 2 γ_{n+2} Σ|a||b|. The data are off by da and db: |a db| + |da b| + |da db| more, which the moduli, errors
/// included, cover as |a| db + da |b|.
fn inner(a: &Bundle, b: &Bundle) -> (Mat<c64>, Plain) {
    let products = multiply(a.parts.view().transpose(), b.parts.view());
    let rounding = 2.0 * gamma(a.parts.rows + 2);
    let mut weights = b.errors.clone();
    for (e, size) in weights.data.iter_mut().zip(&b.moduli.data) {
        *e = up(*e + rounding * size);
    }
    let mut bound = bound_product(&a.moduli.transposed(), &weights);
    let exact = a.errors.data.iter().all(|e| *e == 0.0);
    if !exact {
        let more = bound_product(&a.errors.transposed(), &b.moduli);
        for (x, y) in bound.data.iter_mut().zip(&more.data) {
            *x = up(*x + y);
        }
    }
    let part = |i: usize, j: usize| products.get(i, j);
    let entry = |i: usize, j: usize| {
        let (i, j) = (2 * i, 2 * j);
        c64::new(part(i, j) - part(i + 1, j + 1), part(i, j + 1) + part(i + 1, j))
    };
    (Mat::from_fn(a.moduli.columns, b.moduli.columns, entry), bound)
}

impl Couplings {
    /// From all columns; `distance(i, j)` is |μ_i - μ_j|, `known` are entries of Q that are known better than
    /// from doubles: columns that are nearly parallel have long left vectors.
    pub(super) fn new(
        n: usize,
        measured: &[Residuals],
        links: &[Link],
        known: &[(usize, usize, Approximate)],
        distance: impl Fn(usize, usize) -> f64,
    ) -> Option<Self> {
        let m = measured.len();
        let x = Bundle::new(n, measured, |own| &own.x);
        let y = Bundle::new(n, measured, |own| &own.y);
        let (residuals, residuals_error) = inner(&y, &Bundle::new(n, measured, |own| &own.residual));
        let (lefts, lefts_error) = inner(&Bundle::new(n, measured, |own| &own.left), &x);
        let turned = Bundle::new(n, measured, |own| &own.turned);
        let (first, mut first_error) = inner(&turned, &Bundle::new(n, measured, |own| &own.image));
        let (second, mut second_error) = inner(&y, &Bundle::new(n, measured, |own| &own.rest));
        let mut unit = first + second;
        for &(i, j, entry) in known {
            unit[(i, j)] = entry.value;
            first_error.set(i, j, entry.error);
            second_error.set(i, j, 0.0);
        }
        let square = || Plain::zeros(m, m);
        let (mut right, mut left_t, mut q, mut q_t) = (square(), square(), square(), square());
        let (mut defect, mut least) = (Vec::with_capacity(m), Vec::with_capacity(m));
        for (j, own) in measured.iter().enumerate() {
            for i in 0..m {
                let (a, b) = (first_error.get(i, j), second_error.get(i, j));
                let entry = unit[(i, j)];
                // The sum of the two is rounded by at most 2 u of its parts, which γ covers twice.
                let error = up(2.0 * (a + b));
                if i == j {
                    defect.push(own.defect);
                    least.push((entry.norm() * (1.0 - 1e-15) - error).max(0.0));
                    continue;
                }
                let size = up(entry.norm() + error);
                q.set(i, j, size);
                q_t.set(j, i, size);
                right.set(i, j, up(residuals[(i, j)].norm() + residuals_error.get(i, j)));
                left_t.set(j, i, up(lefts[(i, j)].norm() + lefts_error.get(i, j)));
            }
        }
        // What links add: Σ_k Q_ik T_kj from the right, Σ_k T_ik Q_kj from the left.
        let sizes = |i: usize, j: usize| {
            if i == j {
                up(unit[(i, i)].norm() + 2.0 * (first_error.get(i, i) + second_error.get(i, i)))
            } else {
                q.get(i, j)
            }
        };
        for link in links {
            let size = link.value.abs();
            for (i, defect) in defect.iter_mut().enumerate() {
                let from_right = (&mut right, link.to, sizes(i, link.from));
                for (matrix, column, share) in [from_right, (&mut left_t, link.from, sizes(link.to, i))] {
                    let more = share * size;
                    if i == column {
                        *defect = up(*defect + more);
                    } else {
                        matrix.set(i, column, up(matrix.get(i, column) + more));
                    }
                }
            }
        }
        let mut distances = square();
        for j in 0..m {
            for i in 0..j {
                distances.set_both(i, j, distance(i, j));
            }
        }
        let finite = |plain: &Plain| plain.data.iter().all(|x| x.is_finite());
        let diagonal = defect.iter().chain(&least).all(|x| x.is_finite());
        (diagonal && finite(&right) && finite(&left_t) && finite(&q) && finite(&distances)).then_some(Self {
            size: m,
            right,
            left_t,
            q,
            q_t,
            defect,
            least,
            distance: distances,
            residuals,
            lefts,
            unit,
        })
    }
}
