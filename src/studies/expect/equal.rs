//! Whether two expressions are the same function.

use librate_core::expr::{ExprId, Pool, Tape, ZeroVerdict};
use librate_core::number::Number;
use librate_core::precision::Big;

/// Precision of the comparison at points, and what may be left of a difference of numbers near 1.
const BITS: usize = 400;
const LEFT: f64 = 1e-60;
/// Points that are tried, and how many of them have to have a value.
const POINTS: usize = 20;
const LEAST: usize = 3;

/// Whether two expressions of a pool are equal: by an identity where that decides
/// ([`Pool::is_zero`]), else at points with all symbols between 0.3 and 0.9, where they have to agree to 60 digits.
pub fn are_equal(pool: &mut Pool, a: ExprId, b: ExprId) -> bool {
    if a == b {
        return true;
    }
    let difference = pool.sub(a, b);
    match pool.is_zero(difference) {
        ZeroVerdict::Zero => true,
        ZeroVerdict::NonZero => false,
        ZeroVerdict::Unknown => agree_at_points(pool, difference, a),
    }
}

/// Whether a difference vanishes beside the size of one of its sides.
fn agree_at_points(pool: &Pool, difference: ExprId, side: ExprId) -> bool {
    let roots = [difference, side];
    let symbols = pool.symbols_of(&roots);
    let Ok(tape) = Tape::compile(pool, &roots, &symbols) else { return false };
    let tape = tape.prepare::<Big>(BITS);
    let mut decided = 0;
    // Lehmer's generator: any points will do, but the same ones every time.
    let mut state = 12_345_i64;
    let mut next = || {
        state = state * 48_271 % 2_147_483_647;
        let value = Number::ratio(300 + state % 600, 1000).unwrap_or_default();
        Big::from_number(&value, BITS)
    };
    for _ in 0..POINTS {
        let point: Vec<Big> = symbols.iter().map(|_| next()).collect();
        let values = tape.evaluate(&point, &mut Vec::new());
        if let [difference, side] = values.as_slice()
            && difference.is_finite()
            && side.is_finite()
        {
            let size = side.mid_f64().abs().max(1.0);
            if difference.mid_f64().abs() > LEFT * size {
                return false;
            }
            decided += 1;
        }
    }
    decided >= LEAST
}

/// Whether the left sides of two equations `left = 0` vanish together: whether they are the same but for a factor,
/// which is read off an acceleration, in which both are linear.
pub(super) fn same_equation(pool: &mut Pool, accelerations: &[ExprId], a: ExprId, b: ExprId) -> bool {
    for acceleration in accelerations {
        let Some(symbol) = pool.as_symbol(*acceleration) else { continue };
        let (of_a, of_b) = (pool.diff(a, symbol), pool.diff(b, symbol));
        let zero = pool.zero();
        match (are_equal(pool, of_a, zero), are_equal(pool, of_b, zero)) {
            (true, true) => {}
            (false, false) => {
                let (left, right) = (pool.mul(a, of_b), pool.mul(b, of_a));
                return are_equal(pool, left, right);
            }
            (true, false) | (false, true) => return false,
        }
    }
    let opposite = pool.neg(b);
    are_equal(pool, a, b) || are_equal(pool, a, opposite)
}
