//! The same model over a range of one parameter: a [`Sweep`].
//!
//! Each place of the range has the modes that the value would have with `--set`: certified frequencies, an equilibrium of its own, and as
//! many modes as there are then. A small model about an equilibrium at which no force acts, whatever the value, is derived once, and
//! most places are then solved in doubles with bounds ([`crate::batch`]): what these do not decide is computed in full.
//!
//! It starts no thread: places are independent of each other, a [`Sweep`] is `Sync`, and a [`Worker`] belongs to one thread.

use std::sync::Arc;

use crate::batch::{self, Outcome, Solution, Solutions, Study};
use crate::error::Error;
use crate::sensitivity;
use crate::source::{End, Source, parameter, rational, share, unit_of, written_ends};
use librate_core::derive;
use librate_core::linearize::{self, Linearized};
use librate_core::model::{Assumption, Model, Range};
use librate_core::modes::{Kind, Options};
use librate_core::oscillation::{self, NormalModes};
use librate_core::precision::{Ball, Scalar};

/// Deriving once does not pay for fewer places, ...
const FEW: usize = 16;
/// ... nor for larger models.
const MOST_COORDINATES: usize = 40;
/// So many places are solved together then.
const BLOCK: usize = 64;

/// The model at one place of a range.
#[derive(Clone, Debug)]
#[non_exhaustive]
#[must_use]
pub struct Place {
    /// The parameter's value as it was put in, in the unit that it is declared with; rounded to a double.
    pub value: f64,
    /// The linearized model and its modes, or why there are none.
    pub result: Result<(Linearized, NormalModes), Error>,
}

/// A model over a range of one parameter.
#[derive(Clone, Debug)]
pub struct Sweep {
    source: Source,
    range: Range,
    options: Options,
    /// The ends of the range as they are written.
    ends: Option<[End; 2]>,
    derived: Option<Arc<Derived>>,
}

/// The model as a function of the parameter.
#[derive(Clone, Debug)]
struct Derived {
    study: Study,
    /// The ends of the range in SI, as enclosures and exactly.
    from: Ball,
    to: Ball,
    ends: [End; 2],
}

impl Sweep {
    /// The modes that `options` ask for, at each place of a range.
    #[must_use]
    pub fn new(source: Source, range: Range, options: Options) -> Self {
        let mut sweep = Self::by_places(source, range, options);
        if sweep.range.len() >= FEW {
            sweep.derived = sweep.derive().map(Arc::new);
        }
        sweep
    }

    /// The same for places that are all solved in full: nothing is derived once.
    pub(crate) fn by_places(source: Source, range: Range, options: Options) -> Self {
        let ends = written_ends(&range).ok();
        Self { source, range, options, ends, derived: None }
    }

    /// The range.
    #[must_use]
    pub fn range(&self) -> &Range {
        &self.range
    }

    /// The unit that the parameter is declared with, as it is written.
    #[must_use]
    pub fn unit(&self) -> Option<String> {
        unit_of(&self.source.file, self.range.name())
    }

    /// What is asked of the modes.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The model that most places are solved by, where it is derived once.
    #[must_use]
    pub fn derived(&self) -> Option<&Model> {
        self.derived.as_ref().map(|derived| derived.study.model())
    }

    /// The parameter's value at a place, in the unit that it is declared with; rounded to a double, and no number beyond the end.
    #[must_use]
    pub fn value(&self, place: usize) -> f64 {
        let ends = self.ends.as_ref().filter(|_| place < self.range.len());
        let value = ends.and_then(|ends| rational(ends, &self.range, place));
        let value = value.map(|value| value.to_f64());
        value.or_else(|| self.range.value(place)).unwrap_or(f64::NAN)
    }

    /// The model at a place.
    ///
    /// # Errors
    /// [`Error::Model`] where it can't be one.
    pub fn model(&self, place: usize) -> Result<Model, Error> {
        if let Some(Derived { study, ends, .. }) = self.derived.as_deref()
            && let Some(value) = rational(ends, &self.range, place)
        {
            return Ok(study.model_with([Some(value)]));
        }
        self.source.model(&self.range, place, Error::Model)
    }

    /// The modes at a place, all of them certified.
    pub fn place(&self, place: usize) -> Place {
        let solve = || -> Result<(Linearized, NormalModes), Error> {
            let linearized = derive::linearized(self.model(place)?)?;
            let modes = oscillation::normal_modes(&linearized, &self.options)?;
            Ok((linearized, modes))
        };
        Place { value: self.value(place), result: solve() }
    }

    /// The modes at any value, in the unit that the parameter is declared with; `None` for none that can be written.
    #[must_use]
    pub fn at(&self, value: f64) -> Option<Place> {
        let range = Range::parse(&format!("{}={value:?}..{value:?}:1", self.range.name())).ok()?;
        Some(Self::by_places(self.source.clone(), range, self.options.clone()).place(0))
    }

    /// The modes at a place with the uncertainties of the frequencies, where parameters have some.
    pub fn place_with_uncertainties(&self, place: usize) -> Place {
        let mut place = self.place(place);
        if let Ok((linearized, modes)) = &mut place.result
            && let Err(error) = sensitivity::put_uncertainties(linearized, modes, &self.options)
        {
            place.result = Err(error.into());
        }
        place
    }

    /// The same over as many places and one between any two; `None` where that is too many, or there is a single one.
    pub(crate) fn finer(&self) -> Option<Self> {
        Some(Self { range: self.range.finer()?, ..self.clone() })
    }

    /// The ends of the range in SI.
    #[must_use]
    pub fn ends_si(&self) -> Option<(Ball, Ball)> {
        let end = |place| self.in_si(&self.model(place).ok()?);
        Some((end(0)?, end(self.range.len() - 1)?))
    }

    /// The value that a model was made with, in SI.
    fn in_si(&self, model: &Model) -> Option<Ball> {
        let number = parameter(model, &self.range)?;
        linearize::constant(&model.pool, model.parameters[number].value?)
    }

    /// The model with its parameter open; `None` where it is better solved place by place.
    fn derive(&self) -> Option<Derived> {
        let first = self.model(0).ok()?;
        let last = self.model(self.range.len() - 1).ok()?;
        let number = parameter(&first, &self.range)?;
        let is_assumed = |own: &Assumption| {
            let symbols = first.pool.symbols_of(&[own.left, own.right]);
            symbols.contains(&first.parameters[number].symbol)
        };
        let is_other = first.dissipation.or(first.force).is_some() || first.rates.any();
        // What is assumed of it has to be asked at each place.
        if is_other || first.coordinates.len() > MOST_COORDINATES || first.assumptions.iter().any(is_assumed) {
            return None;
        }
        let (from, to) = (self.in_si(&first)?, self.in_si(&last)?);
        let end = |own: &Model| Some(End { pool: own.pool.clone(), value: own.parameters[number].value? });
        let ends = [end(&first)?, end(&last)?];
        let options = batch::Options::default();
        let options = if self.options.vectors { options } else { options.without_vectors().without_matrices() };
        let study = Study::with_options(first, &[self.range.name()], options).ok()?;
        (study.is_at_rest() && study.is_conservative()).then_some(Derived { study, from, to, ends })
    }

    /// Places that are best solved together.
    #[must_use]
    pub fn blocks<'p>(&self, places: &'p [usize]) -> Vec<&'p [usize]> {
        places.chunks(if self.derived.is_some() { BLOCK } else { 1 }).collect()
    }

    /// For one thread.
    #[must_use]
    pub fn worker(&self) -> Worker<'_> {
        Worker { sweep: self, solutions: Solutions::new() }
    }
}

/// The work space of one thread.
#[derive(Clone, Debug)]
pub struct Worker<'a> {
    sweep: &'a Sweep,
    solutions: Solutions,
}

/// Enclosures of the frequency and the growth of a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enclosed {
    /// Frequency in rad/s.
    pub omega: Ball,
    /// Growth in 1/s.
    pub growth: Ball,
}

/// Enclosures of the exponents of a set, so many at most; nothing where doubles do not decide which mode is what.
fn decided(set: Solution<'_>, lowest: usize) -> Option<Vec<Enclosed>> {
    if set.outcome != Outcome::Solved {
        return None;
    }
    let modes = set.modes().zip(set.omega_squared.iter().zip(set.omega_squared_bounds));
    let modes = modes.take(lowest).map(|(mode, (square, bound))| {
        let root = Ball::exact(square.abs()).with_added_radius(*bound).sqrt();
        match mode.kind {
            Kind::Oscillation => Some(Enclosed { omega: root, growth: Ball::ZERO }),
            Kind::Unstable => Some(Enclosed { omega: Ball::ZERO, growth: root }),
            _ => None,
        }
    });
    modes.collect()
}

impl<'a> Worker<'a> {
    /// What it works on.
    #[must_use]
    pub fn sweep(&self) -> &'a Sweep {
        self.sweep
    }

    /// Enclosures of the exponents at some places, in the order of the modes; nothing for a place where doubles do
    /// not decide which mode is what.
    pub fn enclosed(&mut self, places: &[usize]) -> Vec<Option<Vec<Enclosed>>> {
        self.sets(places).into_iter().map(|own| Some(own?.0)).collect()
    }

    /// The same with what they are made from.
    pub(crate) fn sets(&mut self, places: &[usize]) -> Vec<Option<(Vec<Enclosed>, Solution<'_>)>> {
        let Some(Derived { study, from, to, .. }) = self.sweep.derived.as_deref() else {
            return vec![None; places.len()];
        };
        let way = *to - *from;
        let value = |place: &usize| {
            let share = share(&self.sweep.range, *place);
            share.map_or(Ball::NOT_FINITE, |share| *from + way * Ball::from_number(&share, ()))
        };
        let values: Vec<Ball> = places.iter().map(value).collect();
        let [centres, errors]: [Vec<f64>; 2] =
            [values.iter().map(Ball::mid_f64).collect(), values.iter().map(Ball::mid_f64_error).collect()];
        if study.solve_near(&centres, &errors, &mut self.solutions).is_err() {
            return vec![None; places.len()];
        }
        let lowest = self.sweep.options.lowest.unwrap_or(usize::MAX);
        self.solutions.iter().map(|set| Some((decided(set, lowest)?, set))).collect()
    }
}
