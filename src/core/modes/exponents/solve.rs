//! The precision levels for one problem.

use super::super::pencil::ZeroSpace;
use super::super::start::{NOISE, cholesky};
use super::basis::Metric;
use super::blocks::Pencil;
use super::certify::{Certificate, Disc, certify};
use super::columns::{Columns, measure, steps};
use super::couplings::{Couplings, Residuals};
use super::exact::{self, exact};
use super::far::far_start;
use super::repeated::exact_spectrum;
use super::scale::Scaled;
use super::spectrum::{Facts, Status, finish, mark_rough, spectrum, status};
use super::start::start;
use super::wide::{WideColumn, beyond};
use super::{Exponents, ModesError, Options, PrecisionLevel, QuadraticProblem, QuadraticSource, Structure};
use crate::order::Gather;
use crate::precision::{Ball, Big, Integers, has_pivots, sum_of_products};

/// Rounds in double-double, the first one included.
const ROUNDS: usize = 12;
/// Inertias may differ by nearly so many bits.
const BITS_OF_PIVOTS: usize = 1024;

/// Columns with what is proved about them.
pub(super) struct Solution {
    pub(super) columns: Columns,
    pub(super) measured: Vec<Residuals>,
    pub(super) certificate: Certificate,
    pub(super) facts: Facts,
    pub(super) statuses: Vec<Status>,
    pub(super) level: PrecisionLevel,
}

/// All exponents of a problem whose source can be asked for more where the enclosures do not do.
///
/// # Errors
///
/// See [`ModesError`]; M must be positive definite, provably so.
pub fn exponents(
    problem: &QuadraticProblem,
    source: &dyn QuadraticSource,
    options: &Options,
) -> Result<Exponents, ModesError> {
    let scaled = Scaled::new(problem)?;
    if scaled.n == 0 {
        return Ok(finish(Vec::new(), PrecisionLevel::Doubles, options, &|_| true));
    }
    let inner = &options.smaller(i64::from(scaled.power));
    let mut solution = match in_double_double(&scaled, inner) {
        // What doubles and double-double do not begin with, exact numbers may decide all the same.
        Err(error @ (ModesError::NoConvergence | ModesError::MassNotDecided)) => {
            let facts = Facts::new(&scaled);
            let exact = source.integers();
            let exact = exact.filter(|own| error == ModesError::NoConvergence || has_definite_mass(own, scaled.n));
            if let Some(found) = exact.and_then(|matrices| decided(&scaled, &matrices, &facts, options)) {
                return Ok(found);
            }
            if problem.zero_vectors.is_empty() {
                return Err(error);
            }
            // Chains longer than those that are split off: without what is known of them, everything near 0 stays open.
            let open = QuadraticProblem { zero_vectors: Vec::new(), ..problem.clone() };
            return exponents(&open, &(), options);
        }
        found => found?,
    };
    let lacking = solution.statuses.iter().any(|status| status.lacking);
    let rough = solution.statuses.iter().any(|status| status.rough);
    if lacking || rough {
        if (rough || undecided(&solution))
            && scaled.n <= exact::LARGEST
            && let Some(matrices) = source.integers()
            && let Some(found) = decided(&scaled, &matrices, &solution.facts, options)
        {
            return Ok(found);
        }
        if lacking {
            solution = beyond(&scaled, problem, source, solution, inner).ok_or(ModesError::NoConvergence)?;
        }
    }
    Ok(spectrum(&scaled, &solution, options))
}

/// The exponents of matrices that are known exactly, of which M is singular: as many as the determinant has roots. Vectors have any length;
/// several of one exponent are orthogonal in M + 1. `None` where the determinant is 0 everywhere, or out of reach.
#[must_use]
pub fn exponents_without_inertia(
    problem: &QuadraticProblem,
    matrices: &Integers,
    options: &Options,
) -> Option<Exponents> {
    let scaled = Scaled::new(problem).ok()?;
    let facts = Facts { definite: false, ..Facts::new(&scaled) };
    decided(&scaled, matrices, &facts, options)
}

/// The exponents of matrices that are known exactly.
fn decided(scaled: &Scaled, matrices: &Integers, facts: &Facts, options: &Options) -> Option<Exponents> {
    let n = scaled.n;
    let bits = 128 + 4 * options.digits;
    let pencil = Pencil { matrices, n };
    let values = pencil.values(&matrices.matrices[0], 0, bits);
    let singular = !has_definite_mass(matrices, n);
    let mass = |i: usize, j: usize| {
        let own = values.get(j * n + i).cloned().unwrap_or(Big::zero(bits));
        if singular && i == j { &own + &Big::one(bits) } else { own }
    };
    let metric = Metric { n, mass: &mass, shift: &scaled.shift };
    let metric = options.vectors.then_some(&metric);
    let found = exact(matrices, n, options, facts.definite, metric)?;
    Some(exact_spectrum(scaled, facts, matrices, found, options))
}

/// Whether M is shown to be positive definite: elimination without exchanges has positive pivots.
fn has_definite_mass(matrices: &Integers, n: usize) -> bool {
    let rows = || {
        let values = Pencil { matrices, n }.values(&matrices.matrices[0], 0, BITS_OF_PIVOTS);
        values.chunks(n.max(1)).map(<[Big]>::to_vec).collect()
    };
    n <= exact::LARGEST && has_pivots(rows(), Big::is_positive, BITS_OF_PIVOTS)
}

/// Whether more digits may not decide what is open: exponents that are not separated, signs, the multiplicity
/// of the exponent 0.
fn undecided(solution: &Solution) -> bool {
    let columns = &solution.columns;
    (0..columns.count()).any(|j| {
        let status = &solution.statuses[j];
        let Disc { radius, shared, .. } = solution.certificate.disc(j);
        let (mu, _) = columns.value(j, radius);
        status.lacking
            && (shared > 1
                || j < columns.together()
                || !status.growth_zero && mu.re.contains_zero()
                || !status.omega_zero && mu.im.contains_zero())
    })
}

/// The precision levels up to double-double.
fn in_double_double(scaled: &Scaled, options: &Options) -> Result<Solution, ModesError> {
    let l = cholesky(&scaled.mass.mid.doubles(), NOISE * scaled.n as f64).ok_or(ModesError::MassNotDecided)?;
    if !scaled.mass.is_positive_definite() {
        return Err(ModesError::MassNotDecided);
    }
    ZeroSpace::new(&scaled.mass, &scaled.stiffness_t, scaled.zero.clone())
        .map_err(|index| ModesError::ZeroVector { index })?;
    let facts = Facts::new(scaled);
    let begun = start(scaled, &l).or_else(|| far_start(scaled));
    let mut columns = begun.ok_or(ModesError::NoConvergence)?;
    let mut rounds = Rounds { scaled, facts: &facts, options, best: None };
    let mut stalled = 0;
    for round in 0..ROUNDS {
        let measured = measure(scaled, &mut columns);
        let level = if round == 0 { PrecisionLevel::Doubles } else { PrecisionLevel::Refined };
        let Some(Round { gained, lacking, better, .. }) = rounds.round(columns, measured, level) else { break };
        stalled = if gained { 0 } else { stalled + 1 };
        if lacking.is_empty() || stalled >= 2 {
            break;
        }
        columns = better;
    }
    rounds.best.map(|(_, solution)| solution).ok_or(ModesError::NoConvergence)
}

/// The best columns so far, with their score, and what they are judged by.
pub(super) struct Rounds<'a> {
    pub(super) scaled: &'a Scaled,
    pub(super) facts: &'a Facts,
    pub(super) options: &'a Options,
    pub(super) best: Option<(f64, Solution)>,
}

/// What a round has come to.
pub(super) struct Round {
    /// Whether the score has improved by some bits.
    pub(super) gained: bool,
    /// Columns that lack digits, and those that have to be improved with them.
    pub(super) lacking: Vec<usize>,
    pub(super) groups: Vec<usize>,
    /// Better columns in the place of those that lack digits.
    pub(super) better: Columns,
}

impl Rounds<'_> {
    /// Certifies columns and keeps them if they are the best so far; `None` where numbers leave the range of doubles.
    pub(super) fn round(&mut self, columns: Columns, measured: Vec<Residuals>, level: PrecisionLevel) -> Option<Round> {
        let Self { scaled, facts, options, .. } = *self;
        let distance = |i: usize, j: usize| columns.difference(i, j).norm();
        let known = self.best.as_ref().map(|(_, best)| columns.units(&best.certificate)).unwrap_or_default();
        let couplings = Couplings::new(scaled.n, &measured, &columns.links, &known, distance)?;
        let certificate = certify(&couplings, columns.together(), &columns.conjugate_of);
        let mut statuses = status(facts, &columns, &measured, &certificate, options);
        if options.vectors && columns.bits == 0 {
            mark_rough(&mut statuses, &columns, &measured, &certificate);
        }
        // The bits of all radii together, relative to what they have to cover; digits before vectors.
        let weight = |status: &Status| if status.lacking { 1e4 } else { 0.0 };
        let score: f64 = statuses.iter().map(|status| status.score + weight(status)).sum();
        let before = self.best.as_ref().map_or(f64::INFINITY, |(score, _)| *score);
        let lacking: Vec<usize> = (0..columns.count()).filter(|&j| statuses[j].lacking || statuses[j].rough).collect();
        let groups = closed(&certificate, &columns, &lacking);
        let better = match lacking[..] {
            [] => Columns::default(),
            _ => better(&couplings, &columns, &measured, &certificate, &lacking),
        };
        if score <= before {
            let facts = facts.clone();
            self.best = Some((score, Solution { columns, measured, certificate, facts, statuses, level }));
        }
        Some(Round { gained: score < before - 4.0, lacking, groups, better })
    }
}

/// The given columns, all of their groups, and those that they are conjugates of.
pub(super) fn closed(certificate: &Certificate, columns: &Columns, which: &[usize]) -> Vec<usize> {
    let members = which.iter().flat_map(|&j| &certificate.groups[certificate.of[j]].members);
    members.flat_map(|&j| [j, columns.conjugate_of[j].unwrap_or(j)]).distinct()
}

/// Better columns in the place of those that lack digits.
fn better(
    couplings: &Couplings,
    columns: &Columns,
    measured: &[Residuals],
    certificate: &Certificate,
    lacking: &[usize],
) -> Columns {
    let mut next = columns.clone();
    let turned = columns.turn_groups(couplings, certificate, lacking, &mut next);
    for (j, turned) in turned.iter().enumerate().skip(columns.together()) {
        // In double-double all of the others: the part of a fast column along a slow pair is the difference of two large
        // ones, so that the pair has to be biorthonormal to more digits than it needs for itself.
        if *turned
            || columns.conjugate_of[j].is_some()
            || columns.bits > 0 && !(columns.wide.contains_key(&j) && lacking.contains(&j))
        {
            continue;
        }
        let difference = |i: usize| columns.difference(j, i);
        let same = |i: usize| certificate.of[i] == certificate.of[j];
        let steps = steps(couplings, columns, measured, j, difference, same);
        let unit = couplings.unit[(j, j)];
        if let Some(column) = columns.wide.get(&j) {
            if let Some(improved) = column.own.improved(steps, unit, columns.bits) {
                next.wide.insert(j, WideColumn::new(improved));
            }
        } else if let Some(improved) = columns.all[j].improved(steps, unit, ()) {
            next.all[j] = improved;
        }
    }
    if columns.bits == 0 {
        next.mirror();
    }
    next
}

impl Facts {
    fn new(scaled: &Scaled) -> Self {
        let gyroscopic = scaled.structure == Structure::Gyroscopic;
        let (least_zeros, zero_heads) = least_zeros(scaled);
        Self {
            gyroscopic,
            paired: gyroscopic || scaled.structure == Structure::Circulatory,
            definite: gyroscopic && scaled.zero.is_empty() && scaled.stiffness.is_positive_definite(),
            symmetric: match scaled.structure {
                Structure::Gyroscopic | Structure::Circulatory => false,
                Structure::Symmetric => true,
                Structure::Dissipative | Structure::Damped => {
                    scaled.velocity.is_symmetric() && scaled.stiffness.is_symmetric()
                }
            },
            least_zeros,
            zero_heads,
        }
    }
}

/// A lower bound of the algebraic multiplicity of the exponent 0, z vectors Z of the kernel given, and those of them that
/// are seen to be heads.
///
/// A vector Z a with D Z a = 0 is the head of a chain: L(λ)(Z a) = λ² M Z a. Where S is symmetric,
/// S z₁ = -D Z a can be solved where ZᵀDZ a = 0. Without dissipation these are z - rank(ZᵀDZ) heads; the rank of a skew matrix is
/// even, and not above the number of rows that are not 0 as they stand. The multiplicity is even, the spectrum
/// being symmetric and of even order.
fn least_zeros(scaled: &Scaled) -> (usize, Vec<usize>) {
    let z = scaled.zero.len();
    let mirrored =
        !matches!(scaled.structure, Structure::Circulatory | Structure::Damped) || scaled.stiffness.is_symmetric();
    let is_head = |at: usize| {
        if scaled.unmoved.get(at) == Some(&true) {
            return true;
        }
        let image = scaled.velocity_t.transpose_times(&scaled.zero[at]);
        if !mirrored {
            return image.iter().all(Ball::is_zero);
        }
        scaled.zero.iter().all(|other| sum_of_products(other, &image, ()).is_zero())
    };
    let heads: Vec<usize> = (0..z).filter(|at| is_head(*at)).collect();
    if scaled.structure != Structure::Gyroscopic {
        return (z + heads.len(), heads);
    }
    let rank = (z - heads.len()) & !1;
    let least = 2 * z - rank;
    (least + (least & 1), heads)
}
