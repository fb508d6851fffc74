//! The stiffness matrix as a sum of squares, from the elements: nothing is added up that could cancel.

use super::assemble::{Assembly, Part, Values, head};
use crate::precision::{Ball, Factors, Scalar};

impl Assembly {
    /// The factors of the stiffness matrix; see [`Factors`].
    pub(crate) fn factors(&self, at: &[Ball], values: &Values<Ball>) -> Factors {
        let n = self.dimension;
        let mut factors = Factors::default();
        self.run(Part::Stiffness, at, values, |family, instance, numbers, _| {
            let coordinates = family.terms.coordinates_of(instance);
            let mut numbers = numbers;
            for element in &family.potential {
                let (outer, slopes) = head(&mut numbers, 2, element.slope.len());
                let (curvature, _) = head(&mut numbers, element.curvature.len(), 0);
                let (tension, stiffness) = (outer[0], outer[1]);
                let mut entries = element.slopes(coordinates, slopes);
                entries.retain(|(_, entry)| !entry.is_exact_zero());
                let mut add = |i: usize, j: usize, value: Ball| {
                    if factors.rest.is_empty() {
                        factors.rest = vec![Ball::ZERO; n * n];
                    }
                    factors.rest[i + n * j] = factors.rest[i + n * j] + value;
                };
                if stiffness.is_positive() || stiffness.is_negative() {
                    let root = stiffness.abs().sqrt();
                    for (_, entry) in &mut entries {
                        *entry = *entry * root;
                    }
                    if !entries.is_empty() {
                        factors.rows.push((stiffness.is_positive(), entries));
                    }
                } else if !stiffness.is_exact_zero() {
                    for (i, x) in &entries {
                        for (j, y) in &entries {
                            add(*i, *j, stiffness * *x * *y);
                        }
                    }
                }
                if !tension.is_exact_zero() {
                    for ((a, b, _), bend) in element.curvature.iter().zip(curvature) {
                        let (i, j) = (coordinates[*a] as usize, coordinates[*b] as usize);
                        let value = tension * *bend;
                        add(i, j, value);
                        if a != b {
                            add(j, i, value);
                        }
                    }
                }
            }
        });
        factors
    }
}
