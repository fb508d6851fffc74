//! The entries of M and K that are not zero, to many bits, without the others.

use std::collections::BTreeMap;

use super::assemble::Part;
use super::equilibrium::Origin;
use super::{Linearized, precise};
use crate::precision::{Big, Scalar};

/// The lower triangles of M and K by row and column.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Entries {
    /// Of the mass matrix.
    pub mass: BTreeMap<(usize, usize), Big>,
    /// Of the stiffness matrix.
    pub stiffness: BTreeMap<(usize, usize), Big>,
}

impl Linearized {
    /// The entries of M and K with so many bits, where the equilibrium is known exactly; `None` where it
    /// was searched for, or something is not finite.
    #[must_use]
    pub fn entries(&self, bits: usize) -> Option<Entries> {
        let values = self.assembly.values::<Big>(&self.model, bits).ok()?;
        if self.equilibrium.origins.contains(&Origin::Found) {
            return None;
        }
        let at = precise::equilibrium(&self.model, &self.assembly, &self.equilibrium, &values)?;
        let added = |part: Part| {
            let mut entries: BTreeMap<(usize, usize), Big> = BTreeMap::new();
            self.assembly.entries(part, &at, &values, |i, j, share| {
                let entry = entries.entry((i as usize, j as usize));
                entry.and_modify(|own| *own = own.add(share)).or_insert_with(|| share.clone());
            });
            entries.values().all(Big::is_finite).then_some(entries)
        };
        Some(Entries { mass: added(Part::Inertia)?, stiffness: added(Part::Stiffness)? })
    }
}
