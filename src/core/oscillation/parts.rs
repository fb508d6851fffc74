//! Motions without dissipation beside damped ones that nothing couples them to.
//!
//! Where M, G, C, K and N are block diagonal, exactly, a block without C and N keeps the structure that the whole has lost: its
//! growth is exactly 0 where it is, whether numbers are rational or not. So it is solved by itself. And one coordinate with c² = 4 m k is
//! damped critically, which no bound ever tells, but the expressions may.

use dashu_int::IBig;
use faer::c64;

use super::exponents::Source;
use crate::expr::ExprId;
use crate::groups::connected;
use crate::linearize::{Linearized, ZeroMode, known_values};
use crate::modes::exponents::{
    self, Exponents, PreciseQuadratic, QuadraticProblem, QuadraticSource, Structure, exponents, joined,
};
use crate::modes::{Kind, Options};
use crate::precision::{Ball, Integers};

/// Beyond this many digits a ball may not have them.
const MOST_OF_A_BALL: usize = 25;

/// Some coordinates of a model.
struct Part<'a> {
    whole: Source<'a>,
    own: &'a [usize],
}

fn block<N: Clone>(matrix: &[N], n: usize, own: &[usize]) -> Vec<N> {
    own.iter().flat_map(|j| own.iter().map(move |i| i + n * j)).filter_map(|at| matrix.get(at).cloned()).collect()
}

fn piece<N: Clone>(vector: &[N], own: &[usize]) -> Vec<N> {
    own.iter().filter_map(|i| vector.get(*i).cloned()).collect()
}

impl QuadraticSource for Part<'_> {
    fn precisely(&self, bits: usize) -> Option<PreciseQuadratic> {
        let whole = self.whole.precisely(bits)?;
        Some(whole.map(|matrix| block(&matrix, matrix.len().isqrt(), self.own)))
    }

    fn integers(&self) -> Option<Integers> {
        let whole = self.whole.integers()?;
        let square = whole.matrices[0].len() >> whole.roots.len();
        let blocks = |matrix: &[IBig]| -> Vec<IBig> {
            matrix.chunks(square.max(1)).flat_map(|part| block(part, square.isqrt(), self.own)).collect()
        };
        let matrices = whole.matrices.each_ref().map(|matrix| blocks(matrix));
        Some(Integers { matrices, coordinates: piece(&whole.coordinates, self.own), ..whole })
    }
}

/// The exponents, where a damped model has coordinates that no friction reaches, or one by itself whose damping is
/// critical for numbers that are irrational; `None` for any other model, and where the conventions for what is damped and what is
/// not differ: motions that grow, and free ones with gyroscopic forces. Zero modes are put in the order of the parts.
pub(super) fn solve(
    whole: Source<'_>,
    problem: &QuadraticProblem,
    zero_modes: &mut Vec<ZeroMode>,
    options: &Options,
) -> Option<Exponents> {
    if problem.structure == Structure::Gyroscopic {
        return None;
    }
    let n = problem.dimension;
    let critical = critical(whole.linearized, problem);
    let [free, rest] = divided(whole, problem, &critical);
    if rest.len() == n {
        return None;
    }
    let lies_in = |mode: &ZeroMode, own: &[usize]| (0..n).all(|i| own.contains(&i) || mode.vector[i].is_zero());
    let (first, others): (Vec<ZeroMode>, Vec<ZeroMode>) =
        zero_modes.iter().cloned().partition(|mode| lies_in(mode, &free));
    if !others.iter().all(|mode| lies_in(mode, &rest)) {
        return None;
    }
    let every = Options { lowest: None, ..options.clone() };
    let part = |own: &[usize], zero_modes: &[ZeroMode], structure: Structure| {
        let own_problem = QuadraticProblem {
            dimension: own.len(),
            mass: block(&problem.mass, n, own),
            velocity: block(&problem.velocity, n, own),
            stiffness: block(&problem.stiffness, n, own),
            structure,
            zero_vectors: zero_modes.iter().map(|mode| piece(&mode.vector, own)).collect(),
            unmoved: whole.linearized.unmoved(zero_modes),
        };
        if structure == Structure::Gyroscopic
            && !zero_modes.is_empty()
            && !own_problem.velocity.iter().all(Ball::is_zero)
        {
            return None;
        }
        if own.is_empty() {
            return Some(joined(Vec::new(), &every));
        }
        // What is wrong with a part is told of the whole.
        let mut found = exponents(&own_problem, &Part { whole, own }, &every).ok()?;
        embed(&mut found, own, n);
        Some(found)
    };
    let undamped = part(&free, &first, Structure::Gyroscopic)?;
    let alike = |kind: Kind| matches!(kind, Kind::Oscillation | Kind::Zero);
    if !undamped.entries.iter().all(|entry| alike(entry.kind)) {
        return None;
    }
    let mut parts = vec![undamped, part(&rest, &others, problem.structure)?];
    *zero_modes = first;
    zero_modes.extend(others);
    for i in critical {
        let at = i + n * i;
        let precise = (options.digits > MOST_OF_A_BALL).then(|| {
            let precise = whole.linearized.precisely(options.digits * 4 + 64)?;
            Some([precise.mass.get(at)?.clone(), precise.velocity?.get(at)?.clone()])
        });
        let mass = &problem.mass[at];
        let mut found = exponents::critical(mass, &problem.velocity[at], precise.flatten(), &every);
        if !options.vectors {
            found.entries.iter_mut().for_each(|entry| entry.vector.clear());
        }
        embed(&mut found, &[i], n);
        parts.push(found);
    }
    Some(joined(parts, options))
}

/// Vectors of some coordinates, in all of them.
fn embed(found: &mut Exponents, own: &[usize], n: usize) {
    for entry in &mut found.entries {
        if entry.vector.is_empty() {
            continue;
        }
        let mut vector = vec![c64::new(0.0, 0.0); n];
        own.iter().zip(&entry.vector).for_each(|(i, x)| vector[*i] = *x);
        entry.vector = vector;
    }
}

/// Whether an entry off the diagonal, or its mirror image, is anything but 0, exactly.
fn couples(matrix: &[Ball], n: usize, i: usize, j: usize) -> bool {
    !matrix[i + n * j].is_zero() || !matrix[j + n * i].is_zero()
}

/// Coordinates by themselves with c² = 4 m k, decided on the exact expressions; none where all numbers are rational, which are decided
/// with their characteristic polynomial.
fn critical(linearized: &Linearized, problem: &QuadraticProblem) -> Vec<usize> {
    let n = problem.dimension;
    let matrices = [&problem.mass, &problem.velocity, &problem.stiffness];
    let near = |i: &usize| {
        let [m, c, k] = matrices.map(|matrix| matrix[i + n * i]);
        let alone = || (0..n).all(|j| j == *i || !matrices.iter().any(|a| couples(a, n, *i, j)));
        !c.contains_zero() && (c * c - (m * k).scale(2)).contains_zero() && alone()
    };
    let near: Vec<usize> = (0..n).filter(near).collect();
    if near.is_empty()
        || linearized.is_reduced()
        || n <= exponents::MOST_EXACT && linearized.integers().is_some_and(|own| own.roots.is_empty())
    {
        return Vec::new();
    }
    let mut own = linearized.symbolic();
    let values = known_values(linearized.model());
    let decided = |i: &usize| {
        let (i, pool) = (*i, &mut own.pool);
        let zero = pool.zero();
        let of = |matrix: &Option<Vec<Vec<ExprId>>>| matrix.as_ref().map_or(zero, |a| a[i][i]);
        let (m, c) = (own.mass[i][i], of(&own.damping));
        let k = pool.sum(&[own.stiffness[i][i], of(&own.circulatory)]);
        let four = pool.integer(4);
        let (square, product) = (pool.mul(c, c), pool.product(&[four, m, k]));
        let discriminant = pool.sub(square, product);
        let discriminant = pool.substitute_one(discriminant, &values);
        pool.vanishes(discriminant)
    };
    near.into_iter().filter(decided).collect()
}

/// The coordinates that no friction reaches, nor an equation that was multiplied, and the others, but for those that are left out.
fn divided(whole: Source<'_>, problem: &QuadraticProblem, left_out: &[usize]) -> [Vec<usize>; 2] {
    let n = problem.dimension;
    let Source { linearized, flow } = whole;
    let multiplied = flow.map_or(&[][..], |own| &own.places);
    let friction: Vec<Vec<Ball>> = [linearized.damping(), linearized.circulatory()].into_iter().flatten().collect();
    let rubs = |i: usize| friction.iter().any(|own| (0..n).any(|j| couples(own, n, i, j)));
    let starts = |i: &usize| multiplied.contains(i) || rubs(*i);
    let matrices = [&problem.mass, &problem.velocity, &problem.stiffness];
    let groups = connected(n, |i, j| matrices.iter().any(|own| couples(own, n, i, j))).into_iter();
    let reached: Vec<usize> = groups.filter(|own| own.iter().any(starts)).flatten().collect();
    let kept = (0..n).filter(|i| !left_out.contains(i));
    let (rest, free) = kept.partition(|i| reached.contains(i));
    [free, rest]
}
