//! Equations under conditions on velocities, without their multipliers: Rᵀ(M q'' + h) = 0 with q' = R u + r.
//!
//! The conditions are solved for as many velocities as there are of them; u are the others. Constraint forces Aᵀμ do no
//! work on what is allowed, RᵀAᵀ = 0, and drop out (Neimark and Fufaev, Dynamics of Nonholonomic Systems, chapter 3: Chaplygin's and
//! Voronets's equations, written out). All of it is done coefficient by coefficient, so that each comes in its shortest form.

use std::collections::{BTreeMap, BTreeSet};
use std::iter::repeat_n;

use super::check::Checker;
use super::constraints::{MOST_BY_DETERMINANTS, solved_for};
use super::equations::{self, Factors, single};
use super::lagrangian::{self, Lagrangian, Variables};
use super::motion::{Motion, MotionSum};
use super::shapes::determinant;
use super::simplify::{Algebra, bases_with};
use crate::expr::{ExprId, Pool, Substitution, Symbol};
use crate::linearize::{self, LinearizeError, Linearized};
use crate::model::{Given, Local, Model, TermFamily};
use crate::number::Number;
use crate::order::{Gather, Order};

/// Why no oscillations are found.
const NOWHERE: &str =
    "no equilibrium is found without their forces; where they carry a load, give every coordinate with `equilibrium`";
/// The same of a place that is given.
const LOADED: &str = "whether they bear the forces at the equilibrium that is given, beside constraints or each other, is not worked out";

/// Larger equations are not reduced.
const MOST_PARTS: usize = 3000;
/// Divisors are tried to this power: that of slopes, twice in M, and once more in their rates.
const MOST_POWER: i64 = 3;

/// Equations of motion in as many velocities as are independent.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Independent {
    /// The coordinates whose velocities these are, by number.
    pub free: Vec<usize>,
    /// The other coordinates, by number, with their velocities in terms of those.
    pub follows: Vec<(usize, MotionSum)>,
    /// The left sides of the equations, one for each of `free`.
    pub equations: Vec<MotionSum>,
}

/// What moves, by its factors: a polynomial in velocities and accelerations.
type Polynomial = BTreeMap<Factors, Vec<ExprId>>;

/// The polynomial of one term.
fn monomial(factors: Factors, coefficient: ExprId) -> Polynomial {
    BTreeMap::from([(factors, vec![coefficient])])
}

fn product(pool: &mut Pool, left: &Polynomial, right: &Polynomial) -> Polynomial {
    let mut all = Polynomial::new();
    for (own, a) in left {
        let a = pool.sum(a);
        for (other, b) in right {
            let mut powers: BTreeMap<Motion, u32> = own.iter().copied().gather();
            for (motion, power) in other {
                *powers.entry(*motion).or_default() += power;
            }
            let b = pool.sum(b);
            all.entry(powers.into_iter().collect()).or_default().push(pool.mul(a, b));
        }
    }
    all
}

fn add(sum: &mut Polynomial, other: Polynomial) {
    other.into_iter().for_each(|(motion, parts)| sum.entry(motion).or_default().extend(parts));
}

/// Velocities and accelerations of all coordinates in terms of those of the free ones.
struct Motions {
    velocities: Vec<Polynomial>,
    accelerations: Vec<Polynomial>,
    /// The velocities of the bound coordinates as expressions.
    speeds: Substitution,
}

impl Motions {
    /// From the rows of the bound coordinates: slopes by the velocities of all, then what is without velocities, all on the left side.
    fn new(pool: &mut Pool, variables: &Variables, free: &[usize], solved: &[(usize, Vec<ExprId>)]) -> Self {
        let n = variables.coordinates.len();
        let one = pool.one();
        let all = |of: fn(usize) -> Motion| (0..n).map(|i| monomial(single(of(i)), one)).collect();
        let mut velocities: Vec<Polynomial> = all(Motion::Velocity);
        let mut accelerations: Vec<Polynomial> = all(Motion::Acceleration);
        let mut speeds = Substitution::default();
        for (bound, row) in solved {
            let mut speed = Polynomial::new();
            let mut parts = Vec::new();
            for i in free {
                if !row[*i].is_zero() {
                    speed.insert(single(Motion::Velocity(*i)), vec![row[*i]]);
                    parts.push(pool.times(row[*i], variables.velocities[*i]));
                }
            }
            if !row[n].is_zero() {
                speed.insert(Factors::new(), vec![row[n]]);
                parts.push(row[n]);
            }
            speeds.insert(variables.velocities[*bound], pool.sum(&parts));
            velocities[*bound] = speed;
        }
        for (bound, _) in solved {
            let mut all = Polynomial::new();
            for (motion, parts) in velocities[*bound].clone() {
                let value = pool.sum(&parts);
                let mut rate = monomial(Factors::new(), variables.by_time(pool, value));
                for (j, slope) in variables.symbols.slopes(pool, value) {
                    add(&mut rate, product(pool, &monomial(Factors::new(), slope), &velocities[j]));
                }
                add(&mut all, product(pool, &monomial(motion.clone(), one), &rate));
                if let Some((Motion::Velocity(i), _)) = motion.first() {
                    all.entry(single(Motion::Acceleration(*i))).or_default().push(value);
                }
            }
            accelerations[*bound] = all;
        }
        Self { velocities, accelerations, speeds }
    }

    fn of(&self, motion: Motion) -> Option<&Polynomial> {
        match motion {
            Motion::Velocity(i) => self.velocities.get(i),
            Motion::Acceleration(i) => self.accelerations.get(i),
            Motion::Momentum(_) | Motion::Displacement(_) | Motion::NormalVelocity(_) | Motion::Normal(_) => None,
        }
    }

    /// A coefficient times what moves.
    fn term(&self, pool: &mut Pool, coefficient: ExprId, factors: &Factors) -> Option<Polynomial> {
        let coefficient = monomial(Factors::new(), pool.substitute_one(coefficient, &self.speeds));
        let mut single = factors.iter().flat_map(|(motion, power)| repeat_n(*motion, *power as usize));
        single.try_fold(coefficient, |all, motion| Some(product(pool, &all, self.of(motion)?)))
    }
}

/// The equations without multipliers; `drags` are without forces of conditions. `None` where the conditions are not shown to
/// be independent, and for equations too large to read.
pub(super) fn independent(
    pool: &mut Algebra<'_>,
    variables: &Variables,
    model: &Model,
    drags: &[(usize, ExprId)],
    is_pivot: &dyn Fn(&Pool, ExprId) -> bool,
) -> Option<Independent> {
    let n = variables.coordinates.len();
    let lagrangian = Lagrangian { drags: drags.to_vec(), ..lagrangian::lagrangian(model, pool) };
    let coefficients = equations::coefficients(pool, variables, &lagrangian);
    let at_rest = variables.at_rest(pool);
    let mut rows = Vec::new();
    let conditions: Vec<ExprId> = model.rolling.iter().map(|own| own.expression).collect();
    let constraints: Vec<ExprId> = model.constraints.iter().map(|own| own.expression).collect();
    let all: Vec<ExprId> = coefficients.values().chain(&conditions).chain(&constraints).copied().collect();
    if pool.reachable(&all).len() > MOST_PARTS {
        return None;
    }
    let mut slopes: Vec<(Vec<(usize, ExprId)>, ExprId)> = Vec::new();
    for own in constraints {
        slopes.push((variables.symbols.slopes(pool, own), variables.by_time(pool, own)));
    }
    for own in conditions {
        slopes.push((variables.symbols.velocity_slopes(pool, own), pool.substitute_one(own, &at_rest)));
    }
    for (slopes, rest) in slopes {
        let mut row = vec![pool.zero(); n + 1];
        for (i, slope) in slopes {
            row[i] = pool.simplify(slope);
        }
        row[n] = pool.simplify(rest);
        rows.push(row);
    }
    // Rather those that follow which nothing depends on.
    let used = pool.symbols_of(&all);
    let cyclic = |i: &usize| used.binary_search(&variables.coordinates[*i]).is_err();
    let (mut candidates, others): (Vec<usize>, Vec<usize>) = (0..n).partition(cyclic);
    candidates.extend(others.iter().rev());
    let (bound, eliminated) = solved_for(pool, &rows, &candidates, is_pivot)?;
    let free: Vec<usize> = (0..n).filter(|i| !bound.contains(i)).collect();
    let mut solved: Vec<(usize, Vec<ExprId>)> = Vec::with_capacity(bound.len());
    for (i, row) in bound.iter().zip(eliminated) {
        let own = row.into_iter().map(|entry| pool.short(|pool| pool.neg(entry)));
        solved.push((*i, own.collect()));
    }
    if let Some(other) = by_determinants(pool, &rows, &bound, is_pivot) {
        let [before, after] =
            [&solved, &other].map(|all| pool.weight_of(&all.iter().flat_map(|own| own.1.clone()).collect::<Vec<_>>()));
        solved = if after < before { other } else { solved };
    }
    let all: Vec<ExprId> = solved.iter().flat_map(|(_, row)| row).copied().collect();
    let divisors = bases_with(pool, &all, |base, exponent| exponent.is_negative() && !pool.is_constant(base));
    let motions = Motions::new(pool, variables, &free, &solved);
    let mut equations = Vec::with_capacity(free.len());
    for own in &free {
        let mut parts = Polynomial::new();
        let weights = solved.iter().map(|(bound, row)| (*bound, row[*own]));
        let one = (*own, pool.one());
        for (i, weight) in std::iter::once(one).chain(weights).filter(|(_, weight)| !weight.is_zero()) {
            for ((_, factors), coefficient) in coefficients.range((i, Factors::new())..(i + 1, Factors::new())) {
                let coefficient = pool.mul(weight, *coefficient);
                add(&mut parts, motions.term(pool, coefficient, factors)?);
            }
        }
        let mut equation = MotionSum::of_parts(pool, parts);
        for term in &mut equation.terms {
            term.coefficient = over_divisors(pool, &divisors, term.coefficient);
        }
        equation.terms.retain(|term| !term.coefficient.is_zero());
        equations.push(equation);
    }
    let follows = bound.into_iter().map(|i| (i, MotionSum::of_parts(pool, motions.velocities[i].clone())));
    let mut follows: Vec<(usize, MotionSum)> = follows.collect();
    follows.order_by_key(|(i, _)| *i);
    Some(Independent { free, follows, equations })
}

/// The bound columns of few rows in terms of the others by Cramer's rule, in which cos² + sin² is 1 before anything is divided by it.
fn by_determinants(
    pool: &mut Algebra<'_>,
    rows: &[Vec<ExprId>],
    bound: &[usize],
    is_pivot: &dyn Fn(&Pool, ExprId) -> bool,
) -> Option<Vec<(usize, Vec<ExprId>)>> {
    if !(2..=MOST_BY_DETERMINANTS).contains(&rows.len()) {
        return None;
    }
    let block = |replaced: usize, by: usize| -> Vec<Vec<ExprId>> {
        let column = |own: &usize| if *own == replaced { by } else { *own };
        rows.iter().map(|row| bound.iter().map(|own| row[column(own)]).collect()).collect()
    };
    let whole = pool.short(|pool| determinant(pool, &block(bound[0], bound[0])));
    if !is_pivot(pool, whole) {
        return None;
    }
    let mut solved = Vec::new();
    for own in bound {
        let mut entries = Vec::new();
        for by in 0..rows[0].len() {
            let part = pool.short(|pool| determinant(pool, &block(*own, by)));
            let quotient = pool.div(part, whole);
            entries.push(pool.short(|pool| pool.neg(quotient)));
        }
        solved.push((*own, entries));
    }
    Some(solved)
}

/// An expression over a power of one of the divisors, where that is shorter: 1 + tan² as 1/cos².
fn over_divisors(pool: &mut Algebra<'_>, divisors: &BTreeSet<ExprId>, e: ExprId) -> ExprId {
    let mut best = e;
    for divisor in divisors {
        let mut above = e;
        for power in 1..=MOST_POWER {
            above = pool.mul(above, *divisor);
            let whole = pool.simplify(above);
            let own = pool.product_of_powers(&[(whole, Number::ONE), (*divisor, Number::from(-power))]);
            if pool.weight(own) < pool.weight(best) {
                best = own;
            }
        }
    }
    best
}

/// The equations of a model in independent velocities, and the pool that they are in.
fn reduced(model: &Model, is_pivot: &dyn Fn(&Pool, ExprId) -> bool) -> Option<(Pool, Independent)> {
    let mut pool = model.pool.clone();
    let variables = Variables::new(model);
    let drags = lagrangian::drags(model, &mut pool, &variables);
    let found = independent(&mut Algebra::new(&mut pool), &variables, model, &drags, is_pivot)?;
    Some((pool, found))
}

/// A model with conditions on velocities as one without, of the coordinates whose velocities are independent: with M of the
/// equations in these, and what these have beside Lagrange's equations of the same M and V as generalised forces.
///
/// `None` where the equations contain the other coordinates, or rates that are given break the conditions at the start.
#[must_use]
pub fn in_independent_coordinates(model: &Model) -> Option<Model> {
    let model = linearize::integrated(model);
    let model = model.assumed();
    if model.rolling.is_empty() || !model.constraints.is_empty() {
        return None;
    }
    let variables = Variables::new(&model);
    let checker = Checker::new(&model);
    let mut start = Substitution::default();
    for (i, own) in model.coordinates.iter().enumerate() {
        let stated = model.equilibria.get(i).or_else(|| model.guesses.get(i));
        start.insert(own.symbol, stated.map_or_else(|| model.pool.zero(), |stated| stated.symbolic));
        start.insert(own.velocity, model.rates.get(i).map_or_else(|| model.pool.zero(), |rate| rate.symbolic));
    }
    let differs = |pool: &Pool, e: ExprId| {
        let mut pool = pool.clone();
        let here = pool.substitute_one(e, &start);
        checker.differs_from_zero(&pool, here)
    };
    let (mut pool, found) = reduced(&model, &differs)?;
    if moves_by_itself(&mut pool, &variables, &found) {
        return None;
    }
    for (i, speed) in &found.follows {
        if let Some(rate) = model.rates.get(*i) {
            let speed = speed.at_constant_rates(&mut pool, &variables.velocities);
            let off = pool.sub(speed, rate.symbolic);
            if differs(&pool, off) {
                return None;
            }
        }
    }
    of_independent(&model, pool, &variables, &found)
}

/// Whether the velocity of a coordinate that follows depends on its own place, by way of others too: then it has exponents of its own.
fn moves_by_itself(pool: &mut Pool, variables: &Variables, found: &Independent) -> bool {
    let mut left: Vec<(Symbol, Vec<Symbol>)> = Vec::new();
    for (i, speed) in &found.follows {
        let speed = speed.at_constant_rates(pool, &variables.velocities);
        left.push((variables.coordinates[*i], pool.symbols_of(&[speed])));
    }
    loop {
        let open: Vec<Symbol> = left.iter().map(|(own, _)| *own).collect();
        let before = left.len();
        left.retain(|(_, symbols)| symbols.iter().any(|symbol| open.contains(symbol)));
        if left.len() == before {
            return before > 0;
        }
    }
}

/// The model that has these equations.
fn of_independent(model: &Model, mut pool: Pool, variables: &Variables, found: &Independent) -> Option<Model> {
    let span = model.rolling.first()?.span;
    let mut kinetic = Vec::new();
    for (equation, i) in found.equations.iter().zip(&found.free) {
        for j in &found.free {
            let entry = equation.coefficient(&mut pool, Motion::Acceleration(*j));
            let [u, v] = [i, j].map(|i| pool.symbol_expr(variables.velocities[*i]));
            kinetic.push((pool.product(&[entry, u, v]), Number::half()));
        }
    }
    let kinetic = pool.linear(&kinetic);
    let bound = |symbol: Symbol| {
        let at = variables.symbols.coordinate(symbol).or_else(|| variables.symbols.velocity(symbol));
        at.is_some_and(|at| !found.free.contains(&at))
    };
    let potential = model.potential.iter().flat_map(|own| linearize::instances(model, &mut pool, own, own.body, None));
    let potential: Vec<ExprId> = potential.collect();
    let mut potential = pool.sum(&potential);
    if pool.depends_on(potential, &bound) {
        potential = pool.zero();
    }
    let lagrangian = pool.sub(kinetic, potential);
    let mut own = model.bare(&found.free);
    let locals = || found.free.iter().map(|i| Local::new(variables.coordinates[*i], variables.velocities[*i]));
    let numbers: Vec<u32> = (0..found.free.len()).map(|at| u32::try_from(at).unwrap_or(u32::MAX)).collect();
    let family = |body: ExprId| TermFamily::single(span, body, locals().collect(), numbers.clone());
    for (at, (equation, i)) in found.equations.iter().zip(&found.free).enumerate() {
        // Lagrange's equation of this M and V, without accelerations.
        let momentum = pool.diff(lagrangian, variables.velocities[*i]);
        let mut parts = vec![variables.by_time(&mut pool, momentum)];
        let slopes = variables.symbols.slopes(&mut pool, momentum);
        parts.extend(slopes.into_iter().map(|(j, slope)| pool.times(slope, variables.velocities[j])));
        let slope = pool.diff(lagrangian, variables.coordinates[*i]);
        let load = equation.at_constant_rates(&mut pool, &variables.velocities);
        parts.extend([slope, load].map(|e| pool.neg(e)));
        let force = Algebra::new(&mut pool).short(|pool| pool.sum(&parts));
        if pool.depends_on(force, &bound) {
            return None;
        }
        if !pool.vanishes(force) {
            own.forces.push(TermFamily { acts_on: Some(at), ..family(force) });
            own.force = Some(span);
        }
    }
    if pool.depends_on(kinetic, &bound) {
        return None;
    }
    own.kinetic.push(family(kinetic));
    own.potential.push(family(potential));
    own.dissipation = None;
    own.pool = pool;
    Some(own)
}

/// A model about its equilibrium or steady motion, as [`linearize::linearize`] has it; where conditions on velocities exert forces there,
/// or what they leave open moves in no steady way, as the place of a disc that rolls in a circle, that of the coordinates whose velocities
/// are independent.
///
/// # Errors
/// Those of [`linearize::linearize`] for the model as it is.
pub fn linearized(model: Model) -> Result<Linearized, LinearizeError> {
    let model = if model.rolling.is_empty() { model } else { linearize::integrated(&model).into_owned() };
    if model.rolling.is_empty() {
        return linearize::linearize(model);
    }
    linearize::linearize(model.clone()).or_else(|error| {
        let own = matches!(
            error,
            LinearizeError::NotAnEquilibrium { .. }
                | LinearizeError::NoEquilibrium { .. }
                | LinearizeError::EquilibriumNotFound { .. }
                | LinearizeError::RollingBroken { .. }
                | LinearizeError::RollingNotCovered { .. }
                | LinearizeError::NotCyclic { .. }
                | LinearizeError::RateNotKept { .. }
        );
        if own
            && let Some((held, zeros)) = held_at_zero(&model)
            && let Ok(found) = linearize::linearize(held)
        {
            return Ok(found.with_zeros(&zeros));
        }
        let reduced = if own { in_independent_coordinates(&model) } else { None };
        let span = model.rolling.first().map(|own| own.span).unwrap_or_default();
        let is_decided = reduced.is_some() && model.constraints.is_empty();
        reduced.and_then(|reduced| linearize::linearize(reduced).ok()).ok_or(match error {
            LinearizeError::NotAnEquilibrium { .. } if !is_decided => {
                LinearizeError::RollingNotCovered { reason: LOADED, span }
            }
            error => may_be_carried(&model, error),
        })
    })
}

/// The model at the place where all coordinates are 0 for which nothing is given, and these coordinates: there the forces of the
/// conditions may balance all others.
pub(super) fn held_at_zero(model: &Model) -> Option<(Model, Vec<usize>)> {
    if model.rolling.is_empty() || model.guesses.any() || model.rates.any() {
        return None;
    }
    let mut own = model.clone();
    let zero = own.pool.zero();
    let open: Vec<usize> = (0..own.coordinates.len()).filter(|i| own.equilibria.get(*i).is_none()).collect();
    for i in &open {
        let span = own.coordinates.at(*i).span;
        own.equilibria.set(*i, Some(Given { symbolic: zero, value: Some(zero), span }));
    }
    Some((own, open))
}

/// What an error says of a model whose conditions on velocities may carry what no place is free of.
pub(super) fn may_be_carried(model: &Model, error: LinearizeError) -> LinearizeError {
    match (error, model.rolling.first()) {
        (LinearizeError::NoEquilibrium { .. } | LinearizeError::EquilibriumNotFound { .. }, Some(own)) => {
            LinearizeError::RollingNotCovered { reason: NOWHERE, span: own.span }
        }
        (error, _) => error,
    }
}

/// The equations in independent velocities of a model whose conditions are solved by dividing through nothing that moves, so that
/// they hold everywhere; with the pool that they are in.
#[must_use]
pub fn without_multipliers(model: &Model) -> Option<(Pool, Independent)> {
    if model.rolling.is_empty() || !model.constraints.is_empty() {
        return None;
    }
    let model = linearize::without_dependent(model);
    let model = model.assumed();
    let variables = Variables::new(&model);
    let checker = Checker::new(&model);
    let still = |pool: &Pool, e: ExprId| {
        let moves = |symbol| variables.symbols.coordinate(symbol).is_some() || variables.time == Some(symbol);
        !pool.depends_on(e, &moves) && checker.differs_from_zero(pool, e)
    };
    reduced(&model, &still)
}
