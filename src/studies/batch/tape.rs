//! Expressions as straight-line operations on lanes, with a running error analysis.
//!
//! Beside every value stands a bound of its distance from the exact number, in the manner of
//! Wilkinson's running error analysis (N. J. Higham, Accuracy and Stability of Numerical
//! Algorithms, 2nd ed., §3.3): what the operands are off by is carried through the operation, and
//! what the operation itself rounds off, at most u|result| with u = 2^-53, is added.

use crate::program::{Operation, Program};
use librate_core::precision::{Ball, DoubleDouble, Function, LANES, Lane, Scalar};

/// u, the largest relative error of one rounding to nearest.
pub(super) const U: f64 = f64::EPSILON / 2.0;
/// Each bound below is a sum of nonnegative parts made with at most 12 roundings, each of which
/// loses at most a factor 1 + u: (1 + 2^-49) > (1 + u)^12 (1 + u) makes up for them.
const GROW: f64 = 1.0 + 8.0 * f64::EPSILON;
/// More than underflow takes away from a product and from the parts of its bound, 3·2^-1075.
const TINY: f64 = f64::MIN_POSITIVE;
/// Divisors below are refused, so that underflow in the bound of a quotient, 2^-1075 over half
/// the divisor, stays below [`TINY_QUOTIENT`].
const SMALLEST_DIVISOR: f64 = 1e-150;
const TINY_QUOTIENT: f64 = 1e-170;

/// The values of a program's registers and the bounds of their errors.
pub(super) struct Registers {
    pub(super) value: Vec<Lane>,
    pub(super) error: Vec<Lane>,
}

impl Registers {
    pub(super) fn new(program: &Program) -> Self {
        let count = program.registers();
        let mut value = vec![Lane::ZERO; count];
        let mut error = vec![Lane::ZERO; count];
        for (at, (constant, bound)) in program.constants.iter().enumerate() {
            value[at] = Lane::splat(*constant);
            error[at] = Lane::splat(*bound);
        }
        Self { value, error }
    }
}

/// Runs a program on the inputs that stand in the registers.
#[inline(always)]
pub(super) fn run<const BOUNDS: bool>(program: &Program, registers: &mut Registers) {
    let first = program.constants.len() + program.inputs;
    for (at, operation) in program.operations.iter().enumerate() {
        let (value, error) = step::<BOUNDS>(operation, registers);
        registers.value[first + at] = value;
        if BOUNDS {
            registers.error[first + at] = error;
        }
    }
}

#[inline(always)]
fn step<const BOUNDS: bool>(operation: &Operation, registers: &Registers) -> (Lane, Lane) {
    let value = |at: u32| registers.value[at as usize];
    let error = |at: u32| {
        if BOUNDS { registers.error[at as usize] } else { Lane::ZERO }
    };
    let (u, grow) = (Lane::splat(U), Lane::splat(GROW));
    match *operation {
        Operation::Add(a, b) => {
            let result = value(a) + value(b);
            // A sum in the subnormal range is exact, so that nothing is said of underflow.
            (result, (error(a) + error(b) + u * result.abs()) * grow)
        }
        Operation::Subtract(a, b) => {
            let result = value(a) - value(b);
            (result, (error(a) + error(b) + u * result.abs()) * grow)
        }
        Operation::Multiply(a, b) => {
            // |ab - AB| <= |a||b - B| + |a - A|(|b| + |b - B|)
            let result = value(a) * value(b);
            let carried = value(a).abs() * error(b) + error(a) * (value(b).abs() + error(b));
            let bound = (carried + u * result.abs()) * grow + Lane::splat(TINY);
            (result, bound)
        }
        Operation::Divide(a, b) => {
            // v - A/B = (v(B - b) + (vb - a) + (a - A))/B with |vb - a| <= u|v||b|
            let result = value(a) / value(b);
            if !BOUNDS {
                return (result, Lane::ZERO);
            }
            let divisor = value(b).abs();
            let size = result.abs();
            let above = size * error(b) + error(a) + u * size * divisor;
            let bound = above / (divisor - error(b)) * grow + Lane::splat(TINY_QUOTIENT);
            let least = (error(b) + error(b)).max(Lane::splat(SMALLEST_DIVISOR));
            (result, bound.choose(divisor.above(least), Lane::splat(f64::INFINITY)))
        }
        Operation::Negate(a) => (-value(a), error(a)),
        Operation::Root(a) => {
            // |sqrt A - sqrt a| = |A - a|/(sqrt A + sqrt a) <= |A - a|/sqrt a
            let result = value(a).sqrt();
            if !BOUNDS {
                return (result, Lane::ZERO);
            }
            let mut bound = (error(a) / result + u * result) * grow;
            for i in 0..LANES {
                let (a, e) = (value(a).0[i], error(a).0[i]);
                bound.0[i] = if a == 0.0 && e == 0.0 {
                    0.0
                } else if a > e && a > TINY {
                    bound.0[i]
                } else {
                    f64::INFINITY
                };
            }
            (result, bound)
        }
        Operation::Power(a, b) => {
            each::<BOUNDS>([(value(a), error(a)), (value(b), error(b))], |x, y| x.pow(&y), f64::powf)
        }
        Operation::Angle { y, x } => each::<BOUNDS>(
            [(value(y), error(y)), (value(x), error(x))],
            |y, x| Scalar::atan2(&y, &x),
            |y, x| Scalar::atan2(&y, &x),
        ),
        Operation::Apply(function, a) => apply::<BOUNDS>(function, value(a), error(a)),
        Operation::Undefined => (Lane::splat(f64::NAN), Lane::splat(f64::INFINITY)),
    }
}

#[inline(never)]
fn apply<const BOUNDS: bool>(function: Function, a: Lane, e: Lane) -> (Lane, Lane) {
    each::<BOUNDS>(
        [(a, e), (Lane::ZERO, Lane::ZERO)],
        |x, _| Scalar::apply(&x, function),
        |x, _| Scalar::apply(&x, function),
    )
}

/// A function that has no vector form, number by number: with bounds over enclosures, whose error
/// is proved; without, the machine's own.
#[inline(always)]
fn each<const BOUNDS: bool>(
    operands: [(Lane, Lane); 2],
    enclosed: impl Fn(Ball, Ball) -> Ball,
    plain: impl Fn(f64, f64) -> f64,
) -> (Lane, Lane) {
    let [(a, ea), (b, eb)] = operands;
    let (mut value, mut error) = (Lane::ZERO, Lane::ZERO);
    for i in 0..LANES {
        if BOUNDS {
            let ball = |x: f64, e: f64| Ball::new(DoubleDouble::exact(x), e);
            let result = enclosed(ball(a.0[i], ea.0[i]), ball(b.0[i], eb.0[i]));
            value.0[i] = result.mid_f64();
            error.0[i] = result.mid_f64_error();
        } else {
            value.0[i] = plain(a.0[i], b.0[i]);
        }
    }
    (value, error)
}
