//! The steady response of a linearised model to a harmonic force, with bounds.
//!
//! M q'' + (G + C) q' + (K + N) q = f has the response q = H(ω) f, H = (-ω²M + iω(G + C) + K + N)⁻¹, to a force f e^(iωt): either one
//! of unit amplitude on a coordinate, or the model's own drive (`drive`). Each value is enclosed by elimination in double-double, with more bits
//! where its digits need them (`solve`); for tables with few digits there are doubles with bounds ([`Study::in_doubles`]). That an amplitude is infinite is only said where it is proved from exact matrices
//! (`exact`): close to a resonance a response is large, at it none.
//!
//! It starts no thread: frequencies are independent of each other, and a [`Study`] is `Sync`.

mod drive;
mod error;
mod exact;
mod order;
mod peaks;
mod remarks;
mod solve;

pub use error::ResponseError;
pub use peaks::{Peak, PeakKind, Peaks};

use std::sync::OnceLock;

use crate::source::{self, End, Source, between, first, rational, share, unit_of, written_ends};
use drive::{Drive, Driven, averaged};
use exact::{Exact, Frequency};
use librate_core::derive;
use librate_core::linearize::{self, Linearized, Structure};
use librate_core::model::{Constant, Model, Range, entries};
use librate_core::modes::SparseResponse;
use librate_core::number::Number;
use librate_core::oscillation;
use librate_core::precision::{Ball, Big, Complex, Enclosure, LANES};
use solve::{Matrices, polar};

/// Bits of the levels above double-double, and the multiplications that an elimination may take there.
const LEVELS: [(usize, f64); 3] = [(192, 2e7), (512, 4e6), (1536, 4e5)];
/// What an enclosure in two doubles may be off by, beside itself.
const HELD: f64 = 1e-31;
/// More bits than double-double are for no more coordinates.
const MOST_PRECISE: usize = 1000;
/// An elimination in a band that takes more multiplications comes behind a sparse decomposition, ...
const MOST_ELIMINATED: f64 = 1e5;
/// ... which is not for fewer coordinates.
const FEW: usize = 24;
/// Exact matrices are examined once this level decides nothing.
const EXACT_AFTER: usize = 1;

/// What is asked for.
#[derive(Clone, Debug)]
pub struct Request {
    /// The coordinate on which a force of unit amplitude acts; without it the model's own drive.
    pub input: Option<String>,
    /// The coordinates that are wanted, one or several with commas in each text; all where there are none.
    pub outputs: Vec<String>,
    /// The frequencies, or the values of the parameter in the frequency of the drive.
    pub range: Range,
    /// Significant digits, at most 30.
    pub digits: usize,
}

/// The response of one coordinate at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Value {
    /// A finite one.
    Known {
        /// The amplitude in SI.
        amplitude: Ball,
        /// The angle of the complex amplitude in (-pi, pi]: the coordinate is amplitude · cos(ωt + phase). `None` where the amplitude is 0.
        phase: Option<Ball>,
    },
    /// There is no steady response: an undamped resonance, proved.
    Infinite,
    /// Bounds do not decide.
    Undecided,
}

impl Value {
    /// As a double; infinite at a resonance, no number where undecided.
    #[must_use]
    pub fn amplitude(&self) -> f64 {
        match self {
            Self::Known { amplitude, .. } => amplitude.mid_f64(),
            Self::Infinite => f64::INFINITY,
            Self::Undecided => f64::NAN,
        }
    }

    /// As a double; no number where there is none.
    #[must_use]
    pub fn phase(&self) -> f64 {
        match self {
            Self::Known { phase: Some(phase), .. } => phase.mid_f64(),
            Self::Known { phase: None, .. } | Self::Infinite | Self::Undecided => f64::NAN,
        }
    }
}

/// The response of one coordinate.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Output {
    /// The coordinate.
    pub coordinate: String,
    /// Its unit in SI, where the file tells.
    pub unit: Option<String>,
    /// One a frequency.
    pub values: Vec<Value>,
}

/// The response over a range.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Response {
    /// From the `model` statement.
    pub model: Option<String>,
    /// The coordinate on which the force acts; `None` for the model's own drive.
    pub input: Option<String>,
    /// `omega`, or the parameter in the frequency of the drive.
    pub name: String,
    /// The unit that the parameter is declared with.
    pub unit: Option<String>,
    /// The values of it, rounded to doubles.
    pub places: Vec<f64>,
    /// The outputs.
    pub outputs: Vec<Output>,
    /// Whether the existence of the equilibrium is proved; where it is not, its radius is an estimate, and so are the bounds.
    pub proved: bool,
    /// That motions about the equilibrium grow, where it is the same at all frequencies.
    pub unstable: Option<oscillation::Warning>,
}

impl Response {
    /// Adds a place and the values of the outputs there.
    pub fn push(&mut self, place: f64, values: Vec<Value>) {
        self.places.push(place);
        self.outputs.iter_mut().zip(values).for_each(|(output, value)| output.values.push(value));
    }
}

/// Where the force comes from.
#[derive(Debug)]
enum Force {
    Unit(usize),
    Own(Box<Drive>),
}

impl Force {
    /// The coordinates on which it acts.
    fn coordinates(&self) -> &[usize] {
        match self {
            Self::Unit(at) => std::slice::from_ref(at),
            Self::Own(drive) => &drive.coordinates,
        }
    }
}

/// The linear system and its force.
#[derive(Debug)]
struct System {
    linearized: Linearized,
    force: Force,
    balls: Matrices<Ball>,
    /// What is solved without a band, where that is wide.
    sparse: OnceLock<Option<SparseResponse>>,
    levels: [OnceLock<Option<Matrices<Big>>>; LEVELS.len()],
    exact: OnceLock<Option<Exact>>,
}

/// A model whose response is asked for at many frequencies.
#[derive(Debug)]
pub struct Study {
    source: Source,
    request: Request,
    model: Model,
    /// The coordinates that are wanted, by number.
    outputs: Vec<usize>,
    ends: [End; 2],
    /// The system, where it is the same at all frequencies.
    fixed: Option<System>,
}

/// Finds a coordinate by its name.
fn coordinate(model: &Model, name: &str, what: &'static str) -> Result<usize, ResponseError> {
    let named = source::coordinate(model, name);
    let first = || model.coordinates.names().next().unwrap_or_default();
    named.map_err(|nearest| ResponseError::NotACoordinate { what, name: name.to_owned(), nearest, first: first() })
}

impl System {
    fn new(linearized: &Linearized, force: Force) -> Self {
        let linearized = linearized.with_massless();
        let balls = Matrices::in_balls(&linearized, force.coordinates());
        Self { linearized, force, balls, sparse: OnceLock::new(), levels: Default::default(), exact: OnceLock::new() }
    }

    fn level(&self, level: usize) -> Option<&Matrices<Big>> {
        let (bits, most) = LEVELS[level];
        let matrices = || Matrices::in_bits(&self.linearized, self.force.coordinates(), bits);
        // More bits are for dense matrices.
        let is_small = self.linearized.dimension() <= MOST_PRECISE && self.balls.work() <= most;
        let found = || is_small.then(matrices).flatten();
        self.levels[level].get_or_init(found).as_ref()
    }

    /// The angular frequency and the forces.
    fn driven<S: Enclosure>(&self, quantity: &S, point: &[S], precision: S::Precision) -> Option<Driven<S>> {
        match &self.force {
            Force::Unit(at) => Some((quantity.clone(), vec![(*at, Complex::real(1.0, precision))])),
            Force::Own(drive) => drive.at(quantity, point, precision).map(|[values, _]| values),
        }
    }

    /// The response of the outputs by elimination within the band.
    fn eliminated<S: Enclosure>(
        &self,
        matrices: &Matrices<S>,
        quantity: Option<S>,
        outputs: &[usize],
    ) -> Option<Vec<Complex<S>>> {
        let (omega, forces) = self.driven(&quantity?, &matrices.point, matrices.precision)?;
        matrices.response(&omega, &forces, outputs)
    }

    /// The same by a sparse decomposition and a bound for all coordinates together.
    fn without_band(&self, quantity: Option<Ball>, outputs: &[usize]) -> Option<Vec<Complex<Ball>>> {
        let problem = || SparseResponse::new(&oscillation::sparse_quadratic(&self.linearized)?);
        let sparse = self.sparse.get_or_init(problem).as_ref()?;
        let (omega, forces) = self.driven(&quantity?, &self.balls.point, ())?;
        let mut all = sparse.at(&omega, &forces)?;
        if omega.is_zero() && forces.iter().all(|(_, force)| force.im.is_zero()) {
            all.iter_mut().for_each(|own| own.im = Ball::ZERO);
        }
        outputs.iter().map(|at| all.get(*at).copied()).collect()
    }

    /// Puts in what numbers of one kind decide.
    fn decide<S: Enclosure>(
        &self,
        found: Option<Vec<Complex<S>>>,
        precision: S::Precision,
        outputs: &[usize],
        values: &mut [Value],
        digits: usize,
    ) {
        // -ω²M + iωG + K is Hermitian, and so is its inverse.
        let is_hermitian = self.linearized.structure() == Structure::Gyroscopic;
        for ((value, mut own), output) in values.iter_mut().zip(found.unwrap_or_default()).zip(outputs) {
            if is_hermitian && matches!(self.force, Force::Unit(at) if at == *output) {
                own.im = Complex::real(0.0, precision).re;
            }
            if *value == Value::Undecided {
                *value = decided(&own, precision, digits);
            }
        }
    }
}

/// A response, where its digits are decided.
fn decided<S: Enclosure>(x: &Complex<S>, precision: S::Precision, digits: usize) -> Value {
    let (amplitude, phase) = polar(x, precision);
    let (amplitude, phase) = (amplitude.to_ball(), phase.map(|phase| phase.to_ball()));
    // A thousandth of a unit of the last digit, or what two doubles hold.
    let share = 10_f64.powi(-3 - digits as i32).max(HELD);
    let is_known = |own: &Ball| own.is_finite() && own.radius <= share * own.mid_f64().abs();
    let known = is_known(&amplitude) && phase.as_ref().map_or(amplitude.is_zero(), is_known);
    if known { Value::Known { amplitude, phase } } else { Value::Undecided }
}

impl Study {
    /// Looks the names up and linearises.
    ///
    /// # Errors
    /// Where names are no coordinates, nothing drives the model, its drive is not harmonic or changes the matrices, or there is no
    /// equilibrium.
    pub fn new(model: Model, source: Source, request: Request) -> Result<Self, ResponseError> {
        if !(model.constraints.is_empty() && model.rolling.is_empty()) {
            linearize::check_size(model.coordinates.len())?;
        }
        let names = request.outputs.iter().flat_map(|names| match entries(names) {
            names if names.is_empty() => vec![""],
            names => names,
        });
        let outputs = names.map(|name| coordinate(&model, name, "output"));
        let outputs: Vec<usize> = outputs.collect::<Result<_, _>>()?;
        let outputs = if outputs.is_empty() { (0..model.coordinates.len()).collect() } else { outputs };
        let input = request.input.as_deref().map(|name| coordinate(&model, name, "input")).transpose()?;
        let refuse_rolling = |what, is_refused| match model.rolling.first() {
            Some(own) if is_refused => Err(ResponseError::Unsupported { what, span: own.span }),
            _ => Ok(()),
        };
        refuse_rolling("a steady motion under constraints on velocities", model.rates.any())?;
        let range = &request.range;
        let last = range.len() - 1;
        let (ends, fixed, model) = match (input, model.time_dependent) {
            (Some(at), None) => {
                let ends = written_ends(range)?;
                check_sign(&ends)?;
                let linearized = derive::linearized(model.clone())?;
                // With coordinates of its own it has none for the forces that are carried.
                let is_other = linearized.model().coordinates.len() != model.coordinates.len();
                refuse_rolling("a load that constraints on velocities carry", is_other)?;
                (ends, Some(System::new(&linearized, Force::Unit(at))), model)
            }
            (Some(_), Some(span)) => {
                return Err(ResponseError::DrivenAlready { input: request.input.unwrap_or_default(), span });
            }
            (None, None) => return Err(ResponseError::NotDriven {}),
            (None, Some(_)) => {
                let model = source.model(range, 0, first::<ResponseError>)?;
                let other = source.model(range, last, first::<ResponseError>)?;
                let ends = [end_of(&model, range)?, end_of(&other, range)?];
                check_sign(&ends)?;
                let (system, is_fixed) = driven(&model, range)?;
                (ends, is_fixed.then_some(system), model)
            }
        };
        Ok(Self { source, request, model, outputs, ends, fixed })
    }

    /// The same over other places between the same ends.
    #[must_use]
    pub fn over(mut self, range: Range) -> Self {
        self.request.range = range;
        self
    }

    /// The frequencies.
    #[must_use]
    pub fn range(&self) -> &Range {
        &self.request.range
    }

    /// The number of frequencies.
    #[must_use]
    pub fn len(&self) -> usize {
        self.request.range.len()
    }

    /// Never: a range has at least one place.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The frequency, or the parameter in it, at a place (from 0), in the unit that it is declared with; rounded to a double.
    #[must_use]
    pub fn place(&self, place: usize) -> f64 {
        let in_si = self.quantity::<Ball>(place, ()).filter(|_| self.request.input.is_some());
        in_si.map(|value| value.mid_f64()).or_else(|| self.request.range.value(place)).unwrap_or(f64::NAN)
    }

    /// The response of each output at a place.
    ///
    /// # Errors
    /// Where the model depends on the parameter and has none at its value there.
    pub fn values(&self, place: usize) -> Result<Vec<Value>, ResponseError> {
        match &self.fixed {
            Some(system) => Ok(self.with(system, place)),
            None => {
                let model = self.source.model(&self.request.range, place, first::<ResponseError>)?;
                Ok(self.with(&driven(&model, &self.request.range)?.0, place))
            }
        }
    }

    /// The same at some places in doubles with bounds, eight at a time, for tables with few digits; none where that proves nothing.
    #[must_use]
    pub fn in_doubles(&self, places: std::ops::Range<usize>) -> Vec<Option<Vec<Value>>> {
        let found = self.fixed.as_ref().and_then(|system| self.side_by_side(system, places.clone()));
        found.unwrap_or_else(|| vec![None; places.len()])
    }

    /// The response of each output at some places, with bounds that decide the digits asked for: in doubles where these suffice.
    ///
    /// # Errors
    /// As [`Study::values`].
    pub fn all_values(&self, places: std::ops::Range<usize>) -> Result<Vec<Vec<Value>>, ResponseError> {
        let share = 0.5 * 10_f64.powi(-(self.request.digits as i32));
        let is_enough = |value: &Value| match value {
            Value::Known { amplitude, phase } => {
                let angle = phase.as_ref().map_or(0.0, |phase| phase.radius);
                amplitude.radius <= share * amplitude.mid_f64().abs() && angle <= share
            }
            Value::Infinite | Value::Undecided => false,
        };
        let quick = self.in_doubles(places.clone()).into_iter();
        let quick = quick.map(|own| own.filter(|own| own.iter().all(is_enough)));
        quick.zip(places).map(|(own, place)| own.map_or_else(|| self.values(place), Ok)).collect()
    }

    fn side_by_side(&self, system: &System, places: std::ops::Range<usize>) -> Option<Vec<Option<Vec<Value>>>> {
        let matrices = &system.balls;
        let banded = matrices.banded()?;
        let rows = self.outputs.iter().map(|at| matrices.row(*at)).collect::<Option<Vec<usize>>>()?;
        let driven = |place| {
            let (omega, mut forces) = system.driven(&self.quantity::<Ball>(place, ())?, &matrices.point, ())?;
            forces.iter_mut().try_for_each(|(at, _)| matrices.row(*at).map(|row| *at = row))?;
            Some((omega, forces))
        };
        let driven: Vec<Driven<Ball>> = places.map(driven).collect::<Option<_>>()?;
        let found = banded.polar(&driven, &rows);
        let of_place = |(at, (omega, forces)): (usize, &Driven<Ball>)| {
            let is_real = (matrices.is_real || omega.is_zero()) && forces.iter().all(|(_, force)| force.im.is_zero());
            let mut values = Vec::with_capacity(rows.len());
            for own in &found[at / LANES * rows.len()..][..rows.len()] {
                let [amplitude, phase] = own.at(at % LANES);
                let phase = match is_real {
                    true if own.phase.0[at % LANES] < 1.0 => Ball::ZERO,
                    true => Ball::PI,
                    false => phase,
                };
                if !(amplitude.is_finite() && phase.is_finite()) {
                    return None;
                }
                values.push(Value::Known { amplitude, phase: Some(phase) });
            }
            Some(values)
        };
        Some(driven.iter().enumerate().map(of_place).collect())
    }

    fn with(&self, system: &System, place: usize) -> Vec<Value> {
        let (outputs, digits) = (&self.outputs, self.request.digits);
        let mut values = vec![Value::Undecided; outputs.len()];
        let is_open = |values: &[Value]| values.contains(&Value::Undecided);
        let is_wide = system.balls.work() > MOST_ELIMINATED;
        for in_band in [!is_wide, is_wide] {
            let quantity = self.quantity(place, ());
            let found = match in_band {
                true => system.eliminated(&system.balls, quantity, outputs),
                false if system.linearized.dimension() > FEW => system.without_band(quantity, outputs),
                false => None,
            };
            system.decide(found, (), outputs, &mut values, digits);
            if !is_open(&values) {
                return values;
            }
        }
        for level in 0..LEVELS.len() {
            if level == EXACT_AFTER && is_open(&values) {
                self.exactly(system, place, &mut values);
            }
            if !is_open(&values) {
                break;
            }
            if let Some(matrices) = system.level(level) {
                let precision = matrices.precision;
                let found = system.eliminated(matrices, self.quantity(place, precision), outputs);
                system.decide(found, precision, outputs, &mut values, digits);
            }
        }
        values
    }

    /// Puts in what exact matrices decide.
    fn exactly(&self, system: &System, place: usize, values: &mut [Value]) {
        let limits = || {
            let exact = system.exact.get_or_init(|| Exact::of(&system.linearized)).as_ref()?;
            let frequency = match &system.force {
                Force::Unit(_) => self.frequency(place)?,
                Force::Own(drive) => drive.exactly(&self.rational(place)?)?,
            };
            let (_, forces) = system.driven(&self.quantity::<Ball>(place, ())?, &system.balls.point, ())?;
            exact.limits(&frequency, &forces, &self.outputs)
        };
        for (value, limit) in values.iter_mut().zip(limits().unwrap_or_default()) {
            if *value == Value::Undecided {
                *value = limit.map_or_else(|value| value, |x| decided(&x, (), self.request.digits));
            }
        }
    }

    /// The frequency or the parameter at a place, in SI, where the ends of the range are rational.
    fn rational(&self, place: usize) -> Option<Number> {
        rational(&self.ends, &self.request.range, place)
    }

    /// The frequency at a place where its square is rational.
    fn frequency(&self, place: usize) -> Option<Frequency> {
        let constant = Constant::parse(&self.request.range.expression(place)).ok()?;
        Frequency::of(&mut constant.pool().clone(), constant.value())
    }

    /// The same in any numbers.
    fn quantity<S: Enclosure>(&self, place: usize, precision: S::Precision) -> Option<S> {
        if let Some(value) = self.rational(place) {
            return Some(S::from_number(&value, precision));
        }
        between(&self.ends, &share(&self.request.range, place)?, precision)
    }

    /// The unit of a coordinate, where the file tells.
    fn unit(&self, coordinate: usize) -> Option<String> {
        self.model.coordinates.at(coordinate).unit.filter(|unit| *unit != "1").map(str::to_owned)
    }

    /// All of it, from the values at each place.
    #[must_use]
    pub fn response(&self, values: impl IntoIterator<Item = Vec<Value>>) -> Response {
        let named = |at: &usize| {
            let coordinate = self.model.coordinates.at(*at).name();
            Output { coordinate, unit: self.unit(*at), values: Vec::new() }
        };
        let system = self.fixed.as_ref();
        let name = self.request.range.name();
        // With an input the range is one of frequencies.
        let is_parameter = self.request.input.is_none();
        let mut all = Response {
            model: self.model.name.clone(),
            input: self.request.input.clone(),
            name: name.to_owned(),
            unit: is_parameter.then(|| unit_of(&self.source.file, name)).flatten(),
            places: Vec::new(),
            outputs: self.outputs.iter().map(named).collect(),
            proved: system.is_none_or(|system| system.linearized.equilibrium().proved),
            unstable: system.and_then(|system| oscillation::never_reached(&system.linearized)),
        };
        values.into_iter().enumerate().for_each(|(place, values)| all.push(self.place(place), values));
        all
    }
}

/// The number of the parameter that the range is of.
fn parameter(model: &Model, range: &Range) -> Result<usize, ResponseError> {
    let span = model.time_dependent.unwrap_or_default();
    source::parameter(model, range).ok_or_else(|| ResponseError::OtherFrequency {
        parameter: range.name().to_owned(),
        rate: None,
        span,
    })
}

/// The value of the parameter that a model was made with.
fn end_of(model: &Model, range: &Range) -> Result<End, ResponseError> {
    let number = parameter(model, range)?;
    match model.parameters[number].value {
        Some(value) => Ok(End { pool: model.pool.clone(), value }),
        None => Err(ResponseError::Linearize(linearize::missing_value(model, number))),
    }
}

/// Refuses negative frequencies.
fn check_sign(ends: &[End; 2]) -> Result<(), ResponseError> {
    let values = ends.each_ref().map(|end| linearize::constant(&end.pool, end.value));
    if values.iter().flatten().any(Ball::is_negative) {
        let [from, to] = values.map(|value| value.map_or_else(String::new, |value| value.mid_f64().to_string()));
        return Err(ResponseError::NegativeFrequency { from, to });
    }
    Ok(())
}

/// The system of a driven model, and whether it does not depend on the parameter of a range.
fn driven(model: &Model, range: &Range) -> Result<(System, bool), ResponseError> {
    let number = parameter(model, range)?;
    let averaged = averaged(model, number)?;
    let linearized = linearize::linearize(averaged.model.clone())?;
    let drive = averaged.drive(model, number, &linearized)?;
    Ok((System::new(&linearized, Force::Own(Box::new(drive))), averaged.is_fixed))
}
