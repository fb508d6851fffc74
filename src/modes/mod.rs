//! A stand-in, to be replaced: normal modes in double precision without honest bounds.

use crate::linearize::{LinearizeError, Linearized};
use crate::precision::Ball;

/// What is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Whether mode shapes are wanted.
    pub vectors: bool,
    /// Only so many, the lowest.
    pub lowest: Option<usize>,
    /// Significant digits of the frequencies.
    pub digits: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { vectors: true, lowest: None, digits: 10 }
    }
}

/// All modes.
#[derive(Clone, Debug)]
pub struct NormalModes {
    /// Of the equilibrium.
    pub stability: Stability,
    /// In the order printed.
    pub modes: Vec<NormalMode>,
}

/// One mode.
#[derive(Clone, Debug)]
pub struct NormalMode {
    /// What it does.
    pub kind: Kind,
    /// omega^2
    pub omega_squared: Ball,
    /// omega
    pub omega: Ball,
    /// The growth rate.
    pub growth: Ball,
    /// The shape; empty without vectors.
    pub vector: Vec<f64>,
    /// Of each component.
    pub vector_error_bound: f64,
    /// The cluster.
    pub cluster: u32,
    /// The symmetry class.
    pub symmetry: Option<String>,
    /// What a zero mode is.
    pub meaning: Option<String>,
}

/// What a mode does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It oscillates.
    Oscillation,
    /// Nothing drives it back.
    Zero,
    /// It grows.
    Unstable,
    /// The bounds don't decide.
    Undecided,
}

/// Of the equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// All modes oscillate.
    Stable,
    /// There is a zero mode.
    Neutral,
    /// A mode grows.
    Unstable,
    /// The bounds don't decide.
    Undecided,
}

/// The modes.
///
/// # Errors
/// A singular mass matrix.
pub fn normal_modes(lin: &Linearized, options: &Options) -> Result<NormalModes, LinearizeError> {
    let n = lin.dimension();
    let (m, k) = (lin.mass(), lin.stiffness());
    let mm = nalgebra::DMatrix::from_fn(n, n, |i, j| m[i + n * j].mid_f64());
    let kk = nalgebra::DMatrix::from_fn(n, n, |i, j| k[i + n * j].mid_f64());
    let singular = || LinearizeError::SingularMass {
        combination: vec![(lin.model().coordinates[0].name.clone(), 1.0)],
        span: lin.model().coordinates[0].span,
    };
    let l = nalgebra::Cholesky::new(mm).ok_or_else(singular)?.l();
    let a = l.solve_lower_triangular(&kk).ok_or_else(singular)?;
    let a = l.solve_lower_triangular(&a.transpose()).ok_or_else(singular)?;
    let e = nalgebra::SymmetricEigen::new((&a + a.transpose()) * 0.5);
    let x = l.transpose().solve_upper_triangular(&e.eigenvectors).ok_or_else(singular)?;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| e.eigenvalues[*a].total_cmp(&e.eigenvalues[*b]));
    let scale = e.eigenvalues.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    let mut modes = Vec::new();
    for i in order {
        let w = e.eigenvalues[i];
        let bound = 1e-15 * scale;
        let zero = w.abs() < 1e-12 * scale;
        let w = if zero { Ball::ZERO } else { Ball::from(w).with_added_radius(bound) };
        let undecided = !zero && w.contains_zero();
        let kind = if zero { Kind::Zero } else if undecided { Kind::Undecided } else if w.is_positive() { Kind::Oscillation } else { Kind::Unstable };
        let v: Vec<f64> = x.column(i).iter().copied().collect();
        let big = v.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        let sign = v.iter().find(|c| c.abs() > big * (1.0 - 1e-6)).map_or(1.0, |c| c.signum());
        modes.push(NormalMode {
            kind,
            omega_squared: w,
            omega: if kind == Kind::Oscillation { w.sqrt() } else { Ball::ZERO },
            growth: if kind == Kind::Unstable { (-w).sqrt() } else { Ball::ZERO },
            vector: if options.vectors { v.iter().map(|c| c * sign).collect() } else { Vec::new() },
            vector_error_bound: 1e-15 * big,
            cluster: 0,
            symmetry: None,
            meaning: None,
        });
    }
    if let Some(lowest) = options.lowest {
        modes.truncate(lowest);
    }
    let any = |kind| modes.iter().any(|m| m.kind == kind);
    let stability = if any(Kind::Unstable) { Stability::Unstable } else if any(Kind::Undecided) { Stability::Undecided } else if any(Kind::Zero) { Stability::Neutral } else { Stability::Stable };
    Ok(NormalModes { stability, modes })
}
