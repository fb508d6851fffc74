//! Expressions as polynomials in what they are built of, and back.

use std::collections::BTreeMap;

use super::collapse::collapse;
use super::simplify::{Algebra, Monomial, Monomials, Opening, collapsed, expand, power_of, times};
use crate::expr::{ExprId, Pool};
use crate::number::Number;
use crate::order::Order;
use crate::polynomial::{Polynomial, add_to};

/// Expressions with more terms than this are not multiplied out.
const MOST_TERMS: usize = 600;

/// The variable that stands for the exponent s.
pub(super) const EXPONENT: usize = 0;

/// What the variables of polynomials stand for.
pub(super) struct Ring {
    /// Bases, with the part of their powers that counts as one: 1/2 for a square root. The first is that of variable 1.
    bases: Monomial,
    /// Roots of what has no symbols.
    roots: Vec<Root>,
}

/// A variable of which a power is known.
struct Root {
    variable: usize,
    power: u32,
    value: Polynomial,
}

/// Expressions multiplied out, all with the same powers of what stands below a fraction bar.
pub(super) struct Expanded {
    all: Vec<Monomials>,
    by: Monomial,
}

impl Expanded {
    /// Multiplies out, and by what stands below a fraction bar; `None` where that gets too long.
    pub(super) fn new(pool: &mut Pool, expressions: &[ExprId]) -> Option<Self> {
        let mut all = Vec::new();
        for e in expressions {
            let vanishes = pool.vanishes(*e);
            all.push(if vanishes { Monomials::new() } else { collapsed(pool, *e, Opening::Powers)? });
        }
        let mut own = Self { all, by: Monomial::new() };
        while let Some((base, power)) = own.below() {
            own.multiply(pool, base, &power)?;
        }
        Some(own)
    }

    /// Each for a variable of its own, as it stands, where they get too long otherwise.
    pub(super) fn as_they_stand(pool: &Pool, expressions: &[ExprId]) -> Self {
        let alone = |e: &ExprId| match pool.as_number(*e) {
            Some(number) if number.is_zero() => Monomials::new(),
            Some(number) => Monomials::from([(Monomial::new(), number.clone())]),
            None => Monomials::from([(vec![(*e, Number::ONE)], Number::ONE)]),
        };
        Self { all: expressions.iter().map(alone).collect(), by: Monomial::new() }
    }

    /// Whether they were multiplied by what stood below a fraction bar.
    pub(super) fn is_fraction(&self) -> bool {
        !self.by.is_empty()
    }

    /// Whether there are powers that are no whole ones.
    pub(super) fn has_roots(&self) -> bool {
        self.all.iter().flat_map(BTreeMap::keys).flatten().chain(&self.by).any(|(_, exponent)| !exponent.is_integer())
    }

    /// A base below some fraction bar, or a sum with a power that can be multiplied out, and by which power it is taken up.
    fn below(&self) -> Option<(ExprId, Number)> {
        let powers = self.all.iter().flat_map(BTreeMap::keys).flatten();
        let (base, exponent) = powers.filter(|(_, exponent)| exponent.is_negative()).min()?;
        Some((*base, exponent.neg()))
    }

    fn multiply(&mut self, pool: &mut Pool, base: ExprId, power: &Number) -> Option<()> {
        let factor: Monomial = vec![(base, power.clone())];
        self.by = times(&self.by, &factor, &Number::ONE);
        for monomials in &mut self.all {
            let mut new = Monomials::new();
            for (monomial, coefficient) in std::mem::take(monomials) {
                let monomial = times(&monomial, &factor, &Number::ONE);
                // A sum with a power of its own is multiplied out.
                if pool.is_sum(base) && power_of(&monomial, base).is_some_and(|power| !power.floor().is_zero()) {
                    let product = pool.product_of_powers(&monomial);
                    for (monomial, own) in expand(pool, product, Opening::Powers)? {
                        add_to(&mut new, monomial, &own.mul(&coefficient));
                    }
                    if new.len() > MOST_TERMS {
                        return None;
                    }
                } else {
                    add_to(&mut new, monomial, &coefficient);
                }
            }
            collapse(pool, &mut new);
            *monomials = new;
        }
        (self.all.iter().map(BTreeMap::len).sum::<usize>() <= MOST_TERMS).then_some(())
    }
}

impl Ring {
    /// With a variable for each base of these.
    pub(super) fn new<'a>(pool: &mut Pool, expanded: impl Iterator<Item = &'a Expanded>) -> Self {
        let mut bases: BTreeMap<ExprId, Number> = BTreeMap::new();
        for own in expanded {
            let monomials = own.all.iter().flat_map(BTreeMap::keys).flatten();
            for (base, exponent) in monomials.chain(&own.by) {
                // One over the least common multiple of the denominators.
                let step = bases.entry(*base).or_insert(Number::ONE);
                *step = step.gcd(exponent);
            }
        }
        let mut own = Self { bases: bases.into_iter().collect(), roots: Vec::new() };
        let mut roots = Vec::new();
        for (at, (base, step)) in (1..).zip(&own.bases) {
            if step.is_one() || !pool.is_constant(*base) {
                continue;
            }
            let value = Expanded::new(pool, &[*base]).filter(|own| own.by.is_empty());
            let value = value.and_then(|value| own.polynomial(value.all.first()?));
            let parts = step.recip().and_then(|parts| u32::try_from(parts.to_i64()?).ok());
            roots.extend(parts.zip(value).map(|(power, value)| Root { variable: at, power, value }));
        }
        // Roots of sums with roots in them come first.
        roots.order_by_key(|root| root.value.is_constant());
        own.roots = roots;
        own
    }

    /// With what powers of roots without symbols are: √3² is 3.
    pub(super) fn reduced(&self, polynomial: Polynomial) -> Polynomial {
        self.roots.iter().fold(polynomial, |own, Root { variable: at, power: parts, value }| {
            let high = |(powers, _): (&Vec<u32>, &Number)| powers[*at] >= *parts;
            if !own.terms().any(high) {
                return own;
            }
            let mut sum = Polynomial::zero(self.variables());
            for (power, own) in (0..).zip(own.coefficients(*at)) {
                let mut left = vec![0; self.variables()];
                left[*at] = power % parts;
                let whole = (0..power / parts).fold(Polynomial::monomial(left), |product, _| product.times(value));
                sum = sum.plus(&own.times(&whole));
            }
            sum
        })
    }

    /// How many variables there are, that for the exponent included.
    pub(super) fn variables(&self) -> usize {
        self.bases.len() + 1
    }

    /// What a variable is a power of, and whether it is a root of it.
    pub(super) fn base(&self, variable: usize) -> Option<(ExprId, bool)> {
        self.power(variable).map(|(base, step)| (base, !step.is_one()))
    }

    /// What a variable is a power of, and the power.
    pub(super) fn power(&self, variable: usize) -> Option<(ExprId, &Number)> {
        self.bases.get(variable.checked_sub(1)?).map(|(base, step)| (*base, step))
    }

    /// The powers of a monomial.
    fn powers(&self, monomial: &Monomial) -> Option<Vec<(usize, i64)>> {
        let power = |(base, exponent): &(ExprId, Number)| {
            let at = self.bases.binary_search_by_key(base, |(own, _)| *own).ok()?;
            Some((at + 1, exponent.div(&self.bases[at].1)?.to_i64()?))
        };
        monomial.iter().map(power).collect()
    }

    fn polynomial(&self, monomials: &Monomials) -> Option<Polynomial> {
        let mut polynomial = Polynomial::zero(self.variables());
        for (monomial, coefficient) in monomials {
            let mut powers = vec![0; self.variables()];
            for (at, power) in self.powers(monomial)? {
                powers[at] = u32::try_from(power).ok()?;
            }
            polynomial.add(powers, coefficient);
        }
        Some(polynomial)
    }

    /// As polynomials; `None` where a base has no variable.
    pub(super) fn polynomials(&self, expanded: &Expanded) -> Option<Vec<Polynomial>> {
        expanded.all.iter().map(|own| self.polynomial(own)).collect()
    }

    /// Polynomials that are the expressions times the same positive factor.
    pub(super) fn of_signs(&self, expanded: &Expanded) -> Option<Vec<Polynomial>> {
        let mut powers = vec![0; self.variables()];
        for (at, power) in self.powers(&expanded.by)? {
            powers[at] = u32::from(power % 2 != 0);
        }
        let by = Polynomial::monomial(powers);
        expanded.all.iter().map(|own| Some(self.polynomial(own)?.times(&by))).collect()
    }

    /// A polynomial without the exponent as an expression in its shortest form.
    pub(super) fn expression(&self, pool: &mut Algebra<'_>, polynomial: &Polynomial) -> ExprId {
        pool.in_bases(&self.bases, polynomial.terms().map(|(powers, own)| (&powers[1..], own)))
    }
}
