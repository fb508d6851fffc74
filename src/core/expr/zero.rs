//! Whether an expression is identically 0, tested at random points modulo a prime.
//!
//! Every expression is evaluated at points of the field of [`super::modular`], as
//! [`super::point`] describes. A rational function that vanishes at a few such points is 0 but for
//! a probability of about degree/p each.
//!
//! An identity that holds for arbitrary functions and signs holds for the true ones, so that
//! [`ZeroVerdict::Zero`] stands; that something is not 0 is only said where nothing was
//! replaced.

use super::point::{ATTEMPTS, ModularPoint, POINTS_SIGNS, Plan};
use super::{ExprId, Node, Pool, ZERO};

/// What is known about whether an expression is identically 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZeroVerdict {
    /// It is 0 wherever it has a value (but for a probability below 1e-6, in practice far below).
    Zero,
    /// It is not 0.
    NonZero,
    /// Undecided.
    Unknown,
}

/// Points that have to vanish where nothing is random.
const POINTS_EXACT: usize = 4;
/// Points without a single zero after which nothing more is expected: too many roots do not exist.
const HOPELESS: u64 = 32;

impl Pool {
    /// Whether an expression is 0 for certain; see [`Pool::is_zero`].
    #[must_use]
    pub fn vanishes(&self, e: ExprId) -> bool {
        self.is_zero(e) == ZeroVerdict::Zero
    }

    /// Whether two expressions are equal for certain.
    pub fn agree(&mut self, a: ExprId, b: ExprId) -> bool {
        let difference = self.sub(a, b);
        self.vanishes(difference)
    }

    /// Whether the expression is identically 0; see the module's documentation for what is
    /// decided.
    #[must_use]
    pub fn is_zero(&self, root: ExprId) -> ZeroVerdict {
        if root == ZERO {
            return ZeroVerdict::Zero;
        }
        match self.node(root) {
            Node::Number(_) | Node::Pi | Node::Symbol(_) => return ZeroVerdict::NonZero,
            Node::Undefined => return ZeroVerdict::Unknown,
            Node::Sum { .. } | Node::Product(_) | Node::Power { .. } | Node::Function(..) | Node::Atan2 { .. } => {}
        }
        let plan = Plan::new(self, &[root]);
        let mut zeros = 0;
        for seed in 0..ATTEMPTS {
            let values = |symbol| ModularPoint::random_value(seed, symbol);
            let Some(point) = plan.evaluate(self, &values, seed) else { continue };
            let certainty = point.certainty;
            if certainty.vanishing_root {
                return ZeroVerdict::Unknown;
            }
            if point.values.first() == Some(&0) {
                zeros += 1;
                let enough = if certainty.random_sign || certainty.missing_root { POINTS_SIGNS } else { POINTS_EXACT };
                if zeros >= enough {
                    return ZeroVerdict::Zero;
                }
            } else if certainty.is_exact() {
                return ZeroVerdict::NonZero;
            } else if !certainty.missing_root || (zeros == 0 && seed >= HOPELESS) {
                return ZeroVerdict::Unknown;
            }
        }
        ZeroVerdict::Unknown
    }
}
