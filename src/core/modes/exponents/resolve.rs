//! Columns that the bounds do not separate: the eigenvalue problem of their own block, in doubles.
//!
//! For the members C of a group and a centre σ, H(σ)_CC and Q_CC are known to the relative accuracy of the
//! residuals, however close the exponents are. The eigenvectors of Q_CC⁻¹ H(σ)_CC turn the columns into better ones,
//! and its eigenvalues are the distances of the exponents from σ.

use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, c64};

use super::complex::part;
use super::couplings::Couplings;
use crate::order::Gather;

/// How a block is turned: new columns x' = Σ_c x_c right(c, a), y'ᵀ = Σ_c left(a, c) y_cᵀ, exponents σ + step.
pub(super) struct Turn {
    pub(super) members: Vec<usize>,
    pub(super) right: Mat<c64>,
    pub(super) left: Mat<c64>,
    pub(super) steps: Vec<c64>,
    /// Of each new column: which new column it is the conjugate of.
    pub(super) conjugate_of: Vec<Option<usize>>,
}

const ZERO: c64 = c64::new(0.0, 0.0);

/// The members closed under conjugation where some are conjugates of others; `None` where all are conjugates
/// of columns outside, which will do.
pub(super) fn members(group: &[usize], conjugate_of: &[Option<usize>], skip: usize) -> Option<Vec<usize>> {
    let group: Vec<usize> = group.iter().copied().filter(|&j| j >= skip).collect();
    let conjugates = group.iter().filter(|&&j| conjugate_of[j].is_some()).count();
    if group.is_empty() || conjugates == group.len() && !closed(&group, conjugate_of) {
        return None;
    }
    if conjugates == 0 && !closed(&group, conjugate_of) {
        return Some(group);
    }
    let pairs = conjugate_of.iter().enumerate().filter_map(|(j, i)| Some([j, (*i)?]));
    let met = pairs.filter(|pair| pair.iter().any(|j| group.contains(j)));
    Some(group.iter().copied().chain(met.flatten()).distinct())
}

/// Whether some member's conjugate is a member, or is itself.
fn closed(group: &[usize], conjugate_of: &[Option<usize>]) -> bool {
    group.iter().any(|&j| is_single(conjugate_of, j) || conjugate_of[j].is_some_and(|i| group.contains(&i)))
}

/// Whether a column is neither the conjugate of another nor has one.
pub(super) fn is_single(conjugate_of: &[Option<usize>], j: usize) -> bool {
    conjugate_of[j].is_none() && !conjugate_of.contains(&Some(j))
}

/// The turn of a block; `shift(b)` is μ - σ of its b-th member, and σ is real where the members are closed under conjugation.
pub(super) fn turn(
    couplings: &Couplings,
    members: Vec<usize>,
    conjugate_of: &[Option<usize>],
    shift: impl Fn(usize) -> c64,
) -> Option<Turn> {
    let k = members.len();
    let q = Mat::from_fn(k, k, |a, b| couplings.unit[(members[a], members[b])]);
    let h = Mat::from_fn(k, k, |a, b| shift(b) * q[(a, b)] - couplings.residuals[(members[a], members[b])]);
    let inverse = q.partial_piv_lu().inverse();
    let block = &inverse * &h;
    let finite =
        |m: &Mat<c64>| (0..m.ncols()).all(|j| (0..m.nrows()).all(|i| (m[(i, j)].re + m[(i, j)].im).is_finite()));
    if !finite(&block) {
        return None;
    }
    let place = |j: usize| members.iter().position(|&i| i == j);
    let mut conjugate: Vec<Option<usize>> = members.iter().map(|&j| conjugate_of[j].and_then(place)).collect();
    for a in 0..k {
        if let Some(b) = conjugate[a]
            && conjugate[b].is_none()
        {
            conjugate[b] = Some(a);
        }
    }
    let self_conjugate = (0..k).all(|a| conjugate[a].is_some() || is_single(conjugate_of, members[a]));
    let Eigen { vectors, steps, conjugate_of } = if self_conjugate {
        real_eigen(&block, &conjugate)?
    } else {
        let eigen = block.eigen().ok()?;
        let vectors = Mat::from_fn(k, k, |a, b| eigen.U()[(a, b)]);
        Eigen { vectors, steps: (0..k).map(|e| eigen.S()[e]).collect(), conjugate_of: vec![None; k] }
    };
    let left = vectors.partial_piv_lu().inverse() * &inverse;
    (finite(&left) && finite(&vectors)).then_some(Turn { members, right: vectors, left, steps, conjugate_of })
}

/// Eigenvectors and eigenvalues of a block, and which is whose conjugate.
struct Eigen {
    vectors: Mat<c64>,
    steps: Vec<c64>,
    conjugate_of: Vec<Option<usize>>,
}

/// Those of a block whose columns are closed under conjugation: real or in conjugate pairs.
fn real_eigen(block: &Mat<c64>, conjugate: &[Option<usize>]) -> Option<Eigen> {
    let k = block.nrows();
    // Real and imaginary parts instead of x and its conjugate: x = a + ib, x̄ = a - ib.
    let mut p = Mat::<c64>::zeros(k, k);
    let mut back = Mat::<c64>::zeros(k, k);
    for a in 0..k {
        match conjugate[a] {
            Some(b) if a < b => {
                p[(a, a)] = c64::new(1.0, 0.0);
                p[(a, b)] = c64::new(1.0, 0.0);
                p[(b, a)] = c64::new(0.0, 1.0);
                p[(b, b)] = c64::new(0.0, -1.0);
                back[(a, a)] = c64::new(0.5, 0.0);
                back[(a, b)] = c64::new(0.0, -0.5);
                back[(b, a)] = c64::new(0.5, 0.0);
                back[(b, b)] = c64::new(0.0, 0.5);
            }
            Some(_) => {}
            None => {
                p[(a, a)] = c64::new(1.0, 0.0);
                back[(a, a)] = c64::new(1.0, 0.0);
            }
        }
    }
    let turned = &p * block * &back;
    let real = Mat::from_fn(k, k, |a, b| turned[(a, b)].re);
    let eigen = real.eigen().ok()?;
    let mut vectors = Mat::<c64>::zeros(k, k);
    let mut steps = Vec::with_capacity(k);
    let mut conjugate_of = Vec::with_capacity(k);
    for e in 0..k {
        let value = eigen.S()[e];
        if value.im < 0.0 {
            continue;
        }
        for a in 0..k {
            let mut sum = ZERO;
            let mut conjugate = ZERO;
            for b in 0..k {
                let u = part(eigen.U()[(b, e)], value.im == 0.0);
                sum += back[(a, b)] * u;
                conjugate += back[(a, b)] * u.conj();
            }
            if steps.len() < k {
                vectors[(a, steps.len())] = sum;
            }
            if value.im > 0.0 && steps.len() + 1 < k {
                vectors[(a, steps.len() + 1)] = conjugate;
            }
        }
        steps.push(value);
        conjugate_of.push(None);
        if value.im > 0.0 {
            steps.push(c64::new(value.re, -value.im));
            conjugate_of.push(Some(steps.len() - 2));
        }
    }
    (steps.len() == k).then_some(Eigen { vectors, steps, conjugate_of })
}
