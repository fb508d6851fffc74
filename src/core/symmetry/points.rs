//! Point groups: turns and mirrors of the axes that take bodies to bodies, and the names of their classes.
//!
//! The names are Mulliken's (J. Chem. Phys. 23 (1955) 1997; Landau and Lifshitz, Quantum Mechanics, §95), read off
//! the characters: A and B by the sign under the main turn, E and T for two and three vectors that belong
//! together, g and u by inversion, 1 and 2 by the turns across the main axis or else the mirrors through it,
//! those along the axes of coordinates first. The molecule of C2v that is plane lies in the plane of 1's
//! opposite, as there; in D2 and D2h, B1, B2 and B3 are what the turns about z, y and x leave unchanged. A straight
//! molecule that turns freely has sigma along its axis and pi across.

use std::collections::{BTreeMap, HashMap};

use super::{GroupKind, Pattern, SignedPermutation, Symmetry};
use crate::linearize::{Bodies, Invariance};

/// What an element of a point group does to the bodies' coordinates, and to the axes.
#[derive(Clone, Debug)]
struct Element {
    moves: SignedPermutation,
    axes: SignedPermutation,
    /// Whether every body stays where it is.
    fixes_bodies: bool,
}

/// A point group.
#[derive(Clone, Debug)]
pub(super) struct PointGroup {
    elements: Vec<Element>,
    /// Whether the bodies are in a row about which all turns freely.
    straight: bool,
}

/// An axis of coordinates that the bodies are all on, if there is one.
fn row(bodies: &Bodies) -> Option<usize> {
    let off = |k: usize| bodies.places.iter().any(|place| place[k] != 0);
    let mut moved = (0..bodies.axes.len()).filter(|k| off(*k));
    moved.next().filter(|_| moved.next().is_none())
}

/// All permutations of a few axes with all signs.
fn turns(width: usize) -> Vec<SignedPermutation> {
    let mut orders: Vec<Vec<usize>> = vec![Vec::new()];
    for _ in 0..width {
        let longer = orders.iter().flat_map(|order| {
            let open = (0..width).filter(|axis| !order.contains(axis));
            open.map(|axis| [order.as_slice(), &[axis]].concat())
        });
        orders = longer.collect();
    }
    let signed = orders.into_iter().flat_map(|image| {
        (0..1_u32 << width).map(move |signs| SignedPermutation {
            image: image.clone(),
            negative: (0..width).map(|k| signs & (1 << k) != 0).collect(),
        })
    });
    signed.collect()
}

/// Where the coordinates of bodies go, if each body goes where there is another.
fn moved(bodies: &Bodies, axes: &SignedPermutation) -> Option<Element> {
    let at: HashMap<&[u64], usize> = bodies.places.iter().map(Vec::as_slice).zip(0..).collect();
    let count = bodies.axes.iter().map(Vec::len).sum();
    let mut moves = SignedPermutation::unsigned((0..count).collect());
    let mut fixes_bodies = true;
    for (body, place) in bodies.places.iter().enumerate() {
        let mut image = vec![0; place.len()];
        for (k, value) in place.iter().enumerate() {
            let (to, negative) = axes.of(k);
            image[to] = if negative { crate::expr::neg_mod(*value) } else { *value };
        }
        let other = *at.get(image.as_slice())?;
        fixes_bodies &= other == body;
        for (k, own) in bodies.axes.iter().enumerate() {
            let (to, negative) = axes.of(k);
            moves.image[own[body]] = bodies.axes[to][other];
            moves.negative[own[body]] = negative;
        }
    }
    Some(Element { moves, axes: axes.clone(), fixes_bodies })
}

impl Symmetry {
    /// The symmetry of bodies: the turns and mirrors of the axes that leave the energies unchanged, as they act
    /// where some force holds.
    pub(super) fn of_bodies(bodies: &Bodies, pattern: &Pattern, energies: &mut Invariance) -> Option<Self> {
        let active = pattern.active();
        let parts = pattern.components();
        let width = bodies.axes.len();
        let held = |k: usize| bodies.axes[k].iter().any(|i| active[*i]);
        let mut found: BTreeMap<SignedPermutation, Element> = BTreeMap::new();
        let mut faithful = true;
        for axes in turns(width) {
            // An axis along which nothing is held has no place in it.
            if (0..width).any(|k| !held(k) && axes.of(k) != (k, false)) {
                continue;
            }
            let Some(mut element) = moved(bodies, &axes) else {
                continue;
            };
            if !element.moves.is_identity() && !energies.keeps(&element.moves) {
                continue;
            }
            for i in (0..active.len()).filter(|i| !active[*i]) {
                element.moves.image[i] = i;
                element.moves.negative[i] = false;
            }
            faithful &= found.insert(element.moves.clone(), element).is_none();
        }
        let elements: Vec<Element> = found.into_values().collect();
        let moves = elements.iter().map(|element| element.moves.clone());
        let generators = independent(moves.collect());
        let order = elements.len() as f64;
        let mut own = Self::of(generators, order, &active, &parts)?;
        // Of a ring of bodies in space the turns alone would tell less.
        if let GroupKind::Ring { .. } = own.kind {
            own.kind = GroupKind::Other;
        }
        own.flips.clear();
        own.whole = true;
        let straight = row(bodies).filter(|_| width == 3);
        let straight =
            straight.is_some_and(|k| energies.turns_freely(&bodies.axes[(k + 1) % 3], &bodies.axes[(k + 2) % 3]));
        own.points = (faithful && elements.len() > 2).then_some(PointGroup { elements, straight });
        Some(own)
    }
}

/// Elements that generate a whole group, those with the fewest signs first.
pub(super) fn independent(mut elements: Vec<SignedPermutation>) -> Vec<SignedPermutation> {
    elements.sort_by_cached_key(|g| (g.negatives(), g.clone()));
    let mut generators: Vec<SignedPermutation> = Vec::new();
    let mut known = Vec::new();
    for g in elements.iter().filter(|g| !g.is_identity()) {
        if !known.contains(g) {
            generators.push(g.clone());
            known = SignedPermutation::group(&generators, elements.len());
        }
    }
    generators
}

/// What a turn or mirror of three axes is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Turn {
    Nothing,
    /// A turn by the whole over this.
    Proper(u8),
    Mirror,
    Inversion,
    /// A turn by a quarter with a mirror across.
    Quarter,
    /// A turn by a sixth with a mirror across.
    Sixth,
}

impl Element {
    /// In a plane the third axis stays.
    fn turn(&self) -> Turn {
        let width = self.axes.len();
        let mut trace: i32 = if width == 2 { 1 } else { 0 };
        let mut determinant = 1;
        for k in 0..width {
            let (to, negative) = self.axes.of(k);
            let sign = if negative { -1 } else { 1 };
            determinant *= sign;
            trace += if to == k { sign } else { 0 };
            // Inversions of the order.
            let crossed = (0..k).filter(|before| self.axes.of(*before).0 > to);
            determinant *= if crossed.count() % 2 == 1 { -1 } else { 1 };
        }
        match (determinant, trace) {
            (1, 3) => Turn::Nothing,
            (1, 1) => Turn::Proper(4),
            (1, 0) => Turn::Proper(3),
            (1, _) => Turn::Proper(2),
            (_, 1) => Turn::Mirror,
            (_, 0) => Turn::Sixth,
            (_, -1) => Turn::Quarter,
            (_, _) => Turn::Inversion,
        }
    }

    fn along_axes(&self) -> bool {
        self.axes.moves_nothing()
    }

    /// Whether it leaves an axis as it is, or turns it around.
    fn keeps(&self, axis: usize, around: bool) -> bool {
        axis >= self.axes.len() && !around || self.axes.of(axis) == (axis, around)
    }
}

impl PointGroup {
    /// What the elements do to coordinates.
    pub(super) fn moves(&self) -> impl Iterator<Item = SignedPermutation> {
        self.elements.iter().map(|element| element.moves.clone())
    }

    /// The name of a class, given what each element is on it, divided by how many vectors belong together.
    pub(super) fn name(&self, character: &dyn Fn(&SignedPermutation) -> Option<f64>) -> Option<String> {
        let all: Option<Vec<(&Element, f64)>> =
            self.elements.iter().map(|element| Some((element, character(&element.moves)?))).collect();
        let all = all?;
        let with = |turn: Turn| all.iter().filter(move |(own, _)| own.turn() == turn);
        let sign = |turn: Turn| with(turn).next().map(|(_, value)| *value > 0.0);
        let parity = match sign(Turn::Inversion) {
            Some(true) => "g",
            Some(false) => "u",
            None => "",
        };
        // The characters' squares add up to the order; in these units to as much over the number of vectors
        // squared, or where a pair is complex over 2.
        let squares: f64 = all.iter().map(|(_, value)| value * value).sum();
        let together = all.len() as f64 / squares;
        if self.straight {
            let letter = if together < 1.5 { "sigma" } else { "pi" };
            let line = if parity.is_empty() { "" } else { "_" };
            return Some(format!("{letter}{line}{parity}"));
        }
        let quarter = sign(Turn::Proper(4)).or(sign(Turn::Quarter));
        let number = |one: Option<bool>| match one {
            Some(true) => "1",
            Some(false) => "2",
            None => "",
        };
        let cubic = with(Turn::Proper(3)).count() > 2;
        if cubic || together > 1.5 {
            let letter = match together {
                x if x < 1.5 => "A",
                x if x < 5.0 => "E",
                _ => "T",
            };
            let number = if letter == "E" { "" } else { number(quarter) };
            return Some(format!("{letter}{number}{parity}"));
        }
        let threefold = with(Turn::Proper(3)).next().is_some();
        let mut halves: Vec<&(&Element, f64)> = with(Turn::Proper(2)).collect();
        // Along z before y before x, then the others.
        let place = |element: &Element| (0..3).rev().position(|k| element.keeps(k, false));
        halves.sort_by_key(|(own, _)| (!own.along_axes(), place(own)));
        if let ([(_, a), (_, b), (_, c)], None, false) = (halves.as_slice(), quarter, threefold) {
            let letter = match (*a > 0.0, *b > 0.0, *c > 0.0) {
                (true, true, true) => "A",
                (true, ..) => "B1",
                (_, true, _) => "B2",
                _ => "B3",
            };
            // In D2h parity says what is left.
            return Some(format!("{letter}{parity}"));
        }
        let only = halves.first().filter(|_| halves.len() == 1 && !threefold);
        let main = quarter.or(only.map(|(_, value)| *value > 0.0));
        let letter = if main == Some(false) { "B" } else { "A" };
        let mut fours = with(Turn::Proper(4)).chain(with(Turn::Quarter));
        let axis = match (fours.next(), only) {
            (Some((own, _)), _) => (0..3).find(|k| own.axes.of(*k).0 == *k),
            (None, Some((own, _))) => (0..3).find(|k| own.axes.of(*k) == (*k, false)),
            (None, None) => None,
        };
        // Turns across the axis, or mirrors through it; with a threefold axis all are.
        let across = |own: &Element| threefold || axis.is_some_and(|k| own.keeps(k, true));
        let through = |own: &Element| threefold || axis.is_none_or(|k| own.keeps(k, false));
        let turned = halves.iter().filter(|(own, _)| across(own)).copied();
        let mut references: Vec<&(&Element, f64)> = turned.collect();
        if references.is_empty() {
            references = with(Turn::Mirror).filter(|(own, _)| through(own)).collect();
        }
        // The mirror of x and z before that of y and z, which is the plane of a plane molecule.
        let flips_second = |own: &Element| axis.is_some_and(|k| own.keeps((k + 2) % 3, true));
        references.sort_by_key(|(own, _)| (own.fixes_bodies, !own.along_axes(), !flips_second(own)));
        let number = number(references.first().map(|(_, value)| *value > 0.0));
        Some(format!("{letter}{number}{parity}"))
    }
}
