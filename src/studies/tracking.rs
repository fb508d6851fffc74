//! Modes over a range of a parameter, followed by their shapes: which mode at one value is which at the next.
//!
//! Two modes belong together where |xᴴ M y|² is large, M being the mass matrix at the first value (the modal assurance criterion of
//! R. J. Allemang and D. L. Brown, Proc. 1st Int. Modal Analysis Conf., 1982), and s x is near to s' y: exponents s and -s may have one
//! shape. Where it decides nothing, or two modes seem to change
//! places, the interval is halved, and halved again: at an avoided crossing shapes turn into each other, at a crossing they keep what
//! they are. So it is where frequencies bend. Modes of different symmetry classes never belong together. Among equal frequencies no shape is one of a mode; those before
//! are kept until they part again.

use std::collections::BTreeMap;

use crate::batch::{BatchMode, Solution};
use crate::error::Error;
use crate::refine::{DEEPEST, FEW_FINER, FLAT, MOST_FINER, off_line, span};
use crate::sweep::{Enclosed, Place, Sweep, Worker};
use librate_core::groups::connected;
use librate_core::linearize::Linearized;
use librate_core::modes::Kind;
use librate_core::order::Order;
use librate_core::oscillation::{NormalMode, NormalModes};
use librate_core::precision::Ball;

/// Shapes that agree less leave it open what belongs together.
const SURE: f64 = 0.7;
/// Those that agree less than this have nothing in common.
const LEAST: f64 = 0.05;
/// Between shapes that agree less frequencies may bend.
const STEADY: f64 = 0.98;
/// Where modes change places an interval is halved until bounds no longer separate them.
const DEEPEST_SWAP: u32 = 34;
/// So many places may be added for all intervals that leave it open, where these are few.
const FEW_OPEN: usize = 2000;
/// So many coordinates name a block.
const MOST_NAMED: usize = 2;
/// Masses of more coordinates count alike, ...
const MOST_DENSE: usize = 600;
/// ... and those of which xᴴMx is no larger a part of its terms.
const LOST: f64 = 1e-10;
/// Squares of frequencies that are apart by so many times their bounds have shapes in doubles that are off by no more than a thousandth:
/// the sine of the angle is at most the residual by the gap (C. Davis and W. M. Kahan, SIAM J. Numer. Anal. 7 (1970) 1).
const APART: f64 = 1e3;

/// A mode followed over a range.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Branch {
    /// Its symmetry class at most places, or the coordinates that move in it alone, where it has one.
    pub class: Option<String>,
    /// The places where it is, each with its number among the modes there.
    pub at: Vec<(usize, usize)>,
}

/// The modes at one value of the parameter, as they are followed and drawn.
#[derive(Clone, Debug)]
#[non_exhaustive]
#[must_use]
pub struct Tracked {
    /// The parameter's value, in the unit that it is declared with.
    pub value: f64,
    /// The modes there, or why there are none.
    pub modes: Result<Vec<Shape>, Error>,
}

impl Tracked {
    /// Of a place that is solved in full, with shapes.
    pub fn of(place: Place) -> Self {
        Self { value: place.value, modes: place.result.map(|(linearized, modes)| shapes(&linearized, &modes)) }
    }

    /// Nothing where there are none.
    #[must_use]
    pub fn shapes(&self) -> &[Shape] {
        self.modes.as_deref().unwrap_or_default()
    }
}

/// A mode as it is compared.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Shape {
    /// Its frequency in rad/s.
    pub omega: Ball,
    /// Its growth in 1/s.
    pub growth: Ball,
    /// Its symmetry class, or the coordinates that move in it, where nothing couples these to the others.
    pub class: Option<String>,
    /// Real and imaginary part of each component.
    vector: Vec<[f64; 2]>,
    is_real: bool,
    /// M times it, and the root of xᴴMx.
    image: Vec<[f64; 2]>,
    length: f64,
    pub(crate) cluster: u32,
    kind: Kind,
}

impl Shape {
    /// How much two modes are alike, as one of either pair stands for both: a whirl that turns back has the other one then.
    fn likeness(&self, other: &Self) -> Likeness {
        let [[a, b], [c, d]] = [self, other].map(point);
        let (lengths, both) = (self.length * other.length, a * a + b * b + c * c + d * d);
        let with_sign = |sign: f64| {
            let [re, im] = self.product(other, sign);
            let agreement = if lengths > 0.0 { (re * re + im * im) / lengths } else { 0.0 };
            let share = if both > 0.0 { 0.5 + (sign * a * c + b * d) / both } else { 1.0 };
            Likeness { agreement, of_states: agreement * share }
        };
        let direct = with_sign(1.0);
        if self.is_real || other.is_real {
            return direct;
        }
        let opposite = with_sign(-1.0);
        let is_opposite = (opposite.of_states, opposite.agreement) > (direct.of_states, direct.agreement);
        if is_opposite { opposite } else { direct }
    }

    /// xᴴ M y, or with the sign -1 that of the conjugate of y; real and imaginary part.
    pub(crate) fn product(&self, other: &Self, sign: f64) -> [f64; 2] {
        let parts = self.image.iter().zip(&other.vector).map(|(own, [c, d])| (own, [*c, sign * d]));
        parts.fold([0.0; 2], |[re, im], ([a, b], [c, d])| [re + a * c + b * d, im + a * d - b * c])
    }

    /// The shape as that of another mode.
    pub(crate) fn of_mode(self, other: &Self) -> Self {
        Self { cluster: other.cluster, omega: other.omega, growth: other.growth, ..self }
    }

    /// Whether xᴴMx is what little is left of large terms: in doubles nothing of it need be right.
    fn cancels(&self, mass: &[f64]) -> bool {
        let sizes: Vec<f64> = self.vector.iter().map(|[re, im]| re.hypot(*im)).collect();
        let row = |(row, size): (&[f64], &f64)| size * row.iter().zip(&sizes).map(|(m, x)| m.abs() * x).sum::<f64>();
        self.length < LOST * mass.chunks(sizes.len().max(1)).zip(&sizes).map(row).sum::<f64>()
    }

    fn new(vector: Vec<[f64; 2]>, mass: &[f64], enclosed: Enclosed, kind: Kind, cluster: u32) -> Self {
        let image: Vec<[f64; 2]> = if mass.is_empty() {
            vector.clone()
        } else {
            let row = |row: &[f64]| {
                let parts = row.iter().zip(&vector);
                parts.fold([0.0; 2], |[re, im], (entry, part)| [re + entry * part[0], im + entry * part[1]])
            };
            mass.chunks(vector.len()).map(row).collect()
        };
        let length = vector.iter().zip(&image).map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum();
        let Enclosed { omega, growth } = enclosed;
        let is_real = vector.iter().all(|[_, im]| *im == 0.0);
        Self { omega, growth, class: None, vector, is_real, image, length, cluster, kind }
    }
}

/// How much two modes are alike.
struct Likeness {
    /// |xᴴ M y|²/(xᴴMx · yᴴMy), 1 for the same shape.
    agreement: f64,
    /// The part of it that the states have, (x, s x/s0) with the larger exponent for s0.
    of_states: f64,
}

/// The modes at a place.
pub(crate) type Shapes = [Shape];

/// Frequency and growth.
fn point(mode: &Shape) -> [f64; 2] {
    [mode.omega.mid_f64(), mode.growth.mid_f64()]
}

pub(crate) fn shapes(linearized: &Linearized, modes: &NormalModes) -> Vec<Shape> {
    let n = modes.modes.first().map_or(0, |mode| mode.vector.len());
    let mass = if n <= MOST_DENSE { linearized.mass() } else { Vec::new() };
    let is_plain = mass.len() == n * n && modes.modes.iter().all(|mode| mode.symmetry.is_none());
    let blocks = if is_plain { blocks(linearized, &mass, n) } else { Vec::new() };
    let mass: Vec<f64> = if mass.len() == n * n { mass.iter().map(|own| own.mid_f64()).collect() } else { Vec::new() };
    // Where no motion has inertia, components count alike.
    let mass = if mass.iter().all(|own| *own == 0.0) { Vec::new() } else { mass };
    let shape = |mode: &NormalMode, mass: &[f64]| {
        let imaginary = mode.imaginary.iter().copied().chain(std::iter::repeat(0.0));
        let vector = mode.vector.iter().zip(imaginary).map(|(re, im)| [*re, im]).collect();
        let enclosed = Enclosed { omega: mode.omega, growth: mode.growth };
        let shape = Shape::new(vector, mass, enclosed, mode.kind, mode.cluster);
        let moves = |i: &usize| shape.vector.get(*i).is_some_and(|own| *own != [0.0; 2]);
        let mut own = blocks.iter().filter(|(_, block)| block.iter().any(moves));
        let block = own.next().filter(|_| own.next().is_none()).map(|(name, _)| name.clone());
        Shape { class: mode.symmetry.clone().or(block), ..shape }
    };
    let all = |mass: &[f64]| -> Vec<Shape> { modes.modes.iter().map(|mode| shape(mode, mass)).collect() };
    let own = all(&mass);
    if own.iter().any(|shape| shape.cancels(&mass)) { all(&[]) } else { own }
}

/// Coordinates that nothing couples to the others, with names for each set of them; nothing where all are coupled.
fn blocks(linearized: &Linearized, mass: &[Ball], n: usize) -> Vec<(String, Vec<usize>)> {
    if linearized.is_reduced() {
        return Vec::new();
    }
    let (velocity, stiffness) = linearized.velocity_and_stiffness();
    let coupled = |i: usize, j: usize| {
        let entries =
            [mass, &velocity, &stiffness].into_iter().flat_map(|own| [own.get(i + n * j), own.get(j + n * i)]);
        entries.flatten().any(|entry| !entry.is_zero())
    };
    let groups = connected(n, coupled);
    if groups.len() < 2 {
        return Vec::new();
    }
    let names: Vec<String> = linearized.model().coordinates.names().collect();
    let named = |group: Vec<usize>| {
        let mut shown: Vec<&str> = group.iter().take(MOST_NAMED).map(|i| names[*i].as_str()).collect();
        shown.extend((group.len() > MOST_NAMED).then_some("…"));
        (shown.join(", "), group)
    };
    groups.into_iter().map(named).collect()
}

/// The same from doubles; nothing where shapes may be off.
fn shapes_in_doubles(enclosed: &[Enclosed], set: Solution<'_>) -> Option<Vec<Shape>> {
    let squares = || set.omega_squared.iter().zip(set.omega_squared_bounds);
    let is_apart = |((a, r), (b, s)): ((&f64, &f64), (&f64, &f64))| b - a > APART * (r + s);
    if !squares().zip(squares().skip(1)).all(is_apart) {
        return None;
    }
    let shape = |((number, mode), enclosed): ((u32, BatchMode<'_>), &Enclosed)| {
        Shape::new(mode.vector.iter().map(|x| [*x, 0.0]).collect(), set.mass, *enclosed, mode.kind, number)
    };
    Some((0..).zip(set.modes()).zip(enclosed).map(shape).collect())
}

impl Worker<'_> {
    /// The modes at some places: in full at the first, and where that has symmetry classes or doubles do not decide.
    pub fn tracked(&mut self, places: &[usize]) -> Vec<Tracked> {
        let sweep = self.sweep();
        let full = |place: &usize| Tracked::of(sweep.place(*place));
        let Some((first, others)) = places.split_first() else { return Vec::new() };
        let mut all = vec![full(first)];
        if all[0].shapes().iter().any(|own| own.class.is_some()) {
            all.extend(others.iter().map(full));
            return all;
        }
        let sets = self.sets(others).into_iter();
        let sets = sets.map(|own| own.and_then(|(enclosed, set)| shapes_in_doubles(&enclosed, set)));
        let tracked = |(place, shapes): (&usize, Option<_>)| match shapes {
            Some(shapes) => Tracked { value: sweep.value(*place), modes: Ok(shapes) },
            None => full(place),
        };
        all.extend(others.iter().zip(sets).map(tracked));
        all
    }
}

/// Whether there are other modes with the exponent of one.
pub(crate) fn is_one_of_several(shapes: &Shapes, at: usize) -> bool {
    shapes.iter().filter(|one| one.cluster == shapes[at].cluster).count() > 1
}

/// For each mode of one place that of another, and how sure the least certain pair is.
pub(crate) fn matched(from: &Shapes, to: &Shapes) -> (Pairs, f64) {
    let all = (0..from.len()).flat_map(|i| (0..to.len()).map(move |j| (from[i].likeness(&to[j]), i, j)));
    let mut pairs: Vec<(Likeness, usize, usize)> = all.filter(|own| own.0.agreement > LEAST).collect();
    pairs.order_by(|(p, i, j), (q, k, l)| q.of_states.total_cmp(&p.of_states).then((i, j).cmp(&(k, l))));
    let mut found = vec![None; from.len()];
    let mut taken = vec![false; to.len()];
    let mut sure: f64 = 1.0;
    for (Likeness { agreement, .. }, i, j) in pairs {
        if found[i].is_none() && !taken[j] {
            found[i] = Some(j);
            taken[j] = true;
            // Among equal exponents any basis is as good.
            if !is_one_of_several(from, i) && !is_one_of_several(to, j) && from[i].kind != Kind::Zero {
                sure = sure.min(agreement);
            }
        }
    }
    if from.len() == to.len() && found.iter().any(Option::is_none) {
        sure = 0.0;
    }
    (found, sure)
}

/// Whether two modes change places that may only seem to: shapes that turn into each other within a short way, and are not told apart by
/// their classes on both sides.
fn swaps([from, to]: [&Shapes; 2], found: &[Option<usize>]) -> bool {
    let known: Vec<(usize, usize)> = pairs(found).collect();
    let alike = |a: &Shape, b: &Shape| a.class.is_none() || a.class == b.class;
    known.iter().enumerate().any(|(at, (i, j))| {
        known[at + 1..].iter().any(|(k, l)| {
            let [(a, b), (c, d)] = [(&from[*i], &from[*k]), (&to[*j], &to[*l])];
            l < j && (alike(a, b) || alike(c, d)) && a.cluster != b.cluster && c.cluster != d.cluster
        })
    })
}

/// Modes that belong together, from one place to the next.
pub(crate) type Pairs = Vec<Option<usize>>;

/// The way to the next place: where no finer place is reached, to that of the range.
struct Step {
    found: Pairs,
    finer: Option<Tracked>,
}

/// Follows modes from place to place.
struct Follower {
    /// Frequencies and growths that are off so little are seen as straight.
    slack: [f64; 2],
    /// So many places may still be added where curves bend, and where it is open what belongs together.
    left: [usize; 2],
}

impl Follower {
    fn new(places: &[Tracked]) -> Self {
        let slack = [0, 1].map(|part| {
            let [span, rounding] = span(places.iter().flat_map(Tracked::shapes).map(|mode| point(mode)[part]));
            (FLAT * span).max(rounding)
        });
        Self { slack, left: [FEW_FINER, FEW_OPEN].map(|few| (MOST_FINER * places.len()).max(few)) }
    }

    /// Between which places curves bend, as those beside tell: modes by their numbers.
    fn bent(&self, places: &[Tracked]) -> Vec<bool> {
        // A few points are on many curves.
        let mut bent = vec![places.len() < 3; places.len().saturating_sub(1)];
        for (at, three) in places.windows(3).enumerate() {
            let [Ok(a), Ok(b), Ok(c)] = [0, 1, 2].map(|at| &three[at].modes) else { continue };
            let is_off = |((a, b), c): ((&Shape, &Shape), &Shape)| self.is_off([a, b, c].map(point));
            if a.len() == b.len() && a.len() == c.len() && a.iter().zip(b).zip(c).any(is_off) {
                (bent[at], bent[at + 1]) = (true, true);
            }
        }
        bent
    }

    /// Whether the second of three points, half way between the others, is seen off the line through these.
    fn is_off(&self, points: [[f64; 2]; 3]) -> bool {
        (0..2).any(|part| off_line([0.0, 1.0, 2.0], points.map(|own| own[part])) > self.slack[part])
    }

    /// The modes between two places of a range, which is refined where their shapes leave it open and where curves bend;
    /// `is_bent` if they do so about these places.
    fn connect(
        &mut self,
        sweep: &Sweep,
        ends: [&Shapes; 2],
        between: [usize; 2],
        (found, sure): (Pairs, f64),
        (depth, is_bent): (u32, bool),
        way: &mut Vec<Step>,
    ) {
        let is_swap = swaps(ends, &found);
        let is_open = sure < SURE || is_swap;
        let turns = depth == 0 && pairs(&found).any(|(i, j)| ends[0][i].kind != ends[1][j].kind);
        let is_wanted = self.left[usize::from(is_open)] > 0 && (is_open || is_bent || turns || sure < STEADY);
        let finer = sweep.finer().filter(|_| is_wanted && depth < if is_swap { DEEPEST_SWAP } else { DEEPEST });
        let [from, to] = between.map(|place| 2 * place);
        let middle = finer.and_then(|finer| {
            let place = Tracked::of(finer.place(from + 1));
            let middle = place.modes.as_ref().ok()?;
            // A crossing itself, at which any basis is as good.
            let is_crossing = |at: usize| middle[at].cluster == middle[at - 1].cluster && middle[at].kind != Kind::Zero;
            (!(1..middle.len()).any(is_crossing)).then_some((finer, place))
        });
        let Some((finer, place)) = middle else {
            way.push(Step { found, finer: None });
            return;
        };
        self.left[usize::from(is_open)] -= 1;
        let middle = place.shapes();
        let (first, second) = (matched(ends[0], middle), matched(middle, ends[1]));
        let bends = pairs(&first.0).any(|(i, j)| {
            let Some(k) = second.0[j] else { return false };
            self.is_off([&ends[0][i], &middle[j], &ends[1][k]].map(point))
        });
        self.connect(&finer, [ends[0], middle], [from, from + 1], first, (depth + 1, bends), way);
        let reached = way.len() - 1;
        self.connect(&finer, [middle, ends[1]], [from + 1, to], second, (depth + 1, bends), way);
        way[reached].finer = Some(place);
    }
}

fn pairs(found: &[Option<usize>]) -> impl Iterator<Item = (usize, usize)> + '_ {
    found.iter().enumerate().filter_map(|(i, j)| Some((i, (*j)?)))
}

/// Follows the modes of a sweep from place to place; `places` are all of its places in order, to which finer ones are added where curves
/// through them would be off. A place without modes ends all branches.
#[must_use]
pub fn branches(sweep: &Sweep, places: &mut Vec<Tracked>) -> Vec<Branch> {
    let mut follower = Follower::new(places);
    let bent = follower.bent(places);
    let mut branches: Vec<Branch> = Vec::new();
    // The branches of the modes at the last of all places.
    let mut before: Option<Vec<Option<usize>>> = None;
    let mut all: Vec<Tracked> = Vec::with_capacity(places.len());
    for (number, place) in std::mem::take(places).into_iter().enumerate() {
        let Ok(here) = &place.modes else {
            before = None;
            all.push(place);
            continue;
        };
        let mut way = Vec::new();
        if let (Some(_), Some(last)) = (&before, all.last()) {
            let ends = [last.shapes(), here];
            let found = matched(ends[0], here);
            follower.connect(sweep, ends, [number - 1, number], found, (0, bent[number - 1]), &mut way);
        } else {
            way.push(Step { found: Vec::new(), finer: None });
        }
        let mut last = Some(place);
        for Step { found, finer } in way {
            let Some(mut place) = finer.or_else(|| last.take()) else { continue };
            let here = place.modes.as_deref_mut().unwrap_or_default();
            let mut owners = vec![None; here.len()];
            let old = all.last().map_or(&[][..], Tracked::shapes);
            for ((old, at), branch) in old.iter().zip(found).zip(before.iter().flatten()) {
                let Some(at) = at else { continue };
                owners[at] = *branch;
                if is_one_of_several(here, at) {
                    here[at] = old.clone().of_mode(&here[at]);
                }
            }
            for (at, owner) in owners.iter_mut().enumerate() {
                let branch = *owner.get_or_insert_with(|| {
                    branches.push(Branch { class: None, at: Vec::new() });
                    branches.len() - 1
                });
                branches[branch].at.push((all.len(), at));
            }
            all.push(place);
            before = Some(owners);
        }
    }
    for Branch { class, at } in &mut branches {
        // At single values there may be more symmetry.
        let mut counts: BTreeMap<&Option<String>, usize> = BTreeMap::new();
        for (place, at) in at.iter() {
            *counts.entry(&all[*place].shapes()[*at].class).or_default() += 1;
        }
        *class = counts.into_iter().max_by_key(|own| own.1).and_then(|own| own.0.clone());
    }
    *places = all;
    branches
}
