//! How many bits it takes. Estimates only: whether they were enough is for the certificate to say.

use crate::modes::certify::Couplings;
use crate::modes::dense::Matrix;

/// Bits of an eigenvalue beyond which a rounding is left open: entries have little more.
const MOST_BITS: f64 = 900.0;
/// Bits below the largest eigenvalue down to which signs are searched for, at first and at last.
const SIGNS: [f64; 2] = [192.0, 640.0];
/// Columns with more bits than this would leave the range in which double-doubles copy them.
const MOST_COLUMN_BITS: f64 = 900.0;

/// What is aimed at.
pub(super) struct Goal {
    /// Bits of an eigenvalue relative to itself.
    bits: f64,
    signs: usize,
    /// The largest eigenvalue, roughly.
    pub(super) largest: f64,
}

impl Goal {
    pub(super) fn new(digits: usize) -> Self {
        Self { bits: (digits as f64 + 4.0) * std::f64::consts::LOG2_10, signs: 0, largest: 1.0 }
    }

    /// Eigenvalues below this are not told from 0 yet.
    pub(super) fn floor(&self) -> f64 {
        self.largest * (-SIGNS[self.signs]).exp2()
    }

    /// The radius that an eigenvalue of this size shall have.
    pub(super) fn target(&self, size: f64) -> f64 {
        size.max(self.floor()) * (-self.bits).exp2()
    }

    /// More bits for signs or roundings that are still open; `false` if that would be no use.
    pub(super) fn raise(&mut self, signs: bool, roundings: bool) -> bool {
        let (deeper, finer) = (signs && self.signs + 1 < SIGNS.len(), roundings && self.bits < MOST_BITS);
        self.signs += usize::from(deeper);
        if finer {
            self.bits = (2.0 * self.bits).clamp(64.0, MOST_BITS);
        }
        deeper || finer
    }
}

/// Bits after the point.
pub(super) struct Plan {
    /// Of M and K.
    pub(super) matrices: i64,
    /// Of the columns.
    pub(super) columns: i64,
}

impl Plan {
    /// For some columns of a basis with these couplings; `stiffness` and `mass` are norms of K and M.
    ///
    /// A unit of 2^-p in the matrices changes a quotient by |x|² (1 + μ) 2^-p, where |x| is the sum
    /// of magnitudes; one of 2^-q in column j its couplings by |x_i| (‖K‖ + μ_j ‖M‖) 2^-q, an
    /// eigenvalue by the square of that over the gap, and g_ij by |x_i| |x_j| ‖M‖ 2^-q.
    pub(super) fn new(
        couplings: &Couplings,
        x: &Matrix,
        own: &[usize],
        goal: &Goal,
        (stiffness, mass): (f64, f64),
    ) -> Self {
        let m = couplings.order.len();
        let length: Vec<f64> = (0..m).map(|column| x.hi.column(column).iter().map(|x| x.abs()).sum()).collect();
        let mut is_own = vec![false; m];
        own.iter().for_each(|&j| is_own[j] = true);
        let (mut matrices, mut columns): (f64, f64) = (64.0, 64.0);
        for (position, &j) in couplings.order.iter().enumerate() {
            if !is_own[j] {
                continue;
            }
            let size = couplings.size[j];
            let target = goal.target(size).log2();
            let own_length = length[j].max(1e-300).log2();
            matrices = matrices.max(2.0 * own_length + (1.0 + size).log2() - target);
            // In its own direction the error is squared, relative to the column's length.
            columns = columns.max(0.5 * (size.max(goal.floor()).log2() - target) + 8.0);
            let strength = (stiffness + size * mass).log2();
            let mut bits = |i: usize, gap: f64| {
                if gap > goal.target(size) {
                    let coupling = length[i].max(1e-300).log2() + strength;
                    let needed = 2.0 * coupling - gap.log2() - target + (m as f64).log2();
                    // Rows of the certificate see |μ| |g_ij| beside the gap.
                    let orthogonal = (goal.largest * mass * m as f64 / gap).log2();
                    let lengths = own_length + length[i].max(1e-300).log2();
                    columns = columns.max(0.5 * needed).max(orthogonal + lengths + 4.0);
                }
            };
            let mut gap = 0.0;
            for (step, &i) in couplings.steps[position..].iter().zip(&couplings.order[position + 1..]) {
                gap += step;
                bits(i, gap);
            }
            gap = 0.0;
            for before in (0..position).rev() {
                gap += couplings.steps[before];
                bits(couplings.order[before], gap);
            }
        }
        Self { matrices: matrices.min(1e6).ceil() as i64 + 3, columns: columns.min(MOST_COLUMN_BITS).ceil() as i64 + 3 }
    }
}
