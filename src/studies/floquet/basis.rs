//! Eigenvectors of a small matrix, by two ways: in doubles, and by the QR algorithm at any precision. Nothing here has bounds;
//! what comes out is taken as exactly what it is by who asks for it.

use faer::{Mat, c64};

use librate_core::precision::{Complex, Enclosure, Magnitude, Matrix, clear_column, hypot};

/// Sweeps of the QR algorithm for one eigenvalue: three or four do up to 16 digits, and each beyond doubles them.
const SWEEPS: usize = 60;
/// After as many without an eigenvalue a shift of another kind is tried.
const STUCK: usize = 12;

/// About the eigenvalues of a matrix, its eigenvectors, and their inverse, all of them exact numbers.
pub(super) struct Basis<S> {
    pub(super) values: Vec<Complex<S>>,
    pub(super) vectors: Matrix<Complex<S>>,
    pub(super) inverse: Matrix<Complex<S>>,
}

impl<S: Enclosure> Basis<S> {
    /// In doubles.
    pub(super) fn quick(matrix: &[S], n: usize, precision: S::Precision) -> Option<Self> {
        // Beyond the range of doubles there are no vectors in doubles.
        if !matrix.iter().all(|x| x.mid_f64().is_finite()) {
            return None;
        }
        let eigen = Mat::from_fn(n, n, |i, j| matrix[n * i + j].mid_f64()).eigen().ok()?;
        let (values, vectors) = (eigen.S(), eigen.U());
        let inverse = nalgebra::DMatrix::from_fn(n, n, |i, j| vectors[(i, j)]).try_inverse()?;
        let exact = |of: &dyn Fn(usize, usize) -> c64| {
            let matrix = Matrix::from_fn(n, n, |i, j| Complex::from_c64(of(i, j), precision));
            matrix.entries().iter().all(Complex::is_finite).then_some(matrix)
        };
        Some(Self {
            values: (0..n).map(|j| Complex::from_c64(values[j], precision)).collect(),
            vectors: exact(&|i, j| vectors[(i, j)])?,
            inverse: exact(&|i, j| inverse[(i, j)])?,
        })
    }

    /// At the precision of the entries: Schur's form by the QR algorithm with Wilkinson's shifts, then vectors by back
    /// substitution (G. H. Golub and C. F. Van Loan, Matrix Computations, 4th ed. (2013), §7.5 and §7.6).
    pub(super) fn careful(matrix: &[S], n: usize, precision: S::Precision) -> Option<Self> {
        let schur = Schur::new(matrix, n, precision)?;
        let vectors = schur.vectors();
        let inverse = inverse(&vectors, precision)?;
        let values = (0..n).map(|k| schur.form[(k, k)].clone()).collect();
        Some(Self { values, vectors, inverse })
    }
}

/// A = Z T Z* with T upper triangular and Z unitary.
struct Schur<S: Enclosure> {
    n: usize,
    precision: S::Precision,
    form: Matrix<Complex<S>>,
    basis: Matrix<Complex<S>>,
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
        let form = Matrix::from_fn(n, n, |i, j| Complex::new(matrix[n * i + j].center(), zero.clone()));
        let mut schur = Self { n, precision, form, basis: Matrix::unit(n, precision) };
        schur.hessenberg();
        schur.triangular().then_some(schur)
    }

    fn entry(&self, i: usize, j: usize) -> &Complex<S> {
        &self.form[(i, j)]
    }

    /// The same turn of rows i and i + 1 and, to the other side, of the columns.
    fn turn(&mut self, i: usize, turn: &Turn<S>) {
        let (c, s) = (&turn.cosine, &turn.sine);
        let pair = |x: &Complex<S>, y: &Complex<S>, s: &Complex<S>| {
            let first = x.times(c).add(&s.mul(y)).center();
            (first, y.times(c).sub(&s.conjugate().mul(x)).center())
        };
        for j in 0..self.n {
            let (above, below) = ((i, j), (i + 1, j));
            let (first, second) = pair(&self.form[above], &self.form[below], s);
            (self.form[above], self.form[below]) = (first, second);
        }
        let mirrored = s.conjugate();
        for matrix in [&mut self.form, &mut self.basis] {
            for row in 0..self.n {
                let (left, right) = ((row, i), (row, i + 1));
                let (first, second) = pair(&matrix[left], &matrix[right], &mirrored);
                (matrix[left], matrix[right]) = (first, second);
            }
        }
    }

    fn annihilate(&mut self, row: usize, column: usize) {
        let (x, y) = (self.entry(row, column), self.entry(row + 1, column));
        if let Some(turn) = Turn::new(x, y, self.precision) {
            self.turn(row, &turn);
        }
        self.form[(row + 1, column)] = Complex::zero(self.precision);
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
                self.form[(first, first - 1)] = Complex::zero(self.precision);
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
        self.form.entries().iter().all(Complex::is_finite)
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
        if larger.upper_bound().is_zero() { d.clone() } else { d.sub(&product.mul(&larger.inverse())) }
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

    fn vectors(&self) -> Matrix<Complex<S>> {
        let n = self.n;
        let largest = self.form.entries().iter().map(Complex::upper_bound);
        let largest = largest.fold(Magnitude::ZERO, Magnitude::max);
        let least = largest * Magnitude::from_f64(S::rounding(self.precision));
        let mut vectors = Matrix::unit(n, self.precision);
        for k in 0..n {
            let value = self.entry(k, k);
            let mut own = vec![Complex::real(1.0, self.precision); n];
            own[k + 1..].fill(Complex::zero(self.precision));
            for i in (0..k).rev() {
                let others = own.iter().enumerate().take(k + 1).skip(i + 1);
                let sum = others.fold(Complex::zero(self.precision), |sum, (j, x)| sum.add(&self.entry(i, j).mul(x)));
                let mut gap = value.sub(self.entry(i, i)).center();
                if gap.upper_bound() < least {
                    gap.re = S::from_magnitude(least, self.precision);
                }
                own[i] = sum.mul(&gap.inverse()).center();
            }
            let column = self.basis.image(&own, self.precision);
            let size = column.iter().map(Complex::upper_bound);
            let (_, exponent) = size.fold(Magnitude::ZERO, Magnitude::max).parts();
            for (i, x) in column.iter().enumerate() {
                vectors[(i, k)] = x.scale(-exponent).center();
            }
        }
        vectors
    }
}

/// About the inverse of a complex matrix: by elimination with exchanges of rows, with midpoints.
pub(super) fn inverse<S: Enclosure>(
    matrix: &Matrix<Complex<S>>,
    precision: S::Precision,
) -> Option<Matrix<Complex<S>>> {
    let n = matrix.rows().len();
    let unit = Matrix::unit(n, precision);
    let mut rows: Vec<Vec<Complex<S>>> =
        matrix.rows().zip(unit.rows()).map(|(own, unit)| [own, unit].concat()).collect();
    for k in 0..n {
        let larger = |own: usize, i: usize| rows[own][k].upper_bound() < rows[i][k].upper_bound();
        let pivot = (k + 1..n).fold(k, |own, i| if larger(own, i) { i } else { own });
        if rows[pivot][k].upper_bound().is_zero() {
            return None;
        }
        rows.swap(k, pivot);
        clear_column(&mut rows, k, k, precision);
        rows.iter_mut().flatten().for_each(|entry| *entry = entry.center());
    }
    let inverse = Matrix::from_fn(n, n, |i, j| rows[i][n + j].clone());
    inverse.entries().iter().all(Complex::is_finite).then_some(inverse)
}
