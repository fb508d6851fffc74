//! That a point found by the search has an equilibrium beside it, and how close: a proof.
//!
//! The forces F on the free coordinates are looked at in the coordinates z of q = q~ + W z, where
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
//! All of it is done in doubles, with the rounding errors of matrix products bounded after Higham,
//! Accuracy and Stability of Numerical Algorithms (2002), section 3.5: |fl(AB) - AB| <= γ|A||B| in
//! whatever order it is summed, γ = mu/(1 - mu) for m terms, u = 2^-53. Only one matrix is
//! multiplied out; the bounds |A||B|r are products with vectors.

use nalgebra::{DMatrix, DVector};

use super::assemble::{Assembly, Values};
use super::symmetry::Symmetry;
use std::ops::{Div, Mul};

use crate::precision::{Ball, Big, Magnitude};

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
    /// W, and S.
    directions: DMatrix<f64>,
    signs: Vec<f64>,
    /// r.
    reach: Vec<f64>,
    /// θ < 1.
    contraction: f64,
    /// The middle of the box, per free coordinate ...
    centre: Vec<Ball>,
    /// ... and |W|r, an upper bound.
    size: Vec<f64>,
}

/// What the proof works with.
pub(crate) struct Setting<'a> {
    pub(crate) assembly: &'a Assembly,
    pub(crate) values: &'a Values<Ball>,
    pub(crate) free: &'a [usize],
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
    a.column_iter()
        .map(|column| {
            let sum: f64 = column.iter().zip(x).map(|(a, x)| a.abs() * x).sum();
            above(sum, a.nrows())
        })
        .collect()
}

/// |Aᵀx| for an enclosed vector of midpoints and errors: γ|A|ᵀ|x| + |A|ᵀerror on top of the product.
fn product(a: &DMatrix<f64>, x: &[f64], error: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let gamma = gamma(a.nrows());
    let slack: Vec<f64> = x
        .iter()
        .zip(error)
        .map(|(x, error)| above(x.abs() * gamma + error, 2))
        .collect();
    let middle = a.tr_mul(&DVector::from_column_slice(x));
    let size = middle
        .iter()
        .zip(bound_transposed(a, &slack))
        .map(|(middle, slack)| above(middle.abs() + slack, 2))
        .collect();
    (middle.iter().copied().collect(), size)
}

/// Midpoints in doubles, and how far they are off.
fn split(values: impl Iterator<Item = Ball>) -> (Vec<f64>, Vec<f64>) {
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
        let spread: Vec<f64> = bound(&self.spread, &moved)
            .into_iter()
            .map(|x| x + UNDERFLOW * total)
            .collect();
        bound(&self.middle, d)
            .into_iter()
            .zip(bound_transposed(directions, &spread))
            .map(|(a, b)| above(a + b + UNDERFLOW * total, 4))
            .collect()
    }
}

impl Setting<'_> {
    /// The block of a matrix that belongs to the free coordinates.
    fn block(
        &self,
        n: usize,
        matrix: &[Ball],
        f: impl Fn(&Ball, usize, usize) -> f64,
    ) -> DMatrix<f64> {
        let m = self.free.len();
        DMatrix::from_fn(m, m, |i, j| {
            f(&matrix[self.free[i] + n * self.free[j]], i, j)
        })
    }

    /// The point with the free coordinates anywhere within `size`.
    fn widened(&self, at: &[Ball], size: &[f64]) -> Vec<Ball> {
        let mut wide = at.to_vec();
        for (i, size) in self.free.iter().zip(size) {
            wide[*i] = wide[*i].with_added_radius(*size);
        }
        wide
    }

    /// Tries to prove an equilibrium beside `at`, whose free coordinates are exact. `axes` are
    /// approximate principal axes (K-orthogonal), `stiffness` their eigenvalues; `symmetries` that
    /// many of the smallest are left out. Gives the proof and how far off each free coordinate may be.
    pub(crate) fn prove(
        &self,
        at: &[Ball],
        axes: &DMatrix<f64>,
        stiffness: &[f64],
        symmetries: &[Symmetry],
    ) -> Option<(Proof, Vec<f64>)> {
        let (n, m) = (at.len(), self.free.len());
        let kept = m.checked_sub(symmetries.len()).filter(|kept| *kept > 0)?;
        let mut order: Vec<usize> = (0..m).collect();
        order.sort_by(|a, b| stiffness[*b].abs().total_cmp(&stiffness[*a].abs()));
        order.truncate(kept);
        let signs: Vec<f64> = order.iter().map(|i| stiffness[*i].signum()).collect();
        let directions = DMatrix::from_fn(m, kept, |i, j| {
            axes[(i, order[j])] / stiffness[order[j]].abs().sqrt()
        });
        if !directions.iter().all(|x| x.is_finite()) {
            return None;
        }
        let gradient = self.assembly.gradient(at, self.values);
        let (force, off) = split(self.free.iter().map(|i| gradient[*i]));
        let (_, start) = product(&directions, &force, &off);
        let matrix = self.assembly.stiffness(at, self.values);
        let middle = self.block(n, &matrix, |entry, _, _| entry.mid_f64());
        let inner = directions.tr_mul(&(&middle * &directions));
        let middle_defect = DMatrix::from_fn(kept, kept, |i, j| {
            let unit = if i == j { 1.0 } else { 0.0 };
            // One more rounding than the product, of something at most 1 + |x|.
            let rest = unit - signs[i] * inner[(i, j)];
            rest.abs() * (1.0 + f64::EPSILON)
        });
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
                    factor * (start[i] + 2f64.powi(-20) * worst + 2f64.powi(-75) * scale / longest)
                })
                .collect();
            let size = bound(&directions, &reach);
            let wide = self.widened(at, &size);
            let over = self.assembly.stiffness(&wide, self.values);
            let twice = 2.01 * gamma(m);
            let spread = self.block(n, &over, |entry, i, j| {
                let off = (entry.mid_f64() - middle[(i, j)]).abs() * (1.0 + f64::EPSILON);
                above(
                    twice * middle[(i, j)].abs() + off + entry.mid_f64_error(),
                    4,
                )
            });
            let defect = Defect {
                middle: middle_defect.clone(),
                spread,
            };
            let image = defect.times(&directions, &reach);
            let holds = (0..kept).all(|i| above(start[i] + image[i], 2) < reach[i]);
            if !holds {
                continue;
            }
            let ratio = |x: &[f64]| largest(x.iter().zip(&reach).map(|(x, r)| above(x / r, 2)));
            let contraction = ratio(&image);
            let shrinks = contraction < 1.0;
            if !shrinks || !self.span(&wide, &directions, &over, &reach, contraction, symmetries) {
                continue;
            }
            let proof = Proof {
                free: self.free.to_vec(),
                signs,
                contraction,
                centre: self.free.iter().map(|i| at[*i]).collect(),
                size,
                directions,
                reach,
            };
            // ‖z*‖ <= ‖G(0)‖/(1 - θ), and twice |z*| <= |G(0)| + |D||z*|.
            let norm = above(ratio_of(&start, &proof.reach) / (1.0 - contraction), 4);
            let mut left: Vec<f64> = proof.reach.iter().map(|r| above(r * norm, 2)).collect();
            for _ in 0..2 {
                let image = defect.times(&proof.directions, &left);
                for ((left, start), image) in left.iter_mut().zip(&start).zip(image) {
                    *left = left.min(above(start + image, 2));
                }
            }
            let radii = bound(&proof.directions, &left);
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
        wide: &[Ball],
        directions: &DMatrix<f64>,
        over: &[Ball],
        reach: &[f64],
        contraction: f64,
        symmetries: &[Symmetry],
    ) -> bool {
        if symmetries.is_empty() {
            return true;
        }
        let (n, m, p) = (wide.len(), self.free.len(), symmetries.len());
        let vectors: Vec<(Vec<f64>, Vec<f64>)> = symmetries
            .iter()
            .map(|symmetry| {
                let vector = symmetry.vector(wide, ());
                split(self.free.iter().map(|i| vector[*i]))
            })
            .collect();
        let middle = DMatrix::from_fn(m, p, |i, k| vectors[k].0[i]);
        let Some(inverse) = middle.tr_mul(&middle).try_inverse() else {
            return false;
        };
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
        let mut height = vec![0.0; reach.len()];
        for symmetry in symmetries {
            let vector = symmetry.vector(wide, ());
            let image = self.free.iter().map(|i| {
                self.free
                    .iter()
                    .fold(Ball::ZERO, |sum, j| sum + over[i + n * j] * vector[*j])
            });
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
}

fn ratio_of(x: &[f64], reach: &[f64]) -> f64 {
    largest(x.iter().zip(reach).map(|(x, r)| above(x / r, 2)))
}

impl Proof {
    /// The equilibrium with as many digits as the forces in numbers of `bits` bits give. `point` has
    /// the coordinates that are not searched for; `gradient` is all of ∇U.
    ///
    /// Newton steps with WSWᵀ as the inverse of K gain the same number of digits each (a factor θ,
    /// at the least); the step is worked out in doubles times a power of 2. The radius is
    /// |W|‖z*‖r, with ‖z*‖ <= ‖G(0)‖/(1 - θ). `None` where the steps leave the box.
    pub(crate) fn refine(
        &self,
        mut point: Vec<Big>,
        bits: usize,
        gradient: impl Fn(&[Big]) -> Vec<Big>,
    ) -> Option<Vec<Big>> {
        for (i, centre) in self.free.iter().zip(&self.centre) {
            point[*i] = Big::from_ball(centre, bits).center();
        }
        let mut best = Magnitude::INFINITE;
        let mut found = point.clone();
        for _ in 0..bits + 8 {
            let (norm, step) = self.step(&gradient(&point))?;
            let falls = norm < best;
            if falls {
                best = norm;
                found.clone_from(&point);
            }
            if norm.is_zero() || !falls {
                break;
            }
            for (i, step) in self.free.iter().zip(step) {
                point[*i] = (&point[*i] + &step).center();
            }
        }
        let rest = Magnitude::from_f64((1.0 - self.contraction).next_down());
        if best.scale(1) >= rest {
            return None;
        }
        let norm = best.div(rest);
        for ((i, centre), size) in self.free.iter().zip(&self.centre).zip(&self.size) {
            let size = Magnitude::from_f64(*size);
            let moved = &found[*i] - &Big::from_ball(centre, bits);
            if moved.abs_upper().scale(1) > size {
                return None;
            }
            found[*i] = found[*i].clone().with_added_radius(size.mul(norm));
        }
        Some(found)
    }

    /// ‖G(0)‖ for these forces, and the step that would bring them to 0.
    fn step(&self, gradient: &[Big]) -> Option<(Magnitude, Vec<Big>)> {
        let own: Vec<&Big> = self.free.iter().map(|i| &gradient[*i]).collect();
        let size = own
            .iter()
            .fold(Magnitude::ZERO, |size, force| size.max(force.abs_upper()));
        if !size.is_finite() {
            return None;
        }
        let (_, exponent) = size.parts();
        // In units of 2^exponent; mid_f64 drops less than a unit of the last place.
        let (force, error): (Vec<f64>, Vec<f64>) = own
            .iter()
            .map(|force| {
                let scaled = force.scale(-exponent);
                let middle = scaled.mid_f64();
                let error = scaled.radius().to_f64() + 2.0 * f64::EPSILON * middle.abs();
                (middle, above(error, 2))
            })
            .unzip();
        let (middle, image) = product(&self.directions, &force, &error);
        let norm = Magnitude::from_f64(ratio_of(&image, &self.reach)).scale(exponent);
        let back = DVector::from_iterator(
            middle.len(),
            middle.iter().zip(&self.signs).map(|(x, sign)| -x * sign),
        );
        let bits = own.first().map_or(64, |force| force.bits());
        let step = (&self.directions * back)
            .iter()
            .map(|x| Big::from_f64(*x, bits).scale(exponent))
            .collect();
        Some((norm, step))
    }
}
