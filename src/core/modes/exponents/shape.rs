//! Vectors as they are printed, and their bounds.

use faer::c64;

use super::super::leading;
use super::complex::part;
use super::scale::Scaled;
use super::solve::Solution;
use crate::precision::up;

/// Vectors as they are printed, and their bounds.
pub(super) struct Shapes<'a> {
    pub(super) scaled: &'a Scaled,
    pub(super) solution: &'a Solution,
    pub(super) wanted: bool,
}

impl Shapes<'_> {
    /// The vector of a column and a bound of the error of each component.
    ///
    /// The exact vector is x + e with |e_p| <= ε_p = Σ_i |x_pi| τ_i over the columns outside the group, up to a factor:
    /// the coefficients of an eigenvector that outside of the group are at most τ (see
    /// [`super::certify`]). With |e|_M <= ε, both vectors divided by their M-lengths (1 and a number within ε of 1,
    /// for x of length 1) differ by at most ε_p + (|x_p| + ε_p) ε / (1 - ε); making component k real turns the exact
    /// one by an angle of at most asin(ε_k / |x_k|) <= (π/2) ε_k / |x_k|, which moves every component by at
    /// most that times its size.
    pub(super) fn of(&self, j: usize) -> (Vec<c64>, f64) {
        if !self.wanted {
            return (Vec::new(), 0.0);
        }
        let Solution { columns, measured, certificate, .. } = self.solution;
        let n = self.scaled.n;
        let x: Vec<c64> = measured[j].x.iter().map(|x| x.value).collect();
        let group = &certificate.groups[certificate.of[j]];
        let mut off: Vec<f64> = measured[j].x.iter().map(|x| x.error + f64::EPSILON * x.value.norm()).collect();
        if j >= columns.zeros {
            for (i, &reach) in group.reach.iter().enumerate() {
                if reach > 0.0 {
                    for (off, x) in off.iter_mut().zip(&measured[i].x) {
                        *off += (x.value.norm() + x.error) * reach;
                    }
                }
            }
        }
        let slack = 1.0 + 8.0 * (columns.count() as f64 + 4.0) * f64::EPSILON;
        // xᴴMx and what it may be off by: M as an enclosure, sums of n² terms in doubles.
        let sizes: Vec<f64> = x.iter().map(|x| x.norm()).collect();
        let weighted = self.scaled.mass.magnitude_times(&sizes);
        let places = (0..n).flat_map(|p| (0..n).map(move |q| (p, q)));
        let term = |(p, q): (usize, usize)| self.scaled.mass.mid.get(p, q).hi * (x[p].re * x[q].re + x[p].im * x[q].im);
        let square: f64 = places.map(term).sum();
        let terms: f64 = sizes.iter().zip(&weighted).map(|(a, b)| a * b).sum();
        let rounding = (2.0 * n as f64 + 8.0) * f64::EPSILON * terms + self.scaled.mass.uncertainty(&sizes);
        let length = square.sqrt();
        // |√(s + h) - √s| <= |h| / √s.
        let length_error = rounding / length;
        let error_square: f64 = off.iter().zip(self.scaled.mass.magnitude_times(&off)).map(|(a, b)| a * b).sum();
        let epsilon = up((error_square.sqrt() * slack * slack + length_error) / (length - length_error));
        // In the coordinates of the problem.
        let physical = |p: usize, value: f64| value * f64::from(self.scaled.shift[p]).exp2();
        let Some((first, _)) = leading(n, |p| physical(p, sizes[p])) else {
            return (vec![c64::new(0.0, 0.0); n], f64::INFINITY);
        };
        let turn = c64::new(x[first].re, -x[first].im) / sizes[first] / length;
        let angle = 1.6 * off[first] * slack / sizes[first];
        let error = |p: usize| {
            let share = (sizes[p] + off[p]) * (epsilon / (1.0 - epsilon) + angle);
            let error = (off[p] + share) * slack / (length - length_error) + 8.0 * f64::EPSILON * sizes[p] / length;
            up(physical(p, error))
        };
        let errors: Vec<f64> = (0..n).map(error).collect();
        let is_known = epsilon < 0.5 && errors.iter().all(|error| error.is_finite());
        let bound = if is_known { errors.into_iter().fold(0.0, f64::max) } else { f64::INFINITY };
        let component = |p: usize| {
            let value = part(x[p] * turn, p == first);
            c64::new(physical(p, value.re), physical(p, value.im))
        };
        ((0..n).map(component).collect(), bound)
    }
}
