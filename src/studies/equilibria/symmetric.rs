//! Signed permutations of the unknowns that change neither the equations nor the box: members of families that change places, and axes
//! that are turned round. Of equilibria that they carry into each other one is searched for.
//!
//! Each orbit has a point at which w·q is largest, for any w: pieces on which w·gq > w·q for some element g hold none of these, and are left
//! aside. Every symmetry is an identity of the equations.

use librate_core::expr::{ExprId, Substitution};
use librate_core::model::{CoordinateFamily, Model};
use librate_core::order::Gather;
use librate_core::precision::Interval;
use librate_core::symmetry::SignedPermutation;

use super::forces::Equations;
use super::root::Root;
use super::turned::Farthest;

/// Groups with more elements are not used.
const MOST_ELEMENTS: usize = 800;
/// Members of more values of an index do not change places.
const MOST_VALUES: usize = 8;
/// Weights are multiples of 1 by this.
const SHORT: f64 = (1_u64 << 30) as f64;
/// What a later component weighs beside the one before.
const LATER: f64 = 0.2;

/// Where each unknown goes, and whether with its sign turned.
pub(super) type Element = Vec<(usize, bool)>;

/// A finite group of symmetries.
#[derive(Default)]
pub(super) struct Symmetries {
    /// All of it but the identity.
    elements: Vec<Element>,
    /// w.
    weights: Vec<f64>,
    /// A body that is as far from the centre as any of those with which it changes places.
    pub(super) farthest: Option<Farthest>,
}

impl Symmetries {
    /// Those of equations without multipliers, and of the potential, which has to have a value; `searched` are the coordinates that the
    /// unknowns are, by number.
    pub(super) fn new(
        model: &Model,
        searched: &[usize],
        (equations, potential): (&Equations, ExprId),
        whole: &[Interval],
    ) -> Self {
        let n = equations.unknowns.len();
        if equations.is_constrained || searched.len() != n {
            return Self::default();
        }
        let places: Vec<Place> = searched.iter().map(|at| place(model, *at)).collect();
        let mut equations = equations.clone();
        equations.all.push(potential);
        let generators: Vec<Element> =
            candidates(&places).into_iter().filter(|own| is_symmetry(&mut equations, whole, own)).collect();
        let weight = |(at, (_, key)): (usize, &Place)| {
            let later = if key.len() > 1 { key[key.len() - 1] } else { 0 };
            let own = (2.0 + key.first().map_or(0.0, |own| *own as f64)) * LATER.powi(later as i32);
            // So short that sums of two are exact.
            ((own + 1e-3 * (at as f64).sqrt()) * SHORT).round() / SHORT
        };
        let weights = places.iter().enumerate().map(weight).collect();
        closure(&generators).map_or_else(Self::default, |elements| Self { elements, weights, ..Self::default() })
    }

    /// With a body that is the farthest, if that stays so in all images.
    pub(super) fn with(self, farthest: Option<Farthest>) -> Self {
        let is_kept = |own: &Farthest| self.elements.iter().all(|element| own.is_kept(element));
        Self { farthest: farthest.filter(is_kept), ..self }
    }

    /// Whether a piece is left aside, or what is left of it: all equilibria on the rest have one elsewhere that is searched for.
    pub(super) fn leave_aside(&self, piece: &mut [Interval]) -> bool {
        let is_left = self.farthest.as_ref().is_none_or(|own| own.contract(piece));
        !is_left
            || self.elements.iter().any(|element| {
                let (mut gain, mut size) = (0.0, 0.0);
                for (i, ((to, turned), own)) in element.iter().zip(piece.iter()).enumerate() {
                    let by = (if *turned { -self.weights[*to] } else { self.weights[*to] }) - self.weights[i];
                    let least = by * if by > 0.0 { own.lo } else { own.hi };
                    gain += least;
                    size += least.abs();
                }
                // Weights have no rounding, and the terms less than that.
                gain > 2.0 * element.len() as f64 * f64::EPSILON * size
            })
    }

    /// What a zero is carried into.
    pub(super) fn images<'a>(&'a self, root: &'a Root) -> impl Iterator<Item = Root> + 'a {
        self.elements.iter().map(move |element| {
            let mut image = root.clone();
            for (i, (to, turned)) in element.iter().enumerate() {
                image.at[*to] = if *turned { -root.at[i] } else { root.at[i] };
                image.region[*to] = signed(&root.region[i], *turned);
            }
            image
        })
    }
}

fn signed(side: &Interval, turned: bool) -> Interval {
    if turned { Interval::new(-side.hi, -side.lo) } else { *side }
}

/// The family of a coordinate, and its indices from 0.
pub(super) type Place = (usize, Vec<usize>);

pub(super) fn place(model: &Model, coordinate: usize) -> Place {
    let holds = |own: &CoordinateFamily| own.range().contains(&coordinate);
    let Some(family) = model.families.iter().position(holds) else { return (usize::MAX, Vec::new()) };
    let own = &model.families[family];
    let mut rest = coordinate - own.first;
    let mut key: Vec<usize> = Vec::new();
    for extent in own.extents.iter().rev() {
        key.insert(0, rest % extent);
        rest /= extent;
    }
    (family, key)
}

/// Two values of a first index that change places, in all families or in one; a family, a component or all of them turned round.
fn candidates(places: &[Place]) -> Vec<Element> {
    let n = places.len();
    let identity: Element = (0..n).map(|at| (at, false)).collect();
    let mut found: Vec<Element> = Vec::new();
    let families = places.iter().map(|own| Some(own.0)).chain([None]).distinct();
    let mut values = places.iter().filter_map(|own| own.1.first().copied()).distinct();
    values.truncate(MOST_VALUES);
    for family in families {
        let is_own = |at: usize| family.is_none_or(|family| places[at].0 == family);
        for pair in values.windows(2) {
            let to = |at: usize| {
                let (own, mut key) = places[at].clone();
                match key.first_mut().filter(|first| is_own(at) && pair.contains(first)) {
                    Some(first) => *first = pair[0] + pair[1] - *first,
                    None => return Some(at),
                }
                places.iter().position(|other| *other == (own, key.clone()))
            };
            let element: Option<Element> = (0..n).map(|at| Some((to(at)?, false))).collect();
            found.extend(element);
        }
        let last = |at: usize| places[at].1.last().copied().filter(|_| places[at].1.len() > 1);
        for component in (0..n).map(last).chain([None]).distinct() {
            let is_turned = |at: usize| is_own(at) && (component.is_none() || last(at) == component);
            found.push((0..n).map(|at| (at, is_turned(at))).collect());
        }
    }
    found.extend((0..n).map(|turned| (0..n).map(|at| (at, at == turned)).collect()));
    found.retain(|own| *own != identity);
    found.into_iter().distinct()
}

/// Whether F(gq) = g F(q), and the box goes over into itself.
pub(super) fn is_symmetry(equations: &mut Equations, whole: &[Interval], element: &Element) -> bool {
    let Equations { pool, unknowns, all, .. } = equations;
    let stays = |(i, (to, turned)): (usize, &(usize, bool))| {
        let (own, there) = (signed(&whole[i], *turned), whole[*to]);
        (own.lo, own.hi) == (there.lo, there.hi)
    };
    if !element.iter().enumerate().all(stays) {
        return false;
    }
    let mut map = Substitution::default();
    for (i, (to, turned)) in element.iter().enumerate() {
        let own = pool.symbol_expr(unknowns[i]);
        map.insert(unknowns[*to], if *turned { pool.neg(own) } else { own });
    }
    let there = pool.substitute(all, &map);
    let potential = pool.sub(there[unknowns.len()], all[unknowns.len()]);
    if !pool.vanishes(potential) {
        return false;
    }
    element.iter().enumerate().all(|(i, (to, turned))| {
        let off = if *turned { pool.add(there[*to], all[i]) } else { pool.sub(there[*to], all[i]) };
        pool.vanishes(off)
    })
}

/// The group of some symmetries, without the identity; `None` where it has too many elements.
fn closure(generators: &[Element]) -> Option<Vec<Element>> {
    let generators: Vec<SignedPermutation> = generators.iter().map(|own| own.iter().copied().collect()).collect();
    let all = SignedPermutation::group(&generators, MOST_ELEMENTS + 1);
    let pairs = |own: &SignedPermutation| (0..own.len()).map(|at| own.of(at)).collect();
    (all.len() <= MOST_ELEMENTS).then(|| all.iter().skip(1).map(pairs).collect())
}
