//! Entries of exponents that are 0, repeated or decided exactly: one for each exponent of a Jordan block, with the vector
//! that heads it.

use faer::c64;

use super::basis::{Metric, finished};
use super::blocks::{Blocks, Pencil};
use super::complex::{Complex, Wide};
use super::exact::{ExactRoot, ExactSpectrum};
use super::scale::Scaled;
use super::solve::Solution;
use super::spectrum::{Facts, finish};
use super::{Exponent, Exponents, Kind, Limit, Options, Precise, PrecisionLevel};
use crate::precision::{Ball, Big, Integers, Magnitude, up};

/// Bits of combinations of vectors that come in balls or doubles.
const BITS: usize = 160;

/// A vector in doubles, and a bound of the error of each component.
type Shape = (Vec<c64>, f64);

/// The entries of a spectrum that was decided exactly.
pub(super) fn exact_spectrum(
    scaled: &Scaled,
    facts: &Facts,
    matrices: &Integers,
    exact: ExactSpectrum,
    options: &Options,
) -> Exponents {
    let paired = facts.paired;
    // Whole matrices are a multiple of the true ones in their units: vectors of length 1 in theirs are too short by its root.
    let unit = matrices.coordinates.first();
    let unit = unit.map_or(Big::one(4 * BITS), |unit| unit.value(4 * BITS));
    let true_mass = &Big::from_ball(&true_mass(scaled, 0, 0), 4 * BITS) * &(&unit * &unit);
    let n = scaled.n;
    let pencil = Pencil { matrices, n };
    let mass = pencil.values(&matrices.matrices[0], 0, 4 * BITS);
    let multiple = mass.first().filter(|_| !true_mass.is_zero());
    let multiple = multiple.map_or(Big::one(BITS), |mass| (mass / &true_mass).sqrt());
    let shape = |head: Option<&Vec<Wide>>, known: bool| match head {
        Some(head) => finished(&head.iter().map(|x| x.times(&multiple)).collect::<Vec<_>>()),
        None if known || !options.vectors => (Vec::new(), 0.0),
        None => (vec![c64::new(0.0, 0.0); scaled.n], f64::INFINITY),
    };
    let mut entries = Vec::new();
    let mut cluster = 0;
    for root in exact.roots {
        if paired && root.lambda.im.is_zero() && root.lambda.re.is_negative() {
            // The growing one stands for the pair.
            continue;
        }
        cluster += 1;
        let entry = entry(&root, cluster);
        let Some(blocks) = &root.blocks else {
            let (vector, vector_error_bound) = shape(None, false);
            let limit = Some(Limit::Unresolved { count: root.multiplicity });
            let open = Exponent { vector, vector_error_bound, limit, ..entry };
            entries.extend(std::iter::repeat_n(open, root.multiplicity));
            continue;
        };
        for (at, &order) in blocks.sizes.iter().enumerate() {
            let (vector, vector_error_bound) = shape(blocks.heads.get(at), true);
            let limit = (order > 1).then_some(Limit::Defective { order });
            let own = Exponent { vector, vector_error_bound, limit, ..entry.clone() };
            entries.extend(std::iter::repeat_n(own, order));
        }
    }
    if let Some(root) = exact.zero {
        match root.blocks {
            Some(blocks) => {
                for (head, order) in zero_rows(&blocks, paired) {
                    let limit = (order > 2).then_some(Limit::Defective { order });
                    entries.push(zero(shape(head.as_ref(), true), limit, 0));
                }
            }
            None => {
                let limit = Some(Limit::Unresolved { count: root.multiplicity });
                let known = scaled.zero.len().max(1);
                let count = if paired { root.multiplicity / 2 } else { known };
                let open = zero(shape(None, false), limit, 0);
                entries.extend(std::iter::repeat_n(open, count));
            }
        }
    }
    finish(entries, PrecisionLevel::Precise, options, &|_| false)
}

fn entry(root: &ExactRoot, cluster: u32) -> Exponent {
    let Wide { re: growth, im: omega } = &root.lambda;
    let precise = Some(Box::new(Precise::complex(omega.clone(), growth.clone())));
    let (growth, omega) = (growth.to_far_ball(), omega.to_far_ball());
    Exponent { precise, ..Exponent::new(growth, omega, (Vec::new(), 0.0), cluster) }
}

pub(super) fn zero(shape: Shape, limit: Option<Limit>, cluster: u32) -> Exponent {
    Exponent { kind: Kind::Zero, limit, ..Exponent::new(Ball::ZERO, Ball::ZERO, shape, cluster) }
}

/// The vectors of the entries of the exponent 0, each with the size of its block.
///
/// With damping there is one for each block. Without, one stands for two exponents: a block of even size has half as
/// many, and blocks of odd size, of which there are always two alike (the spectrum is that of a Hamiltonian matrix; where D is 0,
/// all sizes are even), share theirs as the limit of a pair ±iω does, with a vector whose real and imaginary parts head them.
fn zero_rows(blocks: &Blocks, paired: bool) -> Vec<(Option<Vec<Wide>>, usize)> {
    let mut rows = Vec::new();
    let mut at = 0;
    while let Some(&order) = blocks.sizes.get(at) {
        let head = blocks.heads.get(at).cloned();
        if !paired {
            rows.push((head, order));
        } else if order % 2 == 0 {
            rows.extend(std::iter::repeat_n((head, order), order / 2));
        } else {
            at += 1;
            let both = match (head, blocks.heads.get(at)) {
                (Some(head), Some(other)) => Some(joined(&head, other)),
                (head, _) => head,
            };
            rows.extend(std::iter::repeat_n((both, order), order));
        }
        at += 1;
    }
    rows
}

/// (x + iy)/√2
fn joined(x: &[Wide], y: &[Wide]) -> Vec<Wide> {
    let root = Big::one(4 * BITS).scale(-1).sqrt();
    let turned = |y: &Wide| Wide { re: -&y.im, im: y.re.clone() };
    let both = x.iter().zip(y).map(|(x, y)| x.add(&turned(y)).times(&root));
    both.collect()
}

/// An entry of M in the coordinates of the problem.
fn true_mass(scaled: &Scaled, i: usize, j: usize) -> Ball {
    let by = scaled.shift[i] + scaled.shift[j];
    scaled.mass.ball(i, j).scale(-by)
}

/// Shapes of the entries of the exponent 0 from the kernel of S, where no block is larger than 2; so many entries.
pub(super) fn zero_shapes(scaled: &Scaled, solution: &Solution, count: usize) -> Option<Vec<Shape>> {
    let wide = |at: &usize| -> Vec<Wide> {
        let vector = scaled.zero[*at].iter().zip(&scaled.shift);
        let part = |(x, by): (&Ball, &i32)| Wide::from_complex(&Complex::new(*x, Ball::ZERO), BITS).scale((*by).into());
        vector.map(part).collect()
    };
    let metric =
        Metric { n: scaled.n, mass: &|i, j| Big::from_ball(&true_mass(scaled, i, j), BITS), shift: &scaled.shift };
    let z = scaled.zero.len();
    let heads = &solution.facts.zero_heads;
    let others: Vec<usize> = (0..z).filter(|at| !heads.contains(at)).collect();
    let mut vectors: Vec<Vec<Wide>> = Vec::with_capacity(z);
    for part in [heads, &others] {
        let new = metric.orthonormal(&vectors, part.iter().map(wide).collect(), part.len())?;
        vectors.extend(new);
    }
    let sizes = if solution.facts.paired {
        let drifts = (2 * count).saturating_sub(z).min(z);
        [vec![2; drifts], vec![1; z - drifts]].concat()
    } else {
        vec![1; z]
    };
    let blocks = Blocks { sizes, heads: vectors };
    let rows = zero_rows(&blocks, solution.facts.paired).into_iter();
    Some(rows.filter_map(|(head, _)| Some(finished(&head?))).collect())
}

/// Shapes of exponents that the bounds do not separate and that have as many vectors as there are of them, with xᴴMy = 0:
/// some basis of what the given ones span. The bound is that of the distance from the exact space.
///
/// A combination Σ t_c x_c of vectors within b_c of the space is within Σ |t_c| b_c of it.
pub(super) fn cluster_shapes(scaled: &Scaled, columns: &[Shape]) -> Option<Vec<Shape>> {
    let k = columns.len();
    let candidates = columns.iter().enumerate().map(|(at, (vector, _))| {
        let own = vector.iter().map(|x| Wide::from_c64(*x, BITS));
        // The weights of the columns are carried along.
        let weights = (0..k).map(|other| Wide::from_c64(c64::new(f64::from(u8::from(at == other)), 0.0), BITS));
        own.chain(weights).collect()
    });
    let metric =
        Metric { n: scaled.n, mass: &|i, j| Big::from_ball(&true_mass(scaled, i, j), BITS), shift: &scaled.shift };
    let basis = metric.orthonormal(&[], candidates.collect(), k)?;
    let shape = |vector: &Vec<Wide>| {
        let (own, weights) = vector.split_at(scaled.n);
        let (vector, rounding) = finished(own);
        let reached = weights.iter().zip(columns).map(|(weight, (_, bound))| {
            let size = weight.re.abs_upper() + weight.im.abs_upper();
            (size * Magnitude::from_f64(*bound)).to_f64()
        });
        let sum: f64 = reached.sum();
        (vector, up((sum + rounding) * (1.0 + k as f64 * f64::EPSILON)))
    };
    Some(basis.iter().map(shape).collect())
}
