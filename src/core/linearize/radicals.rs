//! Exact numbers on the way to the matrices: sums of rational multiples of positive roots of rational numbers.
//!
//! Positive roots of which no two have a rational ratio are linearly independent over the rational numbers (Besicovitch,
//! J. London Math. Soc. 15 (1940) 3; Mordell, Pacific J. Math. 3 (1953) 625), so that a sum of such is 0 only where all factors are.

use dashu_int::IBig;

use super::elimination::common_denominator;
use crate::number::Number;
use crate::precision::{Ball, Function, Root, Scalar, nth_root, power};

/// Sums of more roots than this are no such numbers.
const MOST_TERMS: usize = 16;

/// Nor are roots of a higher order.
const HIGHEST: u32 = 48;

/// A number that may be known exactly.
#[derive(Clone, Debug)]
pub(super) enum Exact {
    /// A sum of rational multiples of roots.
    Roots(Sum),
    /// A rational multiple of π, but 0: what angles are on the way to their functions.
    Turns(Number),
    /// Any other.
    Unknown,
}

impl From<Option<Sum>> for Exact {
    fn from(sum: Option<Sum>) -> Self {
        sum.map_or(Self::Unknown, Self::Roots)
    }
}

/// The first term is 0 only where the sum is; ratios of different roots are irrational.
#[derive(Clone, Debug)]
pub(super) struct Sum {
    first: Surd,
    others: Vec<Surd>,
}

/// factor·radicand^(1/index); the radicand is positive, and 1 with index 1 where the root is rational.
#[derive(Clone, Debug)]
pub(super) struct Surd {
    factor: Number,
    radicand: Number,
    index: u32,
}

impl Surd {
    pub(super) fn rational(factor: Number) -> Self {
        Self { factor, radicand: Number::ONE, index: 1 }
    }

    /// For a radicand that is positive.
    pub(super) fn new(factor: Number, mut radicand: Number, mut index: u32) -> Option<Self> {
        if factor.is_zero() || radicand.is_one() {
            return (!factor.is_oversized()).then(|| Self::rational(factor));
        }
        let mut divisor = 2;
        while divisor <= index {
            let divides = index.is_multiple_of(divisor);
            match divides.then(|| radicand.root_exact(divisor)).flatten() {
                Some(root) => {
                    index /= divisor;
                    radicand = root;
                }
                None => divisor += 1,
            }
        }
        if index == 1 {
            let factor = factor.mul(&radicand);
            return (!factor.is_oversized()).then(|| Self::rational(factor));
        }
        let fits = index <= HIGHEST && !factor.is_oversized() && !radicand.is_oversized();
        fits.then_some(Self { factor, radicand, index })
    }

    fn with_factor(&self, factor: Number) -> Self {
        Self { factor, ..self.clone() }
    }

    /// A multiple of a vector whose factors are whole, so that they are exact in any numbers.
    pub(super) fn without_denominators(vector: &[Self]) -> Vec<Self> {
        let common = Number::from_integer(common_denominator(vector.iter().map(|own| &own.factor)));
        vector.iter().map(|own| own.with_factor(own.factor.mul(&common))).collect()
    }

    pub(super) fn is_zero(&self) -> bool {
        self.factor.is_zero()
    }

    fn is_rational(&self) -> bool {
        self.index == 1
    }

    /// The radicands for a common index.
    fn alike(&self, other: &Self) -> Option<([Number; 2], u32)> {
        let (p, q) = (self.index, other.index);
        if p == q {
            return Some(([self.radicand.clone(), other.radicand.clone()], p));
        }
        let gcd = (1..=p).rev().find(|d| p.is_multiple_of(*d) && q.is_multiple_of(*d))?;
        let index = p / gcd * q;
        let power = |x: &Self| x.radicand.powi(i32::try_from(index / x.index).ok()?);
        (index <= HIGHEST).then_some(([power(self)?, power(other)?], index))
    }

    /// The root of the other one over this one's, where that is a fraction.
    fn ratio(&self, other: &Self) -> Option<Number> {
        if self.index == other.index && self.radicand == other.radicand {
            return Some(Number::ONE);
        }
        // With the least index roots of different orders have no rational ratio.
        if self.index != other.index {
            return None;
        }
        other.radicand.div(&self.radicand)?.root_exact(self.index)
    }

    pub(super) fn mul(&self, other: &Self) -> Option<Self> {
        let factor = self.factor.mul(&other.factor);
        if self.index == 2 && other.index == 2 && self.radicand == other.radicand {
            return Self::new(factor.mul(&self.radicand), Number::ONE, 1);
        }
        let ([a, b], index) = self.alike(other)?;
        Self::new(factor, a.mul(&b), index)
    }

    pub(super) fn recip(&self) -> Option<Self> {
        Self::new(self.factor.recip()?, self.radicand.recip()?, self.index)
    }

    /// The power with exponent numerator/denominator of a positive one; of any one where the denominator is 1.
    pub(super) fn power(&self, numerator: i32, denominator: u32) -> Option<Self> {
        if denominator == 1 {
            let index = i32::try_from(self.index).ok()?;
            let whole = self.radicand.powi(numerator.div_euclid(index))?;
            let rest = self.radicand.powi(numerator.rem_euclid(index))?;
            let factor = self.factor.powi(numerator)?.mul(&whole);
            return Self::new(factor, rest, self.index);
        }
        if self.factor.is_negative() || self.factor.is_zero() {
            return None;
        }
        // (f ρ^(1/q))^(1/d) = (f^q ρ)^(1/(q d))
        let inside = self.factor.powi(i32::try_from(self.index).ok()?)?;
        let index = self.index.checked_mul(denominator).filter(|i| *i <= HIGHEST)?;
        let root = Self::new(Number::ONE, inside.mul(&self.radicand), index)?;
        root.power(numerator, 1)
    }

    /// Factor, radicand and exponent.
    pub(super) fn parts(&self) -> Option<[Number; 3]> {
        let exponent = Number::ratio(1, i64::from(self.index))?;
        Some([self.factor.clone(), self.radicand.clone(), exponent])
    }

    /// The radicand of a square root, 1 for a fraction; `None` for roots of higher order.
    pub(super) fn square_root_of(&self) -> Option<&Number> {
        (self.index <= 2).then_some(&self.radicand)
    }

    /// The root alone.
    pub(super) fn root(&self) -> Self {
        self.with_factor(Number::ONE)
    }

    /// The root alone times a fraction that makes the radicand whole.
    pub(super) fn whole_root(&self) -> Option<Root> {
        // (n/d)^(1/q) = (n d^(q-1))^(1/q) / d
        let power = usize::try_from(self.index).ok()?.checked_sub(1)?;
        let below = IBig::from(self.radicand.denominator()).pow(power);
        Some(Root { radicand: self.radicand.numerator() * below, index: self.index })
    }

    pub(super) fn in_numbers<S: Scalar>(&self, precision: S::Precision) -> S {
        let factor = S::from_number(&self.factor, precision);
        if self.is_rational() {
            return factor;
        }
        factor.mul(&nth_root(S::from_number(&self.radicand, precision), self.index, precision))
    }
}

impl Sum {
    fn single(surd: Surd) -> Self {
        Self { first: surd, others: Vec::new() }
    }

    fn terms(&self) -> impl Iterator<Item = &Surd> {
        std::iter::once(&self.first).chain(&self.others)
    }

    fn of(terms: impl IntoIterator<Item = Surd>) -> Option<Self> {
        let mut sum: Vec<Surd> = Vec::new();
        for term in terms {
            if term.factor.is_zero() {
                continue;
            }
            let same = sum.iter().enumerate().find_map(|(at, own)| Some((at, own.ratio(&term)?)));
            match same {
                Some((at, ratio)) => {
                    let factor = sum[at].factor.add(&term.factor.mul(&ratio));
                    if factor.is_oversized() {
                        return None;
                    }
                    if factor.is_zero() {
                        sum.swap_remove(at);
                    } else {
                        sum[at].factor = factor;
                    }
                }
                None if sum.len() == MOST_TERMS => return None,
                None => sum.push(term),
            }
        }
        let mut terms = sum.into_iter();
        let first = terms.next().unwrap_or_else(|| Surd::rational(Number::ZERO));
        Some(Self { first, others: terms.collect() })
    }

    fn mul(&self, other: &Self) -> Option<Self> {
        if self.others.is_empty() && other.others.is_empty() {
            return self.first.mul(&other.first).map(Self::single);
        }
        let pairs = self.terms().flat_map(|a| other.terms().map(move |b| a.mul(b)));
        Self::of(pairs.collect::<Option<Vec<Surd>>>()?)
    }

    fn neg(&self) -> Self {
        let turned = |term: &Surd| term.with_factor(term.factor.neg());
        Self { first: turned(&self.first), others: self.others.iter().map(turned).collect() }
    }

    /// By conjugates: y·ȳ, with one square root turned into its negative, has that root no more.
    fn recip(&self) -> Option<Self> {
        if self.others.is_empty() {
            return self.first.recip().map(Self::single);
        }
        let roots = Field::of(self.terms())?;
        let (mut above, mut below) = (Self::single(Surd::rational(Number::ONE)), self.clone());
        for at in 0..roots.0.len() {
            let turned = below.terms().map(|term| {
                let (part, _) = roots.part(term)?;
                let turned = part >> at & 1 == 1;
                let factor = &term.factor;
                Some(term.with_factor(if turned { factor.neg() } else { factor.clone() }))
            });
            let conjugate = Self::of(turned.collect::<Option<Vec<Surd>>>()?)?;
            above = above.mul(&conjugate)?;
            below = below.mul(&conjugate)?;
        }
        let below = below.others.is_empty().then_some(below.first)?;
        above.mul(&Self::single(below.recip()?))
    }
}

/// Whole numbers whose square roots generate a field: no product of some of them is a square.
#[derive(Clone, Debug, Default)]
pub(super) struct Field(pub(super) Vec<Number>);

impl Field {
    /// The field of these; `None` where one is no square root.
    pub(super) fn of<'a>(terms: impl Iterator<Item = &'a Surd>) -> Option<Self> {
        let mut field = Self::default();
        for term in terms {
            let radicand = term.square_root_of()?;
            if field.part(term).is_none() {
                let whole = radicand.numerator() * IBig::from(radicand.denominator());
                field.0.push(Number::from_integer(whole));
            }
            if field.0.len() > MOST_ROOTS {
                return None;
            }
        }
        Some(field)
    }

    /// The term as a fraction times the root of the product of those whose bits are set.
    pub(super) fn part(&self, term: &Surd) -> Option<(usize, Number)> {
        let radicand = term.square_root_of()?;
        (0..1_usize << self.0.len()).find_map(|part| {
            let product = self.product(part);
            let ratio = radicand.div(&product)?.sqrt_exact()?;
            Some((part, term.factor.mul(&ratio)))
        })
    }

    fn product(&self, part: usize) -> Number {
        let own = self.0.iter().enumerate();
        let own = own.filter(|(at, _)| part >> at & 1 == 1);
        own.fold(Number::ONE, |product, (_, root)| product.mul(root))
    }
}

/// Fields of more square roots are not computed in.
const MOST_ROOTS: usize = 3;

impl Exact {
    /// factor·√radicand for a radicand that is positive.
    pub(super) fn new(factor: Number, radicand: Number) -> Self {
        Surd::new(factor, radicand, 2).map(Sum::single).into()
    }

    pub(super) fn rational(factor: Option<Number>) -> Self {
        factor.and_then(|factor| Some(Sum::single(Surd::new(factor, Number::ONE, 1)?))).into()
    }

    pub(super) fn of(surd: Surd) -> Self {
        Self::Roots(Sum::single(surd))
    }

    fn turns(number: Number) -> Self {
        if number.is_zero() { Self::rational(Some(number)) } else { Self::Turns(number) }
    }

    fn sum(&self) -> Option<&Sum> {
        if let Self::Roots(sum) = self { Some(sum) } else { None }
    }

    /// All terms, for 0 one that is 0; `None` for what is no such number.
    pub(super) fn terms(&self) -> Option<impl Iterator<Item = &Surd>> {
        self.sum().map(Sum::terms)
    }

    /// The only term.
    pub(super) fn single(&self) -> Option<&Surd> {
        let sum = self.sum()?;
        sum.others.is_empty().then_some(&sum.first)
    }

    /// The number as a fraction, if it is one.
    pub(super) fn as_rational(&self) -> Option<&Number> {
        let own = self.single().filter(|own| own.is_rational());
        own.map(|own| &own.factor)
    }

    pub(super) fn in_numbers<S: Scalar>(&self, precision: S::Precision) -> Option<S> {
        let mut terms = self.terms()?.map(|term| term.in_numbers::<S>(precision));
        let first = terms.next()?;
        Some(terms.fold(first, |sum, term| sum.add(&term)))
    }

    fn with(&self, other: &Self, f: impl Fn(&Sum, &Sum) -> Option<Sum>) -> Self {
        self.sum().zip(other.sum()).and_then(|(a, b)| f(a, b)).into()
    }

    fn is_positive(&self) -> Option<bool> {
        if self.is_exact_zero() {
            return None;
        }
        let value = self.in_numbers::<Ball>(())?;
        (!value.contains_zero()).then(|| value.is_positive())
    }

    /// The cosine of a multiple of π, where that is one of π/12.
    fn cosine(turns: &Number) -> Self {
        let twelfths = turns.mul(&Number::from(12)).rem_floor(&Number::from(24));
        let Some(at) = twelfths.and_then(|own| own.to_i64()) else { return Self::Unknown };
        let at = at.min(24 - at);
        let root = |quarters: i64, radicand: i64| {
            Number::ratio(quarters, 4).map_or(Self::Unknown, |factor| Self::new(factor, Number::from(radicand)))
        };
        let own = match at.min(12 - at) {
            0 => root(4, 1),
            1 => root(1, 6).add(&root(1, 2)),
            2 => root(2, 3),
            3 => root(2, 2),
            4 => root(2, 1),
            5 => root(1, 6).sub(&root(1, 2)),
            _ => root(0, 1),
        };
        if at > 6 { own.neg() } else { own }
    }
}

impl Scalar for Exact {
    type Precision = ();

    fn from_number(number: &Number, (): ()) -> Self {
        Self::of(Surd::rational(number.clone()))
    }

    fn pi((): ()) -> Self {
        Self::Turns(Number::ONE)
    }

    fn add(&self, other: &Self) -> Self {
        match (self, other) {
            (Self::Turns(a), Self::Turns(b)) => return Self::turns(a.add(b)),
            (Self::Turns(_), zero) if zero.is_exact_zero() => return self.clone(),
            (zero, Self::Turns(_)) if zero.is_exact_zero() => return other.clone(),
            _ => {}
        }
        self.with(other, |a, b| {
            if a.first.factor.is_zero() {
                return Some(b.clone());
            }
            if b.first.factor.is_zero() {
                return Some(a.clone());
            }
            Sum::of(a.terms().chain(b.terms()).cloned())
        })
    }

    fn mul(&self, other: &Self) -> Self {
        if let (Self::Turns(turns), other) | (other, Self::Turns(turns)) = (self, other) {
            return other.as_rational().map_or(Self::Unknown, |by| Self::turns(turns.mul(by)));
        }
        // Zero times anything finite is zero, but what is no such number may not be finite.
        self.with(other, Sum::mul)
    }

    fn div(&self, other: &Self) -> Self {
        if let Self::Turns(turns) = self {
            return match other {
                Self::Turns(other) => Self::rational(turns.div(other)),
                _ => other.as_rational().and_then(|by| turns.div(by)).map_or(Self::Unknown, Self::turns),
            };
        }
        self.with(other, |a, b| a.mul(&b.recip()?))
    }

    fn neg(&self) -> Self {
        match self {
            Self::Roots(sum) => Self::Roots(sum.neg()),
            Self::Turns(turns) => Self::Turns(turns.neg()),
            Self::Unknown => Self::Unknown,
        }
    }

    fn powi(&self, exponent: i32) -> Self {
        if let Some(own) = self.single() {
            return own.power(exponent, 1).map(Sum::single).into();
        }
        let one = Self::rational(Some(Number::ONE));
        let power = power(self, exponent.unsigned_abs(), Self::mul).unwrap_or_else(|| one.clone());
        if exponent < 0 { one.div(&power) } else { power }
    }

    fn sqrt(&self) -> Self {
        if self.is_exact_zero() {
            return self.clone();
        }
        let root = self.single().and_then(|own| own.power(1, 2));
        root.map(Sum::single).into()
    }

    fn pow(&self, exponent: &Self) -> Self {
        let power = || {
            let exponent = exponent.as_rational()?;
            let numerator = i32::try_from(exponent.numerator()).ok()?;
            let denominator = u32::try_from(exponent.denominator()).ok()?;
            if denominator == 1 {
                return Some(self.powi(numerator));
            }
            self.single()?.power(numerator, denominator).map(Self::of)
        };
        power().unwrap_or(Self::Unknown)
    }

    fn apply(&self, function: Function) -> Self {
        // The functions are rational at a few points only (Niven's theorem for the circular ones).
        if function == Function::Abs {
            return match self.is_positive() {
                Some(false) => self.neg(),
                Some(true) => self.clone(),
                None if self.is_exact_zero() => self.clone(),
                None => Self::Unknown,
            };
        }
        if let Self::Turns(turns) = self {
            let sine = || Self::cosine(&Number::half().sub(turns));
            return match function {
                Function::Cos => Self::cosine(turns),
                Function::Sin => sine(),
                Function::Tan => sine().div(&Self::cosine(turns)),
                _ => Self::Unknown,
            };
        }
        let Some(a) = self.as_rational() else { return Self::Unknown };
        let (zero, one) = (a.is_zero(), a.is_one());
        Self::rational(match function {
            Function::Sin | Function::Tan | Function::Asin | Function::Atan | Function::Sinh | Function::Tanh => {
                zero.then_some(Number::ZERO)
            }
            Function::Cos | Function::Cosh | Function::Exp => zero.then_some(Number::ONE),
            Function::Acos | Function::Ln => one.then_some(Number::ZERO),
            Function::Abs => None,
        })
    }

    fn atan2(&self, x: &Self) -> Self {
        let ahead = self.is_exact_zero() && x.is_positive() == Some(true);
        Self::rational(ahead.then_some(Number::ZERO))
    }

    fn is_finite(&self) -> bool {
        self.sum().is_some()
    }

    fn is_exact_zero(&self) -> bool {
        self.sum().is_some_and(|sum| sum.first.factor.is_zero())
    }
}
