//! The equilibrium: given and verified, zero where the forces vanish there, or searched for.
//!
//! The search is a Newton iteration on the generalised forces, so that saddles and maxima count as
//! well as minima; it works in mass-weighted coordinates, in which forces on coordinates of
//! different units can be compared, and is damped so that the force falls at every step the way the
//! linear model foresees, which keeps it near its start. The forces themselves are evaluated in
//! double-double with bounds: a component whose enclosure holds zero is at rounding level and does not
//! move the point, which is how neutral directions (free bodies) stay where they are. Then a proof is
//! tried that an equilibrium is there ([`Setting`]), which also says how close: that is the radius of
//! the coordinates, which enters the stiffness matrix. Without a proof the radius is an estimate from
//! the last forces.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::assemble::{Assembly, Values};
use super::error::{LinearizeError, combination_words};
use super::existence::{Proof, Setting};
use super::newton::{Force, Spectrum};
use super::symbolic::force_text;
use super::symmetry::symmetries;
use super::undefined::{given_not_finite, point_text};
use super::zero::independent_symmetries;
use crate::model::Model;
use crate::precision::{Ball, DoubleDouble, Scalar};

/// Where a coordinate of the equilibrium comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Origin {
    /// The model gives it.
    Given,
    /// It is zero, and no force acts there.
    Zero,
    /// It was searched for.
    Found,
}

/// The point that is linearized about.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Equilibrium {
    /// The coordinates in SI, each with the radius that it is known to.
    pub values: Vec<Ball>,
    /// Per coordinate: where the value comes from.
    pub origins: Vec<Origin>,
    /// Newton steps of the search; 0 where nothing was searched for.
    pub steps: usize,
    /// Whether it is proved that an equilibrium lies within the radii of the coordinates that were
    /// searched for. True where nothing was searched for. Where it is false (the stiffness is
    /// singular or nearly so, for no symmetry that was found), the radii are an estimate, twice the
    /// last possible Newton step, and so is all that depends on them.
    ///
    /// Coordinates that are given are given: the forces on them are zero to within rounding.
    pub proved: bool,
    /// What was shown, unless the forces vanish exactly or nothing was.
    pub(crate) proof: Option<Arc<Proof>>,
}

/// Beside an eigenvalue this small, relative to the largest, a symmetry is looked for.
const NEARLY_SINGULAR: f64 = 1e-10;

/// More Newton steps than this find nothing either.
const MOST_STEPS: usize = 300;

/// What the search works with.
struct Search<'a> {
    model: &'a Model,
    assembly: &'a Assembly,
    values: &'a Values<Ball>,
    /// The coordinates that are searched for.
    free: Vec<usize>,
}

/// Finds or verifies the equilibrium.
pub(crate) fn find(
    model: &Model,
    assembly: &Assembly,
    values: &Values<Ball>,
) -> Result<Equilibrium, LinearizeError> {
    let count = model.coordinates.len();
    let closed = |given: &Option<crate::model::Given>| -> Result<Option<Ball>, LinearizeError> {
        let Some(given) = given else { return Ok(None) };
        let Some(value) = given.value else {
            let number = super::assemble::parameters_of(model, &[given.symbolic])
                .into_iter()
                .find(|number| model.parameters[*number].value.is_none());
            return Err(super::missing_value(model, number.unwrap_or(0)));
        };
        match super::assemble::evaluate_closed::<Ball>(&model.pool, value, ()) {
            Some(number) if !number.is_finite() => Err(given_not_finite(model, given)),
            number => Ok(number),
        }
    };
    let mut point = vec![Ball::ZERO; count];
    let mut origins = vec![Origin::Zero; count];
    let mut free = Vec::new();
    for i in 0..count {
        if let Some(value) = closed(&model.equilibria[i])? {
            point[i] = value;
            origins[i] = Origin::Given;
        } else {
            free.push(i);
        }
    }
    let guessed = model.guesses.iter().any(Option::is_some);
    let mut search = Search {
        model,
        assembly,
        values,
        free,
    };
    if !search.free.is_empty() {
        let force = search.gradient(&point);
        let vanishes = !guessed
            && search
                .free
                .iter()
                .all(|i| force[*i].contains_zero() && force[*i].is_finite());
        if !vanishes {
            for i in &search.free {
                origins[*i] = Origin::Found;
                if let Some(value) = closed(&model.guesses[*i])? {
                    point[*i] = Ball::exact(value.mid_f64());
                }
            }
            let (steps, proof) = search.run(&mut point)?;
            search.verify_given(&point)?;
            let proved = proof.is_some() || search.vanishes_exactly(&point);
            return Ok(Equilibrium {
                values: point,
                origins,
                steps,
                proved,
                proof: proof.map(Arc::new),
            });
        }
        search.free.clear();
    }
    search.verify_given(&point)?;
    Ok(Equilibrium {
        values: point,
        origins,
        steps: 0,
        proved: true,
        proof: None,
    })
}

impl Search<'_> {
    fn gradient(&self, at: &[Ball]) -> Vec<Ball> {
        self.assembly.gradient(at, self.values)
    }

    /// Whether the point is an equilibrium as it stands: exact numbers, and forces that are exactly 0.
    fn vanishes_exactly(&self, at: &[Ball]) -> bool {
        let force = self.gradient(at);
        self.free
            .iter()
            .all(|i| at[*i].is_exact() && force[*i].is_zero())
    }

    /// The point in words, for messages.
    fn describe(&self, at: &[Ball]) -> String {
        point_text(self.model, at)
    }

    fn not_finite(&self, at: &[Ball], what: &str) -> LinearizeError {
        let told = self.assembly.not_finite(self.model, at, self.values, what);
        told.unwrap_or_else(|| LinearizeError::NotFinite {
            what: what.to_owned(),
            point: self.describe(at),
            cause: None,
            span: self
                .model
                .kinetic
                .first()
                .map(|family| family.span)
                .unwrap_or_default(),
        })
    }

    /// Checks that no force acts where the equilibrium is given.
    fn verify_given(&self, at: &[Ball]) -> Result<(), LinearizeError> {
        let force = self.gradient(at);
        if !force.iter().all(Ball::is_finite) {
            return Err(self.not_finite(at, "the force"));
        }
        for (i, component) in force.iter().enumerate() {
            let place = match (&self.model.equilibria[i], self.free.contains(&i)) {
                (Some(given), false) => given.span,
                (None, false) => self.model.coordinates[i].span,
                (_, true) => continue,
            };
            if !component.contains_zero() {
                return Err(LinearizeError::NotAnEquilibrium {
                    coordinate: self.model.coordinates[i].name.clone(),
                    force: force_text(self.model, i, -component.mid_f64()),
                    span: place,
                });
            }
        }
        Ok(())
    }

    /// Searches from `at`; gives the number of steps, and a proof if there is one.
    fn run(&self, at: &mut [Ball]) -> Result<(usize, Option<Proof>), LinearizeError> {
        let metric = self.metric(at);
        let mut force = self.weighted(&self.gradient(at), &metric);
        if !force.finite {
            return Err(self.not_finite(at, "the force"));
        }
        let mut damping = 1.0_f64;
        let mut next = None;
        let mut last = None;
        let (mut way, mut length) = (0.0, f64::INFINITY);
        for step in 0..MOST_STEPS {
            if force.rounding {
                return Ok((step, self.settle(at, &metric)));
            }
            let Some(spectrum) = next.take().or_else(|| self.spectrum(at, &metric)) else {
                return Err(self.not_finite(at, "the stiffness"));
            };
            let newton = spectrum.newton(&force);
            let mut accepted = false;
            damping = (4.0 * damping).min(1.0);
            for attempt in 0..40 {
                let direction = &newton * damping;
                let trial = self.moved(at, &metric, &direction);
                let there = self.weighted(&self.gradient(&trial), &metric);
                let better =
                    there.finite && (there.norm < force.norm * (1.0 - 1e-4) || there.rounding);
                if better && spectrum.foresaw(&force, &there, damping, direction.norm()) {
                    let changed = self.spectrum(&trial, &metric);
                    let alike = changed
                        .as_ref()
                        .is_some_and(|changed| changed.resembles(&spectrum, &direction));
                    if alike || there.rounding {
                        at.clone_from_slice(&trial);
                        force = there;
                        next = changed;
                        length = direction.norm();
                        way += length;
                        accepted = true;
                        break;
                    }
                }
                // Near rounding level the force can't fall any more: a last tiny step is taken.
                let scale = way + self.weighted_size(at, &metric);
                let tiny = direction.norm() <= 1e-14 * scale
                    && there.finite
                    && !spectrum.pushes_neutral(&force);
                if tiny && there.norm <= force.norm * 2.0 && attempt == 0 {
                    at.clone_from_slice(&trial);
                    return Ok((step + 1, self.settle(at, &metric)));
                }
                damping *= 0.5;
            }
            if !accepted {
                last = Some(spectrum);
                if let Some(trial) = self.along_force(at, &metric, &force) {
                    force = self.weighted(&self.gradient(&trial), &metric);
                    at.clone_from_slice(&trial);
                    damping = 1.0;
                    continue;
                }
                break;
            }
            if at.iter().any(|x| x.mid_f64().abs() > 1e150) {
                break;
            }
            // Where the stiffness vanishes too, every step is a fixed part of the one before.
            if step + 1 == MOST_STEPS && length <= 1e-20 * way {
                return Ok((MOST_STEPS, self.settle(at, &metric)));
            }
        }
        let spectrum = last.or_else(|| self.spectrum(at, &metric));
        Err(self.failure(at, &metric, spectrum.as_ref()))
    }

    /// The square root of the mass matrix of the free coordinates, as a Cholesky factor; the unit
    /// matrix where it has none.
    fn metric(&self, at: &[Ball]) -> DMatrix<f64> {
        let n = self.model.coordinates.len();
        let m = self.free.len();
        let mass = self.assembly.mass(at, self.values);
        let own = DMatrix::from_fn(m, m, |i, j| mass[self.free[i] + n * self.free[j]].mid_f64());
        match nalgebra::Cholesky::new(own) {
            Some(factor) if factor.l().iter().all(|x| x.is_finite()) => factor.l(),
            Some(_) | None => DMatrix::identity(m, m),
        }
    }

    /// L⁻¹F: the force in mass-weighted coordinates, and whether it is nothing but rounding.
    fn weighted(&self, gradient: &[Ball], metric: &DMatrix<f64>) -> Force {
        let own: Vec<&Ball> = self.free.iter().map(|i| &gradient[*i]).collect();
        let raw = DVector::from_iterator(own.len(), own.iter().map(|g| g.mid_f64()));
        let noise = DVector::from_iterator(own.len(), own.iter().map(|g| g.radius));
        let finite = own.iter().all(|g| g.is_finite());
        let rounding = own.iter().all(|g| g.is_finite() && g.contains_zero());
        let vector = metric.solve_lower_triangular(&raw).unwrap_or(raw);
        let noise = metric.abs().solve_lower_triangular(&noise).unwrap_or(noise);
        Force {
            norm: vector.norm(),
            noise: noise.amax(),
            vector,
            finite,
            rounding,
        }
    }

    /// How far the free coordinates are from 0, in mass-weighted coordinates.
    fn weighted_size(&self, at: &[Ball], metric: &DMatrix<f64>) -> f64 {
        let own = self.free.iter().map(|i| at[*i].mid_f64());
        metric
            .tr_mul(&DVector::from_iterator(self.free.len(), own))
            .norm()
    }

    fn spectrum(&self, at: &[Ball], metric: &DMatrix<f64>) -> Option<Spectrum> {
        let n = self.model.coordinates.len();
        let m = self.free.len();
        let stiffness = self.assembly.stiffness(at, self.values);
        let own = DMatrix::from_fn(m, m, |i, j| {
            stiffness[self.free[i] + n * self.free[j]].mid_f64()
        });
        if !own.iter().all(|x| x.is_finite()) {
            return None;
        }
        let half = metric.solve_lower_triangular(&own)?;
        let both = metric.solve_lower_triangular(&half.transpose())?;
        let symmetric = (&both + both.transpose()) * 0.5;
        Some(Spectrum {
            eigen: SymmetricEigen::new(symmetric),
        })
    }

    /// The point moved by a step in mass-weighted coordinates.
    fn moved(&self, at: &[Ball], metric: &DMatrix<f64>, step: &DVector<f64>) -> Vec<Ball> {
        let step = metric
            .transpose()
            .solve_upper_triangular(step)
            .unwrap_or_else(|| step.clone());
        let mut moved = at.to_vec();
        for (k, i) in self.free.iter().enumerate() {
            // The new point is an exact number: what it is off by is asked of the force.
            let sum = at[*i].mid + DoubleDouble::from(step[k]);
            moved[*i] = Ball::new(sum, 0.0);
        }
        moved
    }

    /// Where Newton has no way on: steps along the force, both ways, from short to long.
    fn along_force(&self, at: &[Ball], metric: &DMatrix<f64>, force: &Force) -> Option<Vec<Ball>> {
        let unit = &force.vector / force.norm;
        (-12..=12).find_map(|power| {
            let length = 2.0_f64.powi(2 * power - 4);
            [-length, length].into_iter().find_map(|length| {
                let trial = self.moved(at, metric, &(&unit * length));
                let there = self.weighted(&self.gradient(&trial), metric);
                (there.finite && there.norm < 0.9 * force.norm).then_some(trial)
            })
        })
    }

    /// Newton steps with double-double forces down to rounding level, then a proof of what is left;
    /// without one, the estimate: twice the last possible step, the noise of the force included.
    fn settle(&self, at: &mut [Ball], metric: &DMatrix<f64>) -> Option<Proof> {
        let spectrum = self.spectrum(at, metric)?;
        let mut best = f64::INFINITY;
        for _ in 0..8 {
            let gradient = self.gradient(at);
            let force = self.weighted(&gradient, metric);
            if !force.finite || force.norm >= best || force.norm == 0.0 {
                break;
            }
            best = force.norm;
            let trial = self.moved(at, metric, &spectrum.newton(&force));
            let there = self.weighted(&self.gradient(&trial), metric);
            if there.finite && there.norm <= force.norm {
                at.clone_from_slice(&trial);
            } else {
                break;
            }
        }
        if let Some((proof, radii)) = self.proof(at, metric, &spectrum) {
            for (i, radius) in self.free.iter().zip(radii) {
                at[*i] = at[*i].with_added_radius(radius);
            }
            return Some(proof);
        }
        let force = self.weighted(&self.gradient(at), metric);
        let left = spectrum.reach(&force);
        let back = metric
            .transpose()
            .try_inverse()
            .unwrap_or_else(|| DMatrix::identity(left.len(), left.len()));
        let vectors = back * &spectrum.eigen.eigenvectors;
        for (k, i) in self.free.iter().enumerate() {
            let radius: f64 = (0..left.len())
                .map(|mode| vectors[(k, mode)].abs() * left[mode])
                .sum();
            at[*i] = at[*i].with_added_radius(2.0 * radius);
        }
        None
    }

    /// Tries to prove an equilibrium beside `at`. Symmetries are looked for only where the stiffness
    /// may be singular.
    fn proof(
        &self,
        at: &[Ball],
        metric: &DMatrix<f64>,
        spectrum: &Spectrum,
    ) -> Option<(Proof, Vec<f64>)> {
        let eigen = &spectrum.eigen;
        let axes = metric
            .transpose()
            .solve_upper_triangular(&eigen.eigenvectors)?;
        let softest = eigen.eigenvalues.iter().map(|x| x.abs());
        let softest = softest.fold(f64::INFINITY, f64::min);
        let symmetries = if softest > NEARLY_SINGULAR * eigen.eigenvalues.amax() {
            Vec::new()
        } else {
            let mut allowed = vec![false; at.len()];
            for i in &self.free {
                allowed[*i] = true;
            }
            independent_symmetries(symmetries(self.model, self.assembly, &allowed), at)
        };
        let setting = Setting {
            assembly: self.assembly,
            values: self.values,
            free: &self.free,
        };
        setting.prove(at, &axes, eigen.eigenvalues.as_slice(), &symmetries)
    }

    /// Why the search failed: forces that vanish nowhere, or simply no way on.
    fn failure(
        &self,
        at: &[Ball],
        metric: &DMatrix<f64>,
        spectrum: Option<&Spectrum>,
    ) -> LinearizeError {
        let gradient = self.gradient(at);
        let mut forces = Vec::new();
        let mut span = None;
        for i in &self.free {
            if let Some(text) =
                super::symbolic::constant_force(self.model, *i, -gradient[*i].mid_f64())
            {
                span = span.or(Some(self.model.coordinates[*i].span));
                forces.push((format!("`{}`", self.model.coordinates[*i].name), text));
            }
        }
        // A combination that nothing holds although a force acts along it.
        if forces.is_empty()
            && let Some(spectrum) = spectrum
        {
            let force = self.weighted(&gradient, metric);
            let largest = spectrum.eigen.eigenvalues.amax();
            for (mode, value) in spectrum.eigen.eigenvalues.iter().enumerate() {
                let vector = spectrum.eigen.eigenvectors.column(mode);
                let along = vector.dot(&force.vector);
                if value.abs() > 1e-12 * largest || along.abs() < 1e-6 * force.norm {
                    continue;
                }
                let Some(motion) = metric.transpose().solve_upper_triangular(&vector) else {
                    continue;
                };
                let scale = motion.amax();
                let combination: Vec<(String, f64)> = self
                    .free
                    .iter()
                    .zip(motion.iter())
                    .filter(|(_, x)| x.abs() > 1e-9 * scale)
                    .map(|(i, x)| (self.model.coordinates[*i].name.clone(), x / scale))
                    .collect();
                let total: f64 = -self
                    .free
                    .iter()
                    .zip(motion.iter())
                    .map(|(i, x)| gradient[*i].mid_f64() * x / scale)
                    .sum::<f64>();
                span = span.or_else(|| {
                    let first = self.free.iter().zip(motion.iter());
                    first
                        .filter(|(_, x)| x.abs() > 1e-9 * scale)
                        .map(|(i, _)| self.model.coordinates[*i].span)
                        .next()
                });
                forces.push((combination_words(&combination), short(total)));
            }
        }
        if let Some(span) = span {
            return LinearizeError::NoEquilibrium { forces, span };
        }
        let worst = self
            .free
            .iter()
            .copied()
            .max_by(|a, b| {
                let size = |i: &usize| gradient[*i].mid_f64().abs();
                size(a).total_cmp(&size(b))
            })
            .unwrap_or(0);
        LinearizeError::EquilibriumNotFound {
            coordinate: self.model.coordinates[worst].name.clone(),
            force: short(-gradient[worst].mid_f64()),
            point: self.describe(at),
            span: self.model.coordinates[worst].span,
        }
    }
}

/// A number in a message.
pub(crate) fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-3..1e6).contains(&size) {
        let text = format!("{value:.6}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text.is_empty() || text == "-0" {
            "0".to_owned()
        } else {
            text.to_owned()
        }
    } else {
        format!("{value:.5e}")
    }
}
