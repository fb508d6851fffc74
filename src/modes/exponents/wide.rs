//! The last rung: as many bits as it takes, for the columns that need them.
//!
//! A radius is quadratic in the residuals of its column, so that D digits need vectors of D / 2 digits and only
//! the residual of the column at full precision, for the vectors exactly as they stand; its couplings to all others
//! are products in doubles of residuals that are small. The steps of the vectors are those of double-double
//! (the resolvent in doubles), each good for some ten digits.

use faer::c64;

use super::certify::{Certificate, certify};
use super::columns::{Columns, steps};
use super::complex::{Complex, Wide};
use super::couplings::{Approximate, Couplings, Sheet};
use super::resolve::{Turn, members, turn};
use super::scale::Scaled;
use super::solve::Solution;
use super::spectrum::{Status, Value, status};
use super::{Options, PreciseQuadratic, QuadraticProblem, QuadraticSource, Rung};
use crate::precision::{Big, DoubleDouble, Magnitude};

/// The most bits that are worked with: bounds are doubles.
const MOST_BITS: usize = 900;
/// Rounds, rises of precision included.
const ROUNDS: usize = 60;
/// Products for a round that are still worth starting: some seconds.
const MOST_WORK: f64 = 3e8;

/// Larger groups have their entries of Q from doubles.
const MOST_TOGETHER: usize = 16;

/// A matrix of numbers of many bits: the entries that are not 0, row by row.
struct Rows(Vec<Vec<(usize, Big)>>);

impl Rows {
    fn new(n: usize, entry: impl Fn(usize, usize) -> Big) -> Self {
        let row = |i: usize| {
            (0..n)
                .map(|j| (j, entry(i, j)))
                .filter(|(_, x)| !x.is_zero())
                .collect()
        };
        Self((0..n).map(row).collect())
    }

    fn times(&self, x: &[Wide], bits: usize) -> Vec<Wide> {
        self.0
            .iter()
            .map(|row| {
                let zero = Wide::zero(bits);
                row.iter()
                    .fold(zero, |sum, (j, entry)| sum.add(&x[*j].times(entry)))
            })
            .collect()
    }

    fn count(&self) -> usize {
        self.0.iter().map(Vec::len).sum()
    }
}

/// The scaled matrices and the transposes that left vectors need.
struct Matrices {
    bits: usize,
    right: [Rows; 3],
    left: [Rows; 3],
}

impl Matrices {
    fn new(
        scaled: &Scaled,
        problem: &QuadraticProblem,
        source: &dyn QuadraticSource,
        bits: usize,
    ) -> Option<Self> {
        let n = scaled.n;
        let precise = source.precisely(bits).or_else(|| as_it_is(problem, bits))?;
        let square = n * n;
        let whole = [&precise.mass, &precise.velocity, &precise.stiffness];
        if whole
            .iter()
            .any(|m| m.len() != square || m.iter().any(|x| !x.is_finite()))
        {
            return None;
        }
        let entry = |k: usize, row: usize, column: usize| {
            let by = scaled.shift[row] + scaled.shift[column] - k as i32 * scaled.power;
            let x: &Big = &whole[k][column * n + row];
            x.scale(i64::from(by)).with_bits(bits)
        };
        let right = [0, 1, 2].map(|k| Rows::new(n, |i, j| entry(k, i, j)));
        let left = [0, 1, 2].map(|k| Rows::new(n, |i, j| entry(k, j, i)));
        Some(Self { bits, right, left })
    }
}

/// Enclosures without radius are the matrices to any precision.
fn as_it_is(problem: &QuadraticProblem, bits: usize) -> Option<PreciseQuadratic> {
    let wide = |entries: &[crate::precision::Ball]| -> Option<Vec<Big>> {
        entries
            .iter()
            .map(|x| x.is_exact().then(|| Big::from_ball(x, bits)))
            .collect()
    };
    Some(PreciseQuadratic {
        mass: wide(&problem.mass)?,
        velocity: wide(&problem.velocity)?,
        stiffness: wide(&problem.stiffness)?,
        zero_vectors: Vec::new(),
    })
}

/// A column of many bits; its parts are exact numbers.
#[derive(Clone)]
pub(super) struct WideColumn {
    pub(super) mu: Wide,
    x: Vec<Wide>,
    y: Vec<Wide>,
    /// M x and D x, as they were measured.
    image: Vec<Wide>,
    slope: Vec<Wide>,
}

impl WideColumn {
    fn new(mu: Wide, x: Vec<Wide>, y: Vec<Wide>) -> Self {
        Self {
            mu,
            x,
            y,
            image: Vec::new(),
            slope: Vec::new(),
        }
    }

    fn conj(&self) -> Self {
        let conj = |v: &[Wide]| v.iter().map(Wide::conj).collect();
        Self {
            mu: self.mu.conj(),
            x: conj(&self.x),
            y: conj(&self.y),
            image: conj(&self.image),
            slope: conj(&self.slope),
        }
    }

    /// Q_ij = y_iᵀ ((μ_i + μ_j) M + D) x_j.
    fn unit(&self, other: &Self) -> Approximate {
        let sum = self.mu.add(&other.mu);
        let parts = other.image.iter().zip(&other.slope);
        let entry = self
            .y
            .iter()
            .zip(parts)
            .fold(Wide::zero(64), |total, (y, (u, v))| {
                total.add(&y.mul(&sum.mul(u).add(v)))
            });
        approximate(&entry)
    }
}

/// Columns of double-double, some of them replaced by better ones.
pub(super) struct WideColumns {
    pub(super) base: Columns,
    pub(super) wide: Vec<Option<WideColumn>>,
    pub(super) bits: usize,
}

impl WideColumns {
    /// The exponent with this radius.
    pub(super) fn value(&self, j: usize, radius: f64) -> Value {
        let source = self.base.twin[j].unwrap_or(j);
        let Some(column) = &self.wide[source] else {
            return self.base.value(j, radius);
        };
        let error = Magnitude::from_f64(radius);
        let part = |x: &Big| x.clone().with_added_radius(error);
        let im = if source == j {
            part(&column.mu.im)
        } else {
            -&part(&column.mu.im)
        };
        Value::wide(part(&column.mu.re), im)
    }

    fn get(&self, j: usize) -> Option<WideColumn> {
        match self.base.twin[j] {
            Some(i) => self.wide[i].as_ref().map(WideColumn::conj),
            None => self.wide[j].clone(),
        }
    }

    /// The entries of Q between members of a group.
    fn units(&self, certificate: &Certificate) -> Vec<(usize, usize, Approximate)> {
        let mut known = Vec::new();
        for group in &certificate.groups {
            let members = group.members.iter();
            let columns: Vec<(usize, WideColumn)> =
                members.filter_map(|&j| Some((j, self.get(j)?))).collect();
            if group.members.len() < 2 || columns.len() > MOST_TOGETHER {
                continue;
            }
            for (i, a) in &columns {
                known.extend(columns.iter().map(|(j, b)| (*i, *j, a.unit(b))));
            }
        }
        known
    }

    fn mu(&self, j: usize) -> Option<Wide> {
        match self.base.twin[j] {
            Some(i) => self.wide[i].as_ref().map(|column| column.mu.conj()),
            None => self.wide[j].as_ref().map(|column| column.mu.clone()),
        }
    }

    /// μ_i - μ_j, nearly.
    fn difference(&self, i: usize, j: usize) -> c64 {
        match (self.mu(i), self.mu(j)) {
            (Some(a), Some(b)) => a.sub(&b).to_c64(),
            _ => self.base.mu[i].sub(self.base.mu[j]).to_c64(),
        }
    }

    /// Columns join at the precision that is in use.
    fn widen(&mut self, which: &[usize]) {
        for &j in which {
            if self.base.twin[j].is_none() && j >= self.base.together() && self.wide[j].is_none() {
                let wide = |v: &[Complex]| {
                    v.iter()
                        .map(|x| Wide::from_complex(*x, self.bits))
                        .collect()
                };
                let mu = Wide::from_complex(self.base.mu[j], self.bits);
                let (x, y) = (wide(&self.base.x[j]), wide(&self.base.y[j]));
                self.wide[j] = Some(WideColumn::new(mu, x, y));
            }
        }
    }
}

/// Bits of vectors for matrices of so many.
fn half(bits: usize) -> usize {
    bits / 2 + 64
}

fn approximate(x: &Wide) -> Approximate {
    let value = x.to_c64();
    let size = value.re.hypot(value.im);
    Approximate {
        value,
        error: x.radius() + size * 2f64.powi(-50) + 1e-300,
    }
}

fn sheet(matrices: &Matrices, column: &mut WideColumn) -> Sheet {
    let bits = matrices.bits;
    let real = column.mu.im.is_zero();
    let of_x = matrices.right.each_ref().map(|a| a.times(&column.x, bits));
    let of_y = matrices.left.each_ref().map(|a| a.times(&column.y, bits));
    let quadratic = |mu: &Wide, parts: &[Vec<Wide>]| -> Vec<Wide> {
        (0..parts[0].len())
            .map(|i| {
                let inner = mu.mul(&parts[0][i]).add(&parts[1][i]);
                inner.mul(mu).add(&parts[2][i])
            })
            .collect()
    };
    let mut mu = column.mu.clone().with_bits(bits);
    let mut residual = quadratic(&mu, &of_x);
    let against = |residual: &[Wide]| {
        column
            .y
            .iter()
            .zip(residual)
            .fold(Wide::zero(bits), |sum, (y, r)| sum.add(&y.mul(r)))
    };
    for _ in 0..2 {
        let over = against(&residual);
        let mut under = Wide::zero(64);
        for (i, y) in column.y.iter().enumerate() {
            let slope = mu.mul(&of_x[0][i]);
            let slope = slope.add(&slope).add(&of_x[1][i]);
            under = under.add(&y.mul(&slope));
        }
        let step = over.div(&under);
        if !step.is_finite() {
            break;
        }
        mu = mu.sub(&step).center(bits);
        if real {
            mu.im = Big::zero(bits);
        }
        residual = quadratic(&mu, &of_x);
    }
    let defect = against(&residual).abs_upper();
    let left = quadratic(&mu, &of_y);
    let all = |v: &[Wide]| v.iter().map(approximate).collect::<Vec<_>>();
    let rest: Vec<Wide> = of_x[1]
        .iter()
        .zip(&of_x[0])
        .map(|(v, u)| v.add(&mu.mul(u)))
        .collect();
    let turned: Vec<Wide> = column.y.iter().map(|y| mu.mul(y)).collect();
    let sheet = Sheet {
        x: all(&column.x),
        y: all(&column.y),
        residual: all(&residual),
        left: all(&left),
        image: all(&of_x[0]),
        rest: all(&rest),
        turned: all(&turned),
        defect,
    };
    column.mu = mu;
    let [image, slope, _] = of_x;
    column.image = image;
    column.slope = slope;
    sheet
}

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
            let mu = solution.columns.base.mu[j];
            for part in [mu.re.hi.abs(), mu.im.hi.abs()] {
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
    let mut columns = WideColumns {
        base: best.columns.base.clone(),
        wide: vec![None; best.columns.base.count()],
        bits: half(bits),
    };
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
                sheets[j] = sheet(&matrices, column);
                columns.base.mu[j] = column.mu.to_complex();
            }
        }
        for j in 0..columns.base.count() {
            if let Some(i) = columns.base.twin[j]
                && columns.wide[i].is_some()
            {
                sheets[j] = sheets[i].conj();
                columns.base.mu[j] = columns.base.mu[i].conj();
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
        let statuses = status(&best.facts, &columns.base, &value, &certificate, options);
        let now: f64 = statuses.iter().map(|status| status.score).sum();
        let lacking = self::lacking(&statuses);
        stalled = if now < score - 4.0 { 0 } else { stalled + 1 };
        let next = better(&couplings, &columns, &sheets, &certificate, &lacking);
        let more = closed(&certificate, &columns.base, &lacking);
        let open = lacking.iter().any(|&j| j >= columns.base.together());
        if now <= score {
            score = now;
            let kept = WideColumns {
                base: columns.base.clone(),
                wide: columns.wide.clone(),
                bits: columns.bits,
            };
            best = Solution {
                columns: kept,
                sheets,
                couplings,
                certificate,
                facts: best.facts,
                statuses,
                rung: Rung::Precise,
            };
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
    (0..statuses.len())
        .filter(|&j| statuses[j].lacking)
        .collect()
}

/// The given columns, all of their groups, and those that they are conjugates of.
fn closed(certificate: &Certificate, columns: &Columns, which: &[usize]) -> Vec<usize> {
    let mut all: Vec<usize> = which
        .iter()
        .flat_map(|&j| {
            certificate.groups[certificate.of[j]]
                .members
                .iter()
                .copied()
        })
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
    let mut next = WideColumns {
        base: base.clone(),
        wide: columns.wide.clone(),
        bits: columns.bits,
    };
    let mut turned = vec![false; base.count()];
    for group in &certificate.groups {
        if group.members.len() < 2 || !group.members.iter().any(|j| lacking.contains(j)) {
            continue;
        }
        let Some(members) = members(&group.members, &base.twin, base.together()) else {
            continue;
        };
        let wide = |j: usize| columns.mu(j).is_some();
        if members.len() < 2 || members.iter().any(|&j| turned[j] || !wide(j)) {
            continue;
        }
        let own = |j: usize| {
            base.twin[j].is_some_and(|i| members.contains(&i))
                || (0..base.count()).any(|k| base.twin[k] == Some(j) && members.contains(&k))
        };
        let real = members
            .iter()
            .any(|&j| own(j) || base.twin[j].is_none() && !base.twin.contains(&Some(j)));
        let Some(centre) = centre(columns, &members, real) else {
            continue;
        };
        let shift = |j: usize| {
            columns
                .mu(j)
                .map_or(c64::new(f64::NAN, 0.0), |mu| mu.sub(&centre).to_c64())
        };
        if let Some(turn) = turn(couplings, members.clone(), &base.twin, shift) {
            turn.members.iter().for_each(|&j| turned[j] = true);
            apply(columns, &mut next, &turn, &centre);
        }
    }
    for &j in lacking {
        let Some(column) = &columns.wide[j] else {
            continue;
        };
        if turned[j] {
            continue;
        }
        let difference = |i: usize| columns.difference(j, i);
        let same = |i: usize| certificate.of[i] == certificate.of[j];
        let (dx, dy) = steps(couplings, base, sheets, j, difference, same);
        let real = column.mu.im.is_zero();
        let bits = columns.bits;
        let by = c64::new(1.0, 0.0) / couplings.unit.get(j, j);
        let by = Wide::from_c64(by, bits);
        let part = |d: c64| Wide::from_c64(if real { c64::new(d.re, 0.0) } else { d }, bits);
        let x: Vec<Wide> = column
            .x
            .iter()
            .zip(dx)
            .map(|(x, d)| x.add(&part(d)).center(bits))
            .collect();
        let y: Vec<Wide> = column
            .y
            .iter()
            .zip(dy)
            .map(|(y, d)| {
                let mut y = y.add(&part(d)).mul(&by).center(bits);
                if real {
                    y.im = Big::zero(bits);
                }
                y
            })
            .collect();
        if x.iter().chain(&y).all(Wide::is_finite) {
            next.wide[j] = Some(WideColumn::new(column.mu.clone(), x, y));
        }
    }
    next
}

fn centre(columns: &WideColumns, members: &[usize], real: bool) -> Option<Wide> {
    let bits = 2 * columns.bits;
    let mut sum = Wide::zero(bits);
    for &j in members {
        sum = sum.add(&columns.mu(j)?);
    }
    let by = &Big::one(bits) / &Big::from_f64(members.len() as f64, bits);
    let mut mean = sum.times(&by).center(bits);
    if real {
        mean.im = Big::zero(bits);
    }
    Some(mean)
}

/// Puts the turned columns in the place of the members.
fn apply(from: &WideColumns, to: &mut WideColumns, turn: &Turn, centre: &Wide) {
    let bits = from.bits;
    let Some(old): Option<Vec<WideColumn>> = turn.members.iter().map(|&j| from.get(j)).collect()
    else {
        return;
    };
    let k = turn.members.len();
    let n = old.first().map_or(0, |column| column.x.len());
    let length = |v: &[Wide]| {
        v.iter()
            .map(|x| {
                let x = x.to_c64();
                x.re * x.re + x.im * x.im
            })
            .sum::<f64>()
            .sqrt()
    };
    let mut new = Vec::with_capacity(k);
    for a in 0..k {
        let combine = |part: &dyn Fn(&WideColumn) -> &Vec<Wide>, weight: &dyn Fn(usize) -> c64| {
            let mut sum = vec![Wide::zero(bits); n];
            for (c, column) in old.iter().enumerate() {
                let by = Wide::from_c64(weight(c), bits);
                for (sum, x) in sum.iter_mut().zip(part(column)) {
                    *sum = sum.add(&by.mul(x)).center(bits);
                }
            }
            sum
        };
        let x = combine(&|column| &column.x, &|c| turn.right[(c, a)]);
        let y = combine(&|column| &column.y, &|c| turn.left[(a, c)]);
        let by = length(&old[a].x) / length(&x);
        if !(by.is_finite() && by > 0.0) {
            return;
        }
        let real = turn.twin[a].is_none()
            && turn.steps[a].im == 0.0
            && centre.im.is_zero()
            && !turn.twin.contains(&Some(a));
        let scale = |v: Vec<Wide>, by: f64| -> Vec<Wide> {
            let by = Big::from_f64(by, bits);
            v.iter()
                .map(|x| {
                    let mut x = x.times(&by).center(bits);
                    if real {
                        x.im = Big::zero(bits);
                    }
                    x
                })
                .collect()
        };
        let mu = centre.add(&Wide::from_c64(turn.steps[a], 2 * bits));
        let column = WideColumn::new(mu, scale(x, by), scale(y, 1.0 / by));
        if !(column.mu.is_finite() && column.x.iter().chain(&column.y).all(Wide::is_finite)) {
            return;
        }
        new.push((column, real));
    }
    let paired = turn.twin.iter().any(Option::is_some);
    for (a, (column, real)) in new.into_iter().enumerate() {
        let j = turn.members[a];
        if paired || to.base.twin[j].is_some() || real {
            to.base.twin[j] = turn.twin[a].map(|b| turn.members[b]);
        }
        to.base.mu[j] = Complex {
            re: column.mu.re.to_ball().mid,
            im: if real {
                DoubleDouble::ZERO
            } else {
                column.mu.im.to_ball().mid
            },
        };
        to.base.x[j] = column.x.iter().map(Wide::to_complex).collect();
        to.base.y[j] = column.y.iter().map(Wide::to_complex).collect();
        to.wide[j] = if to.base.twin[j].is_some() {
            None
        } else {
            Some(column)
        };
    }
}
