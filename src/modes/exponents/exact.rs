//! What bounds never decide, decided for rational matrices of moderate size: repeated exponents, growth 0, the
//! multiplicity of the exponent 0.
//!
//! The characteristic polynomial p(λ) = det(λ²M + λD + S) is interpolated from exact determinants and taken apart by
//! multiplicity, which leaves factors f with simple roots. An imaginary root iω of f has the root -iω beside it,
//! so that both are roots of gcd(f(λ), f(-λ)), a polynomial in λ²; the rest of f has none. So growth is 0 exactly
//! where λ² is a real negative root of that polynomial, and omega is 0 where a root is real; both are decided
//! by discs that hold one root each and meet no other disc on the other side of the axis.

use dashu_int::IBig;

use super::IntegerQuadratic;
use super::complex::Wide;
use super::polynomial::{
    Polynomial, by_multiplicity, determinant, divided, gcd, mirrored, primitive, roots, through,
};
use crate::precision::{Big, Rounding};

/// Up to this number of coordinates.
pub(super) const LARGEST: usize = 20;
/// Minors of matrices up to this size are looked at one by one.
const MINORS: usize = 8;
/// The most bits that roots are separated with.
const MOST_BITS: usize = 8192;

/// An exponent with its multiplicity, growth or omega exactly 0 where they are.
#[derive(Clone, Debug)]
pub(super) struct ExactRoot {
    pub(super) growth: Big,
    pub(super) omega: Big,
    pub(super) multiplicity: usize,
    /// The number of independent vectors; `None` where it is not known.
    pub(super) vectors: Option<usize>,
}

/// All exponents: conjugates once, of real pairs ±s both.
pub(super) struct ExactSpectrum {
    /// The multiplicity of the exponent 0.
    pub(super) zeros: usize,
    pub(super) roots: Vec<ExactRoot>,
}

/// λ²M + λD + S, row by row.
fn at(matrices: &IntegerQuadratic, n: usize, lambda: &IBig) -> Vec<Vec<IBig>> {
    let entry = |i: usize, j: usize| {
        let k = j * n + i;
        (&matrices.mass[k] * lambda + &matrices.velocity[k]) * lambda + &matrices.stiffness[k]
    };
    (0..n)
        .map(|i| (0..n).map(|j| entry(i, j)).collect())
        .collect()
}

/// The exact spectrum with so many digits of every growth and omega; `None` where it is out of reach.
pub(super) fn exact(
    matrices: &IntegerQuadratic,
    n: usize,
    digits: usize,
    semisimple: bool,
) -> Option<ExactSpectrum> {
    let square = n * n;
    let whole = [&matrices.mass, &matrices.velocity, &matrices.stiffness];
    if n > LARGEST || whole.iter().any(|m| m.len() != square) {
        return None;
    }
    let values = (0..=2 * n).map(|k| determinant(at(matrices, n, &IBig::from(k))));
    let mut p = through(values.collect());
    if p.len() != 2 * n + 1 {
        return None;
    }
    let zeros = p.iter().take_while(|c| c.is_zero()).count();
    p.drain(..zeros);
    let mut found = Vec::new();
    for (factor, multiplicity) in by_multiplicity(&p)? {
        let even = gcd(&factor, &mirrored(&factor));
        let rest = divided(&factor, &even)?;
        // Roots in pairs ±λ, none of them 0: a polynomial in λ².
        if even.iter().skip(1).step_by(2).any(|c| !c.is_zero()) {
            return None;
        }
        let squares: Polynomial = even.iter().step_by(2).cloned().collect();
        let enough = (multiplicity > 1 && !semisimple)
            .then(|| has_enough_vectors(matrices, n, &factor, multiplicity));
        let mut bits = 128 + 4 * digits;
        let parts = loop {
            let parts = separated(&squares, &rest, digits, bits);
            if parts.is_some() || bits >= MOST_BITS {
                break parts;
            }
            bits *= 2;
        }?;
        for (growth, omega) in parts {
            let vectors = match enough {
                None | Some(Some(true)) => Some(multiplicity),
                Some(_) => {
                    let lambda = Wide {
                        re: growth.clone(),
                        im: omega.clone(),
                    };
                    // At most so many; fewer than the multiplicity is what it proves.
                    let most = n - rank_at_least(matrices, n, &lambda, bits);
                    (most < multiplicity).then_some(most)
                }
            };
            found.push(ExactRoot {
                growth,
                omega,
                multiplicity,
                vectors,
            });
        }
    }
    Some(ExactSpectrum {
        zeros,
        roots: found,
    })
}

/// Growth and omega of all roots, λ² a root of `squares` or λ one of `rest`, with omega >= 0.
fn separated(
    squares: &Polynomial,
    rest: &Polynomial,
    digits: usize,
    bits: usize,
) -> Option<Vec<(Big, Big)>> {
    let zero = || Big::zero(bits);
    let mut parts = Vec::new();
    for s in roots(squares, bits)? {
        if s.im.is_zero() {
            if s.re.is_negative() {
                parts.push((zero(), (-&s.re).sqrt()));
            } else if s.re.is_positive() {
                let root = s.re.sqrt();
                parts.push((-&root, zero()));
                parts.push((root, zero()));
            } else {
                return None;
            }
        } else if s.im.is_positive() {
            // λ = a + ib: a² - b² = Re s, 2ab = Im s, a² + b² = |s|.
            let modulus = (&(&s.re * &s.re) + &(&s.im * &s.im)).sqrt();
            let (a, b) = if s.re.is_negative() {
                let b = (&modulus - &s.re).scale(-1).sqrt();
                (&s.im / &b.scale(1), b)
            } else {
                let a = (&modulus + &s.re).scale(-1).sqrt();
                (a.clone(), &s.im / &a.scale(1))
            };
            parts.push((-&a, b.clone()));
            parts.push((a, b));
        } else if !s.im.is_negative() {
            return None;
        }
    }
    for root in roots(rest, bits)? {
        if root.im.is_zero() || root.im.is_positive() {
            parts.push((root.re, root.im));
        } else if !root.im.is_negative() {
            return None;
        }
    }
    let covered = |x: &Big| {
        x.is_zero()
            || matches!(
                x.decimal(digits).rounding,
                Rounding::Correct | Rounding::Tie
            )
    };
    parts
        .iter()
        .all(|(growth, omega)| covered(growth) && covered(omega))
        .then_some(parts)
}

/// Whether every root of the factor has as many vectors as its multiplicity m: exactly if its (m - 1)th power divides
/// all minors of order n - 1 (the elementary divisors of λ²M + λD + S at the root are then all linear). `None` where
/// that is too much to look at.
fn has_enough_vectors(
    matrices: &IntegerQuadratic,
    n: usize,
    factor: &Polynomial,
    multiplicity: usize,
) -> Option<bool> {
    if n > MINORS {
        return None;
    }
    let mut power: Polynomial = vec![IBig::ONE];
    for _ in 1..multiplicity {
        let mut product = vec![IBig::ZERO; power.len() + factor.len() - 1];
        for (i, a) in power.iter().enumerate() {
            for (j, b) in factor.iter().enumerate() {
                product[i + j] += a * b;
            }
        }
        power = primitive(product);
    }
    let samples: Vec<Vec<Vec<IBig>>> = (0..2 * n - 1)
        .map(|k| at(matrices, n, &IBig::from(k)))
        .collect();
    for row in 0..n {
        for column in 0..n {
            let values = samples.iter().map(|whole| {
                let rows = whole.iter().enumerate().filter(|(i, _)| *i != row);
                determinant(
                    rows.map(|(_, r)| {
                        let kept = r.iter().enumerate().filter(|(j, _)| *j != column);
                        kept.map(|(_, x)| x.clone()).collect()
                    })
                    .collect(),
                )
            });
            let minor = through(values.collect());
            if !minor.is_empty() && divided(&minor, &power).is_none() {
                return Some(false);
            }
        }
    }
    Some(true)
}

/// A lower bound of the rank of λ²M + λD + S: pivots that are certainly not 0.
fn rank_at_least(matrices: &IntegerQuadratic, n: usize, lambda: &Wide, bits: usize) -> usize {
    let big = |x: &IBig| Big::from_parts(x.clone(), 0, bits);
    let mut rows: Vec<Vec<Wide>> = (0..n)
        .map(|i| {
            (0..n)
                .map(|j| {
                    let k = j * n + i;
                    let mut inner = lambda.times(&big(&matrices.mass[k]));
                    inner.re = &inner.re + &big(&matrices.velocity[k]);
                    let mut value = inner.mul(lambda);
                    value.re = &value.re + &big(&matrices.stiffness[k]);
                    value
                })
                .collect()
        })
        .collect();
    let least = |x: &Wide| x.re.abs_lower().max(x.im.abs_lower());
    let mut rank = 0;
    while rank < n {
        let mut best = None;
        for (i, row) in rows.iter().enumerate().skip(rank) {
            for (j, x) in row.iter().enumerate().skip(rank) {
                let size = least(x);
                if !size.is_zero() && best.as_ref().is_none_or(|(_, _, most)| size > *most) {
                    best = Some((i, j, size));
                }
            }
        }
        let Some((i, j, _)) = best else { break };
        rows.swap(rank, i);
        for row in &mut rows {
            row.swap(rank, j);
        }
        let (above, below) = rows.split_at_mut(rank + 1);
        let pivot = &above[rank];
        for row in below {
            let factor = row[rank].div(&pivot[rank]);
            for column in rank..n {
                row[column] = row[column].sub(&factor.mul(&pivot[column]));
            }
        }
        rank += 1;
    }
    rank
}
