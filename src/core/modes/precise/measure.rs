//! What the couplings between columns are: residuals at full precision, everything else in doubles
//! and double-doubles.
//!
//! For a column x_j as it stands, s_jj = x_jᵀKx_j, g_jj = x_jᵀMx_j and the residual
//! r_j = K x_j - μ_j M x_j, with μ_j the quotient s_jj / g_jj rounded, are sums of products of whole
//! numbers, exact up to the last rounding. The residual is small, so that its leading digits
//! determine the couplings h_ij = x_iᵀr_j = s_ij - μ_j g_ij: products in double-double do. Only where two
//! quotients are so close that this is not enough, the product is taken at full precision.

use dashu_int::IBig;
use dashu_int::ops::BitTest;

use super::data::Data;
use super::fixed::{LOST, dot, double, double_double, from_double_double, scaled, shifted};
use super::plan::Goal;
use crate::modes::certify::Couplings;
use crate::modes::dense::{Matrix, Plain};
use crate::modes::pencil::Enclosed;
use crate::modes::product::{Part, bound_product, product, product_bound};
use crate::order::places;
use crate::precision::{DoubleDouble, Sum, up};

/// Columns at full precision.
pub(super) struct Columns {
    /// Entries over 2^scale.
    pub(super) scale: i64,
    /// Which columns of the whole basis they are, rising.
    pub(super) own: Vec<usize>,
    pub(super) x: Vec<Vec<IBig>>,
}

/// The columns that stay in double-double, and what is known of them: all columns, of which those
/// at full precision are disregarded.
pub(super) struct Background {
    pub(super) x: Matrix,
    pub(super) quotients: Vec<DoubleDouble>,
    pub(super) couplings: Couplings,
    pub(super) leak: Vec<f64>,
    pub(super) g: Enclosed,
}

/// See the head of the file. "Own" columns are those at full precision, m is the number of all.
pub(super) struct Measured {
    /// For each column its place among the own ones.
    pub(super) own: Vec<Option<usize>>,
    /// Of all columns, over 2^[`Data::quotient_scale`].
    pub(super) quotient: Vec<IBig>,
    pub(super) couplings: Couplings,
    /// All columns, and their magnitudes.
    pub(super) x: Matrix,
    /// x_iᵀr_j for all columns i and own columns j, and what it may be off by.
    pub(super) h: Matrix,
    pub(super) noise: Plain,
    /// x_iᵀMx_j - δ_ij likewise, in double-double or better.
    pub(super) g: Matrix,
    /// ZᵀMx_j of own columns.
    pub(super) overlap: Vec<Vec<IBig>>,
    /// Of all columns: a bound of the M-length along the zero vectors.
    pub(super) leak: Vec<f64>,
    /// x_jᵀMx_j of own columns and how far it may be off.
    pub(super) norm: Vec<(DoubleDouble, f64)>,
}

/// What a coupling does to an eigenvalue at most, roughly: h² / gap, and h at most.
fn effect(h: f64, gap: f64) -> f64 {
    if h <= gap { h * (h / gap) } else { h }
}

/// Per own column, exactly as it stands.
struct Image {
    quotient: IBig,
    /// Over 2^scale of the data, off by less than one unit.
    residual: Vec<IBig>,
    mass_times: Vec<IBig>,
    norm: IBig,
}

/// `None` if some column has no positive length.
fn image(data: &Data, x: &[IBig], x_scale: i64, sum: &mut Sum) -> Option<Image> {
    let q = data.quotient_scale();
    let y = data.stiffness.times(x, sum);
    let z = data.mass.times(x, sum);
    let s = dot(x, &y, sum);
    let norm = dot(x, &z, sum);
    if norm <= IBig::ZERO {
        return None;
    }
    // Truncated: |s - μ g| <= 2^-q g.
    let quotient = (s << q as usize) / &norm;
    let residual =
        y.iter().zip(&z).map(|(y, z)| shifted(&((y << q as usize) - &quotient * z), -(x_scale + q))).collect();
    Some(Image { quotient, residual, mass_times: z.iter().map(|z| shifted(z, -x_scale)).collect(), norm })
}

/// Columns at full precision, a basis around them, and what follows from both.
struct Setting<'a> {
    data: &'a Data,
    columns: &'a Columns,
    /// For each column of the basis its place among the own ones.
    own: Vec<Option<usize>>,
    images: Vec<Image>,
    quotient: Vec<IBig>,
    /// Bounds of |μ|.
    size: Vec<f64>,
    /// The basis in double-double and its magnitudes.
    x: Matrix,
    sizes: Plain,
}

/// x_iᵀr_j and x_iᵀMx_j for all columns i and own columns j, and what they may be off by.
struct Products {
    h: Matrix,
    noise: Plain,
    g: Matrix,
    noise_g: Plain,
}

/// What the entries of K - μ_j M, and of M, are off by and one unit of rounding come to in the
/// products, in units.
struct Off {
    h: Plain,
    g: Plain,
}

/// What the columns are to one another; a coupling that changes an eigenvalue by less than the `goal` may stay unknown.
pub(super) fn measure(
    data: &Data,
    columns: &Columns,
    background: Option<&Background>,
    goal: &Goal,
) -> Option<Measured> {
    let mut sum = Sum::default();
    let setting = Setting::new(data, columns, background, &mut sum)?;
    let mut products = setting.products();
    setting.sharpen(&mut products, goal, &mut sum);
    let mut leak = background.map_or_else(|| vec![0.0; setting.own.len()], |b| b.leak.clone());
    let mut overlap = Vec::with_capacity(columns.own.len());
    for (x, &column) in columns.x.iter().zip(&columns.own) {
        let (own, length) = data.zero.overlap(x, data.scale, columns.scale, &mut sum);
        overlap.push(own);
        leak[column] = length;
    }
    let (couplings, norm) = setting.bounds(&products, background, &leak);
    let Products { h, noise, mut g, .. } = products;
    for (at, (&j, (norm, _))) in columns.own.iter().zip(&norm).enumerate() {
        g.set(j, at, *norm - DoubleDouble::ONE);
    }
    let Setting { own, quotient, x, .. } = setting;
    Some(Measured { own, quotient, couplings, x, h, noise, g, overlap, leak, norm })
}

impl<'a> Setting<'a> {
    fn new(data: &'a Data, columns: &'a Columns, background: Option<&Background>, sum: &mut Sum) -> Option<Self> {
        let m = background.map_or(columns.own.len(), |b| b.quotients.len());
        let images = columns.x.iter().map(|x| image(data, x, columns.scale, sum)).collect::<Option<Vec<Image>>>()?;
        let mut own = vec![None; m];
        let mut x = background.map_or_else(|| Matrix::zeros(data.n, m), |b| b.x.clone());
        for (at, &column) in columns.own.iter().enumerate() {
            own[column] = Some(at);
            for (row, value) in columns.x[at].iter().enumerate() {
                x.set(row, column, double_double(value, -columns.scale));
            }
        }
        let q = data.quotient_scale();
        let quotient = |i: usize| match (own[i], background) {
            (Some(at), _) => images[at].quotient.clone(),
            (None, Some(b)) => from_double_double(b.quotients[i], q),
            (None, None) => IBig::ZERO,
        };
        let quotient: Vec<IBig> = (0..m).map(quotient).collect();
        let size: Vec<f64> = quotient.iter().map(|mu| up(double(mu, -q).abs())).collect();
        let sizes = x.magnitudes();
        let is_finite = size.iter().all(|size| size.is_finite());
        is_finite.then_some(Self { data, columns, own, images, quotient, size, x, sizes })
    }

    fn gap(&self, i: usize, j: usize) -> f64 {
        let difference = &self.quotient[i] - &self.quotient[j];
        double(&difference, -self.data.quotient_scale()).abs()
    }

    /// In double-double. Both factors lose LOST of themselves when converted, and 2^-960 at the most
    /// where they are small beside that; residuals are taken relative to their largest entry.
    fn products(&self) -> Products {
        let (n, p, k) = (self.data.n, self.data.scale, self.images.len());
        let top = |image: &Image| image.residual.iter().map(BitTest::bit_len).max().unwrap_or(0) as i64 - p;
        let place: Vec<i64> = self.images.iter().map(top).collect();
        let residual = |row: usize, at: usize| double_double(&self.images[at].residual[row], -p - place[at]);
        let mass_times = |row: usize, at: usize| double_double(&self.images[at].mass_times[row], -p);
        let (residual, mass_times) = (Matrix::from_fn(n, k, residual), Matrix::from_fn(n, k, mass_times));
        let (xt, sizes_t) = (self.x.transposed(), self.sizes.transposed());
        let h = product(&xt, &residual, Part::All);
        let (noise, noise_g) =
            (bound_product(&sizes_t, &residual.magnitudes()), bound_product(&sizes_t, &mass_times.magnitudes()));
        let (m, unit) = (self.own.len(), product_bound(n) + 2.25 * LOST);
        let bound = |noise: f64| up(unit * noise + 1e-270);
        Products {
            h: Matrix::from_fn(m, k, |row, at| h.get(row, at).scale(place[at].clamp(-4000, 4000) as i32)),
            noise: Plain::from_fn(m, k, |row, at| up(scaled(bound(noise.get(row, at)), place[at]))),
            g: product(&xt, &mass_times, Part::All),
            noise_g: Plain::from_fn(m, k, |row, at| bound(noise_g.get(row, at))),
        }
    }

    /// Takes products at full precision where double-double is not enough; they are exact then but
    /// for what is counted in [`Off`], and 2^-960.
    fn sharpen(&self, products: &mut Products, goal: &Goal, sum: &mut Sum) {
        let m = self.own.len() as f64;
        let top = self.size.iter().fold(0.0, |most: f64, &x| most.max(x));
        let place = -(self.columns.scale + self.data.scale);
        let mut take = |x: &[IBig], y: &[IBig]| {
            let exact = double_double(&dot(x, y, sum), place);
            (exact, up(LOST * exact.hi.abs() + 1e-286))
        };
        for (at, &j) in self.columns.own.iter().enumerate() {
            let gaps: Vec<f64> = (0..self.own.len()).map(|i| self.gap(i, j)).collect();
            let others = gaps.iter().enumerate().filter(|(i, _)| *i != j);
            let largest = others.map(|(i, gap)| effect(products.h.get(i, at).hi.abs(), *gap)).fold(0.0, f64::max);
            let target = goal.target(self.size[j]);
            let enough = target.max(largest * 1e-3) / (16.0 * m);
            for (i, &gap) in gaps.iter().enumerate() {
                let (Some(other), false) = (self.own[i], i == j) else { continue };
                let x = &self.columns.x[other];
                let open = effect(products.noise.get(i, at), gap) > enough;
                if open {
                    let (exact, noise) = take(x, &self.images[at].residual);
                    products.h.set(i, at, exact);
                    products.noise.set(i, at, noise);
                }
                // The certificate sees |μ| |g_ij| beside the gap.
                let close = products.noise_g.get(i, at) * top * 16.0 * m > gap && gap > target;
                if open || close {
                    let (exact, noise) = take(x, &self.images[at].mass_times);
                    products.g.set(i, at, exact);
                    products.noise_g.set(i, at, noise);
                }
            }
        }
    }

    fn off(&self) -> Off {
        let (n, k) = (self.data.n, self.images.len());
        let columns = &self.columns.own;
        let own = Plain::from_fn(n, k, |row, at| self.sizes.get(row, columns[at]));
        let of = |radius: &Option<Plain>| radius.as_ref().map(|radius| bound_product(radius, &own));
        let stiffness = of(&self.data.stiffness.radius);
        let mass = of(&self.data.mass.radius);
        let entry = |off: &Option<Plain>, row, at| off.as_ref().map_or(0.0, |off| off.get(row, at));
        let h = Plain::from_fn(n, k, |row, at| {
            up(entry(&stiffness, row, at) + self.size[columns[at]] * entry(&mass, row, at) + 1.0)
        });
        let g = Plain::from_fn(n, k, |row, at| up(entry(&mass, row, at) + 1.0));
        let sizes_t = self.sizes.transposed();
        Off { h: bound_product(&sizes_t, &h), g: bound_product(&sizes_t, &g) }
    }

    /// Bounds of all couplings, and x_jᵀMx_j of own columns.
    ///
    /// The exact pencil is that of the complement of the zero vectors, whose entries of XᵀMX are
    /// smaller by r_ij with |r_ij| <= leak_i leak_j (see [`crate::modes::pencil::pencil`]).
    fn bounds(
        &self,
        products: &Products,
        background: Option<&Background>,
        leak: &[f64],
    ) -> (Couplings, Vec<(DoubleDouble, f64)>) {
        let (m, p, q) = (self.own.len(), self.data.scale, self.data.quotient_scale());
        let off = self.off();
        let known = background.map(|b| with_rounded_quotients(&b.couplings, q));
        let mut couplings = known.unwrap_or_else(|| Couplings::zeros(m));
        couplings.order = places(m, &mut |i, j| self.quotient[*i].cmp(&self.quotient[*j]));
        let order = couplings.order.windows(2);
        couplings.steps = order.map(|pair| self.gap(pair[0], pair[1])).collect();
        let mut norms = Vec::with_capacity(self.images.len());
        for (at, &j) in self.columns.own.iter().enumerate() {
            for i in (0..m).filter(|&i| i != j) {
                let along = leak[i] * leak[j];
                let (h, g) = (products.h.get(i, at).hi, products.g.get(i, at).hi);
                let error = products.noise.get(i, at) + scaled(off.h.get(i, at), -p);
                let h = up(h.abs() * (1.0 + 1e-15) + error + self.size[j] * along);
                let error = products.noise_g.get(i, at) + scaled(off.g.get(i, at), -p);
                let g = up(g.abs() * (1.0 + 1e-15) + error + along);
                couplings.h.set(i, j, h);
                couplings.g.set(i, j, g);
                if self.own[i].is_none() {
                    couplings.g.set(j, i, g);
                }
            }
            let place = -(p + 2 * self.columns.scale);
            let norm = double_double(&self.images[at].norm, place);
            let along = leak[j] * leak[j];
            let error = up(scaled(off.g.get(j, at), -p) + along + LOST * norm.hi);
            norms.push((norm, error));
            couplings.least[j] = (norm.hi - error) * (1.0 - 1e-15);
            couplings.most[j] = up(norm.hi + error);
            couplings.size[j] = self.size[j];
            couplings.defect[j] =
                up(scaled(couplings.most[j], -q) + scaled(off.h.get(j, at), -p) + self.size[j] * along);
        }
        for &j in &self.columns.own {
            for i in 0..m {
                if i == j || self.own[i].is_some() && i > j {
                    continue;
                }
                let gap = self.gap(i, j);
                if self.own[i].is_none() {
                    // |s_ji - μ_i g_ji| <= |s_ij - μ_j g_ij| + |μ_i - μ_j| |g_ij|
                    let bound = couplings.h.get(i, j) + gap * 1.000_001 * couplings.g.get(i, j);
                    couplings.h.set(j, i, up(bound));
                    continue;
                }
                // (s_ij - μ_j g_ij) - (s_ij - μ_i g_ij) = (μ_i - μ_j) g_ij
                let both = couplings.h.get(i, j) + couplings.h.get(j, i);
                let bound = couplings.g.get(i, j).min(couplings.g.get(j, i));
                couplings.g.set_both(i, j, bound.min(up(both * 1.000_001 / gap)));
            }
        }
        (couplings, norms)
    }
}

/// The same columns with quotients rounded to 2^-q, by less than two units.
fn with_rounded_quotients(couplings: &Couplings, q: i64) -> Couplings {
    let mut result = couplings.clone();
    let off = scaled(2.0, -q);
    for j in 0..result.size.len() {
        result.size[j] = up(result.size[j] + off);
        result.defect[j] = up(result.defect[j] + off * result.most[j]);
        let g = couplings.g.column(j);
        for (h, g) in result.h.column_mut(j).iter_mut().zip(g) {
            *h = if *h == 0.0 && *g == 0.0 { 0.0 } else { up(*h + off * g) };
        }
    }
    result
}
