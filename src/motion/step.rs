//! A step of the Taylor method for M q'' + h = Jᵀ mu with c(q) = 0.
//!
//! Coefficients of q and q' follow each other order by order: those of M, h, J and gamma up to the k-th give q''_k from one
//! linear system, whose matrix is that of order 0 in every order (A. Griewank and A. Walther, Evaluating Derivatives, 2nd ed.
//! (2008), chapter 13). The length of a step is what the last two terms allow (À. Jorba and M. Zou, Experimental Mathematics 14
//! (2005) 99). The polynomials are their own dense output. Time is counted in a power of two near the length of the step, so that
//! coefficients of molecules and planets alike are of moderate size.

use super::equations::Equations;
use crate::expr::{Prepared, Series};
use crate::precision::{Ball, Scalar};

/// Numbers that motions are computed in. Nothing is proved of them: enclosures are cut down to their middle after each
/// step.
pub(super) trait Real: Scalar<Precision = ()> {
    /// A double, exactly.
    fn exact(value: f64) -> Self;
    /// The middle of an enclosure.
    fn from_ball(value: &Ball) -> Self;
    /// The nearest double.
    fn middle(&self) -> f64;
    /// Without what is known about errors.
    fn centred(&self) -> Self;
}

impl Real for f64 {
    fn exact(value: f64) -> Self {
        value
    }

    fn from_ball(value: &Ball) -> Self {
        value.mid_f64()
    }

    fn middle(&self) -> f64 {
        *self
    }

    fn centred(&self) -> Self {
        *self
    }
}

impl Real for Ball {
    fn exact(value: f64) -> Self {
        Ball::exact(value)
    }

    fn from_ball(value: &Ball) -> Self {
        Ball::new(value.mid, 0.0)
    }

    fn middle(&self) -> f64 {
        self.mid_f64()
    }

    fn centred(&self) -> Self {
        Ball::new(self.mid, 0.0)
    }
}

/// Steps of some order, with what is left out of each beside the size of each coordinate.
pub(super) struct Stepper<'a, S: Real> {
    equations: &'a Equations,
    order: usize,
    tolerance: f64,
    series: Series<S>,
    surface: Prepared<S>,
    scratch: Vec<S>,
    /// By order: coordinates, velocities, accelerations, multipliers, M and J.
    positions: Vec<Vec<S>>,
    velocities: Vec<Vec<S>>,
    accelerations: Vec<Vec<S>>,
    multipliers: Vec<Vec<S>>,
    mass: Vec<Vec<S>>,
    gradients: Vec<Vec<S>>,
    inputs: Vec<S>,
    right: Vec<S>,
    matrix: Option<Matrix<S>>,
    /// The unit of time of the coefficients, and that of the next step; 0 before the first one.
    unit: f64,
    next_unit: f64,
}

/// Why there is no step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Trouble {
    /// M, with the constraints, has no inverse.
    Singular,
    /// Something is no number.
    NotFinite,
    /// The solution ends, or the constraints can't be kept.
    NoStep,
}

/// How often a point is brought back to the constraints at most.
const MOST_CORRECTIONS: usize = 8;

impl<'a, S: Real> Stepper<'a, S> {
    pub(super) fn new(equations: &'a Equations, order: usize, tolerance: f64) -> Self {
        let zero = S::exact(0.0);
        let (n, c) = (equations.coordinates, equations.constraints);
        let rows = |count: usize| vec![vec![zero.clone(); count]; order + 1];
        Self {
            equations,
            order,
            tolerance,
            series: equations.tape.prepare::<S>(()).series(),
            surface: equations.surface.prepare::<S>(()),
            scratch: Vec::new(),
            positions: rows(n),
            velocities: rows(n),
            accelerations: rows(n),
            multipliers: rows(c),
            mass: rows(equations.mass.len()),
            gradients: rows(equations.gradients.len()),
            inputs: vec![zero.clone(); 1 + 2 * n],
            right: vec![zero; n + c],
            matrix: None,
            unit: 1.0,
            next_unit: 0.0,
        }
    }

    /// The coefficients about a state, which is brought back to the constraints first, and a length for the step, of
    /// which `longest` is needed at most.
    pub(super) fn expand(
        &mut self,
        t: &S,
        q: &mut [S],
        v: &mut [S],
        longest: f64,
    ) -> Result<f64, Trouble> {
        self.correct(t, q, v)?;
        self.positions[0].clone_from_slice(q);
        self.velocities[0].clone_from_slice(v);
        if self.next_unit == 0.0 {
            self.unit = 1.0;
            self.coefficients(t, FIRST.min(self.order))?;
            self.next_unit = power_of_two(1.0 / self.rate());
        }
        let mut left = MOST_UNITS;
        loop {
            self.unit = self.next_unit;
            left -= 1;
            let length = match self.coefficients(t, self.order) {
                Ok(()) => self.length()?,
                Err(Trouble::NotFinite) if left > 0 => {
                    self.next_unit = self.unit / FAR_OFF;
                    continue;
                }
                Err(trouble) => return Err(trouble),
            };
            let reach = length * self.unit;
            self.next_unit = power_of_two(reach.min(longest));
            // Within this no coefficient that matters has got lost below the smallest double.
            let off = self.next_unit / self.unit;
            if left == 0 || (1.0 / FAR_OFF..=FAR_OFF).contains(&off) {
                return Ok(reach);
            }
        }
    }

    /// All coefficients up to an order.
    fn coefficients(&mut self, t: &S, order: usize) -> Result<(), Trouble> {
        self.series.clear();
        let unit = S::exact(self.unit);
        for k in 0..order {
            self.advance(k, t)?;
            let (done, open) = self.velocities.split_at_mut(k + 1);
            let (_, next) = self.positions.split_at_mut(k + 1);
            let share = unit.div(&S::exact(count(k + 1)));
            for (i, x) in open[0].iter_mut().enumerate() {
                *x = self.accelerations[k][i].mul(&share);
            }
            for (i, x) in next[0].iter_mut().enumerate() {
                *x = done[k][i].mul(&share);
            }
        }
        Ok(())
    }

    /// About how fast the state changes, from the first coefficients in units of 1; 1 where nothing does.
    fn rate(&self) -> f64 {
        let mut rate = 0.0_f64;
        for rows in [&self.positions, &self.velocities] {
            for later in 1..=FIRST.min(self.order) {
                for earlier in 0..later {
                    for (x, y) in rows[earlier].iter().zip(&rows[later]) {
                        let ratio = y.middle().abs() / x.middle().abs();
                        let root = ratio.powf(1.0 / count(later - earlier));
                        if root.is_finite() {
                            rate = rate.max(root);
                        }
                    }
                }
            }
        }
        if rate > 0.0 { rate } else { 1.0 }
    }

    /// q''_k and mu_k.
    fn advance(&mut self, k: usize, t: &S) -> Result<(), Trouble> {
        let (n, c) = (self.equations.coordinates, self.equations.constraints);
        self.inputs[0] = match k {
            0 => t.clone(),
            1 => S::exact(self.unit),
            _ => S::exact(0.0),
        };
        self.inputs[1..=n].clone_from_slice(&self.positions[k]);
        self.inputs[n + 1..].clone_from_slice(&self.velocities[k]);
        let out = self.series.next(&self.inputs);
        let (mass, rest) = out.split_at(self.equations.mass.len());
        let (load, rest) = rest.split_at(n);
        let (gradients, bend) = rest.split_at(self.equations.gradients.len());
        self.mass[k].clone_from_slice(mass);
        self.gradients[k].clone_from_slice(gradients);
        for (right, left) in self.right.iter_mut().zip(load.iter().chain(bend)) {
            *right = left.neg();
        }
        if k == 0 && (self.matrix.is_none() || !self.equations.constant) {
            self.matrix = Some(self.factored()?);
        }
        if !self.equations.constant {
            for j in 1..=k {
                let (a, mu) = (&self.accelerations[k - j], &self.multipliers[k - j]);
                for ((row, column), entry) in self.equations.mass.iter().zip(&self.mass[j]) {
                    if entry.is_exact_zero() {
                        continue;
                    }
                    self.right[*row] = self.right[*row].sub(&entry.mul(&a[*column]));
                    if row != column {
                        self.right[*column] = self.right[*column].sub(&entry.mul(&a[*row]));
                    }
                }
                for ((row, i), entry) in self.equations.gradients.iter().zip(&self.gradients[j]) {
                    if entry.is_exact_zero() {
                        continue;
                    }
                    self.right[n + row] = self.right[n + row].sub(&entry.mul(&a[*i]));
                    // The force is Jᵀ mu, on the right side.
                    self.right[*i] = self.right[*i].add(&entry.mul(&mu[*row]));
                }
            }
        }
        let Some(matrix) = &self.matrix else {
            return Err(Trouble::Singular);
        };
        matrix.solve(&mut self.right);
        self.accelerations[k].clone_from_slice(&self.right[..n]);
        self.multipliers[k].clone_from_slice(&self.right[n..n + c]);
        if self.right.iter().all(S::is_finite) {
            Ok(())
        } else {
            Err(Trouble::NotFinite)
        }
    }

    /// M with -Jᵀ and J beside it, at order 0.
    fn factored(&self) -> Result<Matrix<S>, Trouble> {
        let (n, c) = (self.equations.coordinates, self.equations.constraints);
        let diagonal = c == 0 && self.equations.mass.iter().all(|(i, j)| i == j);
        if diagonal {
            let mut entries = vec![S::exact(0.0); n];
            for ((i, _), value) in self.equations.mass.iter().zip(&self.mass[0]) {
                entries[*i] = value.clone();
            }
            let fine = entries.iter().all(|x| x.middle() != 0.0 && x.is_finite());
            return if fine {
                Ok(Matrix::Diagonal(entries))
            } else {
                Err(Trouble::Singular)
            };
        }
        let order = n + c;
        let mut rows = vec![S::exact(0.0); order * order];
        for ((i, j), value) in self.equations.mass.iter().zip(&self.mass[0]) {
            rows[order * i + j] = value.clone();
            rows[order * j + i] = value.clone();
        }
        for ((a, i), value) in self.equations.gradients.iter().zip(&self.gradients[0]) {
            rows[order * i + n + a] = value.neg();
            rows[order * (n + a) + i] = value.clone();
        }
        Matrix::factored(rows, order)
    }

    /// Brings a state back to c = 0 and c' = 0, along the directions of constraint forces.
    fn correct(&mut self, t: &S, q: &mut [S], v: &mut [S]) -> Result<(), Trouble> {
        let (n, c) = (self.equations.coordinates, self.equations.constraints);
        if c == 0 {
            return Ok(());
        }
        let mut before = f64::INFINITY;
        for _ in 0..MOST_CORRECTIONS {
            self.positions[0].clone_from_slice(q);
            self.velocities[0].clone_from_slice(v);
            self.series.clear();
            // Order 0 leaves the factors of the matrix here.
            self.advance(0, t)?;
            let Some(matrix) = &self.matrix else {
                return Err(Trouble::Singular);
            };
            let gaps = self.surface.evaluate(&self.inputs, &mut self.scratch);
            let mut moved = 0.0_f64;
            for (state, gaps) in [(&mut *q, &gaps[..c]), (&mut *v, &gaps[c..])] {
                let mut step = vec![S::exact(0.0); n + c];
                for (a, gap) in gaps.iter().enumerate() {
                    step[n + a] = gap.neg().centred();
                }
                matrix.solve(&mut step);
                let largest = state
                    .iter()
                    .map(|x| x.middle().abs())
                    .fold(1e-300, f64::max);
                for (x, step) in state.iter_mut().zip(&step) {
                    *x = x.add(step).centred();
                    moved = moved.max(step.middle().abs() / largest);
                }
            }
            if !moved.is_finite() {
                return Err(Trouble::NotFinite);
            }
            // Rounding is reached where it gets no smaller.
            if moved <= self.tolerance || (moved >= 0.5 * before && moved < 1e-12) {
                return Ok(());
            }
            before = moved;
        }
        Err(Trouble::NoStep)
    }

    /// A length in units of time at which the last two terms are what is allowed beside the size of each coordinate.
    fn length(&self) -> Result<f64, Trouble> {
        let mut length = f64::INFINITY;
        for (rows, degree) in [(&self.positions, 2), (&self.velocities, 1)] {
            let coordinates = 0..self.equations.coordinates;
            length = coordinates.fold(length, |length, i| {
                let sizes = |k: usize| rows[k][i].middle().abs();
                let last = [self.order - 1, self.order].into_iter();
                last.fold(length, |length, k| {
                    length.min(self.reach(&sizes, k, degree, length))
                })
            });
        }
        if length.is_nan() || length <= 0.0 {
            return Err(Trouble::NoStep);
        }
        Ok(length)
    }

    /// Where the k-th term of a coordinate is what is allowed beside the largest that the coordinate gets on the way, which
    /// its terms up to a degree tell about. `length` stands for what is not known better.
    fn reach(&self, sizes: &dyn Fn(usize) -> f64, k: usize, degree: i32, length: f64) -> f64 {
        let last = sizes(k);
        let mut own = f64::INFINITY;
        if last == 0.0 {
            return own;
        }
        let mut size = sizes(0);
        for _ in 0..3 {
            own = if size > 0.0 {
                (self.tolerance * size / last).powf(1.0 / count(k))
            } else {
                f64::INFINITY
            };
            let reach = own.min(length);
            size = if reach.is_finite() {
                (0..=degree).zip(0..).fold(0.0, |most, (power, term)| {
                    f64::max(most, sizes(term) * reach.powi(power))
                })
            } else {
                sizes(1).max(sizes(2))
            };
        }
        own
    }

    /// Coordinates and velocities at a time after that of the expansion.
    pub(super) fn at(&self, after: &S) -> (Vec<S>, Vec<S>) {
        let after = after.div(&S::exact(self.unit));
        let sum = |rows: &[Vec<S>], i: usize| {
            let mut value = rows[self.order][i].clone();
            for row in rows[..self.order].iter().rev() {
                value = value.mul(&after).add(&row[i]);
            }
            value.centred()
        };
        let n = self.equations.coordinates;
        (
            (0..n).map(|i| sum(&self.positions, i)).collect(),
            (0..n).map(|i| sum(&self.velocities, i)).collect(),
        )
    }
}

/// So many coefficients tell the unit of time to begin with.
const FIRST: usize = 4;
/// Attempts at a unit of time.
const MOST_UNITS: usize = 8;
/// Steps that are so many units long, or a unit so many steps, have another unit.
const FAR_OFF: f64 = 1_048_576.0;

/// The nearest one.
fn power_of_two(value: f64) -> f64 {
    let power = value.log2().round();
    if power.is_finite() {
        power.clamp(-900.0, 900.0).exp2()
    } else {
        1.0
    }
}

#[allow(clippy::cast_precision_loss)] // orders are small
fn count(k: usize) -> f64 {
    k as f64
}

/// A matrix that equations are solved with again and again.
enum Matrix<S> {
    Diagonal(Vec<S>),
    /// L and U in one, row by row, and which row each one was.
    Full {
        order: usize,
        entries: Vec<S>,
        rows: Vec<usize>,
    },
}

impl<S: Real> Matrix<S> {
    /// Elimination with partial pivoting, rows scaled by their largest entries.
    fn factored(mut entries: Vec<S>, order: usize) -> Result<Self, Trouble> {
        let size = |x: &S| x.middle().abs();
        let mut rows: Vec<usize> = (0..order).collect();
        let mut scales: Vec<f64> = entries
            .chunks(order.max(1))
            .map(|row| row.iter().map(size).fold(0.0, f64::max))
            .collect();
        for k in 0..order {
            let pivot = (k..order).max_by(|a, b| {
                let of = |row: usize| size(&entries[order * row + k]) / scales[row];
                of(*a).total_cmp(&of(*b))
            });
            let pivot = pivot.unwrap_or(k);
            let value = size(&entries[order * pivot + k]);
            if !(value > 0.0 && value.is_finite()) {
                return Err(Trouble::Singular);
            }
            if pivot != k {
                for column in 0..order {
                    entries.swap(order * pivot + column, order * k + column);
                }
                rows.swap(pivot, k);
                scales.swap(pivot, k);
            }
            for row in k + 1..order {
                if entries[order * row + k].is_exact_zero() {
                    continue;
                }
                let factor = entries[order * row + k].div(&entries[order * k + k]);
                for column in k + 1..order {
                    let above = &entries[order * k + column];
                    if !above.is_exact_zero() {
                        let part = factor.mul(above);
                        entries[order * row + column] = entries[order * row + column].sub(&part);
                    }
                }
                entries[order * row + k] = factor;
            }
        }
        Ok(Self::Full {
            order,
            entries,
            rows,
        })
    }

    fn solve(&self, right: &mut [S]) {
        match self {
            Self::Diagonal(entries) => {
                for (x, entry) in right.iter_mut().zip(entries) {
                    *x = x.div(entry);
                }
            }
            Self::Full {
                order,
                entries,
                rows,
            } => {
                let mut x: Vec<S> = rows.iter().map(|row| right[*row].clone()).collect();
                for i in 0..*order {
                    for j in 0..i {
                        let entry = &entries[order * i + j];
                        if !entry.is_exact_zero() {
                            x[i] = x[i].sub(&entry.mul(&x[j]));
                        }
                    }
                }
                for i in (0..*order).rev() {
                    for j in i + 1..*order {
                        let entry = &entries[order * i + j];
                        if !entry.is_exact_zero() {
                            x[i] = x[i].sub(&entry.mul(&x[j]));
                        }
                    }
                    x[i] = x[i].div(&entries[order * i + i]);
                }
                right[..*order].clone_from_slice(&x);
            }
        }
    }
}
