//! Coordinates without inertia that friction or gyroscopic forces hold: equations of first order among those of second.
//!
//! For directions v with M v = 0 the equations vᵀ(s²M + sD + S)q = 0 are of first order, with D = G + C and S = K + N, or where D v = 0
//! too, of none. In place of the equations of as many coordinates they are multiplied by s + σ, or by two such factors, each with a σ of its
//! own. That adds the exponents -σ to those of the model, which are known, and nothing else. Where the leading matrix L of these rows is
//! regular, steps on the rows of these coordinates alone make M of it with some more mass for each of them, which is positive: So exponents,
//! bounds and digits are those of any other model, vectors stay as they are, and what friction does not reach keeps its form.
//! With gyroscopic forces alone the exponents come in pairs ±s still, which then tells that a growth is 0.
//!
//! A direction that springs hold may also be coupled to the velocities of the others ([`Flow::uncouple`]).

use super::Linearized;
use super::constrained::{choose_bound, solve_for};
use super::massless::{self, Direction, product, row};
use crate::number::Number;
use crate::precision::{Ball, Enclosure, Scalar};

/// What an equation is multiplied by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// s + σ: friction holds the direction.
    First,
    /// (s + σ)(s + σ'): springs do.
    Static,
}

/// The directions without inertia of a model with forces that go with velocities.
#[derive(Clone, Debug)]
pub(crate) struct Flow {
    directions: Vec<(Direction, Order)>,
    /// The coordinates whose equations are replaced, among those that are left.
    pub(crate) places: Vec<usize>,
    rate: f64,
    /// The mass that each of these coordinates gets.
    masses: Vec<f64>,
    pub(crate) shifts: Vec<f64>,
}

/// M, G + C and K + N, dense, column by column.
pub(super) type Three<S> = [Vec<S>; 3];

/// The directions without inertia of what is left of a model, where friction or gyroscopic forces determine how they move. Where they are no coordinates,
/// those that follow the others are among them, and none follows before.
pub(super) fn find(own: &mut Linearized) -> Option<Flow> {
    let first = |places: &[usize]| places.iter().map(|at| (massless::unit(*at), Order::First)).collect();
    let mut directions = match own.rolling() {
        Some(rolling) => first(&rolling.symbolic.first),
        None => orders_of(own, massless::resting(own).into_iter().map(massless::unit).collect()),
    };
    if own.rolling().is_none()
        && let Some(all) = massless::kernel_of_mass(own)
        && all.len() > own.massless_directions() + directions.len()
    {
        let followed = own.massless.take();
        let followed = followed.and_then(|own| own.ok()).map(|own| own.directions).unwrap_or_default();
        directions = followed.into_iter().map(|v| (v, Order::Static)).collect();
        for found in orders_of(own, all) {
            directions.push(found);
            if places(own, &directions).is_none() {
                directions.pop();
            }
        }
    }
    if directions.is_empty() {
        return None;
    }
    let places = places(own, &directions)?;
    let (velocity, stiffness) = own.velocity_and_stiffness();
    let (mass, n) = (own.mass(), own.dimension());
    let size = |matrix: &[Ball], i: usize| -> f64 { (0..n).map(|j| matrix[i + n * j].mid_f64().abs()).sum() };
    let mut fastest = 0.0_f64;
    for i in (0..n).filter(|i| !places.contains(i)) {
        let (own, d, s) = (mass[i + n * i].mid_f64(), size(&velocity, i), size(&stiffness, i));
        fastest = fastest.max(d / own).max((s / own).sqrt());
    }
    let mut sizes = Vec::with_capacity(places.len());
    for (v, order) in &directions {
        let [drag, spring] = [&velocity, &stiffness].map(|matrix| {
            let row = row(v, matrix, ());
            let total: f64 = row.iter().map(|entry| entry.mid_f64().abs()).sum();
            (total, product(v, |i| &row[i], ()).mid_f64().abs())
        });
        if *order == Order::First {
            fastest = fastest.max(spring.0 / drag.1);
        }
        sizes.push((drag.0, spring.0, *order));
    }
    let power = |x: f64| if x.is_finite() && x > 0.0 { x.log2().ceil().exp2() } else { 1.0 };
    let rate = power(fastest);
    let mass_of = |(drag, spring, order): (f64, f64, Order)| match order {
        Order::First => power(drag / rate),
        Order::Static => power(spring / rate / rate),
    };
    let masses = sizes.into_iter().map(mass_of).collect();
    let flow = Flow { shifts: Vec::new(), directions, places, rate, masses }.attempt(0);
    flow.regular(&[mass, velocity, stiffness], Enclosure::certain_size, ()).is_some().then_some(flow)
}

/// Which of some directions no force of velocities holds: vᵀDw = 0 for all of them.
fn orders_of(own: &Linearized, all: Vec<Direction>) -> Vec<(Direction, Order)> {
    if all.is_empty() {
        return Vec::new();
    }
    let velocity = own.velocity_and_stiffness().0;
    let images: Vec<Vec<Ball>> = all.iter().map(|v| row(v, &velocity, ())).collect();
    let is_free = |a: usize, b: usize| product(&all[b], |i| &images[a][i], ()).is_zero();
    let order = |a: usize| {
        let is_static = (0..all.len()).all(|b| is_free(a, b) && is_free(b, a));
        if is_static { Order::Static } else { Order::First }
    };
    let orders: Vec<Order> = (0..all.len()).map(order).collect();
    all.into_iter().zip(orders).collect()
}

/// Coordinates by which the directions are told apart, one for each; `None` where the directions are not independent.
fn places(own: &Linearized, directions: &[(Direction, Order)]) -> Option<Vec<usize>> {
    let n = own.dimension();
    let row = |v: &Direction| {
        let mut row = vec![Ball::ZERO; n];
        v.iter().for_each(|(i, x)| row[*i] = x.in_numbers(()));
        row
    };
    let rows: Vec<Vec<Ball>> = directions.iter().map(|(v, _)| row(v)).collect();
    choose_bound(&rows, None, ())
}

impl Flow {
    /// The same with other σ, simple fractions of the fastest rate that exponents are seldom equal to.
    pub(crate) fn attempt(&self, number: usize) -> Self {
        let shift = |at: usize| self.rate * (89 + 19 * at + 31 * number) as f64 / 64.0;
        Self { shifts: (0..self.places.len() + self.following()).map(shift).collect(), ..self.clone() }
    }

    /// The number of directions that follow the others.
    pub(super) fn following(&self) -> usize {
        self.directions.iter().filter(|(_, order)| *order == Order::Static).count()
    }

    /// Half the number of the other directions.
    pub(super) fn pairs(&self) -> usize {
        (self.directions.len() - self.following()) / 2
    }

    /// The polynomial with a regular leading matrix; `None` where that is not shown. `size` is positive for what may be divided by.
    pub(crate) fn regular<S: Scalar>(
        &self,
        [mass, velocity, stiffness]: &Three<S>,
        size: impl Fn(&S) -> f64,
        precision: S::Precision,
    ) -> Option<Three<S>> {
        let n = mass.len().isqrt();
        let others: Vec<usize> = (0..n).filter(|i| !self.places.contains(i)).collect();
        let number = |x: f64| Some(S::from_number(&Number::from_f64_exact(x)?, precision));
        let mut all = [mass.clone(), velocity.clone(), stiffness.clone()];
        for (place, own) in self.places.iter().zip(&self.masses) {
            let entry = &mut all[0][place + n * place];
            *entry = entry.add(&number(*own)?);
        }
        // The rows as they are, and those of the directions, each of the three coefficients of s.
        let mut parts: Vec<Three<S>> = Vec::with_capacity(n);
        let row = |matrix: &[S], i: usize| -> Vec<S> { (0..n).map(|j| matrix[i + n * j].clone()).collect() };
        parts.extend(others.iter().map(|i| [row(mass, *i), row(velocity, *i), row(stiffness, *i)]));
        let along =
            |(v, _): &(Direction, Order)| [velocity, stiffness].map(|matrix| massless::row(v, matrix, precision));
        let mut own: Vec<[Vec<S>; 2]> = self.directions.iter().map(along).collect();
        let coupled: Vec<usize> = (0..own.len())
            .filter(|at| self.directions[*at].1 == Order::Static && !own[*at][0].iter().all(Scalar::is_exact_zero))
            .collect();
        if !coupled.is_empty() {
            // In the directions in place of the coordinates by which they are told apart.
            let rows = parts.iter_mut().flatten().chain(own.iter_mut().flatten());
            rows.for_each(|row| self.replace_by_directions(row, precision));
        }
        let thirds = self.uncouple(&mut parts, &others, &own, &coupled, &size, precision)?;
        let mut second = self.places.len();
        for (at, (_, order)) in self.directions.iter().enumerate() {
            let ([drag, spring], shift) = (&own[at], number(self.shifts[at])?);
            if *order == Order::First {
                parts.push([drag.clone(), plus(spring, &shift, drag), times(spring, &shift)]);
                continue;
            }
            let other = number(self.shifts[second])?;
            let (sum, product) = (shift.add(&other), shift.mul(&other));
            second += 1;
            let mut part = [spring.clone(), times(spring, &sum), times(spring, &product)];
            if let Some(among) = coupled.iter().position(|own| *own == at) {
                part = [plus(&part[0], &sum, drag), plus(&part[1], &product, drag), part[2].clone()];
                // What is left of s³: s times the rows of the others takes it away.
                for (third, [_, velocity, stiffness]) in thirds.iter().zip(&parts) {
                    let factor = third[among].neg();
                    part[0] = plus(&part[0], &factor, velocity);
                    part[1] = plus(&part[1], &factor, stiffness);
                }
            }
            parts.push(part);
        }
        if !coupled.is_empty() {
            self.back(&mut parts, &size, precision)?;
        }
        // Lᵀ X is what the leading rows shall be: those of the coordinates, and of what is coupled to them.
        let changed: Vec<usize> = if coupled.is_empty() { self.places.clone() } else { (0..n).collect() };
        let column = |c: usize| {
            let leading = parts.iter().map(|part| part[0][c].clone());
            leading.chain(changed.iter().map(|place| all[0][place + n * c].clone())).collect()
        };
        let mut factors: Vec<Vec<S>> = (0..n).map(column).collect();
        solve_for(&mut factors, 0..n, &size, precision)?;
        for (at, place) in changed.iter().enumerate() {
            for matrix in [1, 2] {
                let zero = vec![S::from_number(&Number::ZERO, precision); n];
                let parts = factors.iter().zip(&parts);
                let sum = parts.fold(zero, |sum, (factor, part)| plus(&sum, &factor[n + at], &part[matrix]));
                for (c, sum) in sum.into_iter().enumerate() {
                    all[matrix][place + n * c] = sum;
                }
            }
        }
        Some(all)
    }
    /// The entries of a row for the motions along the directions, each in the place of one of the coordinates.
    fn replace_by_directions<S: Scalar>(&self, row: &mut [S], precision: S::Precision) {
        let along = self.directions.iter().map(|(v, _)| product(v, |i| &row[i], precision));
        let along: Vec<S> = along.collect();
        self.places.iter().zip(along).for_each(|(place, own)| row[*place] = own);
    }

    /// The rows for the coordinates again.
    fn back<S: Scalar>(
        &self,
        parts: &mut [Three<S>],
        size: &impl Fn(&S) -> f64,
        precision: S::Precision,
    ) -> Option<()> {
        let zero = S::from_number(&Number::ZERO, precision);
        let count = self.places.len();
        let equation = |(at, (v, _)): (usize, &(Direction, Order))| -> Vec<S> {
            let mut equation = vec![zero.clone(); count];
            let mut others: Direction = Vec::new();
            for (i, x) in v {
                match self.places.iter().position(|place| place == i) {
                    Some(p) => equation[p] = x.in_numbers(precision),
                    None => others.push((*i, x.clone())),
                }
            }
            let rows = parts.iter().flatten();
            equation.extend(rows.map(|row| row[self.places[at]].sub(&product(&others, |i| &row[i], precision))));
            equation
        };
        let mut equations: Vec<Vec<S>> = self.directions.iter().enumerate().map(equation).collect();
        solve_for(&mut equations, 0..count, size, precision)?;
        for (number, row) in parts.iter_mut().flatten().enumerate() {
            for (place, own) in self.places.iter().zip(&equations) {
                row[*place] = own[count + number].clone();
            }
        }
        Some(())
    }

    /// Takes the directions that springs hold out of the velocities in the rows of the others, `parts`, and gives M'⁻ᵀ D for each of these:
    /// with `own` the rows r = s D + S of the directions, less s D S⁻¹ r, which leaves the determinant as it is and gives the
    /// others M' = M - D S⁻¹ D. `None` where S or M' is not shown to be regular.
    fn uncouple<S: Scalar>(
        &self,
        parts: &mut [Three<S>],
        others: &[usize],
        own: &[[Vec<S>; 2]],
        coupled: &[usize],
        size: &impl Fn(&S) -> f64,
        precision: S::Precision,
    ) -> Option<Vec<Vec<S>>> {
        if coupled.is_empty() {
            return Some(Vec::new());
        }
        let places: Vec<usize> = coupled.iter().map(|at| self.places[*at]).collect();
        // Sᵀ X = Dᵀ, with a column for each of the others.
        let row = |column: &usize| {
            let spring = coupled.iter().map(|at| own[*at][1][*column].clone());
            spring.chain(parts.iter().map(|part| part[1][*column].clone())).collect()
        };
        let mut factors: Vec<Vec<S>> = places.iter().map(row).collect();
        solve_for(&mut factors, 0..coupled.len(), size, precision)?;
        for (o, [mass, velocity, _]) in parts.iter_mut().enumerate() {
            for (at, factor) in coupled.iter().zip(&factors) {
                let factor = factor[coupled.len() + o].neg();
                *mass = plus(mass, &factor, &own[*at][0]);
                *velocity = plus(velocity, &factor, &own[*at][1]);
            }
        }
        let row = |column: &usize| {
            let mass = parts.iter().map(|part| part[0][*column].clone());
            mass.chain(coupled.iter().map(|at| own[*at][0][*column].clone())).collect()
        };
        let mut thirds: Vec<Vec<S>> = others.iter().map(row).collect();
        solve_for(&mut thirds, 0..others.len(), size, precision)?;
        thirds.iter_mut().for_each(|row| drop(row.drain(..others.len())));
        Some(thirds)
    }
}

fn times<S: Scalar>(row: &[S], factor: &S) -> Vec<S> {
    row.iter().map(|entry| entry.mul(factor)).collect()
}

/// row + factor * other.
fn plus<S: Scalar>(row: &[S], factor: &S, other: &[S]) -> Vec<S> {
    let entry = |(x, y): (&S, &S)| match factor.is_exact_zero() || y.is_exact_zero() {
        true => x.clone(),
        false => x.add(&factor.mul(y)),
    };
    row.iter().zip(other).map(entry).collect()
}
