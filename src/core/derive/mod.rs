//! The page that a good student hands in: from a model to its derivation, in symbols.
//!
//! A [`Derivation`] holds expressions, never text; each part of it stands in a file of its own and is
//! worked out only where [`Parts`] asks for it:
//!
//! - Lagrange's equations in full, and linearized (`equations`);
//! - momenta, the energy function, the Hamiltonian, T and V to second order (`energy`), what is conserved
//!   (`conserved`);
//! - symmetry classes and closed forms of the frequencies (`frequencies`, with `ties`, `forms`, `blocks`, `lattice`,
//!   `roots`, `cubic`, `check`), and normal coordinates (`normal`, `shapes`, `waves`);
//! - the characteristic polynomial, exponents and conditions of stability of any linear system (`characteristic`, `exponents`,
//!   `stability`, with `polynomial`, `factors`, `ring`), these as a reader writes them (`comparison`);
//! - equilibria in symbols, where a force can be solved by hand (`equilibria`);
//! - M, K and the equilibrium, from [`linearize`], in short (`simplify`); under constraints multipliers, and M and K among the
//!   motions that are left (`constraints`);
//! - names for Lorentz factors and for what a page would repeat (`abbreviate`).
//!
//! The equations exist wherever a model can be read: with explicit time, terms linear in the velocities
//! and friction too. Where M and K don't, [`Derivation::linear`] says why, and all else is there.
//! Nothing here gets a number but the equilibrium, which is searched for where it has to be, and what closed forms are
//! checked with. Of parameters the signs at their values are used, where that saves absolute values; each is told.
//!
//! ```
//! use librate::derive::{Parts, derive};
//! use librate::{model, syntax};
//!
//! let text = "param g  param l  param m  coord phi
//!     T = 1/2*m*l^2*phi'^2
//!     V = -m*g*l*cos(phi)";
//! let file = syntax::parse(text)?;
//! let model = model::elaborate(&file, &Default::default(), &Default::default())?;
//! let derivation = derive(&model, &Parts::default().equations(true))?;
//! assert_eq!(derivation.equation_texts(), ["l^2*m*phi'' + g*l*m*sin(phi) = 0"]);
//! # Ok::<(), librate::Error>(())
//! ```

mod abbreviate;
mod blocks;
mod characteristic;
mod check;
mod collapse;
mod comparison;
mod conserved;
mod constraints;
mod cubic;
mod energy;
mod equations;
mod equilibria;
mod exponents;
mod factors;
mod forms;
mod frequencies;
mod given;
mod independent;
mod lagrangian;
mod lattice;
mod limits;
mod motion;
mod normal;
mod pair;
mod pervasive;
mod products;
mod ring;
mod roots;
mod shapes;
mod simplify;
mod stability;
mod ties;
mod waves;

use std::collections::BTreeMap;

use hashbrown::HashMap;

use crate::budget::Exceeded;
use crate::expr::{ExprId, Pool, ZeroVerdict, evaluate_closed};
use crate::linearize::{self, LinearizeError, Tied};
use crate::model::{Assumption, Constant, Model};
use crate::order::Gather;
use crate::oscillation::NormalModes;

pub use abbreviate::Definition;
pub use comparison::greater_and_less;
pub use conserved::Conserved;
pub use constraints::{Constraints, Reduced, Tangent};
pub use cubic::{Solved, SolvedFormula};
pub use equilibria::{Condition, Root};
pub use exponents::{ClosedExponent, Exponents, Role, StabilityCondition};
pub use frequencies::{Approximation, Block, Case, Exchange, Frequencies, Frequency, Series};
pub use given::Given;
pub use independent::{Independent, in_independent_coordinates, linearized, without_multipliers};
pub use lattice::Angles;
pub use motion::{Factor, Motion, MotionPower, MotionSum, MotionTerm, Names};
pub use normal::{Abbreviation, NormalCoordinates, NormalMode};
pub use waves::{NormalWaves, WaveNumber, WaveSum};

use check::Checker;
use lagrangian::Variables;
use pair::Pair;
pub use simplify::Algebra;

/// The frequencies of more coordinates are left to `modes`.
const MOST_IN_NUMBERS: usize = 40;

/// Which parts of a derivation are wanted; M, K and the equilibrium always are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Parts {
    /// Lagrange's equations.
    pub equations: bool,
    /// Momenta, the energy function, the Hamiltonian and what is conserved.
    pub energy: bool,
    /// The linearized equations, and T and V to second order.
    pub second_order: bool,
    /// Symmetry classes and closed forms of the frequencies.
    pub frequencies: bool,
    /// Blocks of three are solved too, by Viète's formula.
    pub cubic: bool,
    /// Blocks of three and four are solved, those of four by Ferrari's formula.
    pub quartic: bool,
    /// Equilibria in symbols.
    pub equilibria: bool,
    /// The frequencies at the values of the parameters, where all have one and coordinates are few.
    pub numbers: bool,
}

impl Parts {
    /// What these [`CHAPTERS`] need.
    #[must_use]
    pub fn of(chapters: &[String]) -> Self {
        let any = |names: &[&str]| chapters.iter().any(|own| names.contains(&own.as_str()));
        Self {
            equations: any(&["equations"]),
            energy: any(&["momenta", "hamiltonian", "conserved"]),
            second_order: any(&["linearized"]),
            frequencies: any(&["frequencies", "characteristic", "exponents", "stability"]),
            equilibria: any(&["equilibria"]),
            numbers: any(&["numbers"]),
            ..Self::all()
        }
    }

    /// Everything that is symbols.
    #[must_use]
    pub fn all() -> Self {
        Self {
            equations: true,
            energy: true,
            second_order: true,
            frequencies: true,
            equilibria: true,
            ..Self::default()
        }
    }

    crate::choices! {
        /// With Lagrange's equations, or without.
        equations: bool,
        /// With momenta, energies and what is conserved, or without.
        energy: bool,
        /// With symmetry classes and closed forms of the frequencies, or without.
        frequencies: bool,
        /// With blocks of three solved among the closed forms, or without.
        cubic: bool,
        /// With blocks of three and four solved among the closed forms, or without those of four.
        quartic: bool,
        /// With equilibria in symbols, or without.
        equilibria: bool,
        /// With the frequencies at the values of the parameters, or without.
        numbers: bool,
    }

    /// Equations of at most this degree are solved for frequencies.
    fn degree(&self) -> usize {
        match (self.quartic, self.cubic) {
            (true, _) => 4,
            (false, true) => 3,
            (false, false) => 2,
        }
    }
}

/// A model in symbols.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Derivation {
    /// Where the expressions live.
    pub pool: Pool,
    /// From the `model` statement.
    pub model: Option<String>,
    /// What the coordinates and displacements are called.
    pub names: Names,
    /// What the names of the model stand for: its parameters (those defined from others written out), coordinates,
    /// velocities (`x'`), the time `t`, where it speaks of it, and multipliers of constraints.
    pub symbols: BTreeMap<String, ExprId>,
    /// What the model assumes of its parameters.
    pub assumptions: Vec<Assumption>,
    /// The rates of a steady motion, each with the name of its coordinate.
    pub rates: Vec<(String, ExprId)>,
    /// The model about its equilibrium, or why it has no M and K.
    pub linear: Result<Linear, LinearizeError>,
    /// The left sides of Lagrange's equations, one a coordinate.
    pub equations: Option<Vec<MotionSum>>,
    /// The same under conditions on velocities, in independent velocities and without multipliers; `None` where there are no
    /// conditions, or the equations are too large.
    pub independent: Option<Independent>,
    /// Momenta and energies.
    pub energy: Option<Energy>,
    /// Where forces vanish, as far as that can be solved in symbols; `None` under constraints.
    pub equilibria: Option<Vec<Root>>,
    /// Constraints, whose forces stand in the equations with a multiplier each; `None` where there are none.
    pub constraints: Option<Constraints>,
    /// Which [`CHAPTERS`] a page is to have; `None` for all.
    pub only: Option<Vec<String>>,
    /// By what the budget was used up, where that has left out what was to be worked out from there on.
    pub left_out: Option<Exceeded>,
    /// The energies as the file has them, with [`Derivation::put_given`].
    pub given: Option<Given>,
    /// The frequencies at the values of the parameters, where they are asked for.
    pub numbers: Option<NormalModes>,
}

/// What a page may be made of, as `derive --only` names it.
pub const CHAPTERS: [&str; 19] = [
    "model",
    "equations",
    "constraints",
    "momenta",
    "hamiltonian",
    "conserved",
    "equilibria",
    "equilibrium",
    "mass",
    "stiffness",
    "gyroscopic",
    "damping",
    "circulatory",
    "linearized",
    "frequencies",
    "characteristic",
    "exponents",
    "stability",
    "numbers",
];

/// M and K at the equilibrium, as expressions in the parameters.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Linear {
    /// The equilibrium; a coordinate that was found numerically stands as itself.
    pub equilibrium: Vec<ExprId>,
    /// Whether such coordinates were not searched for, since parameters have no values.
    pub open: bool,
    /// A force that vanishes there at the values of the parameters alone, in the model language, with the name of its coordinate.
    pub at_values: Option<(String, String)>,
    /// The mass matrix, row by row.
    pub mass: Vec<Vec<ExprId>>,
    /// The stiffness matrix, row by row.
    pub stiffness: Vec<Vec<ExprId>>,
    /// The gyroscopic matrix G, row by row; `None` where it is 0.
    pub gyroscopic: Option<Vec<Vec<ExprId>>>,
    /// The damping matrix C, row by row; `None` where it is 0.
    pub damping: Option<Vec<Vec<ExprId>>>,
    /// The circulatory matrix N of friction that acts at rest, row by row; `None` where it is 0.
    pub circulatory: Option<Vec<Vec<ExprId>>>,
    /// What is taken to be positive in them, or where the second is true negative, as it is at the values of the
    /// parameters; only where that saves absolute values.
    pub signs: Vec<(ExprId, bool)>,
    /// What follows from them, where it is asked for.
    pub second_order: Option<SecondOrder>,
    /// Symmetry classes and closed forms, where they are asked for; those of [`Linear::tangent`] where there is one.
    pub frequencies: Option<Frequencies>,
    /// Exponents and stability in symbols, where closed forms are asked for; likewise.
    pub exponents: Option<Exponents>,
    /// The directions that constraints allow, or in which massless coordinates follow the others; `None` where there are neither.
    pub tangent: Option<Tangent>,
}

impl Linear {
    /// Whether M and K are all there is.
    #[must_use]
    pub fn is_conservative(&self) -> bool {
        self.gyroscopic.is_none() && self.damping.is_none() && self.circulatory.is_none()
    }

    /// The matrices that there are beside M and K, with their names and letters.
    pub fn others(&self) -> impl Iterator<Item = (&'static str, &'static str, &Vec<Vec<ExprId>>)> {
        let all = [
            ("gyroscopic matrix", "G", &self.gyroscopic),
            ("damping matrix", "C", &self.damping),
            ("circulatory matrix", "N", &self.circulatory),
        ];
        all.into_iter().filter_map(|(name, letter, rows)| Some((name, letter, rows.as_ref()?)))
    }
}

/// The model to second order in the displacements.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SecondOrder {
    /// The left sides of M q'' + (G + C) q' + (K + N) q = 0; what moves is measured from the equilibrium.
    pub equations: Vec<MotionSum>,
    /// 1/2 q'ᵀ M q'.
    pub kinetic: MotionSum,
    /// 1/2 qᵀ K q: the potential energy (of T0 too, where there is one) without its constant.
    pub potential: MotionSum,
}

/// Momenta and energies.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Energy {
    /// p_i = dL/dq_i', one a coordinate.
    pub momenta: Vec<MotionSum>,
    /// h = sum q_i' p_i - L in coordinates and velocities.
    pub function: MotionSum,
    /// The same in coordinates and momenta: where no more than two coordinates are coupled by the inertia.
    pub hamiltonian: Option<MotionSum>,
    /// What is conserved.
    pub conserved: Vec<Conserved>,
    /// Whether T has a part T0 without velocities, so that V - T0 takes the place of V.
    pub rest_energy: bool,
}

/// Derives a model.
///
/// # Errors
/// [`LinearizeError::NotAnEquilibrium`] where the model gives a point as its equilibrium that is none, and
/// [`LinearizeError::ConstraintBroken`] where that breaks a constraint; [`LinearizeError::ConstraintsContradict`];
/// [`LinearizeError::Budget`] where it ends before M and K are there, or their reduction under constraints; what it ends later is
/// [left out](Derivation::left_out).
/// Whatever else keeps M and K from being there is told by [`Derivation::linear`].
pub fn derive(model: &Model, parts: &Parts) -> Result<Derivation, LinearizeError> {
    let budget = model.pool.budget();
    budget.at("the derivation", None);
    let model = linearize::integrated(model);
    let mut derivation = derivation(&model.assumed(), parts)?;
    if let Err(exceeded) = budget.check() {
        derivation.left_out = Some(exceeded);
        derivation.pool.renew_budget();
    }
    Ok(derivation)
}

fn derivation(model: &Model, parts: &Parts) -> Result<Derivation, LinearizeError> {
    let budget = model.pool.budget();
    budget.at("M and K in symbols", None);
    let (mut tied, mut matrices) = linearize::derive_with_multipliers(model);
    if let Err(LinearizeError::NoEquilibrium { .. } | LinearizeError::EquilibriumNotFound { .. }) = matrices
        && let Some((held, _)) = independent::held_at_zero(model)
        && let (own, Ok(found)) = linearize::derive_with_multipliers(&held)
    {
        (tied, matrices) = (own, Ok(found));
    }
    let with_multipliers = tied.as_ref().map_or(model, |tied| &tied.model);
    let (mut whole, mut linear) = match matrices {
        Ok(mut matrices) => {
            let tangent = Tangent::new(&mut matrices).or_else(|| Tangent::without_inertia(&mut matrices));
            let linear = Linear {
                equilibrium: matrices.equilibrium,
                open: matrices.open,
                at_values: matrices.at_values,
                mass: matrices.mass,
                stiffness: matrices.stiffness,
                gyroscopic: matrices.gyroscopic,
                damping: matrices.damping,
                circulatory: matrices.circulatory,
                tangent,
                ..Linear::default()
            };
            (matrices.pool, Ok(linear))
        }
        Err(
            error @ (LinearizeError::NotAnEquilibrium { .. }
            | LinearizeError::ConstraintBroken { .. }
            | LinearizeError::ConstraintsContradict { .. }),
        ) if model.rolling.is_empty() => return Err(error),
        Err(error) => (with_multipliers.pool.clone(), Err(independent::may_be_carried(model, error))),
    };
    let pool = &mut Algebra::new(&mut whole);
    let checker = Checker::new(model);
    if let Ok(found) = &linear
        && !found.open
        && found.tangent.as_ref().is_none_or(|tangent| !tangent.massless.is_empty())
        && let Some(error) = checker.singular_coordinates(pool, &found.mass)
    {
        linear = Err(error);
    }
    let names = names(model, &linear);
    let mut symbols = symbols(model, pool);
    for name in tied.iter().flat_map(Tied::names) {
        let symbol = pool.symbol(&name);
        symbols.insert(name, pool.symbol_expr(symbol));
    }
    if let Ok(linear) = &mut linear {
        budget.at("M and K in their shortest form", None);
        linear.finish(pool, &checker, parts, false);
    }
    budget.check()?;
    let rolling = constraints::Rolling::new(model, pool);
    symbols.extend(rolling.names.iter().cloned().zip(rolling.multipliers.iter().copied()));
    let rates = model.coordinates.iter().zip(model.rates.iter());
    // What is worked out below still adds to the pool.
    let mut derivation = Derivation {
        symbols,
        assumptions: model.assumptions.clone(),
        rates: rates.filter_map(|(coordinate, rate)| Some((coordinate.name(), rate?.symbolic))).collect(),
        constraints: Constraints::new(tied.as_ref(), &rolling, model.redundant.len()),
        ..Derivation::of_matrices(Pool::default(), model, names, linear)
    };
    if parts.equations || parts.energy || parts.equilibria {
        derivation.nonlinear(pool, model, with_multipliers, &rolling, &checker, parts);
    }
    if let Ok(linear) = &mut derivation.linear {
        if linear.tangent.is_none() {
            linear.closed_forms(pool, &checker, parts);
        } else {
            constraints::reduce(pool, linear, &derivation.names, &checker, parts);
            budget.check()?;
        }
    }
    if parts.numbers && model.coordinates.len() <= MOST_IN_NUMBERS {
        derivation.numbers = checker.into_modes();
    }
    derivation.pool = whole;
    Ok(derivation)
}

impl Linear {
    /// Brings all to its shortest form and works out what follows.
    fn finish(&mut self, pool: &mut Algebra<'_>, checker: &Checker<'_>, parts: &Parts, polish: bool) {
        let pair = Pair::new(&self.mass, &self.stiffness).replaced(pool, &HashMap::new());
        let (pair, signs) = checker.signed(pool, &pair);
        let pair = pair.with_halved_angles(pool).with_like_roots(pool);
        self.signs = signs.into_iter().collect();
        (self.mass, self.stiffness) = pair.dense(pool);
        // What ZᵀMZ multiplies out.
        if polish {
            let entries = self.mass.iter_mut().chain(&mut self.stiffness).flatten();
            entries.for_each(|entry| *entry = pool.polished(*entry));
        }
        pool.shorten(self.equilibrium.iter_mut());
        for matrix in [&mut self.gyroscopic, &mut self.damping, &mut self.circulatory] {
            pool.shorten(matrix.iter_mut().flatten().flatten());
            matrix.take_if(|rows| rows.iter().flatten().all(|e| e.is_zero()));
        }
        // What constraints forbid is no motion.
        let is_bound = self.tangent.as_ref().is_some_and(|tangent| tangent.massless.is_empty());
        if parts.second_order && !is_bound {
            self.second_order = Some(SecondOrder {
                equations: equations::linearized(pool, self),
                kinetic: energy::quadratic_form(pool, &self.mass, Motion::Velocity),
                potential: energy::quadratic_form(pool, &self.stiffness, Motion::Displacement),
            });
        }
    }

    /// Frequencies, exponents and stability, as far as the budget allows.
    fn closed_forms(&mut self, pool: &mut Algebra<'_>, checker: &Checker<'_>, parts: &Parts) {
        if pool.is_spent() || !parts.frequencies {
            return;
        }
        if self.is_conservative() {
            pool.budget().at("frequencies in closed form", None);
            let found = frequencies::frequencies(checker, pool, self, parts.degree());
            self.frequencies = Some(found).filter(|_| !pool.is_spent());
        }
        if !pool.is_spent() {
            let found = exponents::exponents(checker, pool, self);
            self.exponents = Some(found).filter(|_| !pool.is_spent());
        }
    }
}

/// What names stand for.
fn symbols(model: &Model, pool: &mut Pool) -> BTreeMap<String, ExprId> {
    let parameters = model.parameters.iter().map(|own| (own.name.clone(), own.symbolic));
    let mut symbols: BTreeMap<String, ExprId> = parameters.gather();
    for coordinate in model.coordinates.iter() {
        symbols.insert(coordinate.name(), pool.symbol_expr(coordinate.symbol));
        symbols.insert(format!("{}'", coordinate.name()), pool.symbol_expr(coordinate.velocity));
    }
    symbols.extend(model.time().map(|time| ("t".to_owned(), pool.symbol_expr(time))));
    symbols
}

/// Displacements are named as the coordinates where they are the same.
fn names(model: &Model, linear: &Result<Linear, LinearizeError>) -> Names {
    let coordinates: Vec<String> = model.coordinates.names().collect();
    let at_zero = linear.as_ref().is_ok_and(|linear| linear.equilibrium.iter().all(|at| at.is_zero()));
    // What no name of the model begins with, before that of a coordinate.
    let prefix = |all: [&str; 3]| {
        let is_free = |own: &&str| {
            let mut named = model.coordinates.stems().map(|name| format!("{own}_{name}"));
            named.all(|name: String| model.unused_name(&[&name]) == name)
        };
        all.into_iter().find(is_free).unwrap_or(all[0]).to_owned()
    };
    let (displacement, momentum) = (prefix(["delta", "xi", "eta"]), prefix(["p", "P", "pi"]));
    let displaced = |name: &String| if at_zero { name.clone() } else { format!("{displacement}_{name}") };
    let displacements = coordinates.iter().map(displaced).collect();
    let normal = model.unused_name(&["Q", "eta", "xi", "zeta"]);
    let energies = [["L", "lagrangian"], ["h", "E"], ["H", "Ham"]].map(|names| model.unused_name(&names));
    let omega = model.unused_name(&["omega", "Omega", "w"]);
    Names { displacements, momentum, normal, energies, omega, named: model.named.clone(), coordinates }
}

impl Derivation {
    /// What M and K tell, and nothing else.
    fn of_matrices(pool: Pool, model: &Model, names: Names, linear: Result<Linear, LinearizeError>) -> Self {
        Self {
            pool,
            model: model.name.clone(),
            names,
            symbols: BTreeMap::new(),
            assumptions: Vec::new(),
            rates: Vec::new(),
            linear,
            equations: None,
            independent: None,
            energy: None,
            equilibria: None,
            constraints: None,
            only: None,
            left_out: None,
            given: None,
            numbers: None,
        }
    }

    /// Works out what needs L in full.
    ///
    /// `tied` has a term lambda c for each constraint in its potential, and is `model` where there is none: what moves
    /// are the coordinates alone, so that multipliers count as parameters.
    fn nonlinear(
        &mut self,
        pool: &mut Algebra<'_>,
        model: &Model,
        tied: &Model,
        rolling: &constraints::Rolling,
        checker: &Checker<'_>,
        parts: &Parts,
    ) {
        let variables = Variables::new(model);
        let budget = pool.budget().clone();
        budget.at("Lagrange's equations", None);
        let mut lagrangian = lagrangian::lagrangian(tied, pool);
        lagrangian.drags = lagrangian::drags(model, pool, &variables);
        let idle = lagrangian.drags.iter().all(|(_, drag)| drag.is_zero()) && rolling.idle;
        let mut reduced = None;
        if (parts.equations || parts.energy) && !rolling.names.is_empty() {
            let at_equilibrium = checker.linearized().is_some();
            let is_pivot = |pool: &Pool, e: ExprId| match at_equilibrium {
                true => checker.differs_from_zero(pool, e),
                false => pool.is_zero(e) == ZeroVerdict::NonZero,
            };
            reduced = independent::independent(pool, &variables, model, &lagrangian.drags, &is_pivot);
        }
        lagrangian.drags.extend(rolling.drags(pool, &variables));
        if parts.equations {
            let coefficients = equations::coefficients(pool, &variables, &lagrangian);
            self.equations = Some(equations::equations(pool, &variables, coefficients));
        }
        if pool.is_spent() {
            self.equations = None;
            return;
        }
        budget.at("the equilibria in symbols", None);
        let bound = !model.constraints.is_empty() || !rolling.names.is_empty();
        // A rate turns with it, whose force is not in L.
        if parts.equilibria && !bound && !model.rates.any() {
            self.equilibria = Some(equilibria::roots(pool, &variables, &lagrangian, checker));
        }
        if pool.is_spent() {
            self.equilibria = None;
            return;
        }
        budget.at("what is conserved", None);
        if parts.energy {
            let momenta = energy::momenta(pool, &variables, &lagrangian);
            let mut conserved = conserved::conserved(pool, &variables, &lagrangian, &momenta, model);
            conserved.retain(|own| idle || !matches!(own, Conserved::Energy { .. }));
            if let Some(reduced) = &reduced {
                let more = conserved::integrals(pool, &variables, reduced, &conserved);
                let before = conserved.len() - usize::from(matches!(conserved.last(), Some(Conserved::Energy { .. })));
                conserved.splice(before..before, more);
            }
            // Along a motion the constraints are 0, and so is their part of L.
            let lagrangian = if bound { lagrangian::lagrangian(model, pool) } else { lagrangian };
            self.energy = Some(Energy {
                momenta,
                function: energy::energy_function(pool, &variables, &lagrangian),
                // Under constraints there are fewer momenta than coordinates.
                hamiltonian: (!bound).then(|| energy::hamiltonian(pool, &variables, &lagrangian)).flatten(),
                conserved,
                rest_energy: lagrangian.has_rest_energy,
            });
        }
        self.independent = reduced.filter(|_| parts.equations);
        if pool.is_spent() {
            (self.independent, self.energy) = (None, None);
        }
    }

    /// The names that a page gives no second meaning: those of symbols and of the model's own expressions, without indices.
    pub fn own_names(&self) -> impl Iterator<Item = &str> {
        let names = self.symbols.keys().chain(&self.names.named);
        names.map(|name| name.split(['[', '\'']).next().unwrap_or(name))
    }

    /// Whether a page is to have one of the [`CHAPTERS`].
    #[must_use]
    pub fn shows(&self, chapter: &str) -> bool {
        self.only.as_ref().is_none_or(|only| only.iter().any(|own| own == chapter))
    }

    /// The derivation of the motions that constraints allow, or that massless coordinates follow; the derivation itself where there
    /// are none.
    #[must_use]
    pub fn reduced(&self) -> &Self {
        let tangent = self.linear.as_ref().ok().and_then(|own| own.tangent.as_ref());
        let reduced = tangent.and_then(|tangent| tangent.reduced.as_ref());
        reduced.map_or(self, |reduced| &reduced.derivation)
    }

    /// What the closed forms take to be positive, or negative, though it is not where a parameter has a value: `d - 2`.
    #[must_use]
    pub fn sign_against(&self, parameter: &str, value: &Constant) -> Option<String> {
        let own = self.reduced();
        let linear = own.linear.as_ref().ok()?;
        let mut pool = own.pool.clone();
        let value = pool.adopted(value.pool(), value.value());
        let more = linear.frequencies.iter().flat_map(|own| own.signs.iter());
        linear.signs.iter().chain(more).find_map(|(e, negative)| {
            let symbol = pool.symbols(*e).into_iter().find(|own| pool.symbol_name(*own) == parameter)?;
            let there = pool.substitute_one(*e, &crate::expr::Substitution::from([(symbol, value)]));
            let is_broken = (evaluate_closed::<f64>(&pool, there, ())? < 0.0) != *negative;
            is_broken.then(|| pool.display(*e))
        })
    }

    /// Replaces the closed forms by what they are where a parameter goes to a value, in SI
    /// ([`Constant::of_parameter`] is); what is not defined there is dropped.
    pub fn limit(&mut self, parameter: &str, value: impl Into<Constant>) {
        self.approximate(&Approximation::Limit { name: parameter.to_owned(), value: value.into() });
    }

    /// Changes the closed forms of what moves.
    fn approximate(&mut self, done: &Approximation) {
        if let Ok(linear) = &mut self.linear {
            let pool = &mut Algebra::new(&mut self.pool);
            if let Some(reduced) = linear.tangent.as_mut().and_then(|tangent| tangent.reduced.as_mut()) {
                reduced.derivation.approximate(done);
            } else if let Some(frequencies) = &mut linear.frequencies {
                let exponents = linear.exponents.take();
                let characteristic = exponents.as_ref().and_then(|own| own.characteristic.as_deref());
                let values = exponents.as_ref().map_or(&[][..], |own| &own.values);
                frequencies.approximate(pool, done, characteristic, values);
                let is_limit = matches!(done, Approximation::Limit { .. });
                linear.exponents =
                    exponents.filter(|_| is_limit).map(|own| own.of_limit(pool, frequencies.best(), done));
            } else if let Some(exponents) = &mut linear.exponents {
                exponents.approximate(pool, done);
            }
        }
    }

    /// Replaces the closed forms by their series about 0 in a parameter, up to a power of it; what has
    /// no such series is dropped.
    pub fn expand(&mut self, parameter: &str, order: u32) {
        self.approximate(&Approximation::Expansion { name: parameter.to_owned(), order });
    }

    /// Lagrange's equations in the model language, `lhs = 0`; none where they were not asked for.
    #[must_use]
    pub fn equation_texts(&self) -> Vec<String> {
        self.equations.iter().flatten().map(|equation| format!("{} = 0", self.text(equation))).collect()
    }

    /// The linearized equations in the model language, `lhs = 0`, in displacements; none where they
    /// were not asked for or don't exist.
    #[must_use]
    pub fn linearized_texts(&self) -> Vec<String> {
        let second_order = self.linear.as_ref().ok().and_then(|linear| linear.second_order.as_ref());
        let equations = second_order.iter().flat_map(|part| &part.equations);
        equations.map(|equation| format!("{} = 0", self.displaced_text(equation))).collect()
    }

    /// A sum in coordinates, velocities, accelerations and momenta as text.
    #[must_use]
    pub fn text(&self, sum: &MotionSum) -> String {
        sum.text(&self.pool, |motion| self.names.of(motion))
    }

    /// A sum in displacements and their rates as text.
    #[must_use]
    pub fn displaced_text(&self, sum: &MotionSum) -> String {
        sum.text(&self.pool, |motion| self.names.displaced(motion))
    }
}
