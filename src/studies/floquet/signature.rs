//! Multipliers that coincide on the unit circle, or that bounds do not tell apart, without growth.
//!
//! A real antisymmetric form ω that the monodromy Φ leaves unchanged makes (x, y) -> i x* ω y a hermitian form with (Φx, Φy) = (x, y).
//! Where that is definite on an invariant subspace, Φ is unitary there in that form: its eigenvalues lie on the circle, and
//! have as many vectors as they have multiplicity (M. G. Krein; V. I. Arnold, Mathematical Methods of Classical Mechanics, §42 and
//! appendix 29).

use super::basis::Basis;
use super::discs::Covers;
use librate_core::precision::{Complex, Enclosure, Magnitude, subtract};

/// Whether i x* ω x is definite on the invariant subspace that belongs to a set of connected discs; `form` is ω row by row. With that
/// all eigenvalues in these discs are on the circle.
///
/// Let V⁻¹ΦV have the blocks B11 of the set, B22 of the others, and B12, B21. Columns (1, Z) span an invariant subspace if
/// B21 + B22 Z = Z (B11 + B12 Z), or, for the diagonals D1 and D2 and what is beside them, E1 and E2,
/// (D2 - D1)_ij Z_ij = (Z E1 + Z B12 Z - B21 - E2 Z)_ij. Where all |Z_ij| <= ζ make the right side at most ζ |D2 - D1|_ij, there
/// is such a Z (Brouwer). It has the eigenvalues of B11 + B12 Z; with k ζ <= 1 for k columns the Gershgorin discs of that lie in
/// those of the set, which hold no others.
pub(super) fn is_definite<S: Enclosure>(
    members: &[usize],
    covers: &Covers<S>,
    basis: &Basis<S>,
    form: &[S],
    precision: S::Precision,
) -> bool {
    let n = covers.plain.len();
    let others: Vec<usize> = (0..n).filter(|at| !members.contains(at)).collect();
    let Some(reach) = reach(members, &others, covers, precision) else { return false };
    // U = V1 + V2 Z.
    let vector = |i: usize, j: usize| {
        let size = |m: &usize| basis.vectors[(i, *m)].upper_bound();
        let spread = others.iter().fold(Magnitude::ZERO, |sum, m| sum + size(m)) * reach;
        let own = &basis.vectors[(i, j)];
        own.with_added_radius(spread)
    };
    let vectors: Vec<Vec<Complex<S>>> = members.iter().map(|j| (0..n).map(|i| vector(i, *j)).collect()).collect();
    let zero = Complex::zero(precision);
    let image = |vector: &Vec<Complex<S>>| -> Vec<Complex<S>> {
        let row = |row: &[S]| row.iter().zip(vector).fold(zero.clone(), |sum, (a, x)| sum.add(&x.times(a)));
        form.chunks_exact(n).map(row).collect()
    };
    let turned: Vec<Vec<Complex<S>>> = vectors.iter().map(image).collect();
    let product = |left: &[Complex<S>], right: &Vec<Complex<S>>| {
        let sum = left.iter().zip(right).fold(zero.clone(), |sum, (x, y)| sum.add(&x.conjugate().mul(y)));
        Complex::new(sum.im.neg(), sum.re)
    };
    let row = |left: &Vec<Complex<S>>| turned.iter().map(|right| product(left, right)).collect();
    let mut products: Vec<Vec<Complex<S>>> = vectors.iter().map(row).collect();
    // Of one sign where all pivots of an elimination are.
    let mut positive = None;
    for k in 0..members.len() {
        let pivot = products[k][k].re.clone();
        let above = pivot.is_positive();
        if !above && !pivot.neg().is_positive() || positive.is_some_and(|own| own != above) {
            return false;
        }
        positive = Some(above);
        let own = products[k].clone();
        let share = S::exact(1.0, precision).div(&pivot);
        for row in &mut products[k + 1..] {
            let factor = row[k].times(&share);
            subtract(row, &own, &factor);
        }
    }
    true
}

/// ζ.
fn reach<S: Enclosure>(
    members: &[usize],
    others: &[usize],
    covers: &Covers<S>,
    precision: S::Precision,
) -> Option<Magnitude> {
    let mut gap = Magnitude::INFINITE;
    for i in others {
        for j in members {
            let difference = covers.plain[*i].center.sub(&covers.plain[*j].center);
            let half = difference.upper_bound().scale(-1);
            let square = S::from_magnitude(half, precision);
            let rest = difference.square_of_modulus().sub(&square.mul(&square));
            if !rest.is_positive() {
                return None;
            }
            gap = gap.min(half);
        }
    }
    let off = |i: usize, j: usize| covers.coupling(i, j);
    let sum = |parts: &mut dyn Iterator<Item = Magnitude>| parts.fold(Magnitude::ZERO, |sum, part| sum + part);
    let [mut back, mut beside, mut cross] = [Magnitude::ZERO; 3];
    for i in others {
        for j in members {
            back = back.max(off(*i, *j));
            cross = cross + off(*j, *i);
        }
        beside = beside.max(sum(&mut others.iter().map(|l| off(*i, *l))));
    }
    let own = members.iter().map(|j| sum(&mut members.iter().map(|l| off(*l, *j))));
    let own = own.fold(Magnitude::ZERO, Magnitude::max);
    if others.is_empty() {
        return Some(Magnitude::ZERO);
    }
    // Twice what is left where the rest is small.
    let reach = (back / gap).scale(1);
    let most = (back + reach * (beside + own) + reach * reach * cross) / gap;
    let columns = Magnitude::from_f64(members.len() as f64);
    (most <= reach && columns * reach <= Magnitude::ONE).then_some(reach)
}
