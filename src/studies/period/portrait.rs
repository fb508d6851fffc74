//! Phase portraits: curves of constant energy in the plane of a coordinate and its velocity.
//!
//! What divides the plane is proved: the equilibria, and with the unstable ones the energies that separate motions of different kinds. The
//! curves are points in doubles, for pictures.

use librate_core::expr::Tape;
use librate_core::model::Model;
use librate_core::modes::Stability;
use librate_core::order::Order;
use librate_core::precision::Ball;

use super::energies::{Energies, check};
use crate::equilibria::Found;

/// Places at which it is searched for where motion is allowed, ...
const PLACES: usize = 2_000;
/// ... and along each piece of a curve.
const POINTS: usize = 80;
/// Energies below the highest of those that separate, and as many above.
const LEVELS: u32 = 5;
/// Steps between places that are smaller than this part of the depth of a potential are rounding.
const FLAT: f64 = 1e-12;
/// Halvings of the way to a turning point.
const HALVINGS: usize = 60;

/// What motions of one energy do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Course {
    /// To and fro between two turning points.
    Bound,
    /// Out of the range of the coordinate, which for a rotation is round and round.
    Leaving,
    /// Towards an unstable equilibrium.
    Separatrix,
}

/// A curve of constant energy.
#[derive(Clone, Debug)]
pub struct Orbit {
    /// The energy as a value of U = V - T0, in J.
    pub energy: f64,
    /// What such a motion does.
    pub course: Course,
    /// Coordinate and velocity, in SI, in the order of the curve.
    pub points: Vec<[f64; 2]>,
}

struct Plane {
    /// U and M from the coordinate and the energy.
    tape: Tape,
    ends: [f64; 2],
}

/// The phase portrait of one coordinate over its range in a box, whose equilibria are known; none where energy is not conserved or
/// the equation of energy can't be solved for the velocity.
#[must_use]
pub fn portrait(model: &Model, found: &Found) -> Vec<Orbit> {
    let [Some(ends)] = found.region.sides.as_slice() else { return Vec::new() };
    let Some(plane) = Plane::new(model, ends.each_ref().map(Ball::mid_f64)) else { return Vec::new() };
    let heights = |stable: bool| {
        let own = found.equilibria.iter().filter(move |own| (own.stability == Stability::Stable) == stable);
        own.filter_map(|own| own.point.first()).map(|q| plane.height(q.mid_f64())).filter(|height| height.is_finite())
    };
    let mut separating: Vec<f64> = heights(false).collect();
    separating.order_by(f64::total_cmp);
    let across = plane.places().map(|q| plane.height(q)).filter(|height| height.is_finite());
    let lowest = across.clone().chain(heights(true)).fold(f64::INFINITY, f64::min);
    let top = separating.last().copied().unwrap_or_else(|| {
        // Between two walls, what reaches the lower of them; else what is there.
        let walls = ends.each_ref().map(|q| plane.height(q.mid_f64())).into_iter().filter(|height| height.is_finite());
        let lower = walls.fold(f64::INFINITY, f64::min);
        if lower > lowest && lower.is_finite() { lower } else { across.fold(lowest, f64::max) }
    });
    let size = top - lowest;
    if !(size > 0.0 && size.is_finite()) {
        return Vec::new();
    }
    separating.dedup_by(|a, b| (*a - *b).abs() <= 1e-9 * size);
    // Velocities rise in equal steps.
    let steps = (1..2 * LEVELS).map(|step| f64::from(step) / f64::from(LEVELS));
    let is_new = |level: &f64| separating.iter().all(|own| (own - level).abs() > 0.02 * size);
    let mut levels: Vec<f64> = steps.map(|step| lowest + size * step * step).filter(is_new).collect();
    // No well is empty.
    for bottom in heights(true) {
        let rim = separating.iter().copied().find(|own| *own > bottom + 1e-9 * size);
        if let Some(rim) = rim.filter(|rim| levels.iter().all(|own| !(bottom..*rim).contains(own))) {
            levels.push(0.5 * (bottom + rim));
        }
    }
    let mut orbits: Vec<Orbit> = Vec::new();
    for energy in levels {
        plane.orbits(energy, &[], &mut orbits);
    }
    let others = found.equilibria.iter().filter(|own| own.stability != Stability::Stable);
    let tops: Vec<f64> = others.filter_map(|own| own.point.first()).map(Ball::mid_f64).collect();
    for energy in separating.iter().copied() {
        let is_here = |q: &f64| (plane.height(*q) - energy).abs() <= 2e-9 * size;
        let here: Vec<f64> = tops.iter().copied().filter(is_here).collect();
        plane.orbits(energy, &here, &mut orbits);
    }
    orbits
}

/// How many hills of the potential a motion passes between its turning points, in doubles, for pictures: where this changes over the energy, there
/// is a separatrix.
#[must_use]
pub fn hills(model: &Model, turning: [f64; 2]) -> usize {
    let Some(plane) = Plane::new(model, turning) else { return 0 };
    let heights: Vec<f64> = plane.places().map(|q| plane.height(q)).filter(|height| height.is_finite()).collect();
    let depth = heights.iter().fold(0.0, |depth: f64, height| depth.max(heights[0] - height));
    let steps = heights.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| step.abs() > FLAT * depth);
    let rises: Vec<bool> = steps.map(|step| step > 0.0).collect();
    rises.windows(2).filter(|pair| pair[0] && !pair[1]).count()
}

impl Plane {
    fn new(model: &Model, ends: [f64; 2]) -> Option<Self> {
        check(model).ok()?;
        let energies = Energies::new(model).ok()?;
        let roots = energies.roots();
        let tape = Tape::compile(&energies.pool, &roots, &[energies.coordinate, energies.energy]).ok()?;
        Some(Self { tape, ends })
    }

    fn places(&self) -> impl Iterator<Item = f64> + Clone {
        let [from, to] = self.ends;
        (0..=PLACES).map(move |at| from + (to - from) * at as f64 / PLACES as f64)
    }

    fn height(&self, q: f64) -> f64 {
        self.at(q, 0.0)[0]
    }

    /// U and M.
    fn at(&self, q: f64, energy: f64) -> [f64; 2] {
        let own = self.tape.evaluate::<f64>(&[q, energy], &mut Vec::new());
        [0, 1].map(|at| own.get(at).copied().unwrap_or(f64::NAN))
    }

    /// The velocity; no number where such a motion does not come.
    fn speed(&self, q: f64, energy: f64) -> f64 {
        let [height, mass] = self.at(q, energy);
        (2.0 * (energy - height) / mass).sqrt()
    }

    /// The curves of an energy; those that reach one of the `tops` divide motions of different kinds, and end there.
    fn orbits(&self, energy: f64, tops: &[f64], into: &mut Vec<Orbit>) {
        let gap = (self.ends[1] - self.ends[0]) / PLACES as f64;
        let is_allowed = |q: f64| self.speed(q, energy).is_finite();
        let border = |mut inside: f64, mut outside: f64| {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (inside + outside);
                *if is_allowed(middle) { &mut inside } else { &mut outside } = middle;
            }
            inside
        };
        let mut before: Option<f64> = None;
        let mut start: Option<(f64, bool)> = None;
        let mut put = |[from, to]: [f64; 2], [starts, ends]: [bool; 2]| {
            let is_bound = starts && ends;
            // Close points where the velocity changes fast.
            let place = |at: usize| {
                let angle = std::f64::consts::PI * at as f64 / POINTS as f64;
                let q = 0.5 * (from + to) - 0.5 * (to - from) * angle.cos();
                let speed = self.speed(q, energy);
                let rests = at == 0 && starts || at == POINTS && ends;
                [
                    q,
                    if rests {
                        0.0
                    } else if at == 0 || at == POINTS {
                        speed.max(0.0)
                    } else {
                        speed
                    },
                ]
            };
            let upper: Vec<[f64; 2]> = (0..=POINTS).map(place).filter(|[_, v]| v.is_finite()).collect();
            let lower = upper.iter().rev().map(|[q, v]| [*q, -v]);
            let is_separating = tops.iter().any(|top| (from - gap..=to + gap).contains(top));
            let course = match (is_separating, is_bound) {
                (true, _) => Course::Separatrix,
                (false, true) => Course::Bound,
                (false, false) => Course::Leaving,
            };
            if is_bound {
                into.push(Orbit { energy, course, points: upper.iter().copied().chain(lower).collect() });
            } else {
                into.push(Orbit { energy, course, points: lower.collect() });
                into.push(Orbit { energy, course, points: upper });
            }
        };
        let mut put_all = |[from, to]: [f64; 2], [starts, ends]: [bool; 2]| {
            let inside = tops.iter().copied().filter(|top| from + gap < *top && *top < to - gap);
            let mut start = (from, starts);
            for top in inside {
                put([start.0, top], [start.1, true]);
                start = (top, true);
            }
            put([start.0, to], [start.1, ends]);
        };
        for q in self.places() {
            match (is_allowed(q), start, before) {
                (true, None, None) => start = Some((q, false)),
                (true, None, Some(before)) => start = Some((border(q, before), true)),
                (false, Some((from, turns)), Some(before)) => {
                    put_all([from, border(before, q)], [turns, true]);
                    start = None;
                }
                _ => {}
            }
            before = Some(q);
        }
        if let (Some((from, turns)), Some(last)) = (start, before) {
            put_all([from, last], [turns, false]);
        }
    }
}
