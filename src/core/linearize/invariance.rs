//! Whether a linear map of the displacements and velocities leaves the energies unchanged, identically.
//!
//! T - V, the dissipation function, the power of generalised forces in virtual velocities and constraints are written out
//! about the equilibrium q0, with the values of the parameters or without, and the map is put in: most terms become each other at once, and the difference of the others is tested
//! at random points modulo a prime. What that does not decide counts as no symmetry.
//!
//! An equilibrium that was searched for is put in with a symbol for each magnitude, the same for coordinates whose
//! enclosures meet, and one more where its centre is not 0; fractions of small numbers stand for themselves. An
//! identity in these symbols holds for whatever numbers they are.
//!
//! Roots in roots are beyond that field: two that are equal may differ there in their signs. Where the energies are those of
//! the coordinates themselves they are tried at points near the equilibrium, too, in numbers of a thousand bits.

use hashbrown::HashMap;

use super::assemble::signed_terms;
use super::equilibrium::Origin;
use super::parameters::known_values;
use super::steady::put_rates_in;
use super::symbolic::{forces_of, written_out};
use super::symmetry::spaces;
use super::{Linearized, Structure, precise};

use crate::expr::{ExprId, ModularPoint, PRIME, Pool, Substitution, Symbol, Tape};
use crate::model::{Model, TermFamily};
use crate::number::Number;
use crate::order::Gather;
use crate::precision::{Ball, Big, Scalar};

/// Energies of more terms are not written out.
const MOST_TERMS: usize = 50_000;
/// Coordinates that are not known better than this tell no symmetry.
const WIDEST: f64 = 1e-9;
/// Fractions up to this denominator stand for themselves in an equilibrium that was searched for.
const MOST_DENOMINATOR: i64 = 24;

/// Places that agree to so many bits are equal.
const BITS: usize = 1024;

/// Beside the size of the equilibrium: how far from it energies are tried, at so many points.
const NEARBY: f64 = 0.1;
const NEARBY_POINTS: u64 = 4;

/// Where each coordinate goes under a linear map: the coordinates and their factors.
type Images = Vec<Vec<(usize, ExprId)>>;

/// Bodies at different places, all of whose coordinates there are.
pub(crate) struct Bodies {
    /// By axis, of which there are two or three: the coordinate of each body.
    pub(crate) axes: Vec<Vec<usize>>,
    /// By body: its place about the centre of all, an element of the prime field an axis.
    pub(crate) places: Vec<Vec<u64>>,
}

/// The energies of a model about its equilibrium.
pub(crate) struct Invariance {
    model: Model,
    /// What is put in for parameters.
    known: Substitution,
    equilibrium: Vec<ExprId>,
    /// T - V, the dissipation function and the power of generalised forces, the symbols of coordinates standing for
    /// displacements: made when asked for.
    energies: Option<[ExprId; 3]>,
    /// Of each coordinate in that power.
    virtual_velocities: Vec<Symbol>,
    /// What constraints set to zero, in the same way.
    constraints: Vec<ExprId>,
    /// A point at which all has a value, and about which more is tried in numbers of many bits; may be empty.
    near: Vec<Big>,
}

impl Linearized {
    /// The energies at the values of the parameters; `None` where they are not all there is.
    pub(crate) fn invariance(&self) -> Option<Invariance> {
        let steady = self.structure() != Structure::Conservative && self.rates().iter().any(|rate| !rate.is_zero());
        if steady {
            return None;
        }
        let known = known_values(&self.model);
        let mut own = Invariance::at(self.model.clone(), known, Vec::new())?;
        own.equilibrium = own.places(&self.equilibrium.values, &self.equilibrium.origins)?;
        // Constraints are looked at themselves, not their multipliers.
        for i in self.coordinates()..own.equilibrium.len() {
            own.equilibrium[i] = own.model.pool.zero();
            own.known.insert(own.model.coordinates.at(i).symbol, own.equilibrium[i]);
        }
        Some(own)
    }

    /// The same about the origin of all coordinates, so that displacements are these themselves.
    /// What stays undecided in the field of a prime is tried near this point.
    pub(crate) fn energies_anywhere(&self, near: &[Big]) -> Option<Invariance> {
        let known = known_values(&self.model);
        let mut own = Invariance::at(self.model.clone(), known, Vec::new())?;
        own.near = near.to_vec();
        own.equilibrium = vec![own.model.pool.zero(); self.model.coordinates.len()];
        Some(own)
    }

    /// The coordinates of several bodies in a plane or in space, by axis, where these are all there are and energies are
    /// all there is.
    pub(crate) fn axes_of_bodies(&self) -> Option<Vec<Vec<usize>>> {
        let whole = !self.is_constrained() && self.structure() == Structure::Conservative;
        axes_of_bodies(&self.model).filter(|_| whole)
    }

    /// The equilibrium in numbers of many bits, where it is exact or proved, and energies alone hold it.
    pub(crate) fn exact_equilibrium(&self) -> Option<Vec<Big>> {
        let found = &self.equilibrium;
        if self.unbalanced.is_some() {
            return None;
        }
        let values = self.assembly.values::<Big>(&self.model, BITS.max(found.bits())).ok()?;
        let at = precise::equilibrium(&self.model, &self.assembly, found, &values)?;
        let size = at.iter().map(|own| own.mid_f64().abs()).fold(0.0, f64::max);
        let is_known = |own: &Big| own.to_ball().radius <= WIDEST * size;
        (found.proved && at.iter().all(is_known)).then_some(at)
    }
}

/// The coordinates of several bodies in a plane or in space, by axis, where these are all there are.
fn axes_of_bodies(model: &Model) -> Option<Vec<Vec<usize>>> {
    let count = model.coordinates.len();
    spaces(model).into_iter().find(|axes| {
        let bodies = axes.first().map_or(0, Vec::len);
        (2..=3).contains(&axes.len()) && bodies > 1 && bodies * axes.len() == count
    })
}

impl Invariance {
    /// The energies of a model, whose pool has these expressions too, at an equilibrium in symbols.
    pub(crate) fn new(mut model: Model, known: Substitution, equilibrium: Vec<ExprId>) -> Option<Self> {
        let variables: Vec<_> = model.coordinates.iter().map(|own| own.symbol).collect();
        let symbols = model.pool.symbols_of(&equilibrium);
        if symbols.iter().any(|symbol| variables.contains(symbol)) {
            return None;
        }
        put_rates_in(&mut model).ok()?;
        Self::at(model, known, equilibrium)
    }

    fn at(mut model: Model, known: Substitution, equilibrium: Vec<ExprId>) -> Option<Self> {
        let terms = |families: &[TermFamily]| families.iter().map(|own| own.count).sum::<usize>();
        let count = terms(&model.kinetic) + terms(&model.potential) + terms(&model.forces);
        if !model.rolling.is_empty() || model.time_dependent.is_some() || count > MOST_TERMS {
            return None;
        }
        let forced = if model.force.is_some() { model.coordinates.len() } else { 0 };
        let virtual_velocities = (0..forced).map(|_| model.pool.fresh_symbol("virtual")).collect();
        let (energies, constraints, near) = (None, Vec::new(), Vec::new());
        Some(Self { model, known, equilibrium, energies, virtual_velocities, constraints, near })
    }

    /// Expressions for an equilibrium in numbers.
    fn places(&mut self, values: &[Ball], origins: &[Origin]) -> Option<Vec<ExprId>> {
        let size = values.iter().map(Ball::abs_upper).fold(0.0, f64::max);
        if values.iter().any(|own| own.radius > WIDEST * size) {
            return None;
        }
        let mut places = vec![self.model.pool.zero(); values.len()];
        for (i, origin) in origins.iter().enumerate() {
            if *origin == Origin::Given {
                places[i] = self.model.equilibria.get(i).and_then(|given| given.value)?;
            }
        }
        let mut axes: Vec<Vec<usize>> = spaces(&self.model).into_iter().flatten().collect();
        axes.push((0..values.len()).collect());
        let mut open: Vec<bool> = origins.iter().map(|own| *own == Origin::Found).collect();
        let mut magnitudes: Vec<(Ball, ExprId)> = Vec::new();
        for axis in axes {
            if axis.is_empty() || !axis.iter().all(|i| open[*i]) {
                continue;
            }
            let sum = axis.iter().fold(Ball::ZERO, |sum, i| sum.add(&values[*i]));
            let count = Number::from(i64::try_from(axis.len()).ok()?);
            let centre = sum.div(&Ball::from_number(&count, ()));
            let middle = self.magnitude(&centre, &mut magnitudes);
            for i in axis {
                let own = self.magnitude(&values[i].sub(&centre), &mut magnitudes);
                places[i] = self.model.pool.add(middle, own);
                open[i] = false;
            }
        }
        for i in (0..values.len()).filter(|i| open[*i]) {
            places[i] = self.magnitude(&values[i], &mut magnitudes);
        }
        Some(places)
    }

    /// A small fraction, or the symbol of a magnitude with its sign.
    fn magnitude(&mut self, value: &Ball, known: &mut Vec<(Ball, ExprId)>) -> ExprId {
        let pool = &mut self.model.pool;
        for denominator in 1..=MOST_DENOMINATOR {
            let numerator = (value.mid_f64() * denominator as f64).round();
            let near = Number::from(numerator as i64).div(&Number::from(denominator));
            if let Some(near) = near
                && value.sub(&Ball::from_number(&near, ())).contains_zero()
            {
                return pool.number(near);
            }
        }
        let size = value.abs();
        let met = known.iter().find(|(other, _)| other.sub(&size).contains_zero());
        let own = match met {
            Some((_, own)) => *own,
            None => {
                let symbol = pool.fresh_symbol("place");
                let own = pool.symbol_expr(symbol);
                known.push((size, own));
                own
            }
        };
        if value.is_negative() { pool.neg(own) } else { own }
    }

    fn energies(&mut self) -> [ExprId; 3] {
        if let Some(energies) = self.energies {
            return energies;
        }
        let model = &self.model;
        let mut pool = model.pool.clone();
        let mut displaced = Vec::with_capacity(self.equilibrium.len());
        for (own, at) in model.coordinates.iter().zip(&self.equilibrium) {
            let displacement = pool.symbol_expr(own.symbol);
            displaced.push(pool.add(*at, displacement));
        }
        let friction = model.forces.iter().filter(|family| family.acts_on.is_none()).map(|family| (false, family));
        let lists: [Vec<(bool, &TermFamily)>; 2] = [signed_terms(model).collect(), friction.collect()];
        let [energy, friction] =
            lists.map(|families| written_out(model, &mut pool, families.into_iter(), Some(&displaced), &self.known));
        let mut power = Vec::new();
        for family in &model.forces {
            let forces = forces_of(model, &mut pool, family).into_iter();
            power.extend(forces.map(|(i, force)| pool.times(force, self.virtual_velocities[i])));
        }
        let mut rest = vec![pool.sum(&power)];
        rest.extend(model.constraints.iter().map(|own| own.expression));
        let about = model.coordinates.iter().map(|own| own.symbol).zip(displaced);
        let rest = pool.substitute(&rest, &about.gather());
        let mut rest = pool.substitute(&rest, &self.known);
        self.constraints = rest.split_off(1);
        let power = rest[0];
        self.model.pool = pool;
        *self.energies.insert([energy, friction, power])
    }

    /// Whether a linear map of the displacements and velocities, which may shift some displacements besides, leaves the
    /// energies unchanged, identically; `None` where that is not decided.
    fn holds(&mut self, images: &Images, shifts: &[(usize, ExprId)]) -> Option<bool> {
        let before = self.energies();
        let pool = &mut self.model.pool;
        let mut map = Substitution::default();
        let all = &self.model.coordinates;
        for (i, (own, image)) in all.iter().zip(images).enumerate() {
            let shift = shifts.iter().filter(|(at, _)| *at == i).map(|(_, shift)| *shift);
            let (mut displacement, mut velocity) = (shift.collect::<Vec<ExprId>>(), Vec::new());
            for (j, factor) in image {
                displacement.push(pool.times(*factor, all.at(*j).symbol));
                velocity.push(pool.times(*factor, all.at(*j).velocity));
            }
            map.insert(own.symbol, pool.sum(&displacement));
            map.insert(own.velocity, pool.sum(&velocity));
            if let Some(own) = self.virtual_velocities.get(i) {
                let velocity = image.iter().map(|(j, factor)| pool.times(*factor, self.virtual_velocities[*j]));
                let velocity: Vec<ExprId> = velocity.collect();
                map.insert(*own, pool.sum(&velocity));
            }
        }
        let after = pool.substitute(&before, &map);
        let pairs = before.into_iter().zip(after);
        let mut differences: Vec<(ExprId, ExprId)> =
            pairs.map(|(before, after)| (before, pool.sub(after, before))).collect();
        // Each constraint becomes one of them, or its opposite.
        let after = pool.substitute(&self.constraints, &map);
        let residues = |all: &[ExprId]| pool.evaluate_mod(all, |symbol| ModularPoint::random_value(7, symbol), 7);
        let (old, new) = (residues(&self.constraints)?, residues(&after)?);
        for (after, residue) in after.into_iter().zip(new) {
            let is_met = |own: &u64| *own == residue || *own == (PRIME - residue) % PRIME;
            let met = old.iter().position(is_met)?;
            let before = self.constraints[met];
            let difference = if old[met] == residue { pool.sub(after, before) } else { pool.add(after, before) };
            differences.push((before, difference));
        }
        for (before, difference) in differences {
            // A first point tells most of what is no symmetry.
            let value = |symbol| ModularPoint::random_value(7, symbol);
            let point = pool.evaluate_mod(&[difference], value, 7);
            let may_vanish = point.is_none_or(|point| point.first() == Some(&0));
            if may_vanish && pool.vanishes(difference) {
                continue;
            }
            let places = self.model.coordinates.iter().map(|own| own.symbol).zip(&self.near).collect();
            if !vanishes_near(pool, &places, before, difference)? {
                return Some(false);
            }
        }
        Some(true)
    }

    /// Whether the energies stay where each coordinate goes to another one, or to its opposite; `None` where that is not
    /// decided.
    pub(crate) fn permuted(&mut self, image: impl Fn(usize) -> (usize, bool)) -> Option<bool> {
        let pool = &mut self.model.pool;
        let one = pool.one();
        let opposite = pool.neg(one);
        let images = (0..self.model.coordinates.len()).map(|i| {
            let (to, negative) = image(i);
            vec![(to, if negative { opposite } else { one })]
        });
        self.holds(&images.collect(), &[])
    }

    /// Whether every turn in the plane of two axes leaves the energies unchanged; `None` where that is not
    /// decided.
    pub(crate) fn turns_freely(&mut self, a: &[usize], b: &[usize]) -> Option<bool> {
        let pool = &mut self.model.pool;
        let angle = pool.fresh_symbol("turn");
        let angle = pool.symbol_expr(angle);
        let (cosine, sine, one) = (pool.cos(angle), pool.sin(angle), pool.one());
        let opposite = pool.neg(sine);
        let mut images: Images = (0..self.model.coordinates.len()).map(|i| vec![(i, one)]).collect();
        for (i, j) in a.iter().zip(b) {
            images[*i] = vec![(*i, cosine), (*j, opposite)];
            images[*j] = vec![(*j, cosine), (*i, sine)];
        }
        self.holds(&images, &[])
    }

    /// Whether the energies stay when some coordinates grow by as much; `None` where that is not decided.
    pub(crate) fn shifts_freely(&mut self, axis: &[usize]) -> Option<bool> {
        let pool = &mut self.model.pool;
        let shift = pool.fresh_symbol("shift");
        let (shift, one) = (pool.symbol_expr(shift), pool.one());
        let images: Images = (0..self.model.coordinates.len()).map(|i| vec![(i, one)]).collect();
        let shifts: Vec<(usize, ExprId)> = axis.iter().map(|i| (*i, shift)).collect();
        self.holds(&images, &shifts)
    }

    /// The bodies, where the coordinates are those of several in a plane or in space, at different places.
    pub(crate) fn bodies(&mut self) -> Option<Bodies> {
        let axes = axes_of_bodies(&self.model)?;
        let bodies = axes.first().map_or(0, Vec::len);
        let pool = &mut self.model.pool;
        let mut about = Vec::new();
        let share = Number::ONE.div(&Number::from(i64::try_from(bodies).ok()?))?;
        for axis in &axes {
            let places: Vec<ExprId> = axis.iter().map(|i| self.equilibrium[*i]).collect();
            let places = pool.substitute(&places, &self.known);
            let sum = pool.sum(&places);
            let centre = pool.scale(sum, &share);
            about.extend(places.into_iter().map(|place| pool.sub(place, centre)));
        }
        let value = |symbol| ModularPoint::random_value(11, symbol);
        let residues = pool.evaluate_mod(&about, value, 11)?;
        let places: Vec<Vec<u64>> =
            (0..bodies).map(|a| residues.iter().skip(a).step_by(bodies).copied().collect()).collect();
        (places.iter().distinct().len() == bodies).then_some(Bodies { axes, places })
    }
}

/// Whether an expression vanishes at points near places, beside another one, to so many bits that it is 0; `None` where some of
/// the points say neither.
fn vanishes_near(pool: &Pool, places: &HashMap<Symbol, &Big>, beside: ExprId, expression: ExprId) -> Option<bool> {
    let size = places.values().map(|own| own.mid_f64().abs()).fold(0.0, f64::max);
    if size == 0.0 {
        return None;
    }
    let both = [expression, beside];
    let symbols = pool.symbols_of(&both);
    let tape = Tape::compile(pool, &both, &symbols).ok()?;
    let exact = tape.prepare::<Big>(BITS);
    for seed in 0..NEARBY_POINTS {
        let input = |symbol: &Symbol| {
            let random = ModularPoint::random_value(seed, *symbol) as f64 / PRIME as f64 - 0.5;
            let step = Big::from_f64(random * NEARBY * size, BITS);
            places.get(symbol).map_or_else(|| step.clone(), |place| place.add(&step))
        };
        let inputs: Vec<Big> = symbols.iter().map(input).collect();
        // Few bits tell most of what is no symmetry.
        let rough: Vec<Ball> = inputs.iter().map(|own| own.to_ball()).collect();
        let rough = tape.evaluate(&rough, &mut Vec::new());
        if rough.first().is_some_and(|value| value.is_finite() && !value.contains_zero()) {
            return Some(false);
        }
        let [value, scale] = exact.evaluate(&inputs, &mut Vec::new()).try_into().ok()?;
        if !value.is_finite() || !scale.is_finite() {
            return None;
        }
        if !value.contains_zero() {
            return Some(false);
        }
        // All but the last bits.
        let upper = |own: &Big| Big::from_magnitude(own.abs_upper(), BITS);
        if !upper(&value).scale(BITS as i64 / 2).sub(&upper(&scale)).is_negative() {
            return None;
        }
    }
    Some(true)
}
