//! The symmetry of M and K in numbers, and the classes of modes under it.
//!
//! The enclosures at hand, of which those that meet count as equal, say whether there may be a symmetry with
//! classes. Where there may it is searched for among entries of many bits from the exact expressions, so
//! that 1 and 1 + 1e-33 differ; only where the equilibrium was searched for, or entries are sums of many terms, the enclosures decide.

use std::collections::BTreeMap;

use hashbrown::HashMap;

use super::NormalMode;
use crate::linearize::{Entries, Invariance, Linearized};
use crate::order::Order;
use crate::precision::{Ball, Big, Enclosure, Function, SparseMatrix};
use crate::symmetry::{Classes, Pattern, Symmetry, point_group};

/// Larger models are not searched.
pub(super) const MOST_COORDINATES: usize = 1500;
/// Numbers that agree to so many bits are equal.
const BITS: usize = 256;
/// Entries that are sums of more terms are not evaluated to so many.
const MOST_SHARES: u64 = 5_000;

/// What tells the modes of different symmetry apart.
pub(super) struct Labels {
    pub(super) classes: Classes,
    /// The name of the point group, where there is one.
    pub(super) group: Option<String>,
    /// Where there may be more symmetry than was searched for.
    more: Option<(Pattern, Invariance)>,
}

impl Labels {
    /// The classes of vectors with their errors.
    ///
    /// Where a mirror leaves some without a class, vectors of one frequency may be exchanged by more
    /// than it: then the whole group with signs is asked, and stands if it leaves fewer.
    pub(super) fn of(&mut self, vectors: &[(Vec<f64>, f64)]) -> Vec<Option<String>> {
        let told = |classes: &Classes| -> Vec<Option<String>> {
            vectors.iter().map(|(x, error)| classes.of(x, *error).map(str::to_owned)).collect()
        };
        let missing = |labels: &[Option<String>]| labels.iter().filter(|l| l.is_none()).count();
        let own = told(&self.classes);
        let Some((pattern, invariance)) = self.more.as_mut().filter(|_| missing(&own) > 0) else { return own };
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
    let of_bodies = point_group(linearized).map(|(group, classes)| Labels { classes, group, more: None });
    if of_bodies.as_ref().is_some_and(|own| own.group.is_some()) {
        return of_bodies;
    }
    // Where coordinates are not exchanged one by one, the mirror of a body in a plane may lie askew.
    by_entries(linearized, mass, stiffness).or(of_bodies)
}

/// Whether modes with friction or rotation may have classes.
pub(super) fn may_classify(linearized: &Linearized) -> bool {
    let is_wanted = (2..=MOST_COORDINATES).contains(&linearized.coordinates()) && linearized.massless_directions() == 0;
    let pattern = || linearized.whole().and_then(|(mass, stiffness)| of_enclosures(&mass, &stiffness));
    is_wanted && pattern().is_some_and(|pattern| Symmetry::may_have_classes(&pattern))
}

/// Gives classes to modes with friction or rotation, whose real and imaginary parts are shapes of one class each.
pub(super) fn classify(linearized: &Linearized, modes: &mut [NormalMode]) {
    let is_whole = |own: &NormalMode| own.vector.len() == linearized.coordinates();
    if !modes.iter().any(is_whole) || !may_classify(linearized) {
        return;
    }
    let Some((mass, stiffness)) = linearized.whole() else { return };
    let Some(mut labels) = by_entries(linearized, &mass, &stiffness) else { return };
    let size = |x: &[f64]| x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let parts = modes.iter().map(|own| {
        let most = size(&own.vector).max(size(&own.imaginary));
        let error = own.vector_error_bound;
        let is_there = |x: &&Vec<f64>| size(x) > error.max(1e-9 * most);
        [&own.vector, &own.imaginary].into_iter().filter(is_there).map(|x| (x.clone(), error)).collect::<Vec<_>>()
    });
    let parts: Vec<Vec<(Vec<f64>, f64)>> = parts.collect();
    let found = labels.of(&parts.concat());
    // Of a larger group without names of its classes their numbers would tell little.
    if found.iter().flatten().any(|class| class.starts_with("class")) {
        return;
    }
    let mut classes = found.into_iter();
    for (mode, parts) in modes.iter_mut().zip(&parts) {
        let own: Vec<Option<String>> = classes.by_ref().take(parts.len()).collect();
        let is_one = own.windows(2).all(|pair| pair[0] == pair[1]);
        mode.symmetry = own.into_iter().next().flatten().filter(|_| is_one);
    }
}

/// From permutations of coordinates, with signs.
fn by_entries(linearized: &Linearized, mass: &SparseMatrix, stiffness: &SparseMatrix) -> Option<Labels> {
    let n = mass.dimension();
    let model = linearized.model();
    let tied = |mut pattern: Pattern| {
        for constraint in &model.constraints {
            let symbols = model.pool.symbols_of(&[constraint.expression]);
            let tied: Vec<usize> = symbols.iter().filter_map(|symbol| model.symbols.coordinate(*symbol)).collect();
            tied.iter().for_each(|i| tied.iter().for_each(|j| pattern.tie(*i, *j)));
        }
        pattern
    };
    let mut pattern = tied(of_enclosures(mass, stiffness)?);
    if !Symmetry::may_have_classes(&pattern) {
        return None;
    }
    let exact = (linearized.shares() <= MOST_SHARES).then(|| linearized.entries(BITS)).flatten();
    if let Some(exact) = exact.and_then(|entries| of_entries(n, &entries)) {
        pattern = tied(exact);
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
        pairs.order_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        // Equal numbers may differ by their rounding.
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-6 * (a.abs() + b.abs());
        pairs.windows(2).all(|pair| !near(pair[0].0, pair[1].0))
            || (pairs.windows(2).all(|pair| pair[0].0 == pair[1].0)
                && pairs.windows(2).all(|pair| !near(pair[0].1, pair[1].1)))
    };
    if diagonal_differs() {
        return None;
    }
    // Rounding differs with the order of summation: a little more than the radii is allowed.
    let classes = |matrix: &SparseMatrix| classes(matrix.entries(), 1e-29);
    Some(pattern(n, &classes(mass)?, &classes(stiffness)?))
}

fn of_entries(n: usize, entries: &Entries) -> Option<Pattern> {
    let classes = |of: &BTreeMap<(usize, usize), Big>| classes(of.iter().map(|((i, j), value)| (*i, *j, value)), 0.0);
    Some(pattern(n, &classes(&entries.mass)?, &classes(&entries.stiffness)?))
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
    entries.order_by_key(|(i, j, ..)| (*i, *j));
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

/// Numbers entries so that those whose enclosures meet, or nearly for their size, have the same number, and opposite ones opposite
/// numbers.
fn classes<'a, S: Enclosure + 'a>(
    entries: impl Iterator<Item = (usize, usize, &'a S)>,
    slack: f64,
) -> Option<Vec<(usize, usize, Class)>> {
    let entries: Vec<(usize, usize, &S)> = entries.collect();
    if !entries.iter().all(|(.., value)| value.is_finite()) {
        return None;
    }
    let mut classes: Vec<_> = entries.iter().map(|(i, j, _)| (*i, *j, 0)).collect();
    let told = entries.iter().enumerate().filter(|(_, (.., value))| value.is_positive() || value.is_negative());
    let mut order: Vec<(usize, S)> = told.map(|(at, (.., value))| (at, value.apply(Function::Abs))).collect();
    let is_above = |a: &S, b: &S| a.sub(b).center().is_positive();
    order.order_by(|(_, a), (_, b)| is_above(a, b).cmp(&is_above(b, a)));
    let mut class = 0;
    let mut last: Option<&S> = None;
    for (at, value) in &order {
        let is_other = last.is_none_or(|before| {
            let gap = value.sub(before);
            if slack > 0.0 { gap.with_added_radius(slack * value.mid_f64()).is_positive() } else { gap.is_positive() }
        });
        class += Class::from(is_other);
        last = Some(value);
        classes[*at].2 = if entries[*at].2.is_negative() { -class } else { class };
    }
    Some(classes)
}
