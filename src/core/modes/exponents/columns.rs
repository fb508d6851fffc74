//! Columns: approximate exponents with their vectors; residuals, quotients and improvement in numbers of any precision.

use std::collections::BTreeMap;

use faer::c64;

use super::super::dense::Matrix;
use super::super::pencil::Enclosed;
use super::certify::Certificate;
use super::complex::{Complex, Wide, part, rounded};
use super::couplings::{Approximate, Couplings, Link, Residuals};
use super::resolve::{Turn, is_single, members, turn};
use super::scale::Scaled;
use super::wide::{Matrices, WideColumn};
use crate::precision::{self, Ball, Big, Enclosure, Magnitude, up};

/// Quotients are taken so often.
const QUOTIENTS: usize = 2;
/// Larger groups have their entries of Q from doubles.
const MOST_TOGETHER: usize = 16;
/// Exponents are close where they differ by less than this part.
const NEAR: f64 = 1e-6;

/// An exponent with its vector and left vector: approximations that are exact numbers, but for the given vectors of the kernel.
#[derive(Clone)]
pub(super) struct Column<S> {
    pub(super) mu: precision::Complex<S>,
    pub(super) x: Vec<precision::Complex<S>>,
    pub(super) y: Vec<precision::Complex<S>>,
}

impl<S: Enclosure> Column<S> {
    /// The same with the images of all numbers.
    pub(super) fn map<T>(&self, image: impl Fn(&precision::Complex<S>) -> precision::Complex<T>) -> Column<T> {
        Column { mu: image(&self.mu), x: self.x.iter().map(&image).collect(), y: self.y.iter().map(&image).collect() }
    }

    pub(super) fn conjugate(&self) -> Self {
        self.map(precision::Complex::conjugate)
    }

    pub(super) fn is_real(&self) -> bool {
        Enclosure::is_zero(&self.mu.im)
    }

    pub(super) fn is_finite(&self) -> bool {
        self.mu.is_finite() && self.x.iter().chain(&self.y).all(precision::Complex::is_finite)
    }

    /// With steps added to the vectors, the left one divided by Q_jj; `None` where that leaves the range of numbers.
    pub(super) fn improved(&self, steps: (Vec<c64>, Vec<c64>), unit: c64, precision: S::Precision) -> Option<Self> {
        let real = self.is_real();
        let number = |z| precision::Complex::<S>::from_c64(z, precision);
        let added = |z: &precision::Complex<S>, step: c64| z.add(&number(part(step, real)));
        let by = c64::new(1.0, 0.0) / unit;
        let by = number(if (by.re + by.im).is_finite() { by } else { c64::new(1.0, 0.0) });
        let (dx, dy) = steps;
        let x = self.x.iter().zip(dx).map(|(x, step)| rounded(&added(x, step), real, precision));
        let y = self.y.iter().zip(dy).map(|(y, step)| rounded(&added(y, step).mul(&by), real, precision));
        let improved = Self { mu: self.mu.clone(), x: x.collect(), y: y.collect() };
        improved.is_finite().then_some(improved)
    }
}

/// The columns of a problem, in double-double, some of them with more bits.
#[derive(Clone, Default)]
pub(super) struct Columns {
    pub(super) all: Vec<Column<Ball>>,
    /// Better columns in the place of those with these numbers, none of which is the conjugate of another.
    pub(super) wide: BTreeMap<usize, WideColumn>,
    /// How many bits vectors of these have; 0 where all are of double-double.
    pub(super) bits: usize,
    /// The column that this one is the exact conjugate of.
    pub(super) conjugate_of: Vec<Option<usize>>,
    pub(super) zeros: usize,
    pub(super) chains: usize,
    pub(super) links: Vec<Link>,
}

impl Columns {
    pub(super) fn count(&self) -> usize {
        self.all.len()
    }

    pub(super) fn mu(&self, j: usize) -> &Complex {
        &self.all[j].mu
    }

    /// How many columns belong to the exponent 0.
    pub(super) fn together(&self) -> usize {
        self.zeros + self.chains
    }

    /// |μ_i - μ_j|, nearly.
    pub(super) fn distance(&self, i: usize, j: usize) -> f64 {
        self.mu(i).sub(self.mu(j)).modulus()
    }

    /// The column with this number and more bits, if it has them.
    fn wide(&self, j: usize) -> Option<WideColumn> {
        match self.conjugate_of[j] {
            Some(i) => self.wide.get(&i).map(WideColumn::conjugate),
            None => self.wide.get(&j).cloned(),
        }
    }

    /// The exponent of that column.
    fn wide_mu(&self, j: usize) -> Option<Wide> {
        match self.conjugate_of[j] {
            Some(i) => self.wide.get(&i).map(|column| column.own.mu.conjugate()),
            None => self.wide.get(&j).map(|column| column.own.mu.clone()),
        }
    }

    /// The exponent with this radius, and to more digits where balls do not hold them.
    pub(super) fn value(&self, j: usize, radius: f64) -> (Complex, Option<Wide>) {
        let radius = Magnitude::from_f64(radius);
        let wide = self.wide_mu(j).map(|mu| mu.with_added_radius(radius));
        let far = wide.as_ref().map(|mu| Complex { re: mu.re.to_far_ball(), im: mu.im.to_far_ball() });
        (far.unwrap_or_else(|| self.mu(j).with_added_radius(radius)), wide)
    }

    /// μ_i - μ_j, nearly.
    pub(super) fn difference(&self, i: usize, j: usize) -> c64 {
        if let (Some(a), Some(b)) = (self.wide_mu(i), self.wide_mu(j)) {
            return a.sub(&b).to_c64();
        }
        let (a, b) = (self.mu(i), self.mu(j));
        let difference = a.sub(b);
        // A column of many bits is rounded to 2^-104 of itself here; closer ones count as not apart.
        let least = if self.bits == 0 { 0.0 } else { 1e-15 * (a.modulus() + b.modulus()) };
        if difference.modulus() > least { difference.to_c64() } else { c64::new(0.0, 0.0) }
    }

    /// Columns get as many bits as the others that have more.
    pub(super) fn widen(&mut self, which: &[usize]) {
        for &j in which {
            if self.conjugate_of[j].is_none() && j >= self.together() && !self.wide.contains_key(&j) {
                let own = self.all[j].map(|x| Wide::from_complex(x, self.bits));
                self.wide.insert(j, WideColumn::new(own));
            }
        }
    }

    /// What the columns of many bits contribute, in the place of what those of double-double do.
    pub(super) fn measure(&mut self, matrices: &Matrices, measured: &mut [Residuals]) {
        for (&j, column) in &mut self.wide {
            measured[j] = column.residuals(matrices);
            self.all[j].mu = column.own.mu.to_complex();
        }
        for j in 0..self.count() {
            if let Some(i) = self.conjugate_of[j].filter(|i| self.wide.contains_key(i)) {
                measured[j] = measured[i].conjugate();
                self.all[j].mu = self.mu(i).conjugate();
            }
        }
    }

    /// The entries of Q between members of a group, and between columns that are as close as those of one: doubles lose them.
    pub(super) fn units(&self, certificate: &Certificate) -> Vec<(usize, usize, Approximate)> {
        let columns: Vec<(usize, WideColumn)> = (0..self.count()).filter_map(|j| Some((j, self.wide(j)?))).collect();
        let size = |j: usize| self.mu(j).modulus();
        let together = |i: usize, j: usize| {
            certificate.of[i] == certificate.of[j] || self.distance(i, j) < NEAR * size(i).max(size(j))
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

    /// Turns a group by the eigenvectors of its block, in `next`; whether it has any.
    fn turn(&self, couplings: &Couplings, members: Vec<usize>, real: bool, next: &mut Self) -> bool {
        if self.bits == 0 {
            let old: Vec<Column<Ball>> = members.iter().map(|&j| self.all[j].clone()).collect();
            let put = |turn: &Turn, new| next.put(turn, new);
            return turn_group(couplings, (members, &self.conjugate_of), real, &old, ((), ()), put);
        }
        let old: Option<Vec<Column<Big>>> = members.iter().map(|&j| Some(self.wide(j)?.own)).collect();
        let put = |turn: &Turn, new: Vec<Column<Big>>| {
            next.put(turn, new.iter().map(|own| own.map(Wide::to_complex)).collect());
            for (own, j) in new.into_iter().zip(&turn.members) {
                next.wide.remove(j);
                if next.conjugate_of[*j].is_none() {
                    next.wide.insert(*j, WideColumn::new(own));
                }
            }
        };
        let precisions = (self.bits, 2 * self.bits);
        old.is_some_and(|old| turn_group(couplings, (members, &self.conjugate_of), real, &old, precisions, put))
    }

    /// Puts the turned columns in the place of the members.
    fn put(&mut self, turn: &Turn, new: Vec<Column<Ball>>) {
        let paired = turn.conjugate_of.iter().any(Option::is_some);
        for (a, column) in new.into_iter().enumerate() {
            let j = turn.members[a];
            if paired || self.conjugate_of[j].is_some() || column.is_real() {
                self.conjugate_of[j] = turn.conjugate_of[a].map(|b| turn.members[b]);
            }
            self.all[j] = column;
        }
    }

    /// Conjugates as what they are.
    pub(super) fn mirror(&mut self) {
        for j in 0..self.count() {
            if let Some(i) = self.conjugate_of[j] {
                self.all[j] = self.all[i].conjugate();
            }
        }
    }

    /// Turns each group that lacks digits and is not resolved, in `next`; tells which columns have been turned.
    pub(super) fn turn_groups(
        &self,
        couplings: &Couplings,
        certificate: &Certificate,
        lacking: &[usize],
        next: &mut Self,
    ) -> Vec<bool> {
        let mut turned = vec![false; self.count()];
        for group in &certificate.groups {
            if group.members.len() < 2 || !group.members.iter().any(|j| lacking.contains(j)) {
                continue;
            }
            let Some(members) = members(&group.members, &self.conjugate_of, self.together()) else { continue };
            if members.len() < 2 || members.iter().any(|&j| turned[j]) {
                continue;
            }
            let paired = |j: usize| {
                let of = |k: usize| self.conjugate_of[k] == Some(j) && members.contains(&k);
                self.conjugate_of[j].is_some_and(|i| members.contains(&i)) || (0..self.count()).any(of)
            };
            let real = members.iter().any(|&j| paired(j) || is_single(&self.conjugate_of, j));
            if self.turn(couplings, members.clone(), real, next) {
                members.iter().for_each(|&j| turned[j] = true);
            }
        }
        turned
    }
}

/// Turns columns of a group by the eigenvectors of their block, if it has any; exponents get the second precision.
fn turn_group<S: Enclosure>(
    couplings: &Couplings,
    (members, conjugate_of): (Vec<usize>, &[Option<usize>]),
    real: bool,
    old: &[Column<S>],
    precisions: (S::Precision, S::Precision),
    put: impl FnOnce(&Turn, Vec<Column<S>>),
) -> bool {
    let center = center(old, real, precisions.1);
    let turn = turn(couplings, members, conjugate_of, |at| old[at].mu.sub(&center).to_c64());
    if let Some(turn) = &turn
        && let Some(new) = turned(old, turn, &center, precisions)
    {
        put(turn, new);
    }
    turn.is_some()
}

/// The mean of the exponents of a group; real where the group is closed under conjugation.
fn center<S: Enclosure>(columns: &[Column<S>], real: bool, precision: S::Precision) -> precision::Complex<S> {
    let zero = precision::Complex::zero(precision);
    let sum = columns.iter().fold(zero, |sum, column| sum.add(&column.mu));
    let by = S::exact(1.0, precision).div(&S::exact(columns.len() as f64, precision));
    rounded(&sum.times(&by), real, precision)
}

/// The columns that a turn makes of the members of a group, with exponents as finely as `center`, vectors with `precision`; `None`
/// where they leave the range of numbers. The lengths of x and y balance as before.
fn turned<S: Enclosure>(
    old: &[Column<S>],
    turn: &Turn,
    center: &precision::Complex<S>,
    (precision, fine): (S::Precision, S::Precision),
) -> Option<Vec<Column<S>>> {
    let n = old.first()?.x.len();
    let length = |v: &[precision::Complex<S>]| v.iter().map(|x| x.to_c64().norm_sqr()).sum::<f64>().sqrt();
    let columns = (0..old.len()).map(|a| {
        let combine = |part: &dyn Fn(&Column<S>) -> &[precision::Complex<S>], weight: &dyn Fn(usize) -> c64| {
            let mut sum = vec![precision::Complex::<S>::zero(precision); n];
            for (c, column) in old.iter().enumerate() {
                let by = precision::Complex::from_c64(weight(c), precision);
                for (sum, x) in sum.iter_mut().zip(part(column)) {
                    *sum = rounded(&sum.add(&by.mul(x)), false, precision);
                }
            }
            sum
        };
        let x = combine(&|column| &column.x, &|c| turn.right[(c, a)]);
        let y = combine(&|column| &column.y, &|c| turn.left[(a, c)]);
        let by = length(&old[a].x) / length(&x);
        if !(by.is_finite() && by > 0.0) {
            return None;
        }
        let real = is_single(&turn.conjugate_of, a) && turn.steps[a].im == 0.0 && Enclosure::is_zero(&center.im);
        let scaled = |v: Vec<precision::Complex<S>>, by: f64| {
            let by = S::exact(by, precision);
            v.iter().map(|x| rounded(&x.times(&by), real, precision)).collect()
        };
        let mu = center.add(&precision::Complex::from_c64(turn.steps[a], fine));
        let mu = rounded(&mu, real, fine);
        let column = Column { mu, x: scaled(x, by), y: scaled(y, 1.0 / by) };
        column.is_finite().then_some(column)
    });
    columns.collect()
}

/// A matrix times complex columns; `inexact`: by how much the vectors themselves may be off, for the first of them.
fn image(matrix: &Enclosed, x: &Matrix, inexact: &[Vec<f64>]) -> Enclosed {
    let mut image = matrix.times(x);
    for (j, radii) in inexact.iter().enumerate().filter(|(_, radii)| radii.iter().any(|r| *r != 0.0)) {
        for (i, more) in matrix.magnitude_times(radii).into_iter().enumerate() {
            image.radius.set(i, 2 * j, up(image.radius.get(i, 2 * j) + more));
        }
    }
    image
}

fn column(image: &Enclosed, j: usize) -> Vec<Complex> {
    (0..image.mid.rows).map(|i| Complex::new(image.ball(i, 2 * j), image.ball(i, 2 * j + 1))).collect()
}

fn stacked<'a>(n: usize, columns: impl Iterator<Item = &'a Vec<Complex>>) -> Matrix {
    let columns: Vec<_> = columns.collect();
    let part = |x: &Complex, real: bool| if real { x.re.mid } else { x.im.mid };
    Matrix::from_fn(n, 2 * columns.len(), |i, j| part(&columns[j / 2][i], j % 2 == 0))
}

/// A number in doubles.
pub(super) fn approximate<S: Enclosure>(z: &precision::Complex<S>) -> Approximate {
    let error = z.re.mid_f64_error() + z.im.mid_f64_error();
    Approximate { value: z.to_c64(), error: if error == 0.0 { 0.0 } else { up(error) } }
}

fn approximates<S: Enclosure>(vector: &[precision::Complex<S>]) -> Vec<Approximate> {
    vector.iter().map(approximate).collect()
}

/// What each column contributes, with exponents replaced by two-sided quotients.
pub(super) fn measure(scaled: &Scaled, columns: &mut Columns) -> Vec<Residuals> {
    let n = scaled.n;
    let own: Vec<usize> = (0..columns.count()).filter(|&j| columns.conjugate_of[j].is_none()).collect();
    let radii: Vec<Vec<f64>> =
        columns.all[..columns.zeros].iter().map(|column| column.x.iter().map(|x| x.re.radius).collect()).collect();
    let x = stacked(n, own.iter().map(|&j| &columns.all[j].x));
    let y = stacked(n, own.iter().map(|&j| &columns.all[j].y));
    let right = [&scaled.mass, &scaled.velocity, &scaled.stiffness].map(|a| image(a, &x, &radii));
    let left = [&scaled.mass, &scaled.velocity_t, &scaled.stiffness_t].map(|a| image(a, &y, &[]));
    let mut measured: Vec<Option<Residuals>> = vec![None; columns.count()];
    for (at, &j) in own.iter().enumerate() {
        measured[j] = Some(if j < columns.together() {
            zero_residuals(columns, j, &right, &left)
        } else {
            let of = |images: &[Enclosed; 3]| images.each_ref().map(|image| column(image, at));
            residuals(&mut columns.all[j], &of(&right), &of(&left), ())
        });
    }
    for j in 0..columns.count() {
        if let Some(i) = columns.conjugate_of[j] {
            columns.all[j].mu = columns.mu(i).conjugate();
            measured[j] = measured[i].as_ref().map(Residuals::conjugate);
        }
    }
    measured.into_iter().flatten().collect()
}

/// What a column contributes that is none of the exponent 0, its exponent replaced by the two-sided quotient. `of_x` are M x, D x
/// and S x, `of_y` those of the transposes and y.
pub(super) fn residuals<S: Enclosure>(
    column: &mut Column<S>,
    of_x: &[Vec<precision::Complex<S>>; 3],
    of_y: &[Vec<precision::Complex<S>>; 3],
    precision: S::Precision,
) -> Residuals {
    type Vector<S> = Vec<precision::Complex<S>>;
    let real = column.is_real();
    let quadratic = |mu: &precision::Complex<S>, parts: &[Vector<S>; 3]| -> Vector<S> {
        let [u, v, w] = parts;
        let parts = u.iter().zip(v).zip(w);
        parts.map(|((u, v), w)| mu.mul(u).add(v).mul(mu).add(w)).collect()
    };
    let zero = precision::Complex::<S>::zero(precision);
    let against = |vector: &[precision::Complex<S>]| {
        let terms = column.y.iter().zip(vector);
        terms.fold(zero.clone(), |sum, (y, r)| sum.add(&y.mul(r)))
    };
    let mut mu = rounded(&column.mu, real, precision);
    let mut residual = quadratic(&mu, of_x);
    for _ in 0..QUOTIENTS {
        let slopes = of_x[0].iter().zip(&of_x[1]).map(|(u, v)| {
            let slope = mu.mul(u);
            slope.add(&slope).add(v)
        });
        let step = against(&residual).div(&against(&slopes.collect::<Vec<_>>())).center();
        // Where exponents meet, a step may lead anywhere.
        if !step.is_finite() || step.upper_bound() > mu.upper_bound() * Magnitude::from_f64(4.0) {
            break;
        }
        mu = rounded(&mu.sub(&step), real, precision);
        residual = quadratic(&mu, of_x);
    }
    let rest: Vector<S> = of_x[1].iter().zip(&of_x[0]).map(|(v, u)| v.add(&mu.mul(u))).collect();
    let turned: Vector<S> = column.y.iter().map(|y| mu.mul(y)).collect();
    let residuals = Residuals {
        x: approximates(&column.x),
        y: approximates(&column.y),
        left: approximates(&quadratic(&mu, of_y)),
        image: approximates(&of_x[0]),
        rest: approximates(&rest),
        turned: approximates(&turned),
        defect: against(&residual).upper_bound().to_f64(),
        residual: approximates(&residual),
    };
    column.mu = mu;
    residuals
}

/// A column of the exponent 0; these are all their own, and the first. With x̃ = (XT)_j, a combination of vectors of the kernel,
/// the residual is D x̃ + S x_j, and exactly 0 for a vector of the kernel; from the left Dᵀ ỹ + Sᵀ y_j with ỹ = (TYᵀ)_j.
fn zero_residuals(columns: &Columns, j: usize, right: &[Enclosed; 3], left: &[Enclosed; 3]) -> Residuals {
    let Column { x, y, .. } = &columns.all[j];
    let none = vec![Complex::zero(()); x.len()];
    let sum = |a: Vec<Complex>, b: &[Complex]| -> Vec<Complex> { a.iter().zip(b).map(|(a, b)| a.add(b)).collect() };
    // Σ over the links of a column of what belongs to the columns at their other ends.
    let linked = |forward: bool, vector: &dyn Fn(usize) -> Vec<Complex>| {
        columns.links.iter().fold(none.clone(), |total, link| {
            let (to, from) = if forward { (link.to, link.from) } else { (link.from, link.to) };
            if to != j {
                return total;
            }
            let by = Ball::exact(link.value);
            sum(total, &vector(from).iter().map(|x| x.times(&by)).collect::<Vec<_>>())
        })
    };
    let residual = if j < columns.zeros {
        none.clone()
    } else {
        sum(linked(true, &|from| column(&right[1], from)), &column(&right[2], j))
    };
    let turned = linked(false, &|from| columns.all[from].y.clone());
    let from_left = sum(linked(false, &|from| column(&left[1], from)), &column(&left[2], j));
    let rest = sum(column(&right[1], j), &linked(true, &|from| column(&right[0], from)));
    // Moduli of y may be large where exponents near 0 are hardly separated: the plain sum does.
    let sizes = y.iter().zip(&residual).map(|(y, r)| y.upper_bound() * r.upper_bound());
    Residuals {
        x: approximates(x),
        y: approximates(y),
        left: approximates(&from_left),
        image: approximates(&column(&right[0], j)),
        rest: approximates(&rest),
        turned: approximates(&turned),
        defect: sizes.fold(Magnitude::ZERO, |sum, size| sum + size).to_f64(),
        residual: approximates(&residual),
    }
}

/// The step of a vector towards the exact one, by the resolvent L(μ)⁻¹ = Σ x_i y_iᵀ / (q_ii (μ - μ_i)) without
/// column j: minus Σ x_i (y_iᵀR_j) / (q_ii (μ_j - μ_i)); from the left likewise. `skip` leaves columns out.
pub(super) fn steps<'a>(
    couplings: &Couplings,
    columns: &Columns,
    measured: &'a [Residuals],
    j: usize,
    difference: impl Fn(usize) -> c64,
    skip: impl Fn(usize) -> bool,
) -> (Vec<c64>, Vec<c64>) {
    let n = columns.all[j].x.len();
    let zero = c64::new(0.0, 0.0);
    let (mut right, mut left) = (vec![zero; columns.count()], vec![zero; columns.count()]);
    for i in (0..columns.count()).filter(|&i| i != j && !skip(i)) {
        let by = couplings.unit[(i, i)] * difference(i);
        right[i] = couplings.residuals[(i, j)] / by;
        left[i] = couplings.lefts[(j, i)] / by;
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
    let x = sum(&right, &|i| &measured[i].x);
    let y = sum(&left, &|i| &measured[i].y);
    (x, y)
}
