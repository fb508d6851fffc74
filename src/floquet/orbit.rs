//! Periodic motions: found in doubles, proved to exist at any precision.

use std::cell::Cell;

use nalgebra::{DMatrix, DVector};

use super::basis::inverse;
use super::complex::Complex;
use super::monodromy::{Stop, Trip, trip};
use crate::flow::{Enclosure, Equations, Plain};
use crate::precision::{Ball, Magnitude};

/// Newton steps to a periodic motion, in doubles.
const NEWTON: usize = 60;
/// Steps in time that are made in doubles: some ten seconds.
pub(super) const SEARCH: usize = 2_000_000;
/// A trip that takes so many times the steps of the first one has gone astray.
const ASTRAY: usize = 20;
/// Newton steps from doubles on: each about doubles the digits.
const CORRECTIONS: usize = 7;
/// Sizes of the box about a periodic motion, in roundings of its scale, that are tried in turn.
const BOXES: [f64; 4] = [2e4, 2e7, 2e11, 2e15];

/// A periodic motion that was proved to exist.
pub(super) struct Orbit<S> {
    /// The state at t = 0.
    pub(super) start: Vec<S>,
    pub(super) trip: Trip<S>,
}

/// A motion that is periodic as far as doubles tell.
pub(super) struct Guess {
    pub(super) start: Vec<f64>,
    /// About the size of the state where it moves.
    scale: Vec<f64>,
}

/// Why no periodic motion was proved.
#[derive(Clone, Debug)]
pub(super) enum Lost {
    /// In words.
    Search(&'static str),
    /// What is found can't be followed over a period.
    Way(Stop),
}

impl From<Stop> for Lost {
    fn from(stop: Stop) -> Self {
        Self::Way(stop)
    }
}

/// Newton's method for the map over a period, in doubles. A period that takes more than `most_steps` is too long; all of it takes
/// `budget` steps at most.
pub(super) fn search(
    plain: &mut Plain,
    period: f64,
    start: &[f64],
    (most_steps, budget): (usize, usize),
) -> Result<Guess, Lost> {
    let n = start.len();
    let steps = Cell::new(0);
    plain.set_most_steps(usize::MAX);
    let mut travel = |x: &DVector<f64>, most: usize| {
        plain.set_most_steps(most);
        let count = |_: f64, _: &[f64], _: &[f64]| steps.set(steps.get() + 1);
        let (end, slopes) = plain.travel(0.0, period, x.as_slice(), count)?;
        let difference = DVector::from_vec(end) - x;
        let slopes = DMatrix::from_row_slice(n, n, &slopes) - DMatrix::identity(n, n);
        Some((difference, slopes))
    };
    let mut x = DVector::from_column_slice(start);
    let first = travel(&x, most_steps.saturating_add(1));
    if steps.get() > most_steps {
        return Err(Lost::Way(Stop::TooLong { steps: most_steps }));
    }
    let Some((mut difference, mut slopes)) = first else {
        let reason = "the motion from the guess ends before the period is over";
        return Err(Lost::Search(reason));
    };
    // Where it takes that much longer it has gone astray.
    let most = ASTRAY * (steps.get() + 10);
    let mut found = false;
    for _ in 0..NEWTON {
        let Some(step) = slopes.clone().lu().solve(&difference) else {
            return Err(Lost::Search("periodic motions are not isolated here"));
        };
        let small = step.norm() <= 1e-13 * (x.norm() + step.norm().min(1e-3));
        // Shorter steps as long as the way around is longer than before; measured in the step that it asks for.
        let mut shorter = 1.0;
        loop {
            let next = &x - &step * shorter;
            if let Some((other, turned)) = travel(&next, most) {
                let asked = slopes.clone().lu().solve(&other);
                let asked = asked.map_or(f64::INFINITY, |asked| asked.norm());
                if asked <= step.norm() * (1.0 - 0.25 * shorter) || small {
                    (x, difference, slopes) = (next, other, turned);
                    break;
                }
            }
            shorter *= 0.5;
            if steps.get() > budget {
                return Err(Lost::Search("the search takes too many steps"));
            }
            if shorter < 1e-6 {
                return Err(Lost::Search("the search ends where it comes no nearer"));
            }
        }
        if small || difference.norm() == 0.0 {
            found = true;
            break;
        }
    }
    if !found {
        return Err(Lost::Search("the search takes too many steps"));
    }
    // A box needs a scale where a component is 0.
    let mut scale = vec![f64::MIN_POSITIVE; n];
    plain.set_most_steps(usize::MAX);
    plain.travel(0.0, period, x.as_slice(), |_, state, _| {
        for (s, x) in scale.iter_mut().zip(state) {
            *s = s.max(x.abs());
        }
    });
    let start = x.as_slice().to_vec();
    Ok(Guess { start, scale })
}

/// The periodic motion near a state: found by Newton's method on the map over a period, proved by Krawczyk's theorem (R.
/// Krawczyk, Computing 4 (1969) 187): with C about (DP - 1)⁻¹ and F(x) = P(x) - x, if
/// K = c - C F(c) + (1 - C DF(X)) (X - c) lies inside X, then X holds exactly one zero of F, and K holds it.
pub(super) fn orbit<S: Enclosure>(
    equations: &Equations,
    period: &S,
    guess: &Guess,
    nearer: Option<&[Ball]>,
    steps: (usize, usize),
    precision: S::Precision,
) -> Result<Orbit<S>, Lost> {
    let n = guess.start.len();
    let rounding = S::rounding(precision);
    let largest = guess.scale.iter().fold(0.0_f64, |most, s| most.max(*s));
    let largest = if largest > 1e-200 { largest } else { 1.0 };
    let mut center: Vec<S> = match nearer {
        Some(known) => known.iter().map(|x| from_ball(x, precision)).collect(),
        None => guess
            .start
            .iter()
            .map(|x| S::exact(*x, precision))
            .collect(),
    };
    let mut asked: Vec<f64> = vec![0.0; n];
    let mut newton = None;
    for _ in 0..CORRECTIONS {
        let there = trip(equations, period, &center, &vec![0.0; n], steps, precision)?;
        let own = Correction::new(&there.monodromy, n, precision);
        let own = own.ok_or(Lost::Search("periodic motions are not isolated here"))?;
        let step = own.step(&there.image, &center);
        for (x, s) in center.iter_mut().zip(&step) {
            *x = x.sub(s).center();
        }
        asked = step.iter().map(Enclosure::abs_upper).collect();
        newton = Some(own);
        // What the next one will about be.
        let share = asked.iter().fold(0.0_f64, |most, a| most.max(*a)) / largest;
        if share.is_nan() || 1e3 * share * share <= BOXES[0] * rounding || share <= 100.0 * rounding
        {
            break;
        }
    }
    let Some(newton) = newton else {
        return Err(Lost::Search("periodic motions are not isolated here"));
    };
    for size in BOXES.map(|size| size * rounding) {
        let reach: Vec<f64> = guess
            .scale
            .iter()
            .zip(&asked)
            .map(|(s, a)| size * s.max(1e-3 * largest) + 4.0 * a.min(size * largest))
            .collect();
        let there = trip(equations, period, &center, &reach, steps, precision)?;
        if let Some(start) = newton.inside(&there, &center, &reach) {
            return Ok(Orbit { start, trip: there });
        }
    }
    Err(Lost::Search(
        "a motion was found, but not proved to be periodic",
    ))
}

/// The midpoint of a ball.
fn from_ball<S: Enclosure>(value: &Ball, precision: S::Precision) -> S {
    let (high, low) = (value.mid.hi, value.mid.lo);
    S::exact(high, precision)
        .add(&S::exact(low, precision))
        .center()
}

/// C of Krawczyk's theorem, taken as exactly what it is.
struct Correction<S: Enclosure> {
    n: usize,
    precision: S::Precision,
    inverse: Vec<S>,
}

impl<S: Enclosure> Correction<S> {
    /// About (DP - 1)⁻¹.
    fn new(monodromy: &[S], n: usize, precision: S::Precision) -> Option<Self> {
        let one = S::exact(1.0, precision);
        let entries = monodromy.iter().enumerate().map(|(at, slope)| {
            let own = if at / n == at % n {
                slope.sub(&one)
            } else {
                slope.clone()
            };
            Complex::new(own.center(), S::exact(0.0, precision))
        });
        let entries: Vec<Complex<S>> = entries.collect();
        let inverse = inverse(&entries, n, precision)?;
        Some(Self {
            n,
            precision,
            inverse: inverse.into_iter().map(|entry| entry.re).collect(),
        })
    }

    /// C F(c).
    fn step(&self, image: &[S], center: &[S]) -> Vec<S> {
        let difference: Vec<S> = image.iter().zip(center).map(|(p, x)| p.sub(x)).collect();
        let row = |row: &[S]| {
            let zero = S::exact(0.0, self.precision);
            let parts = row.iter().zip(&difference);
            parts.fold(zero, |sum, (c, d)| sum.add(&c.mul(d)))
        };
        self.inverse.chunks_exact(self.n).map(row).collect()
    }

    /// K, if it lies inside X.
    fn inside(&self, there: &Trip<S>, center: &[S], reach: &[f64]) -> Option<Vec<S>> {
        let n = self.n;
        let one = S::exact(1.0, self.precision);
        let zero = S::exact(0.0, self.precision);
        let step = self.step(&there.image, center);
        let mut start = Vec::with_capacity(n);
        for i in 0..n {
            // Row i of 1 - C (DP - 1), times the box.
            let mut spread = Magnitude::ZERO;
            for (j, reach) in reach.iter().enumerate() {
                let product = (0..n).fold(zero.clone(), |sum, k| {
                    let slope = &there.monodromy[n * k + j];
                    let own = if k == j {
                        slope.sub(&one)
                    } else {
                        slope.clone()
                    };
                    sum.add(&self.inverse[n * i + k].mul(&own))
                });
                let rest = if i == j { one.sub(&product) } else { product };
                spread = spread + rest.size() * Magnitude::from_f64(*reach);
            }
            if step[i].size() + spread >= Magnitude::from_f64(reach[i]) {
                return None;
            }
            start.push(center[i].sub(&step[i]).with_spread(spread));
        }
        start.iter().all(S::is_finite).then_some(start)
    }
}
