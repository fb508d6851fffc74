//! Whether friction takes energy out of every motion: then a system is stable where its energy has a minimum, and unstable where it
//! has a saddle, whatever M and gyroscopic forces are (W. Thomson and P. G. Tait, Treatise on Natural Philosophy (1879), section
//! 345; E. E. Zajac, Journal of the Astronautical Sciences 11 (1964) 46).

use super::Linear;
use super::ring::{Expanded, Ring};
use super::simplify::Algebra;
use super::stability::{Sign, Signs};
use crate::expr::ExprId;
use crate::linearize::nullspace_mod;
use crate::number::Number;
use crate::polynomial::{Polynomial, determinant};

/// More coordinates are not examined.
const MOST_COORDINATES: usize = 8;
/// Powers of M⁻¹K of longer entries are not multiplied out.
const MOST_TERMS: usize = 200;

type Rows = Vec<Vec<Polynomial>>;

/// Friction in all motions: what has to be positive for it, beside signs that parameters have.
pub(super) struct Pervasive {
    pub(super) ring: Ring,
    /// What is known without these.
    pub(super) signs: Signs,
    pub(super) conditions: Vec<Polynomial>,
    damping: Rows,
    /// Whether each velocity has friction of its own.
    pub(super) definite: bool,
}

impl Pervasive {
    /// `None` where the friction is not known to take energy out of all motions; `signs` tells what is known to be positive for the
    /// values of the parameters, and in general.
    pub(super) fn new(
        pool: &mut Algebra<'_>,
        linear: &Linear,
        known: &[Expanded],
        all_signs: impl Fn(&mut Algebra<'_>, &Ring) -> (Signs, Signs),
    ) -> Option<Self> {
        let n = linear.mass.len();
        let damping = linear.damping.as_ref().filter(|_| linear.circulatory.is_none() && n <= MOST_COORDINATES)?;
        let entries = [damping, &linear.mass, &linear.stiffness];
        let all: Vec<ExprId> = entries.into_iter().flatten().flatten().copied().collect();
        let expanded = Expanded::new(pool, &all)?;
        let ring = Ring::new(pool, std::iter::once(&expanded).chain(known));
        let all = ring.of_signs(&expanded)?;
        let mut matrices = all.chunks(n * n).map(|own| own.chunks(n).map(<[_]>::to_vec).collect::<Rows>());
        let (damping, mass, stiffness) = (matrices.next()?, matrices.next()?, matrices.next()?);
        let minor = |rows: &[usize], columns: &[usize]| {
            let row = |i: &usize| columns.iter().map(|j| damping[*i][*j].clone()).collect();
            determinant(rows.iter().map(row).collect()).map(|own| ring.reduced(own))
        };
        let (of_values, signs) = all_signs(pool, &ring);
        let is_positive = |own: &Polynomial| !own.is_zero() && of_values.sign(own).holds_always();
        // The largest principal minor that is not 0: what is left follows from it.
        let (mut own, mut left, mut conditions) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..n {
            let with = [own.as_slice(), &[i]].concat();
            let found = minor(&with, &with)?;
            if found.is_zero() {
                left.push(i);
                continue;
            }
            if !is_positive(&found) {
                return None;
            }
            conditions.push(found);
            own = with;
        }
        for (i, j) in left.iter().flat_map(|i| left.iter().map(move |j| (*i, *j))) {
            if !minor(&[own.as_slice(), &[i]].concat(), &[own.as_slice(), &[j]].concat())?.is_zero() {
                return None;
            }
        }
        let definite = left.is_empty();
        if !definite {
            // No undamped motion: C x = 0 and K x = ω²M x have no solution where rows of C, CM⁻¹K, CM⁻¹KM⁻¹K, … are independent.
            if linear.gyroscopic.is_some() {
                return None;
            }
            let rows = own.iter().map(|i| damping[*i].clone()).collect();
            let found =
                ring.reduced(determinant(observed(pool, &ring, rows, &product(&adjugate(&mass)?, &stiffness))?)?);
            let opposite = found.scaled(&Number::MINUS_ONE);
            if !is_positive(&found) && !is_positive(&opposite) {
                return None;
            }
        }
        Some(Self { ring, signs, conditions, damping, definite })
    }

    /// Whether conditions are needed as well: there is one alone, with which all friction changes its sign.
    pub(super) fn needs(&self, conditions: &[Sign]) -> bool {
        let [Sign { factors, .. }] = conditions else { return conditions.is_empty() };
        let [common] = factors.as_slice() else { return false };
        let times = |own: &Polynomial| std::iter::successors(own.over(common), |rest| rest.over(common)).count();
        self.damping.iter().flatten().all(|own| own.is_zero() || times(own) % 2 == 1)
    }
}

/// n independent rows of C, CA, CAA, …; `None` where there are fewer, or they are long.
fn observed(pool: &mut Algebra<'_>, ring: &Ring, rows: Rows, a: &Rows) -> Option<Rows> {
    let n = a.len();
    let (mut next, mut found): (Rows, Rows) = (rows, Vec::new());
    let mut values: Vec<Vec<u64>> = Vec::new();
    for _ in 0..n {
        for row in &next {
            if row.iter().any(|entry| entry.terms().count() > MOST_TERMS) {
                return None;
            }
            let entries: Vec<ExprId> = row.iter().map(|entry| ring.expression(pool, entry)).collect();
            values.push(pool.evaluate_at_random(&entries, 1)?);
            if nullspace_mod(&values, n).len() + values.len() > n {
                values.pop();
                continue;
            }
            found.push(row.clone());
        }
        if found.len() == n {
            return Some(found);
        }
        next = product(&next, a);
    }
    None
}

fn product(a: &Rows, b: &Rows) -> Rows {
    let entry = |row: &Vec<Polynomial>, j: usize| {
        row.iter().zip(b).map(|(x, other)| x.times(&other[j])).reduce(|sum, term| sum.plus(&term))
    };
    a.iter().map(|row| (0..row.len()).filter_map(|j| entry(row, j)).collect()).collect()
}

/// What is M⁻¹ times det M.
fn adjugate(matrix: &Rows) -> Option<Rows> {
    let n = matrix.len();
    let without = |of: usize| (0..n).filter(move |i| *i != of);
    let cofactor = |i: usize, j: usize| {
        let rows: Rows = without(i).map(|i| without(j).map(|j| matrix[i][j].clone()).collect()).collect();
        let own = determinant(rows)?;
        Some(if (i + j).is_multiple_of(2) { own } else { own.scaled(&Number::MINUS_ONE) })
    };
    (0..n).map(|i| (0..n).map(|j| cofactor(j, i)).collect()).collect()
}
