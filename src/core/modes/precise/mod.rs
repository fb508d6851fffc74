//! The last precision level: as many bits as it takes.
//!
//! The certificate makes an eigenvalue's radius quadratic in the couplings of its column, so that D
//! digits need columns of D / 2 digits, couplings in doubles, and only the quotients themselves at
//! full precision, for the columns exactly as they stand. Columns come from double-double, or from a
//! Cholesky factor of M at full precision where double-double has none; they are measured
//! (`measure`), certified, and improved (`improve`) until every wanted digit is covered. Only columns
//! that need it take part; all others stay in double-double.

mod data;
mod fixed;
mod improve;
mod measure;
mod plan;

use dashu_int::IBig;
use dashu_int::ops::BitTest;
use faer::Mat;

use super::certify::{Cluster, Couplings, Enclosures, certify};
use super::dense::Matrix;
use super::pencil::{Enclosed, Scaled, ZeroSpace, couplings, pencil};
use super::start::careful_eigenvectors;
use super::{Certificate, Gram, ModesError, Options, PrecisionLevel, Solution, Source, covered, refined};
use crate::order::Order;
use crate::precision::{Ball, Big, Magnitude};
use data::Data;
use fixed::{LOST, Symmetric};
use measure::{Background, Columns, Measured, measure};
use plan::{Goal, Plan};

/// Eigenvalues that are equal to so many digits count as equal: most of those that are near are.
const CLOSE_DIGITS: usize = 120;
/// Beyond so many coordinates that is not tried: equal ones, as symmetry makes them, would cost too much.
const MOST_TOLD_APART: usize = 16;
/// More digits than double-double has for sure, where its bounds grow with the number of coordinates.
const MANY: usize = 22;
/// Fewer modes than this part of all are better taken on from what doubles give.
const FEW: usize = 8;

/// A problem that is solved with as many bits as it takes.
#[derive(Clone, Copy)]
pub(super) struct Precisely<'a> {
    pub(super) scaled: &'a Scaled,
    pub(super) zero: &'a ZeroSpace,
    pub(super) source: &'a dyn Source,
}

impl Precisely<'_> {
    /// The outcome of the precision levels below, or a better one where digits are missing or there is none.
    fn covering(self, options: &Options) -> Result<Solution, ModesError> {
        let below = |options: &Options| refined(self.scaled, self.zero, options);
        let few = options.lowest.is_some_and(|wanted| FEW * wanted <= self.scaled.n);
        if few
            && options.digits >= MANY
            && let Ok(solution) = below(&options.clone().digits(15))
            && let Some(better) = self.with_more_bits(Some(&solution), options)
            && verdict(&better, options, &Goal::new(options.digits)).satisfied
        {
            return Ok(better);
        }
        match below(options) {
            Ok(solution) if covered(&solution.certificate, options) => Ok(solution),
            Ok(solution) => Ok(self.with_more_bits(Some(&solution), options).unwrap_or(solution)),
            Err(error) if is_final(&error) => Err(error),
            Err(error) => self.with_more_bits(None, options).ok_or(error),
        }
    }

    /// That outcome, with close eigenvalues told apart where more digits do it: their shapes are then facts, and no choice.
    pub(super) fn further(self, options: &Options) -> Result<Solution, ModesError> {
        let solution = self.covering(options)?;
        let clusters = &solution.certificate.clusters;
        let wanted = options.lowest.unwrap_or(usize::MAX);
        let close = |cluster: &Cluster| cluster.len() > 1 && cluster.start < wanted;
        if !options.vectors || self.scaled.n > MOST_TOLD_APART || !clusters.iter().any(close) {
            return Ok(solution);
        }
        let finer = options.clone().digits(options.digits.max(CLOSE_DIGITS));
        let apart = self.with_more_bits(Some(&solution), &finer);
        Ok(apart.filter(|apart| apart.certificate.clusters.len() > clusters.len()).unwrap_or(solution))
    }
}

/// Whether more precision changes nothing.
fn is_final(error: &ModesError) -> bool {
    match error {
        ModesError::NotPositiveDefinite { singular, .. } => !singular,
        ModesError::MassNotDecided | ModesError::NoConvergence => false,
        ModesError::NotFinite { .. } | ModesError::Shape { .. } | ModesError::ZeroVector { .. } => true,
    }
}

/// The most bits of an entry that are worked with: one unit is still a double.
const MOST_BITS: i64 = 1000;
/// Products of machine words for a round that are still worth starting: minutes.
const MOST_WORK: f64 = 2e11;
/// The same for a Cholesky factor, which fails where M is singular: seconds.
const MOST_START: f64 = 4e9;
/// Rounds of improvement, start and rises of precision included.
const ROUNDS: usize = 48;
/// Rounds without gain until nothing more is expected: close columns take some to become orthogonal
/// before it shows in the bounds.
const STALLED: usize = 4;
/// Rounds without gain until columns in double-double are no longer good enough beside the others.
const WIDENED: usize = 2;
/// Bits more than planned, so that a plan that grows a little needs no new matrices.
const HEADROOM: i64 = 32;

impl Precisely<'_> {
    /// A better solution than the one in double-double, if there is one.
    fn with_more_bits(self, solved: Option<&Solution>, options: &Options) -> Option<Solution> {
        let Self { scaled, zero, source } = self;
        let mut goal = Goal::new(options.digits);
        let mut matrices = Matrices { scaled, source, data: None };
        let total = scaled.n - zero.mid.columns;
        let (mut columns, mut background) = match solved {
            Some(solution) => {
                let mut own = lacking(&solution.certificate, options);
                let mut estimates = estimates(&solution.certificate);
                let mut background = None;
                if own.len() < total {
                    let some = Background::new(scaled, zero, solution)?;
                    own = some.lacking(options);
                    estimates = some.couplings.clone();
                    background = Some(some);
                }
                goal.largest = largest(&estimates);
                // Rows of the scaled matrices are seldom much larger than their diagonal.
                let plan = Plan::new(&estimates, &solution.x, &own, &goal, (4.0, 4.0));
                let scale = plan.columns.max(112);
                matrices.at_least(plan.matrices)?;
                let x = own.iter().map(|&j| column(&solution.x, j, scale)).collect();
                (Columns { scale, own, x }, background)
            }
            None => (begin(&mut matrices)?, None),
        };
        let mut best: Option<(f64, Solution)> = None;
        let mut stalled = 0;
        for _ in 0..ROUNDS {
            if columns.own.len() == total {
                background = None;
            }
            let Some(data) = &matrices.data else { break };
            if work(data, &columns) > MOST_WORK {
                break;
            }
            let Some(measured) = measure(data, &columns, background.as_ref(), &goal) else { break };
            goal.largest = largest(&measured.couplings);
            let mut more = Vec::new();
            if let Some(enclosures) = certify(&measured.couplings) {
                let background = background.as_ref();
                let solution = assemble(data, &columns, &measured, enclosures, solved, background);
                let verdict = verdict(&solution, options, &goal);
                let gained = best.as_ref().is_none_or(|(before, _)| verdict.score < before - 4.0);
                if best.as_ref().is_none_or(|(before, _)| verdict.score <= *before) {
                    best = Some((verdict.score, solution));
                }
                if verdict.satisfied {
                    break;
                }
                stalled = if gained { 0 } else { stalled + 1 };
                if !(stalled < WIDENED || verdict.met || background.is_none()) {
                    more = (0..total).collect();
                } else if stalled >= STALLED || verdict.met {
                    // Nothing gained: a sign or a rounding is left to decide, or it is beyond reach.
                    if !goal.raise(verdict.signs, verdict.roundings) {
                        break;
                    }
                    stalled = 0;
                }
            } else if background.is_some() {
                more = (0..total).collect();
            }
            let norms = (data.stiffness.norm, data.mass.norm);
            let plan = Plan::new(&measured.couplings, &measured.x, &columns.own, &goal, norms);
            let scale = plan.columns.max(columns.scale);
            if more.is_empty() {
                match improve::improve(data, &columns, &measured, scale) {
                    Ok(better) => columns = better,
                    Err(mixed) => more = mixed,
                }
            }
            if !more.is_empty() {
                let Some(background) = &background else { break };
                columns = widened(&columns, more, &background.x);
                // Scores of different columns do not compare.
                best = best.map(|(_, solution)| (f64::INFINITY, solution));
                stalled = 0;
            }
            if matrices.at_least(plan.matrices).is_none() {
                break;
            }
        }
        best.map(|(_, solution)| solution)
    }
}

/// The matrices at the precision that has been needed so far.
struct Matrices<'a> {
    scaled: &'a Scaled,
    source: &'a dyn Source,
    data: Option<Data>,
}

impl Matrices<'_> {
    /// Makes sure that entries have so many bits; `None` if they can't be had.
    fn at_least(&mut self, bits: i64) -> Option<()> {
        let bits = bits.min(MOST_BITS);
        if self.data.as_ref().is_some_and(|data| data.scale >= bits) {
            return Some(());
        }
        // By half at least, so that all steps together cost little more than the last one.
        let before = self.data.as_ref().map_or(0, |data| data.scale);
        let scale = (bits + HEADROOM).max(before + before / 2).min(MOST_BITS);
        // The largest entries are below 4.
        let problem = self.source.precisely(usize::try_from(scale + 4).ok()?)?;
        let (shift, power) = (&self.scaled.shift, self.scaled.power);
        self.data = Some(Data::new(&problem, shift, power, scale)?);
        Some(())
    }
}

/// A basis from the Cholesky factor of M, at the precision that it takes.
fn begin(matrices: &mut Matrices<'_>) -> Option<Columns> {
    let mut bits = 256;
    while bits < MOST_BITS {
        matrices.at_least(bits)?;
        let data = matrices.data.as_ref()?;
        let words = (bits / 64) as f64;
        if (data.n as f64).powi(3) * words * words > MOST_START {
            return None;
        }
        if let Some(columns) = start(data) {
            return Some(columns);
        }
        bits *= 2;
    }
    None
}

/// Eigenvectors in doubles beyond that factor; `None` if M has none at this precision. A pivot has to keep half of the bits:
/// what is below that is not told from 0.
fn start(data: &Data) -> Option<Columns> {
    let (p, bits) = (data.scale, usize::try_from(data.scale).ok()?);
    let entries = |matrix: &'_ Symmetric, i: usize, j: usize| Big::from_parts(matrix.entry(i, j), -p, bits);
    let mass = |i: usize, j: usize| entries(&data.mass, i, j);
    let stiffness = |i: usize, j: usize| entries(&data.stiffness, i, j);
    let zero = &data.zero.vectors;
    let zero = Mat::from_fn(data.n, zero.len(), |i, j| fixed::double(&zero[j][i], -p));
    let found = careful_eigenvectors(&mass, &stiffness, &zero, (-0.5 * p as f64).exp2(), bits).ok()?;
    let entry = |x: &Big| Some(fixed::unit(x, 0, p)?.0);
    let x = found.iter().map(|column| column.iter().map(entry).collect()).collect::<Option<Vec<Vec<IBig>>>>()?;
    Some(Columns { scale: p, own: (0..x.len()).collect(), x })
}

fn work(data: &Data, columns: &Columns) -> f64 {
    let entries = data.mass.count() + data.stiffness.count() + data.n;
    let words = |bits: i64| bits as f64 / 64.0 + 1.0;
    entries as f64 * columns.own.len() as f64 * words(data.scale) * words(columns.scale)
}

fn column(x: &Matrix, column: usize, scale: i64) -> Vec<IBig> {
    (0..x.rows).map(|row| fixed::from_double_double(x.get(row, column), scale)).collect()
}

/// The same columns and some of the double-double ones.
fn widened(columns: &Columns, more: Vec<usize>, x: &Matrix) -> Columns {
    let own = columns.own.iter().copied().zip(columns.x.iter().cloned());
    let mut all: Vec<(usize, Vec<IBig>)> = own.collect();
    let more = more.into_iter().filter(|j| !columns.own.contains(j));
    all.extend(more.map(|j| (j, column(x, j, columns.scale))));
    all.order_by_key(|(j, _)| *j);
    let (own, x) = all.into_iter().unzip();
    Columns { scale: columns.scale, own, x }
}

impl Background {
    fn new(scaled: &Scaled, zero: &ZeroSpace, solution: &Solution) -> Option<Self> {
        let x = solution.x.clone();
        if let Gram::Factors(round) = &solution.gram {
            // Midpoints beside the diagonal are used without bounds, and nearly 0.
            let g = Enclosed::new(x.columns, |i, j| if i == j { round.norm[i] } else { Ball::ZERO });
            let (quotients, couplings, leak) = (round.quotient.clone(), round.couplings(), round.leak.clone());
            return Some(Self { x, quotients, couplings, leak, g });
        }
        let pencil = pencil(scaled, zero, &x);
        let (quotients, couplings) = couplings(&pencil)?;
        Some(Self { x, quotients, couplings, leak: pencil.leak, g: pencil.g })
    }

    /// [`lacking`] by what double-double shows; all columns where it shows nothing.
    fn lacking(&self, options: &Options) -> Vec<usize> {
        let certificate = Certificate::new(&self.quotients, self.couplings.clone());
        certificate.map_or_else(|| (0..self.quotients.len()).collect(), |own| lacking(&own, options))
    }
}

/// The columns of all clusters with a wanted mode that lacks digits.
fn lacking(certificate: &Certificate, options: &Options) -> Vec<usize> {
    let Certificate { order, eigenvalues, clusters } = certificate;
    let wanted = options.lowest.unwrap_or(usize::MAX);
    let lacks = |position: usize| !options.covers(&eigenvalues[position], true);
    let lacking = clusters.iter().filter(|cluster| (cluster.start..cluster.end.min(wanted)).any(lacks));
    let mut own: Vec<usize> = lacking.flat_map(|cluster| &order[cluster.start..cluster.end]).copied().collect();
    own.sort_unstable();
    own
}

/// Sizes and distances of eigenvalues, for a first plan.
fn estimates(certificate: &Certificate) -> Couplings {
    let values = &certificate.eigenvalues;
    let mut couplings = Couplings::zeros(values.len());
    couplings.order = certificate.order.clone();
    let steps = values.windows(2);
    couplings.steps = steps.map(|pair| (pair[1].mid - pair[0].mid).hi.max(0.0)).collect();
    for (&column, value) in certificate.order.iter().zip(values) {
        couplings.size[column] = value.abs_upper();
    }
    couplings
}

fn largest(couplings: &Couplings) -> f64 {
    couplings.size.iter().fold(0.0, |most: f64, &x| most.max(x))
}

/// What a round has come to.
struct Verdict {
    /// Every wanted digit is there.
    satisfied: bool,
    /// The radii are as small as was planned, and still something is open.
    met: bool,
    /// Signs are open, or digits of what was too small so far.
    signs: bool,
    /// Roundings are open.
    roundings: bool,
    /// The bits of all radii of wanted modes together.
    score: f64,
}

fn verdict(solution: &Solution, options: &Options, goal: &Goal) -> Verdict {
    let wanted = options.lowest.unwrap_or(usize::MAX);
    let mut result = Verdict { satisfied: true, met: true, signs: false, roundings: false, score: 0.0 };
    let values = solution.certificate.eigenvalues.iter();
    for (ball, precise) in values.zip(&solution.precise).take(wanted) {
        let (size, radius, covered) = match precise {
            Some(value) => (value.abs_upper().to_f64(), value.radius().log2(), options.covers(value, true)),
            None => (ball.abs_upper(), ball.radius.log2(), options.covers(ball, true)),
        };
        // Beyond what is aimed at nothing is gained.
        let target = goal.target(size).log2();
        result.score += radius.max(target);
        if !covered {
            let small = ball.contains_zero() || size < goal.floor();
            result.signs |= small;
            result.roundings |= !small;
            result.satisfied = false;
            result.met &= radius <= target;
        }
    }
    result
}

/// The outcome in the form that double-double has, the precise values beside it.
fn assemble(
    data: &Data,
    columns: &Columns,
    measured: &Measured,
    enclosures: Enclosures,
    solved: Option<&Solution>,
    background: Option<&Background>,
) -> Solution {
    let m = measured.quotient.len();
    let order = measured.couplings.order.clone();
    let own = &measured.own;
    let enclosed = |(position, (&i, &radius)): (usize, (&usize, &f64))| {
        let quotient = &measured.quotient[i];
        let bits = (quotient.bit_len() + 8).max(64);
        let value = Big::from_parts(quotient.clone(), -data.quotient_scale(), bits)
            .with_added_radius(Magnitude::from_f64(radius));
        // Both bounds hold for the same eigenvalue.
        let before = solved.map(|solved| solved.certificate.eigenvalues[position]);
        let sharper = before.filter(|before| before.radius <= value.radius().to_f64());
        sharper.map_or_else(|| (value.to_ball(), own[i].map(|_| value)), |before| (before, None))
    };
    let (eigenvalues, precise) = order.iter().zip(&enclosures.radii).enumerate().map(enclosed).unzip();
    let mut clusters = enclosures.clusters;
    for cluster in &mut clusters {
        // The double-doubles of the columns differ from them by up to 2 u² of themselves.
        let members = order[cluster.start..cluster.end].iter();
        members.filter(|i| own[**i].is_some()).for_each(|i| cluster.reach[*i] = LOST);
    }
    let g = background.map(|background| background.g.clone());
    let Enclosed { mut mid, mut radius, .. } = g.unwrap_or_else(|| Enclosed::new(m, |_, _| Ball::ZERO));
    for (at, &j) in columns.own.iter().enumerate() {
        for i in 0..m {
            mid.set(i, j, measured.g.get(i, at));
            mid.set(j, i, measured.g.get(i, at));
            radius.set_both(i, j, measured.couplings.g.get(i, j));
        }
    }
    for (&j, &(norm, error)) in columns.own.iter().zip(&measured.norm) {
        mid.set(j, j, norm);
        radius.set(j, j, error);
    }
    Solution {
        x: measured.x.clone(),
        gram: Gram::Entries(Enclosed::general(mid, radius)),
        leak: measured.leak.clone(),
        certificate: Certificate { order, eigenvalues, clusters },
        precise,
        level: solved.map_or(PrecisionLevel::Precise, |solved| solved.level),
    }
}
