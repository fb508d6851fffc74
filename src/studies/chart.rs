//! Stability charts: whether a driven model is stable, over a grid of two parameters.
//!
//! The equations are derived once, with both parameters open, and followed over a period in plain doubles
//! ([`crate::flow::Plain`]), at eight places at once: nothing is parsed or differentiated again. Multipliers have no bounds
//! here; where that counts, [`crate::floquet::floquet`] is asked. Borders between stable and unstable neighbours are found
//! by bisection.
//!
//! It starts no thread and writes nothing: rows are independent of each other, a [`Chart`] is `Sync`, and a [`Worker`]
//! belongs to one thread.

use crate::source::{self, Source};

use nalgebra::{Complex, DMatrix, DVector};

use crate::error::Error;
use crate::floquet::motion::Driven;
use crate::floquet::{self, FloquetError, trial};
use crate::flow::{Doubles, Equations, Plain};
use librate_core::expr::{Prepared, Tape};
use librate_core::linearize;
use librate_core::model::{self, Model, ModelError, Range};
use librate_core::precision::{LANES, Lane};

/// More places than this are not charted.
pub(crate) const MOST_PLACES: usize = 10_000_000;
/// Multipliers this far outside the unit circle count as growth where several are near each other: a double one moves
/// by the root of what is rounded.
const COARSE: f64 = 1e-7;
/// The same where trace and determinant decide: what is rounded on the way over a period. Where multipliers meet at -1
/// without growing, as they do without a drive, they would else be taken apart by it.
const FINE: f64 = 2e-14;
/// An integration that takes so many times the steps of the one before is none of a motion near that.
const ASTRAY: usize = 4;
/// Steps in time that a search at one place may take.
const SEARCH: usize = 20_000;
/// Steps of Newton's method to a periodic motion.
const NEWTON: usize = 40;
/// Halvings of an interval: 2^-44 is below 1e-13.
const HALVINGS: usize = 44;

/// A parameter over its range.
#[derive(Clone, Debug)]
struct Axis {
    range: Range,
    /// Its ends in SI.
    in_si: [f64; 2],
    /// Its values in the unit that the parameter is declared with.
    values: Vec<f64>,
}

impl Axis {
    /// The value in SI at a place.
    fn in_si(&self, place: f64) -> f64 {
        let [from, to] = self.in_si;
        let last = self.values.len().saturating_sub(1).max(1) as f64;
        from + (to - from) * (place / last)
    }

    /// The value at a place, in the unit that the parameter is declared with.
    fn value(&self, place: f64) -> f64 {
        let share = place.fract();
        let [from, to] = [place, place.ceil()].map(|at| self.values.get(at as usize).copied().unwrap_or(f64::NAN));
        if share == 0.0 { from } else { from + (to - from) * share }
    }
}

/// What a driven model does at one place of a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Place {
    /// Whether no multiplier is outside the unit circle; `None` where there is no periodic motion, and where motions may grow as powers
    /// of the time.
    pub stable: Option<bool>,
    /// ln max |multiplier| / period, in 1/s; 0 where all are on the unit circle but for rounding.
    pub growth_rate: f64,
}

/// A place of a border: where along one axis stable and unstable meet.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Border {
    /// The values of both parameters, in the units that they are declared with.
    pub at: [f64; 2],
}

/// A model over a grid of two parameters.
#[derive(Clone, Debug)]
pub struct Chart {
    axes: [Axis; 2],
    units: [Option<String>; 2],
    has_units: bool,
    equations: Equations,
    /// The period, then the place where a search begins.
    start: Prepared<f64>,
    damped: bool,
}

/// The work space of one thread.
#[derive(Clone, Debug)]
pub struct Worker<'a> {
    chart: &'a Chart,
    single: Plain,
    several: Plain<Lane>,
    scratch: Vec<f64>,
}

impl Chart {
    /// Derives the equations with two parameters open.
    ///
    /// # Errors
    /// As [`floquet::floquet`], and where a parameter does not exist, sets a range of an index, is defined from others or is
    /// named twice, or there are too many places.
    pub fn new(source: &Source, ranges: [Range; 2]) -> Result<Self, Error> {
        let bad = |range: &Range, reason: &str| {
            Error::from(ModelError::BadSetting { text: range.name().to_owned(), reason: reason.to_owned() })
        };
        if ranges[0].name() == ranges[1].name() {
            return Err(bad(&ranges[1], "a chart has two different parameters"));
        }
        if ranges[0].len().saturating_mul(ranges[1].len()) > MOST_PLACES {
            return Err(bad(&ranges[0], "a chart has at most 10000000 places"));
        }
        let ends = |place: &dyn Fn(&Range) -> String| -> Result<Model, Error> {
            let settings = source.settings_with(&[&place(&ranges[0]), &place(&ranges[1])])?;
            Ok(linearize::integrated(&model::elaborate(&source.file, &source.tables, &settings)?).into_owned())
        };
        let model = ends(&Range::first)?;
        let other = ends(&Range::last)?;
        let mut numbers = Vec::new();
        let mut axes = Vec::new();
        for range in &ranges {
            let of = |model: &Model| {
                let number = source::parameter(model, range)?;
                let value = linearize::constant(&model.pool, model.parameters[number].value?)?;
                Some((number, value.mid_f64()))
            };
            let (Some((number, from)), Some((_, to))) = (of(&model), of(&other)) else {
                return Err(bad(range, "a chart needs a parameter with a value"));
            };
            let parameter = &model.parameters[number];
            let own = model.pool.symbols_of(&[parameter.symbolic]);
            if !own.contains(&parameter.symbol) {
                let reason = "it sets a range or is defined from others, and a chart can't vary it";
                return Err(bad(range, reason));
            }
            numbers.push(number);
            let values = (0..range.len()).map(|place| range.value(place).unwrap_or(f64::NAN)).collect();
            axes.push(Axis { range: range.clone(), in_si: [from, to], values });
        }
        let [first, second] = [axes.remove(0), axes.remove(0)];
        let mut driven = Driven::new(&model, &numbers)?;
        let roots = driven.expressions();
        let (time, period) = (driven.time, driven.period.0);
        if trial::repeats(&mut driven.pool, time, period, &roots).is_none() {
            floquet::try_period(&model)?;
            floquet::try_period(&other)?;
        }
        let begin = floquet::begin(&model, &mut driven);
        let (mut driven, begin) = driven.along_constraints(&model, begin)?;
        if driven.tied.is_some() {
            let span = model.constraints.first().map_or(driven.driven_at, |own| own.span);
            return Err(FloquetError::Unsupported { what: "constraints in charts, about what moves", span }.into());
        }
        let (equations, _) = floquet::equations(&model, &mut driven, &begin)?;
        let roots = [&[driven.period.0], begin.as_slice()].concat();
        let start = Tape::compile(&driven.pool, &roots, &driven.open)
            .map_err(|_| FloquetError::NotDefined { span: driven.driven_at })?;
        let units = [&first, &second].map(|axis| source::unit_of(&source.file, axis.range.name()));
        Ok(Self {
            axes: [first, second],
            units,
            has_units: model.has_units,
            equations,
            start: start.prepare(()),
            damped: driven.damped.contains(&true),
        })
    }

    /// The names of the parameters.
    #[must_use]
    pub fn names(&self) -> [&str; 2] {
        [self.axes[0].range.name(), self.axes[1].range.name()]
    }

    /// The units that the parameters are declared with, as they are written.
    #[must_use]
    pub fn units(&self) -> [Option<&str>; 2] {
        self.units.each_ref().map(Option::as_deref)
    }

    /// Whether growth is a number in 1/s.
    #[must_use]
    pub fn has_units(&self) -> bool {
        self.has_units
    }

    /// The number of places along each parameter.
    #[must_use]
    pub fn len(&self) -> [usize; 2] {
        [self.axes[0].range.len(), self.axes[1].range.len()]
    }

    /// The values along a parameter (0 or 1), in the unit that it is declared with.
    #[must_use]
    pub fn values(&self, axis: usize) -> Vec<f64> {
        self.axes.get(axis).map_or_else(Vec::new, |own| own.values.clone())
    }

    /// A work space for one thread.
    #[must_use]
    pub fn worker(&self) -> Worker<'_> {
        Worker {
            chart: self,
            single: Plain::new(&self.equations),
            several: Plain::new(&self.equations),
            scratch: Vec::new(),
        }
    }

    /// What the derivative of the state after a period tells; `None` where it is no number.
    fn judged(&self, slopes: &[f64], period: f64) -> Option<Place> {
        let (size, grows, drifts) = if let [a, b, c, d] = *slopes {
            // Trace and determinant tell all.
            let half = 0.5 * (a + d);
            let product = if self.damped { a * d - b * c } else { 1.0 };
            let square = half * half - product;
            let size = if square > 0.0 { half.abs() + square.sqrt() } else { product.max(0.0).sqrt() };
            // A damper may have no strength at the place.
            let damped = (product - 1.0).abs() > FINE;
            // |z| > 1 for a real z exactly where the characteristic polynomial changes its sign at 1 or -1.
            let grows = if damped { size > 1.0 + FINE } else { half.abs() > 1.0 + FINE };
            // Both 1 or both -1 without two vectors of their own.
            let meet = (half.abs() - 1.0).abs() <= FINE;
            let drifts = !damped && meet && (b / period).abs().max((c * period).abs()) > COARSE;
            let is_conserved = !damped && !grows && size.is_finite();
            (if is_conserved { 1.0 } else { size }, grows, drifts)
        } else {
            let n = self.equations.dimension();
            let matrix = DMatrix::from_row_slice(n, n, slopes);
            let schur = nalgebra::Schur::try_new(matrix.clone(), f64::EPSILON, 10_000)?;
            let values = schur.complex_eigenvalues();
            let size = values.iter().map(|z| z.norm()).fold(0.0, f64::max);
            let grows = size > 1.0 + COARSE;
            let size = if self.damped || grows { size } else { 1.0 };
            (size, grows, lack_vectors(&matrix, values.as_slice(), period))
        };
        if !size.is_finite() {
            return None;
        }
        // Where motions grow with the time it is neither.
        Some(Place { stable: (!drifts).then_some(!grows), growth_rate: size.ln() / period })
    }
}

impl Worker<'_> {
    /// One row of a chart: the second parameter runs, the first one stays.
    pub fn row(&mut self, first: usize) -> Vec<Place> {
        let places = 0..self.chart.axes[1].range.len();
        let places: Vec<[f64; 2]> = places.map(|second| [first as f64, second as f64]).collect();
        self.places(&places)
    }

    /// The borders between neighbours of a row, and between it and the next one, each to 1e-13 of the distance of
    /// neighbours, rounding of the multipliers aside; `rows` are that row and, if there is one, the next.
    pub fn borders(&mut self, first: usize, rows: [Option<&[Place]>; 2]) -> Vec<Border> {
        let Some(own) = rows[0] else { return Vec::new() };
        let mut found = Vec::new();
        for second in 0..own.len() {
            let here = own[second].stable;
            let mut meet = |there: Option<&Place>, step: [f64; 2]| {
                let there = there.and_then(|there| there.stable);
                if let (Some(here), Some(there)) = (here, there)
                    && here != there
                {
                    found.push(Search { from: [first as f64, second as f64], step, here, low: 0.0, high: 1.0 });
                }
            };
            meet(own.get(second + 1), [0.0, 1.0]);
            meet(rows[1].and_then(|next| next.get(second)), [1.0, 0.0]);
        }
        for _ in 0..HALVINGS {
            let middles: Vec<[f64; 2]> = found.iter().map(Search::middle).collect();
            for (search, place) in found.iter_mut().zip(self.places(&middles)) {
                let middle = 0.5 * (search.low + search.high);
                if place.stable == Some(search.here) {
                    search.low = middle;
                } else {
                    search.high = middle;
                }
            }
        }
        let [a, b] = &self.chart.axes;
        let places = found.iter().map(Search::middle);
        places.map(|[first, second]| Border { at: [a.value(first), b.value(second)] }).collect()
    }

    /// What the model does at places between the first and the last of both ranges.
    fn places(&mut self, places: &[[f64; 2]]) -> Vec<Place> {
        let found = places.chunks(LANES).flat_map(|group| {
            let together = if group.len() > 1 { self.together(group) } else { None };
            together.unwrap_or_else(|| group.iter().map(|place| self.alone(*place)).collect())
        });
        found.collect()
    }

    /// `None` where there is no period.
    fn start(&mut self, place: [f64; 2]) -> Option<Start> {
        let [first, second] = &self.chart.axes;
        let values = [first.in_si(place[0]), second.in_si(place[1])];
        let mut state = self.chart.start.evaluate(&values, &mut self.scratch);
        if state.is_empty() {
            return None;
        }
        let period = state.remove(0);
        (period > 0.0 && period.is_finite()).then_some(Start { values, period, state })
    }

    fn alone(&mut self, place: [f64; 2]) -> Place {
        let found = self.start(place).and_then(|Start { values, period, state }| {
            self.single.set_parameters(&values);
            let slopes = if self.chart.equations.is_moving() {
                let start = floquet::repeating(&mut self.single, period, &state, SEARCH)?;
                self.single.travel(0.0, period, &start, |_, _, _| {})?.1
            } else {
                monodromy(&mut self.single, period, None)?
            };
            self.chart.judged(&slopes, period)
        });
        found.unwrap_or(Place { stable: None, growth_rate: f64::NAN })
    }

    /// As many places as there are lanes; `None` where one of them has no periodic motion or is not found beside the
    /// others.
    fn together(&mut self, places: &[[f64; 2]]) -> Option<Vec<Place>> {
        let last = places.len().checked_sub(1)?;
        let starts: Option<Vec<_>> = places.iter().map(|place| self.start(*place)).collect();
        let starts = starts?;
        // Lanes without a place do what the last one does.
        let lanes = |of: &dyn Fn(usize) -> f64| Lane::each(|lane| of(lane.min(last)));
        let values = [0, 1].map(|axis| lanes(&|at| starts[at].values[axis]));
        self.several.set_parameters(&values);
        let period = lanes(&|at| starts[at].period);
        let start = self.chart.equations.is_moving().then(|| {
            let components = 0..starts[0].state.len();
            components.map(|i| lanes(&|at| starts[at].state[i])).collect::<Vec<Lane>>()
        });
        let slopes = monodromy(&mut self.several, period, start)?;
        let found = (0..places.len()).map(|at| {
            let own: Vec<f64> = slopes.iter().map(|slope| slope.one(at)).collect();
            self.chart.judged(&own, starts[at].period)
        });
        found.collect()
    }
}

/// What a place begins with.
struct Start {
    /// The parameters.
    values: [f64; 2],
    period: f64,
    /// Where a search for the motion begins.
    state: Vec<f64>,
}

/// A border between two neighbours that is being searched for.
struct Search {
    from: [f64; 2],
    step: [f64; 2],
    /// Whether it is stable at the first one.
    here: bool,
    /// Shares of the step.
    low: f64,
    high: f64,
}

impl Search {
    fn middle(&self) -> [f64; 2] {
        let share = 0.5 * (self.low + self.high);
        [0, 1].map(|axis| self.from[axis] + share * self.step[axis])
    }
}

/// The derivative of the state after a period by the initial one: about a state that rests, or about the periodic motion near
/// one.
fn monodromy<N: Doubles>(plain: &mut Plain<N>, period: N, start: Option<Vec<N>>) -> Option<Vec<N>> {
    let zero = N::each(|_| 0.0);
    let Some(mut x) = start else { return Some(plain.travel(zero, period, &[], |_, _, _| {})?.1) };
    let n = x.len();
    plain.set_most_steps(usize::MAX);
    for _ in 0..NEWTON {
        let mut steps = 0;
        let (end, slopes) = plain.travel(zero, period, &x, |_, _, _| steps += 1)?;
        // One that takes that much longer has gone astray.
        plain.set_most_steps(ASTRAY * (steps + 10));
        let mut settled = true;
        let mut steps = Vec::with_capacity(N::COUNT);
        for at in 0..N::COUNT {
            let own = DVector::from_iterator(n, x.iter().map(|x| x.one(at)));
            let away = DVector::from_iterator(n, end.iter().map(|x| x.one(at))) - &own;
            let slopes = slopes.iter().map(|slope| slope.one(at));
            let matrix = DMatrix::from_row_iterator(n, n, slopes) - DMatrix::identity(n, n);
            let step = matrix.lu().solve(&away)?;
            settled &= step.norm() <= 1e-12 * (own - &step).norm().max(1e-6);
            steps.push(step);
        }
        for (i, x) in x.iter_mut().enumerate() {
            *x = x.sub(&N::each(|at| steps[at][i]));
        }
        if settled {
            return Some(plain.travel(zero, period, &x, |_, _, _| {})?.1);
        }
    }
    None
}

/// Whether more multipliers are 1 or -1 than there are vectors of theirs, so that motions grow with the time, as the centre of mass may.
fn lack_vectors(matrix: &DMatrix<f64>, values: &[Complex<f64>], period: f64) -> bool {
    let n = matrix.nrows();
    // Velocities as ways in a period.
    let unit = |i: usize| if i < n / 2 { 1.0 } else { period };
    let scaled = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] * unit(i) / unit(j));
    [1.0, -1.0].into_iter().any(|own| {
        let times = values.iter().filter(|z| (*z - own).norm() < COARSE.sqrt()).count();
        let lengths = || (&scaled - DMatrix::identity(n, n) * own).singular_values();
        times > 1 && lengths().iter().filter(|length| **length < COARSE * scaled.norm()).count() < times
    })
}
