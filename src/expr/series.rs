//! Taylor coefficients of compiled expressions along a curve, order by order.
//!
//! Where the inputs of a tape are power series in one variable, so are its outputs, and the k-th coefficient of every
//! operation follows from the coefficients up to the k-th of its operands by O(k) products (A. Griewank and
//! A. Walther, Evaluating Derivatives, 2nd ed. (2008), chapter 13; D. E. Knuth, The Art of Computer Programming 2, §4.7).
//! With the operator theta f = t df/dt, whose coefficients are k f_k, a function with f' = g obeys
//! theta f(a) = g(a) theta a, thus k f_k = Σ_(j=1..k) j a_j g_(k-j): only coefficients of g below the k-th.
//!
//! Coefficients are kept per operation with the place behind the last one that is not exactly zero, so that constants
//! and polynomials cost what they are worth. Over enclosures every coefficient is enclosed. Nothing is allocated
//! after [`Series::clear`] for orders that were reached before (by numbers that do not allocate themselves).

use std::collections::HashMap;

use super::Function;
use super::tape::{Exponent, Factor, Operation, Prepared, Weight};
use crate::number::Number;
use crate::precision::Scalar;

/// One operation on series; its coefficients go to the row of its own number.
#[derive(Clone, Debug)]
enum Step {
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
    /// 1 + x.
    Successor(usize),
    /// 1 - x.
    Complement(usize),
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
enum Start {
    Function(Function, usize),
    Power { base: usize, exponent: usize },
    ConstantPower { base: usize, exponent: usize },
    Angle { y: usize, x: usize },
}

/// Taylor coefficients of a tape's outputs, from those of its inputs.
///
/// ```
/// use librate::expr::{Pool, Tape};
///
/// let mut pool = Pool::default();
/// let x = pool.symbol("x");
/// let e = pool.symbol_expr(x);
/// let cosine = pool.cos(e);
/// let tape = Tape::compile(&pool, &[cosine], &[x])?;
/// let mut series = tape.prepare::<f64>(()).series();
/// // x = t, whose coefficients are 0, 1, 0, 0, …
/// let cosine: Vec<f64> = [0.0, 1.0, 0.0].map(|x| series.next(&[x])[0]).to_vec();
/// assert_eq!(cosine, [1.0, 0.0, -0.5]);
/// # Ok::<(), librate::expr::UnboundSymbol>(())
/// ```
#[derive(Clone, Debug)]
pub struct Series<S: Scalar> {
    steps: Vec<Step>,
    outputs: Vec<usize>,
    /// The first one is 1.
    constants: Vec<S>,
    zero: S,
    pi: S,
    /// 0, 1, 2, … as far as orders went.
    counts: Vec<S>,
    /// The coefficients of each step so far.
    rows: Vec<Vec<S>>,
    /// For each step the place behind its last coefficient that is not exactly zero.
    live: Vec<usize>,
    /// Whether a coefficient of the step is not a number: then no product with it is one, by 0 neither.
    broken: Vec<bool>,
    order: usize,
    out: Vec<S>,
    precision: S::Precision,
}

impl<S: Scalar> Prepared<S> {
    /// The tape as a map of power series, ready for the coefficients of order 0.
    #[must_use]
    pub fn series(&self) -> Series<S> {
        let mut lowering = Lowering::default();
        for operation in &self.code.operations {
            lowering.operation(operation);
        }
        let count = lowering.steps.len();
        let zero = S::from_number(&Number::ZERO, self.precision);
        Series {
            outputs: self
                .code
                .outputs
                .iter()
                .map(|register| lowering.place[*register])
                .collect(),
            steps: lowering.steps,
            constants: self.constants.clone(),
            pi: S::pi(self.precision),
            counts: vec![zero.clone()],
            rows: vec![Vec::new(); count],
            live: vec![0; count],
            broken: vec![false; count],
            order: 0,
            out: vec![zero.clone(); self.code.outputs.len()],
            zero,
            precision: self.precision,
        }
    }
}

/// Takes the operations of a tape apart to operations on series.
#[derive(Default)]
struct Lowering {
    steps: Vec<Step>,
    /// The step with the result of each register.
    place: Vec<usize>,
    slopes: HashMap<usize, usize>,
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
            *part = Some(match part.take() {
                None => value,
                Some(product) => {
                    self.steps.push(Step::Product(product, value));
                    self.steps.len() - 1
                }
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
        let exponent = exponent.unsigned_abs();
        let mut power = None;
        let mut square = base;
        let mut left = exponent;
        while left > 0 {
            if left & 1 == 1 {
                power = Some(match power {
                    None => square,
                    Some(power) => self.push(Step::Product(power, square)),
                });
            }
            left >>= 1;
            if left > 0 {
                square = self.push(Step::Square(square));
            }
        }
        match power {
            Some(power) => power,
            None => self.push(Step::Constant(0)),
        }
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
        let relative = self.push(Step::SlopeQuotient {
            slope,
            divisor: base,
        });
        let slope = self.push(Step::Multiple {
            constant: exponent,
            of: relative,
        });
        let start = Start::ConstantPower { base, exponent };
        self.own_factor(start, slope)
    }

    /// theta (a^b) = theta (b ln a) a^b.
    fn power(&mut self, base: usize, exponent: usize) -> usize {
        let logarithm = self.function(Function::Ln, base);
        let product = self.push(Step::Product(exponent, logarithm));
        let slope = self.slope(product);
        self.own_factor(Start::Power { base, exponent }, slope)
    }

    /// f with theta f = slope·f.
    fn own_factor(&mut self, start: Start, slope: usize) -> usize {
        let own = self.steps.len();
        self.push(Step::Integral {
            start,
            slope,
            factor: Some(own),
            negative: false,
        })
    }

    /// The angle has theta f = (x theta y - y theta x)/(x² + y²).
    fn angle(&mut self, y: usize, x: usize) -> usize {
        let (rise, run) = (self.slope(y), self.slope(x));
        let left = self.push(Step::Product(x, rise));
        let right = self.push(Step::Product(y, run));
        let turn = self.push(Step::Difference(left, right));
        let squares = [y, x].map(|side| (self.push(Step::Square(side)), Weight::One));
        let distance = self.push(Step::Sum {
            constant: None,
            terms: Box::new(squares),
        });
        let slope = self.push(Step::SlopeQuotient {
            slope: turn,
            divisor: distance,
        });
        self.push(Step::Integral {
            start: Start::Angle { y, x },
            slope,
            factor: None,
            negative: false,
        })
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
                self.push(if function == Function::Tan {
                    Step::Successor(square)
                } else {
                    Step::Complement(square)
                });
                value
            }
            Function::Asin | Function::Acos => {
                let square = self.push(Step::Square(x));
                let rest = self.push(Step::Complement(square));
                let root = self.push(Step::Root(rest));
                self.relative(function, x, root, function == Function::Acos)
            }
            Function::Atan => {
                let square = self.push(Step::Square(x));
                let divisor = self.push(Step::Successor(square));
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
        self.push(Step::Integral {
            start: Start::Function(function, x),
            slope,
            factor: None,
            negative,
        })
    }

    fn pair(&mut self, x: usize, hyperbolic: bool) -> (usize, usize) {
        if let Some(known) = self.pairs.get(&(x, hyperbolic)) {
            return *known;
        }
        let slope = self.slope(x);
        let first = self.steps.len();
        let (sine, cosine) = if hyperbolic {
            (Function::Sinh, Function::Cosh)
        } else {
            (Function::Sin, Function::Cos)
        };
        for (function, factor, negative) in [(sine, first + 1, false), (cosine, first, !hyperbolic)]
        {
            self.push(Step::Integral {
                start: Start::Function(function, x),
                slope,
                factor: Some(factor),
                negative,
            });
        }
        self.pairs.insert((x, hyperbolic), (first, first + 1));
        (first, first + 1)
    }
}

impl<S: Scalar> Series<S> {
    /// Forgets all coefficients: the next ones are those of order 0.
    pub fn clear(&mut self) {
        self.order = 0;
        for row in &mut self.rows {
            row.clear();
        }
        self.live.fill(0);
        self.broken.fill(false);
    }

    /// The order of the coefficients that come next: how many there are already.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The k-th Taylor coefficients of all outputs from those of all inputs, in the order of
    /// [`super::Tape::compile`]; k counts up with each call. An input that is left out is not a number.
    ///
    /// What has no expansion is not finite: a root or a power that is not whole where its base begins with 0, an
    /// absolute value where the sign is not decided. (A series whose base is constant so far is constant.)
    pub fn next(&mut self, inputs: &[S]) -> &[S] {
        let k = self.order;
        while self.counts.len() <= k {
            let count = Number::from(i64::try_from(self.counts.len()).unwrap_or(i64::MAX));
            self.counts.push(S::from_number(&count, self.precision));
        }
        for at in 0..self.steps.len() {
            let value = self.coefficient(at, inputs, k);
            if !value.is_exact_zero() {
                self.live[at] = k + 1;
                self.broken[at] |= !value.is_finite();
            }
            self.rows[at].push(value);
        }
        for (place, step) in self.out.iter_mut().zip(&self.outputs) {
            *place = self.rows[*step][k].clone();
        }
        self.order += 1;
        &self.out
    }

    /// Whether the series is a constant as far as it goes.
    fn constant(&self, row: usize) -> bool {
        self.live[row] <= 1
    }

    fn not_a_number(&self) -> S {
        self.zero.div(&self.zero)
    }

    fn coefficient(&self, own: usize, inputs: &[S], k: usize) -> S {
        let at = |row: usize| &self.rows[row][k];
        match &self.steps[own] {
            Step::Input(place) => match inputs.get(*place) {
                Some(value) => value.clone(),
                None => self.not_a_number(),
            },
            Step::Constant(_) | Step::Pi | Step::Undefined if k > 0 => self.zero.clone(),
            Step::Constant(place) => self.constants[*place].clone(),
            Step::Pi => self.pi.clone(),
            Step::Undefined => self.not_a_number(),
            Step::Sum { constant, terms } => self.sum(*constant, terms, k),
            Step::Difference(a, b) => at(*a).sub(at(*b)),
            Step::Successor(a) if k == 0 => self.constants[0].add(at(*a)),
            Step::Successor(a) => at(*a).clone(),
            Step::Complement(a) if k == 0 => self.constants[0].sub(at(*a)),
            Step::Complement(a) => at(*a).neg(),
            Step::Multiple { constant, of } => self.constants[*constant].mul(at(*of)),
            Step::Product(a, b) => self.or_zero(self.convolution(*a, *b, k, 0)),
            Step::Square(a) => self.square(*a, k, 0),
            Step::Quotient(a, b) => self.quotient(*a, *b, own, k),
            Step::Root(a) if k == 0 => at(*a).sqrt(),
            Step::Root(a) if self.constant(*a) => self.zero.clone(),
            Step::Root(a) => self.root(*a, own, k),
            Step::Absolute(a) if k == 0 => at(*a).apply(Function::Abs),
            Step::Absolute(a) if self.constant(*a) => self.zero.clone(),
            Step::Absolute(a) => self.rows[*a][0].signum().mul(at(*a)),
            Step::Slope(a) => {
                if k == 0 {
                    self.zero.clone()
                } else {
                    self.counts[k].mul(at(*a))
                }
            }
            Step::SlopeQuotient { slope, divisor } => {
                if k == 0 || self.live[*slope] == 0 {
                    self.zero.clone()
                } else {
                    self.quotient(*slope, *divisor, own, k)
                }
            }
            Step::Integral { start, .. } if k == 0 => self.start(*start),
            Step::Integral {
                slope,
                factor,
                negative,
                ..
            } => {
                let sum = match factor {
                    None => Some(at(*slope).clone()),
                    Some(factor) => self.convolution(*slope, *factor, k, 1),
                };
                match sum {
                    None => self.zero.clone(),
                    Some(sum) if sum.is_exact_zero() => sum,
                    Some(sum) => {
                        let value = sum.div(&self.counts[k]);
                        if *negative { value.neg() } else { value }
                    }
                }
            }
        }
    }

    fn start(&self, start: Start) -> S {
        let first = |row: usize| &self.rows[row][0];
        match start {
            Start::Function(function, x) => first(x).apply(function),
            Start::Power { base, exponent } => first(base).pow(first(exponent)),
            Start::ConstantPower { base, exponent } => first(base).pow(&self.constants[exponent]),
            Start::Angle { y, x } => first(y).atan2(first(x)),
        }
    }

    fn sum(&self, constant: Option<usize>, terms: &[(usize, Weight)], k: usize) -> S {
        let mut sum = match constant {
            Some(place) if k == 0 => Some(self.constants[place].clone()),
            Some(_) | None => None,
        };
        for (row, weight) in terms {
            if self.live[*row] <= k {
                continue;
            }
            let term = &self.rows[*row][k];
            sum = Some(match (sum, weight) {
                (None, Weight::One) => term.clone(),
                (None, Weight::MinusOne) => term.neg(),
                (None, Weight::Constant(at)) => self.constants[*at].mul(term),
                (Some(sum), Weight::One) => sum.add(term),
                (Some(sum), Weight::MinusOne) => sum.sub(term),
                (Some(sum), Weight::Constant(at)) => sum.add(&self.constants[*at].mul(term)),
            });
        }
        self.or_zero(sum)
    }

    fn or_zero(&self, sum: Option<S>) -> S {
        sum.unwrap_or_else(|| self.zero.clone())
    }

    /// Σ_j a_j b_(k-j) over j >= `from`; `None` where all products are exactly zero. A row that has no k-th
    /// coefficient yet takes part with those it has.
    fn convolution(&self, a: usize, b: usize, k: usize, from: usize) -> Option<S> {
        if self.broken[a] || self.broken[b] {
            return Some(self.not_a_number());
        }
        let low = from.max((k + 1).saturating_sub(self.live[b]));
        let high = (k + 1).min(self.live[a]);
        if low >= high {
            return None;
        }
        // j from low to high - 1 beside k - j from k - low down to k + 1 - high.
        let left = self.rows[a].get(low..high)?;
        let right = self.rows[b].get(k + 1 - high..k + 1 - low)?;
        let mut products = left.iter().zip(right.iter().rev());
        let (first, second) = products.next()?;
        let mut sum = first.mul(second);
        for (x, y) in products {
            sum = sum.add(&x.mul(y));
        }
        Some(sum)
    }

    /// Σ_j a_j a_(k-j) over `from` <= j <= k - `from`: each product of two different coefficients once.
    fn square(&self, a: usize, k: usize, from: usize) -> S {
        if self.broken[a] {
            return self.not_a_number();
        }
        let row = &self.rows[a];
        let live = self.live[a];
        let low = from.max((k + 1).saturating_sub(live));
        let half = k.div_ceil(2);
        let mut sum: Option<S> = None;
        for j in low..half {
            let product = row[j].mul(&row[k - j]);
            sum = Some(match sum {
                None => product,
                Some(sum) => sum.add(&product),
            });
        }
        let mut sum = sum.map(|sum| sum.add(&sum));
        if k.is_multiple_of(2) && half >= from && half < live {
            let middle = row[half].powi(2);
            sum = Some(match sum {
                None => middle,
                Some(sum) => sum.add(&middle),
            });
        }
        self.or_zero(sum)
    }

    /// q = a/b: b_0 q_k = a_k - Σ_(j=1..k) b_j q_(k-j), where q is the row that is being filled.
    fn quotient(&self, a: usize, b: usize, q: usize, k: usize) -> S {
        let rest = match self.convolution(b, q, k, 1) {
            None if self.live[a] <= k && k > 0 => return self.zero.clone(),
            None => self.rows[a][k].clone(),
            Some(known) => self.rows[a][k].sub(&known),
        };
        rest.div(&self.rows[b][0])
    }

    /// s = sqrt a: 2 s_0 s_k = a_k - Σ_(j=1..k-1) s_j s_(k-j), where s is the row that is being filled.
    fn root(&self, a: usize, s: usize, k: usize) -> S {
        let rest = self.rows[a][k].sub(&self.square(s, k, 1));
        let first = &self.rows[s][0];
        rest.div(&first.add(first))
    }
}
