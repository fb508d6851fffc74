//! Discs that hold the eigenvalues of a matrix, at any precision.
//!
//! With V about the eigenvectors, D about the eigenvalues and W about V⁻¹, all taken as exactly what they are,
//! V⁻¹ΦV = D + (1 - E)⁻¹ W(ΦV - VD) for E = 1 - WV, which is nearly diagonal; Gershgorin's discs of it, each with a scaling of
//! its own row that makes it quadratic in the couplings, hold the eigenvalues, and one that meets no other holds exactly one (R.
//! A. Horn and C. R. Johnson, Matrix Analysis, 2nd ed. (2013), §6.1).

use super::basis::Basis;
use librate_core::groups::connected;
use librate_core::precision::{Complex, Enclosure, Magnitude, Matrix};

/// A disc that holds exactly one eigenvalue where it is `single`.
#[derive(Clone, Debug)]
pub(super) struct Disc<S> {
    pub(super) center: Complex<S>,
    pub(super) radius: Magnitude,
    pub(super) single: bool,
}

impl<S: Enclosure> Disc<S> {
    /// Whether another disc is certainly apart from this one.
    pub(super) fn is_apart(&self, other: &Self, precision: S::Precision) -> bool {
        let square = self.center.sub(&other.center).square_of_modulus();
        let reach = S::from_magnitude(self.radius + other.radius, precision);
        square.sub(&reach.mul(&reach)).is_positive()
    }

    /// The image by z -> 1/z̄: of |z - c| <= r with r < |c| the disc about c/(|c|² - r²) of radius r/(|c|² - r²).
    pub(super) fn mirrored(&self, precision: S::Precision) -> Option<Self> {
        let radius = S::from_magnitude(self.radius, precision);
        let rest = self.center.square_of_modulus().sub(&radius.mul(&radius));
        if !rest.is_positive() {
            return None;
        }
        let inverse = S::exact(1.0, precision).div(&rest);
        let center = self.center.times(&inverse);
        let radius = self.radius * inverse.abs_upper_magnitude() + center.radius();
        Some(Self { center: center.center(), radius, single: self.single })
    }

    pub(super) fn conjugate(&self) -> Self {
        Self { center: self.center.conjugate(), ..self.clone() }
    }
}

/// Discs that together hold all eigenvalues: one of them, and the others with the scaling that is best for that one.
pub(super) struct Cover<S> {
    pub(super) disc: Disc<S>,
    pub(super) others: Vec<Disc<S>>,
}

/// Covers for all eigenvalues, and the same discs without a scaling, which hold them together.
pub(super) struct Covers<S: Enclosure> {
    pub(super) of: Vec<Cover<S>>,
    pub(super) plain: Vec<Disc<S>>,
    /// Those that are connected: there are as many eigenvalues in a set as there are discs, but any of them may hold them.
    pub(super) sets: Vec<Vec<usize>>,
    form: Form<S>,
}

impl<S: Enclosure> Covers<S> {
    /// From a matrix row by row; `None` where its eigenvectors could not be told apart.
    pub(super) fn new(matrix: &[S], n: usize, basis: &Basis<S>, precision: S::Precision) -> Option<Self> {
        let (values, vectors, left) = (&basis.values, &basis.vectors, &basis.inverse);
        // ΦV - VD, then W times it, and |1 - WV|.
        let residual = Matrix::from_fn(n, n, |i, j| {
            let products = (0..n).map(|k| vectors[(k, j)].times(&matrix[n * i + k]));
            let product = products.fold(Complex::zero(precision), |sum, term| sum.add(&term));
            product.sub(&vectors[(i, j)].mul(&values[j]))
        });
        let coupling = left.mul(&residual, precision);
        let unit = Matrix::<Complex<S>>::unit(n, precision);
        let product = left.mul(vectors, precision);
        let defect = unit.rows().zip(product.rows()).fold(Magnitude::ZERO, |most, (unit, product)| {
            let off = unit.iter().zip(product).map(|(unit, product)| unit.sub(product).upper_bound());
            most.max(off.fold(Magnitude::ZERO, |sum, off| sum + off))
        });
        if defect >= Magnitude::power_of_two(-1) {
            return None;
        }
        // Σ_(k>0) Eᵏ Y is at most |E|/(1 - |E|) times the largest entry of the column of Y.
        let share = defect / Magnitude::ONE.sub_down(defect);
        let size = |i: usize, j: usize| coupling[(i, j)].upper_bound();
        let columns: Vec<Magnitude> =
            (0..n).map(|j| (0..n).fold(Magnitude::ZERO, |most, i| most.max(size(i, j)))).collect();
        let diagonal: Vec<Complex<S>> = (0..n).map(|i| values[i].add(&coupling[(i, i)])).collect();
        let matrix = Form {
            n,
            precision,
            centers: diagonal.iter().map(Complex::center).collect(),
            own: diagonal.iter().zip(&columns).map(|(own, column)| own.radius() + share * *column).collect(),
            off: Matrix::from_fn(n, n, |i, j| size(i, j) + share * columns[j]),
        };
        let mut of: Vec<Cover<S>> = (0..n).map(|i| matrix.scaled(i)).collect();
        let plain: Vec<Disc<S>> = (0..n).map(|i| matrix.disc(i, matrix.own[i] + matrix.row(i, i))).collect();
        let sets = connected(n, |i, j| !plain[i].is_apart(&plain[j], precision));
        for (i, cover) in of.iter_mut().enumerate() {
            if !cover.disc.single {
                let members = sets.iter().filter(|set| set.contains(&i)).flatten();
                cover.disc.radius = members.fold(Magnitude::ZERO, |most, at| {
                    let distance = plain[*at].center.sub(&plain[i].center).upper_bound();
                    most.max(distance + plain[*at].radius)
                });
            }
        }
        of.iter().all(|own| own.disc.radius.is_finite()).then_some(Self { of, plain, sets, form: matrix })
    }

    /// A bound of an entry of V⁻¹ΦV, on the diagonal of its distance from the center of the disc.
    pub(super) fn coupling(&self, i: usize, j: usize) -> Magnitude {
        if i == j { self.form.own[i] } else { self.form.off[(i, j)] }
    }
}

/// A nearly diagonal matrix: its diagonal, how far that is off, and how large its other entries are.
struct Form<S: Enclosure> {
    n: usize,
    precision: S::Precision,
    centers: Vec<Complex<S>>,
    own: Vec<Magnitude>,
    off: Matrix<Magnitude>,
}

impl<S: Enclosure> Form<S> {
    fn disc(&self, at: usize, radius: Magnitude) -> Disc<S> {
        Disc { center: self.centers[at].clone(), radius, single: false }
    }

    /// The entries of a row beside the diagonal, but for one.
    fn row(&self, j: usize, without: usize) -> Magnitude {
        let others = (0..self.n).filter(|k| *k != j && *k != without);
        others.fold(Magnitude::ZERO, |sum, k| sum + self.off[(j, k)])
    }

    /// Gershgorin's discs, with the row of one of them divided by a number as large as keeps it apart from the others.
    fn scaled(&self, i: usize) -> Cover<S> {
        let n = self.n;
        let mut gap = Magnitude::INFINITE;
        let mut strongest = Magnitude::ZERO;
        for j in (0..n).filter(|j| *j != i) {
            gap = gap.min(self.centers[i].sub(&self.centers[j]).upper_bound());
            strongest = strongest.max(self.off[(j, i)]);
        }
        // Any positive number would do; the sizes only choose one.
        let best = (strongest / gap).scale(2);
        let factor = if best < Magnitude::ONE && !best.is_zero() { best } else { Magnitude::ONE };
        let with = |factor: Magnitude| {
            let others = (0..n).filter(|j| *j != i).map(|j| {
                let own = self.off[(j, i)] / factor;
                self.disc(j, self.own[j] + self.row(j, i) + own)
            });
            Cover { disc: self.disc(i, self.own[i] + factor * self.row(i, i)), others: others.collect() }
        };
        let mut cover = with(factor);
        let disc = &cover.disc;
        let single = cover.others.iter().all(|other| disc.is_apart(other, self.precision));
        cover.disc.single = single;
        if single { cover } else { with(Magnitude::ONE) }
    }
}
