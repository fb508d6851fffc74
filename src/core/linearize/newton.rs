//! Newton steps along the principal axes of the stiffness, in mass-weighted coordinates.

use nalgebra::{DVector, SymmetricEigen};

/// A force in mass-weighted coordinates.
pub(super) struct Force {
    pub(super) vector: DVector<f64>,
    pub(super) norm: f64,
    /// What rounding may have done to each component: a light coordinate's must not hide a heavy
    /// one's force.
    pub(super) noise: DVector<f64>,
    pub(super) finite: bool,
    pub(super) rounding: bool,
}

/// A step downhill.
pub(super) struct Downhill {
    pub(super) step: DVector<f64>,
    /// Whether it is that of Newton.
    pub(super) whole: bool,
    /// By how much V is expected to fall.
    pub(super) falls: f64,
}

/// The stiffness in mass-weighted coordinates, taken to its principal axes.
pub(super) struct Spectrum {
    pub(super) eigen: SymmetricEigen<f64, nalgebra::Dyn>,
}

/// Beside an eigenvalue this small, relative to the largest, a symmetry is searched for.
const NEARLY_SINGULAR: f64 = 1e-10;

impl Spectrum {
    /// Whether the stiffness may be singular.
    pub(super) fn is_nearly_singular(&self) -> bool {
        let softest = self.eigen.eigenvalues.iter().map(|x| x.abs());
        let softest = softest.fold(f64::INFINITY, f64::min);
        softest <= NEARLY_SINGULAR * self.eigen.eigenvalues.amax()
    }

    /// The force along each principal axis, and what of it may be rounding, of which `share` is that
    /// of the products taken here.
    pub(super) fn components(&self, force: &Force, share: f64) -> (DVector<f64>, DVector<f64>) {
        let axes = &self.eigen.eigenvectors;
        let slack = &force.noise + force.vector.abs() * share;
        let noise = axes.column_iter().map(|axis| axis.abs().dot(&slack));
        (axes.tr_mul(&force.vector), DVector::from_iterator(slack.len(), noise))
    }

    /// The step of least size that lowers the quadratic model with |K| in place of K, no longer than
    /// `radius` (Dauphin and others, NIPS 27 (2014) 2933).
    pub(super) fn downhill(&self, force: &Force, radius: f64) -> Downhill {
        let (components, noise) = self.components(force, 1e-18);
        let largest = self.eigen.eigenvalues.amax();
        let at = |shift: f64| {
            DVector::from_fn(components.len(), |mode, _| {
                let f = components[mode];
                let k = self.eigen.eigenvalues[mode].abs().max(1e-16 * largest) + shift;
                if f.abs() <= noise[mode] || k == 0.0 { 0.0 } else { -f / k }
            })
        };
        let mut steps = at(0.0);
        let whole = steps.norm() <= radius;
        if !whole {
            // |step| falls with the shift, and is below the radius at |F|/radius.
            let (mut low, mut high) = (0.0, components.norm() / radius);
            for _ in 0..60 {
                // The shift may be of any size.
                let middle = if low > 0.0 { f64::sqrt(low * high) } else { high * 1e-12 };
                if at(middle).norm() > radius {
                    low = middle;
                } else {
                    high = middle;
                }
                if high <= 1.05 * low || (low == 0.0 && high <= 1e-16 * largest) {
                    break;
                }
            }
            steps = at(high);
        }
        let falls = -steps.dot(&components);
        Downhill { step: &self.eigen.eigenvectors * steps, whole, falls }
    }

    /// Whether K is nowhere negative beyond rounding.
    pub(super) fn is_bowl(&self) -> bool {
        let floor = -1e-12 * self.eigen.eigenvalues.amax();
        self.eigen.eigenvalues.iter().all(|k| *k >= floor)
    }

    /// -K⁺F: components of the force that are rounding move nothing.
    pub(super) fn newton(&self, force: &Force) -> DVector<f64> {
        let (components, noise) = self.components(force, 1e-18);
        let largest = self.eigen.eigenvalues.amax();
        let steps = DVector::from_fn(components.len(), |mode, _| {
            let (f, k) = (components[mode], self.eigen.eigenvalues[mode]);
            let neutral = k.abs() <= 1e-15 * largest || f.abs() <= noise[mode];
            if neutral { 0.0 } else { -f / k }
        });
        &self.eigen.eigenvectors * steps
    }

    /// How far each principal axis may still be off: (|F| + noise)/|k|; none along neutral ones.
    pub(super) fn reach(&self, force: &Force) -> Vec<f64> {
        let (components, noise) = self.components(force, 0.0);
        let largest = self.eigen.eigenvalues.amax();
        let modes = components.iter().zip(&noise).zip(&self.eigen.eigenvalues);
        modes
            .map(|((f, noise), k)| if k.abs() <= 1e-12 * largest { 0.0 } else { (f.abs() + noise) / k.abs() })
            .collect()
    }

    /// Whether the force after a damped step is what the linear model foresaw, (1 - damping)·F, to
    /// within half the step. It keeps the path close to that of infinitely small Newton steps,
    /// which leads to the equilibrium nearby, where a full step from a place of small stiffness
    /// may land anywhere (Deuflhard, Newton Methods for Nonlinear Problems, sec. 3.1).
    pub(super) fn foresaw(&self, before: &Force, after: &Force, damping: f64, length: f64) -> bool {
        if after.rounding {
            return true;
        }
        let defect = Force {
            vector: &after.vector - &before.vector * (1.0 - damping),
            norm: before.norm,
            noise: &before.noise + &after.noise,
            finite: true,
            rounding: false,
        };
        self.newton(&defect).norm() <= 0.5 * length
    }

    /// Whether the stiffness along a step is the same as before it to within its own size: a full
    /// step from an inflection may land near another equilibrium by chance, which the force alone
    /// does not tell.
    pub(super) fn resembles(&self, before: &Self, step: &DVector<f64>) -> bool {
        let apply = |own: &Self| {
            let mut components = own.eigen.eigenvectors.transpose() * step;
            components.component_mul_assign(&own.eigen.eigenvalues);
            &own.eigen.eigenvectors * components
        };
        let (now, then) = (apply(self), apply(before));
        (&now - &then).norm() <= then.norm()
    }

    /// Whether a force acts along a direction without stiffness: Newton can't answer it.
    pub(super) fn pushes_neutral(&self, force: &Force) -> bool {
        let (components, noise) = self.components(force, 1e-13);
        let largest = self.eigen.eigenvalues.amax();
        let mut modes = components.iter().zip(&noise).zip(&self.eigen.eigenvalues);
        modes.any(|((f, noise), k)| k.abs() <= 1e-15 * largest && f.abs() > *noise)
    }
}
