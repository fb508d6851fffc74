//! Whether all exponents of a group lie on the axis of symmetry, with as many vectors as their multiplicity.
//!
//! Without dissipation M q̈ + G q̇ + S q = 0 conserves the Hermitian form κ(v, w) = -i vᴴ [[G, M], [-M, 0]] w of
//! v = (q, q̇); with D and S symmetric the matrix of first order is selfadjoint in vᴴ [[D, M], [M, 0]] w. In both
//! cases (λ_w ± λ̄_v) κ(v, w) = 0 for eigenvectors (+ without dissipation), so that an exponent off the axis has
//! κ(v, v) = 0, and so has the eigenvector at the head of a Jordan chain of one on the axis, being the image of
//! the next one under A - λ (M. G. Krein; Gohberg, Lancaster, Rodman, Indefinite Linear Algebra, 5.7). If κ(v, v)
//! vanishes for no eigenvector of the group, there is neither.
//!
//! An eigenvector is V a with |a_i| <= τ_i max_C |a_c| outside of the group ([`super::certify`]). With max |a_c| = 1
//! and m a lower bound of the eigenvalues of ±κ in the columns of C, |κ(v, v)| >= m - 2 Σ_c Σ_i |κ_ci| τ_i -
//! Σ_ij τ_i |κ_ij| τ_j.

use faer::{Mat, c64};

use super::super::pencil::Enclosed;
use super::certify::Group;
use super::columns::Columns;
use super::couplings::{Approximate, Residuals};
use crate::precision::Ball;

/// Groups up to this size are examined.
const LARGEST: usize = 40;

/// Whether the form is definite on all eigenvectors of the group; `sign` is -1 without dissipation, 1 with symmetric
/// D and S.
pub(super) fn is_definite(columns: &Columns, measured: &[Residuals], group: &Group, sign: f64) -> bool {
    let k = group.members.len();
    if k > LARGEST || group.members.iter().any(|&j| j < columns.together()) {
        return false;
    }
    // 1 + 1e-10 covers the roundings of all sums of nonnegative numbers here.
    let slack = 1.0 + 1e-10;
    let modulus = |x: &Approximate| x.value.re.hypot(x.value.im) + x.error;
    let norm = |v: &[Approximate]| {
        let squares: f64 = v.iter().map(|x| modulus(x) * modulus(x)).sum();
        squares.sqrt() * slack
    };
    let mu = |j: usize| columns.mu(j).modulus() * slack;
    let mut form = Mat::<c64>::zeros(k, k);
    let mut error = Mat::<f64>::zeros(k, k);
    for (a, &i) in group.members.iter().enumerate() {
        let exponent = columns.mu(i).conjugate();
        let by = exponent.to_c64() * sign;
        let low = exponent.re.mid_f64_error() + exponent.im.mid_f64_error();
        for (b, &j) in group.members.iter().enumerate() {
            let (mut sum, mut sizes, mut off) = (c64::new(0.0, 0.0), 0.0, 0.0);
            let parts = measured[j].rest.iter().zip(&measured[j].image);
            for (x, (v, u)) in measured[i].x.iter().zip(parts) {
                sum += x.value.conj() * (v.value + by * u.value);
                sizes += modulus(x) * (modulus(v) + mu(i) * modulus(u));
                off += x.error * (modulus(v) + mu(i) * modulus(u))
                    + modulus(x) * (v.error + (mu(i) * u.error + low * modulus(u)));
            }
            form[(a, b)] = if sign < 0.0 { c64::new(sum.im, -sum.re) } else { sum };
            // Four products and sums of n terms, each within γ of all sizes.
            let rounding = (4.0 * measured[i].x.len() as f64 + 32.0) * f64::EPSILON;
            error[(a, b)] = (off + rounding * sizes) * slack;
        }
    }
    // What columns outside of the group may add.
    let (mut cross, mut first, mut second, mut third, mut fourth) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (i, &reach) in group.reach.iter().enumerate() {
        if reach == 0.0 {
            continue;
        }
        let (x, rest, image) = (norm(&measured[i].x), norm(&measured[i].rest), norm(&measured[i].image));
        let links = columns.links.iter().filter(|link| link.to == i);
        let linked: f64 = links.map(|link| link.value.abs() * norm(&measured[link.from].x)).sum();
        for &c in &group.members {
            cross += norm(&measured[c].x) * (rest + mu(c) * image) * reach;
        }
        first += reach * x;
        second += reach * rest;
        third += reach * (mu(i) * x + linked);
        fourth += reach * image;
    }
    let outside = (2.0 * cross + first * second + third * fourth) * slack;
    let rows = (0..k).map(|a| (0..k).map(|b| error[(a, b)]).sum::<f64>());
    // The largest is below the sum, which does not pass over what is not a number.
    let own = rows.sum::<f64>() * slack;
    [1.0, -1.0].into_iter().any(|side| is_above(&form, side, (own + outside) * slack))
}

/// Whether the eigenvalues of side (H + Hᴴ) / 2, as doubles stand, are above a bound: as a real matrix of twice the order.
fn is_above(form: &Mat<c64>, side: f64, bound: f64) -> bool {
    let k = form.nrows();
    let entry = |a: usize, b: usize| {
        let (p, q) = (form[(a % k, b % k)], form[(b % k, a % k)]);
        let (re, im) = (0.5 * (p.re + q.re), 0.5 * (p.im - q.im));
        side * match (a < k, b < k) {
            (true, true) | (false, false) => re,
            (true, false) => -im,
            (false, true) => im,
        }
    };
    let size: f64 = (0..2 * k).flat_map(|a| (0..2 * k).map(move |b| (a, b))).map(|(a, b)| entry(a, b).abs()).sum();
    // Forming the entries and taking the shift away costs some units of all entries.
    let shift = bound + 8.0 * (2.0 * k as f64 + 8.0) * f64::EPSILON * (size + bound);
    let shifted = Enclosed::new(2 * k, |a, b| Ball::exact(entry(a, b) - if a == b { shift } else { 0.0 }));
    shift.is_finite() && shifted.is_positive_definite()
}
