//! What the couplings between columns are: residuals at full precision, everything else in doubles
//! and double-doubles.
//!
//! For a column x_j as it stands, s_jj = x_jᵀKx_j, g_jj = x_jᵀMx_j and the residual
//! r_j = K x_j - μ_j M x_j, with μ_j the quotient s_jj / g_jj rounded, are sums of products of whole
//! numbers, exact up to the last rounding. The residual is small, so that its leading digits
//! determine the couplings h_ij = x_iᵀr_j = s_ij - μ_j g_ij: products in double-double do. Only where two
//! quotients are so close that this is not enough, the product is taken at full precision.

use dashu_int::IBig;

use super::data::Data;
use super::fixed::{LOST, Sum, dot, double, double_double, from_double_double, length, shifted};
use crate::modes::certify::Couplings;
use crate::modes::dense::{Matrix, Part, Plain, bound_product, product, product_bound};
use crate::modes::pencil::Bounded;
use crate::precision::{DoubleDouble, up};

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
    pub(super) g: Bounded,
}

/// See the head of the file. "Own" columns are those at full precision, m is the number of all.
pub(super) struct Measured {
    /// Of all columns, over 2^scale of the data.
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

fn scaled(x: f64, exponent: i64) -> f64 {
    DoubleDouble::exact(x)
        .scale(exponent.clamp(-4000, 4000) as i32)
        .hi
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
    let p = data.scale;
    let y = data.stiffness.times(x, sum);
    let z = data.mass.times(x, sum);
    let s = dot(x, &y, sum);
    let norm = dot(x, &z, sum);
    if norm <= IBig::ZERO {
        return None;
    }
    // Truncated: |s - μ g| <= 2^-p g.
    let quotient = (s << p as usize) / &norm;
    let residual = y
        .iter()
        .zip(&z)
        .map(|(y, z)| shifted(&((y << p as usize) - &quotient * z), -(x_scale + p)))
        .collect();
    Some(Image {
        quotient,
        residual,
        mass_times: z.iter().map(|z| shifted(z, -x_scale)).collect(),
        norm,
    })
}

/// `target`, by column: coupling that changes an eigenvalue by less than this may stay unknown.
pub(super) fn measure(
    data: &Data,
    columns: &Columns,
    background: Option<&Background>,
    target: &dyn Fn(f64) -> f64,
) -> Option<Measured> {
    let (n, p, x_scale) = (data.n, data.scale, columns.scale);
    let k = columns.own.len();
    let m = background.map_or(k, |b| b.quotients.len());
    let mut sum = Sum::default();
    let mut images = Vec::with_capacity(k);
    for x in &columns.x {
        images.push(image(data, x, x_scale, &mut sum)?);
    }
    let mut own = vec![usize::MAX; m];
    for (at, &column) in columns.own.iter().enumerate() {
        own[column] = at;
    }

    // Quotients and their order.
    let quotient: Vec<IBig> = (0..m)
        .map(|i| match (images.get(own[i]), background) {
            (Some(image), _) => image.quotient.clone(),
            (None, Some(b)) => from_double_double(b.quotients[i], p),
            (None, None) => IBig::ZERO,
        })
        .collect();
    let size: Vec<f64> = quotient.iter().map(|mu| up(double(mu, -p).abs())).collect();
    if size.iter().any(|size| !size.is_finite()) {
        return None;
    }
    let mut order: Vec<usize> = (0..m).collect();
    order.sort_by(|&i, &j| quotient[i].cmp(&quotient[j]));
    let steps = order
        .windows(2)
        .map(|pair| double(&(&quotient[pair[1]] - &quotient[pair[0]]), -p))
        .collect();
    let gap = |i: usize, j: usize| double(&(&quotient[i] - &quotient[j]), -p).abs();

    // All columns in double-double.
    let mut x = background.map_or_else(|| Matrix::zeros(n, m), |b| b.x.clone());
    for (at, &column) in columns.own.iter().enumerate() {
        for (row, value) in columns.x[at].iter().enumerate() {
            x.set(row, column, double_double(value, -x_scale));
        }
    }
    let sizes = x.magnitudes();
    let (xt, sizes_t) = (x.transposed(), sizes.transposed());
    let mut leak = background.map_or_else(|| vec![0.0; m], |b| b.leak.clone());
    let mut overlap = Vec::with_capacity(k);
    for (at, &column) in columns.own.iter().enumerate() {
        let (own, length) = data.zero.overlap(&columns.x[at], p, x_scale, &mut sum);
        overlap.push(own);
        leak[column] = length;
    }

    // What K and M are off by, and one unit for rounding, per unit of x_i.
    let mut own_sizes = Plain::zeros(n, k);
    for (at, &column) in columns.own.iter().enumerate() {
        own_sizes
            .column_mut(at)
            .copy_from_slice(sizes.column(column));
    }
    let of = |radius: &Option<Plain>| {
        radius
            .as_ref()
            .map(|radius| bound_product(radius, &own_sizes, Part::All))
    };
    let (off_k, off_m) = (of(&data.stiffness.radius), of(&data.mass.radius));
    let (mut off, mut off_mass) = (Plain::zeros(n, k), Plain::zeros(n, k));
    for (at, &column) in columns.own.iter().enumerate() {
        for row in 0..n {
            let mass = off_m.as_ref().map_or(0.0, |off| off.get(row, at));
            let stiffness = off_k.as_ref().map_or(0.0, |off| off.get(row, at));
            off.set(row, at, up(stiffness + size[column] * mass + 1.0));
            off_mass.set(row, at, up(mass + 1.0));
        }
    }
    let off = bound_product(&sizes_t, &off, Part::All);
    let off_mass = bound_product(&sizes_t, &off_mass, Part::All);

    // Residuals relative to their largest entry.
    let (mut residual, mut mass_times) = (Matrix::zeros(n, k), Matrix::zeros(n, k));
    let mut place = Vec::with_capacity(k);
    for (at, image) in images.iter().enumerate() {
        let top = image.residual.iter().map(length).max().unwrap_or(0) as i64 - p;
        for row in 0..n {
            residual.set(row, at, double_double(&image.residual[row], -p - top));
            mass_times.set(row, at, double_double(&image.mass_times[row], -p));
        }
        place.push(top);
    }
    let mut h = product(&xt, &residual, Part::All);
    let mut g = product(&xt, &mass_times, Part::All);
    // Both factors lose LOST of themselves when converted, and 2^-960 at the most where they are
    // small beside that.
    let unit = product_bound(n) + 2.25 * LOST;
    let mut noise = bound_product(&sizes_t, &residual.magnitudes(), Part::All);
    let mut noise_g = bound_product(&sizes_t, &mass_times.magnitudes(), Part::All);
    for (at, &place) in place.iter().enumerate() {
        for row in 0..m {
            let value = h.get(row, at).scale(place.clamp(-4000, 4000) as i32);
            h.set(row, at, value);
            let bound = up(unit * noise.get(row, at) + 1e-270);
            noise.set(row, at, up(scaled(bound, place)));
            noise_g.set(row, at, up(unit * noise_g.get(row, at) + 1e-270));
        }
    }

    let top = size.iter().fold(0.0, |most: f64, &x| most.max(x));
    // Where that is not enough: exact but for the rounding counted in `off`.
    for (at, &j) in columns.own.iter().enumerate() {
        let mut largest: f64 = 0.0;
        for i in 0..m {
            if i != j {
                largest = largest.max(effect(h.get(i, at).hi.abs(), gap(i, j)));
            }
        }
        let enough = target(size[j]).max(largest * 1e-3) / (16.0 * m as f64);
        for (i, &place) in own.iter().enumerate() {
            let (Some(xi), false) = (columns.x.get(place), i == j) else {
                continue;
            };
            let gap = gap(i, j);
            let open = effect(noise.get(i, at), gap) > enough;
            if open {
                let exact = double_double(&dot(xi, &images[at].residual, &mut sum), -(x_scale + p));
                h.set(i, at, exact);
                noise.set(i, at, up(LOST * exact.hi.abs()));
            }
            // The certificate sees |μ| |g_ij| beside the gap.
            let close = noise_g.get(i, at) * top * 16.0 * m as f64 > gap && gap > target(size[j]);
            if open || close {
                let z = &images[at].mass_times;
                let exact = double_double(&dot(xi, z, &mut sum), -(x_scale + p));
                g.set(i, at, exact);
                noise_g.set(i, at, up(LOST * exact.hi.abs()));
            }
        }
    }

    // Bounds. The exact pencil is the one of the complement of the zero vectors, whose entries of
    // XᵀMX are smaller by r_ij with |r_ij| <= leak_i leak_j (see `pencil`).
    let mut couplings = match background {
        Some(b) => with_rounded_quotients(&b.couplings, p),
        None => Couplings::zeros(m),
    };
    couplings.order = order;
    couplings.steps = steps;
    let mut norm = Vec::with_capacity(k);
    for (at, &j) in columns.own.iter().enumerate() {
        for i in 0..m {
            if i == j {
                continue;
            }
            let along = leak[i] * leak[j];
            let bound = up(h.get(i, at).hi.abs()
                + noise.get(i, at)
                + scaled(off.get(i, at), -p)
                + size[j] * along);
            couplings.h.set(i, j, up(bound));
            let bound = up(g.get(i, at).hi.abs()
                + noise_g.get(i, at)
                + scaled(off_mass.get(i, at), -p)
                + along);
            couplings.g.set(i, j, up(bound));
            if own[i] == usize::MAX {
                couplings.g.set(j, i, up(bound));
            }
        }
        let value = double_double(&images[at].norm, -(p + 2 * x_scale));
        let error = up(scaled(off_mass.get(j, at), -p) + leak[j] * leak[j] + LOST * value.hi);
        norm.push((value, error));
        couplings.least[j] = (value.hi - error) * (1.0 - 1e-15);
        couplings.most[j] = up(value.hi + error);
        couplings.size[j] = size[j];
        couplings.defect[j] = up(scaled(couplings.most[j], -p)
            + scaled(off.get(j, at), -p)
            + size[j] * leak[j] * leak[j]);
        // From here on the difference from the unit matrix.
        g.set(j, at, value - DoubleDouble::ONE);
    }
    for &j in &columns.own {
        for (i, &place) in own.iter().enumerate() {
            let stays = place == usize::MAX;
            if i == j || !stays && i > j {
                continue;
            }
            let gap = gap(i, j);
            if stays {
                // |s_ji - μ_i g_ji| <= |s_ij - μ_j g_ij| + |μ_i - μ_j| |g_ij|
                let bound = couplings.h.get(i, j) + gap * 1.000_001 * couplings.g.get(i, j);
                couplings.h.set(j, i, up(bound));
                continue;
            }
            // h_ij - h_ji = (μ_i - μ_j) g_ij
            let both = couplings.h.get(i, j) + couplings.h.get(j, i);
            let other = couplings.g.get(i, j).min(couplings.g.get(j, i));
            let bound = other.min(up(both * 1.000_001 / gap));
            couplings.g.set(i, j, bound);
            couplings.g.set(j, i, bound);
        }
    }
    Some(Measured {
        quotient,
        couplings,
        x,
        h,
        noise,
        g,
        overlap,
        leak,
        norm,
    })
}

/// The same columns with quotients rounded to 2^-p, by less than two units.
fn with_rounded_quotients(couplings: &Couplings, p: i64) -> Couplings {
    let mut result = couplings.clone();
    let off = scaled(2.0, -p);
    for j in 0..result.size.len() {
        result.size[j] = up(result.size[j] + off);
        result.defect[j] = up(result.defect[j] + off * result.most[j]);
        let g = couplings.g.column(j);
        for (h, g) in result.h.column_mut(j).iter_mut().zip(g) {
            *h = if *h == 0.0 && *g == 0.0 {
                0.0
            } else {
                up(*h + off * g)
            };
        }
    }
    result
}
