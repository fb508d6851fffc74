//! The equations of motion of a model, compiled: M(q, t) q'' + h(q, q', t) = 0, with forces along the gradients of
//! constraints.
//!
//! M and h are those of [`crate::mechanics`]. A constraint c = 0 that holds at all times has c'' = J q'' + gamma = 0 with J = dc/dq; together
//! with M q'' + h = Jᵀ mu that determines q'' (E. Hairer, G. Wanner, Solving Ordinary Differential Equations 2, section 7.1).

use super::error::MotionError;
use crate::flow::solved;
use crate::mechanics::{Mechanics, energy};
use crate::source;
use librate_core::derive::{Algebra, Motion, without_multipliers};
use librate_core::expr::{ExprId, Pool, Substitution, Symbol, Tape};
use librate_core::linearize::{independent_constraints, known_values, without_dependent};
use librate_core::model::{Model, SymbolKind};
use librate_core::precision::{Matrix, Scalar};

/// Terms beyond this are not written out.
const MOST_TERMS: usize = 200_000;
/// Equations of more parts than this are left as they are ...
const MOST_SHORTENED: usize = 400;
/// ... but for proofs, where each part that occurs twice costs bounds, too.
const MOST_SHORTENED_FOR_PROOFS: usize = 20_000;

/// The equations as tapes over the time, the coordinates and the velocities.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    pub(super) coordinates: usize,
    /// Those that M q'' + h = Jᵀ mu is of, one row and column of M each.
    pub(super) free: Vec<usize>,
    /// The others: their velocities are outputs behind gamma, from those of the free ones.
    pub(super) bound: Vec<usize>,
    pub(super) constraints: usize,
    /// Where the first outputs belong: the entries of M on and above its diagonal that are not 0.
    pub(super) mass: Vec<(usize, usize)>,
    /// Behind M and h, the entries of J that are not 0: constraint and coordinate. Then gamma follows.
    pub(super) gradients: Vec<(usize, usize)>,
    /// Whether M and J are the same everywhere.
    pub(super) constant: bool,
    /// M, h, J, gamma, velocities that follow, and what absolute values are taken of; in these |x| is s x, and the signs s are
    /// inputs behind the velocities.
    pub(super) tape: Tape,
    /// The velocities that follow.
    pub(super) speeds: Tape,
    /// What absolute values are taken of, at any place.
    pub(super) kinks: Tape,
    /// The momenta and the energy function, where there are kinks: with the same inputs as the first.
    pub(super) jumps: Tape,
    /// c, and c' in the velocities.
    pub(super) surface: Tape,
    /// The energy function, where it is conserved.
    pub(super) energy: Option<Tape>,
}

/// The equations in symbols, brought to their shortest form where they are small.
pub(super) struct Written<'a> {
    model: &'a Model,
    pool: Pool,
    time: Symbol,
    coordinates: Vec<Symbol>,
    velocities: Vec<Symbol>,
    free: Vec<usize>,
    bound: Vec<usize>,
    mass: Vec<(usize, usize)>,
    gradients: Vec<(usize, usize)>,
    constraints: usize,
    constant: bool,
    /// M, h, J, gamma, velocities that follow.
    outputs: Vec<ExprId>,
    /// What absolute values in these are taken of, where |x| is s x, and the signs s. Not for proofs.
    signs: Vec<(ExprId, Symbol)>,
    /// The momenta and the energy function in these signs, where there are any.
    jumps: Vec<ExprId>,
    surface: Vec<ExprId>,
    energy: Option<ExprId>,
}

impl<'a> Written<'a> {
    /// Writes the equations out, with the values of the parameters.
    ///
    /// # Errors
    /// Models with too many terms.
    pub(super) fn new(model: &'a Model, for_proofs: bool) -> Result<Self, MotionError> {
        let terms = Mechanics::terms(model);
        if terms > MOST_TERMS {
            return Err(MotionError::TooLarge { terms, most: MOST_TERMS });
        }
        let known = known_values(model);
        let conditions = &without_dependent(model).rolling;
        let mut mechanics = Mechanics::new(model, model.pool.clone(), &known);
        let lagrangian = mechanics.lagrangian;
        // What is differentiated, or brought to its shortest form, may divide by what is 0 at a kink: x + |x|/x is (x² + |x|)/x.
        let mut signs = if for_proofs { Vec::new() } else { mechanics.put_signs() };
        let equations = mechanics.equations();
        let mut jumps = Vec::new();
        if !signs.is_empty() {
            jumps.extend(equations.iter().map(|own| own.momentum));
            jumps.push(energy(&mut mechanics.pool, mechanics.lagrangian, &equations, &mechanics.velocities));
        }
        let (mut mass, mut inertia) = (Vec::new(), Vec::new());
        for (i, equation) in equations.iter().enumerate() {
            for (j, value) in equation.mass.iter().filter(|(j, _)| i <= *j) {
                mass.push((i, *j));
                inertia.push(*value);
            }
        }
        let loads = equations.iter().map(|equation| equation.load).collect();
        let constraints = mechanics.pool.substitute(&independent_constraints(model), &known);
        let (mut gradients, mut slopes) = (Vec::new(), Vec::new());
        let (mut bends, mut rates) = (Vec::new(), Vec::new());
        let holonomic = constraints.iter().map(|own| (*own, false));
        for (a, (own, rolls)) in holonomic.chain(conditions.iter().map(|own| (own.expression, true))).enumerate() {
            // A condition on velocities is kept as it is: c stands for nothing, and c' for the condition.
            let (own, rate) = if rolls {
                let rate = mechanics.pool.substitute_one(own, &known);
                (mechanics.velocity_slopes(rate), rate)
            } else {
                let slopes = mechanics.slopes(own);
                let rate = mechanics.rate(own, &slopes);
                (slopes, rate)
            };
            rates.push(rate);
            gradients.extend(own.iter().map(|(i, _)| (a, *i)));
            slopes.extend(own.iter().map(|(_, slope)| *slope));
            let own = mechanics.slopes(rate);
            bends.push(mechanics.rate(rate, &own));
        }
        let count = rates.len();
        let nothing = vec![mechanics.pool.zero(); conditions.len()];
        let surface = [constraints, nothing, rates].concat();
        let Mechanics { mut pool, coordinates, velocities, time, .. } = mechanics;
        let constant = !moves(model, &pool, time, &signs, &[&inertia[..], &slopes].concat());
        let mut outputs: Vec<ExprId> = [inertia, loads, slopes, bends].concat();
        let inputs = inputs(time, &coordinates, &velocities);
        let mut put_signs = |pool: &mut Pool, outputs: &mut Vec<ExprId>| {
            let (smooth, more) = pool.with_signs(outputs, |symbol| inputs.contains(&symbol));
            *outputs = smooth;
            signs.extend(more);
        };
        if for_proofs {
            shorten(&mut pool, &mut outputs, MOST_SHORTENED_FOR_PROOFS);
        } else {
            // Those of constraints, and then roots of sums that are squares.
            put_signs(&mut pool, &mut outputs);
            shorten(&mut pool, &mut outputs, MOST_SHORTENED);
            put_signs(&mut pool, &mut outputs);
        }
        // A condition with a part without velocities, as a moving belt, does work.
        let idle = conditions.iter().all(|own| model.at_rest(&mut pool, own.expression) == pool.zero());
        let conserved = model.forces.is_empty() && model.time_dependent.is_none() && idle;
        let energy = conserved.then(|| {
            let energy = energy(&mut pool, lagrangian, &equations, &velocities);
            let sizes = absolute_again(&mut pool, &signs).1;
            pool.substitute_one(energy, &sizes)
        });
        Ok(Self {
            model,
            pool,
            time,
            free: (0..coordinates.len()).collect(),
            bound: Vec::new(),
            coordinates,
            velocities,
            mass,
            gradients,
            constraints: count,
            constant,
            outputs,
            signs,
            jumps,
            surface,
            energy,
        })
    }

    /// The equations in independent velocities, where conditions on velocities are solved for the others everywhere: not beside
    /// absolute values, at the kinks of which such forms may divide by 0.
    fn independent(model: &'a Model) -> Option<Self> {
        let (mut pool, found) = without_multipliers(model)?;
        let coordinates: Vec<Symbol> = model.coordinates.iter().map(|own| own.symbol).collect();
        let velocities: Vec<Symbol> = model.coordinates.iter().map(|own| own.velocity).collect();
        let time = model.time().unwrap_or_else(|| pool.fresh_symbol("t"));
        let zero = pool.zero();
        let (mut mass, mut inertia) = (Vec::new(), Vec::new());
        for (i, equation) in found.equations.iter().enumerate() {
            for (j, own) in found.free.iter().enumerate().skip(i) {
                let entry = equation.coefficient(&mut pool, Motion::Acceleration(*own));
                if entry != zero {
                    mass.push((i, j));
                    inertia.push(entry);
                }
            }
        }
        let mut outputs = inertia;
        let follows = found.follows.iter().map(|(_, speed)| speed);
        let sums = found.equations.iter().chain(follows);
        outputs.extend(sums.map(|sum| sum.at_constant_rates(&mut pool, &velocities)));
        outputs = pool.substitute(&outputs, &known_values(model));
        shorten(&mut pool, &mut outputs, MOST_SHORTENED);
        let inputs = inputs(time, &coordinates, &velocities);
        if !pool.with_signs(&outputs, |symbol| inputs.contains(&symbol)).1.is_empty() {
            return None;
        }
        Some(Self {
            constant: !moves(model, &pool, time, &[], &outputs[..mass.len()]),
            model,
            pool,
            time,
            coordinates,
            velocities,
            free: found.free,
            bound: found.follows.into_iter().map(|(i, _)| i).collect(),
            mass,
            gradients: Vec::new(),
            constraints: 0,
            outputs,
            signs: Vec::new(),
            jumps: Vec::new(),
            surface: Vec::new(),
            energy: None,
        })
    }

    /// The time, the coordinates and the velocities.
    fn inputs(&self) -> Vec<Symbol> {
        inputs(self.time, &self.coordinates, &self.velocities)
    }

    fn compile(&self, roots: &[ExprId], inputs: &[Symbol]) -> Result<Tape, MotionError> {
        Tape::compile(&self.pool, roots, inputs).map_err(|unbound| source::missing(self.model, &unbound).into())
    }

    /// (q, q')' = (q', q''), with M q'' = -h, or M q'' - Jᵀ mu = -h and J q'' = -gamma.
    ///
    /// The matrix is eliminated without exchanges: M is positive, and so is the complement J M⁻¹ Jᵀ that is left of the rest.
    ///
    /// # Errors
    /// Parameters without a value, and an M that has no inverse anywhere.
    pub(super) fn explicit(mut self) -> Result<crate::flow::Equations, MotionError> {
        let (n, c) = (self.coordinates.len(), self.constraints);
        let zero = self.pool.zero();
        let mut matrix = vec![vec![zero; n + c]; n + c];
        let outputs = std::mem::take(&mut self.outputs);
        let (mass, rest) = outputs.split_at(self.mass.len());
        for ((i, j), entry) in self.mass.iter().zip(mass) {
            matrix[*i][*j] = *entry;
            matrix[*j][*i] = *entry;
        }
        let (loads, rest) = rest.split_at(n);
        let (slopes, bends) = rest.split_at(self.gradients.len());
        for ((a, i), slope) in self.gradients.iter().zip(slopes) {
            matrix[n + a][*i] = *slope;
            matrix[*i][n + a] = self.pool.neg(*slope);
        }
        let right = loads.iter().chain(bends).map(|e| vec![self.pool.neg(*e)]).collect();
        let solution = solved(&mut self.pool, matrix, right)
            .ok_or(MotionError::NotProved { reached: "0".to_owned(), reason: NO_INVERSE })?;
        let state: Vec<Symbol> = self.inputs().split_off(1);
        let mut rates: Vec<ExprId> = self.velocities.iter().map(|own| self.pool.symbol_expr(*own)).collect();
        rates.extend(solution.into_iter().take(n).flatten());
        let time = self.time;
        crate::flow::Equations::compile(&mut self.pool, time, &state, &[], &rates)
            .map_err(|unbound| source::missing(self.model, &unbound).into())
    }

    fn compiled(mut self) -> Result<Equations, MotionError> {
        let inputs = self.inputs();
        let (kinks, own): (Vec<ExprId>, Vec<Symbol>) = self.signs.iter().copied().unzip();
        let smooth = [self.outputs.as_slice(), &kinks].concat();
        let with_signs = [inputs.as_slice(), &own].concat();
        let kinks = absolute_again(&mut self.pool, &self.signs).0;
        let speeds = &self.outputs[self.outputs.len() - self.bound.len()..];
        Ok(Equations {
            coordinates: self.coordinates.len(),
            speeds: self.compile(speeds, &inputs)?,
            constraints: self.constraints,
            tape: self.compile(&smooth, &with_signs)?,
            kinks: self.compile(&kinks, &inputs)?,
            jumps: self.compile(&self.jumps, &with_signs)?,
            surface: self.compile(&self.surface, &inputs)?,
            energy: self.energy.map(|energy| self.compile(&[energy], &inputs)).transpose()?,
            free: self.free,
            bound: self.bound,
            mass: self.mass,
            gradients: self.gradients,
            constant: self.constant,
        })
    }
}

/// Said of a mass matrix.
pub(super) const NO_INVERSE: &str = "the mass matrix, with the constraints, has no inverse there";

impl Equations {
    /// Compiles the equations of a model.
    ///
    /// # Errors
    /// Parameters without a value, and models with too many terms.
    pub(super) fn new(model: &Model) -> Result<Self, MotionError> {
        Written::new(model, false)?.compiled()
    }

    /// M with -Jᵀ beside it and J below, from the values of their entries.
    pub(super) fn bordered<S: Scalar>(
        &self,
        zero: S,
        mass: impl Fn(usize) -> S,
        slope: impl Fn(usize) -> S,
    ) -> Matrix<S> {
        let (n, order) = (self.free.len(), self.free.len() + self.constraints);
        let mut matrix = Matrix::from_fn(order, order, |_, _| zero.clone());
        for (at, (i, j)) in self.mass.iter().enumerate() {
            matrix[(*i, *j)] = mass(at);
            matrix[(*j, *i)] = mass(at);
        }
        for (at, (a, i)) in self.gradients.iter().enumerate() {
            matrix[(*i, n + a)] = slope(at).neg();
            matrix[(n + a, *i)] = slope(at);
        }
        matrix
    }

    /// See [`Written::independent`].
    pub(super) fn independent(model: &Model) -> Option<Self> {
        Written::independent(model)?.compiled().ok()
    }
}

/// The time, the coordinates and the velocities.
fn inputs(time: Symbol, coordinates: &[Symbol], velocities: &[Symbol]) -> Vec<Symbol> {
    [&[time], coordinates, velocities].concat()
}

/// What signs are of, in expressions that [`Pool::with_signs`] gave, and what they stand for: |x|/x for each, in order, as x may
/// hold signs that stand before its own.
fn absolute_again(pool: &mut Pool, signs: &[(ExprId, Symbol)]) -> (Vec<ExprId>, Substitution) {
    let mut known = Substitution::default();
    let mut values = Vec::with_capacity(signs.len());
    for (x, sign) in signs {
        let x = pool.substitute_one(*x, &known);
        let size = pool.abs(x);
        let own = pool.div(size, x);
        known.insert(*sign, own);
        values.push(x);
    }
    (values, known)
}

/// Brings small equations to their shortest form: what is left of cos a cos b + sin a sin b is computed in every order
/// of every step. Many coordinates have short equations as they stand, or none that could be found in time.
fn shorten(pool: &mut Pool, equations: &mut Vec<ExprId>, most: usize) {
    let before = pool.reachable(equations).len();
    if before > most {
        return;
    }
    let mut algebra = Algebra::new(pool);
    let shorter: Vec<ExprId> = equations.iter().map(|e| algebra.simplify(*e)).collect();
    if pool.reachable(&shorter).len() < before {
        *equations = shorter;
    }
}

/// Whether expressions change along a motion.
fn moves(model: &Model, pool: &Pool, time: Symbol, signs: &[(ExprId, Symbol)], all: &[ExprId]) -> bool {
    let moves = |kind| matches!(kind, SymbolKind::Coordinate(_) | SymbolKind::Velocity(_));
    let is_sign = |symbol| signs.iter().any(|(_, sign)| *sign == symbol);
    let mut symbols = pool.symbols_of(all).into_iter();
    symbols.any(|symbol| symbol == time || is_sign(symbol) || model.symbols.get(symbol).is_some_and(moves))
}
