//! M, G + C and K + N with whole entries, in units that take away as many roots as they can.
//!
//! With q_i = u_i q'_i and λ = ρ λ' the matrices are ρ² u_i u_j M_ij, ρ u_i u_j D_ij and u_i u_j S_ij. The first entry that couples a
//! coordinate to one before it says its unit, and an entry of D, or one of S beside that of M, says ρ.

use std::array;

use dashu_int::IBig;

use super::elimination::common_denominator;
use super::radicals::{Exact, Field, Surd};
use crate::number::Number;
use crate::precision::{Integers, Root, Scalar};

/// So many units of exponents are tried.
const MOST_RATES: usize = 6;

/// In the units that leave the fewest roots; `None` where an entry is no combination of square roots in any.
pub(super) fn integers(matrices: &[Vec<Exact>; 3]) -> Option<Integers> {
    let mut best: Option<Integers> = None;
    for rate in rates(matrices) {
        let found = units(matrices, &rate).and_then(|units| whole(matrices, &rate, &units));
        let Some(found) = found else { continue };
        let done = found.roots.is_empty();
        if best.as_ref().is_none_or(|best| found.roots.len() < best.roots.len()) {
            best = Some(found);
        }
        if done {
            break;
        }
    }
    best
}

/// The root of the first term.
fn leading(entry: &Exact) -> Option<Surd> {
    (!entry.is_exact_zero()).then(|| Some(entry.terms()?.next()?.root()))?
}

fn root(root: &Root) -> Option<Surd> {
    let radicand = Number::from_integer(root.radicand.clone());
    Surd::new(Number::ONE, radicand, root.index)
}

/// Units of exponents that may do.
fn rates(matrices: &[Vec<Exact>; 3]) -> Vec<Root> {
    let [mass, velocity, stiffness] = matrices;
    let mut rates = vec![Root::default()];
    let wanted = |entry: &Exact| leading(entry)?.recip()?.whole_root();
    let beside = |(m, s): (&Exact, &Exact)| {
        let square = leading(s)?.mul(&leading(m)?.recip()?)?;
        square.root().power(1, 2)?.whole_root()
    };
    let all = velocity.iter().filter_map(wanted);
    for rate in all.chain(mass.iter().zip(stiffness).filter_map(beside)) {
        if rates.len() < MOST_RATES && !rates.contains(&rate) {
            rates.push(rate);
        }
    }
    rates
}

/// ρ², ρ and 1.
fn powers(rate: &Root) -> Option<[Exact; 3]> {
    let own = Exact::of(root(rate)?);
    Some([own.mul(&own), own, Exact::rational(Some(Number::ONE))])
}

/// Units of the coordinates as the entries want them, one entry after the other.
fn units(matrices: &[Vec<Exact>; 3], rate: &Root) -> Option<Vec<Root>> {
    let n = matrices[0].len().isqrt();
    let powers = powers(rate)?;
    let entry = |i: usize, j: usize| {
        let own = matrices.iter().zip(&powers);
        let mut own = own.map(|(matrix, power)| matrix[i + n * j].mul(power));
        own.find_map(|entry| leading(&entry))
    };
    let mut units: Vec<Option<Root>> = vec![None; n];
    for first in 0..n {
        if units[first].is_some() {
            continue;
        }
        units[first] = match entry(first, first) {
            Some(own) => Some(own.recip()?.root().power(1, 2)?.whole_root()?),
            None => Some(Root::default()),
        };
        let mut todo = vec![first];
        while let Some(i) = todo.pop() {
            for j in 0..n {
                let (Some(unit), None) = (&units[i], &units[j]) else { continue };
                let Some(own) = entry(i, j) else { continue };
                units[j] = Some(own.mul(&root(unit)?)?.recip()?.whole_root()?);
                todo.push(j);
            }
        }
    }
    units.into_iter().collect()
}

/// The matrices in these units.
fn whole(matrices: &[Vec<Exact>; 3], rate: &Root, units: &[Root]) -> Option<Integers> {
    let n = units.len();
    let powers = powers(rate)?;
    let own = units.iter().map(root).collect::<Option<Vec<Surd>>>()?;
    let own: Vec<Exact> = own.into_iter().map(Exact::of).collect();
    let turned: [Vec<Exact>; 3] = array::from_fn(|k| {
        let entries = matrices[k].iter().enumerate();
        entries.map(|(at, entry)| entry.mul(&powers[k]).mul(&own[at % n]).mul(&own[at / n])).collect()
    });
    let terms = turned.iter().flatten().map(Exact::terms);
    let terms = terms.collect::<Option<Vec<_>>>()?;
    let field = Field::of(terms.into_iter().flatten())?;
    let mut numbers: [Vec<Number>; 3] = array::from_fn(|_| vec![Number::ZERO; (n * n) << field.0.len()]);
    for (numbers, matrix) in numbers.iter_mut().zip(&turned) {
        for (at, entry) in matrix.iter().enumerate() {
            for term in entry.terms()? {
                let (part, factor) = field.part(term)?;
                let place = &mut numbers[part * n * n + at];
                *place = place.add(&factor);
            }
        }
    }
    if numbers.iter().flatten().any(Number::is_oversized) {
        return None;
    }
    let common = common_denominator(numbers.iter().flatten());
    let whole = |entry: &Number| entry.numerator() * (&common / IBig::from(entry.denominator()));
    Some(Integers {
        matrices: numbers.map(|own| own.iter().map(whole).collect()),
        roots: field.0.iter().map(Number::numerator).collect(),
        rate: rate.clone(),
        coordinates: units.to_vec(),
    })
}
