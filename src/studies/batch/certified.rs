//! One set of a study with every digit certified: the model at these values, the usual way.

use super::{Study, StudyError};
use librate_core::expr::{ExprId, Pool, Substitution};
use librate_core::linearize::linearize;
use librate_core::model::{Given, Model};
use librate_core::modes::Options;
use librate_core::number::Number;
use librate_core::order::Gather;
use librate_core::oscillation::{NormalModes, normal_modes};

impl Study {
    /// The model with one set of values in place of its own; a value that is no finite number is
    /// left out.
    ///
    /// # Errors
    /// [`StudyError::Length`] where the values are not one set.
    pub fn model_at(&self, set: &[f64]) -> Result<Model, StudyError> {
        if set.len() != self.width() {
            return Err(StudyError::Length { found: set.len(), width: self.width() });
        }
        Ok(self.model_with(set.iter().map(|value| Number::from_f64_exact(*value))))
    }

    /// The model with other values in place of its own.
    pub(crate) fn model_with(&self, set: impl IntoIterator<Item = Option<Number>>) -> Model {
        let mut model = self.model.clone();
        for (number, value) in self.varying.iter().zip(set) {
            model.parameters[*number].value = value.map(|value| model.pool.number(value));
        }
        let own = model.parameters.iter().filter(|own| model.pool.as_symbol(own.symbolic) == Some(own.symbol));
        let values: Substitution = own.filter_map(|own| Some((own.symbol, own.value?))).gather();
        for parameter in &mut model.parameters {
            if model.pool.as_symbol(parameter.symbolic) != Some(parameter.symbol) {
                parameter.value = closed(&mut model.pool, parameter.symbolic, &values);
            }
        }
        for given in [&mut model.guesses, &mut model.guessed_velocities, &mut model.equilibria, &mut model.rates] {
            for (_, given) in given.given_mut() {
                given.value = closed(&mut model.pool, given.symbolic, &values);
            }
        }
        model
    }

    /// The normal modes of one set with every digit certified, as
    /// [`oscillation::normal_modes`](librate_core::oscillation::normal_modes) gives them. About a thousand
    /// times as slow as a set of [`Study::solve`]. An equilibrium that has to be searched for is
    /// searched for from the one that `solve` finds, so that both speak of the same.
    ///
    /// # Errors
    /// [`StudyError::Length`] where the values are not one set, and [`StudyError::Linearize`] where
    /// there are no modes.
    pub fn certified(&self, set: &[f64]) -> Result<NormalModes, StudyError> {
        let mut model = self.model_at(set)?;
        if let Some(start) = &self.compiled.search {
            let solutions = self.solve(set)?;
            let span = model.coordinates.first().map(|own| own.span);
            for at in &start.free {
                let Some(found) = Number::from_f64_exact(solutions.equilibria()[*at]) else { continue };
                let value = model.pool.number(found);
                let given = Given { symbolic: value, value: Some(value), span: span.unwrap_or_default() };
                model.guesses.set(*at, Some(given));
            }
        }
        let linearized = linearize(model)?;
        normal_modes(&linearized, &Options::default()).map_err(|error| StudyError::Linearize { error })
    }
}

/// The value of an expression in the parameters, where they all have one.
fn closed(pool: &mut Pool, symbolic: ExprId, values: &Substitution) -> Option<ExprId> {
    let value = pool.substitute_one(symbolic, values);
    pool.symbols_of(&[value]).is_empty().then_some(value)
}
