//! M x'' + B x' + K x = 0 for eight parameter sets at once, in doubles: all exponents and vectors.
//!
//! 1. M = L Lᵀ, W = L⁻¹ ([`super::solve`]), and the time in a unit 1/σ, about that of the fastest oscillation.
//! 2. A = [[0, 1], [-W K Wᵀ/σ², -W B Wᵀ/σ]] becomes a Hessenberg matrix, then an upper triangular one, T = Qᴴ A Q, by
//!    complex plane rotations: the shifted QR algorithm (G. H. Golub and C. F. Van Loan, Matrix Computations, 4th ed.,
//!    §7.5) with the shift of Wilkinson. (That of nalgebra does not end for some of these matrices, whose eigenvalues
//!    are pairs; that of faer is not public.)
//! 3. Vectors of T and the inverse of their matrix, both triangular, and from these X and X⁻¹ of A. Where exponents
//!    are so near to each other that their vectors are nearly the same, X⁻¹ A X keeps a triangular block (C. A. Bavely
//!    and G. W. Stewart, SIAM J. Numer. Anal. 16 (1979) 359), scaled so that little of it is beside the diagonal.
//!
//! Which block of T is worked on is decided set by set; beyond it rotations are by the angle 0 and change nothing. So a
//! set's numbers don't depend on its neighbours.

use super::complex::ComplexLane;
use super::solve::{Solver, conjugate};
use librate_core::precision::{LANES, Lane};

/// Sweeps for each exponent; three are usual.
const MOST_SWEEPS: usize = 40;
/// After so many sweeps without an exponent the shift is another one.
const PATIENCE: u32 = 10;
/// A vector of T is not freed from another one that it would have this share of: the two stay joined, in a block that
/// is triangular.
const LARGEST_SHARE: f64 = 1e7;
/// What joins vectors is rounding below this fraction of the largest entry.
const LARGEST_ROUNDING: f64 = 1e-14;
/// Below everything that matters beside numbers of about 1, even in a square.
const NOTHING: f64 = 1e-145;

/// The first-order problems of a block and what becomes of them. All matrices are row by row.
pub(super) struct Exponents {
    n: usize,
    /// B, n by n.
    pub(super) velocity: Vec<Lane>,
    /// σ, a power of two.
    pub(super) unit: Lane,
    /// The exponents over σ, in no order: 2n.
    pub(super) values: Vec<ComplexLane>,
    /// Row k is a vector z = (x, x'/σ) of exponent k, 2n by 2n, ...
    pub(super) right: Vec<ComplexLane>,
    /// ... and this row y is such that y (M x, M x'/σ) is 1 for it and 0 for the others.
    pub(super) left: Vec<ComplexLane>,
    /// √(xᴴMx) of the larger half of each vector.
    pub(super) lengths: Vec<Lane>,
    /// Which row has the shape of exponent k: another one where both have the same vector (a Jordan block, nearly), ...
    pub(super) shapes: Vec<[usize; LANES]>,
    /// ... and of how many before it in its block.
    depths: Vec<Lane>,
    /// 1 where the iteration came to an end, else 0.
    pub(super) converged: Lane,
    /// A, which becomes T.
    matrix: Vec<ComplexLane>,
    /// Row k is column k of Q.
    basis: Vec<ComplexLane>,
    scratch: Vec<Lane>,
}

/// The rotation (c a + s b, c b - s̄ a).
#[derive(Clone, Copy)]
struct Rotation {
    c: Lane,
    s: ComplexLane,
}

impl Rotation {
    /// The one that makes the second of two numbers 0.
    #[inline(always)]
    fn of(a: ComplexLane, b: ComplexLane) -> Self {
        let (first, length) = (a.abs(), (a.square() + b.square()).sqrt());
        let phase = a.times(Lane::ONE / first).choose(first.above(Lane::ZERO), ComplexLane::ONE);
        let any = length.above(Lane::ZERO);
        let inverse = Lane::ONE / length;
        Self { c: (first * inverse).choose(any, Lane::ONE), s: (phase * b.conj()).times(inverse) }.only(any)
    }

    /// It where it is chosen, else none.
    #[inline(always)]
    fn only(self, choice: Lane) -> Self {
        Self { c: self.c.choose(choice, Lane::ONE), s: self.s.choose(choice, ComplexLane::ZERO) }
    }

    #[inline(always)]
    fn conj(self) -> Self {
        Self { s: self.s.conj(), ..self }
    }

    #[inline(always)]
    fn turn(self, a: &mut ComplexLane, b: &mut ComplexLane) {
        let (old_a, old_b) = (*a, *b);
        *a = old_a.times(self.c) + self.s * old_b;
        *b = old_b.times(self.c) - self.s.conj() * old_a;
    }

    /// Turns rows k and k + 1 of a matrix of so many columns from a column on.
    #[inline(always)]
    fn turn_rows(self, matrix: &mut [ComplexLane], size: usize, k: usize, from: usize) {
        let (upper, lower) = matrix.split_at_mut((k + 1) * size);
        for (a, b) in upper[k * size + from..].iter_mut().zip(&mut lower[from..size]) {
            self.turn(a, b);
        }
    }
}

/// Where each set is in its iteration.
struct Place {
    /// The block of T that is worked on; its last is 0 at the end.
    first: [usize; LANES],
    last: [usize; LANES],
    waits: [u32; LANES],
}

impl Exponents {
    pub(super) fn new(n: usize) -> Self {
        let square = vec![ComplexLane::ZERO; 4 * n * n];
        Self {
            n,
            velocity: vec![Lane::ZERO; n * n],
            unit: Lane::ONE,
            values: vec![ComplexLane::ZERO; 2 * n],
            right: square.clone(),
            left: square.clone(),
            lengths: vec![Lane::ONE; 2 * n],
            shapes: vec![[0; LANES]; 2 * n],
            depths: vec![Lane::ZERO; 2 * n],
            converged: Lane::ZERO,
            matrix: square.clone(),
            basis: square,
            scratch: vec![Lane::ZERO; 2 * n * n],
        }
    }

    /// Solves the block from M and K of a solver and B: the exponents, and with `vectors` the vectors of both sides.
    #[inline(always)]
    pub(super) fn solve(&mut self, solver: &mut Solver, vectors: bool) {
        solver.factor();
        self.first_order(solver);
        self.hessenberg(vectors);
        self.triangular(vectors);
        for k in 0..2 * self.n {
            self.values[k] = self.matrix[k * (2 * self.n + 1)];
        }
        if vectors {
            self.vectors(&solver.vectors);
        }
    }

    /// 1 where x'/σ is larger than x in the vector of an exponent, so that the shape has more digits there.
    #[inline(always)]
    pub(super) fn is_fast(&self, k: usize) -> Lane {
        self.values[k].square().above(Lane::ONE)
    }

    /// A, and Q = 1.
    #[inline(always)]
    fn first_order(&mut self, solver: &mut Solver) {
        let (n, size) = (self.n, 2 * self.n);
        let (stiffness, velocity) = self.scratch.split_at_mut(n * n);
        let both = [(&solver.stiffness, stiffness), (&self.velocity, velocity)];
        let [of_stiffness, of_velocity] = both.map(|(from, to)| {
            conjugate((&solver.vectors, from), false, &mut solver.scratch[..n], to);
            to.iter().fold(Lane::ZERO, |most, entry| entry.abs().max(most))
        });
        self.unit = of_stiffness.sqrt().choose(of_stiffness.above(Lane::splat(NOTHING)), of_velocity).map(|x| {
            let bits = x.to_bits() & 0x7ff0_0000_0000_0000;
            if (1e-140..1e140).contains(&x) { f64::from_bits(bits) } else { 1.0 }
        });
        let inverse = Lane::ONE / self.unit;
        self.matrix.fill(ComplexLane::ZERO);
        self.basis.fill(ComplexLane::ZERO);
        for i in 0..n {
            self.matrix[i * size + n + i] = ComplexLane::ONE;
            for j in 0..n {
                let (k, b) = (self.scratch[i * n + j], self.scratch[n * n + i * n + j]);
                self.matrix[(n + i) * size + j] = ComplexLane::real(-(k * inverse * inverse));
                self.matrix[(n + i) * size + n + j] = ComplexLane::real(-(b * inverse));
            }
        }
        for i in 0..size {
            self.basis[i * size + i] = ComplexLane::ONE;
        }
    }

    /// Turns rows k and k + 1 of T from a column on, then the columns, of rows before the last one.
    #[inline(always)]
    fn turn(&mut self, rotation: Rotation, k: usize, (from, rows): (usize, usize), vectors: bool) {
        let size = 2 * self.n;
        rotation.turn_rows(&mut self.matrix, size, k, from);
        for row in self.matrix[..rows * size].chunks_exact_mut(size) {
            let (a, b) = row[k..k + 2].split_at_mut(1);
            rotation.conj().turn(&mut a[0], &mut b[0]);
        }
        if vectors {
            rotation.conj().turn_rows(&mut self.basis, size, k, 0);
        }
    }

    #[inline(always)]
    fn hessenberg(&mut self, vectors: bool) {
        let size = 2 * self.n;
        for j in 0..size.saturating_sub(2) {
            for i in (j + 2..size).rev() {
                let [above, own] = [i - 1, i].map(|row| self.matrix[row * size + j]);
                self.turn(Rotation::of(above, own), i - 1, (j, size), vectors);
                self.matrix[i * size + j] = ComplexLane::ZERO;
            }
        }
    }

    /// Whether an entry beside the diagonal is no more than rounding.
    #[inline(always)]
    fn is_negligible(&self, k: usize, lane: usize) -> bool {
        let diagonal = 2 * self.n + 1;
        let [before, beside, own] = [(k - 1) * diagonal, k * diagonal - 1, k * diagonal].map(|at| {
            let entry = &self.matrix[at];
            entry.re.0[lane].abs() + entry.im.0[lane].abs()
        });
        beside <= f64::EPSILON * (before + own) + NOTHING
    }

    /// Finds the last block of each set; gives the first and the last row of all of them.
    #[inline(always)]
    fn deflate(&mut self, place: &mut Place) -> (usize, usize) {
        let size = 2 * self.n;
        let (mut low, mut high) = (size, 0);
        for lane in 0..LANES {
            let before = place.last[lane];
            while place.last[lane] > 0 {
                let last = place.last[lane];
                let mut first = last;
                while first > 0 && !self.is_negligible(first, lane) {
                    first -= 1;
                }
                if first > 0 {
                    let below = &mut self.matrix[first * size + first - 1];
                    (below.re.0[lane], below.im.0[lane]) = (0.0, 0.0);
                }
                if first < last {
                    place.first[lane] = first;
                    (low, high) = (low.min(first), high.max(last));
                    break;
                }
                place.last[lane] -= 1;
            }
            place.waits[lane] = if place.last[lane] == before { place.waits[lane] + 1 } else { 0 };
        }
        (low, high)
    }

    /// The eigenvalue of the last two rows of each block that is nearer to the last entry.
    #[inline(always)]
    fn shifts(&self, place: &Place) -> ComplexLane {
        let size = 2 * self.n;
        let [mut a, mut b, mut c, mut d] = [ComplexLane::ZERO; 4];
        for lane in 0..LANES {
            let last = place.last[lane].max(1);
            for (entry, at) in [(&mut a, (1, 1)), (&mut b, (1, 0)), (&mut c, (0, 1)), (&mut d, (0, 0))] {
                let own = &self.matrix[(last - at.0) * size + last - at.1];
                (entry.re.0[lane], entry.im.0[lane]) = (own.re.0[lane], own.im.0[lane]);
            }
        }
        let (half, product) = ((a - d).times(Lane::splat(0.5)), b * c);
        let root = (half * half + product).root();
        let is_along = (half.re * root.re + half.im * root.im).above(Lane::ZERO);
        let divisor = half + root.choose(is_along, -root);
        let shift = d - product.over(divisor).choose(divisor.square().above(Lane::ZERO), ComplexLane::ZERO);
        let mut other = Lane::ZERO;
        for (other, waits) in other.0.iter_mut().zip(place.waits) {
            *other = f64::from(u8::from(waits % PATIENCE == PATIENCE - 1));
        }
        (d + ComplexLane::real(c.sum())).choose(other, shift)
    }

    #[inline(always)]
    fn triangular(&mut self, vectors: bool) {
        let size = 2 * self.n;
        let mut place = Place { first: [0; LANES], last: [size.saturating_sub(1); LANES], waits: [0; LANES] };
        let total = self.matrix.iter().fold(Lane::ZERO, |total, entry| total + entry.re);
        for (last, total) in place.last.iter_mut().zip(total.0) {
            // Nothing to be solved; said elsewhere.
            if !total.is_finite() {
                *last = 0;
            }
        }
        for _ in 0..MOST_SWEEPS * size {
            let (low, high) = self.deflate(&mut place);
            if high == 0 {
                break;
            }
            let shift = self.shifts(&place);
            for k in low..high {
                let (mut within, mut begins) = (Lane::ZERO, Lane::ZERO);
                for lane in 0..LANES {
                    let block = place.first[lane]..place.last[lane];
                    within.0[lane] = f64::from(u8::from(block.contains(&k)));
                    begins.0[lane] = f64::from(u8::from(block.start == k));
                }
                let before = k.saturating_sub(1);
                let [upper, lower] =
                    [k, k + 1].map(|row| (self.matrix[row * size + k], self.matrix[row * size + before]));
                let a = (upper.0 - shift).choose(begins, upper.1);
                let rotation = Rotation::of(a, lower.0.choose(begins, lower.1)).only(within);
                self.turn(rotation, k, (before, (k + 3).min(size)), vectors);
                if k > 0 {
                    let below = &mut self.matrix[(k + 1) * size + before];
                    *below = ComplexLane::ZERO.choose(within, *below);
                }
            }
        }
        self.converged = Lane::ZERO;
        for (converged, last) in self.converged.0.iter_mut().zip(place.last) {
            *converged = f64::from(u8::from(last == 0));
        }
    }

    /// X, X⁻¹ and their products with W.
    #[inline(always)]
    fn vectors(&mut self, w: &[Lane]) {
        let (n, size) = (self.n, 2 * self.n);
        let t = &self.matrix;
        let (below, least) = (Lane::splat(f64::EPSILON), Lane::splat(NOTHING));
        let largest = t.iter().fold(Lane::ZERO, |most, entry| entry.sum().max(most));
        // Vectors R of T, column by column in rows of `right`, then in `matrix`, which is no longer needed, R⁻¹.
        for k in 0..size {
            let (known, own) = self.right.split_at_mut(k * size);
            own[..size].fill(ComplexLane::ZERO);
            own[k] = ComplexLane::ONE;
            self.depths[k] = Lane::ZERO;
            self.shapes[k] = [k; LANES];
            for i in (0..k).rev() {
                let mut sum = own[i];
                for j in i + 1..=k {
                    sum += t[i * size + j] * own[j];
                }
                let (this, other) = (t[k * size + k], t[i * size + i]);
                let (apart, limit) = (this - other, (this.sum() + other.sum()) * below + least);
                own[i] = sum.over(apart.choose(apart.sum().above(limit), ComplexLane::real(limit)));
                let joined = sum.sum().above(apart.sum() * Lane::splat(LARGEST_SHARE));
                if joined.any() {
                    own[i] = ComplexLane::ZERO.choose(joined, own[i]);
                    for (own, known) in own[..i].iter_mut().zip(&known[i * size..]) {
                        *own = (*own - *known * sum).choose(joined, *own);
                    }
                    let joined = joined * sum.sum().above(largest * Lane::splat(LARGEST_ROUNDING));
                    let depth = (self.depths[i] + Lane::ONE).max(self.depths[k]);
                    self.depths[k] = depth.choose(joined, self.depths[k]);
                    for lane in (0..LANES).filter(|lane| joined.0[*lane] != 0.0) {
                        self.shapes[k][lane] = self.shapes[i][lane];
                    }
                }
            }
        }
        let deepest = self.depths.iter().fold(Lane::ZERO, |most, depth| depth.max(most));
        for k in 0..size {
            for i in (0..=k).rev() {
                let mut sum = if i == k { -ComplexLane::ONE } else { ComplexLane::ZERO };
                for j in i + 1..=k {
                    sum += self.right[j * size + i] * self.matrix[j * size + k];
                }
                self.matrix[i * size + k] = -sum;
            }
        }
        for k in 0..size {
            let (start, end) = (k * size, (k + 1) * size);
            let length = self.right[start..=start + k].iter().fold(Lane::ZERO, |sum, x| sum + x.square()).sqrt();
            // u^(depth/(deepest + 1)), as a power of two.
            let scale = self.depths[k]
                .zip(deepest, |depth, deepest| f64::from_bits((1023 - (52.0 * depth / (deepest + 1.0)) as u64) << 52));
            for a in 0..size {
                let mut sum = ComplexLane::ZERO;
                for j in k..size {
                    sum += self.matrix[start + j] * self.basis[j * size + a].conj();
                }
                self.left[start + a] = sum.times(length / scale);
            }
            // That row of R⁻¹ is no longer needed.
            self.matrix[start..end].copy_from_slice(&self.right[start..end]);
            let inverse = scale / length;
            for a in 0..size {
                let mut sum = ComplexLane::ZERO;
                for j in 0..=k {
                    sum += self.matrix[start + j] * self.basis[j * size + a];
                }
                self.right[start + a] = sum.times(inverse);
            }
            let [shape, rates] = [0, n].map(|half| {
                let half = &self.right[start + half..start + half + n];
                half.iter().fold(Lane::ZERO, |sum, x| sum + x.square()).sqrt()
            });
            self.lengths[k] = rates.choose(self.is_fast(k), shape);
        }
        for half in self.right.chunks_exact_mut(n.max(1)).chain(self.left.chunks_exact_mut(n.max(1))) {
            for a in 0..n {
                let mut sum = ComplexLane::ZERO;
                for i in a..n {
                    sum += half[i].times(w[i * n + a]);
                }
                half[a] = sum;
            }
        }
    }
}
