//! Eigenpairs next to a shift by block Lanczos steps with (K - σ M)⁻¹ M, every vector orthogonal to all others.
//!
//! The basis V has VᵀMV = 1, and T = VᵀM (K - σ M)⁻¹ M V is known column by column for those vectors that the operator was
//! applied to, so that the basis may be cut down to its best vectors at any time (K. Wu, H. Simon, "Thick-restart Lanczos method for large
//! symmetric eigenvalue problems", SIAM J. Matrix Anal. Appl. 22 (2000) 602) and vectors that are known already are kept out. Blocks find
//! repeated eigenvalues as often as they are wide; what is missing is found by whoever counts. Nothing is proved here.

use crate::order::Order;
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::SelfAdjointEigen;
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};

use super::shifted::{Factor, Pencil};

/// Vectors that the operator is applied to at once.
const BLOCK: usize = 4;
/// A vector is found when what the operator leaves over is this part of its eigenvalue.
const FOUND: f64 = 1e-11;
/// Basis vectors beyond those wanted, before the basis is cut down.
const ROOM: usize = 48;
/// Most blocks that are applied.
const MOST_BLOCKS: usize = 400;

/// Vectors and their eigenvalues.
pub(super) struct Found {
    /// n entries a vector, one after the other.
    pub(super) vectors: Vec<f64>,
    pub(super) values: Vec<f64>,
    /// An estimate of the next eigenvalue, in the same order; infinite where there are no more.
    pub(super) next: f64,
}

fn columns(vectors: &[f64], n: usize) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(vectors, n, vectors.len() / n.max(1))
}

/// The eigenvectors whose eigenvalues are next to the shift of a factor: those above it (`above`), by rising value, or on both sides, by distance.
/// `None` where they are not found. Vectors that are `known`, with xᵀMx = 1 and orthogonal to each other, are kept out.
pub(super) fn lanczos(factor: &Factor<'_>, known: &[f64], wanted: usize, above: bool) -> Option<Found> {
    let pencil = factor.pencil;
    let n = pencil.dimension();
    let free = n - known.len() / n.max(1);
    let wanted = wanted.min(free);
    let most = (2 * wanted + ROOM).min(free);
    let mut state =
        State { pencil, factor, known, basis: Vec::new(), form: Mat::zeros(most + BLOCK, most + BLOCK), applied: 0 };
    let mut seed = Seed::default();
    let mut random: Vec<f64> = (0..n * BLOCK.min(free)).map(|_| seed.next()).collect();
    state.cleaned(&mut random);
    state.add(&random);
    for _ in 0..MOST_BLOCKS {
        let next = state.apply()?;
        let ritz = state.ritz(above)?;
        let last = state.applied >= free || state.basis.len() == state.applied * n && next == 0;
        let converged = ritz.residuals.iter().take(wanted).all(|own| *own <= FOUND);
        if (converged && ritz.values.len() > wanted) || last {
            let take = wanted.min(ritz.values.len());
            let shift = factor.shift;
            let to_value = |inverse: &f64| shift + 1.0 / inverse;
            let next = ritz.values.get(take).map_or(f64::INFINITY, to_value);
            return Some(Found {
                vectors: state.combined(&ritz, take),
                values: ritz.values.iter().take(take).map(to_value).collect(),
                next,
            });
        }
        if state.basis.len() / n + BLOCK > most {
            state.cut(&ritz, wanted + ROOM / 3);
        }
    }
    None
}

/// Random numbers, the same each time.
pub(super) struct Seed(u64);

impl Default for Seed {
    fn default() -> Self {
        Self(0x9e37_79b9_7f4a_7c15)
    }
}

impl Seed {
    /// In -1..1 (G. Marsaglia, "Xorshift RNGs", J. Stat. Softw. 8 (2003)).
    pub(super) fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 * 2.0f64.powi(-52) - 1.0
    }
}

struct Ritz {
    /// Eigenvalues of the operator, in the order that is wanted.
    values: Vec<f64>,
    /// Their vectors in the part of the basis that was applied.
    vectors: Mat<f64>,
    /// What the operator leaves over, beside the eigenvalue.
    residuals: Vec<f64>,
}

struct State<'a> {
    pencil: &'a Pencil,
    factor: &'a Factor<'a>,
    known: &'a [f64],
    /// n entries a vector.
    basis: Vec<f64>,
    /// VᵀM OP V, as far as the operator was applied.
    form: Mat<f64>,
    applied: usize,
}

impl State<'_> {
    /// Takes what is new in some vectors, which are orthogonal to the basis, into it; gives how many.
    fn add(&mut self, vectors: &[f64]) -> usize {
        let n = self.pencil.dimension();
        let before = self.basis.len();
        let mut inertia = vec![0.0; n];
        for vector in vectors.chunks_exact(n) {
            let mut own = vector.to_vec();
            self.pencil.mass.times(&own, &mut inertia);
            let whole = dot(&own, &inertia).sqrt();
            let mut length = whole;
            for _ in 0..2 {
                // What is nearly in the span of those before has lost its distance from all others, too.
                let others: &[f64] = if length < 1e-2 * whole { &self.basis } else { &self.basis[before..] };
                project(others, &inertia, &mut own, n);
                self.pencil.mass.times(&own, &mut inertia);
                length = dot(&own, &inertia).sqrt();
            }
            if length.is_nan() || length <= 1e-10 * whole || length == 0.0 {
                continue;
            }
            self.basis.extend(own.iter().map(|x| x / length));
        }
        (self.basis.len() - before) / n
    }

    /// Takes out of some vectors what they have of the basis and of what is known; gives VᵀM times them.
    fn cleaned(&self, images: &mut [f64]) -> Mat<f64> {
        let n = self.pencil.dimension();
        let mut inertia = vec![0.0; images.len()];
        let mut total = Mat::zeros(self.basis.len() / n, images.len() / n);
        for _ in 0..2 {
            for (inertia, image) in inertia.chunks_exact_mut(n).zip(images.chunks_exact(n)) {
                self.pencil.mass.times(image, inertia);
            }
            project(self.known, &inertia, images, n);
            total += project(&self.basis, &inertia, images, n);
        }
        total
    }

    /// Applies the operator to the next block; gives how many new vectors come of it.
    fn apply(&mut self) -> Option<usize> {
        let n = self.pencil.dimension();
        let (start, end) = (self.applied, (self.basis.len() / n).min(self.applied + BLOCK));
        if start == end {
            return Some(0);
        }
        let mut images = vec![0.0; n * (end - start)];
        for (image, own) in images.chunks_exact_mut(n).zip(self.basis[start * n..end * n].chunks_exact(n)) {
            self.pencil.mass.times(own, image);
        }
        self.factor.solve(&mut images);
        if !images.iter().all(|x| x.is_finite()) {
            return None;
        }
        // T = VᵀM OP V for these columns, with what is new to the basis at its end.
        let total = self.basis.len() / n;
        let parts = self.cleaned(&mut images);
        for j in start..end {
            for i in 0..total {
                self.form[(i, j)] = parts[(i, j - start)];
            }
        }
        let added = self.add(&images);
        // The new vectors' own rows: what is left of the images in them.
        for (j, image) in (start..end).zip(images.chunks_exact(n)) {
            let mut inertia = vec![0.0; n];
            self.pencil.mass.times(image, &mut inertia);
            for i in total..total + added {
                self.form[(i, j)] = dot(&self.basis[i * n..(i + 1) * n], &inertia);
            }
        }
        self.applied = end;
        Some(added)
    }

    fn ritz(&self, above: bool) -> Option<Ritz> {
        let m = self.applied;
        let total = self.basis.len() / self.pencil.dimension();
        let square = Mat::from_fn(m, m, |i, j| 0.5 * (self.form[(i, j)] + self.form[(j, i)]));
        let eigen: SelfAdjointEigen<f64> = square.self_adjoint_eigen(Side::Lower).ok()?;
        let all = eigen.S();
        let mut order: Vec<usize> = (0..m).collect();
        if above {
            order.retain(|k| all[*k] > 0.0);
            order.order_by(|a, b| all[*b].total_cmp(&all[*a]));
        } else {
            order.order_by(|a, b| all[*b].abs().total_cmp(&all[*a].abs()));
        }
        let residuals = order.iter().map(|k| {
            let mut square = 0.0;
            for i in m..total {
                let part: f64 = (0..m).map(|j| self.form[(i, j)] * eigen.U()[(j, *k)]).sum();
                square += part * part;
            }
            square.sqrt() / all[*k].abs()
        });
        let residuals = residuals.collect();
        let vectors = Mat::from_fn(m, order.len(), |i, k| eigen.U()[(i, order[k])]);
        Some(Ritz { values: order.iter().map(|k| all[*k]).collect(), vectors, residuals })
    }

    /// The first Ritz vectors.
    fn combined(&self, ritz: &Ritz, count: usize) -> Vec<f64> {
        let n = self.pencil.dimension();
        let mut out = vec![0.0; n * count];
        let basis = columns(&self.basis[..self.applied * n], n);
        let target = MatMut::from_column_major_slice_mut(&mut out, n, count);
        matmul(target, Accum::Replace, basis, ritz.vectors.as_ref().subcols(0, count), 1.0, Par::Seq);
        out
    }

    /// Keeps the best Ritz vectors and what the operator was not applied to.
    fn cut(&mut self, ritz: &Ritz, keep: usize) {
        let n = self.pencil.dimension();
        let keep = keep.min(ritz.values.len());
        let mut basis = self.combined(ritz, keep);
        basis.extend_from_slice(&self.basis[self.applied * n..]);
        let left = basis.len() / n - keep;
        let coupling = Mat::from_fn(left, keep, |i, k| {
            (0..self.applied).map(|j| self.form[(self.applied + i, j)] * ritz.vectors[(j, k)]).sum::<f64>()
        });
        self.form.fill(0.0);
        for k in 0..keep {
            self.form[(k, k)] = ritz.values[k];
            for i in 0..left {
                self.form[(keep + i, k)] = coupling[(i, k)];
            }
        }
        self.basis = basis;
        self.applied = keep;
    }
}

pub(super) fn dot(x: &[f64], y: &[f64]) -> f64 {
    let (blocks, rest) = x.as_chunks::<8>();
    let (others, left) = y.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (x, y) in blocks.iter().zip(others) {
        for i in 0..8 {
            sums[i] += x[i] * y[i];
        }
    }
    sums.iter().sum::<f64>() + rest.iter().zip(left).map(|(x, y)| x * y).sum::<f64>()
}

/// vectors <- vectors - V Vᵀ inertia, for several; gives Vᵀ inertia.
fn project(others: &[f64], inertia: &[f64], vectors: &mut [f64], n: usize) -> Mat<f64> {
    let (v, w) = (columns(others, n), columns(inertia, n));
    let mut parts = Mat::zeros(v.ncols(), w.ncols());
    matmul(parts.as_mut(), Accum::Replace, v.transpose(), w, 1.0, Par::Seq);
    let count = w.ncols();
    let target = MatMut::from_column_major_slice_mut(vectors, n, count);
    matmul(target, Accum::Add, v, parts.as_ref(), -1.0, Par::Seq);
    parts
}
