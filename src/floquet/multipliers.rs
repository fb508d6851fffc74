//! Certified eigenvalues of a monodromy matrix, and on which side of the unit circle they lie.
//!
//! Two by two they come from trace and determinant. Larger ones: with V the eigenvectors in doubles, D about the
//! eigenvalues and W about V⁻¹, all taken as exactly what they are, V⁻¹ΦV = D + (1 - E)⁻¹ W(ΦV - VD) for E = 1 - WV, which
//! is nearly diagonal; Gershgorin's discs of it, each with a scaling of its own row that makes it quadratic in the
//! couplings, hold the eigenvalues, and one that meets no other holds exactly one (R. A. Horn and C. R. Johnson, Matrix
//! Analysis, 2nd ed. (2013), §6.1).
//!
//! Without friction the monodromy is similar to a symplectic matrix: with z, 1/z̄ is an eigenvalue (V. I. Arnold, Mathematical
//! Methods of Classical Mechanics, §42). An eigenvalue in a disc of its own whose mirror image by the circle meets no
//! other disc is therefore its own image and lies on the circle.

use faer::Mat;

use crate::flow::Enclosure;
use crate::precision::{Ball, up};

/// Where a multiplier lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// Inside the unit circle: what it multiplies decays.
    Inside,
    /// On it, exactly.
    On,
    /// Outside: what it multiplies grows.
    Outside,
    /// The bounds do not tell.
    Undecided,
}

/// A Floquet multiplier.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Multiplier {
    /// The real part.
    pub re: Ball,
    /// The imaginary part.
    pub im: Ball,
    /// The modulus.
    pub modulus: Ball,
    /// Where it lies.
    pub place: Place,
    /// Whether no other multiplier is within its bounds.
    pub single: bool,
}

impl Multiplier {
    fn new(re: Ball, im: Ball, place: Place, single: bool) -> Self {
        let modulus = match place {
            Place::On => Ball::ONE,
            _ if im.is_zero() => re.abs(),
            _ => (re.powi(2) + im.powi(2)).sqrt(),
        };
        Self {
            re,
            im,
            modulus,
            place,
            single,
        }
    }

    /// One of which nothing is known but a bound of its modulus.
    pub(super) fn anywhere(reach: f64) -> Self {
        let part = Ball::ZERO.with_added_radius(reach);
        Self::new(part, part, Place::Undecided, false)
    }

    /// An upper bound of the distance of the multiplier from the midpoints of its parts in doubles.
    #[must_use]
    pub fn error(&self) -> f64 {
        up(self.re.mid_f64_error() + self.im.mid_f64_error())
    }
}

/// Which side of 1 a positive number lies on; its square, alike.
fn side(modulus: &Ball) -> Place {
    if (Ball::ONE - *modulus).is_positive() {
        Place::Inside
    } else if (*modulus - Ball::ONE).is_positive() {
        Place::Outside
    } else {
        Place::Undecided
    }
}

/// The eigenvalues of a matrix of two rows; `symplectic` says that its determinant is 1.
///
/// With half the trace h and the determinant d they are h ± sqrt(h² - d). For d = 1 both lie on the circle where |h| < 1, and
/// one is outside where |h| > 1.
pub(super) fn of_two<S: Enclosure>(
    matrix: &[S],
    symplectic: bool,
    precision: S::Precision,
) -> Vec<Multiplier> {
    let [a, b, c, d] = matrix else {
        return Vec::new();
    };
    let (one, half) = (S::exact(1.0, precision), S::exact(0.5, precision));
    let trace = a.add(d).mul(&half);
    let determinant = if symplectic {
        one.clone()
    } else {
        a.mul(d).sub(&b.mul(c))
    };
    // (h - 1)(h + 1) loses nothing beside the border.
    let below = if symplectic {
        one.sub(&trace).mul(&one.add(&trace))
    } else {
        determinant.sub(&trace.mul(&trace))
    };
    if below.is_above_zero() {
        let (re, im) = (trace.to_ball(), below.sqrt().to_ball());
        let place = if symplectic {
            Place::On
        } else {
            let rest = one.sub(&determinant);
            if rest.is_above_zero() {
                Place::Inside
            } else if rest.neg().is_above_zero() {
                Place::Outside
            } else {
                Place::Undecided
            }
        };
        return vec![
            Multiplier::new(re, im, place, true),
            Multiplier::new(re, -im, place, true),
        ];
    }
    let above = below.neg();
    if above.is_above_zero() {
        let root = above.sqrt();
        let larger = if trace.is_above_zero() {
            trace.add(&root)
        } else if trace.neg().is_above_zero() {
            trace.sub(&root)
        } else {
            // h may be 0: both roots as they are.
            let sides = [trace.add(&root), trace.sub(&root)];
            return sides
                .iter()
                .map(|x| Multiplier::new(x.to_ball(), Ball::ZERO, side(&x.to_ball().abs()), true))
                .collect();
        };
        let smaller = determinant.div(&larger);
        return [(larger, Place::Outside), (smaller, Place::Inside)]
            .into_iter()
            .map(|(value, own)| {
                let value = value.to_ball();
                let place = if symplectic { own } else { side(&value.abs()) };
                Multiplier::new(value, Ball::ZERO, place, true)
            })
            .collect();
    }
    // A double one, or two beside each other: |z - h| = sqrt |h² - d|.
    let reach = if above.is_zero() {
        0.0
    } else {
        up(above.abs_upper().sqrt())
    };
    let re = trace.to_ball().with_added_radius(reach);
    let im = if above.is_zero() {
        Ball::ZERO
    } else {
        Ball::ZERO.with_added_radius(reach)
    };
    let own = Multiplier::new(re, im, Place::Undecided, false);
    let place = if symplectic && own.re.abs() == Ball::ONE && own.im.is_zero() {
        Place::On
    } else {
        side(&own.modulus)
    };
    let own = Multiplier { place, ..own };
    vec![own.clone(), own]
}

/// A complex number with bounds.
#[derive(Clone, Copy, Debug)]
struct Complex {
    re: Ball,
    im: Ball,
}

impl Complex {
    const ZERO: Self = Self {
        re: Ball::ZERO,
        im: Ball::ZERO,
    };

    fn exact(re: f64, im: f64) -> Self {
        Self {
            re: Ball::exact(re),
            im: Ball::exact(im),
        }
    }

    fn add(self, other: Self) -> Self {
        Self {
            re: self.re + other.re,
            im: self.im + other.im,
        }
    }

    fn sub(self, other: Self) -> Self {
        Self {
            re: self.re - other.re,
            im: self.im - other.im,
        }
    }

    fn mul(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }

    fn times(self, factor: Ball) -> Self {
        Self {
            re: self.re * factor,
            im: self.im * factor,
        }
    }

    /// An upper bound of the modulus.
    fn size(self) -> f64 {
        let (re, im) = (self.re.abs_upper(), self.im.abs_upper());
        up((re * re + im * im).sqrt())
    }

    /// An upper bound of the distance from the midpoint.
    fn radius(self) -> f64 {
        let (re, im) = (self.re.radius, self.im.radius);
        up((re * re + im * im).sqrt())
    }

    fn center(self) -> Self {
        Self {
            re: Ball::from(self.re.mid),
            im: Ball::from(self.im.mid),
        }
    }
}

/// A disc that holds exactly one eigenvalue where it is `single`.
#[derive(Clone, Copy, Debug)]
struct Disc {
    center: Complex,
    radius: f64,
    single: bool,
}

impl Disc {
    /// Whether another disc is certainly apart from this one.
    fn is_apart(&self, other: &Self) -> bool {
        let difference = self.center.sub(other.center);
        let square = difference.re.powi(2) + difference.im.powi(2);
        let reach = Ball::from(self.radius) + Ball::from(other.radius);
        (square - reach.powi(2)).is_positive()
    }

    /// The image by z -> 1/z̄: of |z - c| <= r with r < |c| the disc about c/(|c|² - r²) of radius r/(|c|² - r²).
    fn mirrored(&self) -> Option<Self> {
        let square = self.center.re.powi(2) + self.center.im.powi(2);
        let rest = square - Ball::from(self.radius).powi(2);
        if !rest.is_positive() {
            return None;
        }
        let inverse = Ball::ONE / rest;
        let center = self.center.times(inverse);
        let radius = up((Ball::from(self.radius) * inverse).abs_upper() + center.radius());
        Some(Self {
            center: center.center(),
            radius,
            single: self.single,
        })
    }

    fn conjugate(&self) -> Self {
        let mut center = self.center;
        center.im = -center.im;
        Self { center, ..*self }
    }
}

/// The eigenvalues of a matrix given row by row, each as often as it has discs; `symplectic` as above. Empty where
/// eigenvectors could not be told apart.
pub(super) fn of_many(matrix: &[Ball], n: usize, symplectic: bool) -> Vec<Multiplier> {
    let Some(covers) = covers(matrix, n) else {
        return Vec::new();
    };
    covers
        .iter()
        .map(|Cover { disc, others }| {
            // An eigenvalue that is in none of the others is in this one.
            let own = |image: &Disc| others.iter().all(|other| image.is_apart(other));
            let real = disc.single && own(&disc.conjugate());
            let mirrored = || disc.mirrored().is_some_and(|mirror| own(&mirror));
            let re = disc.center.re.with_added_radius(disc.radius);
            let im = if real {
                Ball::ZERO
            } else {
                disc.center.im.with_added_radius(disc.radius)
            };
            let place = if symplectic && disc.single && mirrored() {
                Place::On
            } else {
                // By the disc, not by its square.
                let square = disc.center.re.powi(2) + disc.center.im.powi(2);
                side(&square.sqrt().with_added_radius(disc.radius))
            };
            Multiplier::new(re, im, place, disc.single)
        })
        .collect()
}

/// Discs that together hold all eigenvalues: one of them, and the others with the scaling that is best for that one.
struct Cover {
    disc: Disc,
    others: Vec<Disc>,
}

fn covers(matrix: &[Ball], n: usize) -> Option<Vec<Cover>> {
    let middle = Mat::from_fn(n, n, |i, j| matrix[n * i + j].mid_f64());
    let eigen = middle.eigen().ok()?;
    let (values, vectors) = (eigen.S(), eigen.U());
    let inverse = inverse(vectors, n)?;
    let value = |j: usize| Complex::exact(values[j].re, values[j].im);
    let vector = |i: usize, j: usize| Complex::exact(vectors[(i, j)].re, vectors[(i, j)].im);
    let left = |i: usize, j: usize| {
        let (re, im) = inverse[n * i + j];
        Complex::exact(re, im)
    };
    let sum =
        |term: &dyn Fn(usize) -> Complex| (0..n).fold(Complex::ZERO, |sum, k| sum.add(term(k)));
    // ΦV - VD, then W times it, and |1 - WV|.
    let mut residual = Vec::with_capacity(n * n);
    for i in 0..n {
        for j in 0..n {
            let product = sum(&|k| vector(k, j).times(matrix[n * i + k]));
            residual.push(product.sub(vector(i, j).mul(value(j))));
        }
    }
    let mut defect = 0.0_f64;
    let mut coupling = Vec::with_capacity(n * n);
    for i in 0..n {
        let mut row = 0.0;
        for j in 0..n {
            coupling.push(sum(&|k| left(i, k).mul(residual[n * k + j])));
            let product = sum(&|k| left(i, k).mul(vector(k, j)));
            let unit = Complex::exact(f64::from(u8::from(i == j)), 0.0);
            row = up(row + unit.sub(product).size());
        }
        defect = defect.max(row);
    }
    if defect.is_nan() || defect >= 0.5 {
        return None;
    }
    // Σ_(k>0) Eᵏ Y is at most |E|/(1 - |E|) times the largest entry of the column of Y.
    let share = up(defect / (1.0 - defect));
    let columns: Vec<f64> = (0..n)
        .map(|j| (0..n).fold(0.0_f64, |most, i| most.max(coupling[n * i + j].size())))
        .collect();
    let off = |i: usize, j: usize| up(coupling[n * i + j].size() + share * columns[j]);
    let mut centers = Vec::with_capacity(n);
    let mut own = Vec::with_capacity(n);
    for i in 0..n {
        let center = value(i).add(coupling[n * i + i]);
        own.push(up(center.radius() + share * columns[i]));
        centers.push(center.center());
    }
    let mut covers: Vec<Cover> = (0..n).map(|i| scaled(i, n, &centers, &own, &off)).collect();
    let plain: Vec<Disc> = (0..n)
        .map(|i| Disc {
            center: centers[i],
            radius: (0..n)
                .filter(|j| *j != i)
                .fold(own[i], |sum, j| up(sum + off(i, j))),
            single: false,
        })
        .collect();
    for (i, cover) in covers.iter_mut().enumerate() {
        if !cover.disc.single {
            cover.disc.radius = reach(i, &plain);
        }
    }
    let finite = covers.iter().all(|cover| cover.disc.radius.is_finite());
    finite.then_some(covers)
}

/// The radius of a disc about a center that holds all discs that it is connected with: there are as many eigenvalues in
/// these as there are discs, but any of them may hold them.
fn reach(i: usize, discs: &[Disc]) -> f64 {
    let mut connected = vec![i];
    let mut next = 0;
    while let Some(at) = connected.get(next).copied() {
        next += 1;
        for other in 0..discs.len() {
            if !connected.contains(&other) && !discs[at].is_apart(&discs[other]) {
                connected.push(other);
            }
        }
    }
    connected.iter().fold(0.0_f64, |most, at| {
        let distance = discs[*at].center.sub(discs[i].center).size();
        most.max(up(distance + discs[*at].radius))
    })
}

/// Gershgorin's discs, with the row of one of them divided by a number as large as keeps it apart from the others.
fn scaled(
    i: usize,
    n: usize,
    centers: &[Complex],
    own: &[f64],
    off: &dyn Fn(usize, usize) -> f64,
) -> Cover {
    let row = |j: usize, without: usize| {
        let others = (0..n).filter(|k| *k != j && *k != without);
        others.fold(0.0, |sum, k| up(sum + off(j, k)))
    };
    // The gaps in doubles only choose the scaling.
    let gap = (0..n).filter(|j| *j != i).fold(f64::INFINITY, |least, j| {
        let difference = centers[i].sub(centers[j]);
        least.min(difference.re.mid_f64().hypot(difference.im.mid_f64()))
    });
    let strongest = (0..n)
        .filter(|j| *j != i)
        .fold(0.0_f64, |most, j| most.max(off(j, i)));
    let best = 4.0 * strongest / gap;
    let factor = if best > 0.0 && best < 1.0 { best } else { 1.0 };
    let with = |factor: f64| {
        let disc = |at: usize, radius: f64| Disc {
            center: centers[at],
            radius,
            single: false,
        };
        let others = (0..n).filter(|j| *j != i);
        let others = others.map(|j| disc(j, up(own[j] + row(j, i) + off(j, i) / factor)));
        Cover {
            disc: disc(i, up(own[i] + factor * row(i, i))),
            others: others.collect(),
        }
    };
    let mut cover = with(factor);
    let disc = cover.disc;
    cover.disc.single = cover.others.iter().all(|other| disc.is_apart(other));
    if cover.disc.single { cover } else { with(1.0) }
}

/// About the inverse of a complex matrix, row by row.
fn inverse(matrix: faer::MatRef<'_, faer::c64>, n: usize) -> Option<Vec<(f64, f64)>> {
    use nalgebra::{Complex, DMatrix};
    let copy = DMatrix::from_fn(n, n, |i, j| {
        let entry = matrix[(i, j)];
        Complex::new(entry.re, entry.im)
    });
    let inverse = copy.try_inverse()?;
    let entries = (0..n * n).map(|at| inverse[(at / n, at % n)]);
    let entries: Vec<(f64, f64)> = entries.map(|x| (x.re, x.im)).collect();
    entries
        .iter()
        .all(|(re, im)| re.is_finite() && im.is_finite())
        .then_some(entries)
}
