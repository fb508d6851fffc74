//! Functions of one argument and the two-argument arc tangent: exact values, parity, inverses.
//! What concerns angles is in [`super::angle`].

use super::{ExprId, Function, Node, ONE, PI, Pool, UNDEFINED, ZERO};
use crate::number::Number;

impl Pool {
    /// A function of an expression, simplified as far as is always right.
    pub fn apply(&mut self, function: Function, x: ExprId) -> ExprId {
        if x == UNDEFINED {
            return UNDEFINED;
        }
        match function {
            Function::Sin | Function::Cos | Function::Tan => self.trigonometric(function, x),
            Function::Asin | Function::Acos | Function::Atan => self.inverse_angle(function, x),
            Function::Sinh | Function::Cosh | Function::Tanh => self.hyperbolic(function, x),
            Function::Exp => self.exponential_function(x),
            Function::Ln => self.logarithm(x),
            Function::Abs => self.absolute(x),
        }
    }

    /// Sine.
    pub fn sin(&mut self, x: ExprId) -> ExprId {
        self.apply(Function::Sin, x)
    }

    /// Cosine.
    pub fn cos(&mut self, x: ExprId) -> ExprId {
        self.apply(Function::Cos, x)
    }

    /// Absolute value.
    pub fn abs(&mut self, x: ExprId) -> ExprId {
        self.apply(Function::Abs, x)
    }

    fn hyperbolic(&mut self, function: Function, x: ExprId) -> ExprId {
        let even = function == Function::Cosh;
        if x == ZERO {
            return if even { ONE } else { ZERO };
        }
        if !self.leads_negative(x) {
            return self.intern(Node::Function(function, x));
        }
        let x = self.neg(x);
        let value = self.intern(Node::Function(function, x));
        if even { value } else { self.neg(value) }
    }

    fn exponential_function(&mut self, x: ExprId) -> ExprId {
        if x == ZERO {
            return ONE;
        }
        // exp(r*ln(u)) = u^r.
        if let [(term, factor)] = self.terms(x).as_slice()
            && let Node::Function(Function::Ln, u) = *self.node(*term)
        {
            return self.powr(u, factor);
        }
        self.intern(Node::Function(Function::Exp, x))
    }

    fn logarithm(&mut self, x: ExprId) -> ExprId {
        if let Some(value) = self.as_number(x) {
            if value.is_zero() || value.is_negative() {
                return UNDEFINED;
            }
            if value.is_one() {
                return ZERO;
            }
        }
        if let Node::Function(Function::Exp, u) = *self.node(x) {
            return u;
        }
        self.intern(Node::Function(Function::Ln, x))
    }

    fn absolute(&mut self, x: ExprId) -> ExprId {
        if self.is_nonnegative(x) {
            return x;
        }
        if let Node::Product(factors) = self.node(x) {
            let mut factors = factors.to_vec();
            for (base, exponent) in &mut factors {
                if !self.is_nonnegative_power(*base, exponent) {
                    *base = self.absolute(*base);
                }
            }
            return self.product_of_powers(&factors);
        }
        // A multiple of something else, as c*x*y; one step, multiples do not nest.
        let (factor, core) = self.split_content(x);
        if core != x {
            let value = self.absolute(core);
            return self.scale(value, &factor.abs());
        }
        if self.flags(core).nonpositive { self.neg(core) } else { self.intern(Node::Function(Function::Abs, core)) }
    }

    /// The angle of the point (x, y) in (-pi, pi]; of the origin [`Node::Undefined`].
    pub fn atan2(&mut self, y: ExprId, x: ExprId) -> ExprId {
        if y == UNDEFINED || x == UNDEFINED || (y == ZERO && x == ZERO) {
            return UNDEFINED;
        }
        if self.is_positive_constant(x) {
            let ratio = self.div(y, x);
            return self.apply(Function::Atan, ratio);
        }
        if let Some(is_zero) = self.as_number(x).map(Number::is_zero) {
            match self.sign_of_constant(y) {
                Some(sign) if is_zero => {
                    let quarter = Number::half();
                    return self.scale(PI, &if sign { quarter.neg() } else { quarter });
                }
                // Below the branch cut the angle is negative; the sign of y has to be known.
                Some(sign) => {
                    let ratio = self.div(y, x);
                    let angle = self.apply(Function::Atan, ratio);
                    return if sign { self.sub(angle, PI) } else { self.add(angle, PI) };
                }
                None if y == ZERO => return PI,
                None => {}
            }
        }
        let (cy, y1) = self.split_content(y);
        let (cx, x1) = self.split_content(x);
        let common = if y == ZERO { cx.abs() } else { cy.gcd(&cx) };
        let (y, x) = match common.recip().filter(|_| !common.is_one()) {
            Some(inverse) => (self.scale(y1, &cy.mul(&inverse)), self.scale(x1, &cx.mul(&inverse))),
            None => (y, x),
        };
        self.intern(Node::Atan2 { y, x })
    }

    /// Whether a constant that shows its sign is negative; `None` of 0 and where it does not show.
    fn sign_of_constant(&mut self, e: ExprId) -> Option<bool> {
        if self.is_positive_constant(e) {
            return Some(false);
        }
        let opposite = self.neg(e);
        self.is_positive_constant(opposite).then_some(true)
    }

    /// Whether the expression is a constant above 0 by its form: a number or a root of one, pi,
    /// sums of such with positive coefficients.
    fn is_positive_constant(&self, e: ExprId) -> bool {
        let is_positive = |base: ExprId| match self.as_number(base) {
            Some(value) => !value.is_negative() && !value.is_zero(),
            None => base == PI,
        };
        let is_positive_term = |term: ExprId| self.factors(term).iter().all(|(base, _)| is_positive(*base));
        self.terms(e).iter().all(|(t, c)| !c.is_negative() && is_positive_term(*t))
    }
}
