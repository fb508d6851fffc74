//! How well the numbers of a model determine a frequency.
//!
//! Near a bifurcation ω² is the small difference of large terms, and a small change of a parameter is a
//! large one of ω². Two questions are answered, the second only where the first gives reason to ask:
//! how large the terms of xᵀKx are beside their sum, from the elements in doubles; and which parameter
//! matters most, from the first-order change of ω², the motion of the equilibrium included. Nothing here
//! is a bound; a leading digit is all that is asked for.

use super::Linearized;
use super::assemble::{Part, Values, head};
use super::constrained::solve;
use super::equilibrium::Origin;
use super::existence::Proof;
use super::parameters::{Formulas, parameters_of};
use crate::precision::{Ball, Big, Scalar, quadratic_form};

/// A parameter is changed by this power of 1/2 ...
const SHIFT: i64 = 120;

/// ... in numbers of so many bits: what changes is known to better than any double.
const BITS: usize = 384;

/// Products of so many entries of matrices are not worth a warning.
const MOST_WORK: usize = 2_000_000;

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
        let rough = self.parts(&middles, &values, shapes, |x| *x);
        if rough.iter().all(|ratio| *ratio < limit) {
            return Some(rough);
        }
        let certain = |x: &Ball| x.abs_lower().copysign(x.mid_f64());
        Some(self.parts(at, &self.values, shapes, certain))
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

    /// The parameter that ω² depends on most, and |p/ω² dω²/dp|: dω² = xᵀ(dK - ω² dM)x for xᵀMx = 1, with M
    /// and K at the equilibrium of the changed parameter. `None` where that can't be told or is too much work.
    pub(crate) fn most_sensitive(&self, shape: &[f64]) -> Option<(usize, f64)> {
        let model = &self.model;
        let mut roots: Vec<_> = self.assembly.families.iter().map(|f| f.effective).collect();
        roots.extend(self.assembly.families.iter().flat_map(|family| {
            let inertia = family.inertia.iter().flat_map(|element| element.entries());
            inertia.chain(family.terms.constants.iter().copied())
        }));
        let given = model.equilibria.given().map(|given| given.symbolic);
        roots.extend(given);
        let parameters = parameters_of(model, &roots);
        let size = shape.len() * shape.len() + self.assembly.families.len();
        if size * parameters.len() > MOST_WORK {
            return None;
        }
        let proof = self.equilibrium.proof.as_deref();
        let searched = self.equilibrium.origins.contains(&Origin::Found);
        if searched && !self.equilibrium.proved {
            return None;
        }
        let bits = BITS.max(proof.map_or(0, |proof| proof.bits + 128));
        let vector: Vec<Big> = shape.iter().map(|x| Big::from_f64(*x, bits)).collect();
        let quotient = |changed: Option<usize>| self.quotient(changed, &vector, proof, bits);
        let before = quotient(None)?;
        let mut worst: Option<(usize, f64)> = None;
        for parameter in parameters {
            let change = &(&quotient(Some(parameter))? - &before) / &before;
            let rate = change.scale(SHIFT).mid_f64().abs();
            if rate > worst.map_or(0.0, |(_, rate)| rate) {
                worst = Some((parameter, rate));
            }
        }
        worst
    }

    /// xᵀKx/xᵀMx at the equilibrium, with a parameter made a little larger.
    fn quotient(&self, changed: Option<usize>, vector: &[Big], proof: Option<&Proof>, bits: usize) -> Option<Big> {
        let larger = |number: usize, value: Big| {
            if changed == Some(number) { &value + &value.scale(-SHIFT) } else { value }
        };
        let model = &self.model;
        let values = self.assembly.values_where(model, bits, larger).ok()?;
        let mut at = Vec::with_capacity(vector.len());
        for (i, value) in self.equilibrium.values.iter().enumerate() {
            let origin = self.equilibrium.origins[i];
            let stated = match origin {
                Origin::Found if self.equilibrium.at_guess => model.guesses.get(i),
                Origin::Given | Origin::Found | Origin::Zero => model.equilibria.get(i),
            };
            at.push(match (origin, stated) {
                (Origin::Given | Origin::Found, Some(given)) => {
                    let formulas = Formulas::new(model, &model.pool, &[given.symbolic])?;
                    let found = formulas.at_where(model, &[], bits, |number, value| Some(larger(number, value?)))?;
                    found.into_iter().next()?
                }
                (Origin::Found, None) => Big::from_ball(value, bits).center(),
                (Origin::Given, None) | (Origin::Zero, _) => Big::zero(bits),
            });
        }
        match proof {
            Some(proof) => {
                at = proof.newton(at, bits, |at| self.assembly.gradient(at, &values))?.point;
            }
            None => self.follow(&mut at, &values)?,
        }
        let form = |matrix: &[Big]| quadratic_form(matrix, vector.len(), vector, bits).center();
        let stiffness = form(&self.assembly.stiffness(&at, &values));
        let ratio = &stiffness / &form(&self.assembly.mass(&at, &values));
        ratio.is_finite().then_some(ratio)
    }

    /// A step of Newton's from an equilibrium that was exact, for parameters that have changed; `None` where nothing holds it.
    fn follow(&self, at: &mut [Big], values: &Values<Big>) -> Option<()> {
        let found = |i: &usize| self.equilibrium.origins[*i] == Origin::Found;
        let free: Vec<usize> = (0..at.len()).filter(found).collect();
        let force = self.assembly.gradient(at, values);
        if free.iter().all(|i| force[*i].is_zero()) {
            return Some(());
        }
        let stiffness = self.assembly.stiffness(at, values);
        let equation = |i: &usize| {
            let row = free.iter().map(|j| stiffness[i + at.len() * j].clone());
            row.chain([-&force[*i]]).collect()
        };
        let steps = solve(free.iter().map(equation).collect(), values.precision())?;
        for (i, step) in free.iter().zip(&steps) {
            at[*i] = (&at[*i] + step).center();
        }
        Some(())
    }
}
