//! Eigenvalues of K x = λ M x by means that have nothing in common with the library: Cholesky,
//! Householder and implicit QL in big floats for the true values, and Sturm counts of K - σM itself.

use dashu_ratio::RBig;

use super::real::*;

pub(crate) type Square = Vec<Vec<Real>>;

/// M and K at some number of bits.
pub(crate) struct Matrices {
    pub(crate) mass: Square,
    pub(crate) stiffness: Square,
}

/// Bits of the first attempt; it doubles until nothing is ambiguous.
pub(crate) const BITS: usize = 768;
/// What lies below 2^-CLEAR of the largest eigenvalue is zero, and what differs by less is equal: no
/// drawn number is that small.
const CLEAR: isize = 384;
/// Shifts keep this relative distance from eigenvalues and from the ends of intervals.
pub(crate) const AWAY: isize = 300;

pub(crate) fn to_reals(a: &[Vec<RBig>], bits: usize) -> Square {
    a.iter().map(|row| row.iter().map(|x| real(x, bits)).collect()).collect()
}

/// All eigenvalues, rising; proved neither to be zero nor to be equal, but told apart where they
/// differ by more than rounding. `None`: more bits are needed, or M is not positive definite.
pub(crate) struct Truth {
    pub(crate) values: Vec<Real>,
    /// Neighbours with the same number are equal.
    pub(crate) group: Vec<usize>,
    /// Which group is zero.
    pub(crate) zero: Option<usize>,
}

impl Truth {
    pub(crate) fn new(matrices: &Matrices, bits: usize) -> Option<Self> {
        let mut values = eigenvalues(matrices, bits)?;
        values.sort();
        let size = values.iter().map(log2).max().unwrap_or(0);
        let mut group = Vec::new();
        let mut zero = None;
        let mut number = 0;
        for k in 0..values.len() {
            let own = log2(&values[k]) - size;
            let vanishes = is_zero(&values[k]) || own < -CLEAR;
            // Between what rounding leaves and what is drawn there has to be nothing.
            if !is_zero(&values[k]) && (-CLEAR - 60..-CLEAR + 60).contains(&own) {
                return None;
            }
            if k > 0 {
                let step = log2(&(&values[k] - &values[k - 1]));
                let same = step < log2(&values[k]) - CLEAR || vanishes && zero == Some(number);
                number += usize::from(!same);
            }
            if vanishes {
                zero = Some(number);
            }
            group.push(number);
        }
        if let Some(zero) = zero {
            for (value, number) in values.iter_mut().zip(&group) {
                if *number == zero {
                    *value = integer(0, bits);
                }
            }
        }
        Some(Self { values, group, zero })
    }

    pub(crate) fn zeros(&self) -> usize {
        self.group.iter().filter(|g| Some(**g) == self.zero).count()
    }

    /// A shift beside the k-th eigenvalue, much nearer than any other but not on it.
    pub(crate) fn beside(&self, k: usize, bits: usize) -> Real {
        let least = |values: &[Real]| {
            let all = values.iter().filter(|x| !is_zero(x)).map(log2);
            all.min().unwrap_or(0)
        };
        if is_zero(&self.values[k]) {
            scale(&integer(1, bits), least(&self.values) - AWAY)
        } else {
            &self.values[k] + scale(&self.values[k], -AWAY)
        }
    }
}

fn eigenvalues(matrices: &Matrices, bits: usize) -> Option<Vec<Real>> {
    let n = matrices.mass.len();
    // M = L Lᵀ
    let mut l = matrices.mass.clone();
    for j in 0..n {
        for k in 0..j {
            if is_zero(&l[j][k]) {
                continue;
            }
            let left = l[j][k].clone();
            for row in l.iter_mut().skip(j) {
                let product = &row[k] * &left;
                row[j] -= product;
            }
        }
        if is_negative(&l[j][j]) || is_zero(&l[j][j]) {
            return None;
        }
        let root = sqrt(&l[j][j]);
        for row in l.iter_mut().skip(j + 1) {
            row[j] = &row[j] / &root;
        }
        l[j][j] = root;
    }
    // L⁻¹ K, then its transpose once more.
    let mut c = matrices.stiffness.clone();
    for _ in 0..2 {
        for i in 0..n {
            for k in 0..i {
                if is_zero(&l[i][k]) {
                    continue;
                }
                let (above, below) = c.split_at_mut(i);
                for (x, y) in below[0].iter_mut().zip(&above[k]) {
                    *x -= &l[i][k] * y;
                }
            }
            for x in &mut c[i] {
                *x = &*x / &l[i][i];
            }
        }
        c = transposed(&c);
    }
    let (mut diagonal, mut off) = tridiagonal(c, bits);
    ql(&mut diagonal, &mut off, bits).then_some(diagonal)
}

fn transposed(a: &Square) -> Square {
    (0..a.len()).map(|j| a.iter().map(|row| row[j].clone()).collect()).collect()
}

/// Householder's reduction, column by column.
fn tridiagonal(mut a: Square, bits: usize) -> (Vec<Real>, Vec<Real>) {
    let n = a.len();
    let zero = integer(0, bits);
    let mut off = Vec::new();
    for k in 0..n.saturating_sub(1) {
        let mut v: Vec<Real> = (k + 1..n).map(|i| a[i][k].clone()).collect();
        let rest = v[1..].iter().fold(zero.clone(), |s, x| s + x * x);
        if is_zero(&rest) {
            off.push(v[0].clone());
            continue;
        }
        let length = sqrt(&(&rest + &v[0] * &v[0]));
        let alpha = if is_negative(&v[0]) { length } else { -length };
        v[0] -= &alpha;
        let square = &rest + &v[0] * &v[0];
        off.push(alpha);
        let factor = integer(2, bits) / square;
        let m = v.len();
        // p = factor A v, q = p - (factor vᵀp / 2) v, A - v qᵀ - q vᵀ
        let mut p: Vec<Real> =
            (0..m).map(|i| (0..m).fold(zero.clone(), |s, j| s + &a[k + 1 + i][k + 1 + j] * &v[j]) * &factor).collect();
        let inner = p.iter().zip(&v).fold(zero.clone(), |s, (x, y)| s + x * y);
        let half = inner * &factor / integer(2, bits);
        for (x, y) in p.iter_mut().zip(&v) {
            *x -= &half * y;
        }
        for i in 0..m {
            for j in 0..=i {
                let change = &v[i] * &p[j] + &p[i] * &v[j];
                let entry = &a[k + 1 + i][k + 1 + j] - change;
                a[k + 1 + j][k + 1 + i] = entry.clone();
                a[k + 1 + i][k + 1 + j] = entry;
            }
        }
    }
    ((0..n).map(|i| a[i][i].clone()).collect(), off)
}

/// Implicit QL with Wilkinson's shift; whether it converged.
fn ql(d: &mut [Real], off: &mut Vec<Real>, bits: usize) -> bool {
    let n = d.len();
    off.push(integer(0, bits));
    let one = integer(1, bits);
    let norm = d.iter().chain(off.iter()).map(log2).max().unwrap_or(0);
    for l in 0..n {
        for _ in 0..200 {
            let negligible = |m: usize| {
                let beside = log2(&d[m]).max(log2(&d[m + 1]));
                log2(&off[m]) < beside.max(norm - 200) - bits as isize
            };
            let m = (l..n - 1).find(|m| negligible(*m)).unwrap_or(n - 1);
            if m == l {
                break;
            }
            let mut g = (&d[l + 1] - &d[l]) / (integer(2, bits) * &off[l]);
            let mut r = sqrt(&(&g * &g + &one));
            let signed = if is_negative(&g) { -&r } else { r.clone() };
            g = &d[m] - &d[l] + &off[l] / (&g + signed);
            let (mut s, mut c, mut p) = (one.clone(), one.clone(), integer(0, bits));
            let mut broken = false;
            for i in (l..m).rev() {
                let f = &s * &off[i];
                let b = &c * &off[i];
                r = sqrt(&(&f * &f + &g * &g));
                off[i + 1] = r.clone();
                if is_zero(&r) {
                    d[i + 1] -= &p;
                    off[m] = integer(0, bits);
                    broken = true;
                    break;
                }
                s = &f / &r;
                c = &g / &r;
                g = &d[i + 1] - &p;
                r = (&d[i] - &g) * &s + integer(2, bits) * &c * &b;
                p = &s * &r;
                d[i + 1] = &g + &p;
                g = &c * &r - &b;
            }
            if broken {
                continue;
            }
            d[l] -= &p;
            off[l] = g;
            off[m] = integer(0, bits);
        }
        if l + 1 < n && log2(&off[l]) > norm - bits as isize / 2 {
            return false;
        }
    }
    true
}

/// K - σM = L D Lᵀ without pivoting.
pub(crate) struct Factors {
    /// The rows of L below the diagonal.
    lower: Square,
    pivots: Vec<Real>,
}

impl Factors {
    /// `None` where pivots are too small for the number of bits.
    pub(crate) fn new(matrices: &Matrices, shift: &Real, bits: usize) -> Option<Self> {
        let n = matrices.mass.len();
        let mut a: Square = (0..n)
            .map(|i| (0..=i).map(|j| &matrices.stiffness[i][j] - shift * &matrices.mass[i][j]).collect())
            .collect();
        let size: Vec<isize> = (0..n).map(|i| log2(&a[i][i])).collect();
        let mut pivots = Vec::new();
        for k in 0..n {
            let pivot = a[k][k].clone();
            // A cancellation of so many bits leaves too few.
            if is_zero(&pivot) || log2(&pivot) < size[k] - bits as isize * 3 / 4 {
                return None;
            }
            let column: Vec<Real> = (k + 1..n).map(|i| a[i][k].clone()).collect();
            for (i, x) in (k + 1..n).zip(&column) {
                if is_zero(x) {
                    continue;
                }
                let factor = x / &pivot;
                for (j, y) in (k + 1..=i).zip(&column) {
                    if !is_zero(y) {
                        let product = &factor * y;
                        a[i][j] -= product;
                    }
                }
                a[i][k] = factor;
            }
            pivots.push(pivot);
        }
        Some(Self { lower: a, pivots })
    }

    /// How many eigenvalues lie below the shift (Sylvester).
    pub(crate) fn below(&self) -> usize {
        self.pivots.iter().filter(|x| is_negative(x)).count()
    }

    pub(crate) fn solve(&self, right: &[Real]) -> Vec<Real> {
        let n = right.len();
        let mut x = right.to_vec();
        for i in 0..n {
            for j in 0..i {
                if !is_zero(&self.lower[i][j]) {
                    let product = &self.lower[i][j] * &x[j];
                    x[i] -= product;
                }
            }
        }
        for (value, pivot) in x.iter_mut().zip(&self.pivots) {
            *value = &*value / pivot;
        }
        for i in (0..n).rev() {
            for j in 0..i {
                if !is_zero(&self.lower[i][j]) {
                    let product = &self.lower[i][j] * &x[i];
                    x[j] -= product;
                }
            }
        }
        x
    }
}

pub(crate) fn times(a: &Square, x: &[Real], bits: usize) -> Vec<Real> {
    a.iter()
        .map(|row| {
            let mut sum = integer(0, bits);
            for (y, z) in row.iter().zip(x) {
                if !is_zero(y) && !is_zero(z) {
                    sum += y * z;
                }
            }
            sum
        })
        .collect()
}

pub(crate) fn inner(a: &[Real], b: &[Real], bits: usize) -> Real {
    a.iter().zip(b).fold(integer(0, bits), |s, (x, y)| s + x * y)
}
