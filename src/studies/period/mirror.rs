//! The zero of E - U on the other side of a barrier that a motion turns close to.

use super::panel::Path;
use crate::flow::horner;
use librate_core::precision::{Enclosure, Magnitude};

/// Zeros further away than this part of the path are left: panels feel them little.
const FARTHEST: f64 = 0.25;

/// Where it is searched for reaches beyond the place that a parabola has it at by this factor.
const REACH: f64 = 1.25;

/// Newton steps.
const MOST_STEPS: usize = 12;

impl<S: Enclosure> Path<'_, S> {
    /// b > 0 with E - U = 0 at x = -b, where there is exactly one such place close beyond the turning point x = 0, at which the path
    /// starts.
    ///
    /// With D = E - U and t = -x/b0, b0 the zero of the parabola, p(t) = D/t = Σ D_k t^(k-1) up to order n with D_n taken
    /// between 0 and `REACH`: D is exactly 0 at the turning point, so that p is known as well as the slope there. Newton's
    /// operator proves the zero (R. E. Moore, Methods and Applications of Interval Analysis (1979), chapter 5), with
    /// p' = ∫ s D''(s t) ds, a mean of D''/2.
    pub(super) fn mirror(&mut self) -> Option<S> {
        let (start, span) = (self.start.clone(), self.span.clone());
        let (slopes, _) = self.field.excess(&start, &span, 3);
        let [_, slope, bend] = slopes.as_slice() else { return None };
        if !(slope.is_positive() && bend.is_positive()) {
            return None;
        }
        let guess = slope.div(bend).mid_f64();
        if !(guess > 0.0 && guess < FARTHEST) {
            return None;
        }
        let order = self.order;
        let step = span.mul(&self.field.number(-guess));
        let (mut terms, _) = self.field.excess(&start, &step, order);
        let end = start.add(&step.mul(&self.field.number(REACH)));
        let (over, _) = self.field.excess(&start.hull(&end), &step, order + 1);
        let (top, bends) = (over.get(order)?.clone(), over.get(2)?.clone());
        terms.push(top);
        terms.remove(0);
        let value = |t: &S| horner(&terms, t);
        let mut at = self.field.number(1.0);
        let mut length = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let step = value(&at).center().div(&bends.center());
            let now = step.mid_f64().abs();
            if now.is_nan() || now >= length {
                break;
            }
            length = now;
            at = at.sub(&step).center();
        }
        let found = at.sub(&value(&at).div(&bends));
        let reach = self.field.number(REACH);
        if !(found.is_positive() && reach.sub(&found).is_positive()) {
            return None;
        }
        // What is known too roughly helps nobody.
        let sharp =
            found.radius_magnitude() <= Magnitude::power_of_two(-i64::from(self.bits)) * found.abs_lower_magnitude();
        sharp.then(|| found.mul(&self.field.number(guess)))
    }
}
