//! Mass, centre of mass, and principal moments and axes of inertia.
//!
//! Beside the way from a text to modes: the tensors that a model names ([`of_model`]), a body made of points ([`of_points`]), and a solid
//! between triangles ([`Mesh`]). All three come as exact constants, expressions or fractions, and go the same way:
//! the certified eigenvalues of [`librate_core::modes`] with M = 1. No number of a file is rounded before that.
//!
//! ```
//! use librate::inertia;
//! // A dumbbell along z, and a light point beside it.
//! let body = inertia::of_points("m,x,y,z\n1,0,0,1\n1,0,0,-1\n0.1,0.5,0,0\n", 10)?;
//! assert_eq!(body.mass.decimal(10).text, "2.100000000");
//! let largest = &body.principal.moments[2];
//! assert_eq!(largest.axis, [0.0, 1.0, 0.0]);
//! # Ok::<(), inertia::InertiaError>(())
//! ```
//!
//! It reads no file and knows no mechanics beyond this; whether the body can move freely, or how, is not its matter.

mod body;
mod error;
mod mesh;
mod points;
mod principal;
mod stl;
mod warning;

pub use body::{Amount, Body, Made};
pub use error::InertiaError;
pub use mesh::{Edge, Mesh};
pub use principal::{Equal, Impossible, Moment, Principal};
pub use warning::{Warning, warnings};

use librate_core::diagnostic::Diagnostic;
use librate_core::expr::{Pool, Substitution, Symbol};
use librate_core::linearize;
use librate_core::model::{self, Constant, Model, Tensor};
use librate_core::precision::Big;
use librate_core::span::Span;
use principal::{Exact, bigs};

/// The SI unit of a moment of inertia, as the language writes it.
const UNIT: &str = "kg*m^2";

/// A tensor that a model names, and its principal moments.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct NamedTensor {
    /// `I`, `I[2]`.
    pub name: String,
    /// Where it stands.
    pub span: Span,
    /// The SI unit of its entries, where the file has units and they tell.
    pub unit: Option<String>,
    /// Where it is used as omega . I . omega with an angular velocity, if anywhere.
    pub rotational: Option<Span>,
    /// Its entries, by row.
    pub entries: [[Big; 3]; 3],
    /// Its principal moments and axes.
    pub principal: Principal,
}

impl NamedTensor {
    /// That no body has such a tensor, if so.
    #[must_use]
    pub fn warning(&self) -> Option<Diagnostic> {
        Warning::of(self).as_ref().map(Diagnostic::from)
    }
}

impl Amount {
    /// A mass per volume, from an exact constant expression.
    ///
    /// # Errors
    /// [`InertiaError::BadAmount`] where it is none, or not positive.
    pub fn density(text: &str) -> Result<Self, InertiaError> {
        positive(text, "density").map(Self::Density)
    }

    /// A mass, likewise.
    ///
    /// # Errors
    /// [`InertiaError::BadAmount`] where it is none, or not positive.
    pub fn mass(text: &str) -> Result<Self, InertiaError> {
        positive(text, "mass").map(Self::Mass)
    }
}

fn positive(text: &str, what: &'static str) -> Result<Constant, InertiaError> {
    let constant = Constant::parse(text).ok();
    let fits = |constant: &Constant| {
        let value = linearize::constant(constant.pool(), constant.value());
        value.is_some_and(|value| value.is_finite() && value.is_positive())
    };
    constant.filter(fits).ok_or_else(|| InertiaError::BadAmount { what, text: text.to_owned() })
}

/// The body of a table of points: CSV text with a header that has the columns `m` (or `mass`), `x`, `y` and `z`, among
/// others. Principal moments have so many correctly rounded digits.
///
/// # Errors
/// [`InertiaError`] where the table can't be read, a column is missing, a field is no number, or a mass is negative.
pub fn of_points(text: &str, digits: usize) -> Result<Body, InertiaError> {
    points::read(text)?.body(digits)
}

/// The constant symmetric matrices of 3 x 3 among the named expressions of a model, with so many correctly rounded
/// digits of their principal moments; members of families where the settings of the model ask for [`model::Settings::only_tensors`].
///
/// # Errors
/// All of them: [`InertiaError::NoTensor`], [`InertiaError::MissingValue`], [`InertiaError::NotANumberEntry`].
///
/// ```
/// use librate::{inertia, model, syntax};
/// let text = "param m = 12  let I = rot_z(pi/6)*inertia_box(m, 1, 2, 3)*transpose(rot_z(pi/6))";
/// let file = syntax::parse(text)?;
/// let settings = model::Settings::new().only_tensors();
/// let model = model::elaborate(&file, &Default::default(), &settings)?;
/// let tensors = inertia::of_model(&model, 10).unwrap();
/// let moments = tensors[0].principal.moments.iter();
/// let moments: Vec<f64> = moments.map(|moment| moment.value.mid_f64()).collect();
/// assert_eq!(moments, [5.0, 10.0, 13.0]);
/// # Ok::<(), librate::Error>(())
/// ```
pub fn of_model(model: &Model, digits: usize) -> Result<Vec<NamedTensor>, Vec<InertiaError>> {
    let values = linearize::known_values(model);
    let mut pool = model.pool.clone();
    let mut found = Vec::new();
    let mut errors = Vec::new();
    let mut nearest = None;
    for tensor in &model.tensors {
        match of_tensor(model, &mut pool, &values, tensor, digits) {
            Ok(Ok(named)) => found.push(named),
            Err(error) => errors.push(error),
            Ok(Err(why)) => {
                nearest.get_or_insert((tensor.name.clone(), tensor.span, why));
            }
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    if found.is_empty() { Err(vec![InertiaError::NoTensor { nearest }]) } else { Ok(found) }
}

/// The moments of a tensor; where it is not a constant one, within, why not.
fn of_tensor(
    model: &Model,
    pool: &mut Pool,
    values: &Substitution,
    tensor: &Tensor,
    digits: usize,
) -> Result<Result<NamedTensor, String>, InertiaError> {
    if let Some(on) = &tensor.varies_with {
        return Ok(Err(format!("depends on `{on}`")));
    }
    let symbolic = tensor.entries;
    let closed = pool.substitute(symbolic.as_flattened(), values);
    let closed = square(|i, j| closed[3 * i + j]);
    let symmetric = |pool: &mut Pool, (i, j): (usize, usize)| {
        [symbolic, closed].iter().any(|entries| pool.agree(entries[i][j], entries[j][i]))
    };
    let pairs = [(0, 1), (0, 2), (1, 2)];
    if let Some((i, j)) = pairs.into_iter().find(|pair| !symmetric(pool, *pair)) {
        let (i, j) = (i + 1, j + 1);
        return Ok(Err(format!("not symmetric: entries ({i}, {j}) and ({j}, {i}) differ")));
    }
    let valueless = pool.symbols_of(closed.as_flattened());
    if let Some(parameter) = valueless.iter().find_map(|symbol| parameter(model, *symbol)) {
        return Err(InertiaError::MissingValue {
            tensor: tensor.name.clone(),
            span: tensor.span,
            parameter: parameter.name.clone(),
            declared: parameter.span,
        });
    }
    let entries = bigs(pool, closed.as_flattened(), body::bits_for(digits));
    let mut exact = Exact { pool, symbolic, closed };
    let (name, span) = (&tensor.name, tensor.span);
    let principal = exact.principal(digits, |row, column| InertiaError::NotANumberEntry {
        tensor: name.clone(),
        span,
        row: row + 1,
        column: column + 1,
    })?;
    let entry = |at: usize| entries[at].clone();
    Ok(Ok(NamedTensor {
        name: tensor.name.clone(),
        span: tensor.span,
        unit: tensor.unit.clone(),
        rotational: tensor.rotational,
        entries: square(|i, j| entry(3 * i + j)),
        principal,
    }))
}

/// The nine entries of a tensor, row by row.
fn square<T>(mut entry: impl FnMut(usize, usize) -> T) -> [[T; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)))
}

fn parameter(model: &Model, symbol: Symbol) -> Option<&model::Parameter> {
    model.parameters.get(model.symbols.parameter(symbol)?)
}
