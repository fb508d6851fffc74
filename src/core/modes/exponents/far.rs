//! First approximations where doubles do not do: exponents so far apart that the slow ones are rounding beside the fast.
//!
//! The matrices as they stand in double-double are whole numbers over a power of two. The roots of their exact
//! characteristic polynomial are known to as many digits as are asked for, each relative to itself, and the vectors from
//! both sides are what elimination leaves at them. What the matrices are uncertain by is left to the bounds.

use dashu_int::IBig;

use super::super::dense::Matrix;
use super::Options;
use super::basis::Metric;
use super::blocks::Pencil;
use super::columns::{Column, Columns};
use super::complex::Wide;
use super::exact::exact;
use super::scale::Scaled;
use crate::precision::{Big, Integers, sum_of_products};

/// Digits of the exponents.
const DIGITS: usize = 20;

/// Exponents and vectors of a problem without zero modes whose exponents are simple.
pub(super) fn far_start(scaled: &Scaled) -> Option<Columns> {
    let n = scaled.n;
    if !scaled.zero.is_empty() {
        return None;
    }
    let matrices = whole(scaled)?;
    let mass = |i: usize, j: usize| {
        let entry = matrices.matrices[0].get(j * n + i).cloned();
        Big::from_parts(entry.unwrap_or_default(), 0, 128 + 4 * DIGITS)
    };
    let metric = Metric { n, mass: &mass, shift: &vec![0; n] };
    let found = exact(&matrices, n, &Options::default().digits(DIGITS), false, Some(&metric))?;
    let pencil = Pencil { matrices: &matrices, n };
    let mut columns = Columns::default();
    for root in found.roots.into_iter().chain(found.zero) {
        let blocks = root.blocks.filter(|_| root.multiplicity == 1)?;
        let x = blocks.heads.into_iter().next()?;
        let lambda = root.lambda;
        let y = pencil.left_null_vector(&lambda)?;
        // yᵀ(2λM + D)x = 1, and |x|² = 1 / |λ| as in `start`.
        let slope = pencil.slope(&lambda, &x);
        let bits = lambda.re.bits();
        let product = sum_of_products(&y, &slope, bits);
        let square = x.iter().fold(Big::zero(bits), |sum, x| &sum + &x.square_of_modulus());
        let length = (&Big::one(bits) / &(&square * &lambda.square_of_modulus().sqrt())).sqrt();
        let inverse = Wide::real(1.0, bits).div(&product.times(&length));
        let column = Column {
            mu: lambda.to_complex(),
            x: x.iter().map(|x| x.times(&length).to_complex()).collect(),
            y: y.iter().map(|y| y.mul(&inverse).to_complex()).collect(),
        };
        if !column.is_finite() {
            return None;
        }
        let conjugate = (!column.is_real()).then(|| column.conjugate());
        columns.all.push(column);
        columns.conjugate_of.push(None);
        if let Some(conjugate) = conjugate {
            columns.conjugate_of.push(Some(columns.count() - 1));
            columns.all.push(conjugate);
        }
    }
    (columns.count() == 2 * n).then_some(columns)
}

/// The midpoints, all times one power of two.
fn whole(scaled: &Scaled) -> Option<Integers> {
    let entries = |matrix: &Matrix| -> Vec<Big> {
        let columns = (0..scaled.n).flat_map(|j| (0..scaled.n).map(move |i| (i, j)));
        columns.map(|(i, j)| Big::from_double_double(matrix.get(i, j), 128)).collect()
    };
    let all = [entries(&scaled.mass.mid), entries(&scaled.velocity.mid), entries(&scaled.stiffness.mid)];
    let nonzero = all.iter().flatten().filter(|x| !x.is_zero());
    let least = nonzero.map(|x| x.mid().1).min()?;
    let whole = |x: &Big| -> IBig {
        // The exponent of 0 says nothing.
        let (significand, exponent) = x.mid();
        significand << (exponent - least).max(0) as usize
    };
    let matrices = all.map(|entries| entries.iter().map(whole).collect());
    Some(Integers { matrices, ..Integers::default() })
}
