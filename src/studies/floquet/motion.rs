//! The equations of motion of a driven model (see [`crate::mechanics`]), linearized about rest and solved for the accelerations.
//!
//! Parameters have their exact values, but for those that are left open. Nothing is evaluated here.

use super::constrained::Tied;
use super::error::FloquetError;
use crate::flow::{Equations, solved};
use crate::mechanics::{Mechanics, row};
use librate_core::expr::{ExprId, Node, Pool, Substitution, Symbol, ZeroVerdict};
use librate_core::groups::connected;
use librate_core::linearize::{known_values, missing_value, signed_terms};
use librate_core::model::Model;
use librate_core::number::Number;
use librate_core::precision::Function;
use librate_core::span::Span;

/// Terms beyond this are not written out.
const MOST_TERMS: usize = 10_000;
/// More coordinates than this have expressions that are too large.
pub(super) const MOST_COORDINATES: usize = 40;

/// A driven model as differential equations.
pub(crate) struct Driven {
    pub(crate) pool: Pool,
    pub(crate) time: Symbol,
    /// Where the time occurs.
    pub(crate) driven_at: Span,
    pub(super) coordinates: Vec<Symbol>,
    pub(super) velocities: Vec<Symbol>,
    /// M, row by row.
    pub(super) mass: Vec<Vec<ExprId>>,
    /// dp_i/dq_j, row by row.
    pub(super) slopes: Vec<Vec<ExprId>>,
    /// h.
    pub(super) load: Vec<ExprId>,
    /// For each coordinate, whether there is friction, or a force without potential; about rest that the linear equations have.
    pub(crate) damped: Vec<bool>,
    /// The parameters that stay symbols.
    pub(crate) open: Vec<Symbol>,
    /// The values of the others.
    known: Substitution,
    /// The period, and where it is given.
    pub(crate) period: (ExprId, Span),
    /// The constraints of a motion that follows them.
    pub(crate) tied: Option<Tied>,
}

impl Driven {
    /// Writes the equations out; the parameters with the numbers in `open` stay symbols.
    ///
    /// # Errors
    /// Where the model is not a driven one, or not one that can be written out.
    pub(crate) fn new(model: &Model, open: &[usize]) -> Result<Self, FloquetError> {
        let driven_at = check(model)?;
        let Some(given) = model.period else {
            return Err(FloquetError::NoPeriod { suggestion: suggested_period(model), span: driven_at });
        };
        let mut pool = model.pool.clone();
        let known = values(model, &mut pool, open);
        let mut mechanics = Mechanics::new(model, pool, &known);
        let equations = mechanics.equations();
        let damped = vec![!mechanics.has_potential(); equations.len()];
        let Mechanics { mut pool, coordinates, velocities, time, .. } = mechanics;
        let zero = pool.zero();
        let whole = |entries: &[(usize, ExprId)]| row(entries, coordinates.len(), zero);
        let mass = equations.iter().map(|own| whole(&own.mass)).collect();
        let slopes = equations.iter().map(|own| whole(&own.slopes)).collect();
        let load = equations.iter().map(|own| own.load).collect();
        let period = pool.substitute_one(given.symbolic, &known);
        let driven = Self {
            pool,
            time,
            driven_at,
            coordinates,
            velocities,
            mass,
            slopes,
            load,
            damped,
            open: open.iter().map(|at| model.parameters[*at].symbol).collect(),
            known,
            period: (period, given.span),
            tied: None,
        };
        driven.check_values(model, open)?;
        Ok(driven)
    }

    /// That all parameters have values, but for those left open.
    fn check_values(&self, model: &Model, open: &[usize]) -> Result<(), FloquetError> {
        let mut roots = self.expressions();
        roots.push(self.period.0);
        for symbol in self.pool.symbols_of(&roots) {
            if let Some(number) = model.symbols.parameter(symbol)
                && !open.contains(&number)
            {
                return Err(FloquetError::Linearize(missing_value(model, number)));
            }
        }
        Ok(())
    }

    /// An expression in parameters with their values, but for those left open.
    pub(crate) fn with_values(&mut self, e: ExprId) -> ExprId {
        self.pool.substitute_one(e, &self.known)
    }

    /// The number of coordinates.
    pub(crate) fn dimension(&self) -> usize {
        self.coordinates.len()
    }

    /// h and M, then, in the order of [`Driven::symbols`].
    pub(crate) fn expressions(&self) -> Vec<ExprId> {
        self.load.iter().chain(self.mass.iter().flatten()).copied().collect()
    }

    /// dp_i/dq_j, then dp_i/dq_j' = M_ij, row by row: what makes displacements of the state ones of q and p.
    pub(super) fn canonical(&self) -> Vec<ExprId> {
        self.slopes.iter().flatten().chain(self.mass.iter().flatten()).copied().collect()
    }

    /// The time, the coordinates, their velocities.
    pub(crate) fn symbols(&self) -> Vec<Symbol> {
        std::iter::once(&self.time).chain(&self.coordinates).chain(&self.velocities).copied().collect()
    }

    /// Whether the force on each coordinate at rest at a point is 0 at all times.
    pub(crate) fn at_rest(&mut self, point: &[ExprId]) -> Vec<ZeroVerdict> {
        let forces = self.pool.substitute(&self.load, &self.at(point));
        forces.into_iter().map(|force| self.pool.is_zero(force)).collect()
    }

    /// The force on a coordinate that rests at a point, as text.
    pub(crate) fn force_text(&mut self, coordinate: usize, point: &[ExprId]) -> Option<String> {
        let map = self.at(point);
        let load = self.load.get(coordinate)?;
        let force = self.pool.substitute_one(*load, &map);
        let force = self.pool.neg(force);
        let text = self.pool.display(force);
        (text.chars().count() <= 80).then_some(text)
    }

    /// Rest at a point.
    pub(super) fn at(&self, point: &[ExprId]) -> Substitution {
        let zero = self.pool.zero();
        let places = self.coordinates.iter().copied().zip(point.iter().copied());
        let rest = self.velocities.iter().map(|velocity| (*velocity, zero));
        places.chain(rest).collect()
    }

    /// The linear equations about rest at a point where no force acts: J of (q, q')' = J(t) (q, q'), row by row.
    ///
    /// Accelerations vanish there, so that M q'' + (dh/dq') q' + (dh/dq) q = 0.
    pub(crate) fn linear(&mut self, point: &[ExprId]) -> Result<Vec<ExprId>, FloquetError> {
        let n = self.dimension();
        let map = self.at(point);
        let symbols: Vec<Symbol> = self.symbols()[1..].to_vec();
        let bent = |load: &ExprId| {
            let row = self.pool.gradient(*load, &symbols);
            self.pool.substitute(&row, &map)
        };
        let right: Vec<Vec<ExprId>> = self.load.iter().map(bent).collect();
        let mut at = |rows: &[Vec<ExprId>]| rows.iter().map(|row| self.pool.substitute(row, &map)).collect();
        let [mass, slopes]: [Vec<_>; 2] = [at(&self.mass), at(&self.slopes)];
        if self.damped.contains(&true) {
            self.damp(&mass, &slopes, &right);
        }
        let solved = self.solved(mass, right)?;
        let mut rows = vec![self.pool.zero(); 2 * n * n];
        for i in 0..n {
            rows[2 * n * i + n + i] = self.pool.one();
        }
        rows.extend(solved.into_iter().flatten());
        Ok(rows)
    }

    /// Which coordinates friction acts on in M q'' + D q' + S q = 0, or on one that is coupled to them. Without it D is M' + A - Aᵀ with A = dp/dq,
    /// and S - Sᵀ is A' - A'ᵀ: they are the equations of the Lagrangian q'ᵀM q'/2 + q'ᵀA q - qᵀ(S - A')q/2.
    fn damp(&mut self, mass: &[Vec<ExprId>], momenta: &[Vec<ExprId>], right: &[Vec<ExprId>]) {
        let (n, time, pool) = (self.dimension(), self.time, &mut self.pool);
        // Constraints have left fewer.
        self.damped.truncate(n);
        let mut is_free = |i: usize, j: usize| {
            let turn = pool.sub(momenta[i][j], momenta[j][i]);
            let [rate, change] = [mass[i][j], turn].map(|own| pool.diff(own, time));
            let [drag, twist] = [pool.sub(right[i][n + j], turn), pool.sub(right[i][j], right[j][i])];
            pool.agree(drag, rate) && pool.agree(twist, change)
        };
        let free: Vec<Vec<bool>> = (0..n).map(|i| (0..n).map(|j| is_free(i, j)).collect()).collect();
        let entries = |i: usize, j: usize| [mass[i][j], right[i][j], right[i][n + j]];
        let is_coupled = |i: usize, j: usize| entries(i, j).iter().any(|own| !self.pool.vanishes(*own));
        for members in connected(n, |i, j| is_coupled(i, j) || is_coupled(j, i)) {
            let is_damped = members.iter().any(|i| members.iter().any(|j| !free[*i][*j]));
            members.iter().for_each(|i| self.damped[*i] = is_damped);
        }
    }

    /// The state's own equations, compiled: (q, q')' = (q', -M⁻¹h), with the forces of constraints if there are any.
    pub(crate) fn equations(&mut self) -> Result<Equations, FloquetError> {
        let mut right: Vec<Vec<ExprId>> = self.load.iter().map(|load| vec![*load]).collect();
        let mut matrix = self.mass.clone();
        if let Some(tied) = &self.tied {
            tied.border(&mut self.pool, &mut matrix, &mut right);
        }
        let mut accelerations = self.solved(matrix, right)?;
        accelerations.truncate(self.dimension());
        let mut rates: Vec<ExprId> = self.velocities.iter().map(|own| self.pool.symbol_expr(*own)).collect();
        rates.extend(accelerations.into_iter().flatten());
        let state: Vec<Symbol> = self.symbols()[1..].to_vec();
        Equations::compile(&mut self.pool, self.time, &state, &self.open, &rates)
            .map_err(|_| FloquetError::NotDefined { span: self.driven_at })
    }

    /// -M⁻¹ times the right sides.
    fn solved(&mut self, mass: Vec<Vec<ExprId>>, right: Vec<Vec<ExprId>>) -> Result<Vec<Vec<ExprId>>, FloquetError> {
        let span = self.driven_at;
        let mut rows = solved(&mut self.pool, mass, right).ok_or(FloquetError::NotDefined { span })?;
        for value in rows.iter_mut().flatten() {
            *value = self.pool.neg(*value);
        }
        Ok(rows)
    }
}

/// Refuses what has no Floquet multipliers here; tells where the time occurs.
fn check(model: &Model) -> Result<Span, FloquetError> {
    let Some(span) = model.time_dependent else {
        let span = model.period.map(|given| given.span);
        return Err(FloquetError::NoTime { span });
    };
    if let Some((span, what)) = Mechanics::beside(model, ["constraints on velocities", "a steady motion"]) {
        return Err(FloquetError::Unsupported { what, span });
    }
    let terms = Mechanics::terms(model);
    if terms > MOST_TERMS || model.coordinates.len() > MOST_COORDINATES {
        return Err(FloquetError::TooLarge { coordinates: model.coordinates.len(), terms });
    }
    Ok(span)
}

/// The values of all parameters but some; one that is defined from those stays an expression in them.
pub(crate) fn values(model: &Model, pool: &mut Pool, open: &[usize]) -> Substitution {
    if open.is_empty() {
        return known_values(model);
    }
    let mut known = Substitution::default();
    for (number, parameter) in model.parameters.iter().enumerate() {
        if open.contains(&number) {
            continue;
        }
        let own = pool.symbols_of(&[parameter.symbolic]);
        if own.contains(&parameter.symbol) {
            if let Some(value) = parameter.value {
                known.insert(parameter.symbol, value);
            }
        } else {
            // Those it is defined from stand before it.
            let value = pool.substitute_one(parameter.symbolic, &known);
            known.insert(parameter.symbol, value);
        }
    }
    known
}

/// `2*pi/W`, where the time occurs in sines and cosines of W t alone.
fn suggested_period(model: &Model) -> Option<String> {
    let mut pool = model.pool.clone();
    let time = model.time()?;
    let bodies: Vec<ExprId> = signed_terms(model).map(|(_, family)| family.body).collect();
    let mut rate = None;
    for id in pool.reachable(&bodies) {
        let Node::Function(Function::Sin | Function::Cos, x) = *pool.node(id) else { continue };
        let own = pool.diff(x, time);
        if pool.as_number(own).is_some_and(Number::is_zero) {
            continue;
        }
        let constant = pool.symbols_of(&[own]).into_iter().all(|symbol| model.symbols.parameter(symbol).is_some());
        if !constant || rate.is_some_and(|other| other != own) {
            return None;
        }
        rate = Some(own);
    }
    let turn = pool.pi();
    let turn = pool.scale(turn, &Number::from(2));
    let period = pool.div(turn, rate?);
    Some(pool.display(period))
}
