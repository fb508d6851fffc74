//! Exponents of M q̈ + B q̇ + S q = 0 for small rational matrices, by the integer polynomial
//! det(s²M + sB + S): its repeated factors say exactly what is repeated, its even factor what lies on the
//! imaginary axis, and the rank of the pencil at each root how many vectors there are.

use dashu_ratio::RBig;

use crate::draw::Exact;
use crate::real::*;

/// Coefficients, lowest power first; the last is not 0.
type Polynomial = Vec<RBig>;

/// M, B and S, exactly.
#[derive(Clone)]
pub(crate) struct Pencil {
    pub(crate) mass: Exact,
    pub(crate) velocity: Exact,
    pub(crate) position: Exact,
}

#[derive(Clone)]
pub(crate) struct Complex {
    pub(crate) re: Real,
    pub(crate) im: Real,
}

impl Complex {
    pub(crate) fn new(re: Real, im: Real) -> Self {
        Self { re, im }
    }

    fn zero(bits: usize) -> Self {
        Self::new(integer(0, bits), integer(0, bits))
    }

    fn plus(&self, other: &Self) -> Self {
        Self::new(&self.re + &other.re, &self.im + &other.im)
    }

    fn minus(&self, other: &Self) -> Self {
        Self::new(&self.re - &other.re, &self.im - &other.im)
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        Self::new(&self.re * &other.re - &self.im * &other.im, &self.re * &other.im + &self.im * &other.re)
    }

    pub(crate) fn square(&self) -> Real {
        &self.re * &self.re + &self.im * &self.im
    }

    pub(crate) fn conjugate(&self) -> Self {
        Self::new(self.re.clone(), -&self.im)
    }

    fn over(&self, other: &Self) -> Self {
        let square = other.square();
        let product = self.times(&other.conjugate());
        Self::new(product.re / &square, product.im / square)
    }

    fn is_zero(&self) -> bool {
        is_zero(&self.re) && is_zero(&self.im)
    }

    fn log2(&self) -> isize {
        log2(&self.re).max(log2(&self.im))
    }
}

/// An exponent, of a conjugate pair the one above.
pub(crate) struct Root {
    /// Exactly real or imaginary where it is.
    pub(crate) value: Complex,
    /// The algebraic multiplicity.
    pub(crate) multiplicity: usize,
    /// A basis of the kernel of the pencil there.
    pub(crate) kernel: Vec<Vec<Complex>>,
}

impl Root {
    pub(crate) fn is_real(&self) -> bool {
        is_zero(&self.value.im)
    }

    pub(crate) fn is_imaginary(&self) -> bool {
        is_zero(&self.value.re)
    }
}

impl Pencil {
    /// Whether friction takes energy: the symmetric part of B is not 0.
    pub(crate) fn is_damped(&self) -> bool {
        let n = self.mass.len();
        let part = |i: usize, j: usize| &self.velocity[i][j] + &self.velocity[j][i];
        (0..n).any(|i| (0..n).any(|j| part(i, j) != RBig::ZERO))
    }

    fn at(&self, s: &RBig) -> Exact {
        let n = self.mass.len();
        let entry = |i: usize, j: usize| (&self.mass[i][j] * s + &self.velocity[i][j]) * s + &self.position[i][j];
        (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
    }

    /// det(s²M + sB + S) from its values at 0, 1, …, 2n by divided differences.
    fn characteristic(&self) -> Polynomial {
        let points: Vec<RBig> = (0..=2 * self.mass.len()).map(RBig::from).collect();
        let mut differences: Vec<RBig> = points.iter().map(|s| determinant(self.at(s))).collect();
        for order in 1..points.len() {
            for k in (order..points.len()).rev() {
                let step = &points[k] - &points[k - order];
                differences[k] = (&differences[k] - &differences[k - 1]) / step;
            }
        }
        let mut p = vec![RBig::ZERO];
        for (point, value) in points.iter().zip(&differences).rev() {
            // p (s - point) + value
            p.insert(0, RBig::ZERO);
            for k in 0..p.len() - 1 {
                let next = p[k + 1].clone();
                p[k] -= next * point;
            }
            p[0] += value;
        }
        trimmed(p)
    }

    /// Whether the exponent 0 has a Jordan block over 2: ranks of the block Toeplitz matrices of S, B, M
    /// (Gohberg, Lancaster, Rodman, Matrix Polynomials, 1982, section 1.5).
    pub(crate) fn drifts_faster(&self) -> bool {
        let n = self.mass.len();
        let parts = [&self.position, &self.velocity, &self.mass];
        let nullity = |order: usize| {
            let size = n * order;
            let entry = |i: usize, j: usize| match (i / n).checked_sub(j / n) {
                Some(part) => parts[part][i % n][j % n].clone(),
                None => RBig::ZERO,
            };
            let matrix = (0..size).map(|i| (0..size).map(|j| entry(i, j)).collect());
            size - rank(matrix.collect())
        };
        nullity(3) > nullity(2)
    }

    /// All exponents, of conjugate pairs the one above; `None` where more bits are needed.
    pub(crate) fn roots(&self, bits: usize) -> Option<Vec<Root>> {
        let mut p = self.characteristic();
        let mut roots = Vec::new();
        let zeros = p.iter().take_while(|c| **c == RBig::ZERO).count();
        p.drain(..zeros);
        let mut add = |value: Complex, multiplicity| {
            let kernel = self.kernel(&value, bits)?;
            // A root has a vector.
            (!kernel.is_empty()).then(|| {
                roots.push(Root { value, multiplicity, kernel });
            })
        };
        if zeros > 0 {
            add(Complex::zero(bits), zeros)?;
        }
        for (k, factor) in squarefree(p).into_iter().enumerate() {
            // With z on the imaginary axis conj z = -z is a root, too.
            let even = gcd(factor.clone(), mirrored(&factor));
            let (odd, _) = divided(factor, &even);
            for (polynomial, mirrored) in [(even, true), (odd, false)] {
                for (value, radius) in zeros_of(&polynomial, bits)? {
                    let near = |x: &Real| abs(x) <= radius;
                    // The mirror image of the only root in a disc is in it: it is the root itself.
                    let re = if mirrored && near(&value.re) { integer(0, bits) } else { value.re.clone() };
                    let im = if near(&value.im) { integer(0, bits) } else { value.im.clone() };
                    if !is_negative(&im) {
                        add(Complex::new(re, im), k + 1)?;
                    }
                }
            }
        }
        Some(roots)
    }

    /// The kernel of s²M + sB + S by elimination with complete pivoting. What is left of rounding and what is
    /// not has to be far apart.
    fn kernel(&self, s: &Complex, bits: usize) -> Option<Vec<Vec<Complex>>> {
        let n = self.mass.len();
        let number = |x: &RBig| Complex::new(real(x, bits), integer(0, bits));
        let entry = |i: usize, j: usize| {
            let inner = number(&self.mass[i][j]).times(s);
            let middle = inner.plus(&number(&self.velocity[i][j])).times(s);
            middle.plus(&number(&self.position[i][j]))
        };
        let mut a: Vec<Vec<Complex>> = (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect();
        let mut order: Vec<usize> = (0..n).collect();
        // Of the three parts, which may cancel.
        let part = |a: &Exact, power: isize| {
            let entries = a.iter().flatten().filter(|x| **x != RBig::ZERO);
            let sizes = entries.map(|x| log2(&real(x, bits)) + power * s.log2());
            sizes.max().unwrap_or(isize::MIN / 4)
        };
        let size = part(&self.mass, 2).max(part(&self.velocity, 1)).max(part(&self.position, 0));
        let mut rank = n;
        for k in 0..n {
            let places = (k..n).flat_map(|i| (k..n).map(move |j| (i, j)));
            let (i, j) = places.max_by_key(|(i, j)| a[*i][*j].log2())?;
            let pivot = a[i][j].log2();
            if a[i][j].is_zero() || pivot < size - bits as isize / 2 {
                rank = k;
                break;
            }
            if pivot < size - bits as isize / 4 {
                return None;
            }
            a.swap(i, k);
            order.swap(j, k);
            a.iter_mut().for_each(|row| row.swap(j, k));
            // Gauss-Jordan: the pivot's column is cleared above, too.
            let pivot_row: Vec<Complex> = a[k].iter().map(|x| x.over(&a[k][k])).collect();
            for (i, row) in a.iter_mut().enumerate() {
                if i == k {
                    *row = pivot_row.clone();
                    continue;
                }
                let factor = row[k].clone();
                if !factor.is_zero() {
                    for (x, y) in row.iter_mut().zip(&pivot_row).skip(k) {
                        *x = x.minus(&factor.times(y));
                    }
                }
            }
        }
        let vector = |free: usize| {
            let mut x = vec![Complex::zero(bits); n];
            x[order[free]].re = integer(1, bits);
            for (row, own) in a.iter().take(rank).zip(&order) {
                x[*own] = Complex::zero(bits).minus(&row[free]);
            }
            x
        };
        Some((rank..n).map(vector).collect())
    }
}

/// By elimination, with its rank.
fn eliminated(mut a: Exact) -> (RBig, usize) {
    let n = a.len();
    let (mut determinant, mut rank) = (RBig::ONE, 0);
    for column in 0..n {
        let Some(at) = (rank..n).find(|i| a[*i][column] != RBig::ZERO) else {
            determinant = RBig::ZERO;
            continue;
        };
        if at != rank {
            a.swap(at, rank);
            determinant = -determinant;
        }
        determinant *= &a[rank][column];
        let (above, below) = a.split_at_mut(rank + 1);
        let pivot = &above[rank];
        for row in below {
            if row[column] == RBig::ZERO {
                continue;
            }
            let factor = &row[column] / &pivot[column];
            for (x, y) in row.iter_mut().zip(pivot).skip(column) {
                *x -= &factor * y;
            }
        }
        rank += 1;
    }
    (determinant, rank)
}

fn determinant(a: Exact) -> RBig {
    eliminated(a).0
}

fn rank(a: Exact) -> usize {
    eliminated(a).1
}

fn trimmed(mut p: Polynomial) -> Polynomial {
    while p.last().is_some_and(|c| *c == RBig::ZERO) {
        p.pop();
    }
    p
}

fn derivative(p: &Polynomial) -> Polynomial {
    let terms = p.iter().enumerate().skip(1);
    terms.map(|(k, c)| c * RBig::from(k)).collect()
}

/// p(-s)
fn mirrored(p: &Polynomial) -> Polynomial {
    let terms = p.iter().enumerate();
    terms.map(|(k, c)| if k % 2 == 0 { c.clone() } else { -c }).collect()
}

fn minus(a: &Polynomial, b: &Polynomial) -> Polynomial {
    let zero = RBig::ZERO;
    let entry = |p: &Polynomial, k: usize| p.get(k).unwrap_or(&zero).clone();
    let terms = 0..a.len().max(b.len());
    trimmed(terms.map(|k| entry(a, k) - entry(b, k)).collect())
}

/// Quotient and remainder.
fn divided(mut p: Polynomial, by: &Polynomial) -> (Polynomial, Polynomial) {
    let Some(top) = by.last() else {
        return (Vec::new(), p);
    };
    let mut quotient = vec![RBig::ZERO; (p.len() + 1).saturating_sub(by.len())];
    while p.len() >= by.len() {
        let shift = p.len() - by.len();
        let Some(last) = p.pop() else { break };
        let factor = last / top;
        for (x, y) in p[shift..].iter_mut().zip(by) {
            *x -= &factor * y;
        }
        quotient[shift] = factor;
        p = trimmed(p);
    }
    (quotient, p)
}

/// With leading coefficient 1.
fn gcd(mut a: Polynomial, mut b: Polynomial) -> Polynomial {
    while !b.is_empty() {
        let (_, rest) = divided(a, &b);
        a = b;
        b = monic(rest);
    }
    monic(a)
}

fn monic(p: Polynomial) -> Polynomial {
    let Some(top) = p.last().cloned() else {
        return p;
    };
    p.into_iter().map(|c| c / &top).collect()
}

/// f₁, f₂, … without repeated roots, p = f₁ f₂² f₃³ … (Yun 1976).
fn squarefree(p: Polynomial) -> Vec<Polynomial> {
    let slope = derivative(&p);
    let common = gcd(p.clone(), slope.clone());
    let mut b = divided(p, &common).0;
    let mut d = minus(&divided(slope, &common).0, &derivative(&b));
    let mut factors = Vec::new();
    while b.len() > 1 {
        let factor = gcd(b.clone(), d.clone());
        b = divided(b, &factor).0;
        d = minus(&divided(d, &factor).0, &derivative(&b));
        factors.push(factor);
    }
    factors
}

/// p and its derivative at a point.
fn value(p: &[Real], z: &Complex, bits: usize) -> (Complex, Complex) {
    let (mut value, mut slope) = (Complex::zero(bits), Complex::zero(bits));
    for c in p.iter().rev() {
        slope = slope.times(z).plus(&value);
        value = value.times(z);
        value.re += c;
    }
    (value, slope)
}

/// The roots of a polynomial without repeated ones, each with the radius of a disc that holds it and no
/// other: Aberth's simultaneous iteration from the radii of Newton's polygon; a disc of radius n |p/p'|
/// holds a root.
fn zeros_of(p: &Polynomial, bits: usize) -> Option<Vec<(Complex, Real)>> {
    let n = p.len().saturating_sub(1);
    let p: Vec<Real> = p.iter().map(|c| real(c, bits)).collect();
    let mut z = starts(&p, bits);
    let precise = bits as isize * 3 / 4;
    let mut steps = 0;
    while steps < 500 {
        let mut moved = false;
        for k in 0..n {
            let (value, slope) = value(&p, &z[k], bits);
            if value.is_zero() {
                continue;
            }
            // p / (p' - p Σ 1/(z - z_j))
            let mut away = Complex::zero(bits);
            for (j, other) in z.iter().enumerate() {
                if j != k {
                    let one = Complex::new(integer(1, bits), integer(0, bits));
                    away = away.plus(&one.over(&z[k].minus(other)));
                }
            }
            let step = value.over(&slope.minus(&value.times(&away)));
            moved |= step.log2() > z[k].log2() - precise;
            z[k] = z[k].minus(&step);
        }
        if !moved {
            break;
        }
        steps += 1;
    }
    let discs: Vec<(Complex, Real)> = z
        .into_iter()
        .map(|z| {
            let (value, slope) = value(&p, &z, bits);
            let length = sqrt(&value.over(&slope).square()) * integer(n as i64, bits);
            // What rounding of the values leaves out.
            let rounding = scale(&sqrt(&z.square()), -precise);
            (z, length + rounding)
        })
        .collect();
    let apart = |i: usize, j: usize| {
        let (a, b) = (&discs[i], &discs[j]);
        // Mirror images of a disc are not met either.
        let reach = scale(&(&a.1 + &b.1), 8);
        a.0.minus(&b.0).square() > &reach * &reach
    };
    let all = (0..n).all(|i| (0..i).all(|j| apart(i, j)));
    (all && steps < 500).then_some(discs)
}

/// On circles whose radii are the slopes of the upper hull of log |c_k| (Bini 1996).
fn starts(p: &[Real], bits: usize) -> Vec<Complex> {
    let points: Vec<(isize, isize)> =
        p.iter().enumerate().filter(|(_, c)| !is_zero(c)).map(|(k, c)| (k as isize, log2(c))).collect();
    let mut hull: Vec<(isize, isize)> = Vec::new();
    for point in points {
        while let [.., a, b] = hull[..] {
            // b lies below the line from a to the point.
            if (b.1 - a.1) * (point.0 - a.0) > (point.1 - a.1) * (b.0 - a.0) {
                break;
            }
            hull.pop();
        }
        hull.push(point);
    }
    let mut z = Vec::new();
    for side in hull.windows(2) {
        let count = side[1].0 - side[0].0;
        let radius = (side[0].1 - side[1].1) as f64 / count as f64;
        for k in 0..count {
            let angle = std::f64::consts::TAU * k as f64 / count as f64 + 0.7 + z.len() as f64;
            let unit = |x: f64| real(&exact(x * radius.fract().exp2()), bits);
            let scaled = |x: f64| scale(&unit(x), radius.trunc() as isize);
            z.push(Complex::new(scaled(angle.cos()), scaled(angle.sin())));
        }
    }
    z
}
