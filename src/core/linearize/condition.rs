//! How well the numbers of a model determine a frequency.
//!
//! Near a bifurcation ω² is the small difference of large terms, and a small change of one of these is a
//! large one of ω²: how large the terms of xᵀKx are beside their sum is told by the elements, in doubles.
//! It is no bound; a leading digit is all that is asked for.

use super::Linearized;
use super::assemble::{Part, Values, head};
use crate::precision::{Ball, Scalar};

/// A mode to be judged.
pub(crate) struct Shape<'a> {
    /// x, xᵀMx = 1.
    pub(crate) vector: &'a [f64],
    /// What each component may be off by.
    pub(crate) error: f64,
    /// ω² or its opposite, not 0.
    pub(crate) square: f64,
}

impl Linearized {
    /// For each shape Σ |k_e|(∇s_e·x)² + |t_e xᵀ∇∇s_e x| over |xᵀKx|: 1 where nothing cancels. What the
    /// errors of x may account for is left out: a stiff spring beside a soft one is no cancellation.
    ///
    /// Doubles are asked first; what they say of a mode is believed below `limit` only, as tensions may be
    /// rounding.
    pub(crate) fn cancellation(&self, shapes: &[Shape<'_>], limit: f64) -> Option<Vec<f64>> {
        let values = self.assembly.values::<f64>(&self.model, ()).ok()?;
        let at = &self.equilibrium.values;
        let middles: Vec<f64> = at.iter().map(Ball::mid_f64).collect();
        if self.adds_squares(&middles, &values) {
            return Some(vec![1.0; shapes.len()]);
        }
        let rough = self.parts(&middles, &values, shapes, |x| *x);
        if rough.iter().all(|ratio| *ratio < limit) {
            return Some(rough);
        }
        let certain = |x: &Ball| x.abs_lower().copysign(x.mid_f64());
        Some(self.parts(at, &self.values, shapes, certain))
    }

    /// Whether xᵀKx is a sum of squares of stretches: no stiffness of an element is negative, and no tension counts.
    fn adds_squares(&self, at: &[f64], values: &Values<f64>) -> bool {
        let elements = || self.assembly.families.iter().flat_map(|family| &family.potential);
        let mut holds = self.assembly.unstressed || elements().all(|element| element.curvature.is_empty());
        if holds {
            self.assembly.run(Part::Stiffness, at, values, |family, _, numbers, is_new| {
                let mut rest = if is_new { numbers } else { &[] };
                for element in &family.potential {
                    let (outer, _) = head(&mut rest, 2, element.slope.len() + element.curvature.len());
                    holds &= outer.get(1).is_none_or(|stiffness| *stiffness >= 0.0);
                }
            });
        }
        holds
    }

    /// The ratios, with `size` taken of the stiffnesses, tensions and derivatives of all elements.
    fn parts<S: Scalar>(
        &self,
        at: &[S],
        values: &Values<S>,
        shapes: &[Shape<'_>],
        size: impl Fn(&S) -> f64,
    ) -> Vec<f64> {
        let mut sums = vec![0.0; shapes.len()];
        self.assembly.run(Part::Stiffness, at, values, |family, instance, numbers, _| {
            let numbers: Vec<f64> = numbers.iter().map(&size).collect();
            let coordinates = family.terms.coordinates_of(instance);
            let mut rest = numbers.as_slice();
            for element in &family.potential {
                let (outer, slopes) = head(&mut rest, 2, element.slope.len());
                let (curvature, _) = head(&mut rest, element.curvature.len(), 0);
                for (shape, sum) in shapes.iter().zip(&mut sums) {
                    let x = |place: usize| {
                        let at = coordinates.get(place).map_or(usize::MAX, |at| *at as usize);
                        shape.vector.get(at).copied().unwrap_or(0.0)
                    };
                    let (mut stretch, mut slack) = (0.0, 0.0);
                    for ((place, _), slope) in element.slope.iter().zip(slopes) {
                        stretch += slope * x(*place);
                        slack += (slope * shape.error).abs();
                    }
                    let stretch = (stretch.abs() - slack).max(0.0);
                    let (mut bend, mut slack) = (0.0, 0.0);
                    for ((a, b, _), second) in element.curvature.iter().zip(curvature) {
                        let twice = if a == b { *second } else { 2.0 * second };
                        bend += twice * x(*a) * x(*b);
                        slack += (twice * shape.error).abs() * (x(*a).abs() + x(*b).abs());
                    }
                    let bend = (bend.abs() - slack).max(0.0);
                    let parts = outer[1].abs() * stretch * stretch + outer[0].abs() * bend;
                    // What is not defined in doubles is not judged.
                    if parts.is_finite() {
                        *sum += parts;
                    }
                }
            }
        });
        let ratio = |(sum, shape): (f64, &Shape<'_>)| sum / shape.square.abs();
        sums.into_iter().zip(shapes).map(ratio).collect()
    }
}
