//! Arithmetic modulo one prime: the field in which identities are tested.
//!
//! The prime p = [`PRIME`] is about 2^60.7, and p - 1 is
//! `2^6 * 3^3 * 5 * 7 * 11 * 13 * 17 * 19 * 23 * 29 * 31 * 41 * 797`: i and many other roots of
//! unity exist modulo p, and all primes up to 101 have square roots.

use dashu_int::ops::{SquareRoot, UnsignedAbs};
use dashu_int::{IBig, UBig};

use crate::number::{Number, inverse_modulo};

/// The prime.
pub const PRIME: u64 = 1_887_469_959_161_666_881;

/// A generator of the multiplicative group.
const GENERATOR: u64 = 113;
/// The odd part of p - 1 = 2^6 * ODD.
const ODD: u64 = (PRIME - 1) >> 6;
/// A root of unity of order 2^6.
const UNITY: u64 = pow_mod(GENERATOR, ODD);
/// floor(2^122 / p), below 2^62.
const BARRETT: u64 = ((1u128 << 122) / PRIME as u128) as u64;

/// The product; both factors below [`PRIME`].
#[must_use]
pub const fn mul_mod(a: u64, b: u64) -> u64 {
    // Barrett: with x < 2^122 and 2^60 < p < 2^61 the estimate of the quotient is at most 2 low.
    let x = a as u128 * b as u128;
    let quotient = (((x >> 60) as u64 as u128 * BARRETT as u128) >> 62) as u64;
    let mut rest = (x as u64).wrapping_sub(quotient.wrapping_mul(PRIME));
    while rest >= PRIME {
        rest -= PRIME;
    }
    rest
}

/// The sum; both below [`PRIME`].
#[must_use]
pub fn add_mod(a: u64, b: u64) -> u64 {
    let sum = a + b;
    if sum >= PRIME { sum - PRIME } else { sum }
}

/// The opposite of what is below [`PRIME`].
#[must_use]
pub fn neg_mod(a: u64) -> u64 {
    if a == 0 { 0 } else { PRIME - a }
}

/// The difference; both below [`PRIME`].
#[must_use]
pub fn sub_mod(a: u64, b: u64) -> u64 {
    add_mod(a, neg_mod(b))
}

/// A power.
#[must_use]
pub const fn pow_mod(mut base: u64, mut exponent: u64) -> u64 {
    let mut power = 1;
    while exponent > 0 {
        if exponent & 1 == 1 {
            power = mul_mod(power, base);
        }
        base = mul_mod(base, base);
        exponent >>= 1;
    }
    power
}

/// The inverse; `None` of 0.
#[must_use]
pub fn inverse_mod(a: u64) -> Option<u64> {
    inverse_modulo(a, PRIME)
}

/// The smaller of the two square roots, where there are any.
#[must_use]
pub fn sqrt_mod(a: u64) -> Option<u64> {
    if a == 0 {
        return Some(0);
    }
    // Tonelli and Shanks, p - 1 = 2^6 * ODD: a^((ODD+1)/2) is a root up to a root of unity of
    // order 2^6, which is corrected bit by bit.
    let mut root_of_unity = UNITY;
    let half = pow_mod(a, ODD / 2);
    let mut root = mul_mod(half, a);
    let mut rest = mul_mod(half, root);
    let mut order = 6;
    while rest != 1 {
        let mut least = 0;
        let mut power = rest;
        while power != 1 {
            power = mul_mod(power, power);
            least += 1;
            if least == order {
                return None;
            }
        }
        for _ in 0..order - least - 1 {
            root_of_unity = mul_mod(root_of_unity, root_of_unity);
        }
        root = mul_mod(root, root_of_unity);
        root_of_unity = mul_mod(root_of_unity, root_of_unity);
        rest = mul_mod(rest, root_of_unity);
        order = least;
    }
    Some(root.min(neg_mod(root)))
}

/// What stands for exp(2*pi*i/order), where p has it; all of them are powers of one.
pub(super) fn root_of_unity(order: u64) -> Option<u64> {
    if order == 0 || !(PRIME - 1).is_multiple_of(order) { None } else { Some(pow_mod(GENERATOR, (PRIME - 1) / order)) }
}

/// The square root of a prime q that belongs to the [`root_of_unity`]s: Gauss's sum over
/// (a/q) exp(2*pi*i*a/q), which is sqrt(q) for q = 1 and i*sqrt(q) for q = 3 modulo 4. `None`
/// where p has no such root of unity.
pub(super) fn sqrt_of_prime(q: u64) -> Option<u64> {
    if q == 2 {
        let eighth = root_of_unity(8)?;
        return Some(add_mod(eighth, inverse_mod(eighth)?));
    }
    let root = root_of_unity(q)?;
    // The sum of (a/q) r^a is the sum of r^(a^2) over all residues a.
    let sum = (0..q).fold(0, |sum, a| add_mod(sum, pow_mod(root, a * a % q)));
    if q % 4 == 1 { Some(sum) } else { Some(mul_mod(sum, inverse_mod(root_of_unity(4)?)?)) }
}

/// The fraction n/d with 2 n² and 2 d² below the modulus that is this residue; there is one at most. Wang's
/// algorithm: the extended Euclidean algorithm stopped half way.
#[must_use]
pub fn rational_reconstruct(residue: &IBig, modulus: &UBig) -> Option<Number> {
    let bound = IBig::from((modulus >> 1).sqrt());
    let (mut r0, mut r1) = (IBig::from(modulus.clone()), residue.clone());
    let (mut t0, mut t1) = (IBig::ZERO, IBig::ONE);
    while r1 > bound {
        let quotient = &r0 / &r1;
        (r0, r1) = (r1.clone(), r0 - &quotient * r1);
        (t0, t1) = (t1.clone(), t0 - quotient * t1);
    }
    let (numerator, denominator) = if t1 < IBig::ZERO { (-r1, -t1) } else { (r1, t1) };
    (denominator <= bound).then(|| Number::from_parts(numerator, denominator.unsigned_abs()))?
}

/// The same for a residue modulo [`PRIME`].
#[must_use]
pub fn fraction_mod(residue: u64) -> Option<Number> {
    rational_reconstruct(&residue.into(), &PRIME.into())
}
