//! Every equilibrium of a model in a box.
//!
//! The forces at rest are written out (`forces`) and a box is cut into pieces (`search`) until each is proved to have none, in
//! intervals (`interval`) and beside poles by a field that leads away from them (`poles`), or to have exactly one (`root`). What is
//! not decided is said, so that nothing is missed in silence. Where nothing changes along a direction, equilibria are searched for
//! in a slice across it, and their number is not counted.

mod bifurcation;
mod branches;
mod error;
mod forces;
mod landscape;
mod moments;
mod poles;
mod region;
mod root;
mod search;
mod stability;
mod symmetric;
mod turned;

pub use bifurcation::Kind;
pub use branches::{Bifurcation, Branch, Diagram, follow};
pub use error::EquilibriaError;
pub use landscape::{Landscape, landscape};
pub use region::Region;

use forces::{Equations, Evaluator, Forces, Neutral, gradient, neutral_directions};
use librate_core::expr::{self, ExprId, Substitution, Symbol, Tape};
use librate_core::linearize::{self, AtRest};
use librate_core::model::Model;
use librate_core::modes::Stability;
use librate_core::number::Number;
use librate_core::order::Order;
use librate_core::precision::{Ball, Interval, Scalar};
use moments::moments;
use root::{Root, are_within};
use search::{Findings, Search};
use symmetric::Symmetries;
use turned::Rotations;

/// The most coordinates and constraints.
const MOST_COORDINATES: usize = 64;
/// Undecided places that are examined one by one.
const MOST_EXAMPLES: usize = 20;
/// The most places that are named in words.
const MOST_NAMED: usize = 3;
/// A place smaller than this, beside the box, may be one equilibrium.
const SMALL: f64 = 1e-4;
/// Derivatives of a force of one coordinate that may vanish at an equilibrium.
const MOST_ORDER: usize = 8;
/// Functions without kinks, cuts and poles.
const SMOOTH: [&str; 7] = ["sin", "cos", "sinh", "cosh", "tanh", "exp", "atan"];
/// A range of one value is searched with so much on each side, beside its value.
const POINT: f64 = 1e-6;
/// Undecided pieces are gathered one by one up to so many.
const MOST_GATHERED: usize = 4000;

/// One equilibrium.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Equilibrium {
    /// The coordinates in SI, each enclosed.
    pub point: Vec<Ball>,
    /// Whether it is the only one near it; `None` where that is not decided.
    pub isolated: Option<bool>,
    /// What its modes say.
    pub stability: Stability,
    /// The frequency of each mode in rad/s, in the order of `modes`; none where it has no modes.
    pub omega: Vec<Ball>,
    /// The growth of each mode in 1/s.
    pub growth: Vec<Ball>,
}

impl Equilibrium {
    /// One whose modes are not known yet.
    fn new(point: Vec<Ball>, isolated: Option<bool>) -> Self {
        Self { point, isolated, stability: Stability::Undecided, omega: Vec::new(), growth: Vec::new() }
    }

    /// How far the coordinates, as doubles, are off at most.
    #[must_use]
    pub fn radius(&self) -> f64 {
        radius(&self.point)
    }
}

fn radius(point: &[Ball]) -> f64 {
    point.iter().map(Ball::mid_f64_error).fold(0.0, f64::max)
}

/// A place where it was not decided how many equilibria there are.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Undecided {
    /// Its middle.
    pub point: Vec<f64>,
    /// How far it reaches from there, in any coordinate.
    pub radius: f64,
}

/// The equilibria in a box.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Found {
    /// Where they were searched for.
    pub region: Region,
    /// Ordered by their coordinates.
    pub equilibria: Vec<Equilibrium>,
    /// Whether these are all, each alone.
    pub complete: bool,
    /// Whether these are all, or one of each family that symmetries or coordinates without forces make.
    pub decided: bool,
    /// Places that were not decided.
    pub undecided: Vec<Undecided>,
    /// Why it is not complete, in words.
    pub reasons: Vec<String>,
    /// How many pieces of the box were examined.
    pub pieces: usize,
}

/// Finds every equilibrium in a box. What the model says of `equilibrium` and `guess` is left aside; rates of steady motions count.
///
/// # Errors
/// A box without a range for a coordinate that something depends on, and models whose forces at rest can't be written out.
pub fn find(model: &Model, region: &Region) -> Result<Found, EquilibriaError> {
    let budget = model.pool.budget().clone();
    budget.at("the equilibria in the box", None);
    let model = &*linearize::integrated(model);
    let mut task = Task::new(model, region, None)?;
    let equations = task.equations();
    let mut forces = task.forces(&equations)?;
    let mut search = Search::new(&mut forces, Vec::new(), task.whole.clone());
    search.symmetries = Symmetries::new(model, &task.searched, (&equations, task.rest.potential), &task.whole)
        .with(task.rotations.farthest(&task.searched));
    search.moments = task.moments.take();
    let findings = search.run(&budget)?;
    let mut found = task.found(&findings, &mut forces);
    budget.at("the modes at each equilibrium", None);
    for own in &mut found.equilibria {
        stability::put_modes(model, own)?;
        budget.check()?;
    }
    task.put_examples(&mut found)?;
    Ok(found)
}

/// An equilibrium with the unknowns that it was found with.
struct Node {
    root: Root,
    equilibrium: Equilibrium,
}

/// What is searched for, and where.
struct Task<'a> {
    model: &'a Model,
    region: &'a Region,
    rest: AtRest,
    /// The coordinates that are unknown, by number.
    searched: Vec<usize>,
    /// Coordinates held somewhere, with the direction along which nothing changes.
    slices: Vec<Slice>,
    /// What may be turned.
    rotations: Rotations,
    /// Equations that follow from the others, where no parameter varies.
    moments: Option<Evaluator<Interval>>,
    /// Coordinates left out of the box.
    left_out: Vec<usize>,
    whole: Vec<Interval>,
    /// The value of the parameter that varies.
    parameters: Vec<Ball>,
}

/// A slice across a direction along which nothing changes.
struct Slice {
    /// The coordinate that is held.
    pivot: usize,
    /// Where.
    value: f64,
    /// By coordinate.
    direction: Vec<f64>,
}

impl<'a> Task<'a> {
    /// With one parameter, by its number, that varies from the value that the model has.
    fn new(model: &'a Model, region: &'a Region, varying: Option<usize>) -> Result<Self, EquilibriaError> {
        let count = model.coordinates.len() + model.constraints.len();
        if count > MOST_COORDINATES {
            return Err(EquilibriaError::TooLarge { coordinates: count, most: MOST_COORDINATES });
        }
        let mut rest = linearize::at_rest(model.clone(), varying.as_slice())?;
        let forces = gradient(&mut rest);
        if forces.iter().any(|force| rest.pool.is_undefined(*force)) {
            return Err(EquilibriaError::NoForces {});
        }
        let depends = |at: usize| {
            let own = rest.coordinates[at];
            let all = forces.iter().chain(&rest.constraints).copied();
            let force = !rest.pool.as_number(forces[at]).is_some_and(Number::is_zero);
            force || all.into_iter().any(|e| rest.pool.depends_on(e, &|symbol| symbol == own))
        };
        let missing: Vec<usize> = (0..region.sides.len()).filter(|at| region.sides[*at].is_none()).collect();
        let needed: Vec<String> =
            missing.iter().filter(|at| depends(**at)).map(|at| model.coordinates.at(*at).name()).collect();
        if !needed.is_empty() {
            return Err(EquilibriaError::MissingSide { coordinates: needed });
        }
        let turning: Vec<usize> = (0..region.sides.len()).filter(|at| rest.turning[*at]).collect();
        let left_out: Vec<usize> = missing.iter().copied().filter(|at| !rest.turning[*at]).collect();
        let aside = |at: &usize| missing.contains(at) || turning.contains(at);
        let mut searched: Vec<usize> = (0..region.sides.len()).filter(|at| !aside(at)).collect();
        rest.coordinates = searched.iter().map(|at| rest.coordinates[*at]).collect();
        rest.others = searched.iter().map(|at| rest.others[*at]).collect();
        let forces: Vec<ExprId> = searched.iter().map(|at| forces[*at]).collect();
        let neutral = neutral_directions(&mut rest, &forces);
        let mut whole: Vec<Interval> = Vec::new();
        for at in &searched {
            whole.extend(region.sides[*at].as_ref().map(|[from, to]| {
                let (from, to) = (from.lower(), to.upper());
                let room = if to - from > POINT * from.abs() { 0.0 } else { POINT * from.abs().max(1.0) };
                Interval::new(from - room, to + room)
            }));
        }
        let slices = slices(&neutral, &searched, &mut whole);
        let values =
            slices.iter().map(|slice| (slice.pivot, Number::from_f64_exact(slice.value).unwrap_or(Number::ZERO)));
        hold(&values.collect::<Vec<_>>(), &mut rest, &mut searched, &mut whole);
        let (mut rotations, mut sums) = (Rotations::default(), None);
        if varying.is_none() {
            rotations = Rotations::new(model, &searched, &mut rest, &mut whole);
            let all = (searched.clone(), rest.clone());
            let values: Vec<(usize, Number)> = rotations.held.iter().map(|at| (*at, Number::ZERO)).collect();
            let held = hold(&values, &mut rest, &mut searched, &mut whole);
            sums = moments(model, &all.0, &all.1, &held);
        }
        if !rest.constraints.is_empty() {
            whole.push(Interval::new(0.0, 1.0));
            whole.extend(rest.constraints.iter().map(|_| Interval::new(-1.0, 1.0)));
        }
        let value = |number: usize| linearize::constant(&model.pool, model.parameters[number].value?);
        let parameters = varying.and_then(value).into_iter().collect();
        Ok(Self { model, region, rest, searched, slices, rotations, moments: sums, left_out, whole, parameters })
    }

    fn equations(&self) -> Equations {
        Equations::new(&self.rest, &scale(&mut self.rest.clone(), &self.whole, &self.parameters))
    }

    fn forces(&self, equations: &Equations) -> Result<Forces, EquilibriaError> {
        Forces::new(equations, &self.rest).ok_or(EquilibriaError::NoForces {})
    }

    /// What a search found, in all coordinates.
    fn found(&self, findings: &Findings, forces: &mut Forces) -> Found {
        let mut equilibria: Vec<Equilibrium> = Vec::new();
        for own in self.nodes(findings).map(|node| node.equilibrium) {
            // The slice goes through a family on both sides of the centre.
            if !equilibria.iter().any(|other| self.rotations.may_carry(&other.point, &own.point)) {
                equilibria.push(own);
            }
        }
        let mut undecided = Vec::new();
        for place in self.undecided(findings) {
            // What lies in the region of a proved one is that.
            let is_new = |at: &Vec<Ball>| !findings.roots.iter().any(|root| are_within(at, &root.region));
            let is_centre = |at: &Vec<Ball>| self.rotations.fix(&self.embedded(at));
            let mut alone = false;
            if let Some(at) = self.exactly(&place.hull, forces).filter(is_new).filter(is_centre) {
                alone = self.is_only_one(&at, &place.hull);
                let isolated = |own: &bool| alone || !own;
                let placed = self.placed(&self.embedded(&at));
                equilibria.extend(placed.map(|own| Equilibrium { isolated: own.isolated.filter(isolated), ..own }));
            }
            if !alone {
                undecided.push(self.told(&place));
            }
        }
        sort(&mut equilibria);
        let mut reasons = Vec::new();
        if !equilibria.is_empty() {
            reasons.extend(self.neutral_words());
        }
        if !self.rotations.is_empty() && equilibria.iter().any(|own| own.isolated == Some(false)) {
            let words = self.rotations.words();
            reasons.push(format!("equilibria are not isolated: {words} nothing; of each family one is given"));
        }
        let pieces = findings.pieces;
        reasons.extend(undecided_words(self.model, &undecided, findings.is_cut_short, pieces));
        let complete = reasons.is_empty();
        let decided = undecided.is_empty() && !findings.is_cut_short;
        Found { region: self.region.clone(), equilibria, complete, decided, undecided, reasons, pieces }
    }

    fn told(&self, place: &Place) -> Undecided {
        let middle: Vec<f64> = place.first.iter().map(Interval::middle).collect();
        let reach = |(own, x): (&Interval, &f64)| (own.hi - x).max(x - own.lo);
        let radius = place.hull.iter().zip(&middle).take(self.searched.len()).map(reach).fold(0.0, f64::max);
        Undecided { point: self.shown(&middle), radius }
    }

    /// The equilibria in the box that are proved.
    fn nodes<'b>(&'b self, findings: &'b Findings) -> impl Iterator<Item = Node> {
        self.proved(findings).filter_map(|(root, at)| Some(Node { root: root.clone(), equilibrium: self.placed(&at)? }))
    }

    /// The equilibria that are proved, or one of the family that each belongs to.
    fn proved<'b>(&'b self, findings: &'b Findings) -> impl Iterator<Item = (&'b Root, Vec<Ball>)> {
        let inside = |root: &&Root| root.at.iter().zip(&self.sides()).all(|(x, side)| may_lie(x, side.as_ref()));
        // With all multipliers turned it is the same equilibrium.
        let counts = |root: &&Root| root.at.get(self.searched.len()).is_none_or(Ball::is_positive);
        let vanishes = |root: &&Root| self.rotations.is_equilibrium(&self.embedded(&root.at)) == Some(true);
        let proved = findings.roots.iter().filter(inside).filter(counts).filter(vanishes);
        let alike =
            |root: &'b Root| self.rotations.exchanges(&self.embedded(&root.at)).into_iter().map(move |at| (root, at));
        proved.flat_map(alike)
    }

    /// Places that a search did not decide.
    fn undecided(&self, findings: &Findings) -> Vec<Place> {
        // Gradients of constraints depend on each other where the multiplier of the forces is 0.
        let is_singular = |root: &&Root| root.at.get(self.searched.len()).is_some_and(Ball::contains_zero);
        let is_open = |root: &&Root| self.rotations.is_equilibrium(&self.embedded(&root.at)).is_none();
        let singular = findings.roots.iter().filter(|root| is_singular(root) || is_open(root)).map(|root| &root.region);
        // Of a family no member was found in the box, nor shown that none lies there.
        let may_be_inside = |at: &[Ball]| self.placed(at).is_none() && !self.stays_outside(at);
        let families = self.proved(findings).filter(|(_, at)| may_be_inside(at)).map(|(root, _)| &root.region);
        gathered(findings.undecided.iter().chain(singular).chain(families))
    }

    /// Whether no translation and no rotation that changes nothing brings an equilibrium into the box.
    fn stays_outside(&self, point: &[Ball]) -> bool {
        let sides = &self.region.sides;
        if self.rotations.stay_outside(point, sides, !self.slices.is_empty()) {
            return true;
        }
        self.slices.iter().enumerate().any(|(number, slice)| {
            let moves = |other: &Slice, at: usize| other.direction[at] != 0.0;
            let alone = |at: usize| self.slices.iter().enumerate().all(|(k, own)| (k == number) == moves(own, at));
            let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
            for at in (0..point.len()).filter(|at| alone(*at) && !self.rotations.turn(*at)) {
                let Some([from, to]) = sides[at] else { continue };
                let ends = [from, to].map(|end| (end - point[at]) / Ball::exact(slice.direction[at]));
                // The direction may be rounded.
                let slack = 1e-9 * (ends[0].abs_upper() + ends[1].abs_upper());
                least = least.max(ends[0].lower().min(ends[1].lower()) - slack);
                most = most.min(ends[0].upper().max(ends[1].upper()) + slack);
            }
            least > most
        })
    }

    /// The ranges of what is searched for; none where slices let it be further out.
    fn sides(&self) -> Vec<Option<[Ball; 2]>> {
        self.searched.iter().map(|at| self.region.sides[*at].filter(|_| !self.is_sliced())).collect()
    }

    /// Whether of equilibria that are not alone one is searched for.
    fn is_sliced(&self) -> bool {
        !self.slices.is_empty() || !self.rotations.is_empty()
    }

    /// All coordinates, from those that are searched for.
    fn embedded(&self, at: &[Ball]) -> Vec<Ball> {
        let mut point = vec![Ball::ZERO; self.region.sides.len()];
        for (number, value) in self.searched.iter().zip(at) {
            point[*number] = *value;
        }
        for slice in &self.slices {
            point[slice.pivot] = Ball::exact(slice.value);
        }
        point
    }

    /// The same in doubles.
    fn shown(&self, at: &[f64]) -> Vec<f64> {
        let balls: Vec<Ball> = at.iter().map(|x| Ball::exact(*x)).collect();
        self.embedded(&balls).iter().map(Ball::mid_f64).collect()
    }

    /// An equilibrium moved into the box along what changes nothing; `None` where it does not come there.
    fn placed(&self, own: &[Ball]) -> Option<Equilibrium> {
        let isolated = self.slices.is_empty() && self.left_out.is_empty() && self.rotations.fix(own);
        let point = self.rotations.orientations(own).find_map(|turned| self.shifted(turned))?;
        Some(Equilibrium::new(rounded(&point), Some(isolated)))
    }

    /// A point moved into the box along translations that change nothing.
    fn shifted(&self, mut point: Vec<Ball>) -> Option<Vec<Ball>> {
        for _ in 0..200 {
            for slice in &self.slices {
                let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
                for (x, (v, side)) in point.iter().zip(slice.direction.iter().zip(&self.region.sides)) {
                    let Some([from, to]) = side else { continue };
                    if *v != 0.0 {
                        let (a, b) = ((from.mid_f64() - x.mid_f64()) / v, (to.mid_f64() - x.mid_f64()) / v);
                        least = least.max(a.min(b));
                        most = most.min(a.max(b));
                    }
                }
                let by = if least <= most { 0.0_f64.clamp(least, most) } else { 0.5 * (least + most) };
                if by != 0.0 {
                    for (x, v) in point.iter_mut().zip(&slice.direction) {
                        *x = *x + Ball::exact(by) * Ball::exact(*v);
                    }
                }
            }
        }
        let inside = point.iter().zip(&self.region.sides).all(|(x, side)| match side {
            Some([from, to]) if self.is_sliced() => {
                let slack = 1e-9 * (*to - *from).abs_upper();
                x.mid_f64() >= from.mid_f64() - slack && x.mid_f64() <= to.mid_f64() + slack
            }
            Some(_) | None => true,
        });
        inside.then_some(point)
    }

    /// A place of an undecided piece at which the forces vanish, exactly.
    fn exactly(&self, place: &[Interval], forces: &mut Forces) -> Option<Vec<Ball>> {
        let small = place.iter().zip(&self.whole).all(|(own, whole)| own.width() < SMALL * whole.width());
        if !small {
            return None;
        }
        let own = |x: &Interval| if x.contains(0.0) { 0.0 } else { x.middle() };
        let at: Vec<Ball> = place.iter().map(|x| Ball::exact(own(x))).collect();
        let inputs: Vec<Ball> = at.iter().chain(&self.parameters).copied().collect();
        let force = forces.prepare::<Ball>().force(&inputs);
        let (_, equations) = force.split_last()?;
        equations.iter().all(Ball::is_zero).then_some(at)
    }

    /// Whether an equilibrium is the only one at a place of one coordinate: there the derivatives of the force vanish up to one that vanishes nowhere
    /// at the place.
    fn is_only_one(&self, at: &[Ball], place: &[Interval]) -> bool {
        let mut rest = self.rest.clone();
        let ([own], [x], [side], []) = (rest.coordinates.as_slice(), at, place, self.parameters.as_slice()) else {
            return false;
        };
        let (own, exact) = (*own, Number::from_f64_exact(x.mid_f64()).unwrap_or_default());
        let Some(mut slope) = gradient(&mut rest).first().copied() else { return false };
        // Kinks and cuts are lost in derivatives.
        let is_smooth = |e: ExprId| match rest.pool.node(e) {
            expr::Node::Function(function, _) => SMOOTH.contains(&function.name()),
            expr::Node::Product(powers) => {
                powers.iter().all(|(base, exponent)| exponent.is_integer() || rest.pool.as_number(*base).is_some())
            }
            expr::Node::Power { .. } | expr::Node::Atan2 { .. } => false,
            _ => true,
        };
        if !rest.pool.reachable(&[slope]).into_iter().all(is_smooth) {
            return false;
        }
        let there: Substitution = [(own, rest.pool.number(exact))].into_iter().collect();
        for _ in 0..MOST_ORDER {
            let value = rest.pool.substitute_one(slope, &there);
            if !rest.pool.vanishes(value) {
                let tape = Tape::compile(&rest.pool, &[slope], &[own]).ok();
                let range = tape.map(|tape| tape.prepare::<Interval>(()).evaluate(&[*side], &mut Vec::new()));
                return range.is_some_and(|range| range.iter().all(|own| own.is_finite() && !own.contains(0.0)));
            }
            slope = rest.pool.diff(slope, own);
        }
        false
    }

    /// One equilibrium of each undecided place that `modes` finds from there and proves, and along what it is not isolated.
    fn put_examples(&self, found: &mut Found) -> Result<(), EquilibriaError> {
        let mut told: Vec<String> = Vec::new();
        for place in found.undecided.iter().take(MOST_EXAMPLES) {
            let start: Vec<Ball> = place.point.iter().map(|x| Ball::exact(*x)).collect();
            let Some((mut own, motions)) = stability::nearby(self.model, &start)? else { continue };
            let reach = 2.0 * place.radius;
            let near = own.point.iter().zip(&start).all(|(x, y)| (*x - *y).abs_upper() <= reach);
            let inside = own.point.iter().zip(&self.region.sides).all(|(x, side)| may_lie(x, side.as_ref()));
            let same = |other: &Equilibrium| {
                let here = other.point.iter().zip(&own.point).all(|(x, y)| (*x - *y).contains_zero());
                here || self.rotations.may_carry(&other.point, &own.point)
            };
            if motions.is_empty() || !near || !inside {
                continue;
            }
            // Without a force to second order it may be alone: then nothing is known but that it is undecided.
            for motion in motions.iter().filter(|motion| *motion != linearize::NO_FORCE) {
                let words = format!("equilibria are not isolated: {motion} changes nothing; one of them is given");
                own.isolated = Some(false);
                let is_told = !self.rotations.is_empty() && motion.starts_with("rotation");
                if !is_told && !told.contains(&words) {
                    told.push(words);
                }
            }
            match found.equilibria.iter_mut().find(|other| same(other)) {
                Some(other) => other.isolated = other.isolated.or(own.isolated),
                None => found.equilibria.push(own),
            }
        }
        found.reasons.splice(0..0, told);
        sort(&mut found.equilibria);
        Ok(())
    }

    /// That equilibria are not isolated, and why.
    fn neutral_words(&self) -> Vec<String> {
        let name = |at: usize| self.model.coordinates.at(at).name();
        let left_out = |at: &usize| format!("equilibria are not isolated: nothing depends on `{}`", name(*at));
        let mut words: Vec<String> = self.left_out.iter().map(left_out).collect();
        for slice in &self.slices {
            let moved = slice.direction.iter().enumerate().filter_map(|(at, v)| match *v {
                0.0 => None,
                1.0 => Some(name(at)),
                v => Some(format!("{v} {}", name(at))),
            });
            let moved: Vec<String> = moved.collect();
            let what = match moved.as_slice() {
                [one] => format!("nothing depends on `{one}`"),
                _ => format!("moving {} together changes nothing", moved.join(", ")),
            };
            words.push(format!("equilibria are not isolated: {what}; of each family one is given"));
        }
        words
    }
}

/// Holds coordinates at values; what was put in for them.
fn hold(
    values: &[(usize, Number)],
    rest: &mut AtRest,
    searched: &mut Vec<usize>,
    whole: &mut Vec<Interval>,
) -> Substitution {
    let given = values.iter().filter_map(|(number, value)| {
        let place = searched.iter().position(|at| at == number)?;
        Some((rest.coordinates[place], rest.pool.number(value.clone())))
    });
    let held: Substitution = given.collect();
    let all = [&[rest.potential], rest.others.as_slice(), &rest.constraints].concat();
    let all = rest.pool.substitute(&all, &held);
    rest.potential = all[0];
    let (others, constraints) = all[1..].split_at(rest.others.len());
    rest.constraints = constraints.to_vec();
    let kept: Vec<usize> = (0..searched.len()).filter(|k| !held.contains_key(&rest.coordinates[*k])).collect();
    rest.others = kept.iter().map(|k| others[*k]).collect();
    rest.coordinates = kept.iter().map(|k| rest.coordinates[*k]).collect();
    *whole = kept.iter().map(|k| whole[*k]).collect();
    *searched = kept.iter().map(|k| searched[*k]).collect();
    held
}

/// Slices across directions along which nothing changes, and the ranges widened by what moving into the slices takes.
fn slices(neutral: &[(usize, Neutral)], searched: &[usize], whole: &mut [Interval]) -> Vec<Slice> {
    let original = whole.to_vec();
    let mut slices = Vec::new();
    let last = searched.iter().max().map_or(0, |at| at + 1);
    for (pivot, vector) in neutral {
        let vector: Vec<f64> = vector.iter().map(|x| Ball::from_number(x, ()).mid_f64()).collect();
        let half = 0.5 * original[*pivot].width();
        for (own, v) in whole.iter_mut().zip(&vector) {
            let by = (v.abs() * half).next_up();
            if *v != 0.0 {
                *own = Interval::new((own.lo - by).next_down(), (own.hi + by).next_up());
            }
        }
        let mut direction = vec![0.0; last];
        for (at, v) in searched.iter().zip(&vector) {
            direction[*at] = *v;
        }
        slices.push(Slice { pivot: searched[*pivot], value: original[*pivot].middle(), direction });
    }
    slices
}

/// By their coordinates, one after the other.
fn sort(equilibria: &mut [Equilibrium]) {
    equilibria.order_by(|a, b| compared(&a.point, &b.point));
}

fn compared(a: &[Ball], b: &[Ball]) -> std::cmp::Ordering {
    let mut different = a.iter().zip(b).filter(|(x, y)| !(**x - **y).contains_zero());
    different.next().map_or(std::cmp::Ordering::Equal, |(x, y)| x.mid.hi.total_cmp(&y.mid.hi))
}

/// What may be 0 is shown as that.
fn rounded(point: &[Ball]) -> Vec<Ball> {
    let round = |x: &Ball| if x.contains_zero() { Ball::ZERO.with_added_radius(x.abs_upper()) } else { *x };
    point.iter().map(round).collect()
}

/// Whether an enclosure reaches into a closed range.
fn may_lie(x: &Ball, side: Option<&[Ball; 2]>) -> bool {
    side.is_none_or(|[from, to]| !(*x - *from).is_negative() && !(*to - *x).is_negative())
}

/// A power of two that brings forces to about the size of the gradients of constraints.
fn scale(rest: &mut AtRest, whole: &[Interval], parameters: &[Ball]) -> Number {
    if rest.constraints.is_empty() {
        return Number::ONE;
    }
    let forces = gradient(rest);
    let slopes: Vec<ExprId> =
        rest.constraints.iter().flat_map(|own| rest.pool.gradient(*own, &rest.coordinates)).collect();
    let largest = |roots: &[ExprId]| {
        let inputs: Vec<Symbol> = rest.coordinates.iter().chain(&rest.parameters).copied().collect();
        let tape = Tape::compile(&rest.pool, roots, &inputs).ok();
        let values = [0.5, 0.31, 0.77].iter().flat_map(|share| {
            let at = whole.iter().take(rest.coordinates.len()).map(|own| own.lo + share * own.width());
            let at: Vec<f64> = at.chain(parameters.iter().map(Ball::mid_f64)).collect();
            tape.as_ref().map(|tape| tape.evaluate(&at, &mut Vec::new())).unwrap_or_default()
        });
        values.filter(|x: &f64| x.is_finite()).fold(0.0_f64, |most, x| most.max(x.abs()))
    };
    let (force, slope) = (largest(&forces), largest(&slopes));
    let ratio = (slope / force).log2().round();
    if !ratio.is_finite() {
        return Number::ONE;
    }
    Number::from(2).powi(ratio.clamp(-300.0, 300.0) as i32).unwrap_or(Number::ONE)
}

/// Pieces which touch.
struct Place {
    /// One of them.
    first: Vec<Interval>,
    /// A box that holds them.
    hull: Vec<Interval>,
}

/// Pieces put together where they touch.
fn gathered<'a>(pieces: impl Iterator<Item = &'a Vec<Interval>>) -> Vec<Place> {
    let pieces: Vec<&Vec<Interval>> = pieces.collect();
    let hull = |a: &[Interval], b: &[Interval]| -> Vec<Interval> {
        a.iter().zip(b).map(|(x, y)| Interval::new(x.lo.min(y.lo), x.hi.max(y.hi))).collect()
    };
    let mut boxes: Vec<Place> = Vec::new();
    for (number, piece) in pieces.iter().enumerate() {
        let mut own = Place { first: piece.to_vec(), hull: piece.to_vec() };
        if number >= MOST_GATHERED {
            if let Some(last) = boxes.last_mut() {
                last.hull = hull(&last.hull, &own.hull);
            }
            continue;
        }
        // Pieces end where others begin, but for what contraction took away.
        loop {
            let touches = |other: &Place| {
                own.hull.iter().zip(other.hull.iter().zip(*piece)).all(|(x, (y, piece))| {
                    let slack = piece.width();
                    x.lo <= y.hi + slack && y.lo <= x.hi + slack
                })
            };
            let Some(at) = boxes.iter().position(touches) else { break };
            let other = boxes.swap_remove(at);
            own = Place { hull: hull(&own.hull, &other.hull), first: other.first };
        }
        boxes.push(own);
    }
    boxes.order_by(|a, b| {
        let mut ends = a.hull.iter().zip(&b.hull).map(|(x, y)| x.lo.total_cmp(&y.lo));
        ends.find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    });
    boxes
}

/// That some places were not decided.
fn undecided_words(model: &Model, undecided: &[Undecided], is_cut_short: bool, pieces: usize) -> Vec<String> {
    let mut words = Vec::new();
    if is_cut_short {
        words.push(format!("the search ended after {pieces} pieces of the box; a smaller box, or several, take less"));
    }
    words.extend(named_places(model, undecided).map(|places| {
        format!(
            "how many equilibria there are was not decided near {places}: they coincide or nearly do, lie on a line, or the forces are singular"
        )
    }));
    words
}

/// `x = 1, y = 2; near x = 3, y = 4 and 5 other places`
fn named_places(model: &Model, undecided: &[Undecided]) -> Option<String> {
    let named = |own: &Undecided| {
        let parts = model.coordinates.names().zip(&own.point).map(|(name, x)| {
            let x = if x.abs() <= own.radius.min(SMALL) { 0.0 } else { *x };
            format!("{name} = {}", linearize::short(x))
        });
        parts.collect::<Vec<String>>().join(", ")
    };
    let places: Vec<String> = undecided.iter().take(MOST_NAMED).map(named).collect();
    let more = match undecided.len().saturating_sub(MOST_NAMED) {
        0 => String::new(),
        more => format!(" and {more} other places"),
    };
    (!places.is_empty()).then(|| places.join("; near ") + &more)
}
