//! Bases of spaces of vectors that do not depend on how the space was found: echelon form first, then Gram and Schmidt
//! in the metric of M.

use faer::c64;

use super::super::leading;
use super::complex::Wide;
use crate::order::Order;
use crate::precision::{Big, Magnitude, clear_column, subtract, sum_of_products};

/// A component smaller than 2 to this times the largest is no pivot of an echelon basis.
const NO_PIVOT: i64 = -10;

/// The Hermitian form of M, and the units in which components are compared.
pub(super) struct Metric<'a> {
    pub(super) n: usize,
    pub(super) mass: &'a dyn Fn(usize, usize) -> Big,
    /// Component p is compared with others as times 2^-shift(p).
    pub(super) shift: &'a [i32],
}

impl Metric<'_> {
    /// Mx, of the first n components.
    fn image(&self, x: &[Wide]) -> Vec<Wide> {
        let bits = x.first().map_or(64, |x| x.re.bits());
        let row = |i: usize| {
            let terms = x.iter().take(self.n).enumerate().map(|(j, x)| x.times(&(self.mass)(i, j)));
            terms.filter(|x| !x.is_zero()).fold(Wide::zero(bits), |sum, x| sum.add(&x))
        };
        (0..self.n).map(row).collect()
    }

    /// An orthonormal basis, of `count` vectors, of what the candidates span beside the orthonormal `known` ones: their
    /// projection onto the complement in echelon form, orthonormalised in its order. The caller answers for the
    /// dimension. `None` where enclosures do not tell which components are pivots.
    ///
    /// Components beyond the first n take part in combinations and in nothing else.
    pub(super) fn orthonormal(
        &self,
        known: &[Vec<Wide>],
        mut candidates: Vec<Vec<Wide>>,
        count: usize,
    ) -> Option<Vec<Vec<Wide>>> {
        let clear = |own: &mut [Wide], basis: &[Vec<Wide>], images: &[Vec<Wide>]| {
            for (x, image) in basis.iter().zip(images) {
                let part = dot(image, own);
                subtract(own, x, &part);
            }
        };
        let images: Vec<Vec<Wide>> = known.iter().map(|x| self.image(x)).collect();
        candidates.iter_mut().for_each(|candidate| clear(candidate, known, &images));
        let echelon = self.echelon(candidates, count)?;
        let mut basis: Vec<Vec<Wide>> = Vec::with_capacity(count);
        let mut images: Vec<Vec<Wide>> = Vec::with_capacity(count);
        for mut own in echelon {
            clear(&mut own, &basis, &images);
            let image = self.image(&own);
            let square = dot(&own, &image).re;
            if !square.is_positive() {
                return None;
            }
            let inverse = &Big::one(square.bits()) / &square.sqrt();
            let scaled = |x: &[Wide]| x.iter().map(|x| x.times(&inverse)).collect::<Vec<_>>();
            images.push(scaled(&image));
            basis.push(scaled(&own));
        }
        Some(basis)
    }

    /// Combinations of the vectors that are 1 in the first rows in which `count` of them are independent, each in one
    /// of these and 0 in the others.
    fn echelon(&self, mut columns: Vec<Vec<Wide>>, count: usize) -> Option<Vec<Vec<Wide>>> {
        let size = |x: &[Wide], row: usize| {
            let by = -i64::from(self.shift.get(row).copied().unwrap_or(0));
            x.get(row).map_or(Magnitude::ZERO, |x| x.re.mid_upper().max(x.im.mid_upper()).scale(by))
        };
        let mut pivots: Vec<usize> = Vec::with_capacity(count);
        for p in 0..count {
            let rest = columns.get(p..)?;
            let most = |row: usize| {
                let sizes = rest.iter().map(|x| size(x, row));
                sizes.fold(Magnitude::ZERO, Magnitude::max)
            };
            let free = (0..self.n).filter(|row| !pivots.contains(row));
            let rows: Vec<(usize, Magnitude)> = free.map(|row| (row, most(row))).collect();
            let largest = rows.iter().fold(Magnitude::ZERO, |a, (_, b)| a.max(*b));
            let (row, top) = *rows.iter().find(|(_, most)| !most.is_zero() && *most >= largest.scale(NO_PIVOT))?;
            let best = rest.iter().position(|x| size(x, row) == top)?;
            columns.swap(p, p + best);
            let pivot = columns[p].get(row)?;
            if pivot.contains_zero() {
                return None;
            }
            let bits = pivot.re.bits();
            clear_column(&mut columns, p, row, bits);
            // Exactly so.
            columns[p][row] = Wide::real(1.0, bits);
            pivots.push(row);
        }
        let mut ordered: Vec<(usize, Vec<Wide>)> = pivots.into_iter().zip(columns).collect();
        ordered.order_by_key(|(row, _)| *row);
        Some(ordered.into_iter().map(|(_, column)| column).collect())
    }
}

/// xᴴy
fn dot(x: &[Wide], y: &[Wide]) -> Wide {
    let bits = x.first().map_or(64, |x| x.re.bits());
    let conjugate: Vec<Wide> = x.iter().map(Wide::conjugate).collect();
    sum_of_products(&conjugate, y, bits)
}

/// The vector in doubles, turned so that its first component within 1e-6 of the largest is real and positive, and a
/// bound of the error of each component.
pub(super) fn finished(vector: &[Wide]) -> (Vec<c64>, f64) {
    let size = |x: &Wide| x.re.mid_upper().max(x.im.mid_upper()).to_f64();
    let modulus = |x: &Wide| {
        // In units of the largest part, lest squares leave the range.
        let unit = size(x);
        if unit == 0.0 {
            return 0.0;
        }
        let (re, im) = (x.re.mid_f64() / unit, x.im.mid_f64() / unit);
        unit * re.hypot(im)
    };
    let first = leading(vector.len(), |at| modulus(&vector[at])).filter(|(_, size)| *size > 0.0 && size.is_finite());
    let Some(first) = first.map(|(at, _)| &vector[at]) else {
        return (vec![c64::new(0.0, 0.0); vector.len()], f64::INFINITY);
    };
    let turn = if first.im.is_zero() {
        let sign = Big::one(first.re.bits());
        Wide { im: Big::zero(sign.bits()), re: if first.re.is_negative() { -&sign } else { sign } }
    } else {
        let square = first.square_of_modulus();
        first.conjugate().times(&(&Big::one(square.bits()) / &square.sqrt()))
    };
    let mut bound = 0.0_f64;
    let turned = |x: &Wide| {
        let mut value = x.mul(&turn);
        if std::ptr::eq(x, first) {
            value.im = Big::zero(value.re.bits());
        }
        let (re, im) = (value.re.to_ball(), value.im.to_ball());
        let error = re.mid_f64_error().max(im.mid_f64_error());
        bound = if error.is_finite() { bound.max(error) } else { f64::INFINITY };
        // No negative zeros.
        c64::new(re.mid_f64() + 0.0, im.mid_f64() + 0.0)
    };
    let values = vector.iter().map(turned).collect();
    (values, bound)
}
