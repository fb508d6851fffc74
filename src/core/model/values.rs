//! Values of expressions: scalars, vectors and matrices of symbolic expressions, and what can be
//! done with them.

use crate::expr::{ExprId, Pool, ZERO};
use crate::number::Number;

/// A scalar, or a vector of scalars, vectors, …
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Scalar(ExprId),
    Vector(Vec<Value>),
    /// An empty sum: 0 of any shape.
    Zero,
}

/// Why an operation on shapes is impossible: the sentence, and the way out.
pub(super) type Misfit = (String, Option<String>);

impl Value {
    /// A vector of numbers, or a matrix by its rows.
    pub(super) fn rows(parts: Vec<Self>) -> Result<Self, Misfit> {
        let parts = filled(parts);
        let width = |part: &Self| part.parts().map(<[Self]>::len);
        if let Some(first) = parts.first()
            && let Some(other) = parts.iter().find(|part| width(part) != width(first))
        {
            let help = "rows of a matrix have the same length";
            return Err((format!("{} stands beside {}", other.describe(), first.describe()), Some(help.to_owned())));
        }
        Ok(Self::Vector(parts))
    }

    pub(super) fn describe(&self) -> String {
        match self {
            Self::Scalar(_) => "a number".to_owned(),
            Self::Vector(rows) => match rows.first() {
                Some(Self::Vector(columns)) => format!("a {} x {} matrix", rows.len(), columns.len()),
                Some(Self::Scalar(_) | Self::Zero) | None => format!("a vector of {}", rows.len()),
            },
            Self::Zero => "an empty sum".to_owned(),
        }
    }

    pub(super) fn scalar(&self, what: &str) -> Result<ExprId, Misfit> {
        match self {
            Self::Scalar(e) => Ok(*e),
            Self::Zero => Ok(ZERO),
            Self::Vector(_) => Err((format!("{what} must be a number, but is {}", self.describe()), None)),
        }
    }

    /// The components of a plain vector; none of an empty sum.
    pub(super) fn components(&self, what: &str) -> Result<Vec<ExprId>, Misfit> {
        if *self == Self::Zero {
            return Ok(Vec::new());
        }
        let parts: Option<Vec<ExprId>> =
            self.parts().and_then(|rows| rows.iter().map(|row| row.scalar("").ok()).collect());
        parts.ok_or_else(|| (format!("{what} must be a vector, but is {}", self.describe()), None))
    }

    /// The rows of a rectangular matrix.
    pub(super) fn matrix(&self, what: &str) -> Result<Vec<Vec<ExprId>>, Misfit> {
        let rows: Option<Vec<Vec<ExprId>>> =
            self.parts().and_then(|rows| rows.iter().map(|row| row.components("").ok()).collect());
        let is_matrix = |rows: &Vec<Vec<ExprId>>| {
            let width = rows.first().map_or(0, Vec::len);
            width > 0 && rows.iter().all(|row| row.len() == width)
        };
        rows.filter(is_matrix).ok_or_else(|| (format!("{what} must be a matrix, but is {}", self.describe()), None))
    }

    fn parts(&self) -> Option<&[Self]> {
        if let Self::Vector(parts) = self { Some(parts) } else { None }
    }

    pub(super) fn from_components(parts: Vec<ExprId>) -> Self {
        Self::Vector(parts.into_iter().map(Self::Scalar).collect())
    }

    pub(super) fn from_rows(rows: Vec<Vec<ExprId>>) -> Self {
        Self::Vector(rows.into_iter().map(Self::from_components).collect())
    }

    /// All scalars, in order.
    pub(super) fn scalars(&self) -> Vec<ExprId> {
        match self {
            Self::Scalar(e) => vec![*e],
            Self::Zero => vec![ZERO],
            Self::Vector(rows) => rows.iter().flat_map(Self::scalars).collect(),
        }
    }

    /// The same shape with other scalars.
    pub(super) fn map(&self, f: &mut impl FnMut(ExprId) -> ExprId) -> Self {
        match self {
            Self::Scalar(e) => Self::Scalar(f(*e)),
            Self::Vector(rows) => Self::Vector(rows.iter().map(|row| row.map(f)).collect()),
            Self::Zero => Self::Zero,
        }
    }

    /// The same where another value has its shape, an empty sum in that shape.
    pub(super) fn shaped(&self, like: &Self) -> Option<Self> {
        like.zip(self, &mut |_, own| own)
    }

    fn zip(&self, other: &Self, f: &mut impl FnMut(ExprId, ExprId) -> ExprId) -> Option<Self> {
        match (self, other) {
            (Self::Scalar(a), Self::Scalar(b)) => Some(Self::Scalar(f(*a, *b))),
            (Self::Vector(a), Self::Vector(b)) if a.len() == b.len() => {
                a.iter().zip(b).map(|(a, b)| a.zip(b, f)).collect::<Option<Vec<_>>>().map(Self::Vector)
            }
            (Self::Zero, other) => Some(other.map(&mut |b| f(ZERO, b))),
            (own, Self::Zero) => Some(own.map(&mut |a| f(a, ZERO))),
            (Self::Scalar(_) | Self::Vector(_), Self::Scalar(_) | Self::Vector(_)) => None,
        }
    }
}

/// Parts of one value: an empty sum among them has the shape of the others.
pub(super) fn filled(mut parts: Vec<Value>) -> Vec<Value> {
    if parts.contains(&Value::Zero)
        && let Some(shape) = parts.iter().find(|part| **part != Value::Zero)
    {
        let zeros = shape.map(&mut |_| ZERO);
        parts.iter_mut().filter(|part| **part == Value::Zero).for_each(|part| part.clone_from(&zeros));
    }
    parts
}

/// The sum of values of one shape, each with its sign.
pub(super) fn sum(pool: &mut Pool, terms: &[(bool, Value)]) -> Result<Value, Misfit> {
    let shaped = || terms.iter().filter(|(_, value)| *value != Value::Zero);
    let scalars = shaped().map(|(negative, value)| match value {
        Value::Scalar(e) => Some((*e, if *negative { Number::MINUS_ONE } else { Number::ONE })),
        Value::Vector(_) | Value::Zero => None,
    });
    if let Some(linear) = scalars.collect::<Option<Vec<_>>>() {
        return Ok(if linear.is_empty() { Value::Zero } else { Value::Scalar(pool.linear(&linear)) });
    }
    let mut total: Option<Value> = None;
    for (negative, value) in shaped() {
        let mut add = |a, b| if *negative { pool.sub(a, b) } else { pool.add(a, b) };
        total = Some(match total {
            None if *negative => value.map(&mut |e| pool.neg(e)),
            None => value.clone(),
            Some(total) => total.zip(value, &mut add).ok_or_else(|| {
                let what = if *negative { "subtracted from" } else { "added to" };
                (format!("{} can't be {what} {}", value.describe(), total.describe()), None)
            })?,
        });
    }
    Ok(total.unwrap_or(Value::Zero))
}

/// The product of factors, some of them divisors.
pub(super) fn product(pool: &mut Pool, factors: &[(bool, Value)]) -> Result<Value, Misfit> {
    // Scalars are collected so that the canonical form sees them together.
    let mut scalars = Vec::new();
    let mut tensor: Option<Value> = None;
    for (divided, value) in factors {
        match (value, &tensor) {
            (Value::Scalar(e), _) => scalars.push(if *divided { pool.div(pool.one(), *e) } else { *e }),
            (Value::Zero, _) if *divided => scalars.push(pool.div(pool.one(), ZERO)),
            (Value::Vector(_), _) if *divided => return Err((format!("can't divide by {}", value.describe()), None)),
            (Value::Vector(_) | Value::Zero, None) => tensor = Some(value.clone()),
            (Value::Vector(_) | Value::Zero, Some(left)) => {
                let result = matrix_product(pool, left, value)?;
                if let Value::Scalar(e) = result {
                    scalars.push(e);
                    tensor = None;
                } else {
                    tensor = Some(result);
                }
            }
        }
    }
    let scale = pool.product(&scalars);
    Ok(match tensor {
        None => Value::Scalar(scale),
        Some(_) if pool.is_undefined(scale) => Value::Scalar(scale),
        Some(value) if scalars.is_empty() => value,
        Some(value) => value.map(&mut |e| pool.mul(scale, e)),
    })
}

fn matrix_product(pool: &mut Pool, left: &Value, right: &Value) -> Result<Value, Misfit> {
    if [left, right].contains(&&Value::Zero) {
        return Ok(Value::Zero);
    }
    let misfit = || {
        let vectors = left.matrix("").is_err() && right.matrix("").is_err();
        let help = vectors.then(|| "write `dot(u, v)` or `cross(u, v)`".to_owned());
        (format!("can't multiply {} by {}", left.describe(), right.describe()), help)
    };
    let a = left.matrix("").map_err(|_| misfit())?;
    let width = a.first().map_or(0, Vec::len);
    if let Ok(b) = right.components("") {
        if b.len() != width {
            return Err(misfit());
        }
        let parts = a.iter().map(|row| pool.dot(row, &b)).collect();
        return Ok(Value::from_components(parts));
    }
    let b = right.matrix("").map_err(|_| misfit())?;
    if b.len() != width {
        return Err(misfit());
    }
    let columns = transposed(&b);
    let rows = a.iter().map(|row| columns.iter().map(|column| pool.dot(row, column)).collect()).collect();
    Ok(Value::from_rows(rows))
}

pub(crate) fn transposed(rows: &[Vec<ExprId>]) -> Vec<Vec<ExprId>> {
    let width = rows.first().map_or(0, Vec::len);
    (0..width).map(|j| rows.iter().map(|row| row[j]).collect()).collect()
}

pub(super) fn dot(pool: &mut Pool, u: &Value, v: &Value) -> Result<Value, Misfit> {
    let a = u.components("the first argument of `dot`")?;
    let b = v.components("the second argument of `dot`")?;
    if a.len() != b.len() && ![u, v].contains(&&Value::Zero) {
        return Err((format!("can't multiply {} by {}", u.describe(), v.describe()), None));
    }
    Ok(Value::Scalar(pool.dot(&a, &b)))
}

pub(super) fn norm(pool: &mut Pool, v: &Value) -> Result<Value, Misfit> {
    let a = v.components("the argument of `norm`")?;
    let square = pool.dot(&a, &a);
    Ok(Value::Scalar(pool.sqrt(square)))
}

pub(super) fn three(value: &Value, what: &str) -> Result<[ExprId; 3], Misfit> {
    if *value == Value::Zero {
        return Ok([ZERO; 3]);
    }
    let parts = value.components(what)?;
    <[ExprId; 3]>::try_from(parts)
        .map_err(|_| (format!("{what} must be a vector of 3, but is {}", value.describe()), None))
}

pub(super) fn cross(pool: &mut Pool, u: &Value, v: &Value) -> Result<Value, Misfit> {
    let a = three(u, "the first argument of `cross`")?;
    let b = three(v, "the second argument of `cross`")?;
    let parts = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
        let plus = pool.mul(a[i], b[j]);
        let minus = pool.mul(a[j], b[i]);
        pool.sub(plus, minus)
    });
    Ok(Value::from_components(parts.to_vec()))
}
