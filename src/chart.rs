//! Stability charts: whether a driven model is stable, over a grid of two parameters.
//!
//! The equations are derived once, with both parameters open, and followed over a period in plain doubles at each place
//! ([`crate::flow::Plain`]): nothing is parsed or differentiated again. Multipliers have no bounds here; where that counts,
//! [`crate::floquet::floquet`] is asked. Borders between stable and unstable neighbours are found by bisection.
//!
//! It starts no thread and writes nothing: rows are independent of each other, a [`Chart`] is `Sync`, and a [`Worker`]
//! belongs to one thread.

use nalgebra::{DMatrix, DVector};

use crate::error::Error;
use crate::expr::{Prepared, Tape};
use crate::floquet::motion::Driven;
use crate::floquet::{self, FloquetError};
use crate::flow::{Equations, Plain};
use crate::linearize;
use crate::model::{self, Model, ModelError, Settings, TableTexts};
use crate::sweep::Range;
use crate::syntax::File;

/// More places than this are not charted.
pub const MOST_PLACES: usize = 10_000_000;
/// Multipliers this far outside the unit circle count as growth where several are near each other: a double one moves
/// by the root of what is rounded.
const COARSE: f64 = 1e-7;
/// The same where trace and determinant decide: what is rounded on the way over a period. Where multipliers meet at -1
/// without growing, as they do without a drive, they would else be taken apart by it.
const FINE: f64 = 2e-14;
/// Steps of Newton's method to a periodic motion.
const NEWTON: usize = 40;
/// Halvings of an interval: 2^-44 is below 1e-13.
const HALVINGS: usize = 44;

/// A parameter over its range, in SI.
#[derive(Clone, Debug)]
struct Axis {
    range: Range,
    from: f64,
    to: f64,
}

impl Axis {
    fn value(&self, place: f64) -> f64 {
        #[allow(clippy::cast_precision_loss)] // counts are at most a million
        let last = self.range.len().saturating_sub(1).max(1) as f64;
        self.from + (self.to - self.from) * (place / last)
    }
}

/// What a driven model does at one place of a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Place {
    /// Whether no multiplier is outside the unit circle; `None` where there is no periodic motion.
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
    equations: Equations,
    /// The period, then the place where a search begins.
    start: Prepared<f64>,
    damped: bool,
}

/// The work space of one thread.
#[derive(Clone, Debug)]
pub struct Worker<'a> {
    chart: &'a Chart,
    plain: Plain,
    scratch: Vec<f64>,
}

fn model_with(
    file: &File,
    tables: &TableTexts,
    settings: &Settings,
    values: [&str; 2],
) -> Result<Model, Error> {
    let mut settings = settings.clone();
    for value in values {
        settings.add(value)?;
    }
    Ok(model::elaborate(file, tables, &settings)?)
}

impl Chart {
    /// Derives the equations with two parameters open.
    ///
    /// # Errors
    /// As [`floquet::floquet`], and where a parameter does not exist, sets a range of an index, is defined from others or is
    /// named twice, or there are too many places.
    pub fn new(
        file: &File,
        tables: &TableTexts,
        settings: &Settings,
        ranges: [Range; 2],
    ) -> Result<Self, Error> {
        let bad = |range: &Range, reason: &str| {
            Error::from(ModelError::BadSetting {
                text: range.name().to_owned(),
                reason: reason.to_owned(),
            })
        };
        if ranges[0].name() == ranges[1].name() {
            return Err(bad(&ranges[1], "a chart has two different parameters"));
        }
        if ranges[0].len().saturating_mul(ranges[1].len()) > MOST_PLACES {
            return Err(bad(&ranges[0], "a chart has at most 10000000 places"));
        }
        let ends = |place: &dyn Fn(&Range) -> String| {
            let [first, second] = [place(&ranges[0]), place(&ranges[1])];
            model_with(file, tables, settings, [&first, &second])
        };
        let model = ends(&Range::first)?;
        let other = ends(&Range::last)?;
        let mut numbers = Vec::new();
        let mut axes = Vec::new();
        for range in &ranges {
            let of = |model: &Model| {
                let number = model
                    .parameters
                    .iter()
                    .position(|p| p.name == range.name())?;
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
            axes.push(Axis {
                range: range.clone(),
                from,
                to,
            });
        }
        let [first, second] = [axes.remove(0), axes.remove(0)];
        let mut driven = Driven::new(&model, &numbers)?;
        let n = driven.dimension();
        let point = floquet::point(&model, &mut driven);
        let not_defined = FloquetError::NotDefined {
            span: driven.driven_at,
        };
        let equations = if floquet::rests(&model, &mut driven, &point)? {
            let slopes = driven.linear(&point)?;
            Equations::linear(&driven.pool, driven.time, 2 * n, &driven.open, &slopes)
                .map_err(|_| not_defined.clone())?
        } else {
            driven.equations()?
        };
        let mut roots = vec![driven.period.0];
        roots.extend(&point);
        let start = Tape::compile(&driven.pool, &roots, &driven.open).map_err(|_| not_defined)?;
        Ok(Self {
            axes: [first, second],
            equations,
            start: start.prepare(()),
            damped: driven.damped,
        })
    }

    /// The names of the parameters.
    #[must_use]
    pub fn names(&self) -> [&str; 2] {
        [self.axes[0].range.name(), self.axes[1].range.name()]
    }

    /// The number of places along each parameter.
    #[must_use]
    pub fn len(&self) -> [usize; 2] {
        [self.axes[0].range.len(), self.axes[1].range.len()]
    }

    /// Never: each range has at least one place.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len().contains(&0)
    }

    /// The values along a parameter (0 or 1), in the unit that it is declared with.
    #[must_use]
    pub fn values(&self, axis: usize) -> Vec<f64> {
        let Some(own) = self.axes.get(axis) else {
            return Vec::new();
        };
        let (Some(from), Some(to)) = (own.range.value(0), own.range.value(own.range.len() - 1))
        else {
            return Vec::new();
        };
        (0..own.range.len())
            .map(|at| self.declared(axis, from, to, at as f64))
            .collect()
    }

    fn declared(&self, axis: usize, from: f64, to: f64, place: f64) -> f64 {
        #[allow(clippy::cast_precision_loss)] // counts are at most a million
        let last = self.axes[axis].range.len().saturating_sub(1).max(1) as f64;
        from + (to - from) * (place / last)
    }

    /// A work space for one thread.
    #[must_use]
    pub fn worker(&self) -> Worker<'_> {
        Worker {
            chart: self,
            plain: Plain::new(&self.equations),
            scratch: Vec::new(),
        }
    }
}

impl Worker<'_> {
    /// One row of a chart: the second parameter runs, the first one stays.
    pub fn row(&mut self, first: usize) -> Vec<Place> {
        (0..self.chart.axes[1].range.len())
            .map(|second| self.place([first as f64, second as f64]))
            .collect()
    }

    /// The borders between neighbours of a row, and between it and the next one, each to 1e-13 of the distance of
    /// neighbours, rounding of the multipliers aside; `rows` are that row and, if there is one, the next.
    pub fn borders(&mut self, first: usize, rows: [Option<&[Place]>; 2]) -> Vec<Border> {
        let mut found = Vec::new();
        let Some(own) = rows[0] else { return found };
        for second in 0..own.len() {
            let here = own[second].stable;
            let mut meet = |there: Option<&Place>, step: [f64; 2]| {
                let there = there.and_then(|there| there.stable);
                if let (Some(here), Some(there)) = (here, there)
                    && here != there
                {
                    found.push(self.border([first as f64, second as f64], step, here));
                }
            };
            meet(own.get(second + 1), [0.0, 1.0]);
            meet(rows[1].and_then(|next| next.get(second)), [1.0, 0.0]);
        }
        found
    }

    fn border(&mut self, from: [f64; 2], step: [f64; 2], here: bool) -> Border {
        let (mut low, mut high) = (0.0, 1.0);
        let at = |share: f64| [from[0] + share * step[0], from[1] + share * step[1]];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.place(at(middle)).stable == Some(here) {
                low = middle;
            } else {
                high = middle;
            }
        }
        let place = at(0.5 * (low + high));
        let value = |axis: usize| {
            let range = &self.chart.axes[axis].range;
            let ends = (range.value(0), range.value(range.len() - 1));
            match ends {
                (Some(from), Some(to)) => self.chart.declared(axis, from, to, place[axis]),
                _ => f64::NAN,
            }
        };
        Border {
            at: [value(0), value(1)],
        }
    }

    /// What the model does at a place between the first and the last of both ranges.
    fn place(&mut self, place: [f64; 2]) -> Place {
        let chart = self.chart;
        let values = [chart.axes[0].value(place[0]), chart.axes[1].value(place[1])];
        self.plain.set_parameters(&values);
        let start = chart.start.evaluate(&values, &mut self.scratch);
        let found = start.split_first().and_then(|(period, point)| {
            if !(*period > 0.0 && period.is_finite()) {
                return None;
            }
            let slopes = self.monodromy(*period, point)?;
            Some((*period, self.largest(&slopes)?))
        });
        match found {
            Some((period, (size, grows))) => Place {
                stable: Some(!grows),
                growth_rate: if grows || chart.damped {
                    size.ln() / period
                } else {
                    0.0
                },
            },
            None => Place {
                stable: None,
                growth_rate: f64::NAN,
            },
        }
    }

    fn monodromy(&mut self, period: f64, point: &[f64]) -> Option<Vec<f64>> {
        if !self.chart.equations.is_moving() {
            return Some(self.plain.travel(0.0, period, &[], |_, _, _| {})?.1);
        }
        let n = 2 * point.len();
        let mut x = DVector::from_fn(n, |i, _| point.get(i).copied().unwrap_or(0.0));
        for _ in 0..NEWTON {
            let (end, slopes) = self.plain.travel(0.0, period, x.as_slice(), |_, _, _| {})?;
            let away = DVector::from_vec(end) - &x;
            let matrix = DMatrix::from_row_slice(n, n, &slopes) - DMatrix::identity(n, n);
            let step = matrix.lu().solve(&away)?;
            x -= &step;
            if step.norm() <= 1e-12 * x.norm().max(1e-6) {
                return Some(
                    self.plain
                        .travel(0.0, period, x.as_slice(), |_, _, _| {})?
                        .1,
                );
            }
        }
        None
    }

    /// The modulus of the largest multiplier, and whether it is outside the unit circle.
    fn largest(&self, slopes: &[f64]) -> Option<(f64, bool)> {
        if let [a, b, c, d] = slopes {
            let half = 0.5 * (a + d);
            let product = if self.chart.damped {
                a * d - b * c
            } else {
                1.0
            };
            let square = half * half - product;
            let size = if square > 0.0 {
                half.abs() + square.sqrt()
            } else {
                product.max(0.0).sqrt()
            };
            // |z| > 1 for a real z exactly where the characteristic polynomial changes its sign at 1 or -1.
            let grows = if self.chart.damped {
                size > 1.0 + FINE
            } else {
                half.abs() > 1.0 + FINE
            };
            return size.is_finite().then_some((size, grows));
        }
        let n = self.chart.equations.dimension();
        let matrix = DMatrix::from_row_slice(n, n, slopes);
        let schur = nalgebra::Schur::try_new(matrix, f64::EPSILON, 10_000)?;
        let values = schur.complex_eigenvalues();
        let size = values.iter().map(|z| z.norm()).fold(0.0, f64::max);
        size.is_finite().then_some((size, size > 1.0 + COARSE))
    }
}
