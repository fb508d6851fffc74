//! Equilibria over a parameter: which one at a value is which at the next, and where branches end or meet.
//!
//! At each value all equilibria in the box are found. From one value to the next an equilibrium is followed in steps, each proved: in a
//! region about it there is exactly one for every value of the parameter between both ends (Krawczyk's theorem with the parameter as an
//! interval), so that no branch is taken for another. Where steps become too short a bifurcation is near, and proved
//! (`bifurcation`), or it is said that it was not decided. What begins and ends between two neighbouring values is not seen.

use std::collections::{HashMap, HashSet};

use librate_core::budget::Budget;
use librate_core::linearize;
use librate_core::model::{Constant, Model, Range};
use librate_core::order::{Gather, Order};
use librate_core::precision::{Ball, Interval};

use super::bifurcation::{Kind, Proved, Systems};
use super::error::EquilibriaError;
use super::forces::{Equations, Forces};
use super::region::Region;
use super::root::{Root, are_within};
use super::search::Search;
use super::{
    Equilibrium, MOST_NAMED, Node, Place, Task, Undecided, compared, may_lie, named_places, rounded, stability,
    undecided_words,
};
use crate::source::{self, Source};

/// More values are not examined.
const MOST_VALUES: usize = 10_000;
/// Steps shorter than this part of the way between two values end a branch.
const SHORTEST: f64 = 1.0 / (1 << 14) as f64;
/// A bifurcation is no farther than so many gaps from where a branch that ends in it can't be followed any more.
const FARTHEST: f64 = 256.0 * SHORTEST;
/// What is not decided contains the bifurcation, up to this share of the box: beside a fold forces grow with the square of the
/// distance.
const BESIDE: f64 = 1e-6;

/// Equilibria that are connected over neighbouring values.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Branch {
    /// The number of the value, and the equilibrium there.
    pub at: Vec<(usize, Equilibrium)>,
    /// Values and coordinates on the way, the ends in bifurcations among them; doubles, for pictures.
    pub way: Vec<(f64, Vec<f64>)>,
}

/// Where branches end or meet.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Bifurcation {
    /// What happens there.
    pub kind: Kind,
    /// The value of the parameter, in its unit.
    pub value: Ball,
    /// The coordinates in SI.
    pub point: Vec<Ball>,
}

impl Bifurcation {
    /// How far the coordinates, as doubles, are off at most.
    #[must_use]
    pub fn radius(&self) -> f64 {
        super::radius(&self.point)
    }
}

/// The equilibria in a box over values of a parameter.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Diagram {
    /// Where they were searched for.
    pub region: Region,
    /// The parameter.
    pub name: String,
    /// The unit that it is declared with, as it is written.
    pub unit: Option<String>,
    /// Its values, in its unit.
    pub values: Vec<f64>,
    /// By their first values, then by coordinates.
    pub branches: Vec<Branch>,
    /// By the value of the parameter.
    pub bifurcations: Vec<Bifurcation>,
    /// Whether at each value these are all equilibria, and each end of a branch is accounted for.
    pub complete: bool,
    /// Why it is not complete, in words.
    pub reasons: Vec<String>,
}

/// Finds the equilibria in a box at each value of a range, and connects them.
///
/// # Errors
/// As [`super::find`]; a parameter that sets ranges, and too many values.
pub fn follow(source: &Source, region: &Region, range: &Range) -> Result<Diagram, EquilibriaError> {
    if range.len() > MOST_VALUES {
        return Err(EquilibriaError::TooManyValues { values: range.len(), most: MOST_VALUES });
    }
    let models: Vec<Model> = (0..range.len())
        .map(|place| source.model(range, place, source::first).map(|own| linearize::integrated(&own).into_owned()))
        .collect::<Result<_, EquilibriaError>>()?;
    let Some(first) = models.first() else { return Err(EquilibriaError::NoForces {}) };
    let own = |number: &usize| {
        let own = &first.parameters[*number];
        first.pool.as_symbol(own.symbolic) == Some(own.symbol)
    };
    let name = || range.name().to_owned();
    let varying = source::parameter(first, range);
    let varying = varying.filter(own).ok_or_else(|| EquilibriaError::SetsRanges { parameter: name() })?;
    let mut values = Vec::with_capacity(models.len());
    for model in &models {
        let value = model.parameters[varying].value.and_then(|value| linearize::constant(&model.pool, value));
        values.push(value.ok_or_else(|| linearize::missing_value(model, varying))?);
    }
    let task = Task::new(first, region, Some(varying))?;
    let equations = task.equations();
    let forces = task.forces(&equations)?;
    let mut follower = Follower {
        budget: first.pool.budget().clone(),
        unit: unit(range, &values),
        places: Vec::new(),
        undecided: Vec::new(),
        reasons: Vec::new(),
        bifurcations: Vec::new(),
        task,
        equations,
        forces,
        values,
    };
    follower.search(&models)?;
    let joints = follower.connect()?;
    let mut branches = follower.branches(&joints, &models)?;
    follower.account(&joints);
    branches.order_by(|a, b| {
        let first = |branch: &Branch| branch.at.first().map(|(place, own)| (*place, own.point.clone()));
        match (first(a), first(b)) {
            (Some((a, x)), Some((b, y))) => a.cmp(&b).then_with(|| compared(&x, &y)),
            (a, b) => a.is_some().cmp(&b.is_some()),
        }
    });
    let Follower { mut bifurcations, reasons, .. } = follower;
    bifurcations.order_by(|a, b| a.found.value.mid.hi.total_cmp(&b.found.value.mid.hi));
    Ok(Diagram {
        region: region.clone(),
        name: name(),
        unit: source::unit_of(&source.file, range.name()),
        values: (0..range.len()).map(|place| range.value(place).unwrap_or(f64::NAN)).collect(),
        branches,
        bifurcations: bifurcations.into_iter().map(|own| own.shown).collect(),
        complete: reasons.is_empty(),
        reasons,
    })
}

/// What the parameter's unit is worth in SI.
fn unit(range: &Range, values: &[Ball]) -> Ball {
    let mut all = values.iter().enumerate().filter(|(_, value)| !value.contains_zero());
    let ratio = all.next().and_then(|(place, value)| {
        let written = Constant::parse(&range.expression(place)).ok()?;
        let written = linearize::constant(written.pool(), written.value())?;
        Some(if (written - *value).contains_zero() { Ball::ONE } else { *value / written })
    });
    ratio.filter(Ball::is_finite).unwrap_or(Ball::ONE)
}

/// An equilibrium at a value, by their numbers.
type Mark = (usize, usize);

/// Values and unknowns, in the order in which they were followed.
type Way = Vec<(f64, Vec<f64>)>;

/// How far an equilibrium was followed to a value nearby.
struct Trace {
    way: Way,
    end: Root,
    value: Ball,
    /// Whether that is the value nearby.
    arrived: bool,
}

/// A branch that ends between two values.
struct End {
    mark: Mark,
    forward: bool,
    way: Way,
    bifurcation: Option<usize>,
}

/// How branches go on.
#[derive(Default)]
struct Joints {
    next: HashMap<Mark, (Mark, Way)>,
    later: HashSet<Mark>,
    ends: Vec<End>,
    /// The bifurcations that are equilibria at a value behind (`true`) or before one.
    reached: HashMap<(Mark, bool), usize>,
}

/// A bifurcation as it was found and as it is shown.
struct Known {
    found: Proved,
    shown: Bifurcation,
}

/// A search at many values.
struct Follower<'a> {
    task: Task<'a>,
    equations: Equations,
    forces: Forces,
    budget: Budget,
    /// Of the parameter in SI, and what its unit is worth.
    values: Vec<Ball>,
    unit: Ball,
    /// The equilibria at each value.
    places: Vec<Vec<Node>>,
    /// What was not decided, with the number of the value.
    undecided: Vec<(usize, Place, Vec<String>)>,
    bifurcations: Vec<Known>,
    reasons: Vec<String>,
}

impl Follower<'_> {
    /// All equilibria at each value.
    fn search(&mut self, models: &[Model]) -> Result<(), EquilibriaError> {
        for (place, model) in models.iter().enumerate() {
            self.budget.at("the equilibria in the box", None);
            let parameters = vec![self.values[place]];
            let whole = self.task.whole.clone();
            let findings = Search::new(&mut self.forces, parameters, whole).run(&self.budget)?;
            let mut nodes: Vec<Node> = self.task.nodes(&findings).collect();
            for node in &mut nodes {
                stability::put_modes(model, &mut node.equilibrium)?;
            }
            for own in self.task.undecided(&findings) {
                let words = undecided_words(self.task.model, &[self.task.told(&own)], false, 0);
                self.undecided.push((place, own, words));
            }
            if findings.is_cut_short {
                let words = undecided_words(self.task.model, &[], true, findings.pieces);
                let name = self.named(place);
                self.reasons.extend(words.into_iter().map(|own| format!("at {name}: {own}")));
            }
            self.places.push(nodes);
        }
        if self.places.iter().any(|own| !own.is_empty()) {
            self.reasons.extend(self.task.neutral_words());
        }
        Ok(())
    }

    fn named(&self, place: usize) -> String {
        linearize::short((self.values[place] / self.unit).mid_f64())
    }

    /// Follows each equilibrium to the neighbouring values, and finds what it ends in.
    fn connect(&mut self) -> Result<Joints, EquilibriaError> {
        self.budget.at("the branches of equilibria", None);
        let mut joints = Joints::default();
        for place in 1..self.values.len() {
            for (forward, [from, to]) in [(true, [place - 1, place]), (false, [place, place - 1])] {
                for own in 0..self.places[from].len() {
                    let mark = (from, own);
                    if !forward && joints.later.contains(&mark) {
                        continue;
                    }
                    self.budget.check()?;
                    self.follow(mark, to, &mut joints);
                }
            }
        }
        let span = [0, self.values.len() - 1].map(|at| self.values[at].mid_f64());
        let (equations, whole) = (self.equations.clone(), self.task.whole.clone());
        let mut systems = Systems::new(&equations, &whole, span);
        for end in &mut joints.ends {
            self.budget.check()?;
            self.put_bifurcation(end, &mut systems);
        }
        self.check_folds(&mut joints.ends);
        let open = joints.ends.iter().filter(|end| end.bifurcation.is_none());
        let open: Vec<Undecided> = open.map(|end| self.open(end)).collect();
        self.reasons.extend(named_places(self.task.model, &open).map(|places| {
            format!(
                "what branches end in was not decided near {places}: bifurcations coincide there, or are degenerate"
            )
        }));
        self.join(&mut joints);
        self.reach(&mut joints);
        Ok(joints)
    }

    fn follow(&mut self, mark: Mark, to: usize, joints: &mut Joints) {
        let (from, own) = mark;
        let start = self.places[from][own].root.clone();
        let mut search = Search::new(&mut self.forces, Vec::new(), self.task.whole.clone());
        let Trace { mut way, end, value, arrived } = search.trace(start, self.values[from], self.values[to]);
        let forward = from < to;
        if !arrived {
            if end.at.iter().zip(&self.task.sides()).all(|(x, side)| may_lie(x, side.as_ref())) {
                way.push((value.mid_f64(), end.at.iter().map(Ball::mid_f64).collect()));
                joints.ends.push(End { mark, forward, way, bifurcation: None });
            }
            return;
        }
        // What is not there has left the box.
        let Some(other) = self.places[to].iter().position(|node| node.root.is_same(&end)) else { return };
        let (first, last) = if forward { (mark, (to, other)) } else { ((to, other), mark) };
        if !forward {
            way.reverse();
        }
        if !joints.later.contains(&last) && !joints.next.contains_key(&first) {
            joints.next.insert(first, (last, way));
            joints.later.insert(last);
        }
    }

    /// What a branch ends in.
    fn put_bifurcation(&mut self, end: &mut End, systems: &mut Systems<'_>) {
        let Some((value, place)) = end.way.last().cloned() else { return };
        let mut search = Search::new(&mut self.forces, vec![Ball::exact(value)], self.task.whole.clone());
        let slopes = search.slopes(&place);
        let Some(found) = systems.near(&place, value, &slopes) else { return };
        // Not far from where the branch could not be followed any more, and not before.
        let gap = (self.values[1] - self.values[0]).mid_f64();
        let beyond = (found.value.mid_f64() - value) / if end.forward { gap } else { -gap };
        if !(-1e-9..FARTHEST).contains(&beyond) {
            return;
        }
        let is_same = |known: &Known| {
            let pairs = known.found.at.iter().zip(&found.at);
            known.found.kind == found.kind
                && (known.found.value - found.value).contains_zero()
                && pairs.into_iter().all(|(x, y)| (*x - *y).contains_zero())
        };
        let known = self.bifurcations.iter().position(is_same);
        end.bifurcation = Some(known.unwrap_or_else(|| {
            let point = rounded(&self.task.embedded(&found.at));
            let shown = Bifurcation { kind: found.kind, value: found.value / self.unit, point };
            self.bifurcations.push(Known { found, shown });
            self.bifurcations.len() - 1
        }));
    }

    /// Takes folds from branches where more than two of them end in one, or not from the same side; of one branch the other half may
    /// lie between two values.
    fn check_folds(&self, ends: &mut [End]) {
        for (number, known) in self.bifurcations.iter().enumerate() {
            let own = || ends.iter().filter(|end| end.bifurcation == Some(number)).map(|end| end.forward);
            let mut sides = own();
            let first = sides.next();
            let is_fold = own().count() <= 2 && sides.next().is_none_or(|second| first == Some(second));
            if known.found.kind == Kind::Fold && !is_fold {
                ends.iter_mut().filter(|end| end.bifurcation == Some(number)).for_each(|end| end.bifurcation = None);
            }
        }
    }

    /// Connects branches that pass through a bifurcation.
    fn join(&self, joints: &mut Joints) {
        for (number, known) in self.bifurcations.iter().enumerate() {
            if known.found.kind == Kind::Fold {
                continue;
            }
            let at = |end: &&End| &self.places[end.mark.0][end.mark.1].root.at;
            let is_symmetric = |end: &&End| known.found.is_symmetric(at(end));
            for symmetric in [true, false] {
                let pick = |forward: bool| -> Option<&End> {
                    let all = joints.ends.iter().filter(|end| {
                        end.bifurcation == Some(number) && end.forward == forward && is_symmetric(end) == symmetric
                    });
                    all.only()
                };
                // The other branches of a pitchfork lie on one side.
                let (Some(before), Some(after)) = (pick(true), pick(false)) else { continue };
                let mut way = before.way.clone();
                way.push(self.spot(number));
                way.extend(after.way.iter().rev().cloned());
                let (before, after) = (before.mark, after.mark);
                if before.0 + 2 == after.0 && self.is_at(number, before.0 + 1) {
                    joints.reached.insert((before, true), number);
                }
                joints.next.insert(before, (after, way));
                joints.later.insert(after);
            }
        }
    }

    /// Gives an equilibrium that is a bifurcation at one of the values to a branch that ends in it, the symmetric one if there is
    /// one, where no branch passes through it.
    fn reach(&self, joints: &mut Joints) {
        let mut ends: Vec<(bool, Mark, bool, usize)> = Vec::new();
        for end in &joints.ends {
            let Some(number) = end.bifurcation else { continue };
            let place = if end.forward { end.mark.0 + 1 } else { end.mark.0 - 1 };
            let known = &self.bifurcations[number];
            let inside = known.found.at.iter().zip(&self.task.sides()).all(|(x, side)| may_lie(x, side.as_ref()));
            if inside && self.is_at(number, place) {
                let own = &self.places[end.mark.0][end.mark.1].root.at;
                ends.push((!known.found.is_symmetric(own), end.mark, end.forward, number));
            }
        }
        ends.put_in_order();
        for (_, mark, forward, number) in ends {
            if !joints.reached.values().any(|own| *own == number) {
                joints.reached.insert((mark, forward), number);
            }
        }
    }

    /// Whether a bifurcation is at one of the values.
    fn is_at(&self, number: usize, place: usize) -> bool {
        (self.bifurcations[number].found.value - self.values[place]).contains_zero()
    }

    /// An end that nothing is known of.
    fn open(&self, end: &End) -> Undecided {
        let at = end.way.last().map_or(&[][..], |(_, own)| own.as_slice());
        Undecided { point: self.task.shown(at), radius: 0.0 }
    }

    fn spot(&self, bifurcation: usize) -> (f64, Vec<f64>) {
        let found = &self.bifurcations[bifurcation].found;
        (found.value.mid_f64(), found.at.iter().map(Ball::mid_f64).collect())
    }

    /// The branches, each from its first value to its last.
    fn branches(&self, joints: &Joints, models: &[Model]) -> Result<Vec<Branch>, EquilibriaError> {
        let mut branches = Vec::new();
        let ending =
            |mark: Mark, forward: bool| joints.ends.iter().find(|end| end.mark == mark && end.forward == forward);
        let marks = self.places.iter().enumerate().flat_map(|(place, own)| (0..own.len()).map(move |at| (place, at)));
        for first in marks.filter(|mark| !joints.later.contains(mark)) {
            let mut way: Way = Vec::new();
            if let Some(end) = ending(first, false) {
                way.extend(end.bifurcation.map(|number| self.spot(number)));
                way.extend(end.way.iter().rev().cloned());
            }
            let mut at = Vec::new();
            let mut mark = first;
            if let Some(number) = joints.reached.get(&(first, false)) {
                at.push((first.0 - 1, self.reached(*number, &models[first.0 - 1])?));
            }
            loop {
                let node = &self.places[mark.0][mark.1];
                at.push((mark.0, node.equilibrium.clone()));
                way.push((self.values[mark.0].mid_f64(), node.root.at.iter().map(Ball::mid_f64).collect()));
                if let Some(number) = joints.reached.get(&(mark, true)) {
                    at.push((mark.0 + 1, self.reached(*number, &models[mark.0 + 1])?));
                }
                let Some((next, own)) = joints.next.get(&mark) else { break };
                way.extend(own.iter().cloned());
                mark = *next;
            }
            if let Some(end) = ending(mark, true).filter(|_| !joints.next.contains_key(&mark)) {
                way.extend(end.way.iter().cloned());
                way.extend(end.bifurcation.map(|number| self.spot(number)));
            }
            branches.push(Branch { at, way: self.shown(way) });
        }
        Ok(branches)
    }

    /// The equilibrium that is a bifurcation.
    fn reached(&self, number: usize, model: &Model) -> Result<Equilibrium, EquilibriaError> {
        let mut own = Equilibrium::new(self.bifurcations[number].shown.point.clone(), None);
        stability::put_modes(model, &mut own)?;
        Ok(own)
    }

    /// In the parameter's unit, with all coordinates.
    fn shown(&self, way: Way) -> Vec<(f64, Vec<f64>)> {
        let unit = self.unit.mid_f64();
        way.into_iter().map(|(value, own)| (value / unit, self.task.shown(&own))).collect()
    }

    /// Says what no bifurcation on a branch accounts for.
    fn account(&mut self, joints: &Joints) {
        let mut open: Vec<String> = Vec::new();
        for (place, own, words) in &self.undecided {
            let accounts = |number: &usize| {
                let known = &self.bifurcations[*number];
                let near = |(x, (own, whole)): (&Ball, (&Interval, &Interval))| {
                    let slack = BESIDE * whole.width();
                    own.lo - slack <= x.mid_f64() && x.mid_f64() <= own.hi + slack
                };
                self.is_at(*number, *place)
                    && known.found.at.iter().zip(own.hull.iter().zip(&self.task.whole)).all(near)
            };
            if !joints.reached.values().any(accounts) {
                open.extend(words.iter().map(|own| format!("at {}: {own}", self.named(*place))));
            }
        }
        let more = open.len().saturating_sub(MOST_NAMED);
        open.truncate(MOST_NAMED);
        open.extend((more > 0).then(|| format!("the same holds at {more} further places")));
        self.reasons.append(&mut open);
    }
}

impl Search<'_> {
    /// The derivatives in doubles.
    fn slopes(&mut self, at: &[f64]) -> Vec<f64> {
        self.doubles.slopes(&self.inputs(at, Ball::mid_f64))
    }

    /// Follows an equilibrium from one value of the parameter to another, as far as it is proved to be the same.
    fn trace(&mut self, start: Root, from: Ball, to: Ball) -> Trace {
        let gap = (to - from).mid_f64();
        let mut step = gap;
        let mut trace = Trace { way: Vec::new(), end: start, value: from, arrived: gap == 0.0 };
        while !trace.arrived {
            let rest = (to - trace.value).mid_f64();
            let is_last = step.abs() >= rest.abs();
            let next = if is_last { to } else { Ball::exact(trace.value.mid_f64() + step) };
            if let Some(end) = self.advanced(&trace.end, &trace.value, &next) {
                trace.way.extend((!is_last).then(|| (next.mid_f64(), end.at.iter().map(Ball::mid_f64).collect())));
                (trace.end, trace.value, trace.arrived) = (end, next, is_last);
                step *= 2.0;
            } else {
                step = 0.5 * if is_last { rest } else { step };
                if step.abs() < SHORTEST * gap.abs() {
                    break;
                }
            }
        }
        trace
    }

    /// The equilibrium at another value, if in a region there is exactly one for all values between, which is both.
    fn advanced(&mut self, root: &Root, from: &Ball, to: &Ball) -> Option<Root> {
        let start: Vec<f64> = root.at.iter().map(Ball::mid_f64).collect();
        self.parameters = vec![*to];
        let end = self.converged(&start)?;
        let shift = |((x, y), whole): ((&f64, &f64), &Interval)| (x - y).abs() / whole.width();
        let share = start.iter().zip(&end).zip(&self.whole).map(shift).fold(1e-9, f64::max);
        let sides: Vec<f64> = self.whole.iter().map(|own| share * own.width()).collect();
        let found = self.prove(&end, &sides)?;
        let middle: Vec<f64> = start.iter().zip(&end).map(|(x, y)| 0.5 * (x + y)).collect();
        self.parameters = vec![from.hull(to)];
        let region = self.alone(&middle, &sides)?.region;
        (are_within(&root.at, &region) && are_within(&found.at, &region)).then_some(found)
    }
}
