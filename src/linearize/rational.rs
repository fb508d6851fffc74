//! M, G + C and K + N in fractions, where they are such only after functions and roots are worked out: sin(pi/2) is 1.
//!
//! The matrices are written out as expressions at the equilibrium, and the values of the parameters put in. A coordinate
//! that was searched for is taken for a simple fraction where all forces vanish there as expressions; it is the one that
//! the proof of the equilibrium encloses.

use dashu_int::ops::Gcd;
use dashu_int::{IBig, UBig};

use super::Linearized;
use super::assemble::known_values;
use super::equilibrium::Origin;
use super::multipliers;
use super::symbolic::{forces_vanish, matrices_at};
use crate::expr::{ExprId, Pool, ZeroVerdict};
use crate::number::Number;
use crate::precision::Ball;

/// Matrices of more rows are not written out.
const MOST: usize = 20;

/// More terms are not written out.
const MOST_TERMS: usize = 2_000;

/// Fractions with denominators up to here are simple.
const MOST_DENOMINATOR: u32 = 1_000;

/// Dense, column by column.
type Fractions = Vec<Number>;

/// M, G + C and K + N times one positive number, column by column, for the coordinates that the others follow.
pub(super) fn integers(linearized: &Linearized) -> Option<[Vec<IBig>; 3]> {
    let model = &linearized.model;
    let (visible, order) = (linearized.coordinates(), model.coordinates.len());
    let families = &linearized.assembly.families;
    let terms: usize = families.iter().map(|family| family.terms.count).sum();
    if order > MOST || terms > MOST_TERMS || linearized.unbalanced.is_some() {
        return None;
    }
    let mut pool = model.pool.clone();
    let point = point(linearized, &mut pool)?;
    let matrices = matrices_at(model, pool, &linearized.assembly, &point);
    let known = known_values(model);
    let mut pool = matrices.pool;
    let mut fractions = |rows: &Vec<Vec<ExprId>>| -> Option<Fractions> {
        let mut numbers = vec![Number::ZERO; order * order];
        for (i, row) in rows.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                let value = pool.substitute_one(*entry, &known);
                numbers[i + order * j] = fraction(&pool, value)?;
            }
        }
        Some(numbers)
    };
    let mass = fractions(&matrices.mass)?;
    let mut stiffness = fractions(&matrices.stiffness)?;
    let gradients: Vec<Vec<Number>> = (visible..order)
        .map(|row| {
            (0..visible)
                .map(|i| stiffness[row + order * i].clone())
                .collect()
        })
        .collect();
    let mut velocity = vec![Number::ZERO; order * order];
    let others = [
        (&matrices.gyroscopic, false),
        (&matrices.damping, false),
        (&matrices.circulatory, true),
    ];
    for (rows, is_circulatory) in others {
        let Some(rows) = rows else { continue };
        let into = if is_circulatory {
            &mut stiffness
        } else {
            &mut velocity
        };
        for (entry, part) in into.iter_mut().zip(fractions(rows)?) {
            *entry = entry.add(&part);
        }
    }
    let all = [mass, velocity, stiffness];
    let Some(constrained) = &linearized.constrained else {
        return whole(&all);
    };
    let tangent = directions(gradients, &constrained.bound, visible)?;
    whole(&all.map(|matrix| reduced(&matrix, order, &tangent)))
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
                let simple = simple(value)?;
                pool.number(simple)
            }
        });
    }
    if equilibrium.multipliers_given {
        let dependent = linearized.dependent_constraints();
        let constraints = model.constraints.iter().enumerate();
        let expressions: Vec<ExprId> = constraints
            .filter(|(number, _)| !dependent.contains(number))
            .map(|(_, own)| own.expression)
            .collect();
        multipliers::put_in(model, &linearized.assembly, pool, &mut point, &expressions)?;
    }
    if !guessed {
        return Some(point);
    }
    let known = known_values(model);
    let mut valued = model.clone();
    valued.pool = pool.clone();
    let vanish = equilibrium.proved
        && forces_vanish(&valued, &linearized.assembly, &point, &known) == Some(true);
    vanish.then_some(point)
}

/// The fraction of the smallest denominator in an enclosure, if that is small.
fn simple(value: &Ball) -> Option<Number> {
    (1..=MOST_DENOMINATOR).find_map(|denominator| {
        let scaled = *value * Ball::from(f64::from(denominator));
        let nearest = scaled.mid_f64().round();
        if nearest.abs() > 1e15 || !(scaled - Ball::from(nearest)).contains_zero() {
            return None;
        }
        Number::ratio(nearest as i64, i64::from(denominator))
    })
}

/// A constant expression as a fraction.
fn fraction(pool: &Pool, e: ExprId) -> Option<Number> {
    match pool.as_number(e) {
        Some(number) => (!number.is_oversized()).then(|| number.clone()),
        None => (pool.is_zero(e) == ZeroVerdict::Zero).then_some(Number::ZERO),
    }
}

/// Directions that constraints allow: row by row, one column a free coordinate.
fn directions(
    mut rows: Vec<Vec<Number>>,
    bound: &[usize],
    visible: usize,
) -> Option<Vec<Vec<Number>>> {
    for (at, column) in bound.iter().enumerate() {
        let found = (at..rows.len()).find(|row| !rows[*row][*column].is_zero())?;
        rows.swap(at, found);
        let inverse = rows[at][*column].recip()?;
        let pivot: Vec<Number> = rows[at].iter().map(|x| x.mul(&inverse)).collect();
        for (row, own) in rows.iter_mut().enumerate() {
            let factor = own[*column].clone();
            if row != at && !factor.is_zero() {
                for (entry, above) in own.iter_mut().zip(&pivot) {
                    *entry = entry.sub(&factor.mul(above));
                }
            }
        }
        rows[at] = pivot;
    }
    let free: Vec<usize> = (0..visible).filter(|i| !bound.contains(i)).collect();
    let direction = |i: usize| {
        let follows = bound.iter().position(|own| *own == i);
        let component = |own: &usize| match follows {
            Some(row) => rows[row][*own].neg(),
            None if *own == i => Number::ONE,
            None => Number::ZERO,
        };
        free.iter().map(component).collect()
    };
    Some((0..visible).map(direction).collect())
}

/// ZᵀAZ.
fn reduced(matrix: &Fractions, order: usize, z: &[Vec<Number>]) -> Fractions {
    let m = z.first().map_or(0, Vec::len);
    let mut result = vec![Number::ZERO; m * m];
    for (i, left) in z.iter().enumerate() {
        for (j, right) in z.iter().enumerate() {
            let entry = &matrix[i + order * j];
            if entry.is_zero() {
                continue;
            }
            for (a, x) in left.iter().enumerate().filter(|(_, x)| !x.is_zero()) {
                let part = entry.mul(x);
                for (b, y) in right.iter().enumerate().filter(|(_, y)| !y.is_zero()) {
                    result[a + m * b] = result[a + m * b].add(&part.mul(y));
                }
            }
        }
    }
    result
}

/// The matrices times one positive number that makes them whole.
pub(super) fn whole(matrices: &[Fractions; 3]) -> Option<[Vec<IBig>; 3]> {
    let mut common = UBig::ONE;
    for entry in matrices.iter().flatten() {
        if entry.is_oversized() {
            return None;
        }
        let denominator = entry.denominator();
        let shared = (&common).gcd(&denominator);
        common *= denominator / shared;
    }
    let common = IBig::from(common);
    let whole = |entry: &Number| entry.numerator() * (&common / IBig::from(entry.denominator()));
    Some(
        matrices
            .each_ref()
            .map(|entries| entries.iter().map(whole).collect()),
    )
}
