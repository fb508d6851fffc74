//! Addition theorems, used where two terms become one.

use super::simplify::{self, Monomial, Monomials, split};
use crate::expr::{ExprId, Pool};
use crate::number::Number;
use crate::polynomial::add_to;
use crate::precision::Function;

/// The argument of a sine or cosine.
pub(super) fn angle(pool: &Pool, e: ExprId, function: Function) -> Option<ExprId> {
    pool.as_function(e).filter(|(own, _)| *own == function).map(|(_, x)| x)
}

/// A monomial with some powers changed; exponents that become 0 vanish.
fn changed(monomial: &Monomial, by: &[(ExprId, i64)]) -> Monomial {
    let by = by.iter().map(|(base, change)| (*base, Number::from(*change))).collect();
    simplify::times(monomial, &by, &Number::ONE)
}

/// Uses the addition theorems wherever two terms become one.
pub(super) fn collapse(pool: &mut Pool, monomials: &mut Monomials) {
    let is_angle = |pool: &Pool, id: ExprId| {
        pool.as_function(id).is_some_and(|(own, _)| matches!(own, Function::Sin | Function::Cos | Function::Tan))
    };
    let with_angles = |pool: &Pool, monomials: &Monomials| -> Vec<Monomial> {
        monomials.keys().filter(|own| own.iter().any(|(base, _)| is_angle(pool, *base))).cloned().collect()
    };
    let mut all = with_angles(pool, monomials);
    for rule in [secants, fourths, squares, complements, products, halves] {
        // Each use leaves one term or one function less; a new term may be the partner of one that was
        // examined before.
        let mut changed = true;
        while changed {
            changed = false;
            for monomial in &all {
                if pool.is_spent() {
                    return;
                }
                let Some(coefficient) = monomials.get(monomial).cloned() else { continue };
                if let Some((gone, new)) = rule(pool, monomials, monomial, &coefficient) {
                    for old in gone.iter().flatten() {
                        monomials.remove(old);
                    }
                    new.into_iter().for_each(|(monomial, coefficient)| add_to(monomials, monomial, &coefficient));
                    changed = true;
                }
            }
            if changed {
                all = with_angles(pool, monomials);
            }
        }
    }
}

/// What one or two terms become: those that go, and those that come with their coefficients.
type Step = ([Option<Monomial>; 2], Vec<(Monomial, Number)>);

/// cos + sin tan = 1/cos
fn secants(pool: &mut Pool, monomials: &Monomials, monomial: &Monomial, coefficient: &Number) -> Option<Step> {
    for (base, exponent) in monomial {
        let Some(x) = angle(pool, *base, Function::Tan).filter(|_| exponent.is_one()) else { continue };
        let (sine, cosine) = (pool.sin(x), pool.cos(x));
        let rest = changed(monomial, &[(*base, -1), (sine, -1)]);
        let partner = changed(&rest, &[(cosine, 1)]);
        if monomials.get(&partner) == Some(coefficient) {
            let new = (changed(&rest, &[(cosine, -1)]), coefficient.clone());
            return Some(([Some(monomial.clone()), Some(partner)], vec![new]));
        }
    }
    None
}

/// cos^4 + sin^4 = 1 - 2 cos^2 sin^2, of angles that are halved.
fn fourths(pool: &mut Pool, monomials: &Monomials, monomial: &Monomial, coefficient: &Number) -> Option<Step> {
    for (base, exponent) in monomial {
        let Some(x) = angle(pool, *base, Function::Cos) else { continue };
        if !is_halved(pool, x) || *exponent != Number::from(4) {
            continue;
        }
        let sine = pool.sin(x);
        let partner = changed(monomial, &[(*base, -4), (sine, 4)]);
        if monomials.get(&partner) == Some(coefficient) {
            let one = (changed(monomial, &[(*base, -4)]), coefficient.clone());
            let mixed = (changed(monomial, &[(*base, -2), (sine, 2)]), coefficient.mul(&Number::from(-2)));
            return Some(([Some(monomial.clone()), Some(partner)], vec![one, mixed]));
        }
    }
    None
}

/// Whether half a whole multiple of something is an angle.
fn is_halved(pool: &Pool, x: ExprId) -> bool {
    split(pool, x).0.small_parts().is_some_and(|(_, d)| d.is_multiple_of(2))
}

/// cos^2 + sin^2 = 1, with what one of the terms has more left over: 2 cos^2 + 3 sin^2 = 2 + sin^2.
fn squares(pool: &mut Pool, monomials: &Monomials, monomial: &Monomial, coefficient: &Number) -> Option<Step> {
    let two = Number::from(2);
    for (base, exponent) in monomial {
        if exponent.is_integer()
            && *exponent >= two
            && let Some(x) = angle(pool, *base, Function::Cos)
        {
            let sine = pool.sin(x);
            let partner = changed(monomial, &[(*base, -2), (sine, 2)]);
            let Some(other) = monomials.get(&partner).filter(|own| own.is_negative() == coefficient.is_negative())
            else {
                continue;
            };
            let without = changed(monomial, &[(*base, -2)]);
            let rest = coefficient.sub(other);
            let (shared, longer) = match rest.is_negative() == coefficient.is_negative() && !rest.is_zero() {
                true => (other.clone(), Some((monomial.clone(), rest))),
                false => (coefficient.clone(), Some((partner.clone(), rest.neg())).filter(|(_, rest)| !rest.is_zero())),
            };
            let new = [(without, shared)].into_iter().chain(longer).collect();
            return Some(([Some(monomial.clone()), Some(partner)], new));
        }
    }
    None
}

/// 1 - cos^2 = sin^2, 1 - sin^2 = cos^2 and cos^2 - sin^2 = cos of the doubled angle.
fn complements(pool: &mut Pool, monomials: &Monomials, monomial: &Monomial, coefficient: &Number) -> Option<Step> {
    let two = Number::from(2);
    for (base, exponent) in monomial {
        if !exponent.is_integer() || *exponent < two {
            continue;
        }
        for (own, other) in [(Function::Cos, Function::Sin), (Function::Sin, Function::Cos)] {
            let Some(x) = angle(pool, *base, own) else { continue };
            let opposite = coefficient.neg();
            let without = changed(monomial, &[(*base, -2)]);
            let counterpart = pool.apply(other, x);
            let partner = changed(&without, &[(counterpart, 2)]);
            if monomials.get(&without) == Some(&opposite) {
                return Some(([Some(monomial.clone()), Some(without)], vec![(partner, opposite)]));
            }
            if own == Function::Cos && monomials.get(&partner) == Some(&opposite) {
                let doubled = pool.scale(x, &two);
                let cosine = pool.cos(doubled);
                return joined(pool, [Some(monomial.clone()), Some(partner)], &without, cosine, coefficient);
            }
        }
    }
    None
}

/// cos(a)cos(b) ± sin(a)sin(b) and sin(a)cos(b) ± cos(a)sin(b).
fn products(pool: &mut Pool, monomials: &Monomials, monomial: &Monomial, coefficient: &Number) -> Option<Step> {
    let usable = |exponent: &Number| exponent.is_integer() && *exponent >= Number::ONE;
    for (at, (first, e1)) in monomial.iter().enumerate() {
        for (second, e2) in monomial.iter().skip(at + 1) {
            if !usable(e1) || !usable(e2) {
                continue;
            }
            // Both cosines, or the one with the sine first.
            let cosines = (angle(pool, *first, Function::Cos), angle(pool, *second, Function::Cos));
            let sines = (angle(pool, *first, Function::Sin), angle(pool, *second, Function::Sin));
            let (a, b, mixed) = match (cosines, sines) {
                ((Some(a), Some(b)), _) => (a, b, false),
                ((_, Some(b)), (Some(a), _)) | ((Some(b), _), (_, Some(a))) => (a, b, true),
                _ => continue,
            };
            if a == b {
                continue;
            }
            let rest = changed(monomial, &[(*first, -1), (*second, -1)]);
            let (sin_a, cos_a) = (pool.sin(a), pool.cos(a));
            let sin_b = pool.sin(b);
            let partner = changed(&rest, &[(if mixed { cos_a } else { sin_a }, 1), (sin_b, 1)]);
            let Some(other) = monomials.get(&partner) else { continue };
            let same = other == coefficient;
            if !same && *other != coefficient.neg() {
                continue;
            }
            // cos cos + sin sin is of the difference, sin cos + cos sin of the sum.
            let argument = if same == mixed { pool.add(a, b) } else { pool.sub(a, b) };
            let value = if mixed { pool.sin(argument) } else { pool.cos(argument) };
            return joined(pool, [Some(monomial.clone()), Some(partner)], &rest, value, coefficient);
        }
    }
    None
}

/// sin(x/2)cos(x/2) = sin(x)/2, where only that rids an angle of its fraction.
fn halves(pool: &mut Pool, _: &Monomials, monomial: &Monomial, coefficient: &Number) -> Option<Step> {
    for (base, exponent) in monomial {
        let Some(x) = angle(pool, *base, Function::Sin) else { continue };
        if !is_halved(pool, x) || !exponent.is_integer() || *exponent < Number::ONE {
            continue;
        }
        let cosine = pool.cos(x);
        if !simplify::power_of(monomial, cosine).is_some_and(|other| other.is_integer() && *other >= Number::ONE) {
            continue;
        }
        let rest = changed(monomial, &[(*base, -1), (cosine, -1)]);
        let doubled = pool.scale(x, &Number::from(2));
        let sine = pool.sin(doubled);
        return joined(pool, [Some(monomial.clone()), None], &rest, sine, &coefficient.mul(&Number::half()));
    }
    None
}

/// Terms that go become one, times a sine or cosine; `None` where the pool makes more of it than a monomial.
fn joined(pool: &Pool, gone: [Option<Monomial>; 2], rest: &Monomial, by: ExprId, coefficient: &Number) -> Option<Step> {
    let (sign, function) = split(pool, by);
    pool.as_function(function)?;
    Some((gone, vec![(changed(rest, &[(function, 1)]), coefficient.mul(&sign))]))
}
