//! The certificate at the price of a few products of doubles, for problems of more than some dozen
//! coordinates.
//!
//! Only the quotients μ_j = x_jᵀKx_j / x_jᵀMx_j need more than doubles, and the residuals r_j = K x_j - μ_j M x_j,
//! which are small differences of large numbers; both come from K X and M X in double-double
//! (`image`). From then on everything is small or need not be accurate: the couplings
//! s_ij - μ_j g_ij = x_iᵀr_j are products of doubles whose rounding is as small beside r_j as doubles are beside
//! one. All bounds are taken in length (Cauchy, Schwarz), so that they cost nothing; a problem
//! whose grading is lost in them is left to the pencil in double-double.
//!
//! The overlaps follow from these, as (s_ij - μ_j g_ij) - (s_ij - μ_i g_ij) = (μ_i - μ_j) g_ij.

use std::borrow::Cow;
use std::cell::{Cell, OnceCell};

use super::certify::Couplings;
use super::dense::{Matrix, Plain, gamma, multiply};
use super::image::{Image, Operator, lengths_of_rows, row_lengths};
use super::pencil::{Scaled, ZeroSpace, ordered};
use super::product::{Part, product, residuals};
use crate::precision::{Ball, DoubleDouble, U2, kernel, up};

/// The problem, prepared for several rounds.
pub(super) struct Quick<'a> {
    pub(super) zero: &'a ZeroSpace,
    mass: Operator<'a>,
    stiffness: Operator<'a>,
    /// The zero vectors' images and bounds of the length of what they are off by.
    zero_images: Matrix,
    zero_errors: Vec<f64>,
}

/// Columns with all that is known of them.
pub(super) struct Round {
    /// Xᵀ, (K X)ᵀ and (M X)ᵀ.
    pub(super) xt: Matrix,
    mass_image: Image,
    lengths: Vec<f64>,
    pub(super) quotient: Vec<DoubleDouble>,
    /// Bounds of |s_jj - μ_j g_jj|.
    defect: Vec<f64>,
    /// x_jᵀMx_j
    pub(super) norm: Vec<Ball>,
    /// Near r_j, in rows.
    residual: Plain,
    /// Near x_iᵀr_j, off by at most lengths_i h_error_j; made when asked for.
    h: OnceCell<Plain>,
    h_error: Vec<f64>,
    /// Near x_iᵀMx_j, off by at most lengths_i g_error_j; made when many entries are asked for.
    g: OnceCell<Plain>,
    g_error: Vec<f64>,
    asked: Cell<usize>,
    /// What the columns still have of the zero vectors: XᵀMZ, and bounds of the lengths of those parts.
    pub(super) overlap: Matrix,
    pub(super) leak: Vec<f64>,
}

/// A pair is close where its overlap is not bounded by this from its couplings.
const CLOSE: f64 = 1e-9;

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

    /// Measures columns X, given as Xᵀ.
    pub(super) fn round(&self, xt: Matrix, slices: usize) -> Round {
        let lengths = lengths_of_rows(&xt);
        let y = self.stiffness.image(&xt, &lengths, slices);
        let z = self.mass.image(&xt, &lengths, slices);
        let s = y.products_with(&xt, &lengths);
        let norm = z.products_with(&xt, &lengths);
        let (m, n) = (xt.rows, xt.columns);
        let (y_lengths, z_lengths) = (lengths_of_rows(&y.value), lengths_of_rows(&z.value));
        let quotients = s.iter().zip(&norm).map(|(s, g)| {
            let mu = s.mid / g.mid;
            // The division is off by 16 u² of the quotient.
            let error = 17.0 * U2 * s.mid.hi.abs() + s.radius + mu.hi.abs() * g.radius;
            (mu, if mu.is_finite() { up(error) } else { f64::INFINITY })
        });
        let (quotient, defect): (Vec<DoubleDouble>, Vec<f64>) = quotients.unzip();
        let residual = residuals(&y.value, &z.value, &quotient);
        let residual_lengths = row_lengths(m, (0..n).map(|i| residual.column(i)));
        // |fl(XᵀR) - XᵀR| <= γ |X|ᵀ|R|; the low parts of X are below u |X|. The residuals themselves are off by
        // the images' errors, 16 u² for product and difference, and u for rounding to doubles.
        let rounding = gamma(n) + f64::EPSILON;
        let h_error = |j: usize| {
            let mu = quotient[j].hi.abs();
            let image = y.error[j] + mu * z.error[j];
            let doubles = 16.0 * U2 * (y_lengths[j] + mu * z_lengths[j]);
            up(image + doubles + (rounding + f64::EPSILON) * residual_lengths[j] + 1e-290)
        };
        let h_error = (0..m).map(h_error).collect();
        let g_error = (0..m).map(|j| up(z.error[j] + (rounding + f64::EPSILON) * z_lengths[j] + 1e-290)).collect();
        let (overlap, leak) = self.overlap(&xt, &lengths);
        Round {
            xt,
            mass_image: z,
            lengths,
            quotient,
            defect,
            norm,
            residual,
            h: OnceCell::new(),
            h_error,
            g: OnceCell::new(),
            g_error,
            asked: Cell::new(0),
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
        let part = |j: usize, p: usize| overlap.get(j, p).hi.abs() * (1.0 + 1e-15) + self.zero_errors[p] * lengths[j];
        let leak = |j: usize| {
            let square: f64 = (0..z).map(|p| part(j, p).powi(2)).sum();
            up((square / (1.0 - self.zero.defect)).sqrt() * (1.0 + 1e-9) + 1e-150)
        };
        let leak = (0..m).map(leak).collect();
        (overlap, leak)
    }
}

impl Round {
    /// x_iᵀMx_j for some columns, without bounds.
    pub(super) fn gram(&self, columns: &[usize]) -> Matrix {
        let x = self.xt.gather_rows(columns);
        let z = self.mass_image.value.gather_rows(columns).transposed();
        product(&x, &z, Part::Lower)
    }

    /// Near x_iᵀr_j for all pairs.
    fn h(&self) -> &Plain {
        self.h.get_or_init(|| multiply(self.xt.hi.view(), self.residual.view().transpose()))
    }

    /// Near x_iᵀMx_j for all pairs.
    fn g(&self) -> &Plain {
        self.g.get_or_init(|| multiply(self.xt.hi.view(), self.mass_image.value.hi.view().transpose()))
    }

    /// Near x_iᵀMx_j for one pair; for all where many have been asked for.
    fn g_entry(&self, i: usize, j: usize) -> f64 {
        let asked = self.asked.get();
        self.asked.set(asked + 1);
        if self.g.get().is_some() || asked > self.quotient.len() {
            return self.g().get(i, j);
        }
        self.xt.hi.row(i).zip(self.mass_image.value.hi.row(j)).map(|(x, image)| x * image).sum()
    }

    /// Whether all numbers are in range.
    pub(super) fn is_finite(&self) -> bool {
        self.quotient.iter().all(|mu| mu.is_finite())
    }

    /// Whether some neighbours are coupled by more than this beside the distance of their quotients.
    pub(super) fn is_mixed(&self, most: f64) -> bool {
        let (order, steps) = ordered(&self.quotient);
        let mut neighbours = order.windows(2).zip(&steps);
        let apart = |i: usize, j: usize, step: f64| self.h().get(i, j).abs() <= most * step;
        !neighbours.all(|(pair, step)| apart(pair[0], pair[1], *step))
    }

    /// How the columns are coupled once the zero vectors are taken out; see `pencil`: that changes G
    /// by at most leak_i leak_j, and S not at all.
    pub(super) fn couplings(&self) -> Couplings {
        let m = self.quotient.len();
        let (order, steps) = ordered(&self.quotient);
        let size: Vec<f64> = self.quotient.iter().map(|mu| up(mu.hi.abs())).collect();
        let (mut h, mut g) = self.bounds();
        for (j, &mu) in size.iter().enumerate() {
            let leak = self.leak[j];
            if leak > 0.0 {
                let columns = h.column_mut(j).iter_mut().zip(g.column_mut(j));
                for ((h, g), other) in columns.zip(&self.leak) {
                    let shared = other * leak;
                    *h = up(*h + mu * shared);
                    *g = up(*g + shared);
                }
            }
            h.set(j, j, 0.0);
            g.set(j, j, 0.0);
        }
        let defect = (0..m).map(|j| up(self.defect[j] + size[j] * self.leak[j] * self.leak[j])).collect();
        let square = |j: usize| up(self.leak[j] * self.leak[j]);
        Couplings {
            least: (0..m).map(|j| self.norm[j].with_added_radius(square(j)).lower()).collect(),
            most: (0..m).map(|j| self.norm[j].upper()).collect(),
            order,
            steps,
            size,
            defect,
            h,
            g,
        }
    }

    /// Bounds of |h_ij| = |s_ij - μ_j g_ij|, and those of the overlaps from them, |g_ij| <= (|h_ij| + |h_ji|) / |μ_i - μ_j|. For
    /// close pairs these from their own products.
    fn bounds(&self) -> (Plain, Plain) {
        let m = self.quotient.len();
        let mut h = self.h().clone();
        for j in 0..m {
            let error = self.h_error[j];
            for (h, length) in h.column_mut(j).iter_mut().zip(&self.lengths) {
                *h = up(h.abs() + length * error);
            }
        }
        let mut g = h.transposed();
        let hi: Vec<f64> = self.quotient.iter().map(|mu| mu.hi).collect();
        let lo: Vec<f64> = self.quotient.iter().map(|mu| mu.lo).collect();
        run_overlaps((&hi, &lo), &h, &mut g);
        for j in 0..m {
            for i in (0..m).filter(|i| *i != j) {
                if !(0.0..=CLOSE).contains(&g.get(i, j)) {
                    let overlap = self.g_entry(i, j).abs() + self.lengths[i] * self.g_error[j];
                    g.set(i, j, up(overlap));
                }
            }
        }
        (h, g)
    }
}

kernel!(run_overlaps, overlap_loops, (quotient: (&[f64], &[f64]), h: &Plain, g: &mut Plain));

/// (g_ij + h_ij) / |μ_i - μ_j| in the place of g_ij.
#[inline(always)]
fn overlap_loops<const FUSED: bool>((hi, lo): (&[f64], &[f64]), h: &Plain, g: &mut Plain) {
    let m = hi.len();
    for j in 0..m {
        let (mu_hi, mu_lo) = (hi[j], lo[j]);
        let columns = g.column_mut(j).iter_mut().zip(h.column(j));
        for ((g, h), (hi, lo)) in columns.zip(hi.iter().zip(lo)) {
            // Three roundings, of at most u of what is there, and of u² of the quotients.
            let apart = ((hi - mu_hi) + (lo - mu_lo)).abs();
            let rounded = 4.0 * U2 * (hi.abs() + mu_hi.abs());
            let gap = apart * (1.0 - 4.0 * f64::EPSILON) - rounded;
            *g = up((*g + h) / gap);
        }
        g.set(j, j, 0.0);
    }
}

impl super::refine::Mixed for Round {
    fn quotients(&self) -> &[DoubleDouble] {
        &self.quotient
    }

    fn coupling(&self, i: usize, j: usize) -> f64 {
        self.h().get(i, j)
    }

    fn couplings(&self) -> Cow<'_, Plain> {
        Cow::Borrowed(self.h())
    }

    fn overlap(&self, i: usize, j: usize) -> f64 {
        self.g_entry(i, j)
    }

    fn excess(&self, i: usize) -> f64 {
        (self.norm[i].mid - DoubleDouble::ONE).hi
    }

    fn noise(&self, i: usize, j: usize) -> f64 {
        self.lengths[i] * self.h_error[j] + self.lengths[j] * self.h_error[i]
    }
}
