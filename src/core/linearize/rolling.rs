//! Conditions on velocities: rolling, skates, and what else constraint forces keep without a relation of the coordinates.
//!
//! A condition A(q) q' + b(q) = 0 restricts velocities and, linearised about rest or a steady motion q0' = s,
//! A δq' + B δq = 0 with B = ∂(A s + b)/∂q (Neimark and Fufaev, Dynamics of Nonholonomic Systems, chapter 4). Its forces Aᵀμ vanish there,
//! or balance others at an equilibrium that is given in full, and then turn with the directions A: S is less Σ μ ∂A/∂q. With as many coordinates z expressed by the others y as there
//! are conditions, δq = Z y + W z with AZ = 0 and z' = -β y - γ z, and
//!
//! ```text
//! ZᵀMZ y'' + (ZᵀDZ - Pβ) y' + (ZᵀSZ + Pγβ - Qβ) y + (Pγ² - Qγ + R) z = 0,    P = ZᵀMW, Q = ZᵀDW, R = ZᵀSW.
//! ```
//!
//! Those of z that act on y in a steady motion are coordinates of first order beside y, with the equations z' + β y + γ z = 0. Where the others stay
//! out of it, which is proved in symbols, the exponents are those of y and, as γ is nilpotent for them, a 0 for each
//! condition that can't be integrated: at rest the equilibria come in a family of as many dimensions. How many
//! can't be is told by the Lie brackets of the fields of allowed velocities and, where b is not 0, of the one at which all others rest (Frobenius).
//! All of this is done in symbols, and evaluated at any precision. Holonomic constraints beside them are rows of A with B = 0. *Nothing is
//! integrated here.*

use super::assemble::{Assembly, evaluate_closed};
use super::by_hand;
use super::constrained::{self, Tangent};
use super::elimination::nullspace_mod;
use super::equilibrium::Equilibrium;
use super::error::LinearizeError;
use super::integrable::not_integrable;
use super::multipliers::clear_column;
use super::parameters::{Formulas, known_values};
use super::rows::{Rows, added, beginning, eliminate, masked, minus, parts, product, scaled, total, vanish};
use super::symbolic::{self, SymbolicMatrices, equilibrium_expressions, matrices_at};
use super::velocity::{Numbers, sum};
use crate::expr::{ExprId, Pool, Substitution, Symbol};
use crate::model::{Model, transposed};
use crate::number::Number;
use crate::order::Gather;
use crate::precision::{Ball, Dual, Enclosure, Scalar};

/// Models with more coordinates, multipliers included, are not written out.
const MOST_COORDINATES: usize = 60;

/// Stands for the value of a parameter that has none.
const DRAWN: f64 = 0.703125;

/// Why a family of equilibria is not covered.
const NOT_TOLD: &str = "which of them can be integrated is not told";
const NOT_DECIDED: &str = "whether they can be integrated is not decided";
const ELSEWHERE: &str = "they keep a relation of the coordinates, and whether the place found obeys that of the `guess` is not told; \
    give the place meant with `equilibrium`";
const NOT_SINGLE: &str = "the family of steady motions that they leave is not one of single coordinates";

/// The linearised model in symbols, for the coordinates that the others follow.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SymbolicRolling {
    /// The coordinates that the others follow, by number.
    pub free: Vec<usize>,
    /// Those of them, by place, whose equations are conditions, of first order.
    pub(super) first: Vec<usize>,
    /// The coordinates that follow the others.
    pub(super) bound: Vec<usize>,
    /// How the velocities of `bound` follow what `free` and `bound` are: -β, then -γ; one row each, and none where all of it is 0.
    drift: Rows,
    /// For each condition that can't be integrated, the coordinate that moves along its family of equilibria.
    pub(super) moved: Vec<usize>,
    /// M, G, C, K and N of `free`; those that are 0 are not there.
    pub matrices: [Option<Rows>; 5],
    /// The coefficients of the velocities in constraints and conditions, one row each.
    pub gradients: Rows,
    /// Z, one row a coordinate: what its velocity is made of.
    pub directions: Rows,
    /// The multipliers of the conditions at the equilibrium; none where they exert no force.
    pub reactions: Vec<ExprId>,
    /// What forces on `free` come with each of `moved`, which these follow along the family; one row each of `free`.
    pub(super) shifts: Rows,
    /// How `bound` go with each of `moved`; one row each of `bound`.
    carried: Rows,
}

/// Of the coordinates that others tie to the free ones those that constraints leave to move along families of equilibria, and how all of
/// them go with these: one row a coordinate.
fn left_to_move(pool: &mut Pool, constraints: &[Vec<ExprId>], bound: &[usize]) -> (Vec<usize>, Rows) {
    let mut rows: Rows = constraints.iter().map(|row| bound.iter().map(|i| row[*i]).collect()).collect();
    let mut pivots = Vec::new();
    for at in 0..rows.len() {
        // What other rows have is cleared, so that a row says only what is its own.
        let Some(column) = (0..bound.len()).find(|column| !rows[at][*column].is_zero()) else { continue };
        clear_column(pool, &mut rows, at, column);
        pivots.push((column, at));
    }
    let moved: Vec<usize> = (0..bound.len()).filter(|at| pivots.iter().all(|(pivot, _)| pivot != at)).collect();
    let (zero, one) = (pool.zero(), pool.one());
    let mut row = |at: usize| match pivots.iter().find(|(pivot, _)| *pivot == at) {
        Some((_, row)) => moved.iter().map(|own| pool.neg(rows[*row][*own])).collect(),
        None => moved.iter().map(|own| if *own == at { one } else { zero }).collect(),
    };
    let carried = (0..bound.len()).map(&mut row).collect();
    (moved.iter().map(|at| bound[*at]).collect(), carried)
}

/// The linearised model, for the coordinates that the others follow.
#[derive(Clone, Debug)]
pub(super) struct Rolling {
    pub(super) symbolic: SymbolicRolling,
    /// The matrices, and how each of `bound` follows `free`, one after another.
    formulas: Formulas,
}

/// The value of a parameter, with the derivative by one of them.
fn varied(number: usize, value: Option<Dual<Ball>>, parameter: usize) -> Option<Dual<Ball>> {
    value.map(|own| if number == parameter { Dual { slope: Ball::ONE, ..own } } else { own })
}

/// The columns of `kept` of a matrix that has one of each of `all`.
fn columns_of(rows: &Rows, all: &[usize], kept: &[usize]) -> Rows {
    let of = |row: &Vec<ExprId>| all.iter().zip(row).filter(|(own, _)| kept.contains(own)).map(|(_, e)| *e).collect();
    rows.iter().map(of).collect()
}

/// Which of z, but for those that are `tied` by constraints and rest, act on y (`feeds_back`), or on those that do, or decay or
/// grow by themselves: what is left of γ is nilpotent.
fn acting(pool: &mut Pool, feeds_back: &Rows, [beta, gamma]: [&Rows; 2], tied: &[bool]) -> Vec<bool> {
    let count = gamma.len();
    // What constraints hold has nowhere to drift.
    let held = |k: usize| tied[k] && beta[k].iter().chain(&gamma[k]).all(|e| e.is_zero());
    let acts = |k: usize| !held(k) && feeds_back.iter().any(|row| !row[k].is_zero());
    let mut acting: Vec<bool> = (0..count).map(acts).collect();
    let close = |acting: &mut Vec<bool>| {
        for _ in 0..count {
            for k in 0..count {
                acting[k] |= (0..count).any(|i| acting[i] && !gamma[i][k].is_zero());
            }
        }
    };
    close(&mut acting);
    let left: Vec<usize> = (0..count).filter(|k| !acting[*k]).collect();
    let own: Rows = left.iter().map(|i| left.iter().map(|j| gamma[*i][*j]).collect()).collect();
    let power = (1..left.len()).fold(own.clone(), |power, _| product(pool, &power, &own));
    if !vanish(&power) {
        left.iter().for_each(|k| acting[*k] = gamma[*k].iter().any(|e| !e.is_zero()));
        close(&mut acting);
    }
    acting
}

/// The conditions at a point, in symbols.
struct Conditions {
    /// Of constraints and of conditions: the coefficients of the velocities, then those of the coordinates.
    rows: Rows,
    /// The first so many are constraints.
    constraints: usize,
}

/// Where no velocities obey all conditions and constraints at a point: what all terms without velocities of the first condition that
/// is one too many leave.
fn contradicts(model: &Model, pool: &mut Pool, point: &[ExprId], constraints: &[Vec<ExprId>]) -> Option<String> {
    let n = point.len();
    let velocities: Vec<Symbol> = model.coordinates.iter().take(n).map(|own| own.velocity).collect();
    let mut place: Substitution = model.coordinates.iter().map(|own| own.symbol).zip(point.iter().copied()).gather();
    let known = known_values(model);
    place.extend(velocities.iter().map(|own| (*own, pool.zero())));
    let mut entries: Vec<ExprId> = Vec::new();
    for row in constraints {
        entries.extend(&row[..n]);
        entries.push(pool.zero());
    }
    for own in &model.rolling {
        entries.extend(pool.gradient(own.expression, &velocities));
        entries.push(own.expression);
    }
    let entries = pool.substitute(&entries, &place);
    let valued = pool.substitute(&entries, &known);
    let mut found = pool.points_at_random(&valued, 1).map(|values| {
        let rank = |count: usize, columns: usize| {
            let rows = values.chunks(n + 1).take(count).map(|row| row[..columns].to_vec());
            columns - nullspace_mod(&rows.collect::<Vec<_>>(), columns).len()
        };
        (constraints.len()..valued.len() / (n + 1)).find(|at| rank(at + 1, n) < rank(at + 1, n + 1))
    });
    let at = found.next()??;
    found.all(|other| other == Some(at)).then(|| pool.display(entries[(n + 1) * at + n]))
}

impl Conditions {
    fn new(
        model: &Model,
        pool: &mut Pool,
        point: &[ExprId],
        stiffness: &Rows,
        visible: usize,
    ) -> Result<Self, LinearizeError> {
        let zero = pool.zero();
        let at_velocities = |row: &Vec<ExprId>| [&row[..visible], &vec![zero; visible]].concat();
        let mut rows: Rows = stiffness[visible..].iter().map(at_velocities).collect();
        let constraints = rows.len();
        let place = place(model, pool, &point[..visible]);
        for own in &model.rolling {
            let here = pool.substitute_one(own.expression, &place);
            let valued = pool.substitute_one(here, &known_values(model));
            if !pool.vanishes(here) && !pool.vanishes(valued) {
                let (difference, span) = (pool.display(here), own.span);
                return Err(match contradicts(model, pool, &point[..visible], &rows[..constraints]) {
                    Some(difference) => LinearizeError::ConstraintsContradict { difference: Some(difference), span },
                    None => LinearizeError::RollingBroken { difference, span },
                });
            }
            let coordinates: Vec<Symbol> = model.coordinates.iter().take(visible).map(|own| own.symbol).collect();
            let velocities: Vec<Symbol> = model.coordinates.iter().take(visible).map(|own| own.velocity).collect();
            let mut row = pool.gradient(own.expression, &velocities);
            row.extend(pool.gradient(own.expression, &coordinates));
            let row = pool.substitute(&row, &place);
            rows.push(row.into_iter().map(|e| if pool.vanishes(e) { zero } else { e }).collect());
        }
        Ok(Self { rows, constraints })
    }

    /// Which coordinates follow the others, in the order of elimination: rather those that neither forces nor conditions
    /// depend on.
    fn choose(&self, model: &Model, pool: &Pool, stiffness: &Rows, at: &[Ball]) -> Option<Vec<usize>> {
        let visible = self.rows.first()?.len() / 2;
        let all: Vec<ExprId> = self.rows.iter().flat_map(|row| &row[..visible]).copied().collect();
        // A page needs no values: any will do for what is not 0 identically.
        let drawn = |number: usize| Ball::exact(DRAWN + number as f64 / 8.0);
        let known = |number, value: Option<Ball>| Some(value.unwrap_or_else(|| drawn(number)));
        let numbers = Formulas::new(model, pool, &all)?.at_where(model, at, (), known)?;
        let rows: Vec<Vec<Ball>> = numbers.chunks(visible).map(<[Ball]>::to_vec).collect();
        let tier = |column: usize| {
            let held = stiffness.iter().take(visible).any(|row| !row[column].is_zero());
            let steers = self.rows.iter().any(|row| !row[visible + column].is_zero());
            if held { 0 } else { 2 - usize::from(steers) }
        };
        let rank = |column: usize, size: f64| (size > 1e-9).then(|| (tier(column), size));
        constrained::eliminate(rows, rank, ()).map(|own| own.pivots)
    }
}

/// The multipliers μ of conditions that hold a model at an equilibrium or in a steady motion which is given in full, one a condition, where forces act there:
/// those on the coordinates are Aᵀμ. `None` where no forces act, others are left, or constraints are there as well.
pub(super) fn reactions(model: &mut Model, assembly: &Assembly) -> Option<Vec<ExprId>> {
    if model.rolling.is_empty() || !model.constraints.is_empty() {
        return None;
    }
    let point: Option<Vec<ExprId>> = model.equilibria.iter().map(|given| given.map(|given| given.symbolic)).collect();
    let point = point?;
    let (mut pool, forces) = symbolic::forces(model, model.pool.clone(), assembly, &point)?;
    let (place, velocities) = (place(model, &pool, &point), model.coordinates.iter().map(|own| own.velocity));
    let velocities: Vec<Symbol> = velocities.collect();
    let mut rows: Rows = vec![Vec::new(); point.len()];
    for own in &model.rolling {
        let slopes = pool.gradient(own.expression, &velocities);
        let slopes = pool.substitute(&slopes, &place);
        rows.iter_mut().zip(slopes).for_each(|(row, slope)| row.push(slope));
    }
    for (row, i) in rows.iter_mut().zip(0..) {
        row.push(forces.get(&i).copied().unwrap_or(pool.zero()));
    }
    let count = model.rolling.len();
    let solved = eliminate(&mut pool, rows, &(0..count).collect::<Vec<_>>())?;
    let known = known_values(model);
    let is_none = |pool: &mut Pool, e: ExprId| {
        let valued = pool.substitute_one(e, &known);
        pool.vanishes(e) || pool.vanishes(valued)
    };
    let last = |row: &Vec<ExprId>| row.last().copied();
    let multipliers: Vec<ExprId> = solved.iter().take(count).filter_map(last).collect();
    let held = solved.iter().skip(count).filter_map(last).all(|rest| is_none(&mut pool, rest));
    let acts = multipliers.iter().any(|own| !is_none(&mut pool, *own));
    model.pool = pool;
    (held && acts).then_some(multipliers)
}

/// -Σ μ ∂A/∂q: what the directions of reactions add to the stiffness.
fn bent(model: &Model, pool: &mut Pool, point: &[ExprId], reactions: &[ExprId]) -> Option<Rows> {
    let coordinates: Vec<Symbol> = model.coordinates.iter().take(point.len()).map(|own| own.symbol).collect();
    let place = place(model, pool, point);
    let mut rows: Rows = vec![vec![pool.zero(); point.len()]; point.len()];
    for (own, reaction) in model.rolling.iter().zip(reactions) {
        for (row, coordinate) in rows.iter_mut().zip(model.coordinates.iter()) {
            let slope = pool.diff(own.expression, coordinate.velocity);
            let slopes = pool.gradient(slope, &coordinates);
            for (entry, slope) in row.iter_mut().zip(pool.substitute(&slopes, &place)) {
                let share = pool.mul(*reaction, slope);
                *entry = pool.sub(*entry, share);
            }
        }
    }
    (!reactions.is_empty()).then_some(rows)
}

/// A point, and the rates there.
fn place(model: &Model, pool: &Pool, point: &[ExprId]) -> Substitution {
    let mut place = Substitution::default();
    for ((own, at), rate) in model.coordinates.iter().zip(point).zip(model.rates.iter()) {
        place.insert(own.symbol, *at);
        place.insert(own.velocity, rate.map_or(pool.zero(), |rate| rate.symbolic));
    }
    place
}

/// How many conditions no function of the coordinates gives, where the place is one that the others allow.
fn told_where(model: &Model, point: &[ExprId], at: &[Ball], zeros: usize) -> Result<usize, &'static str> {
    if zeros == model.rolling.len() || rests_where_guessed(model, point, at) { Ok(zeros) } else { Err(ELSEWHERE) }
}

/// Whether a place is that of the guesses, as far as there are any: relations of the coordinates that hold there hold here.
fn rests_where_guessed(model: &Model, point: &[ExprId], at: &[Ball]) -> bool {
    let start = symbolic::stated(model, true).into_iter().zip(point.iter().zip(at)).zip(model.equilibria.iter());
    let known = known_values(model);
    let mut pool = model.pool.clone();
    let mut meets = |start, at: &Ball| {
        let start = pool.substitute_one(start, &known);
        evaluate_closed::<Ball>(&pool, start, ()).is_none_or(|start| (start - *at).contains_zero())
    };
    // What forces leave at rest where it is guessed is not searched for.
    let mut is_there = |(start, (own, at)): (ExprId, (&ExprId, &Ball))| start == *own || meets(start, at);
    !model.guesses.any() || start.filter(|(_, given)| given.is_none()).all(|(own, _)| is_there(own))
}

/// Columns of rows, counted from the one behind `first`.
fn behind(rows: &[Vec<ExprId>], first: usize, columns: &[usize]) -> Rows {
    rows.iter().map(|row| columns.iter().map(|i| row[first + i]).collect()).collect()
}

impl SymbolicRolling {
    /// The linearised model at a point of expressions, from its matrices with multipliers of constraints; `at` is the point where
    /// these hold coordinates, and `reactions` are the multipliers of conditions there, none where these exert no force.
    pub(super) fn new(
        model: &Model,
        whole: &mut SymbolicMatrices,
        point: &[ExprId],
        at: &[Ball],
        (visible, reactions): (usize, &[ExprId]),
    ) -> Result<Self, LinearizeError> {
        let SymbolicMatrices { pool, mass, stiffness: whole, gyroscopic, damping, circulatory, .. } = whole;
        let span = model.rolling.first().map(|own| own.span).unwrap_or_default();
        let refused = |reason| LinearizeError::RollingNotCovered { reason, span };
        let conditions = Conditions::new(model, pool, point, whole, visible)?;
        let bent = bent(model, pool, &point[..visible], reactions);
        let dependent = || refused("they depend on each other there");
        let bound = conditions.choose(model, pool, whole, at).ok_or_else(dependent)?;
        let free: Vec<usize> = (0..visible).filter(|i| !bound.contains(i)).collect();
        let (candidates, carried) = left_to_move(pool, &conditions.rows[..conditions.constraints], &bound);
        let rows = eliminate(pool, conditions.rows.clone(), &bound).ok_or_else(dependent)?;
        let slopes = scaled(pool, &behind(&rows, 0, &free), Number::MINUS_ONE);
        let [own, gamma] = [&free, &bound].map(|columns| behind(&rows, visible, columns));
        let through = product(pool, &gamma, &slopes);
        let beta = added(pool, &own, &through);
        // Z as rows of all coordinates; W has a 1 for each of those that follow.
        let (zero, one) = (pool.zero(), pool.one());
        let unit = |of: &[usize], i: usize| of.iter().map(|own| if *own == i { one } else { zero }).collect();
        let place = |i: &usize| bound.iter().position(|own| own == i);
        let followed = |i| place(&i).map_or_else(|| unit(&free, i), |row| slopes[row].clone());
        let directions: Rows = (0..visible).map(followed).collect();
        let back = transposed(&directions);
        let both = |pool: &mut Pool, parts: [Option<&Rows>; 2]| {
            let matrix = total(pool, visible, parts);
            let image = product(pool, &back, &matrix);
            (product(pool, &image, &directions), behind(&image, 0, &bound))
        };
        let (mass, p) = both(pool, [Some(mass), None]);
        let (velocity, q) = both(pool, [gyroscopic.as_ref(), damping.as_ref()]);
        let bent = total(pool, visible, [circulatory.as_ref(), bent.as_ref()]);
        let (stiffness, r) = both(pool, [Some(whole), Some(&bent)]);

        let p_gamma = product(pool, &p, &gamma);
        let velocity = minus(pool, &velocity, &p, &beta);
        let share = product(pool, &p_gamma, &beta);
        let stiffness = added(pool, &stiffness, &share);
        let stiffness = minus(pool, &stiffness, &q, &beta);
        let drifts = !(vanish(&beta) && vanish(&gamma));
        let feeds_back = product(pool, &p_gamma, &gamma);
        let feeds_back = minus(pool, &feeds_back, &q, &gamma);
        let feeds_back = added(pool, &feeds_back, &r);
        let tied: Vec<bool> = bound.iter().map(|i| !candidates.contains(i)).collect();
        let acting = if drifts { acting(pool, &feeds_back, [&beta, &gamma], &tied) } else { vec![false; bound.len()] };
        let feeds_back = masked(pool, &feeds_back, &acting);
        let zeros = not_integrable(model, pool, &bound, visible).ok_or(NOT_DECIDED);
        let zeros = zeros.and_then(|zeros| told_where(model, point, at, zeros)).map_err(refused)?;
        // A family of equilibria moves these alone; those that act on the others have exponents of their own.
        let is_acting = |i: &usize| place(i).is_some_and(|at| acting[at]);
        let (alive, mut moved): (Vec<usize>, Vec<usize>) = candidates.iter().partition(|i| is_acting(i));
        if alive.len() < acting.iter().filter(|own| **own).count() {
            return Err(refused("coordinates that constraints hold as well act on the others in this steady motion"));
        }
        if zeros == 0 && alive.is_empty() {
            moved.clear();
        } else if zeros != alive.len() + moved.len() && (alive.is_empty() || !moved.is_empty()) {
            return Err(refused(NOT_TOLD));
        }
        let carried = columns_of(&carried, &candidates, &moved);
        let mut shifts = product(pool, &r, &carried);
        let alone = |(i, row): (&usize, &Vec<ExprId>)| moved.contains(i) || row.iter().all(|e| e.is_zero());
        if drifts && !(vanish(&shifts) && bound.iter().zip(&carried).all(alone)) {
            return Err(refused(NOT_SINGLE));
        }
        let others: Vec<usize> = bound.iter().copied().filter(|i| !is_acting(i)).collect();
        let left: Vec<usize> = (0..visible).filter(|i| !others.contains(i)).collect();
        // Beside coordinates that act on the others nothing comes along.
        shifts.resize(left.len(), vec![zero; moved.len()]);
        // Of y and z + Z y, which are the coordinates themselves.
        let stiffness = if alive.is_empty() { stiffness } else { minus(pool, &stiffness, &feeds_back, &slopes) };
        // The equations of y by y and z, and those of z, which are the solved conditions from a column on.
        let second = [(&mass, None, None), (&velocity, None, Some(0)), (&stiffness, Some(&feeds_back), Some(visible))];
        let [mass, velocity, stiffness] = second.map(|(own, beside, from)| -> Rows {
            let entry = |i: &usize, j: &usize| match (free.binary_search(i), free.binary_search(j)) {
                (Ok(i), Ok(j)) => own[i][j],
                (Ok(i), Err(_)) => beside.zip(place(j)).map_or(zero, |(beside, j)| beside[i][j]),
                (Err(_), _) => from.zip(place(i)).map_or(zero, |(from, row)| rows[row][from + j]),
            };
            left.iter().map(|i| left.iter().map(|j| entry(i, j)).collect()).collect()
        });
        let carried = bound.iter().zip(carried).filter(|(i, _)| !is_acting(i)).map(|(_, row)| row).collect();
        let first = (0..left.len()).filter(|at| is_acting(&left[*at])).collect();
        let solved: Rows = others.iter().filter(|_| drifts).filter_map(place).map(|row| rows[row].clone()).collect();
        let drift = scaled(pool, &behind(&solved, visible, &[left.as_slice(), &others].concat()), Number::MINUS_ONE);
        let directions: Rows = (0..visible)
            .map(|i| match left.binary_search(&i) {
                Ok(_) => unit(&left, i),
                Err(_) => left.iter().map(|j| free.binary_search(j).map_or(zero, |at| directions[i][at])).collect(),
            })
            .collect();
        let (matrices, gradients) = (parts(pool, mass, &velocity, &stiffness), beginning(&conditions.rows, visible));
        let (free, bound, reactions) = (left, others, reactions.to_vec());
        Ok(Self { free, first, bound, drift, moved, matrices, gradients, directions, reactions, shifts, carried })
    }

    /// The equations of all coordinates, `free` and then `bound`: the coefficients of 1, s and s² of each entry, row by row.
    pub(super) fn pencil(&self, pool: &mut Pool) -> Vec<Vec<ExprId>> {
        let (n, count) = (self.free.len(), self.free.len() + self.bound.len());
        let (zero, one) = (pool.zero(), pool.one());
        let [mass, gyroscopic, damping, stiffness, circulatory] = &self.matrices;
        let mut entries = Vec::with_capacity(count * count);
        for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
            let mut sum = |parts: [&Option<Rows>; 2]| {
                let parts: Vec<ExprId> = parts.into_iter().flatten().map(|rows| rows[i][j]).collect();
                pool.sum(&parts)
            };
            entries.push(if i < n && j < n {
                vec![sum([stiffness, circulatory]), sum([gyroscopic, damping]), sum([mass, &None])]
            } else if i < n {
                vec![zero; 3]
            } else {
                let velocity = if j < n { pool.neg(self.directions[self.bound[i - n]][j]) } else { zero };
                let place = self.drift.get(i - n).map_or(zero, |row| pool.neg(row[j]));
                vec![place, if i == j { one } else { velocity }, zero]
            });
        }
        entries
    }

    /// What the velocities of coordinates that follow owe to the places of all coordinates, one row a coordinate; `None` where they owe nothing.
    pub(crate) fn drift_of_all(&self, pool: &Pool) -> Option<Rows> {
        if vanish(&self.drift) && self.first.is_empty() {
            return None;
        }
        let count = self.free.len() + self.bound.len();
        let mut all = vec![vec![pool.zero(); count]; count];
        for (row, i) in self.drift.iter().zip(&self.bound) {
            for (entry, j) in row.iter().zip(self.free.iter().chain(&self.bound)) {
                all[*i][*j] = *entry;
            }
        }
        Some(all)
    }
}

impl Rolling {
    /// The linearised model under the conditions of `model.rolling` and, as multipliers, its constraints.
    ///
    /// # Errors
    /// Where a condition does not hold, they depend on each other, or what they leave open acts on the rest.
    pub(super) fn new(
        model: &mut Model,
        assembly: &Assembly,
        equilibrium: &Equilibrium,
        (visible, reactions): (usize, &[ExprId]),
    ) -> Result<Self, LinearizeError> {
        let span = model.rolling.first().map(|own| own.span).unwrap_or_default();
        let refused = |reason| LinearizeError::RollingNotCovered { reason, span };
        if model.coordinates.len() > MOST_COORDINATES {
            return Err(refused("more than 60 coordinates"));
        }
        let mut pool = model.pool.clone();
        let mut point = equilibrium_expressions(model, &mut pool, equilibrium);
        for (i, own) in model.coordinates.iter().enumerate().skip(visible) {
            point[i] = pool.symbol_expr(own.symbol);
        }
        model.pool = pool;
        by_hand::put_in_zeros(model, assembly, &mut point, |i| equilibrium.may_be_zero(i));
        let mut whole = matrices_at(model, model.pool.clone(), assembly, &point);
        let symbolic = SymbolicRolling::new(model, &mut whole, &point, &equilibrium.values, (visible, reactions))?;
        let slopes = symbolic.bound.iter().flat_map(|i| &symbolic.directions[*i]);
        let all = symbolic.matrices.iter().flatten().flatten().flatten().chain(slopes);
        let all = all.chain([&symbolic.drift, &symbolic.shifts, &symbolic.carried].into_iter().flatten().flatten());
        let all: Vec<ExprId> = all.copied().collect();
        let formulas = Formulas::new(model, &whole.pool, &all);
        let formulas = formulas.ok_or_else(|| refused("their matrices have no numbers there"))?;
        if let Some(missing) = formulas.missing(model) {
            return Err(super::missing_value(model, missing));
        }
        model.pool = whole.pool;
        Ok(Self { symbolic, formulas })
    }

    /// M, G, C, K and N column by column, where they are there, and the directions.
    pub(super) fn numbers<S: Enclosure>(
        &self,
        model: &Model,
        at: &[S],
        precision: S::Precision,
    ) -> Option<(Numbers<S>, Tangent<S>)> {
        let mut numbers = self.formulas.at(model, at, precision)?.into_iter();
        let n = self.symbolic.free.len();
        let matrices = self.matrices(&mut numbers);
        let slopes = self.symbolic.bound.iter().map(|_| numbers.by_ref().take(n).collect()).collect();
        let (free, bound) = (self.symbolic.free.clone(), self.symbolic.bound.clone());
        Some((matrices, Tangent { free, bound, slopes }))
    }

    /// M, G, C, K and N from their numbers, which come row by row.
    fn matrices<S: Clone>(&self, numbers: &mut impl Iterator<Item = S>) -> Numbers<S> {
        let n = self.symbolic.free.len();
        self.symbolic.matrices.each_ref().map(|matrix| {
            matrix.as_ref()?;
            let rows: Vec<S> = numbers.by_ref().take(n * n).collect();
            Some((0..n * n).map(|at| rows[at / n + n * (at % n)].clone()).collect())
        })
    }

    /// How these change with a parameter, for an equilibrium that moves with it.
    pub(super) fn slopes(&self, model: &Model, at: &[Dual<Ball>], parameter: usize) -> Option<Numbers<Ball>> {
        let numbers = self.formulas.at_where(model, at, (), |number, value| varied(number, value, parameter))?;
        Some(self.matrices(&mut numbers.into_iter().map(|own| own.slope)))
    }

    /// How the forces of the conditions on the coordinates change with a parameter, likewise.
    pub(super) fn reaction_slopes(&self, model: &Model, at: &[Dual<Ball>], parameter: usize) -> Option<Vec<Ball>> {
        let SymbolicRolling { gradients, reactions, .. } = &self.symbolic;
        let count = gradients.first().map_or(0, Vec::len);
        let all: Vec<ExprId> = reactions.iter().chain(gradients.iter().flatten()).copied().collect();
        let formulas = Formulas::new(model, &model.pool, &all)?;
        let numbers = formulas.at_where(model, at, (), |number, value| varied(number, value, parameter))?;
        let (reactions, gradients) = numbers.split_at(reactions.len());
        let mut forces = vec![Dual::constant(Ball::ZERO, ()); count];
        for (reaction, row) in reactions.iter().zip(gradients.chunks(count.max(1))) {
            forces.iter_mut().zip(row).for_each(|(force, slope)| *force = force.add(&reaction.mul(slope)));
        }
        Some(forces.into_iter().map(|force| force.slope).collect())
    }

    /// For each coordinate that moves along a family of equilibria, by 1, how the free ones follow it so that no force acts; `None`
    /// where balls do not tell.
    pub(super) fn following(
        &self,
        model: &Model,
        at: &[Ball],
        [.., stiffness, circulatory]: &Numbers<Ball>,
    ) -> Option<Vec<Vec<Ball>>> {
        let (n, count) = (self.symbolic.free.len(), self.symbolic.moved.len());
        if count == 0 {
            return Some(Vec::new());
        }
        let held = sum(stiffness.clone(), circulatory.clone());
        let held = held.unwrap_or_else(|| vec![Ball::ZERO; n * n]);
        let [_, shifts, _] = self.beside(model, at)?;
        let one = |place: usize| {
            let force: Vec<Ball> = (0..n).map(|row| -shifts[row * count + place]).collect();
            if force.iter().all(Ball::is_zero) {
                return Some(force);
            }
            let row = |row: usize| (0..n).map(|j| held[row + n * j]).chain([force[row]]).collect();
            constrained::solve((0..n).map(row).collect(), ())
        };
        (0..count).map(one).collect()
    }

    /// The direction of each family of equilibria: of what moves and what goes with it, and what follows.
    pub(super) fn families(
        &self,
        model: &Model,
        at: &[Ball],
        following: &[Vec<Ball>],
        tangent: &Tangent<Ball>,
    ) -> Option<Vec<Vec<Ball>>> {
        let SymbolicRolling { free, bound, moved, .. } = &self.symbolic;
        let [.., carried] = self.beside(model, at)?;
        let family = |(place, following): (usize, &Vec<Ball>)| {
            let mut vector = vec![Ball::ZERO; free.len() + bound.len()];
            free.iter().zip(following).for_each(|(i, y)| vector[*i] = *y);
            for ((i, slopes), carried) in bound.iter().zip(&tangent.slopes).zip(carried.chunks(moved.len())) {
                let own = carried[place];
                vector[*i] = slopes.iter().zip(following).fold(own, |sum, (slope, y)| sum + *slope * *y);
            }
            vector
        };
        Some(following.iter().enumerate().map(family).collect())
    }

    /// The numbers of -β and -γ, of what forces come with coordinates along families, and of what goes with these; row by row.
    fn beside(&self, model: &Model, at: &[Ball]) -> Option<[Vec<Ball>; 3]> {
        let SymbolicRolling { drift, shifts, carried, .. } = &self.symbolic;
        let mut numbers = self.formulas.at(model, at, ())?;
        let mut last = |rows: &Rows| numbers.split_off(numbers.len() - rows.iter().map(Vec::len).sum::<usize>());
        let (carried, shifts) = (last(carried), last(shifts));
        Some([last(drift), shifts, carried])
    }

    /// Whether some velocities are not made of velocities alone.
    pub(super) fn drifts(&self) -> bool {
        !vanish(&self.symbolic.drift) || !self.symbolic.first.is_empty()
    }

    /// How the velocities of those that follow come of the others' places and of their own; one row each, and none where they do not.
    pub(super) fn drift(&self, model: &Model, at: &[Ball]) -> Option<Vec<Vec<Ball>>> {
        let [drift, ..] = self.beside(model, at)?;
        let width = self.symbolic.free.len() + self.symbolic.bound.len();
        Some(drift.chunks(width).map(<[Ball]>::to_vec).collect())
    }

    /// Whether every exponent s has a partner -s, as motions run backward are motions: where a change of sign of some
    /// coordinates leaves M and K + N as they are and turns G + C round.
    pub(super) fn runs_backward(&self) -> bool {
        let n = self.symbolic.free.len();
        let [mass, gyroscopic, damping, stiffness, circulatory] = &self.symbolic.matrices;
        let joins = |matrices: [&Option<Rows>; 3], i: usize, j: usize| {
            matrices.into_iter().flatten().any(|rows| !rows[i][j].is_zero() || !rows[j][i].is_zero())
        };
        let mut turned: Vec<Option<bool>> = vec![None; n];
        for first in 0..n {
            if turned[first].is_some() {
                continue;
            }
            turned[first] = Some(false);
            let mut todo = vec![first];
            while let Some(i) = todo.pop() {
                for j in 0..n {
                    let alike = i != j && joins([mass, stiffness, circulatory], i, j);
                    let opposite = joins([gyroscopic, damping, &None], i, j);
                    let wanted = match (alike, opposite) {
                        (true, true) => return false,
                        (false, false) => continue,
                        (_, opposite) => turned[i].map(|own| own != opposite),
                    };
                    if turned[j].is_none() {
                        turned[j] = wanted;
                        todo.push(j);
                    } else if turned[j] != wanted {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Vectors of the kernel of K + N that are single coordinates.
    pub(super) fn unheld(&self) -> Vec<Vec<Ball>> {
        let n = self.symbolic.free.len();
        let [.., stiffness, circulatory] = &self.symbolic.matrices;
        let both = [stiffness, circulatory].into_iter().flatten();
        let held = |i: usize| both.clone().any(|rows| rows.iter().any(|row| !row[i].is_zero()));
        let unit = |i: usize| (0..n).map(|j| if i == j { Ball::ONE } else { Ball::ZERO }).collect();
        (0..n).filter(|i| !held(*i)).map(unit).collect()
    }
}
