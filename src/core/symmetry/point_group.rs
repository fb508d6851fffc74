//! Point groups: their names, their classes of conjugate elements, and the names of what belongs to each class of symmetry.
//!
//! Characters are not tabulated: the sums over classes of conjugate elements multiply among themselves, and the characters
//! are the common eigenvectors of these products (Burnside; Landau and Lifshitz, Quantum Mechanics, §94). Classes of inverse
//! elements are taken together, so that all is real and two complex conjugate representations are one.
//!
//! The names are those of Schoenflies and Mulliken (J. Chem. Phys. 23 (1955) 1997; Landau and Lifshitz, §95), read off the
//! characters: A and B by the sign under the main turn, E, T, G and H for two to five vectors that belong together, g and u by
//! inversion, one prime and two by the mirror across the main axis, numbers by the turns across it or else the mirrors
//! through it. Where there are two kinds of these, those on which there are more bodies count; in C2v those on which there
//! are fewer, so that a plane molecule lies in the plane of y and z. In D2 and D2h, z is the turn with the most bodies on
//! its axis, and x is across the plane of a plane molecule. What that leaves open the axes of the model decide.

use hashbrown::HashMap;

use crate::order::Order;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::classes::decomposed;
use crate::groups::Groups;

/// Larger groups get no classes.
pub(super) const MOST_ELEMENTS: usize = 128;
/// Angles and directions of turns are known far better, and differ by more.
const NEAR: f64 = 1e-4;
/// How many choices of weights are tried for one that tells all classes apart.
const MOST_WEIGHTS: usize = 16;

/// A turn or mirror, and where it takes each body.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) bodies: Vec<usize>,
    pub(super) matrix: Matrix3<f64>,
}

impl Element {
    /// Whether it is a turn, and not one with a mirror.
    pub(super) fn is_proper(&self) -> bool {
        self.matrix.determinant() > 0.0
    }

    /// How many bodies stay where they are.
    fn fixed(&self) -> usize {
        self.bodies.iter().enumerate().filter(|(i, to)| i == *to).count()
    }

    /// What tells it from all others of its group: two with the same of both differ by a turn that leaves all bodies.
    pub(super) fn key(&self) -> (Vec<usize>, bool) {
        (self.bodies.clone(), self.is_proper())
    }
}

/// First the second one, then the first.
pub(super) fn product(a: &(Vec<usize>, bool), b: &(Vec<usize>, bool)) -> (Vec<usize>, bool) {
    (b.0.iter().map(|i| a.0[*i]).collect(), a.1 == b.1)
}

/// An element as a turn about an axis by an angle up to pi, with the mirror across it where it is not proper: inversion
/// is one by pi, a mirror one by 0.
struct Turn {
    proper: bool,
    angle: f64,
    axis: Option<Vector3<f64>>,
}

impl Turn {
    fn of(element: &Element) -> Self {
        let proper = element.is_proper();
        let sign = if proper { 1.0 } else { -1.0 };
        let turn = element.matrix * sign;
        let angle = ((element.matrix.trace() - sign) / 2.0).clamp(-1.0, 1.0).acos();
        // R + Rᵀ - (tr R - 1) is 2 (1 - cos) u uᵀ.
        let square = turn + turn.transpose() - Matrix3::identity() * (turn.trace() - 1.0);
        let longest = square.column_iter().max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let axis = longest.filter(|own| own.norm() > NEAR * NEAR).map(|own| own.normalize());
        Self { proper, angle, axis }
    }

    fn is(&self, proper: bool, angle: f64) -> bool {
        self.proper == proper && (self.angle - angle).abs() < NEAR
    }

    fn is_along(&self, axis: &Vector3<f64>) -> bool {
        self.axis.is_some_and(|own| own.cross(axis).norm() < NEAR)
    }

    fn is_across(&self, axis: &Vector3<f64>) -> bool {
        self.axis.is_some_and(|own| own.dot(axis).abs() < NEAR)
    }
}

/// A finite point group.
#[derive(Clone, Debug, Default)]
pub(super) struct PointGroup {
    pub(super) elements: Vec<Element>,
    /// Its name after Schoenflies.
    pub(super) name: String,
    /// Elements by number: inversion, else the mirror across the main axis, in groups with one.
    inversion: Option<usize>,
    level: Option<usize>,
    /// The main turn, by this part of a whole one, perhaps with a mirror across.
    main: Option<(usize, usize)>,
    /// Whether there are several main axes, and of these the turn that the numbers of T follow.
    cubic: bool,
    triple: Option<usize>,
    /// What the numbers of A and B follow.
    number: Option<usize>,
    /// The turns about z, y and x in D2 and D2h.
    halves: Option<[usize; 3]>,
}

/// A sum of all elements that is a number on each class of symmetry.
pub(super) struct Weights {
    /// The factor of each element.
    pub(super) elements: Vec<f64>,
    /// These numbers, which all differ, with the names.
    pub(super) names: Vec<(f64, String)>,
}

/// Rounded, so that what is equal is so.
fn rounded(x: f64) -> i64 {
    (x.abs() * 1e6).round() as i64
}

/// The name of a group with several axes of more than two turns, from how many elements it has, whether these are all turns,
/// and whether inversion is one.
fn cubic_name(count: usize, proper: bool, inversion: bool) -> Option<&'static str> {
    Some(match (count, proper, inversion) {
        (12, true, _) => "T",
        (24, true, _) => "O",
        (24, _, true) => "Th",
        (24, ..) => "Td",
        (48, _, true) => "Oh",
        (60, true, _) => "I",
        (120, _, true) => "Ih",
        _ => return None,
    })
}

impl PointGroup {
    /// The group of these elements, which are all.
    pub(super) fn new(elements: Vec<Element>) -> Option<Self> {
        let turns: Vec<Turn> = elements.iter().map(Turn::of).collect();
        let count = elements.len();
        let find = |which: &dyn Fn(&Turn) -> bool| turns.iter().position(which);
        let all = |which: &dyn Fn(&Turn) -> bool| -> Vec<usize> { (0..count).filter(|i| which(&turns[*i])).collect() };
        let mut own = Self { inversion: find(&|turn| turn.is(false, PI)), ..Self::default() };
        let mut axes: Vec<(Vector3<f64>, usize)> = Vec::new();
        for turn in turns.iter().filter(|turn| turn.proper) {
            let Some(axis) = turn.axis else { continue };
            match axes.iter_mut().find(|(other, _)| turn.is_along(other)) {
                Some((_, order)) => *order += 1,
                None => axes.push((axis, 2)),
            }
        }
        own.cubic = axes.iter().filter(|(_, order)| *order > 2).count() > 1;
        if own.cubic {
            own.number = find(&|turn| turn.is(true, PI / 2.0)).or(find(&|turn| turn.is(false, PI / 2.0)));
            own.triple = own.number.or(find(&|turn| turn.is(true, TAU / 5.0)));
            let name = cubic_name(count, turns.iter().all(|turn| turn.proper), own.inversion.is_some())?;
            return Some(Self { elements, name: name.to_owned(), ..own });
        }
        let reflected = |axis: &Vector3<f64>, order: usize| {
            let angle = PI / order as f64;
            turns.iter().position(|turn| turn.is(false, angle) && turn.is_along(axis))
        };
        let rank = |(axis, order): &(Vector3<f64>, usize)| {
            let turn = turns.iter().position(|turn| turn.is(true, TAU / *order as f64) && turn.is_along(axis));
            (*order, reflected(axis, *order).is_some(), turn.map(|at| elements[at].fixed()), rounded(axis.z))
        };
        let Some((axis, n)) = axes.iter().max_by_key(|own| rank(own)).copied() else {
            own.level = find(&|turn| turn.is(false, 0.0));
            let name = match (count, own.inversion, own.level) {
                (1, ..) => "C1",
                (2, Some(_), _) => "Ci",
                (2, _, Some(_)) => "Cs",
                _ => return None,
            };
            return Some(Self { elements, name: name.to_owned(), ..own });
        };
        let level = find(&|turn| turn.is(false, 0.0) && turn.is_along(&axis));
        own.level = level.filter(|_| own.inversion.is_none());
        let across = all(&|turn| turn.is(true, PI) && turn.is_across(&axis));
        let through = all(&|turn| turn.is(false, 0.0) && turn.is_across(&axis));
        let alternating = reflected(&axis, n);
        own.main = match alternating.filter(|_| own.inversion.is_none()) {
            Some(at) => Some((at, 2 * n)),
            None => Some((find(&|turn| turn.is(true, TAU / n as f64) && turn.is_along(&axis))?, n)),
        };
        let (expected, name) = match (across.is_empty(), level.is_some(), through.is_empty()) {
            (false, true, _) => (4 * n, format!("D{n}h")),
            (false, false, false) => (4 * n, format!("D{n}d")),
            (false, false, true) => (2 * n, format!("D{n}")),
            (true, true, _) => (2 * n, format!("C{n}h")),
            (true, false, false) => (2 * n, format!("C{n}v")),
            (true, false, true) if alternating.is_some() => (2 * n, format!("S{}", 2 * n)),
            (true, false, true) => (n, format!("C{n}")),
        };
        // The model's axis nearest to the main one, and the next.
        let next = (axis.iamax() + 1) % 3;
        let toward = |at: usize, k: usize| turns[at].axis.map_or(0, |own| rounded(own[k]));
        let fixed = |at: usize| elements[at].fixed();
        own.number = if !across.is_empty() {
            across.iter().copied().max_by_key(|at| (fixed(*at), toward(*at, next)))
        } else {
            let side = (next + 1) % 3;
            let sign = if n == 2 { -1 } else { 1 };
            through.iter().copied().max_by_key(|at| (sign * fixed(*at) as i64, toward(*at, side)))
        };
        if n == 2 && across.len() == 2 && alternating.is_none() {
            let flat = |at: usize| {
                let whole =
                    turns.iter().zip(&elements).filter(|(turn, own)| !turn.proper && own.fixed() == own.bodies.len());
                whole.into_iter().any(|(turn, _)| turns[at].axis.is_some_and(|axis| turn.is_along(&axis)))
            };
            let mut halves = all(&|turn| turn.is(true, PI));
            halves.order_by_key(|at| (flat(*at), -(fixed(*at) as i64), -toward(*at, 2)));
            if let [z, a, b] = halves[..] {
                let swap = flat(a) || !flat(b) && toward(a, 0) > toward(b, 0);
                own.halves = Some(if swap { [z, b, a] } else { [z, a, b] });
            }
        }
        (count == expected).then_some(Self { elements, name, ..own })
    }

    /// What an irreducible representation is called, from what each element is on it, divided by how many vectors belong
    /// together.
    pub(super) fn class(&self, character: &[f64]) -> String {
        let sign = |at: usize| character[at] > 0.0;
        // The squares of characters add up to the order; in these units to as much over the number of vectors
        // squared, or where a pair is complex over 2.
        let squares: f64 = character.iter().map(|value| value * value).sum();
        let together = character.len() as f64 / squares;
        let told =
            |at: Option<usize>, [even, odd]: [&'static str; 2]| at.map_or("", |at| if sign(at) { even } else { odd });
        let number = |at| told(at, ["1", "2"]);
        // Groups with inversion have no mirror that counts.
        let parity = told(self.inversion, ["g", "u"]).to_owned() + told(self.level, ["'", "''"]);
        let name = if together > 20.0 {
            "H".to_owned()
        } else if together > 12.0 {
            "G".to_owned()
        } else if together > 6.0 {
            format!("T{}", number(self.triple))
        } else if together > 1.5 {
            // About an axis, E of this number turns by so many times the angle.
            match self.main.filter(|(_, whole)| *whole > 4) {
                Some((at, whole)) => {
                    format!("E{}", (character[at].clamp(-1.0, 1.0).acos() * whole as f64 / TAU).round())
                }
                None => "E".to_owned(),
            }
        } else if let Some([z, y, x]) = self.halves {
            let name = match (sign(z), sign(y), sign(x)) {
                (true, true, true) => "A",
                (true, ..) => "B1",
                (_, true, _) => "B2",
                _ => "B3",
            };
            name.to_owned()
        } else {
            let letter = if self.main.is_none_or(|(at, _)| sign(at)) { "A" } else { "B" };
            format!("{letter}{}", number(self.number))
        };
        name + &parity
    }

    /// The same for bodies in a row about which all turns freely.
    pub(super) fn class_in_a_row(&self, character: &[f64]) -> String {
        let squares: f64 = character.iter().map(|value| value * value).sum();
        let (letter, plus) = if character.len() as f64 / squares < 1.5 { ("Σ", "+") } else { ("Π", "") };
        let parity = self.inversion.map_or("", |at| if character[at] > 0.0 { "g" } else { "u" });
        format!("{letter}{parity}{plus}")
    }

    /// The class of conjugate elements and their inverses that each element is in, by number, and how many each has.
    fn conjugates(&self, table: &[Vec<usize>]) -> (Vec<usize>, Vec<usize>) {
        let count = table.len();
        let identity = (0..count).find(|i| table[*i][*i] == *i).unwrap_or_default();
        let inverse = |i: usize| (0..count).find(|j| table[i][*j] == identity).unwrap_or(i);
        let inverses: Vec<usize> = (0..count).map(inverse).collect();
        let mut together = Groups::new(count);
        for i in 0..count {
            together.join(i, inverses[i]);
            (0..count).for_each(|g| together.join(i, table[table[g][i]][inverses[g]]));
        }
        let mut classes = together.all();
        classes.order_by_key(|own| !own.contains(&identity));
        let mut class = vec![0; count];
        for (number, own) in classes.iter().enumerate() {
            own.iter().for_each(|i| class[*i] = number);
        }
        (class, classes.iter().map(Vec::len).collect())
    }

    /// Weights that tell all classes of symmetry apart.
    pub(super) fn weights(&self) -> Option<Weights> {
        let numbers: HashMap<(Vec<usize>, bool), usize> = self.elements.iter().map(Element::key).zip(0..).collect();
        let keys: Vec<(Vec<usize>, bool)> = self.elements.iter().map(Element::key).collect();
        let row = |a| keys.iter().map(|b| numbers.get(&product(a, b)).copied()).collect::<Option<Vec<usize>>>();
        let table = keys.iter().map(row).collect::<Option<Vec<Vec<usize>>>>()?;
        let (class, sizes) = self.conjugates(&table);
        let length = |class: usize| (sizes[class] as f64).sqrt();
        (0..MOST_WEIGHTS).find_map(|attempt| {
            let weight = |class: usize| ((class * (attempt + 1)) as f64 + 1.0).sin().mul_add(0.25, 1.0);
            let weights: Vec<f64> = class.iter().map(|own| weight(*own) / sizes[*own] as f64).collect();
            // The product with this sum, by classes of length 1.
            let mut matrix = DMatrix::zeros(sizes.len(), sizes.len());
            for (g, row) in table.iter().enumerate() {
                for (h, gh) in row.iter().enumerate() {
                    matrix[(class[*gh], class[h])] += weights[g] / (length(class[*gh]) * length(class[h]));
                }
            }
            let (values, vectors) = decomposed(&matrix)?;
            if values.windows(2).any(|pair| pair[1] - pair[0] < 1e-3) {
                return None;
            }
            let names: BTreeMap<String, f64> = (0..values.len())
                .map(|at| {
                    let of = |class: usize| vectors[(class, at)] / (length(class) * vectors[(0, at)]);
                    let character: Vec<f64> = class.iter().map(|own| of(*own)).collect();
                    (self.class(&character), values[at])
                })
                .collect();
            let all_differ = names.len() == values.len();
            let names = names.into_iter().map(|(name, value)| (value, name)).collect();
            all_differ.then_some(Weights { elements: weights, names })
        })
    }
}
