//! Exponents of M q̈ + D q̇ + S q = 0: the λ with det(λ²M + λD + S) = 0, growth and frequency with proved bounds,
//! and their vectors.
//!
//! D = G + C and S = K + N: gyroscopic and damping forces, stiffness and what friction adds to it. Without
//! dissipation D is skew and S symmetric, and growth is exactly 0 where the exponents are on the imaginary axis.
//!
//! The precision levels are those of [`super`]: vectors and left vectors in doubles (`start`), residuals in
//! double-double (`columns`), couplings of the first-order pencil in their basis as magnitudes (`couplings`), discs
//! with a scaling per exponent that makes them quadratic in the residuals (`certify`); where they do not cover the
//! wanted digits of growth and frequency, better vectors; then the same with as many bits as it takes (`wide`).
//! Columns that are not separated are turned by the eigenvectors of their own block (`resolve`). What bounds can
//! never decide (whether a repeated exponent is one, whether a growth is 0) is decided by exact arithmetic where
//! the matrices are rational and small (`exact`), and else said to be open.
//!
//! It never sees a name or an expression, never takes something small for zero, and never pairs exponents by
//! their values: real and imaginary ones are those whose discs hold one exponent and meet no other disc
//! on the other side of the axis.

mod basis;
mod blocks;
mod certify;
mod columns;
mod complex;
mod couplings;
mod exact;
mod far;
mod polynomial;
mod repeated;
mod resolve;
mod scale;
mod shape;
mod signature;
mod solve;
mod spectrum;
mod start;
mod wide;

pub(crate) use exact::LARGEST as MOST_EXACT;
pub use solve::{exponents, exponents_without_inertia};
pub(crate) use spectrum::{finish, joined};

use faer::c64;

use super::{Kind, ModesError, Options, Precise, PrecisionLevel, Stability};
use crate::precision::{Ball, Big, Integers};

/// M q̈ + D q̇ + S q = 0.
#[derive(Clone, Debug)]
pub struct QuadraticProblem {
    /// The number of coordinates, n.
    pub dimension: usize,
    /// The mass matrix M, n by n, column by column; symmetric and positive definite.
    pub mass: Vec<Ball>,
    /// D = G + C, what multiplies velocities, likewise n by n.
    pub velocity: Vec<Ball>,
    /// S = K + N, what multiplies coordinates.
    pub stiffness: Vec<Ball>,
    /// What is known of the exact matrices beside their enclosures.
    pub structure: Structure,
    /// Linearly independent vectors proved to span the kernel of the exact S, each ball enclosing the exact
    /// component.
    pub zero_vectors: Vec<Vec<Ball>>,
    /// Which of these D is proved to take to 0 as well; those beyond are not known to.
    pub unmoved: Vec<bool>,
}

/// What is known of the exact matrices beside their enclosures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Structure {
    /// Nothing is damped: D is skew and S symmetric, exactly.
    Gyroscopic,
    /// D is 0, exactly; S may be anything: friction that acts at rest, and nothing that multiplies velocities.
    Circulatory,
    /// D and S are symmetric, exactly: friction, and neither gyroscopic forces nor friction that acts at rest.
    Symmetric,
    /// S is symmetric, exactly: no friction acts at rest.
    Dissipative,
    /// Anything.
    Damped,
}

/// M, D and S of a [`QuadraticProblem`] at a higher precision.
pub(crate) type PreciseQuadratic = [Vec<Big>; 3];

/// Where a problem comes from: what it can be asked for when its enclosures do not tell enough.
///
/// Everything must describe the same exact matrices as the [`QuadraticProblem`] does. Nothing is asked for that
/// is not needed.
pub trait QuadraticSource {
    /// The matrices with entries of so many bits.
    fn precisely(&self, _bits: usize) -> Option<PreciseQuadratic> {
        None
    }

    /// The matrices exactly, where every entry is a rational number.
    fn integers(&self) -> Option<Integers> {
        None
    }
}

/// No source: the enclosures are all there is.
impl QuadraticSource for () {}

/// All exponents that were asked for.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Exponents {
    /// One for a pair of conjugate exponents, one for a real exponent of a damped problem, one for a real pair
    /// ±s without damping (the growing one), each as often as its algebraic multiplicity; for the
    /// exponent 0 half its multiplicity without damping, the dimension of the kernel of S with it. Unstable
    /// ones by falling growth, then zeros, then by rising frequency and falling growth.
    pub entries: Vec<Exponent>,
    /// What all exponents together say.
    pub stability: Stability,
    /// Whether some motion grows in powers of t beyond a uniform drift: a Jordan block of an imaginary exponent, at 0
    /// one larger than 2. `None` where that is not decided.
    pub secular: Option<bool>,
    /// The highest precision level that any of the numbers comes from.
    pub level: PrecisionLevel,
}

/// An exponent growth + i omega.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Exponent {
    /// What kind of motion it is.
    pub kind: Kind,
    /// The real part; exactly 0 where that is proved.
    pub growth: Ball,
    /// The imaginary part, not negative; exactly 0 where that is proved.
    pub omega: Ball,
    /// -exponent², where growth or omega is proved to be 0.
    pub omega_squared: Option<Ball>,
    /// Growth and omega to more digits, where balls do not hold as many as were asked for.
    pub precise: Option<Box<Precise>>,
    /// The vector x with xᴴMx = 1 whose first component within 1e-6 of the largest is real and positive; empty if
    /// not asked for.
    pub vector: Vec<c64>,
    /// A bound of the error of each component. In a cluster: of the distance from the space that the columns
    /// of the cluster span; infinite where nothing is known.
    pub vector_error_bound: f64,
    /// Exponents with the same number are not separated by the bounds: equal, or nearly so.
    pub cluster: u32,
    /// Why digits are missing or a sign is open, if so; or that the exponent has fewer vectors than its
    /// multiplicity.
    pub limit: Option<Limit>,
}

/// Why an exponent is known less well than was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Limit {
    /// The exponent belongs to a Jordan block, proved: one vector for so many equal exponents, which depend on the
    /// parameters as a root of that order does, and motions of powers of t below that. At the exponent 0 only where the block
    /// is larger than that of a uniform drift, 2.
    Defective {
        /// The size of the block.
        order: usize,
    },
    /// So many exponents are not separated at the highest precision that was tried.
    Unresolved {
        /// How many.
        count: usize,
    },
    /// The exponent is separated from all others, but a sign or digits are open.
    Open,
}

impl Exponent {
    /// From its parts, with a vector and the bound of that.
    pub(crate) fn new(growth: Ball, omega: Ball, (vector, vector_error_bound): (Vec<c64>, f64), cluster: u32) -> Self {
        Self {
            kind: spectrum::kind(&growth, &omega),
            omega_squared: spectrum::omega_squared(&growth, &omega),
            growth,
            omega,
            precise: None,
            vector,
            vector_error_bound,
            cluster,
            limit: None,
        }
    }
}

/// The exponents of m q̈ + c q̇ + k q = 0 with c² = 4 m k, proved, and c not 0: -c/2m twice, with one vector.
pub(crate) fn critical(mass: &Ball, damping: &Ball, precise: Option<[Big; 2]>, options: &Options) -> Exponents {
    let growth = -(*damping / mass.scale(1));
    let x = Ball::ONE / mass.sqrt();
    let precise = precise.map(|[mass, damping]| {
        let growth = -&(&damping / &(&mass + &mass));
        Box::new(Precise::complex(Big::zero(growth.bits()), growth))
    });
    let shape = (vec![c64::new(x.mid_f64(), 0.0)], x.mid_f64_error());
    let limit = Some(Limit::Defective { order: 2 });
    let entry = Exponent { precise, limit, ..Exponent::new(growth, Ball::ZERO, shape, 0) };
    finish(vec![entry.clone(), entry], PrecisionLevel::Refined, options, &|_| true)
}
