//! What a model is made from, for studies that make it anew at each value of a parameter.

use librate_core::linearize::{self, LinearizeError};
use librate_core::model::{self, Model, ModelError, Range, Settings, TableTexts};
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
    /// The model with a value of a range.
    pub(crate) fn model<E>(&self, range: &Range, place: usize) -> Result<Model, E>
    where
        E: From<ModelError> + From<LinearizeError>,
    {
        let mut settings = self.settings.clone();
        settings.add(&format!("{} = {}", range.name(), range.expression(place)))?;
        linearize::check_size(model::coordinate_count(&self.file, &self.tables, &settings))?;
        let first = |mut errors: Vec<ModelError>| errors.swap_remove(0);
        Ok(model::elaborate(&self.file, &self.tables, &settings).map_err(first)?)
    }
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
