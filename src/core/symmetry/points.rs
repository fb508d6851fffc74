//! Turns and mirrors that permute the axes of coordinates and take bodies to bodies, as signed permutations.

use std::collections::BTreeMap;

use hashbrown::HashMap;
use nalgebra::Matrix3;

use super::point_group::{Element, PointGroup};
use super::{GroupKind, Pattern, SignedPermutation, Symmetry};
use crate::linearize::{Bodies, Invariance};
use crate::order::{Gather, Order};

/// What the elements of a point group do to the bodies' coordinates.
#[derive(Clone, Debug)]
pub(super) struct Moves {
    moves: Vec<SignedPermutation>,
    group: PointGroup,
    /// Whether the bodies are in a row about which all turns freely.
    straight: bool,
}

/// An axis of coordinates that the bodies are all on, if there is one.
fn row(bodies: &Bodies) -> Option<usize> {
    let off = |k: usize| bodies.places.iter().any(|place| place[k] != 0);
    (0..bodies.axes.len()).filter(|k| off(*k)).only()
}

/// All permutations of a few axes with all signs.
fn turns(width: usize) -> Vec<SignedPermutation> {
    let flip = (0..width).map(|k| (k, k == 0)).collect();
    let turn = (0..width).map(|k| ((k + 1) % width, false)).collect();
    let exchange = (0..width).map(|k| (if k < 2 { (k + 1) % width.min(2) } else { k }, false)).collect();
    SignedPermutation::group(&[flip, turn, exchange], usize::MAX)
}

/// Where the coordinates of bodies go, if each body goes where there is another.
fn moved(bodies: &Bodies, axes: &SignedPermutation) -> Option<(SignedPermutation, Element)> {
    let at: HashMap<&[u64], usize> = bodies.places.iter().map(Vec::as_slice).zip(0..).collect();
    let count = bodies.axes.iter().map(Vec::len).sum();
    let mut moves = SignedPermutation::unsigned((0..count).collect());
    let mut others = Vec::with_capacity(bodies.places.len());
    for (body, place) in bodies.places.iter().enumerate() {
        let mut image = vec![0; place.len()];
        for (k, value) in place.iter().enumerate() {
            let (to, negative) = axes.of(k);
            image[to] = if negative { crate::expr::neg_mod(*value) } else { *value };
        }
        let other = *at.get(image.as_slice())?;
        others.push(other);
        for (k, own) in bodies.axes.iter().enumerate() {
            let (to, negative) = axes.of(k);
            moves.image[own[body]] = bodies.axes[to][other];
            moves.negative[own[body]] = negative;
        }
    }
    // In a plane the third axis stays.
    let mut matrix = Matrix3::zeros();
    for k in 0..3 {
        let (to, negative) = axes.of(k);
        matrix[(to, k)] = if negative { -1.0 } else { 1.0 };
    }
    Some((moves, Element { bodies: others, matrix }))
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
            let Some((mut moves, element)) = moved(bodies, &axes) else { continue };
            if !moves.is_identity() && !energies.keeps(&moves) {
                continue;
            }
            for i in (0..active.len()).filter(|i| !active[*i]) {
                moves.image[i] = i;
                moves.negative[i] = false;
            }
            faithful &= found.insert(moves, element).is_none();
        }
        let (moves, elements): (Vec<SignedPermutation>, Vec<Element>) = found.into_iter().unzip();
        let generators = independent(moves.clone());
        let order = moves.len() as f64;
        let mut own = Self::of(generators, order, &active, &parts)?;
        // Of a ring of bodies in space the turns alone would tell less.
        if let GroupKind::Ring { .. } = own.kind {
            own.kind = GroupKind::Other;
        }
        own.flips.clear();
        own.whole = true;
        let straight = row(bodies).filter(|_| width == 3);
        let straight = straight
            .is_some_and(|k| energies.turns_freely(&bodies.axes[(k + 1) % 3], &bodies.axes[(k + 2) % 3]) == Some(true));
        if faithful && elements.len() > 2 {
            own.points = PointGroup::new(elements).map(|group| Moves { moves, group, straight });
        }
        Some(own)
    }
}

/// Elements that generate a whole group, those with the fewest signs first.
pub(super) fn independent(mut elements: Vec<SignedPermutation>) -> Vec<SignedPermutation> {
    elements.order_by(|a, b| (a.negatives(), a).cmp(&(b.negatives(), b)));
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

impl Moves {
    /// What the elements do to coordinates.
    pub(super) fn all(&self) -> impl Iterator<Item = SignedPermutation> {
        self.moves.iter().cloned()
    }

    /// The name of a class, given what each element is on it, divided by how many vectors belong together.
    pub(super) fn name(&self, character: &dyn Fn(&SignedPermutation) -> Option<f64>) -> Option<String> {
        let all: Option<Vec<f64>> = self.moves.iter().map(character).collect();
        Some(if self.straight { self.group.class_in_a_row(&all?) } else { self.group.class(&all?) })
    }
}
