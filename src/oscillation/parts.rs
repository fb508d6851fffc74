//! Motions without dissipation beside damped ones that nothing couples them to.
//!
//! Where M, G, C, K and N are block diagonal, exactly, a block without C and N keeps the structure that the whole has lost: its
//! growth is exactly 0 where it is, whether numbers are rational or not. So it is solved by itself.

use faer::c64;

use super::exponents::Source;
use crate::linearize::{Linearized, ZeroMode};
use crate::modes::Options;
use crate::modes::exponents::{
    ExponentKind, Exponents, IntegerQuadratic, PreciseQuadratic, QuadraticProblem, QuadraticSource,
    Structure, exponents, joined,
};
use crate::precision::Ball;

/// Some coordinates of a model.
struct Part<'a> {
    whole: Source<'a>,
    own: &'a [usize],
}

fn block<N: Clone>(matrix: &[N], n: usize, own: &[usize]) -> Vec<N> {
    let pairs = own.iter().flat_map(|j| own.iter().map(move |i| i + n * j));
    pairs.filter_map(|at| matrix.get(at).cloned()).collect()
}

fn piece<N: Clone>(vector: &[N], own: &[usize]) -> Vec<N> {
    own.iter().filter_map(|i| vector.get(*i).cloned()).collect()
}

impl QuadraticSource for Part<'_> {
    fn precisely(&self, bits: usize) -> Option<PreciseQuadratic> {
        let whole = self.whole.precisely(bits)?;
        let n = whole.mass.len().isqrt();
        Some(PreciseQuadratic {
            mass: block(&whole.mass, n, self.own),
            velocity: block(&whole.velocity, n, self.own),
            stiffness: block(&whole.stiffness, n, self.own),
            zero_vectors: whole
                .zero_vectors
                .iter()
                .map(|vector| piece(vector, self.own))
                .collect(),
        })
    }

    fn integers(&self) -> Option<IntegerQuadratic> {
        let whole = self.whole.integers()?;
        let n = whole.mass.len().isqrt();
        Some(IntegerQuadratic {
            mass: block(&whole.mass, n, self.own),
            velocity: block(&whole.velocity, n, self.own),
            stiffness: block(&whole.stiffness, n, self.own),
        })
    }
}

/// The exponents, where a damped model has coordinates that no friction reaches; `None` for any other model, and where the
/// conventions for what is damped and what is not differ: motions that grow, and free ones with gyroscopic forces. Zero modes
/// are put in the order of the parts.
pub(super) fn solve(
    linearized: &Linearized,
    problem: &QuadraticProblem,
    zero_modes: &mut Vec<ZeroMode>,
    options: &Options,
) -> Option<Exponents> {
    if problem.structure != Structure::Damped {
        return None;
    }
    let n = problem.dimension;
    let [free, rest] = divided(linearized, problem)?;
    let lies_in = |mode: &ZeroMode, own: &[usize]| {
        (0..n).all(|i| own.contains(&i) || mode.vector[i].is_zero())
    };
    let (first, others): (Vec<ZeroMode>, Vec<ZeroMode>) = zero_modes
        .iter()
        .cloned()
        .partition(|mode| lies_in(mode, &free));
    if !others.iter().all(|mode| lies_in(mode, &rest)) {
        return None;
    }
    let every = Options {
        lowest: None,
        ..options.clone()
    };
    let part = |own: &[usize], zero_modes: &[ZeroMode], structure: Structure| {
        let own_problem = QuadraticProblem {
            dimension: own.len(),
            mass: block(&problem.mass, n, own),
            velocity: block(&problem.velocity, n, own),
            stiffness: block(&problem.stiffness, n, own),
            structure,
            zero_vectors: zero_modes
                .iter()
                .map(|mode| piece(&mode.vector, own))
                .collect(),
        };
        if structure == Structure::Gyroscopic
            && !zero_modes.is_empty()
            && !own_problem.velocity.iter().all(Ball::is_zero)
        {
            return None;
        }
        let whole = Source {
            linearized,
            zero_modes,
        };
        // What is wrong with a part is told of the whole.
        let mut found = exponents(&own_problem, &Part { whole, own }, &every).ok()?;
        for entry in &mut found.entries {
            if entry.vector.is_empty() {
                continue;
            }
            let mut vector = vec![c64::new(0.0, 0.0); n];
            for (i, x) in own.iter().zip(&entry.vector) {
                vector[*i] = *x;
            }
            entry.vector = vector;
        }
        Some(found)
    };
    let undamped = part(&free, &first, Structure::Gyroscopic)?;
    let alike = |kind: ExponentKind| matches!(kind, ExponentKind::Oscillation | ExponentKind::Zero);
    if !undamped.entries.iter().all(|entry| alike(entry.kind)) {
        return None;
    }
    let damped = part(&rest, &others, Structure::Damped)?;
    *zero_modes = first;
    zero_modes.extend(others);
    Some(joined(vec![undamped, damped], options))
}

/// The coordinates that no friction reaches, and the others; `None` where there is nothing to be divided.
fn divided(linearized: &Linearized, problem: &QuadraticProblem) -> Option<[Vec<usize>; 2]> {
    let n = problem.dimension;
    let friction: Vec<Vec<Ball>> = [linearized.damping(), linearized.circulatory()]
        .into_iter()
        .flatten()
        .collect();
    let acts = |matrix: &[Ball], i: usize, j: usize| {
        !matrix[i + n * j].is_zero() || !matrix[j + n * i].is_zero()
    };
    let mut reached: Vec<bool> = (0..n)
        .map(|i| friction.iter().any(|own| (0..n).any(|j| acts(own, i, j))))
        .collect();
    let mut todo: Vec<usize> = (0..n).filter(|i| reached[*i]).collect();
    let coupling = [&problem.mass, &problem.velocity, &problem.stiffness];
    while let Some(i) = todo.pop() {
        for j in 0..n {
            if !reached[j] && coupling.iter().any(|own| acts(own, i, j)) {
                reached[j] = true;
                todo.push(j);
            }
        }
    }
    let (rest, free): (Vec<usize>, Vec<usize>) = (0..n).partition(|i| reached[*i]);
    (!free.is_empty() && !rest.is_empty()).then_some([free, rest])
}
