//! Definite integrals of sums of powers times exponentials: polynomials, sines, cosines, exponential and hyperbolic
//! functions of linear arguments, and their products, all as real parts of c·x^n·exp(r·x) with complex c and r.

use std::collections::{BTreeMap, BTreeSet};

use hashbrown::HashMap;

use super::{ExprId, Function, Node, ONE, Pool, Symbol, ZERO};
use crate::number::Number;
use crate::order::Gather;

/// More terms than this are not multiplied out.
const MOST_TERMS: usize = 1 << 20;

/// x^power·exp(rate·x); real and imaginary part of the rate, the latter never with a minus sign in front.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Form {
    power: u32,
    rate: [ExprId; 2],
}

const CONSTANT: Form = Form { power: 0, rate: [ZERO; 2] };

/// A real number, or the parts of a complex one.
type Factor = [ExprId; 2];

/// The real part of a sum of powers of a variable times exponentials, with factors that are constant in it.
#[derive(Clone, Debug, Default)]
pub struct Exponentials(BTreeMap<Form, Factor>);

/// Terms before those of one form are added.
type Gathered = BTreeMap<Form, [Vec<ExprId>; 2]>;

fn times(pool: &mut Pool, [a, b]: Factor, [c, d]: Factor) -> Factor {
    let [ac, bd, ad, bc] = [(a, c), (b, d), (a, d), (b, c)].map(|(x, y)| pool.mul(x, y));
    [pool.sub(ac, bd), pool.add(ad, bc)]
}

/// Adds a term: a complex number and its conjugate have the same real part, and a real form leaves nothing of i.
fn gather(pool: &mut Pool, sum: &mut Gathered, mut form: Form, [re, mut im]: Factor) {
    if pool.leads_negative(form.rate[1]) {
        form.rate[1] = pool.neg(form.rate[1]);
        im = pool.neg(im);
    }
    let parts = sum.entry(form).or_default();
    parts[0].push(re);
    if form.rate[1] != ZERO {
        parts[1].push(im);
    }
}

impl Exponentials {
    fn of_gathered(pool: &mut Pool, sum: Gathered) -> Self {
        let added = sum.into_iter().map(|(form, parts)| (form, parts.map(|terms| pool.sum(&terms))));
        Self(added.filter(|(_, factor)| *factor != [ZERO; 2]).gather())
    }

    /// An expression as such a function of a variable, or a part of it that is none.
    ///
    /// # Errors
    /// The part.
    pub(crate) fn of(pool: &mut Pool, e: ExprId, variable: Symbol) -> Result<Self, ExprId> {
        let mut known: HashMap<ExprId, Self> = HashMap::new();
        for id in pool.reachable(&[e]) {
            let node = pool.node(id).clone();
            let mut depends = node == Node::Symbol(variable);
            node.for_each_child(|child| depends |= known.contains_key(&child));
            if !depends {
                continue;
            }
            let part = |id: ExprId| known.get(&id).cloned().unwrap_or_else(|| Self([(CONSTANT, [id, ZERO])].into()));
            let own = match node {
                Node::Symbol(_) => Self([(Form { power: 1, ..CONSTANT }, [ONE, ZERO])].into()),
                Node::Sum { constant, terms } => {
                    let mut sum = Gathered::new();
                    let constant = pool.number(constant);
                    gather(pool, &mut sum, CONSTANT, [constant, ZERO]);
                    for (term, coefficient) in terms {
                        for (form, factor) in part(term).0 {
                            let factor = factor.map(|x| pool.scale(x, &coefficient));
                            gather(pool, &mut sum, form, factor);
                        }
                    }
                    Self::of_gathered(pool, sum)
                }
                Node::Product(factors) => {
                    let mut product = part(ONE);
                    for (base, exponent) in factors {
                        let power = part(base).raised(pool, &exponent);
                        product = match power.map(|power| product.multiplied(pool, &power)) {
                            Some(Some(product)) => product,
                            _ => return Err(pool.product_of_powers(&[(base, exponent)])),
                        };
                    }
                    product
                }
                Node::Function(function, argument) => part(argument).applied(pool, function).ok_or(id)?,
                Node::Number(_) | Node::Pi | Node::Power { .. } | Node::Atan2 { .. } | Node::Undefined => {
                    return Err(id);
                }
            };
            known.insert(id, own);
        }
        Ok(known.remove(&e).unwrap_or_else(|| Self([(CONSTANT, [e, ZERO])].into())))
    }

    /// None where it has too many terms.
    fn multiplied(&self, pool: &mut Pool, other: &Self) -> Option<Self> {
        if self.0.len().saturating_mul(other.0.len()) > MOST_TERMS {
            return None;
        }
        let mut sum = Gathered::new();
        for (f, u) in &self.0 {
            for (g, v) in &other.0 {
                let growth = pool.add(f.rate[0], g.rate[0]);
                let power = f.power.checked_add(g.power)?;
                let wave = pool.add(f.rate[1], g.rate[1]);
                let product = times(pool, *u, *v);
                let form = Form { power, rate: [growth, wave] };
                if f.rate[1] == ZERO || g.rate[1] == ZERO {
                    gather(pool, &mut sum, form, product);
                    continue;
                }
                // Re(a) Re(b) = Re(a b + a b*)/2
                let half = Number::half();
                let product = product.map(|x| pool.scale(x, &half));
                gather(pool, &mut sum, form, product);
                let opposite = [v[0], pool.neg(v[1])];
                let product = times(pool, *u, opposite).map(|x| pool.scale(x, &half));
                let wave = pool.sub(f.rate[1], g.rate[1]);
                gather(pool, &mut sum, Form { power, rate: [growth, wave] }, product);
            }
        }
        Some(Self::of_gathered(pool, sum))
    }

    /// A whole power; a negative one of what is constant or a lone real exponential.
    fn raised(self, pool: &mut Pool, exponent: &Number) -> Option<Self> {
        let (mut rest, mut base) = (exponent.to_i64(), self);
        if let [(form, [factor, _])] = base.0.iter().collect::<Vec<_>>()[..] {
            if *form == CONSTANT {
                return Some(Self([(CONSTANT, [pool.powr(*factor, exponent), ZERO])].into()));
            }
            if form.power == 0 && form.rate[1] == ZERO {
                let form = Form { power: 0, rate: [pool.scale(form.rate[0], exponent), ZERO] };
                return Some(Self([(form, [pool.powr(*factor, exponent), ZERO])].into()));
            }
        }
        let mut power = Self([(CONSTANT, [ONE, ZERO])].into());
        while let Some(left) = rest.filter(|left| *left != 0) {
            if left < 0 {
                return None;
            }
            if left % 2 == 1 {
                power = power.multiplied(pool, &base)?;
            }
            rest = Some(left / 2);
            if left > 1 {
                base = base.multiplied(pool, &base)?;
            }
        }
        rest.map(|_| power)
    }

    /// A function of what is linear in the variable.
    fn applied(&self, pool: &mut Pool, function: Function) -> Option<Self> {
        if self.0.keys().any(|form| form.power > 1 || form.rate != [ZERO; 2]) {
            return None;
        }
        let coefficient = |power| self.0.get(&Form { power, ..CONSTANT }).map_or(ZERO, |factor| factor[0]);
        let (rate, phase) = (coefficient(1), coefficient(0));
        let mut sum = Gathered::new();
        match function {
            Function::Sin | Function::Cos => {
                let (sine, cosine) = (pool.sin(phase), pool.cos(phase));
                let factor = if function == Function::Cos { [cosine, sine] } else { [sine, pool.neg(cosine)] };
                gather(pool, &mut sum, Form { power: 0, rate: [ZERO, rate] }, factor);
            }
            Function::Exp => {
                let factor = pool.apply(Function::Exp, phase);
                gather(pool, &mut sum, Form { power: 0, rate: [rate, ZERO] }, [factor, ZERO]);
            }
            Function::Sinh | Function::Cosh => {
                let half = Number::half();
                let other = if function == Function::Cosh { half.clone() } else { half.neg() };
                for (sign, share) in [(Number::ONE, half), (Number::MINUS_ONE, other)] {
                    let [rate, phase] = [rate, phase].map(|x| pool.scale(x, &sign));
                    let factor = pool.apply(Function::Exp, phase);
                    let factor = pool.scale(factor, &share);
                    gather(pool, &mut sum, Form { power: 0, rate: [rate, ZERO] }, [factor, ZERO]);
                }
            }
            Function::Tan
            | Function::Asin
            | Function::Acos
            | Function::Atan
            | Function::Tanh
            | Function::Ln
            | Function::Abs => return None,
        }
        Some(Self::of_gathered(pool, sum))
    }

    /// The parts of rates of which an integral has to know whether they are 0.
    pub(crate) fn rates(&self) -> BTreeSet<ExprId> {
        self.0.keys().flat_map(|form| form.rate).filter(|rate| *rate != ZERO).gather()
    }

    /// The integral between two bounds; `vanishes` says of rates whether they are 0, if that is known.
    ///
    /// # Errors
    /// A rate of which it would have to be known.
    pub(crate) fn integral(
        &self,
        pool: &mut Pool,
        bounds: [ExprId; 2],
        vanishes: impl Fn(ExprId) -> Option<bool>,
    ) -> Result<ExprId, ExprId> {
        let mut terms = Vec::new();
        for (form, factor) in &self.0 {
            let [growth, wave] = form.rate.map(|rate| if vanishes(rate) == Some(true) { ZERO } else { rate });
            let Form { power, .. } = *form;
            // Coefficients of the antiderivative, of falling powers: integrated by parts.
            let mut coefficients: Vec<(u32, Factor)> = Vec::new();
            if [growth, wave] == [ZERO; 2] {
                let share = Number::ONE.div(&Number::from(i64::from(power) + 1)).unwrap_or(Number::ONE);
                coefficients.push((power + 1, [pool.scale(factor[0], &share), ZERO]));
            } else {
                let inverse = match [growth, wave] {
                    _ if ![growth, wave].map(&vanishes).contains(&Some(false)) => {
                        return Err(if wave == ZERO { growth } else { wave });
                    }
                    [ZERO, _] => [ZERO, pool.div(super::MINUS_ONE, wave)],
                    [_, ZERO] => [pool.div(ONE, growth), ZERO],
                    both => {
                        let squares = both.map(|x| pool.square(x));
                        let size = pool.sum(&squares);
                        let opposite = pool.neg(wave);
                        [pool.div(growth, size), pool.div(opposite, size)]
                    }
                };
                let mut own = *factor;
                for left in (0..=power).rev() {
                    own = times(pool, own, inverse);
                    coefficients.push((left, own));
                    own = own.map(|x| pool.scale(x, &Number::from(-i64::from(left))));
                }
            }
            for (sign, at) in [(Number::ONE, bounds[1]), (Number::MINUS_ONE, bounds[0])] {
                let [growth, angle] = [growth, wave].map(|rate| pool.mul(rate, at));
                let size = pool.apply(Function::Exp, growth);
                let (sine, cosine) = (pool.sin(angle), pool.cos(angle));
                for (power, [re, im]) in &coefficients {
                    let parts = [(*re, cosine, sign.clone()), (*im, sine, sign.neg())];
                    for (factor, wave, sign) in parts {
                        let along = pool.powi(at, i64::from(*power));
                        let term = pool.product(&[factor, along, size, wave]);
                        terms.push((term, sign));
                    }
                }
            }
        }
        Ok(pool.linear(&terms))
    }
}
