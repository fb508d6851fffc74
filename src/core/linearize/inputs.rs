//! Tapes of the body of a family of terms, run for one instance after the other.

use super::assemble::Values;
use super::parameters::parameters_of;
use crate::expr::{ExprId, Pool, Symbol, Tape};
use crate::model::{Model, TermFamily};
use crate::number::Number;
use crate::precision::Scalar;

/// What the tapes of a family get beside the coordinates of an instance.
#[derive(Clone, Debug)]
pub(super) struct Inputs {
    /// Parameters, by number.
    pub(super) parameters: Vec<usize>,
    /// The distinct constants of all instances, by number, one a value slot.
    constants: Vec<u32>,
}

impl Inputs {
    /// For tapes of these expressions.
    pub(super) fn new(model: &Model, roots: &[ExprId], constants: Vec<u32>) -> Self {
        Self { parameters: parameters_of(model, roots), constants }
    }

    /// The same constants with the parameters of other expressions.
    pub(super) fn of_others(&self, model: &Model, roots: &[ExprId]) -> Self {
        Self::new(model, roots, self.constants.clone())
    }

    /// A tape of some of the expressions: every symbol of a body is one of its inputs, as explicit time is refused before.
    pub(super) fn tape(&self, model: &Model, pool: &Pool, terms: &TermFamily, roots: &[ExprId]) -> Option<Tape> {
        let own = terms.locals.iter().map(|local| local.coordinate).chain(terms.values.iter().copied());
        let parameters = self.parameters.iter().map(|number| model.parameters[*number].symbol);
        Tape::compile(pool, roots, &own.chain(parameters).collect::<Vec<Symbol>>()).ok()
    }

    /// Runs a tape for all instances: `scatter` gets the number of each, what comes of it, and whether that is not the same as for
    /// the instance before.
    pub(super) fn run<S: Scalar>(
        &self,
        terms: &TermFamily,
        tape: &Tape,
        at: &[S],
        values: &Values<S>,
        mut scatter: impl FnMut(usize, &[S], bool),
    ) {
        let zero = S::from_number(&Number::ZERO, values.precision());
        let prepared = tape.prepare::<S>(values.precision());
        let width = terms.values.len();
        let mut scratch = Vec::new();
        let mut inputs = vec![zero.clone(); terms.locals.len() + width];
        let parameters = self.parameters.iter().map(|number| values.parameters[*number].as_ref());
        inputs.extend(parameters.map(|value| value.unwrap_or(&zero).clone()));
        let mut out = vec![zero.clone(); tape.outputs()];
        for instance in 0..terms.count {
            let coordinates = terms.coordinates_of(instance).iter();
            let coordinates = coordinates.map(|number| at.get(*number as usize).unwrap_or(&zero));
            let constants = self.constants[instance * width..(instance + 1) * width].iter();
            let constants = constants.map(|number| &values.constants[*number as usize]);
            // The links of a chain at rest are all alike.
            let mut is_new = instance == 0;
            for (input, value) in inputs.iter_mut().zip(coordinates.chain(constants)) {
                if !value.is_same(input) {
                    input.clone_from(value);
                    is_new = true;
                }
            }
            if is_new {
                prepared.evaluate_into(&inputs, &mut scratch, &mut out);
            }
            scatter(instance, &out, is_new);
        }
    }
}
