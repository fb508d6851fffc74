//! Turning points: where E - U changes its sign.

use super::panel::Field;
use librate_core::precision::Enclosure;

/// Steps outward; with steps that grow by a quarter each they reach 1e150 times the first.
const MOST_STEPS: usize = 1600;

/// Beyond this distance nothing is searched for.
const FAR: f64 = 1e150;

/// Halvings and Newton steps in a bracket.
const MOST_NARROWINGS: usize = 400;

/// What lies outward from a place where E - U is positive.
pub(super) enum Outward<S> {
    /// E - U is positive at the first place and negative at the second.
    Bracket(S, S),
    /// The energies have no value beyond about here.
    End(f64),
    /// A top of U that numbers of this precision do not tell from E.
    Touch(S),
    /// No place was met where E - U is negative.
    Open,
}

impl<S: Enclosure> Field<S> {
    /// E - U.
    pub(super) fn excess_at(&mut self, at: &S) -> S {
        let potential = self.potential(at);
        self.energy.sub(&potential)
    }

    /// Goes outward from `from` in steps that grow, up to `reach` (a length). Finds no more than what steps meet and what
    /// tops between them show; what they miss is found by the integral, which proves that E - U is positive all the way.
    pub(super) fn outward(&mut self, from: &S, step: f64, reach: Option<f64>) -> Outward<S> {
        let from = from.center();
        // The last two places and E - U there.
        let mut before = (from.clone(), f64::INFINITY);
        let mut inside = (from.clone(), self.excess_at(&from).mid_f64());
        let mut offset = 0.0_f64;
        let mut step = step;
        for count in 0..MOST_STEPS {
            if reach.is_some_and(|reach| offset.abs() >= reach) || offset.abs() > FAR {
                return Outward::Open;
            }
            let mut next = offset + step;
            if let Some(reach) = reach
                && next.abs() > reach
            {
                next = reach.copysign(next);
            }
            let at = from.add(&self.number(next)).center();
            let excess = self.excess_at(&at);
            // A step over a pole, or over what has no value, shows in an enclosure of all between.
            let between = inside.0.hull(&at);
            if !excess.is_finite() || !self.excess_at(&between).is_finite() {
                step *= 0.5;
                if step.abs() <= 1e-20 * offset.abs() || step.abs() < 1e-200 {
                    return Outward::End(inside.0.mid_f64());
                }
                continue;
            }
            if excess.is_negative() {
                return Outward::Bracket(inside.0, at);
            }
            let now = excess.mid_f64();
            if now > inside.1 && inside.1 < before.1 {
                // A top of U between the last places: it may be a barrier.
                let reach = at.sub(&before.0).mid_f64().abs();
                if let Some((summit, height)) = self.summit(&inside.0, reach) {
                    let least = self.energy.sub(&height);
                    if least.is_negative() {
                        return Outward::Bracket(before.0, summit);
                    }
                    if !least.is_positive() {
                        return Outward::Touch(summit);
                    }
                }
            }
            before = std::mem::replace(&mut inside, (at, now));
            offset = next;
            if count >= 8 {
                step *= 1.25;
            }
        }
        Outward::Open
    }

    /// An enclosure of a zero of E - U between two places of different sign; `None` where numbers of this precision do
    /// not tell.
    pub(super) fn turning_point(&mut self, inside: &S, outside: &S) -> Option<S> {
        let (mut inside, mut outside) = (inside.center(), outside.center());
        let half = self.number(0.5);
        let mut at = inside.add(&outside).mul(&half).center();
        let mut width = f64::INFINITY;
        for step in 0..MOST_NARROWINGS {
            let (excess, slope) = self.excess_and_slope(&at);
            if excess.is_positive() {
                inside = at.clone();
            } else if excess.is_negative() {
                outside = at.clone();
            } else if excess.is_finite() {
                break;
            } else {
                return None;
            }
            let newton = at.sub(&excess.center().div(&slope.center())).center();
            let between = newton.is_finite() && newton.sub(&inside).mul(&newton.sub(&outside)).is_negative();
            let now = outside.sub(&inside).mid_f64().abs();
            let moved = newton.sub(&at).mid_f64().abs();
            // Newton from one side leaves the other end where it is: every third step halves unless it has converged.
            let stalls = step % 3 == 2 && now > 0.5 * width && moved > 1e-6 * now;
            if step % 3 == 2 {
                width = now;
            }
            let next = if between && !stalls { newton } else { inside.add(&outside).mul(&half).center() };
            if next.sub(&at).is_exact_zero() {
                break;
            }
            at = next;
        }
        self.proved(&at)
    }

    /// Newton's operator on an interval about `at`: where N(X) = at - D(at)/D'(X) lies in X, there is exactly one zero
    /// in X, and it is in N(X) (R. E. Moore, Methods and Applications of Interval Analysis (1979), chapter 5).
    fn proved(&mut self, at: &S) -> Option<S> {
        let (excess, slope) = self.excess_and_slope(at);
        let mut radius = excess.div(&slope).abs_upper_magnitude().scale(2);
        for _ in 0..8 {
            let slopes = self.excess_and_slope(&at.with_added_magnitude(radius)).1;
            let step = excess.div(&slopes);
            if !step.is_finite() {
                return None;
            }
            if step.abs_upper_magnitude() <= radius {
                return Some(at.sub(&step));
            }
            radius = step.abs_upper_magnitude().scale(1);
        }
        None
    }
}
