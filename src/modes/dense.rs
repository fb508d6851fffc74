//! Dense matrices in double-double, and their product with a proved error bound.
//!
//! Stored column by column, high and low parts apart, columns padded with zeros to a multiple of
//! four rows, so that the compiler can turn the inner loops into vector instructions.

use crate::precision::{DoubleDouble, two_sum};

/// Terms summed before the result is carried over into a double-double total.
const BLOCK: usize = 8;

/// A matrix of double-doubles.
#[derive(Clone, Debug)]
pub(super) struct Matrix {
    pub(super) rows: usize,
    pub(super) columns: usize,
    stride: usize,
    hi: Vec<f64>,
    lo: Vec<f64>,
}

/// A matrix of doubles: magnitudes and bounds.
#[derive(Clone, Debug)]
pub(super) struct Plain {
    pub(super) rows: usize,
    pub(super) columns: usize,
    stride: usize,
    data: Vec<f64>,
}

fn padded(rows: usize) -> usize {
    rows.next_multiple_of(4)
}

impl Matrix {
    pub(super) fn zeros(rows: usize, columns: usize) -> Self {
        let stride = padded(rows);
        let length = stride * columns;
        Self {
            rows,
            columns,
            stride,
            hi: vec![0.0; length],
            lo: vec![0.0; length],
        }
    }

    pub(super) fn get(&self, row: usize, column: usize) -> DoubleDouble {
        let at = column * self.stride + row;
        DoubleDouble {
            hi: self.hi[at],
            lo: self.lo[at],
        }
    }

    pub(super) fn set(&mut self, row: usize, column: usize, value: DoubleDouble) {
        let at = column * self.stride + row;
        self.hi[at] = value.hi;
        self.lo[at] = value.lo;
    }

    /// The high parts of a column.
    pub(super) fn column_hi(&self, column: usize) -> &[f64] {
        &self.hi[column * self.stride..column * self.stride + self.rows]
    }

    pub(super) fn transposed(&self) -> Self {
        let mut result = Self::zeros(self.columns, self.rows);
        // In squares that fit the cache.
        const SIDE: usize = 16;
        for c0 in (0..self.columns).step_by(SIDE) {
            for r0 in (0..self.rows).step_by(SIDE) {
                for column in c0..(c0 + SIDE).min(self.columns) {
                    for row in r0..(r0 + SIDE).min(self.rows) {
                        let (to, from) = (row * result.stride + column, column * self.stride + row);
                        result.hi[to] = self.hi[from];
                        result.lo[to] = self.lo[from];
                    }
                }
            }
        }
        result
    }

    /// Upper bounds of the magnitudes: |hi + lo| <= |hi| (1 + 2^-53).
    pub(super) fn magnitudes(&self) -> Plain {
        let data = self
            .hi
            .iter()
            .map(|x| x.abs() * (1.0 + f64::EPSILON))
            .collect();
        Plain {
            rows: self.rows,
            columns: self.columns,
            stride: self.stride,
            data,
        }
    }

    /// Adds another matrix of the same shape.
    pub(super) fn add_assign(&mut self, other: &Self) {
        for column in 0..self.columns {
            for row in 0..self.rows {
                self.set(row, column, self.get(row, column) + other.get(row, column));
            }
        }
    }

    /// The given columns, in the given order.
    pub(super) fn gather(&self, columns: &[usize]) -> Self {
        let mut result = Self::zeros(self.rows, columns.len());
        for (to, &from) in columns.iter().enumerate() {
            let (to, from) = (to * self.stride, from * self.stride);
            result.hi[to..to + self.stride].copy_from_slice(&self.hi[from..from + self.stride]);
            result.lo[to..to + self.stride].copy_from_slice(&self.lo[from..from + self.stride]);
        }
        result
    }

    /// Writes the columns of `other` over the given columns.
    pub(super) fn scatter(&mut self, columns: &[usize], other: &Self) {
        for (from, &to) in columns.iter().enumerate() {
            let (to, from) = (to * self.stride, from * self.stride);
            self.hi[to..to + self.stride].copy_from_slice(&other.hi[from..from + self.stride]);
            self.lo[to..to + self.stride].copy_from_slice(&other.lo[from..from + self.stride]);
        }
    }
}

impl Plain {
    pub(super) fn zeros(rows: usize, columns: usize) -> Self {
        let stride = padded(rows);
        Self {
            rows,
            columns,
            stride,
            data: vec![0.0; stride * columns],
        }
    }

    pub(super) fn get(&self, row: usize, column: usize) -> f64 {
        self.data[column * self.stride + row]
    }

    pub(super) fn set(&mut self, row: usize, column: usize, value: f64) {
        self.data[column * self.stride + row] = value;
    }

    pub(super) fn column(&self, column: usize) -> &[f64] {
        &self.data[column * self.stride..column * self.stride + self.rows]
    }

    pub(super) fn column_mut(&mut self, column: usize) -> &mut [f64] {
        &mut self.data[column * self.stride..column * self.stride + self.rows]
    }

    pub(super) fn transposed(&self) -> Self {
        let mut result = Self::zeros(self.columns, self.rows);
        for column in 0..self.columns {
            for row in 0..self.rows {
                result.data[row * result.stride + column] = self.data[column * self.stride + row];
            }
        }
        result
    }

    /// As a matrix of double-doubles.
    pub(super) fn widened(&self) -> Matrix {
        let lo = vec![0.0; self.data.len()];
        let (rows, columns, stride) = (self.rows, self.columns, self.stride);
        Matrix {
            rows,
            columns,
            stride,
            hi: self.data.clone(),
            lo,
        }
    }
}

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
/// With P the sum of magnitudes over one block of b = 8 terms: a term a b is split into the exact
/// product of the high parts, p + e, and the cross terms; dropping lo lo costs u^2 |ab|, the at
/// most four roundings of the cross terms and e, none of them above 3 u |ab|, cost 7 u^2 |ab|:
/// together 8 u^2 P. Adding p to the running s is exact with remainder |r| <= u P. Rounding r + e
/// costs at most u^2 (P + 3 |ab|), in all (b + 3) u^2 P; the running t is at most k u P + 3 u P
/// after k terms, so its roundings cost (b (b + 1)/2 + 3 b) u^2 P. The sum for b = 8 is
/// (8 + 11 + 60) u^2 P = 79 u^2 P; 80 covers the higher powers of u. (This is the argument of
/// Ogita, Rump, Oishi, "Accurate sum and dot product", SIAM J. Sci. Comput. 26 (2005), for
/// double-double data.) Each carry into the total costs 3 u^2 of the total (AccurateDWPlusDW), the
/// first none.
pub(super) fn product_bound(inner: usize) -> f64 {
    let carries = inner.div_ceil(BLOCK).saturating_sub(1) as f64;
    (80.0 + 3.1 * carries) * 2f64.powi(-106)
}

/// The matrix product a b; see [`product_bound`].
pub(super) fn product(a: &Matrix, b: &Matrix, part: Part) -> Matrix {
    let mut c = Matrix::zeros(a.rows, b.columns);
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
        // Without fused multiply-add and four lanes this costs five times as much.
        #[allow(unsafe_code)]
        // SAFETY: the features that the function is compiled for were detected just above.
        unsafe {
            product_avx2(a, b, &mut c, part);
        }
        return mirrored(c, part);
    }
    product_loops::<{ cfg!(any(target_feature = "fma", target_arch = "aarch64")) }>(
        a, b, &mut c, part,
    );
    mirrored(c, part)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn product_avx2(a: &Matrix, b: &Matrix, c: &mut Matrix, part: Part) {
    product_loops::<true>(a, b, c, part);
}

fn mirrored(mut c: Matrix, part: Part) -> Matrix {
    if part == Part::Lower {
        for column in 0..c.columns {
            for row in 0..column {
                c.set(row, column, c.get(column, row));
            }
        }
    }
    c
}

#[inline(always)]
fn product_loops<const FUSED: bool>(a: &Matrix, b: &Matrix, c: &mut Matrix, part: Part) {
    let stride = a.stride;
    for column in 0..b.columns {
        let from = column * b.stride;
        let b_hi = &b.hi[from..from + a.columns];
        let b_lo = &b.lo[from..from + a.columns];
        let to = column * c.stride;
        let mut row = if part == Part::Lower { column & !3 } else { 0 };
        while row + 8 <= stride {
            tile::<FUSED, 8>(a, row, b_hi, b_lo, c, to + row);
            row += 8;
        }
        if row < stride {
            tile::<FUSED, 4>(a, row, b_hi, b_lo, c, to + row);
        }
    }
}

/// N rows of one column of the product.
#[inline(always)]
fn tile<const FUSED: bool, const N: usize>(
    a: &Matrix,
    row: usize,
    b_hi: &[f64],
    b_lo: &[f64],
    c: &mut Matrix,
    to: usize,
) {
    let mut total_hi = [0.0; N];
    let mut total_lo = [0.0; N];
    let mut start = row;
    for (block_hi, block_lo) in b_hi.chunks(BLOCK).zip(b_lo.chunks(BLOCK)) {
        let mut s = [0.0; N];
        let mut t = [0.0; N];
        for (&bh, &bl) in block_hi.iter().zip(block_lo) {
            let ah = &a.hi[start..start + N];
            let al = &a.lo[start..start + N];
            for l in 0..N {
                let p = ah[l] * bh;
                let e = if FUSED {
                    ah[l].mul_add(bl, al[l].mul_add(bh, ah[l].mul_add(bh, -p)))
                } else {
                    crate::precision::product_error(ah[l], bh, p) + (ah[l] * bl + al[l] * bh)
                };
                let (sum, r) = two_sum(s[l], p);
                s[l] = sum;
                t[l] += r + e;
            }
            start += a.stride;
        }
        for l in 0..N {
            let (hi, lo) = two_sum(s[l], t[l]);
            let sum = DoubleDouble {
                hi: total_hi[l],
                lo: total_lo[l],
            } + DoubleDouble { hi, lo };
            total_hi[l] = sum.hi;
            total_lo[l] = sum.lo;
        }
    }
    c.hi[to..to + N].copy_from_slice(&total_hi);
    c.lo[to..to + N].copy_from_slice(&total_lo);
}

/// An upper bound, entry by entry, of the product of two matrices of nonnegative doubles.
///
/// A sum of m products in doubles is off by less than a factor 1 + 2 m u and m 2^-1074 for
/// underflow.
pub(super) fn bound_product(a: &Plain, b: &Plain, part: Part) -> Plain {
    let mut c = Plain::zeros(a.rows, b.columns);
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
        #[allow(unsafe_code)]
        // SAFETY: the features that the function is compiled for were detected just above.
        unsafe {
            bound_product_avx2(a, b, &mut c, part);
        }
    } else {
        bound_loops::<false>(a, b, &mut c, part);
    }
    #[cfg(not(target_arch = "x86_64"))]
    bound_loops::<false>(a, b, &mut c, part);
    let factor = 1.0 + 4.0 * (a.columns as f64 + 2.0) * f64::EPSILON;
    for column in 0..c.columns {
        let from = if part == Part::Lower { column } else { 0 };
        for row in from..c.rows {
            let bound = c.get(row, column) * factor + 1e-300;
            c.set(row, column, bound);
            if part == Part::Lower {
                c.set(column, row, bound);
            }
        }
    }
    c
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn bound_product_avx2(a: &Plain, b: &Plain, c: &mut Plain, part: Part) {
    bound_loops::<true>(a, b, c, part);
}

#[inline(always)]
fn bound_loops<const FUSED: bool>(a: &Plain, b: &Plain, c: &mut Plain, part: Part) {
    for column in 0..b.columns {
        let from = column * b.stride;
        let factors = &b.data[from..from + a.columns];
        let to = column * c.stride;
        let mut row = if part == Part::Lower { column & !3 } else { 0 };
        while row + 16 <= a.stride {
            bound_tile::<FUSED, 16>(a, row, factors, &mut c.data[to + row..]);
            row += 16;
        }
        while row < a.stride {
            bound_tile::<FUSED, 4>(a, row, factors, &mut c.data[to + row..]);
            row += 4;
        }
    }
}

#[inline(always)]
fn bound_tile<const FUSED: bool, const N: usize>(
    a: &Plain,
    row: usize,
    factors: &[f64],
    c: &mut [f64],
) {
    let mut sum = [0.0; N];
    let mut start = row;
    for &factor in factors {
        let column = &a.data[start..start + N];
        for l in 0..N {
            sum[l] = if FUSED {
                column[l].mul_add(factor, sum[l])
            } else {
                sum[l] + column[l] * factor
            };
        }
        start += a.stride;
    }
    c[..N].copy_from_slice(&sum);
}

#[cfg(test)]
mod tests {
    use super::*;
    use dashu_ratio::RBig;

    fn sample(rows: usize, columns: usize, seed: u64) -> Matrix {
        let mut state = seed;
        let mut next = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut matrix = Matrix::zeros(rows, columns);
        for column in 0..columns {
            for row in 0..rows {
                let scale = 10f64.powf(12.0 * next());
                matrix.set(
                    row,
                    column,
                    DoubleDouble::new(next() * scale, next() * scale * 1e-17),
                );
            }
        }
        matrix
    }

    fn exact(x: DoubleDouble) -> RBig {
        RBig::try_from(x.hi).unwrap() + RBig::try_from(x.lo).unwrap()
    }

    #[test]
    fn products_keep_their_bound_with_and_without_vector_instructions() {
        for (rows, inner, columns) in [(1, 1, 1), (3, 3, 3), (5, 9, 4), (13, 40, 11), (8, 17, 3)] {
            let (a, b) = (sample(rows, inner, 7), sample(inner, columns, 11));
            let fast = product(&a, &b, Part::All);
            let mut slow = Matrix::zeros(rows, columns);
            product_loops::<false>(&a, &b, &mut slow, Part::All);
            let sizes = bound_product(&a.magnitudes(), &b.magnitudes(), Part::All);
            for row in 0..rows {
                for column in 0..columns {
                    let sum = (0..inner).fold(RBig::ZERO, |s, k| {
                        s + exact(a.get(row, k)) * exact(b.get(k, column))
                    });
                    let bound = product_bound(inner) * sizes.get(row, column);
                    for c in [&fast, &slow] {
                        let error = exact(c.get(row, column)) - &sum;
                        let error = if error < RBig::ZERO { -error } else { error };
                        assert!(
                            error <= RBig::try_from(bound).unwrap(),
                            "{rows} {inner} {columns}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn lower_part_is_mirrored() {
        let a = sample(21, 9, 3);
        let (full, half) = (
            product(&a, &a.transposed(), Part::All),
            product(&a, &a.transposed(), Part::Lower),
        );
        for row in 0..21 {
            for column in 0..21 {
                let low = full.get(row.max(column), row.min(column));
                assert_eq!(half.get(row, column), low);
            }
        }
    }
}
