//! The last precision level: as many bits as it takes, for the columns that need them.
//!
//! A radius is quadratic in the residuals of its column, so that D digits need vectors of D / 2 digits and only
//! the residual of the column at full precision, for the vectors exactly as they stand; its couplings to all others
//! are products in doubles of residuals that are small. The steps of the vectors are those of double-double
//! (the resolvent in doubles), each good for some ten digits.

use super::columns::{Column, approximate, residuals};
use super::complex::Wide;
use super::couplings::{Approximate, Residuals};
use super::scale::Scaled;
use super::solve::{Round, Rounds, Solution, closed};
use super::{Options, PreciseQuadratic, PrecisionLevel, QuadraticProblem, QuadraticSource};
use crate::precision::{Ball, Big, SparseMatrix};

/// The most bits that are worked with: bounds are doubles.
const MOST_BITS: usize = 900;
/// Rounds, rises of precision included.
const ROUNDS: usize = 60;
/// Products for a round that are still worth starting: some seconds.
const MOST_WORK: f64 = 3e8;

/// Better columns in the place of those that lack digits, as far as bits and effort go.
pub(super) fn beyond(
    scaled: &Scaled,
    problem: &QuadraticProblem,
    source: &dyn QuadraticSource,
    solution: Solution,
    options: &Options,
) -> Option<Solution> {
    let digits = options.digits.min(250) as f64;
    // What the smallest part needs beside the largest exponent, as far as is known by now.
    let lacking = (0..solution.statuses.len()).filter(|j| solution.statuses[*j].lacking);
    let parts = lacking.map(|j| solution.columns.mu(j)).flat_map(|mu| [mu.re.mid.hi.abs(), mu.im.mid.hi.abs()]);
    let least = parts.filter(|part| *part > 1e-25).fold(1.0, f64::min);
    let bits = ((digits + 3.0) * 3.33 - least.log2() + 64.0).max(160.0) as usize;
    let mut bits = bits.min(MOST_BITS);
    let Some(mut matrices) = Matrices::new(scaled, problem, source, bits) else { return Some(solution) };
    let count: usize = matrices.all.iter().map(SparseMatrix::stored).sum();
    let mut columns = solution.columns.clone();
    columns.bits = half(bits);
    let lacking: Vec<usize> = (0..columns.count()).filter(|&j| solution.statuses[j].lacking).collect();
    columns.widen(&closed(&solution.certificate, &columns, &lacking));
    let facts = &solution.facts.clone();
    let mut measured = solution.measured.clone();
    // Whatever has more bits is better.
    let mut rounds = Rounds { scaled, facts, options, best: Some((f64::INFINITY, solution)) };
    let mut stalled = 0;
    for _ in 0..ROUNDS {
        if (count * columns.wide.len()) as f64 * (bits as f64 / 64.0 + 1.0) > MOST_WORK {
            break;
        }
        columns.measure(&matrices, &mut measured);
        let Some(Round { gained, lacking, groups, better }) =
            rounds.round(columns, measured.clone(), PrecisionLevel::Precise)
        else {
            break;
        };
        if !lacking.iter().any(|&j| j >= better.together()) {
            break;
        }
        columns = better;
        columns.widen(&groups);
        stalled = if gained { 0 } else { stalled + 1 };
        if stalled >= 3 {
            if bits >= MOST_BITS {
                break;
            }
            bits = (bits + bits / 2).min(MOST_BITS);
            match Matrices::new(scaled, problem, source, bits) {
                Some(finer) => matrices = finer,
                None => break,
            }
            columns.bits = half(bits);
            stalled = 0;
        }
    }
    rounds.best.map(|(_, solution)| solution)
}

/// Bits of vectors for matrices of so many.
fn half(bits: usize) -> usize {
    bits / 2 + 64
}

/// The scaled matrices.
pub(super) struct Matrices {
    bits: usize,
    all: [SparseMatrix<Big>; 3],
}

impl Matrices {
    fn new(scaled: &Scaled, problem: &QuadraticProblem, source: &dyn QuadraticSource, bits: usize) -> Option<Self> {
        let n = scaled.n;
        let whole = source.precisely(bits).or_else(|| as_it_is(problem, bits))?;
        if whole.iter().any(|m| m.len() != n * n || m.iter().any(|x| !x.is_finite())) {
            return None;
        }
        let matrix = |k: usize| {
            let entry = |at: usize| {
                let (row, column) = (at % n, at / n);
                let by = scaled.shift[row] + scaled.shift[column] - k as i32 * scaled.power;
                (row as u32, column as u32, whole[k][at].scale(i64::from(by)).with_bits(bits))
            };
            SparseMatrix::from_shares(n, &(0..n * n).map(entry).collect::<Vec<_>>())
        };
        Some(Self { bits, all: [0, 1, 2].map(matrix) })
    }
}

/// Enclosures without radius are the matrices to any precision.
fn as_it_is(problem: &QuadraticProblem, bits: usize) -> Option<PreciseQuadratic> {
    let all = [&problem.mass, &problem.velocity, &problem.stiffness];
    let is_exact = all.iter().all(|matrix| matrix.iter().all(Ball::is_exact));
    is_exact.then(|| all.map(|matrix| matrix.iter().map(|x| Big::from_ball(x, bits)).collect()))
}

/// A column of many bits.
#[derive(Clone)]
pub(super) struct WideColumn {
    pub(super) own: Column<Big>,
    /// M x and D x, as they were measured.
    image: Vec<Wide>,
    slope: Vec<Wide>,
}

impl WideColumn {
    pub(super) fn new(own: Column<Big>) -> Self {
        Self { own, image: Vec::new(), slope: Vec::new() }
    }

    pub(super) fn conjugate(&self) -> Self {
        let conjugate = |vector: &[Wide]| vector.iter().map(Wide::conjugate).collect();
        Self { own: self.own.conjugate(), image: conjugate(&self.image), slope: conjugate(&self.slope) }
    }

    /// Q_ij = y_iᵀ ((μ_i + μ_j) M + D) x_j.
    pub(super) fn unit(&self, other: &Self) -> Approximate {
        let sum = self.own.mu.add(&other.own.mu);
        let parts = other.image.iter().zip(&other.slope);
        let terms = self.own.y.iter().zip(parts).map(|(y, (u, v))| y.mul(&sum.mul(u).add(v)));
        approximate(&terms.fold(Wide::zero(64), |total, term| total.add(&term)))
    }

    pub(super) fn residuals(&mut self, matrices: &Matrices) -> Residuals {
        let bits = matrices.bits;
        let of_x = matrices.all.each_ref().map(|a| a.times(&self.own.x, false, bits));
        let of_y = matrices.all.each_ref().map(|a| a.times(&self.own.y, true, bits));
        let residuals = residuals(&mut self.own, &of_x, &of_y, bits);
        let [image, slope, _] = of_x;
        (self.image, self.slope) = (image, slope);
        residuals
    }
}
