//! The last precision level: as many bits as it takes, for the columns that need them.
//!
//! A radius is quadratic in the residuals of its column, so that D digits need vectors of D / 2 digits and only
//! the residual of the column at full precision, for the vectors exactly as they stand; its couplings to all others
//! are products in doubles of residuals that are small. The steps of the vectors are those of double-double
//! (the resolvent in doubles), each good for some ten digits.

use super::scale::Scaled;
use super::solve::{Round, Rounds, Solution, closed};
use super::wide_columns::{Matrices, Rows, WideColumns, half};
use super::{Options, PrecisionLevel, QuadraticProblem, QuadraticSource};

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
    let parts = lacking.map(|j| solution.columns.base.mu(j)).flat_map(|mu| [mu.re.mid.hi.abs(), mu.im.mid.hi.abs()]);
    let least = parts.filter(|part| *part > 1e-25).fold(1.0, f64::min);
    let bits = ((digits + 3.0) * 3.33 - least.log2() + 64.0).max(160.0) as usize;
    let mut bits = bits.min(MOST_BITS);
    let Some(mut matrices) = Matrices::new(scaled, problem, source, bits) else {
        return Some(solution);
    };
    let count: usize = matrices.right.iter().map(Rows::count).sum();
    let base = &solution.columns.base;
    let mut columns = WideColumns { base: base.clone(), wide: vec![None; base.count()], bits: half(bits) };
    let lacking: Vec<usize> = (0..base.count()).filter(|&j| solution.statuses[j].lacking).collect();
    columns.widen(&closed(&solution.certificate, base, &lacking));
    let facts = &solution.facts.clone();
    let mut measured = solution.measured.clone();
    // Whatever has more bits is better.
    let mut rounds = Rounds { scaled, facts, options, best: Some((f64::INFINITY, solution)) };
    let mut stalled = 0;
    for _ in 0..ROUNDS {
        let taking = columns.wide.iter().flatten().count();
        if (count * taking) as f64 * (bits as f64 / 64.0 + 1.0) > MOST_WORK {
            break;
        }
        columns.measure(&matrices, &mut measured);
        let Some(Round { gained, lacking, groups, better }) =
            rounds.round(columns, measured.clone(), PrecisionLevel::Precise)
        else {
            break;
        };
        if !lacking.iter().any(|&j| j >= better.base.together()) {
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
