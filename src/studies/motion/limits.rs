//! What ends a motion, and what of it is lost below the range of numbers.

use super::equations::NO_INVERSE;
use super::error::MotionError;
use super::step::{Real, Stepper, Trouble, sign};
use super::{Start, System, Times, moment};
use crate::flow::count;
use librate_core::precision::{Ball, Big, Enclosure, has_pivots, power_of_two};

/// Bits of the numbers that a place is examined with: these have no range to leave.
const BITS: usize = 128;
/// A motion is taken to reach what it would come to in so many steps at its speed: more than the distance of a singularity, of which
/// a step of a series is some tenth.
const BESIDE: f64 = 64.0;
/// Beyond this a motion has left every scale that it began with.
const ASTRONOMICAL: f64 = 1e9;
/// Below this, numbers in double-double lose digits.
const SMALL: f64 = power_of_two(-960);
/// What a step may lose of a number there.
const LOST: f64 = power_of_two(-1060);
/// So many rows are examined.
const SAMPLES: usize = 256;
/// Forces below this, in SI, are what rounding leaves at the end of the range.
const NOTHING: f64 = 1e-200;
/// How far what may not rest is moved to see what it moves.
const MOVED: f64 = 1e-30;

/// What the equations of motion are near a place.
enum Nearby {
    /// Somewhere they have no value.
    Undefined,
    /// Somewhere the mass matrix may have no inverse.
    NoInverse,
    /// They are what they are everywhere.
    Defined,
}

impl System {
    /// Why a motion ends at the place of a step. A singularity is only said where an enclosure holds one.
    pub(super) fn ended<S: Real>(
        &self,
        stepper: &Stepper<'_, S>,
        trouble: Trouble,
        t: &S,
        (q, v): (&[S], &[S]),
        length: f64,
    ) -> MotionError {
        let place = self.names.iter().zip(q).map(|(name, x)| format!("{name} = {}", moment(x.middle())));
        let mut place: Vec<String> = place.take(6).collect();
        place.extend((self.names.len() > 6).then(|| "…".to_owned()));
        let (time, place) = (moment(t.middle()), place.join(", "));
        let beside = if length > 0.0 { " or right beside it" } else { "" };
        let nearby = self.nearby(stepper, t, (q, v), BESIDE * length);
        let far = q.iter().chain(v).any(|x| x.middle().abs() > ASTRONOMICAL);
        let singular = |reason| MotionError::Singular { time: time.clone(), place: place.clone(), reason };
        let stuck =
            |reason: &str| MotionError::Stuck { time: time.clone(), place: place.clone(), reason: reason.to_owned() };
        match (trouble, nearby) {
            (Trouble::Kink, _) => {
                singular("forces on both sides lead to the kink of an absolute value, where there is none".to_owned())
            }
            (Trouble::Fork, _) => singular(
                "forces on both sides lead away from the kink of an absolute value: several motions begin there"
                    .to_owned(),
            ),
            (Trouble::Impact, _) => singular(
                "the momentum or the energy would jump at the kink of an absolute value, as in an impact or at a step"
                    .to_owned(),
            ),
            (_, Nearby::Undefined) => singular(format!("the equations of motion are not defined there{beside}")),
            (_, Nearby::NoInverse) => singular(format!("{NO_INVERSE}{beside}")),
            (Trouble::NoStep, Nearby::Defined) if far => {
                stuck("steps have become too short, as where a motion grows beyond all bounds")
            }
            (Trouble::NoStep, Nearby::Defined) => {
                stuck("steps have become too short, as where a force or one of its derivatives is infinite or jumps")
            }
            (Trouble::Singular | Trouble::NotFinite, Nearby::Defined) => stuck(
                "a number there is too large or too small to compute with, or a derivative of a force is infinite",
            ),
        }
    }

    /// The equations about a place, as far as the motion gets from there in a time.
    fn nearby<S: Real>(&self, stepper: &Stepper<'_, S>, t: &S, (q, v): (&[S], &[S]), time: f64) -> Nearby {
        let around = |x: &S, rate: f64| {
            let reach = if time > 0.0 { rate.abs() * time } else { 0.0 };
            Enclosure::with_added_radius(&Big::from_ball(&x.to_ball(), BITS), reach)
        };
        let mut inputs = vec![around(t, 1.0)];
        inputs.extend(q.iter().zip(v).map(|(x, rate)| around(x, rate.middle())));
        let mut rates = vec![0.0; v.len()];
        for (i, row) in stepper.equations.free.iter().zip(&stepper.accelerations) {
            rates[*i] = row[0].middle();
        }
        inputs.extend(v.iter().zip(rates).map(|(x, rate)| around(x, rate)));
        let signs = stepper.signs.iter().map(|sign| Big::from_f64(*sign, BITS));
        inputs.extend(signs);
        inputs.resize(1 + q.len() + v.len() + self.equations.kinks.outputs(), Big::from_f64(1.0, BITS));
        let values = self.equations.tape.prepare::<Big>(BITS).evaluate(&inputs, &mut Vec::new());
        if values.iter().any(|x| !x.is_finite()) {
            Nearby::Undefined
        } else if self.has_inverse(&values) {
            Nearby::Defined
        } else {
            Nearby::NoInverse
        }
    }

    /// Whether M, with -Jᵀ and J beside it, has an inverse: by elimination without exchanges, which M > 0 allows.
    fn has_inverse(&self, values: &[Big]) -> bool {
        let first = self.equations.mass.len() + self.equations.coordinates;
        let zero = Big::from_f64(0.0, BITS);
        let matrix = self.equations.bordered(zero, |at| values[at].clone(), |at| values[first + at].clone());
        has_pivots(matrix.rows().map(<[Big]>::to_vec).collect(), |pivot| !pivot.contains_zero(), BITS)
    }

    /// What coordinates and velocities, a row after the other, may be off by because numbers get too small on the way: so much of
    /// an acceleration is lost where parts of the equations are below the range of double-double.
    pub(super) fn lost(&self, start: &Start, times: &Times, rows: &[Vec<Ball>], steps: usize) -> Vec<Vec<f64>> {
        let n = self.names.len();
        let rests = self.rests(start, times, rows);
        let stride = rows.len().div_ceil(SAMPLES).max(1);
        let mut lost = vec![0.0_f64; n];
        let always = LOST * count(steps + 1);
        let mut all = Vec::with_capacity(rows.len());
        for (at, row) in rows.iter().enumerate() {
            if at % stride == 0 {
                let own = self.lost_at(&times.at(at), row);
                for (most, own) in lost.iter_mut().zip(own) {
                    *most = most.max(own);
                }
            }
            let t = times.at(at).mid_f64();
            let part = |column: usize| {
                if rests[column % n] {
                    return 0.0;
                }
                let way = if column < n { 0.5 * t } else { 1.0 };
                always + lost[column % n] * t * way
            };
            all.push((0..2 * n).map(part).collect());
        }
        all
    }

    /// What accelerations are off by at a state because of numbers that are too small.
    fn lost_at(&self, time: &Ball, row: &[Ball]) -> Vec<f64> {
        let equations = &self.equations;
        let n = equations.coordinates;
        let inputs = self.inputs(time, row, |(_, x)| Ball::new(x.mid, 0.0));
        let mut scratch = Vec::new();
        let values = equations.tape.evaluate::<Ball>(&inputs, &mut scratch);
        let vanishes = |x: &Ball| !x.is_zero() && x.mid.hi.abs() < SMALL;
        if !scratch.iter().any(vanishes) {
            return Vec::new();
        }
        let mut inertia = vec![(0.0_f64, 0.0_f64); n];
        for ((i, j), entry) in equations.mass.iter().zip(&values) {
            for row in [*i, *j] {
                let (size, off) = inertia[row];
                inertia[row] = (size.max(entry.mid.hi.abs()), off + entry.radius);
            }
        }
        let loads = values.iter().skip(equations.mass.len()).zip(&inertia);
        let lost = loads.map(|(load, (size, off))| (load.radius + load.mid.hi.abs() * off / size) / size);
        lost.map(|own| if own.is_finite() { own } else { f64::INFINITY }).collect()
    }

    /// Time, coordinates and velocities of a row, each as it is wanted, and the signs of what absolute values are taken of.
    fn inputs(&self, time: &Ball, row: &[Ball], own: impl Fn((usize, &Ball)) -> Ball) -> Vec<Ball> {
        let mut inputs = vec![*time];
        inputs.extend(row.iter().map(|x| Ball::new(x.mid, 0.0)));
        let kinks = self.equations.kinks.evaluate(&inputs, &mut Vec::new());
        inputs.truncate(1);
        inputs.extend(row.iter().enumerate().map(own));
        inputs.extend(kinks.iter().map(|x| Ball::exact(sign(x.mid.hi))));
        inputs
    }

    /// Which coordinates rest at 0: not those that a force moves which is lost below the range of numbers, nor those that these
    /// would move.
    fn rests(&self, start: &Start, times: &Times, rows: &[Vec<Ball>]) -> Vec<bool> {
        let n = self.names.len();
        let first = start.row();
        let still = |row: &Vec<Ball>, i: usize| row[i].is_zero() && row[n + i].is_zero();
        let mut rests: Vec<bool> = (0..n).map(|i| still(&first, i) && rows.iter().all(|row| still(row, i))).collect();
        if !rests.contains(&true) {
            return rests;
        }
        let zero = rests.clone();
        let stride = rows.len().div_ceil(SAMPLES).max(1);
        for (at, row) in rows.iter().enumerate().step_by(stride) {
            let mut before: Option<Vec<Ball>> = None;
            loop {
                let lost = |at: usize| zero[at % n] && !rests[at % n];
                let own =
                    |(at, x): (usize, &Ball)| Ball::new(x.mid, if before.is_some() && lost(at) { MOVED } else { 0.0 });
                let inputs = self.inputs(&times.at(at), row, own);
                let values = self.equations.tape.evaluate(&inputs, &mut Vec::new());
                let loads = &values[self.equations.mass.len()..][..n];
                let moved = |i: usize| match &before {
                    None => loads[i].radius > 0.0 && loads[i].radius < NOTHING,
                    Some(before) => before[i].is_zero() && !loads[i].is_zero(),
                };
                let moved: Vec<usize> = (0..n).filter(|i| rests[*i] && moved(*i)).collect();
                if before.is_some() && moved.is_empty() {
                    break;
                }
                before.get_or_insert_with(|| loads.to_vec());
                moved.iter().for_each(|i| rests[*i] = false);
            }
        }
        rests
    }
}

impl Start {
    /// The values at the start, with what is lost of those that are too small.
    pub(super) fn row(&self) -> Vec<Ball> {
        let own = self.positions.iter().chain(&self.velocities);
        let known = self.known.iter().map(|own| own.enclosed::<Ball>(()));
        let with = |(x, known): (&Ball, Option<Ball>)| match known {
            Some(known) if known.abs_upper() < SMALL => x.with_added_radius(known.radius),
            _ => *x,
        };
        own.zip(known).map(with).collect()
    }
}
