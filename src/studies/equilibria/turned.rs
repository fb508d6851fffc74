//! Rotations of all bodies together that change neither forces nor the potential. Of equilibria that they carry about one is searched for: with
//! the first body on an axis, the second in a plane through it.
//!
//! The forces that are left out so vanish with the others. Torques vanish everywhere, so that they do where the bodies that are held have a
//! distance from the axis of the rotation; and an equilibrium in the slice at which one has none is carried along the slice, unless all
//! bodies lie on that axis: half a turn about it changes the sign of the forces across it alone. What is proved to be alone in the slice is thus
//! an equilibrium, and alone in space if all bodies lie at the centre.

use librate_core::linearize::AtRest;
use librate_core::model::Model;
use librate_core::precision::{Ball, sum_of_products};

use super::interval::Interval;
use super::moments::{Component, along, bodies, turn};

/// Steps of an angle, all the way round, at which bodies that are carried out of the box are looked for inside.
const STEPS: usize = 24;

/// Rotations in a plane or in space.
#[derive(Default)]
pub(super) struct Rotations {
    /// The coordinates of each body along the axes that turn into each other, by number; none where nothing turns.
    bodies: Vec<Vec<usize>>,
    /// Coordinates that are held at 0, by number.
    pub(super) held: Vec<usize>,
}

impl Rotations {
    /// Those of a model without constraints, in a box that is as wide along each axis and has its centre at 0; it is widened by what the corners
    /// reach.
    pub(super) fn new(model: &Model, searched: &[usize], rest: &mut AtRest, whole: &mut [Interval]) -> Self {
        if !rest.constraints.is_empty() {
            return Self::default();
        }
        // The index of a single vector tells its components.
        let mut found = [1, 0].into_iter().map(|least| bodies(model, searched, least));
        let Some((axes, places)) = found.find_map(|(components, places)| {
            let axes = axes(&components, &places, rest);
            (!axes.is_empty()).then_some((axes, places))
        }) else {
            return Self::default();
        };
        let mut keys: Vec<&Vec<usize>> = places.iter().map(|own| &own.1).collect();
        keys.sort_unstable();
        keys.dedup();
        let place = |axis: &Component, key: &Vec<usize>| places.iter().position(|own| own.0 == *axis && own.1 == *key);
        let at = |key: &&Vec<usize>| axes.iter().map(|axis| place(axis, key)).collect::<Option<Vec<usize>>>();
        let bodies: Vec<Vec<usize>> = keys.iter().filter_map(at).collect();
        let half = bodies.iter().flatten().next().map_or(0.0, |at| whole[*at].hi);
        if bodies.iter().flatten().any(|at| whole[*at].lo != -half || whole[*at].hi != half) {
            return Self::default();
        }
        let reach = (half * (axes.len() as f64).sqrt()).next_up();
        bodies.iter().flatten().for_each(|at| whole[*at] = Interval::new(-reach, reach));
        let mut held = Vec::new();
        for (number, body) in bodies.iter().take(axes.len() - 1).enumerate() {
            let (zero, rest) = body.split_at(axes.len() - 1 - number);
            held.extend(zero.iter().map(|at| searched[*at]));
            if let Some(at) = rest.first() {
                whole[*at] = Interval::new(0.0, reach);
            }
        }
        let numbers = |body: &Vec<usize>| body.iter().map(|at| searched[*at]).collect();
        Self { bodies: bodies.iter().map(numbers).collect(), held }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Whether all bodies lie, or may lie, at the centre.
    pub(super) fn fix(&self, point: &[Ball]) -> bool {
        self.bodies.iter().flatten().all(|at| point[*at].contains_zero())
    }

    /// `rotation changes`, before `nothing`.
    pub(super) fn words(&self) -> &'static str {
        if self.bodies.first().is_some_and(|body| body.len() == 2) { "rotation changes" } else { "rotations change" }
    }

    /// Whether two points have the same distances and angles between bodies, and go the same way round, and agree in what does not turn, as far
    /// as they are known.
    pub(super) fn may_carry(&self, a: &[Ball], b: &[Ball]) -> bool {
        let body = |at: usize, point: &[Ball]| self.bodies[at].iter().map(|at| point[*at]).collect::<Vec<Ball>>();
        let alike = |of: &dyn Fn(&[Ball]) -> Ball| (of(a) - of(b)).contains_zero();
        let turns = |at: usize| self.bodies.iter().flatten().any(|own| *own == at);
        let all = 0..self.bodies.len();
        !self.is_empty()
            && (0..a.len()).all(|at| turns(at) || alike(&|point| point[at]))
            && all.clone().all(|i| {
                (i..all.end).all(|j| {
                    let cross = |point: &[Ball]| cross(&body(i, point), &body(j, point));
                    alike(&|point| sum_of_products(&body(i, point), &body(j, point), ()))
                        && match self.bodies[i].len() {
                            2 => alike(&|point| cross(point)[2]),
                            _ => (j..all.end)
                                .all(|k| alike(&|point| sum_of_products(&cross(point), &body(k, point), ()))),
                        }
                })
            })
    }

    /// A point as it is, then turned.
    pub(super) fn orientations(&self, point: &[Ball]) -> impl Iterator<Item = Vec<Ball>> {
        let axes = self.bodies.first().map_or(0, Vec::len);
        let steps = |is_free: bool| 0..if is_free { STEPS } else { 1 };
        let angles = steps(axes > 2)
            .flat_map(move |a| steps(axes > 2).flat_map(move |b| steps(axes > 1).map(move |c| [a, b, c])));
        let angle = |step: usize| Ball::PI.scale(1) * Ball::from(step as f64) / Ball::from(STEPS as f64);
        angles.map(move |[a, b, c]| {
            let mut turned = point.to_vec();
            for (step, [i, j]) in [(c, [0, 1]), (b, [0, 2]), (a, [0, 1])] {
                if step == 0 {
                    continue;
                }
                let (sin, cos) = (angle(step).sin(), angle(step).cos());
                for body in &self.bodies {
                    let (x, y) = (turned[body[i]], turned[body[j]]);
                    (turned[body[i]], turned[body[j]]) = (cos * x - sin * y, sin * x + cos * y);
                }
            }
            turned
        })
    }
}

/// The components that turn into each other: none, two or three.
fn axes(components: &[Component], places: &[(Component, Vec<usize>)], rest: &mut AtRest) -> Vec<Component> {
    let mut is_symmetry = |first: Component, second: Component| {
        let field = turn(places, [first, second], rest);
        field.is_some_and(|field| {
            let torque = along(rest, &field);
            rest.pool.vanishes(torque)
        })
    };
    for (number, first) in components.iter().enumerate() {
        let others = &components[number + 1..];
        let turned: Vec<Component> =
            others.iter().copied().filter(|other| is_symmetry(*first, *other)).take(2).collect();
        if !turned.is_empty() {
            return [vec![*first], turned].concat();
        }
    }
    Vec::new()
}

/// In space; vectors in the plane have no third component.
fn cross(a: &[Ball], b: &[Ball]) -> [Ball; 3] {
    let of = |v: &[Ball], i: usize| v.get(i).copied().unwrap_or(Ball::ZERO);
    [[1, 2], [2, 0], [0, 1]].map(|[i, j]| of(a, i) * of(b, j) - of(a, j) * of(b, i))
}
