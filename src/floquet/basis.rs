//! Eigenvectors of a small matrix, by two ways: in doubles, and by the QR algorithm at any precision. Nothing here has bounds;
//! what comes out is taken as exactly what it is by who asks for it.

use faer::{Mat, c64};

use crate::precision::{Complex, Enclosure, Magnitude, hypot};

/// Sweeps of the QR algorithm for one eigenvalue: three or four do up to 16 digits, and each beyond doubles them.
const SWEEPS: usize = 60;
/// After as many without an eigenvalue a shift of another kind is tried.
const STUCK: usize = 12;

/// About the eigenvalues of a matrix, its eigenvectors, and their inverse; matrices row by row, all of them exact numbers.
pub(super) struct Basis<S> {
    pub(super) values: Vec<Complex<S>>,
    pub(super) vectors: Vec<Complex<S>>,
    pub(super) inverse: Vec<Complex<S>>,
}

impl<S: Enclosure> Basis<S> {
    /// In doubles.
    pub(super) fn quick(matrix: &[S], n: usize, precision: S::Precision) -> Option<Self> {
        // Beyond the range of doubles there are no vectors in doubles.
        if !matrix.iter().all(|x| x.middle().is_finite()) {
            return None;
        }
        let middle = Mat::from_fn(n, n, |i, j| matrix[n * i + j].middle());
        let eigen = middle.eigen().ok()?;
        let (values, vectors) = (eigen.S(), eigen.U());
        let inverse = nalgebra::DMatrix::from_fn(n, n, |i, j| vectors[(i, j)]).try_inverse()?;
        let entries = |of: &dyn Fn(usize, usize) -> c64| -> Option<Vec<Complex<S>>> {
            let all = (0..n * n).map(|at| of(at / n, at % n));
            all.map(|x| x.is_finite().then(|| Complex::from_c64(x, precision))).collect()
        };
        Some(Self {
            values: (0..n).map(|j| Complex::from_c64(values[j], precision)).collect(),
            vectors: entries(&|i, j| vectors[(i, j)])?,
            inverse: entries(&|i, j| inverse[(i, j)])?,
        })
    }

    /// At the precision of the entries: Schur's form by the QR algorithm with Wilkinson's shifts, then vectors by back
    /// substitution (G. H. Golub and C. F. Van Loan, Matrix Computations, 4th ed. (2013), §7.5 and §7.6).
    pub(super) fn careful(matrix: &[S], n: usize, precision: S::Precision) -> Option<Self> {
        let schur = Schur::new(matrix, n, precision)?;
        let vectors = schur.vectors();
        let inverse = inverse(&vectors, n, precision)?;
        let values = (0..n).map(|k| schur.form[n * k + k].clone()).collect();
        Some(Self { values, vectors, inverse })
    }
}

/// A = Z T Z* with T upper triangular and Z unitary.
struct Schur<S: Enclosure> {
    n: usize,
    precision: S::Precision,
    form: Vec<Complex<S>>,
    basis: Vec<Complex<S>>,
}

/// The turn of two components by c, s that takes (x, y) to (r, 0).
struct Turn<S> {
    cosine: S,
    sine: Complex<S>,
}

impl<S: Enclosure> Turn<S> {
    fn new(x: &Complex<S>, y: &Complex<S>, precision: S::Precision) -> Option<Self> {
        // Of like size before they are squared.
        let (_, exponent) = hypot(x.upper_bound(), y.upper_bound()).parts();
        let (x, y) = (x.scale(-exponent), y.scale(-exponent));
        let (own, other) = (x.square_of_modulus().center(), y.square_of_modulus());
        if !other.is_positive() {
            return None;
        }
        let length = own.add(&other).center().sqrt().center();
        if !own.is_positive() {
            let sine = y.conjugate().times(&S::exact(1.0, precision).div(&length));
            return Some(Self { cosine: S::exact(0.0, precision), sine: sine.center() });
        }
        let own = own.sqrt().center();
        let share = S::exact(1.0, precision).div(&own.mul(&length).center());
        Some(Self { cosine: own.div(&length).center(), sine: x.mul(&y.conjugate()).times(&share).center() })
    }
}

impl<S: Enclosure> Schur<S> {
    fn new(matrix: &[S], n: usize, precision: S::Precision) -> Option<Self> {
        let zero = S::exact(0.0, precision);
        let form = matrix.iter().map(|x| Complex::new(x.center(), zero.clone()));
        let unit = |at: usize| Complex::real(f64::from(u8::from(at / n == at % n)), precision);
        let mut schur = Self { n, precision, form: form.collect(), basis: (0..n * n).map(unit).collect() };
        schur.hessenberg();
        schur.triangular().then_some(schur)
    }

    fn entry(&self, i: usize, j: usize) -> &Complex<S> {
        &self.form[self.n * i + j]
    }

    /// The same turn of rows i and i + 1 and, to the other side, of the columns.
    fn turn(&mut self, i: usize, turn: &Turn<S>) {
        let n = self.n;
        let (c, s) = (&turn.cosine, &turn.sine);
        let pair = |x: &Complex<S>, y: &Complex<S>, s: &Complex<S>| {
            let first = x.times(c).add(&s.mul(y)).center();
            let second = y.times(c).sub(&s.conjugate().mul(x)).center();
            (first, second)
        };
        for j in 0..n {
            let (above, below) = (n * i + j, n * (i + 1) + j);
            let (first, second) = pair(&self.form[above], &self.form[below], s);
            (self.form[above], self.form[below]) = (first, second);
        }
        let mirrored = s.conjugate();
        for matrix in [&mut self.form, &mut self.basis] {
            for row in matrix.chunks_exact_mut(n) {
                let (first, second) = pair(&row[i], &row[i + 1], &mirrored);
                (row[i], row[i + 1]) = (first, second);
            }
        }
    }

    fn annihilate(&mut self, row: usize, column: usize) {
        let (x, y) = (self.entry(row, column), self.entry(row + 1, column));
        if let Some(turn) = Turn::new(x, y, self.precision) {
            self.turn(row, &turn);
        }
        let zero = Complex::zero(self.precision);
        self.form[self.n * (row + 1) + column] = zero;
    }

    fn hessenberg(&mut self) {
        for column in 0..self.n.saturating_sub(2) {
            for row in (column + 1..self.n - 1).rev() {
                self.annihilate(row, column);
            }
        }
    }

    /// Whether an entry below the diagonal is nothing beside those on it.
    fn is_negligible(&self, row: usize) -> bool {
        let beside = self.entry(row - 1, row - 1).upper_bound() + self.entry(row, row).upper_bound();
        let rounding = Magnitude::from_f64(S::rounding(self.precision));
        self.entry(row, row - 1).upper_bound() <= beside * rounding
    }

    fn triangular(&mut self) -> bool {
        let mut last = self.n.saturating_sub(1);
        let mut sweeps = 0;
        while last > 0 {
            let mut first = last;
            while first > 0 && !self.is_negligible(first) {
                first -= 1;
            }
            if first > 0 {
                let zero = Complex::zero(self.precision);
                self.form[self.n * first + first - 1] = zero;
            }
            if first == last {
                last -= 1;
                sweeps = 0;
                continue;
            }
            sweeps += 1;
            if sweeps > SWEEPS {
                return false;
            }
            let shift = if sweeps % STUCK == 0 {
                self.entry(last, last).add(self.entry(last, last - 1))
            } else {
                self.shift(last)
            };
            self.sweep(first, last, &shift.center());
        }
        self.form.iter().all(Complex::is_finite)
    }

    /// The eigenvalue of the last two rows and columns that is nearer to the last entry.
    fn shift(&self, last: usize) -> Complex<S> {
        let (a, b) = (self.entry(last - 1, last - 1), self.entry(last - 1, last));
        let (c, d) = (self.entry(last, last - 1), self.entry(last, last));
        let half = a.sub(d).scale(-1).center();
        let product = b.mul(c).center();
        let root = half.mul(&half).add(&product).center().root(self.precision);
        let (plus, minus) = (half.add(&root).center(), half.sub(&root).center());
        let larger = if plus.upper_bound() < minus.upper_bound() { minus } else { plus };
        if larger.upper_bound().is_zero() {
            return d.clone();
        }
        d.sub(&product.mul(&larger.inverse()))
    }

    /// One step with a shift, implicitly: the first turn is that of A - shift, the others bring the matrix back to its form.
    fn sweep(&mut self, first: usize, last: usize, shift: &Complex<S>) {
        let x = self.entry(first, first).sub(shift).center();
        let turn = Turn::new(&x, self.entry(first + 1, first), self.precision);
        if let Some(turn) = turn {
            self.turn(first, &turn);
        }
        for row in first + 1..last {
            self.annihilate(row, row - 1);
        }
    }

    fn vectors(&self) -> Vec<Complex<S>> {
        let n = self.n;
        let largest = self.form.iter().map(Complex::upper_bound);
        let largest = largest.fold(Magnitude::ZERO, Magnitude::max);
        let least = largest * Magnitude::from_f64(S::rounding(self.precision));
        let mut vectors = vec![Complex::zero(self.precision); n * n];
        for k in 0..n {
            let value = self.entry(k, k);
            let mut own = vec![Complex::real(1.0, self.precision); k + 1];
            for i in (0..k).rev() {
                let mut sum = Complex::zero(self.precision);
                for (j, x) in own.iter().enumerate().skip(i + 1) {
                    sum = sum.add(&self.entry(i, j).mul(x));
                }
                let mut gap = value.sub(self.entry(i, i)).center();
                if gap.upper_bound() < least {
                    gap.re = S::from_size(least, self.precision);
                }
                own[i] = sum.mul(&gap.inverse()).center();
            }
            let column: Vec<Complex<S>> = (0..n)
                .map(|i| {
                    let products = own.iter().enumerate();
                    let zero = Complex::zero(self.precision);
                    products.fold(zero, |sum, (j, x)| sum.add(&self.basis[n * i + j].mul(x)))
                })
                .collect();
            let size = column.iter().map(Complex::upper_bound);
            let (_, exponent) = size.fold(Magnitude::ZERO, Magnitude::max).parts();
            for (i, x) in column.iter().enumerate() {
                vectors[n * i + k] = x.scale(-exponent).center();
            }
        }
        vectors
    }
}

/// About the inverse of a complex matrix, row by row: by elimination with exchanges of rows, with midpoints.
pub(super) fn inverse<S: Enclosure>(
    matrix: &[Complex<S>],
    n: usize,
    precision: S::Precision,
) -> Option<Vec<Complex<S>>> {
    let mut left: Vec<Vec<Complex<S>>> = matrix.chunks_exact(n).map(<[_]>::to_vec).collect();
    let mut right: Vec<Vec<Complex<S>>> =
        (0..n).map(|i| (0..n).map(|j| Complex::real(f64::from(u8::from(i == j)), precision)).collect()).collect();
    for k in 0..n {
        let mut pivot = k;
        for i in k + 1..n {
            if left[pivot][k].upper_bound() < left[i][k].upper_bound() {
                pivot = i;
            }
        }
        if left[pivot][k].upper_bound().is_zero() {
            return None;
        }
        left.swap(k, pivot);
        right.swap(k, pivot);
        let by = left[k][k].center().inverse().center();
        for rows in [&mut left, &mut right] {
            for entry in &mut rows[k] {
                *entry = entry.mul(&by).center();
            }
        }
        let pivots = [left[k].clone(), right[k].clone()];
        for i in (0..n).filter(|i| *i != k) {
            let factor = left[i][k].clone();
            for (rows, pivot) in [&mut left, &mut right].into_iter().zip(&pivots) {
                for (entry, own) in rows[i].iter_mut().zip(pivot) {
                    *entry = entry.sub(&factor.mul(own)).center();
                }
            }
        }
    }
    let entries: Vec<Complex<S>> = right.into_iter().flatten().collect();
    entries.iter().all(Complex::is_finite).then_some(entries)
}
