//! That a point found by the search has an equilibrium beside it, and how close: a proof.
//!
//! The forces F on the free coordinates are examined in the coordinates z of q = q~ + W z, where
//! the columns of W are the principal axes of the stiffness at the point found, scaled so that
//! S WᵀKW is nearly the unit matrix, S being the signs of the eigenvalues. Krawczyk's operator for
//! G(z) = S WᵀF(q~ + W z) on the box |z| <= r then says (Krawczyk, Computing 4 (1969) 187; Moore,
//! SIAM J. Numer. Anal. 14 (1977) 611; Rump, Acta Numerica 19 (2010) 287, theorem 13.3):
//!
//! > if |G(0)| + |D| r < r in every component, where D runs over 1 - S WᵀKW for all K over the box,
//! > then G has exactly one zero in the box.
//!
//! As G(0) = G(0) - G(z*) = -(1 - D)z* for one such D, z* obeys |z*| <= |G(0)| + |D||z*|. In the norm
//! ‖z‖ = max |zᵢ|/rᵢ, for which θ = max (|D|r)ᵢ/rᵢ < 1 bounds D, that is ‖z*‖ <= ‖G(0)‖/(1 - θ).
//!
//! Bodies that may move as they are leave K singular. There W has so many columns fewer as there
//! are proved symmetries, whose generators xi obey xi·F = 0 identically: then a zero of G
//! is one of F if the columns of W and xi together span everything ([`span`]).
//!
//! At first all of it is done in doubles, with the rounding errors of matrix products bounded after Higham,
//! Accuracy and Stability of Numerical Algorithms (2002), section 3.5: |fl(AB) - AB| <= γ|A||B| in
//! whatever order it is summed, γ = mu/(1 - mu) for m terms, u = 2^-53. Only one matrix is
//! multiplied out; the bounds |A||B|r are products with vectors. Where stiffnesses are so different that
//! γ|W|ᵀ|K||W| alone is above 1, or forces cancel so far that no box is small enough, the same is
//! done with K and F in numbers of many bits and WᵀKW multiplied out in these ([`Products::Enclosed`]).

use nalgebra::{DMatrix, DVector};

use super::assemble::{Assembly, Values};
use super::symmetry::Symmetry;
use crate::order::places;
use crate::precision::{Big, Enclosure, Magnitude, Scalar};

/// What is lost to underflow in up to 4000 products of doubles: each loses at most 2^-1075.
const UNDERFLOW: f64 = f64::from_bits(1 << 14);

/// What was shown: for every point x closer to the centre than half the box there is exactly one
/// zero of WᵀF(x + W z) with ‖z‖ <= 1/2, if ‖G(0)‖ there is below (1 - θ)/2; and it is an equilibrium.
///
/// The bound of D holds for all K over the box, hence for all boxes x + W z inside of it, and
/// ‖G(0)‖ + θ/2 < 1/2 is Krawczyk's condition for the box of half the size about x.
#[derive(Clone, Debug)]
pub(crate) struct Proof {
    free: Vec<usize>,
    axes: Axes,
    /// r.
    reach: Vec<f64>,
    /// θ < 1.
    contraction: f64,
    /// The middle of the box, per free coordinate ...
    centre: Vec<Big>,
    /// ... and |W|r, an upper bound.
    size: Vec<f64>,
    /// The bits that forces need at least to be told from their rounding: with fewer they may not tell as much as they
    /// did for the proof.
    pub(super) bits: usize,
}

/// Approximate principal axes of the stiffness of the free coordinates, those of symmetries left out.
#[derive(Clone, Debug)]
pub(crate) struct Axes {
    /// W, by free coordinate and axis.
    pub(crate) directions: DMatrix<f64>,
    /// S: WᵀKW is about diag(S), entries 1 and -1.
    pub(crate) signs: Vec<f64>,
}

/// How WᵀKW is multiplied out.
pub(crate) enum Products {
    /// In doubles, with bounds of their rounding errors.
    Doubles,
    /// In the enclosures that K is given in.
    Enclosed,
}

/// What the proof works with.
pub(crate) struct Setting<'a, S: Enclosure> {
    pub(crate) assembly: &'a Assembly,
    pub(crate) values: &'a Values<S>,
    pub(crate) free: &'a [usize],
    pub(crate) products: Products,
    /// The bits that hold a number of the point, but for what then goes to a radius.
    pub(crate) bits: usize,
    /// The least size of a box beside that of the point.
    pub(crate) room: f64,
}

/// An upper bound of a sum of up to `terms` nonnegative products, from what it came to in doubles:
/// the exact sum is at most fl/(1 - γ), and some more operations are covered too.
fn above(x: f64, terms: usize) -> f64 {
    x * (1.0 + (terms as f64 + 16.0) * f64::EPSILON) + UNDERFLOW
}

/// γ for products of up to `terms` terms, twice as large as need be.
fn gamma(terms: usize) -> f64 {
    (terms as f64 + 2.0) * f64::EPSILON
}

/// |A|x for nonnegative x, rounded up.
fn bound(a: &DMatrix<f64>, x: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; a.nrows()];
    for (column, factor) in a.column_iter().zip(x) {
        for (slot, entry) in sum.iter_mut().zip(column.iter()) {
            *slot += entry.abs() * factor;
        }
    }
    sum.into_iter().map(|x| above(x, a.ncols())).collect()
}

/// |A|ᵀx for nonnegative x, rounded up.
fn bound_transposed(a: &DMatrix<f64>, x: &[f64]) -> Vec<f64> {
    a.column_iter().map(|column| above(column.iter().zip(x).map(|(a, x)| a.abs() * x).sum(), a.nrows())).collect()
}

/// |Aᵀx| for an enclosed vector of midpoints and errors: γ|A|ᵀ|x| + |A|ᵀerror on top of the product.
fn product(a: &DMatrix<f64>, x: &[f64], error: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let gamma = gamma(a.nrows());
    let slack: Vec<f64> = x.iter().zip(error).map(|(x, error)| above(x.abs() * gamma + error, 2)).collect();
    let middle = a.tr_mul(&DVector::from_column_slice(x));
    let size =
        middle.iter().zip(bound_transposed(a, &slack)).map(|(middle, slack)| above(middle.abs() + slack, 2)).collect();
    (middle.iter().copied().collect(), size)
}

/// Midpoints in doubles, and how far they are off.
fn split<S: Enclosure>(values: impl Iterator<Item = S>) -> (Vec<f64>, Vec<f64>) {
    values.map(|x| (x.mid_f64(), x.mid_f64_error())).unzip()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    // NaN must not be lost.
    values.fold(0.0, |a: f64, b| if b <= a || a.is_nan() { a } else { b })
}

/// 1 - S WᵀKW for all K over a box, as a midpoint and what it may be off by.
struct Defect {
    middle: DMatrix<f64>,
    /// Per entry of K: γ|K| + its error over the box.
    spread: DMatrix<f64>,
}

impl Defect {
    /// An upper bound of |D|d.
    ///
    /// The double product fl(Wᵀfl(KW)) is off by (2γ + γ^2)|W|ᵀ|K||W|, and K by the spread.
    fn times(&self, directions: &DMatrix<f64>, d: &[f64]) -> Vec<f64> {
        let moved = bound(directions, d);
        let total = above(d.iter().sum(), d.len());
        let spread: Vec<f64> = bound(&self.spread, &moved).into_iter().map(|x| x + UNDERFLOW * total).collect();
        let both = bound(&self.middle, d).into_iter().zip(bound_transposed(directions, &spread));
        both.map(|(a, b)| above(a + b + UNDERFLOW * total, 4)).collect()
    }
}

impl Axes {
    /// From axes along which WᵀKW is nearly the diagonal matrix `stiffness`; as many of the softest
    /// as `fewer` are left out.
    pub(crate) fn new(axes: &DMatrix<f64>, stiffness: &[f64], fewer: usize) -> Option<Self> {
        let kept = stiffness.len().checked_sub(fewer).filter(|kept| *kept > 0)?;
        let mut order = places(stiffness.len(), &mut |a, b| stiffness[*b].abs().total_cmp(&stiffness[*a].abs()));
        order.truncate(kept);
        let directions =
            DMatrix::from_fn(axes.nrows(), kept, |i, j| axes[(i, order[j])] / stiffness[order[j]].abs().sqrt());
        let signs = order.iter().map(|i| stiffness[*i].signum()).collect();
        directions.iter().all(|x| x.is_finite()).then_some(Self { directions, signs })
    }

    /// ‖WᵀF‖ for forces on the free coordinates, and Newton's step -WSWᵀF. The step is worked
    /// out in doubles times a power of 2.
    pub(crate) fn step(&self, force: &[&Big], reach: &[f64]) -> Option<(Magnitude, Vec<Big>)> {
        let size = force.iter().fold(Magnitude::ZERO, |size, force| size.max(force.abs_upper()));
        if !size.is_finite() {
            return None;
        }
        let (_, exponent) = size.parts();
        // In units of 2^exponent; mid_f64 drops less than a unit of the last place.
        let in_units = |force: &&Big| {
            let scaled = force.scale(-exponent);
            let middle = scaled.mid_f64();
            (middle, above(scaled.radius().to_f64() + 2.0 * f64::EPSILON * middle.abs(), 2))
        };
        let (middles, errors): (Vec<f64>, Vec<f64>) = force.iter().map(in_units).unzip();
        let (middle, image) = product(&self.directions, &middles, &errors);
        let norm = Magnitude::from_f64(ratio_of(&image, reach)).scale(exponent);
        let back = DVector::from_iterator(middle.len(), middle.iter().zip(&self.signs).map(|(x, sign)| -x * sign));
        let bits = force.first().map_or(64, |force| force.bits());
        let step = (&self.directions * back).iter().map(|x| Big::from_f64(*x, bits).scale(exponent)).collect();
        Some((norm, step))
    }

    /// So many Newton steps of the free coordinates at most, as long as the force falls by this power of two each time.
    pub(crate) fn newton(
        &self,
        mut point: Vec<Big>,
        free: &[usize],
        reach: &[f64],
        (most, power): (usize, i64),
        gradient: impl Fn(&[Big]) -> Vec<Big>,
    ) -> Option<Newton> {
        let mut trial = point.clone();
        let mut best = Magnitude::INFINITE;
        for done in 0..most {
            let gradient = gradient(&trial);
            let own: Vec<&Big> = free.iter().map(|i| &gradient[*i]).collect();
            let (norm, step) = self.step(&own, reach)?;
            if norm.scale(power) >= best {
                return Some(Newton { point, norm: best, steps: done.saturating_sub(1) });
            }
            best = norm;
            point.clone_from(&trial);
            if norm.is_zero() {
                return Some(Newton { point, norm, steps: done });
            }
            for (i, step) in free.iter().zip(step) {
                trial[*i] = (&trial[*i] + &step).center();
            }
        }
        Some(Newton { point, norm: best, steps: most })
    }
}

/// Where Newton steps end.
pub(crate) struct Newton {
    pub(crate) point: Vec<Big>,
    /// ‖WᵀF‖ there.
    norm: Magnitude,
    /// How many of the steps made it fall.
    pub(crate) steps: usize,
}

/// WᵀKW for a symmetric K (column by column), multiplied out in its own numbers.
pub(crate) fn congruent<S: Enclosure>(stiffness: &[S], directions: &DMatrix<f64>, precision: S::Precision) -> Vec<S> {
    let (m, kept) = (directions.nrows(), directions.ncols());
    let zero = S::from_number(&crate::number::Number::ZERO, precision);
    let exact: Vec<Option<S>> = directions.iter().map(|x| (*x != 0.0).then(|| S::exact(*x, precision))).collect();
    let mut image = vec![zero.clone(); kept * kept];
    for j in 0..kept {
        let mut column = vec![zero.clone(); m];
        for (l, x) in exact[m * j..m * (j + 1)].iter().enumerate() {
            let Some(x) = x else { continue };
            for (slot, entry) in column.iter_mut().zip(&stiffness[m * l..]) {
                if !entry.is_exact_zero() {
                    *slot = slot.add(&entry.mul(x));
                }
            }
        }
        for i in 0..=j {
            let entry = exact[m * i..m * (i + 1)].iter().zip(&column).fold(zero.clone(), |sum, (x, entry)| match x {
                Some(x) => sum.add(&entry.mul(x)),
                None => sum,
            });
            image[j + kept * i] = entry.clone();
            image[i + kept * j] = entry;
        }
    }
    image
}

impl<S: Enclosure> Setting<'_, S> {
    /// The block of K that belongs to the free coordinates, column by column.
    pub(crate) fn stiffness(&self, at: &[S]) -> Vec<S> {
        let n = at.len();
        let all = self.assembly.stiffness(at, self.values);
        if self.free.len() == n {
            return all;
        }
        let column = |j: &usize| self.free.iter().map(|i| all[i + n * j].clone()).collect();
        let columns: Vec<Vec<S>> = self.free.iter().map(column).collect();
        columns.concat()
    }

    /// The point with the free coordinates anywhere within `size`.
    fn widened(&self, at: &[S], size: &[f64]) -> Vec<S> {
        let mut wide = at.to_vec();
        for (i, size) in self.free.iter().zip(size) {
            wide[*i] = wide[*i].with_added_radius(*size);
        }
        wide
    }

    /// 1 - S WᵀKW at the middle of K, absolute values rounded up.
    fn defect(&self, axes: &Axes, matrix: &[S], middle: &DMatrix<f64>) -> DMatrix<f64> {
        let Axes { directions, signs } = axes;
        let kept = signs.len();
        let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        match self.products {
            Products::Doubles => {
                let inner = directions.tr_mul(&(middle * directions));
                DMatrix::from_fn(kept, kept, |i, j| {
                    // One more rounding than the product, of something at most 1 + |x|.
                    let rest = unit(i, j) - signs[i] * inner[(i, j)];
                    rest.abs() * (1.0 + f64::EPSILON)
                })
            }
            Products::Enclosed => {
                let precision = self.values.precision();
                let centre: Vec<S> = matrix.iter().map(S::center).collect();
                let inner = congruent(&centre, directions, precision);
                DMatrix::from_fn(kept, kept, |i, j| {
                    let sign = S::exact(signs[i], precision);
                    let unit = S::exact(unit(i, j), precision);
                    unit.sub(&sign.mul(&inner[i + kept * j])).abs_upper()
                })
            }
        }
    }

    /// How far K may be from its middle over a box, and what rounding adds to products with it.
    fn spread(&self, matrix: &[S], middle: &DMatrix<f64>, over: &[S]) -> DMatrix<f64> {
        let m = middle.nrows();
        match self.products {
            Products::Doubles => {
                let twice = 2.01 * gamma(m);
                DMatrix::from_fn(m, m, |i, j| {
                    let entry = &over[i + m * j];
                    let off = (entry.mid_f64() - middle[(i, j)]).abs() * (1.0 + f64::EPSILON);
                    above(twice * middle[(i, j)].abs() + off + entry.mid_f64_error(), 4)
                })
            }
            Products::Enclosed => DMatrix::from_fn(m, m, |i, j| {
                let at = i + m * j;
                over[at].sub(&matrix[at].center()).abs_upper()
            }),
        }
    }

    /// Tries to prove an equilibrium beside `at`, whose free coordinates are exact. As many `axes` are
    /// left out as there are `symmetries`. Gives the proof and how far off each free coordinate may be.
    pub(crate) fn prove(&self, at: &[S], axes: Axes, symmetries: &[Symmetry]) -> Option<(Proof, Vec<f64>)> {
        let directions = &axes.directions;
        let (m, kept) = (directions.nrows(), directions.ncols());
        let gradient = self.assembly.gradient(at, self.values);
        let (force, off) = split(self.free.iter().map(|i| gradient[*i].clone()));
        let (_, start) = product(directions, &force, &off);
        let matrix = self.stiffness(at);
        let middle = DMatrix::from_fn(m, m, |i, j| matrix[i + m * j].mid_f64());
        let middle_defect = self.defect(&axes, &matrix, &middle);
        let worst = largest(start.iter().copied());
        let scale = match largest(self.free.iter().map(|i| at[*i].mid_f64().abs())) {
            0.0 => 1.0,
            scale => scale,
        };
        for factor in [8.0, 64.0, 4096.0, 2.0] {
            // Any r will do; this one leaves room for points found later with more digits.
            let reach: Vec<f64> = (0..kept)
                .map(|i| {
                    let longest = largest(directions.column(i).iter().map(|x| x.abs()));
                    factor * (start[i] + 2f64.powi(-20) * worst + self.room * scale / longest)
                })
                .collect();
            let size = bound(directions, &reach);
            let wide = self.widened(at, &size);
            let over = self.stiffness(&wide);
            let defect = Defect { middle: middle_defect.clone(), spread: self.spread(&matrix, &middle, &over) };
            let image = defect.times(directions, &reach);
            let contraction = ratio_of(&image, &reach);
            let holds = contraction < 1.0 && (0..kept).all(|i| above(start[i] + image[i], 2) < reach[i]);
            if !holds || !self.span(&wide, directions, &over, &reach, contraction, symmetries) {
                continue;
            }
            let proof = Proof {
                free: self.free.to_vec(),
                contraction,
                centre: self.free.iter().map(|i| at[*i].to_big(self.bits)).collect(),
                size,
                reach,
                bits: self.bits,
                axes,
            };
            // ‖z*‖ <= ‖G(0)‖/(1 - θ), and twice |z*| <= |G(0)| + |D||z*|.
            let norm = above(ratio_of(&start, &proof.reach) / (1.0 - contraction), 4);
            let mut left: Vec<f64> = proof.reach.iter().map(|r| above(r * norm, 2)).collect();
            for _ in 0..2 {
                let image = defect.times(&proof.axes.directions, &left);
                for ((left, start), image) in left.iter_mut().zip(&start).zip(image) {
                    *left = left.min(above(start + image, 2));
                }
            }
            let radii = bound(&proof.axes.directions, &left);
            return Some((proof, radii));
        }
        None
    }

    /// Whether the columns of W and the generators xi are independent wherever in the box the zero is.
    ///
    /// Let W a + xi b = 0. With P the transposed generators at the middle and A an approximate inverse
    /// of P xi, b = -A P W a + (1 - A P xi) b, so |b| <= g |a| where g = ‖A P W‖/(1 - ‖1 - A P xi‖);
    /// and S WᵀKW a = -S WᵀK xi b for any K over the box, so (1 - θ)‖a‖ <= h g ‖a‖ where h = ‖WᵀK xi‖. With
    /// h g < 1 - θ that leaves a = 0 and b = 0. (Near the equilibrium K xi is nearly 0.) The norms are
    /// max |aᵢ|/rᵢ and max |bₖ|.
    fn span(
        &self,
        wide: &[S],
        directions: &DMatrix<f64>,
        over: &[S],
        reach: &[f64],
        contraction: f64,
        symmetries: &[Symmetry],
    ) -> bool {
        if symmetries.is_empty() {
            return true;
        }
        let (m, p) = (self.free.len(), symmetries.len());
        let generators = self.generators(wide, symmetries);
        let vectors: Vec<(Vec<f64>, Vec<f64>)> =
            generators.iter().map(|vector| split(vector.iter().cloned())).collect();
        let middle = DMatrix::from_fn(m, p, |i, k| vectors[k].0[i]);
        let Some(inverse) = middle.tr_mul(&middle).try_inverse() else { return false };
        // The rows of A P as columns, exactly what these doubles are.
        let rows = &middle * inverse.transpose();
        // ‖1 - A P xi‖ and ‖A P W‖.
        let mut across: f64 = 0.0;
        let mut ones = vec![0.0; p];
        for (k, (vector, error)) in vectors.iter().enumerate() {
            let (image, size) = product(&rows, vector, error);
            for (l, slot) in ones.iter_mut().enumerate() {
                let unit = if l == k { 1.0 } else { 0.0 };
                let off = size[l] - image[l].abs();
                *slot += (unit - image[l]).abs() + off.max(0.0) + f64::EPSILON * (1.0 + size[l]);
            }
        }
        let rest = largest(ones.into_iter().map(|one| above(one, p)));
        for k in 0..p {
            let row: Vec<f64> = rows.column(k).iter().copied().collect();
            let (_, size) = product(directions, &row, &vec![0.0; m]);
            let sum: f64 = size.iter().zip(reach).map(|(a, r)| a * r).sum();
            across = largest([across, above(sum, m)].into_iter());
        }
        // K xi over the box, then WᵀK xi.
        let zero = S::exact(0.0, self.values.precision());
        let mut height = vec![0.0; reach.len()];
        for vector in &generators {
            let image = (0..m).map(|i| (0..m).fold(zero.clone(), |sum, j| sum.add(&over[i + m * j].mul(&vector[j]))));
            let (force, error) = split(image);
            let (_, size) = product(directions, &force, &error);
            for (slot, size) in height.iter_mut().zip(size) {
                *slot += size;
            }
        }
        let height = largest(height.iter().zip(reach).map(|(h, r)| above(h / r, p + 2)));
        let g = above(across / (1.0 - rest), 4);
        rest < 1.0 && above(height * g, 4) < (1.0 - contraction) * (1.0 - f64::EPSILON)
    }

    /// The generators on the free coordinates, each less what it has in common with those before it,
    /// and about 1 in length: a body far from the origin turns about itself then. Fixed factors
    /// make generators of generators.
    fn generators(&self, wide: &[S], symmetries: &[Symmetry]) -> Vec<Vec<S>> {
        let precision = self.values.precision();
        let mut basis: Vec<(Vec<S>, Vec<f64>)> = Vec::with_capacity(symmetries.len());
        for symmetry in symmetries {
            let whole = symmetry.vector(wide, precision);
            let mut own: Vec<S> = self.free.iter().map(|i| whole[*i].clone()).collect();
            // In doubles a few leading digits are lost to the common part each time.
            for _ in 0..3 {
                for (other, unit) in &basis {
                    let overlap: f64 = own.iter().zip(unit).map(|(x, y)| x.mid_f64() * y).sum();
                    if overlap != 0.0 && overlap.is_finite() {
                        let overlap = S::exact(overlap, precision);
                        for (x, y) in own.iter_mut().zip(other) {
                            *x = x.sub(&overlap.mul(y));
                        }
                    }
                }
            }
            let norm = own.iter().map(|x| x.mid_f64().powi(2)).sum::<f64>().sqrt();
            if norm > 0.0 && norm.is_normal() {
                let scale = S::exact(norm.recip(), precision);
                for x in &mut own {
                    *x = x.mul(&scale);
                }
            }
            let unit = own.iter().map(S::mid_f64).collect();
            basis.push((own, unit));
        }
        basis.into_iter().map(|(own, _)| own).collect()
    }
}

fn ratio_of(x: &[f64], reach: &[f64]) -> f64 {
    largest(x.iter().zip(reach).map(|(x, r)| above(x / r, 2)))
}

impl Proof {
    /// The equilibrium with as many digits as the forces in numbers of `bits` bits give. `point` has
    /// the coordinates that are not searched for; `gradient` is all of ∇U.
    ///
    /// Newton steps from the centre with WSWᵀ as the inverse of K gain the same number of digits each (a factor θ, at the least). The
    /// radius is |W|‖z*‖r, with ‖z*‖ <= ‖G(0)‖/(1 - θ). `None` where they leave the box.
    pub(crate) fn refine(
        &self,
        mut point: Vec<Big>,
        bits: usize,
        gradient: impl Fn(&[Big]) -> Vec<Big>,
    ) -> Option<Vec<Big>> {
        for (i, centre) in self.free.iter().zip(&self.centre) {
            point[*i] = centre.clone().with_bits(bits).center();
        }
        let newton = self.axes.newton(point, &self.free, &self.reach, (bits + 8, 0), gradient)?;
        let Newton { point: mut found, norm: best, .. } = newton;
        let rest = Magnitude::from_f64((1.0 - self.contraction).next_down());
        if best.scale(1) >= rest {
            return None;
        }
        let norm = best / rest;
        for ((i, centre), size) in self.free.iter().zip(&self.centre).zip(&self.size) {
            let size = Magnitude::from_f64(*size);
            let moved = &found[*i] - centre;
            if moved.abs_upper().scale(1) > size {
                return None;
            }
            found[*i] = found[*i].clone().with_added_radius(size * norm);
        }
        Some(found)
    }
}
