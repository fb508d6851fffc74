//! One motion in numbers of one precision: its turning points and the integral between them.

use super::barrier::Height;
use super::panel::{Field, Obstacle, Path, Refusal, order_for};
use super::turning::Outward;
use super::{Oscillator, PeriodError, Request};
use librate_core::precision::{Big, Enclosure};

/// A barrier this near to the equilibrium, beside the amplitude, is the equilibrium.
const AT_CENTRE: f64 = 1e-6;

/// A barrier is searched for within this part of the path from where the integral ended.
const NEAR_BARRIER: f64 = 1.0 / 16.0;

/// Turning points that turn out not to be the first ones.
const MOST_RETRIES: usize = 40;

/// A motion, in numbers of some precision.
pub(super) struct Found<S> {
    pub(super) period: S,
    pub(super) course: Course<S>,
    pub(super) energy: S,
}

pub(super) enum Course<S> {
    Libration([S; 2]),
    Rotation(S),
}

/// Why there is none.
pub(super) enum Stop<S> {
    Final(PeriodError),
    /// Numbers of this precision do not do, at this place.
    Precision(S),
    /// The integral fails at this place.
    Rough(S),
    /// The energy can't be told from that of the equilibrium.
    AtRest,
}

/// A motion to be found with numbers of one precision.
pub(super) struct Task<'a, S: Enclosure> {
    oscillator: &'a Oscillator,
    pub(super) field: Field<S>,
    /// The equilibrium.
    pub(super) centre: S,
    /// The upper turning point and its distance, where these are given.
    pub(super) turning: Option<(S, S)>,
    /// How far the coordinate goes in a full turn.
    advance: Option<S>,
    bits: u32,
    /// A place where E - U is known to be negative.
    fence: Option<S>,
}

impl<'a, S: Enclosure> Task<'a, S> {
    pub(super) fn new(
        oscillator: &'a Oscillator,
        request: &Request,
        precision: S::Precision,
        centre: S,
        bits: u32,
        fence: Option<&Big>,
    ) -> Self {
        let mut field = oscillator.field::<S>(precision);
        let value = oscillator.value::<S>(request, precision);
        let (energy, turning) = match request {
            Request::Amplitude(_) => {
                let turning = centre.add(&value);
                (field.potential(&turning), Some((turning, value)))
            }
            Request::Energy(_) => (value, None),
        };
        field.set_energy(energy);
        Self {
            oscillator,
            field,
            centre,
            turning,
            advance: oscillator.advance::<S>(precision),
            bits,
            fence: fence.map(|fence| S::from_big(fence, precision)),
        }
    }

    fn name(&self) -> String {
        self.oscillator.coordinate().name()
    }

    pub(super) fn run(&mut self) -> Result<Found<S>, Stop<S>> {
        if !self.field.energy.is_finite() {
            let at = self.turning.as_ref().map_or(&self.centre, |(at, _)| at);
            return Err(Stop::Rough(at.clone()));
        }
        let centre = self.centre.clone();
        let excess = self.field.excess_at(&centre);
        if !excess.is_finite() {
            return Err(Stop::Rough(centre));
        }
        let amplitude = self.turning.is_some();
        if excess.is_negative() || excess.is_exact_zero() {
            return Err(Stop::Final(if !amplitude {
                self.below_equilibrium()
            } else if self.is_maximum() {
                self.maximum()
            } else {
                self.blocked()
            }));
        }
        if !excess.is_positive() {
            return Err(if amplitude {
                // As high as the equilibrium, it may be, and a barrier between: bits do not tell.
                self.barrier_between().map_or_else(|| Stop::Precision(centre), |error| Stop::Final(error))
            } else {
                Stop::AtRest
            });
        }
        let (period, course) = match self.turning.clone() {
            Some((turning, distance)) => self.by_amplitude(turning, &distance)?,
            None => self.by_energy(&excess)?,
        };
        Ok(Found { period, course, energy: self.field.energy.clone() })
    }

    fn by_amplitude(&mut self, upper: S, distance: &S) -> Result<(S, Course<S>), Stop<S>> {
        let right = match self.time(upper.clone(), distance.neg(), true) {
            Ok(time) => time,
            Err(Obstacle { refusal: Refusal::Forbidden, .. }) => return Err(Stop::Final(self.blocked())),
            Err(obstacle) => return Err(self.stopped(obstacle)),
        };
        self.with_lower(&right, upper, distance, -distance.mid_f64() / 8.0, None)
    }

    /// The whole motion from its upper half.
    fn with_lower(
        &mut self,
        right: &S,
        upper: S,
        distance: &S,
        step: f64,
        reach: Option<f64>,
    ) -> Result<(S, Course<S>), Stop<S>> {
        let (left, lower) = match self.oscillator.even {
            true => (right.clone(), self.centre.sub(distance)),
            false => self.side(step, reach)?,
        };
        Ok((right.add(&left), Course::Libration([lower, upper])))
    }

    fn by_energy(&mut self, excess: &S) -> Result<(S, Course<S>), Stop<S>> {
        let step = self.step(excess);
        let reach = self.advance.as_ref().map(|advance| advance.mid_f64().abs());
        // Where steps meet no turning point within a turn, there is none, or the integral will tell.
        if let (Some(advance), None) = (self.advance.clone(), &self.fence) {
            match self.field.outward(&self.centre, step, reach) {
                Outward::Touch(summit) => return Err(Stop::Precision(summit)),
                Outward::Open => match self.time(self.centre.clone(), advance.clone(), false) {
                    Ok(time) => {
                        let advance = if advance.is_negative() { advance.neg() } else { advance };
                        return Ok((time.mul(&self.field.number(0.5)), Course::Rotation(advance)));
                    }
                    Err(Obstacle { refusal: Refusal::Forbidden, at }) => self.fence = Some(at),
                    Err(obstacle) => return Err(self.stopped(obstacle)),
                },
                Outward::Bracket(..) | Outward::End(_) => {}
            }
        }
        let (right, upper) = self.side(step, reach)?;
        let distance = upper.sub(&self.centre);
        self.with_lower(&right, upper, &distance, -step, reach)
    }

    /// The time from the first turning point on one side to the equilibrium, and that point.
    fn side(&mut self, step: f64, reach: Option<f64>) -> Result<(S, S), Stop<S>> {
        let centre = self.centre.clone();
        // The known barrier, where it lies on this side.
        let fence = self.fence.clone().filter(|fence| fence.sub(&centre).mid_f64() * step > 0.0);
        let mut bracket = match (self.field.outward(&self.centre, step, reach), &fence) {
            (Outward::Bracket(inside, outside), _) => (inside, outside),
            (_, Some(fence)) => (centre.clone(), fence.clone()),
            (Outward::End(end), None) => return Err(Stop::Final(self.open(step > 0.0, Some(end)))),
            (Outward::Touch(summit), None) => return Err(Stop::Precision(summit)),
            (Outward::Open, None) => return Err(Stop::Final(self.open(step > 0.0, None))),
        };
        // A barrier that is known is nearer than what steps over it have met.
        if let Some(fence) = fence
            && bracket.1.sub(&fence).mid_f64() * step > 0.0
        {
            bracket = (centre.clone(), fence);
        }
        for _ in 0..MOST_RETRIES {
            let found = self.field.turning_point(&bracket.0, &bracket.1);
            let Some(turning) = found else { return Err(Stop::Precision(bracket.1)) };
            match self.time(turning.clone(), centre.sub(&turning), true) {
                Ok(time) => return Ok((time, turning)),
                Err(Obstacle { refusal: Refusal::Forbidden, at }) => bracket = (centre.clone(), at),
                Err(obstacle) => return Err(self.stopped(obstacle)),
            }
        }
        Err(Stop::Precision(bracket.1))
    }

    /// The time along a path, from kink to kink.
    fn time(&mut self, start: S, span: S, turning: bool) -> Result<S, Obstacle<S>> {
        let mut times = Vec::new();
        for (at, (start, span)) in self.field.pieces(start, span)?.into_iter().enumerate() {
            self.field.hold(&start, &span);
            let time = self.smooth_time(start, span, turning && at == 0);
            self.field.release();
            times.push(time?);
        }
        Ok(times.into_iter().reduce(|total, time| total.add(&time)).unwrap_or_else(|| self.field.number(0.0)))
    }

    /// The time along a path without kinks. Panels are as short as one likes at its start alone: where that is not enough to pass a
    /// barrier, the path is taken in three parts, two of which start on the barrier.
    fn smooth_time(&mut self, start: S, span: S, turning: bool) -> Result<S, Obstacle<S>> {
        let obstacle = match self.time_between(start.clone(), span.clone(), turning) {
            Err(obstacle) if matches!(obstacle.refusal, Refusal::Rough | Refusal::Precision) => obstacle,
            decided => return decided,
        };
        let end = start.add(&span);
        let reach = NEAR_BARRIER * span.mid_f64().abs();
        let barrier = self.field.summit(&obstacle.at, reach).map(|(barrier, _)| barrier);
        let is_passed = |barrier: &S| barrier.sub(&start).mul(&end.sub(barrier)).is_positive();
        let Some(barrier) = barrier.filter(is_passed) else { return Err(obstacle) };
        let way = barrier.sub(&start).mul(&self.field.number(0.5));
        let first = self.time_between(start, way.clone(), turning)?;
        let before = self.time_between(barrier.clone(), way.neg(), false)?;
        let rest = end.sub(&barrier);
        Ok(first.add(&before).add(&self.time_between(barrier, rest, false)?))
    }

    fn time_between(&mut self, start: S, span: S, turning: bool) -> Result<S, Obstacle<S>> {
        Path { field: &mut self.field, start, span, turning, order: order_for(self.bits), bits: self.bits }.time()
    }

    /// A step outward that is small beside the amplitude.
    fn step(&mut self, excess: &S) -> f64 {
        let (potential, _) = self.field.expand(&self.centre, &self.field.number(1.0), 3);
        if let Some(half) = potential.get(2).filter(|half| half.is_positive()) {
            // E - U = u2 A²
            let amplitude = excess.div(half).sqrt().mid_f64();
            if amplitude.is_finite() && amplitude > 0.0 {
                return amplitude / 8.0;
            }
        }
        let mut step = 1e-30;
        while step < 1e30 {
            let at = self.centre.add(&self.field.number(step));
            if !self.field.excess_at(&at).is_positive() {
                return step / 16.0;
            }
            step *= 2.0;
        }
        1.0
    }

    fn stopped(&self, obstacle: Obstacle<S>) -> Stop<S> {
        match obstacle.refusal {
            Refusal::NegativeMass => {
                let coordinate = self.oscillator.coordinate();
                Stop::Final(PeriodError::NegativeMass {
                    coordinate: coordinate.name(),
                    place: self.oscillator.place(obstacle.at.mid_f64()),
                    span: coordinate.span,
                })
            }
            Refusal::Rough => Stop::Rough(obstacle.at),
            Refusal::Long => Stop::Final(PeriodError::TooLong {
                coordinate: self.name(),
                place: self.oscillator.place(obstacle.at.mid_f64()),
            }),
            Refusal::Precision | Refusal::Forbidden => Stop::Precision(obstacle.at),
        }
    }

    fn is_maximum(&mut self) -> bool {
        let (potential, _) = self.field.expand(&self.centre, &self.field.number(1.0), 3);
        potential.get(2).is_some_and(Enclosure::is_negative)
    }

    pub(super) fn below_equilibrium(&mut self) -> PeriodError {
        PeriodError::BelowEquilibrium {
            energy: self.oscillator.height(self.field.energy.mid_f64()),
            potential: self.oscillator.height(self.field.potential(&self.centre).mid_f64()),
            maximum: self.is_maximum(),
        }
    }

    fn open(&self, upward: bool, end: Option<f64>) -> PeriodError {
        PeriodError::NotPeriodic { coordinate: self.name(), upward, end: end.map(|end| self.oscillator.place(end)) }
    }

    /// The error of an amplitude behind a barrier, which is searched for.
    fn blocked(&mut self) -> PeriodError {
        let centre = self.centre.clone();
        match self.barrier_between() {
            Some(error) => error,
            // Nothing rises above the place where it starts.
            None if self.field.excess_at(&self.centre).is_exact_zero() => self.open(false, None),
            None => PeriodError::Undecided { coordinate: self.name(), place: self.oscillator.place(centre.mid_f64()) },
        }
    }

    /// The error of an amplitude behind a barrier that is certainly higher, where there is one.
    pub(super) fn barrier_between(&mut self) -> Option<PeriodError> {
        let centre = self.centre.clone();
        let (upper, distance) = self.turning.clone()?;
        let (summit, height) = self.field.highest(&centre, &upper)?;
        if !height.at.sub(&self.field.energy).is_positive() {
            return None;
        }
        let way = summit.sub(&centre).mid_f64().abs();
        if way <= AT_CENTRE * distance.mid_f64().abs() {
            return Some(self.maximum());
        }
        Some(self.beyond_barrier(&summit, &height))
    }

    /// The error of an equilibrium that is a maximum.
    fn maximum(&self) -> PeriodError {
        PeriodError::Maximum { coordinate: self.name(), equilibrium: self.oscillator.place(self.centre.mid_f64()) }
    }

    pub(super) fn beyond_barrier(&mut self, summit: &S, height: &Height<S>) -> PeriodError {
        let bottom = self.field.potential(&self.centre);
        let amplitude = self.turning.as_ref().map_or(f64::NAN, |(_, distance)| distance.mid_f64());
        PeriodError::BeyondBarrier {
            amplitude: self.oscillator.place(amplitude),
            coordinate: self.name(),
            barrier: self.oscillator.place(summit.mid_f64()),
            height: height.words(&bottom, self.oscillator),
            energy: self.oscillator.height(self.field.energy.sub(&bottom).mid_f64()),
        }
    }
}
