//! Some modes of a large model, from sparse matrices.

use super::{MOST_SHAPES_FOR_CLASSES, NormalModes, named, symmetry, with_names, zero_motions};
use crate::linearize::{LinearizeError, Linearized, MOST_COORDINATES, Structure};
use crate::modes::{Kind, Method, Options, SparseProblem, Spectrum, Wanted, solve_sparse};
use crate::precision::{Ball, SparseMatrix};

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
    let budget = linearized.model().pool.budget();
    let dense = |why: &str| {
        budget.tell(|| format!("solver: dense matrices of {n} coordinates, since {why}"));
        Ok(None)
    };
    let given = options.given.is_some();
    let is_plain = linearized.structure() == Structure::Conservative && linearized.units().is_none();
    if given && (!is_plain || linearized.is_constrained()) {
        return Err(LinearizeError::NoModes {
            reason: "vectors can be given bounds where there are T and V alone, without constraints".to_owned(),
        });
    }
    let (wanted, count) = match (&options.given, options.near, options.lowest) {
        (Some(vectors), ..) => (Wanted::Given(vectors), vectors.len() / n.max(1)),
        (None, Some((omega, count)), _) => (Wanted::Near(omega, count), count),
        (None, None, Some(count)) => (Wanted::Lowest(count), count),
        (None, None, None) => return dense("all modes are wanted"),
    };
    let must = given || n > MOST_COORDINATES;
    if !is_plain {
        return dense("forces depend on velocities, or numbers are far from usual ones");
    } else if !given && n <= DENSE {
        return dense("they are as fast for so few");
    } else if !must && count.saturating_mul(FEW) > n {
        return dense("more than an eighth of the modes are wanted");
    }
    budget.at("the matrices", None);
    if !must && linearized.shares() > (n * n) as u64 {
        return dense("their entries are sums of many terms");
    }
    let Some((mass, stiffness)) = linearized.sparse() else {
        return dense("there are constraints");
    };
    budget.tell(|| structure(&mass, &stiffness));
    let stored = mass.stored().max(stiffness.stored());
    if !must && stored.saturating_mul(2 * SPARSE) > n * n {
        return dense("more than an eighth of their entries are not 0");
    }
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
            budget.at("the zero modes", None);
            zero_modes = linearized.zero_modes_with(others);
            budget.tell(|| {
                format!("zero modes: {} proved{}", zero_modes.len(), if others { "" } else { " by symmetries" })
            });
            zero_modes.iter().map(|mode| mode.vector.clone()).collect()
        };
        let found = solve_sparse(&problem, wanted, &mut zero_vectors, &inner, budget);
        budget.check()?;
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
        return if must { Err(not_found(n, given)) } else { dense("the modes that are wanted were not separated") };
    };
    let is_done = |x: &Ball| x.is_zero() || options.covers(x, true);
    if !must && !spectrum.modes.iter().all(|mode| is_done(&mode.omega_squared)) {
        return dense("bounds in double-double do not cover the digits");
    }
    let labels = (inner.vectors && n <= symmetry::MOST_COORDINATES)
        .then(|| symmetry::labels(linearized, &linearized.mass(), &linearized.stiffness()))
        .flatten();
    let mut modes = with_names(linearized, spectrum, labels, zero_motions(zero_modes), options);
    modes.method = Some(method);
    Ok(Some(modes))
}

/// What the matrices look like, in words.
fn structure(mass: &SparseMatrix, stiffness: &SparseMatrix) -> String {
    let form = |matrix: &SparseMatrix| match matrix.bandwidth() {
        0 => "diagonal".to_owned(),
        1 => "tridiagonal".to_owned(),
        width => format!("sparse, entries up to {width} from the diagonal"),
    };
    let n = mass.dimension();
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
            "the modes that are wanted of {n} coordinates are not separated from the others; ask for more or fewer of them"
        )
    };
    LinearizeError::NoModes { reason }
}
