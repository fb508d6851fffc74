//! The commands about ranges and motions, each as the command line has it, and batches.

use std::iter;
use std::ops::Range as Span;

use librate::batch::{self, Outcome, Solutions, Study};
use librate::chart::{Chart, Place as ChartPlace};
use librate::floquet::{self, Options as FloquetOptions};
use librate::model::{Constant, Model as Elaborated, Range};
use librate::modes::Options;
use librate::motion::{Enclosed, Start, System, Times};
use librate::oscillation;
use librate::period::{self, Oscillator, Request as PeriodRequest};
use librate::report::{self, Remarks, Style, SweepColumns, SweepCsv, SweepRow, SweepView};
use librate::response::{self, Peaks, ResponseError, Value};
use librate::sweep::{Place, Sweep};
use librate::{Error, tracking};
use pyo3::prelude::*;

use crate::answers::{Answer, MOST_DIGITS, bytes, digits, doubles, positive};
use crate::commands::{Written, options};
use crate::job::{Failure, Job, Model, Size, in_parallel, range};

/// As many digits as a double-double holds.
const FEW_DIGITS: usize = 30;
/// So many sets are solved at a time: a multiple of eight, which are worked on side by side.
const PORTION: usize = 64;

/// A number from outside.
fn constant(text: &str) -> Result<Constant, Failure> {
    Constant::read(text).map_err(|reason| {
        Failure::request(format!("can't read `{text}`: {reason}"), "a number is needed: `10`, `'1/2'`, `'2*pi'`")
    })
}

/// What is wanted of a sweep.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct SweepArgs {
    over: String,
    digits: i64,
    lowest: Option<i64>,
    vectors: bool,
    threads: Option<i64>,
    svg: bool,
    orders: Vec<f64>,
    root_locus: bool,
}

/// The modes over a range of a parameter.
#[pyfunction]
pub(crate) fn sweep(py: Python<'_>, model: &Model, args: SweepArgs) -> PyResult<Answer> {
    model.answer(py, move |job| {
        let range = range(&args.over, "write `over=\"k=0..8:17\"` or `over={\"k\": (0, 8, 17)}`")?;
        let mut options = options(args.digits, args.lowest)?;
        options.vectors = args.vectors || args.svg;
        let threads = positive("threads", args.threads)?;
        let name = range.name().to_owned();
        let sweep = Sweep::new(job.made_from(), range, options);
        let count = sweep.range().len();
        if args.svg {
            let all: Vec<usize> = (0..count).collect();
            let blocks = sweep.blocks(&all);
            let worker = || {
                let (mut worker, blocks) = (sweep.worker(), &blocks);
                move |block: usize| worker.tracked(blocks[block])
            };
            let mut places = in_parallel(job, threads, blocks.len(), worker)?.concat();
            complain(job, &name, count, places.iter().map(|own| (own.value, own.modes.as_ref().err())))?;
            let branches = tracking::branches(&sweep, &mut places);
            let view = SweepView::new(args.orders.clone(), args.root_locus);
            return Ok(Written::drawn(report::sweep_svg(&sweep, &places, &branches, &view)));
        }
        let places = in_parallel(job, threads, count, || |at: usize| sweep.place_with_uncertainties(at))?;
        complain(job, &name, count, places.iter().map(|own| (own.value, own.result.as_ref().err())))?;
        let json: Vec<String> = places.iter().map(|place| report::sweep_json(&name, place, sweep.options())).collect();
        let row = |place: &Place| match &place.result {
            Ok((_, modes)) => SweepRow::new(place.value, modes, sweep.options().digits),
            Err(_) => SweepRow::empty(place.value),
        };
        let rows: Vec<SweepRow> = places.iter().map(row).collect();
        Ok(Written { json: format!("[{}]", json.join(",\n")), text: table(&name, &rows) })
    })
}

/// The lines of a sweep as CSV.
fn table(name: &str, rows: &[SweepRow]) -> String {
    let columns = SweepColumns::of(name, rows.iter(), false);
    let mut text = Vec::new();
    let mut table = SweepCsv::new(&mut text, columns);
    // Writing to memory does not fail.
    let written = table.header().and_then(|()| rows.iter().try_for_each(|row| table.row(row)));
    let written = written.and_then(|()| table.flush());
    drop(table);
    written.map_or_else(|_| String::new(), |()| String::from_utf8(text).unwrap_or_default())
}

/// Says why places have no modes, each reason once; an error where none has.
fn complain<'e>(
    job: &mut Job,
    name: &str,
    count: usize,
    places: impl Iterator<Item = (f64, Option<&'e Error>)>,
) -> Result<(), Failure> {
    let mut remarks = Remarks::new(name);
    let failed: Vec<(f64, &Error)> = places.filter_map(|(value, error)| Some((value, error?))).collect();
    failed.iter().for_each(|(value, error)| remarks.add(*value, error.diagnostics()));
    job.warnings.extend(remarks.all);
    match failed.first() {
        Some((_, error)) if failed.len() == count => Err(Failure(error.diagnostics())),
        _ => Ok(()),
    }
}

/// What is wanted of a period.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct PeriodArgs {
    amplitude: Option<String>,
    energy: Option<String>,
    over: Option<String>,
    digits: i64,
    svg: bool,
}

/// The exact period of one coordinate, or a curve of periods.
#[pyfunction]
pub(crate) fn periods(py: Python<'_>, model: &Model, args: PeriodArgs) -> PyResult<Answer> {
    model.answer(py, move |job| {
        let options = period::Options::default().digits(digits(args.digits, MOST_DIGITS)?);
        let help = "give one of `amplitude=1`, `energy=2`, `over=\"amplitude=0.1..3:30\"`";
        let request = match (&args.amplitude, &args.energy, &args.over) {
            (Some(amplitude), None, None) => Ok(PeriodRequest::Amplitude(constant(amplitude)?)),
            (None, Some(energy), None) => Ok(PeriodRequest::Energy(constant(energy)?)),
            (None, None, Some(over)) => Err(range(over, help)?),
            _ => return Err(Failure::request("the motion is not specified", help)),
        };
        if args.svg && request.is_ok() {
            return Err(Failure::request("a single period is no curve", "write `over=\"amplitude=0.1..3:30\"`"));
        }
        let oscillator = Oscillator::of_model(&job.values(Size::Dense)?)?;
        let range = match request {
            Ok(request) => {
                let found = oscillator.period(&request, &options)?;
                return Ok(Written {
                    json: report::period_json(&oscillator, &found, &options),
                    text: report::period_text(&oscillator, &found, &options, &Style::default()),
                });
            }
            Err(range) => range,
        };
        let places: Vec<period::Place> = period::curve(&oscillator, &range, &options)?.collect();
        if let [period::Place { result: Err(error), .. }, ..] = places.as_slice()
            && places.iter().all(|place| place.result.is_err())
        {
            return Err(error.clone().into());
        }
        if args.svg {
            let text = report::period_svg(oscillator.model(), &range, &places);
            return Ok(Written::drawn(text));
        }
        let json = report::period_curve_json(&oscillator, &places, &options);
        Ok(Written { json, text: report::period_csv(&range, &places, &options) })
    })
}

/// Floquet multipliers; a chart of stability over two parameters where there is a `map`.
#[pyfunction]
pub(crate) fn multipliers(
    py: Python<'_>,
    model: &Model,
    map: Option<(String, String)>,
    digits_wanted: i64,
    svg: bool,
) -> PyResult<Answer> {
    model.answer(py, move |job| {
        let digits = digits(digits_wanted, FEW_DIGITS)?;
        let help = "write `map=(\"a=0..10:100\", \"q=0..5:100\")`";
        let Some((first, second)) = map else {
            if svg {
                return Err(Failure::request("multipliers at one place are no chart", help));
            }
            let model = job.values(Size::Any)?;
            let found = floquet::floquet(&model, &FloquetOptions::default().digits(digits))?;
            return Ok(Written {
                json: report::floquet_json(&model, &found, digits),
                text: report::floquet_text(&model, &found, digits, &Style::default()),
            });
        };
        let ranges = [range(&first, help)?, range(&second, help)?];
        let chart = Chart::new(&job.made_from(), ranges)?;
        let rows: Vec<Vec<ChartPlace>> = in_parallel(job, None, chart.len()[0], || {
            let mut worker = chart.worker();
            move |row| worker.row(row)
        })?;
        let text = if svg { report::chart_svg(&chart, &rows) } else { report::chart_csv(&chart, &rows, digits) };
        Ok(Written::drawn(text))
    })
}

/// What is wanted of a response.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ResponseArgs {
    input: Option<String>,
    output: Vec<String>,
    over: String,
    digits: i64,
    threads: Option<i64>,
    svg: bool,
    peaks: bool,
}

/// The steady response to a harmonic force.
#[pyfunction]
pub(crate) fn steady_response(py: Python<'_>, model: &Model, args: ResponseArgs) -> PyResult<Answer> {
    model.answer(py, move |job| {
        let help = "write `over=\"omega=0..20:201\"`";
        let range = if args.peaks {
            Range::parse_ends(&args.over).map_err(|error| Failure::request(error.to_string(), help))?
        } else {
            range(&args.over, help)?
        };
        if args.input.is_some() && range.name() != "omega" {
            let message = format!("the frequency of a force given with `input` is `omega`, not `{}`", range.name());
            return Err(Failure::request(message, help));
        }
        let threads = positive("threads", args.threads)?;
        let digits = digits(args.digits, FEW_DIGITS)?;
        let model = job.values(Size::Dense)?;
        let request = response::Request { input: args.input, outputs: args.output, range, digits };
        let study = response::Study::new(model, job.made_from(), request)?;
        if args.peaks {
            let found = in_parallel(job, threads, study.outputs(), || |output: usize| study.peaks(output))?;
            let found = found.into_iter().collect::<Result<Vec<Peaks>, ResponseError>>()?;
            let response = study.response([]);
            job.warnings.extend(found.iter().filter_map(|own| own.remark(&response.name)));
            let text = report::peaks_csv(&response, &found, digits);
            return Ok(Written { json: report::peaks_json(&response, &found), text });
        }
        let values = in_parallel(job, threads, study.len(), || |place: usize| study.values(place))?;
        let values = values.into_iter().collect::<Result<Vec<Vec<Value>>, ResponseError>>()?;
        let response = study.response(values);
        job.warnings.extend(response.remarks());
        if args.svg {
            return Ok(Written::drawn(report::response_svg(&response, &[])));
        }
        Ok(Written { json: report::response_json(&response), text: report::response_csv(&response, digits) })
    })
}

/// What is wanted of a motion.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct MotionArgs {
    start: Option<String>,
    mode: Option<i64>,
    amplitude: Option<String>,
    until: Option<String>,
    at: Option<Vec<String>>,
    samples: i64,
    digits: i64,
    proved: bool,
    tolerance: Option<f64>,
    svg: bool,
}

/// The motion from a start, or of a mode.
#[pyfunction]
pub(crate) fn trajectory(py: Python<'_>, model: &Model, args: MotionArgs) -> PyResult<Answer> {
    model.answer(py, move |job| {
        let digits = digits(args.digits, FEW_DIGITS)?;
        let (times, mode) = args.check()?;
        let model = job.values(Size::Dense)?;
        let system = System::new(&model)?;
        let start = args.start(&model, &system, mode)?;
        let known = match args.tolerance {
            Some(tolerance) => system.quick(&start, &times, tolerance)?,
            None if args.proved => Enclosed::new(&model)?.motion(&start, &times, digits)?,
            None => system.motion(&start, &times)?,
        };
        if args.svg {
            return Ok(Written::drawn(report::motion_svg(&model, &known, None)));
        }
        let text = format!("{}\n", report::motion_remark(&known));
        Ok(Written { json: report::motion_json(&model, &known, digits), text })
    })
}

impl MotionArgs {
    /// The times, and the number of a mode.
    fn check(&self) -> Result<(Times, Option<usize>), Failure> {
        let samples = positive("samples", Some(self.samples))?.unwrap_or(1);
        let times = match (&self.at, &self.until) {
            (Some(at), None) => {
                let at: Vec<Constant> = at.iter().map(|text| constant(text)).collect::<Result<_, _>>()?;
                Times::listed(&at)?
            }
            (None, Some(until)) => Times::new(&constant(until)?, samples)?,
            _ => {
                return Err(Failure::request(
                    "the times are not specified",
                    "give one of `until=10` and `at=[0, 1, 2]`",
                ));
            }
        };
        let mode = positive("mode", self.mode)?;
        if self.start.is_some() == mode.is_some() || mode.is_some() != self.amplitude.is_some() {
            let help = "give either `start=\"x=1, x'=0\"` or `mode=1, amplitude=0.1`";
            return Err(Failure::request("the start is not specified", help));
        }
        if self.tolerance.is_some() && self.proved {
            return Err(Failure::request("`tolerance` and `proved` exclude each other", "leave out one of them"));
        }
        if self.tolerance.is_some_and(|tolerance| !(1e-17..=0.1).contains(&tolerance)) {
            return Err(Failure::request("`tolerance` is out of range", "a number from 1e-17 to 0.1 is needed"));
        }
        Ok((times, mode))
    }

    fn start(&self, model: &Elaborated, system: &System, mode: Option<usize>) -> Result<Start, Failure> {
        let linearized = Start::linearized(model, mode.is_some())?;
        Ok(match (mode, &self.amplitude, &linearized) {
            (Some(mode), Some(amplitude), Some(linearized)) => {
                let normal = oscillation::normal_modes(linearized, &Options::default())?;
                Start::mode(mode, &constant(amplitude)?, model, (linearized, &normal), system)?
            }
            _ => Start::parse(self.start.as_deref().unwrap_or_default(), model, linearized.as_ref(), system)?,
        })
    }
}

/// Many sets of parameters.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct BatchArgs {
    /// Parameters or families, each with doubles, set after set.
    columns: Vec<(String, Vec<u8>)>,
    sets: usize,
    vectors: bool,
    matrices: bool,
    bounds: bool,
    threads: Option<i64>,
}

/// The modes of many sets as the bytes of doubles, set after set.
#[derive(Default, IntoPyObject)]
pub(crate) struct Batch {
    coordinates: Vec<String>,
    outcome: Vec<u8>,
    equilibrium: Vec<u8>,
    error_bound: Vec<u8>,
    omega_squared: Vec<u8>,
    omega_squared_error_bound: Vec<u8>,
    vectors: Vec<u8>,
    mass: Vec<u8>,
    stiffness: Vec<u8>,
    /// Real and imaginary part of each number.
    exponents: Vec<u8>,
    exponent_error_bound: Vec<u8>,
    shapes: Vec<u8>,
    velocity: Vec<u8>,
    is_conservative: bool,
}

impl Batch {
    /// Behind what is there.
    fn add(&mut self, solved: &Solutions) {
        let modes = solved.omega_squared().len().checked_div(solved.len()).unwrap_or(0);
        for set in 0..solved.len() {
            for mode in 0..modes {
                let found = solved.get(set).and_then(|own| own.mode(mode));
                self.error_bound.extend(found.map_or(f64::NAN, |mode| mode.error_bound).to_ne_bytes());
            }
        }
        self.outcome.extend(solved.outcomes().iter().map(|own| number(*own)));
        let parts = [
            solved.equilibria(),
            solved.omega_squared(),
            solved.omega_squared_bounds(),
            solved.vectors(),
            solved.mass(),
            solved.stiffness(),
            solved.exponent_bounds(),
            solved.velocity(),
        ];
        for (all, part) in self.parts().into_iter().zip(parts) {
            all.extend(bytes(part.iter().copied()));
        }
        for (all, part) in [(&mut self.exponents, solved.exponents()), (&mut self.shapes, solved.shapes())] {
            all.extend(bytes(part.iter().flat_map(|own| [own.re, own.im])));
        }
    }

    /// Behind what is there.
    fn append(&mut self, mut other: Self) {
        for (all, part) in self.parts().into_iter().zip(other.parts()) {
            all.append(part);
        }
    }

    /// Numbers as the results of a study have them, then the others.
    fn parts(&mut self) -> [&mut Vec<u8>; 12] {
        [
            &mut self.equilibrium,
            &mut self.omega_squared,
            &mut self.omega_squared_error_bound,
            &mut self.vectors,
            &mut self.mass,
            &mut self.stiffness,
            &mut self.exponent_error_bound,
            &mut self.velocity,
            &mut self.exponents,
            &mut self.shapes,
            &mut self.outcome,
            &mut self.error_bound,
        ]
    }
}

/// Solves all sets, on all cores, in doubles with rigorous bounds.
#[pyfunction]
pub(crate) fn solve_sets(py: Python<'_>, model: &Model, args: BatchArgs) -> PyResult<Batch> {
    let (solved, _) = model.run(py, move |job| {
        let threads = positive("threads", args.threads)?;
        let model = job.model(Size::Dense)?;
        let mut options = batch::Options::default();
        options.vectors = args.vectors;
        options.matrices = args.matrices;
        if !args.bounds {
            options = options.without_bounds();
        }
        let names: Vec<&str> = args.columns.iter().map(|(name, _)| name.as_str()).collect();
        let study = Study::with_options(model, &names, options)?;
        let members = members(&study, &args)?;
        let solved = in_parallel(job, threads, args.sets.div_ceil(PORTION), || {
            |at: usize| -> Result<Batch, Failure> {
                let sets = at * PORTION..args.sets.min((at + 1) * PORTION);
                let mut own = Batch::default();
                own.add(&study.solve(&interleaved(&args, &members, sets))?);
                Ok(own)
            }
        })?;
        let coordinates = study.model().coordinates.names().collect();
        let mut all = Batch { coordinates, is_conservative: study.is_conservative(), ..Batch::default() };
        for own in solved {
            all.append(own?);
        }
        Ok(all)
    })?;
    Ok(solved)
}

/// Its place in the list that Python has of them.
fn number(outcome: Outcome) -> u8 {
    match outcome {
        Outcome::Solved => 0,
        Outcome::Estimated => 1,
        Outcome::NotFinite => 2,
        Outcome::MassNotPositive => 3,
        Outcome::NoEquilibrium => 4,
        _ => 5,
    }
}

/// How many parameters each column is for: one, or all members of a family, with a value for each or one for all.
fn members(study: &Study, args: &BatchArgs) -> Result<Vec<usize>, Failure> {
    let parameters: Vec<&str> = study.parameters().collect();
    let mut all = Vec::with_capacity(args.columns.len());
    for (name, column) in &args.columns {
        let stem = format!("{name}[");
        let members = parameters.iter().filter(|own| *own == name || own.starts_with(&stem)).count();
        let given = a_set(column, args);
        if given != 1 && given != members {
            let message = format!("`{name}` has {members} members, not {given}");
            return Err(Failure::request(message, "an array of one row a set and one column a member is needed"));
        }
        all.push(members);
    }
    Ok(all)
}

/// How many values a column has for each set.
fn a_set(column: &[u8], args: &BatchArgs) -> usize {
    (column.len() / size_of::<f64>()).checked_div(args.sets).unwrap_or(1)
}

/// The values of all parameters, set after set.
fn interleaved(args: &BatchArgs, members: &[usize], sets: Span<usize>) -> Vec<f64> {
    let mut values = Vec::with_capacity(sets.len() * members.iter().sum::<usize>());
    for set in sets {
        for ((_, column), members) in args.columns.iter().zip(members) {
            let given = a_set(column, args);
            let each = given * size_of::<f64>();
            let row = column.get(each * set..each * (set + 1)).unwrap_or_default();
            let repeated = if given == 1 { *members } else { 1 };
            values.extend(doubles(row).flat_map(|value| iter::repeat_n(value, repeated)));
        }
    }
    values
}
