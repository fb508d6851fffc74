//! The decimal digits of a ball, or a bigger number with bounds: those it decides, and no others.
//!
//! Everything is done in exact integers, so the printed digits are a function of the ball alone.

use std::ops::Range;

use dashu_int::ops::{Abs, UnsignedAbs};
use dashu_int::{IBig, UBig};
use dashu_ratio::Relaxed as Fraction;

use super::ball::Ball;
use super::big::Big;
use super::double::exponent_of;
use super::magnitude::Magnitude;
use crate::number::Number;

/// More digits than this are not printed whatever is asked for; a ball holds about 32.
const MOST_DIGITS: usize = 1000;
/// As that, for numbers that may have any number of bits.
const MOST_BIG_DIGITS: usize = 100_000;
/// Bits that hold both parts of a ball, whatever lies between them.
const BITS_OF_BALLS: usize = 2200;
/// Numbers beyond 2 to this, and those below its inverse, are not written out in digits.
const WIDEST: i64 = 1 << 20;

/// How a printed number relates to the true one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// All digits asked for, correctly rounded (to nearest, ties to even).
    Correct,
    /// All digits asked for; the true number is so close to the middle between two neighbours
    /// that the ball does not decide between them. Right to within one unit of the last place.
    Tie,
    /// Fewer digits than asked for, correctly rounded: the ball decides no more.
    Fewer,
    /// Not even one digit is decided.
    Undecided,
}

/// A number in decimal.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Decimal {
    /// The digits, zeros kept: `3.132091953`, `0.000120`, `1.234567890e-12`.
    pub text: String,
    /// How many significant digits were decided.
    pub digits: usize,
    /// A bound of |printed - true|, rounded up to one significant digit; 0 if the printed number
    /// is exact, infinite if the ball is not finite.
    pub error_bound: f64,
    /// How the digits relate to the true number.
    pub rounding: Rounding,
}

/// `digits` 10^(exponent - count + 1) where `digits` has `count` decimal digits.
#[derive(PartialEq)]
struct Rounded {
    digits: UBig,
    exponent: i32,
    count: usize,
}

enum Direction {
    Down,
    Nearest,
    Up,
}

/// The number in `value` with `digits` significant digits (at least 1), correctly rounded if the
/// ball decides them, else with as many digits as it decides.
///
/// Positional for exponents from -5 to 15 as far as the digits reach the decimal point, else
/// scientific. A number of which no digit is decided, as one that may be zero but is not known to be, prints as `0` with its
/// bound.
pub fn decimal(value: &Ball, digits: usize) -> Decimal {
    Big::from_ball(value, BITS_OF_BALLS).written(Wanted::digits(digits.min(MOST_DIGITS)))
}

/// The digits of [`decimal`], where they are correct and doubles on both sides of the ball tell; many times as fast.
///
/// Rounding to a number of digits preserves order, so that what rounds to the same at both ends does so in between.
pub fn quick_decimal(value: &Ball, digits: usize) -> Option<String> {
    let mut text = Vec::new();
    if push_decimal(&mut text, value, digits) {
        return String::from_utf8(text).ok();
    }
    let is_negative = value.is_negative();
    let ends = if is_negative { [-value.upper(), -value.lower()] } else { [value.lower(), value.upper()] };
    if !(ends[0] > 0.0 && ends[1] < f64::INFINITY) {
        return None;
    }
    let count = digits.clamp(1, MOST_DIGITS);
    let [below, above] = ends.map(|end| format!("{end:.*e}", count - 1));
    let (rounded, exponent) = below.split_once('e').filter(|_| below == above)?;
    Some(layout(&rounded.replace('.', ""), exponent.parse().ok()?, is_negative))
}

/// The same behind a text, where two or three operations decide the digits, and whether they do: as fast as it goes.
pub fn push_decimal(out: &mut Vec<u8>, value: &Ball, digits: usize) -> bool {
    if value.is_zero() {
        out.push(b'0');
        return true;
    }
    let Some((mut whole, exponent)) = quick_digits(value, digits.max(1)) else { return false };
    let mut text = [b'0'; QUICK_DIGITS];
    let text = &mut text[..digits.max(1)];
    for place in text.iter_mut().rev() {
        *place += (whole % 10) as u8;
        whole /= 10;
    }
    place(out, text, exponent, value.mid.hi < 0.0);
    true
}

/// So many digits leave room in a double for what they are rounded from.
const QUICK_DIGITS: usize = 14;
/// The powers of ten that are doubles.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// The digits of |x| as a whole number, and the power of ten of the first one, where doubles decide them.
///
/// y = |x| 10^k is off by two roundings, 2^-52 y, and by what x is off by times 10^k; `slack` is at least 1.9 times that, and y - N
/// is exact. So |x| 10^k is within 1/2 of N. It is not below the power of ten that N is compared with, where digits would be one finer.
fn quick_digits(value: &Ball, count: usize) -> Option<(u64, i32)> {
    let (x, error) = (value.mid.hi.abs(), value.mid_f64_error());
    let limit = *POWERS.get(count).filter(|_| count <= QUICK_DIGITS)?;
    let scaled = |x: f64, exponent: i32| {
        let power = count as i32 - 1 - exponent;
        let first = *POWERS.get(power.unsigned_abs().min(22) as usize)?;
        let second = *POWERS.get(power.unsigned_abs().saturating_sub(22) as usize)?;
        Some(if power < 0 { x / first / second } else { x * first * second })
    };
    // log10(2) from below: right, or one too small.
    let mut exponent = (exponent_of(x) * 1233) >> 12;
    let mut y = scaled(x, exponent)?;
    if y >= limit {
        exponent += 1;
        y = scaled(x, exponent)?;
    }
    let slack = 2.0 * (scaled(error, exponent)? + y * f64::EPSILON);
    let nearest = (y + 0.5) as i64;
    let (rounded, least) = (nearest as f64, limit / 10.0);
    if !((y - rounded).abs() + slack < 0.5 && y - slack >= least && rounded <= limit) {
        return None;
    }
    Some(if rounded == limit { (nearest as u64 / 10, exponent + 1) } else { (nearest as u64, exponent) })
}

/// The number in `value` rounded to a multiple of 10^place by the rules of [`decimal`], with at most `digits`
/// significant digits and at least one.
pub fn decimal_to_place(value: &Ball, place: i32, digits: usize) -> Decimal {
    Big::from_ball(value, BITS_OF_BALLS).written(Wanted::digits(digits.min(MOST_DIGITS)).to(place))
}

/// How far a number is written out.
struct Wanted {
    /// So many significant digits, at least 1.
    digits: usize,
    /// And none behind this power of ten, as far as one is left.
    place: Option<i32>,
}

impl Wanted {
    fn digits(digits: usize) -> Self {
        Self { digits: digits.max(1), place: None }
    }

    fn to(self, place: i32) -> Self {
        Self { place: Some(place), ..self }
    }
}

impl Number {
    /// The number in decimal notation, rounded to the nearest with `digits` significant digits
    /// (ties to even, at least one digit): `0.3333`, `-12.50`, and `6.022e23` outside
    /// 1e-6 .. 1e`digits`.
    #[must_use]
    pub fn to_decimal(&self, digits: usize) -> String {
        let digits = digits.max(1);
        let value = Fraction::from_parts(self.numerator(), self.denominator()).abs();
        let rounded = round(&value, digits, &Direction::Nearest);
        let text = if self.is_zero() { "0".repeat(digits) } else { rounded.digits.to_string() };
        let mut out = Vec::new();
        place_among(&mut out, text.as_bytes(), rounded.exponent, self.is_negative(), -6..digits as i32);
        String::from_utf8(out).unwrap_or_default()
    }
}

impl Big {
    /// The number with `digits` significant digits (1 to 100,000), by the rules of [`decimal`].
    ///
    /// Beyond 2^(2^20), some 315,000 digits, nothing is decided, and below the inverse nothing but
    /// the bound (in doubles, so at least 5e-324).
    #[must_use]
    pub fn decimal(&self, digits: usize) -> Decimal {
        self.written(Wanted::digits(digits.min(MOST_BIG_DIGITS)))
    }

    /// The number rounded to a multiple of 10^place, by the rules of [`decimal_to_place`].
    #[must_use]
    pub fn decimal_to_place(&self, place: i32, digits: usize) -> Decimal {
        self.written(Wanted::digits(digits.min(MOST_BIG_DIGITS)).to(place))
    }

    fn written(&self, wanted: Wanted) -> Decimal {
        let size = self.abs_upper();
        if !size.is_finite() || size >= Magnitude::power_of_two(WIDEST) {
            return not_a_number();
        }
        if self.is_zero() {
            return between(Ends { low: IBig::ZERO, high: IBig::ZERO, exponent: 0 }, wanted);
        }
        let (significand, exponent) = self.mid();
        let least = Magnitude::power_of_two(-WIDEST);
        let (mid, exponent, radius) = if self.mid_upper() < least {
            (IBig::ZERO, 0, size.max(least))
        } else {
            (significand.clone(), exponent, self.radius())
        };
        if radius.is_zero() {
            return between(Ends { low: mid.clone(), high: mid, exponent: exponent as i32 }, wanted);
        }
        // A radius below all digits that can be asked for is rounded up to that.
        let (mantissa, place) = radius.max(size.scale(-WIDEST)).parts();
        let (fraction, shift) = parts(mantissa);
        let place = place + i64::from(shift);
        let common = if mid == IBig::ZERO { place } else { place.min(exponent) };
        let mid = mid << (exponent - common).max(0) as usize;
        let radius = fraction << (place - common).max(0) as usize;
        between(Ends { low: &mid - &radius, high: mid + radius, exponent: common as i32 }, wanted)
    }
}

fn not_a_number() -> Decimal {
    Decimal { text: "nan".to_owned(), digits: 0, error_bound: f64::INFINITY, rounding: Rounding::Undecided }
}

/// The digits of the numbers from `low` 2^exponent to `high` 2^exponent.
struct Ends {
    low: IBig,
    high: IBig,
    exponent: i32,
}

fn between(Ends { low, high, exponent }: Ends, wanted: Wanted) -> Decimal {
    let zero = IBig::ZERO;
    // Where no digit is decided, 0 with a bound that says so is what is right.
    let undecided = |most: UBig| Decimal {
        text: "0".to_owned(),
        digits: 0,
        error_bound: one_digit(&fraction(most, exponent)),
        rounding: Rounding::Undecided,
    };
    let (is_zero, may_be_zero, negative) = (low == zero && high == zero, low <= zero && high >= zero, high < zero);
    // By magnitude from here on.
    let [low, high] = [low, high].map(IBig::unsigned_abs);
    if is_zero {
        return Decimal { text: "0".to_owned(), digits: wanted.digits, error_bound: 0.0, rounding: Rounding::Correct };
    }
    if may_be_zero {
        return undecided(low.max(high));
    }
    let (least, most) = if negative { (high, low) } else { (low, high) };
    let Some((rounded, rounding)) = decide(&least, &most, exponent, wanted) else { return undecided(most) };
    let printed = rounded.value();
    let error = [least, most].map(|end| (&printed - fraction(end, exponent)).abs());
    let error = error.into_iter().fold(Fraction::ZERO, Fraction::max);
    let text = layout(&rounded.digits.to_string(), rounded.exponent, negative);
    Decimal { digits: rounded.count, error_bound: one_digit(&error), text, rounding }
}

/// The digits common to both ends, as many as `wanted` if possible; `None` where not even one is.
fn decide(least: &UBig, most: &UBig, exponent: i32, wanted: Wanted) -> Option<(Rounded, Rounding)> {
    let (low, high) = (fraction(least.clone(), exponent), fraction(most.clone(), exponent));
    // The power of ten of the first digit, before anything is rounded.
    let leading = round(&low, 1, &Direction::Down).exponent;
    let Wanted { digits: most, place } = wanted;
    let wanted = match place {
        Some(place) => {
            let count = leading.saturating_sub(place).saturating_add(1);
            usize::try_from(count).unwrap_or(0).clamp(1, most)
        }
        None => most,
    };
    let at = |count| {
        let below = round(&low, count, &Direction::Nearest);
        let above = round(&high, count, &Direction::Nearest);
        (below, above)
    };
    let (below, above) = at(wanted);
    if below == above {
        return Some((below.carried(leading, place, most), Rounding::Correct));
    }
    // A tie: both ends within a thousandth of a unit of the last place, on both sides of a middle.
    let width = &high - &low;
    if &width * Fraction::from(UBig::from(1000_u32)) <= below.unit() {
        // Across a power of ten the upper one ends in 0.
        let even = above.exponent > below.exponent || (&above.digits % 2u8) == 0;
        return Some((if even { above } else { below }, Rounding::Tie));
    }
    // No more digits than the width of the ball leaves; start there.
    let mut count = (round(&low, 1, &Direction::Nearest).exponent - round(&width, 1, &Direction::Nearest).exponent + 2)
        .clamp(0, wanted as i32 - 1) as usize;
    while count > 0 {
        let (below, above) = at(count);
        if below == above {
            return Some((below, Rounding::Fewer));
        }
        count -= 1;
    }
    None
}

impl Rounded {
    fn value(&self) -> Fraction {
        self.unit() * Fraction::from(self.digits.clone())
    }

    /// Where rounding has carried beyond the leading digit, as 9.96 to 10.0, the last place is the one that was asked for.
    fn carried(mut self, leading: i32, place: Option<i32>, most: usize) -> Self {
        let ends_there = place.is_some_and(|place| leading - self.count as i32 + 1 == place);
        if self.exponent > leading && ends_there && self.count < most {
            self.digits *= UBig::from(10u8);
            self.count += 1;
        }
        self
    }

    /// One unit of the last place.
    fn unit(&self) -> Fraction {
        let place = self.exponent - self.count as i32 + 1;
        let power = power_of_ten(place.unsigned_abs());
        if place >= 0 { Fraction::from(power) } else { Fraction::from_parts(IBig::ONE, power) }
    }
}

/// Digits, the first of which belongs to this power of ten.
fn layout(digits: &str, exponent: i32, negative: bool) -> String {
    let mut out = Vec::new();
    place(&mut out, digits.as_bytes(), exponent, negative);
    String::from_utf8(out).unwrap_or_default()
}

fn place(out: &mut Vec<u8>, digits: &[u8], exponent: i32, negative: bool) {
    place_among(out, digits, exponent, negative, -5..digits.len().min(16) as i32);
}

/// The same, positional for these powers, of which none is beyond the digits, else scientific.
fn place_among(out: &mut Vec<u8>, digits: &[u8], exponent: i32, negative: bool, positional: Range<i32>) {
    if negative {
        out.push(b'-');
    }
    let is_positional = positional.contains(&exponent);
    if is_positional && exponent < 0 {
        out.extend_from_slice(&b"0.00000"[..(1 - exponent) as usize]);
        out.extend_from_slice(digits);
        return;
    }
    let (whole, rest) = digits.split_at(if is_positional { exponent as usize + 1 } else { 1 });
    out.extend_from_slice(whole);
    if !rest.is_empty() {
        out.push(b'.');
        out.extend_from_slice(rest);
    }
    if !is_positional {
        out.extend_from_slice(format!("e{exponent}").as_bytes());
    }
}

fn power_of_ten(exponent: u32) -> UBig {
    UBig::from(10u8).pow(exponent as usize)
}

/// mantissa 2^exponent
fn fraction(mantissa: UBig, exponent: i32) -> Fraction {
    let power = UBig::ONE << exponent.unsigned_abs() as usize;
    if exponent >= 0 { Fraction::from(mantissa * power) } else { Fraction::from_parts(mantissa.into(), power) }
}

/// A double as mantissa and exponent of 2, exactly.
pub(super) fn parts(x: f64) -> (IBig, i32) {
    let bits = x.to_bits();
    let biased = ((bits >> 52) & 0x7ff) as i32;
    let fraction = bits & ((1 << 52) - 1);
    let (mantissa, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | (1 << 52), biased - 1075) };
    let mantissa = IBig::from(mantissa);
    (if x < 0.0 { -mantissa } else { mantissa }, exponent)
}

/// A positive fraction with `count` significant digits; zero gives zero.
fn round(value: &Fraction, count: usize, direction: &Direction) -> Rounded {
    use dashu_int::ops::{BitTest, DivRem};
    if value.is_zero() {
        return Rounded { digits: UBig::ZERO, exponent: 0, count };
    }
    let (numerator, denominator) = (value.numerator().unsigned_abs(), value.denominator());
    // 2^(bits - 1) < value, so this exponent of 10 is right or too small.
    let bits = numerator.bit_len() as i64 - denominator.bit_len() as i64;
    let mut exponent = ((bits - 1) as f64 * std::f64::consts::LOG10_2).floor() as i32;
    let limit = power_of_ten(count as u32);
    loop {
        let shift = count as i32 - 1 - exponent;
        let power = power_of_ten(shift.unsigned_abs());
        let (numerator, denominator) = if shift >= 0 {
            (&numerator * power, denominator.clone())
        } else {
            (numerator.clone(), denominator * power)
        };
        let (mut digits, rest) = numerator.div_rem(&denominator);
        if digits >= limit {
            exponent += 1;
            continue;
        }
        let up = match direction {
            Direction::Down => false,
            Direction::Up => rest != UBig::ZERO,
            Direction::Nearest => {
                let twice = rest << 1;
                twice > denominator || (twice == denominator && (&digits % 2u8) == 1)
            }
        };
        if up {
            digits += UBig::ONE;
        }
        if digits >= limit {
            digits /= UBig::from(10u8);
            exponent += 1;
        }
        return Rounded { digits, exponent, count };
    }
}

/// The fraction rounded up to one significant digit, as the nearest double that is not 0.
fn one_digit(value: &Fraction) -> f64 {
    let rounded = round(value, 1, &Direction::Up);
    let bound = format!("{}e{}", rounded.digits, rounded.exponent).parse().unwrap_or(f64::INFINITY);
    if bound == 0.0 && !value.is_zero() { f64::from_bits(1) } else { bound }
}

/// A bound rounded up to one significant digit: 4.4e-16 gives 5e-16. What prints as one digit
/// already stays.
pub fn one_digit_up(bound: f64) -> f64 {
    one_digit_up_text(bound).parse().unwrap_or(f64::INFINITY)
}

/// A bound rounded up to one significant digit, as text: `5e-16`, `0`, `inf`.
pub fn one_digit_up_text(bound: f64) -> String {
    if bound == 0.0 {
        return "0".to_owned();
    }
    let shortest = format!("{:e}", bound.abs());
    let Some((mantissa, exponent)) = shortest.split_once('e') else { return "inf".to_owned() };
    let (first, rest) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let (Ok(mut digit), Ok(mut exponent)) = (first.parse::<u32>(), exponent.parse::<i32>()) else {
        return "inf".to_owned();
    };
    if rest.bytes().any(|b| b != b'0') {
        digit += 1;
    }
    if digit == 10 {
        (digit, exponent) = (1, exponent + 1);
    }
    format!("{digit}e{exponent}")
}
