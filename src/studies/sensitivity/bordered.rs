//! Vectors of an exponent, enclosed: the kernel of P(lambda) = lambda² M + lambda D + S and that of its adjoint.
//!
//! With borders X₀ and Y₀ of m columns each
//!
//! ```text
//!   [ P(lambda)  Y₀ ] [ X ]   [ 0 ]
//!   [ X₀ᴴ         0 ] [ G ] = [ 1 ]
//! ```
//!
//! is regular beside an exponent with m vectors, and solved with a bound. Where lambda is such an exponent and has m
//! independent vectors, the m by m matrix G is 0 and the columns of X span their space: a regular matrix with a kernel of P of dimension m has
//! no room for more, and for z in it (z - X X₀ᴴz, -G X₀ᴴz) solves the system with 0 on the right. The adjoint system has Y likewise, and
//! G' = -Yᴴ P' X by any parameter, lambda included (W. Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria (2000),
//! chapter 3; W.-J. Beyn, C. Effenberger, D. Kressner, Numer. Math. 119 (2011) 489).

use faer::c64;
use nalgebra::DMatrix;

use super::{Enclosed, Rows, real};
use librate_core::linearize::WithMultipliers;
use librate_core::precision::{Ball, System, power_of_two};

/// Borders are vectors of P at an exponent off by this much of itself: they need not be good, and P must be regular there.
const OFF: f64 = power_of_two(-26);

type Dense = DMatrix<c64>;

/// Columns X and Y as above, one list each.
pub(super) struct Kernel {
    pub(super) x: Rows<Enclosed>,
    pub(super) y: Rows<Enclosed>,
}

/// An exponent as far as it is known, and its square.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) exponent: Enclosed,
    pub(super) square: Enclosed,
}

/// P(lambda), row by row.
fn polynomial(whole: &WithMultipliers, place: Place) -> Vec<Enclosed> {
    let n = whole.order;
    let at = |i: usize, j: usize| {
        let k = i + n * j;
        let mut entry = real(whole.stiffness[k]);
        if !whole.mass[k].is_zero() {
            entry = entry.add(&place.square.times(&whole.mass[k]));
        }
        match &whole.velocity {
            Some(velocity) if !velocity[k].is_zero() => entry.add(&place.exponent.times(&velocity[k])),
            _ => entry,
        }
    };
    (0..n * n).map(|k| at(k / n, k % n)).collect()
}

/// The vectors of the exponents at a place, `count` of them; `None` where that is not shown. `own_left`: P is
/// symmetric and real, so that Y is X.
pub(super) fn kernel(whole: &WithMultipliers, place: Place, count: usize, own_left: bool) -> Option<Kernel> {
    let n = whole.order;
    let entries = polynomial(whole, place);
    if !entries.iter().all(Enclosed::is_finite) {
        return None;
    }
    // Rows and columns of like size, or small masses look like null vectors: by the terms, whose sum may vanish.
    let (one, two) = (place.exponent.upper_bound().to_f64(), place.square.upper_bound().to_f64());
    let term = |k: usize| {
        let velocity = whole.velocity.as_ref().map_or(0.0, |all| all[k].mid_f64());
        let sizes = [whole.mass[k].mid_f64() * two, velocity * one];
        sizes.iter().map(|x| x.abs()).sum::<f64>() + whole.stiffness[k].mid_f64().abs()
    };
    let units: Vec<i32> = (0..n)
        .map(|i| {
            let size = (0..n).fold(0.0_f64, |most, j| most.max(term(i + n * j)));
            (size > 0.0).then(|| -(0.5 * size.log2()).round() as i32)
        })
        .collect::<Option<_>>()?;
    let scaled: Vec<Enclosed> = (0..n * n).map(|k| entries[k].scale(i64::from(units[k / n] + units[k % n]))).collect();
    let (right, left) = borders(whole, place, &units, count, own_left)?;
    let is_real = scaled.iter().all(|x| x.im.is_zero());
    let system = bordered(n, &scaled, &right, &left, is_real)?;
    let solve = |system: &System| -> Option<Rows<Enclosed>> {
        (0..count).map(|k| column(n, count, k, system, is_real, &units)).collect()
    };
    let (x, corner) = parts(solve(&system)?, n);
    if own_left {
        return Some(Kernel { y: x.clone(), x });
    }
    // With fewer vectors than exponents G is not 0.
    if !corner.iter().flatten().all(Enclosed::contains_zero) {
        return None;
    }
    let (y, _) = parts(solve(&system.transposed()?)?, n);
    Some(Kernel { x, y })
}

/// What stands above and below in each column.
fn parts(columns: Rows<Enclosed>, n: usize) -> (Rows<Enclosed>, Rows<Enclosed>) {
    columns.into_iter().map(|mut column| (column.drain(..n).collect(), column)).unzip()
}

/// About the vectors and left vectors, in units: a step of inverse iteration beside the exponent.
fn borders(
    whole: &WithMultipliers,
    place: Place,
    units: &[i32],
    count: usize,
    own_left: bool,
) -> Option<(Dense, Dense)> {
    let n = whole.order;
    let exact = |value: c64| Enclosed::from_c64(value, ());
    let beside = Place {
        exponent: exact(place.exponent.to_c64() * (1.0 + OFF)),
        square: exact(place.square.to_c64() * (1.0 + OFF) * (1.0 + OFF)),
    };
    let entries = polynomial(whole, beside);
    let matrix = Dense::from_fn(n, n, |i, j| entries[n * i + j].scale(i64::from(units[i] + units[j])).to_c64());
    // A start without a pattern of its own: the generator of Knuth's MMIX.
    let mut state = 1_u64;
    let start = Dense::from_fn(n, count, |_, _| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        c64::new((state >> 40) as f64 * power_of_two(-24) - 0.5, 0.0)
    });
    let step = |matrix: Dense| -> Option<Dense> {
        let basis = matrix.lu().solve(&start)?.qr().q();
        let finite = basis.iter().all(|x| x.re.is_finite() && x.im.is_finite());
        (finite && basis.ncols() == count).then_some(basis)
    };
    let adjoint = matrix.adjoint();
    let right = step(matrix)?;
    let left = if own_left { right.clone() } else { step(adjoint)? };
    Some((right, left))
}

/// The bordered system in real numbers: real parts before imaginary ones, these only where there are any.
fn bordered(n: usize, scaled: &[Enclosed], right: &Dense, left: &Dense, real: bool) -> Option<System> {
    let size = n + right.ncols();
    let whole = |i: usize, j: usize| {
        if i < n && j < n {
            scaled[n * i + j]
        } else if i < n {
            Enclosed::from_c64(left[(i, j - n)], ())
        } else if j < n {
            Enclosed::from_c64(right[(j, i - n)].conj(), ())
        } else {
            Enclosed::zero(())
        }
    };
    if real {
        let entries = (0..size * size).map(|k| whole(k / size, k % size).re);
        return System::new(size, entries.collect());
    }
    System::of_complex(size, whole)
}

/// The solution for 1 in row k of the border, in the coordinates of P above, as it is below.
fn column(n: usize, count: usize, k: usize, system: &System, real: bool, units: &[i32]) -> Option<Vec<Enclosed>> {
    let size = n + count;
    let mut right = vec![Ball::ZERO; if real { size } else { 2 * size }];
    *right.get_mut(n + k)? = Ball::ONE;
    let found = system.solve(&right)?;
    let part = |i: usize| Enclosed { re: found[i], im: if real { Ball::ZERO } else { found[size + i] } };
    Some((0..size).map(|i| part(i).scale(units.get(i).map_or(0, |unit| i64::from(*unit)))).collect())
}
