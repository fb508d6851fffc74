//! Vectors and symmetric matrices of whole numbers over a common power of two. Sums of products are
//! exact; what is rounded is a conversion, by less than one unit, and says so.

use dashu_int::ops::BitTest;
use dashu_int::{IBig, Sign, Word};

use crate::modes::dense::Plain;
use crate::precision::{Big, DoubleDouble, Magnitude, Sum};

/// Bits kept of a number that becomes a double-double.
const LEADING: usize = 106;

/// What a conversion to double-double loses, per unit of the number: see [`double_double`].
pub(super) const LOST: f64 = 2.0 * crate::precision::U2;

/// x 2^shift, rounded towards minus infinity.
pub(super) fn shifted(x: &IBig, shift: i64) -> IBig {
    if shift >= 0 { x << shift as usize } else { x >> shift.unsigned_abs() as usize }
}

/// x 2^exponent as a double-double.
///
/// Of a magnitude of l > 106 bits the lowest l - 106 are dropped: less than 2^(l-106), while the
/// magnitude is at least 2^(l-1); so the relative error is below 2^-105. Numbers below 2^-960
/// become 0.
pub(super) fn double_double(x: &IBig, exponent: i64) -> DoubleDouble {
    let length = x.bit_len();
    if length == 0 || length as i64 + exponent < -960 {
        return DoubleDouble::ZERO;
    }
    let (sign, words) = x.as_sign_words();
    let drop = length.saturating_sub(LEADING);
    let size = Word::BITS as usize;
    let (first, offset) = (drop / size, drop % size);
    let mut top: u128 = 0;
    for (place, &word) in words[first..].iter().enumerate() {
        let shift = (place * size) as i64 - offset as i64;
        // Bits above 2^106 are zeros: the number ends there.
        top |= if shift < 0 { u128::from(word) >> -shift } else { u128::from(word) << shift };
    }
    let place = (exponent + drop as i64).clamp(-4000, 4000) as i32;
    let (high, low) = ((top >> 53) as f64, (top & ((1 << 53) - 1)) as f64);
    // Each half has 53 bits, so that nothing is rounded here.
    let sum = DoubleDouble::new(high * 9_007_199_254_740_992.0, low);
    let value = sum.scale(place);
    if sign == Sign::Negative { -value } else { value }
}

/// x 2^exponent for a double.
pub(super) fn scaled(x: f64, exponent: i64) -> f64 {
    DoubleDouble::exact(x).scale(exponent.clamp(-4000, 4000) as i32).hi
}

/// The nearest double or one beside it.
pub(super) fn double(x: &IBig, exponent: i64) -> f64 {
    double_double(x, exponent).hi
}

/// x 2^scale for a double, rounded down to a whole number.
fn whole(x: f64, scale: i64) -> IBig {
    let x = Big::from_f64(x, 53);
    let (significand, exponent) = x.mid();
    shifted(significand, exponent + scale)
}

/// x 2^scale as a whole number, off by less than 2.
pub(super) fn from_double_double(x: DoubleDouble, scale: i64) -> IBig {
    whole(x.hi, scale) + whole(x.lo, scale)
}

/// The most words of a number.
fn words<'a>(x: impl Iterator<Item = &'a IBig>) -> usize {
    x.map(|x| x.as_sign_words().1.len()).max().unwrap_or(0)
}

/// xᵀy, exactly.
pub(super) fn dot(x: &[IBig], y: &[IBig], sum: &mut Sum) -> IBig {
    sum.clear(words(x.iter()) + words(y.iter()));
    x.iter().zip(y).for_each(|(x, y)| sum.add_product(x, y, 0));
    sum.value()
}

/// A symmetric matrix over 2^scale: entries known up to a radius.
pub(super) struct Symmetric {
    /// The entries that are not 0, by column: row, rising, and number.
    columns: Vec<Vec<(usize, IBig)>>,
    words: usize,
    /// By how many units an entry may be off; `None` where all are exact.
    pub(super) radius: Option<Plain>,
    /// The largest sum of magnitudes in a row.
    pub(super) norm: f64,
}

impl Symmetric {
    /// From the lower triangle of `entries`, column by column; entry (r, c) is multiplied by
    /// 2^(shift_r + shift_c - power). `None` where a number is not finite.
    pub(super) fn new(entries: &[Big], shift: &[i32], power: i32, scale: i64) -> Option<Self> {
        let n = shift.len();
        let mut columns: Vec<Vec<(usize, IBig)>> = vec![Vec::new(); n];
        let mut radius = Plain::zeros(n, n);
        let mut sums = vec![0.0; n];
        let mut exact = true;
        for column in 0..n {
            for row in column..n {
                let by = i64::from(shift[row]) + i64::from(shift[column]) - i64::from(power);
                let (value, error) = unit(&entries[column * n + row], by, scale)?;
                if error != 0.0 {
                    exact = false;
                    radius.set_both(row, column, error);
                }
                if value == IBig::ZERO {
                    continue;
                }
                let size = double(&value, -scale).abs();
                sums[row] += size;
                if row != column {
                    sums[column] += size;
                    columns[row].push((column, value.clone()));
                }
                columns[column].push((row, value));
            }
        }
        let words = words(columns.iter().flatten().map(|(_, x)| x));
        Some(Self { columns, words, radius: (!exact).then_some(radius), norm: sums.into_iter().fold(0.0, f64::max) })
    }

    /// The matrix times x, exactly.
    pub(super) fn times(&self, x: &[IBig], sum: &mut Sum) -> Vec<IBig> {
        let words = self.words + words(x.iter());
        let mut product = |row: &Vec<(usize, IBig)>| {
            sum.clear(words);
            row.iter().for_each(|(column, entry)| sum.add_product(entry, &x[*column], 0));
            sum.value()
        };
        self.columns.iter().map(&mut product).collect()
    }

    pub(super) fn entry(&self, row: usize, column: usize) -> IBig {
        let entries = &self.columns[column];
        let found = entries.binary_search_by_key(&row, |(row, _)| *row);
        found.map_or(IBig::ZERO, |at| entries[at].1.clone())
    }

    /// How many entries are not 0.
    pub(super) fn count(&self) -> usize {
        self.columns.iter().map(Vec::len).sum()
    }
}

/// value 2^(by + scale) as a whole number and by how many units it may be off; `None` if it is not
/// finite or that far off that doubles do not say.
pub(super) fn unit(value: &Big, by: i64, scale: i64) -> Option<(IBig, f64)> {
    let (significand, exponent) = value.mid();
    let whole = shifted(significand, exponent + by + scale);
    let lossless = exponent + by + scale >= 0 || shifted(&whole, -(exponent + by + scale)) == *significand;
    let radius: Magnitude = value.radius().scale(by + scale);
    let error = radius.to_f64() + if lossless { 0.0 } else { 1.0 };
    // The sum of the two is rounded up.
    let error = if error == 0.0 { 0.0 } else { error.next_up() };
    (value.is_finite() && error < 1e200).then_some((whole, error))
}
