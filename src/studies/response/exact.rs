//! The response at a frequency at which the linear system is singular, or nearly so, from exact matrices.
//!
//! With M, D = G + C and S rational, and so the frequency, x(ω + ε) is a quotient of polynomials in ε for each force on one coordinate.
//! Elimination over Laurent series in ε with Gaussian rationals for coefficients gives its first terms exactly: a negative power is a
//! resonance, none a finite limit, also where the force or the output is orthogonal to the mode at that frequency. Without D the variable is ω², so
//! that only this has to be rational.

use super::Value;
use librate_core::expr::{ExprId, Pool};
use librate_core::linearize::{Linearized, power_of_two};
use librate_core::number::Number;
use librate_core::precision::{Ball, Complex, Root, Scalar};

/// More coordinates, multipliers among them, are not eliminated exactly.
const MOST: usize = 24;

/// Powers of ε that are kept at first.
const TERMS: usize = 4;

/// The end of the powers of what is exactly 0.
const NEVER: i32 = 1 << 20;

/// Bits of units.
const BITS: usize = 192;

/// A Gaussian rational.
#[derive(Clone, Debug, Default)]
struct Gaussian {
    re: Number,
    im: Number,
}

impl Gaussian {
    fn real(re: Number) -> Self {
        Self { re, im: Number::ZERO }
    }

    fn is_zero(&self) -> bool {
        self.re.is_zero() && self.im.is_zero()
    }

    fn add(&self, other: &Self) -> Self {
        Self { re: self.re.add(&other.re), im: self.im.add(&other.im) }
    }

    fn neg(&self) -> Self {
        Self { re: self.re.neg(), im: self.im.neg() }
    }

    fn mul(&self, other: &Self) -> Self {
        Self {
            re: self.re.mul(&other.re).sub(&self.im.mul(&other.im)),
            im: self.re.mul(&other.im).add(&self.im.mul(&other.re)),
        }
    }

    fn inverse(&self) -> Option<Self> {
        let square = self.re.mul(&self.re).add(&self.im.mul(&self.im)).recip()?;
        Some(Self { re: self.re.mul(&square), im: self.im.neg().mul(&square) })
    }
}

/// Σ terms_k ε^(low + k), and what is of higher order than all of these. The first term is not 0.
#[derive(Clone, Debug)]
struct Series {
    low: i32,
    terms: Vec<Gaussian>,
}

impl Series {
    fn new(low: i32, mut terms: Vec<Gaussian>) -> Self {
        let zeros = terms.iter().take_while(|term| term.is_zero()).count();
        terms.drain(..zeros);
        Self { low: low + i32::try_from(zeros).unwrap_or(NEVER), terms }
    }

    /// A polynomial, known to so many terms.
    fn polynomial(coefficients: Vec<Gaussian>, terms: usize) -> Self {
        if coefficients.iter().all(Gaussian::is_zero) {
            return Self { low: NEVER, terms: Vec::new() };
        }
        let padded = coefficients.into_iter().chain(std::iter::repeat_with(Gaussian::default)).take(terms);
        Self::new(0, padded.collect())
    }

    /// The power from which on nothing is known.
    fn end(&self) -> i32 {
        self.low.saturating_add(i32::try_from(self.terms.len()).unwrap_or(NEVER)).min(NEVER)
    }

    fn is_zero(&self) -> bool {
        self.terms.is_empty() && self.low >= NEVER
    }

    fn term(&self, power: i32) -> Gaussian {
        let place = usize::try_from(power - self.low).ok();
        place.and_then(|place| self.terms.get(place)).cloned().unwrap_or_default()
    }

    fn sub(&self, other: &Self) -> Self {
        let end = self.end().min(other.end());
        let low = self.low.min(other.low).min(end);
        Self::new(low, (low..end).map(|power| self.term(power).add(&other.term(power).neg())).collect())
    }

    fn mul(&self, other: &Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self { low: NEVER, terms: Vec::new() };
        }
        let count = self.terms.len().min(other.terms.len());
        let sum = |k: usize| {
            let products = (0..=k).map(|i| self.terms[i].mul(&other.terms[k - i]));
            products.fold(Gaussian::default(), |sum, product| sum.add(&product))
        };
        Self::new(self.low + other.low, (0..count).map(sum).collect())
    }

    fn inverse(&self) -> Option<Self> {
        let first = self.terms.first()?.inverse()?;
        let mut terms: Vec<Gaussian> = vec![first.clone()];
        for k in 1..self.terms.len() {
            let products = (1..=k).map(|i| self.terms[i].mul(&terms[k - i]));
            let sum = products.fold(Gaussian::default(), |sum, product| sum.add(&product));
            terms.push(sum.mul(&first).neg());
        }
        Some(Self { low: -self.low, terms })
    }
}

/// A frequency.
pub(super) struct Frequency {
    /// Its square.
    square: Number,
    /// Itself, where it is rational.
    value: Option<Number>,
}

impl Frequency {
    /// That of an expression whose square is rational.
    pub(super) fn of(pool: &mut Pool, value: ExprId) -> Option<Self> {
        let square = pool.square(value);
        Some(Self { square: pool.as_number(square)?.clone(), value: pool.as_number(value).cloned() })
    }
}

/// The exact system, in units of its own.
#[derive(Clone, Debug)]
pub(super) struct Exact {
    order: usize,
    /// M, G + C and K + N, column by column.
    matrices: [Vec<Number>; 3],
    is_real: bool,
    /// The square of the unit of frequencies, and the unit.
    rate: (Number, Option<Number>),
    /// What the matrices were multiplied with.
    factor: Ball,
    /// Units of coordinates, and those of forces on them.
    coordinates: Vec<[Ball; 2]>,
}

impl Exact {
    /// `None` where the matrices are not rational in some units.
    pub(super) fn of(own: &Linearized) -> Option<Self> {
        let own = own.bordered()?;
        let order = own.dimension();
        if order > MOST {
            return None;
        }
        let found = own.integers().filter(|found| found.roots.is_empty())?;
        let matrices = found.matrices.map(|matrix| matrix.into_iter().map(Number::from_integer).collect::<Vec<_>>());
        let unit = |root: &Root| root.value(BITS).to_ball();
        let units: Vec<Ball> = found.coordinates.iter().map(unit).collect();
        let rate = unit(&found.rate);
        let (mass, (_, stiffness)) = (own.mass(), own.velocity_and_stiffness());
        let factor = (0..order * order).find_map(|at| {
            let both = units[at % order] * units[at / order];
            let of = |exact: &Number, entry: Ball| {
                let factor = Ball::from_number(exact, ()) / entry;
                (!exact.is_zero() && factor.is_finite()).then_some(factor)
            };
            of(&matrices[2][at], stiffness[at] * both).or_else(|| of(&matrices[0][at], mass[at] * both * rate * rate))
        })?;
        let powers = own.units();
        let own_rate = powers.map_or(0, |units| units.rate());
        let radicand = Number::from_integer(found.rate.radicand.clone());
        let (square, value) = match found.rate.index {
            1 => (radicand.mul(&radicand), Some(radicand)),
            2 => (radicand, None),
            _ => return None,
        };
        let rate = (square.mul(&power_of_two(2 * own_rate)), value.map(|value| value.mul(&power_of_two(own_rate))));
        let energy = powers.map_or(0, |units| units.energy());
        let of_coordinate = |(at, unit): (usize, &Ball)| {
            let length = powers.map_or(0, |units| units.length(at));
            [unit.scale_far(length), unit.scale_far(length - energy)]
        };
        let coordinates = units.iter().enumerate().map(of_coordinate).collect();
        let is_real = matrices[1].iter().all(Number::is_zero);
        Some(Self { order, matrices, is_real, rate, factor, coordinates })
    }

    /// What outputs tend to at a frequency, for forces in SI: a finite response, or the value where there is none or it is open.
    pub(super) fn limits(
        &self,
        frequency: &Frequency,
        forces: &[(usize, Complex<Ball>)],
        outputs: &[usize],
    ) -> Option<Vec<Result<Complex<Ball>, Value>>> {
        let square = frequency.square.div(&self.rate.0)?;
        let value = match (&frequency.value, &self.rate.1) {
            (Some(value), Some(rate)) => value.div(rate),
            _ => None,
        };
        let inputs: Vec<usize> = forces.iter().map(|(at, _)| *at).collect();
        let mut terms = TERMS;
        loop {
            let rows = self.rows(&square, value.as_ref(), &inputs, terms)?;
            let known = solved(rows, self.order);
            let enough = |found: &Vec<Vec<Series>>| outputs.iter().all(|at| found[*at].iter().all(|own| own.end() > 0));
            match known.filter(enough) {
                Some(found) => return Some(outputs.iter().map(|at| self.limit(&found[*at], forces, *at)).collect()),
                None if terms > 2 * self.order => return None,
                None => terms *= 2,
            }
        }
    }

    /// The matrix and unit right sides, row by row.
    fn rows(
        &self,
        square: &Number,
        value: Option<&Number>,
        inputs: &[usize],
        terms: usize,
    ) -> Option<Vec<Vec<Series>>> {
        let n = self.order;
        let entry = |at: usize| -> Option<Series> {
            let [mass, velocity, stiffness] = [0, 1, 2].map(|matrix| &self.matrices[matrix][at]);
            let first = stiffness.sub(&square.mul(mass));
            let coefficients = if self.is_real {
                vec![Gaussian::real(first), Gaussian::real(mass.neg())]
            } else {
                let value = value?;
                let slope = value.mul(mass).mul(&Number::from(-2));
                vec![
                    Gaussian { re: first, im: value.mul(velocity) },
                    Gaussian { re: slope, im: velocity.clone() },
                    Gaussian::real(mass.neg()),
                ]
            };
            Some(Series::polynomial(coefficients, terms))
        };
        let row = |i: usize| {
            let own = (0..n).map(|j| entry(i + n * j));
            let unit = |at: &usize| {
                let number = if *at == i { Number::ONE } else { Number::ZERO };
                Some(Series::polynomial(vec![Gaussian::real(number)], terms))
            };
            own.chain(inputs.iter().map(unit)).collect()
        };
        (0..n).map(row).collect()
    }

    /// What an output tends to, from its response to each unit force.
    fn limit(
        &self,
        responses: &[Series],
        forces: &[(usize, Complex<Ball>)],
        output: usize,
    ) -> Result<Complex<Ball>, Value> {
        let at_power = |power: i32| -> (Complex<Ball>, bool) {
            let mut sum = Complex::new(Ball::ZERO, Ball::ZERO);
            let mut vanishes = true;
            for (own, (input, force)) in responses.iter().zip(forces) {
                let term = own.term(power);
                if term.is_zero() || force.is_zero() {
                    continue;
                }
                vanishes = false;
                let units = self.coordinates[output][0] * self.coordinates[*input][1] * self.factor;
                let term = Complex::new(Ball::from_number(&term.re, ()), Ball::from_number(&term.im, ()));
                sum = sum.add(&term.mul(force).times(&units));
            }
            (sum, vanishes)
        };
        let low = responses.iter().map(|own| own.low).min().unwrap_or(0);
        for power in low..0 {
            let (sum, vanishes) = at_power(power);
            if !vanishes {
                return Err(if sum.contains_zero() { Value::Undecided } else { Value::Infinite });
            }
        }
        Ok(at_power(0).0)
    }
}

/// The solutions for all right sides, by Gauss-Jordan elimination; `None` where the terms do not suffice.
fn solved(mut rows: Vec<Vec<Series>>, order: usize) -> Option<Vec<Vec<Series>>> {
    let mut pivots: Vec<(usize, usize)> = Vec::with_capacity(order);
    for _ in 0..order {
        let is_free = |row: usize, column: usize| pivots.iter().all(|(r, c)| *r != row && *c != column);
        let places = (0..order).flat_map(|row| (0..order).map(move |column| (row, column)));
        let candidates = places.filter(|(row, column)| is_free(*row, *column) && !rows[*row][*column].terms.is_empty());
        let (row, column) = candidates.min_by_key(|(row, column)| rows[*row][*column].low)?;
        let inverse = rows[row][column].inverse()?;
        let own: Vec<Series> = rows[row].iter().map(|entry| entry.mul(&inverse)).collect();
        for (_, other) in rows.iter_mut().enumerate().filter(|(at, _)| *at != row) {
            let factor = other[column].clone();
            if factor.is_zero() {
                continue;
            }
            for (entry, own) in other.iter_mut().zip(&own) {
                if !own.is_zero() {
                    *entry = entry.sub(&factor.mul(own));
                }
            }
        }
        rows[row] = own;
        pivots.push((row, column));
    }
    let mut solution = vec![Vec::new(); order];
    for (row, column) in pivots {
        solution[column] = rows[row].split_off(order);
    }
    Some(solution)
}
