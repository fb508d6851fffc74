//! From a request to a period, with as many bits as it takes, and what is to be said where bits do not help.

use super::barrier::Height;
use super::panel::Field;
use super::small::small;
use super::task::{Course, Found, Stop, Task};
use super::{Motion, Options, Oscillator, Period, PeriodError, Request};
use librate_core::linearize::short;
use librate_core::precision::{Ball, Big, Enclosure, Magnitude, Rounding, Scalar, decimal};

/// The rest that is asked for at least: the period is then known better than doubles tell.
const LEAST_BITS: u32 = 62;

/// Doubled doubles do for so many bits, with room for what cancels.
const BITS_OF_BALLS: u32 = 86;

/// With so many bits what is too rough for expansions is not smooth.
const ROUGH_BITS: usize = 800;

/// Numbers of more bits than these are not tried.
const MOST_BITS: usize = 4096;

/// Results are given as doubles too: numbers smaller or larger than these are not followed.
const LEAST_SIZE: f64 = 1e-280;
const MOST_SIZE: f64 = 1e280;

const OUT_OF_RANGE: &str =
    "a motion with such numbers is beyond the range of double precision; other units bring it back";

/// What a barrier is examined with.
const BITS_OF_BARRIERS: usize = 1024;

/// What one is searched for with, at hundreds of places.
const BITS_OF_PLACES: usize = 192;

/// An energy nearer to the height of a barrier than this, relative to the height of the motion, counts as at the
/// barrier where the integral fails.
const AT_BARRIER: f64 = 1e-30;

/// An inertia that is smaller than this on the top of a barrier, relative to that at the equilibrium, counts as none where
/// the integral fails there.
const VANISHING: f64 = 1e-12;

/// The motion that is asked for.
pub(super) fn period(oscillator: &Oscillator, request: &Request, options: &Options) -> Result<Period, PeriodError> {
    check_request(oscillator, request)?;
    let wanted = (options.digits as f64 * std::f64::consts::LOG2_10).ceil() as u32 + 14;
    let mut bits = wanted.max(LEAST_BITS);
    let place = oscillator.center.position();
    let mut fence = None;
    // Numbers far from usual ones leave the range of balls on their way.
    if bits <= BITS_OF_BALLS && oscillator.center.units().is_none() {
        let mut task = Task::<Ball>::new(oscillator, request, (), place, bits, None);
        match task.run() {
            Ok(found) if decimal(&found.period, options.digits).rounding == Rounding::Correct => {
                return finished(oscillator, request, task, found);
            }
            // More bits take more terms a panel and as many panels.
            Err(Stop::Final(error @ PeriodError::TooLong { .. })) => return Err(error),
            // Their range is that of doubles: what they find nothing for, more bits may.
            Ok(_) | Err(Stop::Final(_) | Stop::AtRest) => {}
            Err(Stop::Precision(at)) => fence = look(oscillator, request, &at, false).unwrap_or_default(),
            Err(Stop::Rough(at)) => fence = look(oscillator, request, &at, true).unwrap_or_default(),
        }
    }
    let mut precision = (bits as usize + 64).next_multiple_of(64);
    let mut attempts = 0;
    loop {
        attempts += 1;
        oscillator.model().pool.budget().check()?;
        let centre = oscillator.position(precision);
        let mut task = Task::<Big>::new(oscillator, request, precision, centre, bits, fence.as_ref());
        match task.run() {
            Ok(found) => {
                let complete = found.period.decimal(options.digits).rounding == Rounding::Correct;
                if complete || attempts > 6 {
                    return finished(oscillator, request, task, found);
                }
                bits += 40;
                precision += 64;
            }
            Err(Stop::Final(error)) => return Err(error),
            Err(Stop::AtRest) if precision * 2 > MOST_BITS => {
                return Err(task.below_equilibrium());
            }
            Err(Stop::AtRest) => precision *= 2,
            Err(ref stop @ (Stop::Precision(ref at) | Stop::Rough(ref at))) => {
                let found = match look(oscillator, request, at, matches!(stop, Stop::Rough(_))) {
                    // What is lost where terms cancel looks rough as well.
                    Err(PeriodError::NotSmooth { .. }) if precision < ROUGH_BITS => None,
                    other => other?,
                };
                // A barrier that was not known is a way on; else it takes more bits.
                if found.is_none() || fence.is_some() {
                    precision *= 2;
                }
                fence = fence.or(found);
                if attempts > 12 || precision > MOST_BITS {
                    return Err(PeriodError::Undecided {
                        coordinate: oscillator.coordinate().name(),
                        place: oscillator.place(at.mid_f64()),
                    });
                }
            }
        }
    }
}

/// Small oscillations and the change of their frequency, where the equilibrium is known.
fn small_about<S: Enclosure>(oscillator: &Oscillator, field: &mut Field<S>, at: &S) -> (Option<S>, Option<S>) {
    let center = &oscillator.center;
    if !center.is_proved() || center.is_corner() {
        return (None, None);
    }
    let energy = field.potential(at);
    field.set_energy(energy);
    if field.is_smooth_at(at) {
        let (small, bend) = small(field, at);
        return (small, bend.filter(|_| !oscillator.stretched));
    }
    // Half of a period on each side; where a derivative jumps the change is no even function of the amplitude.
    let mut half = |side: f64| {
        let way = field.free_way(at, side)?;
        field.hold(at, &way);
        let (small, _) = small(field, at);
        field.release();
        Some(small?.mul(&field.number(0.5)))
    };
    let halves = [half(-1.0), half(1.0)];
    let [Some(before), Some(behind)] = halves else { return (None, None) };
    (Some(before.add(&behind)), None)
}

/// What is asked for, and how it was put in.
fn asked(request: &Request) -> (&'static str, &str) {
    match request {
        Request::Amplitude(constant) => ("the amplitude", constant.text()),
        Request::Energy(constant) => ("the energy", constant.text()),
    }
}

/// Refuses energies that doubles do not hold.
fn check_range<S: Enclosure>(request: &Request, found: &Found<S>) -> Result<(), PeriodError> {
    let (least, most) = (found.energy.abs_lower_magnitude(), found.energy.abs_upper_magnitude());
    let too_small = !least.is_zero() && most < Magnitude::from_f64(LEAST_SIZE);
    if !(too_small || most > Magnitude::from_f64(MOST_SIZE)) {
        return Ok(());
    }
    let (what, text) = asked(request);
    Err(PeriodError::BadRequest { what, value: text.to_owned(), reason: OUT_OF_RANGE })
}

fn check_request(oscillator: &Oscillator, request: &Request) -> Result<(), PeriodError> {
    let value = oscillator.value::<Big>(request, BITS_OF_BARRIERS);
    let (what, text) = asked(request);
    let within = (LEAST_SIZE..MOST_SIZE).contains(&value.mid_f64().abs());
    let bad = |reason| {
        Err(PeriodError::BadRequest {
            what,
            value: if (within || value.is_zero()) && oscillator.center.units().is_none() {
                short(value.mid_f64())
            } else {
                text.to_owned()
            },
            reason,
        })
    };
    if !value.is_finite() {
        return bad("it is not a finite number");
    }
    if !(within || value.is_zero()) {
        return bad(OUT_OF_RANGE);
    }
    let amplitude = matches!(request, Request::Amplitude(_));
    if amplitude && (value.is_zero() || value.is_negative()) {
        return bad("an amplitude is the distance to the upper turning point, which is positive");
    }
    Ok(())
}

fn finished<S: Enclosure>(
    oscillator: &Oscillator,
    request: &Request,
    mut task: Task<S>,
    found: Found<S>,
) -> Result<Period, PeriodError> {
    let (small, bend) = small_about(oscillator, &mut task.field, &task.centre);
    check_range(request, &found)?;
    let (motion, places) = match found.course {
        Course::Libration(turning) => {
            (Motion::Libration { turning: turning.each_ref().map(Enclosure::to_ball) }, turning.to_vec())
        }
        Course::Rotation(advance) => (Motion::Rotation { advance: advance.to_ball() }, vec![advance]),
    };
    Ok(Period {
        period: found.period.to_ball(),
        precise: found.period.precise(),
        motion,
        motion_precise: places.into_iter().filter_map(Enclosure::precise).collect(),
        energy: found.energy.to_ball(),
        energy_precise: match oscillator.center.units() {
            Some(_) => Some(found.energy.to_big(BITS_OF_BARRIERS)),
            None => found.energy.precise(),
        },
        equilibrium: task.centre.to_ball(),
        equilibrium_precise: task.centre.precise(),
        proved: oscillator.center.is_proved(),
        corner: oscillator.center.is_corner(),
        small: small.as_ref().map(Enclosure::to_ball),
        small_precise: small.and_then(Enclosure::precise),
        bend: bend.as_ref().map(Enclosure::to_ball),
    })
}

fn not_smooth<S: Enclosure>(oscillator: &Oscillator, at: &S) -> PeriodError {
    PeriodError::NotSmooth { coordinate: oscillator.coordinate().name(), place: oscillator.place(at.mid_f64()) }
}

/// What is to be said about a place where an integral failed: nothing yet, that there is a barrier (where E - U is negative), or an
/// error. Where it failed because of panels that get too small (`rough`), a barrier that is nearly touched is the reason.
fn look<S: Enclosure>(
    oscillator: &Oscillator,
    request: &Request,
    at: &S,
    rough: bool,
) -> Result<Option<Big>, PeriodError> {
    let bits = BITS_OF_BARRIERS;
    let at = at.to_big(bits);
    let task_of = |bits| Task::<Big>::new(oscillator, request, bits, oscillator.position(bits), 256, None);
    let mut task = task_of(bits);
    let unknown = || if rough { Err(not_smooth(oscillator, &at)) } else { Ok(None) };
    // Where no top is near, a barrier may still be in the way of a turning point that is asked for.
    let unless_between = || match task_of(BITS_OF_PLACES).barrier_between() {
        Some(error) if rough => Err(error),
        Some(_) | None => unknown(),
    };
    let reach = at.sub(&task.centre).mid_f64().abs();
    let Some((summit, height)) = task.field.summit(&at, reach) else { return unless_between() };
    let one = task.field.number(1.0);
    let (potential, mass) = task.field.expand(&summit, &one, 3);
    if !potential.get(2).is_some_and(Enclosure::is_negative) {
        return unless_between();
    }
    let centre = task.centre.clone();
    let (_, own) = task.field.expand(&centre, &one, 1);
    if let (Some(there), Some(here)) = (mass.first(), own.first())
        && there.abs_upper_magnitude() < here.abs_upper_magnitude() * Magnitude::from_f64(VANISHING)
    {
        // As at the cusps of a cycloid: no time is spent on the top, and no expansion passes it.
        return Err(not_smooth(oscillator, &summit));
    }
    let excess = task.field.energy.sub(&height);
    let depth = height.sub(&task.field.potential(&task.centre)).abs_upper_magnitude();
    let small = depth * Magnitude::from_f64(AT_BARRIER);
    let undecided = !(excess.is_positive() || excess.is_negative());
    if undecided || rough && excess.abs_upper_magnitude() <= small {
        return Err(PeriodError::AtBarrier {
            coordinate: oscillator.coordinate().name(),
            barrier: oscillator.place(summit.mid_f64()),
            margin: oscillator.margin(excess.abs_upper_magnitude()),
            height: oscillator.height(height.mid_f64()),
        });
    }
    if excess.is_negative() {
        let Some((upper, _)) = task.turning.clone() else { return Ok(Some(summit)) };
        if summit.sub(&upper).is_positive() {
            // The barrier that the motion turns before.
            return unknown();
        }
        return if summit.sub(&task.centre).is_negative() {
            Ok(Some(summit))
        } else {
            Err(task.beyond_barrier(&summit, &Height { at: height, is_top: true }))
        };
    }
    unknown()
}
