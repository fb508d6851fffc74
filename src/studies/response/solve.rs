//! M, G + C and K + N at the equilibrium in numbers with bounds, and what they respond to a force at one frequency.
//!
//! (S - ω²M + iωD) x = f is solved by elimination with row exchanges in enclosures, so that every component of x has the bound that
//! came along with it; nothing is estimated. Rows stand in an order that keeps the matrix narrow, and zeros outside its band are never
//! touched: a chain takes as many operations as it has masses. Where D is 0 all is real, so that a phase is exactly 0 or pi.

use std::collections::{BTreeMap, BTreeSet};

use faer::c64;
use librate_core::linearize::{Linearized, Precise, Units};
use librate_core::modes::SparseQuadratic;
use librate_core::order::Gather;
use librate_core::oscillation;
use librate_core::precision::{Ball, Banded, Big, Complex, Enclosure, Entry, Function, Scalar, subtract};

use nalgebra::DMatrix;

use super::order::{levels, narrow, neighbours};

/// An entry of the three matrices.
#[derive(Clone, Debug)]
struct Coefficient<S> {
    row: usize,
    column: usize,
    mass: S,
    velocity: S,
    stiffness: S,
}

impl<S: Enclosure> Coefficient<S> {
    /// One of a stiffness alone.
    fn stiff(row: usize, column: usize, stiffness: S, precision: S::Precision) -> Self {
        let zero = S::exact(0.0, precision);
        Self { row, column, mass: zero.clone(), velocity: zero, stiffness }
    }
}

/// Terms of the response in powers of the frequency, beside the first.
const TERMS: usize = 3;

/// An entry of -ω²M + iωD + S.
fn entry<S: Enclosure>(own: &Coefficient<S>, omega: &S, square: &S) -> Complex<S> {
    Complex::new(own.stiffness.sub(&square.mul(&own.mass)), omega.mul(&own.velocity))
}

/// The derivative of an entry of -ω²M + iωD + S over ω.
fn first_order<S: Enclosure>(own: &Coefficient<S>, omega: &S) -> Complex<S> {
    Complex::new(omega.mul(&own.mass).times_power_of_two(1).neg(), own.velocity.clone())
}

/// Larger matrices are eliminated.
const MOST_INVERTED: usize = 120;

/// Entries within the band that eight frequencies at once may have, of 200 bytes each, ...
const MOST_SIDE_BY_SIDE: usize = 1 << 16;
/// ... or within one that is no wider than this, beyond which bounds of long products grow.
const NARROW: (usize, usize) = (1 << 20, 16);

/// More than the roundings of sums of so many doubles.
const ROUNDED_UP: f64 = 1.0 + 1e-12;

/// At least the modulus.
fn size<S: Enclosure>(x: &Complex<S>) -> f64 {
    x.re.abs_upper() + x.im.abs_upper()
}

/// An approximate inverse, and the share of the largest component of its products that they may be off by.
struct Inverse<S> {
    rows: Vec<Vec<Complex<S>>>,
    share: f64,
}

impl<S: Enclosure> Inverse<S> {
    fn times(&self, right: &[Complex<S>], precision: S::Precision) -> Vec<Complex<S>> {
        let product = |row: &Vec<Complex<S>>| {
            let terms = row.iter().zip(right).map(|(own, right)| own.mul(right));
            terms.fold(Complex::zero(precision), |sum, term| sum.add(&term))
        };
        let all: Vec<Complex<S>> = self.rows.iter().map(product).collect();
        let off = all.iter().map(size).fold(0.0, f64::max) * self.share * ROUNDED_UP;
        let widened = |own: Complex<S>| Complex::new(own.re.with_added_radius(off), own.im.with_added_radius(off));
        all.into_iter().map(widened).collect()
    }
}

/// A frequency and the forces on coordinates, with their slopes over a quantity on which they depend; in SI.
pub(super) struct Slope<S> {
    pub(super) omega: [S; 2],
    pub(super) forces: Vec<(usize, Complex<S>)>,
    pub(super) slopes: Vec<(usize, Complex<S>)>,
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
    pub(super) precision: S::Precision,
}

/// The entries that are not 0, column by column, without a dense matrix; `None` under constraints and in units of their own.
fn sparse(own: &Linearized) -> Option<Vec<Coefficient<Ball>>> {
    let SparseQuadratic { mass, velocity, stiffness, .. } = oscillation::sparse_quadratic(own)?;
    let mut all: BTreeMap<(usize, usize), [Ball; 3]> = BTreeMap::new();
    for (part, matrix) in [mass.mirrored(), velocity, stiffness].iter().enumerate() {
        for (row, column, value) in matrix.entries() {
            all.entry((column, row)).or_insert([Ball::ZERO; 3])[part] = *value;
        }
    }
    all.retain(|_, parts| !parts.iter().all(Ball::is_zero));
    let all = all.into_iter();
    let all =
        all.map(|((column, row), [mass, velocity, stiffness])| Coefficient { row, column, mass, velocity, stiffness });
    Some(all.collect())
}

impl Matrices<Ball> {
    pub(super) fn in_balls(own: &Linearized, driven: &[usize]) -> Self {
        let point = own.equilibrium().values.clone();
        if let Some(entries) = sparse(own) {
            return Self::of(own, driven, entries, None, point, ());
        }
        let (velocity, stiffness) = own.velocity_and_stiffness();
        Self::new(own, driven, [&own.mass(), &velocity, &stiffness], own.directions(), point, ())
    }

    /// For eight frequencies at once; none where coordinates are sums of unknowns or in units of their own, or that takes much memory.
    pub(super) fn banded(&self) -> Option<Banded> {
        let is_plain = self.directions.is_none() && self.units.is_none();
        let width = 1 + self.band[0] + self.band[1];
        let is_small = self.order * width <= MOST_SIDE_BY_SIDE || width <= NARROW.1 && self.order * width <= NARROW.0;
        let entry = |own: &'_ Coefficient<Ball>| (own.row, own.column, [own.stiffness, own.mass, own.velocity]);
        (is_plain && is_small).then(|| Banded::new(self.order, self.band, self.entries.iter().map(entry)))
    }

    /// The row of a coordinate that is an unknown itself.
    pub(super) fn row(&self, coordinate: usize) -> Option<usize> {
        self.places.get(coordinate).copied()
    }
}

impl Matrices<Big> {
    /// With so many bits at least; `None` where that is not to be had.
    pub(super) fn in_bits(own: &Linearized, driven: &[usize], bits: usize) -> Option<Self> {
        let precise = own.precisely(bits)?;
        let directions = precise.directions();
        let Precise { bits, mass, velocity, stiffness, equilibrium, .. } = precise;
        let velocity = velocity.unwrap_or_else(|| vec![Big::zero(bits); stiffness.len()]);
        Some(Self::new(own, driven, [&mass, &velocity, &stiffness], directions, equilibrium, bits))
    }
}

impl<S: Enclosure> Matrices<S> {
    fn new(
        own: &Linearized,
        driven: &[usize],
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
        Self::of(own, driven, entries, directions, point, precision)
    }

    /// With 1 on the diagonal for what no chain of entries joins to the coordinates that forces act on. It rests, and its own resonances
    /// are none of the response.
    fn of(
        own: &Linearized,
        driven: &[usize],
        entries: Vec<Coefficient<S>>,
        directions: Option<Vec<Vec<S>>>,
        point: Vec<S>,
        precision: S::Precision,
    ) -> Self {
        let n = own.dimension();
        let units = own.units().cloned();
        let (places, band) = ((0..n).collect(), [0; 2]);
        let mut all = Self { order: n, entries, band, places, is_real: false, directions, units, point, precision };
        all.arrange();
        let neighbours = neighbours(n, &all.pattern());
        let mut is_reached = vec![false; n];
        for (place, _) in driven.iter().filter_map(|coordinate| all.shares(*coordinate)).flatten() {
            if !is_reached[place] {
                levels(&neighbours, place).into_iter().for_each(|own| is_reached[own] = true);
            }
        }
        all.entries.retain(|own| is_reached[own.row]);
        let alone = (0..n).filter(|place| !is_reached[*place]);
        all.entries.extend(alone.map(|row| Coefficient::stiff(row, row, S::exact(1.0, precision), precision)));
        all.is_real = all.entries.iter().all(|own| own.velocity.is_exact_zero());
        all
    }

    /// The rows and columns of the entries.
    fn pattern(&self) -> Vec<(usize, usize)> {
        self.entries.iter().map(|own| (own.row, own.column)).collect()
    }

    /// Puts rows and columns in an order that keeps the matrix narrow.
    fn arrange(&mut self) {
        let places = narrow(self.order, &self.pattern());
        self.band = [0; 2];
        for own in &mut self.entries {
            (own.row, own.column) = (places[own.row], places[own.column]);
            self.band[0] = self.band[0].max(own.row.saturating_sub(own.column));
            self.band[1] = self.band[1].max(own.column.saturating_sub(own.row));
        }
        self.places.iter_mut().for_each(|place| *place = places[*place]);
    }

    /// About the multiplications of an elimination.
    pub(super) fn work(&self) -> f64 {
        self.order as f64 * (1 + self.band[0]) as f64 * (1 + self.band[0] + self.band[1]) as f64
    }

    /// About those for a response over many frequencies at once.
    pub(super) fn work_over(&self) -> f64 {
        let inverted = if self.order > MOST_INVERTED { 0.0 } else { (self.order * self.entries.len()) as f64 };
        6.0 * self.work() + inverted
    }

    /// The response of some coordinates at an angular frequency to forces on coordinates, in SI; `None` where the system is not shown to be regular.
    pub(super) fn response(
        &self,
        omega: &S,
        forces: &[(usize, Complex<S>)],
        outputs: &[usize],
    ) -> Option<Vec<Complex<S>>> {
        let solution = self.solution(&self.rate(omega), self.right(forces)?)?;
        outputs.iter().map(|at| self.motion(&solution, *at)).collect()
    }

    /// The response of a coordinate and its slope over a quantity on which the frequency and the forces depend, each with its own slope:
    /// from A x = f follows A x' = f' - A' x.
    pub(super) fn with_slope(&self, force: &Slope<S>, output: usize) -> Option<[Complex<S>; 2]> {
        let [omega, rise] = force.omega.each_ref().map(|omega| self.rate(omega));
        let x = self.solution(&omega, self.right(&force.forces)?)?;
        let mut right = self.right(&force.slopes)?;
        let change = self.product(|own| first_order(own, &omega).times(&rise), &x);
        right.iter_mut().zip(&change).for_each(|(right, change)| *right = right.sub(change));
        let slope = self.solution(&omega, right)?;
        Some([self.motion(&x, output)?, self.motion(&slope, output)?])
    }

    /// The same over all frequencies of a reach about one, for constant forces, with the slope over the frequency.
    ///
    /// With A(ω + h) = A + h A₁ + h² A₂ the terms of x = Σ hᵏ xₖ + e solve A xₖ = -A₁ xₖ₋₁ - A₂ xₖ₋₂ at one frequency, where nothing is lost to
    /// wide intervals, and the remainder, for which all of A(ω + h) has to be eliminated, has a high power of h for a factor.
    pub(super) fn with_slope_over(
        &self,
        [omega, reach]: [&S; 2],
        forces: &[(usize, Complex<S>)],
        output: usize,
    ) -> Option<[Complex<S>; 2]> {
        let [omega, h] = [omega, reach].map(|omega| self.rate(omega));
        let inertia = |own: &Coefficient<S>| Complex::new(own.mass.neg(), S::exact(0.0, self.precision));
        let first = |x: &[Complex<S>]| self.product(|own| first_order(own, &omega), x);
        let second = |x: &[Complex<S>]| self.product(inertia, x);
        let sum = |x: Vec<Complex<S>>, by: &[Complex<S>]| x.iter().zip(by).map(|(x, by)| x.add(by)).collect::<Vec<_>>();
        let scaled = |x: &[Complex<S>], by: &S| x.iter().map(|x| x.times(by)).collect::<Vec<_>>();
        let opposite = |x: Vec<Complex<S>>| x.iter().map(|x| Complex::new(x.re.neg(), x.im.neg())).collect::<Vec<_>>();
        let mut terms = vec![self.solution(&omega, self.right(forces)?)?];
        let mut left = first(&terms[0]);
        for k in 1..=TERMS {
            terms.push(self.solution(&omega, opposite(left))?);
            left = sum(first(&terms[k]), &second(&terms[k - 1]));
        }
        // What is left of A(ω + h) Σ hᵏ xₖ, and its slope.
        let last = second(&terms[TERMS]);
        let power = |exponent: usize| h.powi(exponent as i32);
        let times = |factor: usize, x: S| x.mul(&S::exact(factor as f64, self.precision));
        let rest = sum(scaled(&left, &power(TERMS + 1)), &scaled(&last, &power(TERMS + 2)));
        let [low, high] = [times(TERMS + 1, power(TERMS)), times(TERMS + 2, power(TERMS + 1))];
        let rest_slope = sum(scaled(&left, &low), &scaled(&last, &high));
        let all = omega.add(&h);
        let inverse = self.inverse(&omega, &all);
        let remainder = |right: Vec<Complex<S>>| match &inverse {
            Some(inverse) => Some(inverse.times(&right, self.precision)),
            None if self.order > MOST_INVERTED => self.solution(&all, right),
            None => None,
        };
        let error = remainder(opposite(rest))?;
        let change = self.product(|own| first_order(own, &all), &error);
        let error_slope = remainder(opposite(sum(change, &rest_slope)))?;
        let mut x = self.motion(&error, output)?;
        let mut slope = self.motion(&error_slope, output)?;
        for (k, term) in terms.iter().enumerate() {
            let own = self.motion(term, output)?;
            x = x.add(&own.times(&power(k)));
            if k > 0 {
                slope = slope.add(&own.times(&times(k, power(k - 1))));
            }
        }
        let unit = self.units.as_ref().map_or(0, |units| -units.rate());
        Some([x, slope.scale(unit)])
    }

    /// The inverse over all of some frequencies from an approximate one: with q = ‖1 - R A‖ < 1, A⁻¹ r is within q/(1 - q) ‖R r‖ of R r
    /// (S. M. Rump, Acta Numerica 19 (2010) 287, theorem 10.2). Elimination of wide intervals gets lost in long chains.
    fn inverse(&self, omega: &S, all: &S) -> Option<Inverse<S>> {
        let n = self.order;
        if n > MOST_INVERTED {
            return None;
        }
        let mut middle = DMatrix::<c64>::zeros(n, n);
        let square = omega.mul(omega);
        for own in &self.entries {
            middle[(own.row, own.column)] = entry(own, omega, &square).to_c64();
        }
        let inverse = middle.try_inverse()?;
        if inverse.iter().any(|own| !own.is_finite()) {
            return None;
        }
        let of = |i: usize, j: usize| Complex::from_c64(inverse[(i, j)], self.precision);
        let rows: Vec<Vec<Complex<S>>> = (0..n).map(|i| (0..n).map(|j| of(i, j)).collect()).collect();
        let square = all.mul(all);
        let entries: Vec<Complex<S>> = self.entries.iter().map(|own| entry(own, all, &square)).collect();
        let distance = |(i, row): (usize, &Vec<Complex<S>>)| {
            let mut own = vec![Complex::zero(self.precision); n];
            own[i] = Complex::real(-1.0, self.precision);
            for (place, entry) in self.entries.iter().zip(&entries) {
                own[place.column] = own[place.column].add(&row[place.row].mul(entry));
            }
            own.iter().map(size).sum::<f64>()
        };
        let q = rows.iter().enumerate().map(distance).fold(0.0, f64::max) * ROUNDED_UP;
        (q < 0.9).then(|| Inverse { rows, share: q / (1.0 - q) * ROUNDED_UP })
    }

    /// A matrix with the places of this one, times a vector.
    fn product(&self, entry: impl Fn(&Coefficient<S>) -> Complex<S>, x: &[Complex<S>]) -> Vec<Complex<S>> {
        let mut product = vec![Complex::zero(self.precision); self.order];
        for own in &self.entries {
            product[own.row] = product[own.row].add(&entry(own).mul(&x[own.column]));
        }
        product
    }

    /// The reciprocal y of the response of a coordinate to forces that are all real, or all imaginary, in some unit: y and z = x y solve
    /// A z = f y with z = 1 for that coordinate, which is regular at a resonance, too.
    pub(super) fn reciprocal(&self, force: &Slope<S>, output: usize) -> Option<Complex<S>> {
        let mut own = self.clone();
        let last = own.order;
        let entry = |row, column, stiffness| Coefficient::stiff(row, column, stiffness, self.precision);
        own.entries.extend(self.shares(output)?.into_iter().map(|(place, share)| entry(last, place, share)));
        let forces = self.right(&force.forces)?;
        let turned = forces.iter().all(|own| own.re.is_exact_zero());
        let forces = forces.into_iter().map(|own| if turned { own.im } else { own.re }).enumerate();
        let forces = forces.filter(|(_, own)| !own.is_exact_zero());
        own.entries.extend(forces.map(|(row, force)| entry(row, last, force.neg())));
        own.order += 1;
        own.places.push(last);
        own.arrange();
        let mut right = vec![Complex::zero(self.precision); own.order];
        right[own.places[last]] = Complex::real(1.0, self.precision);
        let solution = own.solution(&self.rate(&force.omega[0]), right)?;
        let found = solution[own.places[last]].clone();
        // 1/i is -i.
        Some(if turned { Complex::new(found.im, found.re.neg()) } else { found })
    }

    /// Whether the response of a coordinate, if finite, is proved to be 0 between two frequencies. To a force in one row it is a multiple of the
    /// determinant without that row and the column of the output (Cramer's rule). With the other column in place of this one, strongly
    /// connected blocks have determinants for factors, of which one without friction is real and may change its sign.
    pub(super) fn vanishes(&self, force: &Slope<S>, ends: [&S; 2], output: usize) -> Option<bool> {
        let is_zero = |own: &Complex<S>| own.re.is_exact_zero() && own.im.is_exact_zero();
        let right = self.right(&force.forces)?;
        let mut driven = (0..self.order).filter(|row| !is_zero(&right[*row]));
        let (Some(input), None) = (driven.next(), driven.next()) else { return None };
        let [(output, _)] = self.shares(output)?[..] else { return None };
        let minor = self.entries.iter().filter(|own| own.row != input && own.column != output).cloned();
        let renamed =
            |own: Coefficient<S>| Coefficient { column: if own.column == input { output } else { own.column }, ..own };
        let minor: Vec<Coefficient<S>> = minor.map(renamed).collect();
        let ahead = minor.iter().map(|own| (own.row, own.column)).by_place(self.order);
        let back = minor.iter().map(|own| (own.column, own.row)).by_place(self.order);
        let mut left: BTreeSet<usize> = (0..self.order).filter(|row| *row != input).collect();
        while let Some(first) = left.first() {
            let [ahead, back] = [&ahead, &back].map(|links| BTreeSet::from_iter(levels(links, *first)));
            let block: Vec<usize> = ahead.intersection(&back).copied().collect();
            left.retain(|row| !ahead.contains(row) || !back.contains(row));
            let place = |at: usize| block.binary_search(&at).ok();
            let own = |own: &Coefficient<S>| {
                Some(Coefficient { row: place(own.row)?, column: place(own.column)?, ..own.clone() })
            };
            let entries: Vec<Coefficient<S>> = minor.iter().filter_map(own).collect();
            if entries.iter().all(|own| own.velocity.is_exact_zero()) {
                let mut own = Self { order: block.len(), entries, places: Vec::new(), ..self.clone() };
                own.arrange();
                if let [Some(from), Some(to)] = ends.map(|omega| own.is_positive(&own.rate(omega)))
                    && from != to
                {
                    return Some(true);
                }
            }
        }
        None
    }

    /// The sign of the determinant of -ω²M + S.
    fn is_positive(&self, omega: &S) -> Option<bool> {
        let square = omega.mul(omega);
        let mut rows = self.rows(S::exact(0.0, self.precision), |own| entry(own, omega, &square).re);
        let is_odd = rows.eliminate(&mut vec![Vec::new(); self.order], S::certain_size, self.precision)?;
        let is_negative = |k: &usize| rows.rows[*k][rows.place(*k, *k)].is_negative();
        Some((0..self.order).filter(is_negative).count() % 2 == usize::from(is_odd))
    }

    /// A frequency in units of the matrices.
    fn rate(&self, omega: &S) -> S {
        self.units.as_ref().map_or_else(|| omega.clone(), |units| omega.times_power_of_two(-units.rate()))
    }

    /// Forces as a right side.
    fn right(&self, forces: &[(usize, Complex<S>)]) -> Option<Vec<Complex<S>>> {
        let mut right = vec![Complex::zero(self.precision); self.order];
        for (coordinate, force) in forces {
            let by = self.units.as_ref().map_or(0, |units| units.length(*coordinate) - units.energy());
            let force = force.scale(by);
            for (place, share) in self.shares(*coordinate)? {
                right[place] = right[place].add(&force.times(&share));
            }
        }
        Some(right)
    }

    /// The unknowns that a coordinate is a sum of, each with its factor.
    fn shares(&self, coordinate: usize) -> Option<Vec<(usize, S)>> {
        match &self.directions {
            Some(rows) => {
                let shares = rows.get(coordinate)?.iter().zip(&self.places);
                let shares = shares.filter(|(share, _)| !share.is_exact_zero());
                Some(shares.map(|(share, place)| (*place, share.clone())).collect())
            }
            None => Some(vec![(*self.places.get(coordinate)?, S::exact(1.0, self.precision))]),
        }
    }

    fn motion(&self, solution: &[Complex<S>], coordinate: usize) -> Option<Complex<S>> {
        let shares = self.shares(coordinate)?.into_iter().map(|(place, share)| solution[place].times(&share));
        // A coordinate that constraints hold is a sum of nothing.
        let own = shares.reduce(|sum, own| sum.add(&own)).unwrap_or_else(|| Complex::zero(self.precision));
        Some(own.scale(self.units.as_ref().map_or(0, |units| units.length(coordinate))))
    }

    fn solution(&self, omega: &S, right: Vec<Complex<S>>) -> Option<Vec<Complex<S>>> {
        if self.is_real || omega.is_exact_zero() { self.real(omega, right) } else { self.complex(omega, right) }
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
        let zero = S::exact(0.0, self.precision);
        let right = right.into_iter().map(|own| vec![own]).collect();
        let size = |own: &Complex<S>| own.re.certain_size().max(own.im.certain_size());
        let rows = self.rows(Complex::new(zero.clone(), zero), |own| entry(own, omega, &square));
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

    /// Makes it triangular, with right sides of as many numbers each as there are, and says whether the number of row exchanges is odd;
    /// `size` is positive for what may be divided by. `None` where no pivot is left.
    fn eliminate(&mut self, right: &mut [Vec<T>], size: impl Fn(&T) -> f64, precision: T::Precision) -> Option<bool> {
        let n = self.rows.len();
        let mut is_odd = false;
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
            is_odd ^= pivot != k;
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
                subtract(&mut own[place + 1..], &pivot[1..], &factor);
                subtract(&mut rest_right[row - k - 1], pivot_right, &factor);
            }
        }
        Some(is_odd)
    }

    /// Solutions for right sides.
    fn solve(
        mut self,
        mut right: Vec<Vec<T>>,
        size: impl Fn(&T) -> f64,
        precision: T::Precision,
    ) -> Option<Vec<Vec<T>>> {
        self.eliminate(&mut right, size, precision)?;
        for k in (0..self.rows.len()).rev() {
            let (row, rest) = self.rows[k][self.place(k, k)..].split_first()?;
            let (own, below) = right.split_at_mut(k + 1);
            let own = own.last_mut()?;
            for (entry, x) in rest.iter().zip(below.iter()) {
                subtract(own, x, entry);
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
        let zero = x.re.is_positive().then(|| S::exact(0.0, precision));
        let angle = zero.or_else(|| x.re.is_negative().then(|| <S as Scalar>::pi(precision)));
        return (x.re.apply(Function::Abs), angle);
    }
    (x.square_of_modulus().sqrt(), (!x.contains_zero()).then(|| x.im.atan2(&x.re)))
}
