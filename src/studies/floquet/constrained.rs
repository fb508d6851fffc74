//! Driven models with constraints: linearised about rest, in the directions that the constraints leave.
//!
//! At a point where M q'' + h = Jᵀ mu holds at rest for some mu(t), small displacements are q = Z u with J Z = 0, and
//! Zᵀ M Z u'' + Zᵀ (dh/dq') Z u' + Zᵀ (dh/dq - Σ mu_a d²c_a/dq²) Z u = 0. Momenta of u follow as Zᵀ p; what Z changes along the
//! constraints adds a gradient to them, which no bracket sees. Motions other than rest are left to independent coordinates.

use super::error::FloquetError;
use super::motion::Driven;
use crate::flow::solved;
use librate_core::expr::{ExprId, Pool, Symbol, ZeroVerdict};
use librate_core::model::Model;

impl Driven {
    /// The equations of small displacements from a point along the constraints, as a driven model that rests at 0, and that state
    /// in place of `begin`; without constraints all stays as it is.
    ///
    /// # Errors
    /// Where the point does not satisfy the constraints, they change with time, or a force moves it along them.
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
        if gaps.iter().any(|gap| self.pool.depends_on(*gap, &|symbol| symbol == self.time)) {
            return Err(unsupported("constraints that change with time"));
        }
        let pool = &mut self.pool;
        let vanishes = |pool: &mut Pool, e: ExprId| pool.is_zero(e) == ZeroVerdict::Zero;
        let there = pool.substitute(&gaps, &map);
        if !there.iter().all(|gap| vanishes(pool, *gap)) {
            return Err(unsupported("constraints that do not hold at the equilibrium given"));
        }
        let gradients: Vec<Vec<ExprId>> = gaps.iter().map(|gap| pool.gradient(*gap, &symbols[1..=n])).collect();
        let slopes: Vec<Vec<ExprId>> = gradients.iter().map(|row| pool.substitute(row, &map)).collect();
        let directions = kernel(pool, slopes.clone(), n).ok_or(unsupported("constraints that depend on each other"))?;
        // The forces of the constraints: (J Jᵀ) mu = J h.
        let loads = pool.substitute(&self.load, &map);
        let dot = |pool: &mut Pool, a: &[ExprId], b: &[ExprId]| {
            let terms: Vec<ExprId> = a.iter().zip(b).map(|(a, b)| pool.mul(*a, *b)).collect();
            pool.sum(&terms)
        };
        let square = slopes.iter().map(|row| slopes.iter().map(|other| dot(pool, row, other)).collect()).collect();
        let right = slopes.iter().map(|row| vec![dot(pool, row, &loads)]).collect();
        let forces = solved(pool, square, right).ok_or(unsupported("constraints that depend on each other"))?.concat();
        let still = directions.iter().all(|direction| {
            let force = dot(pool, direction, &loads);
            vanishes(pool, force)
        });
        if !still {
            return Err(unsupported("constraints about anything but an equilibrium"));
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
                directions.iter().map(|own| rows.iter().map(|row| dot(pool, row, own)).collect()).collect();
            directions.iter().map(|own| columns.iter().map(|column| dot(pool, own, column)).collect()).collect()
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
                let parts = [dot(pool, stiffness, &places), dot(pool, friction, &rates)];
                pool.sum(&parts)
            })
            .collect();
        (self.mass, self.slopes) = (mass, slopes);
        let zeros = vec![pool.zero(); 2 * directions.len()];
        Ok((self, zeros))
    }
}

/// A basis of the directions along which nothing of some rows changes; `None` where the rows are not independent, as far as is decided.
fn kernel(pool: &mut Pool, mut rows: Vec<Vec<ExprId>>, n: usize) -> Option<Vec<Vec<ExprId>>> {
    let mut pivots: Vec<usize> = Vec::new();
    for k in 0..rows.len() {
        let pivot = (0..n).find(|j| pool.is_zero(rows[k][*j]) == ZeroVerdict::NonZero)?;
        let divisor = rows[k][pivot];
        for entry in &mut rows[k] {
            *entry = pool.div(*entry, divisor);
        }
        let own = rows[k].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(at, _)| *at != k) {
            let factor = row[pivot];
            for (entry, other) in row.iter_mut().zip(&own) {
                let part = pool.mul(factor, *other);
                *entry = pool.sub(*entry, part);
            }
        }
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
