//! Columns of many bits: residuals and quotients.

use faer::c64;

use super::certify::Certificate;
use super::columns::{Column, Columns, approximate, center, conjugate, residuals, turned};
use super::complex::{Complex, Wide};
use super::couplings::{Approximate, Couplings, Residuals};
use super::resolve::{Turn, turn};
use super::scale::Scaled;
use super::spectrum::Value;
use super::{PreciseQuadratic, QuadraticProblem, QuadraticSource};
use crate::precision::{Ball, Big, Enclosure, Magnitude};

/// Larger groups have their entries of Q from doubles.
const MOST_TOGETHER: usize = 16;
/// Exponents are close where they differ by less than this part.
const NEAR: f64 = 1e-6;

/// A matrix of numbers of many bits: the entries that are not 0, row by row.
pub(super) struct Rows(Vec<Vec<(usize, Big)>>);

impl Rows {
    fn new(n: usize, entry: impl Fn(usize, usize) -> Big) -> Self {
        let row = |i: usize| (0..n).map(|j| (j, entry(i, j))).filter(|(_, x)| !x.is_zero()).collect();
        Self((0..n).map(row).collect())
    }

    fn times(&self, x: &[Wide], bits: usize) -> Vec<Wide> {
        let add = |sum: Wide, (j, entry): &(usize, Big)| sum.add(&x[*j].times(entry));
        self.0.iter().map(|row| row.iter().fold(Wide::zero(bits), add)).collect()
    }

    pub(super) fn count(&self) -> usize {
        self.0.iter().map(Vec::len).sum()
    }
}

/// The scaled matrices and the transposes that left vectors need.
pub(super) struct Matrices {
    pub(super) bits: usize,
    pub(super) right: [Rows; 3],
    left: [Rows; 3],
}

impl Matrices {
    pub(super) fn new(
        scaled: &Scaled,
        problem: &QuadraticProblem,
        source: &dyn QuadraticSource,
        bits: usize,
    ) -> Option<Self> {
        let n = scaled.n;
        let whole = source.precisely(bits).or_else(|| as_it_is(problem, bits))?;
        let square = n * n;
        if whole.iter().any(|m| m.len() != square || m.iter().any(|x| !x.is_finite())) {
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

    fn conjugate(&self) -> Self {
        Self { own: self.own.conjugate(), image: conjugate(&self.image), slope: conjugate(&self.slope) }
    }

    /// Q_ij = y_iᵀ ((μ_i + μ_j) M + D) x_j.
    fn unit(&self, other: &Self) -> Approximate {
        let sum = self.own.mu.add(&other.own.mu);
        let parts = other.image.iter().zip(&other.slope);
        let terms = self.own.y.iter().zip(parts).map(|(y, (u, v))| y.mul(&sum.mul(u).add(v)));
        approximate(&terms.fold(Wide::zero(64), |total, term| total.add(&term)))
    }

    pub(super) fn residuals(&mut self, matrices: &Matrices) -> Residuals {
        let bits = matrices.bits;
        let of_x = matrices.right.each_ref().map(|a| a.times(&self.own.x, bits));
        let of_y = matrices.left.each_ref().map(|a| a.times(&self.own.y, bits));
        let residuals = residuals(&mut self.own, &of_x, &of_y, bits);
        let [image, slope, _] = of_x;
        (self.image, self.slope) = (image, slope);
        residuals
    }
}

/// Columns of double-double, some of them replaced by better ones.
#[derive(Clone)]
pub(super) struct WideColumns {
    pub(super) base: Columns,
    pub(super) wide: Vec<Option<WideColumn>>,
    /// 0 where all are of double-double.
    pub(super) bits: usize,
}

/// How a group of columns is turned, and what it makes of them.
type Turned<S> = (Turn, Option<Vec<Column<S>>>);

/// Columns of a group turned by the eigenvectors of their block; exponents get the second precision.
fn turned_group<S: Enclosure>(
    couplings: &Couplings,
    members: Vec<usize>,
    conjugate_of: &[Option<usize>],
    real: bool,
    old: &[Column<S>],
    precisions: (S::Precision, S::Precision),
) -> Option<Turned<S>> {
    let center = center(old, real, precisions.1);
    let turn = turn(couplings, members, conjugate_of, |at| old[at].mu.sub(&center).to_c64())?;
    let new = turned(old, &turn, &center, precisions);
    Some((turn, new))
}

impl WideColumns {
    /// Turns a group by the eigenvectors of its block, in `next`; whether it has any.
    pub(super) fn turn(&self, couplings: &Couplings, members: Vec<usize>, real: bool, next: &mut Self) -> bool {
        let conjugate_of = &self.base.conjugate_of;
        if self.bits == 0 {
            let old: Vec<Column<Ball>> = members.iter().map(|&j| self.base.all[j].clone()).collect();
            let found = turned_group(couplings, members, conjugate_of, real, &old, ((), ()));
            if let Some((turn, Some(new))) = found.as_ref() {
                next.base.put(turn, new.clone());
            }
            return found.is_some();
        }
        let old: Option<Vec<Column<Big>>> = members.iter().map(|&j| Some(self.get(j)?.own)).collect();
        let precisions = (self.bits, 2 * self.bits);
        let found = old.and_then(|old| turned_group(couplings, members, conjugate_of, real, &old, precisions));
        if let Some((turn, Some(new))) = found.as_ref() {
            let narrow = |v: &[Wide]| v.iter().map(Wide::to_complex).collect();
            let base = new.iter().map(|own| Column { mu: own.mu.to_complex(), x: narrow(&own.x), y: narrow(&own.y) });
            next.base.put(turn, base.collect());
            for (own, &j) in new.iter().zip(&turn.members) {
                next.wide[j] = next.base.conjugate_of[j].is_none().then(|| WideColumn::new(own.clone()));
            }
        }
        found.is_some()
    }

    /// What the columns of many bits contribute, in the place of what those of double-double do.
    pub(super) fn measure(&mut self, matrices: &Matrices, measured: &mut [Residuals]) {
        for (j, column) in self.wide.iter_mut().enumerate() {
            if let Some(column) = column {
                measured[j] = column.residuals(matrices);
                self.base.all[j].mu = column.own.mu.to_complex();
            }
        }
        for j in 0..self.base.count() {
            if let Some(i) = self.base.conjugate_of[j]
                && self.wide[i].is_some()
            {
                measured[j] = measured[i].conjugate();
                self.base.all[j].mu = self.base.mu(i).conjugate();
            }
        }
    }

    /// The exponent with this radius.
    pub(super) fn value(&self, j: usize, radius: f64) -> Value {
        match self.mu(j) {
            Some(mu) => {
                let mu = mu.with_added_radius(Magnitude::from_f64(radius));
                Value::wide(mu.re, mu.im)
            }
            None => self.base.value(j, radius),
        }
    }

    pub(super) fn get(&self, j: usize) -> Option<WideColumn> {
        match self.base.conjugate_of[j] {
            Some(i) => self.wide[i].as_ref().map(WideColumn::conjugate),
            None => self.wide[j].clone(),
        }
    }

    /// The entries of Q between members of a group, and between columns that are as close as those of one: doubles lose them.
    pub(super) fn units(&self, certificate: &Certificate) -> Vec<(usize, usize, Approximate)> {
        let get = |j: usize| Some((j, self.get(j)?));
        let columns: Vec<(usize, WideColumn)> = (0..self.base.count()).filter_map(get).collect();
        let size = |j: usize| self.base.mu(j).modulus();
        let together = |i: usize, j: usize| {
            certificate.of[i] == certificate.of[j] || self.base.distance(i, j) < NEAR * size(i).max(size(j))
        };
        let mut known = Vec::new();
        for (i, a) in &columns {
            let others: Vec<_> = columns.iter().filter(|(j, _)| together(*i, *j)).collect();
            if (2..=MOST_TOGETHER).contains(&others.len()) {
                known.extend(others.iter().map(|(j, b)| (*i, *j, a.unit(b))));
            }
        }
        known
    }

    pub(super) fn mu(&self, j: usize) -> Option<Wide> {
        match self.base.conjugate_of[j] {
            Some(i) => self.wide[i].as_ref().map(|column| column.own.mu.conjugate()),
            None => self.wide[j].as_ref().map(|column| column.own.mu.clone()),
        }
    }

    /// μ_i - μ_j, nearly.
    pub(super) fn difference(&self, i: usize, j: usize) -> c64 {
        match (self.mu(i), self.mu(j)) {
            (Some(a), Some(b)) => a.sub(&b).to_c64(),
            _ => {
                let (a, b) = (self.base.mu(i), self.base.mu(j));
                let difference = a.sub(b);
                // A column of many bits is rounded to 2^-104 of itself here; closer ones count as not apart.
                let least = if self.bits == 0 { 0.0 } else { 1e-15 * (a.modulus() + b.modulus()) };
                if difference.modulus() > least { difference.to_c64() } else { c64::new(0.0, 0.0) }
            }
        }
    }

    /// Columns join at the precision that is in use.
    pub(super) fn widen(&mut self, which: &[usize]) {
        for &j in which {
            if self.base.conjugate_of[j].is_none() && j >= self.base.together() && self.wide[j].is_none() {
                let wide = |x: &Complex| Wide::from_complex(x, self.bits);
                let Column { mu, x, y } = &self.base.all[j];
                let (x, y) = (x.iter().map(wide).collect(), y.iter().map(wide).collect());
                self.wide[j] = Some(WideColumn::new(Column { mu: wide(mu), x, y }));
            }
        }
    }
}

/// Bits of vectors for matrices of so many.
pub(super) fn half(bits: usize) -> usize {
    bits / 2 + 64
}
