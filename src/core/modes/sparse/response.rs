//! What a force of one frequency moves, A x = f with A = S - ω²M + iωD of sparse matrices, in balls that hold it.
//!
//! x comes from a decomposition of A as a real symmetric matrix ([`super::bordered`]) and steps of refinement in double-double. With d so that
//! M - diag(d) is not negative, and no singular value of d^(-1/2) A d^(-1/2) less than τ, which an inertia proves, what x is off by has at most
//! the length |d^(-1/2) (f - A x)|/τ in units of d^(1/2). Where A is real and symmetric, K - ω²M, counts of eigenvalues below ω² ± τ say the same.

use faer::c64;

use super::bordered::{Bordered, Form, Row, row};
use super::lanczos::Seed;
use super::quadratic::SparseQuadratic;
use super::rows::{Rows, U};
use super::shifted::{Factor, GivenOrder, Pattern, Pencil, weights};
use crate::precision::{Ball, Complex, SparseMatrix, up};

/// What A is multiplied by in turn: where friction is everywhere -i leaves a definite Hermitian part.
const TURNS: [c64; 3] = [c64::new(0.0, -1.0), c64::new(0.6, -0.8), c64::new(1.0, 0.0)];
/// τ as parts of what the least singular value seems to be.
const SHARES: [f64; 2] = [0.5, 0.05];
/// Steps of an inverse iteration for that.
const ITERATIONS: usize = 4;
/// Most steps of refinement.
const REFINEMENTS: usize = 20;
/// Forces are balanced but for this part.
const REFINED: f64 = 1e-20;
/// Where pivots are next to 0 a matrix is decomposed that is this part of the norm aside.
const ASIDES: [f64; 3] = [0.0, 1e-10, 1e-6];

type Vector = Vec<Complex<Ball>>;

/// M, D and S, whose response is asked for at many frequencies.
pub struct SparseResponse {
    /// D, S and M by rows.
    parts: [Rows; 3],
    weights: Vec<f64>,
    /// 1/√d, rounded up.
    roots: Vec<f64>,
    order: Vec<usize>,
    pattern: Pattern,
    /// K and M, where nothing depends on velocities and S is symmetric.
    pencil: Option<Pencil>,
}

impl std::fmt::Debug for SparseResponse {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SparseResponse").field("coordinates", &self.roots.len()).finish_non_exhaustive()
    }
}

impl SparseResponse {
    /// `None` where M is not shown to be positive definite by its diagonal, or there is no memory.
    #[must_use]
    pub fn new(problem: &SparseQuadratic) -> Option<Self> {
        let parts = [Rows::general(&problem.velocity), Rows::general(&problem.stiffness), Rows::new(&problem.mass)];
        let weights = weights(&parts[2])?;
        let roots = weights.iter().map(|d| (1.0 / d).sqrt() * (1.0 + 4.0 * U)).collect();
        let order = Form::order([&parts[0], &parts[1], &parts[2], &parts[2]])?;
        let is_real = problem.symmetric && problem.velocity.stored() == 0;
        let pencil = if is_real { Pencil::new(&problem.symmetric_stiffness(), &problem.mass) } else { None };
        Some(Self { parts, weights, roots, order, pattern: Pattern::default(), pencil })
    }

    /// The response at an angular frequency to forces on coordinates; `None` where A is not shown to be regular, as at a resonance.
    #[must_use]
    pub fn at(&self, omega: &Ball, forces: &[(usize, Complex<Ball>)]) -> Option<Vec<Complex<Ball>>> {
        let n = self.roots.len();
        let rows = self.matrix(omega);
        let mut right = vec![Complex::<Ball>::zero(()); n];
        for (at, force) in forces {
            right[*at] = right[*at].add(force);
        }
        match &self.pencil {
            Some(pencil) => self.really(pencil, omega, &rows, &right),
            None => TURNS.iter().find_map(|turn| self.solved(&rows, &right, *turn)),
        }
    }

    /// The same of a real symmetric A.
    fn really(&self, pencil: &Pencil, omega: &Ball, rows: &[Row], right: &[Complex<Ball>]) -> Option<Vector> {
        let ball = *omega * *omega;
        let square = ball.mid_f64();
        let aside = pencil.stiffness_norms.0 * ASIDES[1];
        let factor = pencil.factor(square).or_else(|| pencil.factor(square + aside))?;
        let (x, length) = self.refined(rows, right, &|left: &[c64]| {
            let [mut re, mut im]: [Vec<f64>; 2] =
                [left.iter().map(|x| x.re).collect(), left.iter().map(|x| x.im).collect()];
            factor.solve(&mut re);
            factor.solve(&mut im);
            re.into_iter().zip(im).map(|(re, im)| c64::new(re, im)).collect()
        });
        if length > REFINED * self.length(right) {
            return None;
        }
        let seems = factor.least();
        let least = SHARES.iter().find_map(|share| {
            let [below, above] = [-1.0, 1.0].map(|side| pencil.factor(square + side * share * seems));
            let (below, above) = (below?, above?);
            // ω² itself is off by a few roundings.
            let least = share * seems - below.error.max(above.error) - 8.0 * U * square - ball.mid_f64_error();
            (below.negative == above.negative && least > 0.0).then_some(least)
        })?;
        let imaginary = right.iter().any(|own| !own.im.is_zero());
        let mut all = self.widened(x, length / (least * (1.0 - 8.0 * U)))?;
        if !imaginary {
            all.iter_mut().for_each(|own| own.im = Ball::ZERO);
        }
        Some(all)
    }

    /// With what components may be off by, a length in units of d^(1/2).
    fn widened(&self, x: Vector, far: f64) -> Option<Vector> {
        let far = up(far) * (1.0 + 8.0 * U);
        let widened = |(x, root): (Complex<Ball>, &f64)| {
            let by = up(far * root);
            Complex::new(x.re.with_added_radius(by), x.im.with_added_radius(by))
        };
        far.is_finite().then(|| x.into_iter().zip(&self.roots).map(widened).collect())
    }

    /// A by rows.
    fn matrix(&self, omega: &Ball) -> Vec<Row> {
        let square = *omega * *omega;
        let own = |i: usize| {
            let [velocity, stiffness, mass] = &self.parts;
            let all = velocity.entries(i).map(|(j, own)| (j, Complex::new(Ball::ZERO, *omega * own)));
            let all = all.chain(stiffness.entries(i).map(|(j, own)| (j, Complex::new(own, Ball::ZERO))));
            row(all.chain(mass.entries(i).map(|(j, own)| (j, Complex::new(-(square * own), Ball::ZERO)))))
        };
        (0..self.roots.len()).map(own).collect()
    }

    fn solved(&self, rows: &[Row], right: &[Complex<Ball>], turn: c64) -> Option<Vector> {
        let by = Complex::<Ball>::from_c64(turn, ());
        let turned = |row: &Row| row.iter().map(|(j, entry)| (*j, by.mul(entry))).collect();
        let matrix: Vec<Row> = rows.iter().map(turned).collect();
        let order = GivenOrder { rows: &self.order, last: &self.pattern };
        let matrix = Bordered::of(&matrix, &self.weights, &order, turn)?;
        let (factor, x, length) = ASIDES.iter().find_map(|part| {
            let factor = matrix.factor(*part)?;
            let nothing = vec![c64::new(0.0, 0.0); rows.len()];
            let solve = |left: &[c64]| {
                let [x, _] = matrix.solve(&factor, left, &nothing);
                x
            };
            let (x, length) = self.refined(rows, right, &solve);
            (length <= REFINED * self.length(right)).then_some((factor, x, length))
        })?;
        let seems = self.least(&matrix, &factor);
        let least = SHARES.iter().find_map(|share| matrix.least(share * seems).ok())?;
        self.widened(x, length / least)
    }

    /// A solution with the length of what it leaves of the forces.
    fn refined(&self, rows: &[Row], right: &[Complex<Ball>], solve: &dyn Fn(&[c64]) -> Vec<c64>) -> (Vector, f64) {
        let mut x = vec![Complex::<Ball>::zero(()); rows.len()];
        let mut left = right.to_vec();
        let mut length = self.length(&left);
        for _ in 0..REFINEMENTS {
            let mids: Vec<c64> = left.iter().map(Complex::to_c64).collect();
            let step = solve(&mids);
            // Centres alone: any x has the bound of its own residual.
            let next = x.iter().zip(&step).map(|(x, step)| x.add(&Complex::from_c64(*step, ())).center());
            let next: Vector = next.collect();
            let residual = |(row, right): (&Row, &Complex<Ball>)| {
                row.iter().fold(*right, |sum, (j, entry)| sum.sub(&entry.mul(&next[*j])))
            };
            let now: Vector = rows.iter().zip(right).map(residual).collect();
            let size = self.length(&now);
            if size.is_nan() || size >= length {
                break;
            }
            (x, left, length) = (next, now, size);
        }
        (x, length)
    }

    /// Of a vector of forces, in d^(-1/2), rounded up.
    fn length(&self, forces: &[Complex<Ball>]) -> f64 {
        let square = |(own, root): (&Complex<Ball>, &f64)| {
            let size = (own.re.abs_upper() + own.im.abs_upper()) * root;
            size * size
        };
        let sum: f64 = forces.iter().zip(&self.roots).map(square).sum();
        up((sum * (1.0 + (forces.len() + 16) as f64 * U)).sqrt())
    }

    /// About the least singular value in units of d.
    fn least(&self, matrix: &Bordered, factor: &Factor<'_>) -> f64 {
        let n = self.roots.len();
        let mut seed = Seed::default();
        let nothing = vec![c64::new(0.0, 0.0); n];
        let scaled = |x: &[c64]| x.iter().zip(&self.weights).map(|(x, d)| x * *d).collect::<Vec<c64>>();
        let mut right: Vec<c64> = self.weights.iter().map(|d| c64::new(seed.next() * d.sqrt(), 0.0)).collect();
        let mut least = f64::INFINITY;
        for _ in 0..ITERATIONS {
            // With B = d^(-1/2) A d^(-1/2) one step of B⁻¹B⁻ᴴ, in forces.
            let [x, _] = matrix.solve(factor, &right, &nothing);
            let [_, y] = matrix.solve(factor, &nothing, &scaled(&x));
            let length = |x: &[c64]| x.iter().zip(&self.weights).map(|(x, d)| x.norm_sqr() * d).sum::<f64>();
            let next = scaled(&y);
            let forces = |x: &[c64]| x.iter().zip(&self.roots).map(|(x, r)| x.norm_sqr() * r * r).sum::<f64>().sqrt();
            least = least.min((forces(&right) / length(&x).sqrt()).abs());
            let size = forces(&next);
            right = next.into_iter().map(|x| x / size).collect();
        }
        least
    }
}

/// Whether K is proved to be positive definite, beside M.
#[must_use]
pub fn is_definite(stiffness: &SparseMatrix, mass: &SparseMatrix) -> bool {
    let Some(pencil) = Pencil::new(stiffness, mass) else { return false };
    let lowest = pencil.factor(0.0).filter(|own| own.negative == 0).map_or(0.0, |own| own.least());
    pencil.factor(0.5 * lowest).is_some_and(|own| own.negative == 0 && own.error < 0.5 * lowest)
}
