//! Parameter studies: derived once, solved for thousands of sets of parameter values, in doubles.
//!
//! A [`Study`] compiles M, K, the equilibrium and (where that has to be searched for) the forces
//! of a model, as functions of the parameters that vary, to a program that works on eight sets at
//! once; then [`Study::solve`] gives equilibrium, M, K, all ω² with bounds and mode shapes of every
//! set, in flat arrays ([`Solutions`]). Models with friction, forces or terms linear in the velocities have 2n complex
//! exponents in place of n squares ([`Study::is_conservative`], [`Solutions::exponents`]).
//!
//! ```
//! use librate::batch::Study;
//! use librate::{model, syntax};
//!
//! let text = "
//!     param g = 9.81  param l[1..2] = 1  param m[1..2] = 1
//!     coord th[1..2]
//!     let r1 = [l[1]*sin(th[1]), -l[1]*cos(th[1])]
//!     let r2 = r1 + [l[2]*sin(th[2]), -l[2]*cos(th[2])]
//!     T = 1/2*m[1]*dot(r1', r1') + 1/2*m[2]*dot(r2', r2')
//!     V = m[1]*g*r1[2] + m[2]*g*r2[2]
//! ";
//! let file = syntax::parse(text).map_err(|errors| errors[0].clone())?;
//! let model = model::elaborate(&file, &Default::default(), &Default::default())
//!     .map_err(|errors| errors[0].clone())?;
//! // A family's name stands for all its members.
//! let study = Study::new(model, &["m[2]", "l"])?;
//! assert_eq!(study.parameters().collect::<Vec<_>>(), ["m[2]", "l[1]", "l[2]"]);
//!
//! // Set after set, in SI: m[2], l[1], l[2].
//! let sets = [1.0, 1.0, 1.0, /**/ 3.0, 0.5, 0.5, /**/ f64::NAN, 1.0, 1.0];
//! let solutions = study.solve(&sets)?;
//! let [low, high] = [2.0 - 2.0_f64.sqrt(), 2.0 + 2.0_f64.sqrt()].map(|z| (9.81 * z).sqrt());
//! let first = solutions.get(0).into_iter().flat_map(|set| set.modes());
//! for (mode, omega) in first.zip([low, high]) {
//!     assert!((mode.omega - omega).abs() < 1e-14 * omega);
//!     assert!(mode.error_bound < 1e-13);
//! }
//! assert!(!solutions.outcomes()[2].is_solved());
//!
//! // What is to be quoted: the same set with every digit certified.
//! let certified = study.certified(&sets[3..6])?;
//! let batch = solutions.omega_squared()[2];
//! assert!((batch - certified.modes[0].omega.mid_f64().powi(2)).abs() < 1e-14 * batch);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What the numbers are
//!
//! Doubles, not the digits that the rest of the crate certifies. M and K are evaluated in doubles,
//! and so is the eigenvalue problem; soft modes beside stiff ones lose digits as in any such code.
//! But with [`Bounds::Rigorous`], which is the default, each ω² has a bound that holds for the
//! exact M and K of the parameters as given (a double counts as the number that it is, a parameter
//! that does not vary as the exact value of the model): the errors of evaluating M and K, of the
//! eigenvalue problem, and of the bound itself are all in it. About an equilibrium that is searched
//! for, K is enclosed for all points near the one found, and that one of them is an equilibrium is
//! proved as well where the outcome is [`Outcome::Solved`]; [`Outcome::Estimated`] says that it is
//! not. The bound of well-conditioned problems is some 1e-14 of the largest ω². It is for ω²; mode
//! shapes have none. Likewise exponents; of those that are equal and have one vector (critical damping, a free
//! coordinate without friction) the bound is about the root of that, or infinite. Zero modes of free bodies come out
//! as small numbers with a bound around zero and are not proved to be zero; within a degenerate cluster the vectors
//! are M-orthonormal to rounding, but which basis they are is not fixed. For digits to be quoted, proved zeros and
//! vectors with bounds there is [`Study::certified`], one set at a time.
//!
//! With the model's equilibrium searched for, each set starts from the one at the model's own
//! parameter values, which may lead to another equilibrium than a search from the guess.
//!
//! # One core, or several
//!
//! Everything here works in the calling thread and, up to 40 coordinates, allocates nothing per
//! set. A [`Study`] is `Sync`, and a set's results do not depend on the sets beside it (to the
//! bit), so that splitting the sets is all it takes:
//!
//! ```
//! # use librate::batch::{Solutions, Study, StudyError};
//! fn on_two_cores(study: &Study, sets: &[f64]) -> Result<[Solutions; 2], StudyError> {
//!     let half = sets.len() / study.width() / 2 * study.width();
//!     let (left, right) = sets.split_at(half);
//!     std::thread::scope(|scope| {
//!         let other = scope.spawn(|| study.solve(right));
//!         let own = study.solve(left)?;
//!         Ok([own, other.join().unwrap_or(Ok(Solutions::new()))?])
//!     })
//! }
//! ```

mod block;
mod bound;
mod certified;
mod complex;
mod discs;
mod error;
mod exponents;
mod listed;
mod search;
mod solutions;
mod solve;
mod tape;

pub use error::StudyError;
pub use solutions::{BatchMode, Outcome, Solution, Solutions};

use crate::program::Program;
use crate::source;
use block::{Compiled, Start, Workspace};
use bound::Entry;
use librate_core::precision::LANES;

use librate_core::diagnostic::nearest;
use librate_core::expr::{ExprId, Pool, Symbol, UnboundSymbol};
use librate_core::linearize::{Parametric, parametric};
use librate_core::model::Model;

/// Whether errors are bounded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Bounds {
    /// Every ω² or exponent gets a bound that holds; for ω² it takes a fifth to a third more time.
    #[default]
    Rigorous,
    /// Nothing is said about errors, and all bounds are infinite. For pictures.
    None,
}

/// What a study computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[must_use]
pub struct Options {
    /// Whether errors are bounded.
    pub bounds: Bounds,
    /// Whether mode shapes are given.
    pub vectors: bool,
    /// Whether M and K are given.
    pub matrices: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { bounds: Bounds::Rigorous, vectors: true, matrices: true }
    }
}

impl Options {
    /// Without bounds of the errors.
    pub fn without_bounds(self) -> Self {
        Self { bounds: Bounds::None, ..self }
    }

    /// Without mode shapes.
    pub fn without_vectors(self) -> Self {
        Self { vectors: false, ..self }
    }

    /// Without M and K themselves.
    pub fn without_matrices(self) -> Self {
        Self { matrices: false, ..self }
    }
}

/// A model whose parameters vary.
#[derive(Clone, Debug)]
pub struct Study {
    model: Model,
    /// The numbers of the parameters that vary.
    varying: Vec<usize>,
    compiled: Compiled,
    options: Options,
}

impl Study {
    /// Derives M and K of a model as functions of the named parameters. A name is a parameter
    /// (`g`, `m[2]`) or a whole family (`m`); all others keep the model's values. Values of
    /// parameters that vary are only used to find out where an equilibrium may be searched for.
    ///
    /// # Errors
    /// [`StudyError`]: where a name is no parameter, or one that can't vary by itself, and where
    /// the model can't be linearized as [`librate_core::linearize::derive`] would (but forces that don't
    /// vanish are each set's own [`Outcome`]).
    pub fn new(model: Model, names: &[&str]) -> Result<Self, StudyError> {
        Self::with_options(model, names, Options::default())
    }

    /// As [`Study::new`], with a choice of what is computed.
    ///
    /// # Errors
    /// As [`Study::new`].
    pub fn with_options(model: Model, names: &[&str], options: Options) -> Result<Self, StudyError> {
        let varying = parameters(&model, names)?;
        let parametric = parametric(model.clone(), &varying)?;
        let compiled = compile(parametric).map_err(|unbound| source::missing(&model, &unbound))?;
        Ok(Self { model, varying, compiled, options })
    }

    /// The names of the parameters that vary, in the order of a set's values.
    pub fn parameters(&self) -> impl ExactSizeIterator<Item = &str> {
        self.varying.iter().map(|number| self.model.parameters[*number].name.as_str())
    }

    /// How many values a set has.
    #[must_use]
    pub fn width(&self) -> usize {
        self.varying.len()
    }

    /// Whether equilibria are given points, or 0, at which no force acts whatever the values are: proved, and never
    /// searched for.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.compiled.search.is_none() && self.compiled.gradient.is_empty()
    }

    /// Whether no force acts but those of a potential, so that ω² are what there is to find. Any other model has
    /// exponents instead: terms linear in the velocities, friction, forces.
    #[must_use]
    pub fn is_conservative(&self) -> bool {
        self.compiled.velocity.is_none()
    }

    /// The number of coordinates.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.compiled.dimension
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// What is computed.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Solves sets of parameter values: set after set, [`Study::width`] values each in the order
    /// of [`Study::parameters`], in SI where the model has units. What is wrong with a set is its
    /// [`Outcome`] and touches no other.
    ///
    /// # Errors
    /// [`StudyError::Length`] where the values are not whole sets.
    pub fn solve(&self, sets: &[f64]) -> Result<Solutions, StudyError> {
        let mut solutions = Solutions::new();
        self.solve_into(sets, &mut solutions)?;
        Ok(solutions)
    }

    /// As [`Study::solve`], into results that were made before, whose memory is used again.
    ///
    /// # Errors
    /// As [`Study::solve`].
    pub fn solve_into(&self, sets: &[f64], into: &mut Solutions) -> Result<(), StudyError> {
        self.solve_near(sets, &[], into)
    }

    /// As [`Study::solve_into`], for values that are off by up to `errors`, one a value: with [`Bounds::Rigorous`] the
    /// bounds hold for all sets of exact values as near as that. What `errors` has no number for is exact.
    ///
    /// # Errors
    /// As [`Study::solve`].
    pub fn solve_near(&self, sets: &[f64], errors: &[f64], into: &mut Solutions) -> Result<(), StudyError> {
        let width = self.width();
        if !sets.len().is_multiple_of(width) {
            return Err(StudyError::Length { found: sets.len(), width });
        }
        into.prepare(self.dimension(), sets.len() / width, self.is_conservative(), self.options);
        let mut workspace = Workspace::new(&self.compiled);
        for (block, sets) in sets.chunks(LANES * width).enumerate() {
            let first = block * LANES;
            let errors = errors.get(first * width..).unwrap_or_default();
            workspace.block(&self.compiled, &self.options, (sets, errors), first, into);
        }
        Ok(())
    }
}

/// The numbers of named parameters.
fn parameters(model: &Model, names: &[&str]) -> Result<Vec<usize>, StudyError> {
    let mut varying = Vec::new();
    for name in names {
        let member = format!("{name}[");
        let is_meant = |own: &str| own == *name || own.starts_with(&member);
        let found = (0..model.parameters.len()).filter(|number| is_meant(&model.parameters[*number].name));
        let found: Vec<usize> = found.collect();
        if found.is_empty() {
            let known = model.parameters.iter().map(|own| own.name.as_str());
            return Err(StudyError::UnknownParameter {
                name: (*name).to_owned(),
                nearest: nearest(name, known).map(str::to_owned),
            });
        }
        for number in found {
            independent(model, number)?;
            if varying.contains(&number) {
                return Err(StudyError::NamedTwice { name: model.parameters[number].name.clone() });
            }
            varying.push(number);
        }
    }
    if varying.is_empty() { Err(StudyError::NothingVaries {}) } else { Ok(varying) }
}

/// Refuses a parameter that stands for a number or for an expression in others.
fn independent(model: &Model, number: usize) -> Result<(), StudyError> {
    let parameter = &model.parameters[number];
    let name = parameter.name.clone();
    if model.pool.as_symbol(parameter.symbolic) == Some(parameter.symbol) {
        return Ok(());
    }
    let name_of = |symbol: &Symbol| Some(model.parameters[model.symbols.parameter(*symbol)?].name.clone());
    let on: Vec<String> = model.pool.symbols_of(&[parameter.symbolic]).iter().filter_map(name_of).collect();
    if on.is_empty() { Err(StudyError::SetsRange { name }) } else { Err(StudyError::Dependent { name, on }) }
}

/// The entries of a matrix that are not zero identically, of a symmetric one those of the upper triangle; their
/// expressions are added to the roots.
fn entries(pool: &Pool, rows: &[Vec<ExprId>], is_symmetric: bool, roots: &mut Vec<ExprId>) -> Vec<Entry> {
    let mut entries = Vec::new();
    for (row, expressions) in rows.iter().enumerate() {
        for (column, expression) in expressions.iter().enumerate().skip(if is_symmetric { row } else { 0 }) {
            if pool.as_number(*expression).is_some_and(|x| x.is_zero()) {
                continue;
            }
            entries.push(Entry { row, column, register: roots.len() });
            roots.push(*expression);
        }
    }
    entries
}

/// Compiles everything into one program.
fn compile(parametric: Parametric) -> Result<Compiled, UnboundSymbol> {
    let pool = &parametric.pool;
    let n = parametric.equilibrium.len();
    let mut roots = parametric.equilibrium.clone();
    let mut mass = entries(pool, &parametric.mass, true, &mut roots);
    let mut stiffness = entries(pool, &parametric.stiffness, parametric.velocity.is_none(), &mut roots);
    let mut velocity = parametric.velocity.as_ref().map(|rows| entries(pool, rows, false, &mut roots));
    let first_force = roots.len();
    roots.extend(&parametric.gradient);
    let mut inputs = parametric.parameters.clone();
    inputs.extend(parametric.searched.iter().flatten());
    let program = Program::compile(pool, &roots, &inputs)?;
    let register = |output: usize| program.outputs[output] as usize;
    for entry in mass.iter_mut().chain(&mut stiffness).chain(velocity.iter_mut().flatten()) {
        entry.register = register(entry.register);
    }
    let free: Vec<usize> = (0..n).filter(|at| parametric.searched[*at].is_some()).collect();
    let search = if free.is_empty() {
        None
    } else {
        Some(Start {
            free,
            zero_first: !parametric.guessed,
            guess: Program::compile(pool, &parametric.start, &parametric.parameters)?,
            nominal: parametric.nominal,
        })
    };
    Ok(Compiled {
        dimension: n,
        width: parametric.parameters.len(),
        equilibrium: (0..n).map(register).collect(),
        gradient: (first_force..roots.len()).map(register).collect(),
        mass,
        stiffness,
        velocity,
        search,
        program,
    })
}
