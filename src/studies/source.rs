//! What a model is made from, for studies that make it anew at each value of a parameter; and what names and ranges mean in it.

use librate_core::diagnostic::nearest;
use librate_core::expr::{ExprId, Pool, UnboundSymbol};
use librate_core::linearize::{self, LinearizeError, evaluate_closed};
use librate_core::model::{self, Constant, Model, ModelError, Range, Settings, Table, TableTexts};
use librate_core::number::Number;
use librate_core::precision::Enclosure;
use librate_core::span::Span;
use librate_core::syntax::{File, print_unit};

/// What a model is made from.
#[derive(Clone, Debug)]
pub struct Source {
    /// The parsed file.
    pub file: File,
    /// Its tables.
    pub tables: TableTexts,
    /// Values from outside.
    pub settings: Settings,
}

impl Source {
    /// The values from outside with some more.
    pub(crate) fn settings_with(&self, values: &[&str]) -> Result<Settings, ModelError> {
        let mut settings = self.settings.clone();
        values.iter().try_for_each(|value| settings.add(value))?;
        Ok(settings)
    }

    /// The model with a value of a range; `wrong` says what is wrong with it.
    pub(crate) fn model<E>(
        &self,
        range: &Range,
        place: usize,
        wrong: impl FnOnce(Vec<ModelError>) -> E,
    ) -> Result<Model, E>
    where
        E: From<ModelError> + From<LinearizeError>,
    {
        let settings = self.settings_with(&[&format!("{} = {}", range.name(), range.expression(place))])?;
        linearize::check_size(model::coordinate_count(&self.file, &self.tables, &settings))?;
        model::elaborate(&self.file, &self.tables, &settings).map_err(wrong)
    }
}

/// The first of several errors, which are at least one.
pub(crate) fn first<E: From<ModelError>>(mut errors: Vec<ModelError>) -> E {
    errors.swap_remove(0).into()
}

/// The unit that a parameter is declared with, as it is written.
pub(crate) fn unit_of(file: &File, name: &str) -> Option<String> {
    let stem = name.split('[').next().unwrap_or(name).trim();
    let mut bindings = file.statements.iter().flat_map(|statement| statement.kind.parameters());
    let unit = bindings.find(|own| *own.name.text == *stem)?.unit?;
    Some(print_unit(file, unit))
}

/// The number of the parameter that a range is of.
pub(crate) fn parameter(model: &Model, range: &Range) -> Option<usize> {
    let name: String = range.name().split_whitespace().collect();
    model.parameters.iter().position(|own| own.name.replace(' ', "") == name)
}

/// The number of the coordinate of a name; else the one that may have been meant.
pub(crate) fn coordinate(model: &Model, name: &str) -> Result<usize, Option<String>> {
    let name: String = name.split_whitespace().collect();
    let known: Vec<String> = model.coordinates.names().collect();
    let found = known.iter().position(|own| own.replace(' ', "") == name);
    found.ok_or_else(|| nearest(&name, known.iter().map(String::as_str)).map(str::to_owned))
}

/// Names in a message.
pub(crate) fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// Reads a table; the error is a line and what is wrong there.
pub(crate) fn table(text: &str, name: &str) -> Result<Table, (u64, String)> {
    let texts = TableTexts::new().with(name, text);
    Table::read(name, name, Span::default(), Span::default(), &texts).map_err(|error| match error {
        ModelError::BadTable { line, reason, .. } => (line, reason),
        other => (1, other.to_string()),
    })
}

/// That a parameter has no value, which is all that can be open where expressions of a model are compiled.
pub(crate) fn missing(model: &Model, unbound: &UnboundSymbol) -> LinearizeError {
    linearize::missing_value(model, model.symbols.parameter(unbound.symbol).unwrap_or(usize::MAX))
}

/// An end of a range: a closed expression.
#[derive(Clone, Debug)]
pub(crate) struct End {
    pub(crate) pool: Pool,
    pub(crate) value: ExprId,
}

impl End {
    pub(crate) fn rational(&self) -> Option<&Number> {
        self.pool.as_number(self.value)
    }
}

/// The ends of a range as they are written.
pub(crate) fn written_ends(range: &Range) -> Result<[End; 2], ModelError> {
    let end = |place| -> Result<End, ModelError> {
        let constant = Constant::parse(&range.expression(place))?;
        Ok(End { pool: constant.pool().clone(), value: constant.value() })
    };
    Ok([end(0)?, end(range.len() - 1)?])
}

/// How much of a range lies before a place.
pub(crate) fn share(range: &Range, place: usize) -> Option<Number> {
    Number::ratio(place as i64, range.len().saturating_sub(1).max(1) as i64)
}

/// The value at a place of a range with rational ends.
pub(crate) fn rational(ends: &[End; 2], range: &Range, place: usize) -> Option<Number> {
    let [from, to] = [ends[0].rational()?, ends[1].rational()?];
    Some(from.add(&to.sub(from).mul(&share(range, place)?)))
}

/// What is at a share of the way from one end to the other.
pub(crate) fn between<S: Enclosure>(ends: &[End; 2], share: &Number, precision: S::Precision) -> Option<S> {
    let [from, to] = ends;
    let from: S = evaluate_closed(&from.pool, from.value, precision)?;
    let to: S = evaluate_closed(&to.pool, to.value, precision)?;
    Some(from.add(&to.sub(&from).mul(&S::from_number(share, precision))))
}
