//! How frequencies change with parameters: d omega / d parameter, to first order.
//!
//! For P(lambda) = lambda² M + lambda D + S with P x = 0 and yᴴP = 0 the exponent moves by
//! dlambda = -yᴴ(lambda² dM + lambda dD + dS)x / yᴴ(2 lambda M + D)x (Lancaster, Numer. Math. 6 (1964) 377); for M and K
//! alone that is d(omega²) = xᵀ(dK - omega² dM)x with y = x. Exponents that are equal move by the eigenvalues of the same forms
//! on the space of their vectors. Under constraints the matrices have the multipliers for further rows, so that nothing has to be said
//! of how tangent spaces turn.
//!
//! Derivatives of matrices are enclosed ([`crate::precision::Dual`]), and so are shapes: where one shape alone decides,
//! the derivative is.

use nalgebra::{Complex, DMatrix, DVector, SymmetricEigen};

use crate::linearize::{Linearized, Slopes, Structure, WithMultipliers, constant};
use crate::modes::Kind;
use crate::oscillation::{NormalMode, NormalModes};
use crate::precision::Ball;

type C = Complex<f64>;

/// First derivatives of the exponents of all modes by all parameters.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Sensitivities {
    /// Numbers of the parameters, as they stand in the model.
    pub parameters: Vec<usize>,
    /// By mode and parameter: d omega; `None` where there is no derivative. For a mode of M and K that no other
    /// coincides with, the radius is a bound; otherwise an estimate of what rounding leaves.
    pub omega: Vec<Vec<Option<Ball>>>,
    /// By mode and parameter: d growth, likewise.
    pub growth: Vec<Vec<Option<Ball>>>,
}

impl Sensitivities {
    /// The standard uncertainty of omega of each mode, from those of the parameters that are stated, taken as independent and
    /// small; `None` without any, or where a derivative that counts is missing.
    #[must_use]
    pub fn omega_sigma(&self, linearized: &Linearized) -> Option<Vec<Option<f64>>> {
        let model = linearized.model();
        let stated = |parameter: &usize| {
            let uncertainty = model.parameters.get(*parameter)?.uncertainty?;
            Some(constant(&model.pool, uncertainty)?.mid_f64())
        };
        let sigmas: Vec<Option<f64>> = self.parameters.iter().map(stated).collect();
        if sigmas.iter().all(Option::is_none) {
            return None;
        }
        let of = |derivatives: &Vec<Option<Ball>>| {
            let mut total = 0.0_f64;
            for (derivative, sigma) in derivatives.iter().zip(&sigmas) {
                if let Some(sigma) = sigma {
                    total = total.hypot(derivative.as_ref()?.mid_f64() * sigma);
                }
            }
            Some(total)
        };
        Some(self.omega.iter().map(of).collect())
    }
}

/// Whether a model states the uncertainty of a parameter.
#[must_use]
pub fn has_uncertainties(linearized: &Linearized) -> bool {
    let parameters = linearized.model().parameters.iter();
    parameters
        .clone()
        .any(|parameter| parameter.uncertainty.is_some())
}

/// The derivatives for all parameters that have a value, are not defined from others and set no range; `modes` with their
/// shapes.
#[must_use]
pub fn sensitivities(linearized: &Linearized, modes: &NormalModes) -> Sensitivities {
    let parameters: Vec<usize> = (0..linearized.model().parameters.len())
        .filter(|parameter| linearized.can_vary(*parameter))
        .collect();
    let whole = Whole::new(&linearized.with_multipliers());
    let groups = groups(modes);
    let count = modes.modes.len();
    let spaces: Vec<Option<Space>> = groups
        .iter()
        .map(|group| whole.space(linearized, &modes.modes, group))
        .collect();
    let mut omega = vec![vec![None; parameters.len()]; count];
    let mut growth = vec![vec![None; parameters.len()]; count];
    for (at, parameter) in parameters.iter().enumerate() {
        let Some(slopes) = linearized.slopes(*parameter) else {
            continue;
        };
        let model = linearized.model();
        let value = model.parameters[*parameter].value;
        let value = value.and_then(|value| constant(&model.pool, value));
        let value = value.map_or(0.0, |value| value.mid_f64());
        let changes = Changes::new(&slopes, whole.order, value);
        for (group, space) in groups.iter().zip(&spaces) {
            let Some(space) = space else { continue };
            if let ([mode], Space::Real { .. }, false) =
                (group.as_slice(), space, linearized.is_constrained())
                && let Some((own, other)) = enclosed(&modes.modes[*mode], &slopes)
            {
                omega[*mode][at] = Some(own);
                growth[*mode][at] = Some(other);
                continue;
            }
            let Some(moved) = space.moved(&changes) else {
                continue;
            };
            let noise = NOISE * space.size(&changes);
            let ball = |value: f64| {
                let finite = value.is_finite() && noise.is_finite();
                finite.then(|| Ball::from(value).with_added_radius(noise))
            };
            for (mode, moved) in group.iter().zip(moved) {
                omega[*mode][at] = ball(moved.im);
                growth[*mode][at] = ball(moved.re);
            }
        }
    }
    Sensitivities {
        parameters,
        omega,
        growth,
    }
}

/// What rounding leaves of forms in doubles, beside the size of their terms: an estimate.
const NOISE: f64 = 1e-13;

/// d omega and d growth of a single real mode, enclosed: d(ω²) = xᵀ(dK - ω² dM)x.
fn enclosed(mode: &NormalMode, slopes: &Slopes) -> Option<(Ball, Ball)> {
    let n = mode.vector.len();
    let square = mode.omega_squared?;
    let x: Vec<Ball> = mode
        .vector
        .iter()
        .map(|x| Ball::from(*x).with_added_radius(mode.vector_error_bound))
        .collect();
    let mut change = Ball::ZERO;
    for j in 0..n {
        for i in 0..n {
            let (k, m) = (slopes.stiffness[i + n * j], slopes.mass[i + n * j]);
            if k.is_zero() && m.is_zero() {
                continue;
            }
            change = change + x[i] * (k - square * m) * x[j];
        }
    }
    // d(ω²) = 2 ω dω, and for growth s with ω² = -s²: ds = -d(ω²)/(2 s).
    let found = match mode.kind {
        Kind::Oscillation => (change / mode.omega.scale(1), Ball::ZERO),
        Kind::Unstable => (Ball::ZERO, -change / mode.growth.scale(1)),
        _ => return None,
    };
    (found.0.is_finite() && found.1.is_finite()).then_some(found)
}

/// Modes that are equal within their bounds.
fn groups(modes: &NormalModes) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (at, mode) in modes.modes.iter().enumerate() {
        let meets = |other: &usize| {
            let other = &modes.modes[*other];
            other.cluster == mode.cluster
                && (other.kind == Kind::Zero) == (mode.kind == Kind::Zero)
                && (other.omega - mode.omega).contains_zero()
                && (other.growth - mode.growth).contains_zero()
        };
        match groups.last_mut() {
            Some(group) if group.last().is_some_and(meets) => group.push(at),
            Some(_) | None => groups.push(vec![at]),
        }
    }
    groups
}

/// The matrices in doubles.
struct Whole {
    order: usize,
    mass: DMatrix<f64>,
    velocity: Option<DMatrix<f64>>,
    stiffness: DMatrix<f64>,
}

fn doubles(order: usize, matrix: &[Ball]) -> DMatrix<f64> {
    DMatrix::from_iterator(order, order, matrix.iter().map(Ball::mid_f64))
}

struct Changes {
    /// The value of the parameter.
    parameter: f64,
    mass: DMatrix<f64>,
    velocity: Option<DMatrix<f64>>,
    stiffness: DMatrix<f64>,
}

impl Changes {
    fn new(slopes: &Slopes, order: usize, parameter: f64) -> Self {
        Self {
            parameter,
            mass: doubles(order, &slopes.mass),
            velocity: slopes.velocity.as_ref().map(|own| doubles(order, own)),
            stiffness: doubles(order, &slopes.stiffness),
        }
    }
}

/// Vectors of equal exponents.
enum Space {
    /// Proved zeros, with their vectors where there is no G, C or N, and the size of the terms of xᵀSx.
    Zero(usize, Option<DMatrix<f64>>, f64),
    /// Real modes of M and K: ω², and vectors with xᵀMx = 1.
    Real { square: f64, vectors: DMatrix<f64> },
    /// An exponent, its vectors, left vectors, and the inverse of yᴴ(2λM + D)x.
    Complex {
        exponent: C,
        vectors: DMatrix<C>,
        left: DMatrix<C>,
        inverse: DMatrix<C>,
    },
}

impl Whole {
    fn new(own: &WithMultipliers) -> Self {
        Self {
            order: own.order,
            mass: doubles(own.order, &own.mass),
            velocity: own
                .velocity
                .as_ref()
                .map(|matrix| doubles(own.order, matrix)),
            stiffness: doubles(own.order, &own.stiffness),
        }
    }

    fn space(
        &self,
        linearized: &Linearized,
        modes: &[NormalMode],
        group: &[usize],
    ) -> Option<Space> {
        let first = &modes[*group.first()?];
        let zero = first.kind == Kind::Zero;
        let conservative = linearized.structure() == Structure::Conservative;
        if zero && !conservative {
            return Some(Space::Zero(group.len(), None, 0.0));
        }
        if conservative {
            let square = first.omega_squared?.mid_f64();
            let count = linearized.coordinates();
            let mut vectors = DMatrix::zeros(self.order, group.len());
            for (column, mode) in group.iter().enumerate() {
                let vector = &modes[*mode].vector;
                if vector.len() != count {
                    return None;
                }
                let x = DVector::from_fn(self.order, |i, _| vector.get(i).copied().unwrap_or(0.0));
                let x = if self.order == count {
                    x
                } else {
                    self.with_forces(x, square, count)?
                };
                vectors.set_column(column, &x);
            }
            return Some(if zero {
                let sizes = vectors
                    .abs()
                    .tr_mul(&(self.stiffness.abs() * vectors.abs()));
                Space::Zero(group.len(), Some(vectors), sizes.amax())
            } else {
                Space::Real { square, vectors }
            });
        }
        let exponent = C::new(first.growth.mid_f64(), first.omega.mid_f64());
        let whole = |matrix: &DMatrix<f64>| matrix.map(|x| C::new(x, 0.0));
        let mass = whole(&self.mass);
        let velocity = self.velocity.as_ref().map(whole);
        let mut polynomial = &mass * (exponent * exponent) + whole(&self.stiffness);
        let mut slope = &mass * (exponent * 2.0);
        if let Some(velocity) = velocity {
            polynomial += &velocity * exponent;
            slope += velocity;
        }
        // Rows and columns of like size, or small masses look like null vectors.
        let units: Vec<f64> = (0..self.order)
            .map(|i| {
                polynomial
                    .row(i)
                    .iter()
                    .map(|x| x.norm())
                    .fold(0.0, f64::max)
                    .sqrt()
            })
            .collect();
        if units.iter().any(|unit| *unit == 0.0 || !unit.is_finite()) {
            return None;
        }
        let scaled = DMatrix::from_fn(self.order, self.order, |i, j| {
            polynomial[(i, j)] / (units[i] * units[j])
        });
        let svd = scaled.svd(true, true);
        let (left, right) = (svd.u?, svd.v_t?);
        let mut order: Vec<usize> = (0..self.order).collect();
        order.sort_by(|a, b| svd.singular_values[*a].total_cmp(&svd.singular_values[*b]));
        let pick = |at: usize, k: usize| order[k.min(at)];
        let count = group.len();
        let vectors = DMatrix::from_fn(self.order, count, |i, k| {
            right[(pick(self.order - 1, k), i)].conj() / units[i]
        });
        let left = DMatrix::from_fn(self.order, count, |i, k| {
            left[(i, pick(self.order - 1, k))] / units[i]
        });
        let inverse = (left.adjoint() * slope * &vectors).try_inverse()?;
        Some(Space::Complex {
            exponent,
            vectors,
            left,
            inverse,
        })
    }

    /// (x, mu): the shape and the changes of the multipliers that go with it, S x + Rᵀ mu = ω² M x.
    fn with_forces(&self, x: DVector<f64>, square: f64, count: usize) -> Option<DVector<f64>> {
        let rest = &self.mass * &x * square - &self.stiffness * &x;
        let right = rest.rows(0, count).into_owned();
        let matrix = self
            .stiffness
            .view((0, count), (count, self.order - count))
            .into_owned();
        let found = matrix.svd(true, true).solve(&right, 0.0).ok()?;
        let mut all = x;
        all.rows_mut(count, self.order - count).copy_from(&found);
        Some(all)
    }
}

impl Space {
    /// The size of the terms that [`Space::moved`] adds up.
    fn size(&self, changes: &Changes) -> f64 {
        let largest = |vectors: &DMatrix<f64>, square: f64| {
            let sizes = &changes.stiffness.abs() + &changes.mass.abs() * square.abs();
            let form = vectors.abs().tr_mul(&(sizes * vectors.abs()));
            form.amax()
        };
        match self {
            Self::Zero(..) => 0.0,
            Self::Real { square, vectors } => {
                largest(vectors, *square) / (2.0 * square.abs().sqrt())
            }
            Self::Complex {
                exponent,
                vectors,
                left,
                inverse,
            } => {
                let size = exponent.norm();
                let mut sizes = &changes.stiffness.abs() + &changes.mass.abs() * (size * size);
                if let Some(velocity) = &changes.velocity {
                    sizes += velocity.abs() * size;
                }
                let modulus = |matrix: &DMatrix<C>| matrix.map(|x| x.norm());
                let form = modulus(left).tr_mul(&(sizes * modulus(vectors)));
                (modulus(inverse) * form).amax()
            }
        }
    }

    /// d growth + i d omega of each exponent.
    fn moved(&self, changes: &Changes) -> Option<Vec<C>> {
        match self {
            // Most motions that cost nothing do so whatever the parameters. Where one comes to cost something,
            // omega goes as the root of the parameter.
            Self::Zero(count, vectors, size) => {
                let stays = vectors.as_ref().is_none_or(|vectors| {
                    let moved = vectors.tr_mul(&(&changes.stiffness * vectors));
                    let sizes = vectors
                        .abs()
                        .tr_mul(&(changes.stiffness.abs() * vectors.abs()));
                    // What a change of the parameter by as much as it is leaves at rounding counts as nothing, too.
                    let floor = size / changes.parameter.abs();
                    moved.amax() <= 1e-9 * sizes.amax().max(floor)
                });
                stays.then(|| vec![C::new(0.0, 0.0); *count])
            }
            Self::Real { square, vectors } => {
                let change = &changes.stiffness - &changes.mass * *square;
                let form = vectors.tr_mul(&(change * vectors));
                let symmetric = (&form + form.transpose()) * 0.5;
                let mut moved: Vec<f64> = match symmetric.nrows() {
                    1 => vec![symmetric[(0, 0)]],
                    _ => SymmetricEigen::new(symmetric)
                        .eigenvalues
                        .iter()
                        .copied()
                        .collect(),
                };
                moved.sort_by(f64::total_cmp);
                // d(ω²) = 2 ω dω, and for growth s with ω² = -s²: ds = -d(ω²)/(2 s).
                let root = square.abs().sqrt();
                Some(
                    moved
                        .into_iter()
                        .map(|moved| {
                            if *square > 0.0 {
                                C::new(0.0, moved / (2.0 * root))
                            } else {
                                C::new(-moved / (2.0 * root), 0.0)
                            }
                        })
                        .collect(),
                )
            }
            Self::Complex {
                exponent,
                vectors,
                left,
                inverse,
            } => {
                let whole = |matrix: &DMatrix<f64>| matrix.map(|x| C::new(x, 0.0));
                let mut change =
                    whole(&changes.mass) * (exponent * exponent) + whole(&changes.stiffness);
                if let Some(velocity) = &changes.velocity {
                    change += whole(velocity) * *exponent;
                }
                let moved = -(inverse * (left.adjoint() * change * vectors));
                let own = match moved.nrows() {
                    1 => vec![moved[(0, 0)]],
                    _ => moved
                        .schur()
                        .unpack()
                        .1
                        .diagonal()
                        .iter()
                        .copied()
                        .collect(),
                };
                Some(own)
            }
        }
    }
}
