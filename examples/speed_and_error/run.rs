//! Every path over every problem.

use std::error::Error;
use std::path::Path;

use librate::modes::PrecisionLevel;
use librate::number::Number;

use super::case::{Case, FAMILIES, HARD, MANY_DIGITS};
use super::clock::median;
use super::judge::{Judged, judge};
use super::large::LARGE;
use super::paths::{ASKED, Answer, Doubles, with_faer, with_jacobi, with_librate, with_nalgebra};
use super::peers::Peers;
use super::truth::Known;

/// What kind of tool a path is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Group {
    /// Textbook use of a solver in doubles.
    Doubles,
    /// The same in Python.
    Peer,
    Jacobi,
    /// librate, asked for so many digits.
    Librate(usize),
    /// Floating point of so many digits, without bounds.
    Mpmath(usize),
    /// Ball arithmetic of so many digits.
    Flint(usize),
}

pub(crate) struct PathInfo {
    pub(crate) label: &'static str,
    pub(crate) group: Group,
    /// The Python package that it takes.
    pub(crate) package: &'static str,
    pub(crate) what: &'static str,
}

const fn path(label: &'static str, group: Group, package: &'static str, what: &'static str) -> PathInfo {
    PathInfo { label, group, package, what }
}

pub(crate) const SCIPY: &str = "scipy eigh";
pub(crate) const FAER: &str = "faer";
pub(crate) const CHOLMOD: &str = "ARPACK with CHOLMOD";
pub(crate) const DEFAULT: &str = "librate, 10 digits";

pub(crate) const PATHS: [PathInfo; 18] = [
    path("nalgebra", Group::Doubles, "", "Cholesky factor of M, then `SymmetricEigen`"),
    path(FAER, Group::Doubles, "", "Cholesky factor of M, then `self_adjoint_eigen`"),
    path("numpy", Group::Peer, "numpy", "Cholesky factor of M, then `numpy.linalg.eigh`"),
    path(SCIPY, Group::Peer, "scipy", "`scipy.linalg.eigh(K, M)`: LAPACK's dsygvd"),
    path(
        "LAPACK tridiagonal",
        Group::Peer,
        "scipy",
        "`scipy.linalg.eigh_tridiagonal` (stemr; for some modes stebz and stein), chains only",
    ),
    path(
        "ARPACK",
        Group::Peer,
        "scipy",
        "`scipy.sparse.linalg.eigsh`, shift-invert with SuperLU: the lowest of sparse problems, ten where no number is given",
    ),
    path(CHOLMOD, Group::Peer, "scikit-sparse", "the same with CHOLMOD's Cholesky factor, of large models only"),
    path(
        "Jacobi on the factor",
        Group::Jacobi,
        "",
        "one-sided Jacobi rotations of A where K = A Aᵀ is known so; doubles, K never added up",
    ),
    path(DEFAULT, Group::Librate(10), "", "the default, with bounds"),
    path("librate, 15 digits", Group::Librate(15), "", "with bounds"),
    path("librate, 25 digits", Group::Librate(25), "", "with bounds"),
    path("librate, 50 digits", Group::Librate(50), "", "with bounds"),
    path("librate, 100 digits", Group::Librate(100), "", "with bounds"),
    path("mpmath, 30 digits", Group::Mpmath(30), "mpmath", "Cholesky factor of M, `mpmath.eigsy`, values only"),
    path("mpmath, 50 digits", Group::Mpmath(50), "mpmath", "the same"),
    path("mpmath, 100 digits", Group::Mpmath(100), "mpmath", "the same"),
    path("python-flint, 50 digits", Group::Flint(50), "python-flint", "`acb_mat.eig` of M⁻¹K in balls, values only"),
    path("python-flint, 100 digits", Group::Flint(100), "python-flint", "the same"),
];

/// What came of a path on a problem.
pub(crate) enum Verdict {
    Done(Outcome),
    /// It says that it can't.
    Failed(String),
    /// Not for this problem, not installed, or more digits than the true values are known to.
    Absent,
    /// Going by the size before, it would take longer than [`Plan::longest`].
    TooLong,
}

pub(crate) struct Outcome {
    pub(crate) seconds: f64,
    pub(crate) judged: Judged,
    pub(crate) certified: Option<Certified>,
}

/// What librate says of itself, and whether it holds.
pub(crate) struct Certified {
    pub(crate) level: PrecisionLevel,
    /// The largest bound of the relative error of a frequency; infinite where a sign is open.
    pub(crate) bound: f64,
    /// Bound by true error, the median over the frequencies.
    pub(crate) slack: Option<f64>,
    /// Whether every bound holds, and every zero is one.
    pub(crate) holds: bool,
    /// Whether every bound covers the digits that were asked for.
    pub(crate) covered: bool,
}

pub(crate) struct Measured {
    pub(crate) name: String,
    pub(crate) n: usize,
    pub(crate) zeros: usize,
    pub(crate) family: Option<&'static str>,
    /// One for each of [`PATHS`].
    pub(crate) verdicts: Vec<Verdict>,
}

impl Measured {
    pub(crate) fn verdict(&self, label: &str) -> Option<&Verdict> {
        let at = PATHS.iter().position(|path| path.label == label)?;
        self.verdicts.get(at)
    }

    pub(crate) fn of(&self, label: &str) -> Option<&Outcome> {
        match self.verdict(label)? {
            Verdict::Done(outcome) => Some(outcome),
            Verdict::Failed(_) | Verdict::Absent | Verdict::TooLong => None,
        }
    }
}

/// Everything that was measured.
pub(crate) struct Report {
    pub(crate) measured: Vec<Measured>,
    /// Versions of the peers, or why there are none.
    pub(crate) peers: Result<Vec<(String, Option<String>)>, String>,
    /// The path that times are compared with.
    pub(crate) unit: &'static str,
}

impl Report {
    pub(crate) fn new(measured: Vec<Measured>, unit: &'static str, peers: &Result<Peers, String>) -> Self {
        Self { measured, unit, peers: peers.as_ref().map(|p| p.versions.clone()).map_err(Clone::clone) }
    }

    pub(crate) fn hard(&self) -> impl Iterator<Item = &Measured> + Clone {
        self.measured.iter().filter(|m| m.family.is_none())
    }

    pub(crate) fn family<'a>(&'a self, slug: &'a str) -> impl Iterator<Item = &'a Measured> + Clone {
        self.measured.iter().filter(move |m| m.family == Some(slug))
    }

    /// What librate claims and is not so.
    pub(crate) fn violations(&self) -> Vec<String> {
        let mut wrong = Vec::new();
        for measured in &self.measured {
            for (label, _) in librate_paths() {
                let outcome = measured.of(label).and_then(|o| o.certified.as_ref());
                if outcome.is_some_and(|certified| !certified.holds) {
                    wrong.push(format!("{label} on {}", measured.name));
                }
            }
        }
        wrong
    }

    /// The time of a path by that of the reference call on the same problem.
    pub(crate) fn ratio(&self, measured: &Measured, label: &str) -> Option<f64> {
        let unit = measured.of(self.unit)?.seconds;
        Some(measured.of(label)?.seconds / unit)
    }
}

/// What is to be done.
pub(crate) struct Plan {
    pub(crate) hard: &'static [&'static str],
    /// The largest size of a family; 0: none.
    pub(crate) largest: usize,
    /// The largest of the large models; 0: none.
    pub(crate) largest_sparse: usize,
    /// Seconds that a call is repeated for.
    pub(crate) patience: f64,
    /// A call that takes longer than so many seconds is not made.
    pub(crate) longest: f64,
    /// The same for the large models.
    pub(crate) longest_sparse: f64,
}

impl Plan {
    pub(crate) const FULL: Self = Self {
        hard: HARD,
        largest: usize::MAX,
        largest_sparse: usize::MAX,
        patience: 0.15,
        longest: 20.0,
        longest_sparse: 120.0,
    };

    /// How many problems that are.
    pub(crate) fn len(&self) -> usize {
        let sizes = FAMILIES.iter().flat_map(|family| family.sizes);
        let large = LARGE.iter().map(|family| family.sizes(self.largest_sparse).count());
        self.hard.len() + sizes.filter(|n| **n <= self.largest).count() + large.sum::<usize>()
    }

    /// Runs everything; `tell` hears about each problem before it begins.
    ///
    /// # Errors
    /// Where a problem or its true values can't be had.
    pub(crate) fn run(
        &self,
        root: &Path,
        peers: &mut Result<Peers, String>,
        mut tell: impl FnMut(&str),
    ) -> Result<Report, Box<dyn Error>> {
        let mut measured = Vec::new();
        for name in self.hard {
            tell(name);
            let case = Case::hard(root, name)?;
            measured.push(self.measure(&case, None, None, peers));
        }
        for family in &FAMILIES {
            let mut before: Option<Measured> = None;
            for &n in family.sizes.iter().filter(|n| **n <= self.largest) {
                tell(&format!("{}, n = {n}", family.slug));
                let case = (family.make)(n).ok_or("the true values can't be had")?;
                let now = self.measure(&case, Some(family.slug), before.as_ref(), peers);
                measured.extend(before.replace(now));
            }
            measured.extend(before);
        }
        let has = |package| peers.as_ref().is_ok_and(|peers| peers.has(package));
        Ok(Report::new(measured, if has("scipy") { SCIPY } else { FAER }, peers))
    }

    fn measure(
        &self,
        case: &Case,
        family: Option<&'static str>,
        before: Option<&Measured>,
        peers: &mut Result<Peers, String>,
    ) -> Measured {
        if let Ok(some) = peers
            && let Err(error) = some.set(case)
        {
            *peers = Err(error);
        }
        let verdicts = PATHS.iter().enumerate().map(|(at, path)| {
            let expected = before.map(|before| match &before.verdicts[at] {
                Verdict::Done(outcome) => outcome.seconds * (case.n as f64 / before.n as f64).powi(3),
                Verdict::TooLong => f64::INFINITY,
                Verdict::Failed(_) | Verdict::Absent => 0.0,
            });
            if expected.is_some_and(|seconds| seconds > self.longest) {
                Verdict::TooLong
            } else {
                self.verdict(case, path, peers)
            }
        });
        Measured { verdicts: verdicts.collect(), name: case.name.clone(), n: case.n, zeros: case.zeros(), family }
    }

    fn verdict(&self, case: &Case, path: &PathInfo, peers: &mut Result<Peers, String>) -> Verdict {
        // True values have to be known better than what is held against them.
        let known = |digits: usize| digits + 5 <= case.known.digits;
        match path.group {
            Group::Doubles if path.label == FAER => doubles(case, with_faer(case, self.patience)),
            Group::Doubles => doubles(case, with_nalgebra(case, self.patience)),
            Group::Jacobi => with_jacobi(case, self.patience).map_or(Verdict::Absent, |result| doubles(case, result)),
            Group::Librate(digits) if known(digits) => match with_librate(case, digits, self.patience) {
                Ok(answer) => Verdict::Done(certified(&case.known, answer, digits)),
                Err(error) => Verdict::Failed(error),
            },
            Group::Mpmath(digits) | Group::Flint(digits)
                if known(digits) && case.n <= MANY_DIGITS && case.texts.is_some() =>
            {
                self.peer(&case.known, path, peers)
            }
            Group::Librate(_) | Group::Mpmath(_) | Group::Flint(_) => Verdict::Absent,
            Group::Peer => {
                let fits = match path.label {
                    "LAPACK tridiagonal" => case.is_chain() && case.n > 1,
                    "ARPACK" => case.is_sparse() && case.n > 20,
                    CHOLMOD => false,
                    _ => true,
                };
                if fits { self.peer(&case.known, path, peers) } else { Verdict::Absent }
            }
        }
    }

    /// What a peer makes of the problem that was set last.
    pub(crate) fn peer(&self, known: &Known, path: &PathInfo, peers: &mut Result<Peers, String>) -> Verdict {
        let Ok(peers) = peers else {
            return Verdict::Absent;
        };
        if !peers.has(path.package) {
            return Verdict::Absent;
        }
        plain(known, peers.run(path.label, self.patience))
    }
}

fn doubles(case: &Case, result: Doubles) -> Verdict {
    let exact = |values: Vec<f64>| values.into_iter().map(Number::from_f64_exact).collect::<Option<Vec<Number>>>();
    plain(&case.known, result.map(|(seconds, values)| (seconds, exact(values).unwrap_or_default())))
}

/// What is said without bounds, held against the truth.
fn plain(known: &Known, result: Result<(f64, Vec<Number>), String>) -> Verdict {
    match result {
        Ok((seconds, values)) => {
            Verdict::Done(Outcome { seconds, judged: judge(&values, &known.values, known.digits), certified: None })
        }
        Err(error) => Verdict::Failed(error),
    }
}

/// What librate says, held against the truth.
pub(crate) fn certified(known: &Known, answer: Answer, digits: usize) -> Outcome {
    let mids: Vec<Number> = answer.values.iter().map(|x| x.mid.clone()).collect();
    let judged = judge(&mids, &known.values, known.digits);
    let pairs = || answer.values.iter().zip(&known.values);
    let holds = answer.values.len() == known.values.len()
        && pairs().all(|(value, truth)| {
            let open = value.bound().is_none() && !value.radius.is_zero();
            value.holds(truth, known.digits) && (open || value.mid.is_zero() == truth.is_zero())
        });
    let bounds: Vec<f64> = pairs()
        .filter(|(_, truth)| !truth.is_zero())
        .map(|(value, _)| value.bound().unwrap_or(f64::INFINITY))
        .collect();
    let bound = bounds.iter().copied().fold(0.0, f64::max);
    let slack = bounds
        .iter()
        .zip(&judged.errors)
        .filter(|(_, error)| **error > 0.0)
        .map(|(bound, error)| bound / error)
        .collect();
    Outcome {
        seconds: answer.seconds,
        certified: Some(Certified {
            level: answer.level,
            bound,
            slack: median(slack),
            holds,
            covered: bound <= 0.5 * 10f64.powi(-(digits as i32)),
        }),
        judged,
    }
}

/// librate's paths with the digits that they are asked for.
pub(crate) fn librate_paths() -> impl Iterator<Item = (&'static str, usize)> {
    PATHS.iter().filter_map(|path| match path.group {
        Group::Librate(digits) if ASKED.contains(&digits) => Some((path.label, digits)),
        _ => None,
    })
}
