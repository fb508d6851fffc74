//! The functions of the language and what they do with values.

use super::ModelError;
use super::values::{Misfit, Value, cross, dot, norm, product, sum, three, transposed};
use crate::expr::{ExprId, Pool, ZeroVerdict, function_from_name, ratio};
use crate::precision::Function;
use crate::span::Span;
use crate::syntax::{FUNCTIONS, Name, signature};

/// Longer arguments are not quoted in messages.
const LONGEST_ARGUMENT: usize = 40;

/// A function of the language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Builtin {
    Elementary(Function),
    Sqrt,
    Atan2,
    Norm,
    Dot,
    Cross,
    Transpose,
    /// Rotation matrix about axis 0, 1 or 2.
    Rotation(usize),
    AngularVelocity,
    Inertia(Body),
    Steiner,
    About,
}

/// The bodies whose tensors of inertia are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Body {
    Sphere,
    Shell,
    Cylinder,
    Rod,
    Cuboid,
    Point,
}

/// What is no elementary function.
const BUILTINS: [(&str, Builtin); 18] = [
    ("sqrt", Builtin::Sqrt),
    ("atan2", Builtin::Atan2),
    ("norm", Builtin::Norm),
    ("dot", Builtin::Dot),
    ("cross", Builtin::Cross),
    ("transpose", Builtin::Transpose),
    ("rot_x", Builtin::Rotation(0)),
    ("rot_y", Builtin::Rotation(1)),
    ("rot_z", Builtin::Rotation(2)),
    ("angular_velocity", Builtin::AngularVelocity),
    ("inertia_sphere", Builtin::Inertia(Body::Sphere)),
    ("inertia_shell", Builtin::Inertia(Body::Shell)),
    ("inertia_cylinder", Builtin::Inertia(Body::Cylinder)),
    ("inertia_rod", Builtin::Inertia(Body::Rod)),
    ("inertia_box", Builtin::Inertia(Body::Cuboid)),
    ("inertia_point", Builtin::Inertia(Body::Point)),
    ("steiner", Builtin::Steiner),
    ("about", Builtin::About),
];

impl Builtin {
    pub(super) fn from_name(name: &str) -> Option<Self> {
        let own = BUILTINS.iter().find(|(own, _)| *own == name).map(|(_, builtin)| *builtin);
        own.or_else(|| function_from_name(name).map(Self::Elementary))
    }

    fn name(self) -> &'static str {
        let own = |name: &&'static str| Self::from_name(name) == Some(self);
        FUNCTIONS.iter().copied().find(own).unwrap_or("this")
    }

    /// The mistake of a call outside of where it is defined.
    pub(super) fn undefined(self, pool: &Pool, arguments: &[Value], span: Span) -> ModelError {
        let text = |value: &Value| {
            let text = value.scalar("").map_or(String::new(), |e| pool.display(e));
            let quoted = (1..=LONGEST_ARGUMENT).contains(&text.chars().count());
            if quoted { text } else { "…".to_owned() }
        };
        let arguments: Vec<String> = arguments.iter().map(text).collect();
        self.undefined_for(&arguments.join(", "), span)
    }

    /// The same, for arguments in words.
    pub(super) fn undefined_for(self, arguments: &str, span: Span) -> ModelError {
        ModelError::Undefined { what: format!("`{}({arguments})`", self.name()), span, help: self.domain() }
    }

    /// Where it is defined, if not everywhere.
    fn domain(self) -> Option<&'static str> {
        match self {
            Self::Elementary(Function::Asin | Function::Acos) => Some("the argument has to lie between -1 and 1"),
            Self::Elementary(Function::Ln) => Some("the argument has to be positive"),
            Self::Elementary(Function::Tan) => Some("there is no tangent of a right angle"),
            Self::Sqrt => Some("the argument can't be negative"),
            Self::Atan2 => Some("the origin has no angle: one of the arguments has to differ from 0"),
            _ => None,
        }
    }

    /// Applies the function; an angular velocity needs the rate of its argument.
    pub(super) fn apply(self, pool: &mut Pool, arguments: &[Value], rate: Option<Value>) -> Result<Value, Misfit> {
        let scalar = |at: usize| match arguments.get(at) {
            Some(value) => value.scalar(if arguments.len() == 1 {
                "the argument"
            } else {
                ["the first argument", "the second argument", "the third argument"]
                    .get(at)
                    .unwrap_or(&"the last argument")
            }),
            None => Err(("an argument is missing".to_owned(), None)),
        };
        let vector = Value::Vector(Vec::new());
        let value = |at: usize| arguments.get(at).unwrap_or(&vector);
        match self {
            Self::Elementary(function) => {
                if matches!((function, value(0)), (Function::Abs, Value::Vector(_))) {
                    let help = "the length of a vector is `norm(v)`".to_owned();
                    return Err((format!("`abs` takes a number, not {}", value(0).describe()), Some(help)));
                }
                Ok(Value::Scalar(pool.apply(function, scalar(0)?)))
            }
            Self::Sqrt => Ok(Value::Scalar(pool.sqrt(scalar(0)?))),
            Self::Atan2 => Ok(Value::Scalar(pool.atan2(scalar(0)?, scalar(1)?))),
            Self::Norm => norm(pool, value(0)),
            Self::Dot => dot(pool, value(0), value(1)),
            Self::Cross => cross(pool, value(0), value(1)),
            Self::Transpose if *value(0) == Value::Zero => Ok(Value::Zero),
            Self::Transpose => {
                let rows = value(0).matrix("the argument of `transpose`")?;
                Ok(Value::from_rows(transposed(&rows)))
            }
            Self::Rotation(axis) => Ok(rotation(pool, axis, scalar(0)?)),
            Self::AngularVelocity => {
                // The skew matrix of the body-frame angular velocity is Rᵀ dR/dt (Goldstein, sec. 4.9).
                let r = value(0);
                let rows = r.matrix("the argument of `angular_velocity`")?;
                if rows.len() != 3 || rows[0].len() != 3 {
                    return Err((format!("a rotation matrix is 3 x 3, this is {}", r.describe()), None));
                }
                if !is_rotation(pool, &rows) {
                    let help =
                        "`rot_x`, `rot_y`, `rot_z` and products of them are; roots are written as such, `sqrt(1/2)`";
                    let what = "`angular_velocity` needs a rotation matrix: transpose(R)*R is not 1 here";
                    return Err((what.to_owned(), Some(help.to_owned())));
                }
                let rates = rate.unwrap_or(Value::Zero).matrix("the rate")?;
                let elements = [(2, 1), (0, 2), (1, 0)].map(|(i, j)| {
                    let terms: Vec<ExprId> = (0..3).map(|k| pool.mul(rows[k][i], rates[k][j])).collect();
                    pool.sum(&terms)
                });
                Ok(Value::from_components(elements.to_vec()))
            }
            Self::Inertia(Body::Point) => {
                Ok(point_tensor(pool, scalar(0)?, three(value(1), "the place of the point")?))
            }
            Self::Inertia(body) => {
                let lengths = (0..arguments.len()).map(scalar).collect::<Result<Vec<_>, _>>()?;
                Ok(body_tensor(pool, body, &lengths))
            }
            Self::Steiner => {
                let moved = point_tensor(pool, scalar(1)?, three(value(2), "the displacement")?);
                sum(pool, &[(false, value(0).clone()), (false, moved)])
            }
            Self::About => {
                let axis = value(1).clone();
                let product = product(pool, &[(false, value(0).clone()), (false, axis.clone())])?;
                let moment = dot(pool, &axis, &product)?.scalar("the moment")?;
                let square = dot(pool, &axis, &axis)?.scalar("the square of the axis")?;
                let is_unit = pool.agree(square, pool.one());
                Ok(Value::Scalar(if is_unit { moment } else { pool.div(moment, square) }))
            }
        }
    }
}

/// The mistake of a call with a wrong number of arguments.
pub(super) fn check_count(name: &Name, found: usize, span: Span) -> Option<ModelError> {
    let expected = signature(&name.text).map_or(1, |(call, _)| 1 + call.matches(',').count());
    let words = match expected {
        1 => "one argument".to_owned(),
        2 => "two arguments".to_owned(),
        3 => "three arguments".to_owned(),
        4 => "four arguments".to_owned(),
        n => format!("{n} arguments"),
    };
    let function = name.text.to_string();
    (expected != found).then_some(ModelError::ArgumentCount { function, expected: words, found, span })
}

fn rotation(pool: &mut Pool, axis: usize, angle: ExprId) -> Value {
    let (zero, one) = (pool.zero(), pool.one());
    let c = pool.apply(Function::Cos, angle);
    let s = pool.apply(Function::Sin, angle);
    let minus_s = pool.neg(s);
    let mut rows = vec![vec![zero; 3]; 3];
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    rows[axis][axis] = one;
    rows[i][i] = c;
    rows[i][j] = minus_s;
    rows[j][i] = s;
    rows[j][j] = c;
    Value::from_rows(rows)
}

/// m (r² 1 - r rᵀ).
fn point_tensor(pool: &mut Pool, mass: ExprId, r: [ExprId; 3]) -> Value {
    let squares = r.map(|x| pool.mul(x, x));
    let mut element = |i: usize, j: usize| {
        let element = if i == j {
            pool.add(squares[(i + 1) % 3], squares[(i + 2) % 3])
        } else {
            let product = pool.mul(r[i], r[j]);
            pool.neg(product)
        };
        pool.mul(mass, element)
    };
    Value::from_rows((0..3).map(|i| (0..3).map(|j| element(i, j)).collect()).collect())
}

/// Principal tensors about the centre of mass (Landau & Lifshitz, Mechanics, sec. 32).
fn body_tensor(pool: &mut Pool, body: Body, arguments: &[ExprId]) -> Value {
    let get = |at: usize| arguments.get(at).copied();
    let zero = pool.zero();
    let mass = get(0).unwrap_or(zero);
    let term = |pool: &mut Pool, numerator: i64, denominator: i64, length: Option<ExprId>| {
        let length = length.unwrap_or(zero);
        let square = pool.mul(length, length);
        let inertia = pool.mul(mass, square);
        pool.scale(inertia, &ratio(numerator, denominator))
    };
    let diagonal = match body {
        Body::Sphere => [term(pool, 2, 5, get(1)); 3],
        Body::Shell => [term(pool, 2, 3, get(1)); 3],
        Body::Rod => {
            let across = term(pool, 1, 12, get(1));
            [across, across, zero]
        }
        Body::Cylinder => {
            let (r, h) = (term(pool, 1, 4, get(1)), term(pool, 1, 12, get(2)));
            let along = term(pool, 1, 2, get(1));
            let across = pool.add(r, h);
            [across, across, along]
        }
        Body::Cuboid => {
            let [a, b, c] = [1, 2, 3].map(|at| term(pool, 1, 12, get(at)));
            [pool.add(b, c), pool.add(a, c), pool.add(a, b)]
        }
        Body::Point => [zero; 3],
    };
    let entry = |i: usize, j: usize| if i == j { diagonal[i] } else { zero };
    Value::from_rows((0..3).map(|i| (0..3).map(|j| entry(i, j)).collect()).collect())
}

/// Whether RᵀR may be 1.
fn is_rotation(pool: &mut Pool, rows: &[Vec<ExprId>]) -> bool {
    (0..3).flat_map(|i| (0..=i).map(move |j| (i, j))).all(|(i, j)| {
        let mut terms: Vec<ExprId> = rows.iter().map(|row| pool.mul(row[i], row[j])).collect();
        terms.extend((i == j).then(|| pool.integer(-1)));
        let rest = pool.sum(&terms);
        pool.is_zero(rest) != ZeroVerdict::NonZero
    })
}
