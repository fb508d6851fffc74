//! Some exponents of M q̈ + D q̇ + S q = 0 with sparse matrices, each in a disc that holds it, and none missing.
//!
//! Arnoldi steps about a complex number σ find approximations, inverse iteration with a decomposition next to each makes vectors of
//! two doubles of them (A. Neumaier, "Residual inverse iteration for the nonlinear eigenvalue problem", SIAM J. Numer. Anal. 22 (1985) 914). What
//! is proved takes one decomposition of P(σ) with borders ([`super::bordered`]). Let U have k vectors, Θ their exponents, P(s)U = EU(s - Θ) + R,
//! and let B(s) be P(s) with columns W nearly κEU and any k rows beside it. If no singular value of B(σ) is less than τ, B(s) is regular
//! where |s - σ| < τ, and solving with it for (U, -(s - Θ)/κ) shows that the exponents there are the zeros of
//!
//! ```text
//!   det((s - Θ)/κ + Δ(s)),  |Δ(s) e_j| <= |F_j| / (τ - |s - σ|),  F = R + (EU - W/κ)(s - Θ),
//! ```
//!
//! as many as there are columns (for tΔ with t from 0 to 1, zeros stay in the discs of Gershgorin, by columns), each group of discs that overlap with as
//! many of them as it has. Where the strip of frequencies that are asked for is not within the disc about σ, as far as growth may
//! reach ([`Search::is_slow`]), further discs without any exponent cover the rest of it.

use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, c64};

use super::super::exponents::{Exponent, Exponents, Limit, finish};
use super::super::{Options, PrecisionLevel, Stability, leading};
use super::Wanted;
use super::bordered::{Border, Bordered, Form, NO_PIVOT};
use super::lanczos::Seed;
use super::rows::Rows;
use super::shifted::{Pattern, Pencil};
use crate::budget::Budget;
use crate::groups::connected;
use crate::order::{Order, places};
use crate::precision::{Ball, Complex, SparseMatrix, U2, up};

/// Exponents are sought so many times as far from σ as those that are wanted, and some more, to find a gap behind these.
const FAR: f64 = 1.4;
/// See [`FAR`].
const BEYOND: usize = 8;
/// What is farther by this part is behind a gap.
const GAP: f64 = 1e-3;
/// Where S is not positive definite, at least this part of it is added to it.
const LEAST_ADDED: f64 = 1e-6;
/// Steps of a bisection for where the modes without velocities end.
const HALVINGS: usize = 8;
/// How often more exponents are sought.
const SEARCHES: usize = 4;
/// Most Arnoldi steps beyond twice as many as vectors are wanted.
const STEPS: usize = 160;
/// A vector is found when what the operator leaves over is this part of its eigenvalue.
const FOUND: f64 = 1e-8;
/// How far from an exponent the matrix is decomposed that refines it, beside the distance to the next.
const ASIDE: f64 = 1e-4;
/// And beside itself: nearer, equal exponents would all get one vector, that which rounding leaves.
const LEAST_ASIDE: f64 = 1e-7;
/// How far beside a frequency exponents are sought, where those on it are not found.
const ASIDES: [f64; 3] = [0.0, 1e-5, 1e-3];
/// Most steps of refinement.
const REFINEMENTS: usize = 8;
/// A vector that moves by no more than this part is refined.
const REFINED: f64 = 1e-28;
/// Bytes of memory for an entry of P(σ) and what becomes of it.
const ENTRY: usize = 256;
/// Most discs without exponents that cover a strip.
const DISCS: usize = 400;
/// What is smaller beside the strip and the disc about σ is next to an exponent in it.
const SMALLEST: f64 = 1e-3;
/// And most places about which none is proved.
const FAILURES: usize = 24;

/// M, D and S.
#[derive(Clone, Debug)]
pub struct SparseQuadratic {
    /// M, by its lower triangle; positive definite by its diagonal.
    pub mass: SparseMatrix,
    /// D = G + C, all entries.
    pub velocity: SparseMatrix,
    /// S = K + N, all entries.
    pub stiffness: SparseMatrix,
    /// D is skew and S symmetric, exactly.
    pub undamped: bool,
    /// S is symmetric, exactly.
    pub symmetric: bool,
    /// The symmetric part of D is not negative, exactly.
    pub passive: bool,
}

/// An exponent and its vector of first order, approximately.
struct Approximation {
    s: c64,
    vector: Vec<c64>,
    refined: Option<Refined>,
}

/// The same refined: s and x are numbers of two doubles, exactly those that the bounds are about.
#[derive(Clone)]
struct Refined {
    s: Complex<Ball>,
    x: Vec<Complex<Ball>>,
    /// A left vector of first order.
    left: Vec<c64>,
    /// A bound in length of (s²M + sD + S) x.
    residual: f64,
}

/// A disc about the exponent of a column, and how many exponents are in those that overlap with it.
struct Disc {
    radius: f64,
    shared: usize,
    /// The first column of these.
    group: usize,
    /// A bound of the distance of the vector from an exact one, in M.
    vector: f64,
}

struct Search<'a> {
    problem: &'a SparseQuadratic,
    form: &'a Form,
    /// S is symmetric and positive definite.
    definite: bool,
    /// The energy xᴴSx + |s|² xᴴMx bounds all motions.
    bounded: bool,
    sigma: c64,
    /// The frequency next to which all are wanted; `None` for the lowest.
    near: Option<f64>,
    budget: &'a Budget,
}

/// Some exponents. `None` where they are not found or not proved, M is not positive definite by its diagonal, or the budget is spent.
pub fn solve_sparse_quadratic(
    problem: &SparseQuadratic,
    wanted: Wanted<'_>,
    options: &Options,
    budget: &Budget,
) -> Option<Exponents> {
    let stiffness = problem.symmetric_stiffness();
    let pencil = Pencil::new(&stiffness, &problem.mass)?;
    let energy = Energy::new(&pencil, &stiffness, &problem.mass, wanted, budget)?;
    let definite = problem.symmetric && energy.added == 0.0;
    let bounded = definite && (problem.undamped || problem.passive);
    let (near, center, count) = match wanted {
        Wanted::Near(omega, count) if omega > 0.0 => (Some(omega), omega, count),
        Wanted::Near(_, count) | Wanted::Lowest(count) if bounded => {
            (None, 0.5 * end_of_lowest(&pencil, energy.lowest, count, budget)?, count)
        }
        Wanted::Near(..) | Wanted::Lowest(_) | Wanted::Given(_) => {
            budget.tell(unbounded);
            return None;
        }
    };
    let (velocity, stiffness) = (Rows::general(&problem.velocity), Rows::general(&problem.stiffness));
    let (mass, energy_rows) = (Rows::new(&problem.mass), Rows::new(&energy.matrix));
    let form = Form {
        order: Form::order([&mass, &velocity, &stiffness, &energy_rows])?,
        mass,
        velocity,
        stiffness,
        energy: energy_rows,
        floor: energy.floor,
        weights: pencil.weights,
        roots: pencil.roots,
        pattern: Pattern::default(),
    };
    // Half the friction of all coordinates together over their mass is about how fast motions decay, which are nearest there.
    let trace = |of: &SparseMatrix| of.entries().filter(|(i, j, _)| i == j).map(|(.., own)| own.mid_f64()).sum::<f64>();
    let decay = if near.is_some() { 0.5 * (trace(&problem.velocity) / trace(&problem.mass)).max(0.0) } else { 0.0 };
    let places = [decay, 0.0].into_iter().take(if decay > 0.0 { 2 } else { 1 });
    // On an exponent there is no decomposition that is of use.
    let found = places.flat_map(|decay| ASIDES.map(|by| (decay, by))).find_map(|(decay, by)| {
        let sigma = c64::new(-decay, center * (1.0 + by));
        let search = Search { problem, form: &form, definite, bounded, sigma, near, budget };
        search.run(count.min(form.dimension()), options)
    });
    found.flatten()
}

/// Why the lowest are not found, in words.
fn unbounded() -> String {
    "solver: motions may be unstable or free, which come first".to_owned()
}

/// A positive definite matrix next to the symmetric part of S.
struct Energy {
    matrix: SparseMatrix,
    /// It is not less than so many times M.
    floor: f64,
    /// So many times M were added.
    added: f64,
    /// About the lowest eigenvalue, where nothing was.
    lowest: f64,
}

impl Energy {
    fn new(
        pencil: &Pencil,
        stiffness: &SparseMatrix,
        mass: &SparseMatrix,
        wanted: Wanted<'_>,
        budget: &Budget,
    ) -> Option<Self> {
        // At least half as far above a shift as M is there.
        let floor = |shift: f64, least: f64| {
            let factor = super::factor(pencil, shift, budget)?;
            (factor.negative == 0 && factor.error < 0.5 * least).then_some(least - factor.error)
        };
        let lowest = super::factor(pencil, 0.0, budget).filter(|own| own.negative == 0).map_or(0.0, |own| own.least());
        if let Some(floor) = floor(0.5 * lowest, 0.5 * lowest) {
            return Some(Self { matrix: stiffness.clone(), floor, added: 0.0, lowest });
        }
        let Wanted::Near(omega, _) = wanted else {
            budget.tell(unbounded);
            return None;
        };
        let most = 16.0 * pencil.stiffness_norms.0;
        let mut added = (omega * omega).max(LEAST_ADDED * most);
        while added < most && !budget.is_spent() {
            if let Some(floor) = floor(-0.5 * added, 0.5 * added) {
                let more = mass.entries().map(|(i, j, value)| (i as u32, j as u32, *value * Ball::exact(added)));
                let more = SparseMatrix::from_shares(mass.dimension(), &more.collect::<Vec<_>>());
                return Some(Self { matrix: stiffness.plus(&more), floor, added, lowest });
            }
            added *= 8.0;
        }
        None
    }
}

/// A frequency below which there would be so many modes without velocities, and hardly more.
fn end_of_lowest(pencil: &Pencil, lowest: f64, count: usize, budget: &Budget) -> Option<f64> {
    let below = |shift: f64| super::factor(pencil, shift, budget).map(|own| own.negative);
    let mut high = 2.0 * lowest;
    while below(high)? < count {
        high *= 2.0;
    }
    let mut low = 0.5 * high;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if below(middle)? < count { low = middle } else { high = middle }
    }
    Some(high.sqrt())
}

impl SparseQuadratic {
    pub(super) fn symmetric_stiffness(&self) -> SparseMatrix {
        symmetric_part(&self.stiffness, 1.0)
    }
}

/// The symmetric part of a matrix of which all entries are stored, times a number.
fn symmetric_part(matrix: &SparseMatrix, by: f64) -> SparseMatrix {
    let shares = matrix.entries().map(|(i, j, value)| {
        let own = *value * Ball::exact(if i == j { by } else { 0.5 * by });
        (i.max(j) as u32, i.min(j) as u32, own)
    });
    SparseMatrix::from_shares(matrix.dimension(), &shares.collect::<Vec<_>>())
}

impl Search<'_> {
    /// σ in words.
    fn about(&self) -> String {
        let c64 { re, im } = self.sigma;
        if re == 0.0 { format!("{im:.6e} i") } else { format!("{re:.3e} + {im:.6e} i") }
    }

    /// The exponents; `Some(None)` where rounding leaves no proof, which another σ does not change.
    fn run(&self, count: usize, options: &Options) -> Option<Option<Exponents>> {
        let wanted = if self.near.is_some() { count as f64 } else { 1.5 * count as f64 };
        let mut all = self.approximations((FAR * wanted) as usize + BEYOND, count, &[])?;
        let mut refined: Vec<Refined> = Vec::new();
        let (mut proof, mut seed) = (None, Seed::default());
        let mut beside = FAR;
        for _ in 0..SEARCHES {
            let distance = |k: usize| (all[k].s - self.sigma).norm();
            // One stands for a pair of conjugates.
            let entries = |k: usize| all[..k].iter().filter(|own| own.s.im >= 0.0).count();
            let enough = (1..all.len()).find(|k| entries(*k) >= count)?.max(self.nearest_in(&all, count));
            // The lowest are all down to 0.
            let least = if self.near.is_some() { 0.0 } else { self.sigma.im * (1.0 + GAP) };
            let last = distance(enough - 1).max(least);
            // Singular values are nearer to 0 than exponents are to σ: columns beyond those that are wanted keep them away.
            let far = (enough..all.len()).find(|k| distance(*k) >= beside * last).unwrap_or(all.len() - 1);
            let k = (enough..=far).rev().find(|k| distance(*k) > (1.0 + GAP) * distance(k - 1).max(last))?;
            let next = distance(k);
            for at in 0..k {
                if all[at].refined.is_none() {
                    all[at].refined = Some(self.refined(&all, at, &mut seed)?);
                }
            }
            refined = all.iter().take(k).filter_map(|own| own.refined.clone()).collect();
            match self.proved(&refined, [last, next]) {
                Ok(found) => {
                    proof = Some(found);
                    break;
                }
                Err(NO_PIVOT) => return None,
                // Equal exponents have a vector each.
                Err(0) => return Some(None),
                Err(missing) => {
                    // Vectors that are nearly the same may look like one more.
                    beside *= FAR;
                    all.truncate(k);
                    all.extend(self.approximations(missing + BEYOND, missing, &refined)?);
                }
            }
            all.order_by(|a, b| (a.s - self.sigma).norm().total_cmp(&(b.s - self.sigma).norm()));
        }
        let ((discs, reach), k) = (proof?, refined.len());
        let is_inside = |at: &usize| {
            (refined[*at].s.to_c64() - self.sigma).norm() * (1.0 + 1e-14) + 6.0 * discs[*at].radius < reach
        };
        // Signs say nothing of what may be 0: without damping half of those stand for pairs ±s, with it a single one is real.
        let may_be_zero = |at: &usize| refined[*at].s.square_of_modulus().sqrt().lower() <= discs[*at].radius;
        let at_zero: Vec<usize> = (0..k).filter(|at| is_inside(at) && may_be_zero(at)).collect();
        // What is left at the border might be one of those that are asked for, and what is next to the real axis a pair or not.
        let is_open = |at: usize| {
            let (im, radius) = (&refined[at].s.im, discs[at].radius);
            let may_be_inside = (refined[at].s.to_c64() - self.sigma).norm() * (1.0 - 1e-14) - radius < reach;
            may_be_inside && (!is_inside(&at) || !may_be_zero(&at) && !im.is_zero() && im.abs_lower() <= radius)
        };
        if (0..k).any(is_open) {
            return Some(None);
        }
        let of_zero = match at_zero.len() {
            1 => 1,
            even if even == 0 || self.problem.undamped && even.is_multiple_of(2) => even / 2,
            _ => return None,
        };
        // One of a pair of conjugates, and without damping the growing one of a pair ±s.
        let stands = |at: &usize| {
            let s = &refined[*at].s;
            match at_zero.iter().position(|own| own == at) {
                Some(place) => place < of_zero,
                None if refined[*at].is_real() => !self.problem.undamped || s.re.mid_f64() > 0.0,
                None => s.im.mid_f64() > 0.0,
            }
        };
        let distance = |at: usize| (refined[at].s.im.mid_f64() - self.near.unwrap_or(0.0)).abs();
        let mut found: Vec<usize> = (0..k).filter(|at| is_inside(at) && stands(at)).collect();
        found.order_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        let is_tie = |a: &usize, b: &usize| distance(*b) - distance(*a) <= discs[*a].radius + discs[*b].radius;
        for tied in found.chunk_by_mut(is_tie) {
            tied.order_by(|a, b| refined[*b].s.re.mid_f64().total_cmp(&refined[*a].s.re.mid_f64()));
        }
        (found.len() >= count).then_some(())?;
        found.truncate(count);
        let farthest = found.iter().map(|at| distance(*at) + discs[*at].radius).fold(0.0, f64::max);
        self.covers(farthest, reach, &all)?;
        let mut kept = found;
        kept.sort_unstable();
        let exponents = kept.iter().map(|at| self.entry((&refined, &discs), *at, options));
        let bounded = self.bounded;
        let entries = exponents.collect::<Option<Vec<Exponent>>>()?;
        let mut found = finish(entries, PrecisionLevel::Refined, options, &|_| bounded);
        if found.stability != Stability::Unstable {
            found.stability = if bounded { Stability::Stable } else { Stability::Undecided };
        }
        found.secular = bounded.then_some(false);
        Some(Some(found))
    }

    /// How many of those about σ have all that are nearest to the frequency that is asked for, so many of them; 0 for the lowest.
    fn nearest_in(&self, all: &[Approximation], count: usize) -> usize {
        let Some(near) = self.near else { return 0 };
        let off = |own: &Approximation| (own.s.im - near).abs();
        let mut distances: Vec<f64> = all.iter().map(off).collect();
        distances.order_by(f64::total_cmp);
        let Some(farthest) = distances.get(count - 1) else { return 0 };
        all.iter().rposition(|own| off(own) <= *farthest).map_or(0, |last| last + 1).min(all.len() - 1)
    }

    /// So many exponents next to σ by Arnoldi steps with P(σ)⁻¹E, by their distance, or at least more than `least`, without those that are known.
    fn approximations(&self, wanted: usize, least: usize, known: &[Refined]) -> Option<Vec<Approximation>> {
        let (form, n) = (self.form, self.form.dimension());
        let wanted = wanted.min(2 * n - known.len());
        self.budget.at("the search for the modes", None);
        let pencil = self.bordered(self.sigma, &[])?;
        let factor = pencil.factor(0.0)?;
        let told = |what: &str| format!("solver: Arnoldi steps about {}, {what}", self.about());
        self.budget.tell(|| told(&format!("L D L^T of {} entries", pencil.fill())));
        let most = (2 * wanted + STEPS).min(2 * n - known.len());
        let known: Vec<[Vec<c64>; 2]> = known.iter().map(|own| own.pair(form)).collect();
        let k = known.len();
        let overlaps = Mat::from_fn(k, k, |i, j| product(&known[i][1], &known[j][0]));
        let inverse = if k > 0 { overlaps.partial_piv_lu().inverse() } else { overlaps };
        // What a vector has of those that are known.
        let cleared = |u: &mut [c64]| {
            let parts: Vec<c64> = known.iter().map(|own| product(&own[1], u)).collect();
            for (i, [right, _]) in known.iter().enumerate() {
                let part = (0..k).fold(c64::new(0.0, 0.0), |sum, j| sum + inverse[(i, j)] * parts[j]);
                u.iter_mut().zip(right).for_each(|(x, y)| *x -= part * y);
            }
        };
        // Lengths in M of both halves.
        let scale = |u: &mut [c64], by: &[f64]| {
            u.iter_mut().zip(by.iter().chain(by)).for_each(|(u, by)| *u *= *by);
        };
        let mut seed = Seed::default();
        let mut next: Vec<c64> = (0..2 * n).map(|_| c64::new(seed.next(), 0.0)).collect();
        cleared(&mut next);
        scale(&mut next, &form.weights);
        let nothing = vec![c64::new(0.0, 0.0); 2 * n];
        let mut basis: Vec<Vec<c64>> = Vec::new();
        let mut columns: Vec<Vec<c64>> = Vec::new();
        let mut length = norm(&next);
        while basis.len() < most && !self.budget.is_spent() {
            next.iter_mut().for_each(|x| *x /= length);
            basis.push(next.clone());
            scale(&mut next, &form.roots);
            [next, _] = pencil.solve(&factor, &form.first_order(&next), &nothing);
            cleared(&mut next);
            scale(&mut next, &form.weights);
            let whole = norm(&next);
            let mut column = vec![c64::new(0.0, 0.0); basis.len()];
            for _ in 0..2 {
                for (own, sum) in basis.iter().zip(&mut column) {
                    let part = product(own, &next);
                    *sum += part;
                    next.iter_mut().zip(own).for_each(|(x, y)| *x -= part * y);
                }
            }
            length = norm(&next);
            column.push(c64::new(length, 0.0));
            columns.push(column);
            let m = basis.len();
            let ended = length.is_nan() || length <= 1e-13 * whole || m == most;
            if !ended && (m < wanted || !m.is_multiple_of(8)) {
                continue;
            }
            let square = Mat::from_fn(m, m, |i, j| columns[j].get(i).copied().unwrap_or(c64::new(0.0, 0.0)));
            let eigen = square.eigen().ok()?;
            let theta = |k: usize| eigen.S()[k];
            let order = places(m, &mut |a, b| theta(*b).norm().total_cmp(&theta(*a).norm()));
            let left = |k: usize| length * eigen.U()[(m - 1, k)].norm() / theta(k).norm();
            let found = order.iter().take_while(|k| left(**k) <= FOUND).count();
            if found < wanted && !(ended && found > least) {
                continue;
            }
            let one = |k: &usize| {
                let mut vector = nothing.clone();
                for (j, own) in basis.iter().enumerate() {
                    let part = eigen.U()[(j, *k)];
                    vector.iter_mut().zip(own).for_each(|(x, y)| *x += part * y);
                }
                scale(&mut vector, &form.roots);
                Approximation { s: self.sigma - c64::new(1.0, 0.0) / theta(*k), vector, refined: None }
            };
            return Some(order[..found].iter().map(one).collect());
        }
        self.budget.tell(|| told("no convergence"));
        None
    }

    /// The pencil at a number, unless there is no memory for it.
    fn bordered(&self, sigma: c64, borders: &[Border]) -> Option<Bordered> {
        let form = self.form;
        let parts = [&form.mass, &form.velocity, &form.stiffness, &form.energy, &form.energy];
        let entries = parts.iter().map(|rows| rows.high.len()).sum::<usize>();
        self.budget.room(entries + 4 * borders.len() * form.dimension(), ENTRY).ok()?;
        let found = Bordered::new(form, sigma, borders)?;
        self.budget.room(found.fill(), 8).ok()?;
        Some(found)
    }

    /// Inverse iteration beside an exponent, first in doubles for both vectors, then for two doubles of s and x.
    fn refined(&self, all: &[Approximation], at: usize, seed: &mut Seed) -> Option<Refined> {
        let (form, n) = (self.form, self.form.dimension());
        self.budget.at("the refinement of the modes", None);
        let Approximation { s, vector, .. } = &all[at];
        let others = all.iter().map(|other| (other.s - s).norm()).filter(|apart| *apart > 1e-8 * s.norm());
        let apart = others.fold(s.norm(), f64::min);
        let pencil = self.bordered(s + c64::new((ASIDE * apart).max(LEAST_ASIDE * s.norm()), 0.0), &[])?;
        let factor = pencil.factor(0.0)?;
        let mut right = vector.clone();
        // Any one: equal exponents are not to have the same.
        let mut left: Vec<c64> = (0..2 * n).map(|_| c64::new(seed.next(), seed.next())).collect();
        for _ in 0..3 {
            [right, left] = pencil.solve(&factor, &form.first_order(&right), &form.first_order(&left));
            for vector in [&mut right, &mut left] {
                let length = self.length(vector);
                vector.iter_mut().for_each(|x| *x /= length);
            }
        }
        let mut x: Vec<Complex<Ball>> = right[..n].iter().map(|x| Complex::from_c64(*x, ())).collect();
        let mut s = Complex::<Ball>::from_c64(*s, ());
        let nothing = vec![c64::new(0.0, 0.0); 2 * n];
        for _ in 0..REFINEMENTS {
            let (residual, slope) = self.residual(&s, &x);
            let to_c64 = |all: &[Complex<Ball>]| all.iter().map(Complex::to_c64).collect::<Vec<c64>>();
            let (residual, slope) = (to_c64(&residual), to_c64(&slope));
            let step = -product(&left[n..], &residual) / product(&left[n..], &slope);
            let rest = residual.iter().zip(&slope).map(|(r, slope)| r + step * slope);
            let rest: Vec<c64> = nothing[n..].iter().copied().chain(rest).collect();
            s = s.add(&Complex::from_c64(step, ())).center();
            let [change, _] = pencil.solve(&factor, &rest, &nothing);
            for (x, by) in x.iter_mut().zip(&change) {
                *x = x.sub(&Complex::from_c64(*by, ())).center();
            }
            let moved = norm(&change[..n]) / norm(&right[..n]);
            if !moved.is_finite() {
                return None;
            }
            if moved <= REFINED {
                break;
            }
        }
        // What is real in doubles is, more likely than not.
        if s.im.mid_f64().abs() <= 1e-24 * s.re.mid_f64().abs() {
            s.im = Ball::ZERO;
        }
        let (residual, _) = self.residual(&s, &x);
        let residual = self.inverse_length(&residual);
        Some(Refined { s, x, left, residual })
    }

    /// (s²M + sD + S) x and (2sM + D) x.
    fn residual(&self, s: &Complex<Ball>, x: &[Complex<Ball>]) -> (Vec<Complex<Ball>>, Vec<Complex<Ball>>) {
        let form = self.form;
        let row = |i: usize| {
            let [m, d, k] = [&form.mass, &form.velocity, &form.stiffness].map(|rows| rows.component(x, i));
            let inner = d.add(&s.mul(&m));
            (k.add(&s.mul(&inner)), inner.add(&s.mul(&m)))
        };
        (0..form.dimension()).map(row).unzip()
    }

    /// A bound of the length in M⁻¹.
    fn inverse_length(&self, of: &[Complex<Ball>]) -> f64 {
        let square = |(r, root): (&Complex<Ball>, &f64)| {
            let own = r.re.abs_upper().hypot(r.im.abs_upper()) * root;
            own * own
        };
        let sum: f64 = of.iter().zip(&self.form.roots).map(square).sum();
        up(sum.sqrt() * (1.0 + (of.len() + 16) as f64 * f64::EPSILON)) + 1e-280
    }

    /// The length of a vector of first order, about.
    fn length(&self, u: &[c64]) -> f64 {
        product(u, &self.form.first_order(u)).re.sqrt()
    }

    /// Discs about all columns, and how far about σ there are no other exponents; else how many there seem to be, 0 where that is no help.
    fn proved(&self, refined: &[Refined], [last, next]: [f64; 2]) -> Result<(Vec<Disc>, f64), usize> {
        let (form, n) = (self.form, self.form.dimension());
        let scale = 4.0 * next.log2().round().exp2();
        let mut borders = Vec::with_capacity(refined.len());
        // What columns are off by, EU - W/κ, and the lengths of U.
        let (mut rounded, mut lengths, mut left) = (Vec::new(), Vec::new(), Vec::new());
        for own in refined {
            let y: Vec<Complex<Ball>> = own.x.iter().map(|x| x.mul(&own.s)).collect();
            let above = (0..n).map(|i| form.energy.component(&own.x, i));
            let exact: Vec<Complex<Ball>> = above.chain((0..n).map(|i| form.mass.component(&y, i))).collect();
            let column: Vec<c64> = exact.iter().map(Complex::to_c64).collect();
            let off: Vec<Complex<Ball>> =
                exact.iter().zip(&column).map(|(exact, own)| exact.sub(&Complex::from_c64(*own, ()))).collect();
            let above = up(self.inverse_length(&off[..n]) / form.floor.sqrt() * (1.0 + 1e-14));
            rounded.push(up(above + self.inverse_length(&off[n..])));
            let parts = own.x.iter().chain(&y).zip(&exact).map(|(u, image)| u.re * image.re + u.im * image.im);
            lengths.push(parts.fold(Ball::ZERO, |sum, part| sum + part).sqrt().abs_upper());
            borders.push(Border {
                column: column.iter().map(|x| x * scale).collect(),
                row: self.row(own, &mut left, scale),
            });
        }
        let pencil = self.bordered(self.sigma, &borders).ok_or(0_usize)?;
        let mut least = Err(0);
        for part in [0.9, 0.6, 0.4, 0.2, 0.05] {
            least = pencil.least(last + part * (next - last));
            if least.is_ok_and(|least| 0.99 * least > last) {
                break;
            }
            least = least.and(Err(0));
            if least == Err(NO_PIVOT) {
                break;
            }
        }
        self.budget.tell(|| {
            let about = self.about();
            match least {
                Ok(least) => format!("{} exponents, no others within {least:.3e} of {about}", refined.len()),
                Err(NO_PIVOT) => format!("exponents about {about}: a pivot is 0"),
                Err(0) => format!("{} exponents about {about}: rounding leaves no proof", refined.len()),
                Err(missing) => format!("{} exponents about {about}: {missing} seem to be missing", refined.len()),
            }
        });
        let least = least?;
        let reach = 0.99 * least;
        let room = 0.009 * least;
        let root = up((refined.len() as f64).sqrt());
        // |s - s_j| <= κ √k (a |s - s_j| + ρ) / room, and with more room near σ.
        let bound = |own: &Refined, off: f64, room: f64| {
            let part = up(scale * root / room);
            let rest = 1.0 - up(part * off);
            (rest > 0.0).then(|| up(part * own.residual / rest * (1.0 + 1e-14)))
        };
        let finer = |(own, off): (&Refined, &f64)| {
            let first = bound(own, *off, room)?;
            let away = (own.s.to_c64() - self.sigma).norm() + first;
            bound(own, *off, room.max((least - away) * (1.0 - 1e-12))).map(|own| own.min(first))
        };
        let radii = refined.iter().zip(&rounded).map(finer).collect::<Option<Vec<f64>>>().ok_or(0_usize)?;
        Ok((self.discs(refined, [&radii, &rounded, &lengths], [room, scale]), reach))
    }

    /// A row beside P: any will do, but far from those before, as left vectors of equal exponents need not be.
    fn row(&self, own: &Refined, before: &mut Vec<[Vec<c64>; 2]>, scale: f64) -> Vec<c64> {
        let mut vector = own.left.clone();
        for [other, image] in before.iter() {
            let part = product(image, &vector);
            vector.iter_mut().zip(other).for_each(|(x, y)| *x -= part * y);
        }
        let length = self.length(&vector);
        vector.iter_mut().for_each(|x| *x /= length);
        let image = self.form.first_order(&vector);
        let row = image.iter().map(|x| x.conj() * scale).collect();
        before.push([vector, image]);
        row
    }

    /// Groups of discs that overlap, and bounds of the vectors of those that are alone.
    ///
    /// With λ the exponent in the disc of j there is a vector z with |z - U a| <= |F a| / room, a_j = 1 and |a_i| <= κ |F a| / (room (|s_i - s_j| - r_j)),
    /// so that |F a| <= |F_j| / (1 - q), where q is the sum of κ |F_i| / (room (|s_i - s_j| - r_j)).
    fn discs(&self, refined: &[Refined], [radii, rounded, lengths]: [&[f64]; 3], [room, scale]: [f64; 2]) -> Vec<Disc> {
        let k = refined.len();
        let apart = |i: usize, j: usize| refined[i].s.sub(&refined[j].s).square_of_modulus().sqrt().lower();
        let meet = |i: usize, j: usize| apart(i, j) <= up(radii[i] + radii[j]);
        let groups = connected(k, meet);
        let force = |i: usize, distance: f64| up(refined[i].residual + rounded[i] * distance);
        let disc = |j: usize| {
            let members = groups.iter().find(|members| members.contains(&j)).map_or(&[][..], Vec::as_slice);
            let (shared, group) = (members.len(), members.first().copied().unwrap_or(j));
            if shared > 1 {
                let total: f64 = members.iter().map(|i| 2.0 * radii[*i]).sum();
                let radius = up(total * (1.0 + k as f64 * f64::EPSILON));
                return Disc { radius, shared, group, vector: f64::INFINITY };
            }
            let own = force(j, radii[j]);
            let (mut q, mut beside) = (0.0, 0.0);
            for i in (0..k).filter(|i| *i != j) {
                let distance = apart(i, j) - radii[j];
                let part = up(scale / (room * distance));
                q += part * force(i, up(apart(i, j) * (1.0 + 1e-14) + radii[j]));
                beside += part * lengths[i];
            }
            let q = up(q * (1.0 + 4.0 * k as f64 * f64::EPSILON));
            let whole = if q < 1.0 { up(own / (1.0 - q)) } else { f64::INFINITY };
            let vector = up(whole * (1.0 / room + beside) * (1.0 + 4.0 * (k + 4) as f64 * f64::EPSILON));
            Disc { radius: radii[j], shared, group, vector }
        };
        (0..k).map(disc).collect()
    }

    /// That all exponents whose frequency is within `reach` of that asked for are within `known` of σ: by a bound of their growth, and where
    /// this is no help by discs without exponents.
    ///
    /// xᴴ(sM + D + S/s)x = 0 has the real part growth (m + k/|s|²) + c, so that |growth| is at most c/m where k > 0.
    fn covers(&self, reach: f64, known: f64, all: &[Approximation]) -> Option<()> {
        let [velocity, stiffness] = self.form.norms();
        let growth = if self.problem.undamped && self.definite {
            0.0
        } else if self.definite {
            velocity
        } else {
            up(0.5 * (velocity + up((velocity * velocity + 4.0 * stiffness).sqrt())))
        };
        let omega = self.near.unwrap_or(0.0);
        let [low, high] = [(omega - reach).max(0.0), omega + reach];
        // So much growth is within the disc about σ at all of these frequencies.
        let far = (low - self.sigma.im).abs().max((high - self.sigma.im).abs());
        let inner = 0.99 * ((known - far) * (known + far)).sqrt() - self.sigma.re;
        let growth = if inner < growth && self.is_slow([inner, growth], high) { inner } else { growth };
        let fastest = if self.bounded { 0.0 } else { growth };
        let mut empty: Vec<(c64, f64)> = vec![(self.sigma, known)];
        let (mut rest, mut failed) = (vec![[-growth, fastest, low, high]], 0);
        while let Some([left, right, low, high]) = rest.pop() {
            if self.budget.is_spent() {
                return None;
            }
            let corners = [(left, low), (left, high), (right, low), (right, high)];
            let within = |(center, radius): &(c64, f64)| {
                corners.iter().all(|(re, im)| up((re - center.re).hypot(im - center.im) * (1.0 + 1e-14)) < *radius)
            };
            if empty.iter().any(within) {
                continue;
            }
            let center = c64::new(0.5 * (left + right), 0.5 * (low + high));
            let is_known = empty.iter().any(|(other, radius)| (center - other).norm() < 0.7 * radius);
            if !is_known {
                match self.disc(center, 0.5 * (right - left).hypot(high - low), all) {
                    Some(found) if found > SMALLEST * reach.max(known) => empty.push((center, found)),
                    // Perhaps less of it.
                    _ => failed += 1,
                }
                if failed > FAILURES || empty.len() > DISCS {
                    return None;
                }
                if empty.last().is_some_and(within) {
                    continue;
                }
            }
            let [middle, between] = [center.re, center.im];
            if right - left > high - low {
                rest.extend([[left, middle, low, high], [middle, right, low, high]]);
            } else {
                rest.extend([[left, right, low, between], [left, right, between, high]]);
            }
            if rest.len() > 16 * DISCS {
                return None;
            }
        }
        Some(())
    }

    /// Whether there is no exponent whose growth is between these and whose frequency is `high` at most.
    ///
    /// Where |c| <= αm + βk, what is said above of the real part gives |growth| <= (αm + βk) / (m + k/|s|²) <= max(α, β|s|²). With α the least growth
    /// and β|s|² less than the growth at both ends, it is so between these: a convex function of the growth less it.
    fn is_slow(&self, [least, most]: [f64; 2], high: f64) -> bool {
        let SparseQuadratic { mass, velocity, stiffness, passive, .. } = self.problem;
        let beta = 0.99 * [least, most].map(|a| a / (a * a + high * high)).into_iter().fold(f64::INFINITY, f64::min);
        let signs = if *passive { &[-1.0][..] } else { &[-1.0, 1.0] };
        self.definite
            && signs.iter().all(|sign| {
                let rest = symmetric_part(stiffness, beta).plus(&symmetric_part(velocity, *sign));
                let factor = Pencil::new(&rest, mass);
                let factor = factor.as_ref().and_then(|pencil| super::factor(pencil, -0.5 * least, self.budget));
                factor.is_some_and(|own| own.negative == 0 && own.error < 0.5 * least)
            })
    }

    /// The radius of a disc about a number in which there is no exponent, at least as large as is wanted where this is little; `None` where none is
    /// proved.
    fn disc(&self, center: c64, wanted: f64, all: &[Approximation]) -> Option<f64> {
        let pairs = all.iter().flat_map(|own| [own.s, own.s.conj()]);
        let nearest = pairs.map(|s| (s - center).norm()).fold(f64::INFINITY, f64::min);
        let pencil = self.bordered(center, &[])?;
        let radii = [0.6 * nearest, 0.2 * nearest, (1.05 * wanted).min(0.05 * nearest)];
        let least = radii.into_iter().find_map(|radius| pencil.least(radius).ok());
        self.budget.tell(|| match least {
            Some(least) => format!("no exponents within {least:.3e} of {:.3e} + {:.3e} i", center.re, center.im),
            None => format!("exponents about {:.3e} + {:.3e} i: not excluded", center.re, center.im),
        });
        least
    }

    /// The exponent of a column with its vector.
    fn entry(&self, (refined, discs): (&[Refined], &[Disc]), at: usize, options: &Options) -> Option<Exponent> {
        let (own, disc) = (&refined[at], &discs[at]);
        let alone = disc.shared == 1;
        let only = |mirrored: Complex<Ball>| {
            // The mirror image of the exponent is one within the same distance of σ: in this disc, where it meets no other.
            alone
                && refined.iter().zip(discs).enumerate().all(|(i, (other, disc))| {
                    i == at
                        || other.s.sub(&mirrored).square_of_modulus().sqrt().lower()
                            > up(discs[at].radius + disc.radius)
                })
        };
        let near = |x: &Ball| x.abs_lower() <= disc.radius;
        let across = Complex::new(-own.s.re, own.s.im);
        let undamped = self.problem.undamped && (self.definite || near(&own.s.re) && only(across));
        let real = !(self.problem.undamped && self.definite) && near(&own.s.im) && only(own.s.conjugate());
        let part = |zero: bool, x: &Ball| if zero { Ball::ZERO } else { x.with_added_radius(disc.radius) };
        let (growth, omega) = (part(undamped, &own.s.re), part(real, &own.s.im));
        let shape = if options.vectors { self.shape(own, disc)? } else { (Vec::new(), 0.0) };
        let entry = Exponent::new(growth, omega, shape, disc.group as u32);
        let decided = |x: &Ball| x.is_zero() || options.covers(x, false);
        let limit = match (decided(&growth) && decided(&omega), alone) {
            (true, _) => None,
            (false, true) => Some(Limit::Open),
            (false, false) => Some(Limit::Unresolved { count: disc.shared }),
        };
        Some(Exponent { limit, ..entry })
    }

    /// The vector with xᴴMx = 1 and its first component within 1e-6 of the largest real and positive, and a bound of the error of its components.
    fn shape(&self, own: &Refined, disc: &Disc) -> Option<(Vec<c64>, f64)> {
        let n = own.x.len();
        let mut square = Ball::ZERO;
        for i in 0..n {
            for (j, entry) in self.form.mass.entries(i) {
                let (a, b) = (&own.x[i], &own.x[j]);
                square = square + (a.re * b.re + a.im * b.im) * entry;
            }
        }
        let length = square.sqrt();
        let size = length.lower();
        let mut x: Vec<Complex<Ball>> = own.x.iter().map(|x| x.times(&(Ball::ONE / length))).collect();
        let modulus = |x: &Complex<Ball>| x.re.mid_f64().hypot(x.im.mid_f64());
        let first = &x[leading(n, |i| modulus(&x[i]))?.0];
        let turn = first.conjugate().times(&(Ball::ONE / first.square_of_modulus().sqrt()));
        x.iter_mut().for_each(|x| *x = x.mul(&turn));
        // Twice for the length, and as much for the angle, which moves no component by more than the largest is off.
        // √M is not more than the energy's root beside that of its floor.
        let own = disc.vector / self.form.floor.sqrt() * (1.0 + 1e-14);
        let off = up(2.0 * own / size * self.form.roots.iter().copied().fold(0.0, f64::max));
        let rounding = x.iter().map(|x| x.re.mid_f64_error().hypot(x.im.mid_f64_error())).fold(0.0, f64::max);
        let component = |x: &Complex<Ball>| {
            let z = x.to_c64();
            if z.im.abs() <= 1e-300 || modulus(x) == z.re.abs() { c64::new(z.re, 0.0) } else { z }
        };
        Some((x.iter().map(component).collect(), up(2.7 * off + rounding + U2)))
    }
}

impl Refined {
    fn is_real(&self) -> bool {
        self.s.im.is_zero()
    }

    /// The vector of first order, and E times the left one.
    fn pair(&self, form: &Form) -> [Vec<c64>; 2] {
        let y = self.x.iter().map(|x| x.mul(&self.s).to_c64());
        [self.x.iter().map(Complex::to_c64).chain(y).collect(), form.first_order(&self.left)]
    }
}

fn norm(x: &[c64]) -> f64 {
    x.iter().map(c64::norm_sqr).sum::<f64>().sqrt()
}

/// xᴴy.
fn product(x: &[c64], y: &[c64]) -> c64 {
    x.iter().zip(y).fold(c64::new(0.0, 0.0), |sum, (x, y)| sum + x.conj() * y)
}
