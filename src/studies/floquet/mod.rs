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

mod basis;
mod constrained;
mod discs;
mod error;
mod levels;
mod monodromy;
pub(crate) mod motion;
mod multipliers;
mod orbit;
mod resonance;
mod signature;
pub(crate) mod trial;

pub use error::FloquetError;
pub use multipliers::{Multiplier, Place};
pub use resonance::Resonance;
pub use trial::TRIALS;

use std::cmp::Ordering;

use crate::digits::Digits;
use crate::flow::{Equations, Plain};
use levels::Task;
use librate_core::expr::{ExprId, ZeroVerdict};
use librate_core::linearize::{LinearizeError, constant, integrated};
use librate_core::model::Model;
use librate_core::order::Order;
use librate_core::precision::{Ball, Function, Magnitude, Scalar};
use monodromy::short;
use motion::Driven;

/// Beyond so many times its own way a motion is far from its guess.
const FAR: f64 = 2.0;

/// How well: significant digits of the multipliers that have to be certain, 1 to 100.
pub type Options = Digits<100>;

/// What a driven model does about an equilibrium or a periodic motion.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Floquet {
    /// The period of the drive in SI.
    pub period: Ball,
    /// Whether the form of the equations shows that they repeat after it; otherwise it was tried at many states.
    pub period_proved: bool,
    /// How often the drive repeats within the period, as far as the form of the equations shows: mostly once.
    pub cycles: u32,
    /// The coordinates at t = 0, in SI.
    pub place: Vec<Ball>,
    /// Their velocities at t = 0, in SI.
    pub velocities: Vec<Ball>,
    /// Whether the place is an equilibrium at all times; otherwise a periodic motion passes it.
    pub rests: bool,
    /// The coordinates and velocities with a guess that the periodic motion stays far away from.
    pub away: Vec<Away>,
    /// The multipliers, two for each degree of freedom, by falling modulus; those on the unit circle by rising angle, the one
    /// above the real axis first.
    pub multipliers: Vec<Multiplier>,
    /// Whether small displacements stay small; `None` where bounds do not decide.
    pub stable: Option<bool>,
    /// ln max |multiplier| / period; `None` where bounds do not tell it from 0, or nothing of it.
    pub growth_rate: Option<Ball>,
    /// The frequencies of the equations averaged over a period, in rad/s, rising: about those of the model without its
    /// drive, where that is weak. Directions without restoring force have none.
    pub frequencies: Vec<f64>,
    /// Which resonance with the drive makes it unstable.
    pub resonance: Option<Resonance>,
    /// The derivative of coordinates and velocities at the end of a period by those at its beginning, row by row; without
    /// a value where it leaves the range of doubles. Under constraints it is of coordinates that are left free.
    pub monodromy: Vec<Ball>,
}

/// A coordinate, or its velocity, whose guess is far from the periodic motion that was found: further than four times its
/// amplitude.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Away {
    /// Its place among the coordinates.
    pub coordinate: usize,
    /// Whether it is its velocity.
    pub velocity: bool,
    /// Where it was guessed to be, in SI.
    pub guess: f64,
    /// The least and the largest value it has on the way, about.
    pub range: (f64, f64),
}

impl Floquet {
    /// A bound of the distance of every multiplier from the midpoints of its parts in doubles.
    #[must_use]
    pub fn error_bound(&self) -> f64 {
        self.multipliers.iter().map(Multiplier::error).fold(0.0, f64::max)
    }
}

/// The multipliers of a model that is periodic in time.
///
/// They are those about the equilibrium that the model gives, or the point 0, if no force acts there at any time; else
/// about the periodic motion found from the guesses of coordinates and velocities (0 where there is none).
///
/// # Errors
/// Where nothing depends on the time, the period is missing or none, a given equilibrium moves, no periodic motion is
/// found, or the motion can't be followed over a period.
///
/// Where bounds in double-double do not decide on which side of the unit circle a multiplier lies, or not all digits asked
/// for, the way over the period is followed again with more bits, as far as that takes some seconds.
pub fn floquet(model: &Model, options: &Options) -> Result<Floquet, FloquetError> {
    let budget = model.pool.budget();
    budget.at("the motion over a period", None);
    let found = over_a_period(&integrated(model), options);
    budget.check().map_err(LinearizeError::from)?;
    found
}

fn over_a_period(model: &Model, options: &Options) -> Result<Floquet, FloquetError> {
    let mut driven = Driven::new(model, &[])?;
    let period = period(&driven)?;
    let given = begin(model, &mut driven);
    let whole = &given[..driven.dimension()];
    let (mut driven, begin) = driven.along_constraints(model, given.clone())?;
    let n = driven.dimension();
    let numbers = numbers(&driven, &begin);
    let point = &begin[..n];
    let roots = driven.expressions();
    let repeats = trial::repeats(&mut driven.pool, driven.time, driven.period.0, &roots);
    if repeats.is_none() {
        trial::try_period(&driven, &period, &numbers)?;
    }
    // With the constraints beside the equations what rests is a motion like any other.
    let (equations, rests) = equations(model, &mut driven, &begin)?;
    let task = Task { driven: &driven, equations: &equations, period: &period, point, digits: options.digits };
    let found = if rests { task.about_rest()? } else { task.about_motion(&numbers)? };
    let mut multipliers = found.multipliers;
    sort(&mut multipliers);
    let resting = |place: &[ExprId]| -> Vec<Ball> {
        place.iter().map(|value| constant(&driven.pool, *value).unwrap_or(Ball::ZERO)).collect()
    };
    let state = if rests { resting(point) } else { found.start };
    // Beside constraints not all of them are those of motions.
    let averaged = match driven.tied {
        Some(_) => Default::default(),
        None => resonance::frequencies(&equations, period.mid_f64(), &state),
    };
    let stable = stable(&multipliers);
    let cycles = repeats.unwrap_or(1);
    Ok(Floquet {
        growth_rate: growth_rate(&multipliers, stable, &period),
        resonance: match stable {
            Some(false) => resonance::resonance(&multipliers, &averaged, period.mid_f64(), cycles),
            Some(true) | None => None,
        },
        velocities: match state.get(n..) {
            Some(velocities) if velocities.len() == n => velocities.to_vec(),
            _ => vec![Ball::ZERO; whole.len()],
        },
        place: if rests { resting(whole) } else { state[..n.min(state.len())].to_vec() },
        period,
        period_proved: repeats.is_some(),
        cycles,
        rests,
        away: away(model, &numbers, &found.range),
        multipliers,
        stable,
        frequencies: averaged.0,
        monodromy: found.monodromy,
    })
}

/// The coordinates and velocities that stay far away from where they were guessed to be.
fn away(model: &Model, guesses: &[f64], range: &[(f64, f64)]) -> Vec<Away> {
    let n = model.coordinates.len();
    let given = model.guesses.iter().chain(model.guessed_velocities.iter());
    let all = given.zip(guesses).zip(range).enumerate();
    all.filter(|(_, ((given, _), _))| given.is_some())
        .map(|(at, ((_, guess), range))| Away { coordinate: at % n, velocity: at >= n, guess: *guess, range: *range })
        .filter(|own| {
            let (low, high) = own.range;
            (low - own.guess).max(own.guess - high) > FAR * (high - low)
        })
        .collect()
}

/// By falling modulus; on the circle by rising angle, the one above the real axis first.
fn sort(multipliers: &mut [Multiplier]) {
    multipliers.order_by(|a, b| {
        let angle = |m: &Multiplier| m.im.mid_f64().abs().atan2(m.re.mid_f64());
        let circle = |m: &Multiplier| m.place == Place::On;
        let by_size = if circle(a) && circle(b) { Ordering::Equal } else { b.log_size().total_cmp(&a.log_size()) };
        by_size.then(angle(a).total_cmp(&angle(b))).then(b.im.mid_f64().total_cmp(&a.im.mid_f64()))
    });
}

/// About the coordinates and velocities of a state.
fn numbers(driven: &Driven, point: &[ExprId]) -> Vec<f64> {
    point.iter().map(|value| constant(&driven.pool, *value).map_or(0.0, |value| value.mid_f64())).collect()
}

/// Tries the period of a model at many states.
pub(crate) fn try_period(model: &Model) -> Result<(), FloquetError> {
    let mut driven = Driven::new(model, &[])?;
    let period = period(&driven)?;
    let begin = begin(model, &mut driven);
    trial::try_period(&driven, &period, &numbers(&driven, &begin))
}

/// A state that repeats after a period, as far as doubles tell, found from one near it in at most `budget` steps.
pub(crate) fn repeating(plain: &mut Plain, period: f64, start: &[f64], budget: usize) -> Option<Vec<f64>> {
    Some(orbit::search(plain, period, start, (budget, budget)).ok()?.start)
}

/// The period, which is a positive number.
fn period(driven: &Driven) -> Result<Ball, FloquetError> {
    let (value, span) = driven.period;
    let number = constant(&driven.pool, value);
    number.filter(Ball::is_positive).ok_or_else(|| {
        let finite = number.filter(Ball::is_finite);
        let value = finite.map_or_else(|| "not defined".to_owned(), |number| short(number.mid_f64()));
        FloquetError::PeriodNotPositive { value, span }
    })
}

/// Where motions are examined, coordinates before velocities: as given, as guessed, else 0. With an equilibrium they rest.
pub(crate) fn begin(model: &Model, driven: &mut Driven) -> Vec<ExprId> {
    let resting = model.equilibria.any();
    let places = model.equilibria.iter().zip(model.guesses.iter());
    let places = places.map(|(equilibrium, guess)| equilibrium.or(guess));
    let velocities = model.guessed_velocities.iter().map(|guess| guess.filter(|_| !resting));
    places
        .chain(velocities)
        .map(|given| match given {
            Some(given) => driven.with_values(given.symbolic),
            None => driven.pool.zero(),
        })
        .collect()
}

/// The equations of displacements from a state that rests at all times, and whether it does; else those of the state itself.
pub(crate) fn equations(
    model: &Model,
    driven: &mut Driven,
    begin: &[ExprId],
) -> Result<(Equations, bool), FloquetError> {
    if driven.tied.is_some() || !rests(model, driven, begin)? {
        return Ok((driven.equations()?, false));
    }
    let n = driven.dimension();
    let slopes = driven.linear(&begin[..n])?;
    let equations = Equations::linear(&driven.pool, driven.time, 2 * n, &driven.open, &slopes);
    Ok((equations.map_err(|_| FloquetError::NotDefined { span: driven.driven_at })?, true))
}

/// Whether no motion begins at a state, as it has no velocity and no force acts there at any time.
fn rests(model: &Model, driven: &mut Driven, begin: &[ExprId]) -> Result<bool, FloquetError> {
    let (point, velocities) = begin.split_at(driven.dimension());
    let forces = driven.at_rest(point);
    let energy = driven.driven_at;
    for (at, force) in forces.iter().enumerate() {
        // Any given coordinate makes the point one that is asked for.
        let given = model.equilibria.get(at).or(model.equilibria.given().next());
        if let (Some(given), ZeroVerdict::NonZero) = (given, force) {
            return Err(FloquetError::EquilibriumMoves {
                coordinate: model.coordinates.at(at).name(),
                force: driven.force_text(at, point).unwrap_or_else(|| "that is not 0".to_owned()),
                span: given.span,
                energy,
            });
        }
    }
    let still = velocities.iter().all(|own| driven.pool.vanishes(*own));
    Ok(still && forces.iter().all(|force| *force == ZeroVerdict::Zero))
}

fn stable(multipliers: &[Multiplier]) -> Option<bool> {
    let any = |place: Place| multipliers.iter().any(|own| own.place == place);
    if any(Place::Outside) {
        return Some(false);
    }
    let bounded = |own: &Multiplier| match own.place {
        Place::Inside => true,
        // With a vector for each time it repeats, nothing with it grows.
        Place::On => own.semisimple,
        Place::Outside | Place::Undecided => false,
    };
    multipliers.iter().all(bounded).then_some(true)
}

fn growth_rate(multipliers: &[Multiplier], stable: Option<bool>, period: &Ball) -> Option<Ball> {
    let any = |place: Place| multipliers.iter().any(|own| own.place == place);
    if any(Place::Undecided) && stable != Some(false) {
        return None;
    }
    let outside = any(Place::Outside);
    if any(Place::On) && !outside {
        return (!any(Place::Undecided)).then_some(Ball::ZERO);
    }
    // The largest is outside where any is, however near to 1 both are in doubles, or undecided, and one of those that reach as far as
    // the largest lower bound.
    let own = || multipliers.iter().filter(|own| !outside || matches!(own.place, Place::Outside | Place::Undecided));
    let logarithm = if own().all(|own| own.modulus.is_finite()) {
        let least = own().map(|own| own.modulus.lower()).fold(0.0_f64, f64::max);
        let largest = own().map(|own| own.modulus).filter(|modulus| modulus.upper() >= least);
        largest.reduce(|all, one| all.hull(&one))?.ln()
    } else {
        let wide = || own().map(Multiplier::wide_modulus);
        let least = wide().fold(Magnitude::ZERO, |most, one| most.max(one.abs_lower()));
        let largest = wide().filter(|modulus| modulus.abs_upper() >= least).reduce(|all, one| all.hull(&one))?;
        largest.apply(Function::Ln).to_ball()
    };
    let rate = logarithm / *period;
    // What grows does so at some rate, of which no digit may be known.
    let is_known = rate.is_finite() && !(outside && rate.lower() < 0.5 * rate.upper());
    is_known.then_some(rate)
}

/// The exponent of a multiplier, growth and angular frequency between -pi and pi over the period.
#[must_use]
pub fn exponent(multiplier: &Multiplier, period: &Ball) -> (Ball, Ball) {
    let growth = if multiplier.place == Place::On { Ball::ZERO } else { multiplier.log_modulus() / *period };
    // On both sides of the cut it is next to pi.
    let is_on_cut = multiplier.re.is_negative() && multiplier.im.contains_zero();
    let angle = match &multiplier.precise {
        Some(precise) if is_on_cut => (-&precise[1]).atan2(&-&precise[0]).to_ball(),
        Some(precise) => precise[1].atan2(&precise[0]).to_ball(),
        None if is_on_cut => Scalar::atan2(&-multiplier.im, &-multiplier.re),
        None => Scalar::atan2(&multiplier.im, &multiplier.re),
    };
    let angle = if is_on_cut { angle + Ball::PI } else { angle };
    (growth, angle / *period)
}
