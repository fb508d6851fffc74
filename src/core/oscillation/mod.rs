//! Normal modes of a linearized model: the numeric stage put to work, and its results named.
//!
//! Hands M and K with their bounds to [`crate::modes`], proves zero modes only where the stiffness
//! may be singular, searches for symmetries, and puts the model's names back. It computes no eigenvalue
//! itself.

mod exponents;
mod parts;
mod proportional;
mod sparse;
mod symmetry;
mod units;
mod warning;

pub use sparse::sparse_quadratic;
pub use units::in_units;
pub use warning::{Warning, never_reached};

use crate::linearize::{Inertia, LinearizeError, Linearized, Structure, Units, ZeroMode, check_size, may_be_singular};
use crate::modes::exponents::Limit;
use crate::modes::{
    self, Kind, Method, ModesError, Options, Precise, PreciseProblem, PrecisionLevel, Problem, Source, Spectrum,
    Stability,
};
use crate::precision::{Ball, Big, Scalar, SparseMatrix, quadratic_form};

/// Shapes that nobody asked for are made for at most so many coordinates.
const MOST_SHAPES_FOR_CLASSES: usize = 600;

/// All modes of a model that were asked for.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct NormalModes {
    /// What the modes together say about the equilibrium.
    pub stability: Stability,
    /// Whether some motion grows in powers of t beyond the uniform drift of a zero mode; `None` where that is not decided.
    pub secular: Option<bool>,
    /// Unstable modes by falling growth, then zero modes, then by rising frequency.
    pub modes: Vec<NormalMode>,
    /// The highest precision level that any of the numbers comes from.
    pub level: PrecisionLevel,
    /// What the zero modes are together, each in words: "translation", "rotation about z", …; their vectors, real and
    /// imaginary parts of complex ones, are some basis of these motions.
    pub zero_motions: Vec<String>,
    /// The point group of bodies in space or in a plane whose energies turn freely, after Schoenflies; classes of modes
    /// are its own then.
    pub point_group: Option<String>,
    /// How some modes of a large model were found; `None` where all matrices were dense.
    pub method: Option<Method>,
    /// What the lengths of the shapes are.
    pub normalization: Normalization,
    /// The potential has no minimum here, and gyroscopic forces keep the motion stable all the same.
    pub gyroscopically_stabilised: bool,
    /// Whether each exponent s has a partner -s, as without friction.
    pub paired: bool,
}

/// The length of a shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Normalization {
    /// xᴴMx = 1.
    #[default]
    Mass,
    /// The first component within 1e-6 of the largest is 1, whatever the units of the coordinates are.
    Largest,
}

impl NormalModes {
    /// With what is known of all of them, and no more.
    fn new(modes: Vec<NormalMode>, stability: Stability, secular: Option<bool>, level: PrecisionLevel) -> Self {
        Self {
            stability,
            secular,
            modes,
            level,
            zero_motions: Vec::new(),
            point_group: None,
            method: None,
            normalization: Normalization::Mass,
            gyroscopically_stabilised: false,
            paired: true,
        }
    }

    /// With 1 for the largest component of each shape, in place of xᴴMx = 1.
    #[must_use]
    pub fn with_largest_component_one(mut self) -> Self {
        for mode in &mut self.modes {
            let Some(first) = mode.leading() else { continue };
            // That component is real and positive. A quotient of enclosures is as wide as both, and rounded once.
            let largest = mode.vector[first];
            let own = mode.error_bound_of(first);
            let least = (largest - own).max(0.0);
            let bound = |at: usize| {
                let spread = mode.error_bound_of(at) + own * mode.modulus(at) / largest;
                (spread / least) * (1.0 + 1e-15) + f64::EPSILON * mode.modulus(at) / largest
            };
            let all: Vec<f64> = (0..mode.vector.len()).map(bound).collect();
            mode.vector_error_bound = all.iter().copied().fold(0.0, f64::max);
            if !mode.component_error_bounds.is_empty() {
                mode.component_error_bounds = all;
            }
            mode.vector.iter_mut().chain(&mut mode.imaginary).for_each(|part| *part /= largest);
        }
        self.normalization = Normalization::Largest;
        self
    }
}

/// One normal mode of a model.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct NormalMode {
    /// What kind of motion it is.
    pub kind: Kind,
    /// -exponent² in 1/s²: ω², negative for a mode that grows or decays without oscillating; `None` where it
    /// is not known to be real.
    pub omega_squared: Option<Ball>,
    /// The frequency in rad/s: the imaginary part of the exponent, not negative.
    pub omega: Ball,
    /// The rate of growth in 1/s: the real part of the exponent, negative for a mode that decays.
    pub growth: Ball,
    /// The same numbers to more digits, where a ball does not hold as many as were asked for.
    pub precise: Option<Box<Precise>>,
    /// The shape x with xᴴMx = 1, one component a coordinate; empty if not asked for. The real part, where
    /// the coordinates do not move in phase.
    pub vector: Vec<f64>,
    /// The imaginary part of the shape; empty where the coordinates move in phase.
    pub imaginary: Vec<f64>,
    /// A bound of the error of each component; in a cluster, of the distance from its space.
    pub vector_error_bound: f64,
    /// The same for each component by itself, where coordinates are in units so far apart that one bound says little of some; else
    /// empty.
    pub component_error_bounds: Vec<f64>,
    /// Modes with the same number are not separated by the bounds.
    pub cluster: u32,
    /// The class under the model's symmetry: `even` or `odd` for a mirror (in a row for several that
    /// commute), `wave number j` for a ring, else `class j`.
    pub symmetry: Option<String>,
    /// Why digits are missing, or that the exponent has fewer vectors than its multiplicity; only with
    /// gyroscopic forces or friction.
    pub limit: Option<Limit>,
    /// What the uncertainties of parameters make of these numbers, where that was asked for and there are any.
    pub uncertainty: Option<Uncertainty>,
}

impl NormalMode {
    /// With ω², omega and growth, and a real shape with its bound; what else there may be to say is not said.
    fn new(
        kind: Kind,
        (omega_squared, omega, growth): (Option<Ball>, Ball, Ball),
        (vector, vector_error_bound): (Vec<f64>, f64),
        cluster: u32,
    ) -> Self {
        Self {
            kind,
            omega_squared,
            omega,
            growth,
            precise: None,
            vector,
            imaginary: Vec::new(),
            vector_error_bound,
            component_error_bounds: Vec::new(),
            cluster,
            symmetry: None,
            limit: None,
            uncertainty: None,
        }
    }

    /// The damping ratio of a damped mode, -growth/|exponent|; in more digits where the exponent has them.
    #[must_use]
    pub fn damping_ratio(&self) -> Option<(Ball, Option<Big>)> {
        fn ratio<S: Scalar>(growth: &S, omega: &S) -> S {
            growth.neg().div(&growth.mul(growth).add(&omega.mul(omega)).sqrt())
        }
        (self.kind == Kind::Damped).then(|| {
            let precise = self.precise.as_deref().map(|own| ratio(&own.growth, &own.omega));
            (ratio(&self.growth, &self.omega), precise)
        })
    }

    /// The size of a component of the shape, by its number.
    #[must_use]
    pub fn modulus(&self, component: usize) -> f64 {
        let real = self.vector.get(component).copied().unwrap_or(0.0);
        self.imaginary.get(component).map_or(real.abs(), |imaginary| real.hypot(*imaginary))
    }

    /// The first component within 1e-6 of the largest, which is real and positive.
    #[must_use]
    pub fn leading(&self) -> Option<usize> {
        modes::leading(self.vector.len(), |at| self.modulus(at)).map(|(at, _)| at)
    }

    /// A bound of the error of a component of the shape, by its number.
    #[must_use]
    pub fn error_bound_of(&self, component: usize) -> f64 {
        self.component_error_bounds.get(component).copied().unwrap_or(self.vector_error_bound)
    }
}

/// The standard uncertainty of a mode's exponent, of first order; `None` where there is no derivative.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Uncertainty {
    /// Of omega, in rad/s.
    pub omega: Option<Ball>,
    /// Of growth, in 1/s.
    pub growth: Option<Ball>,
}

impl Uncertainty {
    /// Of the two.
    pub fn new(omega: Option<Ball>, growth: Option<Ball>) -> Self {
        Self { omega, growth }
    }
}

/// Finds the normal modes.
///
/// # Errors
/// [`LinearizeError::NotFinite`] where M or K are not numbers, [`LinearizeError::SingularMass`] and
/// [`LinearizeError::IndefiniteMass`] where a motion has no positive inertia.
pub fn normal_modes(linearized: &Linearized, options: &Options) -> Result<NormalModes, LinearizeError> {
    let budget = linearized.model().pool.budget();
    budget.at(format!("the modes of {} coordinates", linearized.dimension()), None);
    let rate = linearized.units().map_or(0, Units::rate);
    let options_here = options.smaller(rate);
    let error = linearized.massless_error().cloned();
    let modes = error.map_or_else(|| modes_of(linearized, &options_here), Err);
    let modes = modes.or_else(|error| match error {
        LinearizeError::SingularMass { .. } => exponents::without_inertia(linearized, &options_here).ok_or(error),
        // Where no velocities act it is a condensation that can't be, as that of a multiplier in V.
        LinearizeError::NotCondensed { .. } if linearized.structure() != Structure::Conservative => {
            exponents::without_inertia(linearized, &options_here).ok_or(error)
        }
        _ => Err(error),
    });
    budget.check()?;
    let mut modes = modes?;
    budget.tell(|| format!("precision: {}", modes.level.as_str()));
    if let Some(own) = linearized.units() {
        modes.modes.iter_mut().for_each(|mode| units::in_si(own, mode));
    }
    if !linearized.rolled().is_empty() && options.given.is_none() && options.near.is_none() {
        add_rolled(linearized, &mut modes, options);
    }
    if let (None, Some((omega, count))) = (&options.given, options.near) {
        modes::keep_nearest(&mut modes.modes, count, |mode| (mode.omega.mid_f64() - omega).abs());
    }
    Ok(modes)
}

/// Adds a zero for each condition on velocities that can't be integrated, behind the other zeros.
fn add_rolled(linearized: &Linearized, modes: &mut NormalModes, options: &Options) {
    let whole = linearized.with_multipliers();
    let place = modes.modes.iter().position(|mode| !matches!(mode.kind, Kind::Unstable | Kind::Zero));
    let place = place.unwrap_or(modes.modes.len());
    let cluster = modes.modes.iter().map(|mode| mode.cluster).max().map_or(0, |most| most + 1);
    let coordinates = &linearized.model().coordinates;
    let added = linearized.rolled().iter().zip(linearized.families()).map(|(own, family)| {
        let inertia = quadratic_form(&whole.mass, whole.order, family, ());
        let size = if inertia.is_positive() { Ball::ONE / inertia.sqrt() } else { Ball::ONE };
        let scaled: Vec<Ball> = family.iter().map(|x| *x * size).collect();
        let bound = scaled.iter().map(Ball::mid_f64_error).fold(0.0, f64::max);
        let vector: Vec<f64> = scaled.iter().map(Ball::mid_f64).collect();
        let what = if linearized.model().rates.any() { "steady motions" } else { "equilibria" };
        modes.zero_motions.push(format!("{what} with any {}", coordinates.at(*own).name()));
        let vector = if options.vectors { modes::signed(vector) } else { Vec::new() };
        NormalMode::new(Kind::Zero, (Some(Ball::ZERO), Ball::ZERO, Ball::ZERO), (vector, bound), cluster)
    });
    let added: Vec<NormalMode> = added.collect();
    modes.modes.splice(place..place, added);
    modes.modes.truncate(options.lowest.unwrap_or(usize::MAX));
}

fn modes_of(linearized: &Linearized, options: &Options) -> Result<NormalModes, LinearizeError> {
    if let Some(modes) = sparse::some_modes(linearized, options)? {
        return Ok(modes);
    }
    // The nearest ones are among all.
    let options = &Options { lowest: options.lowest.filter(|_| options.near.is_none()), ..options.clone() };
    if linearized.structure() != Structure::Conservative {
        return exponents::normal_modes(linearized, options);
    }
    let dimension = linearized.dimension();
    check_size(dimension)?;
    let mass = linearized.mass();
    let stiffness = linearized.stiffness();
    if !mass.iter().chain(&stiffness).all(Ball::is_finite)
        && let Some(error) = linearized.not_finite()
    {
        return Err(error);
    }
    let searched = may_be_singular(dimension, &stiffness);
    let mut zero_modes = if searched { linearized.zero_modes() } else { Vec::new() };
    let mut problem = Problem { dimension, mass, stiffness, zero_vectors: Vec::new() };
    // The classes are read off the shapes, which are made for them where that is cheap.
    let sparse = |matrix: &[Ball]| SparseMatrix::from_dense(dimension, matrix);
    let whole = (dimension <= symmetry::MOST_COORDINATES && has_shapes(dimension, options)).then(|| linearized.whole());
    let labels = whole.flatten().and_then(|(mass, stiffness)| match linearized.is_reduced() {
        true => symmetry::labels(linearized, &mass, &stiffness),
        false => symmetry::labels(linearized, &sparse(&problem.mass), &sparse(&problem.stiffness)),
    });
    let inner = Options { vectors: options.vectors || labels.is_some(), ..options.clone() };
    let mut solve = |zero_modes: &mut Vec<ZeroMode>| loop {
        problem.zero_vectors = zero_modes.iter().map(|mode| mode.vector.clone()).collect();
        let source = Model { linearized, zero_modes, labels: labels.as_ref() };
        match modes::solve_from(&problem, &source, &inner) {
            // What was found modulo a prime does not hold in true numbers: it is no zero mode.
            Err(ModesError::ZeroVector { index }) if index < zero_modes.len() => _ = zero_modes.remove(index),
            result => return result.map_err(|error| named(linearized, &error)),
        }
    };
    let mut spectrum = solve(&mut zero_modes)?;
    // Pivots may have grown from rounding: then the bounds find the zero.
    if !searched && spectrum.modes.iter().any(|mode| mode.kind == Kind::Undecided) {
        zero_modes = linearized.zero_modes();
        if !zero_modes.is_empty() {
            spectrum = solve(&mut zero_modes)?;
        }
    }
    Ok(with_names(linearized, spectrum, labels, zero_motions(zero_modes), options))
}

/// Whether shapes are made, at least for the classes.
fn has_shapes(n: usize, options: &Options) -> bool {
    options.vectors || n <= MOST_SHAPES_FOR_CLASSES
}

/// The modes of a spectrum with their classes.
fn with_names(
    linearized: &Linearized,
    spectrum: Spectrum,
    labels: Option<symmetry::Labels>,
    zero_motions: Vec<String>,
    options: &Options,
) -> NormalModes {
    let point_group = labels.as_ref().and_then(|labels| labels.group.clone());
    let classes = labels.map(|mut labels| {
        // Symmetries are those of all coordinates.
        let whole = spectrum.modes.iter().map(|mode| linearized.embed(&mode.vector, mode.vector_error_bound));
        labels.of(&whole.collect::<Vec<_>>())
    });
    let mut classes = classes.into_iter().flatten();
    let modes = spectrum
        .modes
        .into_iter()
        .map(|mode| {
            let symmetry = classes.next().flatten();
            let shape = if options.vectors {
                shape(linearized, mode.vector, mode.vector_error_bound)
            } else {
                (Vec::new(), mode.vector_error_bound)
            };
            let numbers = (Some(mode.omega_squared), mode.omega, mode.growth);
            NormalMode { precise: mode.precise, symmetry, ..NormalMode::new(mode.kind, numbers, shape, mode.cluster) }
        })
        .collect();
    // K and M are symmetric: a zero mode drifts, and every other motion has its own vector.
    let modes = NormalModes::new(modes, spectrum.stability, Some(false), spectrum.level);
    NormalModes { zero_motions, point_group, ..modes }
}

/// The shape in all coordinates, where constraints tie some to others: the first component within 1e-6 of
/// the largest is positive in these, too.
fn shape(linearized: &Linearized, own: Vec<f64>, bound: f64) -> (Vec<f64>, f64) {
    if !linearized.is_reduced() && linearized.units().is_none() {
        return (own, bound);
    }
    let (mut vector, mut bound) = linearized.embed(&own, bound);
    if let Some(units) = linearized.units() {
        units.shape(&mut vector, false);
        bound = units.shape_error(bound, vector.len(), false);
    }
    (modes::signed(vector), bound)
}

/// A model as the source of a problem.
struct Model<'a> {
    linearized: &'a Linearized,
    zero_modes: &'a [ZeroMode],
    labels: Option<&'a symmetry::Labels>,
}

impl Source for Model<'_> {
    fn precisely(&self, bits: usize) -> Option<PreciseProblem> {
        let precise = self.linearized.precisely(bits)?;
        let zero_modes = self.linearized.precise_zero_modes(&precise, self.zero_modes)?;
        Some(PreciseProblem {
            dimension: self.linearized.dimension(),
            mass: precise.mass,
            stiffness: precise.stiffness,
            zero_vectors: zero_modes.into_iter().map(|mode| mode.vector).collect(),
        })
    }

    fn zero_spaces(&self, vectors: &[Vec<f64>]) -> Option<Vec<Vec<Vec<f64>>>> {
        let whole = vectors.iter().map(|vector| self.linearized.embed(vector, 0.0).0);
        self.labels?.classes.spaces(&whole.collect::<Vec<_>>())
    }
}

/// What the zero modes are. Their printed vectors are an orthonormal basis of the space that they
/// span together, so that a mode alone has a meaning only where it is the only one.
fn zero_motions(zero_modes: Vec<ZeroMode>) -> Vec<String> {
    zero_modes.into_iter().map(|mode| mode.meaning).collect()
}

/// Whether Mx is exactly 0.
fn has_no_inertia(mass: &[Ball], x: &[f64]) -> bool {
    let n = x.len();
    let row = |i: usize| (0..n).fold(Ball::ZERO, |sum, j| sum + mass[i + n * j] * Ball::from(x[j]));
    (0..n).all(|i| row(i).is_zero())
}

/// What is wrong with the mass matrix, if anything is: a problem with that mass and no other forces tells.
pub(crate) fn mass_error(linearized: &Linearized) -> Option<LinearizeError> {
    if let Some(error) = linearized.massless_error() {
        return Some(error.clone());
    }
    let dimension = linearized.dimension();
    let problem = Problem {
        dimension,
        mass: linearized.mass(),
        stiffness: vec![Ball::ZERO; dimension * dimension],
        zero_vectors: Vec::new(),
    };
    let error = modes::solve(&problem, &Options::default()).err()?;
    Some(named(linearized, &error))
}

/// The errors of the numeric stage with the model's names.
fn named(linearized: &Linearized, error: &ModesError) -> LinearizeError {
    let coordinates = &linearized.model().coordinates;
    let first_term = linearized.model().kinetic.first().map(|family| family.span).unwrap_or_default();
    match error {
        ModesError::NotPositiveDefinite { direction, singular } => {
            let own = direction;
            let mut direction = linearized.embed(direction, 0.0).0;
            if let Some(units) = linearized.units() {
                units.direction(&mut direction);
            }
            let moving = || coordinates.iter().zip(&direction).filter(|(_, amplitude)| amplitude.abs() > 1e-6);
            let combination = moving().map(|(coordinate, amplitude)| (coordinate.name(), *amplitude)).collect();
            let span = moving().next().map_or(first_term, |(coordinate, _)| coordinate.span);
            if *singular && linearized.has_inertia_nearby() {
                LinearizeError::SingularCoordinates { combination, drawn: false, span }
            } else if *singular {
                let inertia = if has_no_inertia(&linearized.mass(), own) { Inertia::None } else { Inertia::Undecided };
                LinearizeError::SingularMass { combination, inertia, span }
            } else {
                LinearizeError::IndefiniteMass { combination, span }
            }
        }
        ModesError::NotFinite { matrix, .. } => LinearizeError::NotFinite {
            what: format!("the {} matrix", matrix.as_str()),
            point: "the equilibrium".to_owned(),
            cause: None,
            span: first_term,
        },
        ModesError::MassNotDecided
        | ModesError::Shape { .. }
        | ModesError::ZeroVector { .. }
        | ModesError::NoConvergence => LinearizeError::NoModes { reason: error.to_string() },
    }
}
