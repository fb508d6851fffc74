//! How far the frequencies of a block can be off, proved.
//!
//! Let X be the computed eigenvectors, taken as exact, G = XᵀMX and H = XᵀKX with the exact M and
//! K of the given parameters. Both are computed in doubles, Ĝ and Ĥ, and
//!
//! |H - Ĥ| <= |X|ᵀ (γ |K̂| + E) |X|,   γ = (2n + 4) u,
//!
//! where E bounds the errors of the entries of K̂ (from the running error analysis) and γ those
//! of two products one after the other (Higham, Accuracy and Stability of Numerical Algorithms,
//! 2nd ed., §3.5: γ_2n = 2nu/(1 - 2nu)). Let e be that bound with |ĥ_ij| added beside the diagonal,
//! and f the same of G.
//!
//! Take any weights w > 0, and let ρ_i and φ_i be the sums of e_ij w_j/w_i and f_ij w_j/w_i over j.
//! For every real μ the matrix H - μG differs from the diagonal matrix of ĥ_ii - μ ĝ_ii by a
//! symmetric one whose absolute values are at most e + |μ| f, hence (a symmetric matrix whose
//! diagonal dominates its rows, scaled by the weights or not, is positive semidefinite)
//!
//! H - μG >= diag(ĥ_ii - ρ_i - (μ ĝ_ii + |μ| φ_i)).
//!
//! Where ĝ_ii > φ_i for all i, G is positive definite for the same reason, so X is regular, M is
//! positive definite, and the number of eigenvalues of K x = λ M x below μ is the number of
//! negative eigenvalues of H - μG (Sylvester). That is at most the number of negative entries on
//! the right: of those i with ℓ_i < μ, where ℓ_i solves μ ĝ_ii + |μ| φ_i = ĥ_ii - ρ_i. So the k-th
//! eigenvalue is at least the k-th smallest ℓ_i, and that at least the least ℓ_i of all i with λ_i
//! >= λ_k, where λ_i = ĥ_ii/ĝ_ii; from above likewise. And
//!
//! |ℓ_i - λ_i| <= (ρ_i + |λ_i| φ_i)/(ĝ_ii - φ_i).
//!
//! Every eigenvalue is counted once, and nothing has to be separated. For each k the weights are
//! chosen anew, 1 but for w_k = t >= 1: what couples k to the others counts 1/t in row k and t in
//! the others, which do no harm while they don't reach λ_k. So separated eigenvalues are bounded by
//! e_kk + |λ_k| f_kk, in effect; in clusters t = 1.

use super::solve::Solver;
use super::tape::U;
use librate_core::precision::Lane;

/// An entry that is not zero identically, of a symmetric matrix one of the upper triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) row: usize,
    pub(super) column: usize,
    /// The register that its value and its error stand in.
    pub(super) register: usize,
}

/// One of the forms XᵀMX, XᵀKX.
struct Form {
    /// The diagonal as computed.
    diagonal: Vec<Lane>,
    /// Bounds of its errors, e_ii.
    errors: Vec<Lane>,
    /// The sum of e_ij over j ≠ i.
    beside: Vec<Lane>,
    /// e_ij, row by row; symmetric, its diagonal is not used.
    couplings: Vec<Lane>,
}

/// Scratch and results of the bound.
pub(super) struct Bounder {
    /// Rayleigh quotients λ_k.
    pub(super) values: Vec<Lane>,
    /// How far the eigenvalue with the place of λ_k is from it; infinite where nothing is proved.
    pub(super) radii: Vec<Lane>,
    /// z, the largest displacement of each coordinate when no mode moves by more than 1.
    pub(super) reach: Vec<Lane>,
    /// 1 where M is proved to be positive definite, else 0.
    pub(super) positive: Lane,
    stiffness: Form,
    inertia: Form,
    product: Vec<Lane>,
    error: Vec<Lane>,
}

/// What makes up for the roundings in sums of m nonnegative numbers and a few more operations.
pub(super) fn growth(m: usize) -> f64 {
    1.0 + (4 * m + 64) as f64 * U
}

/// More than underflow takes away from an entry of a form: at most 4000·4000 products lose
/// 2^-1075 each, times the vectors' components; vectors that long are refused.
pub(super) const TINY: f64 = 1e-240;
pub(super) const LONGEST: f64 = 1e60;
/// Without weights φ_i is below this, with weights below twice as much, and ĝ_ii is within it of 1:
/// then 1/(ĝ_ii - φ_i) <= 16/13.
pub(super) const ROOM: f64 = 1.0 / 16.0;
const INVERSE_ROOM: f64 = 1.25;
/// Weights are at most this.
pub(super) const LARGEST_WEIGHT: f64 = 1e30;

impl Form {
    fn new(n: usize) -> Self {
        Self {
            diagonal: vec![Lane::ZERO; n],
            errors: vec![Lane::ZERO; n],
            beside: vec![Lane::ZERO; n],
            couplings: vec![Lane::ZERO; n * n],
        }
    }

    /// Computes XᵀAX and its errors; the rows of `x` are the vectors.
    #[inline(always)]
    fn compute(
        &mut self,
        entries: &[Entry],
        (values, errors): (&[Lane], &[Lane]),
        x: &[Lane],
        (product, error): (&mut [Lane], &mut [Lane]),
    ) {
        let n = self.diagonal.len();
        let gamma = Lane::splat((2 * n + 4) as f64 * U);
        let grow = Lane::splat(growth(n));
        self.beside.fill(Lane::ZERO);
        for j in 0..n {
            let vector = &x[j * n..(j + 1) * n];
            product.fill(Lane::ZERO);
            error.fill(Lane::splat(TINY));
            for entry in entries {
                let (i, j) = (entry.row, entry.column);
                let value = values[entry.register];
                let off = gamma * value.abs() + errors[entry.register];
                product[i] += value * vector[j];
                error[i] += off * vector[j].abs();
                if i != j {
                    product[j] += value * vector[i];
                    error[j] += off * vector[i].abs();
                }
            }
            for i in 0..=j {
                let (mut sum, mut off) = (Lane::ZERO, Lane::splat(TINY));
                let parts = product.iter().zip(&*error);
                for (x, (product, error)) in x[i * n..(i + 1) * n].iter().zip(parts) {
                    sum += *x * *product;
                    off += x.abs() * *error;
                }
                if i == j {
                    self.diagonal[j] = sum;
                    self.errors[j] = off * grow;
                } else {
                    let coupling = (sum.abs() + off) * grow;
                    self.couplings[i * n + j] = coupling;
                    self.couplings[j * n + i] = coupling;
                    self.beside[i] += coupling;
                    self.beside[j] += coupling;
                }
            }
        }
        for beside in &mut self.beside {
            *beside = *beside * grow;
        }
    }
}

impl Bounder {
    pub(super) fn new(n: usize) -> Self {
        let row = vec![Lane::ZERO; n];
        Self {
            values: row.clone(),
            radii: row.clone(),
            reach: row.clone(),
            positive: Lane::ZERO,
            stiffness: Form::new(n),
            inertia: Form::new(n),
            product: row.clone(),
            error: row,
        }
    }

    /// Whether M is proved to be positive definite, from the rows of W.
    #[inline(always)]
    pub(super) fn weigh(&mut self, solver: &Solver, mass: &[Entry], numbers: (&[Lane], &[Lane])) {
        let x = &solver.vectors[..solver.n * solver.n];
        self.inertia.compute(mass, numbers, x, (&mut self.product[..], &mut self.error[..]));
        self.positive = Lane::ONE;
        for i in 0..solver.n {
            let phi = (self.inertia.errors[i] + self.inertia.beside[i]) * Lane::splat(growth(solver.n));
            self.positive = self.positive * self.inertia.diagonal[i].above(phi);
        }
    }

    /// Bounds the eigenvalues of a solved block; `values` and `errors` are those of the registers
    /// that the entries of `mass` and `stiffness` stand in.
    #[inline(always)]
    pub(super) fn bound(
        &mut self,
        solver: &Solver,
        (mass, stiffness): (&[Entry], &[Entry]),
        (values, errors): (&[Lane], &[Lane]),
    ) {
        let n = solver.n;
        let x = &solver.vectors[..n * n];
        let grow = Lane::splat(growth(n));
        for (a, reach) in self.reach.iter_mut().enumerate() {
            let mut sum = Lane::ZERO;
            for j in 0..n {
                sum += x[j * n + a].abs();
            }
            *reach = sum * grow;
        }
        let numbers = (values, errors);
        let scratch = (&mut self.product[..], &mut self.error[..]);
        self.stiffness.compute(stiffness, numbers, x, scratch);
        self.weigh(solver, mass, numbers);
        let longest = self.reach.iter().fold(Lane::ZERO, |most, z| z.max(most));
        let mut proved = Lane::splat(LONGEST).above(longest);
        let room = Lane::splat(ROOM);
        for i in 0..n {
            let (g, phi) = (self.inertia.diagonal[i], self.inertia.errors[i] + self.inertia.beside[i]);
            self.values[i] = self.stiffness.diagonal[i] / g;
            proved = proved * room.above(phi * grow) * room.above((g - Lane::ONE).abs());
        }
        proved = proved * self.positive;
        for k in 0..n {
            self.radii[k] = self.radius(k, grow).choose(proved, Lane::splat(f64::INFINITY));
        }
    }

    /// The radius of one eigenvalue, under the assumptions that [`ROOM`] makes.
    #[inline(always)]
    fn radius(&self, k: usize, grow: Lane) -> Lane {
        let n = self.values.len();
        let (h, g) = (&self.stiffness, &self.inertia);
        let own = self.values[k];
        // The weight: as large as leaves the others a quarter of the distance, and φ its room.
        let mut most = Lane::splat(1.0 / LARGEST_WEIGHT);
        for i in (0..n).filter(|i| *i != k) {
            let distance = (self.values[i] - own).abs();
            let (e, f) = (h.couplings[k * n + i], g.couplings[k * n + i]);
            let share = Lane::splat(4.0) * (e + self.values[i].abs() * f) / distance;
            most = share.max(Lane::splat(4.0 / ROOM) * f).max(most);
        }
        let weight = (Lane::ONE / most).max(Lane::ONE);
        // Row k, whose own interval decides where all goes well.
        let rho = h.errors[k] + h.beside[k] / weight;
        let phi = g.errors[k] + g.beside[k] / weight;
        let size = own.abs();
        let room = g.diagonal[k] - phi * grow;
        let mut radius = ((rho + size * phi) / room + size * Lane::splat(2.0 * U)) * grow;
        // What is no number spreads to the end, which comparisons would lose.
        let mut lost = Lane::ZERO;
        for i in (0..n).filter(|i| *i != k) {
            let (e, f) = (h.couplings[k * n + i], g.couplings[k * n + i]);
            let rho = h.errors[i] + h.beside[i] + weight * e;
            let phi = g.errors[i] + g.beside[i] + weight * f;
            let value = self.values[i];
            let sum = rho + value.abs() * (phi + Lane::splat(2.0 * U));
            let theirs = sum * Lane::splat(INVERSE_ROOM) * grow;
            lost += theirs * Lane::ZERO;
            // How far the interval of row i reaches beyond λ_k, to the other side.
            let beyond = theirs - (value - own).abs() * (Lane::ONE - Lane::splat(4.0 * U));
            radius = beyond.max(radius);
            // The weight may leave φ_i no room: then nothing is proved.
            let narrow = (phi * grow).above(Lane::splat(2.0 * ROOM));
            radius = Lane::splat(f64::INFINITY).choose(narrow, radius);
        }
        (radius + Lane::splat(2.0 * U) * size) * grow + lost
    }

    /// ρ_i without weights: the row sums of |H - diag ĥ|.
    pub(super) fn row(&self, i: usize) -> Lane {
        self.stiffness.errors[i] + self.stiffness.beside[i]
    }

    /// ĥ_ii.
    pub(super) fn diagonal(&self, i: usize) -> Lane {
        self.stiffness.diagonal[i]
    }
}
