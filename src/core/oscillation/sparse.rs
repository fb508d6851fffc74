//! Some modes of a large model, from sparse matrices.

use super::{MOST_SHAPES_FOR_CLASSES, NormalModes, named, symmetry, with_names, zero_motions};
use crate::linearize::{LinearizeError, Linearized, MOST_COORDINATES, Structure};
use crate::modes::{Kind, Method, Options, SparseProblem, Spectrum, Wanted, solve_sparse};
use crate::precision::Ball;

/// Up to so many coordinates dense matrices are as fast.
const DENSE: usize = 300;
/// One mode in so many coordinates is few.
const FEW: usize = 8;
/// As one entry in so many is.
const SPARSE: usize = 8;

/// The modes that are asked for, where these are few of a large sparse model; `None` where dense matrices are to be used.
///
/// # Errors
/// Where there are too many coordinates for these, too, or an entry is not finite.
pub(super) fn some_modes(linearized: &Linearized, options: &Options) -> Result<Option<NormalModes>, LinearizeError> {
    let n = linearized.dimension();
    let is_plain = linearized.structure() == Structure::Conservative && linearized.units().is_none();
    let wanted = match (&options.given, options.near, options.lowest) {
        (Some(vectors), ..) => Some((Wanted::Given(vectors), vectors.len() / n.max(1))),
        (None, Some((omega, count)), _) => Some((Wanted::Near(omega, count), count)),
        (None, None, Some(count)) => Some((Wanted::Lowest(count), count)),
        (None, None, None) => None,
    };
    let given = options.given.is_some();
    if given && (!is_plain || linearized.is_constrained()) {
        return Err(LinearizeError::NoModes {
            reason: "vectors can be given bounds where there are T and V alone, without constraints".to_owned(),
        });
    }
    let Some((wanted, count)) = wanted.filter(|_| is_plain && (given || n > DENSE)) else {
        return Ok(None);
    };
    let must = given || n > MOST_COORDINATES;
    if !must && count.saturating_mul(FEW) > n {
        return Ok(None);
    }
    let Some((mass, stiffness)) = linearized.sparse() else {
        return Ok(None);
    };
    let stored = mass.stored().max(stiffness.stored());
    if !must && stored.saturating_mul(2 * SPARSE) > n * n {
        return Ok(None);
    }
    // Before it is taken: panels of eight vectors, or a basis of some more vectors than wanted; the rest is much less.
    let bytes = if stiffness.bandwidth().max(mass.bandwidth()) <= 1 {
        64 * (count / 8 + 4)
    } else {
        8 * (2 * count.min(n) + 64) + 48 * stored / n
    };
    linearized.model().pool.budget().room(n, bytes)?;
    let is_finite = |(_, _, value): (usize, usize, &Ball)| value.is_finite();
    if !(mass.entries().all(is_finite) && stiffness.entries().all(is_finite))
        && let Some(error) = linearized.not_finite()
    {
        return Err(error);
    }
    let inner = Options {
        lowest: None,
        near: None,
        given: None,
        vectors: options.vectors || n <= MOST_SHAPES_FOR_CLASSES,
        ..options.clone()
    };
    let problem = SparseProblem { mass, stiffness };
    let solved = |others: bool| -> Result<_, LinearizeError> {
        let mut zero_modes = Vec::new();
        let mut zero_vectors = || -> Vec<Vec<Ball>> {
            zero_modes = linearized.zero_modes_with(others);
            zero_modes.iter().map(|mode| mode.vector.clone()).collect()
        };
        let found = solve_sparse(&problem, wanted, &mut zero_vectors, &inner);
        Ok((found.map_err(|error| named(linearized, &error))?, zero_modes))
    };
    // A count of the eigenvalues below the lowest others tells whether symmetries explain all zeros, which is less work.
    let (mut found, mut zero_modes) = solved(false)?;
    let is_open = |(spectrum, _): &(Spectrum, Method)| spectrum.modes.iter().any(|mode| mode.kind == Kind::Undecided);
    if found.as_ref().is_none_or(is_open) {
        let with_others = solved(true)?;
        if with_others.1.len() > zero_modes.len() {
            (found, zero_modes) = with_others;
        }
    }
    let Some((spectrum, method)) = found else {
        return if must { Err(not_found(n, given)) } else { Ok(None) };
    };
    let is_done = |x: &Ball| x.is_zero() || options.covers(x, true);
    if !must && !spectrum.modes.iter().all(|mode| is_done(&mode.omega_squared)) {
        return Ok(None);
    }
    let labels = (inner.vectors && n <= symmetry::MOST_COORDINATES)
        .then(|| symmetry::labels(linearized, &linearized.mass(), &linearized.stiffness()))
        .flatten();
    let mut modes = with_names(linearized, spectrum, labels, zero_motions(zero_modes), options);
    modes.method = Some(method);
    Ok(Some(modes))
}

fn not_found(n: usize, given: bool) -> LinearizeError {
    let reason = if given {
        "the vectors are not shown to span a whole part of the spectrum: they are not independent, too far from those of modes, or \
         leave out some mode between the lowest and the highest of theirs"
            .to_owned()
    } else {
        format!(
            "the modes that are wanted of {n} coordinates are not separated from the others; ask for more or fewer of them"
        )
    };
    LinearizeError::NoModes { reason }
}
