//! What a study finds: flat arrays, one stretch a set.

use faer::c64;

use super::Options;
use librate_core::modes::Kind;

pub(super) const NO_NUMBER: c64 = c64::new(f64::NAN, f64::NAN);

/// What became of a set of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Outcome {
    /// Solved. With [`Bounds::Rigorous`](super::Bounds::Rigorous) the bounds are proved; those of
    /// an equilibrium that was searched for are proved to hold an equilibrium too.
    Solved,
    /// Solved about an equilibrium that was searched for, and of which it is only estimated, not
    /// proved, how far the point found is from it: a neutral direction, or bounds too wide. The
    /// numbers' bounds hold if the estimate does.
    Estimated,
    /// A parameter, M or K is no finite number.
    NotFinite,
    /// M is not positive definite, or so nearly singular that doubles don't show that it is.
    MassNotPositive,
    /// A force acts at the equilibrium that the model gives, or none was found.
    NoEquilibrium,
    /// The eigenvalues were not found. Not known to happen.
    NotConverged,
}

impl Outcome {
    /// Whether there are numbers.
    #[must_use]
    pub fn is_solved(self) -> bool {
        matches!(self, Self::Solved | Self::Estimated)
    }
}

/// The results of many sets of parameters, in flat arrays: set after set in the order given.
///
/// n is the number of coordinates, in the model's order; everything is in SI where the model has
/// units. A conservative model has ω², their bounds and mode shapes, any other one has exponents, their bounds and
/// shapes and the matrix of velocities; what a model does not have is empty. Where a set has no solution its numbers
/// are NaN, but for the equilibrium, M and K as far as they are known.
#[derive(Clone, Debug, Default)]
pub struct Solutions {
    pub(super) dimension: usize,
    pub(super) outcomes: Vec<Outcome>,
    pub(super) equilibria: Vec<f64>,
    pub(super) omega_squared: Vec<f64>,
    pub(super) bounds: Vec<f64>,
    pub(super) vectors: Vec<f64>,
    pub(super) mass: Vec<f64>,
    pub(super) stiffness: Vec<f64>,
    pub(super) exponents: Vec<c64>,
    pub(super) exponent_bounds: Vec<f64>,
    pub(super) shapes: Vec<c64>,
    pub(super) velocity: Vec<f64>,
}

impl Solutions {
    /// No results; what [`Study::solve_into`](super::Study::solve_into) fills and fills again.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes room for results; whatever was there is overwritten.
    pub(super) fn prepare(&mut self, dimension: usize, count: usize, is_conservative: bool, options: Options) {
        let Options { vectors, matrices, .. } = options;
        let (n, square) = (dimension * count, dimension * dimension * count);
        let [squares, exponents] = if is_conservative { [n, 0] } else { [0, 2 * n] };
        self.dimension = dimension;
        self.outcomes.resize(count, Outcome::NotFinite);
        self.equilibria.resize(n, f64::NAN);
        self.omega_squared.resize(squares, f64::NAN);
        self.bounds.resize(squares, f64::NAN);
        self.vectors.resize(if vectors { squares * dimension } else { 0 }, f64::NAN);
        self.mass.resize(if matrices { square } else { 0 }, f64::NAN);
        self.stiffness.resize(if matrices { square } else { 0 }, f64::NAN);
        self.exponents.resize(exponents, NO_NUMBER);
        self.exponent_bounds.resize(exponents, f64::NAN);
        self.shapes.resize(if vectors { exponents * dimension } else { 0 }, NO_NUMBER);
        self.velocity.resize(if matrices && !is_conservative { square } else { 0 }, f64::NAN);
    }

    /// The number of sets.
    #[must_use]
    pub fn len(&self) -> usize {
        self.outcomes.len()
    }

    /// Whether there are no sets.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.outcomes.is_empty()
    }

    /// The number of coordinates, n.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// What became of each set: one a set.
    #[must_use]
    pub fn outcomes(&self) -> &[Outcome] {
        &self.outcomes
    }

    /// The equilibria: n a set.
    #[must_use]
    pub fn equilibria(&self) -> &[f64] {
        &self.equilibria
    }

    /// ω² of all modes in 1/s², ascending: n a set. Empty where the model is not conservative.
    #[must_use]
    pub fn omega_squared(&self) -> &[f64] {
        &self.omega_squared
    }

    /// Bounds of the absolute errors of [`Solutions::omega_squared`]: n a set; infinite without
    /// rigorous bounds.
    #[must_use]
    pub fn omega_squared_bounds(&self) -> &[f64] {
        &self.bounds
    }

    /// The mode shapes: n·n a set, mode after mode (column by column), M-normalised, in the order
    /// of [`Solutions::omega_squared`]; empty if not asked for.
    #[must_use]
    pub fn vectors(&self) -> &[f64] {
        &self.vectors
    }

    /// The mass matrices: n·n a set (symmetric); empty if not asked for.
    #[must_use]
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// The stiffness matrices K + N: n·n a set, row after row (symmetric where the model is conservative); empty if
    /// not asked for.
    #[must_use]
    pub fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// The matrices C + G that multiply velocities: n·n a set, row after row; empty if not asked for, and where the
    /// model is conservative.
    #[must_use]
    pub fn velocity(&self) -> &[f64] {
        &self.velocity
    }

    /// The exponents s of all motions x exp(s t), the roots of det(s² M + s (C + G) + K + N), in 1/s, as often as
    /// their multiplicity: 2n a set. By rising |Im s|, then by rising Re s, conjugates beside each other, the one with
    /// Im s > 0 first. Empty where the model is conservative.
    #[must_use]
    pub fn exponents(&self) -> &[c64] {
        &self.exponents
    }

    /// Bounds of the absolute errors |s - s exact| of [`Solutions::exponents`] in 1/s: 2n a set, the same for
    /// conjugates; infinite without rigorous bounds, and where exponents can't be told apart by vectors in doubles (a
    /// critically damped motion). Exact exponents can be given in such an order that all bounds hold.
    #[must_use]
    pub fn exponent_bounds(&self) -> &[f64] {
        &self.exponent_bounds
    }

    /// The mode shapes x of [`Solutions::exponents`]: 2n·n a set, one after the other, with xᴴ M x = 1 and the first
    /// component within 1e-6 of the largest real and positive; empty if not asked for, and where the model is
    /// conservative. They have no bounds.
    #[must_use]
    pub fn shapes(&self) -> &[c64] {
        &self.shapes
    }

    /// The results of one set, by its number from 0.
    #[must_use]
    pub fn get(&self, set: usize) -> Option<Solution<'_>> {
        (set < self.len()).then(|| self.of(set))
    }

    /// The same, without numbers beyond the end.
    fn of(&self, set: usize) -> Solution<'_> {
        let n = self.dimension;
        Solution {
            outcome: self.outcomes.get(set).copied().unwrap_or(Outcome::NotFinite),
            equilibrium: part(&self.equilibria, set, n),
            omega_squared: part(&self.omega_squared, set, n),
            omega_squared_bounds: part(&self.bounds, set, n),
            vectors: part(&self.vectors, set, n * n),
            mass: part(&self.mass, set, n * n),
            stiffness: part(&self.stiffness, set, n * n),
            exponents: part(&self.exponents, set, 2 * n),
            exponent_bounds: part(&self.exponent_bounds, set, 2 * n),
            shapes: part(&self.shapes, set, 2 * n * n),
            velocity: part(&self.velocity, set, n * n),
        }
    }

    /// The results set by set.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Solution<'_>> {
        (0..self.len()).map(|set| self.of(set))
    }
}

fn part<T>(all: &[T], set: usize, width: usize) -> &[T] {
    all.get(set * width..(set + 1) * width).unwrap_or(&[])
}

/// The results of one set; see [`Solutions`].
#[derive(Clone, Copy, Debug)]
pub struct Solution<'a> {
    /// What became of the set.
    pub outcome: Outcome,
    /// The equilibrium, n coordinates.
    pub equilibrium: &'a [f64],
    /// ω² of all modes, ascending.
    pub omega_squared: &'a [f64],
    /// Bounds of the absolute errors of ω².
    pub omega_squared_bounds: &'a [f64],
    /// The mode shapes, n by n, column by column.
    pub vectors: &'a [f64],
    /// The mass matrix, n by n.
    pub mass: &'a [f64],
    /// The stiffness matrix, n by n, row by row.
    pub stiffness: &'a [f64],
    /// The exponents, 2n.
    pub exponents: &'a [c64],
    /// Bounds of the absolute errors of exponents.
    pub exponent_bounds: &'a [f64],
    /// Their shapes, 2n of n components.
    pub shapes: &'a [c64],
    /// What multiplies velocities, n by n, row by row.
    pub velocity: &'a [f64],
}

/// One mode of one set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatchMode<'a> {
    /// [`Kind::Oscillation`] and [`Kind::Unstable`] where the bound decides the sign of ω²,
    /// [`Kind::Undecided`] otherwise. Never [`Kind::Zero`]: a small number is no proof of zero.
    pub kind: Kind,
    /// The frequency in rad/s: √ω², 0 where ω² <= 0.
    pub omega: f64,
    /// The rate of growth in 1/s: √-ω², 0 where ω² >= 0.
    pub growth: f64,
    /// A bound of the absolute errors of both.
    pub error_bound: f64,
    /// The mode shape; empty if not asked for.
    pub vector: &'a [f64],
}

impl<'a> Solution<'a> {
    /// One mode, in the order of [`Solution::omega_squared`]: unstable ones by falling growth, then
    /// by rising frequency. `None` beyond the last one, where there is no solution and where there are exponents
    /// instead.
    #[must_use]
    pub fn mode(&self, mode: usize) -> Option<BatchMode<'a>> {
        if !self.outcome.is_solved() {
            return None;
        }
        let n = self.omega_squared.len();
        let value = *self.omega_squared.get(mode)?;
        let bound = *self.omega_squared_bounds.get(mode)?;
        let kind = if value > bound {
            Kind::Oscillation
        } else if value < -bound {
            Kind::Unstable
        } else {
            Kind::Undecided
        };
        Some(BatchMode {
            kind,
            omega: value.max(0.0).sqrt(),
            growth: (-value).max(0.0).sqrt(),
            error_bound: root_bound(value.abs(), bound),
            vector: self.vectors.get(mode * n..(mode + 1) * n).unwrap_or(&[]),
        })
    }

    /// All modes; none where there is no solution.
    pub fn modes(&self) -> impl Iterator<Item = BatchMode<'a>> + use<'a> {
        let own = *self;
        (0..own.omega_squared.len()).filter_map(move |mode| own.mode(mode))
    }
}

/// How far √x is from the root of a number within `bound` of x, itself rounded; a root that does
/// not exist (of a negative number) counts as 0.
///
/// |√x - √y| = |x - y|/(√x + √y) <= bound/√x for y >= 0, and never more than √bound, because
/// |√x - √y|² <= |x - y|. A number y of the other sign than x has |x| + |y| <= bound, and √x as well as √|y|
/// is at most √bound.
fn root_bound(x: f64, bound: f64) -> f64 {
    let root = x.sqrt();
    let off = if bound < x { bound / root } else { bound.sqrt() };
    // Three roundings in `off`, one in the root itself.
    (off + root * f64::EPSILON) * (1.0 + 4.0 * f64::EPSILON) + f64::MIN_POSITIVE
}
