//! How the linearization changes with a parameter.
//!
//! The tapes are run over numbers with a derivative ([`Dual`]). First the forces by the parameter, at rest
//! coordinates: they say how the equilibrium moves, K dq = -dF. Then the matrices by parameter and equilibrium
//! together.

use super::Linearized;
use super::assemble::{Values, assemble, evaluate_closed};
use super::equilibrium::Origin;
use super::parameters::{known_values, set_bodies};
use super::rolling::Rolling;
use super::velocity::{Numbers, sum};
use super::zero::{ZeroMode, zero_modes};
use crate::precision::{Ball, Dual, System};

/// Derivatives of the matrices by a parameter, dense, column by column, the motion of the equilibrium included.
/// They are those of [`Linearized::varied`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Slopes {
    /// dM.
    pub mass: Vec<Ball>,
    /// dG + dC; `None` where there is neither.
    pub velocity: Option<Vec<Ball>>,
    /// dK + dN.
    pub stiffness: Vec<Ball>,
    /// Whether dC is anything but 0.
    pub damps: bool,
    /// Whether dN is anything but 0.
    pub drags: bool,
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

impl WithMultipliers {
    fn new(order: usize, [mass, gyroscopic, damping, stiffness, circulatory]: Numbers<Ball>) -> Self {
        Self {
            order,
            mass: mass.unwrap_or_default(),
            velocity: sum(gyroscopic, damping),
            stiffness: sum(stiffness, circulatory).unwrap_or_default(),
        }
    }
}

impl Linearized {
    /// The matrices that [`Linearized::mass`] and the others are reduced from; the same as those without constraints.
    #[must_use]
    pub fn with_multipliers(&self) -> WithMultipliers {
        let at = &self.equilibrium.values;
        WithMultipliers::new(self.model.coordinates.len(), self.assembly.matrices(at, &self.values))
    }

    /// What [`Linearized::slopes`] has the derivatives of: the same, but under conditions on velocities the matrices of the
    /// coordinates that the others follow.
    #[must_use]
    pub fn varied(&self) -> WithMultipliers {
        match self.rolled_numbers() {
            Some((_, matrices)) => WithMultipliers::new(self.dimension(), matrices.clone()),
            None => self.with_multipliers(),
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
        if self.exponents.parameters.contains(&parameter) {
            return self.with_symbols_in_exponents()?.slopes(parameter);
        }
        let varied = |number: usize, value: Dual<Ball>| Dual {
            slope: if number == parameter { Ball::ONE } else { Ball::ZERO },
            ..value
        };
        let values = self.assembly.values_where(&self.model, (), varied).ok()?;
        let matrices = match self.rolling() {
            Some(rolling) => {
                let at = self.moving(&self.rolling_slope(rolling, parameter, &values)?);
                rolling.slopes(&self.model, &at, parameter)?
            }
            None => {
                let at = self.moving(&self.equilibrium_slope(parameter, &values)?);
                let slopes =
                    |matrix: Vec<Dual<Ball>>| -> Vec<Ball> { matrix.into_iter().map(|entry| entry.slope).collect() };
                self.assembly.matrices(&at, &values).map(|matrix| matrix.map(slopes))
            }
        };
        let [mass, gyroscopic, damping, stiffness, circulatory] = matrices;
        let acts = |matrix: &Option<Vec<Ball>>| matrix.iter().flatten().any(|entry| !entry.is_zero());
        let found = Slopes {
            damps: acts(&damping),
            drags: acts(&circulatory),
            mass: mass?,
            velocity: sum(gyroscopic, damping),
            stiffness: sum(stiffness, circulatory)?,
        };
        let finite = |matrix: &[Ball]| matrix.iter().all(Ball::is_finite);
        let all = finite(&found.mass) && finite(&found.stiffness);
        (all && found.velocity.as_deref().is_none_or(finite)).then_some(found)
    }

    /// The same with the symbols of parameters that have become numbers; `None` where units would have to be put in, too, and
    /// under conditions on velocities.
    fn with_symbols_in_exponents(&self) -> Option<Self> {
        if self.units.is_some() || self.rolling().is_some() {
            return None;
        }
        let mut own = self.clone();
        set_bodies(&mut own.model, &std::mem::take(&mut own.exponents).bodies);
        own.assembly = assemble(&mut own.model);
        own.values = own.assembly.values(&own.model, ()).ok()?;
        Some(own)
    }

    /// dq/dp at the equilibrium, enclosed; what is given moves as it is written.
    fn equilibrium_slope(&self, parameter: usize, values: &Values<Dual<Ball>>) -> Option<Vec<Ball>> {
        let (mut slope, free) = self.given_slopes(parameter)?;
        // Multipliers alone, beside coordinates that are given: all forces together tell them.
        let all: Vec<usize> = (0..slope.len()).collect();
        let rows = if self.equilibrium.multipliers_given { &all } else { &free };
        let mut force = self.force_slope(&slope, values)?;
        let moved = self.balanced(rows, &free, &force)?;
        for (i, moved) in free.iter().zip(&moved) {
            slope[*i] = *moved;
        }
        if free.len() == all.len() {
            return Some(slope);
        }
        if moved.iter().any(|moved| !moved.is_zero()) {
            force = self.force_slope(&slope, values)?;
        }
        if force.iter().all(Ball::contains_zero) {
            return Some(slope);
        }
        // What is given is an equilibrium at these values of the parameters only: it moves as the forces say.
        let resting = vec![Ball::ZERO; all.len()];
        let force = self.force_slope(&resting, values)?;
        self.balanced(&all, &all, &force)
    }

    /// dq/dp under conditions on velocities: what is given moves as it is written, and the rest does not, where nothing depends on it or
    /// no force would move it; `None` elsewhere, and where the forces do not keep their balance.
    fn rolling_slope(&self, rolling: &Rolling, parameter: usize, values: &Values<Dual<Ball>>) -> Option<Vec<Ball>> {
        let (mut slope, searched) = self.given_slopes(parameter)?;
        let order = slope.len();
        let mut force = self.force_slope(&slope, values)?;
        if force.iter().all(Ball::is_zero) {
            return Some(slope);
        }
        // Where no more forces begin to act than there are multipliers these alone move.
        let multipliers: Vec<usize> = (self.coordinates()..order).collect();
        let acting: Vec<usize> = (0..order).filter(|i| !force[*i].is_zero()).collect();
        if acting.len() == multipliers.len()
            && let Some(moved) = self.balanced(&acting, &multipliers, &force)
        {
            multipliers.into_iter().zip(moved).for_each(|(i, moved)| slope[i] = moved);
            return Some(slope);
        }
        let held = rolling.reaction_slopes(&self.model, &self.moving(&slope), parameter)?;
        force.iter_mut().zip(held).for_each(|(force, held)| *force = *force - held);
        let [.., stiffness, circulatory] = self.assembly.matrices(&self.equilibrium.values, &self.values);
        let moves = |i: &usize| {
            let both = [&stiffness, &circulatory].into_iter().flatten();
            both.flat_map(|matrix| &matrix[order * i..order * (i + 1)]).any(|entry| !entry.is_zero())
        };
        (!searched.iter().any(moves) && force.iter().all(Ball::contains_zero)).then_some(slope)
    }

    /// The equilibrium, moving like that.
    fn moving(&self, slope: &[Ball]) -> Vec<Dual<Ball>> {
        let both = self.equilibrium.values.iter().zip(slope);
        both.map(|(value, slope)| Dual { value: *value, slope: *slope }).collect()
    }

    /// The derivatives of the forces by the parameter, for coordinates that move like that.
    fn force_slope(&self, moving: &[Ball], values: &Values<Dual<Ball>>) -> Option<Vec<Ball>> {
        let force = self.assembly.gradient(&self.moving(moving), values).into_iter();
        let force: Vec<Ball> = force.map(|force| force.slope).collect();
        force.iter().all(Ball::is_finite).then_some(force)
    }

    /// The displacements x of some coordinates for which Kx is the opposite of the force, in some rows; `None` where there are none
    /// or that is not shown. Where zero modes leave them open they are those without a part along these, (x, g) with
    /// Kx + Zg = -force, Zᵀx = 0: for a symmetry z·∂V = 0 holds identically, so that g = 0.
    fn balanced(&self, rows: &[usize], free: &[usize], force: &[Ball]) -> Option<Vec<Ball>> {
        let n = free.len();
        if rows.iter().all(|i| force[*i].is_zero()) {
            return Some(vec![Ball::ZERO; n]);
        }
        if n == 0 {
            return Some(Vec::new());
        }
        let order = self.model.coordinates.len();
        let whole = self.with_multipliers().stiffness;
        let entry = |i: usize, j: usize| whole[i + order * j];
        if rows != free {
            // As many equations as forces: the normal equations have the same solution, if there is one.
            let dot = |a: &dyn Fn(usize) -> Ball, b: &dyn Fn(usize) -> Ball| {
                let terms = rows.iter().map(|i| a(*i) * b(*i));
                terms.fold(Ball::ZERO, |sum, term| sum + term)
            };
            let pairs = (0..n * n).map(|at| (free[at / n], free[at % n]));
            let entries = pairs.map(|(j, k)| dot(&|i| entry(i, j), &|i| entry(i, k)));
            let system = System::new(n, entries.collect())?;
            let right = free.iter().map(|j| dot(&|i| entry(i, *j), &|i| -force[i])).collect::<Vec<Ball>>();
            return system.solve(&right);
        }
        let entries = (0..n * n).map(|at| entry(free[at / n], free[at % n]));
        let mut right: Vec<Ball> = free.iter().map(|i| -force[*i]).collect();
        if let Some(system) = System::new(n, entries.collect()) {
            return system.solve(&right);
        }
        let zeros = zero_modes(self, true);
        // Motions of what is held are none.
        let held = |i: &usize| !free.contains(i);
        let stays = |mode: &ZeroMode| (0..order).filter(held).all(|i| mode.vector[i].is_zero());
        let zeros: Vec<ZeroMode> = zeros.into_iter().filter(stays).collect();
        if zeros.is_empty() {
            return None;
        }
        let size = n + zeros.len();
        let bordered = (0..size * size).map(|at| match (at / size, at % size) {
            (i, j) if i < n && j < n => entry(free[i], free[j]),
            (i, j) if i < n => zeros[j - n].vector[free[i]],
            (i, j) if j < n => zeros[i - n].vector[free[j]],
            _ => Ball::ZERO,
        });
        let system = System::new(size, bordered.collect())?;
        right.resize(size, Ball::ZERO);
        let mut found = system.solve(&right)?;
        let left = found.split_off(n);
        // A force that no motion balances: the equilibrium ceases to be.
        left.iter().all(Ball::contains_zero).then_some(found)
    }

    /// The derivatives of coordinates that are given, with 0 for the others; and which these are.
    fn given_slopes(&self, parameter: usize) -> Option<(Vec<Ball>, Vec<usize>)> {
        let mut slopes = vec![Ball::ZERO; self.model.coordinates.len()];
        let mut others = Vec::new();
        for (i, own) in slopes.iter_mut().enumerate() {
            match (self.equilibrium.origins[i], self.model.equilibria.get(i)) {
                (Origin::Given, Some(given)) => {
                    let mut pool = self.model.pool.clone();
                    let slope = pool.diff(given.symbolic, self.model.parameters[parameter].symbol);
                    let slope = pool.substitute_one(slope, &known_values(&self.model));
                    *own = evaluate_closed(&pool, slope, ())?;
                }
                _ => others.push(i),
            }
        }
        Some((slopes, others))
    }
}
