//! Some modes of a large model, from sparse matrices, and all of tridiagonal ones.

use super::proportional::Proportional;
use super::{NormalModes, exponents, has_shapes, named, symmetry, with_names, zero_motions};
use crate::linearize::{LinearizeError, Linearized, MOST_COORDINATES, Structure, ZeroMode};
use crate::modes::exponents::Exponents;
use crate::modes::{
    Kind, Method, Options, SparseProblem, SparseQuadratic, Spectrum, Stability, Wanted, is_definite, solve_sparse,
    solve_sparse_quadratic, solve_tridiagonal,
};
use crate::precision::{Ball, SparseMatrix};

/// Up to so many coordinates dense matrices are as fast.
const DENSE: usize = 300;
/// One mode in so many coordinates is few.
const FEW: usize = 8;
/// As one entry in so many is.
const SPARSE: usize = 8;

/// The modes that are asked for, where these are few of a large sparse model or all of a tridiagonal one; `None` where dense matrices are to be used.
///
/// # Errors
/// Where there are too many coordinates for these, too, or an entry is not finite.
pub(super) fn some_modes(linearized: &Linearized, options: &Options) -> Result<Option<NormalModes>, LinearizeError> {
    let n = linearized.dimension();
    let budget = linearized.model().pool.budget();
    let dense = |why: &str| {
        budget.tell(|| format!("solver: dense matrices of {n} coordinates, since {why}"));
        Ok(None)
    };
    let given = options.given.is_some();
    let is_plain = linearized.structure() == Structure::Conservative && linearized.units().is_none();
    if given && (!is_plain || linearized.is_reduced()) {
        return Err(LinearizeError::NoModes {
            reason: "vectors can be given bounds where there are T and V alone, without constraints and massless coordinates".to_owned(),
        });
    }
    let all = |why: &str| all_modes(linearized, options)?.map_or_else(|| dense(why), |modes| Ok(Some(modes)));
    let (wanted, count) = match (&options.given, options.near, options.lowest) {
        (Some(vectors), ..) => (Wanted::Given(vectors), vectors.len() / n.max(1)),
        (None, Some((omega, count)), _) => (Wanted::Near(omega, count), count),
        (None, None, Some(count)) => (Wanted::Lowest(count), count),
        (None, None, None) if is_plain => return all("all modes are wanted"),
        (None, None, None) => return dense("all modes are wanted"),
    };
    let must = given || n > MOST_COORDINATES;
    if linearized.units().is_some() {
        return dense("numbers are far from usual ones");
    } else if !given && n <= DENSE {
        return dense("they are as fast for so few");
    } else if !must && count.saturating_mul(FEW) > n {
        let why = "more than an eighth of the modes are wanted";
        return if is_plain { all(why) } else { dense(why) };
    }
    budget.at("the matrices", None);
    let (mass, stiffness) = match matrices(linearized, count, must, is_plain) {
        Ok(both) => both,
        Err(why) => return dense(why),
    };
    budget.tell(|| structure(&mass, &stiffness));
    let is_finite = |(_, _, value): (usize, usize, &Ball)| value.is_finite();
    if !(mass.entries().all(is_finite) && stiffness.entries().all(is_finite))
        && let Some(error) = linearized.not_finite()
    {
        return Err(error);
    }
    let inner = Options { lowest: None, near: None, given: None, vectors: has_shapes(n, options), ..options.clone() };
    if !is_plain {
        let inner = Options { vectors: options.vectors, ..inner };
        let velocities = linearized.sparse_velocity();
        if let Some(modes) = with_proportional_friction(linearized, (&mass, &stiffness), &velocities, (wanted, &inner))?
        {
            return Ok(Some(modes));
        }
        let problem = quadratic(linearized, (mass, &stiffness), velocities);
        return match some_exponents(linearized, &problem, wanted, (&inner, must))? {
            Some(modes) => Ok(Some(modes)),
            None => dense("the modes that are wanted were not separated"),
        };
    }
    let problem = SparseProblem { mass, stiffness };
    let (found, zero_modes) = undamped(linearized, &problem, wanted, &inner)?;
    let Some((spectrum, method)) = found else {
        return if must { Err(not_found(n, given)) } else { dense("the modes that are wanted were not separated") };
    };
    let is_done = |x: &Ball| x.is_zero() || options.covers(x, true);
    if !must && !spectrum.modes.iter().all(|mode| is_done(&mode.omega_squared)) {
        return dense("bounds in double-double do not cover the digits");
    }
    Ok(Some(in_words(linearized, &problem, (spectrum, method), zero_modes, options)))
}

/// Modes and method, and the proved zero modes.
type Undamped = (Option<(Spectrum, Method)>, Vec<ZeroMode>);

/// The modes of M and K alone.
fn undamped(
    linearized: &Linearized,
    problem: &SparseProblem,
    wanted: Wanted<'_>,
    options: &Options,
) -> Result<Undamped, LinearizeError> {
    let budget = linearized.model().pool.budget();
    let solved = |others: bool| -> Result<_, LinearizeError> {
        let mut zero_modes = Vec::new();
        let mut zero_vectors = || -> Vec<Vec<Ball>> {
            budget.at("the zero modes", None);
            zero_modes = linearized.zero_modes_with(others);
            budget.tell(|| {
                format!(
                    "zero modes: {} proved{}",
                    zero_modes.len(),
                    if others { "" } else { " by symmetries and loose parts" }
                )
            });
            zero_modes.iter().map(|mode| mode.vector.clone()).collect()
        };
        let found = solve_sparse(problem, wanted, &mut zero_vectors, options, budget);
        budget.check()?;
        Ok((found.map_err(|error| named(linearized, &error))?, zero_modes))
    };
    // A count of the eigenvalues below the lowest others tells whether symmetries and loose parts explain all zeros, which is less work.
    let (mut found, mut zero_modes) = solved(false)?;
    let is_open = |(spectrum, _): &(Spectrum, Method)| {
        spectrum.stability == Stability::Undecided || spectrum.modes.iter().any(|mode| mode.kind == Kind::Undecided)
    };
    if found.as_ref().is_none_or(is_open) {
        let with_others = solved(true)?;
        if with_others.1.len() > zero_modes.len() {
            (found, zero_modes) = with_others;
        }
    }
    Ok((found, zero_modes))
}

/// Damped modes whose friction is proportional to M and K, from those without; `None` where it is not, or others come between.
fn with_proportional_friction(
    linearized: &Linearized,
    (mass, stiffness): (&SparseMatrix, &SparseMatrix),
    [velocity, circulatory]: &[SparseMatrix; 2],
    (wanted, options): (Wanted<'_>, &Options),
) -> Result<Option<NormalModes>, LinearizeError> {
    if linearized.structure() != Structure::Damped || circulatory.stored() > 0 {
        return Ok(None);
    }
    let half = |is_lower: bool| {
        let half = velocity.entries().filter(|(i, j, _)| i == j || (i > j) == is_lower);
        let half = half.map(|(i, j, value)| (i.max(j) as u32, i.min(j) as u32, *value));
        SparseMatrix::from_shares(mass.dimension(), &half.collect::<Vec<_>>())
    };
    let damping = half(true);
    if damping != half(false) {
        return Ok(None);
    }
    let Some(friction) = Proportional::new(mass, stiffness, &damping) else { return Ok(None) };
    let budget = linearized.model().pool.budget();
    budget.tell(|| "solver: modes without friction, which is proportional to M and K".to_owned());
    let problem = SparseProblem { mass: mass.clone(), stiffness: stiffness.clone() };
    let mut asked = friction.without(wanted);
    let (mut found, mut zero_modes) = undamped(linearized, &problem, asked, options)?;
    // Those that stop stand behind all zero modes, and the bounds of these need one that is none.
    let is_free = |(own, _): &(Spectrum, Method)| own.modes.last().is_some_and(|mode| mode.kind == Kind::Zero);
    if matches!(asked, Wanted::Lowest(_)) && found.as_ref().is_some_and(is_free) {
        asked = friction.without(Wanted::Lowest(zero_modes.len()));
        (found, zero_modes) = undamped(linearized, &problem, asked, options)?;
    }
    let Some((spectrum, method)) = found else { return Ok(None) };
    // Friction that takes no part in them lets them drift.
    let is_free = !zero_modes.is_empty() && linearized.unmoved(&zero_modes).into_iter().all(|own| own);
    let found = friction.exponents(spectrum, (wanted, asked), options, (linearized.is_passive(), is_free));
    if found.is_none() {
        budget.tell(|| "solver: not all of these oscillate, or others are as near".to_owned());
    }
    let words = |found| exponents::in_words(linearized, found, zero_modes);
    Ok(found.map(|found| NormalModes { method: Some(method), ..words(found) }))
}

/// M and K where they are worth being sparse for so many modes, or `must` be; else why they are not.
fn matrices(
    linearized: &Linearized,
    count: usize,
    must: bool,
    is_plain: bool,
) -> Result<(SparseMatrix, SparseMatrix), &'static str> {
    let n = linearized.dimension();
    let is_full = |matrix: &SparseMatrix| !must && matrix.stored().saturating_mul(2 * SPARSE) > n * n;
    // Sums of many terms are added up where they belong.
    let (mass, stiffness) = if !must && !linearized.is_reduced() && linearized.shares() > (n * n) as u64 {
        let mass = SparseMatrix::from_dense(n, &linearized.mass());
        if is_full(&mass) {
            return Err("M is full");
        }
        (mass, SparseMatrix::from_dense(n, &linearized.stiffness()))
    } else {
        linearized.sparse().ok_or("there are constraints or massless coordinates")?
    };
    match is_full(&mass) || is_full(&stiffness) && (!is_plain || count.saturating_mul(2 * FEW) > n) {
        true => Err("more than an eighth of their entries are not 0"),
        false => Ok((mass, stiffness)),
    }
}

/// Whether the energy, which friction takes from at most, is proved to bound all motions. `false` where that is not known.
pub(super) fn is_bound(linearized: &Linearized) -> bool {
    let is_left = match linearized.structure() {
        Structure::Conservative | Structure::Gyroscopic => true,
        Structure::Damped | Structure::Circulatory => linearized.is_passive(),
    };
    is_left
        && linearized.units().is_none()
        && linearized.sparse_velocity()[1].stored() == 0
        && linearized.sparse().is_some_and(|(mass, stiffness)| is_definite(&stiffness, &mass))
}

/// M, D and S as sparse matrices; `None` under constraints, where massless coordinates follow the others, and in units of their own.
#[must_use]
pub fn sparse_quadratic(linearized: &Linearized) -> Option<SparseQuadratic> {
    let (mass, stiffness) = linearized.sparse().filter(|_| linearized.units().is_none())?;
    Some(quadratic(linearized, (mass, &stiffness), linearized.sparse_velocity()))
}

fn quadratic(
    linearized: &Linearized,
    (mass, stiffness): (SparseMatrix, &SparseMatrix),
    [velocity, circulatory]: [SparseMatrix; 2],
) -> SparseQuadratic {
    let undamped = linearized.structure() == Structure::Gyroscopic;
    SparseQuadratic {
        mass,
        velocity,
        stiffness: stiffness.mirrored().plus(&circulatory),
        undamped,
        symmetric: undamped || circulatory.stored() == 0,
        passive: linearized.is_passive(),
    }
}

/// The same with what goes with velocities; `None` where these are not found, or lack digits.
///
/// # Errors
/// Where the budget is spent, and where they are not found but `must` be.
fn some_exponents(
    linearized: &Linearized,
    problem: &SparseQuadratic,
    wanted: Wanted<'_>,
    (options, must): (&Options, bool),
) -> Result<Option<NormalModes>, LinearizeError> {
    let budget = linearized.model().pool.budget();
    let found = solve_sparse_quadratic(problem, wanted, options, budget);
    budget.check()?;
    // Whether a growth is 0 no bounds decide.
    let is_done = |own: &Exponents| {
        let mut limits = own.entries.iter().filter(|entry| !entry.growth.contains_zero()).map(|entry| entry.limit);
        limits.all(|limit| limit.is_none())
    };
    match found.filter(|found| must || is_done(found)) {
        Some(found) => {
            let method = Some(Method::Arnoldi);
            Ok(Some(NormalModes { method, ..exponents::in_words(linearized, found, Vec::new()) }))
        }
        None if must => {
            let n = linearized.dimension();
            let reason = format!(
                "the modes that are wanted of {n} coordinates are not proved to be all: motions may be unstable or free, or others are as \
                 near; `--near OMEGA --count K` finds those next to a frequency"
            );
            Err(LinearizeError::NoModes { reason })
        }
        None => Ok(None),
    }
}

/// A spectrum with names and classes.
fn in_words(
    linearized: &Linearized,
    problem: &SparseProblem,
    (spectrum, method): (Spectrum, Method),
    zero_modes: Vec<ZeroMode>,
    options: &Options,
) -> NormalModes {
    let n = linearized.dimension();
    let labels =
        has_shapes(n, options).then(|| symmetry::labels(linearized, &problem.mass, &problem.stiffness)).flatten();
    let mut modes = with_names(linearized, spectrum, labels, zero_motions(zero_modes), options);
    modes.method = Some(method);
    modes
}

/// All modes, but for what [`Options::lowest`] leaves out, where M is diagonal and K tridiagonal and bounds tell them apart; `None` elsewhere.
///
/// # Errors
/// Where the vectors need more memory than there is.
fn all_modes(linearized: &Linearized, options: &Options) -> Result<Option<NormalModes>, LinearizeError> {
    let n = linearized.dimension();
    let budget = linearized.model().pool.budget();
    let is_narrow = (DENSE + 1..=MOST_COORDINATES).contains(&n) && linearized.shares() <= (8 * n) as u64;
    let Some((mass, stiffness)) = is_narrow.then(|| linearized.sparse()).flatten() else { return Ok(None) };
    budget.room(n, 8 * n)?;
    budget.tell(|| structure(&mass, &stiffness));
    let problem = SparseProblem { mass, stiffness };
    let inner = Options { vectors: has_shapes(n, options), ..options.clone() };
    let mut zero_modes = Vec::new();
    let mut zero_vectors = || -> Vec<Vec<Ball>> {
        zero_modes = linearized.zero_modes();
        zero_modes.iter().map(|mode| mode.vector.clone()).collect()
    };
    let Some(mut spectrum) = solve_tridiagonal(&problem, &mut zero_vectors, &inner) else { return Ok(None) };
    budget.tell(|| {
        "solver: twisted factorizations for all eigenvalues, since M is diagonal and K tridiagonal".to_owned()
    });
    spectrum.modes.truncate(options.lowest.filter(|_| options.near.is_none()).unwrap_or(n));
    Ok(Some(in_words(linearized, &problem, (spectrum, Method::Tridiagonal), zero_modes, options)))
}

/// What the matrices look like, in words.
fn structure(mass: &SparseMatrix, stiffness: &SparseMatrix) -> String {
    let n = mass.dimension();
    let form = |matrix: &SparseMatrix| match matrix.bandwidth() {
        0 => "diagonal".to_owned(),
        1 => "tridiagonal".to_owned(),
        _ if matrix.stored() == n * (n + 1) / 2 => "full".to_owned(),
        width => format!("sparse, entries up to {width} from the diagonal"),
    };
    let entries = |matrix: &SparseMatrix| 2 * matrix.stored() - matrix.entries().filter(|(i, j, _)| i == j).count();
    format!(
        "structure: {n} coordinates; M {}, {} entries; K {}, {} entries",
        form(mass),
        entries(mass),
        form(stiffness),
        entries(stiffness)
    )
}

fn not_found(n: usize, given: bool) -> LinearizeError {
    let reason = if given {
        "the vectors are not shown to span a whole part of the spectrum: they are not independent, too far from those of modes, or \
         leave out some mode between the lowest and the highest of theirs"
            .to_owned()
    } else {
        format!(
            "the requested modes of {n} coordinates are not separated from the others: ask for more or fewer, or use units in which M and K \
             are between 1e-90 and 1e90"
        )
    };
    LinearizeError::NoModes { reason }
}
