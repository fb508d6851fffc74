//! The symmetry of M and K in numbers, and the classes of modes under it.
//!
//! The enclosures at hand, of which those that meet count as equal, say whether there may be a symmetry with
//! classes. Where there may it is looked for among entries of a thousand bits from the exact expressions, so
//! that 1 and 1 + 1e-33 differ; only where the equilibrium was searched for the enclosures decide.

use std::collections::{BTreeMap, HashMap};

use crate::linearize::{Entries, Invariance, Linearized};
use crate::precision::{Ball, Big, Scalar, SparseMatrix};
use crate::symmetry::{Classes, Pattern, Symmetry, point_group};

/// Larger models are not searched.
pub(super) const MOST_COORDINATES: usize = 1500;
/// Numbers that agree to so many bits are equal.
const BITS: usize = 1024;

/// What tells the modes of different symmetry apart.
pub(super) struct Labels {
    classes: Classes,
    /// The name of the point group, where there is one.
    pub(super) group: Option<String>,
    /// Where there may be more symmetry than was looked for.
    more: Option<(Pattern, Invariance)>,
}

impl Labels {
    /// The classes of vectors with their errors.
    ///
    /// Where a mirror leaves some without a class, vectors of one frequency may be exchanged by more
    /// than it: then the whole group with signs is asked, and stands if it leaves fewer.
    pub(super) fn of(&mut self, vectors: &[(&[f64], f64)]) -> Vec<Option<String>> {
        let told = |classes: &Classes| -> Vec<Option<String>> {
            let labels = vectors.iter().map(|(x, error)| classes.of(x, *error));
            labels.map(|label| label.map(str::to_owned)).collect()
        };
        let missing = |labels: &[Option<String>]| labels.iter().filter(|l| l.is_none()).count();
        let own = told(&self.classes);
        let Some((pattern, invariance)) = self.more.as_mut().filter(|_| missing(&own) > 0) else {
            return own;
        };
        let whole = Symmetry::find_signed(pattern);
        let whole = whole.and_then(|whole| whole.kept(&mut |g| invariance.keeps(g)));
        let other = whole.as_ref().and_then(Classes::new).map(|classes| told(&classes));
        match other {
            Some(other) if missing(&other) < missing(&own) => other,
            Some(_) | None => own,
        }
    }
}

/// The symmetry of a model's energies, if it has one.
pub(super) fn labels(linearized: &Linearized, mass: &SparseMatrix, stiffness: &SparseMatrix) -> Option<Labels> {
    let n = mass.dimension();
    if !(2..=MOST_COORDINATES).contains(&n) {
        return None;
    }
    if let Some((group, classes)) = point_group(linearized) {
        return Some(Labels { classes, group: Some(group), more: None });
    }
    let mut pattern = of_enclosures(mass, stiffness)?;
    if !Symmetry::may_have_classes(&pattern) {
        return None;
    }
    if let Some(entries) = linearized.entries(BITS) {
        pattern = of_entries(n, &entries);
    }
    let mut invariance = linearized.invariance()?;
    let symmetry = Symmetry::of_energies(&pattern, &mut invariance)?;
    let classes = Classes::new(&symmetry)?;
    let more = symmetry.may_be_larger().then_some((pattern, invariance));
    Some(Labels { classes, group: None, more })
}

/// A class of values with its sign: 0 for zero, opposite for opposite values.
type Class = i64;

/// Numbers pairs of classes, opposite pairs by opposite numbers.
#[derive(Default)]
struct Numbering(HashMap<(Class, Class), i64>);

impl Numbering {
    fn of(&mut self, mass: Class, stiffness: Class) -> i64 {
        let negative = mass < 0 || (mass == 0 && stiffness < 0);
        let sign = if negative { -1 } else { 1 };
        let fresh = self.0.len() as i64 + 1;
        sign * *self.0.entry((sign * mass, sign * stiffness)).or_insert(fresh)
    }
}

fn of_enclosures(mass: &SparseMatrix, stiffness: &SparseMatrix) -> Option<Pattern> {
    let n = mass.dimension();
    let diagonal = |matrix: &SparseMatrix, i: usize| {
        let (rows, values) = matrix.column(i);
        values.first().filter(|_| rows[0] as usize == i).map_or(0.0, Ball::mid_f64)
    };
    let diagonal_differs = || {
        let mut pairs: Vec<(f64, f64)> = (0..n).map(|i| (diagonal(mass, i), diagonal(stiffness, i))).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        // Equal numbers may differ by their rounding.
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-6 * (a.abs() + b.abs());
        pairs.windows(2).all(|pair| !near(pair[0].0, pair[1].0))
            || (pairs.windows(2).all(|pair| pair[0].0 == pair[1].0)
                && pairs.windows(2).all(|pair| !near(pair[0].1, pair[1].1)))
    };
    if diagonal_differs() {
        return None;
    }
    let classes = |matrix: &SparseMatrix| -> Option<Vec<(usize, usize, Class)>> {
        let values: Vec<Ball> = matrix.entries().map(|(_, _, value)| *value).collect();
        let classes = value_classes(&values)?;
        Some(matrix.entries().zip(classes).map(|((i, j, _), class)| (i, j, class)).collect())
    };
    Some(pattern(n, &classes(mass)?, &classes(stiffness)?))
}

/// The pattern of both matrices from the classes of their entries, those of one triangle.
fn pattern(n: usize, masses: &[(usize, usize, Class)], stiffnesses: &[(usize, usize, Class)]) -> Pattern {
    // Every entry with its mirror image: row, column and the class of the mass, or of the stiffness.
    let mut entries: Vec<(usize, usize, Class, Class)> = Vec::new();
    for (own, is_mass) in [(masses, true), (stiffnesses, false)] {
        for &(i, j, class) in own {
            let (m, k) = if is_mass { (class, 0) } else { (0, class) };
            entries.push((i, j, m, k));
            if i != j {
                entries.push((j, i, m, k));
            }
        }
    }
    entries.sort_unstable_by_key(|(i, j, ..)| (*i, *j));
    let mut labels = Numbering::default();
    let mut pattern = Pattern::new(n);
    for own in entries.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (i, j, ..) = own[0];
        let (m, k) = own.iter().fold((0, 0), |(m, k), own| (m + own.2, k + own.3));
        if (m, k) == (0, 0) {
            continue;
        }
        let label = labels.of(m, k);
        if i == j {
            // The mass is positive, so is its label.
            pattern.set_diagonal(i, label.unsigned_abs(), k != 0);
        } else {
            pattern.push(i, j, label, k != 0);
        }
    }
    pattern
}

/// Numbers values so that those whose balls meet have the same number, and opposite ones opposite
/// numbers.
fn value_classes(values: &[Ball]) -> Option<Vec<Class>> {
    if !values.iter().all(Ball::is_finite) {
        return None;
    }
    let mut classes = vec![0; values.len()];
    let told = values.iter().enumerate().filter(|(_, value)| !value.contains_zero());
    let mut order: Vec<(usize, Ball)> = told.map(|(i, value)| (i, value.abs())).collect();
    order.sort_by(|(_, a), (_, b)| a.mid.partial_cmp(&b.mid).unwrap_or(std::cmp::Ordering::Equal));
    let mut class = 1;
    let mut last: Option<&Ball> = None;
    for (i, value) in &order {
        if let Some(before) = last {
            // Rounding differs with the order of summation: a little more than the radii is allowed.
            let gap = (value.mid - before.mid).hi;
            let reach = before.radius + value.radius + 1e-29 * value.mid.hi.abs();
            if gap > reach {
                class += 1;
            }
        }
        last = Some(value);
        classes[*i] = if values[*i].is_negative() { -class } else { class };
    }
    Some(classes)
}

/// Numbers values of many bits in the same way.
#[derive(Default)]
struct BigClasses {
    /// By the nearest double: values that were met, with their numbers.
    met: BTreeMap<u64, Vec<(Big, Class)>>,
    count: Class,
}

impl BigClasses {
    fn of(&mut self, value: &Big) -> Class {
        if value.contains_zero() {
            return 0;
        }
        let negative = value.is_negative();
        let size = if negative { value.neg() } else { value.clone() };
        let near = size.mid_f64().abs();
        for key in [near.next_down(), near, near.next_up()] {
            for (other, class) in self.met.get(&key.to_bits()).into_iter().flatten() {
                if other.sub(&size).contains_zero() {
                    return if negative { -class } else { *class };
                }
            }
        }
        self.count += 1;
        let class = self.count;
        self.met.entry(near.to_bits()).or_default().push((size, class));
        if negative { -class } else { class }
    }
}

fn of_entries(n: usize, entries: &Entries) -> Pattern {
    let classes = |entries: &BTreeMap<(usize, usize), Big>| -> Vec<(usize, usize, Class)> {
        let mut known = BigClasses::default();
        entries.iter().map(|((i, j), value)| (*i, *j, known.of(value))).collect()
    };
    pattern(n, &classes(&entries.mass), &classes(&entries.stiffness))
}
