//! What is conserved: momenta of cyclic coordinates, sums of momenta, the energy, and what reduced equations are derivatives of.
//!
//! A motion q -> q + e xi(q) that leaves L unchanged has the constant sum of xi_i p_i (Noether's theorem; Landau
//! and Lifshitz, Mechanics, §7 and §9). Looked for are the same kinds as for zero modes (`linearize`): translations,
//! which are the common null space of the gradients of all that L consists of, and rotations of coordinates that come as
//! vectors. The null space is sampled modulo a prime; each motion is then proved to leave L as it is.

use std::collections::BTreeMap;

use super::independent::Independent;
use super::lagrangian::{Lagrangian, Variables};
use super::motion::{Motion, MotionSum, MotionTerm};
use super::simplify::Algebra;
use crate::expr::{ExprId, Pool, fraction_mod};
use crate::linearize::{Rotation, candidate_rotations, nullspace_mod, rotation_name, translation_name};
use crate::model::Model;
use crate::number::Number;
use crate::order::Order;

/// Sums of more momenta than this tell nobody anything.
const MOST_COORDINATES: usize = 64;

/// What stays the same along every motion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Conserved {
    /// The momentum of a cyclic coordinate, by its number: the coordinate doesn't occur in L.
    Momentum(usize),
    /// The energy function h = sum q' dL/dq' - L: the time doesn't occur in L.
    Energy {
        /// Whether it is T + V: no part of T is without velocities or linear in them. `None` where these are parts of an L that is given
        /// as a whole, which does not say what T is.
        is_total: Option<bool>,
    },
    /// A sum of momenta: L is unchanged by a motion of several coordinates (Noether's theorem).
    Motion {
        /// What the motion is, in words: `translation of r along x`, `rotation about z`.
        motion: String,
        /// The sum over [`Motion::Momentum`], with coordinates for coefficients in a rotation.
        momenta: MotionSum,
        /// The same in velocities.
        value: MotionSum,
    },
    /// What an equation in independent velocities is the derivative of, by the number of its coordinate.
    Integral {
        /// The coordinate whose acceleration the equation is for.
        coordinate: usize,
        /// A sum of velocities and coordinates.
        value: MotionSum,
    },
}

/// What the equations in independent velocities are derivatives of where all that stands beside accelerations and velocities, those
/// that follow included, are constants; but for momenta that are known to be conserved.
pub(super) fn integrals(
    pool: &mut Algebra<'_>,
    variables: &Variables,
    reduced: &Independent,
    known: &[Conserved],
) -> Vec<Conserved> {
    let (coordinates, velocities) = (&variables.coordinates, &variables.velocities);
    let no_velocities = variables.at_rest(pool);
    let state =
        |symbol| coordinates.contains(&symbol) || velocities.contains(&symbol) || variables.time == Some(symbol);
    let mut found = Vec::new();
    'equations: for (coordinate, equation) in reduced.free.iter().zip(&reduced.equations) {
        let mut places = Vec::new();
        let mut load = equation.at_constant_rates(pool, velocities);
        // Multiples of velocities that follow and have a part without velocities.
        for (i, speed) in &reduced.follows {
            let speed = speed.at_constant_rates(pool, velocities);
            let [rest, own] = [load, speed].map(|e| pool.substitute_one(e, &no_velocities));
            if pool.vanishes(rest) || pool.vanishes(own) {
                continue;
            }
            let ratio = pool.short(|pool| pool.div(rest, own));
            if !pool.depends_on(ratio, &state) {
                let share = pool.mul(ratio, speed);
                load = pool.sub(load, share);
                places.push((*i, ratio));
            }
        }
        let mut parts: BTreeMap<Vec<(Motion, u32)>, Vec<ExprId>> = BTreeMap::new();
        for i in &reduced.free {
            let slope = pool.diff(load, velocities[*i]);
            let slope = pool.short(|_| slope);
            let share = pool.times(slope, velocities[*i]);
            load = pool.sub(load, share);
            places.extend((!pool.vanishes(slope)).then_some((*i, slope)));
            let inertia = equation.coefficient(pool, Motion::Acceleration(*i));
            if pool.depends_on(inertia, &state) {
                continue 'equations;
            }
            if !inertia.is_zero() {
                parts.insert(vec![(Motion::Velocity(*i), 1)], vec![inertia]);
            }
        }
        if !pool.vanishes(load) || places.iter().any(|(_, factor)| pool.depends_on(*factor, &state)) {
            continue;
        }
        let momentum = |own: &Conserved| matches!(own, Conserved::Momentum(i) if i == coordinate);
        if places.is_empty() && (parts.is_empty() || parts.len() == 1 && known.iter().any(momentum)) {
            continue;
        }
        for (i, factor) in places {
            parts.entry(Vec::new()).or_default().push(pool.times(factor, coordinates[i]));
        }
        found.push(Conserved::Integral { coordinate: *coordinate, value: MotionSum::of_parts(pool, parts) });
    }
    found
}

/// The conserved quantities that L shows: momenta of coordinates that don't occur in it, sums of momenta for
/// motions that leave it unchanged, and the energy where the time doesn't occur: the work of other forces is not examined.
pub(super) fn conserved(
    pool: &mut Algebra<'_>,
    variables: &Variables,
    lagrangian: &Lagrangian,
    momenta: &[MotionSum],
    model: &Model,
) -> Vec<Conserved> {
    let mut occurs = vec![false; variables.coordinates.len()];
    let mut drives = false;
    let values = lagrangian.inertia.values().chain(lagrangian.linear.values());
    let all = values.chain(&lagrangian.potential).chain(&lagrangian.other);
    for symbol in pool.symbols_of(&all.copied().collect::<Vec<_>>()) {
        if let Some(i) = variables.symbols.coordinate(symbol) {
            occurs[i] = true;
        }
        drives |= variables.time == Some(symbol);
    }
    let mut rubs = vec![false; occurs.len()];
    lagrangian.drags.iter().for_each(|(i, drag)| rubs[*i] |= !drag.is_zero());
    let cyclic = (0..occurs.len()).filter(|i| !occurs[*i] && !rubs[*i] && !momenta[*i].is_zero());
    let mut result: Vec<Conserved> = cyclic.map(Conserved::Momentum).collect();
    let moving: Vec<usize> = (0..occurs.len()).filter(|i| occurs[*i]).collect();
    if moving.len() > 1 && occurs.len() <= MOST_COORDINATES {
        let mut search = Search { model, pool: &mut *pool, variables, lagrangian };
        for (motion, generator) in search.generators(&moving) {
            let (momenta, value) = sum_of_momenta(pool, &generator, momenta);
            result.push(Conserved::Motion { motion, momenta, value });
        }
    }
    if !drives {
        let is_total = lagrangian.other.is_empty() && lagrangian.linear.is_empty() && !lagrangian.has_rest_energy;
        let is_total = (is_total || !model.lagrangian).then_some(is_total);
        result.push(Conserved::Energy { is_total });
    }
    result
}

/// By coordinate: a derivative, or the velocity in a motion.
type Slopes = Vec<(usize, ExprId)>;

struct Search<'a> {
    model: &'a Model,
    pool: &'a mut Pool,
    variables: &'a Variables,
    lagrangian: &'a Lagrangian,
}

impl Search<'_> {
    /// The motions of several coordinates that leave L unchanged, with their names.
    fn generators(&mut self, moving: &[usize]) -> Vec<(String, Slopes)> {
        let mut found = Vec::new();
        for vector in self.translations(moving) {
            let name = translation_name(self.model, &vector);
            let moved = vector.into_iter().enumerate().filter(|(_, x)| !x.is_zero());
            let generator: Slopes = moved.map(|(i, value)| (i, self.pool.number(value))).collect();
            if self.rubs_nowhere(&generator) {
                found.push((name, generator));
            }
        }
        for rotation in candidate_rotations(self.model) {
            let Some(generator) = self.rotation(&rotation, moving) else { continue };
            if self.rubs_nowhere(&generator) {
                found.push((rotation_name(self.model, &rotation), generator));
            }
        }
        found
    }

    /// The gradients by the coordinates of all that L consists of, one by one.
    fn gradients(&mut self) -> Vec<Slopes> {
        let all = self.lagrangian.inertia.values().chain(self.lagrangian.linear.values());
        let all: Vec<ExprId> = all.chain(&self.lagrangian.other).copied().collect();
        let slopes =
            all.into_iter().map(|e| self.variables.symbols.slopes(self.pool, e)).filter(|slopes| !slopes.is_empty());
        slopes.collect()
    }

    /// Constant vectors along which nothing in L changes.
    fn translations(&mut self, moving: &[usize]) -> Vec<Vec<Number>> {
        let forces: Slopes = self.lagrangian.forces.iter().map(|(i, f)| (*i, *f)).collect();
        let mut rows = Vec::new();
        if self.sample(&forces, moving, &mut rows).is_none() || nullspace_mod(&rows, moving.len()).is_empty() {
            return Vec::new();
        }
        let mut gradients = self.gradients();
        for slopes in &gradients {
            if self.sample(slopes, moving, &mut rows).is_none() {
                return Vec::new();
            }
        }
        gradients.push(forces);
        let count = self.variables.coordinates.len();
        let kernel = nullspace_mod(&rows, moving.len());
        let exact = kernel.iter().filter_map(|vector| {
            let mut exact = vec![Number::ZERO; count];
            for (i, residue) in moving.iter().zip(vector) {
                exact[*i] = fraction_mod(*residue)?;
            }
            Some(exact)
        });
        let exact: Vec<Vec<Number>> = exact.collect();
        let holds = |vector: &Vec<Number>| {
            gradients.iter().all(|slopes| {
                // A multiplier stays as it is.
                let terms = slopes.iter().filter_map(|(i, slope)| Some((*slope, vector.get(*i)?.clone())));
                let sum = self.pool.linear(&terms.collect::<Vec<_>>());
                self.pool.vanishes(sum)
            })
        };
        exact.into_iter().filter(holds).collect()
    }

    /// Rows of a gradient at random points modulo a prime, as many as it can have independent ones, and two more.
    fn sample(&self, slopes: &Slopes, columns: &[usize], rows: &mut Vec<Vec<u64>>) -> Option<()> {
        let roots: Vec<ExprId> = slopes.iter().map(|(_, slope)| *slope).collect();
        for point in 0..slopes.len() as u64 + 2 {
            let values = self.pool.evaluate_at_random(&roots, point)?;
            let mut row = vec![0; columns.len()];
            for ((i, _), value) in slopes.iter().zip(values) {
                if let Ok(at) = columns.binary_search(i) {
                    row[at] = value;
                }
            }
            rows.push(row);
        }
        Some(())
    }

    /// The velocities of a rotation, if L does not change: the sum of xi_i dL/dq_i + xi_i' dL/dq_i' is 0.
    fn rotation(&mut self, rotation: &Rotation, moving: &[usize]) -> Option<Slopes> {
        let parts = rotation.parts();
        // What does not occur in L does not turn with the others.
        if !parts.iter().any(|(i, _, _)| moving.binary_search(i).is_ok()) {
            return None;
        }
        let signed = |pool: &mut Pool, symbol, minus: bool| {
            let e = pool.symbol_expr(symbol);
            if minus { pool.neg(e) } else { e }
        };
        let mut at: BTreeMap<usize, (ExprId, ExprId)> = BTreeMap::new();
        for (i, partner, minus) in parts {
            let place = signed(self.pool, *self.variables.coordinates.get(partner)?, minus);
            let velocity = signed(self.pool, *self.variables.velocities.get(partner)?, minus);
            at.insert(i, (place, velocity));
        }
        let forces = self.lagrangian.forces.iter();
        let change: Vec<ExprId> = forces.filter_map(|(i, force)| Some(self.pool.mul(at.get(i)?.0, *force))).collect();
        // Cheap, and mostly the end of it.
        let sum = self.pool.sum(&change);
        if !self.pool.vanishes(sum) {
            return None;
        }
        let mut terms = self.lagrangian.other.clone();
        for ((i, j), a) in &self.lagrangian.inertia {
            let [u, v] = [i, j].map(|i| self.pool.symbol_expr(self.variables.velocities[*i]));
            let product = self.pool.product(&[*a, u, v]);
            terms.push(if i == j { self.pool.scale(product, &Number::half()) } else { product });
        }
        for (i, b) in &self.lagrangian.linear {
            terms.push(self.pool.times(*b, self.variables.velocities[*i]));
        }
        let mut change = Vec::new();
        for term in terms {
            let slopes = self.variables.symbols.slopes(self.pool, term).into_iter();
            change.extend(slopes.filter_map(|(k, slope)| Some(self.pool.mul(at.get(&k)?.0, slope))));
            let slopes = self.variables.symbols.velocity_slopes(self.pool, term).into_iter();
            change.extend(slopes.filter_map(|(k, slope)| Some(self.pool.mul(at.get(&k)?.1, slope))));
        }
        let sum = self.pool.sum(&change);
        if !self.pool.vanishes(sum) {
            return None;
        }
        // Of each plane first the velocity without a minus.
        let mut ordered = rotation.parts();
        ordered.order_by_key(|(i, partner, minus)| (*i.min(partner), *minus));
        Some(ordered.into_iter().filter_map(|(i, _, _)| Some((i, at.get(&i)?.0))).collect())
    }

    /// Whether friction and other forces do no work along a motion: the sum of xi_i (dF/dq_i' - Q_i) is 0.
    fn rubs_nowhere(&mut self, generator: &Slopes) -> bool {
        let drags = self.lagrangian.drags.iter();
        let terms = drags.filter_map(|(i, drag)| {
            let (_, xi) = generator.iter().find(|(own, _)| own == i)?;
            Some(self.pool.mul(*xi, *drag))
        });
        let terms: Vec<ExprId> = terms.collect();
        let sum = self.pool.sum(&terms);
        self.pool.vanishes(sum)
    }
}

/// The sum of xi_i p_i, in momenta and in velocities.
fn sum_of_momenta(pool: &mut Algebra<'_>, generator: &Slopes, momenta: &[MotionSum]) -> (MotionSum, MotionSum) {
    let mut named = Vec::new();
    let mut parts: BTreeMap<Vec<(Motion, u32)>, Vec<ExprId>> = BTreeMap::new();
    for (i, xi) in generator {
        named.push(MotionTerm::new(*xi, &[(Motion::Momentum(*i), 1)]));
        for term in momenta.get(*i).iter().flat_map(|sum| &sum.terms) {
            let value = pool.mul(*xi, term.coefficient);
            let value = if term.negative { pool.neg(value) } else { value };
            parts.entry(term.motion.clone()).or_default().push(value);
        }
    }
    let mut named = MotionSum::new(pool, named);
    // In the order of the motion: x p_y - y p_x, axis by axis.
    let place = |term: &MotionTerm| {
        let own = |i: usize| generator.iter().position(|(other, _)| *other == i);
        term.motion.first().and_then(|(motion, _)| if let Motion::Momentum(i) = motion { own(*i) } else { None })
    };
    named.terms.order_by_key(place);
    (named, MotionSum::of_parts(pool, parts))
}
