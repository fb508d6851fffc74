//! Time evolution: the equations of motion in full, from where a motion starts.
//!
//! The equations are those that the energies give, with nothing linearized (`equations`); they are integrated by Taylor
//! series of high order (`step`), because compiled expressions give them cheaply, a step is its own dense output, and the
//! same code runs in double-double. [`System::motion`] runs in double-double and beside it in doubles: what the two differ by tells
//! how much the motion magnifies errors, and with that which digits of the better one stand. Where doubles have lost the
//! motion, a second run in double-double of another order takes their place. That is an estimate, no proof. [`System::quick`]
//! runs in doubles alone, to a tolerance, and says nothing about digits.
//!
//! It never proves a bound, never smooths over a singularity, and never prints.

mod equations;
mod error;
mod length;
mod limits;
mod linear;
mod matrix;
mod projection;
mod proved;
mod start;
mod step;
mod table;

pub use error::MotionError;
pub use linear::superposition;
pub use proved::Enclosed;
pub use start::{Moved, Start};

use equations::Equations;
use step::{Real, Stepper, Trouble};

use std::sync::Arc;

use librate_core::budget::Budget;
use librate_core::expr::Tape;
use librate_core::linearize::LinearizeError;
use librate_core::model::{Constant, Model};
use librate_core::order::Order;
use librate_core::precision::{Ball, DoubleDouble, Enclosure, Scalar};

/// Order and tolerance of the steps of a run, and by how much beside their sizes the values of its start are displaced.
#[derive(Clone, Copy)]
struct Accuracy {
    order: usize,
    tolerance: f64,
    displaced: f64,
}
/// In double-double.
const FINE: Accuracy = Accuracy { order: 36, tolerance: 1e-33, displaced: 0.0 };
/// The run that checks it: displaced, as errors of rounding may cancel where a motion starts on a top that is an equilibrium.
const CHECK: Accuracy = Accuracy { order: 30, tolerance: 1e-30, displaced: 1e-31 };
/// In doubles.
const PLAIN: Accuracy = Accuracy { order: 22, tolerance: 1e-17, displaced: 0.0 };
/// Beyond this doubles have nothing to do with the motion any more.
const LOST: f64 = 1e-4;
/// What is less beside others may be rounding.
const LEAST_SIZE: f64 = 1e-12;
/// A motion takes at most so many steps.
const MOST_STEPS: usize = 300_000;
/// Kinks that are nearer, beside the length of a step, are not looked at for jumps.
const LEAST_WAY: f64 = 1e-3;
/// After so many steps it is estimated how many it will take.
const FIRST_STEPS: usize = 400;
/// Forces are sampled so many times in a run at least; what is much shorter than their distance may be missed.
const SAMPLES_A_RUN: f64 = 256.0;
/// Runs are compared at so many times at least.
const SAMPLES: usize = 200;
/// By so much of it each coordinate and velocity is changed to see how large the terms of constraints are.
const NUDGE: f64 = 1e-12;
/// A table has at most so many numbers: with those of the runs that check it they take most of a gigabyte.
const MOST_NUMBERS: usize = 5_000_000;

/// A constant, enclosed and as it is; `None` where it is not a finite number.
fn moment_of(constant: &Constant) -> Option<(Ball, Tape)> {
    let value = librate_core::linearize::constant(constant.pool(), constant.value()).filter(Ball::is_finite)?;
    Some((value, Tape::compile(constant.pool(), &[constant.value()], &[]).ok()?))
}

/// When a motion is sampled: rows at equal steps from t = 0, or at times that are listed.
#[derive(Clone, Debug)]
pub struct Times {
    until: Ball,
    exact: Tape,
    samples: usize,
    listed: Option<Arc<Listed>>,
}

/// Times in ascending order.
#[derive(Debug)]
struct Listed {
    times: Vec<Ball>,
    exact: Vec<Tape>,
    /// The place that each has among the rows that are asked for; none of those that are only sampled.
    places: Vec<Option<usize>>,
}

impl Times {
    /// `samples` rows from t = 0 to `until`.
    ///
    /// # Errors
    /// [`MotionError::BadTimes`] for a time that is no positive number, and for no row at all.
    pub fn new(until: &Constant, samples: usize) -> Result<Self, MotionError> {
        let bad =
            |reason: &str| MotionError::BadTimes { until: until.text().to_owned(), samples, reason: reason.to_owned() };
        let value = moment_of(until).filter(|(value, _)| value.is_positive());
        let (until, exact) = value.ok_or_else(|| bad("the time that a motion ends at is a positive number"))?;
        if samples == 0 {
            return Err(bad("a table has at least one row"));
        }
        Ok(Self { until: Ball::new(until.mid, 0.0), exact, samples, listed: None })
    }

    /// A row at each of these times, which may come in any order.
    ///
    /// # Errors
    /// [`MotionError::BadTimes`] for a time that is negative or no number, and for no time at all.
    pub fn listed(times: &[Constant]) -> Result<Self, MotionError> {
        let mut rows = Vec::with_capacity(times.len());
        for (place, time) in times.iter().enumerate() {
            let Some((value, exact)) = moment_of(time).filter(|(value, _)| !value.is_negative()) else {
                let reason = "times are numbers that are not negative".to_owned();
                return Err(MotionError::BadTimes { until: time.text().to_owned(), samples: times.len(), reason });
            };
            rows.push((Ball::new(value.mid, 0.0), exact, Some(place)));
        }
        rows.order_by(|a, b| a.0.mid_f64().total_cmp(&b.0.mid_f64()).then(a.0.mid.lo.total_cmp(&b.0.mid.lo)));
        let Some((until, exact, _)) = rows.last().cloned() else {
            let reason = "there is no time".to_owned();
            return Err(MotionError::BadTimes { until: String::new(), samples: 0, reason });
        };
        let samples = rows.len();
        let (times, all, places) = rows.into_iter().collect();
        let listed = Listed { times, exact: all, places };
        Ok(Self { until, exact, samples, listed: Some(Arc::new(listed)) })
    }

    /// These and as many between them as it takes to see what happens there.
    fn looked_at(&self) -> Self {
        let Some(listed) = &self.listed else {
            let stride = SAMPLES.div_ceil(self.samples.saturating_sub(1).max(1));
            return Self { samples: self.samples.saturating_sub(1) * stride + 1, ..self.clone() };
        };
        let between = Self { samples: SAMPLES + 1, listed: None, ..self.clone() };
        let asked = listed.times.iter().copied().zip(listed.places.iter().copied());
        let mut all: Vec<(Ball, Option<usize>)> =
            asked.chain((0..SAMPLES).map(|row| (between.at(row), None))).collect();
        all.order_by(|a, b| a.0.mid_f64().total_cmp(&b.0.mid_f64()));
        let (times, places): (Vec<Ball>, Vec<Option<usize>>) = all.into_iter().unzip();
        Self {
            samples: times.len(),
            listed: Some(Arc::new(Listed { times, exact: Vec::new(), places })),
            ..self.clone()
        }
    }

    /// The rows that are asked for of those that were examined, or of all of them, in their order.
    fn asked<T>(&self, all: Vec<T>) -> Vec<T> {
        let Some(listed) = self.listed.as_ref().filter(|own| own.places.len() == all.len()) else { return all };
        let mut rows: Vec<(usize, T)> =
            listed.places.iter().zip(all).filter_map(|(place, row)| Some(((*place)?, row))).collect();
        rows.order_by_key(|(place, _)| *place);
        rows.into_iter().map(|(_, row)| row).collect()
    }

    /// The time of a row; those of listed times are in ascending order.
    #[must_use]
    pub fn at(&self, row: usize) -> Ball {
        if let Some(listed) = &self.listed {
            return listed.times.get(row).copied().unwrap_or(self.until);
        }
        if self.samples < 2 {
            return Ball::ZERO;
        }
        let (row, rows) = (row as f64, (self.samples - 1) as f64);
        let time = self.until.mul(&Ball::exact(row)).div(&Ball::exact(rows));
        Ball::new(time.mid, 0.0)
    }

    /// The time of a row, with bounds of that: rows are shares of an exact number.
    fn enclosed<S: Enclosure>(&self, row: usize, precision: S::Precision) -> S {
        let value = |exact: &Tape| {
            let value = start::evaluated::<S>(exact, precision);
            value.unwrap_or_else(|| S::from_ball(&Ball::NOT_FINITE, precision))
        };
        if let Some(exact) = self.listed.as_ref().and_then(|listed| listed.exact.get(row)) {
            return value(exact);
        }
        let zero = S::exact(0.0, precision);
        if self.samples < 2 {
            return zero;
        }
        let (row, rows) = (row as f64, (self.samples - 1) as f64);
        value(&self.exact).mul(&S::exact(row, precision)).div(&S::exact(rows, precision))
    }

    /// Refuses tables of so many values a row that are too large.
    fn check_size(&self, columns: usize) -> Result<(), MotionError> {
        let numbers = self.samples.saturating_mul(columns + 1);
        if numbers > MOST_NUMBERS {
            return Err(MotionError::TooManyNumbers { numbers, most: MOST_NUMBERS });
        }
        Ok(())
    }

    /// How many rows there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.samples
    }

    /// Whether there is no row; never so.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.samples == 0
    }
}

/// A motion, row by row.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Trajectory {
    /// The times, in SI.
    pub times: Vec<Ball>,
    /// Per row: the coordinates, then their velocities, in SI. The radius bounds what the value is off by, or estimates it; 0
    /// for a quick run.
    pub rows: Vec<Vec<Ball>>,
    /// How far the energy strays from where it started, beside the largest kinetic energy, 0 where that is rounding; `None`
    /// where it is not conserved.
    pub energy_drift: Option<f64>,
    /// How far constraints and conditions on velocities are from being kept, beside the largest of their terms, 0 where that is
    /// rounding; `None` where there are none, or where it is proved.
    pub constraint_drift: Option<f64>,
    /// How many steps were made.
    pub steps: usize,
    /// Whether the radii tell the error: an estimate, or proved bounds.
    pub estimated: bool,
    /// The bits of the numbers that the radii were proved with.
    pub proved: Option<usize>,
}

impl Trajectory {
    /// The rows of a run that are asked for; with their errors, which are estimated.
    fn of(times: &Times, rows: Vec<Vec<Ball>>, steps: usize) -> Self {
        Self {
            times: times.asked((0..rows.len()).map(|row| times.at(row)).collect()),
            rows: times.asked(rows),
            energy_drift: None,
            constraint_drift: None,
            steps,
            estimated: true,
            proved: None,
        }
    }
}

/// A model as equations of motion.
#[derive(Clone, Debug)]
pub struct System {
    budget: Budget,
    equations: Equations,
    /// In independent velocities, where there are such: steps are made with these.
    independent: Option<Box<Equations>>,
    names: Vec<String>,
}

/// A time in a message.
fn moment(time: f64) -> String {
    if time == 0.0 || (1e-3..1e9).contains(&time) { format!("{time:.6}") } else { format!("{time:.6e}") }
}

/// Steps in doubles that leave out so much.
fn quick(tolerance: f64) -> Accuracy {
    let tolerance = tolerance.clamp(1e-17, 0.1);
    // About the best order for a tolerance (Jorba and Zou 2005, section 3.2).
    let order = (-0.5 * tolerance.ln()).ceil() + 2.0;
    Accuracy { order: order.clamp(4.0, 22.0) as usize, tolerance, displaced: 0.0 }
}

/// States at the rows, how many steps they took, and the largest magnitude, never 0, of each coordinate and velocity on the way.
struct Run {
    rows: Vec<Vec<Ball>>,
    steps: usize,
    sizes: Vec<f64>,
}

/// Which values are nothing but rounding: much smaller than others of their kind and than what their coordinate is or takes in all the time,
/// and different altogether in doubles. What rests is no motion whose errors tell of the others'.
fn are_rounding(fine: &Run, plain: Option<&Run>, time: f64) -> Vec<bool> {
    let sizes = &fine.sizes;
    let Some(plain) = plain else { return vec![false; sizes.len()] };
    let count = sizes.len() / 2;
    let (positions, velocities) = sizes.split_at(count);
    let largest = |own: &[f64]| own.iter().copied().fold(0.0, f64::max);
    let (far, fast) = (largest(positions), largest(velocities));
    let is_rounding = |at: usize| {
        let beside = if at < count { far.max(velocities[at] * time) } else { fast.max(positions[at - count] / time) };
        let rows = fine.rows.iter().zip(&plain.rows);
        sizes[at] < LEAST_SIZE * beside
            && rows.into_iter().any(|(own, other)| (own[at].mid_f64() - other[at].mid_f64()).abs() > LOST * sizes[at])
    };
    (0..sizes.len()).map(is_rounding).collect()
}

/// Takes a state into the largest magnitudes.
fn grow<'a, S: Real + 'a>(sizes: &mut [f64], state: impl IntoIterator<Item = &'a S>) {
    for (size, value) in sizes.iter_mut().zip(state) {
        *size = size.max(value.middle().abs());
    }
}

impl System {
    /// Writes the equations of motion out.
    ///
    /// # Errors
    /// Parameters without a value, and models of too many terms.
    pub fn new(model: &Model) -> Result<Self, MotionError> {
        let names = model.coordinates.names();
        let budget = model.pool.budget();
        budget.at("the equations of motion", None);
        let equations = Equations::new(model);
        let independent = Equations::independent(model).map(Box::new);
        budget.check().map_err(LinearizeError::from)?;
        budget.at("the motion", None);
        Ok(Self { budget: budget.clone(), equations: equations?, independent, names: names.collect() })
    }

    /// The motion with its digits: each value with an estimate of its error. Time goes in proportion to the number of steps and to the
    /// size of the equations.
    ///
    /// # Errors
    /// [`MotionError::Singular`] where the motion ends or M has no inverse, [`MotionError::Stuck`] where it can't be followed.
    pub fn motion(&self, start: &Start, times: &Times) -> Result<Trajectory, MotionError> {
        times.check_size(2 * self.names.len())?;
        // Runs may differ and agree again, as where a pendulum went round once or did not.
        let asked = times;
        let times = &times.looked_at();
        let fine = self.table::<DoubleDouble>(start, times, FINE)?;
        let plain = self.table::<f64>(start, times, PLAIN).ok();
        let sizes = &fine.sizes;
        let rounding = are_rounding(&fine, plain.as_ref(), times.at(times.samples - 1).mid_f64());
        let relative = |row: usize, other: &Run| {
            let both = fine.rows[row].iter().zip(&other.rows[row]);
            let own = both.zip(sizes).zip(&rounding).filter(|(_, is_rounding)| !**is_rounding);
            own.fold(0.0_f64, |most, (((value, other), size), _)| most.max(value.sub(other).mid_f64().abs() / size))
        };
        let own = start.positions.iter().chain(&start.velocities);
        let known = own.zip(sizes).zip(&rounding).filter(|(_, is_rounding)| !**is_rounding);
        let unknown = known.fold(0.0_f64, |most, ((x, size), _)| most.max(x.radius / size));
        let mut check: Option<Run> = None;
        let mut magnified = 1.0_f64;
        let mut seen = 0.0_f64;
        // By how much what is unknown of the start grows, by which doubles tell even where they are lost.
        let mut spread = 1.0_f64;
        let mut errors = Vec::with_capacity(fine.rows.len());
        for row in 0..fine.rows.len() {
            let off = plain.as_ref().map(|plain| relative(row, plain)).filter(|off| off.is_finite());
            spread = spread.max(off.map_or(f64::INFINITY, |off| off / f64::ROUNDING));
            match off {
                Some(off) if off < LOST && check.is_none() => {
                    magnified = magnified.max(off / f64::ROUNDING);
                }
                _ => {
                    let check = match &mut check {
                        Some(known) => known,
                        open => open.insert(self.table::<DoubleDouble>(start, times, CHECK)?),
                    };
                    // The check leaves out more than what it checks.
                    seen = seen.max(relative(row, check));
                }
            }
            let mut error = (magnified * DoubleDouble::ROUNDING).max(seen);
            if unknown > 0.0 {
                error = error.max(spread * unknown);
            }
            errors.push(error);
        }
        let lost = self.lost(start, times, &fine.rows, fine.steps);
        let stride = if asked.listed.is_some() { 1 } else { (times.samples - 1) / (asked.samples - 1).max(1) };
        let rows = fine.rows.iter().zip(&errors).enumerate().step_by(stride.max(1));
        let rows = rows.map(|(row, (values, error))| {
            if times.at(row).is_zero() {
                return start.row();
            }
            let values = values.iter().zip(sizes).zip(&lost[row]).zip(&rounding);
            let radius = |size: &f64, lost: &f64, is_rounding: &bool| {
                let own = error * size + magnified * lost;
                if *is_rounding { own.max(2.0 * size) } else { own }
            };
            values.map(|(((value, size), lost), own)| Ball::new(value.mid, radius(size, lost, own))).collect()
        });
        let rows: Vec<Vec<Ball>> = rows.collect();
        let seen = if asked.listed.is_some() { times } else { asked };
        let energy_drift = self.energy_drift(seen, &rows, DoubleDouble::ROUNDING);
        let constraint_drift = self.constraint_drift(seen, &rows, DoubleDouble::ROUNDING);
        Ok(Trajectory { energy_drift, constraint_drift, ..Trajectory::of(seen, rows, fine.steps) })
    }

    /// The motion in doubles, steps of which leave out so much beside the size of each coordinate.
    ///
    /// # Errors
    /// As [`System::motion`].
    pub fn quick(&self, start: &Start, times: &Times, tolerance: f64) -> Result<Trajectory, MotionError> {
        times.check_size(2 * self.names.len())?;
        let Run { rows, steps, .. } = self.table::<f64>(start, times, quick(tolerance))?;
        let energy_drift = self.energy_drift(times, &rows, f64::ROUNDING);
        let constraint_drift = self.constraint_drift(times, &rows, f64::ROUNDING);
        let own = Trajectory::of(times, rows, steps);
        Ok(Trajectory { energy_drift, constraint_drift, estimated: false, ..own })
    }

    /// All rows of a motion.
    fn table<S: Real>(&self, start: &Start, times: &Times, accuracy: Accuracy) -> Result<Run, MotionError> {
        self.budget.at("the motion", None);
        let run = self.run::<S>(start, times, accuracy);
        self.budget.check().map_err(LinearizeError::from)?;
        run
    }

    fn run<S: Real>(&self, start: &Start, times: &Times, accuracy: Accuracy) -> Result<Run, MotionError> {
        let equations = self.independent.as_deref().unwrap_or(&self.equations);
        let mut stepper = Stepper::<S>::new(equations, accuracy.order, accuracy.tolerance);
        let moved = |(at, value): (usize, &Ball)| {
            let by = if at % 2 == 0 { accuracy.displaced } else { -accuracy.displaced };
            let value = S::from_ball(value);
            value.add(&value.mul(&S::exact(by)))
        };
        let mut q: Vec<S> = start.positions.iter().enumerate().map(moved).collect();
        let mut v: Vec<S> = start.velocities.iter().enumerate().map(moved).collect();
        let mut t = S::exact(0.0);
        let end = S::from_ball(&times.at(times.samples - 1));
        let mut rows = Vec::with_capacity(times.samples);
        let mut steps = 0;
        let mut sizes = vec![f64::MIN_POSITIVE; q.len() + v.len()];
        let mut resting = 0;
        loop {
            let left = end.sub(&t);
            let mut length = stepper
                .expand(&t, &mut q, &mut v, left.middle().max(f64::MIN_POSITIVE))
                .map_err(|own| self.ended(&stepper, own, &t, (&q, &v), 0.0))?;
            let mut longest = length.min(left.middle().max(0.0));
            let fitting = stepper.fitting(&t, longest, end.middle() / SAMPLES_A_RUN);
            if fitting < longest {
                (length, longest) = (fitting, fitting);
            }
            let kink = stepper.kink(longest).map_err(|own| self.ended(&stepper, own, &t, (&q, &v), 0.0))?;
            if let Some(kink) = &kink {
                length = kink.middle();
            }
            while rows.len() < times.samples {
                let after = S::from_ball(&times.at(rows.len())).sub(&t);
                if after.middle() > length {
                    break;
                }
                let (mut row, speed) = stepper.at(&t, &after);
                row.extend(speed);
                if !row.iter().all(S::is_finite) {
                    return Err(self.ended(&stepper, Trouble::NotFinite, &t, (&q, &v), length));
                }
                grow(&mut sizes, &row);
                rows.push(row.into_iter().map(Real::to_ball).collect());
            }
            if rows.len() == times.samples {
                return Ok(Run { rows, steps, sizes });
            }
            let next = t.add(&kink.unwrap_or_else(|| S::exact(longest)));
            // Steps that get longer later on may save a motion that begins with short ones, but not by much more than this.
            let share = next.middle() / end.middle();
            let expected = FIRST_STEPS as f64 / share;
            if steps >= MOST_STEPS || steps == FIRST_STEPS && expected > 10.0 * MOST_STEPS as f64 {
                return Err(MotionError::TooLong { reached: moment(next.middle()), steps });
            }
            // Steps that do not move the time end in a singularity, unless several kinks meet.
            resting = if next.sub(&t).middle() <= 1e-15 * t.middle() { resting + 1 } else { 0 };
            if resting > equations.kinks.outputs() {
                return Err(self.ended(&stepper, Trouble::NoStep, &t, (&q, &v), length));
            }
            // A kink next to the one before tells nothing.
            let half = kink.filter(|kink| kink.middle() > LEAST_WAY * longest).map(|kink| kink.mul(&S::exact(0.5)));
            let half_way = half.map(|half| (t.add(&half), stepper.at(&t, &half)));
            (q, v) = stepper.at(&t, &next.sub(&t));
            grow(&mut sizes, q.iter().chain(&v));
            t = next;
            steps += 1;
            if let Some((at, (positions, velocities))) = half_way
                && !stepper.passes((at, [&positions, &velocities]), (t, [&q, &v]))
            {
                return Err(self.ended(&stepper, Trouble::Impact, &t, (&q, &v), 0.0));
            }
        }
    }

    fn constraint_drift(&self, times: &Times, rows: &[Vec<Ball>], unit: f64) -> Option<f64> {
        let surface = &self.equations.surface;
        if surface.outputs() == 0 {
            return None;
        }
        let tape = surface.prepare::<Ball>(());
        let mut scratch = Vec::new();
        let (mut off, mut terms) = (vec![0.0_f64; surface.outputs()], vec![0.0_f64; surface.outputs()]);
        for (at, row) in rows.iter().enumerate() {
            let mut nudged = |size: &dyn Fn(usize, f64) -> f64| {
                let mut inputs = vec![times.at(at)];
                let sizes = row.iter().enumerate().map(|(i, x)| size(i, x.mid_f64().abs()));
                inputs.extend(row.iter().zip(sizes).map(|(x, size)| Ball::new(x.mid, NUDGE * size)));
                tape.evaluate(&inputs, &mut scratch)
            };
            let values = nudged(&|_, own| own);
            // What rounding of the largest coordinate, or velocity, makes is no drift: a yaw of 1e-33 has terms as small.
            let largest = |part: &[Ball]| part.iter().map(|x| x.mid_f64().abs()).fold(0.0, f64::max);
            let sizes: Vec<f64> = row.chunks(self.names.len()).map(largest).collect();
            let rounding = nudged(&|i, _| 16.0 * unit * sizes[i / self.names.len()]);
            for (((off, terms), own), rounding) in off.iter_mut().zip(&mut terms).zip(values).zip(rounding) {
                let own_off = own.mid_f64().abs();
                *off = if own_off * NUDGE > rounding.radius { off.max(own_off) } else { *off };
                *terms = terms.max(own.radius / NUDGE);
            }
        }
        let moving = off.iter().zip(&terms).filter(|(_, terms)| **terms > 0.0).map(|(off, terms)| off / terms);
        let drift = moving.reduce(f64::max).filter(|own| own.is_finite())?;
        Some(if drift <= 16.0 * unit { 0.0 } else { drift })
    }

    fn energy_drift(&self, times: &Times, rows: &[Vec<Ball>], unit: f64) -> Option<f64> {
        let tape = self.equations.energy.as_ref()?.prepare::<Ball>(());
        let mut scratch = Vec::new();
        let (mut least, mut most, mut motion) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
        let mut first: Option<Ball> = None;
        let n = self.names.len();
        for (at, row) in rows.iter().enumerate() {
            let mut inputs = vec![times.at(at)];
            inputs.extend(row.iter().map(|x| Ball::new(x.mid, 0.0)));
            let energy = tape.evaluate(&inputs, &mut scratch).into_iter().next()?;
            for speed in &mut inputs[n + 1..] {
                *speed = Ball::ZERO;
            }
            let rest = tape.evaluate(&inputs, &mut scratch).into_iter().next()?;
            motion = motion.max(energy.sub(&rest).mid_f64().abs());
            let first = first.get_or_insert(energy);
            let off = energy.sub(first).mid_f64();
            (least, most) = (least.min(off), most.max(off));
        }
        let stray = most.max(-least);
        // An energy below the range of numbers tells nothing.
        if first.is_some_and(|first| first.contains_zero() && !first.is_zero()) && stray == 0.0 {
            return None;
        }
        if first.is_some_and(|first| stray <= 16.0 * unit * first.mid_f64().abs()) {
            return Some(0.0);
        }
        (motion > 0.0 && stray.is_finite()).then(|| stray / motion)
    }
}
