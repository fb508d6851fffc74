//! M, K and the zero vectors as whole numbers over one power of two.

use dashu_int::IBig;

use super::fixed::{Symmetric, dot, double, scaled, unit};
use crate::modes::PreciseProblem;
use crate::modes::pencil::Orthonormal;
use crate::precision::{Big, Sum, up};

/// Bits of vectors beyond the last one that is kept.
const GUARD: usize = 64;

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
        let zero = ZeroSpace::new(problem, shift, scale)?;
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

/// A bound of Σ |x_i| 2^-scale.
fn length_1(x: &[IBig], scale: i64) -> f64 {
    up(x.iter().map(|x| double(x, -scale).abs()).sum::<f64>() * (1.0 + 1e-12))
}

impl ZeroSpace {
    /// `None` where the vectors are not shown to be independent.
    fn new(problem: &PreciseProblem, shift: &[i32], scale: i64) -> Option<Self> {
        let n = problem.dimension;
        let bits = usize::try_from(scale).ok()? + GUARD;
        let image = |v: &[Big]| -> Vec<Big> {
            let term = |sum: Big, i: usize, j: usize| {
                let entry = &problem.mass[i.min(j) * n + i.max(j)];
                if entry.is_zero() || v[j].is_zero() {
                    return sum;
                }
                &sum + &(&entry.scale(i64::from(shift[i]) + i64::from(shift[j])) * &v[j])
            };
            (0..n).map(|i| (0..n).fold(Big::zero(bits), |sum, j| term(sum, i, j))).collect()
        };
        let given = |z: &Vec<Big>| -> Vec<Big> {
            z.iter().zip(shift).map(|(x, s)| x.scale(-i64::from(*s)).with_bits(bits)).collect()
        };
        let given = problem.zero_vectors.iter().map(given).collect();
        let Orthonormal { vectors, images, defect, .. } = Orthonormal::new(given, &image, bits).ok()?;
        let whole = |v: &Vec<Big>| -> Option<Vec<(IBig, f64)>> { v.iter().map(|x| unit(x, 0, scale)).collect() };
        let mut zero = Self { vectors: Vec::new(), images: Vec::new(), image_error: Vec::new(), defect };
        for (v, y) in vectors.iter().zip(&images) {
            zero.vectors.push(whole(v)?.into_iter().map(|(x, _)| x).collect());
            let (y, errors): (_, Vec<f64>) = whole(y)?.into_iter().unzip();
            zero.images.push(y);
            zero.image_error.push(errors.into_iter().fold(0.0, f64::max));
        }
        Some(zero)
    }

    /// ZᵀMx over 2^(scale + x_scale), and a bound of the M-length of x along the zero vectors: with
    /// r the length of ZᵀMx it is at most r / √(1 - defect).
    pub(super) fn overlap(&self, x: &[IBig], scale: i64, x_scale: i64, sum: &mut Sum) -> (Vec<IBig>, f64) {
        if self.vectors.is_empty() {
            return (Vec::new(), 0.0);
        }
        let size = length_1(x, x_scale);
        let mut square = 0.0;
        let own = |(image, error): (&Vec<IBig>, &f64)| {
            let exact = dot(image, x, sum);
            let part = double(&exact, -(scale + x_scale)).abs() + size * scaled(*error, -scale);
            square += part * part;
            exact
        };
        let overlap: Vec<IBig> = self.images.iter().zip(&self.image_error).map(own).collect();
        let leak = (square / (1.0 - self.defect)).sqrt() * (1.0 + 1e-9);
        (overlap, up(leak))
    }
}
