//! Motions with a proof: every value lies within its bound.
//!
//! The motion is enclosed step by step ([`Following`]), in double-double first, and again with as many bits as it takes
//! where that leaves fewer digits than were asked for. Start, times and parameters are taken as the exact numbers that they
//! are given as.
//!
//! It never prints a digit that its bound does not cover; where no step can be proved, it says when.

use super::equations::Written;
use super::error::MotionError;
use super::{FIRST_STEPS, Start, Times, Trajectory, moment};
use crate::flow::{Equations, Following, count};
use librate_core::budget::Budget;
use librate_core::linearize::LinearizeError;
use librate_core::model::Model;
use librate_core::precision::{Ball, Big, Enclosure};

/// Order of steps in double-double.
const ORDER: usize = 36;
/// Bits of double-double.
const BITS: usize = 106;
/// Steps of a motion in double-double; of more bits, so many fewer as these cost more.
const MOST_STEPS: usize = 100_000;
/// More coordinates than this, with constraints, have expressions that are too large.
const MOST_COORDINATES: usize = 24;
/// With more bits than this motions are not followed: radii have to stay above the smallest double.
const MOST_BITS: usize = 800;
/// Bits beyond those that seem to be needed.
const SPARE_BITS: usize = 24;
/// Attempts with more bits.
const CLIMBS: usize = 4;
/// A set of points this large beside where it is has lost the motion.
const LARGE: f64 = 1e-4;

/// A model as equations of motion, ready for proofs.
#[derive(Clone, Debug)]
pub struct Enclosed {
    budget: Budget,
    equations: Equations,
}

/// The rows of a run of some precision, and how it went.
struct Run {
    rows: Vec<Vec<Ball>>,
    steps: usize,
    /// Where it ended before the end.
    stuck: Option<Stuck>,
}

/// A run that ended before its end.
#[derive(Clone, Copy)]
struct Stuck {
    time: f64,
    /// Whether what is known of the motion had become too little.
    spread: bool,
    /// Whether there were too many steps.
    steps: bool,
}

impl Stuck {
    fn error(&self) -> MotionError {
        let reason = if self.steps {
            "the steps that are proved become too many"
        } else if self.spread {
            "the motion magnifies what is unknown of it until nothing is left that could be proved"
        } else {
            "no step can be proved there, as beside a singularity or at the kink of an absolute value"
        };
        MotionError::NotProved { reached: moment(self.time), reason }
    }
}

impl Enclosed {
    /// Writes the equations of motion out, solved for the accelerations.
    ///
    /// # Errors
    /// Parameters without a value, models that are too large, and a mass matrix that has no inverse anywhere.
    pub fn new(model: &Model) -> Result<Self, MotionError> {
        let coordinates = model.coordinates.len() + model.constraints.len();
        if coordinates > MOST_COORDINATES {
            return Err(MotionError::TooLargeToProve { coordinates, most: MOST_COORDINATES });
        }
        let budget = model.pool.budget();
        budget.at("the equations of motion", None);
        let equations = Written::new(model, true).and_then(|written| written.explicit());
        budget.check().map_err(LinearizeError::from)?;
        budget.at("the motion", None);
        Ok(Self { budget: budget.clone(), equations: equations? })
    }

    /// The motion, each value with a radius that is proved: with so many digits of the size of each column where the start
    /// determines them.
    ///
    /// # Errors
    /// [`MotionError::NotProved`] where there is no proof up to the end, [`MotionError::OpenStart`] where the start is known
    /// only about.
    pub fn motion(&self, start: &Start, times: &Times, digits: usize) -> Result<Trajectory, MotionError> {
        times.check_size(self.equations.dimension())?;
        let mut run = self.run::<Ball>(start, times, BITS, ())?;
        let mut bits = BITS;
        for _ in 0..CLIMBS {
            let Some(more) = wanted_bits(&run, times, digits, bits) else { break };
            if more > MOST_BITS || !start.is_exact() {
                break;
            }
            let mut next = self.run::<Big>(start, times, more, more)?;
            match (&run.stuck, &mut next.stuck) {
                // What is there already has fewer digits, and is proved all the same.
                (None, Some(_)) => break,
                (Some(before), Some(stuck)) => stuck.time = stuck.time.max(before.time),
                (_, None) => {}
            }
            (run, bits) = (next, more);
        }
        self.budget.check().map_err(LinearizeError::from)?;
        if let Some(stuck) = run.stuck {
            return Err(stuck.error());
        }
        Ok(Trajectory { proved: Some(bits), ..Trajectory::of(times, run.rows, run.steps) })
    }

    /// The order of steps with so many bits, and how many are made at most.
    fn order(bits: usize) -> (usize, usize) {
        if bits == BITS {
            return (ORDER, MOST_STEPS);
        }
        // About the best order for numbers that take longer than those of its bounds.
        let order = 3 * bits / 10;
        (order, MOST_STEPS * ORDER * ORDER / (4 * order * order))
    }

    /// Encloses the motion.
    fn run<S: Enclosure>(
        &self,
        start: &Start,
        times: &Times,
        bits: usize,
        precision: S::Precision,
    ) -> Result<Run, MotionError> {
        let (order, most_steps) = Self::order(bits);
        let first = start.enclosed::<S>(precision)?;
        let all = times.len();
        let time = |row: usize| times.enclosed::<S>(row, precision);
        let end = times.at(all - 1).abs_upper();
        let at_start = (0..all).take_while(|row| times.at(*row).is_zero());
        let rows = at_start.map(|_| first.iter().map(S::to_ball).collect()).collect();
        let mut run = Run { rows, steps: 0, stuck: None };
        let mut walk = Following::<S>::new(&self.equations, order, precision, &first, end);
        while run.rows.len() < all {
            let now = S::exact(walk.time(), precision);
            let left = time(all - 1).sub(&now).abs_upper();
            let lost = walk.spread() > LARGE;
            let reach = if lost { None } else { walk.reach(left) };
            let expected = count(run.steps) * end / walk.time();
            let too_many = run.steps >= most_steps || run.steps >= FIRST_STEPS && expected > 2.0 * count(most_steps);
            let Some(reach) = reach.filter(|_| !too_many) else {
                run.stuck = Some(Stuck { time: walk.time(), spread: lost, steps: too_many });
                return Ok(run);
            };
            while run.rows.len() < all {
                let after = time(run.rows.len()).sub(&now);
                let ends = after.to_ball();
                if ends.upper() > reach || ends.lower() < 0.0 {
                    break;
                }
                let Some(state) = walk.at(&after) else { break };
                run.rows.push(state.iter().map(S::to_ball).collect());
            }
            if walk.advance().is_none() {
                run.stuck = Some(Stuck { time: walk.time(), spread: true, steps: false });
                return Ok(run);
            }
            run.steps += 1;
        }
        Ok(run)
    }
}

/// How many bits the motion wants, if there are not enough.
fn wanted_bits(run: &Run, times: &Times, digits: usize, bits: usize) -> Option<usize> {
    let more = match run.stuck {
        // Beside a singularity bits do not help, and more of them mean more steps.
        Some(stuck) if stuck.steps || !stuck.spread => return None,
        // They have gone evenly, as far as that goes.
        Some(stuck) => {
            let share = times.at(times.len() - 1).mid_f64() / stuck.time.max(f64::MIN_POSITIVE);
            count(bits) * (share.min(100.0) - 1.0) + count(digits) * std::f64::consts::LOG2_10
        }
        None => {
            let missing = missing_bits(&run.rows, digits);
            if missing <= 0.0 {
                return None;
            }
            missing
        }
    };
    let wanted = bits + more.ceil() as usize + SPARE_BITS;
    Some(wanted.max(bits + bits / 4).next_multiple_of(32))
}

/// By how many bits the worst value misses so many digits of the size of its column. A column that can't be told from 0 counts
/// as large as the others.
fn missing_bits(rows: &[Vec<Ball>], digits: usize) -> f64 {
    let columns = rows.first().map_or(0, Vec::len);
    let size = |column: usize| rows.iter().map(|row| row[column].abs_lower()).fold(0.0_f64, f64::max);
    let sizes: Vec<f64> = (0..columns).map(size).collect();
    let largest = sizes.iter().fold(0.0_f64, |most, size| most.max(*size));
    let allowed = 10.0_f64.powi(-i32::try_from(digits).unwrap_or(i32::MAX)) * 0.125;
    let mut missing = f64::NEG_INFINITY;
    for row in rows {
        for (value, size) in row.iter().zip(&sizes) {
            let size = if *size > 0.0 { *size } else { largest };
            if value.radius > 0.0 && size > 0.0 {
                missing = missing.max((value.radius / (allowed * size)).log2());
            }
        }
    }
    missing
}
