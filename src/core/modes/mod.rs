//! Normal modes of M q̈ + K q = 0: frequencies with proved bounds, and mode shapes.
//!
//! The stage takes two symmetric matrices whose entries are enclosures of exact numbers, and
//! returns every eigenvalue of K x = ω² M x in an interval that holds it for all matrices in the
//! enclosures (`levels`): eigenvectors in doubles (`start`), both forms in their basis computed
//! with error bounds, in products of doubles where the problem is large (`quick`), else in
//! double-double (`pencil`), enclosures of all eigenvalues (`certify`); where
//! they do not cover the wanted digits, or eigenvalues are not separated, better eigenvectors
//! (`refine`) and again. Where double-double has no more to give, the same loop goes on with matrices
//! and columns of as many bits as it takes (`precise`).
//!
//! It never sees a name or an expression, and never takes something small for zero: a zero mode
//! comes from a vector that the caller has proved to lie in the kernel of K.

mod certify;
mod dense;
pub mod exponents;
mod image;
mod levels;
mod pencil;
mod precise;
mod product;
mod quick;
mod refine;
mod shape;
mod slices;
mod sparse;
mod spectrum;
mod start;

use std::sync::Arc;

use thiserror::Error;

use crate::precision::{Ball, Big, Enclosure, Function, Rounding};
use crate::worded;

use dense::Matrix;
use levels::{Certificate, Gram, Solution, covered, first, refined};
use pencil::{Scaled, ZeroSpace};
use precise::Precisely;
pub use shape::orient;
pub(crate) use shape::{leading, signed};
pub(crate) use sparse::keep_nearest;
pub use sparse::{
    Method, SparseProblem, SparseQuadratic, SparseResponse, Wanted, is_definite, solve_sparse, solve_sparse_quadratic,
    solve_tridiagonal,
};
use spectrum::spectrum;

/// K x = ω² M x, with entries that enclose those of the exact matrices.
#[derive(Clone, Debug)]
pub struct Problem<T = Ball> {
    /// The number of coordinates, n.
    pub dimension: usize,
    /// The mass matrix, n by n, column by column; symmetric (the lower triangle is read).
    pub mass: Vec<T>,
    /// The stiffness matrix, likewise.
    pub stiffness: Vec<T>,
    /// Linearly independent vectors proved to lie in the kernel of the exact stiffness matrix, each
    /// number enclosing the exact component. Every one gives a mode with frequency 0, exactly.
    pub zero_vectors: Vec<Vec<T>>,
}

/// The same with any number of bits.
pub type PreciseProblem = Problem<Big>;

/// What is asked for: all modes with their shapes to ten digits, unless told otherwise.
///
/// ```
/// use librate::modes::Options;
/// let options = Options::default().lowest(5).digits(15);
/// assert!(options.vectors);
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
#[must_use]
pub struct Options {
    /// Whether mode shapes are wanted.
    pub vectors: bool,
    /// How many modes are wanted, counted in the order of [`Spectrum::modes`]; `None`: all.
    pub lowest: Option<usize>,
    /// Only modes next to a frequency: this one in rad/s, and how many; in the usual order.
    pub near: Option<(f64, usize)>,
    /// Vectors to be given bounds, n entries each, one after the other: the modes that they approximate are not searched for, only proved.
    /// For T and V alone, without constraints.
    pub given: Option<Arc<[f64]>>,
    /// How many correctly rounded significant digits the frequencies shall have.
    pub digits: usize,
    /// So many threads may be used, where some modes of a sparse model are wanted; the bits do not depend on it.
    pub threads: usize,
    /// What is printed is 2^power times what is found: which roundings are close depends on it.
    pub(crate) power: i64,
}

impl Default for Options {
    fn default() -> Self {
        Self { vectors: true, lowest: None, near: None, given: None, digits: 10, threads: 1, power: 0 }
    }
}

impl Options {
    /// For numbers that are 2^power times smaller still.
    pub(crate) fn smaller(&self, power: i64) -> Self {
        Self { power: self.power + power, ..self.clone() }
    }

    /// Whether a number, or the root of its absolute value, has all digits as they are printed, correctly rounded, with three to
    /// spare for what is derived.
    pub(crate) fn covers<S: Enclosure>(&self, x: &S, root: bool) -> bool {
        let missing = x.radius_magnitude().log2() - x.abs_upper_magnitude().log2()
            + (self.digits as f64 + 3.0) * std::f64::consts::LOG2_10;
        if missing > 0.0 || !(x.is_positive() || x.is_negative()) {
            return false;
        }
        // In doubles, if they can tell: 10^12 has a spacing of 1e-4.
        if self.digits <= 12 {
            let size = if root { x.mid_f64().abs().sqrt() } else { x.mid_f64().abs() };
            let printed = Ball::exact(size).scale_far(self.power).mid_f64();
            let place = 10f64.powi((self.digits as i32 - 1).saturating_sub(printed.log10().floor() as i32));
            let fraction = (printed * place).fract();
            if printed.log10().abs() < 200.0 && (fraction - 0.5).abs() > 2e-3 {
                return true;
            }
        }
        if root { self.decides(&x.apply(Function::Abs).sqrt()) } else { self.decides(x) }
    }

    /// Whether the bound of a number decides its rounding to all digits.
    fn decides<S: Enclosure>(&self, number: &S) -> bool {
        number.unrounded(BITS_OF_BALLS).scale(self.power).decimal(self.digits).rounding == Rounding::Correct
    }

    /// Frequencies only: shapes cost as much again.
    pub fn without_vectors(mut self) -> Self {
        self.vectors = false;
        self
    }

    /// Only the so many first modes in the order of [`Spectrum::modes`].
    pub fn lowest(mut self, count: usize) -> Self {
        self.lowest = Some(count);
        self
    }

    /// Only the so many modes whose frequencies are nearest to this one, in rad/s.
    pub fn near(mut self, omega: f64, count: usize) -> Self {
        self.near = Some((omega, count));
        self
    }

    crate::choices! {
        /// So many correctly rounded significant digits of every frequency.
        digits: usize,
        /// On up to so many threads.
        threads: usize,
    }
}

/// A ball has no more bits than these, but for zeros between its two parts.
const BITS_OF_BALLS: usize = 192;

/// All modes that were asked for.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Spectrum {
    /// Unstable modes by falling growth, then proved zeros, then by rising ω².
    pub modes: Vec<Mode>,
    /// What all modes together, asked for or not, say about stability.
    pub stability: Stability,
    /// The highest precision level that any of the numbers comes from.
    pub level: PrecisionLevel,
}

worded! {
/// The arithmetic that numbers come from, from the cheapest to the most expensive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
PrecisionLevel {
    /// Eigenvectors of doubles as they are; only quotients and residuals are more precise.
    Doubles "doubles",
    /// Eigenvectors of doubles, refined in double-double.
    Refined "double-double refinement",
    /// Cholesky factor of M and reduction of K in double-double from the start: M is not positive definite in
    /// doubles, or their eigenvectors are of no use.
    DoubleDouble "full double-double",
    /// As many bits as it takes; only the modes that need it have [`Mode::precise`].
    Precise "arbitrary precision",
}
/// In words: `doubles`, `double-double refinement`, …
as_str
}

/// One normal mode.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Mode {
    /// What kind of motion it is.
    pub kind: Kind,
    /// ω², negative for an unstable mode.
    pub omega_squared: Ball,
    /// The frequency, in radians per unit of time; 0 for an unstable mode.
    pub omega: Ball,
    /// The rate of growth √(-ω²) of an unstable mode; 0 for any other.
    pub growth: Ball,
    /// The same numbers to more digits, where a ball does not hold as many as were asked for.
    pub precise: Option<Box<Precise>>,
    /// The mode shape x with xᵀMx = 1, empty if not asked for.
    pub vector: Vec<f64>,
    /// A bound of the error of each component of the vector. In a cluster: of the distance of the
    /// vector from the space that the exact eigenvectors of the cluster span.
    pub vector_error_bound: f64,
    /// Modes with the same number are not separated by the bounds: equal, or nearly so.
    pub cluster: u32,
}

/// The numbers of a mode at a precision beyond that of a [`Ball`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Precise {
    /// omega² - growth², which is ω² of a mode that oscillates or grows.
    pub omega_squared: Big,
    /// The frequency; 0 for an unstable mode.
    pub omega: Big,
    /// The rate of growth; 0 for a mode that oscillates.
    pub growth: Big,
}

impl Precise {
    fn complex(omega: Big, growth: Big) -> Self {
        Self { omega_squared: &(&omega * &omega) - &(&growth * &growth), omega, growth }
    }
}

worded! {
/// The kind of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
Kind {
    /// ω² > 0, and no growth.
    Oscillation "oscillation",
    /// ω² = 0, proved.
    Zero "zero",
    /// ω² < 0; with gyroscopic forces or friction: growth > 0.
    Unstable "unstable",
    /// Growth < 0 and ω > 0.
    Damped "damped",
    /// Growth < 0 and ω = 0.
    Overdamped "overdamped",
    /// The bound does not tell the sign of ω², of growth, or whether there is any.
    Undecided "undecided",
}
/// The word for it in tables and JSON: `oscillation`, `zero`, `unstable`, `damped`, `overdamped`,
/// `undecided`.
as_str
}

worded! {
/// Stability of the equilibrium in linear order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
Stability {
    /// All modes oscillate.
    Stable "stable",
    /// No mode grows, and there is a zero mode.
    Neutral "neutral",
    /// Some mode grows.
    Unstable "unstable",
    /// The bounds do not tell.
    Undecided "undecided",
}
/// The word for it in tables and JSON: `stable`, `neutral`, `unstable`, `undecided`.
as_str
}

worded! {
/// One of the matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
Which {
    /// M.
    Mass "mass",
    /// D = G + C, what multiplies velocities.
    Velocity "velocity",
    /// K, or S = K + N.
    Stiffness "stiffness",
}
/// What it is called in messages.
as_str
}

/// Why there is no spectrum, or there are no exponents.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ModesError {
    /// M is not positive definite, or not shown to be.
    #[error("the mass matrix is {}", if *.singular { "singular" } else { "indefinite" })]
    NotPositiveDefinite {
        /// A direction in which the kinetic energy is not positive; largest component 1.
        direction: Vec<f64>,
        /// Whether the kinetic energy vanishes along it as far as can be told; otherwise it is
        /// negative, proved.
        singular: bool,
    },
    /// M is not shown to be positive definite, where exponents are asked for.
    #[error("the mass matrix is not shown to be positive definite")]
    MassNotDecided,
    /// An entry is not a number or out of range.
    #[error("entry ({row}, {column}) of the {} matrix is not a finite number", .matrix.as_str())]
    NotFinite {
        /// The matrix.
        matrix: Which,
        /// The row, from 0.
        row: usize,
        /// The column, from 0.
        column: usize,
    },
    /// A matrix has the wrong number of entries.
    #[error("the {} matrix has {found} entries instead of {expected}", .matrix.as_str())]
    Shape {
        /// The matrix.
        matrix: Which,
        /// The square of the dimension.
        expected: usize,
        /// The number of entries.
        found: usize,
    },
    /// A zero vector is not in the kernel of the stiffness matrix, depends on those before it, or has the wrong
    /// length.
    #[error("zero vector {index} is not an independent vector of the kernel of the stiffness matrix")]
    ZeroVector {
        /// Its number, from 0.
        index: usize,
    },
    /// The eigenvalue decomposition did not converge.
    #[error("the eigenvalue decomposition did not converge")]
    NoConvergence,
}

/// Where a problem comes from: what it can be asked for when its matrices do not tell enough.
///
/// Everything must describe the same exact matrices as [`Problem`] does. Nothing is asked for that is
/// not needed.
pub trait Source {
    /// Both matrices with entries of so many bits, and the zero vectors, in the same order: for more
    /// digits than double-double has, or problems that are too ill-conditioned for it.
    fn precisely(&self, _bits: usize) -> Option<PreciseProblem> {
        None
    }

    /// How zero vectors, M-orthonormal but for rounding, combine to bases of spaces in which they are to be told apart, as
    /// classes of symmetry: for each space the coefficients of each of its vectors. Nothing, if all are in one.
    fn zero_spaces(&self, _vectors: &[Vec<f64>]) -> Option<Vec<Vec<Vec<f64>>>> {
        None
    }
}

/// No source: the matrices are all there is.
impl Source for () {}

/// All modes of a problem.
///
/// # Errors
///
/// See [`ModesError`]; M must be positive definite, provably so.
pub fn solve(problem: &Problem, options: &Options) -> Result<Spectrum, ModesError> {
    solve_from(problem, &(), options)
}

/// All modes of a problem whose source can be asked for more where the matrices do not do.
///
/// # Errors
///
/// As [`solve`].
pub fn solve_from(problem: &Problem, source: &dyn Source, options: &Options) -> Result<Spectrum, ModesError> {
    let scaled = Scaled::new(problem)?;
    let n = scaled.n;
    if n == 0 {
        return Ok(Spectrum { modes: Vec::new(), stability: Stability::Stable, level: PrecisionLevel::Doubles });
    }
    if problem.zero_vectors.len() > n {
        return Err(ModesError::ZeroVector { index: n });
    }
    let vectors = problem.zero_vectors.iter().map(|vector| {
        let parts = vector.iter().zip(&scaled.shift).filter(|_| vector.len() == n);
        parts.map(|(x, s)| x.scale(-s)).collect()
    });
    let zero = match ZeroSpace::new(&scaled.mass, &scaled.stiffness, vectors.collect()) {
        Ok(zero) => zero,
        Err(index) => {
            // A bad mass matrix shows here too; it is the better message.
            first(&scaled, &Matrix::zeros(n, 0))?;
            return Err(ModesError::ZeroVector { index });
        }
    };
    let options = &options.smaller(i64::from(scaled.power / 2));
    let solution = Precisely { scaled: &scaled, zero: &zero, source }.further(options)?;
    Ok(spectrum(&scaled, (&zero, source), &solution, options))
}
