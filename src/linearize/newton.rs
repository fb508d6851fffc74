//! Newton steps along the principal axes of the stiffness, in mass-weighted coordinates.

use nalgebra::{DVector, SymmetricEigen};

/// A force in mass-weighted coordinates.
pub(super) struct Force {
    pub(super) vector: DVector<f64>,
    pub(super) norm: f64,
    pub(super) noise: f64,
    pub(super) finite: bool,
    pub(super) rounding: bool,
}

/// The stiffness in mass-weighted coordinates, taken to its principal axes.
pub(super) struct Spectrum {
    pub(super) eigen: SymmetricEigen<f64, nalgebra::Dyn>,
}

impl Spectrum {
    /// -K⁺F: components of the force that are rounding move nothing.
    pub(super) fn newton(&self, force: &Force) -> DVector<f64> {
        let components = self.eigen.eigenvectors.transpose() * &force.vector;
        let largest = self.eigen.eigenvalues.amax();
        let noise = force.noise * (components.len() as f64).sqrt() + 1e-18 * force.norm;
        let steps = DVector::from_iterator(
            components.len(),
            components
                .iter()
                .zip(self.eigen.eigenvalues.iter())
                .map(|(f, k)| {
                    let neutral = k.abs() <= 1e-15 * largest || f.abs() <= noise;
                    if neutral { 0.0 } else { -f / k }
                }),
        );
        &self.eigen.eigenvectors * steps
    }

    /// How far each principal axis may still be off: (|F| + noise)/|k|; none along neutral ones.
    pub(super) fn reach(&self, force: &Force) -> Vec<f64> {
        let components = self.eigen.eigenvectors.transpose() * &force.vector;
        let largest = self.eigen.eigenvalues.amax();
        components
            .iter()
            .zip(self.eigen.eigenvalues.iter())
            .map(|(f, k)| {
                if k.abs() <= 1e-12 * largest {
                    0.0
                } else {
                    (f.abs() + force.noise * (components.len() as f64).sqrt()) / k.abs()
                }
            })
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
            noise: before.noise + after.noise,
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
        let components = self.eigen.eigenvectors.transpose() * &force.vector;
        let largest = self.eigen.eigenvalues.amax();
        let noise = force.noise * (components.len() as f64).sqrt() + 1e-13 * force.norm;
        components
            .iter()
            .zip(self.eigen.eigenvalues.iter())
            .any(|(f, k)| k.abs() <= 1e-15 * largest && f.abs() > noise)
    }
}
