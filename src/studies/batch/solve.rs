//! K x = ω² M x for eight parameter sets at once, in doubles.
//!
//! 1. M = L Lᵀ (Cholesky) and W = L⁻¹.
//! 2. A = W K Wᵀ, the ordinary symmetric problem.
//! 3. Cyclic Jacobi rotations J until A is diagonal in all sets (G. H. Golub and C. F. Van Loan,
//!    Matrix Computations, 4th ed., §8.5); W becomes JᵀW on the way, so that its rows end as the
//!    M-normalised eigenvectors.
//!
//! Which rotation is made is decided set by set: where an entry is negligible, the rotation is by
//! the angle 0 and changes nothing. So a set's numbers don't depend on its neighbours. From
//! [`LARGEST_JACOBI`] coordinates on every set's A is decomposed by itself.

use nalgebra::{DMatrix, SymmetricEigen};

use librate_core::precision::{LANES, Lane};

/// Up to here the rotations of eight sets together are faster than eight decompositions
/// (`benches/batch.rs`).
pub(super) const LARGEST_JACOBI: usize = 40;
/// Sweeps end long before: convergence is quadratic, and up to 40 coordinates take ten at most.
const MOST_SWEEPS: usize = 40;
/// An entry is negligible where it is below u·sqrt(|a_pp a_qq|): it moves no eigenvalue by more
/// than rounding does, however small that is beside the others (J. Demmel and K. Veselić, SIAM J.
/// Matrix Anal. Appl. 13 (1992) 1204).
const NEGLIGIBLE: f64 = f64::EPSILON * f64::EPSILON / 4.0;
/// Squares below are at the end of the range; the largest entry is between 1 and 2.
const NOTHING: f64 = 1e-290;

/// The matrices of a block and what becomes of them. All are n by n, row by row.
pub(super) struct Solver {
    pub(super) n: usize,
    /// M; symmetric.
    pub(super) mass: Vec<Lane>,
    /// K; symmetric where the model is conservative.
    pub(super) stiffness: Vec<Lane>,
    /// Row i is the M-normalised eigenvector of eigenvalue i.
    pub(super) vectors: Vec<Lane>,
    /// The eigenvalues, in no order.
    pub(super) values: Vec<Lane>,
    /// 1 where M has a Cholesky decomposition, else 0.
    pub(super) positive: Lane,
    /// 1 where the rotations came to an end, else 0.
    pub(super) converged: Lane,
    /// A, then scratch; of A the upper triangle.
    pub(super) reduced: Vec<Lane>,
    pub(super) scratch: Vec<Lane>,
}

impl Solver {
    pub(super) fn new(n: usize) -> Self {
        let square = vec![Lane::ZERO; n * n];
        Self {
            n,
            mass: square.clone(),
            stiffness: square.clone(),
            vectors: square.clone(),
            values: vec![Lane::ZERO; n],
            positive: Lane::ZERO,
            converged: Lane::ZERO,
            reduced: square.clone(),
            scratch: square,
        }
    }

    /// Solves the block.
    #[inline(always)]
    pub(super) fn solve(&mut self) {
        self.factor();
        self.reduce();
        let power = self.scale();
        if self.n <= LARGEST_JACOBI {
            self.rotate(power);
        } else {
            self.decompose(power);
        }
    }

    /// The root of a pivot; 1, and the set is noted, where there is none.
    #[inline(always)]
    fn pivot(&mut self, pivot: Lane) -> Lane {
        let good = pivot.above(Lane::ZERO);
        self.positive = self.positive * good;
        pivot.choose(good, Lane::ONE).sqrt()
    }

    /// L, then W = L⁻¹ in its place, in `vectors`.
    #[inline(always)]
    pub(super) fn factor(&mut self) {
        let n = self.n;
        self.positive = Lane::ONE;
        self.vectors.fill(Lane::ZERO);
        for i in 0..n {
            for j in 0..=i {
                let mut sum = self.mass[i * n + j];
                for k in 0..j {
                    sum -= self.vectors[i * n + k] * self.vectors[j * n + k];
                }
                self.vectors[i * n + j] = if i == j {
                    self.pivot(sum)
                } else {
                    // The diagonal of finished rows holds 1/l_jj below.
                    sum * self.scratch[j]
                };
            }
            self.scratch[i] = Lane::ONE / self.vectors[i * n + i];
        }
        // Row i of W needs row i of L and the rows of W before it; from left to right nothing is
        // overwritten too early.
        for i in 0..n {
            let inverse = self.scratch[i];
            for j in 0..i {
                let mut sum = Lane::ZERO;
                for k in j..i {
                    sum += self.vectors[i * n + k] * self.vectors[k * n + j];
                }
                self.vectors[i * n + j] = -(inverse * sum);
            }
            self.vectors[i * n + i] = inverse;
        }
    }

    /// The upper triangle of A = W K Wᵀ.
    #[inline(always)]
    fn reduce(&mut self) {
        conjugate((&self.vectors, &self.stiffness), true, &mut self.scratch[..self.n], &mut self.reduced);
    }

    /// Divides A by a power of two a set, which it gives, so that its largest entry is between 1 and 2.
    #[inline(always)]
    fn scale(&mut self) -> Lane {
        let n = self.n;
        let mut largest = Lane::ZERO;
        for i in 0..n {
            for j in i..n {
                largest = self.reduced[i * n + j].abs().max(largest);
            }
        }
        let power = largest.map(|x| {
            // The exponent alone; what is zero, subnormal or no number stays as it is.
            let bits = x.to_bits() & 0x7ff0_0000_0000_0000;
            if (0x0020_0000_0000_0000..0x7fd0_0000_0000_0000).contains(&bits) { f64::from_bits(bits) } else { 1.0 }
        });
        let inverse = Lane::ONE / power;
        for i in 0..n {
            for j in i..n {
                self.reduced[i * n + j] = self.reduced[i * n + j] * inverse;
            }
        }
        power
    }

    #[inline(always)]
    fn rotate(&mut self, power: Lane) {
        let n = self.n;
        let a = &mut self.reduced[..n * n];
        let x = &mut self.vectors[..n * n];
        let mut moved = Lane::ONE;
        for _ in 0..MOST_SWEEPS {
            moved = Lane::ZERO;
            for p in 0..n {
                for q in p + 1..n {
                    let (app, aqq, apq) = (a[p * n + p], a[q * n + q], a[p * n + q]);
                    let limit = (app * aqq).abs() * Lane::splat(NEGLIGIBLE) + Lane::splat(NOTHING);
                    let matters = (apq * apq).above(limit);
                    if !matters.any() {
                        continue;
                    }
                    moved = moved.max(matters);
                    let (tangent, c) = rotation(app, aqq, apq);
                    let tangent = tangent.choose(matters, Lane::ZERO);
                    let c = c.choose(matters, Lane::ONE);
                    let s = tangent * c;
                    a[p * n + p] = app - tangent * apq;
                    a[q * n + q] = aqq + tangent * apq;
                    a[p * n + q] = Lane::ZERO.choose(matters, apq);
                    turn_column(a, n, (p, q), 0..p, (c, s));
                    for r in p + 1..q {
                        let (g, h) = (a[p * n + r], a[r * n + q]);
                        a[p * n + r] = c * g - s * h;
                        a[r * n + q] = s * g + c * h;
                    }
                    turn_rows(a, n, (p, q), q + 1, (c, s));
                    turn_rows(x, n, (p, q), 0, (c, s));
                }
            }
            if !moved.any() {
                break;
            }
        }
        self.converged = Lane::ONE - moved;
        for i in 0..n {
            self.values[i] = self.reduced[i * n + i] * power;
        }
    }

    /// For a K that need not be symmetric, M-orthonormal vectors v_i with (K v_i)ᵀ M⁻¹ K v_j = 0 beside the diagonal,
    /// and for values the numbers on it; `tests` gets M⁻¹ K v_i row by row. Rotations of the columns of W K Wᵀ (M. R.
    /// Hestenes, J. SIAM 6 (1958) 51).
    pub(super) fn split(&mut self, tests: &mut [Lane]) {
        let n = self.n;
        self.factor();
        self.reduced.copy_from_slice(&self.vectors);
        let w = &self.reduced;
        let sum = |terms: std::ops::Range<usize>, term: &dyn Fn(usize) -> Lane| {
            terms.fold(Lane::ZERO, |sum, at| sum + term(at))
        };
        for (row, test) in tests.chunks_exact_mut(n).enumerate() {
            for a in 0..n {
                self.scratch[a] = sum(0..row + 1, &|b| self.stiffness[a * n + b] * w[row * n + b]);
            }
            for (c, test) in test.iter_mut().enumerate() {
                *test = sum(0..c + 1, &|a| w[c * n + a] * self.scratch[a]);
            }
        }
        for _ in 0..MOST_SWEEPS {
            let mut moved = Lane::ZERO;
            for p in 0..n {
                for q in p + 1..n {
                    let [app, aqq, apq] =
                        [(p, p), (q, q), (p, q)].map(|(i, j)| sum(0..n, &|a| tests[i * n + a] * tests[j * n + a]));
                    let matters = (apq * apq).above(app * aqq * Lane::splat(NEGLIGIBLE) + Lane::splat(NOTHING));
                    moved = moved.max(matters);
                    let (tangent, c) = rotation(app, aqq, apq);
                    let c = c.choose(matters, Lane::ONE);
                    let s = tangent.choose(matters, Lane::ZERO) * c;
                    turn_rows(tests, n, (p, q), 0, (c, s));
                    turn_rows(&mut self.vectors, n, (p, q), 0, (c, s));
                }
            }
            if !moved.any() {
                break;
            }
        }
        for (value, test) in self.values.iter_mut().zip(tests.chunks_exact_mut(n)) {
            *value = sum(0..n, &|a| test[a] * test[a]);
            for a in 0..n {
                test[a] = sum(a..n, &|c| w[c * n + a] * test[c]);
            }
        }
    }

    /// Each set by itself; the eigenvectors of A are then put together with W.
    #[inline(never)]
    fn decompose(&mut self, power: Lane) {
        let n = self.n;
        self.converged = Lane::ZERO;
        for lane in 0..LANES {
            let a = DMatrix::from_fn(n, n, |i, j| self.reduced[i.min(j) * n + i.max(j)].0[lane]);
            if !a.iter().all(|entry| entry.is_finite()) {
                // Nothing to be solved; said elsewhere.
                self.converged.0[lane] = 1.0;
                continue;
            }
            let Some(eigen) = SymmetricEigen::try_new(a, f64::EPSILON, 100 * n) else { continue };
            self.converged.0[lane] = 1.0;
            for i in 0..n {
                self.values[i].0[lane] = eigen.eigenvalues[i] * power.0[lane];
                for j in 0..n {
                    self.scratch[i * n + j].0[lane] = eigen.eigenvectors[(j, i)];
                }
            }
        }
        for i in 0..n {
            for b in 0..n {
                let mut sum = Lane::ZERO;
                for a in b..n {
                    sum += self.scratch[i * n + a] * self.vectors[a * n + b];
                }
                self.reduced[i * n + b] = sum;
            }
        }
        std::mem::swap(&mut self.vectors, &mut self.reduced);
    }
}

/// W F Wᵀ of a lower triangular W, of a symmetric F the upper triangle alone; `row` has room for a row.
#[inline(always)]
pub(super) fn conjugate((w, f): (&[Lane], &[Lane]), is_symmetric: bool, row: &mut [Lane], to: &mut [Lane]) {
    let n = row.len();
    for i in 0..n {
        for (b, entry) in row.iter_mut().enumerate() {
            let mut sum = Lane::ZERO;
            for a in 0..=i {
                sum += w[i * n + a] * f[a * n + b];
            }
            *entry = sum;
        }
        for j in if is_symmetric { i } else { 0 }..n {
            let mut sum = Lane::ZERO;
            for b in 0..=j {
                sum += row[b] * w[j * n + b];
            }
            to[i * n + j] = sum;
        }
    }
}

/// The tangent and the cosine that make a_pq 0: the smaller root of t² + 2 t d/a_pq - 1 = 0 with d = (a_qq - a_pp)/2.
#[inline(always)]
fn rotation(app: Lane, aqq: Lane, apq: Lane) -> (Lane, Lane) {
    let d = (aqq - app) * Lane::splat(0.5);
    let length = d.abs() + (d * d + apq * apq).sqrt();
    let tangent = apq / length;
    let tangent = tangent.zip(d, |t, d| if d < 0.0 { -t } else { t });
    (tangent, Lane::ONE / (Lane::ONE + tangent * tangent).sqrt())
}

/// Rows p and q from a column on become c·p - s·q and s·p + c·q.
#[inline(always)]
fn turn_rows(a: &mut [Lane], n: usize, (p, q): (usize, usize), from: usize, (c, s): (Lane, Lane)) {
    let (upper, lower) = a.split_at_mut(q * n);
    let rows = upper[p * n + from..(p + 1) * n].iter_mut();
    for (g, h) in rows.zip(&mut lower[from..n]) {
        let (old_g, old_h) = (*g, *h);
        *g = c * old_g - s * old_h;
        *h = s * old_g + c * old_h;
    }
}

/// The same for columns p and q of some rows.
#[inline(always)]
fn turn_column(a: &mut [Lane], n: usize, (p, q): (usize, usize), rows: std::ops::Range<usize>, (c, s): (Lane, Lane)) {
    for r in rows {
        let (g, h) = (a[r * n + p], a[r * n + q]);
        a[r * n + p] = c * g - s * h;
        a[r * n + q] = s * g + c * h;
    }
}
