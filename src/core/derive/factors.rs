//! Factors over the rational numbers that are linear in one of the variables, parameters included, as nearly all are that physics
//! has: m s² + c s + k is linear in k; and factors of second degree in the exponent or its square.
//!
//! With numbers for all variables but one, rational zeros are whole ones of a polynomial with leading coefficient 1. From such a
//! zero its dependence on the other variables follows power by power (Newton and Hensel; Geddes, Czapor and Labahn, Algorithms for
//! Computer Algebra, chapter 6). What comes out is a factor if the division leaves nothing; what does not is none.

use super::ring::EXPONENT;
use crate::number::Number;
use crate::order::{Gather, Order};
use crate::polynomial::Polynomial;

/// Values at which a factor is searched for, one a variable.
const POINTS: [i64; 14] = [7, 3, 11, 5, 17, 13, 23, 19, 31, 29, 41, 37, 47, 43];
/// Whole zeros are searched for modulo each of these.
const PRIMES: [u64; 3] = [251, 241, 239];
/// Polynomials with more terms are left as they are.
const MOST_TERMS: usize = 400;
/// As are those of a higher degree in the exponent.
const MOST_DEGREE: u32 = 24;
/// Factors of second degree are not searched for beyond this one.
const MOST_DEGREE_OF_PAIRS: u32 = 8;

impl Polynomial {
    /// The factors that are found, without common powers of variables and numbers, each with how often it occurs.
    pub(super) fn factored(&self) -> Vec<(Self, usize)> {
        let (mut found, mut rest) = (Vec::new(), self.clone());
        while let Some(variable) = (0..rest.variables()).find(|at| rest.degree(*at) > 0) {
            let content = rest.content(variable);
            let Some(own) = rest.over(&content) else {
                found.push((rest.primitive(), 1));
                break;
            };
            found.extend(own.split_factors(variable));
            rest = content;
        }
        found
    }

    /// Factors in which no zero of a variable is repeated, each in those that are found, with how often it occurs.
    pub(super) fn split_factors(&self, variable: usize) -> impl Iterator<Item = (Self, usize)> {
        let all = self.factors(variable).into_iter();
        all.flat_map(|(own, times)| own.split().into_iter().map(move |own| (own, times)))
    }

    /// Factors, as far as they are found, of a polynomial without repeated ones; short ones in the exponent first.
    pub(super) fn split(&self) -> Vec<Self> {
        let mut open = vec![self.primitive()];
        let mut found: Vec<Self> = Vec::new();
        while let Some(own) = open.pop() {
            match own.divisor().and_then(|part| Some([own.over(&part)?, part])) {
                Some(parts) => open.extend(parts.map(|part| part.primitive())),
                None => found.push(own),
            }
        }
        found.order_by_key(|own| (own.degree(EXPONENT), own.terms().count()));
        found
    }

    /// A factor that is neither a number nor all of it.
    fn divisor(&self) -> Option<Self> {
        if self.terms().count() > MOST_TERMS || self.degree(EXPONENT) > MOST_DEGREE {
            return None;
        }
        let mut variables: Vec<usize> = (0..self.variables()).filter(|at| self.degree(*at) > 0).collect();
        variables.order_by_key(|at| self.degree(*at));
        for at in &variables {
            let content = self.content(*at);
            if !content.is_constant() {
                return Some(content);
            }
            // What is linear in a variable and has nothing before all of its powers is no product.
            if self.degree(*at) == 1 {
                return None;
            }
        }
        let even = self.with_powers(EXPONENT, |power| power.is_multiple_of(2).then_some(power / 2));
        let of_squares =
            |of: &dyn Fn(&Self) -> Option<Self>| of(even.as_ref()?)?.with_powers(EXPONENT, |power| Some(2 * power));
        let linear = |own: &Self| own.linear_factor(EXPONENT);
        let quadratic = |own: &Self| own.quadratic_factor(EXPONENT);
        let found = variables.iter().find_map(|at| self.linear_factor(*at)).or_else(|| of_squares(&linear));
        found.or_else(|| of_squares(&quadratic)).or_else(|| quadratic(self))
    }

    /// A factor that is linear in a variable.
    fn linear_factor(&self, variable: usize) -> Option<Self> {
        if self.degree(variable) < 2 {
            return None;
        }
        let zeros = self.zeros_of(variable, &|own| own.monic(variable))?;
        let leading = self.coefficients(variable).pop()?;
        let y = Self::variable(self.variables(), variable);
        zeros.into_iter().find_map(|zero| {
            let factor = leading.times(&y).minus(&zero);
            let factor = factor.over(&factor.content(variable))?;
            self.over(&factor).map(|_| factor)
        })
    }

    /// A factor of second degree in a variable x: that with the zeros y and y' divides both p(x) and p(y + y' - x).
    fn quadratic_factor(&self, variable: usize) -> Option<Self> {
        if !(4..=MOST_DEGREE_OF_PAIRS).contains(&self.degree(variable)) {
            return None;
        }
        let sums = self.zeros_of(variable, &|own| own.monic(variable)?.sums_of_pairs(variable))?;
        let (monic, leading) = (self.monic(variable)?, self.coefficients(variable).pop()?);
        let y = Self::variable(self.variables(), variable);
        sums.into_iter().find_map(|sum| {
            let factor = monic.common_divisor(&monic.put(variable, &sum.minus(&y)));
            let factor = factor.put(variable, &leading.times(&y));
            let factor = factor.over(&factor.content(variable))?;
            self.over(&factor).filter(|_| factor.degree(variable) == 2).map(|_| factor)
        })
    }

    /// Zeros that are polynomials in the other variables, of a polynomial with leading coefficient 1 that is made of this one.
    fn zeros_of(&self, variable: usize, of: &dyn Fn(&Self) -> Option<Self>) -> Option<Vec<Self>> {
        let others: Vec<usize> = (0..self.variables()).filter(|at| *at != variable && self.degree(*at) > 0).collect();
        if others.len() > POINTS.len() {
            return None;
        }
        let number = |value: i64| Self::constant(self.variables(), Number::from(value));
        let points: Vec<(usize, Self)> = others.into_iter().zip(POINTS.map(number)).collect();
        // There is none, as far as most polynomials go.
        let at_points = points.iter().fold(self.clone(), |own, (at, value)| own.put(*at, value));
        if at_points.degree(variable) < self.degree(variable) || whole_zeros(&of(&at_points)?, variable).is_empty() {
            return None;
        }
        // With numbers for the last variables, one less each.
        let mut stages = vec![of(self)?];
        for (at, value) in points.iter().rev() {
            let next = stages.last()?.put(*at, value);
            stages.push(next);
        }
        let zeros = whole_zeros(&stages.pop()?, variable).into_iter().filter_map(|zero| {
            let (zero, mut steps) = (Self::constant(self.variables(), zero), stages.iter().rev().zip(&points));
            steps.try_fold(zero, |zero, (stage, (at, value))| stage.lifted(zero, variable, *at, value))
        });
        Some(zeros.collect())
    }

    /// The polynomial whose zeros are the sums of two zeros each of one with leading coefficient 1, by sums of powers (Newton's identities).
    fn sums_of_pairs(&self, variable: usize) -> Option<Self> {
        let constant = |value: i64| Self::constant(self.variables(), Number::from(value));
        let mut coefficients = self.coefficients(variable);
        coefficients.reverse();
        let n = coefficients.len() - 1;
        let count = n * (n - 1) / 2;
        let is_short = |own: &Self| own.terms().count() <= MOST_TERMS;
        let mut powers = vec![constant(n as i64)];
        for k in 1..=count {
            let own = coefficients.get(k).map_or_else(|| constant(0), |own| own.scaled(&Number::from(k as i64)));
            let known = (1..k.min(n + 1)).map(|j| coefficients[j].times(&powers[k - j]));
            let sum = known.fold(own, |sum, own| sum.plus(&own));
            powers.push(Some(constant(0).minus(&sum)).filter(is_short)?);
        }
        let (mut found, mut binomials) = (vec![constant(1)], vec![Number::ONE]);
        let mut sums: Vec<Self> = Vec::new();
        for k in 1..=count {
            binomials = (0..=k)
                .map(|j| match j {
                    0 => Number::ONE,
                    _ => binomials[j - 1].add(binomials.get(j).unwrap_or(&Number::ZERO)),
                })
                .collect();
            let all = (0..=k).map(|j| powers[j].times(&powers[k - j]).scaled(&binomials[j]));
            let twice = powers[k].scaled(&Number::from(2).powi(i32::try_from(k).ok()?)?);
            let sum = all.fold(constant(0), |sum, own| sum.plus(&own)).minus(&twice).scaled(&Number::half());
            sums.push(Some(sum).filter(is_short)?);
            let all = sums.iter().zip(found.iter().rev()).map(|(own, before)| own.times(before));
            let own = all.fold(constant(0), |sum, own| sum.plus(&own)).scaled(&Number::ratio(-1, k as i64)?);
            found.push(Some(own).filter(is_short)?);
        }
        found.reverse();
        Some(Self::from_coefficients(variable, &found))
    }

    /// With the zeros multiplied by the leading coefficient, which makes that 1 and all others whole.
    fn monic(&self, variable: usize) -> Option<Self> {
        let mut coefficients = self.coefficients(variable);
        let leading = coefficients.pop()?;
        let mut power = Self::constant(self.variables(), Number::ONE);
        let one = power.clone();
        for own in coefficients.iter_mut().rev() {
            if own.is_long_with(&power) || power.is_long_with(&leading) {
                return None;
            }
            *own = own.times(&power);
            power = power.times(&leading);
        }
        coefficients.push(one);
        Some(Self::from_coefficients(variable, &coefficients))
    }

    /// A simple zero as a polynomial in one more variable, which has a value in the zero that is known.
    fn lifted(&self, zero: Self, variable: usize, more: usize, value: &Self) -> Option<Self> {
        let x = Self::variable(self.variables(), more);
        let about = self.put(more, &x.clone().plus(value));
        let slope = about.derivative(variable).put(variable, &zero).coefficients(more).swap_remove(0);
        let mut zero = zero;
        // It divides the product of the others, the constant.
        for power in 1..=about.coefficients(variable).first()?.degree(more) + 1 {
            if about.terms().count() * zero.terms().count() > MOST_TERMS * MOST_TERMS {
                return None;
            }
            let rest = about.put(variable, &zero);
            if rest.is_zero() {
                return Some(zero.put(more, &x.minus(value)));
            }
            let change = rest.coefficients(more).into_iter().nth(power as usize)?.over(&slope)?;
            let mut powers = vec![0; self.variables()];
            powers[more] = power;
            zero = zero.minus(&change.times(&Self::monomial(powers)));
        }
        None
    }
}

/// The whole zeros that are not repeated of a polynomial in one variable with whole coefficients, of which the last is 1: zeros
/// modulo a small prime, followed to moduli beyond all zeros. One is missed only if it meets another one modulo each of the primes.
fn whole_zeros(of: &Polynomial, variable: usize) -> Vec<Number> {
    let coefficients = of.coefficients(variable).into_iter();
    let number = |own: Polynomial| own.terms().next().map_or(Number::ZERO, |(_, value)| value.clone());
    let own: Vec<Number> = coefficients.map(number).collect();
    // Twice the largest of their roots, each of the order of its distance from the last (Fujiwara).
    let digits = own.iter().rev().zip(0_usize..).skip(1).map(|(own, order)| own.bits().div_ceil(order));
    let bound = i32::try_from(digits.max().unwrap_or(0) + 1).ok().and_then(|bits| Number::from(2).powi(bits));
    let Some(bound) = bound else { return Vec::new() };
    let slope: Vec<Number> = own.iter().zip(0..).skip(1).map(|(own, power)| own.mul(&Number::from(power))).collect();
    let mut zeros = PRIMES.iter().flat_map(|prime| zeros_from(&own, &slope, *prime, &bound)).distinct();
    zeros.retain(|zero| value(&own, zero).is_zero());
    zeros
}

/// What whole zeros that are not repeated modulo a prime can be, up to a bound, by Newton's steps, each with twice the digits.
fn zeros_from(of: &[Number], slope: &[Number], prime: u64, bound: &Number) -> Vec<Number> {
    let small = |all: &[Number]| all.iter().map(|own| own.mod_prime(prime)).collect::<Option<Vec<u64>>>();
    let (Some(small_of), Some(small_slope)) = (small(of), small(slope)) else { return Vec::new() };
    let at = |all: &[u64], x: u64| all.iter().rev().fold(0, |sum, own| (sum * x + own) % prime);
    let rest = |of: &Number, modulus: &Number| of.rem_floor(modulus).unwrap_or(Number::ZERO);
    let simple = (0..prime).filter(|x| at(&small_of, *x) == 0).filter_map(|x| {
        let slope = at(&small_slope, x);
        Some((x, (1..prime).find(|inverse| slope * inverse % prime == 1)?))
    });
    let number = |small: u64| Number::from_integer(small.into());
    let followed = simple.map(|(zero, inverse)| {
        let (mut zero, mut inverse, mut modulus) = (number(zero), number(inverse), number(prime));
        let twice = bound.add(bound);
        while modulus <= twice {
            modulus = modulus.mul(&modulus);
            zero = rest(&zero.sub(&value(of, &zero).mul(&inverse)), &modulus);
            let product = value(slope, &zero).mul(&inverse);
            inverse = rest(&inverse.mul(&Number::from(2).sub(&product)), &modulus);
        }
        if zero.add(&zero) > modulus { zero.sub(&modulus) } else { zero }
    });
    followed.collect()
}

fn value(coefficients: &[Number], x: &Number) -> Number {
    coefficients.iter().rev().fold(Number::ZERO, |sum, own| sum.mul(x).add(own))
}
