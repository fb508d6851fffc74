//! The true eigenvalues: closed forms in big floats, and the reference of `examples/campaign`, which
//! shares nothing with the library.

use dashu_ratio::RBig;
use faer::{Mat, Side};
use librate::number::Number;

use super::judge::binary;
use super::real::{Real, integer, is_negative, is_zero, log2, pi, scale, sin_cos};
use super::reference::{Matrices, Truth, to_reals};

/// True eigenvalues and how many digits of them are.
pub(crate) struct Known {
    pub(crate) values: Vec<Number>,
    pub(crate) digits: usize,
}

/// A big float as the number that it is.
pub(crate) fn number(x: &Real) -> Number {
    let repr = x.repr();
    binary(repr.significand().clone(), repr.exponent() as i64)
}

fn decimal_digits(bits: usize) -> usize {
    (bits as f64 * std::f64::consts::LOG10_2) as usize
}

/// 4 sin²(jπ/2n) for some j.
fn squares(n: usize, all: impl Iterator<Item = usize>) -> Known {
    let bits = 448;
    let step = pi(bits) / integer(2 * n as i64, bits);
    let value = |j: usize| {
        let (sin, _) = sin_cos(&(&step * integer(j as i64, bits)), bits);
        number(&(integer(4, bits) * &sin * &sin))
    };
    // The series lose a few bits, and the square as many again; small angles theirs.
    Known { values: all.map(value).collect(), digits: decimal_digits(bits - 32 - n.ilog2() as usize) }
}

/// A chain of n unit masses on n - 1 unit springs, both ends free: ω² = 4 sin²(jπ/2n), j = 0..n-1.
pub(crate) fn free_chain(n: usize) -> Known {
    squares(n, 0..n)
}

/// The lowest of a chain of n unit masses between two walls: ω² = 4 sin²(jπ/2(n + 1)), j = 1, 2, ...
pub(crate) fn sines(n: usize, most: usize) -> Known {
    squares(n + 1, 1..n.min(most) + 1)
}

/// The zeros of the Laguerre polynomial L_n, rising (Daniel Bernoulli, 1733: the hanging chain), each
/// known to lie in an interval of its own at whose ends L_n has different signs. There are n of them
/// and no more, so none is missing.
pub(crate) fn laguerre_zeros(n: usize) -> Option<Known> {
    // As many digits as someone is going to ask for.
    let bits = match n {
        0..=40 => 800,
        41..=100 => 400,
        _ => 256,
    };
    // Golub and Welsch: the eigenvalues of the matrix of the recurrence, for a start.
    let start = Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => (2 * i + 1) as f64,
        1 => i.max(j) as f64,
        _ => 0.0,
    });
    let start = start.self_adjoint_eigenvalues(Side::Lower).ok()?;
    let weights: Vec<(Real, Real)> = (0..n as i64).map(|k| (integer(2 * k + 1, bits), integer(k * k, bits))).collect();
    // Of the polynomials with leading coefficient 1 the last two:
    // P_{k+1} = (x - 2k - 1) P_k - k² P_{k-1}.
    let last_two = |x: &Real| {
        let (mut before, mut now) = (integer(0, bits), integer(1, bits));
        for (center, square) in &weights {
            let next = (x - center) * &now - square * &before;
            (before, now) = (now, next);
        }
        (before, now)
    };
    let order = integer(n as i64, bits);
    let reach = bits / 2;
    let mut values = Vec::with_capacity(n);
    let mut last = integer(0, bits);
    for start in start {
        let mut x = Real::try_from(start).ok()?.with_precision(bits).value();
        // Newton, with P_n' = (n/x) (P_n + n P_{n-1}).
        for _ in 0..20 {
            let (before, now) = last_two(&x);
            let slope = (&now + &order * before) * &order / &x;
            if is_zero(&slope) {
                return None;
            }
            let step = now / slope;
            let small = log2(&step) < log2(&x) - bits as isize * 5 / 8;
            x -= step;
            if small {
                break;
            }
        }
        let width = scale(&x, -(reach as isize));
        let (low, high) = (&x - &width, &x + &width);
        let signs = [&low, &high].map(|x| is_negative(&last_two(x).1));
        if low <= last || signs[0] == signs[1] {
            return None;
        }
        last = high;
        values.push(number(&x));
    }
    Some(Known { values, digits: decimal_digits(reach) })
}

/// The eigenvalues of exact matrices by Cholesky, Householder and QL in big floats of two precisions; as
/// many digits as agree. `None` where M is not positive definite.
pub(crate) fn computed(mass: &[Vec<RBig>], stiffness: &[Vec<RBig>]) -> Option<Known> {
    let at = |bits: usize| {
        let matrices = Matrices { mass: to_reals(mass, bits), stiffness: to_reals(stiffness, bits) };
        Truth::new(&matrices, bits)
    };
    let (rough, fine) = (at(768)?, at(960)?);
    let mut bits = 768;
    for (a, b) in rough.values.iter().zip(&fine.values) {
        if is_zero(a) != is_zero(b) {
            return None;
        }
        let apart = a - b;
        if !is_zero(&apart) {
            bits = bits.min(usize::try_from(log2(b) - log2(&apart)).ok()?);
        }
    }
    Some(Known { values: fine.values.iter().map(number).collect(), digits: decimal_digits(bits) })
}
