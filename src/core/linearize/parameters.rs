//! The parameters in expressions, and their values.

use super::assemble::signed_terms;
use crate::expr::{ExprId, Node, Substitution, Symbol};
use crate::model::{Model, Parameter, SymbolKind};

/// Gives parameters in exponents their exact values.
///
/// The derivatives of x^n with a symbol n are those of exp(n ln x), which are not defined at x = 0;
/// with a number they are. Only numeric work needs that: derivations keep the symbol.
pub(crate) fn put_exponents_in(model: &mut Model) {
    let energies = signed_terms(model).map(|(_, family)| family);
    let bodies: Vec<ExprId> = energies.chain(&model.forces).map(|family| family.body).collect();
    let exponents: Vec<ExprId> = model
        .pool
        .reachable(&bodies)
        .into_iter()
        .filter_map(|id| {
            let Node::Power { exponent, .. } = model.pool.node(id) else {
                return None;
            };
            Some(*exponent)
        })
        .collect();
    if exponents.is_empty() {
        return;
    }
    let mut values = Substitution::default();
    for number in parameters_of(model, &exponents) {
        values.extend(rational_value(model, &model.parameters[number]));
    }
    let bodies = model.pool.substitute(&bodies, &values);
    let families = model.kinetic.iter_mut().chain(&mut model.potential);
    for (family, body) in families.chain(&mut model.forces).zip(bodies) {
        family.body = body;
    }
}

/// The parameters whose values are fractions.
pub(super) fn rational_values(model: &Model) -> Substitution {
    model.parameters.iter().filter_map(|parameter| rational_value(model, parameter)).collect()
}

fn rational_value(model: &Model, parameter: &Parameter) -> Option<(Symbol, ExprId)> {
    let value = parameter.value.filter(|value| model.pool.as_number(*value).is_some())?;
    Some((parameter.symbol, value))
}

/// The values of the parameters that have one.
pub fn known_values(model: &Model) -> Substitution {
    let mut known = Substitution::default();
    for parameter in &model.parameters {
        if let Some(value) = parameter.value {
            known.insert(parameter.symbol, value);
        }
    }
    known
}

/// The parameters in expressions, by number, ascending.
pub(crate) fn parameters_of(model: &Model, roots: &[ExprId]) -> Vec<usize> {
    let mut found: Vec<usize> = model
        .pool
        .symbols_of(roots)
        .iter()
        .filter_map(|symbol| match model.symbols.get(*symbol) {
            Some(SymbolKind::Parameter(number)) => Some(number),
            Some(_) | None => None,
        })
        .collect();
    found.sort_unstable();
    found
}
