//! (S - ω²M + iωD) x = f for eight ω at once: banded elimination in doubles, one correction, and a bound that is proved afterwards.
//!
//! A is eliminated without row exchanges, A = L U + F with |F| ≤ c u |L||U| + B, where B bounds what the entries are off by. With x
//! from doubles, r = f - A x in double-double and d from r in doubles, the distance e from x + d to the solution satisfies
//! A e = r', |r'| ≤ ρ. As |L⁻¹| ≤ ⟨L⟩⁻¹ and |U⁻¹| ≤ ⟨U⟩⁻¹ for the comparison matrices (N. J. Higham, Accuracy and Stability of
//! Numerical Algorithms, 2nd ed., theorem 8.12), with G = ⟨U⟩⁻¹⟨L⟩⁻¹ we have |e| ≤ G (ρ + |F||e|). For v = 2 G ρ with v > 0 and
//! 2 G|F| v ≤ v the spectral radius of G|F| is at most 1/2 (Collatz), so A is regular, and (1 - G|F|) v ≥ v/2 = G ρ gives |e| ≤ v.
//! Nothing is decided where this fails, as beside a small pivot; the caller then eliminates with row exchanges.
//!
//! With u = 2^-53 and w = below + above + 1: a complex product costs 2.9 u (Higham, lemma 3.5), a reciprocal 5 u, a factor of L 8 u; an
//! entry meets at most min(below, above) products and differences, its rounding to a double u: c ≤ w + 17 for F. The triangular
//! solutions are those of L + ΔL and U + ΔU (theorem 8.5), so that |r - A d| ≤ (2 w + 34) u |L||U||d| + B|d|. `ROUNDINGS` doubles that.
//! Sums of nonnegative numbers are off by less than a factor 2 in doubles, and are taken twice.

use super::ball::{Ball, U2};
use super::complex::Complex;
use super::double::{DoubleDouble, power_of_two};
use super::lane::{LANES, Lane, Pair, kernel};

/// u.
const U: f64 = power_of_two(-53);
/// Constants c in units of u, for each column of the band and beside these.
const ROUNDINGS: [f64; 2] = [4.0, 80.0];
/// Pivots, bounds and corrections within these leave products that underflow, off by 2^-1070 each, without effect beside c u |u_ii| v_i
/// ≥ 2^-502 and `FLOOR`, which is added to every entry of ρ.
const PIVOTS: [f64; 2] = [power_of_two(-150), power_of_two(150)];
const BOUNDS: [f64; 2] = [power_of_two(-300), power_of_two(100)];
const FLOOR: f64 = power_of_two(-700);
/// As that, for entries of A times components of x.
const ENTRY_FLOOR: f64 = power_of_two(-1000);
/// And for a modulus, whose squares may underflow.
const MODULUS_FLOOR: f64 = power_of_two(-520);
/// A frequency may be off by so much of itself.
const OMEGA_ERROR: f64 = 64.0 * U2;

/// Rows and what is in them.
type Forces = Vec<(usize, Complex<Ball>)>;

/// An entry of the three matrices: centres, and what multiplies 1, ω² and ω in the bound of an entry of A.
#[derive(Clone, Debug)]
struct Place {
    row: usize,
    column: usize,
    centres: [DoubleDouble; 3],
    bounds: [f64; 3],
}

/// Three banded matrices.
#[derive(Clone, Debug)]
pub struct Banded {
    order: usize,
    /// How far the entries are from the diagonal, below and above.
    band: [usize; 2],
    places: Vec<Place>,
    /// What rounding in double-double costs, as a share of |S| + ω²|M| + ω|D|.
    share: f64,
}

/// A component of eight solutions as |x| and its angle in (-pi, pi]; errors are infinite where nothing is proved.
#[derive(Clone, Copy, Debug)]
pub struct Polar {
    /// |x|.
    pub amplitude: Lane,
    /// A bound of what it is off by.
    pub amplitude_error: Lane,
    /// The angle.
    pub phase: Lane,
    /// A bound of what it is off by.
    pub phase_error: Lane,
}

impl Polar {
    /// Amplitude and phase of one of the eight, in balls.
    #[must_use]
    pub fn at(&self, lane: usize) -> [Ball; 2] {
        let ball = |mid: Lane, error: Lane| Ball::new(DoubleDouble::exact(mid.0[lane]), error.0[lane]);
        [ball(self.amplitude, self.amplitude_error), ball(self.phase, self.phase_error)]
    }
}

/// An entry of A, or of a right side: its parts, and a bound of what they are off by.
#[derive(Clone, Copy)]
struct Entry {
    value: Complex<Pair>,
    bound: Lane,
}

impl Entry {
    const ZERO: Self = Self { value: Complex { re: Pair::ZERO, im: Pair::ZERO }, bound: Lane::ZERO };
}

/// What eight systems take, to be used again for the next eight.
struct Work {
    right: Vec<Entry>,
    entries: Vec<Entry>,
    /// A, then L and U, by rows of the band; and the moduli of these.
    matrix: Vec<Complex<Lane>>,
    moduli: Vec<Lane>,
    /// Of the pivots.
    inverse: Vec<Complex<Lane>>,
    x: Vec<Complex<Lane>>,
    d: Vec<Complex<Lane>>,
    /// |d|, v and what G|F| makes of it.
    sizes: Vec<Lane>,
    v: Vec<Lane>,
    again: Vec<Lane>,
    proved: Lane,
}

impl Banded {
    /// From the places of entries, each with its stiffness, mass and velocity coefficient.
    pub fn new(order: usize, band: [usize; 2], entries: impl Iterator<Item = (usize, usize, [Ball; 3])>) -> Self {
        let mut filled = vec![0; order];
        let place = |(row, column, parts): (usize, usize, [Ball; 3])| {
            filled[row] += 1;
            Place { row, column, centres: parts.map(|own| own.mid), bounds: parts.map(|own| own.radius) }
        };
        let mut places: Vec<Place> = entries.map(place).collect();
        // An entry k - θ m of two doubles each is off by at most 40 u² of its terms, what ω is off by costs 130 u²; a sum of 2 m
        // products and f in double-double, added up below at most 2 m + 4 times, by (2 m + 5)² u² (see `residuals` in modes/sparse).
        let widest = filled.into_iter().max().unwrap_or(0) as f64;
        let share = ((2.0 * widest + 5.0) * (2.0 * widest + 5.0) + 256.0) * U2;
        for place in &mut places {
            for (bound, centre) in place.bounds.iter_mut().zip(&place.centres) {
                *bound += share * centre.hi.abs();
            }
            place.bounds[0] += ENTRY_FLOOR;
        }
        Self { order, band, places, share }
    }

    /// Some components of the solutions for any ω and right sides, each a list of rows with what is in them, eight solutions at a time.
    pub fn polar(&self, driven: &[(Ball, Forces)], rows: &[usize]) -> Vec<Polar> {
        let mut work = self.work();
        let mut polar = Vec::with_capacity(driven.len().div_ceil(LANES) * rows.len());
        for driven in driven.chunks(LANES) {
            let omega = self.put(driven, &mut work.right);
            solve(self, &omega, &mut work);
            polar.extend(rows.iter().map(|row| as_polar(&work, *row)));
        }
        polar
    }

    fn work(&self) -> Work {
        let n = self.order;
        let entries = vec![Entry::ZERO; self.places.len()];
        let matrix = vec![ZERO; n * self.width()];
        let moduli = vec![Lane::ZERO; matrix.len()];
        let right = vec![Entry::ZERO; n];
        let [inverse, x, d] = [0; 3].map(|_| vec![ZERO; n]);
        let [sizes, v, again] = [0; 3].map(|_| vec![Lane::ZERO; n]);
        Work { right, entries, matrix, moduli, inverse, x, d, sizes, v, again, proved: Lane::ZERO }
    }

    /// Frequencies and right sides in lanes.
    fn put(&self, driven: &[(Ball, Forces)], right: &mut [Entry]) -> Pair {
        right.fill(Entry::ZERO);
        let mut omega = Pair::ZERO;
        for (lane, (own, forces)) in driven.iter().enumerate() {
            let is_close = own.radius <= OMEGA_ERROR * own.mid.hi;
            omega.high.0[lane] = if is_close { own.mid.hi } else { f64::NAN };
            omega.low.0[lane] = own.mid.lo;
            for (row, force) in forces {
                let Entry { value, bound } = &mut right[*row];
                for (part, force) in [(&mut value.re, &force.re), (&mut value.im, &force.im)] {
                    part.high.0[lane] = force.mid.hi;
                    part.low.0[lane] = force.mid.lo;
                    bound.0[lane] += force.radius + self.share * force.mid.hi.abs();
                }
            }
        }
        omega
    }

    fn width(&self) -> usize {
        self.band[0] + self.band[1] + 1
    }

    /// The place of an entry in a matrix that is kept by rows of its band.
    #[inline(always)]
    fn at(&self, row: usize, column: usize) -> usize {
        row * self.width() + column + self.band[0] - row
    }

    /// The columns of L in a row.
    #[inline(always)]
    fn left(&self, row: usize) -> std::ops::Range<usize> {
        row.saturating_sub(self.band[0])..row
    }

    /// The columns of U in a row, but for the diagonal; rows are `self.band[0]` below for columns.
    #[inline(always)]
    fn rest(&self, row: usize, band: usize) -> std::ops::Range<usize> {
        row + 1..self.order.min(row + band + 1)
    }

    /// |L||U| y, in place.
    #[inline(always)]
    fn product(&self, moduli: &[Lane], y: &mut [Lane]) {
        for i in 0..self.order {
            let mut sum = moduli[self.at(i, i)] * y[i];
            for j in self.rest(i, self.band[1]) {
                sum += moduli[self.at(i, j)] * y[j];
            }
            y[i] = sum;
        }
        for i in (0..self.order).rev() {
            for k in self.left(i) {
                y[i] += moduli[self.at(i, k)] * y[k];
            }
        }
    }

    /// G y, in place.
    #[inline(always)]
    fn spread(&self, moduli: &[Lane], y: &mut [Lane]) {
        for i in 0..self.order {
            for k in self.left(i) {
                y[i] += moduli[self.at(i, k)] * y[k];
            }
        }
        for i in (0..self.order).rev() {
            for j in self.rest(i, self.band[1]) {
                y[i] += moduli[self.at(i, j)] * y[j];
            }
            y[i] = y[i] / moduli[self.at(i, i)];
        }
    }

    /// c u |L||U| y + B y.
    #[inline(always)]
    fn lost(&self, moduli: &[Lane], entries: &[Entry], y: &[Lane], out: &mut [Lane]) {
        out.copy_from_slice(y);
        self.product(moduli, out);
        let c = Lane::splat((ROUNDINGS[0] * self.width() as f64 + ROUNDINGS[1]) * U);
        for out in out.iter_mut() {
            *out = *out * c;
        }
        for (place, entry) in self.places.iter().zip(entries) {
            out[place.row] += entry.bound * y[place.column];
        }
    }

    /// Puts L and U in the place of A, and reciprocals of the pivots beside them.
    #[inline(always)]
    fn eliminate(&self, matrix: &mut [Complex<Lane>], inverse: &mut [Complex<Lane>]) {
        for k in 0..self.order {
            let pivot = matrix[self.at(k, k)];
            let scale = Lane::ONE / (pivot.re * pivot.re + pivot.im * pivot.im);
            inverse[k] = Complex { re: pivot.re * scale, im: -(pivot.im * scale) };
            for row in self.rest(k, self.band[0]) {
                let factor = less_product(ZERO, matrix[self.at(row, k)], inverse[k]);
                // With the opposite sign of what is kept, which `less_product` gives.
                matrix[self.at(row, k)] = Complex { re: -factor.re, im: -factor.im };
                for column in self.rest(k, self.band[1]) {
                    let at = self.at(row, column);
                    matrix[at] = less_product(matrix[at], matrix[self.at(row, k)], matrix[self.at(k, column)]);
                }
            }
        }
    }

    /// The solution from both triangles, in place.
    #[inline(always)]
    fn substitute(&self, matrix: &[Complex<Lane>], inverse: &[Complex<Lane>], x: &mut [Complex<Lane>]) {
        for i in 0..self.order {
            for k in self.left(i) {
                x[i] = less_product(x[i], matrix[self.at(i, k)], x[k]);
            }
        }
        for i in (0..self.order).rev() {
            for j in self.rest(i, self.band[1]) {
                x[i] = less_product(x[i], matrix[self.at(i, j)], x[j]);
            }
            let opposite = less_product(ZERO, x[i], inverse[i]);
            x[i] = Complex { re: -opposite.re, im: -opposite.im };
        }
    }
}

const ZERO: Complex<Lane> = Complex { re: Lane::ZERO, im: Lane::ZERO };

/// sum - x y.
#[inline(always)]
fn less_product(sum: Complex<Lane>, x: Complex<Lane>, y: Complex<Lane>) -> Complex<Lane> {
    Complex { re: sum.re - (x.re * y.re - x.im * y.im), im: sum.im - (x.re * y.im + x.im * y.re) }
}

/// At least the modulus.
#[inline(always)]
fn size(x: Complex<Lane>) -> Lane {
    x.re.abs() + x.im.abs()
}

kernel!(
/// Solutions x + d with bounds v, and where these are proved.
solve, solve_loops, (banded: &Banded, omega: &Pair, work: &mut Work));

#[inline(always)]
fn solve_loops<const FUSED: bool>(banded: &Banded, omega: &Pair, work: &mut Work) {
    fill::<FUSED>(banded, omega, work);
    let Work { right, entries, matrix, moduli, inverse, x, d, sizes, v, again, proved } = work;
    banded.eliminate(matrix, inverse);
    for (x, right) in x.iter_mut().zip(&*right) {
        *x = Complex { re: right.value.re.high, im: right.value.im.high };
    }
    banded.substitute(matrix, inverse, x);
    // What is left of f, and what that is off by.
    for (place, entry) in banded.places.iter().zip(&*entries) {
        let (own, x, Entry { value, bound }) = (&mut right[place.row], x[place.column], entry);
        own.value.re.add_products::<FUSED>(-x.re, &value.re);
        own.value.re.add_products::<FUSED>(x.im, &value.im);
        own.value.im.add_products::<FUSED>(-x.im, &value.re);
        own.value.im.add_products::<FUSED>(-x.re, &value.im);
        own.bound += *bound * size(x);
    }
    for (d, right) in d.iter_mut().zip(&mut *right) {
        let Complex { re, im } = right.value;
        *d = Complex { re: re.high + re.low, im: im.high + im.low };
        right.bound += Lane::splat(U) * size(*d) + Lane::splat(FLOOR);
    }
    banded.substitute(matrix, inverse, d);
    for (modulus, own) in moduli.iter_mut().zip(&*matrix) {
        *modulus = (own.re * own.re + own.im * own.im).sqrt() + Lane::splat(MODULUS_FLOOR);
    }
    for (own, d) in sizes.iter_mut().zip(&*d) {
        *own = size(*d);
    }
    banded.lost(moduli, entries, sizes, v);
    for (v, right) in v.iter_mut().zip(&*right) {
        *v += right.bound;
    }
    banded.spread(moduli, v);
    for v in &mut *v {
        *v = *v * Lane::splat(4.0);
    }
    banded.lost(moduli, entries, v, again);
    banded.spread(moduli, again);
    *proved = Lane::ONE;
    for i in 0..banded.order {
        let pivot = moduli[banded.at(i, i)];
        let is_small = Lane::splat(BOUNDS[1]).above(sizes[i]);
        let contracts = v[i].above(Lane::splat(4.0) * again[i]);
        *proved = *proved * is_within(pivot, PIVOTS) * is_within(v[i], BOUNDS) * is_small * contracts;
    }
}

/// Entries of A, and these in doubles.
#[inline(always)]
fn fill<const FUSED: bool>(banded: &Banded, omega: &Pair, work: &mut Work) {
    let minus = Pair { high: -omega.high, low: -omega.low };
    let mut square = Pair::ZERO;
    square.add_products::<FUSED>(omega.high, omega);
    square.low += omega.low * omega.high;
    let square = square.settled();
    work.matrix.fill(ZERO);
    for (place, entry) in banded.places.iter().zip(&mut work.entries) {
        let [stiffness, mass, velocity] = place.centres;
        let re = Pair::shifted::<FUSED>(stiffness, &square, mass);
        let im = Pair::shifted::<FUSED>(DoubleDouble::ZERO, &minus, velocity);
        let bounds = place.bounds.map(Lane::splat);
        work.matrix[banded.at(place.row, place.column)] = Complex { re: re.high, im: im.high };
        *entry =
            Entry { value: Complex { re, im }, bound: bounds[0] + square.high * bounds[1] + omega.high * bounds[2] };
    }
}

#[inline(always)]
fn is_within(x: Lane, [least, most]: [f64; 2]) -> Lane {
    x.above(Lane::splat(least)) * Lane::splat(most).above(x)
}

/// tan(pi/12) and cos(pi/6).
const TURN: f64 = 0.267_949_192_431_122_7;
const COSINE: f64 = 0.866_025_403_784_438_6;
/// Terms of the series of the arc tangent.
const TERMS: usize = 14;
/// Moduli whose squares stay in range.
const MODULI: [f64; 2] = [power_of_two(-400), power_of_two(400)];

kernel!(
/// Modulus and angle.
///
/// Rounding x + d costs u, the modulus itself 2 u. The angle φ of the smaller part over the larger one is reduced by pi/6 where it is
/// above pi/12; then t = tan φ has |t| ≤ tan(pi/12) and the series of atan t is cut off below 2^-58 |t|. A turn is off by 2.4 u (its
/// cosine and products), t and the sum by 2.3 u |t|, each of pi/6, pi/2 and pi with its addition by 1, 2 and 4 u: in all by 11 u, and
/// where none of these is needed by 2.3 u |φ|. A displacement of at most s|x|, s ≤ 1/8, and the rounding of x + d turn x by less than
/// 1.1 s + 1.5 u, or 1.5 u of the angle.
as_polar, polar_loops, (work: &Work, row: usize) -> Polar);

#[inline(always)]
fn polar_loops<const FUSED: bool>(work: &Work, row: usize) -> Polar {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_6, PI};
    let (x, d) = (work.x[row], work.d[row]);
    let (re, im) = (x.re + d.re, x.im + d.im);
    let bound = work.v[row].choose(work.proved, Lane::splat(f64::INFINITY));
    let modulus = (re * re + im * im).sqrt();
    let (across, up) = (re.abs(), im.abs());
    let is_steep = up.above(across);
    let (long, short) = (up.choose(is_steep, across), across.choose(is_steep, up));
    let is_turned = short.above(long * Lane::splat(TURN));
    let (cosine, sine) = (Lane::splat(COSINE), Lane::splat(0.5));
    let run = (long * cosine + short * sine).choose(is_turned, long);
    let rise = (short * cosine - long * sine).choose(is_turned, short);
    let t = rise / run;
    let z = t * t;
    let mut series = Lane::ZERO;
    for k in (1..TERMS).rev() {
        let sign = if k % 2 == 1 { 1.0 } else { -1.0 };
        series = Lane::splat(sign / (2 * k + 1) as f64) + z * series;
    }
    let mut angle = t - t * z * series;
    angle = (angle + Lane::splat(FRAC_PI_6)).choose(is_turned, angle);
    angle = (Lane::splat(FRAC_PI_2) - angle).choose(is_steep, angle);
    let is_behind = Lane::ZERO.above(re);
    angle = (Lane::splat(PI) - angle).choose(is_behind, angle);
    let is_moved = is_turned + is_steep + is_behind;
    let rounding = Lane::splat(16.0 * U).choose(is_moved, Lane::splat(8.0 * U) * angle);
    let share = Lane::splat(2.0) * bound / modulus;
    let is_certain = Lane::splat(0.125).above(share) * is_within(modulus, MODULI);
    // Where x may be on either side of the real axis, nothing is said of the angle.
    let has_side = is_certain * up.above(Lane::splat(2.0) * bound);
    let infinite = Lane::splat(f64::INFINITY);
    Polar {
        amplitude: modulus,
        amplitude_error: (Lane::splat(2.0) * bound + Lane::splat(8.0 * U) * modulus).choose(is_certain, infinite),
        phase: (-angle).choose(Lane::ZERO.above(im), angle),
        phase_error: (Lane::splat(2.0) * share + rounding).choose(has_side, infinite),
    }
}
