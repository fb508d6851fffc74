//! Rigorous enclosures of all eigenvalues of a nearly diagonal pencil S y = λ G y.
//!
//! The one fact used: let H be symmetric and d > 0 with |h_ii| d_i > Σ_{j≠i} |h_ij| d_j for every i
//! (diagonal dominance up to scaling). Then H has as many negative eigenvalues as negative
//! diagonal entries, for the matrices with off-diagonal entries t h_ij, 0 <= t <= 1, are dominant
//! too, hence never singular (Levy, Desplanques; Horn and Johnson, Matrix Analysis, 6.1), and
//! eigenvalues are continuous. If G is positive definite, H(σ) = S - σG has as many negative
//! eigenvalues as the pencil has eigenvalues below σ (Sylvester's law of inertia).
//!
//! So if H(σ) is shown dominant at both ends of an interval, the eigenvalues in between are
//! counted by looking at the signs of the diagonal: the pairing and the bound come at once, and
//! no eigenvalue is missed or counted twice. The scaling d makes the interval quadratically small
//! (Wilkinson's ρ²/gap; Stewart, Sun, Matrix Perturbation Theory, IV.2; for pencils Nakatsukasa,
//! "Gerschgorin's theorem for generalized eigenvalue problems", Math. Comp. 80 (2011)): for a
//! cluster C of diagonal entries take d = 1 in C and d_i = τ_i outside, where τ solves
//!
//! ```text
//!   |h_ii| τ_i >= Σ_{c∈C} |h_ic| + Σ_{j∉C} |h_ij| τ_j        (i outside C)
//! ```
//!
//! as nearly as possible, about |h_ic| / gap. Then rows in C need, with μ_a, μ_b the outermost
//! quotients of the cluster and σ = μ_a - r or μ_b + r, only
//!
//! ```text
//!   r g_cc >= |s_cc - μ_c g_cc| + Σ_{c'∈C} |h_cc'| + Σ_{i∉C} |h_ci| τ_i .
//! ```
//!
//! The same τ bounds eigenvectors: for an eigenvalue in the interval the rows outside C read
//! |h_ii| |y_i| <= Σ |h_ic| |y_c| + Σ |h_ij| |y_j|, and since the comparison matrix of the rows
//! outside is a nonsingular M-matrix (its inverse is not negative), |y_i| <= τ_i max_c |y_c|.

use super::pencil::{Pencil, rayleigh};
use crate::precision::{Ball, DoubleDouble, U2, up};

/// Neighbouring eigenvalues that the bounds do not separate, or a single one.
pub(super) struct Cluster {
    /// Positions in [`Certificate::order`], from `start` up to but not including `end`.
    pub(super) start: usize,
    pub(super) end: usize,
    /// τ by column: how far eigenvectors of the cluster may reach out to other columns.
    pub(super) reach: Vec<f64>,
}

impl Cluster {
    pub(super) fn len(&self) -> usize {
        self.end - self.start
    }
}

/// What is proved about the pencil.
pub(super) struct Certificate {
    /// The columns by rising quotient.
    pub(super) order: Vec<usize>,
    /// The eigenvalues by rising position: the k-th ball holds the k-th eigenvalue.
    pub(super) eigenvalues: Vec<Ball>,
    /// The clusters by rising position; together they hold every position once.
    pub(super) clusters: Vec<Cluster>,
}

/// What the rows of the pencil contribute to every cluster's bound.
struct Rows<'a> {
    pencil: &'a Pencil,
    quotient: Vec<DoubleDouble>,
    /// |s_ii - μ_i g_ii|
    defect: Vec<f64>,
    /// A lower bound of g_ii.
    least: Vec<f64>,
    /// Scaling in which off-diagonal sums are taken: about |μ|^(-1/2), so that graded problems
    /// are judged grade by grade.
    weight: Vec<f64>,
    /// Σ_{j≠i} |s_ij| w_j and Σ_{j≠i} |g_ij| w_j.
    s_sum: Vec<f64>,
    g_sum: Vec<f64>,
}

/// Encloses all eigenvalues. `None` if G is not shown to be within 1/2 of the unit matrix: then
/// neither is M shown to be positive definite.
pub(super) fn certify(pencil: &Pencil) -> Option<Certificate> {
    let rows = Rows::new(pencil)?;
    let m = rows.quotient.len();
    let mut order: Vec<usize> = (0..m).collect();
    order.sort_by(|&i, &j| {
        rows.quotient[i]
            .partial_cmp(&rows.quotient[j])
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let mut eigenvalues = vec![Ball::ZERO; m];
    // Accepted clusters below, ranges still to be shown above; a range that fails is joined with
    // the neighbour that it could not be told from.
    let mut clusters: Vec<Cluster> = Vec::with_capacity(m);
    let mut start = 0;
    let mut end = 1;
    while start < m {
        match rows.enclose(&order, start, end) {
            Ok((radius, reach)) => {
                for position in start..end {
                    let mid = rows.quotient[order[position]];
                    let below = (mid - rows.quotient[order[start]]).hi;
                    let above = (rows.quotient[order[end - 1]] - mid).hi;
                    eigenvalues[position] = Ball::new(mid, up(below.max(above) + radius));
                }
                clusters.push(Cluster { start, end, reach });
                start = end;
                end = start + 1;
            }
            Err(culprit) => {
                if culprit < start {
                    match clusters.pop() {
                        Some(below) => start = below.start,
                        None => return None,
                    }
                } else {
                    end = (end + 1).min(m);
                }
            }
        }
    }
    Some(Certificate {
        order,
        eigenvalues,
        clusters,
    })
}

impl<'a> Rows<'a> {
    fn new(pencil: &'a Pencil) -> Option<Self> {
        let m = pencil.s.mid.columns;
        let (mut quotient, mut defect) = (Vec::with_capacity(m), Vec::with_capacity(m));
        for i in 0..m {
            let (mu, error) = rayleigh(pencil, i);
            if !mu.is_finite() || !error.is_finite() {
                return None;
            }
            quotient.push(mu);
            defect.push(error);
        }
        let largest = quotient.iter().fold(0.0_f64, |x, mu| x.max(mu.hi.abs()));
        let floor = largest * 1e-30 + 1e-290;
        let weight: Vec<f64> = quotient
            .iter()
            .map(|mu| 1.0 / (mu.hi.abs() + floor).sqrt())
            .collect();
        let mut least = Vec::with_capacity(m);
        let (mut s_sum, mut g_sum) = (vec![0.0; m], vec![0.0; m]);
        for i in 0..m {
            // The matrices are symmetric: column i is row i.
            let (mut s, mut g, mut plain) = (0.0, 0.0, 0.0);
            let columns = pencil
                .s
                .mid
                .column_hi(i)
                .iter()
                .zip(pencil.s.radius.column(i));
            let others = pencil
                .g
                .mid
                .column_hi(i)
                .iter()
                .zip(pencil.g.radius.column(i));
            for (j, ((sij, rs), (gij, rg))) in columns.zip(others).enumerate() {
                if i != j {
                    s += (sij.abs() + rs) * weight[j];
                    let size = gij.abs() + rg;
                    g += size * weight[j];
                    plain += size;
                }
            }
            // Sums of up to m terms in doubles, and lo parts below u |hi|.
            let factor = 1.0 + 4.0 * (m as f64 + 4.0) * f64::EPSILON;
            s_sum[i] = s * factor;
            g_sum[i] = g * factor;
            let diagonal = pencil.g.ball(i, i);
            let low = diagonal.lower() * (1.0 - 1e-15);
            let close = low - plain * factor >= 0.5 && diagonal.upper() <= 1.5;
            if !close {
                return None;
            }
            least.push(low);
        }
        Some(Self {
            pencil,
            quotient,
            defect,
            least,
            weight,
            s_sum,
            g_sum,
        })
    }

    /// The radius r and the reach τ of the positions `start..end`, or the position of a
    /// row that they cannot be separated from.
    fn enclose(&self, order: &[usize], start: usize, end: usize) -> Result<(f64, Vec<f64>), usize> {
        let m = order.len();
        let size = end - start;
        let (low, high) = (self.quotient[order[start]], self.quotient[order[end - 1]]);
        let width = up((high - low).hi);
        let sigma = up(low.hi.abs().max(high.hi.abs()));
        // |h_ij(σ)| <= |s_ij - μ_a g_ij| + |σ - μ_a| |g_ij| + radii for rows c of the cluster.
        let mut h = vec![0.0; size * m];
        let mut g = vec![0.0; size * m];
        for (h, (g, &c)) in h
            .chunks_exact_mut(m)
            .zip(g.chunks_exact_mut(m).zip(&order[start..end]))
        {
            for j in 0..m {
                let (s, b) = (self.pencil.s.mid.get(j, c), self.pencil.g.mid.get(j, c));
                let (rs, rb) = (
                    self.pencil.s.radius.get(j, c),
                    self.pencil.g.radius.get(j, c),
                );
                let residual = (s - low * b).hi.abs() * (1.0 + f64::EPSILON);
                let rounding = 16.0 * U2 * (s.hi.abs() + sigma * b.hi.abs());
                h[j] = up(residual + rounding + rs + sigma * rb);
                g[j] = up(b.hi.abs() + rb);
            }
        }
        // Gaps between rows outside and the cluster.
        let gap = |position: usize| -> f64 {
            let mu = self.quotient[order[position]];
            let distance = if position < start {
                low - mu
            } else {
                mu - high
            };
            distance.hi * (1.0 - 1e-15)
        };
        let outside = || (0..start).chain(end..m);
        let mut tau = vec![0.0; m];
        let factor = 1.0 + 4.0 * (m as f64 + 8.0) * f64::EPSILON;
        let mut radius = 0.0;
        for attempt in 0..10 {
            let reach = width + radius;
            let (mut most, mut culprit): (f64, Option<(f64, usize)>) = (0.0, None);
            for position in outside() {
                let i = order[position];
                let direct: f64 = (0..size).map(|c| h[c * m + i] + reach * g[c * m + i]).sum();
                let distance = gap(position);
                let diagonal = (distance - radius) * self.least[i] * (1.0 - 1e-14) - self.defect[i];
                let rest = self.s_sum[i] + (sigma + radius) * self.g_sum[i];
                let margin = diagonal * self.weight[i] * (1.0 - 1e-14) - rest * factor;
                if margin > 0.0 {
                    most = most.max(direct * factor / margin);
                    // Kept for the next loop.
                    tau[i] = direct;
                } else if culprit.is_none_or(|(nearest, _)| distance < nearest) {
                    culprit = Some((distance, position));
                }
            }
            if let Some((_, position)) = culprit {
                return Err(position);
            }
            let most = up(most);
            for position in outside() {
                let i = order[position];
                let diagonal =
                    (gap(position) - radius) * self.least[i] * (1.0 - 1e-14) - self.defect[i];
                let rest = (self.s_sum[i] + (sigma + radius) * self.g_sum[i]) * most;
                tau[i] = up((tau[i] + rest) * factor / (diagonal * (1.0 - 1e-14)));
            }
            let mut needed: f64 = 0.0;
            for (c, &column) in order[start..end].iter().enumerate() {
                let mut sum = self.defect[column];
                for position in outside() {
                    let i = order[position];
                    sum += (h[c * m + i] + reach * g[c * m + i]) * tau[i];
                }
                for (other, &i) in order[start..end].iter().enumerate() {
                    if other != c {
                        sum += h[c * m + i] + reach * g[c * m + i];
                    }
                }
                needed = needed.max(sum * factor / self.least[column]);
            }
            // With a smaller radius every condition is easier: the needed one will do.
            let needed = if needed == 0.0 {
                0.0
            } else {
                up(needed * (1.0 + 1e-12))
            };
            if attempt > 0 && needed <= radius || needed == 0.0 {
                return Ok((needed, tau));
            }
            radius = 2.0 * needed;
        }
        // The radius runs away: join the nearest.
        outside()
            .min_by(|&p, &q| {
                gap(p)
                    .partial_cmp(&gap(q))
                    .unwrap_or(std::cmp::Ordering::Equal)
            })
            .map_or(Ok((f64::INFINITY, tau)), Err)
    }
}
