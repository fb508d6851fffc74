//! What runs in this process: plain textbook use of nalgebra and faer, Jacobi rotations of the factor,
//! and librate.

use std::hint::black_box;

use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par, Side};
use librate::modes::{Kind, Options, PrecisionLevel};
use librate::number::Number;
use librate::oscillation::normal_modes;
use librate::precision::Ball;
use librate_core::modes::{Precise, solve_from};
use nalgebra::{DMatrix, SymmetricEigen};

use super::case::{Case, Origin};
use super::clock::fastest;
use super::judge::{Enclosure, binary};

/// Digits that librate is asked for; the first is what it takes unless told otherwise.
pub(crate) const ASKED: [usize; 5] = [10, 15, 25, 50, 100];

/// Eigenvalues in doubles, rising, and the CPU seconds that they took with their eigenvectors.
pub(crate) type Doubles = Result<(f64, Vec<f64>), String>;

/// Cholesky's reduction and nalgebra's `SymmetricEigen`.
pub(crate) fn with_nalgebra(case: &Case, patience: f64) -> Doubles {
    let n = case.n;
    let mass = DMatrix::from_column_slice(n, n, &case.mass);
    let stiffness = DMatrix::from_column_slice(n, n, &case.stiffness);
    let (seconds, result) = fastest(patience, || {
        let lower = mass.clone().cholesky().ok_or("M is not positive definite")?.l();
        let half = lower.solve_lower_triangular(&stiffness);
        let whole = half.and_then(|half| lower.solve_lower_triangular(&half.transpose()));
        let reduced = whole.ok_or("a factor of M is singular")?;
        let eigen = SymmetricEigen::try_new(reduced, f64::EPSILON, 0);
        let eigen = eigen.ok_or("no convergence")?;
        black_box(lower.tr_solve_lower_triangular(&eigen.eigenvectors));
        Ok::<_, &str>(eigen.eigenvalues.as_slice().to_vec())
    });
    Ok((seconds, rising(result?)?))
}

/// Cholesky's reduction and faer's `self_adjoint_eigen`.
pub(crate) fn with_faer(case: &Case, patience: f64) -> Doubles {
    let n = case.n;
    let mass = Mat::from_fn(n, n, |i, j| case.mass[i + n * j]);
    let stiffness = Mat::from_fn(n, n, |i, j| case.stiffness[i + n * j]);
    let (seconds, result) = fastest(patience, || {
        let lower = mass.llt(Side::Lower).map_err(|_| "M is not positive definite")?;
        let mut half = stiffness.clone();
        solve_lower_triangular_in_place(lower.L(), half.as_mut(), Par::Seq);
        let mut reduced = half.transpose().to_owned();
        solve_lower_triangular_in_place(lower.L(), reduced.as_mut(), Par::Seq);
        let eigen = reduced.self_adjoint_eigen(Side::Lower);
        let eigen = eigen.map_err(|_| "no convergence")?;
        let mut vectors = eigen.U().to_owned();
        solve_upper_triangular_in_place(lower.L().transpose(), vectors.as_mut(), Par::Seq);
        black_box(vectors);
        Ok::<_, &str>(eigen.S().column_vector().iter().copied().collect())
    });
    Ok((seconds, rising(result?)?))
}

/// One-sided Jacobi rotations of A L⁻ᵀ, where K = A Aᵀ with one square a row and M = L Lᵀ; K is never
/// added up. `None` where K is not a sum of squares.
pub(crate) fn with_jacobi(case: &Case, patience: f64) -> Option<Doubles> {
    let squares = case.squares.as_ref()?;
    let n = case.n;
    let mass = Mat::from_fn(n, n, |i, j| case.mass[i + n * j]);
    let (seconds, result) = fastest(patience, || {
        let lower = mass.llt(Side::Lower).map_err(|_| "M is not positive definite")?;
        let mut factor = Mat::<f64>::zeros(n, squares.len());
        for (to, square) in squares.iter().enumerate() {
            for &(place, entry) in &square.entries {
                factor[(place, to)] += square.weight.sqrt() * entry;
            }
        }
        solve_lower_triangular_in_place(lower.L(), factor.as_mut(), Par::Seq);
        // Column j: row j of the reduced factor, and below it column j of the rotations so far.
        let entries = |j: usize| {
            let factor = factor.row(j).iter().copied().collect::<Vec<_>>();
            let unit = (0..n).map(|i| f64::from(u8::from(i == j)));
            factor.into_iter().chain(unit).collect()
        };
        let mut columns: Vec<Vec<f64>> = (0..n).map(entries).collect();
        rotate(&mut columns, squares.len());
        let mut vectors = Mat::from_fn(n, n, |i, j| columns[j][squares.len() + i]);
        solve_upper_triangular_in_place(lower.L().transpose(), vectors.as_mut(), Par::Seq);
        black_box(vectors);
        let square = |column: &Vec<f64>| dot(&column[..squares.len()], &column[..squares.len()]);
        Ok::<_, &str>(columns.iter().map(square).collect())
    });
    Some(result.map_err(str::to_owned).and_then(|values| Ok((seconds, rising(values)?))))
}

fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// Rotates pairs of columns until all are orthogonal in their first `rows` entries (Demmel, Veselic, "Jacobi's
/// method is more accurate than QR", SIAM J. Matrix Anal. 13 (1992), algorithm 4.1).
fn rotate(columns: &mut [Vec<f64>], rows: usize) {
    let tolerance = f64::EPSILON * (rows.max(1) as f64).sqrt();
    for _ in 0..30 {
        let mut rotated = false;
        for q in 1..columns.len() {
            let (before, after) = columns.split_at_mut(q);
            let second = &mut after[0];
            for first in before {
                let (x, y) = (&first[..rows], &second[..rows]);
                let (a, b, c) = (dot(x, x), dot(y, y), dot(x, y));
                if c.abs() <= tolerance * a.sqrt() * b.sqrt() {
                    continue;
                }
                rotated = true;
                let zeta = (b - a) / (2.0 * c);
                let t = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
                let cosine = 1.0 / t.hypot(1.0);
                let sine = cosine * t;
                for (x, y) in first.iter_mut().zip(second.iter_mut()) {
                    (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
                }
            }
        }
        if !rotated {
            break;
        }
    }
}

/// # Errors
/// Where there is something that is not a number.
fn rising(mut values: Vec<f64>) -> Result<Vec<f64>, String> {
    if !values.iter().all(|x| x.is_finite()) {
        return Err("not a number".to_owned());
    }
    values.sort_by(f64::total_cmp);
    Ok(values)
}

/// What librate says.
pub(crate) struct Answer {
    pub(crate) seconds: f64,
    /// ω², rising.
    pub(crate) values: Vec<Enclosure>,
    pub(crate) level: PrecisionLevel,
}

/// All modes with their shapes, to so many digits.
pub(crate) fn with_librate(case: &Case, digits: usize, patience: f64) -> Result<Answer, String> {
    let options = Options::default().digits(digits);
    match &case.origin {
        Origin::Model(linearized) => {
            let (seconds, result) = fastest(patience, || normal_modes(linearized, &options));
            let normal = result.map_err(|error| error.to_string())?;
            let modes = normal.modes.iter();
            Ok(Answer {
                seconds,
                values: modes
                    .filter_map(|mode| {
                        let square = mode.omega_squared.as_ref()?;
                        Some(enclosure(mode.kind, square, mode.precise.as_deref()))
                    })
                    .collect(),
                level: normal.level,
            })
        }
        Origin::Matrices(exact) => {
            let (seconds, result) = fastest(patience, || solve_from(&exact.problem, exact.as_ref(), &options));
            let spectrum = result.map_err(|error| error.to_string())?;
            let modes = spectrum.modes.iter();
            Ok(Answer {
                seconds,
                values: modes.map(|mode| enclosure(mode.kind, &mode.omega_squared, mode.precise.as_deref())).collect(),
                level: spectrum.level,
            })
        }
    }
}

fn enclosure(kind: Kind, ball: &Ball, precise: Option<&Precise>) -> Enclosure {
    let double = |x: f64| Number::from_f64_exact(x).unwrap_or_else(|| Number::from(0));
    match precise {
        _ if kind == Kind::Zero => Enclosure { mid: Number::from(0), radius: Number::from(0) },
        Some(precise) => {
            let (significand, exponent) = precise.omega_squared.mid();
            let (mantissa, place) = precise.omega_squared.radius().parts();
            Enclosure {
                mid: binary(significand.clone(), exponent),
                radius: double(mantissa).mul(&binary(1.into(), place)),
            }
        }
        None => Enclosure { mid: double(ball.mid.hi).add(&double(ball.mid.lo)), radius: double(ball.radius) },
    }
}
