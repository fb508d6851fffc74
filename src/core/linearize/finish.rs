//! Newton's last steps and the proof of an equilibrium with forces of many bits, where double-double
//! does not do.
//!
//! Two things stop the search in doubles: a stiffness so large that its rounding hides what is soft
//! beside it, and forces that are what is left of terms which cancel. Against the first, WᵀKW is
//! multiplied out in many bits for approximate principal axes W, and these are mended in the units that its
//! diagonal gives them, in which soft and stiff count alike; a few rounds do for stiffnesses that differ
//! by 1e30. Against the second, forces and stiffness are worked out in many bits, and the box of
//! the proof is as much smaller.
//!
//! It is tried only where the proof in doubles fails, and never says more than is proved.

use nalgebra::{DMatrix, SymmetricEigen};

use super::equilibrium::Search;
use super::existence::{Axes, Products, Proof, Setting, congruent};
use super::symmetry::Symmetry;
use crate::order::places;
use crate::precision::{Ball, Big};

/// Products of matrices of so many bits take seconds beyond this.
const MOST: usize = 80;

/// The bits that are tried, one after the other.
const BITS: [usize; 2] = [256, 768];

/// Double-double should tell the place better than this, beside the size of the coordinates.
const FAR: f64 = 1e-20;

/// From so many coordinates on only the first of them.
const MANY: usize = 30;

/// Principal axes are renewed so often at most, at a point and on the way to it.
const ROUNDS: usize = 4;

/// Newton steps with the same axes gain digits each, or there is something wrong.
const MOST_STEPS: usize = 60;

impl Search<'_> {
    /// Goes on from a point that is nearly an equilibrium; `axes` are approximate principal axes of the
    /// stiffness there, orthonormal in some metric. Gives the proof, and the free coordinates.
    pub(super) fn finish(
        &self,
        at: &[Ball],
        axes: &DMatrix<f64>,
        symmetries: &[Symmetry],
    ) -> Option<(Proof, Vec<Ball>)> {
        let size = self.free.len();
        if size > MOST {
            return None;
        }
        let tried = if size > MANY { 1 } else { BITS.len() };
        BITS.iter().take(tried).find_map(|bits| self.finish_with(*bits, at, axes, symmetries))
    }

    /// The free coordinates as many bits tell them, where double-double leaves the place more open
    /// than it should, as forces that cancel do.
    pub(super) fn closer_place(&self, at: &[Ball], proof: &Proof, radii: &[f64]) -> Option<Vec<Ball>> {
        let sizes = self.free.iter().map(|i| at[*i].mid_f64().abs());
        let largest = sizes.fold(0.0, f64::max);
        if radii.iter().all(|radius| *radius <= FAR * largest) {
            return None;
        }
        let [bits, _] = BITS;
        let values = self.assembly.values::<Big>(self.model, bits).ok()?;
        let gradient = |at: &[Big]| self.assembly.gradient(at, &values);
        let point = proof.refine(self.middle(at, bits)?, bits, gradient)?;
        Some(self.free.iter().map(|i| point[*i].to_ball()).collect())
    }

    /// A point in numbers of so many bits: what is given exactly, of the rest the middle.
    fn middle(&self, at: &[Ball], bits: usize) -> Option<Vec<Big>> {
        self.in_bits(at, bits, |value| Some(Big::from_ball(value, bits).center()))
    }

    fn finish_with(
        &self,
        bits: usize,
        at: &[Ball],
        axes: &DMatrix<f64>,
        symmetries: &[Symmetry],
    ) -> Option<(Proof, Vec<Ball>)> {
        let values = self.assembly.values::<Big>(self.model, bits).ok()?;
        let mut point = self.middle(at, bits)?;
        let setting = Setting {
            assembly: self.assembly,
            values: &values,
            free: &self.free,
            products: Products::Enclosed,
            bits,
            // Half of the bits for the box, half for the forces within.
            room: 2f64.powi(-(bits as i32) / 2),
        };
        let mut axes = principal(&setting.stiffness(&point), axes, symmetries.len(), bits)?;
        for _ in 0..ROUNDS {
            let (reach, gradient) = (vec![1.0; axes.signs.len()], |at: &[Big]| self.assembly.gradient(at, &values));
            let newton = axes.newton(point, &self.free, &reach, (MOST_STEPS, 1), gradient)?;
            point = newton.point;
            if newton.steps <= 1 {
                break;
            }
            axes = principal(&setting.stiffness(&point), &axes.directions, 0, bits)?;
        }
        let (proof, radii) = setting.prove(&point, axes, symmetries)?;
        let free = self.free.iter().zip(radii);
        let place = free.map(|(i, radius)| point[*i].to_ball().with_added_radius(radius));
        Some((proof, place.collect()))
    }
}

/// Principal axes of a stiffness (column by column), from approximate ones; as many of the softest as
/// `fewer` are left out.
fn principal(stiffness: &[Big], guess: &DMatrix<f64>, mut fewer: usize, bits: usize) -> Option<Axes> {
    let mut directions = guess.clone();
    let mut found = None;
    for _ in 0..ROUNDS {
        let count = directions.ncols();
        let image = congruent(stiffness, &directions, bits);
        let entry = |i: usize, j: usize| image[i + count * j].mid_f64();
        let mut order = places(count, &mut |a, b| entry(*b, *b).abs().total_cmp(&entry(*a, *a).abs()));
        order.truncate(count.checked_sub(fewer).filter(|kept| *kept > 0)?);
        fewer = 0;
        // In these units the diagonal is 1 and -1.
        let units: Vec<f64> = order.iter().map(|i| entry(*i, *i).abs().sqrt()).collect();
        let scaled = DMatrix::from_fn(order.len(), order.len(), |i, j| entry(order[i], order[j]) / units[i] / units[j]);
        if !scaled.iter().all(|x| x.is_finite()) {
            return None;
        }
        let beside = (0..order.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let worst = beside.fold(0.0_f64, |worst, at| worst.max(scaled[at].abs()));
        let eigen = SymmetricEigen::new(scaled);
        let axes = DMatrix::from_fn(directions.nrows(), order.len(), |i, j| directions[(i, order[j])] / units[j]);
        let axes = Axes::new(&(axes * &eigen.eigenvectors), eigen.eigenvalues.as_slice(), 0)?;
        directions.clone_from(&axes.directions);
        found = Some(axes);
        // What is left is of second order.
        if worst <= 1e-4 {
            break;
        }
    }
    found
}
