//! The matrices in exact numbers, where everything in them is a root of a fraction or a sum of such.
//!
//! On the way there numbers may be rational multiples of square roots: distances between rational
//! points are, and in the stiffness of an unstressed spring between them they appear squared.

use std::borrow::Cow;
use std::collections::{BTreeMap, VecDeque};

use super::assemble::{Assembly, Part, Values, assemble};
use super::equilibrium::{Equilibrium, in_numbers};
use super::flow::Three;
use super::massless::{Direction, product};
use super::parameters::with_values;
use super::radicals::{Exact, Surd};
use super::velocity::{Matrix, Numbers, sum};
use super::{Linearized, elimination};
use crate::model::Model;
use crate::number::Number;
use crate::order::Gather;
use crate::precision::{Ball, Big, DoubleDouble, Integers, Magnitude, Scalar, sum_of_products};

/// Exact characteristic polynomials are for small systems.
pub(super) const MOST: usize = 60;

/// A matrix with more entries in its lower triangle is too much work to eliminate.
const MOST_ENTRIES: usize = 1_000_000;

/// A model with its assembly, or one with the values of parameters put in where these are no fractions.
fn put<'a>(model: &'a Model, assembly: &'a Assembly) -> (Cow<'a, Model>, Cow<'a, Assembly>) {
    let Some(mut valued) = with_values(model) else { return (Cow::Borrowed(model), Cow::Borrowed(assembly)) };
    let assembly = assemble(&mut valued);
    (Cow::Owned(valued), Cow::Owned(assembly))
}

/// Vectors of the kernel of K, independent of each other, where K is rational in units of its own for each
/// coordinate, which may be square roots; `None` where it is not, or too large, and none where its kernel has no
/// more dimensions than the `known` ones.
pub(super) fn kernel(own: &Linearized, known: usize) -> Option<Vec<Vec<Surd>>> {
    let (model, assembly) = put(&own.model, &own.assembly);
    let (at, values) = exactly(&model, &assembly, &own.equilibrium, |_| Exact::Unknown)?;
    let n = at.len();
    let mut lower: Vec<BTreeMap<u32, Exact>> = vec![BTreeMap::new(); n];
    let mut count = 0;
    assembly.entries(Part::Stiffness, &at, &values, |i, j, share| match lower[i as usize].get_mut(&j) {
        Some(entry) => *entry = entry.add(share),
        None if count > MOST_ENTRIES => {}
        None => {
            count += 1;
            lower[i as usize].insert(j, share.clone());
        }
    });
    if count > MOST_ENTRIES { None } else { kernel_of(lower, known) }
}

/// Such vectors of the kernel of a symmetric matrix, of which the lower triangle is given.
fn kernel_of(mut lower: Vec<BTreeMap<u32, Exact>>, known: usize) -> Option<Vec<Vec<Surd>>> {
    let n = lower.len();
    for row in &mut lower {
        row.retain(|_, entry| !entry.is_exact_zero());
    }
    let units = units(&lower)?;
    let mut rows: elimination::Rows = vec![Vec::new(); n];
    for (i, row) in (0_u32..).zip(&lower) {
        for (j, entry) in row {
            let (own, other) = (&units[i as usize], &units[*j as usize]);
            let entry = entry.mul(own).mul(other).as_rational()?.clone();
            if *j != i {
                rows[*j as usize].push((i, entry.clone()));
            }
            rows[i as usize].push((*j, entry));
        }
    }
    for row in &mut rows {
        row.sort_unstable_by_key(|(j, _)| *j);
    }
    let vectors = elimination::kernel(&rows, known)?;
    let in_units = |vector: Vec<Number>| -> Option<Vec<Surd>> {
        let components = vector.into_iter().zip(&units);
        components.map(|(x, unit)| Exact::rational(Some(x)).mul(unit).single().cloned()).collect()
    };
    vectors.into_iter().map(in_units).collect()
}

/// The combinations of columns that vanish, independent of each other, as [`kernel_of`] gives them: those of A are the kernel of AᵀA.
pub(super) fn kernel_of_columns(columns: &[&[Exact]]) -> Option<Vec<Vec<Surd>>> {
    let row = |i: usize| columns[..=i].iter().map(move |other| sum_of_products(columns[i], other, ()));
    kernel_of((0..columns.len()).map(|i| (0..).zip(row(i)).gather()).collect(), 0)
}

/// The directions that have no inertia, at the equilibrium and beside it, `all` or those that no force meets that goes with
/// velocities, where M is rational as K is for [`kernel`]; `None` where it is not, or too large.
pub(super) fn without_inertia(own: &Linearized, all: bool) -> Option<Vec<Direction>> {
    let n = own.model.coordinates.len();
    if n > MOST {
        return None;
    }
    let (model, assembly) = put(&own.model, &own.assembly);
    let (at, values) = exactly(&model, &assembly, &own.equilibrium, |value| Exact::rational(exact_number(value.mid)))?;
    let mass = assembly.mass(&at, &values);
    let others = [Matrix::Gyroscopic, Matrix::Damping].into_iter().filter(|_| !all);
    let others: Vec<_> = others.map(|matrix| assembly.velocity_matrix(matrix, &at, &values)).collect();
    // Neither M nor C is negative, mostly: then that is what both take to 0.
    let both = sum(Some(mass.clone()), others.last().cloned().flatten())?;
    let entry = |i: usize| (0..).zip((0..=i).map(|j| both[i + n * j].clone())).gather();
    let vectors = kernel_of((0..n).map(entry).collect(), 0)?;
    let shift = |(i, x): (usize, &Exact)| x.add(&Exact::rational(Number::ratio(7 * i as i64 + 5, 64)));
    let beside: Vec<Exact> = at.iter().enumerate().map(shift).collect();
    let mut matrices = vec![mass, assembly.mass(&beside, &values)];
    matrices.extend(others.into_iter().flatten());
    let vanishes = |a: &[Exact], v: &Direction, i: usize| {
        let sums = [product(v, |j| &a[i + n * j], ()), product(v, |j| &a[j + n * i], ())];
        sums.iter().all(Exact::is_exact_zero)
    };
    let direction = |vector: Vec<Surd>| -> Direction {
        let components = Surd::without_denominators(&vector).into_iter().enumerate();
        components.filter(|(_, x)| !x.is_zero()).collect()
    };
    let directions = vectors.into_iter().map(direction);
    Some(directions.filter(|v| matrices.iter().all(|a| (0..n).all(|i| vanishes(a, v, i)))).collect())
}

/// A combination of directions without inertia that takes no force, exactly: its image under K + N is 0.
pub(super) fn unheld(own: &Linearized, directions: &[Direction]) -> Option<Direction> {
    let (model, assembly) = put(&own.model, &own.assembly);
    let (at, values) = settled(&model, &assembly, &own.equilibrium)?;
    let n = at.len();
    let circulatory = assembly.velocity_matrix(Matrix::Circulatory, &at, &values);
    let stiffness = sum(Some(assembly.stiffness(&at, &values)), circulatory)?;
    let image = |v: &Direction| (0..n).map(|i| product(v, |j| &stiffness[i + n * j], ())).collect();
    let images: Vec<Vec<Exact>> = directions.iter().map(image).collect();
    let images: Vec<&[Exact]> = images.iter().map(Vec::as_slice).collect();
    let combination = kernel_of_columns(&images)?.into_iter().next()?;
    let mut combined = vec![Exact::rational(Some(Number::ZERO)); n];
    for (v, factor) in directions.iter().zip(combination) {
        let factor = Exact::of(factor);
        for (i, x) in v {
            combined[*i] = combined[*i].add(&Exact::of(x.clone()).mul(&factor));
        }
    }
    let components = combined.iter().enumerate().filter(|(_, x)| !x.is_exact_zero());
    components.map(|(i, x)| Some((i, x.single()?.clone()))).collect()
}

/// Units of the coordinates in which K may be rational: square roots that those of its entries say, from
/// neighbour to neighbour.
fn units(lower: &[BTreeMap<u32, Exact>]) -> Option<Vec<Exact>> {
    let n = lower.len();
    let mut neighbours: Vec<Vec<(usize, &Number)>> = vec![Vec::new(); n];
    let mut rational = true;
    for (i, row) in lower.iter().enumerate() {
        for (j, entry) in row {
            let radicand = entry.single()?.square_root_of()?;
            rational &= radicand.is_one();
            neighbours[i].push((*j as usize, radicand));
            neighbours[*j as usize].push((i, radicand));
        }
    }
    let one = || Exact::new(Number::ONE, Number::ONE);
    if rational {
        return Some(vec![one(); n]);
    }
    let mut squares: Vec<Option<Number>> = vec![None; n];
    let mut queue = VecDeque::new();
    for start in 0..n {
        if squares[start].is_none() {
            squares[start] = Some(Number::ONE);
            queue.push_back(start);
        }
        while let Some(i) = queue.pop_front() {
            let own = squares[i].clone()?;
            for (j, radicand) in &neighbours[i] {
                if squares[*j].is_none() {
                    // What both have in common is there twice.
                    let common = own.gcd(radicand);
                    let square = own.div(&common)?.mul(&radicand.div(&common)?);
                    let whole = square.sqrt_exact().is_some();
                    squares[*j] = Some(if whole { Number::ONE } else { square });
                    queue.push_back(*j);
                }
            }
        }
    }
    let unit = |square: Option<Number>| square.map(|square| Exact::new(Number::ONE, square));
    squares.into_iter().map(unit).collect()
}

/// Whether all forces on some coordinates are exactly 0 at an equilibrium.
pub(super) fn forces_vanish(model: &Model, assembly: &Assembly, equilibrium: &Equilibrium, on: &[usize]) -> bool {
    let (model, assembly) = put(model, assembly);
    exactly(&model, &assembly, equilibrium, |_| Exact::Unknown).is_some_and(|(at, values)| {
        let force = assembly.gradient(&at, &values);
        on.iter().all(|i| force[*i].is_exact_zero())
    })
}

/// The equilibrium in exact numbers, and what else is evaluated in these, if it is known in such; `other` is asked for coordinates that
/// are neither given nor exact.
fn exactly(
    model: &Model,
    assembly: &Assembly,
    equilibrium: &Equilibrium,
    other: impl Fn(&Ball) -> Exact,
) -> Option<(Vec<Exact>, Values<Exact>)> {
    let values = assembly.values::<Exact>(model, ()).ok()?;
    let number =
        |value: &Ball| Some(if value.is_exact() { Exact::rational(exact_number(value.mid)) } else { other(value) });
    let at = equilibrium.in_numbers(model, (), number)?;
    at.iter().all(Exact::is_finite).then_some((at, values))
}

/// The same of a small model, for one that was searched for and proved too: fractions and square roots of
/// fractions within the radii, where all forces vanish exactly there. There is no other equilibrium within these.
fn settled(model: &Model, assembly: &Assembly, equilibrium: &Equilibrium) -> Option<(Vec<Exact>, Values<Exact>)> {
    if model.coordinates.len() > MOST {
        return None;
    }
    if let Some(known) = exactly(model, assembly, equilibrium, |_| Exact::Unknown) {
        return Some(known);
    }
    let guess = |value: &Ball| recognised(value).unwrap_or(Exact::Unknown);
    let (place, values) = exactly(model, assembly, equilibrium, guess).filter(|_| equilibrium.proved)?;
    let forces = assembly.gradient(&place, &values);
    forces.iter().all(Exact::is_exact_zero).then_some((place, values))
}

/// Simple numbers beside a place that was searched for, where all forces on the coordinates `free` vanish exactly.
pub(super) fn beside(model: &Model, assembly: &Assembly, at: &[Ball], free: &[usize]) -> Option<Vec<Ball>> {
    if at.len() > MOST {
        return None;
    }
    let values = assembly.values::<Exact>(model, ()).ok()?;
    let sizes = free.iter().map(|i| at[*i].mid_f64().abs());
    let reach = NEAR * sizes.fold(0.0, f64::max);
    let stated = |i: usize| model.equilibria.get(i).filter(|_| !free.contains(&i))?.value;
    let simple = |value: &Ball| recognised(&Ball::from(value.mid).with_added_radius(reach));
    let place: Vec<Exact> = in_numbers(&model.pool, at, (), stated, simple)?;
    let force = assembly.gradient(&place, &values);
    let vanish = free.iter().all(|i| force[*i].is_exact_zero());
    let numbers = place.iter().map(|exact| exact.in_numbers::<Ball>(()));
    let found = vanish.then(|| numbers.collect::<Option<Vec<Ball>>>())??;
    Some(found.into_iter().map(|x| Ball::from(x.mid)).collect())
}

/// A searched place is as near as this, beside the largest coordinate.
const NEAR: f64 = 1e-13;

/// The simplest fraction within the radius, the square root of the simplest whose root is, or a solution of a quadratic equation with
/// small coefficients: a guess.
pub(super) fn recognised(value: &Ball) -> Option<Exact> {
    let (mid, radius) = (exact_number(value.mid)?, Number::from_f64_exact(value.radius)?);
    let most = most_bits(value);
    let within = |mid: &Number, radius: &Number| {
        let fraction = simplest(mid, radius)?;
        (fraction.bits() <= most).then_some(fraction)
    };
    if let Some(fraction) = within(&mid, &radius) {
        return Some(Exact::rational(Some(fraction)));
    }
    // In numbers whose rounding is far below the radius.
    let held = |exact: &Exact| {
        let value = exact.in_numbers::<Big>(BITS_TO_COMPARE)?;
        let off = (&value - &Big::from_number(&mid, BITS_TO_COMPARE)).abs_upper();
        (off <= Magnitude::from_f64(radius.to_f64())).then(|| exact.clone())
    };
    // |x² - m²| <= 3 |m| r for x between m - r and m + r, r <= |m|.
    let slack = Number::from(3).mul(&mid.abs()).mul(&radius);
    let root = within(&mid.mul(&mid), &slack).filter(|square| !square.is_zero());
    let sign = Number::from(if mid.is_negative() { -1 } else { 1 });
    let root = root.and_then(|square| held(&Exact::new(sign, square)));
    root.or_else(|| quadratic(value, most).find_map(|exact| held(&exact)))
}

/// Solutions of a x² + b x + c = 0 near the value.
fn quadratic(value: &Ball, most: usize) -> impl Iterator<Item = Exact> {
    let value = *value;
    let most = if most < 24 { 0 } else { MOST_COEFFICIENT };
    let linear = (1..=most).flat_map(move |a| (-4 * most..=4 * most).map(move |b| (a, b)));
    linear.filter_map(move |(a, b)| {
        let [x, y] = [a, b].map(|x| Ball::from(x as f64));
        let rest = -(x * value + y) * value;
        let c = rest.mid_f64().round();
        if c.abs() > 1e9 || !(rest - Ball::from(c)).contains_zero() {
            return None;
        }
        let square = Number::from(b * b - 4 * a * c as i64);
        let (half, part) = (Number::ratio(-b, 2 * a)?, Number::ratio(1, 2 * a)?);
        if square.is_negative() {
            return None;
        }
        let root = Exact::new(part, square);
        let half = Exact::rational(Some(half));
        let above = value.mid_f64() > -(b as f64) / (2 * a) as f64;
        Some(if above { half.add(&root) } else { half.sub(&root) })
    })
}

/// Of the square of a coordinate that is searched for.
const MOST_COEFFICIENT: i64 = 24;

/// Guesses are compared with so many bits.
const BITS_TO_COMPARE: usize = 320;

/// A fraction that is half as long as an enclosure is narrow is there by chance once in a thousand times, or more seldom.
fn most_bits(value: &Ball) -> usize {
    let narrow = (value.mid_f64().abs() / value.radius).log2() / 2.0 - 5.0;
    // Without a radius, or 0 within one.
    if narrow.is_nan() || narrow <= 1.0 { 1 } else { (narrow as usize).min(MOST_GUESSED) }
}

/// Numbers with more bits are no guesses.
const MOST_GUESSED: usize = 60;

/// The last convergent that is needed to come within the radius (Khinchin, Continued Fractions, 6).
pub(super) fn simplest(mid: &Number, radius: &Number) -> Option<Number> {
    let (mut before, mut last) = ((Number::ZERO, Number::ONE), (Number::ONE, Number::ZERO));
    let mut rest = mid.clone();
    loop {
        let whole = rest.floor();
        let next = (whole.mul(&last.0).add(&before.0), whole.mul(&last.1).add(&before.1));
        let fraction = next.0.div(&next.1)?;
        if fraction.sub(mid).abs() <= *radius {
            return Some(fraction);
        }
        if next.1.bits() > MOST_GUESSED {
            return None;
        }
        rest = rest.sub(&whole).recip()?;
        (before, last) = (last, next);
    }
}

/// The exact matrices, in units in which their entries are fractions or combinations of a few square roots.
pub(super) fn integers(own: &Linearized) -> Option<Integers> {
    let (model, assembly) = put(&own.model, &own.assembly);
    let (at, values) = settled(&model, &assembly, &own.equilibrium)?;
    super::integers::integers(&three(assembly.matrices(&at, &values))?)
}

/// M, G + C and K + N, those that are not there filled with 0.
pub(super) fn three([mass, gyroscopic, damping, stiffness, circulatory]: Numbers<Exact>) -> Option<Three<Exact>> {
    let (mass, stiffness) = (mass?, sum(stiffness, circulatory)?);
    let nothing = || vec![Exact::rational(Some(Number::ZERO)); mass.len()];
    let velocity = sum(gyroscopic, damping).unwrap_or_else(nothing);
    Some([mass, velocity, stiffness])
}

/// A double-double as a rational number.
fn exact_number(value: DoubleDouble) -> Option<Number> {
    Some(Number::from_f64_exact(value.hi)?.add(&Number::from_f64_exact(value.lo)?))
}
