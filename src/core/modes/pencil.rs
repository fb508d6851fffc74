//! The problem in scaled coordinates, and the pencil (XᵀKX, XᵀMX) with proved error bounds.

use super::certify::Couplings;
use super::dense::{Matrix, Plain, mirror};
use super::factored::Factored;
use super::product::{Part, TERM, bound_product, measured_product, product, product_bound};
use super::{ModesError, Problem, Which};
use crate::precision::{Ball, DoubleDouble, U2, exponent_of, two_prod, up};

/// A symmetric matrix of balls: midpoints, and weights for the error of products with it.
pub(super) struct Enclosed {
    pub(super) mid: Matrix,
    /// radius + c u² |mid|, entry by entry, with c u² = [`TERM`]: what a measured product with the matrix is off
    /// by, per unit of the other factor, beside its noise.
    pub(super) weight: Plain,
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
        let mut power = i32::MIN;
        for column in 0..n {
            for row in column..n {
                let k = problem.stiffness[column * n + row].mid.hi;
                if k != 0.0 {
                    power = power.max(exponent_of(k) + shift[row] + shift[column]);
                }
            }
        }
        // Even, so that factors of K can be scaled by its root.
        let power = if power == i32::MIN { 0 } else { power & !1 };
        Ok(Self {
            n,
            mass: Enclosed::new(n, &problem.mass, &shift, 0),
            stiffness: Enclosed::new(n, &problem.stiffness, &shift, power),
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
    match entries.iter().position(|x| !x.is_finite()) {
        Some(at) => Err(ModesError::NotFinite { matrix, row: at % n, column: at / n }),
        None => Ok(()),
    }
}

impl Enclosed {
    /// From the lower triangle of `entries`.
    pub(super) fn new(n: usize, entries: &[Ball], shift: &[i32], power: i32) -> Self {
        let mut mid = Matrix::zeros(n, n);
        let mut weight = Plain::zeros(n, n);
        let mut diagonal = true;
        for column in 0..n {
            let (hi, lo) = mid.column_mut(column);
            let weights = weight.column_mut(column);
            let shift_here = shift[column] - power;
            for row in column..n {
                let entry = entries[column * n + row];
                if entry.is_zero() {
                    continue;
                }
                let shift = shift[row] + shift_here;
                let entry = if shift == 0 { entry } else { entry.scale(shift) };
                (hi[row], lo[row]) = (entry.mid.hi, entry.mid.lo);
                weights[row] = up(entry.radius + TERM * entry.mid.hi.abs());
                diagonal &= row == column;
            }
        }
        if !diagonal {
            for part in [&mut mid.hi, &mut mid.lo, &mut weight.data] {
                mirror(part, n, mid.stride);
            }
        }
        Self { mid, weight, diagonal }
    }

    /// The matrix times x, with its noise; see [`measured_product`].
    ///
    /// A product of two double-doubles is off by 5 u² of itself, less than [`TERM`]: no noise.
    fn times(&self, x: &Matrix) -> (Matrix, Plain) {
        if !self.diagonal {
            return measured_product(&self.mid, x, Part::All);
        }
        let mut y = Matrix::zeros(x.rows, x.columns);
        for column in 0..x.columns {
            for row in 0..x.rows {
                y.set(row, column, self.mid.get(row, row) * x.get(row, column));
            }
        }
        (y, Plain::zeros(x.rows, x.columns))
    }

    /// The weights times magnitudes.
    fn weigh(&self, sizes: &Plain) -> Plain {
        if !self.diagonal {
            return bound_product(&self.weight, sizes, Part::All);
        }
        let mut y = Plain::zeros(sizes.rows, sizes.columns);
        for column in 0..sizes.columns {
            for row in 0..sizes.rows {
                y.set(row, column, up(self.weight.get(row, row) * sizes.get(row, column)));
            }
        }
        y
    }

    /// XᵀAX.
    ///
    /// With w = radius + c u² |A| (c u² = [`TERM`]), the computed image Y of A X is off by at most
    /// w |X| + its noise E, and XᵀY by at most |X|ᵀ (w |X| + E + c u² |Y|) + its own noise.
    pub(super) fn congruent(&self, x: &Matrix, xt: &Matrix) -> Bounded {
        let sizes = x.magnitudes();
        let (image, noise) = self.times(x);
        let mut error = self.weigh(&sizes);
        for column in 0..x.columns {
            let bounds = error.column_mut(column).iter_mut();
            let more = image.column_hi(column).iter().zip(noise.column(column));
            for (e, (y, noise)) in bounds.zip(more) {
                *e = up(*e + noise + TERM * y.abs());
            }
        }
        let (mid, noise) = measured_product(xt, &image, Part::Lower);
        let mut radius = bound_product(&sizes.transposed(), &error, Part::Lower);
        for column in 0..radius.columns {
            for (r, noise) in radius.column_mut(column).iter_mut().zip(noise.column(column)) {
                *r = up(*r + noise);
            }
        }
        Bounded { mid, radius }
    }

    /// Whether nothing is left of the matrix but uncertainty.
    pub(super) fn is_negligible(&self) -> bool {
        let n = self.mid.rows;
        (0..n).all(|column| self.mid.column_hi(column).iter().all(|x| x.abs() < 1e-25))
    }

    /// The matrix times a vector of balls, as balls.
    pub(super) fn apply(&self, x: &[Ball]) -> Vec<Ball> {
        let sizes: Vec<f64> = x.iter().map(Ball::abs_upper).collect();
        (0..self.mid.rows)
            .map(|row| {
                let mut sum = Ball::ZERO;
                let mut error = 0.0;
                // The matrix is symmetric: a row is the column that lies in one piece.
                let entries = self.mid.column_hi(row).iter();
                let entries = entries.zip(self.weight.column(row)).enumerate();
                for (column, (hi, weight)) in entries.filter(|(_, (_, weight))| **weight != 0.0) {
                    if *hi != 0.0 && !x[column].is_zero() {
                        sum = sum + Ball::from(self.mid.get(column, row)) * x[column];
                    }
                    // The weight holds the radius and a little more.
                    error += weight * sizes[column];
                }
                if error == 0.0 { sum } else { sum.with_added_radius(error * 1.000_001) }
            })
            .collect()
    }

    /// xᵀ A x.
    pub(super) fn form(&self, x: &[Ball]) -> Ball {
        let image = self.apply(x);
        x.iter().zip(&image).fold(Ball::ZERO, |sum, (x, y)| sum + *x * *y)
    }
}

/// A symmetric matrix with an error bound for every entry.
#[derive(Clone)]
pub(super) struct Bounded {
    pub(super) mid: Matrix,
    pub(super) radius: Plain,
}

impl Bounded {
    pub(super) fn ball(&self, row: usize, column: usize) -> Ball {
        Ball { mid: self.mid.get(row, column), radius: self.radius.get(row, column) }
    }
}

/// The congruent pencil: S = XᵀKX and G = XᵀMX, for X exactly as it stands.
pub(super) struct Pencil {
    pub(super) s: Bounded,
    pub(super) g: Bounded,
    /// ZᵀMX at the midpoints, z by m: what X still has of the zero vectors.
    pub(super) overlap: Matrix,
    /// A bound, for each column of X, of the M-length of its part along the zero vectors.
    pub(super) leak: Vec<f64>,
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
    defect: f64,
}

impl ZeroSpace {
    /// (M Z)ᵀ, z by n, and for each zero vector a bound of what products with its row are off by, per
    /// unit of the other factor's length.
    pub(super) fn image(&self) -> (&Matrix, Vec<f64>) {
        let errors = (0..self.image.rows)
            .map(|p| {
                let squares: f64 =
                    (0..self.image.columns).map(|i| self.image_radius.get(p, i) * self.image_radius.get(p, i)).sum();
                squares.sqrt() * (1.0 + 1e-6) + 1e-150
            })
            .collect();
        (&self.image, errors)
    }

    /// A bound of ‖ZᵀMZ - 1‖ below 1.
    pub(super) fn defect(&self) -> f64 {
        self.defect
    }

    /// From linearly independent vectors of the kernel of K; `Err` with an index if a vector is
    /// certainly not in it or they are not independent.
    pub(super) fn new(problem: &Scaled, vectors: &[Vec<Ball>]) -> Result<Self, usize> {
        let (n, z) = (problem.n, vectors.len());
        let mut basis: Vec<Vec<Ball>> = Vec::with_capacity(z);
        let mut images: Vec<Vec<Ball>> = Vec::with_capacity(z);
        for (index, vector) in vectors.iter().enumerate() {
            if vector.len() != n || vector.iter().any(|x| !x.is_finite()) {
                return Err(index);
            }
            let mut v: Vec<Ball> = vector.iter().zip(&problem.shift).map(|(x, s)| x.scale(-s)).collect();
            if problem.stiffness.apply(&v).iter().any(|x| !x.contains_zero()) {
                return Err(index);
            }
            // Gram-Schmidt twice, with coefficients that are exact numbers: the result is a
            // combination of the given vectors, whatever the coefficients.
            for _ in 0..2 {
                for (b, image) in basis.iter().zip(&images) {
                    let c = v.iter().zip(image).fold(Ball::ZERO, |s, (x, y)| s + *x * *y);
                    let c = Ball::from(c.mid);
                    for (x, b) in v.iter_mut().zip(b) {
                        *x = *x - c * *b;
                    }
                }
                let length = problem.mass.form(&v);
                if !length.is_positive() {
                    return Err(index);
                }
                let factor = Ball::from((Ball::ONE / length.sqrt()).mid);
                v.iter_mut().for_each(|x| *x = *x * factor);
            }
            images.push(problem.mass.apply(&v));
            basis.push(v);
        }
        let mut defect: f64 = 0.0;
        for (i, b) in basis.iter().enumerate() {
            let mut sum = 0.0;
            for (j, image) in images.iter().enumerate() {
                let g = b.iter().zip(image).fold(Ball::ZERO, |s, (x, y)| s + *x * *y);
                let g = if i == j { g - Ball::ONE } else { g };
                sum += g.abs_upper();
            }
            defect = defect.max(sum * (1.0 + 1e-9));
        }
        if z > 0 && (defect.is_nan() || defect > 0.5) {
            return Err(z - 1);
        }
        let mut mid = Matrix::zeros(n, z);
        let mut image = Matrix::zeros(z, n);
        let mut image_radius = Plain::zeros(z, n);
        for (p, (b, y)) in basis.iter().zip(&images).enumerate() {
            for i in 0..n {
                mid.set(i, p, b[i].mid);
                image.set(p, i, y[i].mid);
                image_radius.set(p, i, up(y[i].radius + product_bound(n) * y[i].mid.hi.abs()));
            }
        }
        Ok(Self { vectors: basis, mid, image, image_radius, defect })
    }
}

/// The pencil of the problem in the columns of x, with the zero vectors taken out.
///
/// The stiffness is taken from its factors where these are given.
///
/// Zero vectors: for Z in the kernel of K and X' = X - Z (ZᵀMZ)⁻¹ ZᵀMX, which is M-orthogonal to Z,
/// X'ᵀKX' = XᵀKX exactly, and X'ᵀMX' = XᵀMX - R with R = (ZᵀMX)ᵀ (ZᵀMZ)⁻¹ (ZᵀMX). With r_i the length of
/// column i of ZᵀMX and ‖ZᵀMZ - 1‖ <= f < 1, |R_ij| <= r_i r_j / (1 - f). So the pencil of X with R
/// added to the radii is the exact pencil of the M-orthogonal complement of the zero vectors.
pub(super) fn pencil(problem: &Scaled, factored: Option<&Factored>, zero: &ZeroSpace, x: &Matrix) -> Pencil {
    let m = x.columns;
    let xt = x.transposed();
    let s = match factored {
        Some(factored) => factored.form(x),
        None => problem.stiffness.congruent(x, &xt),
    };
    let mut g = problem.mass.congruent(x, &xt);
    let z = zero.mid.columns;
    let mut leak = vec![0.0; m];
    let mut overlap = Matrix::zeros(z, m);
    if z > 0 {
        overlap = product(&zero.image, x, Part::All);
        let error = bound_product(&zero.image_radius, &x.magnitudes(), Part::All);
        for (column, leak) in leak.iter_mut().enumerate() {
            let square: f64 = (0..z)
                .map(|p| {
                    let r = overlap.get(p, column).hi.abs() * (1.0 + 1e-15) + error.get(p, column);
                    r * r
                })
                .sum();
            *leak = up((square / (1.0 - zero.defect)).sqrt() * (1.0 + 1e-12));
        }
        for column in 0..m {
            for row in 0..m {
                let radius = up(g.radius.get(row, column) + leak[row] * leak[column]);
                g.radius.set(row, column, radius);
            }
        }
    }
    Pencil { s, g, overlap, leak }
}

/// The columns by rising quotient, and the distances between neighbours in this order.
pub(super) fn ordered(quotient: &[DoubleDouble]) -> (Vec<usize>, Vec<f64>) {
    let mut order: Vec<usize> = (0..quotient.len()).collect();
    order.sort_by(|&i, &j| {
        let order = quotient[i].partial_cmp(&quotient[j]);
        order.unwrap_or(std::cmp::Ordering::Equal)
    });
    // The difference of two double-doubles is off by at most 3 u² of itself.
    let steps = order.windows(2).map(|pair| (quotient[pair[1]] - quotient[pair[0]]).hi.max(0.0)).collect();
    (order, steps)
}

/// The columns' quotients in double-double and how the columns are coupled; `None` where a number
/// is out of range.
pub(super) fn couplings(pencil: &Pencil) -> Option<(Vec<DoubleDouble>, Couplings)> {
    let m = pencil.s.mid.columns;
    let (mut quotient, mut defect) = (Vec::with_capacity(m), Vec::with_capacity(m));
    for i in 0..m {
        let (mu, error) = rayleigh(pencil, i);
        if !mu.is_finite() || !error.is_finite() {
            return None;
        }
        quotient.push(mu);
        defect.push(error);
    }
    let (order, steps) = ordered(&quotient);
    let size: Vec<f64> = quotient.iter().map(|mu| up(mu.hi.abs())).collect();
    let (mut h, mut g) = (Plain::zeros(m, m), Plain::zeros(m, m));
    let (mut least, mut most) = (Vec::with_capacity(m), Vec::with_capacity(m));
    for j in 0..m {
        for i in 0..m {
            let (s, b) = (pencil.s.mid.get(i, j), pencil.g.mid.get(i, j));
            let (rs, rb) = (pencil.s.radius.get(i, j), pencil.g.radius.get(i, j));
            if i == j {
                let ball = pencil.g.ball(i, i);
                least.push(ball.lower());
                most.push(ball.upper());
                continue;
            }
            let residual = (s - quotient[j] * b).hi.abs();
            // The product is off by 5 u² of itself, the difference by 3 u².
            let rounding = 16.0 * U2 * (s.hi.abs() + size[j] * b.hi.abs());
            h.set(i, j, up(residual + rounding + rs + size[j] * rb));
            g.set(i, j, up(b.hi.abs() + rb));
        }
    }
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
