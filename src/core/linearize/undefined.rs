//! Why a number is none: the divisor that is zero, the root of something negative.
//!
//! Only messages need it. The term is evaluated once more, every part of it, for the instance that
//! went wrong; parts stand in an order in which the first one without a value is to blame.

use hashbrown::HashMap;

use super::assemble::{Assembly, ElementFamily, Part, Values, evaluate_closed};
use super::elements::Element;
use super::equilibrium::short;
use super::error::{GIVEN_VALUE, LinearizeError};
use super::parameters::known_values;
use super::symbolic::instance;
use super::units::start;
use super::velocity::VelocityFamily;
use crate::expr::{ExprId, Function, Node, Pool, Substitution, Symbol, Tape};
use crate::model::{Given, Model, TermFamily};
use crate::number::Number;
use crate::precision::{Ball, Big, Scalar};

/// Longer expressions are not quoted in messages.
const MOST_QUOTED: usize = 60;

/// So many values are listed in a message.
const MOST_LISTED: usize = 6;

/// Parameters defined through parameters are followed so far.
const MOST_DEFINITIONS: usize = 100;

/// Numbers beyond the range of doubles are no reason to blame: all is evaluated with so many bits.
const BITS: usize = 192;

/// What terms with velocities give.
const FRICTION: &str = "a matrix of gyroscopic forces or friction";

/// Where a term is evaluated.
enum Point<'a> {
    Numbers(&'a [Ball]),
    Expressions(&'a [ExprId]),
}

/// A term that has no value at a point.
struct Undefined<'a> {
    what: &'a str,
    terms: &'a TermFamily,
    instance: usize,
    /// What is to blame, where the term itself has a value.
    derivatives: Vec<ExprId>,
}

impl Assembly {
    /// The first term whose numbers at a point are not finite, as an error.
    pub(super) fn not_finite(
        &self,
        model: &Model,
        at: &[Ball],
        values: &Values<Ball>,
        what: &str,
    ) -> Option<LinearizeError> {
        let wide = values.wide(at);
        let undefined = wide.and_then(|(at, wide)| self.first_undefined(&at, wide, what));
        // What is a number may still be none of balls.
        let undefined = undefined.or_else(|| self.first_undefined(at, values, what));
        undefined?.error(model, model.pool.clone(), &Point::Numbers(at))
    }

    fn first_undefined<'a, S: Scalar>(&'a self, at: &[S], values: &Values<S>, what: &'a str) -> Option<Undefined<'a>> {
        let mut place: Option<(&ElementFamily, usize)> = None;
        for part in [Part::Force, Part::Inertia, Part::Stiffness] {
            self.run(part, at, values, |family, instance, numbers, _| {
                if place.is_none() && !numbers.iter().all(S::is_finite) {
                    place = Some((family, instance));
                }
            });
        }
        match place {
            Some((family, instance)) => Some(Undefined::of_energy(family, instance, what)),
            None => self.velocity.iter().find_map(|family| {
                let instance = family.not_finite(at, values)?;
                Some(Undefined::of_velocities(family, instance))
            }),
        }
    }

    /// The first term that has no value at a point of expressions, as an error.
    pub(super) fn undefined_in_symbols(&self, model: &Model, point: &[ExprId]) -> Option<LinearizeError> {
        let mut pool = model.pool.clone();
        let place = self.instances().find_map(|(family, at)| {
            let map = instance(model, &mut pool, &family.terms, at, Some(point));
            let logarithms = pool.substitute(&family.logarithms, &map);
            let forceless = family.potential.iter().any(|element| element.has_no_force_at(&mut pool, &map));
            let mut elements = family.potential.iter().chain(&family.inertia);
            let what = if forceless {
                "the force"
            } else if elements.any(|element| element.is_undefined_at(&mut pool, &map)) {
                "a second derivative of the energies"
            } else if logarithms.iter().any(|e| pool.is_undefined(*e)) {
                "the energy"
            } else {
                return None;
            };
            Some(Undefined::of_energy(family, at, what))
        });
        let mut velocities =
            self.velocity.iter().flat_map(|family| (0..family.terms.count).map(move |at| (family, at)));
        let place = place.or_else(|| {
            velocities.find_map(|(family, at)| {
                let map = instance(model, &mut pool, &family.terms, at, Some(point));
                let images = pool.substitute(&family.derivatives.expressions(), &map);
                images.iter().any(|e| pool.is_undefined(*e)).then(|| Undefined::of_velocities(family, at))
            })
        });
        place?.error(model, pool, &Point::Expressions(point))
    }
}

/// That a term has no value anywhere for the values of the parameters.
pub(super) fn without_value(model: &Model, terms: &TermFamily) -> LinearizeError {
    let what = if terms.acts_on.is_some() { "the force" } else { "the energy" };
    let point: Vec<Ball> = start(model, ()).unwrap_or_default();
    let undefined = Undefined { what, terms, instance: 0, derivatives: Vec::new() };
    let error = undefined.error(model, model.pool.clone(), &Point::Numbers(&point));
    let point = point_text(model, &point);
    error.unwrap_or(LinearizeError::NotFinite { what: what.to_owned(), point, cause: None, span: terms.span })
}

impl<'a> Undefined<'a> {
    fn of_energy(family: &'a ElementFamily, instance: usize, what: &'a str) -> Self {
        let elements = family.inertia.iter().chain(&family.potential);
        Self { what, terms: &family.terms, instance, derivatives: elements.flat_map(Element::entries).collect() }
    }

    fn of_velocities(family: &'a VelocityFamily, instance: usize) -> Self {
        Self { what: FRICTION, terms: &family.terms, instance, derivatives: family.derivatives.expressions() }
    }

    fn error(&self, model: &Model, pool: Pool, at: &Point<'_>) -> Option<LinearizeError> {
        // Multipliers stand where their constraints do.
        let ties = |span| model.constraints.iter().any(|own| own.span == span);
        let visible = model.coordinates.iter().take_while(|own| !ties(own.span)).count();
        let what = if ties(self.terms.span) { "the constraint" } else { self.what };
        let point = match at {
            Point::Numbers(at) => point_text(model, at.get(..visible).unwrap_or(at)),
            Point::Expressions(at) => {
                let values = at.iter().take(visible).map(|e| pool.display(*e));
                listed(model, values)
            }
        };
        let mut scene = Scene::new(model, pool, self.terms, self.instance, at)?;
        let cause = scene.cause(&[self.terms.body]).or_else(|| {
            let cause = scene.cause(&self.derivatives)?;
            Some(format!("in a derivative, {cause}"))
        });
        Some(LinearizeError::NotFinite { what: what.to_owned(), point, cause, span: self.terms.span })
    }
}

/// The point in words, for messages.
pub(super) fn point_text(model: &Model, at: &[Ball]) -> String {
    listed(model, at.iter().map(|value| short(value.mid_f64())))
}

/// `x = 0, y = 1, …`
fn listed(model: &Model, values: impl Iterator<Item = String>) -> String {
    let mut parts: Vec<String> = Vec::with_capacity(MOST_LISTED + 1);
    for (at, (coordinate, value)) in model.coordinates.iter().zip(values).enumerate() {
        if at == MOST_LISTED {
            parts.push("…".to_owned());
            break;
        }
        // Multipliers of forces have the names of the coordinates that these act on.
        let name = format!("{} = ", coordinate.name());
        if !parts.iter().any(|part| part.starts_with(&name)) {
            parts.push(name + &value);
        }
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
        images: None,
    };
    LinearizeError::NotFinite {
        what: GIVEN_VALUE.to_owned(),
        point: "these parameters".to_owned(),
        cause: scene.cause(&[given.symbolic]),
        span: given.span,
    }
}

/// One instance of a term: what its symbols are called and what they come to.
struct Scene<'a> {
    model: &'a Model,
    pool: Pool,
    numbers: HashMap<Symbol, Big>,
    names: Substitution,
    /// What they come to where that is no number: a point of expressions.
    images: Option<Substitution>,
}

impl<'a> Scene<'a> {
    fn new(model: &'a Model, mut pool: Pool, terms: &TermFamily, at: usize, point: &Point<'_>) -> Option<Self> {
        let (mut numbers, mut names) = (HashMap::new(), Substitution::default());
        let mut images = Substitution::default();
        for (local, number) in terms.locals.iter().zip(terms.coordinates_of(at)) {
            let number = *number as usize;
            let value = match point {
                Point::Numbers(at) => Some(Big::from_ball(at.get(number)?, BITS)),
                Point::Expressions(at) => {
                    let image = *at.get(number)?;
                    images.insert(local.coordinate, image);
                    evaluate_closed(&pool, image, BITS)
                }
            };
            numbers.extend(value.map(|value| (local.coordinate, value)));
            numbers.insert(local.velocity, Big::zero(BITS));
            images.insert(local.velocity, pool.zero());
            let name = pool.symbol_expr(model.coordinates.get(number)?.symbol);
            names.insert(local.coordinate, name);
        }
        let known = known_values(model);
        for (symbol, constant) in terms.values.iter().zip(terms.constants_of(at)) {
            names.insert(*symbol, *constant);
            images.insert(*symbol, *constant);
            let value = pool.substitute_one(*constant, &known);
            let value = evaluate_closed(&pool, value, BITS);
            numbers.extend(value.map(|value| (*symbol, value)));
        }
        Some(Self { model, pool, numbers, names, images: matches!(point, Point::Expressions(_)).then_some(images) })
    }

    /// What makes one of the expressions undefined, if any is.
    fn cause(&mut self, roots: &[ExprId]) -> Option<String> {
        let mut roots = roots.to_vec();
        let mut through = String::new();
        for _ in 0..MOST_DEFINITIONS {
            let parts = self.pool.reachable(&roots);
            let numbers = self.evaluate(&parts)?;
            let value = |e: ExprId| numbers.get(parts.binary_search(&e).ok()?).cloned();
            let undefined = numbers.iter().position(|number| !number.is_finite());
            let too_large = || numbers.iter().position(|own| !own.to_ball().is_finite());
            let at = undefined.or_else(too_large)?;
            let Node::Symbol(symbol) = *self.pool.node(parts[at]) else {
                let (said, blamed) = self.describe(parts[at], &value)?;
                let advice = if self.moves(blamed) { "; another point is given with `guess`" } else { "" };
                return Some(format!("{through}{said}{advice}"));
            };
            // A parameter defined through others: one of those, or its definition, is to blame.
            let symbol = self.names.get(&symbol).map_or(Some(symbol), |name| self.pool.as_symbol(*name))?;
            let parameter = self.model.parameters.get(self.model.symbols.parameter(symbol)?)?;
            if self.pool.as_symbol(parameter.symbolic) == Some(symbol) {
                return Some(format!("{through}the value of `{}` is no number, or beyond all range", parameter.name));
            }
            through = format!("`{}` has no value: ", parameter.name);
            roots = vec![parameter.symbolic];
        }
        None
    }

    fn evaluate(&mut self, parts: &[ExprId]) -> Option<Vec<Big>> {
        if let Some(images) = &self.images {
            // What a symbol leaves open is not to blame.
            let images = self.pool.substitute(parts, images);
            let value = |e: &ExprId| {
                if matches!(self.pool.node(*e), Node::Undefined) {
                    Big::not_finite(BITS)
                } else {
                    evaluate_closed(&self.pool, *e, BITS).unwrap_or_else(|| Big::one(BITS))
                }
            };
            return Some(images.iter().map(value).collect());
        }
        let symbols = self.pool.symbols_of(parts);
        let inputs: Option<Vec<Big>> = symbols.iter().map(|symbol| self.number(*symbol)).collect();
        let tape = Tape::compile(&self.pool, parts, &symbols).ok()?;
        Some(tape.prepare(BITS).evaluate(&inputs?, &mut Vec::new()))
    }

    fn number(&self, symbol: Symbol) -> Option<Big> {
        if let Some(number) = self.numbers.get(&symbol) {
            return Some(number.clone());
        }
        let number = self.model.symbols.parameter(symbol)?;
        evaluate_closed(&self.model.pool, self.model.parameters.get(number)?.value?, BITS)
    }

    /// What is wrong with a part whose own parts are all numbers, and the expression to blame.
    fn describe(&mut self, part: ExprId, value: &dyn Fn(ExprId) -> Option<Big>) -> Option<(String, ExprId)> {
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
            Node::Function(Function::Exp | Function::Sinh | Function::Cosh, _) | Node::Sum { .. } => {
                Some((self.too_large(part), part))
            }
            Node::Function(function, x) => {
                let values = self.with_values(x, value(x)?);
                let name = function.name();
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
    fn taken_of(&mut self, power: &str, base: ExprId, number: Big) -> String {
        let values = self.with_values(base, number);
        match self.quoted(base) {
            Some(text) => format!("the {power} of {text} is taken, which is {values}"),
            None => format!("a {power} of {values} is taken"),
        }
    }

    fn too_large(&mut self, part: ExprId) -> String {
        let given = self.given(part);
        let parts = self.pool.reachable(&[part]);
        let number = self.evaluate(&parts).and_then(|all| all.get(parts.binary_search(&part).ok()?).cloned());
        let size = if number.is_some_and(|own| own.mid_f64().abs() < 1.0) { "small" } else { "large" };
        match self.quoted(part) {
            Some(text) => format!("{text} is too {size}{given}"),
            None => "a number is too large or too small to be calculated with".to_owned(),
        }
    }

    /// Whether an expression depends on a coordinate.
    fn moves(&mut self, e: ExprId) -> bool {
        let e = self.named(e);
        let symbols = self.pool.symbols_of(&[e]);
        symbols.iter().any(|symbol| self.model.symbols.coordinate(*symbol).is_some())
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
    fn with_values(&mut self, e: ExprId, number: Big) -> String {
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
        if parts.is_empty() {
            return String::new();
        }
        if symbols.len() > MOST_LISTED {
            parts.push("…".to_owned());
        }
        format!(" for {}", parts.join(", "))
    }

    /// The value of a coordinate or parameter under its own name.
    fn value_of_name(&self, symbol: Symbol) -> Option<Big> {
        let slot = self.names.iter().find(|(_, name)| self.pool.as_symbol(**name) == Some(symbol));
        self.number(slot.map_or(symbol, |(slot, _)| *slot))
    }
}
