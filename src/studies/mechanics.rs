//! Lagrange's equations in symbols, written out over all coordinates: M(q, t) q'' + h(q, q', t) = 0.
//!
//! With p_i = dL/dq_i' they are M_ij = dp_i/dq_j' and h_i = Σ_j dp_i/dq_j q_j' + dp_i/dt - dL/dq_i + dF/dq_i' - Q_i (Landau and
//! Lifshitz, Mechanics, §5). What is put in for parameters is up to the caller. Nothing is evaluated or approximated here, and
//! nothing is said about constraints.

use librate_core::expr::{ExprId, Pool, Substitution, Symbol};
use librate_core::linearize::{all_terms, forces_of, known_values, signed_terms, written_out};
use librate_core::model::{Feature, Model};
use librate_core::span::Span;

/// The Lagrangian of a model, the forces that no energy gives, and its symbols.
pub(crate) struct Mechanics<'a> {
    model: &'a Model,
    pub(crate) pool: Pool,
    pub(crate) coordinates: Vec<Symbol>,
    pub(crate) velocities: Vec<Symbol>,
    /// The time; a symbol of its own where the model does not contain it.
    pub(crate) time: Symbol,
    /// L = T - V.
    pub(crate) lagrangian: ExprId,
    /// By coordinate: dF/dq_i' - Q_i.
    drags: Vec<ExprId>,
}

/// The equation of one coordinate.
pub(crate) struct Equation {
    /// p_i.
    pub(crate) momentum: ExprId,
    /// M_ij and dp_i/dq_j by j, those that are not 0.
    pub(crate) mass: Vec<(usize, ExprId)>,
    pub(crate) slopes: Vec<(usize, ExprId)>,
    /// h_i.
    pub(crate) load: ExprId,
}

/// What a model says beside T and V, and where it does so first; but for forces that are 0 at the values of the parameters.
pub(crate) fn beside_energies(model: &Model) -> Option<(Feature, Span)> {
    let some_act = || {
        let (mut pool, known) = (model.pool.clone(), known_values(model));
        let bodies: Vec<ExprId> = model.forces.iter().map(|family| family.body).collect();
        pool.substitute(&bodies, &known).into_iter().any(|force| !pool.vanishes(force))
    };
    model.features().find(|(own, _)| !matches!(own, Feature::Dissipation | Feature::Force) || some_act())
}

/// A row of `count` entries, from those that are not 0.
pub(crate) fn row(entries: &[(usize, ExprId)], count: usize, zero: ExprId) -> Vec<ExprId> {
    let mut row = vec![zero; count];
    entries.iter().for_each(|(j, entry)| row[*j] = *entry);
    row
}

/// The energy function Σ q' dL/dq' - L.
pub(crate) fn energy(pool: &mut Pool, lagrangian: ExprId, equations: &[Equation], velocities: &[Symbol]) -> ExprId {
    let mut parts = vec![pool.neg(lagrangian)];
    parts.extend(equations.iter().zip(velocities).map(|(own, velocity)| pool.times(own.momentum, *velocity)));
    pool.sum(&parts)
}

impl<'a> Mechanics<'a> {
    /// Writes the energies out, with what is known of the parameters; `pool` builds on the model's and has these values.
    pub(crate) fn new(model: &'a Model, mut pool: Pool, known: &Substitution) -> Self {
        let lagrangian = written_out(model, &mut pool, signed_terms(model), None, known);
        let velocities: Vec<Symbol> = model.coordinates.iter().map(|own| own.velocity).collect();
        let (acting, friction): (Vec<_>, Vec<_>) = model.forces.iter().partition(|family| family.acts_on.is_some());
        let friction = written_out(model, &mut pool, friction.into_iter().map(|family| (false, family)), None, known);
        let mut drags = pool.gradient(friction, &velocities);
        for family in acting {
            for (i, force) in forces_of(model, &mut pool, family) {
                let force = pool.substitute_one(force, known);
                drags[i] = pool.sub(drags[i], force);
            }
        }
        Self {
            model,
            coordinates: model.coordinates.iter().map(|own| own.symbol).collect(),
            velocities,
            time: model.time().unwrap_or_else(|| pool.fresh_symbol("t")),
            pool,
            lagrangian,
            drags,
        }
    }

    /// How many terms the energies have.
    pub(crate) fn terms(model: &Model) -> usize {
        all_terms(model).map(|family| family.count).sum()
    }

    /// The first constraint on velocities or rate of a steady motion beside the energies, in the words for each.
    pub(crate) fn beside(model: &Model, [rolling, steady]: [&'static str; 2]) -> Option<(Span, &'static str)> {
        let rolls = model.rolling.first().map(|own| (own.span, rolling));
        rolls.or_else(|| model.rates.given().map(|given| (given.span, steady)).next())
    }

    /// The derivatives by the coordinates, by their numbers, those that are not 0.
    pub(crate) fn slopes(&mut self, e: ExprId) -> Vec<(usize, ExprId)> {
        self.model.symbols.slopes(&mut self.pool, e)
    }

    /// The same by the velocities.
    pub(crate) fn velocity_slopes(&mut self, e: ExprId) -> Vec<(usize, ExprId)> {
        self.model.symbols.velocity_slopes(&mut self.pool, e)
    }

    /// Σ_j of slopes times velocities, and the derivative by the time: that of an expression in q and t, or in q' too where
    /// accelerations are 0.
    pub(crate) fn rate(&mut self, e: ExprId, slopes: &[(usize, ExprId)]) -> ExprId {
        let mut parts = vec![self.pool.diff(e, self.time)];
        parts.extend(slopes.iter().map(|(j, slope)| self.pool.times(*slope, self.velocities[*j])));
        self.pool.sum(&parts)
    }

    /// Whether what no energy gives has a potential at each time.
    pub(crate) fn has_potential(&mut self) -> bool {
        let drags = self.drags.clone();
        let at_rest = drags.iter().all(|own| self.velocity_slopes(*own).is_empty());
        let slopes: Vec<_> = drags.iter().map(|own| self.slopes(*own)).collect();
        at_rest && is_gradient(&mut self.pool, &slopes)
    }

    /// Puts s x in for each absolute value |x| before anything is differentiated: gives these x with their signs s.
    pub(crate) fn put_signs(&mut self) -> Vec<(ExprId, Symbol)> {
        let Self { coordinates, velocities, time, .. } = self;
        let moves = |symbol| symbol == *time || coordinates.contains(&symbol) || velocities.contains(&symbol);
        let roots = [&[self.lagrangian], self.drags.as_slice()].concat();
        let (smooth, signs) = self.pool.with_signs(&roots, moves);
        if let [lagrangian, drags @ ..] = smooth.as_slice() {
            (self.lagrangian, self.drags) = (*lagrangian, drags.to_vec());
        }
        signs
    }

    /// The equations, one a coordinate.
    pub(crate) fn equations(&mut self) -> Vec<Equation> {
        let forces = self.pool.gradient(self.lagrangian, &self.coordinates);
        let momenta = self.pool.gradient(self.lagrangian, &self.velocities);
        let drags = self.drags.clone();
        let rows = momenta.into_iter().zip(drags).zip(forces).map(|((momentum, drag), force)| {
            let mass = self.velocity_slopes(momentum);
            let slopes = self.slopes(momentum);
            let rate = self.rate(momentum, &slopes);
            let force = self.pool.neg(force);
            let load = self.pool.sum(&[drag, rate, force]);
            Equation { momentum, mass, slopes, load }
        });
        rows.collect()
    }
}

/// Whether components with these derivatives by the coordinates, one list each, are those of a gradient: without a curl.
pub(crate) fn is_gradient(pool: &mut Pool, slopes: &[Vec<(usize, ExprId)>]) -> bool {
    let slope = |pool: &Pool, i: usize, j: usize| {
        let own = slopes[i].iter().find(|(at, _)| *at == j);
        own.map_or(pool.zero(), |own| own.1)
    };
    (0..slopes.len()).flat_map(|i| (0..i).map(move |j| (i, j))).all(|(i, j)| {
        let (own, other) = (slope(pool, i, j), slope(pool, j, i));
        pool.agree(own, other)
    })
}
