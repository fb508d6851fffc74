//! Constraints on the page: multipliers, the directions that are left, and M and K among them.
//!
//! With A the gradients of the constraints at the equilibrium, A q = 0 is solved for as many displacements as there are
//! constraints: q = Z y. M and K of the free displacements y are ZᵀMZ and ZᵀKZ, where K has the curvature of the constraints in
//! it (Lagrange's multipliers; Goldstein, Classical Mechanics, section 2.4).

use super::check::Checker;
use super::motion::{Motion, MotionSum, MotionTerm, Names};
use super::simplify::Simplifier;
use super::{Derivation, Linear, Parts};
use crate::expr::{ExprId, Pool};
use crate::linearize::{self, Eliminated, SymbolicConstraints, Tied};

/// Constraints, one entry each for those that don't follow from others.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Constraints {
    /// What the multipliers are called.
    pub names: Vec<String>,
    /// What is set to zero.
    pub expressions: Vec<ExprId>,
    /// The numbers of the constraints that follow from the others, which have no multiplier.
    pub dependent: Vec<usize>,
}

impl Constraints {
    pub(super) fn new(tied: &Tied) -> Option<Self> {
        let expressions = tied.expressions();
        (!expressions.is_empty()).then(|| Self { names: tied.names(), expressions, dependent: tied.dependent.clone() })
    }
}

/// The directions that constraints allow at the equilibrium.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Tangent {
    /// The multipliers at the equilibrium; one that was found numerically stands as itself.
    pub multipliers: Vec<ExprId>,
    /// The gradients of the constraints, one row each.
    pub gradients: Vec<Vec<ExprId>>,
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
    /// The other coordinates, by number, with their displacements in terms of the free ones.
    pub follows: Vec<(usize, MotionSum)>,
    /// The matrices, closed forms and linearized equations of the free displacements.
    pub derivation: Box<Derivation>,
}

impl Tangent {
    pub(super) fn new(constraints: SymbolicConstraints) -> Self {
        Self { multipliers: constraints.multipliers, gradients: constraints.gradients, reduced: None }
    }
}

/// Simplifies what constraints add to a page, and works out what moves under them. Comes last: the page of what moves has a copy
/// of all expressions.
pub(super) fn reduce(page: &mut Derivation, short: &mut Simplifier, checker: &Checker<'_>, parts: &Parts) {
    let (pool, names) = (&mut page.pool, &page.names);
    let Ok(linear) = &mut page.linear else {
        return;
    };
    let Some(mut tangent) = linear.tangent.take() else {
        return;
    };
    let gradients = tangent.gradients.iter_mut().flatten();
    for entry in tangent.multipliers.iter_mut().chain(gradients) {
        *entry = short.simplify(pool, *entry);
    }
    let solved = directions(pool, short, checker, &tangent.gradients);
    if let Some((free, directions)) = solved
        && !free.is_empty()
    {
        let of = |list: &[String]| -> Vec<String> { free.iter().filter_map(|at| list.get(*at).cloned()).collect() };
        let mut project = |rows: &[Vec<ExprId>]| congruent(pool, rows, &directions);
        let mut reduced = Linear {
            equilibrium: free.iter().map(|at| linear.equilibrium[*at]).collect(),
            mass: project(&linear.mass),
            stiffness: project(&linear.stiffness),
            gyroscopic: linear.gyroscopic.as_deref().map(&mut project),
            damping: linear.damping.as_deref().map(&mut project),
            circulatory: linear.circulatory.as_deref().map(&mut project),
            signs: Vec::new(),
            second_order: None,
            frequencies: None,
            tangent: None,
        };
        reduced.finish(pool, short, checker, parts);
        reduced.forget_zeros();
        let derivation = Derivation {
            pool: pool.clone(),
            model: checker.model.name.clone(),
            names: Names {
                coordinates: of(&names.coordinates),
                displacements: of(&names.displacements),
                normal: names.normal.clone(),
            },
            rates: Vec::new(),
            symbols: std::collections::BTreeMap::new(),
            linear: Ok(reduced),
            equations: None,
            energy: None,
            equilibria: None,
            constraints: None,
        };
        let others = (0..directions.len()).filter(|i| !free.contains(i));
        let follows = others
            .map(|i| {
                let terms = directions[i].iter().zip(&free);
                let terms = terms.map(|(value, at)| MotionTerm::new(*value, &[(Motion::Displacement(*at), 1)]));
                (i, MotionSum::new(pool, terms))
            })
            .collect();
        tangent.reduced = Some(Reduced { free, directions, follows, derivation: Box::new(derivation) });
    }
    linear.tangent = Some(tangent);
}

/// The free coordinates and Z, row by row; `None` where the gradients are not shown to be independent.
fn directions(
    pool: &mut Pool,
    short: &mut Simplifier,
    checker: &Checker<'_>,
    gradients: &[Vec<ExprId>],
) -> Option<(Vec<usize>, Vec<Vec<ExprId>>)> {
    let n = gradients.first()?.len();
    let is_pivot = |pool: &Pool, e: ExprId| checker.differs_from_zero(pool, e);
    // The last coordinates that will do follow the others.
    let turned: Vec<Vec<ExprId>> = (0..n).rev().map(|i| gradients.iter().map(|row| row[i]).collect()).collect();
    // Columns of A that are independent, as rows of its transpose.
    let columns = linearize::eliminate(pool, turned, gradients.len(), &is_pivot)?;
    let mut bound: Vec<usize> = columns.pivots.iter().map(|(_, row)| n - 1 - row).collect();
    bound.sort_unstable();
    let free: Vec<usize> = (0..n).filter(|i| !bound.contains(i)).collect();
    let sorted: Vec<usize> = bound.iter().chain(&free).copied().collect();
    let rows: Vec<Vec<ExprId>> = gradients.iter().map(|row| sorted.iter().map(|i| row[*i]).collect()).collect();
    let Eliminated { pivots, rows } = linearize::eliminate(pool, rows, bound.len(), &is_pivot)?;
    let (zero, one) = (pool.zero(), pool.one());
    let mut directions = vec![vec![zero; free.len()]; n];
    for (at, own) in free.iter().enumerate() {
        directions[*own][at] = one;
    }
    for (column, row) in pivots {
        for (at, _) in free.iter().enumerate() {
            let entry = pool.neg(rows[row][bound.len() + at]);
            directions[bound[column]][at] = short.simplify(pool, entry);
        }
    }
    Some((free, directions))
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

impl Linear {
    /// Without matrices of which nothing is left.
    fn forget_zeros(&mut self) {
        let others = [&mut self.gyroscopic, &mut self.damping, &mut self.circulatory];
        for matrix in others {
            let vanishes = matrix.as_ref().is_some_and(|rows| {
                let mut entries = rows.iter().flatten();
                entries.all(|e| e.is_zero())
            });
            if vanishes {
                *matrix = None;
            }
        }
    }
}
