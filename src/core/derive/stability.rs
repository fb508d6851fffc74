//! Conditions of stability, as polynomials that have to be positive.
//!
//! With friction the criterion of Routh and Hurwitz in the form of Liénard and Chipart (Gantmacher, The Theory of Matrices,
//! vol. 2, chapter XV, section 13): every second coefficient and every second determinant. Without, the squares of the exponents
//! have to be negative and different: signs of coefficients and the discriminant. What follows from the signs that are known, that
//! of M above all, and from other conditions, is left out.

use super::characteristic::Factor;
use super::ring::{EXPONENT, Expanded, Ring};
use crate::expr::{ExprId, Function, Pool, evaluate_closed};
use crate::number::Number;
use crate::order::{Gather, Order};
use crate::polynomial::{Polynomial, determinant};
use crate::precision::{Ball, Scalar};

/// Longer conditions are given in the coefficients, if at all.
const MOST_TERMS: usize = 60;
/// Discriminants of cubics with longer coefficients are not multiplied out.
const MOST_OF_A_CUBIC: usize = 20;
/// Longer ones in the coefficients help nobody.
const MOST_PRODUCTS: usize = 100;

/// What is known to be positive.
#[derive(Clone, Debug)]
pub(super) struct Signs {
    pub(super) variables: Vec<bool>,
    /// Which are never above 1 nor below -1.
    bounded: Vec<bool>,
    /// The numbers that variables without symbols stand for.
    values: Vec<Option<Ball>>,
    others: Vec<Polynomial>,
}

/// A product that has to be positive: factors that are no products themselves, and whether its sign is turned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Sign {
    pub(super) factors: Vec<Polynomial>,
    pub(super) negative: bool,
}

impl Sign {
    /// The product.
    pub(super) fn product(&self, variables: usize) -> Polynomial {
        let sign = if self.negative { Number::MINUS_ONE } else { Number::ONE };
        let one = Polynomial::constant(variables, sign);
        self.factors.iter().fold(one, |product, own| product.times(own))
    }

    /// Whether it is positive whatever the parameters are.
    pub(super) fn holds_always(&self) -> bool {
        self.factors.is_empty() && !self.negative
    }

    fn terms(&self) -> usize {
        self.factors.iter().map(|own| own.terms().count()).sum()
    }
}

impl Signs {
    /// Roots, what is a square or the like, and what else is known to be positive; but not what is assumed to be positive or 0.
    pub(super) fn new(pool: &Pool, ring: &Ring, (known, weak): &(Vec<Expanded>, Vec<ExprId>)) -> Self {
        let is_positive = |base| pool.is_nonnegative(base) && !weak.contains(&base);
        let positive = |at| ring.base(at).is_some_and(|(base, is_root)| is_root || is_positive(base));
        let function = |at| pool.as_function(ring.base(at)?.0);
        let is_bounded = |at| matches!(function(at), Some((Function::Sin | Function::Cos | Function::Tanh, _)));
        let value = |at| {
            let (base, step) = ring.power(at).filter(|(base, _)| pool.is_constant(*base))?;
            Some(evaluate_closed::<Ball>(pool, base, ())?.pow(&Ball::from_number(step, ())))
        };
        let mut own = Self {
            variables: (0..ring.variables()).map(positive).collect(),
            bounded: (0..ring.variables()).map(is_bounded).collect(),
            values: (0..ring.variables()).map(value).collect(),
            others: Vec::new(),
        };
        // What is known of one may tell the sign of another.
        for _ in 0..2 {
            for expanded in known {
                for polynomial in ring.of_signs(expanded).into_iter().flatten() {
                    own.learn(&own.sign(&polynomial));
                }
            }
        }
        own
    }

    /// Takes in that a product is positive.
    pub(super) fn learn(&mut self, sign: &Sign) {
        let [only] = sign.factors.as_slice() else { return };
        if sign.negative {
            self.others.push(only.scaled(&Number::MINUS_ONE));
            return;
        }
        if let Some((powers, _)) = only.terms().only()
            && let Some(at) = powers.iter().position(|power| *power > 0)
        {
            self.variables[at] = true;
        } else {
            self.others.push(only.clone());
        }
    }

    /// The sign of a polynomial that is what is known to be positive, or more than a part of it.
    fn of_known(&self, polynomial: &Polynomial) -> Option<bool> {
        self.of_terms(polynomial).or_else(|| {
            let follows = |own: &Polynomial| self.others.iter().any(|other| follows(own, other, self));
            let opposite = polynomial.scaled(&Number::MINUS_ONE);
            if follows(polynomial) { Some(false) } else { follows(&opposite).then_some(true) }
        })
    }

    /// The sign that all terms have, as far as that is known.
    pub(super) fn of_terms(&self, polynomial: &Polynomial) -> Option<bool> {
        if self.others.contains(polynomial) {
            return Some(false);
        }
        if let Some(negative) = self.of_number(polynomial) {
            return Some(negative);
        }
        let opposite = polynomial.scaled(&Number::MINUS_ONE);
        [polynomial, &opposite].into_iter().position(|own| self.exceeds_squares(own)).map(|at| at == 1)
    }

    /// The sign of a polynomial that is a number.
    fn of_number(&self, polynomial: &Polynomial) -> Option<bool> {
        let term = |(powers, value): (&Vec<u32>, &Number)| {
            let mut powers = powers.iter().zip(&self.values).filter(|(power, _)| **power > 0);
            powers.try_fold(Ball::from_number(value, ()), |product, (power, base)| {
                Some(product.mul(&base.as_ref()?.powi(i32::try_from(*power).ok()?)))
            })
        };
        let sum = polynomial.terms().try_fold(Ball::ZERO, |sum, own| Some(sum.add(&term(own)?)))?;
        if sum.is_positive() { Some(false) } else { sum.is_negative().then_some(true) }
    }

    /// Whether the terms of a sum that are positive are more than all others: each of these is twice that of a square
    /// a p² - 2 √(a b) p q + b q² whose other terms are there, or less for a sine in it, and something is left.
    fn exceeds_squares(&self, of: &Polynomial) -> bool {
        let is_positive = |own: &(&Vec<u32>, Number)| !own.1.is_negative() && self.is_positive(own.0);
        let (mut left, others): (Vec<_>, Vec<_>) =
            of.terms().map(|(powers, value)| (powers, value.clone())).partition(is_positive);
        if others.len().max(left.len()) > MOST_TERMS {
            return others.is_empty();
        }
        let mut is_less = false;
        for (middle, value) in others {
            let quarter = value.mul(&value).mul(&Number::half()).mul(&Number::half());
            let found = (0..left.len()).flat_map(|i| (0..=i).map(move |j| (i, j))).find_map(|(i, j)| {
                let ((a, x), (b, y)) = (&left[i], &left[j]);
                let mut powers =
                    middle.iter().zip(a.iter().zip(*b)).map(|(own, (a, b))| (2 * own, a + b)).zip(&self.bounded);
                let mut bounded = false;
                let reaches = powers.all(|((own, both), is_bounded)| {
                    bounded |= own > both;
                    own == both || *is_bounded && own > both
                });
                let needed = if i == j { value.abs() } else { quarter.div(y)? };
                (reaches && needed <= *x).then(|| (i, j, x.sub(&needed), bounded))
            });
            let Some((i, j, rest, bounded)) = found else { return false };
            is_less |= bounded;
            left[i].1 = rest;
            if i != j {
                left.remove(j);
            }
            left.retain(|(_, value)| !value.is_zero());
        }
        is_less || !left.is_empty()
    }

    /// Whether a product of powers is positive.
    fn is_positive(&self, powers: &[u32]) -> bool {
        powers.iter().zip(&self.variables).all(|(power, known)| *known || power % 2 == 0)
    }

    /// Whether a polynomial is 0 for special values, though its sign says nothing of it: squares count as positive there.
    pub(super) fn may_vanish(&self, polynomial: &Polynomial) -> bool {
        let is_sure = |powers: &[u32]| powers.iter().zip(&self.variables).all(|(power, known)| *known || *power == 0);
        let is_alike = |own: &Polynomial| {
            let negative = own.terms().filter(|(_, value)| value.is_negative()).count();
            negative == 0 || negative == own.terms().count()
        };
        let is_weak = |own: &Polynomial| {
            !(self.others.contains(own) || is_alike(own) && own.terms().any(|(powers, _)| is_sure(powers)))
        };
        if polynomial.is_zero() || self.of_number(polynomial).is_some() {
            return polynomial.is_zero();
        }
        if self.of_terms(polynomial).is_some() {
            return is_weak(polynomial);
        }
        self.factors(polynomial).1.iter().any(|(factor, times)| match self.of_terms(factor) {
            Some(_) => is_weak(factor),
            None => times % 2 == 0 && self.of_known(factor).is_none(),
        })
    }

    /// Whether conditions tell of special values, too, where they hold always, or one of them never.
    pub(super) fn are_settled(&self, conditions: &[Polynomial]) -> bool {
        let fails = |own: &Polynomial| {
            let sign = self.sign(own);
            sign.negative && sign.factors.is_empty() && !self.may_vanish(own)
        };
        conditions.iter().any(fails) || !conditions.iter().any(|own| self.may_vanish(own))
    }

    /// What the sign of a polynomial depends on.
    pub(super) fn sign(&self, polynomial: &Polynomial) -> Sign {
        // What is 0 is never positive.
        let mut sign = Sign { factors: Vec::new(), negative: polynomial.is_zero() };
        if polynomial.is_zero() {
            return sign;
        }
        if let Some(negative) = self.of_terms(polynomial) {
            return Sign { negative, ..sign };
        }
        let (negative, factors) = self.factors(polynomial);
        sign.negative = negative;
        for (factor, _) in factors.into_iter().filter(|(_, times)| times % 2 == 1) {
            match self.of_known(&factor) {
                Some(negative) => sign.negative ^= negative,
                None => sign.factors.push(factor),
            }
        }
        sign
    }

    /// The product of the factors of a polynomial that may vanish, each once: of all, or of those that it has the squares of.
    pub(super) fn open(&self, polynomial: &Polynomial, squares: bool) -> Polynomial {
        let one = Polynomial::constant(self.variables.len(), Number::ONE);
        if polynomial.is_zero() {
            return one;
        }
        let (_, factors) = self.factors(polynomial);
        let open = factors.iter().filter(|(own, times)| (!squares || times % 2 == 0) && self.of_known(own).is_none());
        open.fold(one, |product, (own, _)| product.times(own))
    }

    /// Whether a polynomial has a number below 0 before its factors, and these with how often each is there, without variables and sums
    /// that are known to be positive.
    fn factors(&self, polynomial: &Polynomial) -> (bool, Vec<(Polynomial, usize)>) {
        let common = polynomial.common_powers();
        let variables = common.len();
        let open = common.iter().enumerate().filter(|(at, power)| !self.variables[*at] && **power > 0);
        let mut found: Vec<(Polynomial, usize)> =
            open.map(|(at, power)| (Polynomial::variable(variables, at), *power as usize)).collect();
        let mut rest = polynomial.without(&common);
        // What is known to be positive is no factor that matters.
        for known in self.others.iter().filter(|own| own.terms().count() > 1) {
            while let Some(less) = rest.over(known) {
                rest = less;
            }
        }
        // All factors are taken with their first coefficient positive.
        let negative = rest.is_negative();
        found.extend(rest.factored());
        (negative, found)
    }
}

/// What has to be positive for the exponents of a factor to be on the left, or of an even one on the imaginary axis and single; `None`
/// where that is not written out.
/// Exponents of factors that occur several times have vectors enough where motions are `bounded`.
pub(super) fn conditions(
    factor: &Factor,
    ring: &Ring,
    signs: &Signs,
    [conservative, bounded]: [bool; 2],
) -> Option<Vec<Polynomial>> {
    let coefficients = coefficients(factor, signs, bounded)?;
    let mut found = needed(&coefficients, factor.is_even(), conservative)?;
    for own in &mut found {
        let is_zero = own.is_zero();
        *own = ring.reduced(std::mem::replace(own, Polynomial::zero(ring.variables())));
        // Two of the exponents are equal or opposite, whatever the parameters are, as roots of numbers show.
        if own.is_zero() && !is_zero {
            return None;
        }
    }
    found.iter().all(|own| own.terms().count() <= MOST_TERMS).then_some(found)
}

/// An even factor a s⁴ + b s² + c with 4 a c = n q², where n is no square of a rational number: b > √n |q| then stands for b > 0 and b² > 4 a c.
pub(super) struct BesideRoot {
    /// c.
    pub(super) constant: Polynomial,
    /// b, without positive factors that q has, too.
    pub(super) middle: Polynomial,
    /// n.
    pub(super) number: Number,
    /// q, without these factors.
    pub(super) base: Polynomial,
}

impl BesideRoot {
    pub(super) fn of(factor: &Factor, ring: &Ring, signs: &Signs, [conservative, bounded]: [bool; 2]) -> Option<Self> {
        let [constant, middle, leading] = coefficients(factor, signs, bounded)?.try_into().ok()?;
        let product = ring.reduced(leading.times(&constant).scaled(&Number::from(4)));
        let powers: Vec<u32> = product.common_powers().iter().map(|power| power / 2).collect();
        let mut base = Polynomial::monomial(powers);
        for (own, times) in product.without(&product.common_powers()).factored() {
            base = (0..times / 2).fold(base, |product, _| product.times(&own));
        }
        let number = product.over(&base.times(&base))?;
        let (_, number) = number.terms().only().filter(|_| number.is_constant())?;
        if conservative || !factor.is_even() || number.is_negative() || number.sqrt_exact().is_some() {
            return None;
        }
        // What both have in common says nothing where it is positive.
        let common = middle.common_divisor(&base);
        let less = (middle.over(&common), base.over(&common));
        let (middle, base) = match less {
            (Some(middle), Some(base)) if signs.sign(&common).holds_always() => (middle, base),
            _ => (middle, base),
        };
        Some(Self { constant, middle, number: number.clone(), base })
    }
}

/// The same as polynomials in the coefficients of the factor, which come with them; those that hold always are left out.
pub(super) fn conditions_in_coefficients(
    factor: &Factor,
    signs: &Signs,
    [conservative, bounded]: [bool; 2],
) -> Option<(Vec<Polynomial>, Vec<Polynomial>)> {
    let coefficients = coefficients(factor, signs, bounded)?;
    let count = coefficients.len();
    let variables: Vec<Polynomial> = (0..count).map(|at| Polynomial::variable(count, at)).collect();
    let mut found = needed(&variables, factor.is_even(), conservative)?;
    let positive: Vec<bool> = coefficients.iter().map(|own| signs.sign(own).holds_always()).collect();
    let holds = |powers: &[u32]| powers.iter().zip(&positive).all(|(power, positive)| *power == 0 || *positive);
    found.retain(|own| !own.terms().all(|(powers, factor)| !factor.is_negative() && holds(powers)));
    let short = found.iter().all(|own| own.terms().count() <= MOST_PRODUCTS);
    short.then_some((coefficients, found))
}

/// The coefficients of a factor, the leading one positive; of an even one those of its powers of s².
fn coefficients(factor: &Factor, signs: &Signs, bounded: bool) -> Option<Vec<Polynomial>> {
    let even = factor.is_even();
    if even && factor.repeated > 1 && !bounded {
        return None;
    }
    let mut coefficients = factor.polynomial.coefficients(EXPONENT);
    if even {
        coefficients = coefficients.into_iter().step_by(2).collect();
    }
    let sign = signs.sign(coefficients.last()?).product(signs.variables.len());
    Some(coefficients.iter().map(|own| own.times(&sign)).collect())
}

fn needed(coefficients: &[Polynomial], even: bool, conservative: bool) -> Option<Vec<Polynomial>> {
    if even { of_squares(coefficients, conservative) } else { hurwitz(coefficients) }
}

/// That the zeros z are negative, and different where nothing else keeps them real.
fn of_squares(coefficients: &[Polynomial], conservative: bool) -> Option<Vec<Polynomial>> {
    let (_, others) = coefficients.split_last()?;
    let mut found = others.to_vec();
    if conservative {
        return Some(found);
    }
    let scaled = |of: &Polynomial, factor: i64| of.scaled(&Number::from(factor));
    match coefficients {
        [_, _] => {}
        [c, b, a] => found.push(b.times(b).plus(&scaled(&a.times(c), -4))),
        // Four coefficients are multiplied in each term.
        [d, c, b, a] if coefficients.iter().all(|own| own.terms().count() <= MOST_OF_A_CUBIC) => {
            let mut discriminant = scaled(&a.times(b).times(&c.times(d)), 18);
            discriminant = discriminant.plus(&scaled(&b.times(b).times(b).times(d), -4));
            discriminant = discriminant.plus(&b.times(b).times(&c.times(c)));
            discriminant = discriminant.plus(&scaled(&a.times(c).times(c).times(c), -4));
            found.push(discriminant.plus(&scaled(&a.times(a).times(&d.times(d)), -27)));
        }
        [_, _, _, _] => return None,
        // With p(z) also p(s²) + s p'(s²) has its zeros on the left (Hermite and Biehler; Gantmacher, section 14).
        _ => {
            let derivative = coefficients.iter().zip(0_i64..).map(|(own, power)| scaled(own, power));
            let pairs = derivative.zip(coefficients).flat_map(|(slope, own)| [slope, own.clone()]);
            return hurwitz(&pairs.skip(1).collect::<Vec<_>>());
        }
    }
    Some(found)
}

/// Liénard's and Chipart's choice; the leading coefficient is positive.
fn hurwitz(coefficients: &[Polynomial]) -> Option<Vec<Polynomial>> {
    let degree = coefficients.len() - 1;
    let (first, _) = coefficients.split_first()?;
    let zero = first.scaled(&Number::ZERO);
    // Row i, column j of Hurwitz's matrix: the coefficient number 2 j - i from the leading one, both from 1.
    let entry = |i: usize, j: usize| {
        let number = (2 * j).checked_sub(i).filter(|number| *number <= degree);
        number.map_or_else(|| zero.clone(), |number| coefficients[degree - number].clone())
    };
    let minor = |size: usize| determinant((1..=size).map(|i| (1..=size).map(|j| entry(i, j)).collect()).collect());
    let mut found = vec![first.clone()];
    let minors = (1..degree).rev().step_by(2).filter(|size| *size > 1).map(minor).collect::<Option<Vec<_>>>()?;
    // Opposite exponents, whatever the parameters are: they may be imaginary.
    if minors.iter().any(Polynomial::is_zero) {
        return None;
    }
    // a_0, a_1, a_3, … or a_0, a_2, a_4, …, whichever is shorter.
    let others = |first: usize| -> Vec<Polynomial> {
        let own = (first..degree).step_by(2).map(|at| coefficients[at].clone());
        // Hurwitz's first determinant is a coefficient, too.
        let more =
            (degree.is_multiple_of(2) && (degree - 1) % 2 != first % 2).then(|| coefficients[degree - 1].clone());
        own.chain(more).collect()
    };
    let terms = |all: &[Polynomial]| all.iter().map(|own| own.terms().count()).sum::<usize>();
    let (odd, even) = (others(1), others(2));
    let shorter = if terms(&odd) <= terms(&even) { odd } else { even };
    found.extend(shorter);
    found.extend(minors);
    Some(found)
}

/// Conditions without those that the others, and what is known, imply: shorter ones first.
pub(super) fn essential(all: &[Polynomial], signs: &Signs) -> Vec<Sign> {
    let mut open: Vec<Sign> = all.iter().map(|own| signs.sign(own)).collect();
    open.order_by_key(Sign::terms);
    let mut known = signs.clone();
    let mut kept: Vec<Sign> = Vec::new();
    for own in open {
        let mut again = known.sign(&own.product(known.variables.len()));
        // What is positive as a product is no factor that matters.
        for other in kept.iter().filter(|other| other.factors.len() > 1) {
            if other.factors.iter().all(|factor| again.factors.contains(factor)) {
                again.factors.retain(|factor| !other.factors.contains(factor));
                again.negative ^= other.negative;
            }
        }
        if again.holds_always() || kept.contains(&again) {
            continue;
        }
        known.learn(&again);
        kept.push(again);
    }
    let mut at = 0;
    while at < kept.len() {
        let own = kept.remove(at);
        let mut known = signs.clone();
        kept.iter().for_each(|other| known.learn(other));
        let others = kept.iter().map(|other| other.product(known.variables.len()));
        let product = own.product(known.variables.len());
        if !others.into_iter().any(|other| follows(&product, &other, &known)) {
            kept.insert(at, own);
            at += 1;
        }
    }
    kept
}

/// Whether one is positive where another is: times what is known to be positive it is more than a part of that.
fn follows(own: &Polynomial, other: &Polynomial, known: &Signs) -> bool {
    // Each positive term of the other has its counterpart.
    let positive = |of: &Polynomial| of.terms().filter(|(_, value)| !value.is_negative()).count();
    if positive(other) > positive(own) {
        return false;
    }
    let mut pairs = other.terms().flat_map(|(of_other, whole)| own.terms().map(move |one| (of_other, whole, one)));
    pairs.any(|(of_other, whole, (powers, value))| {
        if value.is_negative() != whole.is_negative() {
            return false;
        }
        let more: Option<Vec<u32>> = of_other.iter().zip(powers).map(|(a, b)| a.checked_sub(*b)).collect();
        let (Some(share), Some(more)) = (value.div(whole), more.filter(|more| known.is_positive(more))) else {
            return false;
        };
        let rest = own.times(&Polynomial::monomial(more)).plus(&other.scaled(&share.neg()));
        rest.is_zero() || known.of_terms(&rest) == Some(false)
    })
}
