//! Sums of products of mirrored rows, with the vector instructions that the machine has.

use pulp::{Arch, Simd, WithSimd};

use super::ball::{Ball, U2};
use super::double::{DoubleDouble, power_of_two, product_error, two_sum};
use super::lane::{LANES, Lane};

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
    Some(Arch::new().dispatch(Doubled { left, right }))
}

struct Doubled<'a> {
    left: &'a [DoubleDouble],
    right: &'a [DoubleDouble],
}

impl WithSimd for Doubled<'_> {
    type Output = DoubleDouble;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> DoubleDouble {
        // Where there are vectors in what is chosen at run time, there are fused products.
        if size_of::<S::f64s>() > size_of::<f64>() {
            self.sum::<true>()
        } else {
            self.sum::<{ cfg!(any(target_feature = "fma", target_arch = "aarch64")) }>()
        }
    }
}

impl Doubled<'_> {
    #[inline(always)]
    fn sum<const FUSED: bool>(self) -> DoubleDouble {
        let (blocks, left) = self.left.as_chunks::<4>();
        let (right, mirrored) = self.right.as_rchunks::<4>();
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
}

/// high + low <- high + low + x y; gives what was added to `low`.
#[inline(always)]
fn add_product<const FUSED: bool>(
    x: DoubleDouble,
    y: DoubleDouble,
    high: &mut f64,
    low: &mut f64,
) -> f64 {
    let p = x.hi * y.hi;
    let error = if FUSED {
        x.hi.mul_add(y.hi, -p)
    } else {
        product_error(x.hi, y.hi, p)
    };
    let rest = error + (x.hi * y.lo + x.lo * y.hi);
    let (sum, left) = two_sum(*high, p);
    *high = sum;
    let left = left + rest;
    *low += left;
    left
}

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
pub(super) fn convolution_of_balls(left: &[Ball], right: &[Ball]) -> Option<Ball> {
    Arch::new().dispatch(Enclosed { left, right })
}

/// Rows of balls shorter than this are multiplied one by one.
pub(super) const SHORT_FOR_BALLS: usize = SHORT;

struct Enclosed<'a> {
    left: &'a [Ball],
    right: &'a [Ball],
}

impl WithSimd for Enclosed<'_> {
    type Output = Option<Ball>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Option<Ball> {
        if size_of::<S::f64s>() > size_of::<f64>() {
            self.sum::<true>()
        } else {
            self.sum::<{ cfg!(any(target_feature = "fma", target_arch = "aarch64")) }>()
        }
    }
}

/// One of the sums side by side; the letters are those of [`convolution_of_balls`].
#[derive(Clone, Copy)]
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

impl Enclosed<'_> {
    #[inline(always)]
    fn sum<const FUSED: bool>(self) -> Option<Ball> {
        let (blocks, left) = self.left.as_chunks::<4>();
        let (right, mirrored) = self.right.as_rchunks::<4>();
        let zero = [0.0; 4];
        let mut sums = Sums {
            high: zero,
            low: zero,
            p: zero,
            q: zero,
            r: zero,
            rest: zero,
            fine: [true; 4],
        };
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
        #[allow(clippy::cast_precision_loss)] // rows are short
        let (n, m) = (self.left.len() as f64, (blocks.len() + 1) as f64);
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
}

/// The same for eight rows at once, in doubles.
pub(super) fn convolution_of_lanes(left: &[Lane], right: &[Lane]) -> Option<Lane> {
    if left.is_empty() {
        return None;
    }
    Some(Arch::new().dispatch(SideBySide { left, right }))
}

struct SideBySide<'a> {
    left: &'a [Lane],
    right: &'a [Lane],
}

impl WithSimd for SideBySide<'_> {
    type Output = Lane;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Lane {
        let mut sum = Lane::ZERO;
        for (x, y) in self.left.iter().zip(self.right.iter().rev()) {
            for i in 0..LANES {
                sum.0[i] += x.0[i] * y.0[i];
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::{LANES, Scalar};
    use dashu_ratio::RBig;
    use proptest::prelude::*;

    #[test]
    fn exact_sums_stay_exact_and_what_is_out_of_range_is_left() {
        let whole: Vec<Ball> = (0..9).map(|k| Ball::exact(f64::from(k))).collect();
        assert_eq!(Ball::convolution(&whole, &whole), Some(Ball::exact(84.0)));
        assert_eq!(
            convolution_of_balls(&[Ball::ZERO; 5], &whole[..5]),
            Some(Ball::ZERO)
        );
        // What is 0 exactly stays so beside anything, and radii that get lost in a product do not.
        let doubtful = vec![Ball::new(DoubleDouble::ONE, 1e-20); 6];
        assert_eq!(
            convolution_of_balls(&[Ball::ZERO; 6], &doubtful),
            Some(Ball::ZERO)
        );
        let small = vec![Ball::new(DoubleDouble::exact(1e-140), 1e-200); 6];
        let smaller = vec![Ball::exact(1e-140); 6];
        assert!(convolution_of_balls(&small, &smaller).unwrap().radius > 0.0);
        for odd in [Ball::exact(1e-200), Ball::exact(1e200), Ball::NOT_FINITE] {
            let mut row = whole.clone();
            row[3] = odd;
            assert_eq!(convolution_of_balls(&row, &whole), None);
            let found = Ball::convolution(&row, &whole).unwrap();
            assert_eq!(found.is_finite(), odd.is_finite());
        }
    }

    fn rational(x: DoubleDouble) -> RBig {
        RBig::try_from(x.hi).unwrap() + RBig::try_from(x.lo).unwrap()
    }

    fn size(x: RBig) -> RBig {
        if x < RBig::ZERO { -x } else { x }
    }

    fn rows() -> impl Strategy<Value = Vec<(DoubleDouble, DoubleDouble)>> {
        let number = (-1.0..1.0f64, -1.0..1.0f64, -20..20i32)
            .prop_map(|(a, b, e)| DoubleDouble::new(a, b * a * f64::EPSILON / 2.0).scale(e));
        let other = (-1.0..1.0f64, -1.0..1.0f64)
            .prop_map(|(a, b)| DoubleDouble::new(a, b * a * f64::EPSILON / 2.0));
        prop::collection::vec((number, other), 0..40)
    }

    proptest! {
        #[test]
        fn convolutions_of_balls_enclose(
            rows in rows(),
            radii in prop::collection::vec((0..4usize, 0..4usize, -1.0..=1.0f64, -1.0..=1.0f64), 40),
        ) {
            let sizes = [0.0, 1e-30, 1e-12, 0.5];
            let mut exact = RBig::ZERO;
            let (mut left, mut right) = (Vec::new(), Vec::new());
            for ((x, y), (r, s, t, v)) in rows.iter().zip(&radii) {
                let (x, y) = (Ball::new(*x, sizes[*r]), Ball::new(*y, sizes[*s]));
                let inside = |ball: &Ball, share: f64| {
                    rational(ball.mid) + RBig::try_from(ball.radius).unwrap() * RBig::try_from(share).unwrap()
                };
                exact += inside(&x, *t) * inside(&y, *v);
                left.push(x);
                right.push(y);
            }
            right.reverse();
            let found = Ball::convolution(&left, &right);
            prop_assert_eq!(found.is_none(), left.is_empty());
            let Some(found) = found else { return Ok(()) };
            let off = size(rational(found.mid) - exact);
            prop_assert!(off <= RBig::try_from(found.radius).unwrap());
            // Hardly wider than one product after the other.
            let simple = crate::precision::scalar::one_by_one(&left, &right).unwrap();
            let products = left.iter().zip(right.iter().rev());
            let sum: f64 = products.map(|(x, y)| (x.mid.hi * y.mid.hi).abs()).sum();
            prop_assert!(found.radius <= simple.radius * (1.0 + 1e-9) + 40.0 * U2 * sum + 1e-300);
            let fused = Enclosed { left: &left, right: &right }.sum::<true>();
            let taken_apart = Enclosed { left: &left, right: &right }.sum::<false>();
            prop_assert_eq!(fused, taken_apart);
        }

        #[test]
        fn convolutions_are_sums_of_mirrored_products(rows in rows()) {
            let (left, right): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
            let products = || left.iter().zip(right.iter().rev());
            let mut exact = RBig::ZERO;
            let mut sum = RBig::ZERO;
            for (x, y) in products() {
                let product = rational(*x) * rational(*y);
                exact += &product;
                sum += size(product);
            }
            let found = convolution(&left, &right);
            prop_assert_eq!(found.is_none(), left.is_empty());
            if let Some(found) = found {
                // 40 terms, each of which costs some units of u² of the sum of magnitudes.
                let u2 = RBig::try_from(f64::EPSILON * f64::EPSILON / 4.0).unwrap();
                prop_assert!(size(rational(found) - &exact) <= u2 * RBig::from(100) * &sum);
                if left.len() >= SHORT {
                    let own = |fused: bool| {
                        let doubled = Doubled { left: &left, right: &right };
                        if fused { doubled.sum::<true>() } else { doubled.sum::<false>() }
                    };
                    // Vector instructions or none: the same bits.
                    prop_assert_eq!(own(true), own(false));
                    prop_assert_eq!(own(true), found);
                }
            }
            // In doubles, one row or eight.
            let doubles = |row: &[DoubleDouble]| row.iter().map(|x| x.hi).collect::<Vec<f64>>();
            let (left, right) = (doubles(&left), doubles(&right));
            let plain = f64::convolution(&left, &right);
            prop_assert_eq!(plain.is_none(), left.is_empty());
            let lanes = |row: &[f64]| row.iter().map(|x| Lane::splat(*x)).collect::<Vec<Lane>>();
            let lanes = convolution_of_lanes(&lanes(&left), &lanes(&right));
            if let (Some(plain), Some(lanes)) = (plain, lanes) {
                let simple = left.iter().zip(right.iter().rev()).fold(0.0, |sum, (x, y)| sum + x * y);
                prop_assert_eq!(lanes.0, [simple; LANES]);
                let products = left.iter().zip(right.iter().rev());
                let sum: f64 = products.map(|(x, y)| (x * y).abs()).sum();
                prop_assert!((plain - simple).abs() <= 80.0 * f64::EPSILON * sum);
            }
        }
    }
}
