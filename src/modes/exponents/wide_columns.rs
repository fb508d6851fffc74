//! Columns of many bits: residuals and quotients.

use faer::c64;

use super::certify::Certificate;
use super::columns::Columns;
use super::complex::{Complex, Wide};
use super::couplings::{Approximate, Sheet};
use super::resolve::Turn;
use super::scale::Scaled;
use super::spectrum::Value;
use super::{PreciseQuadratic, QuadraticProblem, QuadraticSource};
use crate::precision::{Big, DoubleDouble, Magnitude};

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

/// A column of many bits; its parts are exact numbers.
#[derive(Clone)]
pub(super) struct WideColumn {
    pub(super) mu: Wide,
    pub(super) x: Vec<Wide>,
    pub(super) y: Vec<Wide>,
    /// M x and D x, as they were measured.
    image: Vec<Wide>,
    slope: Vec<Wide>,
}

impl WideColumn {
    pub(super) fn new(mu: Wide, x: Vec<Wide>, y: Vec<Wide>) -> Self {
        Self { mu, x, y, image: Vec::new(), slope: Vec::new() }
    }

    fn conjugate(&self) -> Self {
        let conjugate = |v: &[Wide]| v.iter().map(Wide::conjugate).collect();
        Self {
            mu: self.mu.conjugate(),
            x: conjugate(&self.x),
            y: conjugate(&self.y),
            image: conjugate(&self.image),
            slope: conjugate(&self.slope),
        }
    }

    /// Q_ij = y_iᵀ ((μ_i + μ_j) M + D) x_j.
    fn unit(&self, other: &Self) -> Approximate {
        let sum = self.mu.add(&other.mu);
        let parts = other.image.iter().zip(&other.slope);
        let entry =
            self.y.iter().zip(parts).fold(Wide::zero(64), |total, (y, (u, v))| total.add(&y.mul(&sum.mul(u).add(v))));
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
        let im = if source == j { part(&column.mu.im) } else { -&part(&column.mu.im) };
        Value::wide(part(&column.mu.re), im)
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
            Some(i) => self.wide[i].as_ref().map(|column| column.mu.conjugate()),
            None => self.wide[j].as_ref().map(|column| column.mu.clone()),
        }
    }

    /// μ_i - μ_j, nearly.
    pub(super) fn difference(&self, i: usize, j: usize) -> c64 {
        match (self.mu(i), self.mu(j)) {
            (Some(a), Some(b)) => a.sub(&b).to_c64(),
            _ => {
                let difference = self.base.mu[i].sub(&self.base.mu[j]);
                // A column of many bits is rounded to 2^-104 of itself here; closer ones count as not apart.
                let size = self.base.mu[i].modulus() + self.base.mu[j].modulus();
                if difference.modulus() > 1e-15 * size { difference.to_c64() } else { c64::new(0.0, 0.0) }
            }
        }
    }

    /// Columns join at the precision that is in use.
    pub(super) fn widen(&mut self, which: &[usize]) {
        for &j in which {
            if self.base.twin[j].is_none() && j >= self.base.together() && self.wide[j].is_none() {
                let wide = |v: &[Complex]| v.iter().map(|x| Wide::from_complex(x, self.bits)).collect();
                let mu = Wide::from_complex(&self.base.mu[j], self.bits);
                let (x, y) = (wide(&self.base.x[j]), wide(&self.base.y[j]));
                self.wide[j] = Some(WideColumn::new(mu, x, y));
            }
        }
    }
}

/// Bits of vectors for matrices of so many.
pub(super) fn half(bits: usize) -> usize {
    bits / 2 + 64
}

fn approximate(x: &Wide) -> Approximate {
    let value = x.to_c64();
    let size = value.re.hypot(value.im);
    Approximate { value, error: x.radius().to_f64() + size * 2f64.powi(-50) + 1e-300 }
}

pub(super) fn sheet(matrices: &Matrices, column: &mut WideColumn) -> Sheet {
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
    let mu = column.mu.clone();
    let mut mu = Wide::new(mu.re.with_bits(bits), mu.im.with_bits(bits));
    let mut residual = quadratic(&mu, &of_x);
    let against =
        |residual: &[Wide]| column.y.iter().zip(residual).fold(Wide::zero(bits), |sum, (y, r)| sum.add(&y.mul(r)));
    for _ in 0..2 {
        let over = against(&residual);
        let mut under = Wide::zero(64);
        for (i, y) in column.y.iter().enumerate() {
            let slope = mu.mul(&of_x[0][i]);
            let slope = slope.add(&slope).add(&of_x[1][i]);
            under = under.add(&y.mul(&slope));
        }
        let step = over.div(&under);
        // Where exponents meet, a step may lead anywhere.
        if !step.is_finite() || step.upper_bound().to_f64() > 4.0 * mu.upper_bound().to_f64() {
            break;
        }
        mu = mu.sub(&step).rounded(bits);
        if real {
            mu.im = Big::zero(bits);
        }
        residual = quadratic(&mu, &of_x);
    }
    let defect = against(&residual).upper_bound().to_f64();
    let left = quadratic(&mu, &of_y);
    let all = |v: &[Wide]| v.iter().map(approximate).collect::<Vec<_>>();
    let rest: Vec<Wide> = of_x[1].iter().zip(&of_x[0]).map(|(v, u)| v.add(&mu.mul(u))).collect();
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

/// Puts the turned columns in the place of the members.
pub(super) fn apply(from: &WideColumns, to: &mut WideColumns, turn: &Turn, centre: &Wide) {
    let bits = from.bits;
    let Some(old): Option<Vec<WideColumn>> = turn.members.iter().map(|&j| from.get(j)).collect() else {
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
                    *sum = sum.add(&by.mul(x)).rounded(bits);
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
        let real =
            turn.twin[a].is_none() && turn.steps[a].im == 0.0 && centre.im.is_zero() && !turn.twin.contains(&Some(a));
        let scale = |v: Vec<Wide>, by: f64| -> Vec<Wide> {
            let by = Big::from_f64(by, bits);
            v.iter()
                .map(|x| {
                    let mut x = x.times(&by).rounded(bits);
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
            im: if real { DoubleDouble::ZERO } else { column.mu.im.to_ball().mid },
        };
        to.base.x[j] = column.x.iter().map(Wide::to_complex).collect();
        to.base.y[j] = column.y.iter().map(Wide::to_complex).collect();
        to.wide[j] = if to.base.twin[j].is_some() { None } else { Some(column) };
    }
}
