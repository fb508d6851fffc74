//! What vanishes at an equilibrium: forces and their derivatives, compiled; under constraints with multipliers.
//!
//! With constraints c = 0 the equations are (Fritz John) a F + Σ b_k ∇c_k = 0, c = 0 and a² + Σ b_k² = 1 with a >= 0: the multipliers
//! are bounded whatever the forces, and a = 0 only where the gradients of constraints depend on each other.

use librate_core::expr::{ExprId, ModularPoint, Pool, Prepared, Symbol, Tape, fraction_mod};
use librate_core::linearize::{AtRest, nullspace_mod};
use librate_core::number::Number;
use librate_core::precision::Scalar;

use super::poles::Poles;

/// Points at which a direction is searched for that no force acts along.
const POINTS_MORE: u64 = 4;

/// A system of as many equations as unknowns, in symbols.
#[derive(Clone)]
pub(super) struct Equations {
    pub(super) pool: Pool,
    /// Coordinates, then multipliers.
    pub(super) unknowns: Vec<Symbol>,
    /// The parameters that vary.
    pub(super) parameters: Vec<Symbol>,
    pub(super) all: Vec<ExprId>,
    /// Whether there are multipliers among the unknowns.
    pub(super) is_constrained: bool,
}

/// A system of as many equations as unknowns, compiled, with parameters as further inputs.
pub(super) struct Forces {
    /// How many unknowns there are.
    pub(super) unknowns: usize,
    /// The equations, then the potential, which has to have a value.
    force: Tape,
    /// The derivatives of the equations, row by row.
    slopes: Tape,
    /// Those by the parameters.
    drifts: Tape,
    pub(super) poles: Poles,
}

/// A constant direction along which nothing changes: a number for each coordinate.
pub(super) type Neutral = Vec<Number>;

/// The derivatives of the potential and what else acts, coordinate by coordinate.
pub(super) fn gradient(rest: &mut AtRest) -> Vec<ExprId> {
    let slopes = rest.pool.gradient(rest.potential, &rest.coordinates);
    slopes.iter().zip(&rest.others).map(|(slope, other)| rest.pool.add(*slope, *other)).collect()
}

/// The directions that no force acts along and no force changes along, whatever the point: independent ones, each 1 at a pivot
/// of its own at which the others are 0.
pub(super) fn neutral_directions(rest: &mut AtRest, forces: &[ExprId]) -> Vec<(usize, Neutral)> {
    let n = forces.len();
    let mut rows: Vec<Vec<u64>> = Vec::new();
    let functions: Vec<ExprId> = forces.iter().chain(&rest.constraints).copied().collect();
    let mut gradients: Vec<Vec<ExprId>> = vec![forces.to_vec()];
    gradients.extend(rest.constraints.iter().map(|own| rest.pool.gradient(*own, &rest.coordinates)));
    let gentle = rest.others.iter().all(|own| rest.pool.as_number(*own).is_some_and(Number::is_zero));
    if !gentle {
        gradients.extend(functions.iter().map(|own| rest.pool.gradient(*own, &rest.coordinates)));
    }
    for gradient in &gradients {
        for seed in 0..n as u64 + POINTS_MORE {
            let values = |symbol| ModularPoint::random_value(seed, symbol);
            rows.extend(rest.pool.evaluate_mod(gradient, values, seed));
        }
    }
    let kernel = nullspace_mod(&rows, n);
    let mut found: Vec<(usize, Neutral)> = Vec::new();
    for vector in kernel {
        let lifted: Option<Neutral> = vector.into_iter().map(fraction_mod).collect();
        let Some(mut vector) = lifted else { continue };
        let holds = gradients.iter().all(|gradient| {
            let terms: Vec<(ExprId, Number)> =
                gradient.iter().copied().zip(vector.iter().cloned()).filter(|(_, x)| !x.is_zero()).collect();
            let along = rest.pool.linear(&terms);
            rest.pool.vanishes(along)
        });
        if !holds {
            continue;
        }
        for (pivot, other) in &found {
            let by = vector[*pivot].clone();
            vector.iter_mut().zip(other).for_each(|(x, y)| *x = x.sub(&by.mul(y)));
        }
        let Some(pivot) = vector.iter().position(|x| !x.is_zero()) else { continue };
        let Some(scale) = vector[pivot].recip() else { continue };
        vector.iter_mut().for_each(|x| *x = x.mul(&scale));
        for (_, other) in &mut found {
            let by = other[pivot].clone();
            other.iter_mut().zip(&vector).for_each(|(x, y)| *x = x.sub(&by.mul(y)));
        }
        found.push((pivot, vector));
    }
    found
}

impl Equations {
    /// The system of a model at rest. `scale` brings forces to about the size of the gradients of constraints.
    pub(super) fn new(rest: &AtRest, scale: &Number) -> Self {
        let mut rest = rest.clone();
        let mut equations = gradient(&mut rest);
        let AtRest { mut pool, coordinates, parameters, constraints, .. } = rest;
        let mut multipliers = Vec::new();
        if !constraints.is_empty() {
            let names = (0..=constraints.len()).map(|at| format!("multiplier {at}"));
            multipliers = names.map(|name| pool.fresh_symbol(&name)).collect::<Vec<Symbol>>();
            let all: Vec<ExprId> = multipliers.iter().map(|own| pool.symbol_expr(*own)).collect();
            for force in &mut equations {
                let own = pool.scale(*force, scale);
                *force = pool.mul(all[0], own);
            }
            for (constraint, multiplier) in constraints.iter().zip(&all[1..]) {
                for (force, slope) in equations.iter_mut().zip(pool.gradient(*constraint, &coordinates)) {
                    let part = pool.mul(*multiplier, slope);
                    *force = pool.add(*force, part);
                }
            }
            equations.extend(&constraints);
            let mut squares: Vec<ExprId> = all.iter().map(|own| pool.square(*own)).collect();
            squares.push(pool.integer(-1));
            equations.push(pool.sum(&squares));
        }
        let is_constrained = !constraints.is_empty();
        let unknowns = coordinates.iter().copied().chain(multipliers).collect();
        Self { pool, unknowns, parameters, all: equations, is_constrained }
    }

    /// Compiles them, with what has to have a value, and what there are poles of.
    fn compiled(&self, valued: ExprId, poles: impl FnOnce(&[Symbol]) -> Poles) -> Option<Forces> {
        let mut pool = self.pool.clone();
        let slopes: Vec<ExprId> = self.all.iter().flat_map(|own| pool.gradient(*own, &self.unknowns)).collect();
        let drifts: Vec<ExprId> = self.all.iter().flat_map(|own| pool.gradient(*own, &self.parameters)).collect();
        let inputs: Vec<Symbol> = self.unknowns.iter().chain(&self.parameters).copied().collect();
        let outputs: Vec<ExprId> = self.all.iter().copied().chain([valued]).collect();
        let force = Tape::compile(&pool, &outputs, &inputs).ok()?;
        let slopes = Tape::compile(&pool, &slopes, &inputs).ok()?;
        let drifts = Tape::compile(&pool, &drifts, &inputs).ok()?;
        Some(Forces { unknowns: self.unknowns.len(), force, slopes, drifts, poles: poles(&inputs) })
    }

    /// Compiles them as they are.
    pub(super) fn plain(&self) -> Option<Forces> {
        let mut pool = self.pool.clone();
        let zero = pool.zero();
        self.compiled(zero, |inputs| Poles::new(&mut pool, zero, &[], &[], inputs))
    }
}

impl Forces {
    /// The equations of a model at rest, compiled.
    pub(super) fn new(equations: &Equations, rest: &AtRest) -> Option<Self> {
        let mut pool = equations.pool.clone();
        // Under constraints forces are not all that vanishes.
        let free = if rest.constraints.is_empty() { rest.coordinates.as_slice() } else { &[] };
        equations.compiled(rest.potential, |inputs| Poles::new(&mut pool, rest.potential, &rest.others, free, inputs))
    }

    /// For many evaluations in one type of numbers.
    pub(super) fn prepare<S: Scalar<Precision = ()>>(&self) -> Evaluator<S> {
        let [force, slopes, drifts] = [&self.force, &self.slopes, &self.drifts].map(|tape| tape.prepare(()));
        Evaluator { force, slopes, drifts, scratch: Vec::new() }
    }

    pub(super) fn operations(&self) -> usize {
        self.force.len() + self.slopes.len()
    }
}

/// Forces in one type of numbers.
pub(super) struct Evaluator<S: Scalar> {
    pub(super) force: Prepared<S>,
    pub(super) slopes: Prepared<S>,
    pub(super) drifts: Prepared<S>,
    pub(super) scratch: Vec<S>,
}

impl<S: Scalar> Evaluator<S> {
    /// The equations, then the potential.
    pub(super) fn force(&mut self, at: &[S]) -> Vec<S> {
        self.force.evaluate(at, &mut self.scratch)
    }

    /// The derivatives of the equations by the unknowns, row by row.
    pub(super) fn slopes(&mut self, at: &[S]) -> Vec<S> {
        self.slopes.evaluate(at, &mut self.scratch)
    }

    /// The derivatives of the equations by the parameters, row by row.
    pub(super) fn drifts(&mut self, at: &[S]) -> Vec<S> {
        self.drifts.evaluate(at, &mut self.scratch)
    }
}
