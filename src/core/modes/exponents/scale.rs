//! The matrices in units in which M has diagonal entries in [1, 4) and no exponent is much above 1.

use super::super::pencil::{Enclosed, check, halves};
use super::super::{ModesError, Which};
use super::{QuadraticProblem, Structure};
use crate::precision::{Ball, exponent_of, up};

/// M, D and S in coordinates q = 2^shift q' and an exponent λ = 2^power λ'.
pub(super) struct Scaled {
    pub(super) n: usize,
    pub(super) structure: Structure,
    pub(super) shift: Vec<i32>,
    pub(super) power: i32,
    pub(super) mass: Enclosed,
    pub(super) velocity: Enclosed,
    pub(super) stiffness: Enclosed,
    /// The transposes, for left vectors.
    pub(super) velocity_t: Enclosed,
    pub(super) stiffness_t: Enclosed,
    /// Linearly independent vectors of the kernel of S, scaled.
    pub(super) zero: Vec<Vec<Ball>>,
    /// Which of these are in that of D.
    pub(super) unmoved: Vec<bool>,
}

impl Enclosed {
    /// Whether the exact matrix is symmetric, as far as exact entries tell.
    pub(super) fn is_symmetric(&self) -> bool {
        let n = self.mid.rows;
        (0..n).all(|j| {
            (0..j).all(|i| {
                self.radius.get(i, j) == 0.0 && self.radius.get(j, i) == 0.0 && self.mid.get(i, j) == self.mid.get(j, i)
            })
        })
    }

    /// A bound of how far xᵀAy may be from the form of the midpoints, for |x| and |y| at most `x`.
    pub(super) fn uncertainty(&self, x: &[f64]) -> f64 {
        let n = x.len();
        let places = (0..n).flat_map(|i| (0..n).map(move |k| (i, k)));
        up(places.map(|(i, k)| x[i] * self.radius.get(i, k) * x[k]).sum::<f64>()
            * (1.0 + (n * n) as f64 * f64::EPSILON))
    }

    /// A bound of |A| x for x >= 0, uncertainty of A included.
    pub(super) fn magnitude_times(&self, x: &[f64]) -> Vec<f64> {
        let image = |row: usize| {
            let terms = x.iter().enumerate().map(|(k, x)| (self.mid.get(row, k).hi.abs() + self.weight(row, k)) * x);
            up(terms.sum::<f64>() * (1.0 + x.len() as f64 * f64::EPSILON))
        };
        (0..self.mid.rows).map(image).collect()
    }
}

impl Scaled {
    pub(super) fn new(problem: &QuadraticProblem) -> Result<Self, ModesError> {
        let n = problem.dimension;
        check(n, Which::Mass, &problem.mass)?;
        check(n, Which::Velocity, &problem.velocity)?;
        check(n, Which::Stiffness, &problem.stiffness)?;
        if let Some(index) = problem.zero_vectors.iter().position(|v| v.len() != n) {
            return Err(ModesError::ZeroVector { index });
        }
        let shift = halves(n, &problem.mass);
        // |λ| is at most about max(|D|, √|S|).
        let sizes = (0..n * n).flat_map(|at| {
            let by = shift[at % n] + shift[at / n];
            let (d, s) = (problem.velocity[at].mid.hi, problem.stiffness[at].mid.hi);
            let of_d = (d != 0.0).then(|| exponent_of(d) + by + 1);
            [of_d, (s != 0.0).then(|| (exponent_of(s) + by + 2).div_euclid(2))]
        });
        let power = sizes.flatten().max().unwrap_or(0);
        let matrix = |entries: &[Ball], times: i32, transposed: bool| {
            Enclosed::new(n, |row, column| {
                let at = if transposed { row * n + column } else { column * n + row };
                entries[at].scale(shift[row] + shift[column] - times * power)
            })
        };
        let (mass, velocity, stiffness) = (&problem.mass, &problem.velocity, &problem.stiffness);
        let zero = |vector: &Vec<Ball>| {
            let v: Vec<Ball> = vector.iter().zip(&shift).map(|(x, s)| x.scale(-s)).collect();
            let most = v.iter().fold(0.0_f64, |m, x| m.max(x.mid.hi.abs()));
            // The length does not matter, and about 1 is best.
            let by = if most > 0.0 { -exponent_of(most) } else { 0 };
            v.iter().map(|x| x.scale(by)).collect()
        };
        Ok(Self {
            n,
            structure: problem.structure,
            power,
            mass: matrix(mass, 0, false),
            velocity: matrix(velocity, 1, false),
            stiffness: matrix(stiffness, 2, false),
            velocity_t: matrix(velocity, 1, true),
            stiffness_t: matrix(stiffness, 2, true),
            zero: problem.zero_vectors.iter().map(zero).collect(),
            unmoved: problem.unmoved.clone(),
            shift,
        })
    }
}
