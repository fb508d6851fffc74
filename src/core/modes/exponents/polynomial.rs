//! Polynomials with whole coefficients: the characteristic one, and certified roots.

use dashu_int::IBig;
use dashu_int::ops::Abs;

use super::complex::{Wide, rounded};
use crate::precision::{Big, Magnitude};

/// Coefficients by rising power, the last one not 0; empty for 0.
pub(super) type Polynomial = Vec<IBig>;

/// The determinant, by elimination without fractions.
pub(super) fn determinant(rows: Vec<Vec<IBig>>) -> IBig {
    let n = rows.len();
    let (rank, minor) = eliminated(rows);
    if rank < n { IBig::ZERO } else { minor }
}

/// The rank, likewise.
pub(super) fn rank(rows: Vec<Vec<IBig>>) -> usize {
    eliminated(rows).0
}

/// The rank and, up to sign the minor of that order, with its sign where the matrix is regular: elimination in which
/// every entry is a minor, so that the divisions are exact (Bareiss, Math. Comp. 22 (1968) 565).
fn eliminated(mut rows: Vec<Vec<IBig>>) -> (usize, IBig) {
    let width = rows.first().map_or(0, Vec::len);
    let mut sign = false;
    let mut last = IBig::ONE;
    let mut rank = 0;
    for k in 0..width {
        let Some(at) = (rank..rows.len()).find(|&i| !rows[i][k].is_zero()) else { continue };
        if at != rank {
            rows.swap(at, rank);
            sign = !sign;
        }
        let (above, below) = rows.split_at_mut(rank + 1);
        let pivot = &above[rank];
        for row in below {
            for j in k + 1..width {
                row[j] = (&row[j] * &pivot[k] - &row[k] * &pivot[j]) / &last;
            }
            row[k] = IBig::ZERO;
        }
        last = rows[rank][k].clone();
        rank += 1;
    }
    (rank, if sign { -last } else { last })
}

/// The polynomial of the given degree at most with these values at 0, 1, 2, …, times a positive number.
///
/// Newton's form Σ Δᵏ t (t - 1) … (t - k + 1) / k!, times degree!.
pub(super) fn through(values: Vec<IBig>) -> Polynomial {
    let count = values.len();
    let mut differences = values;
    let mut leading = Vec::with_capacity(count);
    while let Some(first) = differences.first() {
        leading.push(first.clone());
        differences = differences.windows(2).map(|w| &w[1] - &w[0]).collect();
    }
    let mut result = vec![IBig::ZERO; count];
    let mut falling: Polynomial = vec![IBig::ONE];
    // degree! / k!
    let mut weights = vec![IBig::ONE; count];
    for k in (0..count.saturating_sub(1)).rev() {
        weights[k] = &weights[k + 1] * IBig::from(k + 1);
    }
    for k in 0..count {
        let by = &leading[k] * &weights[k];
        for (sum, c) in result.iter_mut().zip(&falling) {
            *sum += &by * c;
        }
        let mut next = vec![IBig::ZERO; falling.len() + 1];
        for (i, c) in falling.iter().enumerate() {
            next[i + 1] += c;
            next[i] -= c * IBig::from(k);
        }
        falling = next;
    }
    while result.last().is_some_and(IBig::is_zero) {
        result.pop();
    }
    result
}

/// Rounds of the simultaneous iteration.
const ROUNDS: usize = 400;

/// All roots of a polynomial with real coefficients and simple roots, no two discs meeting, with about so many
/// bits; `None` where they are not separated with these.
///
/// The roots lie in the discs around z_i with radius d |p(z_i) / (a Π (z_i - z_j))|, d the degree and a the
/// leading coefficient, and each component of their union holds as many as it has discs (B. T. Smith, J. ACM 17
/// (1970) 661). One alone in its disc is real if the conjugate of its disc meets no other:
/// its imaginary part is exactly 0 then.
pub(super) fn roots(p: &Polynomial, bits: usize) -> Option<Vec<Wide>> {
    let degree = p.len().checked_sub(1)?;
    if degree == 0 {
        return Some(Vec::new());
    }
    let c: Vec<Big> = p.iter().map(|c| Big::from_parts(c.clone(), 0, bits)).collect();
    let lead = Wide { re: c[degree].clone(), im: Big::zero(bits) };
    let mut z = begin(p, bits);
    let value = |z: &Wide| {
        c.iter().rev().fold(Wide::zero(bits), |sum, c| {
            let mut next = sum.mul(z);
            next.re = &next.re + c;
            next
        })
    };
    // Weierstrass, Durand, Kerner: steps that are also the centres' distances from the roots.
    let corrections = |z: &[Wide]| -> Vec<Wide> {
        let others = |i: usize| (0..degree).filter(move |&j| j != i);
        let product = |i: usize| others(i).fold(lead.clone(), |product, j| product.mul(&z[i].sub(&z[j])));
        (0..degree).map(|i| value(&z[i]).div(&product(i))).collect()
    };
    let mut least = f64::INFINITY;
    let mut stalled = 0;
    for _ in 0..ROUNDS {
        let steps = corrections(&z);
        let mut most = f64::NEG_INFINITY;
        for (z, step) in z.iter_mut().zip(&steps) {
            if !step.is_finite() {
                // Two points have met, or noise is all there is.
                continue;
            }
            let size = (z.re.mid_upper() + z.im.mid_upper()).log2();
            let change = (step.re.mid_upper() + step.im.mid_upper()).log2();
            most = most.max(change - size);
            *z = rounded(&z.sub(step), false, bits);
        }
        if most < least - 1.0 {
            least = most;
            stalled = 0;
        } else {
            stalled += 1;
        }
        if most < -(bits as f64) + 16.0 || stalled > 60 || least < -40.0 && stalled > 4 {
            break;
        }
    }
    let steps = corrections(&z);
    let radius = |step: &Wide| (step.re.abs_upper() + step.im.abs_upper()) * Magnitude::from_f64(degree as f64);
    let radii: Vec<Magnitude> = steps.iter().map(radius).collect();
    let apart = |a: &Wide, b: &Wide| {
        let difference = a.sub(b);
        difference.re.abs_lower().max(difference.im.abs_lower())
    };
    if (0..degree).any(|i| (0..i).any(|j| apart(&z[i], &z[j]) <= radii[i] + radii[j])) {
        return None;
    }
    let root = |i: usize| {
        let conjugate = z[i].conjugate();
        let alone = (0..degree).all(|j| j == i || apart(&conjugate, &z[j]) > radii[i] + radii[j]);
        let im = if alone { Big::zero(bits) } else { z[i].im.clone().with_added_radius(radii[i]) };
        let is_told = alone || !im.contains_zero();
        is_told.then(|| Wide { re: z[i].re.clone().with_added_radius(radii[i]), im })
    };
    (0..degree).map(root).collect()
}

/// First points on circles: the slopes of the upper hull of (k, log |c_k|) are near the logarithms of the moduli
/// (Bini, Numer. Algorithms 13 (1996) 179).
fn begin(p: &Polynomial, bits: usize) -> Vec<Wide> {
    let log = |c: &IBig| Big::from_parts(c.clone().abs(), 0, 64).abs_upper().log2();
    let mut hull: Vec<(f64, f64)> = Vec::new();
    for (k, c) in p.iter().enumerate().filter(|(_, c)| !c.is_zero()) {
        let point = (k as f64, log(c));
        while let [.., a, b] = hull[..] {
            if (b.1 - a.1) * (point.0 - a.0) <= (point.1 - a.1) * (b.0 - a.0) {
                hull.pop();
            } else {
                break;
            }
        }
        hull.push(point);
    }
    let mut points = Vec::with_capacity(p.len());
    for (side, pair) in hull.windows(2).enumerate() {
        let count = pair[1].0 - pair[0].0;
        let log = (pair[0].1 - pair[1].1) / count;
        let whole = log.floor();
        let radius = (log - whole).exp2();
        for k in 0..count as usize {
            let angle = std::f64::consts::TAU * (k as f64 + 0.25) / count + 0.7 + side as f64;
            let part = |x: f64| Big::from_f64(x, bits).scale(whole as i64);
            points.push(Wide { re: part(radius * angle.cos()), im: part(radius * angle.sin()) });
        }
    }
    points
}
