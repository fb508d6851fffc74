//! M, K and the zero vectors as whole numbers over one power of two.

use dashu_int::IBig;
use dashu_int::ops::SquareRoot;

use super::PreciseProblem;
use super::fixed::{Sum, Symmetric, dot, double, length, shifted, unit};
use crate::precision::{DoubleDouble, up};

/// The problem over 2^scale, in the scaled coordinates of [`crate::modes::pencil::Scaled`].
pub(super) struct Data {
    pub(super) n: usize,
    pub(super) scale: i64,
    pub(super) mass: Symmetric,
    pub(super) stiffness: Symmetric,
    pub(super) zero: ZeroSpace,
}

impl Data {
    /// `None` where the numbers are not known well enough to be used at all.
    pub(super) fn new(problem: &PreciseProblem, shift: &[i32], power: i32, scale: i64) -> Option<Self> {
        let n = problem.dimension;
        let right = problem.mass.len() == n * n
            && problem.stiffness.len() == n * n
            && problem.zero_vectors.iter().all(|z| z.len() == n);
        if !right || shift.len() != n {
            return None;
        }
        let mass = Symmetric::new(&problem.mass, shift, 0, scale)?;
        let stiffness = Symmetric::new(&problem.stiffness, shift, power, scale)?;
        let zero = ZeroSpace::new(problem, &mass, shift, scale)?;
        Some(Self { n, scale, mass, stiffness, zero })
    }

    /// Quotients are rounded to 2^-scale, but not so far that a difference might vanish as a double.
    pub(super) fn quotient_scale(&self) -> i64 {
        self.scale.min(950)
    }
}

/// The zero vectors, M-orthonormal up to rounding: combinations of the given ones.
pub(super) struct ZeroSpace {
    pub(super) vectors: Vec<Vec<IBig>>,
    /// M times the vectors, and by how many units an entry may be off.
    images: Vec<Vec<IBig>>,
    image_error: Vec<f64>,
    /// A bound of ‖ZᵀMZ - 1‖ below 1, in the row sum norm.
    defect: f64,
}

/// x 2^-scale.
fn of_units(x: f64, scale: i64) -> f64 {
    DoubleDouble::exact(x).scale(-(scale as i32)).hi
}

/// A bound of Σ |x_i| 2^-scale.
fn length_1(x: &[IBig], scale: i64) -> f64 {
    up(x.iter().map(|x| double(x, -scale).abs()).sum::<f64>() * (1.0 + 1e-12))
}

impl ZeroSpace {
    /// The errors of a vector are all below one number e of units. A combination v - c b with an exact
    /// number c over 2^scale, rounded, is off by e_v + |c| e_b + 1; the image M v, rounded, by
    /// (‖M‖ e + ‖E‖ (|v| + e)) + 1 with row sum norms and radii E of M.
    fn new(problem: &PreciseProblem, mass: &Symmetric, shift: &[i32], scale: i64) -> Option<Self> {
        let n = problem.dimension;
        let mut sum = Sum::default();
        let mut zero = Self { vectors: Vec::new(), images: Vec::new(), image_error: Vec::new(), defect: 0.0 };
        let mut errors: Vec<f64> = Vec::new();
        // Norms in units of 1, not of 2^-scale.
        let one = |x: f64| crate::precision::DoubleDouble::exact(x).scale(-(scale as i32)).hi;
        let radius = mass.radius.as_ref().map_or(0.0, |radius| {
            let row = |row| (0..n).map(|column| radius.get(row, column)).sum::<f64>();
            (0..n).map(row).fold(0.0, f64::max) * (1.0 + 1e-9)
        });
        let image = |v: &[IBig], error: f64, sum: &mut Sum| {
            let exact = mass.times(v, sum);
            let image: Vec<IBig> = exact.iter().map(|x| shifted(x, -scale)).collect();
            let largest = v.iter().fold(0.0_f64, |most, x| most.max(double(x, -scale).abs()));
            let error = mass.norm * (1.0 + 1e-9) * error + radius * (largest + one(error)) + 1.0;
            (image, up(error * (1.0 + 1e-9)))
        };
        for vector in &problem.zero_vectors {
            let mut v = Vec::with_capacity(n);
            let mut error: f64 = 0.0;
            for (x, &s) in vector.iter().zip(shift) {
                let (value, off) = unit(x, -i64::from(s), scale)?;
                v.push(value);
                error = error.max(off);
            }
            // First to a length of about 1, that the errors below are relative to it.
            let top = v.iter().map(length).max().unwrap_or(0) as i64;
            if top == 0 {
                return None;
            }
            for round in 0..3 {
                if round > 0 {
                    for (b, (image, b_error)) in zero.vectors.iter().zip(zero.images.iter().zip(&errors)) {
                        let c = shifted(&dot(&v, image, &mut sum), -scale);
                        for (x, b) in v.iter_mut().zip(b) {
                            *x -= shifted(&(&c * b), -scale);
                        }
                        error = up(error + double(&c, -scale).abs() * 1.000_001 * b_error + 1.0);
                    }
                }
                let (y, _) = image(&v, error, &mut sum);
                let square = dot(&v, &y, &mut sum);
                if square <= IBig::ZERO {
                    return None;
                }
                let (_, square) = square.into_parts();
                let norm = IBig::from(square.sqrt());
                if norm == IBig::ZERO {
                    return None;
                }
                let factor = (IBig::ONE << (2 * scale) as usize) / norm;
                for x in &mut v {
                    *x = shifted(&(&factor * &*x), -scale);
                }
                error = up(double(&factor, -scale) * 1.000_001 * error + 1.0);
            }
            let (y, y_error) = image(&v, error, &mut sum);
            zero.vectors.push(v);
            zero.images.push(y);
            zero.image_error.push(y_error);
            errors.push(error);
        }
        for (i, (b, error)) in zero.vectors.iter().zip(&errors).enumerate() {
            let mut row = 0.0;
            for (j, (y, y_error)) in zero.images.iter().zip(&zero.image_error).enumerate() {
                let mut g = dot(b, y, &mut sum);
                if i == j {
                    g -= IBig::ONE << (2 * scale) as usize;
                }
                let off = length_1(b, scale) * one(*y_error)
                    + length_1(y, scale) * one(*error)
                    + n as f64 * one(*error) * one(*y_error);
                row += double(&g, -2 * scale).abs() + off;
            }
            zero.defect = zero.defect.max(up(row * (1.0 + 1e-9)));
        }
        (zero.defect <= 0.5).then_some(zero)
    }

    /// ZᵀMx over 2^(scale + x_scale), and a bound of the M-length of x along the zero vectors: with
    /// r the length of ZᵀMx it is at most r / √(1 - defect).
    pub(super) fn overlap(&self, x: &[IBig], scale: i64, x_scale: i64, sum: &mut Sum) -> (Vec<IBig>, f64) {
        if self.vectors.is_empty() {
            return (Vec::new(), 0.0);
        }
        let size = length_1(x, x_scale);
        let mut square = 0.0;
        let overlap: Vec<IBig> = self
            .images
            .iter()
            .zip(&self.image_error)
            .map(|(image, error)| {
                let exact = dot(image, x, sum);
                let part = double(&exact, -(scale + x_scale)).abs() + size * of_units(*error, scale);
                square += part * part;
                exact
            })
            .collect();
        let leak = (square / (1.0 - self.defect)).sqrt() * (1.0 + 1e-9);
        (overlap, up(leak))
    }
}
