//! The point group of bodies whose energies turn freely, as those of a molecule do.
//!
//! Where the energies are the same after every turn in space (or about one axis) and do not change when bodies are
//! exchanged, perhaps with a mirror image of all, any turn or mirror that takes the equilibrium to itself with that
//! exchange is a symmetry of the motion about it, whatever its angle. The energies are tested identically; that the
//! equilibrium is taken to itself is a matter of distances, which are compared in numbers of many bits: exact ones where the
//! model says where the bodies are, else those of the equilibrium that is proved.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Matrix3, Vector3};

use super::Classes;
use super::classes::column;
use super::point_group::{Element, MOST_ELEMENTS, PointGroup, product};
use crate::linearize::{Invariance, Linearized};
use crate::number::Number;
use crate::order::{Gather, Order};
use crate::precision::{Big, Scalar};

/// Beside the size of all: what is taken for equal, before that is shown.
const NEAR: f64 = 1e-6;
/// Bodies that are closer have no places of their own.
const APART: f64 = 1e-4;

/// What turns freely: all in space, or about an axis, which in a plane is the third one.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Freedom {
    Space,
    About(usize),
}

impl Freedom {
    /// What turns freely; `None` where nothing does, or that is not decided.
    fn of(energies: &mut Invariance, axes: &[Vec<usize>]) -> Option<Self> {
        let mut turns = |k: usize| match (axes.get((k + 1) % 3), axes.get((k + 2) % 3)) {
            (Some(a), Some(b)) => energies.turns_freely(a, b),
            (_, _) => Some(false),
        };
        let turns = [turns(0)?, turns(1)?, turns(2)?];
        if turns == [true; 3] { Some(Self::Space) } else { turns.iter().position(|own| *own).map(Self::About) }
    }

    /// The changes of signs of the axes that are a matrix of determinant `det`, up to a turn that is free; `along` is what
    /// the matrix does to the axis.
    fn signs(self, det: f64, along: f64) -> [bool; 3] {
        match self {
            Self::Space => [det < 0.0; 3],
            Self::About(axis) => {
                let mut signs = [false; 3];
                signs[axis] = along < 0.0;
                signs[(axis + 1) % 3] = det * along < 0.0;
                signs
            }
        }
    }
}

/// Bodies about their centre.
struct Figure {
    places: Vec<[Big; 3]>,
    near: Vec<Vector3<f64>>,
    size: f64,
    /// Bodies whose places span all others: as many as these have dimensions.
    basis: Vec<usize>,
}

fn dot(a: &[Big; 3], b: &[Big; 3]) -> Big {
    a[0].mul(&b[0]).add(&a[1].mul(&b[1])).add(&a[2].mul(&b[2]))
}

fn cross(a: &[Big; 3], b: &[Big; 3]) -> [Big; 3] {
    [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i].mul(&b[j]).sub(&a[j].mul(&b[i]))
    })
}

impl Figure {
    /// The figure about the centre of all bodies, or the origin along axes that are held there; `None` where two
    /// bodies are at one place, or it is a matter of small numbers whether all are in a row or in a plane.
    fn new(axes: &[Vec<usize>], at: &[Big], held: [bool; 3]) -> Option<Self> {
        let count = axes.first()?.len();
        let bits = at.first()?.bits();
        let share = Big::from_number(&Number::from(i64::try_from(count).ok()?), bits);
        let mut places = vec![[0, 1, 2].map(|_| Big::zero(bits)); count];
        for (k, axis) in axes.iter().enumerate() {
            let sum = axis.iter().fold(Big::zero(bits), |sum, i| sum.add(&at[*i]));
            let centre = if held[k] { Big::zero(bits) } else { sum.div(&share) };
            places.iter_mut().zip(axis).for_each(|(place, i)| place[k] = at[*i].sub(&centre));
        }
        let near: Vec<Vector3<f64>> = places.iter().map(|place| Vector3::from_fn(|k, _| place[k].mid_f64())).collect();
        let size = near.iter().map(Vector3::norm).fold(0.0, f64::max);
        let own = |i: usize| near.iter().skip(i + 1).all(|other| (other - near[i]).norm() > APART * size);
        if !size.is_normal() || !(0..count).all(own) {
            return None;
        }
        let mut figure = Self { places, near, size, basis: Vec::new() };
        figure.basis = figure.spanning()?;
        Some(figure)
    }

    /// Bodies that span the figure, those first that have the fewest others at their distance.
    fn spanning(&self) -> Option<Vec<usize>> {
        let count = self.near.len();
        let alike =
            |i: usize| (0..count).filter(|j| self.near_equal(self.near[i].norm(), self.near[*j].norm(), 1.0)).count();
        let off_centre = (0..count).filter(|i| self.near[*i].norm() > NEAR * self.size);
        let mut order: Vec<(usize, usize)> = off_centre.map(|i| (alike(i), i)).collect();
        order.put_in_order();
        let order: Vec<usize> = order.into_iter().map(|(_, i)| i).collect();
        let a = *order.first()?;
        let off = |i: &usize| self.near[a].normalize().cross(&self.near[*i]).norm() / self.size;
        let b = order.iter().copied().find(|i| off(i) > 0.1);
        let b = b.or_else(|| order.iter().copied().max_by(|i, j| off(i).total_cmp(&off(j))))?;
        if off(&b) < NEAR {
            let in_a_row = |place| cross(&self.places[a], place).iter().all(Big::contains_zero);
            return self.places.iter().all(in_a_row).then(|| vec![a]);
        }
        let normal = self.near[a].cross(&self.near[b]).normalize();
        let height = |i: &usize| normal.dot(&self.near[*i]).abs() / self.size;
        let c = order.iter().copied().max_by(|i, j| height(i).total_cmp(&height(j)))?;
        if height(&c) < NEAR {
            let normal = cross(&self.places[a], &self.places[b]);
            let in_plane = |place| dot(&normal, place).contains_zero();
            return self.places.iter().all(in_plane).then(|| vec![a, b]);
        }
        Some(vec![a, b, c])
    }

    fn near_equal(&self, a: f64, b: f64, size: f64) -> bool {
        (a - b).abs() < NEAR * self.size * size
    }

    /// The turns and mirrors that seem to take the figure to itself.
    fn candidates(&self) -> Option<Vec<Element>> {
        let [a, b, ..] = self.basis[..] else { return None };
        let frame = |a: usize, b: usize| {
            let (x, normal) = (self.near[a].normalize(), self.near[a].cross(&self.near[b]).normalize());
            Matrix3::from_columns(&[x, normal.cross(&x), normal])
        };
        let own = frame(a, b).transpose();
        let mut found = Vec::new();
        let at_distance_of = |i: usize| {
            let norm = self.near[i].norm();
            (0..self.near.len()).filter(move |j| self.near_equal(self.near[*j].norm(), norm, 1.0))
        };
        let angle = self.near[a].dot(&self.near[b]);
        for i in at_distance_of(a) {
            for j in at_distance_of(b).filter(|j| self.near_equal(self.near[i].dot(&self.near[*j]), angle, self.size)) {
                for sign in [1.0, -1.0] {
                    let matrix = frame(i, j) * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * own;
                    let Some(bodies) = self.moved(&matrix) else { continue };
                    if found.len() == MOST_ELEMENTS {
                        return None;
                    }
                    found.push(Element { bodies, matrix });
                }
            }
        }
        Some(found)
    }

    fn moved(&self, matrix: &Matrix3<f64>) -> Option<Vec<usize>> {
        let to = |place: &Vector3<f64>| {
            let image = matrix * place;
            self.near.iter().position(|other| (other - image).norm() < APART / 3.0 * self.size)
        };
        self.near.iter().map(to).collect()
    }

    /// Whether all distances stay, and what an axis says.
    fn holds(&self, element: &Element, freedom: Freedom) -> bool {
        let moved = |i: usize| &self.places[element.bodies[i]];
        let stays = |i: usize| {
            let along = match freedom {
                Freedom::Space => true,
                Freedom::About(k) => {
                    let image =
                        if element.matrix[(k, k)] < 0.0 { self.places[i][k].neg() } else { self.places[i][k].clone() };
                    image.sub(&moved(i)[k]).contains_zero()
                }
            };
            let product =
                |j: &usize| dot(&self.places[i], &self.places[*j]).sub(&dot(moved(i), moved(*j))).contains_zero();
            along && self.basis.iter().all(product)
        };
        (0..self.places.len()).all(stays)
    }
}

/// The part of the energies that says which exchanges are symmetries.
struct Exchanges<'a> {
    energies: Invariance,
    axes: &'a [Vec<usize>],
    freedom: Freedom,
}

impl Exchanges<'_> {
    /// Whether a matrix with this determinant, which does so to the free axis, is a symmetry with an exchange.
    fn keep(&mut self, bodies: &[usize], det: f64, along: f64) -> Option<bool> {
        let signs = self.freedom.signs(det, along);
        let mut images = vec![(0, false); self.axes.iter().map(Vec::len).sum()];
        for (axis, negative) in self.axes.iter().zip(signs) {
            axis.iter().zip(bodies).for_each(|(i, to)| images[*i] = (axis[*to], negative));
        }
        self.energies.permuted(|i| images[i])
    }

    fn keeps(&mut self, element: &Element) -> Option<bool> {
        let along = match self.freedom {
            Freedom::Space => 1.0,
            Freedom::About(k) => element.matrix[(k, k)],
        };
        self.keep(&element.bodies, element.matrix.determinant(), along)
    }

    /// The elements of the group.
    fn group(&mut self, figure: &Figure) -> Option<Vec<Element>> {
        let mut candidates = figure.candidates()?;
        if let Freedom::About(k) = self.freedom {
            let least = if self.axes.len() == 2 { 0.0 } else { -2.0 };
            candidates.retain(|own| own.matrix[(k, k)] > least && own.matrix[(k, k)].abs() > 1.0 - NEAR);
        }
        let by_key: BTreeMap<(Vec<usize>, bool), Element> = candidates.into_iter().map(|own| (own.key(), own)).gather();
        let mut generators = Vec::new();
        let mut known = BTreeSet::from([((0..figure.near.len()).collect::<Vec<usize>>(), true)]);
        for (key, element) in &by_key {
            if known.contains(key) || !figure.holds(element, self.freedom) || !self.keeps(element)? {
                continue;
            }
            generators.push(key.clone());
            let mut open: Vec<_> = known.iter().cloned().collect();
            while let Some(one) = open.pop() {
                let products = generators.iter().map(|g| product(g, &one));
                open.extend(products.filter(|own| known.insert(own.clone())));
                if known.len() > by_key.len() {
                    return None;
                }
            }
        }
        known.iter().map(|key| by_key.get(key).cloned()).collect()
    }

    /// The classes of bodies in a row that turn about it.
    fn in_a_row(&mut self, figure: &Figure) -> Option<(String, Classes)> {
        let along = figure.near[*figure.basis.first()?].normalize();
        let lies = match self.freedom {
            Freedom::Space => true,
            Freedom::About(k) => {
                let across = |place: &[Big; 3]| (1..3).all(|step| place[(k + step) % 3].contains_zero());
                self.axes.len() == 3 && figure.places.iter().all(across)
            }
        };
        let identity: Vec<usize> = (0..figure.near.len()).collect();
        if !lies || !self.keep(&identity, -1.0, 1.0)? {
            return None;
        }
        let matrix = -Matrix3::identity();
        let inversion = figure.moved(&matrix).map(|bodies| Element { bodies, matrix });
        let inversion = match inversion.filter(|own| figure.holds(own, self.freedom)) {
            Some(own) => self.keeps(&own)?.then_some(own),
            None => None,
        };
        let mut terms = vec![(1.0, Element { bodies: identity, matrix: along * along.transpose() })];
        let (name, classes): (&str, &[(f64, &str)]) = match inversion {
            Some(own) => {
                terms.push((3.0, own));
                ("D∞h", &[(4.0, "Σg+"), (-2.0, "Σu+"), (3.0, "Πg"), (-3.0, "Πu")])
            }
            None => ("C∞v", &[(1.0, "Σ+"), (0.0, "Π")]),
        };
        let names = classes.iter().map(|(value, name)| (*value, (*name).to_owned())).collect();
        Some((name.to_owned(), Classes::of_sum(sum(self.axes, &terms), &terms, names)))
    }
}

/// A sum of elements with their factors as they act on coordinates, by columns.
fn sum(axes: &[Vec<usize>], terms: &[(f64, Element)]) -> Vec<Vec<(usize, f64)>> {
    let mut columns = vec![Vec::new(); axes.iter().map(Vec::len).sum()];
    for (k, axis) in axes.iter().enumerate() {
        for (body, i) in axis.iter().enumerate() {
            let images = terms.iter().flat_map(|(factor, element)| {
                let to = axes.iter().map(|axis| axis[element.bodies[body]]);
                to.zip(0..).map(move |(to, l)| (to, factor * element.matrix[(l, k)]))
            });
            columns[*i] = column(images);
        }
    }
    columns
}

/// The point group of a model whose coordinates are those of bodies in a plane or in space, and what tells its classes
/// apart; `None` where the energies do not turn freely, or it has no elements but one. A single mirror in a plane, at any angle, has
/// no name: its classes are even and odd.
pub(crate) fn point_group(linearized: &Linearized) -> Option<(Option<String>, Classes)> {
    let axes = linearized.axes_of_bodies()?;
    let at = linearized.exact_equilibrium()?;
    let figure = Figure::new(&axes, &at, [false; 3])?;
    // Whatever the centre will be, the distances have to allow it.
    if figure.basis.len() == 3 && figure.candidates()?.len() < 2 {
        return None;
    }
    let mut energies = linearized.energies_anywhere(&at)?;
    let freedom = Freedom::of(&mut energies, &axes)?;
    let mut held = [false; 3];
    for (held, axis) in held.iter_mut().zip(&axes) {
        *held = !energies.shifts_freely(axis)?;
    }
    let figure = if held.contains(&true) { Figure::new(&axes, &at, held)? } else { figure };
    let mut exchanges = Exchanges { energies, axes: &axes, freedom };
    if figure.basis.len() == 1 {
        return exchanges.in_a_row(&figure).map(|(name, classes)| (Some(name), classes));
    }
    let group = PointGroup::new(exchanges.group(&figure)?)?;
    if group.elements.len() < 2 {
        return None;
    }
    let mut weights = group.weights()?;
    let is_mirror = axes.len() == 2 && group.elements.len() == 2;
    if is_mirror {
        let is_even = |name: &str| !name.contains("''");
        for (_, name) in &mut weights.names {
            *name = if is_even(name) { "even" } else { "odd" }.to_owned();
        }
    }
    let terms: Vec<(f64, Element)> = weights.elements.into_iter().zip(group.elements).collect();
    Some(((!is_mirror).then_some(group.name), Classes::of_sum(sum(&axes, &terms), &terms, weights.names)))
}
