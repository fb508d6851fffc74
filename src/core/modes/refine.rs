//! One step towards exact eigenvectors: X <- X (1 + W) V.
//!
//! From S = XᵀKX = Λ + E and G = XᵀMX = 1 + F, to first order in E and F (Ogita, Aishima, "Iterative
//! refinement for symmetric eigenvalue decomposition", Japan J. Ind. Appl. Math. 35 (2018), for
//! pencils): w_ij = (s_ij - μ_j g_ij) / (μ_j - μ_i) between separated columns, and -f_ij / 2 between
//! columns too close for that, and on the diagonal. Columns that are too close, for how far they are still mixed, form clusters; each is
//! then rotated by the eigenvectors V of its own small block (Jacobi's method, which resolves graded
//! blocks; "Part II: clustered eigenvalues", ibid. 36 (2019)). The error is squared.
//!
//! The result is approximate, as X itself is: the certificate is computed anew.

use std::borrow::Cow;

use super::dense::{Matrix, Plain, add_to, multiply};
use super::pencil::{Pencil, ZeroSpace, rayleigh};
use super::product::{Part, product};
use super::quick::{Quick, Round};
use crate::groups::Groups;
use crate::precision::DoubleDouble;

/// Corrections above this are not small: the two columns form a cluster.
pub(super) const SMALL: f64 = 0.03;

/// Neighbours nearer than this, relative to their eigenvalues, form a cluster much earlier: a
/// correction w leaves X off orthonormal by w², and what follows from that in the next step, w⁴, has
/// to vanish beside their splitting.
pub(super) const NEAR: f64 = 1e-6;

/// What counts as small between near neighbours: w² is below the rounding of doubles.
pub(super) const TINY: f64 = 1e-8;

/// A nearly diagonal pencil, in doubles: what the columns of X are to one another.
pub(super) trait Mixed {
    /// μ_i, about s_ii / g_ii, of all columns.
    fn quotients(&self) -> &[DoubleDouble];
    /// About s_ij - μ_j g_ij.
    fn coupling(&self, i: usize, j: usize) -> f64;
    /// The same for all columns.
    fn couplings(&self) -> Cow<'_, Plain> {
        let m = self.quotients().len();
        Cow::Owned(Plain::from_fn(m, m, |i, j| self.coupling(i, j)))
    }
    /// About g_ij.
    fn overlap(&self, i: usize, j: usize) -> f64;
    /// About g_ii - 1.
    fn excess(&self, i: usize) -> f64;
    /// What the couplings of i and j are uncertain by.
    fn noise(&self, i: usize, j: usize) -> f64;
}

/// A pencil with its quotients.
struct Measured<'a> {
    pencil: &'a Pencil,
    quotient: Vec<DoubleDouble>,
}

impl Mixed for Measured<'_> {
    fn quotients(&self) -> &[DoubleDouble] {
        &self.quotient
    }

    fn coupling(&self, i: usize, j: usize) -> f64 {
        let (s, g) = (self.pencil.s.mid.get(i, j), self.pencil.g.mid.get(i, j));
        (s - self.quotient[j] * g).hi
    }

    fn overlap(&self, i: usize, j: usize) -> f64 {
        self.pencil.g.mid.get(i, j).hi
    }

    fn excess(&self, i: usize) -> f64 {
        (self.pencil.g.mid.get(i, i) - DoubleDouble::ONE).hi
    }

    fn noise(&self, i: usize, j: usize) -> f64 {
        let size = self.quotient[i].hi.abs().max(self.quotient[j].hi.abs());
        self.pencil.s.radius.get(i, j) + size * self.pencil.g.radius.get(i, j)
    }
}

pub(super) fn refine(pencil: &Pencil, zero: &ZeroSpace, x: &Matrix) -> Matrix {
    let m = x.columns;
    let measured = Measured { pencil, quotient: (0..m).map(|i| rayleigh(pencil, i).0).collect() };
    let step = Step::new(&measured);
    let mut x_new = product(x, &step.correction.widened(), Part::All);
    x_new.add_assign(x);
    // What is left of the zero vectors: X - Z (ZᵀMX).
    if zero.mid.columns > 0 {
        let along = product(&zero.mid, &pencil.overlap, Part::All);
        x_new = Matrix::from_fn(x.rows, m, |i, j| x_new.get(i, j) - along.get(i, j));
    }
    for (cluster, rotation) in &step.rotations {
        let rotated = product(&x_new.gather(cluster), &rotation.widened(), Part::All);
        x_new.scatter(cluster, &rotated);
    }
    x_new
}

/// The same for columns that lie in rows. The correction is computed in doubles: what it is off by
/// is as small beside it as it is beside X.
pub(super) fn refine_rows(quick: &Quick<'_>, round: &Round, step: &Step) -> Matrix {
    let mut new = round.xt.clone();
    let mut change = multiply(step.correction.view().transpose(), new.hi.view());
    if round.overlap.columns > 0 {
        // Z (ZᵀMX), transposed.
        let along = product(&round.overlap, &quick.zero.mid.transposed(), Part::All);
        for (x, part) in change.data.iter_mut().zip(&along.hi.data) {
            *x -= part;
        }
    }
    add_to(&mut new, &change);
    if step.rotations.is_empty() {
        return new;
    }
    let mut columns = new.transposed();
    for (cluster, rotation) in &step.rotations {
        let rotated = product(&columns.gather(cluster), &rotation.widened(), Part::All);
        columns.scatter(cluster, &rotated);
    }
    columns.transposed()
}

/// W, and the clusters with their V.
pub(super) struct Step {
    correction: Plain,
    rotations: Vec<(Vec<usize>, Plain)>,
}

impl Step {
    pub(super) fn new(mixed: &impl Mixed) -> Self {
        let quotient = mixed.quotients();
        let m = quotient.len();
        let upper = mixed.couplings();
        let lower = upper.transposed();
        let mut together = Groups::new(m);
        let mut w = Plain::zeros(m, m);
        for j in 0..m {
            let nu = quotient[j];
            let to = w.column_mut(j).iter_mut().zip(quotient);
            let couplings = upper.column(j).iter().zip(lower.column(j));
            for ((w, mu), (&own, &other)) in to.zip(couplings) {
                let gap = (nu.hi - mu.hi) + (nu.lo - mu.lo);
                let size = mu.hi.abs().max(nu.hi.abs());
                let coupling = own.abs().max(other.abs());
                let near = gap.abs() < NEAR * size;
                let small = if near { TINY } else { SMALL };
                // Where a correction to first order will do.
                let separated = coupling > 0.0 && coupling <= small * gap.abs();
                *w = if separated { own / gap } else { f64::NAN };
            }
        }
        for j in 0..m {
            w.set(j, j, -0.5 * mixed.excess(j));
            for i in 0..j {
                if !w.get(i, j).is_nan() {
                    continue;
                }
                w.set_both(i, j, -0.5 * mixed.overlap(i, j));
                let coupling = upper.get(i, j).abs().max(lower.get(i, j).abs());
                if coupling > mixed.noise(i, j) {
                    together.join(i, j);
                }
            }
        }
        let clusters: Vec<Vec<usize>> = together.all().into_iter().filter(|cluster| cluster.len() > 1).collect();
        // What a rotation is going to mend must not be mended here too.
        for cluster in &clusters {
            for (q, &j) in cluster.iter().enumerate() {
                for &i in &cluster[..q] {
                    w.set_both(i, j, -0.5 * mixed.overlap(i, j));
                }
            }
        }
        let rotation = |cluster: Vec<usize>| {
            let block = block(
                cluster.len(),
                |p| quotient[cluster[p]].hi,
                |p, q| (quotient[cluster[p]] - quotient[cluster[q]]).hi,
                |p, q| mixed.coupling(cluster[p], cluster[q]),
            );
            (cluster, jacobi(block))
        };
        Self { correction: w, rotations: clusters.into_iter().map(rotation).collect() }
    }
}

/// The block of S - (G - 1) Λ, symmetrised, that belongs to a cluster of so many columns: from their quotients, the differences
/// of these, and s_ij - μ_j g_ij.
pub(super) fn block(
    count: usize,
    quotient: impl Fn(usize) -> f64,
    difference: impl Fn(usize, usize) -> f64,
    coupling: impl Fn(usize, usize) -> f64,
) -> Plain {
    let low = (1..count).fold(0, |low, p| if difference(p, low) < 0.0 { p } else { low });
    let high = (1..count).fold(0, |high, p| if difference(p, high) > 0.0 { p } else { high });
    // A narrow cluster is measured from its centre, so that small splittings keep their digits; a
    // wide one from zero, so that small eigenvalues keep theirs.
    let narrow = difference(high, low) < 1e-3 * quotient(high).abs().max(quotient(low).abs());
    Plain::from_fn(count, count, |p, q| {
        if p != q {
            // With the mean of both quotients in place of either.
            0.5 * (coupling(p, q) + coupling(q, p))
        } else if narrow {
            0.5 * (difference(p, low) + difference(p, high))
        } else {
            quotient(p)
        }
    })
}

/// Eigenvectors of a symmetric matrix by cyclic Jacobi rotations (Golub, Van Loan, 8.5). An entry
/// counts as zero relative to its own two diagonal entries (Demmel, Veselic, "Jacobi's method is
/// more accurate than QR", SIAM J. Matrix Anal. 13 (1992)).
pub(super) fn jacobi(mut a: Plain) -> Plain {
    let n = a.rows;
    let mut v = Plain::from_fn(n, n, |i, j| if i == j { 1.0 } else { 0.0 });
    for _ in 0..40 {
        let mut rotated = false;
        for q in 1..n {
            for p in 0..q {
                let (app, aqq, apq) = (a.get(p, p), a.get(q, q), a.get(p, q));
                if apq == 0.0 || apq.abs() <= 1e-17 * (app.abs() * aqq.abs()).sqrt() {
                    continue;
                }
                rotated = true;
                let theta = (aqq - app) / (2.0 * apq);
                let t = if theta.is_finite() { theta.signum() / (theta.abs() + theta.hypot(1.0)) } else { 0.0 };
                if t == 0.0 {
                    a.set_both(p, q, 0.0);
                    continue;
                }
                let cos = 1.0 / t.hypot(1.0);
                let sin = t * cos;
                rotate_columns(&mut a, p, q, cos, sin);
                // Rows by symmetry.
                for k in 0..n {
                    if k != p && k != q {
                        a.set(p, k, a.get(k, p));
                        a.set(q, k, a.get(k, q));
                    }
                }
                a.set(p, p, app - t * apq);
                a.set(q, q, aqq + t * apq);
                a.set_both(p, q, 0.0);
                rotate_columns(&mut v, p, q, cos, sin);
            }
        }
        if !rotated {
            break;
        }
    }
    v
}

fn rotate_columns(a: &mut Plain, p: usize, q: usize, cos: f64, sin: f64) {
    for k in 0..a.rows {
        let (x, y) = (a.get(k, p), a.get(k, q));
        a.set(k, p, cos * x - sin * y);
        a.set(k, q, sin * x + cos * y);
    }
}
