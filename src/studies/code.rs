//! A model as functions of doubles, for code in other languages: M, C, G, K and N at the equilibrium, and M, forces, energy and
//! accelerations of a motion, each a list of operations ([`Program`]).
//!
//! M and h of M q'' + h = 0 are those of `mechanics`, with the parameters open. A model that contains the time has no equilibrium, but a motion. What stands in an exponent has its value, as
//! x^n is not defined at 0 for every n. Where the equilibrium has to be searched for, a step of Newton's method is a list of operations
//! as well. Nothing is evaluated here but the defaults and the point where that search begins.

use crate::mechanics::{Mechanics, energy, row};
use crate::program::Program;
use crate::source;
use librate_core::expr::{ExprId, Pool, Substitution, Symbol};
use librate_core::linearize::{self, Feature, LinearizeError, Linearized, SymbolicMatrices};
use librate_core::model::Model;
use librate_core::number::Number;
use librate_core::precision::clear_column;

/// Code for more coordinates would be too long.
const MOST_COORDINATES: usize = 200;

/// A model for other languages.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Code {
    /// The model's name.
    pub model: Option<String>,
    /// The names of the coordinates.
    pub coordinates: Vec<String>,
    /// Parameters that stand for themselves, with their values in SI.
    pub parameters: Vec<(String, Option<f64>)>,
    /// What is asked of it at the equilibrium; nothing for a model that contains the time.
    pub rest: Option<Rest>,
    /// M row by row, of the time, the coordinates, the velocities and the parameters, ...
    pub mass: Program,
    /// ... the forces -h of the same, ...
    pub forces: Program,
    /// ... the energy Σ q' dL/dq' - L, ...
    pub energy: Program,
    /// ... and M row by row, then h: M q'' + h = 0.
    pub motion: Program,
}

/// A model at its equilibrium.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Rest {
    /// The equilibrium, of the parameters and the coordinates that are searched for.
    pub equilibrium: Program,
    /// How these are found.
    pub search: Option<Search>,
    /// The matrices there, of the same: M, K, and those of C, G and N that are not 0 whatever the parameters are.
    pub matrices: Vec<Matrix>,
}

/// A matrix at the equilibrium.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Matrix {
    /// In words: `mass`.
    pub name: &'static str,
    /// As a letter: `M`.
    pub letter: &'static str,
    /// Row by row.
    pub entries: Program,
}

/// A search for an equilibrium.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Search {
    /// The coordinates that are searched for, by number.
    pub free: Vec<usize>,
    /// Where they are for the default parameters.
    pub start: Vec<f64>,
    /// Forces on these, then their derivatives by them, row by row; of the parameters and these coordinates.
    pub step: Program,
}

/// Parameters in exponents, by their values.
fn exponents(model: &Model) -> Substitution {
    let inside = model.pool.symbols_of(&linearize::exponents_in(model, &linearize::bodies(model)));
    let own = model.parameters.iter().filter(|own| inside.contains(&own.symbol));
    own.filter_map(|own| Some((own.symbol, own.value?))).collect()
}

/// One coordinate for each zero mode among those that are free: with these held, the others have an equilibrium by itself.
fn held(found: &Linearized, free: &[usize]) -> Vec<usize> {
    let modes = found.zero_modes();
    let mut rows: Vec<Vec<f64>> =
        modes.iter().map(|mode| free.iter().map(|at| mode.vector[*at].mid_f64()).collect()).collect();
    let mut held = Vec::new();
    for k in 0..rows.len() {
        let largest = (0..free.len()).max_by(|a, b| rows[k][*a].abs().total_cmp(&rows[k][*b].abs()));
        if let Some(pivot) = largest.filter(|at| rows[k][*at] != 0.0) {
            clear_column(&mut rows, k, pivot, ());
            held.push(free[pivot]);
        }
    }
    held
}

/// Compiles a model.
///
/// # Errors
/// As [`linearize::derive`]; constraints, coordinates without inertia, and more than 200 coordinates.
pub fn code(model: &Model) -> Result<Code, LinearizeError> {
    for (constraints, feature) in [(&model.constraints, Feature::Constraint), (&model.rolling, Feature::Rolling)] {
        if let Some(constraint) = constraints.first() {
            return Err(LinearizeError::Unsupported { feature, span: constraint.span });
        }
    }
    let n = model.coordinates.len();
    if n > MOST_COORDINATES {
        return Err(LinearizeError::TooLarge { coordinates: n, most: MOST_COORDINATES, in_code: true });
    }
    let matrices = match linearize::derive(model.clone()) {
        Err(LinearizeError::TimeDependent { .. }) => None,
        other => Some(other?),
    };
    // A row of M that vanishes is seen below, without values too.
    if let Ok(found) = linearize::linearize(model.clone()) {
        found.check_inertia()?;
    }
    let fixed = exponents(model);
    let open: Vec<usize> = (0..model.parameters.len())
        .filter(|at| {
            let own = &model.parameters[*at];
            model.pool.as_symbol(own.symbolic) == Some(own.symbol) && !fixed.contains_key(&own.symbol)
        })
        .collect();
    let pool = matrices.as_ref().map_or(&model.pool, |matrices| &matrices.pool).clone();
    let mut mechanics = Mechanics::new(model, pool, &fixed);
    let equations = mechanics.equations();
    let zero = mechanics.pool.zero();
    let mass: Vec<ExprId> = equations.iter().flat_map(|equation| row(&equation.mass, n, zero)).collect();
    let still = (0..n).find(|i| mass[n * i..n * (i + 1)].iter().all(|entry| *entry == zero));
    if let Some(coordinate) = still {
        let span = model.coordinates.at(coordinate).span;
        return Err(LinearizeError::Unsupported { feature: Feature::Massless, span });
    }
    let loads: Vec<ExprId> = equations.iter().map(|equation| equation.load).collect();
    let parameters: Vec<Symbol> = open.iter().map(|at| model.parameters[*at].symbol).collect();
    let rest = |own| at_rest(model, own, &mut mechanics, (&fixed, &parameters), &loads);
    let rest = matrices.as_ref().map(rest).transpose()?;

    let Mechanics { mut pool, coordinates, velocities, time, lagrangian, .. } = mechanics;
    let energy = energy(&mut pool, lagrangian, &equations, &velocities);
    let forces: Vec<ExprId> = loads.iter().map(|load| pool.neg(*load)).collect();
    let moving: Vec<Symbol> = [time].into_iter().chain(coordinates).chain(velocities).chain(parameters).collect();
    let value = |at: &usize| {
        let own = &model.parameters[*at];
        let value = own.value.and_then(|value| linearize::constant(&model.pool, value));
        if value.is_some_and(|value| !value.mid_f64().is_normal() && !value.is_zero()) {
            let (what, point) = ("the code in doubles".to_owned(), "these parameters".to_owned());
            let cause = Some(format!("the value of `{}` is no number, or beyond the range of doubles", own.name));
            return Err(LinearizeError::NotFinite { what, point, cause, span: own.span });
        }
        Ok((own.name.clone(), value.map(|value| value.mid_f64())))
    };
    Ok(Code {
        model: model.name.clone(),
        coordinates: model.coordinates.names().collect(),
        parameters: open.iter().map(value).collect::<Result<_, _>>()?,
        rest,
        forces: compiled(model, &pool, &forces, &moving)?,
        energy: compiled(model, &pool, &[energy], &moving)?,
        mass: compiled(model, &pool, &mass, &moving)?,
        motion: compiled(model, &pool, &[mass, loads].concat(), &moving)?,
    })
}

fn compiled(model: &Model, pool: &Pool, roots: &[ExprId], inputs: &[Symbol]) -> Result<Program, LinearizeError> {
    Program::compile(pool, roots, inputs).map_err(|unbound| source::missing(model, &unbound))
}

/// The equilibrium and the matrices there, of the mass matrix and the loads of the motion.
fn at_rest(
    model: &Model,
    matrices: &SymbolicMatrices,
    mechanics: &mut Mechanics<'_>,
    (fixed, parameters): (&Substitution, &[Symbol]),
    loads: &[ExprId],
) -> Result<Rest, LinearizeError> {
    let n = model.coordinates.len();
    let zero = mechanics.pool.zero();
    let (coordinates, velocities) = (mechanics.coordinates.clone(), mechanics.velocities.clone());
    // Where coordinates are given, and at what rates they move.
    let mut point = mechanics.pool.substitute(&matrices.equilibrium, fixed);
    let is_open = |pool: &Pool, point: &[ExprId], at: usize| pool.as_symbol(point[at]) == Some(coordinates[at]);
    let mut free: Vec<usize> = (0..n).filter(|at| is_open(&mechanics.pool, &point, *at)).collect();
    let found = if free.is_empty() { None } else { Some(linearize::linearize(model.clone())?) };
    let values = found.as_ref().map_or(&[][..], |found| &found.equilibrium().values);
    // Where nothing holds a motion every place along it does: the one of the default parameters is kept.
    for at in found.iter().flat_map(|found| held(found, &free)) {
        point[at] = mechanics.pool.number(Number::from_f64_exact(values[at].mid_f64()).unwrap_or_default());
    }
    free.retain(|at| is_open(&mechanics.pool, &point, *at));
    let mut there = Substitution::default();
    for at in 0..n {
        there.insert(coordinates[at], point[at]);
        let rate = model.rates.get(at).map_or(zero, |rate| rate.symbolic);
        there.insert(velocities[at], rate);
    }
    // It drops out of the equations.
    there.insert(mechanics.time, zero);
    let searched: Vec<Symbol> = free.iter().map(|at| coordinates[*at]).collect();
    let inputs = [parameters, &searched].concat();

    let pool = &mut mechanics.pool;
    let search = if free.is_empty() {
        None
    } else {
        let roots: Vec<ExprId> = free.iter().map(|at| loads[*at]).collect();
        let mut roots = pool.substitute(&roots, &there);
        let slopes: Vec<ExprId> = roots.iter().flat_map(|root| pool.gradient(*root, &searched)).collect();
        roots.extend(slopes);
        let start = free.iter().map(|at| values[*at].mid_f64()).collect();
        Some(Search { start, step: compiled(model, pool, &roots, &inputs)?, free })
    };
    // What is defined from others, and what stands in exponents.
    there.extend(fixed.iter().map(|(symbol, value)| (*symbol, *value)));
    let all = [
        ("mass", "M", Some(&matrices.mass)),
        ("stiffness", "K", Some(&matrices.stiffness)),
        ("damping", "C", matrices.damping.as_ref()),
        ("gyroscopic", "G", matrices.gyroscopic.as_ref()),
        ("circulatory", "N", matrices.circulatory.as_ref()),
    ];
    let mut found = Vec::new();
    for (name, letter, rows) in all.into_iter().filter_map(|(name, letter, rows)| Some((name, letter, rows?))) {
        let entries = pool.substitute(&rows.concat(), &there);
        found.push(Matrix { name, letter, entries: compiled(model, pool, &entries, &inputs)? });
    }
    Ok(Rest { equilibrium: compiled(model, pool, &point, &inputs)?, search, matrices: found })
}
