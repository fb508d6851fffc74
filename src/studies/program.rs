//! From expressions to a list of operations on numbers, for any arithmetic.
//!
//! Equal operations are made once; what all terms of a sum have in common is taken out of it,
//! and sums are added from their last term, so that sums which end alike (the masses hanging below
//! each link of a pendulum) share what they have in common.

use std::collections::HashMap;

use librate_core::expr::{ExprId, Node, Pool, Symbol, UnboundSymbol};
use librate_core::linearize;
use librate_core::number::Number;
use librate_core::precision::{Ball, Function, Scalar, power};

/// One operation on registers; its result goes to the next register.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Operation {
    /// a + b
    Add(u32, u32),
    /// a - b
    Subtract(u32, u32),
    /// a b
    Multiply(u32, u32),
    /// a / b
    Divide(u32, u32),
    /// -a
    Negate(u32),
    /// The square root.
    Root(u32),
    /// A base to an exponent.
    Power(u32, u32),
    /// The angle of the point (x, y) in (-pi, pi].
    Angle {
        /// The ordinate.
        y: u32,
        /// The abscissa.
        x: u32,
    },
    /// A function of one argument.
    Apply(Function, u32),
    /// No number.
    Undefined,
}

impl Operation {
    /// The same of other operands.
    fn renumbered(self, mut new: impl FnMut(u32) -> u32) -> Self {
        match self {
            Self::Add(a, b) => Self::Add(new(a), new(b)),
            Self::Subtract(a, b) => Self::Subtract(new(a), new(b)),
            Self::Multiply(a, b) => Self::Multiply(new(a), new(b)),
            Self::Divide(a, b) => Self::Divide(new(a), new(b)),
            Self::Negate(a) => Self::Negate(new(a)),
            Self::Root(a) => Self::Root(new(a)),
            Self::Power(a, b) => Self::Power(new(a), new(b)),
            Self::Angle { y, x } => Self::Angle { y: new(y), x: new(x) },
            Self::Apply(function, a) => Self::Apply(function, new(a)),
            Self::Undefined => Self::Undefined,
        }
    }
}

/// Operations on registers: first the constants, then the inputs, then one result an operation.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// Constants, each with a bound of what the double is off by.
    pub constants: Vec<(f64, f64)>,
    /// How many inputs there are.
    pub inputs: usize,
    /// One for each register behind the inputs.
    pub operations: Vec<Operation>,
    /// The registers of the roots.
    pub outputs: Vec<u32>,
}

impl Program {
    /// How many registers there are.
    pub(crate) fn registers(&self) -> usize {
        self.constants.len() + self.inputs + self.operations.len()
    }

    /// Compiles the roots as functions of the inputs.
    ///
    /// # Errors
    /// A symbol that is no input.
    pub(crate) fn compile(pool: &Pool, roots: &[ExprId], inputs: &[Symbol]) -> Result<Self, UnboundSymbol> {
        let mut compiler = Compiler { pool, inputs, values: Vec::new(), known: HashMap::new(), of: HashMap::new() };
        for id in pool.reachable(roots) {
            let register = compiler.expression(id)?;
            compiler.of.insert(id, register);
        }
        let outputs: Vec<u32> = roots.iter().map(|root| compiler.register(*root)).collect();
        Ok(compiler.finish(&outputs))
    }
}

/// What a register holds, before the registers are put in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Value {
    /// The bits of a constant and of a bound of what it is off by.
    Constant(u64, u64),
    Input(usize),
    Result(Operation),
}

struct Compiler<'a> {
    pool: &'a Pool,
    inputs: &'a [Symbol],
    values: Vec<Value>,
    known: HashMap<Value, u32>,
    of: HashMap<ExprId, u32>,
}

impl Compiler<'_> {
    /// The register of a value, which is made if it is new.
    fn put(&mut self, value: Value) -> u32 {
        *self.known.entry(value).or_insert_with(|| {
            self.values.push(value);
            u32::try_from(self.values.len() - 1).unwrap_or(u32::MAX)
        })
    }

    fn constant(&mut self, ball: &Ball) -> u32 {
        self.put(Value::Constant(ball.mid_f64().to_bits(), ball.mid_f64_error().to_bits()))
    }

    fn number(&mut self, number: &Number) -> u32 {
        self.constant(&Ball::from_number(number, ()))
    }

    fn register(&self, id: ExprId) -> u32 {
        self.of.get(&id).copied().unwrap_or(0)
    }

    fn operation(&mut self, operation: Operation) -> u32 {
        let is_one = |own: u32| self.values.get(own as usize) == Some(&Value::Constant(1_f64.to_bits(), 0));
        match operation {
            Operation::Multiply(a, b) if is_one(a) => return b,
            Operation::Multiply(a, b) if is_one(b) => return a,
            Operation::Negate(a) => {
                if let Some(Value::Constant(value, error)) = self.values.get(a as usize).copied() {
                    return self.put(Value::Constant((-f64::from_bits(value)).to_bits(), error));
                }
            }
            _ => {}
        }
        self.put(Value::Result(match operation {
            Operation::Add(a, b) => Operation::Add(a.min(b), a.max(b)),
            Operation::Multiply(a, b) => Operation::Multiply(a.min(b), a.max(b)),
            other => other,
        }))
    }

    fn expression(&mut self, id: ExprId) -> Result<u32, UnboundSymbol> {
        if self.pool.is_constant(id) {
            let ball = linearize::constant(self.pool, id).unwrap_or(Ball::NOT_FINITE);
            return Ok(self.constant(&ball));
        }
        Ok(match self.pool.node(id) {
            Node::Symbol(symbol) => {
                let place = self.inputs.iter().position(|input| input == symbol);
                let place = place.ok_or(UnboundSymbol { symbol: *symbol })?;
                self.put(Value::Input(place))
            }
            Node::Sum { constant, terms } => self.sum(constant, terms),
            Node::Product(factors) => self.product(factors),
            Node::Power { base, exponent } => {
                self.operation(Operation::Power(self.register(*base), self.register(*exponent)))
            }
            Node::Function(function, x) => self.operation(Operation::Apply(*function, self.register(*x))),
            Node::Atan2 { y, x } => self.operation(Operation::Angle { y: self.register(*y), x: self.register(*x) }),
            Node::Number(_) | Node::Pi | Node::Undefined => self.operation(Operation::Undefined),
        })
    }

    fn sum(&mut self, constant: &Number, terms: &[(ExprId, Number)]) -> u32 {
        let mut parts: Vec<(Vec<(ExprId, Number)>, Number)> =
            terms.iter().map(|(term, coefficient)| (self.pool.factors(*term), coefficient.clone())).collect();
        let mut common: Vec<(ExprId, Number)> = Vec::new();
        let mut scale = Number::ONE;
        if constant.is_zero() {
            if let [first, others @ ..] = parts.as_slice() {
                common.clone_from(&first.0);
                common.retain(|factor| others.iter().all(|(other, _)| other.contains(factor)));
            }
            for (factors, _) in &mut parts {
                factors.retain(|factor| !common.contains(factor));
            }
            // The coefficient of the last term, where all have it up to the sign.
            if let Some((_, last)) = parts.last() {
                let magnitude = last.abs();
                if parts.iter().all(|(_, own)| own.abs() == magnitude) {
                    scale = last.clone();
                }
            }
        }
        let mut total: Option<u32> = None;
        for (factors, coefficient) in parts.iter().rev() {
            // Divided by `scale` the coefficient is exactly 1 or -1, or left as it is.
            let coefficient = coefficient.div(&scale).unwrap_or(Number::ONE);
            let bare = self.product(factors);
            let term = self.scaled(bare, &coefficient.abs());
            total = Some(match (total, coefficient.is_negative()) {
                (None, false) => term,
                (None, true) => self.operation(Operation::Negate(term)),
                (Some(total), false) => self.operation(Operation::Add(total, term)),
                (Some(total), true) => self.operation(Operation::Subtract(total, term)),
            });
        }
        let mut total = total.unwrap_or_else(|| self.number(&Number::ZERO));
        if !constant.is_zero() {
            let constant = self.number(constant);
            total = self.operation(Operation::Add(total, constant));
        }
        let scaled = self.scaled(total, &scale);
        self.times(scaled, &common)
    }

    fn scaled(&mut self, register: u32, scale: &Number) -> u32 {
        if scale.is_one() {
            return register;
        }
        if scale.abs().is_one() {
            return self.operation(Operation::Negate(register));
        }
        let scale = self.number(scale);
        self.operation(Operation::Multiply(scale, register))
    }

    fn product(&mut self, factors: &[(ExprId, Number)]) -> u32 {
        let one = self.number(&Number::ONE);
        self.times(one, factors)
    }

    /// A register times the factors; numerator and denominator apart, so that there is one
    /// division at most.
    fn times(&mut self, register: u32, factors: &[(ExprId, Number)]) -> u32 {
        let one = self.number(&Number::ONE);
        let (mut above, mut below) = (None, None);
        for (base, exponent) in factors {
            let power = self.power(*base, &exponent.abs());
            let part = if exponent.is_negative() { &mut below } else { &mut above };
            *part = Some(part.map_or(power, |product| self.operation(Operation::Multiply(product, power))));
        }
        let result = match above {
            Some(above) if register == one => above,
            Some(above) => self.operation(Operation::Multiply(above, register)),
            None => register,
        };
        below.map_or(result, |below| self.operation(Operation::Divide(result, below)))
    }

    /// A base to a positive exponent.
    fn power(&mut self, base: ExprId, exponent: &Number) -> u32 {
        let base = self.register(base);
        match exponent.small_parts().map(|(n, d)| (n.unsigned_abs(), d)) {
            Some((n, 1)) if n <= 64 => self.whole_power(base, n as u32),
            Some((n, 2)) if n <= 128 => {
                let root = self.operation(Operation::Root(base));
                self.whole_power(root, n as u32)
            }
            Some(_) | None => {
                let exponent = self.number(exponent);
                self.operation(Operation::Power(base, exponent))
            }
        }
    }

    fn whole_power(&mut self, base: u32, exponent: u32) -> u32 {
        power(&base, exponent, |x, y| self.operation(Operation::Multiply(*x, *y))).unwrap_or(base)
    }

    /// Leaves out what no output needs, and puts constants and inputs first.
    fn finish(self, outputs: &[u32]) -> Program {
        let mut needed = vec![false; self.values.len()];
        for output in outputs {
            needed[*output as usize] = true;
        }
        // Operands stand before their results.
        for at in (0..self.values.len()).rev() {
            if let (true, Value::Result(operation)) = (needed[at], self.values[at]) {
                operation.renumbered(|operand| {
                    needed[operand as usize] = true;
                    operand
                });
            }
        }
        let index = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
        let mut program = Program { inputs: self.inputs.len(), ..Program::default() };
        let mut place = vec![0; self.values.len()];
        for (at, value) in self.values.iter().enumerate() {
            if let (true, Value::Constant(value, error)) = (needed[at], value) {
                place[at] = index(program.constants.len());
                program.constants.push((f64::from_bits(*value), f64::from_bits(*error)));
            }
        }
        let first = program.constants.len();
        for (at, value) in self.values.iter().enumerate() {
            match value {
                Value::Input(input) => place[at] = index(first + input),
                Value::Result(operation) if needed[at] => {
                    let new = operation.renumbered(|old| place[old as usize]);
                    place[at] = index(first + program.inputs + program.operations.len());
                    program.operations.push(new);
                }
                Value::Result(_) | Value::Constant(..) => {}
            }
        }
        program.outputs = outputs.iter().map(|at| place[*at as usize]).collect();
        program
    }
}
