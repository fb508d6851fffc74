//! Elementary functions of balls.
//!
//! Each function is evaluated at the midpoint, in ball arithmetic from the reduction of the
//! argument to the last term of the series, with a proved bound of the remainder; so the rounding
//! errors look after themselves. The radius of the argument then enters through a bound of the
//! derivative over the ball. Reduction and Newton steps as in Hida, Li, Bailey (2007); expansions
//! as in Shewchuk, Discrete Comput. Geom. 18 (1997).

use super::ball::{Ball, U2, up};
use super::double::{DoubleDouble, exponent_of, power_of_two, two_prod, two_sum};

/// pi/2 in four doubles; what is left is below 3e-66.
const HALF_PI: [f64; 4] =
    [std::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17, -1.497_384_904_859_169_8e-33, 5.562_271_104_316_826e-50];
const HALF_PI_REST: f64 = 3e-66;
/// ln 2 in three doubles; what is left is below 4e-50.
const LN_2: [f64; 3] = [std::f64::consts::LN_2, 2.319_046_813_846_299_6e-17, 5.707_708_438_416_212e-34];
const LN_2_REST: f64 = 4e-50;

/// 1/n! as double-doubles with relative error below 2^-106.
const INVERSE_FACTORIALS: [(f64, f64); 31] = [
    (1.0, 0.0),
    (1.0, 0.0),
    (0.5, 0.0),
    (0.16666666666666666, 9.25185853854297e-18),
    (0.041666666666666664, 2.3129646346357427e-18),
    (0.008333333333333333, 1.1564823173178714e-19),
    (0.001388888888888889, -5.300543954373577e-20),
    (0.0001984126984126984, 1.7209558293420705e-22),
    (2.48015873015873e-05, 2.1511947866775882e-23),
    (2.7557319223985893e-06, -1.858393274046472e-22),
    (2.755731922398589e-07, 2.3767714622250297e-23),
    (2.505210838544172e-08, -1.448814070935912e-24),
    (2.08767569878681e-09, -1.20734505911326e-25),
    (1.6059043836821613e-10, 1.2585294588752098e-26),
    (1.1470745597729725e-11, 2.0655512752830745e-28),
    (7.647163731819816e-13, 7.03872877733453e-30),
    (4.779477332387385e-14, 4.399205485834081e-31),
    (2.8114572543455206e-15, 1.6508842730861433e-31),
    (1.5619206968586225e-16, 1.1910679660273754e-32),
    (8.22063524662433e-18, 2.2141894119604265e-34),
    (4.110317623312165e-19, 1.4412973378659527e-36),
    (1.9572941063391263e-20, -1.3643503830087908e-36),
    (8.896791392450574e-22, -7.911402614872376e-38),
    (3.868170170630684e-23, -8.843177655482344e-40),
    (1.6117375710961184e-24, -3.6846573564509766e-41),
    (6.446950284384474e-26, -1.9330404233703465e-42),
    (2.4795962632247976e-27, -1.2953730964765229e-43),
    (9.183689863795546e-29, 1.4303150396787322e-45),
    (3.279889237069838e-30, 1.5117542744029879e-46),
    (1.1309962886447716e-31, 1.0498015412959506e-47),
    (3.7699876288159054e-33, 2.5870347832750324e-49),
];

fn inverse_factorial(n: usize) -> Ball {
    let (hi, lo) = INVERSE_FACTORIALS[n];
    let radius = if n < 3 { 0.0 } else { U2 * hi };
    Ball { mid: DoubleDouble { hi, lo }, radius }
}

/// The sum of z^k / (first + k step)! over k while the index is at most `last`.
fn series(z: Ball, first: usize, step: usize, last: usize) -> Ball {
    let mut n = last;
    let mut sum = inverse_factorial(n);
    while n > first {
        n -= step;
        sum = sum * z + inverse_factorial(n);
    }
    sum
}

/// 1.1 x^n / n!, a bound of what the series for |x| <= 0.8 leave out from x^n / n! on: the terms
/// fall by more than 0.8^2 / 29^2 (every second one) or 0.35 / 24 (every one). `up` covers
/// underflow.
fn remainder(x: f64, n: usize) -> f64 {
    up(1.1 * x.abs().powi(n as i32) * INVERSE_FACTORIALS[n].0)
}

/// x - k (w1 + w2 + ...) as a ball, where the words leave `rest` out: all products and sums are
/// exact until the expansion is rounded, so nothing is lost to cancellation.
fn reduce(x: DoubleDouble, k: f64, words: &[f64], rest: f64) -> Ball {
    let mut expansion = [0.0; 10];
    let mut length = 0;
    let mut grow = |term: f64| {
        // Shewchuk's grow-expansion: the sum stays exact, components by rising magnitude.
        let mut carry = term;
        for slot in expansion.iter_mut().take(length) {
            let (s, e) = two_sum(carry, *slot);
            *slot = e;
            carry = s;
        }
        if length < 10 {
            expansion[length] = carry;
            length += 1;
        }
    };
    grow(x.lo);
    grow(x.hi);
    for &word in words {
        let (p, e) = two_prod(k, word);
        grow(-e);
        grow(-p);
    }
    let parts = expansion.iter().rev().filter(|part| **part != 0.0);
    let sum = parts.fold(Ball::ZERO, |sum, part| sum + Ball::exact(*part));
    sum.with_added_radius(up(k.abs() * rest))
}

/// Sine and cosine of a number of at most 0.8 in magnitude.
fn sin_cos_reduced(r: Ball) -> (Ball, Ball) {
    if r.is_zero() {
        return (Ball::ZERO, Ball::ONE);
    }
    // Alternating series with falling terms: the remainder is below the first term left out.
    odd_and_even(r, -(r * r), r.abs_upper())
}

/// r + z r/3! + z² r/5! + … and 1 + z/2! + z²/4! + … for z = ± r², |r| at most `size`.
fn odd_and_even(r: Ball, z: Ball, size: f64) -> (Ball, Ball) {
    let odd = r + r * (z * series(z, 3, 2, 27));
    let even = Ball::ONE + z * series(z, 2, 2, 28);
    (odd.with_added_radius(remainder(size, 29)), even.with_added_radius(remainder(size, 30)))
}

/// Sine and cosine of an exact number; [-1, 1] beyond 2^50, where the quadrant is not resolved.
fn sin_cos_point(x: DoubleDouble) -> (Ball, Ball) {
    if !x.is_finite() {
        return (Ball::NOT_FINITE, Ball::NOT_FINITE);
    }
    if x.hi.abs() > power_of_two(50) {
        let unknown = Ball { mid: DoubleDouble::ZERO, radius: 1.0 };
        return (unknown, unknown);
    }
    if x.hi.abs() <= 0.79 {
        return sin_cos_reduced(Ball::from(x));
    }
    let k = (x.hi * std::f64::consts::FRAC_2_PI).round();
    let (sin, cos) = sin_cos_reduced(reduce(x, k, &HALF_PI, HALF_PI_REST));
    match (k as i64).rem_euclid(4) {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Exponential of an exact number of at most 700 in magnitude.
fn exp_point(x: DoubleDouble) -> Ball {
    if x.hi == 0.0 {
        return Ball::ONE;
    }
    let k = (x.hi * std::f64::consts::LOG2_E).round();
    let r = if k == 0.0 { Ball::from(x) } else { reduce(x, k, &LN_2, LN_2_REST) };
    let sum = Ball::ONE + (r + r * r * series(r, 2, 1, 23));
    sum.with_added_radius(remainder(r.abs_upper(), 24)).scale(k as i32)
}

/// Hyperbolic sine and cosine of an exact number below 0.5 in magnitude.
fn sinh_cosh_small(x: DoubleDouble) -> (Ball, Ball) {
    let r = Ball::from(x);
    odd_and_even(r, r * r, x.hi)
}

/// ln((1 + z) / (1 - z)) = 2 (z + z^3/3 + z^5/5 + ...) for |z| < 0.06, by terms up to z^27; the
/// rest is below 2 z^29 / 29 / (1 - z^2).
fn ln_by_atanh(z: Ball) -> Ball {
    let square = z * z;
    let term = |k: i32| Ball::ONE / Ball::exact(f64::from(2 * k + 1));
    let sum = (0..13).rev().fold(term(13), |sum, k| sum * square + term(k));
    (z * sum).scale(1).with_added_radius(up(0.07 * z.abs_upper().powi(29)))
}

/// Logarithm of an exact positive number.
fn ln_point(x: DoubleDouble) -> Ball {
    if x == DoubleDouble::ONE {
        return Ball::ZERO;
    }
    let near_one = |f: DoubleDouble| (f.hi - 1.0).abs() < 0.1;
    let by_atanh = |f: DoubleDouble| {
        let f = Ball::from(f);
        ln_by_atanh((f - Ball::ONE) / (f + Ball::ONE))
    };
    if near_one(x) {
        return by_atanh(x);
    }
    // x = 2^k f with f in [0.7, 1.42): no cancellation between k ln 2 and ln f.
    let (x, shift) = if x.hi < 1e-290 { (x.scale(300), 300) } else { (x, 0) };
    let mut k = exponent_of(x.hi);
    if x.scale(-k).hi > std::f64::consts::SQRT_2 {
        k += 1;
    }
    let f = x.scale(-k);
    let whole = -reduce(DoubleDouble::ZERO, f64::from(k - shift), &LN_2, LN_2_REST);
    if near_one(f) {
        return whole + by_atanh(f);
    }
    // ln f = y + ln(1 + d) with d = f exp(-y) - 1 for any y; for y = ln f in doubles d is some
    // 1e-16, and |ln(1 + d) - (d - d^2/2 + d^3/3)| <= |d|^4 / (4 (1 - |d|)).
    let y = f.hi.ln();
    let d = Ball::from(f) * exp_point(DoubleDouble::exact(-y)) - Ball::ONE;
    let size = d.abs_upper();
    if size.is_nan() || size >= 0.5 {
        return Ball::NOT_FINITE;
    }
    let ln = d * (Ball::ONE - d * (Ball::exact(0.5) - d / Ball::exact(3.0)));
    whole + (Ball::exact(y) + ln.with_added_radius(up(0.5 * size.powi(4))))
}

/// The angle of the point (x, y) given exactly, not the origin.
fn angle_point(y: DoubleDouble, x: DoubleDouble) -> Ball {
    if y.hi == 0.0 {
        return if x.hi > 0.0 { Ball::ZERO } else { Ball::PI };
    }
    // Scaled so that the larger coordinate is about 1; the angle stays.
    let top = exponent_of(x.hi.abs().max(y.hi.abs()));
    let (y, x) = (Ball::from(y).scale(-top), Ball::from(x).scale(-top));
    // With s = sin a, c = cos a for any a: angle - a = atan((y c - x s) / (x c + y s)); for a in
    // doubles that is some 1e-16, and |atan d - (d - d^3/3)| <= |d|^5 / 5.
    let a = y.mid.hi.atan2(x.mid.hi);
    let (s, c) = sin_cos_point(DoubleDouble::exact(a));
    let across = x * c + y * s;
    let d = (y * c - x * s) / across;
    let size = d.abs_upper();
    if !(across.is_positive() && size < 0.5) {
        return Ball::NOT_FINITE;
    }
    let atan = d - d * d * d / Ball::exact(3.0);
    Ball::exact(a) + atan.with_added_radius(up(0.3 * size.powi(5)))
}

/// The elementary functions.
impl Ball {
    /// Sine; [-1, 1] for arguments beyond 2^50.
    pub fn sin(&self) -> Self {
        // |sin(m + h) - sin m| <= |h|
        sin_cos_point(self.mid).0.with_added_radius(self.radius).within_unit(self)
    }

    /// Cosine; [-1, 1] for arguments beyond 2^50.
    pub fn cos(&self) -> Self {
        sin_cos_point(self.mid).1.with_added_radius(self.radius).within_unit(self)
    }

    /// A sine or cosine is never outside [-1, 1], however wide its argument.
    fn within_unit(self, argument: &Self) -> Self {
        if argument.is_finite() && self.radius > 1.0 { Self { mid: DoubleDouble::ZERO, radius: 1.0 } } else { self }
    }

    /// Tangent; not finite where the cosine may be 0.
    pub fn tan(&self) -> Self {
        if self.is_zero() {
            return *self;
        }
        let (sin, cos) = sin_cos_point(self.mid);
        sin.with_added_radius(self.radius) / cos.with_added_radius(self.radius)
    }

    /// Arc tangent.
    pub fn atan(&self) -> Self {
        if !self.is_finite() {
            return Self::NOT_FINITE;
        }
        // |atan(m + h) - atan m| <= |h| / (1 + min x^2) over the ball.
        let least = self.abs_lower();
        let value = angle_point(self.mid, DoubleDouble::ONE);
        value.with_added_radius(if self.radius == 0.0 { 0.0 } else { up(self.radius / (1.0 + least * least)) })
    }

    /// The angle of the point (x, y), in (-pi, pi]: `y.atan2(x)`. Not finite if the point may be
    /// the origin; [-pi, pi] if it may lie on either side of the negative x axis.
    pub fn atan2(&self, x: &Self) -> Self {
        let y = self;
        if !(y.is_finite() && x.is_finite()) || (y.contains_zero() && x.contains_zero()) {
            return Self::NOT_FINITE;
        }
        if y.contains_zero() && !y.is_zero() && x.is_negative() {
            return Self { mid: DoubleDouble::ZERO, radius: 3.2 };
        }
        let value = angle_point(y.mid, x.mid);
        if y.radius == 0.0 && (x.radius == 0.0 || y.is_zero()) {
            return value;
        }
        // A displacement (dx, dy) of length at most d < p/2 at distance p turns the angle by D with
        // sin D = |x dy - y dx| / (p p') <= s = (|x| ry + |y| rx) / (p (p - d)), and
        // asin s <= s (1 + s^2) for s <= 1.
        let shift = x.radius.hypot(y.radius);
        let distance = x.mid.hi.hypot(y.mid.hi) * (1.0 - power_of_two(-48));
        let t = shift / distance * (1.0 + power_of_two(-48));
        if t < 0.5 {
            let rest = distance * (1.0 - t);
            let s = x.mid.hi.abs() / distance * (y.radius / rest) + y.mid.hi.abs() / distance * (x.radius / rest);
            return value.with_added_radius(up(s * (1.0 + s * s)));
        }
        // The box misses the origin and the cut, so the angle spans less than a turn.
        Self { mid: DoubleDouble::ZERO, radius: 3.2 }
    }

    /// Arc sine. A ball across the end of [-1, 1] is cut off there; one outside is not finite.
    pub fn asin(&self) -> Self {
        self.arc(|x, rest| x.atan2(&rest))
    }

    /// Arc cosine. A ball across the end of [-1, 1] is cut off there; one outside is not finite.
    pub fn acos(&self) -> Self {
        self.arc(|x, rest| rest.atan2(&x))
    }

    /// The angle from the point (x, sqrt(1 - x^2)).
    fn arc(&self, angle: impl Fn(Ball, Ball) -> Ball) -> Self {
        let point = |x: Ball| angle(x, ((Ball::ONE - x) * (Ball::ONE + x)).sqrt());
        let largest = self.abs_upper();
        if self.radius > 0.0 && largest < 1.0 - 1e-6 {
            // The derivative is 1/sqrt(1 - x^2); 1 - largest^2 > 1e-6 has its rounding error in
            // the factor.
            let slope = 1.0 / ((1.0 - largest) * (1.0 + largest)).sqrt() * (1.0 + 1e-9);
            return point(Ball::from(self.mid)).with_added_radius(up(self.radius * slope));
        }
        if !self.is_finite() || self.lower() > 1.0 || self.upper() < -1.0 {
            return Self::NOT_FINITE;
        }
        let one = DoubleDouble::ONE;
        let clip = |x: DoubleDouble| {
            if x > one {
                one
            } else if x < -one {
                -one
            } else {
                x
            }
        };
        if self.radius == 0.0 {
            return if self.mid.abs() > one { Self::NOT_FINITE } else { point(*self) };
        }
        // The function rises or falls all along.
        let (low, high) = self.ends();
        point(clip(low).into()).hull(&point(clip(high).into()))
    }

    /// Exponential function.
    pub fn exp(&self) -> Self {
        if !self.is_finite() || self.mid.hi > 680.0 {
            return Self::NOT_FINITE;
        }
        if self.mid.hi < -680.0 {
            let upper = self.upper();
            return if upper < -750.0 {
                // 0 < exp(x) < exp(-750) < 2^-1074
                Self::new(DoubleDouble::ZERO, f64::from_bits(1))
            } else if self.radius >= 1.0 {
                Self::from_zero_to(Self::exact(upper).exp().abs_upper())
            } else {
                let root = self.scale(-1).exp();
                root * root
            };
        }
        let value = exp_point(self.mid);
        if self.radius == 0.0 {
            return value;
        }
        // |exp(m + h) - exp(m)| <= exp(m) (exp(r) - 1), and exp(r) - 1 <= r exp(r).
        let growth = self.radius * self.radius.exp() * (1.0 + 1e-9);
        value.with_added_radius(up(value.abs_upper() * growth))
    }

    /// Natural logarithm; not finite unless the ball is positive.
    pub fn ln(&self) -> Self {
        if !self.is_positive() {
            return Self::NOT_FINITE;
        }
        let value = ln_point(self.mid);
        if self.radius == 0.0 {
            return value;
        }
        // |ln(1 + h/m)| <= t/(1 - t) = r/(m - r) for t = r/m.
        value.with_added_radius(up(self.radius / self.lower()))
    }

    /// Hyperbolic sine.
    pub fn sinh(&self) -> Self {
        if self.is_zero() {
            return *self;
        }
        let value = if self.mid.hi.abs() < 0.5 {
            sinh_cosh_small(self.mid).0
        } else {
            let e = Ball::from(self.mid.abs()).exp();
            let half = (e - Ball::ONE / e).scale(-1);
            if self.mid.hi < 0.0 { -half } else { half }
        };
        self.with_slope_cosh(value)
    }

    /// Hyperbolic cosine.
    pub fn cosh(&self) -> Self {
        let value = if self.mid.hi.abs() < 0.5 {
            sinh_cosh_small(self.mid).1
        } else {
            let e = Ball::from(self.mid.abs()).exp();
            (e + Ball::ONE / e).scale(-1)
        };
        self.with_slope_cosh(value)
    }

    /// The derivatives of sinh and cosh are at most cosh(|m| + r) <= exp(|m|) exp(r).
    fn with_slope_cosh(&self, value: Self) -> Self {
        if self.radius == 0.0 {
            return value;
        }
        let slope = (self.mid.hi.abs() * (1.0 + power_of_two(-50))).exp() * self.radius.exp();
        value.with_added_radius(up(self.radius * slope * (1.0 + 1e-9)))
    }

    /// Hyperbolic tangent.
    pub fn tanh(&self) -> Self {
        if self.is_zero() || !self.is_finite() {
            return *self;
        }
        let value = if self.mid.hi.abs() < 0.5 {
            let (sinh, cosh) = sinh_cosh_small(self.mid);
            sinh / cosh
        } else {
            // (1 - q) / (1 + q) with q = exp(-2|x|)
            let q = Ball::from(-self.mid.abs()).scale(1).exp();
            let size = (Ball::ONE - q) / (Ball::ONE + q);
            if self.mid.hi < 0.0 { -size } else { size }
        };
        value.with_added_radius(self.radius)
    }

    /// General power: integer and square root powers directly, any other of a positive base as
    /// exp(y ln x).
    pub fn pow(&self, exponent: &Self) -> Self {
        let y = exponent.mid.hi;
        if exponent.is_exact() && exponent.mid.lo == 0.0 {
            if y.fract() == 0.0 && y.abs() <= 65_536.0 {
                return self.powi(y as i32);
            }
            if (2.0 * y).fract() == 0.0 && y.abs() <= 32_768.0 {
                return self.sqrt().powi((2.0 * y) as i32);
            }
        }
        if self.is_zero() && exponent.is_positive() {
            return *self;
        }
        (*exponent * self.ln()).exp()
    }
}
