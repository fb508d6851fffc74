//! Signed permutations of coordinates that leave a pair of symmetric matrices unchanged.
//!
//! A [`Pattern`] says which entries are equal to each other or opposite, and nothing more, so that numbers
//! and expressions are treated alike. [`Symmetry::find`] gives generators of the group, by refinement of
//! hashed rows and a search with a limited effort, and says what kind of group it is: mirrors that
//! commute, the turns of a ring, or another. [`Classes`] is what tells vectors of different symmetry apart.
//!
//! Permutations without signs come first. One with signs is a permutation of the coordinates and of their
//! opposites at once, which keeps each beside its own opposite; changing the sign of everything that hangs
//! together is always possible and counts as nothing. What no force holds has no place in a symmetry and is
//! left out. [`Symmetry::kept`] is the part of a group that is a symmetry of more, the energies say; `points` finds
//! what permutes the axes of bodies, and `figure` the whole point group where their energies turn freely; both have the
//! names of `point_group`.

use crate::groups::Groups;
use crate::linearize::Invariance;
use crate::order::Order;

mod classes;
mod figure;
mod pattern;
mod point_group;
mod points;
mod search;

use std::collections::BTreeSet;

pub use classes::{Classes, wave_number};
pub(crate) use figure::point_group;
pub use pattern::Pattern;
use points::{Moves, independent};

/// Looks at edges before the search is given up: well below a second.
const EFFORT: usize = 40_000_000;

/// Groups of more elements are judged by their generators.
const MOST_TRIED: usize = 256;
/// Fewer mirrors are put in an order of their own.
const MOST_SORTED: usize = 8;
/// With more parts that may change their sign all do or none.
const MOST_PARTS: usize = 6;

/// A permutation of the coordinates with signs: the unit vector of coordinate i goes to that of `image[i]`,
/// with the opposite sign where `negative[i]`.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[must_use]
pub struct SignedPermutation {
    image: Vec<usize>,
    negative: Vec<bool>,
}

impl SignedPermutation {
    /// A permutation without signs.
    pub(crate) fn unsigned(image: Vec<usize>) -> Self {
        let negative = vec![false; image.len()];
        Self { image, negative }
    }

    /// How many coordinates there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.image.len()
    }

    /// Whether there are no coordinates.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.image.is_empty()
    }

    /// Where a coordinate goes, and whether its sign changes.
    #[must_use]
    pub fn of(&self, coordinate: usize) -> (usize, bool) {
        let image = self.image.get(coordinate).copied().unwrap_or(coordinate);
        let negative = self.negative.get(coordinate).copied().unwrap_or(false);
        (image, negative)
    }

    /// How many coordinates change their sign.
    fn negatives(&self) -> usize {
        self.negative.iter().filter(|negative| **negative).count()
    }

    /// Whether every coordinate stays where it is, signs aside.
    pub(crate) fn moves_nothing(&self) -> bool {
        self.image.iter().enumerate().all(|(i, j)| i == *j)
    }

    /// Whether nothing changes.
    pub(crate) fn is_identity(&self) -> bool {
        self.moves_nothing() && !self.negative.contains(&true)
    }

    /// First the other one, then this one.
    pub(crate) fn after(&self, other: &Self) -> Self {
        let end = |i: usize| {
            let (middle, first) = other.of(i);
            let (end, second) = self.of(middle);
            (end, first != second)
        };
        (0..other.len()).map(end).collect()
    }

    /// The one that undoes it.
    pub(crate) fn inverse(&self) -> Self {
        let mut image = vec![0; self.len()];
        let mut negative = vec![false; self.len()];
        for i in 0..self.len() {
            let (to, sign) = self.of(i);
            image[to] = i;
            negative[to] = sign;
        }
        Self { image, negative }
    }

    /// g · self · g⁻¹.
    fn conjugated(&self, g: &Self) -> Self {
        g.after(self).after(&g.inverse())
    }

    /// Elements of the group of some generators, the identity among them: all, or where there are more
    /// so many.
    #[must_use]
    pub fn group(generators: &[Self], most: usize) -> Vec<Self> {
        let Some(first) = generators.first() else { return Vec::new() };
        let identity = Self::unsigned((0..first.len()).collect());
        let mut known = BTreeSet::from([identity.clone()]);
        let mut all = vec![identity];
        let mut next = 0;
        while let Some(element) = all.get(next).cloned() {
            next += 1;
            for g in generators {
                let product = g.after(&element);
                if all.len() >= most {
                    return all;
                }
                if known.insert(product.clone()) {
                    all.push(product);
                }
            }
        }
        all
    }

    /// The length of the cycles of the coordinates in `active`, if they all have the same and no sign
    /// changes.
    fn common_cycle(&self, active: &[bool]) -> Option<usize> {
        let cycle = cycles(self);
        let mut lengths = vec![0; self.len()];
        for (i, own) in cycle.iter().enumerate() {
            lengths[*own] += 1;
            if active[*own] && self.of(i).1 {
                return None;
            }
        }
        let mut active = (0..self.len()).filter(|i| active[*i]).map(|i| lengths[cycle[i]]);
        let common = active.next()?;
        active.all(|length| length == common).then_some(common)
    }
}

impl FromIterator<(usize, bool)> for SignedPermutation {
    /// From where each coordinate goes, and whether its sign changes.
    fn from_iter<I: IntoIterator<Item = (usize, bool)>>(all: I) -> Self {
        let (image, negative) = all.into_iter().unzip();
        Self { image, negative }
    }
}

/// The symmetry of a pattern.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Symmetry {
    /// The generators; none of them is in the group of those before it, signs of what hangs together
    /// aside.
    pub generators: Vec<SignedPermutation>,
    /// How many elements the group has, signs of what hangs together aside.
    pub order: f64,
    /// What kind of group it is.
    pub kind: GroupKind,
    /// The coordinates that some force holds; the others are left out.
    pub active: Vec<bool>,
    /// The part that each coordinate is in: what hangs together has the same number.
    pub parts: Vec<usize>,
    /// Whether there is no more with signs.
    whole: bool,
    /// The changes of sign of some parts, where there are several, that are symmetries too.
    flips: Vec<SignedPermutation>,
    /// The turns of the axes, where it is that of bodies.
    points: Option<Moves>,
}

/// What kind of group a symmetry is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GroupKind {
    /// Mirrors that commute: each vector of a mode is even or odd under each.
    Mirrors(Vec<SignedPermutation>),
    /// A ring: `turn` moves every coordinate to its neighbour, in cycles of `length`, which is 3 at least.
    Ring {
        /// The turn by one place.
        turn: SignedPermutation,
        /// How many turns there are.
        length: usize,
    },
    /// Any other group.
    Other,
}

impl Invariance {
    /// Whether a signed permutation leaves the energies unchanged.
    pub(crate) fn keeps(&mut self, g: &SignedPermutation) -> bool {
        self.permuted(|i| g.of(i)) == Some(true)
    }
}

impl Symmetry {
    /// The symmetry of a pattern, if it has any and the search comes to its end. A mirror without signs
    /// is taken as it is, whether or not there is more with signs: see [`Symmetry::find_signed`].
    #[must_use]
    pub fn find(pattern: &Pattern) -> Option<Self> {
        let active = pattern.active();
        if pattern.all_differ(&active)? {
            return None;
        }
        let parts = pattern.components();
        let unsigned = pattern.permutations(&active, EFFORT)?;
        // A mirror that leaves a part alone says nothing about that part.
        let groups = pattern.parts();
        let acts = |g: &SignedPermutation, on: &[usize]| on.iter().any(|i| g.of(*i).0 != *i || !active[*i]);
        let acts_everywhere = |g: &SignedPermutation| groups.iter().all(|part| acts(g, part));
        let is_mirror = unsigned.order == 2.0 && unsigned.generators.iter().all(acts_everywhere);
        let plain = Self::of(unsigned.generators, unsigned.order, &active, &parts);
        let is_ring = |found: &Self| matches!(found.kind, GroupKind::Ring { .. }) && parts.iter().all(|p| *p == 0);
        if is_mirror || plain.as_ref().is_some_and(is_ring) {
            return plain;
        }
        match Self::find_signed(pattern) {
            Some(signed) if signed.order > unsigned.order => Some(signed),
            Some(_) | None => plain.map(|plain| Self { whole: true, ..plain }),
        }
    }

    /// Whether the group may be larger with signs, which [`Symmetry::find_signed`] would find.
    pub(crate) fn may_be_larger(&self) -> bool {
        !self.whole
    }

    /// Whether a pattern may have classes of symmetry: cheap beside the search, and `false` only where that comes
    /// to nothing, because all coordinates differ or so many are alike that the group is too large.
    #[must_use]
    pub fn may_have_classes(pattern: &Pattern) -> bool {
        let active = pattern.active();
        pattern.all_differ(&active) == Some(false) && !classes::too_many(pattern.most_alike(&active), pattern.len())
    }

    /// The whole group with signs.
    #[must_use]
    pub fn find_signed(pattern: &Pattern) -> Option<Self> {
        let active = pattern.active();
        let signed = pattern.signed_permutations(&active, EFFORT)?;
        let found = Self::of(signed.generators, signed.order, &active, &pattern.components());
        found.map(|found| Self { whole: true, ..found })
    }

    fn of(generators: Vec<SignedPermutation>, order: f64, active: &[bool], parts: &[usize]) -> Option<Self> {
        if generators.is_empty() {
            return None;
        }
        let kind = ring(&generators, order, active).or_else(|| mirrors(&generators)).unwrap_or(GroupKind::Other);
        let flips = parts.iter().max().map_or(0, |last| last + 1);
        Some(Self {
            generators,
            order,
            kind,
            active: active.to_vec(),
            parts: parts.to_vec(),
            whole: false,
            flips: (0..flips).filter(|_| flips > 1).map(|part| flipped(parts, |own| own == part)).collect(),
            points: None,
        })
    }

    /// The symmetry of energies with a pattern of M and K: that of bodies where the coordinates are those of several at
    /// different places, else what stands of that of the pattern.
    pub(crate) fn of_energies(pattern: &Pattern, energies: &mut Invariance) -> Option<Self> {
        if let Some(bodies) = energies.bodies()
            && let Some(found) = Self::of_bodies(&bodies, pattern, energies)
        {
            return Some(found);
        }
        let mut keeps = |g: &SignedPermutation| energies.keeps(g);
        let plain = Self::find(pattern)?;
        let own = plain.kept(&mut keeps);
        let order = own.as_ref().map_or(1.0, |own| own.order);
        if order >= plain.order || !plain.may_be_larger() {
            return own;
        }
        let signed = Self::find_signed(pattern).and_then(|found| found.kept(&mut keeps));
        signed.filter(|signed| signed.order > order).or(own)
    }

    /// The part of a symmetry of M and K that is one of more than these, which `keeps` says; signs of
    /// what hangs together are chosen so, the fewest that will do.
    #[must_use]
    pub fn kept(&self, keeps: &mut dyn FnMut(&SignedPermutation) -> bool) -> Option<Self> {
        let count = self.parts.iter().max().map_or(0, |last| last + 1);
        let masks = if count <= MOST_PARTS { (0..1_u32 << count).collect() } else { vec![0, u32::MAX] };
        let signs = |mask: &u32| {
            let turned = |part: usize| mask >> part.min(31) & 1 == 1;
            flipped(&self.parts, turned)
        };
        let signs: Vec<SignedPermutation> = masks.iter().map(signs).collect();
        let mut lifted = |g: &SignedPermutation| {
            let mut all: Vec<SignedPermutation> = signs.iter().map(|sign| g.after(sign)).collect();
            all.order_by(|a, b| (a.negatives(), a).cmp(&(b.negatives(), b)));
            all.into_iter().find(|g| keeps(g))
        };
        let lifts: Vec<Option<SignedPermutation>> = self.generators.iter().map(&mut lifted).collect();
        let all_stand = lifts.iter().all(Option::is_some);
        let mut generators: Vec<SignedPermutation> = lifts.into_iter().flatten().collect();
        let mut order = self.order;
        if !all_stand {
            let elements = SignedPermutation::group(&self.generators, MOST_TRIED + 1);
            // At most half of a group is a smaller one.
            order /= 2.0;
            if elements.len() <= MOST_TRIED {
                // Signs of parts aside.
                let mut found: Vec<SignedPermutation> = Vec::new();
                for g in elements.iter().filter(|g| !g.moves_nothing()) {
                    let is_new = found.iter().all(|known| known.image != g.image);
                    found.extend(is_new.then(|| lifted(g)).flatten());
                }
                order = found.len() as f64 + 1.0;
                generators = independent(found);
            }
        }
        // Mirrors in an order that does not depend on the search.
        if mirrors(&generators).is_some() && generators.len() < MOST_SORTED {
            let all = SignedPermutation::group(&generators, 1 << MOST_SORTED);
            generators = independent(all);
        }
        let mut own = Self::of(generators, order, &self.active, &self.parts)?;
        own.whole = self.whole;
        own.flips.retain(|flip| keeps(flip));
        Some(own)
    }

    /// The class of vectors that are odd under some of the mirrors that are its kind.
    pub(crate) fn class_under_mirrors(&self, odd: &[bool]) -> String {
        let words: Vec<&str> = odd.iter().map(|odd| if *odd { "odd" } else { "even" }).collect();
        let (GroupKind::Mirrors(mirrors), Some(points)) = (&self.kind, &self.points) else { return words.join(", ") };
        let mut all = vec![(SignedPermutation::unsigned((0..self.parts.len()).collect()), 1.0)];
        for (mirror, odd) in mirrors.iter().zip(odd) {
            let sign = if *odd { -1.0 } else { 1.0 };
            let more: Vec<_> = all.iter().map(|(g, own)| (mirror.after(g), own * sign)).collect();
            all.extend(more);
        }
        let character = |g: &SignedPermutation| {
            let mut own = all.iter().filter(|(h, _)| h == g);
            own.next().map(|(_, sign)| *sign)
        };
        points.name(&character).unwrap_or_else(|| words.join(", "))
    }
}

/// The change of sign of some parts.
fn flipped(parts: &[usize], which: impl Fn(usize) -> bool) -> SignedPermutation {
    SignedPermutation { image: (0..parts.len()).collect(), negative: parts.iter().map(|part| which(*part)).collect() }
}

/// Mirrors undo themselves and each other's order does not matter.
fn mirrors(generators: &[SignedPermutation]) -> Option<GroupKind> {
    let undoes_itself = |g: &SignedPermutation| g.after(g).is_identity();
    let commutes = |g: &SignedPermutation| generators.iter().all(|h| g.after(h) == h.after(g));
    let all = generators.iter().all(|g| undoes_itself(g) && commutes(g));
    all.then(|| GroupKind::Mirrors(generators.to_vec()))
}

/// A ring: a turn in equal cycles which all other elements keep or turn back, in a group with nothing
/// but turns and the mirrors of a polygon, none of which joins two cycles.
fn ring(generators: &[SignedPermutation], order: f64, active: &[bool]) -> Option<GroupKind> {
    for turn in generators.iter().cloned().chain(products(generators)) {
        let Some(length) = turn.common_cycle(active).filter(|length| *length >= 3) else { continue };
        let turns = length as f64;
        let back = turn.inverse();
        let keeps = |g: &SignedPermutation| {
            let moved = turn.conjugated(g);
            moved == turn || moved == back
        };
        let cycle = cycles(&turn);
        let joins = |g: &SignedPermutation| (0..g.len()).any(|i| active[i] && cycle[g.of(i).0] != cycle[i]);
        if (order == turns || order == 2.0 * turns) && generators.iter().all(|g| keeps(g) && !joins(g)) {
            return Some(GroupKind::Ring { turn, length });
        }
    }
    None
}

/// The products of two generators each, in one order.
fn products(generators: &[SignedPermutation]) -> impl Iterator<Item = SignedPermutation> {
    generators.iter().enumerate().flat_map(|(i, g)| generators.iter().skip(i + 1).map(|h| g.after(h)))
}

/// The cycle that each coordinate is in, named by its first coordinate.
fn cycles(turn: &SignedPermutation) -> Vec<usize> {
    let mut together = Groups::new(turn.len());
    (0..turn.len()).for_each(|i| together.join(i, turn.of(i).0));
    (0..turn.len()).map(|i| together.least(i)).collect()
}
