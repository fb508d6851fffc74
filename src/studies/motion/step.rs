//! A step of the Taylor method for M q'' + h = Jᵀ mu with c(q) = 0.
//!
//! Coefficients of q and q' follow each other order by order: those of M, h, J and gamma up to the k-th give q''_k from one
//! linear system, whose matrix is that of order 0 in every order (A. Griewank and A. Walther, Evaluating Derivatives, 2nd ed.
//! (2008), chapter 13). How long a step may be, `length` tells. The polynomials are their own dense output. Time is counted in a power of two near the length of the step, so that
//! coefficients of molecules and planets alike are of moderate size.

use super::equations::Equations;
use super::length::{Buffers, allowed};
use super::matrix::Factored;
use crate::flow::{count, horner, nearest_power_of_two};
use librate_core::expr::{Prepared, Series};
use librate_core::precision::{Ball, DoubleDouble, Scalar};

/// Numbers that motions are computed in. Nothing is proved of them.
pub(super) trait Real: Scalar<Precision = ()> + Copy + Default {
    /// A double, exactly.
    fn exact(value: f64) -> Self;
    /// The middle of an enclosure.
    fn from_ball(value: &Ball) -> Self;
    /// The nearest double.
    fn middle(&self) -> f64;
    /// As an enclosure that knows of no error.
    fn to_ball(self) -> Ball;
    /// About the relative error of one operation.
    const ROUNDING: f64;
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

    fn to_ball(self) -> Ball {
        Ball::exact(self)
    }

    const ROUNDING: f64 = 1.2e-16;
}

impl Real for DoubleDouble {
    fn exact(value: f64) -> Self {
        DoubleDouble::exact(value)
    }

    fn from_ball(value: &Ball) -> Self {
        value.mid
    }

    fn middle(&self) -> f64 {
        self.hi
    }

    fn to_ball(self) -> Ball {
        Ball::from(self)
    }

    const ROUNDING: f64 = 1e-31;
}

/// Where a kink is passed.
#[derive(Clone, Copy)]
struct Crossing<S> {
    /// The number of the absolute value.
    at: usize,
    /// Whether it is before the first place of the step that is looked at.
    is_at_start: bool,
    when: S,
}

/// Steps of some order, with what is left out of each beside the size of each coordinate.
pub(super) struct Stepper<'a, S: Real> {
    pub(super) equations: &'a Equations,
    /// So many terms behind its first one tell a coordinate.
    pub(super) terms: usize,
    /// The order of the step: more than that where coordinates begin with high powers of the time.
    pub(super) order: usize,
    /// Coordinates that higher orders did not move either.
    resting: usize,
    pub(super) tolerance: f64,
    pub(super) allowed: Vec<f64>,
    pub(super) buffers: Buffers<S>,
    series: Series<S>,
    pub(super) values: Prepared<S>,
    surface: Prepared<S>,
    speeds: Prepared<S>,
    pub(super) scratch: Vec<S>,
    /// The coefficients of each coordinate, velocity, acceleration, multiplier and entry of M and J, in rows.
    pub(super) positions: Vec<Vec<S>>,
    pub(super) velocities: Vec<Vec<S>>,
    pub(super) accelerations: Vec<Vec<S>>,
    pub(super) multipliers: Vec<Vec<S>>,
    mass: Vec<Vec<S>>,
    gradients: Vec<Vec<S>>,
    /// What absolute values are taken of, in rows, and the signs that these have in the step; none before the first one.
    kinks: Vec<Vec<S>>,
    pub(super) signs: Vec<f64>,
    /// The one whose kink the last step ended at.
    fresh: Option<usize>,
    inputs: Vec<S>,
    right: Vec<S>,
    matrix: Option<Factored<S>>,
    /// The unit of time of the coefficients, and that of the next step; 0 before the first one.
    pub(super) unit: f64,
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
    /// An absolute value has its kink, and forces from both sides lead to it.
    Kink,
    /// The start is at the kink of an absolute value, and several motions begin there.
    Fork,
    /// There the momentum or the energy would jump.
    Impact,
}

/// What is left of a jump half way to a kink is rounding there.
const LEAST_JUMP: f64 = 1e-3;

/// Coefficients of motions that begin at one place are the same up to this part of them.
const SAME: f64 = 1e-9;

/// How often a point is brought back to the constraints at most.
const MOST_CORRECTIONS: usize = 8;

impl<'a, S: Real> Stepper<'a, S> {
    pub(super) fn new(equations: &'a Equations, terms: usize, tolerance: f64) -> Self {
        let zero = S::exact(0.0);
        let (n, m, c) = (equations.coordinates, equations.free.len(), equations.constraints);
        let rows = |count: usize| vec![vec![zero; terms + 1]; count];
        let values = equations.tape.prepare::<S>(());
        Self {
            equations,
            terms,
            order: terms,
            resting: 0,
            tolerance,
            allowed: allowed(terms, tolerance),
            buffers: Buffers::default(),
            series: values.series(),
            values,
            surface: equations.surface.prepare::<S>(()),
            speeds: equations.speeds.prepare::<S>(()),
            scratch: Vec::new(),
            positions: rows(n),
            velocities: rows(n),
            accelerations: rows(m),
            multipliers: rows(c),
            mass: rows(equations.mass.len()),
            gradients: rows(equations.gradients.len()),
            kinks: rows(equations.kinks.outputs()),
            signs: Vec::new(),
            fresh: None,
            inputs: vec![zero; 1 + 2 * n + equations.kinks.outputs()],
            right: vec![zero; m + c],
            matrix: None,
            unit: 1.0,
            next_unit: 0.0,
        }
    }

    /// The coefficients about a state, which is brought back to the constraints first, and a length for the step, of
    /// which `longest` is needed at most.
    pub(super) fn expand(&mut self, t: &S, q: &mut [S], v: &mut [S], longest: f64) -> Result<f64, Trouble> {
        if self.signs.is_empty() {
            self.settle_signs(t, q, v)?;
        }
        self.correct(t, q, v)?;
        self.begin(q, v);
        if self.next_unit == 0.0 {
            self.unit = 1.0;
            self.coefficients(t, 0..FIRST.min(self.order))?;
            self.next_unit = nearest_power_of_two(1.0 / self.rate());
        }
        let mut left = MOST_UNITS;
        loop {
            self.unit = self.next_unit;
            left -= 1;
            let length = match self.whole(t) {
                Ok(()) => self.length()?,
                Err(Trouble::NotFinite) if left > 0 => {
                    self.next_unit = self.unit / FAR_OFF;
                    continue;
                }
                Err(trouble) => return Err(trouble),
            };
            let reach = length * self.unit;
            self.next_unit = nearest_power_of_two(reach.min(longest));
            // Within this no coefficient that matters has got lost below the smallest double.
            let off = self.next_unit / self.unit;
            let far_off = (FAR_OFF_IN_ALL / count(self.order)).exp2().min(FAR_OFF);
            if left == 0 || (1.0 / far_off..=far_off).contains(&off) {
                return Ok(reach);
            }
        }
    }

    /// The signs at the start. Where something begins with 0, its sign is the one that it gets when it moves with that
    /// sign; a place that draws everything back to it has none, and one that lets go to both sides has no single one.
    fn settle_signs(&mut self, t: &S, q: &[S], v: &[S]) -> Result<(), Trouble> {
        let count = self.kinks.len();
        if count == 0 {
            return Ok(());
        }
        let inputs = [t].into_iter().chain(q).chain(v).cloned().collect::<Vec<S>>();
        let values = self.equations.kinks.prepare::<S>(()).evaluate(&inputs, &mut self.scratch);
        self.signs = values.iter().map(|x| sign(x.middle())).collect();
        let open: Vec<usize> = (0..count).filter(|at| values[*at].middle() == 0.0).collect();
        if open.len() > MOST_OPEN_SIGNS {
            return Err(Trouble::Kink);
        }
        let mut found: Option<(Vec<f64>, Vec<S>)> = None;
        for choice in 0..1_usize << open.len() {
            for (place, at) in open.iter().enumerate() {
                self.signs[*at] = if choice >> place & 1 == 0 { 1.0 } else { -1.0 };
            }
            self.begin(q, v);
            self.unit = 1.0;
            self.coefficients(t, 0..FIRST.min(self.order))?;
            let own = |at: &usize| {
                let first = self.kinks[*at].iter().take(FIRST).map(Real::middle).find(|x| *x != 0.0);
                first.is_none_or(|x| x * self.signs[*at] > 0.0)
            };
            if !open.iter().all(own) {
                continue;
            }
            let motion: Vec<S> = self.positions.iter().flat_map(|row| &row[..FIRST.min(row.len())]).copied().collect();
            let is_same = |(a, b): (&S, &S)| a.sub(b).middle().abs() <= SAME * a.middle().abs().max(b.middle().abs());
            match &found {
                None => found = Some((self.signs.clone(), motion)),
                Some((_, other)) if motion.iter().zip(other).all(is_same) => {}
                Some(_) => return Err(Trouble::Fork),
            }
        }
        self.signs = found.ok_or(Trouble::Kink)?.0;
        Ok(())
    }

    /// Where within a length the first absolute value has its kink, if one has: the time from the expansion, behind which its
    /// sign is the other one.
    ///
    /// It is searched for at places of the step and, between two of these, where the value has a minimum.
    pub(super) fn kink(&mut self, length: f64) -> Result<Option<S>, Trouble> {
        if self.kinks.is_empty() {
            return Ok(None);
        }
        let fresh = self.fresh.take();
        let mut first: Option<Crossing<S>> = None;
        for (at, row) in self.kinks.iter().enumerate() {
            let of = |row: &[S], after: f64| self.signs[at] * horner(row, &S::exact(after / self.unit)).middle();
            let value = |after: f64| of(row, after);
            let slopes: Vec<S> = (1..).zip(&row[1..]).map(|(k, own)| own.mul(&S::exact(count(k)))).collect();
            // The lowest place between two, where the value is below 0 by more than rounding.
            let dip = |mut low: f64, mut high: f64| {
                if !(of(&slopes, low) < 0.0 && of(&slopes, high) > 0.0) {
                    return None;
                }
                let size = value(low).max(row[0].middle().abs()).max((row[1].middle() * high / self.unit).abs());
                for _ in 0..BISECTIONS {
                    let middle = 0.5 * (low + high);
                    if of(&slopes, middle) < 0.0 { low = middle } else { high = middle }
                }
                (value(low) < -LEAST_DIP * S::ROUNDING * size).then_some(low)
            };
            let mut before = 0.0;
            for place in 1..=SAMPLES {
                let after = length * count(place) / count(SAMPLES);
                if first.is_some_and(|known| known.when.middle() <= before) {
                    break;
                }
                if let Some(below) = if value(after) < 0.0 { Some(after) } else { dip(before, after) } {
                    let when = self.crossing(at, before, below);
                    if first.is_none_or(|known| when.sub(&known.when).middle() <= 0.0) {
                        first = Some(Crossing { at, is_at_start: before == 0.0, when });
                    }
                    break;
                }
                before = after;
            }
        }
        let Some(Crossing { at, is_at_start, when }) = first else { return Ok(None) };
        // It turns back at once: forces on both sides lead to the kink.
        let turns_back = self.signs[at] * self.kinks[at][1].middle() < 0.0;
        if is_at_start && turns_back && fresh == Some(at) {
            return Err(Trouble::Kink);
        }
        self.signs[at] = -self.signs[at];
        self.fresh = Some(at);
        Ok(Some(when))
    }

    /// Whether momenta and the energy go on at the kink that the last step ended at: where they jump, velocities would have to. What its
    /// sign makes of them half way there has gone to 0.
    pub(super) fn passes(&mut self, half_way: (S, [&[S]; 2]), there: (S, [&[S]; 2])) -> bool {
        let Some(at) = self.fresh else { return true };
        let tape = self.equations.jumps.prepare::<S>(());
        let mut jumps = |(t, state): (S, [&[S]; 2])| -> Vec<f64> {
            let [one, other] = [1.0, -1.0].map(|side| {
                let signs = self.signs.iter().enumerate().map(|(i, own)| S::exact(if i == at { side } else { *own }));
                let inputs: Vec<S> = [t].into_iter().chain(state.concat()).chain(signs).collect();
                tape.evaluate(&inputs, &mut self.scratch)
            });
            one.iter().zip(&other).map(|(a, b)| a.sub(b).middle().abs()).collect()
        };
        let (before, after) = (jumps(half_way), jumps(there));
        before.iter().zip(after).all(|(before, after)| after <= LEAST_JUMP * before)
    }

    /// Where between two times what an absolute value is taken of changes its sign, on the side behind.
    fn crossing(&self, at: usize, low: f64, high: f64) -> S {
        let unit = S::exact(self.unit);
        let (mut low, mut high) = (S::exact(low), S::exact(high));
        for _ in 0..BISECTIONS {
            let middle = low.add(&high).mul(&S::exact(0.5));
            if self.signs[at] * horner(&self.kinks[at], &middle.div(&unit)).middle() < 0.0 {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }

    /// Writes the state to order 0.
    fn begin(&mut self, q: &[S], v: &[S]) {
        for (rows, values) in [(&mut self.positions, q), (&mut self.velocities, v)] {
            for (row, value) in rows.iter_mut().zip(values) {
                row[0] = *value;
            }
        }
    }

    /// All coefficients of a step. Along a chain that is pulled at its end the powers of the time that its members begin with
    /// count up: the order follows them.
    fn whole(&mut self, t: &S) -> Result<(), Trouble> {
        self.set_order(self.terms);
        self.coefficients(t, 0..self.terms)?;
        loop {
            let (latest, resting) = self.beginnings();
            let late = latest > self.terms / LATE;
            let unknown = resting != self.resting;
            let known = self.order;
            let order = match (unknown, late) {
                (true, _) => known + self.terms,
                (false, true) => self.terms + latest,
                (false, false) => self.terms,
            };
            let order = order.min(self.terms + LATEST);
            if order <= known {
                return Ok(());
            }
            self.set_order(order);
            if let Err(trouble) = self.coefficients(t, known..order) {
                self.set_order(known);
                return if self.series.is_spent() { Err(trouble) } else { Ok(()) };
            }
            if unknown && self.beginnings().1 == resting {
                self.resting = resting;
            }
        }
    }

    /// The latest power of the time that a coordinate begins with, and how many have none.
    fn beginnings(&self) -> (usize, usize) {
        let (mut latest, mut resting) = (0, 0);
        for row in &self.positions {
            match beginning(row) {
                Some(first) => latest = latest.max(first),
                None => resting += 1,
            }
        }
        (latest, resting)
    }

    fn set_order(&mut self, order: usize) {
        if order == self.order {
            return;
        }
        self.order = order;
        let state = [&mut self.positions, &mut self.velocities, &mut self.accelerations, &mut self.multipliers];
        let rest = [&mut self.mass, &mut self.gradients, &mut self.kinks];
        for row in state.into_iter().chain(rest).flatten() {
            row.resize(order + 1, S::exact(0.0));
        }
    }

    /// The coefficients behind those of the orders that are known.
    fn coefficients(&mut self, t: &S, orders: std::ops::Range<usize>) -> Result<(), Trouble> {
        if orders.start == 0 {
            self.series.clear();
        }
        let unit = S::exact(self.unit);
        for k in orders {
            self.advance(k, t)?;
            let share = unit.div(&S::exact(count(k + 1)));
            for (i, a) in self.equations.free.iter().zip(&self.accelerations) {
                self.velocities[*i][k + 1] = a[k].mul(&share);
            }
            for (row, v) in self.positions.iter_mut().zip(&self.velocities) {
                row[k + 1] = v[k].mul(&share);
            }
        }
        Ok(())
    }

    /// About how fast the state changes, from the first coefficients in units of 1; 1 where nothing does.
    fn rate(&self) -> f64 {
        let mut rate = 0.0_f64;
        for rows in [&self.positions, &self.velocities] {
            for row in rows {
                for later in 1..=FIRST.min(self.order) {
                    for earlier in 0..later {
                        let ratio = row[later].middle().abs() / row[earlier].middle().abs();
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

    /// q''_k and mu_k, and the velocities that follow.
    fn advance(&mut self, k: usize, t: &S) -> Result<(), Trouble> {
        let (n, m) = (self.equations.coordinates, self.equations.free.len());
        self.inputs[0] = match k {
            0 => *t,
            1 => S::exact(self.unit),
            _ => S::exact(0.0),
        };
        let rows = self.positions.iter().chain(&self.velocities);
        for (input, row) in self.inputs[1..].iter_mut().zip(rows) {
            *input = row[k];
        }
        let first = 1 + 2 * n;
        for (input, sign) in self.inputs[first..].iter_mut().zip(&self.signs) {
            *input = S::exact(if k == 0 { *sign } else { 0.0 });
        }
        let (mass, rest) = self.series.next(&self.inputs).split_at(self.equations.mass.len());
        let (load, rest) = rest.split_at(m);
        let (gradients, rest) = rest.split_at(self.equations.gradients.len());
        let (bend, rest) = rest.split_at(self.equations.constraints);
        let (speeds, kinks) = rest.split_at(self.equations.bound.len());
        for (i, speed) in self.equations.bound.iter().zip(speeds) {
            self.velocities[*i][k] = *speed;
        }
        for (rows, values) in [(&mut self.mass, mass), (&mut self.gradients, gradients), (&mut self.kinks, kinks)] {
            for (row, value) in rows.iter_mut().zip(values) {
                row[k] = *value;
            }
        }
        for (right, left) in self.right.iter_mut().zip(load.iter().chain(bend)) {
            *right = left.neg();
        }
        if k == 0 && (self.matrix.is_none() || !self.equations.constant) {
            self.matrix = Some(self.factored()?);
        }
        if !self.equations.constant {
            self.move_lower_orders(k);
        }
        let Some(matrix) = &self.matrix else { return Err(Trouble::Singular) };
        matrix.solve(&mut self.right, &mut self.scratch);
        let rows = self.accelerations.iter_mut().chain(&mut self.multipliers);
        for (row, value) in rows.zip(&self.right) {
            row[k] = *value;
        }
        if self.right.iter().all(S::is_finite) { Ok(()) } else { Err(Trouble::NotFinite) }
    }

    /// Takes what is known of the k-th coefficients of M q'' and Jᵀ mu, J q'' to the right: that is all of them but M_0 q''_k
    /// and its like.
    fn move_lower_orders(&mut self, k: usize) {
        let n = self.equations.free.len();
        let Self { equations, series, right, accelerations, multipliers, .. } = self;
        // Σ_(j=1..k) e_j x_(k-j), for an entry that is constant beyond its order 0 in `live`.
        let known = |entry: &[S], live: usize, x: &[S]| {
            let end = live.min(k + 1);
            let entry = entry.get(1..end)?;
            S::convolution(entry, x.get(k + 1 - end..k)?)
        };
        let mass = equations.mass.iter().zip(&self.mass).enumerate();
        for (at, ((row, column), entry)) in mass {
            let live = series.live(at);
            if let Some(part) = known(entry, live, &accelerations[*column]) {
                right[*row] = right[*row].sub(&part);
            }
            if row != column
                && let Some(part) = known(entry, live, &accelerations[*row])
            {
                right[*column] = right[*column].sub(&part);
            }
        }
        let first = equations.mass.len() + n;
        let gradients = equations.gradients.iter().zip(&self.gradients).enumerate();
        for (at, ((row, i), entry)) in gradients {
            let live = series.live(first + at);
            if let Some(part) = known(entry, live, &accelerations[*i]) {
                right[n + row] = right[n + row].sub(&part);
            }
            // The force is Jᵀ mu, on the right side.
            if let Some(part) = known(entry, live, &multipliers[*row]) {
                right[*i] = right[*i].add(&part);
            }
        }
    }

    /// M with -Jᵀ and J beside it, at order 0.
    fn factored(&self) -> Result<Factored<S>, Trouble> {
        let (n, c) = (self.equations.free.len(), self.equations.constraints);
        let diagonal = c == 0 && self.equations.mass.iter().all(|(i, j)| i == j);
        if diagonal {
            let mut entries = vec![S::exact(0.0); n];
            for ((i, _), row) in self.equations.mass.iter().zip(&self.mass) {
                entries[*i] = row[0];
            }
            let fine = entries.iter().all(|x| x.middle() != 0.0 && x.is_finite());
            return if fine { Ok(Factored::Diagonal(entries)) } else { Err(Trouble::Singular) };
        }
        Factored::new(self.equations.bordered(S::exact(0.0), |at| self.mass[at][0], |at| self.gradients[at][0]))
    }

    /// Brings a state back to c = 0 and c' = 0, along the directions of constraint forces.
    fn correct(&mut self, t: &S, q: &mut [S], v: &mut [S]) -> Result<(), Trouble> {
        let (n, c) = (self.equations.coordinates, self.equations.constraints);
        if c == 0 {
            return Ok(());
        }
        let mut before = f64::INFINITY;
        for _ in 0..MOST_CORRECTIONS {
            self.begin(q, v);
            self.series.clear();
            // Order 0 leaves the factors of the matrix here.
            self.advance(0, t)?;
            let Some(matrix) = &self.matrix else { return Err(Trouble::Singular) };
            let gaps = self.surface.evaluate(&self.inputs, &mut self.scratch);
            let mut moved = 0.0_f64;
            for (state, gaps) in [(&mut *q, &gaps[..c]), (&mut *v, &gaps[c..])] {
                let mut step = vec![S::exact(0.0); n + c];
                for (a, gap) in gaps.iter().enumerate() {
                    step[n + a] = gap.neg();
                }
                matrix.solve(&mut step, &mut self.scratch);
                let largest = state.iter().map(|x| x.middle().abs()).fold(1e-300, f64::max);
                for (x, step) in state.iter_mut().zip(&step) {
                    *x = x.add(step);
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

    /// Coordinates and velocities at a time after that of the expansion. Velocities that follow do so there, too.
    pub(super) fn at(&mut self, t: &S, after: &S) -> (Vec<S>, Vec<S>) {
        let place = after.div(&S::exact(self.unit));
        let values = |rows: &[Vec<S>]| rows.iter().map(|row| horner(row, &place)).collect::<Vec<S>>();
        let (positions, mut velocities) = (values(&self.positions), values(&self.velocities));
        if !self.equations.bound.is_empty() {
            let inputs = [vec![t.add(after)], positions.clone(), velocities.clone()].concat();
            let speeds = self.speeds.evaluate(&inputs, &mut self.scratch);
            for (i, speed) in self.equations.bound.iter().zip(speeds) {
                velocities[*i] = speed;
            }
        }
        (positions, velocities)
    }
}

/// The order of the first coefficient that is not 0.
pub(super) fn beginning<S: Real>(row: &[S]) -> Option<usize> {
    row.iter().position(|term| term.middle() != 0.0)
}

/// -1 or 1.
pub(super) fn sign(x: f64) -> f64 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

/// So many places of a step are examined for kinks.
const SAMPLES: usize = 64;
/// Halvings of an interval that holds a kink: more than numbers have bits.
const BISECTIONS: usize = 128;
/// Roundings of its size that a value is below 0 by where it counts between two places.
const LEAST_DIP: f64 = 64.0;
/// Absolute values that begin with 0 at the same time.
const MOST_OPEN_SIGNS: usize = 6;
/// What begins behind this part of the terms of a coordinate asks for a higher order ...
const LATE: usize = 3;
/// ... unless it begins later than this: such a coordinate is so small that it may rest.
const LATEST: usize = 128;
/// So many coefficients tell the unit of time to begin with.
const FIRST: usize = 4;
/// Attempts at a unit of time.
const MOST_UNITS: usize = 8;
/// Steps that are so many units long, or a unit so many steps, have another unit ...
const FAR_OFF: f64 = 1_048_576.0;
/// ... or if the last power of that is so many powers of two.
const FAR_OFF_IN_ALL: f64 = 360.0;
