//! One step towards exact eigenvectors at full precision: X <- X (1 + W) V, as in
//! [`crate::modes::refine`], where the formulae and their source stand.
//!
//! W and V are double-doubles: they are small or orthogonal, so that this loses 31 digits below
//! the error that they mend, and the columns gain that many digits at most. Only their own columns
//! are improved; columns that stay in double-double contribute directions.

use dashu_int::IBig;

use super::data::Data;
use super::fixed::{double, double_double, from_double_double, shifted};
use super::measure::{Columns, Measured};
use crate::groups::Groups;
use crate::modes::dense::Matrix;
use crate::modes::product::{Part, product};
use crate::modes::refine::{NEAR, SMALL, TINY, block, jacobi};
use crate::modes::shape::unit;
use crate::modes::start::symmetric_eigenvectors;
use crate::order::Gather;
use crate::precision::{DoubleDouble, exponent_of};

/// Larger blocks are decomposed by reduction to tridiagonal form, which is faster.
const LARGE: usize = 40;

/// Bits of a rotation.
const ROTATION: i64 = 110;

/// How two columns are still mixed.
struct Pair {
    /// The larger of the couplings, and what it is uncertain by.
    coupling: f64,
    noise: f64,
    /// μ_j - μ_i
    gap: DoubleDouble,
    size: f64,
}

impl Pair {
    fn is_separated(&self) -> bool {
        let gap = self.gap.hi.abs();
        let small = if gap < NEAR * self.size { TINY } else { SMALL };
        gap > 0.0 && self.coupling <= small * gap
    }
}

struct Pairs<'a> {
    measured: &'a Measured,
    scale: i64,
}

impl Pairs<'_> {
    /// Of any column i and an own column j.
    fn pair(&self, i: usize, j: usize, at: usize) -> Pair {
        let Measured { own, quotient, couplings, h, noise, .. } = self.measured;
        let mut coupling = h.get(i, at).hi.abs();
        let mut uncertain = noise.get(i, at);
        if let Some(other) = own[i] {
            coupling = coupling.max(h.get(j, other).hi.abs());
            uncertain = uncertain.max(noise.get(j, other));
        }
        Pair {
            coupling,
            noise: uncertain,
            gap: double_double(&(&quotient[j] - &quotient[i]), -self.scale),
            size: couplings.size[i].max(couplings.size[j]),
        }
    }
}

/// Better columns over 2^scale, or the columns that would have to be taken along because they are
/// not separated from these.
pub(super) fn improve(data: &Data, columns: &Columns, measured: &Measured, scale: i64) -> Result<Columns, Vec<usize>> {
    let m = measured.quotient.len();
    let own = &measured.own;
    let pairs = Pairs { measured, scale: data.quotient_scale() };
    let mut together = Groups::new(m);
    let mut more = Vec::new();
    for (at, &j) in columns.own.iter().enumerate() {
        for (i, other) in own.iter().enumerate() {
            if i == j || other.is_some() && i > j {
                continue;
            }
            let pair = pairs.pair(i, j, at);
            if !pair.is_separated() && pair.coupling > pair.noise {
                together.join(i, j);
                if other.is_none() {
                    more.push(i);
                }
            }
        }
    }
    if !more.is_empty() {
        return Err(more.into_iter().distinct());
    }
    let group: Vec<usize> = (0..m).map(|i| together.least(i)).collect();

    let k = columns.own.len();
    let half = DoubleDouble::exact(-0.5);
    let mut w = Matrix::zeros(m, k);
    let mut place = vec![0; k];
    for (at, &j) in columns.own.iter().enumerate() {
        let mut largest: f64 = 0.0;
        for i in 0..m {
            let pair = pairs.pair(i, j, at);
            let value = if i != j && group[i] != group[j] && pair.is_separated() {
                measured.h.get(i, at) / pair.gap
            } else {
                measured.g.get(i, at) * half
            };
            largest = largest.max(value.hi.abs());
            w.set(i, at, value);
        }
        // Relative to the largest, out of the way of underflow.
        place[at] = exponent_of(largest).max(-1000);
        for i in 0..m {
            w.set(i, at, w.get(i, at).scale(-place[at]));
        }
    }
    let change = product(&measured.x, &w, Part::All);
    let mut better: Vec<Vec<IBig>> = Vec::with_capacity(k);
    for (at, x) in columns.x.iter().enumerate() {
        let column = x.iter().enumerate().map(|(row, x)| {
            let change = from_double_double(change.get(row, at), scale + i64::from(place[at]));
            shifted(x, scale - columns.scale) + change
        });
        let mut column: Vec<IBig> = column.collect();
        // What is left of the zero vectors: X - Z (ZᵀMX).
        for (z, overlap) in data.zero.vectors.iter().zip(&measured.overlap[at]) {
            let lower = scale - (2 * data.scale + columns.scale);
            for (x, z) in column.iter_mut().zip(z) {
                *x -= shifted(&(z * overlap), lower);
            }
        }
        better.push(column);
    }
    for cluster in together.all().into_iter().filter(|cluster| cluster.len() > 1) {
        let places: Vec<usize> = cluster.iter().filter_map(|&i| own[i]).collect();
        if let Some(rotation) = rotation(&pairs, &cluster, &places) {
            rotate(&mut better, &places, &rotation);
        }
    }
    Ok(Columns { scale, own: columns.own.clone(), x: better })
}

/// Orthogonal eigenvectors of the block of S - (G - 1) Λ, symmetrised, that belongs to a cluster.
fn rotation(pairs: &Pairs<'_>, cluster: &[usize], places: &[usize]) -> Option<Matrix> {
    let Measured { quotient, h, .. } = pairs.measured;
    let c = cluster.len();
    let value = |x: &IBig| double(x, -pairs.scale);
    let block = block(
        c,
        |p| value(&quotient[cluster[p]]),
        |p, q| value(&(&quotient[cluster[p]] - &quotient[cluster[q]])),
        |p, q| h.get(cluster[p], places[q]).hi,
    );
    let v = if c < LARGE {
        jacobi(block).widened()
    } else {
        Matrix::from_doubles(symmetric_eigenvectors(block.view())?.as_ref())
    };
    // V <- V (3 - VᵀV) / 2: orthogonal up to the square of what it was (Newton and Schulz).
    let square = product(&v.transposed(), &v, Part::Lower);
    let defect = Matrix::from_fn(c, c, |p, q| (unit(p, q) - square.get(p, q)) * DoubleDouble::exact(0.5));
    let mut better = product(&v, &defect, Part::All);
    better.add_assign(&v);
    Some(better)
}

/// The columns at `places`, recombined.
fn rotate(x: &mut [Vec<IBig>], places: &[usize], rotation: &Matrix) {
    let c = places.len();
    let factors: Vec<Vec<IBig>> =
        (0..c).map(|q| (0..c).map(|p| from_double_double(rotation.get(p, q), ROTATION)).collect()).collect();
    let old: Vec<Vec<IBig>> = places.iter().map(|&at| x[at].clone()).collect();
    for (&at, factors) in places.iter().zip(&factors) {
        for (row, target) in x[at].iter_mut().enumerate() {
            let terms = old.iter().zip(factors).filter(|(_, f)| **f != IBig::ZERO);
            let sum = terms.fold(IBig::ZERO, |sum, (column, f)| sum + &column[row] * f);
            *target = shifted(&sum, -ROTATION);
        }
    }
}
