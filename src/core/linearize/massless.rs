//! Directions without inertia: static condensation.
//!
//! Where M v = 0 for a basis v of directions that no force meets which goes with velocities, the equations of motion along them are
//! vᵀ(K + N)q = 0, as if they were constraints. Where vᵀ(K + N)v is regular they say how these directions follow the others, and the
//! matrices are reduced to what is left, as under constraints (R. J. Guyan, Reduction of stiffness and mass matrices, AIAA J. 3 (1965)
//! 380; exact where what is left out has no mass). *That there is no inertia is exact, never that it is small.*

use faer::{Mat, Side};

use super::assemble::{Assembly, Part, Values};
use super::constrained::{self, Tangent};
use super::error::{Inertia, LinearizeError};
use super::radicals::Surd;
use super::{Linearized, MOST_COORDINATES, dependence, exact};
use crate::number::Number;
use crate::precision::{Ball, Enclosure, Scalar};

/// A vector by its components that are not 0.
pub(super) type Direction = Vec<(usize, Surd)>;

/// Directions without inertia that follow the others.
#[derive(Clone, Debug)]
pub(super) struct Massless {
    /// Independent of each other, in the coordinates that constraints leave.
    pub(super) directions: Vec<Direction>,
    /// The coordinates that follow, one for each.
    pub(super) following: Vec<usize>,
    pub(super) tangent: Tangent<Ball>,
}

/// The directions without inertia of a model with its equilibrium and constraints, or what they have that nothing can make follow; `None`
/// where every motion has inertia, or that is not known.
pub(super) fn find(own: &Linearized) -> Option<Result<Massless, LinearizeError>> {
    let directions = directions(own);
    if directions.is_empty() {
        return None;
    }
    let (_, stiffness) = own.velocity_and_stiffness();
    if let Some(error) = unheld(own, &directions, &stiffness) {
        return Some(Err(error));
    }
    let in_balls = followed(&directions, &stiffness, ());
    let found = in_balls.or_else(|| {
        let bits = dependence::bits(own.measured_model())?;
        let (tangent, following) = followed(&directions, &own.precisely(bits)?.stiffness, bits)?;
        Some((tangent.to_balls(), following))
    });
    Some(match found {
        Some((tangent, following)) => Ok(Massless { directions, following, tangent }),
        None => {
            let (combination, span) = named(own, directions.first()?);
            Err(LinearizeError::NotCondensed { combination, span })
        }
    })
}

/// The motions left where vᵀ(K + N)v is regular, and the coordinates that follow.
fn followed<S: Enclosure>(
    directions: &[Direction],
    stiffness: &[S],
    precision: S::Precision,
) -> Option<(Tangent<S>, Vec<usize>)> {
    let rows = rows(directions, stiffness, precision);
    let alone: Vec<usize> =
        directions.iter().filter_map(|own| own.first().filter(|_| own.len() == 1)).map(|(i, _)| *i).collect();
    if alone.len() == directions.len() {
        return Some((Tangent::new(&rows, &alone, precision)?, alone));
    }
    let inner: Vec<Vec<S>> =
        rows.iter().map(|row| directions.iter().map(|v| product(v, |i| &row[i], precision)).collect()).collect();
    constrained::choose_bound(&inner, None, precision)?;
    // Of the coordinates that the directions move, where these will do.
    let support: Vec<usize> = directions.iter().flatten().map(|(i, _)| *i).collect();
    let among = constrained::choose_bound(&rows, Some(&support), precision);
    let following = among.or_else(|| constrained::choose_bound(&rows, None, precision))?;
    Some((Tangent::new(&rows, &following, precision)?, following))
}

/// vᵀA, a row for each direction.
pub(super) fn rows<S: Scalar>(directions: &[Direction], matrix: &[S], precision: S::Precision) -> Vec<Vec<S>> {
    directions.iter().map(|v| row(v, matrix, precision)).collect()
}

/// vᵀA.
pub(super) fn row<S: Scalar>(v: &Direction, matrix: &[S], precision: S::Precision) -> Vec<S> {
    let n = matrix.len().isqrt();
    (0..n).map(|j| product(v, |i| &matrix[i + n * j], precision)).collect()
}

/// vᵀx.
pub(super) fn product<'a, S: Scalar + 'a>(v: &Direction, entry: impl Fn(usize) -> &'a S, precision: S::Precision) -> S {
    let parts =
        v.iter().filter(|(i, _)| !entry(*i).is_exact_zero()).map(|(i, x)| entry(*i).mul(&x.in_numbers(precision)));
    parts.fold(S::from_number(&Number::ZERO, precision), |sum, part| sum.add(&part))
}

/// Those whose force no motion changes, exactly.
fn unheld(own: &Linearized, directions: &[Direction], stiffness: &[Ball]) -> Option<LinearizeError> {
    let free = rows(directions, stiffness, ()).iter().position(|row| row.iter().all(Ball::is_zero));
    let direction = match free {
        Some(at) => directions[at].clone(),
        None if own.is_constrained() => return None,
        None => exact::unheld(own, directions)?,
    };
    let (combination, span) = named(own, &direction);
    Some(LinearizeError::SingularMass { combination, inertia: Inertia::NoneAndFree, span })
}

/// Which of so many coordinates move something at a point, and whether some do together.
pub(super) fn moved(assembly: &Assembly, at: &[Ball], values: &Values<Ball>, count: usize) -> (Vec<bool>, bool) {
    let mut moved = vec![false; count];
    let mut coupled = false;
    assembly.entries(Part::Inertia, at, values, |i, j, share| {
        if !share.is_zero() {
            moved[i as usize] = true;
            moved[j as usize] = true;
            coupled |= i != j;
        }
    });
    (moved, coupled)
}

fn moved_at(own: &Linearized, at: &[Ball]) -> (Vec<bool>, bool) {
    moved(&own.assembly, at, &own.values, own.model.coordinates.len())
}

/// The coordinates that move nothing at the equilibrium and beside it, among those that are left.
fn alone(own: &Linearized, here: &[bool]) -> Vec<usize> {
    if here[..own.coordinates()].iter().all(|moved| *moved) {
        return Vec::new();
    }
    let (nearby, _) = moved_at(own, &own.nearby());
    let free = own.free_coordinates().into_iter().enumerate();
    let mut alone: Vec<usize> = free.filter(|(_, i)| !here[*i] && !nearby[*i]).map(|(at, _)| at).collect();
    if own.is_reduced() {
        // What follows a coordinate may have inertia.
        let (n, mass) = (own.dimension(), own.mass());
        alone.retain(|i| (0..n).all(|j| mass[i + n * j].is_zero()));
    }
    alone
}

/// The coordinates that are left and have no inertia.
pub(super) fn resting(own: &Linearized) -> Vec<usize> {
    alone(own, &moved_at(own, &own.equilibrium.values).0)
}

/// The directions without inertia that no force meets which goes with velocities.
fn directions(own: &Linearized) -> Vec<Direction> {
    let n = own.dimension();
    if n > MOST_COORDINATES {
        return Vec::new();
    }
    let (here, coupled) = moved_at(own, &own.equilibrium.values);
    let all = alone(own, &here);
    let mut alone = all.clone();
    if !alone.is_empty() && !own.assembly.velocity.is_empty() {
        let matrices: Vec<Vec<Ball>> = [own.gyroscopic(), own.damping()].into_iter().flatten().collect();
        let pair = |a: &Vec<Ball>, i: usize, j: usize| a[i + n * j].is_zero() && a[j + n * i].is_zero();
        alone.retain(|i| (0..n).all(|j| matrices.iter().all(|a| pair(a, *i, j))));
    }
    if !own.is_constrained()
        && n <= exact::MOST
        && (alone.len() < all.len() || coupled && may_be_singular(n, &own.mass()))
        && let Some(vectors) = exact::without_inertia(own, false)
    {
        return vectors;
    }
    alone.into_iter().map(unit).collect()
}

/// A coordinate by itself.
pub(super) fn unit(coordinate: usize) -> Direction {
    vec![(coordinate, Surd::rational(Number::ONE))]
}

/// All directions without inertia, where M couples coordinates and may be singular.
pub(super) fn kernel_of_mass(own: &Linearized) -> Option<Vec<Direction>> {
    let n = own.coordinates();
    if own.is_constrained() || n > exact::MOST || !moved_at(own, &own.equilibrium.values).1 {
        return None;
    }
    let mass = own.assembly.mass(&own.equilibrium.values, &own.values);
    may_be_singular(n, &mass).then(|| exact::without_inertia(own, true))?
}

/// The coordinates that move together in a direction, and where the first is declared.
fn named(own: &Linearized, direction: &Direction) -> (Vec<(String, f64)>, crate::span::Span) {
    let mut motion = vec![0.0; own.dimension()];
    for (i, x) in direction {
        motion[*i] = x.in_numbers::<Ball>(()).mid_f64();
    }
    let mut motion = own.embed(&motion, 0.0).0;
    if let Some(units) = own.units() {
        units.direction(&mut motion);
    }
    let largest = motion.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let moving: Vec<usize> = (0..motion.len()).filter(|i| motion[*i].abs() > 1e-6 * largest).collect();
    let coordinates = &own.model().coordinates;
    let first = moving.first().map_or(1.0, |i| motion[*i].signum());
    let combination = moving.iter().map(|i| (coordinates.at(*i).name(), first * motion[*i] / largest));
    (combination.collect(), moving.first().map(|i| coordinates.at(*i).span).unwrap_or_default())
}

/// Whether a Cholesky decomposition of K, or of M, in doubles fails or nearly does: only then its kernel is
/// searched for. A false alarm costs time, nothing else; a matrix that is positive by a clear margin has
/// no kernel.
pub(crate) fn may_be_singular(n: usize, matrix: &[Ball]) -> bool {
    let doubles = Mat::from_fn(n, n, |i, j| matrix[i + n * j].mid_f64());
    let Ok(factor) = doubles.llt(Side::Lower) else { return true };
    // A clear margin: far above what rounding can leave of a pivot that is zero.
    let is_clear = |k: usize| factor.L()[(k, k)] * factor.L()[(k, k)] > 1e-7 * doubles[(k, k)].abs();
    !(0..n).all(is_clear)
}
