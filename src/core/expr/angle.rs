//! Angles: exact values at multiples of pi, reduction, parity, and the functions that undo each
//! other.

use super::{ExprId, Function, Node, ONE, PI, Pool, UNDEFINED, ZERO, intern};
use crate::number::Number;

/// An angle between 0 and pi/2 whose sine and tangent are known.
#[derive(Clone, Debug)]
pub(super) struct KnownAngle {
    /// The angle as a multiple of pi.
    turns: Number,
    sine: ExprId,
    /// [`Node::Undefined`] of the right angle.
    tangent: ExprId,
}

/// A right triangle with a hypotenuse of 1, by one leg, or by both legs.
pub(super) enum Triangle {
    Sine(ExprId),
    Cosine(ExprId),
    Legs { y: ExprId, x: ExprId },
}

/// A fraction of which the denominator is not 0.
pub(crate) fn ratio(numerator: i64, denominator: i64) -> Number {
    Number::ratio(numerator, denominator).unwrap_or_default()
}

impl Pool {
    /// An angle as `turns*pi + rest`, with no multiple of pi in the rest.
    fn split_angle(&mut self, x: ExprId) -> (Number, ExprId) {
        if x == PI {
            return (Number::ONE, ZERO);
        }
        let Node::Sum { constant, terms } = self.node(x) else { return (Number::ZERO, x) };
        // No term has a smaller id than pi.
        let Some((turns, others)) =
            terms.split_first().and_then(|((id, turns), others)| (*id == PI).then_some((turns, others)))
        else {
            return (Number::ZERO, x);
        };
        let (constant, turns, others) = (constant.clone(), turns.clone(), others.to_vec());
        let constant = self.number(constant);
        let rest = self.linear(&others);
        (turns, self.add(constant, rest))
    }

    /// Sine, cosine and tangent: the angle's leading coefficient made positive, multiples of
    /// pi/2 taken out.
    pub(super) fn trigonometric(&mut self, function: Function, x: ExprId) -> ExprId {
        let own = Node::Function(function, x);
        if let Some(known) = self.find(intern::hash(&own), &own) {
            return known;
        }
        let odd = function != Function::Cos;
        let (mut turns, mut rest) = self.split_angle(x);
        let mut negative = false;
        if self.leads_negative(rest) || (rest == ZERO && turns.is_negative()) {
            rest = self.neg(rest);
            turns = turns.neg();
            negative = odd;
        }
        let quarters = turns.mul(&Number::from(2)).floor();
        turns = turns.sub(&quarters.mul(&Number::half()));
        let quarters = quarters.rem_floor(&Number::from(4)).and_then(|q| q.to_i64()).unwrap_or(0);
        let (base, mut flip) = match (function, quarters) {
            (Function::Sin, 1) => (Function::Cos, false),
            (Function::Sin, 2) | (Function::Cos, 1) => (Function::Sin, true),
            (Function::Sin, 3) | (Function::Cos, 2) => (Function::Cos, true),
            (Function::Cos, 3) => (Function::Sin, false),
            (unchanged, _) => (unchanged, false),
        };
        let mut value = if rest == ZERO {
            self.exact_value(base, &turns)
        } else {
            let angle = self.linear(&[(rest, Number::ONE), (PI, turns)]);
            self.of_reduced_angle(base, angle)
        };
        if function == Function::Tan && quarters % 2 == 1 {
            // tan(a + pi/2) = -1/tan(a)
            value = self.div(ONE, value);
            flip = true;
        }
        if flip != negative { self.neg(value) } else { value }
    }

    /// A function of an angle that is reduced: inverse functions are undone.
    fn of_reduced_angle(&mut self, function: Function, angle: ExprId) -> ExprId {
        // The angle's sine, cosine are s/r and c/r.
        let (s, c) = match self.triangle(angle) {
            Some(Triangle::Sine(u)) => (u, self.leg(u)),
            Some(Triangle::Cosine(u)) => (self.leg(u), u),
            Some(Triangle::Legs { y, x }) => (y, x),
            None => return self.intern(Node::Function(function, angle)),
        };
        if function == Function::Tan {
            return self.div(s, c);
        }
        let r = if let Some(Triangle::Legs { .. }) = self.triangle(angle) {
            let (s2, c2) = (self.square(s), self.square(c));
            let r2 = self.add(s2, c2);
            self.sqrt(r2)
        } else {
            ONE
        };
        let numerator = if function == Function::Sin { s } else { c };
        self.div(numerator, r)
    }

    /// The right triangle with an angle that is the value of an arc function.
    pub(super) fn triangle(&self, angle: ExprId) -> Option<Triangle> {
        if let Node::Atan2 { y, x } = *self.node(angle) {
            return Some(Triangle::Legs { y, x });
        }
        match self.as_function(angle)? {
            (Function::Asin, u) => Some(Triangle::Sine(u)),
            (Function::Acos, u) => Some(Triangle::Cosine(u)),
            (Function::Atan, u) => Some(Triangle::Legs { y: u, x: ONE }),
            _ => None,
        }
    }

    /// `sqrt(1 - u^2)`.
    fn leg(&mut self, u: ExprId) -> ExprId {
        let square = self.square(u);
        let difference = self.sub(ONE, square);
        self.sqrt(difference)
    }

    /// A function at `turns*pi`, with `turns` from 0 to below 1/2.
    fn exact_value(&mut self, function: Function, turns: &Number) -> ExprId {
        let complement = Number::half().sub(turns);
        let (function, turns) = if *turns <= complement {
            (function, turns.clone())
        } else if function == Function::Tan {
            let cotangent = self.exact_up_to_eighth(Function::Tan, &complement);
            return self.div(ONE, cotangent);
        } else if function == Function::Sin {
            (Function::Cos, complement)
        } else {
            (Function::Sin, complement)
        };
        self.exact_up_to_eighth(function, &turns)
    }

    /// A function at `turns*pi`, with `turns` from 0 to 1/4: as (factor, radicand) of square
    /// roots, where that is simple.
    fn exact_up_to_eighth(&mut self, function: Function, turns: &Number) -> ExprId {
        type Row = ((i64, u64), &'static [(i64, i64, i64)]);
        // (numerator, denominator, radicand)
        const SINES: &[Row] = &[
            ((0, 1), &[]),
            ((1, 12), &[(1, 4, 6), (-1, 4, 2)]),
            ((1, 10), &[(1, 4, 5), (-1, 4, 1)]),
            ((1, 6), &[(1, 2, 1)]),
            ((1, 4), &[(1, 2, 2)]),
        ];
        const COSINES: &[Row] = &[
            ((0, 1), &[(1, 1, 1)]),
            ((1, 12), &[(1, 4, 6), (1, 4, 2)]),
            ((1, 6), &[(1, 2, 3)]),
            ((1, 5), &[(1, 4, 5), (1, 4, 1)]),
            ((1, 4), &[(1, 2, 2)]),
        ];
        const TANGENTS: &[Row] = &[
            ((0, 1), &[]),
            ((1, 12), &[(2, 1, 1), (-1, 1, 3)]),
            ((1, 8), &[(1, 1, 2), (-1, 1, 1)]),
            ((1, 6), &[(1, 3, 3)]),
            ((1, 4), &[(1, 1, 1)]),
        ];
        let (table, eighth) = match function {
            Function::Sin => (SINES, Some(-1)),
            Function::Cos => (COSINES, Some(1)),
            _ => (TANGENTS, None),
        };
        let parts = turns.small_parts();
        if let Some((_, terms)) = table.iter().find(|(angle, _)| Some(*angle) == parts) {
            return self.surds(terms);
        }
        if let (Some((1, 8)), Some(sign)) = (parts, eighth) {
            // sqrt(2 ± sqrt(2))/2
            let radicand = self.surds(&[(2, 1, 1), (sign, 1, 2)]);
            let root = self.sqrt(radicand);
            return self.scale(root, &Number::half());
        }
        let angle = self.scale(PI, turns);
        self.intern(Node::Function(function, angle))
    }

    /// The sum of `numerator/denominator*sqrt(radicand)`.
    fn surds(&mut self, terms: &[(i64, i64, i64)]) -> ExprId {
        let surd = |(numerator, denominator, radicand): &(i64, i64, i64)| {
            let radicand = self.integer(*radicand);
            (self.sqrt(radicand), ratio(*numerator, *denominator))
        };
        let terms: Vec<(ExprId, Number)> = terms.iter().map(surd).collect();
        self.linear(&terms)
    }

    /// Arc sine, arc cosine and arc tangent: parity and known angles.
    pub(super) fn inverse_angle(&mut self, function: Function, x: ExprId) -> ExprId {
        if function != Function::Atan && self.as_number(x).is_some_and(|value| value.abs() > Number::ONE) {
            return UNDEFINED;
        }
        if self.leads_negative(x) {
            let opposite = self.neg(x);
            let value = self.inverse_angle_of_positive(function, opposite);
            // acos(-x) = pi - acos(x); the others are odd.
            return if function == Function::Acos { self.sub(PI, value) } else { self.neg(value) };
        }
        self.inverse_angle_of_positive(function, x)
    }

    fn inverse_angle_of_positive(&mut self, function: Function, x: ExprId) -> ExprId {
        let turns = if self.is_constant(x) { self.known_angle(function, x) } else { None };
        match turns {
            Some(turns) if function == Function::Acos => self.scale(PI, &Number::half().sub(&turns)),
            Some(turns) => self.scale(PI, &turns),
            None => self.intern(Node::Function(function, x)),
        }
    }

    /// The angle in [0, pi/2], as a multiple of pi, whose tangent (for the arc tangent) or sine
    /// (for the others) is this constant.
    fn known_angle(&mut self, function: Function, x: ExprId) -> Option<Number> {
        if x == ZERO {
            return Some(Number::ZERO);
        }
        if let Some((of, angle)) = self.as_function(x) {
            // sin, cos and tan of constants are reduced to angles from 0 to pi/4.
            let (turns, rest) = self.split_angle(angle);
            if rest != ZERO {
                return None;
            }
            return match (of, function == Function::Atan) {
                (Function::Sin, false) | (Function::Tan, true) => Some(turns),
                (Function::Cos, false) => Some(Number::half().sub(&turns)),
                _ => None,
            };
        }
        if self.known_angles.is_empty() {
            for (n, d) in [(1, 12), (1, 10), (1, 8), (1, 6), (1, 4), (3, 10), (1, 3), (3, 8), (5, 12), (1, 2)] {
                let turns = ratio(n, d);
                let angle = self.scale(PI, &turns);
                let sine = self.trigonometric(Function::Sin, angle);
                let tangent = self.trigonometric(Function::Tan, angle);
                self.known_angles.push(KnownAngle { turns, sine, tangent });
            }
        }
        self.known_angles
            .iter()
            .find(|known| x == if function == Function::Atan { known.tangent } else { known.sine })
            .map(|known| known.turns.clone())
    }
}
