//! Momenta, the energy function and the Hamiltonian, and the energies to second order about the equilibrium.

use std::collections::BTreeMap;

use super::lagrangian::{Lagrangian, Variables};
use super::motion::{Factor, Motion, MotionSum, MotionTerm};
use super::simplify::Simplifier;
use crate::expr::{ExprId, Pool, ZeroVerdict};
use crate::number::Number;

/// The generalized momenta p_i = dL/dq_i', one a coordinate.
pub(super) fn momenta(
    pool: &mut Pool,
    short: &mut Simplifier,
    variables: &Variables,
    lagrangian: &Lagrangian,
) -> Vec<MotionSum> {
    let mut rows: Vec<Vec<MotionTerm>> = vec![Vec::new(); variables.coordinates.len()];
    let mut push = |i: usize, term: MotionTerm| {
        if let Some(row) = rows.get_mut(i) {
            row.push(term);
        }
    };
    for ((i, j), value) in &lagrangian.inertia {
        push(*i, MotionTerm::new(*value, &[(Motion::Velocity(*j), 1)]));
        if i != j {
            push(*j, MotionTerm::new(*value, &[(Motion::Velocity(*i), 1)]));
        }
    }
    let mut rest: BTreeMap<usize, Vec<ExprId>> = BTreeMap::new();
    for (i, value) in &lagrangian.linear {
        rest.entry(*i).or_default().push(*value);
    }
    for term in &lagrangian.other {
        for (i, slope) in variables.velocity_slopes(pool, *term) {
            rest.entry(i).or_default().push(slope);
        }
    }
    for (i, parts) in rest {
        let sum = pool.sum(&parts);
        push(i, MotionTerm::new(short.simplify(pool, sum), &[]));
    }
    let rows = rows.into_iter();
    rows.map(|terms| MotionSum::new(pool, terms)).collect()
}

/// U = V - T0 and what is left of the terms of any form, in short.
fn without_velocities(
    pool: &mut Pool,
    short: &mut Simplifier,
    variables: &Variables,
    lagrangian: &Lagrangian,
) -> ExprId {
    let mut parts = lagrangian.potential.clone();
    for term in &lagrangian.other {
        parts.push(pool.neg(*term));
        for (i, slope) in variables.velocity_slopes(pool, *term) {
            if let Some(velocity) = variables.velocities.get(i) {
                let velocity = pool.symbol_expr(*velocity);
                parts.push(pool.mul(velocity, slope));
            }
        }
    }
    let sum = pool.sum(&parts);
    short.simplify(pool, sum)
}

/// h = sum q_i' dL/dq_i' - L in coordinates and velocities. Terms linear in the velocities drop out.
pub(super) fn energy_function(
    pool: &mut Pool,
    short: &mut Simplifier,
    variables: &Variables,
    lagrangian: &Lagrangian,
) -> MotionSum {
    let mut terms = Vec::new();
    for ((i, j), value) in &lagrangian.inertia {
        terms.push(if i == j {
            let half = pool.scale(*value, &Number::half());
            MotionTerm::new(half, &[(Motion::Velocity(*i), 2)])
        } else {
            MotionTerm::new(*value, &[(Motion::Velocity(*i), 1), (Motion::Velocity(*j), 1)])
        });
    }
    let rest = without_velocities(pool, short, variables, lagrangian);
    terms.push(MotionTerm::new(rest, &[]));
    MotionSum::new(pool, terms)
}

/// The Hamiltonian in coordinates and momenta, 1/2 (p - b)ᵀ A⁻¹ (p - b) + U, where A is diagonal or
/// two by two; `None` where it is not, where L is no quadratic polynomial in the velocities, or where
/// A is singular.
pub(super) fn hamiltonian(
    pool: &mut Pool,
    short: &mut Simplifier,
    variables: &Variables,
    lagrangian: &Lagrangian,
) -> Option<MotionSum> {
    if !lagrangian.other.is_empty() {
        return None;
    }
    let count = variables.coordinates.len();
    let inverse = inverse(pool, short, count, &lagrangian.inertia)?;
    let mut terms: BTreeMap<Vec<(Motion, u32)>, Vec<ExprId>> = BTreeMap::new();
    let mut add = |motion: &[(Motion, u32)], value: ExprId| {
        terms.entry(motion.to_vec()).or_default().push(value);
    };
    let b = |i: usize| lagrangian.linear.get(&i).copied();
    for ((i, j), value) in inverse {
        let half = pool.scale(value, &Number::half());
        if i == j {
            add(&[(Motion::Momentum(i), 2)], half);
            if let Some(b) = b(i) {
                let crossed = pool.mul(value, b);
                add(&[(Motion::Momentum(i), 1)], pool.neg(crossed));
                let square = pool.square(b);
                add(&[], pool.mul(half, square));
            }
        } else {
            add(&[(Motion::Momentum(i), 1), (Motion::Momentum(j), 1)], value);
            for (own, other) in [(i, j), (j, i)] {
                if let Some(b) = b(other) {
                    let crossed = pool.mul(value, b);
                    add(&[(Motion::Momentum(own), 1)], pool.neg(crossed));
                }
            }
            if let (Some(left), Some(right)) = (b(i), b(j)) {
                add(&[], pool.product(&[value, left, right]));
            }
        }
    }
    let rest = without_velocities(pool, short, variables, lagrangian);
    add(&[], rest);
    Some(MotionSum::of_parts(pool, short, terms))
}

/// The inverse of A on and above the diagonal.
fn inverse(
    pool: &mut Pool,
    short: &mut Simplifier,
    count: usize,
    inertia: &BTreeMap<(usize, usize), ExprId>,
) -> Option<BTreeMap<(usize, usize), ExprId>> {
    let mut result = BTreeMap::new();
    if inertia.keys().all(|(i, j)| i == j) {
        for i in 0..count {
            let value = inertia.get(&(i, i))?;
            result.insert((i, i), pool.powi(*value, -1));
        }
        return Some(result);
    }
    if count != 2 {
        return None;
    }
    let zero = pool.zero();
    let entry = |i, j| inertia.get(&(i, j)).copied().unwrap_or(zero);
    let (a, b, c) = (entry(0, 0), entry(0, 1), entry(1, 1));
    let diagonal = pool.mul(a, c);
    let square = pool.square(b);
    let determinant = pool.sub(diagonal, square);
    let determinant = short.simplify(pool, determinant);
    if pool.is_zero(determinant) != ZeroVerdict::NonZero {
        return None;
    }
    let opposite = pool.neg(b);
    for (place, value) in [((0, 0), c), ((0, 1), opposite), ((1, 1), a)] {
        result.insert(place, pool.div(value, determinant));
    }
    Some(result)
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
        for term in &mut terms {
            term.coefficient = pool.scale(term.coefficient, &Number::half());
        }
    }
    let mut sum = MotionSum::new(pool, terms);
    if count > 1 {
        sum.factor = Factor::Half;
    }
    sum
}
