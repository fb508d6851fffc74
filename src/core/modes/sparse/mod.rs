//! Some modes of M q̈ + K q = 0 with sparse matrices, each in an interval that holds it, and none missing.
//!
//! Approximations come from Sturm counts and twisted factorizations where the matrices are tridiagonal (`twisted`), else from
//! Lanczos steps about a shift (`lanczos`). Two things are proved: how many eigenvalues there are below a number or between two,
//! from the inertia of a factorization whose rounding is bounded (`shifted`), and that those of a small problem of as
//! many columns enclose them (`proof`), which is solved as any other. Where more are counted than were found, the search goes on.
//!
//! It never forms a dense matrix of all coordinates, and never leaves out an eigenvalue between those it returns.

mod bordered;
mod given;
mod lanczos;
mod order;
mod proof;
mod quadratic;
mod response;
mod rows;
mod shifted;
mod twisted;
mod whole;

use std::rc::Rc;
use std::thread;

use lanczos::{Found, dot, lanczos};
use proof::{Columns, Proof, Window, Zeros, prove};
pub use quadratic::{SparseQuadratic, solve_sparse_quadratic};
pub use response::{SparseResponse, is_definite};
use rows::Panel;
use shifted::{Factor, Pencil};
use twisted::Bands;
pub use whole::solve_tridiagonal;

use super::dense::Matrix;
use super::shape::{echelon, finish};
use super::{Mode, ModesError, Options, Spectrum, Stability};
use crate::budget::{Budget, Exceeded};
use crate::order::{Order, places};
use crate::precision::{Ball, DoubleDouble, LANES, Lane, SparseMatrix, up};

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
    /// Those that these vectors approximate, n entries a vector, one after the other: only proved, not searched for. They have to
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
    /// Arnoldi steps with a sparse factorization, for exponents.
    Arnoldi,
    /// The vectors were given.
    Given,
}

/// Two eigenvalues are far enough apart for a count between them if they differ by this part.
const APART: f64 = 1e-3;
/// A pivot that is less than this part of the largest stiffness may be 0.
const SINGULAR: f64 = 1e-10;
/// This part of the largest stiffness is next to 0.
const NEXT: f64 = 1e-9;
/// A factor to search with is off by no more than this part of the largest stiffness, where there is another.
const USABLE: f64 = 1e-7;
/// How often more vectors are searched for.
const SEARCHES: usize = 12;

/// Some modes of a sparse problem. `None` where they are not found or not proved, M is not positive definite by its diagonal, or
/// the budget is spent, which memory is asked of before it is taken.
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
    budget: &Budget,
) -> Result<Option<(Spectrum, Method)>, ModesError> {
    budget.at("the order of elimination", None);
    let Some(pencil) = Pencil::new(&problem.stiffness, &problem.mass) else {
        budget.tell(|| "M is not positive definite by its diagonal".to_owned());
        return Ok(None);
    };
    if room(&pencil, wanted, options, budget).is_err() {
        return Ok(None);
    }
    budget.tell(|| solver(&pencil, wanted));
    let search = Search { pencil: &pencil, zeros: Zeros::default(), base: None, options, budget };
    let mut whole = || search.with_zeros(zero_vectors);
    match wanted {
        Wanted::Lowest(count) => whole().map_or(Ok(None), |search| search.lowest(count)),
        Wanted::Near(omega, count) => search.near(omega, count, whole),
        Wanted::Given(vectors) => whole().map_or(Ok(None), |search| search.given(vectors)),
    }
}

/// That there is memory for what a search holds at a time, before any of it is taken: factors, and a basis with what it is cut down to, or
/// panels of eight vectors.
fn room(pencil: &Pencil, wanted: Wanted<'_>, options: &Options, budget: &Budget) -> Result<(), Exceeded> {
    let (n, fill) = (pencil.dimension(), pencil.fill());
    let (count, factors) = match wanted {
        Wanted::Lowest(count) => (count, 2),
        Wanted::Near(_, count) => (count, 4),
        Wanted::Given(vectors) => (vectors.len() / n.max(1), 3),
    };
    let count = count.min(n);
    let vectors = match (pencil.is_tridiagonal(), options.vectors) {
        (true, true) => 2 * count + 32,
        (true, false) => count + 32,
        (false, _) => 3 * count + 84,
    };
    let bytes = |count: usize, each: usize| (count as u64).saturating_mul(8 * each as u64);
    let (of_factors, of_vectors) = (bytes(factors, fill), bytes(vectors, n));
    let total = of_factors.saturating_add(of_vectors);
    if of_factors > of_vectors {
        let what = format!("{factors} triangular factors of K - s M with {fill} entries each, and {vectors} vectors");
        let instead =
            "how many entries there are depends on what is coupled with what, not on how many modes are wanted";
        budget.room_for(what, total, instead)
    } else {
        let what = format!("{vectors} vectors of {n} components, and {factors} triangular factors of K - s M");
        budget.room_for(what, total, "fewer modes take less")
    }
}

/// What is done, and why, in words.
fn solver(pencil: &Pencil, wanted: Wanted<'_>) -> String {
    let factors = if pencil.is_tridiagonal() {
        "tridiagonal L D L^T".to_owned()
    } else {
        format!("sparse L D L^T, {} entries", pencil.fill())
    };
    match wanted {
        Wanted::Lowest(_) | Wanted::Near(..) if pencil.is_tridiagonal() => {
            "solver: Sturm counts and twisted factorizations, since M and K are tridiagonal".to_owned()
        }
        Wanted::Lowest(_) | Wanted::Near(..) => format!("solver: block Lanczos steps, {factors}"),
        Wanted::Given(_) => format!("solver: bounds for given vectors, {factors}"),
    }
}

/// K - σ M as L D Lᵀ, unless the budget is spent.
fn factor<'a>(pencil: &'a Pencil, shift: f64, budget: &Budget) -> Option<Factor<'a>> {
    budget.at("a factorization of K - s M", None);
    if budget.is_spent() { None } else { pencil.factor(shift) }
}

/// Tells what a factorization counts.
fn told<'a>(shift: f64, factor: Option<Factor<'a>>, budget: &Budget) -> Option<Factor<'a>> {
    budget.tell(|| match &factor {
        Some(own) => format!("inertia at omega^2 = {} +- {:.1e}: {} below", short(shift), own.error, own.negative),
        None => format!("inertia at omega^2 = {}: none, a pivot is 0", short(shift)),
    });
    factor
}

/// A number for people, with what tells neighbours apart.
fn short(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:.6e}") }
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
    /// K - σM that is positive definite, with σ 0 or next to it.
    base: Option<Rc<Factor<'a>>>,
    options: &'a Options,
    budget: &'a Budget,
}

impl<'a> Search<'a> {
    fn factor(&self, shift: f64) -> Option<Factor<'a>> {
        told(shift, factor(self.pencil, shift, self.budget), self.budget)
    }

    /// Two of them, at a time where there are two threads.
    fn factors(&self, shifts: [f64; 2]) -> [Option<Factor<'a>>; 2] {
        let (pencil, budget, [one, other]) = (self.pencil, self.budget, shifts);
        let [first, second] = if self.options.threads < 2 {
            [factor(pencil, one, budget), factor(pencil, other, budget)]
        } else {
            thread::scope(|scope| {
                let other = scope.spawn(move || factor(pencil, other, budget));
                [factor(pencil, one, budget), other.join().ok().flatten()]
            })
        };
        [told(one, first, budget), told(other, second, budget)]
    }

    /// Vectors next to the shift of a factor.
    fn lanczos(&self, factor: &Factor<'_>, known: &[f64], wanted: usize, above: bool) -> Option<Found> {
        self.budget.at("the search for the modes", None);
        let found = lanczos(factor, known, wanted, above).filter(|_| !self.budget.is_spent());
        self.budget.tell(|| match &found {
            Some(found) => format!("Lanczos steps about {}: {} vectors", short(factor.shift), found.values.len()),
            None => format!("Lanczos steps about {}: no convergence", short(factor.shift)),
        });
        found
    }

    /// With the zeros and what is positive definite next to K; `None` where the zero vectors are not told apart.
    fn with_zeros(&self, zero_vectors: &mut dyn FnMut() -> Vec<Vec<Ball>>) -> Option<Self> {
        let is_positive = |own: &Factor<'_>| own.negative == 0;
        let search = |vectors: Vec<Vec<Ball>>, base: Option<Factor<'a>>| {
            Some(Self { zeros: Zeros::new(self.pencil, vectors)?, base: base.map(Rc::new), ..*self })
        };
        // What is next to a singular K is positive definite, too, and tells whether K is singular, so that one elimination does.
        let shift = -NEXT * self.pencil.stiffness_norms.0;
        let near = (!self.pencil.is_tridiagonal()).then(|| self.factor(shift)).flatten();
        let near = near.filter(is_positive);
        let least = near.as_ref().map_or(f64::INFINITY, Factor::least);
        if near.is_some() && least > -1e3 * shift {
            return search(Vec::new(), near);
        }
        let may_be_singular = least < -2.0 * shift;
        let mut vectors = if may_be_singular { zero_vectors() } else { Vec::new() };
        if !vectors.is_empty() {
            return search(vectors, near);
        }
        let own = self.factor(0.0).filter(|own| own.weakest > SINGULAR);
        if own.is_none() && !may_be_singular {
            vectors = zero_vectors();
        }
        search(vectors, own.filter(is_positive).or(near))
    }

    fn zero_count(&self) -> usize {
        self.zeros.vectors.len()
    }

    fn lowest(&self, count: usize) -> Result<Option<(Spectrum, Method)>, ModesError> {
        let n = self.pencil.dimension();
        let count = count.min(n);
        // Zero modes come before those that oscillate, so that fewer of these are needed; but some mode has to be.
        let elastic = count.saturating_sub(self.zero_count()).max(1).min(n - self.zero_count());
        let tridiagonal = self.pencil.is_tridiagonal().then(|| self.tridiagonal(elastic)).flatten();
        if self.pencil.is_tridiagonal() && tridiagonal.is_none() {
            self.budget
                .tell(|| "solver: block Lanczos steps, since the matrices split or counts do not agree".to_owned());
        }
        let first = |found: Option<Candidates<'_>>, method| -> Result<Option<(Spectrum, Method)>, ModesError> {
            let Some(mut spectrum) = found.map_or(Ok(None), |found| self.proved(&found, &self.zeros))? else {
                return Ok(None);
            };
            spectrum.modes.truncate(count);
            Ok(Some((spectrum, method)))
        };
        match first(tridiagonal, Method::Tridiagonal)? {
            None => first(self.by_lanczos(elastic), Method::Lanczos),
            found => Ok(found),
        }
    }

    /// The modes of candidates, beside zeros, if these are proved.
    fn proved(&self, found: &Candidates<'_>, zeros: &Zeros) -> Result<Option<Spectrum>, ModesError> {
        let Candidates { columns, window, positive } = found;
        self.budget.at("the proof of the modes", None);
        let proof = prove(self.pencil, columns, zeros, *window, positive.as_deref(), self.options)?;
        self.budget.tell(|| {
            let end = |end: Option<f64>| end.map_or("the end".to_owned(), short);
            let (low, high) = (end(window.low), end(window.high));
            let how = if proof.is_some() { "proved" } else { "not proved" };
            format!("{} modes from {low} to {high}: {how}", columns.count() + zeros.vectors.len())
        });
        Ok(proof.map(|proof| self.spectrum(columns, zeros, proof)))
    }

    /// The lowest eigenvalues but the zeros, of tridiagonal matrices: one more than wanted, and further until the next is apart.
    fn tridiagonal(&self, elastic: usize) -> Option<Candidates<'a>> {
        let n = self.pencil.dimension();
        let zeros = self.zero_count();
        self.budget.at("the search for the modes", None);
        let bands = Bands::new(self.pencil)?;
        if zeros > 0 && bands.count(-1e-12 * self.pencil.stiffness_norms.0) > 0 {
            return None;
        }
        // All that are close to the last one that is wanted, searched for among twice as many each time.
        let wanted = elastic.min(n.saturating_sub(zeros));
        if wanted == 0 {
            return None;
        }
        let mut most = wanted;
        let (starts, count) = loop {
            let starts = bands.bisect(&(zeros..(zeros + most + 1).min(n)))?;
            let is_end = |count: &usize| match starts.get(count - 1..).and_then(|own| own.get(..2)) {
                Some([last, next]) => next - last > APART * next.abs().max(last.abs()),
                _ => true,
            };
            match (wanted..=most).find(is_end) {
                Some(count) => break (starts, count),
                None => most = (2 * most).min(n - zeros),
            }
        };
        let next = starts.get(count).copied();
        let (values, panels) = bands.pairs(starts.get(..count)?)?;
        let last = values.last().copied()?;
        let columns = Columns { values, panels };
        let high = match next {
            Some(next) => Some(self.counted(last + 0.6 * (next - last), zeros + columns.count())?),
            None => None,
        };
        Some(Candidates { columns, window: Window { low: None, high }, positive: self.positive() })
    }

    /// A number below which there are so many eigenvalues and no more, from a shift.
    fn counted(&self, shift: f64, count: usize) -> Option<f64> {
        let factor = self.factor(shift)?;
        (factor.negative == count).then(|| below(factor.shift, factor.error))
    }

    /// A factor of K - σM that is positive definite, σ as near to 0 as may be.
    fn positive(&self) -> Option<Rc<Factor<'a>>> {
        if let Some(base) = &self.base {
            return Some(Rc::clone(base));
        }
        let scale = self.pencil.stiffness_norms.0.max(f64::MIN_POSITIVE);
        // What is next to K was tried already, where its factor is no mere band.
        let mut distance = scale * if self.pencil.is_tridiagonal() { NEXT } else { 30.0 * NEXT };
        while distance <= 4.0 * scale {
            if let Some(factor) = self.factor(-distance)
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
            let found = self.lanczos(&factor, &known, more, true)?;
            // A shift that is far from what is wanted beside it makes all of them alike.
            if let (Some(first), Some(last)) = (found.values.first(), found.values.last())
                && values.is_empty()
                && *first - factor.shift > 100.0 * (*last).abs().max(*first)
                && let Some(nearer) = self.factor(-first.abs())
                && nearer.negative == 0
            {
                factor = Rc::new(nearer);
                continue;
            }
            known.extend_from_slice(&found.vectors);
            values.extend_from_slice(&found.values);
            let mut order = ordered(&values);
            if values.len() == free {
                let window = Window { low: None, high: None };
                let columns = self.columns(&known[base..], &values, &order);
                return Some(Candidates { columns, window, positive: Some(factor) });
            }
            let Some((k, shift)) = gap(&values, &order, elastic, found.next) else {
                more = (elastic / 2).max(4).min(free - values.len());
                continue;
            };
            let counted = self.factor(shift)?;
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
        let Some((vectors, values)) = given::ritz(self.pencil, vectors) else { return Ok(None) };
        let (Some(first), Some(last)) = (values.first().copied(), values.last().copied()) else { return Ok(None) };
        let order: Vec<usize> = (0..values.len()).collect();
        let columns = self.columns(&vectors, &values, &order);
        let mut found = Candidates { columns, window: Window { low: None, high: None }, positive: None };
        // As far as the next eigenvalues may be away: the farther, the sharper.
        for apart in [0.1, 1e-2, 1e-3, 1e-4, 1e-6] {
            let shift = |value: f64, side: f64| self.factor(value + side * apart * value.abs());
            let Some(high) = shift(last, 1.0) else { continue };
            // Where there are no more but zeros below, nothing has to be counted there.
            let lowest = high.negative == self.zero_count() + values.len();
            let low = if lowest { None } else { shift(first, -1.0) };
            if !lowest && low.as_ref().map(|low| low.negative + values.len()) != Some(high.negative) {
                continue;
            }
            let low = low.map(|low| low.shift + up(low.error));
            found.window = Window { low, high: Some(below(high.shift, high.error)) };
            found.positive = if lowest { self.positive() } else { None };
            let none = Zeros::default();
            if let Some(mut spectrum) = self.proved(&found, if lowest { &self.zeros } else { &none })? {
                if !lowest {
                    spectrum.stability = self.stability()?;
                }
                return Ok(Some((spectrum, Method::Given)));
            }
        }
        Ok(None)
    }

    /// The modes nearest to a frequency; with the search for the `lowest` where these are among them.
    fn near(
        &self,
        omega: f64,
        count: usize,
        lowest: impl FnOnce() -> Option<Self>,
    ) -> Result<Option<(Spectrum, Method)>, ModesError> {
        let n = self.pencil.dimension();
        let count = count.min(n);
        let tridiagonal = self.pencil.is_tridiagonal().then(|| self.tridiagonal_about(omega, count)).flatten();
        let method = if tridiagonal.is_some() { Method::Tridiagonal } else { Method::Lanczos };
        let Some((columns, window)) = tridiagonal.or_else(|| self.about(omega, count)) else { return Ok(None) };
        let Some(columns) = columns else {
            // The window reaches 0: all below its upper end.
            let Some(high) = window.high else { return Ok(None) };
            let (Some(factor), Some(search)) = (self.factor(high), lowest()) else { return Ok(None) };
            let Some((mut spectrum, method)) = search.lowest(factor.negative)? else { return Ok(None) };
            keep_nearest(&mut spectrum.modes, count, |mode| (mode.omega.mid_f64() - omega).abs());
            return Ok(Some((spectrum, method)));
        };
        let found = Candidates { columns, window, positive: None };
        let Some(mut spectrum) = self.proved(&found, &Zeros::default())? else { return Ok(None) };
        keep_nearest(&mut spectrum.modes, count, |mode| (mode.omega.mid_f64() - omega).abs());
        spectrum.stability = lowest().map_or(Ok(Stability::Undecided), |search| search.stability())?;
        Ok(Some((spectrum, method)))
    }

    /// As [`Self::about`], of tridiagonal matrices.
    fn tridiagonal_about(&self, omega: f64, count: usize) -> Option<(Option<Columns>, Window)> {
        let n = self.pencil.dimension();
        self.budget.at("the search for the modes", None);
        let bands = Bands::new(self.pencil)?;
        let below_it = bands.count(omega * omega);
        // The nearest ones may all be on one side, and one more tells where they end.
        let (from, to) = (below_it.saturating_sub(count + 1), (below_it + count + 1).min(n));
        let starts = bands.bisect(&(from..to))?;
        let distances: Vec<f64> = starts.iter().map(|value| (value.max(0.0).sqrt() - omega).abs()).collect();
        let order = ordered(&distances);
        let end = |is_all: bool, distance: Option<&f64>| distance.copied().filter(|_| !is_all).unwrap_or(f64::INFINITY);
        let beyond = end(from == 0, distances.first()).min(end(to == n, distances.last()));
        let (k, reach) = gap(&distances, &order, count, beyond)?;
        if reach >= beyond {
            return None;
        }
        let [low, high] = [omega - reach, omega + reach].map(|end| end.abs() * end);
        if low <= 0.0 {
            return Some((None, Window { low: None, high: Some(high) }));
        }
        let (counted, window) = self.between([low, high])?;
        let mut nearest: Vec<f64> = order[..k].iter().map(|at| starts[*at]).collect();
        nearest.order_by(f64::total_cmp);
        let (values, panels) = bands.pairs(&nearest)?;
        (counted == k).then_some((Some(Columns { values, panels }), window))
    }

    /// How many eigenvalues lie between two numbers, by the factors there, and the window for which this is certain.
    fn between(&self, [low, high]: [f64; 2]) -> Option<(usize, Window)> {
        let [above, under] = self.factors([high, low]);
        let (above, under) = (above?, under?);
        let window = Window { low: Some(low + up(under.error)), high: Some(below(high, above.error)) };
        Some((above.negative.checked_sub(under.negative)?, window))
    }

    /// What the lowest mode says of all.
    fn stability(&self) -> Result<Stability, ModesError> {
        Ok(self.lowest(1)?.map_or(Stability::Undecided, |(spectrum, _)| spectrum.stability))
    }

    /// Columns about a frequency and the window that they fill; none where the window reaches 0.
    fn about(&self, omega: f64, count: usize) -> Option<(Option<Columns>, Window)> {
        let n = self.pencil.dimension();
        let shift = omega * omega;
        let scale = self.pencil.stiffness_norms.0;
        // A shift on an eigenvalue has no factor, or one that is of no use.
        let mut best: Option<Factor<'_>> = None;
        for by in [0.0, 1e-9, 1e-6, 1e-5, 1e-4] {
            let other = self.factor(shift + by * shift.max(1e-6 * scale));
            best = best.into_iter().chain(other).min_by(|a, b| a.error.total_cmp(&b.error));
            if best.as_ref().is_some_and(|best| best.error <= USABLE * scale) {
                break;
            }
        }
        let factor = best?;
        let mut known: Vec<f64> = Vec::new();
        let mut values: Vec<f64> = Vec::new();
        let mut more = (count + 2).min(n);
        for _ in 0..SEARCHES {
            let found = self.lanczos(&factor, &known, more, false)?;
            known.extend_from_slice(&found.vectors);
            values.extend_from_slice(&found.values);
            let distances: Vec<f64> = values.iter().map(|value| (value.max(0.0).sqrt() - omega).abs()).collect();
            let mut order = ordered(&distances);
            let Some((k, reach)) = gap(&distances, &order, count, f64::INFINITY) else {
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
            let (counted, window) = self.between([low, high])?;
            let missing = counted.checked_sub(k)?;
            if missing == 0 {
                order.truncate(k);
                order.order_by(|a, b| values[*a].total_cmp(&values[*b]));
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
            for cluster in spectrum.modes.chunk_by_mut(|a, b| a.cluster == b.cluster) {
                self.in_echelon(cluster);
            }
            for mode in &mut spectrum.modes {
                mode.vector = finish(std::mem::take(&mut mode.vector), mode.vector_error_bound).vector;
            }
        }
        spectrum
    }

    /// The echelon basis of a space, which does not depend on the one that was found.
    fn in_echelon(&self, modes: &mut [Mode]) {
        let (n, count) = (self.pencil.dimension(), modes.len());
        if count < 2 {
            return;
        }
        let basis = Matrix::from_fn(n, count, |i, q| DoubleDouble::exact(modes[q].vector[i]));
        let images = modes.iter().map(|mode| {
            let mut image = vec![0.0; n];
            self.pencil.mass.times(&mode.vector, &mut image);
            image
        });
        let images: Vec<Vec<f64>> = images.collect();
        let gram = Matrix::from_fn(count, count, |p, q| DoubleDouble::exact(dot(&modes[p].vector, &images[q])));
        let transform = echelon(&basis, &gram);
        if !(0..count).all(|q| transform.hi.column(q).iter().all(|x| x.is_finite())) {
            return;
        }
        let bounds: Vec<f64> = modes.iter().map(|mode| mode.vector_error_bound).collect();
        for (q, mode) in modes.iter_mut().enumerate() {
            let own = transform.hi.column(q);
            let sum = |row: usize, term: &dyn Fn(f64, f64) -> f64| -> f64 {
                own.iter().enumerate().map(|(p, t)| term(basis.get(row, p).hi, *t)).sum()
            };
            mode.vector = (0..n).map(|row| sum(row, &|x, t| x * t)).collect();
            let largest = (0..n).map(|row| sum(row, &|x, t| (x * t).abs())).fold(0.0, f64::max);
            let carried: f64 = own.iter().zip(&bounds).map(|(t, bound)| t.abs() * bound).sum();
            // Sums are rounded, and so is the length.
            mode.vector_error_bound = up(carried + f64::EPSILON * (2 * count + 8) as f64 * largest);
        }
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

/// The places of numbers in rising order.
fn ordered(numbers: &[f64]) -> Vec<usize> {
    places(numbers.len(), &mut |a, b| numbers[*a].total_cmp(&numbers[*b]))
}

/// How many numbers, at least so many, are before the first one that is apart from them, in an order, and what lies between; `beyond`
/// are those that are not known.
fn gap(numbers: &[f64], order: &[usize], least: usize, beyond: f64) -> Option<(usize, f64)> {
    (least..order.len()).find_map(|k| {
        let (last, next) = (numbers[order[k - 1]], numbers[order[k]].min(beyond));
        (next - last > APART * next.abs().max(last.abs())).then_some((k, last + 0.6 * (next - last)))
    })
}

/// A number below a shift by what its factorization may be off.
fn below(shift: f64, error: f64) -> f64 {
    (shift - error).next_down().next_down()
}

/// Keeps so many modes that are nearest by some distance, in their order.
pub(crate) fn keep_nearest<M>(modes: &mut Vec<M>, count: usize, distance: impl Fn(&M) -> f64) {
    let mut kept = vec![false; modes.len()];
    let distances: Vec<f64> = modes.iter().map(distance).collect();
    ordered(&distances).into_iter().take(count).for_each(|at| kept[at] = true);
    let mut kept = kept.into_iter();
    modes.retain(|_| kept.next() == Some(true));
}
