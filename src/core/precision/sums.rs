//! Sums of products of mirrored rows, with the vector instructions that the machine has.

use super::ball::{Ball, U2};
use super::double::{DoubleDouble, power_of_two, product_error, two_sum};
use super::lane::{LANES, Lane, kernel};

/// Rows shorter than this are not worth several sums.
const SHORT: usize = 4;

/// Σ left_j right_(n-1-j) in double-double.
///
/// Products of the higher parts are taken apart exactly, as are the additions of their roundings; what that leaves over is
/// summed in doubles, which costs some n u² of the sum of magnitudes (T. Ogita, S. M. Rump, S. Oishi, SIAM J. Sci. Comput.
/// 26 (2005) 1955). Whether products are fused makes no difference to the parts.
pub(super) fn convolution(left: &[DoubleDouble], right: &[DoubleDouble]) -> Option<DoubleDouble> {
    if left.len() < SHORT {
        let products = left.iter().zip(right.iter().rev());
        return products.map(|(x, y)| *x * *y).reduce(|sum, x| sum + x);
    }
    Some(doubled(left, right))
}

kernel!(doubled, doubled_loops, (left: &[DoubleDouble], right: &[DoubleDouble]) -> DoubleDouble);

#[inline(always)]
fn doubled_loops<const FUSED: bool>(left: &[DoubleDouble], right: &[DoubleDouble]) -> DoubleDouble {
    let (blocks, left) = left.as_chunks::<4>();
    let (right, mirrored) = right.as_rchunks::<4>();
    let (mut high, mut low) = ([0.0; 4], [0.0; 4]);
    for (x, y) in blocks.iter().zip(mirrored.iter().rev()) {
        for i in 0..4 {
            add_product::<FUSED>(x[i], y[3 - i], &mut high[i], &mut low[i]);
        }
    }
    for (i, (x, y)) in left.iter().zip(right.iter().rev()).enumerate() {
        add_product::<FUSED>(*x, *y, &mut high[i], &mut low[i]);
    }
    let part = |i: usize| DoubleDouble::new(high[i], low[i]);
    (part(0) + part(1)) + (part(2) + part(3))
}

/// high + low <- high + low + x y; gives what was added to `low`.
#[inline(always)]
fn add_product<const FUSED: bool>(x: DoubleDouble, y: DoubleDouble, high: &mut f64, low: &mut f64) -> f64 {
    let p = x.hi * y.hi;
    let error = if FUSED { x.hi.mul_add(y.hi, -p) } else { product_error(x.hi, y.hi, p) };
    let rest = error + (x.hi * y.lo + x.lo * y.hi);
    let (sum, left) = two_sum(*high, p);
    *high = sum;
    let left = left + rest;
    *low += left;
    left
}

kernel!(
/// Σ left_j right_(n-1-j), enclosed. `None` where a factor is none, or so large or small that products leave their range: then
/// each operation has to look after itself.
///
/// With factors a = h + l, |l| <= u |h|, and radii r, four sums side by side are taken of every fourth product each; for one
/// of these with m terms let P be the sum of |h h'|, Q that of the |q| that are added to its lower part, R that of
/// |h| r' + |h'| r + r r'. As 2^-480 <= |h| <= 2^480 or h = 0, nothing overflows, and products of higher parts are split
/// exactly. What the sum of middles is off by (T. Ogita, S. M. Rump, S. Oishi, SIAM J. Sci. Comput. 26 (2005) 1955):
/// dropping l l' costs u² |h h'|; the products and sums of the rest of a term, none of them above 3 u |h h'| (1 + u)², are
/// four and cost 7 u² |h h'|; together with all higher powers of u, and with 2^-1074 for each of two products that may
/// underflow, which is below u² |h h'|/2^8, less than 8.5 u² P. Rounding q costs u |q| each, and the m additions to the
/// lower part, the first of which is exact and which stays below Q (1 + m u), cost (m - 1) u Q: together less than m u Q
/// (1 + m u). The higher parts are added without loss. Where Q is 0, and in each product one factor is exactly 0 or both have
/// neither lower part nor radius, nothing was lost at all. The product of numbers in the balls is off from that of the middles by at most |a| r' + |a'| r + r r', that is R (1 + u)
/// in all. Every bound is a sum of at most 4 n + 16 nonnegative roundings, each of them worth a factor 1 + u, and of 3 n that lose at most
/// 2^-1074 to underflow.
pub(super) convolution_of_balls, ball_loops, (left: &[Ball], right: &[Ball]) -> Option<Ball>);

/// Rows of balls shorter than this are multiplied one by one.
pub(super) const SHORT_FOR_BALLS: usize = SHORT;

/// One of the sums side by side; the letters are those of [`convolution_of_balls`].
struct Sums {
    high: [f64; 4],
    low: [f64; 4],
    p: [f64; 4],
    q: [f64; 4],
    r: [f64; 4],
    /// Of the lower parts and radii of the factors, but where one of them is exactly 0.
    rest: [f64; 4],
    /// Whether all factors are in range.
    fine: [bool; 4],
}

impl Sums {
    #[inline(always)]
    fn add<const FUSED: bool>(&mut self, i: usize, x: &Ball, y: &Ball) {
        let q = add_product::<FUSED>(x.mid, y.mid, &mut self.high[i], &mut self.low[i]);
        let (a, b) = (x.mid.hi.abs(), y.mid.hi.abs());
        self.p[i] += a * b;
        self.q[i] += q.abs();
        self.r[i] += (a * y.radius + b * x.radius) + x.radius * y.radius;
        let nothing = (a == 0.0) & (x.radius == 0.0) | (b == 0.0) & (y.radius == 0.0);
        let rest = (x.mid.lo.abs() + y.mid.lo.abs()) + (x.radius + y.radius);
        self.rest[i] += if nothing { 0.0 } else { rest };
        let in_range = |h: f64| (h == 0.0) | (LEAST..=MOST).contains(&h);
        self.fine[i] &= in_range(a) & in_range(b);
    }
}

/// Factors from here to there have products that can be taken apart.
const LEAST: f64 = power_of_two(-480);
const MOST: f64 = power_of_two(480);

#[inline(always)]
fn ball_loops<const FUSED: bool>(left: &[Ball], right: &[Ball]) -> Option<Ball> {
    let terms = left.len();
    let (blocks, left) = left.as_chunks::<4>();
    let (right, mirrored) = right.as_rchunks::<4>();
    let zero = [0.0; 4];
    let mut sums = Sums { high: zero, low: zero, p: zero, q: zero, r: zero, rest: zero, fine: [true; 4] };
    for (x, y) in blocks.iter().zip(mirrored.iter().rev()) {
        for i in 0..4 {
            sums.add::<FUSED>(i, &x[i], &y[3 - i]);
        }
    }
    for (i, (x, y)) in left.iter().zip(right.iter().rev()).enumerate() {
        sums.add::<FUSED>(i, x, y);
    }
    if sums.fine != [true; 4] {
        return None;
    }
    let (n, m) = (terms as f64, (blocks.len() + 1) as f64);
    let part = |i: usize| {
        let mid = DoubleDouble::new(sums.high[i], sums.low[i]);
        if sums.q[i] == 0.0 && sums.rest[i] == 0.0 {
            return Ball::new(mid, 0.0);
        }
        let u = 0.5 * f64::EPSILON;
        let lost = 8.5 * U2 * sums.p[i] + (m * u * (1.0 + m * u)) * sums.q[i];
        let slack = 1.0 + (4.0 * n + 32.0) * f64::EPSILON;
        Ball::new(mid, (sums.r[i] + lost) * slack + n * power_of_two(-1072))
    };
    Some((part(0) + part(1)) + (part(2) + part(3)))
}

kernel!(
/// The same for eight rows at once, in doubles; of one product at least.
pub(super) convolution_of_lanes, lane_loops, (left: &[Lane], right: &[Lane]) -> Lane);

#[inline(always)]
fn lane_loops<const FUSED: bool>(left: &[Lane], right: &[Lane]) -> Lane {
    let mut sum = Lane::ZERO;
    for (x, y) in left.iter().zip(right.iter().rev()) {
        for i in 0..LANES {
            sum.0[i] += x.0[i] * y.0[i];
        }
    }
    sum
}
