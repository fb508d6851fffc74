//! Taylor coefficients of compiled expressions along a curve, order by order.
//!
//! Where the inputs of a tape are power series in one variable, so are its outputs, and the k-th coefficient of every
//! operation follows from the coefficients up to the k-th of its operands by O(k) products (A. Griewank and
//! A. Walther, Evaluating Derivatives, 2nd ed. (2008), chapter 13; D. E. Knuth, The Art of Computer Programming 2, §4.7).
//! With the operator theta f = t df/dt, whose coefficients are k f_k, a function with f' = g obeys
//! theta f(a) = g(a) theta a, thus k f_k = Σ_(j=1..k) j a_j g_(k-j): only coefficients of g below the k-th.
//!
//! Coefficients are kept per operation with the place behind the last one that is not exactly zero, so that constants
//! and polynomials cost what they are worth; what depends on no input is worked out once. Over enclosures every
//! coefficient is enclosed. Nothing is allocated after [`Series::clear`] for orders that were reached before (by numbers
//! that do not allocate themselves). `lower` takes tapes apart to operations on series, this file runs them.

mod lower;

use lower::{Lowered, Start, Step};

use super::Function;
use super::tape::{Prepared, Weight};
use crate::budget::Budget;
use crate::number::Number;
use crate::precision::Scalar;

/// Coefficients of an operation that there is room for at first.
const ROOM: usize = 8;

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
/// # Ok::<(), librate_core::expr::UnboundSymbol>(())
/// ```
#[derive(Clone, Debug)]
pub struct Series<S: Scalar> {
    steps: Vec<Step>,
    /// The steps that depend on an input: no other has coefficients beyond the first.
    moving: Vec<usize>,
    outputs: Vec<usize>,
    /// The first one is 1.
    constants: Vec<S>,
    zero: S,
    pi: S,
    /// 0, 1, 2, … as far as orders went.
    counts: Vec<S>,
    /// The coefficients of one step after the other, those of higher order than was reached without meaning.
    coefficients: Vec<S>,
    /// How many coefficients of each step there is room for.
    room: usize,
    /// For each step the place behind its last coefficient that is not exactly zero.
    live: Vec<usize>,
    /// Whether a coefficient of the step is not a number: then no product with it is one, by 0 neither.
    broken: Vec<bool>,
    /// Whether steps that depend on no input are worked out.
    settled: bool,
    /// Whether one of these is not a number.
    spoilt: bool,
    order: usize,
    out: Vec<S>,
    precision: S::Precision,
    budget: Budget,
}

impl<S: Scalar> Prepared<S> {
    /// The tape as a map of power series, ready for the coefficients of order 0.
    #[must_use]
    pub fn series(&self) -> Series<S> {
        let Lowered { steps, moving, outputs } = lower::lower(&self.code);
        let count = steps.len();
        let zero = S::from_number(&Number::ZERO, self.precision);
        Series {
            steps,
            moving,
            out: vec![zero.clone(); outputs.len()],
            outputs,
            constants: self.constants.clone(),
            pi: S::pi(self.precision),
            counts: vec![zero.clone()],
            coefficients: Vec::new(),
            room: 0,
            live: vec![0; count],
            broken: vec![false; count],
            settled: false,
            spoilt: false,
            order: 0,
            zero,
            precision: self.precision,
            budget: self.code.budget.clone(),
        }
    }
}

impl<S: Scalar> Series<S> {
    /// Forgets all coefficients: the next ones are those of order 0.
    pub fn clear(&mut self) {
        self.order = 0;
        for at in &self.moving {
            self.live[*at] = 0;
            self.broken[*at] = false;
        }
    }

    /// Whether the budget is used up: then no further coefficient is a number.
    #[must_use]
    pub fn is_spent(&self) -> bool {
        self.budget.is_spent()
    }

    /// The k-th Taylor coefficients of all outputs from those of all inputs, in the order of
    /// [`super::Tape::compile`]; k counts up with each call. An input that is left out is not a number.
    ///
    /// What has no expansion is not finite: a root or a power that is not whole where its base begins with 0, an
    /// absolute value where the sign is not decided, an angle on both sides of its jump. (A series whose base is constant so far is constant.)
    pub fn next(&mut self, inputs: &[S]) -> &[S] {
        let k = self.order;
        if self.budget.is_spent() {
            self.order += 1;
            let undefined = self.not_a_number();
            self.out.fill(undefined);
            return &self.out;
        }
        while self.counts.len() <= k {
            let count = Number::from(i64::try_from(self.counts.len()).unwrap_or(i64::MAX));
            self.counts.push(S::from_number(&count, self.precision));
        }
        if k >= self.room {
            self.make_room((2 * self.room).max(ROOM));
        }
        if self.settled && !self.spoilt {
            for place in 0..self.moving.len() {
                self.advance(self.moving[place], inputs, k);
            }
        } else {
            for at in 0..self.steps.len() {
                self.advance(at, inputs, k);
            }
            if !self.settled {
                self.settled = true;
                let rests = |at: &usize| self.moving.binary_search(at).is_err();
                self.spoilt = (0..self.steps.len()).filter(rests).any(|at| self.broken[at]);
            }
        }
        for (place, step) in self.out.iter_mut().zip(&self.outputs) {
            *place = self.coefficients[self.room * step + k].clone();
        }
        self.order += 1;
        &self.out
    }

    /// The place behind the last coefficient of an output that is not exactly zero, so far.
    #[must_use]
    pub fn live(&self, output: usize) -> usize {
        self.outputs.get(output).map_or(0, |step| self.live[*step])
    }

    fn make_room(&mut self, room: usize) {
        let mut coefficients = vec![self.zero.clone(); room * self.steps.len()];
        let old = self.coefficients.chunks_exact_mut(self.room.max(1));
        for (old, new) in old.zip(coefficients.chunks_exact_mut(room)) {
            for (old, new) in old.iter_mut().zip(new) {
                std::mem::swap(old, new);
            }
        }
        self.coefficients = coefficients;
        self.room = room;
    }

    #[inline(always)]
    fn advance(&mut self, at: usize, inputs: &[S], k: usize) {
        let value = self.coefficient(at, inputs, k);
        if !value.is_exact_zero() {
            self.live[at] = k + 1;
            self.broken[at] |= !value.is_finite();
        }
        self.coefficients[self.room * at + k] = value;
    }

    /// The coefficients of a step.
    #[inline(always)]
    fn row(&self, step: usize) -> &[S] {
        &self.coefficients[self.room * step..self.room * (step + 1)]
    }

    /// Whether the series is a constant as far as it goes.
    fn constant(&self, row: usize) -> bool {
        self.live[row] <= 1
    }

    fn not_a_number(&self) -> S {
        self.zero.div(&self.zero)
    }

    fn coefficient(&self, own: usize, inputs: &[S], k: usize) -> S {
        let at = |row: usize| &self.coefficients[self.room * row + k];
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
            Step::Multiple { constant, of } => self.constants[*constant].mul(at(*of)),
            Step::Product(a, b) => self.or_zero(self.convolution(*a, *b, k, 0)),
            Step::Square(a) => self.square(*a, k, 0),
            Step::Quotient(a, b) => self.quotient(*a, *b, own, k),
            Step::Root(a) if k == 0 => at(*a).sqrt(),
            Step::Root(a) if self.constant(*a) => self.zero.clone(),
            Step::Root(a) => self.root(*a, own, k),
            Step::Absolute(a) if k == 0 => at(*a).apply(Function::Abs),
            Step::Absolute(a) if self.constant(*a) => self.zero.clone(),
            Step::Absolute(a) => self.row(*a)[0].signum().mul(at(*a)),
            Step::Slope(_) if k == 0 => self.zero.clone(),
            Step::Slope(a) => self.counts[k].mul(at(*a)),
            Step::SlopeQuotient { slope, .. } if k == 0 || self.live[*slope] == 0 => self.zero.clone(),
            Step::SlopeQuotient { slope, divisor } => self.quotient(*slope, *divisor, own, k),
            Step::Integral { start, .. } if k == 0 => self.start(*start),
            // What has no value has no slope: across a jump that of an angle would say nothing of it.
            Step::Integral { .. } if self.broken[own] => self.not_a_number(),
            Step::Integral { slope, factor, negative, .. } => {
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
        let first = |row: usize| &self.row(row)[0];
        match start {
            Start::Function(function, x) => first(x).apply(function),
            Start::Power { base, exponent } => first(base).pow(first(exponent)),
            // Numbers on both sides of the negative x axis have angles that are no expansion of each other.
            Start::Angle { y, x } if self.may_cross(first(y), first(x)) => self.not_a_number(),
            Start::Angle { y, x } => first(y).atan2(first(x)),
        }
    }

    /// Whether a set of points (x, y) may lie on both sides of the negative x axis; a single point does not.
    fn may_cross(&self, y: &S, x: &S) -> bool {
        let decided = y.is_exact_zero() || y.signum().is_finite();
        !decided && !x.apply(Function::Ln).is_finite()
    }

    fn sum(&self, constant: Option<usize>, terms: &[(usize, Weight)], k: usize) -> S {
        let mut sum = constant.filter(|_| k == 0).map(|place| self.constants[place].clone());
        for (row, weight) in terms {
            if self.live[*row] <= k {
                continue;
            }
            let term = &self.row(*row)[k];
            sum = Some(weight.added(sum, term, &self.constants));
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
        let left = self.row(a).get(low..high)?;
        let right = self.row(b).get(k + 1 - high..k + 1 - low)?;
        S::convolution(left, right)
    }

    /// Σ_j a_j a_(k-j) over `from` <= j <= k - `from`: each product of two different coefficients once.
    fn square(&self, a: usize, k: usize, from: usize) -> S {
        if self.broken[a] {
            return self.not_a_number();
        }
        let row = self.row(a);
        let live = self.live[a];
        let low = from.max((k + 1).saturating_sub(live));
        let half = k.div_ceil(2);
        let sum = if low < half { S::convolution(&row[low..half], &row[k + 1 - half..k + 1 - low]) } else { None };
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
            None => self.row(a)[k].clone(),
            Some(known) => self.row(a)[k].sub(&known),
        };
        rest.div(&self.row(b)[0])
    }

    /// s = sqrt a: 2 s_0 s_k = a_k - Σ_(j=1..k-1) s_j s_(k-j), where s is the row that is being filled.
    fn root(&self, a: usize, s: usize, k: usize) -> S {
        let rest = self.row(a)[k].sub(&self.square(s, k, 1));
        let first = &self.row(s)[0];
        rest.div(&first.add(first))
    }
}
