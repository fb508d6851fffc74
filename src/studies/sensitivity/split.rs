//! Into what equal exponents split: eigenvalues of small pencils of enclosures.

use faer::{Mat, c64};
use nalgebra::DMatrix;

use super::Enclosed;
use librate_core::modes::{self, Options, Problem};
use librate_core::order::Order;
use librate_core::precision::{Ball, Magnitude, Matrix, up};

/// Row sums of upper bounds; the largest, rounded up for at most `n` terms each.
fn largest_row(n: usize, entry: impl Fn(usize, usize) -> f64) -> f64 {
    let sums = (0..n).map(|i| (0..n).map(|j| entry(i, j)).sum::<f64>());
    up(sums.fold(0.0, f64::max) * (1.0 + n as f64 * f64::EPSILON))
}

/// The eigenvalues of A v = mu G v for symmetric A and positive definite G, by rising value; `None` where G is not shown to be
/// definite. They are those of normal modes.
pub(super) fn symmetric(a: &Matrix<Ball>, g: &Matrix<Ball>) -> Option<Vec<Ball>> {
    let dimension = a.rows().len();
    if a.entries().iter().all(Ball::is_zero) {
        return Some(vec![Ball::ZERO; dimension]);
    }
    let [mass, stiffness] = [g, a].map(|own| own.entries().to_vec());
    let problem = Problem { dimension, mass, stiffness, zero_vectors: Vec::new() };
    let found = modes::solve(&problem, &Options::default().without_vectors()).ok()?;
    let mut values: Vec<Ball> = found.modes.iter().map(|mode| mode.omega_squared).collect();
    values.order_by(|x, y| x.mid.hi.total_cmp(&y.mid.hi));
    values.iter().all(Ball::is_finite).then_some(values)
}

/// The eigenvalues of A v = mu G v, by rising imaginary part, each with a bound; `None` where G is not shown to be regular.
///
/// With U the eigenvectors of the middle and Z about (GU)⁻¹, both taken as exactly what they are, ZAU = H and ZGU = 1 + F. Where
/// f = ‖F‖ < 1 Gershgorin's argument applies to the row in which a vector is largest: |H_ii - mu| <= Σ_{j≠i} |H_ij| + |mu| f, and
/// |mu| <= ‖H‖/(1 - f). Discs that meet hold together as many eigenvalues as they are, since eigenvalues move continuously as the
/// rest grows from 0 (Horn and Johnson, theorem 6.1.1); each of these is given the hull of all.
pub(super) fn general(a: &Matrix<Enclosed>, g: &Matrix<Enclosed>) -> Option<Vec<Enclosed>> {
    let m = a.rows().len();
    if m == 1 {
        let value = a[(0, 0)].div(&g[(0, 0)]);
        return value.is_finite().then(|| vec![value]);
    }
    type Dense = DMatrix<c64>;
    let middle = |matrix: &Matrix<Enclosed>| Dense::from_fn(m, m, |i, j| matrix[(i, j)].to_c64());
    let (middle_a, middle_g) = (middle(a), middle(g));
    let product = middle_g.clone().try_inverse()? * &middle_a;
    if !product.iter().all(|x| x.is_finite()) {
        return None;
    }
    let eigen = Mat::from_fn(m, m, |i, j| product[(i, j)]).eigen().ok()?;
    let vectors = Dense::from_fn(m, m, |i, j| eigen.U()[(i, j)]);
    let inverse = (middle_g * &vectors).try_inverse()?;
    let exact = |matrix: &Dense| Matrix::from_fn(m, m, |i, j| Enclosed::from_c64(matrix[(i, j)], ()));
    let (vectors, inverse) = (exact(&vectors), exact(&inverse));
    let turned = |matrix: &Matrix<Enclosed>| inverse.mul(&matrix.mul(&vectors, ()), ());
    let (h, g) = (turned(a), turned(g));
    let one = Enclosed { re: Ball::ONE, im: Ball::ZERO };
    let f = largest_row(m, |i, j| {
        let unit = if i == j { one } else { Enclosed::zero(()) };
        g[(i, j)].sub(&unit).upper_bound().to_f64()
    });
    if f.is_nan() || f >= 0.5 {
        return None;
    }
    let reach = up(up(largest_row(m, |i, j| h[(i, j)].upper_bound().to_f64()) / (1.0 - f)) * f);
    let discs: Vec<Enclosed> = (0..m)
        .map(|i| {
            let rest: f64 = (0..m).filter(|j| *j != i).map(|j| h[(i, j)].upper_bound().to_f64()).sum();
            let rest = up(rest * (1.0 + m as f64 * f64::EPSILON) + reach);
            h[(i, i)].with_added_radius(Magnitude::from_f64(rest))
        })
        .collect();
    discs.iter().all(Enclosed::is_finite).then(|| joined(discs))
}

/// What meets is replaced by its hull, until nothing more meets; then by rising imaginary part.
fn joined(mut discs: Vec<Enclosed>) -> Vec<Enclosed> {
    let m = discs.len();
    let mut of: Vec<usize> = (0..m).collect();
    loop {
        let meeting = (0..m)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .find(|&(i, j)| of[i] != of[j] && discs[i].sub(&discs[j]).contains_zero());
        let Some((i, j)) = meeting else { break };
        let hull = discs[i].hull(&discs[j]);
        let (one, other) = (of[i], of[j]);
        for k in 0..m {
            if of[k] == one || of[k] == other {
                (of[k], discs[k]) = (other, hull);
            }
        }
    }
    discs.order_by(|a, b| {
        let key = |x: &Enclosed| (x.im.mid_f64(), x.re.mid_f64());
        let ((a, b), (c, d)) = (key(a), key(b));
        a.total_cmp(&c).then(b.total_cmp(&d))
    });
    discs
}
