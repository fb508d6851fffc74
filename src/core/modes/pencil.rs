//! The problem in scaled coordinates, and the pencil (XᵀKX, XᵀMX) with proved error bounds.

use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par};

use super::certify::Couplings;
use super::dense::{Matrix, Plain};
use super::product::{Part, TERM, bound_product, measured_product, product, product_bound};
use super::start::{NOISE, cholesky};
use super::{ModesError, Problem, Which};
use crate::order::Order;
use crate::precision::{Ball, DoubleDouble, Enclosure, U2, exponent_of, sum_of_products, two_prod, up};

/// A matrix of balls.
#[derive(Clone)]
pub(super) struct Enclosed {
    pub(super) mid: Matrix,
    pub(super) radius: Plain,
    /// It is square, and known to be 0 beside the diagonal.
    diagonal: bool,
}

/// The whole problem in coordinates q_i = 2^shift_i y_i in which the diagonal of M is about 1, and
/// with K divided by 2^power so that its largest entry is about 1. Powers of two: nothing is
/// rounded.
pub(super) struct Scaled {
    pub(super) n: usize,
    pub(super) mass: Enclosed,
    pub(super) stiffness: Enclosed,
    pub(super) shift: Vec<i32>,
    pub(super) power: i32,
}

impl Scaled {
    pub(super) fn new(problem: &Problem) -> Result<Self, ModesError> {
        let n = problem.dimension;
        check(n, Which::Mass, &problem.mass)?;
        check(n, Which::Stiffness, &problem.stiffness)?;
        let shift = halves(n, &problem.mass);
        let places = (0..n).flat_map(|column| (column..n).map(move |row| (row, column)));
        let sizes = places.filter_map(|(row, column)| {
            let k = problem.stiffness[column * n + row].mid.hi;
            (k != 0.0).then(|| exponent_of(k) + shift[row] + shift[column])
        });
        // Even, so that frequencies can be scaled by its root.
        let power = sizes.max().unwrap_or(0) & !1;
        Ok(Self {
            n,
            mass: Enclosed::symmetric(n, &problem.mass, &shift, 0),
            stiffness: Enclosed::symmetric(n, &problem.stiffness, &shift, power),
            shift,
            power,
        })
    }
}

/// Powers of two in which the diagonal of M is about 1.
pub(super) fn halves(n: usize, mass: &[Ball]) -> Vec<i32> {
    let diagonal = mass.iter().step_by(n + 1).map(|entry| entry.mid.hi);
    diagonal.map(|m| if m > 0.0 { -exponent_of(m).div_euclid(2) } else { 0 }).collect()
}

/// Whether the matrix has n by n numbers.
pub(super) fn check(n: usize, matrix: Which, entries: &[Ball]) -> Result<(), ModesError> {
    if entries.len() != n * n {
        return Err(ModesError::Shape { matrix, expected: n * n, found: entries.len() });
    }
    let at = entries.iter().position(|x| !x.is_finite());
    at.map_or(Ok(()), |at| Err(ModesError::NotFinite { matrix, row: at % n, column: at / n }))
}

/// 0 where the entry is exactly 0.
fn weight(radius: f64, hi: f64) -> f64 {
    if radius == 0.0 && hi == 0.0 { 0.0 } else { up(radius + TERM * hi.abs()) }
}

impl Enclosed {
    /// One of any shape and with any entries.
    pub(super) fn general(mid: Matrix, radius: Plain) -> Self {
        Self { mid, radius, diagonal: false }
    }

    /// A square one from the entry of each row and column.
    pub(super) fn new(n: usize, entry: impl Fn(usize, usize) -> Ball) -> Self {
        let (mut mid, mut radius) = (Matrix::zeros(n, n), Plain::zeros(n, n));
        let mut diagonal = true;
        for column in 0..n {
            let ((hi, lo), radii) = (mid.column_mut(column), radius.column_mut(column));
            for row in 0..n {
                let entry = entry(row, column);
                if !entry.is_zero() {
                    (hi[row], lo[row], radii[row]) = (entry.mid.hi, entry.mid.lo, entry.radius);
                    diagonal &= row == column;
                }
            }
        }
        Self { mid, radius, diagonal }
    }

    /// From the lower triangle of `entries`, column by column; entry (r, c) is multiplied by 2^(shift_r + shift_c - power).
    pub(super) fn symmetric(n: usize, entries: &[Ball], shift: &[i32], power: i32) -> Self {
        let mut lower = Self::new(n, |row, column| {
            let entry = entries[column * n + row];
            if row < column || entry.is_zero() {
                return Ball::ZERO;
            }
            let by = shift[row] + shift[column] - power;
            if by == 0 { entry } else { entry.scale(by) }
        });
        if !lower.diagonal {
            lower.mid.mirror();
            lower.radius.mirror();
        }
        lower
    }

    /// The rows of a column whose entries are not exactly 0.
    pub(super) fn nonzero(&self, column: usize) -> impl Iterator<Item = usize> {
        let entries = self.mid.hi.column(column).iter().zip(self.radius.column(column)).enumerate();
        entries.filter(|(_, (hi, radius))| **hi != 0.0 || **radius != 0.0).map(|(row, _)| row)
    }

    pub(super) fn ball(&self, row: usize, column: usize) -> Ball {
        Ball { mid: self.mid.get(row, column), radius: self.radius.get(row, column) }
    }

    /// radius + c u² |mid| with c u² = [`TERM`]: what a measured product with the entry is off by, per unit of the other
    /// factor, beside its noise.
    pub(super) fn weight(&self, row: usize, column: usize) -> f64 {
        weight(self.radius.get(row, column), self.mid.get(row, column).hi)
    }

    /// [`Enclosed::weight`] of all entries.
    pub(super) fn weights(&self) -> Plain {
        let mut weights = self.radius.clone();
        for (own, hi) in weights.data.iter_mut().zip(&self.mid.hi.data) {
            *own = weight(*own, *hi);
        }
        weights
    }

    /// The matrix times x, and a bound of the error of every entry.
    pub(super) fn times(&self, x: &Matrix) -> Self {
        let sizes = x.magnitudes();
        if !self.diagonal {
            let (mid, noise) = measured_product(&self.mid, x, Part::All);
            let mut radius = bound_product(&self.weights(), &sizes);
            for (e, noise) in radius.data.iter_mut().zip(&noise.data) {
                *e = up(*e + noise);
            }
            return Self::general(mid, radius);
        }
        // A product of two double-doubles is off by 5 u² of itself, less than [`TERM`]: no noise.
        let mid = Matrix::from_fn(x.rows, x.columns, |row, column| self.mid.get(row, row) * x.get(row, column));
        let radius = |row: usize, column: usize| up(self.weight(row, row) * sizes.get(row, column));
        Self::general(mid, Plain::from_fn(x.rows, x.columns, radius))
    }

    /// XᵀAX for a symmetric A.
    ///
    /// With w = radius + c u² |A| (c u² = [`TERM`]), the computed image Y of A X is off by at most
    /// w |X| + its noise E, and XᵀY by at most |X|ᵀ (w |X| + E + c u² |Y|) + its own noise.
    pub(super) fn congruent(&self, x: &Matrix, xt: &Matrix) -> Self {
        let Self { mid: image, radius: mut error, .. } = self.times(x);
        for (e, y) in error.data.iter_mut().zip(&image.hi.data) {
            *e = up(*e + TERM * y.abs());
        }
        let (mid, noise) = measured_product(xt, &image, Part::Lower);
        let mut radius = bound_product(&xt.magnitudes(), &error);
        radius.mirror();
        for (r, noise) in radius.data.iter_mut().zip(&noise.data) {
            *r = up(*r + noise);
        }
        Self::general(mid, radius)
    }

    /// Whether the symmetric matrix is shown to be positive definite: with P near the inverse of its Cholesky factor in
    /// doubles, P A Pᵀ is diagonally dominant with a positive diagonal (Gershgorin), and A is definite where
    /// P A Pᵀ is and P is not singular, which follows.
    pub(super) fn is_positive_definite(&self) -> bool {
        let n = self.mid.rows;
        let Some(l) = cholesky(&self.mid.doubles(), NOISE * n as f64) else { return false };
        let mut p = Mat::<f64>::identity(n, n);
        solve_lower_triangular_in_place(l.as_ref(), p.as_mut(), Par::Seq);
        let (rows, columns) = (Matrix::from_doubles(p.as_ref()), Matrix::from_doubles(p.transpose()));
        let Self { mid, radius, .. } = self.congruent(&columns, &rows);
        (0..n).all(|i| {
            let size = |j: usize| if i == j { 0.0 } else { mid.get(i, j).hi.abs() * (1.0 + 1e-15) };
            let rest: f64 = (0..n).map(|j| size(j) + radius.get(i, j)).sum();
            // Sums of nonnegative doubles.
            rest * (1.0 + 8.0 * (n as f64 + 2.0) * f64::EPSILON) < mid.get(i, i).hi * (1.0 - 1e-15)
        })
    }

    /// The transpose times a vector of balls, as balls.
    pub(super) fn transpose_times(&self, x: &[Ball]) -> Vec<Ball> {
        let product = |row: usize| {
            let terms = self.nonzero(row).filter(|at| !x[*at].is_zero());
            terms.fold(Ball::ZERO, |sum, at| sum + self.ball(at, row) * x[at])
        };
        (0..self.mid.rows).map(product).collect()
    }

    /// xᵀ A x for a symmetric A.
    pub(super) fn form(&self, x: &[Ball]) -> Ball {
        sum_of_products(x, &self.transpose_times(x), ())
    }
}

/// The congruent pencil: S = XᵀKX and G = XᵀMX, for X exactly as it stands.
pub(super) struct Pencil {
    pub(super) s: Enclosed,
    pub(super) g: Enclosed,
    /// ZᵀMX at the midpoints, z by m: what X still has of the zero vectors.
    pub(super) overlap: Matrix,
    /// A bound, for each column of X, of the M-length of its part along the zero vectors.
    pub(super) leak: Vec<f64>,
}

/// Vectors that are orthonormal in a positive definite form, nearly.
pub(super) struct Orthonormal<S> {
    pub(super) vectors: Vec<Vec<S>>,
    pub(super) images: Vec<Vec<S>>,
    /// ZᵀMZ, row by row.
    pub(super) gram: Vec<S>,
    /// A bound of ‖ZᵀMZ - 1‖, at most 1/2, in the row sum norm.
    pub(super) defect: f64,
}

impl<S: Enclosure> Orthonormal<S> {
    /// A basis of what the vectors span, `image` being the product with M; `Err` with an index if they are not shown to be
    /// independent.
    pub(super) fn new(
        vectors: Vec<Vec<S>>,
        image: &dyn Fn(&[S]) -> Vec<S>,
        precision: S::Precision,
    ) -> Result<Self, usize> {
        let dot = |x: &[S], y: &[S]| sum_of_products(x, y, precision);
        let one = S::exact(1.0, precision);
        let mut found = Self { vectors: Vec::new(), images: Vec::new(), gram: Vec::new(), defect: 0.0 };
        for (index, mut v) in vectors.into_iter().enumerate() {
            // Gram-Schmidt twice, with coefficients that are exact numbers: the result is a
            // combination of the given vectors, whatever the coefficients.
            for _ in 0..2 {
                for (b, image) in found.vectors.iter().zip(&found.images) {
                    let c = dot(&v, image).center();
                    for (x, b) in v.iter_mut().zip(b) {
                        *x = x.sub(&c.mul(b));
                    }
                }
                let length = dot(&v, &image(&v));
                if !length.is_positive() {
                    return Err(index);
                }
                let factor = one.div(&length.sqrt()).center();
                v.iter_mut().for_each(|x| *x = x.mul(&factor));
            }
            found.images.push(image(&v));
            found.vectors.push(v);
        }
        let z = found.vectors.len();
        found.gram = vec![one.clone(); z * z];
        for (i, j) in (0..z).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            found.gram[i * z + j] = dot(&found.vectors[i], &found.images[j]);
            found.gram[j * z + i] = found.gram[i * z + j].clone();
        }
        for (i, row) in found.gram.chunks(z.max(1)).enumerate() {
            let entry = |(j, g): (usize, &S)| if i == j { g.sub(&one).abs_upper() } else { g.abs_upper() };
            let sum: f64 = row.iter().enumerate().map(entry).sum();
            found.defect = found.defect.max(sum * (1.0 + 1e-9));
            if sum.is_nan() || found.defect > 0.5 {
                return Err(z - 1);
            }
        }
        Ok(found)
    }
}

/// The zero vectors, M-orthonormal as nearly as double-double allows.
pub(super) struct ZeroSpace {
    /// n by z.
    pub(super) vectors: Vec<Vec<Ball>>,
    pub(super) mid: Matrix,
    /// (M Z)ᵀ, z by n, and its radii.
    image: Matrix,
    image_radius: Plain,
    /// A bound of ‖ZᵀMZ - 1‖ below 1, in the row sum norm.
    pub(super) defect: f64,
}

impl ZeroSpace {
    /// (M Z)ᵀ, z by n, and for each zero vector a bound of what products with its row are off by, per
    /// unit of the other factor's length.
    pub(super) fn image(&self) -> (&Matrix, Vec<f64>) {
        let square = |p: usize| (0..self.image.columns).map(|i| self.image_radius.get(p, i).powi(2)).sum::<f64>();
        let errors = (0..self.image.rows).map(|p| square(p).sqrt() * (1.0 + 1e-6) + 1e-150).collect();
        (&self.image, errors)
    }

    /// From linearly independent vectors of the kernel of K; `Err` with an index if a vector is
    /// certainly not in it or they are not independent.
    pub(super) fn new(mass: &Enclosed, stiffness_t: &Enclosed, vectors: Vec<Vec<Ball>>) -> Result<Self, usize> {
        let (n, z) = (mass.mid.rows, vectors.len());
        let outside = |v: &Vec<Ball>| {
            let known = v.len() == n && v.iter().all(|x| x.is_finite());
            !known || stiffness_t.transpose_times(v).iter().any(|x| !x.contains_zero())
        };
        if let Some(index) = vectors.iter().position(outside) {
            return Err(index);
        }
        let Orthonormal { vectors: basis, images, defect, .. } =
            Orthonormal::new(vectors, &|v| mass.transpose_times(v), ())?;
        let mid = Matrix::from_fn(n, z, |i, p| basis[p][i].mid);
        let image = Matrix::from_fn(z, n, |p, i| images[p][i].mid);
        let radius = |y: &Ball| up(y.radius + product_bound(n) * y.mid.hi.abs());
        let image_radius = Plain::from_fn(z, n, |p, i| radius(&images[p][i]));
        Ok(Self { vectors: basis, mid, image, image_radius, defect })
    }
}

/// The pencil of the problem in the columns of x, with the zero vectors taken out.
///
/// Zero vectors: for Z in the kernel of K and X' = X - Z (ZᵀMZ)⁻¹ ZᵀMX, which is M-orthogonal to Z,
/// X'ᵀKX' = XᵀKX exactly, and X'ᵀMX' = XᵀMX - R with R = (ZᵀMX)ᵀ (ZᵀMZ)⁻¹ (ZᵀMX). With r_i the length of
/// column i of ZᵀMX and ‖ZᵀMZ - 1‖ <= f < 1, |R_ij| <= r_i r_j / (1 - f). So the pencil of X with R
/// added to the radii is the exact pencil of the M-orthogonal complement of the zero vectors.
pub(super) fn pencil(problem: &Scaled, zero: &ZeroSpace, x: &Matrix) -> Pencil {
    let m = x.columns;
    let xt = x.transposed();
    let s = problem.stiffness.congruent(x, &xt);
    let mut g = problem.mass.congruent(x, &xt);
    let z = zero.mid.columns;
    let mut leak = vec![0.0; m];
    let mut overlap = Matrix::zeros(z, m);
    if z > 0 {
        overlap = product(&zero.image, x, Part::All);
        let error = bound_product(&zero.image_radius, &x.magnitudes());
        let part = |p: usize, column: usize| overlap.get(p, column).hi.abs() * (1.0 + 1e-15) + error.get(p, column);
        for (column, leak) in leak.iter_mut().enumerate() {
            let square: f64 = (0..z).map(|p| part(p, column).powi(2)).sum();
            *leak = up((square / (1.0 - zero.defect)).sqrt() * (1.0 + 1e-12));
        }
        g.radius = Plain::from_fn(m, m, |row, column| up(g.radius.get(row, column) + leak[row] * leak[column]));
    }
    Pencil { s, g, overlap, leak }
}

/// The columns by rising quotient, and the distances between neighbours in this order.
pub(super) fn ordered(quotient: &[DoubleDouble]) -> (Vec<usize>, Vec<f64>) {
    let mut order: Vec<usize> = (0..quotient.len()).collect();
    order.order_by(|&i, &j| quotient[i].partial_cmp(&quotient[j]).unwrap_or(std::cmp::Ordering::Equal));
    // The difference of two double-doubles is off by at most 3 u² of itself.
    let steps = order.windows(2).map(|pair| (quotient[pair[1]] - quotient[pair[0]]).hi.max(0.0)).collect();
    (order, steps)
}

/// The columns' quotients in double-double and how the columns are coupled; `None` where a number
/// is out of range.
pub(super) fn couplings(pencil: &Pencil) -> Option<(Vec<DoubleDouble>, Couplings)> {
    let m = pencil.s.mid.columns;
    let (quotient, defect): (Vec<DoubleDouble>, Vec<f64>) = (0..m).map(|i| rayleigh(pencil, i)).unzip();
    if !quotient.iter().all(|mu| mu.is_finite()) || !defect.iter().all(|error| error.is_finite()) {
        return None;
    }
    let (order, steps) = ordered(&quotient);
    let size: Vec<f64> = quotient.iter().map(|mu| up(mu.hi.abs())).collect();
    let (mut h, mut g) = (Plain::zeros(m, m), Plain::zeros(m, m));
    for j in 0..m {
        for i in (0..m).filter(|i| *i != j) {
            let (s, b) = (pencil.s.mid.get(i, j), pencil.g.mid.get(i, j));
            let (rs, rb) = (pencil.s.radius.get(i, j), pencil.g.radius.get(i, j));
            let residual = (s - quotient[j] * b).hi.abs();
            // The product is off by 5 u² of itself, the difference by 3 u².
            let rounding = 16.0 * U2 * (s.hi.abs() + size[j] * b.hi.abs());
            h.set(i, j, up(residual + rounding + rs + size[j] * rb));
            g.set(i, j, up(b.hi.abs() + rb));
        }
    }
    let least = (0..m).map(|i| pencil.g.ball(i, i).lower()).collect();
    let most = (0..m).map(|i| pencil.g.ball(i, i).upper()).collect();
    let couplings = Couplings { order, steps, size, defect, least, most, h, g };
    Some((quotient, couplings))
}

/// The quotient s_ii / g_ii in double-double, and a bound of |s_ii - mu g_ii| for the exact entries.
///
/// What the division leaves over, s - mu g, is taken as it is. With p + e the exact product of the high parts,
/// s.hi - p is exact (Sterbenz; s.hi and p agree to a few units), and each of the following
/// operations in doubles is off by at most u of its result.
pub(super) fn rayleigh(pencil: &Pencil, i: usize) -> (DoubleDouble, f64) {
    let (s, g) = (pencil.s.mid.get(i, i), pencil.g.mid.get(i, i));
    let mu = s / g;
    let (p, e) = two_prod(mu.hi, g.hi);
    let high = (s.hi - p) - e;
    let (first, second) = (mu.hi * g.lo, mu.lo * g.hi);
    let cross = first + second;
    let low = s.lo - cross;
    let left = high + low;
    let rounded = high.abs() + first.abs() + second.abs() + cross.abs() + low.abs() + left.abs();
    let exact = (s.hi - p).abs() <= 0.25 * s.hi.abs();
    let division = if exact {
        left.abs() + 0.5 * f64::EPSILON * rounded + (mu.lo * g.lo).abs()
    } else {
        // Out of range: the division is off by 16 u² of the quotient.
        17.0 * U2 * s.hi.abs()
    };
    let defect = up(division + pencil.s.radius.get(i, i) + mu.hi.abs() * pencil.g.radius.get(i, i));
    (mu, defect)
}
