//! From a request to a period: turning points, the integral, and as many bits as it takes.

use super::panel::{Field, Obstacle, Path, Refusal, order_for};
use super::real::Real;
use super::turning::Outward;
use super::{Motion, Options, Oscillator, Period, PeriodError, Request, decides};
use crate::linearize::short;
use crate::precision::{Ball, Big, Magnitude, Rounding, Scalar};

/// The rest that is asked for at least: the period is then known better than doubles tell.
const LEAST_BITS: u32 = 62;

/// Doubled doubles do for so many bits, with room for what cancels.
const BITS_OF_BALLS: u32 = 86;

/// Numbers of more bits than these are not tried.
const MOST_BITS: usize = 4096;

/// What a barrier is looked at with.
const BITS_OF_BARRIERS: usize = 320;

/// An energy nearer to the height of a barrier than this, relative to the height of the motion, counts as at the
/// barrier where the integral fails.
const AT_BARRIER: f64 = 1e-30;

/// Turning points that turn out not to be the first ones.
const MOST_RETRIES: usize = 40;

/// A motion, in numbers of some precision.
struct Found<S> {
    period: S,
    course: Course<S>,
    energy: S,
}

enum Course<S> {
    Libration([S; 2]),
    Rotation(S),
}

/// Why there is none.
enum Stop<S> {
    Final(PeriodError),
    /// Numbers of this precision do not do, at this place.
    Precision(S),
    /// The integral fails at this place.
    Rough(S),
    /// The energy can't be told from that of the equilibrium.
    AtRest,
}

/// What more bits or a look at a barrier make of a failure.
enum Verdict {
    Final(PeriodError),
    /// There is a barrier: E - U is negative at this place.
    Fence(Big),
    Unknown,
}

/// The motion that is asked for.
pub(super) fn period(
    oscillator: &Oscillator,
    request: &Request,
    options: &Options,
) -> Result<Period, PeriodError> {
    check_request(oscillator, request)?;
    let equilibrium = oscillator.linearized.equilibrium();
    let wanted = (options.digits as f64 * std::f64::consts::LOG2_10).ceil() as u32 + 20;
    let mut bits = wanted.max(LEAST_BITS);
    // What is not proved is taken as it stands.
    let at = |value: &Ball| {
        if equilibrium.proved {
            *value
        } else {
            Ball::new(value.mid, 0.0)
        }
    };
    let place = equilibrium.values.first().map_or(Ball::ZERO, at);
    let mut fence = None;
    if bits <= BITS_OF_BALLS {
        let mut task = Task::<Ball>::new(oscillator, request, (), place, bits, None);
        match task.run(request) {
            Ok(found) if decides(&found.period, options.digits) => {
                let mut field = task.field;
                let (small, bend) = small(&mut field, &place);
                return Ok(finished(oscillator, &place, found, None, small, None, bend));
            }
            Ok(_) => {}
            Err(Stop::Final(error)) => return Err(error),
            Err(Stop::AtRest) => {}
            Err(stop @ (Stop::Precision(_) | Stop::Rough(_))) => {
                fence = judge(oscillator, request, &place, stop)?;
            }
        }
    }
    let mut precision = (bits as usize + 64).next_multiple_of(64);
    let mut attempts = 0;
    loop {
        attempts += 1;
        let precise = oscillator.linearized.precisely(precision);
        let centre = match precise.filter(|_| equilibrium.proved) {
            Some(precise) => precise.equilibrium.into_iter().next(),
            None => None,
        };
        let centre = centre.unwrap_or_else(|| Big::from_ball(&place, precision));
        let mut task = Task::<Big>::new(
            oscillator,
            request,
            precision,
            centre.clone(),
            bits,
            fence.as_ref(),
        );
        match task.run(request) {
            Ok(found) => {
                let rounding = found.period.decimal(options.digits).rounding;
                let complete = matches!(rounding, Rounding::Correct | Rounding::Tie);
                if complete || attempts > 6 {
                    let mut field = task.field;
                    let (small_precise, bend) = small(&mut field, &centre);
                    let period = found.period.clone();
                    let small = small_precise.as_ref().map(Big::to_ball);
                    let bend = bend.map(|bend| bend.to_ball());
                    let place = centre.to_ball();
                    return Ok(finished(
                        oscillator,
                        &place,
                        found,
                        Some(period),
                        small,
                        small_precise,
                        bend,
                    ));
                }
                bits += 40;
                precision += 64;
            }
            Err(Stop::Final(error)) => return Err(error),
            Err(Stop::AtRest) if precision * 2 > MOST_BITS => {
                return Err(task.below_equilibrium());
            }
            Err(Stop::AtRest) => precision *= 2,
            Err(stop) => {
                let at = match &stop {
                    Stop::Precision(at) | Stop::Rough(at) => at.clone(),
                    Stop::Final(_) | Stop::AtRest => centre.clone(),
                };
                let found = judge(oscillator, request, &place, stop)?;
                // A barrier that was not known is a way on; else it takes more bits.
                if found.is_none() || fence.is_some() {
                    precision *= 2;
                }
                fence = fence.or(found);
                if attempts > 12 || precision > MOST_BITS {
                    return Err(PeriodError::Undecided {
                        coordinate: oscillator.coordinate().name.clone(),
                        place: short(at.mid_f64()),
                    });
                }
            }
        }
    }
}

fn check_request(oscillator: &Oscillator, request: &Request) -> Result<(), PeriodError> {
    let value = oscillator.value::<Ball>(request, ());
    let (what, text) = match request {
        Request::Amplitude(constant) => ("the amplitude", constant.text()),
        Request::Energy(constant) => ("the energy", constant.text()),
    };
    let bad = |reason| {
        Err(PeriodError::BadRequest {
            what,
            value: text.to_owned(),
            reason,
        })
    };
    if !value.is_finite() {
        return bad("it is not a finite number");
    }
    let amplitude = matches!(request, Request::Amplitude(_));
    if amplitude && (value.is_zero() || value.is_negative()) {
        return bad("an amplitude is the distance to the upper turning point, which is positive");
    }
    Ok(())
}

fn finished<S: Real>(
    oscillator: &Oscillator,
    place: &Ball,
    found: Found<S>,
    precise: Option<Big>,
    small: Option<Ball>,
    small_precise: Option<Big>,
    bend: Option<Ball>,
) -> Period {
    let motion = match found.course {
        Course::Libration([lower, upper]) => Motion::Libration {
            turning: [lower.ball(), upper.ball()],
        },
        Course::Rotation(advance) => Motion::Rotation {
            advance: advance.ball(),
        },
    };
    Period {
        period: found.period.ball(),
        precise,
        motion,
        energy: found.energy.ball(),
        equilibrium: *place,
        proved: oscillator.linearized.equilibrium().proved,
        small,
        small_precise,
        bend,
    }
}

/// 2 pi sqrt(M/K) at the equilibrium and the leading change of the frequency.
///
/// With X = ∫ sqrt(M/M0) dx and U = u2 X² + U3 X³ + U4 X⁴ + …: omega = omega_0 (1 + A² (3 U4/(4 u2) - 15 U3²/(16 u2²)))
/// (L. D. Landau and E. M. Lifshitz, Mechanics, §28, with omega_0² = 2 u2/M0, alpha = 3 U3/M0, beta = 4 U4/M0). The
/// amplitude of X is that of x to the leading order.
fn small<S: Real>(field: &mut Field<S>, at: &S) -> (Option<S>, Option<S>) {
    let one = field.number(1.0);
    let number = |value: f64| field.number(value);
    let [quarter, twenty_fourth, two_pi] = [
        number(0.25),
        number(1.0).div(&number(24.0)),
        field.pi().mul(&number(2.0)),
    ];
    let (ten, three, half, three_quarters, fifteen_sixteenths) = (
        number(10.0),
        number(3.0),
        number(0.5),
        number(0.75),
        number(0.9375),
    );
    let two = number(2.0);
    let (u, m) = field.expand(at, &one, 5);
    let ([_, _, u2, u3, u4], [m0, m1, m2, _, _]) = (u.as_slice(), m.as_slice()) else {
        return (None, None);
    };
    if !(u2.is_positive() && m0.is_positive()) {
        return (None, None);
    }
    let small = two_pi.mul(&m0.div(&u2.add(u2)).sqrt());
    // M = M0 (1 + a x + b x²): X = x + p x² + r x³ with p = a/4, r = b/6 - a²/24; then x = X - p X² + (2p² - r) X³.
    let (a, b) = (m1.div(m0), m2.div(m0));
    let p = a.mul(&quarter);
    let r = b
        .mul(&quarter.mul(&two).div(&three))
        .sub(&a.mul(&a).mul(&twenty_fourth));
    let square = p.mul(&p);
    let third = u3.sub(&p.mul(u2).mul(&two));
    let fourth = u2
        .mul(&square.mul(&ten.mul(&half)).sub(&r.mul(&two)))
        .sub(&p.mul(u3).mul(&three))
        .add(u4);
    let bend = fourth
        .div(u2)
        .mul(&three_quarters)
        .sub(&third.div(u2).powi(2).mul(&fifteen_sixteenths));
    let bend = bend.is_finite().then_some(bend);
    (small.is_finite().then_some(small), bend)
}

/// What is to be said about a place where an integral failed: nothing yet, that there is a barrier, or an error.
fn judge<S: Real>(
    oscillator: &Oscillator,
    request: &Request,
    place: &Ball,
    stop: Stop<S>,
) -> Result<Option<Big>, PeriodError> {
    let (at, rough) = match &stop {
        Stop::Precision(at) => (at, false),
        Stop::Rough(at) => (at, true),
        Stop::Final(_) | Stop::AtRest => return Ok(None),
    };
    match look(
        oscillator,
        request,
        place,
        &at.to_big(BITS_OF_BARRIERS),
        rough,
    ) {
        Verdict::Final(error) => Err(error),
        Verdict::Fence(fence) => Ok(Some(fence)),
        Verdict::Unknown if rough => Err(PeriodError::NotSmooth {
            coordinate: oscillator.coordinate().name.clone(),
            place: short(at.middle()),
        }),
        Verdict::Unknown => Ok(None),
    }
}

/// Looks for a barrier beside a place where an integral failed; where it failed because of panels that get too
/// small, a barrier that is nearly touched is the reason.
fn look(
    oscillator: &Oscillator,
    request: &Request,
    place: &Ball,
    at: &Big,
    rough: bool,
) -> Verdict {
    let bits = BITS_OF_BARRIERS;
    let precise = oscillator.linearized.precisely(bits);
    let centre = precise.and_then(|precise| precise.equilibrium.into_iter().next());
    let centre = centre.unwrap_or_else(|| Big::from_ball(place, bits));
    let mut task = Task::<Big>::new(oscillator, request, bits, centre, 256, None);
    let reach = at.sub(&task.centre).mid_f64().abs();
    let Some((summit, height)) = task.field.summit(at, reach) else {
        return Verdict::Unknown;
    };
    let one = task.field.number(1.0);
    let (potential, _) = task.field.expand(&summit, &one, 3);
    if !potential.get(2).is_some_and(Real::is_negative) {
        return Verdict::Unknown;
    }
    let excess = task.energy.sub(&height);
    let depth = height.sub(&task.field.potential(&task.centre)).largest();
    let small = depth * Magnitude::from_f64(AT_BARRIER);
    let undecided = !(excess.is_positive() || excess.is_negative());
    if undecided || rough && excess.largest() <= small {
        return Verdict::Final(PeriodError::AtBarrier {
            coordinate: oscillator.coordinate().name.clone(),
            barrier: short(summit.mid_f64()),
            margin: crate::precision::one_digit_up_text(excess.largest().to_f64()),
            height: short(height.mid_f64()),
        });
    }
    if excess.is_negative() {
        let Some((upper, _)) = task.turning.clone() else {
            return Verdict::Fence(summit);
        };
        if summit.sub(&upper).is_positive() {
            // The barrier that the motion turns before.
            return Verdict::Unknown;
        }
        return if summit.sub(&task.centre).is_negative() {
            Verdict::Fence(summit)
        } else {
            Verdict::Final(task.beyond_barrier(&summit, &height))
        };
    }
    Verdict::Unknown
}

/// A motion to be found with numbers of one precision.
struct Task<'a, S: Real> {
    oscillator: &'a Oscillator,
    field: Field<S>,
    centre: S,
    /// E.
    energy: S,
    /// The upper turning point and its distance, where these are given.
    turning: Option<(S, S)>,
    advance: Option<S>,
    bits: u32,
    /// A place where E - U is known to be negative.
    fence: Option<S>,
}

impl<'a, S: Real> Task<'a, S> {
    fn new(
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
        Self {
            oscillator,
            field,
            centre,
            energy,
            turning,
            advance: oscillator.advance::<S>(precision),
            bits,
            fence: fence.map(|fence| S::from_big(fence, precision)),
        }
    }

    fn name(&self) -> String {
        self.oscillator.coordinate().name.clone()
    }

    fn run(&mut self, request: &Request) -> Result<Found<S>, Stop<S>> {
        let energy = self.energy.clone();
        if !energy.is_finite() {
            let at = self.turning.as_ref().map_or(&self.centre, |(at, _)| at);
            return Err(Stop::Final(PeriodError::NotSmooth {
                coordinate: self.name(),
                place: short(at.middle()),
            }));
        }
        let centre = self.centre.clone();
        let excess = self.field.excess_at(&energy, &centre);
        if !excess.is_finite() {
            return Err(Stop::Final(PeriodError::NotSmooth {
                coordinate: self.name(),
                place: short(centre.middle()),
            }));
        }
        let amplitude = matches!(request, Request::Amplitude(_));
        if excess.is_negative() || excess.is_exact_zero() {
            return Err(Stop::Final(if !amplitude {
                self.below_equilibrium()
            } else if self.is_maximum() {
                PeriodError::Maximum {
                    coordinate: self.name(),
                    equilibrium: short(centre.middle()),
                }
            } else {
                self.blocked()
            }));
        }
        if !excess.is_positive() {
            return Err(if amplitude {
                Stop::Precision(centre)
            } else {
                Stop::AtRest
            });
        }
        let course = match self.turning.clone() {
            Some((turning, distance)) => self.by_amplitude(turning, &distance)?,
            None => self.by_energy(&excess)?,
        };
        let (period, course) = course;
        Ok(Found {
            period,
            course,
            energy,
        })
    }

    fn by_amplitude(&mut self, upper: S, distance: &S) -> Result<(S, Course<S>), Stop<S>> {
        let right = match self.time(upper.clone(), distance.neg(), true) {
            Ok(time) => time,
            Err(Obstacle {
                refusal: Refusal::Forbidden,
                ..
            }) => return Err(Stop::Final(self.blocked())),
            Err(obstacle) => return Err(self.stopped(obstacle)),
        };
        if self.oscillator.even {
            let lower = self.centre.sub(distance);
            return Ok((right.add(&right), Course::Libration([lower, upper])));
        }
        let step = -distance.middle() / 8.0;
        let (left, lower) = match self.side(step, None)? {
            Some(side) => side,
            None => return Err(Stop::Final(self.open(false, None))),
        };
        Ok((right.add(&left), Course::Libration([lower, upper])))
    }

    fn by_energy(&mut self, excess: &S) -> Result<(S, Course<S>), Stop<S>> {
        let step = self.step(excess);
        let reach = self.advance.as_ref().map(|advance| advance.middle().abs());
        if self.advance.is_some() {
            // Where steps meet no turning point within a turn, there is none, or the integral will tell.
            let mut advance = self.advance.clone().unwrap_or_else(|| self.centre.clone());
            let outward = match &self.fence {
                Some(_) => None,
                None => Some(self.outward(step, reach)),
            };
            if let Some(Outward::Touch(summit)) = outward {
                return Err(Stop::Precision(summit));
            }
            if let Some(Outward::Open) = outward {
                match self.time(self.centre.clone(), advance.clone(), false) {
                    Ok(time) => {
                        if advance.is_negative() {
                            advance = advance.neg();
                        }
                        let half = self.field.number(0.5);
                        return Ok((time.mul(&half), Course::Rotation(advance)));
                    }
                    Err(Obstacle {
                        refusal: Refusal::Forbidden,
                        at,
                    }) => self.fence = Some(at),
                    Err(obstacle) => return Err(self.stopped(obstacle)),
                }
            }
        }
        let (right, upper) = match self.side(step, reach)? {
            Some(side) => side,
            None => return Err(Stop::Final(self.open(true, None))),
        };
        if self.oscillator.even {
            let distance = upper.sub(&self.centre);
            let lower = self.centre.sub(&distance);
            return Ok((right.add(&right), Course::Libration([lower, upper])));
        }
        let (left, lower) = match self.side(-step, reach)? {
            Some(side) => side,
            None => return Err(Stop::Final(self.open(false, None))),
        };
        Ok((right.add(&left), Course::Libration([lower, upper])))
    }

    fn outward(&mut self, step: f64, reach: Option<f64>) -> Outward<S> {
        let (energy, centre) = (self.energy.clone(), self.centre.clone());
        self.field.outward(&energy, &centre, step, reach)
    }

    /// The time from the first turning point on one side to the equilibrium, and that point; `None` where steps meet none.
    fn side(&mut self, step: f64, reach: Option<f64>) -> Result<Option<(S, S)>, Stop<S>> {
        let centre = self.centre.clone();
        let mut bracket = match self.outward(step, reach) {
            Outward::Bracket(inside, outside) => (inside, outside),
            Outward::End(end) if self.fence_on(step).is_none() => {
                return Err(Stop::Final(self.open(step > 0.0, Some(end))));
            }
            Outward::Touch(summit) if self.fence_on(step).is_none() => {
                return Err(Stop::Precision(summit));
            }
            Outward::Open | Outward::End(_) | Outward::Touch(_) => match self.fence_on(step) {
                Some(fence) => (centre.clone(), fence),
                None => return Ok(None),
            },
        };
        // A barrier that is known is nearer than what steps over it have met.
        if let Some(fence) = self.fence_on(step) {
            let nearer = bracket.1.sub(&fence).middle() * step > 0.0;
            if nearer {
                bracket = (centre.clone(), fence);
            }
        }
        let energy = self.energy.clone();
        for _ in 0..MOST_RETRIES {
            let found = self.field.turning_point(&energy, &bracket.0, &bracket.1);
            let Some(turning) = found else {
                return Err(Stop::Precision(bracket.1));
            };
            match self.time(turning.clone(), centre.sub(&turning), true) {
                Ok(time) => return Ok(Some((time, turning))),
                Err(Obstacle {
                    refusal: Refusal::Forbidden,
                    at,
                }) => bracket = (centre.clone(), at),
                Err(obstacle) => return Err(self.stopped(obstacle)),
            }
        }
        Err(Stop::Precision(bracket.1))
    }

    /// The known barrier, where it lies on the side that a step goes to.
    fn fence_on(&self, step: f64) -> Option<S> {
        let fence = self.fence.clone()?;
        let way = fence.sub(&self.centre).middle();
        (way * step > 0.0).then_some(fence)
    }

    fn time(&mut self, start: S, span: S, turning: bool) -> Result<S, Obstacle<S>> {
        Path {
            field: &mut self.field,
            energy: &self.energy,
            start,
            span,
            turning,
            order: order_for(self.bits),
            bits: self.bits,
        }
        .time()
    }

    /// A step outward that is small beside the amplitude.
    fn step(&mut self, excess: &S) -> f64 {
        let centre = self.centre.clone();
        let one = self.field.number(1.0);
        let (potential, _) = self.field.expand(&centre, &one, 3);
        if let Some(half) = potential.get(2).filter(|half| half.is_positive()) {
            // E - U = u2 A²
            let amplitude = excess.div(half).sqrt().middle();
            if amplitude.is_finite() && amplitude > 0.0 {
                return amplitude / 8.0;
            }
        }
        let mut step = 1e-30;
        while step < 1e30 {
            let at = self.centre.add(&self.field.number(step));
            let energy = self.energy.clone();
            if !self.field.excess_at(&energy, &at).is_positive() {
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
                    coordinate: coordinate.name.clone(),
                    place: short(obstacle.at.middle()),
                    span: coordinate.span,
                })
            }
            Refusal::Rough => Stop::Rough(obstacle.at),
            Refusal::Precision | Refusal::Forbidden => Stop::Precision(obstacle.at),
        }
    }

    fn is_maximum(&mut self) -> bool {
        let one = self.field.number(1.0);
        let centre = self.centre.clone();
        let (potential, _) = self.field.expand(&centre, &one, 3);
        potential.get(2).is_some_and(Real::is_negative)
    }

    fn below_equilibrium(&mut self) -> PeriodError {
        let centre = self.centre.clone();
        PeriodError::BelowEquilibrium {
            energy: short(self.energy.middle()),
            potential: short(self.field.potential(&centre).middle()),
            maximum: self.is_maximum(),
        }
    }

    fn open(&self, upward: bool, end: Option<f64>) -> PeriodError {
        PeriodError::NotPeriodic {
            coordinate: self.name(),
            upward,
            end: end.map(short),
        }
    }

    /// The error of an amplitude behind a barrier, which is looked for.
    fn blocked(&mut self) -> PeriodError {
        let centre = self.centre.clone();
        let upper = self
            .turning
            .as_ref()
            .map_or_else(|| centre.clone(), |(at, _)| at.clone());
        match self.field.highest(&centre, &upper) {
            Some((summit, height)) => self.beyond_barrier(&summit, &height),
            None => PeriodError::Undecided {
                coordinate: self.name(),
                place: short(upper.middle()),
            },
        }
    }

    fn beyond_barrier(&mut self, summit: &S, height: &S) -> PeriodError {
        let centre = self.centre.clone();
        let bottom = self.field.potential(&centre);
        let amplitude = self
            .turning
            .as_ref()
            .map_or(f64::NAN, |(_, distance)| distance.middle());
        PeriodError::BeyondBarrier {
            amplitude: short(amplitude),
            coordinate: self.name(),
            barrier: short(summit.middle()),
            height: short(height.sub(&bottom).middle()),
            energy: short(self.energy.sub(&bottom).middle()),
        }
    }
}
