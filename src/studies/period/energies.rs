//! U and M of a model of one coordinate, as expressions with all parameters put in, and what symmetry they have.

use std::collections::HashSet;

use super::PeriodError;
use super::panel::Kink;
use crate::mechanics::{Mechanics, beside_energies};
use librate_core::expr::{ExprId, Function, Node, Pool, Substitution, Symbol, Tape};
use librate_core::linearize::{evaluate_closed, known_values};
use librate_core::model::Model;
use librate_core::number::Number;
use librate_core::precision::{Ball, Scalar};

/// Smaller parts of a period are not searched for.
const PRIMES: [i64; 5] = [2, 3, 5, 7, 11];

/// L = 1/2 M(q) q'^2 + b(q) q' - U(q). The term in b is the derivative of a function of q by the time and moves nothing.
///
/// Where L has more powers of q', as of a relativistic mass, q'² = 2 (E - U)/M with an M that depends on E - U as well: the
/// conserved q' dL/dq' - L is E, and -L at rest is U.
pub(super) struct Energies {
    pub(super) pool: Pool,
    pub(super) coordinate: Symbol,
    /// U = V - T0.
    pub(super) potential: ExprId,
    pub(super) mass: ExprId,
    /// E, where M depends on it.
    pub(super) energy: Symbol,
}

impl Kink<ExprId> {
    /// The same in numbers.
    pub(super) fn evaluated<S: Scalar>(&self, pool: &Pool, precision: S::Precision) -> Option<Kink<S>> {
        Some(Kink {
            place: evaluate_closed(pool, self.place, precision)?,
            slope: evaluate_closed(pool, self.slope, precision)?,
            central: self.central,
        })
    }
}

/// U and M, ready for evaluation.
pub(super) struct Kinked {
    /// U and M from the coordinate, the signs and E; `None` where a parameter is left.
    pub(super) tape: Option<Tape>,
    pub(super) kinks: Vec<Kink<ExprId>>,
    /// U with these signs.
    pub(super) potential: ExprId,
    pub(super) signs: Vec<Symbol>,
}

/// Refuses what has no period by energy conservation in one coordinate, before anything is computed.
///
/// # Errors
/// More coordinates than one, explicit time, friction, constraints and steady motions.
pub fn check(model: &Model) -> Result<(), PeriodError> {
    if model.coordinates.len() != 1 {
        return Err(PeriodError::NotOneCoordinate {
            count: model.coordinates.len(),
            span: model.coordinates.get(1).map(|second| second.span),
        });
    }
    if let Some((feature, span)) = beside_energies(model) {
        return Err(PeriodError::Unsupported { feature, span });
    }
    Ok(())
}

impl Energies {
    /// Of a model of one coordinate: see [`check`].
    pub(super) fn new(model: &Model) -> Result<Self, PeriodError> {
        let own = model.coordinates.at(0);
        let Mechanics { mut pool, lagrangian, .. } = Mechanics::new(model, model.pool.clone(), &known_values(model));
        let velocity = own.velocity;
        let once = pool.diff(lagrangian, velocity);
        let mass = pool.diff(once, velocity);
        let zero = pool.zero();
        let rest = Substitution::from([(velocity, zero)]);
        let lagrangian = pool.substitute_one(lagrangian, &rest);
        if pool.vanishes(mass) {
            return Err(PeriodError::NoInertia { coordinate: own.name(), span: own.span });
        }
        let potential = pool.neg(lagrangian);
        let energy = pool.fresh_symbol("E");
        let excess = pool.symbol_expr(energy);
        let excess = pool.sub(excess, potential);
        let mass = effective_mass(&mut pool, mass, velocity, excess)
            .ok_or_else(|| PeriodError::NotQuadratic { coordinate: own.name(), span: own.span })?;
        Ok(Self { mass, potential, coordinate: own.symbol, energy, pool })
    }

    /// U and M.
    pub(super) fn roots(&self) -> [ExprId; 2] {
        [self.potential, self.mass]
    }

    /// U and M as functions of the coordinate and of the signs of what absolute values are taken of, with the kinks of these.
    /// Where one is taken of what is not linear in the coordinate, all stay as they are. `center`: the equilibrium, where it is
    /// known exactly.
    pub(super) fn kinked(&mut self, center: Option<ExprId>) -> Kinked {
        let roots = self.roots();
        let q = self.coordinate;
        let (smooth, signs) = self.pool.with_signs(&roots, |symbol| symbol == q);
        let pool = &mut self.pool;
        let origin = Substitution::from([(q, pool.zero())]);
        let kinks = signs.iter().map(|(x, _)| {
            let slope = pool.diff(*x, q);
            let there = pool.substitute_one(*x, &origin);
            let place = pool.div(there, slope);
            let place = pool.neg(place);
            let central = center.is_some_and(|center| pool.agree(place, center));
            let linear = pool.is_constant(slope) && pool.is_constant(place);
            linear.then_some(Kink { place, slope, central })
        });
        let kinks = kinks.collect::<Option<Vec<_>>>().unwrap_or_default();
        let (roots, signs) = if kinks.is_empty() { (&roots[..], &[][..]) } else { (&smooth[..], &signs[..]) };
        let signs: Vec<Symbol> = signs.iter().map(|(_, sign)| *sign).collect();
        let inputs = [&[q], &signs[..], &[self.energy]].concat();
        Kinked { tape: Tape::compile(pool, roots, &inputs).ok(), kinks, potential: roots[0], signs }
    }

    /// Whether U and M are the same with q0 + x and q0 - x.
    pub(super) fn is_even_about(&mut self, centre: ExprId) -> bool {
        let pool = &mut self.pool;
        let q = pool.symbol_expr(self.coordinate);
        let mirrored = pool.linear(&[(centre, Number::from(2)), (q, Number::from(-1))]);
        self.is_unchanged(mirrored)
    }

    /// Whether U and M stay the same where the coordinate is replaced.
    fn is_unchanged(&mut self, replacement: ExprId) -> bool {
        let map = Substitution::from([(self.coordinate, replacement)]);
        let before = self.roots();
        let after = self.pool.substitute(&before, &map);
        before.iter().zip(after).all(|(before, after)| self.pool.agree(*before, after))
    }

    /// The shortest period of U and M in the coordinate that is found, a positive constant: where the coordinate occurs
    /// in sines, cosines and tangents of arguments a q + b with rational ratios of the a alone.
    pub(super) fn advance(&mut self) -> Option<ExprId> {
        let q = self.coordinate;
        let roots = self.roots();
        let mut inside: HashSet<ExprId> = HashSet::new();
        let mut rates = Vec::new();
        for function in self.pool.reachable(&roots) {
            let Node::Function(Function::Sin | Function::Cos | Function::Tan, argument) = *self.pool.node(function)
            else {
                continue;
            };
            if !self.pool.depends_on(argument, &|symbol| symbol == q) {
                continue;
            }
            let rate = self.pool.diff(argument, q);
            if self.pool.is_constant(rate) {
                inside.insert(function);
                rates.push(rate);
            }
        }
        let first = *rates.first()?;
        // Everything that depends on the coordinate does so through these functions.
        let (mut seen, mut todo) = (inside, roots.to_vec());
        while let Some(id) = todo.pop() {
            if self.pool.as_symbol(id) == Some(q) {
                return None;
            }
            if seen.insert(id) {
                self.pool.node(id).for_each_child(|child| todo.push(child));
            }
        }
        // The largest part of the first rate that all are whole multiples of.
        let mut part = Number::ZERO;
        for rate in rates {
            let ratio = self.pool.div(rate, first);
            part = part.gcd(self.pool.as_number(ratio)?);
        }
        let size = part.recip()?;
        let pool = &mut self.pool;
        let pi = pool.pi();
        let turn = pool.div(pi, first);
        let turn = pool.scale(turn, &size);
        let turn = pool.scale(turn, &Number::from(2));
        let mut advance = pool.abs(turn);
        // A square of a cosine has half the period.
        for prime in PRIMES {
            for _ in 0..8 {
                let shorter = self.pool.scale(advance, &Number::ratio(1, prime)?);
                let q = self.pool.symbol_expr(self.coordinate);
                let shifted = self.pool.add(q, shorter);
                if !self.is_unchanged(shifted) {
                    break;
                }
                advance = shorter;
            }
        }
        Some(advance)
    }
}

/// The M of q'² = 2 W/M, where W = E - U, from d²L/dq'²; `None` where it is of no kind that is solved:
/// - L = 1/2 m q'²: M = m;
/// - L = 1/2 m q'² + a q'⁴/24: W = 1/2 m q'² + a q'⁴/8, so that M = m/2 + sqrt(m²/4 + a W/2);
/// - L = -r sqrt(1 - m q'²/r), the relativistic one with r = m c²: W = r/sqrt(1 - m q'²/r) - r, so that
///   M = m (1 + W/r)²/(1 + W/(2 r)). With a constant r > 0 it is so for all W > 0.
fn effective_mass(pool: &mut Pool, curvature: ExprId, velocity: Symbol, excess: ExprId) -> Option<ExprId> {
    let rest = Substitution::from([(velocity, pool.zero())]);
    let third = pool.diff(curvature, velocity);
    let mass = pool.substitute_one(curvature, &rest);
    if pool.vanishes(third) {
        return Some(mass);
    }
    if pool.vanishes(mass) {
        return None;
    }
    let fourth = pool.diff(third, velocity);
    let fifth = pool.diff(fourth, velocity);
    let [odd, fourth] = [third, fourth].map(|e| pool.substitute_one(e, &rest));
    if !pool.vanishes(odd) {
        return None;
    }
    let square = pool.square(mass);
    if pool.vanishes(fifth) {
        let bend = pool.mul(fourth, excess);
        let under = pool.linear(&[(square, Number::ratio(1, 4)?), (bend, Number::half())]);
        let root = pool.sqrt(under);
        return Some(pool.linear(&[(mass, Number::half()), (root, Number::ONE)]));
    }
    let inverse = pool.div(fourth, square);
    let inverse = pool.scale(inverse, &Number::ratio(1, 3)?);
    if !evaluate_closed::<Ball>(pool, inverse, ())?.is_positive() {
        return None;
    }
    // (d²L/dq'²)² (1 - m q'²/r)³ = m².
    let q = pool.symbol_expr(velocity);
    let speed = pool.square(q);
    let speed = pool.product(&[mass, inverse, speed]);
    let one = pool.one();
    let under = pool.sub(one, speed);
    let under = pool.powi(under, 3);
    let left = pool.square(curvature);
    let left = pool.mul(left, under);
    if !pool.agree(left, square) {
        return None;
    }
    let share = pool.mul(inverse, excess);
    let above = pool.add(one, share);
    let below = pool.linear(&[(one, Number::ONE), (share, Number::half())]);
    let factors = [(mass, Number::ONE), (above, Number::from(2)), (below, Number::MINUS_ONE)];
    Some(pool.product_of_powers(&factors))
}
