//! Sums of coefficients times velocities, accelerations and displacements, in reading order.
//!
//! The pool orders what is equal to it by age; an equation of motion reads differently:
//! accelerations first, then velocities, then forces. So the order is kept here, and the pool keeps
//! the coefficients.

use std::collections::BTreeMap;

use super::simplify::Algebra;
use crate::expr::{ExprId, Function, Node, Pool, Symbol};
use crate::number::Number;
use crate::order::Order;

/// What moves, by the number of its coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Motion {
    /// The second derivative of a coordinate by the time.
    Acceleration(usize),
    /// A generalized velocity.
    Velocity(usize),
    /// A generalized momentum.
    Momentum(usize),
    /// A coordinate measured from its equilibrium.
    Displacement(usize),
    /// The velocity of a normal coordinate, by the number of its mode.
    NormalVelocity(usize),
    /// A normal coordinate.
    Normal(usize),
}

/// A coefficient times what moves.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MotionTerm {
    /// Whether a minus sign stands in front.
    pub negative: bool,
    /// The coefficient behind the sign, never 0. One without motion has its signs itself.
    pub coefficient: ExprId,
    /// The factors with their powers; empty for a term without any.
    pub motion: Vec<(Motion, u32)>,
}

/// A sum of [`MotionTerm`]s in reading order; 0 if there are none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct MotionSum {
    /// The terms.
    pub terms: Vec<MotionTerm>,
    /// Sums and squares of sums, each with what it is multiplied by and its power; they stand before the terms.
    pub powers: Vec<MotionPower>,
    /// A number in front of the whole sum, as the 1/2 of a quadratic form; 1 where there is none.
    pub factor: Factor,
}

/// A power of a sum with what it is multiplied by.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MotionPower {
    /// What stands before it.
    pub factor: ExprId,
    /// The sum.
    pub sum: MotionSum,
    /// Its power, 1 or 2.
    pub power: u32,
}

/// The number in front of a [`MotionSum`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Factor {
    /// Nothing is written.
    #[default]
    One,
    /// 1/2.
    Half,
}

/// What the coordinates and what is made of them are called in text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Names {
    /// The coordinates, in order.
    pub coordinates: Vec<String>,
    /// The coordinates measured from the equilibrium: the same, where that is 0.
    pub displacements: Vec<String>,
    /// What momenta begin with: `p`, if the model has no such names.
    pub momentum: String,
    /// The family of the normal coordinates: `Q`, if the model has no such name.
    pub normal: String,
    /// The Lagrangian, the energy function and the Hamiltonian: `L`, `h` and `H`, if the model has no such names.
    pub energies: [String; 3],
    /// A frequency: `omega`, if the model has no such name.
    pub omega: String,
    /// What the model calls expressions of its own.
    pub named: Vec<String>,
}

impl Names {
    /// The name of what moves in the model language: `x''` for an acceleration. Momenta are no
    /// part of the language; they are called `p_x`.
    #[must_use]
    pub fn of(&self, motion: Motion) -> String {
        self.moving(motion, &self.coordinates)
    }

    /// The same, for the velocity and acceleration of a displacement.
    #[must_use]
    pub fn displaced(&self, motion: Motion) -> String {
        self.moving(motion, &self.displacements)
    }

    fn moving(&self, motion: Motion, names: &[String]) -> String {
        let name = |names: &[String], i: usize| names.get(i).cloned().unwrap_or_default();
        match motion {
            Motion::Acceleration(i) => name(names, i) + "''",
            Motion::Velocity(i) => name(names, i) + "'",
            Motion::Momentum(i) => format!("{}_{}", self.momentum, name(&self.coordinates, i)),
            Motion::Displacement(i) => name(&self.displacements, i),
            Motion::NormalVelocity(i) => format!("{}[{}]'", self.normal, i + 1),
            Motion::Normal(i) => format!("{}[{}]", self.normal, i + 1),
        }
    }
}

impl MotionSum {
    /// A sum with its terms in reading order, without those that are 0.
    pub(super) fn new(pool: &mut Pool, terms: impl IntoIterator<Item = MotionTerm>) -> Self {
        let mut terms: Vec<MotionTerm> = terms.into_iter().filter(|term| !term.coefficient.is_zero()).collect();
        terms.order_by_key(order);
        for term in &mut terms {
            if reads_negative(pool, term) {
                term.negative = true;
                term.coefficient = pool.neg(term.coefficient);
            }
        }
        Self { terms, ..Self::default() }
    }

    /// A sum by its motions, the parts of each coefficient added up.
    pub(super) fn of_parts(pool: &mut Algebra<'_>, parts: BTreeMap<Vec<(Motion, u32)>, Vec<ExprId>>) -> Self {
        let terms = parts.into_iter();
        let terms = terms.map(|(motion, parts)| MotionTerm::new(pool.short(|pool| pool.sum(&parts)), &motion));
        let terms: Vec<MotionTerm> = terms.collect();
        Self::new(pool, terms)
    }

    /// How many symbols it takes to write it, roughly.
    pub(super) fn weight(&self, pool: &mut Algebra<'_>) -> u64 {
        self.terms.iter().map(|term| pool.weight(term.coefficient) + 1 + term.motion.len() as u64).sum()
    }

    /// Whether nothing is left of it.
    pub(crate) fn is_zero(&self) -> bool {
        self.terms.is_empty() && self.powers.is_empty()
    }

    /// The coefficient of one motion alone.
    pub fn coefficient(&self, pool: &mut Pool, motion: Motion) -> ExprId {
        match self.terms.iter().find(|term| term.motion == [(motion, 1)]) {
            None => pool.zero(),
            Some(term) if term.negative => pool.neg(term.coefficient),
            Some(term) => term.coefficient,
        }
    }

    /// The sum as one expression, with `value` for what moves.
    pub fn expression(&self, pool: &mut Pool, mut value: impl FnMut(&mut Pool, Motion) -> ExprId) -> ExprId {
        self.expression_with(pool, &mut value)
    }

    /// The sum without its accelerations, in the symbols of the velocities.
    pub fn at_constant_rates(&self, pool: &mut Pool, velocities: &[Symbol]) -> ExprId {
        self.expression(pool, |pool, motion| match motion {
            Motion::Velocity(i) => pool.symbol_expr(velocities[i]),
            _ => pool.zero(),
        })
    }

    fn expression_with(&self, pool: &mut Pool, value: &mut dyn FnMut(&mut Pool, Motion) -> ExprId) -> ExprId {
        let mut parts = Vec::with_capacity(self.terms.len());
        for MotionPower { factor, sum, power } in &self.powers {
            let sum = sum.expression_with(pool, value);
            let power = pool.powi(sum, i64::from(*power));
            parts.push(pool.mul(*factor, power));
        }
        for term in &self.terms {
            let mut factors = vec![(term.coefficient, Number::ONE)];
            let motion = term.motion.iter();
            factors.extend(motion.map(|(own, power)| (value(pool, *own), Number::from(i64::from(*power)))));
            let product = pool.product_of_powers(&factors);
            parts.push(if term.negative { pool.neg(product) } else { product });
        }
        let sum = pool.sum(&parts);
        match self.factor {
            Factor::One => sum,
            Factor::Half => pool.scale(sum, &Number::half()),
        }
    }

    /// The sum in the model language.
    #[must_use]
    pub fn text(&self, pool: &Pool, name: impl Fn(Motion) -> String) -> String {
        self.text_with(pool, &name)
    }

    fn text_with(&self, pool: &Pool, name: &dyn Fn(Motion) -> String) -> String {
        if self.is_zero() {
            return "0".to_owned();
        }
        let is_velocity = |own: &MotionTerm| matches!(own.motion[..], [(Motion::Velocity(_), 1)]);
        if self.powers.is_empty()
            && self.terms.iter().all(is_velocity)
            && let Some(text) = factored(&self.terms, pool, name)
        {
            return text;
        }
        let mut out = String::new();
        let powers = self.powers.iter().map(|MotionPower { factor, sum, power }| {
            let sum = sum.text_with(pool, name);
            let text = if *power == 1 { format!("({sum})") } else { format!("({sum})^{power}") };
            (false, multiplied(factor_text(pool, *factor), &text, true))
        });
        // About an equilibrium functions are constants like all else before a displacement.
        let is_displaced = |(own, _): &(Motion, u32)| matches!(own, Motion::Displacement(_) | Motion::Normal(_));
        let constant = self.terms.iter().any(|term| term.motion.iter().any(is_displaced));
        let mut count = 0;
        let texts = |terms: &[MotionTerm]| -> Vec<(bool, String)> {
            let chunks = terms.chunk_by(MotionTerm::goes_with);
            chunks.map(|own| MotionTerm::text(own, pool, name, constant)).collect()
        };
        // The kinetic energy.
        let (kinetic, others) =
            self.terms.split_at(self.terms.iter().take_while(|own| own.is_of_two_velocities()).count());
        let mut terms = texts(kinetic);
        if self.factor == Factor::One
            && let Some(whole) = factored(kinetic, pool, name)
            && whole.len() < terms.iter().map(|(_, text)| text.len() + " + ".len()).sum::<usize>() - " + ".len()
        {
            terms = vec![(false, whole)];
        }
        terms.extend(texts(others));
        for (negative, text) in powers.chain(terms) {
            count += 1;
            append(&mut out, negative, &text);
        }
        let moves = self.terms.iter().all(|term| !term.motion.is_empty());
        match self.factor {
            Factor::One => out,
            Factor::Half if count == 1 && moves && out.starts_with("2*") => match &out[2..] {
                all if all.starts_with('(') && all.find(')') == Some(all.len() - 1) => all[1..all.len() - 1].to_owned(),
                rest => rest.to_owned(),
            },
            Factor::Half if count == 1 && self.terms.len() > 1 && out.ends_with(')') => match out.strip_prefix('-') {
                Some(rest) => format!("-1/2*{rest}"),
                None => format!("1/2*{out}"),
            },
            Factor::Half => format!("1/2*({out})"),
        }
    }
}

/// A sum with the coefficient of one term in front, where the others have it for a factor: C (ψ' + φ' cos θ).
fn factored(terms: &[MotionTerm], pool: &Pool, name: &dyn Fn(Motion) -> String) -> Option<String> {
    if terms.len() < 2 {
        return None;
    }
    let factors = |term: &MotionTerm| match &*pool.terms(term.coefficient) {
        [(product, number)] => {
            let factors = pool.factors(*product);
            let is_one = |own: &(ExprId, Number)| pool.as_number(own.0).is_some_and(Number::is_one);
            Some((number.clone(), factors.into_iter().filter(|own| !is_one(own)).collect::<Vec<_>>()))
        }
        _ => None,
    };
    let all: Vec<_> = terms.iter().map(factors).collect::<Option<_>>()?;
    let divides = |(number, own): &&(Number, Vec<(ExprId, Number)>)| {
        let has = |(other, all): &(Number, Vec<(ExprId, Number)>)| {
            own.iter().all(|factor| all.contains(factor)) && other.div(number).is_some_and(|ratio| ratio.is_integer())
        };
        !own.is_empty() && all.iter().all(has)
    };
    let (number, common) = all.iter().find(divides)?;
    let mut sum = String::new();
    for (term, (own, factors)) in terms.iter().zip(&all) {
        let rest = factors.iter().filter(|factor| !common.contains(factor)).cloned().collect();
        let (factor, functions) = factors_apart(pool, &own.div(number)?, rest);
        append(&mut sum, term.negative, &around(factor, &term.motion_text(name), functions, false));
    }
    Some(multiplied(pool.display_factors(number, common.clone()), &format!("({sum})"), false))
}

/// Accelerations, then squares, then products of two that move, then single ones, then what is without.
fn order(term: &MotionTerm) -> (u8, Vec<Motion>) {
    let degree: u32 = term.motion.iter().map(|(_, power)| *power).sum();
    let rank = match term.motion.first() {
        Some((Motion::Acceleration(_), _)) => 0,
        Some(_) if degree > 1 && term.motion.len() == 1 => 1,
        Some(_) if degree > 1 => 2,
        Some(_) => 3,
        None => 4,
    };
    let motion = term.motion.iter();
    let one_by_one = motion.flat_map(|(motion, power)| std::iter::repeat_n(*motion, *power as usize));
    (rank, one_by_one.collect())
}

impl MotionTerm {
    pub(super) fn new(coefficient: ExprId, motion: &[(Motion, u32)]) -> Self {
        Self { negative: false, coefficient, motion: motion.to_vec() }
    }

    /// Whether both are squares with the same coefficient, which is written once in front of their sum.
    fn goes_with(&self, next: &Self) -> bool {
        let is_square = |own: &Self| matches!(own.motion[..], [(_, 2)]);
        let alike = self.negative == next.negative && self.coefficient == next.coefficient;
        alike && is_square(self) && is_square(next)
    }

    /// Of terms that go with each other whether a minus sign stands in front, and the text behind the sign: functions behind what moves,
    /// unless they are constants.
    fn text(all: &[Self], pool: &Pool, name: &dyn Fn(Motion) -> String, constant: bool) -> (bool, String) {
        let [first, ..] = all else { return (false, String::new()) };
        if first.motion.is_empty() {
            let text = pool.display(first.coefficient);
            // A sum keeps its own signs; only the first one is taken over.
            return match text.strip_prefix('-') {
                Some(rest) => (!first.negative, rest.to_owned()),
                None => (first.negative, text),
            };
        }
        let (rest, functions) = if constant {
            (factor_text(pool, first.coefficient), None)
        } else {
            functions_apart(pool, first.coefficient)
        };
        let products = all.iter().map(|own| own.motion_text(name));
        let motion = match (all.len(), products.collect::<Vec<_>>().join(" + ")) {
            (2.., sum) if first.negative || rest.is_some() || functions.is_some() => format!("({sum})"),
            (_, sum) => sum,
        };
        (first.negative, around(rest, &motion, functions, first.has_momenta()))
    }

    fn is_of_two_velocities(&self) -> bool {
        let is_velocity = |own: &(Motion, u32)| matches!(own.0, Motion::Velocity(_));
        self.motion.iter().all(is_velocity) && self.motion.iter().map(|own| own.1).sum::<u32>() == 2
    }

    fn has_momenta(&self) -> bool {
        matches!(self.motion.first(), Some((Motion::Momentum(_), _)))
    }

    /// The product of what moves.
    fn motion_text(&self, name: &dyn Fn(Motion) -> String) -> String {
        let power = |(motion, power): &(Motion, u32)| {
            let name = name(*motion);
            if *power == 1 { name } else { format!("{name}^{power}") }
        };
        self.motion.iter().map(power).collect::<Vec<_>>().join("*")
    }
}

/// What moves times the text of a factor: p^2/(2*m), not 1/(2*m)*p^2; above any fraction bar where asked for.
fn multiplied(factor: Option<String>, motion: &str, above: bool) -> String {
    let Some(factor) = factor else { return motion.to_owned() };
    match last_bar(&factor) {
        Some(("1", divisor)) => format!("{motion}/{divisor}"),
        Some((factor, divisor)) if above => format!("{factor}*{motion}/{divisor}"),
        _ => format!("{factor}*{motion}"),
    }
}

/// Adds a term to the text of a sum.
fn append(sum: &mut String, negative: bool, text: &str) {
    *sum += match (sum.is_empty(), negative) {
        (true, false) => "",
        (true, true) => "-",
        (false, false) => " + ",
        (false, true) => " - ",
    };
    *sum += text;
}

/// What moves between the text of a factor and that of functions.
fn around(factor: Option<String>, motion: &str, functions: Option<String>, above: bool) -> String {
    let motion = functions.into_iter().fold(motion.to_owned(), |motion, functions| format!("{motion}*{functions}"));
    multiplied(factor, &motion, above)
}

/// Whether what stands in front of what moves begins with a minus sign; before two momenta it does not take that up.
fn reads_negative(pool: &Pool, term: &MotionTerm) -> bool {
    if let Some(value) = pool.as_number(term.coefficient) {
        return value.is_negative() && !term.motion.is_empty();
    }
    let is_negative = pool.terms(term.coefficient).iter().all(|(_, coefficient)| coefficient.is_negative());
    is_negative
        && !term.motion.is_empty()
        && (term.has_momenta() && term.motion.len() > 1 || pool.display(term.coefficient).starts_with('-'))
}

/// An expression as the first factor of a product; nothing for 1.
fn factor_text(pool: &Pool, e: ExprId) -> Option<String> {
    if pool.as_number(e).is_some_and(Number::is_one) {
        return None;
    }
    // A sign stands between two terms.
    Some(pool.display_as_factor(e))
}

/// A factor of what moves as text, and that of functions in it, which stand behind what moves.
fn functions_apart(pool: &Pool, e: ExprId) -> (Option<String>, Option<String>) {
    let [(product, coefficient)] = &*pool.terms(e) else { return (factor_text(pool, e), None) };
    let factors = pool.factors(*product);
    if factors.iter().any(|own| is_function(pool, own)) {
        return factors_apart(pool, coefficient, factors);
    }
    (factor_text(pool, e), None)
}

/// The same of a number and powers.
fn factors_apart(pool: &Pool, number: &Number, all: Vec<(ExprId, Number)>) -> (Option<String>, Option<String>) {
    let (functions, rest): (Vec<_>, Vec<_>) = all.into_iter().partition(|own| is_function(pool, own));
    (pool.display_factors(number, rest), pool.display_factors(&Number::ONE, functions))
}

/// Whether a power stands behind what moves.
fn is_function(pool: &Pool, (base, exponent): &(ExprId, Number)) -> bool {
    let stands_behind = matches!(pool.node(*base), Node::Function(own, _) if *own != Function::Abs);
    stands_behind && exponent.is_integer() && !exponent.is_negative()
}

/// What stands above and below the last fraction bar, where nothing follows that and no number stands below.
fn last_bar(text: &str) -> Option<(&str, &str)> {
    let mut depth = 0_usize;
    let mut bar = None;
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth = depth.saturating_sub(1),
            '/' if depth == 0 => bar = Some(at),
            '*' | ' ' if depth == 0 => bar = None,
            _ => {}
        }
    }
    let (above, below) = text.split_at(bar?);
    let below = &below[1..];
    (!below.starts_with(|c: char| c.is_ascii_digit())).then_some((above, below))
}
