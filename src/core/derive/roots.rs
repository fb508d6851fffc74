//! The zeros of det(K - z M) of a small block, where they can be written down.
//!
//! Factors z are taken out first, where the last coefficients vanish identically, then others over the parameters (`factors`);
//! what is left is solved up to the second degree, and on request up to the fourth (`cubic`).

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use super::cubic::{MOST_ON_PAGE, Solved, solve};
use super::pair::Pair;
use super::ring::{EXPONENT, Expanded, Ring};
use super::shapes::{below_bars, on_one_bar, one_fraction};
use super::simplify::{
    Algebra, Monomial, Monomials, Opening, collapsed, expand, power_of, split, times, with_common_factor, written,
};
use crate::expr::{ExprId, Node, Pool};
use crate::model::Model;
use crate::number::Number;
use crate::order::{Gather, Order};
use crate::polynomial::{Polynomial as Ratio, add_to};
use crate::precision::Function;

/// Determinants of larger blocks are not written out.
pub(super) const MOST_COORDINATES: usize = 5;
/// Nor those of more symbols in all entries: no model has any of more than 400 that fits on a page.
const MOST_IN_ENTRIES: u64 = 1000;
/// Two zeros of more symbols together may get names.
const MOST_FOR_TWO: u64 = 140;
/// Square roots of polynomials with more terms are not searched for.
const MOST_TERMS: usize = 200;

/// A polynomial in z, the constant first.
type Polynomial = Vec<ExprId>;

/// What is solved.
#[derive(Clone, Copy)]
pub(super) struct Request<'a> {
    /// Polynomials of at most this degree.
    pub(super) most: usize,
    /// Names on the page are none of this.
    pub(super) model: &'a Model,
    /// So many cubics and quartics are on it already.
    pub(super) before: usize,
}

/// The zeros of a polynomial.
#[derive(Default)]
pub(super) struct Roots {
    /// Repeated ones as often as they are; none where there is no closed form.
    pub(super) zeros: Vec<ExprId>,
    /// What of them comes from cubics and quartics, for the page.
    pub(super) solved: Vec<Solved>,
    /// The degree, where only a request for a higher one keeps them from being found.
    pub(super) unsolved: Option<usize>,
}

impl Roots {
    pub(super) fn of(zeros: Vec<ExprId>) -> Self {
        Self { zeros, ..Self::default() }
    }
}

/// All zeros of det(K - z M).
pub(super) fn roots(pool: &mut Algebra<'_>, block: &Pair, request: Request<'_>) -> Roots {
    if block.len() == 1 {
        let (mass, stiffness) = block.at(pool, 0, 0);
        let quotient = pool.short(|pool| pool.div(stiffness, mass));
        let quotient = pool.polished(quotient);
        return Roots::of(vec![best_to_read(pool, quotient)]);
    }
    if block.len() > MOST_COORDINATES || pool.weight_of(&block.values()) > MOST_IN_ENTRIES {
        return Roots::default();
    }
    let (coupling, _) = block.at(pool, 0, 1);
    if block.len() == 2 && coupling.is_zero() {
        let zeros = pair_of_roots(pool, block);
        if pool.weight_of(&zeros) <= MOST_FOR_TWO {
            return Roots::of(zeros);
        }
        let coefficients = characteristic(pool, block).unwrap_or_default();
        return named(pool, request, &coefficients, zeros);
    }
    let Some(coefficients) = characteristic(pool, block) else { return Roots::default() };
    let (zeros, rest) = without_zeros(pool, &coefficients);
    if rest.len() <= 3 {
        let zeros = of_polynomial(pool, &coefficients).unwrap_or_default();
        return named(pool, request, &coefficients, zeros);
    }
    let mut all = Roots::of(vec![pool.zero(); zeros.len()]);
    for (factor, times) in factors(pool, rest) {
        let own = of_factor(pool, Request { before: request.before + all.solved.len(), ..request }, &factor);
        (0..times).for_each(|_| all.zeros.extend(&own.zeros));
        all.solved.extend(own.solved);
        all.unsolved = all.unsolved.max(own.unsolved);
    }
    all
}

/// The zeros of a polynomial without factors.
pub(super) fn of_factor(pool: &mut Algebra<'_>, request: Request<'_>, coefficients: &[ExprId]) -> Roots {
    let degree = coefficients.len() - 1;
    if degree <= 2 {
        let zeros = of_polynomial(pool, coefficients).unwrap_or_default();
        return named(pool, request, coefficients, zeros);
    }
    if degree > request.most {
        // Formulas are longer than what they are made from.
        let is_short = degree <= 4 && pool.weight_of(coefficients) <= MOST_ON_PAGE;
        return Roots { unsolved: is_short.then_some(degree), ..Roots::default() };
    }
    let sums = sums_of_products(pool, coefficients).into_iter().map(|own| pool.polished(own)).collect::<Vec<_>>();
    let solved = solve(pool, request, &sums);
    solved.map_or_else(Roots::default, |(_, solved)| Roots {
        zeros: solved.frequencies.clone(),
        solved: vec![solved],
        unsolved: None,
    })
}

/// The factors of a polynomial over the numbers and the parameters, and how often each occurs; the whole where there are none.
pub(super) fn factors(pool: &mut Algebra<'_>, coefficients: &[ExprId]) -> Vec<(Polynomial, usize)> {
    let found = Expanded::new(pool, coefficients).and_then(|expanded| {
        let ring = Ring::new(pool, std::iter::once(&expanded));
        let all = ring.polynomials(&expanded)?.into_iter().map(|own| ring.reduced(own));
        let whole = Ratio::from_coefficients(EXPONENT, &all.collect::<Vec<_>>());
        let all: Vec<(Ratio, usize)> = whole.over(&whole.content(EXPONENT))?.split_factors(EXPONENT).collect();
        let written = |(own, times): (Ratio, usize)| {
            let own = own.coefficients(EXPONENT);
            (own.iter().map(|own| ring.expression(pool, own)).collect(), times)
        };
        (all.len() > 1 || all.iter().any(|(_, times)| *times > 1)).then(|| all.into_iter().map(written).collect())
    });
    found.unwrap_or_else(|| vec![(coefficients.to_vec(), 1)])
}

/// Sums of products of 1, 2, … zeros: the coefficients with signs in turn.
fn sums_of_products(pool: &mut Algebra<'_>, coefficients: &[ExprId]) -> Vec<ExprId> {
    let mut sums = Vec::new();
    for (at, coefficient) in coefficients.iter().rev().skip(1).enumerate() {
        let quotient = pool.short(|pool| pool.div(*coefficient, coefficients[coefficients.len() - 1]));
        let quotient = on_one_bar(pool, quotient);
        sums.push(if at % 2 == 0 { pool.neg(quotient) } else { quotient });
    }
    sums
}

/// Two zeros; those that are long by their sum and product on a page where that is much shorter.
fn named(pool: &mut Algebra<'_>, request: Request<'_>, coefficients: &[ExprId], zeros: Vec<ExprId>) -> Roots {
    let (_, rest) = without_zeros(pool, coefficients);
    let written = pool.weight_of(&zeros);
    let mut roots = Roots::of(zeros);
    if written <= MOST_FOR_TWO || rest.len() != 3 {
        return roots;
    }
    let mut sums = sums_of_products(pool, rest);
    let found = solve(pool, request, &sums).filter(|(weight, _)| *weight <= written - written / 3);
    sums.iter_mut().for_each(|own| *own = pool.polished(*own));
    if found.is_some()
        && let Some((_, mut solved)) = solve(pool, request, &sums)
    {
        let zeros = roots.zeros.iter().copied();
        solved.frequencies = zeros.filter(|zero| !zero.is_zero()).collect();
        roots.solved.push(solved);
    }
    roots
}

/// The zeros that are 0, and the coefficients without them.
pub(super) fn without_zeros<'a>(pool: &Pool, coefficients: &'a [ExprId]) -> (&'a [ExprId], &'a [ExprId]) {
    let before_last = coefficients.iter().take(coefficients.len().saturating_sub(1));
    coefficients.split_at(before_last.take_while(|own| pool.vanishes(**own)).count())
}

/// The zeros for two coordinates with a diagonal M: with a = K_11/M_11, b = K_22/M_22 and c = K_12^2/(M_11 M_22)
/// they are (a + b)/2 -+ sqrt((a - b)^2/4 + c).
fn pair_of_roots(pool: &mut Algebra<'_>, block: &Pair) -> Vec<ExprId> {
    let [(m1, k1), (_, k12), (m2, k2)] = [(0, 0), (0, 1), (1, 1)].map(|(i, j)| block.at(pool, i, j));
    let [a, b, c] = [
        vec![(k1, Number::ONE), (m1, Number::MINUS_ONE)],
        vec![(k2, Number::ONE), (m2, Number::MINUS_ONE)],
        vec![(k12, Number::from(2)), (m1, Number::MINUS_ONE), (m2, Number::MINUS_ONE)],
    ]
    .map(|factors| pool.product_of_powers(&factors));
    let middle = pool.short(|pool| pool.linear(&[(a, Number::half()), (b, Number::half())]));
    let difference = pool.short(|pool| pool.sub(a, b));
    let square = pool.square(difference);
    let quarter = Number::half().mul(&Number::half());
    let c = pool.simplify(c);
    let inside = pool.linear(&[(square, quarter), (c, Number::ONE)]);
    around(pool, middle, inside)
}

/// middle -+ sqrt(square): added up where the root can be drawn, else as two terms.
fn around(pool: &mut Algebra<'_>, middle: ExprId, square: ExprId) -> Vec<ExprId> {
    let (root, is_exact) = root(pool, square);
    let roots = [Number::MINUS_ONE, Number::ONE].map(|sign| {
        let value = pool.linear(&[(middle, Number::ONE), (root, sign)]);
        if is_exact { pool.simplify(value) } else { with_common_bar(pool, value) }
    });
    roots.to_vec()
}

/// p ∓ √(p² - q) as (N ∓ √(N² - 4 Q D))/(2 D), with p = N/(2 D) and q = Q/D; `None` where there are no fractions.
fn over_one_bar(pool: &mut Algebra<'_>, p: ExprId, q: ExprId) -> Option<Vec<ExprId>> {
    let p = pool.scale(p, &Number::from(2));
    let [p, q] = [p, q].map(|own| {
        let flat = without_storeys(pool, own, false);
        one_fraction(pool, flat)
    });
    let below = below_bars([p, q].map(|own| pool.factors(split(pool, own).1)).iter().flatten());
    if below.is_empty() {
        return None;
    }
    let below: Vec<(ExprId, Number)> = below.into_iter().collect();
    let bar = pool.product_of_powers(&below);
    let [n, q] = [p, q].map(|own| pool.short(|pool| pool.mul(own, bar)));
    let square = pool.square(n);
    let product = pool.mul(q, bar);
    let inside = pool.linear(&[(square, Number::ONE), (product, Number::from(-4))]);
    let above = around(pool, n, inside).into_iter();
    let half = |above| {
        let value = pool.div(above, bar);
        pool.scale(value, &Number::half())
    };
    Some(above.map(half).collect())
}

/// Sums below a fraction bar, or on both sides of it, that have fractions of their own as quotients: a/(b - c/d) is a d/(b d - c).
fn without_storeys(pool: &mut Algebra<'_>, e: ExprId, both: bool) -> ExprId {
    let mut terms = Vec::new();
    for (term, coefficient) in pool.terms(e) {
        let factors = pool.factors(term).into_iter().map(|(base, exponent)| {
            let is_high =
                (both || exponent.is_negative()) && exponent.is_integer() && pool.fractions_in_sums(&[base]) > 0;
            (if is_high { one_fraction(pool, base) } else { base }, exponent)
        });
        let factors: Vec<(ExprId, Number)> = factors.collect();
        terms.push((pool.product_of_powers(&factors), coefficient));
    }
    pool.linear(&terms)
}

/// A quotient over one fraction bar, where that is easier to read.
pub(super) fn best_to_read(pool: &mut Algebra<'_>, e: ExprId) -> ExprId {
    if pool.fractions_in_sums(&[e]) == 0 {
        return e;
    }
    let flat = without_storeys(pool, e, false);
    let over = one_fraction(pool, flat);
    let over = without_storeys(pool, over, true);
    if pool.cost(&[over]) < pool.cost(&[e]) { over } else { e }
}

/// What all terms have in common in front, where that is shorter: g (a - √b)/c.
pub(super) fn with_common_bar(pool: &mut Algebra<'_>, e: ExprId) -> ExprId {
    let whole = with_common_factor(pool, e);
    if pool.weight(whole) < pool.weight(e) { whole } else { e }
}

/// det(K - z M).
fn characteristic(pool: &mut Algebra<'_>, block: &Pair) -> Option<Polynomial> {
    let n = block.len();
    let mut entries = vec![vec![Vec::new(); n]; n];
    for (i, row) in entries.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            let (m, k) = block.at(pool, i, j);
            *entry = vec![k, pool.neg(m)];
        }
    }
    let found = determinant_of_polynomials(pool, &entries)?;
    (found.len() == n + 1).then_some(found)
}

/// An expression or its opposite, whichever the values of the parameters make it: without bars about factors, but below roots.
pub(super) fn up_to_sign(pool: &mut Pool, e: ExprId) -> ExprId {
    let (size, core) = pool.split_content(e);
    let bare = |(base, exponent): (ExprId, Number)| match *pool.node(base) {
        Node::Function(Function::Abs, x) if exponent.is_integer() => (x, exponent),
        _ => (base, exponent),
    };
    let factors: Vec<(ExprId, Number)> = pool.factors(core).into_iter().map(bare).collect();
    let product = pool.product_of_powers(&factors);
    pool.scale(product, &size)
}

/// The determinant of a matrix of polynomials, each with the constant first, by expansion along the columns with the minors kept
/// (Laplace).
pub(super) fn determinant_of_polynomials(pool: &mut Algebra<'_>, entries: &[Vec<Polynomial>]) -> Option<Polynomial> {
    let n = entries.len();
    // By the set of rows used so far: the determinant of these with the first columns.
    let mut minors: BTreeMap<u32, Vec<Vec<ExprId>>> = BTreeMap::new();
    minors.insert(0, vec![vec![pool.one()]]);
    for column in 0..n {
        let mut next: BTreeMap<u32, Vec<Vec<ExprId>>> = BTreeMap::new();
        let own: Vec<&Polynomial> = entries.iter().filter_map(|row| row.get(column)).collect();
        for (set, polynomial) in &minors {
            for (row, entry) in own.iter().enumerate().filter(|(row, _)| set & (1 << row) == 0) {
                if entry.iter().all(|own| own.is_zero()) {
                    continue;
                }
                let later = (row + 1..n).filter(|other| set & (1 << other) != 0).count();
                let sign = if later % 2 == 0 { Number::ONE } else { Number::MINUS_ONE };
                let into = next.entry(set | 1 << row).or_default();
                into.resize(into.len().max(polynomial.len() + entry.len() - 1), Vec::new());
                for (degree, parts) in polynomial.iter().enumerate() {
                    let value = pool.sum(parts);
                    for (shift, factor) in entry.iter().enumerate().filter(|(_, factor)| !factor.is_zero()) {
                        let factor = pool.scale(*factor, &sign);
                        into[degree + shift].push(pool.mul(value, factor));
                    }
                }
            }
        }
        minors = BTreeMap::new();
        for (set, polynomial) in next {
            let shortened = polynomial.into_iter().map(|parts| vec![pool.short(|pool| pool.sum(&parts))]);
            minors.insert(set, shortened.collect());
        }
    }
    let mut coefficients: Vec<ExprId> = minors.into_values().next()?.into_iter().flatten().collect();
    while let Some(last) = coefficients.last()
        && last.is_zero()
    {
        coefficients.pop();
    }
    Some(coefficients)
}

/// The zeros of a polynomial of positive degree, of which those that are not 0 are two at most.
pub(super) fn of_polynomial(pool: &mut Algebra<'_>, coefficients: &[ExprId]) -> Option<Vec<ExprId>> {
    let (zeros, rest) = without_zeros(pool, coefficients);
    let mut roots = vec![pool.zero(); zeros.len()];
    let quotient = |pool: &mut Algebra<'_>, a: ExprId, b: ExprId| pool.short(|pool| pool.div(a, b));
    match rest {
        [_] => {}
        [c, b] => {
            let value = quotient(pool, *c, *b);
            roots.push(pool.neg(value));
        }
        [c, b, a] => {
            // z = p -+ sqrt(p^2 - q)
            let half = quotient(pool, *b, *a);
            let p = pool.scale(half, &Number::half().neg());
            let q = quotient(pool, *c, *a);
            let square = pool.square(p);
            let difference = pool.sub(square, q);
            let plain = around(pool, p, difference);
            let over = over_one_bar(pool, p, q).filter(|own| pool.cost(own) < pool.cost(&plain));
            roots.extend(over.unwrap_or(plain));
        }
        _ => return None,
    }
    Some(roots)
}

/// A square root of an expression, up to its sign, and whether it could be drawn: the polynomial of which
/// it is the square where it is one, else with squares of common factors in front of the root where that
/// is shorter.
pub(super) fn root(pool: &mut Algebra<'_>, e: ExprId) -> (ExprId, bool) {
    if pool.vanishes(e) {
        return (pool.zero(), true);
    }
    let plain = pool.sqrt(e);
    let Some(monomials) = collapsed(pool, e, Opening::Powers) else { return (plain, false) };
    let Some((_, size)) = leading(&monomials) else { return (plain, false) };
    let inverse = if size.is_negative() { None } else { size.recip() };
    let scaled =
        inverse.map(|inverse| monomials.iter().map(|(monomial, c)| (monomial.clone(), c.mul(&inverse))).collect());
    if let Some(terms) = scaled.and_then(|scaled: Monomials| exact_root(&scaled)) {
        let size = pool.number(size);
        let size = pool.sqrt(size);
        let value = written(pool, terms);
        return (pool.short(|pool| pool.mul(size, value)), true);
    }
    // With inner sums as they are too: (a + b)^2 below a root says more than what it is multiplied out.
    let mut best = plain;
    let outer = expand(pool, e, Opening::Outermost);
    for (terms, inner) in [Some(monomials), outer].into_iter().flatten().zip([true, false]) {
        let candidate = taken_out(pool, &terms, inner);
        if pool.weight(candidate) < pool.weight(best) {
            best = candidate;
        }
    }
    (best, false)
}

/// A square root, up to its sign, of an expression as it stands, even powers that are factors of it in front.
pub(super) fn plain_root(pool: &mut Algebra<'_>, e: ExprId) -> ExprId {
    if let Some(terms) = expand(pool, e, Opening::Outermost) { taken_out(pool, &terms, false) } else { pool.sqrt(e) }
}

/// The root of a sum with the even powers that all terms have in common in front.
fn taken_out(pool: &mut Algebra<'_>, terms: &Monomials, shorten: bool) -> ExprId {
    let mut common = terms.keys().cloned().reduce(|common, own| in_common(&common, &own)).unwrap_or_default();
    if !shorten {
        // A fraction that is not in all terms stays where it is.
        let in_all = |base| terms.keys().all(|monomial| power_of(monomial, base).is_some());
        common.retain(|(base, exponent)| in_all(*base) && exponent.is_even());
    }
    let mut outside = Monomial::new();
    let mut inverse = Monomial::new();
    for (base, exponent) in common {
        // A negative power is taken out whole, so that no fraction is left below the root.
        let half = exponent.mul(&Number::half()).floor();
        if !half.is_zero() {
            inverse.push((base, half.mul(&Number::from(-2))));
            outside.push((base, half));
        }
    }
    inverse.order_by_key(|(base, _)| *base);
    let mut inside = written(pool, terms.iter().map(|(monomial, c)| (times(monomial, &inverse, &Number::ONE), c)));
    if shorten {
        inside = pool.simplify(inside);
    }
    outside.push((pool.sqrt(inside), Number::ONE));
    pool.product_of_powers(&outside)
}

/// For each base the smaller power.
fn in_common(a: &Monomial, b: &Monomial) -> Monomial {
    let bases: BTreeSet<ExprId> = a.iter().chain(b).map(|(base, _)| *base).gather();
    let power = |monomial, base| power_of(monomial, base).cloned().unwrap_or_default();
    let smaller = bases.into_iter().map(|base| (base, power(a, base).min(power(b, base))));
    smaller.filter(|(_, exponent)| !exponent.is_zero()).collect()
}

/// Compares powers base by base: an order that multiplication keeps.
fn compare(a: &Monomial, b: &Monomial) -> Ordering {
    let alike = a.iter().zip(b).take_while(|(a, b)| a == b).count();
    match (a.get(alike), b.get(alike)) {
        (Some((p, x)), Some((q, y))) if p == q => x.cmp(y),
        (Some((p, x)), other) if other.is_none_or(|(q, _)| p < q) => x.cmp(&Number::ZERO),
        (_, Some((_, y))) => Number::ZERO.cmp(y),
        (_, None) => Ordering::Equal,
    }
}

/// The term that is largest in an order that multiplication keeps.
fn leading(terms: &Monomials) -> Option<(Monomial, Number)> {
    let largest = terms.iter().max_by(|(a, _), (b, _)| compare(a, b))?;
    Some((largest.0.clone(), largest.1.clone()))
}

/// The polynomial (with negative powers too) whose square this is, by division from the leading term on,
/// whose coefficient is 1.
fn exact_root(square: &Monomials) -> Option<Vec<(Monomial, Number)>> {
    if square.len() > MOST_TERMS {
        return None;
    }
    let (monomial, _) = leading(square)?;
    let half = |(base, exponent): (ExprId, Number)| {
        let half = exponent.mul(&Number::half());
        half.is_integer().then_some((base, half))
    };
    let first: Monomial = monomial.into_iter().map(half).collect::<Option<_>>()?;
    let mut root = vec![(first.clone(), Number::ONE)];
    let mut rest = square.clone();
    let subtract = |rest: &mut Monomials, monomial: Monomial, value: &Number| add_to(rest, monomial, &value.neg());
    subtract(&mut rest, times(&first, &first, &Number::ONE), &Number::ONE);
    let twice = Number::half();
    while let Some((monomial, coefficient)) = leading(&rest) {
        // A root of t terms has at most t (t + 1)/2 terms in its square and at least t.
        if root.len() > square.len() {
            return None;
        }
        let next = times(&monomial, &first, &Number::MINUS_ONE);
        let value = coefficient.mul(&twice);
        for (other, factor) in &root {
            let product = factor.mul(&value).mul(&Number::from(2));
            subtract(&mut rest, times(other, &next, &Number::ONE), &product);
        }
        subtract(&mut rest, times(&next, &next, &Number::ONE), &value.mul(&value));
        root.push((next, value));
    }
    Some(root)
}
