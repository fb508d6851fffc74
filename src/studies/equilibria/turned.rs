//! Rotations of all bodies together that change neither forces nor the potential. Of equilibria that they carry about one is searched for: with
//! the first body on an axis, the second in a plane through it.
//!
//! The forces that are left out so vanish with the others: torques vanish everywhere, and the bodies that are held have a distance from the
//! axis of the rotation. Where one may have none, it is an equilibrium if all bodies lie on that axis: half a turn about it changes the sign
//! of the forces across it alone. Elsewhere it is none if a force that is left out does not vanish, and else not decided.
//! What is proved to be alone in the slice is alone in space if all bodies lie at the centre.
//!
//! Where other bodies may change places with the first, it is the one farthest from the centre: equilibria in which another is are
//! these with the two exchanged.

use librate_core::expr::{ExprId, Prepared, Tape};
use librate_core::linearize::AtRest;
use librate_core::model::Model;
use librate_core::number::Number;
use librate_core::order::Gather;
use librate_core::precision::{Ball, Interval, Scalar, sum_of_products};

use super::forces::Equations;
use super::moments::{Component, along, bodies, turn};
use super::symmetric::{Element, is_symmetry};

/// Steps of an angle, all the way round, at which bodies that are carried out of the box are searched for inside.
const STEPS: usize = 24;

/// Rotations in a plane or in space.
#[derive(Default)]
pub(super) struct Rotations {
    /// The coordinates of each body along the axes that turn into each other, by number; none where nothing turns.
    bodies: Vec<Vec<usize>>,
    /// Coordinates that are held at 0, by number.
    pub(super) held: Vec<usize>,
    /// The forces along these.
    left_out: Option<Prepared<Ball>>,
    /// The coordinates that forces depend on, by number.
    searched: Vec<usize>,
    /// Bodies that may change places with the first one.
    exchanged: Vec<Exchange>,
}

/// A body that may change places with the first one.
struct Exchange {
    body: usize,
    /// The coordinates that do, by number.
    pairs: Vec<[usize; 2]>,
}

/// Places of unknowns: of a body, and of bodies that are no farther from the centre.
pub(super) struct Farthest {
    first: usize,
    others: Vec<Vec<usize>>,
}

impl Farthest {
    /// What is left of a piece; false where that is nothing.
    pub(super) fn contract(&self, piece: &mut [Interval]) -> bool {
        let reach = piece[self.first].hi;
        let mut least = Interval::new(0.0, f64::INFINITY);
        for body in &self.others {
            for at in body {
                piece[*at] = piece[*at].meet(&Interval::new(-reach, reach));
            }
            let square = body.iter().fold(Interval::point(0.0), |sum, at| sum.add(&piece[*at].powi(2)));
            least.lo = least.lo.max(square.sqrt().lo);
        }
        piece[self.first] = piece[self.first].meet(&least);
        piece.iter().all(|own| !own.is_empty())
    }

    /// Whether bodies that are exchanged stay so under a symmetry.
    pub(super) fn is_kept(&self, element: &Element) -> bool {
        element[self.first] == (self.first, false)
            && self.others.iter().all(|body| {
                let there = |other: &Vec<usize>| body.iter().all(|at| other.contains(&element[*at].0));
                self.others.iter().any(|other| other.len() == body.len() && there(other))
            })
    }
}

impl Rotations {
    /// Those of a model without constraints in which forces have a potential, in a box that is as wide along each axis and has its centre at 0; it is widened by what the corners
    /// reach.
    pub(super) fn new(model: &Model, searched: &[usize], rest: &mut AtRest, whole: &mut [Interval]) -> Self {
        if !rest.constraints.is_empty() || rest.others.iter().any(|own| *own != rest.pool.zero()) {
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
        let mut keys = places.iter().map(|own| &own.1).distinct();
        let place = |axis: &Component, key: &Vec<usize>| places.iter().position(|own| own.0 == *axis && own.1 == *key);
        keys.retain(|key| axes.iter().all(|axis| place(axis, key).is_some()));
        let at = |key: &&Vec<usize>| axes.iter().filter_map(|axis| place(axis, key)).collect();
        let bodies: Vec<Vec<usize>> = keys.iter().map(at).collect();
        let mut equations = Equations::new(rest, &Number::ONE);
        equations.all.push(rest.potential);
        let mut exchange = |body: usize| {
            let pair = [keys[0], keys[body]];
            let to = |(component, key): &(Component, Vec<usize>)| {
                let other = pair.iter().position(|own| *own == key).map_or(key, |at| pair[1 - at]);
                Some((place(component, other)?, false))
            };
            let element = places.iter().map(to).collect::<Option<Element>>()?;
            let pairs = element.iter().enumerate().filter(|(at, own)| *at < own.0);
            let pairs = pairs.map(|(at, own)| [searched[at], searched[own.0]]).collect();
            is_symmetry(&mut equations, whole, &element).then_some(Exchange { body, pairs })
        };
        let exchanged: Vec<Exchange> = (1..bodies.len()).filter_map(&mut exchange).collect();
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
        let own = |at: &usize| searched.iter().position(|number| number == at).map(|at| equations.all[at]);
        let forces: Vec<ExprId> = held.iter().filter_map(own).collect();
        let left_out = Tape::compile(&equations.pool, &forces, &equations.unknowns).ok().map(|tape| tape.prepare(()));
        let numbers = |body: &Vec<usize>| body.iter().map(|at| searched[*at]).collect();
        let bodies = bodies.iter().map(numbers).collect();
        Self { bodies, held, left_out, searched: searched.to_vec(), exchanged }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Whether the forces that are left out vanish where the others do; `None` where it is not decided.
    pub(super) fn is_equilibrium(&self, point: &[Ball]) -> Option<bool> {
        let Some(left_out) = &self.left_out else { return Some(true) };
        let at: Vec<Ball> = self.searched.iter().map(|at| point[*at]).collect();
        if !left_out.evaluate(&at, &mut Vec::new()).iter().all(Ball::contains_zero) {
            return Some(false);
        }
        let is_decided = |(number, body): (usize, &Vec<usize>)| {
            let across = body.len() - number;
            let is_on_axis = |body: &Vec<usize>| body[..across].iter().all(|at| point[*at].contains_zero());
            !point[body[across - 1]].contains_zero() || self.bodies.iter().all(is_on_axis)
        };
        let axes = self.bodies.first().map_or(1, Vec::len);
        self.bodies.iter().take(axes - 1).enumerate().all(is_decided).then_some(true)
    }

    /// Of the unknowns that are searched for, by number; `None` where the first body does not change places.
    pub(super) fn farthest(&self, searched: &[usize]) -> Option<Farthest> {
        let at = |number: &usize| searched.iter().position(|own| own == number);
        let body = |number: usize| self.bodies[number].iter().filter_map(at).collect::<Vec<usize>>();
        let first = *body(*self.exchanged.first().map(|_| &0)?).first()?;
        Some(Farthest { first, others: self.exchanged.iter().map(|own| body(own.body)).collect() })
    }

    /// A point as it is, then with the first body exchanged for others.
    pub(super) fn exchanges(&self, point: &[Ball]) -> Vec<Vec<Ball>> {
        let mut all = vec![point.to_vec()];
        for own in &self.exchanged {
            let mut point = point.to_vec();
            own.pairs.iter().for_each(|[a, b]| point.swap(*a, *b));
            all.push(point);
        }
        all
    }

    /// Whether all bodies lie, or may lie, at the centre.
    pub(super) fn fix(&self, point: &[Ball]) -> bool {
        self.bodies.iter().flatten().all(|at| point[*at].contains_zero())
    }

    /// Whether a coordinate turns into others.
    pub(super) fn turn(&self, at: usize) -> bool {
        self.bodies.iter().flatten().any(|own| *own == at)
    }

    /// Whether however bodies are turned, and with `moved` moved together, one of them is out of the box: farther from the centre than its
    /// corners, or from another one than these from each other.
    pub(super) fn stay_outside(&self, point: &[Ball], sides: &[Option<[Ball; 2]>], moved: bool) -> bool {
        let place = |body: &Vec<usize>| body.iter().map(|at| point[*at]).collect::<Vec<Ball>>();
        let square = |own: &[Ball]| own.iter().fold(Ball::ZERO, |sum, x| sum + *x * *x);
        let corner = |body: &Vec<usize>| -> Vec<Ball> {
            body.iter().map(|at| sides[*at].map_or(Ball::exact(f64::INFINITY), |[_, to]| to)).collect()
        };
        let is_beyond = |body: &Vec<usize>| (square(&place(body)) - square(&corner(body))).is_positive();
        let are_apart = |a: &Vec<usize>, b: &Vec<usize>| {
            let between: Vec<Ball> = place(a).iter().zip(place(b)).map(|(x, y)| *x - y).collect();
            (square(&between) - square(&corner(a)).scale(2)).is_positive()
        };
        !moved && self.bodies.iter().any(is_beyond)
            || self.bodies.iter().enumerate().any(|(i, a)| self.bodies[..i].iter().any(|b| are_apart(a, b)))
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
        let all = 0..self.bodies.len();
        !self.is_empty()
            && (0..a.len()).all(|at| self.turn(at) || alike(&|point| point[at]))
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
