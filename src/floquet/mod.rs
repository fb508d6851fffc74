//! Models that are driven periodically: Floquet multipliers, with bounds.
//!
//! The equations of motion are written out and linearised about an equilibrium at which no force acts at any
//! time, or about a periodic motion, which is searched for and proved. Followed over one period ([`crate::flow`]) they give
//! the monodromy matrix, whose eigenvalues are the multipliers: what each normal solution is multiplied by in a period. (W.
//! Magnus and S. Winkler, Hill's Equation (1966); V. A. Yakubovich and V. M. Starzhinskii, Linear Differential Equations with
//! Periodic Coefficients (1975).)
//!
//! It never takes a multiplier for one on the unit circle because it is near: there it lies by symmetry, or the bounds say
//! nothing and neither does the result.

mod codes;
mod error;
mod monodromy;
pub(crate) mod motion;
mod multipliers;
mod resonance;

pub use error::FloquetError;
pub use multipliers::{Multiplier, Place};
pub use resonance::Resonance;

use crate::expr::{ExprId, Tape};
use crate::flow::Equations;
use crate::linearize::constant;
use crate::model::Model;
use crate::precision::{Ball, Big, Scalar};
use monodromy::{orbit, short, trip};
use motion::Driven;

/// The order of the steps in double-double: about the best for 32 digits.
const ORDER: usize = 34;
/// Bits that are tried in turn where double-double does not decide.
const MORE_BITS: [usize; 2] = [256, 512];
/// Times at which a period is tried.
const TRIALS: u32 = 24;

/// What a driven model does about an equilibrium or a periodic motion.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Floquet {
    /// The period of the drive in SI.
    pub period: Ball,
    /// The coordinates at t = 0, in SI.
    pub place: Vec<Ball>,
    /// Their velocities at t = 0, in SI.
    pub velocities: Vec<Ball>,
    /// Whether the place is an equilibrium at all times; otherwise a periodic motion passes it.
    pub rests: bool,
    /// The multipliers, two for each coordinate, by falling modulus; those on the unit circle by rising angle, the one
    /// above the real axis first.
    pub multipliers: Vec<Multiplier>,
    /// Whether small displacements stay small; `None` where bounds do not decide.
    pub stable: Option<bool>,
    /// ln max |multiplier| / period; `None` where bounds do not tell it from 0.
    pub growth_rate: Option<Ball>,
    /// The frequencies of the equations averaged over a period, in rad/s, rising: about those of the model without its
    /// drive, where that is weak. Directions without restoring force have none.
    pub frequencies: Vec<f64>,
    /// Which resonance with the drive makes it unstable.
    pub resonance: Option<Resonance>,
    /// The derivative of coordinates and velocities at the end of a period by those at its beginning, row by row.
    pub monodromy: Vec<Ball>,
}

impl Floquet {
    /// A bound of the distance of every multiplier from the midpoints of its parts in doubles.
    #[must_use]
    pub fn error_bound(&self) -> f64 {
        let errors = self.multipliers.iter().map(Multiplier::error);
        errors.fold(0.0, f64::max)
    }
}

/// The multipliers of a model that is periodic in time.
///
/// They are those about the equilibrium that the model gives, or the point 0, if no force acts there at any time; else
/// about the periodic motion found from the guess (0 where there is none).
///
/// # Errors
/// Where nothing depends on the time, the period is missing or none, a given equilibrium moves, no periodic motion is
/// found, or the motion can't be followed over a period.
pub fn floquet(model: &Model) -> Result<Floquet, FloquetError> {
    let mut driven = Driven::new(model, &[])?;
    let period = period(&driven)?;
    let n = driven.dimension();
    let point = point(model, &mut driven);
    let numbers: Vec<f64> = point
        .iter()
        .map(|value| constant(&driven.pool, *value).map_or(0.0, |value| value.mid_f64()))
        .collect();
    check_period(&driven, &period, &numbers)?;
    let rests = rests(model, &mut driven, &point)?;
    let (equations, found) = if rests {
        let slopes = driven.linear(&point)?;
        let not_defined = |_| FloquetError::NotDefined {
            span: driven.driven_at,
        };
        let equations = Equations::linear(&driven.pool, driven.time, 2 * n, &[], &slopes);
        (equations.map_err(not_defined)?, None)
    } else {
        let equations = driven.equations()?;
        let mut start = numbers;
        start.resize(2 * n, 0.0);
        let found = orbit(&equations, &period, &start, ORDER, driven.driven_at)?;
        (equations, Some(found))
    };
    let symplectic = !driven.damped;
    let singular = |time: f64| FloquetError::Singular {
        time: short(time),
        span: driven.driven_at,
    };
    let (state, monodromy) = match found {
        Some(found) => (found.start, found.monodromy),
        None => {
            let trip = trip::<Ball>(&equations, &period, &[], &[], ORDER, ()).map_err(singular)?;
            let place = point.iter();
            let place = place.map(|value| constant(&driven.pool, *value).unwrap_or(Ball::ZERO));
            (place.collect(), trip.monodromy)
        }
    };
    let mut multipliers = by_blocks(&monodromy, 2 * n, symplectic);
    if rests && n == 1 {
        for bits in MORE_BITS {
            if stable(&multipliers).is_some() {
                break;
            }
            let Some(period) = precise(&driven, bits) else {
                break;
            };
            let order = bits / 3;
            let Ok(trip) = trip::<Big>(&equations, &period, &[], &[], order, bits) else {
                break;
            };
            multipliers = multipliers::of_two(&trip.monodromy, symplectic, bits);
        }
    }
    multipliers.sort_by(|a, b| {
        let angle = |m: &Multiplier| m.im.mid_f64().abs().atan2(m.re.mid_f64());
        let circle = |m: &Multiplier| m.place == Place::On;
        let by_size = if circle(a) && circle(b) {
            std::cmp::Ordering::Equal
        } else {
            b.modulus.mid_f64().total_cmp(&a.modulus.mid_f64())
        };
        by_size
            .then(angle(a).total_cmp(&angle(b)))
            .then(b.im.mid_f64().total_cmp(&a.im.mid_f64()))
    });
    let frequencies = resonance::frequencies(&equations, period.mid_f64(), &state);
    let stable = stable(&multipliers);
    Ok(Floquet {
        growth_rate: growth_rate(&multipliers, stable, &period),
        resonance: match stable {
            Some(false) => resonance::resonance(&multipliers, &frequencies, period.mid_f64()),
            Some(true) | None => None,
        },
        velocities: match state.get(n..) {
            Some(velocities) if velocities.len() == n => velocities.to_vec(),
            _ => vec![Ball::ZERO; n],
        },
        place: state[..n.min(state.len())].to_vec(),
        period,
        rests,
        multipliers,
        stable,
        frequencies,
        monodromy,
    })
}

/// The period, which is a positive number.
fn period(driven: &Driven) -> Result<Ball, FloquetError> {
    let (value, span) = driven.period;
    let number = constant(&driven.pool, value);
    match number.filter(Ball::is_positive) {
        Some(number) => Ok(number),
        None => Err(FloquetError::PeriodNotPositive {
            value: match number {
                Some(number) if number.is_finite() => short(number.mid_f64()),
                Some(_) | None => "not defined".to_owned(),
            },
            span,
        }),
    }
}

/// The period with more bits.
fn precise(driven: &Driven, bits: usize) -> Option<Big> {
    let tape = Tape::compile(&driven.pool, &[driven.period.0], &[]).ok()?;
    let values = tape.prepare::<Big>(bits).evaluate(&[], &mut Vec::new());
    values.into_iter().next().filter(Big::is_positive)
}

/// Where motions are looked at: as given, as guessed, else 0.
pub(crate) fn point(model: &Model, driven: &mut Driven) -> Vec<ExprId> {
    let given = model.equilibria.iter().zip(&model.guesses);
    given
        .map(|(equilibrium, guess)| match equilibrium.or(*guess) {
            Some(given) => driven.with_values(given.symbolic),
            None => driven.pool.zero(),
        })
        .collect()
}

/// Whether no force acts on what rests at a point, at any time.
pub(crate) fn rests(
    model: &Model,
    driven: &mut Driven,
    point: &[ExprId],
) -> Result<bool, FloquetError> {
    let moved = driven.moved(point);
    let energy = driven.driven_at;
    for (at, moved) in moved.iter().enumerate() {
        if *moved == Some(false) {
            continue;
        }
        // Any given coordinate makes the point one that is asked for.
        let given = model.equilibria[at].or(model.equilibria.iter().flatten().next().copied());
        if let (Some(given), Some(true)) = (given, moved) {
            return Err(FloquetError::EquilibriumMoves {
                coordinate: model.coordinates[at].name.clone(),
                force: driven
                    .force_text(at, point)
                    .unwrap_or_else(|| "that is not 0".to_owned()),
                span: given.span,
                energy,
            });
        }
    }
    Ok(moved.iter().all(|moved| *moved == Some(false)))
}

/// Compares the equations of motion at many states with those a period later; states are drawn around the point. What
/// is analytic and agrees at so many irregular places to 28 digits is taken to agree.
fn check_period(driven: &Driven, period: &Ball, point: &[f64]) -> Result<(), FloquetError> {
    let undefined = FloquetError::NotDefined {
        span: driven.driven_at,
    };
    let Ok(tape) = Tape::compile(&driven.pool, &driven.expressions(), &driven.symbols()) else {
        return Err(undefined);
    };
    let prepared = tape.prepare::<Ball>(());
    let mut scratch = Vec::new();
    let mut compared = false;
    for trial in 1..=TRIALS {
        // Multiples of an irrational number spread evenly.
        let fraction = |k: u32| {
            let x = f64::from(trial * 64 + k) * 0.618_033_988_749_894_9;
            x - x.floor()
        };
        let time = *period * Ball::exact(fraction(0));
        let scale = if trial % 2 == 0 { 0.3 } else { 1e-3 };
        let mut inputs = vec![time];
        for (k, at) in point.iter().chain(&vec![0.0; point.len()]).enumerate() {
            let shift = scale * (fraction(k as u32 + 1) - 0.5);
            inputs.push(Ball::exact(at + shift * at.abs().max(1.0)));
        }
        let now = prepared.evaluate(&inputs, &mut scratch);
        inputs[0] = time + *period;
        let later = prepared.evaluate(&inputs, &mut scratch);
        for (now, later) in now.iter().zip(&later) {
            let difference = *now - *later;
            if !difference.is_finite() {
                continue;
            }
            compared = true;
            if !difference.contains_zero() {
                return Err(FloquetError::NotAPeriod {
                    time: short(time.mid_f64()),
                    span: driven.period.1,
                    energy: driven.driven_at,
                });
            }
        }
    }
    if compared { Ok(()) } else { Err(undefined) }
}

/// The multipliers, of each set of coordinates by itself that nothing couples to the others: what coincides in two
/// of them has vectors of its own in each. A set holds the velocities of its coordinates, so that its part of a
/// symplectic matrix is symplectic.
fn by_blocks(monodromy: &[Ball], size: usize, symplectic: bool) -> Vec<Multiplier> {
    let n = size / 2;
    let coupled = |i: usize, j: usize| {
        [i, i + n].iter().any(|row| {
            [j, j + n]
                .iter()
                .any(|column| !monodromy[size * row + column].is_zero())
        })
    };
    let mut all = Vec::new();
    let mut done = vec![false; n];
    for first in 0..n {
        if done[first] {
            continue;
        }
        done[first] = true;
        let mut members = vec![first];
        let mut next = 0;
        while let Some(own) = members.get(next).copied() {
            next += 1;
            for (other, done) in done.iter_mut().enumerate() {
                if !*done && (coupled(own, other) || coupled(other, own)) {
                    *done = true;
                    members.push(other);
                }
            }
        }
        members.sort_unstable();
        let rows: Vec<usize> = members
            .iter()
            .copied()
            .chain(members.iter().map(|i| i + n))
            .collect();
        let block: Vec<Ball> = rows
            .iter()
            .flat_map(|row| {
                rows.iter()
                    .map(move |column| monodromy[size * row + column])
            })
            .collect();
        let found = if rows.len() == 2 {
            multipliers::of_two(&block, symplectic, ())
        } else {
            multipliers::of_many(&block, rows.len(), symplectic)
        };
        if found.is_empty() {
            all.extend(unknown(&block, rows.len()));
        } else {
            all.extend(found);
        }
    }
    all
}

/// Discs for multipliers of which nothing is known: all lie within the largest row sum of the matrix.
fn unknown(monodromy: &[Ball], n: usize) -> Vec<Multiplier> {
    let row = |i: usize| {
        let entries = monodromy[n * i..n * (i + 1)].iter();
        entries.fold(Ball::ZERO, |sum, x| sum + x.abs())
    };
    let reach = (0..n).map(|i| row(i).abs_upper()).fold(0.0, f64::max);
    (0..n).map(|_| Multiplier::anywhere(reach)).collect()
}

fn stable(multipliers: &[Multiplier]) -> Option<bool> {
    let any = |place: Place| multipliers.iter().any(|own| own.place == place);
    if any(Place::Outside) {
        return Some(false);
    }
    let bounded = |own: &Multiplier| match own.place {
        Place::Inside => true,
        // A single one has a vector, and no other with it that grows.
        Place::On => own.single,
        Place::Outside | Place::Undecided => false,
    };
    multipliers.iter().all(bounded).then_some(true)
}

fn growth_rate(multipliers: &[Multiplier], stable: Option<bool>, period: &Ball) -> Option<Ball> {
    let any = |place: Place| multipliers.iter().any(|own| own.place == place);
    if any(Place::Undecided) && stable != Some(false) {
        return None;
    }
    if any(Place::On) && !any(Place::Outside) {
        return Some(Ball::ZERO);
    }
    // The largest lies between the largest lower and the largest upper bound.
    let lower = multipliers
        .iter()
        .map(|own| own.modulus)
        .max_by(|a, b| a.lower().total_cmp(&b.lower()))?;
    let upper = multipliers
        .iter()
        .map(|own| own.modulus)
        .max_by(|a, b| a.upper().total_cmp(&b.upper()))?;
    let largest = if lower == upper {
        lower
    } else {
        lower.hull(&upper)
    };
    let rate = largest.ln() / *period;
    rate.is_finite().then_some(rate)
}

/// The exponent of a multiplier, growth and angular frequency between -pi and pi over the period.
#[must_use]
pub fn exponent(multiplier: &Multiplier, period: &Ball) -> (Ball, Ball) {
    let growth = if multiplier.place == Place::On {
        Ball::ZERO
    } else {
        multiplier.modulus.ln() / *period
    };
    let angle = Scalar::atan2(&multiplier.im, &multiplier.re);
    (growth, angle / *period)
}
