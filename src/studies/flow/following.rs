//! A solution followed for a long time, enclosed.
//!
//! What is known of the solution at a time is a set about a centre ([`Set`]). A step takes the centre along by its Taylor
//! series, in numbers of as many bits as are wanted, and the rest by T, the derivative by the initial point: for a convex X
//! with c in it, x(t + h; X) lies in x(t + h; c) + T(X) (X - c) (the theorem of the mean, component by component). What is small needs few digits: T, the box that
//! the solution stays in and Lagrange's remainders are double-double for any precision of the centre.

use super::bounds::{finite, near_unit, norm, onwards};
use super::expansion::{expanded, expanded_slopes};
use super::plain::weights;
use super::set::Set;
use super::{Equations, count, horner, nearest_power_of_two};
use librate_core::expr::{Prepared, Series};
use librate_core::precision::{Ball, Enclosure, Matrix, Scalar, power_of_two, up};

/// A remainder is allowed so many roundings of the component that it belongs to ...
const REMAINDER: f64 = 4.0;
/// ... or of one this much smaller than the largest.
const SMALL: f64 = power_of_two(-10);
/// What is so much smaller than where a motion starts (than 1, where all is 0) is as good as none: what decays is not followed
/// beyond it, nor a force that is yet to come.
const NOTHING: f64 = 1e-200;
/// Many such remainders together are next to nothing.
const NEXT_TO: f64 = 1e50;
/// What the remainder of T may be beside 1.
const SLOPE: f64 = 1e-7;
/// How much further than a step its polynomials hold.
const BEYOND: f64 = 1.0 + power_of_two(-20);
/// Attempts at one step.
const ATTEMPTS: usize = 60;
/// Attempts at a box that holds the solution.
const BOXES: usize = 10;
/// Times are multiples of this much of the whole way, so that they add up exactly.
const GRID: i32 = -48;

/// A solution with what is known of it, at a time that goes on.
#[derive(Clone, Debug)]
pub struct Following<S: Enclosure> {
    dimension: usize,
    precision: S::Precision,
    order: usize,
    slope_order: usize,
    point: Series<S>,
    values: Prepared<Ball>,
    rates: Prepared<Ball>,
    coarse: Series<Ball>,
    slopes: Series<Ball>,
    scratch: Vec<Ball>,
    time: f64,
    grid: f64,
    center: Vec<S>,
    set: Set,
    /// Remainders below this are left in.
    nothing: f64,
    /// The length that is tried next.
    next: f64,
    stretch: Option<Stretch<S>>,
}

/// Polynomials for the way from a time on, in units of time.
#[derive(Clone, Debug)]
struct Stretch<S> {
    unit: f64,
    length: f64,
    /// The coefficients of each component, the last one that of the remainder.
    path: Vec<Vec<S>>,
    /// Those of each entry of T.
    slopes: Vec<Vec<Ball>>,
    /// Scales for what comes next.
    weights: Vec<f64>,
}

impl<S: Enclosure> Following<S> {
    /// From a start at t = 0 on to some time of the size of `until`, by steps of Taylor's method of the given order. Equations with
    /// open parameters, and those of T alone, lead nowhere.
    #[must_use]
    pub fn new(equations: &Equations, order: usize, precision: S::Precision, start: &[S], until: f64) -> Self {
        let values = equations.tape.prepare::<Ball>(());
        let rates = equations.rates.prepare::<Ball>(());
        let order = order.max(4);
        let largest = start.iter().map(S::abs_upper).fold(0.0, f64::max);
        let largest = if largest > 0.0 { largest } else { 1.0 };
        Self {
            dimension: equations.dimension,
            precision,
            order,
            slope_order: (order / 4 + 3).min(20),
            point: equations.rates.prepare::<S>(precision).series(),
            coarse: rates.series(),
            slopes: values.series(),
            values,
            rates,
            scratch: Vec::new(),
            time: 0.0,
            grid: nearest_power_of_two(until) * power_of_two(GRID),
            center: start.iter().map(S::center).collect(),
            set: Set::new(start.iter().map(S::radius).collect()),
            nothing: (NOTHING * largest).max(f64::MIN_POSITIVE),
            next: f64::INFINITY,
            stretch: None,
        }
    }

    /// The time that was reached, exactly.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The state at that time.
    #[must_use]
    pub fn state(&self) -> Vec<S> {
        let spread = self.set.spread();
        self.center.iter().zip(&spread).map(|(x, r)| x.with_added_radius(*r)).collect()
    }

    /// How large the set is beside where it is, both on the scales of the components; 0 where all of it is next to nothing.
    pub(crate) fn spread(&self) -> f64 {
        let weights = self.set.weights();
        let most = |sizes: &mut dyn Iterator<Item = f64>| sizes.zip(weights).map(|(x, w)| x / w).fold(0.0, f64::max);
        let place = most(&mut self.center.iter().map(|x| x.mid_f64().abs()));
        let spread = self.set.spread();
        let size = most(&mut spread.iter().copied());
        if spread.iter().all(|own| *own <= NEXT_TO * self.nothing) { 0.0 } else { size / place }
    }

    /// Finds a step, of about the length asked for or a shorter one; tells how far [`Following::at`] reaches. `None` where none was
    /// found: beside a singularity, or from a set that is too large.
    pub fn reach(&mut self, longest: f64) -> Option<f64> {
        self.stretch = None;
        let time = Ball::exact(self.time);
        let start: Vec<Ball> = self.state().iter().map(S::to_ball).collect();
        let here = finite(&self.values, &[&[time], start.as_slice()].concat(), &mut self.scratch)?;
        let (rates, jacobian) = here.split_at_checked(self.dimension)?;
        let mut length = self.next;
        if !length.is_finite() {
            let rate = norm(jacobian, &scales(self.dimension, jacobian));
            length = if rate > 0.0 { 1.0 / rate } else { longest };
        }
        length = length.min(longest);
        for _ in 0..ATTEMPTS {
            // Up, so that the last one reaches the end.
            let steps = (length / self.grid).ceil();
            let rounded = steps * self.grid;
            if !(rounded.is_finite() && (16.0..1.0 / f64::EPSILON).contains(&steps)) {
                return None;
            }
            let Some((excess, stretch)) = self.attempt(&start, rates, rounded) else {
                length *= 0.5;
                continue;
            };
            if excess <= 1.0 {
                self.next = rounded * (0.9 / excess.powf(1.0 / count(self.order))).clamp(0.5, 1.5);
                self.stretch = stretch;
                return Some(rounded * BEYOND);
            }
            length = rounded * (0.9 / excess.powf(1.0 / count(self.order))).clamp(0.1, 0.9);
        }
        None
    }

    /// How much remainders exceed what is allowed, and the polynomials if they do not.
    fn attempt(&mut self, start: &[Ball], rates: &[Ball], length: f64) -> Option<(f64, Option<Stretch<S>>)> {
        let n = self.dimension;
        let unit = nearest_power_of_two(length);
        let share = length / unit;
        let time = onwards(Ball::exact(self.time), up(length * BEYOND));
        let tube = self.tube(&time, start, rates, length)?;
        let there = finite(&self.values, &[&[time], tube.as_slice()].concat(), &mut self.scratch)?;
        let jacobian = &there[n..];
        // Of what J gets to be on the way: where a motion begins, couplings may vanish.
        let scales = &scales(n, jacobian);
        let over = near_unit(jacobian, scales, up(length * BEYOND))?;
        let path = expanded(&mut self.coarse, &time, &tube, unit, self.order, ());
        let power = share.powf(count(self.order));
        let sizes: Vec<f64> = tube.iter().map(Ball::abs_upper).collect();
        let largest = sizes.iter().zip(scales).fold(0.0_f64, |most, (x, w)| most.max(x / w));
        let mut excess = 1e-30_f64;
        let mut rest = Vec::with_capacity(n);
        for (i, row) in path.iter().enumerate() {
            let last = *row.get(self.order)?;
            let size = last.abs_upper() * power;
            let allowed = sizes[i].max(SMALL * scales[i] * largest);
            if size > 0.0 {
                let allowed = REMAINDER * S::rounding(self.precision) * allowed;
                let allowed = allowed.max(self.nothing);
                excess = excess.max(size / allowed);
            }
            rest.push(last);
        }
        if excess.is_nan() || excess > 1.0 {
            return excess.is_finite().then(|| (excess, None));
        }

        let time_here = Ball::exact(self.time);
        let order = self.slope_order;
        let remainder = expanded_slopes(&mut self.slopes, &time, &tube, &over, unit, order, ()).slopes;
        let last: Vec<Ball> = remainder.iter().map(|row| row.last().copied()).collect::<Option<_>>()?;
        let size = norm(&last, scales) * share.powf(count(self.slope_order));
        excess = excess.max((size / SLOPE).powf(count(self.order) / count(self.slope_order)));
        if excess.is_nan() || excess > 1.0 {
            return excess.is_finite().then(|| (excess, None));
        }
        let first = Matrix::unit(n, ()).into_entries();
        let mut slopes = expanded_slopes(&mut self.slopes, &time_here, start, &first, unit, order, ()).slopes;
        for (row, last) in slopes.iter_mut().zip(&last) {
            if let Some(place) = row.last_mut() {
                *place = *last;
            }
        }
        let now = S::exact(self.time, self.precision);
        let order = self.order - 1;
        let mut path = expanded(&mut self.point, &now, &self.center, unit, order, self.precision);
        for (row, last) in path.iter_mut().zip(&rest) {
            row.push(S::from_ball(last, self.precision));
        }
        let stretch = Stretch { unit, length, path, slopes, weights: scales.clone() };
        Some((excess, Some(stretch)))
    }

    /// A box that no solution from `start` leaves before it is behind the end of the step.
    ///
    /// If X + [0, h] f(B) lies in B for all times of the step, solutions from X stay there (Picard and Lindelöf; f has
    /// bounded derivatives on B), and in fact in X + [0, h] f(B), for which the same holds again.
    fn tube(&mut self, time: &Ball, start: &[Ball], rates: &[Ball], length: f64) -> Option<Vec<Ball>> {
        let half = Ball::exact((0.5 * up(length * BEYOND)).next_up());
        // x + [0, h] f = x + h/2 f ± h/2 |f|.
        let along = |x: &Ball, f: &Ball| {
            let way = half * *f;
            (*x + way).with_added_radius(way.abs_upper())
        };
        let mut tube: Vec<Ball> = start.iter().zip(rates).map(|(x, f)| along(x, f)).collect();
        let mut inputs = vec![*time];
        let mut left = BOXES;
        while left > 0 {
            for (own, x) in tube.iter_mut().zip(start) {
                // What does not move is left alone, until it does.
                if own.radius > x.radius {
                    *own = own.with_added_radius(0.1 * own.radius + self.nothing);
                }
            }
            inputs.truncate(1);
            inputs.extend_from_slice(&tube);
            let rates = self.rates.evaluate(&inputs, &mut self.scratch);
            let next: Vec<Ball> = start.iter().zip(&rates).map(|(x, f)| along(x, f)).collect();
            if next.iter().any(|x| !x.is_finite()) {
                return None;
            }
            let within = |(own, next): (&Ball, &Ball)| {
                let apart = (Ball::from(next.mid) - Ball::from(own.mid)).abs_upper();
                own == next || up(apart + next.radius) <= own.radius
            };
            let held = tube.iter().zip(&next).all(within);
            // What rests begins to move one after the other.
            let moving = |tube: &[Ball]| tube.iter().zip(start).filter(|(own, x)| own.radius > x.radius).count();
            if moving(&next) <= moving(&tube) {
                left -= 1;
            }
            tube = next;
            if held {
                return Some(tube);
            }
        }
        None
    }

    /// The state some time after [`Following::time`], not below 0 and no further than [`Following::reach`] told.
    #[must_use]
    pub fn at(&self, after: &S) -> Option<Vec<S>> {
        let stretch = self.stretch.as_ref()?;
        let place = after.div(&S::exact(stretch.unit, self.precision));
        let spread = self.set.image(&sums(&stretch.slopes, &place.to_ball()));
        let values = sums(&stretch.path, &place);
        let parts = values.iter().zip(&spread);
        let state: Vec<S> = parts.map(|(x, r)| x.with_added_radius(*r)).collect();
        state.iter().all(S::is_finite).then_some(state)
    }

    /// Goes to the end of the step. `None` where the set has left its range.
    pub fn advance(&mut self) -> Option<()> {
        let stretch = self.stretch.take()?;
        let share = stretch.length / stretch.unit;
        let values = sums(&stretch.path, &S::exact(share, self.precision));
        let slopes = sums(&stretch.slopes, &Ball::exact(share));
        let errors: Vec<f64> = values.iter().map(S::radius).collect();
        if errors.iter().any(|e| !e.is_finite()) {
            return None;
        }
        self.set = self.set.moved(&slopes, &errors, stretch.weights)?;
        self.center = values.iter().map(S::center).collect();
        self.time += stretch.length;
        Some(())
    }
}

/// Scales of the components, powers of two, in which the entries of a matrix are of like size on both sides of the
/// diagonal (E. E. Osborne, J. ACM 7 (1960) 338).
fn scales(n: usize, matrix: &[Ball]) -> Vec<f64> {
    let sizes: Vec<f64> = matrix.iter().map(Ball::abs_upper).collect();
    weights(n, &sizes)
}

/// Polynomials, a row each, at a place.
fn sums<S: Scalar>(rows: &[Vec<S>], place: &S) -> Vec<S> {
    rows.iter().map(|row| horner(row, place)).collect()
}
