//! The linearization once more in numbers of any precision.

use super::Linearized;
use super::assemble::{Values, evaluate_closed};
use super::equilibrium::Origin;
use super::existence::Proof;
use super::zero::{self, ZeroMode};
use crate::precision::Big;

/// With fewer bits than double-double has there is nothing to gain.
const LEAST_BITS: usize = 128;

/// M, K and the equilibrium to any number of bits, from the exact expressions.
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
    /// The stiffness matrix, dense, column by column, in SI.
    pub stiffness: Vec<Big>,
    values: Values<Big>,
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
        let proof = found.proof.as_deref();
        let bits = bits.max(LEAST_BITS).max(proof.map_or(0, Proof::bits));
        let values = self.assembly.values::<Big>(&self.model, bits).ok()?;
        let mut equilibrium = Vec::with_capacity(found.values.len());
        for (i, value) in found.values.iter().enumerate() {
            equilibrium.push(match found.origins[i] {
                Origin::Given => {
                    let given = self.model.equilibria[i].and_then(|given| given.value)?;
                    evaluate_closed(&self.model.pool, given, bits)?
                }
                Origin::Zero => Big::zero(bits),
                Origin::Found => Big::from_ball(value, bits),
            });
        }
        if let Some(proof) = proof {
            let gradient = |at: &[Big]| self.assembly.gradient(at, &values);
            equilibrium = proof.refine(equilibrium, bits, gradient)?;
        }
        let mass = self.assembly.mass(&equilibrium, &values);
        let stiffness = self.assembly.stiffness(&equilibrium, &values);
        let finite = |numbers: &[Big]| numbers.iter().all(Big::is_finite);
        (finite(&equilibrium) && finite(&mass) && finite(&stiffness)).then_some(Precise {
            bits,
            equilibrium,
            mass,
            stiffness,
            values,
        })
    }

    /// Modes of [`Linearized::zero_modes`] in numbers of any precision: the same vectors, known better.
    /// `None` where the numbers do not do.
    #[must_use]
    pub fn precise_zero_modes(
        &self,
        precise: &Precise,
        modes: &[ZeroMode],
    ) -> Option<Vec<ZeroMode<Big>>> {
        zero::in_numbers(modes, &self.assembly, &precise.equilibrium, &precise.values)
    }
}
