//! How the linearization changes with a parameter.
//!
//! The tapes are run over numbers with a derivative ([`Dual`]). First the forces by the parameter, at rest
//! coordinates: they say how the equilibrium moves, K dq = -dF. Then the matrices by parameter and equilibrium
//! together.

use nalgebra::{DMatrix, DVector};

use super::Linearized;
use super::assemble::{Values, evaluate_closed, known_values};
use super::constrained::solve;
use super::equilibrium::Origin;
use super::velocity::{Matrix, sum};
use crate::precision::{Ball, DoubleDouble, Dual};

/// Derivatives of the matrices by a parameter, dense, column by column, the motion of the equilibrium included.
/// Under constraints the multipliers count as further coordinates, as in [`Linearized::with_multipliers`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Slopes {
    /// dM.
    pub mass: Vec<Ball>,
    /// dG + dC; `None` where there is neither.
    pub velocity: Option<Vec<Ball>>,
    /// dK + dN.
    pub stiffness: Vec<Ball>,
}

/// M, G + C and K + N of all coordinates and, behind them, the multipliers of constraints.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct WithMultipliers {
    /// The number of rows of each matrix.
    pub order: usize,
    /// M; 0 for multipliers.
    pub mass: Vec<Ball>,
    /// G + C.
    pub velocity: Option<Vec<Ball>>,
    /// K + N, and -∂c/∂q for multipliers.
    pub stiffness: Vec<Ball>,
}

impl Linearized {
    /// The matrices that [`Linearized::mass`] and the others are reduced from; the same as those without constraints.
    #[must_use]
    pub fn with_multipliers(&self) -> WithMultipliers {
        let at = &self.equilibrium.values;
        let part = |matrix| self.assembly.velocity_matrix(matrix, at, &self.values);
        let stiffness = self.assembly.stiffness(at, &self.values);
        let stiffness = sum(Some(stiffness), part(Matrix::Circulatory)).unwrap_or_default();
        WithMultipliers {
            order: self.model.coordinates.len(),
            mass: self.assembly.mass(at, &self.values),
            velocity: sum(part(Matrix::Gyroscopic), part(Matrix::Damping)),
            stiffness,
        }
    }

    /// Whether a parameter (by number) can be varied: it has a value, is not defined from others, and sets no range.
    #[must_use]
    pub fn can_vary(&self, parameter: usize) -> bool {
        let model = self.model();
        model.parameters.get(parameter).is_some_and(|parameter| {
            let itself = model.pool.symbols_of(&[parameter.symbolic]);
            parameter.value.is_some() && itself.contains(&parameter.symbol)
        })
    }

    /// The derivatives of the matrices by a parameter. `None` where something is not differentiable there or the
    /// parameter can't be varied.
    #[must_use]
    pub fn slopes(&self, parameter: usize) -> Option<Slopes> {
        if !self.can_vary(parameter) {
            return None;
        }
        let varied = |number: usize, value: Dual<Ball>| Dual {
            slope: if number == parameter {
                Ball::ONE
            } else {
                Ball::ZERO
            },
            ..value
        };
        let values = self.assembly.values_where(&self.model, (), varied).ok()?;
        let moving = self.equilibrium_slope(parameter, &values)?;
        let at: Vec<Dual<Ball>> = self
            .equilibrium
            .values
            .iter()
            .zip(moving)
            .map(|(value, slope)| Dual {
                value: *value,
                slope,
            })
            .collect();
        let slopes = |matrix: Vec<Dual<Ball>>| -> Vec<Ball> {
            matrix.into_iter().map(|entry| entry.slope).collect()
        };
        let part = |matrix| {
            self.assembly
                .velocity_matrix(matrix, &at, &values)
                .map(slopes)
        };
        let stiffness = slopes(self.assembly.stiffness(&at, &values));
        let found = Slopes {
            mass: slopes(self.assembly.mass(&at, &values)),
            velocity: sum(part(Matrix::Gyroscopic), part(Matrix::Damping)),
            stiffness: sum(Some(stiffness), part(Matrix::Circulatory))?,
        };
        let finite = |matrix: &[Ball]| matrix.iter().all(Ball::is_finite);
        let all = finite(&found.mass) && finite(&found.stiffness);
        (all && found.velocity.as_deref().is_none_or(finite)).then_some(found)
    }

    /// dq/dp at the equilibrium.
    fn equilibrium_slope(
        &self,
        parameter: usize,
        values: &Values<Dual<Ball>>,
    ) -> Option<Vec<Ball>> {
        let order = self.model.coordinates.len();
        let mut slope = vec![Ball::ZERO; order];
        let mut free = Vec::new();
        for (i, slot) in slope.iter_mut().enumerate() {
            match (self.equilibrium.origins[i], self.model.equilibria[i]) {
                (Origin::Given, Some(given)) => {
                    *slot = self.given_slope(given.symbolic, parameter)?;
                }
                _ => free.push(i),
            }
        }
        let at: Vec<Dual<Ball>> = self
            .equilibrium
            .values
            .iter()
            .zip(&slope)
            .map(|(value, slope)| Dual {
                value: *value,
                slope: *slope,
            })
            .collect();
        let force: Vec<Ball> = self
            .assembly
            .gradient(&at, values)
            .into_iter()
            .map(|force| force.slope)
            .collect();
        if !force.iter().all(Ball::is_finite) {
            return None;
        }
        // Multipliers alone, beside coordinates that are given: all forces together tell them.
        let rows: Vec<usize> = if self.equilibrium.multipliers_given {
            (0..order).collect()
        } else {
            free.clone()
        };
        // Forces of nothing but rounding move nothing.
        if free.is_empty() || rows.iter().all(|i| force[*i].contains_zero()) {
            return Some(slope);
        }
        let whole = self.with_multipliers().stiffness;
        let entry = |i: usize, j: usize| whole[i + order * j];
        if rows.len() == free.len() {
            let equations = rows
                .iter()
                .map(|i| {
                    let mut row: Vec<Ball> = free.iter().map(|j| entry(*i, *j)).collect();
                    row.push(-force[*i]);
                    row
                })
                .collect();
            if let Some(found) = solve(equations, ()) {
                for (i, found) in free.iter().zip(found) {
                    slope[*i] = found;
                }
                return Some(slope);
            }
        }
        // Neutral directions stay where they are.
        let matrix = DMatrix::from_fn(rows.len(), free.len(), |i, j| {
            entry(rows[i], free[j]).mid_f64()
        });
        let right = DVector::from_fn(rows.len(), |i, _| -force[rows[i]].mid_f64());
        let scale = matrix.amax();
        let found = matrix
            .clone()
            .svd(true, true)
            .solve(&right, 1e-11 * scale)
            .ok()?;
        let left = (&matrix * &found - &right).amax();
        // A force that no motion balances: the equilibrium ceases to be.
        if left > 1e-6 * right.amax() {
            return None;
        }
        for (i, found) in free.iter().zip(found.iter()) {
            slope[*i] = Ball::from(DoubleDouble::from(*found));
        }
        Some(slope)
    }

    /// The derivative of a given coordinate.
    fn given_slope(&self, given: crate::expr::ExprId, parameter: usize) -> Option<Ball> {
        let mut pool = self.model.pool.clone();
        let slope = pool.diff(given, self.model.parameters[parameter].symbol);
        let slope = pool.substitute_one(slope, &known_values(&self.model));
        evaluate_closed::<Ball>(&pool, slope, ())
    }
}
