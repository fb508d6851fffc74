//! The exponents of M q'' + (G + C) q' + (K + N) q = 0 in symbols: the characteristic polynomial, its zeros where they can be
//! written down, and what stability needs.
//!
//! The polynomial det(s²M + s(G + C) + K + N) is that of each part which hangs together, without what its coefficients have in
//! common; factors in which no zero is repeated are solved one by one: linear and quadratic ones, and even ones up to s⁴. Zeros and
//! conditions are compared with certified exponents before they are given out. Of conservative models the closed forms of the
//! frequencies are taken.

use std::cmp::Ordering;

use super::Linear;
use super::blocks::{adapted, commuting_mirrors};
use super::check::{Checker, WIDEST};
use super::frequencies::{Approximation, Case};
use super::pair::Pair;
use super::polynomial::{Polynomial, determinant};
use super::ring::{EXPONENT, Expanded, Ring};
use super::roots::{MOST_COORDINATES, determinant_of_polynomials, plain_root, root, with_common_bar};
use super::shapes::on_one_bar;
use super::simplify::{Algebra, Opening, expand, split, written};
use super::stability::{Sign, Signs, conditions, conditions_in_coefficients, essential};
use crate::expr::{ExprId, Pool, nullspace_mod};
use crate::groups::connected;
use crate::number::Number;
use crate::oscillation::NormalMode;
use crate::precision::{Ball, Complex, Scalar};
use crate::symmetry::Symmetry;
use crate::syntax::Comparison;

/// Of models with more coordinates only frequencies are looked at.
const MOST_IN_ALL: usize = 40;
/// Determinants of more coordinates are not written out, those beyond the limit of closed forms as polynomials.
const MOST_COORDINATES_OF_POLYNOMIALS: usize = 24;
/// Nor are those of more symbols in all entries.
const MOST_SYMBOLS_OF_POLYNOMIALS: u64 = 3000;
/// Determinants of more symbols in all entries are not multiplied out.
const MOST_SYMBOLS: u64 = 500;
/// Characteristic polynomials of more terms are left out.
const MOST_TERMS: usize = 1000;
/// Conditions of more symbols are left out.
const MOST_IN_CONDITION: u64 = 5000;
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
    /// What has been done to the exponents since.
    pub approximations: Vec<Approximation>,
}

impl Exponents {
    /// -s² of the exponents that are real or imaginary, each pair once, as text with its multiplicity: what squares of frequencies are
    /// where nothing is damped.
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
                (false, false) => continue,
            };
            let square = pool.simplify(square);
            match all.iter_mut().find(|(other, _)| *other == square) {
                Some((_, times)) => *times += own.multiplicity,
                None => all.push((square, own.multiplicity)),
            }
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
}

/// A factor of the characteristic polynomial in which no zero is repeated.
pub(super) struct Factor {
    pub(super) polynomial: Polynomial,
    pub(super) times: usize,
    /// How often it is one of a single part, or class of symmetry.
    pub(super) repeated: usize,
    /// A bit for each of the parts, or classes, that have it.
    parts: u64,
}

impl Factor {
    /// Whether it has even powers of s alone.
    pub(super) fn is_even(&self) -> bool {
        self.polynomial.terms().all(|(powers, _)| powers[EXPONENT] % 2 == 0)
    }
}

/// The characteristic polynomial of all parts.
struct Factored {
    ring: Ring,
    factors: Vec<Factor>,
    /// How often s is a factor.
    zeros: u32,
    signs: Signs,
}

/// The exponents, of conservative models from their frequencies.
pub(super) fn exponents(checker: &Checker<'_>, pool: &mut Algebra<'_>, linear: &Linear) -> Exponents {
    pool.budget().at("the exponents in symbols", None);
    let mut own = Exponents::default();
    let case = linear.frequencies.as_ref().map(|own| own.best()).filter(|case| case.complete);
    let parts = Factored::new(checker, pool, linear);
    let is_general = parts.is_some() || case.is_some_and(|case| case.ties.is_empty());
    let parts = parts.or_else(|| Factored::of_squares(checker, pool, linear, case?));
    if let Some(parts) = parts.as_ref().filter(|_| is_general) {
        own.characteristic = parts.characteristic(checker, pool);
    }
    let mut found = Found { checker, pool, own: &mut own };
    // None are found where a combination of coordinates has no inertia, though the polynomial may have few zeros then.
    match (&linear.frequencies, &parts) {
        (Some(all), Some(parts)) if all.best().frequencies.is_empty() => found.of_factors(parts),
        (Some(all), _) => found.of_frequencies(all.best()),
        (None, Some(parts)) => found.of_factors(parts),
        (None, None) => {}
    }
    if let Some(parts) = &parts {
        let all = parts.factors.iter();
        let conservative = linear.is_conservative();
        let all =
            all.map(|factor| conditions(factor, &parts.ring, &parts.signs, conservative)).collect::<Option<Vec<_>>>();
        let kept = all.map(|all| essential(&all.concat(), &parts.signs));
        own.stability = kept.and_then(|kept| parts.conditions(checker, pool, &kept));
        own.stability = own.stability.or_else(|| parts.in_coefficients(checker, pool, conservative));
        // Without circulatory forces equal exponents have vectors enough, as far as energies keep motions in bounds.
        own.stability = own.stability.and_then(|mut all| {
            if linear.circulatory.is_some() {
                all.extend(parts.distinct(pool)?);
            }
            (conservative || !drifts(pool, linear)).then_some(all)
        });
    }
    own
}

/// Whether motions grow as t² or faster at the exponent 0, for most values of the parameters: a Jordan block over 2, as the kernels of
/// (K), (K, D; K), (K, D, M; K, D; K) tell, D = G + C, whose dimensions count blocks of size 1, 2 and 3 at least. Modulo a prime.
fn drifts(pool: &mut Pool, linear: &Linear) -> bool {
    let n = linear.mass.len();
    let places = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let entries: Vec<ExprId> = places.flat_map(|(i, j)| linear.entry(pool, i, j)).collect();
    let Some(values) = pool.evaluate_at_random(&entries, 1) else { return false };
    let degrees = values.len() / (n * n).max(1);
    let blocks = |size: usize| {
        let entry = |row: usize, column: usize| match (row / n).checked_sub(column / n) {
            Some(power) if power < degrees => values[(row % n * n + column % n) * degrees + power],
            Some(_) | None => 0,
        };
        let mut rows = (0..size * n).map(|row| (0..size * n).map(|column| entry(row, column)).collect()).collect();
        nullspace_mod(&mut rows, size * n).len()
    };
    blocks(3) > blocks(2)
}

/// What is positive: the diagonal of M, and what the model assumes.
fn known(checker: &Checker<'_>, pool: &mut Pool, linear: &Linear) -> Vec<Expanded> {
    let mut all: Vec<ExprId> = linear.mass.iter().enumerate().map(|(i, row)| row[i]).collect();
    for own in &checker.model.assumptions {
        match own.relation {
            Comparison::Greater => all.push(pool.sub(own.left, own.right)),
            Comparison::Less => all.push(pool.sub(own.right, own.left)),
            Comparison::GreaterEqual | Comparison::LessEqual | Comparison::Equal | Comparison::NotEqual => {}
        }
    }
    all.retain(|own| !own.is_zero());
    all.into_iter().filter_map(|own| Expanded::new(pool, &[own])).collect()
}

impl Factored {
    fn new(checker: &Checker<'_>, pool: &mut Algebra<'_>, linear: &Linear) -> Option<Self> {
        if linear.mass.len() > MOST_IN_ALL {
            return None;
        }
        let rows = (0..linear.mass.len()).map(|i| (0..linear.mass.len()).map(|j| linear.entry(pool, i, j)).collect());
        let rows: Matrix = rows.collect();
        // Of conservative models it is known whether there is a symmetry, and few coordinates need none.
        let symmetric = linear.frequencies.as_ref().is_none_or(|own| own.best().symmetry.is_some());
        let few = linear.is_conservative() && (rows.len() <= MOST_COORDINATES || !symmetric);
        let blocks = if few { None } else { by_symmetry(pool, linear, &rows) };
        let (mut expanded, mut symbols) = (Vec::new(), 0);
        let mut known = known(checker, pool, linear);
        for rows in blocks.unwrap_or_else(|| vec![rows]) {
            let couples = |i: usize, j: usize| rows[i][j].iter().any(|own| !own.is_zero());
            for part in connected(rows.len(), |i, j| couples(i, j) || couples(j, i)) {
                let entries = part.iter().map(|i| part.iter().map(|j| rows[*i][*j].clone()).collect());
                let entries: Matrix = entries.collect();
                let all = entries.concat().concat();
                let weight = pool.weight_of(&all);
                if part.len() > MOST_COORDINATES {
                    if weight > MOST_SYMBOLS_OF_POLYNOMIALS || part.len() > MOST_COORDINATES_OF_POLYNOMIALS {
                        return None;
                    }
                    expanded.push((part.len(), Expanded::new(pool, &all)?));
                    continue;
                }
                let is_short = weight <= MOST_SYMBOLS;
                symbols += weight;
                // Frequencies say what conditions say, elsewhere.
                if linear.is_conservative() && linear.mass.len() > MOST_COORDINATES && symbols > 2 * MOST_SYMBOLS {
                    return None;
                }
                let coefficients = determinant_of_polynomials(pool, &entries)?;
                let open = if is_short { Expanded::new(pool, &coefficients) } else { None };
                let is_open = open.is_some();
                expanded.push((1, open.unwrap_or_else(|| Expanded::as_they_stand(pool, &coefficients))));
                // det M is positive, unless it is 0.
                if coefficients.len() == 2 * part.len() + 1
                    && let Some(last) = coefficients.last()
                {
                    known.extend(match is_open {
                        true => Expanded::new(pool, &[*last]),
                        false => Some(Expanded::as_they_stand(pool, &[*last])),
                    });
                }
            }
        }
        let ring = Ring::new(pool, expanded.iter().map(|(_, own)| own).chain(&known));
        let mut factors = Vec::new();
        let mut zeros = 0;
        for (part, (n, own)) in expanded.iter().enumerate() {
            let coefficients = ring.polynomials(own)?;
            // Nothing is left of entries that are all 0: the determinant is, whatever the exponent.
            let degrees = coefficients.len().checked_div(n * n).filter(|own| *own > 0)?;
            let entries = coefficients.chunks(degrees);
            let entries: Vec<_> = entries.map(|own| Polynomial::from_coefficients(EXPONENT, own)).collect();
            let polynomial = ring.reduced(determinant(entries.chunks(*n).map(<[_]>::to_vec).collect())?);
            let common = polynomial.common_powers();
            zeros += common[EXPONENT];
            let polynomial = polynomial.without(&common);
            let polynomial = polynomial.over(&polynomial.content(EXPONENT))?;
            for (polynomial, times) in polynomial.factors(EXPONENT) {
                for polynomial in polynomial.split() {
                    join(&mut factors, Factor { polynomial, times, repeated: times, parts: 1 << part });
                }
            }
        }
        let signs = Signs::new(pool, &ring, &known);
        Some(Self { ring, factors, zeros, signs })
    }

    /// From squares of all frequencies; of two that a root tells apart from their sum and product.
    fn of_squares(checker: &Checker<'_>, pool: &mut Algebra<'_>, linear: &Linear, case: &Case) -> Option<Self> {
        let mut open: Vec<(ExprId, usize)> =
            case.frequencies.iter().map(|own| (own.omega_squared, own.multiplicity)).collect();
        let (one, mut zeros, mut expanded) = (pool.one(), 0, Vec::new());
        while let Some((own, times)) = open.pop() {
            if own.is_zero() {
                zeros += 2 * u32::try_from(times).ok()?;
                continue;
            }
            let alone = Expanded::new(pool, &[own, one])?;
            let mut with_other = |(at, (other, others)): (usize, &(ExprId, usize))| {
                let sums = [pool.short(|pool| pool.mul(own, *other)), pool.short(|pool| pool.add(own, *other)), one];
                let quadratic = Expanded::new(pool, &sums).filter(|own| *others == times && !own.has_roots());
                Some((at, quadratic?))
            };
            let pair = alone.has_roots().then(|| open.iter().enumerate().find_map(&mut with_other)).flatten();
            if let Some((at, _)) = &pair {
                open.remove(*at);
            }
            expanded.push((times, pair.map_or(alone, |(_, quadratic)| quadratic)));
        }
        let known = known(checker, pool, linear);
        let ring = Ring::new(pool, expanded.iter().map(|(_, own)| own).chain(&known));
        let signs = Signs::new(pool, &ring, &known);
        let factor = |(times, own): &(usize, Expanded)| {
            let polynomial = Polynomial::from_coefficients(EXPONENT, &ring.polynomials(own)?);
            let polynomial = polynomial.with_powers(EXPONENT, |power| Some(2 * power))?;
            Some(Factor { polynomial, times: *times, repeated: *times, parts: 0 })
        };
        let factors = expanded.iter().map(factor).collect::<Option<_>>()?;
        Some(Self { ring, factors, zeros, signs })
    }

    /// The product of all factors; `None` where it would be too long.
    fn characteristic(&self, checker: &Checker<'_>, pool: &mut Algebra<'_>) -> Option<Vec<ExprId>> {
        let mut whole = Polynomial::constant(self.ring.variables(), Number::ONE);
        for factor in &self.factors {
            for _ in 0..factor.times {
                whole = whole.times(&factor.polynomial);
                if whole.terms().count() > MOST_TERMS {
                    return None;
                }
            }
        }
        let whole = whole.primitive().coefficients(EXPONENT);
        let zeros = (0..self.zeros).map(|_| pool.zero());
        let mut all: Vec<ExprId> = zeros.collect();
        all.extend(whole.iter().map(|own| self.ring.expression(pool, own)));
        if let Some(last) = all.last()
            && checker.is_negative(pool, *last) == Some(true)
        {
            for own in &mut all {
                *own = pool.short(|pool| pool.neg(*own));
            }
        }
        Some(all)
    }

    /// What has to be positive, as a product.
    fn product(&self, pool: &mut Algebra<'_>, own: &Sign) -> ExprId {
        let factors = own.factors.iter().map(|factor| self.ring.expression(pool, factor));
        let mut factors: Vec<ExprId> = factors.collect();
        if own.negative {
            // The sign goes into a sum.
            let place = factors.iter().position(|factor| pool.is_sum(*factor)).unwrap_or(0);
            match factors.get_mut(place) {
                Some(factor) => *factor = pool.neg(*factor),
                None => factors.push(pool.integer(-1)),
            }
        }
        pool.product(&factors)
    }

    /// Conditions as expressions, where they agree with the modes at the values of the parameters.
    fn conditions(
        &self,
        checker: &Checker<'_>,
        pool: &mut Algebra<'_>,
        all: &[Sign],
    ) -> Option<Vec<StabilityCondition>> {
        let mut by_signs = self.signs.clone();
        for at in 0..self.ring.variables() {
            let symbol = self.ring.base(at).and_then(|(base, _)| pool.as_symbol(base));
            if symbol.and_then(|symbol| checker.sign(symbol)) == Some(false) {
                by_signs.variables[at] = true;
            }
        }
        let mut found = Vec::new();
        for own in all {
            let positive = self.product(pool, own);
            if pool.weight_of(&[positive]) > MOST_IN_CONDITION {
                return None;
            }
            // A relation of numbers.
            if pool.is_constant(positive) && checker.is_negative(pool, positive) == Some(false) {
                continue;
            }
            let left = by_signs.sign(&own.product(self.ring.variables()));
            let open = (!left.holds_always()).then(|| self.product(pool, &left));
            found.push(StabilityCondition { positive, open });
        }
        agreeing(checker, pool, found)
    }

    /// That factors without odd powers have no zeros in common, where they are of one part: else motions grow as powers of t. Squares, as
    /// conditions are what is positive; `None` where they have some whatever the parameters are, or it is too long.
    fn distinct(&self, pool: &mut Algebra<'_>) -> Option<Vec<StabilityCondition>> {
        let even: Vec<&Factor> = self.factors.iter().filter(|own| own.is_even()).collect();
        let mut found = Vec::new();
        for (at, one) in even.iter().enumerate() {
            for other in even[at + 1..].iter().filter(|own| own.parts & one.parts != 0) {
                let resultant = self.ring.reduced(one.polynomial.resultant_of_even(&other.polynomial, EXPONENT)?);
                if resultant.is_zero() {
                    return None;
                }
                let common = resultant.common_powers();
                let rest = resultant.without(&common);
                let open = |(at, power): (usize, &u32)| u32::from(*power > 0 && !self.signs.variables[at]);
                let mut base = Polynomial::monomial(common.iter().enumerate().map(open).collect());
                if self.signs.of_terms(&rest).is_none() {
                    base = base.times(&rest);
                }
                if base.is_constant() {
                    continue;
                }
                let base = self.ring.expression(pool, &base);
                let positive = pool.square(base);
                if pool.weight_of(&[positive]) > MOST_IN_CONDITION {
                    return None;
                }
                found.push(StabilityCondition { positive, open: Some(positive) });
            }
        }
        Some(found)
    }

    /// Conditions in the coefficients of the factors, which are not multiplied out, where they agree with the modes.
    fn in_coefficients(
        &self,
        checker: &Checker<'_>,
        pool: &mut Algebra<'_>,
        conservative: bool,
    ) -> Option<Vec<StabilityCondition>> {
        let mut found = Vec::new();
        for factor in &self.factors {
            let (coefficients, conditions) = conditions_in_coefficients(factor, &self.signs, conservative)?;
            let coefficients: Vec<ExprId> = coefficients.iter().map(|own| self.ring.expression(pool, own)).collect();
            for condition in conditions {
                let terms = condition.terms().map(|(powers, number)| {
                    let powers = coefficients.iter().zip(powers).map(|(own, power)| pool.powi(*own, i64::from(*power)));
                    let powers: Vec<ExprId> = powers.collect();
                    (pool.product(&powers), number.clone())
                });
                let terms: Vec<(ExprId, Number)> = terms.collect();
                let positive = pool.linear(&terms);
                if pool.weight_of(&[positive]) > MOST_IN_CONDITION {
                    return None;
                }
                if !pool.is_constant(positive) || checker.is_negative(pool, positive) != Some(false) {
                    found.push(StabilityCondition { positive, open: Some(positive) });
                }
            }
        }
        agreeing(checker, pool, found)
    }
}

/// Takes another factor in, without what it has in common with one that is there: parts and classes of symmetry may share exponents.
fn join(factors: &mut Vec<Factor>, new: Factor) {
    let mut open = vec![new];
    while let Some(mut own) = open.pop() {
        for other in factors.iter_mut() {
            if other.polynomial.is_prime_to(&own.polynomial, EXPONENT) {
                continue;
            }
            let common = other.polynomial.common_divisor(&own.polynomial);
            let rests = [&other.polynomial, &own.polynomial].map(|of| of.over(&common));
            if common.degree(EXPONENT) > 0
                && let [Some(of_other), Some(of_own)] = rests
            {
                open.push(Factor { polynomial: of_other, ..*other });
                own.polynomial = of_own;
                let (times, repeated) = (other.times + own.times, other.repeated.max(own.repeated));
                *other = Factor { polynomial: common, times, repeated, parts: other.parts | own.parts };
            }
        }
        if own.polynomial.degree(EXPONENT) > 0 {
            factors.push(own);
        }
    }
}

/// Conditions where they agree with the modes at the values of the parameters.
fn agreeing(
    checker: &Checker<'_>,
    pool: &mut Algebra<'_>,
    found: Vec<StabilityCondition>,
) -> Option<Vec<StabilityCondition>> {
    let signs: Vec<Option<bool>> = found.iter().map(|own| checker.is_negative(pool, own.positive)).collect();
    // -1 stands for what is negative but for special values, which those of the model may be.
    let is_general = found.iter().any(|own| pool.as_number(own.positive).is_some());
    let Some(modes) = checker.exponents().filter(|_| !is_general) else { return Some(found) };
    let unstable = modes.iter().any(|mode| mode.growth.is_positive());
    // What is 0 at the values leaves it open, but not beside what is negative.
    let agrees = if signs.contains(&Some(true)) { unstable } else { !unstable || signs.contains(&None) };
    agrees.then_some(found)
}

impl Linear {
    /// s²M + s(G + C) + K + N, the constant first.
    pub(super) fn entry(&self, pool: &mut Pool, i: usize, j: usize) -> Vec<ExprId> {
        let of = |rows: &Option<Vec<Vec<ExprId>>>| rows.as_ref().map(|rows| rows[i][j]);
        let sum = |pool: &mut Pool, parts: [Option<ExprId>; 2]| {
            let parts: Vec<ExprId> = parts.into_iter().flatten().collect();
            pool.sum(&parts)
        };
        let constant = sum(pool, [Some(self.stiffness[i][j]), of(&self.circulatory)]);
        let velocity = sum(pool, [of(&self.gyroscopic), of(&self.damping)]);
        vec![constant, velocity, self.mass[i][j]]
    }
}

/// Closed forms on their way.
struct Found<'a, 'p> {
    checker: &'a Checker<'a>,
    pool: &'a mut Algebra<'p>,
    own: &'a mut Exponents,
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

    /// An expression or its opposite, whichever is not negative.
    fn positive(&mut self, e: ExprId) -> Option<ExprId> {
        Some(if self.sign(e)?.is_lt() { self.pool.neg(e) } else { e })
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

    fn push(&mut self, (real, imaginary): Zero, multiplicity: usize, damping_ratio: Option<ExprId>) {
        let mut all = self.own.exponents.iter_mut();
        match all.find(|own| own.real == real && own.imaginary == imaginary) {
            Some(same) => same.multiplicity += multiplicity,
            None => self.own.exponents.push(ClosedExponent { real, imaginary, multiplicity, damping_ratio }),
        }
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

    fn of_factors(&mut self, parts: &Factored) {
        let zero = self.pool.zero();
        if parts.zeros > 0 {
            self.push((zero, zero), parts.zeros as usize, None);
        }
        self.own.complete = true;
        for factor in &parts.factors {
            let coefficients = factor.polynomial.coefficients(EXPONENT);
            let coefficients = coefficients.iter().map(|own| parts.ring.expression(self.pool, own));
            let coefficients: Vec<ExprId> = coefficients.collect();
            let Some((zeros, ratio)) = self.zeros(&coefficients, factor.is_even()) else {
                self.own.complete = false;
                continue;
            };
            if zeros.iter().any(|zero| !self.is_zero_of(*zero, &coefficients)) {
                self.own.complete = false;
                continue;
            }
            zeros.into_iter().for_each(|zero| self.push(zero, factor.times, ratio));
        }
    }

    /// The zeros of a polynomial, and the damping ratio of a pair.
    fn zeros(&mut self, coefficients: &[ExprId], even: bool) -> Option<(Vec<Zero>, Option<ExprId>)> {
        let zero = self.pool.zero();
        match *coefficients {
            [b, a] => Some((vec![(self.quotient(b, a, Number::MINUS_ONE), zero)], None)),
            [c, _, a] if even => {
                let square = self.quotient(c, a, Number::MINUS_ONE);
                Some((self.pair(square, true)?.to_vec(), None))
            }
            [c, b, a] => {
                let [middle, square, _] = self.middle(c, b, a);
                let zeros = self.pair(square, true)?.map(|(real, imaginary)| {
                    let real = self.pool.add(middle, real);
                    (real, imaginary)
                });
                Some((zeros.to_vec(), self.damping_ratio(c, b, a)))
            }
            [c, _, b, _, a] if even => Some((self.of_squares(c, b, a)?, None)),
            [e, d, c, b, a] => self.about_middle([e, d, c, b, a]),
            _ => None,
        }
    }

    /// The zeros of a polynomial that is even about the middle of its zeros, as friction in proportion to M makes it.
    fn about_middle(&mut self, [e, d, c, b, a]: [ExprId; 5]) -> Option<(Vec<Zero>, Option<ExprId>)> {
        let [bbb, abc, aad] = [[b, b, b], [a, b, c], [a, a, d]].map(|own| self.pool.product(&own));
        let odd = self.pool.linear(&[(bbb, Number::ONE), (abc, Number::from(-4)), (aad, Number::from(8))]);
        if !self.pool.vanishes(odd) {
            return None;
        }
        let middle = self.quotient(b, a, Number::half().mul(&Number::half()).neg());
        let square = self.pool.square(middle);
        let [aq, cq, dm] = [[a, square], [c, square], [d, middle]].map(|own| self.pool.product(&own));
        let aqq = self.pool.mul(aq, square);
        let second = self.pool.short(|pool| pool.linear(&[(c, Number::ONE), (aq, Number::from(-6))]));
        let last = [(e, 1), (dm, 1), (cq, 1), (aqq, -3)].map(|(own, factor)| (own, Number::from(factor)));
        let last = self.pool.short(|pool| pool.linear(&last));
        // Roots within roots help nobody.
        let [_, square, _] = self.middle(last, second, a);
        if !root(self.pool, square).1 {
            return None;
        }
        let zeros = self.of_squares(last, second, a)?.into_iter();
        Some((zeros.map(|(real, imaginary)| (self.pool.add(middle, real), imaginary)).collect(), None))
    }

    /// -b/2a, its square less c/a, and c/a.
    fn middle(&mut self, c: ExprId, b: ExprId, a: ExprId) -> [ExprId; 3] {
        let middle = self.quotient(b, a, Number::half().neg());
        let product = self.quotient(c, a, Number::ONE);
        let square = self.pool.square(middle);
        [middle, self.pool.short(|pool| pool.sub(square, product)), product]
    }

    /// b/(2 sqrt(a c)), where c/a is positive.
    fn damping_ratio(&mut self, c: ExprId, b: ExprId, a: ExprId) -> Option<ExprId> {
        let product = self.pool.mul(a, c);
        if self.sign(product)?.is_le() {
            return None;
        }
        let (size, _) = root(self.pool, product);
        let size = self.positive(size)?;
        let plain = self.quotient(b, size, Number::half());
        if self.sign(b)?.is_le() {
            return Some(plain);
        }
        let square = self.pool.square(b);
        let square = self.quotient(square, product, Number::half().mul(&Number::half()));
        let (other, _) = root(self.pool, square);
        let other = self.positive(other)?;
        let shorter = self.pool.weight(other) < self.pool.weight(plain);
        Some(if shorter { other } else { plain })
    }

    /// The zeros of a s⁴ + b s² + c: with z = p ± r the squares, both negative, and h = sqrt(c/a) they are ±i(u ± w) with
    /// u² = (h - p)/2 and w² = (-p - h)/2, where h can be drawn; where r is imaginary they are ±x ± iy with 2x² = h + p and 2y² = h - p.
    fn of_squares(&mut self, c: ExprId, b: ExprId, a: ExprId) -> Option<Vec<Zero>> {
        let cost = |own: &mut Self, zeros: &[Zero]| {
            let all: Vec<ExprId> = zeros.iter().map(|(_, imaginary)| *imaginary).collect();
            own.pool.cost(&all)
        };
        let [p, square, product] = self.middle(c, b, a);
        let flutters = self.sign(square)?.is_lt();
        let (h, exact) = root(self.pool, product);
        let h = self.positive(h).unwrap_or(h);
        let half = |own: &mut Self, h_sign: i64, p_sign: i64| {
            let terms = [(h, h_sign), (p, p_sign)].map(|(e, sign)| (e, Number::from(sign).mul(&Number::half())));
            own.pool.short(|pool| pool.linear(&terms))
        };
        if flutters {
            let [x, y] = [half(self, 1, 1), half(self, 1, -1)].map(|square| self.root(square));
            let (minus_x, minus_y) = (self.pool.neg(x), self.pool.neg(y));
            return Some(vec![(x, y), (x, minus_y), (minus_x, y), (minus_x, minus_y)]);
        }
        let (r, drawn) = root(self.pool, square);
        let r = self.positive(r)?;
        let squares = [self.pool.add(p, r), self.pool.sub(p, r)];
        let squares = squares.map(|square| self.pool.simplify(square));
        let mut zeros = Vec::new();
        for square in squares {
            zeros.extend(self.pair(square, true)?);
        }
        if !drawn
            && let Some(other) = self.quotients(c, b, a)
            && cost(self, &other) < cost(self, &zeros)
        {
            zeros = other;
        }
        let both = squares.into_iter().all(|square| self.sign(square).is_some_and(Ordering::is_le));
        if both && exact {
            let [u, w] = [half(self, 1, -1), half(self, -1, -1)].map(|square| root(self.pool, square).0);
            let sizes = [self.pool.sub(u, w), self.pool.add(u, w)];
            let sizes = sizes.map(|size| with_common_bar(self.pool, size));
            let other: Vec<Zero> = sizes.into_iter().flat_map(|size| self.both(size, true)).collect();
            if cost(self, &other) < cost(self, &zeros) {
                return Some(other);
            }
        }
        Some(zeros)
    }

    /// The same from s² = (-b ± sqrt(b² - 4ac))/2a, what all terms have in common before the fraction bar.
    fn quotients(&mut self, c: ExprId, b: ExprId, a: ExprId) -> Option<Vec<Zero>> {
        let (square, product) = (self.pool.square(b), self.pool.mul(a, c));
        let discriminant = self.pool.linear(&[(square, Number::ONE), (product, Number::from(-4))]);
        let (r, _) = root(self.pool, discriminant);
        let r = self.positive(r)?;
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
        let Some(values) = self.checker.evaluate(self.pool, all) else {
            return false;
        };
        let [real, imaginary, coefficients @ ..] = values.as_slice() else {
            return false;
        };
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

/// Polynomials in s, the constant first, row by row.
type Matrix = Vec<Vec<Vec<ExprId>>>;

/// One block for each class of the mirrors that leave all matrices unchanged; `None` without such mirrors.
fn by_symmetry(pool: &mut Algebra<'_>, linear: &Linear, rows: &Matrix) -> Option<Vec<Matrix>> {
    let pair = Pair::new(&linear.mass, &linear.stiffness);
    let pair = pair.canonical(pool);
    let symmetry = Symmetry::find(&pair.pattern(pool))?;
    let n = rows.len();
    let mut mirrors = commuting_mirrors(&symmetry);
    mirrors.retain(|mirror| {
        (0..n).all(|i| {
            (0..n).all(|j| {
                let ((to, turned), (other, also)) = (mirror.of(i), mirror.of(j));
                rows[i][j].iter().zip(&rows[to][other]).all(|(own, image)| {
                    let image = if turned == also { *image } else { pool.neg(*image) };
                    pool.agree(*own, image)
                })
            })
        })
    });
    if mirrors.is_empty() {
        return None;
    }
    let all: Vec<usize> = (0..n).collect();
    let classes = adapted(&mirrors, &all);
    let mut blocks = Vec::new();
    for class in classes {
        let mut block = vec![vec![Vec::new(); class.basis.len()]; class.basis.len()];
        for (entries, left) in block.iter_mut().zip(&class.basis) {
            for (entry, right) in entries.iter_mut().zip(&class.basis) {
                let mut sum_of = |power: usize| {
                    let products = left.iter().flat_map(|(i, x)| {
                        let own = right.iter().map(move |(j, y)| (rows[*i][*j][power], Number::from(x * y)));
                        own.collect::<Vec<_>>()
                    });
                    let products: Vec<(ExprId, Number)> = products.collect();
                    pool.short(|pool| pool.linear(&products))
                };
                *entry = (0..3).map(&mut sum_of).collect();
            }
        }
        blocks.push(block);
    }
    Some(blocks)
}
