//! The certificate at the price of a few products of doubles, for problems of more than some dozen
//! coordinates.
//!
//! Only the quotients μ_j = x_jᵀKx_j / x_jᵀMx_j need more than doubles, and the residuals r_j = K x_j - μ_j M x_j,
//! which are small differences of large numbers; both come from K X and M X in double-double
//! (`image`). From then on everything is small or need not be accurate: the couplings
//! s_ij - μ_j g_ij = x_iᵀr_j are products of doubles whose rounding is as small beside r_j as doubles are beside
//! one. All bounds are taken in length (Cauchy, Schwarz), so that they cost nothing; a problem
//! whose grading is lost in them is left to the pencil in double-double.

use super::certify::Couplings;
use super::dense::{Matrix, Plain, gamma, multiply};
use super::image::{Image, Operator, row_lengths};
use super::pencil::{Scaled, ZeroSpace, ordered};
use super::product::{Part, product, product_bound, residuals, row_products};
use crate::precision::{Ball, DoubleDouble, U2, up};

/// The problem, prepared for several rounds.
pub(super) struct Quick<'a> {
    zero: &'a ZeroSpace,
    mass: Operator<'a>,
    stiffness: Operator<'a>,
    /// The zero vectors' images and bounds of the length of what they are off by.
    zero_images: Matrix,
    zero_errors: Vec<f64>,
}

/// Columns with all that is known of them.
pub(super) struct Round {
    /// Xᵀ and (M X)ᵀ.
    xt: Matrix,
    mass_image: Image,
    lengths: Vec<f64>,
    quotient: Vec<DoubleDouble>,
    /// Bounds of |s_jj - μ_j g_jj|.
    defect: Vec<f64>,
    /// x_jᵀMx_j
    norm: Vec<Ball>,
    /// Near x_iᵀr_j, off by at most lengths_i h_error_j.
    h: Plain,
    h_error: Vec<f64>,
    /// Near x_iᵀMx_j, off by at most lengths_i g_error_j.
    g: Plain,
    g_error: Vec<f64>,
    /// What the columns still have of the zero vectors: XᵀMZ, and bounds of the lengths of those parts.
    overlap: Matrix,
    leak: Vec<f64>,
}

impl<'a> Quick<'a> {
    pub(super) fn new(scaled: &'a Scaled, zero: &'a ZeroSpace) -> Self {
        let (image, errors) = zero.image();
        Self {
            zero,
            mass: Operator::new(&scaled.mass),
            stiffness: Operator::new(&scaled.stiffness),
            zero_images: image.transposed(),
            zero_errors: errors,
        }
    }

    /// Looks at columns X, given as Xᵀ.
    pub(super) fn round(&self, xt: Matrix, slices: usize) -> Round {
        let (m, n) = (xt.rows, xt.columns);
        let of_rows = |a: &Matrix| row_lengths(m, (0..n).map(|i| a.column_hi(i)));
        let lengths = of_rows(&xt);
        let y = self.stiffness.image(&xt, &lengths, slices);
        let z = self.mass.image(&xt, &lengths, slices);
        let (y_lengths, z_lengths) = (of_rows(&y.value), of_rows(&z.value));
        let form = |image: &Image, image_lengths: &[f64]| -> Vec<Ball> {
            let unit = product_bound(n);
            row_products(&xt, &image.value)
                .into_iter()
                .enumerate()
                .map(|(j, value)| {
                    let error = image.error[j] + unit * image_lengths[j];
                    Ball::new(value, up(lengths[j] * error))
                })
                .collect()
        };
        let s = form(&y, &y_lengths);
        let norm = form(&z, &z_lengths);
        let mut quotient = Vec::with_capacity(m);
        let mut defect = Vec::with_capacity(m);
        for (s, g) in s.iter().zip(&norm) {
            let mu = s.mid / g.mid;
            // The division is off by 16 u² of the quotient.
            let error = 17.0 * U2 * s.mid.hi.abs() + s.radius + mu.hi.abs() * g.radius;
            quotient.push(mu);
            defect.push(if mu.is_finite() {
                up(error)
            } else {
                f64::INFINITY
            });
        }
        let residual = residuals(&y.value, &z.value, &quotient);
        let residual_lengths = row_lengths(m, (0..n).map(|i| residual.column(i)));
        let h = multiply(xt.hi(), residual.view().transposed());
        let g = multiply(xt.hi(), z.value.hi().transposed());
        // |fl(XᵀR) - XᵀR| <= γ |X|ᵀ|R|; the low parts of X are below u |X|. The residuals themselves are off by
        // the images' errors, 16 u² for product and difference, and u for rounding to doubles.
        let rounding = gamma(n) + f64::EPSILON;
        let h_error = (0..m)
            .map(|j| {
                let mu = quotient[j].hi.abs();
                let image = y.error[j] + mu * z.error[j];
                let doubles = 16.0 * U2 * (y_lengths[j] + mu * z_lengths[j]);
                up(image + doubles + (rounding + f64::EPSILON) * residual_lengths[j] + 1e-290)
            })
            .collect();
        let g_error = (0..m)
            .map(|j| up(z.error[j] + (rounding + f64::EPSILON) * z_lengths[j] + 1e-290))
            .collect();
        let (overlap, leak) = self.overlap(&xt, &lengths);
        Round {
            xt,
            mass_image: z,
            lengths,
            quotient,
            defect,
            norm,
            h,
            h_error,
            g,
            g_error,
            overlap,
            leak,
        }
    }

    /// XᵀMZ, and for each column a bound of the M-length of its part along the zero vectors.
    fn overlap(&self, xt: &Matrix, lengths: &[f64]) -> (Matrix, Vec<f64>) {
        let (m, z) = (xt.rows, self.zero_errors.len());
        if z == 0 {
            return (Matrix::zeros(m, 0), vec![0.0; m]);
        }
        let overlap = product(xt, &self.zero_images, Part::All);
        let leak = (0..m)
            .map(|j| {
                let square: f64 = (0..z)
                    .map(|p| {
                        let error = self.zero_errors[p] * lengths[j];
                        let r = overlap.get(j, p).hi.abs() * (1.0 + 1e-15) + error;
                        r * r
                    })
                    .sum();
                up((square / (1.0 - self.zero.defect())).sqrt() * (1.0 + 1e-9) + 1e-150)
            })
            .collect();
        (overlap, leak)
    }

    /// X <- X - Z (ZᵀMX)
    pub(super) fn without_zero_part(&self, xt: &mut Matrix, overlap: &Matrix) {
        if overlap.columns == 0 {
            return;
        }
        let mut along = product(overlap, &self.zero.mid.transposed(), Part::All);
        along.negate();
        xt.add_assign(&along);
    }
}

impl Round {
    pub(super) fn columns(&self) -> &Matrix {
        &self.xt
    }

    pub(super) fn overlap(&self) -> &Matrix {
        &self.overlap
    }

    pub(super) fn leak(&self) -> &[f64] {
        &self.leak
    }

    pub(super) fn quotients(&self) -> &[DoubleDouble] {
        &self.quotient
    }

    /// x_jᵀMx_j with a bound.
    pub(super) fn norm(&self, j: usize) -> Ball {
        self.norm[j]
    }

    /// x_iᵀMx_j for some columns, without bounds.
    pub(super) fn gram(&self, columns: &[usize]) -> Matrix {
        let x = self.xt.gather_rows(columns);
        let z = self.mass_image.value.gather_rows(columns).transposed();
        product(&x, &z, Part::Lower)
    }

    /// How the columns are coupled once the zero vectors are taken out; see `pencil`: that changes G
    /// by at most leak_i leak_j, and S not at all.
    pub(super) fn couplings(&self) -> Option<Couplings> {
        let m = self.quotient.len();
        if !self.quotient.iter().all(|mu| mu.is_finite()) {
            return None;
        }
        let (order, steps) = ordered(&self.quotient);
        let size: Vec<f64> = self.quotient.iter().map(|mu| up(mu.hi.abs())).collect();
        let (mut h, mut g) = (Plain::zeros(m, m), Plain::zeros(m, m));
        for (j, &mu) in size.iter().enumerate() {
            let (h_error, g_error, leak) = (self.h_error[j], self.g_error[j], self.leak[j]);
            let columns = self.h.column(j).iter().zip(self.g.column(j));
            let to = h.column_mut(j).iter_mut().zip(g.column_mut(j));
            for ((((to_h, to_g), (x, y)), length), other) in
                to.zip(columns).zip(&self.lengths).zip(&self.leak)
            {
                let shared = other * leak;
                *to_h = up(x.abs() + length * h_error + mu * shared);
                *to_g = up(y.abs() + length * g_error + shared);
            }
            h.set(j, j, 0.0);
            g.set(j, j, 0.0);
        }
        let defect = (0..m)
            .map(|j| up(self.defect[j] + size[j] * self.leak[j] * self.leak[j]))
            .collect();
        let square = |j: usize| up(self.leak[j] * self.leak[j]);
        Some(Couplings {
            least: (0..m)
                .map(|j| self.norm[j].with_added_radius(square(j)).lower())
                .collect(),
            most: (0..m).map(|j| self.norm[j].upper()).collect(),
            order,
            steps,
            size,
            defect,
            h,
            g,
        })
    }
}

impl super::refine::Mixed for Round {
    fn quotient(&self, i: usize) -> DoubleDouble {
        self.quotient[i]
    }

    fn coupling(&self, i: usize, j: usize) -> f64 {
        self.h.get(i, j)
    }

    fn overlap(&self, i: usize, j: usize) -> f64 {
        self.g.get(i, j)
    }

    fn excess(&self, i: usize) -> f64 {
        (self.norm[i].mid - DoubleDouble::ONE).hi
    }

    fn noise(&self, i: usize, j: usize) -> f64 {
        self.lengths[i] * self.h_error[j] + self.lengths[j] * self.h_error[i]
    }
}
