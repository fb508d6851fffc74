//! Lagrange's equations, d/dt dL/dq_i' - dL/dq_i + dF/dq_i' - Q_i = 0.
//!
//! With L = 1/2 sum A_ij q_i' q_j' + sum b_i q_i' - U they are, coordinate by coordinate,
//!
//! ```text
//! sum_j A_ij q_j'' + sum_jk (dA_ij/dq_k - 1/2 dA_jk/dq_i) q_j' q_k' + sum_j (dA_ij/dt) q_j'
//!   + sum_j (db_i/dq_j - db_j/dq_i) q_j' + db_i/dt + dU/dq_i + dF/dq_i' - Q_i = 0
//! ```
//!
//! (Landau and Lifshitz, Mechanics, §5; Goldstein, Classical Mechanics, section 1.5 for F). The sums
//! run over the derivatives that are not 0, so that the work grows with what is printed.

use std::collections::BTreeMap;

use super::Linear;
use super::lagrangian::{Lagrangian, Variables};
use super::motion::{Motion, MotionSum, MotionTerm};
use super::simplify::Algebra;
use crate::expr::{ExprId, Pool};
use crate::number::Number;
use crate::order::Gather;

/// What moves, in ascending order, each with its power.
pub(super) type Factors = Vec<(Motion, u32)>;
/// By equation and what moves.
pub(super) type Coefficients = BTreeMap<(usize, Factors), ExprId>;
/// Likewise: the parts of the coefficient.
type Parts = BTreeMap<(usize, Factors), Vec<(ExprId, Number)>>;

/// q_i' q_j'
pub(super) fn velocities(i: usize, j: usize) -> Factors {
    if i == j {
        vec![(Motion::Velocity(i), 2)]
    } else {
        vec![(Motion::Velocity(i.min(j)), 1), (Motion::Velocity(i.max(j)), 1)]
    }
}

/// An entry of a symmetric matrix with its mirror image.
pub(super) fn both_ways(i: usize, j: usize) -> impl Iterator<Item = (usize, usize)> {
    [(i, j), (j, i)].into_iter().take(if i == j { 1 } else { 2 })
}

/// What moves alone.
pub(super) fn single(motion: Motion) -> Factors {
    vec![(motion, 1)]
}

/// The left sides of the equations of motion by equation and what moves.
pub(super) fn coefficients(pool: &mut Algebra<'_>, variables: &Variables, lagrangian: &Lagrangian) -> Coefficients {
    let mut parts = Parts::new();
    quadratic(pool, variables, lagrangian, &mut parts);
    linear(pool, variables, lagrangian, &mut parts);
    lagrangian.forces.iter().for_each(|(i, force)| add(&mut parts, *i, Factors::new(), *force, Number::ONE));
    lagrangian.other.iter().for_each(|term| general(pool, variables, *term, &mut parts));
    lagrangian.drags.iter().for_each(|(i, drag)| dragged(pool, variables, *i, *drag, &mut parts));
    parts.into_iter().map(|(key, parts)| (key, pool.short(|pool| pool.linear(&parts)))).gather()
}

/// The left sides of the equations of motion, one a coordinate.
pub(super) fn equations(pool: &mut Pool, variables: &Variables, coefficients: Coefficients) -> Vec<MotionSum> {
    let mut rows: Vec<Vec<MotionTerm>> = vec![Vec::new(); variables.coordinates.len()];
    for ((i, motion), coefficient) in coefficients {
        // Multipliers have no equation.
        if let Some(row) = rows.get_mut(i) {
            row.push(MotionTerm::new(coefficient, &motion));
        }
    }
    rows.into_iter().map(|terms| MotionSum::new(pool, terms)).collect()
}

fn add(parts: &mut Parts, equation: usize, motion: Factors, value: ExprId, factor: Number) {
    parts.entry((equation, motion)).or_default().push((value, factor));
}

/// From T2: each A_ij with i < j stands for A_ij q_i' q_j', each A_ii for 1/2 A_ii q_i'^2.
fn quadratic(pool: &mut Pool, variables: &Variables, lagrangian: &Lagrangian, parts: &mut Parts) {
    for ((i, j), value) in &lagrangian.inertia {
        let slopes = variables.symbols.slopes(pool, *value);
        let rate = variables.by_time(pool, *value);
        let share = if i == j { Number::half() } else { Number::ONE };
        slopes.iter().for_each(|(k, slope)| add(parts, *k, velocities(*i, *j), *slope, share.neg()));
        for (i, j) in both_ways(*i, *j) {
            add(parts, i, single(Motion::Acceleration(j)), *value, Number::ONE);
            slopes.iter().for_each(|(k, slope)| add(parts, i, velocities(j, *k), *slope, Number::ONE));
            add(parts, i, single(Motion::Velocity(j)), rate, Number::ONE);
        }
    }
}

/// From T1 = sum b_i q_i'.
fn linear(pool: &mut Pool, variables: &Variables, lagrangian: &Lagrangian, parts: &mut Parts) {
    for (i, value) in &lagrangian.linear {
        for (j, slope) in variables.symbols.slopes(pool, *value) {
            if j != *i {
                add(parts, *i, single(Motion::Velocity(j)), slope, Number::ONE);
                add(parts, j, single(Motion::Velocity(*i)), slope, Number::MINUS_ONE);
            }
        }
        let rate = variables.by_time(pool, *value);
        add(parts, *i, Factors::new(), rate, Number::ONE);
    }
}

/// From a term of L of any form.
fn general(pool: &mut Pool, variables: &Variables, term: ExprId, parts: &mut Parts) {
    for (i, slope) in variables.symbols.slopes(pool, term) {
        let force = pool.neg(slope);
        dragged(pool, variables, i, force, parts);
    }
    for (i, momentum) in variables.symbols.velocity_slopes(pool, term) {
        for (j, value) in variables.symbols.velocity_slopes(pool, momentum) {
            add(parts, i, single(Motion::Acceleration(j)), value, Number::ONE);
        }
        for (j, value) in variables.symbols.slopes(pool, momentum) {
            add(parts, i, single(Motion::Velocity(j)), value, Number::ONE);
        }
        let rate = variables.by_time(pool, momentum);
        add(parts, i, Factors::new(), rate, Number::ONE);
    }
}

/// From what friction or a generalised force adds to an equation, velocities apart where it is linear in them.
fn dragged(pool: &mut Pool, variables: &Variables, i: usize, drag: ExprId, parts: &mut Parts) {
    let bends = variables.symbols.velocity_slopes(pool, drag);
    let at_rest = variables.at_rest(pool);
    let rest = pool.substitute_one(drag, &at_rest);
    // The slope of v/|v| is 0 as well.
    if pool.is_undefined(rest) || bends.iter().any(|(_, bend)| variables.moves(pool, *bend)) {
        add(parts, i, Factors::new(), drag, Number::ONE);
        return;
    }
    for (j, bend) in bends {
        add(parts, i, single(Motion::Velocity(j)), bend, Number::ONE);
    }
    add(parts, i, Factors::new(), rest, Number::ONE);
}

/// M q'' + (G + C) q' + (K + N) q = 0, row by row, with q measured from the equilibrium.
pub(super) fn linearized(pool: &mut Pool, linear: &Linear) -> Vec<MotionSum> {
    let motions = [Motion::Displacement, Motion::Velocity, Motion::Acceleration];
    let n = linear.mass.len();
    (0..n)
        .map(|i| {
            let mut parts = Vec::with_capacity(3 * n);
            for j in 0..n {
                let entries = linear.entry(pool, i, j).into_iter().zip(motions);
                parts.extend(entries.map(|(value, motion)| MotionTerm::new(value, &single(motion(j)))));
            }
            MotionSum::new(pool, parts)
        })
        .collect()
}
