//! Driven models with constraints c(q, t) = 0.
//!
//! At a point where M q'' + h = Jᵀ mu holds at rest for some mu(t), small displacements are q = Z u with J Z = 0, and
//! Zᵀ M Z u'' + Zᵀ (dh/dq') Z u' + Zᵀ (dh/dq - Σ mu_a d²c_a/dq²) Z u = 0. Momenta of u follow as Zᵀ p; what Z changes along the
//! constraints adds a gradient to them, which no bracket sees.
//!
//! Elsewhere the equations are those of all coordinates with c'' + 2 b c' + b² c = 0 (J. Baumgarte, Comput. Methods Appl. Mech. Eng. 1
//! (1972) 1): a periodic motion of these satisfies c = 0, as all else decays, and displacements along the constraints,
//! J dq = 0 and d(c') = 0, stay so. Multipliers are those of these displacements, described by as many of q and q' as determine them.

use super::error::FloquetError;
use super::motion::Driven;
use crate::flow::solved;
use librate_core::expr::{ExprId, Pool, Symbol, Tape, ZeroVerdict};
use librate_core::linearize::clear_symbolic_column;
use librate_core::model::Model;
use librate_core::number::Number;
use librate_core::precision::{Enclosure, Matrix, reduce, sum_of_products};

impl Driven {
    /// The equations of small displacements from a point along the constraints, as a driven model that rests at 0, and that state
    /// in place of `begin`; or, where it does not rest there, with the constraints beside its equations.
    ///
    /// # Errors
    /// Constraints that depend on each other, and a given equilibrium that is none.
    pub(crate) fn along_constraints(
        mut self,
        model: &Model,
        begin: Vec<ExprId>,
    ) -> Result<(Self, Vec<ExprId>), FloquetError> {
        let Some(first) = model.constraints.first() else { return Ok((self, begin)) };
        let point = &begin[..self.dimension()];
        let unsupported = |what| FloquetError::Unsupported { what, span: first.span };
        let n = self.dimension();
        let map = self.at(point);
        let symbols = self.symbols();
        let mut gaps: Vec<ExprId> = model.constraints.iter().map(|own| own.expression).collect();
        gaps.iter_mut().for_each(|gap| *gap = self.with_values(*gap));
        let changes = gaps.iter().any(|gap| self.pool.depends_on(*gap, &|symbol| symbol == self.time));
        let pool = &mut self.pool;
        let there = pool.substitute(&gaps, &map);
        let mut resting = there.iter().chain(&begin[n..]);
        if changes || !resting.all(|own| pool.vanishes(*own)) {
            return self.tied(model, &gaps).map(|own| (own, begin));
        }
        let gradients: Vec<Vec<ExprId>> = gaps.iter().map(|gap| pool.gradient(*gap, &symbols[1..=n])).collect();
        let slopes: Vec<Vec<ExprId>> = gradients.iter().map(|row| pool.substitute(row, &map)).collect();
        let directions = kernel(pool, slopes.clone(), n).ok_or(unsupported("constraints that depend on each other"))?;
        if directions.is_empty() {
            return Err(unsupported("constraints that leave no motion"));
        }
        // The forces of the constraints: (J Jᵀ) mu = J h.
        let loads = pool.substitute(&self.load, &map);
        let square = slopes.iter().map(|row| slopes.iter().map(|other| pool.dot(row, other)).collect()).collect();
        let right = slopes.iter().map(|row| vec![pool.dot(row, &loads)]).collect();
        let forces = solved(pool, square, right).ok_or(unsupported("constraints that depend on each other"))?.concat();
        let still = directions.iter().all(|direction| {
            let force = pool.dot(direction, &loads);
            pool.vanishes(force)
        });
        if !still {
            return self.tied(model, &gaps).map(|own| (own, begin));
        }
        // Zᵀ A Z of derivatives of h - Jᵀ mu, of momenta, and of M.
        let mut bent: Vec<Vec<ExprId>> = Vec::new();
        for i in 0..n {
            let mut row = pool.gradient(self.load[i], &symbols[1..]);
            for (gradient, force) in gradients.iter().zip(&forces) {
                let own = pool.gradient(gradient[i], &symbols[1..=n]);
                for (entry, bend) in row.iter_mut().zip(own) {
                    let part = pool.mul(*force, bend);
                    *entry = pool.sub(*entry, part);
                }
            }
            bent.push(pool.substitute(&row, &map));
        }
        let reduced = |pool: &mut Pool, rows: &[Vec<ExprId>]| -> Vec<Vec<ExprId>> {
            let columns: Vec<Vec<ExprId>> =
                directions.iter().map(|own| rows.iter().map(|row| pool.dot(row, own)).collect()).collect();
            directions.iter().map(|own| columns.iter().map(|column| pool.dot(own, column)).collect()).collect()
        };
        let at_point =
            [&self.mass, &self.slopes].map(|rows| rows.iter().map(|row| pool.substitute(row, &map)).collect());
        let [mass, momenta]: [Vec<Vec<ExprId>>; 2] = at_point;
        let [stiffness, friction] = [0, n].map(|from| bent.iter().map(|row| row[from..from + n].to_vec()).collect());
        let [stiffness, friction, mass, slopes] = [stiffness, friction, mass, momenta].map(|rows| reduced(pool, &rows));
        let names = |prime| (1..=directions.len()).map(move |at| format!("u{at}{prime}"));
        self.coordinates = names("").map(|name| pool.fresh_symbol(&name)).collect();
        self.velocities = names("'").map(|name| pool.fresh_symbol(&name)).collect();
        let state = |pool: &mut Pool, symbols: &[Symbol]| -> Vec<ExprId> {
            symbols.iter().map(|symbol| pool.symbol_expr(*symbol)).collect()
        };
        let (places, rates) = (state(pool, &self.coordinates), state(pool, &self.velocities));
        let rows = stiffness.iter().zip(&friction);
        self.load = rows
            .map(|(stiffness, friction)| {
                let parts = [pool.dot(stiffness, &places), pool.dot(friction, &rates)];
                pool.sum(&parts)
            })
            .collect();
        (self.mass, self.slopes) = (mass, slopes);
        let zeros = vec![pool.zero(); 2 * directions.len()];
        Ok((self, zeros))
    }
}

impl Driven {
    /// With the constraints beside the equations.
    fn tied(mut self, model: &Model, gaps: &[ExprId]) -> Result<Self, FloquetError> {
        let span = model.constraints.first().map_or(self.driven_at, |own| own.span);
        if model.equilibria.any() {
            return Err(FloquetError::Unsupported {
                what: "constraints at an equilibrium that does not hold at all times",
                span,
            });
        }
        let symbols = self.symbols();
        let n = self.dimension();
        let pool = &mut self.pool;
        let rate = |pool: &mut Pool, e: ExprId| {
            let slopes = pool.gradient(e, &symbols[1..=n]);
            let mut parts = vec![pool.diff(e, symbols[0])];
            parts.extend(slopes.iter().zip(&symbols[n + 1..]).map(|(slope, velocity)| pool.times(*slope, *velocity)));
            (slopes, pool.sum(&parts))
        };
        let (mut gradients, mut decays, mut slopes) = (Vec::new(), Vec::new(), Vec::new());
        let haste = pool.number(HASTE.into());
        let haste = pool.div(haste, self.period.0);
        for gap in gaps {
            let (gradient, speed) = rate(pool, *gap);
            let (slope, bend) = rate(pool, speed);
            let twice = pool.mul(haste, speed);
            let square = pool.square(haste);
            let held = pool.mul(square, *gap);
            decays.push(pool.linear(&[(bend, Number::ONE), (twice, Number::from(2)), (held, Number::ONE)]));
            gradients.push(gradient);
            slopes.push(slope);
        }
        let rows: Vec<ExprId> = gradients.iter().zip(&slopes).flat_map(|(a, b)| a.iter().chain(b)).copied().collect();
        let tape = Tape::compile(pool, &rows, &symbols).map_err(|_| FloquetError::NotDefined { span })?;
        self.tied = Some(Tied { gradients, decays, tape });
        Ok(self)
    }
}

/// How fast what is off the constraints decays: as exp(-HASTE) in a period.
const HASTE: i64 = 4;

/// The constraints of a motion.
pub(crate) struct Tied {
    /// J, row by row.
    gradients: Vec<Vec<ExprId>>,
    /// c'' where accelerations are 0, and 2 b c' + b² c.
    decays: Vec<ExprId>,
    /// J and dc'/dq, row by row beside each other, from time, coordinates and velocities.
    tape: Tape,
}

impl Tied {
    /// M, with -Jᵀ beside it and J below, and the right sides.
    pub(super) fn border(&self, pool: &mut Pool, matrix: &mut Vec<Vec<ExprId>>, right: &mut Vec<Vec<ExprId>>) {
        let c = self.gradients.len();
        for (i, row) in matrix.iter_mut().enumerate() {
            row.extend(self.gradients.iter().map(|gradient| pool.neg(gradient[i])));
        }
        for (gradient, decay) in self.gradients.iter().zip(&self.decays) {
            let zeros = std::iter::repeat_n(pool.zero(), c);
            matrix.push(gradient.iter().copied().chain(zeros).collect());
            right.push(vec![*decay]);
        }
    }

    /// Displacements of q and q' along the constraints, a column for each of those that determine the others; and which these are.
    pub(super) fn tangent<S: Enclosure>(&self, start: &[S], precision: S::Precision) -> (Vec<usize>, Matrix<S>) {
        let n = start.len() / 2;
        let [zero, one] = [0.0, 1.0].map(|value| S::exact(value, precision));
        let inputs: Vec<S> = std::iter::once(&zero).chain(start).cloned().collect();
        let values = self.tape.prepare::<S>(precision).evaluate(&inputs, &mut Vec::new());
        let mut rows: Vec<Vec<S>> = values.chunks_exact(2 * n).map(<[S]>::to_vec).collect();
        let pivots = reduce(&mut rows, n, |x| x.mid_f64().abs(), precision);
        let free: Vec<usize> = (0..n).filter(|j| !pivots.contains(j)).collect();
        let mut columns: Vec<Vec<S>> = Vec::new();
        let mut later: Vec<Vec<S>> = Vec::new();
        for own in &free {
            let mut place = vec![zero.clone(); n];
            place[*own] = one.clone();
            for (row, pivot) in rows.iter().zip(&pivots) {
                place[*pivot] = row[*own].neg();
            }
            let mut speed = vec![zero.clone(); n];
            for (row, pivot) in rows.iter().zip(&pivots) {
                speed[*pivot] = sum_of_products(&row[n..], &place, precision).neg();
            }
            later.push([vec![zero.clone(); n], place.clone()].concat());
            columns.push([place, speed].concat());
        }
        columns.extend(later);
        let kept = free.iter().copied().chain(free.iter().map(|own| n + own)).collect();
        (kept, Matrix::new(2 * n, columns.concat()).transposed())
    }
}

/// A basis of the directions along which nothing of some rows changes; `None` where the rows are not independent, as far as is decided.
fn kernel(pool: &mut Pool, mut rows: Vec<Vec<ExprId>>, n: usize) -> Option<Vec<Vec<ExprId>>> {
    let mut pivots: Vec<usize> = Vec::new();
    for k in 0..rows.len() {
        let pivot = (0..n).find(|j| pool.is_zero(rows[k][*j]) == ZeroVerdict::NonZero)?;
        clear_symbolic_column(pool, &mut rows, k, pivot);
        pivots.push(pivot);
    }
    let free = (0..n).filter(|j| !pivots.contains(j));
    let direction = |free: usize, pool: &mut Pool| {
        let mut own = vec![pool.zero(); n];
        own[free] = pool.one();
        for (row, pivot) in rows.iter().zip(&pivots) {
            own[*pivot] = pool.neg(row[free]);
        }
        own
    };
    Some(free.map(|free| direction(free, pool)).collect())
}
