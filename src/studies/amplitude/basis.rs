//! Normal coordinates with bounds: components of forces, and what they displace.
//!
//! Modes that the bounds do not separate are taken together, for only the space of their shapes is known. With shapes U in that space
//! and their Gram matrix G = UᵀMU = 1 + E, the part of a force f in the space is M U c with c = G⁻¹Uᵀf, and
//! ‖G⁻¹ - 1‖ <= e/(1 - e) for e = ‖E‖ < 1 in the norm of row sums (Neumann's series; for the symmetric E this norm bounds the spectral
//! one, so that no eigenvalue of G is below 1 - e).

use librate_core::linearize::Linearized;
use librate_core::modes::Kind;
use librate_core::order::Gather as _;
use librate_core::oscillation::{NormalMode, NormalModes};
use librate_core::precision::{Ball, Scalar, up};

/// Modes that are not separated.
pub(super) struct Group {
    pub(super) members: Vec<usize>,
    /// ω² of all of them.
    pub(super) square: Ball,
    /// A bound of ‖G⁻¹ - 1‖; infinite where there is none.
    slack: f64,
}

/// The shapes of all modes, enclosed.
pub(super) struct Basis {
    /// Shapes x with xᵀMx = 1, as far as groups of more than one tell.
    pub(super) shapes: Vec<Vec<Ball>>,
    pub(super) groups: Vec<Group>,
    /// The group of each mode.
    pub(super) group_of: Vec<usize>,
}

impl Basis {
    /// `None` where modes or shapes are missing.
    pub(super) fn new(linearized: &Linearized, modes: &NormalModes) -> Option<Self> {
        let n = linearized.dimension();
        let modes = &modes.modes;
        if modes.len() != n || modes.iter().any(|mode| mode.vector.len() != n) {
            return None;
        }
        let shape = |mode: &NormalMode| -> Vec<Ball> {
            mode.vector.iter().map(|x| Ball::exact(*x).with_added_radius(mode.vector_error_bound)).collect()
        };
        let shapes: Vec<Vec<Ball>> = modes.iter().map(shape).collect();
        let alike = modes.iter().enumerate().map(|(at, mode)| ((mode.cluster, mode.kind == Kind::Zero), at)).grouped();
        let mass = if alike.len() < n { linearized.mass() } else { Vec::new() };
        let mut groups = Vec::with_capacity(alike.len());
        let mut group_of = vec![0; n];
        for ((_, zero), members) in alike {
            let own = |k: &usize| if zero { Some(Ball::ZERO) } else { modes[*k].omega_squared };
            let squares: Vec<Ball> = members.iter().map(own).collect::<Option<_>>()?;
            let square = squares.into_iter().reduce(|all, square| all.hull(&square))?;
            let slack = if members.len() > 1 { slack(&mass, &shapes, &members) } else { 0.0 };
            for k in &members {
                group_of[*k] = groups.len();
            }
            groups.push(Group { members, square, slack });
        }
        Some(Self { shapes, groups, group_of })
    }

    /// The coefficients c of a force M X c.
    pub(super) fn components(&self, force: &[Ball]) -> Vec<Ball> {
        let own: Vec<(usize, Ball)> =
            force.iter().enumerate().filter(|(_, f)| !f.is_zero()).map(|(i, f)| (i, *f)).collect();
        let mut all: Vec<Ball> =
            self.shapes.iter().map(|shape| own.iter().fold(Ball::ZERO, |sum, (i, f)| sum + shape[*i] * *f)).collect();
        for group in self.groups.iter().filter(|group| group.slack > 0.0) {
            // |((G⁻¹ - 1) z)_k| <= ‖G⁻¹ - 1‖ max |z|
            let most = group.members.iter().map(|k| all[*k].abs_upper());
            let error = up(group.slack * most.fold(0.0, f64::max));
            for k in &group.members {
                all[*k] = all[*k].with_added_radius(error);
            }
        }
        all
    }

    /// c_k/(ω_k² - square) for each mode: what a force with these components, at a frequency of that square, displaces. A mode whose
    /// ω² is not told from the square is left where it is, if its component is not told from 0; else it would have to be
    /// displaced without end, and its number is the error.
    ///
    /// Members of a group may differ in ω². With 1/(ω_k² - square) = r ± d for all of them, so that it is a symmetric D with
    /// |D - r| <= d in an orthonormal basis U G^(-1/2) of the space, the coefficients are
    /// G^(-1/2) D G^(-1/2) Uᵀf = r c + G^(-1/2)(D - r) G^(1/2) c, and the second part is at most
    /// d sqrt((1 + e)/(1 - e)) |c| <= d |c|/(1 - e) = d |c| (1 + e/(1 - e)).
    pub(super) fn response(&self, components: &[Ball], square: &Ball) -> Result<Vec<Ball>, usize> {
        let mut all = vec![Ball::ZERO; components.len()];
        for group in &self.groups {
            let distance = group.square - *square;
            if distance.contains_zero() {
                let forced = |k: &&usize| !components[**k].contains_zero();
                if let Some(mode) = group.members.iter().find(forced) {
                    return Err(*mode);
                }
                continue;
            }
            let inverse = Ball::ONE / distance;
            let error = if group.members.len() > 1 {
                let sum = group.members.iter().map(|k| components[*k].abs_upper());
                let sum = sum.fold(0.0, |sum, part| up(sum + part));
                up(inverse.radius * sum * (1.0 + group.slack))
            } else {
                0.0
            };
            for k in &group.members {
                all[*k] = (inverse * components[*k]).with_added_radius(error);
            }
        }
        Ok(all)
    }

    /// Σ c_k x_k in the coordinates.
    pub(super) fn displacement(&self, coefficients: &[Ball]) -> Vec<Ball> {
        let live = || coefficients.iter().zip(&self.shapes).filter(|(c, _)| !c.is_zero());
        (0..self.shapes.len()).map(|i| live().fold(Ball::ZERO, |sum, (c, shape)| sum + *c * shape[i])).collect()
    }
}

/// e/(1 - e) for the largest row sum e of |UᵀMU - 1|.
fn slack(mass: &[Ball], shapes: &[Vec<Ball>], members: &[usize]) -> f64 {
    let n = shapes.len();
    let image = |k: &usize| -> Vec<Ball> {
        let row = |i: usize| {
            let entries = (0..n).map(|j| (mass[i + n * j], shapes[*k][j])).filter(|(entry, _)| !entry.is_zero());
            entries.fold(Ball::ZERO, |sum, (entry, x)| sum + entry * x)
        };
        (0..n).map(row).collect()
    };
    let images: Vec<Vec<Ball>> = members.iter().map(image).collect();
    let mut most = 0.0_f64;
    for (a, k) in members.iter().enumerate() {
        let mut sum = 0.0;
        for (b, image) in images.iter().enumerate() {
            let entry = shapes[*k].iter().zip(image).fold(Ball::ZERO, |sum, (x, y)| sum + *x * *y);
            let unit = if a == b { Ball::ONE } else { Ball::ZERO };
            sum = up(sum + Scalar::sub(&entry, &unit).abs_upper());
        }
        most = most.max(sum);
    }
    // `up` makes more of the difference's rounding than it is; below 1/2 the subtraction is harmless.
    if most < 0.5 { up(most / (1.0 - most)) } else { f64::INFINITY }
}
