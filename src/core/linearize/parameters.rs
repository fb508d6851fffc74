//! The parameters in expressions, and their values.

use super::assemble::{evaluate_closed, signed_terms};
use super::error::LinearizeError;
use super::undefined::without_value;
use crate::expr::{ExprId, Node, Pool, Substitution, Symbol, Tape};
use crate::model::{Model, Parameter, SymbolKind, TermFamily};
use crate::order::Gather;
use crate::precision::Scalar;

/// Gives parameters in exponents their exact values.
///
/// The derivatives of x^n with a symbol n are those of exp(n ln x), which are not defined at x = 0;
/// with a number they are. Only numeric work needs that: derivations keep the symbol.
///
/// # Errors
/// [`LinearizeError::NotFinite`] where an energy or a force has no value for these.
pub(crate) fn put_exponents_in(model: &mut Model) -> Result<Exponents, LinearizeError> {
    let bodies = bodies(model);
    let exponents = exponents_in(model, &bodies);
    if exponents.is_empty() {
        return Ok(Exponents::default());
    }
    let mut parameters = parameters_of(model, &exponents);
    parameters.retain(|number| rational_value(model, &model.parameters[*number]).is_some());
    let own = parameters.iter().filter_map(|number| rational_value(model, &model.parameters[*number]));
    let values: Substitution = own.gather();
    let put_in = model.pool.substitute(&bodies, &values);
    let undefined = |(family, body): &(&TermFamily, &ExprId)| family.count > 0 && model.pool.is_undefined(**body);
    if let Some((family, _)) = all_terms(model).zip(&put_in).find(undefined) {
        return Err(without_value(model, family));
    }
    set_bodies(model, &put_in);
    Ok(Exponents { parameters, bodies })
}

/// Parameters that have become numbers, and what the bodies of all terms were with their symbols.
#[derive(Clone, Debug, Default)]
pub(crate) struct Exponents {
    pub(super) parameters: Vec<usize>,
    pub(super) bodies: Vec<ExprId>,
}

/// All terms of a model, forces behind the energies.
pub fn all_terms(model: &Model) -> impl Iterator<Item = &TermFamily> {
    signed_terms(model).map(|(_, family)| family).chain(&model.forces)
}

/// The bodies of all terms.
pub fn bodies(model: &Model) -> Vec<ExprId> {
    all_terms(model).map(|family| family.body).collect()
}

/// What stands in exponents that are no numbers, in some expressions.
pub fn exponents_in(model: &Model, roots: &[ExprId]) -> Vec<ExprId> {
    let inside = model.pool.reachable(roots).into_iter().filter_map(|id| match model.pool.node(id) {
        Node::Power { exponent, .. } => Some(*exponent),
        _ => None,
    });
    inside.collect()
}

/// Puts in other bodies of all terms, in the same order.
pub(super) fn set_bodies(model: &mut Model, bodies: &[ExprId]) {
    let families = model.kinetic.iter_mut().chain(&mut model.potential);
    for (family, body) in families.chain(&mut model.forces).zip(bodies) {
        family.body = *body;
    }
}

/// A model with those values of parameters put in that are no fractions, as cos(a) for a = π/3 is one; `None` where all are.
pub(super) fn with_values(model: &Model) -> Option<Model> {
    let bodies = bodies(model);
    let is_written = |value: &ExprId| model.pool.as_number(*value).is_none();
    let own = parameters_of(model, &bodies).into_iter().map(|number| &model.parameters[number]);
    let values: Substitution = own.filter_map(|own| Some((own.symbol, own.value.filter(is_written)?))).gather();
    let mut model = if values.is_empty() { return None } else { model.clone() };
    let bodies = model.pool.substitute(&bodies, &values);
    set_bodies(&mut model, &bodies);
    Some(model)
}

/// The parameters whose values are fractions.
pub(super) fn rational_values(model: &Model) -> Substitution {
    model.parameters.iter().filter_map(|parameter| rational_value(model, parameter)).gather()
}

fn rational_value(model: &Model, parameter: &Parameter) -> Option<(Symbol, ExprId)> {
    let value = parameter.value.filter(|value| model.pool.as_number(*value).is_some())?;
    Some((parameter.symbol, value))
}

/// The values of the parameters that have one.
pub fn known_values(model: &Model) -> Substitution {
    model.parameters.iter().filter_map(|own| Some((own.symbol, own.value?))).gather()
}

/// The parameters in expressions, by number, ascending.
pub(crate) fn parameters_of(model: &Model, roots: &[ExprId]) -> Vec<usize> {
    let symbols = model.pool.symbols_of(roots).into_iter();
    let mut found: Vec<usize> = symbols.filter_map(|symbol| model.symbols.parameter(symbol)).collect();
    found.sort_unstable();
    found
}

/// Expressions in the coordinates and parameters of a model, to be evaluated at points.
#[derive(Clone, Debug)]
pub(super) struct Formulas {
    tape: Tape,
    /// What the inputs of the tape are.
    inputs: Vec<SymbolKind>,
}

impl Formulas {
    /// From a pool that builds on the model's; `None` where other symbols are in them.
    pub(super) fn new(model: &Model, pool: &Pool, roots: &[ExprId]) -> Option<Self> {
        let symbols = pool.symbols_of(roots);
        let known = |kind: &SymbolKind| matches!(kind, SymbolKind::Coordinate(_) | SymbolKind::Parameter(_));
        let inputs = symbols.iter().map(|symbol| model.symbols.get(*symbol).filter(known));
        Some(Self { inputs: inputs.collect::<Option<_>>()?, tape: Tape::compile(pool, roots, &symbols).ok()? })
    }

    /// The first parameter in them without a value.
    pub(super) fn missing(&self, model: &Model) -> Option<usize> {
        let missing = |kind: &SymbolKind| match kind {
            SymbolKind::Parameter(number) if model.parameters[*number].value.is_none() => Some(*number),
            _ => None,
        };
        self.inputs.iter().filter_map(missing).min()
    }

    /// Their numbers at a point; `None` where a parameter has no value.
    pub(super) fn at<S: Scalar>(&self, model: &Model, point: &[S], precision: S::Precision) -> Option<Vec<S>> {
        self.at_where(model, point, precision, |_, value| value)
    }

    /// The same with other values of parameters, from their numbers and values.
    pub(super) fn at_where<S: Scalar>(
        &self,
        model: &Model,
        point: &[S],
        precision: S::Precision,
        other: impl Fn(usize, Option<S>) -> Option<S>,
    ) -> Option<Vec<S>> {
        let input = |kind: &SymbolKind| match kind {
            SymbolKind::Coordinate(place) => point.get(*place).cloned(),
            SymbolKind::Parameter(number) => {
                let value = model.parameters.get(*number)?.value;
                other(*number, value.and_then(|value| evaluate_closed(&model.pool, value, precision)))
            }
            _ => None,
        };
        let inputs = self.inputs.iter().map(input).collect::<Option<Vec<S>>>()?;
        Some(self.tape.prepare(precision).evaluate(&inputs, &mut Vec::new()))
    }
}
