//! Modes over a range of a parameter, followed by their shapes: which mode at one value is which at the next.
//!
//! Two modes belong together where |xᴴ M y|² is large, M being the mass matrix at the first value (the modal assurance criterion of
//! R. J. Allemang and D. L. Brown, Proc. 1st Int. Modal Analysis Conf., 1982), and s x is near to s' y: exponents s and -s may have one
//! shape. Where it decides nothing, or two modes seem to change
//! places, the interval is halved, and halved again: at an avoided crossing shapes turn into each other, at a crossing they keep what
//! they are. So it is where frequencies bend. Modes of different symmetry classes never belong together. Among equal frequencies no shape is one of a mode; those before
//! are kept until they part again.

use crate::refine::{DEEPEST, FLAT, MOST_FINER, off_line, span};
use crate::sweep::{Place, Sweep};
use librate_core::linearize::Linearized;
use librate_core::modes::Kind;
use librate_core::order::Order;
use librate_core::oscillation::{NormalMode, NormalModes};

/// Shapes that agree less leave it open what belongs together.
const SURE: f64 = 0.7;
/// Those that agree less than this have nothing in common.
const LEAST: f64 = 0.05;
/// Between shapes that agree less frequencies may bend.
const STEADY: f64 = 0.98;
/// Where modes change places an interval is halved until bounds no longer separate them.
const DEEPEST_SWAP: u32 = 34;
/// Masses of more coordinates count alike.
const MOST_DENSE: usize = 600;

/// A mode followed over a range.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Branch {
    /// Its symmetry class, where it has one.
    pub class: Option<String>,
    /// The places where it is, each with its number among the modes there.
    pub at: Vec<(usize, usize)>,
}

/// A mode as it is compared.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    /// Real and imaginary part of each component.
    vector: Vec<[f64; 2]>,
    /// M times it, and the root of xᴴMx.
    image: Vec<[f64; 2]>,
    length: f64,
    class: Option<String>,
    pub(crate) cluster: u32,
    kind: Kind,
    /// Frequency and growth.
    point: [f64; 2],
}

impl Shape {
    /// |xᴴ M y|²/(xᴴMx · yᴴMy), 1 for the same shape.
    fn agreement(&self, other: &Self) -> f64 {
        if let (Some(own), Some(others)) = (&self.class, &other.class)
            && own != others
        {
            return 0.0;
        }
        let [re, im] = self.product(other);
        if self.length <= 0.0 || other.length <= 0.0 { 0.0 } else { (re * re + im * im) / (self.length * other.length) }
    }

    /// xᴴ M y, real and imaginary part.
    pub(crate) fn product(&self, other: &Self) -> [f64; 2] {
        let parts = self.image.iter().zip(&other.vector);
        parts.fold([0.0; 2], |[re, im], ([a, b], [c, d])| [re + a * c + b * d, im + a * d - b * c])
    }

    /// The part of the agreement that the states have, (x, s x/s0) with the larger exponent for s0.
    fn share_of_states(&self, other: &Self) -> f64 {
        let [[a, b], [c, d]] = [self.point, other.point];
        let both = a * a + b * b + c * c + d * d;
        if both > 0.0 { 0.5 + (a * c + b * d) / both } else { 1.0 }
    }

    /// The shape as one of a number of equal ones.
    pub(crate) fn in_cluster(self, cluster: u32) -> Self {
        Self { cluster, ..self }
    }
}

/// The modes at a place.
pub(crate) type Shapes = Vec<Shape>;

fn point(mode: &NormalMode) -> [f64; 2] {
    [mode.omega.mid_f64(), mode.growth.mid_f64()]
}

pub(crate) fn shapes(linearized: &Linearized, modes: &NormalModes) -> Shapes {
    let n = modes.modes.first().map_or(0, |mode| mode.vector.len());
    let mass = if n <= MOST_DENSE { linearized.mass() } else { Vec::new() };
    let mass: Vec<f64> = if mass.len() == n * n { mass.iter().map(|own| own.mid_f64()).collect() } else { Vec::new() };
    // Where no motion has inertia, components count alike.
    let mass = if mass.iter().all(|own| *own == 0.0) { Vec::new() } else { mass };
    let shape = |mode: &NormalMode| {
        let imaginary = mode.imaginary.iter().copied().chain(std::iter::repeat(0.0));
        let vector: Vec<[f64; 2]> = mode.vector.iter().zip(imaginary).map(|(re, im)| [*re, im]).collect();
        let image: Vec<[f64; 2]> = if mass.is_empty() {
            vector.clone()
        } else {
            let row = |row: &[f64]| {
                let parts = row.iter().zip(&vector);
                parts.fold([0.0; 2], |[re, im], (entry, part)| [re + entry * part[0], im + entry * part[1]])
            };
            mass.chunks(n).map(row).collect()
        };
        let length = vector.iter().zip(&image).map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum();
        Shape {
            vector,
            image,
            length,
            class: mode.symmetry.clone(),
            cluster: mode.cluster,
            kind: mode.kind,
            point: point(mode),
        }
    };
    modes.modes.iter().map(shape).collect()
}

/// Whether there are other modes with the exponent of one.
pub(crate) fn is_one_of_several(shapes: &Shapes, at: usize) -> bool {
    shapes.iter().filter(|one| one.cluster == shapes[at].cluster).count() > 1
}

/// For each mode of one place that of another, and how sure the least certain pair is.
pub(crate) fn matched(from: &Shapes, to: &Shapes) -> (Pairs, f64) {
    let all = (0..from.len()).flat_map(|i| (0..to.len()).map(move |j| (from[i].agreement(&to[j]), i, j)));
    let likely = all.filter(|(agreement, ..)| *agreement > LEAST);
    let mut pairs: Vec<(f64, (f64, usize, usize))> =
        likely.map(|own| (own.0 * from[own.1].share_of_states(&to[own.2]), own)).collect();
    pairs.order_by(|(p, a), (q, b)| q.total_cmp(p).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut found = vec![None; from.len()];
    let mut taken = vec![false; to.len()];
    let mut sure: f64 = 1.0;
    for (_, (agreement, i, j)) in pairs {
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
/// their classes.
fn swaps([from, to]: [&Shapes; 2], found: &[Option<usize>]) -> bool {
    let known: Vec<(usize, usize)> = pairs(found).collect();
    let alike = |i: usize, k: usize| from[i].class.is_none() || from[i].class == from[k].class;
    let single = |i: usize, k: usize| from[i].cluster != from[k].cluster;
    known.iter().enumerate().any(|(at, (i, j))| {
        let later = &known[at + 1..];
        later.iter().any(|(k, l)| l < j && alike(*i, *k) && single(*i, *k) && to[*j].cluster != to[*l].cluster)
    })
}

/// Modes that belong together, from one place to the next.
pub(crate) type Pairs = Vec<Option<usize>>;

/// The way to the next place: where no finer place is reached, to that of the range.
struct Step {
    found: Pairs,
    finer: Option<(Place, Shapes)>,
}

/// Follows modes from place to place.
struct Follower {
    /// Frequencies and growths that are off so little are seen as straight.
    slack: [f64; 2],
    /// So many places may still be added where curves bend.
    left: usize,
}

impl Follower {
    fn new(places: &[Place]) -> Self {
        let slack = [0, 1].map(|part| {
            let solved = places.iter().filter_map(|place| place.result.as_ref().ok());
            let all = solved.flat_map(|(_, modes)| &modes.modes).map(|mode| point(mode)[part]);
            let [span, rounding] = span(all);
            (FLAT * span).max(rounding)
        });
        Self { slack, left: MOST_FINER * places.len() }
    }

    /// Between which places curves bend, as those beside tell: modes by their numbers.
    fn bent(&self, places: &[Place]) -> Vec<bool> {
        // A few points are on many curves.
        let mut bent = vec![places.len() < 3; places.len().saturating_sub(1)];
        for (at, three) in places.windows(3).enumerate() {
            let modes = three.iter().map_while(|place| Some(&place.result.as_ref().ok()?.1.modes));
            let [a, b, c] = modes.collect::<Vec<_>>()[..] else { continue };
            let is_off = |((a, b), c): ((&NormalMode, &NormalMode), &NormalMode)| self.is_off([a, b, c].map(point));
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
        let is_wanted = is_open || self.left > 0 && (is_bent || turns || sure < STEADY);
        let finer = sweep.finer().filter(|_| is_wanted && depth < if is_swap { DEEPEST_SWAP } else { DEEPEST });
        let [from, to] = between.map(|place| 2 * place);
        let middle = finer.and_then(|finer| {
            let place = finer.place(from + 1);
            let (linearized, modes) = place.result.as_ref().ok()?;
            let middle = shapes(linearized, modes);
            // A crossing itself, at which any basis is as good.
            let is_crossing = |at: usize| middle[at].cluster == middle[at - 1].cluster && middle[at].kind != Kind::Zero;
            (!(1..middle.len()).any(is_crossing)).then_some((finer, place, middle))
        });
        let Some((finer, place, middle)) = middle else {
            way.push(Step { found, finer: None });
            return;
        };
        self.left = self.left.saturating_sub(1);
        let (first, second) = (matched(ends[0], &middle), matched(&middle, ends[1]));
        let bends = pairs(&first.0).any(|(i, j)| {
            let Some(k) = second.0[j] else { return false };
            self.is_off([&ends[0][i], &middle[j], &ends[1][k]].map(|own| own.point))
        });
        self.connect(&finer, [ends[0], &middle], [from, from + 1], first, (depth + 1, bends), way);
        let reached = way.len() - 1;
        self.connect(&finer, [&middle, ends[1]], [from + 1, to], second, (depth + 1, bends), way);
        way[reached].finer = Some((place, middle));
    }
}

fn pairs(found: &[Option<usize>]) -> impl Iterator<Item = (usize, usize)> + '_ {
    found.iter().enumerate().filter_map(|(i, j)| Some((i, (*j)?)))
}

/// Follows the modes of a sweep from place to place; `places` are all of its places, with shapes, in order, to which finer ones are
/// added where curves through them would be off. A place without modes ends all branches.
#[must_use]
pub fn branches(sweep: &Sweep, places: &mut Vec<Place>) -> Vec<Branch> {
    let mut follower = Follower::new(places);
    let bent = follower.bent(places);
    let mut branches: Vec<Branch> = Vec::new();
    // Of the modes at the place before: their shapes, and their branches.
    let mut before: Option<(Shapes, Vec<Option<usize>>)> = None;
    let mut all: Vec<Place> = Vec::with_capacity(places.len());
    for (number, place) in std::mem::take(places).into_iter().enumerate() {
        let Ok((linearized, modes)) = &place.result else {
            before = None;
            all.push(place);
            continue;
        };
        let here = shapes(linearized, modes);
        let mut way = Vec::new();
        if let Some((shapes, _)) = &before {
            let found = matched(shapes, &here);
            follower.connect(sweep, [shapes, &here], [number - 1, number], found, (0, bent[number - 1]), &mut way);
        } else {
            way.push(Step { found: Vec::new(), finer: None });
        }
        let mut last = Some((place, here));
        for Step { found, finer } in way {
            let is_finer = finer.is_some();
            let Some((place, mut here)) = finer.or_else(|| last.take()) else { continue };
            let mut owners = vec![None; here.len()];
            if let Some((shapes, known)) = &before {
                for ((old, at), branch) in shapes.iter().zip(found).zip(known) {
                    let Some(at) = at else { continue };
                    owners[at] = *branch;
                    if is_one_of_several(&here, at) {
                        let Shape { cluster, point, .. } = here[at];
                        here[at] = Shape { cluster, point, ..old.clone() };
                    }
                }
            }
            for (at, owner) in owners.iter_mut().enumerate() {
                if owner.is_none() && !is_finer {
                    branches.push(Branch { class: here[at].class.clone(), at: Vec::new() });
                    *owner = Some(branches.len() - 1);
                }
                if let Some(branch) = owner {
                    branches[*branch].at.push((all.len(), at));
                }
            }
            all.push(place);
            before = Some((here, owners));
        }
    }
    *places = all;
    branches
}
