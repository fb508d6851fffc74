//! Elementary functions of numbers of any precision.
//!
//! At the midpoint they are those of dashu-float, which promises correct rounding: its functions
//! carry a proved radius along and try again with more digits until the rounded result is decided
//! (Ziv, ACM TOMS 17 (1991); `ziv.rs` there), so the error is at most half a unit of the last
//! place. They are called with [`GUARD`] more bits than wanted, and half of those are given away as
//! error. The radius of the argument enters through a bound of the derivative over the ball.
//!
//! dashu-float panics nowhere behind `Context` as long as precisions are limited and arguments
//! finite; arguments so large or small that it would work with very many bits do not reach it.

use std::cell::RefCell;
use std::ops::{Add, Div, Mul};

use dashu_float::round::{Rounded, mode::HalfEven};
use dashu_float::{ConstCache, Context, FBig, FpResult, Repr};

use super::super::magnitude::Magnitude;
use super::super::scalar::{Function, Scalar, functions, operators, own_methods};
use super::{Big, MOST_BITS};
use crate::number::Number;

/// Bits that the functions are evaluated with beyond those asked for.
const GUARD: usize = 32;
/// Sines and cosines of numbers beyond 2 to this are not worked out: [-1, 1].
const MOST_TURNS: i64 = 1 << 14;
/// Exponentials of numbers beyond 2 to this are not worked out.
const MOST_EXPONENT: i64 = 30;

type Value = FBig<HalfEven, 2>;

thread_local! {
    /// The digits of pi and ln 2 worked out so far. Results do not depend on it.
    static CONSTANTS: RefCell<ConstCache> = const { RefCell::new(ConstCache::new()) };
}

/// What `f` gives with `bits` + [`GUARD`] bits, as a number with a bound.
fn evaluate(bits: usize, f: impl FnOnce(&Context<HalfEven>, Option<&mut ConstCache>) -> FpResult<Value>) -> Big {
    let bits = bits.clamp(2, MOST_BITS);
    let context = Context::<HalfEven>::new(bits + GUARD);
    let result = CONSTANTS.with(|cache| match cache.try_borrow_mut() {
        Ok(mut cache) => f(&context, Some(&mut cache)),
        Err(_) => f(&context, None),
    });
    result.map_or_else(|_| Big::not_finite(bits), |value| enclose(value, bits))
}

/// A correctly rounded value of `bits` + [`GUARD`] bits. Half a unit of its last place is
/// below |v| 2^(-bits - GUARD); 2^(GUARD/2) times that is charged.
fn enclose(value: Rounded<Value>, bits: usize) -> Big {
    let repr = value.value().into_repr();
    if repr.is_infinite() {
        return Big::not_finite(bits);
    }
    let (significand, exponent) = repr.into_parts();
    let value = Big::from_parts(significand, exponent as i64, bits + GUARD);
    let error = value.mid_upper().scale(-((bits + GUARD / 2) as i64));
    value.with_added_radius(error).with_bits(bits)
}

impl Big {
    /// The number pi.
    pub fn pi(bits: usize) -> Self {
        evaluate(bits, |context, cache| Ok(context.pi::<2>(cache)))
    }

    /// The midpoint for dashu-float; only where its exponent is known to be moderate.
    fn repr(&self) -> Repr<2> {
        let (significand, exponent) = self.mid();
        Repr::new(significand.clone(), exponent as isize)
    }

    fn point(&self, f: impl FnOnce(&Context<HalfEven>, &Repr<2>, Option<&mut ConstCache>) -> FpResult<Value>) -> Self {
        let x = self.repr();
        evaluate(self.bits(), |context, cache| f(context, &x, cache))
    }

    /// Whether the square of the midpoint does not reach the last place of 1 by far.
    fn is_tiny(&self) -> bool {
        self.mid_upper() < Magnitude::power_of_two(-(self.bits() as i64) - 32)
    }

    /// f(x) for an odd f with f(x) = x + d, |d| <= |x|^3 for |x| <= 1/2: that holds for sin, tan, asin,
    /// atan, sinh, tanh, by their series.
    fn odd(&self, f: impl FnOnce(&Context<HalfEven>, &Repr<2>, Option<&mut ConstCache>) -> FpResult<Value>) -> Self {
        let x = self.center();
        if x.is_tiny() {
            let cube = x.mid_upper().powi(3);
            return x.with_added_radius(cube);
        }
        x.point(f)
    }

    /// f(x) for f(x) = 1 + d with |d| <= x^2 for |x| <= 1/2: cos and cosh.
    fn even(&self, f: impl FnOnce(&Context<HalfEven>, &Repr<2>, Option<&mut ConstCache>) -> FpResult<Value>) -> Self {
        if self.is_tiny() {
            let square = self.mid_upper().powi(2);
            return Self::one(self.bits()).with_added_radius(square);
        }
        self.center().point(f)
    }

    /// A sine or cosine from that at the midpoint: |sin(m + h) - sin m| <= |h|, and they never leave [-1, 1], however wide
    /// the argument.
    fn wave(&self, at: impl FnOnce() -> Self) -> Self {
        let anywhere = || Self::zero(self.bits()).with_added_radius(Magnitude::ONE);
        if self.turns_too_often() {
            return anywhere();
        }
        let value = at().with_added_radius(self.radius());
        if value.is_finite() && value.radius() > Magnitude::ONE { anywhere() } else { value }
    }

    /// Whether the angle is too large to be reduced by multiples of pi.
    fn turns_too_often(&self) -> bool {
        self.mid_upper() > Magnitude::power_of_two(MOST_TURNS)
    }

    /// Sine; [-1, 1] for arguments beyond 2^16384.
    pub fn sin(&self) -> Self {
        self.wave(|| self.odd(|context, x, cache| context.sin::<2>(x, cache)))
    }

    /// Cosine; [-1, 1] for arguments beyond 2^16384.
    pub fn cos(&self) -> Self {
        self.wave(|| self.even(|context, x, cache| context.cos::<2>(x, cache)))
    }

    /// Tangent; not finite where the cosine may be 0.
    ///
    /// tan(m + h) - tan m = sin h / (cos m cos(m + h)), and |cos(m + h)| >= |cos m| - r.
    pub fn tan(&self) -> Self {
        if !self.is_finite() || self.turns_too_often() {
            return Self::not_finite(self.bits());
        }
        let value = self.odd(|context, x, cache| context.tan::<2>(x, cache));
        if self.is_exact() {
            return value;
        }
        let cos = self.center().cos().abs_lower();
        let least = cos.sub_down(self.radius());
        value.with_added_radius(self.radius().div(least).div(cos))
    }

    /// Arc tangent.
    pub fn atan(&self) -> Self {
        // |atan(m + h) - atan m| <= |h| / (1 + min x^2) over the ball.
        let slope = Magnitude::ONE.div(Magnitude::ONE.add_down(self.abs_lower_squared()));
        self.center().angle(&Self::one(self.bits()), self.bits()).with_added_radius(self.radius().mul(slope))
    }

    /// A lower bound of x^2, as a power of 2.
    fn abs_lower_squared(&self) -> Magnitude {
        let least = self.abs_lower();
        if least.is_zero() { least } else { Magnitude::power_of_two(2 * least.parts().1) }
    }

    /// The angle of the point (x, y), in (-pi, pi]: `y.atan2(x)`. Not finite if the point may be the
    /// origin; [-pi, pi] if it may lie on either side of the negative x axis.
    pub(crate) fn atan2(&self, x: &Self) -> Self {
        let y = self;
        let bits = x.bits().max(y.bits());
        if !(y.is_finite() && x.is_finite()) || (y.contains_zero() && x.contains_zero()) {
            return Self::not_finite(bits);
        }
        let anywhere = || Self::zero(bits).with_added_radius(Magnitude::from_f64(3.2));
        if y.contains_zero() && !y.is_zero() && x.is_negative() {
            return anywhere();
        }
        let (rx, ry) = (x.radius(), y.radius());
        let (size_x, size_y) = (x.mid_upper(), y.mid_upper());
        // A displacement (dx, dy) of length at most d < p at distance p turns the angle by D with
        // sin D = |x dy - y dx| / (p p') <= s = (|x| ry + |y| rx) / (p (p - d)), and
        // asin s <= s (1 + s^2) for s <= 1. As d < p/2, D is below a right angle.
        let distance = x.mid_lower().max(y.mid_lower());
        let shift = rx.add(ry);
        let mut error = Magnitude::ZERO;
        // On the axis a displacement along it turns nothing.
        let along = y.is_zero() && rx < x.mid_lower();
        if !(shift.is_zero() || along) {
            let s = size_x.mul(ry).add(size_y.mul(rx)).div(distance).div(distance.sub_down(shift));
            if shift.scale(1) >= distance || s >= Magnitude::ONE {
                return anywhere();
            }
            error = s.mul(Magnitude::ONE.add(s.powi(2)));
        }
        y.center().angle(&x.center(), bits).with_added_radius(error)
    }

    /// The angle of a point given exactly, not the origin.
    fn angle(&self, x: &Self, bits: usize) -> Self {
        let y = self;
        if y.is_zero() {
            return if x.is_positive() { Self::zero(bits) } else { Self::pi(bits) };
        }
        let signed = |value: Self| if y.is_negative() { -&value } else { value };
        if x.is_zero() {
            return signed(Self::pi(bits).scale(-1));
        }
        // Near an axis the ratio t is tiny: atan t = t + d with |d| <= |t|^3, and |t| itself is
        // nothing beside pi.
        let t = (y / x).with_bits(bits);
        let inverse = (x / y).with_bits(bits);
        if t.is_tiny() && x.is_positive() {
            let cube = t.abs_upper().powi(3);
            return t.with_added_radius(cube);
        }
        if t.is_tiny() {
            return &signed(Self::pi(bits)) + &t;
        }
        if inverse.is_tiny() {
            return &signed(Self::pi(bits).scale(-1)) - &inverse;
        }
        // Scaled so that the exponents are moderate; the angle stays.
        let (_, top) = x.mid_upper().parts();
        let (y, x) = (y.scale(-top).repr(), x.scale(-top).repr());
        evaluate(bits, |context, cache| context.atan2::<2>(&y, &x, cache))
    }

    /// Arc sine. A number across the end of [-1, 1] is cut off there; one outside is not finite.
    pub fn asin(&self) -> Self {
        self.arc(|x| x.odd(|context, x, cache| context.asin::<2>(x, cache)), |x, rest| x.atan2(rest))
    }

    /// Arc cosine. A number across the end of [-1, 1] is cut off there; one outside is not finite.
    pub fn acos(&self) -> Self {
        self.arc(
            |x| {
                if x.is_tiny() {
                    // acos x = pi/2 - x - d, |d| <= |x|^3
                    let cube = x.mid_upper().powi(3);
                    (&Self::pi(x.bits()).scale(-1) - x).with_added_radius(cube)
                } else {
                    x.point(|context, x, cache| context.acos::<2>(x, cache))
                }
            },
            |x, rest| rest.atan2(x),
        )
    }

    /// By the function at the midpoint and the slope 1/sqrt(1 - x^2) <= 1/sqrt(1 - |x|), or near the
    /// ends of [-1, 1] as the angle of (sqrt(1 - x^2), x).
    fn arc(&self, at: impl Fn(&Self) -> Self, angle: impl Fn(&Self, &Self) -> Self) -> Self {
        let one = Self::one(self.bits());
        let (below, above) = (&one - self, &one + self);
        if !self.is_finite() || below.is_negative() || above.is_negative() {
            return Self::not_finite(self.bits());
        }
        if self.is_exact() {
            return at(self);
        }
        let gap = below.abs_lower().min(above.abs_lower());
        if gap > self.radius().scale(2) {
            let slope = Magnitude::ONE.div(gap.sqrt_down());
            return at(&self.center()).with_added_radius(self.radius().mul(slope));
        }
        // The root of a number that may be 0 is [0, root of the upper end]: cut off.
        angle(self, &(&below * &above).sqrt())
    }

    /// Exponential function; not finite beyond 2^30.
    pub fn exp(&self) -> Self {
        // |exp(m + h) - exp(m)| <= exp(m) (exp(r) - 1), and exp(r) - 1 <= r exp(r).
        let growth = self.radius().mul(self.radius().exp());
        let value = if self.mid_upper() >= Magnitude::power_of_two(MOST_EXPONENT) {
            if self.mid().0.sign() == dashu_int::Sign::Positive {
                return Self::not_finite(self.bits());
            }
            // 0 < exp(x) < 2^x for negative x.
            Self::from_zero_to(Magnitude::power_of_two(-(1 << MOST_EXPONENT)), self.bits())
        } else if self.is_tiny() {
            // |exp(x) - 1 - x| <= x^2 for |x| <= 1
            let square = self.mid_upper().powi(2);
            (&Self::one(self.bits()) + &self.center()).with_added_radius(square)
        } else {
            self.center().point(|context, x, cache| context.exp::<2>(x, cache))
        };
        if self.is_exact() {
            return value;
        }
        let error = value.abs_upper().mul(growth);
        value.with_added_radius(error)
    }

    /// Natural logarithm; not finite unless the number is positive.
    pub fn ln(&self) -> Self {
        if !self.is_positive() {
            return Self::not_finite(self.bits());
        }
        let (_, top) = self.mid_upper().parts();
        let ln = |x: &Self| x.point(|context, x, cache| context.ln::<2>(x, cache));
        let value = if top.abs() <= 1 << 16 {
            let center = self.center();
            if (&center - &Self::one(self.bits())).is_zero() { Self::zero(self.bits()) } else { ln(&center) }
        } else {
            // x = m 2^top with m near 1: the second part outweighs the first by far.
            let bits = self.bits() + 64;
            let scaled = self.center().scale(-top).with_bits(bits);
            let two = ln(&Self::from_f64(2.0, bits));
            let whole = &two * &Self::from_parts(top.into(), 0, bits);
            (&ln(&scaled) + &whole).with_bits(self.bits())
        };
        // |ln(1 + h/m)| <= t/(1 - t) = r/(m - r) for t = r/m.
        value.with_added_radius(self.radius().div(self.abs_lower()))
    }

    /// Hyperbolic sine; not finite beyond 2^30.
    pub fn sinh(&self) -> Self {
        let value = match self.halves() {
            Some((grows, falls)) => {
                let size = (&grows - &falls).with_bits(self.bits());
                if self.mid().0.sign() == dashu_int::Sign::Negative { -&size } else { size }
            }
            None => self.odd(|context, x, cache| context.sinh::<2>(x, cache)),
        };
        self.with_slope_cosh(value)
    }

    /// Hyperbolic cosine; not finite beyond 2^30.
    pub fn cosh(&self) -> Self {
        let value = match self.halves() {
            Some((grows, falls)) => (&grows + &falls).with_bits(self.bits()),
            None => self.even(|context, x, cache| context.cosh::<2>(x, cache)),
        };
        self.with_slope_cosh(value)
    }

    /// exp(|m|)/2 and exp(-|m|)/2 with more bits, for midpoints of at least 1 in size.
    fn halves(&self) -> Option<(Self, Self)> {
        if self.mid_upper() < Magnitude::ONE {
            return None;
        }
        let bits = self.bits() + GUARD;
        let grows = self.center().with_bits(bits).abs().exp();
        let falls = (&Self::one(bits) / &grows).scale(-1);
        Some((grows.scale(-1), falls))
    }

    /// The derivatives of sinh and cosh are at most cosh(|m| + r) <= cosh(m) exp(r), and
    /// cosh(m) <= |sinh m| + 1.
    fn with_slope_cosh(&self, value: Self) -> Self {
        if self.is_exact() {
            return value;
        }
        let slope = value.abs_upper().add(Magnitude::ONE).mul(self.radius().exp());
        value.with_added_radius(self.radius().mul(slope))
    }

    /// Hyperbolic tangent.
    pub fn tanh(&self) -> Self {
        let value = if self.mid_upper() < Magnitude::ONE {
            self.odd(|context, x, cache| context.tanh::<2>(x, cache))
        } else {
            // (1 - q) / (1 + q) with q = exp(-2|x|)
            let bits = self.bits() + GUARD;
            let q = (-&self.center().abs().scale(1)).with_bits(bits).exp();
            let one = Self::one(bits);
            let size = (&(&one - &q) / &(&one + &q)).with_bits(self.bits());
            if self.mid().0.sign() == dashu_int::Sign::Negative { -&size } else { size }
        };
        // The slope is at most 1.
        value.with_added_radius(self.radius())
    }

    /// General power: integer and square root powers directly, any other of a positive base as
    /// exp(y ln x).
    pub(crate) fn pow(&self, exponent: &Self) -> Self {
        let bits = self.bits().max(exponent.bits());
        if exponent.is_exact() && exponent.mid_upper() <= Magnitude::from_f64(65_536.0) {
            let y = exponent.mid_f64();
            // Compared as numbers: the double may be rounded.
            if y.fract() == 0.0 && (exponent - &Self::from_f64(y, bits)).is_zero() {
                return self.powi(y as i32);
            }
            let twice = exponent.scale(1);
            let y = twice.mid_f64();
            if y.fract() == 0.0 && (&twice - &Self::from_f64(y, bits)).is_zero() {
                return self.sqrt().powi(y as i32);
            }
        }
        if self.is_zero() && exponent.is_positive() {
            return self.clone();
        }
        // The size of y ln x, below 2^31 where the result is finite, is lost from the digits.
        let wide = self.clone().with_bits(bits + 64);
        (&wide.ln() * exponent).exp().with_bits(bits)
    }
}

impl Scalar for Big {
    type Precision = usize;

    fn from_number(number: &Number, bits: usize) -> Self {
        Big::from_number(number, bits)
    }

    fn pi(bits: usize) -> Self {
        Big::pi(bits)
    }

    operators!();

    functions!();

    own_methods! { Big:
        powi(exponent: i32) -> Self;
        sqrt() -> Self;
        pow(exponent: &Self) -> Self;
        atan2(x: &Self) -> Self;
        is_finite() -> bool;
    }

    fn signum(&self) -> Self {
        if self.is_positive() {
            Big::one(self.bits)
        } else if self.is_negative() {
            -&Big::one(self.bits)
        } else {
            Big::not_finite(self.bits)
        }
    }

    fn convolution(left: &[Self], right: &[Self]) -> Option<Self> {
        super::arithmetic::convolution(left, right)
    }

    fn is_exact_zero(&self) -> bool {
        self.is_zero()
    }
}
