//! Refinement, from doubles upwards until every digit that is wanted is covered.
//!
//! The same loop at every precision level: measure the columns, enclose all eigenvalues, refine the columns. Large
//! problems start with products of doubles (`quick`), small ones with double-double.

use super::certify::{Cluster, Couplings, certify};
use super::dense::Matrix;
use super::pencil::{Enclosed, Pencil, Scaled, ZeroSpace, couplings, pencil};
use super::quick::{Quick, Round};
use super::start::{Factor, Failure, careful_eigenvectors};
use super::{ModesError, Options, PrecisionLevel, refine, shape};
use crate::precision::{Ball, Big, DoubleDouble};

/// Most rounds of refinement; each squares the error, so that more do not help.
const ROUNDS: usize = 6;

/// From this dimension on most of the work is left to doubles (`quick`): 1.4 times as fast at 30, three times as fast
/// at 228 (benches/modes.rs, `chains`).
const QUICK: usize = 20;

/// Slices of a dense matrix of n coordinates: some 70 bits, which tell residuals apart from rounding and leave ten
/// digits of eigenvalues a millionth of the largest; one slice more where n roundings take too much of that.
fn slices(n: usize) -> usize {
    if n < 500 { 1 } else { 2 }
}

/// Slices that leave all of a double-double.
const ALL_SLICES: usize = 3;

/// How accurate shapes have to be, in length: they have as many digits as frequencies, but doubles hold no more than
/// these.
pub(super) fn shapes(options: &Options) -> f64 {
    10f64.powi(-(options.digits.min(12) as i32))
}

/// Certified columns.
pub(super) struct Solution {
    pub(super) x: Matrix,
    pub(super) gram: Gram,
    /// A bound, for each column, of the M-length of its part along the zero vectors.
    pub(super) leak: Vec<f64>,
    pub(super) certificate: Certificate,
    /// Eigenvalues beyond double-double, by position; may end early.
    pub(super) precise: Vec<Option<Big>>,
    /// Where the columns come from.
    pub(super) level: PrecisionLevel,
}

impl Solution {
    fn new(x: Matrix, gram: Gram, leak: Vec<f64>, certificate: Certificate, level: PrecisionLevel) -> Self {
        Self { x, gram, leak, certificate, precise: Vec::new(), level }
    }
}

/// XᵀMX, in the form in which a precision level leaves it.
pub(super) enum Gram {
    Entries(Enclosed),
    Factors(Box<Round>),
}

impl Gram {
    pub(super) fn diagonal(&self, k: usize) -> Ball {
        match self {
            Self::Entries(g) => g.ball(k, k),
            Self::Factors(round) => {
                let leak = round.leak[k];
                round.norm[k].with_added_radius(leak * leak)
            }
        }
    }

    /// The entries of some columns, without bounds.
    pub(super) fn block(&self, columns: &[usize]) -> Matrix {
        match self {
            Self::Factors(round) => round.gram(columns),
            Self::Entries(g) => Matrix::from_fn(columns.len(), columns.len(), |p, q| g.mid.get(columns[p], columns[q])),
        }
    }
}

/// What is proved about the columns.
pub(super) struct Certificate {
    /// The columns by rising eigenvalue.
    pub(super) order: Vec<usize>,
    /// The eigenvalues by rising position: the k-th ball holds the k-th eigenvalue.
    pub(super) eigenvalues: Vec<Ball>,
    /// The clusters by rising position; together they hold every position once.
    pub(super) clusters: Vec<Cluster>,
}

impl Certificate {
    pub(super) fn new(quotients: &[DoubleDouble], couplings: Couplings) -> Option<Self> {
        let enclosures = certify(&couplings)?;
        let order = couplings.order;
        let eigenvalues = order.iter().zip(&enclosures.radii).map(|(&j, &radius)| Ball::new(quotients[j], radius));
        Some(Self { eigenvalues: eigenvalues.collect(), order, clusters: enclosures.clusters })
    }
}

/// The first approximation, in doubles if they will do.
pub(super) fn first(scaled: &Scaled, zero: &Matrix) -> Result<(Matrix, bool), ModesError> {
    match Factor::new(&scaled.mass.mid) {
        Some(factor) => {
            let x = factor.eigenvectors(&scaled.stiffness.mid, zero);
            Ok((x.ok_or(ModesError::NoConvergence)?, false))
        }
        None => Ok((careful(scaled, zero)?, true)),
    }
}

/// Relative size below which a pivot in double-double cannot be told from rounding error, per unit of dimension.
const NOISE: f64 = 64.0 * f64::EPSILON * f64::EPSILON;

/// The first approximation with Cholesky factor and reduction in double-double.
pub(super) fn careful(scaled: &Scaled, zero: &Matrix) -> Result<Matrix, ModesError> {
    let n = scaled.n;
    let mass = |i: usize, j: usize| Ball::from(scaled.mass.mid.get(i, j));
    let stiffness = |i: usize, j: usize| Ball::from(scaled.stiffness.mid.get(i, j));
    match careful_eigenvectors(&mass, &stiffness, &zero.doubles(), NOISE * n as f64, ()) {
        Ok(columns) => Ok(Matrix::from_fn(n, columns.len(), |i, j| columns[j][i].mid)),
        Err(Failure::NoConvergence) => Err(ModesError::NoConvergence),
        Err(Failure::NotPositiveDefinite(direction)) => Err(not_positive_definite(scaled, &direction)),
    }
}

pub(super) fn not_positive_definite(scaled: &Scaled, direction: &[Ball]) -> ModesError {
    // Where the form is 0 it is negative beside that, unless M takes the direction to 0: of T = x' y', too.
    let image = scaled.mass.transpose_times(direction);
    let steepest = (0..image.len()).max_by(|i, j| image[*i].mid.hi.abs().total_cmp(&image[*j].mid.hi.abs()));
    let mut beside = direction.to_vec();
    if let Some(at) = steepest {
        let own = scaled.mass.mid.get(at, at).hi;
        let step = image[at].mid_f64() / if own > 0.0 { own } else { 1.0 };
        beside[at] = beside[at] - Ball::exact(step);
    }
    let is_negative = |direction: &[Ball]| scaled.mass.form(direction).is_negative();
    let direction = if !is_negative(direction) && is_negative(&beside) { &beside } else { direction };
    let singular = !is_negative(direction);
    let physical: Vec<f64> = direction.iter().zip(&scaled.shift).map(|(x, &s)| x.mid.scale(s).hi).collect();
    // Out of range the direction cannot be told; what is finite of it still points somewhere.
    let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
    let larger = |a: f64, &b: &f64| if finite(b).abs() > a.abs() { b } else { a };
    let largest = physical.iter().fold(0.0, larger);
    let direction = if largest == 0.0 {
        vec![1.0; physical.len()]
    } else {
        physical.iter().map(|&x| finite(x) / largest + 0.0).collect()
    };
    ModesError::NotPositiveDefinite { direction, singular }
}

/// From doubles upwards until every digit that is wanted is covered, or nothing improves any more.
pub(super) fn refined(scaled: &Scaled, zero: &ZeroSpace, options: &Options) -> Result<Solution, ModesError> {
    let (mut x, careful) = first(scaled, &zero.mid)?;

    let mut level = if careful { PrecisionLevel::DoubleDouble } else { PrecisionLevel::Doubles };
    if scaled.n >= QUICK && !careful {
        match quick(scaled, zero, options, &x) {
            Ok(solution) => return Ok(solution),
            Err(better) => (x, level) = (better, PrecisionLevel::Refined),
        }
    }
    let mut best = None;
    let outcome = rounds(scaled, zero, options, (x, level), &mut best);
    best.map(|(_, solution)| solution).ok_or(outcome.err().unwrap_or(ModesError::NoConvergence))
}

/// Refines columns in double-double until everything that is wanted is covered or nothing is gained; `best` are the best so far, with
/// their score.
fn rounds(
    scaled: &Scaled,
    zero: &ZeroSpace,
    options: &Options,
    (mut x, mut level): (Matrix, PrecisionLevel),
    best: &mut Option<(f64, Solution)>,
) -> Result<(), ModesError> {
    let mut before = f64::INFINITY;
    for round in 0..=ROUNDS {
        let pencil = pencil(scaled, zero, &x);
        let certificate = couplings(&pencil).and_then(|(quotients, couplings)| Certificate::new(&quotients, couplings));
        let Some(certificate) = certificate else {
            if before.is_finite() {
                break;
            }
            if round == ROUNDS {
                return Err(unproved(scaled, &pencil, &x));
            }
            if level >= PrecisionLevel::DoubleDouble {
                x = refine::refine(&pencil, zero, &x);
            } else {
                level = PrecisionLevel::DoubleDouble;
                x = careful(scaled, &zero.mid)?;
            }
            continue;
        };
        let satisfied = satisfied(&certificate, options, round);
        let score = score(&certificate, options);
        let next = (!satisfied && round < ROUNDS).then(|| refine::refine(&pencil, zero, &x));
        // Less than a few bits gained in all: double-double has nothing more to give.
        let stuck = score > before - 4.0;
        before = before.min(score);
        if satisfied || best.as_ref().is_none_or(|(best, _)| score <= *best) {
            let solution = Solution::new(x, Gram::Entries(pencil.g), pencil.leak, certificate, level);
            *best = Some((score, solution));
        }
        match next {
            Some(next) if !stuck => (x, level) = (next, level.max(PrecisionLevel::Refined)),
            _ => break,
        }
    }
    Ok(())
}

/// The level of doubles: as long as refinement gains something. Where not everything that is wanted is covered, columns that
/// are better than before.
fn quick(scaled: &Scaled, zero: &ZeroSpace, options: &Options, x: &Matrix) -> Result<Solution, Matrix> {
    let quick = Quick::new(scaled, zero);
    let mut round = quick.round(x.transposed(), slices(scaled.n));
    let mut before = f64::INFINITY;
    for number in 0..=ROUNDS {
        if !round.is_finite() {
            break;
        }
        let first = number == 0 && options.vectors;
        let few = number == 0 && options.digits <= 12;
        // What doubles come to may be known to be too little for the shapes before it is certified.
        if !(first && round.is_mixed(2.0 * shapes(options))) {
            let Some(certificate) = Certificate::new(&round.quotient, round.couplings()) else { break };
            if satisfied(&certificate, options, number) {
                let level = if number == 0 { PrecisionLevel::Doubles } else { PrecisionLevel::Refined };
                let (x, leak) = (round.xt.transposed(), round.leak.clone());
                return Ok(Solution::new(x, Gram::Factors(Box::new(round)), leak, certificate, level));
            }
            let score = score(&certificate, options);
            if number == ROUNDS || score > before - 4.0 {
                break;
            }
            before = score;
        }
        let step = refine::Step::new(&round);
        let xt = refine::refine_rows(&quick, &round, &step);
        round = quick.round(xt, if few { slices(scaled.n) } else { ALL_SLICES });
    }
    Err(round.xt.transposed())
}

/// M is positive definite as far as its midpoints go, but the bounds do not show it: the direction
/// of the column that is known worst.
fn unproved(scaled: &Scaled, pencil: &Pencil, x: &Matrix) -> ModesError {
    let worst =
        (0..x.columns).max_by(|&i, &j| pencil.g.radius.get(i, i).total_cmp(&pencil.g.radius.get(j, j))).unwrap_or(0);
    let direction: Vec<Ball> = (0..scaled.n).map(|row| Ball::from(x.get(row, worst))).collect();
    not_positive_definite(scaled, &direction)
}

/// The bits of all radii and vector errors together: what a round has gained shows here.
fn score(certificate: &Certificate, options: &Options) -> f64 {
    let values: f64 = certificate.eigenvalues.iter().map(|x| (x.radius + 1e-300).log2()).sum();
    let vectors = certificate.clusters.iter().map(|c| (shape::rough_error(c) + 1e-17).log2());
    if options.vectors { values + vectors.sum::<f64>() } else { values }
}

/// Whether the enclosures cover the wanted digits, and the vectors are good enough.
pub(super) fn satisfied(certificate: &Certificate, options: &Options, round: usize) -> bool {
    let wanted = options.lowest.unwrap_or(usize::MAX);
    // Columns that are not separated in doubles may well be in double-double, and whether they are
    // in doubles depends on rounding errors: one round decides alike on every machine.
    let shapes = shapes(options);
    let separated = |cluster: &Cluster| {
        cluster.start >= wanted || if cluster.len() == 1 { shape::rough_error(cluster) < shapes } else { round > 0 }
    };
    (!options.vectors || certificate.clusters.iter().all(separated)) && covered(certificate, options)
}

/// Whether the enclosures cover the wanted digits.
pub(super) fn covered(certificate: &Certificate, options: &Options) -> bool {
    certificate.eigenvalues.iter().take(options.lowest.unwrap_or(usize::MAX)).all(|x| options.covers(x, true))
}
