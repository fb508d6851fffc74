//! Columns of many bits: residuals and quotients.

use faer::c64;

use super::certify::Certificate;
use super::columns::{Column, Columns, approximate, conjugate, sheet, turned};
use super::complex::{Complex, Wide};
use super::couplings::{Approximate, Sheet};
use super::resolve::Turn;
use super::scale::Scaled;
use super::spectrum::Value;
use super::{PreciseQuadratic, QuadraticProblem, QuadraticSource};
use crate::precision::{Big, Magnitude};

/// Larger groups have their entries of Q from doubles.
const MOST_TOGETHER: usize = 16;

/// A matrix of numbers of many bits: the entries that are not 0, row by row.
pub(super) struct Rows(Vec<Vec<(usize, Big)>>);

impl Rows {
    fn new(n: usize, entry: impl Fn(usize, usize) -> Big) -> Self {
        let row = |i: usize| (0..n).map(|j| (j, entry(i, j))).filter(|(_, x)| !x.is_zero()).collect();
        Self((0..n).map(row).collect())
    }

    fn times(&self, x: &[Wide], bits: usize) -> Vec<Wide> {
        self.0
            .iter()
            .map(|row| {
                let zero = Wide::zero(bits);
                row.iter().fold(zero, |sum, (j, entry)| sum.add(&x[*j].times(entry)))
            })
            .collect()
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
        let precise = source.precisely(bits).or_else(|| as_it_is(problem, bits))?;
        let square = n * n;
        let whole = [&precise.mass, &precise.velocity, &precise.stiffness];
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
    let wide = |entries: &[crate::precision::Ball]| -> Option<Vec<Big>> {
        entries.iter().map(|x| x.is_exact().then(|| Big::from_ball(x, bits))).collect()
    };
    Some(PreciseQuadratic {
        mass: wide(&problem.mass)?,
        velocity: wide(&problem.velocity)?,
        stiffness: wide(&problem.stiffness)?,
        zero_vectors: Vec::new(),
    })
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

    pub(super) fn sheet(&mut self, matrices: &Matrices) -> Sheet {
        let bits = matrices.bits;
        let of_x = matrices.right.each_ref().map(|a| a.times(&self.own.x, bits));
        let of_y = matrices.left.each_ref().map(|a| a.times(&self.own.y, bits));
        let sheet = sheet(&mut self.own, &of_x, &of_y, bits);
        let [image, slope, _] = of_x;
        (self.image, self.slope) = (image, slope);
        sheet
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
        match self.mu(j) {
            Some(mu) => {
                let mu = mu.with_added_radius(Magnitude::from_f64(radius));
                Value::wide(mu.re, mu.im)
            }
            None => self.base.value(j, radius),
        }
    }

    pub(super) fn get(&self, j: usize) -> Option<WideColumn> {
        match self.base.twin[j] {
            Some(i) => self.wide[i].as_ref().map(WideColumn::conjugate),
            None => self.wide[j].clone(),
        }
    }

    /// The entries of Q between members of a group.
    pub(super) fn units(&self, certificate: &Certificate) -> Vec<(usize, usize, Approximate)> {
        let mut known = Vec::new();
        for group in &certificate.groups {
            let members = group.members.iter();
            let columns: Vec<(usize, WideColumn)> = members.filter_map(|&j| Some((j, self.get(j)?))).collect();
            if group.members.len() < 2 || columns.len() > MOST_TOGETHER {
                continue;
            }
            for (i, a) in &columns {
                known.extend(columns.iter().map(|(j, b)| (*i, *j, a.unit(b))));
            }
        }
        known
    }

    pub(super) fn mu(&self, j: usize) -> Option<Wide> {
        match self.base.twin[j] {
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
                let size = a.modulus() + b.modulus();
                if difference.modulus() > 1e-15 * size { difference.to_c64() } else { c64::new(0.0, 0.0) }
            }
        }
    }

    /// Columns join at the precision that is in use.
    pub(super) fn widen(&mut self, which: &[usize]) {
        for &j in which {
            if self.base.twin[j].is_none() && j >= self.base.together() && self.wide[j].is_none() {
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

/// The turned columns of a group, put in the place of the members.
pub(super) fn apply(from: &WideColumns, to: &mut WideColumns, turn: &Turn, center: &Wide) {
    let members = turn.members.iter();
    let old: Option<Vec<Column<Big>>> = members.map(|&j| Some(from.get(j)?.own)).collect();
    let bits = from.bits;
    let Some(new) = old.and_then(|old| turned(&old, turn, center, (bits, 2 * bits))) else {
        return;
    };
    let narrow = |v: &[Wide]| v.iter().map(Wide::to_complex).collect();
    let base = new.iter().map(|own| Column { mu: own.mu.to_complex(), x: narrow(&own.x), y: narrow(&own.y) });
    to.base.put(turn, base.collect());
    for (own, &j) in new.into_iter().zip(&turn.members) {
        to.wide[j] = to.base.twin[j].is_none().then(|| WideColumn::new(own));
    }
}
