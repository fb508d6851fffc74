//! Barriers: maxima of U on the way.

use super::Oscillator;
use super::panel::Field;
use librate_core::precision::Enclosure;

/// Newton steps to a summit.
const MOST_STEPS: usize = 200;

/// Places that a summit is searched for at, between two positions.
const PLACES: i32 = 400;

/// U at the top of a barrier.
pub(super) struct Height<S> {
    pub(super) at: S,
    /// Whether it is at a stationary point; else at the highest place that was met: it may rise without end.
    pub(super) is_top: bool,
}

impl<S: Enclosure> Height<S> {
    /// How far it is above another potential.
    pub(super) fn words(&self, bottom: &S, oscillator: &Oscillator) -> String {
        let height = oscillator.height(self.at.sub(bottom).mid_f64());
        if self.is_top { height } else { format!("more than {height}") }
    }
}

impl<S: Enclosure> Field<S> {
    /// A stationary point of U that Newton's method leads to from `near` in steps that end, within `reach`, and U there.
    /// Nothing is proved about it but U at the very point.
    pub(super) fn summit(&mut self, near: &S, reach: f64) -> Option<(S, S)> {
        let one = self.number(1.0);
        let mut at = near.center();
        let mut before = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let (potential, _) = self.expand(&at, &one, 3);
            let [_, slope, half] = potential.as_slice() else { return None };
            let step = slope.center().div(&half.center().add(&half.center()));
            let length = step.mid_f64().abs();
            if !step.is_finite() {
                return None;
            }
            // Where the force is nothing but rounding, or steps do not get shorter any more, this is as near as numbers
            // get.
            let settled = !(slope.is_positive() || slope.is_negative());
            if settled || length == 0.0 || (length >= 0.5 * before && length < 1e-20 * reach) {
                let height = self.potential(&at);
                return height.is_finite().then_some((at, height));
            }
            before = length;
            at = at.sub(&step).center();
            if at.sub(near).mid_f64().abs() > reach {
                return None;
            }
        }
        None
    }

    /// The highest place between two positions, about, and U there.
    pub(super) fn highest(&mut self, from: &S, to: &S) -> Option<(S, Height<S>)> {
        let way = to.sub(from);
        let mut best: Option<(S, S)> = None;
        for place in 1..PLACES {
            let share = self.number(f64::from(place) / f64::from(PLACES));
            let at = from.add(&way.mul(&share)).center();
            let height = self.potential(&at);
            let is_above = |(_, other): &(_, S)| height.sub(other).is_positive();
            let higher = best.as_ref().map_or_else(|| height.is_finite(), is_above);
            if higher {
                best = Some((at, height));
            }
        }
        let (at, height) = best?;
        let reach = way.mid_f64().abs() / f64::from(PLACES) * 2.0;
        match self.summit(&at, reach) {
            Some((summit, at)) if !height.sub(&at).is_positive() => Some((summit, Height { at, is_top: true })),
            Some(_) | None => Some((at, Height { at: height, is_top: false })),
        }
    }
}
