//! Why a number is none: the divisor that is zero, the root of something negative.
//!
//! Only messages need it. The term is evaluated once more, every part of it, for the instance that
//! went wrong; parts stand in an order in which the first one without a value is to blame.

use std::collections::HashMap;

use super::assemble::{Assembly, ElementFamily, Part, Values, evaluate_closed};
use super::equilibrium::short;
use super::error::{GIVEN_VALUE, LinearizeError};
use crate::expr::{ExprId, Function, Node, Pool, Substitution, Symbol, Tape, function_name};
use crate::model::{Given, Model, SymbolKind};
use crate::number::Number;
use crate::precision::Ball;

/// Longer expressions are not quoted in messages.
const MOST_QUOTED: usize = 60;

/// So many values are listed in a message.
const MOST_LISTED: usize = 6;

/// Parameters defined through parameters are followed so far.
const MOST_DEFINITIONS: usize = 100;

impl Assembly {
    /// The first term whose numbers at a point are not finite, as an error.
    pub(super) fn not_finite(
        &self,
        model: &Model,
        at: &[Ball],
        values: &Values<Ball>,
        what: &str,
    ) -> Option<LinearizeError> {
        let mut place: Option<(&ElementFamily, usize)> = None;
        for part in [Part::Inertia, Part::Stiffness] {
            self.run(part, at, values, |family, instance, numbers| {
                if place.is_none() && !numbers.iter().all(Ball::is_finite) {
                    place = Some((family, instance));
                }
            });
        }
        let (family, instance) = place?;
        Some(LinearizeError::NotFinite {
            what: what.to_owned(),
            point: point_text(model, at),
            cause: cause(model, family, instance, at, values),
            span: family.span,
        })
    }
}

/// The point in words, for messages.
pub(super) fn point_text(model: &Model, at: &[Ball]) -> String {
    let coordinates = model.coordinates.iter().zip(at);
    let mut parts: Vec<String> = coordinates
        .take(MOST_LISTED)
        .map(|(coordinate, value)| format!("{} = {}", coordinate.name, short(value.mid_f64())))
        .collect();
    if at.len() > MOST_LISTED {
        parts.push("…".to_owned());
    }
    parts.join(", ")
}

/// A `guess` or `equilibrium` that comes to no number, as an error.
pub(super) fn given_not_finite(model: &Model, given: &Given) -> LinearizeError {
    let mut scene = Scene {
        model,
        pool: model.pool.clone(),
        numbers: HashMap::new(),
        names: Substitution::default(),
    };
    LinearizeError::NotFinite {
        what: GIVEN_VALUE.to_owned(),
        point: "these parameters".to_owned(),
        cause: scene.cause(&[given.symbolic]),
        span: given.span,
    }
}

fn cause(
    model: &Model,
    family: &ElementFamily,
    instance: usize,
    at: &[Ball],
    values: &Values<Ball>,
) -> Option<String> {
    let mut scene = Scene {
        model,
        pool: model.pool.clone(),
        numbers: HashMap::new(),
        names: Substitution::default(),
    };
    let coordinates = family.terms.coordinates_of(instance);
    for (local, number) in family.terms.locals.iter().zip(coordinates) {
        let number = *number as usize;
        scene.numbers.insert(local.coordinate, *at.get(number)?);
        scene.numbers.insert(local.velocity, Ball::ZERO);
        let name = scene
            .pool
            .symbol_expr(model.coordinates.get(number)?.symbol);
        scene.names.insert(local.coordinate, name);
    }
    let constants = family.terms.constants_of(instance);
    let numbers = family.constants_of(instance);
    for (at, symbol) in family.terms.values.iter().enumerate() {
        scene.names.insert(*symbol, *constants.get(at)?);
        let number = values.constants.get(*numbers.get(at)? as usize)?;
        scene.numbers.insert(*symbol, *number);
    }
    if let Some(cause) = scene.cause(&[family.terms.body]) {
        return Some(cause);
    }
    let elements = family.inertia.iter().chain(&family.potential);
    let derivatives: Vec<ExprId> = elements.flat_map(|element| element.entries()).collect();
    let cause = scene.cause(&derivatives)?;
    Some(format!("in a derivative, {cause}"))
}

/// One instance of a term: what its symbols are called and what they come to.
struct Scene<'a> {
    model: &'a Model,
    pool: Pool,
    numbers: HashMap<Symbol, Ball>,
    names: Substitution,
}

impl Scene<'_> {
    /// What makes one of the expressions undefined, if any is.
    fn cause(&mut self, roots: &[ExprId]) -> Option<String> {
        let mut roots = roots.to_vec();
        let mut through = String::new();
        for _ in 0..MOST_DEFINITIONS {
            let parts = self.pool.reachable(&roots);
            let numbers = self.evaluate(&parts)?;
            let value = |e: ExprId| Some(numbers[parts.binary_search(&e).ok()?]);
            let at = numbers.iter().position(|number| !number.is_finite())?;
            let Node::Symbol(symbol) = *self.pool.node(parts[at]) else {
                let (said, blamed) = self.describe(parts[at], &value)?;
                let advice = if self.moves(blamed) {
                    "; another point is given with `guess`"
                } else {
                    ""
                };
                return Some(format!("{through}{said}{advice}"));
            };
            // A parameter defined through others: one of those, or its definition, is to blame.
            let symbol = match self.names.get(&symbol) {
                Some(name) => self.pool.as_symbol(*name)?,
                None => symbol,
            };
            let Some(SymbolKind::Parameter(number)) = self.model.symbols.get(&symbol) else {
                return None;
            };
            let parameter = self.model.parameters.get(*number)?;
            if self.pool.as_symbol(parameter.symbolic) == Some(symbol) {
                return Some(format!(
                    "{through}the value of `{}` is no number",
                    parameter.name
                ));
            }
            through = format!("`{}` has no value: ", parameter.name);
            roots = vec![parameter.symbolic];
        }
        None
    }

    fn evaluate(&self, parts: &[ExprId]) -> Option<Vec<Ball>> {
        let symbols = self.pool.symbols_of(parts);
        let inputs: Option<Vec<Ball>> = symbols.iter().map(|symbol| self.number(*symbol)).collect();
        let tape = Tape::compile(&self.pool, parts, &symbols).ok()?;
        Some(tape.evaluate(&inputs?, &mut Vec::new()))
    }

    fn number(&self, symbol: Symbol) -> Option<Ball> {
        if let Some(number) = self.numbers.get(&symbol) {
            return Some(*number);
        }
        match self.model.symbols.get(&symbol)? {
            SymbolKind::Parameter(number) => evaluate_closed(
                &self.model.pool,
                self.model.parameters.get(*number)?.value?,
                (),
            ),
            _ => None,
        }
    }

    /// What is wrong with a part whose own parts are all numbers, and the expression to blame.
    fn describe(
        &mut self,
        part: ExprId,
        value: &dyn Fn(ExprId) -> Option<Ball>,
    ) -> Option<(String, ExprId)> {
        match self.pool.node(part).clone() {
            Node::Product(factors) => {
                for (base, exponent) in &factors {
                    let number = value(*base)?;
                    if exponent.is_negative() && number.contains_zero() {
                        let divisor = self.pool.powr(*base, &exponent.abs());
                        let given = self.given(divisor);
                        let said = match self.quoted(divisor) {
                            Some(text) => format!("the divisor {text} is 0{given}"),
                            None => format!("a divisor is 0{given}"),
                        };
                        return Some((said, *base));
                    }
                    if !exponent.is_integer() && number.is_negative() {
                        let square = exponent.abs() == Number::half();
                        let power = if square { "square root" } else { "power" };
                        return Some((self.taken_of(power, *base, number), *base));
                    }
                }
                Some((self.too_large(part), part))
            }
            Node::Function(Function::Exp | Function::Sinh | Function::Cosh, _)
            | Node::Sum { .. } => Some((self.too_large(part), part)),
            Node::Function(function, x) => {
                let values = self.with_values(x, value(x)?);
                let name = function_name(function);
                let argument = self.quoted(x).unwrap_or_default();
                let call = match argument.trim_matches('`') {
                    "" => format!("`{name}`"),
                    argument => format!("`{name}({argument})`"),
                };
                let said = format!("{call} is not defined where the argument is {values}");
                Some((said, x))
            }
            Node::Power { base, exponent: _ } => {
                let number = value(base)?;
                if number.is_positive() {
                    return Some((self.too_large(part), part));
                }
                Some((self.taken_of("power", base, number), base))
            }
            Node::Atan2 { y, x } => {
                let (y, x) = (self.quoted(y)?, self.quoted(x)?);
                let said = format!("`atan2` is not defined where both {y} and {x} are 0");
                Some((said, part))
            }
            Node::Number(_) | Node::Pi | Node::Symbol(_) | Node::Undefined => None,
        }
    }

    /// `the square root of `2 - a` is taken, which is -1 for a = 3`
    fn taken_of(&mut self, power: &str, base: ExprId, number: Ball) -> String {
        let values = self.with_values(base, number);
        match self.quoted(base) {
            Some(text) => format!("the {power} of {text} is taken, which is {values}"),
            None => format!("a {power} of {values} is taken"),
        }
    }

    fn too_large(&mut self, part: ExprId) -> String {
        let given = self.given(part);
        match self.quoted(part) {
            Some(text) => format!("{text} is too large{given}"),
            None => "a number is too large or too small to be calculated with".to_owned(),
        }
    }

    /// Whether an expression depends on a coordinate.
    fn moves(&mut self, e: ExprId) -> bool {
        let e = self.named(e);
        let symbols = self.pool.symbols_of(&[e]);
        symbols.iter().any(|symbol| {
            let kind = self.model.symbols.get(symbol);
            matches!(kind, Some(SymbolKind::Coordinate(_)))
        })
    }

    /// In the names of the file.
    fn named(&mut self, e: ExprId) -> ExprId {
        self.pool.substitute_one(e, &self.names)
    }

    /// The text of an expression, if it is short and shows a name.
    fn quoted(&mut self, e: ExprId) -> Option<String> {
        let e = self.named(e);
        if self.pool.symbols_of(&[e]).is_empty() {
            return None;
        }
        let text = self.pool.display(e);
        (text.chars().count() <= MOST_QUOTED).then(|| format!("`{text}`"))
    }

    /// `-1 for a = 1`, for something that a function or a power is taken of.
    fn with_values(&mut self, e: ExprId, number: Ball) -> String {
        format!("{}{}", short(number.mid_f64()), self.given(e))
    }

    /// ` for a = 1, x = 0`: the values of the names in an expression that is more than a name.
    fn given(&mut self, e: ExprId) -> String {
        let e = self.named(e);
        let alone = self.pool.as_symbol(e).is_some();
        let symbols = self.pool.symbols_of(&[e]);
        if alone || symbols.is_empty() {
            return String::new();
        }
        let mut parts: Vec<String> = Vec::new();
        for symbol in symbols.iter().take(MOST_LISTED) {
            if let Some(number) = self.value_of_name(*symbol) {
                let name = self.pool.symbol_name(*symbol);
                parts.push(format!("{name} = {}", short(number.mid_f64())));
            }
        }
        if symbols.len() > MOST_LISTED {
            parts.push("…".to_owned());
        }
        format!(" for {}", parts.join(", "))
    }

    /// The value of a coordinate or parameter under its own name.
    fn value_of_name(&self, symbol: Symbol) -> Option<Ball> {
        let slot = self
            .names
            .iter()
            .find(|(_, name)| self.pool.as_symbol(**name) == Some(symbol));
        match slot {
            Some((slot, _)) => self.number(*slot),
            None => self.number(symbol),
        }
    }
}
