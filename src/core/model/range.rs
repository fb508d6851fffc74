//! Ranges of values of one quantity, as they are written on the command line.

use super::{Constant, ModelError, Settings};
use crate::expr::evaluate_closed;
use crate::number::Number;
use crate::precision::Ball;

/// More places than this are not swept over.
const MOST_PLACES: usize = 1_000_000;

/// A range of values of one parameter, both ends included: `NAME=a..b:count`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Range {
    name: String,
    from: String,
    to: String,
    count: usize,
}

impl Range {
    /// Reads `NAME=a..b:count`; the name may be a member (`m[2]`), the ends exact constant expressions.
    ///
    /// # Errors
    /// [`ModelError::BadSetting`] with what is wrong.
    ///
    /// ```
    /// use librate::model::Range;
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
        let whole = Number::parse(count.trim()).and_then(|count| count.to_i64());
        let count =
            whole.and_then(|count| usize::try_from(count).ok()).ok_or_else(|| bad("the count is a whole number"))?;
        if !(1..=MOST_PLACES).contains(&count) {
            return Err(bad("the count is a number from 1 to 1000000"));
        }
        let range =
            Self { name: name.trim().to_owned(), from: from.trim().to_owned(), to: to.trim().to_owned(), count };
        // Each end by itself, so that `1) + (2` is none.
        for end in [&range.from, &range.to] {
            Settings::new().add(&format!("{} = {end}", range.name))?;
            let own = Constant::read(end).map_err(|reason| bad(&reason))?;
            let value: Option<Ball> = evaluate_closed(own.pool(), own.value(), ());
            if !value.is_some_and(|value| value.is_finite()) {
                return Err(bad(&format!("`{end}` is not a number, or too large a one")));
            }
        }
        Ok(range)
    }

    /// Reads `NAME=a..b`, whose two ends are all places that it has; a count is allowed.
    ///
    /// # Errors
    /// As [`Range::parse`].
    pub fn parse_ends(text: &str) -> Result<Self, ModelError> {
        let has_count = text.rsplit_once("..").is_some_and(|(_, end)| end.contains(':'));
        let range = if has_count { Self::parse(text) } else { Self::parse(&format!("{text}:2")) };
        range.map(|range| Self { count: range.count.max(2), ..range })
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

    /// With one place more between any two; `None` for one place alone, or too many.
    #[must_use]
    pub fn finer(&self) -> Option<Self> {
        let count = 2 * self.count - 1;
        (self.count > 1 && count < usize::MAX / 4).then(|| Self { count, ..self.clone() })
    }

    /// The setting of the first place.
    pub fn first(&self) -> String {
        format!("{} = {}", self.name, self.from)
    }

    /// The setting of the end.
    pub fn last(&self) -> String {
        format!("{} = {}", self.name, self.to)
    }

    /// The value at a place (from 0), as an exact expression.
    pub fn expression(&self, place: usize) -> String {
        if place == 0 {
            return self.from.clone();
        }
        let Self { from, to, count, .. } = self;
        format!("({from}) + (({to}) - ({from}))*{place}/{}", count - 1)
    }

    /// The value at a place (from 0), rounded to a double; `None` beyond the end.
    #[must_use]
    pub fn value(&self, place: usize) -> Option<f64> {
        if place >= self.count { None } else { Some(constant(&self.expression(place))?.mid_f64()) }
    }
}

/// The number that a constant expression comes to.
fn constant(text: &str) -> Option<Ball> {
    let constant = Constant::parse(text).ok()?;
    evaluate_closed(constant.pool(), constant.value(), ())
}

/// The parts between commas outside brackets, trimmed; none of a blank text.
#[must_use]
pub fn entries(text: &str) -> Vec<&str> {
    let (mut depth, mut first, mut parts) = (0_i32, 0, Vec::new());
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(text[first..at].trim());
                first = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text[first..].trim());
    if parts == [""] { Vec::new() } else { parts }
}
