//! The same model over a range of one parameter.
//!
//! Each place of the range makes the whole trip, with the value put in exactly as `--set` would: certified
//! frequencies, an equilibrium of its own, and as many modes as there are then. For thousands of sets
//! in doubles there is `batch::Study`.

use crate::error::Error;
use crate::linearize::{self, Linearized};
use crate::model::{self, Constant, ModelError, Settings, TableTexts};
use crate::modes::Options;
use crate::oscillation::{self, NormalModes};
use crate::precision::Ball;
use crate::syntax::File;

/// More places than this are not swept over.
pub const MOST_PLACES: usize = 1_000_000;

/// A range of values of one parameter, both ends included: `NAME=a..b:count`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Range {
    name: String,
    from: String,
    to: String,
    count: usize,
}

/// The model at one place of a range.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Place {
    /// The parameter's value as it was put in, in the unit that it is declared with; rounded to a double.
    pub value: f64,
    /// The linearized model and its modes, or why there are none.
    pub result: Result<(Linearized, NormalModes), Error>,
}

impl Range {
    /// Reads `NAME=a..b:count`; the name may be a member (`m[2]`), the ends exact constant expressions.
    ///
    /// # Errors
    /// [`ModelError::BadSetting`] with what is wrong.
    ///
    /// ```
    /// use librate::sweep::Range;
    /// let range = Range::parse("k=0..pi/2:5")?;
    /// assert_eq!((range.name(), range.len()), ("k", 5));
    /// assert!((range.value(4).unwrap() - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    /// assert!(Range::parse("k=1..2").is_err());
    /// # Ok::<(), librate::model::ModelError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, ModelError> {
        let bad = |reason: &str| ModelError::BadSetting { text: text.to_owned(), reason: reason.to_owned() };
        let form = "it has no form of a range, NAME=a..b:count";
        let (name, range) = text.split_once('=').ok_or_else(|| bad(form))?;
        let (ends, count) = range.rsplit_once(':').ok_or_else(|| bad(form))?;
        let (from, to) = ends.split_once("..").ok_or_else(|| bad(form))?;
        let count: usize = count.trim().parse().map_err(|_| bad("the count is a whole number"))?;
        if !(1..=MOST_PLACES).contains(&count) {
            return Err(bad("the count is a number from 1 to 1000000"));
        }
        let range =
            Self { name: name.trim().to_owned(), from: from.trim().to_owned(), to: to.trim().to_owned(), count };
        // Each end by itself, so that `1) + (2` is none.
        for end in [&range.from, &range.to] {
            Settings::new().add(&format!("{} = {end}", range.name))?;
            match constant(end) {
                Some(value) if value.is_finite() => {}
                _ => return Err(bad(&format!("`{end}` is no constant"))),
            }
        }
        Ok(range)
    }

    /// The parameter.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The number of places.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Never: a range has at least one place.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The setting of the first place.
    pub(crate) fn first(&self) -> String {
        format!("{} = {}", self.name, self.from)
    }

    /// The setting of the end.
    pub(crate) fn last(&self) -> String {
        format!("{} = {}", self.name, self.to)
    }

    /// The value at a place (from 0), as an exact expression.
    pub(crate) fn expression(&self, place: usize) -> String {
        if place == 0 {
            return self.from.clone();
        }
        let Self { from, to, count, .. } = self;
        format!("({from}) + (({to}) - ({from}))*{place}/{}", count - 1)
    }

    /// The value at a place (from 0), rounded to a double; `None` beyond the end.
    #[must_use]
    pub fn value(&self, place: usize) -> Option<f64> {
        if place >= self.count {
            return None;
        }
        Some(constant(&self.expression(place))?.mid_f64())
    }
}

/// The number that a constant expression comes to.
fn constant(text: &str) -> Option<Ball> {
    let constant = Constant::parse(text).ok()?;
    linearize::constant(constant.pool(), constant.value())
}

/// The modes at each place of a range, one after the other as they are asked for.
pub fn sweep<'a>(
    file: &'a File,
    tables: &'a TableTexts,
    settings: &'a Settings,
    range: &'a Range,
    options: &'a Options,
) -> impl ExactSizeIterator<Item = Place> + 'a {
    (0..range.count).map(move |place| {
        let solve = || -> Result<(Linearized, NormalModes), Error> {
            let mut settings = settings.clone();
            settings.add(&format!("{} = {}", range.name, range.expression(place)))?;
            linearize::check_size(model::coordinate_count(file, tables, &settings))?;
            let model = model::elaborate(file, tables, &settings)?;
            let linearized = linearize::linearize(model)?;
            let modes = oscillation::normal_modes(&linearized, options)?;
            Ok((linearized, modes))
        };
        Place { value: range.value(place).unwrap_or(f64::NAN), result: solve() }
    })
}
