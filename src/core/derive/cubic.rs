//! Cubic and quartic equations (and quadratic ones with long coefficients) whose zeros are all real, as those of det(K - z M) are with a positive definite M.
//!
//! Each is written down twice: in the parameters alone, which is what is checked and what programs read, and for a page, with names
//! for what would be repeated. With s_1, s_2, … the sums of products of one, two, … zeros the equations are
//!
//! ```text
//! z^3 - s_1 z^2 + s_2 z - s_3 = 0        z^4 - s_1 z^3 + s_2 z^2 - s_3 z + s_4 = 0
//! ```
//!
//! The cubic (Viète; Abramowitz and Stegun, 3.8.2 for real zeros): with p = s_1^2/9 - s_2/3 and q = s_1^3/27 - s_1 s_2/6 + s_3/2
//!
//! ```text
//! z = s_1/3 + 2 sqrt(p) cos((phi + 2 pi n)/3),   phi = acos(q/p^(3/2)),   n = 0, 1, 2
//! ```
//!
//! The other root of p gives the same three zeros, as acos(-x) = pi - acos(x), so that none needs an absolute value.
//!
//! The quartic (Ferrari): z = x + s_1/4 makes it x^4 + p x^2 + q x + r = (x^2 + sqrt(y) x + b)(x^2 - sqrt(y) x + c) with
//! b + c = p + y and sqrt(y) (c - b) = q, where bc = r is the resolvent y^3 + 2 p y^2 + (p^2 - 4 r) y - q^2 = 0. Its zeros are the
//! squares of sums of two of the x, which are real, so that none is negative; any but 0 will do. Hence with a sign s
//!
//! ```text
//! z = s_1/4 + s sqrt(y)/2 ± sqrt(-2 p - y - 2 s q/sqrt(y))/2
//! ```

use super::normal::Abbreviation;
use super::roots::{Request, root};
use super::simplify::Algebra;
use crate::expr::{ExprId, Pool, ratio};
use crate::model::Model;
use crate::number::Number;
use crate::precision::Function;

/// What has more symbols gets a name.
const MOST_WITHOUT_NAME: u64 = 5;
/// Formulas of more symbols, with what their names stand for, are no help to anybody.
pub(super) const MOST_ON_PAGE: u64 = 600;
/// Longer sums are left as they are.
const MOST_TO_SIMPLIFY: u64 = 400;

/// The frequencies of a block as they stand on a page, where names make them shorter.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Solved {
    /// The squares of the frequencies.
    pub formulas: Vec<SolvedFormula>,
    /// What the names in them stand for, each after those that occur in it.
    pub abbreviations: Vec<Abbreviation>,
    /// The same zeros written out, as they stand among the frequencies.
    pub frequencies: Vec<ExprId>,
}

/// One zero, or several that are told apart by a number.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SolvedFormula {
    /// omega^2.
    pub omega_squared: ExprId,
    /// What it is the sum of, in reading order.
    pub terms: Vec<ExprId>,
    /// The letter for the number, and the numbers; nothing where there is no such letter.
    pub numbers: Option<(String, Vec<i64>)>,
}

/// Zeros as they are found, each in the terms it is the sum of.
struct Zeros {
    all: Vec<Vec<ExprId>>,
    /// As a formula with a letter for the number of the zero.
    family: Option<Vec<ExprId>>,
}

/// Gives names, where there is a model to keep clear of.
struct Names<'a> {
    model: Option<&'a Model>,
    /// Behind a letter, for the second block and all others.
    suffix: String,
    /// Whether the coefficients have names.
    coefficients: bool,
    given: Vec<(String, ExprId)>,
}

impl Names<'_> {
    fn name(&mut self, pool: &mut Algebra<'_>, letters: &[&str], value: ExprId) -> ExprId {
        self.numbered(pool, letters, None, value)
    }

    fn numbered(&mut self, pool: &mut Algebra<'_>, letters: &[&str], number: Option<usize>, value: ExprId) -> ExprId {
        let Some(model) = self.model else { return value };
        if pool.weight(value) <= MOST_WITHOUT_NAME {
            return value;
        }
        let letter = model.unused_name(letters);
        let name = match number {
            Some(number) => format!("{letter}{}[{number}]", self.suffix),
            None => format!("{letter}{}", self.suffix),
        };
        let symbol = pool.variable(&name);
        self.given.push((name, value));
        symbol
    }
}

/// The zeros of z^n - s_1 z^(n-1) + s_2 z^(n-2) - …, n = 2 to 4. `None` where the formulas would be too long; else with the
/// symbols that they and their names take.
pub(super) fn solve(pool: &mut Algebra<'_>, request: Request<'_>, sums: &[ExprId]) -> Option<(u64, Solved)> {
    let Request { model, before, .. } = request;
    let letter = model.unused_name(&["n", "j", "r", "u"]);
    let q = if let [a, b, c, _] = sums { Some(middle(pool, *a, *b, *c)) } else { None };
    let biquadratic = q.is_some_and(|q| pool.vanishes(q));
    let mut best: Option<(u64, Solved)> = None;
    // As they stand among the frequencies.
    let mut written: Option<Vec<ExprId>> = None;
    // Without names, with names for p and q alone, and for the coefficients too.
    for (model, coefficients) in [(None, false), (Some(model), false), (Some(model), true)] {
        let suffix = if before == 0 { String::new() } else { (before + 1).to_string() };
        let mut names = Names { model, suffix, coefficients, given: Vec::new() };
        let found = zeros(pool, &mut names, sums, biquadratic, &letter);
        let written = written.get_or_insert_with(|| found.all.iter().map(|terms| pool.sum(terms)).collect());
        let numbers = found.family.as_ref().map(|_| (letter.clone(), vec![0, 1, 2]));
        let shown = found.family.map_or(found.all, |family| vec![family]);
        let formulas: Vec<SolvedFormula> = shown
            .into_iter()
            .map(|terms| SolvedFormula { omega_squared: pool.sum(&terms), terms, numbers: numbers.clone() })
            .collect();
        let shown = formulas.iter().map(|formula| formula.omega_squared);
        let shown: Vec<ExprId> = shown.chain(names.given.iter().map(|(_, e)| *e)).collect();
        let weight = pool.weight_of(&shown);
        if best.as_ref().is_none_or(|(least, _)| weight < *least) {
            let abbreviations = names.given.into_iter();
            let abbreviations =
                abbreviations.map(|(name, value)| Abbreviation { names: vec![name], value, modes: None });
            let solved = Solved { formulas, abbreviations: abbreviations.collect(), frequencies: written.clone() };
            best = Some((weight, solved));
        }
    }
    best.filter(|(weight, _)| *weight <= MOST_ON_PAGE)
}

fn zeros(pool: &mut Algebra<'_>, names: &mut Names<'_>, sums: &[ExprId], biquadratic: bool, letter: &str) -> Zeros {
    let mut sums = sums.to_vec();
    if names.coefficients {
        let name = |(at, sum)| names.numbered(pool, &["s", "sigma", "S"], Some(at + 1), sum);
        sums = sums.into_iter().enumerate().map(name).collect();
    }
    match *sums.as_slice() {
        [a, b] => quadratic(pool, [a, b]),
        [a, b, c] => cubic(pool, names, [a, b, c], letter),
        [a, b, c, d] => quartic(pool, names, [a, b, c, d], biquadratic),
        _ => Zeros { all: Vec::new(), family: None },
    }
}

fn shortened(pool: &mut Algebra<'_>, make: impl FnOnce(&mut Pool) -> ExprId) -> ExprId {
    let e = make(pool);
    if pool.weight(e) <= MOST_TO_SIMPLIFY { pool.simplify(e) } else { e }
}

/// s_1/2 ± sqrt(s_1^2/4 - s_2)
fn quadratic(pool: &mut Algebra<'_>, [a, b]: [ExprId; 2]) -> Zeros {
    let half = pool.scale(a, &Number::half());
    let square = pool.square(a);
    let inside = shortened(pool, |pool| pool.linear(&[(square, ratio(1, 4)), (b, Number::MINUS_ONE)]));
    let (size, _) = root(pool, inside);
    let all = [Number::MINUS_ONE, Number::ONE].map(|sign| vec![half, pool.scale(size, &sign)]);
    Zeros { all: all.to_vec(), family: None }
}

fn cubic(pool: &mut Algebra<'_>, names: &mut Names<'_>, [a, b, c]: [ExprId; 3], letter: &str) -> Zeros {
    let middle = pool.scale(a, &ratio(1, 3));
    let square = pool.square(a);
    let p = pool.linear(&[(square, ratio(1, 9)), (b, ratio(-1, 3))]);
    if pool.vanishes(p) {
        return Zeros { all: vec![vec![middle]; 3], family: None };
    }
    let p = shortened(pool, |_| p);
    let (cube, product) = (pool.powi(a, 3), pool.mul(a, b));
    let q = [(cube, ratio(1, 27)), (product, ratio(-1, 6)), (c, ratio(1, 2))];
    let q = shortened(pool, |pool| pool.linear(&q));
    let p = names.name(pool, &["p", "P", "rho"], p);
    let q = names.name(pool, &["q", "kappa", "chi"], q);
    let (size, _) = root(pool, p);
    let cosine = shortened(pool, |pool| pool.product_of_powers(&[(q, Number::ONE), (size, ratio(-3, 1))]));
    let phi = pool.apply(Function::Acos, cosine);
    let phi = names.name(pool, &["phi", "psi", "beta"], phi);
    let zero = |pool: &mut Pool, n: ExprId| {
        let turns = pool.mul(pool.pi(), n);
        let angle = pool.linear(&[(phi, ratio(1, 3)), (turns, ratio(2, 3))]);
        let cosine = pool.cos(angle);
        let product = pool.mul(size, cosine);
        vec![middle, pool.scale(product, &Number::from(2))]
    };
    let all = [0, 1, 2].map(|n| pool.integer(n)).map(|n| zero(pool, n)).to_vec();
    let any = pool.variable(letter);
    let family = zero(pool, any);
    Zeros { all, family: Some(family) }
}

/// q of the quartic: -s_3 + s_1 s_2/2 - s_1^3/8.
fn middle(pool: &mut Pool, a: ExprId, b: ExprId, c: ExprId) -> ExprId {
    let (cube, product) = (pool.powi(a, 3), pool.mul(a, b));
    pool.linear(&[(c, Number::MINUS_ONE), (product, Number::half()), (cube, ratio(-1, 8))])
}

fn quartic(pool: &mut Algebra<'_>, names: &mut Names<'_>, [a, b, c, d]: [ExprId; 4], biquadratic: bool) -> Zeros {
    let square = pool.square(a);
    let p = shortened(pool, |pool| pool.linear(&[(b, Number::ONE), (square, ratio(-3, 8))]));
    let (ac, aab) = (pool.mul(a, c), pool.mul(square, b));
    let fourth = pool.powi(a, 4);
    let r = [(d, Number::ONE), (ac, ratio(-1, 4)), (aab, ratio(1, 16)), (fourth, ratio(-3, 256))];
    let r = shortened(pool, |pool| pool.linear(&r));
    let p = names.name(pool, &["p", "P", "rho"], p);
    let quarter = pool.scale(a, &ratio(1, 4));
    let mut all = Vec::new();
    if biquadratic {
        // x^2 = -p/2 ± sqrt(p^2/4 - r)
        let square = pool.square(p);
        let inside = shortened(pool, |pool| pool.linear(&[(square, ratio(1, 4)), (r, ratio(-1, 1))]));
        let (size, _) = root(pool, inside);
        for sign in [-1, 1] {
            let square = pool.linear(&[(p, ratio(-1, 2)), (size, ratio(sign, 1))]);
            let x = pool.sqrt(square);
            all.extend([-1, 1].map(|sign| vec![quarter, pool.scale(x, &ratio(sign, 1))]));
        }
        return Zeros { all, family: None };
    }
    let q = shortened(pool, |pool| middle(pool, a, b, c));
    let q = names.name(pool, &["q", "kappa", "chi"], q);
    let r = names.name(pool, &["r", "R", "mu"], r);
    // The resolvent with y = t - 2 p/3: t^3 - (p^2 + 12 r)/3 t - (2 p^3 - 72 p r + 27 q^2)/27 = 0.
    let (square, cube) = (pool.square(p), pool.powi(p, 3));
    let size = shortened(pool, |pool| pool.linear(&[(square, Number::ONE), (r, Number::from(12))]));
    let (size, _) = root(pool, size);
    let (pr, qq) = (pool.mul(p, r), pool.square(q));
    let above = [(cube, Number::ONE), (pr, Number::from(-36)), (qq, ratio(27, 2))];
    let above = shortened(pool, |pool| pool.linear(&above));
    let cosine = pool.product_of_powers(&[(above, Number::ONE), (size, ratio(-3, 1))]);
    let phi = pool.apply(Function::Acos, cosine);
    let phi = names.name(pool, &["phi", "psi", "beta"], phi);
    let third = pool.scale(phi, &ratio(1, 3));
    let cosine = pool.cos(third);
    let product = pool.mul(size, cosine);
    let y = pool.linear(&[(product, ratio(2, 3)), (p, ratio(-2, 3))]);
    let y = names.name(pool, &["y", "Y", "eta"], y);
    let width = pool.sqrt(y);
    let slope = pool.div(q, width);
    for sign in [-1, 1] {
        let inside = pool.linear(&[(p, Number::from(-2)), (y, Number::MINUS_ONE), (slope, Number::from(-2 * sign))]);
        let half = pool.sqrt(inside);
        for other in [-1, 1] {
            let (first, second) = (ratio(sign, 2), ratio(other, 2));
            all.push(vec![quarter, pool.scale(width, &first), pool.scale(half, &second)]);
        }
    }
    Zeros { all, family: None }
}
