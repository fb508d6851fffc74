//! What has to be positive, as a reader writes it: with a side for each sign, a single term against a product, squares completed.
//!
//! All forms say the same; the one with the fewest characters is taken.

use super::ring::{Expanded, Ring};
use super::simplify::Algebra;
use crate::expr::{ExprId, Pool};
use crate::number::Number;
use crate::polynomial::Polynomial;

/// Longer sums stay as they are.
const MOST_TERMS: usize = 40;
/// A minus sign in front is as hard to read as so many characters.
const MINUS: usize = 12;
/// Squares of longer sums are not searched for.
const MOST_IN_ROOT: usize = 5;

/// Two expressions, the first of which is more than the second one where `positive` is positive; `None` where all terms of that have
/// the same sign.
pub fn greater_and_less(pool: &mut Pool, positive: ExprId) -> Option<[ExprId; 2]> {
    let by_signs = |of: &Polynomial| {
        let mut sides = [Polynomial::zero(of.variables()), Polynomial::zero(of.variables())];
        for (powers, value) in of.terms() {
            sides[usize::from(value.is_negative())].add(powers.clone(), &value.abs());
        }
        sides
    };
    let expanded = Expanded::new(pool, &[positive])?;
    let ring = Ring::new(pool, std::iter::once(&expanded));
    let whole = ring.polynomials(&expanded)?.pop()?;
    let plain = by_signs(&whole);
    let count = whole.terms().count();
    if plain.iter().any(Polynomial::is_zero) || expanded.is_fraction() {
        return None;
    }
    let algebra = &mut Algebra::new(pool);
    let mut best = plain.map(|side| expression(algebra, &ring, &side));
    let mut length = shown(algebra, best);
    let mut try_out = |pool: &mut Algebra<'_>, sides: [ExprId; 2]| {
        let own = shown(pool, sides);
        if own < length {
            (best, length) = (sides, own);
        }
    };
    if count > MOST_TERMS {
        return Some(best);
    }
    let product = [expression(algebra, &ring, &whole), algebra.zero()];
    try_out(algebra, product);
    // One term against all others.
    for (powers, value) in whole.terms().filter(|_| count > 2) {
        let mut term = Polynomial::zero(whole.variables());
        term.add(powers.clone(), &value.abs());
        let rest = if value.is_negative() { whole.clone().plus(&term) } else { term.clone().minus(&whole) };
        let [term, rest] = [term, rest].map(|side| expression(algebra, &ring, &side));
        try_out(algebra, if value.is_negative() { [rest, term] } else { [term, rest] });
    }
    for root in roots(&whole) {
        let less = root.times(&root).minus(&whole);
        if less.terms().count() < count {
            let [positive, negative] = by_signs(&less).map(|side| expression(algebra, &ring, &side));
            let root = ring.expression(algebra, &root);
            let square = algebra.square(root);
            let more = algebra.add(square, negative);
            try_out(algebra, [more, positive]);
            let less = expression(algebra, &ring, &less);
            try_out(algebra, [square, less]);
        }
    }
    Some(best)
}

/// The characters of both sides. No side begins with a minus sign if that can be helped.
fn shown(pool: &Algebra<'_>, sides: [ExprId; 2]) -> usize {
    let length = |side| {
        let text = pool.display(side);
        text.len() + if text.starts_with('-') { MINUS } else { 0 }
    };
    let length = sides.map(length).iter().sum();
    // Each of several sums that are factors tells where the sign changes.
    let sums = pool.factors(sides[0]).iter().filter(|(base, _)| pool.is_sum(*base)).count();
    if sides[1].is_zero() && sums > 1 { length / 3 * 2 } else { length }
}

/// The shortest form of a side, or its factors where they are shorter.
fn expression(pool: &mut Algebra<'_>, ring: &Ring, side: &Polynomial) -> ExprId {
    let plain = ring.expression(pool, side);
    let common = side.common_powers();
    let rest = side.without(&common);
    let factors = rest.factored();
    let mut each = factors.iter().flat_map(|(own, times)| std::iter::repeat_n(own, *times));
    let Some(number) = each.try_fold(rest, |rest, own| rest.over(own)) else { return plain };
    let mut powers = vec![(ring.expression(pool, &number.times(&Polynomial::monomial(common))), Number::ONE)];
    powers.extend(factors.iter().map(|(own, times)| (ring.expression(pool, own), Number::from(*times as i64))));
    let product = pool.product_of_powers(&powers);
    let length = |e: ExprId| pool.display(e).len();
    if length(product) < length(plain) { product } else { plain }
}

/// Sums whose squares have the square terms of a polynomial.
fn roots(of: &Polynomial) -> Vec<Polynomial> {
    let root = |(powers, value): (&Vec<u32>, &Number)| {
        let whole = powers.iter().all(|power| power % 2 == 0);
        let value = Some(value).filter(|value| whole && !value.is_negative())?.sqrt_exact()?;
        Some(Polynomial::monomial(powers.iter().map(|power| power / 2).collect()).scaled(&value))
    };
    let parts: Vec<Polynomial> = of.terms().filter_map(root).collect();
    if !(2..=MOST_IN_ROOT).contains(&parts.len()) {
        return Vec::new();
    }
    let with_signs = |signs: usize| {
        parts.iter().enumerate().fold(Polynomial::zero(of.variables()), |sum, (at, part)| {
            if at > 0 && signs >> (at - 1) & 1 == 1 { sum.minus(part) } else { sum.plus(part) }
        })
    };
    (0..1_usize << (parts.len() - 1)).map(with_signs).collect()
}
