//! Where a motion starts: values that are given, the rest at the equilibrium; or a mode with an amplitude.

use nalgebra::{DMatrix, DVector};

use super::System;
use super::error::MotionError;
use crate::diagnostic::nearest;
use crate::linearize::{self, Linearized, evaluate_closed};
use crate::model::{Constant, Model, ModelError};
use crate::oscillation::NormalModes;
use crate::precision::{Ball, Scalar};

/// Newton steps to the constraints.
const MOST_STEPS: usize = 60;

/// Coordinates and velocities at t = 0, in SI.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Start {
    /// The coordinates.
    pub positions: Vec<Ball>,
    /// Their velocities.
    pub velocities: Vec<Ball>,
}

/// One value that is given: which coordinate, whether it is the velocity, and what.
type Given = (usize, bool, Ball);

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
            if given.iter().any(|own| (own.0, own.1) == (value.0, value.1)) {
                return Err(MotionError::BadStart {
                    text: entry.trim().to_owned(),
                    reason: "it is given twice".to_owned(),
                });
            }
            given.push(value);
        }
        for (at, moves, value) in &given {
            if *moves {
                start.velocities[*at] = *value;
            } else {
                start.positions[*at] = *value;
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
        let (growth, omega) = (mode.growth.mid_f64(), mode.omega.mid_f64());
        // What the bound does not tell from 0 or from the largest component is taken to be that, as symmetry makes it
        // mostly.
        let unknown = 4.0 * mode.vector_error_bound / square.sqrt();
        let known = |x: f64| {
            let near = [0.0, 1.0, -1.0].into_iter();
            let mut near = near.filter(|whole| (x - whole).abs() <= unknown);
            near.next().unwrap_or(x)
        };
        for (at, x) in start.positions.iter_mut().enumerate() {
            let (a, b) = (mode.vector[at], imaginary[at]);
            let real = known((a * re + b * im) / square);
            let rest = known((b * re - a * im) / square);
            *x = Ball::new(x.add(&value.mul(&Ball::exact(real))).mid, 0.0);
            // The rate of Re(z exp((growth + i omega) t)). A mode in phase starts where it turns.
            let in_phase = mode.imaginary.is_empty() && omega != 0.0;
            if !in_phase {
                let rate = growth * real - omega * rest;
                let v = &mut start.velocities[at];
                *v = Ball::new(v.add(&value.mul(&Ball::exact(rate))).mid, 0.0);
            }
        }
        start.onto_constraints(system, &[])?;
        Ok(start)
    }

    fn at_rest(model: &Model, linearized: Option<&Linearized>) -> Self {
        let centre = |value: &Ball| Ball::new(value.mid, 0.0);
        if let Some(linearized) = linearized {
            return Self {
                positions: linearized.equilibrium().values.iter().map(centre).collect(),
                velocities: linearized.rates().iter().map(centre).collect(),
            };
        }
        let given = model.equilibria.iter().zip(&model.guesses);
        let positions = given.map(|(equilibrium, guess)| {
            let value = equilibrium.or(*guess).and_then(|given| given.value);
            let value = value.and_then(|value| linearize::constant(&model.pool, value));
            value.as_ref().map_or(Ball::ZERO, centre)
        });
        Self {
            positions: positions.collect(),
            velocities: vec![Ball::ZERO; model.coordinates.len()],
        }
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
        let first = equations.mass.len() + n;
        let mut scratch = Vec::new();
        for velocities in [false, true] {
            let held = |i: usize| given.iter().any(|own| (own.0, own.1) == (i, velocities));
            let free: Vec<usize> = (0..n).filter(|i| !held(*i)).collect();
            let mut gap = f64::INFINITY;
            let mut settled = false;
            for _ in 0..MOST_STEPS {
                let mut inputs = vec![Ball::ZERO];
                inputs.extend(self.positions.iter().chain(&self.velocities).copied());
                let gaps = surface.evaluate(&inputs, &mut scratch);
                let gaps = if velocities { &gaps[c..] } else { &gaps[..c] };
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
                    state[*at] = Ball::from((state[*at] + Ball::exact(*step)).mid);
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
    Ok((at, moves, scaled(model, at, &number)))
}

/// From the coordinate's unit to SI.
fn scaled(model: &Model, coordinate: usize, value: &Ball) -> Ball {
    let factor = model.coordinates.get(coordinate).and_then(|own| own.factor);
    let factor = factor.and_then(|factor| evaluate_closed::<Ball>(&model.pool, factor, ()));
    let value = factor.map_or(*value, |factor| value.mul(&factor));
    Ball::new(value.mid, 0.0)
}
