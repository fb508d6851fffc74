//! Rigorous enclosures: a double-double midpoint and an absolute error bound.
//!
//! A ball stands for some real number x with |x - mid| <= radius. Every operation returns a ball
//! that contains the result for all numbers in its operands: the propagated error, proved beside
//! each operation, plus the bound of its own rounding (see [`DoubleDouble`]), rounded outwards.
//! Results of exact operations on exact doubles have radius 0, so exact data stay exact.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::double::{DoubleDouble, power_of_two, scale, two_prod, two_sum};
use super::magnitude::Magnitude;
use super::scalar::power;

/// u^2 = 2^-106, the unit of the double-double bounds.
pub const U2: f64 = power_of_two(-106);
/// Magnitudes beyond 2^990 count as not finite: splitting a factor would overflow.
const LARGEST: f64 = power_of_two(990);
/// Products below 2^-960 may lose their error term to underflow ...
const SMALLEST: f64 = power_of_two(-960);
/// ... by at most this.
const UNDERFLOW: f64 = power_of_two(-1060);

/// An upper bound of a nonnegative expression of at most 16 sums and products that was evaluated
/// as x in doubles: each of them lost at most a factor 1 + 2^-53 and 2^-1074 to underflow, and
/// (1 + 2^-53)^16 < 1 + 2^-48.
#[inline(always)]
pub fn up(x: f64) -> f64 {
    x * (1.0 + power_of_two(-48)) + power_of_two(-1068)
}

/// A real number known to lie within `radius` of `mid`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// The centre.
    pub mid: DoubleDouble,
    /// The largest distance from the centre; 0 for an exact number.
    pub radius: f64,
}

impl Ball {
    /// Zero, exactly.
    pub const ZERO: Self = Self::exact(0.0);
    /// One, exactly.
    pub const ONE: Self = Self::exact(1.0);
    /// No number at all: what comes of leaving the domain or the range.
    pub const NOT_FINITE: Self = Self { mid: DoubleDouble { hi: f64::NAN, lo: 0.0 }, radius: f64::INFINITY };
    /// The number pi.
    pub const PI: Self =
        Self { mid: DoubleDouble { hi: std::f64::consts::PI, lo: 1.224_646_799_147_353_2e-16 }, radius: 2.995e-33 };

    /// A double, exactly.
    #[inline]
    pub const fn exact(value: f64) -> Self {
        Self { mid: DoubleDouble::exact(value), radius: 0.0 }
    }

    /// The ball around `mid`; not finite if the numbers are out of range or not numbers.
    #[inline(always)]
    pub fn new(mid: DoubleDouble, radius: f64) -> Self {
        // Comparisons with NaN are false.
        if mid.hi.abs() <= LARGEST && mid.lo.abs() <= LARGEST && radius <= LARGEST {
            Self { mid, radius }
        } else {
            Self::NOT_FINITE
        }
    }

    /// Whether the ball is a number at all.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.mid.is_finite() && self.radius < f64::INFINITY
    }

    /// Whether the number is known exactly.
    #[inline]
    pub fn is_exact(&self) -> bool {
        self.radius == 0.0
    }

    /// Whether the number is zero, exactly.
    #[inline]
    pub fn is_zero(&self) -> bool {
        self.radius == 0.0 && self.mid.hi == 0.0
    }

    /// Whether the number may be zero; true as well if the ball is not finite.
    #[inline]
    pub fn contains_zero(&self) -> bool {
        !(self.is_positive() || self.is_negative())
    }

    /// Whether the number is certainly positive.
    #[inline]
    pub fn is_positive(&self) -> bool {
        // By value: hi + lo > radius in double-double order.
        self.is_finite() && self.mid > DoubleDouble::exact(self.radius)
    }

    /// Whether the number is certainly negative.
    #[inline]
    pub fn is_negative(&self) -> bool {
        self.is_finite() && -self.mid > DoubleDouble::exact(self.radius)
    }

    /// A double not above any number in the ball; -infinity if the ball is not finite.
    pub fn lower(&self) -> f64 {
        -self.neg().upper()
    }

    /// A double not below any number in the ball; +infinity if the ball is not finite.
    ///
    /// With s + e = hi + r exactly, the value is s + (e + lo). Rounding e + lo loses at most
    /// u |e + lo|, the last sum at most half a unit of its result: two steps up cover both.
    pub fn upper(&self) -> f64 {
        if !self.is_finite() {
            return f64::INFINITY;
        }
        let (s, e) = two_sum(self.mid.hi, self.radius);
        let rest = e + self.mid.lo;
        if rest == 0.0 {
            return s;
        }
        let slack = rest.abs() * f64::EPSILON;
        (s + (rest + slack)).next_up().next_up()
    }

    /// An upper bound of the absolute value; +infinity if the ball is not finite.
    pub fn abs_upper(&self) -> f64 {
        self.upper().max(self.neg().upper())
    }

    /// A lower bound of the absolute value, 0 if the ball contains 0 or is not finite.
    pub fn abs_lower(&self) -> f64 {
        if self.is_finite() { self.lower().max(self.neg().lower()).max(0.0) } else { 0.0 }
    }

    /// The double nearest to the centre.
    #[inline]
    pub fn mid_f64(&self) -> f64 {
        self.mid.hi
    }

    /// An upper bound of the distance between [`Ball::mid_f64`] and the number.
    pub fn mid_f64_error(&self) -> f64 {
        if !self.is_finite() {
            f64::INFINITY
        } else if self.mid.lo == 0.0 {
            self.radius
        } else {
            up(self.mid.lo.abs() + self.radius)
        }
    }

    /// The same ball with a radius larger by `error` (not negative; anything else: not finite).
    #[inline]
    pub fn with_added_radius(&self, error: f64) -> Self {
        if error == 0.0 {
            *self
        } else if self.radius == 0.0 && error > 0.0 {
            Self::new(self.mid, error)
        } else if error > 0.0 {
            Self::new(self.mid, up(self.radius + error))
        } else {
            Self::NOT_FINITE
        }
    }

    /// A ball that contains both.
    ///
    /// The smallest interval holding [a - ra, a + ra] and [b - rb, b + rb], neither inside the
    /// other, with d = b - a > 0, is centred at (a + b + rb - ra) / 2 with radius
    /// (d + ra + rb) / 2.
    pub fn hull(&self, other: &Self) -> Self {
        if !(self.is_finite() && other.is_finite()) {
            return Self::NOT_FINITE;
        }
        let distance = *other - *self;
        let (reach, gap) = (distance.mid.hi.abs(), distance.mid.hi);
        // Upper bound of |b - a|; the rounding of the difference is in 4 u^2.
        let d = up(reach * (1.0 + f64::EPSILON));
        if up(d + other.radius) <= self.radius {
            return *self;
        }
        if up(d + self.radius) <= other.radius {
            return *other;
        }
        let shift = (other.radius - self.radius) * if gap < 0.0 { -0.5 } else { 0.5 };
        let mid = (self.mid + other.mid).scale(-1) + DoubleDouble::exact(shift);
        let rounding = f64::EPSILON * shift.abs() + 16.0 * U2 * (self.mid.hi.abs() + reach);
        Self::new(mid, up(0.5 * (d + self.radius + other.radius) + rounding))
    }

    /// x 2^exponent.
    pub fn scale(&self, exponent: i32) -> Self {
        let mid = self.mid.scale(exponent);
        if mid.hi.abs() < SMALLEST && self.mid.hi != 0.0 {
            return Self::new(mid, up(scale(self.radius, exponent) + UNDERFLOW));
        }
        let radius = scale(self.radius, exponent);
        Self::new(mid, if radius < SMALLEST && self.radius != 0.0 { up(radius) } else { radius })
    }

    /// x 2^exponent, beyond the range of balls as well: a double and its radius there, which nothing more can be calculated
    /// with, and no number where there is no such double.
    pub fn scale_far(&self, exponent: i64) -> Self {
        let by = exponent.clamp(-3000, 3000) as i32;
        let (within, mid) = (self.scale(by), self.mid.scale(by));
        let radius = Magnitude::from_f64(self.radius).scale(exponent).to_f64();
        if !within.is_finite() && mid.is_finite() && radius < f64::INFINITY { Self { mid, radius } } else { within }
    }

    /// Absolute value. Where the ball contains 0, it is [0, m] for the larger end m.
    pub fn abs(&self) -> Self {
        if !self.is_finite() || self.mid.hi == 0.0 && self.radius == 0.0 || self.is_positive() {
            *self
        } else if self.is_negative() {
            self.neg()
        } else {
            Self::from_zero_to(self.abs_upper())
        }
    }

    /// The ball [0, end].
    pub(crate) fn from_zero_to(end: f64) -> Self {
        let half = (0.5 * end).next_up();
        Self::new(DoubleDouble::exact(half), half)
    }

    /// Square root. A ball that contains 0 gives [0, sqrt(upper)]; one below 0 is not finite.
    ///
    /// |sqrt(m + h) - sqrt(m)| = |h| / (sqrt(m + h) + sqrt(m)) for |h| <= r, largest at h = -r.
    pub fn sqrt(&self) -> Self {
        if !self.is_finite() || self.is_negative() {
            return Self::NOT_FINITE;
        }
        if self.is_zero() {
            return *self;
        }
        if !self.is_positive() {
            return Self::from_zero_to(self.upper().sqrt().next_up());
        }
        let root = self.mid.sqrt();
        let propagated = if self.radius == 0.0 {
            if root.lo == 0.0 && self.mid.hi > SMALLEST {
                let (p, e) = two_prod(root.hi, root.hi);
                if p == self.mid.hi && e == self.mid.lo {
                    return Self::new(root, 0.0);
                }
            }
            0.0
        } else {
            self.radius / (root.hi + self.lower().max(0.0).sqrt()) * (1.0 + f64::EPSILON)
        };
        Self::new(root, up(propagated + 4.0 * U2 * root.hi))
    }

    /// Integer power by repeated squaring, negative exponents included.
    pub fn powi(&self, exponent: i32) -> Self {
        let power = power(self, exponent.unsigned_abs(), |x, y| *x * *y).unwrap_or(Self::ONE);
        if exponent < 0 { Self::ONE / power } else { power }
    }

    /// Double-doubles not above and not below any number in the ball.
    pub(crate) fn ends(&self) -> (DoubleDouble, DoubleDouble) {
        let r = DoubleDouble::exact(self.radius);
        let slack = |x: DoubleDouble| DoubleDouble::exact(8.0 * U2 * x.hi.abs());
        let (low, high) = (self.mid - r, self.mid + r);
        if self.radius == 0.0 { (self.mid, self.mid) } else { (low - slack(low), high + slack(high)) }
    }
}

impl From<DoubleDouble> for Ball {
    fn from(value: DoubleDouble) -> Self {
        Self::new(value, 0.0)
    }
}

impl From<f64> for Ball {
    fn from(value: f64) -> Self {
        Self::new(DoubleDouble::exact(value), 0.0)
    }
}

impl Neg for Ball {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { mid: -self.mid, radius: self.radius }
    }
}

impl Add for Ball {
    type Output = Self;

    /// |(x + y) - (a + b)| <= ra + rb; the sum of two doubles is exact.
    #[inline]
    fn add(self, other: Self) -> Self {
        let (mid, rounding) = if self.mid.lo == 0.0 && other.mid.lo == 0.0 {
            (DoubleDouble::new(self.mid.hi, other.mid.hi), 0.0)
        } else if other.mid.hi == 0.0 {
            (self.mid, 0.0)
        } else if self.mid.hi == 0.0 {
            (other.mid, 0.0)
        } else {
            let mid = self.mid + other.mid;
            (mid, 4.0 * U2 * mid.hi.abs())
        };
        let radius = self.radius + other.radius + rounding;
        Self::new(mid, if radius == 0.0 { 0.0 } else { up(radius) })
    }
}

impl Sub for Ball {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + (-other)
    }
}

impl Mul for Ball {
    type Output = Self;

    /// x y - a b = a (y - b) + b (x - a) + (x - a)(y - b), so the error is at most
    /// |a| rb + |b| ra + ra rb; the product of two doubles is exact.
    #[inline]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.mid, other.mid);
        if self.is_zero() && other.is_finite() || other.is_zero() && self.is_finite() {
            return Self::ZERO;
        }
        let (mid, mut rounding) = if a.lo == 0.0 && b.lo == 0.0 {
            let (hi, lo) = two_prod(a.hi, b.hi);
            (DoubleDouble { hi, lo }, 0.0)
        } else {
            let mid = a * b;
            (mid, 6.0 * U2 * mid.hi.abs())
        };
        if mid.hi.abs() < SMALLEST && a.hi != 0.0 && b.hi != 0.0 {
            rounding += UNDERFLOW;
        }
        let (ra, rb) = (self.radius, other.radius);
        if ra == 0.0 && rb == 0.0 {
            return Self::new(mid, if rounding == 0.0 { 0.0 } else { up(rounding) });
        }
        Self::new(mid, up(a.hi.abs() * rb + b.hi.abs() * ra + ra * rb + rounding))
    }
}

impl Div for Ball {
    type Output = Self;

    /// With q = a / b: x / y - q = ((x - a) - q (y - b)) / y, so the error is at most
    /// (ra + |q| rb) / (|b| - rb). Not finite if the divisor may be 0.
    #[inline]
    fn div(self, other: Self) -> Self {
        let least = other.abs_lower();
        // A double that small would not be told from 0 by its reciprocal.
        if least < power_of_two(-990) || !self.is_finite() {
            return Self::NOT_FINITE;
        }
        if self.is_zero() {
            return Self::ZERO;
        }
        let mid = self.mid / other.mid;
        let q = mid.hi.abs();
        if self.radius == 0.0 && other.radius == 0.0 {
            // Quotients that come out even are exact: 6 / 3, x / 2, x / 1.
            if mid.lo == 0.0 && self.mid.lo == 0.0 && other.mid.lo == 0.0 && q > SMALLEST {
                let (p, e) = two_prod(mid.hi, other.mid.hi);
                if p == self.mid.hi && e == 0.0 && p.abs() > SMALLEST {
                    return Self::new(mid, 0.0);
                }
            }
        }
        let rounding = 16.0 * U2 * q + if q < SMALLEST { UNDERFLOW } else { 0.0 };
        Self::new(mid, up((self.radius + q * other.radius) / least + rounding))
    }
}
