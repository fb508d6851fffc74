//! The value of expressions at a point modulo a prime.
//!
//! Symbols take the values they are given; what the field does not have is drawn from a seed,
//! the same on every machine:
//!
//! - sin, cos and tan of sums of angles: an element z stands for exp(i*theta) of each angle,
//!   the same for equal angles, so that addition theorems hold; exp and the hyperbolic functions
//!   alike. Multiples of pi are roots of unity. Arc functions under them are undone.
//! - roots of numbers are true and consistent with those roots of unity. Other square roots are
//!   true with a sign that is random at each point; where there is no root modulo p, a random
//!   element replaces it, and a point that fails so proves nothing.
//! - everything else (logarithms, arc functions, powers with symbolic exponents) is a random
//!   function of its arguments' values.

use std::collections::BTreeSet;

use super::modular::{root_of_unity, sqrt_of_prime};
use super::traverse::Reachable;
use super::{
    ExprId, Function, Node, ONE, PI, PRIME, Pool, Symbol, add_mod, inverse_mod, mul_mod, neg_mod, pow_mod, sqrt_mod,
    sub_mod,
};
use crate::number::{Number, gcd64};

/// How far the values at a point are those of the expressions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Certainty {
    /// A square root got a random sign.
    pub random_sign: bool,
    /// A root does not exist modulo the prime and was replaced by a random value.
    pub missing_root: bool,
    /// A function was replaced by a random function of its arguments.
    pub random_function: bool,
    /// Angles or exponents may depend on each other in a way that is not taken account of.
    pub dependent_angles: bool,
    /// A root was taken of something that vanishes at this point, which it may do for one choice of
    /// signs only, while for the other the root does not exist.
    pub vanishing_root: bool,
}

impl Certainty {
    /// Whether a value that is not 0 shows that the expression is not.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        *self == Certainty::default()
    }
}

/// The values of expressions at a point modulo [`PRIME`].
#[derive(Clone, Debug)]
pub struct ModularPoint {
    /// The values of the roots, below [`PRIME`].
    pub values: Vec<u64>,
    /// How far they are true.
    pub certainty: Certainty,
}

impl ModularPoint {
    /// A pseudo-random value below [`PRIME`], not 0, for a symbol at the point of this seed.
    #[must_use]
    pub fn random_value(seed: u64, symbol: Symbol) -> u64 {
        random(seed, Tag::Symbol, symbol.index() as u64, 0)
    }
}

/// Points at which something has to be so where signs are random: each fails with probability 1/2 if it depends on the sign.
pub(super) const POINTS_SIGNS: usize = 24;
/// Points that are tried, and those after which roots that exist at all of them are not expected.
pub(super) const ATTEMPTS: u64 = 200;
const HOPELESS: usize = 32;
/// What is a square at so many points is taken for one everywhere.
const OFTEN: usize = 12;

/// Common denominators of angles up to here are taken account of.
const MAX_DENOMINATOR: u64 = 1 << 40;

/// What a random element stands for, beside functions.
#[derive(Clone, Copy)]
pub(super) enum Tag {
    Symbol = 1,
    Pi,
    Angle,
    Exponent,
    Sign,
    Root,
    Atan2,
    Power,
}

/// A pseudo-random element, not 0 (splitmix64 of everything it depends on).
pub(super) fn random(seed: u64, tag: Tag, a: u64, b: u64) -> u64 {
    drawn(seed, [tag as u64, a, b])
}

fn drawn(seed: u64, words: [u64; 3]) -> u64 {
    let state = words.into_iter().fold(seed ^ 0x6a09_e667_f3bc_c908, |state, word| mix(state ^ word));
    1 + state % (PRIME - 1)
}

/// The finalizer of SplitMix64 (Steele, Lea and Flood, 2014): every bit depends on every bit.
pub(crate) fn mix(state: u64) -> u64 {
    let mut z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The residue of a number; `None` where p divides the denominator, or the numerator of one that is not 0.
pub(super) fn residue(value: &Number) -> Option<u64> {
    let residue = match value.to_i64() {
        Some(small) => {
            let magnitude = small.unsigned_abs() % PRIME;
            if small < 0 { neg_mod(magnitude) } else { magnitude }
        }
        None => value.mod_prime(PRIME)?,
    };
    (residue != 0 || value.is_zero()).then_some(residue)
}

/// Primes below this are told apart, and their roots are those of the roots of unity.
const SMALL_PRIMES: u64 = 1000;
/// Radicands in which more large factors occur get roots of random signs.
const MOST_LARGE_FACTORS: usize = 100;

/// The factors of whole numbers below square roots that are no small primes, pairwise coprime and none of them a power: then
/// their roots are independent. `None` where there are too many of them.
fn coprime(mut open: Vec<Number>) -> Option<Vec<Number>> {
    let mut bases: Vec<Number> = Vec::new();
    while let Some(number) = open.pop() {
        let shared = |base: &Number| Some(base.gcd(&number)).filter(|common| !common.is_one());
        let Some((at, common)) = bases.iter().enumerate().find_map(|(at, base)| Some((at, shared(base)?))) else {
            if bases.len() == MOST_LARGE_FACTORS {
                return None;
            }
            bases.push(number);
            continue;
        };
        if bases[at] == number {
            continue;
        }
        let over = common.recip()?;
        let parts = [bases.swap_remove(at).mul(&over), number.mul(&over), common];
        open.extend(parts.iter().flat_map(Number::factors).map(|factor| factor.base));
    }
    Some(bases)
}

impl Pool {
    /// The values of the roots modulo [`PRIME`], each below it; `None` where a denominator
    /// vanishes at the point. What the point does not determine (roots, functions) is drawn from
    /// the seed.
    pub fn evaluate_mod(&self, roots: &[ExprId], values: impl Fn(Symbol) -> u64, seed: u64) -> Option<Vec<u64>> {
        self.modular_point(roots, values, seed).map(|point| point.values)
    }

    /// The same at a random point, one of many by its number; where a denominator vanishes another is tried.
    pub(crate) fn evaluate_at_random(&self, roots: &[ExprId], number: u64) -> Option<Vec<u64>> {
        (0..4).find_map(|attempt| {
            let seed = number.wrapping_mul(4).wrapping_add(attempt);
            self.evaluate_mod(roots, |symbol| ModularPoint::random_value(seed, symbol), seed)
        })
    }

    /// The same at so many random points that what is so at all of them is so for certain, and what is not so at one of them is not
    /// known: one point, or many with other signs of roots at each. Points without a root that does not exist, if there are such.
    pub(crate) fn points_at_random(&self, roots: &[ExprId], number: u64) -> impl Iterator<Item = Vec<u64>> {
        let plan = Plan::new(self, roots);
        let is_single = plan.has_a_single_root(self);
        let mut points = (0..ATTEMPTS).filter_map(move |attempt| {
            let seed = number.wrapping_mul(ATTEMPTS).wrapping_add(attempt);
            plan.evaluate(self, &|symbol| ModularPoint::random_value(seed, symbol), seed)
        });
        // The root of what is no square, and there is no other, is as good with one sign as with the other.
        let (mut first, mut exists, mut is_square) = (Vec::new(), false, true);
        while !exists || is_single && is_square && first.len() < OFTEN {
            let Some(point) = points.next().filter(|_| first.len() < HOPELESS) else { break };
            exists |= !point.certainty.missing_root;
            is_square &= !point.certainty.missing_root;
            first.push(point);
        }
        let is_open = !is_single || is_square;
        let is_known = move |own: Certainty| !(own.random_sign && is_open || own.missing_root || own.vanishing_root);
        let full = first.into_iter().chain(points).filter(move |own| !(exists && own.certainty.missing_root));
        let mut ended = false;
        full.map_while(move |own| (!std::mem::replace(&mut ended, is_known(own.certainty))).then_some(own.values))
            .take(POINTS_SIGNS)
    }

    /// As [`Pool::evaluate_mod`], with how far the values are those of the expressions.
    pub fn modular_point(&self, roots: &[ExprId], values: impl Fn(Symbol) -> u64, seed: u64) -> Option<ModularPoint> {
        Plan::new(self, roots).evaluate(self, &values, seed)
    }
}

/// What does not change from point to point.
pub(super) struct Plan {
    roots: Vec<ExprId>,
    reachable: Reachable,
    /// Common denominator of the coefficients in angles, and in exponents.
    pub(super) angle_denominator: u64,
    pub(super) exponent_denominator: u64,
    /// Whether one of them is beyond bounds.
    pub(super) coarse: bool,
    /// What large factors below square roots are made of, where one of them may be no prime.
    large_factors: Option<Vec<Number>>,
}

impl Plan {
    /// Whether roots are taken of one expression alone, and it is no number.
    fn has_a_single_root(&self, pool: &Pool) -> bool {
        let mut bases = BTreeSet::new();
        for id in &self.reachable.ids {
            match pool.node(*id) {
                Node::Product(factors) => {
                    let roots = factors.iter().filter(|(_, exponent)| !exponent.is_integer());
                    bases.extend(roots.map(|(base, _)| *base).filter(|base| pool.as_number(*base).is_none()));
                }
                Node::Function(Function::Abs, _) => return false,
                _ => {}
            }
        }
        bases.len() == 1
    }

    pub(super) fn new(pool: &Pool, roots: &[ExprId]) -> Plan {
        let mut plan = Plan {
            roots: roots.to_vec(),
            reachable: pool.reachable_places(roots),
            angle_denominator: 1,
            exponent_denominator: 1,
            coarse: false,
            large_factors: Some(Vec::new()),
        };
        let mut large = Vec::new();
        for id in &plan.reachable.ids {
            if let Node::Product(factors) = pool.node(*id) {
                let roots = factors.iter().filter(|(_, exponent)| !exponent.is_integer());
                let numbers = roots.filter_map(|(base, _)| pool.as_number(*base)).flat_map(Number::factors);
                large.extend(numbers.map(|factor| factor.base).filter(|base| !is_small(base, SMALL_PRIMES)));
            }
            let Node::Function(function, x) = pool.node(*id) else { continue };
            let denominator = match Kind::of(*function) {
                Some(Kind::Circular) => &mut plan.angle_denominator,
                Some(Kind::Hyperbolic) => &mut plan.exponent_denominator,
                None => continue,
            };
            let mut include = |value: &Number| match value.small_parts().and_then(|(_, d)| lcm(*denominator, d)) {
                Some(lcm) => *denominator = lcm,
                None => plan.coarse = true,
            };
            pool.as_number(*x).into_iter().for_each(&mut include);
            pool.terms(*x).iter().filter(|(term, _)| *term != PI).for_each(|(_, c)| include(c));
        }
        // Below the square of the limit of trial division all of them are primes.
        if large.iter().any(|base| !is_small(base, SMALL_PRIMES * SMALL_PRIMES)) {
            plan.large_factors = coprime(large);
        }
        plan
    }

    pub(super) fn evaluate(&self, pool: &Pool, values: &dyn Fn(Symbol) -> u64, seed: u64) -> Option<ModularPoint> {
        let room = Vec::with_capacity(self.reachable.ids.len());
        let mut point = Point { pool, plan: self, seed, values: room, certainty: Certainty::default() };
        for id in &self.reachable.ids {
            let value = point.value_of(*id, values)?;
            point.values.push(value);
        }
        let values = self.roots.iter().map(|root| point.value(*root)).collect();
        Some(ModularPoint { values, certainty: point.certainty })
    }
}

/// Whether a whole number is below a limit.
fn is_small(number: &Number, limit: u64) -> bool {
    number.to_i64().is_some_and(|own| own.unsigned_abs() < limit)
}

fn lcm(a: u64, b: u64) -> Option<u64> {
    (a / gcd64(a, b).max(1)).checked_mul(b).filter(|lcm| *lcm <= MAX_DENOMINATOR)
}

/// Which exponential a function is made of.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// exp(i*theta)
    Circular,
    /// exp(x)
    Hyperbolic,
}

impl Kind {
    fn of(function: Function) -> Option<Kind> {
        match function {
            Function::Sin | Function::Cos | Function::Tan => Some(Kind::Circular),
            Function::Sinh | Function::Cosh | Function::Tanh | Function::Exp => Some(Kind::Hyperbolic),
            Function::Asin | Function::Acos | Function::Atan | Function::Ln | Function::Abs => None,
        }
    }
}

pub(super) struct Point<'a> {
    pub(super) pool: &'a Pool,
    pub(super) plan: &'a Plan,
    pub(super) seed: u64,
    /// By place among the reachable expressions.
    values: Vec<u64>,
    pub(super) certainty: Certainty,
}

impl Point<'_> {
    /// The value of an expression that was evaluated before.
    pub(super) fn value(&self, id: ExprId) -> u64 {
        self.values.get(self.plan.reachable.place(id)).copied().unwrap_or(0)
    }

    fn value_of(&mut self, id: ExprId, symbols: &dyn Fn(Symbol) -> u64) -> Option<u64> {
        let pool = self.pool;
        match pool.node(id) {
            Node::Number(value) => residue(value),
            Node::Pi => Some(random(self.seed, Tag::Pi, 0, 0)),
            Node::Symbol(symbol) => Some(symbols(*symbol) % PRIME),
            Node::Sum { constant, terms } => terms.iter().try_fold(residue(constant)?, |sum, (term, coefficient)| {
                Some(add_mod(sum, mul_mod(residue(coefficient)?, self.value(*term))))
            }),
            Node::Product(factors) => factors.iter().try_fold(1, |product, (base, exponent)| {
                let power = self.power(*base, exponent)?;
                Some(mul_mod(product, power))
            }),
            Node::Power { base, exponent } => self.general_power(*base, *exponent),
            Node::Function(function, x) => self.function(*function, *x),
            Node::Atan2 { y, x } => {
                self.certainty.random_function = true;
                Some(random(self.seed, Tag::Atan2, self.value(*y), self.value(*x)))
            }
            Node::Undefined => None,
        }
    }

    /// A power with a rational exponent.
    pub(super) fn power(&mut self, base: ExprId, exponent: &Number) -> Option<u64> {
        let value = self.value(base);
        let Some((numerator, denominator)) = exponent.small_parts() else {
            self.certainty.random_function = true;
            return Some(random(self.seed, Tag::Power, value, residue(exponent)?));
        };
        let root = if denominator == 1 {
            value
        } else if let Some(number) = self.pool.as_number(base) {
            self.root_of_number(number, denominator)?
        } else {
            self.root(value, denominator)
        };
        signed_power(root, numerator)
    }

    /// The square root (or a higher one) of a value that is not a number's.
    pub(super) fn root(&mut self, value: u64, degree: u64) -> u64 {
        self.certainty.vanishing_root |= value == 0;
        let mut root = value;
        let mut rest = degree;
        while rest.is_multiple_of(2) {
            let Some(next) = sqrt_mod(root) else {
                self.certainty.missing_root = true;
                return random(self.seed, Tag::Root, value, degree);
            };
            let minus = random(self.seed, Tag::Sign, root, 0) & 1 == 1;
            self.certainty.random_sign = true;
            root = if minus { neg_mod(next) } else { next };
            rest /= 2;
        }
        if rest > 1 {
            self.certainty.random_function = true;
            root = random(self.seed, Tag::Root, root, rest);
        }
        root
    }

    /// A root of a positive whole number, multiplicative in its prime factors.
    fn root_of_number(&mut self, number: &Number, degree: u64) -> Option<u64> {
        let mut root = 1;
        for factor in number.factors() {
            let is_small = is_small(&factor.base, SMALL_PRIMES);
            let power = u64::from(factor.multiplicity);
            let share = match &self.plan.large_factors {
                Some(large) if degree == 2 && !is_small && !large.is_empty() => {
                    self.root_of_product(&factor.base, large, power)?
                }
                None if degree == 2 && !is_small => pow_mod(self.root(residue(&factor.base)?, degree), power),
                Some(_) | None => pow_mod(self.root_of_factor(&factor.base, degree)?, power),
            };
            root = mul_mod(root, share);
        }
        Some(root)
    }

    /// A power of the square root of a product of some numbers without common factors.
    fn root_of_product(&mut self, product: &Number, factors: &[Number], power: u64) -> Option<u64> {
        let mut rest = product.clone();
        let mut root = 1;
        for own in factors {
            let over = own.recip()?;
            let mut times = 0;
            while let Some(quotient) = Some(rest.mul(&over)).filter(Number::is_integer) {
                rest = quotient;
                times += power;
            }
            root = mul_mod(root, pow_mod(residue(own)?, times / 2));
            if times % 2 == 1 {
                root = mul_mod(root, self.root_of_factor(own, 2)?);
            }
        }
        Some(root)
    }

    /// A root of a prime, or of one of several numbers without common factors.
    fn root_of_factor(&mut self, factor: &Number, degree: u64) -> Option<u64> {
        let value = residue(factor)?;
        // Different primes have independent roots (but for those roots of unity), so that any
        // sign is as good as the true one.
        let root = match (degree, factor.small_parts()) {
            (2, Some((q, _))) if is_small(factor, SMALL_PRIMES) => {
                sqrt_of_prime(q.unsigned_abs()).or_else(|| sqrt_mod(value))
            }
            (2, _) => sqrt_mod(value),
            (_, _) => None,
        };
        Some(root.unwrap_or_else(|| {
            self.certainty.random_function = true;
            random(self.seed, Tag::Root, value, degree)
        }))
    }

    /// A power with an exponent that is not a number: the whole part of the exponent is taken
    /// out, the rest is a random function of both values.
    fn general_power(&mut self, base: ExprId, exponent: ExprId) -> Option<u64> {
        self.certainty.random_function = true;
        let b = self.value(base);
        let mut product = 1;
        for (term, coefficient) in self.pool.terms(exponent) {
            // The constant is a multiple of 1, which may have no place among what is evaluated.
            let value = if term == ONE { 1 } else { self.value(term) };
            let factor = match coefficient.to_i64() {
                Some(whole) if term == ONE => signed_power(b, whole)?,
                Some(whole) => signed_power(random(self.seed, Tag::Power, b, value), whole)?,
                None => random(self.seed, Tag::Power, b, mul_mod(value, residue(&coefficient)?)),
            };
            product = mul_mod(product, factor);
        }
        Some(product)
    }

    fn function(&mut self, function: Function, x: ExprId) -> Option<u64> {
        match function {
            Function::Sin => Some(self.sine_and_cosine(x)?.0),
            Function::Cos => Some(self.sine_and_cosine(x)?.1),
            Function::Tan => quotient(self.sine_and_cosine(x)?),
            Function::Exp => self.exponential(Kind::Hyperbolic, x),
            Function::Sinh => Some(self.hyperbolic_sine_and_cosine(x)?.0),
            Function::Cosh => Some(self.hyperbolic_sine_and_cosine(x)?.1),
            Function::Tanh => quotient(self.hyperbolic_sine_and_cosine(x)?),
            // The root of the square, with the sign that root has everywhere.
            Function::Abs => {
                let value = self.value(x);
                Some(self.root(mul_mod(value, value), 2))
            }
            Function::Asin | Function::Acos | Function::Atan | Function::Ln => {
                self.certainty.random_function = true;
                Some(drawn(self.seed, [16 + function as u64, self.value(x), 0]))
            }
        }
    }

    /// (z - 1/z)/(2i) and (z + 1/z)/2 with z for exp(i*x).
    fn sine_and_cosine(&mut self, x: ExprId) -> Option<(u64, u64)> {
        let z = self.exponential(Kind::Circular, x)?;
        let over_i = neg_mod(root_of_unity(4)?);
        let (sine, cosine) = half_difference_and_sum(z)?;
        Some((mul_mod(sine, over_i), cosine))
    }

    fn hyperbolic_sine_and_cosine(&mut self, x: ExprId) -> Option<(u64, u64)> {
        half_difference_and_sum(self.exponential(Kind::Hyperbolic, x)?)
    }
}

fn quotient((above, below): (u64, u64)) -> Option<u64> {
    Some(mul_mod(above, inverse_mod(below)?))
}

/// (w - 1/w)/2 and (w + 1/w)/2.
fn half_difference_and_sum(w: u64) -> Option<(u64, u64)> {
    let half = PRIME.div_ceil(2);
    let inverse = inverse_mod(w)?;
    Some((mul_mod(half, sub_mod(w, inverse)), mul_mod(half, add_mod(w, inverse))))
}

/// A whole power; `None` of a negative one of 0.
pub(super) fn signed_power(base: u64, exponent: i64) -> Option<u64> {
    // Exponents count modulo p - 1; of 0 only the sign matters.
    if exponent < 0 {
        return Some(pow_mod(inverse_mod(base)?, exponent.unsigned_abs()));
    }
    Some(pow_mod(base, exponent.unsigned_abs()))
}
