//! The monodromy matrix: the derivative of the state after a period by the state before it.

use super::error::FloquetError;
use crate::flow::{Enclosing, Enclosure, Equations, Plain};
use crate::precision::{Ball, Scalar, up};
use crate::span::Span;
use nalgebra::{DMatrix, DVector};

/// Steps of a trip over one period.
const MOST_STEPS: usize = 100_000;
/// Newton steps to a periodic motion.
const NEWTON: usize = 60;
/// Sizes of the box about a periodic motion, beside its scale, that are tried in turn.
const BOXES: [f64; 4] = [1e-27, 1e-24, 1e-20, 1e-16];

/// Where a trip over a period leads.
pub(super) struct Trip<S> {
    /// The state after the period, from the midpoint of the initial one.
    pub(super) image: Vec<S>,
    /// Its derivative by the initial state, for every initial state in the box.
    pub(super) monodromy: Vec<S>,
}

/// A trip over a period, from all points within `reach` of `start`.
///
/// The state at each step is m + T d + e for the initial displacement d in its box: a parallelepiped, so that the turning
/// of the initial box costs nothing, and a box e for what has been rounded (R. J. Lohner, in Computational Ordinary
/// Differential Equations (1992), 425). With T over the whole state the image of x is that of the midpoint c plus T (x - c).
pub(super) fn trip<S: Enclosure>(
    equations: &Equations,
    period: &S,
    start: &[S],
    reach: &[f64],
    order: usize,
    precision: S::Precision,
) -> Result<Trip<S>, f64> {
    let n = equations.dimension();
    let mut walk = Enclosing::<S>::new(equations, order, precision);
    let zero = S::exact(0.0, precision);
    let mut total = walk.unit();
    let mut middle = start.to_vec();
    let mut rest = vec![zero.clone(); start.len()];
    let initial: Vec<S> = reach.iter().map(|r| zero.widened(*r)).collect();
    let times = |matrix: &[S], vector: &[S]| -> Vec<S> {
        let row = |i: usize| {
            let parts = matrix[n * i..n * (i + 1)].iter().zip(vector);
            parts.fold(zero.clone(), |sum, (a, x)| sum.add(&a.mul(x)))
        };
        (0..vector.len()).map(row).collect()
    };
    let mut time = zero.clone();
    for _ in 0..MOST_STEPS {
        let spread = times(&total, &initial);
        let state: Vec<S> = middle
            .iter()
            .zip(&rest)
            .zip(&spread)
            .map(|((m, e), s)| m.add(e).add(s))
            .collect();
        for ((e, m), x) in rest.iter_mut().zip(&middle).zip(&state) {
            *e = e.add(&m.sub(&x.center()));
        }
        let left = period.sub(&time);
        let Some(step) = walk.step(&time, &state, &left) else {
            return Err(time.middle());
        };
        middle = step.image.iter().map(S::center).collect();
        rest = times(&step.slopes, &rest)
            .iter()
            .zip(&step.image)
            .zip(&middle)
            .map(|((e, image), m)| e.add(&image.sub(m)))
            .collect();
        total = (0..n * n)
            .map(|at| {
                let (i, j) = (at / n, at % n);
                (0..n).fold(zero.clone(), |sum, k| {
                    sum.add(&step.slopes[n * i + k].mul(&total[n * k + j]))
                })
            })
            .collect();
        if step.whole {
            let image = middle.iter().zip(&rest).map(|(m, e)| m.add(e)).collect();
            return Ok(Trip {
                image,
                monodromy: total,
            });
        }
        time = time.add(&step.length);
    }
    Err(time.middle())
}

/// A periodic motion that was proved to exist.
pub(super) struct Orbit {
    /// The state at t = 0.
    pub(super) start: Vec<Ball>,
    pub(super) monodromy: Vec<Ball>,
}

/// Newton's method for the map over a period, in doubles.
fn newton(
    plain: &mut Plain,
    period: f64,
    start: &[f64],
    span: Span,
) -> Result<(DVector<f64>, DMatrix<f64>), FloquetError> {
    let n = start.len();
    let lost = |reason: String| FloquetError::NoPeriodicMotion { reason, span };
    let mut travel = |x: &DVector<f64>| {
        let (end, slopes) = plain.travel(0.0, period, x.as_slice(), |_, _, _| {})?;
        let difference = DVector::from_vec(end) - x;
        let slopes = DMatrix::from_row_slice(n, n, &slopes) - DMatrix::identity(n, n);
        Some((difference, slopes))
    };
    let mut x = DVector::from_column_slice(start);
    let Some((mut difference, mut slopes)) = travel(&x) else {
        return Err(lost(
            "the motion from the guess ends before the period is over".to_owned(),
        ));
    };
    for _ in 0..NEWTON {
        let Some(step) = slopes.clone().lu().solve(&difference) else {
            return Err(lost("periodic motions are not isolated here".to_owned()));
        };
        let small = step.norm() <= 1e-13 * (x.norm() + step.norm().min(1e-3));
        // Shorter steps as long as the way around is longer than before; measured in the step that it asks for.
        let mut shorter = 1.0;
        loop {
            let next = &x - &step * shorter;
            if let Some((other, turned)) = travel(&next) {
                let asked = slopes.clone().lu().solve(&other);
                let asked = asked.map_or(f64::INFINITY, |asked| asked.norm());
                if asked <= step.norm() * (1.0 - 0.25 * shorter) || small {
                    (x, difference, slopes) = (next, other, turned);
                    break;
                }
            }
            shorter *= 0.5;
            if shorter < 1e-6 {
                return Err(lost("the search ends where it comes no nearer".to_owned()));
            }
        }
        if small || difference.norm() == 0.0 {
            return Ok((x, slopes));
        }
    }
    Err(lost("the search takes too many steps".to_owned()))
}

/// The periodic motion near a state: found by Newton's method on the map over a period, proved by Krawczyk's theorem (R.
/// Krawczyk, Computing 4 (1969) 187): with C about (DP - 1)⁻¹ and F(x) = P(x) - x, if
/// K = c - C F(c) + (1 - C DF(X)) (X - c) lies inside X, then X holds exactly one zero of F, and K holds it.
pub(super) fn orbit(
    equations: &Equations,
    period: &Ball,
    start: &[f64],
    order: usize,
    span: Span,
) -> Result<Orbit, FloquetError> {
    let n = start.len();
    let lost = |reason: &str| FloquetError::NoPeriodicMotion {
        reason: reason.to_owned(),
        span,
    };
    let mut plain = Plain::new(equations);
    let (found, slopes) = newton(&mut plain, period.mid_f64(), start, span)?;
    let Some(inverse) = slopes.try_inverse() else {
        return Err(lost("periodic motions are not isolated here"));
    };
    let correction = |image: &[Ball], center: &[Ball]| -> Vec<Ball> {
        let difference: Vec<Ball> = image.iter().zip(center).map(|(p, x)| *p - *x).collect();
        (0..n)
            .map(|i| {
                (0..n).fold(Ball::ZERO, |sum, j| {
                    sum + Ball::from(inverse[(i, j)]) * difference[j]
                })
            })
            .collect()
    };
    let follow = |center: &[Ball], reach: &[f64]| {
        trip::<Ball>(equations, period, center, reach, order, ()).map_err(|time| {
            FloquetError::Singular {
                time: short(time),
                span,
            }
        })
    };
    let mut center: Vec<Ball> = found.iter().map(|x| Ball::exact(*x)).collect();
    let mut asked = vec![0.0; n];
    for _ in 0..2 {
        let there = follow(&center, &vec![0.0; n])?;
        let step = correction(&there.image, &center);
        center = center
            .iter()
            .zip(&step)
            .map(|(x, s)| Ball::from((*x - *s).mid))
            .collect();
        asked = step.iter().map(Ball::abs_upper).collect();
    }
    // About the size of the state where it moves, so that a box has a scale where a component is 0.
    let mut scale = vec![f64::MIN_POSITIVE; n];
    plain.travel(0.0, period.mid_f64(), found.as_slice(), |_, state, _| {
        for (s, x) in scale.iter_mut().zip(state) {
            *s = s.max(x.abs());
        }
    });
    let largest = scale.iter().fold(0.0_f64, |most, s| most.max(*s));
    let largest = if largest > 1e-200 { largest } else { 1.0 };
    for size in BOXES {
        let reach: Vec<f64> = scale
            .iter()
            .zip(&asked)
            .map(|(s, a)| size * s.max(1e-3 * largest) + 4.0 * a.min(size * largest))
            .collect();
        let there = follow(&center, &reach)?;
        let step = correction(&there.image, &center);
        let mut inside = true;
        let mut start = Vec::with_capacity(n);
        for i in 0..n {
            // Row i of 1 - C (DP - 1), times the box.
            let mut spread = 0.0;
            for (j, reach) in reach.iter().enumerate() {
                let product = (0..n).fold(Ball::ZERO, |sum, k| {
                    let slope = there.monodromy[n * k + j];
                    let own = if k == j { slope - Ball::ONE } else { slope };
                    sum + Ball::from(inverse[(i, k)]) * own
                });
                let unit = if i == j { Ball::ONE } else { Ball::ZERO };
                spread = up(spread + (unit - product).abs_upper() * reach);
            }
            let image = up(step[i].abs_upper() + spread);
            inside &= image < reach[i];
            start.push((center[i] - step[i]).with_added_radius(spread));
        }
        if inside && start.iter().all(Scalar::is_finite) {
            return Ok(Orbit {
                start,
                monodromy: there.monodromy,
            });
        }
    }
    Err(lost("a motion was found, but not proved to be periodic"))
}

/// A number in a message.
pub(super) fn short(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    text.to_owned()
}
