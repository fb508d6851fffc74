//! Products of matrices in double-double with a proved error bound.

use super::dense::{Columns, Matrix, Plain, multiply};
use crate::precision::{DoubleDouble, kernel, two_sum};

/// Terms summed before the result is carried over into a double-double total: with more, bounds are
/// larger; with fewer, products slower.
const BLOCK: usize = 4;
/// u = 2^-53.
const UNIT: f64 = 0.5 * f64::EPSILON;

kernel!(run_product, product_loops, (a: &Matrix, b: &Matrix, c: &mut Matrix, noise: &mut [f64], part: Part));

/// Which part of a product is computed.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Part {
    /// Every entry.
    All,
    /// The lower triangle, mirrored into the upper: for products known to be symmetric.
    Lower,
}

/// c u^2 such that every entry of [`product`] differs from the exact one by at most
/// c u^2 sum |a_k| |b_k|, u = 2^-53, for `inner` terms.
///
/// With P the sum of magnitudes over one block of b terms: a term a b is split into the exact
/// product of the high parts, p + e, and the cross terms; dropping lo lo costs u^2 |ab|, the at
/// most four roundings of the cross terms and e, none of them above 3 u |ab|, cost 7 u^2 |ab|:
/// together 8 u^2 P. Adding p to the running s is exact with remainder |r| <= u P. Rounding r + e
/// costs at most u^2 (P + 3 |ab|), in all (b + 3) u^2 P; the running t is at most k u P + 3 u P
/// after k terms, so its roundings cost (b (b + 1)/2 + 3 b) u^2 P. One more u^2 P covers the higher
/// powers of u. (This is the argument of Ogita, Rump, Oishi, "Accurate sum and dot product", SIAM J.
/// Sci. Comput. 26 (2005), for double-double data.) Each carry into the total costs 3 u^2 of the total
/// (AccurateDWPlusDW), the first none.
pub(super) fn product_bound(inner: usize) -> f64 {
    let b = inner.min(BLOCK) as f64;
    let block = 8.0 + (b + 3.0) + (0.5 * b * (b + 1.0) + 3.0 * b) + 1.0;
    let carries = inner.div_ceil(BLOCK).saturating_sub(1) as f64;
    (block + 3.1 * carries) * 2f64.powi(-106)
}

/// c u^2 such that every entry of [`measured_product`] differs from the exact one by at most
/// c u^2 sum |a_k| |b_k| and the noise beside it: what [`product_bound`] says of a term but for its sum.
pub(super) const TERM: f64 = 8.5 / (1u128 << 106) as f64;

/// The matrix product a b, and bounds of what its sums are rounded by, taken while they are formed: mostly
/// a tenth of [`product_bound`], which has to expect the worst of every sum. See [`TERM`].
///
/// With q = fl(r + e) for each term (see [`product_bound`]) and Q the sum of |q| over a block of b terms, the
/// roundings of all q cost at most u Q, and those of the running t, which are at most Q (1 + b u) and of
/// which the first is exact, (b - 1) u Q: together b u Q. Each carry into the total costs 3 u² of the new
/// total, the first none. The noise is a sum of nonnegative doubles, whose own rounding the
/// last factor covers.
pub(super) fn measured_product(a: &Matrix, b: &Matrix, part: Part) -> (Matrix, Plain) {
    let mut c = Matrix::zeros(a.rows, b.columns);
    let mut noise = Plain::zeros(a.rows, b.columns);
    run_product(a, b, &mut c, &mut noise.data, part);
    if part == Part::Lower {
        noise.mirror();
    }
    (mirrored(c, part), noise)
}

/// The matrix product a b; see [`product_bound`].
pub(super) fn product(a: &Matrix, b: &Matrix, part: Part) -> Matrix {
    let mut c = Matrix::zeros(a.rows, b.columns);
    run_product(a, b, &mut c, &mut [], part);
    mirrored(c, part)
}

fn mirrored(mut c: Matrix, part: Part) -> Matrix {
    if part == Part::Lower {
        c.mirror();
    }
    c
}

#[inline(always)]
fn product_loops<const FUSED: bool>(a: &Matrix, b: &Matrix, c: &mut Matrix, noise: &mut [f64], part: Part) {
    if noise.is_empty() {
        loops::<FUSED, false>(a, b, c, noise, part);
    } else {
        loops::<FUSED, true>(a, b, c, noise, part);
    }
}

#[inline(always)]
fn loops<const FUSED: bool, const MEASURED: bool>(
    a: &Matrix,
    b: &Matrix,
    c: &mut Matrix,
    noise: &mut [f64],
    part: Part,
) {
    let stride = a.hi.stride;
    for column in 0..b.columns {
        let (b_hi, b_lo) = (b.hi.column(column), b.lo.column(column));
        let to = column * c.hi.stride;
        let mut row = if part == Part::Lower { column & !3 } else { 0 };
        while row + 8 <= stride {
            tile::<FUSED, MEASURED, 8>(a, row, |k| k, (b_hi, b_lo), (c, noise), to + row);
            row += 8;
        }
        if row < stride {
            tile::<FUSED, MEASURED, 4>(a, row, |k| k, (b_hi, b_lo), (c, noise), to + row);
        }
    }
}

/// N rows of one column of the product: the columns of `a` at `places` times the numbers of `b`.
#[inline(always)]
fn tile<const FUSED: bool, const MEASURED: bool, const N: usize>(
    a: &Matrix,
    row: usize,
    places: impl Fn(usize) -> usize,
    (b_hi, b_lo): (&[f64], &[f64]),
    (c, noise): (&mut Matrix, &mut [f64]),
    to: usize,
) {
    let mut total = [DoubleDouble::ZERO; N];
    let mut rounded = [0.0; N];
    let mut at = 0;
    for (block_hi, block_lo) in b_hi.chunks(BLOCK).zip(b_lo.chunks(BLOCK)) {
        let mut s = [0.0; N];
        let mut t = [0.0; N];
        let mut size = [0.0; N];
        let first = at == 0;
        for (&bh, &bl) in block_hi.iter().zip(block_lo) {
            let start = places(at) * a.hi.stride + row;
            let ah = &a.hi.data[start..start + N];
            let al = &a.lo.data[start..start + N];
            for l in 0..N {
                let q = add_product::<FUSED>((ah[l], al[l]), (bh, bl), &mut s[l], &mut t[l]);
                if MEASURED {
                    size[l] += q.abs();
                }
            }
            at += 1;
        }
        carry_over(&mut total, &s, &t);
        if MEASURED {
            for l in 0..N {
                rounded[l] += BLOCK as f64 * UNIT * size[l];
                if !first {
                    rounded[l] += 3.1 * UNIT * UNIT * total[l].hi.abs();
                }
            }
        }
    }
    for (l, total) in total.iter().enumerate() {
        c.hi.data[to + l] = total.hi;
        c.lo.data[to + l] = total.lo;
    }
    if MEASURED {
        // The sum has two terms a block, and each of them lost at most a few units.
        let slack = 1.0 + 4.0 * (at as f64 + 8.0) * f64::EPSILON;
        for l in 0..N {
            noise[to + l] = rounded[l] * slack;
        }
    }
}

/// s + t <- s + t + a b, s rounded and t collecting what that leaves over, which is returned.
#[inline(always)]
pub(super) fn add_product<const FUSED: bool>(a: (f64, f64), b: (f64, f64), s: &mut f64, t: &mut f64) -> f64 {
    let p = a.0 * b.0;
    let e = if FUSED {
        a.0.mul_add(b.1, a.1.mul_add(b.0, a.0.mul_add(b.0, -p)))
    } else {
        crate::precision::product_error(a.0, b.0, p) + (a.0 * b.1 + a.1 * b.0)
    };
    let (sum, r) = two_sum(*s, p);
    *s = sum;
    let left = r + e;
    *t += left;
    left
}

#[inline(always)]
fn carry_over<const N: usize>(total: &mut [DoubleDouble; N], s: &[f64; N], t: &[f64; N]) {
    for (total, (s, t)) in total.iter_mut().zip(s.iter().zip(t)) {
        let (hi, lo) = two_sum(*s, *t);
        *total = *total + DoubleDouble { hi, lo };
    }
}

kernel!(
/// The matrix product a b for a sparse b, with the bound of [`product`].
pub(super) product_sparse, sparse_loops, (a: &Matrix, b: &Columns) -> Matrix);

#[inline(always)]
fn sparse_loops<const FUSED: bool>(a: &Matrix, b: &Columns) -> Matrix {
    let mut c = Matrix::zeros(a.rows, b.starts.len().saturating_sub(1));
    for column in 0..c.columns {
        let range = b.starts[column]..b.starts[column + 1];
        let numbers = (&b.hi[range.clone()], &b.lo[range.clone()]);
        let places = &b.places[range];
        let to = column * c.hi.stride;
        let mut row = 0;
        while row + 8 <= a.hi.stride {
            tile::<FUSED, false, 8>(a, row, |k| places[k], numbers, (&mut c, &mut []), to + row);
            row += 8;
        }
        if row < a.hi.stride {
            tile::<FUSED, false, 4>(a, row, |k| places[k], numbers, (&mut c, &mut []), to + row);
        }
    }
    c
}

kernel!(
/// Σ_k a_ik b_ik for every row i, with the bound of [`product`].
pub(super) row_products, row_loops, (a: &Matrix, b: &Matrix) -> Vec<DoubleDouble>);

#[inline(always)]
fn row_loops<const FUSED: bool>(a: &Matrix, b: &Matrix) -> Vec<DoubleDouble> {
    let mut result = Vec::with_capacity(a.hi.stride);
    for row in (0..a.hi.stride).step_by(4) {
        let mut total = [DoubleDouble::ZERO; 4];
        for first in (0..a.columns).step_by(BLOCK) {
            let (mut s, mut t) = ([0.0; 4], [0.0; 4]);
            for column in first..(first + BLOCK).min(a.columns) {
                let at = column * a.hi.stride + row;
                for l in 0..4 {
                    let part = |m: &Matrix| (m.hi.data[at + l], m.lo.data[at + l]);
                    let (x, y) = (part(a), part(b));
                    add_product::<FUSED>(x, y, &mut s[l], &mut t[l]);
                }
            }
            carry_over(&mut total, &s, &t);
        }
        result.extend(total);
    }
    result.truncate(a.rows);
    result
}

kernel!(
/// y_j - μ_j z_j for every row j, rounded to doubles: off by at most 16 u² (|y_j| + |μ_j| |z_j|) and u of
/// the result.
///
/// The product costs 8 u² |μ z|, as in [`product_bound`]; the difference of the high parts is exact, and what it
/// leaves over, together with the low part of the product, is at most u |y| + 4 u |μ z|, whose sum is rounded
/// by u of that; the low part of y makes it 2 u |y| + 4 u |μ z|, rounded once more.
pub(super) residuals, residual_loops, (y: &Matrix, z: &Matrix, quotient: &[DoubleDouble]) -> Plain);

#[inline(always)]
fn residual_loops<const FUSED: bool>(y: &Matrix, z: &Matrix, quotient: &[DoubleDouble]) -> Plain {
    let mut r = Plain::zeros(y.rows, y.columns);
    for column in 0..y.columns {
        let (yh, yl) = (y.hi.column(column), y.lo.column(column));
        let (zh, zl) = (z.hi.column(column), z.lo.column(column));
        let to = r.column_mut(column);
        for ((((to, mu), (yh, yl)), zh), zl) in to.iter_mut().zip(quotient).zip(yh.iter().zip(yl)).zip(zh).zip(zl) {
            let (mut s, mut t) = (*yh, *yl);
            add_product::<FUSED>((-mu.hi, -mu.lo), (*zh, *zl), &mut s, &mut t);
            *to = s + t;
        }
    }
    r
}

/// An upper bound, entry by entry, of the product of two matrices of nonnegative doubles.
///
/// A sum of m products in doubles is off by less than a factor 1 + 2 m u and m 2^-1074 for
/// underflow.
pub(super) fn bound_product(a: &Plain, b: &Plain) -> Plain {
    let mut c = multiply(a.view(), b.view());
    let factor = 1.0 + 4.0 * (a.columns as f64 + 2.0) * f64::EPSILON;
    for column in 0..c.columns {
        c.column_mut(column).iter_mut().for_each(|x| *x = *x * factor + 1e-300);
    }
    c
}
