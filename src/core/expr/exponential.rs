//! What stands for exp(i*theta) and exp(x) at a point modulo a prime.
//!
//! The argument is written as a sum of monomials with rational coefficients; to each monomial's
//! value belongs a random element, whose powers the coefficients are.

use super::angle::Triangle;
use super::modular::root_of_unity;
use super::point::{Kind, Point, Tag, random, residue, signed_power};
use super::{ExprId, Function, Node, ONE, PI, add_mod, collect_equal, inverse_mod, mul_mod, pow_mod, sub_mod};
use crate::number::Number;

/// Monomials up to which the product of sums in an angle is multiplied out.
const MAX_MONOMIALS: usize = 256;

impl Point<'_> {
    /// What stands for exp(i*x), or for exp(x).
    pub(super) fn exponential(&mut self, kind: Kind, x: ExprId) -> Option<u64> {
        let pool = self.pool;
        let mut product = 1;
        // Monomials by value, with their coefficients.
        let mut monomials: Vec<(u64, Number)> = Vec::new();
        for (term, coefficient) in pool.terms(x) {
            if let Some(value) = pool.as_number(term) {
                monomials.push((1, coefficient.mul(value)));
            } else {
                match self.known_exponential(kind, term, &coefficient)? {
                    Some(factor) => product = mul_mod(product, factor),
                    None => self.expand(term, &coefficient, &mut monomials),
                }
            }
        }
        self.certainty.random_function |= self.plan.coarse && !monomials.is_empty();
        collect_equal(&mut monomials);
        let (tag, common) = match kind {
            Kind::Circular => (Tag::Angle, self.plan.angle_denominator),
            Kind::Hyperbolic => (Tag::Exponent, self.plan.exponent_denominator),
        };
        for (value, coefficient) in monomials {
            let Some((numerator, denominator)) = coefficient.small_parts() else {
                self.certainty.random_function = true;
                let scaled = mul_mod(value, residue(&coefficient)?);
                product = mul_mod(product, random(self.seed, tag, scaled, 0));
                continue;
            };
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
    fn known_exponential(&mut self, kind: Kind, term: ExprId, coefficient: &Number) -> Option<Option<u64>> {
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
        let Some(whole) = whole else { return Some(None) };
        if kind == Kind::Hyperbolic {
            let logarithm = pool.as_function(term).filter(|(function, _)| *function == Function::Ln);
            let power = logarithm.map(|(_, u)| signed_power(self.value(u), whole));
            return if let Some(power) = power { power.map(Some) } else { Some(None) };
        }
        // The angle's cosine and sine are c/r and s/r.
        let leg = |point: &mut Self, u: u64| point.root(sub_mod(1, mul_mod(u, u)), 2);
        let (c, s, r) = match pool.triangle(term) {
            Some(Triangle::Sine(u)) => {
                let u = self.value(u);
                (leg(self, u), u, 1)
            }
            Some(Triangle::Cosine(u)) => {
                let u = self.value(u);
                (u, leg(self, u), 1)
            }
            Some(Triangle::Legs { y, x }) => {
                // The leg of an arc tangent that is 1 need not be a part of what is evaluated.
                let (y, x) = (self.value(y), if x == ONE { 1 } else { self.value(x) });
                (x, y, self.root(add_mod(mul_mod(y, y), mul_mod(x, x)), 2))
            }
            None => return Some(None),
        };
        let z = add_mod(c, mul_mod(root_of_unity(4)?, s));
        Some(Some(signed_power(mul_mod(z, inverse_mod(r)?), whole)?))
    }

    /// Adds `coefficient*term` to the monomials, sums multiplied out.
    fn expand(&mut self, term: ExprId, coefficient: &Number, monomials: &mut Vec<(u64, Number)>) {
        let pool = self.pool;
        let is_symbol = |id: ExprId| matches!(pool.node(id), Node::Symbol(_));
        let mut expanded = vec![(1, coefficient.clone())];
        for (base, exponent) in pool.factors(term) {
            let times = exponent.to_i64().filter(|times| (1..=8).contains(times));
            if let (Node::Sum { constant, terms }, Some(times)) = (pool.node(base), times) {
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
            self.certainty.dependent_angles |= !is_symbol(base) || !exponent.is_integer();
            let Some(power) = self.power(base, &exponent) else {
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
