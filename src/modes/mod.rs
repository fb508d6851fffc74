//! Normal modes of M q̈ + K q = 0: frequencies with proved bounds, and mode shapes.
//!
//! The stage takes two symmetric matrices whose entries are enclosures of exact numbers, and
//! returns every eigenvalue of K x = ω² M x in an interval that holds it for all matrices in the
//! enclosures. The ladder: eigenvectors in doubles (`start`), both forms in their basis computed
//! in double-double with error bounds (`pencil`), enclosures of all eigenvalues (`certify`); where
//! they do not cover the wanted digits, or eigenvalues are not separated, better eigenvectors
//! (`refine`) and again. Where double-double has no more to give, the same loop goes on with matrices
//! and columns of as many bits as it takes (`precise`).
//!
//! It never sees a name or an expression, and never takes something small for zero: a zero mode
//! comes from a vector that the caller has proved to lie in the kernel of K.

mod certify;
mod dense;
mod factored;
mod image;
mod pencil;
mod precise;
mod quick;
mod refine;
mod shape;
mod start;

use thiserror::Error;

use crate::precision::{Ball, Big, DoubleDouble, Rounding, decimal};
use certify::{Cluster, Couplings, certify};
use dense::Matrix;
use factored::Factored;
pub use factored::Factors;
use pencil::{Pencil, Scaled, ZeroSpace, couplings, pencil};
pub use precise::{Precise, PreciseProblem};
use quick::{Quick, Round};
use start::Failure;

/// Most rounds of refinement; each squares the error, so that more do not help.
const ROUNDS: usize = 6;

/// K x = ω² M x.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The number of coordinates, n.
    pub dimension: usize,
    /// The mass matrix, n by n, column by column; symmetric (the lower triangle is read).
    pub mass: Vec<Ball>,
    /// The stiffness matrix, likewise.
    pub stiffness: Vec<Ball>,
    /// Linearly independent vectors proved to lie in the kernel of the exact stiffness matrix, each
    /// ball enclosing the exact component. Every one gives a mode with frequency 0, exactly.
    pub zero_vectors: Vec<Vec<Ball>>,
}

/// What is asked for: all modes with their shapes to ten digits, unless told otherwise.
///
/// ```
/// use librate::modes::Options;
/// let options = Options::default().lowest(5).digits(15);
/// assert!(options.vectors);
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Options {
    /// Whether mode shapes are wanted.
    pub vectors: bool,
    /// How many modes are wanted, counted in the order of [`Spectrum::modes`]; `None`: all.
    pub lowest: Option<usize>,
    /// How many correctly rounded significant digits the frequencies shall have.
    pub digits: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            vectors: true,
            lowest: None,
            digits: 10,
        }
    }
}

impl Options {
    /// Frequencies only: shapes cost as much again.
    #[must_use]
    pub fn without_vectors(mut self) -> Self {
        self.vectors = false;
        self
    }

    /// Only the so many first modes in the order of [`Spectrum::modes`].
    #[must_use]
    pub fn lowest(mut self, count: usize) -> Self {
        self.lowest = Some(count);
        self
    }

    /// So many correctly rounded significant digits of every frequency.
    #[must_use]
    pub fn digits(mut self, count: usize) -> Self {
        self.digits = count;
        self
    }
}

/// All modes that were asked for.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Spectrum {
    /// Unstable modes by falling growth, then proved zeros, then by rising ω².
    pub modes: Vec<Mode>,
    /// What all modes together, asked for or not, say about stability.
    pub stability: Stability,
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

/// The kind of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Kind {
    /// ω² > 0.
    Oscillation,
    /// ω² = 0, proved.
    Zero,
    /// ω² < 0.
    Unstable,
    /// The bound does not tell the sign of ω².
    Undecided,
}

/// Stability of the equilibrium in linear order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Stability {
    /// All modes oscillate.
    Stable,
    /// No mode grows, and there is a zero mode.
    Neutral,
    /// Some mode grows.
    Unstable,
    /// The bounds do not tell.
    Undecided,
}

impl Kind {
    /// The word for it in tables and JSON: `oscillation`, `zero`, `unstable`, `undecided`.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Oscillation => "oscillation",
            Self::Zero => "zero",
            Self::Unstable => "unstable",
            Self::Undecided => "undecided",
        }
    }
}

impl Stability {
    /// The word for it in tables and JSON: `stable`, `neutral`, `unstable`, `undecided`.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Neutral => "neutral",
            Self::Unstable => "unstable",
            Self::Undecided => "undecided",
        }
    }
}

/// One of the two matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Which {
    /// M.
    Mass,
    /// K.
    Stiffness,
}

impl std::fmt::Display for Which {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Mass => "mass",
            Self::Stiffness => "stiffness",
        })
    }
}

/// Why there is no spectrum.
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
    /// An entry is not a number or out of range.
    #[error("entry ({row}, {column}) of the {matrix} matrix is not a finite number")]
    NotFinite {
        /// The matrix.
        matrix: Which,
        /// The row, from 0.
        row: usize,
        /// The column, from 0.
        column: usize,
    },
    /// A matrix has the wrong number of entries.
    #[error("the {matrix} matrix has {found} entries instead of {expected}")]
    Shape {
        /// The matrix.
        matrix: Which,
        /// The square of the dimension.
        expected: usize,
        /// The number of entries.
        found: usize,
    },
    /// A zero vector is not in the kernel of K, depends on those before it, or has the wrong
    /// length.
    #[error(
        "zero vector {index} is not an independent vector of the kernel of the stiffness matrix"
    )]
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
    /// The stiffness matrix as a sum of squares, if it is known as one.
    fn factors(&self) -> Option<Factors> {
        None
    }

    /// Both matrices with entries of so many bits, and the zero vectors, in the same order: for more
    /// digits than double-double has, or problems that are too ill-conditioned for it.
    fn precisely(&self, _bits: usize) -> Option<PreciseProblem> {
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
pub fn solve_from(
    problem: &Problem,
    source: &dyn Source,
    options: &Options,
) -> Result<Spectrum, ModesError> {
    let scaled = Scaled::new(problem)?;
    let n = scaled.n;
    if n == 0 {
        return Ok(Spectrum {
            modes: Vec::new(),
            stability: Stability::Stable,
        });
    }
    if problem.zero_vectors.len() > n {
        return Err(ModesError::ZeroVector { index: n });
    }
    let zero = match ZeroSpace::new(&scaled, &problem.zero_vectors) {
        Ok(zero) => zero,
        Err(index) => {
            // A bad mass matrix shows here too; it is the better message.
            let plain = Matrix::zeros(n, 0);
            first(&scaled, &plain)?;
            return Err(ModesError::ZeroVector { index });
        }
    };
    let below = |options: &Options| climb(&scaled, &zero, source, options);
    let solution = precise::further(&scaled, &zero, &below, source, options)?;
    Ok(spectrum(&scaled, &zero, &solution, options))
}

/// From this dimension on most of the work is left to doubles (`quick`): as fast at 60, three times as fast
/// at 228 (benches/modes.rs, `chains`).
const QUICK: usize = 60;

/// Slices of a dense matrix: 84 bits or more, which tell residuals apart from rounding and leave ten
/// digits of eigenvalues a millionth of the largest, or all of a double-double.
const SLICES: [usize; 2] = [4, 6];

/// How accurate shapes have to be.
const SHAPES: f64 = 1e-12;

/// Certified columns.
struct Solution {
    x: Matrix,
    gram: Gram,
    /// A bound, for each column, of the M-length of its part along the zero vectors.
    leak: Vec<f64>,
    certificate: Certificate,
    /// Eigenvalues beyond double-double, by position; may end early.
    precise: Vec<Option<Big>>,
}

/// XᵀMX, in the form in which a rung leaves it.
enum Gram {
    Entries(pencil::Bounded),
    Factors(Box<Round>),
}

impl Gram {
    fn diagonal(&self, k: usize) -> Ball {
        match self {
            Self::Entries(g) => g.ball(k, k),
            Self::Factors(round) => round.norm(k),
        }
    }

    /// The entries of some columns, without bounds.
    fn block(&self, columns: &[usize]) -> Matrix {
        match self {
            Self::Factors(round) => round.gram(columns),
            Self::Entries(g) => {
                let mut block = Matrix::zeros(columns.len(), columns.len());
                for (q, &j) in columns.iter().enumerate() {
                    for (p, &i) in columns.iter().enumerate() {
                        block.set(p, q, g.mid.get(i, j));
                    }
                }
                block
            }
        }
    }
}

/// What is proved about the columns.
struct Certificate {
    /// The columns by rising eigenvalue.
    order: Vec<usize>,
    /// The eigenvalues by rising position: the k-th ball holds the k-th eigenvalue.
    eigenvalues: Vec<Ball>,
    /// The clusters by rising position; together they hold every position once.
    clusters: Vec<Cluster>,
}

impl Certificate {
    fn new(quotients: &[DoubleDouble], couplings: Couplings) -> Option<Self> {
        let enclosures = certify(&couplings)?;
        let order = couplings.order;
        let eigenvalues = order
            .iter()
            .zip(&enclosures.radii)
            .map(|(&column, &radius)| Ball::new(quotients[column], radius))
            .collect();
        Some(Self {
            order,
            eigenvalues,
            clusters: enclosures.clusters,
        })
    }
}

/// The first approximation, in doubles if they will do.
fn first(scaled: &Scaled, zero: &Matrix) -> Result<(Matrix, bool), ModesError> {
    match start::in_doubles(&scaled.mass.mid, &scaled.stiffness.mid, zero) {
        Ok(x) => Ok((x, false)),
        Err(Failure::NoConvergence) => Err(ModesError::NoConvergence),
        Err(Failure::NotPositiveDefinite(_)) => Ok((careful(scaled, zero)?, true)),
    }
}

fn careful(scaled: &Scaled, zero: &Matrix) -> Result<Matrix, ModesError> {
    match start::in_double_doubles(&scaled.mass.mid, &scaled.stiffness.mid, zero) {
        Ok(x) => Ok(x),
        Err(Failure::NoConvergence) => Err(ModesError::NoConvergence),
        Err(Failure::NotPositiveDefinite(direction)) => {
            let balls: Vec<Ball> = direction.into_iter().map(Ball::from).collect();
            Err(not_positive_definite(scaled, &balls))
        }
    }
}

fn not_positive_definite(scaled: &Scaled, direction: &[Ball]) -> ModesError {
    let singular = !scaled.mass.form(direction).is_negative();
    let physical: Vec<f64> = direction
        .iter()
        .zip(&scaled.shift)
        .map(|(x, &s)| x.mid.scale(s).hi)
        .collect();
    // Out of range the direction cannot be told; what is finite of it still points somewhere.
    let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
    let larger = |a: f64, &b: &f64| if finite(b).abs() > a.abs() { b } else { a };
    let largest = physical.iter().fold(0.0, larger);
    let direction = if largest == 0.0 {
        vec![1.0; physical.len()]
    } else {
        physical
            .iter()
            .map(|&x| finite(x) / largest + 0.0)
            .collect()
    };
    ModesError::NotPositiveDefinite {
        direction,
        singular,
    }
}

/// From doubles upwards until every digit that is wanted is covered, or nothing improves any more.
fn climb(
    scaled: &Scaled,
    zero: &ZeroSpace,
    source: &dyn Source,
    options: &Options,
) -> Result<Solution, ModesError> {
    let mut climb = Climb {
        scaled,
        zero,
        options,
        best: None,
    };
    let (mut x, careful) = first(scaled, &zero.mid)?;
    if scaled.n >= QUICK && !careful {
        match quick(scaled, zero, options, &x) {
            Tried::Satisfied(solution) => return Ok(*solution),
            Tried::Improved(better) => x = better,
        }
    }
    let failed = match climb.rounds(None, x, careful) {
        Ok(true) => None,
        Ok(false) => Some(ModesError::NoConvergence),
        Err(error) => Some(error),
    };
    // The same once more with energies in place of entries.
    if failed.is_some()
        && let Some(factors) = source.factors()
    {
        let factored = Factored::new(scaled, &factors)?;
        let columns = scaled.n - zero.mid.columns;
        let start = factored.singular_vectors(scaled, columns);
        let x = match (start, &climb.best) {
            (Some(x), _) => x,
            (None, Some((_, solution))) => solution.x.clone(),
            (None, None) => self::careful(scaled, &zero.mid)?,
        };
        // What has been found so far still stands if this finds nothing.
        let _ = climb.rounds(Some(&factored), x, true);
    }
    match (climb.best, failed) {
        (Some((_, solution)), _) => Ok(solution),
        (None, Some(error)) => Err(error),
        (None, None) => Err(ModesError::NoConvergence),
    }
}

/// The best columns so far, with their score.
struct Climb<'a> {
    scaled: &'a Scaled,
    zero: &'a ZeroSpace,
    options: &'a Options,
    best: Option<(f64, Solution)>,
}

impl Climb<'_> {
    /// Refines from x on, in double-double; whether everything that is wanted is covered.
    fn rounds(
        &mut self,
        factored: Option<&Factored>,
        mut x: Matrix,
        mut tried_careful: bool,
    ) -> Result<bool, ModesError> {
        let (scaled, zero, options) = (self.scaled, self.zero, self.options);
        let (mut before, mut idle) = (f64::INFINITY, 0);
        for round in 0..=ROUNDS {
            let pencil = pencil(scaled, factored, zero, &x);
            let certificate = couplings(&pencil)
                .and_then(|(quotients, couplings)| Certificate::new(&quotients, couplings));
            let Some(certificate) = certificate else {
                if before.is_finite() {
                    break;
                }
                if round == ROUNDS {
                    return Err(unproved(scaled, &pencil, &x));
                }
                if tried_careful {
                    x = refine::refine(&pencil, zero, &x);
                } else {
                    tried_careful = true;
                    x = careful(scaled, &zero.mid)?;
                }
                continue;
            };
            let satisfied = satisfied(&certificate, options, round);
            let score = score(&certificate, options);
            let next = (!satisfied && round < ROUNDS).then(|| refine::refine(&pencil, zero, &x));
            // Less than a few bits gained in all: double-double has nothing more to give. Graded
            // problems may lose a little first, while clusters are taken apart.
            idle = if score > before - 4.0 { idle + 1 } else { 0 };
            let stuck = idle > usize::from(factored.is_some());
            before = before.min(score);
            if satisfied || self.best.as_ref().is_none_or(|(best, _)| score <= *best) {
                let solution = Solution {
                    x,
                    gram: Gram::Entries(pencil.g),
                    leak: pencil.leak,
                    certificate,
                    precise: Vec::new(),
                };
                self.best = Some((score, solution));
            }
            match next {
                Some(next) if !stuck => x = next,
                _ => return Ok(satisfied),
            }
        }
        Ok(false)
    }
}

/// What the rung in doubles comes to.
enum Tried {
    Satisfied(Box<Solution>),
    /// Not everything that is wanted is covered; better columns than before.
    Improved(Matrix),
}

/// The rung in doubles: as long as refinement gains something.
fn quick(scaled: &Scaled, zero: &ZeroSpace, options: &Options, x: &Matrix) -> Tried {
    let quick = Quick::new(scaled, zero);
    let mut xt = x.transposed();
    let mut before = f64::INFINITY;
    for number in 0..=ROUNDS {
        let few = number == 0 || number == 1 && options.digits <= 12;
        let round = quick.round(xt, SLICES[usize::from(!few)]);
        // What doubles come to may be known to be too little for the shapes before it is certified.
        let step = (number == 0 && options.vectors)
            .then(|| refine::Step::new(&round, round.columns().rows))
            .filter(|step| step.size() > SHAPES);
        if let Some(step) = step {
            xt = refine::refine_rows(&quick, &round, &step);
            continue;
        }
        let certificate = round
            .couplings()
            .and_then(|couplings| Certificate::new(round.quotients(), couplings));
        let Some(certificate) = certificate else {
            return Tried::Improved(round.columns().transposed());
        };
        if satisfied(&certificate, options, number) {
            return Tried::Satisfied(Box::new(Solution {
                x: round.columns().transposed(),
                leak: round.leak().to_vec(),
                gram: Gram::Factors(Box::new(round)),
                certificate,
                precise: Vec::new(),
            }));
        }
        let score = score(&certificate, options);
        if score > before - 4.0 {
            return Tried::Improved(round.columns().transposed());
        }
        before = score;
        let step = refine::Step::new(&round, round.columns().rows);
        xt = refine::refine_rows(&quick, &round, &step);
    }
    Tried::Improved(xt.transposed())
}

/// M is positive definite as far as its midpoints go, but the bounds do not show it: the direction
/// of the column that is known worst.
fn unproved(scaled: &Scaled, pencil: &Pencil, x: &Matrix) -> ModesError {
    let worst = (0..x.columns)
        .max_by(|&i, &j| {
            pencil
                .g
                .radius
                .get(i, i)
                .total_cmp(&pencil.g.radius.get(j, j))
        })
        .unwrap_or(0);
    let direction: Vec<Ball> = (0..scaled.n)
        .map(|row| Ball::from(x.get(row, worst)))
        .collect();
    not_positive_definite(scaled, &direction)
}

/// The bits of all radii and vector errors together: what a round has gained shows here.
fn score(certificate: &Certificate, options: &Options) -> f64 {
    let values: f64 = certificate
        .eigenvalues
        .iter()
        .map(|x| (x.radius + 1e-300).log2())
        .sum();
    let vectors = certificate
        .clusters
        .iter()
        .map(|c| (shape::rough_error(c) + 1e-17).log2());
    if options.vectors {
        values + vectors.sum::<f64>()
    } else {
        values
    }
}

/// Whether the enclosures cover the wanted digits, and the vectors are good enough.
fn satisfied(certificate: &Certificate, options: &Options, round: usize) -> bool {
    let wanted = options.lowest.unwrap_or(usize::MAX);
    // Columns that are not separated in doubles may well be in double-double, and whether they are
    // in doubles depends on rounding errors: one round decides alike on every machine.
    let separated = |cluster: &Cluster| {
        cluster.start >= wanted
            || if cluster.len() == 1 {
                shape::rough_error(cluster) < SHAPES
            } else {
                round > 0
            }
    };
    if options.vectors && !certificate.clusters.iter().all(separated) {
        return false;
    }
    covered(certificate, options)
}

/// Whether the enclosures cover the wanted digits.
fn covered(certificate: &Certificate, options: &Options) -> bool {
    certificate
        .eigenvalues
        .iter()
        .take(options.lowest.unwrap_or(usize::MAX))
        .all(|x| covers(x, options.digits))
}

/// Whether √|x| has `digits` digits, correctly rounded, with two to spare for what is derived.
fn covers(x: &Ball, digits: usize) -> bool {
    if x.contains_zero() {
        return false;
    }
    let relative = x.radius / x.mid.hi.abs();
    if relative > 10f64.powi(-(digits.min(300) as i32) - 3) {
        return false;
    }
    // Near a tie the bound has to be narrower. In doubles, if they can tell: 10^12 has a spacing
    // of 1e-4.
    let root = x.mid.hi.abs().sqrt();
    if digits <= 12 {
        let place = 10f64.powi(digits as i32 - 1 - root.log10().floor() as i32);
        let fraction = (root * place).fract();
        if root.log10().abs() < 200.0 && (fraction - 0.5).abs() > 2e-3 {
            return true;
        }
    }
    decimal(&x.abs().sqrt(), digits).rounding == Rounding::Correct
}

/// The modes in printing order.
fn spectrum(scaled: &Scaled, zero: &ZeroSpace, solution: &Solution, options: &Options) -> Spectrum {
    let Solution {
        x,
        leak,
        certificate,
        precise,
        ..
    } = solution;
    let zeros = zero.vectors.len();
    let total = certificate.eigenvalues.len() + zeros;
    let wanted = options.lowest.unwrap_or(total).min(total);
    let unstable = certificate
        .eigenvalues
        .iter()
        .take_while(|x| x.is_negative())
        .count();
    let undecided = certificate
        .eigenvalues
        .iter()
        .filter(|x| x.contains_zero())
        .count();
    let stability = if unstable > 0 {
        Stability::Unstable
    } else if undecided > 0 {
        Stability::Undecided
    } else if zeros > 0 {
        Stability::Neutral
    } else {
        Stability::Stable
    };
    let mut modes = Vec::with_capacity(wanted);
    let mut zero_shapes = if options.vectors {
        shape::zero_shapes(scaled, zero)
    } else {
        Vec::new()
    }
    .into_iter();
    let errors = options
        .vectors
        .then(|| shape::Errors::new(leak, certificate, x));
    let mut number = 0;
    let mut put_zeros = |modes: &mut Vec<Mode>, number: &mut u32| {
        for _ in 0..zeros {
            let shape = zero_shapes.next();
            modes.push(mode(Ball::ZERO, None, Kind::Zero, shape, *number));
        }
        *number += u32::from(zeros > 0);
    };
    for (index, cluster) in certificate.clusters.iter().enumerate() {
        if cluster.start == unstable {
            put_zeros(&mut modes, &mut number);
        }
        if modes.len() >= wanted {
            break;
        }
        let own_number = number;
        number += 1;
        let columns = &certificate.order[cluster.start..cluster.end];
        let mut shapes = errors
            .as_ref()
            .map(|errors| shape::cluster_shapes(scaled, zero, solution, columns, errors, index))
            .unwrap_or_default()
            .into_iter();
        for position in cluster.start..cluster.end {
            if position == unstable && position > cluster.start {
                put_zeros(&mut modes, &mut number);
            }
            let value = certificate.eigenvalues[position].scale(scaled.power);
            let kind = if value.is_positive() {
                Kind::Oscillation
            } else if value.is_negative() {
                Kind::Unstable
            } else {
                Kind::Undecided
            };
            let precise = precise.get(position).and_then(Option::as_ref);
            let precise = precise.map(|x| x.scale(scaled.power.into()));
            modes.push(mode(value, precise, kind, shapes.next(), own_number));
        }
    }
    if unstable == certificate.eigenvalues.len() {
        put_zeros(&mut modes, &mut number);
    }
    modes.truncate(wanted);
    Spectrum { modes, stability }
}

fn mode(
    omega_squared: Ball,
    precise: Option<Big>,
    kind: Kind,
    shape: Option<shape::Shape>,
    cluster: u32,
) -> Mode {
    let (omega, growth) = match kind {
        Kind::Oscillation => (omega_squared.sqrt(), Ball::ZERO),
        Kind::Zero => (Ball::ZERO, Ball::ZERO),
        Kind::Unstable => (Ball::ZERO, (-omega_squared).sqrt()),
        Kind::Undecided => (omega_squared.sqrt(), (-omega_squared).sqrt()),
    };
    let (vector, vector_error_bound) =
        shape.map_or((Vec::new(), 0.0), |shape| (shape.vector, shape.error_bound));
    Mode {
        kind,
        omega_squared,
        omega,
        growth,
        precise: precise.map(|x| Box::new(Precise::new(x, kind))),
        vector,
        vector_error_bound,
        cluster,
    }
}
