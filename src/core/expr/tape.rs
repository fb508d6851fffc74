//! Expressions compiled to a list of operations, to be evaluated over any [`Scalar`].

use std::sync::Arc;

use thiserror::Error;

use super::{ExprId, Function, Node, Pool, Symbol};
use crate::budget::Budget;
use crate::number::Number;
use crate::order::Order;
use crate::precision::{Big, Scalar};

/// Bits of numbers whose parts are beyond the range of what they come to.
const BEYOND_DOUBLES: usize = 192;

/// A symbol that occurs in a compiled expression and is not among the inputs.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("an expression to be evaluated contains a symbol without a value")]
pub struct UnboundSymbol {
    /// The symbol.
    pub symbol: Symbol,
}

/// One operation; its result goes to the register of its own number.
#[derive(Clone, Debug)]
pub(super) enum Operation {
    Input(usize),
    Constant(usize),
    Pi,
    Sum { constant: Option<usize>, terms: Box<[(usize, Weight)]> },
    Product(Box<[Factor]>),
    Power { base: usize, exponent: usize },
    Function(Function, usize),
    Atan2 { y: usize, x: usize },
    Undefined,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Weight {
    One,
    MinusOne,
    Constant(usize),
}

impl Weight {
    /// A sum, if there is one already, and a term times the weight.
    #[inline]
    pub(super) fn added<S: Scalar>(self, sum: Option<S>, term: &S, constants: &[S]) -> S {
        match (sum, self) {
            (None, Self::One) => term.clone(),
            (None, Self::MinusOne) => term.neg(),
            (None, Self::Constant(at)) => constants[at].mul(term),
            (Some(sum), Self::One) => sum.add(term),
            (Some(sum), Self::MinusOne) => sum.sub(term),
            (Some(sum), Self::Constant(at)) => sum.add(&constants[at].mul(term)),
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Factor {
    pub(super) register: usize,
    /// Whether to divide by it.
    pub(super) divides: bool,
    pub(super) exponent: Exponent,
}

/// The absolute value of an exponent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Exponent {
    One,
    Whole(i32),
    /// So many halves.
    Halves(i32),
    Constant(usize),
}

#[derive(Debug)]
pub(super) struct Code {
    pub(super) operations: Vec<Operation>,
    /// The first one is 1.
    constants: Vec<Number>,
    pub(super) outputs: Vec<usize>,
    /// When it is spent all values are undefined, so that whatever goes on from one to the next ends.
    pub(super) budget: Budget,
}

/// Compiled expressions; cheap to clone.
#[derive(Clone, Debug)]
pub struct Tape {
    code: Arc<Code>,
}

/// A [`Tape`] with its constants converted to one type of number.
#[derive(Clone, Debug)]
pub struct Prepared<S: Scalar> {
    pub(super) code: Arc<Code>,
    pub(super) constants: Vec<S>,
    pub(super) precision: S::Precision,
}

impl Tape {
    /// Compiles the roots as functions of the inputs.
    ///
    /// # Errors
    ///
    /// [`UnboundSymbol`] where a root contains a symbol that is not an input.
    pub fn compile(pool: &Pool, roots: &[ExprId], inputs: &[Symbol]) -> Result<Tape, UnboundSymbol> {
        let reachable = pool.reachable_places(roots);
        let mut order: Vec<(Symbol, usize)> =
            inputs.iter().enumerate().map(|(place, symbol)| (*symbol, place)).collect();
        order.put_in_order();
        let mut constants = vec![Number::ONE];
        let mut constant = |value: &Number| {
            constants.push(value.clone());
            constants.len() - 1
        };
        let mut operations = Vec::with_capacity(reachable.ids.len());
        for id in &reachable.ids {
            operations.push(match pool.node(*id) {
                Node::Number(value) => Operation::Constant(constant(value)),
                Node::Pi => Operation::Pi,
                Node::Symbol(symbol) => {
                    let at = order.partition_point(|(other, _)| other < symbol);
                    match order.get(at) {
                        Some((found, place)) if found == symbol => Operation::Input(*place),
                        Some(_) | None => return Err(UnboundSymbol { symbol: *symbol }),
                    }
                }
                Node::Sum { constant: free, terms } => Operation::Sum {
                    constant: (!free.is_zero()).then(|| constant(free)),
                    terms: terms
                        .iter()
                        .map(|(term, coefficient)| {
                            let weight = match coefficient.to_i64() {
                                Some(1) => Weight::One,
                                Some(-1) => Weight::MinusOne,
                                Some(_) | None => Weight::Constant(constant(coefficient)),
                            };
                            (reachable.place(*term), weight)
                        })
                        .collect(),
                },
                Node::Product(factors) => Operation::Product(
                    factors
                        .iter()
                        .map(|(base, exponent)| Factor {
                            register: reachable.place(*base),
                            divides: exponent.is_negative(),
                            exponent: compile_exponent(&exponent.abs(), &mut constant),
                        })
                        .collect(),
                ),
                Node::Power { base, exponent } => {
                    Operation::Power { base: reachable.place(*base), exponent: reachable.place(*exponent) }
                }
                Node::Function(function, x) => Operation::Function(*function, reachable.place(*x)),
                Node::Atan2 { y, x } => Operation::Atan2 { y: reachable.place(*y), x: reachable.place(*x) },
                Node::Undefined => Operation::Undefined,
            });
        }
        let outputs = roots.iter().map(|root| reachable.place(*root)).collect();
        Ok(Tape { code: Arc::new(Code { operations, constants, outputs, budget: pool.budget().clone() }) })
    }

    /// How many operations an evaluation takes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.code.operations.len()
    }

    /// Whether nothing is compiled.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.code.operations.is_empty()
    }

    /// How many values an evaluation gives: one for each root.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.code.outputs.len()
    }

    /// The tape with its constants converted, for many evaluations at a precision.
    #[must_use]
    pub fn prepare<S: Scalar>(&self, precision: S::Precision) -> Prepared<S> {
        let constants = self.code.constants.iter().map(|number| S::from_number(number, precision)).collect();
        Prepared { code: Arc::clone(&self.code), constants, precision }
    }

    /// The values of the roots. `inputs` are those of the symbols, in the order of
    /// [`Tape::compile`]; `scratch` is memory to work in, of any content. Numbers whose precision has
    /// to be said go through [`Tape::prepare`].
    pub fn evaluate<S: Scalar<Precision = ()>>(&self, inputs: &[S], scratch: &mut Vec<S>) -> Vec<S> {
        self.prepare(()).evaluate(inputs, scratch)
    }
}

fn compile_exponent(magnitude: &Number, constant: &mut impl FnMut(&Number) -> usize) -> Exponent {
    if magnitude.is_one() {
        return Exponent::One;
    }
    match magnitude.small_parts().map(|(n, d)| (i32::try_from(n), d)) {
        Some((Ok(n), 1)) => Exponent::Whole(n),
        Some((Ok(n), 2)) => Exponent::Halves(n),
        Some(_) | None => Exponent::Constant(constant(magnitude)),
    }
}

impl<S: Scalar> Prepared<S> {
    /// How many values an evaluation gives: one for each root.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.code.outputs.len()
    }

    /// The values of the roots; see [`Tape::evaluate`].
    pub fn evaluate(&self, inputs: &[S], scratch: &mut Vec<S>) -> Vec<S> {
        self.run(inputs, scratch);
        self.code.outputs.iter().map(|register| scratch[*register].clone()).collect()
    }

    /// The values of the roots, into `out`, which has one place for each. Allocates nothing once
    /// `scratch` has grown (for scalars that do not allocate themselves).
    pub fn evaluate_into(&self, inputs: &[S], scratch: &mut Vec<S>, out: &mut [S]) {
        self.run(inputs, scratch);
        for (place, register) in out.iter_mut().zip(&self.code.outputs) {
            *place = scratch[*register].clone();
        }
    }

    fn run(&self, inputs: &[S], registers: &mut Vec<S>) {
        registers.clear();
        registers.reserve(self.code.operations.len());
        if self.code.budget.is_spent() {
            registers.resize(self.code.operations.len(), self.undefined());
            return;
        }
        for operation in &self.code.operations {
            let value = self.step(operation, inputs, registers);
            registers.push(value);
        }
    }

    fn step(&self, operation: &Operation, inputs: &[S], registers: &[S]) -> S {
        match operation {
            Operation::Input(place) => inputs.get(*place).cloned().unwrap_or_else(|| self.undefined()),
            Operation::Constant(at) => self.constants[*at].clone(),
            Operation::Pi => S::pi(self.precision),
            Operation::Sum { constant, terms } => {
                let mut sum = constant.map(|at| self.constants[at].clone());
                for (register, weight) in terms {
                    let term = &registers[*register];
                    sum = Some(weight.added(sum, term, &self.constants));
                }
                sum.unwrap_or_else(|| self.undefined())
            }
            Operation::Product(factors) => self.product(factors, registers),
            Operation::Power { base, exponent } => registers[*base].pow(&registers[*exponent]),
            Operation::Function(function, x) => registers[*x].apply(*function),
            Operation::Atan2 { y, x } => registers[*y].atan2(&registers[*x]),
            Operation::Undefined => self.undefined(),
        }
    }

    /// Numerator and denominator apart, so that there is one division at most.
    fn product(&self, factors: &[Factor], registers: &[S]) -> S {
        let mut numerator: Option<S> = None;
        let mut denominator: Option<S> = None;
        for factor in factors {
            let base = &registers[factor.register];
            let part = if factor.divides { &mut denominator } else { &mut numerator };
            let value = match factor.exponent {
                Exponent::One => {
                    *part = Some(match part.take() {
                        None => base.clone(),
                        Some(product) => product.mul(base),
                    });
                    continue;
                }
                Exponent::Whole(n) => base.powi(n),
                Exponent::Halves(1) => base.sqrt(),
                Exponent::Halves(n) => base.sqrt().powi(n),
                Exponent::Constant(at) => base.pow(&self.constants[at]),
            };
            *part = Some(match part.take() {
                None => value,
                Some(product) => product.mul(&value),
            });
        }
        match (numerator, denominator) {
            (Some(n), None) => n,
            (Some(n), Some(d)) => n.div(&d),
            (None, Some(d)) => self.constants[0].div(&d),
            (None, None) => self.constants[0].clone(),
        }
    }

    /// A value that is no number.
    fn undefined(&self) -> S {
        let zero = S::from_number(&Number::ZERO, self.precision);
        zero.div(&zero)
    }
}

/// The number that an expression without symbols comes to.
pub fn evaluate_closed<S: Scalar>(pool: &Pool, value: ExprId, precision: S::Precision) -> Option<S> {
    if let Node::Number(number) = pool.node(value) {
        let own = S::from_number(number, precision);
        if own.is_finite() {
            return Some(own);
        }
    }
    let tape = Tape::compile(pool, &[value], &[]).ok()?;
    let own = tape.prepare::<S>(precision).evaluate(&[], &mut Vec::new());
    let own = own.into_iter().next()?;
    if own.is_finite() {
        return Some(own);
    }
    // Parts may be beyond the range of what they come to.
    let wide = tape.prepare::<Big>(BEYOND_DOUBLES).evaluate(&[], &mut Vec::new());
    let wide = wide.first().filter(|wide| wide.is_finite());
    Some(wide.and_then(S::from_wide).unwrap_or(own))
}
