//! Passing the top of a barrier with little energy to spare: the time near it.
//!
//! About a top D = E - U is small and all but a parabola: D = q h with q = x² + c, whose zeros ±i sqrt(c) are so near that
//! expansions of 1/sqrt(D) are worth nothing. They are taken out. For the Taylor polynomial of D of degree n - 1 about a
//! place p, division by q gives D = q h + r0 + r1 x + D_n(ξ) x^n with a polynomial h. p and c are chosen so that r0 and r1
//! are next to nothing; that need not be proved, for what they and the rest of Taylor's formula come to is bounded. With
//! |x| <= 1 in units of the half width,
//!
//! |D/q - h| <= e = |r0|/c + |r1|/(2 sqrt(c)) + |D_n|, and |(1 + t)^(-1/2) - 1| <= |t| for |t| <= 1/2,
//!
//! so that the time is ∫ sqrt(2M/h) w dx to within the factor 1 ± e/min h, w = 1/sqrt(q), and sqrt(2M/h) is smooth: it is
//! expanded, and the moments of w are known.

use super::panel::{Field, over_panel};
use librate_core::precision::{Enclosure, Function, Magnitude};

/// Places along a path at which a top is searched for.
const PLACES: u32 = 16;

/// Tops with c below this part of the squared length of the path are worth it.
const NEAR: f64 = 1.0 / 64.0;

/// Steps to the real part of the zeros.
const MOST_STEPS: usize = 24;

/// Half widths that are tried.
const MOST_TRIALS: usize = 8;

/// The time near a top, and where.
pub(super) struct Pass<S> {
    /// The place p.
    pub(super) place: S,
    /// The half width, in units of the path's span.
    pub(super) half: f64,
    /// The time from one end to the other.
    pub(super) time: S,
}

impl<S: Enclosure> Field<S> {
    /// The time about the lowest place of E - U inside a path, where it is low.
    pub(super) fn pass(&mut self, start: &S, span: &S, order: usize, bits: u32) -> Option<Pass<S>> {
        let near = self.lowest_inside(start, span)?;
        let (place, square) = self.zeros(near, span, order)?;
        let x = place.sub(start).div(span).mid_f64();
        let room = x.min(1.0 - x);
        let size = square.mid_f64();
        if !(size > 0.0 && size < NEAR && room > 2.0 * size.sqrt()) {
            return None;
        }
        let mut half = 0.5 * room;
        for _ in 0..MOST_TRIALS {
            if let Some(time) = self.time_about(&place, span, (half, &square), order, bits) {
                return Some(Pass { place, half, time });
            }
            half *= 0.625;
        }
        None
    }

    /// A place at which E - U is lower than at both neighbours, the lowest one.
    fn lowest_inside(&mut self, start: &S, span: &S) -> Option<S> {
        let mut places = Vec::with_capacity(PLACES as usize + 1);
        for place in 0..=PLACES {
            let share = self.number(f64::from(place) / f64::from(PLACES));
            let at = start.add(&span.mul(&share)).center();
            let excess = self.excess_at(&at).mid_f64();
            places.push((at, excess));
        }
        let inside = places.windows(3).filter_map(|three| match three {
            [before, own, after] if own.1 <= before.1 && own.1 <= after.1 => Some(own),
            _ => None,
        });
        let lowest = inside.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let highest = places.iter().map(|own| own.1).fold(0.0, f64::max);
        (lowest.1 < NEAR * 8.0 * highest).then(|| lowest.0.clone())
    }

    /// p and c with D(p ± i sqrt(c) span) = 0, about: the odd part of the expansion about p vanishes at x² = -c, and so does
    /// the even one.
    fn zeros(&mut self, near: S, span: &S, order: usize) -> Option<(S, S)> {
        let reach = span.mid_f64().abs() / f64::from(PLACES) * 2.0;
        let (mut place, _) = self.summit(&near, reach)?;
        let mut square = self.number(0.0);
        let mut before = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let (terms, _) = self.excess(&place, span, order);
            let bend = terms.get(2)?.center();
            if !bend.is_positive() {
                return None;
            }
            // c for this place, then how far the place is off.
            let mut last = f64::INFINITY;
            for _ in 0..MOST_STEPS {
                let step = part(&terms, 0, &square)?.div(&bend).center();
                let length = step.mid_f64().abs();
                if length >= last {
                    break;
                }
                last = length;
                square = square.add(&step).center();
            }
            let step = part(&terms, 1, &square)?.div(&bend.add(&bend));
            let length = step.mid_f64().abs();
            if length >= before {
                break;
            }
            before = length;
            place = place.sub(&step.mul(span)).center();
        }
        Some((place, square))
    }

    /// The time from p - half span to p + half span; `None` where its rest is too large.
    fn time_about(&mut self, place: &S, span: &S, (half, square): (f64, &S), order: usize, bits: u32) -> Option<S> {
        let count = order + 2;
        let width = self.number(half);
        let step = span.mul(&width);
        let (excess, mass) = self.excess(place, &step, count);
        let all = place.with_added_magnitude(step.abs_upper_magnitude());
        let (over, masses) = self.excess(&all, &step, count + 1);
        let c = square.div(&width.mul(&width));
        // From the top down: D_k = h_(k-2) + c h_k.
        let mut h = vec![self.number(0.0); count];
        for k in (2..count).rev() {
            h[k - 2] = excess.get(k)?.sub(&c.mul(&h[k]));
        }
        h.truncate(order);
        let r0 = excess.first()?.sub(&c.mul(&h[0]));
        let r1 = excess.get(1)?.sub(&c.mul(h.get(1)?));
        let root = c.sqrt();
        let two = self.number(2.0);
        let left = r0.div(&c).abs_upper_magnitude() + r1.div(&root.mul(&two)).abs_upper_magnitude();
        let left = left + over.get(count)?.abs_upper_magnitude();

        let zero = self.number(0.0);
        let h_over = over_panel(&h, &zero);
        let mass_over = over_panel(mass.get(..order)?, masses.get(order)?);
        let least = h_over.first().filter(|least| least.is_positive())?.abs_lower_magnitude();
        let g = self.integrand(&h, mass.get(..order)?);
        let top = self.integrand(&h_over, &mass_over).pop()?;
        if g.len() < order || !top.is_finite() || !mass_over.first()?.is_positive() {
            return None;
        }
        // J_k = ∫ s^k/sqrt(s² + c) ds = (2 sqrt(1 + c) - (k - 1) c J_(k-2))/k, and 0 for odd k; J_0 = 2 arsinh(1/sqrt(c)).
        let one = self.number(1.0);
        let inverse = one.div(&root);
        let ends = c.add(&one).sqrt();
        let first = inverse.add(&inverse.mul(&inverse).add(&one).sqrt()).apply(Function::Ln).mul(&two);
        let whole = first.abs_upper_magnitude();
        let (mut moment, mut sum) = (first, zero);
        for (k, value) in g.iter().enumerate().step_by(2) {
            if k > 0 {
                let less = self.number((k - 1) as f64).mul(&c).mul(&moment);
                moment = two.mul(&ends).sub(&less).div(&self.number(k as f64));
            }
            sum = sum.add(&value.mul(&moment));
        }
        // The rest of sqrt(2M/h), then what is left of D.
        let share = left / least;
        if !share.is_finite() || share > Magnitude::power_of_two(-1) {
            return None;
        }
        let rest = top.abs_upper_magnitude() * whole;
        let time = sum.with_added_magnitude(rest);
        let rest = rest + share * time.abs_upper_magnitude();
        let wanted = Magnitude::power_of_two(-i64::from(bits));
        if rest > wanted * sum.abs_lower_magnitude() {
            return None;
        }
        let time = sum.with_added_magnitude(rest).mul(&step);
        Some(if time.is_negative() { time.neg() } else { time })
    }
}

/// Σ (-c)^j D_(2j + from), about.
fn part<S: Enclosure>(terms: &[S], from: usize, square: &S) -> Option<S> {
    let terms = terms.get(from..)?.iter().step_by(2).rev().map(S::center);
    terms.reduce(|sum, term| term.sub(&sum.mul(square)).center()).filter(S::is_finite)
}
