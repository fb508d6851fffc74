//! Whether an expression is identically 0, tested at random points modulo a prime.
//!
//! Every expression is evaluated in the field of [`super::modular`], symbols taking
//! pseudo-random values (the same on every machine). A rational function that vanishes at a few
//! such points is 0 but for a probability of about degree/p each. Other functions:
//!
//! - sin, cos and tan of sums of angles: an element z stands for exp(i*theta) of each angle,
//!   the same for equal angles, so that addition theorems hold; exp and the hyperbolic functions
//!   alike. Multiples of pi are roots of unity. Arc functions under them are undone.
//! - roots of numbers are true and consistent with those roots of unity. Other square roots are
//!   true with a sign that is random at each point; where there is no root modulo p, a random
//!   element replaces it, and a point that fails so proves nothing.
//! - everything else (logarithms, arc functions, powers with symbolic exponents) is a random
//!   function of its arguments' values.
//!
//! An identity that holds for arbitrary functions and signs holds for the true ones, so that
//! [`ZeroVerdict::Zero`] stands; that something is not 0 is only said where nothing was
//! replaced.

use super::modular::{root_of_unity, sqrt_of_prime};
use super::traverse::ExprMap;
use super::{
    ExprId, Function, Node, PI, PRIME, Pool, Symbol, ZERO, add_mod, inverse_mod,
    mul_mod, neg_mod, pow_mod, sqrt_mod, sub_mod,
};
use crate::number::Number;

/// What is known about whether an expression is identically 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZeroVerdict {
    /// It is 0 wherever it has a value (but for a probability below 1e-6, in practice far below).
    Zero,
    /// It is not 0.
    NonZero,
    /// Undecided.
    Unknown,
}

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

/// Points that have to vanish where nothing is random.
const POINTS_EXACT: u32 = 4;
/// Points that have to vanish where signs are random: each fails with probability 1/2 if the
/// identity depends on the sign.
const POINTS_SIGNS: u32 = 24;
/// Points that are tried.
const ATTEMPTS: u64 = 200;
/// Common denominators of angles up to here are taken account of.
const MAX_DENOMINATOR: u64 = 1 << 40;
/// Monomials up to which the product of sums in an angle is multiplied out.
const MAX_MONOMIALS: usize = 256;

#[derive(Clone, Copy)]
enum Tag {
    Symbol,
    Pi,
    Angle,
    Exponent,
    Sign,
    Root,
    Function(Function),
    Atan2,
    Power,
}

/// A pseudo-random element, not 0 (splitmix64 of everything it depends on).
fn random(seed: u64, tag: Tag, a: u64, b: u64) -> u64 {
    let tag = match tag {
        Tag::Symbol => 1,
        Tag::Pi => 2,
        Tag::Angle => 3,
        Tag::Exponent => 4,
        Tag::Sign => 5,
        Tag::Root => 6,
        Tag::Atan2 => 7,
        Tag::Power => 8,
        Tag::Function(function) => 16 + function as u64,
    };
    let mut state = seed ^ 0x6a09_e667_f3bc_c908;
    for word in [tag, a, b] {
        state = mix(state ^ word);
    }
    1 + state % (PRIME - 1)
}

fn mix(state: u64) -> u64 {
    let mut z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The residue of a number; `None` where p divides the denominator.
fn residue(value: &Number) -> Option<u64> {
    match value.to_i64() {
        Some(small) => {
            let magnitude = small.unsigned_abs() % PRIME;
            Some(if small < 0 { neg_mod(magnitude) } else { magnitude })
        }
        None => value.mod_prime(PRIME),
    }
}

impl Pool {
    /// Whether the expression is identically 0; see the module's documentation for what is
    /// decided.
    #[must_use]
    pub fn is_zero(&self, root: ExprId) -> ZeroVerdict {
        if root == ZERO {
            return ZeroVerdict::Zero;
        }
        match self.node(root) {
            Node::Number(_) | Node::Pi | Node::Symbol(_) => return ZeroVerdict::NonZero,
            Node::Undefined => return ZeroVerdict::Unknown,
            Node::Sum { .. }
            | Node::Product(_)
            | Node::Power { .. }
            | Node::Function(..)
            | Node::Atan2 { .. } => {}
        }
        let plan = Plan::new(self, &[root]);
        let mut zeros = 0;
        for seed in 0..ATTEMPTS {
            let values = |symbol| ModularPoint::random_value(seed, symbol);
            let Some(point) = plan.evaluate(self, &values, seed) else {
                continue;
            };
            let certainty = point.certainty;
            if point.values.first() == Some(&0) {
                zeros += 1;
                let enough = if certainty.random_sign || certainty.missing_root {
                    POINTS_SIGNS
                } else {
                    POINTS_EXACT
                };
                if zeros >= enough {
                    return ZeroVerdict::Zero;
                }
            } else if certainty.is_exact() {
                return ZeroVerdict::NonZero;
            } else if !certainty.missing_root {
                return ZeroVerdict::Unknown;
            }
        }
        ZeroVerdict::Unknown
    }

    /// The values of the roots modulo [`PRIME`], each below it; `None` where a denominator
    /// vanishes at the point. What the point does not determine (roots, functions) is drawn from
    /// the seed.
    pub fn evaluate_mod(
        &self,
        roots: &[ExprId],
        values: impl Fn(Symbol) -> u64,
        seed: u64,
    ) -> Option<Vec<u64>> {
        self.modular_point(roots, values, seed).map(|point| point.values)
    }

    /// As [`Pool::evaluate_mod`], with how far the values are those of the expressions.
    pub fn modular_point(
        &self,
        roots: &[ExprId],
        values: impl Fn(Symbol) -> u64,
        seed: u64,
    ) -> Option<ModularPoint> {
        Plan::new(self, roots).evaluate(self, &values, seed)
    }
}

/// What does not change from point to point.
struct Plan {
    roots: Vec<ExprId>,
    ids: Vec<ExprId>,
    /// Common denominator of the coefficients in angles, and in exponents.
    angle_denominator: u64,
    exponent_denominator: u64,
    /// Whether one of them is beyond bounds.
    coarse: bool,
}

impl Plan {
    fn new(pool: &Pool, roots: &[ExprId]) -> Plan {
        let mut plan = Plan {
            roots: roots.to_vec(),
            ids: pool.reachable(roots),
            angle_denominator: 1,
            exponent_denominator: 1,
            coarse: false,
        };
        for id in &plan.ids {
            let Node::Function(function, x) = pool.node(*id) else { continue };
            let denominator = match Kind::of(*function) {
                Some(Kind::Circular) => &mut plan.angle_denominator,
                Some(Kind::Hyperbolic) => &mut plan.exponent_denominator,
                None => continue,
            };
            let mut include = |value: &Number| match value.small_parts() {
                Some((_, d)) => match lcm(*denominator, d) {
                    Some(lcm) => *denominator = lcm,
                    None => plan.coarse = true,
                },
                None => plan.coarse = true,
            };
            match pool.node(*x) {
                Node::Number(value) => include(value),
                Node::Sum { constant, terms } => {
                    include(constant);
                    terms.iter().filter(|(t, _)| *t != PI).for_each(|(_, c)| include(c));
                }
                Node::Pi
                | Node::Symbol(_)
                | Node::Product(_)
                | Node::Power { .. }
                | Node::Function(..)
                | Node::Atan2 { .. }
                | Node::Undefined => {}
            }
        }
        plan
    }

    fn evaluate(
        &self,
        pool: &Pool,
        values: &dyn Fn(Symbol) -> u64,
        seed: u64,
    ) -> Option<ModularPoint> {
        let mut point = Point {
            pool,
            plan: self,
            seed,
            values: ExprMap::default(),
            certainty: Certainty::default(),
        };
        for id in &self.ids {
            let value = point.value_of(*id, values)?;
            point.values.insert(*id, value);
        }
        let values = self.roots.iter().map(|root| point.value(*root)).collect();
        Some(ModularPoint { values, certainty: point.certainty })
    }
}

fn lcm(a: u64, b: u64) -> Option<u64> {
    let (mut x, mut y) = (a, b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    (a / x.max(1)).checked_mul(b).filter(|lcm| *lcm <= MAX_DENOMINATOR)
}

/// Which exponential a function is made of.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// exp(i*theta)
    Circular,
    /// exp(x)
    Hyperbolic,
}

impl Kind {
    fn of(function: Function) -> Option<Kind> {
        match function {
            Function::Sin | Function::Cos | Function::Tan => Some(Kind::Circular),
            Function::Sinh | Function::Cosh | Function::Tanh | Function::Exp => {
                Some(Kind::Hyperbolic)
            }
            Function::Asin
            | Function::Acos
            | Function::Atan
            | Function::Ln
            | Function::Abs => None,
        }
    }
}

struct Point<'a> {
    pool: &'a Pool,
    plan: &'a Plan,
    seed: u64,
    values: ExprMap<u64>,
    certainty: Certainty,
}

impl Point<'_> {
    /// The value of an expression that was evaluated before.
    fn value(&self, id: ExprId) -> u64 {
        self.values.get(&id).copied().unwrap_or(0)
    }

    fn value_of(&mut self, id: ExprId, symbols: &dyn Fn(Symbol) -> u64) -> Option<u64> {
        let pool = self.pool;
        match pool.node(id) {
            Node::Number(value) => residue(value),
            Node::Pi => Some(random(self.seed, Tag::Pi, 0, 0)),
            Node::Symbol(symbol) => Some(symbols(*symbol) % PRIME),
            Node::Sum { constant, terms } => {
                let mut sum = residue(constant)?;
                for (term, coefficient) in terms {
                    sum = add_mod(sum, mul_mod(residue(coefficient)?, self.value(*term)));
                }
                Some(sum)
            }
            Node::Product(factors) => {
                let mut product = 1;
                for (base, exponent) in factors {
                    product = mul_mod(product, self.power(*base, exponent)?);
                }
                Some(product)
            }
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
    fn power(&mut self, base: ExprId, exponent: &Number) -> Option<u64> {
        let value = self.value(base);
        let Some((numerator, denominator)) = exponent.small_parts() else {
            self.certainty.random_function = true;
            return Some(random(self.seed, Tag::Power, value, residue(exponent)?));
        };
        let root = match (denominator, self.pool.node(base)) {
            (1, _) => value,
            (_, Node::Number(number)) => self.root_of_number(number, denominator)?,
            (_, _) => self.root(value, denominator),
        };
        signed_power(root, numerator)
    }

    /// The square root (or a higher one) of a value that is not a number's.
    fn root(&mut self, value: u64, degree: u64) -> u64 {
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
            let small = factor.base.small_parts().map(|(n, _)| n.unsigned_abs());
            let value = residue(&factor.base)?;
            // Different primes have independent roots (but for those roots of unity), so that any
            // sign is as good as the true one.
            let base = match (degree, small) {
                (2, Some(q)) if q < 1000 => sqrt_of_prime(q).or_else(|| sqrt_mod(value)),
                (2, _) => sqrt_mod(value),
                (_, _) => None,
            };
            let base = match base {
                Some(base) => base,
                None => {
                    self.certainty.random_function = true;
                    random(self.seed, Tag::Root, value, degree)
                }
            };
            root = mul_mod(root, pow_mod(base, u64::from(factor.multiplicity)));
        }
        Some(root)
    }

    /// A power with an exponent that is not a number: the whole part of the exponent is taken
    /// out, the rest is a random function of both values.
    fn general_power(&mut self, base: ExprId, exponent: ExprId) -> Option<u64> {
        self.certainty.random_function = true;
        let b = self.value(base);
        let Node::Sum { constant, terms } = self.pool.node(exponent) else {
            return Some(random(self.seed, Tag::Power, b, self.value(exponent)));
        };
        let mut product = match constant.to_i64() {
            Some(whole) => signed_power(b, whole)?,
            None => random(self.seed, Tag::Power, b, residue(constant)?),
        };
        for (term, coefficient) in terms {
            let value = self.value(*term);
            let factor = match coefficient.to_i64() {
                Some(whole) => signed_power(random(self.seed, Tag::Power, b, value), whole)?,
                None => random(self.seed, Tag::Power, b, mul_mod(value, residue(coefficient)?)),
            };
            product = mul_mod(product, factor);
        }
        Some(product)
    }

    fn function(&mut self, function: Function, x: ExprId) -> Option<u64> {
        let half = PRIME.div_ceil(2);
        match function {
            Function::Sin | Function::Cos | Function::Tan => {
                let z = self.exponential(Kind::Circular, x)?;
                let inverse = inverse_mod(z)?;
                // i*sin, cos
                let sine = mul_mod(half, sub_mod(z, inverse));
                let cosine = mul_mod(half, add_mod(z, inverse));
                let over_i = neg_mod(root_of_unity(4)?);
                match function {
                    Function::Cos => Some(cosine),
                    Function::Tan => Some(mul_mod(mul_mod(sine, over_i), inverse_mod(cosine)?)),
                    _sine => Some(mul_mod(sine, over_i)),
                }
            }
            Function::Exp => self.exponential(Kind::Hyperbolic, x),
            Function::Sinh | Function::Cosh | Function::Tanh => {
                let w = self.exponential(Kind::Hyperbolic, x)?;
                let inverse = inverse_mod(w)?;
                let (difference, sum) = (sub_mod(w, inverse), add_mod(w, inverse));
                match function {
                    Function::Sinh => Some(mul_mod(half, difference)),
                    Function::Cosh => Some(mul_mod(half, sum)),
                    _tanh => Some(mul_mod(difference, inverse_mod(sum)?)),
                }
            }
            // The root of the square, with the sign that root has everywhere.
            Function::Abs => {
                let value = self.value(x);
                Some(self.root(mul_mod(value, value), 2))
            }
            Function::Asin | Function::Acos | Function::Atan | Function::Ln => {
                self.certainty.random_function = true;
                Some(random(self.seed, Tag::Function(function), self.value(x), 0))
            }
        }
    }

    /// What stands for exp(i*x), or for exp(x).
    fn exponential(&mut self, kind: Kind, x: ExprId) -> Option<u64> {
        let pool = self.pool;
        let mut product = 1;
        // Monomials by value, with their coefficients.
        let mut monomials: Vec<(u64, Number)> = Vec::new();
        match pool.node(x) {
            Node::Number(value) => monomials.push((1, value.clone())),
            Node::Sum { constant, terms } => {
                monomials.push((1, constant.clone()));
                for (term, coefficient) in terms {
                    match self.known_exponential(kind, *term, coefficient)? {
                        Some(factor) => product = mul_mod(product, factor),
                        None => self.expand(*term, coefficient, &mut monomials),
                    }
                }
            }
            Node::Pi
            | Node::Symbol(_)
            | Node::Product(_)
            | Node::Power { .. }
            | Node::Function(..)
            | Node::Atan2 { .. }
            | Node::Undefined => match self.known_exponential(kind, x, &Number::ONE)? {
                Some(factor) => product = mul_mod(product, factor),
                None => self.expand(x, &Number::ONE, &mut monomials),
            },
        }
        monomials.sort();
        let (tag, common) = match kind {
            Kind::Circular => (Tag::Angle, self.plan.angle_denominator),
            Kind::Hyperbolic => (Tag::Exponent, self.plan.exponent_denominator),
        };
        let mut rest = monomials.into_iter().peekable();
        while let Some((value, mut coefficient)) = rest.next() {
            while let Some((_, more)) = rest.next_if(|(next, _)| *next == value) {
                coefficient = coefficient.add(&more);
            }
            let Some((numerator, denominator)) = coefficient.small_parts() else {
                self.certainty.random_function = true;
                let scaled = mul_mod(value, residue(&coefficient)?);
                product = mul_mod(product, random(self.seed, tag, scaled, 0));
                continue;
            };
            if self.plan.coarse {
                self.certainty.random_function = true;
            }
            if numerator == 0 {
                continue;
            }
            let (base, factor) = if common.is_multiple_of(denominator) {
                (random(self.seed, tag, value, common), common / denominator)
            } else {
                (random(self.seed, tag, value, denominator), 1)
            };
            let base = pow_mod(base, factor);
            product = mul_mod(product, signed_power(base, numerator)?);
        }
        Some(product)
    }

    /// The exponential of `coefficient*term` where it is known exactly: of multiples of pi, of
    /// arc functions, of logarithms.
    fn known_exponential(
        &mut self,
        kind: Kind,
        term: ExprId,
        coefficient: &Number,
    ) -> Option<Option<u64>> {
        let whole = coefficient.to_i64();
        let pool = self.pool;
        if kind == Kind::Circular && term == PI {
            let root = coefficient.small_parts().and_then(|(n, d)| {
                let root = root_of_unity(d.checked_mul(2)?)?;
                Some(pow_mod(root, i128::from(n).rem_euclid(2 * i128::from(d)) as u64))
            });
            self.certainty.random_function |= root.is_none();
            return Some(root);
        }
        let Some(whole) = whole else {
            return Some(None);
        };
        // The angle's cosine and sine are c/r and s/r.
        let (c, s, r) = match (kind, pool.node(term)) {
            (Kind::Hyperbolic, Node::Function(Function::Ln, u)) => {
                return Some(Some(signed_power(self.value(*u), whole)?));
            }
            (Kind::Circular, Node::Function(Function::Asin, u)) => {
                let u = self.value(*u);
                (self.root(sub_mod(1, mul_mod(u, u)), 2), u, 1)
            }
            (Kind::Circular, Node::Function(Function::Acos, u)) => {
                let u = self.value(*u);
                (u, self.root(sub_mod(1, mul_mod(u, u)), 2), 1)
            }
            (Kind::Circular, Node::Function(Function::Atan, u)) => {
                let u = self.value(*u);
                (1, u, self.root(add_mod(1, mul_mod(u, u)), 2))
            }
            (Kind::Circular, Node::Atan2 { y, x }) => {
                let (y, x) = (self.value(*y), self.value(*x));
                (x, y, self.root(add_mod(mul_mod(y, y), mul_mod(x, x)), 2))
            }
            (_, _) => return Some(None),
        };
        let z = add_mod(c, mul_mod(root_of_unity(4)?, s));
        Some(Some(signed_power(mul_mod(z, inverse_mod(r)?), whole)?))
    }

    /// Adds `coefficient*term` to the monomials, sums multiplied out.
    fn expand(&mut self, term: ExprId, coefficient: &Number, monomials: &mut Vec<(u64, Number)>) {
        let pool = self.pool;
        let is_symbol = |id: ExprId| matches!(pool.node(id), Node::Symbol(_));
        let Node::Product(factors) = pool.node(term) else {
            self.certainty.dependent_angles |= !is_symbol(term);
            monomials.push((self.value(term), coefficient.clone()));
            return;
        };
        let mut expanded = vec![(1, coefficient.clone())];
        for (base, exponent) in factors {
            let times = exponent.to_i64().filter(|times| (1..=8).contains(times));
            if let (Node::Sum { constant, terms }, Some(times)) = (pool.node(*base), times) {
                for _ in 0..times {
                    if expanded.len() * (terms.len() + 1) > MAX_MONOMIALS {
                        self.certainty.dependent_angles = true;
                        monomials.push((self.value(term), coefficient.clone()));
                        return;
                    }
                    let mut next = Vec::new();
                    for (value, factor) in &expanded {
                        if !constant.is_zero() {
                            next.push((*value, factor.mul(constant)));
                        }
                        for (t, c) in terms {
                            self.certainty.dependent_angles |= !is_symbol(*t);
                            next.push((mul_mod(*value, self.value(*t)), factor.mul(c)));
                        }
                    }
                    expanded = next;
                }
                continue;
            }
            self.certainty.dependent_angles |= !is_symbol(*base) || !exponent.is_integer();
            let Some(power) = self.power(*base, exponent) else {
                // The term itself has no value then, and the point is given up elsewhere.
                return;
            };
            for (value, _) in &mut expanded {
                *value = mul_mod(*value, power);
            }
        }
        monomials.append(&mut expanded);
    }
}

/// A whole power; `None` of a negative one of 0.
fn signed_power(base: u64, exponent: i64) -> Option<u64> {
    // Exponents count modulo p - 1; of 0 only the sign matters.
    if exponent < 0 {
        return Some(pow_mod(inverse_mod(base)?, exponent.unsigned_abs()));
    }
    Some(pow_mod(base, exponent.unsigned_abs()))
}
