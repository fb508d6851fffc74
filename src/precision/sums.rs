//! Sums of products of mirrored rows, with the vector instructions that the machine has.

use pulp::{Arch, Simd, WithSimd};

use super::double::{DoubleDouble, product_error, two_sum};
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
        for ((x, y), i) in left.iter().zip(right.iter().rev()).zip(0..) {
            let i: usize = i;
            add_product::<FUSED>(*x, *y, &mut high[i], &mut low[i]);
        }
        let part = |i: usize| DoubleDouble::new(high[i], low[i]);
        (part(0) + part(1)) + (part(2) + part(3))
    }
}

/// high + low <- high + low + x y.
#[inline(always)]
fn add_product<const FUSED: bool>(x: DoubleDouble, y: DoubleDouble, high: &mut f64, low: &mut f64) {
    let p = x.hi * y.hi;
    let error = if FUSED {
        x.hi.mul_add(y.hi, -p)
    } else {
        product_error(x.hi, y.hi, p)
    };
    let rest = error + (x.hi * y.lo + x.lo * y.hi);
    let (sum, left) = two_sum(*high, p);
    *high = sum;
    *low += left + rest;
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
