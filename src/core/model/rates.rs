//! Total time derivatives of the model's expressions.

use super::names::World;
use crate::expr::ExprId;

impl World {
    /// The total time derivative: the chain rule through coordinates, velocities and the time.
    pub(super) fn time_derivative(&mut self, root: ExprId) -> ExprId {
        if let Some(beyond) = self.beyond_acceleration(root) {
            return beyond;
        }
        loop {
            match self.pool.derivative(&mut self.rates, root) {
                Ok(derivative) => return derivative,
                Err(symbol) => {
                    let rate = self.rate(symbol).unwrap_or(self.pool.zero());
                    self.rates.set(&mut self.pool, symbol, rate);
                }
            }
        }
    }

    /// No energy may contain accelerations, nor what is beyond them: a symbol stands for the rate
    /// of an expression that contains one, a new one each time so that nothing cancels.
    fn beyond_acceleration(&mut self, root: ExprId) -> Option<ExprId> {
        if !self.accelerated {
            return None;
        }
        let symbols = self.pool.symbols(root);
        let mut kinds = symbols.iter().filter_map(|symbol| self.kinds.get(*symbol));
        let kind = kinds.find(|kind| kind.is_acceleration())?;
        let beyond = self.pool.fresh_symbol("x'''");
        self.kinds.insert(beyond, kind);
        Some(self.pool.symbol_expr(beyond))
    }
}
