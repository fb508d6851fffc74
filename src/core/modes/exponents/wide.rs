//! The last rung: as many bits as it takes, for the columns that need them.
//!
//! A radius is quadratic in the residuals of its column, so that D digits need vectors of D / 2 digits and only
//! the residual of the column at full precision, for the vectors exactly as they stand; its couplings to all others
//! are products in doubles of residuals that are small. The steps of the vectors are those of double-double
//! (the resolvent in doubles), each good for some ten digits.

use faer::c64;

use super::certify::{Certificate, certify};
use super::columns::{Columns, center, steps};
use super::complex::Wide;
use super::couplings::{Couplings, Sheet};
use super::resolve::turn;
use super::scale::Scaled;
use super::solve::Solution;
use super::spectrum::{Status, status};
use super::wide_columns::{Matrices, Rows, WideColumn, WideColumns, apply, half};
use super::{Options, QuadraticProblem, QuadraticSource, Rung};

/// The most bits that are worked with: bounds are doubles.
const MOST_BITS: usize = 900;
/// Rounds, rises of precision included.
const ROUNDS: usize = 60;
/// Products for a round that are still worth starting: some seconds.
const MOST_WORK: f64 = 3e8;

/// Better columns in the place of those that lack digits, as far as bits and effort go.
pub(super) fn climb(
    scaled: &Scaled,
    problem: &QuadraticProblem,
    source: &dyn QuadraticSource,
    solution: Solution,
    options: &Options,
) -> Solution {
    let digits = options.digits.min(250) as f64;
    // What the smallest part needs beside the largest exponent, as far as is known by now.
    let mut least = 1.0_f64;
    for (j, status) in solution.statuses.iter().enumerate() {
        if status.lacking {
            let mu = solution.columns.base.mu(j);
            for part in [mu.re.mid.hi.abs(), mu.im.mid.hi.abs()] {
                if part > 1e-25 {
                    least = least.min(part);
                }
            }
        }
    }
    let bits = ((digits + 3.0) * 3.33 - least.log2() + 64.0).max(160.0) as usize;
    let mut bits = bits.min(MOST_BITS);
    let Some(mut matrices) = Matrices::new(scaled, problem, source, bits) else {
        return solution;
    };
    let count: usize = matrices.right.iter().map(Rows::count).sum();
    let mut best = solution;
    let mut columns =
        WideColumns { base: best.columns.base.clone(), wide: vec![None; best.columns.base.count()], bits: half(bits) };
    let lacking = lacking(&best.statuses);
    columns.widen(&closed(&best.certificate, &columns.base, &lacking));
    let mut score = f64::INFINITY;
    let mut stalled = 0;
    for _ in 0..ROUNDS {
        let taking = columns.wide.iter().flatten().count();
        if (count * taking) as f64 * (bits as f64 / 64.0 + 1.0) > MOST_WORK {
            break;
        }
        let mut sheets = best.sheets.clone();
        for (j, column) in columns.wide.iter_mut().enumerate() {
            if let Some(column) = column {
                sheets[j] = column.sheet(&matrices);
                columns.base.all[j].mu = column.own.mu.to_complex();
            }
        }
        for j in 0..columns.base.count() {
            if let Some(i) = columns.base.twin[j]
                && columns.wide[i].is_some()
            {
                sheets[j] = sheets[i].conjugate();
                columns.base.all[j].mu = columns.base.mu(i).conjugate();
            }
        }
        let distance = |i: usize, j: usize| {
            let d = columns.difference(i, j);
            d.re.hypot(d.im)
        };
        let known = columns.units(&best.certificate);
        let links = &columns.base.links;
        let Some(couplings) = Couplings::new(scaled.n, &sheets, links, &known, distance) else {
            break;
        };
        let certificate = certify(&couplings, columns.base.together(), &columns.base.twin);
        let value = |j: usize, radius: f64| columns.value(j, radius);
        let statuses = status(&best.facts, &columns.base, &sheets, &value, &certificate, options);
        let now: f64 = statuses.iter().map(|status| status.score).sum();
        let lacking = self::lacking(&statuses);
        stalled = if now < score - 4.0 { 0 } else { stalled + 1 };
        let next = better(&couplings, &columns, &sheets, &certificate, &lacking);
        let more = closed(&certificate, &columns.base, &lacking);
        let open = lacking.iter().any(|&j| j >= columns.base.together());
        if now <= score {
            score = now;
            let kept = WideColumns { base: columns.base.clone(), wide: columns.wide.clone(), bits: columns.bits };
            best = Solution { columns: kept, sheets, certificate, facts: best.facts, statuses, rung: Rung::Precise };
        }
        if !open {
            break;
        }
        columns = next;
        columns.widen(&more);
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
    best
}

fn lacking(statuses: &[Status]) -> Vec<usize> {
    (0..statuses.len()).filter(|&j| statuses[j].lacking).collect()
}

/// The given columns, all of their groups, and those that they are conjugates of.
fn closed(certificate: &Certificate, columns: &Columns, which: &[usize]) -> Vec<usize> {
    let mut all: Vec<usize> = which
        .iter()
        .flat_map(|&j| certificate.groups[certificate.of[j]].members.iter().copied())
        .flat_map(|j| [j, columns.twin[j].unwrap_or(j)])
        .collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn better(
    couplings: &Couplings,
    columns: &WideColumns,
    sheets: &[Sheet],
    certificate: &Certificate,
    lacking: &[usize],
) -> WideColumns {
    let base = &columns.base;
    let mut next = WideColumns { base: base.clone(), wide: columns.wide.clone(), bits: columns.bits };
    let turned = base.turn_groups(certificate, lacking, &mut |members, real| {
        let exponents: Option<Vec<Wide>> = members.iter().map(|&j| columns.mu(j)).collect();
        let Some(exponents) = exponents else {
            return false;
        };
        let center = center(&exponents, real, 2 * columns.bits);
        let shift = |j: usize| columns.mu(j).map_or(c64::new(f64::NAN, 0.0), |mu| mu.sub(&center).to_c64());
        let turn = turn(couplings, members, &base.twin, shift);
        if let Some(turn) = &turn {
            apply(columns, &mut next, turn, &center);
        }
        turn.is_some()
    });
    for &j in lacking.iter().filter(|&&j| !turned[j]) {
        if let Some(column) = &columns.wide[j] {
            let difference = |i: usize| columns.difference(j, i);
            let same = |i: usize| certificate.of[i] == certificate.of[j];
            let steps = steps(couplings, base, sheets, j, difference, same);
            if let Some(improved) = column.own.improved(steps, couplings.unit.get(j, j), columns.bits) {
                next.wide[j] = Some(WideColumn::new(improved));
            }
        }
    }
    next
}
