//! How far the frequencies of a block can be off, proved.
//!
//! Let X be the computed eigenvectors, taken as exact, G = XᵀMX and H = XᵀKX with the exact M and
//! K of the given parameters. Both are computed in doubles, Ĝ and Ĥ, and
//!
//! |H - Ĥ| <= |X|ᵀ (γ |K̂| + E) |X|,   γ = (2n + 4) u,
//!
//! where E bounds the errors of the entries of K̂ (from the running error analysis) and γ those
//! of two products one after the other (Higham, Accuracy and Stability of Numerical Algorithms, 2nd
//! ed., §3.5: γ_2n = 2nu/(1 - 2nu)). Only the row sums of the right side are needed, and they cost no matrix product:
//! |X|ᵀ((γ|K̂| + E) z) with z = |X|·1.
//!
//! Let ρ_i be the sum of |ĥ_ij|, j ≠ i, plus that row sum, and φ_i the same of G. For every real μ
//! the matrix H - μG differs from the diagonal matrix of ĥ_ii - μ ĝ_ii by a symmetric one whose
//! row sums of absolute values are at most ρ_i + |μ| φ_i, hence (a symmetric matrix with
//! dominant nonnegative diagonal is positive semidefinite)
//!
//! H - μG >= diag(ĥ_ii - ρ_i - (μ ĝ_ii + |μ| φ_i)).
//!
//! Where ĝ_ii > φ_i for all i, G is positive definite for the same reason, so X is regular, M is positive
//! definite, and the number of eigenvalues of K x = λ M x below μ is the number of negative
//! eigenvalues of H - μG (Sylvester), which is at most the number of negative entries on the
//! right: of those i with ℓ_i < μ, where ℓ_i solves μ ĝ_ii + |μ| φ_i = ĥ_ii - ρ_i. So the k-th
//! eigenvalue is at least the k-th smallest ℓ_i; from above likewise. With λ_i = ĥ_ii/ĝ_ii
//!
//! |ℓ_i - λ_i| <= (ρ_i + |λ_i| φ_i)/(ĝ_ii - φ_i).
//!
//! Nothing has to be separated for that, and every eigenvalue is counted once. The same holds with
//! weights w_i > 0, the entries of row i counting w_j/w_i: scaling by diag(w) changes no number of negative
//! eigenvalues. Two weightings are used, each for all rows, and the better result is taken: w = 1,
//! and w = 1/√|λ|, under which soft modes don't see the rounding errors of stiff ones.

use super::lane::Lane;
use super::solve::Solver;
use super::tape::U;

/// An entry of the upper triangle that is not zero identically.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) row: usize,
    pub(super) column: usize,
    /// The register that its value and its error stand in.
    pub(super) register: usize,
}

/// Scratch and results of the bound.
#[derive(Clone, Debug)]
pub(super) struct Bounder {
    /// Rayleigh quotients λ_i.
    pub(super) values: Vec<Lane>,
    /// Bounds of |ℓ_i - λ_i| with either weighting; infinite where nothing is proved.
    pub(super) radii: [Vec<Lane>; 2],
    /// ρ_i with either weighting; the first is without weights.
    pub(super) rows: [Vec<Lane>; 2],
    /// z, the largest displacement of each coordinate when no mode moves by more than 1.
    pub(super) reach: Vec<Lane>,
    /// 1 where M is proved to be positive definite, else 0.
    pub(super) positive: Lane,
    /// ĥ_ii.
    pub(super) diagonal: Vec<Lane>,
    inertia: Vec<Lane>,
    inertia_rows: [Vec<Lane>; 2],
    /// The weights, their inverses, and z with them.
    weights: Vec<Lane>,
    inverses: Vec<Lane>,
    weighted_reach: Vec<Lane>,
    product: Vec<Lane>,
}

/// What makes up for the roundings in sums of m nonnegative numbers and a few more operations.
pub(super) fn growth(m: usize) -> f64 {
    1.0 + (4 * m + 64) as f64 * U
}

/// More than underflow takes away anywhere in a row: at most 4000·4000 products lose 2^-1075
/// each, and the vectors' components multiply some of that; vectors that long are refused.
const TINY: f64 = 1e-240;
const LONGEST: f64 = 1e60;
/// Weights are at most the inverse root of this.
const SMALLEST_SHARE: f64 = 1e-12;

impl Bounder {
    pub(super) fn new(n: usize) -> Self {
        let row = vec![Lane::ZERO; n];
        Self {
            values: row.clone(),
            radii: [row.clone(), row.clone()],
            rows: [row.clone(), row.clone()],
            reach: row.clone(),
            positive: Lane::ZERO,
            diagonal: row.clone(),
            inertia: row.clone(),
            inertia_rows: [row.clone(), row.clone()],
            weights: row.clone(),
            inverses: row.clone(),
            weighted_reach: row.clone(),
            product: row,
        }
    }

    /// Bounds the eigenvalues of a solved block; `errors` are those of the registers that the
    /// entries of `mass` and `stiffness` stand in.
    #[inline(always)]
    pub(super) fn bound(
        &mut self,
        solver: &Solver,
        mass: &[Entry],
        stiffness: &[Entry],
        values: &[Lane],
        errors: &[Lane],
    ) {
        let n = solver.n;
        let x = &solver.vectors[..n * n];
        let grow = Lane::splat(growth(n));
        let stiffest = solver
            .values
            .iter()
            .fold(Lane::splat(f64::MIN_POSITIVE), |most, value| {
                value.abs().max(most)
            });
        for (j, value) in solver.values.iter().enumerate() {
            let share = value.abs() / stiffest + Lane::splat(SMALLEST_SHARE);
            self.inverses[j] = share.sqrt();
            self.weights[j] = Lane::ONE / self.inverses[j];
        }
        for a in 0..n {
            let (mut plain, mut weighted) = (Lane::ZERO, Lane::ZERO);
            for j in 0..n {
                let size = x[j * n + a].abs();
                plain += size;
                weighted += self.weights[j] * size;
            }
            self.reach[a] = plain * grow;
            self.weighted_reach[a] = weighted * grow;
        }
        let form = Form {
            x,
            values,
            errors,
            reaches: [&self.reach, &self.weighted_reach],
            weights: &self.weights,
            inverses: &self.inverses,
        };
        form.rows(
            stiffness,
            &mut self.product,
            &mut self.diagonal,
            &mut self.rows,
        );
        form.rows(
            mass,
            &mut self.product,
            &mut self.inertia,
            &mut self.inertia_rows,
        );
        for (i, value) in self.values.iter_mut().enumerate() {
            *value = self.diagonal[i] / self.inertia[i];
        }
        let longest = self.reach.iter().fold(Lane::ZERO, |most, z| z.max(most));
        let in_range = Lane::splat(LONGEST).above(longest);
        for (weighting, radii) in self.radii.iter_mut().enumerate() {
            let mut proved = Lane::ONE;
            for (i, radius) in radii.iter_mut().enumerate() {
                let (rho, phi) = (self.rows[weighting][i], self.inertia_rows[weighting][i]);
                let room = self.inertia[i] - phi * grow;
                proved = proved * room.above(Lane::splat(0.5));
                let size = self.values[i].abs();
                *radius = ((rho + size * phi) / room + size * Lane::splat(2.0 * U)) * grow;
            }
            if weighting == 0 {
                self.positive = proved;
            }
            proved = proved * in_range;
            for radius in radii {
                *radius = radius.choose(proved, Lane::splat(f64::INFINITY));
            }
        }
    }
}

/// What the forms XᵀMX and XᵀKX have in common.
struct Form<'a> {
    x: &'a [Lane],
    values: &'a [Lane],
    errors: &'a [Lane],
    reaches: [&'a [Lane]; 2],
    weights: &'a [Lane],
    inverses: &'a [Lane],
}

impl Form<'_> {
    /// The diagonal of XᵀAX, and for each row the absolute values beside it plus what they can be
    /// off by, with either weighting.
    #[inline(always)]
    fn rows(
        &self,
        entries: &[Entry],
        product: &mut [Lane],
        diagonal: &mut [Lane],
        rows: &mut [Vec<Lane>; 2],
    ) {
        let n = diagonal.len();
        let x = self.x;
        let gamma = Lane::splat((2 * n + 4) as f64 * U);
        // The errors: (γ|A| + E) z, then times |X|ᵀ.
        for (reach, rows) in self.reaches.iter().zip(rows.iter_mut()) {
            product.fill(Lane::splat(TINY));
            for entry in entries {
                let weight =
                    gamma * self.values[entry.register].abs() + self.errors[entry.register];
                product[entry.row] += weight * reach[entry.column];
                if entry.row != entry.column {
                    product[entry.column] += weight * reach[entry.row];
                }
            }
            for (i, row) in rows.iter_mut().enumerate() {
                let mut sum = Lane::splat(TINY);
                for (x, product) in x[i * n..(i + 1) * n].iter().zip(&*product) {
                    sum += x.abs() * *product;
                }
                *row = sum;
            }
        }
        let [plain, weighted] = rows;
        for j in 0..n {
            let vector = &x[j * n..(j + 1) * n];
            product.fill(Lane::ZERO);
            for entry in entries {
                let value = self.values[entry.register];
                product[entry.row] += value * vector[entry.column];
                if entry.row != entry.column {
                    product[entry.column] += value * vector[entry.row];
                }
            }
            for i in 0..=j {
                let mut sum = Lane::ZERO;
                for (x, product) in x[i * n..(i + 1) * n].iter().zip(&*product) {
                    sum += *x * *product;
                }
                if i == j {
                    diagonal[j] = sum;
                } else {
                    let size = sum.abs();
                    plain[i] += size;
                    plain[j] += size;
                    weighted[i] += size * self.weights[j];
                    weighted[j] += size * self.weights[i];
                }
            }
        }
        let grow = Lane::splat(growth(n));
        for i in 0..n {
            plain[i] = plain[i] * grow;
            weighted[i] = weighted[i] * self.inverses[i] * grow;
        }
    }
}
