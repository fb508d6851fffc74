//! Floating-point numbers of many hundred bits, and exact ones on their way there.

use dashu_float::FBig;
use dashu_float::round::mode::HalfEven;
use dashu_ratio::RBig;

pub(crate) type Real = FBig<HalfEven, 2>;

pub(crate) fn real(x: &RBig, bits: usize) -> Real {
    x.to_float::<HalfEven, 2>(bits).value()
}

pub(crate) fn integer(x: i64, bits: usize) -> Real {
    real(&RBig::from(x), bits)
}

/// A double, exactly; zero if it is not a number.
pub(crate) fn exact(x: f64) -> RBig {
    RBig::try_from(x).unwrap_or(RBig::ZERO)
}

pub(crate) fn ratio(x: &Real) -> RBig {
    RBig::try_from(x.clone()).unwrap_or(RBig::ZERO)
}

/// For tables of results; far out of range it is 0 or infinite.
pub(crate) fn float(x: &Real) -> f64 {
    x.to_f64().value()
}

pub(crate) fn is_zero(x: &Real) -> bool {
    x.repr().significand().is_zero()
}

pub(crate) fn is_negative(x: &Real) -> bool {
    x.repr().significand() < &dashu_int::IBig::ZERO
}

pub(crate) fn abs(x: &Real) -> Real {
    if is_negative(x) { -x } else { x.clone() }
}

pub(crate) fn larger(a: Real, b: Real) -> Real {
    if a >= b { a } else { b }
}

/// x 2^power
pub(crate) fn scale(x: &Real, power: isize) -> Real {
    x.clone() << power
}

/// The exponent of the leading bit plus one; very small for zero.
pub(crate) fn log2(x: &Real) -> isize {
    use dashu_int::ops::BitTest as _;
    if is_zero(x) {
        return isize::MIN / 4;
    }
    x.repr().significand().bit_len() as isize + x.repr().exponent()
}

pub(crate) fn sqrt(x: &Real) -> Real {
    x.sqrt()
}

/// Sine and cosine by their series, which lose a few bits for arguments up to 10.
pub(crate) fn sin_cos(x: &Real, bits: usize) -> (Real, Real) {
    let (mut sin, mut cos) = (integer(0, bits), integer(1, bits));
    let mut term = integer(1, bits);
    for k in 1.. {
        term = &term * x / integer(k, bits);
        if log2(&term) < -(bits as isize) - 8 {
            break;
        }
        match k % 4 {
            0 => cos += &term,
            1 => sin += &term,
            2 => cos -= &term,
            _ => sin -= &term,
        }
    }
    (sin, cos)
}

/// Machin: pi = 16 atan(1/5) - 4 atan(1/239).
pub(crate) fn pi(bits: usize) -> Real {
    let atan = |inverse: i64| {
        let square = integer(inverse * inverse, bits);
        let mut power = integer(1, bits) / integer(inverse, bits);
        let mut sum = power.clone();
        for k in 1.. {
            power = -(power / &square);
            if log2(&power) < -(bits as isize) - 8 {
                break;
            }
            sum += &power / integer(2 * k + 1, bits);
        }
        sum
    };
    integer(16, bits) * atan(5) - integer(4, bits) * atan(239)
}
