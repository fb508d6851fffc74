//! Where a motion starts: values that are given, the rest at the equilibrium; or a mode with an amplitude.

use super::error::MotionError;
use super::{System, table};
use crate::source;
use librate_core::derive;
use librate_core::expr::{ExprId, Pool, Tape};
use librate_core::linearize::{self, LinearizeError, Linearized, Origin, evaluate_closed};
use librate_core::model::{Constant, Given as Stated, Model, entries};
use librate_core::oscillation::NormalModes;
use librate_core::precision::{Ball, Enclosure, Scalar, up};

/// Coordinates and velocities at t = 0, in SI.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Start {
    /// The coordinates. The radius is what a shape is estimated to be off by; 0 for what is given or rests.
    pub positions: Vec<Ball>,
    /// Their velocities.
    pub velocities: Vec<Ball>,
    /// What was moved onto the constraints, within the digits that it is given in.
    pub moved: Vec<Moved>,
    /// What is proved of the coordinates, then of the velocities.
    pub(super) known: Vec<Known>,
}

/// A value that was moved onto the constraints.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Moved {
    /// The number of the coordinate.
    pub coordinate: usize,
    /// Whether it is its velocity.
    pub velocity: bool,
    /// By how much, in SI.
    pub by: f64,
    /// Whether the digits that it is given in leave as much.
    pub rounded: bool,
}

/// Decimals of so many digits are results of another program.
const COMPUTED: usize = 10;

/// What is proved of a value.
#[derive(Clone, Debug)]
pub(super) enum Known {
    /// It is a constant, in a unit that is worth another.
    Constant(Tape, Option<Tape>),
    /// It lies within bounds.
    Within(Ball),
    /// Nothing.
    Open,
}

impl Known {
    /// A constant that may be evaluated to any number of digits.
    fn constant(pool: &Pool, value: ExprId) -> Self {
        Tape::compile(pool, &[value], &[]).map_or(Self::Open, |tape| Self::Constant(tape, None))
    }

    pub(super) fn enclosed<S: Enclosure>(&self, precision: S::Precision) -> Option<S> {
        match self {
            Self::Constant(value, factor) => {
                let value = evaluated::<S>(value, precision)?;
                match factor {
                    Some(factor) => Some(value.mul(&evaluated(factor, precision)?)),
                    None => Some(value),
                }
            }
            Self::Within(ball) => Some(S::from_ball(ball, precision)),
            Self::Open => None,
        }
        .filter(S::is_finite)
    }

    fn moved(&self, by: &Ball) -> Self {
        match self.enclosed::<Ball>(()) {
            Some(own) if by.is_finite() => Self::Within(own + *by),
            _ => Self::Open,
        }
    }
}

/// What a tape of one closed expression comes to.
pub(super) fn evaluated<S: Enclosure>(tape: &Tape, precision: S::Precision) -> Option<S> {
    tape.prepare::<S>(precision).evaluate(&[], &mut Vec::new()).into_iter().next()
}

/// One value that is given: which coordinate, whether it is the velocity, and what.
pub(super) struct Given {
    pub(super) coordinate: usize,
    pub(super) moves: bool,
    value: Ball,
    known: Known,
    /// Half a unit of the last digit of a decimal fraction, in SI; none for anything else, which is exact.
    pub(super) half_unit: Option<f64>,
    /// Whether it comes from another program, as digits that nobody types tell.
    pub(super) computed: bool,
}

impl Start {
    /// Reads `phi[1]=0.1, phi[1]'=0`: numbers are in the coordinate's unit, that of a velocity per second. What is left out rests at
    /// the equilibrium, or turns with a steady motion; under constraints coordinates that are left out are moved there from the
    /// equilibrium so that these hold, and where that does not do, decimal fractions by up to half a unit of their last digit, and
    /// those that have as many digits as doubles by a thousandth of the largest value. A model without an equilibrium starts from 0, and one that is driven from its `equilibrium` or
    /// `guess`.
    ///
    /// # Errors
    /// What can't be read, is no coordinate, or does not obey the constraints.
    pub fn parse(
        text: &str,
        model: &Model,
        linearized: Option<&Linearized>,
        system: &System,
    ) -> Result<Self, MotionError> {
        let mut given: Vec<Given> = Vec::new();
        for entry in entries(text) {
            let value = read(entry, model)?;
            let same = |own: &Given| (own.coordinate, own.moves) == (value.coordinate, value.moves);
            if given.iter().any(same) {
                return Err(MotionError::BadStart {
                    text: entry.trim().to_owned(),
                    reason: "it is given twice".to_owned(),
                });
            }
            given.push(value);
        }
        Self::of(&given, model, linearized, system)
    }

    /// A start for each row of a CSV text, whose columns are coordinates (`phi[1]`) and velocities (`phi[1]'`); each as [`Start::parse`]
    /// has it, with decimals in the units of the coordinates.
    ///
    /// # Errors
    /// What is no table of numbers, columns that are no coordinates, and rows that do not obey the constraints, with their lines.
    pub fn table(
        text: &str,
        model: &Model,
        linearized: Option<&Linearized>,
        system: &System,
    ) -> Result<Vec<Result<Self, MotionError>>, MotionError> {
        let table = table::read(text)?;
        let places: Vec<(usize, bool)> =
            table.columns.iter().map(|column| place(column, model)).collect::<Result<_, _>>()?;
        let given = |row: usize| -> Result<Vec<Given>, MotionError> {
            let given = places.iter().enumerate().map(|(column, (at, moves))| {
                let number = table::number(&table, row, column)?;
                let bad = |reason: &str| table::bad(&table, row, reason.to_owned());
                let value = Constant::parse(&number.to_string()).map_err(|error| bad(&error.to_string()))?;
                let value = given(*at, *moves, &value, model).ok_or_else(|| bad("a number is larger than 1e298"))?;
                Ok(Given { half_unit: (!number.is_integer()).then_some(0.0), computed: true, ..value })
            });
            given.collect()
        };
        let given = (1..=table.rows()).map(given).collect::<Result<Vec<_>, _>>()?;
        Ok(given.iter().map(|given| Self::of(given, model, linearized, system)).collect())
    }

    fn of(
        given: &[Given],
        model: &Model,
        linearized: Option<&Linearized>,
        system: &System,
    ) -> Result<Self, MotionError> {
        let mut start = Self::at_rest(model, linearized);
        for own in given {
            let (state, known) = start.parts(own.moves);
            state[own.coordinate] = own.value;
            known[own.coordinate].clone_from(&own.known);
        }
        start.onto_constraints(system, given, &held(model, linearized))?;
        Ok(start)
    }

    /// The model about its equilibrium, for a start there, or of the coordinates whose velocities are independent where these alone have
    /// one; a motion needs none: where there is none it is `None`, unless it is `needed`.
    ///
    /// # Errors
    /// Those of [`derive::linearized`] that leave nothing to start from, and coordinates without inertia.
    pub fn linearized(model: &Model, needed: bool) -> Result<Option<Linearized>, LinearizeError> {
        match derive::linearized(model.clone()) {
            Ok(linearized) => linearized.check_inertia().map(|()| Some(linearized)),
            Err(
                error @ (LinearizeError::MissingValue { .. }
                | LinearizeError::NotAnEquilibrium { .. }
                | LinearizeError::ConstraintBroken { .. }),
            ) => Err(error),
            Err(error) if needed => Err(error),
            Err(_) => Ok(None),
        }
    }

    /// A mode by its number from 1, displaced so that its largest component is the amplitude (in the unit of that coordinate), at rest
    /// but for what the mode itself moves.
    ///
    /// # Errors
    /// A mode or an amplitude that is none.
    pub fn mode(
        number: usize,
        amplitude: &Constant,
        model: &Model,
        (linearized, modes): (&Linearized, &NormalModes),
        system: &System,
    ) -> Result<Self, MotionError> {
        let places = places(model, linearized);
        let mut start = Self::at_rest(model, Some(linearized));
        let count = modes.modes.len();
        let none = MotionError::NoSuchMode { mode: number, count };
        let mode = number.checked_sub(1).and_then(|at| modes.modes.get(at));
        let mode = mode.filter(|mode| !mode.vector.is_empty()).ok_or(none)?;
        let value = linearize::constant(amplitude.pool(), amplitude.value()).filter(Ball::is_finite);
        let value = value.ok_or_else(|| MotionError::BadAmplitude { text: amplitude.text().to_owned() })?;
        let zeros = vec![0.0; mode.vector.len()];
        let imaginary = match mode.imaginary.as_slice() {
            [] => &zeros,
            own => own,
        };
        // The one that is positive in the shapes of `modes`.
        let largest = mode.leading().unwrap_or(0);
        let value = scaled(linearized.model(), largest, &value);
        // Turned so that the largest component is real: it is displaced by the amplitude.
        let (re, im) = (mode.vector[largest], imaginary[largest]);
        let square = re.hypot(im).powi(2);
        // Components are off by d, d' with |d|, |d'| <= b, where b is the bound of both parts: (a + d)/(z + d') differs from
        // a/z by at most (|d| + |a/z| |d'|)/(|z| - |d'|), and |a| <= |z|. The quotient in doubles adds some roundings.
        let bound = 1.5 * mode.vector_error_bound;
        let off = up(2.0 * bound / (square.sqrt() * (1.0 - 4.0 * f64::EPSILON) - bound)) + 16.0 * f64::EPSILON;
        // Vectors of several modes of one frequency are known only together.
        let alone = modes.modes.iter().filter(|own| own.cluster == mode.cluster).count() == 1;
        // What the bound does not tell from 0 or from the largest component is taken to be that, as symmetry makes it
        // mostly.
        let known = |x: f64| {
            let mut near = [0.0, 1.0, -1.0].into_iter().filter(|whole| (x - whole).abs() <= 2.0 * off);
            near.next().map_or((x, off), |near| (near, 0.0))
        };
        let n = model.coordinates.len();
        // A mode in phase starts where it turns.
        let in_phase = mode.imaginary.is_empty() && mode.omega.mid_f64() != 0.0;
        for (component, (a, b)) in mode.vector.iter().zip(imaginary).enumerate() {
            let Some(at) = places.get(component).copied() else { continue };
            let ((real, real_off), (rest, rest_off)) = if component == largest {
                ((1.0, 0.0), (0.0, 0.0))
            } else {
                (known((a * re + b * im) / square), known((b * re - a * im) / square))
            };
            let part = |x: f64, off: f64| Ball::exact(x).with_added_radius(off);
            // Of the values as they are used, with what is estimated of them; and as they are proved.
            let proved = |x: f64| part(x, if component == largest { 0.0 } else { 4.0 * off });
            let moved = value.mul(&part(real, real_off));
            let x = &mut start.positions[at];
            *x = Ball::new(x.add(&moved).mid, moved.radius * f64::from(u8::from(real_off > 0.0)));
            // The rate of Re(z exp((growth + i omega) t)).
            let rate = |real: Ball, rest: Ball| mode.growth * real - mode.omega * rest;
            if !in_phase {
                let own = value.mul(&rate(part(real, real_off), part(rest, rest_off)));
                let v = &mut start.velocities[at];
                let estimated = real_off > 0.0 || rest_off > 0.0;
                *v = Ball::new(v.add(&own).mid, own.radius * f64::from(u8::from(estimated)));
            }
            if alone {
                start.known[at] = start.known[at].moved(&value.mul(&proved(real)));
                if !in_phase {
                    let rate = value.mul(&rate(proved(real), proved(rest)));
                    start.known[n + at] = start.known[n + at].moved(&rate);
                }
            } else {
                start.known[at] = Known::Open;
            }
        }
        let coordinate = places.get(largest).copied().unwrap_or_default();
        let (value, known) = (start.positions[coordinate], start.known[coordinate].clone());
        let displaced = Given { coordinate, moves: false, value, known, half_unit: None, computed: false };
        let held = held(model, Some(linearized));
        start.onto_constraints(system, &[displaced], &held).map_err(|_| {
            let name = model.coordinates.at(coordinate).name();
            let reason =
                format!("no point with `{name}` displaced by {} was found; try a smaller one", amplitude.text());
            MotionError::OffConstraints { reason }
        })?;
        Ok(start)
    }

    /// At the equilibrium, or in the steady motion, as far as these are known.
    fn at_rest(model: &Model, linearized: Option<&Linearized>) -> Self {
        // What may be 0 is: a middle beside it would be a number with digits.
        let centre = |value: &Ball| if value.contains_zero() { Ball::ZERO } else { Ball::new(value.mid, 0.0) };
        let n = model.coordinates.len();
        let stated = |given: Option<Stated>| match given.and_then(|given| given.value) {
            Some(value) => {
                let middle = linearize::constant(&model.pool, value);
                (middle.as_ref().map_or(Ball::ZERO, centre), Known::constant(&model.pool, value))
            }
            None => (Ball::ZERO, Known::Within(Ball::ZERO)),
        };
        let given = model.equilibria.iter().zip(model.guesses.iter());
        let places = given.map(|(equilibrium, guess)| stated(equilibrium.or(guess)));
        let (positions, mut known): (Vec<Ball>, Vec<Known>) = places.unzip();
        let (velocities, moving): (Vec<Ball>, Vec<Known>) = model.rates.iter().map(stated).unzip();
        known.extend(moving);
        let mut start = Self { positions, velocities, moved: Vec::new(), known };
        let Some(linearized) = linearized else { return start };
        let (equilibrium, rates) = (linearized.equilibrium(), linearized.rates());
        for (own, at) in self::places(model, linearized).into_iter().enumerate() {
            start.positions[at] = centre(&equilibrium.values[own]);
            start.known[at] = match equilibrium.origins.get(own) {
                Some(Origin::Given) => {
                    let value = model.equilibria.get(at).and_then(|given| given.value);
                    value.map_or(Known::Open, |value| Known::constant(&model.pool, value))
                }
                Some(Origin::Zero) => Known::Within(Ball::ZERO),
                Some(Origin::Found) if equilibrium.proved => Known::Within(equilibrium.values[own]),
                Some(Origin::Found) | None => Known::Open,
            };
            start.velocities[at] = centre(&rates[own]);
            start.known[n + at] = Known::Within(rates[own]);
        }
        start
    }

    /// Enclosures of the coordinates, then of the velocities.
    ///
    /// # Errors
    /// [`MotionError::OpenStart`] where nothing is proved of one.
    pub(super) fn enclosed<S: Enclosure>(&self, precision: S::Precision) -> Result<Vec<S>, MotionError> {
        let values: Option<Vec<S>> = self.known.iter().map(|own| own.enclosed::<S>(precision)).collect();
        values.ok_or(MotionError::OpenStart {})
    }

    /// Whether all values may be had to any number of digits.
    pub(super) fn is_exact(&self) -> bool {
        self.known.iter().all(|own| match own {
            Known::Constant(..) => true,
            Known::Within(ball) => ball.is_exact(),
            Known::Open => false,
        })
    }
}

/// The places in a model of the coordinates that are left of it.
fn places(model: &Model, linearized: &Linearized) -> Vec<usize> {
    let own = linearized.model().coordinates.names();
    let place = |name: String| model.coordinates.names().position(|other| other == name);
    if linearized.coordinates() == model.coordinates.len() {
        (0..model.coordinates.len()).collect()
    } else {
        own.filter_map(place).collect()
    }
}

/// The coordinates whose velocities the others follow, where these alone have an equilibrium or steady motion.
fn held(model: &Model, linearized: Option<&Linearized>) -> Vec<usize> {
    let reduced = linearized.filter(|own| own.coordinates() < model.coordinates.len());
    reduced.map_or_else(Vec::new, |own| places(model, own))
}

/// `phi[1]'=0.1`
fn read(entry: &str, model: &Model) -> Result<Given, MotionError> {
    let bad = |reason: &str| MotionError::BadStart { text: entry.trim().to_owned(), reason: reason.to_owned() };
    let (name, value) = entry.split_once('=').ok_or_else(|| bad("there is no `=`"))?;
    let (at, moves) = place(name, model)?;
    let value = Constant::read(value.trim()).map_err(|reason| match value.contains(['=', ';']) {
        true => bad("several values are separated by commas"),
        false => bad(&reason),
    })?;
    let text = value.text().to_owned();
    let half_unit = half_unit(&text);
    let value = given(at, moves, &value, model).ok_or_else(|| bad("it is not a number, or larger than 1e298"))?;
    let half_unit = half_unit.map(|own| scaled(model, at, &Ball::exact(own)).mid_f64().abs());
    let digits = text.bytes().filter(u8::is_ascii_digit).count();
    Ok(Given { half_unit, computed: half_unit.is_some() && digits >= COMPUTED, ..value })
}

/// The coordinate of a name, and whether the name has the prime of its velocity.
fn place(name: &str, model: &Model) -> Result<(usize, bool), MotionError> {
    // Indices as names of coordinates have them.
    let name: String = name.split_whitespace().collect();
    let (plain, moves) = name.strip_suffix('\'').map_or_else(|| (name.as_str(), false), |plain| (plain, true));
    if plain.ends_with('\'') {
        let reason = "accelerations follow from the equations of motion".to_owned();
        return Err(MotionError::BadStart { text: name, reason });
    }
    match source::coordinate(model, plain) {
        Ok(at) => Ok((at, moves)),
        Err(nearest) => {
            // A family is given by its members.
            let mut members =
                model.coordinates.names().filter(|own| own.split_once('[').is_some_and(|(own, _)| own == plain));
            let member = members.next().map(|own| if moves { format!("{own}'") } else { own });
            Err(MotionError::NotACoordinate { nearest: member.or(nearest), name })
        }
    }
}

/// A value in the unit of its coordinate; `None` where it is no number.
fn given(at: usize, moves: bool, value: &Constant, model: &Model) -> Option<Given> {
    let number = linearize::constant(value.pool(), value.value()).filter(Ball::is_finite)?;
    let factor = model.coordinates.get(at).and_then(|own| own.factor);
    let factor = factor.map(|factor| Known::constant(&model.pool, factor));
    let known = match (Known::constant(value.pool(), value.value()), factor) {
        (Known::Constant(value, _), Some(Known::Constant(factor, _))) => Known::Constant(value, Some(factor)),
        (known, None) => known,
        (_, Some(_)) => Known::Open,
    };
    let number = scaled(model, at, &number);
    Some(Given { coordinate: at, moves, value: Ball::new(number.mid, 0.0), known, half_unit: None, computed: false })
}

/// Half a unit of the last digit of a decimal fraction, `-0.866` or `8.66e-1`; `None` for anything else.
fn half_unit(text: &str) -> Option<f64> {
    let text = text.trim().trim_start_matches('-').trim_start();
    let (digits, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let exponent = exponent.parse::<i32>().ok()?;
    let (whole, fraction) = digits.split_once('.')?;
    let is_digit = |c: char| c.is_ascii_digit();
    if !whole.chars().all(is_digit) || !fraction.chars().all(is_digit) {
        return None;
    }
    let places = exponent.checked_sub(i32::try_from(fraction.len()).ok()?)?;
    Some(0.5 * 10.0_f64.powi(places))
}

/// From the coordinate's unit to SI.
fn scaled(model: &Model, coordinate: usize, value: &Ball) -> Ball {
    let factor = model.coordinates.get(coordinate).and_then(|own| own.factor);
    let factor = factor.and_then(|factor| evaluate_closed::<Ball>(&model.pool, factor, ()));
    factor.map_or(*value, |factor| value.mul(&factor))
}
