//! The stiffness matrix in exact numbers, where everything in it is rational.
//!
//! On the way there numbers may be rational multiples of square roots: distances between rational
//! points are, and in the stiffness of an unstressed spring between them they appear squared.

use std::collections::{BTreeMap, VecDeque};

use dashu_int::IBig;

use super::assemble::{Assembly, Part};
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
            radicand: Number::from(1),
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
            Some(factor) => Self::new(factor, Number::from(1)),
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
                Number::from(1)
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
                Self::new(factor.mul(&a.radicand), Number::from(1))
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
            let rest = if odd {
                a.radicand.clone()
            } else {
                Number::from(1)
            };
            Some(Self::new(factor, rest))
        };
        self.0.as_ref().and_then(power).unwrap_or(Self(None))
    }

    fn sqrt(&self) -> Self {
        match self.as_rational() {
            Some(a) if a.is_zero() => self.clone(),
            Some(a) if !a.is_negative() => Self::new(Number::from(1), a.clone()),
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
            Function::Cos | Function::Cosh | Function::Exp => zero.then(|| Number::from(1)),
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
    let at = point(model, equilibrium)?;
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
        point(model, equilibrium),
    ) else {
        return false;
    };
    let force = assembly.gradient(&at, &values);
    on.iter().all(|i| force[*i].is_exact_zero())
}

/// The equilibrium in exact numbers, if it is known in such.
fn point(model: &Model, equilibrium: &Equilibrium) -> Option<Vec<Exact>> {
    let place = |(i, value): (usize, &Ball)| {
        let exact = match equilibrium.expression(model, i) {
            Some(given) => super::assemble::evaluate_closed::<Exact>(&model.pool, given, ())?,
            None if value.is_exact() => Exact::rational(exact_number(value.mid)),
            None => Exact(None),
        };
        exact.is_finite().then_some(exact)
    };
    equilibrium.values.iter().enumerate().map(place).collect()
}

/// M, G + C and K + N times one positive number, column by column, where all entries are rational.
pub(crate) fn integers(
    model: &Model,
    assembly: &Assembly,
    equilibrium: &Equilibrium,
) -> Option<[Vec<IBig>; 3]> {
    let n = model.coordinates.len();
    if n > MOST {
        return None;
    }
    let values = assembly.values::<Exact>(model, ()).ok()?;
    let at = point(model, equilibrium)?;
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
    let mut fractions = matrices.iter().map(|matrix| {
        let entries = matrix.iter().map(|entry| entry.as_rational().cloned());
        entries.collect::<Option<Vec<Number>>>()
    });
    whole(&[fractions.next()??, fractions.next()??, fractions.next()??])
}

/// A double-double as a rational number.
fn exact_number(value: DoubleDouble) -> Option<Number> {
    Some(Number::from_f64_exact(value.hi)?.add(&Number::from_f64_exact(value.lo)?))
}
