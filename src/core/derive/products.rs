//! Sums as products of sums, and with squares completed.
//!
//! Products are factors of the polynomial that a sum is in what it is built of (`factors`), asked for only where values modulo a
//! prime leave it open. a² + 2 a b + b² + c is (a + b)² + c. Only results are examined (`Algebra::polished`): equations keep the
//! terms that their energies have.

use std::collections::BTreeSet;

use super::simplify::{Algebra, Monomial, Monomials, common_factor, power_of, split, times};
use crate::expr::{ExprId, PRIME, add_mod, mul_mod, neg_mod, pow_mod};
use crate::number::Number;
use crate::order::Gather;
use crate::polynomial::{Polynomial, add_to};

/// Longer sums are left as they are.
const MOST_TERMS: usize = 100;
/// So are those of which no part is of the first degree.
const MOST_OF_HIGHER_DEGREE: usize = 30;
/// Squares of longer sums are not searched for.
const MOST_WITH_SQUARES: usize = 40;
/// Nor are factors of higher powers.
const MOST_POWER: u32 = 8;
/// At so many points a discriminant has to be a square.
const POINTS: u64 = 8;

impl Algebra<'_> {
    /// Other forms of a sum than those that have common factors in front.
    pub(super) fn products(&mut self, terms: &[(Monomial, Number)]) -> Vec<ExprId> {
        if terms.len() < 3 {
            return Vec::new();
        }
        let completed = self.completed(terms).map(|terms| self.nested(terms));
        self.in_factors(terms).into_iter().chain(completed).collect()
    }

    /// The product of two sums and more, in each of which no variable is; `None` where there is none.
    pub(super) fn in_factors(&mut self, terms: &[(Monomial, Number)]) -> Option<ExprId> {
        let InBases { common: mut product, bases, polynomial } = as_polynomial(terms)?;
        let factors = polynomial.may_be_product().then(|| polynomial.factored())?;
        if factors.iter().map(|(_, times)| times).sum::<usize>() < 2 {
            return None;
        }
        let mut rest = polynomial;
        for (own, times) in factors {
            rest = (0..times).try_fold(rest, |rest, _| rest.over(&own))?;
            let sum = self.in_bases(&bases, own.terms().map(|(powers, value)| (powers.as_slice(), value)));
            product.push((sum, Number::from(times as i64)));
        }
        let number = rest.terms().next().map(|(_, value)| value.clone()).filter(|_| rest.is_constant())?;
        let product = self.product_of_powers(&product);
        Some(self.scale(product, &number))
    }

    /// With squares of sums of two for three terms each; `None` where there are none.
    fn completed(&mut self, terms: &[(Monomial, Number)]) -> Option<Vec<(Monomial, Number)>> {
        if terms.len() > MOST_WITH_SQUARES {
            return None;
        }
        let mut rest: Monomials = terms.iter().cloned().collect();
        let mut found = Monomials::new();
        for (middle, twice) in terms {
            let Some([a, b]) = ends(&rest, middle, twice) else { continue };
            let [Some(of_a), Some(of_b)] = [&a, &b].map(|own| rest.get(own).cloned()) else { continue };
            let common = common_factor(&[(a.clone(), of_a.clone()), (b.clone(), of_b.clone())]);
            let size = of_a.gcd(&of_b);
            let size = if of_a.is_negative() { size.neg() } else { size };
            let root = |of: &Monomial, number: &Number| {
                let half = |(base, exponent): (ExprId, Number)| Some((base, exponent)).filter(|own| own.1.is_even());
                let own = times(of, &common, &Number::MINUS_ONE).into_iter().map(half).collect::<Option<Monomial>>()?;
                let own = own.into_iter().map(|(base, exponent)| (base, exponent.mul(&Number::half()))).collect();
                Some((own, number.div(&size)?.sqrt_exact()?))
            };
            let (Some((x, of_x)), Some((y, of_y))) = (root(&a, &of_a), root(&b, &of_b)) else { continue };
            let of_y = if twice.is_negative() == size.is_negative() { of_y } else { of_y.neg() };
            let (x, y): (Monomial, Monomial) = (x, y);
            let (x, y) = (self.product_of_powers(&x), self.product_of_powers(&y));
            let sum = self.linear(&[(x, of_x), (y, of_y)]);
            let mut square = common;
            square.push((sum, Number::from(2)));
            let square = self.product_of_powers(&square);
            let (number, square) = split(self, square);
            add_to(&mut found, self.factors(square), &number.mul(&size));
            [&a, &b, middle].into_iter().for_each(|own| _ = rest.remove(own));
        }
        (!found.is_empty()).then(|| found.into_iter().chain(rest).collect())
    }
}

/// Two terms whose product is a quarter of the square of another one.
fn ends(terms: &Monomials, middle: &Monomial, twice: &Number) -> Option<[Monomial; 2]> {
    let own = terms.get(middle)?;
    let quarter = own.mul(twice).mul(&Number::half()).mul(&Number::half());
    let square = times(middle, middle, &Number::ONE);
    terms.iter().filter(|(a, _)| *a != middle).find_map(|(a, of_a)| {
        let b = times(&square, a, &Number::MINUS_ONE);
        let of_b = terms.get(&b)?;
        (of_a.mul(of_b) == quarter).then(|| [a.clone(), b])
    })
}

/// A sum as a polynomial times what all terms have in common.
struct InBases {
    common: Monomial,
    /// The variables of the polynomial: bases with the part of their powers that counts as one.
    bases: Monomial,
    polynomial: Polynomial,
}

/// `None` where it is too long, or is no product at first sight.
fn as_polynomial(terms: &[(Monomial, Number)]) -> Option<InBases> {
    if !(2..=MOST_TERMS).contains(&terms.len()) {
        return None;
    }
    let all: BTreeSet<ExprId> = terms.iter().flat_map(|(monomial, _)| monomial).map(|(base, _)| *base).gather();
    let (mut common, mut bases, mut columns) = (Monomial::new(), Vec::new(), Vec::new());
    for base in all {
        let own = terms.iter().map(|(monomial, _)| power_of(monomial, base).cloned().unwrap_or_default());
        let own: Vec<Number> = own.collect();
        let least = own.iter().min()?.clone();
        let step = own.iter().fold(Number::ONE, |step, power| step.gcd(&power.sub(&least)));
        let power = |power: &Number| u32::try_from(power.sub(&least).div(&step)?.to_i64()?).ok();
        let powers = own.iter().map(power).collect::<Option<Vec<u32>>>()?;
        if !least.is_zero() {
            common.push((base, least));
        }
        let most = powers.iter().copied().max()?;
        // With a single term that has it, or has it not, there is nothing that could be before all powers.
        let without = powers.iter().filter(|power| **power == 0).count();
        if most > MOST_POWER || most == 1 && [1, terms.len() - 1].contains(&without) {
            return None;
        }
        if most > 0 {
            bases.push((base, step));
            columns.push(powers);
        }
    }
    let linear = columns.iter().any(|powers| powers.iter().all(|power| *power <= 1));
    if !linear && terms.len() > MOST_OF_HIGHER_DEGREE {
        return None;
    }
    let mut polynomial = Polynomial::zero(bases.len());
    for (at, (_, value)) in terms.iter().enumerate() {
        polynomial.add(columns.iter().map(|powers| powers[at]).collect(), value);
    }
    Some(InBases { common, bases, polynomial })
}

impl Polynomial {
    /// Whether it can be a product, as far as values modulo a prime tell: of second degree in a variable it is one only where the
    /// discriminant is a square. Of the first degree its factors are found as fast as that.
    fn may_be_product(&self) -> bool {
        let Some(variable) = (0..self.variables()).min_by_key(|at| self.degree(*at)) else { return false };
        if self.degree(variable) != 2 {
            return true;
        }
        (0..POINTS).all(|point| {
            let own = self.residues(variable, point);
            let Some([c, b, a]) = own.as_deref() else { return true };
            let discriminant = add_mod(mul_mod(*b, *b), neg_mod(mul_mod(4, mul_mod(*a, *c))));
            pow_mod(discriminant, (PRIME - 1) / 2) <= 1
        })
    }
}
