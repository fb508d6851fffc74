//! The stiffness matrix in exact rational numbers, where everything in it is rational.

use super::assemble::Assembly;
use crate::model::Model;
use crate::number::Number;
use crate::precision::{Ball, DoubleDouble, Function, Scalar};

/// Exact elimination is for small systems.
const MOST: usize = 60;

/// A rational number, or `None` where a result is not rational.
#[derive(Clone, Debug)]
struct Exact(Option<Number>);

impl Exact {
    fn of(&self, other: &Self, f: impl Fn(&Number, &Number) -> Option<Number>) -> Self {
        match (&self.0, &other.0) {
            (Some(a), Some(b)) => Self(f(a, b).filter(|result| !result.is_oversized())),
            (Some(_) | None, _) => Self(None),
        }
    }
}

impl Scalar for Exact {
    type Precision = ();

    fn from_number(number: &Number, (): ()) -> Self {
        Self(Some(number.clone()))
    }

    fn pi((): ()) -> Self {
        Self(None)
    }

    fn add(&self, other: &Self) -> Self {
        self.of(other, |a, b| Some(a.add(b)))
    }

    fn sub(&self, other: &Self) -> Self {
        self.of(other, |a, b| Some(a.sub(b)))
    }

    fn mul(&self, other: &Self) -> Self {
        // Zero times anything finite is zero, but what is not rational may not be finite.
        self.of(other, |a, b| Some(a.mul(b)))
    }

    fn div(&self, other: &Self) -> Self {
        self.of(other, Number::div)
    }

    fn neg(&self) -> Self {
        Self(self.0.as_ref().map(Number::neg))
    }

    fn powi(&self, exponent: i32) -> Self {
        Self(self.0.as_ref().and_then(|a| a.powi(exponent)))
    }

    fn sqrt(&self) -> Self {
        Self(self.0.as_ref().and_then(Number::sqrt_exact))
    }

    fn pow(&self, exponent: &Self) -> Self {
        self.of(exponent, |a, e| {
            let e = i32::try_from(e.to_i64()?).ok()?;
            a.powi(e)
        })
    }

    fn apply(&self, function: Function) -> Self {
        // The functions are rational at a few points only (Niven's theorem for the circular ones).
        let a = match &self.0 {
            Some(a) => a,
            None => return Self(None),
        };
        let (zero, one) = (a.is_zero(), a.is_one());
        Self(match function {
            Function::Sin
            | Function::Tan
            | Function::Asin
            | Function::Atan
            | Function::Sinh
            | Function::Tanh => zero.then(|| Number::from(0)),
            Function::Cos | Function::Cosh | Function::Exp => zero.then(|| Number::from(1)),
            Function::Acos | Function::Ln => one.then(|| Number::from(0)),
            Function::Abs => Some(a.abs()),
        })
    }

    fn atan2(&self, x: &Self) -> Self {
        match (&self.0, &x.0) {
            (Some(y), Some(x)) if y.is_zero() && !x.is_zero() && !x.is_negative() => {
                Self(Some(Number::from(0)))
            }
            (Some(_) | None, _) => Self(None),
        }
    }

    fn is_finite(&self) -> bool {
        self.0.is_some()
    }

    fn is_exact_zero(&self) -> bool {
        self.0.as_ref().is_some_and(Number::is_zero)
    }
}

/// A basis of the kernel of K, where K is rational; `None` where it is not, or too large.
pub(crate) fn kernel(model: &Model, assembly: &Assembly, at: &[Ball]) -> Option<Vec<Vec<Number>>> {
    let n = model.coordinates.len();
    if n > MOST {
        return None;
    }
    let values = assembly.values::<Exact>(model, ()).ok()?;
    let point: Option<Vec<Exact>> = at
        .iter()
        .enumerate()
        .map(|(i, value)| {
            let given = model.equilibria[i].and_then(|given| given.value);
            let exact = match given {
                Some(given) => super::assemble::evaluate_closed::<Exact>(&model.pool, given, ())?,
                None if value.is_exact() => Exact(exact_number(value.mid)),
                None => Exact(None),
            };
            exact.is_finite().then_some(exact)
        })
        .collect();
    let stiffness = assembly.stiffness(&point?, &values);
    let entries: Option<Vec<Number>> = stiffness.into_iter().map(|entry| entry.0).collect();
    let mut rows: Vec<Vec<Number>> = entries?.chunks(n).map(<[Number]>::to_vec).collect();
    // Gauss-Jordan elimination.
    let mut pivots: Vec<usize> = Vec::new();
    for column in 0..n {
        let done = pivots.len();
        let Some(found) = (done..n).find(|row| !rows[*row][column].is_zero()) else {
            continue;
        };
        rows.swap(done, found);
        let inverse = rows[done][column].recip()?;
        for entry in &mut rows[done] {
            *entry = entry.mul(&inverse);
        }
        let pivot = rows[done].clone();
        for (row, own) in rows.iter_mut().enumerate() {
            if row != done && !own[column].is_zero() {
                let factor = own[column].clone();
                for (entry, above) in own.iter_mut().zip(&pivot) {
                    *entry = entry.sub(&factor.mul(above));
                    if entry.is_oversized() {
                        return None;
                    }
                }
            }
        }
        pivots.push(column);
    }
    let free = (0..n).filter(|column| !pivots.contains(column));
    Some(
        free.map(|column| {
            let mut vector = vec![Number::from(0); n];
            vector[column] = Number::from(1);
            for (row, pivot) in pivots.iter().enumerate() {
                vector[*pivot] = rows[row][column].neg();
            }
            vector
        })
        .collect(),
    )
}

/// A double-double as a rational number.
fn exact_number(value: DoubleDouble) -> Option<Number> {
    Some(Number::from_f64_exact(value.hi)?.add(&Number::from_f64_exact(value.lo)?))
}
