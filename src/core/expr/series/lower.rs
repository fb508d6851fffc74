//! Tapes taken apart to operations on series.

use hashbrown::HashMap;

use super::super::Function;
use super::super::tape::{Code, Exponent, Factor, Operation, Weight};
use crate::precision::power;

/// One operation on series; its coefficients go to the row of its own number.
#[derive(Clone, Debug)]
pub(super) enum Step {
    Input(usize),
    /// A number, by its place among the constants.
    Constant(usize),
    Pi,
    Undefined,
    Sum {
        constant: Option<usize>,
        terms: Box<[(usize, Weight)]>,
    },
    Difference(usize, usize),
    /// A constant multiple.
    Multiple {
        constant: usize,
        of: usize,
    },
    Product(usize, usize),
    Square(usize),
    Quotient(usize, usize),
    Root(usize),
    Absolute(usize),
    /// theta x: its k-th coefficient is k x_k.
    Slope(usize),
    /// A quotient of a series that begins with 0, even where the divisor begins with 0 and stays there.
    SlopeQuotient {
        slope: usize,
        divisor: usize,
    },
    /// f with theta f = ±slope·factor, by its first coefficient; a factor that is left out is 1. The factor may be
    /// a later operation or this one: only lower coefficients are read.
    Integral {
        start: Start,
        slope: usize,
        factor: Option<usize>,
        negative: bool,
    },
}

/// The value of a function, from the first coefficients of its arguments.
#[derive(Clone, Copy, Debug)]
pub(super) enum Start {
    Function(Function, usize),
    Power { base: usize, exponent: usize },
    Angle { y: usize, x: usize },
}

/// A tape taken apart.
pub(super) struct Lowered {
    pub(super) steps: Vec<Step>,
    /// The steps that depend on an input, rising.
    pub(super) moving: Vec<usize>,
    /// The steps of the outputs.
    pub(super) outputs: Vec<usize>,
}

/// Takes the operations of a tape apart to operations on series.
pub(super) fn lower(code: &Code) -> Lowered {
    let mut lowering = Lowering::default();
    for operation in &code.operations {
        lowering.operation(operation);
    }
    let outputs = code.outputs.iter();
    let outputs = outputs.map(|register| lowering.place[*register]).collect();
    let steps = lowering.steps;
    let mut moves = Vec::with_capacity(steps.len());
    for step in &steps {
        moves.push(step.moves(&moves));
    }
    let moving = (0..steps.len()).filter(|at| moves[*at]).collect();
    Lowered { steps, moving, outputs }
}

impl Step {
    /// Whether the step depends on an input, from what is known of those before it. The factor of an integral does not
    /// matter: where its slope is constant, the slope is 0.
    fn moves(&self, moves: &[bool]) -> bool {
        match self {
            Self::Input(_) => true,
            Self::Constant(_) | Self::Pi | Self::Undefined => false,
            Self::Sum { terms, .. } => terms.iter().any(|(term, _)| moves[*term]),
            Self::Difference(a, b) | Self::Product(a, b) | Self::Quotient(a, b) => moves[*a] || moves[*b],
            Self::Square(a) | Self::Root(a) | Self::Absolute(a) | Self::Slope(a) | Self::Multiple { of: a, .. } => {
                moves[*a]
            }
            Self::SlopeQuotient { slope, .. } | Self::Integral { slope, .. } => moves[*slope],
        }
    }
}

/// What is taken apart so far.
#[derive(Default)]
struct Lowering {
    steps: Vec<Step>,
    /// The step with the result of each register.
    place: Vec<usize>,
    slopes: HashMap<usize, usize>,
    /// Products of two steps, the lower one first.
    products: HashMap<(usize, usize), usize>,
    /// Sine and cosine of a step, or their hyperbolic kin.
    pairs: HashMap<(usize, bool), (usize, usize)>,
}

impl Lowering {
    fn push(&mut self, step: Step) -> usize {
        self.steps.push(step);
        self.steps.len() - 1
    }

    fn operation(&mut self, operation: &Operation) {
        let at = |register: &usize| self.place[*register];
        let step = match operation {
            Operation::Input(place) => self.push(Step::Input(*place)),
            Operation::Constant(place) => self.push(Step::Constant(*place)),
            Operation::Pi => self.push(Step::Pi),
            Operation::Undefined => self.push(Step::Undefined),
            Operation::Sum { constant, terms } => {
                let terms = terms.iter().map(|(term, w)| (at(term), *w)).collect();
                let constant = *constant;
                self.push(Step::Sum { constant, terms })
            }
            Operation::Product(factors) => self.product(factors),
            Operation::Power { base, exponent } => {
                let (base, exponent) = (at(base), at(exponent));
                self.power(base, exponent)
            }
            Operation::Function(function, x) => {
                let x = at(x);
                self.function(*function, x)
            }
            Operation::Atan2 { y, x } => {
                let (y, x) = (at(y), at(x));
                self.angle(y, x)
            }
        };
        self.place.push(step);
    }

    /// Numerator and denominator apart, as in an evaluation.
    fn product(&mut self, factors: &[Factor]) -> usize {
        let mut parts: [Option<usize>; 2] = [None, None];
        for factor in factors {
            let base = self.place[factor.register];
            let value = match factor.exponent {
                Exponent::One => base,
                Exponent::Whole(n) => self.whole_power(base, n),
                Exponent::Halves(n) => {
                    let root = self.push(Step::Root(base));
                    self.whole_power(root, n)
                }
                Exponent::Constant(exponent) => self.constant_power(base, exponent),
            };
            let part = &mut parts[usize::from(factor.divides)];
            *part = Some(match *part {
                None => value,
                Some(product) => self.times(product, value),
            });
        }
        let [numerator, denominator] = parts;
        let one = |lowering: &mut Self| lowering.push(Step::Constant(0));
        match (numerator, denominator) {
            (Some(n), None) => n,
            (Some(n), Some(d)) => self.push(Step::Quotient(n, d)),
            (None, Some(d)) => {
                let n = one(self);
                self.push(Step::Quotient(n, d))
            }
            (None, None) => one(self),
        }
    }

    /// A power by products, so that a base that begins with 0 is as good as any other.
    fn whole_power(&mut self, base: usize, exponent: i32) -> usize {
        let whole = power(&base, exponent.unsigned_abs(), |x, y| self.times(*x, *y));
        whole.unwrap_or_else(|| self.push(Step::Constant(0)))
    }

    /// 1 ± x.
    fn beside_one(&mut self, x: usize, weight: Weight) -> usize {
        self.push(Step::Sum { constant: Some(0), terms: Box::new([(x, weight)]) })
    }

    /// A product that may be there already.
    fn times(&mut self, a: usize, b: usize) -> usize {
        let key = (a.min(b), a.max(b));
        if let Some(known) = self.products.get(&key) {
            return *known;
        }
        let product = self.push(if a == b { Step::Square(a) } else { Step::Product(a, b) });
        self.products.insert(key, product);
        product
    }

    fn slope(&mut self, x: usize) -> usize {
        if let Some(known) = self.slopes.get(&x) {
            return *known;
        }
        let slope = self.push(Step::Slope(x));
        self.slopes.insert(x, slope);
        slope
    }

    /// theta (a^c) = c (theta a/a) a^c.
    fn constant_power(&mut self, base: usize, exponent: usize) -> usize {
        let slope = self.slope(base);
        let relative = self.push(Step::SlopeQuotient { slope, divisor: base });
        let slope = self.push(Step::Multiple { constant: exponent, of: relative });
        let exponent = self.push(Step::Constant(exponent));
        self.own_factor(Start::Power { base, exponent }, slope)
    }

    /// theta (a^b) = theta (b ln a) a^b.
    fn power(&mut self, base: usize, exponent: usize) -> usize {
        let logarithm = self.function(Function::Ln, base);
        let product = self.times(exponent, logarithm);
        let slope = self.slope(product);
        self.own_factor(Start::Power { base, exponent }, slope)
    }

    /// f with theta f = slope·f.
    fn own_factor(&mut self, start: Start, slope: usize) -> usize {
        let own = self.steps.len();
        self.push(Step::Integral { start, slope, factor: Some(own), negative: false })
    }

    /// The angle has theta f = (x theta y - y theta x)/(x² + y²).
    fn angle(&mut self, y: usize, x: usize) -> usize {
        let (rise, run) = (self.slope(y), self.slope(x));
        let left = self.times(x, rise);
        let right = self.times(y, run);
        let turn = self.push(Step::Difference(left, right));
        let squares = [y, x].map(|side| (self.times(side, side), Weight::One));
        let distance = self.push(Step::Sum { constant: None, terms: Box::new(squares) });
        let slope = self.push(Step::SlopeQuotient { slope: turn, divisor: distance });
        self.push(Step::Integral { start: Start::Angle { y, x }, slope, factor: None, negative: false })
    }

    fn function(&mut self, function: Function, x: usize) -> usize {
        match function {
            Function::Sin => self.pair(x, false).0,
            Function::Cos => self.pair(x, false).1,
            Function::Sinh => self.pair(x, true).0,
            Function::Cosh => self.pair(x, true).1,
            Function::Tan | Function::Tanh => {
                // theta tan a = (1 + tan² a) theta a, theta tanh a = (1 - tanh² a) theta a
                let slope = self.slope(x);
                let own = self.steps.len();
                let value = self.push(Step::Integral {
                    start: Start::Function(function, x),
                    slope,
                    factor: Some(own + 2),
                    negative: false,
                });
                let square = self.push(Step::Square(value));
                self.beside_one(square, if function == Function::Tan { Weight::One } else { Weight::MinusOne });
                value
            }
            Function::Asin | Function::Acos => {
                let square = self.times(x, x);
                let rest = self.beside_one(square, Weight::MinusOne);
                let root = self.push(Step::Root(rest));
                self.relative(function, x, root, function == Function::Acos)
            }
            Function::Atan => {
                let square = self.times(x, x);
                let divisor = self.beside_one(square, Weight::One);
                self.relative(function, x, divisor, false)
            }
            Function::Ln => self.relative(function, x, x, false),
            Function::Exp => {
                let slope = self.slope(x);
                self.own_factor(Start::Function(function, x), slope)
            }
            Function::Abs => self.push(Step::Absolute(x)),
        }
    }

    /// f with theta f = ±theta x/divisor.
    fn relative(&mut self, function: Function, x: usize, divisor: usize, negative: bool) -> usize {
        let slope = self.slope(x);
        let slope = self.push(Step::SlopeQuotient { slope, divisor });
        self.push(Step::Integral { start: Start::Function(function, x), slope, factor: None, negative })
    }

    fn pair(&mut self, x: usize, hyperbolic: bool) -> (usize, usize) {
        if let Some(known) = self.pairs.get(&(x, hyperbolic)) {
            return *known;
        }
        let slope = self.slope(x);
        let first = self.steps.len();
        let (sine, cosine) = if hyperbolic { (Function::Sinh, Function::Cosh) } else { (Function::Sin, Function::Cos) };
        for (function, factor, negative) in [(sine, first + 1, false), (cosine, first, !hyperbolic)] {
            self.push(Step::Integral { start: Start::Function(function, x), slope, factor: Some(factor), negative });
        }
        self.pairs.insert((x, hyperbolic), (first, first + 1));
        (first, first + 1)
    }
}
