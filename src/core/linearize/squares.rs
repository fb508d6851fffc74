//! The stiffness matrix as a sum of squares, from the elements: nothing is added up that could cancel.

use super::assemble::{Assembly, Part, Values, head};
use crate::precision::{Ball, Scalar};

impl Assembly {
    /// Of K = Σ a aᵀ the vectors a, entries that are not 0 with their places; `None` where one is under tension, or its stiffness is not shown to be positive.
    pub(super) fn squares(&self, at: &[Ball], values: &Values<Ball>) -> Option<Vec<Vec<(usize, Ball)>>> {
        let mut squares = Some(Vec::new());
        self.run(Part::Stiffness, at, values, |family, instance, numbers, _| {
            let coordinates = family.terms.coordinates_of(instance);
            let mut numbers = numbers;
            for element in &family.potential {
                let (outer, slopes) = head(&mut numbers, 2, element.slope.len());
                let (curvature, _) = head(&mut numbers, element.curvature.len(), 0);
                let (tension, stiffness) = (outer[0], outer[1]);
                let mut entries = element.slopes(coordinates, slopes);
                entries.retain(|(_, entry)| !entry.is_exact_zero());
                let bends = curvature.iter().any(|bend| (tension * *bend).mid_f64() != 0.0);
                let acts = !entries.is_empty() && !stiffness.is_exact_zero();
                if bends || acts && !stiffness.is_positive() {
                    squares = None;
                } else if acts {
                    let root = stiffness.sqrt();
                    entries.iter_mut().for_each(|(_, entry)| *entry = *entry * root);
                    squares.iter_mut().for_each(|squares| squares.push(std::mem::take(&mut entries)));
                }
            }
        });
        squares
    }
}
