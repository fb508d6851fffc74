//! How far the exponents of a block can be off, proved.
//!
//! With x' = σ v the equations are E z' = σ F z for z = (x, v), E = diag(M, M) and
//! F = [[0, M], [-K/σ², -B/σ]]. Let Z be the computed vectors and Y the computed left ones, both taken as exact, P = Y
//! E Z and R = Y F Z with the exact matrices of the given parameters. Both are computed in doubles, and, with |z| for
//! |Re z| + |Im z|,
//!
//! |P - P̂| <= |Y| (γ |Ê| + errors of its entries) |Z|,   γ = (6n + 8) u,
//!
//! and likewise R: each part of an entry is two sums of products one after the other, of at most 2n and 4n terms
//! (Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., §3.5). Let f and e be these bounds, with |p̂_ij|
//! and |r̂_ij| added beside the diagonal, and ρ_i and φ_i the sums of e_ij w_j/w_i and f_ij w_j/w_i over j, for
//! weights w > 0.
//!
//! Where |p̂_ii| > φ_i for all i, P is regular (its diagonal dominates its rows), and so are Y, Z and M: the
//! eigenvalues of the pencil (R, P) are the 2n exponents over σ. Each makes R - λP singular, so that for some i, with
//! λ_i = r̂_ii/p̂_ii,
//!
//! |λ - λ_i| |p̂_ii| <= ρ_i + |λ| φ_i,   hence   |λ - λ_i| <= (ρ_i + |λ_i| φ_i)/(|p̂_ii| - φ_i):
//!
//! a disc of Gershgorin's (for pencils: G. W. Stewart, Math. Comp. 29 (1975) 600). The same holds on the straight way
//! from the diagonals to P and R, on which the eigenvalues are continuous: as many discs as overlap hold as many
//! exponents.
//!
//! For each k the weights are chosen anew, 1 but for w_k = t >= 1: what couples k to the others counts 1/t in row k
//! and t in the others. Where disc k meets no other one it holds one exponent, and is within the disc for t = 1. Else,
//! all weights 1, each exponent of the discs that overlap is as far from λ_k as the farthest point of them at most.

use super::bound::{Entry, LARGEST_WEIGHT, LONGEST, ROOM, TINY, growth};
use super::complex::ComplexLane;
use super::exponents::Exponents;
use super::tape::U;
use librate_core::precision::{LANES, Lane};

/// Scratch and results of the bound.
pub(super) struct Discs {
    n: usize,
    /// λ_k.
    pub(super) values: Vec<ComplexLane>,
    /// How far the exponents are from these, infinite or no number where nothing is proved; both over σ.
    pub(super) radii: Vec<Lane>,
    /// e_ij and f_ij, ...
    rates: Form,
    shares: Form,
    /// ... |p̂_kk|, ...
    diagonal: Vec<Lane>,
    /// ... the radii for t = 1, and 1 where disc k meets no other one.
    plain: Vec<Lane>,
    alone: Vec<Lane>,
    members: Vec<usize>,
    /// M x, M v and Kx/σ² + Bv/σ of one vector, and bounds of their errors.
    images: [Vec<ComplexLane>; 3],
    errors: [Vec<Lane>; 3],
}

/// Bounds of the entries of a matrix less the computed diagonal.
struct Form {
    size: usize,
    entries: Vec<Lane>,
    /// Their sums over j ≠ i.
    beside: Vec<Lane>,
}

impl Form {
    fn new(size: usize) -> Self {
        Self { size, entries: vec![Lane::ZERO; size * size], beside: vec![Lane::ZERO; size] }
    }

    #[inline(always)]
    fn put(&mut self, (i, j): (usize, usize), bound: Lane) {
        self.entries[i * self.size + j] = bound;
        if i != j {
            self.beside[i] += bound;
        }
    }

    /// The sum of row i with the weight t of k.
    #[inline(always)]
    fn row(&self, i: usize, k: usize, t: Lane) -> Lane {
        let own = self.entries[i * (self.size + 1)];
        if i == k { own + self.beside[i] / t } else { own + self.beside[i] + t * self.entries[i * self.size + k] }
    }
}

/// M, K and B and where their numbers are.
#[derive(Clone, Copy)]
pub(super) struct Matrices<'a> {
    /// M by its upper triangle, K and B in full.
    pub(super) entries: [&'a [Entry]; 3],
    pub(super) values: &'a [Lane],
    pub(super) errors: &'a [Lane],
}

impl Matrices<'_> {
    /// An entry, and what it and the roundings of all sums that it is in are off by.
    #[inline(always)]
    fn number(&self, entry: &Entry, gamma: Lane) -> (Lane, Lane) {
        let value = self.values[entry.register];
        (value, gamma * value.abs() + self.errors[entry.register])
    }
}

/// Adds an entry times a component to an image and to the bound of its error.
#[inline(always)]
fn put(to: (&mut ComplexLane, &mut Lane), component: ComplexLane, (value, off): (Lane, Lane)) {
    *to.0 += component.times(value);
    *to.1 += off * component.sum();
}

impl Discs {
    pub(super) fn new(n: usize) -> Self {
        let row = vec![Lane::ZERO; 2 * n];
        Self {
            n,
            values: vec![ComplexLane::ZERO; 2 * n],
            radii: row.clone(),
            rates: Form::new(2 * n),
            shares: Form::new(2 * n),
            diagonal: row.clone(),
            plain: row.clone(),
            alone: row,
            members: Vec::with_capacity(2 * n),
            images: std::array::from_fn(|_| vec![ComplexLane::ZERO; n]),
            errors: std::array::from_fn(|_| vec![Lane::ZERO; n]),
        }
    }

    /// Bounds the exponents of a solved block.
    #[inline(always)]
    pub(super) fn bound(&mut self, solved: &Exponents, matrices: Matrices<'_>) {
        let size = 2 * self.n;
        let grow = Lane::splat(growth(size));
        self.rates.beside.fill(Lane::ZERO);
        self.shares.beside.fill(Lane::ZERO);
        let mut longest = Lane::ZERO;
        for j in 0..size {
            let vector = &solved.right[j * size..(j + 1) * size];
            self.image(vector, solved.unit, matrices);
            for component in vector.iter().chain(&solved.left[j * size..(j + 1) * size]) {
                // What is no number is kept.
                longest = component.sum().max(longest) + component.sum() * Lane::ZERO;
            }
            for i in 0..size {
                self.couple(&solved.left[i * size..(i + 1) * size], (i, j), grow);
            }
        }
        let mut proved = Lane::splat(LONGEST).above(longest);
        for k in 0..size {
            proved = proved * self.has_room(k, self.shares.row(k, k, Lane::ONE) * grow);
            self.plain[k] = self.disc(k, k, Lane::ONE, grow);
        }
        for k in 0..size {
            self.separate(k, grow);
        }
        for lane in 0..LANES {
            self.join(lane);
        }
        for k in 0..size {
            self.radii[k] = self.radii[k].choose(proved, Lane::splat(f64::INFINITY));
            self.values[k] = self.values[k].choose(proved, solved.values[k]);
        }
    }

    /// M x, M v and Kx/σ² + Bv/σ.
    #[inline(always)]
    fn image(&mut self, vector: &[ComplexLane], unit: Lane, matrices: Matrices<'_>) {
        let (x, v) = vector.split_at(self.n);
        let gamma = Lane::splat((6 * self.n + 8) as f64 * U);
        let inverse = Lane::ONE / unit;
        self.images.iter_mut().for_each(|image| image.fill(ComplexLane::ZERO));
        self.errors.iter_mut().for_each(|error| error.fill(Lane::splat(TINY)));
        let [mx, mv, force] = &mut self.images;
        let [mx_error, mv_error, force_error] = &mut self.errors;
        let [mass, stiffness, velocity] = matrices.entries;
        for entry in mass {
            let (i, j) = (entry.row, entry.column);
            let (value, off) = matrices.number(entry, gamma);
            put((&mut mx[i], &mut mx_error[i]), x[j], (value, off));
            put((&mut mv[i], &mut mv_error[i]), v[j], (value, off));
            if i != j {
                put((&mut mx[j], &mut mx_error[j]), x[i], (value, off));
                put((&mut mv[j], &mut mv_error[j]), v[i], (value, off));
            }
        }
        for (entries, part, factor) in [(stiffness, x, inverse * inverse), (velocity, v, inverse)] {
            for entry in entries {
                let (value, off) = matrices.number(entry, gamma);
                let to = (&mut force[entry.row], &mut force_error[entry.row]);
                put(to, part[entry.column], (value * factor, off * factor));
            }
        }
    }

    /// An entry of P and of R, and what it may be off by.
    #[inline(always)]
    fn couple(&mut self, left: &[ComplexLane], (i, j): (usize, usize), grow: Lane) {
        let [mx, mv, force] = &self.images;
        let [mx_error, mv_error, force_error] = &self.errors;
        let [mut p, mut r] = [ComplexLane::ZERO; 2];
        let [mut p_error, mut r_error] = [Lane::splat(TINY); 2];
        let (upper, lower) = left.split_at(self.n);
        for a in 0..self.n {
            let (y, u) = (upper[a], lower[a]);
            let (y_size, u_size) = (y.sum(), u.sum());
            p += y * mx[a] + u * mv[a];
            r += y * mv[a] - u * force[a];
            p_error += y_size * mx_error[a] + u_size * mv_error[a];
            r_error += y_size * mv_error[a] + u_size * force_error[a];
        }
        if i == j {
            self.diagonal[i] = p.abs();
            self.values[i] = r.over(p);
        } else {
            p_error += p.sum();
            r_error += r.sum();
        }
        self.shares.put((i, j), p_error * grow);
        self.rates.put((i, j), r_error * grow);
    }

    /// 1 where the share of row i leaves the diagonal of P by far the largest number of it, which is about 1.
    #[inline(always)]
    fn has_room(&self, i: usize, share: Lane) -> Lane {
        Lane::splat(ROOM).above((self.diagonal[i] - Lane::ONE).abs()) * Lane::splat(2.0 * ROOM).above(share)
    }

    /// The radius of disc i with the weight t of k; infinite where that leaves no room.
    #[inline(always)]
    fn disc(&self, i: usize, k: usize, t: Lane, grow: Lane) -> Lane {
        let (size, share) = (self.values[i].sum(), self.shares.row(i, k, t) * grow);
        let radius = (self.rates.row(i, k, t) + size * share) / (self.diagonal[i] - share);
        // The quotient λ_i is off by 11 u |λ_i| at most, and by no more than underflow takes from numbers that are
        // divided by about 1.
        let radius = (radius + size * Lane::splat(16.0 * U) + Lane::splat(TINY)) * grow;
        radius.choose(self.has_room(i, share), Lane::splat(f64::INFINITY))
    }

    /// The radius of disc k with the weight that leaves the others a quarter of the distance, and whether it meets
    /// none of them.
    #[inline(always)]
    fn separate(&mut self, k: usize, grow: Lane) {
        let size = 2 * self.n;
        let apart = |i: usize| (self.values[i] - self.values[k]).abs();
        let mut most = Lane::splat(1.0 / LARGEST_WEIGHT);
        for i in (0..size).filter(|i| *i != k) {
            let (e, f) = (self.rates.entries[i * size + k], self.shares.entries[i * size + k]);
            let share = Lane::splat(4.0) * (e + self.values[i].sum() * f) / apart(i);
            most = share.max(Lane::splat(4.0 / ROOM) * f).max(most);
        }
        let t = (Lane::ONE / most).max(Lane::ONE);
        let radius = self.disc(k, k, t, grow);
        let mut alone = Lane::ONE;
        for i in (0..size).filter(|i| *i != k) {
            let reach = (radius + self.disc(i, k, t, grow)) * grow;
            alone = alone * apart(i).above(reach);
        }
        self.radii[k] = radius;
        self.alone[k] = alone;
    }

    /// Gives the discs of a set that are not alone the radius of all that overlap.
    #[inline(always)]
    fn join(&mut self, lane: usize) {
        let size = 2 * self.n;
        if (0..size).all(|k| self.alone[k].0[lane] == 1.0) {
            return;
        }
        let radius = |k: usize| self.plain[k].0[lane];
        let is_known = (0..size).all(|k| radius(k).is_finite());
        let apart = |i: usize, j: usize| {
            let difference = self.values[i].get(lane) - self.values[j].get(lane);
            difference.re.hypot(difference.im)
        };
        let members = &mut self.members;
        for k in (0..size).filter(|k| self.alone[*k].0[lane] == 0.0) {
            members.clear();
            members.push(k);
            let mut at = 0;
            while let Some(i) = members.get(at).copied() {
                for j in 0..size {
                    let is_apart = apart(i, j) > (radius(i) + radius(j)) * growth(size);
                    if !is_apart && !members.contains(&j) {
                        members.push(j);
                    }
                }
                at += 1;
            }
            let farthest = members.iter().fold(0.0_f64, |most, j| most.max(apart(k, *j) + radius(*j)));
            self.radii[k].0[lane] = if is_known { farthest * growth(size) } else { f64::INFINITY };
        }
    }
}
