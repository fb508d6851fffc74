//! A start moved onto the constraints.
//!
//! What is not given moves first, by Newton steps of least length. Where that does not do, what is given in decimals moves
//! too, by no more than half a unit of its last digit, or a little if it comes from another program: steps are then shortest in the metric of the masses. Which point is
//! reached is proved by Krawczyk's theorem (Computing 4 (1969) 187) among the points q + J(q)ᵀ mu beside the last one.

use nalgebra::{DMatrix, DVector};

use super::System;
use super::error::MotionError;
use super::start::{Given, Known, Moved, Start};
use super::step::sign;
use librate_core::linearize::short;
use librate_core::precision::{Ball, up};

/// Newton steps to the constraints.
const MOST_STEPS: usize = 60;

/// Beside half a unit of the last digit: roundings of the projection.
const ROUNDING: f64 = 1.0 + 1e-6;

/// ... or so much of the largest coordinate, or velocity: more than other programs let a motion drift.
const NEAR: f64 = 1e-3;

/// Constraints and their gradients at one state.
struct Place {
    gaps: Vec<Ball>,
    /// Constraint, coordinate and slope.
    slopes: Vec<(usize, usize, Ball)>,
    /// Row, column and entry of M, on and above the diagonal.
    mass: Vec<(usize, usize, f64)>,
}

impl Place {
    /// The constraints, or their rates; `None` where the side of a kink is not decided.
    fn new(system: &System, positions: &[Ball], velocities: &[Ball], rates: bool, decided: bool) -> Option<Self> {
        let equations = &system.equations;
        let (n, c) = (equations.coordinates, equations.constraints);
        let mut scratch = Vec::new();
        let mut inputs = [&[Ball::ZERO], positions, velocities].concat();
        let gaps = equations.surface.prepare::<Ball>(()).evaluate(&inputs, &mut scratch);
        let gaps = if rates { gaps.get(c..)? } else { gaps.get(..c)? };
        let kinks = equations.kinks.prepare::<Ball>(()).evaluate(&inputs, &mut scratch);
        if decided && kinks.iter().any(Ball::contains_zero) {
            return None;
        }
        inputs.extend(kinks.iter().map(|x| Ball::exact(sign(x.mid_f64()))));
        let values = equations.tape.prepare::<Ball>(()).evaluate(&inputs, &mut scratch);
        let masses = equations.mass.iter().zip(&values);
        let slopes = values.get(equations.mass.len() + n..)?;
        let slopes = equations.gradients.iter().zip(slopes);
        Some(Self {
            gaps: gaps.to_vec(),
            slopes: slopes.map(|((a, i), slope)| (*a, *i, *slope)).collect(),
            mass: masses.map(|((i, j), m)| (*i, *j, m.mid_f64())).collect(),
        })
    }

    /// Slopes by some coordinates, one column each.
    fn columns(&self, of: &[usize]) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.gaps.len(), of.len());
        for (a, i, slope) in &self.slopes {
            if let Some(column) = of.iter().position(|own| own == i) {
                matrix[(*a, column)] = slope.mid_f64();
            }
        }
        matrix
    }

    /// The Cholesky factor of M among some coordinates; `None` where it has none.
    fn metric(&self, of: &[usize]) -> Option<DMatrix<f64>> {
        let mut matrix = DMatrix::zeros(of.len(), of.len());
        for (i, j, mass) in &self.mass {
            let place = |i: &usize| of.iter().position(|own| own == i);
            if let (Some(row), Some(column)) = (place(i), place(j)) {
                matrix[(row, column)] = *mass;
                matrix[(column, row)] = *mass;
            }
        }
        Some(nalgebra::Cholesky::new(matrix)?.l())
    }
}

impl Start {
    /// Moves what is not given so that constraints hold, then what is given in decimals within their digits.
    pub(super) fn onto_constraints(
        &mut self,
        system: &System,
        given: &[Given],
        held: &[usize],
    ) -> Result<(), MotionError> {
        if system.equations.constraints == 0 {
            return Ok(());
        }
        for rates in [false, true] {
            let before = self.clone();
            let own = |i: usize| given.iter().find(|own| (own.coordinate, own.moves) == (i, rates));
            let n = system.equations.coordinates;
            let mut free: Vec<usize> = (0..n).filter(|i| own(*i).is_none() && !(rates && held.contains(i))).collect();
            let mut settled = self.settle(system, rates, &free, false);
            if !settled && !held.is_empty() {
                *self = before.clone();
                free = (0..n).filter(|i| own(*i).is_none()).collect();
                settled = self.settle(system, rates, &free, false);
            }
            let mut off = None;
            let rounded = |i: usize| own(i).is_some_and(|own| own.half_unit.is_some());
            if !settled && (0..n).any(rounded) {
                *self = before.clone();
                free = (0..n).filter(|i| own(*i).is_none() || rounded(*i)).collect();
                settled = self.settle(system, rates, &free, true);
                let largest = before.state(rates).iter().fold(0.0_f64, |most, x| most.max(x.mid_f64().abs()));
                for i in (0..n).filter(|i| settled && rounded(*i)) {
                    let by = (self.state(rates)[i] - before.state(rates)[i]).mid_f64();
                    let digits = own(i).and_then(|own| own.half_unit).map_or(0.0, |own| own * ROUNDING);
                    let computed = own(i).is_some_and(|own| own.computed);
                    let most = if computed { digits.max(NEAR * largest) } else { digits };
                    let moved = Moved { coordinate: i, velocity: rates, by, rounded: by.abs() <= digits };
                    if by.abs() > most {
                        off = off.or(Some((moved, most)));
                    } else if by != 0.0 {
                        self.moved.push(moved);
                    }
                }
            }
            let what = if rates { "velocities" } else { "coordinates" };
            let broken = |reason| Err(MotionError::OffConstraints { reason });
            if let Some((moved, most)) = off {
                let (away, most) = (short(moved.by.abs()), short(most));
                return broken(format!(
                    "the nearest {what} that do are {away} away, where the digits given leave {most}"
                ));
            }
            if !settled {
                return broken(format!("no {what} beside those that are given do"));
            }
            self.enclose(system, rates, &free);
        }
        Ok(())
    }

    fn state(&self, rates: bool) -> &[Ball] {
        if rates { &self.velocities } else { &self.positions }
    }

    /// The same with what is known of each, to be changed.
    pub(super) fn parts(&mut self, rates: bool) -> (&mut [Ball], &mut [Known]) {
        let (places, speeds) = self.known.split_at_mut(self.positions.len());
        if rates { (&mut self.velocities, speeds) } else { (&mut self.positions, places) }
    }

    /// Newton steps for some coordinates, or velocities: of least length, or least in the metric of the masses.
    fn settle(&mut self, system: &System, rates: bool, free: &[usize], by_mass: bool) -> bool {
        let (mut gap, before) = (f64::INFINITY, self.clone());
        for _ in 0..MOST_STEPS {
            let place = Place::new(system, &self.positions, &self.velocities, rates, false);
            let Some(place) = place else { return false };
            // Of the parts of each constraint, and beside the largest number: where parts are 0, roundings of the others are left.
            let largest = self.state(rates).iter().fold(0.0_f64, |most, x| most.max(x.mid_f64().abs()));
            let mut sizes = vec![[0.0_f64; 2]; place.gaps.len()];
            for (a, i, slope) in &place.slopes {
                let slope = slope.mid_f64().abs();
                let parts = [slope * self.state(rates)[*i].mid_f64().abs(), slope * largest];
                sizes[*a].iter_mut().zip(parts).for_each(|(size, part)| *size = size.max(part));
            }
            let [off, rounding] = [0, 1].map(|which| {
                place.gaps.iter().zip(&sizes).fold(0.0_f64, |most, (gap, size)| {
                    let gap = gap.mid_f64().abs();
                    most.max(if gap > 0.0 { gap / size[which].max(f64::MIN_POSITIVE) } else { 0.0 })
                })
            });
            if off <= 1e-30 || off >= 0.5 * gap && (off <= 1e-26 || rounding <= 1e-30) {
                self.forget_roundings(before, rates, free, largest);
                return true;
            }
            gap = off;
            if free.is_empty() {
                return false;
            }
            let slopes = place.columns(free);
            let gaps = place.gaps.iter().map(|gap| -gap.mid_f64());
            let right = DVector::from_iterator(place.gaps.len(), gaps);
            // With M = L Lᵀ the shortest L^T dq.
            let metric = by_mass.then(|| place.metric(free)).flatten();
            let weighted = metric.as_ref().and_then(|factor| factor.solve_lower_triangular(&slopes.transpose()));
            let step = match (&metric, weighted) {
                (Some(factor), Some(weighted)) => {
                    let step = weighted.transpose().svd(true, true).solve(&right, 1e-12);
                    step.ok().and_then(|step| factor.transpose().solve_upper_triangular(&step))
                }
                _ => slopes.svd(true, true).solve(&right, 1e-12).ok(),
            };
            let Some(step) = step.filter(|step| step.iter().all(|x| x.is_finite())) else { return false };
            let (state, known) = self.parts(rates);
            // What the constraints leave where it is takes no roundings of the others.
            let roundings = 4.0 * f64::EPSILON * step.amax();
            for (at, step) in free.iter().zip(step.iter()).filter(|(_, step)| step.abs() > roundings) {
                let moved = state[*at] + Ball::exact(*step);
                state[*at] = Ball::new(moved.mid, state[*at].radius);
                // Newton's method leads near a point of the constraints, and no nearer.
                known[*at] = Known::Open;
            }
        }
        false
    }

    /// Puts back what moved by no more than roundings of the largest number leave.
    fn forget_roundings(&mut self, mut before: Self, rates: bool, free: &[usize], largest: f64) {
        let ((state, known), (old, known_before)) = (self.parts(rates), before.parts(rates));
        for &at in free {
            if (state[at] - old[at]).mid_f64().abs() <= 1e-28 * largest {
                known[at].clone_from(&known_before[at]);
                state[at] = old[at];
            }
        }
    }

    /// Encloses the point of the constraints beside which Newton's steps ended; leaves open what can't be proved.
    fn enclose(&mut self, system: &System, rates: bool, free: &[usize]) {
        let (_, known) = self.parts(rates);
        let moved: Vec<usize> = free.iter().copied().filter(|i| matches!(known[*i], Known::Open)).collect();
        if moved.is_empty() {
            return;
        }
        let Some(radii) = self.radii(system, rates, &moved) else { return };
        let (state, known) = self.parts(rates);
        for (i, radius) in moved.iter().zip(radii) {
            known[*i] = Known::Within(Ball::new(state[*i].mid, 0.0).with_added_radius(radius));
        }
    }

    /// How far the point of the constraints is from where Newton's steps ended, coordinate by coordinate.
    ///
    /// With x = x0 + D mu and F(mu) = c(x), |C F(0)| + |1 - C J D| r <= r, J the slopes over the box |mu| <= r, proves a zero
    /// of F in the box (Krawczyk).
    fn radii(&self, system: &System, rates: bool, moved: &[usize]) -> Option<Vec<f64>> {
        let n = system.equations.coordinates;
        let of = |first: usize, values: &[Ball], now: bool| -> Option<Vec<Ball>> {
            let all = self.known.get(first..first + n)?.iter().zip(values).enumerate();
            let is_centre = |i: usize| now && moved.contains(&i);
            all.map(|(i, (known, x))| if is_centre(i) { Some(Ball::new(x.mid, 0.0)) } else { known.enclosed(()) })
                .collect()
        };
        let mut positions = of(0, &self.positions, !rates)?;
        let mut velocities = if rates { of(n, &self.velocities, true)? } else { self.velocities.clone() };
        let here = Place::new(system, &positions, &velocities, rates, true)?;
        let slopes = here.columns(moved);
        let directions = slopes.transpose();
        let inverse = (&slopes * &directions).try_inverse()?;
        let c = here.gaps.len();
        let steps: Vec<f64> = (0..c)
            .map(|a| {
                let parts = here.gaps.iter().enumerate();
                let parts = parts.map(|(b, gap)| up(inverse[(a, b)].abs() * gap.abs_upper()));
                up(parts.sum::<f64>() * (1.0 + 1e-12))
            })
            .collect();
        let radius = up(2.0 * steps.iter().copied().fold(0.0, f64::max)).max(1e-300);
        let radii: Vec<f64> = (0..moved.len())
            .map(|i| {
                let parts = (0..c).map(|a| directions[(i, a)].abs());
                up(parts.sum::<f64>() * radius * (1.0 + 1e-12))
            })
            .collect();
        let state = if rates { &mut velocities } else { &mut positions };
        for (i, radius) in moved.iter().zip(&radii) {
            state[*i] = state[*i].with_added_radius(*radius);
        }
        let over = Place::new(system, &positions, &velocities, rates, true)?;
        let mut derivative = vec![Ball::ZERO; c * c];
        for (a, i, slope) in &over.slopes {
            if let Some(column) = moved.iter().position(|own| own == i) {
                for b in 0..c {
                    let entry = &mut derivative[a + c * b];
                    *entry = *entry + *slope * Ball::exact(directions[(column, b)]);
                }
            }
        }
        let holds = (0..c).all(|a| {
            let row = (0..c).map(|b| {
                let whole = Ball::exact(f64::from(u8::from(a == b)));
                let parts = (0..c).map(|k| Ball::exact(inverse[(a, k)]) * derivative[k + c * b]);
                parts.fold(whole, |rest, part| rest - part).abs_upper()
            });
            let left = up(row.sum::<f64>() * radius * (1.0 + 1e-12));
            up(steps[a] + left) <= radius
        });
        holds.then_some(radii)
    }
}
