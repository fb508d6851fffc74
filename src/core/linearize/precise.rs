//! The linearization once more in numbers of any precision.

use super::assemble::{Assembly, Values};
use super::constrained::{Tangent, gradients};
use super::equilibrium::Equilibrium;
use super::massless::rows;
use super::velocity::sum;
use super::zero::{self, ZeroMode};
use super::{Linearized, tied};
use crate::model::Model;
use crate::precision::Big;

/// With fewer bits than double-double has there is nothing to gain.
const LEAST_BITS: usize = 128;

/// All matrices and the equilibrium to any number of bits, from the exact expressions.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Precise {
    /// The precision that all was worked out with.
    pub bits: usize,
    /// The equilibrium in SI, one number a coordinate. What was searched for and proved is known as
    /// well as forces of so many bits tell; what was not proved no better than in
    /// [`Equilibrium::values`](super::Equilibrium::values), and no less of an estimate.
    pub equilibrium: Vec<Big>,
    /// The mass matrix, dense, column by column, in SI.
    pub mass: Vec<Big>,
    /// The stiffness matrix, dense, column by column, in SI, with what friction at rest adds to it.
    pub stiffness: Vec<Big>,
    /// G + C, dense, column by column, in SI; `None` where there is neither.
    pub velocity: Option<Vec<Big>>,
    /// The equilibrium with multipliers.
    point: Vec<Big>,
    /// From all coordinates to those that are left, one after the other.
    tangents: Vec<Tangent<Big>>,
    values: Values<Big>,
}

/// An equilibrium with the precision of `values`: see [`Linearized::precisely`].
pub(super) fn equilibrium(
    model: &Model,
    assembly: &Assembly,
    found: &Equilibrium,
    values: &Values<Big>,
) -> Option<Vec<Big>> {
    let bits = values.precision();
    let equilibrium = found.in_numbers(model, bits, |value| Some(Big::from_ball(value, bits)))?;
    match found.proof.as_deref() {
        Some(proof) => proof.refine(equilibrium, bits, |at| assembly.gradient(at, values)),
        None => Some(equilibrium),
    }
}

impl Precise {
    /// [`Linearized::directions`].
    #[must_use]
    pub fn directions(&self) -> Option<Vec<Vec<Big>>> {
        self.tangents.first().map(|own| own.rows(self.bits))
    }
}

impl Linearized {
    /// Equilibrium, mass matrix and stiffness matrix with `bits` bits (at least 128 are used, and as many
    /// as the proof of the equilibrium took).
    ///
    /// An equilibrium that was searched for and proved gets Newton steps with forces of that
    /// precision, and its radius is proved again by Krawczyk's theorem (Computing 4 (1969) 187).
    /// `None` where the energies are not finite there or a proved equilibrium gets no closer.
    #[must_use]
    pub fn precisely(&self, bits: usize) -> Option<Precise> {
        let found = &self.equilibrium;
        let other = self.unbalanced.as_ref().map_or(0, |own| own.equilibrium.bits());
        let bits = bits.max(LEAST_BITS).max(found.bits()).max(other);
        let values = self.assembly.values::<Big>(&self.model, bits).ok()?;
        let order = self.model.coordinates.len();
        let visible = self.coordinates();
        let mut point = match &self.unbalanced {
            Some(own) => own.precisely(bits, order)?,
            None => equilibrium(&self.model, &self.assembly, found, &values)?,
        };
        if let Some(own) = self.constrained.as_ref().filter(|own| found.multipliers_given && !own.bound.is_empty()) {
            tied::put_multipliers_in(&self.assembly, &values, &mut point, visible, &own.bound)?;
        }
        let mut tangents = Vec::new();
        let [mass, gyroscopic, damping, stiffness, mut circulatory] = match self.rolling() {
            Some(own) => {
                let (matrices, tangent) = own.numbers::<Big>(&self.model, &point, bits)?;
                tangents.push(tangent);
                matrices
            }
            None => self.assembly.matrices(&point, &values),
        };
        let (mut mass, mut stiffness, mut velocity) = (mass?, stiffness?, sum(gyroscopic, damping));
        // Conditions on velocities are put in with the constraints beside them.
        if let Some(own) = self.constrained.as_ref().filter(|own| own.rolling.is_none() && !own.bound.is_empty()) {
            let rows = gradients(&stiffness, visible, order);
            let own = Tangent::new(&rows, &own.bound, bits)?;
            mass = own.reduce_symmetric(&mass, order);
            stiffness = own.reduce_symmetric(&stiffness, order);
            velocity = velocity.map(|matrix| own.reduce(&matrix, order));
            circulatory = circulatory.map(|matrix| own.reduce(&matrix, order));
            tangents.push(own);
        }
        stiffness = sum(Some(stiffness), circulatory)?;
        if let Some(massless) = self.massless() {
            let held = rows(&massless.directions, &stiffness, bits);
            let own = Tangent::new(&held, &massless.following, bits)?;
            let order = stiffness.len().isqrt();
            mass = own.reduce_symmetric(&mass, order);
            stiffness = own.reduce(&stiffness, order);
            velocity = velocity.map(|matrix| own.reduce(&matrix, order));
            tangents.push(own);
        }
        let finite = |numbers: &[Big]| numbers.iter().all(Big::is_finite);
        let length = |at| self.units.as_ref().map_or(0, |own| own.length(at));
        let ends = finite(&point) && finite(&mass) && finite(&stiffness);
        (ends && velocity.as_deref().is_none_or(finite)).then(|| Precise {
            bits,
            equilibrium: point[..visible].iter().enumerate().map(|(at, x)| x.scale(length(at))).collect(),
            mass,
            stiffness,
            velocity,
            point,
            tangents,
            values,
        })
    }

    /// Modes of [`Linearized::zero_modes`] in numbers of any precision: the same vectors, known better.
    /// `None` where the numbers do not do.
    #[must_use]
    pub fn precise_zero_modes(&self, precise: &Precise, modes: &[ZeroMode]) -> Option<Vec<ZeroMode<Big>>> {
        let modes = zero::in_numbers(modes, &self.assembly, &precise.point, &precise.values)?;
        if self.rolling().is_some() {
            return Some(modes);
        }
        let restricted =
            |vector: &[Big]| precise.tangents.iter().fold(vector.to_vec(), |vector, tangent| tangent.restrict(&vector));
        Some(modes.into_iter().map(|mode| mode.mapped(restricted)).collect())
    }
}
