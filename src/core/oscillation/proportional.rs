//! Friction that is proportional to inertia and stiffness, C = a M + b K, of sparse models: shapes are those without friction, and exponents
//! the zeros of s² + (a + b λ) s + λ with λ the ω² without (Rayleigh's friction).
//!
//! What is known of C leaves a remainder E = C - a M - b K of rounding. With |xᵀEy| ≤ ε where xᵀMx = yᵀMy = 1, exponents lie where
//! |s² + (a + b λ) s + λ| ≤ ε |s| for some λ, as many in each part of that as zeros without E (P. Lancaster, Lambda-matrices and vibrating
//! systems, 1966, chapter 7). Real ones stay real, as xᵀ(2 s M + C) x has one sign for all their shapes (I. Gohberg, P. Lancaster,
//! L. Rodman, Matrix polynomials, 1982, chapter 10). Nothing is found here where friction turns the order of the frequencies round.

use faer::c64;

use crate::modes::exponents::{Exponent, Exponents, finish};
use crate::modes::{Kind, Mode, Options, Spectrum, Stability, Wanted};
use crate::precision::{Ball, SparseMatrix};

/// A remainder is no more than this beside what the friction is.
const ROUNDING: f64 = 1e-24;
/// The extra modes tell how far from others the last one is.
const BEYOND: usize = 2;

/// C = a M + b K.
pub(super) struct Proportional {
    a: Ball,
    b: Ball,
    /// ε.
    remainder: f64,
    /// Below all eigenvalues of M.
    least_mass: f64,
    /// Above all λ.
    highest: f64,
}

/// The largest sum in a row, in units in which the diagonal of M is 1.
fn norm(matrix: &SparseMatrix, scale: &[f64], with_diagonal: bool) -> f64 {
    let mut rows = vec![0.0; matrix.dimension()];
    for (i, j, entry) in matrix.entries().filter(|(i, j, _)| with_diagonal || i != j) {
        let size = entry.abs_upper() * scale[i] * scale[j];
        rows[i] += size;
        if i != j {
            rows[j] += size;
        }
    }
    rows.into_iter().fold(0.0, f64::max) * (1.0 + 1e-12)
}

fn entry(matrix: &SparseMatrix, i: usize, j: usize) -> Ball {
    let (rows, values) = matrix.column(j);
    rows.binary_search(&(i as u32)).map_or(Ball::ZERO, |at| values[at])
}

/// The middle alone.
fn exact(x: Ball) -> Ball {
    Ball { radius: 0.0, ..x }
}

impl Proportional {
    /// From lower triangles; `None` where C is not proportional, or M not positive definite by its diagonal.
    pub(super) fn new(mass: &SparseMatrix, stiffness: &SparseMatrix, damping: &SparseMatrix) -> Option<Self> {
        let n = mass.dimension();
        let diagonal: Vec<f64> = (0..n).map(|i| entry(mass, i, i).lower()).collect();
        if n == 0 || diagonal.iter().any(|own| *own <= 0.0) {
            return None;
        }
        let scale: Vec<f64> = diagonal.iter().map(|own| (1.0 / own.sqrt()).next_up()).collect();
        let share = 1.0 - norm(mass, &scale, false);
        let [m0, k0, c0] = [mass, stiffness, damping].map(|own| entry(own, 0, 0));
        let other = stiffness.entries().find_map(|(i, j, k)| {
            let [m, c] = [mass, damping].map(|own| entry(own, i, j));
            let (along, across) = (m0 * *k, k0 * m);
            let apart = along - across;
            let is_apart = apart.mid_f64().abs() > 1e-3 * (along.mid_f64().abs() + across.mid_f64().abs());
            is_apart.then(|| [(c0 * *k - k0 * c) / apart, (m0 * c - c0 * m) / apart])
        });
        let [a, b] = other.unwrap_or_else(|| [c0 / m0, Ball::ZERO]).map(exact);
        let of = |(i, j, value): (usize, usize, Ball)| (i as u32, j as u32, value);
        let shares = damping.entries().map(|(i, j, c)| (i, j, *c));
        let shares = shares.chain(mass.entries().map(|(i, j, m)| (i, j, -(a * *m))));
        let shares = shares.chain(stiffness.entries().map(|(i, j, k)| (i, j, -(b * *k))));
        let rest = SparseMatrix::from_shares(n, &shares.map(of).collect::<Vec<_>>());
        let remainder = norm(&rest, &scale, true) / share;
        let least_mass = diagonal.into_iter().fold(f64::INFINITY, f64::min) * share * (1.0 - 1e-12);
        let highest = norm(stiffness, &scale, true) / share;
        let is_proportional = share > 0.0 && remainder <= ROUNDING * norm(damping, &scale, true);
        // ω² - γ²/4 rises with λ.
        let rises = (b * (a + b * Ball::exact(highest)) - Ball::exact(2.0)).is_negative();
        (is_proportional && rises).then_some(Self { a, b, remainder, least_mass, highest })
    }

    /// The friction of a mode, over its inertia.
    fn rate(&self, lambda: Ball) -> Ball {
        self.a + self.b * lambda
    }

    /// The square of a frequency with friction.
    fn slowed(&self, lambda: Ball) -> Ball {
        lambda - self.rate(lambda).powi(2).scale(-2)
    }

    /// What is to be found without friction: some more than is wanted with it.
    pub(super) fn without<'w>(&self, wanted: Wanted<'w>) -> Wanted<'w> {
        match wanted {
            Wanted::Near(omega, count) => {
                let (mut low, mut high) = (0.0, self.highest);
                for _ in 0..200 {
                    let middle = 0.5 * (low + high);
                    let is_below = self.slowed(Ball::exact(middle)).mid_f64() < omega * omega;
                    *(if is_below { &mut low } else { &mut high }) = middle;
                }
                Wanted::Near(high.sqrt(), count + BEYOND)
            }
            Wanted::Lowest(count) => Wanted::Lowest(count + BEYOND),
            Wanted::Given(_) => wanted,
        }
    }

    /// The exponents that are wanted, from modes without friction; `None` where these are not all that they have to be.
    pub(super) fn exponents(
        &self,
        spectrum: Spectrum,
        (wanted, asked): (Wanted<'_>, Wanted<'_>),
        options: &Options,
        (is_passive, is_free): (bool, bool),
    ) -> Option<Exponents> {
        let Spectrum { mut modes, stability, level, .. } = spectrum;
        let is_known = |mode: &Mode| mode.omega_squared.is_positive() || mode.kind == Kind::Zero;
        if !modes.iter().all(|mode| is_known(mode) && mode.precise.is_none()) {
            return None;
        }
        let frequency = |mode: &Mode| self.slowed(mode.omega_squared).sqrt().mid_f64();
        // No other λ lies between these.
        let (below, above) = match (wanted, asked) {
            (Wanted::Near(omega, count), Wanted::Near(middle, _)) => {
                let reach = modes.iter().map(|mode| (mode.omega.mid_f64() - middle).abs()).fold(0.0, f64::max);
                let reach = reach * (1.0 - 1e-12);
                let ends = [middle - reach, middle + reach].map(|end| end.max(0.0).powi(2));
                let off = |mode: &Mode| (frequency(mode) - omega).abs();
                modes.sort_by(|x, y| off(x).total_cmp(&off(y)));
                let most = modes.get(count.checked_sub(1)?).map(off)?;
                let is_within = |end: f64| {
                    let end = self.slowed(Ball::exact(end));
                    let end = if end.is_positive() { end.sqrt().mid_f64() } else { 0.0 };
                    (end - omega).abs() > most * (1.0 + 1e-9)
                };
                if !ends.into_iter().all(is_within) {
                    return None;
                }
                (ends[0], ends[1])
            }
            _ => (f64::NEG_INFINITY, modes.last()?.omega_squared.lower()),
        };
        let (count, kept) = match (wanted, asked) {
            (Wanted::Lowest(count), Wanted::Lowest(all)) if modes.len() >= all => (count, modes.len() - 1),
            (Wanted::Near(_, count), Wanted::Near(_, all)) if modes.len() >= all => (count, count),
            _ => return None,
        };
        let least = modes.first().filter(|_| below.is_infinite()).map_or(0.0, |mode| mode.omega_squared.lower());
        let takes = |lambda: f64| (self.rate(Ball::exact(lambda)) - Ball::exact(self.remainder)).is_positive();
        let is_passive = is_passive || takes(least) && takes(self.highest);
        // What grows comes first, and may be anywhere.
        if matches!(wanted, Wanted::Lowest(_)) && !is_passive {
            return None;
        }
        // The last ones beyond those that are wanted may not be apart from the next.
        let entries = modes[..kept].iter().map_while(|mode| match mode.kind {
            Kind::Zero if is_free => Some([Some(zero(mode)), None]),
            _ => self.exponents_of(mode, &modes, (below, above)),
        });
        let mut entries: Vec<[Option<Exponent>; 2]> = entries.collect();
        // Of those that do not oscillate the fast ones come behind the slow ones of all.
        let is_real = |own: &[Option<Exponent>; 2]| own[1].is_some();
        if entries.iter().all(is_real) {
            entries.iter_mut().for_each(|own| own[1] = None);
        }
        if matches!(wanted, Wanted::Near(..)) && entries.iter().any(is_real) {
            return None;
        }
        let entries: Vec<Exponent> = entries.into_iter().flatten().flatten().collect();
        let Exponents { entries, secular, .. } = finish(entries, level, options, &|_| true);
        let entries: Vec<Exponent> = entries.into_iter().take(count).collect();
        let is_done =
            |own: &Exponent| [own.omega, own.growth].iter().all(|part| part.is_zero() || options.covers(part, false));
        let is_certain = stability == Stability::Stable || stability == Stability::Neutral;
        let stability = if is_certain && is_passive { stability } else { Stability::Undecided };
        let is_all = entries.len() == count && entries.iter().all(is_done);
        is_all.then_some(Exponents { entries, stability, secular, level })
    }

    /// The exponent of a mode that oscillates, or the slow and the fast one of a mode that does not.
    fn exponents_of(&self, mode: &Mode, all: &[Mode], (below, above): (f64, f64)) -> Option<[Option<Exponent>; 2]> {
        let lambda = mode.omega_squared;
        let (rate, square) = (self.rate(lambda), self.slowed(lambda));
        let half = rate.scale(-1);
        let equal = all.iter().filter(|other| other.cluster == mode.cluster).count();
        let others = all.iter().filter(|other| other.cluster != mode.cluster).map(|other| {
            let apart = other.omega_squared - lambda;
            apart.mid_f64().abs() - apart.radius
        });
        let gap = others.fold((lambda.lower() - below).min(above - lambda.abs_upper()), f64::min);
        if !rate.is_positive() || gap <= 0.0 {
            return None;
        }
        let exponent = |kind: Kind, growth: Ball, omega: Ball, apart: f64| {
            // |s² + (a + b λ) s + λ| is |s - s₁| |s - s₂|.
            let size = growth.abs_upper().hypot(omega.abs_upper());
            let radius = 8.0 * equal as f64 * self.remainder * size / apart;
            // Of another λ' the polynomial is (λ' - λ) (1 + b s) there.
            let [re, im] = [Ball::ONE + self.b * growth, self.b * omega].map(|part| part.mid_f64());
            let slope = re.hypot(im);
            let turn = 4.0 * self.remainder * size / (gap * slope);
            let is_definite =
                turn * turn * (2.0 * size + self.rate(Ball::exact(self.highest)).abs_upper()) < 0.1 * apart;
            let growth = growth.with_added_radius(radius);
            (radius <= 0.1 * apart && slope >= 0.1 && (omega.is_positive() || is_definite)).then(|| Exponent {
                kind,
                growth,
                omega: if omega.is_zero() { omega } else { omega.with_added_radius(radius) },
                omega_squared: omega.is_zero().then(|| -(growth * growth)),
                precise: None,
                vector: mode.vector.iter().map(|x| c64::new(*x, 0.0)).collect(),
                vector_error_bound: (mode.vector_error_bound + turn / self.least_mass.sqrt()).next_up(),
                cluster: mode.cluster,
                limit: None,
            })
        };
        if square.is_positive() {
            let omega = square.sqrt();
            return Some([Some(exponent(Kind::Damped, -half, omega, 2.0 * omega.lower())?), None]);
        }
        if !square.is_negative() {
            return None;
        }
        let root = (-square).sqrt();
        let fast = -half - root;
        // The slow one by the product of both: no digits cancel.
        let both =
            [lambda / fast, fast].map(|growth| exponent(Kind::Overdamped, growth, Ball::ZERO, 2.0 * root.lower()));
        let [slow, fast] = both;
        let slow = if mode.kind == Kind::Zero { zero(mode) } else { slow? };
        Some([Some(slow), Some(Exponent { cluster: u32::MAX - mode.cluster, ..fast? })])
    }
}

/// A motion that no force and no friction brings back.
fn zero(mode: &Mode) -> Exponent {
    let vector = mode.vector.iter().map(|x| c64::new(*x, 0.0)).collect();
    Exponent {
        kind: Kind::Zero,
        ..Exponent::new(Ball::ZERO, Ball::ZERO, (vector, mode.vector_error_bound), mode.cluster)
    }
}
