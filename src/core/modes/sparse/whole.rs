//! All modes of tridiagonal K and diagonal M, in n² operations.
//!
//! T = M^(-1/2) K M^(-1/2) is tridiagonal too, enclosed entry by entry. faer finds its eigenvalues in doubles; vectors come from twisted
//! factorizations of T - θ (see `twisted`), and a step of Newton's method with the same factors and the residual in double-double leaves
//! vectors of two doubles. What is proved then takes lengths of residuals alone, ρ = ‖T x - θ x‖ / ‖x‖:
//!
//! ```text
//!   |λ - θ| <= ρ for some eigenvalue λ, so that n intervals of which none meets another have one each;
//!   |λ - xᵀTx / xᵀx| <= ρ² / gap (Kato, Temple) and sin φ <= ρ / gap (Davis, Kahan) for their distance from the others
//! ```
//!
//! (B. Parlett, The Symmetric Eigenvalue Problem, chapters 4 and 10, 11). Where intervals meet, nothing is said.

use faer::Par;
use faer::diag::{DiagMut, DiagRef};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::evd::tridiagonal_self_adjoint_evd;
use faer::linalg::temp_mat_scratch;

use super::super::levels::shapes;
use super::super::shape::{Shape, finish};
use super::super::spectrum::{mode, stability};
use super::super::{Kind, Mode, Options, PrecisionLevel, Spectrum};
use super::SparseProblem;
use super::rows::{Rows, U};
use crate::order::Order;
use crate::precision::{Ball, DoubleDouble, LANES, Lane, Pair, U2, kernel, lane_product, two_sum, up};

/// Most steps of Newton's method.
const STEPS: usize = 3;
/// Vectors are good enough where their residual is this part of the gap.
const ENOUGH: f64 = 1e-17;
/// Added to every length, for what underflows.
const TINY: f64 = 1e-280;

/// T, and what its vectors are multiplied by to be those of the problem.
struct Band {
    diagonal: Vec<DoubleDouble>,
    /// The entry right of the diagonal, 0 in the last row.
    side: Vec<DoubleDouble>,
    /// 1/√m.
    weights: Vec<Ball>,
    /// Bounds in length of the magnitudes of T and of its radii.
    size: f64,
    radius: f64,
}

/// An eigenpair: θ and its step to the quotient of Rayleigh, ρ, the vector in the coordinates of the problem and a bound of what its
/// components were rounded by.
struct Found {
    theta: DoubleDouble,
    step: f64,
    residual: f64,
    vector: Vec<f64>,
    rounded: f64,
}

/// All modes. `None` where M is not diagonal or K not tridiagonal, intervals meet, or digits are missing that are wanted. `zero_vectors` as for
/// [`super::solve_sparse`].
pub fn solve_tridiagonal(
    problem: &SparseProblem,
    zero_vectors: &mut dyn FnMut() -> Vec<Vec<Ball>>,
    options: &Options,
) -> Option<Spectrum> {
    let band = Band::new(problem)?;
    let starts = band.eigenvalues()?;
    let pairs = band.pairs(&starts, options.vectors);
    let gaps = band.gaps(&pairs)?;
    let own = |(found, gap): (&Found, &f64)| band.enclosed(found, *gap);
    let mut values: Vec<Ball> = pairs.iter().zip(&gaps).map(own).collect();
    let mut zero = None;
    if let Some(at) = pairs.iter().position(|own| own.theta.hi.abs() <= own.residual * 1.001)
        && let [vector] = zero_vectors().as_slice()
    {
        // Whether K z may be 0.
        if !Rows::new(&problem.stiffness).times_balls(vector).iter().all(Ball::contains_zero) {
            return None;
        }
        // The only interval with a 0 in it, which is an eigenvalue.
        values[at] = Ball::ZERO;
        zero = Some((at, band.zero_shape(vector)));
    }
    let widest = band.weights.iter().fold(0.0_f64, |most, w| most.max(w.abs_upper()));
    let mut modes: Vec<Mode> = Vec::with_capacity(values.len());
    for (at, ((found, gap), value)) in pairs.into_iter().zip(gaps).zip(values).enumerate() {
        let number = modes.len() as u32;
        let mut shape = options.vectors.then(|| {
            // A unit vector at an angle φ is off by no more than √2 sin φ.
            let turned = 1.5 * found.residual / gap;
            (turned, finish(found.vector, up(turned * widest + found.rounded)))
        });
        let kind = match &mut zero {
            Some((zero, own)) if *zero == at => {
                shape = shape.and_then(|_| Some((0.0, own.take()?)));
                Kind::Zero
            }
            Some(_) | None if value.is_positive() => Kind::Oscillation,
            Some(_) | None => Kind::Unstable,
        };
        let is_good = shape.as_ref().is_none_or(|(turned, _)| *turned < shapes(options));
        if kind != Kind::Zero && !options.covers(&value, true) || !is_good {
            return None;
        }
        modes.push(mode((value, 0), None, kind, shape.map(|(_, shape)| shape), number));
    }
    let count = |kind| modes.iter().filter(|mode| mode.kind == kind).count();
    let stability = stability(count(Kind::Unstable), 0, count(Kind::Zero));
    Some(Spectrum { modes, stability, level: PrecisionLevel::Refined })
}

impl Band {
    fn new(problem: &SparseProblem) -> Option<Self> {
        let SparseProblem { mass, stiffness } = problem;
        let n = mass.dimension();
        if mass.bandwidth() > 0 || stiffness.bandwidth() > 1 || mass.stored() < n || n == 0 {
            return None;
        }
        let positive = |value: &Ball| value.is_positive().then(|| (Ball::ONE / *value).sqrt());
        let weights: Vec<Ball> = mass.entries().map(|(_, _, value)| positive(value)).collect::<Option<_>>()?;
        let (mut diagonal, mut side) = (vec![Ball::ZERO; n], vec![Ball::ZERO; n]);
        for (i, j, value) in stiffness.entries() {
            let entry = *value * weights[i] * weights[j];
            let to = if i == j { &mut diagonal } else { &mut side };
            to[j] = entry;
        }
        let row = |i: usize, of: &dyn Fn(&Ball) -> f64| {
            let before = i.checked_sub(1).map_or(0.0, |before| of(&side[before]));
            up(before + of(&diagonal[i]) + of(&side[i]))
        };
        let most = |of: &dyn Fn(&Ball) -> f64| (0..n).map(|i| row(i, of)).fold(0.0, f64::max);
        let (size, radius) = (most(&Ball::abs_upper), most(&|entry: &Ball| entry.radius));
        // Parts that do not know of each other may have equal eigenvalues; squares of what is far from 1 leave the range.
        let whole = side[..n - 1].iter().all(|entry| !entry.contains_zero());
        let usual = size > 1e-100 && size < 1e100 && weights.iter().all(|w| w.radius <= 1e-25 * w.mid.hi);
        let mid = |entries: Vec<Ball>| entries.into_iter().map(|entry| entry.mid).collect();
        (whole && usual).then(|| Self { diagonal: mid(diagonal), side: mid(side), weights, size, radius })
    }

    /// Eigenvalues in doubles, ascending.
    fn eigenvalues(&self) -> Option<Vec<f64>> {
        let n = self.diagonal.len();
        let doubles = |own: &[DoubleDouble]| -> Vec<f64> { own.iter().map(|entry| entry.hi).collect() };
        let (diagonal, side) = (doubles(&self.diagonal), doubles(&self.side));
        let mut values = vec![0.0; n];
        let mut memory = MemBuffer::new(StackReq::all_of(&[temp_mat_scratch::<f64>(n, 1); 2]));
        tridiagonal_self_adjoint_evd(
            DiagRef::from_slice(&diagonal),
            DiagRef::from_slice(&side),
            DiagMut::from_slice_mut(&mut values),
            None,
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        )
        .ok()?;
        values.order_by(f64::total_cmp);
        Some(values)
    }

    /// Eigenpairs from approximations of all eigenvalues.
    fn pairs(&self, starts: &[f64], vectors: bool) -> Vec<Found> {
        let n = starts.len();
        let mut work = Work::new(n);
        let mut pairs = Vec::with_capacity(n);
        for (number, chunk) in starts.chunks(LANES).enumerate() {
            let (mut theta, mut gaps) = (Lane::splat(chunk[0]), Lane::splat(f64::INFINITY));
            for (l, start) in chunk.iter().enumerate() {
                let at = number * LANES + l;
                let below = at.checked_sub(1).map_or(f64::INFINITY, |before| start - starts[before]);
                let above = starts.get(at + 1).map_or(f64::INFINITY, |next| next - start);
                (theta.0[l], gaps.0[l]) = (*start, below.min(above));
            }
            let measured = eight(self, theta, gaps, &mut work);
            let mut own = vec![vec![0.0; n]; if vectors { chunk.len() } else { 0 }];
            let rounded = eight_shapes(self, &work.x, &measured, &mut own);
            let mut own = own.into_iter();
            pairs.extend((0..chunk.len()).map(|l| {
                let theta = DoubleDouble { hi: measured.theta.high.0[l], lo: measured.theta.low.0[l] };
                let (step, rest) = (measured.step.0[l], measured.residual.0[l]);
                // See `measure`.
                let error = 100.0 * U2 * (self.size + theta.hi.abs()) + self.radius;
                let residual = up(rest * (1.0 + 1e-9) + error + TINY);
                Found { theta, step, residual, vector: own.next().unwrap_or_default(), rounded: rounded.0[l] }
            }));
        }
        pairs
    }

    /// How far each θ is from the intervals of the others at least; `None` where intervals meet.
    fn gaps(&self, pairs: &[Found]) -> Option<Vec<f64>> {
        let mut gaps = vec![f64::INFINITY; pairs.len()];
        for (at, pair) in pairs.windows(2).enumerate() {
            let [a, b] = pair else { continue };
            let apart = (b.theta.hi - a.theta.hi) + (b.theta.lo - a.theta.lo);
            let apart = apart * (1.0 - 1e-14) - 8.0 * U2 * self.size;
            // What is no number is no distance.
            let is_apart = apart > (a.residual + b.residual) * 1.001;
            if !is_apart {
                return None;
            }
            gaps[at] = f64::min(gaps[at], apart - b.residual * 1.001);
            gaps[at + 1] = apart - a.residual * 1.001;
        }
        Some(gaps)
    }

    /// The eigenvalue: the quotient is within ρ of θ; its step is a sum of n products over ‖x‖².
    fn enclosed(&self, found: &Found, gap: f64) -> Ball {
        let own = found.residual;
        let rounding = (self.diagonal.len() + 16) as f64 * 2.0 * U * own;
        let error = 100.0 * U2 * (self.size + found.theta.hi.abs()) + self.radius;
        let radius = error + rounding + own * own / (gap - own);
        Ball::new(found.theta + DoubleDouble::exact(found.step), up(radius))
    }

    /// A vector of the kernel with xᵀMx = 1.
    fn zero_shape(&self, vector: &[Ball]) -> Option<Shape> {
        let scaled = vector.iter().zip(&self.weights).map(|(x, w)| *x / *w);
        let square = scaled.fold(Ball::ZERO, |sum, x| sum + x * x);
        let unit: Vec<Ball> = vector.iter().map(|x| *x / square.sqrt()).collect();
        let error = unit.iter().fold(0.0_f64, |most, x| most.max(x.mid_f64_error()));
        error.is_finite().then(|| finish(unit.iter().map(Ball::mid_f64).collect(), error))
    }
}

/// What eight pairs are worked on with, one element a coordinate.
struct Work {
    /// L and U below and above their diagonals of 1, by the row above.
    down: Vec<Lane>,
    up: Vec<Lane>,
    x: Vec<Pair>,
    r: Vec<Lane>,
    c: Vec<Lane>,
}

impl Work {
    fn new(n: usize) -> Self {
        let lanes = || vec![Lane::ZERO; n];
        Self { down: lanes(), up: lanes(), x: vec![Pair::ZERO; n], r: lanes(), c: lanes() }
    }
}

/// Sums of eight pairs.
struct Sums {
    /// ‖x‖²
    square: Pair,
    /// xᵀr
    product: Lane,
    /// ‖r‖²
    rest: Lane,
}

/// What is measured of eight pairs: ‖x‖², xᵀ(T x - θ x) / ‖x‖², ‖T x - θ x‖ / ‖x‖.
struct Measured {
    theta: Pair,
    square: Pair,
    step: Lane,
    residual: Lane,
}

kernel!(
/// Eight eigenpairs from eigenvalues in doubles.
eight, eight_loops, (band: &Band, theta: Lane, gaps: Lane, work: &mut Work) -> Measured);

#[inline(always)]
fn eight_loops<const FUSED: bool>(band: &Band, theta: Lane, gaps: Lane, work: &mut Work) -> Measured {
    let twist = work.factor(band, theta);
    work.vector(twist);
    let mut theta = Pair { high: theta, low: Lane::ZERO };
    let enough = gaps * Lane::splat(ENOUGH);
    let mut steps = 0;
    loop {
        let Sums { square, product, rest } = work.measure::<FUSED>(band, &theta);
        let step = product / square.high;
        let residual = (rest / square.high).sqrt();
        if steps == STEPS || !residual.above(enough).any() {
            return Measured { theta, square, step, residual };
        }
        let (high, low) = two_sum(theta.high, step);
        theta = Pair { high, low: theta.low + low }.settled();
        work.correct(band, twist, step);
        steps += 1;
    }
}

impl Work {
    /// The factors of T - θ from both ends; gives where they meet.
    #[inline(always)]
    fn factor(&mut self, band: &Band, theta: Lane) -> Lane {
        let n = self.x.len();
        let least = Lane::splat(band.size * 1e-40);
        let side = |i: usize| Lane::splat(band.side[i].hi);
        let base = |i: usize| Lane::splat(band.diagonal[i].hi) - theta;
        let guarded = |pivot: Lane| pivot.choose(pivot.abs().above(least), least);
        let mut before = Lane::ZERO;
        for i in 0..n {
            let ratio = side(i) / guarded(base(i) - before);
            self.down[i] = ratio;
            before = side(i) * ratio;
        }
        let (mut meet, mut twist) = (Lane::splat(f64::INFINITY), Lane::ZERO);
        let mut before = Lane::ZERO;
        for i in (0..n).rev() {
            let pivot = base(i) - before;
            let gamma = if i > 0 { pivot - side(i - 1) * self.down[i - 1] } else { pivot };
            let nearer = meet.abs().above(gamma.abs());
            meet = gamma.choose(nearer, meet);
            twist = Lane::splat(i as f64).choose(nearer, twist);
            if i > 0 {
                let ratio = side(i - 1) / guarded(pivot);
                self.up[i - 1] = ratio;
                before = side(i - 1) * ratio;
            }
        }
        twist
    }

    /// The vector that is 1 where the factors meet.
    #[inline(always)]
    fn vector(&mut self, twist: Lane) {
        let n = self.x.len();
        let mut before = Lane::ZERO;
        for i in (0..n).rev() {
            before = (-self.down[i] * before).choose((Lane::splat(i as f64) - twist).abs(), Lane::ONE);
            self.x[i] = Pair { high: before, low: Lane::ZERO };
        }
        for i in 1..n {
            let after = -self.up[i - 1] * self.x[i - 1].high;
            self.x[i].high = after.choose(Lane::splat(i as f64).above(twist), self.x[i].high);
        }
    }

    /// The sums with r = T x - θ x.
    ///
    /// r is summed in double-double from four products, of magnitudes with the sum P: products of high parts are taken apart exactly, as
    /// are their sums; what is added to the lower part is at most 6 u P and rounded less than ten times, and products of low parts are
    /// left out. So r is off by less than 100 u² P, and by u of itself.
    #[inline(always)]
    fn measure<const FUSED: bool>(&mut self, band: &Band, theta: &Pair) -> Sums {
        let n = self.x.len();
        let minus = Pair { high: -theta.high, low: -theta.low };
        let (mut square, mut product, mut rest) = (Pair::ZERO, Lane::ZERO, Lane::ZERO);
        let mut side = Pair::ZERO;
        for i in 0..n {
            let x = self.x[i];
            let mut sum = Pair::ZERO;
            add_product::<FUSED>(&mut sum, &Pair::splat(band.diagonal[i]), &x);
            add_product::<FUSED>(&mut sum, &minus, &x);
            if i > 0 {
                add_product::<FUSED>(&mut sum, &side, &self.x[i - 1]);
            }
            side = Pair::splat(band.side[i]);
            if i + 1 < n {
                add_product::<FUSED>(&mut sum, &side, &self.x[i + 1]);
            }
            let r = sum.high + sum.low;
            self.r[i] = r;
            product += x.high * r;
            rest += r * r;
            add_product::<FUSED>(&mut square, &x, &x);
        }
        Sums { square: square.settled(), product, rest }
    }

    /// x <- x + d with (T - θ) d = step x - r but where the factors meet, and d = 0 there.
    #[inline(always)]
    fn correct(&mut self, band: &Band, twist: Lane, step: Lane) {
        let n = self.x.len();
        let over = |i: usize| Lane::splat(1.0 / band.side[i].hi);
        let mut before = Lane::ZERO;
        for i in 0..n {
            let own = step * self.x[i].high - self.r[i];
            self.r[i] = own;
            before = own - if i > 0 { self.down[i - 1] * before } else { Lane::ZERO };
            self.c[i] = before;
        }
        let (mut before, mut d) = (Lane::ZERO, Lane::ZERO);
        for i in (0..n).rev() {
            if i + 1 < n {
                before = self.r[i] - self.up[i] * before;
                let own = self.down[i] * (self.c[i] * over(i) - d);
                d = own.choose(twist.above(Lane::splat(i as f64)), Lane::ZERO);
            } else {
                before = self.r[i];
            }
            self.r[i] = before;
            self.c[i] = d;
        }
        let mut d = Lane::ZERO;
        for i in 0..n {
            if i > 0 {
                let own = self.up[i - 1] * (self.r[i] * over(i - 1) - d);
                d = own.choose(Lane::splat(i as f64).above(twist), self.c[i]);
            } else {
                d = self.c[i];
            }
            let (high, low) = two_sum(self.x[i].high, d);
            self.x[i] = Pair { high, low: self.x[i].low + low }.settled();
        }
    }
}

/// sum + a x; see [`Work::measure`].
#[inline(always)]
fn add_product<const FUSED: bool>(sum: &mut Pair, a: &Pair, x: &Pair) {
    let (product, error) = lane_product::<FUSED>(a.high, x.high);
    let (high, rest) = two_sum(sum.high, product);
    sum.high = high;
    sum.low += rest + (error + (a.high * x.low + a.low * x.high));
}

kernel!(
/// Eight vectors as shapes: x / ‖x‖ times 1/√m, rounded to doubles; gives what components are off by at most.
///
/// ‖x‖² is off by less than 4 (n + 8)² u² of itself, which the root halves, root, quotient and products by 40 u², the weights by their
/// radii.
eight_shapes, shape_loops, (band: &Band, x: &[Pair], measured: &Measured, vectors: &mut [Vec<f64>]) -> Lane);

#[inline(always)]
fn shape_loops<const FUSED: bool>(band: &Band, x: &[Pair], measured: &Measured, vectors: &mut [Vec<f64>]) -> Lane {
    let mut scale = Pair::ZERO;
    for l in 0..vectors.len() {
        let own = DoubleDouble::ONE / DoubleDouble::new(measured.square.high.0[l], measured.square.low.0[l]).sqrt();
        (scale.high.0[l], scale.low.0[l]) = (own.hi, own.lo);
    }
    let n = x.len() as f64 + 8.0;
    let (mut largest, mut left) = (Lane::ZERO, Lane::ZERO);
    for (i, (x, w)) in x.iter().zip(&band.weights).enumerate() {
        let (mut unit, mut own) = (Pair::ZERO, Pair::ZERO);
        add_product::<FUSED>(&mut unit, x, &scale);
        add_product::<FUSED>(&mut own, &unit.settled(), &Pair::splat(w.mid));
        let own = own.settled();
        largest = largest.max(own.high.abs());
        left = left.max(own.low.abs());
        for (l, vector) in vectors.iter_mut().enumerate() {
            vector[i] = own.high.0[l];
        }
    }
    let relative = 2.0 * U2 * n * n + 40.0 * U2 + 2e-25;
    (left + largest * Lane::splat(relative)).map(|error| up(error + TINY))
}
