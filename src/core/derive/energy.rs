//! Momenta, the energy function and the Hamiltonian, and the energies to second order about the equilibrium.

use std::collections::BTreeMap;

use super::equations::{both_ways, velocities};
use super::lagrangian::{Lagrangian, Variables};
use super::motion::{Factor, Motion, MotionPower, MotionSum, MotionTerm};
use super::shapes::determinant;
use super::simplify::{Algebra, common_factor, written};
use crate::expr::{ExprId, Pool, ZeroVerdict};
use crate::groups::connected;
use crate::number::Number;
use crate::order::Gather;

/// Squares of sums of momenta with more symbols help nobody.
const MOST_IN_SQUARES: u64 = 300;
/// More symbols above a fraction bar do not fit on a line.
const MOST_ABOVE_BAR: u64 = 36;

/// The generalized momenta p_i = dL/dq_i', one a coordinate.
pub(super) fn momenta(pool: &mut Algebra<'_>, variables: &Variables, lagrangian: &Lagrangian) -> Vec<MotionSum> {
    let terms = lagrangian.inertia.iter().flat_map(|((i, j), value)| {
        both_ways(*i, *j).map(|(i, j)| (i, MotionTerm::new(*value, &[(Motion::Velocity(j), 1)])))
    });
    let mut rows = terms.by_place(variables.coordinates.len());
    let mut rest: BTreeMap<usize, Vec<ExprId>> = lagrangian.linear.iter().map(|(i, own)| (*i, vec![*own])).gather();
    for term in &lagrangian.other {
        for (i, slope) in variables.symbols.velocity_slopes(pool, *term) {
            rest.entry(i).or_default().push(slope);
        }
    }
    for (i, parts) in rest {
        rows[i].push(MotionTerm::new(pool.short(|pool| pool.sum(&parts)), &[]));
    }
    rows.into_iter().map(|terms| MotionSum::new(pool, terms)).collect()
}

/// U = V - T0 and what is left of the terms of any form, in short.
fn without_velocities(pool: &mut Algebra<'_>, variables: &Variables, lagrangian: &Lagrangian) -> ExprId {
    let mut parts = lagrangian.potential.clone();
    for term in &lagrangian.other {
        parts.push(pool.neg(*term));
        let slopes = variables.symbols.velocity_slopes(pool, *term);
        parts.extend(slopes.into_iter().map(|(i, slope)| pool.times(slope, variables.velocities[i])));
    }
    let sum = pool.sum(&parts);
    pool.short_over_powers(sum)
}

/// h = sum q_i' dL/dq_i' - L in coordinates and velocities. Terms linear in the velocities drop out.
pub(super) fn energy_function(pool: &mut Algebra<'_>, variables: &Variables, lagrangian: &Lagrangian) -> MotionSum {
    let mut terms = Vec::new();
    for ((i, j), value) in &lagrangian.inertia {
        let value = if i == j { pool.scale(*value, &Number::half()) } else { *value };
        terms.push(MotionTerm::new(value, &velocities(*i, *j)));
    }
    terms.push(MotionTerm::new(without_velocities(pool, variables, lagrangian), &[]));
    MotionSum::new(pool, terms)
}

/// The Hamiltonian in coordinates and momenta, 1/2 (p - b)ᵀ A⁻¹ (p - b) + U; `None` where L is no quadratic polynomial in the
/// velocities, where A is singular or couples three coordinates, and where it would be too long.
///
/// A = L D Lᵀ makes squares of sums of momenta of it, one for each coordinate; of two coordinates A⁻¹ is written out instead where
/// that is not much longer, over one fraction bar where that is shorter.
pub(super) fn hamiltonian(pool: &mut Algebra<'_>, variables: &Variables, lagrangian: &Lagrangian) -> Option<MotionSum> {
    if !lagrangian.other.is_empty() {
        return None;
    }
    let inertia = &lagrangian.inertia;
    let (mut terms, mut powers) = (Vec::new(), Vec::new());
    for part in connected(variables.coordinates.len(), |i, j| inertia.contains_key(&(i.min(j), i.max(j)))) {
        if part.len() > 2 {
            return None;
        }
        let plain = part.iter().all(|i| !lagrangian.linear.contains_key(i));
        let found = squared(pool, &part, lagrangian)?;
        let weight: u64 = found.iter().map(|(factor, sum)| pool.weight(*factor) + sum.weight(pool)).sum();
        let expanded =
            if let ([i, j], true) = (part.as_slice(), plain) { inverse(pool, [*i, *j], lagrangian) } else { None };
        match expanded {
            Some(own) if own.weight <= 2 * weight => match own.over_bar {
                Some(over_bar) => powers.push(over_bar),
                None => terms.extend(own.terms),
            },
            _ if part.len() > 1 && weight > MOST_IN_SQUARES => return None,
            _ => powers.extend(found.into_iter().map(|(factor, sum)| MotionPower { factor, sum, power: 2 })),
        }
    }
    terms.push(MotionTerm::new(without_velocities(pool, variables, lagrangian), &[]));
    // The square of a momentum is a term.
    let one = pool.one();
    powers.retain(|MotionPower { factor, sum, power }| match sum.terms.as_slice() {
        [only] if *power == 2 && only.coefficient == one && only.motion.len() == 1 => {
            terms.push(MotionTerm::new(*factor, &[(only.motion[0].0, 2)]));
            false
        }
        _ => true,
    });
    Some(MotionSum { powers, ..MotionSum::new(pool, terms) })
}

/// 1/(2 d) and p - b for each row of L⁻¹ (p - b), the pivots d of the part in the order of their lengths.
fn squared(pool: &mut Algebra<'_>, part: &[usize], lagrangian: &Lagrangian) -> Option<Vec<(ExprId, MotionSum)>> {
    let n = part.len();
    let zero = pool.zero();
    let entry = |i: usize, j: usize| lagrangian.inertia.get(&(part[i].min(part[j]), part[i].max(part[j])));
    let mut rows: Vec<Vec<ExprId>> =
        (0..n).map(|i| (0..n).map(|j| entry(i, j).copied().unwrap_or(zero)).collect()).collect();
    // Factors of the momenta, then what is subtracted from them.
    let mut sums: Vec<Vec<ExprId>> = vec![vec![zero; n + 1]; n];
    for (i, sum) in sums.iter_mut().enumerate() {
        sum[i] = pool.one();
        sum[n] = lagrangian.linear.get(&part[i]).map_or(zero, |b| pool.neg(*b));
    }
    let mut open: Vec<usize> = (0..n).collect();
    let mut found = Vec::new();
    while !open.is_empty() {
        // H is defined only where the last pivot isn't 0 either.
        let last = open.len() == 1;
        let is_pivot = |verdict| verdict == ZeroVerdict::NonZero || last && verdict != ZeroVerdict::Zero;
        let pivots: Vec<usize> = open.iter().filter(|i| is_pivot(pool.is_zero(rows[**i][**i]))).copied().collect();
        let pivot = pivots.into_iter().min_by_key(|i| pool.weight(rows[*i][*i]))?;
        open.retain(|i| *i != pivot);
        let size = rows[pivot][pivot];
        for i in open.iter().copied().filter(|i| !rows[*i][pivot].is_zero()).collect::<Vec<_>>() {
            let share = pool.short(|pool| pool.div(rows[i][pivot], size));
            for j in &open {
                let product = pool.mul(share, rows[pivot][*j]);
                rows[i][*j] = pool.short(|pool| pool.sub(rows[i][*j], product));
            }
            for (own, by) in std::mem::take(&mut sums[i]).into_iter().zip(sums[pivot].clone()) {
                let product = pool.mul(share, by);
                sums[i].push(pool.short(|pool| pool.sub(own, product)));
            }
        }
        let half = pool.scale(size, &Number::from(2));
        let momenta = part.iter().map(|i| vec![(Motion::Momentum(*i), 1)]).chain([Vec::new()]);
        let terms = sums[pivot].iter().zip(momenta).map(|(factor, motion)| MotionTerm::new(*factor, &motion));
        let terms: Vec<MotionTerm> = terms.collect();
        found.push((pool.powi(half, -1), MotionSum::new(pool, terms)));
    }
    Some(found)
}

/// 1/2 pᵀ A⁻¹ p for two coordinates.
struct Inverse {
    /// How many symbols it takes to write the terms, roughly.
    weight: u64,
    /// Each with its own fraction bar.
    terms: Vec<MotionTerm>,
    /// All over one, where that is shorter.
    over_bar: Option<MotionPower>,
}

fn inverse(pool: &mut Algebra<'_>, [i, j]: [usize; 2], lagrangian: &Lagrangian) -> Option<Inverse> {
    let [a, b, c] = [(i, i), (i, j), (j, j)].map(|at| lagrangian.inertia.get(&at).copied());
    let (a, b, c) = (a?, b?, c?);
    let determinant = pool.short(|pool| determinant(pool, &[vec![a, b], vec![b, c]]));
    if pool.is_zero(determinant) != ZeroVerdict::NonZero {
        return None;
    }
    let [p, q] = [i, j].map(Motion::Momentum);
    let motions = [vec![(p, 2)], vec![(p, 1), (q, 1)], vec![(q, 2)]];
    // What all three have in common goes below the bar.
    let entries = [(c, 1), (b, -2), (a, 1)].map(|(e, by)| (pool.split_content(e), by));
    let number = entries.iter().fold(Number::ZERO, |all, ((number, _), by)| all.gcd(&number.mul(&Number::from(*by))));
    let common = common_factor(&entries.each_ref().map(|((_, core), _)| (pool.factors(*core), Number::ONE)));
    let divisor = written(pool, [(&common, &number)]);
    let bar = pool.short(|pool| {
        let both = pool.scale(determinant, &Number::from(2));
        pool.div(both, divisor)
    });
    let factor = pool.powi(bar, -1);
    let (mut terms, mut above) = (Vec::new(), Vec::new());
    for (((number, core), by), motion) in entries.into_iter().zip(motions) {
        let value = pool.scale(core, &number.mul(&Number::from(by)));
        above.push(MotionTerm::new(pool.short(|pool| pool.div(value, divisor)), &motion));
        let apart = pool.div(value, determinant);
        let apart = pool.scale(apart, &Number::half());
        terms.push(MotionTerm::new(pool.simplify(apart), &motion));
    }
    let mut weigh = |all: &[MotionTerm]| all.iter().map(|term| pool.weight(term.coefficient) + 3).sum::<u64>();
    let (apart, above_bar) = (weigh(&terms), weigh(&above));
    let together = above_bar + pool.weight(factor) + 2;
    let over_bar = (above_bar <= MOST_ABOVE_BAR && together < apart).then(|| MotionPower {
        factor,
        sum: MotionSum::new(pool, above),
        power: 1,
    });
    Some(Inverse { weight: apart, terms, over_bar })
}

/// 1/2 sum m_ij x_i x_j written out.
pub(super) fn quadratic_form(pool: &mut Pool, matrix: &[Vec<ExprId>], motion: impl Fn(usize) -> Motion) -> MotionSum {
    let mut terms = Vec::new();
    for (i, row) in matrix.iter().enumerate() {
        for (j, value) in row.iter().enumerate().skip(i) {
            terms.push(if i == j {
                MotionTerm::new(*value, &[(motion(i), 2)])
            } else {
                let twice = pool.scale(*value, &Number::from(2));
                MotionTerm::new(twice, &[(motion(i), 1), (motion(j), 1)])
            });
        }
    }
    let count = terms.iter().filter(|term| !term.coefficient.is_zero()).count();
    if count == 1 {
        terms.iter_mut().for_each(|term| term.coefficient = pool.scale(term.coefficient, &Number::half()));
    }
    let factor = if count > 1 { Factor::Half } else { Factor::One };
    MotionSum { factor, ..MotionSum::new(pool, terms) }
}
