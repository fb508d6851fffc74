//! What the tests of expressions share: a reader for printed expressions and a plain `f64`
//! scalar.

#![allow(dead_code, unreachable_pub, clippy::unwrap_used, clippy::panic)]

pub mod approx;

use librate::expr::{ExprId, Function, Pool, Symbol, Tape};
use librate::number::Number;
use librate::precision::Scalar;

/// Reads an expression of the model language (names, numbers, operators, functions).
pub fn read(pool: &mut Pool, text: &str) -> ExprId {
    let mut reader = Reader { rest: text, pool };
    let value = reader.sum();
    assert_eq!(reader.rest.trim(), "", "unread text in {text:?}");
    value
}

struct Reader<'a> {
    rest: &'a str,
    pool: &'a mut Pool,
}

impl Reader<'_> {
    fn eat(&mut self, token: &str) -> bool {
        self.rest = self.rest.trim_start();
        match self.rest.strip_prefix(token) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn sum(&mut self) -> ExprId {
        let mut value = self.product();
        loop {
            if self.eat("+") {
                let term = self.product();
                value = self.pool.add(value, term);
            } else if self.eat("-") {
                let term = self.product();
                value = self.pool.sub(value, term);
            } else {
                return value;
            }
        }
    }

    fn product(&mut self) -> ExprId {
        let mut value = self.unary();
        loop {
            if self.eat("*") {
                let factor = self.unary();
                value = self.pool.mul(value, factor);
            } else if self.eat("/") {
                let factor = self.unary();
                value = self.pool.div(value, factor);
            } else {
                return value;
            }
        }
    }

    fn unary(&mut self) -> ExprId {
        if self.eat("-") {
            let value = self.unary();
            return self.pool.neg(value);
        }
        let base = self.atom();
        if self.eat("^") {
            let exponent = self.unary();
            return self.pool.power(base, exponent);
        }
        base
    }

    fn atom(&mut self) -> ExprId {
        if self.eat("(") {
            let value = self.sum();
            assert!(self.eat(")"), "`)` expected at {:?}", self.rest);
            return value;
        }
        self.rest = self.rest.trim_start();
        let is_part = |c: char| c.is_alphanumeric() || "_.'[]".contains(c);
        let end = self.rest.find(|c| !is_part(c)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        assert!(!word.is_empty(), "expression expected at {:?}", self.rest);
        self.rest = rest;
        if word.starts_with(|c: char| c.is_ascii_digit()) {
            return self.pool.number(Number::parse(word).unwrap());
        }
        if !self.eat("(") {
            return match word {
                "pi" => self.pool.pi(),
                name => self.pool.variable(name),
            };
        }
        let x = self.sum();
        let value = if word == "atan2" {
            assert!(self.eat(","));
            let second = self.sum();
            self.pool.atan2(x, second)
        } else if word == "sqrt" {
            self.pool.sqrt(x)
        } else {
            self.pool.apply(function(word), x)
        };
        assert!(self.eat(")"), "`)` expected at {:?}", self.rest);
        value
    }
}

pub const FUNCTIONS: [(&str, Function); 12] = [
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("asin", Function::Asin),
    ("acos", Function::Acos),
    ("atan", Function::Atan),
    ("sinh", Function::Sinh),
    ("cosh", Function::Cosh),
    ("tanh", Function::Tanh),
    ("exp", Function::Exp),
    ("ln", Function::Ln),
    ("abs", Function::Abs),
];

fn function(name: &str) -> Function {
    FUNCTIONS.iter().find(|(n, _)| *n == name).unwrap_or_else(|| panic!("no function {name}")).1
}

/// A double as it is.
#[derive(Clone, Copy, Debug)]
pub struct Plain(pub f64);

impl Scalar for Plain {
    type Precision = ();

    fn from_number(number: &Number, (): ()) -> Self {
        Plain(number.to_f64())
    }
    fn pi((): ()) -> Self {
        Plain(std::f64::consts::PI)
    }
    fn add(&self, other: &Self) -> Self {
        Plain(self.0 + other.0)
    }
    fn sub(&self, other: &Self) -> Self {
        Plain(self.0 - other.0)
    }
    fn mul(&self, other: &Self) -> Self {
        Plain(self.0 * other.0)
    }
    fn div(&self, other: &Self) -> Self {
        Plain(self.0 / other.0)
    }
    fn neg(&self) -> Self {
        Plain(-self.0)
    }
    fn powi(&self, exponent: i32) -> Self {
        Plain(self.0.powi(exponent))
    }
    fn sqrt(&self) -> Self {
        Plain(self.0.sqrt())
    }
    fn pow(&self, exponent: &Self) -> Self {
        Plain(self.0.powf(exponent.0))
    }
    fn apply(&self, function: Function) -> Self {
        Plain(apply(function, self.0))
    }
    fn atan2(&self, x: &Self) -> Self {
        Plain(self.0.atan2(x.0))
    }
    fn is_finite(&self) -> bool {
        self.0.is_finite()
    }
}

pub fn apply(function: Function, x: f64) -> f64 {
    match function {
        Function::Sin => x.sin(),
        Function::Cos => x.cos(),
        Function::Tan => x.tan(),
        Function::Asin => x.asin(),
        Function::Acos => x.acos(),
        Function::Atan => x.atan(),
        Function::Sinh => x.sinh(),
        Function::Cosh => x.cosh(),
        Function::Tanh => x.tanh(),
        Function::Exp => x.exp(),
        Function::Ln => x.ln(),
        Function::Abs => x.abs(),
    }
}

/// The value of an expression at the values of all symbols, in order of creation.
pub fn value(pool: &Pool, e: ExprId, symbols: &[Symbol], values: &[f64]) -> f64 {
    let tape = Tape::compile(pool, &[e], symbols).unwrap();
    let inputs: Vec<Plain> = values.iter().map(|v| Plain(*v)).collect();
    tape.evaluate(&inputs, &mut Vec::new())[0].0
}
