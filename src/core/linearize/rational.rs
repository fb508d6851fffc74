//! M, G + C and K + N in exact numbers, where they are such only after functions and roots are worked out: sin(pi/2) is 1.
//!
//! The matrices are written out as expressions at the equilibrium, and the values of the parameters put in. A coordinate
//! that was searched for is taken for a simple number where all forces vanish there as expressions; it is the one that
//! the proof of the equilibrium encloses.

use super::assemble::evaluate_closed;
use super::constrained::{Tangent, gradients, solve_for};
use super::elimination::grows_from_zero;
use super::equilibrium::Origin;
use super::exact::{kernel_of_columns, recognised, three};
use super::flow::{Flow, Three};
use super::massless::rows;
use super::parameters::known_values;
use super::radicals::{Exact, Surd};
use super::rolling::SymbolicRolling;
use super::symbolic::{forces_vanish, matrices_at};
use super::{Linearized, multipliers};
use crate::expr::{ExprId, Pool, Substitution};
use crate::number::Number;
use crate::precision::{Ball, Function, Integers, Scalar};

/// Matrices of more rows are not written out.
const MOST: usize = 20;

/// More terms are not written out.
const MOST_TERMS: usize = 2_000;

/// M, G + C and K + N with whole entries, for the coordinates that the others follow.
pub(super) fn integers(linearized: &Linearized, flow: Option<&Flow>) -> Option<Integers> {
    super::integers::integers(&matrices(linearized, flow)?.0)
}

/// The vectors that K + N takes to 0 under conditions on velocities; `None` where it is not known exactly.
pub(super) fn unheld(linearized: &Linearized) -> Option<Vec<Vec<Surd>>> {
    let ([.., stiffness], _) = matrices(linearized, None)?;
    let columns: Vec<&[Exact]> = stiffness.chunks(stiffness.len().isqrt().max(1)).collect();
    kernel_of_columns(&columns)
}

/// For each coordinate that moves along a family of equilibria, by 1, how the free ones follow it so that no force acts; `None` where
/// forces can't vanish, or are not known exactly.
pub(super) fn following(linearized: &Linearized) -> Option<Vec<Vec<Surd>>> {
    let ([.., stiffness], shifts) = matrices(linearized, None)?;
    let n = stiffness.len().isqrt();
    let one = |shift: &[Exact]| {
        let columns: Vec<&[Exact]> = stiffness.chunks(n.max(1)).chain([shift]).collect();
        let vectors = kernel_of_columns(&columns)?.into_iter();
        let mut vector = vectors.into_iter().find(|vector| !vector[n].is_zero())?;
        let size = vector.pop()?.recip()?;
        vector.iter().map(|x| x.mul(&size)).collect()
    };
    shifts.chunks(n.max(1)).map(one).collect()
}

/// Whether coordinates that follow places under conditions on velocities move away as t² or faster with those of frequency 0; `None`
/// where the equilibrium is not known exactly.
pub(super) fn follows_away(linearized: &Linearized, rolling: &SymbolicRolling) -> Option<bool> {
    let mut pool = linearized.model.pool.clone();
    let known = known_there(linearized, &mut pool)?;
    let entries = rolling.pencil(&mut pool);
    let entries = entries.iter().map(|entry| pool.substitute(entry, &known)).collect::<Vec<_>>();
    grows_from_zero(&pool, &entries)
}

/// The values of parameters and of coordinates at the equilibrium, as expressions.
fn known_there(linearized: &Linearized, pool: &mut Pool) -> Option<Substitution> {
    let (model, point) = (&linearized.model, point(linearized, pool)?);
    let mut known = known_values(model);
    let point = pool.substitute(&point, &known);
    known.extend(model.coordinates.iter().map(|own| own.symbol).zip(point));
    Some(known)
}

/// M, G + C and K + N, for the coordinates that the others follow, and the forces that come with those which move along a family of
/// equilibria; column by column.
fn matrices(linearized: &Linearized, flow: Option<&Flow>) -> Option<(Three<Exact>, Vec<Exact>)> {
    let model = &linearized.model;
    let (visible, order) = (linearized.coordinates(), model.coordinates.len());
    let families = &linearized.assembly.families;
    let terms: usize = families.iter().map(|family| family.terms.count).sum();
    if order > MOST || terms > MOST_TERMS || linearized.unbalanced.is_some() {
        return None;
    }
    let mut pool = model.pool.clone();
    let mut known = known_values(model);
    let mut shifts = Vec::new();
    let matrices = match linearized.rolling() {
        // Written out already.
        Some(rolling) => {
            known = known_there(linearized, &mut pool)?;
            shifts = entries(&mut pool, &known, &rolling.symbolic.shifts)?;
            rolling.symbolic.matrices.clone()
        }
        None => {
            let point = point(linearized, &mut pool)?;
            let own = matrices_at(model, pool, &linearized.assembly, &point);
            pool = own.pool;
            [Some(own.mass), own.gyroscopic, own.damping, Some(own.stiffness), own.circulatory]
        }
    };
    let mut numbers = [const { None }; 5];
    for (own, rows) in numbers.iter_mut().zip(matrices) {
        *own = rows.map_or(Some(None), |rows| entries(&mut pool, &known, &rows).map(Some))?;
    }
    let mut all = three(numbers)?;
    // Friction at rest has no share in the rows of multipliers.
    if let Some(tied) = linearized.constrained.as_ref().filter(|own| own.rolling.is_none()) {
        let tangent = directions(gradients(&all[2], visible, order), &tied.bound, visible)?;
        all = all.map(|matrix| tangent.reduce(&matrix, order));
    }
    if let Some(massless) = linearized.massless() {
        let left = all[0].len().isqrt();
        let tangent = directions(rows(&massless.directions, &all[2], ()), &massless.following, left)?;
        all = all.map(|matrix| tangent.reduce(&matrix, left));
    }
    if let Some(flow) = flow {
        all = flow.regular(&all, pivot_size, ())?;
    }
    Some((all, shifts))
}

/// A matrix of expressions in numbers, column by column.
fn entries(pool: &mut Pool, known: &Substitution, rows: &[Vec<ExprId>]) -> Option<Vec<Exact>> {
    let width = rows.first().map_or(0, Vec::len);
    let columns = (0..width).flat_map(|column| rows.iter().map(move |row| row[column]));
    let entry = |e: ExprId| {
        let value = pool.substitute_one(e, known);
        exact(pool, value)
    };
    columns.map(entry).collect()
}

/// The equilibrium as expressions: what is given as it is, what was searched for as simple fractions.
fn point(linearized: &Linearized, pool: &mut Pool) -> Option<Vec<ExprId>> {
    let (model, equilibrium) = (&linearized.model, &linearized.equilibrium);
    let visible = linearized.coordinates();
    let mut point = Vec::with_capacity(equilibrium.values.len());
    let mut guessed = false;
    for (i, value) in equilibrium.values.iter().enumerate() {
        let stated = equilibrium.expression(model, i);
        point.push(match (equilibrium.origins[i], stated) {
            (_, Some(stated)) => stated,
            (Origin::Zero, None) if i < visible => pool.zero(),
            _ if i >= visible && equilibrium.multipliers_given => pool.zero(),
            _ => {
                guessed = true;
                simple(value, pool)?
            }
        });
    }
    if equilibrium.multipliers_given {
        let dependent = linearized.dependent_constraints();
        let constraints = model.constraints.iter().enumerate();
        let expressions: Vec<ExprId> =
            constraints.filter(|(number, _)| !dependent.contains(number)).map(|(_, own)| own.expression).collect();
        multipliers::put_in(model, &linearized.assembly, pool, &mut point, &expressions)?;
    }
    if !guessed {
        return Some(point);
    }
    let known = known_values(model);
    let mut valued = model.clone();
    valued.pool = pool.clone();
    let vanish = equilibrium.proved && forces_vanish(&valued, &linearized.assembly, &point, &known) == Some(true);
    vanish.then_some(point)
}

/// What an enclosure may hold: a fraction, a solution of a quadratic equation, such a part of pi, or an angle with such a cosine.
fn simple(value: &Ball, pool: &mut Pool) -> Option<ExprId> {
    let plain = |value: &Ball| recognised(value).filter(Exact::is_finite);
    if let Some(exact) = plain(value) {
        return written(&exact, pool);
    }
    let pi = pool.pi();
    let turns = *value / Ball::pi(());
    if let Some(part) = plain(&turns).filter(|part| part.as_rational().is_some()) {
        let part = written(&part, pool)?;
        return Some(pool.mul(part, pi));
    }
    let cosine = written(&plain(&value.apply(Function::Cos))?, pool)?;
    let angle = pool.apply(Function::Acos, cosine);
    let held = |angle: ExprId, pool: &Pool| {
        let angle = evaluate_closed::<Ball>(pool, angle, ());
        angle.is_some_and(|angle| (angle - *value).contains_zero())
    };
    if held(angle, pool) {
        return Some(angle);
    }
    let negative = pool.neg(angle);
    held(negative, pool).then_some(negative)
}

/// The number as an expression.
fn written(exact: &Exact, pool: &mut Pool) -> Option<ExprId> {
    let mut terms = Vec::new();
    for term in exact.terms()? {
        let [factor, radicand, exponent] = term.parts()?;
        let (factor, radicand) = (pool.number(factor), pool.number(radicand));
        let root = pool.powr(radicand, &exponent);
        terms.push(pool.mul(factor, root));
    }
    Some(pool.sum(&terms))
}

/// A constant expression as an exact number.
fn exact(pool: &Pool, e: ExprId) -> Option<Exact> {
    if let Some(number) = pool.as_number(e) {
        return (!number.is_oversized()).then(|| Exact::from_number(number, ()));
    }
    evaluate_closed::<Exact>(pool, e, ()).filter(Exact::is_finite).or_else(|| {
        let zero = pool.vanishes(e);
        zero.then(|| Exact::from_number(&Number::ZERO, ()))
    })
}

/// Directions that constraints allow.
fn directions(mut rows: Vec<Vec<Exact>>, bound: &[usize], visible: usize) -> Option<Tangent<Exact>> {
    solve_for(&mut rows, bound.iter().copied(), pivot_size, ())?;
    Some(Tangent::solved(visible, &rows, bound.to_vec()))
}

/// Any number but 0 will do for a pivot.
fn pivot_size(entry: &Exact) -> f64 {
    if entry.is_finite() && !entry.is_exact_zero() { 1.0 } else { 0.0 }
}
