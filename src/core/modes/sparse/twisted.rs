//! Eigenpairs of tridiagonal pencils: bisection by Sturm counts, then twisted factorizations in double-double.
//!
//! K - θ M is decomposed from both ends (L D Lᵀ and U P Uᵀ); where they meet, γ_i = d_i + p_i - a_i is smallest at the largest
//! component of the eigenvector, whose other components follow by products alone, and θ + γ / xᵀMx is its Rayleigh quotient
//! (I. Dhillon, B. Parlett, "Orthogonal eigenvectors and relative gaps", SIAM J. Matrix Anal. Appl. 25 (2004) 858). With pivots of
//! 31 digits the vectors are right to rounding also where eigenvalues are 1e-16 of the largest. Nothing is proved here.

use super::rows::{Panel, Rows, squares};
use super::shifted::Pencil;
use crate::precision::{DoubleDouble, LANES, Lane, Pair, fast_two_sum, kernel, lane_product, two_sum};

/// Eigenvalues are found to this part of their size before vectors are.
const START: f64 = 1e-4;
/// Rounds of θ <- θ + γ / xᵀMx, each of which squares its error at least.
const ROUNDS: usize = 6;
/// θ is as good as it need be: the vector is off by this over the distance of the next eigenvalue, which is squared once more.
const ENOUGH: f64 = 1e-11;

/// The entries on the diagonal and beside it.
struct Band {
    diagonal: Vec<DoubleDouble>,
    /// The entry left of the diagonal; empty where all are 0.
    side: Vec<DoubleDouble>,
}

impl Band {
    fn new(rows: &Rows) -> Self {
        let n = rows.dimension();
        let mut own = Self { diagonal: vec![DoubleDouble::ZERO; n], side: vec![DoubleDouble::ZERO; n] };
        let mut is_diagonal = true;
        for i in 0..n {
            for at in rows.row(i) {
                let j = rows.columns[at] as usize;
                if j == i {
                    own.diagonal[i] = rows.value(at);
                } else if j < i {
                    own.side[i] = rows.value(at);
                    is_diagonal = false;
                }
            }
        }
        if is_diagonal {
            own.side = Vec::new();
        }
        own
    }

    #[inline(always)]
    fn side(&self, i: usize) -> DoubleDouble {
        self.side.get(i).copied().unwrap_or(DoubleDouble::ZERO)
    }
}

/// A pencil of tridiagonal matrices none of which splits.
pub(super) struct Bands<'a> {
    pencil: &'a Pencil,
    stiffness: Band,
    mass: Band,
    /// Pivots below this are replaced by it.
    least: f64,
}

impl<'a> Bands<'a> {
    /// `None` where the matrices split into parts that do not know of each other.
    pub(super) fn new(pencil: &'a Pencil) -> Option<Self> {
        let (stiffness, mass) = (Band::new(&pencil.stiffness), Band::new(&pencil.mass));
        let splits = (1..pencil.dimension()).any(|i| stiffness.side(i).hi == 0.0 && mass.side(i).hi == 0.0);
        let least = pencil.stiffness_norms.0 * pencil.least_weight * 1e-40;
        (!splits && least > 0.0).then_some(Self { pencil, stiffness, mass, least })
    }

    /// The entry of K - θ M on the diagonal.
    #[inline(always)]
    fn diagonal<const FUSED: bool>(&self, i: usize, theta: &Pair) -> Pair {
        Pair::shifted::<FUSED>(self.stiffness.diagonal[i], theta, self.mass.diagonal[i])
    }

    /// The entry left of it, 0 in the first row.
    #[inline(always)]
    fn side<const FUSED: bool>(&self, i: usize, theta: &Pair) -> Pair {
        let own = self.stiffness.side(i);
        if self.mass.side.is_empty() {
            return Pair::splat(own);
        }
        Pair::shifted::<FUSED>(own, theta, self.mass.side(i))
    }

    /// The number of eigenvalues below a shift, as doubles see it.
    pub(super) fn count(&self, shift: f64) -> usize {
        counts(self, Lane::splat(shift))[0]
    }

    /// Eigenvalues next to these and their vectors, with xᵀMx = 1 nearly; `None` where they are not found.
    pub(super) fn pairs(&self, starts: &[f64]) -> Option<(Vec<f64>, Vec<Panel>)> {
        let n = self.pencil.dimension();
        let mut values = Vec::with_capacity(starts.len());
        let mut panels = Vec::new();
        let mut down = vec![Lane::ZERO; n];
        for chunk in starts.chunks(LANES) {
            let last = chunk.last().copied().unwrap_or(0.0);
            let mut theta = Pair::splat(DoubleDouble::exact(last));
            theta.high.0.iter_mut().zip(chunk).for_each(|(own, start)| *own = *start);
            let mut z = vec![Lane::ZERO; n];
            let mut settled = false;
            for _ in 0..ROUNDS {
                let meet = twisted(self, theta, &mut down, &mut z);
                let lengths = squares(&z, &self.pencil.weights);
                let mut worst = 0.0_f64;
                for l in 0..LANES {
                    let step = meet.0[l] / lengths.0[l];
                    worst = worst.max((step / theta.high.0[l]).abs());
                    let (high, low) = two_sum(theta.high.0[l], step);
                    (theta.high.0[l], theta.low.0[l]) = fast_two_sum(high, low + theta.low.0[l]);
                }
                if worst.is_nan() {
                    return None;
                }
                settled = worst < ENOUGH;
                if settled {
                    let scale = lengths.map(|square| 1.0 / square.sqrt());
                    z.iter_mut().for_each(|x| *x = *x * scale);
                    break;
                }
            }
            if !settled {
                return None;
            }
            values.extend(theta.high.0.iter().take(chunk.len()));
            panels.push(z);
        }
        Some((values, panels))
    }

    /// Eigenvalues by their numbers from the lowest, each to a small part of its size and of its distance from the others.
    pub(super) fn bisect(&self, numbers: &std::ops::Range<usize>) -> Option<Vec<f64>> {
        let most = self.pencil.stiffness_norms.0 * 1.01;
        let floor = most * 1e-18;
        let wanted: Vec<usize> = numbers.clone().collect();
        let mut brackets: Vec<(f64, f64)> = vec![(-most, most); wanted.len()];
        for _ in 0..200 {
            let mut open: Vec<(f64, f64)> = Vec::new();
            for (i, own) in brackets.iter().enumerate() {
                let next = brackets.get(i + 1).filter(|next| next.0 < own.1);
                if (next.is_some() || !is_narrow(*own)) && open.last() != Some(own) {
                    open.push(*own);
                }
            }
            if open.is_empty() {
                break;
            }
            let each = (LANES / open.len()).max(1);
            let mut points: Vec<f64> = Vec::new();
            for (low, high) in open.into_iter().take(LANES) {
                points.extend((1..=each).map(|k| between(low, high, k as f64 / (each + 1) as f64, floor)));
            }
            points.truncate(LANES);
            let mut shifts = Lane::splat(points.first().copied()?);
            shifts.0.iter_mut().zip(&points).for_each(|(own, point)| *own = *point);
            let counts = counts(self, shifts);
            let mut moved = false;
            for (shift, count) in shifts.0.iter().zip(counts) {
                for (number, own) in wanted.iter().zip(&mut brackets) {
                    if *shift <= own.0 || *shift >= own.1 {
                        continue;
                    }
                    moved = true;
                    if count > *number { own.1 = *shift } else { own.0 = *shift }
                }
            }
            if !moved {
                return None;
            }
        }
        let ordered = brackets.windows(2).all(|pair| matches!(pair, [a, b] if a.1 <= b.0));
        ordered.then(|| brackets.iter().map(|(low, high)| 0.5 * (low + high)).collect())
    }
}

fn is_narrow((low, high): (f64, f64)) -> bool {
    (low > 0.0 || high < 0.0) && high - low <= START * low.abs().max(high.abs())
}

/// A point between two numbers: by their logarithms as far as they have the same sign.
fn between(low: f64, high: f64, part: f64, floor: f64) -> f64 {
    let by_size = |small: f64, large: f64, part: f64| (small.ln() + part * (large.ln() - small.ln())).exp();
    if low >= 0.0 {
        by_size(low.max(floor.min(0.5 * high)), high, part)
    } else if high <= 0.0 {
        -by_size((-high).max(floor.min(-0.5 * low)), -low, 1.0 - part)
    } else if part < 0.5 {
        -by_size(floor.min(-0.5 * low), -low, 1.0 - 2.0 * part)
    } else if part > 0.5 {
        by_size(floor.min(0.5 * high), high, 2.0 * part - 1.0)
    } else {
        0.0
    }
}

kernel!(
/// The number of eigenvalues below each of eight shifts, by the signs of pivots.
counts, count_loops, (bands: &Bands<'_>, shifts: Lane) -> [usize; LANES]);

#[inline(always)]
fn count_loops<const FUSED: bool>(bands: &Bands<'_>, shifts: Lane) -> [usize; LANES] {
    let n = bands.pencil.dimension();
    let shifted = |k: DoubleDouble, m: DoubleDouble| Lane::splat(k.hi) - shifts * Lane::splat(m.hi);
    let diagonal = |i: usize| shifted(bands.stiffness.diagonal[i], bands.mass.diagonal[i]);
    let side = |i: usize| shifted(bands.stiffness.side(i), bands.mass.side(i));
    let apart = |pivot: Lane| {
        let is_small = Lane::splat(bands.least).above(pivot.abs());
        Lane::splat(-bands.least).choose(is_small, pivot)
    };
    // From both ends to the row where they meet: neither division has to wait for the other.
    let meet = n / 2;
    let (mut above, mut below, mut beside) = (Lane::ONE, Lane::ONE, Lane::ZERO);
    let (mut counts, mut others) = (Lane::ZERO, Lane::ZERO);
    for at in 0..meet {
        let own = side(at);
        above = apart(diagonal(at) - own * own / above);
        counts += Lane::ZERO.above(above);
        let last = n - 1 - at;
        if last > meet {
            below = apart(diagonal(last) - beside * beside / below);
            beside = side(last);
            others += Lane::ZERO.above(below);
        }
    }
    let own = side(meet);
    counts += Lane::ZERO.above(apart(diagonal(meet) - own * own / above - beside * beside / below));
    (counts + others).0.map(|count| count as usize)
}

impl Pair {
    /// self - side² / pivot, not nearer to 0 than `least`.
    #[inline(always)]
    fn eliminated<const FUSED: bool>(&self, side: &Self, pivot: &Self, least: f64) -> Self {
        let (square, error) = lane_product::<FUSED>(side.high, side.high);
        let rest = error + (side.high + side.high) * side.low;
        let first = square / pivot.high;
        let (p, error) = lane_product::<FUSED>(first, pivot.high);
        let left = ((square - p) - error) + (rest - first * pivot.low);
        let quotient = Self::nearly_settled(first, left / pivot.high);
        let (high, low) = two_sum(self.high, -quotient.high);
        let own = Self::nearly_settled(high, low + (self.low - quotient.low));
        let is_small = Lane::splat(least).above(own.high.abs());
        Self { high: Lane::splat(least).choose(is_small, own.high), low: Lane::ZERO.choose(is_small, own.low) }
    }
}

kernel!(
/// One twisted factorization for each of eight θ and its vector; gives γ where the two ends meet. In `down` are the pivots from the
/// first row on, then the components before the meeting; in `z` the pivots from the last row on, then the vector.
twisted, twisted_loops, (bands: &Bands<'_>, theta: Pair, down: &mut [Lane], z: &mut [Lane]) -> Lane);

#[inline(always)]
fn twisted_loops<const FUSED: bool>(bands: &Bands<'_>, theta: Pair, down: &mut [Lane], z: &mut [Lane]) -> Lane {
    let n = down.len();
    let (mut above, mut below) = (Pair { high: Lane::ONE, low: Lane::ZERO }, Pair { high: Lane::ONE, low: Lane::ZERO });
    let (mut meet, mut twist) = (Lane::splat(f64::INFINITY), Lane::ZERO);
    let mut side = Pair::ZERO;
    // From both ends at once: neither division has to wait for the other.
    for at in 0..n {
        let last = n - 1 - at;
        // Without closures, in which there would be no fused instructions.
        let (here, there) = (bands.diagonal::<FUSED>(at, &theta), bands.diagonal::<FUSED>(last, &theta));
        above = here.eliminated::<FUSED>(&bands.side::<FUSED>(at, &theta), &above, bands.least);
        below = there.eliminated::<FUSED>(&side, &below, bands.least);
        side = bands.side::<FUSED>(last, &theta);
        (down[at], z[last]) = (above.high, below.high);
        if at < last {
            continue;
        }
        // Where the other end has been.
        let gamma = z[at] + ((above.high - here.high) + (above.low - here.low));
        let nearer = meet.abs().above(gamma.abs());
        (meet, twist) = (gamma.choose(nearer, meet), Lane::splat(at as f64).choose(nearer, twist));
        let gamma = down[last] + ((below.high - there.high) + (below.low - there.low));
        let nearer = meet.abs().above(gamma.abs());
        (meet, twist) = (gamma.choose(nearer, meet), Lane::splat(last as f64).choose(nearer, twist));
    }
    let (mut before, mut side) = (Lane::ZERO, Lane::ZERO);
    for i in (0..n).rev() {
        let at = Lane::splat(i as f64);
        let value = -(side / down[i]) * before;
        // 1 where the two meet.
        let not_there = (at - twist).abs();
        before = value.choose(not_there, Lane::ONE);
        down[i] = before;
        side = bands.side::<FUSED>(i, &theta).high;
    }
    for i in 0..n {
        let side = bands.side::<FUSED>(i, &theta).high;
        let value = -(side / z[i]) * before;
        before = value.choose(Lane::splat(i as f64).above(twist), down[i]);
        z[i] = before;
    }
    meet
}
