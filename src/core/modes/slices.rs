//! Products of dense matrices of double-doubles at the price of a few products of doubles.
//!
//! Both are cut into slices of so few bits that products of slices are exact in doubles, whoever sums
//! them in whatever order (Ozaki, Ogita, Oishi, Rump, "Error-free transformations of matrix
//! multiplication by using fast routines of matrix multiplication and its applications", Numer.
//! Algorithms 59 (2012)); faer multiplies the slices. What the slices leave over is so small that its products in doubles will do.

use faer::Accum;

use super::dense::{Matrix, Plain, add_to, gamma, multiply_onto};
use crate::precision::{U2, exponent_of, power_of_two, two_sum, up};

/// A matrix cut into slices, the coarsest first, each of which is row by row or column by column a power of two
/// times integers of at most `bits` bits, and what the last one leaves over, in doubles.
struct Sliced {
    parts: Vec<Plain>,
    /// Exponents e with |entries of this row (column)| <= 2^e.
    scales: Vec<i32>,
    /// What the last slices leave over, rounded to doubles, each after one slice more; `None` where that is nothing.
    rests: Vec<Option<Plain>>,
}

/// XᵀA for Xᵀ (m by n) and a symmetric A, and a bound of each row's error in length.
///
/// With slices of β bits, A_p B_q sums n products of integers of at most 2^β times a power of two: exact in
/// doubles if n 2^2β <= 2^53. All slices but the first hold at most 2^(β-1), being what rounding left, so that products
/// with the same p + q, whose powers of two are the same, may be summed exactly as long as the sum of their
/// n 2^2β, halved for each p, q > 1, is at most 2^53. The products with p + q <= P + 1 of P slices are taken so. What is
/// left, with R_q for what the first q slices of A leave over and S for what those of X do,
///
/// ```text
///   XᵀA - Σ_{p+q<=P+1} X_pᵀA_q = Σ_p X_pᵀR_(P+1-p) + SᵀA
/// ```
///
/// is so small that its P + 1 products are taken in doubles, all in one sum of sums of [`BLOCK`] terms, in which no term
/// is rounded more often than `roundings`: by rows they are off by γ of so many terms times
/// Σ_p ‖x_p‖ ‖R_(P+1-p)‖ + ‖s‖ ‖A‖ (Cauchy, Schwarz; Frobenius norms), and by 2 u of that as R, S and A are
/// rounded to doubles. Entries of R_q are at most 2^(f - qβ - 1), f being the scale of their column, and those of x_p (s) at
/// most 2^(e - (p-1)β - 1) (2^(e - Pβ - 1)). The sums in double-double cost 2 u² of their terms each, and no term is larger than
/// n 2^(e + f) (1 + 2^(1-β)).
///
/// Where the entries of A have so few bits that it is a single slice, those of X may have more, and there are fewer of them.
pub(super) fn sliced_product(xt: &Matrix, a: &Matrix, lengths: &[f64], slices: usize) -> (Matrix, Vec<f64>) {
    let (m, n) = (xt.rows, a.columns);
    let both = 53 - (n as f64).log2().ceil() as i32;
    let few = few_bits(a, both / 2);
    let (bits, a_bits, slices) = few.map_or((both / 2, both / 2, slices), |few| (both - few, few, (slices - 1).max(1)));
    let left = slice(xt, (slices, 1), bits, Cut::Rows);
    let right = slice(a, (slices, slices), a_bits, Cut::Columns);
    let mut value = Matrix::zeros(m, n);
    let mut part = Plain::zeros(m, n);
    let largest = n as f64 * power_of_two(bits + a_bits);
    let mut first = true;
    for order in 2..=slices + 1 {
        let mut held = 0.0;
        // From both ends, so that large ones come first.
        let pairs = (1..order).map(|k| if k % 2 == 1 { k / 2 + 1 } else { order - k / 2 });
        for (p, q) in pairs.map(|p| (p, order - p)) {
            let (Some(a), Some(b)) = (left.parts.get(p - 1), right.parts.get(q - 1)) else { continue };
            let half = |slice| if slice == 1 { 1.0 } else { 0.5 };
            let size = largest * half(p) * half(q);
            if held > 0.0 && held + size <= power_of_two(53) {
                multiply_onto(&mut part, Accum::Add, a.view(), b.view());
                held += size;
                continue;
            }
            if held > 0.0 {
                put_onto(&mut value, &mut part, &mut first);
            }
            multiply_onto(&mut part, Accum::Replace, a.view(), b.view());
            held = size;
        }
        if held > 0.0 {
            put_onto(&mut value, &mut part, &mut first);
        }
    }
    let rest = left.rests.last().and_then(Option::as_ref);
    let last = rest.map(|rest| (rest.view(), a.hi.view()));
    let pairs = left.parts.iter().zip(right.rests.iter().rev());
    let pairs = pairs.filter_map(|(x, rest)| Some((x.view(), rest.as_ref()?.view())));
    let pairs: Vec<_> = pairs.chain(last).collect();
    let mut accumulate = Accum::Replace;
    for start in (0..n).step_by(BLOCK) {
        let length = BLOCK.min(n - start);
        for (x, a) in &pairs {
            let (x, a) = (x.subcols(start, length), a.subrows(start, length));
            multiply_onto(&mut part, accumulate, x, a);
            accumulate = Accum::Add;
        }
    }
    if !pairs.is_empty() {
        put_onto(&mut value, &mut part, &mut first);
    }
    // The lengths of a row of ones and of the scales of the columns.
    let squares: f64 = right.scales.iter().map(|&f| power_of_two(f) * power_of_two(f)).sum();
    let across = squares.sqrt() * (1.0 + 1e-6);
    let ones = (n as f64).sqrt() * (1.0 + 1e-6);
    // Of what q slices leave over, beside 2^scale.
    let left_over = |q: usize| power_of_two(-(q as i32) * bits - 1);
    let left_over_of_a = |q: usize| power_of_two(-(q as i32) * a_bits - 1);
    let rest_of_x = rest.is_some();
    let exact = (slices * (slices + 1) / 2 + 1) as f64;
    let sums = 3.0 * exact * U2 * n as f64;
    let roundings = BLOCK + (slices + 1) * n.div_ceil(BLOCK);
    let unit = gamma(roundings.min((slices + 1) * n)) + 2.0 * f64::EPSILON;
    let error = |(&e, length): (&i32, &f64)| {
        let entry = power_of_two(e);
        let mut rest = 0.0;
        for p in (1..=slices).filter(|p| right.rests[slices - p].is_some()) {
            // The first slice of x is no longer than x and what it leaves over.
            let own = match p {
                1 => length + ones * entry * left_over(1),
                _ => ones * entry * left_over(p - 1),
            };
            rest += own * (ones * across * left_over_of_a(slices + 1 - p));
        }
        if rest_of_x {
            rest += ones * entry * left_over(slices) * (ones * across);
        }
        up((unit * rest + sums * entry * across) * (1.0 + 1e-6) + 1e-290)
    };
    (value, left.scales.iter().zip(lengths).map(error).collect())
}

/// With how many bits a column is a multiple of a power of two that is not beyond its own scale, if with `most`.
fn few_bits(a: &Matrix, most: i32) -> Option<i32> {
    let mut bits = 1;
    for column in 0..a.columns {
        let entries = a.hi.column(column);
        let largest = entries.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let scale = scale_of(largest);
        for (x, low) in entries.iter().zip(a.lo.column(column)) {
            if *x == 0.0 {
                continue;
            }
            let zeros = (x.to_bits() | 1 << 52).trailing_zeros() as i32;
            bits = bits.max(scale - (exponent_of(*x) - 52 + zeros));
            if bits > most || *low != 0.0 {
                return None;
            }
        }
    }
    Some(bits)
}

/// An exponent e with |x| <= 2^e for all x of a row or column, from the largest of their high parts. Entries below 2^-400 are
/// treated as if there were nothing left.
fn scale_of(largest: f64) -> i32 {
    (exponent_of(largest) + 1).clamp(-400, 900)
}

/// Terms of products in doubles that are summed apart: the bound grows with the number of roundings, and with fewer terms the
/// products take longer.
const BLOCK: usize = 128;

/// Adds a sum of products to the total; the first of them is the total.
fn put_onto(total: &mut Matrix, part: &mut Plain, first: &mut bool) {
    if *first {
        std::mem::swap(&mut total.hi, part);
        *first = false;
    } else {
        add_to(total, part);
    }
}

/// Takes from double-doubles what is a multiple of the anchors' unit.
///
/// Rounds to that unit; exact, as is what is left (Rump, Ogita, Oishi, "Accurate floating-point summation
/// I", SIAM J. Sci. Comput. 31 (2008)).
fn cut(to: &mut [f64], (hi, lo): (&mut [f64], &mut [f64]), anchors: &[f64]) {
    for (((to, hi), lo), anchor) in to.iter_mut().zip(hi).zip(lo).zip(anchors) {
        let top = (*hi + anchor) - anchor;
        *to = top;
        (*hi, *lo) = two_sum(*hi - top, *lo);
    }
}

/// Whether rows or columns have a scale of their own.
#[derive(Clone, Copy, PartialEq)]
enum Cut {
    Rows,
    Columns,
}

/// Cuts a matrix into slices and keeps so many rests.
fn slice(a: &Matrix, (slices, kept): (usize, usize), bits: i32, by: Cut) -> Sliced {
    let (rows, columns) = (a.rows, a.columns);
    let mut largest = vec![0.0_f64; if by == Cut::Rows { rows } else { columns }];
    for column in 0..columns {
        let entries = a.hi.column(column).iter();
        match by {
            Cut::Rows => {
                for (largest, x) in largest.iter_mut().zip(entries) {
                    *largest = largest.max(x.abs());
                }
            }
            Cut::Columns => largest[column] = entries.fold(0.0, |most, x| most.max(x.abs())),
        }
    }
    let scales: Vec<i32> = largest.iter().map(|&x| scale_of(x)).collect();
    let mut parts: Vec<Plain> = (0..slices).map(|_| Plain::zeros(rows, columns)).collect();
    let mut rests: Vec<Plain> = (0..kept).map(|_| Plain::zeros(rows, columns)).collect();
    // 1.5 · 2^52 times the unit of a slice, for each row or column.
    let anchor = |scale: i32, number: i32| 1.5 * power_of_two((52 + scale - number * bits).max(-1000));
    let own = |number: i32| scales.iter().map(|scale| anchor(*scale, number)).collect();
    let anchors: Vec<Vec<f64>> = (1..=slices as i32).map(own).collect();
    let (mut hi, mut lo) = (vec![0.0; rows], vec![0.0; rows]);
    let mut same = vec![0.0; rows];
    for column in 0..columns {
        hi.copy_from_slice(a.hi.column(column));
        lo.copy_from_slice(a.lo.column(column));
        for (number, (part, anchors)) in parts.iter_mut().zip(&anchors).enumerate() {
            let anchors = match by {
                Cut::Rows => anchors.as_slice(),
                Cut::Columns => {
                    same.fill(anchors[column]);
                    same.as_slice()
                }
            };
            cut(part.column_mut(column), (&mut hi, &mut lo), anchors);
            if let Some(rest) = rests.get_mut((number + kept).wrapping_sub(slices)) {
                rest.column_mut(column).copy_from_slice(&hi);
            }
        }
    }
    let zero = |part: &Plain| part.data.iter().all(|x| *x == 0.0);
    while parts.pop_if(|part| zero(part)).is_some() {}
    let some = |rest: Plain| (!zero(&rest)).then_some(rest);
    Sliced { parts, scales, rests: rests.into_iter().map(some).collect() }
}
