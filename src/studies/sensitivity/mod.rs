//! How frequencies change with parameters: d omega / d parameter, to first order, with bounds.
//!
//! For P(lambda) = lambda² M + lambda D + S with P x = 0 and yᴴP = 0 the exponent moves by
//! dlambda = -yᴴ(lambda² dM + lambda dD + dS)x / yᴴ(2 lambda M + D)x (Lancaster, Numer. Math. 6 (1964) 377); for M and K
//! alone that is d(omega²) = xᵀ(dK - omega² dM)x with y = x. Exponents that are equal move by the eigenvalues of the same forms
//! on the space of their vectors (`split`). Under constraints the matrices have the multipliers for further rows, so that nothing
//! has to be said of how tangent spaces turn.
//!
//! Everything is enclosed: derivatives of matrices ([`librate_core::precision::Dual`]), the motion of the equilibrium, and vectors,
//! which are those of the modes for M and K alone and solutions of a bordered system elsewhere (`bordered`). It never
//! takes a derivative for 0 because it is small.

mod bordered;
mod split;

use bordered::Place;
use librate_core::diagnostic::Diagnostic;
use librate_core::expr::{ExprId, Pool};
use librate_core::linearize::{
    LinearizeError, Linearized, Slopes, Structure, Units, WithMultipliers, ZeroMode, constant,
};
use librate_core::model::Model;
use librate_core::modes::{Kind, Options};
use librate_core::number::Number;
use librate_core::order::{Gather as _, Order};
use librate_core::oscillation::{NormalMode, NormalModes, Uncertainty, in_units, normal_modes};
use librate_core::precision::{Ball, Complex, Matrix};

type Enclosed = Complex<Ball>;

/// Vectors, one list each.
type Rows<T> = Vec<Vec<T>>;

/// A warning that the uncertainties of parameters are not carried on, where there are any: for results that take parameters at
/// their values.
#[must_use]
pub fn ignored(model: &Model) -> Option<Diagnostic> {
    let uncertain = model.parameters.iter().filter(|own| own.uncertainty.is_some());
    let count = uncertain.clone().count();
    let (name, span) = uncertain.map(|own| (&own.name, own.span)).next()?;
    let message = match count {
        1 => format!("the uncertainty of `{name}` is ignored here"),
        _ => format!("the uncertainties of `{name}` and {} more are ignored here", count - 1),
    };
    Some(
        Diagnostic::warning(message, span, "treated as exact")
            .with_help("digits and bounds refer to the values; `modes` and `sensitivity` propagate uncertainties"),
    )
}

/// First derivatives of the exponents of all modes by all parameters.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Sensitivities {
    /// Numbers of the parameters, as they stand in the model.
    pub parameters: Vec<usize>,
    /// By mode and parameter: d omega, enclosed; `None` where there is no derivative, or none is proved. Modes that bounds do not
    /// separate count as equal: theirs are the derivatives of the modes that equal ones split into, each beside its shape where
    /// the parameter does not mix these, else by rising value.
    pub omega: Vec<Vec<Option<Ball>>>,
    /// By mode and parameter: d growth, likewise.
    pub growth: Vec<Vec<Option<Ball>>>,
    /// Modes that bounds do not separate, and whether some parameter mixes their shapes.
    groups: Vec<(Vec<usize>, bool)>,
}

impl Sensitivities {
    /// The standard uncertainty of each mode, from those of the parameters that are stated, taken as independent and
    /// small; `None` without any. Where a derivative that counts is missing there is none either, nor where equal modes split into
    /// different ones by several parameters, each along vectors of its own.
    #[must_use]
    pub fn uncertainties(&self, linearized: &Linearized) -> Option<Vec<Uncertainty>> {
        let model = linearized.model();
        let stated = |parameter: &usize| constant(&model.pool, model.parameters.get(*parameter)?.uncertainty?);
        let sigmas: Vec<Option<Ball>> = self.parameters.iter().map(stated).collect();
        if sigmas.iter().all(Option::is_none) {
            return None;
        }
        let of = |derivatives: &[Option<Ball>]| {
            let mut squares = Ball::ZERO;
            for (derivative, sigma) in derivatives.iter().zip(&sigmas) {
                if let Some(sigma) = sigma {
                    squares = squares + ((*derivative)? * *sigma).powi(2);
                }
            }
            Some(squares.sqrt()).filter(Ball::is_finite)
        };
        let stated = |at: &usize| sigmas[*at].is_some_and(|sigma| !sigma.is_zero());
        let stated: Vec<usize> = (0..sigmas.len()).filter(stated).collect();
        let mut open = vec![false; self.omega.len()];
        for (group, is_mixed) in &self.groups {
            let differ = |all: &[Vec<Option<Ball>>], at: usize| {
                let known = group.iter().filter_map(|mode| all[*mode][at]);
                known.clone().any(|one| known.clone().any(|other| !(one - other).contains_zero()))
            };
            let splits = stated.iter().filter(|at| differ(&self.omega, **at) || differ(&self.growth, **at)).count();
            group.iter().for_each(|mode| open[*mode] = *is_mixed && splits > 1);
        }
        let each = self.omega.iter().zip(&self.growth).zip(open).map(|((omega, growth), open)| match open {
            true => Uncertainty::new(None, None),
            false => Uncertainty::new(of(omega), of(growth)),
        });
        Some(each.collect())
    }

    /// Puts the uncertainties into the modes.
    pub fn put_uncertainties(&self, linearized: &Linearized, modes: &mut NormalModes) {
        let own = self.uncertainties(linearized).into_iter().flatten();
        for (mode, own) in modes.modes.iter_mut().zip(own) {
            mode.uncertainty = Some(own);
        }
    }
}

/// Puts the uncertainties into modes of a model that states some of parameters, which were computed with `options`.
///
/// # Errors
/// Those of [`normal_modes`], where shapes have to be computed for this.
pub fn put_uncertainties(
    linearized: &Linearized,
    modes: &mut NormalModes,
    options: &Options,
) -> Result<(), LinearizeError> {
    if linearized.model().parameters.iter().all(|parameter| parameter.uncertainty.is_none()) {
        return Ok(());
    }
    let found = if options.vectors {
        sensitivities(linearized, modes)
    } else {
        let mut options = options.clone();
        options.vectors = true;
        sensitivities(linearized, &normal_modes(linearized, &options)?)
    };
    found.put_uncertainties(linearized, modes);
    Ok(())
}

/// The derivatives for all parameters that have a value, are not defined from others and set no range; `modes` with their
/// shapes.
#[must_use]
pub fn sensitivities(linearized: &Linearized, modes: &NormalModes) -> Sensitivities {
    let parameters: Vec<usize> =
        (0..linearized.model().parameters.len()).filter(|parameter| linearized.can_vary(*parameter)).collect();
    let modes = &*in_units(linearized, modes);
    let rate = linearized.units().map_or(0, Units::rate);
    let whole = linearized.varied();
    // Modes that bounds do not separate, zeros apart.
    let cluster = |mode: &NormalMode| (mode.kind != Kind::Zero).then_some(mode.cluster);
    let alike = modes.modes.iter().enumerate().map(|(at, mode)| (cluster(mode), at)).grouped();
    let mut groups: Vec<(Vec<usize>, bool)> = alike.into_iter().map(|(_, group)| (group, false)).collect();
    let spaces: Vec<Option<Space>> = groups.iter().map(|(group, _)| space(&whole, linearized, modes, group)).collect();
    let mut omega = vec![vec![None; parameters.len()]; modes.modes.len()];
    let mut growth = omega.clone();
    for (at, parameter) in parameters.iter().enumerate() {
        let Some(slopes) = linearized.slopes(*parameter) else { continue };
        for ((group, is_mixed), space) in groups.iter_mut().zip(&spaces) {
            let moved = space.as_ref().and_then(|space| space.moved(&slopes, is_mixed));
            for (mode, moved) in group.iter().zip(moved.into_iter().flatten()) {
                let [im, re] = [moved.im, moved.re].map(|own| own.scale_far(rate));
                omega[*mode][at] = Some(im).filter(Ball::is_finite);
                growth[*mode][at] = Some(re).filter(Ball::is_finite);
            }
        }
    }
    Sensitivities { parameters, omega, growth, groups }
}

/// Vectors of equal exponents, and what their derivatives need.
enum Space {
    /// Exponents that stay 0 whatever the values of the parameters are: so many; with their vectors where
    /// gyroscopic forces between these would leave fewer. `unheld`: forces of displacements never begin to act on these.
    Zero { count: usize, coupled: Option<Rows<Ball>>, unheld: bool },
    /// Modes of M and K: ω², vectors and XᵀMX, and whether the vectors are the shapes of the modes, one by one.
    Real { square: Ball, vectors: Rows<Ball>, gram: Matrix<Ball>, are_shapes: bool },
    /// An exponent, its vectors and left vectors, and Yᴴ(2λM + D)X.
    Complex { place: Place, x: Rows<Enclosed>, y: Rows<Enclosed>, slope: Matrix<Enclosed>, kept: Kept },
}

/// What an exponent keeps to, however parameters change.
enum Kept {
    /// The imaginary axis: without dissipation -λ̄ is an exponent with λ, and this one is alone.
    Imaginary,
    /// The real axis: λ̄ is one with λ.
    Real,
    Nothing,
}

fn real(re: Ball) -> Enclosed {
    Enclosed { re, im: Ball::ZERO }
}

fn hull(balls: impl Iterator<Item = Ball>) -> Option<Ball> {
    balls.reduce(|all, one| all.hull(&one))
}

/// Up to this order vectors are solved for again, to more digits.
const MOST_SOLVED_AGAIN: usize = 40;

fn space(whole: &WithMultipliers, linearized: &Linearized, modes: &NormalModes, group: &[usize]) -> Option<Space> {
    let structure = linearized.structure();
    let own = || group.iter().map(|at| &modes.modes[*at]);
    let first = own().next()?;
    let count = group.len();
    if first.kind == Kind::Zero {
        // Each family of equilibria that conditions on velocities leave has one, and each direction without a force.
        if let Some(vectors) = linearized.unheld() {
            let known = count <= linearized.rolled().len() + vectors.len();
            return known.then_some(Space::Zero { count, coupled: Some(vectors), unheld: true });
        }
        let zeros = linearized.zero_modes();
        if count > zeros.len() || !stay(linearized, &zeros) {
            return None;
        }
        // Without dissipation 0 has a multiplicity that is even, at least the dimension of the kernel, and never grows by
        // a change that is small: where it is as small as that, it stays.
        let half = structure != Structure::Damped && count > zeros.len().div_ceil(2);
        let vectors = || zeros.into_iter().map(|zero| zero.vector).collect();
        return Some(Space::Zero { count, coupled: half.then(vectors), unheld: false });
    }
    let exponent = Enclosed { re: hull(own().map(|mode| mode.growth))?, im: hull(own().map(|mode| mode.omega))? };
    if structure == Structure::Conservative {
        let square = hull(own().filter_map(|mode| mode.omega_squared))?;
        // Of a cluster that was cut off only a part is known.
        let last = group.last() == Some(&(modes.modes.len() - 1));
        let cut = last && modes.modes.len() < linearized.dimension();
        let place = Place { exponent, square: real(-square) };
        let kernel = || {
            let kernel = bordered::kernel(whole, place, count, true)?;
            let parts = |x: Vec<Enclosed>| x.into_iter().map(|x| x.re).collect();
            Some(Space::real(whole, square, kernel.x.into_iter().map(parts).collect(), count == 1))
        };
        // The vectors of the modes are doubles.
        if count == 1
            && whole.order <= MOST_SOLVED_AGAIN
            && let Some(space) = kernel()
        {
            return Some(space);
        }
        if !linearized.is_constrained() && !cut {
            let vectors = own().map(|mode| {
                let x = mode.vector.iter();
                x.map(|x| Ball::from(*x).with_added_radius(mode.vector_error_bound)).collect::<Vec<Ball>>()
            });
            let vectors: Rows<Ball> = vectors.collect();
            if vectors.iter().flatten().all(Ball::is_finite) && vectors.iter().all(|x| x.len() == whole.order) {
                return Some(Space::real(whole, square, vectors, true));
            }
        }
        return kernel();
    }
    let square = exponent.mul(&exponent);
    let place = Place { exponent, square };
    let kernel = bordered::kernel(whole, place, count, false)?;
    let slope = form(whole.order, &whole.mass, &kernel.x, &kernel.y);
    let double = exponent.scale(1);
    let mut slope = slope.map(|entry| entry.mul(&double));
    if let Some(velocity) = &whole.velocity {
        slope = slope.add(&form(whole.order, velocity, &kernel.x, &kernel.y));
    }
    let kept = match count {
        1 if structure == Structure::Gyroscopic && exponent.re.is_zero() => Kept::Imaginary,
        1 if exponent.im.is_zero() => Kept::Real,
        _ => Kept::Nothing,
    };
    Some(Space::Complex { place, x: kernel.x, y: kernel.y, slope, kept })
}

/// More coordinates than this are not asked for in symbols.
const MOST_IN_SYMBOLS: usize = 40;

/// Whether zero modes are such whatever the values of the parameters are: by a symmetry that holds identically, or because Kz = 0 does,
/// with the parameters as symbols.
fn stay(linearized: &Linearized, zeros: &[ZeroMode]) -> bool {
    // Symmetries of the energies say nothing of other forces.
    let acted = !linearized.model().forces.is_empty();
    let others: Vec<&ZeroMode> = zeros.iter().filter(|zero| acted || !zero.holds_everywhere()).collect();
    if others.is_empty() {
        return true;
    }
    if linearized.dimension() > MOST_IN_SYMBOLS || linearized.is_reduced() {
        return false;
    }
    let mut own = linearized.symbolic();
    let pool = &mut own.pool;
    let zero = |pool: &mut Pool, row: &[ExprId], vector: &[Number]| {
        let terms: Vec<(ExprId, Number)> = row.iter().copied().zip(vector.iter().cloned()).collect();
        let image = pool.linear(&terms);
        pool.vanishes(image)
    };
    others.iter().all(|mode| {
        let exact = mode.vector.iter().map(|x| {
            let short = x.is_exact() && x.mid.lo == 0.0;
            short.then(|| Number::from_f64_exact(x.mid_f64())).flatten()
        });
        let Some(vector) = exact.collect::<Option<Vec<Number>>>() else { return false };
        let rows = own.stiffness.iter().chain(own.circulatory.iter().flatten());
        rows.into_iter().all(|row| zero(pool, row, &vector))
    })
}

/// YᴴAX, for a matrix column by column.
fn form(order: usize, matrix: &[Ball], x: &Rows<Enclosed>, y: &Rows<Enclosed>) -> Matrix<Enclosed> {
    let mut sums = Matrix::from_fn(y.len(), x.len(), |_, _| Enclosed::zero(()));
    let mut image = vec![Enclosed::zero(()); order];
    for (q, x) in x.iter().enumerate() {
        image.fill(Enclosed::zero(()));
        for (x, column) in x.iter().zip(matrix.chunks_exact(order.max(1))) {
            for (image, entry) in image.iter_mut().zip(column) {
                if !entry.is_zero() {
                    *image = image.add(&x.times(entry));
                }
            }
        }
        for (p, y) in y.iter().enumerate() {
            for (y, image) in y.iter().zip(&image) {
                if !image.is_zero() {
                    sums[(p, q)] = sums[(p, q)].add(&y.conjugate().mul(image));
                }
            }
        }
    }
    sums
}

/// Xᵀ(A - sB)X for symmetric matrices, column by column.
fn symmetric_form(order: usize, matrix: impl Fn(usize) -> Option<Ball>, vectors: &Rows<Ball>) -> Matrix<Ball> {
    let m = vectors.len();
    let mut sums = Matrix::from_fn(m, m, |_, _| Ball::ZERO);
    for j in 0..order {
        for i in 0..=j {
            let Some(entry) = matrix(i + order * j) else { continue };
            for (p, x) in vectors.iter().enumerate() {
                for (q, y) in vectors.iter().enumerate().take(p + 1) {
                    let product = if i == j { x[i] * y[i] } else { x[i] * y[j] + x[j] * y[i] };
                    sums[(p, q)] = sums[(p, q)] + entry * product;
                }
            }
        }
    }
    Matrix::from_fn(m, m, |p, q| sums[(p.max(q), p.min(q))])
}

fn complex(vectors: &Rows<Ball>) -> Rows<Enclosed> {
    vectors.iter().map(|x| x.iter().copied().map(real).collect()).collect()
}

/// How exponents of M and K move where gyroscopic forces or friction begin to act, which vanish at the values as they are.
fn beginning(
    order: usize,
    square: Ball,
    vectors: &Rows<Ball>,
    gram: &Matrix<Ball>,
    slopes: &Slopes,
) -> Option<Vec<Enclosed>> {
    let root = square.abs().sqrt();
    let exponent = match square.is_positive() {
        true => Enclosed { re: Ball::ZERO, im: root },
        false if square.is_negative() => real(root),
        false => return None,
    };
    let x = complex(vectors);
    let weighted = |matrix: &[Ball], factor: Enclosed| form(order, matrix, &x, &x).map(|entry| entry.mul(&factor));
    // -(λ² dM + λ dD + dS) and 2 λ M.
    let mut change = weighted(&slopes.stiffness, real(-Ball::ONE));
    change = change.add(&weighted(&slopes.mass, real(square)));
    if let Some(velocity) = &slopes.velocity {
        change = change.add(&weighted(velocity, Enclosed::zero(()).sub(&exponent)));
    }
    let double = exponent.scale(1);
    split::general(&change, &gram.map(|entry| double.times(entry)))
}

impl Space {
    fn real(whole: &WithMultipliers, square: Ball, vectors: Rows<Ball>, are_shapes: bool) -> Self {
        let mass = |at: usize| Some(whole.mass[at]).filter(|entry| !entry.is_zero());
        let gram = symmetric_form(whole.order, mass, &vectors);
        Self::Real { square, vectors, gram, are_shapes }
    }

    /// d growth + i d omega of each exponent; those of modes whose shapes mix, which is told, have an order of their own.
    fn moved(&self, slopes: &Slopes, is_mixed: &mut bool) -> Option<Vec<Enclosed>> {
        match self {
            // A force that begins to act on them may hold them or drive them away.
            Self::Zero { unheld: false, .. } if slopes.drags => None,
            Self::Zero { count, coupled, .. } => {
                let stays = match (coupled, &slopes.velocity) {
                    (Some(vectors), Some(velocity)) => {
                        let order = velocity.len().isqrt();
                        let vectors = complex(vectors);
                        let unchanged =
                            || form(order, velocity, &vectors, &vectors).entries().iter().all(Enclosed::is_zero);
                        velocity.iter().all(Ball::is_zero) || vectors.iter().all(|x| x.len() == order) && unchanged()
                    }
                    _ => true,
                };
                stays.then(|| vec![Enclosed::zero(()); *count])
            }
            Self::Real { square, vectors, gram, are_shapes } => {
                let order = vectors.first()?.len();
                let acts = |matrix: &Vec<Ball>| matrix.iter().any(|entry| !entry.is_zero());
                if slopes.drags || slopes.velocity.as_ref().is_some_and(acts) {
                    *is_mixed = true;
                    return beginning(order, *square, vectors, gram, slopes);
                }
                let change = |at: usize| {
                    let (k, m) = (slopes.stiffness[at], slopes.mass[at]);
                    if m.is_zero() { Some(k).filter(|k| !k.is_zero()) } else { Some(k - *square * m) }
                };
                let change = symmetric_form(order, change, vectors);
                let mut moved = match (change.entries(), gram.entries()) {
                    ([change], [gram]) => vec![*change / *gram],
                    _ => split::symmetric(&change, gram)?,
                };
                // Shapes that a parameter does not mix have the values on the diagonal.
                let m = moved.len();
                let is_diagonal = (0..m * m).all(|at| at / m == at % m || change[(at / m, at % m)].contains_zero());
                let apart = *are_shapes && is_diagonal;
                *is_mixed |= !apart;
                if apart {
                    let own: Vec<Ball> = (0..m).map(|i| change[(i, i)] / gram[(i, i)]).collect();
                    let mut order: Vec<usize> = (0..m).collect();
                    order.order_by(|i, j| own[*i].mid.hi.total_cmp(&own[*j].mid.hi));
                    let sorted = std::mem::take(&mut moved);
                    moved = own;
                    order.into_iter().zip(sorted).for_each(|(i, value)| moved[i] = value);
                } else if square.is_negative() {
                    moved.reverse();
                }
                // d(ω²) = 2 ω dω, and for growth s with ω² = -s²: ds = -d(ω²)/(2 s).
                let double = square.abs().sqrt().scale(1);
                let part = |moved: Ball| {
                    if square.is_positive() {
                        Some(Enclosed { re: Ball::ZERO, im: moved / double })
                    } else {
                        square.is_negative().then(|| real(-moved / double))
                    }
                };
                moved.into_iter().map(part).collect()
            }
            Self::Complex { place, x, y, slope, kept } => {
                *is_mixed |= x.len() > 1;
                let order = x.first()?.len();
                let mut change = form(order, &slopes.stiffness, x, y);
                let mut more = |matrix: &[Ball], factor: Enclosed| {
                    if matrix.iter().any(|entry| !entry.is_zero()) {
                        let part = form(order, matrix, x, y).map(|entry| entry.mul(&factor));
                        change = change.add(&part);
                    }
                };
                more(&slopes.mass, place.square);
                if let Some(velocity) = &slopes.velocity {
                    more(velocity, place.exponent);
                }
                let mut moved = split::general(&change.map(|x| Enclosed::zero(()).sub(x)), slope)?;
                for moved in &mut moved {
                    match kept {
                        Kept::Imaginary if !(slopes.damps || slopes.drags) => moved.re = Ball::ZERO,
                        Kept::Real => moved.im = Ball::ZERO,
                        Kept::Imaginary | Kept::Nothing => {}
                    }
                }
                Some(moved)
            }
        }
    }
}
