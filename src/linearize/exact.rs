//! The stiffness matrix in exact numbers, where everything in it is rational.
//!
//! On the way there numbers may be rational multiples of square roots: distances between rational
//! points are, and in the stiffness of an unstressed spring between them they appear squared.

use std::collections::{BTreeMap, VecDeque};

use dashu_int::IBig;

use super::assemble::{Assembly, Part, Values};
use super::elimination;
use super::equilibrium::Equilibrium;
use super::rational::whole;
use super::velocity::Matrix;
use crate::model::Model;
use crate::number::Number;
use crate::precision::{Ball, DoubleDouble, Function, Scalar};

/// Exact characteristic polynomials are for small systems.
const MOST: usize = 60;

/// A matrix with more entries in its lower triangle is too much work to eliminate.
const MOST_ENTRIES: usize = 1_000_000;

/// A rational multiple of the square root of a rational number, or `None` for what is no such.
#[derive(Clone, Debug)]
struct Exact(Option<Surd>);

/// factor·√radicand; the radicand is positive, and 1 where its root is rational.
#[derive(Clone, Debug)]
pub(super) struct Surd {
    factor: Number,
    radicand: Number,
}

impl Surd {
    fn rational(factor: Number) -> Self {
        Self {
            factor,
            radicand: Number::ONE,
        }
    }

    /// The number as a fraction, if it is one.
    fn as_rational(&self) -> Option<&Number> {
        self.radicand.is_one().then_some(&self.factor)
    }

    pub(super) fn in_numbers<S: Scalar>(&self, precision: S::Precision) -> S {
        let factor = S::from_number(&self.factor, precision);
        if self.radicand.is_one() {
            return factor;
        }
        factor.mul(&S::from_number(&self.radicand, precision).sqrt())
    }
}

impl Exact {
    /// factor·√radicand for a radicand that is positive.
    fn new(factor: Number, radicand: Number) -> Self {
        if factor.is_oversized() || radicand.is_oversized() {
            return Self(None);
        }
        if factor.is_zero() || radicand.is_one() {
            return Self(Some(Surd::rational(factor)));
        }
        Self(Some(match radicand.sqrt_exact() {
            Some(root) => Surd::rational(factor.mul(&root)),
            None => Surd { factor, radicand },
        }))
    }

    fn rational(factor: Option<Number>) -> Self {
        match factor {
            Some(factor) => Self::new(factor, Number::ONE),
            None => Self(None),
        }
    }

    fn of(&self, other: &Self, f: impl Fn(&Surd, &Surd) -> Option<Self>) -> Self {
        match (&self.0, &other.0) {
            (Some(a), Some(b)) => f(a, b).unwrap_or(Self(None)),
            (Some(_) | None, _) => Self(None),
        }
    }

    fn as_rational(&self) -> Option<&Number> {
        self.0.as_ref().and_then(Surd::as_rational)
    }
}

impl Scalar for Exact {
    type Precision = ();

    fn from_number(number: &Number, (): ()) -> Self {
        Self(Some(Surd::rational(number.clone())))
    }

    fn pi((): ()) -> Self {
        Self(None)
    }

    fn add(&self, other: &Self) -> Self {
        self.of(other, |a, b| {
            if a.factor.is_zero() {
                return Some(other.clone());
            }
            if b.factor.is_zero() {
                return Some(self.clone());
            }
            // √b = √(ab)/a·√a, where that makes a fraction of √(ab)/a.
            let ratio = if a.radicand == b.radicand {
                Number::ONE
            } else {
                let both = a.radicand.mul(&b.radicand).sqrt_exact()?;
                both.div(&a.radicand)?
            };
            let sum = a.factor.add(&b.factor.mul(&ratio));
            Some(Self::new(sum, a.radicand.clone()))
        })
    }

    fn sub(&self, other: &Self) -> Self {
        self.add(&other.neg())
    }

    fn mul(&self, other: &Self) -> Self {
        // Zero times anything finite is zero, but what is no such number may not be finite.
        self.of(other, |a, b| {
            let factor = a.factor.mul(&b.factor);
            Some(if a.radicand == b.radicand {
                Self::new(factor.mul(&a.radicand), Number::ONE)
            } else {
                Self::new(factor, a.radicand.mul(&b.radicand))
            })
        })
    }

    fn div(&self, other: &Self) -> Self {
        self.of(other, |a, b| {
            let factor = a.factor.div(&b.factor)?;
            Some(Self::new(factor, a.radicand.div(&b.radicand)?))
        })
    }

    fn neg(&self) -> Self {
        Self(self.0.as_ref().map(|a| Surd {
            factor: a.factor.neg(),
            radicand: a.radicand.clone(),
        }))
    }

    fn powi(&self, exponent: i32) -> Self {
        let power = |a: &Surd| {
            let whole = a.radicand.powi(exponent.div_euclid(2))?;
            let factor = a.factor.powi(exponent)?.mul(&whole);
            let odd = exponent.rem_euclid(2) == 1;
            let rest = if odd { a.radicand.clone() } else { Number::ONE };
            Some(Self::new(factor, rest))
        };
        self.0.as_ref().and_then(power).unwrap_or(Self(None))
    }

    fn sqrt(&self) -> Self {
        match self.as_rational() {
            Some(a) if a.is_zero() => self.clone(),
            Some(a) if !a.is_negative() => Self::new(Number::ONE, a.clone()),
            Some(_) | None => Self(None),
        }
    }

    fn pow(&self, exponent: &Self) -> Self {
        match exponent.as_rational().and_then(Number::to_i64) {
            Some(exponent) => i32::try_from(exponent).map_or(Self(None), |e| self.powi(e)),
            None => Self(None),
        }
    }

    fn apply(&self, function: Function) -> Self {
        // The functions are rational at a few points only (Niven's theorem for the circular ones).
        if function == Function::Abs {
            return Self(self.0.as_ref().map(|a| Surd {
                factor: a.factor.abs(),
                radicand: a.radicand.clone(),
            }));
        }
        let Some(a) = self.as_rational() else {
            return Self(None);
        };
        let (zero, one) = (a.is_zero(), a.is_one());
        Self::rational(match function {
            Function::Sin
            | Function::Tan
            | Function::Asin
            | Function::Atan
            | Function::Sinh
            | Function::Tanh => zero.then(|| Number::from(0)),
            Function::Cos | Function::Cosh | Function::Exp => zero.then_some(Number::ONE),
            Function::Acos | Function::Ln => one.then(|| Number::from(0)),
            Function::Abs => None,
        })
    }

    fn atan2(&self, x: &Self) -> Self {
        let ahead = |x: &Surd| !x.factor.is_zero() && !x.factor.is_negative();
        match &x.0 {
            Some(x) if self.is_exact_zero() && ahead(x) => Self::rational(Some(Number::ZERO)),
            Some(_) | None => Self(None),
        }
    }

    fn is_finite(&self) -> bool {
        self.0.is_some()
    }

    fn is_exact_zero(&self) -> bool {
        self.0.as_ref().is_some_and(|a| a.factor.is_zero())
    }
}

/// Vectors of the kernel of K, independent of each other, where K is rational in units of its own for each
/// coordinate, which may be square roots; `None` where it is not, or too large, and none where its kernel has no
/// more dimensions than the `known` ones.
pub(super) fn kernel(
    model: &Model,
    assembly: &Assembly,
    equilibrium: &Equilibrium,
    known: usize,
) -> Option<Vec<Vec<Surd>>> {
    let n = model.coordinates.len();
    let values = assembly.values::<Exact>(model, ()).ok()?;
    let at = point(model, equilibrium, |_| Exact(None))?;
    let mut lower: Vec<BTreeMap<u32, Exact>> = vec![BTreeMap::new(); n];
    let mut count = 0;
    assembly.entries(Part::Stiffness, &at, &values, |i, j, share| {
        match lower[i as usize].get_mut(&j) {
            Some(entry) => *entry = entry.add(share),
            None if count > MOST_ENTRIES => {}
            None => {
                count += 1;
                lower[i as usize].insert(j, share.clone());
            }
        }
    });
    if count > MOST_ENTRIES {
        return None;
    }
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
        components
            .map(|(x, unit)| Exact::rational(Some(x)).mul(unit).0)
            .collect()
    };
    vectors.into_iter().map(in_units).collect()
}

/// Units of the coordinates in which K may be rational: square roots that those of its entries say, from
/// neighbour to neighbour.
fn units(lower: &[BTreeMap<u32, Exact>]) -> Option<Vec<Exact>> {
    let n = lower.len();
    let mut neighbours: Vec<Vec<(usize, &Number)>> = vec![Vec::new(); n];
    let mut rational = true;
    for (i, row) in lower.iter().enumerate() {
        for (j, entry) in row {
            let radicand = &entry.0.as_ref()?.radicand;
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
pub(super) fn forces_vanish(
    model: &Model,
    assembly: &Assembly,
    equilibrium: &Equilibrium,
    on: &[usize],
) -> bool {
    let (Ok(values), Some(at)) = (
        assembly.values::<Exact>(model, ()),
        point(model, equilibrium, |_| Exact(None)),
    ) else {
        return false;
    };
    let force = assembly.gradient(&at, &values);
    on.iter().all(|i| force[*i].is_exact_zero())
}

/// The equilibrium in exact numbers, if it is known in such; `other` is asked for coordinates that are neither given nor
/// exact.
fn point(
    model: &Model,
    equilibrium: &Equilibrium,
    other: impl Fn(&Ball) -> Exact,
) -> Option<Vec<Exact>> {
    let place = |(i, value): (usize, &Ball)| {
        let exact = match equilibrium.expression(model, i) {
            Some(given) => super::assemble::evaluate_closed::<Exact>(&model.pool, given, ())?,
            None if value.is_exact() => Exact::rational(exact_number(value.mid)),
            None => other(value),
        };
        exact.is_finite().then_some(exact)
    };
    equilibrium.values.iter().enumerate().map(place).collect()
}

/// The same for one that was searched for and proved: fractions and square roots of fractions within the radii, where all
/// forces vanish exactly there. There is no other equilibrium within these.
fn settled(
    model: &Model,
    assembly: &Assembly,
    values: &Values<Exact>,
    equilibrium: &Equilibrium,
) -> Option<Vec<Exact>> {
    if let Some(known) = point(model, equilibrium, |_| Exact(None)) {
        return Some(known);
    }
    let place = point(model, equilibrium, recognised).filter(|_| equilibrium.proved)?;
    let forces = assembly.gradient(&place, values);
    forces.iter().all(Exact::is_exact_zero).then_some(place)
}

/// The simplest fraction within the radius, or the square root of the simplest whose root is: a guess.
fn recognised(value: &Ball) -> Exact {
    let within = |mid: &Number, radius: &Number| {
        let fraction = simplest(mid, radius)?;
        (fraction.bits() <= MOST_GUESSED).then_some(fraction)
    };
    let guess = || {
        let mid = exact_number(value.mid)?;
        let radius = Number::from_f64_exact(value.radius)?;
        if let Some(fraction) = within(&mid, &radius) {
            return Some(Exact::rational(Some(fraction)));
        }
        // |x² - m²| <= |m| r for x between m - r/2 and m + r/2.
        let slack = mid.abs().mul(&radius);
        let square = within(&mid.mul(&mid), &slack).filter(|square| !square.is_zero())?;
        let sign = Number::from(if mid.is_negative() { -1 } else { 1 });
        let near = Ball::from_number(&square, ()).sqrt() - Ball::from(value.mid).abs();
        let root = Exact::new(sign, square);
        (near.abs_upper() <= value.radius).then_some(root)
    };
    guess().unwrap_or(Exact(None))
}

/// Numbers with more bits are no guesses.
const MOST_GUESSED: usize = 60;

/// The last convergent that is needed to come within the radius (Khinchin, Continued Fractions, 6).
fn simplest(mid: &Number, radius: &Number) -> Option<Number> {
    let (mut before, mut last) = ((Number::ZERO, Number::ONE), (Number::ONE, Number::ZERO));
    let mut rest = mid.clone();
    loop {
        let whole = rest.floor();
        let next = (
            whole.mul(&last.0).add(&before.0),
            whole.mul(&last.1).add(&before.1),
        );
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

/// M, G + C and K + N in units in which they are rational, times one positive number, column by column.
#[derive(Clone, Debug)]
pub struct Integers {
    /// M, G + C and K + N.
    pub matrices: [Vec<IBig>; 3],
    /// Exponents are in units of its root.
    pub rate: IBig,
    /// Coordinates are in units of the roots of these.
    pub coordinates: Vec<IBig>,
}

impl Integers {
    /// Matrices that are rational as they stand.
    pub(super) fn plain(matrices: [Vec<IBig>; 3]) -> Self {
        Self {
            matrices,
            rate: IBig::ONE,
            coordinates: Vec::new(),
        }
    }
}

/// The exact matrices, where units make all entries rational.
///
/// With q_i = √u_i q'_i and λ = √r λ' the matrices are r √(u_i u_j) M_ij, √(r u_i u_j) D_ij and √(u_i u_j) S_ij. An
/// entry √a of M or S wants u_j = a u_i, up to the square of a fraction; one of D wants u_j = a r u_i.
pub(crate) fn integers(
    model: &Model,
    assembly: &Assembly,
    equilibrium: &Equilibrium,
) -> Option<Integers> {
    let n = model.coordinates.len();
    if n > MOST {
        return None;
    }
    let values = assembly.values::<Exact>(model, ()).ok()?;
    let at = settled(model, assembly, &values, equilibrium)?;
    let part = |matrix| assembly.velocity_matrix(matrix, &at, &values);
    let zeros = || vec![Exact::rational(Some(Number::ZERO)); n * n];
    let sum = |left: Vec<Exact>, right: Option<Vec<Exact>>| -> Vec<Exact> {
        match right {
            Some(right) => left.iter().zip(&right).map(|(x, y)| x.add(y)).collect(),
            None => left,
        }
    };
    let velocity = sum(zeros(), part(Matrix::Gyroscopic));
    let matrices = [
        assembly.mass(&at, &values),
        sum(velocity, part(Matrix::Damping)),
        sum(assembly.stiffness(&at, &values), part(Matrix::Circulatory)),
    ];
    let surds = matrices.iter().flatten().map(|entry| entry.0.clone());
    let surds = surds.collect::<Option<Vec<Surd>>>()?;
    let mut rates = vec![Number::ONE];
    for own in surds[n * n..2 * n * n]
        .iter()
        .filter(|x| !x.factor.is_zero())
    {
        let rate = whole_class(&own.radicand);
        if !rates.contains(&rate) {
            rates.push(rate);
        }
    }
    rates.truncate(MOST_RATES);
    rates.into_iter().find_map(|rate| {
        let coordinates = units_of_all(&surds, n, &rate);
        let mut numbers = in_units(&surds, n, &rate, &coordinates)?;
        let stiffness = numbers.split_off(2 * n * n);
        let velocity = numbers.split_off(n * n);
        let parts = [numbers, velocity, stiffness];
        Some(Integers {
            matrices: whole(&parts)?,
            rate: rate.numerator(),
            coordinates: coordinates.iter().map(Number::numerator).collect(),
        })
    })
}

/// So many units of exponents are tried.
const MOST_RATES: usize = 4;

/// Units of the coordinates as the entries want them, one entry after the other; whether all agree is seen in
/// [`in_units`].
fn units_of_all(surds: &[Surd], n: usize, rate: &Number) -> Vec<Number> {
    let mut units: Vec<Option<Number>> = vec![None; n];
    for first in 0..n {
        if units[first].is_some() {
            continue;
        }
        units[first] = Some(Number::ONE);
        let mut todo = vec![first];
        while let Some(i) = todo.pop() {
            for j in 0..n {
                let own = [0, 1, 2].map(|matrix| &surds[matrix * n * n + i + n * j]);
                let Some(matrix) = own.iter().position(|x| !x.factor.is_zero()) else {
                    continue;
                };
                let (Some(unit), None) = (&units[i], &units[j]) else {
                    continue;
                };
                let mut wanted = own[matrix].radicand.mul(unit);
                if matrix == 1 {
                    wanted = wanted.mul(rate);
                }
                units[j] = Some(whole_class(&wanted));
                todo.push(j);
            }
        }
    }
    let units = units.into_iter();
    units.map(|unit| unit.unwrap_or(Number::ONE)).collect()
}

/// The fraction times the square of one: whole, and 1 if that is so.
fn whole_class(x: &Number) -> Number {
    if x.sqrt_exact().is_some() {
        return Number::ONE;
    }
    Number::from_integer(x.numerator() * IBig::from(x.denominator()))
}

/// The entries of the three matrices in these units, where all are rational.
fn in_units(surds: &[Surd], n: usize, rate: &Number, units: &[Number]) -> Option<Vec<Number>> {
    let root = |x: &Number| Exact::new(Number::ONE, x.clone());
    let entry = |(at, own): (usize, &Surd)| {
        let (i, j) = (at % n, at / n % n);
        let mut entry = Exact(Some(own.clone()));
        entry = entry.mul(&root(&units[i].mul(&units[j])));
        entry = match at / (n * n) {
            0 => entry.mul(&Exact::rational(Some(rate.clone()))),
            1 => entry.mul(&root(rate)),
            _ => entry,
        };
        let entry = entry.as_rational()?;
        (!entry.is_oversized()).then(|| entry.clone())
    };
    surds.iter().enumerate().map(entry).collect()
}

/// A double-double as a rational number.
fn exact_number(value: DoubleDouble) -> Option<Number> {
    Some(Number::from_f64_exact(value.hi)?.add(&Number::from_f64_exact(value.lo)?))
}
