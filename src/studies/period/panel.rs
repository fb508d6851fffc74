//! The time along a line of positions: ∫ sqrt(2M/(E - U)) dq by Taylor expansions with bounds.
//!
//! Positions are q = start + x·span with x from 0 to 1, and E - U = h(x)/w(x)². Where x = 0 is a turning point, w = 1/sqrt(x)
//! and h is the mean of the slope of E - U between 0 and x, which is positive and smooth. Elsewhere w = 1. On a panel of half width r about c, h, M and g = sqrt(2M/h) are expanded in
//! s = (x - c)/r, and the time is |span| Σ g_k J_k with J_k = ∫ s^k w(x) dx (`weights`). The rest is Lagrange's, with the
//! next coefficient enclosed over the whole panel. A panel whose rest is too large is made shorter; how small the rest was
//! tells how long the next one may be.

use super::weights::{divided, of_one, of_root};
use crate::flow::horner;
use librate_core::expr::{Prepared, Series, Tape};
use librate_core::order::Order;
use librate_core::precision::{Enclosure, Magnitude, Scalar, exponent_of, power_of_two};

/// So many panels are tried at most, in one integral.
const MOST_PANELS: usize = 4000;

/// Widths below this are not tried beside a turning point; elsewhere doubles end earlier.
const LEAST: f64 = 1e-75;

/// About so many bits for each term of an expansion a rest gains where a panel is half as wide. How panels are chosen decides
/// about time alone.
const BITS_A_HALVING: f64 = 1.4;

/// About so many bits for each term a rest is larger than the last terms where these are too large.
const BITS_OF_A_REST: f64 = 0.65;

/// So many bits for each term smaller than it may be the rest of the next panel shall be.
const MARGIN: f64 = 0.18;

/// Why a panel is not integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// E - U is negative in its middle, proved.
    Forbidden,
    /// M is negative in its middle, proved.
    NegativeMass,
    /// Numbers of this precision do not tell E - U from 0, or too few of its digits.
    Precision,
    /// E - U, M or a derivative is not finite, or the rest is too large.
    Rough,
    /// There are more panels than are tried.
    Long,
}

/// Where an integral ended, and why.
pub(super) struct Obstacle<S> {
    pub(super) refusal: Refusal,
    /// The position.
    pub(super) at: S,
}

/// Where what an absolute value is taken of changes its sign, in numbers or as constant expressions.
#[derive(Clone, Debug)]
pub(super) struct Kink<T> {
    pub(super) place: T,
    /// The derivative of that by the coordinate.
    pub(super) slope: T,
    /// Whether it is known to be the equilibrium, where paths end.
    pub(super) central: bool,
}

/// U and M as functions of the position, and the integrand made of them.
pub(super) struct Field<S: Enclosure> {
    values: Prepared<S>,
    series: Series<S>,
    shape: Series<S>,
    precision: S::Precision,
    scratch: Vec<S>,
    zero: S,
    /// E.
    pub(super) energy: S,
    kinks: Vec<Kink<S>>,
    /// Whether signs are those of a piece between kinks, and not those at each position.
    held: bool,
    /// The position, the signs of what absolute values are taken of, and E.
    inputs: Vec<S>,
}

impl<S: Enclosure> Field<S> {
    /// `energies` gives U and M from the coordinate, signs and E, `shape` sqrt(2M/h) from h and M.
    pub(super) fn new(energies: &Tape, shape: &Tape, kinks: Vec<Kink<S>>, precision: S::Precision) -> Self {
        let values = energies.prepare::<S>(precision);
        let zero = S::exact(0.0, precision);
        Self {
            inputs: vec![zero.clone(); 2 + kinks.len()],
            kinks,
            held: false,
            series: values.series(),
            values,
            shape: shape.prepare::<S>(precision).series(),
            precision,
            scratch: Vec::new(),
            energy: zero.clone(),
            zero,
        }
    }

    /// M is that of a motion of this energy, if it depends on it.
    pub(super) fn set_energy(&mut self, energy: S) {
        if let Some(own) = self.inputs.last_mut() {
            *own = energy.clone();
        }
        self.energy = energy;
    }

    /// Puts a position in, and the signs there: anything from -1 to 1 where they are not decided, so that values and slopes are
    /// enclosed on both sides of a kink.
    fn put(&mut self, at: &S) {
        self.inputs[0] = at.clone();
        if self.held {
            return;
        }
        for (kink, sign) in self.kinks.iter().zip(&mut self.inputs[1..]) {
            let own = at.sub(&kink.place).mul(&kink.slope);
            *sign = if own.is_positive() {
                S::exact(1.0, self.precision)
            } else if own.is_negative() {
                S::exact(-1.0, self.precision)
            } else {
                self.zero.with_added_magnitude(Magnitude::ONE)
            };
        }
    }

    /// Whether no absolute value may have its kink at a position.
    pub(super) fn is_smooth_at(&self, at: &S) -> bool {
        self.kinks.iter().all(|kink| {
            let way = at.sub(&kink.place);
            way.is_positive() || way.is_negative()
        })
    }

    /// Takes U and M as they are in the middle of a path, with the signs there, until [`Field::release`]: beyond kinks they
    /// go on as if there were none.
    pub(super) fn hold(&mut self, start: &S, span: &S) {
        let middle = start.add(&span.mul(&self.number(0.5)));
        self.put(&middle);
        self.held = true;
    }

    pub(super) fn release(&mut self) {
        self.held = false;
    }

    /// The pieces of a path between kinks, first positions and spans; the error where it is not decided whether a kink lies on it, or
    /// which of two comes first.
    pub(super) fn pieces(&self, start: S, span: S) -> Result<Vec<(S, S)>, Obstacle<S>> {
        let end = start.add(&span);
        let mut between: Vec<S> = Vec::new();
        let undecided = |at: &S| Obstacle { refusal: Refusal::Rough, at: at.clone() };
        for Kink { place, .. } in self.kinks.iter().filter(|kink| !kink.central) {
            let (before, after) = (place.sub(&start), place.sub(&end));
            let inside = before.mul(&after);
            if inside.is_negative() {
                between.push(place.clone());
            } else if !inside.is_positive() && !before.is_exact_zero() && !after.is_exact_zero() {
                return Err(undecided(place));
            }
        }
        let way = |place: &S| place.sub(&start).mid_f64().abs();
        between.order_by(|a, b| way(a).total_cmp(&way(b)));
        let mut pieces: Vec<(S, S)> = vec![(start, span)];
        for place in between {
            let Some((from, rest)) = pieces.pop() else { break };
            let own = place.sub(&from);
            if own.is_exact_zero() {
                // Two of them have their kinks at the same place.
                pieces.push((from, rest));
                continue;
            }
            if !own.mul(&rest).is_positive() {
                return Err(undecided(&place));
            }
            pieces.push((from, own));
            let rest = end.sub(&place);
            pieces.push((place, rest));
        }
        Ok(pieces)
    }

    /// A way from a position without kinks on it: half of that to the next one on this side, 1 or -1, or of this length where
    /// there is none; `None` where it is not decided which kinks lie there.
    pub(super) fn free_way(&self, at: &S, side: f64) -> Option<S> {
        let mut least = self.number(side);
        for kink in &self.kinks {
            let way = kink.place.sub(at);
            if way.is_positive() || way.is_negative() {
                if way.mid_f64() * side > 0.0 && way.mid_f64().abs() < least.mid_f64().abs() {
                    least = way;
                }
            } else if !way.is_exact_zero() && !kink.place.center().sub(&at.center()).is_exact_zero() {
                return None;
            }
        }
        Some(least.mul(&self.number(0.5)))
    }

    pub(super) fn number(&self, value: f64) -> S {
        S::exact(value, self.precision)
    }

    pub(super) fn pi(&self) -> S {
        S::pi(self.precision)
    }

    /// U at a position.
    pub(super) fn potential(&mut self, at: &S) -> S {
        self.put(at);
        let mut both = [self.zero.clone(), self.zero.clone()];
        self.values.evaluate_into(&self.inputs, &mut self.scratch, &mut both);
        let [potential, _] = both;
        potential
    }

    /// The first `count` Taylor coefficients of U and M along at + slope·s.
    pub(super) fn expand(&mut self, at: &S, slope: &S, count: usize) -> (Vec<S>, Vec<S>) {
        self.series.clear();
        let mut potential = Vec::with_capacity(count);
        let mut mass = Vec::with_capacity(count);
        self.put(at);
        let mut later = vec![self.zero.clone(); self.inputs.len()];
        later[0] = slope.clone();
        for k in 0..count {
            let inputs = if k == 0 { &self.inputs } else { &later };
            if let [u, m] = self.series.next(inputs) {
                potential.push(u.clone());
                mass.push(m.clone());
            }
            if k == 1 {
                later[0] = self.zero.clone();
            }
        }
        (potential, mass)
    }

    /// The Taylor coefficients of E - U along at + slope·s, and those of M.
    fn excess(&mut self, at: &S, slope: &S, count: usize) -> (Vec<S>, Vec<S>) {
        let (mut excess, mass) = self.expand(at, slope, count);
        for (k, value) in excess.iter_mut().enumerate() {
            *value = if k == 0 { self.energy.sub(value) } else { value.neg() };
        }
        (excess, mass)
    }

    /// E - U at a position and its slope along the coordinate.
    pub(super) fn excess_and_slope(&mut self, at: &S) -> (S, S) {
        let one = self.number(1.0);
        let (excess, _) = self.excess(at, &one, 2);
        let mut values = excess.into_iter();
        let mut next = || values.next().unwrap_or_else(|| self.zero.clone());
        (next(), next())
    }

    /// The coefficients of g = sqrt(2M/h).
    fn integrand(&mut self, h: &[S], mass: &[S]) -> Vec<S> {
        self.shape.clear();
        let both = h.iter().zip(mass);
        both.filter_map(|(h, m)| self.shape.next(&[h.clone(), m.clone()]).first().cloned()).collect()
    }
}

/// The positions that are integrated over, and how well.
pub(super) struct Path<'a, S: Enclosure> {
    pub(super) field: &'a mut Field<S>,
    pub(super) start: S,
    /// The last position less the first.
    pub(super) span: S,
    /// Whether E - U is exactly 0 at the start.
    pub(super) turning: bool,
    /// Terms of an expansion.
    pub(super) order: usize,
    /// The rest that a panel may have, relative to its own time: 2 to the minus this.
    pub(super) bits: u32,
}

/// A panel that is not taken.
struct Refused {
    refusal: Refusal,
    /// By how many bits its rest is too large, where that is known.
    bits: Option<f64>,
}

impl From<Refusal> for Refused {
    fn from(refusal: Refusal) -> Self {
        Self { refusal, bits: None }
    }
}

/// A panel that is taken.
struct Taken<S> {
    /// Its part of the time, less |span|.
    time: S,
    known: Known<S>,
    /// By how many bits its rest is smaller than it may be.
    bits: f64,
}

/// log2(a/b), about; infinite where b is 0.
fn bits_between(a: Magnitude, b: Magnitude) -> f64 {
    if b.is_zero() {
        f64::INFINITY
    } else if a.is_zero() {
        f64::NEG_INFINITY
    } else {
        a.log2() - b.log2()
    }
}

/// E - U about a place where it is well known.
struct Known<S> {
    middle: f64,
    half: f64,
    coefficients: Vec<S>,
}

/// c with |f_j(X) - f_j| <= c_j for the Taylor coefficients f_j at all places X of the panel |s| <= 1, from those in
/// its middle and a bound of the n-th, n = `middle.len()`, over the panel.
///
/// f_j(X) = Σ_(k=j..n-1) C(k,j) f_k X^(k-j) + C(n,j) f_n(Y) X^(n-j) with Y between 0 and X: Taylor's formula for f^(j)/j!.
/// The sums of binomials are those of Horner's shift by 1 of Σ |f_k| s^k, less each own coefficient.
fn spreads<S: Enclosure>(middle: &[S], top: Magnitude) -> Vec<Magnitude> {
    let mut sizes: Vec<Magnitude> = middle.iter().map(Enclosure::abs_upper_magnitude).collect();
    sizes.push(top);
    let last = middle.len();
    let mut spread = vec![Magnitude::ZERO; sizes.len()];
    if sizes.iter().skip(1).all(|size| size.is_zero()) {
        spread.truncate(last);
        return spread;
    }
    for from in 0..last {
        for k in (from..last).rev() {
            spread[k] = spread[k] + (sizes[k + 1] + spread[k + 1]);
        }
    }
    spread.truncate(last);
    spread
}

/// The coefficients at any place of the panel: those of the middle with their spreads, then the top one.
fn over_panel<S: Enclosure>(middle: &[S], top: &S) -> Vec<S> {
    let own = middle.iter().zip(spreads(middle, top.abs_upper_magnitude()));
    own.map(|(value, spread)| value.with_added_magnitude(spread)).chain(std::iter::once(top.clone())).collect()
}

impl<S: Enclosure> Path<'_, S> {
    /// |∫ sqrt(2M/(E - U)) dq| over the path.
    pub(super) fn time(&mut self) -> Result<S, Obstacle<S>> {
        if self.turning {
            // E - U rises from the turning point, or there is none.
            let rise = self.field.excess_and_slope(&self.start).1.mul(&self.span);
            if !rise.is_positive() {
                let refusal = if rise.is_negative() { Refusal::Forbidden } else { Refusal::Precision };
                return Err(Obstacle { refusal, at: self.start.clone() });
            }
        }
        let mut sum: Option<S> = None;
        let mut known: Option<Known<S>> = None;
        let (mut from, mut width, mut trend) = (0.0, 1.0, 1.0);
        let mut before = Refusal::Rough;
        let terms = self.order as f64;
        for _ in 0..MOST_PANELS {
            let to = self.end(from, width);
            let middle = 0.5 * (from + to);
            // Middles and half widths have to be exact, so that nothing is left out.
            let exact = from < middle && middle < to && middle - from == to - middle && 2.0 * middle - to == from;
            if !exact {
                return Err(Obstacle { refusal: before, at: self.position(from) });
            }
            match self.panel(from, to, known.as_ref()) {
                Ok(taken) => {
                    let total = sum.map_or_else(|| taken.time.clone(), |total| total.add(&taken.time));
                    if to >= 1.0 {
                        let total = total.mul(&self.span);
                        return Ok(if total.is_negative() { total.neg() } else { total });
                    }
                    // Where panels have grown they go on growing: mostly it is the distance from a singularity that counts.
                    let room = ((taken.bits / terms - MARGIN) / BITS_A_HALVING).exp2();
                    let factor = (room * trend).clamp(0.25, 4.0);
                    trend = factor.clamp(0.7, 1.5);
                    width = (to - from) * factor;
                    sum = Some(total);
                    known = Some(taken.known);
                    from = to;
                }
                Err(Refused { refusal, bits }) => {
                    let whole = refusal == Refusal::Forbidden || refusal == Refusal::NegativeMass;
                    let shorter = bits.map_or(0.5, |bits| (-(bits / terms + MARGIN) / BITS_A_HALVING).exp2());
                    let next = (to - from) * shorter.clamp(0.0625, 0.8);
                    if whole || next < LEAST || next < 4.0 * f64::EPSILON * from {
                        return Err(Obstacle { refusal, at: self.position(middle) });
                    }
                    (width, trend, before) = (next, 1.0, refusal);
                }
            }
        }
        Err(Obstacle { refusal: Refusal::Long, at: self.position(from) })
    }

    /// The end of a panel of about a width, on a grid so coarse that sums and differences of ends are exact.
    fn end(&self, from: f64, width: f64) -> f64 {
        // Weights are computed for panels that are as far from the turning point as they are wide.
        let width = if self.turning && from > 0.0 { width.min(from) } else { width };
        let finest = power_of_two(exponent_of(from.max(width)) - 51);
        let grid = power_of_two(exponent_of(width) - 6).max(finest);
        let to = ((from + width) / grid).floor() * grid;
        // A panel that was refused does not get its old end again.
        if to + 0.125 * width >= 1.0 && (from == 0.0 || !self.turning || from >= 0.5) { 1.0 } else { to }
    }

    fn position(&self, x: f64) -> S {
        self.start.add(&self.span.mul(&self.field.number(x)))
    }

    /// The part of one panel.
    fn panel(&mut self, from: f64, to: f64, known: Option<&Known<S>>) -> Result<Taken<S>, Refused> {
        let (order, zeros) = (self.order, usize::from(self.turning));
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let step = self.span.mul(&self.field.number(half));
        let at = self.position(middle);
        let (mut excess, mass) = self.field.excess(&at, &step, order);
        let wanted = Magnitude::power_of_two(-i64::from(self.bits));
        let doubtful = |value: &S| value.radius_magnitude() > wanted * value.abs_lower_magnitude();
        let mut enclosed = None;
        // Carried from the panel before, all between has to be enclosed.
        let near = known.map_or(from, |known| known.middle.min(from));
        let near = if self.turning { 0.0 } else { near };
        if doubtful(&excess[0])
            && let Ok(over) = self.beside(near, to, &step, zeros)
        {
            let better = self.carried(middle, half, known, &over.0[order]);
            if better.radius_magnitude() < excess[0].radius_magnitude() || !excess[0].is_finite() {
                excess[0] = better;
            }
            enclosed = Some(over);
        }
        if excess[0].is_negative() {
            return Err(Refusal::Forbidden.into());
        }
        if mass[0].is_negative() {
            return Err(Refusal::NegativeMass.into());
        }
        if !excess.iter().chain(&mass).all(Scalar::is_finite) {
            return Err(Refusal::Rough.into());
        }
        if doubtful(&excess[0]) {
            return Err(Refusal::Precision.into());
        }
        let r = self.field.number(half);
        let h = match self.turning {
            true => divided(&excess, &self.field.number(middle), &r),
            false => excess.clone(),
        };
        let g = self.field.integrand(&h, &mass);
        let Some(first) = g.first().filter(|first| first.is_positive()) else { return Err(Refusal::Rough.into()) };
        // A rest is hardly smaller than the last terms: no need to enclose what is refused anyway.
        let last = g.iter().rev().take(2).map(Enclosure::abs_upper_magnitude);
        let last = last.fold(Magnitude::ZERO, Magnitude::max);
        if last > wanted.scale(2) * first.abs_upper_magnitude() {
            return Err(Refused {
                refusal: Refusal::Rough,
                bits: Some(bits_between(last, wanted * first.abs_upper_magnitude()) + BITS_OF_A_REST * order as f64),
            });
        }
        let number = |value: f64| self.field.number(value);
        let weights = match self.turning {
            true => of_root(from, to, order, self.bits, &number),
            false => of_one(&number(to - from), order, &number),
        };
        let zero = self.field.zero.clone();
        let time = g.iter().zip(&weights).fold(zero, |time, (value, weight)| time.add(&value.mul(weight)));
        // |∫ g_n(Y) s^n w dx| <= max |g_n| J_0.
        let whole = weights.first().map_or(Magnitude::INFINITE, Enclosure::abs_upper_magnitude);
        let first = if self.turning { 0.0 } else { from };
        let enclosed = enclosed.or_else(|| self.beside(first, to, &step, zeros).ok());
        let mut rest = enclosed.map_or(Magnitude::INFINITE, |over| {
            // h_k(X) is a mean of the (k+1)-th coefficients of D = E - U between 0 and X: h(x) = ∫ D'(t x) dt over
            // 0 < t < 1, so h^(k)(x)/k! = ∫ t^k D^(k+1)(t x)/k! dt, and (k + 1) ∫ t^k dt = 1.
            let top = &over.0[order + zeros];
            let top = if self.turning { top.div(&r) } else { top.clone() };
            self.top(&h, &top, &mass, &over.1[order]) * whole
        });
        let enough = |rest: Magnitude| rest <= wanted * time.abs_lower_magnitude();
        if !enough(rest) && self.turning && from > 0.0 {
            // All the way from the turning point may be too far for an enclosure.
            let over = self.beside(from, to, &step, 0)?;
            let excess = over_panel(&excess, &over.0[order]);
            let x = self.field.number(from).hull(&self.field.number(to));
            let top = divided(&excess, &x, &r).pop().unwrap_or_else(|| self.field.zero.clone());
            rest = self.top(&h, &top, &mass, &over.1[order]) * whole;
        }
        let bits = bits_between(rest, wanted * time.abs_lower_magnitude());
        if !enough(rest) {
            return Err(Refused { refusal: Refusal::Rough, bits: bits.is_finite().then_some(bits) });
        }
        let known = Known { middle, half, coefficients: excess };
        Ok(Taken { time: time.with_added_magnitude(rest), known, bits: -bits })
    }

    /// A bound of the n-th coefficient of g over the panel, from the first coefficients of h and M in its middle and
    /// enclosures of their n-th ones.
    fn top(&mut self, h: &[S], top_h: &S, mass: &[S], top_mass: &S) -> Magnitude {
        let h = over_panel(h, top_h);
        let mass = over_panel(mass, top_mass);
        let top = self.field.integrand(&h, &mass).pop().filter(S::is_finite);
        top.map_or(Magnitude::INFINITE, |top| top.abs_upper_magnitude())
    }

    /// Enclosures of the coefficients of E - U and M between two places, the order-th and `more` beyond it being the last.
    fn beside(&mut self, from: f64, to: f64, step: &S, more: usize) -> Result<(Vec<S>, Vec<S>), Refusal> {
        let all = self.position(from).hull(&self.position(to));
        let count = self.order + more + 1;
        let both = self.field.excess(&all, step, count);
        let last = |values: &[S]| values.iter().rev().take(more + 1).all(Scalar::is_finite);
        if both.0.len() == count && last(&both.0) && last(&both.1) { Ok(both) } else { Err(Refusal::Rough) }
    }

    /// E - U in the middle of a panel from its expansion about the panel before, or about the turning point, where it
    /// is 0: near a barrier it is small beside E and U. `top` encloses its n-th coefficient from there to here.
    fn carried(&mut self, middle: f64, half: f64, known: Option<&Known<S>>, top: &S) -> S {
        let own;
        let known = match known {
            Some(known) => known,
            None if self.turning => {
                let step = self.span.mul(&self.field.number(half));
                let start = self.start.clone();
                let (mut coefficients, _) = self.field.excess(&start, &step, self.order);
                coefficients[0] = self.field.zero.clone();
                let middle = 0.0;
                own = Known { middle, half, coefficients };
                &own
            }
            None => return self.field.zero.div(&self.field.zero),
        };
        // Middles and half widths are whole multiples of powers of 2; the quotients are rounded as enclosures.
        let way = self.field.number(middle).sub(&self.field.number(known.middle));
        let sum = horner(&known.coefficients, &way.div(&self.field.number(known.half)));
        let steps = way.div(&self.field.number(half)).abs_upper_magnitude();
        let power = u32::try_from(self.order).unwrap_or(u32::MAX);
        sum.with_added_magnitude(top.abs_upper_magnitude() * steps.powi(power))
    }
}

/// The nearest whole number of terms for a relative rest of 2^-bits: each term gains about two bits on panels as wide
/// as half their distance from the next singularity.
pub(super) fn order_for(bits: u32) -> usize {
    (bits as usize * 9 / 20).max(16)
}
