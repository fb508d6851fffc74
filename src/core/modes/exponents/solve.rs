//! The ladder for one problem.

use super::basis::Metric;
use super::blocks::Pencil;
use super::certify::{Certificate, Disc, certify};
use super::columns::{Column, Columns, center, measure, steps, turned};
use super::complex::Complex;
use super::couplings::{Couplings, Sheet};
use super::definite::is_positive_definite;
use super::exact::{self, exact};
use super::far::far_start;
use super::repeated::exact_spectrum;
use super::resolve::turn;
use super::scale::Scaled;
use super::spectrum::{Facts, Status, mark_rough, spectrum, status};
use super::start::{cholesky, start};
use super::wide::climb;
use super::wide_columns::WideColumns;
use super::{
    Exponents, IntegerQuadratic, ModesError, Options, QuadraticProblem, QuadraticSource, Rung, Stability, Structure,
};
use crate::precision::{Ball, Big};

/// Rounds in double-double, the first one included.
const ROUNDS: usize = 12;

/// What a rung has come to.
pub(super) struct Solution {
    pub(super) columns: WideColumns,
    pub(super) sheets: Vec<Sheet>,
    pub(super) certificate: Certificate,
    pub(super) facts: Facts,
    pub(super) statuses: Vec<Status>,
    pub(super) rung: Rung,
}

pub(super) fn solve(
    problem: &QuadraticProblem,
    source: &dyn QuadraticSource,
    options: &Options,
) -> Result<Exponents, ModesError> {
    let scaled = Scaled::new(problem)?;
    if scaled.n == 0 {
        return Ok(Exponents {
            entries: Vec::new(),
            stability: Stability::Stable,
            secular: Some(false),
            rung: Rung::Doubles,
        });
    }
    let inner = &options.smaller(i64::from(scaled.power));
    let mut solution = match in_double_double(&scaled, inner) {
        // What doubles and double-double do not begin with, exact numbers may decide all the same.
        Err(ModesError::NoConvergence) => {
            let facts = Facts::new(&scaled);
            let exact = source.integers();
            if let Some(found) = exact.and_then(|matrices| decided(&scaled, &matrices, &facts, options)) {
                return Ok(found);
            }
            if problem.zero_vectors.is_empty() {
                return Err(ModesError::NoConvergence);
            }
            // Chains longer than those that are split off: without what is known of them, everything near 0 stays open.
            let open = QuadraticProblem { zero_vectors: Vec::new(), ..problem.clone() };
            return solve(&open, &(), options);
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
            solution = climb(&scaled, problem, source, solution, inner);
        }
    }
    Ok(spectrum(&scaled, &solution, options))
}

/// The exponents of matrices that are known exactly.
fn decided(scaled: &Scaled, matrices: &IntegerQuadratic, facts: &Facts, options: &Options) -> Option<Exponents> {
    let n = scaled.n;
    let bits = 128 + 4 * options.digits;
    let pencil = Pencil { matrices, n };
    let values = pencil.values(&matrices.mass, 0, bits);
    let mass = |i: usize, j: usize| values.get(j * n + i).cloned().unwrap_or(Big::zero(bits));
    let metric = Metric { n, mass: &mass, shift: &scaled.shift };
    let metric = options.vectors.then_some(&metric);
    let found = exact(matrices, n, options, facts.definite, metric)?;
    Some(exact_spectrum(scaled, facts, matrices, found, options))
}

/// Whether more digits may not decide what is open: exponents that are not separated, signs, the multiplicity
/// of the exponent 0.
fn undecided(solution: &Solution) -> bool {
    let columns = &solution.columns;
    (0..columns.base.count()).any(|j| {
        let status = &solution.statuses[j];
        let Disc { radius, shared, .. } = solution.certificate.disc(j);
        let value = columns.value(j, radius);
        status.lacking
            && (shared > 1
                || j < columns.base.together()
                || !status.growth_zero && value.growth.contains_zero()
                || !status.omega_zero && value.omega.contains_zero())
    })
}

/// The rungs up to double-double.
pub(super) fn in_double_double(scaled: &Scaled, options: &Options) -> Result<Solution, ModesError> {
    let l = cholesky(&scaled.mass.doubles()).ok_or(ModesError::MassNotDecided)?;
    if !is_positive_definite(&scaled.mass) {
        return Err(ModesError::MassNotDecided);
    }
    if let Some(index) = bad_zero_vector(scaled) {
        return Err(ModesError::ZeroVector { index });
    }
    let facts = Facts::new(scaled);
    let begun = start(scaled, &l).or_else(|| far_start(scaled));
    let mut columns = begun.ok_or(ModesError::NoConvergence)?;
    let mut best: Option<(f64, Solution)> = None;
    let mut stalled = 0;
    for round in 0..ROUNDS {
        let sheets = measure(scaled, &mut columns);
        let distance = |i: usize, j: usize| columns.distance(i, j);
        let Some(couplings) = Couplings::new(scaled.n, &sheets, &columns.links, &[], distance) else {
            break;
        };
        let certificate = certify(&couplings, columns.together(), &columns.twin);
        let value = |j: usize, radius: f64| columns.value(j, radius);
        let mut statuses = status(&facts, &columns, &sheets, &value, &certificate, options);
        if options.vectors {
            mark_rough(&mut statuses, &columns, &sheets, &certificate);
        }
        let score = score(&statuses);
        let lacking: Vec<usize> = (0..columns.count()).filter(|&j| statuses[j].lacking || statuses[j].rough).collect();
        let gained = best.as_ref().is_none_or(|(before, _)| score < before - 4.0);
        stalled = if gained { 0 } else { stalled + 1 };
        let next = (!lacking.is_empty() && stalled < 2 && round + 1 < ROUNDS)
            .then(|| better(&couplings, &columns, &sheets, &certificate, &lacking));
        let done = next.is_none();
        if best.as_ref().is_none_or(|(before, _)| score <= *before) {
            let rung = if round == 0 { Rung::Doubles } else { Rung::Refined };
            let kept = std::mem::replace(&mut columns, next.unwrap_or_default());
            let solution = Solution {
                columns: WideColumns { wide: vec![None; kept.count()], base: kept, bits: 0 },
                sheets,
                certificate,
                facts: facts.clone(),
                statuses,
                rung,
            };
            best = Some((score, solution));
        } else if let Some(next) = next {
            columns = next;
        }
        if done {
            break;
        }
    }
    best.map(|(_, solution)| solution).ok_or(ModesError::NoConvergence)
}

/// The bits of all radii together, relative to what they have to cover; digits before vectors.
fn score(statuses: &[Status]) -> f64 {
    let weight = |status: &Status| if status.lacking { 1e4 } else { 0.0 };
    statuses.iter().map(|status| status.score + weight(status)).sum()
}

/// Better columns in the place of those that lack digits.
fn better(
    couplings: &Couplings,
    columns: &Columns,
    sheets: &[Sheet],
    certificate: &Certificate,
    lacking: &[usize],
) -> Columns {
    let mut next = columns.clone();
    let turned = columns.turn_groups(certificate, lacking, &mut |members, real| {
        let old: Vec<Column<Ball>> = members.iter().map(|&j| columns.all[j].clone()).collect();
        let exponents: Vec<Complex> = old.iter().map(|column| column.mu).collect();
        let center = center(&exponents, real, ());
        let shift = |j: usize| columns.mu(j).sub(&center).to_c64();
        let turn = turn(couplings, members, &columns.twin, shift);
        if let Some(turn) = &turn
            && let Some(new) = turned(&old, turn, &center, ((), ()))
        {
            next.put(turn, new);
        }
        turn.is_some()
    });
    // All of the others: the part of a fast column along a slow pair is the difference of two large ones, so that the
    // pair has to be biorthonormal to more digits than it needs for itself.
    for (j, turned) in turned.iter().enumerate().skip(columns.together()) {
        if columns.twin[j].is_none() && !turned {
            let difference = |i: usize| columns.mu(j).sub(columns.mu(i)).to_c64();
            let same = |i: usize| certificate.of[i] == certificate.of[j];
            let steps = steps(couplings, columns, sheets, j, difference, same);
            if let Some(improved) = columns.all[j].improved(steps, couplings.unit.get(j, j), ()) {
                next.all[j] = improved;
            }
        }
    }
    next.mirror();
    next
}

impl Facts {
    fn new(scaled: &Scaled) -> Self {
        let gyroscopic = scaled.structure == Structure::Gyroscopic;
        let (least_zeros, zero_heads) = least_zeros(scaled);
        Self {
            gyroscopic,
            paired: gyroscopic || scaled.structure == Structure::Circulatory,
            definite: gyroscopic && scaled.zero.is_empty() && is_positive_definite(&scaled.stiffness),
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

/// The first zero vector that is certainly not in the kernel of S, is not shown to be independent of those before
/// it, or has the wrong length.
fn bad_zero_vector(scaled: &Scaled) -> Option<usize> {
    let n = scaled.n;
    let mut basis: Vec<(usize, Vec<Ball>)> = Vec::new();
    for (index, vector) in scaled.zero.iter().enumerate() {
        if vector.len() != n || vector.iter().any(|x| !x.is_finite()) {
            return Some(index);
        }
        let outside = (0..n).any(|i| {
            let image = (0..n).fold(Ball::ZERO, |sum, k| sum + scaled.stiffness.ball(i, k) * vector[k]);
            !image.contains_zero()
        });
        // Elimination by those before; what is left has a component that is not 0.
        let mut rest = vector.clone();
        for (at, row) in &basis {
            let factor = rest[*at] / row[*at];
            for (x, y) in rest.iter_mut().zip(row) {
                *x = *x - factor * *y;
            }
            rest[*at] = Ball::ZERO;
        }
        let pivot = (0..n).max_by(|&a, &b| rest[a].abs_lower().total_cmp(&rest[b].abs_lower()));
        match pivot {
            Some(at) if !outside && !rest[at].contains_zero() => basis.push((at, rest)),
            _ => return Some(index),
        }
    }
    None
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
    let n = scaled.n;
    let is_head = |v: &Vec<Ball>| {
        let image = |i: usize| (0..n).fold(Ball::ZERO, |sum, k| sum + scaled.velocity.ball(i, k) * v[k]);
        let image: Vec<Ball> = (0..n).map(image).collect();
        if matches!(scaled.structure, Structure::Circulatory | Structure::Damped) {
            return image.iter().all(Ball::is_zero);
        }
        scaled.zero.iter().all(|other| {
            let parts = other.iter().zip(&image);
            parts.fold(Ball::ZERO, |sum, (a, b)| sum + *a * *b).is_zero()
        })
    };
    let heads: Vec<usize> = (0..z).filter(|at| is_head(&scaled.zero[*at])).collect();
    if scaled.structure != Structure::Gyroscopic {
        return (z + heads.len(), heads);
    }
    let rank = (z - heads.len()) & !1;
    let least = 2 * z - rank;
    (least + (least & 1), heads)
}
