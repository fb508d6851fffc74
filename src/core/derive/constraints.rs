//! Constraints on the page: multipliers, the directions that are left, and M and K among them.
//!
//! With A the gradients of the constraints at the equilibrium, A q = 0 is solved for as many displacements as there are
//! constraints: q = Z y. M and K of the free displacements y are ZᵀMZ and ZᵀKZ, where K has the curvature of the constraints in
//! it (Lagrange's multipliers; Goldstein, Classical Mechanics, section 2.4).

use super::check::Checker;
use super::lagrangian::Variables;
use super::motion::{Motion, MotionSum, MotionTerm, Names};
use super::shapes::determinant;
use super::simplify::Algebra;
use super::{Derivation, Linear, Parts};
use crate::expr::{ExprId, Pool, Symbol};
use crate::linearize::{self, Eliminated, SymbolicMatrices, SymbolicRolling, Tied};
use crate::model::Model;
use crate::order::Order;

/// Determinants of so many rows are written out.
pub(super) const MOST_BY_DETERMINANTS: usize = 3;

/// A matrix, row by row.
type Rows = Vec<Vec<ExprId>>;
/// Free coordinates, Z, and K where it is known with it.
type Directions = (Vec<usize>, Rows, Option<Rows>);

/// Constraints, one entry each for those that don't follow from others.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Constraints {
    /// What the multipliers are called.
    pub names: Vec<String>,
    /// What is set to zero.
    pub expressions: Vec<ExprId>,
    /// How many follow from the others, and have no multiplier.
    pub dependent: usize,
}

impl Constraints {
    pub(super) fn new(tied: Option<&Tied>, rolling: &Rolling, redundant: usize) -> Option<Self> {
        let mut expressions = tied.map_or_else(Vec::new, Tied::expressions);
        let mut names = tied.map_or_else(Vec::new, Tied::names);
        expressions.extend(&rolling.expressions);
        names.extend(rolling.names.iter().cloned());
        let dependent = redundant + tied.map_or(0, |tied| tied.dependent.len());
        (!expressions.is_empty()).then_some(Self { names, expressions, dependent })
    }
}

/// Conditions on velocities with their multipliers (Lagrange and d'Alembert): the force on q_i is the sum of mu_a ∂f_a/∂q_i'.
pub(super) struct Rolling {
    pub(super) names: Vec<String>,
    pub(super) multipliers: Vec<ExprId>,
    /// f_a(q, q'), linear in q'.
    expressions: Vec<ExprId>,
    /// Whether their forces do no work: no condition has a part without velocities.
    pub(super) idle: bool,
}

impl Rolling {
    pub(super) fn new(model: &Model, pool: &mut Pool) -> Self {
        let family = model.unused_name(&["mu", "kappa", "nu"]);
        let name = |at: usize| if model.rolling.len() == 1 { family.clone() } else { format!("{family}[{}]", at + 1) };
        let names: Vec<String> = (0..model.rolling.len()).map(name).collect();
        let symbols: Vec<Symbol> = names.iter().map(|name| pool.symbol(name)).collect();
        let expressions: Vec<ExprId> = model.rolling.iter().map(|own| own.expression).collect();
        let idle = expressions.iter().all(|own| model.at_rest(pool, *own).is_zero());
        Self { names, multipliers: symbols.iter().map(|own| pool.symbol_expr(*own)).collect(), expressions, idle }
    }

    /// What they add to the left sides of the equations, by coordinate.
    pub(super) fn drags(&self, pool: &mut Pool, variables: &Variables) -> Vec<(usize, ExprId)> {
        let mut drags = Vec::new();
        for (multiplier, condition) in self.multipliers.iter().zip(&self.expressions) {
            for (i, slope) in variables.symbols.velocity_slopes(pool, *condition) {
                let force = pool.mul(*multiplier, slope);
                drags.push((i, pool.neg(force)));
            }
        }
        drags
    }
}

/// The directions that constraints allow at the equilibrium, or in which massless coordinates follow the others.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Tangent {
    /// The massless coordinates, by number; none under constraints.
    pub massless: Vec<usize>,
    /// The multipliers at the equilibrium; one that was found numerically stands as itself.
    pub multipliers: Vec<ExprId>,
    /// The gradients of the constraints, one row each; without constraints the rows of K + N of the massless coordinates.
    pub gradients: Vec<Vec<ExprId>>,
    /// What conditions on velocities leave, before it is brought to its shortest form.
    rolling: Option<SymbolicRolling>,
    /// The motions that are left; `None` where there are none, or the gradients are not shown to be independent.
    pub reduced: Option<Reduced>,
}

/// Displacements expressed by as many as are free.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Reduced {
    /// The free coordinates, by number.
    pub free: Vec<usize>,
    /// Z, one row a coordinate: what its displacement is made of.
    pub directions: Vec<Vec<ExprId>>,
    /// The other coordinates, by number, with their displacements in terms of the free ones, or their velocities.
    pub follows: Vec<(usize, MotionSum)>,
    /// Whether these are velocities, which depend on places too.
    pub velocities: bool,
    /// The matrices, closed forms and linearized equations of the free displacements.
    pub derivation: Box<Derivation>,
}

impl Tangent {
    /// Of constraints and conditions on velocities; `None` without any.
    pub(super) fn new(matrices: &mut SymbolicMatrices) -> Option<Self> {
        let constraints = matrices.constraints.take();
        let rolling = matrices.rolling.take();
        let (mut multipliers, mut gradients) =
            constraints.map_or_else(Default::default, |own| (own.multipliers, own.gradients));
        if let Some(own) = &rolling {
            // Forces of others vanish there.
            gradients.extend_from_slice(&own.gradients[gradients.len()..]);
            multipliers.extend_from_slice(&own.reactions);
            multipliers.resize(gradients.len(), matrices.pool.zero());
        }
        (!gradients.is_empty()).then_some(Self { multipliers, gradients, rolling, ..Self::default() })
    }

    /// What follows from the coordinates that neither M nor forces which go with velocities have a part of; `None` without any.
    pub(super) fn without_inertia(matrices: &mut SymbolicMatrices) -> Option<Self> {
        let others = [&matrices.gyroscopic, &matrices.damping].into_iter().flatten();
        let all: Vec<&Vec<Vec<ExprId>>> = std::iter::once(&matrices.mass).chain(others).collect();
        let n = matrices.mass.len();
        let vanishes =
            |i: &usize| (0..n).all(|j| all.iter().all(|rows| rows[*i][j].is_zero() && rows[j][*i].is_zero()));
        let massless: Vec<usize> = (0..n).filter(vanishes).collect();
        let pool = &mut matrices.pool;
        let mut row = |i: &usize| match &matrices.circulatory {
            Some(rows) => rows[*i].iter().zip(&matrices.stiffness[*i]).map(|(n, k)| pool.sum(&[*n, *k])).collect(),
            None => matrices.stiffness[*i].clone(),
        };
        let gradients: Vec<Vec<ExprId>> = massless.iter().map(&mut row).collect();
        (!massless.is_empty()).then(|| Self { massless, gradients, ..Self::default() })
    }
}

/// Simplifies what constraints add to a page, and works out what moves under them. Comes last: the page of what moves has a copy
/// of all expressions.
pub(super) fn reduce(pool: &mut Algebra<'_>, linear: &mut Linear, names: &Names, checker: &Checker<'_>, parts: &Parts) {
    let Some(mut tangent) = linear.tangent.take() else { return };
    let gradients = tangent.gradients.iter_mut().flatten();
    pool.shorten(tangent.multipliers.iter_mut().chain(gradients));
    if let Some(Reduction { free, directions, matrices, drift, energies }) =
        reduction(pool, checker, linear, &mut tangent)
        && !free.is_empty()
    {
        let of = |list: &[String]| -> Vec<String> { free.iter().filter_map(|at| list.get(*at).cloned()).collect() };
        let [mass, gyroscopic, damping, stiffness, circulatory] = matrices;
        let mut reduced = Linear {
            equilibrium: free.iter().map(|at| linear.equilibrium[*at]).collect(),
            mass: mass.unwrap_or_default(),
            stiffness: stiffness.unwrap_or_default(),
            gyroscopic,
            damping,
            circulatory,
            ..Linear::default()
        };
        reduced.finish(pool, checker, parts, true);
        reduced.closed_forms(pool, checker, parts);
        if let Some(part) = reduced.second_order.as_mut().filter(|_| !energies) {
            // Matrices of conditions are not those of energies.
            (part.kinetic, part.potential) = Default::default();
        }
        let own =
            Names { coordinates: of(&names.coordinates), displacements: of(&names.displacements), ..names.clone() };
        let derivation = Derivation::of_matrices((**pool).clone(), checker.model, own, Ok(reduced));
        let velocities = drift.is_some();
        let moved = |at: usize| if velocities { Motion::Velocity(at) } else { Motion::Displacement(at) };
        let others = (0..directions.len()).filter(|i| !free.contains(i));
        let follows = others.map(|i| {
            let terms = directions[i].iter().zip(&free);
            let terms = terms.map(|(value, at)| MotionTerm::new(*value, &[(moved(*at), 1)]));
            let places = drift.iter().flat_map(|rows| rows[i].iter().enumerate());
            let places = places.map(|(at, value)| MotionTerm::new(*value, &[(Motion::Displacement(at), 1)]));
            (i, MotionSum::new(pool, terms.chain(places)))
        });
        let follows = follows.collect();
        tangent.reduced = Some(Reduced { free, directions, follows, velocities, derivation: Box::new(derivation) });
    }
    linear.tangent = Some(tangent);
}

/// What is left under constraints.
struct Reduction {
    /// The numbers of the free coordinates.
    free: Vec<usize>,
    /// Z, row by row.
    directions: Rows,
    /// M, G, C, K and N of the free coordinates.
    matrices: [Option<Rows>; 5],
    /// What the velocities of the others owe to the places of all, one row a coordinate, where they do.
    drift: Option<Rows>,
    /// Whether M and K are those of T and V.
    energies: bool,
}

fn reduction(
    pool: &mut Algebra<'_>,
    checker: &Checker<'_>,
    linear: &Linear,
    tangent: &mut Tangent,
) -> Option<Reduction> {
    if let Some(mut own) = tangent.rolling.take() {
        pool.shorten(own.directions.iter_mut().flatten());
        let mut drift = own.drift_of_all(pool);
        pool.shorten(drift.iter_mut().flatten().flatten());
        let energies = drift.is_none() && own.reactions.is_empty();
        let SymbolicRolling { free, directions, matrices, .. } = own;
        return Some(Reduction { free, directions, matrices, drift, energies });
    }
    let condensed = condensed(pool, checker, linear, tangent);
    let (free, directions, stiffness) = condensed.or_else(|| directions(pool, checker, tangent))?;
    let mut project = |rows: &Rows| congruent(pool, rows, &directions);
    let matrices = [
        Some(project(&linear.mass)),
        linear.gyroscopic.as_ref().map(&mut project),
        linear.damping.as_ref().map(&mut project),
        Some(stiffness.unwrap_or_else(|| project(&linear.stiffness))),
        linear.circulatory.as_ref().map(&mut project),
    ];
    Some(Reduction { free, directions, matrices, drift: None, energies: true })
}

/// The free coordinates and Z, row by row; `None` where the rows are not shown to be independent.
fn directions(pool: &mut Algebra<'_>, checker: &Checker<'_>, tangent: &Tangent) -> Option<Directions> {
    let gradients = &tangent.gradients;
    let n = gradients.first()?.len();
    let is_pivot = |pool: &Pool, e: ExprId| checker.differs_from_zero(pool, e);
    // The last coordinates that will do follow the others, or the massless ones.
    let candidates: Vec<usize> =
        if tangent.massless.is_empty() { (0..n).rev().collect() } else { tangent.massless.clone() };
    let (bound, rows) = solved_for(pool, gradients, &candidates, &is_pivot)?;
    let free: Vec<usize> = (0..n).filter(|i| !bound.contains(i)).collect();
    let mut directions = units(pool, n, &free);
    for (bound, row) in bound.iter().zip(rows) {
        for (at, own) in free.iter().enumerate() {
            directions[*bound][at] = pool.short(|pool| pool.neg(row[*own]));
        }
    }
    Some((free, directions, None))
}

/// Z with a row of its own for each free coordinate, and nothing else yet.
fn units(pool: &Pool, n: usize, free: &[usize]) -> Rows {
    let entry = |i: usize, own: &usize| if *own == i { pool.one() } else { pool.zero() };
    (0..n).map(|i| free.iter().map(|own| entry(i, own)).collect()).collect()
}

/// Rows solved for as many columns as there are rows, the first of the candidates that will do: these columns in ascending order,
/// each with its row, in which it has 1 and the others have 0. `None` where the rows are not shown to be independent.
pub(super) fn solved_for(
    pool: &mut Pool,
    rows: &[Vec<ExprId>],
    candidates: &[usize],
    is_pivot: &dyn Fn(&Pool, ExprId) -> bool,
) -> Option<(Vec<usize>, Vec<Vec<ExprId>>)> {
    let turned: Vec<Vec<ExprId>> = candidates.iter().map(|i| rows.iter().map(|row| row[*i]).collect()).collect();
    // Columns that are independent, as rows of the transpose.
    let columns = linearize::eliminate(pool, turned, rows.len(), is_pivot)?;
    let mut bound: Vec<usize> = columns.pivots.iter().filter_map(|(_, row)| candidates.get(*row).copied()).collect();
    bound.sort_unstable();
    let (width, count) = (rows.first()?.len(), bound.len());
    let sorted: Vec<usize> = bound.iter().copied().chain((0..width).filter(|i| !bound.contains(i))).collect();
    let rows = rows.iter().map(|row| sorted.iter().map(|i| row[*i]).collect()).collect();
    let Eliminated { mut pivots, rows } = linearize::eliminate(pool, rows, count, is_pivot)?;
    pivots.put_in_order();
    let mut solved = Vec::with_capacity(count);
    for (_, row) in pivots {
        let mut own = vec![pool.zero(); width];
        sorted.iter().zip(&rows[row]).for_each(|(place, entry)| own[*place] = *entry);
        solved.push(own);
    }
    Some((bound, solved))
}

/// The free coordinates, Z and K of what is left, where so few massless coordinates follow that determinants give them in short: with
/// D = det K₂₂ and Nⱼ from Cramer's rule, Z₂ = N/D and (D K₁₁ + K₁₂ N)/D, in which D cancels what it can.
fn condensed(pool: &mut Algebra<'_>, checker: &Checker<'_>, linear: &Linear, tangent: &Tangent) -> Option<Directions> {
    let (massless, k) = (&tangent.massless, &linear.stiffness);
    if !(1..=MOST_BY_DETERMINANTS).contains(&massless.len()) || linear.circulatory.is_some() {
        return None;
    }
    let free: Vec<usize> = (0..k.len()).filter(|i| !massless.contains(i)).collect();
    let block: Vec<Vec<ExprId>> = massless.iter().map(|i| massless.iter().map(|j| k[*i][*j]).collect()).collect();
    let whole = pool.short(|pool| determinant(pool, &block));
    if !checker.differs_from_zero(pool, whole) {
        return None;
    }
    // One row a massless coordinate, one column a free one.
    let mut parts = vec![Vec::with_capacity(free.len()); massless.len()];
    for j in &free {
        for (b, parts) in parts.iter_mut().enumerate() {
            let mut replaced = block.clone();
            replaced.iter_mut().zip(massless).for_each(|(row, i)| row[b] = pool.neg(k[*i][*j]));
            let part = determinant(pool, &replaced);
            parts.push(pool.simplify(part));
        }
    }
    let mut directions = units(pool, k.len(), &free);
    for (b, parts) in massless.iter().zip(&parts) {
        for (slot, part) in directions[*b].iter_mut().zip(parts) {
            *slot = pool.short(|pool| pool.div(*part, whole));
        }
    }
    let mut entry = |i: usize, (column, j): (usize, &usize)| {
        let mut terms = vec![pool.mul(whole, k[i][*j])];
        terms.extend(massless.iter().zip(&parts).map(|(b, parts)| pool.mul(k[i][*b], parts[column])));
        let sum = pool.short(|pool| pool.sum(&terms));
        pool.div(sum, whole)
    };
    let stiffness = free.iter().map(|i| free.iter().enumerate().map(|own| entry(*i, own)).collect()).collect();
    Some((free, directions, Some(stiffness)))
}

/// ZᵀAZ.
fn congruent(pool: &mut Pool, rows: &[Vec<ExprId>], z: &[Vec<ExprId>]) -> Vec<Vec<ExprId>> {
    let m = z.first().map_or(0, Vec::len);
    let mut parts: Vec<Vec<Vec<ExprId>>> = vec![vec![Vec::new(); m]; m];
    for (i, row) in rows.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            if entry.is_zero() {
                continue;
            }
            for (a, left) in z[i].iter().enumerate() {
                for (b, right) in z[j].iter().enumerate() {
                    if !left.is_zero() && !right.is_zero() {
                        parts[a][b].push(pool.product(&[*left, *entry, *right]));
                    }
                }
            }
        }
    }
    parts.iter().map(|row| row.iter().map(|parts| pool.sum(parts)).collect()).collect()
}
