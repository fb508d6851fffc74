//! Products and powers with rational exponents.
//!
//! A product is built by one loop over a list of `base^exponent` still to be examined: products
//! are taken apart, numbers, contents of sums and what is certainly not negative come out of
//! roots, equal bases are collected. What collecting made reducible again (`sqrt(u)*sqrt(u)`)
//! goes back on the list; every round takes something apart, so that there are few.

use super::sum::{collect_equal, leads_negative};
use super::{ExprId, Function, Node, ONE, Pool, Symbol, UNDEFINED, ZERO, intern};
use crate::number::Number;
use crate::order::Order;

/// Products of more factors are not taken apart again. The derivative of a chain of n functions
/// is a product of n factors, and so is each one on the way to it: flat, they would take n^2/2
/// places.
const MAX_FACTORS: usize = 64;

/// What the product loop works on.
#[derive(Default)]
struct Workspace {
    /// What numbers come to.
    coefficient: Number,
    /// Factors still to be examined.
    pending: Vec<(ExprId, Number)>,
    /// Factors that are canonical by themselves.
    settled: Vec<(ExprId, Number)>,
    /// Arguments of exponential functions with their factors.
    exponents: Vec<(ExprId, Number)>,
    /// Prime factors of numbers under roots with their exponents.
    roots: Vec<(Number, Number)>,
}

/// Breaks off a product that has no value.
enum NoValue {
    Undefined,
    /// One that is too long to be written out.
    TooLong,
}

impl Pool {
    /// The product of the expressions.
    pub fn product(&mut self, factors: &[ExprId]) -> ExprId {
        match factors {
            [] => ONE,
            [single] => *single,
            [a, b] => self.mul(*a, *b),
            _ => self.product_iter(factors.iter().map(|factor| (*factor, Number::ONE))),
        }
    }

    /// The product of `base^exponent`.
    pub fn product_of_powers(&mut self, factors: &[(ExprId, Number)]) -> ExprId {
        let known = self.find_product(factors);
        known.unwrap_or_else(|| self.product_iter(factors.iter().cloned()))
    }

    /// The product that consists of these factors, as they are. What becomes of powers that are not whole depends on assumptions, which may
    /// be younger.
    fn find_product(&self, factors: &[(ExprId, Number)]) -> Option<ExprId> {
        if !factors.iter().all(|(_, exponent)| exponent.is_integer()) {
            return None;
        }
        let is_same = |id| matches!(self.nodes.get(id as usize), Some(Node::Product(own)) if **own == *factors);
        self.table.find(intern::hash_of_product(factors), is_same).map(ExprId)
    }

    /// The product of two expressions.
    pub fn mul(&mut self, a: ExprId, b: ExprId) -> ExprId {
        if let Some(value) = self.as_number(a).cloned() {
            return self.scale(b, &value);
        }
        if let Some(value) = self.as_number(b).cloned() {
            return self.scale(a, &value);
        }
        self.product_iter([(a, Number::ONE), (b, Number::ONE)].into_iter())
    }

    /// The product of an expression and a symbol.
    pub fn times(&mut self, e: ExprId, symbol: Symbol) -> ExprId {
        let symbol = self.symbol_expr(symbol);
        self.mul(e, symbol)
    }

    /// The quotient of two expressions; [`Node::Undefined`] where the divisor is exactly 0.
    pub fn div(&mut self, a: ExprId, b: ExprId) -> ExprId {
        if let Some(value) = self.as_number(b) {
            return if let Some(inverse) = value.recip() { self.scale(a, &inverse) } else { UNDEFINED };
        }
        self.product_iter([(a, Number::ONE), (b, Number::MINUS_ONE)].into_iter())
    }

    /// A power with a rational exponent. Powers that are not whole have values only of bases
    /// that are not negative: `(-8)^(1/3)` is [`Node::Undefined`]. `x^0` is 1.
    pub fn powr(&mut self, base: ExprId, exponent: &Number) -> ExprId {
        if exponent.is_one() { base } else { self.product_iter(std::iter::once((base, exponent.clone()))) }
    }

    /// A whole power.
    pub fn powi(&mut self, base: ExprId, exponent: i64) -> ExprId {
        self.powr(base, &Number::from(exponent))
    }

    /// The square root.
    pub fn sqrt(&mut self, x: ExprId) -> ExprId {
        self.powr(x, &Number::half())
    }

    /// The square.
    pub fn square(&mut self, x: ExprId) -> ExprId {
        self.powr(x, &Number::from(2))
    }

    /// A power with any exponent; the base is taken to be positive where the exponent is not a
    /// number.
    pub fn power(&mut self, base: ExprId, exponent: ExprId) -> ExprId {
        if base == UNDEFINED || exponent == UNDEFINED {
            return UNDEFINED;
        }
        if let Some(value) = self.as_number(exponent).cloned() {
            return self.powr(base, &value);
        }
        if base == ONE {
            return ONE;
        }
        if let Some(x) = self.exponential(base) {
            let x = self.mul(x, exponent);
            return self.apply(Function::Exp, x);
        }
        if let Node::Power { base, exponent: inner } = *self.node(base)
            && self.is_nonnegative(base)
        {
            let exponent = self.mul(inner, exponent);
            return self.power_node(base, exponent);
        }
        self.power_node(base, exponent)
    }

    /// Whether (b^n)^exponent is b^(n*exponent): with n = 2 and a negative b, (b^n)^(1/2) is -b.
    fn is_one_power(&self, b: ExprId, exponent: &Number) -> bool {
        exponent.is_integer() || self.is_nonnegative(b)
    }

    /// A power whose base is no exponential, nor a power that it could be merged with.
    fn power_node(&mut self, base: ExprId, exponent: ExprId) -> ExprId {
        if let Some(value) = self.as_number(exponent).cloned() {
            return self.powr(base, &value);
        }
        // By the last term, so that x^(n - 1) stays what it is.
        if let Node::Sum { terms, .. } = self.node(exponent)
            && terms.last().is_some_and(|(_, c)| c.is_negative())
        {
            let exponent = self.neg(exponent);
            let inverse = self.intern(Node::Power { base, exponent });
            return self.product_iter(std::iter::once((inverse, Number::MINUS_ONE)));
        }
        self.intern(Node::Power { base, exponent })
    }

    fn product_iter(&mut self, factors: impl Iterator<Item = (ExprId, Number)>) -> ExprId {
        let mut work = Workspace { coefficient: Number::ONE, pending: factors.collect(), ..Workspace::default() };
        work.pending.reverse();
        match self.build_product(&mut work) {
            Ok(result) => result,
            Err(NoValue::Undefined) => UNDEFINED,
            Err(NoValue::TooLong) => self.too_long(),
        }
    }

    fn build_product(&mut self, work: &mut Workspace) -> Result<ExprId, NoValue> {
        if self.is_spent() {
            return Err(NoValue::Undefined);
        }
        loop {
            while let Some((base, exponent)) = work.pending.pop() {
                self.settle(base, exponent, work)?;
            }
            self.merge_exponentials(work);
            collect_equal(&mut work.settled);
            self.merge_powers(work);
            self.settle_moduli(&mut work.settled);
            self.take_back_reducible(work);
            if work.pending.is_empty() && work.exponents.is_empty() {
                break;
            }
        }
        self.settle_roots(work)?;
        if work.coefficient.is_zero() {
            return Ok(ZERO);
        }
        let core = match work.settled.as_slice() {
            [] => return Ok(self.number(std::mem::take(&mut work.coefficient))),
            [(base, exponent)] if exponent.is_one() => *base,
            _ => self.intern(Node::Product(std::mem::take(&mut work.settled).into())),
        };
        Ok(self.scale(core, &work.coefficient))
    }

    /// Looks at one factor: canonical ones are settled, the others taken apart.
    fn settle(&mut self, base: ExprId, exponent: Number, work: &mut Workspace) -> Result<(), NoValue> {
        if base == UNDEFINED {
            return Err(NoValue::Undefined);
        }
        if exponent.is_zero() {
            return Ok(());
        }
        let whole = exponent.is_integer();
        match self.node(base) {
            Node::Number(value) => return multiply_number(value, &exponent, work),
            Node::Product(factors) if whole && factors.len() > MAX_FACTORS => work.settled.push((base, exponent)),
            Node::Product(factors) if whole => work.pending.extend(factors.iter().map(|(b, e)| (*b, e.mul(&exponent)))),
            Node::Product(_) => self.settle_root(base, false, exponent, work),
            Node::Sum { constant, terms } => {
                if let ([(term, factor)], true) = (&**terms, constant.is_zero()) {
                    let (term, factor) = (*term, factor.clone());
                    if whole {
                        multiply_number(&factor, &exponent, work)?;
                        work.pending.push((term, exponent));
                    } else {
                        multiply_number(&factor.abs(), &exponent, work)?;
                        self.settle_root(term, factor.is_negative(), exponent, work);
                    }
                    return Ok(());
                }
                if let Some(shorter) = if whole { None } else { self.without_pythagoras(base) } {
                    work.pending.push((shorter, exponent));
                    return Ok(());
                }
                let (content, core) = self.split_coefficient(base, whole);
                multiply_number(&content, &exponent, work)?;
                work.settled.push((core, exponent));
            }
            Node::Function(Function::Abs, x) if exponent.is_even() => work.pending.push((*x, exponent)),
            Node::Function(Function::Exp, x) => work.exponents.push((*x, exponent)),
            Node::Power { base: b, .. } if !self.is_one_power(*b, &exponent) => work.settled.push((base, exponent)),
            Node::Power { base: b, exponent: e } => {
                let (b, e) = (*b, *e);
                let magnitude = exponent.abs();
                let node = if magnitude.is_one() {
                    base
                } else {
                    let e = self.scale(e, &magnitude);
                    self.intern(Node::Power { base: b, exponent: e })
                };
                work.settled.push((node, sign(&exponent)));
            }
            Node::Undefined => return Err(NoValue::Undefined),
            Node::Pi | Node::Symbol(_) | Node::Function(..) | Node::Atan2 { .. } => work.settled.push((base, exponent)),
        }
        Ok(())
    }

    /// A sum in which a sin²(x) and a cos²(x) are put together, if there are such terms.
    fn without_pythagoras(&mut self, sum: ExprId) -> Option<ExprId> {
        let Node::Sum { constant, terms } = self.node(sum) else { return None };
        let is_sine = |(base, exponent): &(ExprId, Number)| {
            *exponent == Number::from(2) && matches!(self.node(*base), Node::Function(Function::Sin, _))
        };
        if !terms
            .iter()
            .any(|(term, _)| matches!(self.node(*term), Node::Product(factors) if factors.iter().any(is_sine)))
        {
            return None;
        }
        let (mut constant, mut terms) = (constant.clone(), terms.to_vec());
        let (mut at, mut found) = (0, false);
        while at < terms.len() {
            let (term, coefficient) = terms[at].clone();
            at += 1;
            let factors = self.factors(term);
            let sine = factors.iter().enumerate().find_map(|(place, (base, exponent))| match self.node(*base) {
                Node::Function(Function::Sin, x) if *exponent == Number::from(2) => Some((place, *x)),
                _ => None,
            });
            let Some((place, x)) = sine else { continue };
            let mut rest = factors;
            rest.remove(place);
            let cosine = self.cos(x);
            let partner = [rest.as_slice(), &[(cosine, Number::from(2))]].concat();
            let partner = self.product_of_powers(&partner);
            if !terms.contains(&(partner, coefficient.clone())) {
                continue;
            }
            (at, found) = (0, true);
            let whole = self.product_of_powers(&rest);
            terms.retain(|own| own.0 != term && own.0 != partner);
            if rest.is_empty() {
                constant = constant.add(&coefficient);
            } else {
                terms.push((whole, coefficient));
            }
        }
        if !found {
            return None;
        }
        let sum = self.linear(&terms);
        let constant = self.number(constant);
        Some(self.add(sum, constant))
    }

    /// `(±term)^exponent` for an exponent that is not whole.
    ///
    /// Whatever is certainly not negative comes out, `(x^2)^r = |x|^(2r)`; odd powers leave one
    /// factor behind, `(x^3*y)^r = |x|^(2r)*(x*y)^r`. The first factor that stays gets exponent
    /// 1: `(y/x)^r = (x/y)^-r` with x before y.
    fn settle_root(&mut self, term: ExprId, negative: bool, exponent: Number, work: &mut Workspace) {
        let base = if negative { self.neg(term) } else { term };
        let factors = self.factors(term);
        let stay = factors.iter().filter(|(b, e)| !self.is_nonnegative_power(*b, e));
        let mut left: Vec<(ExprId, Number)> = stay.map(|(b, e)| (*b, sign(e))).collect();
        if negative && left.is_empty() {
            // -(x^2) under a root: a value only at x = 0. Nothing is gained by taking it apart.
            work.settled.push((base, exponent));
            return;
        }
        for (b, e) in &factors {
            if !e.is_integer() || self.is_nonnegative(*b) {
                work.pending.push((*b, e.mul(&exponent)));
                continue;
            }
            let even = if e.is_even() { e.clone() } else { e.sub(&sign(e)) };
            // A single odd power: (x^3)^r = x^(3r), since x is not negative where it has a value, which a whole 3r would not show.
            if !e.is_even() && !negative && left.len() == 1 && !e.mul(&exponent).is_integer() {
                work.pending.push((*b, even.mul(&exponent)));
            } else if !even.is_zero() {
                let magnitude = self.apply(Function::Abs, *b);
                work.pending.push((magnitude, even.mul(&exponent)));
            }
        }
        let mut exponent = exponent;
        if left.first().is_some_and(|(_, e)| e.is_negative()) {
            exponent = exponent.neg();
            for (_, e) in &mut left {
                *e = e.neg();
            }
        }
        let core = match left.as_slice() {
            [] => return,
            [(b, _)] => *b,
            _ => self.intern(Node::Product(left.into())),
        };
        let core = if negative { self.neg(core) } else { core };
        let is_settled = matches!(self.node(core), Node::Product(_) | Node::Sum { .. });
        let list = if is_settled { &mut work.settled } else { &mut work.pending };
        list.push((core, exponent));
    }

    /// `exp(a)*exp(b) = exp(a + b)`.
    fn merge_exponentials(&mut self, work: &mut Workspace) {
        if work.exponents.is_empty() {
            return;
        }
        let at = work.settled.iter().position(|(b, _)| self.exponential(*b).is_some());
        if let Some(at) = at {
            let (node, exponent) = work.settled.swap_remove(at);
            work.exponents.extend(self.exponential(node).map(|x| (x, exponent)));
        }
        let argument = self.linear(&work.exponents);
        work.exponents.clear();
        let merged = self.apply(Function::Exp, argument);
        let is_settled = self.exponential(merged).is_some();
        let list = if is_settled { &mut work.settled } else { &mut work.pending };
        list.push((merged, Number::ONE));
    }

    /// Puts powers of one base together where one has an exponent that is no number: x^n/x = x^(n - 1).
    fn merge_powers(&mut self, work: &mut Workspace) {
        let mut at = 0;
        while let Some((node, _)) = work.settled.get(at) {
            at += 1;
            let Node::Power { base, .. } = *self.node(*node) else { continue };
            let exponent_of = |pool: &Self, node: ExprId, times: &Number| match *pool.node(node) {
                Node::Power { base: own, exponent } if own == base && pool.is_one_power(base, times) => Some(exponent),
                _ => (node == base).then_some(ONE),
            };
            if work.settled.iter().filter(|(node, times)| exponent_of(self, *node, times).is_some()).count() < 2 {
                continue;
            }
            let mut exponents = Vec::new();
            work.settled.retain(|(node, times)| {
                let exponent = exponent_of(self, *node, times);
                exponents.extend(exponent.map(|exponent| (exponent, times.clone())));
                exponent.is_none()
            });
            let exponent = self.linear(&exponents);
            let merged = self.power(base, exponent);
            work.pending.push((merged, Number::ONE));
            at = 0;
        }
    }

    /// The argument of an exponential function.
    fn exponential(&self, e: ExprId) -> Option<ExprId> {
        self.as_function(e).filter(|(function, _)| *function == Function::Exp).map(|(_, x)| x)
    }

    /// Puts x^m |x|^b, m an integer, as x^p |x|^(m + b - p) with p = 0 or 1, its sign: so there is one form of it, and what is
    /// continuous where x is 0 has a value there: x³/|x| = x|x|, x²/|x|^(1/2) = |x|^(3/2). Where m is none, x is not negative, and takes
    /// all of b but what is left beyond an integer.
    fn settle_moduli(&mut self, settled: &mut Vec<(ExprId, Number)>) {
        for at in 0..settled.len() {
            let Node::Function(Function::Abs, x) = self.node(settled[at].0) else { continue };
            // Sums are factors with the sign of their first term.
            let x = *x;
            let x = if self.leads_negative(x) { self.neg(x) } else { x };
            let Some(other) = settled.iter().position(|(base, _)| *base == x) else { continue };
            let (m, b) = (settled[other].1.clone(), settled[at].1.clone());
            let kept = if !m.is_integer() {
                m.add(&b.floor())
            } else if m.is_even() {
                Number::ZERO
            } else {
                Number::ONE
            };
            settled[at].1 = m.add(&b).sub(&kept);
            settled[other].1 = kept;
        }
        settled.retain(|(_, exponent)| !exponent.is_zero());
    }

    /// Moves factors whose collected exponents allow more back to the pending ones.
    fn take_back_reducible(&self, work: &mut Workspace) {
        let pending = &mut work.pending;
        work.settled.retain(|(base, exponent)| {
            let reducible = match self.node(*base) {
                Node::Product(factors) => exponent.is_integer() && factors.len() <= MAX_FACTORS,
                Node::Sum { constant, terms } => {
                    exponent.is_integer() && (leads_negative(constant, terms) || !self.flags(*base).primitive)
                }
                Node::Function(Function::Abs, _) => exponent.is_even(),
                Node::Power { base, .. } => !exponent.abs().is_one() && self.is_one_power(*base, exponent),
                _ => false,
            };
            if reducible {
                pending.push((*base, exponent.clone()));
            }
            !reducible
        });
    }

    /// Collects the primes under roots: whole powers go to the coefficient, and one number base
    /// remains for each exponent between 0 and 1: `sqrt(2)*sqrt(6) = 2*sqrt(3)`.
    fn settle_roots(&mut self, work: &mut Workspace) -> Result<(), NoValue> {
        if work.roots.is_empty() {
            return Ok(());
        }
        collect_equal(&mut work.roots);
        let mut by_exponent: Vec<(Number, Number)> = Vec::new();
        for (prime, exponent) in work.roots.drain(..) {
            let whole = exponent.floor();
            let fraction = exponent.sub(&whole);
            multiply_whole_power(&prime, &whole, &mut work.coefficient)?;
            if !fraction.is_zero() {
                by_exponent.push((fraction, prime));
            }
        }
        by_exponent.put_in_order();
        for alike in by_exponent.chunk_by(|a, b| a.0 == b.0) {
            let base = self.number(alike.iter().fold(Number::ONE, |base, (_, prime)| base.mul(prime)));
            work.settled.push((base, alike[0].0.clone()));
        }
        work.settled.order_by_key(|(base, _)| *base);
        Ok(())
    }
}

/// 1 or -1, as the number is negative or not.
fn sign(number: &Number) -> Number {
    if number.is_negative() { Number::MINUS_ONE } else { Number::ONE }
}

/// Multiplies by `value^exponent`; the part that is not rational goes to the roots.
fn multiply_number(value: &Number, exponent: &Number, work: &mut Workspace) -> Result<(), NoValue> {
    if value.is_one() {
        return Ok(());
    }
    if exponent.is_integer() {
        return multiply_whole_power(value, exponent, &mut work.coefficient);
    }
    if value.is_negative() || (value.is_zero() && exponent.is_negative()) {
        return Err(NoValue::Undefined);
    }
    if value.is_zero() {
        work.coefficient = Number::ZERO;
        return Ok(());
    }
    for (part, sign) in [
        (Number::from_integer(value.numerator()), Number::ONE),
        (Number::from_integer(value.denominator().into()), Number::MINUS_ONE),
    ] {
        for factor in part.factors() {
            let multiplicity = Number::from(i64::from(factor.multiplicity));
            let exponent = exponent.mul(&sign).mul(&multiplicity);
            work.roots.push((factor.base, exponent));
        }
    }
    Ok(())
}

/// Multiplies by a whole power of a number.
fn multiply_whole_power(value: &Number, exponent: &Number, coefficient: &mut Number) -> Result<(), NoValue> {
    let power = if exponent.is_one() {
        value.clone()
    } else if value.is_zero() && !exponent.is_negative() {
        Number::ZERO
    } else if value.abs().is_one() {
        if exponent.is_even() { Number::ONE } else { Number::MINUS_ONE }
    } else {
        let exponent = exponent.to_i64().and_then(|e| i32::try_from(e).ok()).ok_or(NoValue::TooLong)?;
        let no_value = if value.is_zero() { NoValue::Undefined } else { NoValue::TooLong };
        value.powi(exponent).ok_or(no_value)?
    };
    *coefficient = coefficient.mul(&power);
    if coefficient.is_oversized() { Err(NoValue::TooLong) } else { Ok(()) }
}
