//! How long a step may be.
//!
//! As long as its last terms allow (À. Jorba and M. Zou, Experimental Mathematics 14 (2005) 99). Series have gaps: from 90° a
//! pendulum falls with the powers 2, 6, 10, … of the time, so that all terms of the upper half are looked at. And a
//! series knows nothing of a force that is next to nothing where it begins, as a hill far away or a kick to come: its
//! polynomials are put into the equations of motion at some places of the step, which is halved until they fit.

use super::step::{Real, Stepper, Trouble, count, horner};

/// What is left of the equations of motion, relative to their terms, may be so many roundings ...
const LEFT: f64 = 1e6;
/// ... or move a coordinate by so many roundings of what moves in the step, each times the root of its inertia ...
const MOVED: f64 = 1e4;
/// ... or by this, in SI: where nothing moves yet, a force far below it is none.
const NOTHING: f64 = 1e-200;
/// A step is looked at in so many places at least.
const LEAST: f64 = 2.0;
/// Halvings of a step.
const HALVINGS: usize = 60;
/// Halvings after which what does not get smaller counts as rounding.
const PATIENCE: usize = 3;

impl<S: Real> Stepper<'_, S> {
    /// A length in units of time at which the last terms are what is allowed beside the size of each coordinate; a term before
    /// the last one may be as much larger.
    pub(super) fn length(&self) -> Result<f64, Trouble> {
        let mut length = f64::INFINITY;
        for (rows, degree) in [(&self.positions, 2), (&self.velocities, 1)] {
            for row in rows.iter().take(self.equations.coordinates) {
                let sizes = |k: usize| row[k].middle().abs();
                // What moves with a high power of the time at first has no size but from that.
                let first = (0..=self.order).find(|k| sizes(*k) != 0.0);
                let degree = first.unwrap_or(0).max(degree);
                for k in (self.order.div_ceil(2)..=self.order).rev() {
                    length = length.min(self.reach(&sizes, k, degree, length));
                }
            }
        }
        if length.is_nan() || length <= 0.0 {
            return Err(Trouble::NoStep);
        }
        Ok(length)
    }

    /// Where the k-th term of a coordinate is what is allowed beside the largest that the coordinate gets on the way, which
    /// its terms up to a degree tell about, if that is nearer than `length`; infinite otherwise.
    fn reach(&self, sizes: &dyn Fn(usize) -> f64, k: usize, degree: usize, length: f64) -> f64 {
        let last = sizes(k);
        if last == 0.0 || k == 0 {
            return f64::INFINITY;
        }
        let power = |reach: f64, k: usize| reach.powi(i32::try_from(k).unwrap_or(i32::MAX));
        let on_the_way = |reach: f64| {
            let terms = (0..=degree.min(k)).map(|term| sizes(term) * power(reach, term));
            terms.fold(0.0, f64::max)
        };
        let share = count(k) / count((self.order - 1).max(k));
        let tolerance = || self.tolerance.powf(share);
        // Mostly another term is what counts.
        if length.is_finite() {
            let part = last * power(length, k) / on_the_way(length);
            if part <= self.tolerance || part <= tolerance() {
                return f64::INFINITY;
            }
        }
        let tolerance = tolerance();
        let mut size = sizes(0);
        let mut own = f64::INFINITY;
        for _ in 0..3 {
            own = if size > 0.0 {
                (tolerance * size / last).powf(1.0 / count(k))
            } else {
                f64::INFINITY
            };
            let reach = own.min(length);
            size = if reach.is_finite() {
                on_the_way(reach)
            } else {
                (1..=degree.min(k)).map(sizes).fold(0.0, f64::max)
            };
        }
        own
    }

    /// The length, in time, halved until the polynomials fit the equations of motion; places that are looked at are no further
    /// from each other than `spacing`.
    pub(super) fn fitting(&mut self, t: &S, length: f64, spacing: f64) -> f64 {
        if !(length > 0.0 && length.is_finite()) {
            return length;
        }
        let mut own = length;
        let mut before = f64::INFINITY;
        let mut vain = 0;
        for _ in 0..HALVINGS {
            let looks = (own / spacing).ceil().max(LEAST);
            let Some(left) = self.left(t, own, looks) else {
                return own;
            };
            vain = if left > 0.5 * before { vain + 1 } else { 0 };
            // Rounding does not get smaller, nor does a jump, which is larger.
            if vain >= PATIENCE && left < (LEFT * S::ROUNDING).sqrt() {
                return length;
            }
            before = left;
            own *= 0.5;
        }
        own
    }

    /// The largest part of the equations of motion that is left over somewhere in a step, if it is more than may be.
    fn left(&mut self, t: &S, length: f64, looks: f64) -> Option<f64> {
        let n = self.equations.coordinates;
        let rounding = S::ROUNDING.max(self.tolerance);
        let mut look = 1.0;
        while look <= looks {
            let after = S::exact(length * (look / looks));
            look += 1.0;
            let place = after.div(&S::exact(self.unit));
            let at = |rows: &[Vec<S>], terms: usize| -> Vec<S> {
                rows.iter()
                    .map(|row| horner(&row[..terms], &place))
                    .collect()
            };
            let q = at(&self.positions, self.order + 1);
            let v = at(&self.velocities, self.order + 1);
            // In time, not in units of it.
            let a = at(&self.accelerations, self.order);
            let mu = at(&self.multipliers, self.order);
            let mut inputs = Vec::with_capacity(1 + 2 * n + self.signs.len());
            inputs.push(t.add(&after));
            inputs.extend(q.iter().chain(&v));
            inputs.extend(self.signs.iter().map(|sign| S::exact(*sign)));
            let out = self.values.evaluate(&inputs, &mut self.scratch);
            let (mass, rest) = out.split_at(self.equations.mass.len());
            let (load, rest) = rest.split_at(n);
            let mut sums: Vec<S> = load.to_vec();
            let mut sizes: Vec<f64> = load.iter().map(|x| x.middle().abs()).collect();
            let mut inertia = vec![0.0_f64; n];
            let mut put = |row: usize, part: S| {
                sums[row] = sums[row].add(&part);
                sizes[row] += part.middle().abs();
            };
            for ((i, j), entry) in self.equations.mass.iter().zip(mass) {
                put(*i, entry.mul(&a[*j]));
                inertia[*i] = inertia[*i].max(entry.middle().abs());
                if i != j {
                    put(*j, entry.mul(&a[*i]));
                    inertia[*j] = inertia[*j].max(entry.middle().abs());
                }
            }
            for ((row, i), entry) in self.equations.gradients.iter().zip(rest) {
                put(*i, entry.mul(&mu[*row]).neg());
            }
            // A coordinate at rest has nothing but what is rounded of others.
            let way = (0..n).fold(0.0_f64, |most, i| {
                let own = self.positions[i][0].middle().abs();
                let own = own.max(q[i].middle().abs());
                let own = own.max(v[i].middle().abs() * length);
                most.max(own * inertia[i].sqrt())
            });
            let mut worst: Option<f64> = None;
            for i in 0..n {
                let left = sums[i].middle().abs();
                if !left.is_finite() {
                    return Some(f64::INFINITY);
                }
                let moved = left * length * length;
                let root = inertia[i].sqrt();
                let counts = moved > (MOVED * rounding * way).max(NOTHING * root) * root;
                if counts && left > LEFT * rounding * sizes[i] {
                    worst = Some(worst.unwrap_or(0.0).max(left / sizes[i]));
                }
            }
            if worst.is_some() {
                return worst;
            }
        }
        None
    }
}
