//! The exponents of M q'' + (G + C) q' + (K + N) q = 0 in symbols: the zeros of the characteristic polynomial, where they can be
//! written down.
//!
//! Factors in which no zero is repeated are solved one by one: linear and quadratic ones, and even ones up to s⁴. Zeros are compared
//! with certified exponents before they are given out. Of conservative models the closed forms of the frequencies are taken.

use std::cmp::Ordering;

use hashbrown::HashMap;

use super::Linear;
use super::characteristic::Factored;
use super::check::{Checker, WIDEST};
use super::equilibria::sign_by_parameters;
use super::frequencies::{Approximation, Case};
use super::ring::EXPONENT;
use super::roots::{plain_root, root, up_to_sign, with_common_bar};
use super::shapes::on_one_bar;
use super::simplify::{A_STOREY, Algebra, Opening, expand, split, with_common_factor, written};
use crate::expr::{ExprId, Function, Node, Pool, Symbol};
use crate::linearize;
use crate::model::Parameter;
use crate::number::Number;
use crate::order::{Keyed, Order};
use crate::oscillation::NormalMode;
use crate::precision::{Ball, Complex, Scalar};

/// The roots of more expressions are left as they are.
const MOST_ROOTS: usize = 12;

/// What the motions exp(s t) of a linear system are, in symbols.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Exponents {
    /// det(s²M + s(G + C) + K + N) without what all coefficients have in common, the constant first; `None` where more than 24
    /// coordinates hang together, or it would be too long.
    pub characteristic: Option<Vec<ExprId>>,
    /// The zeros with a closed form.
    pub exponents: Vec<ClosedExponent>,
    /// Whether these are all zeros.
    pub complete: bool,
    /// What has to be positive for stability: together necessary and sufficient; M is taken to be positive definite, exponents that
    /// are 0 whatever the parameters are do not count. `None` where that is not written out.
    pub stability: Option<Vec<StabilityCondition>>,
    /// What together is necessary and sufficient, where `stability` has conditions that are shorter and only sufficient.
    pub stability_exact: Option<Vec<ExprId>>,
    /// Whether what holds always, or never, by these does so for special values of the parameters, too, at which a square is 0.
    pub settled: bool,
    /// What has been done to the exponents since.
    pub approximations: Vec<Approximation>,
    /// The parameters that have values, to tell which exponent of a pair has a positive imaginary part there.
    pub(super) values: Vec<(Symbol, f64)>,
}

impl Exponents {
    /// -s² of the exponents that are real or imaginary, or become so where a condition of stability holds, each pair once, as text with its
    /// multiplicity: what squares of frequencies are where nothing is damped.
    #[must_use]
    pub fn squares_of_frequencies(&self, pool: &mut Pool) -> Vec<(String, usize)> {
        let pool = &mut Algebra::new(pool);
        let mut all: Vec<(ExprId, usize)> = Vec::new();
        for own in &self.exponents {
            let square = match (own.real.is_zero(), own.imaginary.is_zero()) {
                (true, _) => pool.square(own.imaginary),
                (false, true) => {
                    let square = pool.square(own.real);
                    pool.neg(square)
                }
                // ±a ± ib with a = √(-r²) stand for ±i(b ± r) where r² > 0.
                (false, false) => {
                    let square = pool.square(own.real);
                    let negative = pool.neg(square);
                    let is_condition = |pool: &mut Algebra<'_>, condition: &StabilityCondition| {
                        let ratio = pool.div(condition.positive, negative);
                        let ratio = pool.simplify(ratio);
                        pool.as_number(ratio).is_some_and(|own| !own.is_zero() && !own.is_negative())
                    };
                    if !self.stability.iter().flatten().any(|condition| is_condition(pool, condition)) {
                        continue;
                    }
                    let root = pool.sqrt(negative);
                    let sum = pool.add(root, own.imaginary);
                    pool.square(sum)
                }
            };
            let square = pool.simplify(square);
            *all.under(square) += own.multiplicity;
        }
        all.into_iter().map(|(square, times)| (pool.display(square), times / 2)).collect()
    }
}

/// An exponent, as often as it is a zero of the characteristic polynomial.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ClosedExponent {
    /// Its real part.
    pub real: ExprId,
    /// Its imaginary part.
    pub imaginary: ExprId,
    /// How often it is a zero.
    pub multiplicity: usize,
    /// For a pair of a quadratic factor, -real/|s|, where that is not 0.
    pub damping_ratio: Option<ExprId>,
}

/// A product that has to be positive.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct StabilityCondition {
    /// What has to be positive.
    pub positive: ExprId,
    /// What is left of it wherever the parameters have the signs that they have in the model; `None` where it holds then.
    pub open: Option<ExprId>,
    /// What stands against leaving it out.
    pub role: Role,
}

/// What a condition of stability is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Role {
    /// Without it the system is unstable, or not asymptotically stable.
    Needed,
    /// It excludes special values at which exponents are equal or 0, where motions may be bounded or grow as powers of t.
    Special,
    /// The system may be stable without it.
    Sufficient,
}

impl StabilityCondition {
    pub(super) fn new(positive: ExprId, open: Option<ExprId>) -> Self {
        Self { positive, open, role: Role::Needed }
    }
}

/// The exponents, of conservative models from their frequencies.
pub(super) fn exponents(checker: &Checker<'_>, pool: &mut Algebra<'_>, linear: &Linear) -> Exponents {
    pool.budget().at("the exponents in symbols", None);
    let model = checker.model;
    let value = |own: &Parameter| Some((own.symbol, linearize::constant(&model.pool, own.value?)?.mid_f64()));
    let mut own = Exponents { values: model.parameters.iter().filter_map(value).collect(), ..Exponents::default() };
    let case = linear.frequencies.as_ref().map(|own| own.best()).filter(|case| case.complete);
    let parts = Factored::new(checker, pool, linear);
    let is_general = parts.is_some() || case.is_some_and(|case| case.ties.is_empty());
    let parts = parts.or_else(|| Factored::of_squares(checker, pool, linear, case?));
    if let Some(parts) = parts.as_ref().filter(|_| is_general) {
        own.characteristic = parts.characteristic(pool);
    }
    let mut found = Found { checker, pool, own: &mut own };
    // None are found where a combination of coordinates has no inertia, though the polynomial may have few zeros then.
    match (&linear.frequencies, &parts) {
        (Some(all), Some(parts)) if all.best().frequencies.is_empty() => found.of_factors(parts),
        (Some(all), _) => found.of_frequencies(all.best()),
        (None, Some(parts)) => found.of_factors(parts),
        (None, None) => {}
    }
    // Of equal parameters nothing is told of others.
    let stability = parts.filter(|_| is_general).and_then(|parts| parts.stability(pool));
    if let Some(found) = stability {
        own.settled = found.settled;
        own.stability_exact = Some(found.exact).filter(|all| !all.is_empty());
        own.stability = Some(found.all);
    }
    own
}

/// Closed forms on their way.
struct Found<'a, 'p> {
    checker: &'a Checker<'a>,
    pool: &'a mut Algebra<'p>,
    own: &'a mut Exponents,
}

/// Whether absolute values occur.
fn has_bars(pool: &Pool, e: ExprId) -> bool {
    pool.reachable(&[e]).iter().any(|id| matches!(pool.node(*id), Node::Function(Function::Abs, _)))
}

/// Real and imaginary part.
type Zero = (ExprId, ExprId);

impl Found<'_, '_> {
    /// How an expression compares with 0 at the values of the parameters.
    fn sign(&mut self, e: ExprId) -> Option<Ordering> {
        match self.checker.is_negative(self.pool, e) {
            Some(negative) => Some(if negative { Ordering::Less } else { Ordering::Greater }),
            None => self.vanishes(e).then_some(Ordering::Equal),
        }
    }

    fn vanishes(&mut self, e: ExprId) -> bool {
        let value = self.checker.at_values(self.pool, &[e]);
        value.iter().all(|value| self.pool.vanishes(*value))
    }

    /// An expression or its opposite, whichever is not negative: in bars where no values tell.
    fn positive(&mut self, e: ExprId) -> Option<ExprId> {
        self.sign(e)?;
        let size = self.pool.abs(e);
        let own: Vec<ExprId> = self.pool.factors(size).iter().map(|(base, _)| *base).collect();
        Some(self.without_bars(&[size], |all, bars, inner| own.contains(&bars) || all.follows(inner))[0])
    }

    /// A number times a/b.
    fn quotient(&mut self, a: ExprId, b: ExprId, by: Number) -> ExprId {
        let quotient = self.pool.div(a, b);
        self.pool.short(|pool| pool.scale(quotient, &by))
    }

    /// A square root, up to its sign, the best to read of the root as it stands and those over one fraction bar.
    fn root(&mut self, e: ExprId) -> ExprId {
        let (plain, exact) = root(self.pool, e);
        if exact {
            return plain;
        }
        let over = on_one_bar(self.pool, e);
        // A minus sign goes into the sum behind it.
        let (factor, core) = split(self.pool, over);
        let terms = expand(self.pool, core, Opening::Outermost).filter(|_| factor.is_negative());
        let opened = terms.map(|terms| written(self.pool, terms.iter()));
        let opened = opened.map_or(over, |sum| self.pool.scale(sum, &factor));
        let all = [plain, root(self.pool, over).0, plain_root(self.pool, opened)];
        all.into_iter().min_by_key(|own| self.pool.cost(&[*own])).unwrap_or(plain)
    }

    /// With the signs that some absolute values have at the values of the parameters.
    fn without_bars(&mut self, all: &[ExprId], is_free: impl Fn(&mut Self, ExprId, ExprId) -> bool) -> Vec<ExprId> {
        let mut parts = HashMap::new();
        for bars in self.pool.reachable(all) {
            if let Node::Function(Function::Abs, inner) = *self.pool.node(bars)
                && self.pool.symbols_of(&[inner]).into_iter().all(|symbol| self.checker.has_value(symbol))
                && let Some(sign) = self.sign(inner)
                && is_free(self, bars, inner)
            {
                parts.insert(bars, if sign.is_lt() { self.pool.neg(inner) } else { inner });
            }
        }
        if parts.is_empty() { all.to_vec() } else { self.pool.replaced(all, &parts) }
    }

    /// Whether an absolute value has the sign that follows from those of the parameters.
    fn follows(&mut self, inner: ExprId) -> bool {
        sign_by_parameters(self.pool, self.checker, inner).is_some()
    }

    /// Whether zeros are the same ones with the opposite of an absolute value.
    fn turns(&mut self, zeros: &[ExprId], bars: ExprId, inner: ExprId) -> bool {
        let opposite = self.pool.neg(inner);
        let both = [inner, opposite].map(|own| {
            let replaced = self.pool.replaced(zeros, &HashMap::from([(bars, own)]));
            let mut pairs: Vec<[ExprId; 2]> = replaced.chunks(2).filter_map(|own| own.try_into().ok()).collect();
            pairs.put_in_order();
            pairs
        });
        both[0] == both[1]
    }

    fn push(&mut self, (real, imaginary): Zero, multiplicity: usize, damping_ratio: Option<ExprId>) {
        self.own.add(ClosedExponent { real, imaginary, multiplicity, damping_ratio });
    }

    /// ± the root of a square whose sign is known at the values of the parameters.
    fn pair(&mut self, square: ExprId, few: bool) -> Option<[Zero; 2]> {
        // Where it is 0, what holds nearby is as good.
        let negative = self.sign(square)?.is_le();
        let size = if negative { self.pool.neg(square) } else { square };
        let size = if few { self.root(size) } else { self.pool.sqrt(size) };
        Some(self.both(size, negative))
    }

    /// ±x or ±ix, the one with the plus first.
    fn both(&mut self, x: ExprId, imaginary: bool) -> [Zero; 2] {
        let zero = self.pool.zero();
        let mut both = [x, self.pool.neg(x)];
        if self.sign(x) == Some(Ordering::Less) {
            both.reverse();
        }
        both.map(|x| if imaginary { (zero, x) } else { (x, zero) })
    }

    fn of_frequencies(&mut self, case: &Case) {
        let few = case.frequencies.len() <= MOST_ROOTS;
        self.own.complete = case.complete;
        for own in &case.frequencies {
            if own.omega_squared.is_zero() {
                self.push((own.omega_squared, own.omega_squared), 2 * own.multiplicity, None);
                continue;
            }
            let square = self.pool.neg(own.omega_squared);
            match self.pair(square, few) {
                Some(pair) => pair.into_iter().for_each(|zero| self.push(zero, own.multiplicity, None)),
                None => self.own.complete = false,
            }
        }
    }

    fn of_factors(&mut self, parts: &Factored<'_>) {
        let zero = self.pool.zero();
        if parts.zeros > 0 {
            self.push((zero, zero), parts.zeros as usize, None);
        }
        self.own.complete = true;
        for factor in &parts.factors {
            let coefficients = factor.polynomial.coefficients(EXPONENT);
            let coefficients = coefficients.iter().map(|own| parts.ring.expression(self.pool, own));
            let coefficients: Vec<ExprId> = coefficients.collect();
            let [is_even, is_positive] = [factor.is_even(), parts.leads_positively(factor)];
            let Some((zeros, ratio)) = self.zeros(&coefficients, is_even, is_positive) else {
                self.own.complete = false;
                continue;
            };
            let all: Vec<ExprId> =
                zeros.iter().flat_map(|(real, imaginary)| [*real, *imaginary]).map(|e| self.pool.polished(e)).collect();
            let all = self.without_bars(&all, |own, bars, inner| own.follows(inner) || own.turns(&all, bars, inner));
            let zeros: Vec<Zero> = all.chunks(2).map(|own| (own[0], own[1])).collect();
            let ratio = ratio.map(|ratio| {
                let polished = self.pool.polished(ratio);
                self.without_bars(&[polished], |own, _, inner| own.follows(inner))[0]
            });
            if zeros.iter().any(|zero| !self.is_zero_of(*zero, &coefficients)) {
                self.own.complete = false;
                continue;
            }
            zeros.into_iter().for_each(|zero| self.push(zero, factor.times, ratio));
        }
    }

    /// The zeros of a polynomial, with a positive highest coefficient or an unknown one, and the damping ratio of a pair.
    fn zeros(&mut self, coefficients: &[ExprId], even: bool, is_positive: bool) -> Option<(Vec<Zero>, Option<ExprId>)> {
        let zero = self.pool.zero();
        match *coefficients {
            [b, a] => Some((vec![(self.quotient(b, a, Number::MINUS_ONE), zero)], None)),
            [c, _, a] if even => {
                let square = self.quotient(c, a, Number::MINUS_ONE);
                Some((self.pair(square, true)?.to_vec(), None))
            }
            [c, b, a] => {
                let [middle, square, _] = self.middle(c, b, a);
                let zeros = self.pair(square, true)?.map(|(real, imaginary)| (self.pool.add(middle, real), imaginary));
                Some((zeros.to_vec(), self.damping_ratio([c, b, a], is_positive)))
            }
            [c, _, b, _, a] if even => Some((self.of_squares(c, b, a)?, None)),
            _ => None,
        }
    }

    /// -b/2a, its square less c/a, and c/a.
    fn middle(&mut self, c: ExprId, b: ExprId, a: ExprId) -> [ExprId; 3] {
        let middle = self.quotient(b, a, Number::half().neg());
        let product = self.quotient(c, a, Number::ONE);
        let square = self.pool.square(middle);
        [middle, self.pool.short(|pool| pool.sub(square, product)), product]
    }

    /// (b/a)/(2 sqrt(c/a)), where c/a is positive.
    fn damping_ratio(&mut self, [c, b, a]: [ExprId; 3], is_positive: bool) -> Option<ExprId> {
        let product = self.pool.mul(a, c);
        if self.sign(product)?.is_le() {
            return None;
        }
        let (above, square) =
            if is_positive { (b, product) } else { (self.pool.div(b, a), self.quotient(c, a, Number::ONE)) };
        let (size, _) = root(self.pool, square);
        let size = self.positive(size)?;
        let plain = self.quotient(above, size, Number::half());
        if self.sign(b)?.is_le() {
            return Some(plain);
        }
        let [b, product] = [b, product].map(|own| with_common_factor(self.pool, own));
        let square = self.pool.square(b);
        let square = self.quotient(square, product, Number::half().mul(&Number::half()));
        let (other, _) = root(self.pool, square);
        let other = self.positive(other)?;
        // Without the signs of a and b it would be that of no growing motion.
        let is_known = is_positive || self.checker.linearized().is_some() && self.sign(a) == Some(Ordering::Greater);
        let is_signed = is_known && !has_bars(self.pool, other);
        let shorter = is_signed && self.pool.weight(other) < self.pool.weight(plain);
        Some(if shorter { other } else { plain })
    }

    /// The zeros of a s⁴ + b s² + c: with z = p ± r the squares, both negative, and h = sqrt(c/a) they are ±i(u ± w) with
    /// u² = (h - p)/2 and w² = (-p - h)/2, where h can be drawn; where r is imaginary they are ±x ± iy with 2x² = h + p and 2y² = h - p.
    fn of_squares(&mut self, c: ExprId, b: ExprId, a: ExprId) -> Option<Vec<Zero>> {
        let cost = |own: &mut Self, zeros: &[Zero]| {
            let all: Vec<ExprId> = zeros.iter().map(|(_, imaginary)| *imaginary).collect();
            let piled_up: u64 = all.iter().map(|e| own.pool.piled_up(*e)).sum();
            own.pool.cost(&all) + A_STOREY * piled_up
        };
        let [p, square, product] = self.middle(c, b, a);
        let flutters = self.sign(square)?.is_lt();
        let (h, exact) = root(self.pool, product);
        // Either sign of h gives the same u ± w.
        let h =
            if flutters || has_bars(self.pool, p) { self.positive(h).unwrap_or(h) } else { up_to_sign(self.pool, h) };
        let half = |own: &mut Self, h_sign: i64, p_sign: i64| {
            let terms = [(h, h_sign), (p, p_sign)].map(|(e, sign)| (e, Number::from(sign).mul(&Number::half())));
            own.pool.short(|pool| pool.linear(&terms))
        };
        if flutters {
            let [x, y] = [half(self, 1, 1), half(self, 1, -1)].map(|square| self.root(square));
            let (minus_x, minus_y) = (self.pool.neg(x), self.pool.neg(y));
            return Some(vec![(x, y), (x, minus_y), (minus_x, y), (minus_x, minus_y)]);
        }
        // With both signs.
        let (r, drawn) = root(self.pool, square);
        let r = if drawn { r } else { self.root(square) };
        let r = up_to_sign(self.pool, r);
        let squares = [self.pool.add(p, r), self.pool.sub(p, r)].map(|square| self.pool.simplify(square));
        let mut zeros = [self.pair(squares[0], true)?, self.pair(squares[1], true)?].concat();
        if !drawn
            && let Some(other) = self.quotients(c, b, a)
            && cost(self, &other) < cost(self, &zeros)
        {
            zeros = other;
        }
        let both = squares.into_iter().all(|square| self.sign(square).is_some_and(Ordering::is_le));
        if both && exact {
            for (over_one_bar, is_common) in [(false, true), (true, true), (true, false)] {
                let [u, w] = [half(self, 1, -1), half(self, -1, -1)].map(|square| {
                    let size = if over_one_bar { self.root(square) } else { root(self.pool, square).0 };
                    up_to_sign(self.pool, size)
                });
                let sizes = [self.pool.sub(u, w), self.pool.add(u, w)];
                let sizes = if is_common { sizes.map(|size| with_common_bar(self.pool, size)) } else { sizes };
                let other: Vec<Zero> = sizes.into_iter().flat_map(|size| self.both(size, true)).collect();
                if cost(self, &other) < cost(self, &zeros) {
                    zeros = other;
                }
            }
        }
        Some(zeros)
    }

    /// The same from s² = (-b ± sqrt(b² - 4ac))/2a, what all terms have in common before the fraction bar.
    fn quotients(&mut self, c: ExprId, b: ExprId, a: ExprId) -> Option<Vec<Zero>> {
        let (square, product) = (self.pool.square(b), self.pool.mul(a, c));
        let discriminant = self.pool.linear(&[(square, Number::ONE), (product, Number::from(-4))]);
        let (r, _) = root(self.pool, discriminant);
        let r = up_to_sign(self.pool, r);
        let mut zeros = Vec::new();
        for sign in [Number::ONE, Number::MINUS_ONE] {
            let above = self.pool.linear(&[(b, Number::MINUS_ONE), (r, sign)]);
            let above = with_common_bar(self.pool, above);
            let negative = self.sign(above)?.is_lt() != self.sign(a)?.is_lt();
            let below = self.pool.scale(a, &Number::from(if negative { -2 } else { 2 }));
            let size = self.pool.div(above, below);
            let size = plain_root(self.pool, size);
            zeros.extend(self.both(size, negative));
        }
        Some(zeros)
    }

    /// Whether this is a zero of the polynomial at the values of the parameters, and an exponent where these are certified.
    fn is_zero_of(&mut self, (real, imaginary): Zero, coefficients: &[ExprId]) -> bool {
        let all: Vec<ExprId> = [real, imaginary].iter().chain(coefficients).copied().collect();
        // Roots that vanish are exactly 0 with the values put in first.
        self.vanish(&all) || {
            let all = self.checker.at_values(self.pool, &all);
            self.vanish(&all)
        }
    }

    /// The same of real and imaginary part and the coefficients, as they stand.
    fn vanish(&self, all: &[ExprId]) -> bool {
        let Some(values) = self.checker.evaluate(self.pool, all) else { return false };
        let [real, imaginary, coefficients @ ..] = values.as_slice() else { return false };
        let s = Complex { re: *real, im: *imaginary };
        let zero = Complex { re: Ball::ZERO, im: Ball::ZERO };
        let (mut sum, mut size) = (zero, 0.0);
        let length = real.abs_upper().hypot(imaginary.abs_upper());
        for coefficient in coefficients.iter().rev() {
            sum = sum.mul(&s).add(&Complex { re: *coefficient, im: Ball::ZERO });
            size = size * length + coefficient.abs_upper();
        }
        let vanishes = |part: &Ball| part.contains_zero() && part.radius <= WIDEST * size;
        let meets = |a: &Ball, b: &Ball| a.sub(b).contains_zero();
        let certified = self.checker.exponents().is_none_or(|modes| {
            // One of a pair ±s stands for both.
            let pairs =
                |mode: &NormalMode| meets(&real.abs(), &mode.growth.abs()) && meets(&imaginary.abs(), &mode.omega);
            modes.iter().any(pairs)
        });
        vanishes(&sum.re) && vanishes(&sum.im) && certified
    }
}
