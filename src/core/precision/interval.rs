//! Intervals by their ends, which may be infinite: what excludes.
//!
//! A [`Ball`] has no value where a divisor may be 0, and loses that squares are not negative. Here a function stands for its
//! values where it has any: 1/[0, 2] is [1/2, ∞], sqrt([-1, 4]) is [0, 2], and what has a value nowhere is empty.
//! `whole` tells that everything on the way was defined and continuous on all of the operands. Filters of whole boxes of values
//! (`model::sieve`) and the search for equilibria exclude with them.

use super::{Ball, Function, Scalar, power, two_prod, two_sum};
use crate::number::Number;

/// A closed interval; empty where `lo` is not a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The lower end.
    pub lo: f64,
    /// The upper end.
    pub hi: f64,
    /// Whether everything on the way was defined and continuous.
    pub whole: bool,
}

/// Products below this may be rounded though a factor is a power of two.
const SMALLEST: f64 = 1e-280;
/// Beside an angle: it decides only whether an extremum counts, which more often does no harm.
const ANGLE: f64 = 1e-12;
/// Angles beyond this are anywhere.
const LARGE_ANGLE: f64 = 1e6;

fn sum_down(a: f64, b: f64) -> f64 {
    let (s, e) = two_sum(a, b);
    if e == 0.0 { s } else { s.next_down() }
}

fn sum_up(a: f64, b: f64) -> f64 {
    let (s, e) = two_sum(a, b);
    if e == 0.0 { s } else { s.next_up() }
}

/// Whether products with it are exact: its size is a power of two.
fn is_power_of_two(x: f64) -> bool {
    x.to_bits() << 12 == 0
}

/// a b rounded down and up; 0 times infinity is 0.
fn products(a: f64, b: f64) -> (f64, f64) {
    if a == 0.0 || b == 0.0 {
        return (0.0, 0.0);
    }
    let p = a * b;
    let exact = (is_power_of_two(a) || is_power_of_two(b)) && p.abs() > SMALLEST && p.is_finite();
    if exact || p.is_infinite() && (a.is_infinite() || b.is_infinite()) {
        return (p, p);
    }
    (p.next_down(), p.next_up())
}

/// a/b for b != 0, rounded down and up; a finite number by infinity is 0, infinity by infinity anything from 0 on.
fn quotients(a: f64, b: f64) -> (f64, f64) {
    if a == 0.0 {
        return (0.0, 0.0);
    }
    let q = a / b;
    if b.is_infinite() {
        let (sign, end) = (a.signum() * b.signum(), if a.is_infinite() { f64::INFINITY } else { 0.0 });
        return if sign > 0.0 { (0.0, end) } else { (-end, 0.0) };
    }
    if q.is_infinite() && a.is_infinite() || is_power_of_two(b) && q.abs() > SMALLEST && q.is_finite() {
        return (q, q);
    }
    (q.next_down(), q.next_up())
}

impl Interval {
    /// No number.
    pub const EMPTY: Self = Self { lo: f64::NAN, hi: f64::NAN, whole: false };
    const ALL: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY, whole: false };

    /// From end to end.
    pub fn new(lo: f64, hi: f64) -> Self {
        Self { lo, hi, whole: true }
    }

    /// One number.
    pub fn point(x: f64) -> Self {
        Self::new(x, x)
    }

    /// What a ball holds.
    pub fn of_ball(ball: &Ball) -> Self {
        Self::new(ball.lower(), ball.upper())
    }

    /// Whether there is no number in it.
    pub fn is_empty(&self) -> bool {
        self.lo.is_nan()
    }

    /// Whether both ends are finite.
    pub fn is_bounded(&self) -> bool {
        self.lo.is_finite() && self.hi.is_finite()
    }

    /// Whether everything on the way was defined and continuous, and bounded.
    pub fn is_usable(&self) -> bool {
        self.whole && self.is_bounded()
    }

    /// Whether a number is in it.
    pub fn contains(&self, x: f64) -> bool {
        self.lo <= x && x <= self.hi
    }

    /// Whether all of it is in another.
    pub fn is_within(&self, other: &Self) -> bool {
        other.lo <= self.lo && self.hi <= other.hi
    }

    /// About the middle.
    pub fn middle(&self) -> f64 {
        let middle = self.lo + 0.5 * (self.hi - self.lo);
        middle.clamp(self.lo, self.hi)
    }

    /// The distance of the ends.
    pub fn width(&self) -> f64 {
        self.hi - self.lo
    }

    /// The largest magnitude.
    pub fn size(&self) -> f64 {
        self.lo.abs().max(self.hi.abs())
    }

    /// What is in both.
    pub fn meet(&self, other: &Self) -> Self {
        let (lo, hi) = (self.lo.max(other.lo), self.hi.min(other.hi));
        if lo <= hi { Self { lo, hi, whole: self.whole && other.whole } } else { Self::EMPTY }
    }

    fn with(self, whole: bool) -> Self {
        Self { whole: self.whole && whole, ..self }
    }

    /// The values of a rising function between the ends, which lie in its domain; values within `range`.
    fn rising(&self, f: impl Fn(&Ball) -> Ball, range: (f64, f64)) -> Self {
        if self.is_empty() {
            return *self;
        }
        let lo = if self.lo.is_finite() { f(&Ball::exact(self.lo)).lower() } else { range.0 };
        let hi = if self.hi.is_finite() { f(&Ball::exact(self.hi)).upper() } else { range.1 };
        Self { lo: lo.max(range.0), hi: hi.min(range.1), whole: self.whole }
    }

    /// The part within a domain.
    fn within(&self, lo: f64, hi: f64) -> Self {
        let inside = lo <= self.lo && self.hi <= hi;
        self.meet(&Self::new(lo, hi)).with(inside)
    }

    /// The magnitudes.
    #[must_use]
    pub fn abs(&self) -> Self {
        if self.lo >= 0.0 {
            *self
        } else if self.hi <= 0.0 {
            self.neg()
        } else {
            Self { lo: 0.0, hi: self.size(), whole: self.whole }
        }
    }

    /// Sine of the interval shifted by quarters of a turn: extrema at pi/2 + k pi.
    fn sine(&self, f: impl Fn(&Ball) -> Ball, quarter: f64) -> Self {
        use std::f64::consts::{FRAC_PI_2, TAU};
        let all = Self { lo: -1.0, hi: 1.0, whole: self.whole };
        if !self.is_bounded() || self.size() > LARGE_ANGLE || self.width() >= TAU {
            return all;
        }
        let (a, b) = (f(&Ball::exact(self.lo)), f(&Ball::exact(self.hi)));
        let mut own = Self { lo: a.lower().min(b.lower()), hi: a.upper().max(b.upper()), whole: self.whole };
        // Whether a top at `top` + k 2 pi lies between the ends, or nearly.
        let has = |top: f64| {
            let next = top + TAU * ((self.lo - ANGLE * (1.0 + self.lo.abs()) - top) / TAU).ceil();
            next <= self.hi + ANGLE * (1.0 + self.hi.abs())
        };
        if has(FRAC_PI_2 - quarter) {
            own.hi = 1.0;
        }
        if has(-FRAC_PI_2 - quarter) {
            own.lo = -1.0;
        }
        own.meet(&all)
    }

    fn tan(&self) -> Self {
        use std::f64::consts::{FRAC_PI_2, PI};
        if !self.is_bounded() || self.size() > LARGE_ANGLE {
            return Self::ALL;
        }
        let next = FRAC_PI_2 + PI * ((self.lo - ANGLE * (1.0 + self.lo.abs()) - FRAC_PI_2) / PI).ceil();
        if next <= self.hi + ANGLE * (1.0 + self.hi.abs()) {
            return Self::ALL;
        }
        self.rising(Ball::tan, (f64::NEG_INFINITY, f64::INFINITY))
    }

    fn exp(&self) -> Self {
        // Beyond the range of balls nothing but the sign is kept.
        let f = |x: &Ball| if x.mid_f64() > 600.0 { Ball::NOT_FINITE } else { x.exp() };
        let mut own = self.rising(f, (0.0, f64::INFINITY));
        if self.lo > 600.0 {
            own.lo = 1e200;
        }
        own
    }

    fn ln(&self) -> Self {
        let part = self.within(0.0, f64::INFINITY);
        if part.hi == 0.0 {
            return Self::EMPTY;
        }
        let f = |x: &Ball| if x.is_zero() { Ball::NOT_FINITE } else { x.ln() };
        part.rising(f, (f64::NEG_INFINITY, f64::INFINITY)).with(part.lo > 0.0)
    }
}

impl Scalar for Interval {
    type Precision = ();

    fn from_number(number: &Number, (): ()) -> Self {
        Self::of_ball(&Ball::from_number(number, ()))
    }

    fn pi((): ()) -> Self {
        Self::of_ball(&Ball::PI)
    }

    #[inline]
    fn add(&self, other: &Self) -> Self {
        if self.is_empty() || other.is_empty() {
            return Self::EMPTY;
        }
        Self {
            lo: sum_down(self.lo, other.lo).max(f64::NEG_INFINITY),
            hi: sum_up(self.hi, other.hi).min(f64::INFINITY),
            whole: self.whole && other.whole,
        }
    }

    #[inline]
    fn mul(&self, other: &Self) -> Self {
        if self.is_empty() || other.is_empty() {
            return Self::EMPTY;
        }
        // Signs tell which ends make the least and the largest product.
        if self.hi <= 0.0 && self.lo < 0.0 {
            return self.neg().mul(other).neg();
        }
        let (lo, hi) = if self.lo >= 0.0 {
            let low = if other.lo >= 0.0 { self.lo } else { self.hi };
            let high = if other.hi >= 0.0 { self.hi } else { self.lo };
            (products(low, other.lo).0, products(high, other.hi).1)
        } else if other.lo >= 0.0 || other.hi <= 0.0 {
            return other.mul(self);
        } else {
            let low = products(self.lo, other.hi).0.min(products(self.hi, other.lo).0);
            (low, products(self.lo, other.lo).1.max(products(self.hi, other.hi).1))
        };
        Self { lo, hi, whole: self.whole && other.whole }
    }

    fn div(&self, other: &Self) -> Self {
        if self.is_empty() || other.is_empty() || other.lo == 0.0 && other.hi == 0.0 {
            return Self::EMPTY;
        }
        let whole = self.whole && other.whole;
        if other.hi <= 0.0 {
            return self.neg().div(&other.neg());
        }
        if other.lo < 0.0 {
            let zero = self.lo == 0.0 && self.hi == 0.0;
            return if zero { Self::point(0.0).with(false) } else { Self::ALL };
        }
        let inverse = |a: f64, b: f64| if b == 0.0 { (f64::INFINITY * a, f64::INFINITY * a) } else { quotients(a, b) };
        let side = |a: f64| {
            if a == 0.0 {
                return (0.0, 0.0);
            }
            let (first, last) = (inverse(a, other.lo), inverse(a, other.hi));
            (first.0.min(last.0), first.1.max(last.1))
        };
        let (low, high) = (side(self.lo), side(self.hi));
        Self { lo: low.0.min(high.0), hi: low.1.max(high.1), whole: whole && other.lo > 0.0 }
    }

    fn neg(&self) -> Self {
        Self { lo: -self.hi, hi: -self.lo, whole: self.whole }
    }

    fn powi(&self, exponent: i32) -> Self {
        if self.is_empty() {
            return *self;
        }
        let positive = exponent.unsigned_abs();
        let base = if positive.is_multiple_of(2) { self.abs() } else { *self };
        let power = |x: &Self| power(x, positive, Self::mul).unwrap_or_else(|| Self::point(1.0));
        let own = if base.lo < 0.0 && base.hi > 0.0 {
            Self { lo: power(&Self::point(base.lo)).lo, hi: power(&Self::point(base.hi)).hi, whole: base.whole }
        } else {
            power(&base).with(base.whole)
        };
        if exponent < 0 { Self::point(1.0).div(&own) } else { own }
    }

    fn sqrt(&self) -> Self {
        let part = self.within(0.0, f64::INFINITY);
        // IEEE 754 rounds roots to nearest.
        let ends = |x: f64| match x.sqrt() {
            root if x.is_infinite() || two_prod(root, root) == (x, 0.0) && x > SMALLEST => (root, root),
            root => (root.next_down().max(0.0), root.next_up()),
        };
        if part.is_empty() || part.hi == 0.0 { part } else { Self { lo: ends(part.lo).0, hi: ends(part.hi).1, ..part } }
    }

    fn pow(&self, exponent: &Self) -> Self {
        // Negative numbers have powers where the exponent is whole.
        if self.lo < 0.0 && exponent.lo.ceil() <= exponent.hi {
            if exponent.lo == exponent.hi && exponent.lo.abs() <= 65_536.0 {
                return self.powi(exponent.lo as i32);
            }
            let size = Self { hi: self.size(), ..Self::point(0.0) }.pow(exponent).size();
            return Self { lo: -size, hi: size, whole: false };
        }
        let part = self.within(0.0, f64::INFINITY);
        if part.is_empty() || exponent.is_empty() {
            return Self::EMPTY;
        }
        // exp(y ln x), with 0^y = 0 for y > 0.
        if part.hi == 0.0 {
            return if exponent.lo > 0.0 { part } else { Self::EMPTY };
        }
        let own = exponent.mul(&part.ln()).exp();
        let rises = part.whole && exponent.whole && exponent.lo > 0.0;
        Self { whole: rises || own.whole && (part.lo > 0.0 || exponent.lo > 0.0), ..own }
    }

    fn apply(&self, function: Function) -> Self {
        if self.is_empty() {
            return *self;
        }
        let all = (f64::NEG_INFINITY, f64::INFINITY);
        match function {
            Function::Sin => self.sine(Ball::sin, 0.0),
            Function::Cos => self.sine(Ball::cos, std::f64::consts::FRAC_PI_2),
            Function::Tan => self.tan(),
            Function::Asin => self.within(-1.0, 1.0).rising(Ball::asin, all),
            Function::Acos => self.within(-1.0, 1.0).neg().rising(|x| x.neg().acos(), all),
            Function::Atan => self.rising(Ball::atan, (-1.6, 1.6)),
            Function::Sinh => {
                let f = |x: &Ball| if x.mid_f64().abs() > 600.0 { Ball::NOT_FINITE } else { x.sinh() };
                self.rising(f, all)
            }
            Function::Cosh => {
                let f = |x: &Ball| if x.mid_f64() > 600.0 { Ball::NOT_FINITE } else { x.cosh() };
                self.abs().rising(f, (1.0, f64::INFINITY))
            }
            Function::Tanh => self.rising(Ball::tanh, (-1.0, 1.0)),
            Function::Exp => self.exp(),
            Function::Ln => self.ln(),
            Function::Abs => self.abs(),
        }
    }

    fn atan2(&self, x: &Self) -> Self {
        if self.is_empty() || x.is_empty() {
            return Self::EMPTY;
        }
        let cut = x.lo <= 0.0 && self.contains(0.0);
        let whole = self.whole && x.whole;
        if cut || !self.is_bounded() || !x.is_bounded() {
            return Self::of_ball(&Ball::PI.hull(&Ball::PI.neg())).with(whole && !cut);
        }
        // Off the cut the angle is extremal at corners.
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for (y, x) in [(self.lo, x.lo), (self.lo, x.hi), (self.hi, x.lo), (self.hi, x.hi)] {
            let angle = Ball::exact(y).atan2(&Ball::exact(x));
            lo = lo.min(angle.lower());
            hi = hi.max(angle.upper());
        }
        Self { lo, hi, whole }
    }

    fn is_finite(&self) -> bool {
        self.is_bounded()
    }

    fn is_exact_zero(&self) -> bool {
        self.lo == 0.0 && self.hi == 0.0
    }
}
