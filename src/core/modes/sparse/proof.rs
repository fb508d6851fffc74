//! What is proved about eigenvalues of K x = λ M x from a few vectors and from counts beside them.
//!
//! Let X have N independent columns, let c eigenvalues lie between two shifts (or below one), and let all eigenvalues of the small pencil
//! (Θ, G) = (XᵀKX, XᵀMX) lie there, too. With R = KX - MXD and P its part that is M⁻¹-orthogonal to MX, in a basis of X and an
//! M-orthogonal complement the pencil is [[Θ, Pᵀ], [P, C]]. If c = N, inertia is additive (E. Haynsworth, Linear Algebra Appl. 1
//! (1968) 73), so that C - σ ± P(Θ - σ)⁻¹Pᵀ has as many negative eigenvalues at both shifts: C has none between them, but for ‖P‖² over
//! the distance of Θ from the shifts. For every eigenvalue λ between them, (Θ - S) c = λ G c with S = Pᵀ(C - λ)⁻¹P, whose entries
//! are bounded by ‖p_i‖ ‖p_j‖ over the gap; at the lower end of the spectrum S is not negative, and eigenvalues are monotone in it. There,
//! with F = K - σ₀M positive definite and μ the largest of the eigenvalues of Θ,
//!
//! ```text
//!   (C - λ)⁻¹ <= κ (C - σ₀)⁻¹,  κ = (σ - σ₀) / (σ - μ),  so that  |S_ij| <= κ ‖p_i‖ ‖p_j‖ in the norm of F⁻¹,
//! ```
//!
//! which forgives what rounding leaves in stiff directions (compare F. Goerisch, H. Haunhorst, "Eigenwertschranken für
//! Eigenwertaufgaben mit partiellen Differentialgleichungen", ZAMM 65 (1985) 129). So N eigenvalues of the large problem are those of a small
//! one whose entries are enclosed, counted and in order (S grows with λ, so that each eigenvalue of Θ - S meets λ once), and that is solved as any other. Proved zero vectors are a block
//! of their own: K is 0 there, and X is made orthogonal to them, which leaves XᵀKX as it is.

use super::super::pencil::Orthonormal;
use super::super::{ModesError, Options, Problem, Spectrum, solve};
use super::rows::{
    PLAIN_ERROR, Panel, U, form_error, forms, leftovers, plain_forms, products, products_error, residuals, squares,
};
use super::shifted::{Factor, Pencil};
use crate::precision::{Ball, LANES, Lane, U2, up};

/// Added to every length, for what underflows.
const TINY: f64 = 1e-280;

/// Up to eight vectors in a panel, as many as are wanted.
pub(super) struct Columns {
    /// Approximations of the eigenvalues.
    pub(super) values: Vec<f64>,
    pub(super) panels: Vec<Panel>,
}

/// Vectors of the kernel of K.
#[derive(Default)]
pub(super) struct Zeros {
    /// Enclosures of their components, and M times them.
    pub(super) vectors: Vec<Vec<Ball>>,
    images: Vec<Vec<Ball>>,
    /// ZᵀMZ.
    pub(super) gram: Vec<Ball>,
    /// A bound from below of its least eigenvalue.
    pub(super) least: f64,
}

/// Between which numbers as many eigenvalues lie as there are columns, beside the zeros.
#[derive(Clone, Copy)]
pub(super) struct Window {
    /// `None`: nothing lies below.
    pub(super) low: Option<f64>,
    /// `None`: nothing lies above.
    pub(super) high: Option<f64>,
}

/// A small problem with the same eigenvalues, and how far its vectors are from those of the large one.
pub(super) struct Proof {
    pub(super) spectrum: Spectrum,
    /// For each mode of it: a bound of the length (in M) of what its columns do not hold.
    pub(super) outside: Vec<f64>,
}

/// What is measured of the columns: lengths are rounded up.
struct Forms {
    /// XᵀMX and XᵀR, row by row.
    gram: Vec<Ball>,
    leftover: Vec<Ball>,
    theta: Vec<f64>,
    /// ‖x‖ in D.
    lengths: Vec<f64>,
    /// Of the exact residual in D⁻¹, and of what it is off by as computed.
    residuals: Vec<f64>,
    errors: Vec<f64>,
    /// With a positive definite F and Fz = r nearly: rᵀz and ‖r - Fz‖ in D⁻¹.
    solved: Vec<(f64, f64)>,
}

impl Columns {
    pub(super) fn count(&self) -> usize {
        self.values.len()
    }

    fn theta(&self, panel: usize) -> Lane {
        let mut own = Lane::ZERO;
        let part = self.values.iter().skip(panel * LANES);
        own.0.iter_mut().zip(part).for_each(|(own, value)| *own = *value);
        own
    }

    /// How many columns a panel has.
    fn width(&self, panel: usize) -> usize {
        LANES.min(self.count() - panel * LANES)
    }
}

impl Forms {
    fn new(pencil: &Pencil, columns: &Columns, positive: Option<&Factor<'_>>) -> Self {
        let n = columns.count();
        let size = pencil.dimension();
        let length = |panel: &[Lane], weights: &[f64]| squares(panel, weights).map(|square| up(square.sqrt()) + TINY);
        let lengths: Vec<f64> =
            columns.panels.iter().flat_map(|panel| length(panel, &pencil.weights).0).take(n).collect();
        let (own, mass) = (pencil.stiffness_norms, pencil.mass_norms);
        let widest = pencil.stiffness.widest.max(pencil.mass.widest) as f64;
        let unit = U2 * ((widest + 3.0) * (widest + 3.0) + 16.0);
        let of_mass = U2 * form_error(size, pencil.mass.widest) * mass.0 + mass.1;
        let mut measured = Self {
            gram: vec![Ball::ZERO; n * n],
            leftover: vec![Ball::ZERO; n * n],
            theta: columns.values.clone(),
            lengths,
            residuals: Vec::with_capacity(n),
            errors: Vec::with_capacity(n),
            solved: Vec::with_capacity(n),
        };
        let (mut r, mut z) = (vec![Lane::ZERO; size], Vec::new());
        for (number, x) in columns.panels.iter().enumerate() {
            let theta = columns.theta(number);
            residuals(&pencil.stiffness, &pencil.mass, x, theta, &mut r);
            let rounded = length(&r, &pencil.roots);
            let first = number * LANES;
            let here = columns.width(number);
            for l in 0..here {
                let t = theta.0[l].abs();
                let off = (unit * (own.0 + t * mass.0) + own.1 + t * mass.1) * measured.lengths[first + l];
                let error = up(off + 2.0 * U * rounded.0[l]);
                measured.errors.push(error);
                measured.residuals.push(up(rounded.0[l] + error));
            }
            let Self { gram, leftover, lengths, errors, .. } = &mut measured;
            for (p, y) in columns.panels.iter().enumerate() {
                let start = p * LANES;
                let small = plain_forms(y, columns.width(p), &r);
                for (i, row) in small.iter().take(columns.width(p)).enumerate() {
                    for (l, value) in row.iter().take(here).enumerate() {
                        let error = PLAIN_ERROR * rounded.0[l] + errors[first + l];
                        let radius = up(lengths[start + i] * error) + TINY;
                        leftover[(start + i) * n + first + l] = Ball::new(*value, radius);
                    }
                }
                if p > number {
                    continue;
                }
                let own = forms(x, here, &pencil.mass, y);
                for (l, row) in own.iter().take(here).enumerate() {
                    for (i, value) in row.iter().take(columns.width(p)).enumerate() {
                        let (i, j) = (start + i, first + l);
                        let radius = up(of_mass * lengths[i] * lengths[j]) + TINY;
                        let value = Ball::new(*value, radius);
                        (gram[i * n + j], gram[j * n + i]) = (value, value);
                    }
                }
            }
            if let Some(factor) = positive {
                z.clone_from(&r);
                factor.solve_panel(&mut z);
                let products = products(&r, &z);
                let shift = factor.shift;
                let left = leftovers([&pencil.stiffness, &pencil.mass], &z, shift, &r, &pencil.roots);
                let z = length(&z, &pencil.weights);
                // Products of Fz are off by little of |F| |z|, differences by roundings of what they are taken from.
                let rounding = 4.0 * U * (own.0 + shift.abs() * mass.0) + own.1 + shift.abs() * mass.1;
                for l in 0..here {
                    let rest = up(up(left.0[l].sqrt()) + rounding * z.0[l] + 4.0 * U * rounded.0[l]) + TINY;
                    let product = up(products.0[l].abs() + products_error(size) * rounded.0[l] * z.0[l]) + TINY;
                    measured.solved.push((product, rest));
                }
            }
        }
        measured
    }

    /// XᵀKX = θ_j G_ij + XᵀR.
    fn stiffness(&self) -> Vec<Ball> {
        let n = self.theta.len();
        let entry = |at: usize| self.gram[at] * Ball::exact(self.theta[at % n]) + self.leftover[at];
        (0..n * n).map(entry).collect()
    }

    /// A bound from below of the least eigenvalue of G.
    fn least_gram(&self) -> f64 {
        let n = self.theta.len();
        let row = |i: usize| {
            let rest: f64 = (0..n).filter(|j| *j != i).map(|j| self.gram[i * n + j].abs_upper()).sum();
            self.gram[i * n + i].lower() - up(rest * (1.0 + 4.0 * n as f64 * U))
        };
        (0..n).map(row).fold(f64::INFINITY, f64::min)
    }
}

/// The eigenvalues in a window that holds as many as there are columns; `positive` is a factor of K - σ₀M that is positive definite.
/// `None` where the columns prove nothing.
pub(super) fn prove(
    pencil: &Pencil,
    columns: &Columns,
    zeros: &Zeros,
    window: Window,
    positive: Option<&Factor<'_>>,
    options: &Options,
) -> Result<Option<Proof>, ModesError> {
    let forms = Forms::new(pencil, columns, positive);
    let n = columns.count();
    let leak = zeros.leak(columns);
    let least = forms.least_gram();
    if least.is_nan() || least <= 0.5 {
        return Ok(None);
    }
    let one_sided = window.low.is_none();
    let small = |couplings: &dyn Fn(usize, usize) -> f64| small_problem(&forms, zeros, &leak, (couplings, one_sided));
    let plain = options.clone().without_vectors().digits(3);
    let ritz = solve(&small(&|_, _| 0.0), &plain)?;
    let ends = elastic(&ritz, zeros);
    let (Some(lowest), Some(highest)) = (ends.first(), ends.last()) else { return Ok(None) };
    // ‖p_j‖ in M⁻¹; what is left of a residual beside the zero vectors.
    let lengths: Vec<f64> = (0..n).map(|j| up(forms.residuals[j] + forms.theta[j].abs() * leak[j])).collect();
    let total = up(lengths.iter().map(|own| own * own).sum::<f64>() / least);
    let side = |distance: f64| {
        // The complement comes nearer by ‖P‖² / distance.
        let near = distance - up(total / distance);
        (distance > 0.0 && near > 0.0).then_some(near * (1.0 - 8.0 * U))
    };
    let end = |distance: Option<f64>| distance.map_or(Some(f64::INFINITY), |own| side(own * (1.0 - 4.0 * U)));
    let above = end(window.high.map(|high| high - highest.upper()));
    let (Some(above), Some(below)) = (above, end(window.low.map(|low| lowest.lower() - low))) else {
        return Ok(None);
    };
    // Eigenvalues are not above those of Θ at the lower end of the spectrum; elsewhere they are next to them by ‖P‖.
    let reach = if one_sided { 0.0 } else { up(total.sqrt()) };
    let gap = (above.min(below) - reach) * (1.0 - 4.0 * U);
    if gap <= 0.0 {
        return Ok(None);
    }
    let plainly = |i: usize, j: usize| up(lengths[i] * lengths[j] / gap);
    let first = solve(&small(&plainly), &plain)?;
    // The refined bound needs a bound of the lowest eigenvalue.
    let lowest = elastic(&first, zeros).first().map_or(f64::NEG_INFINITY, |own| own.lower());
    let refined = match (positive, window) {
        (Some(factor), Window { low: None, high: Some(high) }) if lowest > factor.shift => {
            let room = (lowest - factor.shift) * (1.0 - 4.0 * U);
            let own = forms.in_inverse(factor, &leak, (room, least), zeros);
            let ratio = up((high - factor.shift) / above);
            Some((own, ratio))
        }
        _ => None,
    };
    let couplings = |i: usize, j: usize| match &refined {
        Some((own, ratio)) => up(ratio * own[i] * own[j]).min(plainly(i, j)),
        None => plainly(i, j),
    };
    let spectrum = solve(&small(&couplings), options)?;
    let outside = spectrum.modes.iter().map(|mode| {
        let sum = |own: &[f64]| -> f64 {
            let parts = mode.vector.iter().skip(zeros.vectors.len()).zip(own);
            up(parts.map(|(c, own)| (c.abs() + mode.vector_error_bound) * own).sum::<f64>()
                * (1.0 + 4.0 * n as f64 * U))
        };
        let crude = up(sum(&lengths) / gap);
        let fine = refined.as_ref().map_or(f64::INFINITY, |(own, ratio)| up((ratio / above).sqrt() * sum(own)));
        up(crude.min(fine) + sum(&leak))
    });
    let outside = outside.collect();
    Ok(Some(Proof { spectrum, outside }))
}

/// The eigenvalues that are no proved zeros.
fn elastic(spectrum: &Spectrum, zeros: &Zeros) -> Vec<Ball> {
    let mut left = zeros.vectors.len();
    let modes = spectrum.modes.iter().filter(|mode| {
        let is_zero = left > 0 && mode.kind == super::super::Kind::Zero;
        left -= usize::from(is_zero);
        !is_zero
    });
    modes.map(|mode| mode.omega_squared).collect()
}

/// (Θ - S, G), with a block of zeros in front. Where nothing lies below (`one_sided`), S is not negative.
fn small_problem(
    forms: &Forms,
    zeros: &Zeros,
    leak: &[f64],
    (couplings, one_sided): (&dyn Fn(usize, usize) -> f64, bool),
) -> Problem {
    let (z, n) = (zeros.vectors.len(), forms.theta.len());
    let dimension = z + n;
    let mut mass = vec![Ball::ZERO; dimension * dimension];
    let mut stiffness = mass.clone();
    for j in 0..z {
        for i in 0..z {
            mass[i + dimension * j] = zeros.gram[i + z * j];
        }
    }
    let theta = forms.stiffness();
    for j in 0..n {
        for i in 0..n {
            let at = (z + i) + dimension * (z + j);
            // The lower triangle is read.
            let (row, column) = (i.max(j), i.min(j));
            let own = forms.gram[row * n + column];
            mass[at] = own.with_added_radius(up(leak[i] * leak[j]));
            let coupling = couplings(i, j);
            let half = 0.5 * coupling;
            let own = theta[row * n + column];
            stiffness[at] = if i == j && one_sided {
                (own - Ball::exact(half)).with_added_radius(half)
            } else {
                own.with_added_radius(coupling)
            };
        }
    }
    let unit = |j: usize| (0..dimension).map(|i| if i == j { Ball::ONE } else { Ball::ZERO }).collect();
    Problem { dimension, mass, stiffness, zero_vectors: (0..z).map(unit).collect() }
}

impl Forms {
    /// Bounds of ‖p_j‖ in the norm of F⁻¹, F = K - σ₀M >= `room` M on what is orthogonal to the zero vectors.
    ///
    /// For any z, rᵀF⁻¹r = rᵀz + rᵀF⁻¹(r - Fz), so that q = ‖r‖ satisfies q² <= rᵀz + q ‖r - Fz‖, the last length at most that in
    /// D⁻¹ over √room. P differs from R by MX G⁻¹XᵀR, and by θ M times what X has of the zero vectors, on which F is the shift.
    fn in_inverse(&self, factor: &Factor<'_>, leak: &[f64], (room, least): (f64, f64), zeros: &Zeros) -> Vec<f64> {
        let n = self.theta.len();
        let room = if zeros.vectors.is_empty() { room } else { room.min(factor.shift.abs()) };
        let root = room.sqrt() * (1.0 - 4.0 * U);
        let longest = self.lengths.iter().copied().fold(0.0, f64::max);
        let longest = longest * up((factor.pencil.mass_norms.0 + factor.pencil.mass_norms.1).sqrt());
        let norm = |j: usize| {
            let (product, rest) = self.solved[j];
            let rest = up(rest / root);
            let q = up(0.5 * (rest + (rest * rest + 4.0 * product).sqrt()));
            let square: f64 = (0..n).map(|i| self.leftover[i * n + j].abs_upper().powi(2)).sum();
            let turned = up(square.sqrt() * (n as f64).sqrt() * (1.0 + 4.0 * n as f64 * U) / least * longest);
            up(q + (self.errors[j] + turned + self.theta[j].abs() * leak[j]) / root)
        };
        (0..n).map(norm).collect()
    }
}

impl Zeros {
    /// Bounds of what the columns have of the zero vectors, in the length of M.
    fn leak(&self, columns: &Columns) -> Vec<f64> {
        let n = columns.count();
        if self.vectors.is_empty() {
            return vec![0.0; n];
        }
        let leak = |j: usize| {
            let (panel, lane) = (&columns.panels[j / LANES], j % LANES);
            let square = |image: &Vec<Ball>| {
                let parts = image.iter().zip(panel).map(|(m, x)| *m * Ball::exact(x.0[lane]));
                parts.fold(Ball::ZERO, |sum, part| sum + part).abs_upper().powi(2)
            };
            up((self.images.iter().map(square).sum::<f64>() / self.least).sqrt())
        };
        (0..n).map(leak).collect()
    }

    /// Vectors of the kernel, made orthonormal as balls allow; `None` where they are not independent, or one is certainly none of it.
    pub(super) fn new(pencil: &Pencil, vectors: Vec<Vec<Ball>>) -> Option<Self> {
        if vectors.iter().any(|own| pencil.stiffness.times_balls(own).iter().any(|x| !x.contains_zero())) {
            return None;
        }
        let image = |x: &[Ball]| pencil.mass.times_balls(x);
        let Orthonormal { vectors, images, gram, defect } = Orthonormal::new(vectors, &image, ()).ok()?;
        Some(Self { vectors, images, gram, least: 1.0 - defect })
    }
}
