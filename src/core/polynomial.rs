//! Polynomials in several variables with rational coefficients: exact quotients, greatest common divisors, and factors that
//! occur several times.
//!
//! Greatest common divisors by primitive remainders (Knuth, The Art of Computer Programming, vol. 2, 4.6.1), asked for only
//! where one at random values modulo a prime leaves it open. *Knows no expressions.*

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use dashu_int::IBig;

use crate::expr::{PRIME, add_mod, inverse_mod, mix, mul_mod, neg_mod, pow_mod};
use crate::number::Number;
use crate::order::Order;

/// Beyond so many terms common divisors are not searched for.
const MOST_TERMS: usize = 400;
/// Products of more terms are not multiplied out where something else will do.
const MOST_PRODUCTS: usize = 20_000;

/// Exponents, one a variable.
type Powers = Vec<u32>;

/// Adds to the coefficient of a term; what is 0 then is left out.
pub(crate) fn add_to<K: Ord>(terms: &mut BTreeMap<K, Number>, key: K, coefficient: &Number) {
    match terms.entry(key) {
        Entry::Vacant(entry) if !coefficient.is_zero() => {
            entry.insert(coefficient.clone());
        }
        Entry::Vacant(_) => {}
        Entry::Occupied(mut entry) => {
            let sum = entry.get().add(coefficient);
            if sum.is_zero() {
                entry.remove();
            } else {
                entry.insert(sum);
            }
        }
    }
}

/// A sum of products of powers; none of its coefficients is 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Polynomial {
    variables: usize,
    terms: BTreeMap<Powers, Number>,
}

impl Polynomial {
    /// How many there are.
    pub(crate) fn variables(&self) -> usize {
        self.variables
    }

    pub(crate) fn zero(variables: usize) -> Self {
        Self { variables, terms: BTreeMap::new() }
    }

    /// In one variable, from its coefficients, the constant first.
    pub(crate) fn of_one(coefficients: impl IntoIterator<Item = IBig>) -> Self {
        let mut own = Self::zero(1);
        (0..).zip(coefficients).for_each(|(power, value)| own.add(vec![power], &Number::from_integer(value)));
        own
    }

    /// The coefficients of one in one variable, the constant first, where they are whole.
    pub(crate) fn whole(&self) -> Vec<IBig> {
        let constant = |own: &Self| own.terms.values().next().map_or(IBig::ZERO, Number::numerator);
        self.coefficients(0).iter().map(constant).collect()
    }

    pub(crate) fn constant(variables: usize, value: Number) -> Self {
        Self::monomial(vec![0; variables]).scaled(&value)
    }

    pub(crate) fn variable(variables: usize, at: usize) -> Self {
        Self::monomial((0..variables).map(|variable| u32::from(variable == at)).collect())
    }

    pub(crate) fn add(&mut self, powers: Powers, coefficient: &Number) {
        add_to(&mut self.terms, powers, coefficient);
    }

    pub(crate) fn terms(&self) -> impl Iterator<Item = (&Powers, &Number)> {
        self.terms.iter()
    }

    /// Whether the coefficient of the first term in the order of the variables is negative.
    pub(crate) fn is_negative(&self) -> bool {
        self.terms.last_key_value().is_some_and(|(_, value)| value.is_negative())
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.terms.is_empty()
    }

    /// Whether no variable occurs.
    pub(crate) fn is_constant(&self) -> bool {
        self.terms.keys().all(|powers| powers.iter().all(|power| *power == 0))
    }

    /// The highest power of a variable.
    pub(crate) fn degree(&self, variable: usize) -> u32 {
        self.terms.keys().map(|powers| powers[variable]).max().unwrap_or(0)
    }

    /// What stands before each power of a variable, the constant first.
    pub(crate) fn coefficients(&self, variable: usize) -> Vec<Self> {
        let mut all = vec![Self::zero(self.variables); self.degree(variable) as usize + 1];
        for (powers, value) in &self.terms {
            let mut rest = powers.clone();
            let power = std::mem::take(&mut rest[variable]);
            all[power as usize].terms.insert(rest, value.clone());
        }
        all
    }

    /// From what stands before each power of a variable.
    pub(crate) fn from_coefficients(variable: usize, coefficients: &[Self]) -> Self {
        let mut whole = Self::zero(coefficients.first().map_or(0, |own| own.variables));
        for (power, own) in (0..).zip(coefficients) {
            for (powers, value) in &own.terms {
                let mut powers = powers.clone();
                powers[variable] += power;
                whole.add(powers, value);
            }
        }
        whole
    }

    /// With a polynomial in the place of a variable.
    pub(crate) fn put(&self, variable: usize, value: &Self) -> Self {
        let coefficients = self.coefficients(variable).into_iter().rev();
        coefficients.fold(Self::zero(self.variables), |sum, own| sum.times(value).plus(&own))
    }

    /// With other powers of a variable; `None` where there is none for some.
    pub(crate) fn with_powers(&self, variable: usize, of: impl Fn(u32) -> Option<u32>) -> Option<Self> {
        let mut own = Self::zero(self.variables);
        for (powers, value) in &self.terms {
            let mut powers = powers.clone();
            powers[variable] = of(powers[variable])?;
            own.add(powers, value);
        }
        Some(own)
    }

    pub(crate) fn minus(mut self, other: &Self) -> Self {
        other.terms.iter().for_each(|(powers, value)| self.add(powers.clone(), &value.neg()));
        self
    }

    pub(crate) fn plus(mut self, other: &Self) -> Self {
        other.terms.iter().for_each(|(powers, value)| self.add(powers.clone(), value));
        self
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        let mut product = Self::zero(self.variables);
        self.terms.iter().for_each(|(powers, value)| product.add_multiple(other, powers, value));
        product
    }

    /// Adds a polynomial times one term; powers are copied only where they are new.
    fn add_multiple(&mut self, other: &Self, by: &[u32], coefficient: &Number) {
        let mut powers = Powers::with_capacity(self.variables);
        for (own, value) in &other.terms {
            powers.clear();
            powers.extend(by.iter().zip(own).map(|(a, b)| a + b));
            let share = value.mul(coefficient);
            match self.terms.get_mut(&powers) {
                None => {
                    self.terms.insert(powers.clone(), share);
                }
                Some(sum) => {
                    *sum = sum.add(&share);
                    if sum.is_zero() {
                        self.terms.remove(&powers);
                    }
                }
            }
        }
    }

    pub(crate) fn scaled(&self, factor: &Number) -> Self {
        if factor.is_zero() {
            return Self::zero(self.variables);
        }
        let terms = self.terms.iter().map(|(powers, value)| (powers.clone(), value.mul(factor))).collect();
        Self { variables: self.variables, terms }
    }

    /// Whether a product takes long.
    pub(crate) fn is_long_with(&self, other: &Self) -> bool {
        self.terms.len() * other.terms.len() > MOST_PRODUCTS
    }

    /// The quotient, where the division leaves nothing.
    pub(crate) fn over(&self, divisor: &Self) -> Option<Self> {
        let (mut divisor, mut rest) = (divisor.clone(), self.clone());
        let (first, size) = divisor.terms.pop_last()?;
        let inverse = size.recip()?;
        let mut quotient = Self::zero(self.variables);
        while let Some((mut powers, value)) = rest.terms.pop_last() {
            for (own, less) in powers.iter_mut().zip(&first) {
                *own = own.checked_sub(*less)?;
            }
            let value = value.mul(&inverse);
            rest.add_multiple(&divisor, &powers, &value.neg());
            quotient.terms.insert(powers, value);
        }
        Some(quotient)
    }

    /// d/dx
    pub(crate) fn derivative(&self, variable: usize) -> Self {
        let mut slope = Self::zero(self.variables);
        for (powers, value) in self.terms.iter().filter(|(powers, _)| powers[variable] > 0) {
            let factor = Number::from(i64::from(powers[variable]));
            let mut powers = powers.clone();
            powers[variable] -= 1;
            slope.add(powers, &value.mul(&factor));
        }
        slope
    }

    /// Times a number that makes the coefficients whole, without a common divisor, and the first in the order of the variables positive.
    pub(crate) fn primitive(&self) -> Self {
        let Some((_, first)) = self.terms.last_key_value() else { return self.clone() };
        let size = self.terms.values().fold(Number::ZERO, |size, value| size.gcd(value));
        let size = if first.is_negative() { size.neg() } else { size };
        size.recip().map_or_else(|| self.clone(), |inverse| self.scaled(&inverse))
    }

    /// The powers that all terms have in common.
    pub(crate) fn common_powers(&self) -> Powers {
        let mut all = self.terms.keys();
        let first = all.next().cloned().unwrap_or_else(|| vec![0; self.variables]);
        all.fold(first, |common, powers| common.iter().zip(powers).map(|(a, b)| *a.min(b)).collect())
    }

    /// Without powers that all terms have.
    pub(crate) fn without(&self, common: &Powers) -> Self {
        let less = |powers: &Powers| powers.iter().zip(common).map(|(a, b)| a - b).collect();
        let terms = self.terms.iter().map(|(powers, value)| (less(powers), value.clone())).collect();
        Self { variables: self.variables, terms }
    }

    pub(crate) fn monomial(powers: Powers) -> Self {
        let mut own = Self::zero(powers.len());
        own.add(powers, &Number::ONE);
        own
    }

    /// A common divisor: the greatest, but for numbers, where the polynomials are not too long.
    pub(crate) fn common_divisor(&self, other: &Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return if self.is_zero() { other.primitive() } else { self.primitive() };
        }
        let (own, others) = (self.common_powers(), other.common_powers());
        let common = Self::monomial(own.iter().zip(&others).map(|(a, b)| *a.min(b)).collect());
        let (mut a, mut b) = (self.without(&own), other.without(&others));
        if a.terms.len().max(b.terms.len()) > MOST_TERMS {
            return common;
        }
        let shared = |a: &Self, b: &Self| {
            let both = (0..self.variables).filter(|x| a.degree(*x) > 0 && b.degree(*x) > 0);
            both.filter(|x| !a.is_prime_to(b, *x)).min_by_key(|x| a.degree(*x).max(b.degree(*x)))
        };
        if shared(&a, &b).is_none() {
            return common;
        }
        // What only one of them knows is in no common divisor.
        for variable in 0..self.variables {
            let (of_a, of_b) = (a.degree(variable), b.degree(variable));
            if of_a > 0 && of_b == 0 {
                a = a.content(variable);
            } else if of_b > 0 && of_a == 0 {
                b = b.content(variable);
            }
        }
        let Some(variable) = shared(&a, &b) else { return common };
        let (of_a, of_b) = (a.content(variable), b.content(variable));
        let contents = common.times(&of_a.common_divisor(&of_b));
        let (Some(a), Some(b)) = (a.over(&of_a), b.over(&of_b)) else { return contents };
        contents.times(&a.divisor_in(b, variable)).primitive()
    }

    /// Whether they have no divisor with this variable in common, as values at random for the others show modulo a prime.
    pub(crate) fn is_prime_to(&self, other: &Self, variable: usize) -> bool {
        let (Some(mut a), Some(mut b)) = (self.residues(variable, 0), other.residues(variable, 0)) else {
            return false;
        };
        while let Some(last) = b.last().copied() {
            let Some(inverse) = inverse_mod(last) else { return false };
            if b.len() == 1 {
                return true;
            }
            while a.len() >= b.len() {
                let factor = neg_mod(mul_mod(a[a.len() - 1], inverse));
                let shift = a.len() - b.len();
                for (at, value) in b.iter().enumerate() {
                    a[at + shift] = add_mod(a[at + shift], mul_mod(factor, *value));
                }
                a.pop();
            }
            while a.last() == Some(&0) {
                a.pop();
            }
            std::mem::swap(&mut a, &mut b);
        }
        false
    }

    /// The coefficients of one variable at a point of random values of the others, modulo a prime; `None` where the last is 0.
    pub(crate) fn residues(&self, variable: usize, point: u64) -> Option<Vec<u64>> {
        let mut all = vec![0; self.degree(variable) as usize + 1];
        for (powers, value) in &self.terms {
            let others = powers.iter().enumerate().filter(|(at, _)| *at != variable);
            let product = others.fold(value.mod_prime(PRIME)?, |product, (at, power)| {
                mul_mod(product, pow_mod(mix((point << 32) + at as u64 + 1) >> 8, u64::from(*power)))
            });
            let place = &mut all[powers[variable] as usize];
            *place = add_mod(*place, product);
        }
        (all.last() != Some(&0)).then_some(all)
    }

    /// The divisor of polynomials whose coefficients in a variable have none: the last remainder.
    fn divisor_in(&self, other: Self, variable: usize) -> Self {
        let one = Self::constant(self.variables, Number::ONE);
        let (mut a, mut b) = (self.clone(), other);
        if a.degree(variable) < b.degree(variable) {
            std::mem::swap(&mut a, &mut b);
        }
        while b.degree(variable) > 0 {
            let Some(rest) = a.remainder(&b, variable) else { return one };
            if rest.is_zero() {
                return b;
            }
            let content = rest.content(variable);
            let Some(rest) = rest.over(&content) else { return one };
            // Without it numbers would double in length at each step.
            (a, b) = (b, rest.primitive());
        }
        one
    }

    /// What is left of a power of the leading coefficient of `divisor` times this; `None` where that takes long.
    fn remainder(&self, divisor: &Self, variable: usize) -> Option<Self> {
        let degree = divisor.degree(variable);
        let of_divisor = divisor.coefficients(variable);
        let mut rest = self.clone();
        let by = of_divisor.last()?;
        while !rest.is_zero() && rest.degree(variable) >= degree {
            let own = rest.degree(variable);
            let leading = rest.coefficients(variable).pop()?;
            if divisor.is_long_with(&leading) || rest.is_long_with(by) {
                return None;
            }
            let mut power = vec![0; self.variables];
            power[variable] = own - degree;
            let less = divisor.times(&leading).times(&Self::monomial(power));
            rest = rest.times(by).minus(&less);
        }
        (rest.terms.len() <= MOST_TERMS).then_some(rest)
    }

    /// The common divisor of what stands before the powers of a variable.
    pub(crate) fn content(&self, variable: usize) -> Self {
        let mut coefficients = self.coefficients(variable);
        coefficients.order_by_key(|own| own.terms.len());
        let content = coefficients.into_iter().fold(Self::zero(self.variables), |common, own| {
            if common.is_constant() && !common.is_zero() { common } else { common.common_divisor(&own) }
        });
        content.primitive()
    }

    /// Factors in which no zero of a variable is repeated, each with how often it occurs (Yun). What stands before its powers has no
    /// common divisor.
    pub(crate) fn factors(&self, variable: usize) -> Vec<(Self, usize)> {
        let slope = self.derivative(variable);
        if self.is_prime_to(&slope, variable) {
            return vec![(self.primitive(), 1)];
        }
        let repeated = self.common_divisor(&slope);
        let (Some(mut each), mut repeated) = (self.over(&repeated), repeated) else { return vec![(self.clone(), 1)] };
        let mut factors = Vec::new();
        let mut times = 1;
        while each.degree(variable) > 0 {
            let more = each.common_divisor(&repeated);
            if let Some(own) = each.over(&more)
                && own.degree(variable) > 0
            {
                factors.push((own.primitive(), times));
            }
            repeated = repeated.over(&more).unwrap_or(repeated);
            if more.degree(variable) == each.degree(variable) && times > self.degree(variable) as usize {
                break;
            }
            each = more;
            times += 1;
        }
        factors
    }
}

impl Polynomial {
    /// The resultant of two polynomials in the square of a variable, Sylvester's determinant: 0 where they have a zero in common.
    pub(crate) fn resultant_of_even(&self, other: &Self, variable: usize) -> Option<Self> {
        let sides = [self, other].map(|own| own.coefficients(variable).into_iter().step_by(2).collect::<Vec<Self>>());
        let size = sides[0].len() + sides[1].len() - 2;
        let rows = |own: &[Self], count: usize| -> Vec<Vec<Self>> {
            let entry = |row: usize, at: usize| at.checked_sub(row).and_then(|at| own.get(at)).cloned();
            let zero = || Self::zero(self.variables);
            (0..count).map(|row| (0..size).map(|at| entry(row, at).unwrap_or_else(zero)).collect()).collect()
        };
        determinant([rows(&sides[0], sides[1].len() - 1), rows(&sides[1], sides[0].len() - 1)].concat())
    }
}

/// The determinant of a matrix, row by row, without fractions (Bareiss, Mathematics of Computation 22, 1968); `None` where the entries
/// on the way get too long.
pub(crate) fn determinant(mut rows: Vec<Vec<Polynomial>>) -> Option<Polynomial> {
    let n = rows.len();
    let variables = rows.first()?.first()?.variables;
    let mut before = Polynomial::constant(variables, Number::ONE);
    let mut turned = false;
    for step in 0..n {
        // Short pivots keep what follows short.
        let candidates = (step..n).filter(|i| !rows[*i][step].is_zero());
        let Some(pivot) = candidates.min_by_key(|i| rows[*i][step].terms.len()) else {
            return Some(Polynomial::zero(variables));
        };
        rows.swap(step, pivot);
        turned ^= pivot != step;
        let (done, left) = rows.split_at_mut(step + 1);
        let own = done.last()?;
        // The longest first: where one gets too long, the others need no work.
        let mut left: Vec<_> = left.iter_mut().collect();
        left.order_by_key(|row| std::cmp::Reverse(row[step].terms.len()));
        for row in left {
            let share = std::mem::replace(&mut row[step], Polynomial::zero(variables));
            for (entry, other) in row.iter_mut().zip(own).skip(step + 1) {
                if entry.is_long_with(&own[step]) || share.is_long_with(other) {
                    return None;
                }
                let mut whole = entry.times(&own[step]);
                share.terms.iter().for_each(|(powers, value)| whole.add_multiple(other, powers, &value.neg()));
                *entry = whole.over(&before)?;
                if entry.terms.len() > MOST_TERMS {
                    return None;
                }
            }
        }
        before = own[step].clone();
    }
    Some(if turned { before.scaled(&Number::MINUS_ONE) } else { before })
}
