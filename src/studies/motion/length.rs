//! How long a step may be.
//!
//! As long as its last terms allow (À. Jorba and M. Zou, Experimental Mathematics 14 (2005) 99). Series have gaps: from 90° a
//! pendulum falls with the powers 2, 6, 10, … of the time, so that all terms of the upper half are examined. And a
//! series knows nothing of a force that is next to nothing where it begins, as a hill far away or a kick to come: its
//! polynomials are put into the equations of motion at some places of the step, which is halved until they fit.

use super::step::{Real, Stepper, Trouble, beginning};
use crate::flow::{count, horner};

/// What is left of the equations of motion, relative to their terms, may be so many roundings ...
const LEFT: f64 = 1e6;
/// ... or move a coordinate, in the step, by so many times the square of the order times what may be left out of what moves, each
/// times the root of its inertia (two derivatives of the last term make that of it) ...
const MOVED: f64 = 10.0;
/// ... or by this, in SI: where nothing moves yet, a force far below it is none.
const NOTHING: f64 = 1e-200;
/// A step is examined in so many places at least: what is missing is most at its end.
const LEAST: f64 = 1.0;
/// A term before the last two may be so many times what it would be if all fell evenly: they count where those vanish.
const UNEVEN: f64 = 10.0;
/// Halvings of a step.
const HALVINGS: usize = 60;
/// Halvings after which what does not get smaller counts as rounding.
const PATIENCE: usize = 3;

impl<S: Real> Stepper<'_, S> {
    /// A length in units of time at which the last terms are what is allowed beside the size of each coordinate; a term before
    /// the last one may be as much larger.
    pub(super) fn length(&self) -> Result<f64, Trouble> {
        let terms = self.terms;
        let all = [(&self.positions, 2), (&self.velocities, 1)];
        let rows = || {
            all.into_iter().flat_map(|(rows, degree)| {
                rows.iter().take(self.equations.coordinates).map(move |row| {
                    // What moves with a high power of the time at first has no size but from that.
                    let first = beginning(row).unwrap_or(0);
                    // Its terms are counted from there, as far as the order goes.
                    let start = first.min(self.order - terms);
                    Row { terms: row, degree: first.max(degree), start }
                })
            })
        };
        let mut length = f64::INFINITY;
        for row in rows() {
            length = [terms, terms - 1].iter().fold(length, |length, k| length.min(self.reach(&row, *k, length)));
        }
        // Mostly the others are small by far where these are.
        for row in rows() {
            let mut power = power(length, row.start + terms - 1);
            let mut size = row.on_the_way(length);
            for k in (terms.div_ceil(2)..terms - 1).rev() {
                power /= length;
                let term = row.terms[row.start + k].middle().abs();
                let fine = length.is_finite() && term * power <= self.allowed[k] * size;
                if term == 0.0 || fine {
                    continue;
                }
                length = length.min(self.reach(&row, k, length));
                power = self::power(length, row.start + k);
                size = row.on_the_way(length);
            }
        }
        if length.is_nan() || length <= 0.0 { Err(Trouble::NoStep) } else { Ok(length) }
    }

    /// Where the k-th term of a coordinate, from where its terms are counted, is what is allowed beside the largest that the
    /// coordinate gets on the way, if that is nearer than `length`; infinite otherwise.
    fn reach(&self, row: &Row<'_, S>, k: usize, length: f64) -> f64 {
        let allowed = self.allowed[k];
        let k = row.start + k;
        let last = row.terms[k].middle().abs();
        if last == 0.0 || k == 0 {
            return f64::INFINITY;
        }
        // Mostly another term is what counts.
        if length.is_finite() && last * power(length, k) <= allowed * row.on_the_way(length) {
            return f64::INFINITY;
        }
        let mut size = row.terms[0].middle().abs();
        let mut own = f64::INFINITY;
        for _ in 0..3 {
            own = if size > 0.0 {
                // Where all is small their product may vanish.
                (allowed * (size / last)).powf(1.0 / count(k))
            } else {
                f64::INFINITY
            };
            let reach = own.min(length);
            size = if reach.is_finite() {
                row.on_the_way(reach)
            } else {
                row.terms.iter().take(row.degree + 1).skip(1).map(|x| x.middle().abs()).fold(0.0, f64::max)
            };
        }
        own
    }

    /// The length, in time, halved until the polynomials fit the equations of motion; places that are examined are no further
    /// from each other than `spacing`.
    pub(super) fn fitting(&mut self, t: &S, length: f64, spacing: f64) -> f64 {
        if !(length > 0.0 && length.is_finite()) {
            return length;
        }
        let mut own = length;
        let mut before = f64::INFINITY;
        let mut vain = 0;
        for _ in 0..HALVINGS {
            let samples = (own / spacing).ceil().max(LEAST);
            let Some(left) = self.left(t, own, samples) else { return own };
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
    fn left(&mut self, t: &S, length: f64, samples: f64) -> Option<f64> {
        let mut buffers = std::mem::take(&mut self.buffers);
        let mut worst = None;
        let mut sample = 1.0;
        while sample <= samples && worst.is_none() {
            worst = self.left_at(&mut buffers, t, length * (sample / samples));
            sample += 1.0;
        }
        self.buffers = buffers;
        worst
    }

    /// The same at one place.
    fn left_at(&mut self, buffers: &mut Buffers<S>, t: &S, after: f64) -> Option<f64> {
        let equations = self.equations;
        let (n, m) = (equations.coordinates, equations.free.len());
        let may = MOVED * count(self.order).powi(2) * S::ROUNDING.max(self.tolerance);
        let time = S::exact(after);
        let place = time.div(&S::exact(self.unit));
        let order = self.order;
        buffers.inputs.clear();
        buffers.inputs.push(t.add(&time));
        let state = self.positions.iter().chain(&self.velocities);
        buffers.inputs.extend(state.map(|row| horner(row, &place)));
        buffers.inputs.extend(self.signs.iter().map(|sign| S::exact(*sign)));
        // Accelerations and multipliers have a term less.
        let forces = self.accelerations.iter().chain(&self.multipliers);
        buffers.forces.clear();
        buffers.forces.extend(forces.map(|row| horner(&row[..order], &place)));
        buffers.out.resize(self.values.outputs(), S::exact(0.0));
        self.values.evaluate_into(&buffers.inputs, &mut self.scratch, &mut buffers.out);
        let (mass, rest) = buffers.out.split_at(equations.mass.len());
        let (load, rest) = rest.split_at(m);
        buffers.sums.clear();
        buffers.sums.extend_from_slice(load);
        buffers.sizes.clear();
        buffers.sizes.extend(load.iter().map(|x| x.middle().abs()));
        buffers.inertia.clear();
        buffers.inertia.resize(m, 0.0);
        let (sums, sizes, forces) = (&mut buffers.sums, &mut buffers.sizes, &buffers.forces);
        let mut put = |row: usize, part: S| {
            sums[row] = sums[row].add(&part);
            sizes[row] += part.middle().abs();
        };
        for ((i, j), entry) in equations.mass.iter().zip(mass) {
            let size = entry.middle().abs();
            put(*i, entry.mul(&forces[*j]));
            buffers.inertia[*i] = buffers.inertia[*i].max(size);
            if i != j {
                put(*j, entry.mul(&forces[*i]));
                buffers.inertia[*j] = buffers.inertia[*j].max(size);
            }
        }
        for ((row, i), entry) in equations.gradients.iter().zip(rest) {
            put(*i, entry.mul(&forces[m + *row]).neg());
        }
        // A coordinate at rest has nothing but what is rounded of others.
        let way = equations.free.iter().zip(&buffers.inertia).fold(0.0_f64, |most, (i, inertia)| {
            let own = self.positions[*i][0].middle().abs().max(buffers.inputs[1 + i].middle().abs());
            let own = own.max(buffers.inputs[1 + n + i].middle().abs() * after);
            most.max(own * inertia.sqrt())
        });
        let mut worst: Option<f64> = None;
        let mut counted = |left: f64, size: f64| worst = Some(worst.unwrap_or(0.0).max(left / size));
        for i in 0..m {
            let left = buffers.sums[i].middle().abs();
            if !left.is_finite() {
                return Some(f64::INFINITY);
            }
            let moved = left * after * after;
            let root = buffers.inertia[i].sqrt();
            let counts = moved > (may * way).max(NOTHING * root) * root;
            if counts && left > LEFT * S::ROUNDING * buffers.sizes[i] {
                counted(left, buffers.sizes[i]);
            }
        }
        // The polynomials of velocities that follow have a term less.
        let speeds = rest.iter().skip(equations.gradients.len() + equations.constraints);
        for (i, speed) in equations.bound.iter().zip(speeds) {
            let own = &buffers.inputs[1 + n + i];
            let left = own.sub(speed).middle().abs();
            let size = own.middle().abs().max(speed.middle().abs());
            let way = self.positions[*i][0].middle().abs().max(buffers.inputs[1 + i].middle().abs()).max(size * after);
            if left * after > (may * way).max(NOTHING) && left > LEFT * S::ROUNDING * size {
                counted(left, size);
            }
        }
        worst
    }
}

fn power(length: f64, k: usize) -> f64 {
    length.powi(i32::try_from(k).unwrap_or(i32::MAX))
}

/// The terms of a coordinate or velocity, those up to a degree that tell its size, and where its terms are counted from.
struct Row<'a, S> {
    terms: &'a [S],
    degree: usize,
    start: usize,
}

impl<S: Real> Row<'_, S> {
    /// The largest of the first terms at a length.
    fn on_the_way(&self, length: f64) -> f64 {
        let (mut most, mut power) = (0.0_f64, 1.0);
        for term in self.terms.iter().take(self.degree + 1) {
            most = most.max(term.middle().abs() * power);
            power *= length;
        }
        most
    }
}

/// What each term may be beside the size of a coordinate: the last ones as much as is left out, one before them more.
pub(super) fn allowed(order: usize, tolerance: f64) -> Vec<f64> {
    let even = |k: usize| tolerance.powf(count(k) / count((order - 1).max(k).max(1)));
    let uneven = |k: usize| if k + 1 < order { UNEVEN } else { 1.0 };
    (0..=order).map(|k| uneven(k) * even(k)).collect()
}

/// Buffers for what is calculated at a place.
#[derive(Default)]
pub(super) struct Buffers<S> {
    inputs: Vec<S>,
    forces: Vec<S>,
    out: Vec<S>,
    sums: Vec<S>,
    sizes: Vec<f64>,
    inertia: Vec<f64>,
}
