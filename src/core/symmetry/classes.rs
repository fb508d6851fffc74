//! The classes of a symmetry and how vectors are told apart.
//!
//! A sum of elements of the group over whole conjugacy classes commutes with the group and with M and K,
//! and on the vectors of one class of symmetry it is a number (Schur's lemma; Landau and Lifshitz, Quantum
//! Mechanics, §94). Mirrors that commute are such sums, and so is a turn of a ring plus its inverse, with
//! 2 cos(2 pi j/N) for the wave number j. So the class of a vector doesn't depend on which vectors of
//! a degenerate frequency are examined.

use crate::order::Order;
use std::collections::{BTreeMap, BTreeSet};

use faer::{MatRef, Side};
use nalgebra::DMatrix;

use super::point_group::Element;
use super::points::Moves;
use super::{GroupKind, SignedPermutation, Symmetry, products};

/// Sums of more elements are not made.
const MOST_CONJUGATES: usize = 2000;
/// The classes of groups that are neither mirrors nor a ring are found for at most so many coordinates.
const MOST_COORDINATES: usize = 200;
/// More mirrors than this are not told apart.
const MOST_MIRRORS: usize = 12;
/// Coordinates moved in search of conjugates, all in all: some hundredths of a second. Many like coordinates that
/// hang together in no way have more than all the symmetry that there is to name.
const MOST_EFFORT: usize = 2_000_000;

/// What tells vectors of different symmetry apart.
#[derive(Clone, Debug)]
pub struct Classes {
    /// A sum of elements with their factors, which is a number on each class, by columns: where a
    /// coordinate goes, and by what factor.
    sum: Vec<Vec<(usize, f64)>>,
    /// The magnitudes of all factors together, and 1.
    weight: f64,
    /// These numbers in ascending order, with the names of the classes.
    names: Vec<(f64, String)>,
    active: Vec<bool>,
}

impl Classes {
    /// The classes of a symmetry; `None` where they can't be told apart.
    pub(crate) fn new(symmetry: &Symmetry) -> Option<Self> {
        let (terms, mut names) = match &symmetry.kind {
            GroupKind::Mirrors(mirrors) => of_mirrors(symmetry, mirrors)?,
            GroupKind::Ring { turn, length } => of_ring(turn, *length),
            GroupKind::Other => of_other(symmetry)?,
        };
        names.order_by(|a, b| a.0.total_cmp(&b.0));
        let weight = terms.iter().fold(1.0, |sum, (factor, _)| sum + factor.abs());
        let image = |i: usize, (factor, element): &(f64, SignedPermutation)| {
            let (to, negative) = element.of(i);
            (to, if negative { -factor } else { *factor })
        };
        let own = |i: usize| column(terms.iter().map(|term| image(i, term)));
        let sum = (0..symmetry.active.len()).map(own).collect();
        Some(Self { sum, weight, names, active: symmetry.active.clone() })
    }

    /// The classes that this sum of elements with their factors tells apart, given by columns.
    pub(super) fn of_sum(sum: Vec<Vec<(usize, f64)>>, terms: &[(f64, Element)], mut names: Vec<(f64, String)>) -> Self {
        names.order_by(|a, b| a.0.total_cmp(&b.0));
        // A turn makes no component larger than by the root of 3.
        let weight = terms.iter().fold(1.0, |sum, (factor, _)| sum + 2.0 * factor.abs());
        let active = vec![true; sum.len()];
        Self { sum, weight, names, active }
    }

    /// The class of a vector whose components are known within `error`; `None` where it has parts in
    /// several, or moves what is outside of the symmetry.
    pub(crate) fn of(&self, vector: &[f64], error: f64) -> Option<&str> {
        if vector.len() != self.active.len() {
            return None;
        }
        let largest = vector.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let allowed = (2.0 * error).max(1e-9 * largest);
        if error.is_nan() || allowed > 1e-3 * largest {
            return None;
        }
        let outside = vector.iter().zip(&self.active).filter(|(_, active)| !**active);
        if outside.into_iter().any(|(value, _)| value.abs() > allowed) {
            return None;
        }
        let sum = self.image(vector);
        let square: f64 = vector.iter().map(|x| x * x).sum();
        let product: f64 = vector.iter().zip(&sum).map(|(x, y)| x * y).sum();
        let value = product / square;
        let pairs = sum.iter().zip(vector);
        if pairs.into_iter().any(|(y, x)| (y - value * x).abs() > self.weight * allowed) {
            return None;
        }
        self.named(value)
    }

    /// What the sum of elements makes of a vector.
    fn image(&self, vector: &[f64]) -> Vec<f64> {
        let mut image = vec![0.0; vector.len()];
        for (column, value) in self.sum.iter().zip(vector) {
            for (to, factor) in column {
                image[*to] += factor * value;
            }
        }
        image
    }

    /// The class on which the sum of elements is nearly this number.
    fn named(&self, value: f64) -> Option<&str> {
        let mut nearest: Vec<(f64, &str)> =
            self.names.iter().map(|(at, name)| ((at - value).abs(), name.as_str())).collect();
        nearest.order_by(|a, b| a.0.total_cmp(&b.0));
        match nearest.as_slice() {
            [(distance, name), rest @ ..] => {
                let other = rest.first().map_or(1.0, |(other, _)| *other);
                (*distance < 0.1 * other).then_some(*name)
            }
            [] => None,
        }
    }

    /// How vectors that are M-orthonormal but for rounding, of a space that the symmetry keeps, combine to vectors of one class
    /// each: by class, in the order of their names, the coefficients of each. `None` where the space is not kept.
    ///
    /// The sum of elements commutes with M, so that in such a basis it is a symmetric matrix.
    pub(crate) fn spaces(&self, vectors: &[Vec<f64>]) -> Option<Vec<Vec<Vec<f64>>>> {
        let matrix = |of: &dyn Fn(&[f64]) -> Vec<f64>| {
            DMatrix::from_iterator(self.sum.len(), vectors.len(), vectors.iter().flat_map(|x| of(x)))
        };
        if vectors.is_empty() || vectors.iter().any(|x| x.len() != self.sum.len()) {
            return None;
        }
        let (basis, image) = (matrix(&<[f64]>::to_vec), matrix(&|x| self.image(x)));
        let qr = basis.clone().qr();
        let within = qr.r().solve_upper_triangular(&(qr.q().transpose() * &image))?;
        let (rest, turned) = (&basis * &within - image, &within - within.transpose());
        if rest.amax() > 1e-8 * self.weight * basis.amax() || turned.amax() > 1e-8 * self.weight {
            return None;
        }
        let (values, coefficients) = decomposed(&within)?;
        let mut spaces: BTreeMap<&str, Vec<Vec<f64>>> = BTreeMap::new();
        for (value, own) in values.iter().zip(coefficients.column_iter()) {
            spaces.entry(self.named(*value)?).or_default().push(own.iter().copied().collect());
        }
        Some(spaces.into_values().collect())
    }
}

/// What a sum of elements does to a coordinate, from what each of them does to it.
pub(super) fn column(parts: impl Iterator<Item = (usize, f64)>) -> Vec<(usize, f64)> {
    let mut column: BTreeMap<usize, f64> = BTreeMap::new();
    parts.for_each(|(to, factor)| *column.entry(to).or_default() += factor);
    column.into_iter().collect()
}

type Told = (Vec<(f64, SignedPermutation)>, Vec<(f64, String)>);

/// Each mirror is 1 or -1; with weights 1, 3, 9, … all sums differ.
fn of_mirrors(symmetry: &Symmetry, mirrors: &[SignedPermutation]) -> Option<Told> {
    if mirrors.len() > MOST_MIRRORS {
        return None;
    }
    let weights: Vec<f64> = (0..mirrors.len()).map(|at| 3_f64.powi(at as i32)).collect();
    let names = (0_u32..1 << mirrors.len()).map(|signs| {
        let odd: Vec<bool> = (0..mirrors.len()).map(|at| signs & (1 << at) != 0).collect();
        let value = weights.iter().zip(&odd).map(|(weight, odd)| if *odd { -weight } else { *weight });
        (value.sum(), symmetry.class_under_mirrors(&odd))
    });
    let names = names.collect();
    Some((weights.into_iter().zip(mirrors.iter().cloned()).collect(), names))
}

/// The name of the class of a wave number.
#[must_use]
pub fn wave_number(j: usize) -> String {
    format!("wave number {j}")
}

fn of_ring(turn: &SignedPermutation, length: usize) -> Told {
    let terms = vec![(1.0, turn.clone()), (1.0, turn.inverse())];
    let angle = std::f64::consts::TAU / length as f64;
    let names = (0..=length / 2).map(|j| (2.0 * (angle * j as f64).cos(), wave_number(j))).collect();
    (terms, names)
}

/// All elements that an element is turned into by others; `None` where there are too many. `effort` is
/// what may still be spent, in coordinates that are moved.
fn conjugates(
    of: &SignedPermutation,
    generators: &[SignedPermutation],
    effort: &mut usize,
) -> Option<BTreeSet<SignedPermutation>> {
    let mut found = BTreeSet::from([of.clone(), of.inverse()]);
    let mut open: Vec<SignedPermutation> = found.iter().cloned().collect();
    while let Some(element) = open.pop() {
        for g in generators {
            *effort = effort.checked_sub(3 * of.len())?;
            let moved = element.conjugated(g);
            if !found.contains(&moved) {
                if found.len() == MOST_CONJUGATES {
                    return None;
                }
                open.push(moved.clone());
                found.insert(moved);
            }
        }
    }
    Some(found)
}

/// Whether no classes are found for a group that has all permutations of `alike` coordinates among so many.
///
/// An exchange of two of them has alike (alike - 1) / 2 conjugates at least, each of which every generator is
/// tried on, alike - 1 at least: where that takes more than [`MOST_EFFORT`], [`of_other`] finds nothing. For
/// alike > 3 the group is neither mirrors that commute nor that of a ring.
pub(super) fn too_many(alike: usize, coordinates: usize) -> bool {
    let others = alike.saturating_sub(1);
    let tried = (alike.saturating_mul(others) / 2).saturating_mul(others);
    alike > 3 && tried.saturating_mul(3 * coordinates) > MOST_EFFORT
}

/// Sums over the conjugacy classes of the generators and their products; the classes of symmetry are
/// numbered by falling values, so that the first one is what all elements leave unchanged.
fn of_other(symmetry: &Symmetry) -> Option<Told> {
    let mut generators = symmetry.generators.clone();
    // Parts that don't hang together have equal frequencies where they are exchanged, and vectors of
    // these may be in one part or in several: the signs of parts, where they are symmetries, belong to the group then.
    generators.extend(symmetry.flips.iter().cloned());
    let generators = generators.as_slice();
    let count = symmetry.active.len();
    if count > MOST_COORDINATES {
        return None;
    }
    let mut sums: Vec<BTreeSet<SignedPermutation>> = Vec::new();
    let all = symmetry.points.iter().flat_map(Moves::all);
    let mut effort = MOST_EFFORT;
    for element in generators.iter().cloned().chain(products(generators)).chain(all) {
        if sums.iter().all(|sum| !sum.contains(&element))
            && !element.is_identity()
            && let Some(sum) = conjugates(&element, generators, &mut effort)
        {
            sums.push(sum);
        }
        // Some classes without others would tell less than there is.
        effort = effort.checked_sub(element.len())?;
    }
    // Weights without a rational relation, so that no two classes get the same sum by chance.
    let mut terms: Vec<(f64, SignedPermutation)> = Vec::new();
    let places: Vec<usize> = (0..count).filter(|i| symmetry.active[*i]).collect();
    let mut matrices: Vec<DMatrix<f64>> = Vec::new();
    let mut all = DMatrix::zeros(places.len(), places.len());
    for (at, sum) in sums.iter().enumerate() {
        let weight = (at as f64 + 1.0).sin().mul_add(0.25, 1.0) / sum.len() as f64;
        let mut matrix = DMatrix::zeros(count, count);
        for element in sum {
            terms.push((weight, element.clone()));
            for i in 0..count {
                let (to, negative) = element.of(i);
                matrix[(to, i)] += if negative { -1.0 } else { 1.0 };
            }
        }
        let inner = matrix.select_rows(&places).select_columns(&places);
        all += &inner * weight;
        matrices.push(inner);
    }
    // A sum over a class and its inverses is symmetric.
    let (eigenvalues, eigenvectors) = decomposed(&all)?;
    let mut values: Vec<(f64, Vec<i64>)> = Vec::new();
    for (value, vector) in eigenvalues.iter().zip(eigenvectors.column_iter()) {
        if values.iter().any(|(known, _)| (known - value).abs() < 1e-7) {
            continue;
        }
        let tuple = matrices.iter().map(|matrix| {
            // Rounded, so that what is equal is so.
            ((matrix * vector).dot(&vector) * 1e6).round() as i64
        });
        values.push((*value, tuple.collect()));
    }
    if values.len() < 2 {
        return None;
    }
    values.order_by(|a, b| b.1.cmp(&a.1));
    let told = |tuple: &[i64]| {
        symmetry.points.as_ref()?.name(&|g: &SignedPermutation| {
            if g.is_identity() {
                return Some(1.0);
            }
            let at = sums.iter().position(|sum| sum.contains(g))?;
            Some(*tuple.get(at)? as f64 / (1e6 * sums[at].len() as f64))
        })
    };
    let names: Option<Vec<String>> = values.iter().map(|(_, tuple)| told(tuple)).collect();
    let differ = |names: &Vec<String>| names.iter().collect::<BTreeSet<_>>().len() == names.len();
    let numbered = || (1..=values.len()).map(|i| format!("class {i}")).collect();
    let names = names.filter(differ).unwrap_or_else(numbered);
    let names = values.iter().map(|(value, _)| *value).zip(names).collect();
    Some((terms, names))
}

/// Eigenvalues and eigenvectors of a symmetric matrix.
pub(super) fn decomposed(matrix: &DMatrix<f64>) -> Option<(Vec<f64>, DMatrix<f64>)> {
    let n = matrix.nrows();
    let eigen = MatRef::from_column_major_slice(matrix.as_slice(), n, n).self_adjoint_eigen(Side::Lower).ok()?;
    let values = (0..n).map(|k| eigen.S()[k]).collect();
    Some((values, DMatrix::from_fn(n, n, |i, j| eigen.U()[(i, j)])))
}
