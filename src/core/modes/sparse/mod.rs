//! Some modes of M q̈ + K q = 0 with sparse matrices, each in an interval that holds it, and none missing.
//!
//! Approximations come from Sturm counts and twisted factorizations where the matrices are tridiagonal (`twisted`), else from
//! Lanczos steps about a shift (`lanczos`). Two things are proved: how many eigenvalues there are below a number or between two,
//! from the inertia of a factorization whose rounding is bounded (`shifted`), and that those of a small problem of as
//! many columns enclose them (`proof`), which is solved as any other. Where more are counted than were found, the search goes on.
//!
//! It never forms a dense matrix of all coordinates, and never leaves out an eigenvalue between those it returns.

mod given;
mod lanczos;
mod proof;
mod rows;
mod shifted;
mod twisted;

use std::rc::Rc;

use lanczos::lanczos;
use proof::{Columns, Proof, Window, Zeros, prove};
use rows::Panel;
use shifted::{Factor, Pencil};
use twisted::Bands;

use super::{Mode, ModesError, Options, Spectrum};
use crate::precision::{Ball, LANES, Lane, SparseMatrix, up};

/// K x = ω² M x with sparse matrices.
#[derive(Clone, Debug)]
pub struct SparseProblem {
    /// The mass matrix; positive definite by its diagonal.
    pub mass: SparseMatrix,
    /// The stiffness matrix.
    pub stiffness: SparseMatrix,
}

/// Which modes are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted<'a> {
    /// So many in the order of [`Spectrum::modes`].
    Lowest(usize),
    /// So many whose frequencies are nearest to this one, in rad/s.
    Near(f64, usize),
    /// Those that these vectors approximate, n entries a vector, one after the other: only proved, not looked for. They have to
    /// leave out none between the lowest and the highest of them, but proved zeros.
    Given(&'a [f64]),
}

/// How the modes were found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Sturm counts and twisted factorizations of tridiagonal matrices.
    Tridiagonal,
    /// Lanczos steps with a sparse factorization.
    Lanczos,
    /// The vectors were given.
    Given,
}

/// Two eigenvalues are far enough apart for a count between them if they differ by this part.
const APART: f64 = 1e-3;
/// A pivot that is less than this part of the largest stiffness may be 0.
const SINGULAR: f64 = 1e-10;
/// How often more vectors are looked for.
const SEARCHES: usize = 12;

/// Some modes of a sparse problem. `None` where they are not found or not proved, or M is not positive definite by its diagonal.
/// `zero_vectors` gives independent vectors proved to lie in the kernel of K, as in [`super::Problem`]; they are asked for
/// only where K may be singular.
///
/// # Errors
/// As [`super::solve`], for the small problem of the modes that are wanted.
pub fn solve_sparse(
    problem: &SparseProblem,
    wanted: Wanted<'_>,
    zero_vectors: &mut dyn FnMut() -> Vec<Vec<Ball>>,
    options: &Options,
) -> Result<Option<(Spectrum, Method)>, ModesError> {
    let Some(pencil) = Pencil::new(&problem.stiffness, &problem.mass) else {
        return Ok(None);
    };
    let base = pencil.factor(0.0).filter(|own| own.weakest > SINGULAR);
    let vectors = if base.is_some() { Vec::new() } else { zero_vectors() };
    let Some(zeros) = Zeros::new(&pencil, &vectors) else {
        return Ok(None);
    };
    let base = base.filter(|own| own.negative == 0).map(Rc::new);
    let search = Search { pencil: &pencil, zeros, base, options };
    match wanted {
        Wanted::Lowest(count) => search.lowest(count),
        Wanted::Near(omega, count) => search.near(omega, count),
        Wanted::Given(vectors) => search.given(vectors),
    }
}

/// Vectors that may be all of a window; with what they are proved by at the lower end of the spectrum.
struct Candidates<'a> {
    columns: Columns,
    window: Window,
    positive: Option<Rc<Factor<'a>>>,
}

struct Search<'a> {
    pencil: &'a Pencil,
    zeros: Zeros,
    /// K itself, where it is positive definite.
    base: Option<Rc<Factor<'a>>>,
    options: &'a Options,
}

impl<'a> Search<'a> {
    fn zero_count(&self) -> usize {
        self.zeros.vectors.len()
    }

    fn lowest(&self, count: usize) -> Result<Option<(Spectrum, Method)>, ModesError> {
        let n = self.pencil.dimension();
        let count = count.min(n);
        // Zero modes come before those that oscillate, so that fewer of these are needed; but some mode has to be.
        let elastic = count.saturating_sub(self.zero_count()).max(1).min(n - self.zero_count());
        let tridiagonal = self.pencil.is_tridiagonal().then(|| self.tridiagonal(elastic)).flatten();
        if let Some(spectrum) = self.proved(tridiagonal, count)? {
            return Ok(Some((spectrum, Method::Tridiagonal)));
        }
        let spectrum = self.proved(self.by_lanczos(elastic), count)?;
        Ok(spectrum.map(|spectrum| (spectrum, Method::Lanczos)))
    }

    /// The first modes of candidates, if these are proved.
    fn proved(&self, found: Option<Candidates<'_>>, count: usize) -> Result<Option<Spectrum>, ModesError> {
        let Some(Candidates { columns, window, positive }) = found else {
            return Ok(None);
        };
        let proof = prove(self.pencil, &columns, &self.zeros, window, positive.as_deref(), self.options)?;
        Ok(proof.map(|proof| {
            let mut spectrum = self.spectrum(&columns, &self.zeros, proof);
            spectrum.modes.truncate(count);
            spectrum
        }))
    }

    /// The lowest eigenvalues but the zeros, of tridiagonal matrices: one more than wanted, and further until the next is apart.
    fn tridiagonal(&self, elastic: usize) -> Option<Candidates<'a>> {
        let n = self.pencil.dimension();
        let zeros = self.zero_count();
        let bands = Bands::new(self.pencil)?;
        if zeros > 0 && bands.count(-1e-12 * self.pencil.stiffness_norms.0) > 0 {
            return None;
        }
        let mut end = (zeros + elastic).min(n);
        let (values, panels, next) = loop {
            let starts = bands.bisect(&(zeros..(end + 1).min(n)))?;
            let (own, next) = starts.split_at(end - zeros);
            let next = next.first().copied();
            let last = own.last().copied()?;
            if next.is_some_and(|next| next - last <= APART * next.abs().max(last.abs())) {
                end += 1;
                continue;
            }
            let (values, panels) = bands.pairs(own)?;
            break (values, panels, next);
        };
        let last = values.last().copied()?;
        let columns = Columns { values, panels };
        let window = match next {
            Some(next) => {
                Window { low: None, high: Some(self.counted(last + 0.6 * (next - last), zeros + columns.count())?) }
            }
            None => Window { low: None, high: None },
        };
        Some(Candidates { columns, window, positive: self.positive() })
    }

    /// A number below which there are so many eigenvalues and no more, from a shift.
    fn counted(&self, shift: f64, count: usize) -> Option<f64> {
        let factor = self.pencil.factor(shift)?;
        (factor.negative == count).then(|| below(factor.shift, factor.error))
    }

    /// A factor of K - σM that is positive definite, σ as near to 0 as may be.
    fn positive(&self) -> Option<Rc<Factor<'a>>> {
        if let Some(base) = &self.base {
            return Some(Rc::clone(base));
        }
        let scale = self.pencil.stiffness_norms.0.max(f64::MIN_POSITIVE);
        let mut distance = scale * 1e-9;
        while distance <= 4.0 * scale {
            if let Some(factor) = self.pencil.factor(-distance)
                && factor.negative == 0
            {
                return Some(Rc::new(factor));
            }
            distance *= 30.0;
        }
        None
    }

    /// The lowest eigenvalues but the zeros, by Lanczos steps.
    fn by_lanczos(&self, elastic: usize) -> Option<Candidates<'a>> {
        let n = self.pencil.dimension();
        let zeros = self.zero_count();
        let free = n - zeros;
        let mut factor = self.positive()?;
        let mut known = self.known();
        let base = known.len();
        let mut values: Vec<f64> = Vec::new();
        let mut more = (elastic + 2).min(free);
        for _ in 0..SEARCHES {
            let found = lanczos(self.pencil, &factor, &known, more, true)?;
            // A shift that is far from what is wanted beside it makes all of them alike.
            if let (Some(first), Some(last)) = (found.values.first(), found.values.last())
                && values.is_empty()
                && *first - factor.shift > 100.0 * (*last).abs().max(*first)
                && let Some(nearer) = self.pencil.factor(-first.abs())
                && nearer.negative == 0
            {
                factor = Rc::new(nearer);
                continue;
            }
            known.extend_from_slice(&found.vectors);
            values.extend_from_slice(&found.values);
            let mut order: Vec<usize> = (0..values.len()).collect();
            order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
            if values.len() == free {
                let window = Window { low: None, high: None };
                let columns = self.columns(&known[base..], &values, &order);
                return Some(Candidates { columns, window, positive: Some(factor) });
            }
            // The first place behind those wanted where the next one is apart.
            let value = |k: usize| order.get(k).map(|at| values[*at]);
            let cut = (elastic..values.len()).find_map(|k| {
                let (last, next) = (value(k - 1)?, value(k)?);
                let next = next.min(found.next);
                (next - last > APART * next.abs().max(last.abs())).then_some((k, last + 0.6 * (next - last)))
            });
            let Some((k, shift)) = cut else {
                more = (elastic / 2).max(4).min(free - values.len());
                continue;
            };
            let counted = self.pencil.factor(shift)?;
            let missing = counted.negative.checked_sub(zeros + k)?;
            if missing == 0 {
                order.truncate(k);
                let window = Window { low: None, high: Some(below(counted.shift, counted.error)) };
                let columns = self.columns(&known[base..], &values, &order);
                return Some(Candidates { columns, window, positive: Some(factor) });
            }
            more = (missing + 1).min(free - values.len());
        }
        None
    }

    /// The zero vectors in doubles.
    fn known(&self) -> Vec<f64> {
        self.zeros.vectors.iter().flatten().map(Ball::mid_f64).collect()
    }

    /// Vectors side by side, in an order.
    fn columns(&self, vectors: &[f64], values: &[f64], order: &[usize]) -> Columns {
        let n = self.pencil.dimension();
        let panel = |chunk: &[usize]| -> Panel {
            let mut panel = vec![Lane::ZERO; n];
            for (lane, at) in chunk.iter().enumerate() {
                let own = &vectors[at * n..(at + 1) * n];
                panel.iter_mut().zip(own).for_each(|(panel, x)| panel.0[lane] = *x);
            }
            panel
        };
        Columns {
            values: order.iter().map(|at| values[*at]).collect(),
            panels: order.chunks(LANES).map(panel).collect(),
        }
    }

    /// Bounds for vectors that were given.
    fn given(&self, vectors: &[f64]) -> Result<Option<(Spectrum, Method)>, ModesError> {
        let Some((vectors, values)) = given::ritz(self.pencil, vectors) else {
            return Ok(None);
        };
        let (Some(first), Some(last)) = (values.first().copied(), values.last().copied()) else {
            return Ok(None);
        };
        let order: Vec<usize> = (0..values.len()).collect();
        let columns = self.columns(&vectors, &values, &order);
        // As far as the next eigenvalues may be away: the farther, the sharper.
        for apart in [0.1, 1e-2, 1e-3, 1e-4, 1e-6] {
            let shift = |value: f64, side: f64| self.pencil.factor(value + side * apart * value.abs());
            let Some(high) = shift(last, 1.0) else { continue };
            // Where there are no more but zeros below, nothing has to be counted there.
            let lowest = high.negative == self.zero_count() + values.len();
            let low = if lowest { None } else { shift(first, -1.0) };
            if !lowest && low.as_ref().map(|low| low.negative + values.len()) != Some(high.negative) {
                continue;
            }
            let low = low.map(|low| low.shift + up(low.error));
            let window = Window { low, high: Some(below(high.shift, high.error)) };
            let none = Zeros::none();
            let zeros = if lowest { &self.zeros } else { &none };
            let positive = self.positive().filter(|_| lowest);
            if let Some(proof) = prove(self.pencil, &columns, zeros, window, positive.as_deref(), self.options)? {
                return Ok(Some((self.spectrum(&columns, zeros, proof), Method::Given)));
            }
        }
        Ok(None)
    }

    fn near(&self, omega: f64, count: usize) -> Result<Option<(Spectrum, Method)>, ModesError> {
        let n = self.pencil.dimension();
        let count = count.min(n);
        let Some((columns, window)) = self.about(omega, count) else {
            return Ok(None);
        };
        let Some(columns) = columns else {
            // The window reaches 0: all below its upper end.
            let Some(high) = window.high else { return Ok(None) };
            let Some(factor) = self.pencil.factor(high) else { return Ok(None) };
            let Some((mut spectrum, method)) = self.lowest(factor.negative)? else { return Ok(None) };
            keep_nearest(&mut spectrum.modes, count, |mode| (mode.omega.mid_f64() - omega).abs());
            return Ok(Some((spectrum, method)));
        };
        let zeros = Zeros::none();
        let proof = prove(self.pencil, &columns, &zeros, window, None, self.options)?;
        Ok(proof.map(|proof| {
            let mut spectrum = self.spectrum(&columns, &zeros, proof);
            keep_nearest(&mut spectrum.modes, count, |mode| (mode.omega.mid_f64() - omega).abs());
            (spectrum, Method::Lanczos)
        }))
    }

    /// Columns about a frequency and the window that they fill; none where the window reaches 0.
    fn about(&self, omega: f64, count: usize) -> Option<(Option<Columns>, Window)> {
        let n = self.pencil.dimension();
        let shift = omega * omega;
        let scale = self.pencil.stiffness_norms.0;
        // A shift on an eigenvalue has no factor.
        let factor = (0..8).find_map(|k| self.pencil.factor(shift + f64::from(k) * 1e-9 * shift.max(1e-6 * scale)))?;
        let mut known: Vec<f64> = Vec::new();
        let mut values: Vec<f64> = Vec::new();
        let mut more = (count + 2).min(n);
        for _ in 0..SEARCHES {
            let found = lanczos(self.pencil, &factor, &known, more, false)?;
            known.extend_from_slice(&found.vectors);
            values.extend_from_slice(&found.values);
            let distance = |value: f64| (value.max(0.0).sqrt() - omega).abs();
            let mut order: Vec<usize> = (0..values.len()).collect();
            order.sort_by(|a, b| distance(values[*a]).total_cmp(&distance(values[*b])));
            let at = |k: usize| order.get(k).map(|at| distance(values[*at]));
            let cut = (count..values.len()).find_map(|k| {
                let (last, next) = (at(k - 1)?, at(k)?);
                (next - last > APART * next).then_some((k, last + 0.6 * (next - last)))
            });
            let Some((k, reach)) = cut else {
                if values.len() == n {
                    return Some((None, Window { low: None, high: Some(4.0 * scale) }));
                }
                more = (count / 2).max(4).min(n - values.len());
                continue;
            };
            let high = (omega + reach) * (omega + reach);
            if reach >= omega {
                return Some((None, Window { low: None, high: Some(high) }));
            }
            let low = (omega - reach) * (omega - reach);
            let (above, under) = (self.pencil.factor(high)?, self.pencil.factor(low)?);
            let counted = above.negative.checked_sub(under.negative)?;
            let missing = counted.checked_sub(k)?;
            if missing == 0 {
                order.truncate(k);
                order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
                let window = Window { low: Some(low + up(under.error)), high: Some(below(high, above.error)) };
                return Some((Some(self.columns(&known, &values, &order)), window));
            }
            more = (missing + 1).min(n - values.len());
        }
        None
    }

    /// The modes of the small problem in all coordinates.
    fn spectrum(&self, columns: &Columns, zeros: &Zeros, proof: Proof) -> Spectrum {
        let Proof { mut spectrum, outside } = proof;
        if self.options.vectors {
            let widest = columns.widest(zeros);
            for (mode, outside) in spectrum.modes.iter_mut().zip(&outside) {
                self.expand((columns, zeros), mode, *outside, widest);
            }
        }
        spectrum
    }

    /// The shape of a mode from its coefficients.
    fn expand(&self, (columns, zeros): (&Columns, &Zeros), mode: &mut Mode, outside: f64, widest: f64) {
        let n = self.pencil.dimension();
        let mut vector = vec![0.0; n];
        for (coefficient, zero) in mode.vector.iter().zip(&zeros.vectors) {
            vector.iter_mut().zip(zero).for_each(|(x, z)| *x += coefficient * z.mid_f64());
        }
        for (number, panel) in columns.panels.iter().enumerate() {
            let mut own = [0.0; LANES];
            let part = mode.vector.iter().skip(zeros.vectors.len() + number * LANES);
            own.iter_mut().zip(part).for_each(|(own, coefficient)| *own = *coefficient);
            for (x, lane) in vector.iter_mut().zip(panel) {
                *x += lane.0.iter().zip(&own).map(|(x, c)| x * c).sum::<f64>();
            }
        }
        let size = mode.vector.len() as f64;
        let coefficients: f64 = mode.vector.iter().map(|c| c.abs()).sum();
        let largest = vector.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        // The part outside, in its largest component; what it takes from the length; coefficients; roundings.
        let beside = outside / self.pencil.least_weight.sqrt() + largest * outside * outside;
        let rounding = f64::EPSILON * (size + 2.0) * widest * (coefficients + 1.0);
        mode.vector_error_bound = up(beside + mode.vector_error_bound * widest + rounding);
        let first = vector.iter().find(|x| x.abs() >= largest * (1.0 - 1e-6));
        if first.is_some_and(|x| *x < 0.0) {
            vector.iter_mut().for_each(|x| *x = -*x);
        }
        mode.vector = vector;
    }
}

impl Columns {
    /// The largest sum of magnitudes of one component of all columns.
    fn widest(&self, zeros: &Zeros) -> f64 {
        let n = self.panels.first().map_or(0, Vec::len);
        let row = |i: usize| {
            let own = self.panels.iter().map(|panel| panel[i].0.iter().map(|x| x.abs()).sum::<f64>());
            own.sum::<f64>() + zeros.vectors.iter().map(|z| z[i].abs_upper()).sum::<f64>()
        };
        up((0..n).map(row).fold(0.0, f64::max))
    }
}

/// A number below a shift by what its factorization may be off.
fn below(shift: f64, error: f64) -> f64 {
    (shift - error).next_down().next_down()
}

/// Keeps so many modes that are nearest by some distance, in their order.
pub(crate) fn keep_nearest<M>(modes: &mut Vec<M>, count: usize, distance: impl Fn(&M) -> f64) {
    let mut order: Vec<usize> = (0..modes.len()).collect();
    order.sort_by(|a, b| distance(&modes[*a]).total_cmp(&distance(&modes[*b])));
    let mut kept = vec![false; modes.len()];
    order.into_iter().take(count).for_each(|at| kept[at] = true);
    let mut kept = kept.into_iter();
    modes.retain(|_| kept.next() == Some(true));
}
