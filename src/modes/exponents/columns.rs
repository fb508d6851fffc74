//! The columns in double-double: residuals, quotients and improvement.

use faer::c64;

use super::super::dense::{Matrix, Plain};
use super::complex::Complex;
use super::couplings::{Approximate, Couplings, Link, Sheet};
use super::scale::{Enclosure, Scaled};
use super::start::Start;
use crate::precision::{U2, up};

/// Approximate vectors and exponents, all exact numbers but for the given vectors of the kernel.
#[derive(Clone)]
pub(super) struct Columns {
    pub(super) mu: Vec<Complex>,
    pub(super) x: Vec<Vec<Complex>>,
    pub(super) y: Vec<Vec<Complex>>,
    /// The column that this one is the exact conjugate of.
    pub(super) twin: Vec<Option<usize>>,
    pub(super) zeros: usize,
    pub(super) chains: usize,
    pub(super) links: Vec<Link>,
}

impl Columns {
    pub(super) fn new(start: Start) -> Self {
        let Start { mu, x, y, twin, zeros, chains, links } = start;
        Self { mu: mu.into_iter().map(Complex::from_c64).collect(), x, y, twin, zeros, chains, links }
    }

    pub(super) fn count(&self) -> usize {
        self.mu.len()
    }

    /// How many columns belong to the exponent 0.
    pub(super) fn together(&self) -> usize {
        self.zeros + self.chains
    }

    /// |μ_i - μ_j|, nearly.
    pub(super) fn distance(&self, i: usize, j: usize) -> f64 {
        self.mu[i].sub(&self.mu[j]).modulus()
    }
}

/// A matrix times complex columns, with a bound of the error of each entry.
struct Image {
    value: Matrix,
    error: Plain,
}

impl Image {
    /// `inexact`: by how much the vectors themselves may be off, for the first of them.
    fn new(matrix: &Enclosure, x: &Matrix, inexact: &[Vec<f64>]) -> Self {
        let (value, mut error) = matrix.times(x);
        for (j, radii) in inexact.iter().enumerate() {
            if radii.iter().all(|r| *r == 0.0) {
                continue;
            }
            let more = matrix.magnitude_times(radii);
            for (i, more) in more.into_iter().enumerate() {
                error.set(i, 2 * j, up(error.get(i, 2 * j) + more));
            }
        }
        Self { value, error }
    }

    fn get(&self, i: usize, j: usize) -> (Complex, f64) {
        let value = Complex { re: self.value.get(i, 2 * j), im: self.value.get(i, 2 * j + 1) };
        (value, up(self.error.get(i, 2 * j) + self.error.get(i, 2 * j + 1)))
    }

    fn column(&self, j: usize) -> Vec<(Complex, f64)> {
        (0..self.value.rows).map(|i| self.get(i, j)).collect()
    }
}

fn stacked(n: usize, columns: &[&Vec<Complex>]) -> Matrix {
    let mut matrix = Matrix::zeros(n, 2 * columns.len());
    for (j, column) in columns.iter().enumerate() {
        for (i, x) in column.iter().enumerate() {
            matrix.set(i, 2 * j, x.re);
            matrix.set(i, 2 * j + 1, x.im);
        }
    }
    matrix
}

/// (μ a + b) μ + c with a bound of its error.
///
/// By the bounds of [`Complex`] the evaluation costs 16 u² |μa|, 4 u² |μa + b|, 16 u² |μ||μa + b| and 4 u² of the
/// result, in all less than 48 u² (|μ|²|a| + |μ||b| + |c|); errors of a, b and c come on top.
fn quadratic(mu: Complex, a: (Complex, f64), b: (Complex, f64), c: (Complex, f64)) -> (Complex, f64) {
    let value = mu.mul(&a.0).add(&b.0).mul(&mu).add(&c.0);
    let m = mu.modulus() * (1.0 + 1e-15);
    let sizes = m * m * a.0.modulus() + m * b.0.modulus() + c.0.modulus();
    (value, up(48.0 * U2 * sizes * (1.0 + 1e-14) + m * m * a.1 + m * b.1 + c.1))
}

/// A double-double number in doubles.
fn rounded((value, error): (Complex, f64)) -> Approximate {
    Approximate {
        value: value.to_c64(),
        error: if error == 0.0 && value.low() == 0.0 { 0.0 } else { up(error + value.low()) },
    }
}

/// What each column contributes, with exponents replaced by two-sided quotients.
pub(super) fn measure(scaled: &Scaled, columns: &mut Columns) -> Vec<Sheet> {
    let n = scaled.n;
    let own: Vec<usize> = (0..columns.count()).filter(|&j| columns.twin[j].is_none()).collect();
    let radii: Vec<Vec<f64>> = scaled.zero.iter().map(|v| v.iter().map(|x| x.radius).collect()).collect();
    let x = stacked(n, &own.iter().map(|&j| &columns.x[j]).collect::<Vec<_>>());
    let y = stacked(n, &own.iter().map(|&j| &columns.y[j]).collect::<Vec<_>>());
    let right = [&scaled.mass, &scaled.velocity, &scaled.stiffness].map(|a| Image::new(a, &x, &radii));
    let left = [&scaled.mass, &scaled.velocity_t, &scaled.stiffness_t].map(|a| Image::new(a, &y, &[]));
    let mut sheets: Vec<Option<Sheet>> = vec![None; columns.count()];
    for (at, &j) in own.iter().enumerate() {
        let inexact = radii.get(j).map_or(&[] as &[f64], Vec::as_slice);
        let of_x = |k: usize| right[k].column(at);
        let of_y = |k: usize| left[k].column(at);
        let sheet = if j < columns.together() {
            // Columns of the exponent 0 are all their own; their places are the first.
            let linked = |image: &Image, forward: bool| {
                let mut sum = vec![(Complex::ZERO, 0.0); n];
                for link in &columns.links {
                    let (to, from) = if forward { (link.to, link.from) } else { (link.from, link.to) };
                    if to != j {
                        continue;
                    }
                    let by = Complex::from_c64(c64::new(link.value, 0.0));
                    for (sum, (x, e)) in sum.iter_mut().zip(image.column(from)) {
                        let term = by.mul(&x);
                        let value = sum.0.add(&term);
                        let rounding = U2 * (16.0 * term.modulus() + 4.0 * value.modulus());
                        *sum = (value, up(sum.1 + e * link.value.abs() + rounding * (1.0 + 1e-14)));
                    }
                }
                sum
            };
            zero_sheet(columns, j, inexact, &linked, (&right, &left), at)
        } else {
            let (u, v, w) = (of_x(0), of_x(1), of_x(2));
            let (p, q, r) = (of_y(0), of_y(1), of_y(2));
            let residuals =
                |mu: Complex| -> Vec<(Complex, f64)> { (0..n).map(|i| quadratic(mu, u[i], v[i], w[i])).collect() };
            let mut mu = columns.mu[j];
            let mut residual = residuals(mu);
            for _ in 0..2 {
                let (mut over, mut under) = (Complex::ZERO, Complex::ZERO);
                for (i, y) in columns.y[j].iter().enumerate() {
                    over = over.add(&y.mul(&residual[i].0));
                    let slope = mu.mul(&u[i].0);
                    under = under.add(&y.mul(&slope.add(&slope).add(&v[i].0)));
                }
                let step = over.to_c64() / under.to_c64();
                // Where exponents meet, a step may lead anywhere; also not finite.
                if step.re.hypot(step.im) <= 4.0 * mu.modulus() {
                    let next = mu.sub(&Complex::from_c64(step));
                    mu = next;
                    residual = residuals(mu);
                }
            }
            columns.mu[j] = mu;
            let mut defect = Complex::ZERO;
            let (mut error, mut sizes) = (0.0, 0.0);
            for (y, (value, e)) in columns.y[j].iter().zip(&residual) {
                defect = defect.add(&y.mul(value));
                error += y.modulus() * e;
                sizes += y.modulus() * value.modulus();
            }
            // Products cost 16 u² each, n sums at most 4 n u² of all.
            let error = error * (1.0 + 1e-13) + (16.0 + 4.0 * n as f64) * U2 * sizes * (1.0 + 1e-13);
            let size = mu.modulus() * (1.0 + 1e-15);
            Sheet {
                x: columns.x[j].iter().map(|x| rounded((*x, 0.0))).collect(),
                y: columns.y[j].iter().map(|y| rounded((*y, 0.0))).collect(),
                left: (0..n).map(|i| rounded(quadratic(mu, p[i], q[i], r[i]))).collect(),
                rest: (0..n)
                    .map(|i| {
                        // D x + μ M x
                        let product = mu.mul(&u[i].0);
                        let sum = product.add(&v[i].0);
                        let rounding = U2 * (20.0 * product.modulus() + 4.0 * v[i].0.modulus());
                        rounded((sum, up(v[i].1 + size * u[i].1 + rounding * (1.0 + 1e-14))))
                    })
                    .collect(),
                turned: columns.y[j]
                    .iter()
                    .map(|y| {
                        let product = mu.mul(y);
                        rounded((product, up(17.0 * U2 * product.modulus())))
                    })
                    .collect(),
                image: u.into_iter().map(rounded).collect(),
                residual: residual.into_iter().map(rounded).collect(),
                defect: up(defect.modulus() * (1.0 + 1e-15) + error),
            }
        };
        sheets[j] = Some(sheet);
    }
    for j in 0..columns.count() {
        if let Some(i) = columns.twin[j] {
            columns.mu[j] = columns.mu[i].conjugate();
            sheets[j] = sheets[i].as_ref().map(Sheet::conjugate);
        }
    }
    sheets.into_iter().flatten().collect()
}

/// Σ over the links of a column of the images of the columns at their other ends: forward (XT)_j, else (TYᵀ)_j.
type Linked<'a> = dyn Fn(&Image, bool) -> Vec<(Complex, f64)> + 'a;

/// A column of the exponent 0. With x̃ = (XT)_j, a combination of vectors of the kernel, the residual is D x̃ + S x_j,
/// and exactly 0 for a vector of the kernel; from the left Dᵀ ỹ + Sᵀ y_j with ỹ = (TYᵀ)_j.
fn zero_sheet(
    columns: &Columns,
    j: usize,
    inexact: &[f64],
    linked: &Linked<'_>,
    (right, left): (&[Image; 3], &[Image; 3]),
    at: usize,
) -> Sheet {
    let n = columns.x[j].len();
    let sum = |a: Vec<(Complex, f64)>, b: Vec<(Complex, f64)>| -> Vec<(Complex, f64)> {
        a.into_iter()
            .zip(b)
            .map(|(a, b)| {
                let value = a.0.add(&b.0);
                (value, up(a.1 + b.1 + 4.0 * U2 * value.modulus() * (1.0 + 1e-14)))
            })
            .collect()
    };
    let residual = if j < columns.zeros {
        vec![(Complex::ZERO, 0.0); n]
    } else {
        sum(linked(&right[1], true), right[2].column(at))
    };
    let turned: Vec<(Complex, f64)> = (0..n)
        .map(|i| {
            let mut total = (Complex::ZERO, 0.0);
            for link in columns.links.iter().filter(|link| link.from == j) {
                let by = Complex::from_c64(c64::new(link.value, 0.0));
                let term = by.mul(&columns.y[link.to][i]);
                let value = total.0.add(&term);
                let rounding = U2 * (16.0 * term.modulus() + 4.0 * value.modulus());
                total = (value, up(total.1 + rounding * (1.0 + 1e-14)));
            }
            total
        })
        .collect();
    let from_left = sum(linked(&left[1], false), left[2].column(at));
    let rest = sum(right[1].column(at), linked(&right[0], true));
    // Moduli of y may be large where exponents near 0 are hardly separated: the plain sum does.
    let defect: f64 =
        columns.y[j].iter().zip(&residual).map(|(y, (value, error))| y.modulus() * (value.modulus() + error)).sum();
    let x = columns.x[j].iter().enumerate();
    Sheet {
        x: x.map(|(i, x)| rounded((*x, inexact.get(i).copied().unwrap_or(0.0)))).collect(),
        y: columns.y[j].iter().map(|y| rounded((*y, 0.0))).collect(),
        residual: residual.into_iter().map(rounded).collect(),
        left: from_left.into_iter().map(rounded).collect(),
        image: right[0].column(at).into_iter().map(rounded).collect(),
        rest: rest.into_iter().map(rounded).collect(),
        turned: turned.into_iter().map(rounded).collect(),
        defect: up(defect * (1.0 + (n as f64 + 8.0) * f64::EPSILON)),
    }
}

/// The step of a vector towards the exact one, by the resolvent L(μ)⁻¹ = Σ x_i y_iᵀ / (q_ii (μ - μ_i)) without
/// column j: minus Σ x_i (y_iᵀR_j) / (q_ii (μ_j - μ_i)); from the left likewise. `skip` leaves columns out.
pub(super) fn steps<'a>(
    couplings: &Couplings,
    columns: &Columns,
    sheets: &'a [Sheet],
    j: usize,
    difference: impl Fn(usize) -> c64,
    skip: impl Fn(usize) -> bool,
) -> (Vec<c64>, Vec<c64>) {
    let n = columns.x[j].len();
    let zero = c64::new(0.0, 0.0);
    let (mut right, mut left) = (vec![zero; columns.count()], vec![zero; columns.count()]);
    for i in (0..columns.count()).filter(|&i| i != j && !skip(i)) {
        let by = couplings.unit.get(i, i) * difference(i);
        right[i] = couplings.residuals.get(i, j) / by;
        left[i] = couplings.lefts.get(j, i) / by;
    }
    for link in &columns.links {
        let by = difference(link.to);
        if skip(link.to) || skip(link.from) {
            continue;
        }
        let (a, b) = (right[link.to], left[link.from]);
        right[link.from] += a / by * link.value;
        left[link.to] += b / by * link.value;
    }
    let sum = |weights: &[c64], part: &dyn Fn(usize) -> &'a [Approximate]| {
        let mut total = vec![zero; n];
        for (i, &weight) in weights.iter().enumerate() {
            if weight.re == 0.0 && weight.im == 0.0 || !(weight.re + weight.im).is_finite() {
                continue;
            }
            for (t, x) in total.iter_mut().zip(part(i)) {
                *t -= weight * x.value;
            }
        }
        total
    };
    let x = sum(&right, &|i| &sheets[i].x);
    let y = sum(&left, &|i| &sheets[i].y);
    (x, y)
}

/// One step for each of the given columns, and left vectors rescaled so that Q_jj is nearly 1.
pub(super) fn improve(
    couplings: &Couplings,
    columns: &mut Columns,
    sheets: &[Sheet],
    which: &[usize],
    skip: impl Fn(usize, usize) -> bool,
) {
    let mut changes = Vec::with_capacity(which.len());
    for &j in which {
        let difference = |i: usize| columns.mu[j].sub(&columns.mu[i]).to_c64();
        changes.push(steps(couplings, columns, sheets, j, difference, |i| skip(j, i)));
    }
    for (&j, (dx, dy)) in which.iter().zip(changes) {
        let real = columns.mu[j].im.hi == 0.0 && columns.mu[j].im.lo == 0.0;
        let by = c64::new(1.0, 0.0) / couplings.unit.get(j, j);
        for (x, dx) in columns.x[j].iter_mut().zip(dx) {
            let dx = if real { c64::new(dx.re, 0.0) } else { dx };
            *x = x.add(&Complex::from_c64(dx));
        }
        for (y, dy) in columns.y[j].iter_mut().zip(dy) {
            let dy = if real { c64::new(dy.re, 0.0) } else { dy };
            *y = y.add(&Complex::from_c64(dy));
            let scaled = y.mul(&Complex::from_c64(by));
            if scaled.is_finite() {
                *y = scaled;
                if real {
                    y.im = crate::precision::DoubleDouble::ZERO;
                }
            }
        }
    }
    for j in 0..columns.count() {
        if let Some(i) = columns.twin[j] {
            columns.x[j] = columns.x[i].iter().map(|x| x.conjugate()).collect();
            columns.y[j] = columns.y[i].iter().map(|y| y.conjugate()).collect();
        }
    }
}
