//! Where a motion starts: values that are given, the rest at the equilibrium; or a mode with an amplitude.

use nalgebra::{DMatrix, DVector};

use super::System;
use super::error::MotionError;
use crate::diagnostic::nearest;
use crate::expr::{ExprId, Pool, Tape};
use crate::flow::Enclosure;
use crate::linearize::{self, Linearized, Origin, evaluate_closed};
use crate::model::{Constant, Model, ModelError};
use crate::oscillation::NormalModes;
use crate::precision::{Ball, Scalar, up};

/// Newton steps to the constraints.
const MOST_STEPS: usize = 60;

/// Coordinates and velocities at t = 0, in SI.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Start {
    /// The coordinates. The radius is what a shape is estimated to be off by; 0 for what is given or rests.
    pub positions: Vec<Ball>,
    /// Their velocities.
    pub velocities: Vec<Ball>,
    /// What is proved of the coordinates, then of the velocities.
    known: Vec<Known>,
}

/// What is proved of a value.
#[derive(Clone, Debug)]
enum Known {
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
        match Tape::compile(pool, &[value], &[]) {
            Ok(tape) => Self::Constant(tape, None),
            Err(_) => Self::Open,
        }
    }

    fn enclosed<S: Enclosure>(&self, precision: S::Precision) -> Option<S> {
        match self {
            Self::Constant(value, factor) => {
                let value = evaluated::<S>(value, precision)?;
                let factor = factor.as_ref().map(|own| evaluated::<S>(own, precision));
                Some(match factor {
                    Some(factor) => value.mul(&factor?),
                    None => value,
                })
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
    let values = tape.prepare::<S>(precision).evaluate(&[], &mut Vec::new());
    values.into_iter().next()
}

/// One value that is given: which coordinate, whether it is the velocity, and what.
struct Given {
    coordinate: usize,
    moves: bool,
    value: Ball,
    known: Known,
}

impl Start {
    /// Reads `phi[1]=0.1, phi[1]'=0`: numbers are in the coordinate's unit, that of a velocity per second. What is left out rests at
    /// the equilibrium, or turns with a steady motion; under constraints coordinates that are left out are moved there from the
    /// equilibrium so that these hold. A model without an equilibrium starts from 0, and one that is driven from its `equilibrium` or
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
        let mut start = Self::at_rest(model, linearized);
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
        let n = model.coordinates.len();
        for own in &given {
            let at = own.coordinate;
            if own.moves {
                start.velocities[at] = own.value;
                start.known[n + at] = own.known.clone();
            } else {
                start.positions[at] = own.value;
                start.known[at] = own.known.clone();
            }
        }
        start.onto_constraints(system, &given)?;
        Ok(start)
    }

    /// A mode by its number from 1, displaced so that its largest component is the amplitude (in the unit of that coordinate), at rest
    /// but for what the mode itself moves.
    ///
    /// # Errors
    /// A mode or an amplitude that is none.
    pub fn mode(
        number: usize,
        amplitude: &Constant,
        linearized: &Linearized,
        modes: &NormalModes,
        system: &System,
    ) -> Result<Self, MotionError> {
        let model = linearized.model();
        let mut start = Self::at_rest(model, Some(linearized));
        let count = modes.modes.len();
        let none = MotionError::NoSuchMode {
            mode: number,
            count,
        };
        let mode = number.checked_sub(1).and_then(|at| modes.modes.get(at));
        let mode = mode.filter(|mode| !mode.vector.is_empty()).ok_or(none)?;
        let value = linearize::constant(amplitude.pool(), amplitude.value());
        let value = value.filter(Ball::is_finite);
        let value = value.ok_or_else(|| MotionError::BadAmplitude {
            text: amplitude.text().to_owned(),
        })?;
        let zeros = vec![0.0; mode.vector.len()];
        let imaginary = match mode.imaginary.as_slice() {
            [] => &zeros,
            own => own,
        };
        let size = |at: &usize| mode.vector[*at].hypot(imaginary[*at]);
        let largest = (0..mode.vector.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
        let largest = largest.unwrap_or(0);
        let value = scaled(model, largest, &value);
        // Turned so that the largest component is real: it is displaced by the amplitude.
        let (re, im) = (mode.vector[largest], imaginary[largest]);
        let square = re.hypot(im).powi(2);
        // Components are off by d, d' with |d|, |d'| <= b, where b is the bound of both parts: (a + d)/(z + d') differs from
        // a/z by at most (|d| + |a/z| |d'|)/(|z| - |d'|), and |a| <= |z|. The quotient in doubles adds some roundings.
        let bound = 1.5 * mode.vector_error_bound;
        let off = up(2.0 * bound / (square.sqrt() * (1.0 - 4.0 * f64::EPSILON) - bound))
            + 16.0 * f64::EPSILON;
        // Vectors of several modes of one frequency are known only together.
        let alone = modes
            .modes
            .iter()
            .filter(|own| own.cluster == mode.cluster)
            .count()
            == 1;
        // What the bound does not tell from 0 or from the largest component is taken to be that, as symmetry makes it
        // mostly.
        let known = |x: f64| {
            let near = [0.0, 1.0, -1.0].into_iter();
            let mut near = near.filter(|whole| (x - whole).abs() <= 2.0 * off);
            near.next().map_or((x, off), |near| (near, 0.0))
        };
        let n = mode.vector.len();
        // A mode in phase starts where it turns.
        let in_phase = mode.imaginary.is_empty() && mode.omega.mid_f64() != 0.0;
        for (at, (a, b)) in mode.vector.iter().zip(imaginary).enumerate() {
            let ((real, real_off), (rest, rest_off)) = if at == largest {
                ((1.0, 0.0), (0.0, 0.0))
            } else {
                (
                    known((a * re + b * im) / square),
                    known((b * re - a * im) / square),
                )
            };
            let part = |x: f64, off: f64| Ball::exact(x).with_added_radius(off);
            // Of the values as they are used, with what is estimated of them; and as they are proved.
            let proved = |x: f64| part(x, if at == largest { 0.0 } else { 4.0 * off });
            let moved = value.mul(&part(real, real_off));
            let x = &mut start.positions[at];
            *x = Ball::new(
                x.add(&moved).mid,
                moved.radius * f64::from(u8::from(real_off > 0.0)),
            );
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
        start.onto_constraints(system, &[])?;
        Ok(start)
    }

    fn at_rest(model: &Model, linearized: Option<&Linearized>) -> Self {
        let centre = |value: &Ball| Ball::new(value.mid, 0.0);
        let n = model.coordinates.len();
        if let Some(linearized) = linearized {
            let equilibrium = linearized.equilibrium();
            let rates = linearized.rates();
            let place = |at: usize| match equilibrium.origins.get(at) {
                Some(Origin::Given) => {
                    let given = model.equilibria.get(at).copied().flatten();
                    let value = given.and_then(|given| given.value);
                    value.map_or(Known::Open, |value| Known::constant(&model.pool, value))
                }
                Some(Origin::Zero) => Known::Within(Ball::ZERO),
                Some(Origin::Found) if equilibrium.proved => Known::Within(equilibrium.values[at]),
                Some(Origin::Found) | None => Known::Open,
            };
            let moving = rates.iter().map(|rate| Known::Within(*rate));
            return Self {
                positions: equilibrium.values.iter().map(centre).collect(),
                velocities: rates.iter().map(centre).collect(),
                known: (0..n).map(place).chain(moving).collect(),
            };
        }
        let given = model.equilibria.iter().zip(&model.guesses);
        let given =
            given.map(|(equilibrium, guess)| equilibrium.or(*guess).and_then(|given| given.value));
        let given: Vec<Option<ExprId>> = given.collect();
        let positions = given.iter().map(|value| {
            let value = value.and_then(|value| linearize::constant(&model.pool, value));
            value.as_ref().map_or(Ball::ZERO, centre)
        });
        let known = given.iter().map(|value| match value {
            Some(value) => Known::constant(&model.pool, *value),
            None => Known::Within(Ball::ZERO),
        });
        let resting = (0..n).map(|_| Known::Within(Ball::ZERO));
        Self {
            positions: positions.collect(),
            velocities: vec![Ball::ZERO; n],
            known: known.chain(resting).collect(),
        }
    }

    /// Enclosures of the coordinates, then of the velocities.
    ///
    /// # Errors
    /// [`MotionError::OpenStart`] where nothing is proved of one.
    pub(super) fn enclosed<S: Enclosure>(
        &self,
        precision: S::Precision,
    ) -> Result<Vec<S>, MotionError> {
        let values = self.known.iter().map(|own| own.enclosed::<S>(precision));
        let values: Option<Vec<S>> = values.collect();
        values.ok_or(MotionError::OpenStart)
    }

    /// Whether all values may be had to any number of digits.
    pub(super) fn is_exact(&self) -> bool {
        self.known.iter().all(|own| match own {
            Known::Constant(..) => true,
            Known::Within(ball) => ball.is_exact(),
            Known::Open => false,
        })
    }

    /// Moves what is not given so that constraints hold, by Newton steps of least length.
    fn onto_constraints(&mut self, system: &System, given: &[Given]) -> Result<(), MotionError> {
        let equations = &system.equations;
        let (n, c) = (equations.coordinates, equations.constraints);
        if c == 0 {
            return Ok(());
        }
        let surface = equations.surface.prepare::<Ball>(());
        let tape = equations.tape.prepare::<Ball>(());
        let kinks = equations.kinks.prepare::<Ball>(());
        let first = equations.mass.len() + n;
        let mut scratch = Vec::new();
        for velocities in [false, true] {
            let held = |i: usize| {
                let mut given = given.iter();
                given.any(|own| (own.coordinate, own.moves) == (i, velocities))
            };
            let free: Vec<usize> = (0..n).filter(|i| !held(*i)).collect();
            let mut gap = f64::INFINITY;
            let mut settled = false;
            for _ in 0..MOST_STEPS {
                let mut inputs = vec![Ball::ZERO];
                inputs.extend(self.positions.iter().chain(&self.velocities).copied());
                let gaps = surface.evaluate(&inputs, &mut scratch);
                let gaps = if velocities { &gaps[c..] } else { &gaps[..c] };
                let kinks = kinks.evaluate(&inputs, &mut scratch);
                inputs.extend(
                    kinks
                        .iter()
                        .map(|x| Ball::exact(if x.mid_f64() < 0.0 { -1.0 } else { 1.0 })),
                );
                let values = tape.evaluate(&inputs, &mut scratch);
                let mut slopes = DMatrix::zeros(c, free.len());
                let mut sizes = vec![0.0_f64; c];
                for ((a, i), value) in equations.gradients.iter().zip(&values[first..]) {
                    let state = if velocities {
                        &self.velocities
                    } else {
                        &self.positions
                    };
                    let slope = value.mid_f64();
                    sizes[*a] = sizes[*a].max((slope * state[*i].mid_f64()).abs());
                    if let Some(column) = free.iter().position(|own| own == i) {
                        slopes[(*a, column)] = slope;
                    }
                }
                let off = gaps.iter().zip(&sizes).fold(0.0_f64, |most, (gap, size)| {
                    let gap = gap.mid_f64().abs();
                    most.max(if gap > 0.0 {
                        gap / size.max(f64::MIN_POSITIVE)
                    } else {
                        0.0
                    })
                });
                if off <= 1e-30 || (off <= 1e-26 && off >= 0.5 * gap) {
                    settled = true;
                    break;
                }
                gap = off;
                if free.is_empty() {
                    break;
                }
                let right = DVector::from_iterator(c, gaps.iter().map(|gap| -gap.mid_f64()));
                let step = slopes.svd(true, true).solve(&right, 1e-12);
                let Ok(step) = step else { break };
                let state = if velocities {
                    &mut self.velocities
                } else {
                    &mut self.positions
                };
                for (at, step) in free.iter().zip(step.iter()) {
                    let moved = state[*at] + Ball::exact(*step);
                    state[*at] = Ball::new(moved.mid, state[*at].radius);
                    // Newton's method leads near a point of the constraints, and no nearer.
                    self.known[if velocities { n + *at } else { *at }] = Known::Open;
                }
                if !step.iter().all(|x| x.is_finite()) {
                    break;
                }
            }
            if !settled {
                let what = if velocities {
                    "velocities"
                } else {
                    "coordinates"
                };
                return Err(MotionError::OffConstraints {
                    reason: format!("no {what} beside those that are given do"),
                });
            }
        }
        Ok(())
    }
}

/// The parts between commas outside brackets.
fn entries(text: &str) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut depth, mut first) = (0_i32, 0);
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&text[first..at]);
                first = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[first..]);
    if let [only] = parts.as_slice()
        && only.trim().is_empty()
    {
        parts.clear();
    }
    parts
}

/// `phi[1]'=0.1`
fn read(entry: &str, model: &Model) -> Result<Given, MotionError> {
    let bad = |reason: &str| MotionError::BadStart {
        text: entry.trim().to_owned(),
        reason: reason.to_owned(),
    };
    let (name, value) = entry
        .split_once('=')
        .ok_or_else(|| bad("there is no `=`"))?;
    let name: String = name.split_whitespace().collect();
    let (plain, moves) = match name.strip_suffix('\'') {
        Some(plain) => (plain, true),
        None => (name.as_str(), false),
    };
    if plain.ends_with('\'') {
        return Err(bad("accelerations follow from the equations of motion"));
    }
    // Indices as names of coordinates have them.
    let wanted = plain.replace(' ', "");
    let mut names = model.coordinates.iter();
    let at = names.position(|own| own.name.replace(' ', "") == wanted);
    let Some(at) = at else {
        let known: Vec<&str> = model
            .coordinates
            .iter()
            .map(|own| own.name.as_str())
            .collect();
        return Err(MotionError::NotACoordinate {
            nearest: nearest(plain, known).map(str::to_owned),
            name: name.clone(),
        });
    };
    let value = Constant::parse(value.trim()).map_err(|error| match error {
        ModelError::BadSetting { reason, .. } => bad(&reason),
        other => bad(&other.to_string()),
    })?;
    let number = linearize::constant(value.pool(), value.value()).filter(Ball::is_finite);
    let number = number.ok_or_else(|| bad("it is no number"))?;
    let factor = model.coordinates.get(at).and_then(|own| own.factor);
    let factor = factor.map(|factor| Known::constant(&model.pool, factor));
    let known = match (Known::constant(value.pool(), value.value()), factor) {
        (Known::Constant(value, _), Some(Known::Constant(factor, _))) => {
            Known::Constant(value, Some(factor))
        }
        (known, None) => known,
        (_, Some(_)) => Known::Open,
    };
    let number = scaled(model, at, &number);
    Ok(Given {
        coordinate: at,
        moves,
        value: Ball::new(number.mid, 0.0),
        known,
    })
}

/// From the coordinate's unit to SI.
fn scaled(model: &Model, coordinate: usize, value: &Ball) -> Ball {
    let factor = model.coordinates.get(coordinate).and_then(|own| own.factor);
    let factor = factor.and_then(|factor| evaluate_closed::<Ball>(&model.pool, factor, ()));
    factor.map_or(*value, |factor| value.mul(&factor))
}
