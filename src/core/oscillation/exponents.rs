//! Modes of models with gyroscopic forces or friction: exponents growth + i omega.

use faer::c64;

use super::{NormalMode, NormalModes, parts};
use crate::linearize::{Flow, LinearizeError, Linearized, NO_FORCE, Structure, ZeroMode};
use crate::modes::exponents::Structure as Form;
use crate::modes::exponents::{
    Exponent, Exponents, Limit, PreciseQuadratic, QuadraticProblem, QuadraticSource, exponents,
    exponents_without_inertia, finish,
};
use crate::modes::{Kind, ModesError, Options, Stability, leading};
use crate::order::Gather;
use crate::precision::{Ball, Big, Complex, Enclosure, Integers, Magnitude, System, quadratic_form};

/// The model as a source of matrices.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) linearized: &'a Linearized,
    pub(super) flow: Option<&'a Flow>,
}

impl QuadraticSource for Source<'_> {
    fn precisely(&self, bits: usize) -> Option<PreciseQuadratic> {
        let precise = self.linearized.precisely(bits)?;
        // Circulatory forces need no velocities.
        let still = || vec![Big::zero(precise.bits); precise.mass.len()];
        let velocity = precise.velocity.unwrap_or_else(still);
        let mut all = [precise.mass, velocity, precise.stiffness];
        if let Some(flow) = self.flow {
            all = flow.regular(&all, Enclosure::certain_size, precise.bits)?;
        }
        Some(all)
    }

    fn integers(&self) -> Option<Integers> {
        self.linearized.integers_with(self.flow)
    }
}

/// Finds the exponents and their shapes.
///
/// # Errors
/// As [`super::normal_modes`].
pub(super) fn normal_modes(linearized: &Linearized, options: &Options) -> Result<NormalModes, LinearizeError> {
    let (problem, mut zero_modes) = problem(linearized);
    // The classes are read off the shapes, which are made for them where that is cheap.
    let for_classes = || super::has_shapes(problem.dimension, options) && super::symmetry::may_classify(linearized);
    let inner = Options { vectors: options.vectors || for_classes(), ..options.clone() };
    let found = match linearized.flow() {
        Some(flow) => flowing(linearized, flow, &problem, &mut zero_modes, &inner)?,
        None => solved(Source { linearized, flow: None }, problem.clone(), &mut zero_modes, &inner)?,
    };
    let stabilised = problem.structure == Form::Gyroscopic
        && found.stability == Stability::Stable
        && falling_direction(&problem.mass, &problem.stiffness).is_some();
    let mut modes = in_words(linearized, found, zero_modes);
    if !options.vectors {
        modes.modes.iter_mut().for_each(|mode| (mode.vector, mode.imaginary) = (Vec::new(), Vec::new()));
    }
    Ok(NormalModes { gyroscopically_stabilised: stabilised, ..modes })
}

/// The problem of a model, with its proved zero modes.
fn problem(linearized: &Linearized) -> (QuadraticProblem, Vec<ZeroMode>) {
    let (velocity, stiffness) = linearized.velocity_and_stiffness();
    let circulatory = linearized.circulatory().is_some();
    let mut zero_modes = linearized.zero_modes();
    if circulatory {
        // What costs no energy may still be pushed by friction.
        let pushed = |mode: &ZeroMode| !linearized.is_free_of_friction_at_rest(&mode.vector);
        zero_modes.retain(|mode| !pushed(mode));
    }
    let problem = QuadraticProblem {
        dimension: linearized.dimension(),
        mass: linearized.mass(),
        velocity,
        stiffness,
        structure: match linearized.structure() {
            Structure::Circulatory => Form::Circulatory,
            Structure::Damped if circulatory => Form::Damped,
            Structure::Damped if linearized.gyroscopic().is_some() => Form::Dissipative,
            Structure::Damped => Form::Symmetric,
            Structure::Conservative | Structure::Gyroscopic => Form::Gyroscopic,
        },
        zero_vectors: zero_modes.iter().map(|mode| mode.vector.clone()).collect(),
        unmoved: linearized.unmoved(&zero_modes),
    };
    (problem, zero_modes)
}

/// Where M is singular in a way that does not reduce to a regular one: decided exactly, if all matrices are known exactly.
pub(super) fn without_inertia(linearized: &Linearized, options: &Options) -> Option<NormalModes> {
    // Where coordinates are singular there is inertia beside the place.
    if linearized.has_inertia_nearby() {
        return None;
    }
    let (problem, _) = problem(linearized);
    let (n, m) = (problem.dimension, &problem.mass);
    let falls = |i: usize, j: usize| (m[i + n * i] * m[j + n * j] - m[i + n * j] * m[i + n * j]).is_negative();
    if (0..n).any(|i| (0..i).any(|j| falls(i, j))) {
        return None;
    }
    let integers = linearized.integers_with(None)?;
    let problem = QuadraticProblem { zero_vectors: Vec::new(), unmoved: Vec::new(), ..problem };
    let mut found = exponents_without_inertia(&problem, &integers, options)?;
    found.entries.truncate(options.lowest.unwrap_or(usize::MAX));
    found.entries.iter_mut().for_each(|entry| normalise(entry, &problem));
    Some(in_words(linearized, found, Vec::new()))
}

/// Exponents as modes, with what is known of those without frequency.
pub(super) fn in_words(linearized: &Linearized, found: Exponents, zero_modes: Vec<ZeroMode>) -> NormalModes {
    let mut modes: Vec<NormalMode> = found.entries.into_iter().map(|entry| mode(linearized, entry)).collect();
    if linearized.runs_backward() {
        // The decaying partner of each that grows: a pair ±s is one entry.
        modes.retain(|mode| mode.kind != Kind::Overdamped);
    }
    super::symmetry::classify(linearized, &mut modes);
    let zeros: Vec<&NormalMode> = modes.iter().filter(|mode| mode.kind == Kind::Zero).collect();
    let mut zero_motions = super::zero_motions(zero_modes);
    if zeros.is_empty() {
        zero_motions.clear();
    }
    // Others are known by their exponents alone; a complex shape stands for two motions.
    let motions = |mode: &&NormalMode| if mode.imaginary.is_empty() { 1 } else { 2 };
    let apart = zeros.iter().filter(|mode| mode.limit.is_none()).map(motions).sum();
    zero_motions.resize(zero_motions.len().max(apart), NO_FORCE.to_owned());
    let paired = linearized.structure() != Structure::Damped || linearized.runs_backward();
    let secular = match (found.secular, linearized.follows_away()) {
        (Some(true), _) | (_, Some(true)) => Some(true),
        (own, follows) => own.and(follows),
    };
    NormalModes { zero_motions, paired, ..NormalModes::new(modes, found.stability, secular, found.level) }
}

/// The exponents of a regular problem.
fn solved(
    source: Source<'_>,
    mut problem: QuadraticProblem,
    zero_modes: &mut Vec<ZeroMode>,
    options: &Options,
) -> Result<Exponents, LinearizeError> {
    if let Some(found) = parts::solve(source, &problem, zero_modes, options) {
        return Ok(found);
    }
    loop {
        match exponents(&problem, &source, options) {
            // What was found modulo a prime does not hold in true numbers: it is no zero mode.
            Err(ModesError::ZeroVector { index }) if index < zero_modes.len() => {
                zero_modes.remove(index);
                problem.zero_vectors.remove(index);
                problem.unmoved.remove(index);
            }
            other => return other.map_err(|error| named(source.linearized, &error)),
        }
    }
}

/// So many ways to make a problem regular are tried.
const MOST_ATTEMPTS: usize = 3;

/// The exponents where friction holds what has no inertia: those that make the problem regular are left out, where bounds tell
/// which they are.
fn flowing(
    linearized: &Linearized,
    flow: &Flow,
    problem: &QuadraticProblem,
    zero_modes: &mut Vec<ZeroMode>,
    options: &Options,
) -> Result<Exponents, LinearizeError> {
    let every = Options { lowest: None, ..options.clone() };
    let all = [problem.mass.clone(), problem.velocity.clone(), problem.stiffness.clone()];
    for number in 0..MOST_ATTEMPTS {
        let flow = flow.attempt(number);
        let Some([mass, velocity, stiffness]) = flow.regular(&all, Enclosure::certain_size, ()) else { break };
        let regular = QuadraticProblem { mass, velocity, stiffness, structure: Form::Damped, ..problem.clone() };
        let source = Source { linearized, flow: Some(&flow) };
        let mut found = solved(source, regular, zero_modes, &every)?;
        let added = |entry: &Exponent, shift: &f64| {
            (entry.growth + Ball::exact(*shift)).contains_zero() && entry.omega.contains_zero()
        };
        // An added one that is an exponent of the model as well is two, which may look like a pair.
        let is_single = |entry: &&Exponent| entry.omega.is_zero() && entry.limit.is_none();
        let is_told = |shift: &f64| {
            found.entries.iter().filter(|entry| added(entry, shift)).only().is_some_and(|own| is_single(&own))
        };
        if !flow.shifts.iter().all(is_told) {
            continue;
        }
        found.entries.retain(|entry| !flow.shifts.iter().any(|shift| added(entry, shift)));
        if linearized.structure() == Structure::Gyroscopic {
            found = paired(found, linearized.mode_count(), &every);
        }
        found.entries.truncate(options.lowest.unwrap_or(usize::MAX));
        found.entries.iter_mut().for_each(|entry| normalise(entry, problem));
        return Ok(found);
    }
    let reason = "coordinates without inertia beside friction lead to exponents that bounds do not tell apart";
    Err(LinearizeError::NoModes { reason: reason.to_owned() })
}

/// The exponents of so many modes that are known to come in pairs ±s: one of each, half of the zeros.
fn paired(found: Exponents, modes: usize, options: &Options) -> Exponents {
    let Exponents { mut entries, level, .. } = found;
    let all: Vec<[Ball; 2]> = entries.iter().map(|entry| [entry.growth, entry.omega]).collect();
    for (at, entry) in entries.iter_mut().enumerate() {
        // s and -s̄ are exponents; where there is no other one, s lies on the axis.
        let is_apart = |(other, [growth, omega]): (usize, &[Ball; 2])| {
            other == at
                || !(*growth + entry.growth).contains_zero()
                || !(*omega - entry.omega).contains_zero() && !(*omega + entry.omega).contains_zero()
        };
        let is_simple = entry.limit == Some(Limit::Open) && entry.omega.is_positive();
        if is_simple && entry.growth.contains_zero() && all.iter().enumerate().all(is_apart) {
            entry.kind = Kind::Oscillation;
            entry.growth = Ball::ZERO;
            entry.omega_squared = Some(entry.omega * entry.omega);
            entry.limit = None;
            if let Some(precise) = &mut entry.precise {
                precise.growth = Big::zero(precise.omega.bits());
                precise.omega_squared = &precise.omega * &precise.omega;
            }
        }
    }
    // The decaying partner of each that grows.
    entries.retain(|entry| entry.kind != Kind::Overdamped);
    // There may be more motions without frequency than half the multiplicity of the exponent 0.
    let moving = entries.iter().filter(|entry| entry.kind != Kind::Zero).count();
    let mut zeros = 0..modes.saturating_sub(moving);
    entries.retain(|entry| entry.kind != Kind::Zero || zeros.next().is_some());
    // Or fewer: then motions grow with powers of t, which have no shapes of their own.
    let more = entries.iter().find(|entry| entry.kind == Kind::Zero).cloned();
    let more: Vec<Exponent> = more.into_iter().flat_map(|zero| vec![zero; zeros.len()]).collect();
    let grows = !more.is_empty();
    entries.extend(more);
    let mut found = finish(entries, level, options, &|_| false);
    found.secular = if grows { Some(true) } else { found.secular };
    found
}

/// Above this share of xᴴMx that rounding may be, the vector is solved for once more.
const MOST_SLACK: f64 = 1e-6;
/// Of so many coordinates at most.
const MOST_SOLVED: usize = 60;

/// Brings a vector to xᴴMx = 1 for a mass matrix that is singular; to a largest component of 1 where it has no inertia.
fn normalise(entry: &mut Exponent, problem: &QuadraticProblem) {
    let (x, n, mass) = (&entry.vector, entry.vector.len(), &problem.mass);
    if n == 0 {
        return;
    }
    let (mut square, mut slope) = (0.0, 0.0);
    for j in 0..n {
        for i in 0..n {
            let m = mass[i + n * j].mid_f64();
            square += m * (x[i].re * x[j].re + x[i].im * x[j].im);
            slope += m.abs() * x[i].re.hypot(x[i].im);
        }
    }
    let largest = x.iter().fold(0.0_f64, |most, x| most.max(x.re.hypot(x.im)));
    // With x off by e in each component xᴴMx is off by 2 e Σ|M||x| to first order, and its root by half of that beside itself.
    let slack = 1.01 * entry.vector_error_bound * slope / square + (n * n) as f64 * 4.0 * f64::EPSILON;
    let moves_masses = square > 0.0;
    if moves_masses
        && slack > MOST_SLACK
        && n <= MOST_SOLVED
        && let Some((vector, bound)) = solved_for(entry, problem)
    {
        (entry.vector, entry.vector_error_bound) = (vector, bound);
        return;
    }
    let (size, share) = match slack < 0.1 {
        true => (square.sqrt(), slack),
        false if moves_masses => (largest, f64::INFINITY),
        false => (largest, 4.0 * f64::EPSILON),
    };
    if size <= 0.0 {
        return;
    }
    entry.vector.iter_mut().for_each(|x| *x /= size);
    entry.vector_error_bound = (entry.vector_error_bound + 1.3 * share * largest) / size * (1.0 + 8.0 * f64::EPSILON);
}

/// The vector of a single exponent with xᴴMx = 1 and a bound of its components, from all equations but one, with its largest component
/// put to 1: masses may move by less than the bound of a vector of doubles. `None` where the equations, or the inertia, are not known
/// well enough.
fn solved_for(entry: &Exponent, problem: &QuadraticProblem) -> Option<(Vec<c64>, f64)> {
    let n = problem.dimension;
    let size = |i: &usize| entry.vector[*i].re.hypot(entry.vector[*i].im);
    let fixed = (0..n).max_by(|i, j| size(i).total_cmp(&size(j)))?;
    let s = Complex::new(entry.growth, entry.omega);
    let of = |i: usize, j: usize| {
        let [mass, velocity, stiffness] =
            [&problem.mass, &problem.velocity, &problem.stiffness].map(|own| own[i + n * j]);
        let rest = s.times(&velocity).add(&Complex::new(stiffness, Ball::ZERO));
        s.mul(&s).times(&mass).add(&rest)
    };
    let without = |left_out: usize| {
        let unit = |j: usize| Complex::real(f64::from(u8::from(j == fixed)), ());
        let mut right = vec![Ball::ZERO; 2 * n];
        right[left_out] = Ball::ONE;
        System::of_complex(n, |i, j| if i == left_out { unit(j) } else { of(i, j) })?.solve(&right)
    };
    let parts = [fixed].into_iter().chain((0..n).filter(|i| *i != fixed)).find_map(without)?;
    let (re, im) = parts.split_at(n);
    let inertia = quadratic_form(&problem.mass, n, re, ()) + quadratic_form(&problem.mass, n, im, ());
    let unit = inertia.is_positive().then(|| Ball::ONE / inertia.sqrt())?;
    let own: Vec<Complex<Ball>> = re.iter().zip(im).map(|(x, y)| Complex::new(*x, *y).times(&unit)).collect();
    let off = |x: &Complex<Ball>| x.radius().to_f64() + f64::EPSILON * x.re.abs_upper().hypot(x.im.abs_upper());
    let bound = own.iter().map(off).fold(0.0, f64::max).next_up();
    Some((own.iter().map(Complex::to_c64).collect(), bound))
}

fn mode(linearized: &Linearized, entry: Exponent) -> NormalMode {
    let own = carried(linearized, &entry).unwrap_or_else(|| {
        let own = shape(linearized, &entry.vector, entry.vector_error_bound);
        if linearized.drift().is_some() { of_length_one(linearized, own) } else { own }
    });
    let Shape { real, imaginary, bound } = own;
    let numbers = (entry.omega_squared, entry.omega, entry.growth);
    let plain = NormalMode::new(entry.kind, numbers, (real, bound), entry.cluster);
    NormalMode { precise: entry.precise, imaginary, limit: entry.limit, ..plain }
}

struct Shape {
    real: Vec<f64>,
    /// Empty where the shape is real.
    imaginary: Vec<f64>,
    /// A bound of the error in length.
    bound: f64,
}

/// The shape where velocities follow places under conditions, with xᴴMx = 1 for all coordinates; `None` elsewhere, and where the exponent may be 0.
fn carried(linearized: &Linearized, entry: &Exponent) -> Option<Shape> {
    let drift = linearized.drift()?;
    let s = Complex::new(entry.growth, entry.omega);
    if entry.vector.is_empty() || s.contains_zero() {
        return None;
    }
    let error = Magnitude::from_f64(entry.vector_error_bound);
    let own: Vec<Complex<Ball>> =
        entry.vector.iter().map(|x| Complex::from_c64(*x, ()).with_added_radius(error)).collect();
    let mut all = linearized.following()?.carried(&drift, &s, &own);
    let (re, im): (Vec<Ball>, Vec<Ball>) = all.iter().map(|x| (x.re, x.im)).unzip();
    let inertia = inertia(linearized, &re, &im);
    if inertia.is_positive() {
        let size = Ball::ONE / inertia.sqrt();
        all.iter_mut().for_each(|x| *x = x.times(&size));
    }
    let bound = all.iter().map(|x| x.radius().to_f64()).fold(0.0, f64::max).next_up();
    let (real, imaginary) = all.iter().map(Complex::to_c64).map(|x| (x.re, x.im)).unzip();
    Some(turned(real, imaginary, bound))
}

/// xᴴMx for all coordinates, of the real and the imaginary parts of x.
fn inertia(linearized: &Linearized, re: &[Ball], im: &[Ball]) -> Ball {
    let whole = linearized.with_multipliers();
    let of = |part: &[Ball]| quadratic_form(&whole.mass, whole.order, part, ());
    of(re) + of(im)
}

/// A shape with xᴴMx = 1 for all coordinates, those of first order too.
fn of_length_one(linearized: &Linearized, own: Shape) -> Shape {
    let balls = |of: &[f64]| of.iter().map(|x| Ball::exact(*x).with_added_radius(own.bound)).collect::<Vec<Ball>>();
    let inertia = inertia(linearized, &balls(&own.real), &balls(&own.imaginary));
    if !inertia.is_positive() {
        return own;
    }
    let size = inertia.sqrt();
    let scaled = |of: &[f64]| of.iter().map(|x| x / size.mid_f64()).collect();
    let largest = own.real.iter().chain(&own.imaginary).fold(0.0_f64, |most, x| most.max(x.abs()));
    let bound = (own.bound + largest * (size.radius / size.mid_f64() + 4.0 * f64::EPSILON)) / size.lower();
    Shape { real: scaled(&own.real), imaginary: scaled(&own.imaginary), bound }
}

/// Real and imaginary parts in all coordinates.
fn shape(linearized: &Linearized, own: &[c64], bound: f64) -> Shape {
    let real: Vec<f64> = own.iter().map(|x| x.re).collect();
    let imaginary: Vec<f64> = own.iter().map(|x| x.im).collect();
    let plain = !linearized.is_reduced() && linearized.units().is_none();
    if own.is_empty() || plain {
        let flat = imaginary.iter().all(|x| *x == 0.0);
        return Shape { real, imaginary: if flat { Vec::new() } else { imaginary }, bound };
    }
    let (mut real, one) = linearized.embed(&real, bound);
    let (mut imaginary, other) = linearized.embed(&imaginary, bound);
    let mut bound = one.hypot(other).next_up();
    if let Some(units) = linearized.units() {
        units.shape(&mut real, false);
        units.shape(&mut imaginary, false);
        bound = units.shape_error(bound, real.len(), false);
    }
    turned(real, imaginary, bound)
}

/// Turned so that the first component within 1e-6 of the largest is real and positive.
fn turned(real: Vec<f64>, imaginary: Vec<f64>, bound: f64) -> Shape {
    let size = |at: usize| real[at].hypot(imaginary[at]);
    let Some((first, largest)) = leading(real.len(), size).filter(|(_, largest)| *largest > 0.0) else {
        return Shape { real, imaginary, bound };
    };
    // Turned by the angle of that component, which is known to (π/2) bound / size: all components move with it.
    let (cos, sin) = (real[first] / size(first), imaginary[first] / size(first));
    let turned = |at: usize| {
        let re = real[at] * cos + imaginary[at] * sin;
        let im = imaginary[at] * cos - real[at] * sin;
        (re, if at == first { 0.0 } else { im })
    };
    let (re, im): (Vec<f64>, Vec<f64>) = (0..real.len()).map(turned).unzip();
    let angle = 1.6 * bound / size(first) + 8.0 * f64::EPSILON;
    let bound = (bound + angle * (largest + bound)) * (1.0 + 8.0 * f64::EPSILON);
    let flat = im.iter().all(|x| *x == 0.0);
    Shape { real: re, imaginary: if flat { Vec::new() } else { im }, bound }
}

/// A direction x with xᵀAx < 0, proved, for the symmetric part of A: an eigenvector of its middle, in
/// units in which all coordinates have mass.
pub(super) fn falling_direction(mass: &[Ball], matrix: &[Ball]) -> Option<Vec<f64>> {
    let n = mass.len().isqrt();
    let units: Vec<f64> = (0..n).map(|i| mass[i + n * i].mid_f64().sqrt()).collect();
    let scaled = nalgebra::DMatrix::from_fn(n, n, |i, j| {
        let entry = matrix[i + n * j].mid_f64() + matrix[j + n * i].mid_f64();
        0.5 * entry / units[i] / units[j]
    });
    if n == 0 || !scaled.iter().all(|x| x.is_finite()) {
        return None;
    }
    let eigen = nalgebra::SymmetricEigen::new(scaled);
    let (lowest, value) = eigen.eigenvalues.argmin();
    if value >= 0.0 {
        return None;
    }
    let direction: Vec<f64> = (0..n).map(|i| eigen.eigenvectors[(i, lowest)] / units[i]).collect();
    let exact: Vec<Ball> = direction.iter().map(|x| Ball::from(*x)).collect();
    quadratic_form(matrix, n, &exact, ()).is_negative().then_some(direction)
}

/// The errors of the numeric stage with the model's names.
fn named(linearized: &Linearized, error: &ModesError) -> LinearizeError {
    let told = match error {
        // The conservative problem with the same mass shows which motion it is.
        ModesError::MassNotDecided => super::mass_error(linearized),
        ModesError::NotFinite { .. } => linearized.not_finite(),
        _ => None,
    };
    told.unwrap_or_else(|| LinearizeError::NoModes { reason: error.to_string() })
}
