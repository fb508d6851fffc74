//! M, G + C and K + N at the equilibrium in numbers with bounds, and what they respond to a force at one frequency.
//!
//! (S - ω²M + iωD) x = f is solved by elimination with row exchanges in enclosures, so that every component of x has the bound that
//! came along with it; nothing is estimated. Rows stand in an order that keeps the matrix narrow, and zeros outside its band are never
//! touched: a chain takes as many operations as it has masses. Where D is 0 all is real, so that a phase is exactly 0 or pi.

use librate_core::linearize::{Linearized, Precise, Units};
use librate_core::precision::{Ball, Big, Complex, Enclosure, Entry, Function, Scalar};

use super::order::narrow;

/// An entry of the three matrices.
#[derive(Clone, Debug)]
struct Coefficient<S> {
    row: usize,
    column: usize,
    mass: S,
    velocity: S,
    stiffness: S,
}

/// The linear system at any frequency.
#[derive(Clone, Debug)]
pub(super) struct Matrices<S: Enclosure> {
    order: usize,
    entries: Vec<Coefficient<S>>,
    /// How far the entries are from the diagonal, below and above.
    band: [usize; 2],
    /// The row of each coordinate that the matrices have.
    places: Vec<usize>,
    /// Whether no force depends on velocities.
    pub(super) is_real: bool,
    directions: Option<Vec<Vec<S>>>,
    units: Option<Units>,
    /// The equilibrium in SI.
    pub(super) point: Vec<S>,
    precision: S::Precision,
}

impl Matrices<Ball> {
    pub(super) fn in_balls(own: &Linearized) -> Self {
        let (velocity, stiffness) = own.velocity_and_stiffness();
        let point = own.equilibrium().values.clone();
        Self::new(own, [&own.mass(), &velocity, &stiffness], own.directions(), point, ())
    }
}

impl Matrices<Big> {
    /// With so many bits at least; `None` where that is not to be had.
    pub(super) fn in_bits(own: &Linearized, bits: usize) -> Option<Self> {
        let precise = own.precisely(bits)?;
        let directions = precise.directions();
        let Precise { bits, mass, velocity, stiffness, equilibrium, .. } = precise;
        let velocity = velocity.unwrap_or_else(|| vec![Big::zero(bits); stiffness.len()]);
        Some(Self::new(own, [&mass, &velocity, &stiffness], directions, equilibrium, bits))
    }
}

impl Matrices<Big> {
    /// The precision.
    pub(super) fn bits(&self) -> usize {
        self.precision
    }
}

impl<S: Enclosure> Matrices<S> {
    fn new(
        own: &Linearized,
        [mass, velocity, stiffness]: [&[S]; 3],
        directions: Option<Vec<Vec<S>>>,
        point: Vec<S>,
        precision: S::Precision,
    ) -> Self {
        let n = own.dimension();
        let mut entries = Vec::new();
        for column in 0..n {
            for row in 0..n {
                let [m, d, s] = [mass, velocity, stiffness].map(|matrix| &matrix[row + n * column]);
                if !(m.is_exact_zero() && d.is_exact_zero() && s.is_exact_zero()) {
                    let (mass, velocity, stiffness) = (m.clone(), d.clone(), s.clone());
                    entries.push(Coefficient { row, column, mass, velocity, stiffness });
                }
            }
        }
        let pattern: Vec<(usize, usize)> = entries.iter().map(|own| (own.row, own.column)).collect();
        let places = narrow(n, &pattern);
        let mut band = [0; 2];
        for own in &mut entries {
            (own.row, own.column) = (places[own.row], places[own.column]);
            band[0] = band[0].max(own.row.saturating_sub(own.column));
            band[1] = band[1].max(own.column.saturating_sub(own.row));
        }
        let is_real = entries.iter().all(|own| own.velocity.is_exact_zero());
        let units = own.units().cloned();
        Self { order: n, entries, band, places, is_real, directions, units, point, precision }
    }

    /// About the multiplications of an elimination.
    pub(super) fn work(&self) -> f64 {
        self.order as f64 * (1 + self.band[0]) as f64 * (1 + self.band[0] + self.band[1]) as f64
    }

    /// The response of some coordinates at an angular frequency to forces on coordinates, in SI; `None` where the system is not shown to be regular.
    pub(super) fn response(
        &self,
        omega: &S,
        forces: &[(usize, Complex<S>)],
        outputs: &[usize],
    ) -> Option<Vec<Complex<S>>> {
        let omega = match &self.units {
            Some(units) => omega.times_power_of_two(-units.rate()),
            None => omega.clone(),
        };
        let zero = S::exact(0.0, self.precision);
        let mut right = vec![Complex::new(zero.clone(), zero); self.order];
        for (coordinate, force) in forces {
            let by = self.units.as_ref().map_or(0, |units| units.length(*coordinate) - units.energy());
            let force = force.scale(by);
            match &self.directions {
                Some(rows) => {
                    for (place, share) in self.places.iter().zip(rows.get(*coordinate)?) {
                        right[*place] = right[*place].add(&force.times(share));
                    }
                }
                None => right[*self.places.get(*coordinate)?] = force,
            }
        }
        let solution = if self.is_real { self.real(&omega, right)? } else { self.complex(&omega, right)? };
        let motion = |coordinate: usize| -> Option<Complex<S>> {
            let own = match &self.directions {
                Some(rows) => {
                    let shares = rows.get(coordinate)?.iter().zip(&self.places);
                    let mut shares = shares.filter(|(share, _)| !share.is_exact_zero());
                    let (first, place) = shares.next()?;
                    shares.fold(solution[*place].times(first), |sum, (share, place)| {
                        sum.add(&solution[*place].times(share))
                    })
                }
                None => solution[*self.places.get(coordinate)?].clone(),
            };
            Some(own.scale(self.units.as_ref().map_or(0, |units| units.length(coordinate))))
        };
        outputs.iter().map(|at| motion(*at)).collect()
    }

    fn real(&self, omega: &S, right: Vec<Complex<S>>) -> Option<Vec<Complex<S>>> {
        let square = omega.mul(omega);
        let entry = |own: &Coefficient<S>| own.stiffness.sub(&square.mul(&own.mass));
        let is_real = right.iter().all(|own| own.im.is_exact_zero());
        let columns = |own: Complex<S>| if is_real { vec![own.re] } else { vec![own.re, own.im] };
        let right = right.into_iter().map(columns).collect();
        let zero = S::exact(0.0, self.precision);
        let found = self.rows(zero.clone(), entry).solve(right, S::certain_size, self.precision)?;
        let both = |own: Vec<S>| {
            let mut own = own.into_iter();
            Some(Complex::new(own.next()?, own.next().unwrap_or_else(|| zero.clone())))
        };
        found.into_iter().map(both).collect()
    }

    fn complex(&self, omega: &S, right: Vec<Complex<S>>) -> Option<Vec<Complex<S>>> {
        let square = omega.mul(omega);
        let entry =
            |own: &Coefficient<S>| Complex::new(own.stiffness.sub(&square.mul(&own.mass)), omega.mul(&own.velocity));
        let zero = S::exact(0.0, self.precision);
        let right = right.into_iter().map(|own| vec![own]).collect();
        let size = |own: &Complex<S>| own.re.certain_size().max(own.im.certain_size());
        let rows = self.rows(Complex::new(zero.clone(), zero), entry);
        Some(rows.solve(right, size, self.precision)?.into_iter().flatten().collect())
    }

    /// The matrix at one frequency.
    fn rows<T: Entry>(&self, zero: T, entry: impl Fn(&Coefficient<S>) -> T) -> Rows<T> {
        let [below, above] = self.band;
        // Row exchanges widen it to the right.
        let width = below + above + 1;
        let mut rows = vec![vec![zero; width]; self.order];
        for own in &self.entries {
            rows[own.row][own.column + below - own.row] = entry(own);
        }
        let starts = (0..self.order).map(|row| row as isize - below as isize).collect();
        Rows { rows, starts, below }
    }
}

/// A matrix by rows, each from a column on.
struct Rows<T> {
    rows: Vec<Vec<T>>,
    starts: Vec<isize>,
    below: usize,
}

impl<T: Entry> Rows<T> {
    /// Where a column is in a row.
    fn place(&self, row: usize, column: usize) -> usize {
        (column as isize - self.starts[row]).max(0) as usize
    }

    /// Solutions for right sides, each of as many numbers as there are; `size` is positive for what may be divided by. `None` where no
    /// pivot is left.
    fn solve(
        mut self,
        mut right: Vec<Vec<T>>,
        size: impl Fn(&T) -> f64,
        precision: T::Precision,
    ) -> Option<Vec<Vec<T>>> {
        let n = self.rows.len();
        for k in 0..n {
            let last = (k + self.below).min(n - 1);
            let mut best = (k, 0.0);
            for row in k..=last {
                let own = self.rows[row].get(self.place(row, k)).map_or(0.0, &size);
                if own > best.1 {
                    best = (row, own);
                }
            }
            let (pivot, own) = best;
            if own <= 0.0 {
                return None;
            }
            self.rows.swap(k, pivot);
            self.starts.swap(k, pivot);
            right.swap(k, pivot);
            let first = self.place(k, k);
            let (done, rest) = self.rows.split_at_mut(k + 1);
            let (done_right, rest_right) = right.split_at_mut(k + 1);
            let (Some(pivot), Some(pivot_right)) = (done.last(), done_right.last()) else { return None };
            let pivot = &pivot[first..];
            for row in k + 1..=last {
                let own = &mut rest[row - k - 1];
                let place = (k as isize - self.starts[row]).max(0) as usize;
                if own.get(place).is_none_or(T::is_zero) {
                    continue;
                }
                let factor = own[place].div(&pivot[0]);
                if own.len() < place + pivot.len() {
                    own.resize(place + pivot.len(), T::whole(0, precision));
                }
                for (entry, above) in own[place..].iter_mut().zip(pivot).skip(1) {
                    if !above.is_zero() {
                        *entry = entry.sub(&factor.mul(above));
                    }
                }
                for (entry, above) in rest_right[row - k - 1].iter_mut().zip(pivot_right) {
                    if !above.is_zero() {
                        *entry = entry.sub(&factor.mul(above));
                    }
                }
            }
        }
        for k in (0..n).rev() {
            let first = self.place(k, k);
            let (row, rest) = self.rows[k][first..].split_first()?;
            let (own, below) = right.split_at_mut(k + 1);
            let own = own.last_mut()?;
            for (entry, x) in rest.iter().zip(below.iter()) {
                if entry.is_zero() {
                    continue;
                }
                for (sum, x) in own.iter_mut().zip(x) {
                    if !x.is_zero() {
                        *sum = sum.sub(&entry.mul(x));
                    }
                }
            }
            for sum in own {
                *sum = sum.div(row);
            }
        }
        Some(right)
    }
}

/// The modulus and the angle, in (-pi, pi]; none of 0.
pub(super) fn polar<S: Enclosure>(x: &Complex<S>, precision: S::Precision) -> (S, Option<S>) {
    if x.im.is_exact_zero() {
        let angle = if x.re.is_positive() {
            Some(S::exact(0.0, precision))
        } else if x.re.is_negative() {
            Some(<S as Scalar>::pi(precision))
        } else {
            None
        };
        return (x.re.apply(Function::Abs), angle);
    }
    let modulus = x.square_of_modulus().sqrt();
    (modulus, (!x.contains_zero()).then(|| x.im.atan2(&x.re)))
}
